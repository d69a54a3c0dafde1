//! Moments and load over penetration (Fig. 3 of the paper).

use asperity_results::{FrictionResult, LevelResult, LoadCurve, Pair, UncertainLevel, UncertaintyResult};

use crate::Run;
use crate::figures::{CaptionedFigure, defined, positive};
use crate::format::{Dimension, Unit, significant};
use crate::plot::{Axis, BLUE, Chart, Colour, Dash, GREY, ORANGE, Pen, VERMILION, range, stacked};
use crate::words::conditions;

/// A band this much wider than the curves is cut off.
const WIDE: f64 = 4.0;

/// Lower and upper ends of intervals.
type Limits = [Vec<f64>; 2];

/// Reads a moment of a level with its interval.
type Moment = fn(&LevelResult) -> (Option<f64>, Option<Pair>);

/// A moment in a chart.
struct Panel {
    label: &'static str,
    /// Name among the moments over the uncertain parameters.
    name: &'static str,
    of_quotient: Moment,
    at_mean_load: Option<Moment>,
}

const MOMENTS: [Panel; 2] = [
    Panel {
        label: "Mean of μ",
        name: "mean",
        of_quotient: |level| (level.mean, level.mean_interval),
        at_mean_load: Some(|level| {
            let own = &level.process.at_mean_load;
            (Some(own.mean), own.mean_interval)
        }),
    },
    Panel {
        label: "Std of μ",
        name: "std",
        of_quotient: |level| (level.std, level.std_interval),
        at_mean_load: Some(|level| {
            let own = &level.process.at_mean_load;
            (Some(own.std), own.std_interval)
        }),
    },
];

const SHAPE: [Panel; 2] = [
    Panel {
        label: "CoV of μ",
        name: "coefficient_of_variation",
        of_quotient: |level| (level.coefficient_of_variation, level.coefficient_of_variation_interval),
        // The interval is that of the std: the error of the mean is negligible.
        at_mean_load: Some(|level| {
            let own = &level.process.at_mean_load;
            (Some(own.std / own.mean), own.std_interval.map(|ends| ends.map(|end| end / own.mean)))
        }),
    },
    Panel {
        label: "Skewness of μ",
        name: "skewness",
        of_quotient: |level| (level.skewness, level.skewness_interval),
        at_mean_load: None,
    },
];

/// Values at every level from the shallowest, with their intervals if there are any.
struct Curve {
    y: Vec<f64>,
    limits: Option<Limits>,
}

impl Curve {
    /// Reads a moment of all levels; `None` if no level has it.
    fn new(levels: &[&LevelResult], of: Moment) -> Option<Self> {
        let (y, intervals): (Vec<_>, Vec<_>) = levels.iter().map(|level| of(level)).unzip();
        let y: Vec<f64> = y.into_iter().map(|y| y.unwrap_or(f64::NAN)).collect();
        let end = |end: usize| intervals.iter().map(|ends| ends.map_or(f64::NAN, |ends| ends[end])).collect();
        let limits = intervals.iter().any(Option::is_some).then(|| [end(0), end(1)]);
        y.iter().any(|y| y.is_finite()).then_some(Self { y, limits })
    }

    fn values(&self) -> impl Iterator<Item = &f64> {
        self.y.iter().chain(self.limits.iter().flatten().flatten())
    }

    fn draw(&self, chart: &mut Chart, x: &[f64], (name, band): (&str, &str), pen: Pen) {
        chart.points(name, x, &self.y, pen);
        if let Some([low, high]) = &self.limits {
            chart.band(band, x, [low, high], pen.colour);
        }
    }
}

/// Returns the levels from the shallowest; they may be listed in any order.
fn by_depth(friction: &FrictionResult) -> Vec<&LevelResult> {
    let mut levels: Vec<&LevelResult> = friction.levels.iter().collect();
    levels.sort_by(|a, b| a.penetration_m.total_cmp(&b.penetration_m));
    levels
}

/// Draws the moments of the quotient F/N at every level, beside those at the mean load.
pub(super) fn figures(run: &Run) -> Vec<CaptionedFigure> {
    const NAME: &str = "friction_levels";
    let Some(friction) = &run.results.friction else { return Vec::new() };
    let conditions = conditions(friction);
    let uncertain = friction.uncertainty.as_ref();
    let over = " Orange: interval of the moments of F/N over 95 % of the uncertain parameters of the surface, from fewer strips.";
    let drawn = [
        (
            NAME,
            "Mean and standard deviation of the friction coefficient over penetration",
            "Mean and standard deviation of μ over the windows at each penetration",
            MOMENTS,
            uncertain.map_or("", |_| over),
        ),
        (
            "friction_shape",
            "Coefficient of variation and skewness of the friction coefficient over penetration",
            "Coefficient of variation, std over mean, and skewness of μ over the windows at each penetration",
            SHAPE,
            "",
        ),
    ];
    let drawn = drawn.into_iter().filter_map(|(name, title, moments, panels, over)| {
        let (charts, clipped) = charts(friction, uncertain, panels);
        let cut = if clipped { " Bands that are far wider than the curves are cut off." } else { "" };
        let caption = format!(
            "{moments} (the paper’s Fig. 3). “F/N” is the quotient of friction force and load of each window, where it has a variance; \
             “at the mean load” weights each window by the load it carries; shaded: 95 % intervals, if the strips hold enough \
             windows for one. The numbers at the points are the percentile of heights above the plane; “at load” is the level at the \
             mean pressure of the machine. {conditions}{over}{cut}"
        );
        let tables: &[&str] = if over.is_empty() { &[NAME] } else { &[NAME, "friction_uncertainty"] };
        CaptionedFigure::from_charts(name, title, caption.trim_end(), 1, &charts, tables)
    });
    drawn.collect()
}

/// Returns penetrations and limits of a moment over the uncertain parameters of the surface.
fn parameter_band(friction: &FrictionResult, uncertain: &UncertaintyResult, name: &str) -> Option<(Vec<f64>, Limits)> {
    let levels = friction.levels.iter().zip(&uncertain.levels);
    let place = |(own, level): (&LevelResult, &UncertainLevel)| {
        let response = level.responses.iter().find(|response| response.name == name)?;
        Some((own.penetration_m, response.interval?))
    };
    let mut places: Vec<(f64, Pair)> = levels.filter_map(place).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let end = |end: usize| places.iter().map(|(_, ends)| ends[end]).collect();
    (places.len() > 1).then(|| (places.iter().map(|(x, _)| *x).collect(), [end(0), end(1)]))
}

/// Draws the moments of the quotient, and the moments at the mean load where they differ visibly. `uncertain` holds the moments over
/// the uncertain parameters of the surface. Also reports whether a band was cut off.
fn charts(friction: &FrictionResult, uncertain: Option<&UncertaintyResult>, panels: [Panel; 2]) -> (Vec<Chart>, bool) {
    let levels = by_depth(friction);
    let x: Vec<f64> = levels.iter().map(|level| level.penetration_m).collect();
    let Some(x_range) = range(&x) else { return (Vec::new(), false) };
    let (mut charts, mut clipped) = (Vec::new(), false);
    for Panel { label, name, of_quotient, at_mean_load } in panels {
        let Some(quotient) = Curve::new(&levels, of_quotient) else { continue };
        let Some((low, high)) = range(quotient.values()) else { continue };
        let apart = |other: &Curve| {
            let mut pairs = other.y.iter().zip(&quotient.y);
            pairs.any(|(a, b)| (a - b).abs() > 0.01 * (high - low) || (b.is_nan() && !a.is_nan()))
        };
        let other = at_mean_load.and_then(|of| Curve::new(&levels, of)).filter(apart);
        let over = uncertain.and_then(|uncertain| parameter_band(friction, uncertain, name));
        let limits = over.iter().flat_map(|(_, limits)| limits.iter().flatten());
        let values = quotient.values().chain(other.iter().flat_map(Curve::values)).chain(limits);
        let Some(all) = range(values) else { continue };
        let curves = quotient.y.iter().chain(other.iter().flat_map(|other| &other.y));
        let (low, high) = range(curves).map_or(all, |curves| near(curves, all));
        clipped |= (low, high) != all;
        // The names of the levels need room above the first curve.
        let room = if charts.is_empty() { 0.25 * (high - low) } else { 0.0 };
        let y_axis = Axis::padded(label, Unit::none(), (low, high + room), 0.08);
        let x_axis = Axis::padded("Penetration", Dimension::Length.unit(x_range.1), x_range, 0.05);
        let mut chart = Chart::new(x_axis, y_axis);
        chart.horizontal("", 0.0, Pen::new(GREY, 1.0, Dash::Solid));
        if let Some((x, [low, high])) = &over {
            chart.band("95 % of the parameters", x, [low, high], ORANGE);
        }
        if charts.is_empty() {
            // Without a quotient the name is at the value at the mean load.
            let other = other.as_ref().map_or(&quotient.y, |other| &other.y);
            let places = quotient.y.iter().zip(other).map(|(own, other)| if own.is_nan() { *other } else { *own });
            name_levels(&mut chart, &levels, &x, &places.collect::<Vec<f64>>());
        }
        quotient.draw(&mut chart, &x, ("F/N of a window", "95 %, F/N"), Pen::new(BLUE, 1.8, Dash::Solid));
        if let Some(other) = other {
            let pen = Pen::new(VERMILION, 1.8, Dash::Dashed);
            other.draw(&mut chart, &x, ("at the mean load", "95 %, at the mean load"), pen);
        }
        charts.push(chart);
    }
    (stacked(charts, 190.0), clipped)
}

/// Returns the range of an axis whose bands may be far wider than its curves. It then extends beyond the curves by their range, or by
/// a quarter of their magnitude.
fn near((low, high): (f64, f64), all: (f64, f64)) -> (f64, f64) {
    let span = (high - low).max(0.25 * low.abs().max(high.abs()));
    if all.1 - all.0 > WIDE * span { (all.0.max(low - span), all.1.min(high + span)) } else { all }
}

fn name_levels(chart: &mut Chart, levels: &[&LevelResult], x: &[f64], y: &[f64]) {
    for ((level, &x), &y) in levels.iter().zip(x).zip(y) {
        let named = level.percentile.map(|percentile| format!("{} %", significant(percentile, 3)));
        chart.note(x, y, named.unwrap_or_else(|| "at load".to_owned()));
    }
}

/// Draws the load over penetration.
pub(super) fn load_curve(run: &Run) -> Option<CaptionedFigure> {
    const NAME: &str = "friction_load_curve";
    let table = run.tables.get(NAME)?;
    // Rows are in the order of the depth.
    let LoadCurve { penetration_m: x, mean_pressure_pa, low, high, contact_fraction } = LoadCurve::of(table);
    let x_range = range(&*x)?;
    let panel = |label: &str, y: &[f64], limits: Option<[&[f64]; 2]>, dimension: Dimension, colour: Colour| {
        let ends = range(positive(y).chain(limits.iter().flatten().flat_map(|end| positive(end))))?;
        let y_axis = Axis::logarithmic(label, dimension.unit(ends.1), (ends.0 / 1.3, ends.1 * 1.3));
        let x_axis = Axis::padded("Penetration", Dimension::Length.unit(x_range.1), x_range, 0.05);
        let mut chart = Chart::new(x_axis, y_axis);
        if let Some(limits) = limits {
            chart.band("95 % interval", &x, limits, colour);
        }
        defined([y])?;
        chart.points("", &x, y, Pen::new(colour, 1.8, Dash::Solid));
        Some(chart)
    };
    let panels = [
        panel("Mean pressure", &mean_pressure_pa, defined([&low, &high]), Dimension::Pressure, BLUE),
        panel("Contact fraction", &contact_fraction, None, Dimension::None, VERMILION),
    ];
    let caption = "Mean pressure over the nominal area, and contact area over nominal area, against the mean depth of the plane \
                   below the highest point of each strip; shaded: 95 % interval over the strips.";
    let charts = stacked(panels.into_iter().flatten().collect(), 190.0);
    CaptionedFigure::from_charts(NAME, "Load over penetration", caption, 1, &charts, &[NAME])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_follows_its_curves_where_bands_are_far_wider() {
        assert_eq!(near((1.0, 2.0), (0.0, 3.0)), (0.0, 3.0));
        assert_eq!(near((1.0, 2.0), (-50.0, 60.0)), (0.0, 3.0));
        assert_eq!(near((1.0, 2.0), (0.9, 60.0)), (0.9, 3.0));
    }

    #[test]
    fn levels_are_sorted_by_penetration() {
        let level = |penetration_m| LevelResult { penetration_m, ..LevelResult::default() };
        let friction = FrictionResult { levels: [3.0, 1.0, 2.0].map(level).into(), ..FrictionResult::default() };
        let found: Vec<f64> = by_depth(&friction).iter().map(|level| level.penetration_m).collect();
        assert_eq!(found, [1.0, 2.0, 3.0]);
    }
}
