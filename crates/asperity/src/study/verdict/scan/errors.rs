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

/// Changes of ln μ that stand for the errors of the scans, with the errors that change it by 1.
#[derive(Debug, Clone, Default)]
pub(in super::super) struct ScanErrors {
    pub(in super::super) inputs: Vec<(Place, UncertainInput, BodyErrors)>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::{CorrelationModel, Covariance};
    use crate::distribution::Marginal;
    use crate::surface::model::Texture;
    use crate::translation::TranslationKind;

    #[test]
    fn errors_change_measured_quantities_only() {
        let heights = (0..2000).map(|i| Marginal::STANDARD_NORMAL.quantile((f64::from(i) + 0.5) / 2000.0)).collect();
        let marginal = Marginal::empirical(heights).unwrap().standardised(0.0, 1e-6).unwrap();
        let covariance = Covariance::new(CorrelationModel::Exponential, 1e-6, 20e-6, 10e-6).unwrap();
        let texture = Texture::Translated {
            covariance: SurfaceCovariance::Model(covariance),
            translation: TranslationKind::Plain,
            expansion: None,
        };
        let surface = SurfaceModel { marginal, texture, shortest_wave_m: None };
        for [rms_height, covariance, marginal] in
            [[true, true, true], [true, false, false], [false, true, false], [false, false, true], [false; 3]]
        {
            let measured = Measured { rms_height, covariance, marginal };
            let found = measured.with_errors(&surface, [0.1, 0.3, 0.02]).unwrap();
            let std_m = if rms_height { 1e-6 * 0.1_f64.exp() } else { 1e-6 };
            assert!((found.marginal.std() / std_m - 1.0).abs() < 1e-9, "{measured:?}");
            // Rms slopes are proportional to rms heights over lengths.
            let length_m = if covariance { 20e-6 * (-0.2_f64).exp() } else { 20e-6 };
            assert!((found.covariance().unwrap().length_x_m() / length_m - 1.0).abs() < 1e-9, "{measured:?}");
            let skewness = if marginal { 0.02 } else { 0.0 };
            // The next term of the expansion is of the order of the square of the change.
            let difference = found.marginal.skewness() - skewness;
            assert!(difference.abs() <= 1e-9 + skewness * skewness, "{measured:?}: {difference}");
        }
    }
}
