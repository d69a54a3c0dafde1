//! Surface stage: statistics of the scans, and the model of the random surfaces.

use std::mem;
use std::path::Path;

use crate::map::HeightMap;
use crate::pressure::ContactLikeness;
use crate::study::check::SurfaceStudy;
use crate::study::output::StageOutput;
use crate::study::profile::MeasuredProfile;
use crate::study::result::{
    CovarianceResult, KarhunenLoeveResult, MeasuredSurface, SurfaceResult, distribution_result,
};
use crate::study::scan_tables::scan_tables;
use crate::study::surface_model::model_of;
use crate::study::surface_result::{covariance_result, part_statistics, surface_statistics};
use crate::study::surface_scans::{measure_all, of_one};
use crate::study::{StudyError, sentence};
use crate::surface::model::{CompositeModel, CovarianceRequest, Measurable, SurfaceModelError, SurfaceRequest};
use crate::surface::scanned::ScannedSurface;

/// Model of the random surfaces, and the scans on which it is measured.
pub(super) struct SurfaceStage {
    /// Model of the surface, and of a rough counterface.
    pub(super) model: CompositeModel,
    pub(super) measured: Option<ScannedSurface>,
    /// Profile of a surface without lay.
    pub(super) profile: Option<MeasuredProfile>,
    /// Scans of a rough counterface.
    pub(super) measured_counterface: Option<ScannedSurface>,
    /// Shortest wavelength in metre at which the spectra of all scans are reliable.
    pub(super) band_end_m: Option<f64>,
    /// Whether the random surface stands for the scan: it has its covariance and rms height.
    pub(super) is_of_the_scan: bool,
    /// Whether the study states the shortest wave.
    pub(super) states_cut_off: bool,
    covariance: Option<CovarianceResult>,
    pub(super) output: StageOutput,
}

impl SurfaceStage {
    /// Returns the entry of `results.json`; `karhunen_loeve` is the expansion on the patches of the pressure stage.
    pub(super) fn result(&self, karhunen_loeve: Option<KarhunenLoeveResult>) -> SurfaceResult {
        let measured = match &self.measured {
            None => MeasuredSurface::Stated {},
            Some(ScannedSurface { part: Some(part), .. }) => {
                MeasuredSurface::Part(Box::new(part_statistics(&part.statistics)))
            }
            Some(scan) => MeasuredSurface::Scan(Box::new(surface_statistics(&scan.statistics))),
        };
        let (covariance, marginal) = (self.covariance.clone(), distribution_result(&self.model.surface.marginal));
        SurfaceResult { measured, covariance, marginal, karhunen_loeve }
    }
}

/// Checks that the scans can be filtered and returns warnings about them; `folder` is the folder of the study file. Computes the
/// statistics of the scans only if the random surfaces need their fractal dimension.
pub(super) fn check_scans(study: &SurfaceStudy, folder: &Path) -> Result<Vec<String>, StudyError> {
    let scans = study.read_scans(folder)?;
    let mut of_profile = StageOutput::default();
    if MeasuredProfile::of(study, &scans, &mut of_profile)?.is_some() {
        return Ok(of_profile.warnings);
    }
    let several = scans.len() > 1;
    let mut warnings = Vec::new();
    for (file, mut scan) in scans {
        let mut own = mem::take(&mut scan.warnings);
        let map = HeightMap::try_from(scan).map_err(|error| StudyError::Map { file: file.clone(), error })?;
        let (missing, points) = (map.missing_points(), map.grid().points());
        if missing > 0 {
            own.push(format!("{missing} of {points} heights are missing"));
        }
        let checked = study.preparation.check(map.grid()).map_err(|error| SurfaceModelError::from(error).into());
        checked.map_err(|error| if several { of_one(&file, error) } else { error })?;
        warnings.extend(own.into_iter().map(|own| if several { format!("{file}: {own}") } else { own }));
    }
    if matches!(study.request, SurfaceRequest::WeierstrassMandelbrot { dimension: Measurable::Measured, .. }) {
        run(study, folder)?;
    }
    Ok(warnings)
}

/// Runs the stage; `folder` is the folder of the study file.
pub(super) fn run(study: &SurfaceStudy, folder: &Path) -> Result<SurfaceStage, StudyError> {
    let mut stage = without_tables(study, folder)?;
    if let Some(measured) = &stage.measured {
        let model = &stage.model.surface;
        stage.output.tables.extend(scan_tables(measured, model.covariance(), &model.marginal)?);
    }
    Ok(stage)
}

/// Runs the stage without the tables of the scan, which take most of its time.
pub(super) fn without_tables(study: &SurfaceStudy, folder: &Path) -> Result<SurfaceStage, StudyError> {
    let mut output = StageOutput::default();
    let scans = study.read_scans(folder)?;
    let profile = MeasuredProfile::of(study, &scans, &mut output)?;
    let measured = if profile.is_some() { None } else { measure_all(&study.preparation, scans, &mut output)? };
    let (model, selected) =
        model_of(&study.request, study.stated_marginal.as_deref(), measured.as_ref(), profile.as_ref(), &mut output)?;
    let covariance = selected.as_ref().map(covariance_result);
    if let Some(measured) = &measured {
        let is_like_the_scan = matches!(
            study.request,
            SurfaceRequest::Translated {
                rms_height_m: Measurable::Measured,
                covariance: CovarianceRequest::Measured | CovarianceRequest::Empirical,
                marginal: Measurable::Measured,
                ..
            }
        );
        if let Some(trial) = selected.and_then(|selected| selected.trial).filter(|_| is_like_the_scan) {
            output.warnings.extend(warn_of_contact(&measured.map, &trial.maps));
        }
    }
    let band_end_m = measured.as_ref().and_then(ScannedSurface::band_end_m);
    let (is_of_the_scan, states_cut_off) = match study.request {
        SurfaceRequest::Translated {
            rms_height_m: Measurable::Measured,
            covariance: CovarianceRequest::Measured | CovarianceRequest::Empirical,
            shortest_wave_m,
            ..
        } => (measured.is_some(), shortest_wave_m.is_some()),
        _ => (false, true),
    };
    let model = CompositeModel { surface: model, counterface: None };
    Ok(SurfaceStage {
        model,
        measured,
        profile,
        measured_counterface: None,
        band_end_m,
        is_of_the_scan,
        states_cut_off,
        covariance,
        output,
    })
}

/// Returns a warning if random maps have another contact area than the scan under the same elastic mean pressure.
fn warn_of_contact(scan: &HeightMap, maps: &[HeightMap]) -> Option<String> {
    let found = ContactLikeness::new(scan, maps).filter(|found| !found.is_near())?;
    let [nx, ny] = found.points;
    let of_part =
        if scan.grid().shape() == (ny, nx) { String::new() } else { format!("a part of {nx} × {ny} points of ") };
    Some(format!(
        "pressed elastically as hard as {of_part}the scan, which touches on {} % of its area, random maps touch on {} times that area, \
         and mean contact pressures are off by about that factor: random maps have the scan's spectrum and heights, but not the shape of \
         its summits; a form of higher degree to remove (`level`), or the rejection of outliers, may help",
        sentence::digits(100.0 * found.fraction_of_scan),
        sentence::digits(found.ratio),
    ))
}
