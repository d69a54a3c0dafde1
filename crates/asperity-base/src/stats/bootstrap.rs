//! Bootstrap intervals, for independent values and for correlated records.

use rand::RngExt;
use rayon::prelude::*;

use super::{Interval, StatsError, quantile_sorted};
use crate::random::{self, Stream};

/// How values are drawn again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resampling {
    /// One by one, with replacement: for independent values.
    Independent,
    /// In overlapping blocks of this many neighbours (Künsch 1989): for a correlated record, with blocks of at least a
    /// few correlation times.
    MovingBlocks {
        /// Values in a block.
        length: usize,
    },
}

/// A percentile bootstrap.
///
/// # References
/// Efron & Tibshirani, *An Introduction to the Bootstrap*, Chapman & Hall 1993, ch. 13; Künsch, *Ann. Stat.* **17** (1989)
/// 1217, <https://doi.org/10.1214/aos/1176347265>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// Number of resamples.
    pub resamples: usize,
    /// Confidence level of the interval, between 0 and 1.
    pub level: f64,
    /// How values are drawn again.
    pub resampling: Resampling,
    /// Seed; resample `i` uses the stream (seed, "bootstrap", i).
    pub seed: u64,
}

impl Bootstrap {
    /// 95 % intervals from 1,000 resamples.
    pub fn new(resampling: Resampling, seed: u64) -> Self {
        Self { resamples: 1000, level: 0.95, resampling, seed }
    }

    /// The percentile interval of a statistic of the values. Resamples on which the statistic is NaN are left out.
    ///
    /// # Errors
    /// Fewer than two values, a block longer than the record, or a statistic that is NaN on every resample.
    pub fn interval(&self, values: &[f64], statistic: impl Fn(&[f64]) -> f64 + Sync) -> Result<Interval, StatsError> {
        self.percentiles(self.replicates(values, statistic)?)
    }

    fn percentiles(&self, replicates: Vec<f64>) -> Result<Interval, StatsError> {
        let replicates = super::sorted_present(replicates);
        if replicates.is_empty() {
            return Err(StatsError::TooFew { statistic: "a bootstrap interval", n: 0, wanted: 1 });
        }
        let tail = 0.5 * (1.0 - self.level);
        Ok(Interval { low: quantile_sorted(&replicates, tail), high: quantile_sorted(&replicates, 1.0 - tail) })
    }

    /// The percentile interval of a statistic of all values of `records` with equal steps. Blocks are drawn from all of them,
    /// each from one, so that none reaches across an end; a record shorter than a block is a block of its own.
    ///
    /// From 200 correlation lengths, with blocks of two correlation times, its 95 % intervals of mean and standard deviation were
    /// counted to hold in 84 to 91 % of the runs; those of [`super::ProcessMoments`] in 93 to 96 %.
    ///
    /// # Errors
    /// Fewer than two values, a level or a block length out of range, or a statistic that is NaN on every resample.
    pub fn interval_of_records(
        &self,
        records: &[&[f64]],
        statistic: impl Fn(&[f64]) -> f64 + Sync,
    ) -> Result<Interval, StatsError> {
        let total: usize = records.iter().map(|record| record.len()).sum();
        let block = self.block(total)?;
        let starts = |record: &[f64]| (record.len() + 1).saturating_sub(block).max(usize::from(!record.is_empty()));
        let all: usize = records.iter().map(|record| starts(record)).sum();
        let resample = |index: usize| {
            let mut stream = random::stream(self.seed, "bootstrap", index as u64);
            let mut drawn = Vec::with_capacity(total + block);
            while drawn.len() < total {
                let mut start = stream.random_range(0..all);
                for record in records {
                    if start < starts(record) {
                        drawn.extend_from_slice(&record[start..(start + block).min(record.len())]);
                        break;
                    }
                    start -= starts(record);
                }
            }
            drawn.truncate(total);
            statistic(&drawn)
        };
        self.percentiles((0..self.resamples).into_par_iter().map(resample).collect())
    }

    /// The standard deviation of the statistic over the resamples.
    ///
    /// # Errors
    /// As [`Bootstrap::interval`].
    pub fn standard_error(&self, values: &[f64], statistic: impl Fn(&[f64]) -> f64 + Sync) -> Result<f64, StatsError> {
        Ok(super::Moments::of(&self.replicates(values, statistic)?).sample_std())
    }

    /// The statistic of every resample, in order.
    ///
    /// # Errors
    /// Fewer than two values, a level or a block length out of range.
    pub fn replicates(&self, values: &[f64], statistic: impl Fn(&[f64]) -> f64 + Sync) -> Result<Vec<f64>, StatsError> {
        let block = self.block(values.len())?;
        let resample = |index: usize| {
            let mut stream = random::stream(self.seed, "bootstrap", index as u64);
            statistic(&draw(&mut stream, values, block))
        };
        Ok((0..self.resamples).into_par_iter().map(resample).collect())
    }

    /// Length of a block of `n` values.
    fn block(&self, n: usize) -> Result<usize, StatsError> {
        if n < 2 {
            return Err(StatsError::TooFew { statistic: "a bootstrap", n, wanted: 2 });
        }
        if !(self.level > 0.0 && self.level < 1.0) {
            let wanted = "between 0 and 1";
            return Err(StatsError::Parameter { parameter: "confidence level", value: self.level, wanted });
        }
        let block = match self.resampling {
            Resampling::Independent => 1,
            Resampling::MovingBlocks { length } => length,
        };
        if block == 0 || block > n {
            let wanted = "between 1 and the number of values";
            return Err(StatsError::Parameter { parameter: "block length", value: block as f64, wanted });
        }
        Ok(block)
    }
}

/// Blocks drawn with replacement and laid end to end until there are as many values as before.
fn draw(stream: &mut Stream, values: &[f64], block: usize) -> Vec<f64> {
    let mut drawn = Vec::with_capacity(values.len() + block);
    while drawn.len() < values.len() {
        let start = stream.random_range(0..=values.len() - block);
        drawn.extend_from_slice(&values[start..start + block]);
    }
    drawn.truncate(values.len());
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Moments;

    fn mean(values: &[f64]) -> f64 {
        values.iter().sum::<f64>() / values.len() as f64
    }

    #[test]
    fn the_independent_bootstrap_finds_the_standard_error_of_the_mean() {
        let values = random::standard_normal(&mut random::stream(1, "values", 0), 400);
        let bootstrap = Bootstrap::new(Resampling::Independent, 7);
        let (moments, interval) = (Moments::of(&values), bootstrap.interval(&values, mean).unwrap());
        // The bootstrap's exact standard error is std/√n; 1,000 resamples know it to 1/√2000 = 2.2 %.
        let error = bootstrap.standard_error(&values, mean).unwrap();
        assert!((error / (moments.std / 20.0) - 1.0).abs() < 4.0 * 0.022, "{error}");
        // An end of the interval is a 2.5 % quantile of 1,000 replicates: ±√(.025·.975/1000)/φ(1.96) = .085 errors.
        assert!(((interval.high - moments.mean) / error - super::super::NORMAL_95).abs() < 4.0 * 0.085);
        assert!(((moments.mean - interval.low) / error - super::super::NORMAL_95).abs() < 4.0 * 0.085);
    }

    #[test]
    fn blocks_see_the_correlation_that_single_draws_miss() {
        // The moving sum of 10 white values: τ = 1 + 2 Σ (1 − k/10) = 10, so the mean's error is √10 times larger.
        let white = random::standard_normal(&mut random::stream(2, "values", 0), 20_009);
        let record: Vec<f64> = white.windows(10).map(|w| w.iter().sum()).collect();
        let error = |resampling| Bootstrap::new(resampling, 3).standard_error(&record, mean).unwrap();
        let ratio = error(Resampling::MovingBlocks { length: 200 }) / error(Resampling::Independent);
        // 100 blocks know a variance to √(2/100) = 14 %, so the error to 7 %; resampling adds 3 %, the bias is 1.6 %.
        assert!((ratio / 10_f64.sqrt() - 1.0).abs() < 0.016 + 3.0 * 0.077, "{ratio}");
    }

    #[test]
    fn one_record_is_drawn_as_its_values_are_and_blocks_stay_within_records() {
        let values = random::standard_normal(&mut random::stream(1, "values", 2), 60);
        let bootstrap = Bootstrap::new(Resampling::MovingBlocks { length: 7 }, 9);
        let whole = bootstrap.interval_of_records(&[&values], mean).unwrap();
        assert_eq!(whole, bootstrap.interval(&values, mean).unwrap());
        // Records of one value each: every block is a run of equal values, cut at the end alone.
        let (short, long) = (vec![5.0; 3], vec![-1.0; 40]);
        let runs = |drawn: &[f64]| drawn.chunk_by(|a, b| a == b).map(|run| (run[0], run.len())).collect::<Vec<_>>();
        let sound = |drawn: &[f64]| {
            let runs = runs(drawn);
            let last = runs.len() - 1;
            let whole =
                |(i, (value, n)): (usize, &(f64, usize))| i == last || n % if *value > 0.0 { 3 } else { 7 } == 0;
            f64::from(u8::from(runs.iter().enumerate().all(whole)))
        };
        let all = bootstrap.interval_of_records(&[&short, &long, &[]], sound).unwrap();
        assert_eq!((all.low, all.high), (1.0, 1.0));
    }

    #[test]
    fn intervals_do_not_depend_on_the_number_of_threads() {
        let values = random::standard_normal(&mut random::stream(1, "values", 1), 50);
        let bootstrap = Bootstrap::new(Resampling::MovingBlocks { length: 5 }, 9);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let three = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let run = || bootstrap.interval(&values, mean).unwrap();
        assert_eq!(one.install(run), three.install(run));
    }

    #[test]
    fn senseless_requests_are_refused() {
        let blocks = |length| Bootstrap::new(Resampling::MovingBlocks { length }, 0);
        assert!(blocks(0).interval(&[1.0, 2.0], mean).is_err());
        assert!(blocks(3).interval(&[1.0, 2.0], mean).is_err());
        assert!(blocks(1).interval(&[1.0], mean).is_err());
        assert!(blocks(1).interval(&[1.0, 2.0], |_| f64::NAN).is_err());
    }
}
