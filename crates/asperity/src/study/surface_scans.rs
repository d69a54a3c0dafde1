//! Preparation and measurement of the scans of a surface.

use asperity_formats::Scan;

use crate::map::HeightMap;
use crate::monitor::{Monitor, Quiet};
use crate::random;
use crate::study::output::StageOutput;
use crate::study::series::map_field;
use crate::study::{StudyError, sentence};
use crate::surface::level::Level;
use crate::surface::model::SurfaceModelError;
use crate::surface::preparation::{Preparation, Prepared};
use crate::surface::scanned::ScannedSurface;
use crate::surface::{FillError, FillOptions, Filling, RandomSurface};

/// Returns the error of one of several scans.
pub(super) fn of_one(file: &str, error: StudyError) -> StudyError {
    match error {
        error @ StudyError::Map { .. } => error,
        error => StudyError::OneOf { file: file.into(), error: Box::new(error) },
    }
}

/// Prepares and measures all scans; maps and series show the first.
pub(super) fn measure_all(
    preparation: &Preparation,
    scans: Vec<(String, Scan)>,
    output: &mut StageOutput,
) -> Result<Option<ScannedSurface>, StudyError> {
    if scans.len() < 2 {
        let one = scans.into_iter().next();
        return one.map(|(file, scan)| measure(preparation, &file, scan, output)).transpose();
    }
    let mut measured = Vec::with_capacity(scans.len());
    for (file, scan) in scans {
        let mut own = StageOutput::default();
        let scan = measure(preparation, &file, scan, &mut own).map_err(|error| of_one(&file, error))?;
        if measured.is_empty() {
            output.fields = own.fields;
        }
        output.assumptions.append(&mut own.assumptions);
        output.warnings.extend(own.warnings.into_iter().map(|warning| format!("{file}: {warning}")));
        measured.push((file, scan));
    }
    output.assumptions.push(format!(
        "The {} scans are taken as samples of one part: statistics are weighted means over the scans, the correlation is \
         that of all pairs of heights within a scan, the marginal distribution that of all heights. Maps and figures of the \
         measured heights show {}.",
        measured.len(),
        measured[0].0
    ));
    let mut names: Vec<&String> = measured.iter().map(|(file, _)| file).collect();
    names.sort();
    for pair in names.windows(2).filter(|pair| pair[0] == pair[1]) {
        output.warnings.push(format!("{} is listed twice and counts as two places: intervals are too narrow", pair[0]));
    }
    Ok(Some(ScannedSurface::from_scans(measured)?))
}

/// Prepares a scan and computes its statistics.
pub(super) fn measure(
    preparation: &Preparation,
    file: &str,
    mut scan: Scan,
    output: &mut StageOutput,
) -> Result<ScannedSurface, StudyError> {
    output.warnings.append(&mut scan.warnings);
    let raw = HeightMap::try_from(scan).map_err(|error| StudyError::Map { file: file.into(), error })?;
    let prepared = preparation.apply(raw.clone()).map_err(SurfaceModelError::from)?;
    let map = &prepared.map;
    output.fields.push(("height_raw", map_field(raw.grid(), "m", raw.heights_m().clone())));
    output.fields.push(("height_levelled", map_field(map.grid(), "m", map.heights_m().clone())));
    let grid = map.grid();
    output.assumptions.push(format!(
        "The scan {file} {}. Its statistics hold for pixels of {} on a field of {}. {} of {} points are missing and stay \
         missing.",
        in_words(preparation, &prepared),
        sentence::size(grid.dx_m(), grid.dy_m()),
        sentence::size(grid.width_m(), grid.height_m()),
        map.missing_points(),
        grid.points()
    ));
    if prepared.lost > 0 {
        let lost = sentence::count(prepared.lost, "height", "heights");
        output.warnings.push(format!("the robust filter found no surface around {lost}, which count as missing"));
    }
    Ok(ScannedSurface::new(prepared)?)
}

/// Returns the preparation of a scan as the end of a sentence.
fn in_words(preparation: &Preparation, prepared: &Prepared) -> String {
    let form = match preparation.level {
        Level::None => "was not levelled".to_owned(),
        Level::Mean => "was counted from its mean".to_owned(),
        Level::Polynomial(degree) => format!("was levelled by its least-squares polynomial of degree {degree}"),
        Level::Plane | Level::Quadratic | Level::Cylinder | Level::Sphere => {
            let radius = prepared.radius_m.map_or_else(String::new, |m| format!(" of radius {}", sentence::si(m, "m")));
            format!("was levelled by its least-squares {}{radius}", preparation.level)
        }
    };
    let outliers = preparation.outliers.map_or_else(
        || "no outliers were looked for".to_owned(),
        |k| {
            let rejected = sentence::count(prepared.outliers, "height", "heights");
            format!("{rejected} beyond {k} robust standard deviations rejected")
        },
    );
    let filter = |name: &str, cutoff_m: Option<f64>| {
        cutoff_m.map_or_else(|| format!("no {name}-filter"), |m| format!("{name}-filter at {}", sentence::si(m, "m")))
    };
    let kind = if preparation.robust { " (robust)" } else { "" };
    let (short, long) = (filter("S", preparation.s_filter_m), filter("L", preparation.l_filter_m));
    format!("{form} ({outliers}; {short}; {long}{kind})")
}

/// Returns the map with its voids filled by a random surface of its statistics; `stage` is the stream of the random numbers.
pub(super) fn filled(
    map: &HeightMap,
    seed: u64,
    stage: &'static str,
    monitor: &dyn Monitor,
) -> Result<HeightMap, FillError> {
    if map.missing_points() == 0 {
        return Ok(map.clone());
    }
    let filling = Filling::new(map, FillOptions::default(), &Quiet(monitor))?;
    Ok(filling.generate(&random::standard_normal(&mut random::stream(seed, stage, 0), filling.xi_len())))
}
