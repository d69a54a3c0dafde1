//! Tensor products of orthonormal polynomials.

use ndarray::Array2;
use thiserror::Error;

use super::{Family, MultiIndexError, MultiIndexSet};

/// Why a basis could not be made.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
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

/// The functions Ψ_α(ξ) = Π_i ψ_{α_i}(ξ_i) of a set of multi-indices, orthonormal when the ξ_i are independent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Basis {
    set: MultiIndexSet,
    families: Vec<Family>,
}

impl Basis {
    /// The basis of a set, with one family for each variable.
    ///
    /// # Errors
    /// Another number of families than of variables.
    pub fn new(set: MultiIndexSet, families: Vec<Family>) -> Result<Self, BasisError> {
        if families.len() != set.variables() {
            return Err(BasisError::Families { families: families.len(), variables: set.variables() });
        }
        Ok(Self { set, families })
    }

    /// Hermite polynomials of total degree `degree` in `variables` standard normal variables.
    ///
    /// # Errors
    /// As [`MultiIndexSet::total_degree`].
    pub fn hermite(variables: usize, degree: usize) -> Result<Self, BasisError> {
        Self::new(MultiIndexSet::total_degree(variables, degree)?, vec![Family::Hermite; variables])
    }

    /// The multi-indices.
    pub fn set(&self) -> &MultiIndexSet {
        &self.set
    }

    /// The family of each variable.
    pub fn families(&self) -> &[Family] {
        &self.families
    }

    /// Number of functions.
    pub fn len(&self) -> usize {
        self.set.len()
    }

    /// Whether there are no functions: never, the constant is one.
    pub fn is_empty(&self) -> bool {
        self.set.is_empty()
    }

    /// Writes all Ψ_α(ξ) into `values`: one product for each function after the univariate recurrences. The leading
    /// variables of `germ` are used; further ones are ignored.
    ///
    /// # Panics
    /// If `germ` is shorter than the number of variables, or `values` is not as long as the basis.
    pub fn fill(&self, germ: &[f64], univariate: &mut Vec<f64>, values: &mut [f64]) {
        let variables = self.set.variables();
        assert!(germ.len() >= variables, "{} germ values for {variables} variables", germ.len());
        assert_eq!(values.len(), self.len(), "values of another basis");
        let stride = self.set.degree() + 1;
        univariate.resize(stride * variables, 0.0);
        for ((family, &xi), row) in self.families.iter().zip(germ).zip(univariate.chunks_exact_mut(stride)) {
            family.fill_orthonormal(xi, row);
        }
        values[0] = 1.0;
        for (term, step) in self.set.steps().iter().enumerate() {
            values[term + 1] = values[step.parent] * univariate[step.variable * stride + step.degree];
        }
    }

    /// The design matrix Ψ_j(ξ_k), shape `[germs, functions]`.
    pub fn design_matrix<G: AsRef<[f64]>>(&self, germs: &[G]) -> Array2<f64> {
        let mut matrix = Array2::zeros((germs.len(), self.len()));
        let mut univariate = Vec::new();
        let mut values = vec![0.0; self.len()];
        for (germ, mut row) in germs.iter().zip(matrix.rows_mut()) {
            self.fill(germ.as_ref(), &mut univariate, &mut values);
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
        let set = MultiIndexSet::total_degree(3, 4).unwrap();
        let families = [Family::Hermite, Family::Legendre, Family::Hermite];
        let basis = Basis::new(set.clone(), families.to_vec()).unwrap();
        let germ = [0.3, -0.7, 1.9];
        let row = basis.design_matrix(&[germ]);
        for (term, alpha) in set.iter().enumerate() {
            let product: f64 = (0..3)
                .map(|i| {
                    let mut psi = [0.0; 5];
                    families[i].fill_orthonormal(germ[i], &mut psi);
                    psi[usize::from(alpha[i])]
                })
                .product();
            assert!((row[[0, term]] - product).abs() < 1e-14);
        }
    }

    #[test]
    fn families_must_match_variables() {
        let set = MultiIndexSet::total_degree(3, 1).unwrap();
        let error = Basis::new(set, vec![Family::Hermite]).unwrap_err();
        assert_eq!(error, BasisError::Families { families: 1, variables: 3 });
    }
}
