//! Why a study ended early.

use asperity_formats::FormatError;
use thiserror::Error;

use crate::chaos::PropagationError;
use crate::contact::ContactError;
use crate::correlation::{CovarianceError, EstimateError, FitError, MeasuredCovarianceError};
use crate::distribution::DistributionError;
use crate::friction::FrictionError;
use crate::friction::process::ProcessError;
use crate::friction::window::WindowError;
use crate::map::MapError;
use crate::monitor::Cancelled;
use crate::pressure::PressureError;
use crate::stats::StatsError;
use crate::study::sentence;
use crate::surface::areal::ArealError;
use crate::surface::filter::FilterError;
use crate::surface::fractal::FractalError;
use crate::surface::level::Level;
use crate::surface::pooling::PoolingError;
use crate::surface::preparation::PreparationError;
use crate::surface::uncertainty::UncertaintyError;
use crate::surface::{GeneratorError, TranslationError};
use crate::vibration::{LARGEST_CLIPPED_FRACTION, VibrationError};

/// Why a study ended early.
#[derive(Debug, Error)]
pub enum StudyError {
    /// The scan cannot be read.
    #[error(transparent)]
    Scan(#[from] FormatError),
    /// The scan makes no height map.
    #[error("{file}: {error}")]
    Map {
        /// The scan file.
        file: String,
        /// What is wrong.
        error: MapError,
    },
    /// One of several scans cannot be used.
    #[error("{file}: {error}")]
    OneOf {
        /// The scan file.
        file: String,
        /// What is wrong.
        error: Box<StudyError>,
    },
    /// Scans of one part have different pixels.
    #[error(
        "{file} has pixels of {} and {first} of {}: scans of one part must have the same, or their correlations cannot be \
         pooled",
        sentence::size(.pitch_m.0, .pitch_m.1),
        sentence::size(.first_pitch_m.0, .first_pitch_m.1)
    )]
    Pitch {
        /// The scan file.
        file: String,
        /// Its pitch along x and y in metre.
        pitch_m: (f64, f64),
        /// The first scan file.
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
    /// The surface has no texture once its form is removed.
    #[error(
        "surface: once the form ({level}) is removed, all {present} heights that are present are equal: a surface without \
         roughness has no texture parameters"
    )]
    FormAlone {
        /// The form.
        level: Level,
        /// Heights present.
        present: usize,
    },
    /// The surface has no scaling.
    #[error("surface: {0}")]
    Fractal(#[from] FractalError),
    /// The correlation cannot be estimated.
    #[error("surface: {0}")]
    Estimate(#[from] EstimateError),
    /// Intervals of its statistics cannot be had.
    #[error("surface: {0}")]
    Uncertainty(#[from] UncertaintyError),
    /// The covariance cannot be fitted.
    #[error("covariance of the scan: {0}; state a covariance in [surface]")]
    Fit(#[from] FitError),
    /// The scan's own correlation makes no covariance.
    #[error("covariance of the scan: {0}; state a covariance in [surface]")]
    Empirical(#[from] MeasuredCovarianceError),
    /// The stated covariance is not one.
    #[error("[surface] covariance: {0}")]
    Covariance(#[from] CovarianceError),
    /// A law is not one.
    #[error("{0}")]
    Law(#[from] DistributionError),
    /// A random surface cannot be made.
    #[error("random surface: {0}")]
    Generator(#[from] GeneratorError),
    /// A random surface cannot be given its marginal law.
    #[error("random surface: {0}")]
    Translation(#[from] TranslationError),
    /// A grid of the study is not one.
    #[error("[{section}] {error}")]
    Grid {
        /// Section of the study.
        section: &'static str,
        /// What is wrong.
        error: MapError,
    },
    /// A contact problem cannot be posed.
    #[error("[{section}] {error}")]
    Contact {
        /// Section of the study.
        section: &'static str,
        /// What is wrong.
        error: ContactError,
    },
    /// The pressure stage failed.
    #[error("pressure: {0}")]
    Pressure(#[from] PressureError),
    /// The window does not fit.
    #[error("[friction] {0}")]
    Window(#[from] WindowError),
    /// A level of the friction stage failed.
    #[error("friction at {level}: {error}")]
    Friction {
        /// The level.
        level: String,
        /// What is wrong.
        error: FrictionError,
    },
    /// A parameter of the surface is as uncertain as measured, and no interval was.
    #[error(
        "[friction.uncertainty] {key}: the scan holds too few correlation lengths for an interval of {statistic}; state a \
         standard deviation instead of \"measured\""
    )]
    NoInterval {
        /// Key of the section.
        key: &'static str,
        /// Statistic of the scan.
        statistic: &'static str,
    },
    /// Uncertain parameters could not be propagated.
    #[error("[friction.uncertainty] {0}")]
    Propagation(#[from] PropagationError),
    /// The heights of the scan have no histogram.
    #[error("heights: {0}")]
    Heights(StatsError),
    /// A patch that is not periodic has no constant mode to leave out.
    #[error(
        "[surface] mean_mode: only periodic patches have a constant Fourier mode to leave out; set boundary = \"periodic\""
    )]
    ConstantMode,
    /// The Weierstrass–Mandelbrot generator lacks its dimension.
    #[error(
        "[surface] fractal_dimension: the scan shows no scaling range to measure it on; state a value strictly between 2 \
         and 3"
    )]
    FractalDimension,
    /// The friction process cannot be made.
    #[error("friction process: {0}")]
    Process(#[from] ProcessError),
    /// The file of a fitted process cannot be used.
    #[error("[vibration] friction_process: {file}: {reason}")]
    FrictionProcess {
        /// The file.
        file: String,
        /// What is wrong.
        reason: String,
    },
    /// Too many friction values would be clipped to stay positive.
    #[error(
        "vibration: with the {upscaling} upscaling, {} % of the friction values would be clipped to stay positive, more than {} %; \
         lower the standard deviation of friction or its weakening with velocity, or set `allow_clipping = true` in [vibration]",
        sentence::digits(100.0 * .fraction),
        100.0 * LARGEST_CLIPPED_FRACTION
    )]
    Clipped {
        /// The upscaling, `paper` or `area`.
        upscaling: &'static str,
        /// Fraction of the values.
        fraction: f64,
        /// Whether the friction stage computed the friction, so that this was not known before the run.
        computed: bool,
    },
    /// The vibration stage failed.
    #[error("vibration: {0}")]
    Vibration(#[from] VibrationError),
    /// The study lacks the section of a stage that was asked for.
    #[error("the study has no [{0}] section")]
    NoStage(&'static str),
    /// Stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Kinds of failure that a front end tells apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FailureKind {
    /// A value of the study is out of range.
    Configuration,
    /// The scan is missing, corrupt or unusable.
    Input,
    /// Not converged, too few valid samples, or too many clipped ones.
    NotConverged,
    /// Stopped from outside.
    Cancelled,
    /// Anything else.
    Runtime,
}

impl StudyError {
    /// What kind of failure this is.
    pub fn kind(&self) -> FailureKind {
        match self {
            Self::Scan(error) if matches!(error.cause(), FormatError::NoSuchChannel { .. }) => {
                FailureKind::Configuration
            }
            Self::OneOf { error, .. } => error.kind(),
            Self::Scan(_)
            | Self::Map { .. }
            | Self::Pitch { .. }
            | Self::Pooling(_)
            | Self::Preparation(PreparationError::Level(_) | PreparationError::Outliers(FilterError::Map(_)))
            | Self::Areal(_)
            | Self::FormAlone { .. }
            | Self::Fractal(_)
            | Self::Estimate(_)
            | Self::Fit(_)
            | Self::Empirical(_)
            | Self::Heights(_)
            | Self::NoInterval { .. }
            | Self::FrictionProcess { .. } => FailureKind::Input,
            Self::Cancelled(_)
            | Self::Pressure(PressureError::Cancelled(_))
            | Self::Friction { error: FrictionError::Cancelled(_), .. }
            | Self::Vibration(VibrationError::Cancelled(_)) => FailureKind::Cancelled,
            Self::Pressure(PressureError::TooFewValid { .. })
            | Self::Clipped { computed: true, .. }
            | Self::Friction { .. }
            | Self::Vibration(VibrationError::TooFewValid { .. })
            | Self::Generator(GeneratorError::NotConverged { .. }) => FailureKind::NotConverged,
            Self::Preparation(_)
            | Self::Uncertainty(_)
            | Self::Covariance(_)
            | Self::Law(_)
            | Self::Generator(_)
            | Self::Translation(_)
            | Self::Grid { .. }
            | Self::Contact { .. }
            | Self::Pressure(_)
            | Self::Window(_)
            | Self::Clipped { computed: false, .. }
            | Self::Process(_)
            | Self::Propagation(_)
            | Self::ConstantMode
            | Self::FractalDimension
            | Self::NoStage(_) => FailureKind::Configuration,
            Self::Vibration(VibrationError::Parameter { .. }) => FailureKind::Configuration,
            // The stated law alone is to blame.
            Self::Vibration(VibrationError::FrictionNotPositive { fluctuation, .. }) if *fluctuation >= 0.0 => {
                FailureKind::Configuration
            }
            Self::Vibration(_) => FailureKind::Runtime,
        }
    }
}
