//! The pressure continued below zero.
//!
//! Out of contact the pressure is zero whatever the distance, at the hardness it is the hardness. A latent pressure is a
//! polynomial of the variables with a normal error; seen is what lies between the two. The law is that of the latent
//! pressure, cut off. Of the degrees that the samples allow the one of the least information criterion of Akaike is taken.
//!
//! # References
//! H. Akaike, *IEEE Trans. Autom. Control* **19** (1974) 716, <https://doi.org/10.1109/TAC.1974.1100705>.

use ndarray::{Array1, Array2};

use super::censored;
use super::functions::Functions;
use super::{Fitted, LEAST_IN_CONTACT, Rotated, SAMPLES_PER_TERM, Surrogate, golden};
use crate::law::standard_normal_quantile;
use crate::pressure::MethodError;

/// Errors drawn for each fresh germ.
const DRAWS: usize = 5;

/// Censored regression on the variables of the rotated germ.
#[derive(Debug)]
pub(crate) struct LatentOverlap<'a> {
    samples: &'a Rotated,
    design: Array2<f64>,
    fresh: Array2<f64>,
}

impl<'a> LatentOverlap<'a> {
    /// Of degree up to `degree`.
    ///
    /// # Errors
    /// Too few samples are in contact.
    pub(crate) fn new(samples: &'a Rotated, degree: usize) -> Result<Self, MethodError> {
        let [count, in_contact] = samples.counts();
        if in_contact < LEAST_IN_CONTACT {
            return Err(MethodError::TooFewInContact { in_contact, samples: count, wanted: LEAST_IN_CONTACT });
        }
        let ones = vec![1.0; count];
        let mut best: Option<(f64, Functions, Array2<f64>)> = None;
        for degree in Functions::degrees(samples.variables(), degree, in_contact, SAMPLES_PER_TERM) {
            let functions = Functions::new(&samples.rows, degree)?;
            let design = functions.matrix(&samples.rows);
            let fit = censored::fit(design.view(), &samples.pressures_pa, [0.0, samples.largest_pa], &ones);
            let criterion = 2.0 * (functions.len() as f64 - fit.log_likelihood);
            if best.as_ref().is_none_or(|(least, ..)| criterion < *least) {
                best = Some((criterion, functions, design));
            }
        }
        match best {
            Some((_, functions, design)) => Ok(Self { samples, design, fresh: functions.matrix(&samples.fresh) }),
            None => Err(MethodError::TooFewSamples { samples: count, wanted: LEAST_IN_CONTACT }),
        }
    }
}

impl Surrogate for LatentOverlap<'_> {
    fn fit(&self, weights: &[f64]) -> Result<Fitted, MethodError> {
        let largest = self.samples.largest_pa;
        let fit = censored::fit(self.design.view(), &self.samples.pressures_pa, [0.0, largest], weights);
        let latent = self.fresh.dot(&Array1::from(fit.coefficients.clone()));
        let probability = 1.0 / (latent.len() * DRAWS) as f64;
        let mut atoms = Vec::with_capacity(latent.len() * DRAWS);
        for (i, mean) in latent.iter().enumerate() {
            for draw in 0..DRAWS {
                let error = fit.sigma * standard_normal_quantile((draw as f64 + golden(i)) / DRAWS as f64);
                atoms.push(((mean + error).clamp(0.0, largest), probability));
            }
        }
        let in_contact = atoms.iter().filter(|(p, _)| *p > 0.0).count();
        Ok(Fitted {
            contact_probability: in_contact as f64 / atoms.len() as f64,
            atoms,
            coefficients: fit.coefficients.len() + 1,
            leave_one_out_error: None,
        })
    }
}
