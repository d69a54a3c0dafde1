//! The random surface fitted to the measured one: its covariance, its distribution, its expansion.

use std::collections::BTreeMap;

use asperity_results::SurfaceResult;

use crate::format::Dimension;
use crate::page::answer_table::{all, distribution};
use crate::page::data_table::DataTable;
use crate::words::length_in_words;

/// Returns the random surface: distribution of the heights, covariance, covariances that were tried, expansion.
pub(super) fn tables(surface: &SurfaceResult) -> Vec<DataTable> {
    let heights = distribution(&surface.marginal, &BTreeMap::new(), Dimension::Length);
    let mut tables = vec![DataTable::new("Heights of random surfaces", &["Property", "Value"], heights)];
    tables.extend(surface.covariance.iter().flat_map(|found| {
        [
            DataTable::of(
                &format!("Covariance of random surfaces; length ℓ: {}", length_in_words(&found.model)),
                found,
                all,
            ),
            DataTable::listed("Covariances that were tried", &found.candidates, all),
        ]
    }));
    tables.extend(surface.karhunen_loeve.iter().map(|found| DataTable::of("Karhunen–Loève expansion", found, all)));
    tables
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_results::DistributionResult;

    fn value_of(surface: &SurfaceResult, name: &str) -> String {
        let rows: Vec<Vec<String>> = tables(surface).into_iter().flat_map(|table| table.rows).collect();
        let found = rows.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("{name}: {rows:?}"));
        found[1].replace('\u{a0}', " ")
    }

    #[test]
    fn parameters_that_are_heights_have_units_and_shapes_have_none() {
        let of = |name: &str, parameters: &[(&str, f64)], wanted: &str| {
            let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
            let marginal = DistributionResult { name: name.into(), parameters };
            value_of(&SurfaceResult { marginal, ..SurfaceResult::default() }, wanted)
        };
        let beta: [(&str, f64); 4] = [("a", 2.1), ("b", 5.0), ("low", -2e-6), ("high", 5e-6)];
        assert_eq!(of("beta", &beta, "distribution"), "Beta");
        assert_eq!(of("beta", &beta, "first shape a"), "2.1");
        assert_eq!(of("beta", &beta, "lower end"), "−2 µm");
        assert_eq!(of("beta", &beta, "upper end"), "5 µm");
        let normal = [("mean", 0.0), ("std", 1e-6)];
        assert_eq!(of("normal", &normal, "standard deviation"), "1 µm");
        let johnson = [("gamma", 0.2), ("lambda", 3e-7)];
        assert_eq!(of("johnson_su", &johnson, "distribution"), "Johnson SU");
        assert_eq!(of("johnson_su", &johnson, "scale λ"), "300 nm");
        let weibull = [("shape", 2.0), ("scale", 1e-6)];
        assert_eq!(of("weibull", &weibull, "shape"), "2");
        assert_eq!(of("weibull", &weibull, "scale"), "1 µm");
        let lognormal = [("mu", -14.0), ("sigma", 0.5)];
        let logarithm = "mean of the logarithm of the excess over the shift";
        assert_eq!(of("lognormal", &lognormal, logarithm), "−14");
    }
}
