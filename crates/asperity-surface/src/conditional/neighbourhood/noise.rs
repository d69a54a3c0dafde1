//! Variance of the measured heights that the correlation does not explain.

use ndarray::Array2;

use crate::conditional::lags::Lags;
use asperity_base::blocks;
use asperity_base::map::Grid;
use asperity_base::numeric::{Cholesky, dot};

/// Candidate variances of the noise over the variance of the heights, from [`LEAST_NOISE`] up by factors of ten.
const DECADES: i32 = 8;
/// Least noise, always included because rounding makes smooth correlations singular.
pub(super) const LEAST_NOISE: f64 = 1e-10;
/// Side in points of the patches used for the likelihood, and their number along a side of the map.
const PATCH: usize = 12;
const PATCHES: usize = 6;
/// Least gain in log-likelihood for which more noise is chosen.
const DECISIVE: f64 = 3.0;

/// Returns the most likely variance of white noise on `values` at `places`, in decades from 1e-10 to 1e-2 of the
/// variance `variance` of the field: the least one that no other exceeds decisively.
///
/// A correlation smoother than the heights, such as a fitted model without measurement noise, would cause oscillations
/// in the voids: the steps between neighbouring heights are then extremely unlikely, and the field continues them.
pub(super) fn likeliest_noise(lags: &Lags, grid: Grid, places: &[usize], values: &[f64], variance: f64) -> f64 {
    let (ny, nx) = grid.shape();
    let mut at = vec![f64::NAN; nx * ny];
    places.iter().zip(values).for_each(|(place, value)| at[*place] = *value);
    let corner = |i: usize, n: usize| i * n.saturating_sub(PATCH) / (PATCHES - 1);
    let likelihoods: Vec<Vec<f64>> = blocks::map(0..PATCHES * PATCHES, |index| {
        let (top, left) = (corner(index / PATCHES, ny), corner(index % PATCHES, nx));
        let mut patch = Vec::new();
        for row in top..(top + PATCH).min(ny) {
            for column in left..(left + PATCH).min(nx) {
                let value = at[row * nx + column];
                if !value.is_nan() {
                    patch.push((column as isize, row as isize, value));
                }
            }
        }
        (0..=DECADES).map(|decade| likelihood(lags, &patch, noise(decade), variance)).collect()
    });
    let sums: Vec<f64> = (0..=DECADES as usize).map(|d| likelihoods.iter().map(|l| l[d]).sum()).collect();
    let best = sums.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = sums.iter().position(|sum| *sum >= best - DECISIVE).unwrap_or(0);
    noise(least as i32)
}

fn noise(decade: i32) -> f64 {
    LEAST_NOISE * 10.0_f64.powi(decade)
}

/// Returns the logarithm of the Gaussian density of the values of a patch, up to a constant.
fn likelihood(lags: &Lags, patch: &[(isize, isize, f64)], noise: f64, variance: f64) -> f64 {
    let n = patch.len();
    let between = Array2::from_shape_fn((n, n), |(i, j)| {
        lags.at(patch[i].0 - patch[j].0, patch[i].1 - patch[j].1) + if i == j { noise } else { 0.0 }
    });
    let Some(factor) = Cholesky::new(between) else { return f64::NEG_INFINITY };
    let values: Vec<f64> = patch.iter().map(|point| point.2).collect();
    let misfit = dot(&values, &factor.solve(&values)) / variance;
    -0.5 * (misfit + factor.log_determinant())
}
