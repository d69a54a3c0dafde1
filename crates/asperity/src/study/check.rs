//! Conversion of a study file to a checked study: checks of values that their types do not exclude.

mod counterface;
mod friction;
mod keys_without_effect;
mod mode_coupling;
mod pressure;
mod surface;
mod verdict;
mod vibration;

use std::fmt::Display;

use thiserror::Error;

use crate::study::file::StudyFile;
use crate::surface::model::SurfaceRequest;
pub(super) use counterface::CounterfaceStudy;
pub(super) use friction::{FrictionStudy, UncertaintyStudy};
pub(super) use pressure::PressureStudy;
pub(super) use verdict::{RemedyStudy, VerdictStudy};
pub(super) use vibration::{FrictionSource, VibrationStudy};

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

/// Error of a well-formed value that is invalid.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{}{key}: {message}", prefix(section))]
pub struct InvalidValue {
    /// Section of the value, such as `friction.uncertainty`; empty above the sections.
    pub section: &'static str,
    /// Key of the value.
    pub key: &'static str,
    message: String,
}

fn prefix(section: &str) -> String {
    if section.is_empty() { String::new() } else { format!("[{section}] ") }
}

fn invalid(section: &'static str, key: &'static str, message: impl Into<String>) -> InvalidValue {
    InvalidValue { section, key, message: message.into() }
}

/// Fails unless `value`, a number or a quantity in SI, lies in the stated range.
fn within<T: Copy + Display + Into<f64>>(
    section: &'static str,
    key: &'static str,
    value: T,
    fits: impl Fn(f64) -> bool,
    expected: &str,
) -> Result<(), InvalidValue> {
    if value.into().is_finite() && fits(value.into()) {
        Ok(())
    } else {
        Err(invalid(section, key, format!("found {value}, expected {expected}")))
    }
}

fn at_least(section: &'static str, key: &'static str, value: usize, least: usize) -> Result<(), InvalidValue> {
    within(section, key, value as f64, |value| value >= least as f64, &format!("at least {least}"))
}

/// Fails if a value of a list occurs twice.
fn once<T: PartialEq + Display>(section: &'static str, key: &'static str, values: &[T]) -> Result<(), InvalidValue> {
    let repeated = values.iter().enumerate().find(|(index, value)| values[..*index].contains(value));
    repeated.map_or(Ok(()), |(_, value)| Err(invalid(section, key, format!("found {value} twice"))))
}

const POSITIVE: &str = "a positive value";
const PERCENT: &str = "a percentage strictly between 0 and 100";

fn positive(value: f64) -> bool {
    value > 0.0
}

impl StudyFile {
    /// Checks the values and returns the study.
    ///
    /// # Errors
    /// A value is out of range, a required value is missing, or two values exclude each other.
    pub fn check(mut self) -> Result<Study, InvalidValue> {
        within("", "valid_share", self.valid_share, |share| share > 0.0 && share <= 1.0, "a share above 0, at most 1")?;
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
