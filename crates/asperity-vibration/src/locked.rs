//! End of the forced cycle that is locked to the force.

use std::f64::consts::TAU;

use super::critical::critical_damping;
use super::scaled_forcing::ScaledForcing;
use super::slip_orbit::first_minimum;
use super::structure::grazing::grazing_damping;
use super::weakening::Weakening;
use super::{Oscillator, VibrationError};
use asperity_base::numeric::try_root_between;

/// Number of detachment phases on the first grid.
const PHASES: usize = 96;

/// Returns the largest damping ratio at which a stick-slip cycle with one slip per forcing period can end by grazing.
///
/// At the boundary the slip orbit from F = μ_st touches the belt velocity and returns to its start, in displacement and
/// phase, after 2π/η. With a jump of the law it returns after the stick that the jump causes. For each phase of the
/// detachment the damping ratio at which the orbit grazes is computed. Among the phases at which the orbit also closes,
/// the largest damping ratio is returned. The oscillator's own damping ratio is ignored.
///
/// Fails without forcing, and if no phase closes the orbit, which happens far from resonance.
pub fn locked_boundary(oscillator: &Oscillator) -> Result<f64, VibrationError> {
    Ok(grazing_lock(oscillator)?.1)
}

/// Returns the time of the detachment of that orbit, and its damping ratio.
pub(super) fn grazing_lock(oscillator: &Oscillator) -> Result<(f64, f64), VibrationError> {
    let what = "locked cycle";
    let Some(forcing) = oscillator.forcing() else {
        return Err(VibrationError::NotFound { what, reason: "the oscillator has no forcing" });
    };
    let period = TAU / forcing.frequency;
    let free = critical_damping(oscillator)?.critical_damping_ratio;
    let (scaled, jump) = (ScaledForcing::new(oscillator), Weakening::new(oscillator).jump);
    let mismatch = |phase: f64| -> Result<Option<(f64, f64)>, VibrationError> {
        if 1.0 + scaled.rate(phase) <= 0.0 {
            return Ok(None);
        }
        let Some(damping) = grazing_damping(oscillator, phase, free.max(0.01), 60.0 * free.max(0.01))? else {
            return Ok(None);
        };
        let Some(minimum) = first_minimum(&oscillator.with_damping(damping)?, phase)? else { return Ok(None) };
        let stick = scaled.release(1.0, 1.0, -jump, phase + minimum.time, f64::INFINITY);
        Ok(stick.map(|stick| (minimum.time + stick - period, damping)))
    };
    let mut best: Option<(f64, f64)> = None;
    let mut last: Option<(f64, f64)> = None;
    for i in 0..=PHASES {
        let phase = period * i as f64 / PHASES as f64;
        let here = mismatch(phase)?.map(|(value, _)| (phase, value));
        if let (Some((a, at_a)), Some((b, at_b))) = (last, here) {
            // The mismatch is an angle: a jump of nearly a full turn is not a zero.
            if at_a * at_b <= 0.0 && (at_a - at_b).abs() < 0.5 * period {
                let value = |phase: f64| -> Result<f64, VibrationError> {
                    Ok(mismatch(phase)?.map_or(f64::INFINITY, |(value, _)| value))
                };
                if let Some(root) = try_root_between(value, [a, at_a], [b, at_b], 1e-14)?
                    && let Some((_, damping)) = mismatch(root)?
                {
                    best = best.filter(|(_, largest)| *largest >= damping).or(Some((root, damping)));
                }
            }
        }
        last = here;
    }
    best.ok_or(VibrationError::NotFound { what, reason: "no detachment phase closes the grazing orbit" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Forcing, limit_cycle};

    #[test]
    fn the_locked_cycle_ends_at_the_published_damping() {
        for (frequency, wanted) in [(0.98, 0.270_299_774_5), (1.0, 0.273_186_622_3)] {
            let oscillator = Oscillator::with_stribeck(0.2, 4.2, 0.0, 0.1).unwrap();
            let forced = oscillator.with_forcing(Some(Forcing { amplitude: 0.01, frequency })).unwrap();
            let found = locked_boundary(&forced).unwrap();
            // One unit of the last published digit, which may be truncated or rounded.
            assert!((found - wanted).abs() < 1e-10, "{found:.13} instead of {wanted}");
        }
    }

    #[test]
    fn just_below_the_boundary_the_motion_is_locked_with_hardly_any_stick() {
        let oscillator = Oscillator::with_stribeck(0.2, 4.2, 0.0, 0.1).unwrap();
        let forced = oscillator.with_forcing(Some(Forcing { amplitude: 0.01, frequency: 1.0 })).unwrap();
        let boundary = locked_boundary(&forced).unwrap();
        let cycle = *limit_cycle(&forced.with_damping(boundary - 1e-6).unwrap()).unwrap().cycle().unwrap();
        assert_eq!(cycle.slips, 1);
        assert!(cycle.period - cycle.slip_duration < 0.02 && cycle.period > cycle.slip_duration);
    }
}
