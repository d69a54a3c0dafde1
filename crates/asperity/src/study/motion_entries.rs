//! Conversion of kinds of motion and cycles of either machine to entries of `results.json`.

use crate::friction::process::Steady;
use crate::study::result::CoupledCycleResult;
use crate::vibration::mode_coupling::{CoupledCycle, CoupledTrajectory, CoupledTrajectorySettings, Instability, Model};
use crate::vibration::{MotionKind, Scales, VibrationError};

/// Points of one period from which the velocity amplitude is read.
const PERIOD_POINTS: usize = 1024;

/// Returns the kind of motion of two coupled modes by the stability of steady sliding.
pub(super) fn instability_result(instability: Option<Instability>) -> MotionKind {
    match instability {
        Some(Instability::Flutter) => MotionKind::Flutter,
        Some(Instability::Divergence) => MotionKind::Divergence,
        None => MotionKind::None,
    }
}

/// Returns a cycle of two coupled modes in SI.
pub(super) fn coupled_cycle_result(
    model: &Model,
    cycle: &CoupledCycle,
    scales: &Scales,
) -> Result<CoupledCycleResult, VibrationError> {
    let settings = CoupledTrajectorySettings { duration: cycle.period, start: Some(cycle.start) };
    let points = CoupledTrajectory::portrait(model, Steady, &settings, 0.0, PERIOD_POINTS)?;
    let velocities = points.iter().map(|point| point.state.tangential_velocity);
    let (least, largest) =
        velocities.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let half = |[low, high]: [f64; 2]| 0.5 * (high - low);
    Ok(CoupledCycleResult {
        frequency_hz: 1.0 / (cycle.period * scales.time_s()),
        velocity_amplitude_m_per_s: half([least, largest]) * scales.velocity_m_per_s(),
        displacement_amplitude_m: half(cycle.tangential) * scales.length_m(),
        normal_amplitude_m: half(cycle.normal) * scales.length_m(),
        stick_share: cycle.stick_share,
        flight_share: cycle.flight_share,
    })
}
