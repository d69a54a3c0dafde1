//! Damping ratios at which the stick-slip cycle ends and at which steady sliding becomes stable.

use std::f64::consts::{PI, TAU};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::slip_orbit::first_minimum;
use super::structure::grazing::grazing_damping;
use super::structure::slip_cycle::fold_damping;
use super::{Oscillator, VibrationError};

/// Upper end of the search for the damping ratio.
const MAX_DAMPING: f64 = 1e3;
/// Least start of the search.
const LEAST_GUESS: f64 = 0.01;
/// Points of half a turn in the averaging.
const NODES: usize = 12;

/// Damping ratios that separate stick-slip from steady sliding.
///
/// For velocity-weakening laws ζ_H < ζ_c: between them both stick-slip and steady sliding are stable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CriticalDamping {
    /// ζ_c of the grazing–sliding fold: the slip orbit from a detachment touches the belt velocity. Above ζ_c no
    /// stick-slip cycle exists.
    pub critical_damping_ratio: f64,
    /// ζ_H of the Hopf bifurcation, 2ζ_H = −dμ/d|v| at the belt velocity. Above ζ_H steady sliding is stable. ζ_H is
    /// negative where friction rises with the speed.
    pub hopf_damping_ratio: f64,
}

/// Returns ζ_c and ζ_H of an oscillator, ignoring its own damping ratio and forcing.
///
/// ζ_c is the damping ratio at which the least relative velocity on the slip orbit from a detachment is zero. The orbit
/// is continued smoothly below zero, and the zero is sought from that of first-order averaging, for the paper's law
/// ζ_c ≈ μ_st/(aV²)·[(1+aV)/√(1+2aV) − 1].
pub fn critical_damping(oscillator: &Oscillator) -> Result<CriticalDamping, VibrationError> {
    let weakening = oscillator.law().weakening(oscillator.belt_velocity());
    let hopf_damping_ratio = 0.5 * weakening;
    let jump = oscillator.static_friction() - oscillator.law().kinetic();
    if jump == 0.0 && (oscillator.law().is_linear() || oscillator.law().is_constant()) {
        // Steady sliding loses its stability to motions of all amplitudes at once: at ζ_H the linear oscillator has no damping, and
        // the slip orbit from a detachment returns to its start.
        return Ok(CriticalDamping { critical_damping_ratio: hopf_damping_ratio.max(0.0), hopf_damping_ratio });
    }
    let too_large = VibrationError::NotFound { what: "critical damping", reason: "it lies above 1000" };
    if hopf_damping_ratio > MAX_DAMPING {
        return Err(too_large);
    }
    let free = oscillator.with_forcing(None)?;
    let guess = averaged_damping(&free).clamp(LEAST_GUESS, MAX_DAMPING);
    let critical_damping_ratio = match grazing_damping(&free, 0.0, guess, MAX_DAMPING)? {
        Some(damping) => damping,
        // Friction that rises with the speed damps the motion, or weakening and jump are below rounding.
        None if first_minimum(&free.with_damping(0.0)?, 0.0)?.is_none_or(|m| m.w >= 0.0) => hopf_damping_ratio.max(0.0),
        None => return Err(too_large),
    };
    Ok(CriticalDamping { critical_damping_ratio, hopf_damping_ratio })
}

/// Returns about the damping ratio at which the slip orbit from a detachment touches the belt velocity.
///
/// With the jump J of friction over the belt velocity, the orbit W = 1 − a cos θ has the amplitude √(1 + J²) at first
/// and 1 at its end. In one turn friction of the slope g = −dμ/d|v| adds the energy ∫ g W′² dθ, and damping takes
/// 2ζ ∫ W′² dθ.
fn averaged_damping(oscillator: &Oscillator) -> f64 {
    let (law, belt_velocity) = (oscillator.law(), oscillator.belt_velocity());
    let jump = (oscillator.static_friction() - law.kinetic()) / belt_velocity;
    let amplitude = 0.5 * (1.0 + jump.hypot(1.0));
    let nodes = (0..NODES).map(|node| PI * (node as f64 + 0.5) / NODES as f64);
    let in_slip =
        nodes.map(|theta| (1.0 - amplitude * theta.cos(), theta.sin().powi(2))).filter(|(speed, _)| *speed > 0.0);
    let (gained, all) = in_slip.fold((0.0, 0.0), |(gained, all), (speed, weight)| {
        (gained + weight * law.weakening(belt_velocity * speed), all + weight)
    });
    jump.hypot(1.0).ln() / TAU + 0.5 * gained / all
}

/// Returns ζ_v, the largest damping ratio at which any vibration persists, ignoring the oscillator's own damping ratio
/// and forcing.
///
/// Vibration ends at the largest of three damping ratios: the grazing point ζ_c, the Hopf point ζ_H, or a fold of slip
/// cycles above both. For ζ_H < ζ < ζ_v steady sliding is stable and a vibration coexists with it: a machine that
/// starts in stick vibrates, and a machine that slides steadily vibrates only after a kick ([`super::smallest_kick`]).
pub fn limit_damping(oscillator: &Oscillator) -> Result<f64, VibrationError> {
    limit_above(oscillator, &critical_damping(oscillator)?)
}

/// Returns ζ_v of an oscillator with these ends of stick-slip and of unstable sliding.
pub(super) fn limit_above(oscillator: &Oscillator, ends: &CriticalDamping) -> Result<f64, VibrationError> {
    let least = ends.critical_damping_ratio.max(ends.hopf_damping_ratio);
    Ok(fold_damping(&oscillator.with_forcing(None)?, least)?.unwrap_or(least))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Coulomb, Exponential, Linear, Stribeck};
    use crate::tests::machine;
    use crate::{FrictionTable, MotionKind, VelocityLaw, limit_cycle, smallest_kick};
    use asperity_base::distribution::standard_normal_cdf;
    use asperity_base::numeric::bisect;
    use asperity_base::random;

    /// Finds ζ_c by bisection of whether the orbit reaches the belt velocity, over all damping ratios.
    fn bisected(oscillator: &Oscillator) -> f64 {
        let reaches = |damping: f64| -> Result<bool, VibrationError> {
            let minimum = first_minimum(&oscillator.with_damping(damping)?, 0.0)?;
            Ok(minimum.is_some_and(|minimum| minimum.w < 0.0))
        };
        bisect(0.0, MAX_DAMPING, 0.0, reaches).unwrap()[0]
    }

    #[test]
    fn the_paper_s_law_ends_at_the_published_damping() {
        for (friction, velocity, wanted) in [
            (0.1, 0.003, 0.204_830_150_584_523_17),
            (0.1, 0.1, 0.111_508_270_209_214_07),
            (0.2, 0.1, 0.222_953_501_902_507_68),
            (0.3, 0.1, 0.334_272_847_322_423_26),
        ] {
            let found = critical_damping(&Oscillator::with_stribeck(friction, 4.2, 0.0, velocity).unwrap()).unwrap();
            assert!((found.critical_damping_ratio - wanted).abs() < 1e-12, "{found:?} instead of {wanted}");
            let hopf = 0.5 * 4.2 * friction / (1.0 + 4.2 * velocity).powi(2);
            assert!((found.hopf_damping_ratio - hopf).abs() < 1e-15);
            assert!(found.hopf_damping_ratio < found.critical_damping_ratio);
            // First-order averaging; its error is of the order of the friction coefficient squared.
            let speed: f64 = 4.2 * velocity;
            let averaged = friction / (speed * velocity) * ((1.0 + speed) / (1.0 + 2.0 * speed).sqrt() - 1.0);
            assert!((found.critical_damping_ratio / averaged - 1.0).abs() < friction * friction, "{averaged}");
        }
    }

    #[test]
    fn linear_weakening_ends_at_half_its_slope() {
        for slope in [0.05, 0.3, 1.1] {
            let law = VelocityLaw::Linear(Linear { kinetic: 0.4, slope });
            let found = critical_damping(&machine(0.4, law, 0.0, 0.1)).unwrap();
            assert!((found.critical_damping_ratio - 0.5 * slope).abs() < 1e-12, "{found:?}");
            assert!((found.hopf_damping_ratio - 0.5 * slope).abs() < 1e-15);
        }
    }

    #[test]
    fn friction_that_falls_far_below_the_belt_velocity_after_a_large_jump_has_its_critical_damping() {
        let stribeck = |decay| VelocityLaw::Stribeck(Stribeck { kinetic: 0.3, decay });
        let exponential =
            VelocityLaw::Exponential(Exponential { kinetic: 0.3, high_speed: 0.2, stribeck_velocity: 1e-5 });
        for law in [stribeck(5000.0), stribeck(14_000.0), stribeck(20_000.0), exponential] {
            let oscillator = machine(0.35, law, 0.0, 0.001);
            let (found, slow) = (critical_damping(&oscillator).unwrap().critical_damping_ratio, bisected(&oscillator));
            assert!((found / slow - 1.0).abs() < 1e-11, "{found} instead of {slow}: {oscillator:?}");
        }
    }

    #[test]
    fn the_search_ends_where_it_begins_at_the_critical_damping() {
        // The least velocity of some of these orbits is exactly zero.
        for step in 1..60 {
            let oscillator = Oscillator::with_stribeck(0.3, 0.1 * f64::from(step), 0.0, 0.003).unwrap();
            let critical = critical_damping(&oscillator).unwrap().critical_damping_ratio;
            let again = grazing_damping(&oscillator, 0.0, critical, MAX_DAMPING).unwrap().unwrap();
            assert!((again / critical - 1.0).abs() < 1e-13, "{again} instead of {critical}");
        }
    }

    #[test]
    fn a_cycle_exists_exactly_below_the_critical_damping_for_random_oscillators() {
        let rng = &mut random::stream(5, "test", 0);
        for i in 0..300 {
            let g = random::standard_normal(rng, 5);
            let static_friction = 0.2 * g[0].exp();
            let kinetic = if g[1] > 0.0 { static_friction } else { static_friction * standard_normal_cdf(g[1] + 1.0) };
            let decay = 3.0 * (1.5 * g[2]).exp();
            let stribeck = VelocityLaw::Stribeck(Stribeck { kinetic, decay });
            let (high_speed, stribeck_velocity) = (0.5 * kinetic, 0.5 / decay);
            let points: Vec<_> =
                (0..8).map(|i| 0.3 * f64::from(i) / decay).map(|v| [v, stribeck.coefficient(v)]).collect();
            let law = match i % 3 {
                0 => stribeck,
                1 => VelocityLaw::Exponential(Exponential { kinetic, high_speed, stribeck_velocity }),
                _ => VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap()),
            };
            // On a belt faster than the last point of the table, friction is constant.
            let belt_velocity = (0.05 * (1.5 * g[3]).exp()).min(if i % 3 == 2 { 1.0 / decay } else { f64::INFINITY });
            let of = |damping_ratio| {
                let law = law.clone();
                machine(static_friction, law, damping_ratio, belt_velocity)
            };
            let critical = critical_damping(&of(0.0)).unwrap().critical_damping_ratio;
            let slow = bisected(&of(0.0));
            // Orbits are of order 1 even for small ζ, so rounding moves ζ_c by at most 1e-15.
            let allowed = 1e-13 * critical.max(0.01);
            assert!((critical - slow).abs() < allowed, "{critical:.17} instead of {slow:.17}: {:?}", of(0.0));
            for (factor, exists) in [(0.3, true), (1.0 - 1e-7, true), (1.0 + 1e-7, false), (1.7, false)] {
                let regime =
                    limit_cycle(&of(factor * critical)).unwrap_or_else(|e| panic!("{e} {factor} {:?}", of(critical)));
                let reaches_belt = matches!(regime.kind(), MotionKind::StickSlip | MotionKind::Overtaking);
                assert_eq!(reaches_belt, exists, "{factor} of {critical}: {:?}", of(0.0));
            }
        }
    }

    #[test]
    fn without_weakening_any_damping_ends_the_cycle_but_a_jump_keeps_it() {
        let of = |static_friction| {
            let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 });
            critical_damping(&machine(static_friction, law, 0.0, 0.05)).unwrap().critical_damping_ratio
        };
        assert_eq!(of(0.3), 0.0);
        let with_jump = of(0.4);
        // Independent check by the event-driven motion: the cycle exists just below the limit and not above it.
        for (factor, exists) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
            let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 });
            let damping_ratio = with_jump * factor;
            let regime = limit_cycle(&machine(0.4, law, damping_ratio, 0.05)).unwrap();
            assert_eq!(regime.cycle().is_some(), exists);
        }
    }
    /// Returns an oscillator with the law .3 + .1e^{−(v/.08)²} as a table; the relative error of its slopes is about
    /// 7e-6.
    fn gaussian(belt_velocity: f64) -> Oscillator {
        let coefficient = |v: f64| 0.3 + 0.1 * (-(v / 0.08).powi(2)).exp();
        let points: Vec<_> = (0..=1200).map(|i| 2.5e-4 * f64::from(i)).map(|v| [v, coefficient(v)]).collect();
        let law = VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap());
        machine(0.4, law, 0.0, belt_velocity)
    }

    #[test]
    fn slip_cycles_exist_above_the_grazing_and_hopf_points() {
        // ζ_H = .1V/.08²·e^{−(V/.08)²}. The folds: scipy 1.17, DOP853 at rtol 1e-12, largest damping over the amplitudes
        // of closed orbits, by bounded minimisation to six digits of the amplitude.
        for (velocity, fold) in [(0.056, None), (0.11, Some(0.275_461_271)), (0.12, Some(0.238_055_208))] {
            let machine = gaussian(velocity);
            let ends = critical_damping(&machine).unwrap();
            let hopf = 0.1 * velocity / 0.0064 * (-(velocity / 0.08_f64).powi(2)).exp();
            assert!((ends.hopf_damping_ratio / hopf - 1.0).abs() < 2e-5, "{ends:?} {hopf}");
            // Published to three digits.
            assert!(velocity > 0.06 || (ends.critical_damping_ratio - 0.418).abs() < 5e-4, "{ends:?}");
            let limit = limit_damping(&machine).unwrap();
            let wanted = fold.unwrap_or(hopf);
            assert!((limit / wanted - 1.0).abs() < 2e-5, "{limit} instead of {wanted}");
            let kind = |factor: f64| limit_cycle(&machine.with_damping(factor * limit).unwrap()).unwrap().kind();
            assert_eq!([kind(0.999), kind(1.001)], [MotionKind::SlipCycle, MotionKind::None], "{velocity}");
            assert_eq!(kind(0.99 * ends.critical_damping_ratio / limit), MotionKind::StickSlip);
        }
    }

    #[test]
    fn the_last_vibration_of_a_falling_law_grazes_the_belt() {
        let laws = [
            VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 }),
            VelocityLaw::Exponential(Exponential { kinetic: 0.1, high_speed: 0.04, stribeck_velocity: 0.1 }),
            VelocityLaw::Linear(Linear { kinetic: 0.1, slope: 0.2 }),
            VelocityLaw::Coulomb(Coulomb { kinetic: 0.09 }),
        ];
        for law in laws {
            let machine = machine(0.1, law, 0.0, 0.1);
            let wanted = critical_damping(&machine).unwrap().critical_damping_ratio;
            assert_eq!(limit_damping(&machine).unwrap(), wanted);
        }
        // Closed forms for a jump of .05 at V = .05: without weakening, and with a weakening b = .1, which shifts the
        // limit by b/2.
        for (law, wanted) in [
            (VelocityLaw::Coulomb(Coulomb { kinetic: 0.25 }), 0.057_829_116_137_66),
            (VelocityLaw::Linear(Linear { kinetic: 0.25, slope: 0.1 }), 0.107_829_116_137_66),
        ] {
            let found = limit_damping(&machine(0.3, law, 0.0, 0.05)).unwrap();
            assert!((found - wanted).abs() < 1e-12, "{found} instead of {wanted}");
        }
    }
    #[test]
    fn vibration_persists_exactly_below_the_limit_damping_for_random_oscillators() {
        let rng = &mut random::stream(77, "test", 0);
        let mut folds = 0;
        for i in 0..60 {
            let g = random::standard_normal(rng, 4);
            let static_friction = 0.3 * g[0].exp();
            let kinetic = if g[1] > 0.0 { static_friction } else { static_friction * standard_normal_cdf(g[1] + 1.0) };
            let reach = 0.1 * (1.5 * g[2]).exp();
            let bell = |v: f64| kinetic * (0.3 + 0.7 * (-(v / reach).powi(2)).exp());
            let points: Vec<_> = (0..40).map(|i| 0.1 * f64::from(i) * reach).map(|v| [v, bell(v)]).collect();
            let law = match i % 3 {
                0 => VelocityLaw::Stribeck(Stribeck { kinetic, decay: 1.0 / reach }),
                1 => VelocityLaw::Exponential(Exponential {
                    kinetic,
                    high_speed: 0.3 * kinetic,
                    stribeck_velocity: reach,
                }),
                _ => VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap()),
            };
            let belt_velocity = reach * (0.7 * g[3]).exp();
            let of = |damping_ratio| {
                let law = law.clone();
                machine(static_friction, law, damping_ratio, belt_velocity)
            };
            let ends = critical_damping(&of(0.0)).unwrap();
            let limit = limit_damping(&of(0.0)).unwrap();
            folds += usize::from(limit > ends.critical_damping_ratio.max(ends.hopf_damping_ratio));
            for (factor, exists) in [(0.5, true), (0.9, true), (0.9999, true), (1.0001, false), (1.5, false)] {
                let machine = of(factor * limit);
                let kind = limit_cycle(&machine).unwrap().kind();
                assert_eq!(kind.is_vibration(), exists, "{factor} of {limit}, {ends:?}: {machine:?}");
                // Where sliding and vibration are both stable, a kick is needed and sufficient.
                let bistable = exists && !machine.sliding_is_unstable();
                assert_eq!(smallest_kick(&machine).unwrap().is_some(), bistable, "{factor} of {limit}: {machine:?}");
            }
        }
        assert!(folds > 0, "no fold of slip cycles");
    }

    #[test]
    fn a_critical_damping_above_the_largest_damping_ratio_is_named() {
        // ζ_H = μ_k·a/(2(1 + aV)²) is 1250.
        let law = VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 1e5 });
        let error = critical_damping(&machine(2.1, law, 0.1, 1e-5)).unwrap_err();
        assert_eq!(error, VibrationError::NotFound { what: "critical damping", reason: "it lies above 1000" });
    }
}
