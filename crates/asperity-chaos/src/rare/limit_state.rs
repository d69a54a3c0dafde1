//! Evaluation of a limit state in parallel batches.

use asperity_base::blocks::Task;
use asperity_base::monitor::Monitor;

use super::error::RareError;

/// Limit state g with its number of evaluations.
pub(super) struct LimitState<'a, E> {
    g: &'a (dyn Fn(&[f64]) -> Result<f64, E> + Sync),
    task: Task<'a>,
    evaluations: usize,
    most: usize,
}

impl<'a, E: Send> LimitState<'a, E> {
    pub(super) fn new(g: &'a (dyn Fn(&[f64]) -> Result<f64, E> + Sync), most: usize, monitor: &'a dyn Monitor) -> Self {
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

    /// Returns g at the points, in their order.
    ///
    /// # Errors
    /// g fails or is NaN at a point, or the monitor cancels.
    pub(super) fn evaluate(&mut self, points: &[Vec<f64>]) -> Result<Vec<f64>, RareError<E>> {
        self.evaluations += points.len();
        self.task.map(points.len(), |index| match (self.g)(&points[index]) {
            Err(error) => Err(RareError::Evaluation(error)),
            Ok(value) if value.is_nan() => Err(RareError::NotANumber { point: points[index].clone() }),
            Ok(value) => Ok(value),
        })
    }
}
