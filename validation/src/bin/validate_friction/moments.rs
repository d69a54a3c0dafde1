//! Moments: coverage of the 95 % intervals.

use std::fmt::Write;

use asperity::random;
use asperity::stats::{
    Interval, Moments, ProcessEstimate, ProcessMoments, correlation_time, quantile_sorted, sorted_present,
};
use rand::RngExt;
use rayon::prelude::*;

use crate::planted::Planted;

/// Number of correlation lengths in the records of a run.
const LENGTHS: usize = 200;

pub(crate) fn section(runs: usize) -> String {
    let mut text = format!(
        "## Moments\n\n{runs} runs of {LENGTHS} ℓ each of a translated Ornstein–Uhlenbeck process, ten steps to ℓ, in 1, 3 and 20 \
         records, without a window or averaged over a window W. A cell states the percentage of the 95 % intervals that contain the true value, in \
         brackets the percentages above and below it, and the percentage of runs that have an interval if some have none. The true values \
         are those of the distribution, or with a window the moments of a record of 400,000 ℓ.\n\n\
         | process | mean | std | CoV | skewness | kurtosis |\n|---|---|---|---|---|---|\n"
    );
    for distribution in ["normal:3,1", "beta:2.1,5"] {
        for window in [0.0, 0.5, 2.4] {
            for (strips, periodic) in [(1, false), (3, false), (3, true), (20, false), (20, true)] {
                let planted = Planted { distribution, lengths: LENGTHS, strips, periodic, window };
                row(&mut text, planted, runs);
            }
        }
    }
    text.push_str(
        "\nThe moving-block bootstrap (200 resamples, percentiles, blocks of twice the correlation time), for \
         comparison:\n\n| process | mean | std |\n|---|---|---|\n",
    );
    for (strips, distribution) in [(1, "normal:3,1"), (20, "normal:3,1"), (1, "beta:2.1,5"), (20, "beta:2.1,5")] {
        bootstrap(
            &mut text,
            Planted { distribution, lengths: LENGTHS, strips, periodic: false, window: 0.0 },
            runs.div_ceil(4),
        );
    }
    text
}

fn row(text: &mut String, planted: Planted, runs: usize) {
    let truth = truth(planted);
    let found: Vec<[Option<ProcessEstimate>; 5]> =
        (0..runs as u64).into_par_iter().map(|run| estimates(planted, run)).collect();
    let _ = write!(text, "| {} ", planted.name());
    for (k, truth) in truth.iter().enumerate() {
        let present: Vec<Interval> = found.iter().filter_map(|e| e[k]).map(|e| e.interval).collect();
        let _ = write!(text, "| {} ", coverage(&present, *truth));
        let percentage = 100.0 * present.len() as f64 / found.len() as f64;
        if percentage < 99.5 {
            let _ = write!(text, "of {percentage:.0} % ");
        }
    }
    text.push_str("|\n");
}

/// Formats the percentages of the intervals that contain the truth, lie above it, and lie below it.
fn coverage(intervals: &[Interval], truth: f64) -> String {
    let percentage = |f: &dyn Fn(&Interval) -> bool| {
        100.0 * intervals.iter().filter(|interval| f(interval)).count() as f64 / intervals.len() as f64
    };
    let covering = percentage(&|i| i.contains(truth));
    let [above, below] = [percentage(&|i| i.low > truth), percentage(&|i| i.high < truth)];
    format!("{covering:.1} % ({above:.1}, {below:.1})")
}

fn estimates(planted: Planted, run: u64) -> [Option<ProcessEstimate>; 5] {
    let records = planted.records(run);
    let views: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
    let found = ProcessMoments::new(&views, planted.periodic);
    [found.mean, found.std, found.coefficient_of_variation, found.skewness, found.excess_kurtosis]
}

fn truth(planted: Planted) -> [f64; 5] {
    if planted.window == 0.0 {
        let distribution = planted.distribution();
        return [
            distribution.mean(),
            distribution.std(),
            distribution.std() / distribution.mean(),
            distribution.skewness(),
            distribution.excess_kurtosis(),
        ];
    }
    let long = Planted { lengths: 20_000, strips: 1, periodic: false, ..planted };
    let values: Vec<f64> = (0..20).into_par_iter().flat_map(|run| long.records(1_000_000 + run).concat()).collect();
    let m = Moments::new(&values);
    [m.mean, m.std, m.coefficient_of_variation(), m.skewness, m.excess_kurtosis]
}

/// Returns the 95 % percentile interval of 200 resamples in moving blocks, which stay within records; `None` if a block is longer than
/// all records together.
fn moving_blocks(records: &[&[f64]], block: usize, seed: u64, statistic: fn(Moments) -> f64) -> Option<Interval> {
    let total: usize = records.iter().map(|record| record.len()).sum();
    let starts = |record: &[f64]| (record.len() + 1).saturating_sub(block).max(usize::from(!record.is_empty()));
    let all: usize = records.iter().map(|record| starts(record)).sum();
    let resample = |index: u64| {
        let mut stream = random::stream(seed, "bootstrap", index);
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
        statistic(Moments::new(&drawn))
    };
    let replicates = sorted_present((0..200).map(resample));
    let end = |probability: f64| quantile_sorted(&replicates, probability);
    (block <= total && !replicates.is_empty()).then(|| Interval { low: end(0.025), high: end(0.975) })
}

fn bootstrap(text: &mut String, planted: Planted, runs: usize) {
    let truth = truth(planted);
    let found: Vec<[Option<Interval>; 2]> = (0..runs as u64)
        .into_par_iter()
        .map(|run| {
            let records = planted.records(run);
            let views: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
            let times = views.iter().filter_map(|record| correlation_time(record).ok());
            let blocks = times.map(|t| ((2.0 * t.steps).ceil() as usize).clamp(1, (t.n / 2).max(1)));
            let block = blocks.max().unwrap_or(1);
            [moving_blocks(&views, block, run, |m| m.mean), moving_blocks(&views, block, run, |m| m.std)]
        })
        .collect();
    let column = |k: usize| coverage(&found.iter().filter_map(|f| f[k]).collect::<Vec<_>>(), truth[k]);
    let _ = writeln!(text, "| {} | {} | {} |", planted.name(), column(0), column(1));
}
