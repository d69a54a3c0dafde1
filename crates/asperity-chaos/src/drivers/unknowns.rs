//! Probabilities over unknown inputs: how probable an event is, depending on values that are not known.

use super::{DriverError, Response, finite};
use crate::{Design, SamplingMethod, UncertainInputs};
use asperity_base::blocks;

/// Points at which the other inputs are drawn while one unknown input is fixed.
const EFFECT_POINTS: usize = 1 << 14;
/// Points of a block.
const BLOCK: usize = 256;

/// Nested sampling: unknown inputs outside, varying inputs inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NestedSampling {
    /// Placement of the points.
    pub method: SamplingMethod,
    /// Number of points of the unknown inputs.
    pub outer: usize,
    /// Number of points of the varying inputs, the same for all outer points.
    pub inner: usize,
    /// Seed of the stages "chaos/unknowns/outer", "chaos/unknowns/inner" and "chaos/unknowns/effects".
    pub seed: u64,
}

/// Distribution of a probability over the unknown inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbabilityOverUnknowns {
    /// Quantile of probability 0.05.
    pub q05: f64,
    /// Median.
    pub q50: f64,
    /// Quantile of probability 0.95.
    pub q95: f64,
    /// Effect of each unknown input, in the order of the inputs.
    pub effects: Vec<UnknownEffect>,
}

/// Probability of the event if one unknown input had a low or a high value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnknownEffect {
    /// Index of the unknown input.
    pub input: usize,
    /// Probability if the input has its 5 % quantile.
    pub probability_at_q05: f64,
    /// Probability if the input has its 95 % quantile.
    pub probability_at_q95: f64,
}

impl NestedSampling {
    /// Creates the settings for 1,024 × 1,024 Sobol' points.
    pub fn new(seed: u64) -> Self {
        Self { method: SamplingMethod::Sobol, outer: 1024, inner: 1024, seed }
    }

    /// Estimates the distribution of P\[f < 0 | unknown inputs\] over the unknown inputs; the probability refers to the
    /// varying inputs. If no input varies it is 0 or 1. Returns `None` if no input is unknown.
    ///
    /// The response f takes independent standard normal variables, as in [`PickFreeze::drivers`](super::PickFreeze).
    /// Quantiles are order statistics without interpolation. The effect of one unknown input is
    /// P\[f < 0 | its value\]; all other inputs have their distribution given this value.
    ///
    /// # Errors
    /// The response is not finite, or a number of points is zero.
    ///
    /// # Panics
    /// If the response returns another number of values than points.
    pub fn probability_over_unknowns(
        &self,
        inputs: &UncertainInputs,
        response: &Response<'_>,
    ) -> Result<Option<ProbabilityOverUnknowns>, DriverError> {
        let n = inputs.inputs().len();
        let (unknown, varying): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| inputs.inputs()[i].is_unknown());
        if unknown.is_empty() {
            return Ok(None);
        }
        let outer = self.design("outer", self.outer, unknown.len())?;
        let mut inner = vec![vec![0.0; n]];
        if !varying.is_empty() {
            let design = self.design("inner", self.inner, varying.len())?;
            inner.resize(self.inner, vec![0.0; n]);
            let set = |(k, z): (usize, &mut Vec<f64>)| varying.iter().zip(design.xi(k)).for_each(|(&i, xi)| z[i] = xi);
            inner.iter_mut().enumerate().for_each(set);
        }
        let probability = |k: usize| {
            let (mut points, outer) = (inner.clone(), outer.xi(k));
            points.iter_mut().for_each(|z| unknown.iter().zip(&outer).for_each(|(&i, xi)| z[i] = *xi));
            Ok(count_negative(&finite(response, &points)?) as f64 / points.len() as f64)
        };
        let mut probabilities = blocks::map::<_, Result<Vec<f64>, DriverError>>(0..self.outer, probability)?;
        probabilities.sort_by(f64::total_cmp);
        let rank = |probability: f64| (probability * self.outer as f64).ceil() as usize;
        let [q05, q50, q95] = [0.05, 0.5, 0.95].map(|probability| probabilities[rank(probability).max(1) - 1]);
        let effects = unknown.iter().map(|&input| self.effect(inputs, input, response)).collect::<Result<_, _>>()?;
        Ok(Some(ProbabilityOverUnknowns { q05, q50, q95, effects }))
    }

    /// Returns the effect of one unknown input.
    fn effect(
        &self,
        inputs: &UncertainInputs,
        input: usize,
        response: &Response<'_>,
    ) -> Result<UnknownEffect, DriverError> {
        let n = inputs.inputs().len();
        let design = self.design("effects", EFFECT_POINTS, n)?;
        let order: Vec<usize> = std::iter::once(input).chain((0..n).filter(|&i| i != input)).collect();
        let redraw = inputs.redraw(&order);
        let probability_at = |quantile: f64| {
            let fixed = inputs.point_with(input, quantile);
            let block = |number: usize| {
                let points = (number * BLOCK..(number + 1) * BLOCK).map(|k| redraw.last(n - 1, &fixed, &design.xi(k)));
                Ok(count_negative(&finite(response, &points.collect::<Vec<_>>())?))
            };
            let counts = blocks::map::<_, Result<Vec<usize>, DriverError>>(0..EFFECT_POINTS / BLOCK, block)?;
            Ok::<f64, DriverError>(counts.iter().sum::<usize>() as f64 / EFFECT_POINTS as f64)
        };
        Ok(UnknownEffect {
            input,
            probability_at_q05: probability_at(0.05)?,
            probability_at_q95: probability_at(0.95)?,
        })
    }

    fn design(&self, stage: &str, points: usize, dimensions: usize) -> Result<Design, DriverError> {
        Ok(Design::new(self.method, self.seed, &format!("chaos/unknowns/{stage}"), points, dimensions)?)
    }
}

fn count_negative(values: &[f64]) -> usize {
    values.iter().filter(|value| **value < 0.0).count()
}
