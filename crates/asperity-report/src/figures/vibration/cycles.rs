//! Cycles and vibration lost to roughness over damping.

use asperity_results::{Table, VibrationResult};

use crate::Run;
use crate::figures::{CaptionedFigure, columns};
use crate::format::{Unit, significant};
use crate::plot::{Axis, BLACK, BLUE, Chart, Colour, Dash, GREY, Pen, VERMILION, range, stacked};

const NAME: &str = "cycles_over_damping";

/// An upscaling: prefix in tables, name, colour and dash.
type Upscaling = (&'static str, &'static str, Colour, Dash);

const UPSCALINGS: [Upscaling; 2] =
    [("area", "upscaling “area”", BLUE, Dash::Long), ("paper", "upscaling “paper”", VERMILION, Dash::Dashed)];

pub(super) fn figures(run: &Run) -> Vec<CaptionedFigure> {
    let Some(sweep) = run.tables.get(NAME).and_then(|table| Sweep::new(table, run.results.vibration.as_ref())) else {
        return Vec::new();
    };
    let lost = "Number of stick-slip cycles M, and its difference from the deterministic count (the paper’s Fig. 5c) with 95 % \
                intervals. “Area” averages μ over the nominal contact area and is the reading to use; “paper” lets one window carry \
                the whole normal force.";
    let sustained = "Above: fraction of the trajectories that vibrate for at least half of the second half of their time. Below: cycles \
                     per natural period 2π/ω₀, over the whole time. Bands are 95 % intervals.";
    let counts = [sweep.cycles(), sweep.differences()];
    let vibration = [sweep.sustained(), duration(run).and_then(|duration| sweep.rate(duration))];
    let drawn = [
        (NAME, "Cycles lost to roughness over damping", lost, counts),
        ("sustained_over_damping", "Vibration over damping", sustained, vibration),
    ];
    let drawn = drawn.into_iter().filter_map(|(name, title, caption, charts)| {
        let charts = sweep.stacked(charts.into_iter().flatten().collect());
        CaptionedFigure::from_charts(name, title, caption, 1, &charts, &[NAME])
    });
    drawn.collect()
}

/// Returns the length τ of the trajectories.
fn duration(run: &Run) -> Option<f64> {
    let input = run.inputs.iter().find(|input| input.section == "vibration" && input.key == "duration")?;
    input.value.trim().parse().ok()
}

/// Counts at several damping ratios, and the limits of the deterministic motion.
struct Sweep<'a> {
    table: &'a Table,
    damping: &'a [f64],
    limits: Vec<(f64, String, Pen)>,
    ends: (f64, f64),
}

impl<'a> Sweep<'a> {
    fn new(table: &'a Table, vibration: Option<&VibrationResult>) -> Option<Self> {
        let [damping] = columns(table, ["damping_ratio"])?;
        let hopf = vibration.and_then(|vibration| vibration.hopf_damping_ratio);
        let critical = vibration.and_then(|vibration| vibration.critical_damping_ratio);
        let limits = [
            (hopf, "Hopf point ζ", Pen::new(GREY, 1.6, Dash::Dotted)),
            (critical, "cycle ends at ζ", Pen::new(BLACK, 1.6, Dash::Alternating)),
        ];
        let limits = limits.into_iter().filter_map(|(value, label, pen)| {
            let value = value?;
            Some((value, format!("{label} = {}", significant(value, 4)), pen))
        });
        let limits: Vec<_> = limits.collect();
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

    fn chart(&self, y: Axis) -> Chart {
        Chart::new(Axis::padded("Damping ratio ζ", Unit::none(), self.ends, 0.03), y)
    }

    fn column(&self, (prefix, ..): Upscaling, column: &str) -> Option<&[f64]> {
        self.table.defined_column(&format!("{prefix}_{column}"))
    }

    /// Draws band and curve of an upscaling.
    fn draw(&self, chart: &mut Chart, upscaling: Upscaling, mean: Option<&[f64]>, band: Option<(&[f64], &[f64])>) {
        let (_, name, colour, dash) = upscaling;
        if let Some((low, high)) = band {
            chart.band("", self.damping, [low, high], colour);
        }
        if let Some(mean) = mean {
            chart.points(name, self.damping, mean, Pen::new(colour, 1.8, dash));
        }
    }

    /// Arranges charts one above the other, with the limits in each.
    fn stacked(&self, mut charts: Vec<Chart>) -> Vec<Chart> {
        for chart in &mut charts {
            for (value, label, pen) in self.limits.iter().filter(|l| (self.ends.0..=self.ends.1).contains(&l.0)) {
                chart.vertical(label, *value, *pen);
            }
        }
        stacked(charts, 230.0)
    }

    /// Draws the number of cycles.
    fn cycles(&self) -> Option<Chart> {
        let means = UPSCALINGS.map(|upscaling| self.column(upscaling, "cycles_mean"));
        let deterministic = self.table.defined_column("cycles_deterministic");
        let y = range(means.iter().chain([&deterministic]).copied().flatten().flatten())?;
        let mut chart = self.chart(Axis::padded("Cycles M", Unit::none(), (y.0.min(0.0), y.1), 0.08));
        if let Some(counts) = deterministic {
            chart.points("deterministic", self.damping, counts, Pen::new(BLACK, 1.8, Dash::Solid));
        }
        UPSCALINGS.into_iter().zip(means).for_each(|(upscaling, mean)| self.draw(&mut chart, upscaling, mean, None));
        Some(chart)
    }

    /// Draws the difference from the number of cycles without roughness.
    fn differences(&self) -> Option<Chart> {
        let of = |upscaling, end: &str| self.column(upscaling, &format!("difference_{end}"));
        let all = UPSCALINGS.iter().flat_map(|upscaling| ["mean", "low", "high"].map(|end| of(*upscaling, end)));
        let y = range(all.flatten().flatten())?;
        let y = Axis::padded("M(det) − mean M", Unit::none(), (y.0.min(0.0), y.1.max(0.0)), 0.08);
        let mut chart = self.chart(y);
        chart.horizontal("", 0.0, Pen::new(GREY, 1.2, Dash::Solid));
        for upscaling in UPSCALINGS {
            let band = of(upscaling, "low").zip(of(upscaling, "high"));
            self.draw(&mut chart, upscaling, of(upscaling, "mean"), band);
        }
        Some(chart)
    }

    /// Draws the fraction of the trajectories that sustain vibration.
    fn sustained(&self) -> Option<Chart> {
        let of = |upscaling, end: &str| self.column(upscaling, &format!("sustained_share{end}"));
        UPSCALINGS.iter().find_map(|upscaling| of(*upscaling, ""))?;
        let mut chart = self.chart(Axis::linear("Sustained vibration, fraction", Unit::none(), (-0.04, 1.04)));
        for upscaling in UPSCALINGS {
            self.draw(&mut chart, upscaling, of(upscaling, ""), of(upscaling, "_low").zip(of(upscaling, "_high")));
        }
        Some(chart)
    }

    /// Draws the number of cycles per natural period.
    fn rate(&self, duration: f64) -> Option<Chart> {
        let deterministic = self.table.defined_column("cycles_deterministic")?;
        let scaled =
            |counts: &[f64]| counts.iter().map(|count| count * std::f64::consts::TAU / duration).collect::<Vec<f64>>();
        let less = |difference: &[f64]| {
            let counts: Vec<f64> = deterministic.iter().zip(difference).map(|(count, less)| count - less).collect();
            scaled(&counts)
        };
        let means = UPSCALINGS.map(|upscaling| self.column(upscaling, "cycles_mean").map(scaled));
        let without = scaled(deterministic);
        let (_, top) = range(without.iter().chain(means.iter().flatten().flatten())).filter(|(_, top)| *top > 0.0)?;
        let mut chart = self.chart(Axis::linear("Cycles per period 2π", Unit::none(), (-0.03 * top, 1.06 * top)));
        chart.points("deterministic", self.damping, &without, Pen::new(BLACK, 1.8, Dash::Solid));
        for (upscaling, mean) in UPSCALINGS.into_iter().zip(means) {
            let end = |end: &str| self.column(upscaling, &format!("difference_{end}")).map(less);
            let band = end("high").zip(end("low"));
            let band = band.as_ref().map(|(low, high)| (low.as_slice(), high.as_slice()));
            self.draw(&mut chart, upscaling, mean.as_deref(), band);
        }
        Some(chart)
    }
}
