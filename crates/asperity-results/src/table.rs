//! Tables: the data behind the figures.

use serde_json::Value;
use thiserror::Error;

use crate::labelled::{Answer, FieldKind, LabelledField};
use crate::unit::split_unit;

/// Header of the column that names rows.
const NAME: &str = "name";

/// Columns of equal length; NaN is an undefined value and an empty cell in CSV. Rows may have names, in a first column
/// `name`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Names of all rows; empty if they have none.
    names: Vec<String>,
    columns: Vec<(String, Vec<f64>)>,
}

/// Error of reading a CSV text as a table.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TableError {
    /// Not CSV.
    #[error("not a CSV table: {0}")]
    Csv(#[from] csv::Error),
    /// A cell is not a number.
    #[error("row {row}, column `{column}`: `{text}` is not a number")]
    Cell {
        /// Row, counted from 1 after the header.
        row: usize,
        /// Column name.
        column: String,
        /// Text of the cell.
        text: String,
    },
}

impl Table {
    /// Creates a table from named columns.
    ///
    /// # Panics
    /// If the columns differ in length.
    pub fn new<N: Into<String>>(columns: impl IntoIterator<Item = (N, Vec<f64>)>) -> Self {
        let columns: Vec<(String, Vec<f64>)> =
            columns.into_iter().map(|(name, values)| (name.into(), values)).collect();
        assert!(columns.windows(2).all(|pair| pair[0].1.len() == pair[1].1.len()), "columns differ in length");
        Self { names: Vec::new(), columns }
    }

    /// Creates a table from named columns and the names of its rows.
    ///
    /// # Panics
    /// If the columns differ in length, or the number of names differs from it.
    pub fn with_names<N: Into<String>>(names: Vec<String>, columns: impl IntoIterator<Item = (N, Vec<f64>)>) -> Self {
        let table = Self::new(columns);
        assert!(table.columns.iter().all(|(_, values)| values.len() == names.len()), "names differ from rows");
        Self { names, ..table }
    }

    /// Returns a row for each answer and a column for each of its numbers, in the order of their declaration. An interval
    /// `x_interval` has the columns `x_low` and `x_high` with the unit of x, and the numbers of an
    /// answer within it have its name before theirs.
    pub fn of<T: Answer>(answers: &[T]) -> Self {
        let rows: Vec<Value> = answers.iter().map(T::json).collect();
        let rows: Vec<&Value> = rows.iter().collect();
        Self { names: Vec::new(), columns: columns("", &T::fields(), &rows) }
    }

    /// Moves the named column, the abscissa, to the front.
    #[must_use]
    pub fn with_first(mut self, name: &str) -> Self {
        self.columns.sort_by_key(|(own, _)| own != name);
        self
    }

    /// Returns the names of the rows; empty if they have none.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the columns with their names.
    pub fn columns(&self) -> &[(String, Vec<f64>)] {
        &self.columns
    }

    /// Returns the columns with their names, without a copy.
    pub fn into_columns(self) -> Vec<(String, Vec<f64>)> {
        self.columns
    }

    /// Returns the values of the named column.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(own, _)| own == name).map(|(_, values)| values.as_slice())
    }

    /// Returns the values of the named column if one of them is finite.
    pub fn defined_column(&self, name: &str) -> Option<&[f64]> {
        self.column(name).filter(|values| values.iter().any(|value| value.is_finite()))
    }

    /// Returns comma-separated text with a header; reading it back gives the same bits.
    ///
    /// # Errors
    /// Only if the buffer of the CSV writer fails, which does not happen in memory.
    pub fn to_csv(&self) -> Result<Vec<u8>, TableError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let header = (!self.names.is_empty()).then_some(NAME);
        writer.write_record(header.into_iter().chain(self.columns.iter().map(|(name, _)| name.as_str())))?;
        let rows = self.columns.first().map_or(0, |(_, values)| values.len());
        let cell = |value: f64| if value.is_nan() { String::new() } else { format!("{value:?}") };
        for row in 0..rows {
            let name = self.names.get(row).cloned();
            writer.write_record(name.into_iter().chain(self.columns.iter().map(|(_, values)| cell(values[row]))))?;
        }
        writer.into_inner().map_err(|error| TableError::Csv(error.into_error().into()))
    }

    /// Reads the output of [`Table::to_csv`].
    ///
    /// # Errors
    /// The text is not CSV or contains cells that are no numbers.
    pub fn from_csv(bytes: &[u8]) -> Result<Self, TableError> {
        let mut reader = csv::Reader::from_reader(bytes);
        let named = usize::from(reader.headers()?.get(0) == Some(NAME));
        let mut names = Vec::new();
        let mut columns: Vec<(String, Vec<f64>)> =
            reader.headers()?.iter().skip(named).map(|name| (name.to_owned(), Vec::new())).collect();
        for (row, record) in reader.records().enumerate() {
            let record = record?;
            names.extend(record.iter().take(named).map(str::to_owned));
            for ((column, values), text) in columns.iter_mut().zip(record.iter().skip(named)) {
                let value = if text.is_empty() { Ok(f64::NAN) } else { text.parse() };
                values.push(value.map_err(|_| TableError::Cell {
                    row: row + 1,
                    column: column.clone(),
                    text: text.into(),
                })?);
            }
        }
        Ok(Self { names, columns })
    }
}

/// Returns the columns of the numbers of answers, given as JSON objects, with `prefix` before their names.
fn columns(prefix: &str, fields: &[LabelledField], rows: &[&Value]) -> Vec<(String, Vec<f64>)> {
    let numbers = |key: &str, place: Option<usize>| -> Vec<f64> {
        let number = |row: &&Value| place.map_or(&row[key], |place| &row[key][place]).as_f64();
        rows.iter().map(|row| number(row).unwrap_or(f64::NAN)).collect()
    };
    let of = |LabelledField { key, kind, .. }: &LabelledField| match kind {
        FieldKind::Number => vec![(format!("{prefix}{key}"), numbers(key, None))],
        FieldKind::Numbers if key.ends_with("interval") => {
            let name = key.trim_end_matches("interval");
            // `mean_interval` has the unit of `mean_pa`.
            let number = fields.iter().find(|field| field.interval == *key).map_or("", |field| &field.key);
            let unit = &number[split_unit(number).0.len()..];
            let unit = if name.trim_end_matches('_') == number { "" } else { unit };
            let end = |end, place| (format!("{prefix}{name}{end}{unit}"), numbers(key, Some(place)));
            vec![end("low", 0), end("high", 1)]
        }
        FieldKind::Answer(inner) => {
            columns(&format!("{prefix}{key}_"), inner, &rows.iter().map(|row| &row[key]).collect::<Vec<_>>())
        }
        _ => Vec::new(),
    };
    fields.iter().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_their_names_in_csv() {
        let names = vec!["monte_carlo".to_owned(), "a, \"quoted\"".to_owned()];
        let table = Table::with_names(names, [("work", vec![1.0, 2.0])]);
        let text = table.to_csv().unwrap();
        assert!(text.starts_with(b"name,work\nmonte_carlo,1.0\n"), "{}", String::from_utf8_lossy(&text));
        assert_eq!(Table::from_csv(&text).unwrap(), table);
    }

    #[test]
    fn a_table_survives_csv_bit_by_bit() {
        let table = Table::new([("x_m", vec![1.0 / 3.0, 1e-300, -0.0]), ("y, quoted", vec![f64::NAN, 2.0, f64::MAX])]);
        let back = Table::from_csv(&table.to_csv().unwrap()).unwrap();
        for ((name, values), (back_name, back_values)) in table.columns().iter().zip(back.columns()) {
            assert_eq!(name, back_name);
            assert!(
                values.iter().zip(back_values).all(|(a, b)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan())
            );
        }
    }
}
