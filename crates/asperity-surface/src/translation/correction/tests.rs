use super::*;
use crate::{RandomSurface, Translated};
use asperity_base::correlation::{CorrelationModel, Covariance, Rotated};
use asperity_base::random;
use asperity_base::stats::Moments;

fn covariance(model: CorrelationModel, length_m: f64) -> Covariance {
    Covariance::isotropic(model, 1.0, length_m).unwrap()
}

/// Returns any covariance with the symmetry of a lay along an axis.
fn mirrored() -> Covariance {
    covariance(CorrelationModel::Exponential, 1.0)
}

fn marginal(text: &str) -> Marginal {
    text.parse().unwrap()
}

fn square(points: usize) -> Grid {
    Grid::new(points, points, 1.0, 1.0).unwrap()
}

/// The correlation cos(2πx/period), and 1 at zero.
struct Wave(f64);

impl StationaryCovariance for Wave {
    fn std_m(&self) -> f64 {
        1.0
    }

    fn correlation(&self, dx_m: f64, _dy_m: f64) -> f64 {
        (std::f64::consts::TAU * dx_m / self.0).cos()
    }
}

/// Returns the ensemble autocorrelation of a periodic surface averaged over rings of one point, Σ z z'/Σ z² with the
/// known mean of the distribution, and the standard error of each ring from the variability of the realisations.
fn ring_correlation(surface: &Translated<SpectralField>, mean: f64, count: u64, stage: &str) -> Vec<(f64, f64)> {
    let grid = surface.grid();
    let lags = Lags::periodic(&mirrored(), grid);
    let mut work = lags.fft.workspace();
    let ring = |place: usize| {
        let (row, column) = (place / grid.nx(), place % grid.nx());
        let (y, x) = (row.min(grid.ny() - row), column.min(grid.nx() - column));
        (x as f64).hypot(y as f64).round() as usize
    };
    let rings = grid.nx() / 2;
    let mut sizes = vec![0.0; rings];
    (0..grid.points()).filter(|place| ring(*place) < rings).for_each(|place| sizes[ring(place)] += 1.0);
    let maps: Vec<Vec<f64>> = (0..count)
        .map(|index| {
            let xi = random::standard_normal(&mut random::stream(2011, stage, index), surface.xi_len());
            let heights: Vec<f64> = surface.generate(&xi).heights_m().iter().map(|z| z - mean).collect();
            let mut spectrum = lags.fft.spectrum();
            lags.fft.forward(&heights, &mut spectrum, &mut work);
            let power: Vec<f64> = spectrum.iter().map(|s| s.norm_sqr() / grid.points() as f64).collect();
            let mut means = vec![0.0; rings];
            for (place, value) in lags.map(&power, &mut work).into_iter().enumerate() {
                if ring(place) < rings {
                    means[ring(place)] += value / sizes[ring(place)];
                }
            }
            means
        })
        .collect();
    let variance = maps.iter().map(|means| means[0]).sum::<f64>() / count as f64;
    (0..rings)
        .map(|ring| {
            let rho = maps.iter().map(|means| means[ring]).sum::<f64>() / (count as f64 * variance);
            let deviations: Vec<f64> = maps.iter().map(|means| (means[ring] - rho * means[0]) / variance).collect();
            (rho, Moments::new(&deviations).standard_error())
        })
        .collect()
}

#[test]
fn corrected_surfaces_keep_the_target_correlation_to_a_hundredth_over_two_hundred_realisations() {
    // On a side of 32 lengths the variance of a lag's estimate is at most about πℓ²/A per map (Bartlett), 0.055² here.
    // So 200 maps have an error of 0.004, reduced further by ring averages and the common variance.
    let target = covariance(CorrelationModel::SquaredExponential, 4.0);
    let grid = square(128);
    let ring_mean = |of: &dyn Fn(f64, f64) -> f64, ring: usize| {
        // The same average of a function of the lag.
        let all: Vec<f64> = (0..=64_i32)
            .flat_map(|y| (0..=64_i32).map(move |x| (x, y)))
            .filter(|(x, y)| f64::from(*x).hypot(f64::from(*y)).round() as usize == ring)
            .flat_map(|(x, y)| {
                let copies = if x % 64 == 0 { 1 } else { 2 } * if y % 64 == 0 { 1 } else { 2 };
                vec![of(f64::from(x), f64::from(y)); copies]
            })
            .collect();
        all.iter().sum::<f64>() / all.len() as f64
    };
    for (text, plain_error) in [("beta:2.1,5", 0.00779), ("lognormal:0,0.5", 0.0312)] {
        let marginal = marginal(text);
        let distortion = Translation::new(&marginal).unwrap();
        let CorrectedField { field, report } =
            TranslationCorrection { tolerance: 1e-2, ..Default::default() }.periodic(&target, &marginal, grid).unwrap();
        assert!(report.corrected.largest_deviation < 3e-3, "{text}: {:?}", report.corrected);
        let plain_field = SpectralField::periodic(&target, grid);
        let corrected = Translated::new(field, marginal.clone()).unwrap();
        let plain = Translated::new(plain_field, marginal.clone()).unwrap();
        let met = ring_correlation(&corrected, marginal.mean(), 200, "corrected");
        let distorted = ring_correlation(&plain, marginal.mean(), 200, "plain");
        let (mut largest, mut largest_plain) = (0.0_f64, 0.0_f64);
        for (ring, ((rho, error), (rho_plain, error_plain))) in met.into_iter().zip(distorted).enumerate() {
            let wanted = ring_mean(&|x, y| target.correlation(x, y), ring);
            let wanted_plain = ring_mean(&|x, y| distortion.correlation(target.correlation(x, y)), ring);
            assert!(error < 3e-3 && error_plain < 3e-3, "{text} ring {ring}: standard errors {error} {error_plain}");
            largest = largest.max((rho - wanted).abs());
            largest_plain = largest_plain.max((rho_plain - wanted).abs());
            assert!((rho_plain - wanted_plain).abs() < 4.0 * error_plain + 1e-9, "{text} ring {ring}: {rho_plain}");
        }
        println!(
            "{text}: corrected {largest:.4} (exact {:.5}), plain {largest_plain:.4}",
            report.corrected.largest_deviation
        );
        assert!(largest < 0.01, "{text}: {largest}");
        // Largest error of the plain map, max |T(ρ) − ρ| over ρ in [0, 1]; no lag of the grid exceeds it.
        assert!(report.plain.largest_deviation <= plain_error + 1e-4, "{text}: {:?}", report.plain);
        assert!((largest_plain - plain_error).abs() < 6e-3, "{text}: {largest_plain}");
    }
}

#[test]
fn models_and_distributions_of_a_study_are_reproduced_on_both_boundaries() {
    for model in [
        CorrelationModel::Exponential,
        CorrelationModel::SquaredExponential,
        CorrelationModel::Matern { nu: 1.5 },
        CorrelationModel::SelfAffine { hurst: 0.8 },
    ] {
        for text in ["beta:2.1,5", "lognormal:0,0.5", "weibull:1.5,1", "johnson:-1,5", "normal"] {
            let target = covariance(model, 4.0);
            let correction = TranslationCorrection::default();
            for (boundary, corrected) in [
                ("periodic", correction.periodic(&target, &marginal(text), square(64)).unwrap()),
                ("free", correction.free(&target, &marginal(text), square(32)).unwrap()),
            ] {
                let CorrectionReport { feasibility, plain, predistorted, corrected, iterations, .. } = corrected.report;
                println!(
                    "{} {text} {boundary}: plain {:.5}, once {:.5}, corrected {:.5} after {iterations}, negative {:.5}",
                    model.name(),
                    plain.largest_deviation,
                    predistorted.largest_deviation,
                    corrected.largest_deviation,
                    feasibility.predistorted_negative_fraction
                );
                assert!(corrected.largest_deviation < 3e-3, "{model:?} {text} {boundary}");
                assert!(corrected.largest_deviation <= predistorted.largest_deviation);
                assert!(feasibility.target_negative_fraction < 1e-8);
                if text != "normal" {
                    assert!(plain.largest_deviation > 3.0 * corrected.largest_deviation);
                }
            }
        }
    }
}

/// Runs the published iteration for comparison: S ← S (S_target/S_met)^1.4, from the target's spectrum.
fn translation_approximation(lags: &Lags, translation: &Translation, target: &[f64], iterations: usize) -> Vec<f64> {
    let mut work = lags.fft.workspace();
    let mut wanted = lags.spectrum(target, &mut work);
    lags.clip(&mut wanted);
    let mut spectrum = wanted.clone();
    for _ in 0..iterations {
        let normal = lags.map(&spectrum, &mut work);
        let met: Vec<f64> = normal.into_iter().map(|rho| translation.correlation(rho.clamp(-1.0, 1.0))).collect();
        for ((s, wanted), met) in spectrum.iter_mut().zip(&wanted).zip(lags.spectrum(&met, &mut work)) {
            *s *= (wanted / met.max(1e-12)).max(0.0).powf(1.4);
        }
        lags.clip(&mut spectrum);
    }
    spectrum
}

#[test]
fn strongly_distorted_targets_are_approached_better_than_by_clipping_or_the_published_iteration() {
    let grid = square(64);
    let lags = Lags::periodic(&mirrored(), grid);
    for (text, model) in [
        ("lognormal:0,1.5", CorrelationModel::SquaredExponential),
        ("lognormal:0,2", CorrelationModel::SquaredExponential),
        ("johnson_sb:0,0.15", CorrelationModel::SquaredExponential),
        ("lognormal:0,2", CorrelationModel::Exponential),
    ] {
        let (target, marginal) = (covariance(model, 8.0), marginal(text));
        let correction = TranslationCorrection { tolerance: 0.0, ..Default::default() };
        let CorrectedField { report, .. } = correction.periodic(&target, &marginal, grid).unwrap();
        let translation = Translation::new(&marginal).unwrap();
        let wanted = lags.wrapped(&target).unwrap();
        let spectrum = translation_approximation(&lags, &translation, &wanted, 60);
        let normal = lags.map(&spectrum, &mut lags.fft.workspace());
        let met: Vec<f64> = normal.into_iter().map(|rho| translation.correlation(rho.clamp(-1.0, 1.0))).collect();
        let published = lags.deviation(&met, &wanted);
        println!(
            "{text} {}: plain {:.4}, once {:.4}, corrected {:.4} (rms {:.5}) after {}, multiplicative {:.4} (rms {:.5})",
            model.name(),
            report.plain.largest_deviation,
            report.predistorted.largest_deviation,
            report.corrected.largest_deviation,
            report.corrected.rms_deviation,
            report.iterations,
            published.largest_deviation,
            published.rms_deviation,
        );
        assert!(report.feasibility.predistorted_negative_fraction > 1e-3);
        assert!(report.corrected.largest_deviation < 0.75 * report.predistorted.largest_deviation, "{text}");
        assert!(report.corrected.largest_deviation < 1.1 * published.largest_deviation, "{text}");
        assert!(report.corrected.rms_deviation < 1.1 * published.rms_deviation, "{text}");
    }
}

#[test]
fn the_search_ends_where_no_admissible_spectrum_is_better() {
    // Two checks independent of the search: its gradient equals difference quotients, and a step against it returns
    // to the same spectrum by projection.
    let lags = Lags::within(&mirrored(), Grid::new(6, 5, 1.0, 1.0).unwrap(), Grid::new(12, 10, 1.0, 1.0).unwrap());
    let marginal = marginal("lognormal:0,1.5");
    let target = covariance(CorrelationModel::SquaredExponential, 2.5);
    let translation = Translation::new(&marginal).unwrap();
    let wanted = lags.wrapped(&target).unwrap();
    let work = lags.fft.workspace();
    let mut search = Search { lags: &lags, translation: &translation, target: &wanted, least_gain: 0.0, work };
    let normal = lags.wrapped(&Predistorted::new(target, &marginal).unwrap()).unwrap();
    let start = lags.spectrum(&normal, &mut lags.fft.workspace());
    let mut projected = start.clone();
    lags.project(&mut projected);

    let here = search.height(&projected);
    let ny = lags.fft.ny();
    for place in [0, 1, 3, ny + 2, 3 * ny] {
        // Only even spectra: the partner (k_x, −k_y) changes too.
        let partner = (place / ny) * ny + (ny - place % ny) % ny;
        let along = |h: f64| {
            let mut moved = projected.clone();
            moved[place] += h;
            if partner != place {
                moved[partner] += h;
            }
            moved
        };
        let h = 1e-4;
        let quotient = (search.height(&along(h)).value - search.height(&along(-h)).value) / (2.0 * h);
        let direction: Vec<f64> = along(1.0).iter().zip(&projected).map(|(a, b)| a - b).collect();
        let slope = search.product(&here.gradient, &direction);
        assert!((quotient - slope).abs() < 1e-4 * (1e-3 + slope.abs()), "{place}: {quotient} {slope}");
    }

    let settings = TranslationCorrection { tolerance: 0.0, iterations: 2000 };
    let first = Best { deviation: here.deviation, spectrum: projected.clone() };
    let Descent { last, .. } = search.descend(&settings, start, first);
    let there = search.height(&last);
    assert!(there.value < 0.9 * here.value, "{} {}", there.value, here.value);
    let mut back: Vec<f64> = last.iter().zip(&there.gradient).map(|(s, g)| s - g).collect();
    lags.project(&mut back);
    let size = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let moved: Vec<f64> = back.iter().zip(&last).map(|(a, b)| a - b).collect();
    assert!(size(&moved) < 1e-5 * size(&there.gradient), "{:e} {:e}", size(&moved), size(&there.gradient));
    assert!(last.iter().all(|s| *s >= 0.0) && last.contains(&0.0), "some mode is at its bound");
    assert!((lags.sum(last.iter().copied()) / lags.points() as f64 - 1.0).abs() < 1e-12);
}

#[test]
fn the_projection_is_the_nearest_admissible_spectrum() {
    for (nx, ny) in [(12, 10), (9, 7), (16, 5)] {
        let lags = Lags::periodic(&mirrored(), Grid::new(nx, ny, 1.0, 1.0).unwrap());
        let points = lags.points() as f64;
        let given = random::standard_normal(&mut random::stream(1, "projection", nx as u64), lags.fft.spectrum_len());
        let mut projected = given.clone();
        lags.project(&mut projected);
        assert!((lags.sum(projected.iter().copied()) / points - 1.0).abs() < 1e-13);
        // Computes the offset by bisection.
        let total = |offset: f64| lags.sum(given.iter().map(|s| (s - offset).max(0.0)));
        let (mut low, mut high) = (-1e3, 1e3);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if total(middle) > points { low = middle } else { high = middle }
        }
        for (s, p) in given.iter().zip(&projected) {
            assert!(((s - low).max(0.0) - p).abs() < 1e-12);
        }
        // The projection leaves an admissible spectrum unchanged.
        let mut again = projected.clone();
        lags.project(&mut again);
        assert!(again.iter().zip(&projected).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}

#[test]
fn correlations_below_the_least_one_of_the_distribution_are_reported() {
    // Least correlations: −0.95158625 of the distribution of friction, −e^{−σ²} of a lognormal one, since
    // (e^{−σ²} − 1)/(e^{σ²} − 1) = −e^{−σ²}.
    let correction = TranslationCorrection::default();
    for (text, least) in [("beta:2.1,5", -0.951_586_25), ("lognormal:0,0.5", -(-0.25_f64).exp())] {
        let CorrectedField { report, .. } = correction.periodic(&Wave(16.0), &marginal(text), square(32)).unwrap();
        assert!((report.feasibility.least_correlation - least).abs() < 1e-8, "{:?}", report.feasibility);
        assert!((report.feasibility.least_target + 1.0).abs() < 1e-12);
        assert!(!report.converged);
        // At half a period no translation reaches the target.
        assert!(report.corrected.largest_deviation > 1.0 + least - 1e-7);
    }
    let CorrectedField { report, .. } = correction.periodic(&Wave(16.0), &marginal("normal"), square(32)).unwrap();
    assert!(report.converged && report.iterations == 0);
    assert!(report.corrected.largest_deviation < 1e-12);
}

#[test]
fn a_target_that_is_no_correlation_is_an_error() {
    struct Broken;
    impl StationaryCovariance for Broken {
        fn std_m(&self) -> f64 {
            1.0
        }
        fn correlation(&self, dx_m: f64, _dy_m: f64) -> f64 {
            if dx_m == 3.0 { f64::NAN } else { (-dx_m).exp() }
        }
    }
    let error = TranslationCorrection::default().periodic(&Broken, &marginal("normal"), square(8)).unwrap_err();
    assert!(matches!(error, TranslationError::Target { lag_x_m: 3.0, lag_y_m: 0.0, .. }), "{error}");
}

#[test]
fn the_field_has_the_correlation_that_the_report_states() {
    // Two independent computations of the same number: the spectrum of the search, and the modes of the generator.
    let target = covariance(CorrelationModel::SquaredExponential, 5.0);
    let marginal = marginal("lognormal:0,1");
    let correction = TranslationCorrection::default();
    for (free, corrected) in [
        (false, correction.periodic(&target, &marginal, square(32)).unwrap()),
        (true, correction.free(&target, &marginal, square(32)).unwrap()),
    ] {
        let CorrectedField { field, report } = corrected;
        assert_eq!(report.achieved.dim(), if free { (32, 32) } else { (17, 17) });
        // A free field needs twice the sides. Larger domains do not make the spectrum positive.
        assert_eq!(field.xi_len(), if free { 64 * 64 } else { 32 * 32 });
        let surface = Translated::new(field, marginal.clone()).unwrap();
        let met = surface.correlation_with(0, 0);
        for ((row, column), value) in report.achieved.indexed_iter() {
            assert!((met[[row, column]] - value).abs() < 1e-9, "({row},{column}): {} {value}", met[[row, column]]);
            // On a periodic map the target is the sum of its images.
            let period = if free { f64::INFINITY } else { 32.0 };
            let along =
                |lag: usize| (-(lag as f64 / 5.0).powi(2)).exp() + (-((period - lag as f64) / 5.0).powi(2)).exp();
            assert!((report.target[[row, column]] - along(row) * along(column)).abs() < 1e-12);
        }
        assert!((report.achieved_plain[[0, 0]] - 1.0).abs() < 1e-9);
    }
}

#[test]
fn an_oblique_lay_is_reproduced_on_both_of_its_sides() {
    let long = Covariance::new(CorrelationModel::Exponential, 1.0, 7.0, 2.5).unwrap();
    let target = Rotated::new(long, 0.6).unwrap();
    let marginal = marginal("lognormal:0,0.5");
    let correction = TranslationCorrection::default();
    // An even and an odd side: half a period is a lag only on an even side.
    for grid in [Grid::new(48, 45, 1.0, 1.0).unwrap(), Grid::new(45, 48, 1.0, 1.0).unwrap()] {
        for (free, corrected) in [
            (false, correction.periodic(&target, &marginal, grid).unwrap()),
            (true, correction.free(&target, &marginal, grid).unwrap()),
        ] {
            let CorrectedField { field, report } = corrected;
            assert!(report.corrected.largest_deviation < 0.01, "{free}: {:?}", report.corrected);
            assert!(report.plain.largest_deviation > 0.02, "{:?}", report.plain);
            let surface = Translated::new(field, marginal.clone()).unwrap();
            // Correlation with one point in the middle, whose lags have either sign.
            let met = surface.correlation_with(20, 20);
            for (x, y) in [(3_i32, 2_i32), (-3, 2), (6, 4), (-6, 4), (2, 6), (-2, 6)] {
                let value = met[[(20 + y) as usize, (20 + x) as usize]];
                let wanted = target.correlation(f64::from(x), f64::from(y));
                assert!((value - wanted).abs() < 0.011, "({x},{y}): {value} {wanted}");
            }
        }
    }
}
