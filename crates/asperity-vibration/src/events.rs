//! Events, and what happens between them.

use serde::{Deserialize, Serialize};

/// What the mass does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// It moves with the belt.
    Stick,
    /// It is slower than the belt, ẋ < v_b.
    Slip,
    /// It is faster than the belt, ẋ > v_b.
    OverSlip,
}

impl Phase {
    /// Sign of v_b − ẋ, +1 in stick.
    pub(super) fn direction(self) -> f64 {
        if self == Self::OverSlip { -1.0 } else { 1.0 }
    }
}

/// What happens at v_rel = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum EventKind {
    /// D: the mass leaves the belt.
    #[serde(rename = "D")]
    Detach,
    /// R: the mass sticks again.
    #[serde(rename = "R")]
    Restick,
    /// O: the relative velocity passes zero without stick, because the force exceeds the stick limit on the other side;
    /// over-slip begins or ends.
    #[serde(rename = "O")]
    Reverse,
}

impl EventKind {
    /// One letter: D, R or O.
    pub fn code(self) -> &'static str {
        match self {
            Self::Detach => "D",
            Self::Restick => "R",
            Self::Reverse => "O",
        }
    }
}

/// One event of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// What happened.
    pub kind: EventKind,
    /// When, τ.
    pub tau: f64,
    /// Displacement X.
    pub displacement: f64,
    /// Sliding distance s = ∫|v_rel|dτ since the start.
    pub sliding_distance: f64,
}

impl Event {
    /// (letter, τ, X, s), a row of a table.
    pub fn row(&self) -> (&'static str, f64, f64, f64) {
        (self.kind.code(), self.tau, self.displacement, self.sliding_distance)
    }
}

/// What the friction process is a function of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Drive {
    /// The sliding distance s = ∫|v_rel|dτ: friction is frozen while the mass sticks.
    #[default]
    Distance,
    /// The belt's travel v_b·t, stick or slip, as the paper has it.
    Time,
}
