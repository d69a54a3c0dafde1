//! The data of the report of a study.

use std::collections::BTreeMap;

use asperity_results::{Field, Provenance, Results, Table};

/// File with the results of a run, as tables name their source.
pub(crate) const RESULTS: &str = "results.json";

/// The data of the report of one study.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// Name of the study.
    pub name: String,
    /// The content of `results.json`.
    pub results: Results,
    /// The tables of the run by the name of their CSV file, without its extension.
    pub tables: BTreeMap<String, Table>,
    /// The fields of the run: `height_raw`, `height_levelled`, `surface_sample` in metre, `pressure_sample`, `pressure_mean`,
    /// `pressure_quantile_10`, `_50` and `_90` and `pressure_strip` in pascal, `contact_probability` and `expansion_error`.
    pub fields: BTreeMap<String, Field>,
    /// The inputs of the study as resolved, with units.
    pub inputs: Vec<Input>,
    /// The content of `provenance.json`.
    pub provenance: Option<Provenance>,
    /// The content of `machine.json`, which the reader of the page can move again.
    pub machine: Option<String>,
}

/// One input of a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// Section of the study file, such as `material`.
    pub section: String,
    /// Key in that section.
    pub key: String,
    /// Value with its unit, as text.
    pub value: String,
}
