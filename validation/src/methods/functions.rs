//! Polynomials without extrapolation: variables are clamped to the range of the samples.

use ndarray::{Array2, ArrayView1};

use asperity::chaos::{Basis, BasisError, number_of_terms};

/// Hermite polynomials of variables that are clamped to the range of the samples.
///
/// Only the constant for degree 0 or without variables.
#[derive(Debug, Clone)]
pub(crate) struct Functions {
    basis: Option<Basis>,
    ranges: Vec<[f64; 2]>,
}

impl Functions {
    /// Creates the polynomials of total degree `degree` in the variables of the rows.
    pub(crate) fn new(rows: &[Vec<f64>], degree: usize) -> Result<Self, BasisError> {
        let variables = rows.first().map_or(0, Vec::len);
        let basis = if degree == 0 || variables == 0 { None } else { Some(Basis::hermite(variables, degree)?) };
        let range = |j: usize| {
            let values = rows.iter().map(|row| row[j]);
            [values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max)]
        };
        Ok(Self { basis, ranges: (0..variables).map(range).collect() })
    }

    /// Returns the number of functions.
    pub(crate) fn len(&self) -> usize {
        self.basis.as_ref().map_or(1, Basis::len)
    }

    /// Returns the degrees up to `most` with at least `per_term` of `samples` samples per coefficient; 0 is always included.
    pub(crate) fn degrees(
        variables: usize,
        most: usize,
        samples: usize,
        per_term: usize,
    ) -> std::ops::RangeInclusive<usize> {
        let fits =
            |degree: &usize| number_of_terms(variables, *degree).is_some_and(|terms| terms * per_term <= samples);
        let largest = if variables == 0 { 0 } else { (1..=most).take_while(fits).last().unwrap_or(0) };
        0..=largest
    }

    /// Returns all functions at the rows, shape `[rows, functions]`. Rows may be longer than those of the samples.
    pub(crate) fn matrix(&self, rows: &[Vec<f64>]) -> Array2<f64> {
        let Some(basis) = &self.basis else { return Array2::ones((rows.len(), 1)) };
        let within = |row: &Vec<f64>| -> Vec<f64> {
            row.iter().zip(&self.ranges).map(|(x, [low, high])| x.clamp(*low, *high)).collect()
        };
        basis.design_matrix(&rows.iter().map(within).collect::<Vec<_>>())
    }

    /// Returns the polynomial with the given coefficients at the rows.
    pub(crate) fn predict(&self, rows: &[Vec<f64>], coefficients: &[f64]) -> Vec<f64> {
        self.matrix(rows).dot(&ArrayView1::from(coefficients)).to_vec()
    }
}
