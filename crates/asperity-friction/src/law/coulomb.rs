//! Friction proportional to the load: F = μN.

use crate::WindowContact;
use crate::law::WindowLaw;

/// A constant friction coefficient, independent of the contact. It does not vary along the strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coulomb {
    /// Friction coefficient μ.
    pub coefficient: f64,
}

impl WindowLaw for Coulomb {
    fn force_n(&self, window: &WindowContact) -> f64 {
        self.coefficient * window.load_n
    }

    fn describe(&self) -> String {
        format!("Friction is Coulomb's, μ = {} whatever the contact", self.coefficient)
    }

    fn plastic_floor(&self, _hardness_pa: f64) -> Option<f64> {
        None
    }
}
