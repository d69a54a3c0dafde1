//! Height maps, height density, autocorrelation, spectrum and structure functions.

mod correlation;
mod density;
mod spectrum;
mod structure;

use asperity_results::{SurfaceResult, SurfaceStatistics};

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

/// The statistics of the scan that the figures show: the first of several.
fn scan(run: &Run) -> Option<&SurfaceStatistics> {
    let surface = run.results.surface.as_ref()?;
    surface.scan().or_else(|| Some(&surface.part()?.scans.first()?.statistics))
}

/// Which scan a figure shows, as a sentence at the end of its caption; nothing where there is but one.
fn which(run: &Run) -> String {
    let part = run.results.surface.as_ref().and_then(SurfaceResult::part);
    match part.and_then(|part| part.scans.first().filter(|_| part.scans.len() > 1).zip(Some(part.scans.len()))) {
        Some((first, scans)) => {
            format!(" Measured: {}, the first of {scans} scans; the random surface is of all.", first.file)
        }
        None => String::new(),
    }
}
