//! From a run to its report: the library's results in the shape that the report reads.

use std::io;
use std::path::Path;

use asperity::study::{Staging, StoreError, StoredRun};
use asperity_report::{Field, Input, Report, Run, Table, render};

use crate::failure::{Failure, Kind, chain};
use crate::output::unwritten;

/// Renders the report of a run.
pub(crate) fn rendered(run: &StoredRun) -> Result<Report, Failure> {
    let assumptions = run.results["assumptions"].as_array().map_or_else(Vec::new, |sentences| {
        sentences.iter().filter_map(|sentence| sentence.as_str().map(str::to_owned)).collect()
    });
    let tables = run.tables.iter().map(|(name, table)| (name.clone(), Table { columns: table.columns().to_vec() }));
    let fields = run.fields.iter().map(|(name, field)| {
        let (ny, nx) = field.values.dim();
        let values = field.values.iter().copied().collect();
        (name.clone(), Field { nx, ny, dx_m: field.dx_m, dy_m: field.dy_m, values })
    });
    render(&Run {
        name: run.provenance["study"].as_str().unwrap_or("study").to_owned(),
        results: run.results.clone(),
        tables: tables.collect(),
        fields: fields.collect(),
        inputs: inputs(&run.study),
        assumptions,
        provenance: run.provenance.clone(),
    })
    .map_err(|e| Failure::new(Kind::Runtime, format!("the report could not be rendered: {}", chain(&e))))
}

/// Every key of a study with its value as it stands in the file, by section.
fn inputs(study: &str) -> Vec<Input> {
    let Ok(document) = study.parse::<toml::Table>() else { return Vec::new() };
    let input = |section: &str, key: &str, value: &toml::Value| Input {
        section: section.to_owned(),
        key: key.to_owned(),
        value: in_words(value),
    };
    let (sections, plain): (Vec<_>, Vec<_>) = document.iter().partition(|(_, value)| value.is_table());
    let top = plain.into_iter().map(|(key, value)| input("study", key, value));
    let below = sections.into_iter().flat_map(|(section, value)| {
        value.as_table().into_iter().flatten().map(move |(key, value)| input(section, key, value))
    });
    top.chain(below).collect()
}

fn in_words(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        toml::Value::Array(items) => items.iter().map(in_words).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}

/// A finished run of which a file is missing or cannot be read is unusable data.
pub(crate) fn load_failure(error: &StoreError) -> Failure {
    match error {
        StoreError::Io { path, source } => Failure::io(Kind::Data, path.display(), source),
        error => store_failure(error),
    }
}

/// A run folder that cannot be read is unusable data; one that cannot be written is a runtime error.
pub(crate) fn store_failure(error: &StoreError) -> Failure {
    match error {
        StoreError::NotEmpty { .. }
        | StoreError::NoFolder { .. }
        | StoreError::Unnamed { .. }
        | StoreError::HoldsInput { .. }
        | StoreError::NoManifest { .. }
        | StoreError::Foreign { .. } => Failure::usage(error),
        StoreError::NotARun { .. } | StoreError::Corrupt { .. } => Failure::new(Kind::Data, error.to_string()),
        StoreError::Io { path, source } => unwritten(path, source),
        StoreError::Taken { .. } => Failure::new(Kind::Runtime, error.to_string()),
        StoreError::Table(_) | StoreError::Process(_) | StoreError::Json(_) => {
            Failure::new(Kind::Runtime, chain(error))
        }
    }
}

/// Begins the folder of a command; `argument` names the flag that chose it.
pub(crate) fn begin_folder(argument: &str, folder: &Path, force: bool, inputs: &[&Path]) -> Result<Staging, Failure> {
    Staging::open(folder, force, inputs).map_err(|error| {
        let is_misnamed = matches!(&error, StoreError::Io { source, .. }
            if matches!(source.kind(), io::ErrorKind::NotADirectory | io::ErrorKind::InvalidFilename));
        match store_failure(&error) {
            failure if is_misnamed || failure.kind() == Kind::Usage => {
                Failure::usage(format_args!("{argument} {}", failure.message()))
            }
            failure => failure,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_keep_their_section_and_unit() {
        let found = inputs("seed = 7\n[pressure]\nsize = [\"200 um\", \"100 um\"]\npercentile = 50.0\n");
        let as_text: Vec<String> = found.iter().map(|i| format!("{}.{} = {}", i.section, i.key, i.value)).collect();
        assert_eq!(as_text, ["study.seed = 7", "pressure.percentile = 50.0", "pressure.size = 200 um, 100 um"]);
    }
}
