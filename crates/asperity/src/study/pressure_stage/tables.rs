//! Tables behind the figures of the pressure stage.

use crate::chaos::DiscreteDistribution;
use crate::pressure::{Band, ComparisonResults, Method};
use crate::study::Table;
use crate::study::pressure_stage::{indices, scalars};
use crate::study::result::{MethodEntry, Pair, PressureResult};

pub(super) fn tables(results: &ComparisonResults, summary: &PressureResult) -> Vec<(&'static str, Table)> {
    let mut tables = vec![
        ("pressure_cdf", cdf(results)),
        ("pressure_bands", bands(results)),
        ("pressure_methods", methods(summary)),
    ];
    if !results.scalars.is_empty() {
        tables.push(("pressure_scalars", scalars::table(&summary.scalars)));
        tables.push(("pressure_scalar_distributions", scalars::quantile_table(&results.scalars)));
    }
    if summary.sensitivities.iter().any(|entry| !entry.indices.is_empty()) {
        tables.push(("pressure_sensitivities", indices::table(&summary.sensitivities)));
    }
    tables
}

/// Returns the CDF of every method with an estimate, on one grid of pressures: 0, quantiles of the reference, and even
/// steps between.
fn cdf(results: &ComparisonResults) -> Table {
    const ROWS: usize = 400;
    let reference = &results.reference.estimate.distribution;
    let atom = reference.cdf(0.0);
    let highest = reference.quantile(1.0);
    let mut pressures = vec![0.0];
    for k in 0..ROWS {
        let fraction = (k as f64 + 0.5) / ROWS as f64;
        pressures.push(reference.quantile(atom + (1.0 - atom) * fraction));
        // Even steps too: with a hardness most quantiles are equal to it.
        pressures.push(highest * fraction);
    }
    pressures.push(highest);
    pressures.sort_by(f64::total_cmp);
    pressures.dedup();
    let column =
        |distribution: &DiscreteDistribution| -> Vec<f64> { pressures.iter().map(|p| distribution.cdf(*p)).collect() };
    let mut columns = vec![("pressure_pa".to_owned(), pressures.clone()), ("reference".into(), column(reference))];
    for method in Method::ALL {
        columns.extend(results.estimate(method).map(|(found, _)| (method.name().into(), column(&found.distribution))));
    }
    Table::new(columns)
}

/// Returns the CDF of the reference and of every method with a band, each at its own pressures, with standard errors
/// and 95 % limits, pointwise and simultaneous.
fn bands(results: &ComparisonResults) -> Table {
    let reference = std::iter::once(("reference", results.reference.estimate.band.as_ref()));
    let methods = Method::ALL.into_iter().map(|method| {
        let estimate = results.estimate(method).map(|(estimate, _)| estimate);
        (method.name(), estimate.and_then(|estimate| estimate.band.as_ref()))
    });
    let bands: Vec<(&str, &Band)> = reference.chain(methods).filter_map(|(name, band)| Some((name, band?))).collect();
    let rows = bands.iter().map(|(_, band)| band.values.len()).max().unwrap_or(0);
    let mut columns = Vec::new();
    for (name, band) in bands {
        let n = band.values.len();
        let mut add = |what: &str, value: &dyn Fn(usize) -> f64| {
            let values = (0..rows).map(|i| if i < n { value(i) } else { f64::NAN }).collect();
            columns.push((format!("{name}_{what}"), values));
        };
        add("pressure_pa", &|i| band.values[i]);
        add("cdf", &|i| band.cdf[i]);
        add("cdf_bias", &|i| band.bias[i]);
        add("cdf_se", &|i| band.standard_errors[i]);
        for (what, limits) in [
            ("pointwise", &(|i| band.pointwise(i)) as &dyn Fn(usize) -> [f64; 2]),
            ("simultaneous", &|i| band.simultaneous(i)),
        ] {
            add(&format!("{what}_low"), &|i| limits(i)[0]);
            add(&format!("{what}_high"), &|i| limits(i)[1]);
        }
    }
    Table::new(columns)
}

/// Returns a row for each method with an estimate, the reference first.
fn methods(summary: &PressureResult) -> Table {
    let methods: Vec<&MethodEntry> = summary.methods.iter().filter(|method| method.failure.is_none()).collect();
    let end = |interval: Option<Pair>, end: usize| interval.map_or(f64::NAN, |interval| interval[end]);
    let names = std::iter::once("reference".to_owned()).chain(methods.iter().map(|m| m.name.name().to_owned()));
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    let mut add = |name: &str, reference: Option<f64>, values: Vec<Option<f64>>| {
        let values = values.into_iter().map(|value| value.unwrap_or(f64::NAN));
        columns.push((name.to_owned(), std::iter::once(reference.unwrap_or(f64::NAN)).chain(values).collect()));
    };
    let of = |value: &dyn Fn(&MethodEntry) -> Option<f64>| -> Vec<Option<f64>> {
        methods.iter().map(|method| value(method)).collect()
    };
    let samples = Some(summary.reference_samples as f64);
    add("fine_solves", samples, of(&|m| Some(m.fine_solves as f64)));
    add("work_in_fine_solves", samples, of(&|m| Some(m.work_in_fine_solves)));
    add("contact_probability", Some(summary.contact_probability), of(&|m| m.contact_probability));
    add("contact_probability_bias", None, of(&|m| m.contact_probability_bias));
    add("contact_probability_se", summary.contact_probability_se, of(&|m| m.contact_probability_se));
    for (i, side) in ["low", "high"].into_iter().enumerate() {
        let own = summary.contact_probability_interval.map(|interval| interval[i]);
        add(&format!("contact_probability_{side}"), own, of(&|m| Some(end(m.contact_probability_interval, i))));
    }
    add("mean_pa", Some(summary.mean_pa), of(&|m| m.mean_pa));
    add("mean_bias_pa", None, of(&|m| m.mean_bias_pa));
    add("mean_se_pa", summary.mean_se_pa, of(&|m| m.mean_se_pa));
    for (i, side) in ["low", "high"].into_iter().enumerate() {
        let own = summary.mean_interval.map(|interval| interval[i]);
        add(&format!("mean_{side}_pa"), own, of(&|m| Some(end(m.mean_interval, i))));
    }
    add("std_pa", Some(summary.std_pa), of(&|m| m.std_pa));
    for (k, quantile) in summary.quantiles.iter().enumerate() {
        let percent = (100.0 * quantile.probability).round();
        add(
            &format!("quantile_{percent}_pa"),
            Some(quantile.pressure_pa),
            of(&|m| m.quantiles.get(k).map(|q| q.pressure_pa)),
        );
        for (i, side) in ["low", "high"].into_iter().enumerate() {
            let found = of(&|m| m.quantiles.get(k).map(|q| end(q.pressure_pa_interval, i)));
            add(&format!("quantile_{percent}_{side}_pa"), Some(end(quantile.pressure_pa_interval, i)), found);
        }
    }
    add("ks_distance", None, of(&|m| m.ks_distance));
    add("wasserstein_1_over_std", None, of(&|m| m.wasserstein_1_over_std));
    Table::with_names(names.collect(), columns)
}
