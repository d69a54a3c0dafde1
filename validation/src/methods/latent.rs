//! The pressure continued below zero.
//!
//! Out of contact the pressure is zero whatever the distance, at the hardness it is the hardness. A latent pressure is a
//! polynomial of the variables with a normal error; seen is what lies between the two. The law is that of the latent
//! pressure, cut off. Of the degrees that the samples allow the one of the least information criterion of Akaike is taken.
//!
//! # References
//! H. Akaike, *IEEE Trans. Autom. Control* **19** (1974) 716, <https://doi.org/10.1109/TAC.1974.1100705>.

use ndarray::Array1;

use super::censored::{self, Censored};
use super::functions::Functions;
use super::{LEAST_IN_CONTACT, SAMPLES_PER_TERM, golden, rows_but, rows_of};
use asperity::distribution::standard_normal_quantile;
use asperity::pressure::MethodError;
use asperity::pressure::surrogate::{Fitted, PointMasses, RotatedSamples, Surrogate};

/// Errors drawn for each fresh ξ, and for each sample that is held out.
const DRAWS: usize = 5;
const DRAWS_HELD: usize = 20;

/// Censored regression on the variables of the rotated ξ.
#[derive(Debug)]
pub(crate) struct LatentOverlap<'a> {
    samples: &'a RotatedSamples,
    degree: usize,
}

impl<'a> LatentOverlap<'a> {
    /// Of degree up to `degree`.
    pub(crate) fn new(samples: &'a RotatedSamples, degree: usize) -> Self {
        Self { samples, degree }
    }
}

impl Surrogate for LatentOverlap<'_> {
    fn fit(&self, samples: &[usize]) -> Result<Fitted, MethodError> {
        let rows = rows_of(self.samples, samples);
        let pressures_pa: Vec<f64> = samples.iter().map(|i| self.samples.pressures_pa[*i]).collect();
        let in_contact = pressures_pa.iter().filter(|p| **p > 0.0).count();
        if in_contact < LEAST_IN_CONTACT {
            return Err(MethodError::TooFewSamples { samples: in_contact, wanted: LEAST_IN_CONTACT });
        }
        let largest = self.samples.largest_pa;
        let mut best: Option<(f64, Functions, Censored)> = None;
        for degree in Functions::degrees(self.samples.variables(), self.degree, in_contact, SAMPLES_PER_TERM) {
            let functions = Functions::new(&rows, degree)?;
            let fit = censored::fit(functions.matrix(&rows).view(), &pressures_pa, [0.0, largest]);
            let criterion = 2.0 * (functions.len() as f64 - fit.log_likelihood);
            if best.as_ref().is_none_or(|(least, ..)| criterion < *least) {
                best = Some((criterion, functions, fit));
            }
        }
        let Some((_, functions, fit)) = best else {
            return Err(MethodError::TooFewSamples { samples: rows.len(), wanted: LEAST_IN_CONTACT });
        };
        let coefficients = Array1::from(fit.coefficients);
        let means = |rows: &[Vec<f64>]| functions.matrix(rows).dot(&coefficients);
        let law = |(i, mean): (usize, &f64), draws: usize, probability: f64| -> PointMasses {
            let error = |draw| fit.sigma * standard_normal_quantile((draw as f64 + golden(i)) / draws as f64);
            (0..draws).map(|draw| ((mean + error(draw)).clamp(0.0, largest), probability / draws as f64)).collect()
        };
        let fresh = &self.samples.fresh;
        let probability = 1.0 / fresh.len() as f64;
        let held = means(&rows_but(self.samples, samples));
        Ok(Fitted {
            distribution: means(fresh).iter().enumerate().flat_map(|mean| law(mean, DRAWS, probability)).collect(),
            given: held.iter().enumerate().map(|mean| law(mean, DRAWS_HELD, 1.0)).collect(),
            coefficients: coefficients.len() + 1,
            leave_one_out_error: None,
        })
    }
}
