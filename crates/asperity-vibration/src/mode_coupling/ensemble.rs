//! Ensembles of trajectories and the probability that they become a vibration.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::super::sample_distribution::RunningMoments;
use super::super::{Count, FailedTrajectory, VibrationError, positive};
use super::motion::Cut;
use super::trajectory::started;
use super::{Contact, CoupledTrajectorySettings, Model, State};
use asperity_base::blocks::Task;
use asperity_base::monitor::Monitor;
use asperity_base::stats::wilson_interval;
use asperity_process::{Cancellable, Fluctuation, FrictionProcess, Steady};

/// Last fraction of the time, in which a vibration counts as sustained.
const LAST_FRACTION: f64 = 0.25;

/// Settings of an ensemble.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoupledEnsembleSettings {
    /// Number of trajectories, at least 2.
    pub trajectories: usize,
    /// Duration τ of each trajectory.
    pub duration: f64,
    /// Amplitude |x − x_s| above which motion counts as vibration; x_s is x in steady sliding without fluctuation.
    pub threshold: f64,
    /// Seed; trajectory i reads realisation i of the process.
    pub seed: u64,
    /// State at τ = 0; the default is given at [`CoupledTrajectorySettings::start`].
    pub start: Option<State>,
    /// Least fraction of valid trajectories.
    pub least_valid_share: f64,
}

/// Statistics of many trajectories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CoupledEnsemble {
    /// Number of requested trajectories.
    pub trajectories: usize,
    /// Fraction of the trajectories whose amplitude exceeds the threshold.
    pub passed: f64,
    /// 95 % interval of that fraction (Wilson).
    pub passed_interval: [f64; 2],
    /// Time of the first passage, over the trajectories that exceed the threshold; none if fewer than two do.
    pub passage_time: Option<Count>,
    /// Fraction of the trajectories whose amplitude exceeds the threshold in the last quarter of the time: a sustained
    /// vibration.
    pub sustained: f64,
    /// 95 % interval of that fraction (Wilson).
    pub sustained_interval: [f64; 2],
    /// Largest amplitude in the last quarter of the time.
    pub amplitude: Count,
    /// Fraction of the time in stick.
    pub stick_share: Count,
    /// Fraction of the time off the belt.
    pub flight_share: Count,
    /// Result without fluctuation.
    pub deterministic: CoupledOutcome,
    /// Trajectories that failed.
    pub failures: Vec<FailedTrajectory>,
}

/// Result of one trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CoupledOutcome {
    /// Time at which the amplitude first exceeded the threshold.
    pub passage: Option<f64>,
    /// Largest amplitude in the last quarter of the time.
    pub amplitude: f64,
    /// Fraction of the time in stick.
    pub stick_share: f64,
    /// Fraction of the time off the belt.
    pub flight_share: f64,
}

impl CoupledEnsemble {
    /// Simulates many trajectories in parallel. Amplitudes are evaluated at the extremes of x. The result does not
    /// depend on the number of threads.
    ///
    /// Fails if settings are out of range, if no steady sliding exists, if the motion without fluctuation is invalid,
    /// if too few trajectories are valid, or when cancelled.
    pub fn simulate(
        model: &Model,
        process: &FrictionProcess,
        settings: &CoupledEnsembleSettings,
        monitor: &dyn Monitor,
    ) -> Result<Self, VibrationError> {
        positive("threshold", settings.threshold)?;
        let deterministic = follow(model, Steady, settings)?;
        let run = |index| {
            let mut path = Cancellable::new(process.path(settings.seed, index), monitor);
            follow(model, &mut path, settings)
        };
        let Runs { values, failures } = run_all(settings.trajectories, settings.least_valid_share, monitor, run)?;
        let count = |of: fn(&CoupledOutcome) -> f64| counted(values.iter().map(of));
        let fraction = |of: &dyn Fn(&CoupledOutcome) -> bool| {
            let met = values.iter().filter(|outcome| of(outcome)).count();
            let interval = wilson_interval(met, values.len());
            (met as f64 / values.len() as f64, [interval.low, interval.high])
        };
        let (passed, passed_interval) = fraction(&|outcome| outcome.passage.is_some());
        let (sustained, sustained_interval) = fraction(&|outcome| outcome.amplitude >= settings.threshold);
        let passages: Vec<f64> = values.iter().filter_map(|outcome| outcome.passage).collect();
        Ok(Self {
            trajectories: settings.trajectories,
            passed,
            passed_interval,
            passage_time: (passages.len() > 1).then(|| counted(passages.into_iter())),
            sustained,
            sustained_interval,
            amplitude: count(|outcome| outcome.amplitude),
            stick_share: count(|outcome| outcome.stick_share),
            flight_share: count(|outcome| outcome.flight_share),
            deterministic,
            failures,
        })
    }
}

/// Follows one trajectory.
fn follow(
    model: &Model,
    fluctuation: impl Fluctuation,
    settings: &CoupledEnsembleSettings,
) -> Result<CoupledOutcome, VibrationError> {
    let CoupledEnsembleSettings { duration, threshold, start, .. } = *settings;
    let reason = "friction pulls the mass away";
    let missing = VibrationError::NotFound { what: "state of steady sliding", reason };
    let rest = model.steady(model.sliding_friction()).ok_or(missing)?.tangential;
    let mut motion = started(model, fluctuation, &CoupledTrajectorySettings { duration, start })?;
    let (mut stick, mut flight, mut amplitude, mut passage) = (0.0, 0.0, 0.0_f64, None);
    while motion.now.tau < duration {
        let cut = motion.step(duration)?;
        let now = motion.now;
        match motion.passed {
            (Contact::Stick, since) => stick += now.tau - since,
            (Contact::Flight, since) => flight += now.tau - since,
            _ => {}
        }
        if !matches!(cut, Cut::Maximum | Cut::Minimum) {
            continue;
        }
        let size = (now.x - rest).abs();
        if size >= threshold && passage.is_none() {
            passage = Some(now.tau);
        }
        if now.tau >= (1.0 - LAST_FRACTION) * duration {
            amplitude = amplitude.max(size);
        }
    }
    Ok(CoupledOutcome { passage, amplitude, stick_share: stick / duration, flight_share: flight / duration })
}

/// Returns the mean, standard deviation and standard error.
fn counted(values: impl Iterator<Item = f64>) -> Count {
    let mut sums = RunningMoments::EMPTY;
    values.for_each(|value| sums.add(value));
    Count { mean: sums.mean(), std: sums.std(), se: sums.std() / (sums.count() as f64).sqrt() }
}

/// Valid results in the order of their trajectories, and the failures.
pub(super) struct Runs<T> {
    pub(super) values: Vec<T>,
    pub(super) failures: Vec<FailedTrajectory>,
}

/// Runs trajectories in parallel; at least the given fraction must be valid.
pub(super) fn run_all<T: Serialize + DeserializeOwned + Send>(
    total: usize,
    least_valid_share: f64,
    monitor: &dyn Monitor,
    run: impl Fn(u64) -> Result<T, VibrationError> + Sync,
) -> Result<Runs<T>, VibrationError> {
    if total < 2 {
        let value = total as f64;
        return Err(VibrationError::Parameter { parameter: "trajectories", value, wanted: "at least 2" });
    }
    if !(0.0..=1.0).contains(&least_valid_share) {
        let wanted = "in 0 … 1";
        return Err(VibrationError::Parameter { parameter: "least_valid_share", value: least_valid_share, wanted });
    }
    let task = Task::new(monitor, "trajectories", total);
    let found =
        task.try_map(total, |index| Ok::<_, VibrationError>(run(index as u64).map_err(|error| error.to_string())))?;
    let mut runs = Runs { values: Vec::with_capacity(total), failures: Vec::new() };
    for (trajectory, value) in found.into_iter().enumerate() {
        match value {
            Ok(value) => runs.values.push(value),
            Err(reason) => runs.failures.push(FailedTrajectory { trajectory, reason }),
        }
    }
    let valid = runs.values.len();
    if valid < 2 || (valid as f64) < least_valid_share * total as f64 {
        let (wanted, first) = (least_valid_share, runs.failures.first().map(|f| f.reason.clone()).unwrap_or_default());
        return Err(VibrationError::TooFewValid { valid, total, wanted, first });
    }
    Ok(runs)
}

#[cfg(test)]
mod tests {
    use super::super::{CoupledParameters, Damping, limit_cycle};
    use super::*;
    use crate::VelocityLaw;
    use crate::law::Coulomb;
    use asperity_base::monitor::Silent;
    use asperity_process::ProcessModel;

    fn model(friction: f64) -> Model {
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: friction });
        let damping = Damping::Modal { ratios: [0.05; 2] };
        Model::new(CoupledParameters { law, static_friction: friction, damping, ..CoupledParameters::default() })
            .unwrap()
    }

    fn process(std: f64) -> FrictionProcess {
        FrictionProcess::new(ProcessModel::new("normal".parse().unwrap(), std, 0.5)).unwrap()
    }

    fn settings(trajectories: usize, threshold: f64) -> CoupledEnsembleSettings {
        CoupledEnsembleSettings {
            trajectories,
            duration: 400.0,
            threshold,
            seed: 11,
            start: None,
            least_valid_share: 1.0,
        }
    }

    #[test]
    fn without_fluctuation_an_ensemble_is_its_limit_cycle() {
        let model = model(0.9);
        let cycle = *limit_cycle(&model, None).unwrap().cycle().unwrap();
        let settings = CoupledEnsembleSettings { start: Some(cycle.start), ..settings(4, 0.05) };
        let found = CoupledEnsemble::simulate(&model, &process(1e-14), &settings, &Silent).unwrap();
        let rest = model.steady(0.9).unwrap().tangential;
        let amplitude = (cycle.tangential[1] - rest).max(rest - cycle.tangential[0]);
        assert!((found.amplitude.mean - amplitude).abs() < 1e-10, "{} {amplitude}", found.amplitude.mean);
        assert_eq!((found.passed, found.sustained), (1.0, 1.0));
        assert!((found.passage_time.unwrap().mean - found.deterministic.passage.unwrap()).abs() < 1e-9);
        // The duration is not a whole number of periods.
        let difference = found.flight_share.mean - cycle.flight_share;
        assert!(difference.abs() < cycle.period / settings.duration, "{difference}");
    }

    #[test]
    fn the_first_passage_follows_the_growth_rate() {
        // In linear growth the time from a to A is ln(A/a)/growth; both thresholds lie in the linear range.
        let model = model(0.85);
        let growth = super::super::modes(&model, 0.85)[0].growth.max(super::super::modes(&model, 0.85)[1].growth);
        let passage = |threshold: f64| {
            CoupledEnsemble::simulate(&model, &process(1e-13), &settings(2, threshold), &Silent)
                .unwrap()
                .deterministic
                .passage
        };
        let (early, late) = (passage(0.02).unwrap(), passage(0.08).unwrap());
        // Amplitudes are evaluated at extremes of x, so times are known to half a period.
        assert!(((late - early) - 4.0_f64.ln() / growth).abs() < 2.5, "{early} {late}");
    }

    #[test]
    fn results_do_not_depend_on_threads_and_noise_excites_a_stable_mass() {
        let model = model(0.7);
        let run = |threads: usize, std: f64| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| CoupledEnsemble::simulate(&model, &process(std), &settings(40, 0.05), &Silent).unwrap())
        };
        let one = run(1, 0.02);
        assert_eq!(one, run(2, 0.02));
        let (weak, strong) = (run(2, 0.002), run(2, 0.02));
        assert!(weak.passed < strong.passed && weak.sustained == 0.0, "{weak:?} {strong:?}");
        // Small motion is linear in the fluctuation.
        let ratio = strong.amplitude.mean / weak.amplitude.mean;
        assert!((ratio / 10.0 - 1.0).abs() < 0.15, "{ratio}");
    }

    #[test]
    fn invalid_settings_and_too_many_failures_are_errors() {
        let (model, process) = (model(0.8), process(0.3));
        assert!(matches!(
            CoupledEnsemble::simulate(&model, &process, &settings(8, 0.1), &Silent),
            Err(VibrationError::TooFewValid { .. })
        ));
        for settings in
            [settings(1, 0.1), settings(4, 0.0), CoupledEnsembleSettings { duration: -1.0, ..settings(4, 0.1) }]
        {
            assert!(CoupledEnsemble::simulate(&model, &process, &settings, &Silent).is_err());
        }
    }
}
