//! Friction in proportion to the load: F = μN.

use crate::law::FrictionLaw;
use crate::window::WindowContact;

/// A constant coefficient of friction: what is left when the contact does not matter. It does not vary along the strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coulomb {
    /// μ.
    pub coefficient: f64,
}

impl FrictionLaw for Coulomb {
    fn force_n(&self, window: &WindowContact) -> Option<f64> {
        window.loaded().then_some(self.coefficient * window.load_n)
    }
}
