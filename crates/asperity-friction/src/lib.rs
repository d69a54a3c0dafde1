//! The friction coefficient as a stochastic process (paper §4).
//!
//! [`strip::Strips`] solves long strips at several levels of contact; a [`window::Window`] slides along each solution and a
//! [`law::FrictionLaw`] turns what it sees into μ(s); [`load_curve::LoadCurve`] is load against depth; [`statistics::FrictionStatistics`] says what kind of
//! process μ(s) is, and [`window_study::WindowStudy`] what of its correlation is not the window's; [`replicates`] says how few strips leave its moments uncertain; [`upscaling`] carries its scatter from one window to the nominal area; [`process`] draws from it, and
//! [`measured`] fits one to a record from a tribometer.

use thiserror::Error;

pub mod analysis;
pub mod law;
pub mod load_curve;
pub mod replicates;
pub mod statistics;
pub mod strip;
mod strip_sums;
pub mod upscaling;
pub mod window;
pub mod window_study;

pub use asperity_process as process;
pub use asperity_process::{diagnostics, measured};
pub use strip_sums::StripSums;

use asperity_base::monitor::Cancelled;
use asperity_base::stats::StatsError;

/// Why friction could not be computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FrictionError {
    /// Too few strips converged.
    #[error("{valid} of {total} strips converged, wanted a share of {wanted}; the first failure: {first}")]
    TooFewValid {
        /// Converged strips.
        valid: usize,
        /// All strips.
        total: usize,
        /// Least share.
        wanted: f64,
        /// Reason of the first failure.
        first: String,
    },
    /// Hardly any window carries load.
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
    /// Stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
