//! Friction laws: the friction force of a window as a function of its contact.

mod adhesion_ploughing;
mod bowden_tabor;
mod coulomb;
mod pressure_dependent;

use std::fmt::Debug;
use std::sync::Arc;

pub use adhesion_ploughing::AdhesionPloughing;
pub use bowden_tabor::BowdenTabor;
pub use coulomb::Coulomb;
pub use pressure_dependent::PressureDependent;

use crate::WindowContact;
use asperity_base::statement::{Stated, Statement, StatementError};
use asperity_base::{choice, sentence};

choice! {
    /// Friction law.
    #[derive(Default)]
    pub enum WindowLawKind: "friction law" {
        /// F = τ_max A_c (the paper's law).
        #[default]
        BowdenTabor = "bowden_tabor",
        /// F = τ_max A_c + αN.
        PressureDependent = "pressure_dependent",
        /// F = τ_max A_c plus the ploughing force of plastic contacts.
        AdhesionPloughing = "adhesion_ploughing",
        /// F = μN.
        Coulomb = "coulomb",
    }
}

impl WindowLawKind {
    /// Returns whether the law depends on the shear strength of the contacts.
    #[doc(hidden)]
    pub fn is_sheared(self) -> bool {
        self.statement().inputs.contains(&SHEAR_STRENGTH)
    }

    /// Returns how a study states it, in SI.
    #[doc(hidden)]
    pub fn statement(self) -> &'static Statement<Arc<dyn WindowLaw>> {
        match self {
            Self::BowdenTabor => BowdenTabor::STATEMENT,
            Self::PressureDependent => PressureDependent::STATEMENT,
            Self::AdhesionPloughing => AdhesionPloughing::STATEMENT,
            Self::Coulomb => Coulomb::STATEMENT,
        }
    }
}

/// Shear strength of the contacts, an input of several laws.
const SHEAR_STRENGTH: &str = "material.shear_strength";

fn shear_strength_pa(stated: &dyn Stated) -> Result<f64, StatementError> {
    required(stated, SHEAR_STRENGTH, "[friction] needs the shear strength of the contacts")
}

fn required(stated: &dyn Stated, input: &'static str, reason: &str) -> Result<f64, StatementError> {
    stated.number(input).ok_or_else(|| StatementError { input, reason: reason.into() })
}

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

    /// Returns the input, `section.key`, to which the force of every window is proportional, if there is one.
    fn proportional_to(&self) -> Option<&'static str> {
        None
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
