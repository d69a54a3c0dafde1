//! Keys, JSON Schema and round trips of `results.json` and `comparison.json`.
#![expect(clippy::unwrap_used, reason = "a test stops where results are not what they must be")]

mod example;

use std::collections::BTreeSet;

use asperity_results::{
    Comparison, DistributionResult, MeasuredSurface, Results, SCHEMA_VERSION, ScanOfPart, SurfaceResult, VerdictResult,
    results_schema,
};
use serde_json::Value;

/// Returns the results of one scan, and those of a part of two scans with uncertain parameters and a stated counterface.
fn both() -> [Results; 2] {
    let one = example::results();
    let mut two = one.clone();
    let scans = ["left.x3p", "right.x3p"].map(|file| ScanOfPart { file: file.into(), statistics: example::scan() });
    two.surface.as_mut().unwrap().measured = example::part(scans.into());
    two.friction.as_mut().unwrap().uncertainty = Some(example::uncertainty(6));
    let turning_points = example::verdict::turning_points();
    two.verdict = Some(VerdictResult { turning_points, ..example::verdict::verdict() });
    two.mode_coupling = Some(example::mode_coupling());
    two.counterface = Some(SurfaceResult {
        marginal: DistributionResult { name: "normal".into(), ..DistributionResult::default() },
        ..SurfaceResult::default()
    });
    [one, two]
}

/// Collects the paths of all keys; paths of list items do not contain the index.
fn keys(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| keys(item, path, found)),
        Value::Object(entries) => {
            for (key, entry) in entries {
                let path = format!("{path}/{key}");
                keys(entry, &path, found);
                found.insert(path);
            }
        }
        _ => {}
    }
}

#[test]
fn results_are_read_back_as_they_were_written() {
    for results in both() {
        let text = serde_json::to_string(&results).unwrap();
        assert_eq!(serde_json::from_str::<Results>(&text).unwrap(), results);
        let value = serde_json::to_value(&results).unwrap();
        assert_eq!(serde_json::from_value::<Results>(value).unwrap(), results);
    }
}

#[test]
fn every_key_is_in_the_list_and_every_listed_key_is_written() {
    let results = both().map(|results| serde_json::to_value(results).unwrap());
    let comparison = [serde_json::to_value(example::comparison()).unwrap()];
    let files = [
        ("results.json", &results[..], include_str!("keys.txt")),
        ("comparison.json", &comparison, include_str!("comparison_keys.txt")),
    ];
    for (file, values, listed) in files {
        let mut found = BTreeSet::new();
        values.iter().for_each(|value| keys(value, "", &mut found));
        let listed: BTreeSet<String> = listed.lines().map(str::to_owned).collect();
        let added: Vec<_> = found.difference(&listed).collect();
        let removed: Vec<_> = listed.difference(&found).collect();
        assert!(
            added.is_empty() && removed.is_empty(),
            "keys of {file} changed: state it in CHANGELOG.md, and raise SCHEMA_VERSION if a key of results.json was renamed or \
             removed. added: {added:#?}, removed: {removed:#?}"
        );
    }
}

/// Collects the schemas of a key of an object, or of the objects of a list, in all forms that a schema allows.
fn of_key<'s>(root: &'s Value, schema: &'s Value, key: &str, found: &mut Vec<&'s Value>) {
    if let Some(place) = schema["$ref"].as_str() {
        of_key(root, root.pointer(place.trim_start_matches('#')).unwrap(), key, found);
    }
    schema["anyOf"].as_array().into_iter().flatten().for_each(|form| of_key(root, form, key, found));
    if schema["items"].is_object() {
        of_key(root, &schema["items"], key, found);
    }
    found.extend(schema["properties"].get(key));
    // Names that are data.
    found.extend(Some(&schema["additionalProperties"]).filter(|value| value.is_object()));
    // Patterns have the form `^(one|two)ending$`.
    for (pattern, value) in schema["patternProperties"].as_object().into_iter().flatten() {
        let (names, ending) = pattern.trim_start_matches("^(").trim_end_matches('$').split_once(')').unwrap();
        if key.strip_suffix(ending).is_some_and(|name| names.split('|').any(|own| own == name)) {
            found.push(value);
        }
    }
}

#[test]
fn the_schema_has_every_key_of_the_list() {
    let schema = results_schema().to_value();
    for path in include_str!("keys.txt").lines() {
        let mut schemas = vec![&schema["$defs"]["Results"]];
        for key in path.split('/').skip(1) {
            let mut inner = Vec::new();
            schemas.iter().for_each(|outer| of_key(&schema, outer, key, &mut inner));
            schemas = inner;
        }
        assert!(!schemas.is_empty(), "{path}");
    }
    let mut found = Vec::new();
    of_key(&schema, &schema["$defs"]["Results"]["properties"]["surface"], "colour", &mut found);
    assert!(found.is_empty(), "{found:?}");
    for kind in ["Results", "CampaignResults"] {
        assert_eq!(schema["$defs"][kind]["properties"]["schema_version"]["const"], SCHEMA_VERSION);
        assert_eq!(schema["$defs"][kind]["additionalProperties"], false);
    }
    assert_eq!(schema["anyOf"].as_array().unwrap().len(), 2);
    assert_eq!(schema["$defs"]["MemberResult"]["additionalProperties"], false);
    assert!(schema["$defs"]["MemberResult"]["properties"]["damping_margin"].is_object());
}

#[test]
fn every_key_of_the_schema_has_a_description_for_its_reader() {
    let schema = results_schema().to_value();
    let definitions = schema["$defs"].as_object().unwrap();
    for (key, value) in definitions.values().filter_map(|part| part["properties"].as_object()).flatten() {
        let text = value["description"].as_str().unwrap_or_else(|| panic!("{key} has no description"));
        let of_rust = ["[`", "crate::", "`None`", "\n"].iter().any(|word| text.contains(word));
        assert!(!of_rust && text.ends_with('.'), "{key}: {text}");
    }
}

#[test]
fn a_comparison_is_read_back_as_it_was_written() {
    let comparison = example::comparison();
    let text = serde_json::to_string(&comparison).unwrap();
    let read: Comparison = serde_json::from_str(&text).unwrap();
    assert_eq!(read, comparison);
    assert_eq!(serde_json::to_string(&read).unwrap(), text);
    // Statistics keep the order of the table, which is not alphabetical.
    assert!(text.find("\"Ssk\":{").unwrap() < text.find("\"Sdq\":{").unwrap());
    assert_eq!(read.outside().collect::<Vec<_>>(), ["Sdq"]);
    assert_eq!(read.curves_inside_share(), Some(0.9));
    assert_eq!(Comparison::default().curves_inside_share(), None);
    for place in ["", "/model", "/twins/Sdq", "/curves/acf_x"] {
        let mut changed = serde_json::to_value(&comparison).unwrap();
        changed.pointer_mut(place).unwrap()["colour"] = "red".into();
        assert!(serde_json::from_value::<Comparison>(changed).is_err(), "{place}");
    }
}

#[test]
fn the_version_of_the_keys_comes_first() {
    let text = serde_json::to_string(&Results::default()).unwrap();
    assert!(text.starts_with(&format!("{{\"schema_version\":{SCHEMA_VERSION},\"seed\":")), "{text}");
}

#[test]
fn an_unknown_or_incomplete_key_is_an_error() {
    let value = serde_json::to_value(example::results()).unwrap();
    assert!(serde_json::from_value::<Results>(value.clone()).is_ok());
    for place in
        ["", "/surface", "/surface/covariance", "/pressure", "/pressure/methods/0", "/friction/levels/0", "/vibration"]
    {
        let mut changed = value.clone();
        changed.pointer_mut(place).unwrap()["colour"] = "red".into();
        assert!(serde_json::from_value::<Results>(changed).is_err(), "{place}");
    }
    for (place, key) in [("/surface", "Sq_m"), ("/surface", "Sq_m_se"), ("/vibration", "area"), ("/friction", "levels")]
    {
        let mut changed = value.clone();
        changed.pointer_mut(place).unwrap().as_object_mut().unwrap().remove(key);
        assert!(serde_json::from_value::<Results>(changed).is_err(), "{place}/{key}");
    }
}

#[test]
fn a_study_without_a_scan_has_no_statistics_and_no_key_of_them() {
    let mut results = example::results();
    results.surface.as_mut().unwrap().measured = MeasuredSurface::Stated {};
    let text = serde_json::to_string(&results).unwrap();
    assert!(text.contains("\"surface\":{\"covariance\""), "{text:.200}");
    let read: Results = serde_json::from_str(&text).unwrap();
    assert_eq!(read, results);
    let surface = read.surface.unwrap();
    assert!(surface.scan().is_none() && surface.part().is_none());
}
