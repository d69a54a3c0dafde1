//! Random records.

use asperity_base::random::{self, Stream};

/// Returns `n` values of a stationary Gaussian process of unit variance with correlation φ^lag.
pub fn autoregressive(phi: f64, n: usize, stream: &mut Stream) -> Vec<f64> {
    let mut values = random::standard_normal(stream, n);
    for i in 1..n {
        values[i] = phi * values[i - 1] + (1.0 - phi * phi).sqrt() * values[i];
    }
    values
}
