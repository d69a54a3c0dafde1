//! Shapes of the correlation of a friction process.

use std::convert::Infallible;

use serde::{Deserialize, Serialize};

use super::{ProcessError, positive};
use asperity_base::correlation::{CorrelationModel, RecordModel, windowed_exponential};
use asperity_base::distribution::standard_normal_quantile;
use asperity_base::numeric::bisect;
use asperity_base::stats::student_quantile;

/// Largest order of a Matérn correlation. Above it the correlation is indistinguishable from a squared exponential in a
/// record.
const LARGEST_NU: f64 = 100.0;
/// Largest number of doublings of the end of a bracket.
const DOUBLINGS: usize = 200;

/// Shape of the correlation ρ(s) of a process, without its length ℓ.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CorrelationShape {
    /// e^{−s/ℓ}.
    #[default]
    Exponential,
    /// e^{−(s/ℓ)²}.
    SquaredExponential,
    /// Matérn correlation of smoothness ν with argument √(2ν) s/ℓ; ν = ½ is the exponential.
    Matern {
        /// Smoothness ν in (0, 100].
        nu: f64,
    },
    /// Moving average over a window W of an exponential of length ℓ ([`windowed_exponential`]); for ℓ = 0 it is the
    /// triangle of the window.
    WindowedExponential {
        /// Window W, in the unit of the sliding distance.
        window: f64,
    },
}

impl CorrelationShape {
    /// Returns the shape of a family fitted to records.
    pub fn from_record_model(model: RecordModel) -> Self {
        match model {
            RecordModel::Exponential => Self::Exponential,
            RecordModel::Smooth => Self::Matern { nu: RecordModel::SMOOTHNESS },
        }
    }

    /// Returns the name used in files: `exponential`, `squared_exponential`, `matern`, `windowed_exponential`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Exponential => "exponential",
            Self::SquaredExponential => "squared_exponential",
            Self::Matern { .. } => "matern",
            Self::WindowedExponential { .. } => "windowed_exponential",
        }
    }

    /// Returns the correlation at a lag, for the length ℓ in the same unit.
    ///
    /// # Panics
    /// Panics with a window if window or length is negative, or if both are zero.
    pub fn correlation(&self, lag: f64, length: f64) -> f64 {
        let r = lag.abs() / length;
        match *self {
            Self::Exponential => (-r).exp(),
            Self::SquaredExponential => CorrelationModel::SquaredExponential.correlation(r),
            Self::Matern { nu } => CorrelationModel::Matern { nu }.correlation(r),
            Self::WindowedExponential { window } => windowed_exponential(lag, window, length),
        }
    }

    /// Returns the same shape with lags in another unit, `unit` in the present one.
    #[must_use]
    pub fn in_unit(self, unit: f64) -> Self {
        match self {
            Self::WindowedExponential { window } => Self::WindowedExponential { window: window / unit },
            other => other,
        }
    }

    /// Fails if the shape is invalid, or if `length` is: it must be positive, or zero with a window.
    pub(super) fn check(&self, length: f64) -> Result<(), ProcessError> {
        match *self {
            Self::Matern { nu } if !(nu > 0.0 && nu <= LARGEST_NU) => {
                let parameter = "smoothness of the correlation";
                return Err(ProcessError::Parameter { parameter, value: nu, wanted: "in (0, 100]" });
            }
            Self::WindowedExponential { window } => {
                positive("window of the correlation", window)?;
                if length == 0.0 {
                    return Ok(());
                }
            }
            _ => {}
        }
        positive("correlation length", length)
    }

    /// Returns whether the shape is e^{−s/ℓ}.
    pub(super) fn is_exponential(&self) -> bool {
        matches!(self, Self::Exponential | Self::Matern { nu: 0.5 })
    }

    /// Returns whether a normal process of this shape is an Ornstein–Uhlenbeck process or its moving average.
    pub(super) fn has_recursion(&self) -> bool {
        self.is_exponential() || matches!(self, Self::WindowedExponential { .. })
    }

    /// Returns the lag at which the correlation is 1/e.
    pub fn decay_length(&self, length: f64) -> f64 {
        match *self {
            Self::Exponential | Self::SquaredExponential | Self::Matern { nu: 0.5 } => length,
            Self::Matern { .. } | Self::WindowedExponential { .. } => {
                let start = match *self {
                    Self::WindowedExponential { window } => window + length,
                    _ => length,
                };
                rising_root(start, |lag| (-1.0_f64).exp() - self.correlation(lag, length))
            }
        }
    }

    /// Returns the length for which the correlation at `lag` is `wanted`, which must be at least the correlation for
    /// `length`.
    pub(super) fn longer(&self, length: f64, lag: f64, wanted: f64) -> f64 {
        match *self {
            Self::Exponential | Self::Matern { nu: 0.5 } => -lag / wanted.ln(),
            Self::SquaredExponential => lag / (-wanted.ln()).sqrt(),
            Self::Matern { .. } | Self::WindowedExponential { .. } => {
                rising_root(length.max(lag), |length| self.correlation(lag, length) - wanted)
            }
        }
    }

    /// Returns the frequency times ℓ below which the fraction `probability` of the spectrum of positive frequencies
    /// lies; `None` with a window, whose spectrum has no such closed form.
    pub(super) fn spectral_quantile(&self, probability: f64) -> Option<f64> {
        match *self {
            Self::Exponential => Some((std::f64::consts::FRAC_PI_2 * probability).tan()),
            // Normal distribution of variance 2.
            Self::SquaredExponential => Some(2.0_f64.sqrt() * standard_normal_quantile(0.5 + 0.5 * probability)),
            // Student's distribution with 2ν degrees of freedom.
            Self::Matern { nu } => Some(student_quantile(0.5 + 0.5 * probability, 2.0 * nu)),
            Self::WindowedExponential { .. } => None,
        }
    }
}

/// Returns the root of a rising function of a positive number, between 0 and the largest value reached by doubling
/// `start`.
fn rising_root(start: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, start);
    for _ in 0..DOUBLINGS {
        if f(high) >= 0.0 {
            break;
        }
        low = high;
        high *= 2.0;
    }
    let Ok([_, root]) = bisect(low, high, 0.0, |x| Ok::<_, Infallible>(f(x) < 0.0));
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_decay_length_is_where_the_correlation_is_one_over_e() {
        for shape in [
            CorrelationShape::Exponential,
            CorrelationShape::SquaredExponential,
            CorrelationShape::Matern { nu: 1.5 },
            CorrelationShape::Matern { nu: 3.2 },
            CorrelationShape::WindowedExponential { window: 600.0 },
        ] {
            let lag = shape.decay_length(250.0);
            assert!((shape.correlation(lag, 250.0) - (-1.0_f64).exp()).abs() < 1e-12, "{shape:?}");
            let longer = shape.longer(250.0, lag, 0.4);
            assert!(longer > 250.0 && (shape.correlation(lag, longer) - 0.4).abs() < 1e-12, "{shape:?}");
        }
        // Triangle of a window alone: the fraction 1 − 1/e of it.
        let triangle = CorrelationShape::WindowedExponential { window: 600.0 };
        assert!((triangle.decay_length(0.0) / 600.0 - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn spectral_quantiles_integrate_to_the_correlation() {
        // ρ(s) = ∫ cos(ω(u) s) du over the fractions u, by the midpoint rule with n points. The rule misses frequencies
        // that turn by more than half a circle between points: a fraction of about 1/√n for e^{−s}, 3e-4 and 4e-5 for
        // the last two shapes.
        for (shape, tolerance) in [
            (CorrelationShape::Exponential, 2e-3),
            (CorrelationShape::SquaredExponential, 1e-5),
            (CorrelationShape::Matern { nu: 0.8 }, 1e-3),
            (CorrelationShape::Matern { nu: 1.5 }, 5e-4),
            (CorrelationShape::Matern { nu: 4.0 }, 1e-4),
        ] {
            let n = 20_000;
            let quantiles: Vec<f64> =
                (0..n).map(|k| shape.spectral_quantile((f64::from(k) + 0.5) / f64::from(n)).unwrap()).collect();
            for s in [0.3, 1.0, 2.5] {
                let found = quantiles.iter().map(|w| (w * s).cos()).sum::<f64>() / f64::from(n);
                let error = found - shape.correlation(s, 1.0);
                assert!(error.abs() < tolerance, "{shape:?} at {s}: {error:e}");
            }
        }
    }

    #[test]
    fn invalid_shapes_are_refused() {
        for (shape, length) in [
            (CorrelationShape::Matern { nu: 0.0 }, 1.0),
            (CorrelationShape::Matern { nu: f64::NAN }, 1.0),
            (CorrelationShape::WindowedExponential { window: 0.0 }, 1.0),
            (CorrelationShape::WindowedExponential { window: 1.0 }, -1.0),
            (CorrelationShape::SquaredExponential, 0.0),
        ] {
            assert!(shape.check(length).is_err(), "{shape:?} {length}");
        }
        assert!(CorrelationShape::WindowedExponential { window: 1.0 }.check(0.0).is_ok());
    }
}
