//! The section `[surface]`.

use std::fmt;
use std::path::{Path, PathBuf};

use asperity_base::choice;
use asperity_formats::Decimal;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{self, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::friction::RoughBody;
use crate::quantity::Length;
use crate::study::parse::wrong_length;
use crate::surface::level::Level;
use crate::surface::{CovarianceSource, SurfaceGenerator};
use crate::translation::TranslationKind;

/// Value of `marginal` that takes the distribution of the scans.
const MEASURED: &str = "measured";

/// One scan, or several scans of one part: `"a.x3p"` or `["a.x3p", "b.x3p"]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected the name of a scan, or a list of names")]
pub enum ScanFiles {
    /// One scan.
    One(PathBuf),
    /// Several scans of one part.
    Several(Vec<PathBuf>),
}

impl ScanFiles {
    /// Returns the names of the scans.
    pub fn paths(&self) -> &[PathBuf] {
        match self {
            Self::One(path) => std::slice::from_ref(path),
            Self::Several(paths) => paths,
        }
    }

    /// Returns the same list with each name replaced by `name`.
    #[must_use]
    pub fn map(&self, name: impl Fn(&Path) -> PathBuf) -> Self {
        match self {
            Self::One(path) => Self::One(name(path)),
            Self::Several(paths) => Self::Several(paths.iter().map(|path| name(path)).collect()),
        }
    }
}

impl From<&str> for ScanFiles {
    fn from(path: &str) -> Self {
        Self::One(path.into())
    }
}

choice! {
    /// Decimal sign of a text file.
    pub enum DecimalSign: "decimal sign" {
        /// The comma: `1,234` is 1.234.
        Comma = "comma",
        /// The point: `1,234` is 1234.
        Point = "point",
    }
}

impl From<DecimalSign> for Decimal {
    fn from(sign: DecimalSign) -> Self {
        match sign {
            DecimalSign::Comma => Self::Comma,
            DecimalSign::Point => Self::Point,
        }
    }
}

/// The section `[surface]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceSection {
    /// Scan file, relative to the study file, or a list of scans of one part. The statistics of several scans are
    /// pooled. Random surfaces then have the correlation of all pairs of heights and the distribution of all heights, each relative
    /// to the form of its own scan. All scans must have the same pixel size. Maps and figures show the first scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<ScanFiles>,
    /// Height map to read from a file that contains several: its name, or its number counted from 1.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "name_or_number")]
    #[schemars(schema_with = "name_or_number_schema")]
    pub channel: Option<String>,
    /// Pixel size (x, y), or one value for both. Required for a scan that states none; replaces the size stated in the
    /// file.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "one_or_two")]
    #[schemars(schema_with = "one_or_two_schema")]
    pub pixel_size: Option<[Length; 2]>,
    /// Unit of the heights, such as `um`. Heights of a scan that states none count as metre; the key is required if they would then exceed
    /// the field of view. It replaces the unit stated in the file, and a conversion factor in the header of a text file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_unit: Option<String>,
    /// Decimal sign of a text file in which every comma may be a decimal sign or separate thousands, as in `1,234`. Required for such a
    /// file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimal: Option<DecimalSign>,
    /// Whether the surface has no lay. A study takes a profile, heights along one line, only for such a surface: its spectrum is then that in
    /// all directions.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub isotropic: bool,
    /// Form removed from the scan.
    #[serde(default)]
    pub level: Level,
    /// Limit in robust standard deviations from the median beyond which heights count as missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outliers: Option<f64>,
    /// Cutoff of the S-filter, which removes shorter waves of the scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub s_filter: Option<Length>,
    /// Cutoff of the L-filter, which removes longer waves of the scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub l_filter: Option<Length>,
    /// Whether the L-filter is robust against grooves and spikes.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub robust_filter: bool,
    /// Length of the shortest wave of the random surfaces that exists physically, shorter or longer than the waves that the scan
    /// resolves. When left out, the random surfaces have the waves that the scan resolves, and a verdict takes the length as unknown
    /// between these and twice the pixel. Not used by the Weierstrass–Mandelbrot generator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut_off: Option<Length>,
    /// Generator of the random surfaces.
    #[serde(default)]
    pub generator: SurfaceGenerator,
    /// Covariance of the random surfaces; not used by the Weierstrass–Mandelbrot generator.
    #[serde(default)]
    pub covariance: CovarianceSource,
    /// Standard deviation of the heights of the random surfaces, if not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_height: Option<Length>,
    /// Correlation lengths (x, y) of the random surfaces, or one for both, if not measured: the parameter ℓ of the model. For the
    /// exponential and the squared exponential model it is the lag at which the correlation is 1/e. For the Matérn model it is the
    /// scale and for the self-affine model the roll-off length; their correlation falls to 1/e at another lag.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "one_or_two")]
    #[schemars(schema_with = "one_or_two_schema")]
    pub correlation_length: Option<[Length; 2]>,
    /// Hurst exponent of a self-affine model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hurst: Option<f64>,
    /// Smoothness ν of a Matérn model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothness: Option<f64>,
    /// Fractal dimension, between 2 and 3, of the Weierstrass–Mandelbrot generator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fractal_dimension: Option<f64>,
    /// Marginal distribution of the heights: `measured`, `normal`, `beta:A,B`, …; not used by the
    /// Weierstrass–Mandelbrot generator.
    #[serde(default = "measured")]
    pub marginal: String,
    /// Method that imposes the marginal distribution.
    #[serde(default)]
    pub translation: TranslationKind,
    /// Number of terms of the Karhunen–Loève expansion. When left out, enough for 90 % of the slope variance of a
    /// patch, or all Fourier modes if more than 400 are needed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modes: Option<usize>,
    /// Whether patches include the constant Fourier mode, so that their mean heights differ. Without it the variance of
    /// the other modes is scaled to the total. Applies to Karhunen–Loève expansions on periodic patches.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub mean_mode: bool,
    /// Treatment of the variance that a truncated Karhunen–Loève expansion of normal heights lacks. `true` scales all
    /// heights of a patch by one factor, so that the modes have the full variance on average over the patch; `false`
    /// leaves the heights lower. When left out, the marginal distribution is imposed at every point, as for any other
    /// distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rescale: Option<bool>,
    /// Body that is rough: the `track`, over which the slider passes, or the `slider`, which carries its contacts along. When left
    /// out, `both` with a rough `[counterface]`, otherwise the track. Friction depends on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<RoughBody>,
}

/// Returns the JSON Schema of the values that [`name_or_number`] reads.
pub(super) fn name_or_number_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "anyOf": [{ "type": "string" }, { "type": "integer", "minimum": 1 }] })
}

/// Reads a name, or a number, as text.
pub(super) fn name_or_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    struct NameOrNumber;
    impl Visitor<'_> for NameOrNumber {
        type Value = String;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a name, or a number counted from 1")
        }

        fn visit_str<E: de::Error>(self, name: &str) -> Result<String, E> {
            Ok(name.to_owned())
        }

        fn visit_i64<E: de::Error>(self, number: i64) -> Result<String, E> {
            Ok(number.to_string())
        }

        fn visit_u64<E: de::Error>(self, number: u64) -> Result<String, E> {
            Ok(number.to_string())
        }
    }
    deserializer.deserialize_any(NameOrNumber).map(Some)
}

/// Returns the JSON Schema of the values that [`one_or_two`] reads.
pub(super) fn one_or_two_schema(generator: &mut SchemaGenerator) -> Schema {
    let [one, two] = [generator.subschema_for::<Length>(), generator.subschema_for::<[Length; 2]>()];
    json_schema!({ "anyOf": [one, two] })
}

/// Reads one length for x and y, `"20 um"`, or one for each, `["20 um", "10 um"]`.
pub(super) fn one_or_two<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[Length; 2]>, D::Error> {
    struct OneOrTwo;
    impl<'de> Visitor<'de> for OneOrTwo {
        type Value = [Length; 2];

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a length with its unit, such as \"20 um\", or a list of two, along x and y")
        }

        fn visit_str<E: de::Error>(self, text: &str) -> Result<[Length; 2], E> {
            let both = text.parse().map_err(E::custom)?;
            Ok([both, both])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, lengths: A) -> Result<[Length; 2], A::Error> {
            let lengths = Vec::deserialize(SeqAccessDeserializer::new(lengths))?;
            lengths.try_into().map_err(|lengths: Vec<Length>| wrong_length(lengths.len(), 2))
        }
    }
    deserializer.deserialize_any(OneOrTwo).map(Some)
}

impl Default for SurfaceSection {
    /// Returns the defaults of an empty section.
    fn default() -> Self {
        Self {
            file: None,
            channel: None,
            pixel_size: None,
            height_unit: None,
            decimal: None,
            isotropic: false,
            level: Level::default(),
            outliers: None,
            s_filter: None,
            l_filter: None,
            robust_filter: false,
            cut_off: None,
            generator: SurfaceGenerator::default(),
            covariance: CovarianceSource::default(),
            rms_height: None,
            correlation_length: None,
            hurst: None,
            smoothness: None,
            fractal_dimension: None,
            marginal: measured(),
            translation: TranslationKind::default(),
            modes: None,
            mean_mode: yes(),
            rescale: None,
            body: None,
        }
    }
}

impl SurfaceSection {
    /// Returns the names of the scans; empty for a surface without scans.
    pub fn files(&self) -> &[PathBuf] {
        self.file.as_ref().map_or(&[], ScanFiles::paths)
    }

    /// Returns the marginal distribution as stated; `None` if it is measured.
    pub(in crate::study) fn stated_marginal(&self) -> Option<&str> {
        Some(self.marginal.as_str()).filter(|marginal| *marginal != MEASURED)
    }
}

fn measured() -> String {
    MEASURED.into()
}
fn yes() -> bool {
    true
}
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over references")]
fn is_true(value: &bool) -> bool {
    *value
}
