//! Non-Gaussian surfaces by translation, z = F⁻¹(Φ(g)).

mod correction;
mod lags;
mod normal_to_marginal;
mod predistorted;
#[cfg(test)]
mod tests;

use ndarray::Array2;

use super::gaussian::map_of;
use super::{GaussianSurface, GeneratorError, RandomSurface};
use asperity_base::distribution::{DistributionError, Marginal};
use asperity_base::map::{Grid, HeightMap};

pub use correction::{CorrectedField, CorrectionReport, Feasibility, TranslationCorrection};
pub use predistorted::Predistorted;

use normal_to_marginal::NormalToMarginal;

/// Least pointwise variance, over the largest on the map, that may be scaled up to a full marginal distribution.
const LEAST_FRACTION: f64 = 1e-6;
/// Half width of the difference quotient for the slope of the map from normal heights.
const SLOPE_STEP: f64 = 1e-3;

/// Translated surface z(x) = F⁻¹(Φ(g(x)/σ_g(x))) whose heights have the distribution F at every point.
///
/// A truncated expansion has a pointwise variance below σ² that varies over the map. So the Gaussian field is divided
/// by its *own* standard deviation at each point. The marginal distribution is then exactly F everywhere, and the
/// truncation affects only the correlation.
///
/// *Plain* translation takes a Gaussian field with the wanted correlation; F⁻¹∘Φ then distorts it (towards zero). For
/// the *corrected* correlation, create the Gaussian field by [`TranslationCorrection`], or from another generator by
/// [`Predistorted`].
///
/// # References
/// Grigoriu, *J. Eng. Mech.* **110** (1984) 610, <https://doi.org/10.1061/(ASCE)0733-9399(1984)110:4(610)>.
#[derive(Debug, Clone)]
pub struct Translated<S> {
    gaussian: S,
    marginal: Marginal,
    map: NormalToMarginal,
    /// 1/σ_g at each point in row order; one value if all are equal.
    inverse_std_per_m: Vec<f64>,
    least_variance_fraction: f64,
}

/// Deviation of the correlation of a translated surface from a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TranslationReport {
    /// Largest |ρ − target| over all lags of up to half the map from its centre.
    pub largest_deviation: f64,
    /// Lag along x of that deviation in metre.
    pub lag_x_m: f64,
    /// Lag along y of that deviation in metre.
    pub lag_y_m: f64,
    /// Root mean square deviation over these lags.
    pub rms_deviation: f64,
}

impl<S: GaussianSurface> Translated<S> {
    /// Creates a surface whose heights have the distribution `marginal`, in metre.
    ///
    /// # Errors
    /// A distribution with a parameter outside its range, or a field that hardly varies at some point.
    pub fn new(gaussian: S, marginal: Marginal) -> Result<Self, TranslationError> {
        Self::scaled(gaussian, marginal, 0.0, 1.0)
    }

    /// Creates a surface whose heights have the shape of `marginal`, shifted to mean zero and scaled to `rms_height_m`.
    ///
    /// # Errors
    /// The errors of [`Translated::new`], and an rms height that is not positive.
    pub fn with_rms_height(gaussian: S, marginal: Marginal, rms_height_m: f64) -> Result<Self, TranslationError> {
        if !(rms_height_m > 0.0 && rms_height_m.is_finite()) {
            let parameter = "rms_height_m";
            return Err(GeneratorError::Parameter { parameter, value: rms_height_m, wanted: "positive" }.into());
        }
        marginal.check()?;
        let scale = rms_height_m / marginal.std();
        let offset = -scale * marginal.mean();
        Self::scaled(gaussian, marginal, offset, scale)
    }

    fn scaled(gaussian: S, marginal: Marginal, offset: f64, scale: f64) -> Result<Self, TranslationError> {
        marginal.check()?;
        let std = gaussian.pointwise_std_m();
        let largest = std.iter().fold(0.0_f64, |m, s| m.max(*s));
        let mut least_variance_fraction = 1.0_f64;
        for ((row, column), value) in std.indexed_iter() {
            let fraction = if largest > 0.0 { (value / largest).powi(2) } else { 0.0 };
            if fraction < LEAST_FRACTION {
                return Err(GeneratorError::NoVariance { row, column, fraction }.into());
            }
            least_variance_fraction = least_variance_fraction.min(fraction);
        }
        let map = NormalToMarginal::new(&marginal, offset, scale);
        let count = if std.iter().all(|s| *s == largest) { 1 } else { std.len() };
        let inverse_std_per_m = std.iter().take(count).map(|s| 1.0 / s).collect();
        Ok(Self { gaussian, marginal, map, inverse_std_per_m, least_variance_fraction })
    }

    /// Returns 1/σ_g at each point in row order.
    fn inverse_std_per_m(&self) -> impl Iterator<Item = f64> {
        self.inverse_std_per_m.iter().copied().cycle().take(self.gaussian.grid().points())
    }

    /// Translates a map of the Gaussian field.
    fn translate(&self, map: HeightMap) -> HeightMap {
        let mut heights = map.into_heights_m().into_raw_vec_and_offset().0;
        match self.inverse_std_per_m[..] {
            [inverse] => heights.iter_mut().for_each(|z| *z = self.map.value(*z * inverse)),
            _ => heights
                .iter_mut()
                .zip(&self.inverse_std_per_m)
                .for_each(|(z, inverse)| *z = self.map.value(*z * inverse)),
        }
        map_of(self.gaussian.grid(), heights)
    }

    /// Returns the underlying Gaussian field.
    pub fn gaussian(&self) -> &S {
        &self.gaussian
    }

    /// Returns the marginal distribution of the heights before shift and scale.
    pub fn marginal(&self) -> &Marginal {
        &self.marginal
    }

    /// Returns the least pointwise variance of the Gaussian field over its largest; 1 for a stationary field.
    pub fn least_variance_fraction(&self) -> f64 {
        self.least_variance_fraction
    }

    /// Returns the correlation of the translated heights with the height at (`row`, `column`), shape `[ny, nx]`,
    /// without sampling.
    #[cfg(test)]
    fn correlation_with(&self, row: usize, column: usize) -> Array2<f64> {
        let translation = asperity_base::distribution::translation::Translation::new(&self.marginal).unwrap();
        let mut correlation = self.gaussian.covariance_with_m2(row, column);
        let nx = self.gaussian.grid().nx();
        let inverse: Vec<f64> = self.inverse_std_per_m().collect();
        for (value, there) in correlation.iter_mut().zip(&inverse) {
            *value = translation.correlation((*value * inverse[row * nx + column] * there).clamp(-1.0, 1.0));
        }
        correlation
    }
}

impl<S: GaussianSurface> RandomSurface for Translated<S> {
    fn xi_len(&self) -> usize {
        self.gaussian.xi_len()
    }

    fn grid(&self) -> Grid {
        self.gaussian.grid()
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        self.translate(self.gaussian.generate(xi))
    }

    fn generate_from(&self, xi: Vec<f64>) -> HeightMap {
        self.translate(self.gaussian.generate_from(xi))
    }

    /// Every point has the same map from standardised normal heights, and so the same slope at zero.
    fn xi_response(&self, weights: &Array2<f64>) -> Option<Vec<f64>> {
        let mut normal = weights.clone();
        normal.iter_mut().zip(self.inverse_std_per_m()).for_each(|(weight, inverse)| *weight *= inverse);
        let mut response = self.gaussian.xi_response(&normal)?;
        let slope_m = (self.map.value(SLOPE_STEP) - self.map.value(-SLOPE_STEP)) / (2.0 * SLOPE_STEP);
        response.iter_mut().for_each(|value| *value *= slope_m);
        Some(response)
    }

    fn is_periodic_and_stationary(&self) -> bool {
        self.gaussian.is_periodic_and_stationary()
    }
}

/// Reason why a surface could not be translated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TranslationError {
    /// The marginal distribution is invalid.
    #[error(transparent)]
    Distribution(#[from] DistributionError),
    /// The Gaussian field cannot have this marginal distribution.
    #[error(transparent)]
    Generator(#[from] GeneratorError),
    /// The target is not a valid correlation at some lag.
    #[error(
        "the target correlation at the lag ({lag_x_m}, {lag_y_m}) m is {value}, but must be in [-1, 1], and 1 at zero"
    )]
    Target {
        /// Lag along x in metre.
        lag_x_m: f64,
        /// Lag along y in metre.
        lag_y_m: f64,
        /// Value found.
        value: f64,
    },
}
