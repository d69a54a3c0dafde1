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

/// `pressure`: one row per method, then one per scalar of the whole contact.
pub(super) fn pressure(run: &Run) -> Vec<DataTable> {
    let pressure = &run.results["pressure"];
    let cell = |value: &Value, digits| value.as_f64().map_or("–".into(), |v| significant(v, digits));
    let rows = list(&pressure["methods"])
        .iter()
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
        "monte_carlo"
        | "pooled_sites"
        | "control_variate"
        | "polynomial_chaos_local"
        | "latent_overlap"
        | "two_part" => &["monte_carlo"],
        "latin_hypercube" | "polynomial_chaos" | "polynomial_chaos_log" => &["latin_hypercube"],
        "sobol" => &["sobol"],
        "multilevel" | "default" => &["monte_carlo", "coarse"],
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
