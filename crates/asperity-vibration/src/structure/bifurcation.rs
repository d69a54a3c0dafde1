//! Attractors over a parameter that rises and then falls.

use std::cmp::Ordering;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::super::cycle::{LimitCycle, Turn};
use super::super::motion::Motion;
use super::super::{
    EventKind, MotionKind, Oscillator, Regime, VibrationError, critical_damping, limit_cycle, locked_boundary,
};
use super::basin::{StartClassifier, started_at};
use super::parameter::CurveParameter;
use super::slip_cycle::{SlipCycle, slip_cycles};
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_base::numeric::try_root_between;
use asperity_process::Steady;

/// Difference of states, relative to the belt velocity and the stick limit, below which a motion counts as repeated.
const REPEATS: f64 = 1e-6;
/// Largest number of forcing periods per period of a periodic motion.
const MAX_MULTIPLICITY: usize = 32;
/// Largest factor by which the distance from a repetition shrinks during a record while the motion counts as
/// approaching one. Close to a bifurcation a motion approaches slowly.
const APPROACH_FACTOR: f64 = 0.999;
/// Largest number of records of a motion that approaches a repetition.
const MAX_BLOCKS: usize = 300;

/// Settings of a diagram.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BifurcationSettings {
    /// Values of the parameter, rising.
    pub values: Vec<f64>,
    /// Number of forcing periods that are discarded at each value while the motion settles.
    pub transient: usize,
    /// Number of forcing periods that are recorded afterwards, at least 2. While the motion does not repeat but
    /// approaches a repetition, further records of the same length follow, up to three hundred.
    pub recorded: usize,
}

impl BifurcationSettings {
    /// Creates settings with `count` ≥ 2 equally spaced values, 400 forcing periods to settle and 100 to record.
    pub fn new([low, high]: [f64; 2], count: usize) -> Self {
        let last = count.max(2) - 1;
        let values = (0..=last).map(|i| low + (high - low) * i as f64 / last as f64).collect();
        Self { values, transient: 400, recorded: 100 }
    }
}

/// Motion from one detachment to the next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Turnover {
    /// Time T between the two.
    pub duration: f64,
    /// Displacement X_r at the last re-attachment between them.
    pub reattachment_displacement: Option<f64>,
    /// Least X′ between them.
    pub velocity_min: f64,
}

/// Motion at one value of the parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BifurcationPoint {
    /// Value of the parameter.
    pub parameter: f64,
    /// Kind of the motion. Under forcing, a periodic response slower than the belt counts as none.
    pub attractor: MotionKind,
    /// Number of forcing periods per period of the motion; none if it does not repeat within 32 periods or half of the
    /// recorded ones. Always 1 without forcing.
    pub multiplicity: Option<usize>,
    /// False if the motion was still approaching a repetition when the computation stopped, for example close to a
    /// bifurcation. It is then probably periodic although it has no multiplicity.
    pub settled: bool,
    /// Least and largest X.
    pub displacement: [f64; 2],
    /// Least and largest X′.
    pub velocity: [f64; 2],
    /// Detachments of one period, or all recorded ones of a motion that does not repeat. Under forcing, a cycle that
    /// passes the belt velocity without stick has none.
    pub turnovers: Vec<Turnover>,
}

/// Kind of a mark on a diagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MarkKind {
    /// ζ = ζ_H: steady sliding loses its stability.
    Hopf,
    /// ζ = ζ_c: the stick-slip cycle ends.
    Fold,
    /// ζ of [`locked_boundary`]: the locked cycle ends.
    LockedFold,
}

/// Value of the parameter at which the attractors change.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// Kind of the change.
    pub kind: MarkKind,
    /// Value of the parameter.
    pub parameter: f64,
}

/// Attractors over a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BifurcationDiagram {
    /// The parameter.
    pub parameter: CurveParameter,
    /// Points for a rising parameter.
    pub upward: Vec<BifurcationPoint>,
    /// Points for a falling parameter, also listed by rising parameter.
    pub downward: Vec<BifurcationPoint>,
    /// Changes between the first and the last value. Without forcing they are all Hopf points and folds between
    /// neighbouring values; with forcing the end of the locked cycle, for the damping ratio only.
    pub marks: Vec<Mark>,
}

/// Returns the attractors over a parameter that rises slowly and then falls slowly.
///
/// Each value starts from the end state of the previous one, the first from rest on the belt. Where the two directions
/// differ, more than one attractor exists. Without forcing the attractor is exact: the basin of the start determines
/// it. With forcing the motion is followed until it repeats or no longer approaches a repetition.
///
/// Fails for values that do not rise or are out of range, if friction does not stay positive, or when cancelled.
pub fn bifurcation_diagram(
    oscillator: &Oscillator,
    parameter: CurveParameter,
    settings: &BifurcationSettings,
    monitor: &dyn Monitor,
) -> Result<BifurcationDiagram, VibrationError> {
    let values = &settings.values;
    if values.len() < 2 {
        let value = values.len() as f64;
        return Err(VibrationError::Parameter { parameter: "number of values", value, wanted: "at least 2" });
    }
    if let Some(pair) = values.windows(2).find(|pair| pair[1].partial_cmp(&pair[0]) != Some(Ordering::Greater)) {
        return Err(VibrationError::Parameter { parameter: "values of the diagram", value: pair[1], wanted: "rising" });
    }
    if settings.recorded < 2 {
        let value = settings.recorded as f64;
        return Err(VibrationError::Parameter { parameter: "recorded", value, wanted: "at least 2" });
    }
    let oscillators = values.iter().map(|value| parameter.set(oscillator, *value)).collect::<Result<Vec<_>, _>>()?;
    let first = &oscillators[0];
    let mut state = [first.default_start(), first.belt_velocity()];
    let total = 2 * values.len();
    let mut points = Vec::with_capacity(total);
    for i in (0..values.len()).chain((0..values.len()).rev()) {
        if monitor.cancelled() {
            return Err(Cancelled.into());
        }
        let (point, end) = match oscillators[i].forcing() {
            None => free_point(&oscillators[i], values[i], state)?,
            Some(forcing) => forced_point(&oscillators[i], TAU / forcing.frequency, values[i], state, settings)?,
        };
        state = end;
        points.push(point);
        monitor.progress("values of the diagram", points.len(), total);
    }
    let mut downward = points.split_off(values.len());
    downward.reverse();
    let marks = marks(oscillator, parameter, values, &oscillators)?;
    Ok(BifurcationDiagram { parameter, upward: points, downward, marks })
}

/// Returns the attractor of a start and a state on it.
fn free_point(
    oscillator: &Oscillator,
    value: f64,
    [x, v]: [f64; 2],
) -> Result<(BifurcationPoint, [f64; 2]), VibrationError> {
    let belt = oscillator.belt_velocity();
    let attractor = StartClassifier::new(oscillator)?.kind(x, v)?;
    let rest = oscillator.law().coefficient(belt);
    let mut point = BifurcationPoint {
        parameter: value,
        attractor,
        multiplicity: Some(1),
        settled: true,
        displacement: [rest; 2],
        velocity: [0.0; 2],
        turnovers: Vec::new(),
    };
    let regime = if attractor.is_vibration() { limit_cycle(oscillator)? } else { Regime::Sliding };
    let reached = regime.cycle().copied().filter(|cycle| cycle.kind == attractor);
    let cycle = match reached {
        None if attractor == MotionKind::SlipCycle => {
            slip_cycles(oscillator)?.into_iter().find(SlipCycle::is_stable).map(Into::into)
        }
        reached => reached,
    };
    let Some(LimitCycle { displacement_min, displacement_max, velocity_min, velocity_max, .. }) = cycle else {
        // Undecided to rounding at the end of a cycle: the motion counts as steady sliding.
        point.attractor = MotionKind::None;
        return Ok((point, [rest, 0.0]));
    };
    point.displacement = [displacement_min, displacement_max];
    point.velocity = [velocity_min, velocity_max];
    if attractor == MotionKind::SlipCycle {
        return Ok((point, [displacement_max, 0.0]));
    }
    point.turnovers = cycle
        .map(|cycle| Turnover {
            duration: cycle.period,
            reattachment_displacement: cycle.reattachment_displacement,
            velocity_min,
        })
        .into_iter()
        .collect();
    let detachment = oscillator.static_friction() - 2.0 * oscillator.damping_ratio() * belt;
    Ok((point, [detachment, belt]))
}

/// Returns the motion after its transient, and its state at the end of a forcing period.
fn forced_point(
    oscillator: &Oscillator,
    period: f64,
    value: f64,
    [x, v]: [f64; 2],
    settings: &BifurcationSettings,
) -> Result<(BifurcationPoint, [f64; 2]), VibrationError> {
    let scale = [oscillator.static_friction(), oscillator.belt_velocity()];
    let mut forced = ForcedMotion { motion: started_at(oscillator, x, v)?, period, turn: Turn::EMPTY, begun: None };
    forced.pass(settings.transient)?;
    let mut record = forced.record(settings.recorded)?;
    let mut settled = false;
    // A motion that approaches a repetition gets further records.
    for _ in 1..MAX_BLOCKS {
        if record.multiplicity(scale) == Some(1) {
            settled = true;
            break;
        }
        let next = forced.record(settings.recorded)?;
        settled = !next.approaches(&record, scale);
        record = next;
        if settled {
            break;
        }
    }
    let multiplicity = record.multiplicity(scale).filter(|_| settled);
    let since = settings.recorded - multiplicity.unwrap_or(settings.recorded);
    let span = |spans: &[[f64; 2]]| spans[since..].iter().fold(EMPTY_RANGE, |[a, b], [c, d]| [a.min(*c), b.max(*d)]);
    let turnovers = record.turns.iter().filter(|(index, _)| *index >= since).map(|(_, turn)| Turnover {
        duration: turn.duration,
        reattachment_displacement: turn.reattachment,
        velocity_min: turn.slowest,
    });
    let point = BifurcationPoint {
        parameter: value,
        attractor: match (record.sticks, record.touched) {
            (true, _) => MotionKind::StickSlip,
            (false, true) => MotionKind::Overtaking,
            (false, false) => MotionKind::None,
        },
        multiplicity,
        settled,
        displacement: span(&record.displacements),
        velocity: span(&record.velocities),
        turnovers: turnovers.collect(),
    };
    Ok((point, record.states.last().copied().unwrap_or([x, v])))
}

/// Empty range.
const EMPTY_RANGE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Motion that is followed by forcing periods; its time is counted from the last one.
struct ForcedMotion {
    motion: Motion<Steady>,
    period: f64,
    /// Turn since the last recorded detachment, and the time of that detachment.
    turn: Turn,
    begun: Option<f64>,
}

/// Record of several forcing periods.
struct Record {
    /// (X, X′) at the end of each period.
    states: Vec<[f64; 2]>,
    /// Extremes in each period.
    displacements: Vec<[f64; 2]>,
    velocities: Vec<[f64; 2]>,
    /// Turns, with the forcing period in which each ends.
    turns: Vec<(usize, Turn)>,
    /// Whether the mass reached the belt velocity.
    touched: bool,
    /// Whether the mass stuck.
    sticks: bool,
}

impl ForcedMotion {
    /// Advances by a number of forcing periods without a record.
    fn pass(&mut self, periods: usize) -> Result<(), VibrationError> {
        for _ in 0..periods {
            while self.motion.tau < self.period {
                self.motion.step(self.period)?;
            }
            self.motion.tau -= self.period;
        }
        Ok(())
    }

    fn record(&mut self, periods: usize) -> Result<Record, VibrationError> {
        let (mut states, mut displacements, mut velocities) = (Vec::new(), Vec::new(), Vec::new());
        let (mut turns, mut touched, mut sticks) = (Vec::new(), false, self.motion.slip_state().is_none());
        for index in 0..periods {
            let (mut displacement, mut velocity) = (EMPTY_RANGE, EMPTY_RANGE);
            while self.motion.tau < self.period {
                let event = self.motion.step(self.period)?;
                self.turn.include(&self.motion);
                for (x, v) in self.motion.turning_times().into_iter().map(|tau| self.motion.sample(tau)) {
                    displacement = [displacement[0].min(x), displacement[1].max(x)];
                    velocity = [velocity[0].min(v), velocity[1].max(v)];
                }
                touched |= event.is_some();
                match event.map(|e| e.kind) {
                    Some(EventKind::Restick) => {
                        self.turn.reattachment = Some(self.motion.displacement());
                        sticks = true;
                    }
                    Some(EventKind::Detach) => {
                        if let Some(begun) = self.begun {
                            self.turn.duration = self.motion.tau - begun;
                            turns.push((index, self.turn));
                        }
                        (self.turn, self.begun) = (Turn::EMPTY, Some(self.motion.tau));
                    }
                    Some(EventKind::Reverse) | None => {}
                }
            }
            states.push(self.motion.sample(self.motion.tau).into());
            displacements.push(displacement);
            velocities.push(velocity);
            self.motion.tau -= self.period;
            self.begun = self.begun.map(|begun| begun - self.period);
        }
        Ok(Record { states, displacements, velocities, turns, touched, sticks })
    }
}

impl Record {
    /// Returns the largest distance between the states of the later half and the states k forcing periods before.
    /// States at the largest multiple of k that the record covers count too, because a slow motion hardly moves in one
    /// period.
    fn apart(&self, k: usize, scale: [f64; 2]) -> f64 {
        let n = self.states.len();
        let distance = |a: [f64; 2], b: [f64; 2]| (0..2).map(|i| (a[i] - b[i]).abs() / scale[i]).fold(0.0, f64::max);
        let lags = [k, k * (n / 2 / k)];
        let all = (n / 2..n).flat_map(|i| lags.map(|lag| distance(self.states[i], self.states[i - lag])));
        all.fold(0.0, f64::max)
    }

    /// Returns the numbers of forcing periods after which the motion may repeat.
    fn periods(&self) -> RangeInclusive<usize> {
        1..=MAX_MULTIPLICITY.min(self.states.len() / 2)
    }

    /// Returns the number of forcing periods after which the states repeat.
    fn multiplicity(&self, scale: [f64; 2]) -> Option<usize> {
        self.periods().find(|k| self.apart(*k, scale) < REPEATS)
    }

    /// Returns whether the motion is closer to a repetition than in the previous record. If it repeats, compares
    /// repetitions after fewer forcing periods.
    fn approaches(&self, before: &Self, scale: [f64; 2]) -> bool {
        let closer = |after: f64, before: f64| after < APPROACH_FACTOR * before;
        if let Some(multiplicity) = self.multiplicity(scale) {
            return (1..multiplicity).any(|k| closer(self.apart(k, scale), before.apart(k, scale)));
        }
        let closest = |record: &Self| record.periods().map(|k| record.apart(k, scale)).fold(f64::INFINITY, f64::min);
        closer(closest(self), closest(before))
    }
}

fn marks(
    oscillator: &Oscillator,
    parameter: CurveParameter,
    values: &[f64],
    oscillators: &[Oscillator],
) -> Result<Vec<Mark>, VibrationError> {
    let (low, high) = (values[0], values[values.len() - 1]);
    if oscillator.forcing().is_some() {
        if parameter != CurveParameter::DampingRatio {
            return Ok(Vec::new());
        }
        // Without a locked cycle there is no mark.
        let boundary = locked_boundary(oscillator).ok().filter(|damping| (low..=high).contains(damping));
        return Ok(boundary.map(|parameter| Mark { kind: MarkKind::LockedFold, parameter }).into_iter().collect());
    }
    let mut marks = Vec::new();
    for kind in [MarkKind::Hopf, MarkKind::Fold] {
        let above = |oscillator: &Oscillator| -> Result<f64, VibrationError> {
            let ends = critical_damping(oscillator)?;
            let end = if kind == MarkKind::Hopf { ends.hopf_damping_ratio } else { ends.critical_damping_ratio };
            Ok(oscillator.damping_ratio() - end)
        };
        let heights = oscillators.iter().map(above).collect::<Result<Vec<_>, _>>()?;
        for i in 1..values.len() {
            let ends = [i - 1, i].map(|i| [values[i], heights[i]]);
            if ends[0][1] * ends[1][1] < 0.0 {
                let height = |value: f64| above(&parameter.set(oscillator, value)?);
                let root = try_root_between(height, ends[0], ends[1], 1e-15)?;
                marks.extend(root.map(|parameter| Mark { kind, parameter }));
            }
        }
    }
    Ok(marks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Coulomb;
    use crate::{Forcing, forced_cycles};
    use asperity_base::monitor::Silent;

    #[test]
    fn stick_slip_lasts_to_the_fold_and_sliding_to_the_hopf_point() {
        let oscillator = Oscillator::with_stribeck(0.3, 4.2, 0.0, 0.1).unwrap();
        let ends = critical_damping(&oscillator).unwrap();
        let (hopf, fold) = (ends.hopf_damping_ratio, ends.critical_damping_ratio);
        let settings = BifurcationSettings::new([0.28, 0.36], 41);
        let found = bifurcation_diagram(&oscillator, CurveParameter::DampingRatio, &settings, &Silent).unwrap();
        for (points, limit) in [(&found.upward, fold), (&found.downward, hopf)] {
            for point in points {
                let wanted = if point.parameter < limit { MotionKind::StickSlip } else { MotionKind::None };
                assert_eq!(point.attractor, wanted, "{point:?}, limit {limit}");
                assert_eq!(point.turnovers.len(), usize::from(wanted == MotionKind::StickSlip));
            }
        }
        assert_eq!(found.marks.iter().map(|m| m.kind).collect::<Vec<_>>(), [MarkKind::Hopf, MarkKind::Fold]);
        assert!((found.marks[0].parameter - hopf).abs() < 1e-13 && (found.marks[1].parameter - fold).abs() < 1e-13);
    }

    #[test]
    fn the_section_of_a_cycle_matches_the_publication_and_fast_belts_do_not_vibrate() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        let settings =
            BifurcationSettings { values: vec![0.003, 0.02, 0.05], ..BifurcationSettings::new([0.0, 1.0], 2) };
        let found = bifurcation_diagram(&oscillator, CurveParameter::BeltVelocity, &settings, &Silent).unwrap();
        for points in [&found.upward, &found.downward] {
            let turnover = points[0].turnovers[0];
            assert!((turnover.duration / 6.372_163_483_739_709 - 1.0).abs() < 1e-12);
            assert!((turnover.reattachment_displacement.unwrap() / 0.096_795_689_222_287_6 - 1.0).abs() < 1e-12);
            assert_eq!(points[2].attractor, MotionKind::None);
            assert!((points[2].displacement[0] - 0.1 / 1.21).abs() < 1e-15);
        }
        // ζ_H(V) = ζ has the closed form V = (√(aμ/2ζ) − 1)/a.
        let wanted = ((4.2_f64 * 0.1 / 0.34).sqrt() - 1.0) / 4.2;
        assert!((found.marks[0].parameter - wanted).abs() < 1e-13, "{:?}", found.marks);
    }

    #[test]
    fn a_mass_that_overtakes_its_belt_does_not_count_as_stick_slip() {
        // Cycles without stick at ζ = .001 and .002, with stick at .004, by an independent integrator.
        let belt = 31_416.0 / 10_000.0;
        let oscillator = Oscillator::with_stribeck(0.432353, 4.2, 0.0, belt).unwrap();
        let settings =
            BifurcationSettings { values: vec![0.001, 0.002, 0.004], ..BifurcationSettings::new([0.0, 1.0], 2) };
        let found = bifurcation_diagram(&oscillator, CurveParameter::DampingRatio, &settings, &Silent).unwrap();
        for points in [&found.upward, &found.downward] {
            let kinds: Vec<_> = points.iter().map(|point| point.attractor).collect();
            assert_eq!(kinds, [MotionKind::Overtaking, MotionKind::Overtaking, MotionKind::StickSlip]);
            assert!(points[0].velocity[1] > belt && points[0].turnovers[0].reattachment_displacement.is_none());
        }
        // Starts inside and outside that cycle.
        let classifier = StartClassifier::new(&oscillator.with_damping(0.001).unwrap()).unwrap();
        for start in [[0.1, 0.0], [3.0, 0.0], [0.0, 3.2], [4.0, 1.0], [0.0, belt]] {
            assert_eq!(classifier.kind(start[0], start[1]).unwrap(), MotionKind::Overtaking, "{start:?}");
        }
    }

    #[test]
    #[ignore = "slow"]
    fn a_forced_oscillator_is_locked_up_to_its_boundary_and_irregular_motion_has_many_points() {
        let free = Oscillator::with_stribeck(0.2, 4.2, 0.2, 0.1).unwrap();
        let forced = free.with_forcing(Some(Forcing { amplitude: 0.01, frequency: 0.98 })).unwrap();
        let boundary = locked_boundary(&forced).unwrap();
        let values = vec![0.2, 0.25, boundary - 1e-3, boundary + 1e-3, 0.3];
        let settings = BifurcationSettings { values, ..BifurcationSettings::new([0.0, 1.0], 2) };
        let found = bifurcation_diagram(&forced, CurveParameter::DampingRatio, &settings, &Silent).unwrap();
        assert_eq!(found.marks, [Mark { kind: MarkKind::LockedFold, parameter: boundary }]);
        for point in &found.upward[..3] {
            assert_eq!((point.attractor, point.multiplicity), (MotionKind::StickSlip, Some(1)), "{point:?}");
            let oscillator = forced.with_damping(point.parameter).unwrap();
            let cycles = forced_cycles(&oscillator, 1, &Silent).unwrap();
            let stable = cycles.iter().find(|c| c.is_stable()).unwrap().cycle;
            assert_eq!(point.turnovers.len(), 1);
            let differences = [
                point.turnovers[0].duration - stable.period,
                point.turnovers[0].velocity_min - stable.velocity_min,
                point.displacement[1] - stable.displacement_max,
                point.velocity[1] - 0.1,
            ];
            assert!(differences.iter().all(|d| d.abs() < 1e-9), "{differences:?}");
        }
        assert_eq!(found.upward[4].attractor, MotionKind::None, "{:?}", found.upward[4]);
        let beating = free.with_damping(0.1).unwrap().with_forcing(Some(Forcing { amplitude: 0.05, frequency: 0.7 }));
        let settings = BifurcationSettings::new([0.1, 0.11], 2);
        let found = bifurcation_diagram(&beating.unwrap(), CurveParameter::DampingRatio, &settings, &Silent).unwrap();
        assert!(
            found.upward[0].multiplicity.is_none() && found.upward[0].turnovers.len() > 80,
            "{:?}",
            found.upward[0]
        );
    }

    #[test]
    fn a_slowly_settling_motion_is_followed_until_it_repeats() {
        // Slip under a force, without stick, loses the effect of its start as e^{−ζτ}: to 1 % in 100 forcing periods.
        let law = crate::VelocityLaw::Coulomb(Coulomb { kinetic: 0.2 });
        let forcing = Some(Forcing { amplitude: 0.01, frequency: 0.7 });
        let (damping_ratio, belt_velocity) = (0.005, 0.5);
        let parameters = crate::Parameters { static_friction: 0.2, law, damping_ratio, belt_velocity, forcing };
        let oscillator = Oscillator::new(parameters).unwrap();
        let short = BifurcationSettings { transient: 0, ..BifurcationSettings::new([0.005, 0.006], 2) };
        let found = bifurcation_diagram(&oscillator, CurveParameter::DampingRatio, &short, &Silent).unwrap();
        let point = &found.upward[0];
        assert_eq!(
            (point.attractor, point.multiplicity, point.settled),
            (MotionKind::None, Some(1), true),
            "{point:?}"
        );
        // The steady response has the amplitude q/|1 − η² + 2iζη| about μ.
        let amplitude = 0.01 / (1.0_f64 - 0.49).hypot(0.007);
        let [low, high] = point.displacement;
        assert!((high - 0.2 - amplitude).abs() < 1e-6 && (0.2 - low - amplitude).abs() < 1e-6, "{point:?} {amplitude}");
    }

    #[test]
    fn close_to_a_period_doubling_the_motion_is_the_stable_cycle_of_the_shooting() {
        // Multipliers of −.99924 and .99896 per period of the motion.
        let free = Oscillator::with_stribeck(0.2, 4.2, 0.1, 0.1).unwrap();
        let forced = free.with_forcing(Some(Forcing { amplitude: 0.2, frequency: 1.0 })).unwrap();
        for frequency in [2.125, 2.115] {
            let machine = CurveParameter::ForcingFrequency.set(&forced, frequency).unwrap();
            let stable: Vec<_> =
                forced_cycles(&machine, 2, &Silent).unwrap().into_iter().filter(|cycle| cycle.is_stable()).collect();
            let settings = BifurcationSettings::new([frequency, frequency + 1e-6], 2);
            let found = bifurcation_diagram(&forced, CurveParameter::ForcingFrequency, &settings, &Silent).unwrap();
            let point = &found.upward[0];
            assert_eq!((stable.len(), point.settled), (1, true), "{point:?}");
            assert_eq!(point.multiplicity, Some(stable[0].forcing_periods), "{point:?}");
            let least = point.turnovers.iter().map(|turn| turn.velocity_min).fold(f64::INFINITY, f64::min);
            assert!((least - stable[0].cycle.velocity_min).abs() < 1e-5, "{point:?} {:?}", stable[0]);
        }
    }

    #[test]
    fn values_that_do_not_rise_are_refused() {
        let oscillator = Oscillator::with_stribeck(0.2, 4.2, 0.2, 0.1).unwrap();
        for values in [vec![], vec![0.1], vec![0.2, 0.1], vec![0.1, f64::NAN]] {
            let settings = BifurcationSettings { values, ..BifurcationSettings::new([0.0, 1.0], 2) };
            assert!(bifurcation_diagram(&oscillator, CurveParameter::DampingRatio, &settings, &Silent).is_err());
        }
    }
}
