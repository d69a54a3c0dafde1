//! Tables of the page from `results.json`.

use serde_json::Value;

use super::json::{interval, plain, shown};
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

/// The methods without an estimate and their reasons as a sentence; empty where every method has one.
pub(super) fn refused_methods(pressure: &Value) -> String {
    let refused: Vec<String> = list(&pressure["methods"])
        .iter()
        .filter_map(|method| {
            Some(format!("{} ({})", method_name(method["name"].as_str()?), method["failure"].as_str()?))
        })
        .collect();
    if refused.is_empty() { String::new() } else { format!("Methods without an estimate: {}.", refused.join("; ")) }
}

/// `pressure`: one row per method that has an estimate, then one per scalar of the whole contact.
pub(super) fn pressure(run: &Run) -> Vec<DataTable> {
    let pressure = &run.results["pressure"];
    let cell = |value: &Value, digits| value.as_f64().map_or("–".into(), |v| significant(v, digits));
    let rows = list(&pressure["methods"])
        .iter()
        .filter(|method| !method["failure"].is_string())
        .map(|method| {
            let probability = match (method["contact_probability"].as_f64(), method["contact_probability_se"].as_f64())
            {
                (Some(value), Some(error)) => with_error(value, error),
                _ => shown(method, "contact_probability"),
            };
            let name = method["name"].as_str().unwrap_or("–");
            let mean = method["mean_pa"].as_f64();
            vec![
                method_name(name),
                plain(&method["fine_solves"]),
                coarse_solves(&method["coarse_solves"]),
                seconds(run, name).map_or("–".into(), |s| Dimension::Time.show_short(s)),
                probability,
                mean.map_or("–".into(), |v| Dimension::Pressure.show_interval(v, interval(method, "mean"))),
                cell(&method["ks_distance"], 3),
                cell(&method["wasserstein_1_over_std"], 3),
            ]
        })
        .collect();
    let reference = pressure["reference_samples"].as_u64().map_or(String::new(), |n| format!(" of {n} samples"));
    let sites = match pressure["sites"].as_u64() {
        Some(sites) if sites > 1 => format!(", each at {sites} sites"),
        _ => String::new(),
    };
    let caption = format!(
        "Methods for the law of the pressure; distances are taken from the reference{reference}{sites}; brackets hold 95 % \
         intervals"
    );
    let headers = [
        "Method",
        "Fine solves",
        "Coarse solves",
        "Wall time",
        "P(contact) ± s.e.",
        "Mean pressure",
        "KS distance",
        "W₁ / std",
    ];
    let methods = DataTable::new(&caption, &headers, rows, "tables/pressure_methods.csv").without_empty_columns();
    [methods, scalars(pressure)].into()
}

/// Contact solves on coarser grids.
fn coarse_solves(coarse: &Value) -> String {
    let each: Vec<String> = list(coarse)
        .iter()
        .map(|grid| format!("{} on {} × {}", plain(&grid["solves"]), plain(&grid["nx"]), plain(&grid["ny"])))
        .collect();
    if each.is_empty() { "–".into() } else { each.join(", ") }
}

/// Wall time of a method: of the contact solutions on which it rests, which methods share, and of its estimate.
fn seconds(run: &Run, method: &str) -> Option<f64> {
    let samples: &[&str] = match method {
        "monte_carlo" | "polynomial_chaos_local" => &["monte_carlo"],
        "latin_hypercube" | "polynomial_chaos" | "polynomial_chaos_log" => &["latin_hypercube"],
        "sobol" => &["sobol"],
        "default" => &["monte_carlo", "coarse"],
        _ => return None,
    };
    let of = |task: &str| run.provenance["seconds"][format!("pressure/{task}")].as_f64();
    let solved = samples.iter().map(|task| of(task)).sum::<Option<f64>>()?;
    Some(solved + of(&format!("law/{method}")).unwrap_or(0.0))
}

/// One row per scalar of the whole contact.
fn scalars(pressure: &Value) -> DataTable {
    let rows = list(&pressure["scalars"]).iter().map(|scalar| {
        let key = scalar["name"].as_str().unwrap_or("–");
        let (name, dimension) = Dimension::of_key(key);
        let value = |entry: &Value, key: &str| {
            entry[key].as_f64().map_or("–".into(), |v| dimension.show_interval(v, interval(entry, key)))
        };
        let quantile = |probability: f64| {
            let found = list(&scalar["quantiles"]).iter().find(|q| q["probability"].as_f64() == Some(probability));
            found.map_or("–".into(), |q| value(q, "value"))
        };
        let std = scalar["std"].as_f64().map_or("–".into(), |v| dimension.show(v));
        let name = match name {
            "contact_fraction" => "contact area over nominal area".into(),
            other => other.replace('_', " "),
        };
        vec![name, value(scalar, "mean"), std, quantile(0.1), quantile(0.5), quantile(0.9)]
    });
    let headers = ["Property of the contact", "Mean", "Std", "10 % quantile", "Median", "90 % quantile"];
    let caption = "Laws of what belongs to the whole contact; brackets hold 95 % intervals";
    DataTable::new(caption, &headers, rows.collect(), "tables/pressure_scalars.csv")
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
