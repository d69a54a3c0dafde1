//! A mass on a moving belt, in dimensionless form, X = x·c/N and τ = ω₀t, or with units.

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
mod units;
mod velocity_law;
mod wav;

use asperity::study::FailureKind;
use asperity::vibration::VibrationError;
use clap::{Args, Subcommand};

#[cfg(test)]
pub(crate) use units::FLAGS_WITH_UNITS;
pub(crate) use units::dimensionless;

use crate::failure::Failure;
use crate::monitor::Terminal;

/// A mass on a moving belt.
#[derive(Debug, Args)]
pub(crate) struct Vibration {
    #[command(flatten)]
    units: units::Units,
    #[command(subcommand)]
    computation: Computation,
}

/// Commands of the stick-slip oscillator. Help shows the documentation of each command's type.
#[derive(Debug, Subcommand)]
enum Computation {
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
        let writes_wav = matches!(&self.computation, Computation::Sound(sound) if sound.writes_wav());
        self.units.note(writes_wav, monitor)?;
        match &self.computation {
            Computation::Cycle(cycle) => cycle.run(monitor),
            Computation::CriticalDamping(critical) => critical.run(monitor),
            Computation::Trajectory(trajectory) => trajectory.run(monitor),
            Computation::Ensemble(ensemble) => ensemble.run(monitor),
            Computation::Sound(sound) => sound.run(self.units.natural_frequency, monitor),
            Computation::Map(map) => map.run(monitor),
            Computation::CriticalCurve(curve) => curve.run(monitor),
            Computation::Bifurcation(diagram) => diagram.run(monitor),
            Computation::ForcedCycles(cycles) => cycles.run(monitor),
            Computation::Basin(basin) => basin.run(monitor),
            Computation::ModeCoupling(coupling) => coupling.run(monitor),
        }
    }
}

/// A failed search has not converged; any other error is due to the flags.
impl From<VibrationError> for Failure {
    fn from(error: VibrationError) -> Self {
        Self::new(FailureKind::of(&error).into(), error.to_string())
    }
}
