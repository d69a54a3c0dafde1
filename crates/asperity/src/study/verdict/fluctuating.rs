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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;
    use crate::study::Study;
    use crate::study::verdict::machines::Machines;
    use crate::study::verdict::machines::tests::stated_window;
    use crate::vibration::Drive;

    #[test]
    fn a_machine_vibrates_if_the_mean_fraction_of_an_ensemble_with_its_drive_is_half() {
        const DURATION_S: f64 = 0.6;
        let text = "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
                    nominal_area = \"833 mm^2\"\ndimensionless_belt_velocity = 0.003\nstribeck = 4.2\nstatic_friction = 0.1\n\
                    friction_std = 0.003\nfriction_correlation_length = \"25 um\"\nfriction_marginal = \"beta:2.1,5\"\n\
                    damping_ratio = 0.62\nupscaling = \"paper\"\n";
        // Friction that changes during stick, too, releases the mass early.
        for (drive, name, wanted) in [(Drive::Time, "time", false), (Drive::Distance, "distance", true)] {
            let study = Study::parse(&format!("{text}drive = \"{name}\"\n"), "study.toml").unwrap();
            let (verdict, vibration) = (study.verdict.as_ref().unwrap(), study.vibration.as_ref().unwrap());
            let window = stated_window(&study);
            let machine = Machines::new(verdict, &window, None, 1).nominal().unwrap();
            let Dynamics::StickSlip(oscillator) = &machine.dynamics else { panic!() };
            let model =
                machine.window.process_model(vibration.upscaling, vibration.generator, vibration.scales.length_m());
            let settings = EnsembleSettings { drive, ..EnsembleSettings::new(128, DURATION_S * 316.0, 7) };
            let process = FrictionProcess::new(model).unwrap();
            let fraction = Ensemble::simulate(oscillator, &process, &settings, &Silent).unwrap().passages.late_share;
            assert!(
                (fraction.mean - 0.5).abs() > 3.0 * fraction.se && (fraction.mean > 0.5) == wanted,
                "{name}: {fraction:?}"
            );
            assert_eq!(vibrates(&machine, DURATION_S, 1, &Silent), Ok(Some(wanted)));
        }
    }

    #[test]
    #[ignore = "slow"]
    fn a_machine_near_the_limit_is_decided_by_more_trajectories() {
        // After 512 trajectories the sign of φ − ½ decides; an earlier decision, at three standard errors, has the same sign.
        let text = "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
                    nominal_area = \"833 mm^2\"\ndimensionless_belt_velocity = 0.003\nstribeck = 4.2\nstatic_friction = 0.1\n\
                    friction_std = 0.003\nfriction_correlation_length = \"25 um\"\nfriction_marginal = \"beta:2.1,5\"\n\
                    upscaling = \"paper\"\n";
        let mut early = 0;
        for (damping, seed) in [(0.74, 2), (0.8, 3), (0.86, 4), (0.92, 5), (0.98, 14)] {
            let study = Study::parse(&format!("{text}damping_ratio = {damping}\n"), "study.toml").unwrap();
            let (verdict, vibration) = (study.verdict.as_ref().unwrap(), study.vibration.as_ref().unwrap());
            let window = stated_window(&study);
            let machine = Machines::new(verdict, &window, None, 1).nominal().unwrap();
            let Dynamics::StickSlip(oscillator) = &machine.dynamics else { panic!() };
            let model =
                machine.window.process_model(vibration.upscaling, vibration.generator, vibration.scales.length_m());
            let process = FrictionProcess::new(model).unwrap();
            let fraction = |trajectories: usize| {
                let settings =
                    EnsembleSettings { drive: vibration.drive, ..EnsembleSettings::new(trajectories, 60.0, seed) };
                Ensemble::simulate(oscillator, &process, &settings, &Silent).unwrap().passages.late_share.mean
            };
            let wanted = fraction(512) >= 0.5;
            early += usize::from((fraction(8) >= 0.5) != wanted);
            assert_eq!(vibrates(&machine, 60.0 / 316.0, seed, &Silent), Ok(Some(wanted)), "{seed}");
        }
        assert!(early > 0, "eight trajectories decide every machine");
    }
}
