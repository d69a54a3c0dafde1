//! Gamma distribution with a given shift.

use crate::distribution::special::{digamma, trigamma};
use crate::distribution::{DistributionError, Marginal};

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
    if !(deficit.is_finite() && deficit > 0.0) {
        let reason = "a value lies at the shift, or all are nearly equal";
        return Err(DistributionError::Sample { distribution: "gamma", n: sorted.len(), reason });
    }
    let mut shape = (3.0 - deficit + ((deficit - 3.0).powi(2) + 24.0 * deficit).sqrt()) / (12.0 * deficit);
    for _ in 0..50 {
        let excess = shape.ln() - digamma(shape) - deficit;
        let slope = shape * shape * (1.0 / shape - trigamma(shape));
        let next = 1.0 / (1.0 / shape + excess / slope);
        let moved = (next / shape - 1.0).abs();
        shape = next;
        if moved < 1e-14 || !moved.is_finite() {
            break;
        }
    }
    Marginal::gamma(shape, mean / shape, shift)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_most_likely, sample};
    use super::super::{End, Family, fit};
    use crate::distribution::Marginal;
    use crate::distribution::special::trigamma;

    fn near(marginal: &Marginal, shifted: bool) -> Vec<Marginal> {
        let Marginal::Gamma { shape, scale, shift } = *marginal else { panic!() };
        let mut marginals = vec![];
        for h in [-1e-3, 1e-3] {
            marginals.push(Marginal::gamma(shape + h, scale, shift).unwrap());
            marginals.push(Marginal::gamma(shape, scale + h, shift).unwrap());
            if shifted {
                marginals.push(Marginal::gamma(shape, scale, shift + h).unwrap());
            }
        }
        marginals
    }

    #[test]
    fn two_parameters_are_found_within_their_standard_errors() {
        let n = 2000;
        for (index, wanted) in [0.6, 2.0, 40.0].into_iter().enumerate() {
            let values = sample(&format!("gamma:{wanted},2"), n, 80 + index as u64);
            let fitted = fit(Family::Gamma, &values).unwrap();
            let Marginal::Gamma { shape, scale, .. } = fitted.marginal else { panic!() };
            // The inverse Fisher information: var k = k/(k ψ′ − 1)/n, var s = s² ψ′/(k ψ′ − 1)/n.
            let curve = trigamma(wanted);
            let rest = (wanted * curve - 1.0) * n as f64;
            assert!((shape - wanted).abs() < 4.0 * (wanted / rest).sqrt(), "{shape}");
            assert!((scale - 2.0).abs() < 4.0 * 2.0 * (curve / rest).sqrt(), "{scale}");
            assert_most_likely(&fitted, &values, &near(&fitted.marginal, false));
        }
    }

    #[test]
    fn a_shift_is_found_and_is_a_local_maximum() {
        let values = sample("gamma:4,2,-7", 4000, 84);
        let fitted = fit(Family::ShiftedGamma, &values).unwrap();
        let Marginal::Gamma { shift, .. } = fitted.marginal else { panic!() };
        assert!((shift + 7.0).abs() < 1.0, "{fitted:?}");
        assert_eq!(fitted.low_end, End::Fitted);
        assert_most_likely(&fitted, &values, &near(&fitted.marginal, true));
    }
}
