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
    Table::with_names(names, Table::of(scalars).into_columns())
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
