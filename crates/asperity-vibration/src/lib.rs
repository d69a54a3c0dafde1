//! Stochastic stick-slip of a mass on a belt (paper §5).
//!
//! Everything is dimensionless: displacement X = x·c/N, time τ = ω₀t, belt velocity V = v_b·mω₀/N, damping ratio ζ,
//! friction process m(s) over the sliding distance s in the unit N/c. [`Scales`] converts.
//!
//! [`Oscillator`] → [`limit_cycle`] (kind of motion, period, extremes), [`critical_damping`] and [`limit_damping`] (where
//! vibration ends), [`smallest_kick`] (what starts it from steady sliding), [`Trajectory`] (events of one realisation of the
//! friction process), [`Ensemble`] (statistics of many), [`damping_sweep`] (how noise smears the end of vibration).
//! Deterministic structure: [`slip_cycles`], [`forced_cycles`], [`critical_curve`], [`locked_curve`], [`basin`],
//! [`bifurcation_diagram`].
//!
//! # Method
//! Slip is integrated by Taylor series, or by Runge–Kutta methods ([`Method`]), in variables in which nothing cancels; a step
//! is a polynomial. The first zero of the relative velocity is told from the turning of the phase plane or isolated by
//! coefficient bounds, so no re-attachment, however short, is missed. Sign functions
//! never enter a step: the smooth slip branch is followed to v_rel = 0, where the force decides between stick and
//! over-slip. In stick the relative velocity is exactly zero. A knot of the friction process is looked for only before an
//! arrival, because the sliding distance of the slip branch runs backwards after it.

#![cfg_attr(test, expect(clippy::disallowed_methods, reason = "tests read reference files and call other programs"))]

mod arrival;
mod batch;
mod clipping;
mod critical;
mod cycle;
mod ensemble;
mod events;
mod kind;
mod lanes;
mod law;
mod locked;
pub mod mode_coupling;
mod motion;
#[cfg(test)]
mod oracle;
mod oscillator;
mod polynomial;
mod portrait;
#[cfg(test)]
mod robustness;
mod runge_kutta;
mod sample_law;
mod series;
mod settled;
mod slip_orbit;
mod sound;
mod stability_map;
mod structure;
mod sway;
mod sweep;
mod table;
mod tableau;
mod trajectory;
mod waveform;
mod weakening;

use thiserror::Error;

pub use batch::deterministic_slips;
pub use clipping::{LARGEST_CLIPPED_FRACTION, kept_positive};
pub use critical::{CriticalDamping, critical_damping, limit_damping};
pub use cycle::{LimitCycle, Regime, limit_cycle};
pub use ensemble::{Count, Ensemble, EnsembleSettings, Failure, Passages, Rate, Share};
pub use events::{Drive, Event, EventKind, Phase};
pub use kind::MotionKind;
pub use law::FrictionLaw;
pub use locked::locked_boundary;
pub use oscillator::{Forcing, Oscillator, Parameters, Scales};
pub use portrait::{PhasePoint, cycle_portrait, trajectory_portrait};
pub use runge_kutta::Method;
pub use sample_law::SampleLaw;
pub use sound::{Sound, SoundSettings};
pub use stability_map::{
    Machine, MapAxis, MapCell, MapContour, MapPoint, MapResolution, MapSettings, StabilityMap, stability_map,
};
pub use structure::{
    Basin, BasinBox, BifurcationDiagram, BifurcationPoint, BifurcationSettings, Branch, BranchEnd, BranchPoint,
    CurveSettings, ForcedCycle, Mark, MarkKind, Parameter, Separatrix, SeparatrixKind, SlipCycle, Turnover, basin,
    bifurcation_diagram, critical_curve, forced_cycles, locked_curve, separatrix, slip_cycles, smallest_kick,
};
pub use sweep::{Crossing, DampingSweep, crossings_without_fluctuation, damping_sweep};
pub use table::FrictionTable;
pub use trajectory::{Slips, Trajectory, TrajectorySettings};
pub use waveform::{Waveform, WaveformSettings};

use self::settled::swing_level;
use asperity_base::monitor::Cancelled;
use asperity_process::ProcessError;

/// Why a vibration could not be computed.
#[derive(Debug, Clone, PartialEq, Error)]
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
            "lower the standard deviation of the fluctuation, or the weakening of the law"
        } else {
            "the linear law falls below zero at the speeds of this motion: lower its slope or the belt velocity"
        }
    )]
    FrictionNotPositive {
        /// Coefficient found.
        coefficient: f64,
        /// Fluctuation there; where it is not negative, the law alone is to blame.
        fluctuation: f64,
        /// Time.
        tau: f64,
        /// Sliding distance.
        sliding_distance: f64,
    },
    /// A recorded friction process ended before the trajectory.
    #[error("the friction process ends at {coordinate:.6e}, where the trajectory is only at tau = {tau:.6}")]
    ProcessTooShort {
        /// Time reached.
        tau: f64,
        /// Where the process ends.
        coordinate: f64,
    },
    /// Time stands still: events follow each other without time between them.
    #[error("events accumulate at tau = {tau:.12}")]
    Stalled {
        /// Time of the events.
        tau: f64,
    },
    /// No answer was found.
    #[error("no {what} found: {reason}")]
    NotFound {
        /// What was looked for.
        what: &'static str,
        /// Why it was not found.
        reason: &'static str,
    },
    /// The friction process cannot be made.
    #[error(transparent)]
    Process(#[from] ProcessError),
    /// The law of the fluctuation is none.
    #[error(transparent)]
    Law(#[from] asperity_base::law::LawError),
    /// Too few trajectories are valid for statistics.
    #[error("{valid} of {total} trajectories are valid, wanted a share of {wanted}; the first failure: {first}")]
    TooFewValid {
        /// Valid trajectories.
        valid: usize,
        /// All trajectories.
        total: usize,
        /// Least valid share.
        wanted: f64,
        /// Reason of the first failure.
        first: String,
    },
    /// Stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A number without hundreds of zeros.
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
