//! The margin as a picture: the limit of the damping ratio over the uncertain values, and the damping ratio of the machine.

use asperity_results::keys::{DAMPING_RATIO, STATIC_FRICTION};
use asperity_results::{InputKind, MachineModel, Quantiles, Reach, RestsOn, VerdictResult};

use crate::Run;
use crate::cells::shown;
use crate::format::{Dimension, Unit, count, significant};
use crate::markup::{Html, html};
use crate::plot::Axis;
use crate::verdict::{is_exact, percent, sampled_percent};
use crate::words::{between, unbroken};

/// Table of the sampled machines.
const SAMPLES: &str = "verdict_samples";
/// Columns of the margin and of the friction coefficient.
const MARGIN: &str = "damping_margin";
const FRICTION: &str = "friction_coefficient";
/// Number of values that represent the quantiles of the margin if there are no samples.
const VALUES: usize = 2000;
/// Number of cells over the drawn range.
const CELLS: f64 = 44.0;
/// Fraction of the machines at either end that are drawn in the outermost cell.
const TAIL: f64 = 0.002;
/// Standard errors by which the fraction of negative margins may differ from the probability.
const STANDARD_ERRORS: f64 = 4.0;
/// Size of the picture, and the range of the drawing in it.
const WIDTH: f64 = 600.0;
const HEIGHT: f64 = 206.0;
const LEFT: f64 = 16.0;
const RIGHT: f64 = 584.0;
const TOP: f64 = 62.0;
const BASE: f64 = 154.0;
/// Width of a bold character, on a phone.
const CHARACTER: f64 = 13.0;
/// Rows of the texts above the drawing.
const UPPER: f64 = 22.0;
const LOWER: f64 = 50.0;
/// Row of the text of a remedy, in the drawing.
const INSIDE: f64 = 84.0;

/// Limits of the damping ratio, moved such that a machine vibrates if its limit exceeds the central damping ratio: ζ_c − M for the
/// central damping ratio ζ_c and the margin M.
pub(super) struct Limits {
    /// Central damping ratio ζ_c.
    central: f64,
    /// Limits in ascending order; empty without samples and quantiles.
    sorted: Vec<f64>,
    /// Limit that separates quiet machines from those that vibrate.
    split: f64,
    /// Number of sampled machines; 0 if the limits represent quantiles.
    samples: usize,
    /// Whether the damping ratio itself is uncertain.
    uncertain_damping: bool,
    /// Whether the machine has two coupled modes: the margin μ_c − μ is one of friction. The central critical coefficient μ_c takes the
    /// place of the central damping ratio.
    coupled: bool,
}

/// Part of the range of limits with the fraction of the machines in it.
struct Cell {
    low: f64,
    high: f64,
    fraction: f64,
}

impl Limits {
    pub(super) fn new(run: &Run, verdict: &VerdictResult) -> Self {
        let coupled = verdict.model == MachineModel::ModeCoupling;
        let central = match &run.results.mode_coupling {
            Some(result) if coupled => result.friction + verdict.nominal.damping_margin,
            _ => verdict.nominal.limit_damping_ratio.unwrap_or(0.0) + verdict.nominal.damping_margin,
        };
        let table = run.tables.get(SAMPLES);
        let sampled = table.and_then(|table| table.defined_column(MARGIN));
        let sampled: Option<Vec<f64>> =
            sampled.map(|column| column.iter().copied().filter(|m| m.is_finite()).collect());
        let samples = sampled.as_ref().map_or(0, Vec::len);
        let margins = sampled.unwrap_or_else(|| from_quantiles(verdict));
        let mut sorted: Vec<f64> = margins.iter().map(|margin| central - margin).collect();
        sorted.sort_by(f64::total_cmp);
        let uncertain_damping = match table {
            Some(table) => table.defined_column(DAMPING_RATIO).is_some(),
            None => verdict.drivers.iter().any(|driver| driver.input == DAMPING_RATIO),
        };
        let mut limits = Self { central, sorted, split: central, samples, uncertain_damping, coupled };
        let n = limits.sorted.len();
        if n > 0 && !limits.agrees_with(verdict) {
            // As many limits exceed the split as machines vibrate.
            let quiet = ((1.0 - verdict.probability) * n as f64).round() as usize;
            limits.split = match quiet {
                0 => limits.sorted[0],
                quiet if quiet == n => limits.sorted[n - 1],
                quiet => 0.5 * (limits.sorted[quiet - 1] + limits.sorted[quiet]),
            };
        }
        limits
    }

    /// Returns the title of the picture: the value of the machine and its limit, each with the range that holds 90 % of the machines.
    pub(super) fn title(&self, run: &Run, verdict: &VerdictResult) -> String {
        let table = run.tables.get(SAMPLES).filter(|_| !is_exact(verdict));
        let column = |name: &str| table.and_then(|table| table.defined_column(name));
        let limit = self.central - if self.coupled { 0.0 } else { verdict.nominal.damping_margin };
        let value = self.central - if self.coupled { verdict.nominal.damping_margin } else { 0.0 };
        let values = column(if self.coupled { FRICTION } else { DAMPING_RATIO });
        let sign = if self.coupled { 1.0 } else { -1.0 };
        let limits = column(MARGIN).map(|margins| {
            let of = |(place, margin): (usize, &f64)| values.map_or(value, |values| values[place]) + sign * margin;
            margins.iter().enumerate().map(of).collect()
        });
        // Of an exact machine the friction coefficient, or the limit, has the error of the computation.
        let interval =
            verdict.nominal.damping_margin_interval.map(|[low, high]| [self.central - high, self.central - low]);
        let [of_value, of_limit] = if self.coupled { [interval, None] } else { [None, interval] };
        let [value, limit] = [(values.map(<[f64]>::to_vec), value, of_value), (limits, limit, of_limit)].map(
            |(machines, central, interval)| match machines.and_then(spread) {
                Some(spread) => spread,
                None if interval.is_some() => shown(Dimension::None, central, interval),
                None => significant(central, 3),
            },
        );
        let constant = if verdict.friction_fluctuates { " without fluctuation" } else { "" };
        let name = if self.coupled { "Friction coefficient" } else { "Damping ratio" };
        format!("{name}: {} {value}, limit{constant} {limit}", self.owner(verdict))
    }

    /// Returns whose value the picture marks: the user's, or that of the example.
    fn owner(&self, verdict: &VerdictResult) -> &'static str {
        let input = if self.coupled { STATIC_FRICTION } else { DAMPING_RATIO };
        let is_example = |own: &RestsOn| own.input == input && own.kind == InputKind::Example;
        if verdict.rests_on.iter().any(is_example) { "example" } else { "yours" }
    }

    /// Returns whether the sign of the margin decides if a machine vibrates; with fluctuating friction it may not.
    fn sign_decides(&self) -> bool {
        self.split == self.central
    }

    /// Returns whether the fraction of limits above the damping ratio is the probability, within the errors of both.
    fn agrees_with(&self, verdict: &VerdictResult) -> bool {
        let (n, p) = (self.sorted.len() as f64, verdict.probability);
        let fraction = self.sorted.iter().filter(|limit| **limit > self.central).count() as f64 / n;
        let [low, high] = verdict.probability_interval;
        // Quantiles are joined by straight lines, whose error exceeds the one of samples.
        let coarse = if self.samples == 0 { 0.05 } else { 0.0 };
        let variance = (p * (1.0 - p)).max(1.0 / n);
        (fraction - p).abs() <= STANDARD_ERRORS * (variance / n).sqrt() + 0.5 * (high - low) + coarse
    }

    /// Returns the range of the picture: of all limits but the tails, with the damping ratio and the split.
    fn range(&self) -> (f64, f64) {
        let last = self.sorted.len() - 1;
        let tail = (TAIL * last as f64).round() as usize;
        let low = self.sorted[tail].min(self.central).min(self.split);
        let high = self.sorted[last - tail].max(self.central).max(self.split);
        let margin = if high > low { 0.02 * (high - low) } else { 0.1 * high.abs().max(1e-6) };
        (low - margin, high + margin)
    }

    /// Returns the cells on both sides of the split: quiet machines, whose fractions sum to 1 − P, and machines that vibrate.
    fn cells(&self, probability: f64, (low, high): (f64, f64)) -> [Vec<Cell>; 2] {
        let width = (high - low) / CELLS;
        let side = |low: f64, high: f64, limits: &[f64], total: f64| {
            let count = ((high - low) / width).ceil().max(1.0) as usize;
            let edge = |place: usize| low + (high - low) * place as f64 / count as f64;
            let mut cells: Vec<Cell> =
                (0..count).map(|place| Cell { low: edge(place), high: edge(place + 1), fraction: 0.0 }).collect();
            for limit in limits {
                let place = ((limit - low) / (high - low) * count as f64).clamp(0.0, count as f64 - 1.0);
                cells[place as usize].fraction += total / limits.len() as f64;
            }
            cells
        };
        let first = self.sorted.partition_point(|limit| *limit <= self.split);
        let (quiet, vibrating) = self.sorted.split_at(first);
        [side(low, self.split, quiet, 1.0 - probability), side(self.split, high, vibrating, probability)]
    }

    /// Draws the picture with its caption.
    pub(super) fn picture(&self, verdict: &VerdictResult) -> Html {
        if is_exact(verdict) || self.sorted.is_empty() {
            return self.marks(verdict);
        }
        let range = self.range();
        let drawn = if self.coupled { "friction coefficient" } else { "damping ratio needed to stay quiet" };
        let axis = Axis::linear(drawn, Unit::none(), range);
        let [quiet, vibrating] = self.cells(verdict.probability, range);
        let density = |cell: &Cell| cell.fraction / (cell.high - cell.low);
        let highest = quiet.iter().chain(&vibrating).map(density).fold(0.0, f64::max);
        let x = |limit: f64| LEFT + (RIGHT - LEFT) * (limit - range.0) / (range.1 - range.0);
        let outline = |cells: &[Cell]| {
            let y = |cell: &Cell| BASE - (BASE - TOP) * density(cell) / highest;
            let steps =
                cells.iter().map(|cell| format!("L{0:.2} {2:.2}L{1:.2} {2:.2}", x(cell.low), x(cell.high), y(cell)));
            let ends = (cells.first().map_or(LEFT, |cell| x(cell.low)), cells.last().map_or(LEFT, |cell| x(cell.high)));
            format!("M{:.2} {BASE}{}L{:.2} {BASE}Z", ends.0, steps.collect::<String>(), ends.1)
        };
        let (share, [low, high]) = (verdict.probability, verdict.probability_interval);
        let shares = [(1.0 - share, [1.0 - high, 1.0 - low]), (share, [low, high])]
            .map(|(share, interval)| unbroken(&sampled_percent(share, interval)));
        let marked = if self.coupled { "critical coefficient" } else { "damping ratio" };
        let label = format!(
            "Distribution of the {drawn}: {} of the machines stay quiet, {} vibrate; the {marked} is {}",
            shares[0],
            shares[1],
            significant(self.central, 3)
        );
        let areas = html!(
            "<path class=\"area quiet\" d=\"{}\"/>\n<path class=\"area vibrates\" d=\"{}\"/>\n\
             <text class=\"quiet\" x=\"16\" y=\"22\">quiet {}</text>\n\
             <text class=\"vibrates\" x=\"584\" y=\"22\" text-anchor=\"end\">vibrates {}</text>\n",
            outline(&quiet),
            outline(&vibrating),
            &shares[0],
            &shares[1],
        );
        let damping = mark(x(self.central), "", if self.coupled { "limit" } else { self.owner(verdict) }, LOWER);
        let remedied = self.remedied(verdict).filter(|(value, _)| (range.0..=range.1).contains(value));
        let line = remedied.map(|(value, reach)| {
            let text = Dimension::None.show_within(value, reach.value_interval.map(Into::into));
            mark(x(value), " limit", &text, INSIDE)
        });
        let caption = self.caption(verdict)
            + &remedied.map_or_else(String::new, |(_, reach)| {
                unbroken(&format!(" Dashed: {} vibrate.", percent(reach.probability)))
            });
        picture(&label, &[areas, damping].into_iter().chain(line).chain([scale(&axis)]).collect(), &caption)
    }

    /// Returns the damping ratio that reaches the first target.
    fn remedied<'a>(&self, verdict: &'a VerdictResult) -> Option<(f64, &'a Reach)> {
        let damping = verdict.remedies.iter().find(|remedy| remedy.input == DAMPING_RATIO && !self.coupled)?;
        let first = damping.reach.first()?;
        Some((first.value.filter(|value| *value != damping.now)?, first))
    }

    /// Draws the damping ratio and its limit, or the friction coefficient and the critical one, for exact values.
    fn marks(&self, verdict: &VerdictResult) -> Html {
        let (name, value, limit, sides, caption) = if self.coupled {
            let friction = self.central - verdict.nominal.damping_margin;
            let caption = "Above the critical coefficient steady sliding is unstable and the machine flutters.";
            ("friction coefficient", friction, self.central, ["quiet", "vibrates"], caption)
        } else {
            let limit = verdict.nominal.limit_damping_ratio.unwrap_or(0.0);
            let caption =
                "Below the limit the machine vibrates once started from standstill; above it, it stays quiet.";
            ("damping ratio ζ", self.central, limit, ["vibrates", "quiet"], caption)
        };
        // The text beside the larger of both has room on its right.
        let high = 2.0 * value.max(limit).max(f64::MIN_POSITIVE);
        let axis = Axis::linear(name, Unit::none(), (0.0, high));
        let x = |value: f64| LEFT + (RIGHT - LEFT) * (value / high).clamp(0.0, 1.0);
        let texts = [significant(value, 3), significant(limit, 3)];
        let label = format!("The {} is {}, its limit {}", name.trim_end_matches(" ζ"), texts[0], texts[1]);
        let ranges = html!(
            "<path class=\"area {5}\" d=\"M{0} {2}H{1}V{3}H{0}Z\"/>\n<path class=\"area {6}\" d=\"M{1} {2}H{4}V{3}H{1}Z\"/>\n",
            format!("{LEFT}"),
            format!("{:.2}", x(limit)),
            format!("{}", BASE - 40.0),
            format!("{BASE}"),
            format!("{RIGHT}"),
            sides[0],
            sides[1],
        );
        // The line of the smaller one starts in the upper row, to the left of the text in the lower row.
        let (upper, lower) = if value < limit { (UPPER, LOWER) } else { (LOWER, UPPER) };
        let marks = [
            ranges,
            mark(x(value), "", self.owner(verdict), upper),
            mark(x(limit), " limit", "limit", lower),
            scale(&axis),
        ];
        let brackets =
            verdict.nominal.damping_margin_interval.map_or("", |_| " Brackets: 95 % interval of the computation.");
        picture(&label, &marks.into_iter().collect(), &format!("{caption}{brackets}"))
    }

    fn caption(&self, verdict: &VerdictResult) -> String {
        let drawn = if self.coupled {
            "A machine flutters if its friction coefficient lies above the critical one. Drawn is the critical coefficient of central values \
             minus the margin of each machine, so that the areas are the probabilities."
        } else if self.uncertain_damping {
            "Each machine stands at its limit, shifted by how far its damping differs from the central one; areas are probabilities."
        } else {
            "A machine vibrates if its limit lies above its damping ratio."
        };
        let fluctuates = if self.sign_decides() {
            ""
        } else {
            " Friction fluctuates, so machines near the limit vibrate for a part of the time; the colours change where as many machines \
             lie above as count as vibrating."
        };
        let of = match self.samples {
            0 => "From the quantiles of the margin.".to_owned(),
            samples => format!("{} sampled machines.", count(samples)),
        };
        let fewer = if verdict.probability > 0.0
            && !verdict.friction_fluctuates
            && self.sorted.last().is_some_and(|limit| *limit <= self.split)
        {
            " None of them vibrates: the small probability has its own samples."
        } else {
            ""
        };
        format!("{drawn}{fluctuates} {of}{fewer}")
    }
}

/// Returns the median of numbers with the range that holds 90 % of them; `None` without numbers.
fn spread(mut numbers: Vec<f64>) -> Option<String> {
    numbers.retain(|number| number.is_finite());
    numbers.sort_by(f64::total_cmp);
    let last = numbers.len().checked_sub(1)?;
    let [q05, q50, q95] = [0.05, 0.5, 0.95].map(|at| numbers[(at * last as f64).round() as usize]);
    let (middle, range) = between(Dimension::None, Quantiles { q05, q50, q95 });
    Some(middle.trim_end().to_owned() + &range)
}

/// Returns margins that represent the quantiles, between which the distribution function is linear.
fn from_quantiles(verdict: &VerdictResult) -> Vec<f64> {
    let mut known: Vec<(f64, f64)> =
        verdict.margin_quantiles.iter().map(|quantile| (quantile.probability, quantile.damping_margin)).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    if known.len() < 2 {
        return Vec::new();
    }
    let at = |probability: f64| {
        let place = known.partition_point(|(known, _)| *known < probability).clamp(1, known.len() - 1);
        let ((p0, m0), (p1, m1)) = (known[place - 1], known[place]);
        m0 + (m1 - m0) * (probability - p0) / (p1 - p0)
    };
    (0..VALUES).map(|index| at((index as f64 + 0.5) / VALUES as f64)).filter(|margin| margin.is_finite()).collect()
}

/// Draws a vertical line with a text beside its upper end.
fn mark(x: f64, class: &str, text: &str, y: f64) -> Html {
    let has_room = x + 6.0 + CHARACTER * text.chars().count() as f64 <= WIDTH;
    let (anchor, beside) = if has_room { ("start", x + 6.0) } else { ("end", x - 6.0) };
    html!(
        "<line class=\"mark{}\" x1=\"{2}\" x2=\"{2}\" y1=\"{3}\" y2=\"{4}\"/>\n<text class=\"mark{0}\" x=\"{5}\" y=\"{6}\" \
         text-anchor=\"{1}\">{7}</text>\n",
        class,
        anchor,
        format!("{x:.1}"),
        format!("{}", y - 14.0),
        format!("{}", BASE + 6.0),
        format!("{beside:.1}"),
        format!("{y}"),
        text,
    )
}

/// Draws the axis with its ticks.
fn scale(axis: &Axis) -> Html {
    let ticks =
        axis.ticks(3).into_iter().filter(|tick| !tick.label.is_empty() && (0.04..=0.96).contains(&tick.position));
    let ticks = ticks.map(|tick| {
        let x = LEFT + (RIGHT - LEFT) * tick.position;
        html!("<text x=\"{}\" y=\"176\" text-anchor=\"middle\">{}</text>\n", format!("{x:.1}"), tick.label)
    });
    html!(
        "<line class=\"axis\" x1=\"16\" x2=\"584\" y1=\"{0}\" y2=\"{0}\"/>\n{1}<text x=\"300\" y=\"200\" text-anchor=\"middle\">{2}</text>\n",
        format!("{BASE}"),
        ticks.collect::<Html>(),
        axis.label(),
    )
}

fn picture(label: &str, content: &Html, caption: &str) -> Html {
    html!(
        "<svg class=\"margin\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n{}</svg>\n<p class=\"note\">{}</p>\n",
        format!("{WIDTH}"),
        format!("{HEIGHT}"),
        label,
        content,
        caption,
    )
}
