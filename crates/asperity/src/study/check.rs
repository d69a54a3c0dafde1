//! Conversion of a study file to a checked study: checks of values that their types do not exclude.

mod counterface;
mod friction;
mod invalid_value;
mod keys_without_effect;
mod mode_coupling;
mod pressure;
mod stated_law;
mod surface;
mod verdict;
mod vibration;
mod vibration_study;

use asperity_results::keys::Key;

use self::invalid_value::{invalid, within};
use crate::quantity::Dimension;
use crate::study::file::StudyFile;
use crate::study::uncertain::{needs, numbers};
pub(super) use friction::{FrictionStudy, UncertaintyStudy};
pub use invalid_value::InvalidValue;
pub(super) use pressure::PressureStudy;
pub(super) use surface::SurfaceStudy;
pub(super) use verdict::{LARGEST_CHANGE, RemedyStudy, VerdictStudy};
pub(super) use vibration_study::{FrictionSource, MachineInputs, VibrationStudy};

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

/// Returns whether a study may have this name, the one of the folder of its run.
pub fn is_folder_name(name: &str) -> bool {
    !name.trim_matches(['.', ' ']).is_empty() && !name.contains(['/', '\\', '\0'])
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
        if let Some(name) = self.name.as_deref().filter(|name| !is_folder_name(name)) {
            return Err(invalid("", "name", format!("found {name:?}, expected the name of a folder, without `/`")));
        }
        self.check_numbers()?;
        let surface = self.check_surface()?;
        let counterface = self.check_counterface()?;
        let material = self.check_material()?;
        let pressure = self.check_pressure(material.as_ref())?;
        let friction = self.check_friction(material.as_ref())?;
        let vibration = self.check_vibration()?;
        let body = self.check_body(friction.as_ref(), vibration.as_ref())?;
        let friction = friction.map(|friction| FrictionStudy { body, ..friction });
        let file = self.with_defaults(friction.as_ref(), vibration.as_ref());
        let verdict = file.check_verdict(friction.as_ref(), vibration.as_ref())?;
        Ok(Study { file, surface, counterface, pressure, friction, vibration, verdict })
    }

    /// Checks the numbers and quantities that may be uncertain.
    fn check_numbers(&self) -> Result<(), InvalidValue> {
        for (key, access) in numbers() {
            let Some(bounds) = key.bounds else { continue };
            for number in [None, Some(0), Some(1)].into_iter().filter_map(|element| access.get(self, key, element)) {
                if !bounds.contain(number) {
                    let found = Dimension::of_unit(key.unit).map_or(number.to_string(), |unit| unit.show(number));
                    let message = format!("found {found}, expected {}", bounds.expected);
                    return Err(invalid(key.section, key.name, message));
                }
            }
        }
        Ok(())
    }

    /// Returns the stated inputs that need another value of the word `name` of their section than `word`, with one that they need.
    fn unmet<'a>(
        &'a self,
        section: &'a str,
        name: &'a str,
        word: &'a str,
    ) -> impl Iterator<Item = (&'static Key, &'static str)> + 'a {
        let stated = numbers().filter(move |(key, access)| key.section == section && access.is_stated(self));
        stated.filter_map(move |(key, _)| {
            let (own, needed) = needs(key)?;
            (own == name && !needed.contains(&word)).then(|| (key, needed[0]))
        })
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
            section.stribeck = study.machine.stribeck;
            if let Some(coupled) = study.machine.coupled {
                section.spring_angles = Some(coupled.angles_deg);
                section.springs = Some(coupled.springs);
                section.contact_spring = Some(coupled.contact_spring);
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::law::WindowLawKind;
    use crate::map::HEIGHT_RANGE_M;
    use crate::study::file::MachineModel;
    use crate::surface::{CovarianceSource, SurfaceGenerator};
    use crate::vibration::law::VelocityLawKind;

    /// Study in which every number of one degree of freedom is stated.
    const STUDY: &str = "seed = 1\n[surface]\nrms_height = \"1 um\"\ncorrelation_length = [\"20 um\", \"30 um\"]\n\
                         covariance = \"exponential\"\nmarginal = \"normal\"\n[material]\nyoungs_modulus = \"210 GPa\"\n\
                         poisson_ratio = 0.3\nhardness = \"2 GPa\"\nshear_strength = \"385 MPa\"\n[friction]\n[vibration]\n\
                         mass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\ndamping_ratio = 0.17\nnormal_force = \"2.5 kN\"\n\
                         nominal_area = \"833 mm^2\"\nbelt_velocity = \"0.1 m/s\"\nstribeck = 4.2\nkinetic_share = 0.9\n";

    #[test]
    fn every_number_outside_its_bounds_is_refused_with_its_key_unit_and_bounds() {
        let study = StudyFile::parse(STUDY, "study.toml").unwrap();
        study.clone().check().unwrap();
        let mut checked = 0;
        for (key, access) in numbers() {
            for element in [None, Some(1)] {
                if access.get(&study, key, element).is_none() {
                    continue;
                }
                let bounds = key.bounds.unwrap();
                for value in [bounds.low, bounds.high].into_iter().filter(|value| !bounds.contain(*value)) {
                    let mut wrong = study.clone();
                    access.set(&mut wrong, key, element, value);
                    let error = wrong.check().unwrap_err();
                    assert_eq!((error.section, error.key), (key.section, key.name));
                    assert!(error.message.ends_with(bounds.expected), "{error}");
                    checked += 1;
                }
            }
        }
        assert!(checked > 20, "{checked}");
        let mut wrong = study;
        wrong.material.as_mut().unwrap().youngs_modulus.0 = -2e9;
        assert_eq!(
            wrong.check().unwrap_err().to_string(),
            "[material] youngs_modulus: found -2 GPa, expected a positive value"
        );
    }

    #[test]
    fn inputs_need_known_words_and_laws_known_inputs() {
        for (key, name, word) in numbers().filter_map(|(key, _)| key.needs.map(|(name, word)| (key, name, word))) {
            let is_known = match name {
                "model" => word.parse::<MachineModel>().is_ok(),
                "covariance" => word.parse::<CovarianceSource>().is_ok(),
                "generator" => word.parse::<SurfaceGenerator>().is_ok(),
                _ => false,
            };
            assert!(is_known, "{key:?}");
        }
        let velocity = VelocityLawKind::ALL.iter().flat_map(|law| law.statement().inputs);
        let window = WindowLawKind::ALL.iter().flat_map(|law| law.statement().inputs);
        for input in velocity.chain(window).filter(|input| **input != "vibration.friction_table") {
            assert!(Key::find(input).is_some(), "{input}");
        }
    }

    #[test]
    fn heights_have_the_range_of_maps() {
        let bounds = Key::find("surface.rms_height").unwrap().bounds.unwrap();
        assert_eq!((bounds.low, bounds.high), (*HEIGHT_RANGE_M.start(), *HEIGHT_RANGE_M.end()));
    }
}
