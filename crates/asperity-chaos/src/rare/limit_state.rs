//! Evaluation of a limit state in parallel batches.

use asperity_base::blocks::{self, Task};
use asperity_base::monitor::{Cancelled, Monitor};

use super::RareError;

/// Limit state g with its number of evaluations.
pub(super) struct LimitState<'a, G> {
    g: &'a G,
    task: Task<'a>,
    evaluations: usize,
    most: usize,
}

impl<'a, G> LimitState<'a, G> {
    pub(super) fn new(g: &'a G, most: usize, monitor: &'a dyn Monitor) -> Self {
        Self { g, task: Task::new(monitor, "small probability", most), evaluations: 0, most }
    }

    /// Returns the number of evaluations so far.
    pub(super) fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Returns the number of evaluations that the budget still allows.
    pub(super) fn left(&self) -> usize {
        self.most.saturating_sub(self.evaluations)
    }
}

impl<G, E: Send> LimitState<'_, G>
where
    G: Fn(&[f64]) -> Result<f64, E> + Sync,
{
    /// Returns g at the points, in their order.
    ///
    /// # Errors
    /// g fails or is NaN at a point, or the monitor cancels.
    pub(super) fn evaluate(&mut self, points: &[Vec<f64>]) -> Result<Vec<f64>, RareError<E>> {
        self.evaluations += points.len();
        blocks::map(0..points.len(), |index| match self.task.step(|| (self.g)(&points[index])) {
            Err(Cancelled) => Err(RareError::Cancelled),
            Ok(Err(error)) => Err(RareError::Evaluation(error)),
            Ok(Ok(value)) if value.is_nan() => Err(RareError::NotANumber { point: points[index].clone() }),
            Ok(Ok(value)) => Ok(value),
        })
    }
}
