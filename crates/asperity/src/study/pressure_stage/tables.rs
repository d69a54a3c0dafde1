//! Tables behind the figures of the pressure stage.

use crate::chaos::DiscreteDistribution;
use crate::pressure::{Band, ComparisonResults, PressureEstimate, PressureMethod};
use crate::study::Table;
use crate::study::pressure_stage::{indices, scalars};
use crate::study::result::{MethodEntry, PressureResult};

pub(super) fn tables(
    results: &ComparisonResults,
    answer: &PressureEstimate,
    summary: &PressureResult,
) -> Vec<(&'static str, Table)> {
    let mut tables = vec![
        ("pressure_cdf", cdf(results, &answer.distribution)),
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

/// Returns the CDF of the reference and of every method with an estimate, on one grid of pressures: 0, quantiles of the answer, and
/// even steps between.
fn cdf(results: &ComparisonResults, answer: &DiscreteDistribution) -> Table {
    const ROWS: usize = 400;
    let atom = answer.cdf(0.0);
    let highest = answer.quantile(1.0);
    let mut pressures = vec![0.0];
    for k in 0..ROWS {
        let fraction = (k as f64 + 0.5) / ROWS as f64;
        pressures.push(answer.quantile(atom + (1.0 - atom) * fraction));
        // Even steps too: with a hardness most quantiles are equal to it.
        pressures.push(highest * fraction);
    }
    pressures.push(highest);
    pressures.sort_by(f64::total_cmp);
    pressures.dedup();
    let column =
        |distribution: &DiscreteDistribution| -> Vec<f64> { pressures.iter().map(|p| distribution.cdf(*p)).collect() };
    let mut columns = vec![("pressure_pa".to_owned(), pressures.clone())];
    let reference = results.reference.as_ref().map(|reference| &reference.estimate.distribution);
    columns.extend(reference.map(|reference| ("reference".into(), column(reference))));
    for &method in PressureMethod::ALL {
        columns.extend(results.estimate(method).map(|(found, _)| (method.name().into(), column(&found.distribution))));
    }
    Table::new(columns)
}

/// Returns the CDF of the reference and of every method with a band, each at its own pressures, with standard errors
/// and 95 % limits, pointwise and simultaneous.
fn bands(results: &ComparisonResults) -> Table {
    let reference = results.reference.iter().map(|reference| ("reference", reference.estimate.band.as_ref()));
    let methods = PressureMethod::ALL.iter().map(|&method| {
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
    let reference = MethodEntry {
        fine_solves: summary.reference_samples,
        work_in_fine_solves: summary.reference_samples as f64,
        failed_samples: summary.failed_samples,
        contact_probability: Some(summary.contact_probability),
        contact_probability_se: summary.contact_probability_se,
        contact_probability_interval: summary.contact_probability_interval,
        mean_pa: Some(summary.mean_pa),
        mean_se_pa: summary.mean_se_pa,
        mean_interval: summary.mean_interval,
        std_pa: Some(summary.std_pa),
        ..MethodEntry::default()
    };
    let methods = summary.methods.iter().filter(|method| method.failure.is_none()).cloned();
    let reference = (summary.reference_samples > 0).then_some(("reference", reference));
    let named = methods.map(|method| (method.name.name(), method));
    let (names, methods): (Vec<&str>, Vec<MethodEntry>) = reference.into_iter().chain(named).unzip();
    let names = names.into_iter().map(str::to_owned).collect();
    Table::with_names(names, Table::of(&methods).into_columns())
}
