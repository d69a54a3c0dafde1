//! Intervals of crossings cover the crossings computed from many more trajectories.
//!
//! `ASPERITY_REPLICATES` sets the number of replicates; the default is small. `docs/vibration-fluctuation.md` reports
//! the coverage of 1,000. The unit tests of the sweep use 1,000 replicates of a closed form.

use asperity_base::monitor::Silent;
use asperity_process::{FrictionProcess, ProcessModel};
use asperity_results::CrossingResult;
use asperity_vibration::{EnsembleSettings, Oscillator, damping_sweep};
use rayon::prelude::*;

const LEVELS: [f64; 3] = [0.95, 0.5, 0.05];
const PATHS: usize = 100;
const DURATION: f64 = 60.0;

fn crossings(paths: usize, seed: u64) -> Vec<CrossingResult> {
    let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.1, 0.003).unwrap();
    let process = FrictionProcess::new(ProcessModel::new("beta:2.1,5".parse().unwrap(), 0.001, 0.04)).unwrap();
    let settings = EnsembleSettings { sample_capacity: 0, ..EnsembleSettings::new(paths, DURATION, seed) };
    let sweep = damping_sweep(&oscillator, &[0.15, 0.3], &process, &settings, &Silent).unwrap();
    sweep.crossings(&oscillator, &process, &LEVELS, &settings, &Silent).unwrap()
}

#[test]
#[ignore = "slow"]
fn intervals_of_crossings_cover_the_crossings_of_many_more_trajectories() {
    let replicates: usize = std::env::var("ASPERITY_REPLICATES").map_or(8, |count| count.parse().unwrap());
    // With 1,000 replicates, the error of these crossings is a fourteenth of the error of one replicate.
    let wanted = crossings(PATHS * replicates.clamp(40, 1000) / 5, 0);
    let found: Vec<Vec<CrossingResult>> =
        (1..=replicates as u64).into_par_iter().map(|seed| crossings(PATHS, seed)).collect();
    for (k, truth) in wanted.iter().map(|crossing| crossing.damping_ratio.unwrap()).enumerate() {
        let intervals: Vec<[f64; 2]> =
            found.iter().map(|crossings| crossings[k].damping_ratio_interval.unwrap()).collect();
        let covered = intervals.iter().filter(|[low, high]| *low <= truth && truth <= *high).count();
        let width = intervals.iter().map(|[low, high]| high - low).sum::<f64>() / replicates as f64;
        println!("level {}: {truth:.5}, covered by {covered} of {replicates}, mean width {width:.5}", LEVELS[k]);
        // Four standard deviations of a binomial count below 93 %.
        let least = 0.93 - 4.0 * (0.93 * 0.07 / replicates as f64).sqrt();
        assert!(covered as f64 >= least * replicates as f64, "level {}: {covered} of {replicates}", LEVELS[k]);
    }
}
