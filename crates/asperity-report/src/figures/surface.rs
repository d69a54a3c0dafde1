//! Height maps, height density, autocorrelation, spectrum and structure functions.

mod correlation;
mod density;
mod spectrum;
mod structure;

use serde_json::Value;

use super::{Plate, Stage, columns, csv, map, map_of};
use crate::raster::{Kind, Raster};
use crate::{Field, ReportError, Run};

pub(super) fn plates(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    maps(run, plates)?;
    plates.extend(density::plate(run)?);
    plates.extend(correlation::plate(run)?);
    plates.extend(spectrum::plate(run)?);
    plates.extend(structure::plate(run)?);
    Ok(())
}

/// The scan on a scale of its own, form included; the roughness and its realisation on one.
fn maps(run: &Run, plates: &mut Vec<Plate>) -> Result<(), ReportError> {
    const SATURATE: &str = "the colours saturate beyond the 0.1 % and 99.9 % quantiles.";
    let which = which(run);
    let raw = format!("Heights relative to their mean, form included; {SATURATE}{which}");
    plates.extend(map(run, ("height_raw", Stage::Surface), Kind::Height, "Heights as measured", &raw)?);
    let maps =
        [("height_levelled", "Heights after levelling"), ("surface_sample", "One realisation of the random surface")];
    // A field without any value has no image and no say in the scale.
    let present = |field: &&Field| field.values.iter().any(|value| value.is_finite());
    let shown: Vec<_> = maps.iter().filter_map(|map| Some((map, run.fields.get(map.0).filter(present)?))).collect();
    let rasters = Raster::on_one_scale(shown.iter().map(|(_, field)| *field), Kind::Height)?;
    let caption = match rasters.len() {
        1 => format!("Heights relative to their mean; {SATURATE}{which}"),
        _ => format!(
            "Heights relative to their mean, scan and realisation on one colour scale, each over its own field; \
             {SATURATE}{which}"
        ),
    };
    for (((name, title), _), raster) in shown.iter().zip(&rasters) {
        plates.push(map_of(raster, (name, Stage::Surface), title, &caption)?);
    }
    Ok(())
}

/// The results of the scan that the figures show: the first of several.
fn scan(run: &Run) -> &Value {
    let surface = &run.results["surface"];
    surface["scans"].get(0).unwrap_or(surface)
}

/// A number of the scan's results.
fn number(run: &Run, key: &str) -> Option<f64> {
    scan(run)[key].as_f64().filter(|value| value.is_finite())
}

/// Which scan a figure shows, as a sentence at the end of its caption; nothing where there is but one.
fn which(run: &Run) -> String {
    let scans = run.results["surface"]["scans"].as_array().map_or(0, Vec::len);
    match scan(run)["file"].as_str().filter(|_| scans > 1) {
        Some(file) => format!(" Measured: {file}, the first of {scans} scans; the random surface is of all."),
        None => String::new(),
    }
}
