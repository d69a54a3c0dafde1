//! Many trajectories over a random friction fluctuation.

use asperity::study::{cloud_table, points_table, survival_table};
use asperity::vibration::Drive;
use asperity::vibration::{self, EnsembleSettings};
use asperity_report::VibrationFigures;
use clap::Args;
use serde_json::{Value, json};

use super::folder::Folder;
use super::machine::{Damping, Machine};
use super::random::{Source, Trajectories, note_time};
use super::series;
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::Answer;

/// Trajectories of the phase cloud.
const CLOUD: usize = 200;

/// Simulates many trajectories. Counts their cycles (slips that reach a negative velocity) and the time in vibration of
/// any kind.
#[derive(Debug, Args)]
pub(crate) struct Ensemble {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    #[command(flatten)]
    source: Source,
    /// Argument of the fluctuation.
    #[arg(long, value_parser = args::named::<Drive>(), default_value = "distance")]
    drive: Drive,
    #[command(flatten)]
    trajectories: Trajectories,
    #[command(flatten)]
    folder: Folder,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Ensemble {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(self.damping.damping_ratio, monitor)?;
        let process = self.source.process(&oscillator, monitor)?;
        let settings = EnsembleSettings { drive: self.drive, ..self.trajectories.settings() };
        let inputs: Vec<_> = self.machine.friction.inputs().into_iter().chain(self.source.inputs()).collect();
        let has_folder = self.folder.is_requested(&inputs)?;
        note_time(&process, oscillator.belt_velocity() * settings.duration, settings.trajectories, monitor);
        let answer =
            |kind, ensemble| answer(kind, ensemble).with("clipped_fraction", process.model().clipped_fraction());
        let ensemble = vibration::Ensemble::simulate(&oscillator, &process, &settings, monitor)
            .or_else(|e| Err(Failure::from(e).print(answer(None, None), self.json)?))?;
        if let Some(first) = ensemble.failures.first() {
            let (failed, total) = (ensemble.failures.len(), ensemble.trajectories);
            monitor.warn(&format!("{failed} of {total} trajectories failed, the first: {}", first.reason));
        }
        let kind = monitor.killable(|| vibration::limit_cycle(&oscillator).map(|regime| regime.kind()))??;
        let answer = answer(Some(kind), Some(&ensemble));
        if has_folder {
            let cloud = cloud_table(&oscillator, &process, &settings, CLOUD, monitor)?;
            let mut tables =
                vec![("phase_cloud", cloud), ("survival", survival_table(&ensemble.passages, settings.duration))];
            tables.extend(series::cycle(&oscillator)?);
            for (name, points) in [("reattachment", &ensemble.reattachments), ("release", &ensemble.releases)] {
                tables.extend(points_table(points).map(|table| (name, table)));
            }
            self.folder.write("ensemble", &VibrationFigures::Ensemble, &inputs, &answer, tables, monitor)?;
        }
        answer.print(self.json)
    }
}

fn answer(kind: Option<vibration::MotionKind>, ensemble: Option<&vibration::Ensemble>) -> Answer {
    let rate = |of: fn(&vibration::Passages) -> Option<vibration::Estimate>| ensemble.and_then(|e| of(&e.passages));
    let fraction = |of: fn(&vibration::Passages) -> vibration::Estimate| ensemble.map(|e| of(&e.passages));
    let (exit, entry) = (rate(|p| p.exit_rate), rate(|p| p.entry_rate));
    let (left, sustained) = (fraction(|p| p.left), fraction(|p| p.sustained));
    let pair = |interval: Option<[f64; 2]>| interval.map_or(Value::Null, |[low, high]| json!([low, high]));
    Answer::default()
        .with("kind", kind.map(vibration::MotionKind::name))
        .with("cycles_mean", ensemble.map(|e| e.cycles.mean))
        .with("cycles_se", ensemble.map(|e| e.cycles.se))
        .with("cycles_deterministic", ensemble.map(|e| e.cycles_deterministic))
        .with("difference_mean", ensemble.map(|e| e.difference_mean))
        .with("difference_mean_interval", pair(ensemble.map(|e| e.difference_interval)))
        .with("micro_slips_mean", ensemble.map(|e| e.micro_slips.mean))
        .with("reattachment_mean", ensemble.map(|e| e.reattachments.mean))
        .with("reattachment_std", ensemble.map(|e| e.reattachments.std))
        .with("reattachment_skewness", ensemble.map(|e| e.reattachments.skewness))
        .with("reattachment_normality_p", ensemble.and_then(|e| e.reattachments.normality_p))
        .with("release_mean", ensemble.map(|e| e.releases.mean))
        .with("release_std", ensemble.map(|e| e.releases.std))
        .with("release_skewness", ensemble.map(|e| e.releases.skewness))
        .with("release_normality_p", ensemble.and_then(|e| e.releases.normality_p))
        .with("period_mean", ensemble.map(|e| e.periods.mean))
        .with("period_std", ensemble.map(|e| e.periods.std))
        .with("stick_share_mean", ensemble.map(|e| e.stick_share.mean))
        .with("stick_share_se", ensemble.map(|e| e.stick_share.se))
        .with("share_in_cycle", ensemble.map(|e| e.passages.share_in_cycle))
        .with("kind_shares", ensemble.map(|e| json!(e.passages.kinds)))
        .with("vibration_share", ensemble.map(|e| e.passages.late_share.mean))
        .with("vibration_share_se", ensemble.map(|e| e.passages.late_share.se))
        .with("exit_rate", exit.map(|r| r.value))
        .with("exit_rate_interval", pair(exit.map(|r| r.interval)))
        .with("entry_rate", entry.map(|r| r.value))
        .with("entry_rate_interval", pair(entry.map(|r| r.interval)))
        .with("left_share", left.map(|s| s.value))
        .with("left_share_interval", pair(left.map(|s| s.interval)))
        .with("sustained_share", sustained.map(|s| s.value))
        .with("sustained_share_interval", pair(sustained.map(|s| s.interval)))
}
