//! Checks of the machine of two coupled modes in `[vibration]`.

use super::vibration::SECTION;
use super::{FrictionSource, InvalidValue, POSITIVE, VibrationStudy, invalid, positive, within};
use crate::map::BoundaryKind;
use crate::study::StudyFile;
use crate::study::file::{ContactSpring, MachineModel, VibrationSection};
use crate::vibration::mode_coupling::{CoupledParameters, Damping, Model};
use crate::vibration::{VelocityLaw, VibrationError};

/// Springs of two coupled modes, in units of mω₀².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::study) struct CoupledStudy {
    pub(in crate::study) angles_deg: [f64; 2],
    pub(in crate::study) springs: [f64; 2],
    pub(in crate::study) contact_spring: ContactSpring,
}

impl VibrationStudy {
    /// Returns the model of two coupled modes with this friction coefficient and this stiffness of the rough contact over its area
    /// in Pa/m; `None` for a machine with one degree of freedom.
    ///
    /// # Errors
    /// The springs do not hold the mass, a value is out of range, or the stiffness of the contact is not known.
    pub(in crate::study) fn coupled_model(
        &self,
        friction: f64,
        stiffness_pa_per_m: Option<f64>,
    ) -> Option<Result<Model, VibrationError>> {
        let CoupledStudy { angles_deg, springs, contact_spring } = self.coupled?;
        let contact_stiffness = match (contact_spring, stiffness_pa_per_m) {
            (ContactSpring::Stated(stiffness), _) => stiffness,
            (ContactSpring::Surface, Some(pa_per_m)) => {
                pa_per_m * self.nominal_area.0 / self.scales.stiffness_n_per_m()
            }
            (ContactSpring::Surface, None) => {
                let reason = "the strips of the operating level have no contact stiffness";
                return Some(Err(VibrationError::NotFound { what: "contact spring of the surface", reason }));
            }
        };
        let damper = 2.0 * self.damping_ratio;
        Some(Model::new(CoupledParameters {
            angles_deg,
            springs,
            contact_stiffness,
            damping: Damping::Axes { tangential: damper, normal: damper },
            static_friction: friction,
            law: VelocityLaw::Coulomb { kinetic: friction },
            belt_velocity: self.belt_velocity,
        }))
    }
}

impl StudyFile {
    /// Checks the keys of the model of the machine, and returns its springs; `None` for one degree of freedom.
    pub(super) fn check_coupled(&self, v: &VibrationSection) -> Result<Option<CoupledStudy>, InvalidValue> {
        let own = [
            ("spring_angles", v.spring_angles.is_some()),
            ("springs", v.springs.is_some()),
            ("contact_spring", v.contact_spring.is_some()),
        ];
        let requires =
            |key, model: MachineModel| Err(invalid(SECTION, key, format!("this key requires model = \"{model}\"")));
        if v.model == MachineModel::StickSlip {
            return match own.into_iter().find(|(_, stated)| *stated) {
                Some((key, _)) => requires(key, MachineModel::ModeCoupling),
                None => Ok(None),
            };
        }
        if let Some((key, _)) = v.usual_keys().into_iter().find(|(_, usual)| !usual) {
            return requires(key, MachineModel::StickSlip);
        }
        let usual = CoupledParameters::default();
        let springs = v.springs.unwrap_or(usual.springs);
        for spring in springs {
            within(SECTION, "springs", spring, |k| k >= 0.0, "zero or positive values")?;
        }
        let angles_deg = v.spring_angles.unwrap_or(usual.angles_deg);
        for angle in angles_deg {
            within(SECTION, "spring_angles", angle, |_| true, "angles in degrees")?;
        }
        let contact_spring = v.contact_spring.unwrap_or(ContactSpring::Stated(usual.contact_stiffness));
        match (contact_spring, &self.friction) {
            (ContactSpring::Stated(stiffness), _) => within(SECTION, "contact_spring", stiffness, positive, POSITIVE)?,
            (ContactSpring::Surface, Some(friction)) if friction.boundary != BoundaryKind::Free => {}
            (ContactSpring::Surface, Some(_)) => {
                let message =
                    "the free boundary of [friction] has no contact stiffness; use the periodic one, or state a number";
                return Err(invalid(SECTION, "contact_spring", message));
            }
            (ContactSpring::Surface, None) => {
                let message = "\"surface\" requires a [friction] section, which computes the contact stiffness; or state a number";
                return Err(invalid(SECTION, "contact_spring", message));
            }
        }
        Ok(Some(CoupledStudy { angles_deg, springs, contact_spring }))
    }
}

/// Checks that the springs hold the mass with stated friction.
pub(super) fn check_springs(study: &VibrationStudy) -> Result<(), InvalidValue> {
    let friction = match &study.friction {
        FrictionSource::Stated(friction) => friction.mean,
        FrictionSource::Computed(_) | FrictionSource::File(_) => return Ok(()),
    };
    match study.coupled_model(friction, None) {
        Some(Err(error)) => Err(invalid(SECTION, "springs", format!("in the units of the machine, {error}"))),
        Some(Ok(_)) | None => Ok(()),
    }
}
