//! Gamma distribution with a given shift.

use crate::distribution::special::{digamma, trigamma};
use crate::distribution::{DistributionError, Marginal};

/// Least ln mean t − mean ln t of which rounding leaves some digits. It is about 1/(2k), half the squared coefficient of variation.
const LEAST_DEFICIT: f64 = 1e-12;

/// Returns the maximum-likelihood Gamma distribution with this shift.
///
/// The shape k is the root of ln k − ψ(k) = ln mean t − mean ln t, by Newton's method on 1/k from Minka's
/// approximation, which is within 1.5 %; the scale is mean t/k.
///
/// # References
/// Choi & Wette, *Technometrics* **11** (1969) 683, <https://doi.org/10.1080/00401706.1969.10490731>.
pub(super) fn fit(sorted: &[f64], shift: f64) -> Result<Marginal, DistributionError> {
    let n = sorted.len() as f64;
    let mean = sorted.iter().map(|x| x - shift).sum::<f64>() / n;
    // Relative to the mean, which preserves the accuracy of the difference.
    let deficit = -sorted.iter().map(|x| ((x - shift) / mean).ln()).sum::<f64>() / n;
    if !(deficit.is_finite() && deficit > LEAST_DEFICIT) {
        let reason = "a value lies at the shift, or all are nearly equal";
        return Err(DistributionError::Sample { distribution: "gamma", n: sorted.len(), reason });
    }
    let mut shape = (3.0 - deficit + ((deficit - 3.0).powi(2) + 24.0 * deficit).sqrt()) / (12.0 * deficit);
    for _ in 0..50 {
        let excess = shape.ln() - digamma(shape) - deficit;
        let slope = shape * shape * (1.0 / shape - trigamma(shape));
        let next = 1.0 / (1.0 / shape + excess / slope);
        if !(next.is_finite() && next > 0.0) {
            break;
        }
        let moved = (next / shape - 1.0).abs();
        shape = next;
        if moved < 1e-14 {
            break;
        }
    }
    Marginal::gamma(shape, mean / shape, shift)
}

#[cfg(test)]
mod tests {
    use crate::distribution::Marginal;

    #[test]
    fn nearly_equal_values_have_the_shape_of_their_variation_or_are_refused() {
        for exponent in 1..17 {
            let spread = 10.0_f64.powi(-exponent);
            let sorted: Vec<f64> = (0..11).map(|i| 1.0 + spread * (f64::from(i) - 5.0)).collect();
            // The variance of −5 … 5 is 10.
            let wanted = 1.0 / (10.0 * spread * spread);
            match super::fit(&sorted, 0.0) {
                Ok(Marginal::Gamma { shape, .. }) => {
                    assert!(exponent < 2 || (shape / wanted - 1.0).abs() < 0.05, "{exponent}: {shape} for {wanted}");
                }
                Ok(other) => panic!("{other:?}"),
                Err(_) => assert!(wanted > 1e11, "{exponent}"),
            }
        }
    }
}
