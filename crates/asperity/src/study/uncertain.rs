//! Uncertain values of a study file: `damping_ratio = "0.17 ± 0.02"`.
//!
//! An uncertain value is replaced by its central value when the file is read, so a study with uncertain values is an ordinary
//! study that also knows their distributions. With a sample of the values it is an ordinary study again.

mod keys;
mod stated;

use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};
use toml::{Table, Value};

use asperity_formats::{read_text, refusal};
use asperity_results::keys::{Key, LATENT};

use self::keys::{Access, find, show};
pub(super) use self::keys::{needs, numbers, parse};
use self::stated::{Stated, StatedDistribution, hyphenated_range};
use crate::chaos::{InputError, UncertainInput};
use crate::distribution::Marginal;
use crate::quantity::Dimension;
use crate::study::StudyFile;

/// Name of the differences between the parts of a rough slider.
pub(super) const BETWEEN_PARTS: &str = "surface.between_parts";

/// Name of the shortest wave of the surface. A study that does not state it may have it as a value that the scan leaves unknown.
pub(super) const CUT_OFF: &str = "surface.cut_off";

/// Uncertain value of a study file.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainValue {
    place: Place,
    written: Value,
    input: UncertainInput,
}

impl UncertainValue {
    /// Returns the distribution of the value in SI. Its name is that of the key with its section, `vibration.damping_ratio`.
    pub fn input(&self) -> &UncertainInput {
        &self.input
    }

    /// Returns the value at a standard normal variable as a study file states it.
    pub(super) fn stated_at(&self, xi: f64) -> Value {
        show(self.place.key, self.input.value(xi))
    }

    /// Returns the central value as a study file states it.
    pub(super) fn central_as_stated(&self) -> Value {
        show(self.place.key, self.input.central())
    }

    pub(super) fn place(&self) -> Place {
        self.place
    }

    /// Replaces the path of a file of samples by `name`.
    pub(super) fn rename(&mut self, name: &impl Fn(&Path) -> PathBuf) {
        if let Value::Table(stated) = &mut self.written
            && let Some(Value::String(file)) = stated.get_mut("samples")
            && let Some(renamed) = name(Path::new(file)).to_str()
        {
            *file = renamed.to_owned();
        }
    }

    /// Writes the value as it was stated into a table of its study file.
    pub(super) fn restore(&self, table: &mut Table) {
        if let Some(value) = self.place.find(table) {
            value.clone_from(&self.written);
        }
    }
}

/// Place of a number or quantity in a study file, or of a value that no file states.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    key: &'static Key,
    access: Option<&'static Access>,
    /// Position in a list of values.
    pub(super) element: Option<usize>,
}

impl Serialize for Place {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.name())
    }
}

impl PartialEq for Place {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.key, other.key) && self.element == other.element
    }
}

impl Place {
    /// Returns the place of a number or quantity that a study file states by its name, `section.key` or `section.key[position]`.
    pub(super) fn named(name: &str, point: &Point) -> Option<Self> {
        let (path, element) = match name.strip_suffix(']').and_then(|name| name.split_once('[')) {
            Some((path, position)) => (path, Some(position.parse().ok()?)),
            None => (name, None),
        };
        let of_file = numbers().map(|(key, access)| Self { key, access: Some(access), element });
        let own = point.latent.iter().map(|(place, _)| *place);
        of_file.chain(own).find(|place| place.key.path() == path && place.value_in(point).is_some())
    }

    /// Returns the place of a value that no study file states.
    pub(super) fn latent(name: &str) -> Option<Self> {
        let key = LATENT.iter().chain(numbers().map(|(key, _)| key)).find(|key| key.path() == name)?;
        Some(Self { key, access: None, element: None })
    }

    pub(super) fn name(&self) -> String {
        let path = self.key.path();
        self.element.map_or_else(|| path.clone(), |position| format!("{path}[{position}]"))
    }

    /// Returns what is known about the input.
    pub(super) fn key(&self) -> &'static Key {
        self.key
    }

    /// Returns its value in SI.
    pub(super) fn value_in(&self, point: &Point) -> Option<f64> {
        let latent = point.latent.iter().find(|(place, _)| place == self).map(|(_, value)| *value);
        latent.or_else(|| self.access?.get(&point.file, self.key, self.element))
    }

    /// Writes its value in SI.
    pub(super) fn set(&self, point: &mut Point, value: f64) {
        match (point.latent.iter_mut().find(|(place, _)| place == self), self.access) {
            (Some((_, latent)), _) => *latent = value,
            (None, Some(access)) => access.set(&mut point.file, self.key, self.element, value),
            (None, None) => {}
        }
    }

    fn find<'t>(&self, table: &'t mut Table) -> Option<&'t mut Value> {
        let value = table.get_mut(self.key.section)?.get_mut(self.key.name)?;
        match self.element {
            Some(position) => value.get_mut(position),
            None => Some(value),
        }
    }
}

/// Point in parameter space: a study with exact values, and values that no study file states.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Point {
    pub(super) file: StudyFile,
    latent: Vec<(Place, f64)>,
}

impl Point {
    /// Returns the central values of a study.
    pub(super) fn central(file: &StudyFile) -> Self {
        let file = StudyFile {
            name: None,
            unstated: Vec::new(),
            uncertainty: None,
            verdict: None,
            uncertain: Vec::new(),
            ..file.clone()
        };
        Self { file, latent: Vec::new() }
    }

    /// Adds values that no study file states, at their centres.
    pub(super) fn add_latent(&mut self, places: &[Place]) {
        self.latent.extend(places.iter().map(|place| (*place, 0.0)));
    }
}

/// Number that a study file states, in SI.
pub(super) struct SiValue {
    /// The number; of an uncertain value its centre.
    pub(super) number: f64,
    /// Standard deviation of an uncertain value.
    pub(super) std: Option<f64>,
    /// SI unit; empty for a number without unit.
    pub(super) unit: &'static str,
}

/// Returns the number in SI that a key states; `None` for texts and lists, and for plain numbers of keys that cannot be uncertain.
/// Files of samples are relative to `folder`.
pub(super) fn si_value(section: &str, key: &str, value: &Value, folder: &Path) -> Option<SiValue> {
    if let Ok(Some(UncertainValue { place, input, .. })) = uncertain_value(section, key, None, value, folder) {
        return Some(SiValue { number: input.central(), std: Some(input.marginal().std()), unit: place.key.unit });
    }
    if let Some(number) = percentage(section, key, value) {
        return Some(SiValue { number, std: None, unit: "" });
    }
    let of_key = find(section, key, value).and_then(|(key, _)| Some((parse(key, value).ok()?, key.unit)));
    let (number, unit) = of_key.or_else(|| Dimension::parse_any(value.as_str()?))?;
    Some(SiValue { number, std: None, unit })
}

/// Returns whether a value that may be uncertain has the distribution of a file of samples.
pub(super) fn has_samples(section: &str, name: &str, value: &Value) -> bool {
    let Ok(Some(Stated { distribution, .. })) = Stated::read(value, true) else { return false };
    let is_uncertain = find(section, name, distribution.example()).is_some();
    is_uncertain && matches!(distribution, StatedDistribution::Samples(_))
}

/// Returns the uncertain value at a key, if the value is one.
pub(super) fn uncertain_value(
    section: &str,
    name: &str,
    element: Option<usize>,
    value: &Value,
    folder: &Path,
) -> Result<Option<UncertainValue>, String> {
    let is_number = find(section, name, &Value::Boolean(false)).is_some();
    let Some(stated) = Stated::read(value, is_number)? else {
        return refuse_other_forms(section, name, value).map(|()| None);
    };
    let (key, access) = find(section, name, stated.distribution.example())
        .ok_or("this key is a setting of the computation and cannot be uncertain; state one value")?;
    if !key.percentage && value.to_string().contains('%') {
        return Err(format!("{value} has a percentage; state numbers"));
    }
    let place = Place { key, access: Some(access), element };
    let marginal = marginal(key, &stated.distribution, folder)?;
    let input = UncertainInput::new(&place.name(), marginal, stated.unknown)
        .and_then(|input| truncated(input, key))
        .map_err(|error| error.to_string())?;
    Ok(Some(UncertainValue { place, written: value.clone(), input }))
}

/// Refuses a text that seems to state an uncertain value in another form.
fn refuse_other_forms(section: &str, name: &str, value: &Value) -> Result<(), String> {
    const OTHERS: [&str; 5] = ["unknown", "±", "..", "–", "?"];
    let (Value::String(text), Some((key, _))) = (value, find(section, name, value)) else { return Ok(()) };
    if parse(key, value).is_ok() {
        return Ok(());
    }
    if let Some(range) = hyphenated_range(text) {
        return Err(format!("`{text}` is no value; write the range as \"{range}\""));
    }
    if !OTHERS.iter().any(|mark| text.contains(mark)) {
        return Ok(());
    }
    Err(format!(
        "`{text}` is no value; state one, or `mean ± standard deviation`, `low .. high`, or {{ uniform = [low, high], unknown = true }}"
    ))
}

/// Returns the number that a percentage such as `"3 %"` states at a key of a number without unit.
pub(super) fn percentage(section: &str, name: &str, value: &Value) -> Option<f64> {
    find(section, name, &Value::Float(0.0)).filter(|(key, _)| key.unit.is_empty() && key.percentage)?;
    crate::quantity::percentage(value.as_str()?)
}

/// Truncates a distribution to the possible values of an input.
fn truncated(input: UncertainInput, key: &Key) -> Result<UncertainInput, InputError> {
    key.bounds.map_or(Ok(input.clone()), |bounds| input.truncated(bounds.low, bounds.high))
}

/// Returns a stated distribution in SI.
fn marginal(key: &Key, stated: &StatedDistribution, folder: &Path) -> Result<Marginal, String> {
    let number = |value: &Value| parse(key, value);
    let plain = |value: &Value| match value {
        Value::Float(number) => Ok(*number),
        Value::Integer(number) => Ok(*number as f64),
        other => Err(format!("{other} is not a number")),
    };
    let distribution = match stated {
        StatedDistribution::Normal([mean, std]) => Marginal::normal(number(mean)?, number(std)?),
        StatedDistribution::Lognormal([median, sigma]) => {
            let median = number(median)?;
            if median <= 0.0 {
                return Err(format!("the median of a lognormal distribution is positive, found {median}"));
            }
            Marginal::lognormal(median.ln(), plain(sigma)?, 0.0)
        }
        StatedDistribution::Uniform([low, high]) => Marginal::beta(1.0, 1.0, number(low)?, number(high)?),
        StatedDistribution::Triangular([low, mode, high]) => {
            Marginal::triangular(number(low)?, number(mode)?, number(high)?)
        }
        StatedDistribution::Beta([a, b, low, high]) => {
            Marginal::beta(plain(a)?, plain(b)?, number(low)?, number(high)?)
        }
        StatedDistribution::Samples(file) => Marginal::empirical(samples_of_file(key, &folder.join(file))?),
    };
    distribution.map_err(|error| error.to_string())
}

/// Reads the text of a file of samples of a key.
#[cfg(fuzzing)]
pub fn read_samples(section: &str, name: &str, text: &str) -> Option<UncertainInput> {
    let (key, _) = find(section, name, &Value::Boolean(false))?;
    let marginal = Marginal::empirical(samples(key, text, Path::new("samples.csv")).ok()?).ok()?;
    truncated(UncertainInput::new(name, marginal, false).ok()?, key).ok()
}

/// Reads the samples of a CSV file.
fn samples_of_file(key: &Key, file: &Path) -> Result<Vec<f64>, String> {
    let text = read_text(file).map_err(|error| format!("{}: {}", file.display(), refusal(&error)))?;
    samples(key, &text, file)
}

/// Reads samples from the first column of the text of a CSV file: quantities with units, or numbers in SI. A first line that does not begin
/// with a number names the columns. Errors name `file`.
fn samples(key: &Key, text: &str, file: &Path) -> Result<Vec<f64>, String> {
    let text = text.trim_start_matches('\u{feff}');
    // Where another separator is used, a comma separates no columns.
    let is_separated = text.lines().any(|line| !line.trim_start().starts_with('#') && line.contains([';', '\t']));
    let separators: &[char] = if is_separated { &[';', '\t'] } else { &[','] };
    let begins_with_number = |cell: &str| cell.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    let (mut values, mut columns) = (Vec::new(), 1);
    // A line with a decimal comma, and whether another line has none.
    let (mut comma, mut other) = (None, false);
    for (index, line) in text.lines().enumerate() {
        let mut cells = line.split(separators).map(|cell| cell.trim().trim_matches('"'));
        let cell = cells.next().unwrap_or("");
        if cell.is_empty() || cell.starts_with('#') {
            continue;
        }
        if values.is_empty() && !begins_with_number(cell) {
            columns = 1 + cells.count();
            continue;
        }
        let wrong = |reason: String| format!("{}:{}: {reason}", file.display(), index + 1);
        if cell.contains(',') {
            return Err(wrong(format!("`{cell}` may have a decimal comma; write numbers with a decimal point")));
        }
        let value = match cell.parse() {
            Ok(number) => number,
            Err(_) => parse(key, &Value::String(cell.into())).map_err(wrong)?,
        };
        if !f64::is_finite(value) {
            return Err(wrong(format!("`{cell}` is not a number")));
        }
        let is_integer = cell.parse::<i64>().is_ok();
        let fraction = cells.next().filter(|cell| cell.starts_with(|c: char| c.is_ascii_digit()));
        if columns == 1 && is_integer && line.contains(',') && fraction.is_some() && cells.next().is_none() {
            comma = comma.or(Some((index + 1, line)));
        } else {
            other |= !is_integer;
        }
        values.push(value);
    }
    match comma.filter(|_| !other) {
        Some((index, line)) => Err(format!(
            "{}:{index}: `{}` may have a decimal comma; write numbers with a decimal point, or name two columns in the first line",
            file.display(),
            line.trim(),
        )),
        None => Ok(values),
    }
}
