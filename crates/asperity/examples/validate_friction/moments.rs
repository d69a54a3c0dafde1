//! Moments: how often 95 % intervals hold the truth.

use std::fmt::Write;

use asperity::stats::{Estimate, Moments, ProcessMoments};
use rayon::prelude::*;

use crate::planted::Planted;

const NAMES: [&str; 5] = ["mean", "std", "CoV", "skewness", "kurtosis"];

pub(crate) fn section(runs: usize) -> String {
    let mut text = String::from("## Moments\n\n");
    text.push_str("| process | mean | std | CoV | skewness | kurtosis |\n|---|---|---|---|---|---|\n");
    for law in ["normal:3,1", "beta:2.1,5"] {
        for window in [0.0, 2.4] {
            for (strips, periodic) in [(1, false), (3, false), (20, true)] {
                let planted = Planted { law, lengths: 200, strips, periodic, window };
                let began = std::time::Instant::now();
                let truth = truth(planted);
                let found: Vec<[Option<Estimate>; 5]> =
                    (0..runs as u64).into_par_iter().map(|run| estimates(planted, run)).collect();
                let _ = write!(text, "| {} ", planted.name());
                let _ = write!(text, "({:.1} s) ", began.elapsed().as_secs_f64());
                for (k, truth) in truth.iter().enumerate() {
                    let present: Vec<Estimate> = found.iter().filter_map(|e| e[k]).collect();
                    let share = |f: &dyn Fn(&Estimate) -> bool| {
                        present.iter().filter(|e| f(e)).count() as f64 / present.len() as f64
                    };
                    let spread = Moments::of_values(present.iter().map(|e| e.value));
                    let se = Moments::of_values(present.iter().map(|e| e.standard_error.powi(2))).mean.sqrt();
                    let df = Moments::of_values(present.iter().map(|e| e.degrees_of_freedom)).mean;
                    let _ = write!(
                        text,
                        "| {:.1} (↑{:.1} ↓{:.1}; n {:.0} b {:.2} r {:.2} ν {:.0}) ",
                        100.0 * share(&|e| e.interval.contains(*truth)),
                        100.0 * share(&|e| e.interval.low > *truth),
                        100.0 * share(&|e| e.interval.high < *truth),
                        100.0 * present.len() as f64 / found.len() as f64,
                        (spread.mean - truth) / spread.std,
                        se / spread.std,
                        df
                    );
                }
                text.push_str("|\n");
            }
        }
    }
    let _ = NAMES;
    text
}

fn estimates(planted: Planted, run: u64) -> [Option<Estimate>; 5] {
    let records = planted.records(run);
    let views: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
    let found = ProcessMoments::of(&views, planted.periodic);
    [found.mean, found.std, found.coefficient_of_variation, found.skewness, found.excess_kurtosis]
}

/// Moments of the process, of 4·10⁵ correlation lengths.
fn truth(planted: Planted) -> [f64; 5] {
    let long = Planted { lengths: 20_000, strips: 1, periodic: false, ..planted };
    let values: Vec<f64> = (0..20).into_par_iter().map(|run| long.records(1_000_000 + run)).flatten().flatten().collect();
    let m = Moments::of(&values);
    [m.mean, m.std, m.coefficient_of_variation(), m.skewness, m.excess_kurtosis]
}
