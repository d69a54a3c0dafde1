//! Tables of answers, from the fields and the documentation of their types.

use std::collections::BTreeMap;

use asperity_results::choice::Choice;
use asperity_results::{Answer, DistributionResult, FieldKind, LabelledField, MotionKind, Pair};
use serde_json::Value;

use crate::cells::{self, DASH};
use crate::format::{Dimension, count, significant};
use crate::page::data_table::DataTable;
use crate::run::RESULTS;
use crate::words::{distribution_name, in_words, kind_in_words, meaning};

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
    std::iter::once(vec!["distribution".into(), distribution_name(fit)]).chain(parameters).collect()
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
                let named = |name: &str| match key.as_str() {
                    "kind_shares" => word("kind", name),
                    _ => in_words(Dimension::of_key(name).0),
                };
                names.into_iter().filter_map(|name| row(&named(name), cells(name))).collect()
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
        for (place, field) in fields.iter().enumerate() {
            let key = &field.key;
            // `interval` alone is that of the field before it.
            let before = || place.checked_sub(1).map(|before| fields[before].key.as_str());
            let interval = key.strip_suffix("_interval").or_else(|| before().filter(|_| key == "interval"));
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
        (Value::String(text), _) => word(key, text),
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

/// Returns the word of a value for readers; texts and names of files stay as they are.
fn word(key: &str, text: &str) -> String {
    match (key, text) {
        ("kind", _) => MotionKind::from_name(text).map_or_else(|_| in_words(text), |kind| kind_in_words(kind).into()),
        ("motion", "cycle") => "limit cycle".into(),
        ("motion", "steady") => "steady sliding".into(),
        ("motion", "locked") => "self-locking".into(),
        ("motion", "irregular") => "not periodic".into(),
        ("file", _) => text.into(),
        _ if text.contains(' ') => text.into(),
        _ => in_words(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_results::{
        CovarianceResult, CutoffPoint, DampingResult, FinerPitch, LevelResult, MethodEntry, ModeCouplingResult,
        ReturnLevelResult, ScanCutoff, ScanOfPart, SurfaceStatistics, UncertainResponse, VibrationResult,
    };

    /// Returns the keys of the entries of a type with those of their intervals and standard errors.
    fn entries<T: Answer>() -> Vec<[String; 3]> {
        let fields = T::fields();
        Entry::all(&fields)
            .into_iter()
            .map(|entry| [entry.field.key.clone(), entry.interval, entry.standard_error])
            .collect()
    }

    #[test]
    fn uncertainties_belong_to_the_number_of_their_name() {
        let methods = entries::<MethodEntry>();
        let mean = methods.iter().find(|[key, ..]| key == "mean_pa").unwrap();
        assert_eq!(mean[1..], ["mean_interval", "mean_se_pa"]);
        assert!(methods.iter().any(|[key, ..]| key == "mean_bias_pa"));
        let levels = entries::<ReturnLevelResult>();
        assert_eq!(levels.iter().map(|[key, ..]| key.as_str()).collect::<Vec<_>>(), ["distance_m", "mu"]);
        assert_eq!(levels[1][1], "interval");
        // The interval of the moment is not that of its standard deviation.
        let responses = entries::<UncertainResponse>();
        let std = responses.iter().find(|[key, ..]| key == "std").unwrap();
        assert_ne!(std[1], "interval");
    }

    #[test]
    fn names_of_files_and_sentences_stay_as_they_are() {
        let scan = ScanOfPart { file: "left_scan_01.x3p".into(), ..ScanOfPart::default() };
        let table = DataTable::listed("", &[scan], |key| ["file", "nx"].contains(&key));
        assert_eq!(table.rows, [["left_scan_01.x3p", "0"]]);
        assert_eq!(
            (word("kind", "none"), word("model", "self_affine")),
            ("steady sliding".into(), "self-affine".into())
        );
    }

    #[test]
    fn labels_hold_no_code() {
        fn plain(fields: &[LabelledField]) {
            for entry in Entry::all(fields) {
                let label = &entry.field.label;
                // Symbols such as ζ_c have indices.
                let is_key = label.as_bytes().windows(2).any(|pair| pair[0].is_ascii_lowercase() && pair[1] == b'_');
                assert!(!is_key, "{}: {label}", entry.field.key);
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
