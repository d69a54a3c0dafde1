//! Covariance of random surfaces: a model of few parameters, or the covariance of the scan.

use std::convert::Infallible;
use std::f64::consts::FRAC_PI_2;

use asperity_base::correlation::{CorrelationModel, Covariance, MeasuredCovariance, StationaryCovariance};
use asperity_base::numeric::bisect;

use super::SurfaceModelError;

/// Covariance of a random surface, stated or measured on the scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CovarianceRequest {
    /// The model, or the covariance of the scan, that keeps the spectrum and the slopes of the scan.
    Measured,
    /// Covariance of the scan, made positive definite.
    Empirical,
    /// Stated model.
    Stated {
        /// Correlation model.
        model: CorrelationModel,
        /// Lengths of the model along x and y in metre.
        lengths_m: [f64; 2],
    },
}

/// Covariance of random surfaces.
#[derive(Debug, Clone)]
pub enum SurfaceCovariance {
    /// Function of few parameters.
    Model(Covariance),
    /// Covariance of the scan.
    Empirical(Box<MeasuredCovariance>),
}

impl SurfaceCovariance {
    /// Returns the length along x of a model, or the 1/e lag of a measured correlation, in metre.
    pub fn length_x_m(&self) -> f64 {
        match self {
            Self::Model(covariance) => covariance.length_x_m(),
            Self::Empirical(_) => self.decay_lengths_m()[0],
        }
    }

    /// Returns the lags along x and y at which the correlation is 1/e, in metre.
    pub fn decay_lengths_m(&self) -> [f64; 2] {
        /// Every model has fallen to 1/e within so many of its lengths ℓ: the smoothest Matérn model, e^{−r²/2}, at √2 of them, the
        /// self-affine one of H = 1 at 1.7.
        const FARTHEST: f64 = 2.0;
        let (x_m, y_m) = match self {
            Self::Model(covariance) => (FARTHEST * covariance.length_x_m(), FARTHEST * covariance.length_y_m()),
            Self::Empirical(covariance) => covariance.support_m(),
        };
        [
            decay_length_m(x_m, |lag_m| self.correlation(lag_m, 0.0)),
            decay_length_m(y_m, |lag_m| self.correlation(0.0, lag_m)),
        ]
    }

    /// Returns the power spectral density of profiles along x in m³, at q in rad/m.
    pub fn profile_psd_x_m3(&self, q_rad_per_m: f64) -> f64 {
        match self {
            Self::Model(covariance) => covariance.profile_psd_x_m3(q_rad_per_m),
            Self::Empirical(covariance) => covariance.profile_psd_x_m3(q_rad_per_m),
        }
    }

    /// Returns the power spectral density of profiles along y in m³, at q in rad/m.
    pub fn profile_psd_y_m3(&self, q_rad_per_m: f64) -> f64 {
        match self {
            Self::Model(covariance) => covariance.profile_psd_y_m3(q_rad_per_m),
            Self::Empirical(covariance) => covariance.profile_psd_y_m3(q_rad_per_m),
        }
    }

    /// Returns the two-dimensional power spectral density in m⁴, averaged over the directions, at each wavenumber in rad/m.
    pub fn radial_psd_m4(&self, q_rad_per_m: &[f64]) -> Vec<f64> {
        /// Directions over a quarter turn, by the symmetry of the models.
        const DIRECTIONS: usize = 90;

        match self {
            Self::Model(covariance) => {
                let angles = || (0..DIRECTIONS).map(|i| (i as f64 + 0.5) * FRAC_PI_2 / DIRECTIONS as f64);
                let density = |q: f64| angles().map(move |a| covariance.psd_m4(q * a.cos(), q * a.sin())).sum::<f64>();
                q_rad_per_m.iter().map(|q| density(*q) / DIRECTIONS as f64).collect()
            }
            Self::Empirical(covariance) => covariance.radial_psd_m4(q_rad_per_m),
        }
    }

    /// Returns whether the covariance is a product of one along x and one along y.
    pub(super) fn is_product(&self) -> bool {
        matches!(self, Self::Model(covariance) if covariance.model() == CorrelationModel::SquaredExponential)
    }

    /// Returns the covariance with another standard deviation and all lags multiplied by a factor.
    pub(super) fn stretched(&self, std_m: f64, factor: f64) -> Result<Self, SurfaceModelError> {
        Ok(match self {
            Self::Model(own) => {
                let (x_m, y_m) = (factor * own.length_x_m(), factor * own.length_y_m());
                Self::Model(Covariance::new(own.model(), std_m, x_m, y_m)?)
            }
            Self::Empirical(own) => Self::Empirical(Box::new((**own).clone().with_std(std_m).stretched(factor))),
        })
    }
}

impl StationaryCovariance for SurfaceCovariance {
    fn std_m(&self) -> f64 {
        match self {
            Self::Model(covariance) => covariance.std_m(),
            Self::Empirical(covariance) => covariance.std_m(),
        }
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        match self {
            Self::Model(covariance) => covariance.correlation(dx_m, dy_m),
            Self::Empirical(covariance) => covariance.correlation(dx_m, dy_m),
        }
    }

    fn mirror_symmetric(&self) -> bool {
        match self {
            Self::Model(covariance) => covariance.mirror_symmetric(),
            Self::Empirical(covariance) => covariance.mirror_symmetric(),
        }
    }
}

/// Returns the first lag at which a correlation that ends at `end_m` is 1/e.
fn decay_length_m(end_m: f64, correlation: impl Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 4096;
    let (level, step_m) = ((-1.0_f64).exp(), end_m / STEPS as f64);
    let after = (1..=STEPS).find(|&step| correlation(step as f64 * step_m) <= level).unwrap_or(STEPS);
    let (low_m, high_m) = ((after - 1) as f64 * step_m, after as f64 * step_m);
    let is_above = |lag_m| Ok::<_, Infallible>(correlation(lag_m) > level);
    let Ok([low_m, high_m]) = bisect(low_m, high_m, 1e-12 * end_m, is_above);
    0.5 * (low_m + high_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_decay_length_of_a_model_is_where_it_is_1_over_e() {
        let found = |model| {
            let covariance = SurfaceCovariance::Model(Covariance::new(model, 1e-6, 2e-5, 3e-5).unwrap());
            let [x_m, y_m] = covariance.decay_lengths_m();
            assert!((y_m / x_m - 1.5).abs() < 1e-9, "{model:?}");
            x_m / 2e-5
        };
        let exponential = [
            CorrelationModel::Exponential,
            CorrelationModel::SquaredExponential,
            CorrelationModel::Matern { nu: 0.5 },
            CorrelationModel::SelfAffine { hurst: 0.5 },
        ];
        for model in exponential {
            assert!((found(model) - 1.0).abs() < 1e-9, "{model:?}: {}", found(model));
        }
        // (1 + x) e^{−x} = 1/e at x = 2.146193 (Newton), x = √3 r.
        assert!((found(CorrelationModel::Matern { nu: 1.5 }) - 2.146_193_22 / 3.0_f64.sqrt()).abs() < 1e-8);
        // Ever smoother Matérn models tend to e^{−r²/2}; x K₁(x), of H = 1, is 1/e at 1.6.
        let smooth = found(CorrelationModel::Matern { nu: 60.0 });
        assert!((smooth - 2.0_f64.sqrt()).abs() < 0.01 && smooth < 2.0, "{smooth}");
        let rough = found(CorrelationModel::SelfAffine { hurst: 0.05 });
        let persistent = found(CorrelationModel::SelfAffine { hurst: 0.999 });
        assert!(0.0 < rough && rough < 0.2 && 1.5 < persistent && persistent < 1.8, "{rough} {persistent}");
    }
}
