//! The paper's chaos expansions of the pressure in contact, eq. (8) to (11).
//!
//! Both expansions are fitted by least squares to the K samples in contact. They give the distribution (1 − K/K_t) δ₀ +
//! K/K_t · F_c, where F_c is evaluated on many fresh samples of ξ. Fitting only p > 0 and clipping afterwards is
//! truncated regression: the distribution is biased, and the variance of the neglected variables is lost. Standard
//! errors and bands include the bias, which is estimated from samples that were not used for the fit, see
//! [`surrogate`].
//!
//! The contact model limits the pressure to the hardness. The expansions do not, and the exponential of eq. (9) exceeds
//! it by orders of magnitude for some ξ. Values above the hardness are set to the hardness, and values below zero to
//! zero.

use crate::surrogate::{self, Fitted, PointMasses, Surrogate, TrainingSamples, others};
use crate::{MethodError, PressureEstimate};
use asperity_chaos::{Basis, Expansion, LeastSquares, RegressionError};

/// Function of the pressure that is expanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Response {
    /// Eq. (8): p_c = min([Σ a_i Γ_i(ξ)]⁺, H).
    Pressure,
    /// Eq. (9): log p_c = min(Σ b_i Γ_i(ξ), log H).
    Logarithm,
}

/// Expansion of the pressure conditional on contact.
#[derive(Debug)]
struct Conditional<'a> {
    response: Response,
    basis: Basis,
    xi_samples: &'a [Vec<f64>],
    pressures_pa: &'a [f64],
    fresh: &'a [Vec<f64>],
    /// Upper bound of the pressure.
    largest_pa: f64,
}

/// Estimates the distribution of the pressure from an expansion in the variables of the basis, the leading variables ξ.
/// F_c is evaluated at `fresh`.
///
/// # Errors
/// There are too few samples in contact, they do not determine the coefficients, or the expansion of the logarithm
/// overflows without a hardness.
pub(super) fn estimate(
    response: Response,
    xi_samples: &[Vec<f64>],
    training: TrainingSamples<'_>,
    basis: Basis,
    fresh: &[Vec<f64>],
    seed: u64,
) -> Result<PressureEstimate, MethodError> {
    let TrainingSamples { pressures_pa, largest_pa, .. } = training;
    let conditional = Conditional { response, basis, xi_samples, pressures_pa, fresh, largest_pa };
    let found = surrogate::estimate(&conditional, training, seed)?;
    let in_contact = training.pressures_pa.iter().filter(|p| **p > 0.0).count();
    let (contact_probability_se, interval) = training.contact_fraction(seed);
    Ok(PressureEstimate {
        contact_probability: in_contact as f64 / training.pressures_pa.len() as f64,
        contact_probability_se,
        contact_probability_interval: Some(interval),
        contact_probability_bias: None,
        ..found
    })
}

impl Surrogate for Conditional<'_> {
    fn fit(&self, samples: &[usize]) -> Result<Fitted, MethodError> {
        let contact: Vec<usize> = samples.iter().copied().filter(|i| self.pressures_pa[*i] > 0.0).collect();
        let (count, coefficients) = (contact.len(), self.basis.len());
        if count <= coefficients {
            return Err(RegressionError::TooFewSamples { samples: count, coefficients }.into());
        }
        let value = |i: &usize| match self.response {
            Response::Pressure => self.pressures_pa[*i],
            Response::Logarithm => self.pressures_pa[*i].ln(),
        };
        let xi_samples: Vec<&[f64]> = contact.iter().map(|i| self.xi_samples[*i].as_slice()).collect();
        let values: Vec<f64> = contact.iter().map(value).collect();
        let fit = LeastSquares::new(self.basis.design_matrix(&xi_samples))?.fit(&values)?;
        let expansion = Expansion::new(self.basis.clone(), fit.coefficients.clone());
        let pressure_pa = |value: f64| match self.response {
            Response::Pressure => value.clamp(0.0, self.largest_pa),
            Response::Logarithm => value.exp().min(self.largest_pa),
        };
        let in_contact = count as f64 / samples.len() as f64;
        let distribution = |values: Vec<f64>| -> PointMasses {
            let probability = in_contact / values.len() as f64;
            let point_masses = values.into_iter().map(|value| (pressure_pa(value), probability));
            std::iter::once((0.0, 1.0 - in_contact)).chain(point_masses).collect()
        };
        let held: Vec<&[f64]> =
            others(samples, self.xi_samples.len()).into_iter().map(|i| self.xi_samples[i].as_slice()).collect();
        Ok(Fitted {
            distribution: distribution(expansion.evaluate_many(self.fresh)),
            given: expansion.evaluate_many(&held).into_iter().map(|value| distribution(vec![value])).collect(),
            coefficients,
            leave_one_out_error: fit.leave_one_out.relative_error,
        })
    }
}

#[cfg(test)]
mod tests;
