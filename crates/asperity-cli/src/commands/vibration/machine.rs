//! Flags of the machine.

pub(super) use asperity::keys::DAMPING_RATIO as DAMPING;
use asperity::study::{implausible_damping, implausible_friction};
use asperity::vibration::{Forcing, MotionKind, Oscillator, Parameters};
use clap::Args;

use super::velocity_law::Friction;
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;

/// Friction law, belt and forcing.
#[derive(Debug, Args)]
pub(super) struct Machine {
    #[command(flatten)]
    pub(super) friction: Friction,
    #[command(flatten)]
    belt: Belt,
    /// Amplitude q = Q/N of a harmonic force.
    #[arg(long, value_name = "X", value_parser = args::non_negative, allow_hyphen_values = true,
          requires = "forcing_frequency")]
    pub(super) forcing: Option<f64>,
    /// Frequency η = Ω/ω₀ of the harmonic force.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, requires = "forcing")]
    forcing_frequency: Option<f64>,
}

/// Velocity of the belt.
#[derive(Debug, Args)]
pub(super) struct Belt {
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = args::of_input(VELOCITY), help = args::help(VELOCITY, " V = v_b·mω₀/N"))]
    pub(super) belt_velocity: f64,
}

const VELOCITY: &str = "vibration.dimensionless_belt_velocity";

impl Machine {
    /// Returns the oscillator; warns about implausible values.
    pub(super) fn oscillator(&self, damping_ratio: f64, monitor: &Terminal) -> Result<Oscillator, Failure> {
        let parameters = Parameters {
            static_friction: self.friction.static_friction,
            law: self.friction.law()?,
            damping_ratio,
            belt_velocity: self.belt.belt_velocity,
            forcing: self
                .forcing
                .zip(self.forcing_frequency)
                .map(|(amplitude, frequency)| Forcing { amplitude, frequency }),
        };
        let oscillator = Oscillator::new(parameters).map_err(Failure::usage)?;
        let warnings = [implausible_friction(self.friction.static_friction), implausible_damping(damping_ratio)];
        warnings.iter().flatten().for_each(|warning| monitor.warn(warning));
        Ok(oscillator)
    }
}

/// Damping of the oscillator.
#[derive(Debug, Args)]
pub(super) struct Damping {
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = args::of_input(DAMPING), help = args::help(DAMPING, " ζ"))]
    pub(super) damping_ratio: f64,
}

/// Returns the number that denotes a kind of motion in tables.
pub(super) fn code(kind: MotionKind) -> f64 {
    match kind {
        MotionKind::None | MotionKind::Flutter | MotionKind::Divergence => 0.0,
        MotionKind::SlipCycle => 1.0,
        MotionKind::StickSlip => 2.0,
        MotionKind::Overtaking => 3.0,
    }
}
