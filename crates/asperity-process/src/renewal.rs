//! Process with jumps at the points of a Poisson process.

use rand_distr::{Distribution, Exp1, StandardNormal};

use super::Cell;
use asperity_base::random::Stream;

/// Mean number of intervals between two points of a record above which they are not drawn one by one.
const MOST_INTERVALS: f64 = 1e4;

/// Intervals of exponential length with mean ℓ and an independent value in each.
///
/// Two points a distance s apart have the same value if no jump lies between them, with probability e^{−s/ℓ}, and
/// independent values otherwise. This probability is the correlation. The exponential distribution is memoryless, so
/// the process is stationary from s = 0 on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Renewal {
    mean_length: f64,
    /// End of the present interval, and m in it.
    end: f64,
    m: f64,
    /// Distance between the points of a record, and number of the next point.
    step: f64,
    next: usize,
}

impl Renewal {
    pub(super) fn new(mean_length: f64, step: f64) -> Self {
        Self { mean_length, end: 0.0, m: 0.0, step, next: 0 }
    }

    /// Returns the next interval; `value` computes m from a standard normal value.
    #[inline]
    pub(super) fn cell(&mut self, rng: &mut Stream, value: impl FnOnce(f64) -> f64) -> Cell {
        self.m = value(StandardNormal.sample(rng));
        let fraction: f64 = Exp1.sample(rng);
        let length = self.mean_length * fraction;
        self.end += length;
        Cell { end: self.end, length, left: self.m, right: self.m }
    }

    /// Returns m at the next point of a record.
    pub(super) fn next_value(&mut self, rng: &mut Stream, mut value: impl FnMut(f64) -> f64) -> f64 {
        let place = self.next as f64 * self.step;
        self.next += 1;
        if place - self.end > MOST_INTERVALS * self.mean_length {
            // The exponential distribution is memoryless: the rest of the interval at this place is distributed like a new one.
            self.end = place;
            self.cell(rng, value);
        } else {
            while place >= self.end {
                self.cell(rng, &mut value);
            }
        }
        self.m
    }
}
