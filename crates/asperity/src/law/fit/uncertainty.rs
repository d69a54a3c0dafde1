//! How well correlated records know the parameters of a law fitted to them.

use super::{End, Family, Fit};
use crate::law::Marginal;
use crate::stats::{Estimate, Moments, RecordSum};

/// Step of a difference quotient, in units of a positive parameter or of the law's standard deviation.
const STEP: f64 = 1e-4;
/// The same of a second difference.
const WIDE_STEP: f64 = 1e-3;
/// Shape up to which the density at an end of the support is so steep that the end is known better than by any influence.
const IRREGULAR: f64 = 2.0;

/// A parameter that was fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Parameter {
    name: &'static str,
    /// Place in [`Marginal::parameters`].
    place: usize,
    value: f64,
    /// Size of a difference that counts.
    scale: f64,
    /// Whether it cannot be negative.
    positive: bool,
}

/// A fitted parameter and what the records tell of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterEstimate {
    /// Name, as [`Marginal::parameters`] has it.
    pub name: &'static str,
    /// Value.
    pub value: f64,
    /// With interval; `None` for an end of the support that is no smooth parameter of the likelihood, and where the records hold
    /// too few correlation lengths.
    pub estimate: Option<Estimate>,
}

impl Fit {
    /// Every parameter that was fitted, ends of the support among them.
    fn fitted(&self) -> Vec<Parameter> {
        let std = self.law.std();
        let given = |name: &str| match self.family {
            Family::Lognormal | Family::Weibull | Family::Gamma => name == "shift",
            Family::Beta { .. } => name == "low" || name == "high",
            _ => false,
        };
        let all = self.law.parameters().into_iter().enumerate();
        all.filter(|(_, (name, _))| !given(name))
            .map(|(place, (name, value))| {
                let positive = matches!(name, "std" | "sigma" | "shape" | "scale" | "a" | "b" | "delta" | "lambda");
                let scale = match name {
                    "gamma" => 1.0,
                    "mu" => self.law.parameters()[1].1,
                    _ if positive => value,
                    _ => std,
                };
                Parameter { name, place, value, scale, positive }
            })
            .collect()
    }

    /// The fitted parameters on which the likelihood depends smoothly. An end of the support at the sample's extreme or out of
    /// sight is none, nor one where the shape is at most 2: there the density falls so steeply that the end is known to
    /// n^{−1/shape}, better than to n^{−1/2} (Smith, *Biometrika* **72** (1985) 67,
    /// <https://doi.org/10.1093/biomet/72.1.67>).
    pub(crate) fn regular_parameters(&self) -> Vec<Parameter> {
        let shapes = match self.law {
            Marginal::Beta { a, b, .. } => [a, b],
            Marginal::Weibull { shape, .. } | Marginal::Gamma { shape, .. } => [shape, f64::INFINITY],
            _ => [f64::INFINITY; 2],
        };
        let smooth = |end: End, shape: f64| end == End::Fitted && shape > IRREGULAR;
        let regular = |parameter: &Parameter| match parameter.name {
            "low" | "shift" => smooth(self.low_end, shapes[0]),
            "high" => smooth(self.high_end, shapes[1]),
            _ => true,
        };
        self.fitted().into_iter().filter(regular).collect()
    }

    /// The law with parameters moved from where they are.
    pub(crate) fn moved(&self, moves: &[(Parameter, f64)]) -> Marginal {
        let mut values: Vec<f64> = self.law.parameters().into_iter().map(|(_, value)| value).collect();
        for (parameter, by) in moves {
            values[parameter.place] += by * parameter.scale;
        }
        self.law.with_parameters(&values)
    }

    /// ∂ ln f(x)/∂θ over the parameter's scale.
    pub(crate) fn score(&self, parameter: Parameter, x: f64) -> f64 {
        let at = |by: f64| self.moved(&[(parameter, by)]).ln_pdf(x);
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    }

    /// ∂F(x)/∂θ over the parameter's scale.
    pub(crate) fn slope(&self, parameter: Parameter, x: f64) -> f64 {
        let at = |by: f64| self.moved(&[(parameter, by)]).cdf(x);
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    }

    /// The fitted parameters of a law that was fitted to these records (with equal steps, independent of each other, of one
    /// process; NaN is a missing value; a periodic record goes on with its first value after its last), with 95 % intervals
    /// that know the correlation.
    ///
    /// The covariance of the parameters is H⁻¹JH⁻¹: H the second derivatives of the mean logarithm of the density, J the
    /// long-run variance of the scores, so that the law need not be the true one. Positive parameters have intervals on the
    /// scale of their logarithm; all are Student's, as those of [`crate::stats::ProcessMoments`]. An end of the support
    /// counts as known where it lies at the sample's extreme or out of sight, or the shape there is at most 2: the density then
    /// falls so steeply that the end is known to n^{−1/shape} (Smith 1985), and the intervals of the shapes are too narrow by
    /// what the end itself was not known.
    ///
    /// # References
    /// White, *Econometrica* **50** (1982) 1, <https://doi.org/10.2307/1912526>; Varin, Reid & Firth, *Stat. Sinica* **21**
    /// (2011) 5, for the likelihood of values taken as independent.
    pub fn estimates(&self, records: &[&[f64]], periodic: bool) -> Vec<ParameterEstimate> {
        let regular = self.regular_parameters();
        let influences = self.influences(records, &regular);
        let records: Vec<&[f64]> = records.iter().copied().filter(|record| !record.is_empty()).collect();
        let mean = Moments::of_values(records.iter().flat_map(|record| record.iter().copied())).mean;
        let sum = influences.is_some().then(|| RecordSum::new(&records, mean, periodic));
        let estimate = |parameter: &Parameter| -> Option<Estimate> {
            let place = regular.iter().position(|other| other.place == parameter.place)?;
            let spread = sum.as_ref()?.spread(&influences.as_ref()?[place], regular.len() as f64)?;
            if parameter.positive {
                let ratio = parameter.scale / parameter.value;
                Estimate::logarithmic(parameter.value, 1.0, spread.scaled(ratio))
            } else {
                Estimate::linear(parameter.value, spread.scaled(parameter.scale))
            }
        };
        let of = |p: Parameter| ParameterEstimate { name: p.name, value: p.value, estimate: estimate(&p) };
        self.fitted().into_iter().map(of).collect()
    }

    /// −H⁻¹ s(x)/n of every value for every parameter, in the parameters' scales, as they would add up if the fit had not made
    /// the scores add up to nothing; `None` where H has no inverse.
    fn influences(&self, records: &[&[f64]], parameters: &[Parameter]) -> Option<Vec<Vec<Vec<f64>>>> {
        // At the sample's extremes, where an end was put, the density says nothing.
        let inside = |x: &&f64| self.law.ln_pdf(**x).is_finite();
        let values: Vec<f64> = records.iter().flat_map(|r| r.iter()).filter(inside).copied().collect();
        let n = values.len() as f64;
        let mean_log = |moves: &[(Parameter, f64)]| {
            let law = self.moved(moves);
            values.iter().map(|x| law.ln_pdf(*x)).sum::<f64>() / n
        };
        let k = parameters.len();
        let mut curvature = vec![vec![0.0; k]; k];
        for i in 0..k {
            for j in 0..=i {
                let at = |a: f64, b: f64| mean_log(&[(parameters[i], a * WIDE_STEP), (parameters[j], b * WIDE_STEP)]);
                let difference = at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0);
                let second = difference / (4.0 * WIDE_STEP * WIDE_STEP);
                (curvature[i][j], curvature[j][i]) = (-second, -second);
            }
        }
        let inverse = inverse(curvature)?;
        let scores: Vec<Vec<Vec<f64>>> = parameters
            .iter()
            .map(|parameter| {
                let (above, below) = (self.moved(&[(*parameter, STEP)]), self.moved(&[(*parameter, -STEP)]));
                let score = |x: &f64| {
                    let score = (above.ln_pdf(*x) - below.ln_pdf(*x)) / (2.0 * STEP * n);
                    if x.is_nan() || score.is_finite() { score } else { 0.0 }
                };
                records.iter().filter(|r| !r.is_empty()).map(|record| record.iter().map(score).collect()).collect()
            })
            .collect();
        let combined = |row: &Vec<f64>| -> Vec<Vec<f64>> {
            let record = |r: usize| {
                let value = |i: usize| row.iter().zip(&scores).map(|(weight, score)| weight * score[r][i]).sum();
                (0..scores[0][r].len()).map(value).collect()
            };
            (0..scores[0].len()).map(record).collect()
        };
        Some(inverse.iter().map(combined).collect())
    }
}

/// The inverse of a small symmetric matrix by Gauss and Jordan's elimination; `None` unless all pivots are positive.
pub(crate) fn inverse(mut matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    let n = matrix.len();
    for pivot in 0..n {
        let diagonal = matrix[pivot][pivot];
        if !(diagonal > 0.0 && diagonal.is_finite()) {
            return None;
        }
        matrix[pivot][pivot] = 1.0;
        matrix[pivot].iter_mut().for_each(|entry| *entry /= diagonal);
        let row = matrix[pivot].clone();
        for (_, other) in matrix.iter_mut().enumerate().filter(|(index, _)| *index != pivot) {
            let factor = std::mem::take(&mut other[pivot]);
            other.iter_mut().zip(&row).for_each(|(entry, above)| *entry -= factor * above);
        }
    }
    (n > 0).then_some(matrix)
}
