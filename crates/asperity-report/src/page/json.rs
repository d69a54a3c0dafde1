//! Reading `results.json` and `provenance.json`: whatever is absent or `null` is simply not there.

use serde_json::Value;

use crate::format::{Dimension, significant};

/// Key of the 95 % interval of `key`: `x_interval`, also before a unit suffix or without it.
fn interval_keys(key: &str) -> [String; 3] {
    let (name, _) = Dimension::of_key(key);
    [format!("{key}_interval"), format!("{name}_interval{}", &key[name.len()..]), format!("{name}_interval")]
}

/// The interval `[low, high]` that belongs to a number of `entry`.
pub(crate) fn interval(entry: &Value, key: &str) -> Option<(f64, f64)> {
    interval_keys(key).iter().find_map(|key| Some((entry[key][0].as_f64()?, entry[key][1].as_f64()?)))
}

/// A number of `entry` with its unit and its interval, or a dash.
pub(super) fn shown(entry: &Value, key: &str) -> String {
    match entry[key].as_f64() {
        Some(value) => Dimension::of_key(key).1.show_interval(value, interval(entry, key)),
        None => "–".into(),
    }
}

/// A whole number, a number without unit, a word, or a dash.
pub(crate) fn plain(value: &Value) -> String {
    match value {
        Value::Null => "–".into(),
        Value::Bool(true) => "yes".into(),
        Value::Bool(false) => "no".into(),
        Value::Number(number) if number.is_f64() => number.as_f64().map_or_else(String::new, |v| significant(v, 5)),
        Value::Number(number) => number.to_string(),
        Value::String(text) => text.clone(),
        Value::Array(items) if items.len() <= 12 && items.iter().any(Value::is_object) => {
            items.iter().map(plain).collect::<Vec<_>>().join("; ")
        }
        Value::Array(items) if items.len() <= 12 => items.iter().map(plain).collect::<Vec<_>>().join(", "),
        Value::Array(items) => format!("{} values", items.len()),
        Value::Object(_) => flattened(value).iter().map(|(k, v)| format!("{k} = {v}")).collect::<Vec<_>>().join(", "),
    }
}

/// Every leaf of an object as (name, value with unit), nested names joined by a dot; intervals go with their number and
/// warnings are shown elsewhere.
pub(super) fn flattened(value: &Value) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    flatten("", value, &mut rows);
    rows
}

fn flatten(prefix: &str, value: &Value, rows: &mut Vec<(String, String)>) {
    let Value::Object(entries) = value else { return };
    for (key, entry) in entries {
        if key == "warnings" || key.contains("_interval") {
            continue;
        }
        let name = |key: &str| {
            let words = key.replace("karhunen_loeve", "Karhunen–Loève").replace("hopf", "Hopf").replace('_', " ");
            if prefix.is_empty() { words } else { format!("{prefix} · {words}") }
        };
        match entry {
            Value::Object(_) => flatten(&name(key), entry, rows),
            Value::Number(_) => {
                let (short, dimension) = Dimension::of_key(key);
                if dimension == Dimension::None {
                    let limits = interval(value, key).map(|(low, high)| crate::format::show_range(low, high));
                    rows.push((
                        name(key),
                        [Some(plain(entry)), limits].into_iter().flatten().collect::<Vec<_>>().join(" "),
                    ));
                } else {
                    rows.push((name(short), shown(value, key)));
                }
            }
            _ => rows.push((name(key), plain(entry))),
        }
    }
}

/// The warnings of the study and of its stages.
pub(super) fn warnings(results: &Value) -> Vec<String> {
    let stages = ["surface", "pressure", "friction", "vibration"].map(|stage| &results[stage]);
    std::iter::once(results).chain(stages).filter_map(|part| part["warnings"].as_array()).flatten().map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn intervals_are_found_before_and_after_the_unit() {
        let entry =
            json!({"length_m": 2.5e-4, "length_interval_m": [2e-4, 3e-4], "mean": 0.2, "mean_interval": [0.1, 0.3]});
        assert_eq!(interval(&entry, "length_m"), Some((2e-4, 3e-4)));
        assert_eq!(interval(&entry, "mean"), Some((0.1, 0.3)));
        assert_eq!(interval(&json!({"mean_interval": [null, 0.3]}), "mean"), None);
        assert_eq!(shown(&entry, "length_m").replace('\u{a0}', " "), "250 µm [200, 300]");
        assert_eq!(shown(&entry, "absent"), "–");
    }

    #[test]
    fn nested_objects_become_rows_with_units() {
        let value = json!({"modes": 101, "covariance": {"model": "exponential", "length_x_m": 2e-5}, "x": null});
        let rows = flattened(&value);
        assert!(rows.contains(&("covariance · length x".into(), "20\u{a0}µm".into())));
        assert!(rows.contains(&("modes".into(), "101".into())));
        assert!(rows.contains(&("x".into(), "–".into())));
    }
}
