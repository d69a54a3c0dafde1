//! Which starts end in steady sliding, and which in stick-slip.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::super::motion::{Motion, SlipState};
use super::super::portrait::{PhasePoint, sampled};
use super::super::root::zero_between;
use super::super::slip_orbit::first_minimum_from;
use super::super::sway::Sway;
use super::super::weakening::Weakening;
use super::super::{Drive, EventKind, Oscillator, Phase, Regime, VibrationError, limit_cycle};
use super::planar::Planar;
use super::slip_cycle::{ReturnMap, return_map};
use crate::friction::process::Steady;
use crate::monitor::{Cancelled, Monitor};

/// W and W′ closer than this to steady sliding end there, if it is stable.
const SETTLED: f64 = 1e-9;
/// Reversals after which a motion that never sticks counts as a cycle of slip and over-slip.
const MAX_REVERSALS: usize = 2000;
const MAX_STEPS: usize = 1_000_000;
/// How far, relatively, rounding may put a crossing of the section beyond that of the orbit from a detachment.
const ROUNDING: f64 = 1e-9;

/// Where a motion without forcing and fluctuation ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Attractor {
    /// Steady sliding, X′ = 0.
    Sliding,
    /// A stable cycle that stays slower than the belt.
    SlipCycle,
    /// The cycle that reaches the belt velocity.
    StickSlip,
}

/// A rectangle of starts (X, X′).
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
    /// The centre (X, X′) of a cell.
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
                    wanted: "finite, and more than its least",
                });
            }
        }
        if let Some(&few) = self.cells.iter().find(|n| !(1..=100_000).contains(*n)) {
            return Err(VibrationError::Parameter { parameter: "cells", value: few as f64, wanted: "1 to 100,000" });
        }
        Ok(())
    }
}

/// What the centres of the cells of a box of starts end in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Basin {
    /// The box.
    pub area: BasinBox,
    /// Attractors, row by row with rising X′, along rising X in a row.
    pub attractors: Vec<Attractor>,
    /// Share of the cells that end in steady sliding.
    pub sliding_share: f64,
}

/// A mass at (X, X′) at τ = 0.
pub(super) fn started_at(
    oscillator: &Oscillator,
    displacement: f64,
    velocity: f64,
) -> Result<Motion<Steady>, VibrationError> {
    let belt = oscillator.belt_velocity();
    let w = 1.0 - velocity / belt;
    if w == 0.0 {
        return Motion::new(oscillator, Steady, Drive::Distance, displacement);
    }
    let phase = if w > 0.0 { Phase::Slip } else { Phase::OverSlip };
    let external = belt * Sway::new(oscillator).force(0.0);
    let force = phase.direction() * (displacement + 2.0 * oscillator.damping_ratio() * belt - external);
    let e = (force - oscillator.static_friction()) / belt;
    Motion::in_slip(oscillator, Steady, SlipState { tau: 0.0, phase, w: w.abs(), e })
}

/// Decides where starts end: by the return map of slip as soon as an orbit crosses its section, else by following it.
pub(super) struct Fates {
    oscillator: Oscillator,
    rest: f64,
    map: Option<ReturnMap>,
    /// What a detachment leads to.
    after_stick: Attractor,
}

impl Fates {
    /// The forcing is left aside.
    pub(super) fn new(oscillator: &Oscillator) -> Result<Self, VibrationError> {
        let oscillator = oscillator.with_forcing(None)?;
        let map = return_map(&oscillator)?;
        let rest = Planar::new(&oscillator)?.rest;
        let mut fates = Self { oscillator: oscillator.clone(), rest, map, after_stick: Attractor::StickSlip };
        if limit_cycle(&oscillator)? == Regime::Sliding {
            fates.after_stick = match &fates.map {
                Some(map) => within(map, map.edge),
                None => Attractor::Sliding,
            };
        }
        Ok(fates)
    }

    /// Whether steady sliding attracts, a continuum of cycles about it included.
    pub(super) fn near_rest(&self) -> Attractor {
        self.map.as_ref().map_or(Attractor::Sliding, |map| within(map, 0.0))
    }

    /// Where the start (X, X′) ends.
    pub(super) fn of(&self, displacement: f64, velocity: f64) -> Result<Attractor, VibrationError> {
        let mut motion = started_at(&self.oscillator, displacement, velocity)?;
        let mut reversals = 0;
        for _ in 0..MAX_STEPS {
            // Looked at before a step: from rest itself a step has no end.
            if motion.has_settled(SETTLED) {
                return Ok(self.near_rest());
            }
            let before = match motion.slip_state() {
                None => return Ok(self.after_stick),
                Some(state) => state,
            };
            match motion.step(f64::INFINITY)?.map(|e| e.kind) {
                Some(EventKind::Restick) => return Ok(self.after_stick),
                Some(EventKind::Reverse | EventKind::Detach) => reversals += 1,
                None => {}
            }
            if reversals > MAX_REVERSALS {
                return Ok(Attractor::StickSlip);
            }
            if before.phase == Phase::Slip
                && before.w < 1.0
                && let Some(map) = &self.map
                && let Some(r) = self.crossing(&motion)
                && r <= map.edge * (1.0 + ROUNDING)
            {
                return Ok(within(map, r.min(map.edge)));
            }
        }
        Err(VibrationError::NotFound { what: "attractor of a start", reason: "undecided after a million steps" })
    }

    /// Where the last step of slip, which began below W = 1, crosses it.
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
}

/// What an orbit ends in that crosses the section at r.
fn within(map: &ReturnMap, r: f64) -> Attractor {
    let inside = map.cycles.iter().take_while(|(radius, _)| *radius < r).count();
    // An orbit on a stable cycle or next to one stays; growth leads outwards to the next, decay inwards.
    if map.growth[inside] > 0.0 {
        if inside < map.cycles.len() { Attractor::SlipCycle } else { Attractor::StickSlip }
    } else if inside > 0 {
        Attractor::SlipCycle
    } else {
        Attractor::Sliding
    }
}

/// What the starts in a box of the phase plane end in. Forcing is left aside.
///
/// Each start is followed to stick or to the section X′ = 0, where the return map of slip decides; the answer is exact but
/// for rounding at the separatrix. Rows are computed in parallel, with the same result on any number of threads.
///
/// Fails for an empty box, if friction does not stay positive, and when cancelled.
pub fn basin(oscillator: &Oscillator, area: &BasinBox, monitor: &dyn Monitor) -> Result<Basin, VibrationError> {
    area.validate()?;
    let fates = Fates::new(oscillator)?;
    let [columns, rows] = area.cells;
    let finished = AtomicUsize::new(0);
    let lines: Vec<Vec<Attractor>> = (0..rows)
        .into_par_iter()
        .map(|row| {
            if monitor.cancelled() {
                return Err(Cancelled.into());
            }
            let start = |column| {
                let [displacement, velocity] = area.centre(column, row);
                fates.of(displacement, velocity)
            };
            let line = (0..columns).map(start).collect::<Result<Vec<_>, _>>();
            monitor.progress("rows of the basin", finished.fetch_add(1, Ordering::Relaxed) + 1, rows);
            line
        })
        .collect::<Result<_, VibrationError>>()?;
    let attractors = lines.concat();
    let sliding = attractors.iter().filter(|a| **a == Attractor::Sliding).count();
    let sliding_share = sliding as f64 / attractors.len() as f64;
    Ok(Basin { area: *area, attractors, sliding_share })
}

/// What a separatrix is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SeparatrixKind {
    /// The outermost unstable cycle of slip, a closed orbit.
    UnstableCycle,
    /// The orbit of slip that only touches the belt velocity, closed by a piece of the line X′ = V on which the mass
    /// sticks. It takes a jump of the friction force at detachment.
    GrazingOrbit,
}

/// The border of the basin of steady sliding, or of what lives next to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Separatrix {
    /// What it is.
    pub kind: SeparatrixKind,
    /// The curve at equal times, its end included.
    pub points: Vec<PhasePoint>,
}

impl Separatrix {
    /// Area of the (X, X′) plane inside, by the trapezoidal rule on its points and the chord from end to start.
    pub fn area(&self) -> f64 {
        let ring = self.points.iter().zip(self.points.iter().cycle().skip(1));
        let sum: f64 = ring.map(|(a, b)| a.displacement * b.velocity - b.displacement * a.velocity).sum();
        0.5 * sum.abs()
    }
}

/// The curve that parts the starts that end in stick-slip from those that do not, at `points` ≥ 2 equal times; none if all
/// end alike. Forcing is left aside.
pub fn separatrix(oscillator: &Oscillator, points: usize) -> Result<Option<Separatrix>, VibrationError> {
    let free = oscillator.with_forcing(None)?;
    let fates = Fates::new(&free)?;
    let Some(map) = fates.map.as_ref().filter(|_| fates.after_stick == Attractor::StickSlip) else { return Ok(None) };
    let drawn = |kind, state: SlipState, duration: f64| -> Result<Option<Separatrix>, VibrationError> {
        let motion = Motion::in_slip(&free, Steady, state)?;
        Ok(Some(Separatrix { kind, points: sampled(motion, 0.0, duration, points)? }))
    };
    let grows = map.growth.last().is_some_and(|g| *g > 0.0);
    if let Some((r, cycle)) = map.cycles.last().filter(|_| grows) {
        let start = SlipState { tau: 0.0, phase: Phase::Slip, w: 1.0, e: fates.rest + r };
        return drawn(SeparatrixKind::UnstableCycle, start, cycle.period);
    }
    let jump = Weakening::new(&free).jump;
    if grows || jump == 0.0 {
        return Ok(None);
    }
    // The orbit that rises from the belt at an excess between −jump and 0 and comes back to touch it.
    let least = |e: f64| -> Result<f64, VibrationError> {
        Ok(first_minimum_from(&free, 0.0, e, |_, _| {})?.map_or(1.0, |minimum| minimum.w))
    };
    let (near, far) = (least(-jump * (1.0 - 1e-9))?, least(0.0)?);
    if near <= 0.0 || far >= 0.0 {
        return Ok(None);
    }
    let e = zero_between(least, (0.0, far), (-jump * (1.0 - 1e-9), near), 0.0)?;
    let Some(minimum) = first_minimum_from(&free, 0.0, e, |_, _| {})? else { return Ok(None) };
    // The touch is tangential: rounding may make it an arrival a little before.
    drawn(SeparatrixKind::GrazingOrbit, SlipState { tau: 0.0, phase: Phase::Slip, w: 0.0, e }, minimum.time)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;
    use crate::random;
    use crate::vibration::{FrictionLaw, Parameters, critical_damping};

    fn midway(friction: f64, velocity: f64, share: f64) -> Oscillator {
        let of = |damping| Oscillator::stribeck(friction, 4.2, damping, velocity).unwrap();
        let ends = critical_damping(&of(0.0)).unwrap();
        of(ends.hopf_damping_ratio + share * (ends.critical_damping_ratio - ends.hopf_damping_ratio))
    }

    fn coulomb(damping_ratio: f64) -> Oscillator {
        let law = FrictionLaw::Coulomb { kinetic: 0.3 };
        Oscillator::new(Parameters { static_friction: 0.4, law, damping_ratio, belt_velocity: 0.05, forcing: None })
            .unwrap()
    }

    const AREA: BasinBox = BasinBox { displacement: [-0.3, 0.8], velocity: [-0.3, 0.3], cells: [120, 90] };

    /// Follows a start until it sticks or has settled, with no look at the return map.
    fn followed(oscillator: &Oscillator, [x, velocity]: [f64; 2]) -> Attractor {
        let belt = oscillator.belt_velocity();
        let (phase, sign) = if velocity < belt { (Phase::Slip, 1.0) } else { (Phase::OverSlip, -1.0) };
        let force = sign * (x + 2.0 * oscillator.damping_ratio() * belt);
        let e = (force - oscillator.static_friction()) / belt;
        let state = SlipState { tau: 0.0, phase, w: (1.0 - velocity / belt).abs(), e };
        let mut motion = Motion::in_slip(oscillator, Steady, state).unwrap();
        loop {
            if motion.step(f64::INFINITY).unwrap().is_some_and(|event| event.kind == EventKind::Restick) {
                return Attractor::StickSlip;
            }
            if motion.has_settled(1e-4) {
                return Attractor::Sliding;
            }
        }
    }

    #[test]
    fn the_map_decides_as_following_does() {
        for (oscillator, tell) in [
            (midway(0.3, 0.1, 0.5), "one unstable cycle"),
            (midway(1.0, 0.2, 0.2), "near the Hopf point"),
            (coulomb(0.05), "a grazing orbit"),
        ] {
            let fates = Fates::new(&oscillator).unwrap();
            let scale = oscillator.static_friction();
            let rng = &mut random::stream(8, "test", 0);
            let mut counts = [0, 0];
            for _ in 0..300 {
                let g = random::standard_normal(rng, 2);
                let start = [scale * (0.8 + 0.3 * g[0]), 1.3 * oscillator.belt_velocity() * g[1]];
                let found = fates.of(start[0], start[1]).unwrap();
                assert_eq!(found, followed(&oscillator, start), "{tell}: {start:?}");
                counts[usize::from(found == Attractor::Sliding)] += 1;
            }
            assert!(counts[0] > 10 && counts[1] > 10, "{tell}: {counts:?}");
        }
    }

    #[test]
    fn the_sliding_share_of_a_box_is_the_area_inside_the_separatrix() {
        for (oscillator, kind) in [
            (midway(0.3, 0.1, 0.5), SeparatrixKind::UnstableCycle),
            (midway(0.3, 0.1, 0.9), SeparatrixKind::UnstableCycle),
            (coulomb(0.05), SeparatrixKind::GrazingOrbit),
        ] {
            let found = basin(&oscillator, &AREA, &Silent).unwrap();
            let curve = separatrix(&oscillator, 4001).unwrap().unwrap();
            assert_eq!(curve.kind, kind);
            let size = (AREA.displacement[1] - AREA.displacement[0]) * (AREA.velocity[1] - AREA.velocity[0]);
            // Counting centres errs by much less than a cell for each cell on the curve, about 100 of them.
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
            // It ends at X′ = V, X″ = 0, where X − μ_k = −2ζV.
            let t = point.tau - end.tau;
            let (x0, v0) = (-2.0 * damping * velocity, velocity);
            let (sin, cos) = (frequency * t).sin_cos();
            let x = (-damping * t).exp() * (x0 * cos + (v0 + damping * x0) / frequency * sin);
            assert!((point.displacement - 0.3 - x).abs() < 1e-12, "{point:?}");
        }
        assert!((curve.points[0].velocity - velocity).abs() < 1e-15);
    }

    #[test]
    fn outside_the_two_critical_dampings_all_starts_end_alike() {
        let ends = critical_damping(&midway(0.3, 0.1, 0.5)).unwrap();
        for (damping, wanted) in [
            (0.9 * ends.hopf_damping_ratio, Attractor::StickSlip),
            (1.01 * ends.critical_damping_ratio, Attractor::Sliding),
            (3.0, Attractor::Sliding),
        ] {
            let oscillator = Oscillator::stribeck(0.3, 4.2, damping, 0.1).unwrap();
            let area = BasinBox { cells: [20, 20], ..AREA };
            let found = basin(&oscillator, &area, &Silent).unwrap();
            assert!(found.attractors.iter().all(|a| *a == wanted), "{damping}");
            assert_eq!(separatrix(&oscillator, 100).unwrap(), None);
        }
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
