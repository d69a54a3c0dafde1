//! Names and values of the inputs of a verdict, for readers.

use asperity_results::Quantiles;

use crate::format::{Dimension, fixed};

/// Returns the dimension of an SI unit.
pub(crate) fn dimension(unit: &str) -> Dimension {
    match unit {
        "m" => Dimension::Length,
        "m^2" => Dimension::Area,
        "Pa" => Dimension::Pressure,
        "kg" => Dimension::Mass,
        "N" => Dimension::Force,
        "m/s" => Dimension::Velocity,
        "rad/s" => Dimension::AngularFrequency,
        "s/m" => Dimension::Other("s/m"),
        "s" => Dimension::Time,
        "m/Pa" => Dimension::Compliance,
        _ => Dimension::None,
    }
}

/// Returns the name of an input, `vibration.damping_ratio`, in words.
pub(crate) fn named(input: &str) -> String {
    let (section, key) = input.split_once('.').unwrap_or(("", input));
    match key {
        "springs[0]" => return "first spring".into(),
        "springs[1]" => return "second spring".into(),
        "spring_angles[0]" => return "angle of the first spring in degrees".into(),
        "spring_angles[1]" => return "angle of the second spring in degrees".into(),
        _ => {}
    }
    let (key, axis) = match key.split_once('[') {
        Some((list @ ("mean_pressures" | "penetrations"), place)) => {
            return format!("{} [{place}", list.replace('_', " "));
        }
        Some((key, "0]")) => (key, " along x"),
        Some((key, "1]")) => (key, " along y"),
        _ => (key, ""),
    };
    let words = match key {
        "youngs_modulus" => "Young’s modulus".into(),
        "poisson_ratio" => "Poisson’s ratio".into(),
        "rms_height" => "rms height".into(),
        "hurst" => "Hurst exponent".into(),
        "law" => "friction law".into(),
        "stribeck" => "Stribeck coefficient".into(),
        "kinetic_share" => "kinetic over static friction".into(),
        "high_speed_share" => "friction at high speed over kinetic friction".into(),
        "friction_std" => "standard deviation of friction".into(),
        "linear_weakening" => "weakening of friction with speed".into(),
        "belt_velocity" => "belt speed".into(),
        "dimensionless_belt_velocity" => "dimensionless belt speed".into(),
        "stribeck_velocity" => "Stribeck speed".into(),
        "friction_process" => "friction process".into(),
        "static_friction" => "friction coefficient".into(),
        "scan" => return format!("{section}, as far as the scan tells"),
        "between_scans" => return format!("{section}, from part to part"),
        "between_parts" => "friction of the slider’s parts".into(),
        "file" => section.to_owned(),
        other => other.replace('_', " "),
    };
    let body = if section == "counterface" && key != "file" { " of the counterface" } else { "" };
    format!("{words}{body}{axis}")
}

/// Returns the median with its unit, and the 5–95 % range in brackets; an empty range if it is no wider than its digits.
pub(in crate::page) fn between(dimension: Dimension, quantiles: Quantiles) -> (String, String) {
    let Quantiles { q05, q50, q95 } = quantiles;
    let unit = dimension.unit(q50);
    let [low, middle, high] = [q05, q50, q95].map(|value| value / unit.si);
    let decimals = if middle == 0.0 { 0 } else { (2.0 - middle.abs().log10().floor()).clamp(0.0, 9.0) as usize };
    let [low, middle, high] = [low, middle, high].map(|value| fixed(value, decimals));
    let range = if low == high { String::new() } else { format!(" ({low}–{high})") };
    (format!("{middle}\u{a0}{}", unit.symbol), range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_have_names_and_ranges_have_one_unit() {
        assert_eq!(named("vibration.damping_ratio"), "damping ratio");
        assert_eq!(named("surface.correlation_length[0]"), "correlation length along x");
        assert_eq!(named("vibration.springs[1]"), "second spring");
        assert_eq!(named("surface.scan"), "surface, as far as the scan tells");
        assert_eq!(named("counterface.between_scans"), "counterface, from part to part");
        assert_eq!(named("counterface.youngs_modulus"), "Young’s modulus of the counterface");
        let hertz = Quantiles { q05: 1298.0, q50: 1312.4, q95: 1326.0 };
        let spaced = |(middle, range): (String, String)| format!("{middle}{range}").replace('\u{a0}', " ");
        assert_eq!(spaced(between(Dimension::Frequency, hertz)), "1.31 kHz (1.30–1.33)");
        let exact = Quantiles { q05: 2.34e-5, q50: 2.34e-5, q95: 2.34e-5 };
        assert_eq!(spaced(between(Dimension::Length, exact)), "23.4 µm");
    }
}
