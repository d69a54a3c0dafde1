//! From what a window sees to the friction force on it.

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

/// A law of friction: the force that resists sliding, from the contact in one window.
pub trait FrictionLaw: Debug + Sync {
    /// Friction force of a window in newton; `None` where it carries no load.
    fn force_n(&self, window: &WindowContact) -> Option<f64>;

    /// Whether the force depends on [`WindowContact::ploughing_n`], for which the slopes of the surface are needed.
    fn ploughs(&self) -> bool {
        false
    }

    /// Friction coefficient F/N of a window; `None` where it carries no load.
    fn coefficient(&self, window: &WindowContact) -> Option<f64> {
        self.force_n(window).map(|force_n| force_n / window.load_n)
    }
}
