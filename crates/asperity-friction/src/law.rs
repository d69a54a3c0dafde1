//! Friction laws: the friction force of a window as a function of its contact.

mod adhesion_ploughing;
mod bowden_tabor;
mod coulomb;
mod pressure_dependent;

use std::fmt::Debug;

pub use adhesion_ploughing::AdhesionPloughing;
pub use bowden_tabor::BowdenTabor;
pub use coulomb::Coulomb;
pub use pressure_dependent::PressureDependent;

use crate::WindowContact;
use asperity_base::sentence;

/// A friction law of windows: the force that resists sliding, from the contact in one window.
pub trait WindowLaw: Debug + Send + Sync {
    /// Returns the friction force of a window in newton; 0 if it carries no load.
    fn force_n(&self, window: &WindowContact) -> f64;

    /// Describes the law and its parameters in a sentence without its full stop.
    fn describe(&self) -> String;

    /// Returns the friction coefficient of windows in which all contact is at the hardness, the least of the law; `None` if the
    /// friction does not depend on the contact.
    fn plastic_floor(&self, hardness_pa: f64) -> Option<f64>;

    /// Returns whether the force depends on [`WindowContact::ploughing_n`], which requires the slopes of the surface.
    fn ploughs(&self) -> bool {
        false
    }

    /// Returns the friction coefficient F/N of a window; `None` if it carries no load.
    fn coefficient(&self, window: &WindowContact) -> Option<f64> {
        window.loaded().then(|| self.force_n(window) / window.load_n)
    }
}

/// Describes a shear strength in pascal and the contact area that it acts on.
fn describe_shear(shear_strength_pa: f64) -> String {
    let strength = sentence::si(shear_strength_pa, "Pa");
    format!("τ_max = {strength} and the contact area A_c corrected at its edges")
}
