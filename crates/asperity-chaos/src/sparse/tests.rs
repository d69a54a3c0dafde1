mod accuracy;
mod cross_validation;
mod oracles;
mod refusals;

use ndarray::Array2;

use super::growing_fit::GrowingFit;
use super::matching_pursuit::pursue;
use super::*;
use asperity_base::random::{standard_normal, stream};

/// Selects from a design with the default settings.
fn select(design: &Array2<f64>, response: &[f64]) -> Result<SparseFit, SparseError> {
    SparseRegression::default().select(&Candidates::new(design.view()).unwrap(), response)
}

/// Returns a constant column and independent standard normal columns.
fn normal_design(seed: u64, samples: usize, columns: usize) -> Array2<f64> {
    let values = standard_normal(&mut stream(seed, "sparse design", 0), samples * columns);
    let mut design = Array2::from_shape_vec((samples, columns), values).unwrap();
    design.column_mut(0).fill(1.0);
    design
}

/// Returns Σ c_j x_j.
fn combination(design: &Array2<f64>, terms: &[(usize, f64)]) -> Vec<f64> {
    design.rows().into_iter().map(|row| terms.iter().map(|&(j, c)| c * row[j]).sum()).collect()
}

/// Returns a response with a few large terms and noise.
fn noisy_response(design: &Array2<f64>, noise: f64) -> Vec<f64> {
    let signal = combination(design, &[(0, 3.0), (4, 2.0), (9, -1.5), (17, 1.0), (30, 0.7)]);
    let errors = standard_normal(&mut stream(3, "sparse noise", 0), signal.len());
    signal.iter().zip(errors).map(|(y, e)| y + noise * e).collect()
}
