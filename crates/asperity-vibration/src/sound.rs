//! Loudness and spectrum of the vibration.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::{
    MotionKind, Oscillator, TrajectorySettings, VibrationError, cycle_portrait, limit_cycle, positive,
    trajectory_portrait,
};
use asperity_base::blocks::Task;
use asperity_base::correlation::{RecordEnds, record_spectrum};
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_base::stats::{Moments, student_95};
use asperity_process::{Cancellable, FrictionProcess};

/// Number of points of the limit cycle for its mean square velocity.
const CYCLE_POINTS: usize = 8193;

/// Settings of the recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoundSettings {
    /// Number of recorded trajectories, at least 2; they are the first ones of the ensemble.
    pub trajectories: usize,
    /// Number of values per natural period 2π, at least 4.
    pub points_per_period: usize,
    /// Time τ before the recording starts.
    pub from: f64,
    /// Seed; trajectory i reads realisation i of the process, as in an ensemble.
    pub seed: u64,
    /// Settings of each trajectory.
    pub followed: TrajectorySettings,
}

/// Level and spectrum of the velocity X′ of a mass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sound {
    /// Kind of motion without fluctuation.
    pub kind: MotionKind,
    /// Root mean square of the deviation of the velocity from its mean.
    pub velocity_rms: f64,
    /// 95 % interval of the root mean square, from its spread over trajectories (Student).
    pub velocity_rms_interval: [f64; 2],
    /// Root mean square velocity of the limit cycle without fluctuation, if there is one.
    pub cycle_velocity_rms: Option<f64>,
    /// Level of the velocity relative to the limit cycle, 20 lg(rms/rms of the cycle), in dB.
    pub level_db: Option<f64>,
    /// 95 % interval of the level.
    pub level_db_interval: Option<[f64; 2]>,
    /// Frequencies ω/ω₀ of the bins, which are a sixth of an octave wide, or as wide as the resolution of the records.
    pub frequency: Vec<f64>,
    /// One-sided power spectral density of X′ over ω/ω₀. Its integral is the variance.
    pub density: Vec<f64>,
    /// Lower end of the 95 % band of the density.
    pub density_low: Vec<f64>,
    /// Upper end of the 95 % band of the density.
    pub density_high: Vec<f64>,
}

impl Sound {
    /// Records the velocity of several trajectories.
    ///
    /// Fails if settings are out of range, if a trajectory fails, or when cancelled.
    pub fn record(
        oscillator: &Oscillator,
        process: &FrictionProcess,
        settings: &SoundSettings,
        monitor: &dyn Monitor,
    ) -> Result<Self, VibrationError> {
        let refused = |parameter, value, wanted| Err(VibrationError::Parameter { parameter, value, wanted });
        if settings.trajectories < 2 {
            return refused("recorded trajectories", settings.trajectories as f64, "at least 2");
        }
        if settings.points_per_period < 4 {
            return refused("points per period", settings.points_per_period as f64, "at least 4");
        }
        positive("duration", settings.followed.duration)?;
        let step = TAU / settings.points_per_period as f64;
        let points = ((settings.followed.duration - settings.from) / step).floor();
        if !(settings.from >= 0.0 && points >= 64.0) {
            return refused("from", settings.from, "earlier than 64 values before the end");
        }
        let points = points as usize + 1;
        let followed = TrajectorySettings { duration: settings.from + step * (points - 1) as f64, ..settings.followed };
        let task = Task::new(monitor, "paths", settings.trajectories);
        let records = task.map(settings.trajectories, |index| -> Result<Vec<f64>, VibrationError> {
            let path = Cancellable::new(process.path(settings.seed, index as u64), monitor);
            let portrait = trajectory_portrait(oscillator, path, &followed, settings.from, points)
                .map_err(|error| if monitor.cancelled() { Cancelled.into() } else { error })?;
            Ok(portrait.iter().map(|point| point.velocity).collect())
        })?;
        let squares: Vec<f64> = records.iter().map(|record| Moments::new(record).std.powi(2)).collect();
        let moments = Moments::new(&squares);
        let half_width = student_95(moments.n) * moments.standard_error();
        let root = |square: f64| square.max(0.0).sqrt();
        let velocity_rms = root(moments.mean);
        let velocity_rms_interval = [root(moments.mean - half_width), root(moments.mean + half_width)];
        let cycle_velocity_rms = cycle_rms(oscillator)?;
        let level = |rms: f64| cycle_velocity_rms.map(|cycle| 20.0 * (rms / cycle).log10());
        let level_db_interval =
            level(velocity_rms_interval[0]).zip(level(velocity_rms_interval[1])).map(<[f64; 2]>::from);
        let slices: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
        let spectrum = record_spectrum(&slices, 1, step, RecordEnds::Free)
            .map_err(|_| VibrationError::NotFound { what: "spectrum", reason: "the records are too short" })?;
        let per_frequency = |density: &[f64]| density.iter().map(|d| d / TAU).collect();
        Ok(Self {
            kind: limit_cycle(oscillator)?.kind(),
            velocity_rms,
            velocity_rms_interval,
            cycle_velocity_rms,
            level_db: level(velocity_rms),
            level_db_interval,
            frequency: spectrum.frequency_per_m.iter().map(|f| TAU * f).collect(),
            density: per_frequency(&spectrum.density),
            density_low: per_frequency(&spectrum.low),
            density_high: per_frequency(&spectrum.high),
        })
    }
}

/// Returns the root mean square velocity of the limit cycle, whose mean is zero.
fn cycle_rms(oscillator: &Oscillator) -> Result<Option<f64>, VibrationError> {
    let Some(points) = cycle_portrait(oscillator, CYCLE_POINTS)? else { return Ok(None) };
    // Trapezoidal rule; the first and the last point are the same.
    let squares: f64 = points[1..].iter().map(|point| point.velocity.powi(2)).sum();
    Ok(Some((squares / (points.len() - 1) as f64).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Coulomb;
    use crate::tests::machine;
    use crate::{Drive, VelocityLaw};
    use asperity_base::monitor::Silent;
    use asperity_process::ProcessModel;
    use asperity_testing::{covered, least_coverage, repetitions};

    fn process(std: f64) -> FrictionProcess {
        FrictionProcess::new(ProcessModel::new("beta:2.1,5".parse().unwrap(), std, 0.01)).unwrap()
    }

    fn settings(duration: f64) -> SoundSettings {
        let followed = TrajectorySettings { duration, start: None, drive: Drive::Distance };
        SoundSettings { trajectories: 8, points_per_period: 64, from: 60.0, seed: 3, followed }
    }

    #[test]
    fn the_coulomb_cycle_has_the_mean_square_of_its_arcs() {
        // Slip is X = μ_k + A cos with the duration 2π − 2 atan(Δ/V); stick lasts 2Δ/V at the velocity V.
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 });
        let found = cycle_rms(&machine(0.4, law, 0.0, 0.05)).unwrap().unwrap();
        let (jump, v) = (0.1_f64, 0.05_f64);
        let (half, square) = (std::f64::consts::PI - (jump / v).atan(), jump * jump + v * v);
        // ∫A² sin² over an angle of 2·half symmetric about the point of the largest backward speed.
        let slip = square * (half + 0.5 * (2.0 * half).sin());
        let stick = v * v * 2.0 * jump / v;
        let wanted = ((slip + stick) / (2.0 * half + 2.0 * jump / v)).sqrt();
        assert!((found / wanted - 1.0).abs() < 1e-6, "{found} and {wanted}");
    }

    #[test]
    fn little_noise_leaves_the_level_of_the_cycle_and_its_frequency() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.1, 0.003).unwrap();
        let found = Sound::record(&oscillator, &process(1e-6), &settings(700.0), &Silent).unwrap();
        assert!(found.level_db.unwrap().abs() < 0.05, "{:?}", found.level_db);
        let loudest = (0..found.density.len()).max_by(|a, b| found.density[*a].total_cmp(&found.density[*b])).unwrap();
        let period = crate::limit_cycle(&oscillator).unwrap().cycle().unwrap().period;
        // Bins are a sixth of an octave wide.
        let octaves = (found.frequency[loudest] * period / TAU).log2();
        assert!(octaves.abs() < 0.5 / 6.0, "{octaves}");
        // The integral of the density is the variance.
        let mut power = 0.0;
        for k in 1..found.frequency.len() {
            power += 0.5 * (found.density[k] + found.density[k - 1]) * (found.frequency[k] - found.frequency[k - 1]);
        }
        assert!((power / found.velocity_rms.powi(2) - 1.0).abs() < 0.1, "{power} of {}", found.velocity_rms.powi(2));
    }

    #[test]
    #[expect(clippy::approx_constant, reason = "a published belt velocity, which is not π")]
    fn the_spectrum_of_overtaking_peaks_at_its_cycle() {
        // Periods at these dampings, without stick: 6.29467 and 6.29499. An independent integrator in
        // `tests/vibration/kinds.rs` agrees.
        for (damping, period) in [(0.001, 6.294_67), (0.002, 6.294_99)] {
            let oscillator = Oscillator::with_stribeck(0.432_353, 4.2, damping, 3.1416).unwrap();
            let settings = SoundSettings { trajectories: 2, from: 3000.0, ..settings(3500.0) };
            let slow = ProcessModel::new("beta:2.1,5".parse().unwrap(), 1e-9, 30.0);
            let found = Sound::record(&oscillator, &FrictionProcess::new(slow).unwrap(), &settings, &Silent).unwrap();
            assert_eq!(found.kind, MotionKind::Overtaking);
            assert!(found.level_db.unwrap().abs() < 0.05, "{:?}", found.level_db);
            let peak = (0..found.density.len()).max_by(|a, b| found.density[*a].total_cmp(&found.density[*b])).unwrap();
            assert!((found.frequency[peak] * period / TAU).log2().abs() < 0.5 / 6.0);
        }
    }

    #[test]
    #[ignore = "slow"]
    fn intervals_of_the_level_cover_that_of_many_trajectories() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.19, 0.003).unwrap();
        let record = |trajectories, seed| {
            let settings = SoundSettings { trajectories, points_per_period: 16, seed, ..settings(150.0) };
            Sound::record(&oscillator, &process(0.001), &settings, &Silent).unwrap()
        };
        let truth = record(20_000, 1).level_db.unwrap();
        for trajectories in [4, 8, 32] {
            let repeats = repetitions(50);
            let holds = |seed: &usize| {
                let [low, high] = record(trajectories, *seed as u64).level_db_interval.unwrap();
                low <= truth && truth <= high
            };
            let held = (2..repeats + 2).filter(holds).count();
            let fraction = covered("level of the sound", &format!("{trajectories} trajectories"), held, repeats);
            assert!(fraction >= least_coverage(repeats), "{trajectories}: {fraction}");
        }
    }

    #[test]
    fn noise_beyond_the_end_of_the_cycle_is_quieter_than_the_last_cycle() {
        let of = |damping| Oscillator::with_stribeck(0.1, 4.2, damping, 0.003).unwrap();
        let loud = Sound::record(&of(0.17), &process(0.001), &settings(400.0), &Silent).unwrap();
        let quiet = Sound::record(&of(0.25), &process(0.001), &settings(400.0), &Silent).unwrap();
        assert!(quiet.velocity_rms_interval[1] < loud.velocity_rms_interval[0]);
        assert_eq!((quiet.level_db, quiet.cycle_velocity_rms), (None, None));
        assert!(loud.level_db.unwrap() < 1.0);
        let wrong = SoundSettings { points_per_period: 2, ..settings(400.0) };
        assert!(Sound::record(&of(0.17), &process(0.001), &wrong, &Silent).is_err());
    }
}
