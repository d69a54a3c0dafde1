//! Margins of machines with constant friction at changed central values.

use asperity_base::blocks::Task;
use asperity_results::keys::{DAMPING_RATIO, INERTIA};

use super::machines::{Change, Machines};
use super::sampled::Evaluated;
use crate::monitor::{Cancelled, Monitor};
use crate::study::file::Hold;
use crate::study::result::MachineModel;
use crate::study::uncertain::Place;

/// Machines with other central values, or the reason why there are none.
pub(super) type Moved<'a> = Result<Machines<'a>, String>;

/// Returns the machines with other central values.
pub(super) fn moved<'a>(machines: &Machines<'a>, changes: &[Change]) -> Moved<'a> {
    let (mut inputs, mut hold, mut exact) = (machines.inputs().clone(), Hold::DampingRatio, Vec::new());
    for change in changes {
        match machines.places().iter().position(|uncertain| *uncertain == change.place) {
            Some(input) => {
                inputs = inputs.with_moved(input, change.value).map_err(|error| error.to_string())?;
                // Other values leave mω₀ as it is; what they hold must not decide for mass and frequency.
                if change.hold == Hold::Damper && INERTIA.contains(&change.place.name().as_str()) {
                    hold = change.hold;
                }
            }
            None => exact.push(*change),
        }
    }
    Ok(machines.with_inputs(inputs, hold).with_changes(exact))
}

/// Number of machines per block.
const BLOCK: usize = 64;

/// Returns the damping ratio and the margin of the machines at points of the standard normal variables. The margin is −∞ without an
/// answer, so that the machine counts as vibrating.
fn answers(machines: &Moved, points: &[Vec<f64>], monitor: &dyn Monitor) -> Result<Vec<[f64; 2]>, Cancelled> {
    let answer = |point: &Vec<f64>| {
        let machine = machines.as_ref().map_err(Clone::clone).and_then(|machines| machines.at(point));
        let answer = machine.and_then(|machine| {
            Ok([machine.inputs.damping_ratio, Evaluated::constant_friction(&machine)?.margins.from_stick])
        });
        answer.unwrap_or([0.0, f64::NEG_INFINITY])
    };
    let chunks: Vec<&[Vec<f64>]> = points.chunks(BLOCK).collect();
    let task = Task::new(monitor, "verdict: margins", chunks.len());
    let block = |index: usize| Ok::<Vec<_>, Cancelled>(chunks[index].iter().map(answer).collect());
    Ok(task.map(chunks.len(), block)?.concat())
}

/// Returns the margins of the machines at points of the standard normal variables; −∞ without an answer.
pub(super) fn margins(machines: &Moved, points: &[Vec<f64>], monitor: &dyn Monitor) -> Result<Vec<f64>, Cancelled> {
    Ok(answers(machines, points, monitor)?.into_iter().map(|[_, margin]| margin).collect())
}

/// Returns whether a change of a value changes the margins by as much as the damping ratios. The margin of coupled modes is one of friction.
pub(super) fn is_damping(place: Place, model: MachineModel) -> bool {
    place.name() == DAMPING_RATIO && model == MachineModel::StickSlip
}

/// Limits of the damping ratio of machines. They do not depend on the damping ratio, so machines that differ from known ones in it alone
/// need no further evaluation.
pub(super) struct Limits(Vec<f64>);

impl Limits {
    /// Computes the limits of the machines at points of the standard normal variables.
    pub(super) fn new(machines: &Moved, points: &[Vec<f64>], monitor: &dyn Monitor) -> Result<Self, Cancelled> {
        Ok(Self(answers(machines, points, monitor)?.into_iter().map(|[damping, margin]| damping - margin).collect()))
    }

    /// Returns the margins of the machines at the first of these points with other damping ratios.
    pub(super) fn margins(&self, machines: &Moved, place: Place, points: &[Vec<f64>]) -> Vec<f64> {
        let damping = |point: &Vec<f64>| {
            let damping = machines.as_ref().ok().and_then(|machines| machines.value_of(place, point));
            damping.unwrap_or(f64::NEG_INFINITY)
        };
        points.iter().zip(&self.0).map(|(point, limit)| damping(point) - limit).collect()
    }
}
