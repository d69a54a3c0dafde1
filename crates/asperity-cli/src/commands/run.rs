//! Run of a study, from its file to a run folder.

use std::path::{Path, PathBuf};

use asperity::study::Stage;
use asperity::study::result::{MeasuredSurface, Results};
use asperity_report::{verdict_sentence, vibration_answer};
use clap::Args;
use serde_json::Value;

use super::computation::{Computation, Options};
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::Answer;

/// Runs a study and writes its folder: numbers, tables, fields, figures, an offline report, provenance. An interrupted run goes on from its
/// finished blocks when the same command is given again.
#[derive(Debug, Args)]
pub(crate) struct Run {
    /// Study file.
    study: PathBuf,
    /// Compute only this stage and the stages that it needs.
    #[arg(long, value_parser = args::named::<Stage>(), value_name = "STAGE")]
    only: Option<Stage>,
    #[command(flatten)]
    options: Options,
}

impl Run {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        self.options.run(&Computation::study(&self.study, self.options.seed, self.only)?, monitor)
    }
}

/// Returns the default folder of a run.
pub(super) fn default_destination(study: &Path) -> PathBuf {
    Path::new("runs").join(study.file_stem().unwrap_or_default())
}

/// Returns the main results, and the folder of the others.
pub(super) fn headline(results: &Results, folder: &Path) -> Answer {
    let mut answer = Answer::default();
    let mut show = |key: &str, value: Value| answer = std::mem::take(&mut answer).with(key, value);
    if let Some(verdict) = &results.verdict {
        show("verdict", verdict_sentence(verdict).into());
    }
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
        let main = if vibration.upscaling == "paper" { &vibration.paper } else { &vibration.area };
        show("friction_std", main.friction_std.into());
        // A part of a rough slider has constant friction.
        match point.filter(|_| vibration.friction_correlation_length_m.is_none()) {
            Some(point) if vibration.upscaling == "paper" => show("friction_std_between_parts", point.std.into()),
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
