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
    use super::super::tests::sample;
    use super::super::{Family, fit};
    use crate::distribution::DistributionError;

    #[test]
    fn a_sample_that_leans_left_has_no_shifted_lognormal_distribution() {
        let values: Vec<f64> = sample("lognormal:0,0.5", 500, 5).iter().map(|x| -x).collect();
        assert!(matches!(fit(Family::ShiftedLognormal, &values), Err(DistributionError::Sample { .. })));
    }
}
