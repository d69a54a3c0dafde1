//! The Gaussian correlation beneath a translated one.

use asperity_base::correlation::StationaryCovariance;
use asperity_base::law::{LawError, Marginal, translation::Translation};

/// The Gaussian correlation that a translation turns into that of `target`: ρ_G = T⁻¹(ρ_X).
///
/// ρ_G may fail to be a correlation function; generators then clip what is negative, and
/// [`Translated::correlation_report`](super::Translated::correlation_report) says what is left;
/// [`TranslationCorrection`](super::TranslationCorrection) leaves less of it. Targets below the least correlation of the
/// law are raised to it.
#[derive(Debug, Clone)]
pub struct Predistorted<C> {
    target: C,
    translation: Translation,
    least: f64,
}

impl<C: StationaryCovariance> Predistorted<C> {
    /// The correlation to give to a Gaussian field for heights of law `law` with the covariance `target`.
    ///
    /// # Errors
    /// A law with a parameter outside its range.
    pub fn new(target: C, marginal: &Marginal) -> Result<Self, LawError> {
        let translation = Translation::new(marginal)?;
        let least = translation.least_correlation();
        Ok(Self { target, translation, least })
    }

    /// The least correlation that heights of the law can have by translation; targets below it are not met.
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
        // A value that is not finite is found by the generators.
        self.translation.normal_correlation(wanted).unwrap_or(f64::NAN)
    }

    fn mirror_symmetric(&self) -> bool {
        self.target.mirror_symmetric()
    }
}
