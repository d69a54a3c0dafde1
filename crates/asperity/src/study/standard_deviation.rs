//! Standard deviation of an uncertain parameter of the surface: `"5 %"`, `"0.05 um"`, `0.2`, `"measured"`.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::quantity::{LENGTH, Length, NUMBER_PATTERN};

/// Word for the interval that the surface stage measured.
const MEASURED: &str = "measured";

/// Standard deviation of a length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LengthStd {
    /// Over the length itself.
    Relative(f64),
    /// In metre.
    Absolute(Length),
    /// From the 95 % interval of the scan.
    Measured,
}

/// Standard deviation of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NumberStd {
    /// As stated.
    Absolute(f64),
    /// From the 95 % interval of the scan.
    Measured,
}

impl FromStr for LengthStd {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text == MEASURED {
            return Ok(Self::Measured);
        }
        match text.strip_suffix('%') {
            Some(percent) => percent
                .trim()
                .parse::<f64>()
                .map(|percent| Self::Relative(percent / 100.0))
                .map_err(|_| format!("`{text}` is no percentage; write for example \"5 %\"")),
            None => text.parse().map(Self::Absolute).map_err(|error: crate::quantity::QuantityError| {
                format!("{error}; a percentage such as \"5 %\" and \"measured\" are standard deviations too")
            }),
        }
    }
}

impl fmt::Display for LengthStd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Relative(fraction) => write!(f, "{} %", percent(*fraction)),
            Self::Absolute(length) => length.fmt(f),
            Self::Measured => f.write_str(MEASURED),
        }
    }
}

/// Returns the number of per cent that reads back to the same fraction.
fn percent(fraction: f64) -> f64 {
    let exact = 100.0 * fraction;
    let round = (exact * 1e9).round() / 1e9;
    if (round / 100.0).to_bits() == fraction.to_bits() { round } else { exact }
}

impl JsonSchema for LengthStd {
    fn schema_name() -> Cow<'static, str> {
        "LengthStandardDeviation".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let units = LENGTH.unit_pattern();
        json_schema!({
            "type": "string",
            "pattern": format!(r"^\s*({MEASURED}|{NUMBER_PATTERN}\s*(%|{units}))\s*$"),
            "examples": ["5 %", "0.05 um", MEASURED],
        })
    }
}

impl Serialize for LengthStd {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for LengthStd {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = LengthStd;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a standard deviation such as \"5 %\" or \"0.05 um\", or \"measured\"")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<LengthStd, E> {
                text.parse().map_err(E::custom)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

impl JsonSchema for NumberStd {
    fn schema_name() -> Cow<'static, str> {
        "NumberStandardDeviation".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "type": "number" }, { "const": MEASURED }] })
    }
}

impl Serialize for NumberStd {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Absolute(value) => serializer.serialize_f64(*value),
            Self::Measured => serializer.serialize_str(MEASURED),
        }
    }
}

impl<'de> Deserialize<'de> for NumberStd {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = NumberStd;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a standard deviation such as 0.2, or \"measured\"")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<NumberStd, E> {
                Ok(NumberStd::Absolute(value))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<NumberStd, E> {
                Ok(NumberStd::Absolute(value as f64))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<NumberStd, E> {
                if text == MEASURED {
                    Ok(NumberStd::Measured)
                } else {
                    Err(E::custom(format!("`{text}` is no number; write for example 0.2, or \"measured\"")))
                }
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standard_deviation_is_relative_absolute_or_measured() {
        assert_eq!("5 %".parse(), Ok(LengthStd::Relative(0.05)));
        assert_eq!("2.5%".parse(), Ok(LengthStd::Relative(0.025)));
        assert_eq!("0.05 um".parse(), Ok(LengthStd::Absolute("0.05 um".parse().unwrap())));
        assert_eq!("measured".parse(), Ok(LengthStd::Measured));
        for (text, wanted) in [("5", "no unit"), ("five %", "no percentage"), ("5 GPa", "not a unit of length")] {
            let error = text.parse::<LengthStd>().unwrap_err();
            assert!(error.contains(wanted), "{text}: {error}");
        }
        for text in ["5 %", "0.7 %", "33.3 %", "50 nm", "measured"] {
            let std: LengthStd = text.parse().unwrap();
            assert_eq!(std.to_string().parse(), Ok(std), "{text}");
        }
    }
}
