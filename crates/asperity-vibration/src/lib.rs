//! Stick-slip of a mass on a belt under deterministic and random friction (paper §5).
//!
//! All quantities are dimensionless: displacement X = x·c/N, time τ = ω₀t, belt velocity V = v_b·mω₀/N, damping ratio
//! ζ, friction process m(s) over the sliding distance s in the unit N/c. [`Scales`] converts from and to SI.
//!
//! Motion without fluctuation: [`Oscillator`] → [`limit_cycle`] (kind of motion, period, extremes),
//! [`critical_damping`] and [`limit_damping`] (damping ratios at which vibration ends), [`smallest_kick`] (smallest
//! disturbance of steady sliding that starts vibration), [`slip_cycles`], [`forced_cycles`], [`critical_curve`],
//! [`locked_curve`], [`basin`], [`bifurcation_diagram`].
//!
//! Motion under fluctuating friction: [`Trajectory`] (events of one realisation of the friction process), [`Ensemble`]
//! (statistics of many), [`damping_sweep`] (gradual end of vibration over damping), [`stability_map`].
//!
//! # Method
//! Slip is integrated by Taylor series. The variables are chosen so that no
//! difference of nearly equal numbers occurs, and every step is a polynomial. The first zero of the relative velocity
//! follows from a bound on the rotation in the phase plane, or is isolated by bounds of the coefficients, so no
//! re-attachment is missed, however short.
//!
//! A time step contains no sign function: it follows the smooth slip branch to v_rel = 0, where the force determines
//! whether the mass sticks or enters over-slip. In stick the relative velocity is exactly zero. Grid points of the
//! friction process are searched only up to an arrival, because the sliding distance of the slip branch runs backwards
//! after it.

#![cfg_attr(test, expect(clippy::disallowed_methods, reason = "tests read reference files and call other programs"))]

mod arrival;
mod batch;
mod clipping;
mod cloud;
mod critical;
mod cycle;
mod deterministic;
mod ensemble;
mod events;
pub mod law;
mod locked;
mod margin;
pub mod mode_coupling;
mod motion;
#[cfg(test)]
mod oracle;
mod oscillator;
mod polynomial;
mod portrait;
#[cfg(test)]
mod robustness;
mod sample_distribution;
mod scaled_forcing;
mod series;
mod settled;
mod slip_orbit;
mod sound;
mod stability_map;
mod structure;
mod sweep;
#[cfg(test)]
mod tests;
mod trajectory;
mod waveform;
mod weakening;

use thiserror::Error;

pub use asperity_results::MotionKind;
pub use clipping::{TooManyClipped, accept_clipping, clipped_to_positive};
pub use cloud::phase_cloud;
pub use critical::{CriticalDamping, critical_damping, limit_damping};
pub use cycle::{LimitCycle, Regime, limit_cycle};
pub use deterministic::{check_positive, deterministic_slips};
pub use ensemble::{Ensemble, EnsembleSettings, Estimate, FailedTrajectory, Passages};
pub use events::{Drive, Event, EventKind, Phase};
pub use law::{FrictionTable, VelocityLaw};
pub use locked::locked_boundary;
pub use margin::DampingMargins;
pub use oscillator::{Forcing, Oscillator, Parameters, Scales};
pub use portrait::{PhasePoint, SampledTrajectory, cycle_portrait, trajectory_portrait};
pub use sample_distribution::{Count, SampleDistribution};
pub use sound::{Sound, SoundSettings};
#[doc(hidden)]
pub use stability_map::grid_contour;
pub use stability_map::{
    CONSTANT_STD, FluctuatingOscillator, MapAxis, MapCell, MapContour, MapOver, MapPoint, MapResolution, MapSettings,
    StabilityMap, stability_map,
};
pub use structure::{
    Basin, BasinBox, BifurcationDiagram, BifurcationPoint, BifurcationSettings, Branch, BranchEnd, BranchPoint,
    CurveParameter, CurveSettings, ForcedCycle, Mark, MarkKind, Separatrix, SeparatrixKind, SlipCycle, Turnover, basin,
    bifurcation_diagram, critical_curve, forced_cycles, locked_curve, separatrix, slip_cycles, smallest_kick,
};
pub use sweep::{DampingSweep, crossings_without_fluctuation, damping_sweep};
pub use trajectory::{Slips, Trajectory, TrajectorySettings};
pub use waveform::{Waveform, WaveformSettings};

use asperity_base::monitor::Cancelled;
use asperity_process::ProcessError;

/// Error of a vibration computation.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum VibrationError {
    /// A parameter lies outside its range.
    #[error("{parameter} is {}, but must be {wanted}", shown(*value))]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value found.
        value: f64,
        /// Values allowed.
        wanted: &'static str,
    },
    /// The friction coefficient vanished or changed its sign.
    #[error(
        "the friction coefficient fell to {coefficient:.3e} at tau = {tau:.6} (sliding distance {sliding_distance:.6e}): \
         it must stay positive; {}",
        if *fluctuation < 0.0 {
            "lower the standard deviation of the fluctuation, or the weakening of the friction law"
        } else {
            "the linear law falls below zero at the speeds of this motion: lower its slope or the belt velocity"
        }
    )]
    FrictionNotPositive {
        /// Coefficient found.
        coefficient: f64,
        /// Fluctuation there. If it is not negative, the law alone makes the coefficient negative.
        fluctuation: f64,
        /// Time τ.
        tau: f64,
        /// Sliding distance s.
        sliding_distance: f64,
    },
    /// A recorded friction process ended before the trajectory.
    #[error("the friction process ends at {coordinate:.6e}, but the trajectory has only reached tau = {tau:.6}")]
    ProcessTooShort {
        /// Time τ reached.
        tau: f64,
        /// End of the process.
        coordinate: f64,
    },
    /// Events follow each other without time between them.
    #[error("events accumulate at tau = {tau:.12}")]
    Stalled {
        /// Time τ of the events.
        tau: f64,
    },
    /// The search found no solution.
    #[error("no {what} found: {reason}")]
    NotFound {
        /// Object of the search.
        what: &'static str,
        /// Reason.
        reason: &'static str,
    },
    /// The friction process is invalid.
    #[error(transparent)]
    Process(#[from] ProcessError),
    /// The marginal distribution of the fluctuation is invalid.
    #[error(transparent)]
    Distribution(#[from] asperity_base::distribution::DistributionError),
    /// Too few trajectories are valid for statistics.
    #[error(
        "{valid} of {total} trajectories are valid, at least two and the fraction {wanted} must be; first failure: {first}"
    )]
    TooFewValid {
        /// Number of valid trajectories.
        valid: usize,
        /// Number of all trajectories.
        total: usize,
        /// Least valid fraction.
        wanted: f64,
        /// Reason of the first failure.
        first: String,
    },
    /// The caller cancelled the computation.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl VibrationError {
    /// Returns whether a search or a simulation ended without result, and no parameter is invalid.
    pub fn is_not_converged(&self) -> bool {
        matches!(self, Self::NotFound { .. } | Self::Stalled { .. } | Self::TooFewValid { .. })
    }
}

/// Formats a number, very small and very large ones with an exponent.
fn shown(value: f64) -> String {
    if value == 0.0 || (1e-6..1e9).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

fn positive(parameter: &'static str, value: f64) -> Result<(), VibrationError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(VibrationError::Parameter { parameter, value, wanted: "positive and finite" })
    }
}

fn non_negative(parameter: &'static str, value: f64) -> Result<(), VibrationError> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(VibrationError::Parameter { parameter, value, wanted: "finite and not negative" })
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
