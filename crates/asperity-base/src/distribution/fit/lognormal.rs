//! Lognormal distribution with a given shift.

use crate::distribution::{DistributionError, Marginal};
use crate::stats::Moments;

/// Returns the maximum-likelihood lognormal distribution with this shift, from mean and standard deviation of ln(x −
/// shift).
pub(super) fn fit(sorted: &[f64], shift: f64) -> Result<Marginal, DistributionError> {
    let moments = Moments::from_values(sorted.iter().map(|x| (x - shift).ln()));
    Marginal::lognormal(moments.mean, moments.std, shift)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_most_likely, sample};
    use super::super::{End, Family, fit};
    use crate::distribution::{DistributionError, Marginal};

    #[test]
    fn two_parameters_are_found_within_their_standard_errors() {
        let n = 2000;
        let Marginal::Lognormal { mu, sigma, shift } =
            fit(Family::Lognormal, &sample("lognormal:0.4,0.7", n, 3)).unwrap().marginal
        else {
            panic!()
        };
        let error = 0.7 / (n as f64).sqrt();
        assert!((mu - 0.4).abs() < 4.0 * error && (sigma - 0.7).abs() < 4.0 * error / 2.0_f64.sqrt());
        assert_eq!(shift, 0.0);
    }

    #[test]
    fn a_shift_is_found_and_is_a_local_maximum() {
        let values = sample("lognormal:0.4,0.7,-3", 2000, 4);
        let fitted = fit(Family::ShiftedLognormal, &values).unwrap();
        let Marginal::Lognormal { mu, sigma, shift } = fitted.marginal else { panic!() };
        // Standard errors by the inverse Fisher information.
        for (found, wanted, error) in [(mu, 0.4, 0.0281), (sigma, 0.7, 0.0197), (shift, -3.0, 0.0272)] {
            assert!((found - wanted).abs() < 4.0 * error, "{fitted:?}");
        }
        assert_eq!(fitted.low_end, End::Fitted);
        let neighbours: Vec<Marginal> = [(1e-3, 0.0, 0.0), (-1e-3, 0.0, 0.0), (0.0, 1e-3, 0.0), (0.0, -1e-3, 0.0)]
            .into_iter()
            .chain([(0.0, 0.0, 1e-3), (0.0, 0.0, -1e-3)])
            .map(|(m, s, t)| Marginal::lognormal(mu + m, sigma + s, shift + t).unwrap())
            .collect();
        assert_most_likely(&fitted, &values, &neighbours);
    }

    #[test]
    fn a_sample_that_leans_left_has_no_shifted_lognormal_distribution() {
        let values: Vec<f64> = sample("lognormal:0,0.5", 500, 5).iter().map(|x| -x).collect();
        assert!(matches!(fit(Family::ShiftedLognormal, &values), Err(DistributionError::Sample { .. })));
    }
}
