//! Published test functions of sparse expansions.

use asperity_testing::{BOREHOLE, ISHIGAMI, TestFunction};
use ndarray::Array1;

use super::*;
use crate::{Basis, Design, MultiIndexSet, PolynomialFamily, SamplingMethod, Truncation};

struct Problem {
    basis: Basis,
    families: Vec<PolynomialFamily>,
    function: TestFunction,
}

impl Problem {
    fn ishigami() -> Self {
        Self::new(MultiIndexSet::total_degree(3, 14).unwrap(), vec![PolynomialFamily::Legendre; 3], ISHIGAMI)
    }

    /// The hyperbolic set (Σ α_i^q)^{1/q} ≤ p with q = 3/4 and p = 5.
    fn borehole() -> Self {
        let truncation = Truncation { q: 0.75, ..Truncation::total_degree(5) };
        let set = MultiIndexSet::truncated(8, &truncation).unwrap();
        let families =
            (0..8).map(|i| if i < 2 { PolynomialFamily::Hermite } else { PolynomialFamily::Legendre }).collect();
        Self::new(set, families, BOREHOLE)
    }

    fn new(set: MultiIndexSet, families: Vec<PolynomialFamily>, function: TestFunction) -> Self {
        Self { basis: Basis::new(set, families.clone()).unwrap(), families, function }
    }

    fn points(&self, method: SamplingMethod, seed: u64, samples: usize) -> Vec<Vec<f64>> {
        let families = &self.families;
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
    fn errors(&self, design: SamplingMethod, samples: usize, fresh: usize) -> Vec<f64> {
        let tests = self.points(SamplingMethod::MonteCarlo, 99, fresh);
        let error = |seed| {
            let points = self.points(design, seed, samples);
            let response: Vec<f64> = points.iter().map(|x| (self.function.evaluate)(x)).collect();
            let fit = select(&self.matrix(&points), &response).unwrap();
            let dense = Array1::from(fit.dense(self.basis.len()));
            let square = |points: &[Vec<f64>]| -> f64 {
                let predicted = self.matrix(points).dot(&dense);
                predicted.iter().zip(points).map(|(p, x)| (p - (self.function.evaluate)(x)).powi(2)).sum()
            };
            tests.chunks(1000).map(square).sum::<f64>() / (fresh as f64 * self.function.variance)
        };
        (0..5).map(error).collect()
    }
}

fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|v| v.ln()).sum::<f64>() / values.len() as f64).exp()
}

/// Bounds each design method by the geometric mean over five designs.
fn assert_errors(problem: &Problem, samples: usize, fresh: usize, bound: f64) {
    for design in [SamplingMethod::LatinHypercube, SamplingMethod::Sobol] {
        let errors = problem.errors(design, samples, fresh);
        let mean = geometric_mean(&errors);
        println!("{design:?}: {mean:.2e} of {errors:?}");
        assert!(mean <= bound, "{design:?}: {mean:.2e} of {errors:?}");
    }
}

#[test]
#[ignore = "slow"]
fn ishigami_at_100_samples_of_680_terms() {
    let problem = Problem::ishigami();
    assert_eq!(problem.basis.len(), 680);
    assert_errors(&problem, 100, 20_000, 1e-9);
}

#[test]
#[ignore = "slow"]
fn borehole_at_150_samples_of_a_hyperbolic_set() {
    let problem = Problem::borehole();
    assert_errors(&problem, 150, 5_000, 5e-5);
}
