//! Requests for a random surface, and the model that meets them.

use asperity_base::correlation::CorrelationFamily;
use asperity_base::distribution::Marginal;
use asperity_base::map::HEIGHT_RANGE_M;
use asperity_base::translation::TranslationKind;

use super::covariance::CovarianceRequest;
use super::selection::{SelectedCovariance, select};
use super::{SurfaceModel, SurfaceModelError, Texture, TruncatedExpansion};
use crate::GeneratorError;
use crate::scanned::ScannedSurface;

/// Quantity that is stated or measured on the scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measurable<T> {
    /// Measured on the scan.
    Measured,
    /// Stated value.
    Stated(T),
}

/// Request for a random surface.
#[derive(Debug, Clone, PartialEq)]
pub enum SurfaceRequest {
    /// Translated Gaussian field.
    Translated {
        /// Root-mean-square height in metre.
        rms_height_m: Measurable<f64>,
        /// Covariance.
        covariance: CovarianceRequest,
        /// Covariance models that are fitted to the scan. With fewer than [`CorrelationFamily::ALL`], a measured covariance is the
        /// best of them.
        families: Vec<CorrelationFamily>,
        /// Marginal distribution; its mean and standard deviation are replaced.
        marginal: Measurable<Marginal>,
        /// Length of the shortest wave in metre; `None` for the shortest that the scan resolves, or that the grid has.
        shortest_wave_m: Option<f64>,
        /// Kind of translation.
        translation: TranslationKind,
        /// Karhunen–Loève expansion of patches; `None` uses all Fourier modes.
        expansion: Option<TruncatedExpansion>,
    },
    /// Weierstrass–Mandelbrot function. Its heights are nearly normal, because it is a sum of cosines of random phase.
    WeierstrassMandelbrot {
        /// Root-mean-square height in metre.
        rms_height_m: Measurable<f64>,
        /// Fractal dimension, between 2 and 3.
        dimension: Measurable<f64>,
    },
}

impl<T> Measurable<T> {
    /// States a value that was to be measured; keeps a stated one.
    pub fn state(&mut self, value: T) {
        if let Self::Measured = self {
            *self = Self::Stated(value);
        }
    }

    /// Returns the stated value, or measures it.
    fn or_measure(self, measure: impl FnOnce() -> Result<T, SurfaceModelError>) -> Result<T, SurfaceModelError> {
        match self {
            Self::Measured => measure(),
            Self::Stated(value) => Ok(value),
        }
    }
}

impl SurfaceModel {
    /// Makes the model that a request describes and, for a translated field, reports the selection of its covariance.
    ///
    /// # Errors
    /// A quantity is to be measured without a scan, the scan has no such quantity, a stated quantity is invalid, or the rms height is
    /// outside [`HEIGHT_RANGE_M`].
    pub fn new(
        request: SurfaceRequest,
        scan: Option<&ScannedSurface>,
    ) -> Result<(Self, Option<SelectedCovariance>), SurfaceModelError> {
        let needed = |quantity| scan.ok_or(SurfaceModelError::NoScan(quantity));
        let of_scan = || Ok(needed("the rms height")?.sq_m());
        let rms_m = |stated: Measurable<f64>| match stated.or_measure(of_scan)? {
            value if HEIGHT_RANGE_M.contains(&value) => Ok(value),
            value => {
                let (parameter, wanted) = ("rms height in metre", "between 1e-50 and 1e50");
                Err(SurfaceModelError::from(GeneratorError::Parameter { parameter, value, wanted }))
            }
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
                let std_m = rms_m(rms_height_m)?;
                let heights = || Ok(needed("the marginal distribution")?.marginal()?);
                let marginal = marginal.or_measure(heights)?.standardised(0.0, std_m)?;
                let selected = select(covariance, translation, &families, (&marginal, std_m), scan)?;
                let texture = Texture::Translated { covariance: selected.covariance.clone(), translation, expansion };
                let shortest_wave_m = shortest_wave_m.or(selected.shortest_wave_m);
                Ok((Self { marginal, texture, shortest_wave_m }, Some(selected)))
            }
            SurfaceRequest::WeierstrassMandelbrot { rms_height_m, dimension } => {
                let own =
                    || scan.and_then(ScannedSurface::fractal_dimension).ok_or(SurfaceModelError::FractalDimension);
                let dimension = dimension.or_measure(own)?;
                let marginal = Marginal::normal(0.0, rms_m(rms_height_m)?)?;
                let texture = Texture::WeierstrassMandelbrot { dimension };
                Ok((Self { marginal, texture, shortest_wave_m: None }, None))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::SurfaceModelError;

    #[test]
    fn an_rms_height_whose_variance_cannot_be_represented_is_refused() {
        let of = |rms_height_m| {
            let request = SurfaceRequest::WeierstrassMandelbrot {
                rms_height_m: Measurable::Stated(rms_height_m),
                dimension: Measurable::Stated(2.5),
            };
            SurfaceModel::new(request, None)
        };
        assert!(of(1e-50).is_ok() && of(1e50).is_ok());
        for rms_height_m in [0.0, -1e-6, 1e-310, 1e-200, 1e51, f64::INFINITY, f64::NAN] {
            let error = of(rms_height_m).map(drop);
            assert!(matches!(error, Err(SurfaceModelError::Generator(_))), "{rms_height_m}: {error:?}");
        }
    }
}
