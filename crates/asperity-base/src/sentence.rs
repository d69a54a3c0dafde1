//! Numbers and quantities as text for sentences: engineering units, four significant digits.

pub use asperity_formats::chain;

/// SI prefixes and their powers of ten.
const PREFIXES: [(&str, i32); 9] =
    [("p", -12), ("n", -9), ("µ", -6), ("m", -3), ("", 0), ("k", 3), ("M", 6), ("G", 9), ("T", 12)];

/// Significant digits of a sentence.
const DIGITS: i32 = 4;

/// Formats a value of an SI unit with four digits and a prefix: "300 µm", "3.001 MPa".
pub fn si(value: f64, unit: &str) -> String {
    let (scaled, prefix) = prefixed(value, DIGITS);
    format!("{} {prefix}{unit}", digits(scaled))
}

/// Scales a value to between 1 and 1000, rounded to that many digits, and returns it with the prefix of its unit.
pub fn prefixed(value: f64, digits: i32) -> (f64, &'static str) {
    // 999.96 would round to 1000 of the smaller unit.
    let least = 1.0 - 0.5 * 10_f64.powi(-digits);
    let magnitude = |power: i32| value.abs() / 10_f64.powi(power);
    let prefix = PREFIXES.iter().rev().find(|(_, power)| magnitude(*power) >= least);
    let (name, power) = *prefix.unwrap_or(&("", 0));
    (value / 10_f64.powi(power), name)
}

/// Formats a length and a width: "6 mm × 75 µm".
pub fn size(width_m: f64, height_m: f64) -> String {
    format!("{} × {}", si(width_m, "m"), si(height_m, "m"))
}

/// Formats a compliance, in nm/MPa below 1 mm/Pa and otherwise in m/Pa.
pub fn compliance(m_per_pa: f64) -> String {
    if m_per_pa < 1e-3 { format!("{} nm/MPa", digits(m_per_pa * 1e15)) } else { format!("{} m/Pa", digits(m_per_pa)) }
}

/// Formats a number with four significant digits, without trailing zeros; very small and large numbers have an exponent.
pub fn digits(value: f64) -> String {
    significant(value, DIGITS)
}

/// Formats as [`digits`] does, with another number of significant digits.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".into() } else { value.to_string() };
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..6).contains(&exponent) {
        return format!("{value:.*e}", (digits - 1) as usize);
    }
    let text = format!("{value:.*}", (digits - 1 - exponent).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// Formats a count with its noun in the singular or the plural: "1 window", "12 windows".
pub fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_in_engineering_units() {
        for (value, unit, wanted) in [
            (3e-4, "m", "300 µm"),
            (6.006e-4, "m", "600.6 µm"),
            (999.96e-6, "m", "1 mm"),
            (385e6, "Pa", "385 MPa"),
            (3_001_200.5, "Pa", "3.001 MPa"),
            (-2e-6, "m", "-2 µm"),
            (0.0, "m", "0 m"),
            (6e-3, "m", "6 mm"),
            (210e9, "Pa", "210 GPa"),
        ] {
            assert_eq!(si(value, unit), wanted);
        }
        assert_eq!(size(512e-6, 1e-3), "512 µm × 1 mm");
        assert_eq!(compliance(8.2761e-15), "8.276 nm/MPa");
        assert_eq!(compliance(0.25), "0.25 m/Pa");
        assert_eq!(
            (digits(0.204_023), digits(1e-5), digits(123_456.0)),
            ("0.204".into(), "1.000e-5".into(), "123456".into())
        );
        assert_eq!(
            (count(1, "window", "windows"), count(2, "window", "windows")),
            ("1 window".into(), "2 windows".into())
        );
    }
}
