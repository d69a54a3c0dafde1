//! Cycles that stay slower than the belt.

use serde::{Deserialize, Serialize};

use super::super::root::newton_between;
use super::super::{Oscillator, VibrationError};
use super::planar::{Lap, Planar, Turn};

/// Amplitudes at which the return map is first looked at.
const AMPLITUDES: usize = 64;
/// |ln(P/r)| below this is rounding: no growth and no decay.
const NEUTRAL: f64 = 1e-12;
/// Amplitudes below this share of the first on the grid are not looked at.
const SMALLEST: f64 = 1e-6;
/// |ln(P/r)| of a cycle that was found.
const CLOSED: f64 = 1e-9;

/// A cycle of slip that never reaches the belt velocity.
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
    /// Half the span of the velocity.
    pub fn velocity_amplitude(&self) -> f64 {
        0.5 * (self.velocity_max - self.velocity_min)
    }

    /// Whether it attracts.
    pub fn is_stable(&self) -> bool {
        self.multiplier < 1.0
    }
}

/// The return map seen as a whole.
#[derive(Debug, Clone)]
pub(super) struct ReturnMap {
    /// (r, cycle), by rising r.
    pub(super) cycles: Vec<(f64, SlipCycle)>,
    /// Orbits from beyond this r reach the belt velocity within one turn, or lie outside of the one from a detachment.
    pub(super) edge: f64,
    /// Sign of ln(P/r) before the first cycle, between the cycles and after the last.
    pub(super) growth: Vec<f64>,
}

/// All cycles without stick and without forcing between steady sliding and the orbit from a detachment, by rising
/// amplitude.
///
/// Between ζ_H and ζ_c a velocity-weakening law has an unstable one, which parts the starts that end in steady sliding
/// from those that end in stick-slip. The zeros of ln(P(r)/r) of the return map r → P(r) are isolated on a grid of 64
/// amplitudes and found by Newton's method with the exact derivative; two cycles between neighbours of the grid are not
/// seen. A continuum of cycles, as of Coulomb friction without damping, has none that is isolated, so none is returned.
pub fn slip_cycles(oscillator: &Oscillator) -> Result<Vec<SlipCycle>, VibrationError> {
    Ok(return_map(oscillator)?.map_or(Vec::new(), |map| map.cycles.into_iter().map(|(_, cycle)| cycle).collect()))
}

/// None if orbits do not turn around steady sliding.
pub(super) fn return_map(oscillator: &Oscillator) -> Result<Option<ReturnMap>, VibrationError> {
    let planar = Planar::new(oscillator)?;
    let Some(outer) = planar.detachment()? else { return Ok(None) };
    let growth = |r: f64| -> Result<(f64, f64), VibrationError> {
        Ok(match planar.turn(r)? {
            Turn::Back(lap) => ((lap.back / r).ln(), (r / lap.back * lap.stretch.exp()) / lap.back - 1.0 / r),
            Turn::Touches => (1.0, f64::NAN),
            Turn::Settles => (-1.0, f64::NAN),
        })
    };
    let sign = |value: f64| if value.abs() <= NEUTRAL { 0.0 } else { value.signum() };
    let half_rate = 0.5 * oscillator.law().weakening(oscillator.belt_velocity()) - oscillator.damping_ratio();
    let mut map = ReturnMap { cycles: Vec::new(), edge: 0.0, growth: vec![sign(half_rate)] };
    let (mut before, mut side) = (0.0, sign(half_rate));
    for i in 1..=AMPLITUDES {
        // Denser towards rest, where cycles are born.
        let r = outer * (i as f64 / AMPLITUDES as f64).powi(3);
        let touches = matches!(planar.turn(r)?, Turn::Touches);
        let here = if touches { 1.0 } else { sign(growth(r)?.0) };
        if here * side < 0.0 {
            let (low, high) = if here > 0.0 { (before, r) } else { (r, before) };
            let root = newton_between(growth, low, high, 0.5 * (before + r))?;
            if let Turn::Back(lap) = planar.turn(root)?
                && (lap.back / root).ln().abs() < CLOSED
            {
                map.cycles.push((root, cycle(oscillator, &planar, root, &lap)));
                map.growth.push(here);
            }
        }
        if touches {
            map.edge = edge(&planar, before, r)?;
            return Ok(Some(map));
        }
        if here != 0.0 {
            side = here;
            if let Some(last) = map.growth.last_mut().filter(|last| **last == 0.0) {
                *last = here;
            }
        }
        (before, map.edge) = (r, r);
    }
    // Under much damping all orbits run together, and the cycle they run into is the orbit from a detachment to rounding.
    if side > 0.0
        && map.growth.last().is_some_and(|last| *last > 0.0)
        && let Turn::Back(lap) = planar.turn(outer)?
        && lap.stretch < 0.0
        && (lap.back / outer).ln().abs() < CLOSED
    {
        map.cycles.push((outer, cycle(oscillator, &planar, outer, &lap)));
        map.growth.push(-1.0);
    }
    Ok(Some(map))
}

/// Where the orbits that come back end; zero if all touch, as around a node that repels.
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

fn cycle(oscillator: &Oscillator, planar: &Planar, r: f64, lap: &Lap) -> SlipCycle {
    let velocity = oscillator.belt_velocity();
    let displacement = |excess: f64| {
        velocity * (planar.rest + excess) + oscillator.static_friction() - 2.0 * oscillator.damping_ratio() * velocity
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
    use super::super::hopf::hopf_point;
    use super::*;
    use crate::vibration::{FrictionLaw, FrictionTable, Parameters, critical_damping};

    #[test]
    fn one_unstable_cycle_lies_exactly_between_the_hopf_point_and_the_fold() {
        for (friction, velocity) in [(0.1, 0.003), (0.3, 0.1), (1.0, 0.2)] {
            let of = |damping| Oscillator::stribeck(friction, 4.2, damping, velocity).unwrap();
            let ends = critical_damping(&of(0.0)).unwrap();
            let (low, high) = (ends.hopf_damping_ratio, ends.critical_damping_ratio);
            for share in [1e-6, 0.01, 0.5, 0.99, 1.0 - 1e-6] {
                let cycles = slip_cycles(&of(low + share * (high - low))).unwrap();
                assert!(cycles.len() == 1 && !cycles[0].is_stable(), "{share}: {cycles:?}");
            }
            for outside in [0.5 * low, low * (1.0 - 1e-6), high * (1.0 + 1e-6), 2.0 * high, 5.0] {
                assert_eq!(slip_cycles(&of(outside)).unwrap(), [], "{outside} and {ends:?}");
            }
        }
    }

    #[test]
    fn the_unstable_cycle_ends_where_it_touches_the_belt_velocity() {
        let of = |damping| Oscillator::stribeck(0.3, 4.2, damping, 0.1).unwrap();
        let fold = critical_damping(&of(0.0)).unwrap().critical_damping_ratio;
        // It meets the orbit from the detachment there.
        let cycle = slip_cycles(&of(fold - 1e-9)).unwrap()[0];
        assert!((cycle.velocity_max - 0.1).abs() < 1e-6 && cycle.velocity_max < 0.1, "{cycle:?}");
    }

    #[test]
    fn its_amplitude_follows_the_normal_form_near_the_hopf_point() {
        for (friction, decay, velocity) in [(0.2, 4.2, 0.05), (0.3, 4.2, 0.1), (1.0, 3.0, 0.2)] {
            let of = |damping| Oscillator::stribeck(friction, decay, damping, velocity).unwrap();
            let hopf = hopf_point(&of(0.0)).unwrap();
            let width = critical_damping(&of(0.0)).unwrap().critical_damping_ratio - hopf.damping_ratio;
            let off = |share: f64| {
                let damping = hopf.damping_ratio + share * width;
                let cycle = slip_cycles(&of(damping)).unwrap()[0];
                cycle.velocity_amplitude() / hopf.velocity_amplitude(damping).unwrap() - 1.0
            };
            // √((ζ − ζ_H)/ℓ)·(1 + O(ζ − ζ_H)).
            let (far, near) = (off(1e-2), off(1e-3));
            assert!(near.abs() < 2e-3 && (far / near / 10.0 - 1.0).abs() < 0.05, "{far} and {near}");
        }
    }

    #[test]
    fn laws_without_isolated_cycles_have_none() {
        for (law, damping_ratio) in [
            (FrictionLaw::Coulomb { kinetic: 0.3 }, 0.0),
            (FrictionLaw::Coulomb { kinetic: 0.3 }, 0.01),
            (FrictionLaw::Linear { kinetic: 0.3, slope: 0.2 }, 0.1),
            (FrictionLaw::Linear { kinetic: 0.3, slope: 0.2 }, 0.09),
            (FrictionLaw::Linear { kinetic: 0.3, slope: 0.2 }, 0.1001),
        ] {
            for static_friction in [0.3, 0.31] {
                let law = law.clone();
                let parameters = Parameters { static_friction, law, damping_ratio, belt_velocity: 0.1, forcing: None };
                assert_eq!(slip_cycles(&Oscillator::new(parameters).unwrap()).unwrap(), []);
            }
        }
    }

    #[test]
    fn a_relaxation_oscillation_is_a_cycle_that_all_orbits_run_into() {
        // 2ζ dX/dτ = μ − X on the two flat pieces, 0.1 and 0.05 … 0.04, and jumps between them.
        let law = FrictionLaw::Tabulated(
            FrictionTable::new(&[[0.0, 0.1], [0.001, 0.1], [0.0011, 0.05], [1.0, 0.04]]).unwrap(),
        );
        let (damping_ratio, belt_velocity) = (23.0, 0.00105);
        let parameters = Parameters { static_friction: 0.1, law, damping_ratio, belt_velocity, forcing: None };
        let oscillator = Oscillator::new(parameters).unwrap();
        let cycles = slip_cycles(&oscillator).unwrap();
        let [cycle] = cycles[..] else { panic!("{cycles:?}") };
        assert!(cycle.is_stable() && cycle.velocity_max < belt_velocity, "{cycle:?}");
        // Followed by its own equation for many periods, the motion repeats itself after that time.
        let settings = crate::vibration::TrajectorySettings {
            duration: 5.0 * cycle.period,
            start: None,
            drive: crate::vibration::Drive::Distance,
            method: crate::vibration::Method::DormandPrince { tolerance: 1e-11 },
        };
        let steady = crate::friction::process::Steady;
        let from = 3.0 * cycle.period;
        let points = crate::vibration::trajectory_portrait(&oscillator, steady, &settings, from, 2001).unwrap();
        for (a, b) in points.iter().zip(&points[1000..]) {
            assert!((a.displacement - b.displacement).abs() < 1e-7, "{a:?} {b:?}");
        }
        let extreme = |of: fn(f64, f64) -> f64| points.iter().map(|p| p.displacement).reduce(of).unwrap();
        assert!((extreme(f64::max) - cycle.displacement_max).abs() < 1e-3 * cycle.displacement_max, "{cycle:?}");
        assert!((extreme(f64::min) - cycle.displacement_min).abs() < 1e-3 * cycle.displacement_max, "{cycle:?}");
    }

    #[test]
    fn around_a_rest_that_repels_without_turning_there_is_none() {
        let law = FrictionLaw::Stribeck { kinetic: 2.2, decay: 3.6 };
        let parameters =
            Parameters { static_friction: 3.2, law, damping_ratio: 0.03, belt_velocity: 0.02, forcing: None };
        let map = return_map(&Oscillator::new(parameters).unwrap()).unwrap().unwrap();
        assert!(map.cycles.is_empty() && map.growth == [1.0] && map.edge < 1e-3);
    }

    #[test]
    fn the_multiplier_is_the_slope_of_the_return_map() {
        let oscillator = Oscillator::stribeck(0.3, 4.2, 0.32, 0.1).unwrap();
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
