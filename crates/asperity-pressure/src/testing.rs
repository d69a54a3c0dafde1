//! Random surfaces for tests.

use ndarray::Array2;

use asperity_base::correlation::{CorrelationModel, Covariance};
use asperity_base::map::{Grid, HeightMap};
use asperity_contact::{Boundary, HalfSpace};
use asperity_surface::{KarhunenLoeve, ModesRoute, RandomSurface};

/// Fixed shape at a normally distributed height: one variable ξ.
pub(super) struct Shape {
    pub(super) heights_m: Array2<f64>,
    grid: Grid,
    std_m: f64,
}

impl Shape {
    pub(super) fn new(grid: Grid, std_m: f64, height_m: impl Fn(f64, f64) -> f64) -> Self {
        let heights_m = HeightMap::from_function(grid, height_m).unwrap().heights_m().clone();
        Self { heights_m, grid, std_m }
    }
}

impl RandomSurface for Shape {
    fn xi_len(&self) -> usize {
        1
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        HeightMap::new(self.grid, &self.heights_m + self.std_m * xi[0]).unwrap()
    }
}

/// Returns a Gaussian surface of unit height and edge, ℓ = L/5, on a free half-space of unit modulus.
pub(super) fn gaussian_surface(points: usize, modes: usize) -> (KarhunenLoeve, HalfSpace) {
    let grid = Grid::with_size(points, points, 1.0, 1.0).unwrap();
    let covariance = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 0.2, 0.2).unwrap();
    let surface = KarhunenLoeve::new(&covariance, grid, modes, ModesRoute::Separable).unwrap();
    (surface, HalfSpace::new(grid, 1.0, Boundary::Free).unwrap())
}
