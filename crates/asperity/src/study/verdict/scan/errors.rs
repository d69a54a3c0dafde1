//! Errors of the statistics of scans, and surfaces whose scans had them.

use crate::chaos::UncertainInput;
use crate::study::uncertain::Place;
use crate::surface::model::{SurfaceCovariance, SurfaceModel, SurfaceModelError, Variation};

/// Errors of ln Sq, ln Sdq and Ssk.
pub(in super::super) type StatisticErrors = [f64; 3];

/// Errors of the statistics of the surface and of the counterface.
pub(in super::super) type BodyErrors = [StatisticErrors; 2];

/// Quantities of a body that are measured on the scans and not stated.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Measured {
    pub(in super::super) rms_height: bool,
    pub(in super::super) covariance: bool,
    pub(in super::super) marginal: bool,
}

impl Measured {
    /// Returns a surface whose scan had statistics with these errors.
    ///
    /// # Errors
    /// No surface has these statistics.
    pub(in super::super) fn with_errors(
        self,
        surface: &SurfaceModel,
        [height, slope, skewness]: StatisticErrors,
    ) -> Result<SurfaceModel, SurfaceModelError> {
        let length_x_m = surface.covariance().map(SurfaceCovariance::length_x_m);
        surface.varied(&Variation {
            rms_height_m: self.rms_height.then(|| surface.marginal.std() * height.exp()),
            // Slopes are heights over lengths.
            correlation_length_m: length_x_m
                .filter(|_| self.covariance)
                .map(|length_m| length_m * (height - slope).exp()),
            skewness: None,
            skewness_change: self.marginal.then_some(skewness),
        })
    }
}

/// Uncertain values that stand for the errors of the scans, with the errors at one standard deviation.
#[derive(Debug, Clone, Default)]
pub(in super::super) struct ScanErrors {
    pub(in super::super) inputs: Vec<(Place, UncertainInput, BodyErrors)>,
}
