//! Friction law of a study.

use crate::friction::law::{AdhesionPloughing, BowdenTabor, Coulomb, FrictionLaw, PressureDependent};
use crate::study::check::WindowLaw;
use crate::study::sentence;

/// Returns the law and its description.
pub(super) fn friction_law(law: WindowLaw) -> (Box<dyn FrictionLaw>, String) {
    let area = |strength_pa| {
        format!("τ_max = {} and the contact area A_c corrected for its perimeter", sentence::si(strength_pa, "Pa"))
    };
    match law {
        WindowLaw::BowdenTabor { shear_strength_pa } => {
            let words = format!("Friction is shear-dominated, μ = τ_max A_c/N with {}", area(shear_strength_pa));
            (Box::new(BowdenTabor { shear_strength_pa }), words)
        }
        WindowLaw::PressureDependent { shear_strength_pa, pressure_coefficient } => {
            let words = format!(
                "The shear strength of contacts grows with the pressure, τ = τ_max + αp, so that μ = τ_max A_c/N + α with α = \
                 {pressure_coefficient}, {}",
                area(shear_strength_pa)
            );
            (Box::new(PressureDependent { shear_strength_pa, pressure_coefficient }), words)
        }
        WindowLaw::AdhesionPloughing { shear_strength_pa } => {
            let words = format!(
                "Contacts are sheared and, where they yield, plough: μ = (τ_max A_c + ∫p|∂z/∂x| dA)/N, the integral over \
                 plastic contact, with {}",
                area(shear_strength_pa)
            );
            (Box::new(AdhesionPloughing { shear_strength_pa }), words)
        }
        WindowLaw::Coulomb { coefficient } => {
            let words = format!("Friction is Coulomb's, μ = {coefficient} whatever the contact");
            (Box::new(Coulomb { coefficient }), words)
        }
    }
}
