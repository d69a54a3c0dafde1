//! The random surface that stands for the measured one: its covariance, its law, its expansion.

use serde_json::Value;

use super::DataTable;
use super::json::{flattened, plain, shown};
use crate::format::{Dimension, significant};

/// `surface` without the statistics of the scan, as rows of name and value.
pub(super) fn table(rest: &Value) -> DataTable {
    let mut others = rest.clone();
    if let Value::Object(entries) = &mut others {
        entries.remove("covariance");
        entries.remove("marginal");
    }
    let rows = [covariance(&rest["covariance"]), law(&rest["marginal"]), flattened(&others)].into_iter().flatten();
    let rows = rows.map(|(key, value)| vec![key, value]).collect();
    DataTable::new("Random surface", &["Property", "Value"], rows, "results.json")
}

/// What the length of a covariance model is.
pub(crate) fn length_in_words(model: &Value) -> &'static str {
    match model.as_str() {
        Some("matern") => "scale of the model",
        Some("self_affine") => "roll-off length",
        _ => "to 1/e",
    }
}

/// The name of a covariance model, generator or law as a reader calls it.
pub(crate) fn in_words(name: &Value) -> String {
    match name.as_str() {
        Some("matern") => "Matérn".into(),
        Some("self_affine") => "self-affine".into(),
        Some("karhunen_loeve") => "Karhunen–Loève".into(),
        Some("weierstrass_mandelbrot") => "Weierstrass–Mandelbrot".into(),
        Some("johnson_su") => "Johnson SU".into(),
        Some("johnson_sb") => "Johnson SB".into(),
        Some("johnson_sl") => "Johnson SL".into(),
        Some("johnson_sn") => "Johnson SN".into(),
        _ => plain(name).replace('_', " "),
    }
}

fn covariance(covariance: &Value) -> Vec<(String, String)> {
    if !covariance.is_object() {
        return if covariance.is_null() { vec![] } else { vec![("covariance".to_owned(), plain(covariance))] };
    }
    let length = length_in_words(&covariance["model"]);
    let named = [
        ("std_m", "standard deviation".to_owned()),
        ("length_x_m", format!("length along x ({length})")),
        ("length_y_m", format!("length along y ({length})")),
        ("decay_length_x_m", "correlation length along x, to 1/e".to_owned()),
        ("decay_length_y_m", "correlation length along y, to 1/e".to_owned()),
        ("smoothness", "smoothness ν".to_owned()),
        ("hurst", "Hurst exponent".to_owned()),
        ("misfit", "misfit, rms of ln(measured/model spectral density)".to_owned()),
        ("slope_ratio", "Sdq of maps drawn like the scan over the scan's, within the band".to_owned()),
        ("slope_cutoff_m", "S-filter at the end of that band".to_owned()),
    ];
    let mut rows = vec![("covariance".to_owned(), in_words(&covariance["model"]))];
    let present = named.iter().filter(|(key, _)| covariance[*key].is_number());
    rows.extend(present.map(|(key, name)| (format!("covariance · {name}"), shown(covariance, key))));
    let candidate = |tried: &Value| {
        let number = |key: &str| tried[key].as_f64().map_or("–".into(), |value| significant(value, 3));
        format!("{} ({}; {})", in_words(&tried["model"]), number("misfit"), number("slope_ratio"))
    };
    let candidates: Vec<String> = covariance["candidates"].as_array().into_iter().flatten().map(candidate).collect();
    if !candidates.is_empty() {
        rows.push(("covariance · tried, with misfit and ratio of Sdq".to_owned(), candidates.join(", ")));
    }
    let mut others = covariance.clone();
    if let Value::Object(entries) = &mut others {
        entries.retain(|key, _| key != "model" && key != "candidates" && named.iter().all(|(own, _)| own != key));
    }
    rows.extend(flattened(&others).into_iter().map(|(key, value)| (format!("covariance · {key}"), value)));
    rows
}

/// A law of heights with its parameters, which are in metre where they are heights.
fn law(law: &Value) -> Vec<(String, String)> {
    if law.is_null() {
        return vec![];
    }
    let name = law["name"].as_str().unwrap_or_default();
    let mut rows = vec![("marginal law".to_owned(), in_words(&law["name"]))];
    let parameters = law["parameters"].as_object().into_iter().flatten();
    rows.extend(parameters.map(|(key, value)| {
        let (meaning, dimension) = parameter(name, key);
        let shown = value.as_f64().map_or_else(|| plain(value), |value| dimension.show(value));
        (format!("marginal law · {meaning}"), shown)
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
    use serde_json::json;

    fn rows(rest: &Value) -> Vec<(String, String)> {
        let rows = table(rest).rows.into_iter();
        rows.map(|row| (row[0].clone(), row[1].replace('\u{a0}', " "))).collect()
    }

    fn said(rest: &Value, name: &str) -> String {
        let rows = rows(rest);
        rows.iter().find(|(own, _)| own == name).unwrap_or_else(|| panic!("{name}: {rows:?}")).1.clone()
    }

    #[test]
    fn heights_among_the_parameters_of_a_law_have_their_unit_and_shapes_none() {
        let beta =
            json!({"marginal": {"name": "beta", "parameters": {"a": 2.1, "b": 5.0, "low": -2e-6, "high": 5e-6}}});
        assert_eq!(said(&beta, "marginal law"), "beta");
        assert_eq!(said(&beta, "marginal law · first shape a"), "2.1");
        assert_eq!(said(&beta, "marginal law · lower end"), "−2 µm");
        assert_eq!(said(&beta, "marginal law · upper end"), "5 µm");
        let normal = json!({"marginal": {"name": "normal", "parameters": {"mean": 0.0, "std": 1e-6}}});
        assert_eq!(said(&normal, "marginal law · standard deviation"), "1 µm");
        let johnson = json!({"marginal": {"name": "johnson_su", "parameters": {"gamma": 0.2, "lambda": 3e-7}}});
        assert_eq!(said(&johnson, "marginal law"), "Johnson SU");
        assert_eq!(said(&johnson, "marginal law · scale λ"), "300 nm");
        let weibull = json!({"marginal": {"name": "weibull", "parameters": {"shape": 2.0, "scale": 1e-6}}});
        assert_eq!(
            (said(&weibull, "marginal law · shape"), said(&weibull, "marginal law · scale")),
            ("2".into(), "1 µm".into())
        );
        let lognormal = json!({"marginal": {"name": "lognormal", "parameters": {"mu": -14.0, "sigma": 0.5}}});
        assert_eq!(said(&lognormal, "marginal law · µ, mean of the logarithm of z − shift in metre"), "−14");
    }

    #[test]
    fn the_length_of_a_model_says_what_it_is() {
        let matern = json!({"covariance": {"model": "matern", "length_x_m": 2e-5, "decay_length_x_m": 3e-5, "smoothness": 1.5,
            "misfit": 0.012, "hurst": null, "candidates": [{"model": "matern", "misfit": 0.012, "slope_ratio": 1.02}, {"model": "empirical", "misfit": null, "slope_ratio": 0.97}],
            "slope_ratio": 1.02,
            "extra_m": 1e-6}, "karhunen_loeve": {"modes": 101}});
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
        assert_eq!(said(&matern, "covariance · extra"), "1 µm");
        assert_eq!(said(&matern, "Karhunen–Loève · modes"), "101");
        let self_affine = json!({"covariance": {"model": "self_affine", "length_y_m": 2e-5}});
        assert_eq!(said(&self_affine, "covariance · length along y (roll-off length)"), "20 µm");
        let exponential = json!({"covariance": {"model": "exponential", "length_y_m": 2e-5}});
        assert_eq!(said(&exponential, "covariance · length along y (to 1/e)"), "20 µm");
        assert!(rows(&json!({})).is_empty());
    }
}
