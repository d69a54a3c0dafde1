//! JSON Schema of study files.

use asperity_results::keys::{Key, RANGES, SPREADS};
use asperity_results::tidy;
use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{Schema, json_schema};
use serde_json::{Map, Value, json};

use crate::quantity::{Dimension, NUMBER_PATTERN};
use crate::study::StudyFile;
use crate::study::uncertain::numbers;

/// Returns the JSON Schema of study files, for editors and for programs that write studies.
///
/// It has every key that [`StudyFile::parse`] reads, with its type, unit, default and description. It does not have the conditions
/// that [`StudyFile::check`] checks: bounds of numbers, and keys that depend on each other. For programs that write studies, `x-unit` is the
/// SI unit of a quantity, and `x-expected` names the possible values of an input. Its version of JSON Schema is draft-07, which editors of TOML
/// support.
pub fn study_schema() -> Schema {
    let settings = SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    let settings = settings.with_transform(tidy).with_transform(without_null);
    let mut schema = settings.into_generator().into_root_schema_for::<StudyFile>();
    schema.insert("$id".into(), "urn:asperity:study".into());
    schema.insert("title".into(), "Study file of asperity".into());
    let mut definitions = Map::new();
    for (key, _) in numbers() {
        let name = definition_name(key);
        let place = format!("/properties/{}/properties/{}", key.section, key.name);
        if let Some(value) = schema.pointer_mut(&place) {
            allow(value, &json!({ "$ref": format!("#/definitions/{name}") }));
            if let Some(bounds) = key.bounds {
                value["x-expected"] = bounds.expected.into();
            }
        }
        definitions.entry(name).or_insert_with(|| uncertain_value(key).into());
    }
    schema.insert("definitions".into(), definitions.into());
    schema
}

/// Removes `null`, which TOML lacks.
fn without_null(schema: &mut Schema) {
    let is_null = |value: &Value| value.get("type").is_some_and(|kind| kind == "null");
    if let Some(Value::Array(kinds)) = schema.get_mut("type") {
        kinds.retain(|kind| kind != "null");
        if let [kind] = &mut kinds[..] {
            let kind = kind.take();
            schema.insert("type".into(), kind);
        }
    }
    if let Some(Value::Array(forms)) = schema.get_mut("anyOf") {
        forms.retain(|form| !is_null(form));
        if let [Value::Object(form)] = &mut forms[..] {
            let form = std::mem::take(form);
            schema.remove("anyOf");
            form.into_iter().for_each(|(key, value)| {
                let object = schema.ensure_object();
                object.entry(key).or_insert(value);
            });
        }
    }
    if schema.get("default").is_some_and(Value::is_null) {
        schema.remove("default");
    }
    transform_subschemas(&mut without_null, schema);
}

/// Adds a form to a value, or to the elements of a list.
fn allow(value: &mut Value, form: &Value) {
    let Value::Object(object) = value else { return };
    if let Some(Value::Array(forms)) = object.get_mut("anyOf") {
        forms.iter_mut().filter(|form| form["type"] == "array").for_each(|list| allow(list, form));
        if !forms.contains(form) {
            forms.push(form.clone());
        }
    } else if let Some(elements) = object.get_mut("items") {
        allow(elements, form);
    } else {
        let (notes, own) = std::mem::take(object)
            .into_iter()
            .partition::<Map<_, _>, _>(|(key, _)| matches!(key.as_str(), "description" | "default" | "examples"));
        *object = notes;
        object.insert("anyOf".into(), json!([own, form]));
    }
}

/// Returns the name of the definition of the uncertain values of a key.
fn definition_name(key: &Key) -> String {
    let number = if key.percentage { "number" } else { "number_without_percentage" };
    let name = Dimension::of_unit(key.unit).map_or(number, |dimension| dimension.name);
    format!("uncertain_{}", name.replace(' ', "_"))
}

/// Returns the schema of the uncertain values of a key.
fn uncertain_value(key: &Key) -> Schema {
    let number = json!({ "type": "number" });
    let list = |values: &[&Value], description: &str| json!({ "type": "array", "items": values, "minItems": values.len(), "maxItems": values.len(), "description": description });
    let units = Dimension::of_unit(key.unit).map(Dimension::unit_pattern);
    let quantity = |units: &str| json!({ "type": "string", "pattern": format!(r"^\s*{NUMBER_PATTERN}\s*{units}\s*$") });
    let percentage = json!({
        "type": "string",
        "pattern": format!(r"^\s*{NUMBER_PATTERN}\s*%\s*$"),
        "description": "The number as a percentage.",
    });
    let value = units.as_deref().map_or_else(
        || match key.percentage {
            true => json!({ "anyOf": [number, percentage] }),
            false => number.clone(),
        },
        quantity,
    );
    // Units of the first and of the second number; a standard deviation may be a percentage of the mean.
    let (percent, pair) = (r"\s*%".to_owned(), |left: &str, right: &str| [left.to_owned(), right.to_owned()]);
    let (ranges, spreads) = match &units {
        None if !key.percentage => (vec![pair("", "")], vec![pair("", "")]),
        None => {
            let [plain, both] = [pair("", ""), pair(&percent, &percent)];
            ([plain.clone(), pair(r"(\s*%)?", &percent)].to_vec(), vec![plain, both])
        }
        Some(units) => {
            let [own, relative] = [r"\s*U?", r"\s*U"].map(|pattern| pattern.replace('U', units));
            let of_mean = pair(&relative, &percent);
            ([pair(&own, &relative)].to_vec(), vec![pair(&own, &relative), of_mean])
        }
    };
    let text = |separators: &[&str], units: &[[String; 2]]| {
        let separator = separators.join("|").replace('.', r"\.").replace('+', r"\+");
        let forms = units
            .iter()
            .map(|[left, right]| format!(r"{NUMBER_PATTERN}{left}\s*({separator})\s*{NUMBER_PATTERN}{right}"));
        format!(r"^\s*({})\s*$", forms.collect::<Vec<_>>().join("|"))
    };
    let distributions = [
        ("normal", list(&[&value, &value], "Mean and standard deviation.")),
        ("lognormal", list(&[&value, &number], "Median, and standard deviation of the natural logarithm.")),
        ("uniform", list(&[&value, &value], "Lower and upper end.")),
        ("triangular", list(&[&value, &value, &value], "Lower end, mode and upper end.")),
        ("beta", list(&[&number, &number, &value, &value], "Shapes a and b, lower and upper end.")),
        ("samples", json!({ "type": "string", "description": "CSV file of samples, relative to the study file." })),
    ];
    let unknown = json!({
        "type": "boolean",
        "description": "Whether it is one value that is not known, not a value that varies from part to part.",
    });
    let one_of: Vec<Value> = distributions.iter().map(|(name, _)| json!({ "required": [name] })).collect();
    let names = distributions.into_iter().chain([("unknown", unknown)]);
    let properties: Map<String, Value> = names.map(|(name, form)| (name.to_owned(), form)).collect();
    let mut schema = json_schema!({
        "anyOf": [
            {
                "type": "string",
                "pattern": text(&SPREADS, &spreads),
                "description": "Uncertain value: mean ± standard deviation of a normal distribution.",
            },
            {
                "type": "string",
                "pattern": text(&RANGES, &ranges),
                "description": "Uncertain value: lower .. upper end of a uniform distribution.",
            },
            {
                "type": "object",
                "properties": properties,
                "additionalProperties": false,
                "oneOf": one_of,
                "description": "Uncertain value: a distribution by name.",
            },
        ]
    });
    if let (None, true, Some(forms)) = (units, key.percentage, schema.get_mut("anyOf").and_then(Value::as_array_mut)) {
        forms.push(percentage);
    }
    schema
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Returns the sections of the schema by name, those inside others as `outer.inner`.
    fn sections(name: &str, section: &Value, found: &mut Vec<(String, Value)>) {
        for (key, value) in section["properties"].as_object().unwrap() {
            if value["properties"].is_object() {
                sections([name, key].join(".").trim_start_matches('.'), value, found);
            }
        }
        found.push((name.to_owned(), section.clone()));
    }

    #[test]
    fn every_section_has_the_keys_that_the_parser_knows_and_no_other() {
        let mut found = Vec::new();
        sections("", &study_schema().to_value(), &mut found);
        assert!(found.iter().any(|(name, _)| name == "friction.uncertainty"));
        for (name, section) in found {
            let header = if name.is_empty() { String::new() } else { format!("[{name}]\n") };
            // The error of an unknown key lists all keys.
            let error = StudyFile::parse(&format!("{header}colour = 1\n"), "study.toml").unwrap_err().message;
            let known = error.split_once("(known: ").unwrap_or_else(|| panic!("{name}: {error}")).1;
            let known: BTreeSet<&str> = known.trim_end_matches(')').split(", ").collect();
            let own: BTreeSet<&str> = section["properties"].as_object().unwrap().keys().map(String::as_str).collect();
            assert_eq!(own, known, "[{name}]");
            assert_eq!(section["additionalProperties"], false, "[{name}]");
            for (key, value) in section["properties"].as_object().unwrap() {
                let text = value["description"].as_str().unwrap_or_else(|| panic!("[{name}] {key}: no description"));
                assert!(!text.contains("[`") && !text.contains("crate::"), "[{name}] {key}: {text}");
            }
        }
    }

    #[test]
    fn every_value_that_may_be_uncertain_has_the_forms_of_its_unit() {
        let schema = study_schema().to_value();
        for (key, _) in numbers() {
            let value = &schema["properties"][key.section]["properties"][key.name];
            let form = json!({ "$ref": format!("#/definitions/{}", definition_name(key)) });
            let has_form = |value: &Value| value["anyOf"].as_array().is_some_and(|forms| forms.contains(&form));
            assert!(has_form(value) || has_form(&value["items"]), "{} {}: {value}", key.section, key.name);
        }
        let certain = &schema["properties"]["friction"]["properties"]["realisations"];
        assert_eq!(certain["type"], "integer", "{certain}");
    }

    #[test]
    fn the_schema_has_no_null() {
        let text = study_schema().to_value().to_string();
        assert!(!text.contains("null"), "{text}");
    }
}
