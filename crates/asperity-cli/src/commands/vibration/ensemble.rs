//! Many paths over a random friction fluctuation.

use asperity::friction::process::{FrictionProcess, ProcessModel};
use asperity::law::Marginal;
use asperity::vibration::{self, EnsembleSettings};
use clap::{Args, ValueEnum};

use super::{Damping, Machine, refused};
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::Answer;

/// Follows many paths and counts their cycles: slips that reach a negative velocity.
#[derive(Debug, Args)]
pub(crate) struct Ensemble {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    /// Standard deviation of the friction coefficient.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    friction_std: f64,
    /// Its correlation length in sliding distance, λ = ℓ_μ·c/N.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    correlation_length: f64,
    /// Shape of its law: normal, lognormal:MU,SIGMA, weibull:SHAPE,SCALE, gamma:SHAPE,SCALE or beta:A,B.
    #[arg(long, value_name = "LAW")]
    marginal: Marginal,
    /// Knots of the fluctuation per correlation length.
    #[arg(long, value_name = "N", default_value = "20", value_parser = args::count, allow_hyphen_values = true)]
    steps_per_length: usize,
    /// What the fluctuation is a function of.
    #[arg(long, value_enum, default_value = "distance")]
    drive: Drive,
    /// Number of paths.
    #[arg(long, value_name = "N", value_parser = args::count, allow_hyphen_values = true)]
    trajectories: usize,
    /// Time τ of each.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    duration: f64,
    /// Seed of every random draw.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: u64,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Drive {
    /// The sliding distance: friction is frozen in stick.
    Distance,
    /// The travel of the belt.
    Time,
}

impl Ensemble {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(self.damping.damping_ratio)?;
        let process = FrictionProcess::new(ProcessModel {
            steps_per_length: self.steps_per_length,
            ..ProcessModel::new(self.marginal.clone(), self.friction_std, self.correlation_length)
        })
        .map_err(Failure::usage)?;
        let settings = EnsembleSettings {
            drive: match self.drive {
                Drive::Distance => vibration::Drive::Distance,
                Drive::Time => vibration::Drive::Time,
            },
            ..EnsembleSettings::new(self.trajectories, self.duration, self.seed)
        };
        let ensemble = vibration::Ensemble::simulate(&oscillator, &process, &settings, monitor)
            .or_else(|e| Err(refused(&e).told(answer(None), self.json)?))?;
        if let Some(first) = ensemble.failures.first() {
            let (failed, total) = (ensemble.failures.len(), ensemble.trajectories);
            monitor.warn(&format!("{failed} of {total} paths are left out; the first: {}", first.reason));
        }
        answer(Some(&ensemble)).print(self.json)
    }
}

fn answer(ensemble: Option<&vibration::Ensemble>) -> Answer {
    Answer::default()
        .with("cycles_mean", ensemble.map(|e| e.cycles.mean))
        .with("cycles_se", ensemble.map(|e| e.cycles.se))
        .with("cycles_deterministic", ensemble.map(|e| e.cycles_deterministic))
        .with("difference_mean", ensemble.map(|e| e.difference_mean))
        .with("reattachment_mean", ensemble.map(|e| e.reattachments.mean))
        .with("reattachment_std", ensemble.map(|e| e.reattachments.std))
        .with("reattachment_skewness", ensemble.map(|e| e.reattachments.skewness))
}
