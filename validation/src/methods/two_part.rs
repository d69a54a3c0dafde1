//! Two-part model of the pressure: the probabilities of contact and of plastic contact, and the pressure in elastic contact.
//!
//! P(contact) is logistic in a polynomial of the variables. With a hardness H, so is the probability that a contact is plastic. In
//! elastic contact, ln(p/(1 − p/H)) is another polynomial plus an error drawn from the leave-one-out errors of samples with similar
//! predictions. This transform keeps 0 < p < H, and equals ln p without a hardness.

use ndarray::{Array1, ArrayView2};

use super::functions::Functions;
use super::newton::{Local, maximise};
use super::{LEAST_IN_CONTACT, SAMPLES_PER_TERM, golden, rows_but, rows_of};
use asperity::chaos::{LeastSquares, RegressionError};
use asperity::pressure::MethodError;
use asperity::pressure::surrogate::{Fitted, PointMasses, RotatedSamples, Surrogate};

/// Factor λ of the penalty ½ λ c² of all coefficients of the log odds except the constant. It keeps them finite if the two kinds of
/// samples are separable.
const RIDGE: f64 = 1e-2;
/// Number of errors drawn for each fresh ξ.
const DRAWS: usize = 5;
/// Number of errors drawn for each left-out sample.
const DRAWS_HELD: usize = 20;
/// Number of samples in a group of neighbouring predictions, which have one distribution of errors.
const GROUP: usize = 50;

/// Two-part model in the variables of the rotated ξ.
#[derive(Debug)]
pub(crate) struct TwoPart<'a> {
    samples: &'a RotatedSamples,
    degree: usize,
}

impl<'a> TwoPart<'a> {
    /// Creates the model with degrees up to `degree`. Akaike's criterion selects the degree of the log odds, the leave-one-out error
    /// that of the pressure.
    pub(crate) fn new(samples: &'a RotatedSamples, degree: usize) -> Self {
        Self { samples, degree }
    }
}

impl Surrogate for TwoPart<'_> {
    fn fit(&self, samples: &[usize]) -> Result<Fitted, MethodError> {
        let largest = self.samples.largest_pa;
        let pressure = |i: &usize| self.samples.pressures_pa[*i];
        let of = |wanted: &dyn Fn(f64) -> bool| -> Vec<usize> {
            samples.iter().copied().filter(|i| wanted(pressure(i))).collect()
        };
        let contact = of(&|p| p > 0.0);
        if contact.len() < LEAST_IN_CONTACT {
            return Err(MethodError::TooFewSamples { samples: contact.len(), wanted: LEAST_IN_CONTACT });
        }
        let elastic = of(&|p| p > 0.0 && p < largest);
        let touches = Chance::fit(self.samples, samples, self.degree, |p| p > 0.0)?;
        let yields = Chance::fit(self.samples, &contact, self.degree, |p| p >= largest)?;
        let pressed = Elastic::fit(self.samples, &elastic, self.degree)?;
        let masses_of = |rows: &[Vec<f64>], draws: usize| -> Vec<PointMasses> {
            let (touches, yields) = (touches.of(rows), yields.of(rows));
            let values = pressed.as_ref().map(|pressed| pressed.functions.predict(rows, &pressed.coefficients));
            let masses_at = |i: usize| {
                // If all contacts are plastic, there is no elastic part.
                let plastic = if values.is_some() { yields[i] } else { 1.0 };
                let mut masses = vec![(0.0, 1.0 - touches[i]), (largest, touches[i] * plastic)];
                if let (Some(pressed), Some(values)) = (&pressed, &values) {
                    for draw in 0..draws {
                        let error = pressed.errors.pick(values[i], (draw as f64 + golden(i)) / draws as f64);
                        let probability = touches[i] * (1.0 - plastic) / draws as f64;
                        masses.push((pressure_pa(values[i] + error, largest), probability));
                    }
                }
                masses.retain(|(_, probability)| *probability > 0.0);
                masses
            };
            (0..rows.len()).map(masses_at).collect()
        };
        let fresh = &self.samples.fresh;
        let weight = 1.0 / fresh.len() as f64;
        Ok(Fitted {
            distribution: masses_of(fresh, DRAWS)
                .into_iter()
                .flatten()
                .map(|(p, probability)| (p, weight * probability))
                .collect(),
            given: masses_of(&rows_but(self.samples, samples), DRAWS_HELD),
            coefficients: touches.coefficients.len()
                + if yields.varies() { yields.coefficients.len() } else { 0 }
                + pressed.as_ref().map_or(0, |pressed| pressed.coefficients.len()),
            leave_one_out_error: pressed.and_then(|pressed| pressed.relative_error),
        })
    }
}

/// Returns ln(p/(1 − p/H)).
fn logarithm(pressure_pa: f64, largest_pa: f64) -> f64 {
    pressure_pa.ln() - (-pressure_pa / largest_pa).ln_1p()
}

/// Returns the pressure from its [`logarithm`].
fn pressure_pa(logarithm: f64, largest_pa: f64) -> f64 {
    1.0 / ((-logarithm).exp() + 1.0 / largest_pa)
}

fn logistic(odds: f64) -> f64 {
    1.0 / (1.0 + (-odds).exp())
}

/// Probability of an event, logistic in a polynomial.
struct Chance {
    functions: Functions,
    coefficients: Vec<f64>,
}

impl Chance {
    /// Fits the probability that `happens` is true for the pressure, from the chosen samples.
    fn fit(
        samples: &RotatedSamples,
        chosen: &[usize],
        degree: usize,
        happens: impl Fn(f64) -> bool,
    ) -> Result<Self, MethodError> {
        let rows = rows_of(samples, chosen);
        let seen: Vec<bool> = chosen.iter().map(|i| happens(samples.pressures_pa[*i])).collect();
        let often = seen.iter().filter(|seen| **seen).count();
        if often == 0 || often == seen.len() {
            let constant = if often == 0 { f64::NEG_INFINITY } else { f64::INFINITY };
            return Ok(Self { functions: Functions::new(&rows, 0)?, coefficients: vec![constant] });
        }
        let mut best: Option<(f64, Self)> = None;
        let fewer = often.min(seen.len() - often);
        for degree in Functions::degrees(samples.variables(), degree, fewer, SAMPLES_PER_TERM) {
            let functions = Functions::new(&rows, degree)?;
            let (coefficients, likelihood) = log_odds(functions.matrix(&rows).view(), &seen);
            let criterion = 2.0 * (functions.len() as f64 - likelihood);
            if best.as_ref().is_none_or(|(least, _)| criterion < *least) {
                best = Some((criterion, Self { functions, coefficients }));
            }
        }
        let wanted = LEAST_IN_CONTACT;
        best.map(|(_, chance)| chance).ok_or(MethodError::TooFewSamples { samples: seen.len(), wanted })
    }

    /// Returns the probabilities at some rows.
    fn of(&self, rows: &[Vec<f64>]) -> Vec<f64> {
        self.functions.predict(rows, &self.coefficients).iter().map(|odds| logistic(*odds)).collect()
    }

    /// Returns whether the probability is neither 0 nor 1 everywhere.
    fn varies(&self) -> bool {
        self.coefficients[0].is_finite()
    }
}

/// Returns the coefficients of the log odds and their penalised log-likelihood.
fn log_odds(design: ArrayView2<'_, f64>, seen: &[bool]) -> (Vec<f64>, f64) {
    let likelihood = |place: &[f64]| -> Local {
        let odds = design.dot(&Array1::from(place.to_vec()));
        let mut value = 0.0;
        let mut slopes = Array1::zeros(odds.len());
        let mut weighted = design.to_owned();
        for (i, (odds, seen)) in odds.iter().zip(seen).enumerate() {
            let sign = if *seen { 1.0 } else { -1.0 };
            // −ln(1 + e^{−|x|}) does not overflow.
            let margin = sign * odds;
            value += margin.min(0.0) - (-margin.abs()).exp().ln_1p();
            slopes[i] = sign * logistic(-margin);
            let curvature = logistic(margin) * logistic(-margin);
            weighted.row_mut(i).mapv_inplace(|a| a * curvature);
        }
        let mut gradient = design.t().dot(&slopes).to_vec();
        let mut curvature = design.t().dot(&weighted);
        for (j, c) in place.iter().enumerate().skip(1) {
            value -= 0.5 * RIDGE * c * c;
            gradient[j] -= RIDGE * c;
            curvature[[j, j]] += RIDGE;
        }
        Local { value, gradient, curvature }
    };
    let place = maximise(vec![0.0; design.ncols()], [f64::NEG_INFINITY, f64::INFINITY], likelihood);
    let value = likelihood(&place).value;
    (place, value)
}

/// Model of the pressure in elastic contact.
struct Elastic {
    functions: Functions,
    coefficients: Vec<f64>,
    errors: Residuals,
    relative_error: Option<f64>,
}

impl Elastic {
    /// Fits the model to the chosen samples; `None` without samples.
    fn fit(samples: &RotatedSamples, chosen: &[usize], degree: usize) -> Result<Option<Self>, MethodError> {
        let rows = rows_of(samples, chosen);
        let values: Vec<f64> = chosen.iter().map(|i| logarithm(samples.pressures_pa[*i], samples.largest_pa)).collect();
        let mut best: Option<(f64, Self)> = None;
        if chosen.is_empty() {
            return Ok(None);
        }
        for degree in Functions::degrees(samples.variables(), degree, chosen.len(), SAMPLES_PER_TERM) {
            let functions = Functions::new(&rows, degree)?;
            let design = functions.matrix(&rows);
            let found = LeastSquares::new(design).and_then(|squares| squares.fit(&values));
            let fit = match found {
                Ok(fit) => fit,
                // The samples do not determine all coefficients of this degree.
                Err(RegressionError::RankDeficient { .. }) => continue,
                Err(error) => return Err(error.into()),
            };
            let errors = fit.leave_one_out.errors.iter().zip(&fit.residuals);
            let errors: Vec<f64> = errors.map(|(error, rest)| error.unwrap_or(*rest)).collect();
            let criterion = errors.iter().map(|e| e * e).sum::<f64>();
            if best.as_ref().is_none_or(|(least, _)| criterion < *least) {
                let predictions = functions.predict(&rows, &fit.coefficients);
                let errors = Residuals::new(&predictions, &errors);
                let relative_error = fit.leave_one_out.relative_error;
                best = Some((criterion, Self { functions, coefficients: fit.coefficients, errors, relative_error }));
            }
        }
        Ok(best.map(|(_, elastic)| elastic))
    }
}

/// Errors of the samples, in groups with neighbouring predictions.
struct Residuals {
    /// Least prediction of each group after the first.
    bounds: Vec<f64>,
    /// Increasing errors of each group.
    groups: Vec<Vec<f64>>,
}

impl Residuals {
    fn new(predictions: &[f64], errors: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..errors.len()).collect();
        order.sort_by(|a, b| predictions[*a].total_cmp(&predictions[*b]).then(a.cmp(b)));
        let count = (order.len() / GROUP).max(1);
        let start = |group: usize| group * order.len() / count;
        let group = |group: usize| {
            let mut own: Vec<f64> = order[start(group)..start(group + 1)].iter().map(|i| errors[*i]).collect();
            own.sort_by(f64::total_cmp);
            own
        };
        Self {
            bounds: (1..count).map(|group| predictions[order[start(group)]]).collect(),
            groups: (0..count).map(group).collect(),
        }
    }

    /// Returns the quantile of the errors near a prediction.
    fn pick(&self, prediction: f64, probability: f64) -> f64 {
        let group = &self.groups[self.bounds.partition_point(|bound| *bound <= prediction)];
        group[((probability * group.len() as f64) as usize).min(group.len() - 1)]
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;
    use asperity::random::{standard_normal, stream};

    #[test]
    fn log_odds_solve_the_score_equations() {
        let xi = standard_normal(&mut stream(2, "two_part", 0), 800);
        let design = Array2::from_shape_fn((400, 2), |(i, j)| if j == 0 { 1.0 } else { xi[i] });
        let seen: Vec<bool> = (0..400).map(|i| xi[i] + xi[400 + i] > 0.5).collect();
        let (c, _) = log_odds(design.view(), &seen);
        for j in 0..2 {
            let score: f64 = (0..400)
                .map(|i| {
                    let seen = if seen[i] { 1.0 } else { 0.0 };
                    design[[i, j]] * (seen - 1.0 / (1.0 + (-c[0] - c[1] * xi[i]).exp()))
                })
                .sum();
            let penalty = if j == 0 { 0.0 } else { RIDGE * c[1] };
            assert!((score - penalty).abs() < 1e-6, "{j} {score} {penalty}");
        }
        // Without variables, the probability is the fraction of the samples.
        let (c, _) = log_odds(Array2::ones((400, 1)).view(), &seen);
        let fraction = seen.iter().filter(|seen| **seen).count() as f64 / 400.0;
        assert!((logistic(c[0]) - fraction).abs() < 1e-9);
    }

    #[test]
    fn separate_samples_have_finite_log_odds() {
        let design = Array2::from_shape_fn((40, 2), |(i, j)| if j == 0 { 1.0 } else { i as f64 / 10.0 - 2.0 });
        let seen: Vec<bool> = (0..40).map(|i| i >= 20).collect();
        let (c, _) = log_odds(design.view(), &seen);
        assert!(c.iter().all(|c| c.is_finite()) && c[1] > 5.0, "{c:?}");
    }

    #[test]
    fn the_logarithm_of_elastic_pressure_is_inverted_and_stays_below_the_hardness() {
        for p in [1e-9, 0.3, 1.9, 2.0 - 1e-9] {
            assert!((pressure_pa(logarithm(p, 2.0), 2.0) / p - 1.0).abs() < 1e-12, "{p}");
        }
        assert!((logarithm(3.0, f64::INFINITY) - 3.0_f64.ln()).abs() < 1e-15);
        assert!((pressure_pa(30.0, 2.0) - 2.0).abs() < 1e-9 && pressure_pa(1000.0, 2.0) <= 2.0);
        assert!((pressure_pa(1.0, f64::INFINITY) - 1.0_f64.exp()).abs() < 1e-12);
    }

    #[test]
    fn errors_are_quantiles_among_similar_predictions() {
        let predictions: Vec<f64> = (0..100).map(f64::from).collect();
        let errors: Vec<f64> = (0..100).map(|i| if i < 50 { f64::from(i % 2) } else { f64::from(i) }).collect();
        let residuals = Residuals::new(&predictions, &errors);
        assert_eq!([0.1, 0.49, 0.51, 1.0].map(|p| residuals.pick(20.0, p)), [0.0, 0.0, 1.0, 1.0]);
        assert_eq!([0.0, 0.5, 1.0].map(|p| residuals.pick(50.0, p)), [50.0, 75.0, 99.0]);
    }
}
