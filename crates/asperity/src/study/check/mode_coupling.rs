//! Checks of the machine of two coupled modes in `[vibration]`.

use super::invalid_value::{InvalidValue, invalid};
use super::vibration_study::{CoupledStudy, FrictionSource, SECTION, VibrationStudy};
use crate::map::BoundaryKind;
use crate::study::StudyFile;
use crate::study::file::{ContactSpring, MachineModel, VibrationSection};
use crate::vibration::mode_coupling::CoupledParameters;

impl StudyFile {
    /// Checks the keys of the model of the machine, and returns its springs; `None` for one degree of freedom.
    pub(super) fn check_coupled(&self, v: &VibrationSection) -> Result<Option<CoupledStudy>, InvalidValue> {
        let requires =
            |key, model: MachineModel| Err(invalid(SECTION, key, format!("this key requires model = \"{model}\"")));
        if v.model == MachineModel::StickSlip {
            return match self.unmet(SECTION, "model", v.model.name()).next() {
                Some((key, _)) => requires(key.name, MachineModel::ModeCoupling),
                None => Ok(None),
            };
        }
        let of_law = self.unmet(SECTION, "velocity_law", "").map(|(key, _)| key.name);
        let unusual = v.unusual_keys().map_err(|error| invalid(SECTION, "model", error.to_string()))?;
        if let Some(key) = unusual.into_iter().chain(of_law).next() {
            return requires(key, MachineModel::StickSlip);
        }
        let usual = CoupledParameters::default();
        let springs = v.springs.unwrap_or(usual.springs);
        let angles_deg = v.spring_angles.unwrap_or(usual.angles_deg);
        let contact_spring = v.contact_spring.unwrap_or(ContactSpring::Stated(usual.contact_stiffness));
        match (contact_spring, &self.friction) {
            (ContactSpring::Stated(_), _) => {}
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
