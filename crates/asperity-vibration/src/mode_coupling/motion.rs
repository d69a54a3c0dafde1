//! Motion along one trajectory: steps of the Taylor series that end at events.

mod series;
pub(super) mod state;

use serde::{Deserialize, Serialize};

use self::series::{Series, holding};
use self::state::{Contact, Now, State};
use super::super::VibrationError;
use super::Model;
use asperity_process::{Cell, Fluctuation};

/// Largest number of consecutive steps without progress in time.
const MAX_IDLE_STEPS: usize = 100;

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CoupledEventKind {
    /// D: stick ends.
    #[serde(rename = "D")]
    Detach,
    /// R: stick begins.
    #[serde(rename = "R")]
    Restick,
    /// O: the relative velocity passes zero without stick.
    #[serde(rename = "O")]
    Reverse,
    /// F: the mass leaves the belt.
    #[serde(rename = "F")]
    LiftOff,
    /// L: the mass lands.
    #[serde(rename = "L")]
    Landing,
}

impl CoupledEventKind {
    /// Returns the letter of the event: D, R, O, F or L.
    pub fn code(self) -> &'static str {
        match self {
            Self::Detach => "D",
            Self::Restick => "R",
            Self::Reverse => "O",
            Self::LiftOff => "F",
            Self::Landing => "L",
        }
    }
}

/// Event of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CoupledEvent {
    /// Kind of the event.
    pub kind: CoupledEventKind,
    /// Time τ.
    pub tau: f64,
    /// State of the mass.
    pub state: State,
    /// Sliding distance since the start.
    pub sliding_distance: f64,
}

/// Reason for the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cut {
    /// The requested time, a grid point of the friction process, the reach of the series, or an extreme of y.
    None,
    /// x′ passed zero while falling: maximum of x.
    Maximum,
    /// x′ passed zero while rising: minimum of x.
    Minimum,
    /// An event.
    Event(CoupledEvent),
}

/// Motion of a mass under one realisation of the friction process.
#[derive(Debug)]
pub(super) struct Motion<'a, F> {
    model: &'a Model,
    fluctuation: F,
    cell: Cell,
    /// Start of the present cell.
    began: f64,
    pub(super) now: Now,
    /// Contact during the last step, and the start time of that step.
    pub(super) passed: (Contact, f64),
    series: Series,
    idle_steps: usize,
}

impl<'a, F: Fluctuation> Motion<'a, F> {
    /// Creates a motion from the given state at τ = 0.
    pub(super) fn new(model: &'a Model, fluctuation: F, start: State) -> Result<Self, VibrationError> {
        let State { tangential: x, tangential_velocity: u, normal: y, normal_velocity: v } = start;
        for (parameter, value) in [("start x", x), ("start x'", u), ("start y", y), ("start y'", v)] {
            if !value.is_finite() {
                return Err(VibrationError::Parameter { parameter, value, wanted: "finite" });
            }
        }
        let now = Now {
            tau: 0.0,
            x,
            u,
            y,
            v,
            contact: Contact::Slip,
            m: 0.0,
            sliding_distance: 0.0,
            released: false,
            touching: false,
        };
        let cell = Cell { end: 0.0, length: f64::INFINITY, left: 0.0, right: 0.0 };
        let passed = (Contact::Slip, 0.0);
        let mut motion =
            Self { model, fluctuation, cell, began: 0.0, now, passed, series: Series::ZERO, idle_steps: 0 };
        motion.next_cell()?;
        if motion.now.normal(model) < 0.0 {
            motion.now.contact = Contact::Flight;
        } else {
            motion.determine_contact()?;
        }
        motion.passed.0 = motion.now.contact;
        Ok(motion)
    }

    /// Returns 1 + μ_s/(k₁₁V), approximately the longest stick without coupling.
    pub(super) fn stick_time(&self) -> f64 {
        1.0 + self.model.parameters().static_friction / (self.model.stiffness[0] * self.model.belt_velocity())
    }

    /// Returns the contact stiffness k₃.
    pub(super) fn contact_stiffness(&self) -> f64 {
        self.model.parameters().contact_stiffness
    }

    /// Advances to the next cut, at most to `until`.
    pub(super) fn step(&mut self, until: f64) -> Result<Cut, VibrationError> {
        let before = self.now.tau;
        self.passed = (self.now.contact, before);
        let cut = match self.now.contact {
            Contact::Slip | Contact::OverSlip => self.slip(until),
            Contact::Stick => self.stick(until),
            Contact::Flight => self.fly(until),
        }?;
        self.idle_steps = if self.now.tau > before { 0 } else { self.idle_steps + 1 };
        if self.idle_steps > MAX_IDLE_STEPS {
            return Err(VibrationError::Stalled { tau: before });
        }
        Ok(cut)
    }

    /// Returns the state at the time τ inside the last step.
    pub(super) fn sample(&self, tau: f64) -> State {
        let [x, u, y, v] = self.series.state(tau - self.passed.1);
        State { tangential: x, tangential_velocity: u, normal: y, normal_velocity: v }
    }

    /// Returns the sliding distance since the start of the last step at the time τ inside it.
    #[cfg(test)]
    pub(super) fn distance_at(&self, tau: f64) -> f64 {
        self.series.distance(tau - self.passed.1)
    }

    fn expand(&mut self, until: f64, horizon: f64) -> f64 {
        self.series.expand(self.model, &self.now, self.slope(), horizon);
        self.series.reach(horizon.min(until - self.now.tau))
    }

    /// Advances in slip to the first of: arrival or lift-off, extreme, grid point. Grid points come last, because after
    /// an arrival the distance runs backwards.
    fn slip(&mut self, until: f64) -> Result<Cut, VibrationError> {
        let to_grid_point = self.cell.end - self.now.sliding_distance;
        let speed = self.now.speed(self.model);
        // Slightly longer, so that the grid point is inside the step.
        let estimate =
            if to_grid_point.is_finite() && speed > 0.0 { 1.2 * to_grid_point / speed } else { f64::INFINITY };
        let mut h = self.expand(until, estimate.min(until - self.now.tau));
        let mut kind = None;
        if let Some(t) = self.series.arrival(h) {
            (h, kind) = (t, Some(CoupledEventKind::Restick));
        }
        if let Some(t) = self.series.contact_change(1.0, h) {
            (h, kind) = (t, Some(CoupledEventKind::LiftOff));
        }
        let turn = self.turn(&mut h, &mut kind);
        let crossed = to_grid_point.is_finite() && self.series.distance(h) >= to_grid_point;
        if crossed {
            h = self.series.time_of_distance(to_grid_point.max(0.0), h);
            kind = None;
        }
        if let Some(t) = self.series.friction_end(h) {
            let (tau, sliding_distance) = (self.now.tau + t, self.now.sliding_distance + self.series.distance(t));
            return Err(VibrationError::FrictionNotPositive {
                coefficient: 0.0,
                fluctuation: self.now.m,
                tau,
                sliding_distance,
            });
        }
        let distance = self.now.sliding_distance + self.series.distance(h);
        self.advance(h, until);
        if crossed {
            self.now.sliding_distance = self.cell.end;
            self.next_cell()?;
            return Ok(Cut::None);
        }
        self.now.sliding_distance = distance;
        self.now.m = self.cell.left + self.slope() * (distance - self.began);
        match kind {
            None => Ok(self.at_turn(turn)),
            Some(CoupledEventKind::LiftOff) => Ok(self.lift_off()),
            Some(_) => {
                self.now.u = self.model.belt_velocity();
                self.determine_contact()?;
                let kind = if self.now.contact == Contact::Stick {
                    CoupledEventKind::Restick
                } else {
                    CoupledEventKind::Reverse
                };
                Ok(self.event(kind))
            }
        }
    }

    fn stick(&mut self, until: f64) -> Result<Cut, VibrationError> {
        let mut h = self.expand(until, until - self.now.tau);
        let friction = self.model.parameters().static_friction + self.now.m;
        let mut kind = None;
        let mut released = Contact::Slip;
        // The force that would hold the mass back is at its limit: the mass becomes slower than the belt.
        for (contact, direction) in [(Contact::Slip, 1.0), (Contact::OverSlip, -1.0)] {
            if let Some(t) = self.series.release(friction, direction, h) {
                (h, kind, released) = (t, Some(CoupledEventKind::Detach), contact);
            }
        }
        if let Some(t) = self.series.contact_change(1.0, h).filter(|t| kind.is_none() || *t < h) {
            (h, kind) = (t, Some(CoupledEventKind::LiftOff));
        }
        if let Some(t) = self.series.normal_turn(h).filter(|t| *t < h) {
            (h, kind) = (t, None);
            self.advance(h, until);
            self.now.v = 0.0;
        } else {
            self.advance(h, until);
        }
        self.now.u = self.model.belt_velocity();
        match kind {
            None => Ok(Cut::None),
            Some(CoupledEventKind::LiftOff) => Ok(self.lift_off()),
            Some(kind) => {
                (self.now.contact, self.now.released) = (released, true);
                Ok(self.event(kind))
            }
        }
    }

    fn fly(&mut self, until: f64) -> Result<Cut, VibrationError> {
        let mut h = self.expand(until, until - self.now.tau);
        let mut kind = None;
        if let Some(t) = self.series.contact_change(-1.0, h) {
            (h, kind) = (t, Some(CoupledEventKind::Landing));
        }
        let turn = self.turn(&mut h, &mut kind);
        self.advance(h, until);
        if kind.is_none() {
            return Ok(self.at_turn(turn));
        }
        self.now.touching = true;
        self.determine_contact()?;
        Ok(self.event(CoupledEventKind::Landing))
    }

    /// Shortens a step to the first sign change of x′ or y′, if it precedes the other events.
    fn turn(&self, h: &mut f64, kind: &mut Option<CoupledEventKind>) -> Turn {
        let mut turn = Turn::None;
        if let Some(t) = self.series.tangential_turn(*h).filter(|t| *t < *h) {
            (*h, *kind, turn) = (t, None, Turn::Tangential);
        }
        if let Some(t) = self.series.normal_turn(*h).filter(|t| *t < *h) {
            (*h, *kind, turn) = (t, None, Turn::Normal);
        }
        turn
    }

    /// Sets the velocity that changed its sign to exactly zero.
    fn at_turn(&mut self, turn: Turn) -> Cut {
        match turn {
            Turn::None => {}
            Turn::Normal => self.now.v = 0.0,
            Turn::Tangential => {
                // x′ falls through zero if it was positive half-way.
                let rising = self.sample(0.5 * (self.passed.1 + self.now.tau)).tangential_velocity < 0.0;
                self.now.u = 0.0;
                return if rising { Cut::Minimum } else { Cut::Maximum };
            }
        }
        Cut::None
    }

    /// Advances by the time h.
    fn advance(&mut self, h: f64, until: f64) {
        let [x, u, y, v] = self.series.state(h);
        let now = &mut self.now;
        now.tau = if h == until - now.tau { until } else { now.tau + h };
        (now.x, now.u, now.y, now.v) = (x, u, y, v);
        if h > 0.0 {
            (now.released, now.touching) = (false, false);
        }
    }

    fn lift_off(&mut self) -> Cut {
        self.now.contact = Contact::Flight;
        self.now.touching = true;
        self.event(CoupledEventKind::LiftOff)
    }

    /// Determines the contact of a mass on the belt from its velocity, and at the velocity of the belt from the force
    /// that stick requires.
    fn determine_contact(&mut self) -> Result<(), VibrationError> {
        let Now { x, u, y, v, m, tau, sliding_distance, .. } = self.now;
        let ahead = self.model.belt_velocity() - u;
        let coefficient = self.model.parameters().static_friction + m;
        if coefficient <= 0.0 {
            return Err(VibrationError::FrictionNotPositive { coefficient, fluctuation: m, tau, sliding_distance });
        }
        let (force, limit) = (holding(self.model, [x, u, y, v]), coefficient * self.now.normal(self.model));
        self.now.contact = if ahead > 0.0 {
            Contact::Slip
        } else if ahead < 0.0 {
            Contact::OverSlip
        } else if force > limit {
            Contact::Slip
        } else if force < -limit {
            Contact::OverSlip
        } else {
            Contact::Stick
        };
        Ok(())
    }

    /// Enters the next cell of the friction process.
    fn next_cell(&mut self) -> Result<(), VibrationError> {
        let exhausted = VibrationError::ProcessTooShort { tau: self.now.tau, coordinate: self.now.sliding_distance };
        (self.began, self.cell) = (self.cell.end, self.fluctuation.next_cell().ok_or(exhausted)?);
        self.now.m = self.cell.left;
        Ok(())
    }

    /// Returns dm/ds in this cell.
    fn slope(&self) -> f64 {
        if self.cell.length.is_finite() { self.cell.slope() } else { 0.0 }
    }

    fn event(&self, kind: CoupledEventKind) -> Cut {
        let Now { tau, sliding_distance, .. } = self.now;
        Cut::Event(CoupledEvent { kind, tau, state: self.now.state(), sliding_distance })
    }
}

/// Velocity that changes its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Turn {
    None,
    Tangential,
    Normal,
}
