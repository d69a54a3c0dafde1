//! A mass on a moving belt, in dimensionless form: X = x·c/N, τ = ω₀t.

mod basin;
mod bifurcation;
mod critical_curve;
mod critical_damping;
mod cycle;
mod ensemble;
mod folder;
mod forced_cycles;
mod machine;
mod map;
mod mode_coupling;
mod random;
mod series;
mod sound;
mod trajectory;
mod velocity_law;
mod wav;

use asperity::study::FailureKind;
use asperity::vibration::VibrationError;
use clap::Subcommand;

use crate::failure::Failure;
use crate::monitor::Terminal;

/// Commands of the stick-slip oscillator. Help shows the documentation of each command's type.
#[derive(Debug, Subcommand)]
pub(crate) enum Vibration {
    Cycle(cycle::Cycle),
    CriticalDamping(critical_damping::CriticalDamping),
    Trajectory(trajectory::Trajectory),
    Ensemble(ensemble::Ensemble),
    Sound(sound::Sound),
    Map(Box<map::Map>),
    CriticalCurve(critical_curve::CriticalCurve),
    Bifurcation(bifurcation::Bifurcation),
    ForcedCycles(forced_cycles::ForcedCycles),
    Basin(basin::Basin),
    ModeCoupling(Box<mode_coupling::ModeCoupling>),
}

impl Vibration {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        match self {
            Self::Cycle(cycle) => cycle.run(monitor),
            Self::CriticalDamping(critical) => critical.run(monitor),
            Self::Trajectory(trajectory) => trajectory.run(monitor),
            Self::Ensemble(ensemble) => ensemble.run(monitor),
            Self::Sound(sound) => sound.run(monitor),
            Self::Map(map) => map.run(monitor),
            Self::CriticalCurve(curve) => curve.run(monitor),
            Self::Bifurcation(diagram) => diagram.run(monitor),
            Self::ForcedCycles(cycles) => cycles.run(monitor),
            Self::Basin(basin) => basin.run(monitor),
            Self::ModeCoupling(coupling) => coupling.run(monitor),
        }
    }
}

/// A failed search has not converged; any other error is due to the flags.
impl From<VibrationError> for Failure {
    fn from(error: VibrationError) -> Self {
        Self::new(FailureKind::of(&error).into(), error.to_string())
    }
}
