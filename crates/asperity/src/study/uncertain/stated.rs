//! Forms of an uncertain value: `"0.17 ± 0.02"`, `"0.1 .. 0.2"`, `{ lognormal = ["2 GPa", 0.2], unknown = true }`.

use std::path::PathBuf;

use asperity_results::keys::{RANGES, SPREADS};
use toml::{Table, Value};

use crate::quantity::percentage;

/// Uncertain value as stated; quantities keep their units.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stated {
    pub(super) distribution: StatedDistribution,
    /// Whether it is one value that is not known, not a value that varies from part to part.
    pub(super) unknown: bool,
}

/// Distribution as stated.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum StatedDistribution {
    /// Mean and standard deviation.
    Normal([Value; 2]),
    /// Median and standard deviation of the natural logarithm.
    Lognormal([Value; 2]),
    /// Ends.
    Uniform([Value; 2]),
    /// Lower end, mode, upper end.
    Triangular([Value; 3]),
    /// Shapes a and b, lower end, upper end.
    Beta([Value; 4]),
    /// File of samples.
    Samples(PathBuf),
}

impl StatedDistribution {
    /// Returns a value that shows whether the distribution is of numbers or of quantities; samples may be of both.
    pub(super) fn example(&self) -> &Value {
        match self {
            Self::Normal([value, _]) | Self::Lognormal([value, _]) | Self::Uniform([value, _]) => value,
            Self::Triangular([value, ..]) | Self::Beta([_, _, value, _]) => value,
            Self::Samples(_) => &Value::Boolean(false),
        }
    }
}

/// Separators that names of files and channels may contain.
const IN_NAMES: [&str; 2] = ["+-", "–"];

/// Names of the distributions in a table.
const NAMES: [&str; 6] = ["normal", "lognormal", "uniform", "triangular", "beta", "samples"];

impl Stated {
    /// Reads a value; `None` for a value that is not uncertain. Texts of keys that are no number may contain dashes, such as names of files.
    pub(super) fn read(value: &Value, is_number: bool) -> Result<Option<Self>, String> {
        match value {
            Value::String(text) if !is_number && IN_NAMES.iter().any(|mark| text.contains(mark)) => Ok(None),
            Value::String(text) => Self::from_text(text),
            Value::Table(table) if NAMES.iter().any(|name| table.contains_key(*name)) => {
                Self::from_table(table).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Reads `a ± b`, `a +/- b` and `a .. b`, with the unit on both or at the end, and `a ± b %` of a quantity.
    fn from_text(text: &str) -> Result<Option<Self>, String> {
        let split =
            |separator: &&str| text.split_once(*separator).filter(|(left, right)| has_digit(left) && has_digit(right));
        let (pair, is_normal) = match (SPREADS.iter().find_map(split), RANGES.iter().find_map(split)) {
            (Some(pair), _) => (pair, true),
            (None, Some(pair)) => (pair, false),
            (None, None) => return Ok(None),
        };
        let [left, right] = [pair.0.trim(), pair.1.trim()];
        let (of_left, unit) = (unit_of(left), unit_of(right));
        let pair = match (of_left, unit) {
            ("", "%") if is_normal => {
                return Err(format!(
                    "`{text}` may mean a part of {left}, or percentages; state the unit or `%` of {left}, too"
                ));
            }
            ("%", unit) if unit != "%" => return Err(format!("`{text}`: state `%` with both numbers or with none")),
            (of_left, "%") if is_normal && of_left != "%" => {
                let [number, percent] = [(left, of_left), (right, unit)].map(|(text, unit)| number_of(text, unit));
                [value_of(left), value_of(&format!("{:?} {of_left}", number.abs() * percent / 100.0))]
            }
            ("", unit) => [value_of(&format!("{left} {unit}")), value_of(right)],
            _ => [value_of(left), value_of(right)],
        };
        let distribution = if is_normal { StatedDistribution::Normal(pair) } else { StatedDistribution::Uniform(pair) };
        Ok(Some(Self { distribution, unknown: false }))
    }

    fn from_table(table: &Table) -> Result<Self, String> {
        let mut unknown = false;
        let mut stated = Vec::new();
        for (name, value) in table {
            match (name.as_str(), value) {
                ("unknown", Value::Boolean(flag)) => unknown = *flag,
                ("unknown", other) => return Err(format!("`unknown` is true or false, found {other}")),
                (name, value) if NAMES.contains(&name) => stated.push((name, value)),
                (name, _) => {
                    return Err(format!(
                        "unknown key `{name}` of a distribution (known: {}, unknown)",
                        NAMES.join(", ")
                    ));
                }
            }
        }
        let [(name, value)] = stated[..] else { return Err("state exactly one distribution".into()) };
        let distribution = match name {
            "normal" => StatedDistribution::Normal(list(name, value, "its mean and standard deviation")?),
            "lognormal" => StatedDistribution::Lognormal(list(
                name,
                value,
                "its median and the standard deviation of its logarithm",
            )?),
            "uniform" => StatedDistribution::Uniform(list(name, value, "its lower and upper end")?),
            "triangular" => StatedDistribution::Triangular(list(name, value, "its lower end, mode and upper end")?),
            "beta" => StatedDistribution::Beta(list(name, value, "its shapes a and b, lower end and upper end")?),
            _ => match value {
                Value::String(file) => StatedDistribution::Samples(file.into()),
                other => return Err(format!("`samples` names a CSV file, found {other}")),
            },
        };
        Ok(Self { distribution, unknown })
    }
}

/// Returns the range that a text with a hyphen between two positive numbers seems to state, `80 .. 150 MPa` for `80-150 MPa`.
pub(super) fn hyphenated_range(text: &str) -> Option<String> {
    let (low, high) = text.split_once('-')?;
    let is_positive = |number: &str| number.starts_with(|c: char| c.is_ascii_digit());
    let [low, high] = [low.trim(), high.trim()];
    // The hyphen of `5e-05 Pa` belongs to the number.
    let is_exponent = low.ends_with(['e', 'E']) && unit_of(low).len() == 1;
    (is_positive(low) && is_positive(high) && !is_exponent).then(|| format!("{low} .. {high}"))
}

/// Returns the numbers of a distribution.
fn list<const N: usize>(name: &str, value: &Value, what: &str) -> Result<[Value; N], String> {
    let values = value.as_array().and_then(|list| <[Value; N]>::try_from(list.clone()).ok());
    values.ok_or_else(|| format!("`{name}` needs a list of {N} values: {what}"))
}

fn has_digit(text: &str) -> bool {
    text.contains(|c: char| c.is_ascii_digit())
}

/// Returns the text after the longest prefix that is a number.
fn unit_of(text: &str) -> &str {
    let is_number = |end: &usize| text.is_char_boundary(*end) && text[..*end].parse::<f64>().is_ok();
    (1..=text.len()).rev().find(is_number).map_or(text, |end| text[end..].trim())
}

/// Returns the number before a unit; NaN without one.
fn number_of(text: &str, unit: &str) -> f64 {
    text.strip_suffix(unit).and_then(|number| number.trim().parse().ok()).unwrap_or(f64::NAN)
}

/// Returns a number, also of a percentage, or the text of a quantity.
fn value_of(text: &str) -> Value {
    let text = text.trim();
    percentage(text).or_else(|| text.parse().ok()).map_or_else(|| Value::String(text.into()), Value::Float)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Option<Stated>, String> {
        let table: Table = toml::from_str(&format!("x = {text}")).unwrap();
        Stated::read(&table["x"], true)
    }

    fn quantity(text: &str) -> Value {
        Value::String(text.into())
    }

    #[test]
    fn text_with_plus_minus_is_normal_and_a_range_is_uniform() {
        let both = |text: &str, found: StatedDistribution| {
            assert_eq!(read(text), Ok(Some(Stated { distribution: found, unknown: false })), "{text}");
        };
        let numbers = [Value::Float(0.17), Value::Float(0.02)];
        for text in ["\"0.17 ± 0.02\"", "\"0.17±0.02\"", "\"0.17 +/- 0.02\"", "\"0.17 +- 0.02\"", "\"17 % ± 2 %\""] {
            both(text, StatedDistribution::Normal(numbers.clone()));
        }
        both("\"-0.1 .. 2e-1\"", StatedDistribution::Uniform([Value::Float(-0.1), Value::Float(0.2)]));
        both("\"0.1..0.2\"", StatedDistribution::Uniform([Value::Float(0.1), Value::Float(0.2)]));
        for text in ["\"2 ± 0.2 GPa\"", "\"2 GPa ± 0.2 GPa\""] {
            both(text, StatedDistribution::Normal([quantity("2 GPa"), quantity("0.2 GPa")]));
        }
        for text in ["\"8 GPa ± 10 %\"", "\"8 GPa ± 0.8 GPa\""] {
            both(text, StatedDistribution::Normal([quantity("8 GPa"), quantity("0.8 GPa")]));
        }
        assert!(read("\"0.055 ± 10 %\"").unwrap_err().contains("state the unit or `%` of 0.055"));
        assert!(read("\"10 % .. 20\"").unwrap_err().contains("with both numbers or with none"));
        both("\"1–5 %\"", StatedDistribution::Uniform([Value::Float(0.01), Value::Float(0.05)]));
        both("\"80–150 MPa\"", StatedDistribution::Uniform([quantity("80 MPa"), quantity("150 MPa")]));
        both("\"1 .. 2 GPa\"", StatedDistribution::Uniform([quantity("1 GPa"), quantity("2 GPa")]));
        both("\"900 MPa .. 2 GPa\"", StatedDistribution::Uniform([quantity("900 MPa"), quantity("2 GPa")]));
        for (text, is_uncertain) in [("lot 3–4.x3p", false), ("lot1+-2.x3p", false), ("1 +/- 0.2 s", true)] {
            let found = Stated::read(&Value::String(text.into()), false).unwrap();
            assert_eq!(found.is_some(), is_uncertain, "{text}");
        }
        for text in ["\"0.17\"", "0.17", "\"../scans/a.x3p\"", "\"2 GPa\"", "true", "\"beta:2.1,5\"", "{ x = 1 }"] {
            assert_eq!(read(text), Ok(None), "{text}");
        }
    }

    #[test]
    fn tables_name_their_distribution() {
        let table = |text: &str| read(text).unwrap().unwrap();
        let lognormal = table("{ lognormal = [\"2 GPa\", 0.2], unknown = true }");
        assert!(lognormal.unknown);
        assert_eq!(lognormal.distribution, StatedDistribution::Lognormal([quantity("2 GPa"), Value::Float(0.2)]));
        assert_eq!(table("{ samples = \"m.csv\" }").distribution, StatedDistribution::Samples("m.csv".into()));
        assert!(matches!(table("{ beta = [2, 5, 0, 1] }").distribution, StatedDistribution::Beta(_)));
        assert!(matches!(table("{ triangular = [0, 1, 2] }").distribution, StatedDistribution::Triangular(_)));
        for (text, expected) in [
            ("{ normal = [1.0] }", "a list of 2 values: its mean and standard deviation"),
            ("{ normal = [1.0, 0.1], uniform = [0, 1] }", "exactly one distribution"),
            ("{ normal = [1.0, 0.1], known = true }", "unknown key `known`"),
            ("{ normal = [1.0, 0.1], unknown = 1 }", "true or false"),
            ("{ samples = 3 }", "names a CSV file"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
