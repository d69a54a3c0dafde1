//! Folder of a campaign: its file, the rows of its members, results, provenance and report.

use std::fs;
use std::path::Path;

use asperity_results::Provenance;

use super::Campaign;
use crate::study::result::{CampaignResults, InputValue, MemberResult, VariedKey};
use crate::study::stored_run::{CAMPAIGN, PROVENANCE, RESULTS, read_results};
use crate::study::{Staging, StoreError, TableError, is_finished, json_bytes};
use asperity_runs::require_finished;

/// Finished campaign, read from its folder.
#[derive(Debug, Clone)]
pub struct StoredCampaign {
    /// Text of the resolved campaign file.
    pub text: String,
    /// `results.json`.
    pub results: CampaignResults,
    /// `provenance.json`.
    pub provenance: Provenance,
}

impl StoredCampaign {
    /// Returns whether `dir` is the folder of a finished campaign.
    pub fn is_campaign(dir: &Path) -> bool {
        is_finished(dir) && dir.join(CAMPAIGN).is_file()
    }

    /// Reads the folder of a campaign.
    ///
    /// # Errors
    /// The folder is no finished campaign, or one of its files cannot be read.
    pub fn load(dir: &Path) -> Result<Self, StoreError> {
        require_finished(dir, CAMPAIGN)?;
        let read = |name: &str| {
            let path = dir.join(name);
            fs::read(&path).map_err(|source| StoreError::Io { path, source })
        };
        let corrupt = |name: &str, error: &serde_json::Error| StoreError::Corrupt {
            path: dir.join(name),
            reason: error.to_string(),
        };
        Ok(Self {
            text: String::from_utf8_lossy(&read(CAMPAIGN)?).into_owned(),
            results: read_results(dir, true)?,
            provenance: serde_json::from_slice(&read(PROVENANCE)?).map_err(|error| corrupt(PROVENANCE, &error))?,
        })
    }
}

/// Writes the folder of a campaign; with the feature `report` also the report and its figure. The folder appears at its destination with
/// [`Staging::commit`].
///
/// # Errors
/// The operating system refused.
pub fn write_campaign(
    staging: &Staging,
    campaign: &Campaign,
    results: &CampaignResults,
    provenance: &Provenance,
) -> Result<(), StoreError> {
    staging.write(CAMPAIGN, campaign.resolved().as_bytes())?;
    staging.write(PROVENANCE, &json_bytes(provenance)?)?;
    campaign_files(results, |name, bytes| staging.write(name, bytes))?;
    #[cfg(feature = "report")]
    {
        let run = asperity_report::CampaignRun {
            name: provenance.study.clone(),
            results: results.clone(),
            provenance: Some(provenance.clone()),
        };
        let report = asperity_report::render_campaign(&run);
        for (path, svg) in report.figures.iter().flat_map(asperity_report::Figure::files) {
            staging.write(&path, svg.as_bytes())?;
        }
        staging.write("report.html", report.html.as_bytes())?;
    }
    Ok(())
}

/// Passes the files with the results of a campaign to `write`, by name.
///
/// # Errors
/// The error of `write`.
pub fn campaign_files(
    results: &CampaignResults,
    mut write: impl FnMut(&str, &[u8]) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    write(RESULTS, &json_bytes(results)?)?;
    write("members.csv", &members_csv(results).map_err(StoreError::content)?)
}

/// Returns the rows of the members as CSV. Undefined cells are empty; a key with a unit has it at the end of its name.
pub(super) fn members_csv(results: &CampaignResults) -> Result<Vec<u8>, TableError> {
    let with_unit = |key: &VariedKey| {
        let unit = key.unit.replace('^', "").replace('/', "_per_").to_lowercase();
        if unit.is_empty() { key.key.clone() } else { format!("{}_{unit}", key.key) }
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let first = ["member".to_owned(), "scan".into()].into_iter().chain(results.keys.iter().map(with_unit));
    let answers = [
        "friction_mean",
        "friction_std",
        "limit_damping_ratio",
        "damping_margin",
        "kind",
        "vibrates",
        "probability",
        "probability_low",
        "probability_high",
        "probability_range_low",
        "probability_range_high",
        "remedy",
        "remedy_probability",
        "remedy_value",
        "warnings",
        "failed",
        "reason",
    ];
    writer.write_record(first.chain(answers.map(str::to_owned)))?;
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:?}"));
    for (index, MemberResult { scan, values, failed, reason, answers }) in results.members.iter().enumerate() {
        let values = values.iter().map(|value| match value {
            InputValue::Integer(value) => value.to_string(),
            InputValue::Number(value) => number(Some(*value)),
            InputValue::Name(text) => text.clone(),
        });
        let of_answers = [
            number(answers.friction_mean),
            number(answers.friction_std),
            number(answers.limit_damping_ratio),
            number(answers.damping_margin),
            answers.kind.map_or_else(String::new, |kind| kind.name().into()),
            answers.vibrates.map_or_else(String::new, |vibrates| vibrates.to_string()),
            number(answers.probability),
            number(answers.probability_interval.map(|[low, _]| low)),
            number(answers.probability_interval.map(|[_, high]| high)),
            number(answers.probability_range.map(|[low, _]| low)),
            number(answers.probability_range.map(|[_, high]| high)),
            answers.remedy.as_ref().map_or_else(String::new, |remedy| remedy.input.clone()),
            number(answers.remedy.as_ref().map(|remedy| remedy.probability)),
            number(answers.remedy.as_ref().and_then(|remedy| remedy.value)),
            answers.warnings.map_or_else(String::new, |warnings| warnings.to_string()),
            failed.to_string(),
            reason.clone().unwrap_or_default(),
        ];
        let first = [(index + 1).to_string(), scan.clone().unwrap_or_default()];
        writer.write_record(first.into_iter().chain(values).chain(of_answers))?;
    }
    writer.into_inner().map_err(|error| TableError::Csv(error.into_error().into()))
}
