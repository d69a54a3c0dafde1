use super::*;
use crate::{KarhunenLoeve, ModesRoute, SpectralField};
use asperity_base::correlation::{CorrelationModel, Covariance, Rotated, SeparableCovariance, StationaryCovariance};
use asperity_base::random;
use asperity_base::stats::Moments;
use rand::RngExt;
use std::f64::consts::TAU;

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

/// Returns the correlation of translated variables as a function of that of the normal ones, by Mehler's series of the
/// Hermite coefficients of F⁻¹(Φ(g)).
fn distortion(marginal: &Marginal) -> impl Fn(f64) -> f64 {
    let mut squares = [0.0; 80];
    let nodes: Vec<_> = (-288..=288).map(|i| f64::from(i) / 32.0).map(|g| (g, marginal.translate(g))).collect();
    let mut psi: Vec<_> =
        nodes.iter().map(|(g, _)| [0.0, (-0.25 * g * g).exp() / (32.0 * TAU.sqrt()).sqrt()]).collect();
    for (n, square) in squares.iter_mut().enumerate() {
        let weight = |g: f64| (-0.25 * g * g).exp() / (32.0 * TAU.sqrt()).sqrt();
        let coefficient: f64 = nodes.iter().zip(&psi).map(|((g, z), psi)| z * psi[1] * weight(*g)).sum();
        *square = if n == 0 { 0.0 } else { coefficient * coefficient };
        let n = n as f64;
        for ((g, _), psi) in nodes.iter().zip(&mut psi) {
            *psi = [psi[1], (g * psi[1] - n.sqrt() * psi[0]) / (n + 1.0).sqrt()];
        }
    }
    let variance = marginal.std().powi(2);
    let rest = variance - squares.iter().sum::<f64>();
    move |rho| (squares.iter().rev().fold(rest, |sum, square| sum * rho + square)) / variance
}

fn random_correlation(rng: &mut random::Stream) -> CorrelationModel {
    match rng.random_range(0..4) {
        0 => CorrelationModel::SquaredExponential,
        1 => CorrelationModel::Exponential,
        2 => CorrelationModel::Matern { nu: rng.random_range(0.2..4.0) },
        _ => CorrelationModel::SelfAffine { hurst: rng.random_range(0.05..0.95) },
    }
}

fn random_marginal(rng: &mut random::Stream) -> Marginal {
    let (a, b): (f64, f64) = (rng.random_range(0.6..5.0), rng.random_range(0.6..5.0));
    let text = match rng.random_range(0..6) {
        0 => "normal".to_owned(),
        1 => format!("lognormal:0,{}", 0.15 * a),
        2 => format!("weibull:{},1", 0.5 + a),
        3 => format!("gamma:{a},{b}"),
        4 => format!("beta:{a},{b}"),
        _ => format!("triangular:0,{},{}", a, a + b),
    };
    text.parse().unwrap()
}

/// Returns the means over a map of the product of heights at each lag, of the heights, and of the squared differences of
/// neighbours along x and along y.
fn statistics(map: &HeightMap, periodic: bool, lags: &[(usize, usize)]) -> Vec<f64> {
    let z = map.heights_m();
    let (ny, nx) = z.dim();
    let mean = |f: &dyn Fn(f64, f64) -> f64, (x, y): (usize, usize)| {
        let (rows, columns) = if periodic { (ny, nx) } else { (ny - y, nx - x) };
        let pairs = (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c)));
        pairs.map(|(r, c)| f(z[[r, c]], z[[(r + y) % ny, (c + x) % nx]])).sum::<f64>() / (rows * columns) as f64
    };
    let products = lags.iter().map(|lag| mean(&|a, b| a * b, *lag));
    let difference = |lag| mean(&|a, b| (b - a).powi(2), lag);
    products.chain([mean(&|a, _| a, (0, 0)), difference((1, 0)), difference((0, 1))]).collect()
}

#[test]
#[ignore = "slow"]
fn random_models_have_their_moments_correlations_and_slopes_within_four_standard_errors() {
    let (mut used, count) = (0, 400);
    for case in 0.. {
        let rng = &mut random::stream(9, "random surface models", case);
        let kind = rng.random_range(0..4);
        let sides = if kind < 2 { 12..=56_usize } else { 6..=14 };
        let (nx, ny) = (rng.random_range(sides.clone()), rng.random_range(sides));
        let (dx, dy) = (rng.random_range(0.5..2.0), rng.random_range(0.5..2.0));
        let grid = Grid::new(nx, ny, dx, dy).unwrap();
        let longest = 0.15 * f64::min(nx as f64 * dx, ny as f64 * dy);
        let lengths = [rng.random_range(0.3..longest), rng.random_range(0.3..longest)];
        let lengths = if rng.random() { [lengths[0]; 2] } else { lengths };
        let (model, marginal) = (random_correlation(rng), random_marginal(rng));
        let wanted: Box<dyn StationaryCovariance> = {
            let along = Covariance::new(model, 1.0, lengths[0], lengths[1]).unwrap();
            match (kind, rng.random()) {
                (3, _) => Box::new(SeparableCovariance(along)),
                (_, true) => Box::new(Rotated::new(along, rng.random_range(0.0..3.0)).unwrap()),
                (_, false) => Box::new(along),
            }
        };
        let corrected = rng.random::<bool>();
        let predistorted = Predistorted::new(&*wanted, &marginal).unwrap();
        let normal: &dyn StationaryCovariance = if corrected && kind < 2 { &predistorted } else { &*wanted };
        let (field, clipped): (Box<dyn GaussianSurface>, f64) = if kind < 2 {
            let field =
                if kind == 0 { Ok(SpectralField::periodic(normal, grid)) } else { SpectralField::free(normal, grid) };
            let field = field.unwrap();
            let clipped = field.clipped_variance();
            (Box::new(field), clipped)
        } else {
            let route = if kind == 2 { ModesRoute::General } else { ModesRoute::Separable };
            (Box::new(KarhunenLoeve::new(&*wanted, grid, nx * ny, route).unwrap()), 0.0)
        };
        // The covariance may deviate by about the clipped variance.
        if clipped > 1e-4 {
            continue;
        }
        used += 1;
        let surface = Translated::with_rms_height(field, marginal.clone(), 2.0).unwrap();
        let corrected = corrected && kind < 2;
        let distort = distortion(&marginal);
        let expected = |x: usize, y: usize| {
            // On a periodic grid the nearest image counts.
            let wrapped =
                |lag: usize, n: usize| if kind == 0 && 2 * lag > n { lag as f64 - n as f64 } else { lag as f64 };
            let rho = wanted.correlation(wrapped(x, nx) * dx, wrapped(y, ny) * dy);
            4.0 * if corrected { rho } else { distort(rho) }
        };
        let lags = [(0, 0), (1, 0), (0, 1), (2, 1), (3, 0), (0, 4), (nx / 2, ny / 3)];
        let mut seen = vec![Vec::with_capacity(count); 3 + lags.len()];
        for index in 0..count as u64 {
            let xi = random::standard_normal(&mut random::stream(case, "map", index), surface.xi_len());
            let found = statistics(&surface.generate(&xi), kind == 0, &lags);
            seen.iter_mut().zip(found).for_each(|(seen, found)| seen.push(found));
        }
        let slope = |x, y| 2.0 * (expected(0, 0) - expected(x, y));
        let wanted = lags.iter().map(|(x, y)| expected(*x, *y)).chain([0.0, slope(1, 0), slope(0, 1)]);
        for (i, (values, wanted)) in seen.into_iter().zip(wanted).enumerate() {
            let found = Moments::from_values(values.into_iter());
            let allowed = 4.0 * found.standard_error() + 8.0 * clipped;
            let case = format!("{case}: {kind} {model:?} {lengths:?} {marginal} {nx} {ny}");
            assert!(
                (found.mean - wanted).abs() < allowed,
                "{case}, value {i}: {} ± {allowed}, not {wanted}",
                found.mean
            );
        }
        if used == 30 {
            return;
        }
    }
}
