use super::*;
use crate::areal::parameters;
use crate::level::remove_form;
use crate::{RandomSurface, SpectralField, Translated};
use asperity_base::correlation::{Autocorrelation, CorrelationModel, Covariance};
use asperity_base::distribution::Marginal;
use asperity_base::map::Grid;
use asperity_base::random;
use ndarray::{Array2, s};
use rand::RngExt;

/// Number of points per correlation length.
const POINTS: usize = 4;

fn covariance(model: CorrelationModel) -> Covariance {
    Covariance::new(model, 1.0, POINTS as f64, POINTS as f64).unwrap()
}

/// Returns maps of `lengths` correlation lengths a side, cut from a periodic field ten lengths wider.
fn maps(model: CorrelationModel, marginal: &Marginal, lengths: usize, count: u64) -> impl Iterator<Item = HeightMap> {
    let (side, domain) = (lengths * POINTS, (lengths + 10) * POINTS);
    let field = SpectralField::periodic(&covariance(model), Grid::new(domain, domain, 1.0, 1.0).unwrap());
    let field = Translated::new(field, marginal.standardised(0.0, 1.0).unwrap()).unwrap();
    (0..count).map(move |index| {
        let xi = random::standard_normal(&mut random::stream(41, "maps", index), field.xi_len());
        let heights = field.generate(&xi).heights_m().slice(s![..side, ..side]).to_owned();
        HeightMap::new(Grid::new(side, side, 1.0, 1.0).unwrap(), heights).unwrap()
    })
}

fn normal() -> Marginal {
    Marginal::normal(0.0, 1.0).unwrap()
}

fn values(map: &HeightMap) -> Values {
    Values::new(&parameters(map).unwrap(), &Autocorrelation::estimate(map).unwrap())
}

/// Returns estimates with the least number of bootstrap draws.
fn estimates(map: &HeightMap) -> Estimates {
    Uncertainty { resamples: 2, ..Uncertainty::default() }.of(map, &values(map)).unwrap()
}

/// Returns the values that take little time.
fn quick_values(map: &HeightMap) -> Values {
    let moments = Moments::from_values(map.heights_m().iter().copied());
    let correlation = Autocorrelation::estimate(map).unwrap();
    Values {
        sa_m: 0.8 * moments.std,
        sq_m: moments.std,
        ssk: moments.skewness,
        sku: moments.excess_kurtosis + 3.0,
        sdq: None,
        sal_m: None,
        sk_m: 1.0,
        spk_m: 1.0,
        svk_m: 1.0,
        correlation_length_x_m: correlation.correlation_length_m(Axis::X),
        correlation_length_y_m: correlation.correlation_length_m(Axis::Y),
    }
}

fn with_holes(map: &HeightMap, fraction: f64, index: u64) -> HeightMap {
    let mut holes = random::stream(42, "holes", index);
    let punch = |z: &f64| if holes.random::<f64>() < fraction { f64::NAN } else { *z };
    HeightMap::new(map.grid(), map.heights_m().map(punch)).unwrap()
}

/// Returns the coverage of the 95 % intervals of Sq, Ssk and the length along x.
fn covered(maps: impl Iterator<Item = HeightMap>, ssk: f64, length_m: f64) -> [f64; 3] {
    let (mut covered, mut all) = ([0.0; 3], 0.0);
    for map in maps {
        let e = Uncertainty { resamples: 2, ..Uncertainty::default() }.of(&map, &quick_values(&map)).unwrap();
        let truths = [(e.sq_m, 1.0), (e.ssk, ssk), (e.correlation_length_x_m, length_m)];
        for (covered, (estimate, truth)) in covered.iter_mut().zip(truths) {
            *covered += f64::from(u8::from(estimate.unwrap().interval.contains(truth)));
        }
        all += 1.0;
    }
    covered.map(|covered| covered / all)
}

/// Maps of a count of coverage; `interval_coverage` of the validation draws a thousand.
const MAPS: u64 = 60;
/// Of 60 intervals at 95 % fewer than 50 cover with a probability of 2e-4 (binomial).
const LEAST: f64 = 50.0;

/// Checks the coverage by [`MAPS`] intervals. Not all of them cover, or they would be too wide.
fn assert_covered(name: &str, fractions: &[f64]) {
    let covered: Vec<f64> = fractions.iter().map(|fraction| (MAPS as f64 * fraction).round()).collect();
    assert!(covered.iter().all(|covered| *covered >= LEAST), "{name}: {covered:?} of {MAPS} intervals cover");
    assert!(covered.iter().any(|covered| *covered < MAPS as f64), "{name}: all intervals cover");
}

#[test]
#[ignore = "slow"]
fn intervals_of_normal_surfaces_have_95_percent_coverage() {
    for model in [CorrelationModel::SquaredExponential, CorrelationModel::Exponential] {
        assert_covered(model.name(), &covered(maps(model, &normal(), 30, MAPS), 0.0, POINTS as f64));
    }
}

#[test]
#[ignore = "slow"]
fn intervals_of_skewed_surfaces_with_missing_heights_have_95_percent_coverage() {
    let marginal = Marginal::beta(2.1, 5.0, 0.0, 1.0).unwrap();
    let translation = asperity_base::distribution::translation::Translation::new(&marginal).unwrap();
    let model = CorrelationModel::Exponential;
    // The length at which the translated correlation falls to 1/e.
    let length_m = POINTS as f64 * -translation.normal_correlation((-1.0_f64).exp()).unwrap().ln();
    let holed = maps(model, &marginal, 30, MAPS).enumerate().map(|(index, map)| with_holes(&map, 0.2, index as u64));
    assert_covered("beta", &covered(holed, marginal.skewness(), length_m));
}

#[test]
#[ignore = "slow"]
fn intervals_have_95_percent_coverage_after_removing_a_plane() {
    let uncertainty =
        Uncertainty { resamples: 2, removed_terms: removed_terms(Level::Plane), ..Uncertainty::default() };
    let (mut covered, mut sum) = ([0.0; 2], 0.0);
    for map in maps(CorrelationModel::Exponential, &normal(), 30, MAPS) {
        let map = remove_form(&map, Level::Plane).unwrap().map;
        let e = uncertainty.of(&map, &quick_values(&map)).unwrap();
        let (sq, length) = (e.sq_m.unwrap(), e.correlation_length_y_m.unwrap());
        covered[0] += f64::from(u8::from(sq.interval.contains(1.0)));
        covered[1] += f64::from(u8::from(length.interval.contains(POINTS as f64)));
        sum += sq.surface * sq.surface - sq.value * sq.value;
    }
    assert_covered("plane", &covered.map(|covered| covered / MAPS as f64));
    // A plane removes three times the variance of the mean, 2π/30² minus 8 % for the edges; its relative error on one
    // map is a third.
    let wanted = 3.0 * 0.92 * std::f64::consts::TAU / 900.0;
    assert!((sum / MAPS as f64 / wanted - 1.0).abs() < 0.15, "{} for {wanted}", sum / MAPS as f64);
}

#[test]
#[ignore = "slow"]
fn limits_of_the_correlation_cover_it_at_short_and_long_lags() {
    let lags = [0, 1, 4, 12, 40];
    let uncertainty = Uncertainty::default();
    let mut covered = [0; 5];
    for map in maps(CorrelationModel::Exponential, &normal(), 30, MAPS) {
        let turned = HeightMap::new(map.grid(), map.heights_m().t().to_owned()).unwrap();
        let [x, none] = uncertainty.correlation(&map, &quick_values(&map), [&lags, &[]]).unwrap();
        assert!(none.is_empty());
        let [_, y] = uncertainty.correlation(&turned, &quick_values(&turned), [&[], &lags[..2]]).unwrap();
        for k in 0..5 {
            let (interval, truth) = (x[k].unwrap(), (-(lags[k] as f64) / POINTS as f64).exp());
            assert!(interval.low >= -1.0 && interval.high <= 1.0);
            covered[k] += usize::from(interval.contains(truth));
        }
        let (x, y) = (x[1].unwrap(), y[1].unwrap());
        assert!((x.low - y.low).abs() < 1e-9 && (x.high - y.high).abs() < 1e-9, "{x:?} {y:?}");
    }
    // At lag zero the correlation is 1.
    assert!(covered[0] == MAPS as usize && covered[1..].iter().all(|covered| *covered as f64 >= LEAST), "{covered:?}");
    assert!(covered[1..].iter().any(|covered| *covered < MAPS as usize), "{covered:?}");
}

/// Returns Bartlett's variances for a normal surface of known mean, by sums over all lags s of the map:
/// Var⟨z²⟩ = Σ w(s) 2ρ²(s), and of ⟨z(x)z(x + τ) − z²(x)/e⟩ with ρ(τ) = 1/e, w(s) the fraction of pairs of points.
fn bartlett(model: CorrelationModel, side: usize) -> (f64, f64) {
    let c = covariance(model);
    let (n, tau, level) = (side as isize, POINTS as f64, (-1.0_f64).exp());
    let (mut square, mut decay) = (0.0, 0.0);
    for y in 1 - n..n {
        for x in 1 - n..n {
            let weight = ((n - x.abs()) * (n - y.abs())) as f64 / (n as f64).powi(4);
            let rho = |shift: f64| c.correlation(x as f64 + shift, y as f64);
            let (here, right, left) = (rho(0.0), rho(tau), rho(-tau));
            square += weight * 2.0 * here * here;
            // Covariances of products of four normal variables (Isserlis).
            let products = here * here + right * left;
            let mixed = 2.0 * here * right + 2.0 * here * left;
            decay += weight * (products - level * mixed + level * level * 2.0 * here * here);
        }
    }
    (square, decay)
}

#[test]
fn standard_errors_of_normal_surfaces_equal_bartletts() {
    for model in [CorrelationModel::SquaredExponential, CorrelationModel::Exponential] {
        let (square, decay) = bartlett(model, 30 * POINTS);
        let (mut sq, mut length) = (0.0, 0.0);
        for map in maps(model, &normal(), 30, 60) {
            let moments = Moments::from_values(map.heights_m().iter().copied());
            let cells = Cells::cut(&map, moments.mean, moments.std, [Some(POINTS as f64); 2]).unwrap();
            let sums = HeightSums::of(&cells);
            let window = Window::new(cells.rows, cells.columns, cells.step, cells.length, &sums.fraction);
            sq += window.spread(&sums.sq_influence(), 2.0).unwrap().variance / 60.0;
            let removal = Removal::none(sums.fraction.len());
            let lengths = Lengths::new(&cells, &window, &sums, &removal, 0.025);
            length += lengths.tested((POINTS as isize, 0), (-1.0_f64).exp()).unwrap().1.variance / 60.0;
        }
        // Single variances vary by half, the mean of 60 by 6 %. Allowances for the window's tail and for fitted means
        // add a tenth on average.
        for (name, found, wanted) in [("Sq", sq, square), ("length", length, decay)] {
            let ratio = found / wanted;
            assert!(ratio > 1.0 - 0.18 && ratio < 1.1 + 0.18, "{}: {name} {found} {wanted}", model.name());
        }
    }
}

#[test]
#[ignore = "slow"]
fn standard_errors_equal_the_spread_over_maps() {
    let marginal = Marginal::beta(2.1, 5.0, 0.0, 1.0).unwrap();
    let uncertainty = Uncertainty { resamples: 100, ..Uncertainty::default() };
    let all: Vec<Estimates> = maps(CorrelationModel::SquaredExponential, &marginal, 30, 240)
        .map(|map| uncertainty.of(&map, &values(&map)).unwrap())
        .collect();
    for (k, (name, _)) in all[0].named().into_iter().enumerate() {
        let of: Vec<Estimate> = all.iter().filter_map(|e| e.named()[k].1).collect();
        assert!(of.len() >= 234, "{name} of {}", of.len());
        let spread = Moments::new(&of.iter().map(|e| e.surface).collect::<Vec<_>>()).sample_std();
        let told = Moments::new(&of.iter().map(|e| e.standard_error).collect::<Vec<_>>()).mean;
        // The spread of 240 values has an error of 5 %. The error of Sal is that of one direction; that of the shortest is smaller by a
        // fifth.
        let wanted = if name == "Sal_m" { 1.2 } else { 1.0 };
        assert!((told / spread - wanted).abs() < 0.2, "{name}: {told} for {spread}");
    }
}

#[test]
fn influences_are_derivatives_of_the_statistics() {
    // Heights of one cell have the weight 1 + ε: the statistic changes by ε times the cell's influence.
    let map = maps(CorrelationModel::Exponential, &Marginal::lognormal(0.0, 0.4, 0.0).unwrap(), 10, 1).next().unwrap();
    let moments = Moments::from_values(map.heights_m().iter().copied());
    let cells = Cells::cut(&map, moments.mean, moments.std, [Some(4.0); 2]).unwrap();
    let sums = HeightSums::of(&cells);
    let place = cells.columns + 3;
    let statistics = |weight: f64| {
        let mean = |k: usize| sums.power[k].iter().sum::<f64>() + (weight - 1.0) * sums.power[k][place];
        let all = 1.0 + (weight - 1.0) * sums.fraction[place];
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| mean(k) / all);
        let second = b - a * a;
        let third = c - 3.0 * a * b + 2.0 * a.powi(3);
        let fourth = d - 4.0 * a * c + 6.0 * a * a * b - 3.0 * a.powi(4);
        [second.ln(), third / second.powf(1.5), fourth / (second * second)]
    };
    let (up, down) = (statistics(1.0 + 1e-4), statistics(1.0 - 1e-4));
    let (ssk, sku) = (moments.skewness, moments.excess_kurtosis + 3.0);
    let found = [sums.sq_influence(), sums.ssk_influence(ssk), sums.sku_influence(ssk, sku)];
    for k in 0..3 {
        let wanted = (up[k] - down[k]) / 2e-4;
        assert!((found[k][place] - wanted).abs() < 1e-6 * wanted.abs(), "{k}: {} {wanted}", found[k][place]);
        assert!(found[k].iter().sum::<f64>().abs() < 1e-12, "influences add up to zero");
    }
}

#[test]
fn pairs_with_a_stride_equal_those_of_the_rows() {
    let map = maps(CorrelationModel::Exponential, &normal(), 30, 1).next().unwrap();
    let heights = |map: &HeightMap, row: usize, column: usize| map.heights_m().get([row, column]).copied();
    for (map, length_m, stride) in [(map.clone(), 4.0, 1), (with_holes(&map, 0.2, 7), 4.0, 1), (map, 13.0, 3)] {
        let cells = Cells::cut(&map, 0.0, 1.0, [Some(length_m), Some(length_m)]).unwrap();
        for (lag_x, lag_y) in [(0, 0), (5, 0), (-7, 3), (0, 11), (2, 40)] {
            let (mut sum, mut count) = (0.0, 0.0);
            for ((row, column), z) in map.heights_m().indexed_iter().filter(|((row, _), _)| row % stride == 0) {
                let other = heights(&map, row + lag_y, column.wrapping_add_signed(lag_x));
                if let Some(other) = other.filter(|other| !other.is_nan() && !z.is_nan()) {
                    sum += z * other;
                    count += 1.0;
                }
            }
            let found = cells.pairs(lag_x, lag_y).into_iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
            assert!((found[0] - sum).abs() < 1e-9 * count && found[1] == count, "{found:?} {sum} {count}");
        }
    }
}

#[test]
fn missing_rows_change_only_the_count() {
    // With twice as many rows, cells are still half a correlation length.
    let full = maps(CorrelationModel::SquaredExponential, &normal(), 15, 1).next().unwrap();
    let side = full.grid().nx();
    let padded =
        Array2::from_shape_fn(
            (2 * side, side),
            |(row, column)| {
                if row < side { full.heights_m()[[row, column]] } else { f64::NAN }
            },
        );
    let padded = HeightMap::new(Grid::new(side, 2 * side, 1.0, 1.0).unwrap(), padded).unwrap();
    let (a, b) = (estimates(&full), estimates(&padded));
    for ((name, a), (_, b)) in a.named().into_iter().zip(b.named()).filter(|((name, _), _)| !name.ends_with("k_m")) {
        assert_eq!(a.is_some(), b.is_some(), "{name}");
        let (Some(a), Some(b)) = (a, b) else { continue };
        assert!((a.standard_error / b.standard_error - 1.0).abs() < 1e-9, "{name}: {a:?} {b:?}");
        assert!((a.interval.low / b.interval.low - 1.0).abs() < 1e-6, "{name}: {a:?} {b:?}");
    }
}

#[test]
fn a_transposed_map_has_transposed_lengths_and_units_scale() {
    let map = maps(CorrelationModel::Exponential, &normal(), 20, 1).next().unwrap();
    let turned = map.heights_m().t().map(|z| 1e-6 * z);
    let turned = HeightMap::new(Grid::new(80, 80, 1e-5, 1e-5).unwrap(), turned).unwrap();
    let (a, b) = (estimates(&map), estimates(&turned));
    for (a, b, unit) in [
        (a.correlation_length_x_m, b.correlation_length_y_m, 1e-5),
        (a.correlation_length_y_m, b.correlation_length_x_m, 1e-5),
        (a.sq_m, b.sq_m, 1e-6),
        (a.ssk, b.ssk, 1.0),
        (a.sdq, b.sdq, 0.1),
    ] {
        let (a, b) = (a.unwrap(), b.unwrap());
        assert!((b.interval.high / a.interval.high / unit - 1.0).abs() < 1e-9, "{a:?} {b:?}");
        assert!((b.standard_error / a.standard_error / unit - 1.0).abs() < 1e-9, "{a:?} {b:?}");
    }
}

#[test]
fn a_lay_as_long_as_the_map_has_only_the_blocks_across_it() {
    // Profiles along x, copies of the first with a little noise: the number of blocks is that of one profile.
    let (mut errors, mut lengths, mut held) = (Vec::new(), 0, 0);
    for rough in maps(CorrelationModel::SquaredExponential, &normal(), 50, 12) {
        let side = rough.grid().nx();
        let noise = random::standard_normal(&mut random::stream(43, "noise", 0), side * side);
        let lay = Array2::from_shape_fn((side, side), |(row, column)| {
            rough.heights_m()[[0, column]] + 0.1 * noise[row * side + column]
        });
        let e = estimates(&HeightMap::new(rough.grid(), lay).unwrap());
        assert_eq!(e.correlation_length_y_m, None);
        // So few blocks do not always allow an estimate.
        if let Some(sq) = e.sq_m {
            assert!(sq.blocks < 20.0, "{sq:?}");
            errors.push(sq.standard_error);
        }
        if let Some(length) = e.correlation_length_x_m {
            assert!(length.blocks < 20.0, "{length:?}");
            lengths += 1;
            held += usize::from(length.interval.contains(POINTS as f64));
        }
    }
    assert!(errors.len() >= 9 && lengths >= 9 && held + 2 >= lengths, "{errors:?} {lengths} {held}");
    // A profile of 50 lengths has Var⟨z²⟩ = 2 ∫ρ² = 2 √(π/2)/50, so Sq has an error of 11 %, known to a third.
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    assert!(mean > 0.07 && mean < 0.17, "{errors:?}");
}

#[test]
fn a_map_of_few_correlation_lengths_has_no_estimates() {
    let map = maps(CorrelationModel::Exponential, &normal(), 5, 1).next().unwrap();
    assert_eq!(estimates(&map), Estimates::default());
    // With ten lengths a side intervals would be too narrow; a form of many coefficients needs even more lengths.
    let map = maps(CorrelationModel::Exponential, &normal(), 10, 1).next().unwrap();
    assert_eq!(estimates(&map), Estimates::default());
    let map = maps(CorrelationModel::Exponential, &normal(), 30, 1).next().unwrap();
    let form = |terms| Uncertainty { removed_terms: terms, resamples: 20, ..Uncertainty::default() };
    let values = values(&map);
    assert!(form(3).of(&map, &values).unwrap().sq_m.is_some());
    assert_eq!(form(15).of(&map, &values).unwrap(), Estimates::default());
}

#[test]
fn estimates_do_not_depend_on_the_number_of_threads() {
    let map = with_holes(&maps(CorrelationModel::Exponential, &normal(), 30, 1).next().unwrap(), 0.1, 0);
    let values = values(&map);
    let run = || Uncertainty { resamples: 20, ..Uncertainty::default() }.of(&map, &values).unwrap();
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    assert_eq!(pool(1).install(run), pool(3).install(run));
}

#[test]
fn invalid_requests_are_refused() {
    let map = maps(CorrelationModel::Exponential, &normal(), 10, 1).next().unwrap();
    let values = values(&map);
    let of = |level, resamples| Uncertainty { level, resamples, ..Uncertainty::default() }.of(&map, &values);
    assert!(matches!(of(1.0, 100), Err(UncertaintyError::Parameter { parameter: "confidence level", .. })));
    assert!(matches!(of(0.95, 1), Err(UncertaintyError::Parameter { parameter: "number of resamples", .. })));
}

#[test]
#[ignore = "slow"]
fn joint_errors_of_height_slope_and_skewness_equal_their_covariance_over_maps() {
    let marginal = Marginal::beta(2.1, 5.0, 0.0, 1.0).unwrap();
    let count = 80;
    let mut errors = [[0.0; 3]; 3];
    let mut statistics = Vec::new();
    for map in maps(CorrelationModel::SquaredExponential, &marginal, 24, count) {
        let values = Values { sdq: parameters(&map).unwrap().sdq, ..quick_values(&map) };
        let joint = Uncertainty { resamples: 2, ..Uncertainty::default() }.of(&map, &values).unwrap().joint.unwrap();
        for i in 0..3 {
            for j in 0..3 {
                errors[i][j] += joint[i][j] / count as f64;
            }
        }
        statistics.push([values.sq_m.ln(), values.sdq.unwrap().ln(), values.ssk]);
    }
    let mean = |i: usize| statistics.iter().map(|s| s[i]).sum::<f64>() / count as f64;
    let covariance_of = |i: usize, j: usize| {
        statistics.iter().map(|s| (s[i] - mean(i)) * (s[j] - mean(j))).sum::<f64>() / (count as f64 - 1.0)
    };
    for i in 0..3 {
        for j in 0..=i {
            // The standard error of a covariance of normal errors.
            let variance = covariance_of(i, i) * covariance_of(j, j) + covariance_of(i, j).powi(2);
            let tolerance = 4.0 * (variance / (count as f64 - 1.0)).sqrt();
            let (found, wanted) = (errors[i][j], covariance_of(i, j));
            assert!((found - wanted).abs() < tolerance, "{i} {j}: {found:e} for {wanted:e} ± {tolerance:e}");
            assert!((errors[i][j] - errors[j][i]).abs() < 1e-15);
        }
    }
    // Heights and slopes of one map are high together.
    assert!(errors[0][1] > 0.2 * (errors[0][0] * errors[1][1]).sqrt());
}

/// Returns maps of `side` points a side whose correlation falls to 1/e at `length` points; far below one point they are
/// white noise.
fn short_maps(model: CorrelationModel, length: f64, side: usize, count: u64) -> impl Iterator<Item = HeightMap> {
    let covariance = Covariance::new(model, 1.0, length, length).unwrap();
    let field = SpectralField::periodic(&covariance, Grid::new(side + 24, side + 24, 1.0, 1.0).unwrap());
    (0..count).map(move |index| {
        let xi = random::standard_normal(&mut random::stream(44, "short maps", index), field.xi_len());
        let heights = field.generate(&xi).heights_m().slice(s![..side, ..side]).to_owned();
        HeightMap::new(Grid::new(side, side, 1.0, 1.0).unwrap(), heights).unwrap()
    })
}

/// Returns maps of white noise averaged over 3 × 3 points, whose correlation is linear: 1, 2/3, 1/3, 0.
fn averaged_noise(side: usize, count: u64) -> impl Iterator<Item = HeightMap> {
    (0..count).map(move |index| {
        let wide = side + 2;
        let noise = random::standard_normal(&mut random::stream(45, "averaged noise", index), wide * wide);
        let noise = Array2::from_shape_vec((wide, wide), noise).unwrap();
        let mean = |(row, column)| noise.slice(s![row..row + 3, column..column + 3]).sum() / 9.0;
        HeightMap::new(Grid::new(side, side, 1.0, 1.0).unwrap(), Array2::from_shape_fn((side, side), mean)).unwrap()
    })
}

/// Counts of intervals of the length along x.
#[derive(Debug, Default)]
struct Stated {
    stated: u64,
    without_value: u64,
    without_truth: u64,
}

fn stated(maps: impl Iterator<Item = HeightMap>, length: f64) -> Stated {
    let mut found = Stated::default();
    for map in maps {
        let e = Uncertainty { resamples: 2, ..Uncertainty::default() }.of(&map, &quick_values(&map)).unwrap();
        if let Some(Estimate { value, interval, .. }) = e.correlation_length_x_m {
            found.stated += 1;
            found.without_value += u64::from(!interval.contains(value));
            found.without_truth += u64::from(!interval.contains(length));
        }
    }
    found
}

const SHORT_MODELS: [CorrelationModel; 2] = [CorrelationModel::SquaredExponential, CorrelationModel::Exponential];

#[test]
fn intervals_of_lengths_of_few_points_contain_their_values() {
    for model in SHORT_MODELS {
        for length in [1.5, 2.2, 3.0] {
            let found = stated(short_maps(model, length, 72, 2), length);
            assert!(found.stated == 2 && found.without_value == 0, "{} {length}: {found:?}", model.name());
        }
        // Without a lag at which the correlation exceeds 1/e there is no interval.
        for length in [0.01, 0.5, 0.8] {
            assert_eq!(stated(short_maps(model, length, 64, 3), length).stated, 0, "{} {length}", model.name());
        }
    }
}

#[test]
fn sal_below_the_shortest_lag_has_no_interval() {
    let sal = |length: f64| {
        let map = short_maps(CorrelationModel::Exponential, length, 64, 1).next().unwrap();
        let estimates = Uncertainty { resamples: 2, ..Uncertainty::default() }.of(&map, &values(&map)).unwrap();
        estimates.sal_m.map(|estimate| estimate.interval)
    };
    assert_eq!(sal(0.01), None);
    // ln 5 times as long.
    let Interval { low, high } = sal(2.0).unwrap();
    assert!(low > 1.0 && low < 3.2 && high > 3.2, "{low} {high}");
}

#[test]
#[ignore = "slow"]
fn intervals_of_lengths_of_few_points_have_95_percent_coverage() {
    // More than 10 of 60 intervals miss with a probability of 2e-4 (binomial). More than 95 % cover if the ends of linear and convex
    // correlations differ.
    for model in SHORT_MODELS {
        for length in [1.5, 1.8, 2.2, 2.6, 3.0] {
            let found = stated(short_maps(model, length, 90, MAPS), length);
            assert!(found.stated == MAPS && found.without_value == 0, "{} {length}: {found:?}", model.name());
            assert!(found.without_truth <= 10, "{} {length}: {found:?}", model.name());
        }
        // On larger maps the intervals are narrower than the bias of the value.
        for length in [1.5, 2.5] {
            let found = stated(short_maps(model, length, 240, 40), length);
            assert!(found.stated == 40 && found.without_value == 0, "{} {length}: {found:?}", model.name());
            // More than 8 of 40 with a probability of 1e-4.
            assert!(found.without_truth <= 8, "{} {length}: {found:?}", model.name());
        }
        // Close to one point only maps whose correlation there exceeds 1/e significantly have an interval. Those without
        // the truth are at most 2.5 % of the maps: more than 7 of 60 with a probability of 1e-4.
        for length in [1.0, 1.1, 1.2] {
            let found = stated(short_maps(model, length, 90, MAPS), length);
            assert!(found.without_value == 0 && found.without_truth <= 7, "{} {length}: {found:?}", model.name());
        }
    }
}

#[test]
#[ignore = "slow"]
fn intervals_of_averaged_noise_have_95_percent_coverage() {
    let length = 3.0 * (1.0 - (-1.0_f64).exp());
    for (side, count, most) in [(64, MAPS, 10), (240, 40, 8)] {
        let found = stated(averaged_noise(side, count), length);
        assert!(found.stated == count && found.without_value == 0 && found.without_truth <= most, "{side}: {found:?}");
    }
}

#[test]
fn weights_between_lags_are_those_of_several_shapes() {
    let level = (-1.0_f64).exp();
    for (power, tolerance) in [(1.0, 1e-12), (2.0, 1e-12), (1.25, 4e-3), (1.5, 4e-3), (1.75, 4e-3)] {
        for step in 0..900 {
            let length = 1.0 + 0.1 * f64::from(step) / 3.0;
            let sum: f64 = super::lengths::convex(length, level)
                .into_iter()
                .map(|(lag, weight)| weight * (-(lag as f64 / length).powf(power)).exp())
                .sum();
            assert!((sum - level).abs() < tolerance, "{power} {length}: {sum}");
        }
    }
}
