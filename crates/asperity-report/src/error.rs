//! Errors of the report.

use thiserror::Error;

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
