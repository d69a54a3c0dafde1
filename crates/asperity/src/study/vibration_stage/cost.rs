//! Rough cost of the vibration stage.

use crate::study::check::{FrictionSource, VibrationStudy};
use crate::study::estimate::MAP_POINT_BYTES;
use crate::study::{Stage, StageEstimate, Study};
use crate::vibration::EnsembleSettings;

/// Seconds per unit of dimensionless time of a trajectory, and per value of its fluctuation.
const TRAJECTORY_SECONDS: f64 = 0.2e-6;
pub(in crate::study) const FLUCTUATION_SECONDS: f64 = 60e-9;
/// Additional ensembles, beside those of the sweep, that locate the crossings of one upscaling.
pub(in crate::study) const CROSSING_ENSEMBLES: usize = 20;
/// Number of values of a fluctuation per correlation length.
const FLUCTUATION_VALUES: f64 = 20.0;

/// Returns the rough cost of the vibration stage; `None` for a study without ensembles.
pub(in crate::study) fn cost(whole: &Study, threads: usize) -> Option<StageEstimate> {
    let study = whole.vibration.as_ref().filter(|study| study.machine.coupled.is_none())?;
    // Both upscalings, and a map whose front is refined: a line of cells at each depth.
    let points = study.map.as_ref().map_or(0, |map| {
        let (nx, ny) = (map.x.2, map.y.2);
        (nx + 1) * (ny + 1) + 4 * nx.max(ny) * ((1 << (map.depth + 1)) - 2)
    });
    let map = study.map.as_ref().map_or(0, |map| points.saturating_mul(map.trajectories));
    let ensembles = study.damping_sweep.2 + CROSSING_ENSEMBLES;
    let trajectories = (2 * ensembles * study.trajectories).saturating_add(map);
    let settings = EnsembleSettings::new(study.trajectories, study.duration, whole.seed());
    let bytes = settings.memory_bytes(threads) + points as f64 * MAP_POINT_BYTES;
    Some(StageEstimate {
        trajectories,
        core_seconds: trajectories as f64 * trajectory_seconds(whole, study),
        ..StageEstimate::new(Stage::Vibration, bytes)
    })
}

/// Returns the seconds of one trajectory.
pub(in crate::study) fn trajectory_seconds(whole: &Study, study: &VibrationStudy) -> f64 {
    // Friction that a study computes is correlated over at least one window.
    let length_m = match &study.machine.friction {
        FrictionSource::Stated(friction) => Some(friction.length_m),
        FrictionSource::Computed(_) | FrictionSource::File(_) => whole.friction.as_ref().map(|f| f.window_m[0]),
    };
    let values = length_m.map_or(0.0, |length_m| FLUCTUATION_VALUES * study.sliding_distance_m() / length_m);
    TRAJECTORY_SECONDS * study.duration + FLUCTUATION_SECONDS * values
}
