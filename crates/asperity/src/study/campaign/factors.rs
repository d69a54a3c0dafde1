//! Factors of a campaign: lists, grids and samples of values, and scans.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, de};
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use crate::chaos::{Design, SamplingMethod};
use crate::study::parse::{line_at, read_with_uncertain_values};
use crate::study::result::{InputValue, VariedKey};
use crate::study::uncertain::{SiValue, UncertainValue, si_value};
use crate::study::{StudyFileError, sentence};

/// Stream of the samples.
const STREAM: &str = "study/campaign";
/// Largest number of members.
pub(super) const MOST: usize = 100_000;
/// Key whose value the scans replace.
pub(super) const SCAN: &str = "surface.file";

/// Campaign file as written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CampaignFile {
    /// Study that the members vary, relative to the campaign file.
    pub(super) study: PathBuf,
    /// Seed in place of the study's.
    pub(super) seed: Option<u64>,
    /// Pattern of the scans, relative to the campaign file.
    #[serde(default, deserialize_with = "pattern")]
    pub(super) scans: Option<String>,
    /// Lists whose combinations are the members.
    #[serde(default)]
    values: Table,
    /// Lists of equal length that go together.
    #[serde(default)]
    zip: Table,
    /// Number of samples, and the distributions from which they are drawn.
    #[serde(default)]
    sample: Table,
}

fn pattern<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    match Value::deserialize(deserializer)? {
        Value::String(pattern) => Ok(Some(pattern)),
        found => Err(de::Error::custom(format!("scans: found {found}, expected one pattern such as \"lot-*/*.x3p\""))),
    }
}

/// Key that differs between members.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Key {
    /// Name, `section.key`.
    pub(super) name: String,
    /// Its line in the campaign file.
    pub(super) line: usize,
}

/// Choices that combine with those of the other factors.
#[derive(Debug, Clone)]
pub(super) enum Factor {
    /// Scans in place of that of the study: names, relative to the campaign file.
    Scans(Vec<String>),
    /// Lists of values of keys that go together, one list per key.
    Listed(Vec<(Key, Vec<Value>)>),
    /// Points of a Latin hypercube.
    Sampled(Vec<(Key, UncertainValue)>, Design),
}

impl Factor {
    /// Returns the number of choices.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Scans(scans) => scans.len(),
            Self::Listed(lists) => lists.first().map_or(0, |(_, values)| values.len()),
            Self::Sampled(_, design) => design.samples(),
        }
    }

    /// Returns the keys; none of scans.
    pub(super) fn keys(&self) -> Vec<&Key> {
        match self {
            Self::Scans(_) => Vec::new(),
            Self::Listed(lists) => lists.iter().map(|(key, _)| key).collect(),
            Self::Sampled(inputs, _) => inputs.iter().map(|(key, _)| key).collect(),
        }
    }

    /// Returns the values of the keys for a choice, as a study file states them.
    pub(super) fn values(&self, choice: usize) -> Vec<Value> {
        match self {
            Self::Scans(_) => Vec::new(),
            Self::Listed(lists) => lists.iter().map(|(_, values)| values[choice].clone()).collect(),
            Self::Sampled(inputs, design) => {
                let point = design.xi(choice);
                inputs.iter().zip(point).map(|((_, input), xi)| input.stated_at(xi)).collect()
            }
        }
    }

    /// Returns the columns of the keys, `folder` being the folder of the study.
    pub(super) fn columns(&self, folder: &Path) -> Vec<Column> {
        let values: Vec<Vec<Value>> = (0..self.len()).map(|choice| self.values(choice)).collect();
        let of_key = |(place, key): (usize, &Key)| {
            let own: Vec<Value> = values.iter().map(|choice| choice[place].clone()).collect();
            columns(&key.name, &own, self.is_sampled(), folder)
        };
        self.keys().into_iter().enumerate().flat_map(of_key).collect()
    }

    pub(super) fn is_sampled(&self) -> bool {
        matches!(self, Self::Sampled(..))
    }
}

/// Writes the value of a key, `section.key`, into a study.
pub(super) fn set(study: &mut Table, name: &str, value: Value) {
    let (mut table, mut name) = (study, name);
    while let Some((section, rest)) = name.split_once('.') {
        let inner = table.entry(section).or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(inner) = inner else { return };
        (table, name) = (inner, rest);
    }
    table.insert(name.into(), value);
}

/// Column of the table of the members: a cell for each choice of a factor.
#[derive(Debug, Clone)]
pub(super) struct Column {
    pub(super) key: VariedKey,
    pub(super) cells: Vec<InputValue>,
}

/// Returns the columns of a key: of lists of numbers one for each component, otherwise one; with uncertain values another one of their
/// standard deviations.
fn columns(key: &str, values: &[Value], sampled: bool, folder: &Path) -> Vec<Column> {
    let component = |value: &Value, place: usize| match value {
        Value::Array(list) => list.get(place).cloned(),
        // One value holds for all components.
        value => Some(value.clone()),
    };
    let of_place = |place: usize| {
        let own = values.iter().map(|value| component(value, place)).collect::<Option<Vec<Value>>>()?;
        numbers(&format!("{key}[{place}]"), &own, sampled, folder)
    };
    let found = match values.iter().filter_map(Value::as_array).map(Vec::len).max() {
        None | Some(0) => numbers(key, values, sampled, folder),
        Some(length) => {
            (0..length).map(of_place).collect::<Option<Vec<_>>>().map(|columns| columns.into_iter().flatten().collect())
        }
    };
    found.unwrap_or_else(|| {
        let key = VariedKey { key: key.into(), unit: String::new(), sampled };
        vec![Column { key, cells: values.iter().map(as_stated).collect() }]
    })
}

/// Returns the numbers in SI that a key states, and texts as stated; `None` if the numbers have different units, or if a component of a
/// list has a text.
fn numbers(name: &str, values: &[Value], sampled: bool, folder: &Path) -> Option<Vec<Column>> {
    let (section, key) = name.split_once('.').unwrap_or(("", name));
    let key = key.split_once('[').map_or(key, |(key, _)| key);
    let found: Vec<Option<SiValue>> = values.iter().map(|value| si_value(section, key, value, folder)).collect();
    let unit = found.iter().flatten().next().map_or("", |value| value.unit);
    let is_component = name.contains('[');
    if found.iter().flatten().any(|value| value.unit != unit) || (is_component && found.iter().any(Option::is_none)) {
        return None;
    }
    let column = |name: String, cells| {
        let key = VariedKey { key: name, unit: unit.into(), sampled };
        Column { key, cells }
    };
    let cells = values.iter().zip(&found).map(|(value, number)| {
        number.as_ref().map_or_else(|| as_stated(value), |value| InputValue::Number(value.number))
    });
    let mut columns = vec![column(name.into(), cells.collect())];
    if found.iter().flatten().any(|value| value.std.is_some()) {
        let std = |value: &Option<SiValue>| value.as_ref().and_then(|value| value.std).unwrap_or(0.0);
        let cells = found.iter().map(|value| InputValue::Number(std(value))).collect();
        columns.push(column(format!("{name}_std"), cells));
    }
    Some(columns)
}

fn as_stated(value: &Value) -> InputValue {
    match value {
        Value::Float(number) => InputValue::Number(*number),
        Value::Integer(number) => InputValue::Integer(*number),
        Value::String(text) => InputValue::Name(text.clone()),
        other => InputValue::Name(other.to_string()),
    }
}

/// Reader of a campaign file, which names lines in errors.
pub(super) struct Reader<'a> {
    pub(super) text: &'a str,
    /// Name of the file in errors.
    pub(super) name: &'a str,
}

impl Reader<'_> {
    pub(super) fn file(&self) -> Result<CampaignFile, StudyFileError> {
        StudyFileError::read(self.text, self.name)
    }

    pub(super) fn error(&self, line: usize, message: impl Into<String>) -> StudyFileError {
        StudyFileError { file: self.name.into(), line, message: message.into(), in_data: false }
    }

    /// Returns the place of the value of a top-level key in the text.
    pub(super) fn span(&self, key: &str) -> Option<Range<usize>> {
        let root = DeTable::parse(self.text).ok()?;
        Some(root.get_ref().iter().find(|(name, _)| name.get_ref() == key)?.1.span())
    }

    pub(super) fn line(&self, key: &str) -> usize {
        self.span(key).map_or(1, |span| line_at(self.text, span.start))
    }

    /// Returns the keys of a section in their order, with their values. A key may be quoted, `"vibration.mass"`, or dotted.
    fn entries(&self, section: &str, values: &Table) -> Vec<(Key, Value)> {
        let Ok(root) = DeTable::parse(self.text) else { return Vec::new() };
        let Some(DeValue::Table(spans)) = root.get_ref().get(section).map(Spanned::get_ref) else { return Vec::new() };
        let mut found = Vec::new();
        for (name, span) in spans {
            let outer = name.get_ref().as_ref();
            let Some(value) = values.get(outer) else { continue };
            match (value, span.get_ref()) {
                (Value::Table(inner), DeValue::Table(spans)) if !outer.contains('.') => {
                    for key in spans.keys() {
                        let Some(value) = inner.get(key.get_ref().as_ref()) else { continue };
                        found.push((key.span().start, format!("{outer}.{}", key.get_ref()), value.clone()));
                    }
                }
                _ => found.push((name.span().start, outer.to_owned(), value.clone())),
            }
        }
        found.sort_by_key(|(start, ..)| *start);
        let key = |start, name| Key { name, line: line_at(self.text, start) };
        found.into_iter().map(|(start, name, value)| (key(start, name), value)).collect()
    }

    /// Returns the keys of a section with their lists of values.
    fn lists(&self, section: &str, values: &Table) -> Result<Vec<(Key, Vec<Value>)>, StudyFileError> {
        let entries = self.entries(section, values).into_iter();
        let lists = entries.map(|(key, value)| match value {
            Value::Array(list) if !list.is_empty() => Ok((key, list)),
            found => {
                Err(self.error(key.line, format!("[{section}] {}: found {found}, expected a list of values", key.name)))
            }
        });
        lists.collect()
    }

    /// Returns the factors of the file, the one that changes slowest first: scans, lists, lists that go together, samples. `study` is the
    /// study that the members vary, `study_name` names its file, and `seed` is that of the samples.
    pub(super) fn factors(
        &self,
        file: &CampaignFile,
        folder: &Path,
        study: &Table,
        study_name: &str,
        seed: u64,
    ) -> Result<Vec<Factor>, StudyFileError> {
        let mut factors = Vec::new();
        if let Some(pattern) = &file.scans {
            factors.push(Factor::Scans(self.scans(pattern, folder)?));
        }
        factors.extend(self.lists("values", &file.values)?.into_iter().map(|list| Factor::Listed(vec![list])));
        let zip = self.lists("zip", &file.zip)?;
        if let Some((first, values)) = zip.first() {
            if let Some((key, other)) = zip.iter().find(|(_, other)| other.len() != values.len()) {
                let other = sentence::count(other.len(), "value", "values");
                let message = format!("[zip] {} has {other}, {} has {}", key.name, first.name, values.len());
                return Err(self.error(key.line, message));
            }
            factors.push(Factor::Listed(zip));
        }
        factors.extend(self.sample(file, study, study_name, seed)?);
        if factors.is_empty() {
            return Err(self.error(1, "nothing differs between members; add `scans`, [values], [zip] or [sample]"));
        }
        let keys: Vec<&Key> = factors.iter().flat_map(Factor::keys).collect();
        for (place, key) in keys.iter().enumerate() {
            if keys[..place].iter().any(|other| other.name == key.name) {
                return Err(self.error(key.line, format!("{} is listed twice", key.name)));
            }
            if key.name == SCAN && file.scans.is_some() {
                return Err(self.error(key.line, format!("{SCAN} and `scans` exclude each other")));
            }
        }
        Ok(factors)
    }

    /// Returns the samples; `None` without distributions.
    fn sample(
        &self,
        file: &CampaignFile,
        study: &Table,
        study_name: &str,
        seed: u64,
    ) -> Result<Option<Factor>, StudyFileError> {
        const COUNT: &str = "count";
        let entries = self.entries("sample", &file.sample);
        if entries.is_empty() {
            return Ok(None);
        }
        let (count, entries): (Vec<_>, Vec<_>) = entries.into_iter().partition(|(key, _)| key.name == COUNT);
        let count = match count.as_slice() {
            [(_, Value::Integer(count))] if (1..=MOST as i64).contains(count) => *count as usize,
            [(key, found)] => {
                let message = format!("[sample] count: found {found}, expected a whole number from 1 to {MOST}");
                return Err(self.error(key.line, message));
            }
            _ => return Err(self.error(self.line("sample"), "[sample] has no `count`, the number of samples")),
        };
        let mut inputs = Vec::new();
        for (key, value) in entries {
            let mut with = study.clone();
            set(&mut with, &key.name, value.clone());
            let text = toml::to_string(&with).map_err(|error| self.error(key.line, error.to_string()))?;
            let read = read_with_uncertain_values(&text, study_name);
            let read =
                read.map_err(|error| StudyFileError { in_data: error.in_data, ..self.error(key.line, error.message) })?;
            let found = read.uncertain.into_iter().find(|input| input.input().name() == key.name);
            let wrong = || self.error(key.line, format!("[sample] {}: {value} is not a distribution", key.name));
            inputs.push((key.clone(), found.ok_or_else(wrong)?));
        }
        if inputs.is_empty() {
            return Err(self.error(self.line("sample"), "[sample] has no distribution"));
        }
        let design = Design::new(SamplingMethod::LatinHypercube, seed, STREAM, count, inputs.len());
        let design = design.map_err(|error| self.error(self.line("sample"), format!("[sample] {error}")))?;
        Ok(Some(Factor::Sampled(inputs, design)))
    }

    /// Returns the files that a pattern matches by name, relative to the campaign file.
    fn scans(&self, pattern: &str, folder: &Path) -> Result<Vec<String>, StudyFileError> {
        let line = self.line("scans");
        let options = glob::MatchOptions { require_literal_leading_dot: true, ..glob::MatchOptions::new() };
        let whole = if Path::new(pattern).is_absolute() {
            pattern.to_owned()
        } else {
            let folder = glob::Pattern::escape(&folder.to_string_lossy());
            format!("{folder}/{pattern}")
        };
        let matches = glob::glob_with(&whole, options).map_err(|error| self.error(line, format!("scans: {error}")))?;
        let in_data = |message: String| StudyFileError { in_data: true, ..self.error(line, message) };
        let mut found = Vec::new();
        for path in matches {
            let path = path.map_err(|error| in_data(format!("scans: {error}")))?;
            // A link to nothing is a member whose scan is missing.
            if path.is_file() || !path.exists() {
                let name = path.strip_prefix(folder).unwrap_or(&path).to_str();
                let name =
                    name.ok_or_else(|| in_data(format!("scans: the name of {} is not Unicode", path.display())))?;
                found.push(name.to_owned());
            }
        }
        if found.is_empty() { Err(in_data(format!("scans: no file matches `{pattern}`"))) } else { Ok(found) }
    }
}
