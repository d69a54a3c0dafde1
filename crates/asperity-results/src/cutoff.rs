//! Friction against the shortest waves kept, in `results.json`.

use serde::{Deserialize, Serialize};

use crate::Pair;

/// How far the mean friction coefficient depends on the shortest waves that the random surface keeps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutoffResult {
    /// Mean pressure on every strip: the mean pressure at the operating point.
    pub mean_pressure_pa: f64,
    /// Strips solved for each entry, with the same random numbers.
    pub strips: usize,
    /// Length of these strips.
    pub strip_length_m: f64,
    /// Pitch of these strips, the larger one where the two differ.
    pub pitch_m: f64,
    /// Shortest wavelength on the study's own strips: twice the pitch.
    pub cutoff_m: f64,
    /// Shortest wavelength at which the spectrum of the scan is reliable; `null` without a scan, or where nothing is.
    pub band_end_m: Option<f64>,
    /// Least friction coefficient, reached where all contacts have the hardness; `null` without a hardness.
    pub plastic_floor: Option<f64>,
    /// One entry per cut-off, from the study's own upwards, in octaves.
    pub points: Vec<CutoffPoint>,
    /// The same surface at the study's own cut-off, solved with half the pitch; `null` if there is no solution.
    pub halved_pitch: Option<HalvedPitch>,
    /// How far the friction coefficient depends on the shortest waves, in a sentence.
    pub known: String,
}

/// Mean friction without the waves that are shorter than a cut-off.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutoffPoint {
    /// Cut-off wavelength of the Gaussian filter; the first entry is twice the pitch, without a filter.
    pub cutoff_m: f64,
    /// μ = ΣF/ΣN.
    pub mean: f64,
    /// Interval of the mean: it contains the error of the study's own mean and of the ratio to it.
    pub mean_interval: Option<Pair>,
    /// Root mean square gradient of the heights, by differences over the pitch.
    pub rms_slope: f64,
    /// Fraction of the contact cells at the hardness.
    pub plastic_fraction: f64,
}

/// Mean friction of the same surface on cells of half the pitch.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HalvedPitch {
    /// The pitch.
    pub pitch_m: f64,
    /// μ = ΣF/ΣN.
    pub mean: f64,
    /// Its interval.
    pub mean_interval: Option<Pair>,
    /// Its difference from the study's own mean.
    pub change: f64,
    /// Interval of the difference, which the common random numbers make narrow.
    pub change_interval: Pair,
}
