//! The fields of an answer with their labels: what its tables and its CSV columns are made of.
//!
//! A label is the first sentence of a field's documentation, and the unit is the suffix of its name, so a number is described once,
//! where it is declared.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde_json::{Map, Value};

/// An answer: a type of `results.json`.
pub trait Answer {
    /// Returns the fields in the order of their declaration, without those that `#[serde(flatten)]` adds.
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
        };
        properties.and_then(Value::as_object).into_iter().flat_map(Map::iter).map(of).collect()
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

/// Returns the first sentence of a text, up to a colon or semicolon, without code marks.
fn label(text: &str) -> String {
    let end = ["; ", ": ", ". "].iter().filter_map(|mark| text.find(mark)).min().unwrap_or(text.len());
    text[..end].trim_end_matches('.').replace('`', "").split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pair, Table};

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
        let period = LabelledField { key: "period_s".into(), label: "Period".into(), kind: FieldKind::Number };
        let kinds: Vec<FieldKind> = fields.into_iter().map(|field| field.kind).collect();
        let cycle = FieldKind::Answer(vec![period]);
        let (number, word) = (FieldKind::Number, FieldKind::Word);
        assert_eq!(kinds, [number.clone(), FieldKind::Numbers, number, word, cycle, FieldKind::List]);
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
