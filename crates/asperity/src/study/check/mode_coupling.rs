//! Checks of the machine of two coupled modes in `[vibration]`.

use super::invalid_value::{InvalidValue, invalid};
use super::vibration_study::{CoupledStudy, FrictionSource, MachineInputs, SECTION};
use crate::map::BoundaryKind;
use crate::study::StudyFile;
use crate::study::file::{ContactSpring, MachineModel, VibrationSection};
use crate::vibration::mode_coupling::CoupledParameters;

impl StudyFile {
    /// Checks the keys of the model of the machine.
    pub(super) fn check_model(&self, v: &VibrationSection) -> Result<(), InvalidValue> {
        let requires =
            |key, model: MachineModel| Err(invalid(SECTION, key, format!("this key requires model = \"{model}\"")));
        if v.model == MachineModel::StickSlip {
            return match self.unmet(SECTION, "model", v.model.name()).next() {
                Some((key, _)) => requires(key.name, MachineModel::ModeCoupling),
                None => Ok(()),
            };
        }
        let of_law = self.unmet(SECTION, "velocity_law", "").map(|(key, _)| key.name);
        let unusual = v.unusual_keys().map_err(|error| invalid(SECTION, "model", error.to_string()))?;
        if let Some(key) = unusual.into_iter().chain(of_law).next() {
            return requires(key, MachineModel::StickSlip);
        }
        let message = match (v.contact_spring, &self.friction) {
            (None | Some(ContactSpring::Stated(_)), _) => return Ok(()),
            (_, Some(friction)) if friction.boundary != BoundaryKind::Free => return Ok(()),
            (_, Some(_)) => {
                "the free boundary of [friction] has no contact stiffness; use the periodic one, or state a number"
            }
            (_, None) => {
                "\"surface\" requires a [friction] section, which computes the contact stiffness; or state a number"
            }
        };
        Err(invalid(SECTION, "contact_spring", message))
    }
}

impl VibrationSection {
    /// Returns the springs of two coupled modes; `None` for one degree of freedom.
    pub(super) fn coupled(&self) -> Option<CoupledStudy> {
        let usual = CoupledParameters::default();
        (self.model == MachineModel::ModeCoupling).then(|| CoupledStudy {
            angles_deg: self.spring_angles.unwrap_or(usual.angles_deg),
            springs: self.springs.unwrap_or(usual.springs),
            contact_spring: self.contact_spring.unwrap_or(ContactSpring::Stated(usual.contact_stiffness)),
        })
    }
}

/// Checks that the springs hold the mass with stated friction.
pub(super) fn check_springs(machine: &MachineInputs) -> Result<(), InvalidValue> {
    let friction = match &machine.friction {
        FrictionSource::Stated(friction) => friction.mean,
        FrictionSource::Computed(_) | FrictionSource::File(_) => return Ok(()),
    };
    match machine.coupled_model(friction, None) {
        Some(Err(error)) => Err(invalid(SECTION, "springs", format!("in the units of the machine, {error}"))),
        Some(Ok(_)) | None => Ok(()),
    }
}
