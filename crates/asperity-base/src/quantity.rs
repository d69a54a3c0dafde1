//! Quantities with units as text: `"210 GPa"`, `"0.5um"`, `"5e-05 Pa"`.
//!
//! All numbers inside the library are in SI units; this module converts input and output. A number without a unit is an
//! error, because `0.5` could be in metre or in micrometre.

use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use thiserror::Error;

/// Error in the text of a quantity.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum QuantityError {
    /// The text does not start with a finite number.
    #[error("`{text}` does not start with a number; write for example \"{example}\"")]
    NotANumber {
        /// The text.
        text: String,
        /// Expected dimension.
        wanted: &'static str,
        /// Example of a valid quantity.
        example: &'static str,
    },
    /// The number, or its value in SI units, overflows.
    #[error("`{text}` is out of range: no {wanted} is that large")]
    TooLarge {
        /// The text.
        text: String,
        /// Expected dimension.
        wanted: &'static str,
    },
    /// A number without a unit.
    #[error("`{text}` has no unit; write for example \"{example}\"")]
    NoUnit {
        /// The text.
        text: String,
        /// Expected dimension.
        wanted: &'static str,
        /// Example of a valid quantity.
        example: &'static str,
    },
    /// A unit that is unknown or of another dimension.
    #[error("`{unit}` is not a unit of {wanted}{}; write for example \"{example}\"", meant(*like))]
    WrongUnit {
        /// The unit.
        unit: String,
        /// Unit that differs in the case of its letters alone.
        like: Option<&'static str>,
        /// Expected dimension.
        wanted: &'static str,
        /// Example of a valid quantity.
        example: &'static str,
    },
}

fn meant(unit: Option<&str>) -> String {
    unit.map_or_else(String::new, |unit| format!(", did you mean `{unit}`?"))
}

/// Physical dimension with its name, an example, and its units with their factors to SI.
#[doc(hidden)]
#[derive(Debug)]
pub struct Dimension {
    /// Name.
    pub name: &'static str,
    example: &'static str,
    /// SI unit of output.
    si: &'static str,
    units: &'static [(&'static str, f64)],
}

/// Dimension of lengths.
#[doc(hidden)]
pub const LENGTH: Dimension = Dimension {
    name: "length",
    example: "0.5 um",
    si: "m",
    units: &[
        ("m", 1.0),
        ("cm", 1e-2),
        ("mm", 1e-3),
        ("um", 1e-6),
        ("µm", 1e-6),
        ("μm", 1e-6),
        ("nm", 1e-9),
        ("pm", 1e-12),
    ],
};
const AREA: Dimension = Dimension {
    name: "area",
    example: "833 mm^2",
    si: "m^2",
    units: &[
        ("m^2", 1.0),
        ("m2", 1.0),
        ("m²", 1.0),
        ("cm^2", 1e-4),
        ("cm2", 1e-4),
        ("cm²", 1e-4),
        ("mm^2", 1e-6),
        ("mm2", 1e-6),
        ("mm²", 1e-6),
        ("um^2", 1e-12),
        ("um2", 1e-12),
        ("µm²", 1e-12),
        ("μm²", 1e-12),
    ],
};
const PRESSURE: Dimension = Dimension {
    name: "pressure",
    example: "210 GPa",
    si: "Pa",
    units: &[
        ("Pa", 1.0),
        ("hPa", 1e2),
        ("kPa", 1e3),
        ("MPa", 1e6),
        ("GPa", 1e9),
        ("TPa", 1e12),
        ("mPa", 1e-3),
        ("N/mm^2", 1e6),
        ("N/mm2", 1e6),
        ("N/mm²", 1e6),
        ("N/m^2", 1.0),
        ("N/m2", 1.0),
        ("bar", 1e5),
    ],
};
const MASS: Dimension =
    Dimension { name: "mass", example: "1 kg", si: "kg", units: &[("kg", 1.0), ("g", 1e-3), ("mg", 1e-6), ("t", 1e3)] };
const FORCE: Dimension = Dimension {
    name: "force",
    example: "2.5 kN",
    si: "N",
    units: &[
        ("N", 1.0),
        ("mN", 1e-3),
        ("uN", 1e-6),
        ("µN", 1e-6),
        ("μN", 1e-6),
        ("nN", 1e-9),
        ("kN", 1e3),
        ("MN", 1e6),
    ],
};
const VELOCITY: Dimension = Dimension {
    name: "velocity",
    example: "23.7 mm/s",
    si: "m/s",
    units: &[
        ("m/s", 1.0),
        ("cm/s", 1e-2),
        ("mm/s", 1e-3),
        ("um/s", 1e-6),
        ("µm/s", 1e-6),
        ("μm/s", 1e-6),
        ("km/h", 1.0 / 3.6),
    ],
};
const INVERSE_VELOCITY: Dimension = Dimension {
    name: "inverse velocity",
    example: "0.13 s/m",
    si: "s/m",
    units: &[("s/m", 1.0), ("s/cm", 1e2), ("s/mm", 1e3), ("ms/m", 1e-3), ("ms/mm", 1.0)],
};
const ANGULAR_FREQUENCY: Dimension = Dimension {
    name: "angular frequency",
    example: "316 rad/s",
    si: "rad/s",
    units: &[
        ("rad/s", 1.0),
        ("1/s", 1.0),
        ("s^-1", 1.0),
        ("krad/s", 1e3),
        ("Hz", std::f64::consts::TAU),
        ("kHz", 1e3 * std::f64::consts::TAU),
    ],
};
const TIME: Dimension = Dimension {
    name: "time",
    example: "2.5 s",
    si: "s",
    units: &[
        ("s", 1.0),
        ("ms", 1e-3),
        ("us", 1e-6),
        ("µs", 1e-6),
        ("μs", 1e-6),
        ("ns", 1e-9),
        ("min", 60.0),
        ("h", 3600.0),
    ],
};
const FREQUENCY: Dimension = Dimension {
    name: "frequency",
    example: "1 kHz",
    si: "Hz",
    units: &[("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6), ("1/s", 1.0), ("s^-1", 1.0)],
};
const COMPLIANCE: Dimension = Dimension {
    name: "compliance",
    example: "5e-15 m/Pa",
    si: "m/Pa",
    units: &[
        ("m/Pa", 1.0),
        ("m/MPa", 1e-6),
        ("m/GPa", 1e-9),
        ("um/Pa", 1e-6),
        ("um/MPa", 1e-12),
        ("µm/MPa", 1e-12),
        ("um/GPa", 1e-15),
        ("nm/MPa", 1e-15),
        ("nm/Pa", 1e-9),
        ("mm/MPa", 1e-9),
    ],
};

/// Returns the number of a percentage, .03 for `3 %`.
#[doc(hidden)]
pub fn percentage(text: &str) -> Option<f64> {
    let number = text.trim().strip_suffix('%')?.trim();
    // The decimal point moves, so that no digit changes.
    match number.contains(['e', 'E']) {
        true => number.parse().ok().map(|percent: f64| percent / 100.0),
        false => format!("{number}e-2").parse().ok(),
    }
}

impl Dimension {
    /// Returns the dimension of an SI unit; that of Hz is a frequency, not an angular one.
    pub fn of_unit(si: &str) -> Option<&'static Self> {
        Self::ALL.iter().copied().find(|dimension| dimension.si == si)
    }

    /// Returns a quantity of any dimension in SI with its SI unit.
    pub fn parse_any(text: &str) -> Option<(f64, &'static str)> {
        Self::ALL.iter().find_map(|dimension| Some((dimension.parse(text).ok()?, dimension.si)))
    }

    /// Returns a number with a unit in SI.
    ///
    /// # Errors
    /// The text does not start with a finite number, or its unit is missing or of another dimension.
    pub fn parse(&self, text: &str) -> Result<f64, QuantityError> {
        let (wanted, example) = (self.name, self.example);
        let trimmed = text.trim();
        // Returns the length of the longest prefix that is a number, for "5e-05 Pa" and "210GPa", but not "1e".
        let split = (1..=trimmed.len())
            .rev()
            .filter(|&end| trimmed.is_char_boundary(end))
            .find(|&end| trimmed[..end].parse::<f64>().is_ok() && trimmed.as_bytes()[end - 1] != b' ')
            .filter(|&end| trimmed[..end].contains(|c: char| c.is_ascii_digit()));
        let Some(split) = split.filter(|_| !trimmed.starts_with(|c: char| c.is_alphabetic())) else {
            return Err(QuantityError::NotANumber { text: trimmed.into(), wanted, example });
        };
        let (number, unit) = (&trimmed[..split], trimmed[split..].trim());
        if unit.is_empty() {
            return Err(QuantityError::NoUnit { text: trimmed.into(), wanted, example });
        }
        let factor = self.units.iter().find(|(name, _)| *name == unit).map(|(_, factor)| *factor);
        match (number.parse::<f64>(), factor) {
            (Ok(value), Some(factor)) => match scaled(value, factor) {
                value if value.is_finite() => Ok(value),
                _ => Err(QuantityError::TooLarge { text: trimmed.into(), wanted }),
            },
            _ => {
                let alike = || self.units.iter().map(|(name, _)| *name).filter(|name| name.eq_ignore_ascii_case(unit));
                let like = alike().find(|name| name.chars().next() == unit.chars().next()).or_else(|| alike().next());
                Err(QuantityError::WrongUnit { unit: unit.into(), like, wanted, example })
            }
        }
    }

    /// Returns a text that parses to the same bits, in the unit with the shortest number: without exponent, at least 1,
    /// with few digits. Only units in plain ASCII are used.
    pub fn show(&self, value: f64) -> String {
        let candidates = self.units.iter().filter(|(unit, _)| unit.is_ascii()).flat_map(|(unit, factor)| {
            // Both roundings differ; parsing decides which is exact.
            [value / factor, value * (1.0 / factor).round()].map(|scaled| {
                let digits = format!("{scaled:?}");
                (digits.strip_suffix(".0").unwrap_or(&digits).to_owned(), *unit)
            })
        });
        candidates
            .filter(|(number, unit)| {
                self.parse(&format!("{number} {unit}")).is_ok_and(|back| back.to_bits() == value.to_bits())
            })
            .min_by_key(|(number, unit)| {
                let small = number.trim_start_matches('-').starts_with("0.");
                // The bar is not used for hardness.
                (number.contains('e'), small, matches!(*unit, "bar" | "hPa"), number.len())
            })
            .map_or_else(|| format!("{value:?} {}", self.si), |(number, unit)| format!("{number} {unit}"))
    }

    /// Returns the regular expression of the units.
    pub fn unit_pattern(&self) -> String {
        let units: Vec<String> = self.units.iter().map(|(unit, _)| unit.replace('^', r"\^")).collect();
        format!("({})", units.join("|"))
    }

    fn schema(&self) -> Schema {
        json_schema!({
            "type": "string",
            "description": format!("Text of a number and a unit of {}.", self.name),
            "pattern": format!(r"^\s*{NUMBER_PATTERN}\s*{}\s*$", self.unit_pattern()),
            "examples": [self.example],
            "x-unit": self.si,
        })
    }
}

/// Returns `value · factor`, dividing by the inverse of small powers of ten because those are exact: "20 um" is then
/// 2e-5 m.
fn scaled(value: f64, factor: f64) -> f64 {
    let inverse = (1.0 / factor).round();
    if factor < 1.0 && (inverse * factor - 1.0).abs() < 1e-15 { value / inverse } else { value * factor }
}

/// Regular expression of a number in the text of a quantity.
#[doc(hidden)]
pub const NUMBER_PATTERN: &str = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?";

macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident = $dimension:ident;)+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl From<$name> for f64 {
            /// Returns the number in SI.
            fn from(quantity: $name) -> Self {
                quantity.0
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                $dimension.schema()
            }
        }

        impl FromStr for $name {
            type Err = QuantityError;

            fn from_str(text: &str) -> Result<Self, QuantityError> {
                $dimension.parse(text).map(Self)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&$dimension.show(self.0))
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Visitor;
                impl de::Visitor<'_> for Visitor {
                    type Value = $name;

                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        write!(f, "a {} with its unit, such as \"{}\"", $dimension.name, $dimension.example)
                    }

                    fn visit_str<E: de::Error>(self, text: &str) -> Result<$name, E> {
                        text.parse().map_err(E::custom)
                    }
                }
                deserializer.deserialize_any(Visitor)
            }
        }
    )+

        impl Dimension {
            const ALL: &[&Self] = &[$(&$dimension),+];
        }
    };
}

quantities! {
    /// A length in metre.
    Length = LENGTH;
    /// An area in square metre.
    Area = AREA;
    /// A pressure, modulus or hardness in pascal.
    Pressure = PRESSURE;
    /// A mass in kilogram.
    Mass = MASS;
    /// A force in newton.
    Force = FORCE;
    /// A velocity in metre per second.
    Velocity = VELOCITY;
    /// A rate per velocity, such as the Stribeck coefficient, in second per metre.
    InverseVelocity = INVERSE_VELOCITY;
    /// An angular frequency in radian per second.
    AngularFrequency = ANGULAR_FREQUENCY;
    /// A time in second.
    Time = TIME;
    /// A frequency, such as a sampling rate, in hertz: not radian per second.
    Frequency = FREQUENCY;
    /// A displacement per pressure in metre per pascal.
    Compliance = COMPLIANCE;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_read_with_and_without_a_space() {
        assert_eq!("210 GPa".parse(), Ok(Pressure(210e9)));
        assert_eq!("210GPa".parse(), Ok(Pressure(210e9)));
        assert_eq!("5e-05 Pa".parse(), Ok(Pressure(5e-5)));
        assert_eq!("0.5um".parse(), Ok(Length(0.5e-6)));
        assert_eq!("-1.5 µm".parse(), Ok(Length(-1.5e-6)));
        assert_eq!("23.7 mm/s".parse(), Ok(Velocity(23.7e-3)));
        assert_eq!("0.13 s/mm".parse(), Ok(InverseVelocity(130.0)));
        assert_eq!("2 min".parse(), Ok(Time(120.0)));
        assert_eq!("1 kHz".parse(), Ok(Frequency(1000.0)));
    }

    #[test]
    fn a_bare_number_a_wrong_unit_and_a_word_are_errors() {
        assert!(matches!("0.5".parse::<Length>(), Err(QuantityError::NoUnit { .. })));
        assert!(matches!("0.5 GPa".parse::<Length>(), Err(QuantityError::WrongUnit { .. })));
        assert!(matches!("inf m".parse::<Length>(), Err(QuantityError::NotANumber { .. })));
        assert!(matches!("NaN m".parse::<Length>(), Err(QuantityError::NotANumber { .. })));
        assert!(matches!("-inf m".parse::<Length>(), Err(QuantityError::NotANumber { .. })));
        assert!(matches!("".parse::<Length>(), Err(QuantityError::NotANumber { .. })));
        assert!(matches!("µm".parse::<Length>(), Err(QuantityError::NotANumber { .. })));
    }

    #[test]
    fn overflowing_quantities_are_rejected() {
        for text in ["1e400 m", "-1e400um"] {
            assert!(matches!(text.parse::<Length>(), Err(QuantityError::TooLarge { .. })), "{text}");
        }
        assert!(matches!("1e308 TPa".parse::<Pressure>(), Err(QuantityError::TooLarge { .. })));
        assert!(matches!("1e400".parse::<Length>(), Err(QuantityError::NoUnit { .. })));
    }

    #[test]
    fn display_parses_back_to_the_same_bits() {
        for value in [1.0 / 3.0, 2e-5, 6.02e23, 0.1, 0.0, -0.0, -1e-300, 7.3e-6, f64::MAX, f64::MIN_POSITIVE] {
            let back: Length = Length(value).to_string().parse().unwrap();
            assert_eq!(back.0.to_bits(), value.to_bits(), "{}", Length(value));
        }
    }

    #[test]
    fn quantities_are_shown_without_exponents_in_few_digits() {
        for text in [
            "210 GPa",
            "500 nm",
            "20 um",
            "200 um",
            "2.5 kN",
            "833 mm^2",
            "23.7 mm/s",
            "316 rad/s",
            "6 mm",
            "1 kg",
            "1 m",
        ] {
            let shown = match text.rsplit(' ').next().unwrap() {
                "GPa" => text.parse::<Pressure>().unwrap().to_string(),
                "kN" => text.parse::<Force>().unwrap().to_string(),
                "mm^2" => text.parse::<Area>().unwrap().to_string(),
                "mm/s" => text.parse::<Velocity>().unwrap().to_string(),
                "rad/s" => text.parse::<AngularFrequency>().unwrap().to_string(),
                "kg" => text.parse::<Mass>().unwrap().to_string(),
                _ => text.parse::<Length>().unwrap().to_string(),
            };
            assert_eq!(shown, text);
        }
    }
}
