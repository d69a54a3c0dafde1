//! Tables of answers, from the fields and the documentation of their types.

use std::collections::BTreeMap;

use asperity_results::{Answer, DistributionResult, FieldKind, LabelledField, Pair};
use serde_json::Value;

use crate::cells::{self, DASH};
use crate::format::{Dimension, count};
use crate::page::data_table::DataTable;
use crate::run::RESULTS;
use crate::words::{distribution_name, in_words, meaning};

impl DataTable {
    /// Returns the table of an answer: its entries, then those of the answers within it. Undefined entries are left
    /// out, and those whose key, such as `cycle.period`, `keep` refuses.
    pub(super) fn of<T: Answer>(caption: &str, answer: &T, keep: impl Fn(&str) -> bool) -> Self {
        let rows = rows(&fields_of::<T>(keep), &[&answer.json()]);
        Self::new(caption, &["Property", "Value"], rows, RESULTS)
    }

    /// Returns the table of several answers of one type, with a column for each, below its name.
    pub(super) fn beside<T: Answer>(caption: &str, answers: &[(String, &T)], keep: impl Fn(&str) -> bool) -> Self {
        let values: Vec<Value> = answers.iter().map(|(_, answer)| answer.json()).collect();
        let rows = rows(&fields_of::<T>(keep), &values.iter().collect::<Vec<_>>());
        let names = answers.iter().map(|(name, _)| name.as_str());
        Self::new(caption, &std::iter::once("Property").chain(names).collect::<Vec<_>>(), rows, RESULTS)
    }

    /// Returns the table of a list of answers, with a row for each and a column for each of their entries.
    pub(super) fn listed<T: Answer>(caption: &str, answers: &[T], keep: impl Fn(&str) -> bool) -> Self {
        let fields = fields_of::<T>(keep);
        let entries = Entry::all(&fields);
        let headers: Vec<&str> = entries.iter().map(|entry| entry.field.label.as_str()).collect();
        let cells = |answer: &T| {
            let object = answer.json();
            entries.iter().map(|entry| entry.cell(&object)).collect()
        };
        Self::new(caption, &headers, answers.iter().map(cells).collect(), RESULTS).without_empty_columns()
    }
}

/// Keeps all entries.
pub(super) fn all(_: &str) -> bool {
    true
}

/// Returns name and parameters of a distribution, of values with a dimension, with the intervals that are known.
pub(super) fn distribution(
    fit: &DistributionResult,
    intervals: &BTreeMap<String, Option<Pair>>,
    dimension: Dimension,
) -> Vec<Vec<String>> {
    let parameters = fit.parameters.iter().map(|(key, value)| {
        let (meaning, has_unit) = meaning(&fit.name, key);
        let dimension = if has_unit { dimension } else { Dimension::None };
        vec![meaning, cells::shown(dimension, *value, intervals.get(key).copied().flatten())]
    });
    std::iter::once(vec!["Distribution".into(), distribution_name(fit)]).chain(parameters).collect()
}

fn fields_of<T: Answer>(keep: impl Fn(&str) -> bool) -> Vec<LabelledField> {
    kept(T::fields(), "", &keep)
}

/// Returns the fields whose key, with those of the answers around it, `keep` accepts.
fn kept(fields: Vec<LabelledField>, path: &str, keep: &impl Fn(&str) -> bool) -> Vec<LabelledField> {
    let of = |LabelledField { key, label, kind }: LabelledField| {
        let path = format!("{path}{key}");
        let kind = match kind {
            FieldKind::Answer(inner) => FieldKind::Answer(kept(inner, &format!("{path}."), keep)),
            other => other,
        };
        keep(&path).then_some(LabelledField { key, label, kind })
    };
    fields.into_iter().filter_map(of).collect()
}

/// Returns a row for each entry that one of the answers, given as JSON objects, defines.
fn rows(fields: &[LabelledField], answers: &[&Value]) -> Vec<Vec<String>> {
    let row = |name: &str, cells: Vec<String>| {
        let known = cells.iter().any(|cell| cell != DASH);
        known.then(|| std::iter::once(name.to_owned()).chain(cells).collect())
    };
    let mut rows: Vec<Vec<String>> = Entry::all(fields)
        .iter()
        .filter_map(|entry| row(&entry.field.label, answers.iter().map(|answer| entry.cell(answer)).collect()))
        .collect();
    for LabelledField { key, label, kind } in fields {
        let own: Vec<&Value> = answers.iter().map(|answer| &answer[key]).collect();
        let inner = match kind {
            FieldKind::Answer(inner) => self::rows(inner, &own),
            FieldKind::Map => {
                let mut names: Vec<&String> =
                    own.iter().filter_map(|map| map.as_object()).flat_map(serde_json::Map::keys).collect();
                names.sort();
                names.dedup();
                let cells = |name: &String| own.iter().map(|map| shown(name, &map[name], None, None)).collect();
                names.into_iter().filter_map(|name| row(&in_words(Dimension::of_key(name).0), cells(name))).collect()
            }
            _ => Vec::new(),
        };
        if !inner.is_empty() {
            rows.push(vec![label.clone()]);
            rows.extend(inner);
        }
    }
    rows
}

/// A field that is an entry of a table, with the keys of its interval and of its standard error.
pub(super) struct Entry<'a> {
    pub(super) field: &'a LabelledField,
    interval: String,
    standard_error: String,
}

impl<'a> Entry<'a> {
    /// Returns the entries of fields. An interval or a standard error belongs to the number with its name, otherwise to the one that
    /// is declared before it if that begins with its name.
    pub(super) fn all(fields: &'a [LabelledField]) -> Vec<Self> {
        let mut entries: Vec<Self> = Vec::new();
        for field in fields {
            let key = &field.key;
            let interval = key.strip_suffix("_interval").or((key == "interval").then_some(""));
            let error = Dimension::of_key(key).0.strip_suffix("_se");
            match interval.or(error).and_then(|stem| owner(&mut entries, stem)) {
                Some(owner) if interval.is_some() => owner.interval.clone_from(key),
                Some(owner) => owner.standard_error.clone_from(key),
                None if matches!(field.kind, FieldKind::Answer(_) | FieldKind::Map | FieldKind::List) => {}
                None => entries.push(Self::of(field)),
            }
        }
        entries
    }

    /// Returns the entry of a field whose interval and standard error have its key before their endings.
    fn of(field: &'a LabelledField) -> Self {
        let [interval, standard_error] = ["interval", "se"].map(|ending| format!("{}_{ending}", field.key));
        Self { field, interval, standard_error }
    }

    /// Returns the text of the entry in an answer, given as a JSON object.
    pub(super) fn cell(&self, answer: &Value) -> String {
        let [value, interval, error] = [&self.field.key, &self.interval, &self.standard_error].map(|key| &answer[key]);
        shown(&self.field.key, value, pair(interval), error.as_f64())
    }
}

/// Returns the number to which an interval or standard error of this name belongs.
fn owner<'a, 'b>(entries: &'b mut [Entry<'a>], stem: &str) -> Option<&'b mut Entry<'a>> {
    let has = |entry: &Entry<'_>| entry.field.key == stem || Dimension::of_key(&entry.field.key).0 == stem;
    let place = entries.iter().position(has).or(entries.len().checked_sub(1))?;
    let owner = entries.get_mut(place)?;
    (owner.field.kind == FieldKind::Number && owner.field.key.starts_with(stem)).then_some(owner)
}

fn pair(value: &Value) -> Option<Pair> {
    Some([value[0].as_f64()?, value[1].as_f64()?])
}

/// Returns the text of a value: a number with the unit of its key and its uncertainty, a word, a decision, or a dash.
pub(super) fn shown(key: &str, value: &Value, interval: Option<Pair>, standard_error: Option<f64>) -> String {
    let (_, dimension) = Dimension::of_key(key);
    match (value, value.as_f64()) {
        (Value::Bool(holds), _) => if *holds { "yes" } else { "no" }.to_owned(),
        (Value::String(text), _) => in_words(text),
        (Value::Array(values), _) => {
            values.iter().map(|value| shown(key, value, None, None)).collect::<Vec<_>>().join(", ")
        }
        (Value::Number(number), _) if number.is_u64() => count(value.as_u64().unwrap_or_default() as usize),
        (_, Some(number)) => match (interval, standard_error) {
            (Some(ends), _) => dimension.show_interval(number, Some(ends.into())),
            (None, Some(error)) => dimension.show_error(number, error),
            // A wavelength is easier to judge than a wavenumber.
            (None, None) if dimension == Dimension::Wavenumber && number > 0.0 => {
                let wavelength = Dimension::Length.show_short(std::f64::consts::TAU / number);
                format!("{} ({wavelength})", dimension.show_short(number))
            }
            (None, None) => dimension.show(number),
        },
        _ => DASH.to_owned(),
    }
}
