use super::lanczos::sort_falling;
use super::profile::dense_eigenpairs;
use super::profile::tests::exponential_eigenvalues_m;
use super::*;
use asperity_base::correlation::{CorrelationModel, Rotated, SeparableCovariance};
use asperity_base::random;

fn unit(model: CorrelationModel, length_x_m: f64, length_y_m: f64) -> Covariance {
    Covariance::new(model, 1.0, length_x_m, length_y_m).unwrap()
}

/// Returns the eigenvalues of the full covariance matrix of a small grid times the cell area.
fn dense(covariance: &dyn StationaryCovariance, grid: Grid) -> Vec<f64> {
    let place = |i: usize| ((i % grid.nx()) as f64 * grid.dx_m(), (i / grid.nx()) as f64 * grid.dy_m());
    let entry = |i: usize, j: usize| {
        let ((xi, yi), (xj, yj)) = (place(i), place(j));
        grid.cell_area_m2() * covariance.correlation(xi - xj, yi - yj)
    };
    dense_eigenpairs(grid.points(), entry).unwrap().0
}

/// Returns the functions as rows of ny·nx values.
fn functions(found: &ClassModes) -> Array2<f64> {
    let count = found.eigenvalues_m2.len();
    let rows: Vec<Vec<f64>> =
        (0..count).map(|j| found.superpose((0..count).map(|k| f64::from(u8::from(j == k))))).collect();
    Array2::from_shape_fn((count, rows[0].len()), |(j, i)| rows[j][i])
}

fn assert_orthonormal(surface: &KarhunenLoeve) {
    let cell = surface.grid().cell_area_m2();
    let functions: Vec<_> = (0..surface.xi_len()).map(|j| surface.mode_per_m(j)).collect();
    for (i, a) in functions.iter().enumerate() {
        for (j, b) in functions.iter().enumerate().take(i + 1) {
            let product = cell * (a * b).sum();
            assert!((product - f64::from(u8::from(i == j))).abs() < 1e-10, "modes {i}, {j}: {product}");
        }
    }
}

#[test]
fn a_hundred_and_one_terms_have_the_known_fraction_of_a_two_dimensional_variance() {
    // The fractions of the separable exponential and of the squared exponential on the unit square, to the three
    // published digits.
    for (length, exponential, squared) in [(0.1, 0.665, 0.940), (0.2, 0.839, 0.9999)] {
        let fraction = |model| {
            modes(&unit(model, length, length), &[1.0, 1.0], &[256, 256], 101, ModesRoute::Separable)
                .unwrap()
                .captured_variance
        };
        assert!((fraction(CorrelationModel::Exponential) - exponential).abs() < 1e-3);
        assert!((fraction(CorrelationModel::SquaredExponential) - squared).abs() < 1e-3);
    }
}

#[test]
fn products_of_the_closed_form_equal_the_separable_spectrum() {
    let line = exponential_eigenvalues_m(0.2, 1.0, 101);
    let mut wanted: Vec<f64> = line.iter().flat_map(|a| line.iter().map(move |b| a * b)).collect();
    wanted.sort_by(|a, b| b.total_cmp(a));
    let covariance = unit(CorrelationModel::Exponential, 0.2, 0.2);
    let coarse = modes(&covariance, &[1.0, 1.0], &[128, 128], 101, ModesRoute::Separable).unwrap();
    let fine = modes(&covariance, &[1.0, 1.0], &[256, 256], 101, ModesRoute::Separable).unwrap();
    for (value, wanted) in fine.eigenvalues.iter().zip(&wanted).take(12) {
        assert!((value / wanted - 1.0).abs() < 2e-3, "{value} {wanted}");
    }
    let fraction: f64 = wanted[..101].iter().sum();
    let errors = [coarse, fine].map(|found| (found.captured_variance - fraction).abs());
    assert!(errors[1] < 1e-3 && ((errors[0] / errors[1]).log2() - 2.0).abs() < 0.1, "{errors:?}");
}

#[test]
fn the_separable_exponential_has_its_published_spectrum_on_the_unit_square() {
    // Products of the closed-form eigenvalues of e^{−5|x−y|}.
    let published = [
        0.109_508_446_799_123_1,
        0.069_419_234_116_789_88,
        0.069_419_234_116_789_88,
        0.044_006_012_378_218_42,
        0.041_002_987_465_165_8,
        0.041_002_987_465_165_8,
        0.025_992_478_840_955_84,
        0.025_992_478_840_955_84,
        0.025_138_512_839_319_3,
        0.025_138_512_839_319_3,
        0.016_420_885_587_705_82,
        0.016_420_885_587_705_82,
    ];
    let covariance = unit(CorrelationModel::Exponential, 0.2, 0.2);
    let found = [256, 512].map(|n| modes(&covariance, &[1.0, 1.0], &[n, n], 101, ModesRoute::Separable).unwrap());
    for (value, wanted) in found[1].eigenvalues.iter().zip(published) {
        assert!((value / wanted - 1.0).abs() < 2e-4, "{value} {wanted}");
    }
    let errors = found.map(|found| (found.captured_variance - 0.838_697_221_059_422_5).abs());
    assert!(errors[1] < 2e-4 && ((errors[0] / errors[1]).log2() - 2.0).abs() < 0.05, "{errors:?}");
}

#[test]
#[ignore = "slow"]
fn a_hundred_and_one_modes_by_iteration_equal_those_of_the_dense_problem() {
    // A constant start vector, or a single one, would return pairs of equal eigenvalues twice or once too few.
    let grid = Grid::with_size(64, 64, 1.0, 1.0).unwrap();
    for covariance in
        [unit(CorrelationModel::Exponential, 0.2, 0.2), unit(CorrelationModel::Matern { nu: 1.5 }, 0.2, 0.2)]
    {
        let wanted = general::dense_modes(&covariance, grid, 101).unwrap().eigenvalues_m2;
        let found = general::iterated_modes(&covariance, grid, 101).unwrap();
        assert!(found.eigenvalues_m2.iter().zip(&wanted).all(|(f, w)| (f - w).abs() < 1e-12 * wanted[0]));
        let vectors = functions(&found);
        let gram = vectors.dot(&vectors.t()) * grid.cell_area_m2();
        assert!(gram.indexed_iter().all(|((i, j), v)| (v - f64::from(u8::from(i == j))).abs() < 1e-11));
    }
}

#[test]
fn an_oblique_lay_keeps_its_angle_in_the_modes() {
    let grid = Grid::new(13, 10, 1.0, 0.8).unwrap();
    let covariance = Rotated::new(unit(CorrelationModel::Matern { nu: 1.5 }, 6.0, 2.0), 0.6).unwrap();
    let wanted = dense(&covariance, grid);
    for method in [general::dense_modes, general::iterated_modes] {
        let found = method(&covariance, grid, 40).unwrap();
        assert!(found.eigenvalues_m2.iter().zip(&wanted).all(|(f, w)| (f - w).abs() < 1e-11 * wanted[0]));
        let vectors = functions(&found);
        let gram = vectors.dot(&vectors.t()) * grid.cell_area_m2();
        assert!(gram.indexed_iter().all(|((i, j), v)| (v - f64::from(u8::from(i == j))).abs() < 1e-11));
        // All modes reproduce the covariance, which differs from the covariance at mirrored lags.
        let all = method(&covariance, grid, grid.points()).unwrap();
        let here = all.values_at(4 * 13 + 6);
        let met = all.superpose(all.eigenvalues_m2.iter().zip(here).map(|(value, phi)| value * phi));
        for (place, value) in met.iter().enumerate() {
            let (x, y) = ((place % 13) as f64 - 6.0, 0.8 * ((place / 13) as f64 - 4.0));
            assert!((value - covariance.correlation(x, y)).abs() < 1e-11);
        }
        assert!((covariance.correlation(3.0, 2.4) - covariance.correlation(-3.0, 2.4)).abs() > 0.2);
    }
    let periodic = KarhunenLoeve::new(&covariance, grid, grid.points(), ModesRoute::Periodic).unwrap();
    let met = periodic.covariance_with_m2(4, 6);
    assert!((met[[6, 8]] - met[[2, 4]]).abs() < 1e-12 && met[[6, 8]] > met[[6, 4]] + 0.2);
}

#[test]
fn both_general_methods_return_the_dense_eigenvalues_with_their_multiplicity() {
    let grids = [Grid::new(16, 16, 1.0, 1.0), Grid::new(20, 11, 0.5, 1.0), Grid::new(9, 13, 1.0, 1.0)];
    for grid in grids.map(Result::unwrap) {
        for covariance in [
            unit(CorrelationModel::Exponential, 4.0, 4.0),
            unit(CorrelationModel::Matern { nu: 1.5 }, 3.0, 6.0),
            unit(CorrelationModel::SelfAffine { hurst: 0.8 }, 5.0, 5.0),
        ] {
            let wanted = dense(&covariance, grid);
            for method in [general::dense_modes, general::iterated_modes] {
                let found = method(&covariance, grid, 40).unwrap();
                let vectors = functions(&found);
                for (j, (f, w)) in found.eigenvalues_m2.iter().zip(&wanted).enumerate() {
                    assert!((f - w).abs() < 1e-11 * wanted[0], "{covariance:?} mode {j}: {f} {w}");
                }
                let gram = vectors.dot(&vectors.t()) * grid.cell_area_m2();
                assert!(gram.indexed_iter().all(|((i, j), v)| (v - f64::from(u8::from(i == j))).abs() < 1e-11));
            }
        }
    }
}

#[test]
fn rounding_does_not_order_the_modes_of_a_square() {
    let grid = Grid::new(18, 18, 1.0, 1.0).unwrap();
    let isotropic = unit(CorrelationModel::Matern { nu: 0.8 }, 5.0, 5.0);
    let diagonal = Rotated::new(unit(CorrelationModel::Exponential, 9.0, 3.0), std::f64::consts::FRAC_PI_4).unwrap();
    for covariance in [&isotropic as &dyn StationaryCovariance, &diagonal] {
        let spectrum = periodic_spectrum(covariance, grid).1.eigenvalues_m2;
        for (kx, ky) in (0..10).flat_map(|kx| (0..18).map(move |ky| (kx, ky))) {
            let exchanged = if ky < 10 { ky * 18 + kx } else { (18 - ky) * 18 + (18 - kx) % 18 };
            assert_eq!(spectrum[kx * 18 + ky], spectrum[exchanged], "{kx} {ky}");
        }
    }
    // The two modes of a pair belong to different classes, that of the lower number first.
    for method in [general::dense_modes, general::iterated_modes] {
        let found = method(&isotropic, grid, 60).unwrap();
        let values = &found.eigenvalues_m2;
        let pairs: Vec<_> = (1..60).filter(|&j| values[j - 1] - values[j] < 1e-12 * values[0]).collect();
        assert!(pairs.len() > 12, "{pairs:?}");
        assert!(pairs.iter().all(|&j| found.places[j - 1] < found.places[j]));
    }
}

#[test]
fn values_that_rounding_tells_apart_are_sorted_by_place() {
    let mut modes = [(1.0, 1), (1.0 + 1e-15, 2), (2.0, 4), (1.0 - 1e-15, 0), (0.5, 3)];
    sort_falling(&mut modes);
    assert_eq!(modes.map(|mode| mode.1), [4, 0, 1, 2, 3]);
}

#[test]
fn both_general_methods_span_the_same_field() {
    // When the truncation separates distinct eigenvalues, the covariance does not depend on rotations of equal modes.
    let grid = Grid::new(18, 18, 1.0, 1.0).unwrap();
    let covariance = unit(CorrelationModel::Matern { nu: 0.8 }, 5.0, 5.0);
    let all = dense(&covariance, grid);
    let count = (25..45).find(|&m| all[m - 1] - all[m] > 1e-4 * all[0]).unwrap();
    let field = |found: ClassModes| {
        let vectors = functions(&found);
        let weighted = Array2::from_shape_fn(vectors.dim(), |(j, i)| found.eigenvalues_m2[j] * vectors[[j, i]]);
        vectors.t().dot(&weighted)
    };
    let a = field(general::dense_modes(&covariance, grid, count).unwrap());
    let b = field(general::iterated_modes(&covariance, grid, count).unwrap());
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-6));
}

#[test]
fn the_general_and_the_separable_route_agree_on_a_separable_covariance() {
    let grid = Grid::new(24, 18, 1.0, 1.0).unwrap();
    let covariance = SeparableCovariance(unit(CorrelationModel::Exponential, 6.0, 4.0));
    let general = KarhunenLoeve::new(&covariance, grid, 30, ModesRoute::General).unwrap();
    let separable = KarhunenLoeve::new(&covariance, grid, 30, ModesRoute::Separable).unwrap();
    for (a, b) in general.eigenvalues_m2().iter().zip(separable.eigenvalues_m2()) {
        assert!((a - b).abs() < 1e-10 * separable.eigenvalues_m2()[0]);
    }
    let (a, b) = (general.covariance_with_m2(7, 11), separable.covariance_with_m2(7, 11));
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-7));
    assert_orthonormal(&separable);
}

#[test]
fn the_isotropic_exponential_is_not_the_separable_one() {
    let covariance = unit(CorrelationModel::Exponential, 0.1, 0.1);
    let fraction = |route| modes(&covariance, &[1.0, 1.0], &[48, 48], 101, route).unwrap().captured_variance;
    assert!(fraction(ModesRoute::General) > fraction(ModesRoute::Separable) + 0.02);
}

#[test]
fn all_modes_rebuild_the_covariance_on_the_map_exactly() {
    let grid = Grid::new(9, 8, 1.0, 0.7).unwrap();
    let covariance = Covariance::new(CorrelationModel::SquaredExponential, 2.5, 3.0, 2.0).unwrap();
    for route in [ModesRoute::Separable, ModesRoute::General] {
        let surface = KarhunenLoeve::new(&covariance, grid, grid.points(), route).unwrap();
        assert!((surface.captured_variance() - 1.0).abs() < 1e-12);
        let met = surface.covariance_with_m2(2, 6);
        for ((row, column), value) in met.indexed_iter() {
            let lag = ((column as f64 - 6.0).abs(), 0.7 * (row as f64 - 2.0).abs());
            assert!((value - covariance.value_m2(lag.0, lag.1)).abs() < 1e-11, "{route:?}");
        }
    }
}

#[test]
fn a_map_is_the_sum_of_its_terms_on_every_route() {
    let grid = Grid::new(14, 10, 1.0, 1.0).unwrap();
    let covariance = Covariance::new(CorrelationModel::Exponential, 3.0, 4.0, 5.0).unwrap();
    for route in [ModesRoute::Separable, ModesRoute::General, ModesRoute::Periodic] {
        let surface = KarhunenLoeve::new(&covariance, grid, 30, route).unwrap();
        assert_orthonormal(&surface);
        let xi = random::standard_normal(&mut random::stream(5, "karhunen-loeve", 0), 30);
        let mut sum = Array2::<f64>::zeros(grid.shape());
        let mut variance = Array2::<f64>::zeros(grid.shape());
        let mut with_point = Array2::<f64>::zeros(grid.shape());
        for (j, xi) in xi.iter().enumerate() {
            let mode = surface.mode_per_m(j);
            let value = surface.eigenvalues_m2()[j];
            sum.scaled_add(3.0 * value.sqrt() * xi, &mode);
            variance.scaled_add(9.0 * value, &mode.mapv(|v| v * v));
            with_point.scaled_add(9.0 * value * mode[[3, 4]], &mode);
        }
        let close = |a: &Array2<f64>, b: &Array2<f64>| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close(&sum, surface.generate(&xi).heights_m()), "{route:?}");
        assert!(close(&variance, &surface.pointwise_std_m().mapv(|s| s * s)), "{route:?}");
        assert!(close(&with_point, &surface.covariance_with_m2(3, 4)), "{route:?}");
        assert!(surface.eigenvalues_m2().windows(2).all(|pair| pair[0] >= pair[1]));
    }
}

#[test]
fn the_ensemble_has_the_variance_of_its_modes_within_four_standard_errors() {
    let grid = Grid::new(32, 32, 1.0, 1.0).unwrap();
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 2.0, 6.0).unwrap();
    let surface = KarhunenLoeve::new(&covariance, grid, 40, ModesRoute::Separable).unwrap();
    let count = 2000;
    let powers: Vec<f64> = (0..count)
        .map(|index| {
            let xi = random::standard_normal(&mut random::stream(9, "ensemble", index), 40);
            let map = surface.generate(&xi);
            map.present_m().map(|z| z * z).sum::<f64>() / grid.points() as f64
        })
        .collect();
    let mean = powers.iter().sum::<f64>() / count as f64;
    let spread = powers.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / (count - 1) as f64;
    let wanted = 4.0 * surface.captured_variance();
    assert!((mean - wanted).abs() < 4.0 * (spread / count as f64).sqrt(), "{mean} {wanted}");
}

#[test]
fn one_size_is_an_interval_and_wrong_counts_are_refused() {
    let covariance = unit(CorrelationModel::Exponential, 1.0, 1.0);
    let found = modes(&covariance, &[1.0], &[256], 4, ModesRoute::Separable).unwrap();
    for (value, wanted) in
        found.eigenvalues.iter().zip([0.738_810_809_4, 0.138_003_775_4, 0.045_088_487_3, 0.021_328_931_3])
    {
        assert!((value / wanted - 1.0).abs() < 1e-3);
    }
    assert!(matches!(
        modes(&covariance, &[1.0], &[8, 8], 4, ModesRoute::General),
        Err(GeneratorError::Dimensions { sizes: 1, points: 2 })
    ));
    assert!(matches!(
        modes(&covariance, &[1.0], &[8], 9, ModesRoute::General),
        Err(GeneratorError::Modes { wanted: 9, points: 8 })
    ));
    let ring = modes(&covariance, &[8.0], &[64], 5, ModesRoute::Periodic).unwrap().eigenvalues;
    assert!((ring[1] - ring[2]).abs() < 1e-12 && (ring[3] - ring[4]).abs() < 1e-12, "cosines and sines come in pairs");
}

#[test]
fn modes_do_not_depend_on_the_number_of_threads() {
    let grid = Grid::new(20, 14, 1.0, 1.0).unwrap();
    let covariance = unit(CorrelationModel::SelfAffine { hurst: 0.6 }, 5.0, 4.0);
    for method in [general::dense_modes, general::iterated_modes] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let found = pool.install(|| method(&covariance, grid, 25).unwrap());
            (functions(&found), found.eigenvalues_m2)
        };
        assert!(with(1) == with(3), "results must be bit-identical");
    }
}

#[test]
fn the_captured_slope_variance_equals_that_of_the_covariance_of_the_modes() {
    let grid = Grid::new(14, 11, 1.0, 0.7).unwrap();
    let covariance = unit(CorrelationModel::Exponential, 3.0, 4.0);
    for (route, modes) in [(ModesRoute::General, 20), (ModesRoute::Separable, 20), (ModesRoute::Periodic, 21)] {
        let surface = KarhunenLoeve::new(&covariance, grid, modes, route).unwrap();
        // E(z(x) − z(y))² = C(x, x) + C(y, y) − 2C(x, y) over all neighbours, by another path through the modes.
        let (mut slopes, mut pairs) = ([0.0; 2], [0.0; 2]);
        let std = surface.pointwise_std_m();
        for row in 0..grid.ny() {
            for column in 0..grid.nx() {
                let with = surface.covariance_with_m2(row, column);
                for (axis, other) in [(row, column + 1), (row + 1, column)].into_iter().enumerate() {
                    if let Some(cross) = with.get(other) {
                        slopes[axis] += std[[row, column]].powi(2) + std[other].powi(2) - 2.0 * cross;
                        pairs[axis] += 1.0;
                    }
                }
            }
        }
        let of_modes = slopes[0] / pairs[0] + slopes[1] / pairs[1] / 0.49;
        let whole = 2.0 * (1.0 - (-1.0_f64 / 3.0).exp()) + 2.0 * (1.0 - (-0.7_f64 / 4.0).exp()) / 0.49;
        let found = surface.captured_slope_variance();
        assert!((found - of_modes / whole).abs() < 1e-9, "{route:?}: {found}");
        assert!(found < 0.7 * surface.captured_variance(), "first modes hold less of the slopes than of the variance");
        let all = KarhunenLoeve::new(&covariance, grid, grid.points(), ModesRoute::General).unwrap();
        assert!((all.captured_slope_variance() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_predicted_number_of_periodic_modes_has_the_requested_fraction_of_the_slopes() {
    let grid = Grid::new(48, 40, 1.0, 1.0).unwrap();
    for covariance in
        [unit(CorrelationModel::SquaredExponential, 6.0, 6.0), unit(CorrelationModel::Matern { nu: 1.5 }, 4.0, 9.0)]
    {
        let needed = modes_for_slopes(&covariance, grid, 0.9);
        let fraction = |modes: usize| {
            KarhunenLoeve::new(&covariance, grid, modes, ModesRoute::Periodic).unwrap().captured_slope_variance()
        };
        // Differences of a periodic mode leave out the pair across the edge: about 1/48 of its slope.
        assert!(fraction(needed) > 0.88 && fraction(needed / 2) < 0.9, "{needed}: {}", fraction(needed));
    }
}
