//! Several windows side by side on one strip do not count as several strips.

use asperity_base::correlation::{
    LengthFit, LengthSettings, RecordCorrelation, RecordEnds, RecordModel, Stationarity, WindowedRecords,
    cross_correlation, fit_families, fit_length, fit_record, fitted_length_interval, record_spectrum,
};
use asperity_base::distribution::Marginal;
use asperity_base::distribution::fit::{Family, fit};
use asperity_base::distribution::goodness::ProcessNull;
use asperity_base::random;
use asperity_base::stats::{Interval, Layout, Moments, ProcessEstimate, ProcessMoments, fraction_above};
use asperity_friction::statistics::FrictionStatistics;
use asperity_friction::strip::Record;

const TRACKS: usize = 3;

/// Returns a record of a distribution with the correlation e^{−lag/10}; a periodic record is continuous at its ends.
fn record(text: &str, n: usize, index: u64, periodic: bool) -> Vec<f64> {
    let marginal: Marginal = text.parse().unwrap();
    let phi = (-0.1_f64).exp();
    let noise = random::standard_normal(&mut random::stream(61, "lanes", index), n);
    let std = (1.0 - phi * phi).sqrt();
    let mut last = noise[0];
    if periodic {
        // State at the end of one turn from zero, with all previous turns added.
        last = noise.iter().fold(0.0, |last, e| phi * last + std * e) / (1.0 - phi.powi(n as i32));
    }
    let mut values = Vec::with_capacity(n);
    for (place, e) in noise.iter().enumerate() {
        if periodic || place > 0 {
            last = phi * last + std * e;
        }
        values.push(marginal.translate(last));
    }
    values
}

/// Returns strips of one track, and the same strips with copies side by side.
fn copied(strips: usize, n: usize, seed: u64) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let single: Vec<Vec<f64>> =
        (0..strips as u64).map(|strip| record("beta:2.1,5", n, 1000 * seed + strip, false)).collect();
    let copies = single.iter().flat_map(|track| vec![track.clone(); TRACKS]).collect();
    (single, copies)
}

fn views(records: &[Vec<f64>]) -> Vec<&[f64]> {
    records.iter().map(Vec::as_slice).collect()
}

fn close(a: f64, b: f64, what: &str) {
    assert!((a - b).abs() <= 1e-6 * a.abs().max(b.abs()), "{what}: {a} {b}");
}

fn same(a: Interval, b: Interval, what: &str) {
    close(a.low, b.low, what);
    close(a.high, b.high, what);
}

fn same_estimate(a: Option<ProcessEstimate>, b: Option<ProcessEstimate>, what: &str) {
    assert_eq!(a.is_some(), b.is_some(), "{what}");
    if let (Some(a), Some(b)) = (a, b) {
        close(a.standard_error, b.standard_error, what);
        close(a.degrees_of_freedom, b.degrees_of_freedom, what);
        same(a.interval, b.interval, what);
    }
}

fn layout(periodic: bool) -> Layout {
    Layout { periodic, tracks: TRACKS }
}

#[test]
fn copies_side_by_side_have_the_statistics_of_one_of_them() {
    for (strips, periodic) in [(1, false), (4, true), (24, false)] {
        let (single, copies) = copied(strips, 2400 / strips, strips as u64);
        let (single, copies) = (views(&single), views(&copies));
        let (a, b) = (ProcessMoments::new(&single, periodic), ProcessMoments::new(&copies, layout(periodic)));
        same_estimate(a.mean, b.mean, "mean");
        same_estimate(a.std, b.std, "std");
        same_estimate(a.coefficient_of_variation, b.coefficient_of_variation, "CoV");
        same_estimate(a.skewness, b.skewness, "skewness");
        same_estimate(a.excess_kurtosis, b.excess_kurtosis, "kurtosis");
        close(a.effective_size, b.effective_size, "effective size");
        let share = |records: &[&[f64]], layout: Layout| fraction_above(records, 0.5, layout).1;
        same_estimate(share(&single, periodic.into()), share(&copies, layout(periodic)), "share");
        let family = Family::Beta { low: 0.0, high: 1.0 };
        let parameters =
            |records: &[&[f64]], layout: Layout| fit(family, &records.concat()).unwrap().estimates(records, layout);
        let (of_single, of_copies) = (parameters(&single, periodic.into()), parameters(&copies, layout(periodic)));
        for (a, b) in of_single.iter().zip(&of_copies) {
            same_estimate(a.estimate, b.estimate, a.name);
        }
        let jackknife = |records: &[&[f64]], tracks: usize| {
            let estimate = RecordCorrelation::estimate(records, 1.0, 60).unwrap();
            let fitted = fit_record(&estimate, RecordModel::Exponential).unwrap();
            fitted_length_interval(records, tracks, 1.0, 60, &fitted).unwrap()
        };
        same(jackknife(&single, 1), jackknife(&copies, TRACKS), "jackknife");
        let cross = |records: &[&[f64]], tracks: usize| {
            let pairs: Vec<(&[f64], &[f64])> = records.iter().map(|r| (&r[..r.len() - 3], &r[3..])).collect();
            cross_correlation(&pairs, tracks, 1.0, 0).unwrap().interval
        };
        same(cross(&single, 1), cross(&copies, TRACKS), "cross-correlation");
        let (a, b) = (Stationarity::new(&single, 1, 1.0).unwrap(), Stationarity::new(&copies, TRACKS, 1.0).unwrap());
        close(a.trend.p_value, b.trend.p_value, "trend");
        close(a.variance_change.p_value, b.variance_change.p_value, "variance");
        let spectrum =
            |records: &[&[f64]], tracks: usize| record_spectrum(records, tracks, 1.0, RecordEnds::Free).unwrap();
        let (a, b) = (spectrum(&single, 1), spectrum(&copies, TRACKS));
        for bin in 0..a.density.len() {
            close(a.low[bin], b.low[bin], "spectrum");
            close(a.degrees_of_freedom[bin], b.degrees_of_freedom[bin], "spectrum");
        }
    }
}

fn length(records: &[Vec<f64>], tracks: usize, ends: RecordEnds) -> LengthFit {
    let channel = WindowedRecords { window_m: 0.0, step_m: 1.0, cell_m: 0.0, tracks, records: views(records) };
    fit_length(&[channel], RecordModel::Exponential, LengthSettings { ends, ..LengthSettings::default() }).unwrap()
}

#[test]
fn the_length_of_copies_side_by_side_has_the_interval_of_one_of_them() {
    for (strips, n, ends) in [
        (1, 150, RecordEnds::Free),
        (1, 2400, RecordEnds::Free),
        (4, 600, RecordEnds::Periodic),
        (24, 100, RecordEnds::Free),
    ] {
        let (single, copies) = copied(strips, n, 100 + strips as u64);
        let (a, b) = (length(&single, 1, ends), length(&copies, TRACKS, ends));
        close(a.length_m, b.length_m, "length");
        same(a.interval, b.interval, "length");
        assert_eq!((a.pieces, a.track_redundancy), (b.pieces, 1.0));
        close(b.track_redundancy, TRACKS as f64, "track redundancy");
        let families = |records: &[Vec<f64>], tracks: usize| {
            let channel = WindowedRecords { window_m: 0.0, step_m: 1.0, cell_m: 0.0, tracks, records: views(records) };
            fit_families(&[channel], LengthSettings { ends, ..LengthSettings::default() }).unwrap()
        };
        let (a, b) = (families(&single, 1), families(&copies, TRACKS));
        assert_eq!((a.chosen.model, a.told_apart()), (b.chosen.model, b.told_apart()));
        close(a.evidence(), b.evidence(), "evidence");
    }
}

#[test]
fn independent_tracks_count_as_strips() {
    let tracks = 4;
    let (mut mean, mut std, mut fitted, mut curve) = (vec![], vec![], vec![], vec![]);
    let runs = 20;
    for run in 0..runs {
        let all: Vec<Vec<f64>> =
            (0..8 * tracks as u64).map(|index| record("normal:3,1", 400, 5000 + 100 * run + index, false)).collect();
        let first: Vec<Vec<f64>> = all.iter().step_by(tracks).cloned().collect();
        let (one, four) = (views(&first), views(&all));
        let of = |records: &[&[f64]], tracks: usize| ProcessMoments::new(records, Layout { periodic: false, tracks });
        let (a, b) = (of(&one, 1), of(&four, tracks));
        mean.push(b.mean.unwrap().standard_error / a.mean.unwrap().standard_error);
        std.push(b.std.unwrap().standard_error / a.std.unwrap().standard_error);
        let width = |fit: LengthFit| (fit.interval.high / fit.interval.low).ln();
        fitted.push(width(length(&all, tracks, RecordEnds::Free)) / width(length(&first, 1, RecordEnds::Free)));
        let jackknife = |records: &[&[f64]], tracks: usize| {
            let estimate = RecordCorrelation::estimate(records, 1.0, 60).unwrap();
            let fit = fit_record(&estimate, RecordModel::Exponential).unwrap();
            let interval = fitted_length_interval(records, tracks, 1.0, 60, &fit).unwrap();
            interval.high - interval.low
        };
        curve.push(jackknife(&four, tracks) / jackknife(&one, 1));
    }
    for (what, ratios, error) in [("mean", mean, 0.2), ("std", std, 0.2), ("ℓ", fitted, 0.2), ("curve", curve, 0.3)] {
        let logarithms: Vec<f64> = ratios.iter().map(|ratio: &f64| ratio.ln()).collect();
        let found = Moments::new(&logarithms);
        println!("{what}: {} ± {}", found.mean.exp(), found.std);
        // A standard error from some thirty blocks has an error of 1/√60 = 13 %, a quotient of two 18 %. For jackknives
        // from twenty parts of correlated curves it is some 30 %. The bound is four errors of the mean of 20
        // logarithms, and a twentieth.
        assert!((found.mean - 0.5_f64.ln()).abs() < 4.0 * error / (runs as f64).sqrt() + 0.05, "{what}: {found:?}");
    }
}

fn of_values(friction: Vec<f64>) -> Record {
    let n = friction.len();
    Record {
        position_m: (0..n).map(|i| i as f64).collect(),
        contact_cells: vec![100.0; n],
        area_m2: vec![1.0; n],
        friction_force_n: friction.clone(),
        load_n: vec![1.0; n],
        friction,
    }
}

#[test]
#[ignore = "slow"]
fn the_tail_and_the_distributions_of_copies_equal_those_of_one_of_them() {
    let (single, copies) = copied(20, 1000, 300);
    let statistics = |records: Vec<Vec<f64>>, tracks: usize| {
        let records: Vec<Record> = records.into_iter().map(of_values).collect();
        FrictionStatistics::new(&records, 1e-3, Layout { periodic: false, tracks }, 1).unwrap()
    };
    let (a, b) = (statistics(single, 1), statistics(copies, TRACKS));
    for (a, b) in a.marginals.fits.iter().zip(&b.marginals.fits) {
        assert_eq!(a.family, b.family);
    }
    let (a, b) = (a.tail.unwrap(), b.tail.unwrap());
    assert_eq!(a.clusters, b.clusters);
    close(a.shape_interval.low, b.shape_interval.low, "tail");
    close(a.shape_interval.high, b.shape_interval.high, "tail");
    for (a, b) in a.return_levels.iter().zip(&b.return_levels) {
        close(a.mu, b.mu, "return level");
        assert_eq!(a.interval.is_some(), b.interval.is_some());
        if let (Some(a), Some(b)) = (a.interval, b.interval) {
            same(a, b, "return level");
        }
    }
}

/// Returns the largest distance of p-values from the uniform distribution.
fn from_uniform(mut p: Vec<f64>) -> f64 {
    p.sort_by(f64::total_cmp);
    let n = p.len() as f64;
    let distance = |(i, p): (usize, &f64)| f64::max((p - i as f64 / n).abs(), (p - (i as f64 + 1.0) / n).abs());
    p.iter().enumerate().map(distance).fold(0.0, f64::max)
}

#[test]
#[ignore = "slow"]
fn p_values_of_a_correct_distribution_are_uniform_on_periodic_strips_and_on_copied_tracks() {
    let runs = 150_u64;
    let p = |seed: u64, strips: usize, n: usize, periodic: bool, tracks: usize, known: Layout| -> Vec<[f64; 2]> {
        (0..runs)
            .map(|run| {
                let of = |strip: usize| record("normal:3,1", n, 100_000 * seed + 100 * run + strip as u64, periodic);
                let records: Vec<Vec<f64>> = (0..strips).flat_map(|strip| vec![of(strip); tracks]).collect();
                let values = records.concat();
                let null = ProcessNull::new(&views(&records), known, 99, run).unwrap();
                let found = null.goodness(&fit(Family::Normal, &values).unwrap(), &values).unwrap();
                [found.kolmogorov_smirnov.p_value, found.anderson_darling.unwrap().p_value]
            })
            .collect()
    };
    let distances = |p: &[[f64; 2]]| [0, 1].map(|k| from_uniform(p.iter().map(|p| p[k]).collect()));
    // The 99.9 % quantile of Kolmogorov's distribution, plus the step of p-values of 99 draws.
    let allowed = 1.95 / (runs as f64).sqrt() + 0.01;
    let periodic = distances(&p(1, 8, 120, true, 1, true.into()));
    let copies = distances(&p(2, 6, 200, true, TRACKS, Layout { periodic: true, tracks: TRACKS }));
    println!("{periodic:?} {copies:?} of {allowed}");
    assert!(periodic.iter().chain(&copies).all(|distance| *distance < allowed), "{periodic:?} {copies:?}");
    // Copies that count as strips are rejected far too often.
    let naive = p(2, 6, 200, true, TRACKS, true.into());
    let refused = naive.iter().filter(|p| p[1] <= 0.1).count();
    assert!(refused > 40, "{refused} of {runs}");
}
