//! Units of numbers by the ending of their name.

/// Endings of names with their unit as in study files. A longer ending stands before the one that it contains.
const ENDINGS: [(&str, &str); 19] = [
    ("_rad_per_m", "rad/m"),
    ("_rad_per_s", "rad/s"),
    ("_m_per_pa", "m/Pa"),
    ("_m_per_s", "m/s"),
    ("_pa_per_m", "Pa/m"),
    ("_n_per_m", "N/m"),
    ("_per_s", "1/s"),
    ("_hz", "Hz"),
    ("_per_m", "1/m"),
    ("_m2", "m^2"),
    ("_m3", "m^3"),
    ("_m4", "m^4"),
    ("_pa", "Pa"),
    ("_kg", "kg"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
    ("_rad", "rad"),
    ("_deg", "°"),
];

/// Returns a name without the ending that states its unit, and the unit; both are the name and empty if it states none.
pub fn split_unit(name: &str) -> (&str, &'static str) {
    let found = ENDINGS.iter().find_map(|(ending, unit)| Some((name.strip_suffix(ending)?, *unit)));
    found.filter(|(stem, _)| !stem.is_empty()).unwrap_or((name, ""))
}

/// Returns all units that a name may end with.
#[doc(hidden)]
pub fn units_of_names() -> impl Iterator<Item = &'static str> {
    ENDINGS.iter().map(|(_, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_end_with_their_unit() {
        assert_eq!(split_unit("contact_stiffness_pa_per_m"), ("contact_stiffness", "Pa/m"));
        assert_eq!(split_unit("belt_velocity_m_per_s"), ("belt_velocity", "m/s"));
        assert_eq!(split_unit("std_nominal_area"), ("std_nominal_area", ""));
    }

    #[test]
    fn longer_endings_stand_before_those_that_they_contain() {
        for (ending, unit) in ENDINGS {
            assert_eq!(split_unit(&format!("x{ending}")), ("x", unit));
        }
    }
}
