//! Conversion of the text of a study file to a checked [`Study`], with errors that name a line.

mod deserializer;

use std::path::Path;

use serde::de::DeserializeOwned;
use thiserror::Error;
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use crate::study::uncertain::{UncertainValue, has_samples, percentage, uncertain_value};
use crate::study::{InvalidValue, Study, StudyFile};
use deserializer::ValueDeserializer;
pub(super) use deserializer::{quoted_number, wrong_length};

/// Sections whose numbers and quantities may be uncertain.
const SECTIONS: [&str; 5] = ["surface", "counterface", "material", "friction", "vibration"];

/// Error of a study file.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{file}:{line}: {message}")]
pub struct StudyFileError {
    /// Name of the file.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Description of the error and the expected value.
    pub message: String,
    /// Whether a file of data that the study names is missing or unusable.
    pub in_data: bool,
}

impl Study {
    /// Reads the text of a study file; `file` names it in errors.
    ///
    /// # Errors
    /// The first error of the study, with its line.
    pub fn parse(text: &str, file: &str) -> Result<Self, StudyFileError> {
        StudyFile::parse(text, file)?.check().map_err(|value| StudyFileError::invalid(&value, text, file))
    }
}

impl StudyFile {
    /// Reads the text of a study file without a check of its values; `file` names it in errors.
    ///
    /// # Errors
    /// A key, type or unit is wrong.
    pub fn parse(text: &str, file: &str) -> Result<Self, StudyFileError> {
        let mut study = read_with_uncertain_values(text, file)?;
        study.fill_in_sizes(Path::new(file).parent().unwrap_or(Path::new("")));
        let written = StudyFileError::read(text, file)?;
        study.with_defaults_of(&written).map_err(|message| {
            let line = line_of_key(text, "", "unstated");
            StudyFileError { file: file.into(), line, message, in_data: false }
        })
    }
}

impl StudyFileError {
    /// Returns the error of an invalid value, with the line of its key in `text`.
    pub(super) fn invalid(value: &InvalidValue, text: &str, file: &str) -> Self {
        Self {
            file: file.into(),
            line: line_of_key(text, value.section, value.key),
            message: value.to_string(),
            in_data: false,
        }
    }

    /// Reads TOML into a section or a whole file; errors about unknown keys and wrong units name their line.
    pub(super) fn read<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, Self> {
        let root = DeTable::parse(text).map_err(|error| Self::toml(&error, text, file))?;
        Self::read_table(root, text, file)
    }

    /// Reads the parsed `text` into a section or a whole file.
    fn read_table<T: DeserializeOwned>(root: Spanned<DeTable<'_>>, text: &str, file: &str) -> Result<T, Self> {
        T::deserialize(ValueDeserializer::from(root)).map_err(|error| Self::at(error.start, &error, text, file))
    }

    /// Returns an error of the syntax of TOML, with its line.
    fn toml(error: &toml::de::Error, text: &str, file: &str) -> Self {
        Self::at(error.span().map(|span| span.start), error.message(), text, file)
    }

    fn at(byte: Option<usize>, message: impl ToString, text: &str, file: &str) -> Self {
        let line = byte.map_or(1, |byte| line_at(text, byte));
        Self { file: file.into(), line, message: message.to_string(), in_data: false }
    }
}

/// Reads the text of a study file with its uncertain values; `file` names it in errors. Files of samples are relative to its
/// folder.
///
/// # Errors
/// A key, type, unit or distribution is wrong.
pub(super) fn read_with_uncertain_values(text: &str, file: &str) -> Result<StudyFile, StudyFileError> {
    let written: Table = StudyFileError::read(text, file)?;
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let (mut uncertain, mut replaced) = (Vec::new(), Vec::new());
    for section in SECTIONS {
        let Some(Value::Table(values)) = written.get(section) else { continue };
        for (name, value) in values {
            let elements: Vec<(Option<usize>, &Value)> = match value {
                Value::Array(list) => {
                    list.iter().enumerate().map(|(position, value)| (Some(position), value)).collect()
                }
                value => vec![(None, value)],
            };
            for (element, value) in elements {
                let found = uncertain_value(section, name, element, value, folder).map_err(|message| {
                    let line = line_of_key(text, section, name);
                    let message = format!("[{section}] {name}: {message}");
                    StudyFileError { file: file.into(), line, message, in_data: has_samples(section, name, value) }
                })?;
                let number = percentage(section, name, value).map(Value::Float);
                let exact = found.as_ref().map(UncertainValue::central_as_stated).or(number);
                replaced.extend(exact.map(|exact| (section, name, element, exact.to_string())));
                uncertain.extend(found);
            }
        }
    }
    let mut root = DeTable::parse(text).map_err(|error| StudyFileError::toml(&error, text, file))?;
    for (section, name, element, exact) in &replaced {
        let central = DeValue::parse(exact).map_err(|error| StudyFileError::toml(&error, text, file))?;
        let section = root.get_mut().get_mut(*section).map(|section| section.get_mut());
        let Some(DeValue::Table(section)) = section else { continue };
        let value = section.get_mut(name.as_str()).map(|value| value.get_mut());
        match (value, *element) {
            (Some(DeValue::Array(list)), Some(position)) => {
                if let Some(element) = list.get_mut(position) {
                    *element.get_mut() = central.into_inner();
                }
            }
            (Some(value), None) => *value = central.into_inner(),
            _ => {}
        }
    }
    Ok(StudyFile { uncertain, ..StudyFileError::read_table(root, text, file)? })
}

/// Returns the line of a byte, counted from 1.
pub(super) fn line_at(text: &str, byte: usize) -> usize {
    text.as_bytes()[..byte.min(text.len())].iter().filter(|b| **b == b'\n').count() + 1
}

/// Returns the line of `key` in `[section]`, which may be `outer.inner`, or empty for a key of no section; the line of the
/// section if the key is absent; 1 if the section is absent too.
pub(super) fn line_of_key(text: &str, section: &str, key: &str) -> usize {
    let Ok(file) = DeTable::parse(text) else { return 1 };
    let find = |table: &DeTable<'_>, name: &str| table.keys().find(|key| key.get_ref() == name).map(|key| key.span());
    let (mut table, mut line) = (file.get_ref(), 1);
    for name in section.split('.').filter(|name| !name.is_empty()).chain([key]) {
        let Some(span) = find(table, name) else { return line };
        line = line_at(text, span.start);
        match table.get(name).map(|value| value.get_ref()) {
            Some(DeValue::Table(inner)) => table = inner,
            _ => return line,
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    const STUDY: &str = "\nseed = 2016\n[surface]\ncovariance = \"squared_exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\n\
                         correlation_length = [\"20 um\", \"20 um\"]\n[material]\nyoungs_modulus = \"210 GPa\"\n[pressure]\n\
                         size = [\"200 um\", \"200 um\"]\npoints = [64, 64]\npercentile = 50.0\n";

    fn error(from: &str, to: &str) -> StudyFileError {
        assert!(STUDY.contains(from));
        Study::parse(&STUDY.replace(from, to), "study.toml").unwrap_err()
    }

    #[test]
    fn a_study_fills_in_its_defaults_and_survives_being_written() {
        let study = Study::parse(STUDY, "study.toml").unwrap();
        let pressure = study.file().pressure.as_ref().unwrap();
        assert_eq!((pressure.variables, pressure.degree, pressure.fine_solves), (8, 3, 500));
        let written = toml::to_string(study.file()).unwrap();
        assert_eq!(Study::parse(&written, "written").unwrap().file(), study.file());
    }

    #[test]
    fn a_date_is_no_value() {
        let found = error("rms_height = \"1 um\"", "rms_height = 2026-01-01");
        assert_eq!((found.line, found.message.as_str()), (6, "2026-01-01 is a date; no key has one"));
    }

    #[test]
    fn a_typo_in_the_file_is_an_error_not_a_default() {
        let error = error("percentile = 50.0", "percentil = 50.0");
        assert_eq!(error.line, 13);
        assert!(
            error.message.contains("`percentil`") && error.message.contains("did you mean `percentile`?"),
            "{error}"
        );
    }

    #[test]
    fn percentages_are_numbers_and_other_forms_of_an_uncertain_value_name_those_that_exist() {
        let hardness = |value: &str| {
            let text = STUDY.replace("youngs_modulus", &format!("hardness = \"{value}\"\nyoungs_modulus"));
            Study::parse(&text.replace("[pressure]", "poisson_ratio = \"25 %\"\n[pressure]"), "study.toml")
        };
        let study = hardness("8 GPa ± 10 %").unwrap();
        let material = study.file().material.as_ref().unwrap();
        assert_eq!((material.poisson_ratio, material.hardness.unwrap().0), (0.25, 8e9));
        assert!((study.file().uncertain[0].input().marginal().std() / 8e8 - 1.0).abs() < 1e-12);
        for (value, expected) in [
            ("unknown", "`unknown` is no value; state one, or `mean ± standard deviation`, `low .. high`"),
            ("8 GPa ± ?", "`8 GPa ± ?` is no value"),
            ("8 Gpa", "`Gpa` is not a unit of pressure, did you mean `GPa`?"),
            ("1 .. 2 Gpa", "did you mean `GPa`?"),
            ("8 %", "`%` is not a unit of pressure"),
            ("1-2 GPa", "`1-2 GPa` is no value; write the range as \"1 .. 2 GPa\""),
            ("900 MPa - 2 GPa", "write the range as \"900 MPa .. 2 GPa\""),
            ("5e-05 Gpa", "did you mean `GPa`?"),
        ] {
            let error = hardness(value).unwrap_err();
            assert!(error.line == 9 && error.message.contains(expected), "{value}: {error}");
        }
    }

    #[test]
    fn one_length_applies_to_both_axes() {
        let lengths = |value: &str| {
            let text = STUDY.replace("[\"20 um\", \"20 um\"]", value);
            Study::parse(&text, "study.toml")
                .map(|study| study.file().surface.as_ref().unwrap().correlation_length.unwrap())
        };
        assert_eq!(lengths("\"20 um\"").unwrap(), lengths("[\"20 um\", \"20 um\"]").unwrap());
        assert_ne!(lengths("[\"20 um\", \"10 um\"]").unwrap(), lengths("\"20 um\"").unwrap());
        for (value, expected) in [
            ("20.0", "with its unit"),
            ("\"20\"", "no unit"),
            ("\"20 GPa\"", "`GPa` is not a unit of length"),
            ("\"1e400 m\"", "out of range"),
            ("[\"20 um\"]", "found 1 value, expected 2"),
            ("[\"20 um\", \"20 um\", \"20 um\"]", "found 3 values, expected 2"),
            ("\"-20 um\"", "positive"),
        ] {
            let error = lengths(value).unwrap_err();
            assert!(error.line == 7 && error.message.contains(expected), "{value}: {error}");
        }
        let pixel = STUDY.replace("covariance", "file = \"a.npy\"\npixel_size = \"1e-155 m\"\ncovariance");
        let error = Study::parse(&pixel, "study.toml").unwrap_err();
        assert!(error.line == 5 && error.message.contains("between 1e-15 m and 1e3 m"), "{error}");
        let unit = STUDY.replace("covariance", "file = \"a.npy\"\nheight_unit = \"V\"\ncovariance");
        let error = Study::parse(&unit, "study.toml").unwrap_err();
        assert!(error.line == 5 && error.message.contains("`V` is not a unit of length"), "{error}");
    }

    #[test]
    fn errors_point_at_their_line() {
        for (from, to, line, expected) in [
            ("\"1 um\"", "\"1 GPa\"", 6, "`GPa` is not a unit of length"),
            ("\"1 um\"", "1.0", 6, "with its unit"),
            ("\"1 um\"", "\"1\"", 6, "no unit"),
            ("percentile = 50.0", "percentile = 150.0", 13, "150"),
            ("percentile = 50.0", "", 10, "exactly one of"),
            ("\"squared_exponential\"", "\"square_exponential\"", 4, "did you mean `squared_exponential`?"),
            ("\"squared_exponential\"", "\"measured\"", 4, "without `file`"),
            ("\"210 GPa\"", "\"-210 GPa\"", 9, "positive"),
            ("seed = 2016", "", 1, "seed"),
            ("seed = 2016", "seed = ", 2, ""),
            ("[pressure]", "[presure]", 10, "did you mean `pressure`?"),
            ("marginal = \"normal\"", "marginal = \"norml\"", 5, "norml"),
            ("seed = 2016", "seed = 2016\nname = \"a/b\"", 3, "expected the name of a folder"),
            ("seed = 2016", "seed = 2016\nname = \"..\"", 3, "expected the name of a folder"),
            ("seed = 2016", "seed = 2.5", 2, "`2.5` is not a whole number from 0 on"),
            ("seed = 2016", "seed = 99999999999999999999", 2, "99999999999999999999"),
            ("seed = 2016", "seed = 9223372036854775808", 2, "above 9223372036854775807 is out of range"),
            ("percentile = 50.0", "percentile = \"50 %\"", 13, "\"50 %\" is not a number"),
            (
                "percentile = 50.0",
                "percentile = \"-0.05\"",
                13,
                "\"-0.05\" is text; write -0.05 without quotation marks",
            ),
            ("[64, 64]", "[64, '32']", 12, "\"32\" is text; write 32 without quotation marks"),
            ("[64, 64]", "[64, [2]]", 12, "a list is not a whole number"),
        ] {
            let error = error(from, to);
            assert_eq!(error.line, line, "{from} → {to}: {error}");
            assert!(error.message.contains(expected), "{from} → {to}: {error}");
        }
    }
}
