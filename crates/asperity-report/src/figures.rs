//! The figures of a run, one module per stage.

pub(crate) mod friction;
pub(crate) mod pressure;
pub(crate) mod surface;
pub(crate) mod verdict;
pub(crate) mod vibration;

use asperity_results::Table;

use crate::plot::{Chart, ColourBar, Kind, Layout, ONE_COLUMN, PAGE, Raster, TWO_COLUMNS};
use crate::{ReportError, Run};

/// A figure with its title, its caption and the files that hold its data.
#[derive(Debug, Clone)]
pub(crate) struct CaptionedFigure {
    pub(crate) name: &'static str,
    pub(crate) title: String,
    pub(crate) caption: String,
    /// Files of the run folder.
    pub(crate) sources: Vec<String>,
    pub(crate) layout: Layout,
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
        let layout = (!charts.is_empty()).then(|| Layout::new(columns, charts))?;
        let drawn = Self { name, title: title.into(), caption: caption.into(), sources: Vec::new(), layout };
        Some(drawn.with_tables(tables))
    }

    /// Adds the bar that explains the colours of the maps.
    pub(crate) fn with_colours(mut self, colours: ColourBar) -> Self {
        self.layout.colours = Some(colours);
        self
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

    /// Draws the figure, two columns of a paper wide.
    pub(crate) fn svg(&self) -> String {
        self.layout.svg(&self.title, &self.caption, TWO_COLUMNS)
    }

    /// Draws the figure for a page, which scales it to the width of the screen.
    pub(crate) fn svg_of_page(&self) -> String {
        self.layout.svg(&self.title, &self.caption, PAGE)
    }
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

impl From<CaptionedFigure> for Figure {
    fn from(figure: CaptionedFigure) -> Self {
        let one_column = || figure.layout.svg(&figure.title, &figure.caption, ONE_COLUMN);
        let one_column = (figure.layout.columns == 1).then(one_column);
        Self { name: figure.name.into(), svg: figure.svg(), one_column }
    }
}

/// Returns the named columns of a table if all of them hold values.
pub(crate) fn columns<'a, const N: usize>(table: &'a Table, names: [&str; N]) -> Option<[&'a [f64]; N]> {
    let found: Vec<&[f64]> = names.iter().filter_map(|name| table.defined_column(name)).collect();
    found.try_into().ok()
}

/// Returns columns of a table of curves if all of them hold values.
pub(crate) fn defined<const N: usize>(columns: [&[f64]; N]) -> Option<[&[f64]; N]> {
    columns.iter().all(|column| !column.is_empty()).then_some(columns)
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
    Some(raster_panels(name, title, caption, &[("", raster)], 1, 400.0)?.with_fields(&[name]))
}

/// Draws rasters of one colour scale with their names in a grid of panels, with axes, colour bar and legend. `height` is the largest
/// one of all rows of panels.
pub(crate) fn raster_panels(
    name: &'static str,
    title: &str,
    caption: &str,
    panels: &[(&str, &Raster)],
    columns: usize,
    height: f64,
) -> Option<CaptionedFigure> {
    let (_, first) = panels.first()?;
    let tallest = height / panels.len().div_ceil(columns) as f64;
    let charts: Vec<Chart> = panels
        .iter()
        .enumerate()
        .map(|(number, (name, raster))| {
            let mut chart = raster.chart().with_height(tallest);
            // The lowest panel of a column has the x axis, the first of a row the y axis.
            chart.shows_x = number + columns >= panels.len();
            chart.shows_y = number % columns == 0;
            if name.is_empty() { chart } else { chart.with_title(name) }
        })
        .collect();
    let caption = format!("{caption}{}", first.pixel_sentence());
    let figure = CaptionedFigure::from_charts(name, title, caption, columns, &charts, &[])?;
    Some(figure.with_colours(first.colour_bar().clone()))
}
