//! Scalars of the contact as entries of `results.json` and as tables.

use crate::pressure::{QuantileResult, Quantity, ScalarResult};
use crate::study::Table;
use crate::study::result::{ScalarEntry, ScalarQuantile, pair};

/// Returns the name of a scalar with its unit.
pub(super) fn name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Pressure => "pressure_pa",
        Quantity::ContactFraction => "contact_fraction",
        Quantity::MeanPressure => "mean_pressure_pa",
        Quantity::MeanGap => "mean_gap_m",
        Quantity::Stiffness => "stiffness_pa_per_m",
    }
}

pub(super) fn entry(scalar: &ScalarResult) -> ScalarEntry {
    let quantile = |q: &QuantileResult| ScalarQuantile {
        probability: q.probability,
        value: q.value,
        value_interval: pair(q.interval),
    };
    ScalarEntry {
        name: name(scalar.quantity).into(),
        mean: scalar.mean,
        mean_se: scalar.mean_se,
        mean_interval: pair(scalar.mean_interval),
        std: scalar.distribution.std(),
        quantiles: scalar.quantiles.iter().map(quantile).collect(),
    }
}

/// Returns a row for each scalar, in the unit of its name.
pub(super) fn table(scalars: &[ScalarEntry]) -> Table {
    let names = scalars.iter().map(|scalar| scalar.name.clone()).collect();
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    let mut add = |name: String, value: &dyn Fn(&ScalarEntry) -> f64| {
        columns.push((name, scalars.iter().map(value).collect()));
    };
    add("mean".into(), &|s| s.mean);
    add("mean_se".into(), &|s| s.mean_se);
    add("mean_low".into(), &|s| s.mean_interval[0]);
    add("mean_high".into(), &|s| s.mean_interval[1]);
    add("std".into(), &|s| s.std);
    for (k, quantile) in scalars.iter().take(1).flat_map(|s| s.quantiles.iter().enumerate()) {
        let name = format!("quantile_{}", (100.0 * quantile.probability).round());
        add(name.clone(), &|s| s.quantiles[k].value);
        add(format!("{name}_low"), &|s| s.quantiles[k].value_interval[0]);
        add(format!("{name}_high"), &|s| s.quantiles[k].value_interval[1]);
    }
    Table::with_names(names, columns)
}

/// Returns the quantiles of the scalars at evenly spaced probabilities.
pub(super) fn quantile_table(scalars: &[ScalarResult]) -> Table {
    const ROWS: usize = 200;
    let probabilities: Vec<f64> = (0..ROWS).map(|k| (k as f64 + 0.5) / ROWS as f64).collect();
    let scalars = scalars.iter().map(|scalar| {
        let values = probabilities.iter().map(|p| scalar.distribution.quantile(*p)).collect();
        (name(scalar.quantity).to_owned(), values)
    });
    let scalars: Vec<(String, Vec<f64>)> = scalars.collect();
    Table::new(std::iter::once(("probability".to_owned(), probabilities)).chain(scalars))
}
