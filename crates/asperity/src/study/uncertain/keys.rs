//! Keys of a study file whose values may be uncertain, with their units and physical bounds.

use toml::Value;

use crate::quantity::{
    AngularFrequency, Area, Compliance, Force, InverseVelocity, Length, Mass, Pressure, QuantityError, Time, Velocity,
};

/// Key whose value may be uncertain.
#[derive(Debug, PartialEq)]
pub(in crate::study) struct UncertainKey {
    pub(in crate::study) section: &'static str,
    pub(in crate::study) name: &'static str,
    /// SI unit; empty for a number.
    pub(in crate::study) unit: &'static str,
    /// Physical bounds in SI.
    pub(super) low: f64,
    pub(super) high: f64,
}

const fn key(section: &'static str, name: &'static str, unit: &'static str, low: f64, high: f64) -> UncertainKey {
    UncertainKey { section, name, unit, low, high }
}

const UNBOUNDED: f64 = f64::INFINITY;

/// All keys whose values may be uncertain.
pub(in crate::study) const KEYS: &[UncertainKey] = &[
    key("surface", "rms_height", "m", 0.0, UNBOUNDED),
    key("surface", "correlation_length", "m", 0.0, UNBOUNDED),
    key("surface", "hurst", "", 0.0, 1.0),
    key("surface", "smoothness", "", 0.0, UNBOUNDED),
    key("surface", "fractal_dimension", "", 2.0, 3.0),
    key("surface", "cut_off", "m", 0.0, UNBOUNDED),
    key("material", "youngs_modulus", "Pa", 0.0, UNBOUNDED),
    key("material", "poisson_ratio", "", -1.0, 0.5),
    key("material", "hardness", "Pa", 0.0, UNBOUNDED),
    key("material", "shear_strength", "Pa", 0.0, UNBOUNDED),
    key("counterface", "youngs_modulus", "Pa", 0.0, UNBOUNDED),
    key("counterface", "poisson_ratio", "", -1.0, 0.5),
    key("counterface", "hardness", "Pa", 0.0, UNBOUNDED),
    key("friction", "pressure_coefficient", "", 0.0, UNBOUNDED),
    key("friction", "coefficient", "", 0.0, UNBOUNDED),
    key("friction", "nominal_area", "m^2", 0.0, UNBOUNDED),
    key("vibration", "mass", "kg", 0.0, UNBOUNDED),
    key("vibration", "natural_frequency", "rad/s", 0.0, UNBOUNDED),
    key("vibration", "damping_ratio", "", 0.0, UNBOUNDED),
    key("vibration", "normal_force", "N", 0.0, UNBOUNDED),
    key("vibration", "nominal_area", "m^2", 0.0, UNBOUNDED),
    key("vibration", "belt_velocity", "m/s", 0.0, UNBOUNDED),
    key("vibration", "dimensionless_belt_velocity", "", 0.0, UNBOUNDED),
    key("vibration", "stribeck", "", 0.0, UNBOUNDED),
    key("vibration", "stribeck", "s/m", 0.0, UNBOUNDED),
    key("vibration", "linear_weakening", "", 0.0, UNBOUNDED),
    key("vibration", "spring_angles", "", -UNBOUNDED, UNBOUNDED),
    key("vibration", "springs", "", 0.0, UNBOUNDED),
    key("vibration", "contact_spring", "", 0.0, UNBOUNDED),
    key("vibration", "kinetic_share", "", 0.0, 1.0),
    key("vibration", "stribeck_velocity", "m/s", 0.0, UNBOUNDED),
    key("vibration", "high_speed_share", "", 0.0, 1.0),
    key("vibration", "static_friction", "", 0.0, UNBOUNDED),
    key("vibration", "friction_std", "", 0.0, UNBOUNDED),
    key("vibration", "friction_correlation_length", "m", 0.0, UNBOUNDED),
];

/// Name of the differences between the parts of a rough slider.
pub(in crate::study) const BETWEEN_PARTS: &str = "surface.between_parts";

/// Name of the shortest wave of the surface. A study that does not state it may have it as a value that the scan leaves unknown.
pub(in crate::study) const CUT_OFF: &str = "surface.cut_off";

/// Standard normal values that no study file states: what the scans of either body leave uncertain, differences between scans and between
/// the parts of a rough slider.
pub(super) const LATENT: &[UncertainKey] = &[
    key("surface", "scan", "", -UNBOUNDED, UNBOUNDED),
    key("surface", "between_scans", "", -UNBOUNDED, UNBOUNDED),
    key("counterface", "scan", "", -UNBOUNDED, UNBOUNDED),
    key("counterface", "between_scans", "", -UNBOUNDED, UNBOUNDED),
    key("surface", "between_parts", "", -UNBOUNDED, UNBOUNDED),
];

impl UncertainKey {
    /// Returns the key; of a key that takes numbers and quantities, the form of `value`.
    pub(super) fn find(section: &str, name: &str, value: &Value) -> Option<&'static Self> {
        let mut found = KEYS.iter().filter(|key| (key.section, key.name) == (section, name));
        let first = found.next()?;
        let is_number = matches!(value, Value::Float(_) | Value::Integer(_));
        Some(
            found
                .find(|key| key.unit.is_empty() == is_number)
                .filter(|_| first.unit.is_empty() != is_number)
                .unwrap_or(first),
        )
    }

    /// Returns whether a value in SI lies within the physical bounds.
    pub(in crate::study) fn contains(&self, value: f64) -> bool {
        value.is_finite() && (self.low..=self.high).contains(&value)
    }

    /// Reads a number or quantity in SI.
    pub(in crate::study) fn parse(&self, value: &Value) -> Result<f64, String> {
        let text = match value {
            Value::Float(number) if self.unit.is_empty() => return Ok(*number),
            Value::Integer(number) if self.unit.is_empty() => return Ok(*number as f64),
            Value::String(text) if self.unit.is_empty() => return Err(format!("`{text}` is not a number")),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        quantity(self.unit, &text).map_err(|error| error.to_string())
    }

    /// Returns the name of its dimension and the regular expression of its units; `None` for a number.
    pub(in crate::study) fn quantity(&self) -> Option<(&'static str, String)> {
        Some(match self.unit {
            "" => return None,
            "m" => ("length", Length::unit_pattern()),
            "m^2" => ("area", Area::unit_pattern()),
            "Pa" => ("pressure", Pressure::unit_pattern()),
            "kg" => ("mass", Mass::unit_pattern()),
            "N" => ("force", Force::unit_pattern()),
            "m/s" => ("velocity", Velocity::unit_pattern()),
            "s/m" => ("inverse_velocity", InverseVelocity::unit_pattern()),
            _ => ("angular_frequency", AngularFrequency::unit_pattern()),
        })
    }

    /// Returns a number in SI as a study file states it.
    pub(in crate::study) fn show(&self, value: f64) -> Value {
        if self.unit.is_empty() { Value::Float(value) } else { Value::String(format!("{value:?} {}", self.unit)) }
    }
}

/// Returns a quantity of any dimension in SI with its unit.
pub(super) fn any_quantity(text: &str) -> Option<(f64, &'static str)> {
    const UNITS: [&str; 10] = ["m", "m^2", "Pa", "kg", "N", "m/s", "s/m", "s", "m/Pa", "rad/s"];
    UNITS.into_iter().find_map(|unit| Some((quantity(unit, text).ok()?, unit)))
}

fn quantity(unit: &str, text: &str) -> Result<f64, QuantityError> {
    Ok(match unit {
        "m" => text.parse::<Length>()?.0,
        "m^2" => text.parse::<Area>()?.0,
        "Pa" => text.parse::<Pressure>()?.0,
        "kg" => text.parse::<Mass>()?.0,
        "N" => text.parse::<Force>()?.0,
        "m/s" => text.parse::<Velocity>()?.0,
        "s/m" => text.parse::<InverseVelocity>()?.0,
        "s" => text.parse::<Time>()?.0,
        "m/Pa" => text.parse::<Compliance>()?.0,
        _ => text.parse::<AngularFrequency>()?.0,
    })
}
