//! Records for tests.

use crate::random::{Stream, standard_normal};

/// Returns `n` values of a stationary Gaussian process of unit variance with correlation φ^lag.
pub(crate) fn autoregressive(phi: f64, n: usize, stream: &mut Stream) -> Vec<f64> {
    let mut values = standard_normal(stream, n);
    for i in 1..n {
        values[i] = phi * values[i - 1] + (1.0 - phi * phi).sqrt() * values[i];
    }
    values
}
