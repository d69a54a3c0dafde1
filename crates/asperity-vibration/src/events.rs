//! Phases of the motion and the events between them.

use serde::{Deserialize, Serialize};

/// Phase of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// The mass moves with the belt.
    Stick,
    /// The mass is slower than the belt, ẋ < v_b.
    Slip,
    /// The mass is faster than the belt, ẋ > v_b.
    OverSlip,
}

impl Phase {
    /// Returns the sign of v_b − ẋ, +1 in stick.
    pub(super) fn direction(self) -> f64 {
        if self == Self::OverSlip { -1.0 } else { 1.0 }
    }
}

/// Kind of an event at v_rel = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum EventKind {
    /// D: the mass leaves the belt.
    #[serde(rename = "D")]
    Detach,
    /// R: the mass sticks again.
    #[serde(rename = "R")]
    Restick,
    /// O: the relative velocity passes zero without stick, because the force exceeds the stick limit in the other
    /// direction. Over-slip starts or ends.
    #[serde(rename = "O")]
    Reverse,
}

impl EventKind {
    /// Returns the letter of the event: D, R or O.
    pub fn code(self) -> &'static str {
        match self {
            Self::Detach => "D",
            Self::Restick => "R",
            Self::Reverse => "O",
        }
    }
}

/// Event of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Kind of the event.
    pub kind: EventKind,
    /// Time τ.
    pub tau: f64,
    /// Displacement X.
    pub displacement: f64,
    /// Sliding distance s = ∫|v_rel|dτ since the start.
    pub sliding_distance: f64,
}

impl Event {
    /// Returns (letter, τ, X, s), a row of a table.
    pub fn row(&self) -> (&'static str, f64, f64, f64) {
        (self.kind.code(), self.tau, self.displacement, self.sliding_distance)
    }
}

asperity_base::choice! {
    /// Independent variable of the friction process.
    #[derive(Default)]
    pub enum Drive: "independent variable of friction" {
        /// Sliding distance s = ∫|v_rel|dτ: friction is frozen while the mass sticks.
        #[default]
        Distance = "distance",
        /// Travel of the belt v_b·t, in stick and in slip, as in the paper.
        Time = "time",
    }
}
