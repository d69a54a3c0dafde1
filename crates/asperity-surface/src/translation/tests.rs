use super::*;
use crate::{KarhunenLoeve, ModesRoute, SpectralField};
use asperity_base::correlation::{CorrelationModel, Covariance, StationaryCovariance};
use asperity_base::random;

fn covariance(model: CorrelationModel, length_m: f64) -> Covariance {
    Covariance::isotropic(model, 1.0, length_m).unwrap()
}

fn beta() -> Marginal {
    Marginal::beta(2.1, 5.0, 0.0, 1.0).unwrap()
}

#[test]
fn the_table_equals_the_quantile() {
    for marginal in [beta(), Marginal::beta(0.6, 0.8, -1.0, 3.0).unwrap(), Marginal::beta(30.0, 2.0, 0.0, 1.0).unwrap()]
    {
        let map = NormalToMarginal::new(&marginal, 0.0, 1.0);
        for i in -900..=900 {
            let g = f64::from(i) * 0.010_37;
            let error = (map.value(g) - marginal.translate(g)).abs();
            assert!(error < 2e-9, "{marginal:?} at {g}: {error:e}");
        }
    }
}

#[test]
fn heights_have_the_distribution_at_every_point_also_of_a_truncated_field() {
    // 12 modes have about half of the variance, unevenly. Kolmogorov's distance stays below its 1e−3 quantile.
    let grid = Grid::new(16, 16, 1.0, 1.0).unwrap();
    let field =
        KarhunenLoeve::new(&covariance(CorrelationModel::Exponential, 4.0), grid, 12, ModesRoute::Separable).unwrap();
    assert!(field.captured_variance() < 0.7);
    let surface = Translated::new(field, beta()).unwrap();
    assert!(surface.least_variance_fraction() < 0.9);
    let count = 4000;
    let maps: Vec<_> = (0..count)
        .map(|index| surface.generate(&random::standard_normal(&mut random::stream(2, "law", index), 12)))
        .collect();
    for place in [[0, 0], [8, 8], [3, 15]] {
        let mut values: Vec<f64> = maps.iter().map(|map| map.heights_m()[place]).collect();
        values.sort_by(f64::total_cmp);
        let distance = values
            .iter()
            .enumerate()
            .fold(0.0_f64, |m, (i, z)| m.max((beta().cdf(*z) - (i as f64 + 0.5) / count as f64).abs()));
        assert!(distance < 1.95 / (count as f64).sqrt(), "{place:?}: {distance}");
    }
}

/// Returns the largest deviation of the correlation around the centre of the map from `target`.
fn largest_deviation<S: GaussianSurface>(surface: &Translated<S>, target: &dyn StationaryCovariance) -> f64 {
    let grid = surface.grid();
    let (row, column) = (grid.ny() / 2, grid.nx() / 2);
    let met = surface.correlation_with(row, column);
    let deviation = |((r, c), value): ((usize, usize), &f64)| {
        let lag_x = (c as f64 - column as f64) * grid.dx_m();
        let lag_y = (r as f64 - row as f64) * grid.dy_m();
        (value - target.correlation(lag_x, lag_y)).abs()
    };
    met.indexed_iter().map(deviation).fold(0.0, f64::max)
}

#[test]
fn a_plain_lognormal_translation_has_the_closed_form_distortion() {
    // ρ_X = (e^{σ²ρ} − 1)/(e^{σ²} − 1).
    let sigma = 0.8_f64;
    let target = covariance(CorrelationModel::SquaredExponential, 4.0);
    let field = SpectralField::free(&target, Grid::new(32, 32, 1.0, 1.0).unwrap()).unwrap();
    let surface = Translated::new(field, Marginal::lognormal(0.0, sigma, 0.0).unwrap()).unwrap();
    let met = surface.correlation_with(16, 16);
    let mut largest = 0.0_f64;
    for ((row, column), value) in met.indexed_iter() {
        let rho = target.correlation(column as f64 - 16.0, row as f64 - 16.0);
        let wanted = (sigma * sigma * rho).exp_m1() / (sigma * sigma).exp_m1();
        assert!((value - wanted).abs() < 1e-9);
        largest = largest.max((wanted - rho).abs());
    }
    assert!((largest_deviation(&surface, &target) - largest).abs() < 1e-9 && largest > 0.05);
}

#[test]
fn the_corrected_translation_reproduces_the_target_and_the_plain_one_does_not() {
    let target = covariance(CorrelationModel::Exponential, 5.0);
    let grid = Grid::new(48, 48, 1.0, 1.0).unwrap();
    let marginal = Marginal::lognormal(0.0, 0.8, 0.0).unwrap();
    let plain = Translated::new(SpectralField::periodic(&target, grid), marginal.clone()).unwrap();
    let predistorted = Predistorted::new(target, &marginal).unwrap();
    let field = SpectralField::periodic(&predistorted, grid);
    let clipped = field.clipped_variance();
    let corrected = Translated::new(field, marginal).unwrap();
    let (before, after) = (largest_deviation(&plain, &target), largest_deviation(&corrected, &target));
    assert!(before > 0.03);
    assert!(after < 0.02 * before + 3.0 * clipped, "{after}, clipped {clipped}");
}

#[test]
fn the_predistortion_of_the_papers_beta_distribution_is_the_published_one() {
    // Published ρ_G for ρ_X = e⁻¹, e^{−.1} and e⁻².
    let gaussian = Predistorted::new(covariance(CorrelationModel::Exponential, 1.0), &beta()).unwrap();
    for (lag, wanted) in [(1.0, 0.375_013_83), (0.1, 0.907_643_18), (2.0, 0.138_828_91)] {
        assert!((gaussian.correlation(lag, 0.0) - wanted).abs() < 5e-8);
    }
}

#[test]
fn sampled_heights_have_the_computed_correlation() {
    let target = covariance(CorrelationModel::SquaredExponential, 3.0);
    let grid = Grid::new(24, 24, 1.0, 1.0).unwrap();
    let predistorted = Predistorted::new(target, &beta()).unwrap();
    let surface = Translated::with_rms_height(SpectralField::periodic(&predistorted, grid), beta(), 2.0).unwrap();
    let wanted = surface.correlation_with(0, 0);
    let lags = [(0, 0), (1, 0), (2, 1), (0, 4)];
    let count = 600;
    let mut sums = [(0.0, 0.0); 4];
    for index in 0..count {
        let xi = random::standard_normal(&mut random::stream(4, "beta", index), surface.xi_len());
        let map = surface.generate(&xi);
        let z = map.heights_m();
        for (sum, (x, y)) in sums.iter_mut().zip(lags) {
            let mean = z.indexed_iter().map(|((r, c), v)| v * z[[(r + y) % 24, (c + x) % 24]]).sum::<f64>() / 576.0;
            *sum = (sum.0 + mean, sum.1 + mean * mean);
        }
    }
    for ((sum, square), (x, y)) in sums.into_iter().zip(lags) {
        let mean = sum / count as f64;
        let error = ((square / count as f64 - mean * mean) / (count - 1) as f64).sqrt();
        assert!((mean - 4.0 * wanted[[y, x]]).abs() < 4.0 * error, "({x},{y}): {mean} ± {error}");
    }
}

#[test]
fn a_field_that_vanishes_at_a_point_is_refused() {
    // One odd mode is zero in the middle of a grid with an odd number of points.
    let grid = Grid::new(9, 2, 1.0, 1.0).unwrap();
    let full = covariance(CorrelationModel::SquaredExponential, 30.0);
    let field = KarhunenLoeve::new(&full, grid, 1, ModesRoute::Separable).unwrap();
    assert!(Translated::new(field, beta()).is_ok());
    #[derive(Debug)]
    struct Odd(Grid);
    impl RandomSurface for Odd {
        fn xi_len(&self) -> usize {
            1
        }
        fn grid(&self) -> Grid {
            self.0
        }
        fn generate(&self, xi: &[f64]) -> HeightMap {
            HeightMap::from_function(self.0, |x, _| xi[0] * (x - 4.5)).unwrap()
        }
    }
    impl GaussianSurface for Odd {
        fn pointwise_std_m(&self) -> Array2<f64> {
            self.generate(&[1.0]).heights_m().mapv(f64::abs)
        }
        fn covariance_with_m2(&self, row: usize, column: usize) -> Array2<f64> {
            let shape = self.generate(&[1.0]).heights_m().clone();
            let here = shape[[row, column]];
            shape * here
        }
    }
    let error = Translated::new(Odd(grid), beta()).unwrap_err();
    assert!(matches!(error, TranslationError::Generator(GeneratorError::NoVariance { column: 4, .. })), "{error}");
}
