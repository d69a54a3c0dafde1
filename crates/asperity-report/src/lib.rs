//! Results of a study as one self-contained HTML page and SVG figures.
//!
//! [`render`] is a pure function of a [`Run`]: it reads no file, clock or environment, and equal runs give equal bytes.
//! A study may stop after any of its stages; the report leaves out absent results, tables and fields.
//!
//! # Conventions
//! - Numbers are in SI units, with the unit in the names of columns and keys (`lag_m`, `pressure_pa`); the report chooses
//!   engineering units for display.
//! - NaN in tables and `None` in results mean undefined. Curves are interrupted there and cells show a dash.
//! - All text of the caller is escaped: HTML is written from literal templates only.

mod campaign;
mod figures;
mod fits;
mod format;
mod markup;
mod motion;
mod page;
mod plot;
mod record;
mod twin;
mod verdict;

use std::collections::BTreeMap;

use asperity_results::{Provenance, Results, VibrationResult};
use thiserror::Error;

pub use campaign::{CampaignRun, render_campaign};
pub use motion::render_vibration;
pub use page::verdict_text;
pub use record::record_figures;
pub use twin::{TwinRun, render_twins};
pub use verdict::verdict_sentence;

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
    fn column(&self, name: &str) -> Option<&[f64]> {
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

/// A rendered report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// One HTML document that needs no other file and no network.
    pub html: String,
    /// The figures of the document, for use elsewhere.
    pub figures: Vec<Figure>,
}

/// One figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// File name without extension, such as `pressure_cdf`.
    pub name: String,
    /// A complete SVG document, two columns of a paper (170 mm) wide.
    pub svg: String,
    /// The same figure in one column (85 mm), unless its charts stand side by side.
    pub one_column: Option<String>,
}

impl Figure {
    /// Returns the files of the figure: their paths in a folder, and their content.
    pub fn files(&self) -> impl Iterator<Item = (String, &str)> {
        let one_column =
            self.one_column.iter().map(|svg| (format!("figures/{}_one_column.svg", self.name), svg.as_str()));
        std::iter::once((format!("figures/{}.svg", self.name), self.svg.as_str())).chain(one_column)
    }
}

/// Reason why a report cannot be rendered.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// Columns of a table differ in length.
    #[error("table `{table}`: column `{column}` has {found} values, the first column {wanted}")]
    RaggedTable {
        /// Name of the table.
        table: String,
        /// The column that differs.
        column: String,
        /// Its length.
        found: usize,
        /// Length of the first column.
        wanted: usize,
    },
    /// A field's values do not fill its grid.
    #[error("field `{field}` has {found} values, its {nx} × {ny} grid needs {wanted}")]
    FieldShape {
        /// Name of the field.
        field: String,
        /// Points along x.
        nx: usize,
        /// Points along y.
        ny: usize,
        /// Number of values found.
        found: usize,
        /// Number of values wanted.
        wanted: usize,
    },
    /// A field's pitch is not positive and finite.
    #[error("field `{field}` has the pixel size {dx_m} × {dy_m} m; both must be positive")]
    FieldPitch {
        /// Name of the field.
        field: String,
        /// Pitch along x, as text, in metre.
        dx_m: String,
        /// Pitch along y, as text, in metre.
        dy_m: String,
    },
    /// A map could not be encoded.
    #[error("a map could not be encoded as PNG: {message}")]
    Image {
        /// The encoder's message.
        message: String,
    },
}

/// Renders the report of a run.
///
/// # Errors
/// The columns of a table differ in length, a field does not fill its grid or has no pixel size, or the PNG encoder failed.
pub fn render(run: &Run) -> Result<Report, ReportError> {
    let tables = run.tables.iter().map(|(name, table)| (name.as_str(), table));
    validate(tables, run.fields.iter().map(|(name, field)| (name.as_str(), field)))?;
    Ok(page::of_run(run)?.render())
}

/// Returns the answer to "Does it vibrate?".
pub fn vibration_answer(vibration: &VibrationResult) -> String {
    page::answers::vibration_answer(vibration)
}

fn validate<'a>(
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

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
