//! Removal of form by least squares, the F-operation of ISO 25178-2.

mod polynomial;
mod round;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use ndarray::Array2;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use asperity_base::map::{HeightMap, MapError};

/// Highest degree of a polynomial form. Higher degrees would remove waviness and roughness.
pub const MAX_DEGREE: u8 = 12;

/// Form that is removed from the heights.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Level {
    /// No form.
    None,
    /// The mean height.
    Mean,
    /// The least-squares plane.
    #[default]
    Plane,
    /// The least-squares polynomial of total degree two.
    Quadratic,
    /// The least-squares polynomial of this total degree, 0 to [`MAX_DEGREE`].
    Polynomial(u8),
    /// The least-squares circular cylinder, of any axis and tilt, with vertical residuals.
    Cylinder,
    /// The least-squares sphere, with vertical residuals.
    Sphere,
}

impl Level {
    /// The forms without a parameter.
    const PLAIN: [Self; 6] = [Self::None, Self::Mean, Self::Plane, Self::Quadratic, Self::Cylinder, Self::Sphere];

    /// Returns the quadratic polynomial for a cylinder or a sphere, which random maps do not have, and otherwise the form itself.
    pub fn as_polynomial(self) -> Self {
        match self {
            Self::Cylinder | Self::Sphere => Self::Quadratic,
            level => level,
        }
    }
}

impl JsonSchema for Level {
    fn schema_name() -> Cow<'static, str> {
        "Level".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let plain = Self::PLAIN.iter().map(Self::to_string).collect::<Vec<_>>().join("|");
        let degrees = (0..=MAX_DEGREE).map(|degree| degree.to_string()).collect::<Vec<_>>().join("|");
        json_schema!({ "type": "string", "pattern": format!("^({plain}|polynomial:({degrees}))$") })
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Mean => f.write_str("mean"),
            Self::Plane => f.write_str("plane"),
            Self::Quadratic => f.write_str("quadratic"),
            Self::Polynomial(degree) => write!(f, "polynomial:{degree}"),
            Self::Cylinder => f.write_str("cylinder"),
            Self::Sphere => f.write_str("sphere"),
        }
    }
}

impl FromStr for Level {
    type Err = LevelError;

    fn from_str(text: &str) -> Result<Self, LevelError> {
        let plain = Self::PLAIN.into_iter().find(|level| level.to_string() == text);
        let degree = || text.strip_prefix("polynomial:")?.parse().ok().filter(|degree| *degree <= MAX_DEGREE);
        plain.or_else(|| degree().map(Self::Polynomial)).ok_or_else(|| LevelError::Unknown { text: text.into() })
    }
}

impl TryFrom<String> for Level {
    type Error = LevelError;

    fn try_from(text: String) -> Result<Self, LevelError> {
        text.parse()
    }
}

impl From<Level> for String {
    fn from(level: Level) -> Self {
        level.to_string()
    }
}

/// Reason why a form could not be removed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LevelError {
    /// The text names no form.
    #[error(
        "`{text}` is not a form to remove; write none, mean, plane, quadratic, polynomial:N (N up to {MAX_DEGREE}), cylinder \
         or sphere"
    )]
    Unknown {
        /// Text found.
        text: String,
    },
    /// The present points do not determine the form: there are too few, or they lie on a line or conic.
    #[error("the {present} heights that are present do not determine a form `{level}`")]
    Undetermined {
        /// Requested form.
        level: Level,
        /// Number of present heights.
        present: usize,
    },
    /// The search for a cylinder or sphere did not converge.
    #[error("no {level} fits the heights: the search did not converge in {iterations} steps")]
    NotConverged {
        /// Requested form.
        level: Level,
        /// Number of steps.
        iterations: usize,
    },
}

/// A map without its form, and the form.
#[derive(Debug, Clone, PartialEq)]
pub struct Levelled {
    /// Heights minus the form, missing where the heights were missing.
    pub map: HeightMap,
    /// Heights of the form in metre at every point, missing or not, shape `[ny, nx]`; NaN beyond the rim of a cylinder
    /// or sphere.
    pub form_m: Array2<f64>,
    /// Radius of a cylinder or sphere in metre: positive for a ridge or cap, negative for a groove or dish.
    pub radius_m: Option<f64>,
}

/// Removes the least-squares form of the present heights; missing heights stay missing and have no influence.
///
/// Residuals are vertical. The result does not depend on pitch, offset or mask beyond rounding. If only the rounding
/// error of the heights remains, it is set to zero: a perfect plane has no roughness.
///
/// # Errors
/// [`LevelError::Undetermined`] if the present points do not determine the form, [`LevelError::NotConverged`] if the
/// search for a cylinder or sphere does not converge.
pub fn remove_form(map: &HeightMap, level: Level) -> Result<Levelled, LevelError> {
    let present = map.grid().points() - map.missing_points();
    let undetermined = |_| LevelError::Undetermined { level, present };
    let (form_m, radius_m) = match level {
        Level::None => (Array2::zeros(map.grid().shape()), None),
        Level::Mean => (polynomial::fit(map, 0).map_err(undetermined)?, None),
        Level::Plane => (polynomial::fit(map, 1).map_err(undetermined)?, None),
        Level::Quadratic => (polynomial::fit(map, 2).map_err(undetermined)?, None),
        Level::Polynomial(degree) => (polynomial::fit(map, degree.min(MAX_DEGREE).into()).map_err(undetermined)?, None),
        Level::Cylinder | Level::Sphere => {
            let fitted = round::fit(map, level == Level::Cylinder).map_err(|error| match error {
                round::RoundError::Undetermined => undetermined(polynomial::Undetermined),
                round::RoundError::NotConverged { iterations } => LevelError::NotConverged { level, iterations },
            })?;
            (fitted.heights_m, Some(fitted.radius_m))
        }
    };
    if level == Level::None {
        return Ok(Levelled { map: map.clone(), form_m, radius_m });
    }
    let mut left = map.heights_m() - &form_m;
    // Residuals no larger than the rounding of the heights are not roughness.
    let largest_m = map.present_m().fold(0.0, |m: f64, z| m.max(z.abs()));
    let rounding_m = 16.0 * f64::EPSILON * largest_m;
    if left.iter().all(|z| z.is_nan() || z.abs() <= rounding_m) {
        left.mapv_inplace(|z| if z.is_nan() { z } else { 0.0 });
    }
    let map = HeightMap::new(map.grid(), left).map_err(|_: MapError| undetermined(polynomial::Undetermined))?;
    Ok(Levelled { map, form_m, radius_m })
}

/// A form whose root-mean-square height exceeds that of the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DominantForm {
    /// The form, a plane or a quadratic polynomial.
    pub level: Level,
    /// Root mean square height of the form about its mean, in metre.
    pub form_rms_m: f64,
    /// Root mean square height of the rest, in metre.
    pub roughness_rms_m: f64,
}

/// Returns the least-squares form of an unlevelled map if its root-mean-square height exceeds that of the rest.
///
/// The form is quadratic if its quadratic part exceeds the rest, otherwise a plane. Returns `None` if neither exceeds
/// the rest or the heights do not determine it.
pub fn dominant_form(map: &HeightMap) -> Option<DominantForm> {
    let rms_after = |level: Level| {
        let left = remove_form(map, level).ok()?.map;
        let (count, sum) = left.present_m().fold((0.0, 0.0), |(count, sum), z| (count + 1.0, sum + z * z));
        Some(f64::sqrt(sum / count))
    };
    let (mean, plane) = (rms_after(Level::Mean)?, rms_after(Level::Plane)?);
    // Residuals of least squares are orthogonal to the form.
    let between = |before: f64, after: f64| (before * before - after * after).max(0.0).sqrt();
    let quadratic = rms_after(Level::Quadratic).unwrap_or(plane);
    let (level, rest) =
        if between(plane, quadratic) > quadratic { (Level::Quadratic, quadratic) } else { (Level::Plane, plane) };
    let form_rms_m = between(mean, rest);
    (form_rms_m > rest).then_some(DominantForm { level, form_rms_m, roughness_rms_m: rest })
}
