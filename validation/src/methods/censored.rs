//! Censored regression: regression of values that are only known within bounds.
//!
//! The latent value is y* = Σ c_j ψ_j + σ ε with a standard normal ε. The observed value is y* clamped to the bounds.
//! In c/σ and 1/σ the log-likelihood is concave, so Newton's method finds its maximum from any start.
//!
//! # References
//! J. Tobin, *Econometrica* **26** (1958) 24, <https://doi.org/10.2307/1907382>.
//! R. J. Olsen, *Econometrica* **46** (1978) 1211, <https://doi.org/10.2307/1911445>.

use ndarray::{Array1, Array2, ArrayView2};

use super::newton::{Local, maximise};
use asperity::distribution::{standard_normal_cdf, standard_normal_pdf};

/// Smallest and largest ratio of the scale of the values to σ. The fit ends at the smallest if all values lie on bounds, and at the
/// largest if the fit is exact.
const PRECISION: [f64; 2] = [1e-3, 1e5];
/// Argument below which the tail is computed by the asymptotic series.
const TAIL: f64 = -30.0;

/// Fitted model of the latent value.
#[derive(Debug, Clone)]
pub(crate) struct Censored {
    pub(crate) coefficients: Vec<f64>,
    pub(crate) sigma: f64,
    pub(crate) log_likelihood: f64,
}

/// Fits `values` within `bounds` at the rows of the design. At least one value must lie above the lower bound.
pub(crate) fn fit(design: ArrayView2<'_, f64>, values: &[f64], bounds: [f64; 2]) -> Censored {
    let terms = design.ncols();
    let seen = values.iter().filter(|y| **y > bounds[0]);
    let count = seen.clone().count().max(1) as f64;
    let scale = (seen.map(|y| y * y).sum::<f64>() / count).sqrt();
    let scale = if scale > 0.0 { scale } else { 1.0 };
    // u = Σ ψ_j δ_j − θ y, with δ = c/σ and θ = 1/σ.
    let mut columns = Array2::zeros((values.len(), terms + 1));
    for ((mut row, functions), y) in columns.rows_mut().into_iter().zip(design.rows()).zip(values) {
        row.iter_mut().zip(functions).for_each(|(cell, psi)| *cell = *psi);
        row[terms] = -y.clamp(bounds[0], bounds[1]) / scale;
    }
    let likelihood = |place: &[f64]| -> Local {
        let theta = place[terms];
        let all = columns.dot(&Array1::from(place.to_vec()));
        let (mut value, mut within) = (0.0, 0.0);
        let mut slopes = Array1::zeros(values.len());
        let mut weighted = columns.clone();
        for (i, (u, y)) in all.iter().zip(values).enumerate() {
            let (term, slope, curvature) = if *y <= bounds[0] {
                let (log, mills) = log_normal_cdf(-u);
                (log, -mills, mills * (mills - u))
            } else if *y >= bounds[1] {
                let (log, mills) = log_normal_cdf(*u);
                (log, mills, mills * (mills + u))
            } else {
                within += 1.0;
                (theta.ln() - 0.5 * u * u, -u, 1.0)
            };
            value += term;
            slopes[i] = slope;
            weighted.row_mut(i).mapv_inplace(|a| a * curvature);
        }
        let mut gradient = columns.t().dot(&slopes).to_vec();
        gradient[terms] += within / theta;
        let mut curvature = columns.t().dot(&weighted);
        curvature[[terms, terms]] += within / (theta * theta);
        Local { value, gradient, curvature }
    };
    let mut start = vec![0.0; terms + 1];
    start[terms] = 1.0;
    let place = maximise(start, PRECISION, likelihood);
    let log_likelihood = likelihood(&place).value;
    let sigma = scale / place[terms];
    Censored { coefficients: place[..terms].iter().map(|delta| delta * sigma).collect(), sigma, log_likelihood }
}

/// Returns ln Φ(z) and φ(z)/Φ(z).
fn log_normal_cdf(z: f64) -> (f64, f64) {
    if z > TAIL {
        let below = standard_normal_cdf(z);
        (below.ln(), standard_normal_pdf(z) / below)
    } else {
        let square = 1.0 / (z * z);
        let series = 1.0 - square * (1.0 - 3.0 * square * (1.0 - 5.0 * square));
        let log = -0.5 * z * z - (-z).ln() - 0.5 * std::f64::consts::TAU.ln() + series.ln();
        (log, -z / series)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity::random::{standard_normal, stream};

    /// Returns the design of a line, and values with normal errors.
    fn line(samples: usize) -> (Array2<f64>, Vec<f64>) {
        let xi = standard_normal(&mut stream(4, "censored", 0), 2 * samples);
        let design = Array2::from_shape_fn((samples, 2), |(i, j)| if j == 0 { 1.0 } else { xi[i] });
        let values = (0..samples).map(|i| 1e6 * (0.3 + xi[i] + 0.5 * xi[samples + i])).collect();
        (design, values)
    }

    /// Fits a line by expectation maximisation: replaces each censored value by its moments given the bound.
    fn by_expectation_maximisation(design: &Array2<f64>, values: &[f64], [low, high]: [f64; 2]) -> ([f64; 2], f64) {
        let (mut c, mut sigma) = ([0.0, 0.0], 1e6);
        for _ in 0..4000 {
            // Normal equations of a line.
            let (mut a, mut b, mut moments) = ([0.0; 3], [0.0; 2], Vec::new());
            for (row, y) in design.rows().into_iter().zip(values) {
                let mean = c[0] + c[1] * row[1];
                let (first, variance) = if *y <= low || *y >= high {
                    let sign = if *y <= low { -1.0 } else { 1.0 };
                    let bound = if *y <= low { low } else { high };
                    let z = sign * (mean - bound) / sigma;
                    let mills = standard_normal_pdf(z) / standard_normal_cdf(z);
                    (mean + sign * sigma * mills, sigma * sigma * (1.0 - mills * (mills + z)))
                } else {
                    (*y, 0.0)
                };
                moments.push((row[1], first, variance));
                a[0] += 1.0;
                a[1] += row[1];
                a[2] += row[1] * row[1];
                b[0] += first;
                b[1] += row[1] * first;
            }
            let determinant = a[0] * a[2] - a[1] * a[1];
            c = [(a[2] * b[0] - a[1] * b[1]) / determinant, (a[0] * b[1] - a[1] * b[0]) / determinant];
            let square = |(x, y, v): &(f64, f64, f64)| (y - c[0] - c[1] * x).powi(2) + v;
            sigma = (moments.iter().map(square).sum::<f64>() / a[0]).sqrt();
        }
        (c, sigma)
    }

    #[test]
    fn newton_agrees_with_expectation_maximisation() {
        let (design, latent) = line(300);
        for bounds in [[0.0, f64::INFINITY], [0.0, 1.2e6]] {
            let values: Vec<f64> = latent.iter().map(|y| y.clamp(bounds[0], bounds[1])).collect();
            let found = fit(design.view(), &values, bounds);
            let (c, sigma) = by_expectation_maximisation(&design, &values, bounds);
            for (found, wanted) in found.coefficients.iter().zip(c) {
                assert!((found - wanted).abs() < 1e-4 * sigma, "{found} {wanted}");
            }
            assert!((found.sigma / sigma - 1.0).abs() < 1e-4, "{} {sigma}", found.sigma);
        }
    }

    #[test]
    fn without_censoring_it_is_least_squares() {
        let (design, values) = line(200);
        let found = fit(design.view(), &values, [-1e9, f64::INFINITY]);
        let wanted = asperity::chaos::LeastSquares::new(design).unwrap().fit(&values).unwrap();
        for (found, wanted) in found.coefficients.iter().zip(&wanted.coefficients) {
            assert!((found - wanted).abs() < 1e-3, "{found} {wanted}");
        }
        let sigma = (wanted.residuals.iter().map(|r| r * r).sum::<f64>() / 200.0).sqrt();
        assert!((found.sigma / sigma - 1.0).abs() < 1e-8);
    }

    #[test]
    fn an_exact_line_ends_at_the_smallest_sigma() {
        let (design, _) = line(100);
        let values: Vec<f64> = design.rows().into_iter().map(|row| (2e6 * row[1] - 3e5).max(0.0)).collect();
        let found = fit(design.view(), &values, [0.0, f64::INFINITY]);
        assert!((found.coefficients[1] / 2e6 - 1.0).abs() < 1e-4 && (found.coefficients[0] / -3e5 - 1.0).abs() < 1e-3);
        assert!(found.sigma < 1e-4 * 2e6, "{}", found.sigma);
    }

    #[test]
    fn the_tail_of_the_normal_distribution_is_continuous() {
        let (above, below) = (log_normal_cdf(TAIL + 1e-12), log_normal_cdf(TAIL));
        assert!((above.0 - below.0).abs() < 1e-6 && (above.1 / below.1 - 1.0).abs() < 1e-6);
        assert!((log_normal_cdf(0.0).0 - 0.5_f64.ln()).abs() < 1e-15);
    }
}
