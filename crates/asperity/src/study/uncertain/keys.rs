//! Access to the inputs of a study file, and their texts.

use asperity_results::keys::{KEYS, Key};
use asperity_results::study_keys;
use toml::Value;

use crate::friction::law::WindowLawKind;
use crate::quantity::{
    AngularFrequency, Area, Dimension, Force, InverseVelocity, Length, Mass, Pressure, QuantityError, Velocity,
    percentage,
};
use crate::study::StudyFile;
use crate::study::file::{ContactSpring, Stribeck};
use crate::vibration::law::VelocityLawKind;

/// Access to the number of an input in SI. A unit tells numbers and quantities of the same name apart.
#[derive(Debug)]
pub(in crate::study) struct Access {
    is_stated: fn(&StudyFile) -> bool,
    get: fn(&StudyFile, unit: &str, element: Option<usize>) -> Option<f64>,
    set: fn(&mut StudyFile, unit: &str, element: Option<usize>, f64),
}

impl Access {
    /// Returns whether a file states the input, also by a word where it may be a number.
    pub(in crate::study) fn is_stated(&self, file: &StudyFile) -> bool {
        (self.is_stated)(file)
    }

    /// Returns the number, or that of one element of a list; `None` if the file does not state it.
    pub(in crate::study) fn get(&self, file: &StudyFile, key: &Key, element: Option<usize>) -> Option<f64> {
        (self.get)(file, key.unit, element)
    }

    /// Replaces the number, or that of one element or of all of a list, if the file states it.
    pub(in crate::study) fn set(&self, file: &mut StudyFile, key: &Key, element: Option<usize>, value: f64) {
        (self.set)(file, key.unit, element, value);
    }
}

macro_rules! access {
    ($section:ident.$name:ident: word $($facts:tt)*) => {
        Access { is_stated: |_| false, get: |_, _, _| None, set: |_, _, _, _| {} }
    };
    ($section:ident.$name:ident: $($facts:tt)*) => {
        Access {
            is_stated: |file| file.$section.as_ref().is_some_and(|section| section.$name.is_stated()),
            get: |file, unit, element| file.$section.as_ref()?.$name.get(unit, element),
            set: |file, unit, element, value| {
                if let Some(section) = &mut file.$section {
                    section.$name.set(unit, element, value);
                }
            },
        }
    };
}

/// Access to each of [`KEYS`].
const ACCESS: &[Access] = &study_keys!(access);

/// Returns all numbers and quantities that may be uncertain, with their access.
pub(in crate::study) fn numbers() -> impl Iterator<Item = (&'static Key, &'static Access)> {
    KEYS.iter().zip(ACCESS).filter(|(key, _)| key.bounds.is_some())
}

/// Returns the word of its section that decides whether an input has an effect, by name, and the values with which it has.
pub(in crate::study) fn needs(key: &Key) -> Option<(&'static str, Vec<&'static str>)> {
    let path = key.path();
    let reads = |inputs: &[&str]| inputs.contains(&path.as_str());
    let (name, laws): (_, Vec<&str>) = match key.section {
        "vibration" => {
            let laws = VelocityLawKind::ALL.iter().filter(|law| reads(law.statement().inputs));
            ("velocity_law", laws.map(|law| law.name()).collect())
        }
        "friction" => {
            let laws = WindowLawKind::ALL.iter().filter(|law| reads(law.statement().inputs));
            ("law", laws.map(|law| law.name()).collect())
        }
        _ => return None,
    };
    if laws.is_empty() { key.needs.map(|(name, word)| (name, vec![word])) } else { Some((name, laws)) }
}

/// Returns the number or quantity of this name; of one that may be either, the form of `value`.
pub(super) fn find(section: &str, name: &str, value: &Value) -> Option<(&'static Key, &'static Access)> {
    let mut found = numbers().filter(|(key, _)| (key.section, key.name) == (section, name));
    let first = found.next()?;
    let is_percentage = value.as_str().is_some_and(|text| percentage(text).is_some());
    let is_number = is_percentage || matches!(value, Value::Float(_) | Value::Integer(_));
    let other = found.find(|(key, _)| key.unit.is_empty() == is_number);
    Some(other.filter(|_| first.0.unit.is_empty() != is_number).unwrap_or(first))
}

/// Reads a number or quantity in SI.
pub(in crate::study) fn parse(key: &Key, value: &Value) -> Result<f64, String> {
    let quantity = |text: &str| {
        let dimension = Dimension::of_unit(key.unit).ok_or_else(|| format!("`{text}` is not a number"))?;
        dimension.parse(text).map_err(|error: QuantityError| error.to_string())
    };
    match value {
        Value::Float(number) if key.unit.is_empty() => Ok(*number),
        Value::Integer(number) if key.unit.is_empty() => Ok(*number as f64),
        Value::String(text) => {
            percentage(text).filter(|_| key.unit.is_empty() && key.percentage).map_or_else(|| quantity(text), Ok)
        }
        other => quantity(&other.to_string()),
    }
}

/// Returns a number in SI as a study file states it.
pub(in crate::study) fn show(key: &Key, value: f64) -> Value {
    if key.unit.is_empty() { Value::Float(value) } else { Value::String(format!("{value:?} {}", key.unit)) }
}

/// Number of a study file in SI, or a list of numbers.
trait Numbers {
    fn is_stated(&self) -> bool {
        true
    }

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
    fn is_stated(&self) -> bool {
        self.is_some()
    }

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
