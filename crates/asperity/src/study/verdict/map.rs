//! Probability of vibration over the central values of two inputs.

use asperity_base::blocks::{self, Task};

use super::machines::{Change, Machine, Machines};
use super::remedies::{DAMPING, Evaluate, fraction_below_zero, moved, points};
use crate::monitor::{Cancelled, Monitor};
use crate::stats::quantile_sorted;
use crate::study::check::{RemedyStudy, VerdictStudy};
use crate::study::file::Hold;
use crate::study::result::{ModelResult, ProbabilityMap, ProbabilityMapAxis};
use crate::study::vibration_stage::lines;
use crate::study::{CsvTable, StudyError};
use crate::vibration::grid_contour;

/// Central values of one input.
pub(in crate::study) const VALUES: usize = 17;
/// Machines of each pair of central values: points of each randomisation of the Sobol' sequence.
pub(in crate::study) const POINTS: usize = 64;
/// Probability of a contour besides the targets.
const EVEN: f64 = 0.5;

/// Name of the table of the contours.
const CONTOURS: &str = "verdict_map_contours";

/// Map over the first two remedies with the table of its contours.
pub(super) struct Map {
    pub(super) result: ProbabilityMap,
    pub(super) contours: (&'static str, CsvTable),
}

/// Computes the map over the ranges of the first two remedies; `None` unless they change two inputs.
///
/// All pairs of central values share the standard normal variables of their machines. `evaluate` takes friction as constant. A
/// contour is the line on which the quantile of the margin is zero: it is smooth where the probability is not.
pub(super) fn map(
    machines: &Machines<'_>,
    study: &VerdictStudy,
    evaluate: &Evaluate<'_>,
    fluctuates: bool,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Option<Map>, StudyError> {
    let [x, y, ..] = &study.remedies[..] else { return Ok(None) };
    if x.place == y.place {
        return Ok(None);
    }
    let grid = Grid { machines, axes: [x, y], variables: points(machines.variables(), POINTS, seed)?, evaluate };
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
    let table = lines(names.each_ref().map(String::as_str), contours.iter().map(|(level, line)| (*level, line)), true);
    let axis = |remedy: &RemedyStudy, values| ProbabilityMapAxis {
        input: remedy.place.name(),
        unit: remedy.place.key().unit.into(),
        values,
    };
    let result = ProbabilityMap {
        probability: rows(&|node| node.probability),
        x: axis(x, x_values),
        y: axis(y, y_values),
        leaves_out_fluctuation: fluctuates,
    };
    Ok(Some(Map { result, contours: (CONTOURS, table) }))
}

/// Returns the central values of an axis.
fn values(remedy: &RemedyStudy) -> Vec<f64> {
    let step = (remedy.high - remedy.low) / (VALUES - 1) as f64;
    (0..VALUES).map(|index| if index + 1 == VALUES { remedy.high } else { remedy.low + step * index as f64 }).collect()
}

/// Machines at one pair of central values.
struct Node {
    /// Fraction of them that vibrates.
    probability: f64,
    /// Quantiles of the margin.
    quantiles: Vec<f64>,
}

struct Grid<'a> {
    machines: &'a Machines<'a>,
    axes: [&'a RemedyStudy; 2],
    variables: Vec<Vec<f64>>,
    evaluate: &'a Evaluate<'a>,
}

impl Grid<'_> {
    /// Evaluates the machines at all nodes, row by row.
    fn nodes(&self, levels: &[f64], monitor: &dyn Monitor) -> Result<Vec<Node>, Cancelled> {
        let [x, y] = self.axes.map(values);
        // The limit of the damping does not depend on the damping: the other axis needs one column of machines. The margin of coupled
        // modes is one of friction.
        let one_mode = self.machines.model() == ModelResult::StickSlip;
        let damping = self.axes.iter().position(|axis| axis.place.name() == DAMPING).filter(|_| one_mode);
        let columns = match damping {
            Some(axis) => {
                let others = if axis == 0 { &y } else { &x };
                let task = Task::new(monitor, "verdict: map", others.len());
                blocks::map::<_, Result<Vec<_>, _>>(0..others.len(), |index| {
                    task.step(|| self.limits(self.axes[1 - axis], others[index]))
                })?
            }
            None => Vec::new(),
        };
        let task = Task::new(monitor, "verdict: map", x.len() * y.len());
        blocks::map(0..x.len() * y.len(), |index| {
            task.step(|| {
                let (column, row) = (index % x.len(), index / x.len());
                let machines = self.at([x[column], y[row]]);
                let mut margins = match damping {
                    Some(axis) => self.damping_margins(machines, axis, &columns[if axis == 0 { row } else { column }]),
                    None => self.margins(machines),
                };
                margins.sort_by(f64::total_cmp);
                Node {
                    probability: fraction_below_zero(&margins),
                    quantiles: levels.iter().map(|level| quantile_sorted(&margins, *level)).collect(),
                }
            })
        })
    }

    /// Returns the machines with two central values. The map of a damping ratio states it, whatever the other input holds.
    fn at(&self, values: [f64; 2]) -> Result<Machines<'_>, String> {
        let is_damping = |axis: &&RemedyStudy| axis.place.name() == DAMPING;
        let hold = |axis: &RemedyStudy| if self.axes.iter().any(is_damping) { Hold::DampingRatio } else { axis.hold };
        let changes = [0, 1].map(|k| Change { place: self.axes[k].place, value: values[k], hold: hold(self.axes[k]) });
        moved(self.machines, &changes)
    }

    /// Returns the margins of machines. A machine without an answer counts as vibrating.
    fn margins(&self, machines: Result<Machines<'_>, String>) -> Vec<f64> {
        let margin = |machine: &Machine, index| Ok((self.evaluate)(machine, index)?.margins.from_stick);
        self.each(machines, &margin).map(|margin| margin.unwrap_or(f64::NEG_INFINITY)).collect()
    }

    /// Returns the limit damping ratios of machines with one other central value; infinite without an answer.
    fn limits(&self, axis: &RemedyStudy, value: f64) -> Vec<f64> {
        let machines = moved(self.machines, &[Change { place: axis.place, value, hold: Hold::DampingRatio }]);
        let limit = |machine: &Machine, index| {
            Ok(machine.study.damping_ratio - (self.evaluate)(machine, index)?.margins.from_stick)
        };
        self.each(machines, &limit).map(|limit| limit.unwrap_or(f64::INFINITY)).collect()
    }

    /// Returns the margins at the damping ratios of machines with these limits.
    fn damping_margins(&self, machines: Result<Machines<'_>, String>, axis: usize, limits: &[f64]) -> Vec<f64> {
        let damping = |variables: &Vec<f64>| {
            machines.as_ref().map_or(f64::NEG_INFINITY, |machines| machines.value_of(self.axes[axis].place, variables))
        };
        self.variables.iter().zip(limits).map(|(variables, limit)| damping(variables) - limit).collect()
    }

    /// Returns a number of each machine.
    fn each<'b>(
        &'b self,
        machines: Result<Machines<'b>, String>,
        number: &'b dyn Fn(&Machine, usize) -> Result<f64, String>,
    ) -> impl Iterator<Item = Result<f64, String>> + 'b {
        self.variables.iter().enumerate().map(move |(index, variables)| {
            let machine = machines.as_ref().map_err(Clone::clone)?.at(variables)?;
            number(&machine, index)
        })
    }
}
