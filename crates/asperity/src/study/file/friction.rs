//! The section `[friction]`.

use asperity_base::choice;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::pressure::solve_tolerance;
use crate::friction::law::WindowLawKind;
use crate::map::BoundaryKind;
use crate::quantity::{Area, Compliance, Length, Pressure};
use crate::study::ScanSizes;
use crate::study::standard_deviation::{LengthStd, NumberStd};

choice! {
    /// Shape of the window.
    #[derive(Default)]
    pub enum WindowShape: "shape of the window" {
        /// Full length and width of the window.
        #[default]
        Rectangle = "rectangle",
        /// Ellipse inscribed in the window.
        Ellipse = "ellipse",
    }
}

/// The section `[friction]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionSection {
    /// Size (x, y) of a strip; it slides along x. When left out, ten windows along and some correlation lengths of the
    /// scan across, or 6 mm and 75 µm without a scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strip: Option<[Length; 2]>,
    /// Points (x, y) of a strip. When left out, four to the shortest wave of the scan, or 2048 and 32 without a scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<[usize; 2]>,
    /// Length of the window along x. When left out, a tenth of the strip, or 600 µm without a scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<Length>,
    /// Width of the window along y; the width of the strip when left out. Narrower windows lie side by side on a
    /// periodic strip, and each track gives its own record.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window_width: Option<Length>,
    /// Shape of the window.
    #[serde(default, skip_serializing_if = "is_default")]
    pub window_shape: WindowShape,
    /// Friction law. Its τ_max is `shear_strength` of `[material]`.
    #[serde(default)]
    pub law: WindowLawKind,
    /// Coefficient α of the pressure-dependent law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_coefficient: Option<f64>,
    /// Friction coefficient μ of Coulomb's law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficient: Option<f64>,
    /// Boundary of a strip.
    #[serde(default = "periodic")]
    pub boundary: BoundaryKind,
    /// Mean compliance of a periodic strip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_compliance: Option<Compliance>,
    /// Levels as percentages of the heights (of the ensemble) above the plane, which has the same position in space for
    /// all strips. Five default levels when left out, unless other levels are stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub percentiles: Option<Vec<f64>>,
    /// Further levels: mean pressures on each strip.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mean_pressures: Vec<Pressure>,
    /// Further levels: depths of the plane below the highest point of each strip.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub penetrations: Vec<Length>,
    /// Area over which windows average in the `area` upscaling; when left out, the area of `[vibration]`, or else 833
    /// mm².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal_area: Option<Area>,
    /// Strips per level.
    #[serde(default = "realisations")]
    pub realisations: usize,
    /// Relative tolerance of each contact solve.
    #[serde(default = "solve_tolerance")]
    pub tolerance: f64,
    /// Uncertain parameters of the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintySection>,
}

/// The section `[friction.uncertainty]`: standard deviations of the surface's parameters about their values in the
/// study. The parameters are independent. At least one is stated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UncertaintySection {
    /// Standard deviation of the rms height, which is lognormal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_height: Option<LengthStd>,
    /// Standard deviation of the correlation length along x, which is lognormal. The length along y and all lags are
    /// proportional to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub correlation_length: Option<LengthStd>,
    /// Standard deviation of the skewness of the heights, which is normal. Heights then have Johnson's distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skewness: Option<NumberStd>,
    /// Number of surfaces, each with other parameters.
    #[serde(default = "uncertainty_points")]
    pub points: usize,
    /// Number of strips of each surface, the same for all; when left out, half as many as for the levels, at least 4.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub realisations: Option<usize>,
}

impl FrictionSection {
    /// Returns size, points and window of a strip: the stated ones, or else those that suit the scan, or usual ones.
    pub(in crate::study) fn sizes(&self, of_scan: Option<&ScanSizes>) -> ([Length; 2], [usize; 2], Length) {
        let strip = self.strip.unwrap_or_else(|| of_scan.map_or(STRIP_M, |sizes| sizes.strip_m).map(Length));
        let points = self.points.unwrap_or_else(|| match (of_scan, self.strip) {
            (None, _) => STRIP_POINTS,
            (Some(sizes), None) => sizes.strip_points,
            (Some(sizes), Some(strip)) => sizes.points_of(strip.map(|side| side.0)),
        });
        let window_m = if of_scan.is_some() { ScanSizes::window_m(strip[0].0) } else { WINDOW_M };
        (strip, points, self.window.unwrap_or(Length(window_m)))
    }

    /// Fills in the sizes that are left out.
    pub(in crate::study) fn fill_in_sizes(&mut self, of_scan: Option<&ScanSizes>) {
        let (strip, points, window) = self.sizes(of_scan);
        (self.strip, self.points, self.window) = (Some(strip), Some(points), Some(window));
    }

    /// Returns the percentages of the heights above the plane: the stated ones or, if no level is stated, the defaults.
    pub fn percentiles(&self) -> &[f64] {
        match &self.percentiles {
            Some(stated) => stated,
            None if self.mean_pressures.is_empty() && self.penetrations.is_empty() => &PERCENTILES,
            None => &[],
        }
    }
}

/// Returns length and width of the default window in metre.
pub(in crate::study) fn usual_window_m() -> [f64; 2] {
    [WINDOW_M, STRIP_M[1]]
}

/// Sides (x, y) and points of a strip, and length of a window, of studies without a scan.
const STRIP_M: [f64; 2] = [6e-3, 75e-6];
const STRIP_POINTS: [usize; 2] = [2048, 32];
const WINDOW_M: f64 = 600e-6;

/// Default levels of the friction stage, in percent.
const PERCENTILES: [f64; 5] = [5.0, 10.0, 25.0, 50.0, 75.0];
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
fn periodic() -> BoundaryKind {
    BoundaryKind::Periodic
}
fn realisations() -> usize {
    20
}
fn uncertainty_points() -> usize {
    32
}
