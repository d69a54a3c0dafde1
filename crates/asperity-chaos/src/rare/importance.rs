//! Importance sampling from a mixture, with its interval.
//!
//! The mean of w = 1(g < 0) φ/h over draws from h estimates the probability. The interpolant ĝ serves as control variate: the
//! mean K of k = 1(ĝ < 0) φ/h costs no evaluations of g, so the estimate is K + mean(w − k) where ĝ predicts failures. In
//! general it is mean(w) − c (mean(k) − K) with the regression coefficient c of w on k. A poor interpolant has c = 0 and leaves
//! plain importance sampling.
//!
//! # References
//! Owen & Zhou, *J. Am. Stat. Assoc.* **95** (2000) 135, <https://doi.org/10.1080/01621459.2000.10473909>.

use asperity_base::random::Stream;
use asperity_base::stats::{Interval, Moments, student_quantile};

use super::error::RareError;
use super::interpolant::Interpolant;
use super::limit_state::LimitState;
use super::proposal::Proposal;

/// Relative variance, divided by the number of draws, that is added for regions without a draw.
pub(super) const UNSEEN: f64 = 0.1;
/// Draws for the mean of the control variate.
const CONTROL: usize = 10_000;

/// Draws from one mixture and their estimate of the probability.
#[derive(Debug, Clone)]
pub(super) struct Draws<'a> {
    proposal: &'a Proposal,
    control: Control<'a>,
    random: Stream,
    pub(super) points: Vec<Vec<f64>>,
    pub(super) values: Vec<f64>,
    /// Values of 1(g < 0) φ/h.
    weights: Vec<f64>,
    /// Values of 1(ĝ < 0) φ/h.
    controls: Vec<f64>,
}

/// Control variate.
#[derive(Debug, Clone)]
struct Control<'a> {
    interpolant: &'a Interpolant,
    mean: f64,
    /// Squared standard error of the mean.
    error: f64,
}

impl<'a> Draws<'a> {
    /// Starts without draws.
    pub(super) fn new(proposal: &'a Proposal, interpolant: &'a Interpolant, mut random: Stream) -> Self {
        let drawn = proposal.draw(CONTROL, &mut random);
        let moments = Moments::new(&weights(proposal, &drawn, &interpolant.values(&drawn)));
        let error = moments.sample_std().powi(2) / CONTROL as f64;
        let control = Control { interpolant, mean: moments.mean, error };
        let (points, values, weights, controls) = Default::default();
        Self { proposal, control, random, points, values, weights, controls }
    }

    /// Draws `count` more points and evaluates the limit state there.
    pub(super) fn add<E: Send>(&mut self, count: usize, state: &mut LimitState<'_, E>) -> Result<(), RareError<E>> {
        let points = self.proposal.draw(count, &mut self.random);
        let values = state.evaluate(&points)?;
        self.weights.extend(weights(self.proposal, &points, &values));
        self.controls.extend(weights(self.proposal, &points, &self.control.interpolant.values(&points)));
        self.points.extend(points);
        self.values.extend(values);
        Ok(())
    }

    /// Returns whether the draws fail where the interpolant predicts failures, and only there.
    pub(super) fn predicted(&self) -> bool {
        self.weights == self.controls
    }

    /// Returns the probability and its coefficient of variation, which is infinite without failures.
    ///
    /// The largest deviation counts twice, because a deviation larger than all others may be missing.
    pub(super) fn estimate(&self) -> [f64; 2] {
        if self.weights.iter().all(|w| *w == 0.0) {
            return [0.0, f64::INFINITY];
        }
        let coefficient = slope(&self.controls, &self.weights);
        let shift = |(w, k): (&f64, &f64)| w - coefficient * (k - self.control.mean);
        let shifted: Vec<f64> = self.weights.iter().zip(&self.controls).map(shift).collect();
        let with_control = accuracy(&shifted, coefficient * coefficient * self.control.error);
        let plain = accuracy(&self.weights, 0.0).unwrap_or([0.0, f64::INFINITY]);
        with_control.filter(|found| found[1] < plain[1]).unwrap_or(plain)
    }

    /// Returns the 95 % interval P exp(±t c) with the coefficient of variation c. Student's t has as many degrees of freedom as
    /// the effective number of failures (Σw)²/Σw² less one.
    pub(super) fn interval(&self) -> Interval {
        let (sum, squares) = self.weights.iter().fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
        let t = student_quantile(0.975, (sum * sum / squares - 1.0).max(1.0));
        let [probability, coefficient_of_variation] = self.estimate();
        let factor = (t * coefficient_of_variation).exp();
        Interval { low: probability / factor, high: probability * factor }
    }
}

/// Returns 1(g < 0) φ/h at the points.
fn weights(proposal: &Proposal, points: &[Vec<f64>], values: &[f64]) -> Vec<f64> {
    points.iter().zip(values).map(|(z, g)| if *g < 0.0 { 1.0 / proposal.ratio(z) } else { 0.0 }).collect()
}

/// Returns the mean of the terms and its coefficient of variation; `None` if the mean is not positive.
fn accuracy(terms: &[f64], further_variance: f64) -> Option<[f64; 2]> {
    let (count, mean) = (terms.len() as f64, terms.iter().sum::<f64>() / terms.len() as f64);
    let squares: Vec<f64> = terms.iter().map(|term| (term - mean).powi(2)).collect();
    let largest = squares.iter().copied().fold(0.0, f64::max);
    let variance = (squares.iter().sum::<f64>() + largest) / (count - 1.0) / count + further_variance;
    (mean > 0.0).then(|| [mean, (variance / (mean * mean) + UNSEEN / count).sqrt()])
}

/// Returns the slope of the regression of y on x, between 0 and 1; 1 if x is constant.
fn slope(x: &[f64], y: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (centre_x, centre_y) = (mean(x), mean(y));
    let products: f64 = x.iter().zip(y).map(|(x, y)| (x - centre_x) * (y - centre_y)).sum();
    let squares: f64 = x.iter().map(|x| (x - centre_x).powi(2)).sum();
    if squares > 0.0 { (products / squares).clamp(0.0, 1.0) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{standard_normal, stream};

    #[test]
    fn a_control_variate_corrects_the_mean_by_its_own_error() {
        let points: Vec<Vec<f64>> =
            standard_normal(&mut stream(1, "points", 0), 80).chunks(2).map(<[_]>::to_vec).collect();
        let values: Vec<f64> = points.iter().map(|z| z[0]).collect();
        let proposal = Proposal::fit(&points, &vec![vec![1.0, 0.0]; 40]);
        let interpolant = Interpolant::new(&points, &values).unwrap();
        let controls: Vec<f64> = (0..100).map(|i| f64::from(u8::from(i % 4 == 0))).collect();
        let weights: Vec<f64> = (0..100).map(|i| if i % 20 == 0 { 0.5 } else { controls[i] }).collect();
        // The regression of w on k has the slope (mean(wk) − mean(w) mean(k))/(mean(k²) − mean(k)²).
        let coefficient: f64 = (0.225 - 0.225 * 0.25) / (0.25 - 0.0625);
        for (mean, wanted) in [(0.26, 0.225 + coefficient * 0.01), (0.25, 0.225), (0.2, 0.225 - coefficient * 0.05)] {
            let draws = Draws {
                proposal: &proposal,
                control: Control { interpolant: &interpolant, mean, error: 1e-8 },
                random: stream(1, "draws", 0),
                points: Vec::new(),
                values: Vec::new(),
                weights: weights.clone(),
                controls: controls.clone(),
            };
            let [probability, variation] = draws.estimate();
            assert!((probability - wanted).abs() < 1e-12, "{probability} {wanted}");
            // The largest deviation of what is left of w counts twice.
            let rest: Vec<f64> = weights.iter().zip(&controls).map(|(w, k)| w - coefficient * k).collect();
            let centre = rest.iter().sum::<f64>() / 100.0;
            let squares: Vec<f64> = rest.iter().map(|r| (r - centre).powi(2)).collect();
            let largest = squares.iter().copied().fold(0.0, f64::max);
            let variance = (squares.iter().sum::<f64>() + largest) / 99.0 / 100.0 + coefficient * coefficient * 1e-8;
            let expected = (variance / (wanted * wanted) + UNSEEN / 100.0).sqrt();
            assert!((variation / expected - 1.0).abs() < 1e-12, "{variation} {expected}");
            assert!(draws.interval().low < probability && probability < draws.interval().high && !draws.predicted());
        }
    }
}
