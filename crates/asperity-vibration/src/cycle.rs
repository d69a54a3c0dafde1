//! Limit cycle without fluctuation.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::motion::{Motion, SlipState};
use super::structure::slip_cycle::{ReturnMap, SlipCycle, return_map};
use super::{Drive, EventKind, MotionKind, Oscillator, Phase, VibrationError};
use asperity_process::Steady;

/// Distance of W and W′ from steady sliding below which the motion never returns to stick.
const SETTLED: f64 = 1e-9;
/// Difference of detachment phases below which a motion counts as repeated.
const PHASE_TOLERANCE: f64 = 1e-12;
/// Relative difference of states below which a motion counts as repeated.
const STATE_TOLERANCE: f64 = 1e-12;
/// Largest number of slips per period in the search for a forced cycle.
const MAX_MULTIPLICITY: usize = 32;
/// Number of slips, or of forcing periods without stick, after which a forced motion counts as irregular.
const MAX_PERIODS: usize = 20_000;
/// Largest number of steps of one slip phase without forcing.
const MAX_STEPS: usize = 1_000_000;

/// One period of the limit cycle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LimitCycle {
    /// Kind of motion.
    pub kind: MotionKind,
    /// Period in τ.
    pub period: f64,
    /// Time of slip per period.
    pub slip_duration: f64,
    /// Displacement X at the last re-attachment of the period; none if the mass never sticks.
    pub reattachment_displacement: Option<f64>,
    /// Least X.
    pub displacement_min: f64,
    /// Largest X.
    pub displacement_max: f64,
    /// Least X′.
    pub velocity_min: f64,
    /// Largest X′.
    pub velocity_max: f64,
    /// Number of detachments per period: 1 without forcing, 0 for a cycle without stick.
    pub slips: usize,
}

impl From<SlipCycle> for LimitCycle {
    fn from(cycle: SlipCycle) -> Self {
        Self {
            kind: MotionKind::SlipCycle,
            period: cycle.period,
            slip_duration: cycle.period,
            reattachment_displacement: None,
            displacement_min: cycle.displacement_min,
            displacement_max: cycle.displacement_max,
            velocity_min: cycle.velocity_min,
            velocity_max: cycle.velocity_max,
            slips: 0,
        }
    }
}

/// Long-term motion without fluctuation of a mass that starts in stick.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Regime {
    /// Periodic vibration.
    Cycle(LimitCycle),
    /// Steady sliding or, under forcing, a periodic response slower than the belt.
    Sliding,
    /// Forced motion that reaches the belt velocity and does not repeat within 20,000 slips.
    Irregular(MotionKind),
}

impl Regime {
    /// Returns the cycle if the motion is periodic vibration.
    pub fn cycle(&self) -> Option<&LimitCycle> {
        match self {
            Self::Cycle(cycle) => Some(cycle),
            Self::Sliding | Self::Irregular(_) => None,
        }
    }

    /// Returns the kind of motion.
    pub fn kind(&self) -> MotionKind {
        match self {
            Self::Cycle(cycle) => cycle.kind,
            Self::Sliding => MotionKind::None,
            Self::Irregular(kind) => *kind,
        }
    }
}

/// Extremes and times of the motion between two detachments.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    pub(super) duration: f64,
    pub(super) slip: f64,
    pub(super) reattachment: Option<f64>,
    pub(super) lowest: f64,
    pub(super) highest: f64,
    pub(super) slowest: f64,
    pub(super) fastest: f64,
}

impl Turn {
    pub(super) const EMPTY: Self = Self {
        duration: 0.0,
        slip: 0.0,
        reattachment: None,
        lowest: f64::INFINITY,
        highest: f64::NEG_INFINITY,
        slowest: f64::INFINITY,
        fastest: f64::NEG_INFINITY,
    };

    pub(super) fn include(&mut self, motion: &Motion<Steady>) {
        for tau in motion.turning_times() {
            let (x, velocity) = motion.sample(tau);
            self.lowest = self.lowest.min(x);
            self.highest = self.highest.max(x);
            self.slowest = self.slowest.min(velocity);
            self.fastest = self.fastest.max(velocity);
        }
    }

    pub(super) fn cycle(turns: &[Self]) -> LimitCycle {
        let fold = |f: fn(f64, f64) -> f64, of: fn(&Self) -> f64| turns.iter().map(of).reduce(f).unwrap_or(f64::NAN);
        let slips = turns.iter().filter(|t| t.reattachment.is_some()).count();
        LimitCycle {
            kind: if slips > 0 { MotionKind::StickSlip } else { MotionKind::Overtaking },
            period: turns.iter().map(|t| t.duration).sum(),
            slip_duration: turns.iter().map(|t| t.slip).sum(),
            reattachment_displacement: turns.last().and_then(|t| t.reattachment),
            displacement_min: fold(f64::min, |t| t.lowest),
            displacement_max: fold(f64::max, |t| t.highest),
            velocity_min: fold(f64::min, |t| t.slowest),
            velocity_max: fold(f64::max, |t| t.fastest),
            slips,
        }
    }
}

/// Returns the long-term motion of an oscillator without fluctuation that starts in stick.
///
/// Without forcing every detachment is the same state, so one turn is exactly the cycle. With little damping on a fast
/// belt the mass may overtake the belt in every period and never stick; this motion is followed until it repeats. If
/// the slip orbit from a detachment turns back before the belt velocity, no cycle reaches the belt, because planar
/// orbits cannot cross. The motion then approaches the outermost slip cycle ([`super::slip_cycles`]) or steady sliding.
/// With forcing the motion starts from [`Oscillator::default_start`] and is followed until the phases of its
/// detachments repeat; this finds the attracting cycle with up to 32 slips per period.
///
/// Fails if the friction coefficient does not stay positive, or if an orbit needs more than a million steps to repeat.
/// The latter happens on a very fast belt without damping, where friction hardly changes the orbit in a period.
pub fn limit_cycle(oscillator: &Oscillator) -> Result<Regime, VibrationError> {
    Ok(locate(oscillator)?.0)
}

/// Returns the regime and a state on its cycle.
pub(super) fn locate(oscillator: &Oscillator) -> Result<(Regime, SlipState), VibrationError> {
    if let Some(forcing) = oscillator.forcing() {
        return forced_cycle(oscillator, TAU / forcing.frequency);
    }
    if let Some((cycle, state)) = cycle_at_belt(oscillator)? {
        return Ok((Regime::Cycle(cycle), state));
    }
    let map = return_map(oscillator)?;
    Ok(match map.as_ref().and_then(ReturnMap::outermost_attractor) {
        Some((state, cycle)) => (Regime::Cycle((*cycle).into()), state),
        None => (Regime::Sliding, SlipState::detached(0.0)),
    })
}

/// Returns the cycle that reaches the belt velocity without forcing, and a state on it. Returns none if the slip orbit
/// from a detachment turns back before the belt velocity.
pub(super) fn cycle_at_belt(oscillator: &Oscillator) -> Result<Option<(LimitCycle, SlipState)>, VibrationError> {
    let start = SlipState::detached(0.0);
    let mut motion = Motion::from_slip(oscillator, Steady, start)?;
    // A turn starts at a detachment; a lap starts at a return from over-slip.
    let (mut turn, mut lap) = (Turn::EMPTY, Turn::EMPTY);
    let mut returned: Option<SlipState> = None;
    for _ in 0..MAX_STEPS {
        let event = motion.step(f64::INFINITY)?;
        turn.include(&motion);
        lap.include(&motion);
        match event.map(|e| e.kind) {
            Some(EventKind::Detach) => {
                turn.duration = motion.tau;
                return Ok(Some((Turn::cycle(&[turn]), start)));
            }
            Some(EventKind::Restick) => {
                turn.slip = motion.tau;
                turn.reattachment = Some(motion.displacement());
            }
            Some(EventKind::Reverse) => {
                let Some(state) = motion.slip_state().filter(|state| state.phase == Phase::Slip) else { continue };
                if let Some(before) = returned.filter(|before| state.repeats(before, STATE_TOLERANCE)) {
                    (lap.duration, lap.slip) = (state.tau - before.tau, state.tau - before.tau);
                    return Ok(Some((Turn::cycle(&[lap]), state)));
                }
                (returned, lap) = (Some(state), Turn::EMPTY);
            }
            None => {
                if motion.passed_minimum() || motion.has_settled(SETTLED) {
                    return Ok(None);
                }
            }
        }
    }
    Err(VibrationError::NotFound { what: "limit cycle", reason: "the slip phase did not end within a million steps" })
}

fn forced_cycle(oscillator: &Oscillator, forcing_period: f64) -> Result<(Regime, SlipState), VibrationError> {
    let mut motion = Motion::new(oscillator, Steady, Drive::Distance, oscillator.default_start())?;
    let mut turns: Vec<Turn> = Vec::new();
    let mut detachments: Vec<(Phase, f64)> = Vec::new();
    // A turn starts at a detachment; `period_turn` starts with each forcing period.
    let (mut turn, mut period_turn) = (Turn::EMPTY, Turn::EMPTY);
    // Time is counted from the last whole forcing period, so that phases keep their digits.
    let (mut detached_at, mut slides_since) = (0.0, 0.0);
    let mut last_state: Option<SlipState> = None;
    let (mut periods_without_stick, mut reversals) = (0, 0);
    while turns.len() < MAX_PERIODS && periods_without_stick < MAX_PERIODS {
        let event = motion.step(forcing_period)?;
        turn.include(&motion);
        period_turn.include(&motion);
        match event.map(|e| e.kind) {
            Some(EventKind::Detach) => {
                turn.duration = motion.tau - detached_at;
                turns.push(turn);
                turn = Turn::EMPTY;
                (detached_at, slides_since) = (motion.tau, motion.tau);
                let Some(state) = motion.slip_state() else { continue };
                detachments.push((state.phase, state.tau));
                if let Some(period) = repetition(&detachments, forcing_period) {
                    let cycle = Turn::cycle(&turns[turns.len() - period..]);
                    return Ok((Regime::Cycle(cycle), state));
                }
            }
            Some(EventKind::Restick) => {
                turn.slip += motion.tau - slides_since;
                turn.reattachment = Some(motion.displacement());
                (periods_without_stick, last_state) = (0, None);
            }
            Some(EventKind::Reverse) => reversals += 1,
            None => {}
        }
        if motion.tau >= forcing_period {
            motion.tau -= forcing_period;
            (detached_at, slides_since) = (detached_at - forcing_period, slides_since - forcing_period);
            if let Some(state) = motion.slip_state() {
                if last_state.is_some_and(|last| state.repeats(&last, STATE_TOLERANCE)) {
                    (period_turn.duration, period_turn.slip) = (forcing_period, forcing_period);
                    let cycle = Turn::cycle(&[period_turn]);
                    return Ok((if reversals == 0 { Regime::Sliding } else { Regime::Cycle(cycle) }, state));
                }
                last_state = Some(state);
            }
            periods_without_stick += 1;
            (period_turn, reversals) = (Turn::EMPTY, 0);
        }
    }
    let kind = if periods_without_stick < MAX_PERIODS { MotionKind::StickSlip } else { MotionKind::Overtaking };
    Ok((Regime::Irregular(kind), SlipState::detached(0.0)))
}

/// Returns the number of slips after which detachments repeat: the last two agree with the ones a period earlier.
fn repetition(detachments: &[(Phase, f64)], forcing_period: f64) -> Option<usize> {
    let n = detachments.len();
    let same = |a: usize, b: usize| {
        let ((phase, tau), (other, before)) = (detachments[a], detachments[b]);
        let difference = (tau - before).abs();
        phase == other && difference.min(forcing_period - difference) < PHASE_TOLERANCE
    };
    (1..=MAX_MULTIPLICITY).find(|&k| n >= k + 3 && same(n - 1, n - 1 - k) && same(n - 2, n - 2 - k))
}

#[cfg(test)]
mod tests {
    use crate::law::{Coulomb, Exponential, Linear, Stribeck};
    use std::f64::consts::PI;

    use super::*;
    use crate::{Forcing, FrictionTable, MotionKind, Parameters, PhasePoint, VelocityLaw, cycle_portrait};
    use asperity_testing::Choices;

    fn cycle_of(parameters: Parameters) -> LimitCycle {
        *limit_cycle(&Oscillator::new(parameters).unwrap()).unwrap().cycle().unwrap()
    }

    fn close(found: f64, wanted: f64, relative: f64) {
        assert!((found / wanted - 1.0).abs() < relative, "found {found:.17}, wanted {wanted:.17}");
    }

    #[test]
    fn coulomb_friction_has_its_closed_form_cycle() {
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 });
        let cycle =
            cycle_of(Parameters { static_friction: 0.4, law, damping_ratio: 0.0, belt_velocity: 0.05, forcing: None });
        let ratio: f64 = 0.1 / 0.05;
        close(cycle.period, TAU - 2.0 * ratio.atan() + 2.0 * ratio, 1e-14);
        close(cycle.period, 8.068_887_871_591_405, 1e-14);
        close(cycle.reattachment_displacement.unwrap(), 2.0 * 0.3 - 0.4, 1e-13);
        close(cycle.slip_duration, cycle.period - 2.0 * ratio, 1e-14);
        // Slip is the circle X = μ_k + A cos; its extremes are μ_k ± √(Δ² + V²).
        let amplitude = 0.1_f64.hypot(0.05);
        close(cycle.displacement_max, 0.3 + amplitude, 1e-14);
        close(cycle.displacement_min, 0.3 - amplitude, 1e-13);
        close(cycle.velocity_min, -amplitude, 1e-14);
    }

    #[test]
    fn linear_weakening_has_its_closed_form_cycle() {
        let law = VelocityLaw::Linear(Linear { kinetic: 0.4, slope: 0.3 });
        let cycle =
            cycle_of(Parameters { static_friction: 0.4, law, damping_ratio: 0.1, belt_velocity: 0.1, forcing: None });
        close(cycle.period, 6.439_474_890_105_244, 1e-13);
        close(cycle.reattachment_displacement.unwrap(), 0.288_933_000_910_998, 1e-13);
    }

    #[test]
    fn a_straight_line_of_points_is_the_linear_law() {
        for speeds in [&[0.0, 1.0][..], &[0.0, 0.03, 0.08, 0.1, 0.15, 0.2, 1.0]] {
            let points: Vec<_> = speeds.iter().map(|&v| [v, 0.4 - 0.3 * v]).collect();
            let law = VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap());
            let parameters =
                Parameters { static_friction: 0.4, law, damping_ratio: 0.1, belt_velocity: 0.1, forcing: None };
            let cycle = cycle_of(parameters);
            close(cycle.period, 6.439_474_890_105_244, 1e-13);
            close(cycle.reattachment_displacement.unwrap(), 0.288_933_000_910_998, 1e-12);
        }
    }

    #[test]
    fn exponential_and_tabulated_laws_give_the_cycles_of_an_independent_integrator() {
        // scipy 1.17.1, solve_ivp with DOP853 at rtol 3e-14, restarted at the points of the table: 11 digits.
        let exponential =
            |kinetic| VelocityLaw::Exponential(Exponential { kinetic, high_speed: 0.2, stribeck_velocity: 0.1 });
        let points = [[0.0, 0.3], [0.05, 0.27], [0.2, 0.2], [0.3, 0.22], [0.5, 0.22], [0.9, 0.25]];
        let table = VelocityLaw::Tabulated(FrictionTable::new(&points).unwrap());
        for (law, static_friction, damping_ratio, belt_velocity, [period, slip, reattachment]) in [
            (exponential(0.3), 0.3, 0.05, 0.1, [6.929_871_534_970_7, 5.013_270_760_081_6, 0.098_339_922_511_09]),
            (exponential(0.28), 0.3, 0.05, 0.1, [6.735_882_684_754_9, 4.962_176_102_686_8, 0.112_629_341_793_19]),
            (table.clone(), 0.3, 0.02, 0.1, [7.243_635_246_977_1, 4.953_431_731_211_2, 0.066_979_648_423_41]),
            (table, 0.33, 0.02, 0.4, [6.309_511_508_870_6, 6.056_887_694_860_1, 0.212_950_474_395_79]),
        ] {
            let cycle = cycle_of(Parameters { static_friction, law, damping_ratio, belt_velocity, forcing: None });
            close(cycle.period, period, 1e-10);
            close(cycle.slip_duration, slip, 1e-10);
            close(cycle.reattachment_displacement.unwrap(), reattachment, 1e-10);
        }
    }

    #[test]
    fn the_paper_s_law_gives_the_published_cycle() {
        let cycle = *limit_cycle(&Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap()).unwrap().cycle().unwrap();
        close(cycle.period, 6.372_163_483_739_709, 1e-13);
        close(cycle.slip_duration, 5.644_059_891_168_911, 1e-13);
        close(cycle.reattachment_displacement.unwrap(), 0.096_795_689_222_287_6, 1e-13);
        close(cycle.displacement_min, 0.095_239_651_620_418_2, 1e-13);
        close(cycle.displacement_max, 0.101_931_013_749_859_67, 1e-13);
    }

    #[test]
    fn leine_s_oscillator_gives_the_published_cycle() {
        // In units of the natural period.
        let cycle = *limit_cycle(&Oscillator::with_stribeck(1.0, 3.0, 0.0, 0.2).unwrap()).unwrap().cycle().unwrap();
        let found = [
            cycle.period,
            cycle.slip_duration,
            cycle.reattachment_displacement.unwrap(),
            cycle.displacement_max,
            cycle.velocity_min,
        ];
        for (found, (_, wanted, digit)) in found.into_iter().zip(asperity_testing::LEINE) {
            assert!((found - wanted).abs() <= 0.505 * digit, "{found} instead of {wanted}");
        }
    }

    #[test]
    fn above_the_critical_damping_there_is_no_cycle() {
        for damping in [0.2048302, 0.3, 0.99, 1.5, 20.0] {
            let oscillator = Oscillator::with_stribeck(0.1, 4.2, damping, 0.003).unwrap();
            assert_eq!(limit_cycle(&oscillator).unwrap(), Regime::Sliding, "damping ratio {damping}");
        }
        assert!(
            limit_cycle(&Oscillator::with_stribeck(0.1, 4.2, 0.2048301, 0.003).unwrap()).unwrap().cycle().is_some()
        );
    }

    #[test]
    #[ignore = "slow"]
    fn extreme_parameters_give_a_result() {
        let sizes = [0.0, 5e-324, 1e-9, 1e-6, 1e-3, 0.1, 1.0, 50.0, 1e4, 1e300];
        let mut cycles = 0;
        for sample in 0..500 {
            let mut choices = Choices::new(31, "extreme", sample);
            let (static_friction, belt_velocity) = (choices.one_of(&sizes), choices.one_of(&sizes));
            let (damping_ratio, decay) = (choices.one_of(&sizes), choices.one_of(&sizes));
            let kinetic = static_friction * choices.one_of(&[1.0, 0.3]);
            let law = VelocityLaw::Stribeck(Stribeck { kinetic, decay });
            let parameters = Parameters { static_friction, law, damping_ratio, belt_velocity, forcing: None };
            let oscillator = match Oscillator::new(parameters.clone()) {
                Ok(oscillator) => oscillator,
                Err(VibrationError::Parameter { .. }) => continue,
                Err(error) => panic!("{parameters:?}: {error}"),
            };
            match limit_cycle(&oscillator) {
                Ok(regime) => {
                    let Some(cycle) = regime.cycle() else { continue };
                    let LimitCycle { period, displacement_min, displacement_max, velocity_min, velocity_max, .. } =
                        *cycle;
                    assert!(period.is_finite() && period > 0.0, "{parameters:?}: {cycle:?}");
                    let values = [displacement_min, displacement_max, velocity_min, velocity_max];
                    assert!(values.iter().all(|x| x.is_finite()), "{parameters:?}: {cycle:?}");
                    assert!(
                        displacement_min <= displacement_max && velocity_min <= velocity_max,
                        "{parameters:?}: {cycle:?}"
                    );
                    cycles += 1;
                }
                // Hardly damped motion under hardly any friction takes very many cycles to its first stick.
                Err(error) => assert!(matches!(error, VibrationError::NotFound { .. }), "{parameters:?}: {error}"),
            }
        }
        assert!(cycles > 50, "{cycles}");
    }

    #[test]
    fn a_fast_belt_may_end_in_slip_and_over_slip_without_stick() {
        let oscillator = |forcing| {
            let law = VelocityLaw::Stribeck(Stribeck { kinetic: 0.1415, decay: 4.98 });
            let static_friction = 0.1688;
            Oscillator::new(Parameters { static_friction, law, damping_ratio: 0.003, belt_velocity: 1.732, forcing })
                .unwrap()
        };
        let cycle = *limit_cycle(&oscillator(None)).unwrap().cycle().unwrap();
        assert_eq!((cycle.reattachment_displacement, cycle.slips), (None, 0));
        // The energy that friction supplies in slip balances damping and over-slip, which exceeds the velocity of the
        // belt.
        let portrait = cycle_portrait(&oscillator(None), 100_001).unwrap().unwrap();
        let law = oscillator(None).law().clone();
        let power = |p: &PhasePoint| {
            let relative = 1.732 - p.velocity;
            (relative.signum() * law.coefficient(relative.abs()) - 0.006 * p.velocity) * p.velocity
        };
        let mean: f64 = portrait[1..].iter().map(power).sum::<f64>() / 100_000.0;
        let size: f64 = portrait[1..].iter().map(|p| power(p).abs()).sum::<f64>() / 100_000.0;
        // Each of the two jumps of the friction force causes an error of one step of the sum.
        assert!(mean.abs() < 1e-4 * size, "{mean} of {size}");
        assert!(portrait.iter().any(|p| p.velocity > 1.732));
        // Under forcing at resonance it follows the force, again without stick.
        let forced = oscillator(Some(Forcing { amplitude: 0.3, frequency: 1.0 }));
        let driven = *limit_cycle(&forced).unwrap().cycle().unwrap();
        assert_eq!((driven.slips, driven.period), (0, TAU));
    }

    #[test]
    fn a_cycle_faster_than_the_belt_is_overtaking() {
        // Independent integrator: cycles without stick at ζ = .001 and .002, with stick at .004.
        let belt = 31_416.0 / 10_000.0;
        for (damping, kind, period) in [
            (0.001, MotionKind::Overtaking, 6.294_67),
            (0.002, MotionKind::Overtaking, 6.294_99),
            (0.004, MotionKind::StickSlip, 6.295_32),
        ] {
            let regime = limit_cycle(&Oscillator::with_stribeck(0.432353, 4.2, damping, belt).unwrap()).unwrap();
            let cycle = regime.cycle().unwrap();
            assert_eq!((regime.kind(), cycle.kind), (kind, kind));
            assert!((cycle.period - period).abs() < 6e-6, "{cycle:?}");
            assert!(
                cycle.velocity_max >= belt - 1e-12 && (cycle.reattachment_displacement.is_some()) == (cycle.slips > 0)
            );
        }
    }

    #[test]
    fn weak_forcing_at_resonance_locks_the_cycle_to_its_period() {
        let free = Oscillator::with_stribeck(0.2, 4.2, 0.2, 0.1).unwrap();
        let forced = free.with_forcing(Some(Forcing { amplitude: 0.01, frequency: 0.98 })).unwrap();
        let cycle = *limit_cycle(&forced).unwrap().cycle().unwrap();
        assert_eq!(cycle.slips, 1);
        close(cycle.period, 2.0 * PI / 0.98, 1e-11);
        // Far above the limit the mass follows the force without stick.
        assert_eq!(limit_cycle(&forced.with_damping(0.5).unwrap()).unwrap(), Regime::Sliding);
    }
}
