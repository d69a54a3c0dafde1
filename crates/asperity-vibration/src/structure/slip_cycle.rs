//! Cycles slower than the belt.

use serde::{Deserialize, Serialize};

use super::super::motion::SlipState;
use super::super::{Oscillator, Phase, VibrationError};
use super::planar::{Lap, Planar, Turn};
use asperity_base::numeric::newton_between;

/// Number of amplitudes on the first grid of the return map.
const AMPLITUDES: usize = 32;
/// |ln(P/r)| below which growth is rounding.
const NEUTRAL: f64 = 1e-12;
/// Least amplitude of the search, as a fraction of the first one on the grid.
const SMALLEST: f64 = 1e-6;
/// |ln(P/r)| below which a cycle counts as closed.
const CLOSED: f64 = 1e-9;
/// Largest number of evaluations of the return map in the search for an extremum of ln(P/r) between grid points.
const EXTREMUM_TRIES: usize = 60;
/// Step of the damping ratio for the derivative of ln(P/r).
const DAMPING_STEP: f64 = 1e-6;
/// Relative distance above the grazing point at which slip cycles are searched.
const BEYOND: f64 = 1e-9;
/// Largest number of steps in the search for a damping ratio above the last slip cycle.
const MAX_RAISES: usize = 100;

/// Cycle of slip that never reaches the belt velocity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SlipCycle {
    /// Period in τ.
    pub period: f64,
    /// Least X.
    pub displacement_min: f64,
    /// Largest X.
    pub displacement_max: f64,
    /// Least X′.
    pub velocity_min: f64,
    /// Largest X′, less than the belt velocity.
    pub velocity_max: f64,
    /// Floquet multiplier: factor of a small deviation in one period. Below 1 the cycle attracts, above it repels.
    pub multiplier: f64,
}

impl SlipCycle {
    /// Returns whether the cycle attracts.
    pub fn is_stable(&self) -> bool {
        self.multiplier < 1.0
    }
}

/// Cycles and growth of the return map.
#[derive(Debug, Clone)]
pub(crate) struct ReturnMap {
    /// (r, cycle), by rising r.
    pub(super) cycles: Vec<(f64, SlipCycle)>,
    /// Amplitude r beyond which orbits reach the belt velocity within one turn, or lie outside the orbit from a
    /// detachment.
    pub(super) edge: f64,
    /// Sign of ln(P/r) before the first cycle, between the cycles and after the last.
    pub(super) growth: Vec<f64>,
    /// Excess e in steady sliding.
    rest: f64,
}

impl ReturnMap {
    /// Returns the cycle that orbits from the edge approach, with a state on it; none if they end in steady sliding.
    pub(crate) fn outermost_attractor(&self) -> Option<(SlipState, &SlipCycle)> {
        let (r, cycle) = self.cycles.last().filter(|_| self.growth.last().is_some_and(|growth| *growth <= 0.0))?;
        Some((self.state(*r), cycle))
    }

    /// Returns the state in which an orbit of amplitude r crosses the section.
    pub(super) fn state(&self, r: f64) -> SlipState {
        SlipState { tau: 0.0, phase: Phase::Slip, w: 1.0, e: self.rest + r }
    }

    fn add(&mut self, oscillator: &Oscillator, r: f64, lap: &Lap, growth: f64) {
        self.cycles.push((r, cycle(oscillator, self.rest, r, lap)));
        self.growth.push(growth);
    }
}

/// ln(P(r)/r) of one turn and its derivative.
#[derive(Debug, Clone, Copy)]
struct Growth {
    r: f64,
    value: f64,
    slope: f64,
    touches: bool,
}

impl Growth {
    fn at(planar: &Planar, r: f64) -> Result<Self, VibrationError> {
        let (value, slope) = match planar.turn(r)? {
            Turn::Back(lap) => ((lap.back / r).ln(), (r / lap.back * lap.stretch.exp()) / lap.back - 1.0 / r),
            Turn::Touches => return Ok(Self { r, value: 1.0, slope: f64::NAN, touches: true }),
            Turn::Settles => (-1.0, f64::NAN),
        };
        Ok(Self { r, value, slope, touches: false })
    }

    fn sign(&self) -> f64 {
        sign(self.value)
    }
}

fn sign(value: f64) -> f64 {
    if value.abs() <= NEUTRAL { 0.0 } else { value.signum() }
}

/// Returns the growth on the grid of amplitudes, up to the orbit from a detachment or to the first orbit that reaches
/// the belt.
fn growths(planar: &Planar, outer: f64) -> Result<Vec<Growth>, VibrationError> {
    let mut found = Vec::with_capacity(AMPLITUDES);
    for i in 1..=AMPLITUDES {
        // Denser close to rest, where cycles appear.
        found.push(Growth::at(planar, outer * (i as f64 / AMPLITUDES as f64).powi(3))?);
        if found.last().is_some_and(|growth| growth.touches) {
            break;
        }
    }
    Ok(found)
}

/// Returns the extremum of ln(P/r) between two amplitudes whose slopes differ in sign: a maximum for `side` < 0, a
/// minimum for `side` > 0. The search ends early if `decided` accepts the best value and the bound from the tangents at
/// the ends of the bracket.
fn extremum(
    planar: &Planar,
    [mut a, mut b]: [Growth; 2],
    side: f64,
    decided: impl Fn(f64, f64) -> bool,
) -> Result<Option<Growth>, VibrationError> {
    if !(side * a.slope < 0.0 && side * b.slope > 0.0) {
        return Ok(None);
    }
    let mut best = if side * a.value < side * b.value { a } else { b };
    for _ in 0..EXTREMUM_TRIES {
        let along = (b.value - a.value - b.slope * (b.r - a.r)) / (a.slope - b.slope);
        let bound = a.value + a.slope * along;
        if decided(best.value, bound) || (bound - best.value).abs() < NEUTRAL {
            break;
        }
        // Secant of the slopes, kept away from the ends of the bracket.
        let fraction = (a.slope / (a.slope - b.slope)).clamp(0.05, 0.95);
        let here = Growth::at(planar, a.r + fraction * (b.r - a.r))?;
        if here.slope.is_nan() {
            break;
        }
        if side * here.value < side * best.value {
            best = here;
        }
        if side * here.slope < 0.0 { a = here } else { b = here }
    }
    Ok(Some(best))
}

/// Returns all cycles without stick and without forcing between steady sliding and the orbit from a detachment, by
/// rising amplitude.
///
/// Between ζ_H and ζ_c a velocity-weakening law has an unstable cycle, which separates the starts that end in steady
/// sliding from the starts that end in stick-slip. The zeros of ln(P(r)/r) of the return map r → P(r) are isolated on a
/// grid of 32 amplitudes and by the extrema between its points, and computed by Newton's method with the exact
/// derivative. A continuum of cycles, for example with Coulomb friction and no damping, contains no isolated cycle, so
/// none is returned.
pub fn slip_cycles(oscillator: &Oscillator) -> Result<Vec<SlipCycle>, VibrationError> {
    Ok(return_map(oscillator)?.map_or(Vec::new(), |map| map.cycles.into_iter().map(|(_, cycle)| cycle).collect()))
}

/// Returns the return map; none if orbits do not turn around steady sliding.
pub(crate) fn return_map(oscillator: &Oscillator) -> Result<Option<ReturnMap>, VibrationError> {
    let planar = Planar::new(oscillator)?;
    let Some(outer) = planar.detachment()? else { return Ok(None) };
    let half_rate = 0.5 * oscillator.law().weakening(oscillator.belt_velocity()) - oscillator.damping_ratio();
    let at_rest = sign(half_rate);
    let mut map = ReturnMap { cycles: Vec::new(), edge: 0.0, growth: vec![at_rest], rest: planar.rest };
    let mut before = Growth { r: 0.0, value: at_rest, slope: f64::NAN, touches: false };
    let mut side = at_rest;
    for here in growths(&planar, outer)? {
        // Checks for two cycles between neighbours on the grid.
        let hidden = if here.sign() == side {
            extremum(&planar, [before, here], side, |best, bound| side * best < -NEUTRAL || side * bound > 0.0)?
        } else {
            None
        };
        let pair = hidden.filter(|point| point.sign() * side < 0.0);
        for point in pair.into_iter().chain([here]) {
            if point.sign() * side < 0.0 {
                let (low, high) = if point.sign() > 0.0 { (before.r, point.r) } else { (point.r, before.r) };
                let growth = |r: f64| Growth::at(&planar, r).map(|growth| (growth.value, growth.slope));
                let root = newton_between(growth, low, high, 0.5 * (before.r + point.r))?;
                if let Turn::Back(lap) = planar.turn(root)?
                    && (lap.back / root).ln().abs() < CLOSED
                {
                    map.add(oscillator, root, &lap, point.sign());
                }
            }
            if point.touches {
                map.edge = edge(&planar, before.r, point.r)?;
                return Ok(Some(map));
            }
            if point.sign() != 0.0 {
                side = point.sign();
                if let Some(last) = map.growth.last_mut().filter(|last| **last == 0.0) {
                    *last = side;
                }
            }
            (before, map.edge) = (point, point.r);
        }
    }
    // Under strong damping all orbits converge, and their cycle is the orbit from a detachment, to rounding.
    if side > 0.0
        && map.growth.last().is_some_and(|last| *last > 0.0)
        && let Turn::Back(lap) = planar.turn(outer)?
        && lap.stretch < 0.0
        && (lap.back / outer).ln().abs() < CLOSED
    {
        map.add(oscillator, outer, &lap, -1.0);
    }
    Ok(Some(map))
}

/// Returns the damping ratio of the fold in which the last slip cycles above a given damping ratio end; none if there
/// are none.
///
/// Cycles of different damping do not intersect (the field rotates with ζ), so cycles exist exactly while the largest
/// ln(P/r) over the amplitudes is positive. Its zero over ζ is found by Newton's method.
///
/// A law whose fall φ = −dμ/d|v| is convex has no fold above ζ_H: f = 2ζ − φ(V − X′) divided by X′ falls on both sides of
/// rest, so there is at most one cycle (Zhang).
///
/// # References
/// Duff, *Annals of Mathematics* **57** (1953) 15, <https://doi.org/10.2307/1969724>; Zhang, *Applicable Analysis* **23**
/// (1986) 63, <https://doi.org/10.1080/00036818608839631>.
pub(crate) fn fold_damping(oscillator: &Oscillator, above: f64) -> Result<Option<f64>, VibrationError> {
    if oscillator.law().has_convex_fall() {
        return Ok(None);
    }
    searched_fold(oscillator, above)
}

/// Returns the fold above a damping ratio that a search finds.
fn searched_fold(oscillator: &Oscillator, above: f64) -> Result<Option<f64>, VibrationError> {
    // Returns −max ln(P/r) and its derivative.
    let decay = |damping: f64| -> Result<(f64, f64), VibrationError> {
        let planar = Planar::new(&oscillator.with_damping(damping)?)?;
        let Some(peak) = peak(&planar)? else { return Ok((1.0, f64::NAN)) };
        let next = Growth::at(&Planar::new(&oscillator.with_damping(damping + DAMPING_STEP)?)?, peak.r)?;
        Ok((-peak.value, (peak.value - next.value) / DAMPING_STEP))
    };
    // Exactly at the grazing point, rounding decides whether the outermost orbit reaches the belt.
    let mut low = above * (1.0 + BEYOND);
    let (mut value, mut slope) = decay(low)?;
    if value > -CLOSED {
        return Ok(None);
    }
    for _ in 0..MAX_RAISES {
        // One and a half times the step of the tangent, so that the zero is passed.
        let step = if slope > 0.0 { -1.5 * value / slope } else { 0.5 * low };
        let high = low + step.max(DAMPING_STEP);
        let (at_high, slope_there) = decay(high)?;
        if at_high > 0.0 {
            return newton_between(decay, low, high, low + step / 1.5).map(Some);
        }
        (low, value, slope) = (high, at_high, slope_there);
    }
    Err(VibrationError::NotFound { what: "fold of slip cycles", reason: "its damping ratio keeps growing" })
}

/// Returns the largest ln(P/r) between the ends of the grid of amplitudes.
fn peak(planar: &Planar) -> Result<Option<Growth>, VibrationError> {
    let Some(outer) = planar.detachment()? else { return Ok(None) };
    let mut best: Option<Growth> = None;
    for pair in growths(planar, outer)?.windows(2) {
        if let Some(found) = extremum(planar, [pair[0], pair[1]], -1.0, |_, _| false)? {
            best = best.filter(|best| best.value >= found.value).or(Some(found));
        }
    }
    Ok(best)
}

/// Returns the limit amplitude of orbits that return; zero if all touch, for example around a repelling node.
fn edge(planar: &Planar, mut back: f64, mut touches: f64) -> Result<f64, VibrationError> {
    let least = SMALLEST * touches;
    while touches - back > 4.0 * f64::EPSILON * touches && touches > least {
        let middle = 0.5 * (back + touches);
        match planar.turn(middle)? {
            Turn::Touches => touches = middle,
            Turn::Back(_) | Turn::Settles => back = middle,
        }
    }
    Ok(back)
}

fn cycle(oscillator: &Oscillator, rest: f64, r: f64, lap: &Lap) -> SlipCycle {
    let velocity = oscillator.belt_velocity();
    let displacement = |excess: f64| {
        velocity * (rest + excess) + oscillator.static_friction() - 2.0 * oscillator.damping_ratio() * velocity
    };
    SlipCycle {
        period: lap.time,
        displacement_min: displacement(lap.lowest),
        displacement_max: displacement(r),
        velocity_min: velocity * (1.0 - lap.fastest),
        velocity_max: velocity * (1.0 - lap.slowest),
        multiplier: lap.stretch.exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Coulomb, Exponential, Linear, Stribeck};
    use crate::oracle::Oracle;
    use crate::tests::machine;
    use crate::{FrictionTable, VelocityLaw, critical_damping};
    use asperity_process::Cell;

    #[test]
    fn one_unstable_cycle_lies_exactly_between_the_hopf_point_and_the_fold() {
        for (friction, velocity) in [(0.1, 0.003), (0.3, 0.1), (1.0, 0.2)] {
            let of = |damping| Oscillator::with_stribeck(friction, 4.2, damping, velocity).unwrap();
            let ends = critical_damping(&of(0.0)).unwrap();
            let (low, high) = (ends.hopf_damping_ratio, ends.critical_damping_ratio);
            for fraction in [1e-6, 0.01, 0.5, 0.99, 1.0 - 1e-6] {
                let cycles = slip_cycles(&of(low + fraction * (high - low))).unwrap();
                assert!(cycles.len() == 1 && !cycles[0].is_stable(), "{fraction}: {cycles:?}");
            }
            for outside in [0.5 * low, low * (1.0 - 1e-6), high * (1.0 + 1e-6), 2.0 * high, 5.0] {
                assert_eq!(slip_cycles(&of(outside)).unwrap(), [], "{outside} and {ends:?}");
            }
        }
    }

    #[test]
    fn the_unstable_cycle_ends_where_it_touches_the_belt_velocity() {
        let of = |damping| Oscillator::with_stribeck(0.3, 4.2, damping, 0.1).unwrap();
        let fold = critical_damping(&of(0.0)).unwrap().critical_damping_ratio;
        // The cycle coincides there with the orbit from the detachment.
        let cycle = slip_cycles(&of(fold - 1e-9)).unwrap()[0];
        assert!((cycle.velocity_max - 0.1).abs() < 1e-6 && cycle.velocity_max < 0.1, "{cycle:?}");
    }

    #[test]
    fn the_amplitude_follows_the_normal_form_near_the_hopf_point() {
        for (friction, decay, velocity) in [(0.2, 4.2, 0.05), (0.3, 4.2, 0.1), (1.0, 3.0, 0.2)] {
            let of = |damping| Oscillator::with_stribeck(friction, decay, damping, velocity).unwrap();
            let ends = critical_damping(&of(0.0)).unwrap();
            let width = ends.critical_damping_ratio - ends.hopf_damping_ratio;
            // R′ = (ζ_H − ζ)R + ℓR³ with ℓ = −μ‴(V)/16 (Guckenheimer & Holmes, §3.4). The quadratic part is reversible
            // in time and does not contribute. μ‴ = −6a³μ/(1 + aV)⁴.
            let lyapunov = 6.0 / 16.0 * decay.powi(3) * friction / (1.0_f64 + decay * velocity).powi(4);
            let off = |fraction: f64| {
                let cycle = slip_cycles(&of(ends.hopf_damping_ratio + fraction * width)).unwrap()[0];
                0.5 * (cycle.velocity_max - cycle.velocity_min) / (fraction * width / lyapunov).sqrt() - 1.0
            };
            // √((ζ − ζ_H)/ℓ)·(1 + O(ζ − ζ_H)).
            let (far, near) = (off(1e-2), off(1e-3));
            assert!(near.abs() < 2e-3 && (far / near / 10.0 - 1.0).abs() < 0.05, "{far} and {near}");
        }
    }

    #[test]
    fn laws_without_isolated_cycles_have_none() {
        for (law, damping_ratio) in [
            (VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 }), 0.0),
            (VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 }), 0.01),
            (VelocityLaw::Linear(Linear { kinetic: 0.3, slope: 0.2 }), 0.1),
            (VelocityLaw::Linear(Linear { kinetic: 0.3, slope: 0.2 }), 0.09),
            (VelocityLaw::Linear(Linear { kinetic: 0.3, slope: 0.2 }), 0.1001),
        ] {
            for static_friction in [0.3, 0.31] {
                let law = law.clone();
                assert_eq!(slip_cycles(&machine(static_friction, law, damping_ratio, 0.1)).unwrap(), []);
            }
        }
    }

    #[test]
    fn the_search_finds_no_fold_of_laws_with_a_convex_fall() {
        let rng = &mut asperity_base::random::stream(9, "test", 0);
        for i in 0..30 {
            let g = asperity_base::random::standard_normal(rng, 4);
            let kinetic = 0.5 * g[0].exp();
            let reach = 0.1 * (2.0 * g[1]).exp();
            let law = if i % 2 == 0 {
                VelocityLaw::Stribeck(Stribeck { kinetic, decay: 1.0 / reach })
            } else {
                VelocityLaw::Exponential(Exponential { kinetic, high_speed: 0.1 * kinetic, stribeck_velocity: reach })
            };
            let (static_friction, belt_velocity) = (kinetic * (1.0 + 0.3 * g[3].max(0.0)), reach * (1.5 * g[2]).exp());
            let oscillator = machine(static_friction, law, 0.0, belt_velocity);
            let ends = critical_damping(&oscillator).unwrap();
            let above = ends.critical_damping_ratio.max(ends.hopf_damping_ratio);
            assert_eq!(searched_fold(&oscillator, above).unwrap(), None, "{oscillator:?}");
        }
    }

    #[test]
    fn all_orbits_approach_a_relaxation_oscillation() {
        // Relaxation oscillation: 2ζ dX/dτ = μ − X on the two flat pieces, 0.1 and 0.05 … 0.04, and jumps between them.
        let law = VelocityLaw::Tabulated(
            FrictionTable::new(&[[0.0, 0.1], [0.001, 0.1], [0.0011, 0.05], [1.0, 0.04]]).unwrap(),
        );
        let (damping_ratio, belt_velocity) = (23.0, 0.00105);
        let oscillator = machine(0.1, law, damping_ratio, belt_velocity);
        let cycles = slip_cycles(&oscillator).unwrap();
        let [cycle] = cycles[..] else { panic!("{cycles:?}") };
        assert!(cycle.is_stable() && cycle.velocity_max < belt_velocity, "{cycle:?}");
        // Simulated by its own equation for many periods, the motion has these extremes and crosses its middle at this distance of time.
        let steady = [Cell { end: 1e9, length: 1e9, left: 0.0, right: 0.0 }];
        let mut oracle = Oracle::new(&oscillator, &steady, crate::Drive::Distance, 2e-4);
        let middle = 0.5 * (cycle.displacement_min + cycle.displacement_max);
        let (mut extremes, mut crossings) = ([f64::INFINITY, f64::NEG_INFINITY], Vec::new());
        while oracle.tau < 5.0 * cycle.period {
            let (tau, x) = (oracle.tau, oracle.x);
            oracle.run(tau + 1e-4);
            if tau > 3.0 * cycle.period {
                extremes = [extremes[0].min(oracle.x), extremes[1].max(oracle.x)];
                if x < middle && oracle.x >= middle {
                    crossings.push(tau + (middle - x) / (oracle.x - x) * (oracle.tau - tau));
                }
            }
        }
        let [first, .., last] = crossings[..] else { panic!("{crossings:?}") };
        let period = (last - first) / (crossings.len() - 1) as f64;
        assert!((period / cycle.period - 1.0).abs() < 1e-6, "{period} {cycle:?}");
        for (found, wanted) in extremes.iter().zip([cycle.displacement_min, cycle.displacement_max]) {
            assert!((found - wanted).abs() < 1e-7, "{found} {cycle:?}");
        }
    }

    #[test]
    fn a_repelling_node_has_no_cycle_around_it() {
        let law = VelocityLaw::Stribeck(Stribeck { kinetic: 2.2, decay: 3.6 });
        let map = return_map(&machine(3.2, law, 0.03, 0.02)).unwrap().unwrap();
        assert!(map.cycles.is_empty() && map.growth == [1.0] && map.edge < 1e-3);
    }

    #[test]
    fn the_multiplier_is_the_slope_of_the_return_map() {
        let oscillator = Oscillator::with_stribeck(0.3, 4.2, 0.32, 0.1).unwrap();
        let planar = Planar::new(&oscillator).unwrap();
        let (r, cycle) = return_map(&oscillator).unwrap().unwrap().cycles[0];
        let back = |r: f64| match planar.turn(r).unwrap() {
            Turn::Back(lap) => lap.back,
            other => panic!("{other:?}"),
        };
        assert!((back(r) / r - 1.0).abs() < 1e-14);
        let h = 1e-4 * r;
        let (near, wide) =
            ((back(r + h) - back(r - h)) / (2.0 * h), (back(r + 2.0 * h) - back(r - 2.0 * h)) / (4.0 * h));
        assert!(((4.0 * near - wide) / 3.0 - cycle.multiplier).abs() < 1e-10, "{near} and {}", cycle.multiplier);
    }
}
