//! Cycles and vibration lost to roughness against damping.

use asperity_results::VibrationResult;

use crate::axis::{Axis, range};
use crate::canvas::{Dash, Pen};
use crate::chart::{Chart, Layout, Mark, figure, stacked};
use crate::figures::{Plate, Stage, columns, csv};
use crate::format::{Unit, significant};
use crate::palette::{BLACK, BLUE, GREY, VERMILION};
use crate::{ReportError, Run, Table};

const NAME: &str = "cycles_over_damping";

/// Upscalings: their prefix in tables, name, colour and dash.
const UPSCALINGS: [(&str, &str, plotters::prelude::RGBColor, Dash); 2] =
    [("area", "upscaling “area”", BLUE, Dash::Long), ("paper", "upscaling “paper”", VERMILION, Dash::Dashed)];

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let Some(table) = run.tables.get(NAME) else { return Ok(()) };
    let Some([damping]) = columns(table, ["damping_ratio"]) else { return Ok(()) };
    let Some(sweep) = Sweep::new(table, damping, run.results.vibration.as_ref()) else { return Ok(()) };
    cycles(&sweep, plates)?;
    lost(&sweep, duration(run), plates)
}

/// Length τ of the trajectories.
fn duration(run: &Run) -> Option<f64> {
    let input = run.inputs.iter().find(|input| input.section == "vibration" && input.key == "duration")?;
    input.value.trim().parse().ok()
}

/// What was counted at several damping ratios, and the limits of the deterministic motion.
struct Sweep<'a> {
    table: &'a Table,
    damping: &'a [f64],
    limits: Vec<(f64, String, Pen)>,
    ends: (f64, f64),
}

impl<'a> Sweep<'a> {
    fn new(table: &'a Table, damping: &'a [f64], vibration: Option<&VibrationResult>) -> Option<Self> {
        let limits = [
            (vibration.and_then(|v| v.hopf_damping_ratio), "Hopf point ζ", Pen::new(GREY, 1.6, Dash::Dotted)),
            (
                vibration.and_then(|v| v.critical_damping_ratio),
                "cycle ends at ζ",
                Pen::new(BLACK, 1.6, Dash::Alternating),
            ),
        ];
        let limits: Vec<(f64, String, Pen)> = limits
            .iter()
            .filter_map(|(value, label, pen)| {
                let value = (*value)?;
                Some((value, format!("{label} = {}", significant(value, 5)), *pen))
            })
            .collect();
        let (mut low, mut high) = range(damping)?;
        for (value, _, _) in &limits {
            // A limit far outside the sweep must not compress it.
            let reach = 0.35 * (high - low);
            if *value > low - reach && *value < high + reach {
                (low, high) = (low.min(*value), high.max(*value));
            }
        }
        Some(Self { table, damping, limits, ends: (low, high) })
    }

    fn axis(&self) -> Axis {
        Axis::padded("Damping ratio ζ", Unit::none(), self.ends, 0.03)
    }

    fn column(&self, prefix: &str, column: &str) -> Option<Vec<f64>> {
        self.table.column(&format!("{prefix}_{column}")).map(<[f64]>::to_vec)
    }

    /// Band and curve of an upscaling.
    fn add(
        &self,
        chart: &mut Chart,
        (_, name, colour, dash): (&str, &'static str, plotters::prelude::RGBColor, Dash),
        mean: Option<Vec<f64>>,
        band: Option<(Vec<f64>, Vec<f64>)>,
    ) {
        if let Some((low, high)) = band {
            chart.add(None, Mark::Band { x: self.damping.to_vec(), low, high, colour });
        }
        if let Some(y) = mean {
            chart.add(name, Mark::Points { x: self.damping.to_vec(), y, pen: Pen::new(colour, 1.8, dash) });
        }
    }

    /// The charts one above the other, with the limits in each.
    fn stacked(&self, mut charts: Vec<Chart>) -> Vec<(f64, Chart)> {
        for chart in &mut charts {
            for (value, label, pen) in self.limits.iter().filter(|l| (self.ends.0..=self.ends.1).contains(&l.0)) {
                chart.add_named(label.clone(), Mark::Vertical { x: *value, pen: *pen });
            }
        }
        stacked(charts, 230.0)
    }
}

/// The number of cycles, and what it is less than without roughness.
fn cycles(sweep: &Sweep<'_>, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let counts = [
        ("cycles_deterministic", "deterministic", Pen::new(BLACK, 1.8, Dash::Solid)),
        ("area_cycles_mean", "upscaling “area”", Pen::new(BLUE, 1.8, Dash::Long)),
        ("paper_cycles_mean", "upscaling “paper”", Pen::new(VERMILION, 1.8, Dash::Dashed)),
    ];
    let mut charts = Vec::new();
    if let Some(y) = range(counts.iter().filter_map(|c| sweep.table.column(c.0)).flatten()) {
        let mut chart = Chart::new(sweep.axis(), Axis::padded("Cycles M", Unit::none(), (y.0.min(0.0), y.1), 0.08));
        for (name, label, pen) in counts {
            if let Some(y) = sweep.table.column(name) {
                chart.add(label, Mark::Points { x: sweep.damping.to_vec(), y: y.to_vec(), pen });
            }
        }
        charts.push(chart);
    }
    let named = |prefix: &str, column: &str| sweep.column(prefix, &format!("difference_{column}"));
    let values = UPSCALINGS.iter().flat_map(|d| ["mean", "low", "high"].map(|c| named(d.0, c))).flatten().flatten();
    if let Some(y) = range(&values.collect::<Vec<_>>()) {
        let y = Axis::padded("M(det) − mean M", Unit::none(), (y.0.min(0.0), y.1.max(0.0)), 0.08);
        let mut chart = Chart::new(sweep.axis(), y);
        chart.add(None, Mark::Horizontal { y: 0.0, pen: Pen::new(GREY, 1.2, Dash::Solid) });
        for upscaling in UPSCALINGS {
            let band = named(upscaling.0, "low").zip(named(upscaling.0, "high"));
            sweep.add(&mut chart, upscaling, named(upscaling.0, "mean"), band);
        }
        charts.push(chart);
    }
    let caption = "Number of stick-slip cycles M, and its difference from the deterministic count (the paper’s Fig. 5c) \
                   with 95 % intervals. “Area” averages μ over the nominal contact area and is the reading to use; \
                   “paper” lets one window carry the whole normal force.";
    push(sweep, NAME, "Cycles lost to roughness against damping", caption, charts, plates)
}

/// The share of the trajectories that sustain vibration, and the rate of cycles.
fn lost(sweep: &Sweep<'_>, duration: Option<f64>, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    let mut charts = Vec::new();
    let share = |prefix: &str, end: &str| sweep.column(prefix, &format!("sustained_share{end}"));
    if UPSCALINGS.iter().any(|upscaling| share(upscaling.0, "").is_some()) {
        let y = Axis::linear("Sustained vibration, share", Unit::none(), (-0.04, 1.04));
        let mut chart = Chart::new(sweep.axis(), y);
        for upscaling in UPSCALINGS {
            let band = share(upscaling.0, "_low").zip(share(upscaling.0, "_high"));
            sweep.add(&mut chart, upscaling, share(upscaling.0, ""), band);
        }
        charts.push(chart);
    }
    charts.extend(duration.and_then(|duration| rate(sweep, duration)));
    let caption = "Above: share of the trajectories that vibrate for at least half of the second half of their time. Below: \
                   cycles per natural period 2π/ω₀, over the whole time. Bands are 95 % intervals.";
    push(sweep, "sustained_over_damping", "Vibration against damping", caption, charts, plates)
}

/// Cycles per natural period.
fn rate(sweep: &Sweep<'_>, duration: f64) -> Option<Chart> {
    let per = |count: f64| count * std::f64::consts::TAU / duration;
    let deterministic = sweep.table.column("cycles_deterministic")?;
    let less = |difference: Vec<f64>| -> Vec<f64> {
        deterministic.iter().zip(&difference).map(|(count, difference)| per(count - difference)).collect()
    };
    let scaled = |counts: &[f64]| counts.iter().map(|count| per(*count)).collect::<Vec<f64>>();
    let means = UPSCALINGS.map(|upscaling| sweep.column(upscaling.0, "cycles_mean").map(|counts| scaled(&counts)));
    let without = scaled(deterministic);
    let top = without.iter().chain(means.iter().flatten().flatten()).copied().filter(|v| v.is_finite());
    let top = top.fold(0.0, f64::max);
    if !(top > 0.0 && top.is_finite()) {
        return None;
    }
    let mut chart =
        Chart::new(sweep.axis(), Axis::linear("Cycles per period 2π", Unit::none(), (-0.03 * top, 1.06 * top)));
    let pen = Pen::new(BLACK, 1.8, Dash::Solid);
    chart.add("deterministic", Mark::Points { x: sweep.damping.to_vec(), y: without, pen });
    for (upscaling, mean) in UPSCALINGS.into_iter().zip(means) {
        let end = |end: &str| sweep.column(upscaling.0, &format!("difference_{end}")).map(less);
        sweep.add(&mut chart, upscaling, mean, end("high").zip(end("low")));
    }
    Some(chart)
}

fn push(
    sweep: &Sweep<'_>,
    name: &'static str,
    title: &str,
    caption: &str,
    charts: Vec<Chart>,
    plates: &mut Vec<Plate>,
) -> Result<(), ReportError> {
    if charts.is_empty() {
        return Ok(());
    }
    let svg = figure(title, caption, Layout::Column, &sweep.stacked(charts))?;
    let (title, caption, sources) = (title.to_owned(), caption.to_owned(), vec![csv(NAME)]);
    plates.push(Plate { name, stage: Stage::Vibration, title, caption, sources, svg });
    Ok(())
}
