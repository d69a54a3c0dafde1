//! Friction proportional to the load: F = μN.

use crate::law::FrictionLaw;
use crate::window::WindowContact;

/// A constant friction coefficient, independent of the contact. It does not vary along the strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coulomb {
    /// Friction coefficient μ.
    pub coefficient: f64,
}

impl FrictionLaw for Coulomb {
    fn force_n(&self, window: &WindowContact) -> Option<f64> {
        window.loaded().then_some(self.coefficient * window.load_n)
    }
}
