//! Distances between distributions.

/// Returns the Kolmogorov–Smirnov distance between a discrete distribution of values that are not negative and a
/// distribution function that jumps at zero only.
///
/// `values` increase strictly; `cumulative` are the probabilities up to and including them.
pub fn kolmogorov_smirnov_to(values: &[f64], cumulative: &[f64], cdf: impl Fn(f64) -> f64) -> f64 {
    let left = |x: f64| if x <= 0.0 { 0.0 } else { cdf(x) };
    let below = std::iter::once(&0.0).chain(cumulative);
    let steps = values.iter().zip(cumulative.iter().zip(below));
    steps.map(|(&x, (to, below))| (to - cdf(x)).abs().max((below - left(x)).abs())).fold(0.0, f64::max)
}
