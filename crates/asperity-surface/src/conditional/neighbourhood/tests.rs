use super::*;
use asperity_base::correlation::{CorrelationModel, Covariance, Rotated};
use asperity_base::numeric::{Qr, solve_upper};
use asperity_base::random;
use asperity_testing::AlwaysCancelled;

fn grid(nx: usize, ny: usize) -> Grid {
    Grid::new(nx, ny, 1.0, 1.0).unwrap()
}

fn xi(len: usize, stage: &str, index: u64) -> Vec<f64> {
    random::standard_normal(&mut random::stream(21, stage, index), len)
}

/// Returns a map of unit variance with missing points where `missing` is true.
fn measured(covariance: &dyn StationaryCovariance, grid: Grid, missing: impl Fn(usize, usize) -> bool) -> HeightMap {
    let field = SpectralField::free(covariance, grid).unwrap();
    let mut heights = field.generate(&xi(field.xi_len(), "truth", 0)).heights_m().clone();
    heights.indexed_iter_mut().filter(|((row, column), _)| missing(*row, *column)).for_each(|(_, z)| *z = f64::NAN);
    HeightMap::new(grid, heights).unwrap()
}

/// Accuracy of the weights of a surface at one missing point, over the variance.
struct Weighed {
    /// Error variance of conditioning on all heights, and of the surface.
    exact: f64,
    met: f64,
    /// Variance of the maps over the true maps on which they are conditioned.
    variance: f64,
}

/// Returns the correlations between the measured places, with the noise of the heights.
fn between(surface: &NeighbourhoodSurface) -> Array2<f64> {
    let places = &surface.places;
    let noise = |i: usize, j: usize| if i == j { surface.noise } else { 0.0 };
    let entry = |(i, j): (usize, usize)| rho(surface, places[i], places[j]) + noise(i, j);
    Array2::from_shape_fn((places.len(), places.len()), entry)
}

fn rho(surface: &NeighbourhoodSurface, p: usize, q: usize) -> f64 {
    let nx = surface.grid.nx();
    surface.lags.at((p % nx) as isize - (q % nx) as isize, (p / nx) as isize - (q / nx) as isize)
}

/// Returns the missing places, their correlations with all heights, and the kriging weights by dense algebra.
fn dense(surface: &NeighbourhoodSurface) -> (Vec<usize>, Array2<f64>, Array2<f64>) {
    let places = &surface.places;
    let missing: Vec<usize> = (0..surface.grid.points()).filter(|p| places.binary_search(p).is_err()).collect();
    let shape = (places.len(), missing.len());
    let to_missing = Array2::from_shape_fn(shape, |(i, j)| rho(surface, places[i], missing[j]));
    let Qr { q, r } = Qr::new(between(surface));
    let mut best = q.t().dot(&to_missing);
    solve_upper(r.view(), best.view_mut());
    (missing, to_missing, best)
}

/// Computes the accuracy at every missing point by dense algebra. Unit differences give the weights of the surface; the
/// system of all heights gives the best weights.
fn weighed(surface: &NeighbourhoodSurface) -> Vec<Weighed> {
    let (nx, n) = (surface.grid.nx(), surface.places.len());
    let units: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| if i == j { 1.0 } else { 0.0 }).collect()).collect();
    let mut maps = vec![Array2::zeros(surface.grid.shape()); n];
    surface.correct(&units, &mut maps, &Silent).unwrap();
    let (missing, to_missing, best) = dense(surface);
    let weights = Array2::from_shape_fn((n, missing.len()), |(i, j)| maps[i][[missing[j] / nx, missing[j] % nx]]);
    let image = between(surface).dot(&weights);
    let of = |j: usize| {
        let (mut exact, mut met, mut variance) = (1.0, 1.0, 1.0);
        for i in 0..n {
            exact -= best[[i, j]] * to_missing[[i, j]];
            met += weights[[i, j]] * (image[[i, j]] - 2.0 * to_missing[[i, j]]);
            variance += 2.0 * weights[[i, j]] * (image[[i, j]] - to_missing[[i, j]]);
        }
        Weighed { exact, met, variance }
    };
    (0..missing.len()).map(of).collect()
}

/// Returns a surface with the limited work per missing point of large maps; on small maps neighbourhoods contain most
/// heights.
fn thrifty(covariance: &dyn StationaryCovariance, map: &HeightMap) -> NeighbourhoodSurface {
    let surface = NeighbourhoodSurface::new(covariance, map, 0.0, 0.0, &Silent).unwrap();
    let pyramid = Pyramid::new(Metric::of(&surface.lags, surface.grid), surface.grid, surface.places.clone());
    let groups = groups(&pyramid, surface.grid, groups::LEAST_WORK_PER_POINT, &Silent).unwrap();
    NeighbourhoodSurface { groups, ..surface }
}

fn isotropic(model: CorrelationModel, length: f64) -> Covariance {
    Covariance::isotropic(model, 1.0, length).unwrap()
}

fn lay(model: CorrelationModel) -> Rotated<Covariance> {
    Rotated::new(Covariance::new(model, 1.0, 3.0, 30.0).unwrap(), 0.6).unwrap()
}

fn block(row: usize, column: usize) -> bool {
    (12..28).contains(&row) && (11..27).contains(&column)
}

/// Returns true for one point in five, at random.
fn salt(row: usize, column: usize) -> bool {
    xi(1, "salt", (1000 * row + column) as u64)[0] > 0.84
}

#[test]
#[ignore = "slow"]
fn neighbourhoods_lose_less_than_one_percent_of_accuracy() {
    let rough: [(&str, Box<dyn StationaryCovariance>); 4] = [
        ("exponential", Box::new(isotropic(CorrelationModel::Exponential, 12.0))),
        ("self-affine", Box::new(isotropic(CorrelationModel::SelfAffine { hurst: 0.8 }, 12.0))),
        ("Matérn", Box::new(isotropic(CorrelationModel::Matern { nu: 1.5 }, 6.0))),
        ("exponential with a lay", Box::new(lay(CorrelationModel::Exponential))),
    ];
    for (name, covariance) in rough {
        for missing in [block, salt] {
            let map = measured(&*covariance, grid(40, 40), missing);
            let surface = thrifty(&*covariance, &map);
            for Weighed { exact, met, variance } in weighed(&surface) {
                // The error of the mean is the root of this ratio times its standard deviation.
                let fraction = met / exact - 1.0;
                assert!((-1e-6..0.01).contains(&fraction), "{name}: {met:e} {exact:e}");
                assert!((variance - 1.0).abs() < 1e-6, "{name}: {variance}");
            }
        }
    }
}

#[test]
#[ignore = "slow"]
fn smooth_voids_have_small_errors_and_keep_their_variance() {
    // The least noise limits the extrapolation of a smooth field, so errors are compared with the variance.
    for length in [2.0, 4.0, 8.0] {
        let smooth = isotropic(CorrelationModel::SquaredExponential, length);
        for missing in [block, salt] {
            let map = measured(&smooth, grid(40, 40), missing);
            let surface = thrifty(&smooth, &map);
            assert_eq!(surface.noise(), LEAST_NOISE);
            let weighed = weighed(&surface);
            let largest = |value: &dyn Fn(&Weighed) -> f64| weighed.iter().map(value).fold(0.0_f64, f64::max);
            let (excess, off) = (largest(&|w| w.met - w.exact), largest(&|w| (w.variance - 1.0).abs()));
            // Largest loss by thinning: in a void four lengths wide, see docs/validation/filling.md.
            assert!(excess < if length > 6.0 { 1e-3 } else { 0.12 }, "{length}: {excess:e}");
            assert!(off < 1e-3, "{length}: {off:e}");
        }
    }
}

#[test]
fn weights_of_neighbourhoods_are_never_better_than_those_of_all_heights() {
    if std::env::var_os("ASPERITY_TABLES").is_none() {
        println!("skipped: ASPERITY_TABLES is not set");
        return;
    }
    let straight = |model| Covariance::new(model, 1.0, 3.0, 30.0).unwrap();
    let cases: [(&str, Box<dyn StationaryCovariance>); 10] = [
        ("exponential, 5", Box::new(isotropic(CorrelationModel::Exponential, 5.0))),
        ("exponential, 40", Box::new(isotropic(CorrelationModel::Exponential, 40.0))),
        ("self-affine H = 0.8, 12", Box::new(isotropic(CorrelationModel::SelfAffine { hurst: 0.8 }, 12.0))),
        ("Matérn 1.5, 6", Box::new(isotropic(CorrelationModel::Matern { nu: 1.5 }, 6.0))),
        ("squared exponential, 3", Box::new(isotropic(CorrelationModel::SquaredExponential, 3.0))),
        ("squared exponential, 8", Box::new(isotropic(CorrelationModel::SquaredExponential, 8.0))),
        ("exponential, lay 3 × 30", Box::new(straight(CorrelationModel::Exponential))),
        ("exponential, lay 3 × 30 at 34°", Box::new(lay(CorrelationModel::Exponential))),
        ("Matérn 1.5, lay 3 × 30 at 34°", Box::new(lay(CorrelationModel::Matern { nu: 1.5 }))),
        ("squared exponential, lay 3 × 30", Box::new(straight(CorrelationModel::SquaredExponential))),
    ];
    println!(
        "| correlation, lengths in points | missing | heights | exact error variance | excess, worst | over exact | mean over exact | variance kept |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, covariance) in cases {
        let large = |row: usize, column: usize| (12..60).contains(&row) && (12..60).contains(&column);
        for (what, side, missing) in
            [("16 × 16", 40, block as fn(usize, usize) -> bool), ("one in five", 40, salt), ("48 × 48", 72, large)]
        {
            let map = measured(&*covariance, grid(side, side), missing);
            let surface = thrifty(&*covariance, &map);
            let found = weighed(&surface);
            let fold = |value: &dyn Fn(&Weighed) -> f64| found.iter().map(value).fold(f64::NEG_INFINITY, f64::max);
            let fraction = |w: &Weighed| (w.met - w.exact) / (w.exact + 1e-8);
            assert!(found.iter().all(|w| w.met > w.exact - 1e-6), "{name}, {what}");
            assert!(found.iter().all(|w| (w.variance - 1.0).abs() < 1e-3), "{name}, {what}");
            println!(
                "| {name} | {what} | {} | {:.0e} … {:.0e} | {:.0e} | {:.0e} | {:.0e} | {:.4} |",
                surface.groups.iter().map(|group| group.heights.len()).max().unwrap_or(0),
                -fold(&|w| -w.exact),
                fold(&|w| w.exact),
                fold(&|w| w.met - w.exact),
                fold(&fraction),
                found.iter().map(fraction).sum::<f64>() / found.len() as f64,
                1.0 + fold(&|w| (w.variance - 1.0).abs()),
            );
        }
    }
}

#[test]
#[ignore = "slow"]
fn the_mean_equals_that_of_all_heights() {
    let rough = isotropic(CorrelationModel::Matern { nu: 1.5 }, 5.0);
    for nugget in [0.0, 0.02] {
        let map = measured(&rough, grid(44, 40), block);
        let surface = NeighbourhoodSurface::new(&rough, &map, 0.3, nugget, &Silent).unwrap();
        let met = surface.generate(&vec![0.0; surface.xi_len()]);
        let (missing, to_missing, best) = dense(&surface);
        for (j, place) in missing.into_iter().enumerate() {
            let weight = |i: usize| best[[i, j]];
            let wanted: f64 = 0.3 + surface.values.iter().enumerate().map(|(i, value)| weight(i) * value).sum::<f64>();
            let variance: f64 = 1.0 - (0..surface.values.len()).map(|i| weight(i) * to_missing[[i, j]]).sum::<f64>();
            let off = (met.heights_m()[[place / 44, place % 44]] - wanted) / variance.sqrt();
            assert!(off.abs() < 0.02, "{nugget} {place}: {off}");
        }
    }
}

/// Returns the mean and standard error of values of independent maps.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt())
}

#[test]
#[ignore = "slow"]
fn voids_of_a_smooth_map_are_as_steep_as_the_map_inside_and_across_their_edges() {
    let smooth = isotropic(CorrelationModel::SquaredExponential, 8.0);
    let void = |row: usize, column: usize| row % 60 > 22 && column % 60 > 22;
    let wanted = 2.0 * (1.0 - smooth.correlation(1.0, 0.0));
    let (mut inside, mut across) = (Vec::new(), Vec::new());
    let field = SpectralField::free(&smooth, grid(200, 200)).unwrap();
    for index in 0..20 {
        let mut heights = field.generate(&xi(field.xi_len(), "truth", index)).heights_m().clone();
        heights.indexed_iter_mut().filter(|((r, c), _)| void(*r, *c)).for_each(|(_, z)| *z = f64::NAN);
        let map = HeightMap::new(field.grid(), heights).unwrap();
        let surface = NeighbourhoodSurface::new(&smooth, &map, 0.0, 0.0, &Silent).unwrap();
        let drawn = surface.generate(&xi(surface.xi_len(), "fill", index));
        let mut sums = [(0.0, 0.0); 3];
        for (row, heights) in drawn.heights_m().outer_iter().enumerate() {
            for column in 0..199 {
                let sum = &mut sums[usize::from(void(row, column)) + usize::from(void(row, column + 1))];
                *sum = (sum.0 + (heights[column + 1] - heights[column]).powi(2), sum.1 + 1.0);
            }
        }
        across.push(sums[1].0 / sums[1].1 / wanted);
        inside.push(sums[2].0 / sums[2].1 / wanted);
    }
    for (what, ratios) in [("inside", inside), ("across", across)] {
        let (mean, error) = mean_and_error(&ratios);
        assert!((mean - 1.0).abs() < 4.0 * error && error < 0.06, "{what}: {mean} ± {error}");
        assert!((mean.sqrt() - 1.0).abs() < 0.03 || what == "across", "{what}: {mean} ± {error}");
    }
}

#[test]
#[ignore = "slow"]
fn the_parts_of_a_large_void_show_no_seam() {
    // Second differences would reveal a seam first, because on a smooth map they are small.
    let smooth = isotropic(CorrelationModel::SquaredExponential, 8.0);
    let wanted = 6.0 - 8.0 * smooth.correlation(1.0, 0.0) + 2.0 * smooth.correlation(2.0, 0.0);
    let size = grid(190, 190);
    let void = |row: usize, column: usize| (25..165).contains(&row) && (25..165).contains(&column);
    let ratios: Vec<f64> = (0..12)
        .map(|index| {
            let field = SpectralField::free(&smooth, size).unwrap();
            let mut heights = field.generate(&xi(field.xi_len(), "truth", index)).heights_m().clone();
            heights.indexed_iter_mut().filter(|((r, c), _)| void(*r, *c)).for_each(|(_, z)| *z = f64::NAN);
            let map = HeightMap::new(size, heights).unwrap();
            let surface = NeighbourhoodSurface::new(&smooth, &map, 0.0, 0.0, &Silent).unwrap();
            assert!(surface.groups.len() > 3);
            let drawn = surface.generate(&xi(surface.xi_len(), "fill", index));
            let z = drawn.heights_m();
            let fading = surface.groups.iter().flat_map(|group| group.targets.iter().zip(&group.weights));
            let fading =
                fading.filter(|(_, fraction)| (0.01..0.99).contains(*fraction)).map(|(place, _)| *place as usize);
            let (mut sum, mut count) = (0.0, 0.0);
            for (row, column) in fading.map(|place| (place / 190, place % 190)) {
                let along_x = z[[row, column - 1]] - 2.0 * z[[row, column]] + z[[row, column + 1]];
                let along_y = z[[row - 1, column]] - 2.0 * z[[row, column]] + z[[row + 1, column]];
                sum += along_x * along_x + along_y * along_y;
                count += 2.0;
            }
            sum / count / wanted
        })
        .collect();
    let (mean, error) = mean_and_error(&ratios);
    assert!((mean - 1.0).abs() < 4.0 * error && error < 0.05, "{mean} ± {error}");
}

#[test]
#[ignore = "slow"]
fn weights_of_the_groups_of_every_missing_point_add_up_to_one() {
    let rough = isotropic(CorrelationModel::Exponential, 5.0);
    let voids: [fn(usize, usize) -> bool; 4] = [
        |row, column| row > 0 || column > 0,
        |row, column| salt(row, column) || (20..110).contains(&row) && column > 30,
        |row, column| row < 20 || column < 20 || row > 100 || column > 100,
        |row, column| (row / 2 + column / 3) % 2 == 0,
    ];
    for missing in voids {
        let map = measured(&rough, grid(130, 120), missing);
        let surface = NeighbourhoodSurface::new(&rough, &map, 0.0, 0.0, &Silent).unwrap();
        let mut sums = Array2::<f64>::zeros((120, 130));
        for group in &surface.groups {
            assert!(group.heights.len() <= 2000 && !group.heights.is_empty() || group.targets.len() > 24);
            for (place, fraction) in group.targets.iter().zip(&group.weights) {
                sums[[*place as usize / 130, *place as usize % 130]] += fraction;
            }
        }
        for ((row, column), sum) in sums.indexed_iter() {
            assert!((sum - f64::from(u8::from(missing(row, column)))).abs() < 1e-12, "{row} {column}: {sum}");
        }
        let drawn = surface.generate(&xi(surface.xi_len(), "fill", 0));
        assert_eq!(drawn.missing_points(), 0);
    }
}

#[test]
fn heights_rougher_than_their_correlation_cause_no_oscillations() {
    let rough = isotropic(CorrelationModel::Exponential, 8.0);
    let smooth = isotropic(CorrelationModel::SquaredExponential, 8.0);
    let map = measured(&rough, grid(80, 80), |row, column| block(row, column) || block(80 - row, 80 - column));
    let surface = NeighbourhoodSurface::new(&smooth, &map, 0.0, 0.0, &Silent).unwrap();
    assert!(surface.noise() >= 1e-3, "{:e}", surface.noise());
    let drawn = surface.generate(&xi(surface.xi_len(), "fill", 0));
    let largest = |map: &HeightMap| map.present_m().fold(0.0_f64, |m, z| m.max(z.abs()));
    assert!(largest(&drawn) < 1.3 * largest(&map), "{}", largest(&drawn));
    // The correct correlation explains the heights without noise.
    let surface = NeighbourhoodSurface::new(&rough, &map, 0.0, 0.0, &Silent).unwrap();
    assert_eq!(surface.noise(), LEAST_NOISE);
}

#[test]
fn a_lay_stretches_distances_along_it() {
    let map = measured(&lay(CorrelationModel::Exponential), grid(128, 128), block);
    let surface = NeighbourhoodSurface::new(&lay(CorrelationModel::Exponential), &map, 0.0, 0.0, &Silent).unwrap();
    let metric = Metric::of(&surface.lags, surface.grid);
    assert!((metric.elongation() / 10.0 - 1.0).abs() < 0.25, "{}", metric.elongation());
    // The long axis is y turned by 0.6 rad.
    let length = |[u, v]: [f64; 2]| u.hypot(v);
    let distances: Vec<f64> =
        [0.6, -0.6].iter().map(|turn: &f64| length(metric.frame(-20.0 * turn.sin(), 20.0 * turn.cos()))).collect();
    let least = distances[0].min(distances[1]);
    assert!(least < 4.0 && distances[0].max(distances[1]) > 12.0, "{distances:?}");
}

#[test]
#[ignore = "slow"]
fn maps_are_the_same_alone_together_and_with_any_number_of_threads() {
    let rough = isotropic(CorrelationModel::Matern { nu: 1.5 }, 4.0);
    let map = measured(&rough, grid(70, 60), |row, column| block(row, column) || salt(row, column) || column > 50);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let surface = NeighbourhoodSurface::new(&rough, &map, 0.0, 1e-3, &Silent).unwrap();
            let xis: Vec<Vec<f64>> = (0..3).map(|i| xi(surface.xi_len(), "fill", i)).collect();
            let alone = surface.generate(&xis[2]);
            let together = surface.draw(xis, &Silent).unwrap();
            assert!(alone == together[2], "results must be bit-identical");
            together
        })
    };
    let maps = with(1);
    assert!(maps == with(3), "results must be bit-identical");
    for (before, after) in map.heights_m().iter().zip(maps[0].heights_m()) {
        assert!(before.is_nan() || before.to_bits() == after.to_bits());
    }
}

#[test]
fn cancellation_stops_all_computations() {
    let rough = isotropic(CorrelationModel::Exponential, 4.0);
    let map = measured(&rough, grid(40, 40), block);
    let error = NeighbourhoodSurface::new(&rough, &map, 0.0, 0.0, &AlwaysCancelled).unwrap_err();
    assert!(matches!(error, ConditionalError::Cancelled(_)));
    let surface = NeighbourhoodSurface::new(&rough, &map, 0.0, 0.0, &Silent).unwrap();
    assert!(surface.draw([xi(surface.xi_len(), "fill", 0)], &AlwaysCancelled).is_err());
    assert!(matches!(
        NeighbourhoodSurface::new(&rough, &map, 0.0, -1.0, &Silent),
        Err(ConditionalError::Parameter { parameter: "nugget", .. })
    ));
}
