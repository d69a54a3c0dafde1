//! Laws that a study states.

use asperity_base::statement::{Stated, Statement};

use super::invalid_value::{InvalidValue, invalid};
use crate::study::StudyFile;
use crate::study::uncertain::numbers;
use crate::vibration::Scales;

impl StudyFile {
    /// Returns a law that the file states, in SI or in the units of a machine.
    pub(super) fn stated_law<L>(&self, statement: &Statement<L>, scales: Option<&Scales>) -> Result<L, InvalidValue> {
        (statement.law)(&StatedValues { file: self, scales }).map_err(|error| {
            let (section, key) = split(error.input);
            invalid(section, key, error.reason)
        })
    }

    /// Returns the numbers of a law's inputs in SI.
    pub(super) fn stated_numbers(&self, inputs: &[&'static str]) -> Vec<(&'static str, Option<f64>)> {
        let stated = StatedValues { file: self, scales: None };
        inputs.iter().map(|input| (*input, stated.number(input))).collect()
    }
}

/// Returns the section and the key of an input.
pub(super) fn split(input: &str) -> (&str, &str) {
    input.split_once('.').unwrap_or(("", input))
}

/// Values of a study, in SI or in the units of a machine.
struct StatedValues<'a> {
    file: &'a StudyFile,
    scales: Option<&'a Scales>,
}

impl StatedValues<'_> {
    fn dimensionless(&self, value: f64, unit: &str) -> f64 {
        self.scales.and_then(|scales| scales.dimensionless(value, unit)).unwrap_or(value)
    }
}

impl Stated for StatedValues<'_> {
    fn number(&self, input: &str) -> Option<f64> {
        if input == "material.hardness" {
            // That of the softer body.
            return self.file.hardness().map(|hardness| hardness.0);
        }
        let rows = || numbers().filter(|(key, _)| (key.section, key.name) == split(input));
        let stated =
            rows().find_map(|(key, access)| Some(self.dimensionless(access.get(self.file, key, None)?, key.unit)));
        stated.or_else(|| rows().find_map(|(key, _)| key.default?.value.number()))
    }

    /// Returns the points of the only table that a study may state, with coefficients relative to the first.
    fn points(&self, _: &str) -> Option<Vec<[f64; 2]>> {
        let table = self.file.vibration.as_ref()?.friction_table.as_ref()?;
        let kinetic = table.first().map_or(1.0, |(_, coefficient)| *coefficient);
        Some(
            table
                .iter()
                .map(|(speed, coefficient)| [self.dimensionless(speed.0, "m/s"), coefficient / kinetic])
                .collect(),
        )
    }
}
