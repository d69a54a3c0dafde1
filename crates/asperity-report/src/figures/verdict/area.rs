//! The probability of vibration against the number of windows that share the load.

use asperity_results::AreaAsOne;

use crate::Run;
use crate::cells::percent;
use crate::figures::CaptionedFigure;
use crate::format::{Unit, significant};
use crate::plot::{Axis, BLACK, BLUE, Chart, Dash, Pen, VERMILION};

const TITLE: &str = "Probability of vibration against the windows that share the load";

/// Draws the probabilities of a run.
pub(super) fn figure(run: &Run) -> Option<CaptionedFigure> {
    let rows = run.results.verdict.as_ref()?.area_as_one.as_deref()?;
    let (first, last) = (rows.first()?, rows.last()?);
    let stated = run.inputs.iter().find(|input| input.section == "vibration" && input.key == "upscaling");
    let is_paper = stated.is_some_and(|input| input.value == "paper");
    let column = |of: fn(&AreaAsOne) -> f64| rows.iter().map(of).collect::<Vec<f64>>();
    let windows = column(|row| row.windows);
    let mut chart = Chart::new(
        Axis::logarithmic(
            "Number n of independent windows that share the load",
            Unit::none(),
            (0.7 * first.windows, 1.4 * last.windows),
        ),
        Axis::linear("Probability of vibration", Unit::none(), (-0.03, 1.03)),
    );
    let interval = [column(|row| row.probability_interval[0]), column(|row| row.probability_interval[1])];
    chart.band("95 % interval", &windows, interval.each_ref().map(Vec::as_slice), BLUE);
    chart.points("probability, from stick", &windows, &column(|row| row.probability), Pen::new(BLUE, 2.0, Dash::Solid));
    let marks = if is_paper {
        [("this study: one window, as in the paper", first.windows), ("the nominal area", last.windows)]
    } else {
        [("the paper: one window", first.windows), ("this study: the nominal area", last.windows)]
    };
    for ((name, windows), (colour, dash)) in marks.into_iter().zip([(VERMILION, Dash::Dashed), (BLACK, Dash::Dotted)]) {
        chart.vertical(name, windows, Pen::new(colour, 1.8, dash));
    }
    let caption = format!(
        "{} The standard deviation of friction, corrected for pitch and scan as its mean is, falls like 1/√n, from {} to {}; the last point has the variance of the nominal area itself. \
         All points share their machines and realisations of friction.",
        sentence(rows),
        significant(first.friction_std, 2),
        significant(last.friction_std, 2)
    );
    CaptionedFigure::from_charts("verdict_area", TITLE, caption, 1, &[chart], &["verdict_area"])
}

/// Returns whether the probability depends on the number of windows, in a sentence.
fn sentence(rows: &[AreaAsOne]) -> String {
    let by = |a: &&AreaAsOne, b: &&AreaAsOne| a.probability.total_cmp(&b.probability);
    let (Some(least), Some(most)) = (rows.iter().min_by(by), rows.iter().max_by(by)) else { return String::new() };
    let shown = |row: &AreaAsOne| percent(row.probability, 2);
    if least.probability_interval[1] < most.probability_interval[0] {
        let windows = |row: &AreaAsOne| significant(row.windows, 3);
        return format!(
            "The answer depends on how much of the area acts as one: vibration has the probability {} at n = {} and {} at n = {}.",
            shown(least),
            windows(least),
            shown(most),
            windows(most)
        );
    }
    format!(
        "The answer does not depend on how much of the area acts as one: the probability stays between {} and {}, within the error of the \
         sample.",
        shown(least),
        shown(most)
    )
}
