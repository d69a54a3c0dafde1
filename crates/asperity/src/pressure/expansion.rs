//! The paper's chaos expansions of the pressure in contact, eq. (8) to (11).
//!
//! Both are fitted by least squares to the K samples in contact alone, and give the law
//! (1 − K/K_t) δ₀ + K/K_t · F_c with F_c from many evaluations on fresh germs. Fitting only p > 0 and clipping afterwards
//! is truncated regression: the law is biased, and the variance of the variables left out is lost. Standard errors and
//! bands are those of the samples, see [`surrogate`]; neither bias is part of them.

use crate::chaos::{Basis, Expansion, Fit, LeastSquares, RegressionError};
use crate::pressure::surrogate::{self, Fitted, Surrogate};
use crate::pressure::{Estimate, MethodError};
use crate::stats::wilson_interval;

/// Which function of the pressure is expanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Response {
    /// Eq. (8): p_c = [Σ a_i Γ_i(ξ)]⁺.
    Pressure,
    /// Eq. (9): log p_c = Σ b_i Γ_i(ξ).
    Logarithm,
}

/// Samples in contact and what is expanded in what.
#[derive(Debug)]
struct Conditional<'a> {
    response: Response,
    basis: Basis,
    /// Positions of the samples in contact, their germs and responses.
    contact: Vec<usize>,
    germs: Vec<&'a [f64]>,
    values: Vec<f64>,
    fresh: &'a [Vec<f64>],
}

/// The law of the pressure from an expansion in the variables of the basis, those that lead the germs; `fresh` germs evaluate F_c.
///
/// # Errors
/// The samples in contact are too few or do not tell the functions apart, or the expansion of the logarithm overflows.
pub(super) fn estimate(
    response: Response,
    germs: &[Vec<f64>],
    pressures_pa: &[f64],
    basis: Basis,
    fresh: &[Vec<f64>],
    seed: u64,
) -> Result<Estimate, MethodError> {
    let conditional = Conditional::new(response, germs, pressures_pa, basis, fresh);
    let (samples, in_contact) = (pressures_pa.len(), conditional.contact.len());
    let found = surrogate::estimate(&conditional, [samples, in_contact], fresh.len(), seed)?;
    let contact_probability = in_contact as f64 / samples as f64;
    Ok(Estimate {
        contact_probability,
        contact_probability_se: (contact_probability * (1.0 - contact_probability) / samples as f64).sqrt(),
        contact_probability_interval: wilson_interval(in_contact, samples),
        ..found
    })
}

impl<'a> Conditional<'a> {
    fn new(
        response: Response,
        germs: &'a [Vec<f64>],
        pressures_pa: &[f64],
        basis: Basis,
        fresh: &'a [Vec<f64>],
    ) -> Self {
        let contact: Vec<usize> = (0..germs.len()).filter(|i| pressures_pa[*i] > 0.0).collect();
        let value = |i: &usize| match response {
            Response::Pressure => pressures_pa[*i],
            Response::Logarithm => pressures_pa[*i].ln(),
        };
        let values = contact.iter().map(value).collect();
        let germs = contact.iter().map(|i| germs[*i].as_slice()).collect();
        Self { response, basis, contact, germs, values, fresh }
    }

    /// Least squares with weights.
    fn expansion(&self, weights: &[f64]) -> Result<(Expansion, Fit), RegressionError> {
        let (samples, coefficients) = (self.germs.len(), self.basis.len());
        if samples <= coefficients {
            return Err(RegressionError::TooFewSamples { samples, coefficients });
        }
        let roots: Vec<f64> = self.contact.iter().map(|i| weights[*i].sqrt()).collect();
        let mut design = self.basis.design_matrix(&self.germs);
        design.rows_mut().into_iter().zip(&roots).for_each(|(mut row, root)| row *= *root);
        let values: Vec<f64> = self.values.iter().zip(&roots).map(|(value, root)| value * root).collect();
        let fit = LeastSquares::new(design.view())?.fit(&values)?;
        Ok((Expansion::new(self.basis.clone(), fit.coefficients.clone()), fit))
    }
}

impl Surrogate for Conditional<'_> {
    fn fit(&self, weights: &[f64]) -> Result<Fitted, MethodError> {
        let (expansion, fit) = self.expansion(weights)?;
        let contact: f64 = self.contact.iter().map(|i| weights[*i]).sum();
        let contact_probability = contact / weights.iter().sum::<f64>();
        let probability = contact_probability / self.fresh.len() as f64;
        let pressure = |value: f64| match self.response {
            Response::Pressure => value.max(0.0),
            Response::Logarithm => value.exp(),
        };
        let atoms = expansion.evaluate_many(self.fresh).into_iter().map(|value| (pressure(value), probability));
        Ok(Fitted {
            atoms: std::iter::once((0.0, 1.0 - contact_probability)).chain(atoms).collect(),
            contact_probability,
            coefficients: self.basis.len(),
            leave_one_out_error: fit.leave_one_out.relative_error,
        })
    }
}

#[cfg(test)]
mod tests;
