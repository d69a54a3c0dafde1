//! The section `[counterface]`.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::surface::{name_or_number, name_or_number_schema, one_or_two, one_or_two_schema};
use super::{DecimalSign, ScanFiles, SurfaceSection};
use crate::contact::Elastic;
use crate::quantity::{Length, Pressure};
use crate::surface::CovarianceSource;
use crate::surface::level::Level;
use crate::translation::TranslationKind;

/// The section `[counterface]`: the body that is pressed against the surface. Without the section it is smooth and rigid.
///
/// The roughness keys have the meaning of the same keys of `[surface]`. The counterface is smooth if the section states none of
/// `file`, `covariance`, `rms_height`, `correlation_length`, `hurst`, `smoothness`, `fractal_dimension` and `marginal`. Its random
/// maps have the generator, `modes`, `mean_mode` and `rescale` of `[surface]`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CounterfaceSection {
    /// Young's modulus; rigid when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub youngs_modulus: Option<Pressure>,
    /// Poisson's ratio; 0.3 when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poisson_ratio: Option<f64>,
    /// Hardness. The lower hardness of the two bodies bounds the pressure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardness: Option<Pressure>,
    /// Scan file, relative to the study file, or a list of scans of one part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<ScanFiles>,
    /// Height map to read from a file that contains several: its name, or its number counted from 1.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "name_or_number")]
    #[schemars(schema_with = "name_or_number_schema")]
    pub channel: Option<String>,
    /// Pixel size (x, y), or one value for both.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "one_or_two")]
    #[schemars(schema_with = "one_or_two_schema")]
    pub pixel_size: Option<[Length; 2]>,
    /// Unit of the heights, such as `um`, as in `[surface]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_unit: Option<String>,
    /// Decimal sign of a text file, as in `[surface]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimal: Option<DecimalSign>,
    /// Form removed from the scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<Level>,
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
    /// Covariance of the random counterface; measured when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance: Option<CovarianceSource>,
    /// Standard deviation of the heights, if not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_height: Option<Length>,
    /// Correlation lengths (x, y), or one for both, if not measured.
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
    /// Marginal distribution of the heights; measured when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub marginal: Option<String>,
    /// Method that imposes the marginal distribution; that of `[surface]` when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translation: Option<TranslationKind>,
}

impl CounterfaceSection {
    /// Returns the key, if any, that makes the counterface rough.
    pub(in crate::study) fn roughness_key(&self) -> Option<&'static str> {
        let keys = [
            ("file", self.file.is_some()),
            ("rms_height", self.rms_height.is_some()),
            ("covariance", self.covariance.is_some()),
            ("correlation_length", self.correlation_length.is_some()),
            ("hurst", self.hurst.is_some()),
            ("smoothness", self.smoothness.is_some()),
            ("fractal_dimension", self.fractal_dimension.is_some()),
            ("marginal", self.marginal.is_some()),
        ];
        keys.into_iter().find(|(_, stated)| *stated).map(|(key, _)| key)
    }

    /// Returns the elastic constants; `None` if the counterface is rigid.
    pub(in crate::study) fn elastic(&self) -> Option<Elastic> {
        let modulus = self.youngs_modulus?;
        Some(Elastic {
            youngs_modulus_pa: modulus.0,
            poisson_ratio: self.poisson_ratio.unwrap_or(Elastic::POISSON_RATIO),
        })
    }

    /// Returns the scan files; empty without scans.
    pub fn files(&self) -> &[PathBuf] {
        self.file.as_ref().map_or(&[], ScanFiles::paths)
    }

    /// Returns the roughness as a section of its own, made by the generator of `surface`.
    pub(in crate::study) fn roughness(&self, surface: &SurfaceSection) -> SurfaceSection {
        let own = self.clone();
        SurfaceSection {
            file: own.file,
            channel: own.channel,
            pixel_size: own.pixel_size,
            height_unit: own.height_unit,
            decimal: own.decimal,
            level: own.level.unwrap_or_default(),
            outliers: own.outliers,
            s_filter: own.s_filter,
            l_filter: own.l_filter,
            robust_filter: own.robust_filter,
            cut_off: None,
            covariance: own.covariance.unwrap_or_default(),
            rms_height: own.rms_height,
            correlation_length: own.correlation_length,
            hurst: own.hurst,
            smoothness: own.smoothness,
            fractal_dimension: own.fractal_dimension,
            marginal: own.marginal.unwrap_or_else(|| SurfaceSection::default().marginal),
            translation: own.translation.unwrap_or(surface.translation),
            body: None,
            ..surface.clone()
        }
    }
}
