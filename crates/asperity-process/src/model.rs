//! Stationary random friction processes.

use std::ops::RangeInclusive;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::jacobi::JacobiStep;
use super::table::TranslationTable;
use super::{CorrelationShape, Generator, ProcessError, TranslationKind, positive};
use asperity_base::distribution::Marginal;
use asperity_base::distribution::translation::Translation;

/// Parameters of a random friction process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProcessModel {
    /// Shape of the distribution of m; its mean is zero and its standard deviation is `std`.
    pub marginal: Marginal,
    /// Standard deviation σ of the friction coefficient.
    pub std: f64,
    /// Correlation length ℓ, in the unit of the sliding distance.
    pub correlation_length: f64,
    /// Shape of the correlation.
    #[serde(default)]
    pub shape: CorrelationShape,
    /// Grid points per lag at which the correlation falls to 1/e (ℓ for an exponential). A renewal process has grid
    /// points only when it is recorded.
    pub steps_per_length: usize,
    /// Generator of realisations.
    pub generator: Generator,
    /// Process that has the correlation length.
    pub correlation: TranslationKind,
    /// Least value of m: lower values are raised to it and counted. `None` means no clipping.
    pub least: Option<f64>,
}

impl ProcessModel {
    /// Creates an autoregressive process with twenty grid points per correlation length, without correction and without
    /// clipping.
    pub fn new(marginal: Marginal, std: f64, correlation_length: f64) -> Self {
        Self {
            marginal,
            std,
            correlation_length,
            shape: CorrelationShape::default(),
            steps_per_length: 20,
            generator: Generator::default(),
            correlation: TranslationKind::default(),
            least: None,
        }
    }

    /// Returns the fraction of the values of m that are raised to `least`, from the distribution.
    pub fn clipped_fraction(&self) -> f64 {
        let below = |least: f64| self.marginal.cdf(self.marginal.mean() + least / self.std * self.marginal.std());
        self.least.map_or(0.0, below)
    }

    fn check(&self) -> Result<(), ProcessError> {
        self.marginal.check()?;
        positive("friction standard deviation", self.std)?;
        self.shape.check(self.correlation_length)?;
        positive("standard deviation of the marginal distribution", self.marginal.std())?;
        positive("steps per correlation length", self.steps_per_length as f64)?;
        self.generator.check(self.shape, &self.marginal)?;
        if let Some(value) = self.least.filter(|least| least.is_nan() || *least >= 0.0) {
            return Err(ProcessError::Parameter { parameter: "least fluctuation", value, wanted: "negative" });
        }
        Ok(())
    }
}

/// Distances between values whose sums are accurate in double precision.
pub(super) const STEPS: RangeInclusive<f64> = 1e-15..=1e15;

/// Checks that a distance between values is one of [`STEPS`].
pub(super) fn check_step(step: f64) -> Result<(), ProcessError> {
    if STEPS.contains(&step) {
        return Ok(());
    }
    let (parameter, wanted) = ("distance between values of friction", "between 1e-15 and 1e15");
    Err(ProcessError::Parameter { parameter, value: step, wanted })
}

/// Largest number of steps in a window; a realisation stores 8 bytes for each.
const MOST_STEPS_IN_WINDOW: f64 = 1e6;

/// Tables and length of a [`FrictionProcess`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Parts<'a> {
    pub(super) table: &'a TranslationTable,
    pub(super) jacobi: Option<&'a JacobiStep>,
    pub(super) length: f64,
}

/// Stationary random process m(s) of zero mean, ready for sampling.
#[derive(Debug, Clone)]
pub struct FrictionProcess {
    model: ProcessModel,
    table: TranslationTable,
    /// Step of a Jacobi diffusion; shared, because it is large.
    jacobi: Option<Arc<JacobiStep>>,
    /// Correlation length of the normal process, or of m if there is none.
    normal_length: f64,
    /// Distance between grid points.
    step: f64,
}

impl FrictionProcess {
    /// Checks a model and tabulates its translation.
    ///
    /// Fails if a parameter is not positive, if grid points are not between 1e-15 and 1e15 apart, if the distribution
    /// is invalid or has no finite standard deviation, if the generator does not support the correlation or the
    /// distribution, if `least` is not negative, or if a step of a Jacobi diffusion is below a thousandth of its
    /// correlation length.
    pub fn new(model: ProcessModel) -> Result<Self, ProcessError> {
        model.check()?;
        let step = model.shape.decay_length(model.correlation_length) / model.steps_per_length as f64;
        let step = match model.shape {
            // The window must be a whole number of steps.
            CorrelationShape::WindowedExponential { window } => window / (window / step).ceil(),
            _ => step,
        };
        Self::build(model, step)
    }

    /// Creates the process with grid points `step` apart, regardless of `steps_per_length`.
    ///
    /// Fails like [`FrictionProcess::new`], and if the window is not a whole number of steps or has more than 10⁶ steps.
    pub fn with_step(model: ProcessModel, step: f64) -> Result<Self, ProcessError> {
        model.check()?;
        positive("step", step)?;
        if let CorrelationShape::WindowedExponential { window } = model.shape {
            let steps = (window / step).round();
            if steps < 1.0 || (window / step - steps).abs() > 1e-6 * steps {
                let nearest = window / steps.max(1.0);
                return Err(ProcessError::StepInWindow { step, window, nearest });
            }
            if steps > MOST_STEPS_IN_WINDOW {
                let (parameter, wanted) = ("number of steps in the window", "at most 10⁶");
                return Err(ProcessError::Parameter { parameter, value: steps, wanted });
            }
        }
        Self::build(model, step)
    }

    fn build(model: ProcessModel, step: f64) -> Result<Self, ProcessError> {
        check_step(step)?;
        let normal_length = match model.correlation {
            TranslationKind::Corrected if model.generator.translates() => {
                let wanted = Translation::new(&model.marginal)?.normal_correlation((-1.0_f64).exp())?;
                let decay = model.shape.decay_length(model.correlation_length);
                model.shape.longer(model.correlation_length, decay, wanted)
            }
            _ => model.correlation_length,
        };
        let table = TranslationTable::new(&model.marginal, model.std);
        let jacobi = match (model.generator, &model.marginal) {
            (Generator::Jacobi, Marginal::Beta { a, b, .. }) => {
                Some(Arc::new(JacobiStep::new(*a, *b, step / normal_length)?))
            }
            _ => None,
        };
        Ok(Self { model, table, jacobi, normal_length, step })
    }

    /// Returns the model of the process.
    pub fn model(&self) -> &ProcessModel {
        &self.model
    }

    /// Returns the distance between grid points: 1/N of the lag at which the correlation is 1/e, ℓ/N for an
    /// exponential. With a window it is slightly smaller, so that the window is a whole number of steps.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Returns the correlation between neighbouring grid points, e^{−h/ℓ_G} for an exponential: of the normal process
    /// if there is one, otherwise of m.
    pub fn normal_step_correlation(&self) -> f64 {
        self.model.shape.correlation(self.step, self.normal_length)
    }

    /// Returns the correlation of m at two grid points a distance `lag` apart, after the translation and without
    /// clipping.
    #[cfg(test)]
    pub(super) fn correlation_at(&self, lag: f64) -> f64 {
        let correlation = self.model.shape.correlation(lag, self.normal_length);
        if !self.model.generator.translates() {
            return correlation;
        }
        Translation::new(&self.model.marginal).unwrap().correlation(correlation)
    }

    /// Returns the lower and upper end of the support of m; infinite for unbounded distributions.
    pub fn support(&self) -> (f64, f64) {
        (self.table.at_probability(0.0), self.table.at_probability(1.0))
    }

    /// Returns the tables for realisations.
    pub(super) fn parts(&self) -> Parts<'_> {
        Parts { table: &self.table, jacobi: self.jacobi.as_deref(), length: self.normal_length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::stats::Moments;

    fn beta(std: f64, length: f64) -> ProcessModel {
        ProcessModel::new("beta:2.1,5".parse().unwrap(), std, length)
    }

    fn values(process: &FrictionProcess, index: u64, count: usize) -> Vec<f64> {
        let mut path = process.path(7, index);
        (0..count).map(|_| path.next_value()).collect()
    }

    #[test]
    fn the_autoregression_has_the_published_coefficient() {
        let model = ProcessModel { steps_per_length: 25, ..ProcessModel::new(Marginal::STANDARD_NORMAL, 1.0, 250.0) };
        let process = FrictionProcess::new(model).unwrap();
        assert_eq!(process.step(), 10.0);
        assert!((process.normal_step_correlation() - 0.960_789_439_2).abs() < 5e-11);
    }

    #[test]
    fn the_mean_over_a_window_has_the_published_variance() {
        // 2(ℓ/W)·[1 − (ℓ/W)(1 − e^{−W/ℓ})] for ℓ = 250 and W = 600 is 0.51761.
        // A sampled process, averaged by the trapezoidal rule over 60 steps; the relative error of the rule is
        // (Δ/ℓ)²/6.
        let model = ProcessModel { steps_per_length: 25, ..ProcessModel::new(Marginal::STANDARD_NORMAL, 1.0, 250.0) };
        let process = FrictionProcess::new(model).unwrap();
        let paths = 20_000;
        let mean_square = (0..paths)
            .map(|i| {
                let m = values(&process, i, 61);
                let mean = (m.iter().sum::<f64>() - 0.5 * (m[0] + m[60])) / 60.0;
                mean * mean
            })
            .sum::<f64>()
            / paths as f64;
        let standard_error = 0.51761 * (2.0 / paths as f64).sqrt();
        assert!((mean_square - 0.51761).abs() < 4.0 * standard_error + 3e-4, "{mean_square}");
    }

    #[test]
    fn grid_points_have_the_wanted_moments_and_correlation_for_every_generator() {
        let (recursion, harmonics) = (Generator::Autoregressive, Generator::Spectral { harmonics: 64 });
        let windowed = CorrelationShape::WindowedExponential { window: 4.0 };
        for (generator, correlation, shape, length) in [
            (recursion, TranslationKind::Plain, CorrelationShape::Exponential, 3.0),
            (recursion, TranslationKind::Corrected, CorrelationShape::Exponential, 3.0),
            (recursion, TranslationKind::Plain, windowed, 3.0),
            (recursion, TranslationKind::Corrected, windowed, 0.3),
            (recursion, TranslationKind::Plain, windowed, 0.0),
            (harmonics, TranslationKind::Plain, CorrelationShape::Exponential, 3.0),
            (harmonics, TranslationKind::Corrected, CorrelationShape::SquaredExponential, 3.0),
            (harmonics, TranslationKind::Plain, CorrelationShape::Matern { nu: 1.5 }, 3.0),
        ] {
            let model = ProcessModel { generator, correlation, shape, ..beta(0.002, length) };
            let process = FrictionProcess::new(model).unwrap();
            let paths: Vec<Vec<f64>> = (0..20_000).map(|i| values(&process, i, 41)).collect();
            let mean_of = |f: &dyn Fn(&[f64]) -> f64| {
                let values: Vec<f64> = paths.iter().map(|m| f(m)).collect();
                let moments = Moments::new(&values);
                (moments.mean, 4.0 * moments.standard_error())
            };
            for (power, wanted) in [(1, 0.0), (2, 1.0), (3, 0.5598)] {
                let (found, margin) = mean_of(&|m| (m[40] / 0.002).powi(power));
                assert!((found - wanted).abs() < margin, "{generator:?}, {shape:?}: mean of m^{power} is {found}");
            }
            for lag in [1, 10, 20, 40] {
                let wanted = process.correlation_at(lag as f64 * process.step());
                let (found, margin) = mean_of(&|m| m[0] * m[lag] / 0.002_f64.powi(2));
                assert!((found - wanted).abs() < margin, "{generator:?}, {shape:?}: {found} at {lag}, not {wanted}");
            }
        }
    }

    #[test]
    fn the_correction_gives_the_length_and_the_plain_translation_shortens_it() {
        let plain = FrictionProcess::new(beta(1.0, 2.0)).unwrap();
        let model = ProcessModel { correlation: TranslationKind::Corrected, ..beta(1.0, 2.0) };
        let corrected = FrictionProcess::new(model).unwrap();
        assert!((corrected.normal_step_correlation().powi(20) - 0.375_013_83).abs() < 5e-9);
        assert!((corrected.correlation_at(2.0) - (-1.0_f64).exp()).abs() < 1e-12);
        assert!((plain.normal_step_correlation() - (-0.05_f64).exp()).abs() < 1e-15);
        assert!(plain.correlation_at(2.0) < corrected.correlation_at(2.0));
    }

    #[test]
    fn the_correction_gives_the_decay_of_every_shape() {
        for (generator, shape) in [
            (Generator::Autoregressive, CorrelationShape::WindowedExponential { window: 3.0 }),
            (Generator::Spectral { harmonics: 8 }, CorrelationShape::SquaredExponential),
            (Generator::Spectral { harmonics: 8 }, CorrelationShape::Matern { nu: 2.2 }),
        ] {
            let model = ProcessModel { correlation: TranslationKind::Corrected, generator, shape, ..beta(1.0, 2.0) };
            let found = FrictionProcess::new(model).unwrap().correlation_at(shape.decay_length(2.0));
            assert!((found - (-1.0_f64).exp()).abs() < 1e-11, "{shape:?}: {found}");
        }
    }

    #[test]
    fn an_unsupported_correlation_is_an_error_that_names_a_generator() {
        let windowed = CorrelationShape::WindowedExponential { window: 1.0 };
        for (generator, shape, able) in [
            (Generator::Autoregressive, CorrelationShape::SquaredExponential, "spectral"),
            (Generator::Autoregressive, CorrelationShape::Matern { nu: 1.5 }, "spectral"),
            (Generator::Spectral { harmonics: 8 }, windowed, "autoregressive"),
        ] {
            let error = FrictionProcess::new(ProcessModel { generator, shape, ..beta(1.0, 1.0) }).unwrap_err();
            assert!(error.to_string().contains(able) && error.to_string().contains(shape.name()), "{error}");
        }
    }

    #[test]
    fn the_support_of_beta_friction_matches_the_publication() {
        let (low, high) = FrictionProcess::new(beta(1.0, 1.0)).unwrap().support();
        assert!((low + 1.844).abs() < 5e-4 && (high - 4.392).abs() < 5e-4);
    }

    #[test]
    fn clipped_values_are_counted_and_none_is_below_the_least() {
        let model = ProcessModel { least: Some(-1e-3), ..beta(1e-3, 1.0) };
        let process = FrictionProcess::new(model).unwrap();
        let mut path = process.path(1, 0);
        let values: Vec<f64> = (0..2000).map(|_| path.next_value()).collect();
        let raised = values.iter().filter(|m| **m == -1e-3).count() as u64;
        assert!(raised > 0 && raised == path.clipped());
        assert!(values.iter().all(|m| *m >= -1e-3));
        // Fraction from the distribution; 2,000 values have an effective sample size of about 1,000; four standard
        // errors.
        for generator in [Generator::Autoregressive, Generator::Jacobi, Generator::Spectral { harmonics: 256 }] {
            let model = ProcessModel { least: Some(-1e-3), generator, ..beta(1e-3, 0.05) };
            let wanted = model.clipped_fraction();
            let process = FrictionProcess::with_step(model, 0.05).unwrap();
            let (runs, count) = (20, 500);
            let clipped: u64 = (0..runs)
                .map(|run| {
                    let mut path = process.path(1, run);
                    for _ in 0..count {
                        path.next_value();
                    }
                    path.clipped()
                })
                .sum();
            let found = clipped as f64 / (runs as usize * count) as f64;
            let error = (wanted * (1.0 - wanted) * 2.2 / (runs as usize * count) as f64).sqrt();
            assert!((found - wanted).abs() < 4.0 * error, "{generator:?}: {found} and {wanted}");
        }
        // P(X < mean − std) of the standard normal distribution.
        let normal = ProcessModel { least: Some(-1e-3), ..ProcessModel::new("normal".parse().unwrap(), 1e-3, 1.0) };
        assert!((normal.clipped_fraction() - 0.158_655_253_931_457).abs() < 1e-12);
        assert_eq!(beta(1e-3, 1.0).clipped_fraction(), 0.0);
        assert!(FrictionProcess::new(ProcessModel { least: Some(0.1), ..beta(1e-3, 1.0) }).is_err());
    }

    #[test]
    fn realisations_depend_on_seed_and_index_alone_and_invalid_models_are_refused() {
        let process = FrictionProcess::new(beta(1e-3, 1.0)).unwrap();
        assert_eq!(values(&process, 3, 5), values(&process, 3, 5));
        assert_ne!(values(&process, 3, 5), values(&process, 4, 5));
        for model in [
            beta(0.0, 1.0),
            beta(1.0, f64::NAN),
            ProcessModel { steps_per_length: 0, ..beta(1.0, 1.0) },
            ProcessModel { generator: Generator::Spectral { harmonics: 0 }, ..beta(1.0, 1.0) },
            ProcessModel { generator: Generator::Spectral { harmonics: usize::MAX }, ..beta(1.0, 1.0) },
        ] {
            assert!(FrictionProcess::new(model).is_err());
        }
    }
}
