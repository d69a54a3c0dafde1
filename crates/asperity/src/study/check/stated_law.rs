//! Laws that a study states.

use asperity_base::statement::{Stated, Statement};

use super::invalid_value::{InvalidValue, invalid};
use crate::study::StudyFile;
use crate::study::uncertain::numbers;

impl StudyFile {
    /// Returns a law that the file states, with velocities in this unit.
    pub(super) fn stated_law<L>(&self, statement: &Statement<L>, unit_m_per_s: f64) -> Result<L, InvalidValue> {
        (statement.law)(&StatedValues { file: self, unit_m_per_s }).map_err(|error| {
            let (section, key) = split(error.input);
            invalid(section, key, error.reason)
        })
    }

    /// Returns the numbers of a law's inputs in SI.
    pub(super) fn stated_numbers(&self, inputs: &[&'static str]) -> Vec<(&'static str, Option<f64>)> {
        let stated = StatedValues { file: self, unit_m_per_s: 1.0 };
        inputs.iter().map(|input| (*input, stated.number(input))).collect()
    }
}

/// Returns the section and the key of an input.
pub(super) fn split(input: &str) -> (&str, &str) {
    input.split_once('.').unwrap_or(("", input))
}

/// Values of a study, with velocities in a unit.
struct StatedValues<'a> {
    file: &'a StudyFile,
    unit_m_per_s: f64,
}

impl Stated for StatedValues<'_> {
    fn number(&self, input: &str) -> Option<f64> {
        if input == "material.hardness" {
            // That of the softer body.
            return self.file.hardness().map(|hardness| hardness.0);
        }
        let rows = || numbers().filter(|(key, _)| (key.section, key.name) == split(input));
        let stated = rows().find_map(|(key, access)| {
            let value = access.get(self.file, key, None)?;
            Some(match key.unit {
                "m/s" => value / self.unit_m_per_s,
                "s/m" => value * self.unit_m_per_s,
                _ => value,
            })
        });
        stated.or_else(|| rows().find_map(|(key, _)| key.default?.value.number()))
    }

    /// Returns the points of the only table that a study may state, with coefficients relative to the first.
    fn points(&self, _: &str) -> Option<Vec<[f64; 2]>> {
        let table = self.file.vibration.as_ref()?.friction_table.as_ref()?;
        let kinetic = table.first().map_or(1.0, |(_, coefficient)| *coefficient);
        Some(table.iter().map(|(speed, coefficient)| [speed.0 / self.unit_m_per_s, coefficient / kinetic]).collect())
    }
}
