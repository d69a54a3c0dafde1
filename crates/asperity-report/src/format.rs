//! Numbers for readers: engineering units, digits set by the uncertainty, a true minus sign.

use std::f64::consts::PI;

use asperity_results::split_unit;

/// Keeps a number and its unit or uncertainty on one line.
const NO_BREAK: char = '\u{a0}';

/// A unit of display: symbol and size in SI.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unit {
    pub(crate) symbol: String,
    pub(crate) si: f64,
}

impl Unit {
    pub(crate) fn new(symbol: impl Into<String>, si: f64) -> Self {
        Self { symbol: symbol.into(), si }
    }

    /// Returns the unit of a dimensionless number.
    pub(crate) fn none() -> Self {
        Self::new("", 1.0)
    }

    /// Returns the reciprocal of this unit, for densities.
    pub(crate) fn inverse(&self) -> Self {
        if self.symbol.is_empty() { Self::none() } else { Self::new(format!("1/{}", self.symbol), 1.0 / self.si) }
    }
}

/// Dimension of a number, which determines its units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Dimension {
    None,
    Length,
    Pressure,
    Force,
    Mass,
    Wavenumber,
    AngularFrequency,
    Frequency,
    Velocity,
    Area,
    Time,
    Compliance,
    Stiffness,
    Angle,
    Other(&'static str),
}

impl Dimension {
    /// Returns a key without its unit suffix, and the dimension of the suffix.
    pub(crate) fn of_key(key: &str) -> (&str, Self) {
        let (name, unit) = split_unit(key);
        (name, Self::of_unit(unit))
    }

    /// Returns the dimension of an SI unit as in study files.
    pub(crate) fn of_unit(unit: &str) -> Self {
        match unit {
            "m" => Self::Length,
            "m^2" => Self::Area,
            "m^3" => Self::Other("m³"),
            "m^4" => Self::Other("m⁴"),
            "1/m" => Self::Other("1/m"),
            "rad/m" => Self::Wavenumber,
            "Pa" => Self::Pressure,
            "m/Pa" => Self::Compliance,
            "Pa/m" => Self::Stiffness,
            "N/m" => Self::Other("N/m"),
            "kg" => Self::Mass,
            "N" => Self::Force,
            "s" => Self::Time,
            "1/s" => Self::Other("1/s"),
            "s/m" => Self::Other("s/m"),
            "m/s" => Self::Velocity,
            "Hz" => Self::Frequency,
            "rad/s" => Self::AngularFrequency,
            "rad" => Self::Angle,
            "°" => Self::Other("°"),
            _ => Self::None,
        }
    }

    fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::None => &[("", 1.0)],
            Self::Length => &[("pm", 1e-12), ("nm", 1e-9), ("µm", 1e-6), ("mm", 1e-3), ("m", 1.0)],
            Self::Pressure => &[("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6), ("GPa", 1e9)],
            Self::Force => &[("µN", 1e-6), ("mN", 1e-3), ("N", 1.0), ("kN", 1e3), ("MN", 1e6)],
            Self::Mass => &[("g", 1e-3), ("kg", 1.0), ("t", 1e3)],
            Self::Wavenumber => &[("rad/m", 1.0), ("rad/mm", 1e3), ("rad/µm", 1e6)],
            Self::AngularFrequency => &[("mHz", 2e-3 * PI), ("Hz", 2.0 * PI), ("kHz", 2e3 * PI)],
            Self::Frequency => &[("mHz", 1e-3), ("Hz", 1.0), ("kHz", 1e3)],
            Self::Velocity => &[("µm/s", 1e-6), ("mm/s", 1e-3), ("m/s", 1.0)],
            Self::Area => &[("µm²", 1e-12), ("mm²", 1e-6), ("m²", 1.0)],
            Self::Time => &[("µs", 1e-6), ("ms", 1e-3), ("s", 1.0)],
            Self::Compliance => &[("nm/MPa", 1e-15), ("µm/MPa", 1e-12), ("m/Pa", 1.0)],
            Self::Stiffness => &[("Pa/m", 1.0), ("kPa/µm", 1e9), ("MPa/µm", 1e12), ("GPa/µm", 1e15)],
            Self::Angle => &[("°", PI / 180.0)],
            Self::Other(_) => &[],
        }
    }

    /// Returns the unit in which `largest` (SI) has one to three digits before the point, if there is one, otherwise the nearest.
    pub(crate) fn unit(self, largest: f64) -> Unit {
        if let Self::Other(symbol) = self {
            return Unit::new(symbol, 1.0);
        }
        let units = self.units();
        let size = largest.abs() * (1.0 + 1e-9);
        let fitting = units.iter().rev().find(|(_, si)| size >= *si).or(units.first());
        let zero = units.iter().find(|(_, si)| *si == 1.0).or(units.first());
        let chosen = if size > 0.0 { fitting } else { zero };
        chosen.map_or_else(Unit::none, |(symbol, si)| Unit::new(*symbol, *si))
    }

    /// Formats a value in SI with its engineering unit and four digits.
    pub(crate) fn show(self, value: f64) -> String {
        let unit = self.unit(value);
        attach(&significant(value / unit.si, 4), &unit)
    }

    /// Formats a value as [`Dimension::show`] does, with three digits, for notes in figures.
    pub(crate) fn show_short(self, value: f64) -> String {
        let unit = self.unit(value);
        attach(&significant(value / unit.si, 3), &unit)
    }

    /// Formats a value with its standard error, both in one unit: `1.02 ± 0.03 µm`.
    pub(crate) fn show_error(self, value: f64, error: f64) -> String {
        let unit = self.unit(value);
        attach(&with_error(value / unit.si, error / unit.si), &unit)
    }

    /// Formats a value with its interval, all in one unit: `1.02 µm [0.98, 1.06]`. Zero has the unit of its interval.
    pub(crate) fn show_interval(self, value: f64, interval: Option<(f64, f64)>) -> String {
        let shown = self.show_within(value, interval);
        let Some((low, high)) = interval else { return shown };
        let unit = self.unit(if value == 0.0 { high } else { value });
        format!("{shown} {}", show_range(low / unit.si, high / unit.si))
    }

    /// Formats a value as [`Dimension::show_interval`] does, without its interval.
    pub(crate) fn show_within(self, value: f64, interval: Option<(f64, f64)>) -> String {
        let Some((low, high)) = interval else { return self.show(value) };
        let unit = self.unit(if value == 0.0 { high } else { value });
        let value = value / unit.si;
        let number = match shown_decimals(low / unit.si, high / unit.si) {
            // A value far smaller than its interval is not rounded to 0.
            Some(decimals) if value != 0.0 && value.abs() < 0.5 * 10_f64.powi(-(decimals as i32)) => {
                significant(value, 2)
            }
            Some(decimals) => rounded(value, decimals),
            None => significant(value, 4),
        };
        attach(&number, &unit)
    }
}

/// Returns the number of decimals that show two digits of an uncertainty; `None` for very large and very small ones.
fn decimals(uncertainty: f64) -> Option<usize> {
    let places = 1.0 - uncertainty.log10().floor();
    (uncertainty > 0.0 && (-4.0..=9.0).contains(&places)).then_some(places.max(0.0) as usize)
}

/// Returns the number of decimals of an interval: two digits of its width, but no more than four digits of its ends.
fn shown_decimals(low: f64, high: f64) -> Option<usize> {
    let four = 3.0 - low.abs().max(high.abs()).log10().floor();
    decimals(high - low).map(|decimals| decimals.min(four.max(0.0) as usize))
}

/// Formats `[low, high]` with two digits of its width.
pub(crate) fn show_range(low: f64, high: f64) -> String {
    match shown_decimals(low, high) {
        Some(decimals) => format!("[{},{NO_BREAK}{}]", rounded(low, decimals), rounded(high, decimals)),
        None => format!("[{},{NO_BREAK}{}]", significant(low, 3), significant(high, 3)),
    }
}

fn attach(number: &str, unit: &Unit) -> String {
    match unit.symbol.as_str() {
        "" | "°" => format!("{number}{}", unit.symbol),
        symbol => format!("{number}{NO_BREAK}{symbol}"),
    }
}

/// Replaces the hyphen before a number by a minus sign.
fn minus(text: String) -> String {
    if text.starts_with('-') { text.replacen('-', "−", 1) } else { text }
}

/// Formats a whole number as a superscript.
pub(crate) fn superscript(number: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    number.to_string().chars().map(|c| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize])).collect()
}

/// Formats a number with fixed decimals and a true minus sign; −0 is written 0.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if zero { text.trim_start_matches('-').to_owned() } else { minus(text) }
}

/// Formats a number as [`fixed`] does, but an exact zero without decimals.
fn rounded(value: f64, decimals: usize) -> String {
    if value == 0.0 { "0".into() } else { fixed(value, decimals) }
}

/// Formats a number with that many significant digits, very large and small ones as a power of ten, undefined ones as a dash.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    // Rounding may carry to the next power of ten, so the exponent is read from the rounded number.
    let rounded = format!("{value:.*e}", digits.max(1) - 1);
    let Some((mantissa, exponent)) = rounded.split_once('e') else { return rounded };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        let text = fixed(value, decimals);
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
    }
    minus(format!("{mantissa}·10{}", superscript(exponent)))
}

/// Formats a count with commas between thousands.
pub(crate) fn count(count: usize) -> String {
    if count < 1000 { count.to_string() } else { format!("{},{:03}", self::count(count / 1000), count % 1000) }
}

/// Formats `value ± error`, the error with two significant digits and the value with as many decimals.
pub(crate) fn with_error(value: f64, error: f64) -> String {
    if !(error.is_finite() && error > 0.0) {
        return significant(value, 4);
    }
    match decimals(error) {
        Some(decimals) => format!("{}{NO_BREAK}±{NO_BREAK}{}", fixed(value, decimals), fixed(error, decimals)),
        None => format!("{}{NO_BREAK}±{NO_BREAK}{}", significant(value, 4), significant(error, 2)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spaced(text: String) -> String {
        text.replace(NO_BREAK, " ")
    }

    #[test]
    fn every_unit_of_a_name_is_shown() {
        for unit in asperity_results::units_of_names() {
            assert_ne!(Dimension::of_unit(unit).unit(1.0).symbol, "", "{unit}");
        }
    }

    #[test]
    fn engineering_units_are_chosen_by_size() {
        assert_eq!(spaced(Dimension::Length.show(1.0234e-6)), "1.023 µm");
        assert_eq!(spaced(Dimension::Length.show(6e-3)), "6 mm");
        assert_eq!(spaced(Dimension::Length.show(0.0)), "0 m");
        assert_eq!(spaced(Dimension::Pressure.show(2.1e11)), "210 GPa");
        assert_eq!(spaced(Dimension::Pressure.show(-3e6)), "−3 MPa");
        assert_eq!(spaced(Dimension::Length.show_interval(2.5e-4, Some((2e-4, 3e-4)))), "250 µm [200, 300]");
        assert_eq!(spaced(Dimension::Length.show_interval(0.0, Some((0.0, 9.07e-6)))), "0 µm [0, 9.1]");
        assert_eq!(spaced(Dimension::None.show_interval(0.0621, Some((0.0, 19.0)))), "0.062 [0, 19]");
        assert_eq!(spaced(Dimension::None.show_interval(0.400_019, Some((0.4, 0.400_067)))), "0.4000 [0.4000, 0.4001]");
        assert_eq!(spaced(Dimension::AngularFrequency.show(628.3185)), "100 Hz");
        assert_eq!(spaced(Dimension::None.show_interval(25.9871, Some((23.49, 28.51)))), "26.0 [23.5, 28.5]");
        assert_eq!(
            spaced(Dimension::None.show_interval(0.005279, Some((0.00468, 0.00607)))),
            "0.0053 [0.0047, 0.0061]"
        );
    }

    #[test]
    fn keys_state_their_units() {
        assert_eq!(Dimension::of_key("mean_compliance_m_per_pa"), ("mean_compliance", Dimension::Compliance));
        assert_eq!(Dimension::of_key("Ssk"), ("Ssk", Dimension::None));
        assert_eq!(Dimension::Stiffness.show(2.512e13), "25.12\u{a0}MPa/µm");
    }

    #[test]
    fn digits_follow_the_uncertainty() {
        assert_eq!(spaced(with_error(0.41234, 0.0221)), "0.412 ± 0.022");
        assert_eq!(spaced(with_error(69.48, 0.30)), "69.48 ± 0.30");
        assert_eq!(spaced(with_error(0.5, f64::NAN)), "0.5");
        assert_eq!(significant(0.999_96, 4), "1");
        assert_eq!(significant(1.5e-7, 3), "1.50·10⁻⁷");
        assert_eq!(significant(-0.1705, 4), "−0.1705");
        assert_eq!(significant(f64::NAN, 4), "–");
        assert_eq!(fixed(-0.0001, 2), "0.00");
    }
}
