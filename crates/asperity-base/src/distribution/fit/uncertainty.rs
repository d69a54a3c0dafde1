//! Confidence intervals of the parameters of a distribution fitted to correlated records.

use super::{End, Family, Fit, fit};
use crate::blocks;
use crate::distribution::Marginal;
use crate::numeric::inverse;
use crate::stats::{Layout, Moments, ProcessEstimate, RecordSum};

/// Step of a first difference, in units of a positive parameter or of the standard deviation.
const STEP: f64 = 1e-4;
/// Step of a second difference.
const WIDE_STEP: f64 = 1e-3;
/// Shape up to which the density at an end of the support is so steep that the end converges faster than any regular
/// estimate.
const IRREGULAR: f64 = 2.0;

/// Number of jackknife blocks.
const GROUPS: usize = 20;

/// Fitted parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(hidden)]
pub struct FittedParameter {
    name: &'static str,
    /// Index in [`Marginal::parameters`].
    place: usize,
    value: f64,
    /// Scale of the parameter.
    scale: f64,
    /// Whether it is positive.
    positive: bool,
}

/// Fitted parameter with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterEstimate {
    /// Name, as in [`Marginal::parameters`].
    pub name: &'static str,
    /// Value.
    pub value: f64,
    /// Value with interval; `None` for an end of the support on which the likelihood does not depend smoothly, and for
    /// records of too few correlation lengths.
    pub estimate: Option<ProcessEstimate>,
}

impl Fit {
    /// Parameters fitted, including the ends of the support.
    fn fitted(&self) -> Vec<FittedParameter> {
        let std = self.marginal.std();
        let given = |name: &str| match self.family {
            Family::Lognormal | Family::Weibull | Family::Gamma => name == "shift",
            Family::Beta { .. } => name == "low" || name == "high",
            _ => false,
        };
        let all = self.marginal.parameters().into_iter().enumerate();
        all.filter(|(_, (name, _))| !given(name))
            .map(|(place, (name, value))| {
                let positive = matches!(name, "std" | "sigma" | "shape" | "scale" | "a" | "b" | "delta" | "lambda");
                let scale = match name {
                    "gamma" => 1.0,
                    "mu" => self.marginal.parameters()[1].1,
                    _ if positive => value,
                    _ => std,
                };
                FittedParameter { name, place, value, scale, positive }
            })
            .collect()
    }

    /// Returns the fitted parameters on which the likelihood depends smoothly. This excludes ends of the support that
    /// are at the extreme of the sample or undetermined, and ends with a shape of at most 2: the density is so steep
    /// there that the error of the end is of order n^{−1/shape}, less than n^{−1/2} (Smith, *Biometrika* **72** (1985)
    /// 67, <https://doi.org/10.1093/biomet/72.1.67>).
    #[doc(hidden)]
    pub fn regular_parameters(&self) -> Vec<FittedParameter> {
        let shapes = match self.marginal {
            Marginal::Beta { a, b, .. } => [a, b],
            Marginal::Weibull { shape, .. } | Marginal::Gamma { shape, .. } => [shape, f64::INFINITY],
            _ => [f64::INFINITY; 2],
        };
        let smooth = |end: End, shape: f64| end == End::Fitted && shape > IRREGULAR;
        let regular = |parameter: &FittedParameter| match parameter.name {
            "low" | "shift" => smooth(self.low_end, shapes[0]),
            "high" => smooth(self.high_end, shapes[1]),
            _ => true,
        };
        self.fitted().into_iter().filter(regular).collect()
    }

    /// Returns the distribution with shifted parameters.
    #[doc(hidden)]
    pub fn moved(&self, moves: &[(FittedParameter, f64)]) -> Marginal {
        let mut values: Vec<f64> = self.marginal.parameters().into_iter().map(|(_, value)| value).collect();
        for (parameter, by) in moves {
            values[parameter.place] += by * parameter.scale;
        }
        self.marginal.with_parameters(&values)
    }

    /// Returns ∂ ln f(x)/∂θ in units of the parameter's scale.
    #[doc(hidden)]
    pub fn score(&self, parameter: FittedParameter, x: f64) -> f64 {
        let at = |by: f64| self.moved(&[(parameter, by)]).ln_pdf(x);
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    }

    /// Returns ∂F(x)/∂θ in units of the parameter's scale.
    #[doc(hidden)]
    pub fn slope(&self, parameter: FittedParameter, x: f64) -> f64 {
        let at = |by: f64| self.moved(&[(parameter, by)]).cdf(x);
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    }

    /// Returns the fitted parameters of a distribution fitted to these records, with 95 % intervals that account for
    /// the correlation along and across strips. The records have equal steps and belong to one process; NaN is a
    /// missing value, and `true` and `false` stand for periodic and free strips of one track.
    ///
    /// The covariance of the parameters is H⁻¹JH⁻¹ with the second derivatives H of the mean log-density and the
    /// long-run variance J of the scores, which does not assume that the distribution is the true one. Positive
    /// parameters have intervals on a logarithmic scale, bias-corrected if two parameters were fitted (by the jackknife
    /// over twenty blocks); all use Student's quantiles as [`crate::stats::ProcessMoments`]. An end of the support
    /// counts as known if it is at the extreme of the sample or undetermined, or the shape there is at most 2: its
    /// error is then of order n^{−1/shape} (Smith 1985), and the intervals of the shapes neglect it.
    ///
    /// # References
    /// White, *Econometrica* **50** (1982) 1, <https://doi.org/10.2307/1912526>; Varin, Reid & Firth, *Stat. Sinica*
    /// **21** (2011) 5, on the composite likelihood.
    pub fn estimates(&self, records: &[&[f64]], layout: impl Into<Layout>) -> Vec<ParameterEstimate> {
        let layout = layout.into();
        let regular = self.regular_parameters();
        let influences = self.influences(records, &regular);
        let records: Vec<&[f64]> = records.iter().copied().filter(|record| !record.is_empty()).collect();
        let mean = Moments::from_values(records.iter().flat_map(|record| record.iter().copied())).mean;
        let bias = self.bias(&side_by_side(&records, layout));
        let sum = influences.is_some().then(|| RecordSum::new(&records, mean, layout));
        let estimate = |parameter: &FittedParameter| -> Option<ProcessEstimate> {
            let place = regular.iter().position(|other| other.place == parameter.place)?;
            let spread = sum.as_ref()?.spread(&influences.as_ref()?[place], regular.len() as f64)?;
            if parameter.positive {
                let ratio = parameter.scale / parameter.value;
                ProcessEstimate::logarithmic(parameter.value, (-bias[parameter.place]).exp(), spread.scaled(ratio))
            } else {
                ProcessEstimate::linear(parameter.value, spread.scaled(parameter.scale))
            }
        };
        let of = |p: FittedParameter| ParameterEstimate { name: p.name, value: p.value, estimate: estimate(&p) };
        self.fitted().into_iter().map(of).collect()
    }

    /// Returns the jackknife bias of the logarithm of every parameter, omitting one of twenty blocks of neighbours at a
    /// time. It is zero with more than two fitted parameters, which would take too long, and if a subset has no fit.
    ///
    /// # References
    /// Quenouille, *Biometrika* **43** (1956) 353, <https://doi.org/10.1093/biomet/43.3-4.353>.
    fn bias(&self, values: &[f64]) -> Vec<f64> {
        let own = self.marginal.parameters();
        let none = vec![0.0; own.len()];
        if self.family.parameters() != 2 || values.len() < 10 * GROUPS {
            return none;
        }
        let without = |group: usize| {
            let [from, to] = [group, group + 1].map(|edge| edge * values.len() / GROUPS);
            let kept = [&values[..from], &values[to..]].concat();
            Some(fit(self.family, &kept).ok()?.marginal.parameters())
        };
        let parts: Option<Vec<_>> = blocks::map(0..GROUPS, without);
        let Some(parts) = parts else { return none };
        let of = |place: usize| {
            let shift = |part: &Vec<(&str, f64)>| (part[place].1 / own[place].1).ln();
            (GROUPS - 1) as f64 * parts.iter().map(shift).sum::<f64>() / GROUPS as f64
        };
        (0..own.len()).map(of).collect()
    }

    /// Returns −H⁻¹ s(x)/n of every value for every parameter, in units of the scales, not centred by the fit; `None`
    /// if H is singular.
    fn influences(&self, records: &[&[f64]], parameters: &[FittedParameter]) -> Option<Vec<Vec<Vec<f64>>>> {
        // At extremes of the sample that are ends of the support, the density carries no information.
        let inside = |x: &&f64| self.marginal.ln_pdf(**x).is_finite();
        let values: Vec<f64> = records.iter().flat_map(|r| r.iter()).filter(inside).copied().collect();
        let n = values.len() as f64;
        let mean_log = |moves: &[(FittedParameter, f64)]| {
            let marginal = self.moved(moves);
            values.iter().map(|x| marginal.ln_pdf(*x)).sum::<f64>() / n
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

/// Returns all values strip by strip and, within a strip, position by position over the tracks, so that the values of a
/// block are neighbours in space.
fn side_by_side(records: &[&[f64]], layout: Layout) -> Vec<f64> {
    let strip = |tracks: &[&[f64]]| -> Vec<f64> {
        (0..tracks[0].len()).flat_map(|place| tracks.iter().map(move |track| track[place])).collect()
    };
    layout.by_strip(records).flat_map(strip).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample;
    use super::*;
    use crate::distribution::special::trigamma;
    use crate::random;

    /// Returns a translated record with correlation e^{−lag/5}.
    fn record(marginal: &str, n: usize, index: u64) -> Vec<f64> {
        let marginal: Marginal = marginal.parse().unwrap();
        let phi = (-0.2_f64).exp();
        let mut g = random::standard_normal(&mut random::stream(29, "parameters", index), n);
        for t in 1..n {
            g[t] = phi * g[t - 1] + (1.0 - phi * phi).sqrt() * g[t];
        }
        g.into_iter().map(|g| marginal.translate(g)).collect()
    }

    #[test]
    fn of_independent_values_the_errors_are_those_of_fisher() {
        let n = 4000;
        let values = sample("beta:2.1,5", n, 90);
        let fitted = fit(Family::Beta { low: 0.0, high: 1.0 }, &values).unwrap();
        let found = fitted.estimates(&[&values], false);
        let (curve, curve_a, curve_b) = (trigamma(7.1), trigamma(2.1), trigamma(5.0));
        let determinant = (curve_a * curve_b - curve * (curve_a + curve_b)) * n as f64;
        let wanted = [((curve_b - curve) / determinant).sqrt(), ((curve_a - curve) / determinant).sqrt()];
        for (parameter, wanted) in found.iter().zip(wanted) {
            let ratio = parameter.estimate.unwrap().standard_error / wanted;
            // A variance from forty blocks or more has a relative standard error of √(2/40), its square root half of
            // that.
            assert!((ratio - 1.0).abs() < 4.0 * 0.11, "{parameter:?} for {wanted}");
        }
        assert_eq!([found[0].name, found[1].name], ["a", "b"]);
        let normal = sample("normal:3,0.5", n, 91);
        let fitted = fit(Family::Normal, &normal).unwrap().estimates(&[&normal], false);
        // The fitted mean equals the sample mean: σ/√n.
        assert!((fitted[0].estimate.unwrap().standard_error / (0.5 / (n as f64).sqrt()) - 1.0).abs() < 0.44);
    }

    #[test]
    #[ignore = "slow"]
    fn intervals_of_a_correlated_record_cover_the_shapes() {
        let runs = 120;
        let mut held = [0; 2];
        for run in 0..runs {
            let values = record("beta:2.1,5", 1000, run);
            let records: Vec<&[f64]> = values.chunks(250).collect();
            let fitted = fit(Family::Beta { low: 0.0, high: 1.0 }, &values).unwrap();
            for (held, (found, truth)) in held.iter_mut().zip(fitted.estimates(&records, false).iter().zip([2.1, 5.0]))
            {
                *held += usize::from(found.estimate.unwrap().interval.contains(truth));
            }
        }
        println!("{held:?}");
        // 95 % of 120 with a standard error of 2.4.
        assert!(held.iter().all(|held| *held > 114 - 10), "{held:?} of {runs}");
    }

    #[test]
    fn intervals_follow_the_unit_of_the_values() {
        let metre = record("gamma:3,1", 2000, 1);
        let nanometre: Vec<f64> = metre.iter().map(|x| 1e-9 * x).collect();
        let of = |values: &[f64]| fit(Family::Gamma, values).unwrap().estimates(&[values], false);
        let (coarse, fine) = (of(&metre), of(&nanometre));
        for (parameter, unit) in [(0, 1.0), (1, 1e-9)] {
            let (a, b) = (coarse[parameter].estimate.unwrap().interval, fine[parameter].estimate.unwrap().interval);
            assert!((a.low * unit / b.low - 1.0).abs() < 1e-5 && (a.high * unit / b.high - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn an_end_that_is_no_smooth_parameter_has_no_interval() {
        let values = record("weibull:1.5,1,3", 3000, 2);
        let fitted = fit(Family::ShiftedWeibull, &values).unwrap();
        let found = fitted.estimates(&[&values], false);
        let Marginal::Weibull { shape, .. } = fitted.marginal else { panic!() };
        assert!(shape < IRREGULAR, "{fitted:?}");
        assert!(found[0].estimate.is_some() && found[1].estimate.is_some() && found[2].estimate.is_none());
        // Without intervals the parameters are still listed.
        let short = record("beta:2.1,5", 40, 3);
        let fitted = fit(Family::Beta { low: 0.0, high: 1.0 }, &short).unwrap();
        assert!(fitted.estimates(&[&short], false).iter().all(|found| found.estimate.is_none()));
    }
}
