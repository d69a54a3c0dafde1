//! Starts that end in steady sliding, and starts that end in vibration.

use serde::{Deserialize, Serialize};

use super::super::cycle::cycle_at_belt;
use super::super::motion::{Motion, SlipState};
use super::super::portrait::{PhasePoint, equally_sampled};
use super::super::slip_orbit::first_minimum_from;
use super::super::weakening::Weakening;
use super::super::{Drive, EventKind, MotionKind, Oscillator, Phase, VibrationError};
use super::planar::Planar;
use super::slip_cycle::{ReturnMap, return_map};
use asperity_base::blocks::Task;
use asperity_base::monitor::Monitor;
use asperity_base::numeric::{bisect, try_root_between};
use asperity_process::Steady;

/// Distance of W and W′ from steady sliding below which the motion ends there, if steady sliding is stable.
const SETTLED: f64 = 1e-9;
/// Number of reversals after which a motion without stick counts as overtaking.
const MAX_REVERSALS: usize = 2000;
const MAX_STEPS: usize = 1_000_000;
const UNDECIDED: VibrationError =
    VibrationError::NotFound { what: "attractor of a start", reason: "undecided after a million steps" };
/// Relative error of a kick.
const KICK_TOLERANCE: f64 = 1e-12;
/// Relative amount by which rounding may put a crossing of the section beyond the crossing of the orbit from a
/// detachment.
const ROUNDING: f64 = 1e-9;

/// Rectangle of starts (X, X′).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BasinBox {
    /// Least and largest X.
    pub displacement: [f64; 2],
    /// Least and largest X′.
    pub velocity: [f64; 2],
    /// Cells along X and X′.
    pub cells: [usize; 2],
}

impl BasinBox {
    /// Returns the centre (X, X′) of a cell.
    pub fn centre(&self, column: usize, row: usize) -> [f64; 2] {
        let at = |[low, high]: [f64; 2], i: usize, n: usize| low + (high - low) * (i as f64 + 0.5) / n as f64;
        [at(self.displacement, column, self.cells[0]), at(self.velocity, row, self.cells[1])]
    }

    fn validate(&self) -> Result<(), VibrationError> {
        for (parameter, [low, high]) in
            [("displacement of the box", self.displacement), ("velocity of the box", self.velocity)]
        {
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(VibrationError::Parameter {
                    parameter,
                    value: high,
                    wanted: "finite, and greater than its lower end",
                });
            }
        }
        if let Some(&few) = self.cells.iter().find(|n| !(1..=100_000).contains(*n)) {
            return Err(VibrationError::Parameter { parameter: "cells", value: few as f64, wanted: "1 to 100,000" });
        }
        Ok(())
    }
}

/// Attractors of the starts at the centres of the cells of a box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Basin {
    /// Box of starts.
    pub area: BasinBox,
    /// Kinds of motion, row by row with rising X′, with rising X in each row.
    pub attractors: Vec<MotionKind>,
    /// Fraction of the cells that end in steady sliding.
    pub sliding_share: f64,
}

/// Returns the motion of a mass at (X, X′) at τ = 0.
pub(super) fn started_at(
    oscillator: &Oscillator,
    displacement: f64,
    velocity: f64,
) -> Result<Motion<Steady>, VibrationError> {
    Motion::started_at(oscillator, Steady, Drive::Distance, [displacement, velocity])
}

/// Next event of an orbit that helps to decide its attractor.
enum Arrival {
    /// Steady sliding.
    Rest,
    /// Stick.
    Stick,
    /// Start or end of over-slip.
    Reversal,
    /// Upward crossing of the section W = 1 at the amplitude r.
    Section(f64),
}

/// Classifier of starts: by the return map of slip as soon as an orbit crosses its section, otherwise by simulation.
pub(super) struct StartClassifier {
    oscillator: Oscillator,
    rest: f64,
    map: Option<ReturnMap>,
    /// Kind of motion after a detachment.
    after_stick: MotionKind,
    /// Least X′ of that motion; 0 for steady sliding.
    slowest: f64,
}

impl StartClassifier {
    /// Creates the classifier of an oscillator, ignoring its forcing.
    pub(super) fn new(oscillator: &Oscillator) -> Result<Self, VibrationError> {
        let oscillator = oscillator.with_forcing(None)?;
        let map = return_map(&oscillator)?;
        let rest = Planar::new(&oscillator)?.rest;
        let (after_stick, slowest) = match cycle_at_belt(&oscillator)? {
            Some((cycle, _)) => (cycle.kind, cycle.velocity_min),
            None => match map.as_ref().and_then(ReturnMap::outermost_attractor) {
                Some((_, cycle)) => (MotionKind::SlipCycle, cycle.velocity_min),
                None => (MotionKind::None, 0.0),
            },
        };
        Ok(Self { oscillator, rest, map, after_stick, slowest })
    }

    /// Returns the kind of motion after a small disturbance of steady sliding.
    pub(super) fn near_rest(&self) -> MotionKind {
        self.map.as_ref().map_or(MotionKind::None, |map| self.within(map, 0.0))
    }

    /// Returns the kind of motion after the start (X, X′).
    pub(super) fn kind(&self, displacement: f64, velocity: f64) -> Result<MotionKind, VibrationError> {
        let mut motion = started_at(&self.oscillator, displacement, velocity)?;
        let mut reversals = 0;
        for _ in 0..MAX_STEPS {
            match self.next_arrival(&mut motion)? {
                Arrival::Rest => return Ok(self.near_rest()),
                Arrival::Stick => return Ok(self.after_stick),
                Arrival::Reversal => reversals += 1,
                Arrival::Section(r) => {
                    if let Some(map) = self.map.as_ref().filter(|map| r <= map.edge * (1.0 + ROUNDING)) {
                        return Ok(self.within(map, r.min(map.edge)));
                    }
                }
            }
            if reversals > MAX_REVERSALS {
                return Ok(MotionKind::Overtaking);
            }
        }
        Err(UNDECIDED)
    }

    fn next_arrival(&self, motion: &mut Motion<Steady>) -> Result<Arrival, VibrationError> {
        for _ in 0..MAX_STEPS {
            // Checked before a step, because a step from rest itself has no end.
            if motion.has_settled(SETTLED) {
                return Ok(Arrival::Rest);
            }
            let Some(before) = motion.slip_state() else { return Ok(Arrival::Stick) };
            match motion.step(f64::INFINITY)?.map(|e| e.kind) {
                Some(EventKind::Restick) => return Ok(Arrival::Stick),
                Some(EventKind::Reverse | EventKind::Detach) => return Ok(Arrival::Reversal),
                None => {}
            }
            if before.phase == Phase::Slip
                && before.w < 1.0
                && let Some(r) = self.crossing(motion)
            {
                return Ok(Arrival::Section(r));
            }
        }
        Err(UNDECIDED)
    }

    /// Returns the crossing of W = 1 in the last step of slip, which started below it.
    fn crossing(&self, motion: &Motion<Steady>) -> Option<f64> {
        let step = motion.slip_step()?;
        if step.series.state(step.length).0 < 1.0 {
            return None;
        }
        let mut below = step.series.w().to_vec();
        below.iter_mut().for_each(|c| *c = -*c);
        below[0] += 1.0;
        let t = super::super::polynomial::first_zero(&below, step.length)?;
        Some(step.series.state(t).1 - self.rest)
    }

    /// Returns the long-term motion of an orbit that crosses the section at r.
    fn within(&self, map: &ReturnMap, r: f64) -> MotionKind {
        let inside = map.cycles.iter().take_while(|(radius, _)| *radius < r).count();
        // An orbit on a stable cycle or close to one stays. Growth leads outwards to the next cycle, decay inwards.
        if map.growth[inside] > 0.0 {
            if inside < map.cycles.len() { MotionKind::SlipCycle } else { self.after_stick }
        } else if inside > 0 {
            MotionKind::SlipCycle
        } else {
            MotionKind::None
        }
    }
}

/// Returns the smallest kick, |ΔX′| of either sign, after which a machine that slides steadily vibrates permanently.
/// Forcing is ignored.
///
/// Returns none if steady sliding is unstable, so that no kick is needed, and none if every motion ends in steady
/// sliding. The border of the basin is the innermost unstable slip cycle if it stays slower than the belt, otherwise an
/// orbit through stick. It is found to twelve digits on exact motions. Orbits in the phase plane do not cross, so all
/// larger kicks of the same sign also end in vibration.
pub fn smallest_kick(oscillator: &Oscillator) -> Result<Option<f64>, VibrationError> {
    if oscillator.sliding_is_unstable() {
        return Ok(None);
    }
    let belt = oscillator.belt_velocity();
    let classifier = StartClassifier::new(oscillator)?;
    if !classifier.after_stick.is_vibration() || classifier.near_rest().is_vibration() {
        return Ok(None);
    }
    let rest = oscillator.law().coefficient(belt);
    // Positive outside the basin of steady sliding.
    let excess = |velocity: f64| -> Result<f64, VibrationError> {
        let Some((border, _)) = classifier.map.as_ref().and_then(|map| map.cycles.first()) else {
            return Ok(if classifier.kind(rest, velocity)?.is_vibration() { 1.0 } else { -1.0 });
        };
        Ok(match classifier.next_arrival(&mut started_at(&classifier.oscillator, rest, velocity)?)? {
            Arrival::Section(r) => r / border - 1.0,
            Arrival::Rest => -1.0,
            Arrival::Stick | Arrival::Reversal => 1.0,
        })
    };
    let smooth = classifier.map.as_ref().is_some_and(|map| !map.cycles.is_empty());
    let threshold = |sign: f64, high: f64| -> Result<f64, VibrationError> {
        let tolerance = KICK_TOLERANCE * high;
        if smooth {
            let ends = [[0.0, -1.0], [high, excess(sign * high)?]];
            let root = try_root_between(|velocity| excess(sign * velocity), ends[0], ends[1], tolerance)?;
            return Ok(root.unwrap_or(high));
        }
        let ends_in_vibration = |velocity| excess(sign * velocity).map(|excess| excess > 0.0);
        Ok(bisect(high, 0.0, tolerance, ends_in_vibration)?[0])
    };
    // At the velocity of the belt the mass sticks, or it is faster than on any orbit that does not reach the belt.
    let with_belt = threshold(1.0, belt)?;
    let against_belt = with_belt.min(-classifier.slowest);
    Ok(Some(if excess(-against_belt)? > 0.0 { threshold(-1.0, against_belt)? } else { with_belt }))
}

/// Returns the attractors of the starts in a box of the phase plane. Forcing is ignored.
///
/// Each start is followed to stick or to the section X′ = 0, where the return map of slip decides. The result is exact
/// except for rounding at the separatrix. Rows are computed in parallel; the result does not depend on the number of
/// threads.
///
/// Fails for an empty box, if friction does not stay positive, or when cancelled.
pub fn basin(oscillator: &Oscillator, area: &BasinBox, monitor: &dyn Monitor) -> Result<Basin, VibrationError> {
    area.validate()?;
    let classifier = StartClassifier::new(oscillator)?;
    let [columns, rows] = area.cells;
    let task = Task::new(monitor, "rows of the basin", rows);
    let lines = task.map(rows, |row| {
        let start = |column| {
            let [displacement, velocity] = area.centre(column, row);
            classifier.kind(displacement, velocity)
        };
        (0..columns).map(start).collect::<Result<Vec<MotionKind>, VibrationError>>()
    })?;
    let attractors = lines.concat();
    let sliding = attractors.iter().filter(|a| **a == MotionKind::None).count();
    let sliding_share = sliding as f64 / attractors.len() as f64;
    Ok(Basin { area: *area, attractors, sliding_share })
}

/// Kind of a separatrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SeparatrixKind {
    /// The outermost unstable cycle of slip, a closed orbit.
    UnstableCycle,
    /// The orbit of slip that touches the belt velocity, closed by a piece of the line X′ = V on which the mass sticks.
    /// It exists only if the friction force jumps at detachment.
    GrazingOrbit,
}

/// Border of the basin of steady sliding, or of the inner one of two vibrations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Separatrix {
    /// Kind of the separatrix.
    pub kind: SeparatrixKind,
    /// Points of the curve at equal times, including its end.
    pub points: Vec<PhasePoint>,
}

impl Separatrix {
    /// Returns the area of the (X, X′) plane inside, by the trapezoidal rule on the points and the chord from end to
    /// start.
    pub fn area(&self) -> f64 {
        let ring = self.points.iter().zip(self.points.iter().cycle().skip(1));
        let sum: f64 = ring.map(|(a, b)| a.displacement * b.velocity - b.displacement * a.velocity).sum();
        0.5 * sum.abs()
    }
}

/// Returns the curve that separates starts that end in vibration from starts that do not, at `points` ≥ 2 equal times;
/// none if all starts have the same attractor. With two stable vibrations it separates the outer one from the inner
/// one. Forcing is ignored.
pub fn separatrix(oscillator: &Oscillator, points: usize) -> Result<Option<Separatrix>, VibrationError> {
    let free = oscillator.with_forcing(None)?;
    let classifier = StartClassifier::new(&free)?;
    let Some(map) = classifier.map.as_ref().filter(|_| classifier.after_stick.is_vibration()) else { return Ok(None) };
    let drawn = |kind, state: SlipState, duration: f64| -> Result<Option<Separatrix>, VibrationError> {
        let motion = Motion::from_slip(&free, Steady, state)?;
        Ok(Some(Separatrix { kind, points: equally_sampled(motion, 0.0, duration, points)? }))
    };
    let unstable = map.cycles.iter().zip(&map.growth[1..]).rev().find(|(_, growth)| **growth > 0.0);
    if let Some(((r, cycle), _)) = unstable {
        return drawn(SeparatrixKind::UnstableCycle, map.state(*r), cycle.period);
    }
    let grows = map.growth.last().is_some_and(|g| *g > 0.0);
    let jump = Weakening::new(&free).jump;
    if grows || jump == 0.0 {
        return Ok(None);
    }
    // The orbit that rises from the belt at an excess between −jump and 0 and returns to touch the belt velocity.
    let least = |e: f64| -> Result<f64, VibrationError> {
        Ok(first_minimum_from(&free, 0.0, e, |_, _| {})?.map_or(1.0, |minimum| minimum.w))
    };
    let (near, far) = (least(-jump * (1.0 - 1e-9))?, least(0.0)?);
    if near <= 0.0 || far >= 0.0 {
        return Ok(None);
    }
    let Some(e) = try_root_between(least, [0.0, far], [-jump * (1.0 - 1e-9), near], 0.0)? else { return Ok(None) };
    let Some(minimum) = first_minimum_from(&free, 0.0, e, |_, _| {})? else { return Ok(None) };
    // The touch is tangential: with rounding it may be an arrival slightly earlier.
    drawn(SeparatrixKind::GrazingOrbit, SlipState { tau: 0.0, phase: Phase::Slip, w: 0.0, e }, minimum.time)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Coulomb, Exponential, Stribeck};
    use crate::tests::machine;
    use crate::{FrictionTable, VelocityLaw, critical_damping, limit_cycle, limit_damping};
    use asperity_base::monitor::Silent;
    use asperity_base::random;

    fn midway(friction: f64, velocity: f64, fraction: f64) -> Oscillator {
        let of = |damping| Oscillator::with_stribeck(friction, 4.2, damping, velocity).unwrap();
        let ends = critical_damping(&of(0.0)).unwrap();
        of(ends.hopf_damping_ratio + fraction * (ends.critical_damping_ratio - ends.hopf_damping_ratio))
    }

    fn coulomb(damping_ratio: f64) -> Oscillator {
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 });
        machine(0.4, law, damping_ratio, 0.05)
    }

    const AREA: BasinBox = BasinBox { displacement: [-0.3, 0.8], velocity: [-0.3, 0.3], cells: [120, 90] };

    /// Simulates a start until it sticks or has settled, without the return map.
    fn followed(oscillator: &Oscillator, [x, velocity]: [f64; 2]) -> MotionKind {
        let belt = oscillator.belt_velocity();
        let (phase, sign) = if velocity < belt { (Phase::Slip, 1.0) } else { (Phase::OverSlip, -1.0) };
        let force = sign * (x + 2.0 * oscillator.damping_ratio() * belt);
        let e = (force - oscillator.static_friction()) / belt;
        let state = SlipState { tau: 0.0, phase, w: (1.0 - velocity / belt).abs(), e };
        let mut motion = Motion::from_slip(oscillator, Steady, state).unwrap();
        loop {
            if motion.step(f64::INFINITY).unwrap().is_some_and(|event| event.kind == EventKind::Restick) {
                return MotionKind::StickSlip;
            }
            if motion.has_settled(1e-4) {
                return MotionKind::None;
            }
        }
    }

    #[test]
    fn the_return_map_agrees_with_simulation() {
        for (oscillator, case) in [
            (midway(0.3, 0.1, 0.5), "one unstable cycle"),
            (midway(1.0, 0.2, 0.2), "near the Hopf point"),
            (coulomb(0.05), "a grazing orbit"),
        ] {
            let classifier = StartClassifier::new(&oscillator).unwrap();
            let scale = oscillator.static_friction();
            let rng = &mut random::stream(8, "test", 0);
            let mut counts = [0, 0];
            for _ in 0..300 {
                let g = random::standard_normal(rng, 2);
                let start = [scale * (0.8 + 0.3 * g[0]), 1.3 * oscillator.belt_velocity() * g[1]];
                let found = classifier.kind(start[0], start[1]).unwrap();
                assert_eq!(found, followed(&oscillator, start), "{case}: {start:?}");
                counts[usize::from(found == MotionKind::None)] += 1;
            }
            assert!(counts[0] > 10 && counts[1] > 10, "{case}: {counts:?}");
        }
    }

    #[test]
    fn the_sliding_fraction_of_a_box_is_the_area_inside_the_separatrix() {
        for (oscillator, kind) in [
            (midway(0.3, 0.1, 0.5), SeparatrixKind::UnstableCycle),
            (midway(0.3, 0.1, 0.9), SeparatrixKind::UnstableCycle),
            (coulomb(0.05), SeparatrixKind::GrazingOrbit),
        ] {
            let found = basin(&oscillator, &AREA, &Silent).unwrap();
            let curve = separatrix(&oscillator, 4001).unwrap().unwrap();
            assert_eq!(curve.kind, kind);
            let size = (AREA.displacement[1] - AREA.displacement[0]) * (AREA.velocity[1] - AREA.velocity[0]);
            // The error of counting centres is much less than a cell for each cell on the curve, about 100 of them.
            let cell = size / found.attractors.len() as f64;
            assert!((found.sliding_share * size - curve.area()).abs() < 10.0 * cell, "{kind:?}: {}", curve.area());
            assert!(curve.area() > 100.0 * cell);
        }
    }

    #[test]
    fn the_grazing_orbit_of_coulomb_friction_is_a_damped_oscillation() {
        let (damping, velocity) = (0.05, 0.05);
        let curve = separatrix(&coulomb(damping), 301).unwrap().unwrap();
        let end = curve.points[300];
        let frequency = f64::sqrt(1.0 - damping * damping);
        for point in &curve.points {
            // The orbit ends at X′ = V, X″ = 0, where X − μ_k = −2ζV.
            let t = point.tau - end.tau;
            let (x0, v0) = (-2.0 * damping * velocity, velocity);
            let (sin, cos) = (frequency * t).sin_cos();
            let x = (-damping * t).exp() * (x0 * cos + (v0 + damping * x0) / frequency * sin);
            assert!((point.displacement - 0.3 - x).abs() < 1e-12, "{point:?}");
        }
        assert!((curve.points[0].velocity - velocity).abs() < 1e-15);
    }

    #[test]
    fn outside_the_two_critical_dampings_all_starts_have_one_attractor() {
        let ends = critical_damping(&midway(0.3, 0.1, 0.5)).unwrap();
        for (damping, wanted) in [
            (0.9 * ends.hopf_damping_ratio, MotionKind::StickSlip),
            (1.01 * ends.critical_damping_ratio, MotionKind::None),
            (3.0, MotionKind::None),
        ] {
            let oscillator = Oscillator::with_stribeck(0.3, 4.2, damping, 0.1).unwrap();
            let area = BasinBox { cells: [20, 20], ..AREA };
            let found = basin(&oscillator, &area, &Silent).unwrap();
            assert!(found.attractors.iter().all(|a| *a == wanted), "{damping}");
            assert_eq!(separatrix(&oscillator, 100).unwrap(), None);
        }
    }

    #[test]
    fn the_smallest_kick_matches_the_publication() {
        // Reference: SciPy, DOP853 with bisection.
        for (damping, wanted) in [(0.111, 0.0966), (0.109, 0.0821)] {
            let found = smallest_kick(&Oscillator::with_stribeck(0.1, 4.2, damping, 0.1).unwrap()).unwrap().unwrap();
            assert!((found - wanted).abs() < 2e-4, "{found} instead of {wanted}");
        }
        // A kick into a slip cycle, in the direction of the belt, to relative 2e-5: .3 + .1e^{−(v/.08)²} at V = .11 and
        // ζ = .27.
        let bell = |v: f64| 0.3 + 0.1 * (-(v / 0.08).powi(2)).exp();
        let points: Vec<_> = (0..=400).map(|i| 1e-3 * f64::from(i)).map(|v| [v, bell(v)]).collect();
        let law = VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap());
        let found = smallest_kick(&machine(0.4, law, 0.27, 0.11)).unwrap().unwrap();
        assert!((found / 0.040_666 - 1.0).abs() < 1e-4, "{found}");
        // Below ζ_H = .104 no kick is needed; above ζ_c = .1115 no kick is sufficient.
        for damping in [0.1041, 0.1116, 0.9] {
            assert_eq!(smallest_kick(&Oscillator::with_stribeck(0.1, 4.2, damping, 0.1).unwrap()).unwrap(), None);
        }
    }

    #[test]
    fn the_kick_over_a_jump_of_friction_is_the_closed_form_of_a_damped_oscillation() {
        let (damping, belt, kinetic) = (0.05_f64, 0.05_f64, 0.25);
        let law = VelocityLaw::Coulomb(Coulomb { kinetic });
        let machine = machine(0.3, law, damping, belt);
        let classifier = StartClassifier::new(&machine).unwrap();
        // Against the belt: the orbit that grazes it at X − μ_k = −2ζV, X′ = V, half a turn earlier at X = μ_k.
        let (x0, frequency) = (-2.0 * damping * belt, (1.0 - damping * damping).sqrt());
        let rate = (belt + damping * x0) / frequency;
        let t = ((-x0 / rate).atan() - std::f64::consts::PI) / frequency;
        let (sin, cos) = (frequency * t).sin_cos();
        let against =
            (-damping * t).exp() * ((rate * frequency - damping * x0) * cos - (x0 * frequency + damping * rate) * sin);
        assert!((against + 0.0583).abs() < 1e-4, "{against}");
        for (factor, wanted) in [(1.0 - 1e-9, MotionKind::None), (1.0 + 1e-9, MotionKind::StickSlip)] {
            assert_eq!(classifier.kind(kinetic, factor * against).unwrap(), wanted);
        }
        // In the direction of the belt: the belt velocity, at which the mass sticks.
        assert!((smallest_kick(&machine).unwrap().unwrap() / belt - 1.0).abs() < 1e-11);
    }

    /// Steps per natural period of the independent integrator.
    const STEPS: f64 = 800.0;

    /// Returns whether a kick ends in vibration, by the classical Runge–Kutta method with separate branches of sign(V −
    /// X′). The motion has decayed if the largest velocity of a period is at most half of the kick. Stick, or 200
    /// periods without decay, is vibration.
    fn vibrates(machine: &Oscillator, kick: f64) -> bool {
        let (belt, zeta) = (machine.belt_velocity(), machine.damping_ratio());
        let rest = machine.law().coefficient(belt);
        let (mut x, mut v, mut over) = (rest, kick, kick > belt);
        let h = std::f64::consts::TAU / STEPS;
        let (mut largest, mut sticks) = (0.0_f64, 0);
        for i in 1..=(200.0 * STEPS) as usize {
            let sign = if over { -1.0 } else { 1.0 };
            let force = |x: f64, v: f64| sign * machine.law().coefficient((belt - v).abs()) - 2.0 * zeta * v - x;
            let step = |h: f64| {
                let (k1, l1) = (v, force(x, v));
                let (k2, l2) = (v + 0.5 * h * l1, force(x + 0.5 * h * k1, v + 0.5 * h * l1));
                let (k3, l3) = (v + 0.5 * h * l2, force(x + 0.5 * h * k2, v + 0.5 * h * l2));
                let (k4, l4) = (v + h * l3, force(x + h * k3, v + h * l3));
                (x + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4), v + h / 6.0 * (l1 + 2.0 * (l2 + l3) + l4))
            };
            let after = step(h);
            if sign * (belt - after.1) < 0.0 {
                let (mut low, mut high) = (0.0, h);
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    if sign * (belt - step(middle).1) < 0.0 { high = middle } else { low = middle }
                }
                x = step(low).0;
                let held = x + 2.0 * zeta * belt;
                if held.abs() <= machine.static_friction() {
                    sticks += 1;
                    if sticks > 3 {
                        return true;
                    }
                    x = machine.static_friction() - 2.0 * zeta * belt;
                }
                over = held < -machine.static_friction();
                v = if over { belt * (1.0 + 1e-12) } else { belt * (1.0 - 1e-12) };
                largest = belt;
                continue;
            }
            (x, v) = after;
            largest = largest.max(v.abs());
            if i % STEPS as usize == 0 {
                if largest < 0.5 * kick.abs().min(belt) {
                    return false;
                }
                largest = 0.0;
            }
        }
        true
    }

    #[test]
    fn kicks_of_random_machines_separate_vibration_from_decay_in_an_independent_integrator() {
        let rng = &mut random::stream(17, "test", 0);
        let (mut count, mut slow) = (0, 0);
        for i in 0..40 {
            let g = random::standard_normal(rng, 4);
            let static_friction = 0.25 * (0.4 * g[0]).exp();
            let kinetic =
                if i % 2 == 0 { static_friction } else { static_friction * (1.0 - 0.1 * g[1].abs().min(3.0)) };
            let belt_velocity = 0.2 * (0.5 * g[2]).exp();
            let reach = 0.8 * belt_velocity * (0.3 * g[3]).exp();
            let bell = |v: f64| 0.7 * kinetic + 0.3 * kinetic * (-(v / reach).powi(2)).exp();
            let law = match i % 4 {
                0 | 1 => VelocityLaw::Stribeck(Stribeck { kinetic, decay: 1.5 / reach }),
                2 => VelocityLaw::Exponential(Exponential {
                    kinetic,
                    high_speed: 0.6 * kinetic,
                    stribeck_velocity: reach,
                }),
                _ => {
                    let points: Vec<_> = (0..60).map(|i| 0.1 * reach * f64::from(i)).map(|v| [v, bell(v)]).collect();
                    VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap())
                }
            };
            let machine = |damping_ratio| {
                let law = law.clone();
                machine(static_friction, law, damping_ratio, belt_velocity)
            };
            let hopf = 0.5 * law.weakening(belt_velocity);
            let limit = limit_damping(&machine(0.0)).unwrap();
            // Close to the Hopf point, motions take hundreds of periods to grow or decay.
            if limit < hopf + 0.01 {
                continue;
            }
            let machine = machine(hopf + 0.6 * (limit - hopf));
            let kick = smallest_kick(&machine).unwrap().unwrap();
            let either = |factor: f64| vibrates(&machine, factor * kick) || vibrates(&machine, -factor * kick);
            assert!(!either(0.96) && either(1.04), "{kick} of {machine:?}");
            count += 1;
            slow += usize::from(limit_cycle(&machine).unwrap().kind() == MotionKind::SlipCycle);
        }
        assert!(count > 15 && slow > 0, "{count} machines, {slow} slip cycles");
    }

    #[test]
    fn an_empty_box_is_refused() {
        let oscillator = midway(0.3, 0.1, 0.5);
        for area in [
            BasinBox { displacement: [0.3, 0.3], ..AREA },
            BasinBox { velocity: [0.0, f64::NAN], ..AREA },
            BasinBox { cells: [0, 5], ..AREA },
        ] {
            assert!(matches!(basin(&oscillator, &area, &Silent), Err(VibrationError::Parameter { .. })));
        }
    }
}
