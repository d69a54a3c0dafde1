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

/// Profile with what it tells of the surface.
pub(super) struct MeasuredProfile {
    pub(super) statistics: ProfileStatistics,
    pub(super) covariance: Covariance,
    marginal: Marginal,
}

impl MeasuredProfile {
    /// Measures the profile of a study that states its surface to be isotropic; `None` for scans, and for profiles of other surfaces,
    /// which are refused as maps. Adds sentences and warnings.
    ///
    /// # Errors
    /// The profile cannot be prepared, is flat, or has no covariance.
    pub(super) fn of(
        study: &SurfaceStudy,
        scans: &[(String, Scan)],
        output: &mut StageOutput,
    ) -> Result<Option<Self>, StudyError> {
        let [(file, scan)] = scans else { return Ok(None) };
        if !scan.is_profile() || !study.isotropic {
            return Ok(None);
        }
        output.warnings.extend(scan.warnings.iter().cloned());
        let profile = profile_of(scan.clone()).map_err(|error| StudyError::Map { file: file.clone(), error })?;
        let prepared = profile.prepare(&study.preparation).map_err(SurfaceModelError::from)?;
        let statistics = ProfileStatistics::new(prepared)?;
        let fits = statistics.isotropic_covariance(CorrelationFamily::ALL).map_err(SurfaceModelError::from)?;
        let covariance = fits.best();
        let marginal = statistics.marginal()?;
        output.warnings.extend(fits.warnings.iter().map(|warning| format!("covariance fit: {warning}")));
        let (points, missing) = (statistics.prepared.profile.heights_m().len(), statistics.missing);
        let length = |length_m: f64| sentence::si(length_m, "m");
        output.assumptions.push(format!(
            "The profile {file} of {points} points ({missing} missing) over {} stands for a surface without lay, as stated: its correlation \
             along the line is that in all directions. The {} model was fitted to its spectrum by likelihood; it meets the spectral \
             density to {} % rms.",
            length(statistics.prepared.profile.length_m()),
            covariance.model().name(),
            sentence::digits(100.0 * fits.fits[0].misfit.exp_m1()),
        ));
        output.warnings.push(format!(
            "a profile cannot show a lay, nor the summits of the surface beside its line: friction rests on the model alone, of waves down to \
             {}; no scan was pressed to check it",
            length(statistics.shortest_wave_m())
        ));
        Ok(Some(Self { statistics, covariance, marginal }))
    }

    /// Returns a request that states what it would measure.
    pub(super) fn state(&self, request: SurfaceRequest) -> SurfaceRequest {
        let height = |stated: Measurable<f64>| match stated {
            Measurable::Measured => Measurable::Stated(self.statistics.rq_m),
            stated @ Measurable::Stated(_) => stated,
        };
        match request {
            SurfaceRequest::Translated {
                rms_height_m,
                covariance,
                families,
                marginal,
                shortest_wave_m,
                translation,
                expansion,
            } => {
                let (model, length_m) = (self.covariance.model(), self.covariance.length_x_m());
                let is_measured = covariance == CovarianceRequest::Measured;
                SurfaceRequest::Translated {
                    rms_height_m: height(rms_height_m),
                    covariance: match covariance {
                        CovarianceRequest::Measured => CovarianceRequest::Stated { model, lengths_m: [length_m; 2] },
                        other => other,
                    },
                    families,
                    marginal: match marginal {
                        Measurable::Measured => Measurable::Stated(self.marginal.clone()),
                        stated @ Measurable::Stated(_) => stated,
                    },
                    shortest_wave_m: shortest_wave_m.or_else(|| is_measured.then(|| self.statistics.shortest_wave_m())),
                    translation,
                    expansion,
                }
            }
            SurfaceRequest::WeierstrassMandelbrot { rms_height_m, dimension } => {
                SurfaceRequest::WeierstrassMandelbrot { rms_height_m: height(rms_height_m), dimension }
            }
        }
    }
}
