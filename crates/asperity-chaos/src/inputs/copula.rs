//! Gaussian copula: dependent standard normal variables from independent ones.

use super::InputError;
use asperity_base::numeric::dot;
use serde::Serialize;

/// Smallest pivot of a correlation matrix that counts as positive definite.
const LEAST_PIVOT: f64 = 1e-9;

/// Correlation of standard normal variables, with its Cholesky factor in the order of the inputs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Copula {
    correlation: Vec<Vec<f64>>,
    factor: Factor,
}

/// Cholesky factor of a correlation matrix whose rows and columns are put in an order.
///
/// Variable `order[k]` depends on the independent standard normal variables 0 … k.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Factor {
    order: Vec<usize>,
    rows: Vec<Vec<f64>>,
}

impl Copula {
    /// Creates the copula of a symmetric matrix with unit diagonal.
    ///
    /// # Errors
    /// The matrix is not positive definite.
    pub(super) fn new(correlation: Vec<Vec<f64>>) -> Result<Self, InputError> {
        let factor = Factor::new(&correlation, (0..correlation.len()).collect());
        if factor.rows.iter().enumerate().any(|(k, row)| row[k] * row[k] <= LEAST_PIVOT) {
            return Err(InputError::NotPositiveDefinite);
        }
        Ok(Self { correlation, factor })
    }

    /// Returns the copula of the same variables and `more` independent ones.
    pub(super) fn with_independent(mut self, more: usize) -> Self {
        let count = self.correlation.len() + more;
        self.correlation.resize(count, Vec::new());
        for (i, row) in self.correlation.iter_mut().enumerate() {
            row.resize(count, 0.0);
            row[i] = 1.0;
        }
        Self { factor: Factor::new(&self.correlation, (0..count).collect()), ..self }
    }

    /// Returns whether a correlation is not zero.
    pub(super) fn is_dependent(&self) -> bool {
        self.correlation.iter().enumerate().any(|(i, row)| row[..i].iter().any(|rho| *rho != 0.0))
    }

    /// Returns the dependent standard normal variables at the independent ones `z`.
    pub(super) fn dependent(&self, z: &[f64]) -> Vec<f64> {
        self.factor.dependent(z)
    }

    /// Returns independent standard normal variables at which the dependent variable of one input is `g`.
    pub(super) fn point_with(&self, input: usize, g: f64) -> Vec<f64> {
        // The row has unit length.
        let mut z: Vec<f64> = self.factor.rows[input].iter().map(|entry| g * entry).collect();
        z.resize(self.correlation.len(), 0.0);
        z
    }
}

impl Factor {
    /// Factors the matrix in an order. Pivots below [`LEAST_PIVOT`] are raised to it.
    fn new(correlation: &[Vec<f64>], order: Vec<usize>) -> Self {
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(order.len());
        for (k, &i) in order.iter().enumerate() {
            let mut row = vec![0.0; k + 1];
            for l in 0..k {
                row[l] = (correlation[i][order[l]] - dot(&rows[l][..l], &row)) / rows[l][l];
            }
            row[k] = (correlation[i][i] - dot(&row, &row)).max(LEAST_PIVOT).sqrt();
            rows.push(row);
        }
        Self { order, rows }
    }

    fn dependent(&self, independent: &[f64]) -> Vec<f64> {
        assert_eq!(independent.len(), self.order.len(), "one standard normal variable per input");
        let mut dependent = vec![0.0; independent.len()];
        for (row, &i) in self.rows.iter().zip(&self.order) {
            dependent[i] = dot(row, independent);
        }
        dependent
    }

    /// Inverts [`Factor::dependent`].
    fn independent(&self, dependent: &[f64]) -> Vec<f64> {
        let mut independent = Vec::with_capacity(dependent.len());
        for (k, (row, &i)) in self.rows.iter().zip(&self.order).enumerate() {
            independent.push((dependent[i] - dot(row, &independent)) / row[k]);
        }
        independent
    }
}

/// Draws the last inputs of an order anew, given the values of the others.
///
/// With the Cholesky factor in this order, the kept inputs determine the first independent variables. The conditional
/// distribution of the last inputs follows when their independent variables are replaced by new ones.
#[derive(Debug, Clone)]
pub struct Redraw {
    natural: Factor,
    ordered: Factor,
}

impl Redraw {
    /// Creates the redraw for an order of all inputs.
    pub(super) fn new(copula: &Copula, order: Vec<usize>) -> Self {
        Self { natural: copula.factor.clone(), ordered: Factor::new(&copula.correlation, order) }
    }

    /// Returns the point `z` with the last `count` inputs of the order drawn anew from the standard normal variables
    /// `fresh`, one per input; only those of the redrawn inputs are used. All other inputs keep their values.
    ///
    /// # Panics
    /// If a length or `count` does not fit the number of inputs.
    pub fn last(&self, count: usize, z: &[f64], fresh: &[f64]) -> Vec<f64> {
        let order = &self.ordered.order;
        let mut independent = self.ordered.independent(&self.natural.dependent(z));
        let first = order.len() - count;
        independent[first..].iter_mut().zip(&order[first..]).for_each(|(z, &input)| *z = fresh[input]);
        self.natural.independent(&self.ordered.dependent(&independent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{standard_normal, stream};
    use asperity_base::stats::Moments;

    fn correlated() -> Copula {
        Copula::new(vec![vec![1.0, 0.6, -0.3], vec![0.6, 1.0, 0.2], vec![-0.3, 0.2, 1.0]]).unwrap()
    }

    #[test]
    fn redrawn_variables_have_the_conditional_normal_distribution() {
        // Given variable 0 = g: means (0.6 g, −0.3 g), covariance 1 − 0.36, 1 − 0.09, 0.2 + 0.18.
        let copula = correlated();
        let redraw = Redraw::new(&copula, vec![0, 2, 1]);
        let z = [1.3, -0.4, 0.7];
        let n = 20_000;
        let draws: Vec<Vec<f64>> = (0..n)
            .map(|i| copula.dependent(&redraw.last(2, &z, &standard_normal(&mut stream(1, "redraw", i), 3))))
            .collect();
        assert!(draws.iter().all(|g| (g[0] - 1.3).abs() < 1e-14));
        let deviations = |i: usize, mean: f64| draws.iter().map(move |g| g[i] - mean);
        for (i, mean, variance) in [(1, 0.78, 0.64), (2, -0.39, 0.91)] {
            let found = Moments::from_values(deviations(i, mean));
            assert!(found.mean.abs() < 4.0 * found.standard_error(), "{i}: {}", found.mean);
            let squares = Moments::from_values(deviations(i, mean).map(|d| d * d));
            assert!((squares.mean - variance).abs() < 4.0 * squares.standard_error(), "{i}: {}", squares.mean);
        }
        let products = deviations(1, 0.78).zip(deviations(2, -0.39)).map(|(a, b)| a * b);
        let products = Moments::from_values(products);
        assert!((products.mean - 0.38).abs() < 4.0 * products.standard_error(), "{}", products.mean);
    }

    #[test]
    fn no_redraw_changes_nothing_and_a_full_one_replaces_the_point() {
        let copula = correlated();
        let redraw = Redraw::new(&copula, vec![2, 0, 1]);
        let (z, fresh) = ([0.3, -1.1, 2.0], [0.5, 0.1, -0.8]);
        assert!(redraw.last(0, &z, &fresh).iter().zip(z).all(|(a, b)| (a - b).abs() < 1e-14));
        let other = redraw.last(3, &[9.0, -9.0, 0.0], &fresh);
        assert!(redraw.last(3, &z, &fresh).iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-14));
    }

    #[test]
    fn independent_variables_are_appended_unchanged() {
        let copula = Copula::new(vec![vec![1.0, 0.6], vec![0.6, 1.0]]).unwrap().with_independent(2);
        let found = copula.dependent(&[0.5, -1.0, 0.25, 2.0]);
        let wanted = [0.5, 0.6 * 0.5 - 0.8, 0.25, 2.0];
        assert!(found.iter().zip(wanted).all(|(f, w)| (f - w).abs() < 1e-15) && found.len() == 4, "{found:?}");
        assert!(copula.is_dependent());
    }
}
