//! Composite roughness of two independent random surfaces that face each other.

use ndarray::{Array2, s};

use crate::RandomSurface;
use crate::gaussian::map_of;
use asperity_base::map::{Grid, HeightMap};

/// Sum of the heights of a random surface and of the random counterface above it.
///
/// Heights point out of the material of each body. The map of the counterface is mirrored along x to face the surface. The
/// variables ξ of the two bodies alternate, so that the most important ones of each come first.
pub(crate) struct CompositeSurface {
    surface: Box<dyn RandomSurface>,
    counterface: Box<dyn RandomSurface>,
}

impl CompositeSurface {
    /// Creates the sum of two surfaces on the same grid.
    ///
    /// # Panics
    /// If the grids differ.
    pub(crate) fn new(surface: Box<dyn RandomSurface>, counterface: Box<dyn RandomSurface>) -> Self {
        assert_eq!(surface.grid(), counterface.grid(), "both bodies need the same grid");
        Self { surface, counterface }
    }

    /// Returns the variables ξ of each body.
    fn split(&self, xi: &[f64]) -> [Vec<f64>; 2] {
        let (own, other) = (self.surface.xi_len(), self.counterface.xi_len());
        assert_eq!(xi.len(), own + other, "ξ has the wrong length");
        let (pairs, rest) = xi.split_at(2 * own.min(other));
        let (mut first, mut second): (Vec<f64>, Vec<f64>) =
            pairs.chunks_exact(2).map(|pair| (pair[0], pair[1])).unzip();
        if own > other { &mut first } else { &mut second }.extend_from_slice(rest);
        [first, second]
    }
}

/// Returns a map as the other body sees it.
fn mirrored(values: &Array2<f64>) -> Array2<f64> {
    values.slice(s![.., ..;-1]).to_owned()
}

impl RandomSurface for CompositeSurface {
    fn xi_len(&self) -> usize {
        self.surface.xi_len() + self.counterface.xi_len()
    }

    fn grid(&self) -> Grid {
        self.surface.grid()
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        let [own, other] = self.split(xi);
        let facing = mirrored(self.counterface.generate(&other).heights_m());
        map_of(self.grid(), (self.surface.generate(&own).heights_m() + &facing).into_iter().collect())
    }

    fn bodies(&self, xi: &[f64]) -> Option<[HeightMap; 2]> {
        let [own, other] = self.split(xi);
        Some([self.surface.generate(&own), self.counterface.generate(&other)])
    }

    fn xi_response(&self, weights: &Array2<f64>) -> Option<Vec<f64>> {
        let own = self.surface.as_ref().xi_response(weights)?;
        let other = self.counterface.as_ref().xi_response(&mirrored(weights))?;
        let (pairs, longer) = (own.len().min(other.len()), if own.len() > other.len() { &own } else { &other });
        let alternating = own.iter().zip(&other).flat_map(|(own, other)| [*own, *other]);
        Some(alternating.chain(longer[pairs..].iter().copied()).collect())
    }

    fn is_periodic_and_stationary(&self) -> bool {
        // A box of a surface does not pass the question on.
        self.surface.as_ref().is_periodic_and_stationary() && self.counterface.as_ref().is_periodic_and_stationary()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{KarhunenLoeve, ModesRoute, SpectralField};
    use asperity_base::correlation::{CorrelationModel, Covariance, Rotated};
    use asperity_base::random::{standard_normal, stream};

    /// A periodic surface of all Fourier modes, and one of a few modes whose lay is at an angle.
    fn bodies(modes: usize) -> [Box<dyn RandomSurface>; 2] {
        let grid = Grid::new(8, 6, 1.0, 0.7).unwrap();
        let covariance = Covariance::new(CorrelationModel::SquaredExponential, 2.0, 3.0, 1.0).unwrap();
        let turned = Rotated::new(covariance, 0.4).unwrap();
        let few = KarhunenLoeve::new(&turned, grid, modes, ModesRoute::Periodic).unwrap();
        // Every wave of this covariance is larger than the rounding of the heights.
        let rough = Covariance::new(CorrelationModel::Exponential, 2.0, 3.0, 1.0).unwrap();
        [Box::new(SpectralField::periodic(&rough, grid)), Box::new(few)]
    }

    #[test]
    fn the_sum_has_the_heights_of_both_bodies_with_the_counterface_mirrored() {
        for order in [[0, 1], [1, 0]] {
            let [own, other] = order.map(|place| bodies(5).into_iter().nth(place).unwrap());
            let (own_len, other_len) = (own.xi_len(), other.xi_len());
            let sum = CompositeSurface::new(own, other);
            let xi = standard_normal(&mut stream(1, "composite", 0), sum.xi_len());
            let [lower, upper] = sum.bodies(&xi).unwrap();
            let found = sum.generate(&xi);
            for ((row, column), z) in found.heights_m().indexed_iter() {
                assert_eq!(*z, lower.heights_m()[[row, column]] + upper.heights_m()[[row, 7 - column]]);
            }
            // Every variable moves one body alone, and the first two are the first of each.
            let moved = |place: usize| {
                let mut xi = xi.clone();
                xi[place] += 1.0;
                let [a, b] = sum.bodies(&xi).unwrap();
                [a != lower, b != upper]
            };
            assert_eq!([moved(0), moved(1)], [[true, false], [false, true]]);
            let of_lower = (0..sum.xi_len()).filter(|place| moved(*place) == [true, false]).count();
            assert_eq!([of_lower, sum.xi_len() - of_lower], [own_len, other_len]);
        }
    }

    #[test]
    fn the_response_of_the_sum_equals_finite_differences() {
        let [own, other] = bodies(5);
        let sum = CompositeSurface::new(own, other);
        let weights = standard_normal(&mut stream(1, "composite", 1), 48);
        let weights = Array2::from_shape_vec((6, 8), weights).unwrap();
        let stated = sum.xi_response(&weights).unwrap();
        for (place, stated) in stated.iter().enumerate() {
            let mut xi = vec![0.0; sum.xi_len()];
            xi[place] = 1.0;
            let found = (sum.generate(&xi).heights_m() * &weights).sum();
            assert!((found - stated).abs() < 1e-10, "{place}: {found} {stated}");
        }
        assert!(sum.is_periodic_and_stationary());
    }
}
