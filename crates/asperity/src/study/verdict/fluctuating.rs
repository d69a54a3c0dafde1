//! Machines whose friction fluctuates.

use crate::friction::process::FrictionProcess;
use crate::monitor::{Monitor, Quiet};
use crate::vibration::{CONSTANT_STD, Ensemble, EnsembleSettings, VibrationError, clipped_to_positive};

use super::dynamics::Dynamics;
use super::machines::Machine;

/// Numbers of trajectories after which a decision is tried.
const TRAJECTORIES: [usize; 4] = [8, 32, 128, 512];
/// Standard errors between φ and ½ at which it is decided.
const STANDARD_ERRORS: f64 = 3.0;

/// Returns whether a machine whose motion begins in stick vibrates for at least half of the second half of the duration, in the
/// mean over the realisations of friction; `None` if its friction does not fluctuate, and for coupled modes.
pub(super) fn vibrates(
    machine: &Machine,
    duration_s: f64,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Option<bool>, String> {
    let (study, window) = (&machine.study, &machine.window);
    let Dynamics::StickSlip(oscillator) = &machine.dynamics else { return Ok(None) };
    let model = window.process_model(study.upscaling, study.generator, study.scales.length_m());
    if model.std < CONSTANT_STD {
        return Ok(None);
    }
    let process = FrictionProcess::new(clipped_to_positive(oscillator, model, 1.0)).map_err(|e| e.to_string())?;
    let duration = duration_s / study.scales.time_s();
    for (round, &trajectories) in TRAJECTORIES.iter().enumerate() {
        let settings = EnsembleSettings {
            drive: study.drive,
            method: study.method,
            sample_capacity: 0,
            ..EnsembleSettings::new(trajectories, duration, seed)
        };
        let ensemble = Ensemble::simulate(oscillator, &process, &settings, &Quiet(monitor));
        let fraction = ensemble.map_err(|error: VibrationError| error.to_string())?.passages.late_share;
        let distance = (fraction.mean - 0.5).abs();
        if distance > STANDARD_ERRORS * fraction.se || round + 1 == TRAJECTORIES.len() {
            return Ok(Some(fraction.mean >= 0.5));
        }
    }
    Ok(None)
}
