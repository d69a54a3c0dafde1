//! Tables of the page from `results.json`.

use asperity_results::choice::Choice;
use asperity_results::keys::{Key, KeyDefault, RANGES, SPREADS};
use asperity_results::{PressureResult, ScalarQuantile};

use crate::cells::{DASH, shown};
use crate::format::Dimension;
use crate::page::data_table::DataTable;
use crate::page::{parameters, random_surface};
use crate::{Input, Run};

/// Returns the tables of `surface`: parameters with their meaning, then the random surface.
pub(super) fn surface(run: &Run) -> Vec<DataTable> {
    let surface = run.results.surface.as_ref();
    let mut tables: Vec<DataTable> = surface.map(|surface| parameters::table(&surface.measured)).into_iter().collect();
    tables.extend(surface.and_then(parameters::scans));
    tables.extend(surface.iter().flat_map(|surface| random_surface::tables(surface)));
    tables
}

/// Returns a sentence on the methods without an estimate and their reasons; empty if every method has one.
pub(super) fn refused_methods(pressure: &PressureResult) -> String {
    let methods = pressure.methods.iter();
    let refused: Vec<String> =
        methods.filter_map(|method| Some(format!("{} ({})", method.name.words(), method.failure.as_ref()?))).collect();
    if refused.is_empty() { String::new() } else { format!("Methods without an estimate: {}.", refused.join("; ")) }
}

/// Returns the methods with an estimate, beside each other.
pub(super) fn methods(pressure: &PressureResult) -> DataTable {
    let estimated = pressure.methods.iter().filter(|method| method.failure.is_none());
    let estimated: Vec<_> = estimated.map(|method| (method.name.words(), method)).collect();
    let sites = if pressure.sites > 1 { format!(", each at {} sites", pressure.sites) } else { String::new() };
    let caption = match pressure.reference_samples {
        0 => "Estimated distribution of the pressure at a point of a patch; brackets are 95 % intervals".to_owned(),
        samples => format!(
            "Methods for the distribution of the pressure at a point of a patch; distances are from the reference of {samples} samples{sites}; brackets are \
             95 % intervals"
        ),
    };
    DataTable::beside(&caption, &estimated, |key| key != "name")
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
            "contact_fraction" => "contact area over nominal area of a patch, by cells".into(),
            other => other.replace('_', " "),
        };
        let mean = shown(dimension, scalar.mean, Some(scalar.mean_interval));
        vec![name, mean, dimension.show(scalar.std), quantile(0.1), quantile(0.5), quantile(0.9)]
    });
    let headers = ["Property of the contact", "Mean", "Std", "10 % quantile", "Median", "90 % quantile"];
    let caption = "Distributions of properties of a whole patch, from patch to patch; brackets are 95 % intervals";
    DataTable::new(caption, &headers, rows.collect())
}

/// Returns the inputs with their origin, without the settings of the computation, one table per section in the order of appearance.
pub(super) fn inputs(inputs: &[Input]) -> Vec<DataTable> {
    let is_list = |input: &&Input| input.section == "study" && input.key == UNSTATED;
    let unstated: Vec<&str> =
        inputs.iter().find(is_list).map_or_else(Vec::new, |list| list.value.split(", ").collect());
    let mut tables: Vec<DataTable> = Vec::new();
    for input in inputs.iter().filter(|input| !is_list(input)) {
        let Input { section, key, value } = input;
        let Some(origin) = origin(input, &unstated) else { continue };
        let row = vec![key.clone(), value.clone(), origin.to_owned()];
        match tables.iter_mut().find(|table| table.caption == *section) {
            Some(table) => table.rows.push(row),
            None => tables.push(DataTable::new(section, &["Key", "Value", "Origin"], vec![row])),
        }
    }
    tables
}

/// Key of the defaults that a resolved study lists.
const UNSTATED: &str = "unstated";

/// Returns where the value of an input comes from; `None` for a setting of the computation.
fn origin(Input { section, key, value }: &Input, unstated: &[&str]) -> Option<&'static str> {
    let name = key.split('.').next().unwrap_or(key);
    let is_measured = match name {
        "file" => true,
        "covariance" | "marginal" => matches!(value.as_str(), "measured" | "empirical"),
        _ => false,
    };
    let path = format!("{section}.{name}");
    let known = Key::find(&path);
    let default = known.filter(|_| unstated.contains(&path.as_str())).and_then(|known| known.default);
    Some(match (section.as_str(), default) {
        ("surface" | "counterface", _) if is_measured => "measured",
        (_, Some(KeyDefault { of_paper: true, .. })) => "the paper’s default",
        (_, Some(_)) => "asperity’s default",
        _ if known.is_none() => return None,
        _ if key.contains('.') || SPREADS.iter().chain(&RANGES).any(|mark| value.contains(mark)) => "stated, uncertain",
        _ => "stated",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_input_has_an_origin() {
        let input = |section: &str, key: &str, value: &str| Input {
            section: section.into(),
            key: key.into(),
            value: value.into(),
        };
        let all = [
            input("study", "seed", "1"),
            input("study", "unstated", "friction.law, material.poisson_ratio"),
            input("surface", "file", "a.x3p"),
            input("friction", "law", "bowden_tabor"),
            input("friction", "points", "64, 64"),
            input("material", "poisson_ratio", "0.3"),
            input("material", "youngs_modulus", "2 GPa ± 0.1 GPa"),
            input("material", "hardness.lognormal", "1 GPa, 0.2"),
            input("vibration", "mass", "1 kg"),
        ];
        let origins: Vec<String> =
            inputs(&all).into_iter().flat_map(|table| table.rows).filter_map(|row| row.last().cloned()).collect();
        let wanted = [
            "measured",
            "the paper’s default",
            "asperity’s default",
            "stated, uncertain",
            "stated, uncertain",
            "stated",
        ];
        assert_eq!(origins, wanted);
    }
}
