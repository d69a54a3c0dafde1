//! Tables of the page from `results.json`.

use serde_json::Value;

use super::json::{flattened, interval, plain, shown};
use super::{DataTable, method_name, parameters, random_surface};
use crate::format::{Dimension, significant, with_error};
use crate::{Input, Run};

/// `surface`: parameters with their meaning, the laws of the heights, then the random surface.
pub(super) fn surface(run: &Run) -> Vec<DataTable> {
    let surface = &run.results["surface"];
    let mut rest = surface.clone();
    if let Value::Object(entries) = &mut rest {
        entries.retain(|key, _| !parameters::belongs(key));
    }
    let random = random_surface::table(&rest);
    [Some(parameters::table(surface)), parameters::scans(surface), parameters::laws(run), Some(random)]
        .into_iter()
        .flatten()
        .collect()
}

/// `pressure`: one row per method.
pub(super) fn pressure(pressure: &Value) -> Vec<DataTable> {
    let cell = |value: &Value, digits| value.as_f64().map_or("–".into(), |v| significant(v, digits));
    let rows = list(&pressure["methods"])
        .iter()
        .map(|method| {
            let probability = match (method["contact_probability"].as_f64(), method["contact_probability_se"].as_f64())
            {
                (Some(value), Some(error)) => with_error(value, error),
                _ => shown(method, "contact_probability"),
            };
            vec![
                method_name(method["name"].as_str().unwrap_or("–")),
                plain(&method["fine_solves"]),
                probability,
                cell(&method["ks_distance"], 3),
                cell(&method["wasserstein_1_over_std"], 3),
            ]
        })
        .collect();
    let reference = pressure["reference_samples"].as_u64().map_or(String::new(), |n| format!(" of {n} samples"));
    let caption = format!("Methods for the law of the pressure; distances are taken from the reference{reference}");
    let headers = ["Method", "Fine solves", "P(contact) ± s.e.", "KS distance", "W₁ / std"];
    vec![DataTable::new(&caption, &headers, rows, "results.json").without_empty_columns()]
}

/// How a level is named: by percentile, or by the mean pressure that defines it.
pub(super) fn level_name(level: &Value) -> String {
    match (level["percentile"].as_f64(), level["mean_pressure_pa"].as_f64()) {
        (Some(percentile), _) => format!("{} %", significant(percentile, 3)),
        (None, Some(pressure)) => format!("at {}", Dimension::Pressure.show(pressure)),
        _ => "–".into(),
    }
}

/// The level that feeds the vibration: the one marked, else the one given by mean pressure, else the first.
pub(super) fn leading_level(friction: &Value) -> Option<&Value> {
    let levels = list(&friction["levels"]);
    levels
        .iter()
        .find(|level| level["leading"] == Value::Bool(true))
        .or_else(|| levels.iter().find(|level| level["percentile"].is_null() && level["mean_pressure_pa"].is_f64()))
        .or(levels.first())
}

/// `friction`: one row per level.
pub(super) fn friction(friction: &Value) -> Vec<DataTable> {
    let rows = list(&friction["levels"])
        .iter()
        .map(|level| {
            // The length of the exponential fit contains the window; it never stands without saying so.
            let length = match level["window_only"] == Value::Bool(true) {
                true => format!("{} (window only)", shown(level, "correlation_length_m")),
                false => shown(level, "correlation_length_m"),
            };
            vec![
                level_name(level),
                shown(level, "penetration_m"),
                shown(level, "mean_pressure_pa"),
                shown(level, "mean"),
                shown(level, "std"),
                shown(level, "coefficient_of_variation"),
                shown(level, "skewness"),
                shown(level, "excess_kurtosis"),
                length,
                marginal(&level["marginal"]),
            ]
        })
        .collect();
    let window = friction["window_m"]
        .as_f64()
        .map_or(String::new(), |w| format!(" for a window of {}", Dimension::Length.show(w)));
    let caption = format!("Friction coefficient by level{window}; brackets hold 95 % intervals");
    let headers = [
        "Level",
        "Penetration",
        "Mean pressure",
        "Mean μ",
        "Std",
        "CoV",
        "Skewness",
        "Excess kurtosis",
        "ℓ of μ",
        "Marginal law",
    ];
    let source = "tables/friction_levels.csv";
    vec![DataTable::new(&caption, &headers, rows, source).without_empty_columns()]
}

fn marginal(marginal: &Value) -> String {
    match marginal["name"].as_str() {
        Some(name) if marginal["parameters"].is_null() => name.replace('_', " "),
        Some(name) => format!("{} ({})", name.replace('_', " "), plain(&marginal["parameters"])),
        None => "–".into(),
    }
}

/// `vibration`: limits and cycle, cycles against damping, re-attachment law.
pub(super) fn vibration(run: &Run) -> Vec<DataTable> {
    let vibration = &run.results["vibration"];
    let mut tables = Vec::new();
    let mut scalars = vibration.clone();
    if let Value::Object(entries) = &mut scalars {
        entries.remove("paper");
        entries.remove("area");
    }
    let rows = flattened(&scalars).into_iter().map(|(key, value)| vec![key, value]).collect();
    tables.push(DataTable::new("Without roughness", &["Property", "Value"], rows, "results.json"));

    let mut counts: Vec<Vec<String>> = Vec::new();
    for entry in list(&vibration["area"]["damping"]).iter().chain(list(&vibration["paper"]["damping"])) {
        let damping = entry["damping_ratio"].as_f64().map_or("–".into(), |v| significant(v, 4));
        if counts.iter().any(|row| row[0] == damping) {
            continue;
        }
        let mut row = vec![damping, shown(entry, "cycles_deterministic")];
        for upscaling in ["area", "paper"] {
            let found = at_damping(&vibration[upscaling], entry["damping_ratio"].as_f64());
            row.push(found.map_or("–".into(), |entry| shown(entry, "cycles_mean")));
            row.push(found.map_or("–".into(), |entry| difference(run, upscaling, entry).1));
        }
        counts.push(row);
    }
    let headers = ["ζ", "M deterministic", "M, “area”", "lost, “area”", "M, “paper”", "lost, “paper”"];
    let caption =
        "Cycles M and cycles lost, M(det) − mean M, by damping ratio and upscaling; brackets hold 95 % intervals";
    tables.push(DataTable::new(caption, &headers, counts, "tables/cycles_over_damping.csv").without_empty_columns());

    let rows = ["area", "paper"]
        .iter()
        .filter(|upscaling| vibration[**upscaling].is_object())
        .map(|upscaling| {
            let part = &vibration[*upscaling];
            let law = &part["reattachment"];
            vec![
                format!("“{upscaling}”"),
                shown(part, "friction_std"),
                match (law["mean"].as_f64(), law["std"].as_f64()) {
                    (Some(mean), Some(std)) => with_error(mean, std),
                    _ => shown(law, "mean"),
                },
                shown(law, "skewness"),
                shown(law, "excess_kurtosis"),
                shown(law, "normality_p"),
            ]
        })
        .collect();
    let headers = ["Upscaling", "Std of μ", "X: mean ± std", "Skewness", "Excess kurtosis", "p (normality)"];
    tables.push(
        DataTable::new("Re-attachment points by upscaling", &headers, rows, "results.json").without_empty_columns(),
    );
    tables
}

/// The entry of an upscaling at a damping ratio.
fn at_damping(upscaling: &Value, damping: Option<f64>) -> Option<&Value> {
    let damping = damping?;
    list(&upscaling["damping"]).iter().find(|entry| entry["damping_ratio"].as_f64() == Some(damping))
}

/// The interval of the lost cycles, from the results or from the table of the sweep, and the number as text.
pub(super) fn difference(run: &Run, upscaling: &str, entry: &Value) -> (Option<(f64, f64)>, String) {
    let limits = interval(entry, "difference_mean").or_else(|| interval(entry, "difference")).or_else(|| {
        let table = run.tables.get("cycles_over_damping")?;
        let damping = entry["damping_ratio"].as_f64()?;
        let row = table.column("damping_ratio")?.iter().position(|v| (v - damping).abs() <= 1e-9 * damping.abs())?;
        let end = |end: &str| table.column(&format!("{upscaling}_difference_{end}")).map(|values| values[row]);
        Some((end("low")?, end("high")?)).filter(|(low, high)| low.is_finite() && high.is_finite())
    });
    let text = match entry["difference_mean"].as_f64() {
        Some(value) => Dimension::None.show_interval(value, limits),
        None => "–".into(),
    };
    (limits, text)
}

/// The inputs, one table per section in the order of appearance.
pub(super) fn inputs(inputs: &[Input]) -> Vec<DataTable> {
    let mut tables: Vec<DataTable> = Vec::new();
    for Input { section, key, value } in inputs {
        let row = vec![key.clone(), value.clone()];
        match tables.iter_mut().find(|table| table.caption == *section) {
            Some(table) => table.rows.push(row),
            None => tables.push(DataTable::new(section, &["Key", "Value"], vec![row], "study.toml")),
        }
    }
    tables
}

/// The items of an array; none when it is absent.
pub(super) fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}
