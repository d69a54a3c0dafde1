//! Ensembles of trajectories and their statistics.

mod passage;
mod rate;

use std::f64::consts::TAU;
use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::passage::Passage;
pub use self::rate::{Estimate, Passages};
use super::batch::{Task, simulate_many};
use super::sample_distribution::{Count, RunningMoments, SampleCollector, SampleDistribution};
use super::settled::swing_level;
use super::trajectory::{NoObserver, follow};
use super::{Drive, Oscillator, Slips, TrajectorySettings, VibrationError};
use asperity_base::blocks::{self, Loop};
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_base::stats::{VALID_FRACTION, student_95};
use asperity_process::{Cancellable, FrictionProcess, Steady};

/// Number of trajectories per block.
const BLOCK: usize = 32;

/// Settings of an ensemble.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnsembleSettings {
    /// Number of trajectories, at least 2.
    pub trajectories: usize,
    /// Duration τ of each trajectory.
    pub duration: f64,
    /// Seed; trajectory i reads realisation i of the process.
    pub seed: u64,
    /// Displacement X at τ = 0; [`Oscillator::default_start`] if none.
    pub start: Option<f64>,
    /// Independent variable of the friction process.
    pub drive: Drive,
    /// Number of values of each distribution that are kept for histograms and tests. Each kept value takes 24 bytes
    /// during the computation and 8 in the result; each trajectory in progress keeps at most as many.
    pub sample_capacity: usize,
    /// Least fraction of valid trajectories; two must be valid in any case.
    pub least_valid_share: f64,
}

impl EnsembleSettings {
    /// Creates settings with the sliding distance as drive, the default start, up to 65,536 kept values and at least 95
    /// % valid trajectories.
    pub fn new(trajectories: usize, duration: f64, seed: u64) -> Self {
        Self {
            trajectories,
            duration,
            seed,
            start: None,
            drive: Drive::default(),
            sample_capacity: 65_536,
            least_valid_share: VALID_FRACTION,
        }
    }
}

/// Bytes per kept value, and number of distributions with kept values: re-attachments, releases, periods.
const VALUE_BYTES: f64 = 24.0;
const DISTRIBUTIONS: f64 = 3.0;

impl EnsembleSettings {
    /// Returns an approximate upper bound of the memory of the samples of a number of trajectories in bytes. It assumes one
    /// slip per natural period; each distribution keeps at most `sample_capacity` values.
    fn samples_bytes(&self, trajectories: usize) -> f64 {
        let values = self.duration / TAU * trajectories as f64;
        VALUE_BYTES * DISTRIBUTIONS * values.min(self.sample_capacity as f64)
    }

    /// Returns an approximate upper bound of the memory of a block in bytes: each trajectory keeps its own samples.
    fn block_bytes(&self) -> f64 {
        self.samples_bytes(1) * BLOCK as f64
    }

    /// Returns an approximate upper bound of the memory of an ensemble in bytes.
    pub fn memory_bytes(&self, threads: usize) -> f64 {
        let waiting = blocks::at_once(self.block_bytes() as usize, threads).min(self.trajectories.div_ceil(BLOCK));
        self.block_bytes() * waiting as f64 + self.samples_bytes(self.trajectories)
    }
}

/// Trajectory that was left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FailedTrajectory {
    /// Index of the trajectory.
    pub trajectory: usize,
    /// Reason of the failure.
    pub reason: String,
}

/// Statistics of many trajectories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ensemble {
    /// Number of requested trajectories.
    pub trajectories: usize,
    /// Finished slips per trajectory that reached a negative velocity.
    pub cycles: Count,
    /// Other finished slips per trajectory.
    pub micro_slips: Count,
    /// Number of cycles of the same oscillator without fluctuation in the same time.
    pub cycles_deterministic: u64,
    /// Difference of the numbers of cycles without and with fluctuation.
    pub difference_mean: f64,
    /// 95 % interval of `difference_mean` (Student).
    pub difference_interval: [f64; 2],
    /// Displacements X at which cycles stick again.
    pub reattachments: SampleDistribution,
    /// Displacements X at which the mass leaves the belt, except the first one of each trajectory.
    pub releases: SampleDistribution,
    /// Times τ from the start of a cycle to the start of the next, unless vibration is lost in between. The mean is the
    /// period, the standard deviation its jitter. A cycle starts with a detachment or where over-slip ends without
    /// stick.
    pub periods: SampleDistribution,
    /// Fraction of the time in stick, per trajectory.
    pub stick_share: Count,
    /// Vibration over time: exits, entries and fractions of the time.
    pub passages: Passages,
    /// Trajectories that failed.
    pub failures: Vec<FailedTrajectory>,
}

/// Result of one trajectory.
#[derive(Serialize, Deserialize)]
struct Outcome {
    slips: Slips,
    passage: Passage,
}

/// Properties that all trajectories of an ensemble have in common.
struct Plan<'a> {
    oscillator: &'a Oscillator,
    process: &'a FrictionProcess,
    settings: &'a EnsembleSettings,
    followed: TrajectorySettings,
    swing_level: f64,
    cycles_deterministic: u64,
}

impl<'a> Plan<'a> {
    /// Checks the settings and follows the motion without fluctuation.
    fn new(
        oscillator: &'a Oscillator,
        process: &'a FrictionProcess,
        settings: &'a EnsembleSettings,
        monitor: &dyn Monitor,
    ) -> Result<Self, VibrationError> {
        if settings.trajectories < 2 {
            let value = settings.trajectories as f64;
            return Err(VibrationError::Parameter { parameter: "trajectories", value, wanted: "at least 2" });
        }
        if !(0.0..=1.0).contains(&settings.least_valid_share) {
            let value = settings.least_valid_share;
            return Err(VibrationError::Parameter { parameter: "least_valid_share", value, wanted: "in 0 … 1" });
        }
        let EnsembleSettings { duration, start, drive, .. } = *settings;
        let followed = TrajectorySettings { duration, start, drive };
        let cycles_deterministic =
            follow(oscillator, Steady, &followed, f64::INFINITY, monitor, &mut NoObserver)?.cycles;
        let swing_level = swing_level(oscillator);
        Ok(Self { oscillator, process, settings, followed, swing_level, cycles_deterministic })
    }

    /// Simulates the trajectories of a block, one step of the task each.
    fn block(
        &self,
        block: Range<usize>,
        monitor: &dyn Monitor,
        task: &blocks::Task<'_>,
    ) -> Vec<Result<Outcome, String>> {
        let mut outcomes: Vec<_> = block.clone().map(|_| Err(Cancelled.to_string())).collect();
        simulate_many(
            &self.followed,
            block.clone(),
            |index| {
                if monitor.cancelled() {
                    return Err(Cancelled.into());
                }
                let fluctuation = Cancellable::new(self.process.path(self.settings.seed, index as u64), monitor);
                let passage = Passage::new(index, self.settings.duration, self.settings.sample_capacity);
                Ok(Task::new(self.oscillator.clone(), fluctuation, passage).with_swing_level(self.swing_level))
            },
            |index, ended| {
                outcomes[index - block.start] = ended.map_err(|error| error.to_string()).map(|mut followed| {
                    followed.observer.finish();
                    Outcome { slips: followed.slips, passage: followed.observer }
                });
                task.advance(1);
            },
        );
        outcomes
    }
}

/// Sums over the trajectories, in their order.
struct Reduction {
    cycles: RunningMoments,
    micro_slips: RunningMoments,
    stick_share: RunningMoments,
    reattachments: SampleCollector,
    releases: SampleCollector,
    periods: SampleCollector,
    passages: Passages,
    failures: Vec<FailedTrajectory>,
}

impl Reduction {
    fn new(settings: &EnsembleSettings) -> Self {
        let collector = || SampleCollector::new(0, settings.sample_capacity);
        Self {
            cycles: RunningMoments::EMPTY,
            micro_slips: RunningMoments::EMPTY,
            stick_share: RunningMoments::EMPTY,
            reattachments: collector(),
            releases: collector(),
            periods: collector(),
            passages: Passages::EMPTY,
            failures: Vec::new(),
        }
    }

    fn add(&mut self, trajectory: usize, outcome: Result<Outcome, String>, duration: f64) {
        match outcome {
            Ok(Outcome { slips, passage }) => {
                self.cycles.add(slips.cycles as f64);
                self.micro_slips.add(slips.micro_slips as f64);
                self.stick_share.add(passage.stick / duration);
                self.passages.add(&passage, duration);
                self.reattachments.merge(passage.reattachments);
                self.releases.merge(passage.releases);
                self.periods.merge(passage.periods);
            }
            Err(reason) => self.failures.push(FailedTrajectory { trajectory, reason }),
        }
    }

    /// Fails if too few trajectories are valid.
    fn finish(mut self, plan: &Plan<'_>) -> Result<Ensemble, VibrationError> {
        let (total, wanted) = (plan.settings.trajectories, plan.settings.least_valid_share);
        let valid = total - self.failures.len();
        let are_too_few = valid < 2 || (valid as f64) < wanted * total as f64;
        if let Some(first) = self.failures.first().filter(|_| are_too_few) {
            return Err(VibrationError::TooFewValid { valid, total, wanted, first: first.reason.clone() });
        }
        self.passages.finish();
        let (cycles, cycles_deterministic) = (Count::from_moments(&self.cycles), plan.cycles_deterministic);
        let difference_mean = cycles_deterministic as f64 - cycles.mean;
        let half_width = student_95(valid) * cycles.se;
        Ok(Ensemble {
            trajectories: total,
            cycles,
            micro_slips: Count::from_moments(&self.micro_slips),
            cycles_deterministic,
            difference_mean,
            difference_interval: [difference_mean - half_width, difference_mean + half_width],
            reattachments: self.reattachments.finish(),
            releases: self.releases.finish(),
            periods: self.periods.finish(),
            stick_share: Count::from_moments(&self.stick_share),
            passages: self.passages,
            failures: self.failures,
        })
    }
}

impl Ensemble {
    /// Simulates many trajectories in parallel.
    ///
    /// The result does not depend on the number of threads: trajectories are computed in blocks and added up in order.
    /// `sample_capacity` bounds the values of each.
    ///
    /// Fails if settings are out of range, if the motion without fluctuation is invalid, if too few trajectories are
    /// valid, or when cancelled.
    pub fn simulate(
        oscillator: &Oscillator,
        process: &FrictionProcess,
        settings: &EnsembleSettings,
        monitor: &dyn Monitor,
    ) -> Result<Self, VibrationError> {
        let plan = Plan::new(oscillator, process, settings, monitor)?;
        let total = settings.trajectories;
        let task = blocks::Task::new(monitor, "trajectories", total);
        let chunks = Loop {
            count: total.div_ceil(BLOCK),
            block_bytes: settings.block_bytes() as usize,
            steps: BLOCK,
            failure: |outcomes: &Vec<Result<Outcome, String>>| outcomes.iter().find_map(|o| o.as_ref().err().cloned()),
        };
        let block = |(): &mut (), index: usize| -> Result<_, Cancelled> {
            Ok(plan.block(index * BLOCK..total.min((index + 1) * BLOCK), monitor, &task))
        };
        let mut reduction = Reduction::new(settings);
        task.reduce(
            &chunks,
            || (),
            block,
            |index, outcomes| {
                for (trajectory, outcome) in (index * BLOCK..).zip(outcomes) {
                    reduction.add(trajectory, outcome, settings.duration);
                }
            },
        )?;
        reduction.finish(&plan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Coulomb, Exponential, Stribeck};
    use crate::{Forcing, FrictionTable, Parameters, VelocityLaw};
    use asperity_base::monitor::Silent;
    use asperity_process::ProcessModel;
    use asperity_testing::{AlwaysCancelled, covered, least_coverage, repetitions};

    fn paper_process(std: f64) -> FrictionProcess {
        FrictionProcess::new(ProcessModel::new("beta:2.1,5".parse().unwrap(), std, 0.01)).unwrap()
    }

    fn oscillator(damping: f64) -> Oscillator {
        Oscillator::with_stribeck(0.1, 4.2, damping, 0.003).unwrap()
    }

    #[test]
    fn cycle_counts_match_the_publication() {
        // Means and standard errors of 4,000 trajectories; the standard errors of 200 trajectories are √20 times
        // larger.
        let published =
            [(0.17, 68.99, 0.10, 99), (0.2048301, 45.21, 0.11, 101), (0.22, 34.31, 0.11, 0), (0.25, 17.18, 0.08, 0)];
        let process = paper_process(0.001);
        for (damping, mean, se, deterministic) in published {
            let settings = EnsembleSettings::new(200, 637.2, 1);
            let found = Ensemble::simulate(&oscillator(damping), &process, &settings, &Silent).unwrap();
            assert_eq!(found.cycles_deterministic, deterministic);
            assert!(found.failures.is_empty());
            let spread = found.cycles.se.hypot(se);
            assert!((found.cycles.mean - mean).abs() < 4.0 * spread, "damping {damping}: {:?}", found.cycles);
            assert!((found.cycles.se / (se * 20.0_f64.sqrt()) - 1.0).abs() < 0.3);
            assert_eq!(found.difference_mean, deterministic as f64 - found.cycles.mean);
        }
    }

    #[test]
    fn negative_friction_is_recorded_and_too_many_failures_are_refused() {
        // The least m is −1.844 σ; in some trajectories friction falls below zero at the speeds of this noise.
        let process = paper_process(0.05);
        let settings = EnsembleSettings { least_valid_share: 0.0, ..EnsembleSettings::new(60, 50.0, 3) };
        let found = Ensemble::simulate(&oscillator(0.17), &process, &settings, &Silent).unwrap();
        assert!(!found.failures.is_empty() && found.failures.len() < 60, "{} failures", found.failures.len());
        assert!(found.failures.iter().all(|f| f.reason.contains("must stay positive")));
        let strict = EnsembleSettings { least_valid_share: 1.0, ..settings };
        let refused = Ensemble::simulate(&oscillator(0.17), &process, &strict, &Silent);
        assert!(matches!(refused, Err(VibrationError::TooFewValid { total: 60, .. })));
        // One valid trajectory has no standard error.
        let of_two = |seed: u64| {
            let settings = EnsembleSettings { least_valid_share: 0.0, ..EnsembleSettings::new(2, 50.0, seed) };
            Ensemble::simulate(&oscillator(0.17), &process, &settings, &Silent)
        };
        assert!((0..20).any(|seed| matches!(of_two(seed), Err(VibrationError::TooFewValid { valid: 1, .. }))));
        // With a clipping limit all trajectories are valid.
        let model = ProcessModel { least: Some(-0.04), ..process.model().clone() };
        let clamped = FrictionProcess::new(model).unwrap();
        let found = Ensemble::simulate(&oscillator(0.17), &clamped, &strict, &Silent).unwrap();
        assert!(found.failures.is_empty());
    }

    #[test]
    #[ignore = "slow"]
    fn rough_noise_and_strong_forcing_neither_stall_nor_fail() {
        // Slopes dm/ds far above 1 cause many short slips; a clipping limit keeps friction positive.
        let model =
            ProcessModel { least: Some(-0.01), ..ProcessModel::new("beta:0.6,2".parse().unwrap(), 0.02, 0.002) };
        let process = FrictionProcess::new(model).unwrap();
        for drive in [Drive::Distance, Drive::Time] {
            for law in [
                VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 }),
                VelocityLaw::Stribeck(Stribeck { kinetic: 0.08, decay: 2.0 }),
                VelocityLaw::Coulomb(Coulomb { kinetic: 0.1 }),
                VelocityLaw::Exponential(Exponential { kinetic: 0.1, high_speed: 0.08, stribeck_velocity: 0.02 }),
                VelocityLaw::Tabulated(
                    FrictionTable::new(&[[0.0, 0.1], [0.01, 0.09], [0.03, 0.08], [0.05, 0.085]]).unwrap(),
                ),
            ] {
                for amplitude in [0.0, 0.02, 0.3] {
                    let parameters = Parameters {
                        static_friction: 0.1,
                        law: law.clone(),
                        damping_ratio: 0.1,
                        belt_velocity: 0.01,
                        forcing: Some(Forcing { amplitude, frequency: 0.9 }),
                    };
                    let oscillator = Oscillator::new(parameters.clone()).unwrap();
                    let settings = EnsembleSettings { drive, ..EnsembleSettings::new(6, 60.0, 4) };
                    let found = Ensemble::simulate(&oscillator, &process, &settings, &Silent).unwrap();
                    assert!(found.failures.is_empty(), "{parameters:?}: {:?}", found.failures[0]);
                    // A strong force carries the mass through the belt velocity without stick, so no slip ends.
                    assert!(found.cycles.mean > 3.0 || amplitude > 0.1, "{parameters:?}: {:?}", found.cycles);
                }
            }
        }
    }

    #[test]
    #[ignore = "slow"]
    fn intervals_of_an_ensemble_cover_the_means_of_many_trajectories() {
        let process = paper_process(0.002);
        let simulate = |trajectories, seed| {
            let settings = EnsembleSettings::new(trajectories, 150.0, seed);
            Ensemble::simulate(&oscillator(0.19), &process, &settings, &Silent).unwrap()
        };
        let truth = simulate(20_000, 1);
        let rate = truth.passages.exit_rate.unwrap().value;
        let holds = |[low, high]: [f64; 2], value: f64| usize::from(low <= value && value <= high);
        for trajectories in [8, 20, 100] {
            let repeats = repetitions(50);
            let mut held = [0; 4];
            for seed in 0..repeats {
                let found = simulate(trajectories, seed as u64 + 2);
                held[0] += holds(found.difference_interval, truth.difference_mean);
                held[1] += holds(found.passages.left.interval, truth.passages.left.value);
                held[2] += holds(found.passages.sustained.interval, truth.passages.sustained.value);
                held[3] += holds(found.passages.exit_rate.unwrap().interval, rate);
            }
            let kinds =
                ["cycles lost", "fraction that left vibration", "fraction in vibration at the end", "rate of exits"];
            for (kind, held) in kinds.into_iter().zip(held) {
                let fraction = covered(kind, &format!("{trajectories} trajectories"), held, repeats);
                assert!(fraction >= least_coverage(repeats), "{kind}, {trajectories}: {fraction}");
            }
        }
    }

    #[test]
    fn a_cancelled_ensemble_is_an_error() {
        let settings = EnsembleSettings::new(10, 60.0, 5);
        let result = Ensemble::simulate(&oscillator(0.17), &paper_process(0.001), &settings, &AlwaysCancelled);
        assert_eq!(result, Err(VibrationError::Cancelled(Cancelled)));
    }
}
