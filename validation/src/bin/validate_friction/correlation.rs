//! Correlation lengths, the window study, spectra, stationarity and cross-correlation.

use std::fmt::Write;

use asperity::correlation::{
    LengthFit, LengthSettings, RecordEnds, RecordModel, Stationarity, WindowedRecords, cross_correlation, fit_length,
};
use asperity::distribution::Marginal;
use asperity::random;
use asperity::stats::wilson_interval;
use rayon::prelude::*;

use super::Result;
use super::field::{Field, averaged};

/// Returns the section on correlation, as Markdown.
pub(crate) fn section(runs: usize) -> Result<String> {
    let mut text = String::from("## Correlation\n");
    text += &lengths(runs)?;
    text += &window_study(runs)?;
    text += &drifts(runs)?;
    text += &cross(runs)?;
    Ok(text)
}

/// Returns the marginal distributions of the processes, with their names; `None` is normal.
fn marginals() -> Result<Vec<(&'static str, Option<Marginal>)>> {
    Ok(vec![
        ("normal", None),
        ("Beta(2.1, 5)", Some(Marginal::beta(2.1, 5.0, 0.0, 1.0)?)),
        ("lognormal, skewness 1.75", Some(Marginal::lognormal(0.0, 0.5, 0.0)?)),
    ])
}

/// Layouts of 200 ℓ in strips: name, number of strips, and ends.
const LAYOUTS: [(&str, usize, RecordEnds); 5] = [
    ("1 free", 1, RecordEnds::Free),
    ("3 free", 3, RecordEnds::Free),
    ("20 free", 20, RecordEnds::Free),
    ("20 periodic", 20, RecordEnds::Periodic),
    ("2 periodic", 2, RecordEnds::Periodic),
];

/// Number of cells in ℓ = 250 µm.
const LENGTH: usize = 160;

fn lengths(runs: usize) -> Result<String> {
    let mut text = String::from(
        "\n### Length of 200 ℓ of record\n\nℓ = 250 µm; the window W = 25 µm moves by W/16.\n\n| marginal | strips | coverage % (95 %) | \
         bias % | sd % | mean width/4sd | dispersion |\n|---|---|---|---:|---:|---:|---:|\n",
    );
    for (name, marginal) in marginals()? {
        for (layout, strips, ends) in LAYOUTS {
            let cells = 200 * LENGTH / strips;
            let field = match ends {
                RecordEnds::Periodic => Field::new(LENGTH as f64, cells, marginal.clone())?,
                RecordEnds::Free => Field::new(LENGTH as f64, 1 << 16, marginal.clone())?,
            };
            let run = |run: usize| -> Result<LengthFit> {
                let records: Vec<Vec<f64>> = match ends {
                    RecordEnds::Periodic => (0..strips)
                        .map(|strip| averaged(&field.draw(name, (run * strips + strip) as u64), 16, 1, true))
                        .collect(),
                    RecordEnds::Free => {
                        // Six ℓ between strips of one field.
                        let whole = field.draw(name, run as u64);
                        (0..strips)
                            .map(|s| s * (cells + 6 * LENGTH))
                            .map(|start| averaged(&whole[start..start + cells], 16, 1, false))
                            .collect()
                    }
                };
                let channel = WindowedRecords {
                    window_m: 25e-6,
                    step_m: 25e-6 / 16.0,
                    cell_m: CELL_M,
                    tracks: 1,
                    records: records.iter().map(Vec::as_slice).collect(),
                };
                Ok(fit_length(
                    &[channel],
                    RecordModel::Exponential,
                    LengthSettings { ends, ..LengthSettings::default() },
                )?)
            };
            let fits = all(runs, run)?;
            writeln!(text, "| {name} | {layout} | {} |", summary(&fits, 250e-6))?;
        }
    }
    Ok(text)
}

/// Returns the section on joint fits to windows W, W/2, W/4 and W/8 on the same strips.
fn window_study(runs: usize) -> Result<String> {
    let mut text = String::from(
        "\n### Window study\n\nFour windows W, W/2, W/4, W/8 (three if W/8 has fewer than four cells) on the same free \
         strips, 200 ℓ in all (400 W for uncorrelated cells), ℓ = 250 µm.\n\n| marginal | W/ℓ | strips | coverage % (95 %) | \
         bias % | sd % | mean width/4sd | dispersion |\n|---|---:|---:|---|---:|---:|---:|---:|\n",
    );
    for (name, marginal) in marginals()?.into_iter().take(2) {
        let field = Field::new(LENGTH as f64, 1 << 16, marginal)?;
        for (ratio, window) in [("0.1", 16), ("1", 160), ("2.4", 384)] {
            for strips in [2, 5, 20] {
                let cells = 200 * LENGTH / strips;
                let fits = all(runs, |run| {
                    let whole = field.draw(name, 500_000 + run as u64);
                    let starts = (0..strips).map(|s| s * (cells + 6 * LENGTH));
                    joint(&starts.map(|start| &whole[start..start + cells]).collect::<Vec<_>>(), window)
                })?;
                writeln!(text, "| {name} | {ratio} | {strips} | {} |", summary(&fits, 250e-6))?;
            }
        }
    }
    text += "\n| uncorrelated cells, strips | due to the window alone % (95 %) | mean ℓ/W | mean upper end/W |\n|---:|---|---:|---:|\n";
    for strips in [2, 5, 20] {
        let window = 64;
        let cells = 400 * window / strips;
        let fits = all(runs, |run| {
            let of = |strip: usize| {
                random::standard_normal(&mut random::stream(78, "white", (run * strips + strip) as u64), cells)
            };
            let strips: Vec<Vec<f64>> = (0..strips).map(of).collect();
            joint(&strips.iter().map(Vec::as_slice).collect::<Vec<_>>(), window)
        })?;
        // The shortest step is one cell.
        let only = fits.iter().filter(|fit| fit.interval.low < CELL_M).count();
        let mean = |value: &dyn Fn(&LengthFit) -> f64| fits.iter().map(value).sum::<f64>() / runs as f64;
        let window_m = window as f64 * CELL_M;
        writeln!(
            text,
            "| {strips} | {} | {:.3} | {:.3} |",
            percentage(only, runs),
            mean(&|fit| fit.length_m) / window_m,
            mean(&|fit| fit.interval.high) / window_m
        )?;
    }
    Ok(text)
}

/// Size of a cell in metre.
const CELL_M: f64 = 250e-6 / LENGTH as f64;

fn joint(strips: &[&[f64]], window: usize) -> Result<LengthFit> {
    let windows: Vec<usize> = [1, 2, 4, 8].map(|part| window / part).into_iter().filter(|cells| *cells >= 4).collect();
    let seen: Vec<(usize, usize, Vec<Vec<f64>>)> = windows
        .into_iter()
        .map(|window| (window, (window / 16).max(1)))
        .map(|(window, step)| (window, step, strips.iter().map(|s| averaged(s, window, step, false)).collect()))
        .collect();
    let channels: Vec<WindowedRecords<'_>> = seen
        .iter()
        .map(|(window, step, records)| WindowedRecords {
            window_m: *window as f64 * CELL_M,
            step_m: *step as f64 * CELL_M,
            cell_m: CELL_M,
            tracks: 1,
            records: records.iter().map(Vec::as_slice).collect(),
        })
        .collect();
    Ok(fit_length(&channels, RecordModel::Exponential, LengthSettings::default())?)
}

/// Mean and scale at a position from 0 to 1.
type Drift = fn(f64) -> (f64, f64);

/// Returns mean 0 and scale 1: no drift.
fn still(_: f64) -> (f64, f64) {
    (0.0, 1.0)
}

/// Returns a mean that rises by one and a half standard deviations from end to end, and scale 1.
fn rising(x: f64) -> (f64, f64) {
    (1.5 * x, 1.0)
}

/// Returns the section on how often the tests of stationarity are significant.
fn drifts(runs: usize) -> Result<String> {
    let mut text = String::from(
        "\n### Stationarity\n\nPercentage of runs in which a test is significant at 5 %: 200 ℓ, W = ℓ/10, normal.\n\n\
         | process | strips | trend | mean of halves | ends | variance | wander |\n|---|---:|---:|---:|---:|---:|---:|\n",
    );
    let field = Field::new(LENGTH as f64, 1 << 16, None)?;
    let drifts: [(&str, Drift); 2] = [("stationary", still), ("mean rises by 1.5 sd", rising)];
    for (name, drift) in drifts {
        for strips in [1, 5, 20] {
            let cells = 200 * LENGTH / strips;
            let found = all(runs, |run| {
                let whole = field.draw("drift", run as u64);
                let of = |strip: usize| -> Vec<f64> {
                    let start = strip * (cells + 6 * LENGTH);
                    let values = averaged(&whole[start..start + cells], LENGTH / 10, LENGTH / 40, false);
                    let n = values.len() as f64;
                    let add = |(i, value): (usize, f64)| drift(i as f64 / n).0 + drift(i as f64 / n).1 * value;
                    values.into_iter().enumerate().map(add).collect()
                };
                let records: Vec<Vec<f64>> = (0..strips).map(of).collect();
                let views: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
                Ok(Stationarity::new(&views, 1, CELL_M * LENGTH as f64 / 40.0)?)
            })?;
            let rate = |significant: &dyn Fn(&Stationarity) -> bool| {
                100.0 * found.iter().filter(|tests| significant(tests)).count() as f64 / runs as f64
            };
            let wander = if found.iter().any(|tests| tests.wander.is_some()) {
                format!("{:.1}", rate(&|tests| tests.wander.is_some_and(|wander| wander.significant())))
            } else {
                "–".into()
            };
            writeln!(
                text,
                "| {name} | {strips} | {:.1} | {:.1} | {:.1} | {:.1} | {wander} |",
                rate(&|tests| tests.trend.significant()),
                rate(&|tests| tests.mean_change.significant()),
                rate(&|tests| tests.ends.significant()),
                rate(&|tests| tests.variance_change.significant()),
            )?;
        }
    }
    Ok(text)
}

/// Returns the section on the coverage of the cross-correlation at lag zero.
fn cross(runs: usize) -> Result<String> {
    let mut text = String::from(
        "\n### Cross-correlation\n\nTwo normal processes of ℓ = 250 µm under W = 25 µm, 200 ℓ in all.\n\n| ρ | strips | \
         coverage % (95 %) |\n|---:|---:|---|\n",
    );
    let field = Field::new(LENGTH as f64, 1 << 16, None)?;
    for rho in [0.0, 0.6, 0.95] {
        for strips in [1, 5, 20] {
            let cells = 200 * LENGTH / strips;
            let hits = all(runs, |run| {
                let (a, own) = (field.draw("cross/a", run as u64), field.draw("cross/b", run as u64));
                let b: Vec<f64> =
                    a.iter().zip(&own).map(|(a, own)| rho * a + (1.0_f64 - rho * rho).sqrt() * own).collect();
                let of = |whole: &[f64], strip: usize| {
                    let start = strip * (cells + 6 * LENGTH);
                    averaged(&whole[start..start + cells], LENGTH / 10, LENGTH / 40, false)
                };
                let records: Vec<(Vec<f64>, Vec<f64>)> = (0..strips).map(|s| (of(&a, s), of(&b, s))).collect();
                let views: Vec<(&[f64], &[f64])> = records.iter().map(|(a, b)| (a.as_slice(), b.as_slice())).collect();
                Ok(cross_correlation(&views, 1, CELL_M * LENGTH as f64 / 40.0, 0)?.interval.contains(rho))
            })?;
            writeln!(text, "| {rho} | {strips} | {} |", percentage(hits.iter().filter(|hit| **hit).count(), runs))?;
        }
    }
    Ok(text)
}

/// Returns the results of all runs, in order.
fn all<T: Send>(runs: usize, run: impl Fn(usize) -> Result<T> + Sync) -> Result<Vec<T>> {
    let found: std::result::Result<Vec<T>, String> =
        (0..runs).into_par_iter().map(|index| run(index).map_err(|error| error.to_string())).collect();
    Ok(found?)
}

/// Formats a percentage with its Wilson interval.
fn percentage(hits: usize, runs: usize) -> String {
    let interval = wilson_interval(hits, runs);
    format!("{:.1} ({:.1}–{:.1})", 100.0 * hits as f64 / runs as f64, 100.0 * interval.low, 100.0 * interval.high)
}

fn summary(fits: &[LengthFit], truth_m: f64) -> String {
    let runs = fits.len();
    let hits = fits.iter().filter(|fit| fit.interval.contains(truth_m)).count();
    let mean = fits.iter().map(|fit| fit.length_m).sum::<f64>() / runs as f64;
    let sd = (fits.iter().map(|fit| (fit.length_m - mean).powi(2)).sum::<f64>() / runs as f64).sqrt();
    let width = fits.iter().map(|fit| fit.interval.high - fit.interval.low).sum::<f64>() / runs as f64;
    let dispersion = fits.iter().map(|fit| fit.dispersion).sum::<f64>() / runs as f64;
    format!(
        "{} | {:.1} | {:.1} | {:.2} | {:.2}",
        percentage(hits, runs),
        100.0 * (mean / truth_m - 1.0),
        100.0 * sd / truth_m,
        width / (3.92 * sd),
        dispersion
    )
}
