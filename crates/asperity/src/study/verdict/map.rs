//! Probability of vibration over the central values of two inputs.

use asperity_base::blocks::Task;
use asperity_base::sentence;
use asperity_results::keys::DAMPING_RATIO;

use super::machines::{Change, Machines};
use super::margins::{Limits, Moved, is_damping, margins, moved};
use super::replicates::{fraction_below_zero, fraction_unanswered, points};
use crate::monitor::{Cancelled, Monitor, Quiet};
use crate::stats::quantile_sorted;
use crate::study::check::{RemedyStudy, VerdictStudy};
use crate::study::file::Hold;
use crate::study::result::{ProbabilityMap, ProbabilityMapAxis};
use crate::study::series::lines_table;
use crate::study::{StudyError, Table};
use crate::vibration::grid_contour;

/// Central values of one input.
pub(super) const VALUES: usize = 17;
/// Machines of each pair of central values: points of each randomisation of the Sobol' sequence.
pub(super) const POINTS: usize = 64;
/// Probability of a contour besides the targets.
const EVEN: f64 = 0.5;

/// Name of the table of the contours.
const CONTOURS: &str = "verdict_map_contours";

/// Map over the first two remedies of the study file with the table of its contours.
pub(super) struct Map {
    pub(super) result: ProbabilityMap,
    pub(super) contours: (&'static str, Table),
    /// Warning if too few machines have an answer somewhere.
    pub(super) warning: Option<String>,
}

/// Computes the map over the ranges of the first two remedies of the study file; `None` unless they change two inputs.
///
/// All pairs of central values share the standard normal variables of their machines. Friction is constant. A contour is the line on
/// which the quantile of the margin is zero: it is smooth where the probability is not.
pub(super) fn map(
    machines: &Machines<'_>,
    study: &VerdictStudy,
    friction_fluctuates: bool,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Option<Map>, StudyError> {
    let Some([x, y]) = study.mapped() else { return Ok(None) };
    if x.place == y.place {
        return Ok(None);
    }
    let grid = Grid { machines, axes: [x, y], points: points(machines.variables(), POINTS, seed)? };
    let mut levels: Vec<f64> = study.targets.iter().copied().chain([EVEN]).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let nodes = grid.nodes(&levels, monitor)?;
    let rows = |of: &dyn Fn(&Node) -> f64| -> Vec<Vec<f64>> {
        nodes.chunks(VALUES).map(|row| row.iter().map(of).collect()).collect()
    };
    let [x_values, y_values] = [x, y].map(values);
    let contours = levels.iter().enumerate().flat_map(|(place, level)| {
        let lines = grid_contour(&x_values, &y_values, &rows(&|node| node.quantiles[place]));
        lines.into_iter().map(|line| (*level, line))
    });
    let contours: Vec<(f64, Vec<[f64; 2]>)> = contours.collect();
    let names = [x.place.name(), y.place.name()];
    let table =
        lines_table(names.each_ref().map(String::as_str), contours.iter().map(|(level, line)| (*level, line)), true);
    let axis = |remedy: &RemedyStudy, values| ProbabilityMapAxis {
        input: remedy.place.name(),
        unit: remedy.place.key().unit.into(),
        values,
    };
    let result = ProbabilityMap {
        probability: rows(&|node| node.probability),
        x: axis(x, x_values),
        y: axis(y, y_values),
        leaves_out_fluctuation: friction_fluctuates,
    };
    let unanswered = nodes.iter().filter(|node| 1.0 - node.unanswered < study.valid_fraction).count();
    let warning = (unanswered > 0).then(|| {
        format!(
            "the map counts machines without an answer as vibrating, more than {} % of them at {unanswered} of its {} pairs of values",
            sentence::digits(100.0 * (1.0 - study.valid_fraction)),
            nodes.len()
        )
    });
    Ok(Some(Map { result, contours: (CONTOURS, table), warning }))
}

/// Returns the central values of an axis.
fn values(remedy: &RemedyStudy) -> Vec<f64> {
    let fractions = (0..VALUES).map(|index| index as f64 / (VALUES - 1) as f64);
    fractions.map(|fraction| (1.0 - fraction) * remedy.low + fraction * remedy.high).collect()
}

/// Machines at one pair of central values.
struct Node {
    /// Fraction of them that vibrates.
    probability: f64,
    /// Fraction without an answer.
    unanswered: f64,
    /// Quantiles of the margin.
    quantiles: Vec<f64>,
}

struct Grid<'a> {
    machines: &'a Machines<'a>,
    axes: [&'a RemedyStudy; 2],
    points: Vec<Vec<f64>>,
}

impl Grid<'_> {
    /// Evaluates the machines at all nodes, row by row.
    fn nodes(&self, levels: &[f64], monitor: &dyn Monitor) -> Result<Vec<Node>, Cancelled> {
        let [x, y] = self.axes.map(values);
        let quiet = &Quiet(monitor);
        let damping = self.axes.iter().position(|axis| is_damping(axis.place, self.machines.model()));
        let limits = match damping {
            Some(axis) => {
                let (other, values) = (self.axes[1 - axis].place, if axis == 0 { &y } else { &x });
                let task = Task::new(monitor, "verdict: map", values.len());
                let at = |value| moved(self.machines, &[Change { place: other, value, hold: Hold::DampingRatio }]);
                let limits = values.iter().map(|&value| task.step(|| Limits::new(&at(value), &self.points, quiet))?);
                limits.collect::<Result<Vec<_>, _>>()?
            }
            None => Vec::new(),
        };
        let task = Task::new(monitor, "verdict: map", x.len() * y.len());
        let node = |index: usize| {
            let (column, row) = (index % x.len(), index / x.len());
            let machines = self.at([x[column], y[row]]);
            let mut margins = match damping {
                Some(axis) => {
                    let limits = &limits[if axis == 0 { row } else { column }];
                    limits.margins(&machines, self.axes[axis].place, &self.points)
                }
                None => margins(&machines, &self.points, quiet)?,
            };
            margins.sort_by(f64::total_cmp);
            Ok(Node {
                probability: fraction_below_zero(&margins),
                unanswered: fraction_unanswered(&margins),
                quantiles: levels.iter().map(|level| quantile_sorted(&margins, *level)).collect(),
            })
        };
        (0..x.len() * y.len()).map(|index| task.step(|| node(index))?).collect()
    }

    /// Returns the machines with two central values. The map of a damping ratio states it, whatever the other input holds.
    fn at(&self, values: [f64; 2]) -> Moved<'_> {
        let states_damping = self.axes.iter().any(|axis| axis.place.name() == DAMPING_RATIO);
        let hold = |axis: &RemedyStudy| if states_damping { Hold::DampingRatio } else { axis.hold };
        let changes = [0, 1].map(|k| Change { place: self.axes[k].place, value: values[k], hold: hold(self.axes[k]) });
        moved(self.machines, &changes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::standard_normal_cdf;
    use crate::monitor::Silent;
    use crate::study::verdict::machines::tests::{LINEAR, stated};

    #[test]
    #[ignore = "slow"]
    fn either_axis_can_be_the_damping_ratio() {
        // M = ζ − b/2 has the standard deviation .0111803, and a machine vibrates if it is negative.
        let ranges = |input: &str| if input == "damping_ratio" { [0.03, 0.08] } else { [0.08, 0.16] };
        let text = |inputs: [&str; 2]| {
            let remedy = |input| format!("{{ input = \"vibration.{input}\", range = {:?} }}", ranges(input));
            let remedies = inputs.map(remedy);
            format!("{LINEAR}[verdict]\nremedies = [{}]\n", remedies.join(", "))
        };
        // One remedy gives no map.
        let one =
            text(["damping_ratio"; 2]).replace(", { input = \"vibration.damping_ratio\", range = [0.03, 0.08] }]", "]");
        let (study, window) = stated(&one);
        let verdict = study.verdict.as_ref().unwrap();
        assert!(map(&Machines::new(verdict, &window, None, 1), verdict, false, 1, &Silent).unwrap().is_none());
        let maps = [["damping_ratio", "linear_weakening"], ["linear_weakening", "damping_ratio"]].map(|inputs| {
            let (study, window) = stated(&text(inputs));
            let verdict = study.verdict.as_ref().unwrap();
            let machines = Machines::new(verdict, &window, None, 1);
            map(&machines, verdict, false, 1, &Silent).unwrap().unwrap().result
        });
        for (which, map) in maps.iter().enumerate() {
            assert_eq!([&map.x, &map.y].map(|axis| axis.values.len()), [VALUES; 2]);
            for (axis, damping) in [(&map.x, which == 0), (&map.y, which == 1)] {
                let input = if damping { "damping_ratio" } else { "linear_weakening" };
                assert_eq!(axis.input, format!("vibration.{input}"));
                assert_eq!([axis.values[0], axis.values[VALUES - 1]], ranges(input));
            }
            for (y, row) in map.y.values.iter().zip(&map.probability) {
                for (x, probability) in map.x.values.iter().zip(row) {
                    let (damping, weakening) = if which == 0 { (x, y) } else { (y, x) };
                    let wanted = standard_normal_cdf(-(damping - 0.5 * weakening) / 0.011_180_3);
                    // Four standard deviations of 512 independent machines, and one machine.
                    let error = 4.0 * (wanted * (1.0 - wanted) / 512.0).sqrt() + 1.0 / 512.0;
                    assert!((probability - wanted).abs() < error, "{damping} {weakening}: {probability} not {wanted}");
                }
            }
        }
    }
}
