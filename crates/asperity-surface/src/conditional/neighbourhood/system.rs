//! Kriging weights of one neighbourhood.

use asperity_base::numeric::{Cholesky, dot};
use ndarray::{Array2, s};

use super::NeighbourhoodSurface;
use super::groups::Group;

impl NeighbourhoodSurface {
    /// Computes the corrections at the missing points of a group for each of `misses`, times the weights of the group:
    /// as many values for each point as there are misses.
    pub(super) fn corrections(&self, group: &Group, misses: &[Vec<f64>]) -> Vec<f64> {
        let (count, heights) = (misses.len(), group.heights.len());
        let mut corrections = vec![0.0; group.targets.len() * count];
        if heights == 0 {
            return corrections;
        }
        let at: Vec<(isize, isize)> =
            group.heights.iter().map(|height| self.column_and_row(self.places[*height as usize])).collect();
        let factor = self.factor(&at);
        // Solved one by one, because the rounding of a joint solve depends on the number of right-hand sides.
        let solve = |misses: &Vec<f64>| -> Vec<f64> {
            factor.solve(&group.heights.iter().map(|height| misses[*height as usize]).collect::<Vec<f64>>())
        };
        let weights: Vec<Vec<f64>> = misses.iter().map(solve).collect();
        let mut correlations = vec![0.0; heights];
        let points = group.targets.iter().zip(&group.weights);
        for ((place, fraction), out) in points.zip(corrections.chunks_exact_mut(count)) {
            let (column, row) = self.column_and_row(*place as usize);
            for (value, (x, y)) in correlations.iter_mut().zip(&at) {
                *value = self.lags.at(column - x, row - y);
            }
            for (weights, out) in weights.iter().zip(out) {
                *out = fraction * dot(weights, &correlations);
            }
        }
        corrections
    }

    /// Factorises the correlation of noisy heights. If rounding leaves it indefinite, the noise is multiplied by ten.
    fn factor(&self, at: &[(isize, isize)]) -> Cholesky {
        let mut between = Array2::zeros((at.len(), at.len()));
        for (i, (p, q)) in at.iter().enumerate() {
            for (value, (x, y)) in between.slice_mut(s![i, ..=i]).iter_mut().zip(at) {
                *value = self.lags.at(p - x, q - y);
            }
        }
        let mut noise = self.noise;
        loop {
            for i in 0..at.len() {
                between[[i, i]] = self.lags.at(0, 0) + noise;
            }
            // When the noise exceeds the number of heights, the diagonal dominates.
            match Cholesky::new(between.clone()) {
                Some(factor) => return factor,
                None if noise <= at.len() as f64 => noise *= 10.0,
                None => unreachable!("correlations are at most 1"),
            }
        }
    }

    fn column_and_row(&self, place: usize) -> (isize, isize) {
        ((place % self.grid.nx()) as isize, (place / self.grid.nx()) as isize)
    }
}
