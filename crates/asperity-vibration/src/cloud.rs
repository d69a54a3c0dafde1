//! Phase cloud of an ensemble, for plots.

use std::f64::consts::TAU;

use asperity_base::blocks;
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_process::{Cancellable, FrictionProcess};

use super::{EnsembleSettings, Oscillator, PhasePoint, TrajectorySettings, VibrationError, trajectory_portrait};

/// Points of each trajectory, and the time τ that they span.
const POINTS: usize = 72;
const SPAN: f64 = 1.1 * TAU;

/// Returns the ends of the first `most` trajectories of an ensemble, slightly more than a natural period of each; `None` for failed ones.
///
/// # Errors
/// Settings out of range, or cancelled.
pub fn phase_cloud(
    oscillator: &Oscillator,
    process: &FrictionProcess,
    settings: &EnsembleSettings,
    most: usize,
    monitor: &dyn Monitor,
) -> Result<Vec<Option<Vec<PhasePoint>>>, VibrationError> {
    let EnsembleSettings { duration, start, drive, seed, .. } = *settings;
    let followed = TrajectorySettings { duration, start, drive };
    let from = (duration - SPAN).max(0.0);
    blocks::map(0..settings.trajectories.min(most), |index| {
        if monitor.cancelled() {
            return Err(Cancelled.into());
        }
        let path = Cancellable::new(process.path(seed, index as u64), monitor);
        match trajectory_portrait(oscillator, path, &followed, from, POINTS) {
            Ok(points) => Ok(Some(points)),
            Err(_) if monitor.cancelled() => Err(Cancelled.into()),
            Err(error @ VibrationError::Parameter { .. }) => Err(error),
            Err(_) => Ok(None),
        }
    })
}
