//! The friction coefficient as a stochastic process (paper §4).
//!
//! [`strip::Strips`] solves long strips at several levels of contact. A [`window::Window`] slides along each solution, and a
//! [`law::WindowLaw`] computes μ(s) from the contact in the window. [`load_curve::LoadCurve`] relates load and depth.
//! [`statistics::FrictionStatistics`] estimates the statistics of the process μ(s), and [`window_study::WindowStudy`] separates
//! its correlation from the effect of the window. [`TwoBodyFriction`] separates differences between parts from the
//! fluctuation along the path if both bodies are rough. [`replicates`] provides the jackknife over strips. [`upscaling`]
//! converts the variance of one window to the variance of the nominal area. [`WindowFriction`] is the friction of one window,
//! computed, fitted or stated. [`process`] simulates the process, and
//! [`measured`] fits it to a tribometer record.

use thiserror::Error;

pub mod analysis;
pub mod cutoff;
pub mod law;
mod level_control;
pub mod load_curve;
mod mean_errors;
mod pressed_scan;
pub mod replicates;
mod solved_level;
pub mod statistics;
pub mod strip;
mod two_bodies;
pub mod uncertain;
pub mod upscaling;
pub mod window;
mod window_contact;
mod window_friction;
pub mod window_study;

pub use asperity_process as process;
pub use asperity_process::{diagnostics, measured};
pub use asperity_results::RoughBody;
pub use level_control::{LevelControl, OperatingLevel};
pub use mean_errors::{CutOff, MeanErrors};
pub use pressed_scan::{Extrapolated, PressedScan, WINDOWS};
pub use solved_level::SolvedLevel;
pub use two_bodies::DISTANCES;
pub use two_bodies::split::TwoBodyFriction;
pub use upscaling::Upscaling;
pub use window_contact::{WindowContact, window_contacts};
pub use window_friction::{NominalContact, StatedFriction, WindowFriction};

use asperity_base::monitor::Cancelled;
use asperity_base::stats::StatsError;

/// Reason why friction could not be computed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FrictionError {
    /// Too few strips converged.
    #[error(
        "{valid} of {total} strips converged, but at least two and the fraction {wanted} must; the first failure: {first}"
    )]
    TooFewValid {
        /// Converged strips.
        valid: usize,
        /// All strips.
        total: usize,
        /// Least fraction.
        wanted: f64,
        /// Reason of the first failure.
        first: String,
    },
    /// Too few windows carry load.
    #[error(
        "{with_contact} of {windows} windows carry load; statistics of friction need at least ten: press deeper, or take \
         a longer window or more strips"
    )]
    NoContact {
        /// All windows.
        windows: usize,
        /// Windows with contact.
        with_contact: usize,
    },
    /// A statistic is undefined.
    #[error(transparent)]
    Statistics(#[from] StatsError),
    /// The monitor cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
