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
pub(super) use friction::{FrictionStudy, UncertaintyStudy};
pub use invalid_value::InvalidValue;
pub(super) use pressure::PressureStudy;
pub(super) use surface::SurfaceStudy;
pub(super) use verdict::{RemedyStudy, VerdictStudy};
pub(super) use vibration_study::{FrictionSource, VibrationStudy};

/// Study with checked values, made from a [`StudyFile`].
#[derive(Debug, Clone)]
pub struct Study {
    file: StudyFile,
    pub(super) surface: Option<SurfaceStudy>,
    /// Surface of a rough counterface.
    pub(super) counterface: Option<SurfaceStudy>,
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
    pub fn check(self) -> Result<Study, InvalidValue> {
        within(
            "",
            "valid_share",
            self.valid_share,
            |fraction| fraction > 0.0 && fraction <= 1.0,
            "a fraction above 0, at most 1",
        )?;
        let surface = self.check_surface()?;
        let counterface = self.check_counterface()?;
        let material = self.check_material()?;
        let pressure = self.check_pressure(material.as_ref())?;
        let friction = self.check_friction(material.as_ref())?;
        let vibration = self.check_vibration()?;
        let body = self.check_body(friction.as_ref(), vibration.as_ref())?;
        let friction = friction.map(|friction| FrictionStudy { body, ..friction });
        let file = self.with_defaults(friction.as_ref(), vibration.as_ref());
        let verdict = file.check_verdict()?;
        Ok(Study { file, surface, counterface, pressure, friction, vibration, verdict })
    }

    /// Returns the file with the default values that other keys determine; the study of a run folder states them.
    fn with_defaults(mut self, friction: Option<&FrictionStudy>, vibration: Option<&VibrationStudy>) -> Self {
        if let Some(section) = &mut self.friction {
            section.fill_in_sizes(None);
            if !section.percentiles().is_empty() {
                section.percentiles = Some(section.percentiles().to_vec());
            }
        }
        if let (Some(section), Some(study)) = (&mut self.surface, friction) {
            section.body = Some(study.body);
        }
        if let (Some(section), Some(study)) = (&mut self.vibration, vibration) {
            section.stribeck = study.stribeck;
            if let Some(coupled) = study.coupled {
                section.spring_angles = Some(coupled.angles_deg);
                section.springs = Some(coupled.springs);
                section.contact_spring = Some(coupled.contact_spring);
            }
        }
        self
    }
}
