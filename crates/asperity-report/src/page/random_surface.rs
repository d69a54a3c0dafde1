//! The random surface fitted to the measured one: its covariance, its distribution, its expansion.

use asperity_results::{CovarianceCandidateResult, CovarianceResult, EmpiricalCovariance, SurfaceResult};

use crate::cells::{percent, plain, yes_or_no};
use crate::format::Dimension;
use crate::page::data_table::DataTable;
use crate::run::RESULTS;
use crate::words::{TO_1_E, in_words, length_in_words, meaning};

/// Returns the random surface: covariance, distribution of the heights, expansion.
pub(super) fn table(surface: &SurfaceResult) -> DataTable {
    let mut rows = Vec::new();
    if let Some(found) = &surface.covariance {
        rows.extend(covariance(found).chain(found.empirical.iter().flat_map(empirical)));
    }
    let fit = &surface.marginal;
    rows.extend([("Marginal distribution".into(), String::new()), ("distribution".into(), in_words(&fit.name))]);
    rows.extend(fit.parameters.iter().map(|(key, value)| {
        let (meaning, has_unit) = meaning(&fit.name, key);
        let dimension = if has_unit { Dimension::Length } else { Dimension::None };
        (if key == "mu" { format!("{meaning}, in metre") } else { meaning }, dimension.show(*value))
    }));
    rows.extend(surface.karhunen_loeve.iter().flat_map(|found| {
        [
            ("Karhunen–Loève expansion".into(), String::new()),
            ("modes".into(), found.modes.to_string()),
            ("fraction of the variance".into(), plain(found.captured_variance, 4)),
            ("fraction of the slope variance".into(), plain(found.captured_slope_variance, 4)),
        ]
    }));
    DataTable::properties("Random surface", rows, RESULTS)
}

/// Returns the model with its lengths and exponents, and the models that were tried.
fn covariance(found: &CovarianceResult) -> impl Iterator<Item = (String, String)> {
    let length = length_in_words(&found.model);
    let metre = |value| Some(Dimension::Length.show(value));
    let number = |value: Option<f64>| value.map(|value| plain(value, 4));
    // Most models have the length to 1/e as their own.
    let decay = |value| metre(value).filter(|_| length != TO_1_E);
    let tried = |tried: &CovarianceCandidateResult| {
        format!("{} ({}; {})", in_words(&tried.model), plain(tried.misfit, 3), plain(tried.slope_ratio, 3))
    };
    let candidates = found.candidates.iter().map(tried).collect::<Vec<_>>().join(", ");
    let rows = [
        ("Covariance".into(), Some(String::new())),
        ("model".into(), Some(in_words(&found.model))),
        ("standard deviation".into(), metre(found.std_m)),
        (format!("length along x ({length})"), metre(found.length_x_m)),
        (format!("length along y ({length})"), metre(found.length_y_m)),
        (format!("length along x ({TO_1_E})"), decay(found.decay_length_x_m)),
        (format!("length along y ({TO_1_E})"), decay(found.decay_length_y_m)),
        ("smoothness ν".into(), number(found.smoothness)),
        ("Hurst exponent".into(), number(found.hurst)),
        ("misfit, rms of ln(measured/model spectral density)".into(), number(found.misfit)),
        ("Sdq of random maps over Sdq of the scan, within the reliable band".into(), number(found.slope_ratio)),
        ("cut-off of the S-filter of both Sdq".into(), found.slope_cutoff_m.and_then(metre)),
        ("models tried (misfit; ratio of Sdq)".into(), Some(candidates).filter(|text| !text.is_empty())),
    ];
    rows.into_iter().filter_map(|(name, value)| Some((name, value?)))
}

/// Returns the changes that made the scan's own autocorrelation a covariance.
fn empirical(found: &EmpiricalCovariance) -> [(String, String); 9] {
    let length = |metre| Dimension::Length.show(metre);
    let rows = [
        ("estimate used as it is up to the lag along x", length(found.reliable_x_m)),
        ("estimate used as it is up to the lag along y", length(found.reliable_y_m)),
        ("correlation decays within the map along x", yes_or_no(found.decayed_x).into()),
        ("correlation decays within the map along y", yes_or_no(found.decayed_y).into()),
        ("standard error at lags without correlation", plain(found.standard_error, 3)),
        ("fraction of the variance removed with the mean", percent(found.mean_share, 3)),
        ("largest change of a lag by the taper", plain(found.taper_change, 3)),
        ("fraction of the variance in clipped negative spectral values", percent(found.clipped_variance, 3)),
        ("largest change of a lag by the clipping", plain(found.clipping_change, 3)),
    ];
    rows.map(|(name, value)| (name.to_owned(), value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_results::DistributionResult;

    fn value_of(surface: &SurfaceResult, name: &str) -> String {
        let rows = table(surface).rows;
        let found = rows.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("{name}: {rows:?}"));
        found[1].replace('\u{a0}', " ")
    }

    #[test]
    fn parameters_that_are_heights_have_units_and_shapes_have_none() {
        let of = |name: &str, parameters: &[(&str, f64)], wanted: &str| {
            let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
            let marginal = DistributionResult { name: name.into(), parameters };
            value_of(&SurfaceResult { marginal, ..SurfaceResult::default() }, wanted)
        };
        let beta: [(&str, f64); 4] = [("a", 2.1), ("b", 5.0), ("low", -2e-6), ("high", 5e-6)];
        assert_eq!(of("beta", &beta, "distribution"), "Beta");
        assert_eq!(of("beta", &beta, "first shape a"), "2.1");
        assert_eq!(of("beta", &beta, "lower end"), "−2 µm");
        assert_eq!(of("beta", &beta, "upper end"), "5 µm");
        let normal = [("mean", 0.0), ("std", 1e-6)];
        assert_eq!(of("normal", &normal, "standard deviation"), "1 µm");
        let johnson = [("gamma", 0.2), ("lambda", 3e-7)];
        assert_eq!(of("johnson_su", &johnson, "distribution"), "Johnson SU");
        assert_eq!(of("johnson_su", &johnson, "scale λ"), "300 nm");
        let weibull = [("shape", 2.0), ("scale", 1e-6)];
        assert_eq!(of("weibull", &weibull, "shape"), "2");
        assert_eq!(of("weibull", &weibull, "scale"), "1 µm");
        let lognormal = [("mu", -14.0), ("sigma", 0.5)];
        let logarithm = "mean of the logarithm of the excess over the shift, in metre";
        assert_eq!(of("lognormal", &lognormal, logarithm), "−14");
    }

    #[test]
    fn the_length_of_a_model_has_its_meaning() {
        let of = |covariance| SurfaceResult { covariance: Some(covariance), ..SurfaceResult::default() };
        let candidate =
            |model: &str, misfit, slope_ratio| CovarianceCandidateResult { model: model.into(), misfit, slope_ratio };
        let matern = of(CovarianceResult {
            model: "matern".into(),
            length_x_m: 2e-5,
            decay_length_x_m: 3e-5,
            smoothness: Some(1.5),
            misfit: Some(0.012),
            candidates: vec![candidate("matern", Some(0.012), Some(1.02)), candidate("empirical", None, Some(0.97))],
            slope_ratio: Some(1.02),
            empirical: Some(EmpiricalCovariance { reliable_x_m: 1e-6, ..EmpiricalCovariance::default() }),
            ..CovarianceResult::default()
        });
        assert_eq!(value_of(&matern, "model"), "Matérn");
        assert_eq!(value_of(&matern, "length along x (scale of the model)"), "20 µm");
        assert_eq!(value_of(&matern, "length along x (to 1/e)"), "30 µm");
        assert_eq!(
            value_of(&matern, "models tried (misfit; ratio of Sdq)"),
            "Matérn (0.012; 1.02), empirical (–; 0.97)"
        );
        assert_eq!(value_of(&matern, "Sdq of random maps over Sdq of the scan, within the reliable band"), "1.02");
        assert_eq!(value_of(&matern, "estimate used as it is up to the lag along x"), "1 µm");
        assert!(table(&matern).rows.iter().all(|row| row[0] != "Karhunen–Loève expansion"));
        let with = |model: &str| of(CovarianceResult { model: model.into(), length_y_m: 2e-5, ..Default::default() });
        assert_eq!(value_of(&with("self_affine"), "length along y (roll-off length)"), "20 µm");
        assert_eq!(value_of(&with("exponential"), "length along y (to 1/e)"), "20 µm");
    }
}
