//! Censored regression of a latent pressure.
//!
//! Out of contact the pressure is zero at any distance, and in plastic contact it equals the hardness. The latent pressure is a
//! polynomial of the variables plus a normal error, and is observed between these two bounds. The distribution of the pressure is that
//! of the latent pressure, clamped to the bounds. Akaike's information criterion selects among the degrees that the samples allow.
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

/// Number of errors drawn for each fresh ξ.
const DRAWS: usize = 5;
/// Number of errors drawn for each left-out sample.
const DRAWS_HELD: usize = 20;

/// Censored regression on the variables of the rotated ξ.
#[derive(Debug)]
pub(crate) struct LatentOverlap<'a> {
    samples: &'a RotatedSamples,
    degree: usize,
}

impl<'a> LatentOverlap<'a> {
    /// Creates the regression with degrees up to `degree`.
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
        let masses = |(i, mean): (usize, &f64), draws: usize, probability: f64| -> PointMasses {
            let error = |draw| fit.sigma * standard_normal_quantile((draw as f64 + golden(i)) / draws as f64);
            (0..draws).map(|draw| ((mean + error(draw)).clamp(0.0, largest), probability / draws as f64)).collect()
        };
        let fresh = &self.samples.fresh;
        let probability = 1.0 / fresh.len() as f64;
        let left_out = means(&rows_but(self.samples, samples));
        Ok(Fitted {
            distribution: means(fresh).iter().enumerate().flat_map(|mean| masses(mean, DRAWS, probability)).collect(),
            given: left_out.iter().enumerate().map(|mean| masses(mean, DRAWS_HELD, 1.0)).collect(),
            coefficients: coefficients.len() + 1,
            leave_one_out_error: None,
        })
    }
}
