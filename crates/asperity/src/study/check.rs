//! Conversion of a study file to a checked study: checks of values that their types do not exclude.

mod counterface;
mod friction;
mod invalid_value;
mod keys_without_effect;
mod mode_coupling;
mod pressure;
mod surface;
mod verdict;
mod vibration;
mod vibration_study;

use self::invalid_value::within;
use crate::study::file::StudyFile;
use crate::surface::model::SurfaceRequest;
pub(super) use counterface::CounterfaceStudy;
pub(super) use friction::{FrictionStudy, UncertaintyStudy};
pub use invalid_value::InvalidValue;
pub(super) use pressure::PressureStudy;
pub(super) use verdict::{RemedyStudy, VerdictStudy};
pub(super) use vibration_study::{FrictionSource, VibrationStudy};

/// Study with checked values, made from a [`StudyFile`].
#[derive(Debug, Clone)]
pub struct Study {
    file: StudyFile,
    pub(super) surface: Option<SurfaceRequest>,
    pub(super) counterface: Option<CounterfaceStudy>,
    pub(super) pressure: Option<PressureStudy>,
    pub(super) friction: Option<FrictionStudy>,
    pub(super) vibration: Option<VibrationStudy>,
    pub(super) verdict: Option<VerdictStudy>,
}

impl Study {
    /// Returns the study as a file, with all default values filled in.
    pub fn file(&self) -> &StudyFile {
        &self.file
    }

    /// Returns the seed of every random draw.
    pub fn seed(&self) -> u64 {
        self.file.seed
    }

    /// Returns the same study with another seed.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.file.seed = seed;
        self
    }
}

impl StudyFile {
    /// Checks the values and returns the study.
    ///
    /// # Errors
    /// A value is out of range, a required value is missing, or two values exclude each other.
    pub fn check(mut self) -> Result<Study, InvalidValue> {
        within(
            "",
            "valid_share",
            self.valid_share,
            |fraction| fraction > 0.0 && fraction <= 1.0,
            "a share above 0, at most 1",
        )?;
        let surface = self.check_surface()?;
        let counterface = self.check_counterface()?;
        let material = self.check_material()?;
        let pressure = self.check_pressure(material.as_ref())?;
        // The study of a run folder also states the default values.
        if let Some(friction) = self.friction.as_mut().filter(|f| !f.percentiles().is_empty()) {
            friction.percentiles = Some(friction.percentiles().to_vec());
        }
        let mut friction = self.check_friction(material.as_ref())?;
        let vibration = self.check_vibration()?;
        let body = self.check_body(vibration.as_ref())?;
        if let (Some(surface), Some(study)) = (&mut self.surface, &mut friction) {
            (surface.body, study.body) = (Some(body), body);
        }
        if let (Some(section), Some(study)) = (&mut self.vibration, &vibration) {
            section.stribeck = study.stribeck;
            if let Some(coupled) = study.coupled {
                section.spring_angles = Some(coupled.angles_deg);
                section.springs = Some(coupled.springs);
                section.contact_spring = Some(coupled.contact_spring);
            }
        }
        let verdict = self.check_verdict()?;
        Ok(Study { file: self, surface, counterface, pressure, friction, vibration, verdict })
    }
}
