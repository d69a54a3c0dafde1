//! Report of a run.

use asperity_report::{Figure, Input, Report, ReportError, Run, Work, render};
use asperity_results::{Provenance, Results};

use crate::study::{Outcome, StoredRun};

/// Files of a report, by their path in the run folder.
pub type ReportFiles = Vec<(String, Vec<u8>)>;

/// Renders the report of a run that was just computed; `study` is the text of the resolved study.
pub(super) fn new_report(study: &str, outcome: &Outcome, provenance: &Provenance) -> Result<ReportFiles, ReportError> {
    render_files(Run {
        name: provenance.study.clone(),
        results: outcome.results.clone(),
        tables: outcome.tables.clone(),
        fields: outcome.fields.clone(),
        inputs: inputs(study),
        provenance: Some(provenance.clone()),
        machine: outcome.machine.as_ref().and_then(|machine| serde_json::to_string(machine).ok()),
    })
}

impl StoredRun {
    /// Renders the report again. Returns `report.html` and the figures, by their path in the run folder.
    ///
    /// # Errors
    /// A figure or the page could not be drawn.
    pub fn report(&self) -> Result<ReportFiles, ReportError> {
        render_files(Run {
            name: self.provenance.study.clone(),
            results: self.results.clone(),
            tables: self.tables.clone(),
            fields: self.fields.clone(),
            inputs: inputs(&self.study),
            provenance: Some(self.provenance.clone()),
            machine: self.machine.as_ref().and_then(|machine| serde_json::to_string(machine).ok()),
        })
    }
}

/// Returns the works whose methods a run used, whose resolved study is the text `study`.
pub fn works(results: &Results, study: &str) -> Vec<&'static Work> {
    asperity_report::works(results, &inputs(study))
}

fn render_files(run: Run) -> Result<ReportFiles, ReportError> {
    let Report { html, figures } = render(&run)?;
    let figures = figures.iter().flat_map(Figure::files).map(|(path, svg)| (path, svg.as_bytes().to_vec()));
    Ok(figures.chain([("report.html".to_owned(), html.into_bytes())]).collect())
}

/// Returns every key of a study with its value as written in the file, by section.
fn inputs(study: &str) -> Vec<Input> {
    let Ok(document) = study.parse::<toml::Table>() else { return Vec::new() };
    let (sections, plain): (Vec<_>, Vec<_>) = document.iter().partition(|(_, value)| value.is_table());
    let mut inputs = inputs_of("study", "", plain);
    for (section, value) in sections {
        inputs.extend(value.as_table().into_iter().flat_map(|keys| inputs_of(section, "", keys)));
    }
    inputs
}

/// Returns the keys of a table, those of tables inside it as `table.key`.
fn inputs_of<'a>(
    section: &str,
    prefix: &str,
    table: impl IntoIterator<Item = (&'a String, &'a toml::Value)>,
) -> Vec<Input> {
    let of = |(key, value): (&String, &'a toml::Value)| match value {
        toml::Value::Table(inner) => inputs_of(section, &format!("{prefix}{key}."), inner),
        value => {
            vec![Input { section: section.to_owned(), key: format!("{prefix}{key}"), value: format_value(value) }]
        }
    };
    table.into_iter().flat_map(of).collect()
}

fn format_value(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        toml::Value::Array(items) => items.iter().map(format_value).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_keep_their_section_and_unit() {
        let found = inputs(
            "seed = 7\n[pressure]\nsize = [\"200 um\", \"100 um\"]\npercentile = 50.0\n[vibration.map]\ndepth = 2\n",
        );
        let as_text: Vec<String> = found.iter().map(|i| format!("{}.{} = {}", i.section, i.key, i.value)).collect();
        let wanted = [
            "study.seed = 7",
            "pressure.percentile = 50.0",
            "pressure.size = 200 um, 100 um",
            "vibration.map.depth = 2",
        ];
        assert_eq!(as_text, wanted);
    }
}
