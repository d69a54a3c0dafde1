//! The random surface fitted to the measured one: its covariance, its distribution, its expansion.

use asperity_results::{CovarianceCandidateResult, CovarianceResult, EmpiricalCovariance, LawResult, SurfaceResult};

use super::DataTable;
use super::cells::{DASH, plain, yes_or_no};
use crate::format::Dimension;

/// Returns the random surface as rows of name and value.
pub(super) fn table(surface: &SurfaceResult) -> DataTable {
    let expansion = match &surface.karhunen_loeve {
        None => vec![("Karhunen–Loève".to_owned(), DASH.to_owned())],
        Some(found) => vec![
            ("Karhunen–Loève · captured slope variance".to_owned(), plain(found.captured_slope_variance, 5)),
            ("Karhunen–Loève · captured variance".to_owned(), plain(found.captured_variance, 5)),
            ("Karhunen–Loève · modes".to_owned(), found.modes.to_string()),
        ],
    };
    let covariance = surface.covariance.iter().flat_map(covariance);
    let rows = covariance.chain(marginal(&surface.marginal)).chain(expansion).map(|(key, value)| vec![key, value]);
    DataTable::new("Random surface", &["Property", "Value"], rows.collect(), "results.json")
}

/// Returns the meaning of the length of a covariance model.
pub(crate) fn length_in_words(model: &str) -> &'static str {
    match model {
        "matern" => "scale of the model",
        "self_affine" => "roll-off length",
        _ => "to 1/e",
    }
}

/// Returns the name of a covariance model, generator or distribution for readers.
pub(crate) fn in_words(name: &str) -> String {
    match name {
        "matern" => "Matérn".into(),
        "self_affine" => "self-affine".into(),
        "karhunen_loeve" => "Karhunen–Loève".into(),
        "weierstrass_mandelbrot" => "Weierstrass–Mandelbrot".into(),
        "johnson_su" => "Johnson SU".into(),
        "johnson_sb" => "Johnson SB".into(),
        "johnson_sl" => "Johnson SL".into(),
        "johnson_sn" => "Johnson SN".into(),
        other => other.replace('_', " "),
    }
}

fn covariance(found: &CovarianceResult) -> Vec<(String, String)> {
    let length = length_in_words(&found.model);
    let named = [
        ("standard deviation".to_owned(), Dimension::Length, Some(found.std_m)),
        (format!("length along x ({length})"), Dimension::Length, Some(found.length_x_m)),
        (format!("length along y ({length})"), Dimension::Length, Some(found.length_y_m)),
        ("correlation length along x, to 1/e".to_owned(), Dimension::Length, Some(found.decay_length_x_m)),
        ("correlation length along y, to 1/e".to_owned(), Dimension::Length, Some(found.decay_length_y_m)),
        ("smoothness ν".to_owned(), Dimension::None, found.smoothness),
        ("Hurst exponent".to_owned(), Dimension::None, found.hurst),
        ("misfit, rms of ln(measured/model spectral density)".to_owned(), Dimension::None, found.misfit),
        (
            "Sdq of random maps over Sdq of the scan, within the reliable band".to_owned(),
            Dimension::None,
            found.slope_ratio,
        ),
        ("S-filter at the end of that band".to_owned(), Dimension::Length, found.slope_cutoff_m),
    ];
    let mut rows = vec![("covariance".to_owned(), in_words(&found.model))];
    rows.extend(named.into_iter().filter_map(|(name, dimension, value)| {
        Some((format!("covariance · {name}"), dimension.show_interval(value?, None)))
    }));
    let candidate = |tried: &CovarianceCandidateResult| {
        format!("{} ({}; {})", in_words(&tried.model), plain(tried.misfit, 3), plain(tried.slope_ratio, 3))
    };
    let candidates: Vec<String> = found.candidates.iter().map(candidate).collect();
    if !candidates.is_empty() {
        rows.push(("covariance · tried, with misfit and ratio of Sdq".to_owned(), candidates.join(", ")));
    }
    rows.extend(found.empirical.iter().flat_map(empirical));
    rows
}

/// Returns the changes that made the scan's own autocorrelation a covariance, in the order of the names.
fn empirical(found: &EmpiricalCovariance) -> Vec<(String, String)> {
    let length = |metre| Dimension::Length.show_interval(metre, None);
    let rows = [
        ("clipped variance", plain(found.clipped_variance, 5)),
        ("clipping change", plain(found.clipping_change, 5)),
        ("decayed x", yes_or_no(found.decayed_x).into()),
        ("decayed y", yes_or_no(found.decayed_y).into()),
        ("mean share", plain(found.mean_share, 5)),
        ("reliable x", length(found.reliable_x_m)),
        ("reliable y", length(found.reliable_y_m)),
        ("standard error", plain(found.standard_error, 5)),
        ("taper change", plain(found.taper_change, 5)),
    ];
    rows.map(|(name, value)| (format!("covariance · empirical · {name}"), value)).into()
}

/// Returns a distribution of heights with its parameters; those that are heights are in metre.
fn marginal(fit: &LawResult) -> Vec<(String, String)> {
    let mut rows = vec![("marginal distribution".to_owned(), in_words(&fit.name))];
    rows.extend(fit.parameters.iter().map(|(key, value)| {
        let (meaning, dimension) = parameter(&fit.name, key);
        (format!("marginal distribution · {meaning}"), dimension.show(*value))
    }));
    rows
}

/// Returns the meaning and the dimension of a parameter of a distribution of heights.
fn parameter(distribution: &str, key: &str) -> (String, Dimension) {
    let (meaning, dimension) = match (distribution, key) {
        (_, "mean") => ("mean", Dimension::Length),
        (_, "std") => ("standard deviation", Dimension::Length),
        ("lognormal", "mu") => ("µ, mean of the logarithm of z − shift in metre", Dimension::None),
        ("lognormal", "sigma") => ("σ, standard deviation of that logarithm", Dimension::None),
        ("lognormal" | "weibull" | "gamma", "shift") => ("shift, lower end", Dimension::Length),
        ("weibull" | "gamma", "shape") => ("shape", Dimension::None),
        ("weibull" | "gamma", "scale") => ("scale", Dimension::Length),
        ("beta", "a") => ("first shape a", Dimension::None),
        ("beta", "b") => ("second shape b", Dimension::None),
        ("beta", "low") => ("lower end", Dimension::Length),
        ("beta", "high") => ("upper end", Dimension::Length),
        (_, "gamma") => ("γ", Dimension::None),
        (_, "delta") => ("δ", Dimension::None),
        (_, "xi") => ("location ξ", Dimension::Length),
        (_, "lambda") => ("scale λ", Dimension::Length),
        _ => {
            let (name, dimension) = Dimension::of_key(key);
            return (name.replace('_', " "), dimension);
        }
    };
    (meaning.to_owned(), dimension)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value_of(surface: &SurfaceResult, name: &str) -> String {
        let rows = table(surface).rows;
        let found = rows.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("{name}: {rows:?}"));
        found[1].replace('\u{a0}', " ")
    }

    #[test]
    fn parameters_that_are_heights_have_units_and_shapes_have_none() {
        let of = |name: &str, parameters: &[(&str, f64)], wanted: &str| {
            let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
            let marginal = LawResult { name: name.into(), parameters };
            value_of(&SurfaceResult { marginal, ..SurfaceResult::default() }, wanted)
        };
        let beta: [(&str, f64); 4] = [("a", 2.1), ("b", 5.0), ("low", -2e-6), ("high", 5e-6)];
        assert_eq!(of("beta", &beta, "marginal distribution"), "beta");
        assert_eq!(of("beta", &beta, "marginal distribution · first shape a"), "2.1");
        assert_eq!(of("beta", &beta, "marginal distribution · lower end"), "−2 µm");
        assert_eq!(of("beta", &beta, "marginal distribution · upper end"), "5 µm");
        let normal = [("mean", 0.0), ("std", 1e-6)];
        assert_eq!(of("normal", &normal, "marginal distribution · standard deviation"), "1 µm");
        let johnson = [("gamma", 0.2), ("lambda", 3e-7)];
        assert_eq!(of("johnson_su", &johnson, "marginal distribution"), "Johnson SU");
        assert_eq!(of("johnson_su", &johnson, "marginal distribution · scale λ"), "300 nm");
        let weibull = [("shape", 2.0), ("scale", 1e-6)];
        assert_eq!(of("weibull", &weibull, "marginal distribution · shape"), "2");
        assert_eq!(of("weibull", &weibull, "marginal distribution · scale"), "1 µm");
        let lognormal = [("mu", -14.0), ("sigma", 0.5)];
        let logarithm = "marginal distribution · µ, mean of the logarithm of z − shift in metre";
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
        assert_eq!(value_of(&matern, "covariance"), "Matérn");
        assert_eq!(value_of(&matern, "covariance · length along x (scale of the model)"), "20 µm");
        assert_eq!(value_of(&matern, "covariance · correlation length along x, to 1/e"), "30 µm");
        assert_eq!(
            value_of(&matern, "covariance · tried, with misfit and ratio of Sdq"),
            "Matérn (0.012; 1.02), empirical (–; 0.97)"
        );
        assert_eq!(
            value_of(&matern, "covariance · Sdq of random maps over Sdq of the scan, within the reliable band"),
            "1.02"
        );
        assert_eq!(value_of(&matern, "covariance · empirical · reliable x"), "1 µm");
        assert_eq!(value_of(&matern, "Karhunen–Loève"), "–");
        let with = |model: &str| of(CovarianceResult { model: model.into(), length_y_m: 2e-5, ..Default::default() });
        assert_eq!(value_of(&with("self_affine"), "covariance · length along y (roll-off length)"), "20 µm");
        assert_eq!(value_of(&with("exponential"), "covariance · length along y (to 1/e)"), "20 µm");
    }
}
