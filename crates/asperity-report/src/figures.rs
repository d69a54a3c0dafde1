//! The figures of a run, one module per stage.

pub(crate) mod friction;
mod pressure;
mod surface;
pub(crate) mod vibration;

use crate::canvas::{Rect, draw};
use crate::raster::{Kind, Raster};
use crate::{ReportError, Run, Table};

/// The stage that a figure belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stage {
    Surface,
    Pressure,
    Friction,
    /// The quotient F/N of single windows.
    Quotient,
    Vibration,
}

/// A figure with what the page says about it.
#[derive(Debug, Clone)]
pub(crate) struct Plate {
    pub(crate) name: &'static str,
    pub(crate) stage: Stage,
    pub(crate) title: String,
    pub(crate) caption: String,
    /// Files of the run folder that hold what is drawn.
    pub(crate) sources: Vec<String>,
    pub(crate) svg: String,
}

/// All figures for which the run holds data, in the order of the chain.
///
/// # Errors
/// The drawing backend's and the PNG encoder's.
pub(crate) fn plates(run: &Run) -> Result<Vec<Plate>, ReportError> {
    let mut plates = Vec::new();
    surface::plates(run, &mut plates)?;
    pressure::plates(run, &mut plates)?;
    friction::plates(run, &mut plates)?;
    vibration::plates(run, &mut plates)?;
    Ok(plates)
}

fn csv(table: &str) -> String {
    format!("tables/{table}.csv")
}

/// The named columns of a table, if all of them hold values.
fn columns<'a, const N: usize>(table: &'a Table, names: [&str; N]) -> Option<[&'a [f64]; N]> {
    let found: Vec<&[f64]> = names.iter().filter_map(|name| table.column(name)).collect();
    found.try_into().ok()
}

/// A map with axes, colour bar and legend, if the run holds the field.
///
/// # Errors
/// The drawing backend's and the PNG encoder's.
fn map(
    run: &Run,
    (name, stage): (&'static str, Stage),
    kind: Kind,
    title: &str,
    caption: &str,
) -> Result<Option<Plate>, ReportError> {
    let Some(raster) = run.fields.get(name).map(|field| Raster::new(field, kind)).transpose()?.flatten() else {
        return Ok(None);
    };
    map_of(&raster, (name, stage), title, caption).map(Some)
}

/// A map with axes, colour bar and legend from its raster.
///
/// # Errors
/// The drawing backend's and the PNG encoder's.
fn map_of(
    raster: &Raster,
    (name, stage): (&'static str, Stage),
    title: &str,
    caption: &str,
) -> Result<Plate, ReportError> {
    let caption = match raster.block {
        1 => caption.to_owned(),
        block => format!("{caption} Each pixel is the mean of {block} × {block} points."),
    };
    let (left, room, tallest): (f64, f64, f64) = (92.0, 400.0, 400.0);
    let width = room.min(tallest / raster.aspect()).max(40.0);
    let height = (width * raster.aspect()).clamp(40.0, tallest);
    let legend = if raster.kind() == Kind::Pressure || raster.missing > 0 { 30.0 } else { 10.0 };
    // Maps of all shapes stand in the middle of the same width.
    let left = left + 0.5 * (room - width);
    let plot = Rect::new(left, legend, width, height);
    let bar = height.max(100.0);
    let svg = draw((640.0, (legend + bar.max(height + 52.0)).ceil() + 2.0), title, &caption, |canvas| {
        raster.legend(canvas, (left, 14.0))?;
        raster.draw(canvas, plot, true)?;
        raster.colour_bar(canvas, Rect::new(plot.right + 18.0, plot.top, 16.0, bar))
    })?;
    let sources = vec![format!("fields/{name}")];
    Ok(Plate { name, stage, title: title.into(), caption, sources, svg })
}
