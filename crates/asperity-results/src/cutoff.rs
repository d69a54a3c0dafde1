//! Friction over the shortest wavelength, in `results.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Pair;

/// Dependence of the mean friction coefficient on the shortest waves of the random surface.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CutoffResult {
    /// Mean pressure on every strip: the mean pressure at the operating point.
    pub mean_pressure_pa: f64,
    /// Strips solved for each entry, with the same random numbers.
    pub strips: usize,
    /// Length of the strips.
    pub strip_length_m: f64,
    /// Pitch of the strips, the larger one if the two differ.
    pub pitch_m: f64,
    /// Shortest wavelength on the study's own strips: twice the pitch, or the shortest wave that the scan resolves.
    pub cutoff_m: f64,
    /// Shortest wavelength at which the spectrum of the scan is reliable; `null` without a scan, or if there is none.
    pub band_end_m: Option<f64>,
    /// Least friction coefficient, reached if all contacts are at the hardness; `null` without a hardness.
    pub plastic_floor: Option<f64>,
    /// One entry per cut-off, from the study's own upwards, in octaves.
    pub points: Vec<CutoffPoint>,
    /// The same surface at the study's own cut-off, solved on half the pitch and, while the error of the pitch matters and the work is
    /// affordable, on half of that.
    pub finer_pitches: Vec<FinerPitch>,
    /// Dependence of the friction coefficient on the shortest waves, in a sentence.
    pub known: String,
}

/// Mean friction without the waves that are shorter than a cut-off.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CutoffPoint {
    /// Cut-off wavelength of the Gaussian filter; the first entry is the strips, without a filter.
    pub cutoff_m: f64,
    /// Friction coefficient μ = ΣF/ΣN.
    pub mean: f64,
    /// Interval of the mean: it contains the error of the study's own mean and of the ratio to it.
    pub mean_interval: Option<Pair>,
    /// Root mean square gradient of the heights, by differences over the pitch.
    pub rms_slope: f64,
    /// Fraction of the contact cells at the hardness.
    pub plastic_fraction: f64,
}

/// Mean friction of the same surface on smaller cells, not extrapolated.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FinerPitch {
    /// Pitch of the cells.
    pub pitch_m: f64,
    /// Friction coefficient μ = ΣF/ΣN.
    pub mean: f64,
    /// 95 % interval of `mean`.
    pub mean_interval: Option<Pair>,
    /// Difference from the mean at the pitch of the strips; it is not extrapolated either.
    pub change: f64,
    /// Interval of the difference, which the common random numbers make narrow.
    pub change_interval: Pair,
}

/// Friction of the scan itself, pressed at the operating point.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScanFriction {
    /// Size of the pressed part of the scan.
    pub size_m: Pair,
    /// Pitches of the solved grids: the larger pixel size and halves of it.
    pub pitches_m: Vec<f64>,
    /// Rms slope of a strip over that of the scan, both within the resolved waves; `null` if these waves do not fit on the maps.
    pub slope_ratio: Option<f64>,
    /// One entry per cut-off: without waves shorter than those of the strips, between, and with all waves down to twice the pixel.
    pub cut_offs: Vec<ScanCutoff>,
}

/// Friction of the scan without the waves that are shorter than a cut-off.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScanCutoff {
    /// Length of the shortest wave.
    pub cutoff_m: f64,
    /// Friction coefficient μ = ΣF/ΣN, extrapolated in the pitch.
    pub mean: f64,
    /// 95 % interval for the surface of which the scan is a sample, from the differences between its sixteen tiles.
    pub mean_interval: Pair,
    /// Error of the mean due to the pitch; `null` if one pitch was solved.
    pub grid_error: Option<f64>,
    /// Observed order of convergence in the pitch; `null` if it is below 0.5 or unknown.
    pub order: Option<f64>,
    /// Standard deviation of friction between windows of a sixteenth by a quarter of the scan, at the mean load; 0 in results of earlier
    /// versions.
    #[serde(default)]
    pub std: f64,
    /// Root mean square gradient of the heights, by differences over the pixels.
    pub rms_slope: f64,
    /// Fraction of the contact cells at the hardness.
    pub plastic_fraction: f64,
}
