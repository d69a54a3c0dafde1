//! Tables of a page, also as text.

use std::fmt::{self, Display};

use crate::cells::DASH;
use crate::markup::{Html, html};

/// A table of the page: header cells and rows of text. A row of one cell is the title of the rows below it.
#[derive(Debug, Clone, Default)]
pub(crate) struct DataTable {
    pub(super) caption: String,
    pub(super) headers: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
    /// Rows whose last cell is highlighted.
    pub(super) highlighted: Vec<usize>,
}

impl DataTable {
    pub(crate) fn new(caption: &str, headers: &[&str], rows: Vec<Vec<String>>) -> Self {
        let headers = headers.iter().map(|header| (*header).to_owned()).collect();
        Self { caption: caption.into(), headers, rows, highlighted: Vec::new() }
    }

    /// Returns a table of names and values. A name with an empty value is the title of the rows below it.
    pub(crate) fn properties(caption: &str, rows: impl IntoIterator<Item = (String, String)>) -> Self {
        let row = |(name, value): (String, String)| if value.is_empty() { vec![name] } else { vec![name, value] };
        Self::new(caption, &["Property", "Value"], rows.into_iter().map(row).collect())
    }

    /// Highlights the last cell of some rows.
    pub(crate) fn with_highlighted(self, highlighted: Vec<usize>) -> Self {
        Self { highlighted, ..self }
    }

    /// Leaves out columns in which every cell is a dash.
    pub(super) fn without_empty_columns(mut self) -> Self {
        let kept: Vec<bool> = (0..self.headers.len())
            .map(|c| self.rows.iter().filter(|row| row.len() > 1).any(|row| row.get(c).is_some_and(|t| t != DASH)))
            .collect();
        for row in self.rows.iter_mut().chain([&mut self.headers]) {
            let mut columns = kept.iter();
            row.retain(|_| columns.next() == Some(&true));
        }
        self
    }

    pub(super) fn html(&self) -> Html {
        let caption = match self.caption.as_str() {
            "" => Html::default(),
            caption => html!("<caption>{}</caption>\n", caption),
        };
        let headers = self.headers.iter().map(|header| html!("<th scope=\"col\">{}</th>", header));
        let rows = self.rows.iter().enumerate().map(|(place, row)| match row.as_slice() {
            [title] => {
                let span = self.headers.len().to_string();
                html!("<tr class=\"group\"><th scope=\"rowgroup\" colspan=\"{}\">{}</th></tr>\n", span, title)
            }
            [first, cells @ ..] => {
                let is_highlighted = self.highlighted.contains(&place);
                let cells =
                    cells.iter().enumerate().map(|(column, cell)| match is_highlighted && column + 1 == cells.len() {
                        true => html!("<td class=\"outside\">{}</td>", cell),
                        false => html!("<td>{}</td>", cell),
                    });
                html!("<tr><th scope=\"row\">{}</th>{}</tr>\n", first, cells.collect::<Html>())
            }
            [] => Html::default(),
        });
        html!(
            "<div class=\"table\" role=\"region\" tabindex=\"0\" aria-label=\"{}\">\n<table>\n{}<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody>\n</table>\n</div>\n",
            if self.caption.is_empty() { "Table" } else { &self.caption },
            caption,
            headers.collect::<Html>(),
            rows.collect::<Html>(),
        )
    }
}

impl Display for DataTable {
    /// Writes the caption, then the headers and rows in aligned columns.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rows = || std::iter::once(&self.headers).chain(&self.rows);
        let cell = |row: &[String], column: usize| row.get(column).map_or(0, |cell| cell.chars().count());
        let widths: Vec<usize> =
            (0..self.headers.len()).map(|column| rows().map(|row| cell(row, column)).max().unwrap_or(0)).collect();
        writeln!(f, "{}", self.caption)?;
        for row in rows() {
            let cells = row.iter().zip(&widths).map(|(cell, width)| format!("  {cell:width$}"));
            writeln!(f, "{}", cells.collect::<String>().trim_end())?;
        }
        Ok(())
    }
}
