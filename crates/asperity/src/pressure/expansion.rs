//! The paper's chaos expansions of the pressure in contact, eq. (8) to (11).
//!
//! Both are fitted by least squares to the K samples in contact alone, and give the law
//! (1 − K/K_t) δ₀ + K/K_t · F_c with F_c from many evaluations on fresh germs. Fitting only p > 0 and clipping afterwards
//! is truncated regression: the law is biased, and the variance of the variables left out is lost.

use crate::chaos::{Basis, Expansion, StepLaw};
use crate::pressure::{Estimate, MethodError, Samples};
use crate::stats::wilson_interval;

/// Which function of the pressure is expanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Response {
    /// Eq. (8): p_c = [Σ a_i Γ_i(ξ)]⁺.
    Pressure,
    /// Eq. (9): log p_c = Σ b_i Γ_i(ξ).
    Logarithm,
}

/// The law of the pressure from an expansion in the leading variables of the basis; `fresh` germs evaluate F_c.
pub(super) fn estimate(
    response: Response,
    samples: &Samples,
    basis: Basis,
    fresh: &[Vec<f64>],
    _seed: u64,
) -> Result<Estimate, MethodError> {
    let (germs, values): (Vec<Vec<f64>>, Vec<f64>) = samples
        .leading_germs(basis.set().variables())
        .into_iter()
        .zip(samples.observations())
        .filter(|(_, observation)| observation.pressure_pa > 0.0)
        .map(|(germ, observation)| match response {
            Response::Pressure => (germ, observation.pressure_pa),
            Response::Logarithm => (germ, observation.pressure_pa.ln()),
        })
        .unzip();
    let (expansion, leave_one_out_error, law) = conditional_law(response, basis, &germs, &values, fresh)?;
    let contact_probability = samples.contact_probability();
    let atoms = law.atoms().map(|(value, probability)| (value, contact_probability * probability));
    let law = StepLaw::weighted(std::iter::once((0.0, 1.0 - contact_probability)).chain(atoms))?;
    let contact_probability_se = (contact_probability * (1.0 - contact_probability) / samples.len() as f64).sqrt();
    Ok(Estimate {
        contact_probability,
        contact_probability_se,
        contact_probability_interval: wilson_interval(samples.in_contact(), samples.len()),
        mean_pa: law.mean(),
        mean_se_pa: f64::NAN,
        band: None,
        coefficients: Some(expansion.coefficients().len()),
        leave_one_out_error,
        law,
    })
}

/// The expansion, its relative leave-one-out error, and the law F_c of the pressure in contact.
fn conditional_law(
    response: Response,
    basis: Basis,
    germs: &[Vec<f64>],
    values: &[f64],
    fresh: &[Vec<f64>],
) -> Result<(Expansion, Option<f64>, StepLaw), MethodError> {
    let (expansion, fit) = Expansion::fit(basis, germs, values)?;
    let pressures: Vec<f64> = expansion
        .evaluate_many(fresh)
        .into_iter()
        .map(|value| match response {
            Response::Pressure => value.max(0.0),
            Response::Logarithm => value.exp(),
        })
        .collect();
    let overflowed = pressures.iter().filter(|p| !p.is_finite()).count();
    if overflowed > 0 {
        return Err(MethodError::Overflow { overflowed, evaluations: fresh.len() });
    }
    let law = StepLaw::empirical(&pressures)?;
    Ok((expansion, fit.leave_one_out.relative_error, law))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chaos::{Design, RegressionError, SamplingMethod, distance};

    fn germs(stage: &str, samples: usize, dimensions: usize) -> Vec<Vec<f64>> {
        let design = Design::new(SamplingMethod::LatinHypercube, 9, stage, samples, dimensions).unwrap();
        (0..samples).map(|i| design.germ(i)).collect()
    }

    #[test]
    fn a_polynomial_pressure_is_recovered_exactly() {
        // Always positive: nothing is truncated and eq. (8) is exact.
        let pressure = |xi: &[f64]| 3.0 + (xi[0] - 0.5 * xi[1]).powi(2) + 0.1 * (xi[2] * xi[0]).powi(2);
        let (fine, fresh) = (germs("fine", 120, 3), germs("fresh", 3000, 3));
        let values: Vec<f64> = fine.iter().map(|xi| pressure(xi)).collect();
        let basis = Basis::hermite(3, 4).unwrap();
        let (_, error, law) = conditional_law(Response::Pressure, basis, &fine, &values, &fresh).unwrap();
        let truth: Vec<f64> = fresh.iter().map(|xi| pressure(xi)).collect();
        assert!(error.unwrap() < 1e-20);
        assert!(distance::wasserstein_1(&law, &StepLaw::empirical(&truth).unwrap()) < 1e-10);
    }

    #[test]
    fn a_lognormal_pressure_is_recovered_exactly_by_its_logarithm() {
        let log_pressure = |xi: &[f64]| 15.0 + 0.8 * xi[0] - 0.3 * xi[1] + 0.1 * xi[0] * xi[1];
        let (fine, fresh) = (germs("fine", 40, 2), germs("fresh", 3000, 2));
        let values: Vec<f64> = fine.iter().map(|xi| log_pressure(xi)).collect();
        let basis = Basis::hermite(2, 2).unwrap();
        let (_, _, law) = conditional_law(Response::Logarithm, basis, &fine, &values, &fresh).unwrap();
        let truth = StepLaw::empirical(&fresh.iter().map(|xi| log_pressure(xi).exp()).collect::<Vec<_>>()).unwrap();
        assert!(distance::wasserstein_1(&law, &truth) < 1e-10 * truth.std());
    }

    #[test]
    fn an_exponent_beyond_the_largest_number_is_a_reason_not_a_pressure() {
        let fine = germs("fine", 40, 1);
        let values: Vec<f64> = fine.iter().map(|xi| 400.0 * xi[0]).collect();
        let basis = Basis::hermite(1, 1).unwrap();
        let outcome = conditional_law(Response::Logarithm, basis, &fine, &values, &germs("fresh", 1000, 1));
        assert!(matches!(outcome, Err(MethodError::Overflow { overflowed: 1.., evaluations: 1000 })));
    }

    #[test]
    fn as_many_coefficients_as_samples_are_refused() {
        let fine = germs("fine", 10, 2);
        let values = vec![1.0; 10];
        let basis = Basis::hermite(2, 3).unwrap();
        let outcome = conditional_law(Response::Pressure, basis, &fine, &values, &fine);
        let wanted = MethodError::Regression(RegressionError::TooFewSamples { samples: 10, coefficients: 10 });
        assert_eq!(outcome.unwrap_err(), wanted);
    }
}
