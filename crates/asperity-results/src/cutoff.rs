//! Friction against the shortest waves kept, in `results.json`.

use serde::{Deserialize, Serialize};

use crate::Pair;

/// How far the mean friction coefficient depends on the shortest waves that the random surface keeps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutoffResult {
    /// Mean pressure on every strip, that of the leading level.
    pub mean_pressure_pa: f64,
    /// Strips solved for each entry, all of the same random numbers.
    pub strips: usize,
    /// Their length.
    pub strip_length_m: f64,
    /// Pitch of the strips, the larger one where the two differ.
    pub pitch_m: f64,
    /// Shortest wavelength that the study's own strips hold: twice the pitch.
    pub cutoff_m: f64,
    /// Shortest wavelength at which the spectrum of the scan is reliable; `null` without a scan, or where nothing is.
    pub band_end_m: Option<f64>,
    /// Least coefficient, that of contacts which all have the hardness; `null` without a hardness.
    pub plastic_floor: Option<f64>,
    /// From the study's own cut-off upwards, in octaves.
    pub points: Vec<CutoffPoint>,
    /// The same surface at the study's own cut-off, solved with half the pitch; `null` where that has no solution.
    pub halved_pitch: Option<HalvedPitch>,
    /// What is known, in a sentence.
    pub known: String,
}

/// Mean friction without the waves that are shorter than a cut-off.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutoffPoint {
    /// Cut-off wavelength of the Gaussian filter; the first is that of the pitch, without a filter.
    pub cutoff_m: f64,
    /// μ = ΣF/ΣN.
    pub mean: f64,
    /// Its interval: the interval of the study's own mean, and that of the ratio to it.
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
