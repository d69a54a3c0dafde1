//! Random choices of test parameters.

use asperity_base::random::{self, Stream};
use rand::RngExt;

/// Generator of random choices.
#[derive(Debug)]
pub struct Choices {
    /// Underlying random stream.
    pub stream: Stream,
}

impl Choices {
    /// Creates the generator of sample `index` of the named `stage` under `seed`.
    pub fn new(seed: u64, stage: &str, index: u64) -> Self {
        Self { stream: random::stream(seed, stage, index) }
    }

    /// Returns a number uniform between two limits.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.stream.random::<f64>()
    }

    /// Returns a number between 10^low and 10^high, uniform in its logarithm.
    pub fn decades(&mut self, low: f64, high: f64) -> f64 {
        10.0_f64.powf(self.between(low, high))
    }

    /// Returns one of equally probable choices.
    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.stream.random::<f64>() * choices.len() as f64) as usize]
    }
}
