//! Sensitivity of contact results to the variables of a random surface.

use thiserror::Error;

use crate::directions::NamedDirections;
use crate::nested::kappa_pa_per_m;
use crate::{Problem, Quantity, Samples};
use asperity_base::blocks;
use asperity_chaos::{
    Basis, BasisError, Candidates, Expansion, IndexError, IndexEstimates, RegressionError, Resamples, SparseError,
    SparseRegression,
};

/// Maximum number of variables around the cell.
const MOST_LOCAL: usize = 8;
/// Maximum number of terms of an expansion, and samples per term.
const MOST_TERMS: usize = 40;
const SAMPLES_PER_TERM: usize = 4;
/// Number of resamples for the intervals.
const RESAMPLES: usize = 200;
/// Quantities whose indices are estimated.
const QUANTITIES: [Quantity; 3] = [Quantity::Pressure, Quantity::ContactFraction, Quantity::MeanPressure];

/// Set of variables ξ for the indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VariableSet {
    /// The height of the cell, and the orthogonal parts of the mean heights of rings around it whose radii double.
    Local,
    /// The leading variables ξ.
    Global,
}

/// Sobol' indices of a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// Quantity. The pressure is continued below zero by the gap and beyond the hardness by the plastic displacement.
    pub quantity: Quantity,
    /// Variables.
    pub variables: VariableSet,
    /// Indices, or the reason why there are none.
    pub outcome: Result<SensitivityIndices, SensitivityError>,
}

/// Sobol' indices from a sparse expansion.
///
/// They are fractions of the variance that the expansion explains. `cross_validated_error` is the unexplained fraction,
/// due to other variables, higher degrees and errors of the fit. Intervals are those of the coefficients, because the
/// terms are chosen once.
#[derive(Debug, Clone, PartialEq)]
pub struct SensitivityIndices {
    /// Name of each variable.
    pub names: Vec<String>,
    /// First-order and total indices with intervals.
    pub indices: IndexEstimates,
    /// Number of terms of the expansion.
    pub terms: usize,
    /// Mean square error of cross-validation divided by the variance of the quantity.
    pub cross_validated_error: Option<f64>,
}

/// Reason why there are no indices.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SensitivityError {
    /// There are too many variables ξ to compute the response of single heights.
    #[error("too many normal variables to rotate them to the cell")]
    NoVariables,
    /// The basis could not be created.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// There is no expansion.
    #[error(transparent)]
    Sparse(#[from] SparseError),
    /// The indices have no intervals.
    #[error(transparent)]
    Indices(#[from] IndexError<RegressionError>),
}

/// Estimates indices of all quantities with respect to variables around the cell and to up to `leading` leading
/// variables ξ, by expansions of total degree `degree`.
pub(super) fn estimate(
    problem: &Problem<'_>,
    samples: &Samples,
    leading: usize,
    degree: usize,
    seed: u64,
) -> Vec<Sensitivity> {
    let sets = [
        (VariableSet::Local, NamedDirections::from_cell(problem, MOST_LOCAL)),
        (VariableSet::Global, NamedDirections::leading(problem.surface().xi_len(), leading)),
    ];
    let sets = sets.map(|(set, named)| {
        let rows: Vec<Vec<f64>> = (0..samples.len()).map(|i| named.apply(&samples.xi(i))).collect();
        (set, named.names, rows)
    });
    let kappa = kappa_pa_per_m(samples.observations());
    blocks::map(0..QUANTITIES.len() * sets.len(), |index| {
        let (quantity, (variables, names, rows)) = (QUANTITIES[index / sets.len()], &sets[index % sets.len()]);
        let values = quantity.values(samples.observations(), kappa);
        Sensitivity { quantity, variables: *variables, outcome: indices(names, rows, &values, degree, seed) }
    })
}

fn indices(
    names: &[String],
    rows: &[Vec<f64>],
    values: &[f64],
    degree: usize,
    seed: u64,
) -> Result<SensitivityIndices, SensitivityError> {
    if names.is_empty() {
        return Err(SensitivityError::NoVariables);
    }
    let basis = Basis::hermite(names.len(), degree)?;
    let matrix = basis.design_matrix(rows);
    let most = (rows.len() / SAMPLES_PER_TERM).clamp(2, MOST_TERMS);
    let regression = SparseRegression { max_terms: Some(most), ..SparseRegression::default() };
    let sparse = regression.select(&Candidates::new(matrix.view())?, values)?;
    let chosen = basis.select(&sparse.terms)?;
    let fit = |positions: &[usize]| -> Result<Expansion, RegressionError> {
        let rows: Vec<&[f64]> = positions.iter().map(|i| rows[*i].as_slice()).collect();
        let values: Vec<f64> = positions.iter().map(|i| values[*i]).collect();
        Ok(Expansion::fit(chosen.clone(), &rows, &values)?.0)
    };
    let resamples = Resamples { count: RESAMPLES, ..Resamples::new(seed) };
    Ok(SensitivityIndices {
        names: names.to_vec(),
        indices: resamples.sobol_indices(rows.len(), &[], &fit)?,
        terms: sparse.terms.len(),
        cross_validated_error: Some(sparse.cross_validated),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{standard_normal, stream};

    #[test]
    fn indices_of_a_known_polynomial_are_its_variance_fractions() {
        // 2 x₀ + x₁ x₂ + 0.5 η: fractions 4/5 and 1/5 of the explained variance, and 1/21 unexplained.
        let rows: Vec<Vec<f64>> = (0..500).map(|i| standard_normal(&mut stream(1, "sensitivity", i), 4)).collect();
        let values: Vec<f64> = rows.iter().map(|x| 2.0 * x[0] + x[1] * x[2] + 0.5 * x[3]).collect();
        let rows: Vec<Vec<f64>> = rows.into_iter().map(|row| row[..3].to_vec()).collect();
        let names = ["a", "b", "c"].map(str::to_owned);
        let found = indices(&names, &rows, &values, 3, 1).unwrap();
        let wanted = [(0.8, 0.8), (0.0, 0.2), (0.0, 0.2)];
        for (k, (first, total)) in wanted.into_iter().enumerate() {
            let (found_first, found_total) = (found.indices.first_order[k], found.indices.total[k]);
            assert!((found_first.value - first).abs() < 4.0 * found_first.standard_error + 0.005, "{found_first:?}");
            assert!((found_total.value - total).abs() < 4.0 * found_total.standard_error + 0.005, "{found_total:?}");
        }
        assert!((found.cross_validated_error.unwrap() - 0.25 / 5.25).abs() < 0.02);
    }

    #[test]
    fn constants_and_missing_variables_are_reported_as_reasons() {
        let rows: Vec<Vec<f64>> = (0..50).map(|i| standard_normal(&mut stream(1, "sensitivity", i), 2)).collect();
        let names = ["a", "b"].map(str::to_owned);
        let constant = indices(&names, &rows, &[3.0; 50], 2, 1);
        assert!(
            matches!(constant, Err(SensitivityError::Sparse(SparseError::ConstantResponse { .. }))),
            "{constant:?}"
        );
        assert_eq!(indices(&[], &rows, &[3.0; 50], 2, 1), Err(SensitivityError::NoVariables));
    }
}
