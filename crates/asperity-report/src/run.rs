//! The data of the report of a study.

use std::collections::BTreeMap;

use asperity_results::{Provenance, Results};

use crate::ReportError;

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

/// Columns of equal length with their names, NaN where a value is undefined.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Name and values of every column, in SI units.
    pub columns: Vec<(String, Vec<f64>)>,
}

impl Table {
    /// Returns the named column if it exists and has a finite value.
    pub(crate) fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns
            .iter()
            .find(|(column, values)| column == name && values.iter().any(|v| v.is_finite()))
            .map(|(_, values)| values.as_slice())
    }
}

/// Values on a regular grid of cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Points along x (columns).
    pub nx: usize,
    /// Points along y (rows).
    pub ny: usize,
    /// Pitch along x in metre.
    pub dx_m: f64,
    /// Pitch along y in metre.
    pub dy_m: f64,
    /// Values in SI units, row by row from the top; NaN where missing.
    pub values: Vec<f64>,
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

/// Checks that the columns of each table have equal lengths, and that each field fills its grid.
pub(crate) fn validate<'a>(
    tables: impl IntoIterator<Item = (&'a str, &'a Table)>,
    fields: impl IntoIterator<Item = (&'a str, &'a Field)>,
) -> Result<(), ReportError> {
    for (name, table) in tables {
        let wanted = table.columns.first().map_or(0, |(_, values)| values.len());
        if let Some((column, values)) = table.columns.iter().find(|(_, values)| values.len() != wanted) {
            let (table, column, found) = (name.to_owned(), column.clone(), values.len());
            return Err(ReportError::RaggedTable { table, column, found, wanted });
        }
    }
    for (name, field) in fields {
        let &Field { nx, ny, dx_m, dy_m, .. } = field;
        let (found, wanted) = (field.values.len(), nx.saturating_mul(ny));
        if found != wanted {
            return Err(ReportError::FieldShape { field: name.into(), nx, ny, found, wanted });
        }
        if !(dx_m > 0.0 && dy_m > 0.0 && dx_m.is_finite() && dy_m.is_finite()) {
            let (dx_m, dy_m) = (dx_m.to_string(), dy_m.to_string());
            return Err(ReportError::FieldPitch { field: name.into(), dx_m, dy_m });
        }
    }
    Ok(())
}
