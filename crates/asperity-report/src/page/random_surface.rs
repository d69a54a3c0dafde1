//! The random surface that stands for the measured one: its covariance, its law, its expansion.

use asperity_results::{CovarianceCandidate, CovarianceResult, EmpiricalCovariance, LawResult, SurfaceResult};

use super::DataTable;
use super::cells::{DASH, plain, yes_or_no};
use crate::format::Dimension;

/// The random surface as rows of name and value.
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
    let rows = covariance.chain(law(&surface.marginal)).chain(expansion).map(|(key, value)| vec![key, value]);
    DataTable::new("Random surface", &["Property", "Value"], rows.collect(), "results.json")
}

/// What the length of a covariance model is.
pub(crate) fn length_in_words(model: &str) -> &'static str {
    match model {
        "matern" => "scale of the model",
        "self_affine" => "roll-off length",
        _ => "to 1/e",
    }
}

/// The name of a covariance model, generator or law as a reader calls it.
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
            "Sdq of maps drawn like the scan over the scan's, within the band".to_owned(),
            Dimension::None,
            found.slope_ratio,
        ),
        ("S-filter at the end of that band".to_owned(), Dimension::Length, found.slope_cutoff_m),
    ];
    let mut rows = vec![("covariance".to_owned(), in_words(&found.model))];
    rows.extend(named.into_iter().filter_map(|(name, dimension, value)| {
        Some((format!("covariance · {name}"), dimension.show_interval(value?, None)))
    }));
    let candidate = |tried: &CovarianceCandidate| {
        format!("{} ({}; {})", in_words(&tried.model), plain(tried.misfit, 3), plain(tried.slope_ratio, 3))
    };
    let candidates: Vec<String> = found.candidates.iter().map(candidate).collect();
    if !candidates.is_empty() {
        rows.push(("covariance · tried, with misfit and ratio of Sdq".to_owned(), candidates.join(", ")));
    }
    rows.extend(found.empirical.iter().flat_map(empirical));
    rows
}

/// What made the scan's own autocorrelation a covariance, in the order of the names.
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

/// A law of heights with its parameters, which are in metre where they are heights.
fn law(law: &LawResult) -> Vec<(String, String)> {
    let mut rows = vec![("marginal law".to_owned(), in_words(&law.name))];
    rows.extend(law.parameters.iter().map(|(key, value)| {
        let (meaning, dimension) = parameter(&law.name, key);
        (format!("marginal law · {meaning}"), dimension.show(*value))
    }));
    rows
}

/// What a parameter of a law of heights means, and what it measures.
fn parameter(law: &str, key: &str) -> (String, Dimension) {
    let (meaning, dimension) = match (law, key) {
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

    fn said(surface: &SurfaceResult, name: &str) -> String {
        let rows = table(surface).rows;
        let found = rows.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("{name}: {rows:?}"));
        found[1].replace('\u{a0}', " ")
    }

    #[test]
    fn heights_among_the_parameters_of_a_law_have_their_unit_and_shapes_none() {
        let of = |name: &str, parameters: &[(&str, f64)], wanted: &str| {
            let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
            let marginal = LawResult { name: name.into(), parameters };
            said(&SurfaceResult { marginal, ..SurfaceResult::default() }, wanted)
        };
        let beta: [(&str, f64); 4] = [("a", 2.1), ("b", 5.0), ("low", -2e-6), ("high", 5e-6)];
        assert_eq!(of("beta", &beta, "marginal law"), "beta");
        assert_eq!(of("beta", &beta, "marginal law · first shape a"), "2.1");
        assert_eq!(of("beta", &beta, "marginal law · lower end"), "−2 µm");
        assert_eq!(of("beta", &beta, "marginal law · upper end"), "5 µm");
        let normal = [("mean", 0.0), ("std", 1e-6)];
        assert_eq!(of("normal", &normal, "marginal law · standard deviation"), "1 µm");
        let johnson = [("gamma", 0.2), ("lambda", 3e-7)];
        assert_eq!(of("johnson_su", &johnson, "marginal law"), "Johnson SU");
        assert_eq!(of("johnson_su", &johnson, "marginal law · scale λ"), "300 nm");
        let weibull = [("shape", 2.0), ("scale", 1e-6)];
        assert_eq!(of("weibull", &weibull, "marginal law · shape"), "2");
        assert_eq!(of("weibull", &weibull, "marginal law · scale"), "1 µm");
        let lognormal = [("mu", -14.0), ("sigma", 0.5)];
        let logarithm = "marginal law · µ, mean of the logarithm of z − shift in metre";
        assert_eq!(of("lognormal", &lognormal, logarithm), "−14");
    }

    #[test]
    fn the_length_of_a_model_says_what_it_is() {
        let of = |covariance| SurfaceResult { covariance: Some(covariance), ..SurfaceResult::default() };
        let candidate =
            |model: &str, misfit, slope_ratio| CovarianceCandidate { model: model.into(), misfit, slope_ratio };
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
        assert_eq!(said(&matern, "covariance"), "Matérn");
        assert_eq!(said(&matern, "covariance · length along x (scale of the model)"), "20 µm");
        assert_eq!(said(&matern, "covariance · correlation length along x, to 1/e"), "30 µm");
        assert_eq!(
            said(&matern, "covariance · tried, with misfit and ratio of Sdq"),
            "Matérn (0.012; 1.02), empirical (–; 0.97)"
        );
        assert_eq!(
            said(&matern, "covariance · Sdq of maps drawn like the scan over the scan's, within the band"),
            "1.02"
        );
        assert_eq!(said(&matern, "covariance · empirical · reliable x"), "1 µm");
        assert_eq!(said(&matern, "Karhunen–Loève"), "–");
        let with = |model: &str| of(CovarianceResult { model: model.into(), length_y_m: 2e-5, ..Default::default() });
        assert_eq!(said(&with("self_affine"), "covariance · length along y (roll-off length)"), "20 µm");
        assert_eq!(said(&with("exponential"), "covariance · length along y (to 1/e)"), "20 µm");
    }
}
