//! Reason why a random surface could not be modelled on a scan or made.

use thiserror::Error;

use asperity_base::correlation::{CovarianceError, EstimateError, FitError, MeasuredCovarianceError};
use asperity_base::distribution::DistributionError;
use asperity_base::map::MapError;
use asperity_base::sentence;

use crate::areal::ArealError;
use crate::fractal::FractalError;
use crate::level::Level;
use crate::pooling::PoolingError;
use crate::preparation::PreparationError;
use crate::uncertainty::UncertaintyError;
use crate::{GeneratorError, TranslationError};

/// Reason why a random surface could not be modelled on a scan or made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SurfaceModelError {
    /// A quantity is to be measured, but there is no scan.
    #[error("random surface: {0} is to be measured, but there is no scan; state a value")]
    NoScan(&'static str),
    /// Scans of one part have different pixels.
    #[error(
        "{file} has pixels of {} and {first} of {}: scans of one part must have the same, or their correlations cannot be \
         pooled",
        sentence::size(.pitch_m.0, .pitch_m.1),
        sentence::size(.first_pitch_m.0, .first_pitch_m.1)
    )]
    Pitch {
        /// Name of the scan.
        file: String,
        /// Its pitch along x and y in metre.
        pitch_m: (f64, f64),
        /// Name of the first scan.
        first: String,
        /// Its pitch along x and y in metre.
        first_pitch_m: (f64, f64),
    },
    /// The scans cannot be pooled.
    #[error("the scans of [surface] file: {0}")]
    Pooling(#[from] PoolingError),
    /// The scan cannot be levelled or filtered.
    #[error(transparent)]
    Preparation(#[from] PreparationError),
    /// The surface has no texture.
    #[error("surface: {0}")]
    Areal(#[from] ArealError),
    /// The surface has no texture after its form is removed.
    #[error(
        "surface: once the form ({level}) is removed, all {present} heights that are present are equal: a surface without \
         roughness has no texture parameters"
    )]
    FormAlone {
        /// Form that was removed.
        level: Level,
        /// Number of present heights.
        present: usize,
    },
    /// The surface has no scaling.
    #[error("surface: {0}")]
    Fractal(#[from] FractalError),
    /// The correlation cannot be estimated.
    #[error("surface: {0}")]
    Estimate(#[from] EstimateError),
    /// The intervals of the statistics cannot be computed.
    #[error("surface: {0}")]
    Uncertainty(#[from] UncertaintyError),
    /// The covariance cannot be fitted.
    #[error("covariance of the scan: {0}; state a covariance in [surface]")]
    Fit(#[from] FitError),
    /// The correlation of the scan makes no covariance.
    #[error("covariance of the scan: {0}; state a covariance in [surface]")]
    Empirical(#[from] MeasuredCovarianceError),
    /// The stated covariance is invalid.
    #[error("[surface] covariance: {0}")]
    Covariance(#[from] CovarianceError),
    /// A distribution is invalid.
    #[error("{0}")]
    Distribution(#[from] DistributionError),
    /// The random surface cannot be generated.
    #[error("random surface: {0}")]
    Generator(#[from] GeneratorError),
    /// The random surface cannot have its marginal distribution.
    #[error("random surface: {0}")]
    Translation(#[from] TranslationError),
    /// The grid of the trial maps is invalid.
    #[error("[trial maps] {0}")]
    TrialGrid(MapError),
    /// A patch that is not periodic has no constant mode to leave out.
    #[error(
        "[surface] mean_mode: only periodic patches have a constant Fourier mode to leave out; set boundary = \"periodic\""
    )]
    ConstantMode,
    /// The Weierstrass–Mandelbrot generator has no fractal dimension.
    #[error(
        "the scan shows no scaling range, so its fractal dimension cannot be measured; state a `fractal_dimension` strictly \
         between 2 and 3"
    )]
    FractalDimension,
    /// The counterface cannot be modelled or generated.
    #[error("counterface: {0}")]
    Counterface(Box<SurfaceModelError>),
}
