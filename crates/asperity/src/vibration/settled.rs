//! What an oscillator without fluctuation settles into.

use super::{MotionKind, Oscillator, Regime, SlipCycle, VibrationError, critical_damping, limit_cycle, slip_cycles};

/// Returns the kind of motion that an oscillator without fluctuation settles into when it starts in stick.
///
/// Without forcing, the orbit from a detachment encloses all cycles that stay slower than the belt. So if it does not return to the
/// belt, it ends in the largest of those cycles that attracts. Forced motion that stays slower than the belt follows the force and
/// is [`MotionKind::None`]; forced motion that reaches the belt and does not repeat itself counts as [`MotionKind::StickSlip`].
///
/// # Errors
/// As [`limit_cycle`].
pub fn motion_kind(oscillator: &Oscillator) -> Result<MotionKind, VibrationError> {
    Ok(match limit_cycle(oscillator)? {
        Regime::Cycle(cycle) if cycle.slips == 0 => MotionKind::Overtaking,
        Regime::Cycle(_) | Regime::Irregular => MotionKind::StickSlip,
        Regime::Sliding if swing_level(oscillator).is_finite() => MotionKind::SlipCycle,
        Regime::Sliding => MotionKind::None,
    })
}

/// Returns the largest damping ratio at which an oscillator without fluctuation and forcing vibrates; none if it does not vibrate at
/// any.
///
/// # Errors
/// As [`critical_damping`].
pub(super) fn vibration_limit(oscillator: &Oscillator) -> Result<Option<f64>, VibrationError> {
    let limit = critical_damping(oscillator)?;
    Ok(Some(limit.critical_damping_ratio.max(limit.hopf_damping_ratio)).filter(|damping| *damping > 0.0))
}

/// Returns the W = |v_rel|/V that a swing of the velocity slower than the belt has to exceed to be part of a slip cycle; infinite if
/// no slip cycle attracts.
///
/// W = 1 in steady sliding. The level lies midway between the largest W of the smallest slip cycle that attracts and that of the
/// border of its basin, which is the slip cycle inside it or steady sliding. So fluctuations of friction about stable steady sliding
/// rarely exceed it, and fluctuations about the slip cycle rarely fall below it.
pub(super) fn swing_level(oscillator: &Oscillator) -> f64 {
    if oscillator.forcing().is_some() {
        return f64::INFINITY;
    }
    // Where slip cycles cannot be computed, as under a law that falls below zero, none is known to attract.
    let cycles = slip_cycles(oscillator).unwrap_or_default();
    let fastest = |cycle: &SlipCycle| 1.0 - cycle.velocity_min / oscillator.belt_velocity();
    let Some(first) = cycles.iter().position(SlipCycle::is_stable) else { return f64::INFINITY };
    let border = if first == 0 { 1.0 } else { fastest(&cycles[first - 1]) };
    0.5 * (border + fastest(&cycles[first]))
}
