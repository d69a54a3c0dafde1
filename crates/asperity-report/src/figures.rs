//! The figures of a run, one module per stage.

pub(crate) mod friction;
pub(crate) mod pressure;
pub(crate) mod surface;
pub(crate) mod verdict;
pub(crate) mod vibration;

use crate::plot::{Align, Canvas, Chart, Kind, LABEL, Raster, Rect, WIDTH, draw, figure};
use crate::{Figure, ReportError, Run, Table};

/// A figure with its title, its caption and the files that hold its data.
#[derive(Debug, Clone)]
pub(crate) struct CaptionedFigure {
    pub(crate) name: &'static str,
    pub(crate) title: String,
    pub(crate) caption: String,
    /// Files of the run folder.
    pub(crate) sources: Vec<String>,
    pub(crate) svg: String,
}

impl CaptionedFigure {
    /// Draws charts of some tables in that many columns with one legend above them; `None` without charts.
    pub(crate) fn from_charts(
        name: &'static str,
        title: &str,
        caption: impl Into<String>,
        columns: usize,
        charts: &[Chart],
        tables: &[&str],
    ) -> Option<Self> {
        let caption = caption.into();
        let svg = (!charts.is_empty()).then(|| figure(title, &caption, columns, charts))?;
        let drawn = Self { name, title: title.into(), caption, sources: Vec::new(), svg };
        Some(drawn.with_tables(tables))
    }

    /// Draws on a canvas of some size.
    pub(crate) fn from_drawing(
        name: &'static str,
        title: &str,
        caption: impl Into<String>,
        size: (f64, f64),
        content: impl FnOnce(&mut Canvas),
    ) -> Self {
        let caption = caption.into();
        let svg = draw(size, title, &caption, content);
        Self { name, title: title.into(), caption, sources: Vec::new(), svg }
    }

    /// Names the tables that hold the data.
    pub(crate) fn with_tables(mut self, tables: &[&str]) -> Self {
        self.sources.extend(tables.iter().map(|table| format!("tables/{table}.csv")));
        self
    }

    /// Names the fields that hold the data.
    pub(crate) fn with_fields(mut self, fields: &[&str]) -> Self {
        self.sources.extend(fields.iter().map(|field| format!("fields/{field}")));
        self
    }
}

impl From<CaptionedFigure> for Figure {
    fn from(figure: CaptionedFigure) -> Self {
        Self { name: figure.name.into(), svg: figure.svg }
    }
}

/// Returns the named columns of a table if all of them hold values.
pub(crate) fn columns<'a, const N: usize>(table: &'a Table, names: [&str; N]) -> Option<[&'a [f64]; N]> {
    let found: Vec<&[f64]> = names.iter().filter_map(|name| table.column(name)).collect();
    found.try_into().ok()
}

/// Returns the names that are keys of the tables.
fn present<'a>(run: &Run, names: &[&'a str]) -> Vec<&'a str> {
    names.iter().copied().filter(|name| run.tables.contains_key(*name)).collect()
}

/// Returns the values that a logarithmic axis can show.
pub(crate) fn positive(values: &[f64]) -> impl Iterator<Item = &f64> + Clone {
    values.iter().filter(|value| **value > 0.0)
}

/// Draws a field as a map, if the run holds it.
///
/// # Errors
/// The PNG encoder failed.
fn field_map(
    run: &Run,
    name: &'static str,
    kind: Kind,
    title: &str,
    caption: &str,
) -> Result<Option<CaptionedFigure>, ReportError> {
    let raster = run.fields.get(name).map(|field| Raster::new(field, kind)).transpose()?.flatten();
    Ok(raster.and_then(|raster| raster_map(&raster, name, title, caption)))
}

/// Draws a raster as a map.
fn raster_map(raster: &Raster, name: &'static str, title: &str, caption: &str) -> Option<CaptionedFigure> {
    Some(raster_panels(name, title, caption, &[("", raster)], 1, (WIDTH, 400.0))?.with_fields(&[name]))
}

/// Draws rasters of one colour scale with their names in a grid of panels, with axes, colour bar and legend. `size` is the width of
/// the figure and the largest height of all rows of panels. Panels of all shapes are centred in the same width.
pub(crate) fn raster_panels(
    name: &'static str,
    title: &str,
    caption: &str,
    panels: &[(&str, &Raster)],
    columns: usize,
    size: (f64, f64),
) -> Option<CaptionedFigure> {
    const LEFT: f64 = 92.0;
    const RIGHT: f64 = 118.0;
    const BETWEEN: f64 = 36.0;
    let (first_name, first) = panels.first()?;
    let rows = panels.len().div_ceil(columns);
    let room = (size.0 - LEFT - RIGHT + BETWEEN) / columns as f64 - BETWEEN;
    let tallest = size.1 / rows as f64;
    let width = room.min(tallest / first.aspect()).max(40.0);
    let height = (width * first.aspect()).clamp(40.0, tallest);
    let left = LEFT + 0.5 * (room - width) * columns as f64;
    let legend = panels.iter().find(|(_, raster)| raster.has_legend());
    let above = if first_name.is_empty() { 8.0 } else { 32.0 };
    let top = |row: usize| if legend.is_some() { 22.0 } else { 0.0 } + above + (height + above) * row as f64;
    let bottom = top(rows - 1) + height;
    let right = left + (width + BETWEEN) * columns as f64 - BETWEEN;
    let bar = Rect::new(right + 18.0, top(0), 16.0, (bottom - top(0)).max(100.0));
    let caption = format!("{caption}{}", first.pixel_sentence());
    let size = (size.0, (bottom + 54.0).max(bar.bottom + 2.0).ceil());
    Some(CaptionedFigure::from_drawing(name, title, caption, size, |canvas| {
        if let Some((_, raster)) = legend {
            raster.draw_legend(canvas, (left, 14.0));
        }
        for (number, (name, raster)) in panels.iter().enumerate() {
            let (row, column) = (number / columns, number % columns);
            let plot = Rect::new(left + (width + BETWEEN) * column as f64, top(row), width, height);
            // The lowest panel of a column has the x axis.
            raster.draw(canvas, plot, number + columns >= panels.len(), column == 0);
            canvas.text((plot.left, plot.top - 12.0), name, LABEL, Align::Start);
        }
        first.draw_colour_bar(canvas, bar);
    }))
}
