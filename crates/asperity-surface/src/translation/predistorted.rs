//! Gaussian correlation whose translation is a given correlation.

use asperity_base::correlation::StationaryCovariance;
use asperity_base::distribution::{DistributionError, Marginal, translation::Translation};

/// Gaussian correlation that a translation converts into the correlation of `target`: ρ_G = T⁻¹(ρ_X).
///
/// ρ_G may fail to be a correlation function. Generators then clip its negative part, and the correlation of the
/// heights deviates from the target. [`TranslationCorrection`](super::TranslationCorrection) leaves a smaller
/// deviation. Targets below the least correlation of the distribution are raised to it.
#[derive(Debug, Clone)]
pub struct Predistorted<C> {
    target: C,
    translation: Translation,
    least: f64,
}

impl<C: StationaryCovariance> Predistorted<C> {
    /// Creates the correlation of a Gaussian field for heights of the distribution `marginal` with the covariance
    /// `target`.
    ///
    /// # Errors
    /// A distribution with a parameter outside its range.
    pub fn new(target: C, marginal: &Marginal) -> Result<Self, DistributionError> {
        let translation = Translation::new(marginal)?;
        let least = translation.least_correlation();
        Ok(Self { target, translation, least })
    }

    /// Returns the least correlation that heights of the distribution can have by translation; lower targets are not
    /// reached.
    pub fn least_correlation(&self) -> f64 {
        self.least
    }
}

impl<C: StationaryCovariance> StationaryCovariance for Predistorted<C> {
    fn std_m(&self) -> f64 {
        self.target.std_m()
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        let wanted = self.target.correlation(dx_m, dy_m).clamp(self.least, 1.0);
        // The generators detect a value that is not finite.
        self.translation.normal_correlation(wanted).unwrap_or(f64::NAN)
    }

    fn mirror_symmetric(&self) -> bool {
        self.target.mirror_symmetric()
    }
}
