//! Motion along one trajectory: steps of the Taylor series that end at events.

mod dense;
mod slip;
mod stick;

use super::scaled_forcing::ScaledForcing;
use super::series::Series;
use super::weakening::Weakening;
use super::{Drive, Event, EventKind, Oscillator, Phase, VelocityLaw, VibrationError};
use asperity_process::{Cell, Fluctuation};

/// Largest number of consecutive steps without progress in time; an arrival and a release at the same time are two.
pub(super) const MAX_IDLE_STEPS: usize = 100;

/// Motion of the mass under one realisation of the friction process.
///
/// [`Motion::step`] advances to the next cut: an event, a grid point of the friction process, the reach of the series,
/// or the requested time.
#[derive(Debug)]
pub(super) struct Motion<F> {
    weakening: Weakening,
    static_friction: f64,
    damping: f64,
    velocity: f64,
    scaled: ScaledForcing,
    law: VelocityLaw,
    drive: Drive,
    fluctuation: F,
    cell: CurrentCell,
    /// Time at the end of the last step.
    pub(super) tau: f64,
    /// Sliding distance ∫|v_rel|dτ.
    pub(super) sliding_distance: f64,
    /// Friction fluctuation m.
    m: f64,
    w: f64,
    e: f64,
    phase: Phase,
    /// Whether the mass has moved backwards, ẋ < 0, since its last slip was finished.
    pub(super) reached_backward: bool,
    series: Series,
    segment: Segment,
    idle_steps: usize,
}

/// State of slip or over-slip.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlipState {
    pub(super) tau: f64,
    pub(super) phase: Phase,
    pub(super) w: f64,
    pub(super) e: f64,
}

impl SlipState {
    /// Creates the state right after a detachment into slip.
    pub(super) fn detached(tau: f64) -> Self {
        Self { tau, phase: Phase::Slip, w: 0.0, e: 0.0 }
    }

    /// Returns whether two states at any times agree within a tolerance relative to their size.
    pub(super) fn repeats(&self, other: &Self, tolerance: f64) -> bool {
        let change = (self.w - other.w).abs().max((self.e - other.e).abs());
        self.phase == other.phase && change < tolerance * self.w.abs().max(self.e.abs()).max(1.0)
    }
}

/// Last step, for dense output.
#[derive(Debug, Clone, Copy)]
struct Segment {
    tau: f64,
    duration: f64,
    phase: Phase,
    m: f64,
    slope: f64,
    e: f64,
}

/// Present cell of the friction process, with its start and its slope.
#[derive(Debug, Clone, Copy)]
struct CurrentCell {
    left: f64,
    right: f64,
    slope: f64,
    start: f64,
    end: f64,
}

impl CurrentCell {
    fn new(cell: Cell, start: f64) -> Self {
        Self { left: cell.left, right: cell.right, slope: cell.slope(), start, end: cell.end }
    }

    /// Returns m at a coordinate inside the cell.
    #[inline]
    fn at(&self, coordinate: f64) -> f64 {
        // A cell without end has constant m.
        if self.end.is_finite() { self.left + self.slope * (coordinate - self.start) } else { self.left }
    }
}

impl<F: Fluctuation> Motion<F> {
    /// Creates a mass at X on the belt at τ = 0, with the velocity of the belt. It sticks if the force allows it;
    /// otherwise it slips.
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
            scaled: ScaledForcing::new(oscillator),
            law: oscillator.law().clone(),
            drive,
            fluctuation,
            cell: CurrentCell { left: 0.0, right: 0.0, slope: 0.0, start: 0.0, end: 0.0 },
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
        motion.cell = CurrentCell::new(motion.draw()?, 0.0);
        motion.m = motion.cell.left;
        motion.e = ((start - motion.static_friction) + 2.0 * motion.damping * velocity - motion.m) / velocity
            - motion.scaled.force(0.0);
        motion.phase = motion.phase_at_rest()?;
        if motion.phase == Phase::OverSlip {
            motion.e = motion.opposite_excess();
        }
        Ok(motion)
    }

    /// Creates a mass at (X, X′) at τ = 0. With the velocity of the belt it sticks if the force allows it.
    pub(super) fn started_at(
        oscillator: &Oscillator,
        fluctuation: F,
        drive: Drive,
        [displacement, velocity]: [f64; 2],
    ) -> Result<Self, VibrationError> {
        let mut motion = Self::new(oscillator, fluctuation, drive, displacement)?;
        let w = 1.0 - velocity / motion.velocity;
        if w != 0.0 {
            motion.phase = if w > 0.0 { Phase::Slip } else { Phase::OverSlip };
            motion.w = w.abs();
            let external = motion.velocity * motion.scaled.force(0.0);
            let force = motion.phase.direction() * (displacement + 2.0 * motion.damping * motion.velocity - external);
            motion.e = (force - motion.static_friction - motion.m) / motion.velocity;
            motion.reached_backward = velocity < 0.0;
        }
        Ok(motion)
    }

    /// Creates a motion from a state of slip.
    pub(super) fn from_slip(oscillator: &Oscillator, fluctuation: F, state: SlipState) -> Result<Self, VibrationError> {
        let mut motion = Self::new(oscillator, fluctuation, Drive::Distance, oscillator.static_friction())?;
        (motion.tau, motion.w, motion.e, motion.phase) = (state.tau, state.w, state.e, state.phase);
        Ok(motion)
    }

    /// Returns the state at the last cut, if the mass slips.
    pub(super) fn slip_state(&self) -> Option<SlipState> {
        let state = SlipState { tau: self.tau, phase: self.phase, w: self.w, e: self.e };
        (self.phase != Phase::Stick).then_some(state)
    }

    fn draw(&mut self) -> Result<Cell, VibrationError> {
        let exhausted = VibrationError::ProcessTooShort { tau: self.tau, coordinate: self.coordinate() };
        self.fluctuation.next_cell().ok_or(exhausted)
    }

    /// Returns the coordinate of the friction process: sliding distance or Vτ.
    fn coordinate(&self) -> f64 {
        match self.drive {
            Drive::Distance => self.sliding_distance,
            Drive::Time => self.velocity * self.tau,
        }
    }

    /// Returns the displacement X at the last cut.
    pub(super) fn displacement(&self) -> f64 {
        self.displacement_of(self.tau, self.phase, self.e, self.m)
    }

    fn displacement_of(&self, tau: f64, phase: Phase, e: f64, m: f64) -> f64 {
        let force = (self.velocity * e + m + self.static_friction) * phase.direction();
        force - 2.0 * self.damping * self.velocity + self.velocity * self.scaled.force(tau)
    }

    /// Advances to the next cut, at most to `until`; returns the event if the cut is one.
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

    /// Returns whether the mass is faster than the belt.
    pub(super) fn is_over_slipping(&self) -> bool {
        self.phase == Phase::OverSlip
    }

    /// Returns a detachment at τ = 0, if the force at the start exceeds the stick limit.
    pub(super) fn first_event(&self) -> Option<Event> {
        if self.phase == Phase::Stick { None } else { self.event(EventKind::Detach) }
    }

    fn event(&self, kind: EventKind) -> Option<Event> {
        Some(Event { kind, tau: self.tau, displacement: self.displacement(), sliding_distance: self.sliding_distance })
    }

    /// Enters the next cell of the friction process at its start.
    ///
    /// Where m jumps, position and velocity of the mass are continuous, so the excess e, of either direction, jumps by
    /// −Δm/V.
    fn next_cell(&mut self) -> Result<(), VibrationError> {
        let before = self.cell;
        self.cell = CurrentCell::new(self.draw()?, before.end);
        self.m = self.cell.left;
        if self.m != before.right {
            self.e -= (self.m - before.right) / self.velocity;
        }
        Ok(())
    }

    /// Returns the excess over the stick limit of the other direction.
    fn opposite_excess(&self) -> f64 {
        -self.e - 2.0 * (self.static_friction + self.m) / self.velocity
    }

    /// Returns the phase of a mass at W = 0, given e of the forward direction.
    fn phase_at_rest(&self) -> Result<Phase, VibrationError> {
        let coefficient = self.static_friction + self.m;
        if coefficient <= 0.0 {
            let (tau, sliding_distance) = (self.tau, self.sliding_distance);
            return Err(VibrationError::FrictionNotPositive {
                coefficient,
                fluctuation: self.m,
                tau,
                sliding_distance,
            });
        }
        Ok(if self.e > 0.0 {
            Phase::Slip
        } else if self.opposite_excess() > 0.0 {
            Phase::OverSlip
        } else {
            Phase::Stick
        })
    }
}

/// Returns dm/dτ divided by V for a process that depends on time. A process that depends on sliding distance enters
/// through κ instead.
fn drift_rate(drive: Drive, slope: f64) -> f64 {
    match drive {
        Drive::Distance => 0.0,
        Drive::Time => slope,
    }
}

#[cfg(test)]
mod tests;
