//! Profile of a surface without lay: the heights, spectrum and distribution that a study takes from it.

use asperity_formats::Scan;

use crate::correlation::{CorrelationFamily, Covariance};
use crate::distribution::Marginal;
use crate::map::MapError;
use crate::study::check::SurfaceStudy;
use crate::study::output::StageOutput;
use crate::study::{StudyError, sentence};
use crate::surface::model::{CovarianceRequest, Measurable, SurfaceModelError, SurfaceRequest};
use crate::surface::profile::{Profile, ProfileStatistics};

/// Returns the profile that a file holds.
///
/// # Errors
/// No distance between points, or fewer than two points.
pub fn profile_of(scan: Scan) -> Result<Profile, MapError> {
    let (step_m, _) = scan.pitch_m.ok_or(MapError::NoPitch)?;
    Profile::new(&scan.heights_m.into_iter().collect::<Vec<f64>>(), step_m)
}

/// Statistics of a profile, and the model and distribution of the surface that were fitted to it.
pub(super) struct MeasuredProfile {
    pub(super) statistics: ProfileStatistics,
    /// Fitted model; `None` if the study states another texture.
    covariance: Option<Covariance>,
    marginal: Marginal,
    /// Length in metre of the shortest wave of the random surfaces: the one that the study states, or the shortest that the profile resolves.
    pub(super) shortest_wave_m: f64,
}

impl MeasuredProfile {
    /// Measures the profile of a study that states its surface to be isotropic; `None` for scans, and for profiles of other surfaces,
    /// which are refused as maps. Adds sentences and warnings.
    ///
    /// # Errors
    /// The profile cannot be prepared, is flat, or lacks what the study would measure on it.
    pub(super) fn of(
        study: &SurfaceStudy,
        scans: &[(String, Scan)],
        output: &mut StageOutput,
    ) -> Result<Option<Self>, StudyError> {
        let [(file, scan)] = scans else { return Ok(None) };
        if !scan.is_profile() || !study.isotropic {
            return Ok(None);
        }
        let missing = |quantity| Err(SurfaceModelError::NoScan(quantity).into());
        let (is_measured, stated_wave_m) = match &study.request {
            SurfaceRequest::Translated { covariance: CovarianceRequest::Empirical, .. } => {
                return missing("the covariance in all directions");
            }
            SurfaceRequest::WeierstrassMandelbrot { dimension: Measurable::Measured, .. } => {
                return missing("the fractal dimension");
            }
            SurfaceRequest::Translated { covariance, shortest_wave_m, .. } => {
                (*covariance == CovarianceRequest::Measured, *shortest_wave_m)
            }
            SurfaceRequest::WeierstrassMandelbrot { .. } => (false, None),
        };
        output.warnings.extend(scan.warnings.iter().cloned());
        let profile = profile_of(scan.clone()).map_err(|error| StudyError::Map { file: file.clone(), error })?;
        let prepared = profile.prepare(&study.preparation).map_err(SurfaceModelError::from)?;
        let statistics = ProfileStatistics::new(prepared)?;
        let length = |length_m: f64| sentence::si(length_m, "m");
        let mut text = format!(
            "The profile {file} of {} points ({} missing) over {} stands for a surface without lay, as stated: its correlation along the line \
             is that in all directions.",
            statistics.prepared.profile.heights_m().len(),
            statistics.missing,
            length(statistics.prepared.profile.length_m()),
        );
        let mut covariance = None;
        if is_measured {
            let fits = statistics.isotropic_covariance(CorrelationFamily::ALL).map_err(SurfaceModelError::from)?;
            output.warnings.extend(fits.warnings.iter().map(|warning| format!("covariance fit: {warning}")));
            let (best, misfit) = (fits.best(), sentence::digits(100.0 * fits.fits[0].misfit.exp_m1()));
            let name = best.model().name();
            text += &format!(
                " The {name} model was fitted to its spectrum by likelihood; it meets the spectral density to {misfit} % rms."
            );
            covariance = Some(best);
        }
        output.assumptions.push(text);
        let shortest_wave_m = stated_wave_m.unwrap_or_else(|| statistics.shortest_wave_m());
        output.warnings.push(format!(
            "a profile cannot show a lay, nor the summits of the surface beside its line: friction rests on the model alone, of waves down to \
             {}; no scan was pressed to check it, and intervals leave out shorter waves and these differences",
            length(shortest_wave_m)
        ));
        let marginal = statistics.marginal()?;
        Ok(Some(Self { statistics, covariance, marginal, shortest_wave_m }))
    }

    /// Returns a request that states what it would measure.
    pub(super) fn state(&self, mut request: SurfaceRequest) -> SurfaceRequest {
        match &mut request {
            SurfaceRequest::Translated { rms_height_m, covariance, marginal, shortest_wave_m, .. } => {
                if let Some(own) = self.covariance {
                    *covariance = CovarianceRequest::Stated { model: own.model(), lengths_m: [own.length_x_m(); 2] };
                    *shortest_wave_m = Some(self.shortest_wave_m);
                }
                rms_height_m.state(self.statistics.rq_m);
                marginal.state(self.marginal.clone());
            }
            SurfaceRequest::WeierstrassMandelbrot { rms_height_m, .. } => rms_height_m.state(self.statistics.rq_m),
        }
        request
    }
}
