//! A mass on a moving belt, in dimensionless form: X = x·c/N, τ = ω₀t.

mod critical_damping;
mod cycle;
mod ensemble;
mod trajectory;

use asperity::vibration::{Forcing, FrictionLaw, Oscillator, Parameters, VibrationError};
use clap::{Args, Subcommand};

use crate::args;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;

/// Commands of the stick-slip oscillator; help shows what stands at each of them.
#[derive(Debug, Subcommand)]
pub(crate) enum Vibration {
    Cycle(cycle::Cycle),
    CriticalDamping(critical_damping::CriticalDamping),
    Trajectory(trajectory::Trajectory),
    Ensemble(ensemble::Ensemble),
}

impl Vibration {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        match self {
            Self::Cycle(cycle) => cycle.run(monitor),
            Self::CriticalDamping(critical) => critical.run(monitor),
            Self::Trajectory(trajectory) => trajectory.run(monitor),
            Self::Ensemble(ensemble) => ensemble.run(monitor),
        }
    }
}

/// Friction law, belt and forcing.
#[derive(Debug, Args)]
struct Machine {
    /// Static friction coefficient, the stick limit.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    static_friction: f64,
    /// Kinetic friction coefficient at vanishing velocity; the static one when left out.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    kinetic_friction: Option<f64>,
    /// Weakening a of the kinetic law μ_k/(1 + a|v|), per unit of dimensionless velocity.
    #[arg(long, value_name = "X", value_parser = args::non_negative, allow_hyphen_values = true)]
    stribeck: f64,
    /// Dimensionless belt velocity V = v_b·mω₀/N.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    belt_velocity: f64,
    /// Amplitude q = Q/N of a harmonic force.
    #[arg(long, value_name = "X", value_parser = args::non_negative, allow_hyphen_values = true,
          requires = "forcing_frequency")]
    forcing: Option<f64>,
    /// Frequency η = Ω/ω₀ of the harmonic force.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, requires = "forcing")]
    forcing_frequency: Option<f64>,
}

impl Machine {
    fn oscillator(&self, damping_ratio: f64) -> Result<Oscillator, Failure> {
        Oscillator::new(Parameters {
            static_friction: self.static_friction,
            law: FrictionLaw::Stribeck {
                kinetic: self.kinetic_friction.unwrap_or(self.static_friction),
                decay: self.stribeck,
            },
            damping_ratio,
            belt_velocity: self.belt_velocity,
            forcing: self
                .forcing
                .zip(self.forcing_frequency)
                .map(|(amplitude, frequency)| Forcing { amplitude, frequency }),
        })
        .map_err(Failure::usage)
    }
}

/// The damper.
#[derive(Debug, Args)]
struct Damping {
    /// Damping ratio ζ.
    #[arg(long, value_name = "X", value_parser = args::non_negative, allow_hyphen_values = true)]
    damping_ratio: f64,
}

/// A search that failed has not converged; everything else lies in the flags.
fn refused(error: &VibrationError) -> Failure {
    match error {
        VibrationError::NotFound { .. } | VibrationError::Stalled { .. } | VibrationError::TooFewValid { .. } => {
            Failure::new(Kind::NotConverged, error.to_string())
        }
        VibrationError::Cancelled(cancelled) => Failure::from(*cancelled),
        _ => Failure::usage(error),
    }
}
