//! Whether there is contact, and the pressure where there is.
//!
//! P(contact) is logistic in a polynomial of the variables; the logarithm of the pressure in contact is another polynomial plus an
//! error drawn from the leave-one-out errors of samples with similar predictions.

use ndarray::{Array1, Array2, ArrayView2, Axis};

use super::functions::Functions;
use super::newton::{Local, maximise};
use super::{Fitted, LEAST_IN_CONTACT, Rotated, SAMPLES_PER_TERM, Surrogate, golden};
use crate::chaos::{LeastSquares, RegressionError};
use crate::pressure::MethodError;

/// Penalty ½ λ c² of all coefficients of the log odds but the constant: it keeps them finite where the samples in contact and
/// those out of it are separate.
const RIDGE: f64 = 1e-2;
/// Errors drawn for each fresh germ.
const DRAWS: usize = 5;
/// Samples in a group of neighbouring predictions that share one law of errors.
const GROUP: usize = 50;

/// Both parts on the variables of the rotated germ.
#[derive(Debug)]
pub(crate) struct TwoPart<'a> {
    samples: &'a Rotated,
    /// Positions of the samples in contact and logarithms of their pressures.
    contact: Vec<usize>,
    logarithms: Vec<f64>,
    /// Of all samples and of the fresh ones, for the log odds.
    odds: [Array2<f64>; 2],
    /// Of the samples in contact and of the fresh ones, for the logarithm.
    logarithm: [Array2<f64>; 2],
}

impl<'a> TwoPart<'a> {
    /// Of degrees up to `degree`: that of the log odds by Akaike's criterion, that of the logarithm by its leave-one-out
    /// error.
    ///
    /// # Errors
    /// Too few samples are in contact.
    pub(crate) fn new(samples: &'a Rotated, degree: usize) -> Result<Self, MethodError> {
        let [count, in_contact] = samples.counts();
        if in_contact < LEAST_IN_CONTACT {
            return Err(MethodError::TooFewInContact { in_contact, samples: count, wanted: LEAST_IN_CONTACT });
        }
        let contact: Vec<usize> = (0..count).filter(|i| samples.pressures_pa[*i] > 0.0).collect();
        let logarithms: Vec<f64> = contact.iter().map(|i| samples.pressures_pa[*i].ln()).collect();
        let ones = vec![1.0; count];
        let variables = samples.variables();
        let mut odds: Option<(f64, Functions)> = None;
        let fewer = in_contact.min(count - in_contact);
        for degree in Functions::degrees(variables, degree, fewer, SAMPLES_PER_TERM) {
            let functions = Functions::new(&samples.rows, degree)?;
            let design = functions.matrix(&samples.rows);
            let fit = log_odds(design.view(), &samples.pressures_pa, &ones);
            let criterion = 2.0 * (functions.len() as f64 - fit.1);
            if odds.as_ref().is_none_or(|(least, _)| criterion < *least) {
                odds = Some((criterion, functions));
            }
        }
        let mut logarithm: Option<(f64, Functions)> = None;
        for degree in Functions::degrees(variables, degree, in_contact, SAMPLES_PER_TERM) {
            let functions = Functions::new(&samples.rows, degree)?;
            let design = functions.matrix(&samples.rows).select(Axis(0), &contact);
            let fit = match regress(design.view(), &logarithms, &vec![1.0; in_contact]) {
                Ok(fit) => fit,
                // A degree whose functions the samples cannot tell apart is no candidate.
                Err(RegressionError::RankDeficient { .. }) => continue,
                Err(error) => return Err(error.into()),
            };
            let error = fit.errors.iter().map(|e| e * e).sum::<f64>();
            if logarithm.as_ref().is_none_or(|(least, _)| error < *least) {
                logarithm = Some((error, functions));
            }
        }
        match (odds, logarithm) {
            (Some((_, odds)), Some((_, logarithm))) => Ok(Self {
                odds: [odds.matrix(&samples.rows), odds.matrix(&samples.fresh)],
                logarithm: [
                    logarithm.matrix(&samples.rows).select(Axis(0), &contact),
                    logarithm.matrix(&samples.fresh),
                ],
                samples,
                contact,
                logarithms,
            }),
            _ => Err(MethodError::TooFewSamples { samples: count, wanted: LEAST_IN_CONTACT }),
        }
    }
}

impl Surrogate for TwoPart<'_> {
    fn fit(&self, weights: &[f64]) -> Result<Fitted, MethodError> {
        let (odds, _) = log_odds(self.odds[0].view(), &self.samples.pressures_pa, weights);
        let of_contact: Vec<f64> = self.contact.iter().map(|i| weights[*i]).collect();
        let fit = regress(self.logarithm[0].view(), &self.logarithms, &of_contact)?;
        let residuals = Residuals::new(&fit, &of_contact);
        let odds = self.odds[1].dot(&Array1::from(odds));
        let logarithms = self.logarithm[1].dot(&Array1::from(fit.coefficients.clone()));
        let count = odds.len() as f64;
        let (mut atoms, mut contact_probability) = (Vec::with_capacity(odds.len() * (DRAWS + 1)), 0.0);
        for (i, (odds, logarithm)) in odds.iter().zip(&logarithms).enumerate() {
            let probability = logistic(*odds);
            contact_probability += probability / count;
            atoms.push((0.0, (1.0 - probability) / count));
            for draw in 0..DRAWS {
                let error = residuals.pick(*logarithm, (draw as f64 + golden(i)) / DRAWS as f64);
                let pressure_pa = (logarithm + error).exp().min(self.samples.largest_pa);
                atoms.push((pressure_pa, probability / (count * DRAWS as f64)));
            }
        }
        let leave_one_out_error = fit.relative_error;
        let coefficients = self.odds[0].ncols() + self.logarithm[0].ncols();
        Ok(Fitted { atoms, contact_probability, coefficients, leave_one_out_error })
    }
}

fn logistic(odds: f64) -> f64 {
    1.0 / (1.0 + (-odds).exp())
}

/// Coefficients of the log odds of a positive pressure, and their penalised log-likelihood. The constant is +∞ where all are
/// positive.
fn log_odds(design: ArrayView2<'_, f64>, pressures_pa: &[f64], weights: &[f64]) -> (Vec<f64>, f64) {
    let terms = design.ncols();
    if pressures_pa.iter().all(|p| *p > 0.0) {
        let mut all = vec![0.0; terms];
        all[0] = f64::INFINITY;
        return (all, 0.0);
    }
    let likelihood = |place: &[f64]| -> Local {
        let odds = design.dot(&Array1::from(place.to_vec()));
        let mut value = 0.0;
        let mut slopes = Array1::zeros(odds.len());
        let mut weighted = design.to_owned();
        for (i, ((odds, p), w)) in odds.iter().zip(pressures_pa).zip(weights).enumerate() {
            let sign = if *p > 0.0 { 1.0 } else { -1.0 };
            // −ln(1 + e^{−|x|}) does not overflow.
            let margin = sign * odds;
            value += w * (margin.min(0.0) - (-margin.abs()).exp().ln_1p());
            slopes[i] = w * sign * logistic(-margin);
            let curvature = logistic(margin) * logistic(-margin);
            weighted.row_mut(i).mapv_inplace(|a| a * w * curvature);
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
    let place = maximise(vec![0.0; terms], [f64::NEG_INFINITY, f64::INFINITY], likelihood);
    let value = likelihood(&place).value;
    (place, value)
}

/// A weighted least-squares fit.
struct Regression {
    coefficients: Vec<f64>,
    predictions: Vec<f64>,
    /// Of predicting each sample from the others.
    errors: Vec<f64>,
    relative_error: Option<f64>,
}

fn regress(design: ArrayView2<'_, f64>, values: &[f64], weights: &[f64]) -> Result<Regression, RegressionError> {
    let roots: Array1<f64> = weights.iter().map(|w| w.sqrt()).collect();
    let scaled = &design * &roots.view().insert_axis(Axis(1));
    let fit = LeastSquares::new(scaled.view())?
        .fit(&values.iter().zip(&roots).map(|(y, root)| y * root).collect::<Vec<_>>())?;
    let predictions = design.dot(&Array1::from(fit.coefficients.clone())).to_vec();
    let errors = fit.leave_one_out.errors.iter().zip(&fit.residuals).zip(&roots);
    let errors = errors.map(|((error, rest), root)| error.unwrap_or(*rest) / root).collect();
    Ok(Regression {
        coefficients: fit.coefficients,
        predictions,
        errors,
        relative_error: fit.leave_one_out.relative_error,
    })
}

/// Errors in groups of samples with neighbouring predictions.
struct Residuals {
    /// Least prediction of each group after the first.
    bounds: Vec<f64>,
    /// Increasing errors of each group, with the share of the weight up to each.
    groups: Vec<Vec<(f64, f64)>>,
}

impl Residuals {
    fn new(fit: &Regression, weights: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..weights.len()).collect();
        order.sort_by(|a, b| fit.predictions[*a].total_cmp(&fit.predictions[*b]).then(a.cmp(b)));
        let count = (order.len() / GROUP).max(1);
        let start = |group: usize| group * order.len() / count;
        let group = |group: usize| {
            let members = &order[start(group)..start(group + 1)];
            let mut errors: Vec<(f64, f64)> = members.iter().map(|i| (fit.errors[*i], weights[*i])).collect();
            errors.sort_by(|a, b| a.0.total_cmp(&b.0));
            let whole: f64 = errors.iter().map(|(_, w)| w).sum();
            let mut sum = 0.0;
            for (_, share) in &mut errors {
                sum += *share / whole;
                *share = sum;
            }
            errors
        };
        Self {
            bounds: (1..count).map(|group| fit.predictions[order[start(group)]]).collect(),
            groups: (0..count).map(group).collect(),
        }
    }

    /// The error at a share 0 to 1 of those around a prediction.
    fn pick(&self, prediction: f64, share: f64) -> f64 {
        let group = &self.groups[self.bounds.partition_point(|bound| *bound <= prediction)];
        group[group.partition_point(|(_, sum)| *sum <= share).min(group.len() - 1)].0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{standard_normal, stream};

    #[test]
    fn log_odds_solve_the_score_equations() {
        let xi = standard_normal(&mut stream(2, "two_part", 0), 800);
        let design = Array2::from_shape_fn((400, 2), |(i, j)| if j == 0 { 1.0 } else { xi[i] });
        let pressures: Vec<f64> = (0..400).map(|i| (xi[i] + xi[400 + i] - 0.5).max(0.0)).collect();
        let weights: Vec<f64> = (0..400).map(|i| 0.5 + f64::from(i % 2)).collect();
        let (c, _) = log_odds(design.view(), &pressures, &weights);
        for j in 0..2 {
            let score: f64 = (0..400)
                .map(|i| {
                    let seen = if pressures[i] > 0.0 { 1.0 } else { 0.0 };
                    weights[i] * design[[i, j]] * (seen - 1.0 / (1.0 + (-c[0] - c[1] * xi[i]).exp()))
                })
                .sum();
            let penalty = if j == 0 { 0.0 } else { RIDGE * c[1] };
            assert!((score - penalty).abs() < 1e-6, "{j} {score} {penalty}");
        }
        // Without variables the share itself.
        let (c, _) = log_odds(Array2::ones((400, 1)).view(), &pressures, &vec![1.0; 400]);
        let share = pressures.iter().filter(|p| **p > 0.0).count() as f64 / 400.0;
        assert!((logistic(c[0]) - share).abs() < 1e-9);
    }

    #[test]
    fn separate_samples_have_finite_log_odds() {
        let design = Array2::from_shape_fn((40, 2), |(i, j)| if j == 0 { 1.0 } else { i as f64 / 10.0 - 2.0 });
        let pressures: Vec<f64> = (0..40).map(|i| if i < 20 { 0.0 } else { 1.0 }).collect();
        let (c, _) = log_odds(design.view(), &pressures, &[1.0; 40]);
        assert!(c.iter().all(|c| c.is_finite()) && c[1] > 5.0, "{c:?}");
    }

    #[test]
    fn weighted_errors_are_picked_by_their_share() {
        let weights = [1.0, 2.0, 1.0];
        let fit = regress(Array2::ones((3, 1)).view(), &[0.0, 1.0, 5.0], &weights).unwrap();
        assert!((fit.coefficients[0] - 7.0 / 4.0).abs() < 1e-12);
        // Without the second sample the mean is 5/2.
        assert!((fit.errors[1] - (1.0 - 2.5)).abs() < 1e-12);
        let residuals = Residuals::new(&fit, &weights);
        assert_eq!([0.1, 0.3, 0.7, 0.8].map(|share| residuals.pick(1.75, share)), {
            [fit.errors[0], fit.errors[1], fit.errors[1], fit.errors[2]]
        });
    }
}
