//! Surface stage: statistics of the scans, and the model of the random surfaces.

use std::mem;
use std::path::Path;

use asperity_formats::Scan;

use crate::correlation::{CorrelationModel, StationaryCovariance};
use crate::map::HeightMap;
use crate::study::contact_check::contact_warning;
use crate::study::file::SurfaceSection;
use crate::study::output::StageOutput;
use crate::study::result::{CovarianceResult, MeasuredSurface, SurfaceResult, law_result};
use crate::study::scan_tables::scan_tables;
use crate::study::surface_result::{covariance_result, karhunen_loeve_result, part_statistics, surface_statistics};
use crate::study::{QuantityMap, StudyError, sentence};
use crate::surface::CovarianceSource;
use crate::surface::level::Level;
use crate::surface::model::{
    CapturedModes, CompositeModel, GAMMA, Measurable, RIDGES, SelectedCovariance, SurfaceCovariance, SurfaceModel,
    SurfaceModelError, SurfaceRequest, Texture,
};
use crate::surface::preparation::{Preparation, Prepared};
use crate::surface::scanned::ScannedSurface;
use crate::translation::TranslationKind;

/// Model of the random surfaces, and the scans on which it is measured.
pub(super) struct SurfaceStage {
    /// Model of the surface, and of a rough counterface.
    pub(super) model: CompositeModel,
    pub(super) measured: Option<ScannedSurface>,
    /// Scans of a rough counterface.
    pub(super) measured_counterface: Option<ScannedSurface>,
    /// Shortest wavelength in metre at which the spectra of all scans are reliable.
    pub(super) band_end_m: Option<f64>,
    covariance: Option<CovarianceResult>,
    pub(super) output: StageOutput,
}

impl SurfaceStage {
    /// Returns the entry of `results.json`; `karhunen_loeve` is the expansion on the patches of the pressure stage.
    pub(super) fn result(&self, karhunen_loeve: Option<CapturedModes>) -> SurfaceResult {
        let measured = match &self.measured {
            None => MeasuredSurface::Stated {},
            Some(ScannedSurface { part: Some(part), .. }) => {
                MeasuredSurface::Part(Box::new(part_statistics(&part.statistics)))
            }
            Some(scan) => MeasuredSurface::Scan(Box::new(surface_statistics(&scan.statistics))),
        };
        let (covariance, marginal) = (self.covariance.clone(), law_result(&self.model.surface.marginal));
        SurfaceResult { measured, covariance, marginal, karhunen_loeve: karhunen_loeve.map(karhunen_loeve_result) }
    }
}

/// Checks that the scans can be filtered and returns warnings about them; `folder` is the folder of the study file. Computes the
/// statistics of the scans only if the random surfaces need their fractal dimension.
pub(super) fn check_scans(
    section: &SurfaceSection,
    request: &SurfaceRequest,
    folder: &Path,
) -> Result<Vec<String>, StudyError> {
    let scans = section.read_scans(folder)?;
    let (preparation, several) = (section.preparation(), scans.len() > 1);
    let mut warnings = Vec::new();
    for (file, mut scan) in scans {
        let mut own = mem::take(&mut scan.warnings);
        let map = HeightMap::try_from(scan).map_err(|error| StudyError::Map { file: file.clone(), error })?;
        let (missing, points) = (map.missing_points(), map.grid().points());
        if missing > 0 {
            own.push(format!("{missing} of {points} heights are missing"));
        }
        let checked = preparation.check(map.grid()).map_err(|error| SurfaceModelError::from(error).into());
        checked.map_err(|error| if several { of_one(&file, error) } else { error })?;
        warnings.extend(own.into_iter().map(|own| if several { format!("{file}: {own}") } else { own }));
    }
    if matches!(request, SurfaceRequest::WeierstrassMandelbrot { dimension: Measurable::Measured, .. }) {
        run(section, request, folder)?;
    }
    Ok(warnings)
}

/// Returns the error of one of several scans.
fn of_one(file: &str, error: StudyError) -> StudyError {
    match error {
        error @ StudyError::Map { .. } => error,
        error => StudyError::OneOf { file: file.into(), error: Box::new(error) },
    }
}

/// Runs the stage; `folder` is the folder of the study file.
pub(super) fn run(
    section: &SurfaceSection,
    request: &SurfaceRequest,
    folder: &Path,
) -> Result<SurfaceStage, StudyError> {
    let mut stage = without_tables(section, request, folder)?;
    if let Some(measured) = &stage.measured {
        let model = &stage.model.surface;
        stage.output.tables.extend(scan_tables(measured, model.covariance(), &model.marginal)?);
    }
    Ok(stage)
}

/// Runs the stage without the tables of the scan, which take most of its time.
pub(super) fn without_tables(
    section: &SurfaceSection,
    request: &SurfaceRequest,
    folder: &Path,
) -> Result<SurfaceStage, StudyError> {
    let mut output = StageOutput::default();
    let measured = measure_all(section, section.read_scans(folder)?, &mut output)?;
    let (model, selected) = model_of(section, request.clone(), measured.as_ref(), &mut output)?;
    let covariance = selected.as_ref().map(covariance_result);
    if let Some(measured) = &measured {
        let is_like_the_scan =
            section.covariance.is_of_the_scan() && section.marginal == "measured" && section.rms_height.is_none();
        if let Some(trial) = selected.and_then(|selected| selected.trial).filter(|_| is_like_the_scan) {
            output.warnings.extend(contact_warning(&measured.map, &trial.maps));
        }
    }
    let band_end_m = measured.as_ref().and_then(ScannedSurface::band_end_m);
    let model = CompositeModel { surface: model, counterface: None };
    Ok(SurfaceStage { model, measured, measured_counterface: None, band_end_m, covariance, output })
}

/// Makes the model of the random surfaces that a section requests and, if it has a covariance, reports its selection.
pub(super) fn model_of(
    section: &SurfaceSection,
    request: SurfaceRequest,
    measured: Option<&ScannedSurface>,
    output: &mut StageOutput,
) -> Result<(SurfaceModel, Option<SelectedCovariance>), StudyError> {
    let (model, selected) = SurfaceModel::new(request, measured)?;
    let part = measured.and_then(|m| m.part.as_ref());
    output.assumptions.push(model_sentence(section, &model, if part.is_some() { "the scans" } else { "the scan" }));
    if let Some(selected) = &selected {
        output.assumptions.extend(selected.reason.clone());
        output.warnings.extend(selected.warnings.iter().cloned());
    }
    Ok((model, selected))
}

/// Prepares and measures all scans; maps and series show the first.
fn measure_all(
    section: &SurfaceSection,
    scans: Vec<(String, Scan)>,
    output: &mut StageOutput,
) -> Result<Option<ScannedSurface>, StudyError> {
    if scans.len() < 2 {
        let one = scans.into_iter().next();
        return one.map(|(file, scan)| measure(section, &file, scan, output)).transpose();
    }
    let mut measured = Vec::with_capacity(scans.len());
    for (file, scan) in scans {
        let mut own = StageOutput::default();
        let scan = measure(section, &file, scan, &mut own).map_err(|error| of_one(&file, error))?;
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
    section: &SurfaceSection,
    file: &str,
    mut scan: Scan,
    output: &mut StageOutput,
) -> Result<ScannedSurface, StudyError> {
    output.warnings.append(&mut scan.warnings);
    let raw = HeightMap::try_from(scan).map_err(|error| StudyError::Map { file: file.into(), error })?;
    let preparation = section.preparation();
    let prepared = preparation.apply(&raw).map_err(SurfaceModelError::from)?;
    let map = &prepared.map;
    output.fields.push(("height_raw", QuantityMap { grid: raw.grid(), unit: "m", values: raw.heights_m().clone() }));
    output
        .fields
        .push(("height_levelled", QuantityMap { grid: map.grid(), unit: "m", values: map.heights_m().clone() }));
    let grid = map.grid();
    output.assumptions.push(format!(
        "The scan {file} {}. Its statistics hold for pixels of {} on a field of {}. {} of {} points are missing and stay \
         missing.",
        in_words(&preparation, &prepared),
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
        Level::Cylinder | Level::Sphere => format!(
            "was levelled by its least-squares {} of radius {}",
            preparation.level,
            sentence::si(prepared.radius_m.unwrap_or(f64::NAN), "m")
        ),
        Level::Plane | Level::Quadratic => format!("was levelled by its least-squares {}", preparation.level),
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

fn model_sentence(section: &SurfaceSection, model: &SurfaceModel, scans: &str) -> String {
    match &model.texture {
        Texture::WeierstrassMandelbrot { dimension } => format!(
            "Random surfaces are Weierstrass–Mandelbrot functions of fractal dimension {} ({}), wavenumber ratio {GAMMA} and \
             {RIDGES} ridges, from the longer side of a grid down to its pixels, scaled to the rms height {}. Their heights \
             are taken as normal; covariance and marginal distribution of the study have no effect.",
            sentence::digits(*dimension),
            if section.fractal_dimension.is_some() { "stated".into() } else { format!("measured on {scans}") },
            sentence::si(model.marginal.std(), "m"),
        ),
        Texture::Translated { covariance, translation, .. } => format!(
            "Random surfaces have {} of rms height {}. {} imposed by {} translation.",
            covariance_words(section, covariance, scans),
            sentence::si(covariance.std_m(), "m"),
            if section.marginal == "measured" {
                "The distribution of the measured heights is".to_owned()
            } else {
                format!("The marginal distribution `{}` is", section.marginal)
            },
            match translation {
                TranslationKind::Plain => "plain",
                TranslationKind::Corrected => "corrected",
            }
        ),
    }
}

/// Returns a description of a covariance.
fn covariance_words(section: &SurfaceSection, covariance: &SurfaceCovariance, scans: &str) -> String {
    let along = |x_m, y_m| format!("{} along x and {} along y", sentence::si(x_m, "m"), sentence::si(y_m, "m"));
    match covariance {
        SurfaceCovariance::Model(model) => {
            let (name, lengths) = match model.model() {
                CorrelationModel::Matern { .. } => ("Matérn", "scales"),
                CorrelationModel::SelfAffine { .. } => ("self-affine", "roll-off lengths"),
                CorrelationModel::Exponential => ("exponential", "lengths"),
                CorrelationModel::SquaredExponential => ("squared exponential", "lengths"),
            };
            let along = along(model.length_x_m(), model.length_y_m());
            match section.covariance {
                CovarianceSource::Measured => format!("a {name} covariance (fitted to {scans}, {lengths} {along})"),
                _ => format!("a {name} covariance (stated, {lengths} {along})"),
            }
        }
        SurfaceCovariance::Empirical(own) => {
            let report = own.report();
            format!(
                "the covariance of {scans} itself (lags up to {} as estimated, then tapered; to make it positive definite {} % of \
                 the variance was clipped and correlations changed by at most {})",
                along(report.reliable_x_m, report.reliable_y_m),
                sentence::digits(100.0 * report.clipped_variance),
                sentence::digits(report.clipping_change),
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::Covariance;

    #[test]
    fn the_lengths_of_a_model_are_named() {
        let words = |model| {
            let covariance = SurfaceCovariance::Model(Covariance::new(model, 1e-6, 2e-5, 3e-5).unwrap());
            covariance_words(&SurfaceSection::default(), &covariance, "the scan")
        };
        for (model, said) in [
            (CorrelationModel::Exponential, "lengths 20 µm along x"),
            (CorrelationModel::Matern { nu: 1.5 }, "scales 20 µm along x"),
            (CorrelationModel::SelfAffine { hurst: 0.7 }, "roll-off lengths 20 µm along x"),
        ] {
            assert!(words(model).contains(said), "{}", words(model));
        }
    }
}
