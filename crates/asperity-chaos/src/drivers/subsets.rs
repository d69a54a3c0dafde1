//! Fractions of the variance that subsets of the inputs leave when all others are known.
//!
//! For a subset u, c(u) = E Var\[f | inputs outside u\]/Var f. The total index of input i is c({i}), and its first-order
//! index is 1 − c(all but i). Its Shapley effect is the weighted sum of c(u ∪ {i}) − c(u) over the subsets u without i.

use super::Centred;
use super::error::DriverError;
use super::replicates::Point;
use crate::{Redraw, UncertainInputs};

/// Sums per subset: half the squared difference, the mean and the mean square of the two responses, and their number.
const SUMS: usize = 4;

/// Subsets of the inputs that are drawn anew.
pub(super) struct Subsets {
    inputs: usize,
    /// Sets of bits in ascending order, without the empty and the full set.
    sets: Vec<u64>,
    redraws: Vec<Redraw>,
}

impl Subsets {
    /// Creates all subsets.
    pub(super) fn all(inputs: &UncertainInputs) -> Self {
        Self::new(inputs, (1..full(inputs.inputs().len())).collect())
    }

    /// Creates the subsets of one input, and of all inputs but one.
    pub(super) fn single(inputs: &UncertainInputs) -> Self {
        let n = inputs.inputs().len();
        let mut sets: Vec<u64> = (0..n).flat_map(|i| [1 << i, full(n) ^ (1 << i)]).collect();
        sets.retain(|set| *set != 0 && *set != full(n));
        sets.sort_unstable();
        sets.dedup();
        Self::new(inputs, sets)
    }

    fn new(inputs: &UncertainInputs, sets: Vec<u64>) -> Self {
        let n = inputs.inputs().len();
        let order = |set: u64| {
            let (redrawn, mut order): (Vec<usize>, Vec<usize>) = (0..n).partition(|i| set >> i & 1 == 1);
            order.extend(redrawn);
            order
        };
        let redraws = sets.iter().map(|set| inputs.redraw(&order(*set))).collect();
        Self { inputs: n, sets, redraws }
    }

    /// Returns the number of sums.
    pub(super) fn width(&self) -> usize {
        // One more for the variance of the points themselves.
        SUMS * (self.sets.len() + 1)
    }

    /// Adds the terms of a point to the sums.
    ///
    /// # Errors
    /// The error of the response.
    pub(super) fn add(&self, point: &Point<'_>, response: &Centred<'_>, sums: &mut [f64]) -> Result<(), DriverError> {
        let redrawn = self.sets.iter().zip(&self.redraws);
        let redrawn = redrawn.map(|(set, redraw)| redraw.last(set.count_ones() as usize, point.z, point.fresh));
        let points: Vec<Vec<f64>> = std::iter::once(point.z.to_vec()).chain(redrawn).collect();
        let values = response.at(&points)?;
        let here = values[0];
        let mut add = |column: usize, there: f64| {
            let terms = [0.5 * (here - there).powi(2), 0.5 * (here + there), 0.5 * (here * here + there * there), 1.0];
            sums[SUMS * column..][..SUMS].iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        };
        values[1..].iter().enumerate().for_each(|(column, there)| add(column, *there));
        add(self.sets.len(), here);
        Ok(())
    }

    /// Returns c(u). NaN if the response is constant.
    fn fraction(&self, sums: &[f64], set: u64) -> f64 {
        let column = self.sets.binary_search(&set).unwrap_or(self.sets.len());
        let [half_square, mean, square, count] = std::array::from_fn(|k| sums[SUMS * column + k]);
        let variance = square / count - (mean / count).powi(2);
        if variance <= 0.0 {
            f64::NAN
        } else if set == full(self.inputs) {
            1.0
        } else {
            half_square / count / variance
        }
    }

    /// Returns the first-order indices.
    pub(super) fn first_order(&self, sums: &[f64]) -> Vec<f64> {
        (0..self.inputs).map(|i| 1.0 - self.fraction(sums, full(self.inputs) ^ (1 << i))).collect()
    }

    /// Returns the total indices.
    pub(super) fn total(&self, sums: &[f64]) -> Vec<f64> {
        (0..self.inputs).map(|i| self.fraction(sums, 1 << i)).collect()
    }

    /// Returns the Shapley effects, for all subsets.
    pub(super) fn shapley_effects(&self, sums: &[f64]) -> Vec<f64> {
        let n = self.inputs;
        let fractions: Vec<f64> = (0..=full(n)).map(|set| self.fraction(sums, set)).collect();
        // 1/(n C(n − 1, k)) for subsets of k inputs.
        let mut weights = vec![1.0 / n as f64];
        (1..n).for_each(|k| weights.push(weights[k - 1] * k as f64 / (n - k) as f64));
        let effect = |i: usize| {
            let without = (0..=full(n)).filter(|set| set >> i & 1 == 0);
            let gain = |set: u64| fractions[(set | 1 << i) as usize] - fractions[set as usize];
            without.map(|set| weights[set.count_ones() as usize] * gain(set)).sum()
        };
        (0..n).map(effect).collect()
    }
}

/// Returns the set of all inputs.
fn full(inputs: usize) -> u64 {
    u64::MAX >> (64 - inputs)
}
