//! Tensor products of orthonormal polynomials.

use ndarray::Array2;
use thiserror::Error;

use super::{Factor, MultiIndexError, MultiIndexSet, OrthonormalPolynomials, PolynomialFamily};

/// Why a basis could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum BasisError {
    /// The set of terms could not be made.
    #[error(transparent)]
    Terms(#[from] MultiIndexError),
    /// Families and variables differ in number.
    #[error("{families} polynomial families for {variables} variables")]
    Families {
        /// Families given.
        families: usize,
        /// Variables of the set.
        variables: usize,
    },
}

/// Functions Ψ_α(ξ) = Π_i ψ_{α_i}(ξ_i) of a set of multi-indices, orthonormal for independent ξ_i.
#[derive(Debug, Clone, PartialEq)]
pub struct Basis {
    set: MultiIndexSet,
    polynomials: Vec<OrthonormalPolynomials>,
}

impl Basis {
    /// Creates the basis of a set, with one family for each variable.
    ///
    /// # Errors
    /// The number of families differs from the number of variables.
    pub fn new(set: MultiIndexSet, families: Vec<PolynomialFamily>) -> Result<Self, BasisError> {
        let degree = set.largest_power();
        Self::with_polynomials(set, families.into_iter().map(|family| family.polynomials(degree)).collect())
    }

    /// Creates the basis of a set, with the polynomials of each variable.
    ///
    /// # Errors
    /// The number of families of polynomials differs from the number of variables.
    ///
    /// # Panics
    /// If a family ends before the largest power of the set.
    pub fn with_polynomials(set: MultiIndexSet, polynomials: Vec<OrthonormalPolynomials>) -> Result<Self, BasisError> {
        if polynomials.len() != set.variables() {
            return Err(BasisError::Families { families: polynomials.len(), variables: set.variables() });
        }
        let degree = set.largest_power();
        assert!(polynomials.iter().all(|own| own.steps().len() >= degree), "polynomials of degree {degree}");
        Ok(Self { set, polynomials })
    }

    /// Creates the basis of Hermite polynomials of total degree `degree` in `variables` standard normal variables.
    ///
    /// # Errors
    /// See [`MultiIndexSet::total_degree`].
    pub fn hermite(variables: usize, degree: usize) -> Result<Self, BasisError> {
        Self::new(MultiIndexSet::total_degree(variables, degree)?, vec![PolynomialFamily::Hermite; variables])
    }

    /// Returns the multi-indices.
    pub fn set(&self) -> &MultiIndexSet {
        &self.set
    }

    /// Returns the polynomials of each variable.
    pub fn polynomials(&self) -> &[OrthonormalPolynomials] {
        &self.polynomials
    }

    /// Returns the number of functions.
    pub fn len(&self) -> usize {
        self.set.len()
    }

    /// Returns false: a basis always contains the constant.
    pub fn is_empty(&self) -> bool {
        self.set.is_empty()
    }

    /// Returns the basis of the functions at the given positions, in that order.
    ///
    /// # Errors
    /// See [`MultiIndexSet::select`].
    ///
    /// # Panics
    /// If a position lies beyond the basis.
    pub fn select(&self, positions: &[usize]) -> Result<Self, BasisError> {
        Ok(Self { set: self.set.select(positions)?, polynomials: self.polynomials.clone() })
    }

    /// Writes all Ψ_α(ξ) into `values`.
    ///
    /// After the univariate recurrences, each function costs one product if its predecessor (the function without its
    /// last factor) precedes it in the basis. Entries of `xi` beyond the number of variables are ignored.
    ///
    /// # Panics
    /// If `xi` is shorter than the number of variables, or `values` is not as long as the basis.
    pub fn fill(&self, xi: &[f64], univariate: &mut Vec<f64>, values: &mut [f64]) {
        let variables = self.set.variables();
        assert!(xi.len() >= variables, "{} normal variables for {variables} variables", xi.len());
        assert_eq!(values.len(), self.len(), "values of another basis");
        let stride = self.set.largest_power() + 1;
        univariate.resize(stride * variables, 0.0);
        for ((own, &xi), row) in self.polynomials.iter().zip(xi).zip(univariate.chunks_exact_mut(stride)) {
            own.fill(xi, row);
        }
        let psi = |factor: &Factor| univariate[factor.variable as usize * stride + usize::from(factor.degree)];
        for (term, factors) in self.set.iter().enumerate() {
            values[term] = match (self.set.parent(term), factors.last()) {
                (Some(parent), Some(last)) => values[parent] * psi(last),
                _ => factors.iter().map(psi).product(),
            };
        }
    }

    /// Returns the design matrix Ψ_j(ξ_k), shape `[samples, functions]`.
    pub fn design_matrix<G: AsRef<[f64]>>(&self, xi_samples: &[G]) -> Array2<f64> {
        let mut matrix = Array2::zeros((xi_samples.len(), self.len()));
        let mut univariate = Vec::new();
        let mut values = vec![0.0; self.len()];
        for (xi, mut row) in xi_samples.iter().zip(matrix.rows_mut()) {
            self.fill(xi.as_ref(), &mut univariate, &mut values);
            row.iter_mut().zip(&values).for_each(|(cell, value)| *cell = *value);
        }
        matrix
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_function_is_the_product_of_its_polynomials() {
        let complete = MultiIndexSet::total_degree(3, 4).unwrap();
        // No term has its predecessor in the list, and the list is unordered.
        let list = MultiIndexSet::from_rows(3, [[0, 0, 0], [4, 1, 3], [0, 0, 2], [2, 2, 0], [2, 0, 0]]).unwrap();
        let families = [PolynomialFamily::Hermite, PolynomialFamily::Legendre, PolynomialFamily::Hermite];
        let xi = [0.3, -0.7, 1.9];
        for set in [complete, list] {
            let row = Basis::new(set.clone(), families.to_vec()).unwrap().design_matrix(&[xi]);
            for term in 0..set.len() {
                let product: f64 = (0..3)
                    .map(|i| {
                        let mut psi = [0.0; 5];
                        families[i].polynomials(4).fill(xi[i], &mut psi);
                        psi[usize::from(set.at(term)[i])]
                    })
                    .product();
                assert!((row[[0, term]] - product).abs() < 1e-14 * product.abs().max(1.0));
            }
        }
    }

    #[test]
    fn families_must_match_variables() {
        let set = MultiIndexSet::total_degree(3, 1).unwrap();
        let error = Basis::new(set, vec![PolynomialFamily::Hermite]).unwrap_err();
        assert_eq!(error, BasisError::Families { families: 1, variables: 3 });
    }
}
