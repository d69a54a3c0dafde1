//! The end of stick-slip along a parameter.

use asperity::vibration::{Branch, CurveSettings, Parameter, critical_curve, locked_curve};
use clap::{Args, ValueEnum};

use super::{Machine, refused};
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::{Answer, columns, print};

/// Continues the damping ratio at which the limit cycle ends over a parameter; under forcing, that of the cycle locked to
/// the force.
#[derive(Debug, Args)]
pub(crate) struct CriticalCurve {
    #[command(flatten)]
    machine: Machine,
    /// The parameter.
    #[arg(long, value_enum)]
    over: Over,
    /// Where the curve begins.
    #[arg(long, value_name = "X", value_parser = args::number, allow_hyphen_values = true)]
    from: f64,
    /// Where it ends.
    #[arg(long, value_name = "X", value_parser = args::number, allow_hyphen_values = true)]
    to: f64,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// A parameter of the machine.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum Over {
    DampingRatio,
    BeltVelocity,
    StaticFriction,
    /// Weakening rate of the friction law.
    Weakening,
    /// Amplitude of the harmonic force.
    Forcing,
    /// Frequency of the harmonic force.
    ForcingFrequency,
}

impl Over {
    pub(super) fn parameter(self) -> Parameter {
        match self {
            Self::DampingRatio => Parameter::DampingRatio,
            Self::BeltVelocity => Parameter::BeltVelocity,
            Self::StaticFriction => Parameter::StaticFriction,
            Self::Weakening => Parameter::Weakening,
            Self::Forcing => Parameter::ForcingAmplitude,
            Self::ForcingFrequency => Parameter::ForcingFrequency,
        }
    }
}

impl CriticalCurve {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(0.0)?;
        let settings = CurveSettings::new([self.from, self.to]);
        let curve = if oscillator.forcing().is_some() { locked_curve } else { critical_curve };
        let branch = curve(&oscillator, self.over.parameter(), &settings, monitor).map_err(|e| refused(&e))?;
        if self.json { Answer::of(&branch)?.print(true) } else { table(&branch) }
    }
}

fn table(branch: &Branch) -> Result<(), Failure> {
    let mut rows = vec![["parameter", "critical damping ratio", "Hopf damping ratio"].map(str::to_owned)];
    for point in &branch.points {
        let row = [point.parameter, point.critical_damping_ratio, point.hopf_damping_ratio];
        rows.push(row.map(|value| format!("{value:.10}")));
    }
    print(&columns(&rows))
}
