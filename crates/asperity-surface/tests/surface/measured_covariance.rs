//! The measured covariance on fields of known correlation.

use asperity_base::correlation::{
    Autocorrelation, BlockSpectrum, CorrelationFamily, CorrelationModel, Covariance, MeasuredCovariance,
    MeasuredCovarianceError, Rotated, SeparableCovariance, StationaryCovariance, fit_covariance,
};
use asperity_base::distribution::standard_normal_quantile;
use asperity_base::map::{Grid, HeightMap};
use asperity_base::numeric::symmetric_eigen;
use asperity_base::random;
use asperity_surface::{GaussianSurface, KarhunenLoeve, ModesRoute, RandomSurface, SpectralField};
use ndarray::Array2;

/// Returns the transform of the cubic spline that is one at zero and zero at every other lag, over the pitch, at a
/// phase per lag.
fn spline_factor(phase: f64) -> f64 {
    let half = 0.5 * phase;
    let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
    3.0 * sinc.powi(4) / (2.0 + phase.cos())
}

fn all_lags(map: &HeightMap) -> Autocorrelation {
    Autocorrelation::within(map, map.grid().nx() - 1, map.grid().ny() - 1).unwrap()
}

fn draw(field: &SpectralField, stage: &str, index: u64) -> HeightMap {
    field.generate(&random::standard_normal(&mut random::stream(31, stage, index), field.xi_len()))
}

fn sample(covariance: &dyn StationaryCovariance, grid: Grid, index: u64) -> HeightMap {
    draw(&SpectralField::free(covariance, grid).unwrap(), "measured", index)
}

fn measure(map: &HeightMap) -> (Autocorrelation, MeasuredCovariance) {
    let estimate = all_lags(map).and_semivariance(map);
    let measured = MeasuredCovariance::new(&estimate).unwrap();
    (estimate, measured)
}

fn unit_grid(nx: usize, ny: usize) -> Grid {
    Grid::new(nx, ny, 1.0, 1.0).unwrap()
}

/// Short-range roughness on a wave that decays; no family of the fits has this shape.
struct Mixture;

impl StationaryCovariance for Mixture {
    fn std_m(&self) -> f64 {
        2.0
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        let envelope = (-(dx_m / 30.0).powi(2) - (dy_m / 12.0).powi(2)).exp();
        0.5 * envelope * (std::f64::consts::TAU * dx_m / 16.0).cos() + 0.5 * (-dx_m.hypot(dy_m) / 3.0).exp()
    }
}

fn ridge() -> Rotated<Covariance> {
    let long = Covariance::new(CorrelationModel::Matern { nu: 1.5 }, 1.5, 12.0, 4.0).unwrap();
    Rotated::new(long, 0.6).unwrap()
}

#[test]
fn reliable_lags_equal_the_estimate_except_for_the_mean_and_the_clipping() {
    let (estimate, measured) = measure(&sample(&ridge(), unit_grid(192, 160), 0));
    let report = measured.report();
    assert!(report.decayed_x && report.decayed_y && report.clipping_change < 0.03 && report.mean_share < 0.05);
    // Within the ellipse of the reliable lags: a disc that fits into it.
    let reach = 0.4 * report.reliable_x_m.min(report.reliable_y_m);
    assert!(reach > 4.0, "{report:?}");
    for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1), (-1, 1), (3, 2), (-3, 2), (4, -1)] {
        let before = (1.0 - report.mean_share) * estimate.correlation(x, y) + report.mean_share;
        let found = measured.correlation(x as f64, y as f64);
        assert!((found - before).abs() <= report.clipping_change + 1e-9, "({x}, {y}): {found} {before}");
        assert!((found - measured.correlation(-x as f64, -y as f64)).abs() < 1e-12);
    }
    assert!(measured.correlation(4.0, 3.0) > measured.correlation(-4.0, 3.0) + 0.2, "the lay is kept");
    let (end_x, end_y) = measured.support_m();
    assert!(measured.correlation(end_x, 0.0) == 0.0 && measured.correlation(0.0, -end_y) == 0.0);
}

#[test]
fn it_is_a_covariance_at_any_points_and_at_every_pitch() {
    let smooth = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 6.0, 3.0).unwrap();
    let white = Covariance::isotropic(CorrelationModel::Exponential, 1.0, 0.05).unwrap();
    let planted: [&dyn StationaryCovariance; 4] = [&ridge(), &Mixture, &smooth, &white];
    for (index, covariance) in planted.into_iter().enumerate() {
        let (_, measured) = measure(&sample(covariance, unit_grid(96, 96), 10 + index as u64));
        // Points off the lattice, close and far.
        let mut stream = random::stream(7, "points", index as u64);
        let at: Vec<f64> = random::standard_normal(&mut stream, 240).into_iter().map(|xi| 8.0 * xi).collect();
        let matrix = Array2::from_shape_fn((120, 120), |(i, j)| {
            measured.correlation(at[2 * i] - at[2 * j], at[2 * i + 1] - at[2 * j + 1])
        });
        let eigenvalues = symmetric_eigen(matrix).unwrap().values;
        assert!(eigenvalues[0] > -1e-9, "{index}: {:e}", eigenvalues[0]);
        for pitch in [0.31, 1.0, 1.7] {
            let grid = Grid::new(100, 90, pitch, pitch).unwrap();
            let clipped = SpectralField::free(&measured, grid).unwrap().clipped_variance();
            assert!(clipped < 1e-9, "{index} at pitch {pitch}: {clipped:e}");
        }
    }
}

#[test]
fn generated_maps_have_the_measured_correlation() {
    let grid = unit_grid(160, 128);
    let (estimate, measured) = measure(&sample(&ridge(), grid, 2));
    let report = measured.report();
    let field = SpectralField::free(&measured, grid).unwrap();
    let count = 60;
    let maps: Vec<Autocorrelation> = (0..count).map(|i| all_lags(&draw(&field, "again", i))).collect();
    let lags = [(0, 0), (1, 0), (0, 1), (2, 2), (-2, 2), (5, 0), (0, 5), (6, 4), (-6, 4), (9, 6)];
    for (x, y) in lags {
        let values: Vec<f64> = maps.iter().map(|map| map.covariance_m2(x, y)).collect();
        let mean = values.iter().sum::<f64>() / count as f64;
        let spread = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1) as f64;
        let error = (spread / count as f64).sqrt();
        let wanted = estimate.covariance_m2(x, y);
        // Four standard errors of the mean, plus the effect of clipping.
        let bound = 4.0 * error + report.clipping_change * estimate.variance_m2();
        assert!((mean - wanted).abs() < bound, "({x}, {y}): {mean} ± {error}, measured {wanted}");
    }
}

/// Returns the mean square of the slopes to the next heights over the variance.
fn slopes(rho: impl Fn(f64, f64) -> f64) -> f64 {
    4.0 - 2.0 * rho(1.0, 0.0) - 2.0 * rho(0.0, 1.0)
}

#[test]
#[ignore = "slow"]
fn a_smooth_map_stays_smooth() {
    // The slopes of the covariance are compared with differences of neighbours in the map. In a map
    // of twelve lengths the correlation may not visibly decay, and is then tapered.
    let smooth = Covariance::isotropic(CorrelationModel::SquaredExponential, 1.0, 8.0).unwrap();
    let lay = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 30.0, 5.0).unwrap();
    let oblique = Rotated::new(lay, 0.5).unwrap();
    let rough = Covariance::isotropic(CorrelationModel::Exponential, 1.0, 8.0).unwrap();
    let cases: [(&dyn StationaryCovariance, usize, f64); 5] =
        [(&smooth, 256, 0.01), (&smooth, 96, 0.05), (&lay, 256, 0.02), (&oblique, 256, 0.02), (&rough, 256, 0.005)];
    for (case, (covariance, points, bound)) in cases.into_iter().enumerate() {
        for holes in [false, true] {
            let mut ratios = Vec::new();
            for index in 0..6 {
                let map = sample(covariance, unit_grid(points, points), 40 + index);
                let mut heights = map.heights_m().clone();
                if holes {
                    let third = points / 3;
                    heights.slice_mut(ndarray::s![third..2 * third, points / 4..points / 2]).fill(f64::NAN);
                }
                let (estimate, measured) = measure(&HeightMap::new(map.grid(), heights).unwrap());
                let own = (estimate.semivariance_m2(1, 0).unwrap() + estimate.semivariance_m2(0, 1).unwrap())
                    / estimate.variance_m2();
                let fraction = 1.0 - measured.report().mean_share;
                ratios.push((slopes(|x, y| measured.correlation(x, y)) / (2.0 * fraction * own)).sqrt());
            }
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            assert!((mean - 1.0).abs() < bound, "case {case}, holes {holes}: {ratios:?}");
        }
    }
}

#[test]
fn scattered_voids_leave_a_smooth_map_nearly_smooth() {
    let smooth = Covariance::isotropic(CorrelationModel::SquaredExponential, 1.0, 8.0).unwrap();
    let map = sample(&smooth, unit_grid(256, 256), 50);
    let mask = random::standard_normal(&mut random::stream(5, "mask", 1), 65_536);
    let cut = standard_normal_quantile(0.2);
    let mut heights = map.heights_m().clone();
    heights.iter_mut().zip(mask).filter(|(_, m)| *m < cut).for_each(|(z, _)| *z = f64::NAN);
    let (_, whole) = measure(&map);
    let (_, holed) = measure(&HeightMap::new(map.grid(), heights).unwrap());
    let roughness = |measured: &MeasuredCovariance| slopes(|x, y| measured.correlation(x, y)).sqrt();
    // Every lag has different pairs, a noise of a few thousandths from lag to lag. As roughness it would double the
    // slopes.
    assert!((roughness(&holed) / roughness(&whole) - 1.0).abs() < 0.04);
}

#[test]
fn a_mixture_that_no_model_fits_is_reproduced_where_the_fitted_model_is_not() {
    let map = sample(&Mixture, unit_grid(320, 256), 3);
    let (_, measured) = measure(&map);
    let spectrum = BlockSpectrum::new(&map).unwrap();
    let fitted = fit_covariance(&[&spectrum], measured.std_m(), CorrelationFamily::ALL).unwrap().best();
    // The standard error of one lag of one map where the correlation is small; it is less where the correlation is
    // large.
    let error = measured.report().standard_error;
    assert!(error < 0.05);
    let mut worst = [0.0_f64; 2];
    for lag in 0..28 {
        let x = f64::from(lag);
        let wanted = Mixture.correlation(x, 0.0);
        worst[0] = worst[0].max((measured.correlation(x, 0.0) - wanted).abs());
        worst[1] = worst[1].max((Covariance::correlation(&fitted, x, 0.0) - wanted).abs());
    }
    assert!(worst[0] < 3.0 * error, "measured: {worst:?}, standard error {error}");
    assert!(worst[1] > 6.0 * error, "fitted: {worst:?}, standard error {error}");
    // The generated maps contain the wave.
    let field = SpectralField::periodic(&measured, unit_grid(320, 256));
    let drawn = all_lags(&draw(&field, "mixture", 0));
    assert!(drawn.correlation(8, 0) < -0.25 && drawn.correlation(16, 0) > 0.2);
}

#[test]
fn missing_heights_add_only_noise_to_the_covariance() {
    let map = sample(&Mixture, unit_grid(200, 200), 4);
    let (_, whole) = measure(&map);
    let mask = random::standard_normal(&mut random::stream(5, "mask", 0), 40_000);
    let cut = standard_normal_quantile(0.2);
    let mut heights = map.heights_m().clone();
    heights.iter_mut().zip(mask).filter(|(_, m)| *m < cut).for_each(|(z, _)| *z = f64::NAN);
    heights.slice_mut(ndarray::s![50..90, 100..160]).fill(f64::NAN);
    let (_, holed) = measure(&HeightMap::new(map.grid(), heights).unwrap());
    assert!((holed.std_m() / whole.std_m() - 1.0).abs() < 0.03);
    for (x, y) in [(1.0, 0.0), (0.0, 1.0), (8.0, 0.0), (16.0, 0.0), (3.0, 4.0), (0.5, 0.7)] {
        let change = (holed.correlation(x, y) - whole.correlation(x, y)).abs();
        assert!(change < whole.report().standard_error, "({x}, {y}): {change}");
    }
}

#[test]
fn the_variance_removed_with_the_mean_is_restored() {
    // Maps of eight correlation lengths: the mean removes about a tenth of the variance.
    let planted = Covariance::isotropic(CorrelationModel::Exponential, 1.0, 8.0).unwrap();
    let field = SpectralField::free(&planted, unit_grid(64, 64)).unwrap();
    let count = 60;
    let (mut raw, mut corrected) = (Vec::new(), Vec::new());
    for index in 0..count {
        let (estimate, measured) = measure(&draw(&field, "short", index));
        raw.push(estimate.variance_m2());
        corrected.push(measured.std_m().powi(2));
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count as f64;
    let error = |values: &[f64]| {
        let mean = mean(values);
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count * (count - 1)) as f64).sqrt()
    };
    let missing = 1.0 - mean(&raw);
    assert!(missing > 3.0 * error(&raw), "{missing}");
    // The correction also lacks the tail beyond the taper, so a part of the mean's variance stays lost.
    assert!((mean(&corrected) - 1.0).abs() < 2.0 * error(&corrected) + 0.5 * missing, "{}", mean(&corrected));
    assert!(mean(&corrected) > mean(&raw) + 0.5 * missing);
}

#[test]
fn karhunen_loeve_expands_it_generally_and_periodically() {
    let (_, measured) = measure(&sample(&ridge(), unit_grid(128, 128), 6));
    let grid = Grid::new(14, 11, 0.8, 1.3).unwrap();
    let surface = KarhunenLoeve::new(&measured, grid, grid.points(), ModesRoute::General).unwrap();
    assert!((surface.captured_variance() - 1.0).abs() < 1e-12);
    let met = surface.covariance_with_m2(5, 6);
    for ((row, column), value) in met.indexed_iter() {
        let (x, y) = (0.8 * (column as f64 - 6.0), 1.3 * (row as f64 - 5.0));
        assert!((value - measured.value_m2(x, y)).abs() < 1e-10 * measured.value_m2(0.0, 0.0));
    }
    let (end_x, end_y) = measured.support_m();
    let wide = unit_grid((2.0 * end_x) as usize + 2, (2.0 * end_y) as usize + 2);
    let periodic = KarhunenLoeve::new(&measured, wide, 400, ModesRoute::Periodic).unwrap();
    assert!(periodic.captured_variance() < 1.0 && periodic.captured_variance() > 0.5);
    let field = SpectralField::periodic(&measured, wide);
    assert!(field.clipped_variance() < 1e-9);
    let met = field.covariance_with_m2(20, 20);
    assert!((met[[23, 24]] - measured.value_m2(4.0, 3.0)).abs() < 1e-9);
    assert!((met[[23, 16]] - measured.value_m2(-4.0, 3.0)).abs() < 1e-9);
}

#[test]
fn a_lay_that_does_not_decay_is_reported_and_its_covariance_stays_valid() {
    let long = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 3.0, 150.0).unwrap();
    let (_, measured) = measure(&sample(&SeparableCovariance(long), unit_grid(128, 128), 8));
    let report = measured.report();
    assert!(report.decayed_x && !report.decayed_y && report.taper_change > 0.3, "{report:?}");
    assert!(report.clipping_change < 0.05);
    // The taper lowers it by less than a tenth up to a tenth of the map.
    assert!(measured.correlation(0.0, 12.0) > 0.9);
}

#[test]
fn an_estimate_of_fewer_lags_gives_a_shorter_covariance() {
    let long = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 3.0, 150.0).unwrap();
    let map = sample(&SeparableCovariance(long), unit_grid(128, 128), 8);
    let all = MeasuredCovariance::from_map(&map).unwrap();
    for (reach_x, reach_y) in [(64, 64), (5, 9), (1, 1)] {
        let few = MeasuredCovariance::new(&Autocorrelation::within(&map, reach_x, reach_y).unwrap()).unwrap();
        // The correlation of the moving average ends at twice the taper; its spline has tails of sixteen lags.
        assert!(few.support_m().1 <= 2.0 * reach_y as f64 + 16.0 + 2.0);
        assert!(few.correlation(0.0, 12.0) < all.correlation(0.0, 12.0) && !few.report().decayed_y);
    }
}

#[test]
fn the_profile_spectrum_is_the_transform_of_the_covariance_along_x() {
    let (_, measured) = measure(&sample(&ridge(), unit_grid(96, 80), 3));
    let end_m = measured.support_m().0;
    for q in [0.0, 0.05, 0.3, 1.0, 2.5, 4.0] {
        // Trapezoidal rule: the spline has a continuous second derivative, so errors fall like the fourth power.
        let step_m = 1.0 / 64.0;
        let terms = (1..(end_m / step_m) as usize).map(|k| k as f64 * step_m);
        let sum: f64 = terms.map(|x| measured.value_m2(x, 0.0) * (q * x).cos()).sum();
        let wanted = step_m * (measured.value_m2(0.0, 0.0) + 2.0 * sum);
        let found = measured.profile_psd_x_m3(q);
        assert!((found - wanted).abs() < 1e-6 * measured.profile_psd_x_m3(0.0).max(wanted), "{q}: {found} {wanted}");
    }
}

#[test]
fn a_map_without_roughness_or_neighbours_has_no_covariance() {
    let bowl = HeightMap::from_function(unit_grid(64, 64), |x, y| x * x + y * y).unwrap();
    let estimate = all_lags(&bowl);
    let error = MeasuredCovariance::new(&estimate).unwrap_err();
    assert!(matches!(error, MeasuredCovarianceError::FewPatches { patches, .. } if patches < 10.0), "{error}");
    let chess = HeightMap::from_function(unit_grid(16, 16), |x, y| {
        if (x as usize + y as usize).is_multiple_of(2) { x.sin() } else { f64::NAN }
    });
    let estimate = all_lags(&chess.unwrap());
    assert_eq!(MeasuredCovariance::new(&estimate).unwrap_err(), MeasuredCovarianceError::NoPairs);
}

#[test]
#[ignore = "slow"]
fn the_radial_spectrum_is_the_mean_of_the_transform_over_the_directions() {
    let (_, measured) = measure(&sample(&ridge(), unit_grid(96, 80), 3));
    let (end_x, end_y) = measured.support_m();
    let (end_x, end_y) = (end_x as i32, end_y as i32);
    // The transform of the lags at one wavevector, and the mean over sixty directions.
    let density = |qx: f64, qy: f64| {
        let mut sum = 0.0;
        for y in -end_y..=end_y {
            for x in -end_x..=end_x {
                let (x, y) = (f64::from(x), f64::from(y));
                sum += measured.value_m2(x, y) * (qx * x + qy * y).cos();
            }
        }
        sum * spline_factor(qx) * spline_factor(qy)
    };
    let mean = |q: f64| {
        let angles = (0..120).map(|i| std::f64::consts::PI * (f64::from(i) + 0.5) / 120.0);
        angles.map(|angle| density(q * angle.cos(), q * angle.sin())).sum::<f64>() / 120.0
    };
    // Means over rings, linear between them: about a triangle of weights.
    let width = std::f64::consts::TAU / f64::from(2 * end_x.min(end_y) + 1);
    let smooth = |q: f64| {
        let weights = (-3..=3).map(|i| (q + 0.25 * f64::from(i) * width, 1.0 - 0.25 * f64::from(i).abs()));
        weights.map(|(q, weight)| 0.25 * weight * mean(q)).sum::<f64>()
    };
    let wavenumbers = [0.3, 0.6, 1.2, 2.0];
    for (q, found) in wavenumbers.iter().zip(measured.radial_psd_m4(&wavenumbers)) {
        let wanted = smooth(*q);
        assert!((found / wanted - 1.0).abs() < 0.05, "{q}: {found} {wanted}");
    }
}

#[test]
fn the_normal_covariance_of_lognormal_heights_has_its_closed_form() {
    // Heights e^{sg} have ρ = (e^{s²ρ_G} − 1)/(e^{s²} − 1), so ρ_G = ln(1 + ρ(e^{s²} − 1))/s².
    let (_, measured) = measure(&sample(&ridge(), unit_grid(96, 80), 3));
    let square = 0.8_f64.powi(2);
    let distorted = |rho: f64| (square * rho).exp_m1() / square.exp_m1();
    let beneath = measured.beneath(distorted, 0.5, |_| 1.0);
    for (x, y) in [(1.0, 0.0), (0.0, 1.0), (2.0, 3.0), (4.0, -2.0), (6.0, 6.0)] {
        let wanted = (measured.correlation(x, y) * square.exp_m1()).ln_1p() / square;
        let found = beneath.correlation(x, y);
        assert!((found - wanted).abs() < 0.03, "({x}, {y}): {found} {wanted}");
    }
    assert!((beneath.correlation(0.0, 1e-9) - 1.0).abs() < 1e-6 && beneath.std_m() == measured.std_m());
    // It is a valid covariance: a free field of it needs no clipping.
    let clipped = SpectralField::free(&beneath, unit_grid(96, 80)).unwrap().clipped_variance();
    assert!(clipped < 1e-6, "{clipped}");
    // Slopes that are 1.3 times too large are lowered by that factor: 1 − ρ at one lag is its square.
    let target = measured.correlation(1.0, 0.0);
    let ratio = |own: &MeasuredCovariance| ((1.0 - own.correlation(1.0, 0.0)) / (1.0 - target)).sqrt();
    let smoother = measured.beneath(|rho| rho, 0.5, |own| 1.3 * ratio(own));
    assert!((1.3 * ratio(&smoother) - 1.0).abs() < 0.02, "{}", ratio(&smoother));
}

#[test]
fn deconvolution_keeps_grooves_that_run_through_the_map() {
    // Grooves along y; the correlation over half of the map is known: exp(−(64/150)²) = 0.83.
    let long = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 3.0, 150.0).unwrap();
    let (mut tapered, mut sharp) = (0.0, 0.0);
    for index in 0..8 {
        let map = sample(&SeparableCovariance(long), unit_grid(128, 128), 70 + index);
        let (_, measured) = measure(&map);
        let own = measured.deconvolved(&map);
        tapered += measured.correlation(0.0, 64.0) / 8.0;
        sharp += own.correlation(0.0, 64.0) / 8.0;
        let field = SpectralField::free(&own, map.grid()).unwrap();
        assert!(field.clipped_variance() < 1e-9, "non-negative on twice the sides: {}", field.clipped_variance());
    }
    // The iterations approach it from below.
    assert!(tapered < 0.3 && (0.65..0.85).contains(&sharp), "{tapered} {sharp}");
}

#[test]
fn deconvolution_leaves_no_floor_beneath_a_steep_spectrum() {
    // Mean squares of the first to fourth differences of neighbours weigh the shortest waves more and more. A map without
    // voids has them without any model.
    let steep = Covariance::isotropic(CorrelationModel::Matern { nu: 3.0 }, 1.0, 4.0).unwrap();
    let (mut met, mut wanted) = ([0.0; 4], [0.0; 4]);
    for index in 0..10 {
        let map = sample(&steep, unit_grid(128, 128), 90 + index);
        let (_, measured) = measure(&map);
        let own = measured.deconvolved(&map);
        for order in 1..=4 {
            // Coefficients of (1 − shift)^k times its reverse: the binomials of 2k with alternating signs.
            let mut rows: Vec<Vec<f64>> = map.heights_m().rows().into_iter().map(|row| row.to_vec()).collect();
            for row in &mut rows {
                for _ in 0..order {
                    *row = row.windows(2).map(|pair| pair[1] - pair[0]).collect();
                }
            }
            let count = rows.iter().map(Vec::len).sum::<usize>() as f64;
            wanted[order - 1] += rows.iter().flatten().map(|d| d * d).sum::<f64>() / count;
            let mut binomial = 1.0;
            for k in 0..=2 * order {
                let lag = k as f64 - order as f64;
                let sign = if (k + order).is_multiple_of(2) { 1.0 } else { -1.0 };
                met[order - 1] += sign * binomial * own.value_m2(lag, 0.0);
                binomial *= (2 * order - k) as f64 / (k + 1) as f64;
            }
        }
    }
    let ratios: Vec<f64> = met.iter().zip(wanted).map(|(met, wanted)| met / wanted).collect();
    assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.1), "{ratios:?}");
}
