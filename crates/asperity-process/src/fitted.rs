//! Fitted friction process in SI: random realisations, conversion to a machine, and storage in a file.

use serde::{Deserialize, Serialize};

use super::json::{CorrelationDocument, origin, stated};
use super::{CorrelationShape, FrictionProcess, Generator, ProcessError, ProcessModel, TranslationKind, positive};
use asperity_base::distribution::Marginal;

/// Largest number of values of a simulated record.
const MOST_VALUES: f64 = 1e9;

/// Friction coefficient μ(s) = mean + m(s), fitted to the windows of a study or to a measured record.
///
/// [`FittedProcess::model`] creates the model of m for the generator, in any unit of length. [`FittedProcess::to_json`]
/// and [`FittedProcess::from_json`] preserve every bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FittedProcess {
    /// Mean of μ, positive; the static coefficient at the start of the Stribeck curve.
    pub mean: f64,
    /// 95 % interval of the mean.
    pub mean_interval: Option<[f64; 2]>,
    /// Standard deviation of μ; 0 for a constant coefficient.
    pub std: f64,
    /// 95 % interval of the standard deviation.
    pub std_interval: Option<[f64; 2]>,
    /// Distribution fitted to μ, bounds included. Realisations use its shape with `mean` and `std`. `None` only if μ is
    /// constant.
    pub marginal: Option<Marginal>,
    /// Correlation of μ along the sliding distance. `None` only if μ is constant.
    pub correlation: Option<FittedCorrelation>,
    /// Generator of realisations; if `None`, [`Generator::for_shape`] selects one for the correlation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generator: Option<Generator>,
    /// Coefficient a of μ/(1 + a|v|) in s/m, if known.
    pub stribeck_s_per_m: Option<f64>,
    /// Length and width in metre of the area over which this friction is averaged: window and strip of a study, or the
    /// contact of a specimen. Friction averaged over larger areas varies less. `None` if the area is unknown.
    pub averaged_over_m: Option<[f64; 2]>,
    /// Mean pressure in pascal at which the process was determined.
    pub mean_pressure_pa: Option<f64>,
    /// Source of the process.
    #[serde(default = "stated", deserialize_with = "origin")]
    pub origin: Origin,
}

/// Correlation of μ(s) along the sliding distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "CorrelationDocument", try_from = "CorrelationDocument")]
pub struct FittedCorrelation {
    /// Shape of the correlation of μ; a window is in metre.
    pub shape: CorrelationShape,
    /// Length ℓ of the shape in metre.
    pub length_m: f64,
    /// 95 % interval of the length, in metre.
    pub length_interval_m: Option<[f64; 2]>,
    /// Window over which μ was averaged and which the length therefore includes, in metre; `None` if no window is known.
    /// With [`CorrelationShape::WindowedExponential`] it is the window of the shape, and the length excludes it.
    pub window_m: Option<f64>,
    /// Length without the effect of that window, in metre, if known: ℓ of an exponential with the same integral scale.
    pub length_without_window_m: Option<f64>,
}

/// Source of a process.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Kind of the source.
    pub kind: OriginKind,
    /// Description of the source: file and column, or level of the study.
    pub description: String,
}

asperity_base::choice! {
    /// Kind of source.
    pub enum OriginKind: "source" {
        /// Windows on solved strips.
        Study = "study",
        /// A measured record.
        Record = "record",
        /// Stated by the user.
        Stated = "stated",
    }
}

impl FittedProcess {
    /// Returns whether μ is constant.
    pub fn is_constant(&self) -> bool {
        self.std == 0.0
    }

    /// Checks the process and returns the first invalid value as an error.
    ///
    /// # Errors
    /// Fails if the mean is not positive, if the standard deviation or the Stribeck coefficient is negative, if the
    /// distribution or the correlation is invalid or is absent although μ varies, if an interval does not rise, or if
    /// the generator does not support the correlation or the distribution.
    pub fn check(&self) -> Result<(), ProcessError> {
        positive("mean", self.mean)?;
        non_negative("std", self.std)?;
        for (parameter, interval) in [("mean_interval", self.mean_interval), ("std_interval", self.std_interval)] {
            rising(parameter, interval)?;
        }
        if let Some(marginal) = &self.marginal {
            marginal.check()?;
            positive("standard deviation of the marginal distribution", marginal.std())?;
        }
        if let Some(correlation) = &self.correlation {
            correlation.check()?;
        }
        if !self.is_constant() {
            let present = [("marginal", self.marginal.is_some()), ("correlation", self.correlation.is_some())];
            if let Some((absent, _)) = present.iter().find(|(_, present)| !present) {
                return Err(ProcessError::Absent { absent, std: self.std });
            }
        }
        if let (Some(generator), Some(correlation), Some(marginal)) =
            (self.generator, &self.correlation, &self.marginal)
        {
            generator.check(correlation.shape, marginal)?;
        }
        if let Some(a) = self.stribeck_s_per_m {
            non_negative("stribeck_s_per_m", a)?;
        }
        for side in self.averaged_over_m.into_iter().flatten() {
            positive("averaged_over_m", side)?;
        }
        self.mean_pressure_pa.map_or(Ok(()), |pressure| positive("mean_pressure_pa", pressure))
    }

    /// Returns the model of m(s) with lengths in multiples of `unit_m`: 1 for metre, N/c for the oscillator. The
    /// correlation is the one of m, not of the underlying normal process. Unless a generator is stated, exponential
    /// correlations use the recursion and all others a sum of harmonics.
    ///
    /// # Errors
    /// Fails like [`FittedProcess::check`], and if μ is constant, because a constant has no such model.
    pub fn model(&self, unit_m: f64) -> Result<ProcessModel, ProcessError> {
        self.check()?;
        positive("unit of length", unit_m)?;
        positive("friction standard deviation", self.std)?;
        let absent = |absent| ProcessError::Absent { absent, std: self.std };
        let marginal = self.marginal.clone().ok_or_else(|| absent("marginal"))?;
        let correlation = self.correlation.ok_or_else(|| absent("correlation"))?;
        Ok(ProcessModel {
            shape: correlation.shape.in_unit(unit_m),
            generator: self.generator.unwrap_or_else(|| Generator::for_shape(correlation.shape)),
            correlation: TranslationKind::Corrected,
            ..ProcessModel::new(marginal, self.std, correlation.length_m / unit_m)
        })
    }

    /// Returns the Stribeck coefficient per unit of a dimensionless velocity with the unit `unit_m_per_s`, N/(mω₀) for
    /// the oscillator.
    pub fn stribeck(&self, unit_m_per_s: f64) -> Option<f64> {
        self.stribeck_s_per_m.map(|a| a * unit_m_per_s)
    }

    /// Returns a record μ(0), μ(h), … of this process over `length_m` with the step h = `step_m`; realisation `index`
    /// under `seed`.
    ///
    /// # Errors
    /// Fails like [`FittedProcess::check`], if the length is shorter than a step, if the record has more than 10⁹
    /// values, or if a window of the correlation is not a multiple of the step or more than 10⁶ steps long.
    pub fn simulate(&self, length_m: f64, step_m: f64, seed: u64, index: u64) -> Result<Vec<f64>, ProcessError> {
        positive("step", step_m)?;
        positive("length", length_m)?;
        // Tolerance for rounding: a length of whole steps keeps its last value.
        let steps = (length_m / step_m * (1.0 + 1e-12)).floor();
        if !(1.0..MOST_VALUES).contains(&steps) {
            let parameter = "number of steps in the length";
            return Err(ProcessError::Parameter { parameter, value: steps, wanted: "from 1 to 10⁹" });
        }
        let count = steps as usize + 1;
        self.check()?;
        if self.is_constant() {
            return Ok(vec![self.mean; count]);
        }
        let process = FrictionProcess::with_step(self.model(1.0)?, step_m)?;
        let mut path = process.path(seed, index);
        Ok((0..count).map(|_| self.mean + path.next_value()).collect())
    }
}

impl FittedCorrelation {
    fn check(&self) -> Result<(), ProcessError> {
        self.shape.check(self.length_m)?;
        rising("length_m_interval", self.length_interval_m)?;
        if let Some(window) = self.window_m {
            positive("window_m", window)?;
        }
        if let CorrelationShape::WindowedExponential { window } = self.shape
            && self.window_m != Some(window)
        {
            let value = self.window_m.unwrap_or(f64::NAN);
            return Err(ProcessError::Parameter {
                parameter: "window_m",
                value,
                wanted: "the window of the correlation",
            });
        }
        self.length_without_window_m.map_or(Ok(()), |length| non_negative("length_without_window_m", length))
    }
}

fn non_negative(parameter: &'static str, value: f64) -> Result<(), ProcessError> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(ProcessError::Parameter { parameter, value, wanted: "zero or positive, and finite" })
    }
}

fn rising(parameter: &'static str, interval: Option<[f64; 2]>) -> Result<(), ProcessError> {
    match interval {
        Some([low, high]) if !(low.is_finite() && high.is_finite() && low <= high) => {
            Err(ProcessError::Parameter { parameter, value: low, wanted: "two finite numbers, the lower first" })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use asperity_base::correlation::RecordCorrelation;
    use asperity_base::stats::Moments;

    pub(crate) fn fitted(shape: CorrelationShape) -> FittedProcess {
        FittedProcess {
            mean: 0.21,
            mean_interval: Some([0.2, 0.1 + 0.12]),
            std: 0.01 / 3.0,
            std_interval: None,
            marginal: Some("beta:2.1,5,0.2,0.25".parse().unwrap()),
            correlation: Some(FittedCorrelation {
                shape,
                length_m: 250e-6,
                length_interval_m: Some([2e-4, 3e-4]),
                window_m: match shape {
                    CorrelationShape::WindowedExponential { window } => Some(window),
                    _ => Some(75e-6),
                },
                length_without_window_m: None,
            }),
            generator: None,
            stribeck_s_per_m: Some(4.2 / 7.9),
            averaged_over_m: Some([75e-6, 1e-3]),
            mean_pressure_pa: None,
            origin: Origin { kind: OriginKind::Record, description: "run \"1\".csv".into() },
        }
    }

    /// Moments and correlation of one simulated record.
    type Drawn = (Moments, Vec<f64>);

    #[test]
    fn a_simulated_record_has_the_moments_and_the_correlation_of_its_process() {
        for shape in [
            CorrelationShape::Exponential,
            CorrelationShape::SquaredExponential,
            CorrelationShape::Matern { nu: 1.5 },
            CorrelationShape::WindowedExponential { window: 500e-6 },
        ] {
            let process = fitted(shape);
            let found: Vec<Drawn> = (0..24)
                .map(|index| {
                    let mu = process.simulate(0.5, 50e-6, 4, index).unwrap();
                    assert_eq!(mu.len(), 10_001);
                    let acf = RecordCorrelation::estimate(&[&mu], 50e-6, 40);
                    (Moments::new(&mu), acf.unwrap().correlation)
                })
                .collect();
            let close = |name: &str, wanted: f64, bias: f64, value: &dyn Fn(&Drawn) -> f64| {
                let over = Moments::new(&found.iter().map(value).collect::<Vec<_>>());
                let error = (over.mean - wanted).abs();
                assert!(
                    error < 4.0 * over.standard_error() + bias,
                    "{shape:?}, {name}: {} ± {}",
                    over.mean,
                    over.standard_error()
                );
            };
            close("mean", process.mean, 0.0, &|(moments, _)| moments.mean);
            // Subtracting the mean of a record reduces the variance by the fraction 2ℓ/L, about 1e-3.
            close("std", process.std, 1e-3 * process.std, &|(moments, _)| moments.std);
            close("skewness", 0.5598, 3e-3, &|(moments, _)| moments.skewness);
            let exact = FrictionProcess::with_step(process.model(1.0).unwrap(), 50e-6).unwrap();
            for lag in [1, 5, 10, 20] {
                let wanted = exact.correlation_at(50e-6 * lag as f64);
                close("correlation", wanted, 3e-3, &|(_, acf)| acf[lag]);
            }
        }
    }

    #[test]
    fn a_stated_generator_makes_the_record() {
        let process = FittedProcess { generator: Some(Generator::Renewal), ..fitted(CorrelationShape::Exponential) };
        let mu = process.simulate(0.1, 5e-6, 4, 0).unwrap();
        // One jump per correlation length.
        let jumps = mu.windows(2).filter(|pair| pair[0] != pair[1]).count() as f64;
        let wanted = 20_000.0 * -(-5.0_f64 / 250.0).exp_m1();
        assert!((jumps - wanted).abs() < 4.0 * wanted.sqrt(), "{jumps}");
        // Many more jumps than a loop over them ends with.
        let short = FittedCorrelation { length_m: 1e-200, ..process.correlation.unwrap() };
        let mu = FittedProcess { correlation: Some(short), ..process }.simulate(0.1, 5e-6, 4, 0).unwrap();
        assert!(mu.windows(2).all(|pair| pair[0] != pair[1]));
        let windowed = CorrelationShape::WindowedExponential { window: 500e-6 };
        let error = FittedProcess { generator: Some(Generator::Jacobi), ..fitted(windowed) }.check().unwrap_err();
        assert!(matches!(error, ProcessError::Generator { generator: "jacobi", .. }), "{error}");
    }

    #[test]
    fn the_model_uses_the_requested_units_of_length_and_velocity() {
        let process = fitted(CorrelationShape::WindowedExponential { window: 500e-6 });
        let model = process.model(0.025).unwrap();
        assert!((model.correlation_length - 0.01).abs() < 1e-15);
        assert!(
            matches!(model.shape, CorrelationShape::WindowedExponential { window } if (window - 0.02).abs() < 1e-15)
        );
        assert!((process.stribeck(7.9).unwrap() - 4.2).abs() < 1e-12);
        let (metre, dimensionless) =
            (FrictionProcess::new(process.model(1.0).unwrap()).unwrap(), FrictionProcess::new(model).unwrap());
        assert!((metre.step() / dimensionless.step() - 0.025).abs() < 1e-12);
    }

    #[test]
    fn a_window_that_is_not_a_multiple_of_the_step_is_refused_with_a_suitable_step() {
        let process = fitted(CorrelationShape::WindowedExponential { window: 500e-6 });
        assert!(process.simulate(0.01, 50e-6, 1, 0).is_ok());
        let error = process.simulate(0.01, 60e-6, 1, 0).unwrap_err();
        assert!(matches!(error, ProcessError::StepInWindow { nearest, .. } if (nearest - 62.5e-6).abs() < 1e-12));
        assert!(process.simulate(1e-6, 50e-6, 1, 0).is_err() && process.simulate(1e6, 1e-9, 1, 0).is_err());
        let error = process.simulate(1e-9, 50e-12, 1, 0).unwrap_err().to_string();
        assert_eq!(error, "number of steps in the window is 10000000, but must be at most 10⁶");
    }

    #[test]
    fn constant_friction_needs_no_distribution_and_varying_friction_does() {
        let steady =
            FittedProcess { std: 0.0, marginal: None, correlation: None, ..fitted(CorrelationShape::Exponential) };
        assert_eq!(steady.simulate(1e-3, 1e-4, 1, 0).unwrap(), vec![0.21; 11]);
        assert!(steady.check().is_ok() && steady.model(1.0).is_err());
        let error = FittedProcess { std: 0.1, ..steady }.check().unwrap_err();
        assert!(error.to_string().contains("marginal"), "{error}");
    }
}
