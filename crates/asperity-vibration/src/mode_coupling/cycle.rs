//! Motion without fluctuation, followed until it repeats.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::super::VibrationError;
use super::motion::state::Now;
use super::motion::{Cut, Motion};
use super::trajectory::default_start;
use super::{Contact, CoupledEventKind, Model, State};
use asperity_process as process;

/// Difference of two states, relative to the size of the vibration, below which the motion counts as repeated.
const REPEATED: f64 = 1e-11;
/// Size of a vibration, relative to the displacement, below which the mass counts as being at rest in space.
const SETTLED: f64 = 1e-8;
/// Largest number of maxima of x per period in the search for a cycle.
const MAX_MULTIPLICITY: usize = 32;
/// Number of maxima of x after which a motion counts as irregular.
const MAX_MAXIMA: usize = 40_000;
/// Difference below which two states may still converge, and the number of maxima allowed for this after states further
/// apart in time already agree. A motion that spirals into its cycle first comes close to itself after several turns.
const NEAR: f64 = 1e-3;
const MAX_SPIRAL: usize = 8_000;
/// Largest time without a maximum of x, in the unit 1 + μ_s/(k₁₁V) of a stick.
const MAX_WAIT: f64 = 1e3;

/// One period of the limit cycle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CoupledCycle {
    /// Period in τ.
    pub period: f64,
    /// Least and largest x.
    pub tangential: [f64; 2],
    /// Least and largest y.
    pub normal: [f64; 2],
    /// Largest normal force, 1 + k₃y.
    pub normal_force_max: f64,
    /// Fraction of the period in stick.
    pub stick_share: f64,
    /// Fraction of the period off the belt.
    pub flight_share: f64,
    /// Number of ends of stick per period.
    pub detachments: usize,
    /// Number of lift-offs from the belt per period.
    pub lift_offs: usize,
    /// Number of maxima of x per period.
    pub summits: usize,
    /// State at the start of the period, a maximum of x.
    pub start: State,
    /// Difference of the states one period apart, relative to the size of the vibration.
    pub residual: f64,
}

/// Long-term motion without fluctuation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CoupledRegime {
    /// The motion is periodic.
    Cycle(CoupledCycle),
    /// The mass comes to rest in space: steady sliding.
    Steady,
    /// The belt carries the mass away. The mass sticks, and the normal force grows faster than the force that would
    /// release it, because det K(μ_s) ≤ 0 (self-locking).
    Locked,
    /// The motion did not repeat, with up to 32 maxima of x per period, within 40,000 maxima.
    Irregular,
}

impl CoupledRegime {
    /// Returns the cycle if the motion is periodic.
    pub fn cycle(&self) -> Option<&CoupledCycle> {
        match self {
            Self::Cycle(cycle) => Some(cycle),
            Self::Steady | Self::Locked | Self::Irregular => None,
        }
    }
}

/// Maximum of x: x′ falls through zero.
#[derive(Debug, Clone, Copy)]
struct Maximum {
    state: State,
    /// Decrease of x before the maximum.
    fall: f64,
}

impl Maximum {
    /// Returns the largest difference from another maximum, relative to the size of the vibration.
    fn difference(&self, other: &Self) -> f64 {
        let size = self.fall.max(other.fall).max(f64::MIN_POSITIVE);
        let (a, b) = (self.state, other.state);
        let difference = (a.tangential - b.tangential).abs().max((a.normal - b.normal).abs());
        difference.max((a.normal_velocity - b.normal_velocity).abs()) / size
    }
}

/// Follows the motion from a state until it repeats or comes to rest. The default start is 1 % away from steady
/// sliding.
///
/// States are compared at the maxima of x, where x′ falls through zero. The distance of the result from the limit cycle
/// is at most 10⁻¹¹ of its size divided by the rate at which it attracts per period. If several cycles exist, the
/// result depends on the start. Without damping and with friction below the coalescence, the motion has two frequencies
/// and is irregular.
///
/// Fails if no start is given and no steady sliding exists, if the friction coefficient does not stay positive, or if
/// the mass does not return.
pub fn limit_cycle(model: &Model, start: Option<State>) -> Result<CoupledRegime, VibrationError> {
    limit_cycle_within(model, start, MAX_MAXIMA)
}

/// Follows the motion like [`limit_cycle`], and counts it as irregular if it has not repeated after `maxima` maxima of x.
///
/// Fails like [`limit_cycle`].
pub fn limit_cycle_within(model: &Model, start: Option<State>, maxima: usize) -> Result<CoupledRegime, VibrationError> {
    let start = start.map_or_else(|| default_start(model), Ok)?;
    let mut motion = Motion::new(model, process::Steady, start)?;
    let mut summits: VecDeque<Maximum> = VecDeque::with_capacity(MAX_MULTIPLICITY);
    // A single small wave may belong to an irregular motion.
    let mut small = 0;
    let mut spiral = 0;
    for _ in 0..maxima {
        let Some(summit) = next_maximum(&mut motion, |_, _| {})? else {
            let Now { x, u, y, v, .. } = motion.now;
            return if u.abs() + v.abs() <= SETTLED * (x.abs() + y.abs()) {
                Ok(CoupledRegime::Steady)
            } else if model.divergence().is_some_and(|friction| model.parameters().static_friction >= friction) {
                Ok(CoupledRegime::Locked)
            } else {
                Err(lost())
            };
        };
        let settled = summit.fall <= SETTLED * (summit.state.tangential.abs() + summit.state.normal.abs());
        small = if settled { small + 1 } else { 0 };
        if small == MAX_MULTIPLICITY {
            return Ok(CoupledRegime::Steady);
        }
        let repeated = |earlier: &Maximum| !settled && summit.difference(earlier) < REPEATED;
        if let Some(back) = summits.iter().position(repeated) {
            if spiral == MAX_SPIRAL || !summits.iter().take(back).any(|earlier| summit.difference(earlier) < NEAR) {
                return measure(&mut motion, summit, back + 1).map(CoupledRegime::Cycle);
            }
            spiral += 1;
        }
        summits.truncate(MAX_MULTIPLICITY - 1);
        summits.push_front(summit);
    }
    Ok(CoupledRegime::Irregular)
}

fn lost() -> VibrationError {
    VibrationError::NotFound { what: "vibration", reason: "the mass does not return" }
}

/// Follows the mass to its next maximum of x and passes every step to `visit`; returns none if it does not return.
fn next_maximum(
    motion: &mut Motion<process::Steady>,
    mut show: impl FnMut(&Motion<process::Steady>, Cut),
) -> Result<Option<Maximum>, VibrationError> {
    let until = motion.now.tau + MAX_WAIT * motion.stick_time();
    let mut lowest = motion.now.x;
    while motion.now.tau < until {
        let cut = motion.step(until)?;
        lowest = lowest.min(motion.now.x);
        show(motion, cut);
        if cut == Cut::Maximum {
            return Ok(Some(Maximum { state: motion.now.state(), fall: motion.now.x - lowest }));
        }
    }
    Ok(None)
}

/// Follows one more period and measures it; extremes lie at ends of steps.
fn measure(
    motion: &mut Motion<process::Steady>,
    first: Maximum,
    summits: usize,
) -> Result<CoupledCycle, VibrationError> {
    let contact = motion.contact_stiffness();
    let began = motion.now.tau;
    let mut tangential = [motion.now.x; 2];
    let mut normal = [motion.now.y; 2];
    let (mut stick, mut flight, mut detachments, mut lift_offs) = (0.0, 0.0, 0, 0);
    let mut last = first;
    for _ in 0..summits {
        last = next_maximum(motion, |motion, cut| {
            let now = motion.now;
            tangential = [tangential[0].min(now.x), tangential[1].max(now.x)];
            normal = [normal[0].min(now.y), normal[1].max(now.y)];
            match motion.passed {
                (Contact::Stick, since) => stick += now.tau - since,
                (Contact::Flight, since) => flight += now.tau - since,
                _ => {}
            }
            if let Cut::Event(event) = cut {
                detachments += usize::from(event.kind == CoupledEventKind::Detach);
                lift_offs += usize::from(event.kind == CoupledEventKind::LiftOff);
            }
        })?
        .ok_or_else(lost)?;
    }
    let period = motion.now.tau - began;
    Ok(CoupledCycle {
        period,
        tangential,
        normal,
        normal_force_max: 1.0 + contact * normal[1],
        stick_share: stick / period,
        flight_share: flight / period,
        detachments,
        lift_offs,
        summits,
        start: first.state,
        residual: last.difference(&first),
    })
}

#[cfg(test)]
mod tests {
    use super::super::{CoupledParameters, CoupledTrajectory, CoupledTrajectorySettings, Damping, critical_friction};
    use super::*;
    use crate::VelocityLaw;
    use crate::law::{Coulomb, Linear, Stribeck};

    fn model(friction: f64, ratio: f64, belt_velocity: f64) -> Model {
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: friction });
        let damping = Damping::Modal { ratios: [ratio; 2] };
        let parameters = CoupledParameters {
            law,
            static_friction: friction,
            damping,
            belt_velocity,
            ..CoupledParameters::default()
        };
        Model::new(parameters).unwrap()
    }

    fn cycle(model: &Model) -> CoupledCycle {
        *limit_cycle(model, None).unwrap().cycle().unwrap()
    }

    #[test]
    fn a_cycle_repeats_and_attracts_other_starts() {
        for model in [model(0.8, 0.05, 0.05), model(0.9, 0.05, 0.5), model(0.9, 0.01, 0.05)] {
            let found = cycle(&model);
            let settings = CoupledTrajectorySettings { duration: found.period, start: Some(found.start) };
            let CoupledTrajectory { end, stick_share, flight_share, events } =
                CoupledTrajectory::simulate(&model, process::Steady, &settings).unwrap();
            let (a, b) = (end, found.start);
            for (a, b) in [
                (a.tangential, b.tangential),
                (a.tangential_velocity, 0.0),
                (a.normal, b.normal),
                (a.normal_velocity, b.normal_velocity),
            ] {
                assert!((a - b).abs() < 1e-10, "{a} {b}");
            }
            assert!((stick_share - found.stick_share).abs() < 1e-10);
            assert!((flight_share - found.flight_share).abs() < 1e-10);
            let count = |kind| events.iter().filter(|event| event.kind == kind).count();
            assert_eq!(
                (count(CoupledEventKind::Detach), count(CoupledEventKind::LiftOff)),
                (found.detachments, found.lift_offs)
            );
            let start = State { tangential: 0.2, normal: 0.3, tangential_velocity: 0.01, normal_velocity: -0.1 };
            let other = limit_cycle(&model, Some(start)).unwrap();
            let other = other.cycle().unwrap();
            assert!(
                (other.period - found.period).abs() < 1e-9 && (other.tangential[1] - found.tangential[1]).abs() < 1e-9
            );
        }
    }

    #[test]
    fn without_coupling_the_cycle_has_one_degree_of_freedom() {
        // Springs along and across the belt: y stays 0, and x is the oscillator with one degree of freedom. Reference
        // periods and extremes of x come from 30-digit integration; with Coulomb friction from the closed form.
        let (drop, v) = (0.1_f64, 0.05_f64);
        let closed = std::f64::consts::TAU - 2.0 * (drop / v).atan() + 2.0 * drop / v;
        let coulomb = VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 });
        let paper = VelocityLaw::Stribeck(Stribeck { kinetic: 0.1, decay: 4.2 });
        let linear = VelocityLaw::Linear(Linear { kinetic: 0.4, slope: 0.3 });
        for (static_friction, law, ratio, belt_velocity, period, extremes) in [
            (0.4, coulomb, 0.0, v, closed, None),
            (0.4, linear, 0.1, 0.1, 6.439_474_890_105_244, None),
            (
                0.1,
                paper,
                0.17,
                0.003,
                6.372_163_483_739_709,
                Some([0.095_239_651_620_418_22, 0.101_931_013_749_859_67]),
            ),
            (1.0, VelocityLaw::Stribeck(Stribeck { kinetic: 1.0, decay: 3.0 }), 0.0, 0.2, 12.001_031, None),
        ] {
            let model = Model::new(CoupledParameters {
                angles_deg: [0.0, 90.0],
                springs: [1.0, 2.0],
                damping: Damping::Axes { tangential: 2.0 * ratio, normal: 0.1 },
                static_friction,
                law: law.clone(),
                belt_velocity,
                ..CoupledParameters::default()
            })
            .unwrap();
            let tangential = 0.97 * static_friction - 2.0 * ratio * belt_velocity;
            let start = State { tangential, tangential_velocity: belt_velocity, normal: 0.0, normal_velocity: 0.0 };
            let regime = limit_cycle(&model, Some(start)).unwrap();
            let found = regime.cycle().unwrap();
            // Leine's period is published with six decimals.
            let tolerance = if period == 12.001_031 { 5e-7 } else { 2e-12 };
            assert!((found.period - period).abs() < tolerance, "{law:?}: {:.15} {period:.15}", found.period);
            if let Some(extremes) = extremes {
                for (found, wanted) in found.tangential.iter().zip(extremes) {
                    assert!((found - wanted).abs() < 1e-14, "{found} {wanted}");
                }
            }
            assert_eq!((found.detachments, found.lift_offs), (1, 0));
        }
    }

    #[test]
    fn damped_motion_rests_below_the_onset_and_lifts_off_above() {
        let onset = |ratio: f64| critical_friction(&model(0.8, ratio, 0.5), 2.0).unwrap().unwrap().friction;
        assert!(onset(0.05) > 0.75 && onset(0.05) < 0.77);
        assert_eq!(limit_cycle(&model(0.75, 0.05, 0.5), None).unwrap(), CoupledRegime::Steady);
        let found = cycle(&model(0.78, 0.05, 0.5));
        assert!(found.flight_share > 0.0 && found.stick_share == 0.0);
        assert_eq!(found.normal_force_max, 1.0 + 4.0 / 3.0 * found.normal[1]);
    }

    #[test]
    fn the_belt_velocity_has_no_effect_on_a_slower_mass_under_coulomb_friction() {
        // Only flight limits the vibration, so the velocity of the belt has no effect.
        let (slow, fast) = (cycle(&model(0.9, 0.05, 0.6)), cycle(&model(0.9, 0.05, 3.0)));
        assert_eq!(slow.detachments, 0);
        assert!((slow.period - fast.period).abs() < 1e-9 && (slow.normal[0] - fast.normal[0]).abs() < 1e-9);
    }

    #[test]
    fn springs_with_the_opposite_inclination_lock() {
        // det K(μ) = 3 − 4μ/3.
        let springs = CoupledParameters::default().springs;
        let leaning = |friction: f64| {
            let parameters = model(friction, 0.05, 0.3).parameters().clone();
            Model::new(CoupledParameters { springs: [springs[1], springs[0]], ..parameters.clone() }).unwrap()
        };
        let start = State { tangential: 0.1, tangential_velocity: 0.3, normal: 0.0, normal_velocity: 0.0 };
        assert_eq!(limit_cycle(&leaning(2.3), Some(start)).unwrap(), CoupledRegime::Locked);
        assert_eq!(limit_cycle(&leaning(2.0), Some(start)).unwrap(), CoupledRegime::Steady);
        assert!(limit_cycle(&leaning(2.3), None).is_err());
    }

    #[test]
    fn undamped_motion_below_coalescence_does_not_repeat_itself() {
        assert_eq!(limit_cycle(&model(0.6, 0.0, 0.5), None).unwrap(), CoupledRegime::Irregular);
    }

    #[test]
    fn a_motion_that_spirals_into_its_cycle_has_the_period_of_one_turn() {
        // Periods of an independent simulation; the motion first comes close to itself after several turns.
        for (friction, period) in [(0.85, 4.989_417_7), (0.9, 5.027_113_47), (1.0, 5.092_547_6)] {
            let law = crate::VelocityLaw::Coulomb(Coulomb { kinetic: friction });
            let damping = Damping::Modal { ratios: [0.01, 0.02] };
            let parameters = CoupledParameters {
                law,
                static_friction: friction,
                damping,
                belt_velocity: 0.5,
                ..CoupledParameters::default()
            };
            let found = limit_cycle(&Model::new(parameters).unwrap(), None).unwrap();
            let cycle = found.cycle().unwrap();
            assert!((cycle.period / period - 1.0).abs() < 1e-7, "{cycle:?}");
            assert_eq!(cycle.lift_offs, 1);
        }
    }
}
