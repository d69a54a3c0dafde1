use super::*;
use asperity_base::correlation::{CorrelationModel, Covariance, Rotated};
use asperity_base::random;

fn germ(surface: &ConditionalSurface, index: u64) -> Vec<f64> {
    random::standard_normal(&mut random::stream(17, "conditional", index), surface.germ_len())
}

fn grid(nx: usize, ny: usize) -> Grid {
    Grid::new(nx, ny, 1.0, 1.0).unwrap()
}

fn covariance(model: CorrelationModel, length_m: f64) -> Covariance {
    Covariance::isotropic(model, 2.0, length_m).unwrap()
}

/// A map of `covariance`, with what `missing` says missing.
fn measured(covariance: &dyn StationaryCovariance, grid: Grid, missing: impl Fn(usize, usize) -> bool) -> HeightMap {
    truth(covariance, grid, 0, missing)
}

fn truth(
    covariance: &dyn StationaryCovariance,
    grid: Grid,
    index: u64,
    missing: impl Fn(usize, usize) -> bool,
) -> HeightMap {
    let field = SpectralField::free(covariance, grid).unwrap();
    let germ = random::standard_normal(&mut random::stream(18, "truth", index), field.germ_len());
    let mut heights = field.generate(&germ).heights_m().clone();
    heights.indexed_iter_mut().filter(|((row, column), _)| missing(*row, *column)).for_each(|(_, z)| *z = f64::NAN);
    HeightMap::new(grid, heights).unwrap()
}

/// Kriging by dense algebra: mean and covariance of all points, row by row, given the present heights with noise.
fn dense(covariance: &dyn StationaryCovariance, measured: &HeightMap, mean: f64, nugget: f64) -> (Vec<f64>, Mat<f64>) {
    let grid = measured.grid();
    let variance = covariance.std_m().powi(2);
    let c = |p: usize, q: usize| {
        let x = ((p % grid.nx()) as f64 - (q % grid.nx()) as f64) * grid.dx_m();
        let y = ((p / grid.nx()) as f64 - (q / grid.nx()) as f64) * grid.dy_m();
        variance * covariance.correlation(x, y)
    };
    let (at, n) = (places(measured), grid.points());
    let between =
        Mat::from_fn(at.len(), at.len(), |i, j| c(at[i], at[j]) + if i == j { nugget * variance } else { 0.0 });
    let to_all = Mat::from_fn(at.len(), n, |i, p| c(at[i], p));
    let values: Vec<f64> = measured.present_m().collect();
    let misses = Mat::from_fn(at.len(), 1, |i, _| values[i] - mean);
    let factor = between.partial_piv_lu();
    let (weights, solved) = (factor.solve(&misses), factor.solve(&to_all));
    let centre = to_all.transpose() * &weights;
    let known = to_all.transpose() * &solved;
    ((0..n).map(|p| mean + centre[(p, 0)]).collect(), Mat::from_fn(n, n, |p, q| c(p, q) - known[(p, q)]))
}

fn close(map: &HeightMap, wanted: &[f64], tolerance: f64) {
    for (place, (found, wanted)) in map.heights_m().iter().zip(wanted).enumerate() {
        assert!((found - wanted).abs() < tolerance, "place {place}: {found} {wanted}");
    }
}

/// The mean and the covariance of the maps as functions of the germ are those of dense kriging: z = m + Bξ, so both follow
/// from unit germs without any sampling.
fn is_kriging(covariance: &dyn StationaryCovariance, measured: &HeightMap, nugget: f64) {
    let options = Conditioning { mean_m: 0.7, nugget, tolerance: 1e-12, ..Conditioning::default() };
    let surface = ConditionalSurface::new(covariance, measured, options).unwrap();
    assert!(surface.clipped_variance() < 1e-12);
    let (mean, wanted) = dense(covariance, measured, 0.7, nugget);
    close(&surface.kriging_mean().unwrap(), &mean, 1e-9);
    let zero = vec![0.0; surface.germ_len()];
    close(&surface.generate(&zero), &mean, 1e-9);
    let variance = surface.kriging_variance_m2().unwrap();
    assert!(variance.iter().enumerate().all(|(p, v)| (v - wanted[(p, p)]).abs() < 1e-9));
    let points = measured.grid().points();
    let mut met = Mat::<f64>::zeros(points, points);
    for j in 0..surface.germ_len() {
        let mut unit = zero.clone();
        unit[j] = 1.0;
        let map = surface.draw(&unit).unwrap();
        let part: Vec<f64> = map.heights_m().iter().zip(&mean).map(|(z, m)| z - m).collect();
        for p in 0..points {
            for q in 0..points {
                met[(p, q)] += part[p] * part[q];
            }
        }
    }
    for p in 0..points {
        for q in 0..points {
            assert!((met[(p, q)] - wanted[(p, q)]).abs() < 1e-8, "{p} {q}: {} {}", met[(p, q)], wanted[(p, q)]);
        }
    }
}

#[test]
fn mean_and_covariance_are_those_of_dense_kriging() {
    let some = |row: usize, column: usize| (3 * row + 5 * column) % 7 < 5;
    let exponential = covariance(CorrelationModel::Exponential, 2.5);
    is_kriging(&exponential, &measured(&exponential, grid(9, 7), some), 0.0);
    let smooth =
        Rotated::new(Covariance::new(CorrelationModel::Matern { nu: 1.5 }, 2.0, 3.0, 1.2).unwrap(), 0.5).unwrap();
    is_kriging(&smooth, &measured(&smooth, grid(8, 7), some), 0.0);
    is_kriging(&smooth, &measured(&smooth, grid(8, 7), some), 0.05);
}

#[test]
fn measured_heights_are_kept_to_the_bit_and_met_by_the_weights() {
    let rough = covariance(CorrelationModel::Matern { nu: 1.2 }, 6.0);
    let map = measured(&rough, grid(60, 50), |row, column| {
        (row as f64 - 25.0).hypot(column as f64 - 30.0) < 11.0 || (7 * row + 3 * column) % 11 == 0
    });
    let options = Conditioning { tolerance: 1e-10, ..Conditioning::default() };
    let surface = ConditionalSurface::new(&rough, &map, options).unwrap();
    let drawn = surface.draw(&germ(&surface, 0)).unwrap();
    assert_eq!(drawn.missing_points(), 0);
    for (before, after) in map.heights_m().iter().zip(drawn.heights_m()).filter(|(before, _)| !before.is_nan()) {
        assert_eq!(before.to_bits(), after.to_bits());
    }
    // Before they are put in, the corrected map meets them to the tolerance.
    let values: Vec<f64> = map.present_m().collect();
    let met = surface.weighted(&values).unwrap();
    let worst = places(&map).iter().zip(&values).map(|(p, v)| (met[*p] - v).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-10 * 2.0, "{worst:e}");
}

#[test]
fn an_ensemble_has_the_kriging_mean_and_variance_and_far_away_the_unconditional_one() {
    let rough = covariance(CorrelationModel::Exponential, 3.0);
    // Heights in the left quarter alone.
    let map = measured(&rough, grid(64, 32), |_, column| column >= 16);
    let surface = ConditionalSurface::new(&rough, &map, Conditioning::default()).unwrap();
    let (mean, variance) = (surface.kriging_mean().unwrap(), surface.kriging_variance_m2().unwrap());
    let count = 400;
    let maps: Vec<HeightMap> = (0..count).map(|i| surface.draw(&germ(&surface, i)).unwrap()).collect();
    let at = [(16, 16), (10, 17), (20, 19), (5, 24), (16, 60)];
    for (row, column) in at {
        let values: Vec<f64> = maps.iter().map(|map| map.heights_m()[[row, column]]).collect();
        let found = values.iter().sum::<f64>() / count as f64;
        let spread = values.iter().map(|v| (v - found).powi(2)).sum::<f64>() / (count - 1) as f64;
        let (wanted, expected) = (mean.heights_m()[[row, column]], variance[[row, column]]);
        // Standard errors of a normal sample's mean and variance.
        assert!((found - wanted).abs() < 4.0 * (expected / count as f64).sqrt(), "({row}, {column}): {found} {wanted}");
        let error = expected * (2.0 / (count - 1) as f64).sqrt();
        assert!((spread - expected).abs() < 4.0 * error, "({row}, {column}): {spread} {expected}");
    }
    // Neighbours off the measured part: their covariance given the heights is that of dense kriging.
    let (_, given) = dense(&rough, &map, 0.0, 0.0);
    let pair = |map: &HeightMap| {
        let at = |row: usize, column: usize| map.heights_m()[[row, column]] - mean.heights_m()[[row, column]];
        at(12, 18) * at(14, 20)
    };
    let products: Vec<f64> = maps.iter().map(pair).collect();
    let found = products.iter().sum::<f64>() / count as f64;
    let spread = products.iter().map(|v| (v - found).powi(2)).sum::<f64>() / (count - 1) as f64;
    let wanted = given[(12 * 64 + 18, 14 * 64 + 20)];
    assert!((found - wanted).abs() < 4.0 * (spread / count as f64).sqrt(), "{found} {wanted}");
    // Fifteen lengths away nothing is known.
    assert!(mean.heights_m()[[16, 61]].abs() < 1e-5 && (variance[[16, 61]] - 4.0).abs() < 1e-9);
}

#[test]
fn noisy_heights_are_not_passed_through_but_weighed() {
    let rough = covariance(CorrelationModel::Matern { nu: 1.5 }, 5.0);
    let map = measured(&rough, grid(24, 20), |row, column| (row + column) % 3 != 0);
    let options = Conditioning { nugget: 0.1, ..Conditioning::default() };
    let surface = ConditionalSurface::new(&rough, &map, options).unwrap();
    assert_eq!(surface.germ_len(), surface.field.germ_len() + surface.measured_points());
    let (mean, given) = dense(&rough, &map, 0.0, 0.1);
    close(&surface.kriging_mean().unwrap(), &mean, 1e-8);
    let place = places(&map)[40];
    assert!(given[(place, place)] > 0.01, "something is left to be drawn at a noisy height");
}

#[test]
fn heights_of_a_law_are_met_and_the_rest_has_that_law() {
    let rough = covariance(CorrelationModel::Exponential, 2.0);
    let law = Marginal::lognormal(0.0, 0.6, -1.0).unwrap();
    let gaussian = measured(&Standardised(&rough), grid(48, 40), |row, column| row > 8 || column > 8);
    let heights = gaussian.heights_m().mapv(|g| law.translate(g));
    let map = HeightMap::new(gaussian.grid(), heights).unwrap();
    let surface = ConditionalSurface::with_law(&rough, &map, &law, Conditioning::default()).unwrap();
    // The scores are the Gaussian field again.
    let scores: Vec<f64> = gaussian.present_m().collect();
    assert!(surface.values.iter().zip(&scores).all(|(a, b)| (a - b).abs() < 1e-12));
    let (count, mut far) = (500, Vec::new());
    for index in 0..count {
        let drawn = surface.draw(&germ(&surface, index)).unwrap();
        assert!(map.heights_m().iter().zip(drawn.heights_m()).all(|(a, b)| a.is_nan() || a == b));
        far.push(drawn.heights_m()[[38, 45]]);
    }
    far.sort_by(f64::total_cmp);
    // Kolmogorov's distance; 1.95/√n is passed by one sample in a thousand.
    let distance = far
        .iter()
        .enumerate()
        .map(|(i, z)| (law.cdf(*z) - (i as f64 + 0.5) / count as f64).abs() + 0.5 / count as f64)
        .fold(0.0, f64::max);
    assert!(distance < 1.95 / (count as f64).sqrt(), "{distance}");
    // A height below the shift of the law cannot be.
    let mut heights = map.heights_m().clone();
    heights[[2, 3]] = -1.5;
    let error = ConditionalSurface::with_law(
        &rough,
        &HeightMap::new(map.grid(), heights).unwrap(),
        &law,
        Conditioning::default(),
    );
    assert!(matches!(error, Err(ConditionalError::OutsideLaw { row: 2, column: 3, .. })));
}

#[test]
fn a_measured_law_gives_its_own_heights_back() {
    let rough = covariance(CorrelationModel::Exponential, 4.0);
    let map = measured(&rough, grid(30, 30), |row, column| row.abs_diff(15) < 5 && column.abs_diff(15) < 5);
    let law = Marginal::empirical(map.present_m().collect()).unwrap();
    let surface = ConditionalSurface::with_law(&rough, &map, &law, Conditioning::default()).unwrap();
    let present: Vec<f64> = map.present_m().collect();
    for (score, height) in surface.values.iter().zip(&present) {
        assert!((law.translate(*score) - height).abs() < 1e-9);
    }
    let drawn = surface.draw(&germ(&surface, 0)).unwrap();
    let (low, high) = present.iter().fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(*z), h.max(*z)));
    assert!(drawn.present_m().all(|z| (low..=high).contains(&z)));
}

#[test]
fn a_map_is_extended_beyond_its_edges_and_its_voids_are_filled() {
    let rough = covariance(CorrelationModel::SelfAffine { hurst: 0.7 }, 5.0);
    let map = measured(&rough, grid(40, 30), |row, column| row < 6 && column > 30);
    let wide = surrounded(&map, 12, 7).unwrap();
    assert_eq!(wide.grid().shape(), (44, 64));
    assert_eq!(wide.missing_points(), 44 * 64 - map.present_m().count());
    assert_eq!(wide.heights_m()[[7, 12]], map.heights_m()[[0, 0]]);
    let surface = ConditionalSurface::new(&rough, &wide, Conditioning::default()).unwrap();
    let drawn = surface.draw(&germ(&surface, 3)).unwrap();
    assert_eq!(drawn.missing_points(), 0);
    // No seam: over truths and draws, steps across the edge have the mean square of steps anywhere.
    let wanted = 2.0 * 4.0 * (1.0 - rough.correlation(1.0, 0.0));
    let count = 30;
    let means: Vec<f64> = (0..count)
        .map(|index| {
            let wide = surrounded(&truth(&rough, grid(24, 30), index, |_, _| false), 4, 0).unwrap();
            let surface = ConditionalSurface::new(&rough, &wide, Conditioning::default()).unwrap();
            let drawn = surface.draw(&germ(&surface, index)).unwrap();
            let z = drawn.heights_m();
            (0..30).map(|row| (z[[row, 4]] - z[[row, 3]]).powi(2)).sum::<f64>() / 30.0
        })
        .collect();
    let mean = means.iter().sum::<f64>() / count as f64;
    let spread = means.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1) as f64;
    assert!((mean - wanted).abs() < 4.0 * (spread / count as f64).sqrt(), "{mean} {wanted}");
}

#[test]
fn no_convergence_is_an_error_and_leaves_the_points_missing() {
    // A squared exponential of many points per length: hardly more than a handful of its eigenvalues are above rounding.
    let smooth = covariance(CorrelationModel::SquaredExponential, 12.0);
    let map = measured(&smooth, grid(32, 32), |row, column| row > 20 && column > 20);
    let noisy = random::standard_normal(&mut random::stream(1, "noise", 0), 1024);
    let heights = Array2::from_shape_fn((32, 32), |(r, c)| map.heights_m()[[r, c]] + 0.1 * noisy[32 * r + c]);
    let map = HeightMap::new(map.grid(), heights).unwrap();
    let options = Conditioning { iterations: 60, ..Conditioning::default() };
    let surface = ConditionalSurface::new(&smooth, &map, options).unwrap();
    let error = surface.draw(&germ(&surface, 0)).unwrap_err();
    assert!(matches!(error, ConditionalError::NotConverged { .. }), "{error}");
    let left = surface.generate(&germ(&surface, 0));
    assert_eq!(left.missing_points(), map.missing_points());
    // With the noise that is there, it converges.
    let options = Conditioning { nugget: 0.0025, iterations: 60, ..Conditioning::default() };
    let surface = ConditionalSurface::new(&smooth, &map, options).unwrap();
    surface.draw(&germ(&surface, 0)).unwrap();
}

#[test]
fn few_iterations_settle_the_weights_of_many_heights() {
    // A snapshot of cost: iterations of the preconditioned solve on a map with a void and scattered missing points.
    for (model, most) in [
        (CorrelationModel::Exponential, 30),
        (CorrelationModel::SelfAffine { hurst: 0.8 }, 40),
        (CorrelationModel::Matern { nu: 1.5 }, 60),
    ] {
        let rough = covariance(model, 8.0);
        let map = measured(&rough, grid(96, 96), |row, column| {
            (row as f64 - 40.0).hypot(column as f64 - 50.0) < 15.0 || (31 * row + 17 * column) % 13 < 3
        });
        let options = Conditioning { iterations: most, ..Conditioning::default() };
        let surface = ConditionalSurface::new(&rough, &map, options).unwrap();
        surface.draw(&germ(&surface, 0)).unwrap_or_else(|error| panic!("{model:?}: {error}"));
    }
}

#[test]
fn maps_do_not_depend_on_the_number_of_threads() {
    let rough = covariance(CorrelationModel::Exponential, 3.0);
    let map = measured(&rough, grid(20, 20), |row, column| (row * column) % 3 == 0);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let surface = ConditionalSurface::new(&rough, &map, Conditioning::default()).unwrap();
            surface.draw(&germ(&surface, 0)).unwrap()
        })
    };
    assert!(with(1) == with(3), "not one bit may differ");
}

#[test]
fn options_outside_their_ranges_are_refused() {
    let rough = covariance(CorrelationModel::Exponential, 3.0);
    let map = measured(&rough, grid(8, 8), |row, _| row > 3);
    for options in [
        Conditioning { nugget: -1.0, ..Conditioning::default() },
        Conditioning { nugget: f64::NAN, ..Conditioning::default() },
        Conditioning { tolerance: 0.0, ..Conditioning::default() },
        Conditioning { iterations: 0, ..Conditioning::default() },
        Conditioning { mean_m: f64::INFINITY, ..Conditioning::default() },
    ] {
        assert!(matches!(ConditionalSurface::new(&rough, &map, options), Err(ConditionalError::Parameter { .. })));
    }
}
