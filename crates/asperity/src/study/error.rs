//! Why a study ended early.

use std::error::Error;

use asperity_formats::FormatError;
use thiserror::Error;

use crate::chaos::{DriverError, PropagationError, RegressionError, SamplingError};
use crate::contact::ContactError;
use crate::distribution::DistributionError;
use crate::friction::FrictionError;
use crate::friction::measured::MeasuredError;
use crate::friction::process::ProcessError;
use crate::map::MapError;
use crate::monitor::Cancelled;
use crate::pressure::PressureError;
use crate::stats::StatsError;
use crate::study::parse::line_of_key;
use crate::study::{InvalidValue, StoreError};
use crate::surface::GeneratorError;
use crate::surface::filter::FilterError;
use crate::surface::model::SurfaceModelError;
use crate::surface::preparation::PreparationError;
use crate::vibration::{TooManyClipped, VibrationError};

/// Why a study ended early.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The scan cannot be read.
    #[error(transparent)]
    Scan(#[from] FormatError),
    /// The scan makes no height map.
    #[error("{file}: {error}")]
    Map {
        /// The scan file.
        file: String,
        /// Reason, with the remedy if there is one.
        error: MapError,
    },
    /// A file that the study reads changed during the computation.
    #[error("{0}: the file changed or disappeared during the computation; nothing that depends on it is stored")]
    Changed(String),
    /// One of several scans cannot be used.
    #[error("{file}: {error}")]
    OneOf {
        /// The scan file.
        file: String,
        /// Reason, with the remedy if there is one.
        error: Box<StudyError>,
    },
    /// The counterface cannot be measured or modelled.
    #[error("counterface: {0}")]
    Counterface(Box<StudyError>),
    /// The random surface cannot be modelled or made.
    #[error(transparent)]
    Surface(#[from] SurfaceModelError),
    /// The scan is too small for its correlation length.
    #[error(
        "the correlation of the heights does not fall to 1/e within half of the scan; in [surface], remove more form by \
         `level = \"quadratic\"` or `level = \"polynomial:4\"`, or long waves by an `l_filter`, or take a larger scan"
    )]
    NoCorrelationLength,
    /// The scan has too few points for a study.
    #[error("the scan has {} × {} points; a study needs at least {least} × {least}", found[0], found[1])]
    FewPoints {
        /// Points (x, y) of the scan.
        found: [usize; 2],
        /// Least number of points along either axis.
        least: usize,
    },
    /// A stated distribution is invalid.
    #[error("{0}")]
    Distribution(#[from] DistributionError),
    /// A grid of the study is not one.
    #[error("[{section}] {error}")]
    Grid {
        /// Section of the study.
        section: &'static str,
        /// Reason, with the remedy if there is one.
        error: MapError,
    },
    /// A contact problem cannot be posed.
    #[error("[{section}] {error}")]
    Contact {
        /// Section of the study.
        section: &'static str,
        /// Reason, with the remedy if there is one.
        error: ContactError,
    },
    /// The pressure stage failed.
    #[error("pressure: {0}")]
    Pressure(#[from] PressureError),
    /// A level of the friction stage failed.
    #[error("friction at {level}: {error}")]
    Friction {
        /// The level.
        level: String,
        /// Reason, with the remedy if there is one.
        error: FrictionError,
    },
    /// A parameter of the surface is as uncertain as measured, and no interval was.
    #[error(
        "[friction.uncertainty] {key}: the scan contains too few correlation lengths, or too few points to a length, for \
         an interval of {statistic}; state a standard deviation instead of \"measured\""
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
    /// The friction process cannot be made.
    #[error("friction process: {0}")]
    Process(#[from] ProcessError),
    /// The file of a fitted process cannot be used.
    #[error("[vibration] friction_process: {file}: {reason}")]
    FrictionProcess {
        /// The file.
        file: String,
        /// Reason, with the remedy if there is one.
        reason: String,
    },
    /// Too many friction values would be clipped to stay positive.
    #[error(
        "vibration: with the {upscaling} upscaling, {error}; lower the standard deviation of friction or its weakening with velocity, \
         or set `allow_clipping = true` in [vibration]"
    )]
    Clipped {
        /// The upscaling, `paper` or `area`.
        upscaling: &'static str,
        /// Reason.
        error: TooManyClipped,
        /// Whether the friction stage computed the friction, so that this was not known before the run.
        computed: bool,
    },
    /// The vibration stage failed.
    #[error("vibration: {0}")]
    Vibration(#[from] VibrationError),
    /// Too few machines of the verdict have an answer.
    #[error("verdict: {0}")]
    Verdict(String),
    /// A verdict of a machine under a harmonic force.
    #[error("[vibration] forcing: a machine under a harmonic force has no limit damping, and so no verdict")]
    ForcedVerdict,
    /// The samples of the verdict cannot be drawn.
    #[error("verdict: {0}")]
    Samples(#[from] SamplingError),
    /// The margin of the verdict cannot be expanded.
    #[error("verdict: {0}")]
    Margin(#[from] RegressionError),
    /// The drivers of the verdict cannot be computed.
    #[error("verdict: {0}")]
    Drivers(#[from] DriverError),
    /// A value of the study is invalid.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The study lacks the section of a stage that was asked for.
    #[error("the study has no [{0}] section")]
    NoStage(&'static str),
    /// The blocks of the run cannot be stored.
    #[error(transparent)]
    Blocks(#[from] StoreError),
    /// Blocks of other parts of the run are missing.
    #[error("blocks of other parts are missing")]
    Incomplete,
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

impl FailureKind {
    /// Returns the kind of an error of any stage: an argument is wrong unless the error says otherwise.
    pub fn of(error: &(dyn Error + 'static)) -> Self {
        let vibration = error.downcast_ref::<VibrationError>();
        let pressure = error.downcast_ref::<PressureError>();
        if let Some(error) = error.downcast_ref::<StudyError>() {
            error.kind()
        } else if error.is::<Cancelled>()
            || matches!(vibration, Some(VibrationError::Cancelled(_)))
            || matches!(pressure, Some(PressureError::Cancelled(_)))
            || matches!(error.downcast_ref(), Some(FrictionError::Cancelled(_)))
        {
            Self::Cancelled
        } else if vibration.is_some_and(VibrationError::is_not_converged)
            || matches!(pressure, Some(PressureError::TooFewValid { .. }))
            || error.downcast_ref::<MeasuredError>().is_some_and(MeasuredError::is_too_few)
        {
            Self::NotConverged
        } else {
            Self::Configuration
        }
    }
}

impl StudyError {
    /// Returns the error of the surface stage as one of the counterface.
    pub(super) fn of_counterface(self) -> Self {
        Self::Counterface(Box::new(self))
    }

    /// Returns the error as a sentence that begins with the file. With its text, the line of the value that caused the error follows.
    pub fn message_in(&self, file: &str, text: Option<&str>) -> String {
        match (self, text.and_then(|text| self.line_in(text))) {
            // The error of a scan already names its file.
            (Self::Scan(_) | Self::Map { .. }, Some(line)) => format!("{file}:{line}: [surface] file: {self}"),
            (Self::Scan(_) | Self::Map { .. }, None) => self.to_string(),
            (_, Some(line)) => format!("{file}:{line}: {self}"),
            (_, None) => format!("{file}: {self}"),
        }
    }

    /// Returns the line of the value in `text`, the study file, that caused the error; `None` if no single value did.
    fn line_in(&self, text: &str) -> Option<usize> {
        self.key().map(|(section, key)| line_of_key(text, section, key))
    }

    /// Returns the section and the key of the value that caused the error.
    fn key(&self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Invalid(value) => Some((value.section, value.key)),
            Self::OneOf { error, .. } => error.key(),
            Self::Scan(_) | Self::Map { .. } => Some(("surface", "file")),
            Self::Counterface(error) => error.key().map(|(_, key)| ("counterface", key)),
            Self::NoInterval { key, .. } => Some(("friction.uncertainty", key)),
            Self::FrictionProcess { .. } => Some(("vibration", "friction_process")),
            Self::Surface(error) => key_of_surface(error),
            _ => None,
        }
    }

    /// Kind of the failure.
    pub fn kind(&self) -> FailureKind {
        match self {
            Self::Scan(error) if error.asks_for_option() => FailureKind::Configuration,
            Self::OneOf { error, .. } | Self::Counterface(error) => error.kind(),
            Self::Surface(error) => kind_of_surface(error),
            Self::Scan(_)
            | Self::Map { .. }
            | Self::Heights(_)
            | Self::NoInterval { .. }
            | Self::NoCorrelationLength
            | Self::FewPoints { .. }
            | Self::Changed(_)
            | Self::Blocks(StoreError::Input { .. })
            | Self::FrictionProcess { .. } => FailureKind::Input,
            Self::Cancelled(_)
            | Self::Pressure(PressureError::Cancelled(_))
            | Self::Friction { error: FrictionError::Cancelled(_), .. }
            | Self::Vibration(VibrationError::Cancelled(_)) => FailureKind::Cancelled,
            Self::Pressure(PressureError::TooFewValid { .. } | PressureError::Method(_))
            | Self::Clipped { computed: true, .. }
            | Self::Friction { .. }
            | Self::Verdict(_) => FailureKind::NotConverged,
            Self::Vibration(error) if error.is_not_converged() => FailureKind::NotConverged,
            Self::Distribution(_)
            | Self::Grid { .. }
            | Self::Contact { .. }
            | Self::Pressure(_)
            | Self::Clipped { computed: false, .. }
            | Self::Process(_)
            | Self::Propagation(_)
            | Self::NoStage(_)
            | Self::ForcedVerdict
            | Self::Samples(_)
            | Self::Margin(_)
            | Self::Drivers(_)
            | Self::Invalid(_) => FailureKind::Configuration,
            Self::Vibration(VibrationError::Parameter { .. }) => FailureKind::Configuration,
            // The stated law alone is to blame.
            Self::Vibration(VibrationError::FrictionNotPositive { fluctuation, .. }) if *fluctuation >= 0.0 => {
                FailureKind::Configuration
            }
            Self::Vibration(_) | Self::Blocks(_) | Self::Incomplete => FailureKind::Runtime,
        }
    }
}

/// Returns the section and the key of the value for which a random surface cannot be modelled or made.
fn key_of_surface(error: &SurfaceModelError) -> Option<(&'static str, &'static str)> {
    use SurfaceModelError as E;

    match error {
        E::Preparation(PreparationError::SFilter(_)) => Some(("surface", "s_filter")),
        E::Preparation(PreparationError::LFilter(_)) => Some(("surface", "l_filter")),
        E::FractalDimension => Some(("surface", "fractal_dimension")),
        E::Covariance(_) => Some(("surface", "covariance")),
        E::Counterface(error) => key_of_surface(error).map(|(_, key)| ("counterface", key)),
        _ => None,
    }
}

/// Returns the kind of a failure to model or make a random surface.
fn kind_of_surface(error: &SurfaceModelError) -> FailureKind {
    use SurfaceModelError as E;

    match error {
        E::Pitch { .. }
        | E::Pooling(_)
        | E::Preparation(PreparationError::Level(_) | PreparationError::Outliers(FilterError::Map(_)))
        | E::Areal(_)
        | E::FormAlone { .. }
        | E::Fractal(_)
        | E::Estimate(_)
        | E::Fit(_)
        | E::Empirical(_) => FailureKind::Input,
        E::Generator(GeneratorError::NotConverged { .. }) => FailureKind::NotConverged,
        E::Counterface(error) => kind_of_surface(error),
        // A value of the study is invalid.
        _ => FailureKind::Configuration,
    }
}
