//! Keys of a study file whose values may be uncertain, with their units and physical bounds.

use toml::Value;

use crate::quantity::{
    AngularFrequency, Area, Compliance, Force, InverseVelocity, Length, Mass, Pressure, QuantityError, Time, Velocity,
};
use crate::study::StudyFile;
use crate::study::file::{ContactSpring, Stribeck};

/// Key whose value may be uncertain.
#[derive(Debug)]
pub(in crate::study) struct UncertainKey {
    pub(in crate::study) section: &'static str,
    pub(in crate::study) name: &'static str,
    /// SI unit; empty for a number.
    pub(in crate::study) unit: &'static str,
    /// Physical bounds in SI.
    pub(super) low: f64,
    pub(super) high: f64,
    /// Returns its number in SI, or that of one element of a list; `None` if the file does not state it.
    pub(super) get: fn(&StudyFile, Option<usize>) -> Option<f64>,
    /// Replaces its number in SI, or that of one element or of all of a list, if the file states it.
    pub(super) set: fn(&mut StudyFile, Option<usize>, f64),
}

impl PartialEq for UncertainKey {
    fn eq(&self, other: &Self) -> bool {
        (self.section, self.name, self.unit) == (other.section, other.name, other.unit)
    }
}

macro_rules! key {
    ($section:ident.$name:ident, $unit:literal, $low:expr, $high:expr) => {
        UncertainKey {
            section: stringify!($section),
            name: stringify!($name),
            unit: $unit,
            low: $low,
            high: $high,
            get: |file, element| file.$section.as_ref()?.$name.get($unit, element),
            set: |file, element, value| {
                if let Some(section) = &mut file.$section {
                    section.$name.set($unit, element, value);
                }
            },
        }
    };
}

const fn latent(section: &'static str, name: &'static str) -> UncertainKey {
    UncertainKey { section, name, unit: "", low: -UNBOUNDED, high: UNBOUNDED, get: |_, _| None, set: |_, _, _| {} }
}

/// Number of a study file in SI, or a list of numbers.
trait Numbers {
    fn get(&self, unit: &str, element: Option<usize>) -> Option<f64>;
    fn set(&mut self, unit: &str, element: Option<usize>, value: f64);
}

impl Numbers for f64 {
    fn get(&self, _: &str, element: Option<usize>) -> Option<f64> {
        element.is_none().then_some(*self)
    }

    fn set(&mut self, _: &str, element: Option<usize>, value: f64) {
        if element.is_none() {
            *self = value;
        }
    }
}

macro_rules! quantities {
    ($($quantity:ident),*) => {$(
        impl Numbers for $quantity {
            fn get(&self, unit: &str, element: Option<usize>) -> Option<f64> {
                self.0.get(unit, element)
            }

            fn set(&mut self, unit: &str, element: Option<usize>, value: f64) {
                self.0.set(unit, element, value);
            }
        }
    )*};
}

quantities!(AngularFrequency, Area, Force, InverseVelocity, Length, Mass, Pressure, Velocity);

impl<T: Numbers> Numbers for Option<T> {
    fn get(&self, unit: &str, element: Option<usize>) -> Option<f64> {
        self.as_ref()?.get(unit, element)
    }

    fn set(&mut self, unit: &str, element: Option<usize>, value: f64) {
        if let Some(numbers) = self {
            numbers.set(unit, element, value);
        }
    }
}

impl<T: Numbers> Numbers for [T; 2] {
    /// Returns an element or, without one, the number that all elements are.
    fn get(&self, unit: &str, element: Option<usize>) -> Option<f64> {
        let of = |element: &T| element.get(unit, None);
        match element {
            Some(position) => of(<[T]>::get(self, position)?),
            None => of(&self[0]).filter(|first| of(&self[1]) == Some(*first)),
        }
    }

    fn set(&mut self, unit: &str, element: Option<usize>, value: f64) {
        let chosen = |(position, _): &(usize, &mut T)| element.is_none_or(|element| element == *position);
        self.iter_mut().enumerate().filter(chosen).for_each(|(_, number)| number.set(unit, None, value));
    }
}

impl Numbers for Stribeck {
    fn get(&self, unit: &str, element: Option<usize>) -> Option<f64> {
        match self {
            Self::Dimensionless(number) if unit.is_empty() => number.get(unit, element),
            Self::Physical(quantity) if !unit.is_empty() => quantity.get(unit, element),
            Self::Dimensionless(_) | Self::Physical(_) => None,
        }
    }

    fn set(&mut self, unit: &str, element: Option<usize>, value: f64) {
        match self {
            Self::Dimensionless(number) if unit.is_empty() => number.set(unit, element, value),
            Self::Physical(quantity) if !unit.is_empty() => quantity.set(unit, element, value),
            Self::Dimensionless(_) | Self::Physical(_) => {}
        }
    }
}

impl Numbers for ContactSpring {
    fn get(&self, unit: &str, element: Option<usize>) -> Option<f64> {
        match self {
            Self::Stated(number) => number.get(unit, element),
            Self::Surface => None,
        }
    }

    fn set(&mut self, unit: &str, element: Option<usize>, value: f64) {
        if let Self::Stated(number) = self {
            number.set(unit, element, value);
        }
    }
}

const UNBOUNDED: f64 = f64::INFINITY;

/// All keys whose values may be uncertain.
pub(in crate::study) const KEYS: &[UncertainKey] = &[
    key!(surface.rms_height, "m", 0.0, UNBOUNDED),
    key!(surface.correlation_length, "m", 0.0, UNBOUNDED),
    key!(surface.hurst, "", 0.0, 1.0),
    key!(surface.smoothness, "", 0.0, UNBOUNDED),
    key!(surface.fractal_dimension, "", 2.0, 3.0),
    key!(surface.cut_off, "m", 0.0, UNBOUNDED),
    key!(material.youngs_modulus, "Pa", 0.0, UNBOUNDED),
    key!(material.poisson_ratio, "", -1.0, 0.5),
    key!(material.hardness, "Pa", 0.0, UNBOUNDED),
    key!(material.shear_strength, "Pa", 0.0, UNBOUNDED),
    key!(counterface.youngs_modulus, "Pa", 0.0, UNBOUNDED),
    key!(counterface.poisson_ratio, "", -1.0, 0.5),
    key!(counterface.hardness, "Pa", 0.0, UNBOUNDED),
    key!(friction.pressure_coefficient, "", 0.0, UNBOUNDED),
    key!(friction.coefficient, "", 0.0, UNBOUNDED),
    key!(friction.nominal_area, "m^2", 0.0, UNBOUNDED),
    key!(vibration.mass, "kg", 0.0, UNBOUNDED),
    key!(vibration.natural_frequency, "rad/s", 0.0, UNBOUNDED),
    key!(vibration.damping_ratio, "", 0.0, UNBOUNDED),
    key!(vibration.normal_force, "N", 0.0, UNBOUNDED),
    key!(vibration.nominal_area, "m^2", 0.0, UNBOUNDED),
    key!(vibration.belt_velocity, "m/s", 0.0, UNBOUNDED),
    key!(vibration.dimensionless_belt_velocity, "", 0.0, UNBOUNDED),
    key!(vibration.stribeck, "", 0.0, UNBOUNDED),
    key!(vibration.stribeck, "s/m", 0.0, UNBOUNDED),
    key!(vibration.linear_weakening, "", 0.0, UNBOUNDED),
    key!(vibration.spring_angles, "", -UNBOUNDED, UNBOUNDED),
    key!(vibration.springs, "", 0.0, UNBOUNDED),
    key!(vibration.contact_spring, "", 0.0, UNBOUNDED),
    key!(vibration.kinetic_share, "", 0.0, 1.0),
    key!(vibration.stribeck_velocity, "m/s", 0.0, UNBOUNDED),
    key!(vibration.high_speed_share, "", 0.0, 1.0),
    key!(vibration.static_friction, "", 0.0, UNBOUNDED),
    key!(vibration.friction_std, "", 0.0, UNBOUNDED),
    key!(vibration.friction_correlation_length, "m", 0.0, UNBOUNDED),
];

/// Name of the differences between the parts of a rough slider.
pub(in crate::study) const BETWEEN_PARTS: &str = "surface.between_parts";

/// Name of the shortest wave of the surface. A study that does not state it may have it as a value that the scan leaves unknown.
pub(in crate::study) const CUT_OFF: &str = "surface.cut_off";

/// Standard normal values that no study file states: what the scans of either body leave uncertain, differences between scans and between
/// the parts of a rough slider.
pub(super) const LATENT: &[UncertainKey] = &[
    latent("surface", "scan"),
    latent("surface", "between_scans"),
    latent("counterface", "scan"),
    latent("counterface", "between_scans"),
    latent("surface", "between_parts"),
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
