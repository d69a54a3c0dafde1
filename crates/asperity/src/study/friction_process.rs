//! Fitted process of the friction stage, written as `friction_process.json`, and read by other studies.

use std::fs;
use std::path::Path;

use crate::friction::process::{CorrelationShape, FittedCorrelation, FittedProcess, Origin, OriginKind, ProcessError};
use crate::study::friction_stage::{SolvedLevel, SolvedStrips};
use crate::study::result::pair;
use crate::study::sentence;
use crate::study::{StudyError, Table};

/// Returns the process of one level at the mean load, or the reason why there is none. Constant friction has neither
/// distribution nor correlation. Varying friction without a correlation gives no process.
pub(super) fn fitted(
    strips: &SolvedStrips,
    level: &SolvedLevel,
    stribeck_s_per_m: Option<f64>,
) -> Result<FittedProcess, String> {
    let process = &level.process;
    let correlation = process.correlation.as_ref().map(|found| FittedCorrelation {
        shape: CorrelationShape::Exponential,
        length_m: found.exponential.length_m,
        length_interval_m: found.length_interval.map(pair),
        window_m: Some(strips.window.length_m()),
        length_without_window_m: level
            .window_study
            .as_ref()
            // Users of the process treat the length as that of an exponential.
            .map(|study| study.model.integral_scale_m(study.length_m)),
    });
    let varies = process.moments.std > 0.0;
    let fitted = FittedProcess {
        mean: level.mean,
        mean_interval: process.estimates.mean.map(|mean| pair(mean.interval)).filter(|_| varies),
        std: process.moments.std,
        std_interval: process.estimates.std.map(|std| pair(std.interval)).filter(|_| varies),
        marginal: process.marginal().filter(|_| varies).map(|fit| fit.law.clone()),
        correlation: match correlation {
            Ok(correlation) => Some(correlation).filter(|_| varies),
            Err(_) if !varies => None,
            Err(error) => return Err(error.to_string()),
        },
        generator: None,
        stribeck_s_per_m,
        averaged_over_m: Some([strips.window.length_m(), strips.window.area_m2() / strips.window.length_m()]),
        mean_pressure_pa: Some(level.level.mean_pressure_pa),
        origin: Origin {
            kind: OriginKind::Study,
            description: format!(
                "windows of {} at {} and the mean load",
                sentence::size(strips.window.length_m(), strips.window.width_m()),
                level.control.name()
            ),
        },
    };
    fitted.check().map_err(|error| error.to_string())?;
    Ok(fitted)
}

/// Simulates a record of a process: `position_m`, `mu` and `fluctuation`, the deviation of μ from its mean.
///
/// # Errors
/// See [`FittedProcess::simulate`].
pub fn simulated_record(process: &FittedProcess, length_m: f64, step_m: f64, seed: u64) -> Result<Table, ProcessError> {
    let mu = process.simulate(length_m, step_m, seed, 0)?;
    Ok(Table::new([
        ("position_m", (0..mu.len()).map(|index| index as f64 * step_m).collect()),
        ("fluctuation", mu.iter().map(|mu| mu - process.mean).collect()),
        ("mu", mu),
    ]))
}

/// Reads the process that a study names; `path` is its location, `name` its name in the study.
///
/// # Errors
/// The file cannot be read, or contains no process.
pub(super) fn read(path: &Path, name: &Path) -> Result<FittedProcess, StudyError> {
    let failed = |reason: String| StudyError::FrictionProcess { file: name.display().to_string(), reason };
    let text = fs::read_to_string(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => failed("no such file".into()),
        std::io::ErrorKind::InvalidData => failed("not a text file".into()),
        _ => failed(error.to_string()),
    })?;
    FittedProcess::from_json(&text).map_err(|error| failed(error.to_string()))
}
