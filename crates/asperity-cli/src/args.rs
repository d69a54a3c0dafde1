//! Parsers of flag values: numbers with a range, quantities with a unit, pairs for x and y.

use std::error::Error;
use std::ffi::OsStr;
use std::fmt::Display;
use std::str::FromStr;

use asperity::choice::Choice;
use asperity::keys::Key;
use asperity::quantity::percentage;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, Command};

/// Reason why a value is invalid; clap prints it after the name of the flag.
pub(crate) type Refusal = Box<dyn Error + Send + Sync>;

/// A quantity with a unit; its number is in SI.
pub(crate) trait Quantity: FromStr<Err: Display> + Display + Copy + Into<f64> {}

impl<Q: FromStr<Err: Display> + Display + Copy + Into<f64>> Quantity for Q {}

/// Parser of a choice by its name in study files. Accepts hyphens in place of underscores.
#[derive(Debug, Clone)]
pub(crate) struct Named<T> {
    /// Further name of one value.
    alias: Option<(&'static str, T)>,
}

/// Returns the parser of a choice by its name.
pub(crate) fn named<T: Choice>() -> Named<T> {
    Named { alias: None }
}

impl<T: Choice> Named<T> {
    /// Returns the parser that also accepts the name `alias` for `value`.
    pub(crate) fn with_alias(self, alias: &'static str, value: T) -> Self {
        Self { alias: Some((alias, value)) }
    }

    fn values() -> impl Iterator<Item = PossibleValue> {
        T::ALL.iter().map(|value| PossibleValue::new(value.name()).help(value.description()))
    }
}

impl<T: Choice + Send + Sync> TypedValueParser for Named<T> {
    type Value = T;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<T, clap::Error> {
        let name = value.to_string_lossy().replace('-', "_");
        let aliased = self.alias.filter(|(alias, _)| *alias == name).map(|(_, value)| value);
        match aliased.or_else(|| T::from_name(&name).ok()) {
            Some(found) => Ok(found),
            // clap's error lists the names.
            None => Err(PossibleValuesParser::new(Self::values())
                .parse_ref(command, arg, value)
                .map_or_else(|error| error, |_| clap::Error::new(clap::error::ErrorKind::InvalidValue))),
        }
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(Self::values()))
    }
}

/// A value along x and, when it differs, along y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum OneOrTwo<T> {
    /// One value, `X`.
    One(T),
    /// Two values, `X,Y`.
    Two(T, T),
}

impl<T: Copy> OneOrTwo<T> {
    /// Returns the values as given: one or two.
    pub(crate) fn given(self) -> Vec<T> {
        match self {
            Self::One(x) => vec![x],
            Self::Two(x, y) => vec![x, y],
        }
    }

    /// Returns (x, y), repeating a single value.
    pub(crate) fn both(self) -> (T, T) {
        match self {
            Self::One(x) => (x, x),
            Self::Two(x, y) => (x, y),
        }
    }
}

/// Largest accepted number in SI; squares and sums of larger numbers overflow a double.
const LARGEST_SI: f64 = 1e30;

fn quantity<Q: Quantity>(text: &str) -> Result<Q, Refusal> {
    let value: Q = text.parse().map_err(|e: Q::Err| e.to_string())?;
    if value.into().abs() <= LARGEST_SI {
        Ok(value)
    } else {
        Err(format!("{value} is out of range: it must be at most {LARGEST_SI:e} in SI").into())
    }
}

/// Parses a quantity above zero.
pub(crate) fn positive_quantity<Q: Quantity>(text: &str) -> Result<Q, Refusal> {
    let value: Q = quantity(text)?;
    if value.into() > 0.0 { Ok(value) } else { Err(format!("{value} is out of range: it must be above 0").into()) }
}

/// Parses a quantity of zero or more.
pub(crate) fn non_negative_quantity<Q: Quantity>(text: &str) -> Result<Q, Refusal> {
    let value: Q = quantity(text)?;
    if value.into() >= 0.0 {
        Ok(value)
    } else {
        Err(format!("{value} is out of range: it must not be negative").into())
    }
}

/// Parses `Q` or `Q,Q`, each above zero.
pub(crate) fn quantity_pair<Q: Quantity>(text: &str) -> Result<OneOrTwo<Q>, Refusal> {
    pair(text, positive_quantity)
}

/// Parses `N` or `N,N`, each at least 1.
pub(crate) fn count_pair(text: &str) -> Result<OneOrTwo<usize>, Refusal> {
    pair(text, count)
}

/// Parses one value, or two as `X,Y`.
pub(crate) fn pair<T>(text: &str, parse: impl Fn(&str) -> Result<T, Refusal>) -> Result<OneOrTwo<T>, Refusal> {
    let parts: Vec<&str> = text.split(',').collect();
    match parts.as_slice() {
        [one] => Ok(OneOrTwo::One(parse(one)?)),
        [x, y] => Ok(OneOrTwo::Two(parse(x)?, parse(y)?)),
        _ => Err(format!("{} values were found; write one, or two as X,Y", parts.len()).into()),
    }
}

/// Parses a whole number of at least 1.
pub(crate) fn count(text: &str) -> Result<usize, Refusal> {
    match text.trim().parse() {
        Ok(0) => Err("0 is out of range: it must be at least 1".into()),
        Ok(n) => Ok(n),
        Err(_) => Err("it must be a whole number of at least 1".into()),
    }
}

/// Parses a seed up to the largest whole number of TOML, in which a run stores it.
pub(crate) fn seed(text: &str) -> Result<u64, Refusal> {
    let seed = text.trim().parse().ok().filter(|seed| i64::try_from(*seed).is_ok());
    seed.ok_or_else(|| format!("a seed is a whole number from 0 to {}", i64::MAX).into())
}

/// Parses a number of threads. Thousands of them on a few cores only wait for one another.
pub(crate) fn threads(text: &str) -> Result<usize, Refusal> {
    const MOST: usize = 1024;
    match count(text)? {
        n if n <= MOST => Ok(n),
        n => Err(format!("{n} is out of range: it must be at most {MOST}").into()),
    }
}

fn finite(text: &str) -> Result<f64, Refusal> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        // Rust parses a number that is too large as infinite.
        Ok(_) if text.contains(|c: char| c.is_ascii_digit()) => Err("the number is too large".into()),
        Ok(x) => Err(format!("{x} is not a finite number").into()),
        Err(_) => Err("it is dimensionless and must be a plain number".into()),
    }
}

const POSITIVE: &str = "it must be above 0";
const NOT_NEGATIVE: &str = "it must not be negative";

/// Parses a finite dimensionless number.
pub(crate) fn number(text: &str) -> Result<f64, Refusal> {
    finite(text)
}

/// Parses a dimensionless number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, Refusal> {
    within(finite(text)?, |x| x > 0.0, POSITIVE)
}

/// Parses a dimensionless number of zero or more.
pub(crate) fn non_negative(text: &str) -> Result<f64, Refusal> {
    within(finite(text)?, |x| x >= 0.0, NOT_NEGATIVE)
}

/// Parses a dimensionless number within the bounds of an input of a study, or a percentage where the study takes one.
pub(crate) fn of_input(input: &str) -> impl Fn(&str) -> Result<f64, Refusal> + Clone + Send + Sync + 'static {
    // The coefficient of which the input is a share is positive.
    let own = Key::find(input).filter(|key| key.coefficient.is_none());
    let (bounds, takes_percentage) = (own.and_then(|key| key.bounds), own.is_some_and(|key| key.percentage));
    move |text| {
        let number = match percentage(text).filter(|number| takes_percentage && number.is_finite()) {
            Some(number) => number,
            None => finite(text)?,
        };
        match bounds {
            Some(bounds) if (bounds.low, bounds.high) != (0.0, f64::INFINITY) => {
                within(number, |x| bounds.contain(x), &format!("expected {}", bounds.expected))
            }
            Some(bounds) if bounds.contain(0.0) => within(number, |x| x >= 0.0, NOT_NEGATIVE),
            Some(_) | None => within(number, |x| x > 0.0, POSITIVE),
        }
    }
}

/// Returns the name of the flag of an input, with underscores.
pub(crate) fn name(input: &'static str) -> &'static str {
    let own = input.rsplit('.').next().unwrap_or(input);
    Key::find(input).and_then(|key| key.coefficient).map_or(own, |[name, _]| name)
}

/// Returns the label of an input, and a note after it.
pub(crate) fn help(input: &str, note: &str) -> String {
    let of_key = |key: &Key| key.coefficient.map_or(key.label, |[_, label]| label);
    let label = Key::find(input).map_or("", of_key);
    let (first, rest) = label.split_at(label.chars().next().map_or(0, char::len_utf8));
    format!("{}{rest}{note}", first.to_uppercase())
}

/// Parses a number of bytes with its unit, such as `4 GB`.
pub(crate) fn bytes(text: &str) -> Result<f64, Refusal> {
    const UNITS: [(&str, f64); 7] = [
        ("KiB", 1024.0),
        ("MiB", 1_048_576.0),
        ("GiB", 1_073_741_824.0),
        ("kB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("TB", 1e12),
    ];
    let found = UNITS
        .iter()
        .find_map(|(unit, bytes)| Some(text.trim().strip_suffix(unit)?.trim().parse::<f64>().ok()? * bytes));
    found
        .filter(|bytes| *bytes > 0.0 && bytes.is_finite())
        .ok_or_else(|| format!("`{text}` is not a size such as 4 GB").into())
}

/// Parses one part of several, `I/N` with I from 1.
pub(crate) fn shard(text: &str) -> Result<[usize; 2], Refusal> {
    let numbers = text.split_once('/').and_then(|(number, of)| Some([number.parse().ok()?, of.parse().ok()?]));
    numbers
        .filter(|[number, of]| (1..=*of).contains(number))
        .ok_or_else(|| format!("`{text}` is not a part: write 2/5 for the second of five").into())
}

/// Parses a percentage, 0 to 100.
pub(crate) fn percent(text: &str) -> Result<f64, Refusal> {
    within(finite(text)?, |x| (0.0..=100.0).contains(&x), "it must lie between 0 and 100")
}

/// Parses a bound on a relative residual, above 0 and below 1.
pub(crate) fn tolerance(text: &str) -> Result<f64, Refusal> {
    within(finite(text)?, |x| x > 0.0 && x < 1.0, "it must be above 0 and below 1")
}

/// Parses a distance from the median in standard deviations, at least 1.
pub(crate) fn outliers(text: &str) -> Result<f64, Refusal> {
    within(finite(text)?, |x| x >= 1.0, "it must be at least 1 standard deviation")
}

fn within(x: f64, allowed: impl Fn(f64) -> bool, requirement: &str) -> Result<f64, Refusal> {
    if allowed(x) { Ok(x) } else { Err(format!("{x} is out of range: {requirement}").into()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity::quantity::{Length, Pressure};

    #[test]
    fn one_value_applies_to_both_axes_and_three_are_refused() {
        assert_eq!(quantity_pair::<Length>("2um").unwrap().both(), (Length(2e-6), Length(2e-6)));
        assert_eq!(quantity_pair::<Length>("2 um, 3 um").unwrap(), OneOrTwo::Two(Length(2e-6), Length(3e-6)));
        assert!(quantity_pair::<Length>("1um,2um,3um").is_err());
        assert!(quantity_pair::<Length>("1um,").is_err());
        assert!(quantity_pair::<Length>("1um,-2um").is_err());
        assert!(count_pair("0").is_err() && count_pair("2.5").is_err());
    }

    #[test]
    fn nan_infinity_and_values_out_of_range_are_refused() {
        for text in ["nan", "NaN", "inf", "-inf", "1e999", "", "one", "0.1um"] {
            assert!(number(text).is_err(), "{text}");
        }
        assert!(positive("0").is_err() && positive("-1").is_err());
        assert!(non_negative("0").is_ok() && non_negative("-1e-300").is_err());
        assert!(percent("100").is_ok() && percent("100.1").is_err());
        let poisson_ratio = of_input("material.poisson_ratio");
        assert!(poisson_ratio("0.5").is_ok() && poisson_ratio("0.51").is_err() && poisson_ratio("-1").is_err());
        let damping = of_input("vibration.damping_ratio");
        assert_eq!((damping("5.5%").unwrap(), damping("5.5 %").unwrap()), (0.055, 0.055));
        assert!(damping("-1 %").is_err() && damping("x%").is_err() && damping("1e999 %").is_err());
        assert!(of_input("vibration.friction_std")("3 %").is_err());
        assert!(tolerance("1e-300").is_ok() && tolerance("1").is_err() && tolerance("0").is_err());
        assert!(non_negative_quantity::<Length>("-1um").is_err() && non_negative_quantity::<Length>("0um").is_ok());
        assert!(positive_quantity::<Pressure>("0 Pa").is_err());
        assert!(positive_quantity::<Pressure>("1e30 Pa").is_ok() && positive_quantity::<Pressure>("1e308 Pa").is_err());
    }
}
