//! Tests of twins of maps with a known distribution.

use asperity_formats::Scan;
use asperity_testing::{AlwaysCancelled, covered, repetitions};
use ndarray::Array2;

use super::*;
use crate::correlation::CorrelationFamily;
use crate::correlation::{Autocorrelation, CorrelationModel, Covariance, Rotated};
use crate::distribution::Marginal;
use crate::monitor::Silent;
use crate::quantity::Length;
use crate::study::result::StatisticComparison;
use crate::surface::CovarianceSource;
use crate::surface::scanned::MapStatistics;
use crate::surface::{Predistorted, SpectralField, Translated};
use crate::translation::TranslationKind;

const PITCH_M: f64 = 1e-6;

/// Draws one map of a covariance and a distribution, in metre; its random streams differ from those of twins.
fn map_of(covariance: &Covariance, law: &Marginal, shape: (usize, usize), index: u64) -> Array2<f64> {
    let grid = Grid::new(shape.1, shape.0, PITCH_M, PITCH_M).unwrap();
    let field = SpectralField::free(&Predistorted::new(*covariance, law).unwrap(), grid).unwrap();
    let surface = Translated::with_rms_height(field, law.clone(), covariance.std_m()).unwrap();
    let mut stream = random::stream(77, "known map", index);
    surface.generate(&random::standard_normal(&mut stream, surface.xi_len())).heights_m().clone()
}

fn scan_of(heights_m: Array2<f64>) -> Scan {
    Scan::new(heights_m, Some((PITCH_M, PITCH_M)))
}

fn smooth(length_x_m: f64, length_y_m: f64) -> Covariance {
    Covariance::new(CorrelationModel::SquaredExponential, 1e-6, length_x_m, length_y_m).unwrap()
}

/// Options that give twins the distribution of `map_of`; nothing is measured.
fn stated(covariance: &Covariance, seed: u64) -> TwinOptions {
    let mut options = TwinOptions::new(seed);
    options.surface.covariance = CovarianceSource::SquaredExponential;
    options.surface.rms_height = Some(Length(covariance.std_m()));
    options.surface.correlation_length = Some([Length(covariance.length_x_m()), Length(covariance.length_y_m())]);
    options.surface.marginal = "normal".into();
    options
}

/// Options that measure everything; the correlation is slightly distorted, which these tests accept.
fn plain(seed: u64) -> TwinOptions {
    let mut options = TwinOptions::new(seed);
    options.surface.translation = TranslationKind::Plain;
    options.surface.covariance = CovarianceSource::Measured;
    options
}

fn compare(twins: &Twins, count: usize) -> Comparison {
    compare_with_tables(twins, count).0
}

fn compare_with_tables(twins: &Twins, count: usize) -> (Comparison, TwinTables) {
    twins.compare(count, &Silent, |_, _| Ok::<(), StudyError>(())).unwrap()
}

fn statistic(comparison: &Comparison, name: &str) -> StatisticComparison {
    comparison.twins.iter().find(|(own, _)| own == name).unwrap().1
}

/// Returns mean and standard error.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt())
}

/// Returns the fraction of the statistics, and of the abscissas of the curves, of maps of a known distribution that lie
/// in the bands of twins of that distribution; one value per map, because the statistics of a map are correlated.
fn coverage(count: usize, maps: u64) -> (Vec<f64>, Vec<f64>) {
    let covariance = smooth(4e-6, 3e-6);
    let of_map = |index: u64| {
        let mut heights = map_of(&covariance, &Marginal::STANDARD_NORMAL, (36, 40), index);
        // Holes, which twins share.
        heights.indexed_iter_mut().filter(|((r, c), _)| r.pow(2) + c.pow(2) < 90).for_each(|(_, z)| *z = f64::NAN);
        let comparison = compare(&Twins::new(scan_of(heights), "map", &stated(&covariance, index)).unwrap(), count);
        assert!(comparison.compared > 18, "{}", comparison.compared);
        let shares = comparison.curves.iter().map(|(_, curve)| curve.inside_share.unwrap());
        let curves = shares.sum::<f64>() / comparison.curves.len() as f64;
        (comparison.inside as f64 / comparison.compared as f64, curves)
    };
    (0..maps).map(of_map).unzip()
}

#[test]
#[ignore = "slow"]
fn bands_of_twins_cover_maps_of_their_own_distribution() {
    // Scan and twins are exchangeable, so order statistics of 39 twins contain the scan's with probability 38/40
    // exactly, for any distribution of a statistic.
    let (statistics, curves) = coverage(39, 8);
    for (what, shares) in [("statistics", statistics), ("curves", curves)] {
        let (mean, error) = mean_and_error(&shares);
        assert!(error < 0.045 && (mean - 0.95).abs() < 4.0 * error, "{what}: {mean:.3} ± {error:.3}");
    }
    // Student's interval of few twins is exact for normal statistics only; most of these are nearly normal.
    let maps = repetitions(16);
    let (statistics, curves) = coverage(10, maps as u64);
    for (what, shares) in [("statistics", statistics), ("curves", curves)] {
        let (mean, error) = mean_and_error(&shares);
        covered("band of ten digital twins", what, (mean * maps as f64).round() as usize, maps);
        assert!(error < 0.035 && (mean - 0.95).abs() < 4.0 * error + 0.01, "{what}: {mean:.3} ± {error:.3}");
    }
}

#[test]
#[ignore = "slow"]
fn twins_of_the_scan_s_own_covariance_keep_a_lay_at_an_angle() {
    let long = Covariance::new(CorrelationModel::Matern { nu: 1.5 }, 1e-6, 12e-6, 3e-6).unwrap();
    let grid = Grid::new(120, 120, PITCH_M, PITCH_M).unwrap();
    let field = SpectralField::free(&Rotated::new(long, 0.7).unwrap(), grid).unwrap();
    let scan = field.generate(&random::standard_normal(&mut random::stream(77, "oblique", 0), field.xi_len()));
    // Along and across the lay, on the diagonals.
    let diagonals = |map: &HeightMap| {
        let acf = Autocorrelation::within(map, 8, 8).unwrap();
        (acf.correlation(4, 4), acf.correlation(4, -4))
    };
    let (along, across) = diagonals(&scan);
    assert!(along - across > 0.4, "{along} {across}");
    // A requested model is used, although it averages the lay away.
    let mut options = TwinOptions { families: vec![CorrelationFamily::Matern], ..plain(1) };
    let mean_of_twins = |options: &TwinOptions| {
        let twins = Twins::new(scan_of(scan.heights_m().clone()), "map", options).unwrap();
        let all: Vec<(f64, f64)> = (0..12).map(|index| diagonals(&twins.draw(index))).collect();
        (all.iter().map(|d| d.0).sum::<f64>() / 12.0, all.iter().map(|d| d.1).sum::<f64>() / 12.0)
    };
    let (model_along, model_across) = mean_of_twins(&options);
    assert!((model_along - model_across).abs() < 0.1, "{model_along} {model_across}");
    options.surface.covariance = CovarianceSource::Empirical;
    let (own_along, own_across) = mean_of_twins(&options);
    assert!((own_along - along).abs() < 0.1 && (own_across - across).abs() < 0.1, "{own_along} {own_across}");
}

#[test]
#[ignore = "slow"]
fn grooves_that_run_through_the_scan_run_through_its_twins() {
    let grooves = Covariance::new(CorrelationModel::SquaredExponential, 1e-6, 3e-6, 300e-6).unwrap();
    let rough = Covariance::isotropic(CorrelationModel::Matern { nu: 1.5 }, 1.0, 2e-6).unwrap();
    let mut heights = map_of(&grooves, &Marginal::STANDARD_NORMAL, (128, 128), 21);
    heights.scaled_add(0.1, &map_of(&rough, &Marginal::STANDARD_NORMAL, (128, 128), 22));
    for holes in [false, true] {
        if holes {
            heights.iter_mut().step_by(97).for_each(|z| *z = f64::NAN);
        }
        let twins = Twins::new(scan_of(heights.clone()), "map", &TwinOptions::new(3)).unwrap();
        let comparison = compare(&twins, 39);
        // The covariance that is reported is the one that was drawn: not tapered.
        assert_eq!(comparison.model.covariance.as_ref().unwrap().empirical.unwrap().taper_change, 0.0);
        // Few of the wavenumbers across the grooves are independent.
        for (name, curve) in comparison.curves.iter().filter(|(name, _)| name.starts_with("psd")) {
            assert!(curve.inside_share.unwrap() > 0.85, "{name}, holes {holes}: {curve:?}");
        }
        assert!(!comparison.warnings.iter().any(|warning| warning.contains("spectrum")), "{:?}", comparison.warnings);
    }
}

#[test]
#[ignore = "slow"]
fn a_scan_too_short_for_its_own_covariance_gets_twins_of_a_model_and_a_warning() {
    // A map of a few lengths from which no form is removed.
    let heights = map_of(&smooth(16e-6, 16e-6), &Marginal::STANDARD_NORMAL, (40, 40), 3);
    let mut options = TwinOptions::new(1);
    options.surface.level = Level::None;
    let twins = Twins::new(scan_of(heights.clone()), "map", &options).unwrap();
    assert_ne!(twins.model.covariance.as_ref().unwrap().model, "empirical");
    assert!(twins.warnings().iter().any(|warning| warning.contains("independent patches")), "{:?}", twins.warnings());
    // Without the fallback it is an error.
    options.allow_model = false;
    assert!(matches!(
        Twins::new(scan_of(heights), "map", &options),
        Err(StudyError::Surface(SurfaceModelError::Empirical(_)))
    ));
}

#[test]
#[ignore = "slow"]
fn twins_of_a_measured_map_have_its_height_without_their_form_and_its_correlation() {
    // A map of few correlation lengths: the plane removes about a tenth of the variance.
    let covariance = smooth(9e-6, 9e-6);
    let (mut squares, mut lengths, mut shares) = (Vec::new(), Vec::new(), Vec::new());
    for index in 0..24 {
        let heights = map_of(&covariance, &Marginal::STANDARD_NORMAL, (64, 64), 100 + index);
        let options = TwinOptions { families: vec![CorrelationFamily::SquaredExponential], ..plain(index) };
        let twins = Twins::new(scan_of(heights), "map", &options).unwrap();
        let (comparison, tables) = compare_with_tables(&twins, 8);
        let table = &tables[0].1;
        let target = statistic(&comparison, "Sq_m").target.unwrap();
        let mean_square = table.column("Sq_m").unwrap().iter().map(|sq| sq * sq).sum::<f64>() / 8.0;
        squares.push(mean_square / (target * target));
        let length = statistic(&comparison, "correlation_length_x_m");
        lengths.push(length.mean.unwrap() / length.target.unwrap());
        shares.push(comparison.model.form_share.unwrap());
    }
    let (share, _) = mean_and_error(&shares);
    let (square, error) = mean_and_error(&squares);
    // The test is sensitive: without the correction for the form the squares would be short by that fraction.
    assert!(share > 5.0 * error, "share {share}, standard error {error}");
    assert!((square - 1.0).abs() < 4.0 * error, "{square} ± {error}");
    // The fit accounts for the removed mean, but not for the plane, which shortens correlations a little further.
    let (length, error) = mean_and_error(&lengths);
    assert!((length - 1.0).abs() < 4.0 * error + 0.05, "{length} ± {error}");
}

#[test]
#[ignore = "slow"]
fn a_twin_depends_on_seed_and_number_alone() {
    let covariance = smooth(4e-6, 3e-6);
    let heights = map_of(&covariance, &Marginal::STANDARD_NORMAL, (32, 40), 0);
    let twins = |seed| Twins::new(scan_of(heights.clone()), "map", &plain(seed)).unwrap();
    let (one, same, other) = (twins(1), twins(1), twins(2));
    assert_eq!(one.draw(5), same.draw(5));
    assert_ne!(one.draw(5), one.draw(6));
    assert_ne!(one.draw(5), other.draw(5));
    // Neither the number of twins nor the number of threads changes a twin.
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let crowd = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let few = alone.install(|| compare_with_tables(&one, 4));
    let many = crowd.install(|| compare_with_tables(&same, 7));
    let bytes = |(comparison, tables): &(Comparison, TwinTables)| {
        let tables = tables.iter().map(|(_, table)| table.to_csv().unwrap()).collect::<Vec<_>>();
        (serde_json::to_string(comparison).unwrap(), tables)
    };
    assert_eq!(bytes(&many), bytes(&alone.install(|| compare_with_tables(&one, 7))));
    for ((name, few), (_, many)) in few.1[0].1.columns().iter().zip(many.1[0].1.columns()) {
        assert!(few.iter().zip(many).all(|(a, b)| a.to_bits() == b.to_bits()), "{name}");
    }
    let kept = std::sync::Mutex::new(Vec::new());
    let keep = |index: usize, twin: &HeightMap| {
        assert_eq!(twin, &one.draw(index as u64));
        kept.lock().unwrap().push(index);
        Ok::<(), StudyError>(())
    };
    one.compare(4, &Silent, keep).unwrap();
    let mut kept = kept.into_inner().unwrap();
    kept.sort_unstable();
    assert_eq!(kept, [0, 1, 2, 3]);
}

#[test]
#[ignore = "slow"]
fn a_skewed_marginal_is_reproduced_and_a_normal_one_lies_outside() {
    let covariance = smooth(3e-6, 3e-6);
    let law = Marginal::lognormal(0.0, 0.5, 0.0).unwrap();
    let heights = map_of(&covariance, &law, (96, 96), 3);
    let with = |marginal: &str| {
        let mut options = TwinOptions::new(4);
        options.surface.marginal = marginal.into();
        compare(&Twins::new(scan_of(heights.clone()), "map", &options).unwrap(), 39)
    };
    let measured = with("measured");
    // e^{σ²}: skewness (e^{σ²} + 2) √(e^{σ²} − 1) = 1.75 in the limit of a large map.
    assert!(statistic(&measured, "Ssk").target.unwrap() > 1.0);
    for name in ["Sq_m", "Ssk", "Sku", "Sk_m", "Spk_m", "Svk_m", "Sdq", "Sal_m", "correlation_length_x_m"] {
        let found = statistic(&measured, name);
        assert_eq!(found.inside, Some(true), "{name}: {found:?}");
    }
    let normal = with("normal");
    let skewness = statistic(&normal, "Ssk");
    assert!(skewness.inside == Some(false) && skewness.mean.unwrap().abs() < 0.2, "{skewness:?}");
    let outside: Vec<&str> = normal.outside().collect();
    assert!(outside.contains(&"Ssk") && outside.contains(&"Sku"), "{outside:?}");
    assert!(normal.warnings.iter().any(|w| w.contains("Ssk (")), "{:?}", normal.warnings);
}

#[test]
#[ignore = "slow"]
fn missing_points_are_masked_in_the_comparison_only() {
    let covariance = smooth(4e-6, 3e-6);
    let mut heights = map_of(&covariance, &Marginal::STANDARD_NORMAL, (48, 56), 5);
    heights.indexed_iter_mut().filter(|((r, c), _)| (r * 7 + c * 3) % 11 == 0).for_each(|(_, z)| *z = f64::NAN);
    let missing = heights.iter().filter(|z| z.is_nan()).count();
    let twins = Twins::new(scan_of(heights), "map", &plain(6)).unwrap();
    assert_eq!(twins.draw(0).missing_points(), 0);
    let prepared_twin = twins.prepared_twin(&twins.draw(0)).unwrap();
    assert_eq!((prepared_twin.map.missing_points(), prepared_twin.outliers), (missing, 0));
    let plane = Preparation::default().apply(prepared_twin.map.clone()).unwrap().map;
    let largest = plane.present_m().zip(prepared_twin.map.present_m()).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(largest < 1e-18, "the form is gone: {largest:e}");
    let comparison = compare(&twins, 8);
    assert_eq!(comparison.target.missing_points, missing);
    assert!(comparison.assumptions.iter().any(|sentence| sentence.contains(&missing.to_string())));
    assert!(comparison.twins.iter().all(|(_, statistic)| statistic.defined <= 8));
}

#[test]
#[ignore = "slow"]
fn twins_are_not_filtered_a_second_time() {
    // A Gaussian filter turns a squared exponential covariance into another one: ℓ² grows by 2 ln 2 (λc/π)², and σ² falls
    // as ℓ⁻², so that slopes σ/ℓ fall as ℓ⁻². Here 9 µm² become 23 µm², and by a second pass 37 µm².
    let heights = map_of(&smooth(3e-6, 3e-6), &Marginal::STANDARD_NORMAL, (160, 160), 8);
    let mut options = plain(9);
    options.surface.s_filter = Some(Length(10e-6));
    let twins = Twins::new(scan_of(heights), "map", &options).unwrap();
    let comparison = compare(&twins, 10);
    let again = Preparation { s_filter_m: Some(10e-6), ..Preparation::default() };
    let twice: Vec<f64> = (0..10)
        .map(|index| {
            let prepared = again.apply(twins.draw(index)).unwrap();
            MapStatistics::new(&prepared).unwrap().parameters.sdq.unwrap()
        })
        .collect();
    let slope = statistic(&comparison, "Sdq");
    let (target, once, twice) = (slope.target.unwrap(), slope.mean.unwrap(), mean_and_error(&twice).0);
    assert!((once / target - 1.0).abs() < 0.05 && slope.inside == Some(true), "{once} of {target}");
    let wanted = (9.0 + 14.05) / (9.0 + 2.0 * 14.05);
    assert!((twice / target - wanted).abs() < 0.06, "{twice} of {target}, not {wanted}");
    assert!(comparison.assumptions.iter().any(|sentence| sentence.contains("not filtered again")));
}

#[test]
#[ignore = "slow"]
fn twins_of_another_size_are_drawn_with_a_warning() {
    let covariance = smooth(4e-6, 3e-6);
    let heights = map_of(&covariance, &Marginal::STANDARD_NORMAL, (40, 40), 10);
    let with = |points, size_m| {
        let options = TwinOptions { points, size_m, ..plain(11) };
        Twins::new(scan_of(heights.clone()), "map", &options)
    };
    let wide = with(Some([80, 50]), None).unwrap();
    assert_eq!((wide.grid().nx(), wide.grid().ny(), wide.grid().dx_m()), (80, 50, PITCH_M));
    let comparison = compare(&wide, 3);
    assert!(comparison.warnings.iter().any(|w| w.contains("80 × 50 points")), "{:?}", comparison.warnings);
    assert_eq!(comparison.points, [80, 50]);
    let fine = with(Some([80, 80]), Some([40e-6, 40e-6])).unwrap();
    assert!((fine.grid().dx_m() / 0.5e-6 - 1.0).abs() < 1e-12);
    let small = with(None, Some([20.4e-6, 10e-6])).unwrap();
    assert_eq!((small.grid().nx(), small.grid().ny()), (20, 10));
    // The underlying field has the same height on every other grid: the variance of the form depends on the scan's grid.
    for other in [&fine, &small] {
        assert!((other.model.rms_height_m / wide.model.rms_height_m - 1.0).abs() < 0.02);
    }
    assert!(matches!(with(Some([1, 40]), None), Err(StudyError::Grid { .. })));
}

#[test]
fn a_flat_scan_an_invalid_distribution_and_cancellation_are_errors() {
    let flat = Twins::new(scan_of(Array2::from_elem((16, 16), 2e-6)), "flat", &TwinOptions::new(1));
    assert_eq!(flat.err().unwrap().kind(), crate::study::FailureKind::Input);
    let covariance = smooth(4e-6, 3e-6);
    let heights = map_of(&covariance, &Marginal::STANDARD_NORMAL, (32, 32), 12);
    let mut options = TwinOptions::new(1);
    options.surface.marginal = "gamma:2".into();
    let error = Twins::new(scan_of(heights.clone()), "map", &options).err().unwrap();
    assert_eq!(error.kind(), crate::study::FailureKind::Configuration);

    let twins = Twins::new(scan_of(heights), "map", &plain(1)).unwrap();
    let stopped = twins.compare(3, &AlwaysCancelled, |_, _| Ok::<(), StudyError>(()));
    assert!(matches!(stopped, Err(TwinError::Study(StudyError::Cancelled(_)))));
    let full = twins.compare(3, &Silent, |_, _| Err("the disk is full"));
    assert!(matches!(full, Err(TwinError::Keep("the disk is full"))));
    let single = compare(&twins, 1);
    assert_eq!((single.band_method, single.compared), (BandMethod::None, 0));
    assert!(single.twins.iter().all(|(_, statistic)| statistic.band.is_none() && statistic.std.is_none()));
}
