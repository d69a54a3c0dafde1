//! Importance sampling from a mixture, with its interval.

use asperity_base::random::Stream;
use asperity_base::stats::{Interval, student_quantile};

use super::RareError;
use super::limit_state::LimitState;
use super::proposal::Proposal;

/// Relative variance, divided by the number of draws, that is added for regions without a draw.
const UNSEEN: f64 = 0.1;

/// Draws from one mixture and their estimate of the probability, the mean of 1(g < 0) φ/h.
#[derive(Debug, Clone, Default)]
pub(super) struct Draws {
    pub(super) points: Vec<Vec<f64>>,
    pub(super) values: Vec<f64>,
    /// Values of 1(g < 0) φ/h.
    weights: Vec<f64>,
}

impl Draws {
    /// Draws `count` more points and evaluates the limit state there.
    pub(super) fn add<G, E: Send>(
        &mut self,
        count: usize,
        proposal: &Proposal,
        state: &mut LimitState<'_, G>,
        variables: usize,
        draws: &mut Stream,
    ) -> Result<(), RareError<E>>
    where
        G: Fn(&[f64]) -> Result<f64, E> + Sync,
    {
        let points = proposal.draw(count, variables, draws);
        let values = state.evaluate(&points)?;
        self.weights
            .extend(points.iter().zip(&values).map(|(z, g)| if *g < 0.0 { 1.0 / proposal.ratio(z) } else { 0.0 }));
        self.points.extend(points);
        self.values.extend(values);
        Ok(())
    }

    pub(super) fn probability(&self) -> f64 {
        self.weights.iter().sum::<f64>() / self.weights.len() as f64
    }

    /// Returns the coefficient of variation of the probability; infinite without failures.
    ///
    /// The largest weight counts twice, because a weight larger than all others may be missing.
    pub(super) fn coefficient_of_variation(&self) -> f64 {
        let (count, mean) = (self.weights.len() as f64, self.probability());
        if mean == 0.0 {
            return f64::INFINITY;
        }
        let largest = self.weights.iter().copied().fold(0.0, f64::max);
        let squares: f64 = self.weights.iter().chain([&largest]).map(|w| (w / mean - 1.0).powi(2)).sum();
        ((squares / (count - 1.0) + UNSEEN) / count).sqrt()
    }

    /// Returns the 95 % interval P exp(±t c) with the coefficient of variation c. Student's t has as many degrees of freedom as
    /// the effective number of failures (Σw)²/Σw² less one.
    pub(super) fn interval(&self) -> Interval {
        let (sum, squares) = self.weights.iter().fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
        let t = student_quantile(0.975, (sum * sum / squares - 1.0).max(1.0));
        let factor = (t * self.coefficient_of_variation()).exp();
        Interval { low: self.probability() / factor, high: self.probability() * factor }
    }
}
