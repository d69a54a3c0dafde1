//! Output of the stages, in addition to their results.

use std::collections::BTreeMap;

use crate::friction::process::FittedProcess;
use crate::study::result::{Outcome, Results};
use crate::study::run_machine::RunMachine;
use crate::study::{Field, Table, sentence};

/// Tables, fields and sentences of one stage.
#[derive(Debug, Clone, Default)]
pub(super) struct StageOutput {
    pub(super) tables: Vec<(&'static str, Table)>,
    pub(super) fields: Vec<(&'static str, Field)>,
    /// Assumptions, in sentences.
    pub(super) assumptions: Vec<String>,
    /// Warnings, in sentences.
    pub(super) warnings: Vec<String>,
}

impl StageOutput {
    /// Appends the output of a part of the same stage.
    pub(super) fn extend(&mut self, part: Self) {
        self.tables.extend(part.tables);
        self.fields.extend(part.fields);
        self.assumptions.extend(part.assumptions);
        self.warnings.extend(part.warnings);
    }
}

/// Returns the warning that statistics leave out failed samples.
pub(super) fn left_out(what: &str, failed: usize, of: usize) -> Option<String> {
    let percent = sentence::digits(100.0 * failed as f64 / of as f64);
    (failed > 0).then(|| {
        format!(
            "{failed} of {of} {what} failed ({percent} %) and are left out; failures may depend on the surface, so the others need not be a \
             random choice"
        )
    })
}

/// Output of all stages, in their order.
#[derive(Default)]
pub(super) struct Gathered {
    pub(super) results: Results,
    tables: BTreeMap<String, Table>,
    fields: BTreeMap<String, Field>,
    pub(super) friction_process: Option<FittedProcess>,
    pub(super) machine: Option<RunMachine>,
}

impl Gathered {
    pub(super) fn add(&mut self, output: StageOutput) {
        self.tables.extend(output.tables.into_iter().map(|(name, table)| (name.to_owned(), table)));
        self.fields.extend(output.fields.into_iter().map(|(name, field)| (name.to_owned(), field)));
        self.results.assumptions.extend(output.assumptions);
        self.results.warnings.extend(output.warnings);
    }

    pub(super) fn outcome(self) -> Outcome {
        Outcome {
            results: self.results,
            tables: self.tables,
            fields: self.fields,
            friction_process: self.friction_process,
            machine: self.machine,
        }
    }
}
