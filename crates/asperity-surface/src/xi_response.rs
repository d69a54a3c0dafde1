//! Responses of generators to ξ against finite differences.

use ndarray::Array2;

use super::{KarhunenLoeve, ModesRoute, RandomSurface, SpectralField, Translated};
use asperity_base::correlation::{CorrelationModel, Covariance, Rotated, StationaryCovariance};
use asperity_base::distribution::Marginal;
use asperity_base::map::Grid;
use asperity_base::random::{standard_normal, stream};

/// Returns the largest deviation of the response from central differences, over the largest response.
fn deviation(surface: &dyn RandomSurface, step: f64) -> f64 {
    let shape = surface.grid().shape();
    let values = standard_normal(&mut stream(1, "germ_response", 0), shape.0 * shape.1);
    let weights = Array2::from_shape_fn(shape, |(row, column)| values[row * shape.1 + column]);
    let stated = surface.xi_response(&weights).unwrap();
    assert_eq!(stated.len(), surface.xi_len());
    let mut xi = vec![0.0; surface.xi_len()];
    let mut sum = |j: usize, value: f64| {
        xi[j] = value;
        let sum = (surface.generate(&xi).heights_m() * &weights).sum();
        xi[j] = 0.0;
        sum
    };
    let differences: Vec<f64> = (0..stated.len()).map(|j| (sum(j, step) - sum(j, -step)) / (2.0 * step)).collect();
    let largest = differences.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    stated.iter().zip(&differences).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f64::max)
}

#[test]
fn the_response_of_linear_generators_equals_finite_differences() {
    let covariance = Covariance::new(CorrelationModel::SquaredExponential, 2.0, 3.0, 2.0).unwrap();
    let turned = Rotated::new(covariance, 0.4).unwrap();
    for (nx, ny) in [(8, 6), (7, 9)] {
        let grid = Grid::new(nx, ny, 1.0, 0.7).unwrap();
        let both: [&dyn StationaryCovariance; 2] = [&covariance, &turned];
        for covariance in both {
            assert!(deviation(&SpectralField::periodic(covariance, grid), 1.0) < 1e-10);
            assert!(deviation(&SpectralField::free(covariance, grid).unwrap(), 1.0) < 1e-10);
            for route in [ModesRoute::Periodic, ModesRoute::General] {
                let surface = KarhunenLoeve::new(covariance, grid, 9, route).unwrap();
                assert!(deviation(&surface, 1.0) < 1e-10, "{route:?}");
            }
        }
        let separable = KarhunenLoeve::new(&covariance, grid, 9, ModesRoute::Separable).unwrap();
        assert!(deviation(&separable, 1.0) < 1e-10);
        // This surface is not linear: the error of the differences is of second order in their step.
        let skewed = Marginal::beta(2.1, 5.0, 0.0, 1.0).unwrap();
        assert!(deviation(&Translated::new(separable, skewed).unwrap(), 1e-3) < 1e-5);
    }
}
