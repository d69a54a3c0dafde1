//! Results of a finished folder, as printed.

use std::path::Path;

use asperity::study::result::{MeasuredSurface, Results};
use asperity::study::{CampaignResults, Computed};
use asperity_report::{campaign_summary, verdict_answer, verdict_summary, vibration_answer};
use serde_json::Value;

use crate::failure::{Failure, Kind};
use crate::output::{Answer, print, print_sentences, with_bold};

/// Results of a finished folder.
pub(super) enum Found<'a> {
    Run(&'a Results),
    Campaign(&'a CampaignResults),
}

impl Found<'_> {
    /// Prints the results as JSON, or the verdict or, without one, the main results, with their folder. A campaign without any answer fails.
    pub(super) fn print(&self, json: bool, folder: &Path) -> Result<(), Failure> {
        if let Self::Run(Results { verdict: Some(verdict), .. }) = self
            && !json
        {
            let report = folder.join("report.html");
            let more = format!("Report: {}; all numbers: {}", report.display(), folder.join("results.json").display());
            let mut sentences = verdict_summary(verdict);
            sentences.iter_mut().take(1).for_each(|first| *first = with_bold(first, &verdict_answer(verdict)));
            sentences.push(more);
            return print_sentences(&sentences);
        }
        let answer = match self {
            Self::Run(results) if json => Answer::new(results)?,
            Self::Run(results) => of_run(results, folder),
            Self::Campaign(results) if json => Answer::new(results)?,
            Self::Campaign(results) => of_campaign(results, folder),
        };
        if let Self::Campaign(results) = self
            && !json
        {
            print_sentences(&campaign_summary(results))?;
            print("\n")?;
        }
        answer.print(json)?;
        match self {
            Self::Campaign(results) => require_answer(results),
            Self::Run(_) => Ok(()),
        }
    }
}

/// Returns the results that were just computed.
pub(super) fn found(computed: &Computed) -> Found<'_> {
    match computed {
        Computed::Run(outcome) => Found::Run(&outcome.results),
        Computed::Campaign(results) => Found::Campaign(results),
    }
}

/// Returns the main results of a run without verdict, and the folder of the others.
fn of_run(results: &Results, folder: &Path) -> Answer {
    let mut answer = Answer::default();
    let mut show = |key: &str, value: Value| answer = std::mem::take(&mut answer).with(key, value);
    if let Some(scan) = results.surface.as_ref().map(|surface| &surface.measured) {
        let number = |name: &str| match scan {
            MeasuredSurface::Scan(scan) => Some(scan.number(name)),
            MeasuredSurface::Part(part) => Some(part.pooled.get(name).map(|pooled| pooled.value)),
            MeasuredSurface::Stated {} => None,
        };
        for name in ["Sq_m", "correlation_length_x_m", "correlation_length_y_m"] {
            if let Some(value) = number(name) {
                show(name, value.into());
            }
        }
    }
    // The lengths of the scan come first, then those of the covariance. A fitted model need not reproduce the scan's
    // length, and its length parameter may differ from its 1/e length.
    if let Some(covariance) = results.surface.as_ref().and_then(|surface| surface.covariance.as_ref()) {
        show("covariance", covariance.model.as_str().into());
        show("covariance_length_x_m", covariance.length_x_m.into());
        show("covariance_length_y_m", covariance.length_y_m.into());
        show("covariance_decay_length_x_m", covariance.decay_length_x_m.into());
        show("covariance_decay_length_y_m", covariance.decay_length_y_m.into());
    }
    let point = results.friction.as_ref().map(|friction| &friction.operating_point);
    let vibration = results.vibration.as_ref();
    // Contact and friction at the operating point, if there is one: the coefficient that drives the vibration.
    if let Some(point) = point {
        show("operating_point", point.level.as_str().into());
        show("mean_pressure_pa", point.mean_pressure_pa.into());
        show("contact_probability", point.contact_fraction.into());
        show("friction_mean", point.mean.into());
        // The mean of short strips has no interval.
        if let Some([low, high]) = point.mean_interval {
            show("friction_mean_interval", vec![low, high].into());
        }
        if let Some(mean) = point.mean_of_scan {
            show("friction_mean_of_scan", mean.into());
        }
        show("friction_resolved", point.resolved.into());
    } else {
        if let Some(pressure) = &results.pressure {
            show("contact_probability", pressure.contact_probability.into());
        }
        if let Some(vibration) = vibration {
            show("friction_mean", vibration.static_friction.into());
        }
    }
    if let Some(vibration) = vibration {
        // The standard deviation of the study's main upscaling.
        show("friction_std", vibration.of_study().friction_std.into());
        // A part of a rough slider has constant friction.
        match point.filter(|_| vibration.friction_correlation_length_m.is_none()) {
            Some(point) if vibration.is_of_one_window() => show("friction_std_between_parts", point.std.into()),
            Some(point) => show("friction_std_between_parts", point.std_nominal_area.into()),
            None => show("friction_correlation_length_m", vibration.friction_correlation_length_m.into()),
        }
        show("critical_damping_ratio", vibration.critical_damping_ratio.into());
        show("limit_damping_ratio", vibration.limit_damping_ratio.into());
        show("kind", vibration.kind.name().into());
        show("period", vibration.cycle.period.into());
        show("vibrates", vibration_answer(vibration).into());
    } else if let Some(point) = point {
        show("friction_std", point.std.into());
    }
    if let Some(coupled) = &results.mode_coupling {
        show("friction", coupled.friction.into());
        show("critical_friction", coupled.critical_friction.into());
        show("limit_damping_ratio", coupled.limit_damping_ratio.into());
        show("kind", coupled.kind.name().into());
        show("frequency_hz", coupled.cycle.map(|cycle| cycle.frequency_hz).into());
    }
    answer.with("folder", folder.display().to_string())
}

/// Returns the number of members, those that vibrate, the range of the main answers, and the folder of the rest.
fn of_campaign(results: &CampaignResults, folder: &Path) -> Answer {
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
fn require_answer(results: &CampaignResults) -> Result<(), Failure> {
    match results.members.first() {
        Some(first) if results.members.iter().all(|member| member.failed) => {
            let reason = first.reason.as_deref().unwrap_or_default();
            Err(Failure::new(Kind::NotConverged, format!("no member has an answer; the first because {reason}")))
        }
        _ => Ok(()),
    }
}
