use super::*;
use crate::{RandomSurface, SpectralField};
use asperity_base::correlation::{CorrelationModel, Covariance, Rotated};
use asperity_base::monitor::Silent;
use asperity_base::numeric::{Qr, solve_upper};
use asperity_base::random;

fn xi(surface: &NeighbourhoodSurface, index: u64) -> Vec<f64> {
    random::standard_normal(&mut random::stream(17, "conditional", index), surface.xi_len())
}

fn grid(nx: usize, ny: usize) -> Grid {
    Grid::new(nx, ny, 1.0, 1.0).unwrap()
}

fn covariance(model: CorrelationModel, length_m: f64) -> Covariance {
    Covariance::isotropic(model, 2.0, length_m).unwrap()
}

/// Returns a map of `covariance` with missing points where `missing` is true.
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
    let xi = random::standard_normal(&mut random::stream(18, "truth", index), field.xi_len());
    let mut heights = field.generate(&xi).heights_m().clone();
    heights.indexed_iter_mut().filter(|((row, column), _)| missing(*row, *column)).for_each(|(_, z)| *z = f64::NAN);
    HeightMap::new(grid, heights).unwrap()
}

/// Computes dense kriging: mean and covariance of all points, row by row, given the present heights with noise.
fn dense(
    covariance: &dyn StationaryCovariance,
    measured: &HeightMap,
    mean: f64,
    nugget: f64,
) -> (Vec<f64>, Array2<f64>) {
    let grid = measured.grid();
    let variance = covariance.std_m().powi(2);
    let c = |p: usize, q: usize| {
        let x = ((p % grid.nx()) as f64 - (q % grid.nx()) as f64) * grid.dx_m();
        let y = ((p / grid.nx()) as f64 - (q / grid.nx()) as f64) * grid.dy_m();
        variance * covariance.correlation(x, y)
    };
    let (at, n) = (places(measured), grid.points());
    let entry = |(i, j): (usize, usize)| c(at[i], at[j]) + if i == j { nugget * variance } else { 0.0 };
    let between = Array2::from_shape_fn((at.len(), at.len()), entry);
    let to_all = Array2::from_shape_fn((at.len(), n), |(i, p)| c(at[i], p));
    let misses: ndarray::Array1<f64> = measured.present_m().map(|value| value - mean).collect();
    let Qr { q, r } = Qr::new(between);
    let mut solved = q.t().dot(&to_all);
    solve_upper(r.view(), solved.view_mut());
    let known = to_all.t().dot(&solved);
    let centre = solved.t().dot(&misses);
    ((0..n).map(|p| mean + centre[p]).collect(), Array2::from_shape_fn((n, n), |(p, q)| c(p, q) - known[[p, q]]))
}

/// Checks that mean and covariance of the maps equal dense kriging at the missing points. The maps are z = m + Bξ, so
/// both follow from unit vectors ξ without sampling. On a small map a neighbourhood contains all heights.
fn is_kriging(covariance: &dyn StationaryCovariance, measured: &HeightMap, nugget: f64) {
    let surface = NeighbourhoodSurface::new(covariance, measured, 0.7, nugget, &Silent).unwrap();
    assert!(surface.clipped_variance() < 1e-12);
    let (mean, wanted) = dense(covariance, measured, 0.7, surface.noise());
    let at = places(measured);
    let missing: Vec<usize> = (0..measured.grid().points()).filter(|p| at.binary_search(p).is_err()).collect();
    let close = |map: &HeightMap| {
        let heights: Vec<f64> = map.heights_m().iter().copied().collect();
        missing
            .iter()
            .for_each(|p| assert!((heights[*p] - mean[*p]).abs() < 1e-6, "{p}: {} {}", heights[*p], mean[*p]));
    };
    let zero = vec![0.0; surface.xi_len()];
    close(&surface.generate(&zero));
    let mut met = Array2::<f64>::zeros((missing.len(), missing.len()));
    for j in 0..surface.xi_len() {
        let mut unit = zero.clone();
        unit[j] = 1.0;
        let part: Vec<f64> = surface.generate(&unit).heights_m().iter().zip(&mean).map(|(z, m)| z - m).collect();
        for (a, p) in missing.iter().enumerate() {
            for (b, q) in missing.iter().enumerate() {
                met[[a, b]] += part[*p] * part[*q];
            }
        }
    }
    for (a, p) in missing.iter().enumerate() {
        for (b, q) in missing.iter().enumerate() {
            assert!((met[[a, b]] - wanted[[*p, *q]]).abs() < 1e-5, "{p} {q}: {} {}", met[[a, b]], wanted[[*p, *q]]);
        }
    }
}

#[test]
fn mean_and_covariance_equal_dense_kriging() {
    let some = |row: usize, column: usize| (3 * row + 5 * column) % 7 < 5;
    let exponential = covariance(CorrelationModel::Exponential, 2.5);
    is_kriging(&exponential, &measured(&exponential, grid(9, 7), some), 0.0);
    let smooth =
        Rotated::new(Covariance::new(CorrelationModel::Matern { nu: 1.5 }, 2.0, 3.0, 1.2).unwrap(), 0.5).unwrap();
    is_kriging(&smooth, &measured(&smooth, grid(8, 7), some), 0.0);
    is_kriging(&smooth, &measured(&smooth, grid(8, 7), some), 0.05);
}

#[test]
fn measured_heights_are_kept_to_the_bit() {
    let rough = covariance(CorrelationModel::Matern { nu: 1.2 }, 6.0);
    let map = measured(&rough, grid(60, 50), |row, column| {
        (row as f64 - 25.0).hypot(column as f64 - 30.0) < 11.0 || (7 * row + 3 * column) % 11 == 0
    });
    let surface = NeighbourhoodSurface::new(&rough, &map, 0.0, 0.0, &Silent).unwrap();
    let drawn = surface.generate(&xi(&surface, 0));
    assert_eq!(drawn.missing_points(), 0);
    for (before, after) in map.heights_m().iter().zip(drawn.heights_m()).filter(|(before, _)| !before.is_nan()) {
        assert_eq!(before.to_bits(), after.to_bits());
    }
}

#[test]
fn measured_heights_are_kept_and_the_rest_has_their_distribution() {
    let rough = covariance(CorrelationModel::Exponential, 2.0);
    let marginal = Marginal::lognormal(0.0, 0.6, -1.0).unwrap();
    let gaussian = measured(&Standardised(&rough), grid(48, 40), |row, column| row > 8 || column > 8);
    let heights = gaussian.heights_m().mapv(|g| marginal.translate(g));
    let map = HeightMap::new(gaussian.grid(), heights).unwrap();
    let surface = NeighbourhoodSurface::with_marginal(&rough, &map, &marginal, 0.0, &Silent).unwrap();
    // The scores equal the Gaussian field.
    let found = scores(&marginal, &map).unwrap();
    assert!(found.iter().zip(gaussian.present_m()).all(|(a, b)| (a - b).abs() < 1e-12));
    let (count, mut far) = (500, Vec::new());
    for index in 0..count {
        let drawn = surface.generate(&xi(&surface, index));
        assert!(map.heights_m().iter().zip(drawn.heights_m()).all(|(a, b)| a.is_nan() || a == b));
        far.push(drawn.heights_m()[[38, 45]]);
    }
    far.sort_by(f64::total_cmp);
    // Kolmogorov's distance; one sample in a thousand exceeds 1.95/√n.
    let distance = far
        .iter()
        .enumerate()
        .map(|(i, z)| (marginal.cdf(*z) - (i as f64 + 0.5) / count as f64).abs() + 0.5 / count as f64)
        .fold(0.0, f64::max);
    assert!(distance < 1.95 / (count as f64).sqrt(), "{distance}");
    // A height below the shift of the distribution is impossible.
    let mut heights = map.heights_m().clone();
    heights[[2, 3]] = -1.5;
    let error = NeighbourhoodSurface::with_marginal(
        &rough,
        &HeightMap::new(map.grid(), heights).unwrap(),
        &marginal,
        0.0,
        &Silent,
    );
    assert!(matches!(error, Err(ConditionalError::OutsideSupport { row: 2, column: 3, .. })));
}

#[test]
fn an_empirical_distribution_reproduces_its_own_heights() {
    let rough = covariance(CorrelationModel::Exponential, 4.0);
    let map = measured(&rough, grid(30, 30), |row, column| row.abs_diff(15) < 5 && column.abs_diff(15) < 5);
    let marginal = Marginal::empirical(map.present_m().collect()).unwrap();
    let surface = NeighbourhoodSurface::with_marginal(&rough, &map, &marginal, 0.0, &Silent).unwrap();
    let present: Vec<f64> = map.present_m().collect();
    for (score, height) in scores(&marginal, &map).unwrap().iter().zip(&present) {
        assert!((marginal.translate(*score) - height).abs() < 1e-9);
    }
    let drawn = surface.generate(&xi(&surface, 0));
    let (low, high) = present.iter().fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(*z), h.max(*z)));
    assert!(drawn.present_m().all(|z| (low..=high).contains(&z)));
}

#[test]
#[ignore = "slow"]
fn a_map_is_extended_beyond_its_edges_and_its_voids_are_filled() {
    let rough = covariance(CorrelationModel::SelfAffine { hurst: 0.7 }, 5.0);
    let map = measured(&rough, grid(40, 30), |row, column| row < 6 && column > 30);
    let wide = surrounded(&map, 12, 7).unwrap();
    assert_eq!(wide.grid().shape(), (44, 64));
    assert_eq!(wide.missing_points(), 44 * 64 - map.present_m().count());
    assert_eq!(wide.heights_m()[[7, 12]], map.heights_m()[[0, 0]]);
    let surface = NeighbourhoodSurface::new(&rough, &wide, 0.0, 0.0, &Silent).unwrap();
    let drawn = surface.generate(&xi(&surface, 3));
    assert_eq!(drawn.missing_points(), 0);
    // No seam: over true maps and draws, steps across the edge have the mean square of other steps.
    let wanted = 2.0 * 4.0 * (1.0 - rough.correlation(1.0, 0.0));
    let count = 30;
    let means: Vec<f64> = (0..count)
        .map(|index| {
            let wide = surrounded(&truth(&rough, grid(24, 30), index, |_, _| false), 4, 0).unwrap();
            let surface = NeighbourhoodSurface::new(&rough, &wide, 0.0, 0.0, &Silent).unwrap();
            let drawn = surface.generate(&xi(&surface, index));
            let z = drawn.heights_m();
            (0..30).map(|row| (z[[row, 4]] - z[[row, 3]]).powi(2)).sum::<f64>() / 30.0
        })
        .collect();
    let mean = means.iter().sum::<f64>() / count as f64;
    let spread = means.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1) as f64;
    assert!((mean - wanted).abs() < 4.0 * (spread / count as f64).sqrt(), "{mean} {wanted}");
}
