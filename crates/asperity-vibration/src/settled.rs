//! Level above which swings of the velocity belong to a slip cycle.

use super::{Oscillator, SlipCycle, slip_cycles};

/// Returns the level of W = |v_rel|/V that a swing slower than the belt must exceed to count as part of a slip cycle;
/// infinite if no slip cycle attracts.
///
/// W = 1 in steady sliding. The level lies midway between the largest W of the smallest attracting slip cycle and the
/// largest W of the border of its basin, which is the slip cycle inside it or steady sliding. So fluctuations of
/// friction about stable steady sliding rarely exceed the level, and fluctuations about the slip cycle rarely fall
/// below it.
pub(super) fn swing_level(oscillator: &Oscillator) -> f64 {
    if oscillator.forcing().is_some() {
        return f64::INFINITY;
    }
    // Slip cycles cannot be computed under some laws, for example a law that falls below zero; then no cycle is known
    // to attract.
    let cycles = slip_cycles(oscillator).unwrap_or_default();
    let fastest = |cycle: &SlipCycle| 1.0 - cycle.velocity_min / oscillator.belt_velocity();
    let Some(first) = cycles.iter().position(SlipCycle::is_stable) else { return f64::INFINITY };
    let border = if first == 0 { 1.0 } else { fastest(&cycles[first - 1]) };
    0.5 * (border + fastest(&cycles[first]))
}
