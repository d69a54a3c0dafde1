//! Machines whose friction fluctuates.

use crate::friction::process::FrictionProcess;
use crate::monitor::{Inner, Monitor};
use crate::vibration::{Count, Ensemble, EnsembleSettings, Passages, VibrationError, clipped_to_positive};

use super::dynamics::Dynamics;
use super::machines::Machine;

/// Fraction of the time in vibration that half of the duration separates from the other half.
pub(super) const HALF: f64 = 0.5;
/// Numbers of trajectories after which a decision is tried.
const TRAJECTORIES: [usize; 4] = [8, 32, 128, 256];
/// Standard errors between φ and a level at which the side of φ is decided. As many machines on one side of a level as on the other are on the
/// wrong side by chance, so that their effect on a probability is of second order in the standard error.
const STANDARD_ERRORS: f64 = 2.0;

/// Standard deviation of friction over its mean below which friction counts as constant. It moves the limit of the damping ratio by less
/// than any error of the mean does.
pub(super) const NEGLIGIBLE_STD: f64 = 1e-4;

/// Time and levels of a fraction φ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted<'a> {
    pub(super) duration_s: f64,
    /// Trajectories are added until φ is above or below each of these levels; without levels, all trajectories are simulated.
    pub(super) levels: &'a [f64],
}

/// Returns the fraction φ of the second half of the duration in which a machine vibrates whose motion begins in stick, the mean over
/// realisations of friction; `None` if its friction counts as constant, and for coupled modes.
///
/// The standard error of few trajectories understates the error of φ if most of them never vibrate, or always. The side of φ therefore also
/// has to follow from the intervals of the rates of exit and entry.
///
/// The trajectories are part of the block of their machine: no part of a computation waits for those of another.
pub(super) fn fraction(
    machine: &Machine,
    wanted: Wanted<'_>,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Option<Count>, String> {
    let (inputs, window) = (&machine.inputs, &machine.window);
    let Dynamics::StickSlip(oscillator) = &machine.dynamics else { return Ok(None) };
    let model = window.process_model(inputs.upscaling, inputs.generator, inputs.scales.length_m());
    if model.std < NEGLIGIBLE_STD * window.mean {
        return Ok(None);
    }
    let process = FrictionProcess::new(clipped_to_positive(oscillator, model, 1.0)).map_err(|e| e.to_string())?;
    let duration = wanted.duration_s / inputs.scales.time_s();
    let last = TRAJECTORIES.len() - 1;
    for (round, &trajectories) in TRAJECTORIES.iter().enumerate().skip(if wanted.levels.is_empty() { last } else { 0 })
    {
        let settings = EnsembleSettings {
            drive: inputs.drive,
            sample_capacity: 0,
            ..EnsembleSettings::new(trajectories, duration, seed)
        };
        let ensemble = Ensemble::simulate(oscillator, &process, &settings, &Inner(monitor));
        let passages = ensemble.map_err(|error: VibrationError| error.to_string())?.passages;
        let [low, high] = bounds(&passages, duration);
        if round == last || wanted.levels.iter().all(|level| *level < low || *level > high) {
            return Ok(Some(passages.late_share));
        }
    }
    Ok(None)
}

/// Returns bounds of φ: by its standard error, and by the intervals of the rates.
fn bounds(passages: &Passages, duration: f64) -> [f64; 2] {
    let Count { mean, se, .. } = passages.late_share;
    let [exits, entries] = [passages.exit_rate, passages.entry_rate].map(|rate| rate.map(|rate| rate.interval));
    // Rates are unknown without time in which their events may occur.
    let [slow_exit, fast_exit] = exits.unwrap_or([0.0, f64::INFINITY]);
    let [slow_entry, fast_entry] = entries.unwrap_or([0.0, f64::INFINITY]);
    let least = late_fraction(fast_exit, slow_entry, duration);
    let most = late_fraction(slow_exit, fast_entry, duration);
    [(mean - STANDARD_ERRORS * se).min(least), (mean + STANDARD_ERRORS * se).max(most)]
}

/// Returns the expected fraction of the second half of a duration T in vibration at constant rates a of exit and b of entry: with
/// π = b/(a + b), the mean of π + (1 − π) e^{−(a + b)τ} over T/2 … T.
fn late_fraction(exit: f64, entry: f64, duration: f64) -> f64 {
    if exit == 0.0 || entry == f64::INFINITY {
        return 1.0;
    }
    if exit == f64::INFINITY {
        return 0.0;
    }
    let (rate, stationary) = (exit + entry, entry / (exit + entry));
    let half = 0.5 * rate * duration;
    let decay = (-half).exp() * -(-half).exp_m1() / half;
    stationary + (1.0 - stationary) * decay
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::WindowFriction;
    use crate::monitor::Silent;
    use crate::study::Study;
    use crate::study::verdict::machines::Machines;
    use crate::study::verdict::machines::tests::stated;
    use crate::study::verdict::sampled::{Evaluated, Sampled};
    use crate::vibration::Drive;
    use asperity_testing::StudyText;

    #[test]
    fn the_fraction_at_constant_rates_is_the_mean_of_its_markov_process() {
        // Simpson's rule over T/2 … T.
        let mean = |exit: f64, entry: f64, duration: f64| {
            let (rate, stationary) = (exit + entry, entry / (exit + entry));
            let at = |tau: f64| stationary + (1.0 - stationary) * (-rate * tau).exp();
            let steps: Vec<f64> = (0..=200).map(|k| duration * (0.5 + 0.0025 * f64::from(k))).collect();
            let weight = |k: usize| if k == 0 || k == 200 { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
            steps.iter().enumerate().map(|(k, tau)| weight(k) * at(*tau)).sum::<f64>() / 600.0
        };
        for (exit, entry, duration) in [(0.01, 0.002, 100.0), (0.3, 0.0, 20.0), (1e-4, 1e-5, 10.0), (2.0, 1.0, 7.0)] {
            let (found, wanted) = (late_fraction(exit, entry, duration), mean(exit, entry, duration));
            assert!((found - wanted).abs() < 1e-6, "{found} instead of {wanted}");
        }
        for (exit, entry, wanted) in [(0.0, 0.0, 1.0), (1.0, f64::INFINITY, 1.0), (f64::INFINITY, 0.0, 0.0)] {
            assert_eq!(late_fraction(exit, entry, 10.0), wanted);
        }
    }

    /// Machines whose friction fluctuates: the fraction of the time in vibration is .29 on average, and with the probability .108 ± .008 it is
    /// at least a half (4,000 machines of an independent program).
    const FLUCTUATING: &str = "seed = 14\n[vibration]\nmass = \"2 kg\"\nnatural_frequency = \"60 Hz\"\nnormal_force = \"500 N\"\n\
        nominal_area = \"400 mm^2\"\nbelt_velocity = \"20 mm/s\"\ndamping_ratio = \"0.085 ± 0.012\"\nstribeck = \"0.8 s/m\"\n\
        static_friction = \"0.3 ± 0.02\"\nfriction_std = 0.006\nfriction_correlation_length = \"100 um\"\n\
        friction_marginal = \"normal\"\nupscaling = \"paper\"\n[verdict]\nduration = \"2 s\"\n";

    #[test]
    fn friction_whose_standard_deviation_is_negligible_counts_as_constant() {
        for (std, fluctuates) in [("0.00001", false), ("0.0001", true)] {
            let (study, window) = stated(&FLUCTUATING.replace("0.006", std));
            let machine = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 14).nominal().unwrap();
            let found = fraction(&machine, Wanted { duration_s: 0.1, levels: &[HALF] }, 1, &Silent).unwrap();
            assert_eq!(found.is_some(), fluctuates, "{std}");
        }
    }

    /// Returns machines with φ, of which the side of `levels` is decided.
    fn sampled(machines: usize, levels: &[f64]) -> Sampled {
        let (study, window) = stated(FLUCTUATING);
        let all = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 14);
        let evaluate = |machine: &Machine, index: usize| {
            let found = fraction(machine, Wanted { duration_s: 2.0, levels }, index as u64, &Silent)?;
            Ok(Evaluated::constant_friction(machine)?.with_fraction(found.unwrap(), 0.1))
        };
        Sampled::until(&all, &evaluate, 1e-3, machines, &Silent).unwrap()
    }

    #[test]
    fn few_machines_have_the_mean_fraction_of_an_independent_program() {
        // Few trajectories decide that φ is below .97.
        let share = sampled(48, &[0.97]).mean(|machine| machine.fraction);
        // The fractions of machines have a standard deviation of .16, so that the mean of 48 independent ones has an error of .023.
        assert!((share.value - 0.29).abs() < 2.0 * 0.023, "{share:?}");
    }

    #[test]
    #[ignore = "slow"]
    fn many_machines_have_the_fraction_and_the_probability_of_an_independent_program() {
        let sampled = sampled(2048, &[0.1, HALF]);
        let share = sampled.mean(|machine| machine.fraction);
        let half = sampled.mean(|machine| f64::from(u8::from(machine.fraction >= HALF)));
        // Two digits are known of the mean.
        assert!((share.value - 0.29).abs() < 0.005 + share.half_width && share.half_width < 0.01, "{share:?}");
        assert!((half.value - 0.108).abs() < 3.0 * 0.008 && half.half_width < 0.02, "{half:?}");
        let probability = sampled.probability();
        assert!(probability.value > 0.8 && probability.half_width < 0.03, "{probability:?}");
    }

    /// Returns the paper's machine with strong fluctuation over short distances, and its friction.
    fn paper(lines: &str) -> (Study, WindowFriction) {
        let friction =
            "stribeck = 4.2\nfriction_std = 0.003\nfriction_correlation_length = \"25 um\"\nupscaling = \"paper\"";
        let study = StudyText::new(1, &["vibration", "stated friction"]).with("vibration", friction);
        stated(&study.with("vibration", lines).to_string())
    }

    #[test]
    fn the_fraction_is_that_of_an_ensemble_with_the_drive_of_the_machine() {
        const DURATION_S: f64 = 0.6;
        // Friction that changes during stick, too, releases the mass early.
        for (drive, name, wanted) in [(Drive::Time, "time", false), (Drive::Distance, "distance", true)] {
            let (study, window) = paper(&format!("damping_ratio = 0.62\ndrive = \"{name}\""));
            let (verdict, vibration) = (study.verdict.as_ref().unwrap(), study.vibration.as_ref().unwrap());
            let machine = Machines::new(verdict, &window, None, 1).nominal().unwrap();
            let Dynamics::StickSlip(oscillator) = &machine.dynamics else { panic!() };
            let model = machine.window.process_model(
                vibration.machine.upscaling,
                vibration.machine.generator,
                vibration.machine.scales.length_m(),
            );
            let settings = EnsembleSettings { drive, ..EnsembleSettings::new(128, DURATION_S * 316.0, 7) };
            let process = FrictionProcess::new(model).unwrap();
            let fraction = Ensemble::simulate(oscillator, &process, &settings, &Silent).unwrap().passages.late_share;
            assert!(
                (fraction.mean - 0.5).abs() > 3.0 * fraction.se && (fraction.mean > 0.5) == wanted,
                "{name}: {fraction:?}"
            );
            let found = Wanted { duration_s: DURATION_S, levels: &[HALF] };
            let found = super::fraction(&machine, found, 1, &Silent).unwrap().unwrap();
            assert!((found.mean - fraction.mean).abs() < 4.0 * found.se.hypot(fraction.se), "{found:?} {fraction:?}");
            // Without levels all trajectories are simulated.
            let all = super::fraction(&machine, Wanted { duration_s: DURATION_S, levels: &[] }, 1, &Silent);
            let settings = EnsembleSettings { drive, ..EnsembleSettings::new(256, DURATION_S * 316.0, 1) };
            let wanted = Ensemble::simulate(oscillator, &process, &settings, &Silent).unwrap().passages.late_share;
            assert_eq!(all, Ok(Some(wanted)));
        }
    }

    #[test]
    #[ignore = "slow"]
    fn a_machine_near_the_limit_is_decided_by_more_trajectories() {
        // After 256 trajectories the sign of φ − ½ decides; an earlier decision, at two standard errors, has the same sign.
        let mut early = 0;
        for (damping, seed) in [(0.74, 2), (0.8, 3), (0.86, 4), (0.92, 5), (0.98, 14)] {
            let (study, window) = paper(&format!("damping_ratio = {damping}"));
            let (verdict, vibration) = (study.verdict.as_ref().unwrap(), study.vibration.as_ref().unwrap());
            let machine = Machines::new(verdict, &window, None, 1).nominal().unwrap();
            let Dynamics::StickSlip(oscillator) = &machine.dynamics else { panic!() };
            let model = machine.window.process_model(
                vibration.machine.upscaling,
                vibration.machine.generator,
                vibration.machine.scales.length_m(),
            );
            let process = FrictionProcess::new(model).unwrap();
            let fraction = |trajectories: usize| {
                let settings = EnsembleSettings {
                    drive: vibration.machine.drive,
                    ..EnsembleSettings::new(trajectories, 60.0, seed)
                };
                Ensemble::simulate(oscillator, &process, &settings, &Silent).unwrap().passages.late_share.mean
            };
            let wanted = fraction(256) >= 0.5;
            early += usize::from((fraction(8) >= 0.5) != wanted);
            let found = super::fraction(&machine, Wanted { duration_s: 60.0 / 316.0, levels: &[HALF] }, seed, &Silent);
            assert_eq!(found.unwrap().unwrap().mean >= HALF, wanted, "{seed}");
        }
        assert!(early > 0, "eight trajectories decide every machine");
    }
}
