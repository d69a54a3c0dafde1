//! Weighted nonlinear least squares in a few bounded parameters.

use super::{dot, solution};

/// Bounds of a positive parameter, searched on a logarithmic scale.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

impl Range {
    fn at(&self, t: f64) -> f64 {
        self.low * (self.high / self.low).powf(1.0 / (1.0 + (-t).exp()))
    }

    fn inverse(&self, value: f64) -> f64 {
        let fraction = ((value / self.low).ln() / (self.high / self.low).ln()).clamp(1e-3, 1.0 - 1e-3);
        (fraction / (1.0 - fraction)).ln()
    }
}

/// Minimises the sum of squares of `residuals(parameters)` within `ranges` by Levenberg–Marquardt with forward
/// differences from `start`, and returns the parameters and the sum.
///
/// # References
/// Marquardt, *J. Soc. Indust. Appl. Math.* **11** (1963) 431, <https://doi.org/10.1137/0111030>.
pub fn least_squares(residuals: &dyn Fn(&[f64]) -> Vec<f64>, start: &[f64], ranges: &[Range]) -> (Vec<f64>, f64) {
    let count = start.len();
    let real = |t: &[f64]| -> Vec<f64> { t.iter().zip(ranges).map(|(t, range)| range.at(*t)).collect() };
    let square = |r: &[f64]| r.iter().map(|v| v * v).sum::<f64>();
    let mut t: Vec<f64> = start.iter().zip(ranges).map(|(value, range)| range.inverse(*value)).collect();
    let mut now = residuals(&real(&t));
    let mut sum = square(&now);
    let mut damping = 1e-3;
    for _ in 0..100 {
        let step = 1e-6;
        let slopes: Vec<Vec<f64>> = (0..count)
            .map(|p| {
                let mut moved = t.clone();
                moved[p] += step;
                residuals(&real(&moved)).iter().zip(&now).map(|(after, before)| (after - before) / step).collect()
            })
            .collect();
        let normal: Vec<Vec<f64>> = slopes.iter().map(|a| slopes.iter().map(|b| dot(a, b)).collect()).collect();
        let gradient: Vec<f64> = slopes.iter().map(|a| -dot(a, &now)).collect();
        let mut improved = false;
        while damping < 1e12 {
            let mut matrix = normal.clone();
            for (p, row) in matrix.iter_mut().enumerate() {
                row[p] += damping * row[p].max(1e-12);
            }
            let change = solution(matrix, &gradient);
            // A step of 2 in the logistic variable is a third of the range; longer steps are not local.
            let trial: Vec<f64> =
                t.iter().zip(&change).map(|(t, d)| (t + d.clamp(-2.0, 2.0)).clamp(-12.0, 12.0)).collect();
            let after = residuals(&real(&trial));
            let lower = square(&after);
            if lower < sum {
                let moved = trial.iter().zip(&t).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
                let gain = sum - lower;
                (t, now) = (trial, after);
                improved = gain > 1e-10 * sum && moved > 1e-8;
                sum = lower;
                damping = (damping * 0.2).max(1e-12);
                break;
            }
            damping *= 5.0;
        }
        if !improved {
            break;
        }
    }
    (real(&t), sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_data_give_exact_parameters() {
        let model = |p: &[f64], x: f64| p[0] * (-x / p[1]).exp() + p[2];
        let truth = [2.0, 0.7, 0.05];
        let residuals =
            |p: &[f64]| (0..40).map(|i| model(p, 0.1 * f64::from(i)) - model(&truth, 0.1 * f64::from(i))).collect();
        let ranges = [Range { low: 0.1, high: 10.0 }; 3];
        let ranges = [ranges[0], ranges[1], Range { low: 1e-4, high: 1.0 }];
        let (found, sum) = least_squares(&residuals, &[1.0, 3.0, 0.5], &ranges);
        assert!(sum < 1e-16, "{sum:e}");
        assert!(found.iter().zip(truth).all(|(f, t)| (f / t - 1.0).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn a_minimum_outside_the_range_ends_at_its_bound() {
        let residuals = |p: &[f64]| vec![p[0] - 5.0];
        let (found, _) = least_squares(&residuals, &[0.5], &[Range { low: 0.1, high: 1.0 }]);
        assert!(found[0] > 0.99 && found[0] <= 1.0);
    }
}
