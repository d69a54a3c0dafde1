//! Tables of answers, from the fields and the documentation of their types.

use std::collections::BTreeMap;

use asperity_results::{Answer, DistributionResult, FieldKind, LabelledField, Pair};
use serde_json::Value;

use crate::cells::{self, DASH};
use crate::format::{Dimension, count, significant};
use crate::page::data_table::DataTable;
use crate::words::{distribution_name, in_words, meaning};

impl DataTable {
    /// Returns the table of an answer: its entries, then those of the answers within it. Undefined entries are left
    /// out, and those whose key, such as `cycle.period`, `keep` refuses.
    pub(super) fn of<T: Answer>(caption: &str, answer: &T, keep: impl Fn(&str) -> bool) -> Self {
        let rows = rows(&fields_of::<T>(keep), &[&answer.json()]);
        Self::new(caption, &["Property", "Value"], rows)
    }

    /// Returns the table of several answers of one type, with a column for each, below its name.
    pub(super) fn beside<T: Answer>(caption: &str, answers: &[(String, &T)], keep: impl Fn(&str) -> bool) -> Self {
        let values: Vec<Value> = answers.iter().map(|(_, answer)| answer.json()).collect();
        let rows = rows(&fields_of::<T>(keep), &values.iter().collect::<Vec<_>>());
        let names = answers.iter().map(|(name, _)| name.as_str());
        Self::new(caption, &std::iter::once("Property").chain(names).collect::<Vec<_>>(), rows)
    }

    /// Returns the table of a list of answers, with a row for each and a column for each of their entries.
    pub(super) fn listed<T: Answer>(caption: &str, answers: &[T], keep: impl Fn(&str) -> bool) -> Self {
        Self::grouped(caption, &[("", answers)], keep)
    }

    /// Returns the table of lists of answers, each below its name.
    pub(super) fn grouped<T: Answer>(caption: &str, groups: &[(&str, &[T])], keep: impl Fn(&str) -> bool) -> Self {
        let fields = fields_of::<T>(keep);
        let headers: Vec<&str> = entries(&fields).map(|entry| entry.label.as_str()).collect();
        let cells = |answer: &T| {
            let object = answer.json();
            entries(&fields).map(|entry| cell(entry, &object)).collect()
        };
        let rows = groups.iter().flat_map(|(name, answers)| {
            let title = (!name.is_empty() && !answers.is_empty()).then(|| vec![(*name).to_owned()]);
            title.into_iter().chain(answers.iter().map(cells))
        });
        Self::new(caption, &headers, rows.collect()).without_empty_columns()
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
    std::iter::once(vec!["distribution".into(), distribution_name(fit)]).chain(parameters).collect()
}

fn fields_of<T: Answer>(keep: impl Fn(&str) -> bool) -> Vec<LabelledField> {
    kept(T::fields(), "", &keep)
}

/// Returns the fields whose key, with those of the answers around it, `keep` accepts.
fn kept(fields: Vec<LabelledField>, path: &str, keep: &impl Fn(&str) -> bool) -> Vec<LabelledField> {
    let of = |mut field: LabelledField| {
        let path = format!("{path}{}", field.key);
        if let FieldKind::Answer(inner) = field.kind {
            field.kind = FieldKind::Answer(kept(inner, &format!("{path}."), keep));
        }
        keep(&path).then_some(field)
    };
    fields.into_iter().filter_map(of).collect()
}

/// Returns a row for each entry that one of the answers, given as JSON objects, defines.
fn rows(fields: &[LabelledField], answers: &[&Value]) -> Vec<Vec<String>> {
    let row = |name: &str, cells: Vec<String>| {
        let known = cells.iter().any(|cell| cell != DASH);
        known.then(|| std::iter::once(name.to_owned()).chain(cells).collect())
    };
    let mut rows: Vec<Vec<String>> = entries(fields)
        .filter_map(|entry| row(&entry.label, answers.iter().map(|answer| cell(entry, answer)).collect()))
        .collect();
    for field in fields {
        let own: Vec<&Value> = answers.iter().map(|answer| &answer[&field.key]).collect();
        let inner = match &field.kind {
            FieldKind::Answer(inner) => self::rows(inner, &own),
            FieldKind::Map => {
                let mut names: Vec<&String> =
                    own.iter().filter_map(|map| map.as_object()).flat_map(serde_json::Map::keys).collect();
                names.sort();
                names.dedup();
                let cells = |name: &String| own.iter().map(|map| shown(name, &map[name], None, None)).collect();
                let named = |name: &str| match field.words.get(name) {
                    Some(words) => words.clone(),
                    None => in_words(Dimension::of_key(name).0),
                };
                names.into_iter().filter_map(|name| row(&named(name), cells(name))).collect()
            }
            _ => Vec::new(),
        };
        if !inner.is_empty() {
            rows.push(vec![field.label.clone()]);
            rows.extend(inner);
        }
    }
    rows
}

/// Returns the fields that are entries of a table: no intervals and standard errors of others, and no answers within the answer.
pub(super) fn entries(fields: &[LabelledField]) -> impl Iterator<Item = &LabelledField> {
    let has_cell = |field: &&LabelledField| {
        matches!(field.kind, FieldKind::Number | FieldKind::Numbers | FieldKind::Word) && !field.belongs_to(fields)
    };
    fields.iter().filter(has_cell)
}

/// Returns the text of an entry in an answer, given as a JSON object.
pub(super) fn cell(entry: &LabelledField, answer: &Value) -> String {
    let [value, interval, error] = [&entry.key, &entry.interval, &entry.standard_error].map(|key| &answer[key]);
    match value.as_str() {
        // Names of files stay as they are.
        Some(text) if entry.key == "file" => text.into(),
        Some(text) => entry.words.get(text).map_or_else(|| word(text), String::clone),
        None => shown(&entry.key, value, pair(interval), error.as_f64()),
    }
}

fn pair(value: &Value) -> Option<Pair> {
    Some([value[0].as_f64()?, value[1].as_f64()?])
}

/// Returns the text of a value: a number with the unit of its key and its uncertainty, a decision, or a dash.
pub(super) fn shown(key: &str, value: &Value, interval: Option<Pair>, standard_error: Option<f64>) -> String {
    let (_, dimension) = Dimension::of_key(key);
    match (value, value.as_f64()) {
        (Value::Bool(holds), _) => if *holds { "yes" } else { "no" }.to_owned(),
        (Value::String(text), _) => word(text),
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
            // The limits of the damping ratio often differ in the last digits only.
            (None, None) if key.ends_with("damping_ratio") => significant(number, 5),
            (None, None) => dimension.show(number),
        },
        _ => DASH.to_owned(),
    }
}

/// Returns a name in words; sentences stay as they are.
fn word(text: &str) -> String {
    if text.contains(' ') { text.into() } else { in_words(text) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_results::{
        CoupledMotion, CovarianceResult, CutoffPoint, DampingResult, FinerPitch, LevelResult, MethodEntry,
        ModeCouplingResult, ScanCutoff, ScanOfPart, SurfaceStatistics, VibrationResult,
    };

    #[test]
    fn names_of_files_and_sentences_stay_as_they_are() {
        let scan = ScanOfPart { file: "left_scan_01.x3p".into(), ..ScanOfPart::default() };
        let table = DataTable::listed("", &[scan], |key| ["file", "nx"].contains(&key));
        assert_eq!(table.rows, [["left_scan_01.x3p", "0"]]);
        let result = ModeCouplingResult { motion: Some(CoupledMotion::Locked), ..ModeCouplingResult::default() };
        let table = DataTable::of("", &result, |key| ["kind", "motion"].contains(&key));
        assert_eq!(
            table.rows.iter().map(|row| row[1].as_str()).collect::<Vec<_>>(),
            ["steady sliding", "self-locking"]
        );
        assert_eq!(word("self_affine"), "self-affine");
    }

    #[test]
    fn labels_hold_no_code() {
        fn plain(fields: &[LabelledField]) {
            for LabelledField { key, label, .. } in entries(fields) {
                // Symbols such as ζ_c have indices.
                let is_key = label.as_bytes().windows(2).any(|pair| pair[0].is_ascii_lowercase() && pair[1] == b'_');
                assert!(!is_key, "{key}: {label}");
            }
            for field in fields {
                if let FieldKind::Answer(inner) = &field.kind {
                    plain(inner);
                }
            }
        }
        let tabled = [
            SurfaceStatistics::fields(),
            CovarianceResult::fields(),
            MethodEntry::fields(),
            LevelResult::fields(),
            CutoffPoint::fields(),
            FinerPitch::fields(),
            ScanCutoff::fields(),
            VibrationResult::fields(),
            DampingResult::fields(),
            ModeCouplingResult::fields(),
        ];
        tabled.iter().for_each(|fields| plain(fields));
    }
}
