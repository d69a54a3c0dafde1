//! Names and values of models, methods, motions and inputs, for readers.

use asperity_results::keys;
use asperity_results::{DistributionResult, FrictionResult, Quantiles};

use crate::format::{Dimension, fixed};

/// Returns the name of an input, `vibration.damping_ratio`, in words.
pub(crate) fn named(input: &str) -> String {
    // A body has scans where an input has a value.
    input.strip_suffix(".file").map_or_else(|| keys::label(input), str::to_owned)
}

/// Returns the median with its unit, and the 5–95 % range in brackets; an empty range if it is no wider than its digits.
pub(crate) fn between(dimension: Dimension, quantiles: Quantiles) -> (String, String) {
    let Quantiles { q05, q50, q95 } = quantiles;
    let unit = dimension.unit(q50);
    let [low, middle, high] = [q05, q50, q95].map(|value| value / unit.si);
    let decimals = if middle == 0.0 { 0 } else { (2.0 - middle.abs().log10().floor()).clamp(0.0, 9.0) as usize };
    let [low, middle, high] = [low, middle, high].map(|value| fixed(value, decimals));
    let range = if low == high { String::new() } else { format!(" ({low}–{high})") };
    (format!("{middle}\u{a0}{}", unit.symbol), range)
}

/// Meaning of a length over which the correlation falls to 1/e.
pub(crate) const TO_1_E: &str = "to 1/e";

/// Returns the meaning of the length of a covariance model.
pub(crate) fn length_in_words(model: &str) -> &'static str {
    match model {
        "matern" => "scale of the model",
        "self_affine" => "roll-off length",
        _ => TO_1_E,
    }
}

/// Returns the name of a covariance model, generator or distribution for readers.
pub(crate) fn in_words(name: &str) -> String {
    match name {
        "self_affine" => return "self-affine".into(),
        "karhunen_loeve" => return "Karhunen–Loève".into(),
        "weierstrass_mandelbrot" => return "Weierstrass–Mandelbrot".into(),
        _ => {}
    }
    let word = |word| match word {
        "matern" => "Matérn",
        "beta" => "Beta",
        "gamma" => "Gamma",
        "weibull" => "Weibull",
        "johnson" => "Johnson",
        "su" => "SU",
        "sb" => "SB",
        "sl" => "SL",
        "sn" => "SN",
        other => other,
    };
    name.split('_').map(word).collect::<Vec<_>>().join(" ")
}

/// Returns the meaning of a parameter of a distribution, and whether it has the unit of the distributed quantity.
pub(crate) fn meaning(distribution: &str, key: &str) -> (String, bool) {
    let (meaning, has_unit) = match (distribution, key) {
        (_, "mean") => ("mean", true),
        (_, "std") => ("standard deviation", true),
        ("lognormal", "mu") => ("mean of the logarithm of the excess over the shift", false),
        ("lognormal", "sigma") => ("standard deviation of that logarithm", false),
        ("lognormal" | "weibull" | "gamma", "shift") => ("shift, lower end", true),
        ("weibull" | "gamma", "shape") => ("shape", false),
        ("weibull" | "gamma", "scale") => ("scale", true),
        ("beta", "a") => ("first shape a", false),
        ("beta", "b") => ("second shape b", false),
        ("beta" | "triangular", "low") => ("lower end", true),
        ("triangular", "mode") => ("mode", true),
        ("beta" | "triangular", "high") => ("upper end", true),
        (_, "gamma") => ("γ", false),
        (_, "delta") => ("δ", false),
        (_, "xi") => ("location ξ", true),
        (_, "lambda") => ("scale λ", true),
        (_, other) => return (other.replace('_', " "), false),
    };
    (meaning.to_owned(), has_unit)
}

/// Returns the name of a fitted distribution for readers.
pub(crate) fn distribution_name(fit: &DistributionResult) -> String {
    let shifted = fit.parameters.get("shift").is_some_and(|shift| *shift != 0.0);
    format!("{}{}", if shifted { "shifted " } else { "" }, in_words(&fit.name))
}

/// Describes window, strips and boundary in a sentence.
pub(crate) fn conditions(friction: &FrictionResult) -> String {
    let length = |metre: f64| Dimension::Length.show_short(metre);
    let boundary = match friction.mean_compliance_m_per_pa {
        Some(compliance) => {
            format!("periodic, of mean compliance {} under a fixed plane", Dimension::Compliance.show(compliance))
        }
        None => "free".into(),
    };
    format!(
        "Window of {} × {} on {} strips {} wide ({boundary}).",
        length(friction.window_m),
        length(friction.window_width_m),
        friction.realisations,
        length(friction.strip_width_m)
    )
}

/// Returns a text with a capital first letter.
pub(crate) fn capitalised(mut text: String) -> String {
    text.get_mut(..1).into_iter().for_each(str::make_ascii_uppercase);
    text
}

/// Keeps numbers and percent signs on one line.
pub(crate) fn unbroken(text: &str) -> String {
    text.replace(" %", "\u{a0}%")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_have_names_and_ranges_have_one_unit() {
        assert_eq!(named("counterface.youngs_modulus"), "Young’s modulus of the counterface");
        assert_eq!(named("counterface.file"), "counterface");
        let hertz = Quantiles { q05: 1298.0, q50: 1312.4, q95: 1326.0 };
        let spaced = |(middle, range): (String, String)| format!("{middle}{range}").replace('\u{a0}', " ");
        assert_eq!(spaced(between(Dimension::Frequency, hertz)), "1.31 kHz (1.30–1.33)");
        let exact = Quantiles { q05: 2.34e-5, q50: 2.34e-5, q95: 2.34e-5 };
        assert_eq!(spaced(between(Dimension::Length, exact)), "23.4 µm");
    }
}
