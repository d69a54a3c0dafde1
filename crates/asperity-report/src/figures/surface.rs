//! Height maps, height density, autocorrelation, spectrum and structure functions.

mod correlation;
mod density;
mod scan;
mod spectrum;
mod structure;

use self::scan::scan_sentence;
use super::{CaptionedFigure, field_map, raster_map};
use asperity_results::Field;

use crate::plot::{Kind, Raster};
use crate::{ReportError, Run};

/// Draws the figures for which the run holds data.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn figures(run: &Run) -> Result<Vec<CaptionedFigure>, ReportError> {
    let charts = [density::figure(run), correlation::figure(run), spectrum::figure(run), structure::figure(run)];
    Ok(maps(run)?.into_iter().chain(charts.into_iter().flatten()).collect())
}

/// Draws the scan with its form on its own scale, and the roughness and its realisation on a common one.
fn maps(run: &Run) -> Result<Vec<CaptionedFigure>, ReportError> {
    const SATURATE: &str = "the colours saturate beyond the 0.1 % and 99.9 % quantiles.";
    let which = scan_sentence(run);
    let caption = format!("Heights relative to their mean, form included; {SATURATE}{which}");
    let mut maps: Vec<_> =
        field_map(run, "height_raw", Kind::Form, "Heights as measured", &caption)?.into_iter().collect();
    let names = [
        ("height_levelled", "Heights after levelling"),
        ("surface_sample", "One realisation of the random surface"),
        ("counterface_sample", "The counterface of that realisation, seen from outside"),
    ];
    // A field without any value has no image.
    let defined = |field: &&Field| field.values().iter().any(|value| value.is_finite());
    let shown: Vec<_> = names.iter().filter_map(|map| Some((map, run.fields.get(map.0).filter(defined)?))).collect();
    let rasters = Raster::with_common_scale(shown.iter().map(|(_, field)| *field), Kind::Height)?;
    let common =
        if rasters.len() > 1 { ", scan and realisation on one colour scale, each over its own field" } else { "" };
    let caption = format!("Heights relative to their mean{common}; {SATURATE}{which}");
    let drawn = shown.iter().zip(&rasters);
    maps.extend(drawn.filter_map(|(((name, title), _), raster)| raster_map(raster, name, title, &caption)));
    Ok(maps)
}
