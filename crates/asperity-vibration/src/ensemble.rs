//! Many trajectories, and the law of what they count.

mod passage;
mod rate;

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::passage::Passage;
pub use self::rate::{Passages, Rate, Share};
use super::lanes::{Task, follow_many};
use super::sample_law::{Gathering, RunningMoments, SampleLaw};
use super::trajectory::{NoObserver, follow};
use super::{Drive, Method, Oscillator, Slips, TrajectorySettings, VibrationError, swing_level};
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_base::stats::NORMAL_95;
use asperity_process::{FrictionProcess, Steady, Watched};

/// Trajectories computed before their results are added up, and the time τ of all of them beyond which they are fewer: both bound
/// the memory.
const BLOCK: usize = 1024;
const BLOCK_TIME: f64 = 1e7;
/// Trajectories that one thread takes at a time.
const CHUNK: usize = 32;

/// How an ensemble is computed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnsembleSettings {
    /// Number of trajectories, at least 2.
    pub trajectories: usize,
    /// Time τ of each.
    pub duration: f64,
    /// Seed; trajectory i reads realisation i of the process.
    pub seed: u64,
    /// Displacement X at τ = 0; none: [`Oscillator::default_start`].
    pub start: Option<f64>,
    /// What the friction process is a function of.
    pub drive: Drive,
    /// How slip is integrated. Taylor series follow many trajectories at once; the others are for comparison.
    #[serde(default)]
    pub method: Method,
    /// Values of each law that are kept for histograms and tests; 8 bytes each at the end, 24 on the way, and as many of each
    /// trajectory that is followed, if it has them.
    pub sample_capacity: usize,
    /// Least share of valid trajectories.
    pub least_valid_share: f64,
}

impl EnsembleSettings {
    /// Settings with the sliding distance as drive, the default start, up to 65,536 kept points, and 95 % to be valid.
    pub fn new(trajectories: usize, duration: f64, seed: u64) -> Self {
        Self {
            trajectories,
            duration,
            seed,
            start: None,
            drive: Drive::default(),
            method: Method::default(),
            sample_capacity: 65_536,
            least_valid_share: 0.95,
        }
    }
}

/// Memory of a kept value, and the laws of which values are kept: re-attachments, releases, periods.
const VALUE_BYTES: f64 = 24.0;
const LAWS: f64 = 3.0;

impl EnsembleSettings {
    /// Trajectories computed before their results are added up.
    fn block(&self, threads: usize) -> usize {
        let least = CHUNK * threads.clamp(1, BLOCK / CHUNK);
        ((BLOCK_TIME / self.duration) as usize).clamp(least, BLOCK)
    }

    /// Memory in byte that an ensemble takes at most, roughly: a slip takes a natural period or so, and of no trajectory more
    /// values are kept than of all.
    pub fn memory_bytes(&self, threads: usize) -> f64 {
        let values = (self.duration / TAU).min(self.sample_capacity as f64);
        VALUE_BYTES * LAWS * (values * self.trajectories.min(self.block(threads)) as f64 + self.sample_capacity as f64)
    }
}

/// Mean and spread of a count over trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Count {
    /// Mean.
    pub mean: f64,
    /// Standard deviation over trajectories, divisor n − 1.
    pub std: f64,
    /// Standard error of the mean.
    pub se: f64,
}

impl Count {
    fn of(sums: &RunningMoments) -> Self {
        Self { mean: sums.mean(), std: sums.std(), se: sums.std() / (sums.count() as f64).sqrt() }
    }
}

/// A trajectory that was left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Its index.
    pub trajectory: usize,
    /// Why.
    pub reason: String,
}

/// The law of many trajectories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ensemble {
    /// Trajectories asked for.
    pub trajectories: usize,
    /// Finished slips that reached ẋ < 0, per trajectory; see [`Slips`].
    pub cycles: Count,
    /// Finished slips that did not, per trajectory.
    pub micro_slips: Count,
    /// Cycles of the same oscillator without fluctuation in the same time.
    pub cycles_deterministic: u64,
    /// M_diff = M_det − E\[M\] of the cycles.
    pub difference_mean: f64,
    /// 95 % interval of M_diff.
    pub difference_interval: [f64; 2],
    /// Displacements X at which cycles stick again.
    pub reattachments: SampleLaw,
    /// Displacements X at which the mass leaves the belt, but for the first time.
    pub releases: SampleLaw,
    /// Times τ from the beginning of a cycle to that of the next, as long as vibration is not lost between: their mean is the
    /// period and their standard deviation its jitter. A cycle begins with a detachment, or where over-slip ends without stick.
    pub periods: SampleLaw,
    /// Share of the time in stick, per trajectory.
    pub stick_share: Count,
    /// Vibration over time, and the ways out of it and back.
    pub passages: Passages,
    /// Trajectories without a valid end.
    pub failures: Vec<Failure>,
}

/// What one trajectory leaves.
struct Outcome {
    slips: Slips,
    passage: Passage,
}

impl Ensemble {
    /// Follows many trajectories in parallel.
    ///
    /// The result does not depend on the number of threads: trajectories are computed in blocks of up to 1,024 and added up in
    /// their order. Memory is bounded by the points of one block, and of one trajectory by `sample_capacity`.
    ///
    /// Fails if settings are out of range, if the motion without fluctuation is invalid, if too few trajectories are valid,
    /// and when cancelled.
    pub fn simulate(
        oscillator: &Oscillator,
        process: &FrictionProcess,
        settings: &EnsembleSettings,
        monitor: &dyn Monitor,
    ) -> Result<Self, VibrationError> {
        let total = settings.trajectories;
        if total < 2 {
            let value = total as f64;
            return Err(VibrationError::Parameter { parameter: "trajectories", value, wanted: "at least 2" });
        }
        if !(0.0..=1.0).contains(&settings.least_valid_share) {
            let value = settings.least_valid_share;
            return Err(VibrationError::Parameter { parameter: "least_valid_share", value, wanted: "in 0 … 1" });
        }
        let EnsembleSettings { duration, start, drive, method, .. } = *settings;
        let followed = TrajectorySettings { duration, start, drive, method };
        let cycles_deterministic =
            follow(oscillator, Steady, &followed, f64::INFINITY, monitor, &mut NoObserver)?.cycles;
        let swing_level = swing_level(oscillator);
        let (mut cycles, mut micro_slips) = (RunningMoments::EMPTY, RunningMoments::EMPTY);
        let mut stick_share = RunningMoments::EMPTY;
        let [mut reattachments, mut releases, mut periods] =
            [(); 3].map(|()| Gathering::new(0, settings.sample_capacity));
        let mut passages = Passages::EMPTY;
        let mut failures = Vec::new();
        let finished = AtomicUsize::new(0);
        let size = settings.block(rayon::current_num_threads());
        for first in (0..total).step_by(size) {
            let block = first..total.min(first + size);
            let chunks: Vec<Range<usize>> =
                block.clone().step_by(CHUNK).map(|start| start..block.end.min(start + CHUNK)).collect();
            let outcomes: Vec<Result<Outcome, VibrationError>> = chunks
                .into_par_iter()
                .flat_map_iter(|chunk| {
                    let mut outcomes: Vec<_> = chunk.clone().map(|_| Err(Cancelled.into())).collect();
                    follow_many(
                        &followed,
                        chunk.clone(),
                        |index| {
                            if monitor.cancelled() {
                                return Err(Cancelled.into());
                            }
                            let fluctuation = Watched::new(process.path(settings.seed, index as u64), monitor);
                            let passage = Passage::new(index, duration, settings.sample_capacity);
                            Ok(Task::new(oscillator.clone(), fluctuation, passage).with_swing_level(swing_level))
                        },
                        |index, ended| {
                            outcomes[index - chunk.start] = ended.map(|mut followed| {
                                followed.observer.finish();
                                Outcome { slips: followed.slips, passage: followed.observer }
                            });
                            monitor.progress("trajectories", finished.fetch_add(1, Ordering::Relaxed) + 1, total);
                        },
                    );
                    outcomes
                })
                .collect();
            for (trajectory, outcome) in (first..).zip(outcomes) {
                match outcome {
                    Ok(outcome) => {
                        cycles.add(outcome.slips.cycles as f64);
                        micro_slips.add(outcome.slips.micro_slips as f64);
                        stick_share.add(outcome.passage.stick / duration);
                        passages.add(&outcome.passage, duration);
                        reattachments.merge(outcome.passage.reattachments);
                        releases.merge(outcome.passage.releases);
                        periods.merge(outcome.passage.periods);
                    }
                    // Whatever a path ended in then, it was not followed to its end.
                    Err(_) if monitor.cancelled() => return Err(Cancelled.into()),
                    Err(error) => failures.push(Failure { trajectory, reason: error.to_string() }),
                }
            }
        }
        let valid = total - failures.len();
        if let Some(first) = failures.first().filter(|_| (valid as f64) < settings.least_valid_share * total as f64) {
            let (wanted, first) = (settings.least_valid_share, first.reason.clone());
            return Err(VibrationError::TooFewValid { valid, total, wanted, first });
        }
        passages.conclude();
        let cycles = Count::of(&cycles);
        let difference_mean = cycles_deterministic as f64 - cycles.mean;
        let half_width = NORMAL_95 * cycles.se;
        Ok(Self {
            trajectories: total,
            cycles,
            micro_slips: Count::of(&micro_slips),
            cycles_deterministic,
            difference_mean,
            difference_interval: [difference_mean - half_width, difference_mean + half_width],
            reattachments: reattachments.finish(),
            releases: releases.finish(),
            periods: periods.finish(),
            stick_share: Count::of(&stick_share),
            passages,
            failures,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Forcing, FrictionLaw, FrictionTable, Parameters};
    use asperity_base::monitor::Silent;
    use asperity_process::ProcessModel;

    fn paper_process(std: f64) -> FrictionProcess {
        FrictionProcess::new(ProcessModel::new("beta:2.1,5".parse().unwrap(), std, 0.01)).unwrap()
    }

    fn oscillator(damping: f64) -> Oscillator {
        Oscillator::stribeck(0.1, 4.2, damping, 0.003).unwrap()
    }

    #[test]
    fn cycle_counts_are_the_published_ones() {
        // Means and standard errors of 4,000 paths; ours of 200 have √20 times that.
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
    fn one_thread_and_many_give_the_same_bits() {
        let process = paper_process(0.001);
        let settings = EnsembleSettings { sample_capacity: 50, ..EnsembleSettings::new(40, 60.0, 5) };
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Ensemble::simulate(&oscillator(0.17), &process, &settings, &Silent)).unwrap()
        };
        let (one, many) = (with(1), with(4));
        assert_eq!(one, many);
        assert_eq!(one.reattachments.sample.len(), 50);
    }

    #[test]
    fn friction_that_loses_its_sign_is_recorded_and_too_much_of_it_refused() {
        // The least m is −1.844 σ, below the law at the speeds of this noise in some trajectories.
        let process = paper_process(0.05);
        let settings = EnsembleSettings { least_valid_share: 0.0, ..EnsembleSettings::new(60, 50.0, 3) };
        let found = Ensemble::simulate(&oscillator(0.17), &process, &settings, &Silent).unwrap();
        assert!(!found.failures.is_empty() && found.failures.len() < 60, "{} failures", found.failures.len());
        assert!(found.failures.iter().all(|f| f.reason.contains("must stay positive")));
        let strict = EnsembleSettings { least_valid_share: 1.0, ..settings };
        let refused = Ensemble::simulate(&oscillator(0.17), &process, &strict, &Silent);
        assert!(matches!(refused, Err(VibrationError::TooFewValid { total: 60, .. })));
        // With a stated clamp all are valid.
        let model = ProcessModel { least: Some(-0.04), ..process.model().clone() };
        let clamped = FrictionProcess::new(model).unwrap();
        let found = Ensemble::simulate(&oscillator(0.17), &clamped, &strict, &Silent).unwrap();
        assert!(found.failures.is_empty());
    }

    #[test]
    fn rough_noise_and_strong_forcing_neither_stall_nor_fail() {
        // Slopes dm/ds far beyond one make many short slips; a clamp keeps friction positive.
        let model =
            ProcessModel { least: Some(-0.01), ..ProcessModel::new("beta:0.6,2".parse().unwrap(), 0.02, 0.002) };
        let process = FrictionProcess::new(model).unwrap();
        for drive in [Drive::Distance, Drive::Time] {
            for law in [
                FrictionLaw::Stribeck { kinetic: 0.1, decay: 4.2 },
                FrictionLaw::Stribeck { kinetic: 0.08, decay: 2.0 },
                FrictionLaw::Coulomb { kinetic: 0.1 },
                FrictionLaw::Exponential { kinetic: 0.1, high_speed: 0.08, stribeck_velocity: 0.02 },
                FrictionLaw::Tabulated(
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
                    // A strong force carries the mass through the belt velocity without stick: no slip ends.
                    assert!(found.cycles.mean > 3.0 || amplitude > 0.1, "{parameters:?}: {:?}", found.cycles);
                }
            }
        }
    }

    #[test]
    fn a_cancelled_ensemble_says_so() {
        struct Stop;
        impl Monitor for Stop {
            fn progress(&self, _: &str, _: usize, _: usize) {}
            fn cancelled(&self) -> bool {
                true
            }
        }
        let settings = EnsembleSettings::new(10, 60.0, 5);
        let result = Ensemble::simulate(&oscillator(0.17), &paper_process(0.001), &settings, &Stop);
        assert_eq!(result, Err(VibrationError::Cancelled(Cancelled)));
    }
}
