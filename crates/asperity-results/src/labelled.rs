//! The fields of an answer with their labels: what its tables and its CSV columns are made of.
//!
//! A label is the first sentence of a field's documentation, and the unit is the suffix of its name, so a number is described once,
//! where it is declared.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::unit::split_unit;

/// An answer: a type of `results.json`.
pub trait Answer {
    /// Returns the fields in the order of their declaration, with those of the types that `#[serde(flatten)]` includes.
    fn fields() -> Vec<LabelledField>;

    /// Returns the answer as in `results.json`.
    fn json(&self) -> Value;
}

impl<T: Serialize + JsonSchema> Answer for T {
    fn fields() -> Vec<LabelledField> {
        let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
        let schema = settings.into_generator().into_root_schema_for::<T>();
        LabelledField::of_properties(schema.get("properties"))
    }

    fn json(&self) -> Value {
        serde_json::to_value(self).unwrap_or_default()
    }
}

/// A field of an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelledField {
    /// Name in `results.json`.
    pub key: String,
    /// First sentence of the documentation, up to a colon or semicolon.
    pub label: String,
    /// What the field holds.
    pub kind: FieldKind,
    /// Key of its 95 % interval. An answer may have none.
    pub interval: String,
    /// Key of its standard error. An answer may have none.
    pub standard_error: String,
    /// Words for readers by the name of a choice: of the value, or of the keys of a map.
    pub words: BTreeMap<String, String>,
}

/// What a field holds.
#[derive(Debug, Clone, PartialEq)]
pub enum FieldKind {
    /// A number, or none.
    Number,
    /// Several numbers, such as an interval.
    Numbers,
    /// A word or a decision.
    Word,
    /// Numbers by name.
    Map,
    /// An answer within the answer.
    Answer(Vec<LabelledField>),
    /// A list or map of other values, which is a table of its own.
    List,
}

impl LabelledField {
    fn of_properties(properties: Option<&Value>) -> Vec<Self> {
        let of = |(key, schema): (&String, &Value)| Self {
            key: key.clone(),
            label: label(schema.get("description").and_then(Value::as_str).unwrap_or(key)),
            kind: FieldKind::of(schema),
            interval: format!("{key}_interval"),
            standard_error: format!("{key}_se"),
            words: words(schema),
        };
        let mut fields: Vec<Self> =
            properties.and_then(Value::as_object).into_iter().flat_map(Map::iter).map(of).collect();
        pair(&mut fields);
        fields
    }

    /// Returns whether the field is the interval or the standard error of one of these fields.
    pub fn belongs_to(&self, fields: &[Self]) -> bool {
        fields.iter().any(|number| [&number.interval, &number.standard_error].contains(&&self.key))
    }
}

/// Names the intervals and standard errors of the numbers. One belongs to the number with its name, otherwise to the number before it if
/// that begins with its name.
fn pair(fields: &mut [LabelledField]) {
    let mut before: Option<usize> = None;
    for place in 0..fields.len() {
        let key = fields[place].key.clone();
        let is_number = |field: &LabelledField| field.kind == FieldKind::Number;
        let interval = key.strip_suffix("interval").map(|stem| stem.trim_end_matches('_'));
        let owner = interval.or_else(|| split_unit(&key).0.strip_suffix("_se")).and_then(|stem| {
            let is_named = |field: &LabelledField| field.key == stem || split_unit(&field.key).0 == stem;
            let is_free = |field: &LabelledField| fields.iter().all(|other| other.key != field.interval);
            let begins = |field: &LabelledField| field.key.starts_with(stem) && is_free(field);
            let named = fields[..place].iter().position(is_named).filter(|owner| is_number(&fields[*owner]));
            named.or(before.filter(|before| begins(&fields[*before])))
        });
        match (owner, interval) {
            (Some(owner), Some(_)) => fields[owner].interval = key,
            (Some(owner), None) => fields[owner].standard_error = key,
            (None, _) if is_number(&fields[place]) => before = Some(place),
            (None, _) => {}
        }
    }
}

impl FieldKind {
    fn of(schema: &Value) -> Self {
        let is = |name: &str| match schema.get("type") {
            Some(Value::Array(kinds)) => kinds.iter().any(|kind| kind == name),
            Some(kind) => kind == name,
            None => false,
        };
        let options = ["anyOf", "allOf"].iter().find_map(|key| schema.get(key)?.as_array());
        if let Some(properties) = schema.get("properties") {
            return Self::Answer(LabelledField::of_properties(Some(properties)));
        }
        if let Some(option) = options.and_then(|options| options.first()) {
            return Self::of(option);
        }
        match (schema.get("items").map(Self::of), schema.get("additionalProperties").map(Self::of)) {
            (Some(Self::Number), _) => Self::Numbers,
            (_, Some(Self::Number)) => Self::Map,
            (None, None) if is("number") || is("integer") => Self::Number,
            (None, None) => Self::Word,
            _ => Self::List,
        }
    }
}

/// Returns the words for readers by the name of a choice: of a value, or of the names of a map.
fn words(schema: &Value) -> BTreeMap<String, String> {
    let options = ["anyOf", "allOf"].iter().find_map(|key| schema.get(key)?.as_array()?.first());
    if let Some(inner) = options.or_else(|| schema.get("propertyNames")) {
        return words(inner);
    }
    let word = |option: &Value| Some((option["const"].as_str()?.to_owned(), option["title"].as_str()?.to_owned()));
    schema.get("oneOf").and_then(Value::as_array).into_iter().flatten().filter_map(word).collect()
}

/// Returns the first sentence of a text, up to a colon or semicolon, without code marks.
fn label(text: &str) -> String {
    let end = ["; ", ": ", ". "].iter().filter_map(|mark| text.find(mark)).min().unwrap_or(text.len());
    text[..end].trim_end_matches('.').replace('`', "").split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        DampingResult, MethodEntry, ModeCouplingResult, MotionResult, Pair, ReturnLevelResult, Table, UncertainResponse,
    };

    #[derive(Serialize, JsonSchema)]
    struct Inner {
        /// Period.
        period_s: Option<f64>,
    }

    #[derive(Serialize, JsonSchema)]
    struct Outer {
        /// Ratio of two
        /// lengths, at most 0.5; `null` if it is not known.
        ratio: f64,
        /// 95 % interval of `ratio`.
        ratio_interval: Option<Pair>,
        /// Number of samples.
        samples: usize,
        /// Whether it holds.
        holds: bool,
        /// The cycle: an answer of its own.
        cycle: Option<Inner>,
        /// Rows of another table.
        rows: Vec<Inner>,
    }

    #[test]
    fn labels_are_the_first_sentences_of_the_documentation() {
        let fields = Outer::fields();
        let labels: Vec<&str> = fields.iter().map(|field| field.label.as_str()).collect();
        let wanted = ["Ratio of two lengths, at most 0.5", "95 % interval of ratio", "Number of samples"];
        assert_eq!(labels[..3], wanted);
        assert_eq!(labels[3..], ["Whether it holds", "The cycle", "Rows of another table"]);
        let kinds: Vec<FieldKind> = fields.into_iter().map(|field| field.kind).collect();
        let cycle = FieldKind::Answer(Inner::fields());
        let (number, word) = (FieldKind::Number, FieldKind::Word);
        assert_eq!(kinds, [number.clone(), FieldKind::Numbers, number, word, cycle, FieldKind::List]);
    }

    #[test]
    fn uncertainties_belong_to_the_number_of_their_name() {
        fn keys<T: Answer>(key: &str) -> [String; 2] {
            let field = T::fields().into_iter().find(|field| field.key == key).unwrap();
            [field.interval, field.standard_error]
        }
        assert_eq!(keys::<MethodEntry>("mean_pa"), ["mean_interval", "mean_se_pa"]);
        assert_eq!(keys::<MethodEntry>("mean_bias_pa"), ["mean_bias_pa_interval", "mean_bias_pa_se"]);
        assert_eq!(keys::<ReturnLevelResult>("mu")[0], "interval");
        assert_eq!(keys::<DampingResult>("cycles_mean"), ["cycles_mean_interval", "cycles_se"]);
        assert_eq!(keys::<DampingResult>("difference_mean")[0], "difference_interval");
        // The interval of the moment is not that of its standard deviation.
        assert_eq!(keys::<UncertainResponse>("std")[0], "std_interval");
        let fields = UncertainResponse::fields();
        let alone: Vec<&str> = fields.iter().filter(|f| !f.belongs_to(&fields)).map(|f| f.key.as_str()).collect();
        assert!(alone.contains(&"interval") && !alone.contains(&"std_interval"), "{alone:?}");
    }

    #[test]
    fn choices_have_words_for_readers() {
        let words = |fields: Vec<LabelledField>, key: &str| fields.into_iter().find(|f| f.key == key).unwrap().words;
        assert_eq!(words(ModeCouplingResult::fields(), "motion")["locked"], "self-locking");
        assert_eq!(words(MotionResult::fields(), "kind_shares")["none"], "steady sliding");
        assert!(words(DampingResult::fields(), "cycles_mean").is_empty());
    }

    #[test]
    fn answers_are_rows_whose_columns_are_their_numbers() {
        let of = |ratio, cycle| Outer { ratio, ratio_interval: None, samples: 3, holds: true, cycle, rows: Vec::new() };
        let first = Outer { ratio_interval: Some([0.1, 0.4]), ..of(0.25, Some(Inner { period_s: Some(2.0) })) };
        let table = Table::of(&[first, of(1.0 / 3.0, None)]);
        let csv = String::from_utf8(table.to_csv().unwrap()).unwrap();
        let wanted = "ratio,ratio_low,ratio_high,samples,cycle_period_s\n\
                      0.25,0.1,0.4,3.0,2.0\n0.3333333333333333,,,3.0,\n";
        assert_eq!(csv, wanted);
    }
}
