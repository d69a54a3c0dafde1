//! Conditional distribution of a quantity given the results of a cheaper model.
//!
//! A polynomial s(x) of the cheaper model's results x predicts the quantity q. The distribution of q given x is that of
//! s(x) + e, where e are the errors of the samples with similar predictions, because errors in and out of contact have
//! different variances.

use crate::MethodError;
use asperity_base::numeric::Line;
use asperity_chaos::{Basis, Expansion, LeastSquares, RegressionError, number_of_terms};

/// Number of samples per group of neighbouring predictions with one error distribution.
const GROUP: usize = 50;
/// Minimum number of samples per coefficient for a degree to be tried.
const SAMPLES_PER_TERM: usize = 4;

/// Fitted conditional distribution.
#[derive(Debug, Clone)]
pub(super) enum Predictor {
    /// The quantity equals the first variable.
    Identity,
    /// Polynomial with the distributions of its errors.
    Fitted(Box<Fitted>),
}

/// Polynomial with the distributions of its errors.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    /// Scaling of the variables that vary.
    scaling: Scaling,
    /// Slope of the line in the first variable to which the expansion is added.
    slope: f64,
    /// `None` if no variable varies.
    expansion: Option<Expansion>,
    /// Prediction without an expansion.
    mean: f64,
    errors: ErrorDistributions,
    /// Mean square leave-one-out error divided by the variance of the quantity.
    relative_error: Option<f64>,
}

impl Predictor {
    /// Fits `values` to `rows` of variables, with the degree up to `degree` that has the smallest leave-one-out error.
    ///
    /// # Errors
    /// The regression fails for another reason than too few or duplicate samples, for which lower degrees are used.
    pub(super) fn fit(rows: &[Vec<f64>], values: &[f64], degree: usize) -> Result<Self, MethodError> {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = spread(values);
        // A straight line in the first variable extrapolates where the polynomial's variables are clamped to their
        // ranges; otherwise all samples beyond the fitted ones would have errors of the same sign.
        let slope = slope(rows, values);
        let bent: Vec<f64> = rows.iter().zip(values).map(|(row, q)| q - slope * row.first().unwrap_or(&0.0)).collect();
        let scaling = Scaling::new(rows);
        let scaled: Vec<Vec<f64>> = rows.iter().map(|row| scaling.apply(row)).collect();
        let variables = scaling.variables();
        let constant: Vec<(f64, f64)> = values.iter().map(|q| (mean, q - mean)).collect();
        let mut best = (None, constant, f64::INFINITY);
        for degree in 1..=if variables == 0 || variance == 0.0 { 0 } else { degree } {
            if number_of_terms(variables, degree).is_none_or(|terms| terms * SAMPLES_PER_TERM > rows.len()) {
                break;
            }
            let basis = Basis::hermite(variables, degree)?;
            // Degrees with linearly dependent functions are skipped.
            let fit = match LeastSquares::new(basis.design_matrix(&scaled)).and_then(|fit| fit.fit(&bent)) {
                Ok(fit) => fit,
                Err(RegressionError::RankDeficient { .. }) => continue,
                Err(error) => return Err(error.into()),
            };
            let Some(relative_error) = fit.leave_one_out.relative_error else { continue };
            let relative_error = relative_error * spread(&bent) / variance;
            if relative_error < best.2 {
                let errors = fit.leave_one_out.errors.iter().zip(&fit.residuals);
                let pairs = errors.zip(values).map(|((error, rest), q)| (q - rest, error.unwrap_or(*rest))).collect();
                best = (Some(Expansion::new(basis, fit.coefficients)), pairs, relative_error);
            }
        }
        let (expansion, pairs, relative_error) = best;
        let relative_error = relative_error.is_finite().then_some(relative_error);
        let errors = ErrorDistributions::new(pairs);
        Ok(Self::Fitted(Box::new(Fitted { scaling, slope, expansion, mean, errors, relative_error })))
    }

    /// Returns the prediction s(x).
    pub(super) fn predict(&self, row: &[f64]) -> f64 {
        match self {
            Self::Identity => row[0],
            Self::Fitted(fitted) => match &fitted.expansion {
                Some(expansion) => fitted.slope * row[0] + expansion.evaluate(&fitted.scaling.apply(row)),
                None => fitted.mean,
            },
        }
    }

    /// Returns the errors around a prediction, in increasing order and equally likely.
    pub(super) fn errors(&self, prediction: f64) -> &[f64] {
        match self {
            Self::Identity => &[0.0],
            Self::Fitted(fitted) => fitted.errors.around(prediction),
        }
    }

    /// Returns the mean square leave-one-out error divided by the variance of the quantity, if there is an expansion.
    pub(super) fn relative_error(&self) -> Option<f64> {
        if let Self::Fitted(fitted) = self { fitted.relative_error } else { None }
    }

    /// Returns the number of coefficients.
    pub(super) fn coefficients(&self) -> Option<usize> {
        let Self::Fitted(fitted) = self else { return None };
        fitted.expansion.as_ref().map(|expansion| expansion.coefficients().len())
    }
}

/// Returns the variance of a sample.
fn spread(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / n
}

/// Returns the slope of the least-squares line over the first variable; 0 if the variable is constant.
fn slope(rows: &[Vec<f64>], values: &[f64]) -> f64 {
    let first = |row: &Vec<f64>| row.first().copied().unwrap_or(0.0);
    let points: Vec<(f64, f64)> = rows.iter().map(first).zip(values.iter().copied()).collect();
    let slope = Line::through(&points).slope;
    if slope.is_finite() { slope } else { 0.0 }
}

/// Errors in groups of samples with neighbouring predictions.
#[derive(Debug, Clone)]
pub(super) struct ErrorDistributions {
    /// Smallest prediction of each group after the first.
    bounds: Vec<f64>,
    /// Errors of each group in increasing order.
    groups: Vec<Vec<f64>>,
}

impl ErrorDistributions {
    /// Creates groups of about [`GROUP`] (prediction, error) pairs.
    fn new(mut pairs: Vec<(f64, f64)>) -> Self {
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let groups = (pairs.len() / GROUP).max(1);
        let start = |group: usize| group * pairs.len() / groups;
        let errors = |group: usize| {
            let mut errors: Vec<f64> = pairs[start(group)..start(group + 1)].iter().map(|pair| pair.1).collect();
            errors.sort_by(f64::total_cmp);
            errors
        };
        Self {
            bounds: (1..groups).map(|group| pairs[start(group)].0).collect(),
            groups: (0..groups).map(errors).collect(),
        }
    }

    fn around(&self, prediction: f64) -> &[f64] {
        &self.groups[self.bounds.partition_point(|bound| *bound <= prediction)]
    }
}

/// Shift, scale and range that make variables dimensionless.
#[derive(Debug, Clone)]
pub(super) struct Scaling {
    /// (position, mean, standard deviation, minimum, maximum) of each variable that varies.
    columns: Vec<(usize, f64, f64, f64, f64)>,
}

impl Scaling {
    /// Creates the scaling of a sample. Constant variables are dropped.
    pub(super) fn new(rows: &[Vec<f64>]) -> Self {
        let n = rows.len() as f64;
        let columns = (0..rows.first().map_or(0, Vec::len))
            .filter_map(|j| {
                let mean = rows.iter().map(|row| row[j]).sum::<f64>() / n;
                let std = (rows.iter().map(|row| (row[j] - mean).powi(2)).sum::<f64>() / n).sqrt();
                let least = rows.iter().map(|row| row[j]).fold(f64::INFINITY, f64::min);
                let largest = rows.iter().map(|row| row[j]).fold(f64::NEG_INFINITY, f64::max);
                let varies = std > 1e-12 * least.abs().max(largest.abs());
                varies.then_some((j, mean, std, least, largest))
            })
            .collect();
        Self { columns }
    }

    /// Returns the number of variables that vary.
    pub(super) fn variables(&self) -> usize {
        self.columns.len()
    }

    /// Returns the dimensionless variables, clamped to the range of the sample so that a polynomial is never
    /// extrapolated.
    pub(super) fn apply(&self, row: &[f64]) -> Vec<f64> {
        self.columns.iter().map(|&(j, mean, std, least, largest)| (row[j].clamp(least, largest) - mean) / std).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{standard_normal, stream};

    #[test]
    fn scaled_variables_are_standardised_limited_and_free_of_constants() {
        let rows = vec![vec![1.0, 5.0], vec![3.0, 5.0], vec![5.0, 5.0]];
        let scaling = Scaling::new(&rows);
        assert_eq!(scaling.variables(), 1);
        let std = (8.0_f64 / 3.0).sqrt();
        assert_eq!(scaling.apply(&[3.0, 5.0]), [0.0]);
        assert!((scaling.apply(&[100.0, 5.0])[0] - 2.0 / std).abs() < 1e-15);
    }

    #[test]
    fn a_heteroscedastic_polynomial_is_fitted_with_its_errors() {
        // q = x² + (1 + |x|)/10 η.
        let xi = standard_normal(&mut stream(1, "predictor", 0), 8000);
        let rows: Vec<Vec<f64>> = xi[..4000].iter().map(|x| vec![*x, 7.0]).collect();
        let values: Vec<f64> =
            xi[..4000].iter().zip(&xi[4000..]).map(|(x, eta)| x * x + 0.1 * eta * (1.0 + x.abs())).collect();
        let predictor = Predictor::fit(&rows, &values, 3).unwrap();
        assert_eq!(predictor.coefficients(), Some(3));
        for x in [0.5_f64, 1.5] {
            let prediction = predictor.predict(&[x, 7.0]);
            assert!((prediction - x * x).abs() < 0.02, "{prediction}");
            let errors = predictor.errors(prediction);
            let spread = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            // The relative standard error of the standard deviation of 50 values is 1/√100.
            assert!((spread / (0.1 * (1.0 + x)) - 1.0).abs() < 0.4, "{spread}");
        }
    }

    #[test]
    fn a_line_is_followed_beyond_the_samples() {
        let rows: Vec<Vec<f64>> = (0..100).map(|i| vec![0.01 * f64::from(i)]).collect();
        let values: Vec<f64> = rows.iter().map(|row| 3.0 * row[0] - 1.0).collect();
        let predictor = Predictor::fit(&rows, &values, 2).unwrap();
        assert!((predictor.predict(&[5.0]) - 14.0).abs() < 1e-9);
    }

    #[test]
    fn constants_are_predicted_by_their_mean() {
        let rows = vec![vec![1.0]; 60];
        let values: Vec<f64> = (0..60).map(f64::from).collect();
        let predictor = Predictor::fit(&rows, &values, 3).unwrap();
        assert_eq!((predictor.predict(&[1.0]), predictor.coefficients()), (29.5, None));
        assert_eq!(predictor.errors(29.5).len(), 60);
        let equal = Predictor::fit(&[vec![1.0], vec![2.0], vec![2.0]], &[4.0; 3], 3).unwrap();
        assert_eq!((equal.predict(&[9.0]), equal.errors(4.0)), (4.0, &[0.0; 3][..]));
    }
}
