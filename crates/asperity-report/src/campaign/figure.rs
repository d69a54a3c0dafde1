//! The figure of a campaign: the main answer over the values.

use asperity_results::{CampaignResults, InputValue, MemberAnswers, MemberResult, Pair};

use crate::campaign::words::{SOURCE, capitalised, differs, key_in_words, number, unit_of, values_in_words, verdict};
use crate::cells::DASH;
use crate::figures::CaptionedFigure;
use crate::format::{Unit, count};
use crate::plot::{Axis, BLUE, Chart, Colour, Mark, VERMILION, pen, range};

/// Largest number of curves or colours.
const MOST_CURVES: usize = 6;

const PROBABILITY: &str = "Probability of vibration";
/// Name of the band of a curve.
const RANGE: &str = "shaded: 90 % range over unknown values";
/// Largest number of curves with a band.
const MOST_BANDS: usize = 3;
const MARGIN: &str = "Margin of the damping ratio";

/// Main answer of a member, by title and value.
type Quantity = (&'static str, fn(&MemberResult) -> Option<f64>);

/// Answers in the order in which the figure prefers them.
const QUANTITIES: [Quantity; 3] = [
    (PROBABILITY, |member| member.answers.probability),
    (MARGIN, |member| member.answers.damping_margin),
    ("Friction coefficient", |member| member.answers.friction_mean),
];

/// Points with one name in the legend.
type Group = (String, Vec<(f64, f64)>);

/// Draws the main answer over the first key whose values are numbers, one curve for each choice of the other values; or over the members.
pub(super) fn figure(results: &CampaignResults) -> Option<CaptionedFigure> {
    let members = &results.members;
    let (title, answer) = QUANTITIES.into_iter().find(|(_, answer)| members.iter().any(|m| answer(m).is_some()))?;
    let is_number = |place: &usize| members.iter().all(|member| matches!(member.values[*place], InputValue::Number(_)));
    let over = (0..results.keys.len()).find(|place| differs(results, *place) && is_number(place));
    let at = |index: usize, member: &MemberResult| match over {
        Some(place) => number(&member.values[place]).unwrap_or(f64::NAN),
        None => (index + 1) as f64,
    };
    let group = |name: &dyn Fn(&MemberResult) -> String| {
        let mut groups: Vec<Group> = Vec::new();
        for (index, member) in members.iter().enumerate() {
            let Some(y) = answer(member) else { continue };
            let (name, point) = (name(member), (at(index, member), y));
            match groups.iter().rposition(|(known, _)| *known == name) {
                Some(place) => groups[place].1.push(point),
                None if groups.len() > MOST_CURVES => break,
                None => groups.push((name, vec![point])),
            }
        }
        groups
    };
    let others = |member: &MemberResult| {
        let values = values_in_words(results, member, over);
        values.into_iter().chain(member.scan.clone()).collect::<Vec<_>>().join(", ")
    };
    let curves = group(&others);
    let is_curves = over.is_some_and(|place| !results.keys[place].sampled) && curves.len() <= MOST_CURVES;
    let scans = group(&|member: &MemberResult| member.scan.clone().unwrap_or_default());
    let by_scan = over.is_some() && (2..=MOST_CURVES).contains(&scans.len());
    let groups = match (is_curves, by_scan) {
        (true, _) => curves,
        (false, true) => scans,
        (false, false) => group(&|member: &MemberResult| verdict(member).to_owned()),
    };
    let all = || groups.iter().flat_map(|(_, points)| points);
    let x_ends = range(&all().map(|(x, _)| *x).collect::<Vec<_>>())?;
    let (low, high) = range(&all().map(|(_, y)| *y).collect::<Vec<_>>())?;
    let x = match over.map(|place| &results.keys[place]) {
        Some(key) => {
            let unit = unit_of(key, [x_ends.0, x_ends.1].into_iter());
            Axis::padded(&capitalised(key_in_words(key)), unit, x_ends, 0.03)
        }
        None => Axis::padded("Member", Unit::none(), x_ends, 0.03),
    };
    let y = axis_of(title, low, high);
    let ((x_low, x_high), y_ends) = (x.ends(), y.ends());
    let mut chart = Chart::new(x, y);
    if title == MARGIN {
        let x = [x_low, x_high];
        chart.band("ζ < ζ_v: vibrates", &x, [&[y_ends.0; 2], &[0.0; 2]], VERMILION);
        chart.band("ζ > ζ_v: quiet", &x, [&[0.0; 2], &[y_ends.1; 2]], BLUE);
    }
    if title == PROBABILITY && is_curves && groups.len() <= MOST_BANDS {
        bands(&mut chart, members, &groups, &at, &others);
    }
    for (place, (name, mut points)) in groups.into_iter().enumerate() {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        match is_curves {
            true => chart.points(name, &x, &y, pen(place)),
            false => {
                let (name, colour) = of_group(&name, if by_scan { pen(place).colour } else { BLUE });
                chart.add(name, Mark::Dots { x, y, radius: 3.5, colour, opacity: 0.8 });
            }
        }
    }
    let points = match over {
        Some(_) if is_curves => "One point for each member.",
        Some(_) => "One point for each member; the members differ in other values as well.",
        None => "One point for each member, in the order of the table.",
    };
    let caption = caption(points, title, members.iter().filter(|member| answer(member).is_none()).count());
    let figure = CaptionedFigure::from_charts("members", title, caption, 1, &[chart], &[])?;
    Some(CaptionedFigure { sources: vec![SOURCE.into()], ..figure })
}

/// Adds a band to each curve: the ranges over unknown values or, if no member has one, the intervals. `at` and `curve_of` return the place and
/// the curve of a member.
fn bands(
    chart: &mut Chart,
    members: &[MemberResult],
    curves: &[Group],
    at: &dyn Fn(usize, &MemberResult) -> f64,
    curve_of: &dyn Fn(&MemberResult) -> String,
) {
    let has_ranges = members.iter().any(|member| member.answers.probability_range.is_some());
    for (place, (curve, _)) in curves.iter().enumerate() {
        let ends = |(index, member): (usize, &MemberResult)| {
            let MemberAnswers { probability_range, probability_interval, .. } = member.answers;
            let ends = if has_ranges { probability_range } else { probability_interval };
            (curve_of(member) == *curve).then_some((at(index, member), ends?))
        };
        // The legend names bands once.
        let name = match (place, has_ranges) {
            (0, true) => RANGE,
            (0, false) => "shaded: 95 % interval",
            _ => "",
        };
        band(chart, name, members.iter().enumerate().filter_map(ends).collect(), pen(place).colour);
    }
}

/// Adds the intervals or ranges of the members of one curve, at their values.
fn band(chart: &mut Chart, name: &str, mut intervals: Vec<(f64, Pair)>, colour: Colour) {
    intervals.sort_by(|a, b| a.0.total_cmp(&b.0));
    let x: Vec<f64> = intervals.iter().map(|(x, _)| *x).collect();
    let [low, high] = [0, 1].map(|end| intervals.iter().map(|(_, ends)| ends[end]).collect::<Vec<f64>>());
    if !x.is_empty() {
        chart.band(name, &x, [&low, &high], colour);
    }
}

/// Returns the axis of an answer.
fn axis_of(title: &str, low: f64, high: f64) -> Axis {
    match title {
        PROBABILITY => Axis::linear(title, Unit::new("%", 0.01), (0.0, 1.0)),
        // Both sides of the limit are in the figure.
        MARGIN => {
            let reach = 0.2 * (high.max(0.0) - low.min(0.0));
            Axis::padded("Margin ζ − ζ_v", Unit::none(), (low.min(-reach), high.max(reach)), 0.06)
        }
        _ => Axis::padded(title, Unit::none(), (low, high), 0.06),
    }
}

/// Returns the caption; `failed` members have no value.
fn caption(points: &str, title: &str, failed: usize) -> String {
    let margin = if title == MARGIN {
        " ζ is the damping ratio of the member, and ζ_v the limit above which no vibration persists."
    } else {
        ""
    };
    let missing = match failed {
        0 => String::new(),
        1 => " One member has no value.".to_owned(),
        failed => format!(" {} members have no value.", count(failed)),
    };
    format!("{points}{margin}{missing}")
}

/// Returns the name and colour of points without a curve. Points without a verdict need no name.
fn of_group(name: &str, otherwise: Colour) -> (&str, Colour) {
    match name {
        "vibrates" => (name, VERMILION),
        DASH => ("", otherwise),
        _ => (name, otherwise),
    }
}
