//! Tables of the page from `results.json`.

use asperity_results::{CoarseEntry, PressureResult, ScalarQuantile};

use super::cells::{DASH, plain, shown};
use super::{DataTable, method_name, parameters, random_surface};
use crate::format::{Dimension, with_error};
use crate::{Input, Run};

/// Returns the tables of `surface`: parameters with their meaning, then the random surface.
pub(super) fn surface(run: &Run) -> Vec<DataTable> {
    let surface = run.results.surface.as_ref();
    [
        surface.map(|surface| parameters::table(&surface.measured)),
        surface.and_then(parameters::scans),
        surface.map(random_surface::table),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Returns a sentence on the methods without an estimate and their reasons; empty if every method has one.
pub(super) fn refused_methods(pressure: &PressureResult) -> String {
    let methods = pressure.methods.iter();
    let refused: Vec<String> = methods
        .filter_map(|method| Some(format!("{} ({})", method_name(&method.name), method.failure.as_ref()?)))
        .collect();
    if refused.is_empty() { String::new() } else { format!("Methods without an estimate: {}.", refused.join("; ")) }
}

/// Returns one row per method with an estimate.
pub(super) fn methods(run: &Run, pressure: &PressureResult) -> DataTable {
    let rows = pressure.methods.iter().filter(|method| method.failure.is_none()).map(|method| {
        let probability = match (method.contact_probability, method.contact_probability_se) {
            (Some(value), Some(error)) => with_error(value, error),
            (value, _) => shown(Dimension::None, value, method.contact_probability_interval),
        };
        vec![
            method_name(&method.name),
            method.fine_solves.to_string(),
            coarse_solves(&method.coarse_solves),
            seconds(run, &method.name).map_or(DASH.into(), |s| Dimension::Time.show_short(s)),
            probability,
            shown(Dimension::Pressure, method.mean_pa, method.mean_interval),
            plain(method.ks_distance, 3),
            plain(method.wasserstein_1_over_std, 3),
        ]
    });
    let sites = if pressure.sites > 1 { format!(", each at {} sites", pressure.sites) } else { String::new() };
    let caption = format!(
        "Methods for the distribution of the pressure; distances are from the reference of {} samples{sites}; brackets are 95 % \
         intervals",
        pressure.reference_samples
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
    DataTable::new(&caption, &headers, rows.collect(), "tables/pressure_methods.csv").without_empty_columns()
}

/// Formats the contact solves on coarser grids.
fn coarse_solves(coarse: &[CoarseEntry]) -> String {
    let each: Vec<String> = coarse.iter().map(|grid| format!("{} on {} × {}", grid.solves, grid.nx, grid.ny)).collect();
    if each.is_empty() { DASH.into() } else { each.join(", ") }
}

/// Returns the wall time of a method: of its contact solutions, which several methods share, and of its estimate.
fn seconds(run: &Run, method: &str) -> Option<f64> {
    let samples: &[&str] = match method {
        "monte_carlo" | "polynomial_chaos_local" => &["monte_carlo"],
        "latin_hypercube" | "polynomial_chaos" | "polynomial_chaos_log" => &["latin_hypercube"],
        "sobol" => &["sobol"],
        "default" => &["monte_carlo", "coarse"],
        _ => return None,
    };
    let of = |task: &str| run.provenance.as_ref()?.seconds.get(&format!("pressure/{task}")).copied();
    let solved = samples.iter().map(|task| of(task)).sum::<Option<f64>>()?;
    Some(solved + of(&format!("law/{method}")).unwrap_or(0.0))
}

/// Returns one row per property of the whole contact.
pub(super) fn scalars(pressure: &PressureResult) -> DataTable {
    let rows = pressure.scalars.iter().map(|scalar| {
        let (name, dimension) = Dimension::of_key(&scalar.name);
        let quantile = |probability: f64| {
            let found = scalar.quantiles.iter().find(|q| q.probability == probability);
            let value = |q: &ScalarQuantile| shown(dimension, q.value, Some(q.value_interval));
            found.map_or_else(|| DASH.into(), value)
        };
        let name = match name {
            "contact_fraction" => "contact area over nominal area".into(),
            other => other.replace('_', " "),
        };
        let mean = shown(dimension, scalar.mean, Some(scalar.mean_interval));
        vec![name, mean, dimension.show(scalar.std), quantile(0.1), quantile(0.5), quantile(0.9)]
    });
    let headers = ["Property of the contact", "Mean", "Std", "10 % quantile", "Median", "90 % quantile"];
    let caption = "Distributions of properties of the whole contact; brackets are 95 % intervals";
    DataTable::new(caption, &headers, rows.collect(), "tables/pressure_scalars.csv")
}

/// Returns the inputs, one table per section in the order of appearance.
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
