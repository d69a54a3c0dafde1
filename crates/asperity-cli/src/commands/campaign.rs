//! Campaign: one study over many values and scans.

use std::path::{Path, PathBuf};

use asperity::study::CampaignResults;
use clap::Args;

use super::computation::{Computation, Options};
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::Answer;

/// Computes one study over lists, grids and samples of its values and over many scans: one table, one report. An interrupted campaign
/// goes on from its finished members when the same command is given again.
#[derive(Debug, Args)]
pub(crate) struct Campaign {
    /// Campaign file.
    file: PathBuf,
    #[command(flatten)]
    options: Options,
}

impl Campaign {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let computation = Computation::campaign(&self.file, self.options.seed)?;
        computation.extent().into_iter().for_each(|extent| monitor.note(&extent));
        self.options.run(&computation, monitor)
    }
}

/// Returns the number of members, those that vibrate, the range of the main answers, and the folder of the rest.
pub(super) fn headline(results: &CampaignResults, folder: &Path) -> Answer {
    let members = &results.members;
    let failed = members.iter().filter(|member| member.failed).count();
    let mut answer = Answer::default().with("members", members.len()).with("failed", failed);
    let judged: Vec<bool> = members.iter().filter_map(|member| member.answers.vibrates).collect();
    if !judged.is_empty() {
        answer = answer.with("vibrating", judged.iter().filter(|vibrates| **vibrates).count());
    }
    let ranges = [
        ("friction_mean", members.iter().filter_map(|member| member.answers.friction_mean).collect::<Vec<f64>>()),
        ("limit_damping_ratio", members.iter().filter_map(|member| member.answers.limit_damping_ratio).collect()),
        ("probability", members.iter().filter_map(|member| member.answers.probability).collect()),
    ];
    for (key, values) in ranges {
        let least = values.iter().copied().reduce(f64::min);
        let largest = values.into_iter().reduce(f64::max);
        if let (Some(least), Some(largest)) = (least, largest) {
            answer = answer.with(&format!("least_{key}"), least).with(&format!("largest_{key}"), largest);
        }
    }
    answer.with("folder", folder.display().to_string())
}

/// Fails if no member has an answer.
pub(super) fn require_answer(results: &CampaignResults) -> Result<(), Failure> {
    match results.members.first() {
        Some(first) if results.members.iter().all(|member| member.failed) => {
            let reason = first.reason.as_deref().unwrap_or_default();
            Err(Failure::new(Kind::NotConverged, format!("no member has an answer; the first because {reason}")))
        }
        _ => Ok(()),
    }
}
