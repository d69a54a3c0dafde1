//! The figures of a run, one module per stage.

pub(crate) mod friction;
pub(crate) mod pressure;
pub(crate) mod surface;
pub(crate) mod vibration;

use crate::canvas::{Canvas, Rect, draw};
use crate::chart::{Chart, WIDTH, figure};
use crate::raster::{Kind, Raster};
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
    /// Draws charts in that many columns with one legend above them; `None` without charts.
    pub(crate) fn from_charts(
        name: &'static str,
        title: &str,
        caption: impl Into<String>,
        columns: usize,
        charts: &[Chart],
    ) -> Option<Self> {
        let caption = caption.into();
        let svg = (!charts.is_empty()).then(|| figure(title, &caption, columns, charts))?;
        Some(Self { name, title: title.into(), caption, sources: Vec::new(), svg })
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
    Ok(raster.map(|raster| raster_map(&raster, name, title, caption)))
}

/// Draws a raster with axes, colour bar and legend.
fn raster_map(raster: &Raster, name: &'static str, title: &str, caption: &str) -> CaptionedFigure {
    let caption = format!("{caption}{}", raster.pixel_sentence());
    let (left, room, tallest): (f64, f64, f64) = (92.0, 400.0, 400.0);
    let width = room.min(tallest / raster.aspect()).max(40.0);
    let height = (width * raster.aspect()).clamp(40.0, tallest);
    let legend = if raster.has_legend() { 30.0 } else { 10.0 };
    // Maps of all shapes are centred in the same width.
    let plot = Rect::new(left + 0.5 * (room - width), legend, width, height);
    let bar = height.max(100.0);
    let size = (WIDTH, (legend + bar.max(height + 52.0)).ceil() + 2.0);
    let drawn = CaptionedFigure::from_drawing(name, title, caption, size, |canvas| {
        raster.draw_legend(canvas, (plot.left, 14.0));
        raster.draw(canvas, plot, true, true);
        raster.draw_colour_bar(canvas, Rect::new(plot.right + 18.0, plot.top, 16.0, bar));
    });
    drawn.with_fields(&[name])
}
