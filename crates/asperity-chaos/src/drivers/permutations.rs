//! Shapley effects from random permutations of the inputs.
//!
//! The Shapley effect of an input is the mean, over all orders of the inputs, of the variance that it adds to the
//! variance of the inputs before it. Each point has one order. Every n consecutive points have the rotations of one
//! random permutation, so that each input has each place equally often.

use rand::RngExt;

use super::Centred;
use super::error::DriverError;
use super::replicates::Point;
use crate::UncertainInputs;
use asperity_base::random::stream;

/// Random orders of the inputs.
pub(super) struct Permutations<'a> {
    inputs: &'a UncertainInputs,
    seed: u64,
}

impl<'a> Permutations<'a> {
    pub(super) fn new(inputs: &'a UncertainInputs, seed: u64) -> Self {
        Self { inputs, seed }
    }

    /// Returns the number of sums: per input the added variance and how often it comes last, then the number, the sum
    /// and the sum of squares of the responses, and the number of points.
    pub(super) fn width(&self) -> usize {
        2 * self.n() + 4
    }

    fn n(&self) -> usize {
        self.inputs.inputs().len()
    }

    /// Returns the order of a point; inputs are added from its end.
    fn order(&self, index: usize) -> Vec<usize> {
        let n = self.n();
        let mut order: Vec<usize> = (0..n).collect();
        let mut stream = stream(self.seed, "chaos/drivers/permutations", (index / n) as u64);
        (1..n).rev().for_each(|last| order.swap(last, stream.random_range(0..=last)));
        order.rotate_left(index % n);
        order
    }

    /// Adds the terms of a point to the sums.
    ///
    /// # Errors
    /// The error of the response.
    pub(super) fn add(&self, point: &Point<'_>, response: &Centred<'_>, sums: &mut [f64]) -> Result<(), DriverError> {
        let n = self.n();
        let order = self.order(point.index);
        let redraw = self.inputs.redraw(&order);
        let (effects, rest) = sums.split_at_mut(n);
        let (last, totals) = rest.split_at_mut(n);
        let redrawn = (1..n).map(|count| redraw.last(count, point.z, point.fresh));
        let points: Vec<Vec<f64>> = std::iter::once(point.z.to_vec()).chain(redrawn).collect();
        let values = response.at(&points)?;
        let here = values[0];
        let mut add = |value: f64| {
            totals.iter_mut().zip([1.0, value, value * value]).for_each(|(sum, term)| *sum += term);
        };
        add(here);
        let mut before = 0.0;
        for (count, there) in (1..n).zip(&values[1..]) {
            add(*there);
            let added = 0.5 * (here - there).powi(2);
            effects[order[n - count]] += added - before;
            before = added;
        }
        // The last input adds the rest of the variance, which is known only from all points.
        effects[order[0]] -= before;
        last[order[0]] += 1.0;
        totals[3] += 1.0;
        Ok(())
    }

    /// Returns the Shapley effects. NaN if the response is constant.
    pub(super) fn shapley_effects(&self, sums: &[f64]) -> Vec<f64> {
        let n = self.n();
        let [count, sum, square, points] = std::array::from_fn(|k| sums[2 * n + k]);
        let variance = square / count - (sum / count).powi(2);
        let effect = |i: usize| (sums[i] / variance + sums[n + i]) / points;
        (0..n).map(|i| if variance > 0.0 { effect(i) } else { f64::NAN }).collect()
    }
}
