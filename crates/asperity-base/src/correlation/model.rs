//! Stationary covariance models.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};
use statrs::function::gamma::ln_gamma;
use thiserror::Error;

use super::bessel::matern;

/// A rejected covariance.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CovarianceError {
    /// A parameter outside its range.
    #[error("{parameter} is {value}, but must be {wanted}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Rejected value.
        value: f64,
        /// Range of the parameter.
        wanted: &'static str,
    },
}

/// Shape ρ(r) of a stationary correlation at the scaled distance r = √((x/ℓx)² + (y/ℓy)²).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CorrelationModel {
    /// ρ = e^{−r²}.
    SquaredExponential,
    /// ρ = e^{−r}.
    Exponential,
    /// ρ = 2^{1−ν}/Γ(ν) (√(2ν) r)^ν K_ν(√(2ν) r).
    Matern {
        /// Smoothness ν > 0.
        nu: f64,
    },
    /// Self-affine with roll-off: power spectral density ∝ (1 + (q_x ℓx)² + (q_y ℓy)²)^{−(1+H)}, 0 < H < 1.
    ///
    /// In two dimensions this is the Matérn model of ν = H with ℓ in place of ℓ/√(2ν).
    SelfAffine {
        /// Hurst exponent H.
        hurst: f64,
    },
}

/// Argument x beyond which x^ν K_ν(x)/Γ(ν) is below the smallest number for every order ν up to 100, the largest allowed.
const VANISHED: f64 = 2000.0;

impl CorrelationModel {
    /// Returns the name as in study files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::SquaredExponential => "squared_exponential",
            Self::Exponential => "exponential",
            Self::Matern { .. } => "matern",
            Self::SelfAffine { .. } => "self_affine",
        }
    }

    /// Returns ρ(r) at the scaled distance r ≥ 0; 1 at r = 0.
    pub fn correlation(&self, r: f64) -> f64 {
        let Some((nu, corner)) = self.order_and_corner() else { return (-r * r).exp() };
        let x = corner.sqrt() * r;
        match nu {
            _ if x > VANISHED => 0.0,
            0.5 => (-x).exp(),
            1.5 => (1.0 + x) * (-x).exp(),
            2.5 => (1.0 + x + x * x / 3.0) * (-x).exp(),
            _ => matern(nu, x),
        }
    }

    /// Returns the order ν and squared corner κ² of a Matérn spectrum ∝ (κ² + k²)^{−(ν + d/2)}; `None` for the squared
    /// exponential.
    fn order_and_corner(&self) -> Option<(f64, f64)> {
        match *self {
            Self::SquaredExponential => None,
            Self::Exponential => Some((0.5, 1.0)),
            Self::Matern { nu } => Some((nu, 2.0 * nu)),
            Self::SelfAffine { hurst } => Some((hurst, 1.0)),
        }
    }

    /// Returns ∬ ρ(|x|) e^{−ik·x} d²x at the scaled wavenumber k.
    fn spectrum_2d(&self, k_squared: f64) -> f64 {
        match self.order_and_corner() {
            None => PI * (-k_squared / 4.0).exp(),
            Some((nu, corner)) => {
                let above = 1.0 + k_squared / corner;
                // Power −3/2 of exponential correlation.
                let power = if nu == 0.5 { 1.0 / (above * above.sqrt()) } else { above.powf(-(nu + 1.0)) };
                4.0 * PI * nu / corner * power
            }
        }
    }

    /// Returns ∫ ρ(|x|) e^{−ikx} dx at the scaled wavenumber k.
    fn spectrum_1d(&self, k: f64) -> f64 {
        match self.order_and_corner() {
            None => PI.sqrt() * (-k * k / 4.0).exp(),
            Some((nu, corner)) => {
                let gammas = (ln_gamma(nu + 0.5) - ln_gamma(nu)).exp();
                2.0 * PI.sqrt() * gammas / corner.sqrt() * (1.0 + k * k / corner).powf(-(nu + 0.5))
            }
        }
    }

    fn validate(&self) -> Result<(), CovarianceError> {
        match *self {
            // Largest order ν: above it a Matérn correlation cannot be distinguished from a squared exponential in
            // practice.
            Self::Matern { nu } if !(nu > 0.0 && nu <= 100.0) => {
                Err(CovarianceError::Parameter { parameter: "nu", value: nu, wanted: "in (0, 100]" })
            }
            Self::SelfAffine { hurst } if !(hurst > 0.0 && hurst < 1.0) => {
                Err(CovarianceError::Parameter { parameter: "hurst", value: hurst, wanted: "in (0, 1)" })
            }
            _ => Ok(()),
        }
    }
}

/// A stationary covariance of heights.
///
/// The interface that generators need; implemented by models, products of profile correlations and tables.
pub trait StationaryCovariance: Sync {
    /// Returns the standard deviation σ in metre.
    fn std_m(&self) -> f64;

    /// Returns the correlation ρ at the lag (dx, dy) in metre; 1 at zero, and ρ(−dx, −dy) = ρ(dx, dy).
    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64;

    /// Returns whether ρ(−dx, dy) = ρ(dx, dy), as for a texture along an axis. The lags of one quadrant then suffice,
    /// and modes are even or odd in x and in y. The default is `false`.
    fn mirror_symmetric(&self) -> bool {
        false
    }
}

impl<C: StationaryCovariance + ?Sized> StationaryCovariance for &C {
    fn std_m(&self) -> f64 {
        (**self).std_m()
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        (**self).correlation(dx_m, dy_m)
    }

    fn mirror_symmetric(&self) -> bool {
        (**self).mirror_symmetric()
    }
}

/// A stationary covariance C(x, y) = σ² ρ(r), r = √((x/ℓx)² + (y/ℓy)²).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct Covariance {
    model: CorrelationModel,
    std_m: f64,
    length_x_m: f64,
    length_y_m: f64,
}

/// Fields of a file before validation.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    model: CorrelationModel,
    std_m: f64,
    length_x_m: f64,
    length_y_m: f64,
}

impl TryFrom<Unchecked> for Covariance {
    type Error = CovarianceError;

    fn try_from(found: Unchecked) -> Result<Self, CovarianceError> {
        Self::new(found.model, found.std_m, found.length_x_m, found.length_y_m)
    }
}

impl Covariance {
    /// Creates a covariance of standard deviation σ and lengths ℓx, ℓy in metre.
    ///
    /// # Errors
    /// A standard deviation or length that is not positive and finite, ν outside (0, 100], or H outside (0, 1).
    pub fn new(model: CorrelationModel, std_m: f64, length_x_m: f64, length_y_m: f64) -> Result<Self, CovarianceError> {
        model.validate()?;
        for (parameter, value) in [("std_m", std_m), ("length_x_m", length_x_m), ("length_y_m", length_y_m)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(CovarianceError::Parameter { parameter, value, wanted: "positive and finite" });
            }
        }
        Ok(Self { model, std_m, length_x_m, length_y_m })
    }

    /// Creates a covariance with equal lengths along x and y.
    ///
    /// # Errors
    /// See [`Covariance::new`].
    pub fn isotropic(model: CorrelationModel, std_m: f64, length_m: f64) -> Result<Self, CovarianceError> {
        Self::new(model, std_m, length_m, length_m)
    }

    /// Returns the shape of the correlation.
    pub fn model(&self) -> CorrelationModel {
        self.model
    }

    /// Returns the standard deviation σ in metre.
    pub fn std_m(&self) -> f64 {
        self.std_m
    }

    /// Returns the length ℓx in metre.
    pub fn length_x_m(&self) -> f64 {
        self.length_x_m
    }

    /// Returns the length ℓy in metre.
    pub fn length_y_m(&self) -> f64 {
        self.length_y_m
    }

    /// Returns the correlation ρ at the lag (dx, dy) in metre.
    pub fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.model.correlation((dx_m / self.length_x_m).hypot(dy_m / self.length_y_m))
    }

    /// Returns the covariance C = σ²ρ at the lag (dx, dy) in metre, in m².
    pub fn value_m2(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.std_m * self.std_m * self.correlation(dx_m, dy_m)
    }

    /// Two-dimensional power spectral density P(q) = ∬ C e^{−iq·x} d²x in m⁴, at q in rad/m.
    pub fn psd_m4(&self, qx_rad_per_m: f64, qy_rad_per_m: f64) -> f64 {
        let k_squared = (qx_rad_per_m * self.length_x_m).powi(2) + (qy_rad_per_m * self.length_y_m).powi(2);
        self.std_m * self.std_m * self.length_x_m * self.length_y_m * self.model.spectrum_2d(k_squared)
    }

    /// Returns the power spectral density P₁(q) = ∫ C(x, 0) e^{−iqx} dx of profiles along x in m³, at q in rad/m.
    pub fn profile_psd_x_m3(&self, q_rad_per_m: f64) -> f64 {
        self.std_m * self.std_m * self.length_x_m * self.model.spectrum_1d(q_rad_per_m * self.length_x_m)
    }

    /// Returns the power spectral density of profiles along y in m³, at q in rad/m; see
    /// [`Covariance::profile_psd_x_m3`].
    pub fn profile_psd_y_m3(&self, q_rad_per_m: f64) -> f64 {
        self.std_m * self.std_m * self.length_y_m * self.model.spectrum_1d(q_rad_per_m * self.length_y_m)
    }
}

impl StationaryCovariance for Covariance {
    fn std_m(&self) -> f64 {
        self.std_m
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        Covariance::correlation(self, dx_m, dy_m)
    }

    fn mirror_symmetric(&self) -> bool {
        true
    }
}

/// The product C(x, y) = σ² ρ(|x|/ℓx) ρ(|y|/ℓy) of two profile correlations.
///
/// For the squared exponential it equals the elliptic covariance. Any other model changes: the exponential becomes
/// e^{−|x|/ℓx−|y|/ℓy}, which is anisotropic even for ℓx = ℓy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeparableCovariance(pub Covariance);

impl StationaryCovariance for SeparableCovariance {
    fn std_m(&self) -> f64 {
        self.0.std_m
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.0.correlation(dx_m, 0.0) * self.0.correlation(0.0, dy_m)
    }

    fn mirror_symmetric(&self) -> bool {
        true
    }
}

/// Covariance with rotated axes, for a texture at an angle.
///
/// ρ(x, y) = ρ₀(x cos α + y sin α, y cos α − x sin α): the first axis of the inner covariance points along (cos α, sin
/// α) of the map, with y down the rows. A rotation keeps a covariance positive definite, but a separable covariance is
/// in general no longer a product along the axes of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotated<C> {
    covariance: C,
    angle_rad: f64,
    sin: f64,
    cos: f64,
}

impl<C: StationaryCovariance> Rotated<C> {
    /// Creates the covariance rotated by the angle α in radian, from x towards y.
    ///
    /// # Errors
    /// An angle that is not finite.
    pub fn new(covariance: C, angle_rad: f64) -> Result<Self, CovarianceError> {
        if !angle_rad.is_finite() {
            let (parameter, wanted) = ("angle_rad", "finite");
            return Err(CovarianceError::Parameter { parameter, value: angle_rad, wanted });
        }
        let (sin, cos) = angle_rad.sin_cos();
        Ok(Self { covariance, angle_rad, sin, cos })
    }

    /// Returns the angle in radian.
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// Returns the inner covariance.
    pub fn inner(&self) -> &C {
        &self.covariance
    }
}

impl<C: StationaryCovariance> StationaryCovariance for Rotated<C> {
    fn std_m(&self) -> f64 {
        self.covariance.std_m()
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.covariance.correlation(dx_m * self.cos + dy_m * self.sin, dy_m * self.cos - dx_m * self.sin)
    }

    fn mirror_symmetric(&self) -> bool {
        // A quarter turn exchanges the axes; the computed cosine of 6e-17 is a rounding error.
        self.covariance.mirror_symmetric() && (self.sin * self.cos).abs() < 1e-15
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODELS: [CorrelationModel; 6] = [
        CorrelationModel::SquaredExponential,
        CorrelationModel::Exponential,
        CorrelationModel::Matern { nu: 1.3 },
        CorrelationModel::Matern { nu: 2.5 },
        CorrelationModel::SelfAffine { hurst: 0.8 },
        CorrelationModel::SelfAffine { hurst: 0.3 },
    ];

    #[test]
    fn the_matern_model_of_half_integer_order_is_elementary() {
        for r in [0.0_f64, 1e-6, 0.2, 1.0, 3.0, 12.0] {
            let exact = [
                (0.5, (-r).exp()),
                (1.5, (1.0 + 3_f64.sqrt() * r) * (-(3_f64.sqrt()) * r).exp()),
                (2.5, (1.0 + 5_f64.sqrt() * r + 5.0 / 3.0 * r * r) * (-(5_f64.sqrt()) * r).exp()),
            ];
            for (nu, value) in exact {
                // Through the closed form, and through the Bessel function.
                assert!((CorrelationModel::Matern { nu }.correlation(r) - value).abs() < 1e-14);
                assert!((matern(nu, (2.0 * nu).sqrt() * r) - value).abs() < 2e-13, "nu {nu} r {r}");
            }
        }
    }

    #[test]
    fn correlations_vanish_at_any_large_distance() {
        for model in
            MODELS.into_iter().chain([1e-320, 1e-9, 1.5, 2.5, 60.0, 100.0].map(|nu| CorrelationModel::Matern { nu }))
        {
            let mut last = 1.0;
            for r in [5e-324, 1e-100, 1e-3, 1.0, 30.0, 900.0, 2000.0, 1e9, 4e64, 1e200, f64::MAX, f64::INFINITY] {
                let value = model.correlation(r);
                assert!((0.0..=last + 1e-12).contains(&value), "{model:?} at {r}: {value} after {last}");
                last = value;
            }
            assert_eq!(last, 0.0, "{model:?}");
        }
    }

    #[test]
    fn a_very_smooth_matern_field_is_nearly_a_squared_exponential() {
        // ρ → e^{−r²/2} with a deviation of order 1/ν.
        for r in [0.1_f64, 0.5, 1.0, 2.0] {
            let difference = CorrelationModel::Matern { nu: 100.0 }.correlation(r) - (-r * r / 2.0).exp();
            assert!(difference.abs() < 0.01, "r {r}: {difference}");
        }
    }

    #[test]
    fn self_affine_is_matern_with_another_length() {
        let hurst = 0.7_f64;
        let rough = Covariance::new(CorrelationModel::SelfAffine { hurst }, 1.0, 2.0, 3.0).unwrap();
        let scale = (2.0 * hurst).sqrt();
        let matern = Covariance::new(CorrelationModel::Matern { nu: hurst }, 1.0, 2.0 * scale, 3.0 * scale).unwrap();
        for (x, y) in [(0.0, 0.1), (1.0, 2.0), (5.0, 1.0)] {
            assert!((rough.value_m2(x, y) - matern.value_m2(x, y)).abs() < 1e-13);
            assert!((rough.psd_m4(x, y) / matern.psd_m4(x, y) - 1.0).abs() < 1e-12);
        }
        let slope = (rough.psd_m4(2e4, 0.0) / rough.psd_m4(1e4, 0.0)).log2();
        assert!((slope + 2.0 * (1.0 + hurst)).abs() < 1e-6, "spectral slope {slope}");
    }

    /// Returns ∫₀^∞ f(u) du by the trapezoidal rule after u = e^{s − e^{−s}}, for smooth f with an algebraic or faster
    /// tail.
    fn half_line(f: impl Fn(f64) -> f64) -> f64 {
        let step = 1.0 / 64.0;
        (-320..3200)
            .map(|i| {
                let s = i as f64 * step;
                let u = (s - (-s).exp()).exp();
                let term = f(u) * u * (1.0 + (-s).exp());
                if term.is_finite() { term * step } else { 0.0 }
            })
            .sum()
    }

    #[test]
    fn the_spectrum_integrates_to_the_variance_and_at_zero_to_the_integral_of_the_covariance() {
        for model in MODELS {
            // Elliptic: integrate over scaled wavevectors, d²q = 2π k dk/(ℓxℓy).
            let covariance = Covariance::new(model, 3.0, 2.0, 0.5).unwrap();
            let variance = half_line(|k| covariance.psd_m4(k / 2.0, 0.0) * k) / (2.0 * PI) / (2.0 * 0.5);
            assert!((variance / 9.0 - 1.0).abs() < 1e-9, "{model:?}: {variance}");
            let integral = half_line(|r| covariance.value_m2(2.0 * r, 0.0) * 2.0 * PI * r) * 2.0 * 0.5;
            assert!((integral / covariance.psd_m4(0.0, 0.0) - 1.0).abs() < 1e-9, "{model:?}: {integral}");
            // The profile: its variance and its integral.
            let variance = half_line(|q| covariance.profile_psd_x_m3(q)) / PI;
            assert!((variance / 9.0 - 1.0).abs() < 1e-9, "{model:?}: {variance}");
            let integral = 2.0 * half_line(|y| covariance.value_m2(0.0, y));
            assert!((integral / covariance.profile_psd_y_m3(0.0) - 1.0).abs() < 1e-9, "{model:?}: {integral}");
        }
    }

    #[test]
    fn the_profile_spectrum_is_the_marginal_of_the_two_dimensional_one() {
        for model in MODELS {
            let covariance = Covariance::new(model, 1.0, 1.5, 0.7).unwrap();
            for q in [0.0, 0.4, 3.0] {
                let marginal = half_line(|qy| covariance.psd_m4(q, qy)) / PI;
                assert!((marginal / covariance.profile_psd_x_m3(q) - 1.0).abs() < 1e-8, "{model:?} at {q}");
            }
        }
    }

    #[test]
    fn bad_parameters_are_refused_also_in_a_file() {
        assert!(Covariance::isotropic(CorrelationModel::Exponential, 1.0, 0.0).is_err());
        assert!(Covariance::isotropic(CorrelationModel::Exponential, f64::NAN, 1.0).is_err());
        assert!(Covariance::isotropic(CorrelationModel::SelfAffine { hurst: 1.0 }, 1.0, 1.0).is_err());
        assert!(Covariance::isotropic(CorrelationModel::Matern { nu: -0.5 }, 1.0, 1.0).is_err());
        let good = r#"{"model":{"matern":{"nu":1.5}},"std_m":1e-6,"length_x_m":2e-5,"length_y_m":2e-5}"#;
        let covariance: Covariance = serde_json::from_str(good).unwrap();
        assert_eq!(
            serde_json::to_string(&covariance).unwrap().parse::<serde_json::Value>().unwrap(),
            good.parse::<serde_json::Value>().unwrap()
        );
        assert!(serde_json::from_str::<Covariance>(&good.replace("2e-5", "-2e-5")).is_err());
    }
}
