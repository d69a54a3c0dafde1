//! Cycles with stick under a harmonic force, stable and unstable.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::super::cycle::{LimitCycle, Turn};
use super::super::{Oscillator, VibrationError};
use super::passage::passage;
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_base::numeric::{bisect, newton_between, try_root_between};

/// Number of detachment phases on the first grid, per slip of the cycle.
const PHASES: usize = 192;
/// Difference in units of the forcing period below which a cycle counts as closed.
const CLOSED: f64 = 1e-9;
/// Difference of detachment phases, in units of the forcing period, below which two cycles count as one.
const SAME: f64 = 1e-8;

/// Cycle with stick of a forced oscillator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ForcedCycle {
    /// Phase ητ mod 2π of a detachment into slip.
    pub detachment_phase: f64,
    /// Number of detachments into slip per period.
    pub multiplicity: usize,
    /// Number of forcing periods per period.
    pub forcing_periods: usize,
    /// Floquet multiplier: factor of a small deviation of the detachment phase in one period. The other multiplier is
    /// zero, because the motion after a stick depends only on the time of its end. The multiplier may be negative, and
    /// it is large close to a grazing.
    pub multiplier: f64,
    /// Extremes and times.
    pub cycle: LimitCycle,
}

impl ForcedCycle {
    /// Returns whether the cycle attracts.
    pub fn is_stable(&self) -> bool {
        self.multiplier.abs() < 1.0
    }
}

/// A sequence of k passages from a detachment.
struct Passages {
    /// τ_k − τ_0.
    advance: f64,
    slope: f64,
    /// Times of the detachments, except the last.
    taus: Vec<f64>,
    turns: Vec<Turn>,
}

fn passages(oscillator: &Oscillator, tau: f64, count: usize, period: f64) -> Result<Option<Passages>, VibrationError> {
    let mut all = Passages { advance: 0.0, slope: 1.0, taus: Vec::new(), turns: Vec::new() };
    let mut now = tau;
    for _ in 0..count {
        all.taus.push(now);
        let Some(next) = passage(oscillator, now)? else { return Ok(None) };
        all.advance += next.tau - now;
        all.slope *= next.slope;
        all.turns.extend(next.turns);
        now = next.tau.rem_euclid(period);
    }
    Ok(Some(all))
}

/// Returns all cycles with stick of a forced oscillator that have at most `most` detachments into slip per period,
/// stable and unstable, by rising multiplicity and detachment phase.
///
/// The unknown of the shooting method is the time of a detachment; the equation requires that the k-th detachment after
/// it comes whole forcing periods later. Zeros are isolated on a grid of 192 k phases, including extremes and jumps
/// between its nodes, and computed by Newton's method with the exact derivative of the event map. The grid misses pairs
/// of cycles that exist on a phase range narrower than its spacing. Cycles without stick are not searched.
/// Fails without forcing, if friction does not stay positive, or when cancelled.
pub fn forced_cycles(
    oscillator: &Oscillator,
    most: usize,
    monitor: &dyn Monitor,
) -> Result<Vec<ForcedCycle>, VibrationError> {
    let Some(forcing) = oscillator.forcing() else {
        return Err(VibrationError::NotFound { what: "forced cycle", reason: "the oscillator has no forcing" });
    };
    let period = TAU / forcing.frequency;
    let mut found: Vec<ForcedCycle> = Vec::new();
    let total = (1..=most).map(|k| k * PHASES).sum();
    let mut done = 0;
    for count in 1..=most {
        let mut phases: Vec<f64> = Vec::new();
        let advance = |tau: f64| -> Result<Option<(f64, f64)>, VibrationError> {
            Ok(passages(oscillator, tau, count, period)?.map(|all| (all.advance, all.slope - 1.0)))
        };
        let mut last: Option<Node> = None;
        for i in 0..=count * PHASES {
            if monitor.cancelled() {
                return Err(Cancelled.into());
            }
            let tau = period * i as f64 / (count * PHASES) as f64;
            let here = advance(tau)?.map(|(value, slope)| Node { tau, value, slope });
            for (a, b) in pieces(&advance, last, here, period / (count * PHASES) as f64, period)? {
                for root in roots(&advance, a, b, period)? {
                    let Some(all) = passages(oscillator, root, count, period)? else { continue };
                    let forcing_periods = (all.advance / period).round();
                    let open = |advance: f64| (advance / period - (advance / period).round()).abs() > CLOSED;
                    let mut repeats = false;
                    for divisor in (1..count).filter(|d| count % d == 0) {
                        repeats |= passages(oscillator, root, divisor, period)?.is_some_and(|p| !open(p.advance));
                    }
                    let known = |tau: &f64| {
                        let apart = ((tau - root) / period).rem_euclid(1.0);
                        apart.min(1.0 - apart) < SAME
                    };
                    if open(all.advance) || repeats || phases.iter().any(known) {
                        continue;
                    }
                    phases.extend(&all.taus);
                    found.push(ForcedCycle {
                        detachment_phase: forcing.frequency * root.rem_euclid(period),
                        multiplicity: count,
                        forcing_periods: forcing_periods as usize,
                        multiplier: all.slope,
                        cycle: Turn::cycle(&all.turns),
                    });
                }
            }
            last = here;
            done += usize::from(i > 0);
            monitor.progress("detachment phases", done, total);
        }
    }
    Ok(found)
}

/// Value of the map at one node of the grid.
#[derive(Debug, Clone, Copy)]
struct Node {
    tau: f64,
    value: f64,
    slope: f64,
}

/// Returns the smooth pieces of the map next to two neighbours on the grid.
///
/// At a grazing the map jumps by about a forcing period, or ends; each neighbour's piece is followed up to the jump.
fn pieces(
    advance: &impl Fn(f64) -> Result<Option<(f64, f64)>, VibrationError>,
    a: Option<Node>,
    b: Option<Node>,
    spacing: f64,
    period: f64,
) -> Result<Vec<(Node, Node)>, VibrationError> {
    let joined = |value: f64, node: Node| (value - node.value).abs() < 0.5 * period;
    if let (Some(a), Some(b)) = (a, b)
        && joined(b.value, a)
    {
        return Ok(vec![(a, b)]);
    }
    let mut pieces = Vec::new();
    for (node, far) in [(a, spacing), (b, -spacing)] {
        let Some(node) = node else { continue };
        let mut inside = node;
        bisect(node.tau, node.tau + far, 1e-13 * period, |tau| -> Result<bool, VibrationError> {
            let found = advance(tau)?.filter(|(value, _)| joined(*value, node));
            inside = found.map_or(inside, |(value, slope)| Node { tau, value, slope });
            Ok(found.is_some())
        })?;
        pieces.push(if far > 0.0 { (node, inside) } else { (inside, node) });
    }
    Ok(pieces)
}

/// Returns the times between two nodes at which the advance is a whole number of forcing periods.
fn roots(
    advance: &impl Fn(f64) -> Result<Option<(f64, f64)>, VibrationError>,
    a: Node,
    b: Node,
    period: f64,
) -> Result<Vec<f64>, VibrationError> {
    let mut nodes = vec![a, b];
    if a.slope * b.slope < 0.0 {
        let slope =
            |tau: f64| -> Result<f64, VibrationError> { Ok(advance(tau)?.map_or(f64::INFINITY, |(_, slope)| slope)) };
        if let Some(extreme) = try_root_between(slope, [a.tau, a.slope], [b.tau, b.slope], 1e-12 * period)?
            && let Some((value, slope)) = advance(extreme)?
        {
            nodes.insert(1, Node { tau: extreme, value, slope });
        }
    }
    let mut roots = Vec::new();
    for pair in nodes.windows(2) {
        let (low, high) = if pair[0].value < pair[1].value { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
        let first = (low.value / period).floor() as i64 + 1;
        let last = (high.value / period).floor() as i64;
        for whole in first..=last {
            let goal = whole as f64 * period;
            let off = |tau: f64| -> Result<(f64, f64), VibrationError> {
                Ok(advance(tau)?.map_or((f64::NAN, f64::NAN), |(value, slope)| (value - goal, slope)))
            };
            roots.push(newton_between(off, low.tau, high.tau, 0.5 * (low.tau + high.tau))?);
        }
    }
    Ok(roots)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Forcing, limit_cycle, locked_boundary};
    use asperity_base::monitor::Silent;

    fn forced(friction: f64, decay: f64, damping: f64, velocity: f64, amplitude: f64, frequency: f64) -> Oscillator {
        let free = Oscillator::with_stribeck(friction, decay, damping, velocity).unwrap();
        free.with_forcing(Some(Forcing { amplitude, frequency })).unwrap()
    }

    #[test]
    fn a_locked_oscillator_has_the_published_stable_and_unstable_cycle() {
        // Reference: SciPy's DOP853 at 1e-13 in displacement and velocity, brentq on the phase, and fourth-order
        // differences of the map at ±0.001 and ±0.002 for the multiplier; accurate to 1e-11.
        let found = forced_cycles(&forced(0.2, 4.2, 0.1, 0.1, 0.02, 0.85), 2, &Silent).unwrap();
        let wanted = [
            (0.167_718_780_139, 0.798_109_649_788, -0.035_325_585_865_86, true),
            (5.478_189_762_536, 1.229_339_408_056, -0.010_219_851_067_10, false),
        ];
        assert_eq!(found.len(), 2);
        for (cycle, (phase, multiplier, reattachment, stable)) in found.iter().zip(wanted) {
            assert_eq!((cycle.multiplicity, cycle.forcing_periods, cycle.is_stable()), (1, 1, stable));
            assert!((cycle.detachment_phase - phase).abs() < 2e-12, "{cycle:?}");
            assert!((cycle.multiplier - multiplier).abs() < 1e-10, "{cycle:?}");
            assert!((cycle.cycle.reattachment_displacement.unwrap() - reattachment).abs() < 1e-13, "{cycle:?}");
            assert!((cycle.cycle.period - TAU / 0.85).abs() < 1e-13);
        }
    }

    #[test]
    fn motion_ends_in_the_attracting_cycle() {
        // The third cycle includes over-slip and sticks twice.
        for oscillator in [
            forced(0.2, 4.2, 0.2, 0.1, 0.01, 0.98),
            forced(0.2, 4.2, 0.1, 0.1, 0.05, 0.93),
            forced(0.1, 3.0, 0.1, 0.05, 0.15, 0.5),
        ] {
            let stable: Vec<_> =
                forced_cycles(&oscillator, 1, &Silent).unwrap().into_iter().filter(ForcedCycle::is_stable).collect();
            let followed = *limit_cycle(&oscillator).unwrap().cycle().unwrap();
            assert_eq!(stable.len(), 1);
            let shot = stable[0].cycle;
            assert_eq!(shot.slips, followed.slips);
            for (a, b) in [
                (shot.period, followed.period),
                (shot.slip_duration, followed.slip_duration),
                (shot.displacement_min, followed.displacement_min),
                (shot.displacement_max, followed.displacement_max),
                (shot.velocity_min, followed.velocity_min),
            ] {
                assert!((a / b - 1.0).abs() < 1e-10, "{shot:?} and {followed:?}");
            }
        }
    }

    #[test]
    #[ignore = "slow"]
    fn the_locked_cycle_ends_at_its_boundary() {
        let at = |damping| forced(0.2, 4.2, damping, 0.1, 0.01, 0.98);
        let boundary = locked_boundary(&at(0.0)).unwrap();
        let below = forced_cycles(&at(boundary - 1e-6), 1, &Silent).unwrap();
        assert!(below.iter().any(ForcedCycle::is_stable), "{below:?}");
        assert_eq!(forced_cycles(&at(boundary + 1e-6), 1, &Silent).unwrap(), []);
    }

    #[test]
    fn without_forcing_there_is_no_forced_cycle() {
        let free = Oscillator::with_stribeck(0.2, 4.2, 0.1, 0.1).unwrap();
        assert!(matches!(forced_cycles(&free, 1, &Silent), Err(VibrationError::NotFound { .. })));
    }
}
