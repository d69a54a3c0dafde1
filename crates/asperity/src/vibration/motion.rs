//! One trajectory: steps of the Taylor series cut at events.

use super::polynomial::{self, bracketed_zero};
use super::series::{Loading, Series, Weakening};
use super::sway::Sway;
use super::{Drive, Event, EventKind, FrictionLaw, Oscillator, Phase, VibrationError};
use crate::friction::process::Fluctuation;

/// Steps in a row that may leave the time where it is (an arrival and a release at one time are two).
const MAX_IDLE_STEPS: usize = 100;

/// Points at which the friction coefficient is checked when a bound does not settle its sign.
const POSITIVITY_POINTS: usize = 32;

/// The state of the mass while it is followed.
///
/// [`Motion::step`] advances to the next cut: an event, a knot of the friction process, the reach of the series, or the
/// asked time.
#[derive(Debug)]
pub(super) struct Motion<F> {
    weakening: Weakening,
    static_friction: f64,
    damping: f64,
    velocity: f64,
    sway: Sway,
    law: FrictionLaw,
    drive: Drive,
    fluctuation: F,
    cell: Cell,
    /// Time at the end of the last step.
    pub(super) tau: f64,
    /// Sliding distance ∫|v_rel|dτ.
    pub(super) sliding_distance: f64,
    /// Friction fluctuation m.
    m: f64,
    w: f64,
    e: f64,
    phase: Phase,
    /// Whether the mass has moved backwards, ẋ < 0, since it last stuck.
    pub(super) reached_backward: bool,
    series: Series,
    segment: Segment,
    idle_steps: usize,
}

/// A state of slip or over-slip.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlipState {
    pub(super) tau: f64,
    pub(super) phase: Phase,
    pub(super) w: f64,
    pub(super) e: f64,
}

impl SlipState {
    /// The state right after a detachment into slip.
    pub(super) fn detached(tau: f64) -> Self {
        Self { tau, phase: Phase::Slip, w: 0.0, e: 0.0 }
    }

    /// Whether two states are the same, at any times, within a tolerance relative to their size.
    pub(super) fn repeats(&self, other: &Self, tolerance: f64) -> bool {
        let change = (self.w - other.w).abs().max((self.e - other.e).abs());
        self.phase == other.phase && change < tolerance * self.w.abs().max(self.e.abs()).max(1.0)
    }
}

/// The last step, for dense output.
#[derive(Debug, Clone, Copy)]
struct Segment {
    tau: f64,
    duration: f64,
    phase: Phase,
    m: f64,
    slope: f64,
    e: f64,
}

/// The knots between which the friction process is a straight line.
#[derive(Debug, Clone, Copy)]
struct Cell {
    index: usize,
    left: f64,
    right: f64,
    slope: f64,
    start: f64,
    end: f64,
}

impl Cell {
    const ENDLESS: Self = Self { index: 0, left: 0.0, right: 0.0, slope: 0.0, start: 0.0, end: f64::INFINITY };
}

impl<F: Fluctuation> Motion<F> {
    /// A mass at X on the belt at τ = 0, with the velocity of the belt. It sticks if the force allows it and slips if not.
    pub(super) fn new(
        oscillator: &Oscillator,
        fluctuation: F,
        drive: Drive,
        start: f64,
    ) -> Result<Self, VibrationError> {
        let velocity = oscillator.belt_velocity();
        let mut motion = Self {
            weakening: Weakening::new(oscillator),
            static_friction: oscillator.static_friction(),
            damping: oscillator.damping_ratio(),
            velocity,
            sway: Sway::new(oscillator),
            law: oscillator.law(),
            drive,
            fluctuation,
            cell: Cell::ENDLESS,
            tau: 0.0,
            sliding_distance: 0.0,
            m: 0.0,
            w: 0.0,
            e: 0.0,
            phase: Phase::Stick,
            reached_backward: false,
            series: Series::new(),
            segment: Segment { tau: 0.0, duration: 0.0, phase: Phase::Stick, m: 0.0, slope: 0.0, e: 0.0 },
            idle_steps: 0,
        };
        if let Some(step) = motion.fluctuation.step() {
            motion.m = motion.draw()?;
            let right = motion.draw()?;
            let slope = (right - motion.m) / step;
            motion.cell = Cell { index: 0, left: motion.m, right, slope, start: 0.0, end: step };
        }
        motion.e = ((start - motion.static_friction) + 2.0 * motion.damping * velocity - motion.m) / velocity
            - motion.sway.force(0.0);
        motion.phase = motion.phase_at_rest()?;
        if motion.phase == Phase::OverSlip {
            motion.e = motion.opposite_excess();
        }
        Ok(motion)
    }

    /// A mass in a given state of slip.
    pub(super) fn in_slip(oscillator: &Oscillator, fluctuation: F, state: SlipState) -> Result<Self, VibrationError> {
        let mut motion = Self::new(oscillator, fluctuation, Drive::Distance, oscillator.static_friction())?;
        (motion.tau, motion.w, motion.e, motion.phase) = (state.tau, state.w, state.e, state.phase);
        Ok(motion)
    }

    /// The state at the last cut, if the mass slips.
    pub(super) fn slip_state(&self) -> Option<SlipState> {
        let state = SlipState { tau: self.tau, phase: self.phase, w: self.w, e: self.e };
        (self.phase != Phase::Stick).then_some(state)
    }

    fn draw(&mut self) -> Result<f64, VibrationError> {
        let exhausted = VibrationError::ProcessTooShort { tau: self.tau, coordinate: self.coordinate() };
        self.fluctuation.next_knot().ok_or(exhausted)
    }

    /// Where the friction process is read: sliding distance or Vτ.
    fn coordinate(&self) -> f64 {
        match self.drive {
            Drive::Distance => self.sliding_distance,
            Drive::Time => self.velocity * self.tau,
        }
    }

    /// Displacement X at the last cut.
    pub(super) fn displacement(&self) -> f64 {
        self.displacement_of(self.tau, self.phase, self.e, self.m)
    }

    fn displacement_of(&self, tau: f64, phase: Phase, e: f64, m: f64) -> f64 {
        let force = (self.velocity * e + m + self.static_friction) * phase.direction();
        force - 2.0 * self.damping * self.velocity + self.velocity * self.sway.force(tau)
    }

    /// (X, X′) at a time inside the last step.
    pub(super) fn sample(&self, tau: f64) -> (f64, f64) {
        let Segment { tau: start, phase, m, slope, e, .. } = self.segment;
        let t = tau - start;
        if phase == Phase::Stick {
            let drift = match self.drive {
                Drive::Distance => 0.0,
                Drive::Time => slope * self.velocity * t,
            };
            let excess = e + self.sway.growth(1.0, 1.0 - drift_rate(self.drive, slope), start, t);
            return (self.displacement_of(tau, phase, excess, m + drift), self.velocity);
        }
        let (w, e) = self.series.state(t);
        let moved = match self.drive {
            Drive::Distance => self.series.distance(t).0,
            Drive::Time => t,
        };
        let m = m + slope * self.velocity * moved;
        (self.displacement_of(tau, phase, e, m), self.velocity * (1.0 - phase.direction() * w))
    }

    /// Times in the last step at which X′ = 0 or W is extreme, and its ends: where displacement and velocity are extreme.
    pub(super) fn turning_times(&self) -> Vec<f64> {
        let Segment { tau, duration, phase, .. } = self.segment;
        let mut cuts = vec![0.0];
        if phase == Phase::Slip {
            cuts.extend(self.series.first_extremum(duration));
            cuts.push(duration);
            // W is monotonic between the cuts and passes 1, where X′ = 0, at most once in each.
            for i in 1..cuts.len() {
                let (low, high) = (cuts[i - 1], cuts[i]);
                let excess = |t| {
                    let (w, slope) = polynomial::value_and_slope(self.series.w(), t);
                    (w - 1.0, slope)
                };
                let (first, last) = (excess(low).0, excess(high).0);
                if first * last < 0.0 {
                    cuts.push(bracketed_zero(excess, low, high, first > 0.0, 0.5 * (low + high)));
                }
            }
        } else {
            cuts.push(duration);
        }
        cuts.into_iter().map(|t| tau + t).collect()
    }

    /// Whether W passed a minimum above zero in the last step: it fell at its beginning and rises at its end.
    pub(super) fn passed_minimum(&self) -> bool {
        self.segment.phase == Phase::Slip
            && self.phase == Phase::Slip
            && self.series.w()[1] < 0.0
            && self.weakening.acceleration(self.w, self.e) > 0.0
    }

    /// Whether the mass is at rest in space but for the tolerance: W = 1, W′ = 0.
    pub(super) fn has_settled(&self, tolerance: f64) -> bool {
        self.phase == Phase::Slip
            && (self.w - 1.0).abs() < tolerance
            && self.weakening.acceleration(self.w, self.e).abs() < tolerance
    }

    /// Advances to the next cut, at most to `until`; says so if the cut is an event.
    pub(super) fn step(&mut self, until: f64) -> Result<Option<Event>, VibrationError> {
        let before = self.tau;
        let event = match self.phase {
            Phase::Stick => self.stick(until),
            Phase::Slip | Phase::OverSlip => self.slip(until),
        }?;
        self.idle_steps = if self.tau > before { 0 } else { self.idle_steps + 1 };
        if self.idle_steps > MAX_IDLE_STEPS {
            return Err(VibrationError::Stalled { tau: self.tau });
        }
        Ok(event)
    }

    /// A detachment at τ = 0, if the force at the start exceeds the stick limit.
    pub(super) fn first_event(&self) -> Option<Event> {
        if self.phase == Phase::Stick { None } else { self.event(EventKind::Detach) }
    }

    fn event(&self, kind: EventKind) -> Option<Event> {
        Some(Event { kind, tau: self.tau, displacement: self.displacement(), sliding_distance: self.sliding_distance })
    }

    // ---- slip ----

    fn slip(&mut self, until: f64) -> Result<Option<Event>, VibrationError> {
        let direction = self.phase.direction();
        let remaining = until - self.tau;
        let (estimate, to_knot) = self.horizon();
        // A little more, so that the knot is inside the step.
        let wanted = remaining.min(if self.drive == Drive::Time { estimate } else { 1.1 * estimate });
        let loading = Loading {
            base: direction - drift_rate(self.drive, self.cell.slope),
            kappa: 1.0 + (self.cell.slope - drift_rate(self.drive, self.cell.slope)),
            swing: direction * self.sway.amplitude * self.sway.frequency,
            frequency: self.sway.frequency,
            phase: self.sway.frequency * self.tau,
        };
        self.segment =
            Segment { tau: self.tau, duration: 0.0, phase: self.phase, m: self.m, slope: self.cell.slope, e: self.e };
        self.series.expand(&self.weakening, &loading, self.w, self.e, wanted);
        let mut h = self.series.reach(wanted);
        // First the arrival, then the knot: past an arrival the distance would run backwards.
        let mut arrived = false;
        if let Some(t) = self.series.first_arrival(h) {
            (h, arrived) = (t, true);
        }
        let mut crossed = false;
        if self.drive == Drive::Time {
            crossed = !arrived && h >= to_knot;
        } else if to_knot.is_finite() && self.series.distance(h).0 >= to_knot {
            h = self.series.time_of_distance(to_knot, h, estimate);
            (crossed, arrived) = (true, false);
        }
        self.finish_slip(h, crossed, arrived, until)
    }

    /// About how long it takes to the next knot, and how far it is: in scaled distance or in time, after [`Drive`].
    #[inline]
    fn horizon(&self) -> (f64, f64) {
        let left = (self.cell.end - self.coordinate()) / self.velocity;
        if self.drive == Drive::Time {
            return (left.max(0.0), left.max(0.0));
        }
        if left == f64::INFINITY {
            return (left, left);
        }
        // At constant acceleration.
        let acceleration = self.weakening.acceleration(self.w, self.e);
        let discriminant = self.w * self.w + 2.0 * acceleration * left;
        (if discriminant > 0.0 { 2.0 * left / (self.w + discriminant.sqrt()) } else { f64::INFINITY }, left)
    }

    #[inline]
    fn finish_slip(
        &mut self,
        h: f64,
        crossed: bool,
        arrived: bool,
        until: f64,
    ) -> Result<Option<Event>, VibrationError> {
        let (before, rising) = (self.w, self.series.w()[1] > 0.0 || self.series.w()[0] == 0.0);
        let m_before = self.m;
        let (w, e) = self.series.state(h);
        self.segment.duration = h;
        self.tau = if h == until - self.tau { until } else { self.tau + h };
        self.e = e;
        self.w = if arrived { 0.0 } else { w.max(0.0) };
        if crossed && self.drive == Drive::Distance {
            self.sliding_distance = self.cell.end;
        } else {
            self.sliding_distance += self.velocity * self.series.distance(h).0;
        }
        if crossed {
            self.next_cell()?;
        } else if self.cell.end.is_finite() {
            self.m = self.cell.left + self.cell.slope * (self.coordinate() - self.cell.start);
        }
        let turns = rising && (arrived || self.weakening.acceleration(self.w, self.e) < 0.0);
        if self.phase == Phase::Slip && !self.reached_backward {
            self.reached_backward = self.w > 1.0
                || (turns
                    && self.series.ceiling(h) > 1.0
                    && self.series.first_extremum(h).is_some_and(|t| self.series.state(t).0 > 1.0));
        }
        self.check_friction(before, m_before, h, turns)?;
        if arrived { self.arrive() } else { Ok(None) }
    }

    /// Moves into the next cell of the friction process.
    fn next_cell(&mut self) -> Result<(), VibrationError> {
        let Some(step) = self.fluctuation.step() else { return Ok(()) };
        let left = self.cell.right;
        let right = self.draw()?;
        let index = self.cell.index + 1;
        let (start, end) = (index as f64 * step, (index + 1) as f64 * step);
        self.cell = Cell { index, left, right, slope: (right - left) / step, start, end };
        self.m = left;
        Ok(())
    }

    /// Refuses a friction coefficient that is not positive somewhere in the last step.
    #[inline]
    fn check_friction(&self, w_before: f64, m_before: f64, h: f64, turns: bool) -> Result<(), VibrationError> {
        let fastest = if turns { self.series.ceiling(h) } else { w_before.max(self.w) };
        if self.law.coefficient(self.velocity * fastest) + m_before.min(self.m) > 0.0 {
            return Ok(());
        }
        for i in 0..=POSITIVITY_POINTS {
            let share = i as f64 / POSITIVITY_POINTS as f64;
            let w = self.series.state(share * h).0;
            let moved = match self.drive {
                Drive::Distance => self.series.distance(share * h).0 / self.series.distance(h).0.max(f64::MIN_POSITIVE),
                Drive::Time => share,
            };
            let coefficient = self.law.coefficient(self.velocity * w.max(0.0)) + m_before + moved * (self.m - m_before);
            if coefficient <= 0.0 {
                return Err(VibrationError::FrictionNotPositive {
                    coefficient,
                    tau: self.segment.tau + share * h,
                    sliding_distance: self.sliding_distance,
                });
            }
        }
        Ok(())
    }

    /// The relative speed is zero: stick if the force is within the limit, else slip on.
    fn arrive(&mut self) -> Result<Option<Event>, VibrationError> {
        // An arrival has W′ = e + jump ≤ 0; anything else is rounding at a grazing arrival.
        self.e = self.e.min(-self.weakening.jump);
        let arrived_from = self.phase;
        if arrived_from == Phase::OverSlip {
            self.e = self.opposite_excess();
        }
        self.phase = self.phase_at_rest()?;
        if self.phase == Phase::OverSlip {
            self.e = self.opposite_excess();
        }
        if self.phase == Phase::Stick { Ok(self.event(EventKind::Restick)) } else { Ok(self.event(EventKind::Reverse)) }
    }

    /// Excess over the stick limit of the other direction.
    fn opposite_excess(&self) -> f64 {
        -self.e - 2.0 * (self.static_friction + self.m) / self.velocity
    }

    /// What a mass at W = 0 does, given e of the forward direction.
    fn phase_at_rest(&self) -> Result<Phase, VibrationError> {
        let coefficient = self.static_friction + self.m;
        if coefficient <= 0.0 {
            let (tau, sliding_distance) = (self.tau, self.sliding_distance);
            return Err(VibrationError::FrictionNotPositive { coefficient, tau, sliding_distance });
        }
        Ok(if self.e > 0.0 {
            Phase::Slip
        } else if self.opposite_excess() > 0.0 {
            Phase::OverSlip
        } else {
            Phase::Stick
        })
    }

    // ---- stick ----

    fn stick(&mut self, until: f64) -> Result<Option<Event>, VibrationError> {
        let rate = drift_rate(self.drive, self.cell.slope);
        self.segment =
            Segment { tau: self.tau, duration: 0.0, phase: Phase::Stick, m: self.m, slope: self.cell.slope, e: self.e };
        let to_knot = match self.drive {
            Drive::Distance => f64::INFINITY,
            Drive::Time => ((self.cell.end - self.coordinate()) / self.velocity).max(0.0),
        };
        let limit = (until - self.tau).min(to_knot);
        let forward = self.sway.release(1.0, 1.0 - rate, self.e, self.tau, limit);
        let backward = self.sway.release(-1.0, -1.0 - rate, self.opposite_excess(), self.tau, forward.unwrap_or(limit));
        let (h, released) = match (forward, backward) {
            (_, Some(t)) => (t, Some(Phase::OverSlip)),
            (Some(t), None) => (t, Some(Phase::Slip)),
            (None, None) => (limit, None),
        };
        self.e += self.sway.growth(1.0, 1.0 - rate, self.tau, h);
        self.segment.duration = h;
        self.tau = if h == until - self.tau { until } else { self.tau + h };
        if self.drive == Drive::Time {
            if h >= to_knot && released.is_none() {
                self.next_cell()?;
            } else if self.cell.end.is_finite() {
                self.m = self.cell.left + self.cell.slope * (self.coordinate() - self.cell.start);
            }
            let coefficient = self.static_friction + self.m;
            if coefficient <= 0.0 {
                let (tau, sliding_distance) = (self.tau, self.sliding_distance);
                return Err(VibrationError::FrictionNotPositive { coefficient, tau, sliding_distance });
            }
        }
        let Some(phase) = released else { return Ok(None) };
        // At the release the excess is zero by definition.
        (self.w, self.e, self.phase) = (0.0, 0.0, phase);
        self.reached_backward = false;
        Ok(self.event(EventKind::Detach))
    }
}

/// dm/dτ divided by V, for a process read in time; a process read in sliding distance changes through κ instead.
fn drift_rate(drive: Drive, slope: f64) -> f64 {
    match drive {
        Drive::Distance => 0.0,
        Drive::Time => slope,
    }
}
