//! Cycles and vibration lost to roughness over damping.

use asperity_results::{DampingResult, VibrationResult};

use crate::Run;
use crate::figures::CaptionedFigure;
use crate::format::{Unit, significant};
use crate::plot::{Axis, BLACK, BLUE, Chart, Colour, Dash, GREY, Pen, VERMILION, range, stacked};

const NAME: &str = "cycles_over_damping";

/// Smallest jump across a limit, as a fraction of the range of a quantity, through which no line is drawn.
const JUMP: f64 = 0.3;

/// Smallest change between neighbours, as a fraction of the range, through which no line is drawn elsewhere.
const UNRESOLVED: f64 = 0.6;

/// Name, colour and dash of an upscaling.
type Style = (&'static str, Colour, Dash);

const AREA: Style = ("upscaling “area”", BLUE, Dash::Long);
const PAPER: Style = ("upscaling “paper”", VERMILION, Dash::Dashed);

pub(super) fn figures(run: &Run) -> Vec<CaptionedFigure> {
    let Some(sweep) = run.results.vibration.as_ref().and_then(Sweep::new) else { return Vec::new() };
    let lost = "Number of stick-slip cycles M, and its difference from the deterministic count (the paper’s Fig. 5c) with 95 % \
                intervals. “Area” averages μ over the nominal contact area and is the reading to use; “paper” lets one window carry \
                the whole normal force.";
    let sustained = "Above: fraction of the trajectories that sustain vibration, which here means to vibrate for at least half of the second half of their time; the \
                     verdict counts machines that vibrate for more than 10 % of the time. Below: cycles \
                     per natural period 2π/ω₀, over the whole time. Bands are 95 % intervals. No line is \
                     drawn across a jump.";
    let counts = [Some(sweep.cycles()), Some(sweep.differences())];
    let vibration = [Some(sweep.sustained()), duration(run).and_then(|duration| sweep.rate(duration))];
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
    upscalings: [(Style, &'a [DampingResult]); 2],
    limits: Vec<(f64, String, Pen)>,
    ends: (f64, f64),
}

/// Reads a number of one damping ratio.
type Number = fn(&DampingResult) -> f64;

/// Reads the ends of an interval at one damping ratio.
type Ends<'a> = [&'a dyn Fn(&DampingResult) -> f64; 2];

fn column(entries: &[DampingResult], of: impl Fn(&DampingResult) -> f64) -> Vec<f64> {
    entries.iter().map(of).collect()
}

fn deterministic(entry: &DampingResult) -> f64 {
    entry.cycles_deterministic as f64
}

impl<'a> Sweep<'a> {
    fn new(vibration: &'a VibrationResult) -> Option<Self> {
        let upscalings = [(AREA, &vibration.area.damping[..]), (PAPER, &vibration.paper.damping[..])];
        let (hopf, critical) = (vibration.hopf_damping_ratio, vibration.critical_damping_ratio);
        let limits = [
            (hopf, "Hopf point ζ", Pen::new(GREY, 1.6, Dash::Dotted)),
            (critical, "cycle ends at ζ", Pen::new(BLACK, 1.6, Dash::Alternating)),
        ];
        let limits = limits.into_iter().filter_map(|(value, label, pen)| {
            let value = value?;
            Some((value, format!("{label} = {}", significant(value, 4)), pen))
        });
        let limits: Vec<_> = limits.collect();
        let (mut low, mut high) = range(&column(upscalings[0].1, |entry| entry.damping_ratio))?;
        for (value, _, _) in &limits {
            // A limit far outside the sweep must not compress it.
            let reach = 0.35 * (high - low);
            if *value > low - reach && *value < high + reach {
                (low, high) = (low.min(*value), high.max(*value));
            }
        }
        Some(Self { upscalings, limits, ends: (low, high) })
    }

    fn chart(&self, y: Axis) -> Chart {
        Chart::new(Axis::padded("Damping ratio ζ", Unit::none(), self.ends, 0.03), y)
    }

    /// Draws the curve of each upscaling, with its band if there is one.
    fn draw(&self, chart: &mut Chart, of: impl Fn(&DampingResult) -> f64, band: Option<Ends<'_>>) {
        for ((name, colour, dash), entries) in self.upscalings {
            let x = self.interrupted(entries, &of, |entry| entry.damping_ratio);
            if let Some([low, high]) = band {
                let ends = [low, high].map(|end| self.interrupted(entries, &of, end));
                chart.band("", &x, ends.each_ref().map(Vec::as_slice), colour);
            }
            chart.points(name, &x, &self.interrupted(entries, &of, &of), Pen::new(colour, 1.8, dash));
        }
    }

    /// Returns numbers of the entries, with an undefined one wherever the quantity `of` jumps: across a limit between the damping ratios,
    /// or by so much that the sweep does not resolve it.
    fn interrupted(
        &self,
        entries: &[DampingResult],
        of: impl Fn(&DampingResult) -> f64,
        number: impl Fn(&DampingResult) -> f64,
    ) -> Vec<f64> {
        let span = range(&column(entries, &of)).map_or(0.0, |(low, high)| high - low);
        let mut numbers: Vec<f64> = entries.first().map(&number).into_iter().collect();
        for pair in entries.windows(2) {
            let [before, after] = pair else { continue };
            let between = before.damping_ratio..=after.damping_ratio;
            let change = (of(after) - of(before)).abs();
            let has_limit = self.limits.iter().any(|(limit, _, _)| between.contains(limit));
            let is_jump = span > 0.0 && change > span * if has_limit { JUMP } else { UNRESOLVED };
            numbers.extend(is_jump.then_some(f64::NAN));
            numbers.push(number(after));
        }
        numbers
    }

    /// Returns the range of some numbers of both upscalings.
    fn range(&self, numbers: &[Number]) -> (f64, f64) {
        let entries = || self.upscalings.iter().flat_map(|(_, entries)| *entries);
        let values: Vec<f64> = numbers.iter().flat_map(|of| entries().map(of)).collect();
        range(&values).unwrap_or_default()
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
    fn cycles(&self) -> Chart {
        let (low, high) = self.range(&[deterministic, |entry| entry.cycles_mean]);
        let mut chart = self.chart(Axis::padded("Cycles M", Unit::none(), (low.min(0.0), high), 0.08));
        self.draw_deterministic(&mut chart, deterministic);
        self.draw(&mut chart, |entry| entry.cycles_mean, None);
        chart
    }

    fn draw_deterministic(&self, chart: &mut Chart, of: impl Fn(&DampingResult) -> f64) {
        let [(_, entries), _] = self.upscalings;
        let x = self.interrupted(entries, &of, |entry| entry.damping_ratio);
        chart.points("deterministic", &x, &self.interrupted(entries, &of, &of), Pen::new(BLACK, 1.8, Dash::Solid));
    }

    /// Draws the difference from the number of cycles without roughness.
    fn differences(&self) -> Chart {
        let ends: [Number; 2] = [|entry| entry.difference_interval[0], |entry| entry.difference_interval[1]];
        let (low, high) = self.range(&[|entry| entry.difference_mean, ends[0], ends[1]]);
        let y = Axis::padded("M(det) − mean M", Unit::none(), (low.min(0.0), high.max(0.0)), 0.08);
        let mut chart = self.chart(y);
        chart.horizontal("", 0.0, Pen::new(GREY, 1.2, Dash::Solid));
        self.draw(&mut chart, |entry| entry.difference_mean, Some([&ends[0], &ends[1]]));
        chart
    }

    /// Draws the fraction of the trajectories that sustain vibration.
    fn sustained(&self) -> Chart {
        let mut chart = self.chart(Axis::linear("Sustained vibration, fraction", Unit::none(), (-0.04, 1.04)));
        let ends: [Number; 2] = [|entry| entry.sustained_share_interval[0], |entry| entry.sustained_share_interval[1]];
        self.draw(&mut chart, |entry| entry.sustained_share, Some([&ends[0], &ends[1]]));
        chart
    }

    /// Draws the number of cycles per natural period.
    fn rate(&self, duration: f64) -> Option<Chart> {
        let scaled = |count: f64| count * std::f64::consts::TAU / duration;
        let (_, most) = self.range(&[deterministic, |entry| entry.cycles_mean]);
        let top = Some(scaled(most)).filter(|top| *top > 0.0)?;
        let mut chart = self.chart(Axis::linear("Cycles per period 2π", Unit::none(), (-0.03 * top, 1.06 * top)));
        self.draw_deterministic(&mut chart, |entry| scaled(deterministic(entry)));
        let less = |entry: &DampingResult, end: usize| scaled(deterministic(entry) - entry.difference_interval[end]);
        self.draw(
            &mut chart,
            |entry| scaled(entry.cycles_mean),
            Some([&|entry| less(entry, 1), &|entry| less(entry, 0)]),
        );
        Some(chart)
    }
}
