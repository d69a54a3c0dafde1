//! Round trip: generate maps, estimate their spectra and fit the known model.

use std::f64::consts::{PI, TAU};

use super::SpectralField;
use crate::RandomSurface;
use asperity_base::correlation::{
    Axis, BlockSpectrum, CorrelationFamily, CorrelationModel, Covariance, CovarianceFit, CovarianceFits, FitWarning,
    RadialSpectrum, SpectrumRoute, fit_covariance, profile_spectrum, radial_spectrum,
};
use asperity_base::map::{Grid, HeightMap};
use asperity_base::random;

/// Returns a map of `covariance` on a quarter of a periodic domain, so that it is not periodic, with a fraction of
/// points missing.
fn sample(covariance: &Covariance, grid: Grid, missing: f64, index: u64) -> HeightMap {
    let field = SpectralField::free(covariance, grid).unwrap();
    let mut stream = random::stream(21, "fit", index);
    let xi = random::standard_normal(&mut stream, field.xi_len());
    let mask = random::standard_normal(&mut stream, grid.points());
    let cut = asperity_base::distribution::standard_normal_quantile(missing);
    let mut heights = field.generate(&xi).heights_m().clone();
    heights.iter_mut().zip(mask).filter(|(_, m)| *m < cut).for_each(|(z, _)| *z = f64::NAN);
    HeightMap::new(grid, heights).unwrap()
}

/// Fits models to the spectrum of a map of this standard deviation.
fn fitted(map: &HeightMap, std_m: f64, families: &[CorrelationFamily]) -> CovarianceFits {
    fit_covariance(&[&BlockSpectrum::new(map).unwrap()], std_m, families).unwrap()
}

/// Returns the mean and standard error of a list.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt())
}

/// Fits the known model to several maps. The mean of each parameter must lie within four standard errors, plus 2 % for
/// the curvature of the estimator.
fn recovers(known: Covariance, missing: f64) {
    let family = match known.model() {
        CorrelationModel::SquaredExponential => CorrelationFamily::SquaredExponential,
        CorrelationModel::Exponential => CorrelationFamily::Exponential,
        CorrelationModel::Matern { .. } => CorrelationFamily::Matern,
        CorrelationModel::SelfAffine { .. } => CorrelationFamily::SelfAffine,
    };
    let grid = Grid::new(160, 128, 1.0, 1.0).unwrap();
    let name = known.model().name();
    let fits: Vec<CovarianceFit> = (0..12)
        .map(|index| {
            let map = sample(&known, grid, missing, index);
            fitted(&map, known.std_m(), &[family]).named(name).unwrap().clone()
        })
        .collect();
    let shape = |covariance: &Covariance| match covariance.model() {
        CorrelationModel::Matern { nu } => nu,
        CorrelationModel::SelfAffine { hurst } => hurst,
        _ => 1.0,
    };
    let values =
        |covariance: &Covariance| [("length x", covariance.length_x_m()), ("length y", covariance.length_y_m())];
    for (i, (label, wanted)) in values(&known).into_iter().enumerate() {
        let (mean, error) = mean_and_error(&fits.iter().map(|fit| values(&fit.covariance)[i].1).collect::<Vec<_>>());
        assert!(
            (mean - wanted).abs() < 4.0 * error + 0.02 * wanted,
            "{name} {label}: {mean} ± {error}, known {wanted}"
        );
    }
    let (mean, error) = mean_and_error(&fits.iter().map(|fit| shape(&fit.covariance)).collect::<Vec<_>>());
    assert!((mean - shape(&known)).abs() < 4.0 * error + 0.02, "{name} shape: {mean} ± {error}");
}

#[test]
#[ignore = "slow"]
fn known_covariances_are_recovered() {
    recovers(Covariance::new(CorrelationModel::SquaredExponential, 2.0, 5.0, 5.0).unwrap(), 0.0);
    recovers(Covariance::new(CorrelationModel::Exponential, 2.0, 5.0, 5.0).unwrap(), 0.0);
    recovers(Covariance::new(CorrelationModel::SelfAffine { hurst: 0.75 }, 2.0, 4.0, 4.0).unwrap(), 0.0);
    recovers(Covariance::new(CorrelationModel::Matern { nu: 4.0 }, 2.0, 4.0, 4.0).unwrap(), 0.0);
}

#[test]
#[ignore = "slow"]
fn known_covariances_are_recovered_with_a_tenth_of_the_points_missing() {
    recovers(Covariance::new(CorrelationModel::SquaredExponential, 2.0, 5.0, 5.0).unwrap(), 0.1);
    recovers(Covariance::new(CorrelationModel::Matern { nu: 1.5 }, 2.0, 5.0, 5.0).unwrap(), 0.1);
}

#[test]
#[ignore = "slow"]
fn anisotropy_is_recovered() {
    recovers(Covariance::new(CorrelationModel::SquaredExponential, 1.0, 8.0, 3.0).unwrap(), 0.0);
    recovers(Covariance::new(CorrelationModel::Exponential, 1.0, 3.0, 8.0).unwrap(), 0.05);
}

#[test]
#[ignore = "slow"]
fn the_known_family_is_ranked_first_or_not_distinguishable_from_the_first() {
    // Differences of Schwarz's criterion above 10 are very strong evidence: Kass & Raftery, J. Am. Stat. Assoc. 90
    // (1995) 773.
    const VERY_STRONG: f64 = 10.0;
    let grid = Grid::new(256, 256, 1.0, 1.0).unwrap();
    for model in [CorrelationModel::SquaredExponential, CorrelationModel::Exponential] {
        let known = Covariance::new(model, 1.0, 5.0, 5.0).unwrap();
        let mut first = 0;
        for index in 0..5 {
            let fits = fitted(&sample(&known, grid, 0.0, 100 + index), 1.0, CorrelationFamily::ALL);
            let other = if model.name() == "exponential" { "squared_exponential" } else { "exponential" };
            // Both models have two parameters; any other model has three and a larger penalty.
            let [own, other] = [model.name(), other].map(|name| fits.named(name).unwrap().deviance);
            assert!(other - own > VERY_STRONG, "{fits:?}");
            assert!(own - fits.fits[0].deviance < VERY_STRONG + (256.0_f64).ln(), "{fits:?}");
            first += usize::from(fits.best().model() == model);
        }
        // Models of three parameters include the exponential, but the squared exponential only as a limit.
        let wanted = if model == CorrelationModel::SquaredExponential { 5 } else { 4 };
        assert!(first >= wanted, "{model:?}: {first} of 5");
    }
}

#[test]
#[ignore = "slow"]
fn a_correlation_that_does_not_decay_along_an_axis_is_a_warning() {
    let grid = Grid::new(64, 64, 1.0, 1.0).unwrap();
    let ridge = |long: f64| {
        let known = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 4.0, long).unwrap();
        sample(&known, grid, 0.0, 7)
    };
    let fits = fitted(&ridge(400.0), 1.0, CorrelationFamily::ALL);
    let extrapolated =
        |w: &FitWarning| matches!(w, FitWarning::FewLengths { axis: Axis::Y, lengths } if *lengths < 2.0);
    assert!(fits.warnings.iter().any(extrapolated), "{fits:?}");
    assert!(fits.best().length_y_m() > 5.0 * fits.best().length_x_m());
}

/// Compares mean spectra over realisations of a known covariance, with their standard errors, with the model.
fn against_model(missing_fraction: f64, route: SpectrumRoute) {
    let covariance = Covariance::isotropic(CorrelationModel::SelfAffine { hurst: 0.8 }, 2.0, 3.0).unwrap();
    let grid = Grid::new(128, 128, 1.0, 1.0).unwrap();
    let field = SpectralField::periodic(&covariance, grid);
    let spectra: Vec<RadialSpectrum> = (0..24)
        .map(|index| {
            let mut stream = random::stream(11, "radial", index);
            let xi = random::standard_normal(&mut stream, field.xi_len());
            let mask = random::standard_normal(&mut stream, grid.points());
            let cut = asperity_base::distribution::standard_normal_quantile(missing_fraction);
            let mut heights = field.generate(&xi).heights_m().clone();
            heights.iter_mut().zip(mask).filter(|(_, m)| *m < cut).for_each(|(z, _)| *z = f64::NAN);
            radial_spectrum(&HeightMap::new(grid, heights).unwrap()).unwrap()
        })
        .collect();
    assert!(spectra.iter().all(|s| s.route == route));
    // Rings where the model is smooth over the window and aliasing is small.
    for ring in [4, 7, 11, 16] {
        let values: Vec<f64> = spectra.iter().map(|s| s.psd_m4[ring]).collect();
        let mean = values.iter().sum::<f64>() / 24.0;
        let error = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (23.0 * 24.0)).sqrt();
        let wanted = covariance.psd_m4(spectra[0].q_rad_per_m[ring], 0.0);
        // Four standard errors, plus 3 % for the curvature within a ring and window, and the folded tail.
        assert!((mean - wanted).abs() < 4.0 * error + 0.03 * wanted, "ring {ring}: {mean} ± {error}, {wanted}");
    }
}

#[test]
fn the_radial_spectrum_of_a_generated_map_equals_the_model() {
    against_model(0.0, SpectrumRoute::Periodogram);
}

#[test]
fn scattered_missing_points_do_not_change_the_radial_spectrum() {
    // Filled, and too many to be filled.
    against_model(0.05, SpectrumRoute::Periodogram);
    against_model(0.5, SpectrumRoute::MaskedCorrelogram);
}

#[test]
fn profile_spectra_distinguish_the_directions() {
    let covariance = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 4.0, 12.0).unwrap();
    let field = SpectralField::periodic(&covariance, Grid::new(128, 128, 1.0, 1.0).unwrap());
    let count = 30;
    let mut sums = [(0.0, 0.0); 2];
    let bin = 4;
    let q = bin as f64 * TAU / 128.0;
    for index in 0..count {
        let xi = random::standard_normal(&mut random::stream(12, "profiles", index), field.xi_len());
        let map = field.generate(&xi);
        for (sum, axis) in sums.iter_mut().zip([Axis::X, Axis::Y]) {
            let value = profile_spectrum(&map, axis).unwrap().psd_m3[bin];
            sum.0 += value;
            sum.1 += value * value;
        }
    }
    // The expectation of a windowed periodogram: the transform of C times the autocorrelation of the window.
    let window: Vec<f64> = (0..128).map(|i| (PI * (f64::from(i) + 0.5) / 128.0).sin().powi(2)).collect();
    let square: f64 = window.iter().map(|w| w * w).sum();
    let expected = |length: f64| -> f64 {
        (-127_i32..128)
            .map(|lag| {
                let overlap = (0..128_i32).filter(|i| (0..128).contains(&(i + lag)));
                let taper: f64 = overlap.map(|i| window[i as usize] * window[(i + lag) as usize]).sum();
                let image = f64::from(lag.abs().min(128 - lag.abs()));
                (-(image / length).powi(2)).exp() * taper / square * (q * f64::from(lag)).cos()
            })
            .sum()
    };
    for ((sum, square), length) in sums.into_iter().zip([4.0, 12.0]) {
        let mean = sum / count as f64;
        let error = ((square / count as f64 - mean * mean) / (count - 1) as f64).sqrt();
        let wanted = expected(length);
        assert!((mean - wanted).abs() < 4.0 * error, "{mean} ± {error}, wanted {wanted}");
    }
    // Where the spectrum is smooth over the window, that expectation equals the model.
    assert!((expected(4.0) / covariance.profile_psd_x_m3(q) - 1.0).abs() < 0.02);
}

#[test]
#[ignore = "slow"]
fn an_oblique_lay_is_a_warning_and_a_straight_one_is_not() {
    let oblique = |angle: f64| {
        // Random noise elongated along ridges at an angle: a sum of plane waves normal to them.
        let grid = Grid::new(128, 128, 1.0, 1.0).unwrap();
        let mut stream = random::stream(41, "lay", 0);
        let amplitudes = random::standard_normal(&mut stream, 400);
        let map = HeightMap::from_function(grid, |x, y| {
            let (across, along) = (x * angle.cos() + y * angle.sin(), y * angle.cos() - x * angle.sin());
            (0..200)
                .map(|k| {
                    let (q, p) = (0.002 * f64::from(k), 0.02 * f64::from(k % 7 - 3));
                    let phase = q * across + p * along;
                    let k = 2 * k as usize;
                    (amplitudes[k] * phase.cos() + amplitudes[k + 1] * phase.sin()) * (-(4.0 * q).powi(2) / 8.0).exp()
                })
                .sum()
        })
        .unwrap();
        let fits = fitted(&map, 1.0, &[CorrelationFamily::SquaredExponential]);
        fits.warnings.iter().any(|w| matches!(w, FitWarning::ObliqueLay { .. }))
    };
    assert!(oblique(PI / 4.0));
    let straight = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 3.0, 8.0).unwrap();
    let map = sample(&straight, Grid::new(128, 128, 1.0, 1.0).unwrap(), 0.0, 50);
    let fits = fitted(&map, 1.0, CorrelationFamily::ALL);
    assert!(!fits.warnings.iter().any(|w| matches!(w, FitWarning::ObliqueLay { .. })), "{:?}", fits.warnings);
}
