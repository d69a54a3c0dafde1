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

use crate::window::WindowContact;

/// A friction law: the force that resists sliding, from the contact in one window.
pub trait FrictionLaw: Debug + Sync {
    /// Returns the friction force of a window in newton; `None` if it carries no load.
    fn force_n(&self, window: &WindowContact) -> Option<f64>;

    /// Returns whether the force depends on [`WindowContact::ploughing_n`], which requires the slopes of the surface.
    fn ploughs(&self) -> bool {
        false
    }

    /// Returns the friction coefficient F/N of a window; `None` if it carries no load.
    fn coefficient(&self, window: &WindowContact) -> Option<f64> {
        self.force_n(window).map(|force_n| force_n / window.load_n)
    }
}
