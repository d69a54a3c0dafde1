//! Many oscillators without fluctuation, simulated in lockstep.

use super::batch::{Task, simulate_many};
use super::trajectory::NoObserver;
use super::{Oscillator, Slips, TrajectorySettings, VibrationError};
use asperity_base::blocks;
use asperity_process::Steady;

/// Number of oscillators per work item of a thread.
const CHUNK: usize = 64;

/// Checks that friction without fluctuation stays positive at the velocities of a motion.
///
/// # Errors
/// [`VibrationError::FrictionNotPositive`]. Other errors of the motion are none of this check.
pub fn check_positive(oscillator: &Oscillator, settings: &TrajectorySettings) -> Result<(), VibrationError> {
    if oscillator.law().is_positive() {
        return Ok(());
    }
    match deterministic_slips(std::slice::from_ref(oscillator), settings).pop() {
        Some(Err(error @ VibrationError::FrictionNotPositive { .. })) => Err(error),
        _ => Ok(()),
    }
}

/// Returns the slip counts of many oscillators without fluctuation, simulated in lockstep on all threads.
///
/// See [`super::Trajectory::simulate`] for a single oscillator.
pub fn deterministic_slips(
    oscillators: &[Oscillator],
    settings: &TrajectorySettings,
) -> Vec<Result<Slips, VibrationError>> {
    let chunks: Vec<&[Oscillator]> = oscillators.chunks(CHUNK).collect();
    let slips: Vec<Vec<_>> = blocks::map(0..chunks.len(), |chunk| {
        let chunk = chunks[chunk];
        let mut slips: Vec<_> = chunk.iter().map(|_| Ok(Slips::default())).collect();
        simulate_many(
            settings,
            0..chunk.len(),
            |index| Ok(Task::new(chunk[index].clone(), Steady, NoObserver)),
            |index, ended| slips[index] = ended.map(|followed| followed.slips),
        );
        slips
    });
    slips.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Linear;
    use crate::tests::machine;
    use crate::{Drive, Forcing, Trajectory, VelocityLaw};

    #[test]
    fn oscillators_in_lockstep_match_single_simulations() {
        let settings = TrajectorySettings { duration: 150.0, start: None, drive: Drive::Distance };
        let machines: Vec<Oscillator> = (0..70)
            .map(|i| {
                let free = Oscillator::with_stribeck(0.1, 4.2, 0.1 + 0.002 * f64::from(i), 0.003).unwrap();
                let forcing = (i % 5 == 0).then_some(Forcing { amplitude: 0.002, frequency: 0.98 });
                free.with_forcing(forcing).unwrap()
            })
            .collect();
        for (machine, slips) in machines.iter().zip(deterministic_slips(&machines, &settings)) {
            assert_eq!(slips, Trajectory::simulate(machine, Steady, &settings).map(|t| t.slips));
        }
        // A linear law has no positive value at the speed of the mass, and a start may be no number.
        let law = VelocityLaw::Linear(Linear { kinetic: 0.4, slope: 0.3 });
        let fast = machine(0.4, law, 0.1, 1.0);
        for settings in [settings, TrajectorySettings { start: Some(f64::NAN), ..settings }] {
            let alone = Trajectory::simulate(&fast, Steady, &settings).map(|t| t.slips);
            assert!(alone.is_err(), "{alone:?}");
            let found = deterministic_slips(std::slice::from_ref(&fast), &settings).remove(0);
            assert_eq!(format!("{found:?}"), format!("{alone:?}"));
        }
    }
}
