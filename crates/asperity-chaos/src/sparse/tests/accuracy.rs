//! Published test functions of sparse expansions.

use std::f64::consts::PI;

use ndarray::Array1;

use super::*;
use crate::{Basis, Design, MultiIndexSet, PolynomialFamily, SamplingMethod, Truncation};

/// Evaluates Ishigami's function with (a, b) = (7, 0.1) of variables on [−1, 1].
fn ishigami(x: &[f64]) -> f64 {
    let (first, second, third) = ((PI * x[0]).sin(), (PI * x[1]).sin(), PI * x[2]);
    first + 7.0 * second * second + 0.1 * third.powi(4) * first
}

const ISHIGAMI_VARIANCE: f64 = 13.844_587_940_719_254;

/// Evaluates the flow through a borehole, a function of two normal variables and six on [−1, 1].
fn borehole(x: &[f64]) -> f64 {
    let between = |low: f64, high: f64, x: f64| 0.5 * (low + high) + 0.5 * (high - low) * x;
    let well_m = 0.10 + 0.016_181_2 * x[0];
    let log_ratio = (7.71 + 1.0056 * x[1]) - well_m.ln();
    let upper = between(63_070.0, 115_600.0, x[2]);
    let head_m = between(990.0, 1110.0, x[3]) - between(700.0, 820.0, x[5]);
    let lower = between(63.1, 116.0, x[4]);
    let (length_m, conductivity) = (between(1120.0, 1680.0, x[6]), between(9855.0, 12_045.0, x[7]));
    let leak = 2.0 * length_m * upper / (log_ratio * well_m * well_m * conductivity);
    2.0 * PI * upper * head_m / (log_ratio * (1.0 + leak + upper / lower))
}

const BOREHOLE_VARIANCE: f64 = 817.69;

struct Problem {
    basis: Basis,
    function: fn(&[f64]) -> f64,
    variance: f64,
}

impl Problem {
    fn ishigami() -> Self {
        let basis =
            Basis::new(MultiIndexSet::total_degree(3, 14).unwrap(), vec![PolynomialFamily::Legendre; 3]).unwrap();
        Self { basis, function: ishigami, variance: ISHIGAMI_VARIANCE }
    }

    /// The hyperbolic set (Σ α_i^q)^{1/q} ≤ p with q = 3/4 and p = 5.
    fn borehole() -> Self {
        let truncation = Truncation { q: 0.75, ..Truncation::total_degree(5) };
        let set = MultiIndexSet::truncated(8, &truncation).unwrap();
        let families =
            (0..8).map(|i| if i < 2 { PolynomialFamily::Hermite } else { PolynomialFamily::Legendre }).collect();
        Self { basis: Basis::new(set, families).unwrap(), function: borehole, variance: BOREHOLE_VARIANCE }
    }

    fn points(&self, method: SamplingMethod, seed: u64, samples: usize) -> Vec<Vec<f64>> {
        let families = self.basis.families();
        let design = Design::new(method, seed, "accuracy", samples, families.len()).unwrap();
        let mut unit = vec![0.0; families.len()];
        let point = |index| {
            design.fill_unit(index, &mut unit);
            families.iter().zip(&unit).map(|(family, &u)| family.from_unit(u)).collect()
        };
        (0..samples).map(point).collect()
    }

    fn matrix(&self, points: &[Vec<f64>]) -> Array2<f64> {
        self.basis.design_matrix(points)
    }

    /// Returns the mean square error divided by the variance at fresh points, for designs of seeds 0 to 4.
    fn errors(&self, design: SamplingMethod, samples: usize, regression: SparseRegression, fresh: usize) -> Vec<f64> {
        let tests = self.points(SamplingMethod::MonteCarlo, 99, fresh);
        let error = |seed| {
            let points = self.points(design, seed, samples);
            let response: Vec<f64> = points.iter().map(|x| (self.function)(x)).collect();
            let fit = regression.select(&Candidates::new(self.matrix(&points).view()).unwrap(), &response).unwrap();
            let dense = Array1::from(fit.dense(self.basis.len()));
            let square = |points: &[Vec<f64>]| -> f64 {
                let predicted = self.matrix(points).dot(&dense);
                predicted.iter().zip(points).map(|(p, x)| (p - (self.function)(x)).powi(2)).sum()
            };
            tests.chunks(1000).map(square).sum::<f64>() / (fresh as f64 * self.variance)
        };
        (0..5).map(error).collect()
    }
}

fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|v| v.ln()).sum::<f64>() / values.len() as f64).exp()
}

/// Bounds each design method by the geometric mean over five designs.
fn assert_errors(problem: &Problem, regression: SparseRegression, samples: usize, fresh: usize, bound: f64) {
    for design in [SamplingMethod::LatinHypercube, SamplingMethod::Sobol] {
        let errors = problem.errors(design, samples, regression, fresh);
        let mean = geometric_mean(&errors);
        println!("{regression:?}, {design:?}: {mean:.2e} of {errors:?}");
        assert!(mean <= bound, "{regression:?}, {design:?}: {mean:.2e} of {errors:?}");
    }
}

#[test]
#[ignore = "slow"]
fn ishigami_at_100_samples_of_680_terms() {
    let problem = Problem::ishigami();
    assert_eq!(problem.basis.len(), 680);
    // Subspace pursuit by cross-validation is excluded: a part in which it fails dominates its error.
    for regression in [
        by_leave_one_out(SparseMethod::OrthogonalMatchingPursuit),
        by_cross_validation(SparseMethod::OrthogonalMatchingPursuit),
        by_leave_one_out(SparseMethod::SubspacePursuit),
    ] {
        assert_errors(&problem, regression, 100, 20_000, 1e-9);
    }
}

#[test]
#[ignore = "slow"]
fn borehole_at_150_samples_of_a_hyperbolic_set() {
    let problem = Problem::borehole();
    for method in [SparseMethod::OrthogonalMatchingPursuit, SparseMethod::SubspacePursuit] {
        for regression in [by_leave_one_out(method), by_cross_validation(method)] {
            assert_errors(&problem, regression, 150, 5_000, 5e-5);
        }
    }
}
