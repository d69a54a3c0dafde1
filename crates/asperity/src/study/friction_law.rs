//! The friction law of a study.

use crate::friction::law::{AdhesionPloughing, BowdenTabor, Coulomb, FrictionLaw, PressureDependent};
use crate::study::StudyError;
use crate::study::file::{FrictionLawKind, FrictionSection, MaterialSection};
use crate::study::sentence;

/// The law that a section chooses, and the same in words.
pub(super) fn friction_law(
    section: &FrictionSection,
    material: &MaterialSection,
) -> Result<(Box<dyn FrictionLaw>, String), StudyError> {
    let shear = || material.shear_strength.map(|strength| strength.0).ok_or(StudyError::NoStage("material"));
    let area = |strength_pa| {
        format!("τ_max = {} and the contact area A_c corrected for its perimeter", sentence::si(strength_pa, "Pa"))
    };
    Ok(match section.law {
        FrictionLawKind::BowdenTabor => {
            let shear_strength_pa = shear()?;
            let words = format!("Friction is shear-dominated, μ = τ_max A_c/N with {}", area(shear_strength_pa));
            (Box::new(BowdenTabor { shear_strength_pa }), words)
        }
        FrictionLawKind::PressureDependent => {
            let (shear_strength_pa, pressure_coefficient) = (shear()?, section.pressure_coefficient.unwrap_or(0.0));
            let words = format!(
                "The shear strength of contacts grows with the pressure, τ = τ_max + αp, so that μ = τ_max A_c/N + α with α = \
                 {pressure_coefficient}, {}",
                area(shear_strength_pa)
            );
            (Box::new(PressureDependent { shear_strength_pa, pressure_coefficient }), words)
        }
        FrictionLawKind::AdhesionPloughing => {
            let shear_strength_pa = shear()?;
            let words = format!(
                "Contacts are sheared and, where they yield, plough: μ = (τ_max A_c + ∫p|∂z/∂x| dA)/N, the integral over \
                 plastic contact, with {}",
                area(shear_strength_pa)
            );
            (Box::new(AdhesionPloughing { shear_strength_pa }), words)
        }
        FrictionLawKind::Coulomb => {
            let coefficient = section.coefficient.ok_or(StudyError::NoStage("friction"))?;
            let words = format!("Friction is Coulomb's, μ = {coefficient} whatever the contact");
            (Box::new(Coulomb { coefficient }), words)
        }
    })
}
