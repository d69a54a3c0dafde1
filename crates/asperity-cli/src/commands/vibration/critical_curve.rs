//! Damping ratio at which stick-slip ends, along a parameter.

use asperity::study::Table;
use asperity::vibration::{
    Branch, BranchPoint, CurveParameter, CurveSettings, Oscillator, critical_curve, locked_curve,
};
use asperity_report::VibrationFigures;
use clap::Args;

use super::folder::Folder;
use super::machine::Machine;
use crate::args::{self, Named};
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::{Answer, columns, print};

/// Continues the damping ratio at which the limit cycle ends over a parameter; under forcing, the ratio of the cycle
/// that is locked to the force.
#[derive(Debug, Args)]
pub(crate) struct CriticalCurve {
    #[command(flatten)]
    machine: Machine,
    /// Parameter to vary.
    #[arg(long, value_parser = parameter())]
    over: CurveParameter,
    /// Start of the curve.
    #[arg(long, value_name = "X", value_parser = args::number, allow_hyphen_values = true)]
    from: f64,
    /// End of the curve.
    #[arg(long, value_name = "X", value_parser = args::number, allow_hyphen_values = true)]
    to: f64,
    #[command(flatten)]
    folder: Folder,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// Returns the parser of the parameter of a curve or a diagram.
pub(super) fn parameter() -> Named<CurveParameter> {
    args::named().with_alias("forcing", CurveParameter::ForcingAmplitude)
}

/// Fails if the oscillator lacks the parameter, or if the range does not rise or has an impossible end.
pub(super) fn check_over(over: CurveParameter, oscillator: &Oscillator, from: f64, to: f64) -> Result<(), Failure> {
    if over.value(oscillator).is_none() {
        let reason = match over {
            CurveParameter::ForcingAmplitude | CurveParameter::ForcingFrequency => {
                "the machine has no forcing; give --forcing and --forcing-frequency"
            }
            _ => "the velocity law has no weakening rate",
        };
        return Err(Failure::usage(format!("--over {over}: {reason}")));
    }
    if from >= to {
        return Err(Failure::usage(format!("--to is {to}, but must be above --from, {from}")));
    }
    for (flag, value) in [("--from", from), ("--to", to)] {
        over.set(oscillator, value).map_err(|e| Failure::usage(format_args!("{flag}: {e}")))?;
    }
    Ok(())
}

impl CriticalCurve {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(0.0, monitor)?;
        if self.over == CurveParameter::DampingRatio {
            return Err(Failure::usage("--over damping_ratio: the curve itself gives the critical damping ratio"));
        }
        check_over(self.over, &oscillator, self.from, self.to)?;
        let inputs = self.machine.friction.inputs();
        let has_folder = self.folder.is_requested(&inputs)?;
        let settings = CurveSettings::new([self.from, self.to]);
        let curve = if oscillator.forcing().is_some() { locked_curve } else { critical_curve };
        let branch = curve(&oscillator, self.over, &settings, monitor)?;
        if has_folder {
            let tables = vec![("critical_curve", branch_columns(&branch, self.over.name()))];
            let figures = VibrationFigures::CriticalCurve { parameter: self.over.name().to_owned() };
            self.folder.write("critical-curve", &figures, &inputs, &Answer::new(&branch)?, tables, monitor)?;
        }
        if self.json { Answer::new(&branch)?.print(true) } else { table(&branch) }
    }
}

fn branch_columns(branch: &Branch, parameter: &str) -> Table {
    let column = |of: fn(&BranchPoint) -> f64| branch.points.iter().map(of).collect::<Vec<f64>>();
    Table::new([
        (parameter, column(|p| p.parameter)),
        ("critical_damping_ratio", column(|p| p.critical_damping_ratio)),
        ("hopf_damping_ratio", column(|p| p.hopf_damping_ratio)),
        ("detachment_phase", column(|p| p.detachment_phase.unwrap_or(f64::NAN))),
    ])
}

fn table(branch: &Branch) -> Result<(), Failure> {
    let mut rows = vec![["parameter", "critical damping ratio", "Hopf damping ratio"].map(str::to_owned)];
    for point in &branch.points {
        let row = [point.parameter, point.critical_damping_ratio, point.hopf_damping_ratio];
        rows.push(row.map(|value| if value.abs() < 1e-4 { format!("{value:.9e}") } else { format!("{value:.10}") }));
    }
    print(&columns(&rows))
}
