//! State of the mass between two steps.

use serde::{Deserialize, Serialize};

use super::super::Model;

/// Contact of the mass with the belt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Contact {
    /// The mass moves with the belt.
    Stick,
    /// The mass is slower than the belt.
    Slip,
    /// The mass is faster than the belt.
    OverSlip,
    /// The mass has left the belt.
    Flight,
}

impl Contact {
    /// Returns the sign of friction on the mass in slip, otherwise 0.
    pub(in crate::mode_coupling) fn direction(self) -> f64 {
        match self {
            Self::Slip => 1.0,
            Self::OverSlip => -1.0,
            Self::Stick | Self::Flight => 0.0,
        }
    }
}

/// Displacements and velocities of the mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// x, along the belt.
    pub tangential: f64,
    /// x′.
    pub tangential_velocity: f64,
    /// y, into the belt.
    pub normal: f64,
    /// y′.
    pub normal_velocity: f64,
}

/// State between two steps.
#[derive(Debug, Clone, Copy)]
pub(in crate::mode_coupling) struct Now {
    pub(in crate::mode_coupling) tau: f64,
    pub(in crate::mode_coupling) x: f64,
    pub(in crate::mode_coupling) u: f64,
    pub(in crate::mode_coupling) y: f64,
    pub(in crate::mode_coupling) v: f64,
    pub(in crate::mode_coupling) contact: Contact,
    /// Fluctuation of friction.
    pub(in crate::mode_coupling) m: f64,
    pub(in crate::mode_coupling) sliding_distance: f64,
    /// Stick ended here: the holding force is exactly at the limit.
    pub(in crate::mode_coupling) released: bool,
    /// The normal force is exactly zero.
    pub(in crate::mode_coupling) touching: bool,
}

impl Now {
    /// Returns the normal force 1 + k₃y.
    pub(in crate::mode_coupling) fn normal(&self, model: &Model) -> f64 {
        if self.touching { 0.0 } else { 1.0 + model.parameters().contact_stiffness * self.y }
    }

    /// Returns |V − x′| in slip, otherwise 0.
    pub(in crate::mode_coupling) fn speed(&self, model: &Model) -> f64 {
        self.contact.direction() * (model.belt_velocity() - self.u)
    }

    pub(in crate::mode_coupling) fn state(&self) -> State {
        State { tangential: self.x, tangential_velocity: self.u, normal: self.y, normal_velocity: self.v }
    }
}
