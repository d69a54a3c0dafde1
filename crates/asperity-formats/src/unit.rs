//! Units of length as spelt in instrument files.

use std::str::FromStr;

use crate::{FormatError, Result};

/// Returns the number of units per metre; `None` if the text is not a unit of length.
///
/// Division by it is exact in the last place, multiplication by its inverse is not. The micro sign occurs as U+00B5
/// and U+03BC, in UTF-8 read as Latin-1, and in the DOS code pages. `A` is the ampere: programs of probe microscopes
/// state it for maps of a current. A micro sign alone is a prefix of any unit.
pub(crate) fn per_metre(unit: &str) -> Option<f64> {
    match unit {
        "km" | "kilometer" | "kilometre" | "kilometers" | "kilometres" => Some(1e-3),
        "m" | "meter" | "metre" | "meters" | "metres" => Some(1.0),
        "dm" => Some(1e1),
        "cm" => Some(1e2),
        "mm" | "millimeter" | "millimetre" | "millimeters" | "millimetres" => Some(1e3),
        "um" | "\u{b5}m" | "\u{3bc}m" | "\u{c2}\u{b5}m" | "\u{ce}\u{bc}m" | "\u{e6}m" | "~m" | "micron" | "microns"
        | "micrometer" | "micrometre" | "micrometers" | "micrometres" => Some(1e6),
        "nm" | "nanometer" | "nanometre" | "nanometers" | "nanometres" => Some(1e9),
        "pm" | "picometer" | "picometre" | "picometers" | "picometres" => Some(1e12),
        "fm" | "femtometer" | "femtometre" | "femtometers" | "femtometres" => Some(1e15),
        "\u{c5}" | "\u{212b}" | "\u{c3}\u{85}" | "Ang" | "angstrom" | "Angstrom" | "angstroms" => Some(1e10),
        "in" | "inch" | "inches" => Some(1.0 / 0.0254),
        "mil" => Some(1.0 / 2.54e-5),
        _ => None,
    }
}

/// Returns whether a text is the prefix of micrometre alone.
pub(crate) fn is_micro(text: &str) -> bool {
    matches!(text, "u" | "\u{b5}" | "\u{3bc}")
}

/// Returns the usual name of a unit, given the number of units per metre.
pub(crate) fn name(unit_per_metre: f64) -> Option<&'static str> {
    let names = ["km", "m", "dm", "cm", "mm", "um", "nm", "pm", "fm", "angstrom", "in", "mil"];
    names.into_iter().find(|name| per_metre(name) == Some(unit_per_metre))
}

/// Formats a length for a message: four digits, in a unit that makes it 1 or more.
pub(crate) fn in_words(length_m: f64) -> String {
    if length_m == 0.0 {
        return "0 m".into();
    }
    let units = [("m", 1.0), ("mm", 1e3), ("µm", 1e6), ("nm", 1e9), ("pm", 1e12), ("fm", 1e15), ("km", 1e-3)];
    let rounded = |per_metre: f64| format!("{:.3e}", length_m * per_metre).parse::<f64>().unwrap_or(f64::NAN);
    let found = units.into_iter().find(|(_, per_metre)| (1.0..1e4).contains(&rounded(*per_metre).abs()));
    found.map_or_else(|| format!("{length_m:e} m"), |(name, per_metre)| format!("{} {name}", rounded(per_metre)))
}

/// Unit of length stated by a user.
#[derive(Debug, Clone, PartialEq)]
pub struct LengthUnit {
    name: String,
    per_metre: f64,
}

impl LengthUnit {
    /// Returns the unit as it was spelt.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the number of units per metre.
    pub(crate) fn per_metre(&self) -> f64 {
        self.per_metre
    }
}

impl FromStr for LengthUnit {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Self> {
        let name = text.trim();
        let unknown = || FormatError::UnknownUnit { unit: name.into() };
        Ok(Self { name: name.into(), per_metre: per_metre(name).ok_or_else(unknown)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_shown_in_a_fitting_unit() {
        let lengths = [(2e-6, "2 µm"), (1.0, "1 m"), (0.999_96e-3, "1 mm"), (-1.23456e-8, "-12.35 nm")];
        let others = [(0.0, "0 m"), (1e5, "100 km"), (9e-13, "900 fm"), (1e-40, "1e-40 m")];
        for (length_m, text) in lengths.into_iter().chain(others) {
            assert_eq!(in_words(length_m), text);
        }
    }

    #[test]
    fn a_unit_of_length_is_read_and_anything_else_refused() {
        let unit: LengthUnit = " um ".parse().unwrap();
        assert_eq!((unit.name(), unit.per_metre()), ("um", 1e6));
        for (name, per_metre) in [("km", 1e-3), ("fm", 1e15)] {
            assert_eq!(name.parse::<LengthUnit>().unwrap().per_metre(), per_metre);
        }
        for prefix in ["u", "µ", "\u{3bc}"] {
            let error = prefix.parse::<LengthUnit>().unwrap_err().to_string();
            assert!(
                error.contains(&format!("`{prefix}` is not a unit")) && error.ends_with("did you mean `um`?"),
                "{error}"
            );
        }
        for wrong in ["V", "", "1 um", "UM"] {
            let error = wrong.parse::<LengthUnit>().unwrap_err().to_string();
            assert_eq!(error, format!("`{wrong}` is not a unit of length; wanted m, mm, um, nm, pm, angstrom or in"));
        }
    }
}
