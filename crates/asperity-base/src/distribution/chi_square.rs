//! Quantiles of the chi-square distribution.

use statrs::function::gamma::{gamma_lr, gamma_ur};

use super::special::standard_normal_quantile;
use crate::numeric::root_between;

/// Returns the quantile of the chi-square distribution at a probability between 0 and 1, for any positive, also
/// fractional, degrees of freedom ν: the x with P(ν/2, x/2) = `probability`, P the regularised incomplete gamma
/// function.
///
/// NaN when an argument is outside its range.
#[doc(hidden)]
pub fn chi_square_quantile(degrees_of_freedom: f64, probability: f64) -> f64 {
    let nu = degrees_of_freedom;
    if !(nu > 0.0 && nu.is_finite() && probability > 0.0 && probability < 1.0) {
        return f64::NAN;
    }
    // Take the difference in the smaller tail.
    let difference = |x: f64| {
        if probability <= 0.5 {
            gamma_lr(0.5 * nu, 0.5 * x) - probability
        } else {
            1.0 - probability - gamma_ur(0.5 * nu, 0.5 * x)
        }
    };
    // Wilson–Hilferty approximation, inaccurate only for few degrees of freedom.
    let third = 2.0 / (9.0 * nu);
    let guess = nu * (1.0 - third + standard_normal_quantile(probability) * third.sqrt()).max(0.1).powi(3);
    let (mut low, mut high) = (0.9 * guess, 1.1 * guess);
    while difference(low) > 0.0 && low > f64::MIN_POSITIVE {
        low *= 0.5;
    }
    while difference(high) < 0.0 {
        high *= 2.0;
    }
    root_between(difference, [low, difference(low)], [high, difference(high)]).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_degrees_of_freedom_are_an_exponential_distribution() {
        // 1 − e^{−x/2}.
        for probability in [1e-6_f64, 0.025, 0.5, 0.975, 0.999] {
            let wanted = -2.0 * (-probability).ln_1p();
            assert!((chi_square_quantile(2.0, probability) / wanted - 1.0).abs() < 1e-11);
        }
    }

    #[test]
    fn quantiles_are_those_of_published_tables() {
        // Abramowitz & Stegun, table 26.8, at 2.5 % and 97.5 %; for 1 the square of Φ⁻¹ as well.
        for (nu, low, high) in [
            (1.0, 9.820_69e-4, 5.023_89),
            (4.0, 0.484_419, 11.143_3),
            (10.0, 3.246_97, 20.483_1),
            (30.0, 16.790_8, 46.979_2),
            (100.0, 74.221_9, 129.561),
        ] {
            assert!((chi_square_quantile(nu, 0.025) / low - 1.0).abs() < 1e-5, "{nu}");
            assert!((chi_square_quantile(nu, 0.975) / high - 1.0).abs() < 1e-5, "{nu}");
        }
    }

    #[test]
    fn many_degrees_of_freedom_are_nearly_normal() {
        // ν + z√(2ν) + 2(z² − 1)/3 up to terms of 1/√ν (Cornish and Fisher).
        let (nu, z) = (1e6_f64, 1.959_963_984_540_054_f64);
        let wanted = nu + z * (2.0 * nu).sqrt() + 2.0 * (z * z - 1.0) / 3.0;
        assert!((chi_square_quantile(nu, 0.975) - wanted).abs() < 0.01);
        assert!(chi_square_quantile(0.0, 0.5).is_nan() && chi_square_quantile(3.0, 1.0).is_nan());
    }
}
