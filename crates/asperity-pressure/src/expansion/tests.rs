use super::*;
use asperity_base::distribution::standard_normal_cdf;
use asperity_chaos::{Design, DiscreteDistribution, SamplingMethod, distance};

fn xi_samples(stage: &str, samples: usize, dimensions: usize) -> Vec<Vec<f64>> {
    let design = Design::new(SamplingMethod::LatinHypercube, 9, stage, samples, dimensions).unwrap();
    (0..samples).map(|i| design.xi(i)).collect()
}

fn independent(pressures_pa: &[f64], evaluations: usize) -> TrainingSamples<'_> {
    TrainingSamples { pressures_pa, groups: None, evaluations, largest_pa: f64::INFINITY }
}

fn estimate_of(
    response: Response,
    pressure: impl Fn(&[f64]) -> f64,
    samples: usize,
    basis: Basis,
) -> Result<(PressureEstimate, DiscreteDistribution), MethodError> {
    let variables = basis.set().variables();
    let (fine, fresh) = (xi_samples("fine", samples, variables), xi_samples("fresh", 3000, variables));
    let pressures: Vec<f64> = fine.iter().map(|xi| pressure(xi)).collect();
    let truth: Vec<f64> = fresh.iter().map(|xi| pressure(xi)).collect();
    let estimate = estimate(response, &fine, independent(&pressures, fresh.len()), basis, &fresh, 1)?;
    Ok((estimate, DiscreteDistribution::empirical(&truth)?))
}

#[test]
fn a_polynomial_pressure_is_recovered_exactly() {
    // The pressure is always positive: nothing is truncated and eq. (8) is exact.
    let pressure = |xi: &[f64]| 3.0 + (xi[0] - 0.5 * xi[1]).powi(2) + 0.1 * (xi[2] * xi[0]).powi(2);
    let basis = Basis::hermite(3, 4).unwrap();
    let (estimate, truth) = estimate_of(Response::Pressure, pressure, 120, basis).unwrap();
    assert!(estimate.leave_one_out_error.unwrap() < 1e-20);
    assert!(distance::wasserstein_1(&estimate.distribution, &truth) < 1e-10);
    // The only error is the choice of 3,000 fresh samples.
    let evaluations = truth.std() / 3000.0_f64.sqrt();
    // Its standard deviation is estimated from 120 samples with a relative standard error of 1/√240 = 6 % for a normal
    // distribution.
    assert!((estimate.mean_se_pa / evaluations - 1.0).abs() < 0.3, "{} {evaluations}", estimate.mean_se_pa);
    assert_eq!(estimate.contact_probability_interval.unwrap().high, 1.0);
    assert!(estimate.contact_probability_interval.unwrap().low > 0.96);
}

#[test]
fn a_lognormal_pressure_is_recovered_exactly_by_its_logarithm() {
    let pressure = |xi: &[f64]| (15.0 + 0.8 * xi[0] - 0.3 * xi[1] + 0.1 * xi[0] * xi[1]).exp();
    let basis = Basis::hermite(2, 2).unwrap();
    let (estimate, truth) = estimate_of(Response::Logarithm, pressure, 40, basis).unwrap();
    assert!(distance::wasserstein_1(&estimate.distribution, &truth) < 1e-10 * truth.std());
}

#[test]
fn the_standard_error_of_the_mean_is_that_of_least_squares() {
    // p = 50 + ξ₀ + ε, where ε is not in the model: the mean is the constant of the line, known to σ_ε/√n.
    let (samples, fresh) = (400, xi_samples("fresh", 20_000, 1));
    let fine = xi_samples("noisy", samples, 2);
    let pressures: Vec<f64> = fine.iter().map(|xi| 50.0 + xi[0] + xi[1]).collect();
    let basis = Basis::hermite(1, 1).unwrap();
    let estimate = estimate(Response::Pressure, &fine, independent(&pressures, fresh.len()), basis, &fresh, 3).unwrap();
    let wanted = (1.0 / samples as f64 + 1.0 / 20_000.0).sqrt();
    // The standard deviation of 400 samples has a relative standard error of 1/√800 = 3.5 %.
    assert!((estimate.mean_se_pa / wanted - 1.0).abs() < 0.15, "{} {wanted}", estimate.mean_se_pa);
    assert!(estimate.mean_bias_pa.unwrap().abs() < 4.0 * wanted);
    // The distribution of 50 + ξ₀ + ε is N(50, 2), the distribution of the expansion N(50, 1).
    let band = estimate.band.unwrap();
    for (i, value) in band.values.iter().enumerate() {
        let [low, high] = band.simultaneous(i);
        let f = standard_normal_cdf((value - 50.0) / 2.0_f64.sqrt());
        assert!(low <= f && f <= high, "{value}: {low} {f} {high}");
        let own = standard_normal_cdf(value - 50.0);
        assert!((band.bias[i] - (own - f)).abs() < 4.0 * band.standard_errors[i], "{value}: {}", band.bias[i]);
    }
}

#[test]
fn an_exponent_beyond_the_largest_number_is_a_reason_not_a_pressure() {
    let pressure = |xi: &[f64]| (260.0 * xi[0].clamp(-2.5, 2.5)).exp();
    let outcome = estimate_of(Response::Logarithm, pressure, 100, Basis::hermite(1, 1).unwrap());
    assert!(matches!(outcome, Err(MethodError::Overflow { overflowed: 1.., evaluations: 3000 })), "{outcome:?}");
}

#[test]
fn a_lognormal_pressure_above_the_hardness_becomes_a_point_mass_at_the_hardness() {
    // ln p = 20 + ξ on samples with |ξ| < 1.4, all below the hardness e^{21.5}: the expansion is exact, and on fresh
    // samples it exceeds the hardness with probability Φ(−1.5).
    let hardness = 21.5_f64.exp();
    let fine: Vec<Vec<f64>> = (0..80).map(|i| vec![-1.4 + 2.8 * f64::from(i) / 79.0]).collect();
    let pressures: Vec<f64> = fine.iter().map(|xi| (20.0 + xi[0]).exp()).collect();
    let fresh = xi_samples("fresh", 20_000, 1);
    let training = TrainingSamples { largest_pa: hardness, ..independent(&pressures, fresh.len()) };
    let basis = Basis::hermite(1, 1).unwrap();
    let found = estimate(Response::Logarithm, &fine, training, basis, &fresh, 1).unwrap();
    assert_eq!(found.distribution.quantile(1.0), hardness);
    // The fresh samples are stratified, so each fraction is exact up to one stratum.
    let beyond = standard_normal_cdf(-1.5);
    assert!(
        (1.0 - found.distribution.cdf_left(hardness) - beyond).abs() < 2.0 / 20_000.0,
        "{}",
        found.distribution.cdf_left(hardness)
    );
    // E min(e^{20+ξ}, H) = e^{20.5} Φ(1.5 − 1) + H Φ(−1.5); a stratum of 1/20,000 moves it by less than 1e-3.
    let mean = 20.5_f64.exp() * standard_normal_cdf(0.5) + hardness * beyond;
    assert!((found.mean_pa / mean - 1.0).abs() < 1e-3, "{} {mean}", found.mean_pa);
    let interval = found.mean_interval_pa().unwrap();
    assert!(interval.low >= 0.0 && interval.high <= hardness, "{interval:?}");
}

#[test]
fn under_a_hardness_an_exponent_beyond_the_largest_number_is_the_hardness() {
    let (fine, fresh) = (xi_samples("fine", 100, 1), xi_samples("fresh", 3000, 1));
    let pressures: Vec<f64> = fine.iter().map(|xi| (260.0 * xi[0].clamp(-2.5, 2.5)).exp()).collect();
    let hardness = pressures.iter().copied().fold(0.0, f64::max);
    let training = TrainingSamples { largest_pa: hardness, ..independent(&pressures, fresh.len()) };
    let found = estimate(Response::Logarithm, &fine, training, Basis::hermite(1, 1).unwrap(), &fresh, 1).unwrap();
    assert!(found.distribution.quantile(1.0) == hardness && found.mean_pa <= hardness, "{}", found.mean_pa);
}

#[test]
fn as_many_coefficients_as_samples_are_refused() {
    let outcome = estimate_of(Response::Pressure, |_| 1.0, 10, Basis::hermite(2, 3).unwrap());
    let wanted = MethodError::Regression(RegressionError::TooFewSamples { samples: 10, coefficients: 10 });
    assert_eq!(outcome.unwrap_err(), wanted);
    // No sample is in contact.
    let outcome = estimate_of(Response::Pressure, |_| 0.0, 10, Basis::hermite(2, 1).unwrap());
    let wanted = MethodError::Regression(RegressionError::TooFewSamples { samples: 0, coefficients: 3 });
    assert_eq!(outcome.unwrap_err(), wanted);
}

#[test]
fn a_pressure_that_does_not_vary_has_the_mean_without_error() {
    let (estimate, _) = estimate_of(Response::Pressure, |_| 7.0, 40, Basis::hermite(1, 1).unwrap()).unwrap();
    assert!((estimate.mean_pa - 7.0).abs() < 1e-12 && estimate.mean_se_pa < 1e-12, "{}", estimate.mean_se_pa);
    assert_eq!(estimate.leave_one_out_error, None);
}

#[test]
fn an_expansion_not_determined_by_subsamples_has_no_intervals() {
    // Without a tenth of 11 samples, ten or nine remain for ten coefficients.
    let pressure = |xi: &[f64]| 20.0 + xi[0] + (3.0 * xi[1]).sin();
    let (estimate, _) = estimate_of(Response::Pressure, pressure, 11, Basis::hermite(2, 3).unwrap()).unwrap();
    assert!(estimate.band.is_none() && estimate.mean_interval_pa().is_none());
    let few = |reason: &MethodError| matches!(reason, MethodError::Regression(RegressionError::TooFewSamples { .. }));
    assert!(estimate.interval_failure.as_ref().is_some_and(few), "{:?}", estimate.interval_failure);
    // Samples in contact are counted without a model.
    assert_eq!(estimate.contact_probability_interval.unwrap().high, 1.0);
}

#[test]
fn xi_samples_of_zeros_are_a_reason_and_samples_that_repeat_are_not() {
    let fresh = xi_samples("fresh", 500, 1);
    let run = |fine: &[Vec<f64>]| {
        let pressures: Vec<f64> = fine.iter().map(|xi| 5.0 + xi[0]).collect();
        estimate(
            Response::Pressure,
            fine,
            independent(&pressures, fresh.len()),
            Basis::hermite(1, 2).unwrap(),
            &fresh,
            1,
        )
    };
    let zeros = run(&vec![vec![0.0]; 20]);
    assert!(matches!(zeros, Err(MethodError::Regression(RegressionError::RankDeficient { .. }))), "{zeros:?}");
    let few: Vec<Vec<f64>> = (0..20).map(|i| vec![[-1.2, -0.3, 0.4, 1.7][i % 4]]).collect();
    let repeated = run(&few).unwrap();
    assert!((repeated.mean_pa - 5.0).abs() < 4.0 * repeated.mean_se_pa && repeated.band.is_some());
}

#[test]
fn the_probability_of_contact_is_that_of_the_samples() {
    // p = ξ − c where it is positive: 100 strata of a Latin hypercube, 30 of them in contact.
    let fine = xi_samples("fine", 100, 1);
    let pressures: Vec<f64> = fine.iter().map(|xi| (standard_normal_cdf(xi[0]) - 0.7).max(0.0)).collect();
    assert_eq!(pressures.iter().filter(|p| **p > 0.0).count(), 30);
    let basis = Basis::hermite(1, 1).unwrap();
    let found =
        estimate(Response::Pressure, &fine, independent(&pressures, 500), basis, &xi_samples("fresh", 500, 1), 1);
    let found = found.unwrap();
    assert!((found.contact_probability - 0.3).abs() < 1e-15 && found.contact_probability_bias.is_none());
    assert!((found.contact_probability_se - (0.3_f64 * 0.7 / 100.0).sqrt()).abs() < 1e-15);
    assert_eq!(found.contact_probability_interval, Some(asperity_base::stats::wilson_interval(30, 100)));
}
