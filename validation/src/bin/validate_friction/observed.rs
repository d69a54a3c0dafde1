//! Records of instruments: means, filters, noise, decimation, and short records.

use std::f64::consts::PI;
use std::fmt::Write;

use asperity::correlation::{
    Observation, ObservedLengths, RecordBand, RecordHistory, RecordModel, WindowedRecords, fit_length,
};
use asperity::friction::measured::{DistributionChoice, FittedRecord, MeasuredRecord, RecordPreparation};
use asperity::monitor::Silent;
use asperity::random;
use asperity::stats::wilson_interval;
use asperity_testing::autoregressive;
use rayon::prelude::*;

use super::Result;

/// Correlation length in steps.
const LENGTH: f64 = 20.0;
/// Number of values of a record.
const VALUES: usize = 4000;
/// Number of parts of a step that an integrating converter averages.
const PARTS: usize = 16;

/// Returns the section on records of instruments, as Markdown.
pub(crate) fn section(runs: usize) -> Result<String> {
    let mut text = String::from("## Records of instruments\n");
    text += &lengths(runs)?;
    text += &short(runs)?;
    Ok(text)
}

/// Returns a stationary record of the correlation e^{−lag/ℓ}.
fn exponential(length: f64, values: usize, name: &str, run: usize) -> Vec<f64> {
    autoregressive((-1.0 / length).exp(), values, &mut random::stream(79, name, run as u64))
}

fn means(values: &[f64], count: usize) -> Vec<f64> {
    values.chunks_exact(count).map(|part| part.iter().sum::<f64>() / count as f64).collect()
}

/// Returns a record of the smooth family, a moving average of white noise, with the integral scale of [`LENGTH`] and
/// noise of a standard deviation relative to that of the record.
fn smooth(noise: f64, run: usize) -> Vec<f64> {
    // Three exponential filters in series, t² e^{−λt} with λ = √5/ℓ, have the power spectrum ∝ (λ² + ω²)⁻³ of ν = 5/2.
    let rate = 5.0_f64.sqrt() * RecordModel::Smooth.integral_scale_m(1.0) / LENGTH;
    let times = (0..(30.0 / rate) as i32).map(f64::from);
    let kernel: Vec<f64> = times.map(|t| t * t * (-rate * t).exp()).collect();
    let norm = kernel.iter().map(|weight| weight * weight).sum::<f64>().sqrt();
    let normal = |name, count| random::standard_normal(&mut random::stream(79, name, run as u64), count);
    let (white, errors) = (normal("smooth", VALUES + kernel.len() - 1), normal("noise", VALUES));
    let sum = |values: &[f64]| values.iter().zip(&kernel).map(|(value, weight)| value * weight).sum::<f64>() / norm;
    white.windows(kernel.len()).zip(errors).map(|(values, error)| sum(values) + noise * error).collect()
}

/// Returns the Gaussian mean line of ISO 16610-21.
fn mean_line(values: &[f64], cutoff: f64) -> Vec<f64> {
    let reach = (1.5 * cutoff) as usize;
    let alpha = (2.0_f64.ln() / PI).sqrt();
    let weight = |distance: usize| (-PI * (distance as f64 / (alpha * cutoff)).powi(2)).exp();
    let weights: Vec<f64> = (0..=reach).map(weight).collect();
    (0..values.len())
        .map(|i| {
            let near = i.saturating_sub(reach)..(i + reach + 1).min(values.len());
            let sums = near.fold((0.0, 0.0), |(sum, all), j| {
                (sum + weights[i.abs_diff(j)] * values[j], all + weights[i.abs_diff(j)])
            });
            sums.0 / sums.1
        })
        .collect()
}

type Case = (&'static str, RecordHistory, Box<dyn Fn(usize) -> Vec<f64> + Sync>);

fn cases() -> Vec<Case> {
    let plain = |run| exponential(LENGTH, VALUES, "plain", run);
    let decimated = |count: usize| RecordHistory { decimation: count, ..RecordHistory::default() };
    let noisy = move |fraction: f64| {
        move |run: usize| {
            let noise = random::standard_normal(&mut random::stream(79, "noise", run as u64), VALUES);
            plain(run).iter().zip(noise).map(|(value, noise)| value + fraction * noise).collect()
        }
    };
    let chi_square = |run| {
        // The square of a normal value with e^{−s/2ℓ} has e^{−s/ℓ}.
        let parts: Vec<Vec<f64>> =
            ["a", "b", "c"].iter().map(|name| exponential(2.0 * LENGTH, VALUES, name, run)).collect();
        (0..VALUES).map(|t| parts.iter().map(|part| part[t] * part[t]).sum()).collect()
    };
    let low = RecordBand { low_pass_m: Some(10.0), ..RecordBand::default() };
    let high = RecordBand { high_pass_m: Some(400.0), ..RecordBand::default() };
    let filtered = |band| RecordHistory { band, ..RecordHistory::default() };
    let mut cases: Vec<Case> = vec![
        ("points", RecordHistory::default(), Box::new(plain)),
        ("points, χ² of 3 (skewness 1.63)", RecordHistory::default(), Box::new(chi_square)),
        ("smooth family", RecordHistory::default(), Box::new(|run| smooth(0.0, run))),
        ("smooth family, white noise of 1 % of the sd", RecordHistory::default(), Box::new(|run| smooth(0.01, run))),
        ("white noise of 10 % of the sd", RecordHistory::default(), Box::new(noisy(0.1))),
        ("white noise of 30 % of the sd", RecordHistory::default(), Box::new(noisy(0.3))),
        (
            "means over the step",
            RecordHistory::default(),
            Box::new(|run| means(&exponential(LENGTH * PARTS as f64, VALUES * PARTS, "fine", run), PARTS)),
        ),
    ];
    for (name, count) in [("`--decimate 2`", 2), ("`--decimate 5`", 5), ("`--decimate 10`", 10)] {
        cases.push((name, decimated(count), Box::new(move |run| means(&plain(run), count))));
    }
    cases.push(("`--low-pass` ℓ/2", filtered(low), Box::new(move |run| mean_line(&plain(run), 10.0))));
    cases.push((
        "`--detrend high_pass:20ℓ`",
        filtered(high),
        Box::new(move |run| {
            let record = plain(run);
            record.iter().zip(mean_line(&record, 400.0)).map(|(value, line)| value - line).collect()
        }),
    ));
    cases
}

fn lengths(runs: usize) -> Result<String> {
    let mut text = String::from(
        "\n### Length of a record of 4,000 values and 200 integral scales, exponential unless stated, with an estimated model of the \
         instrument\n\nLengths are integral scales. “Assuming points” is the bias of an exponential fit that treats the values as values at points. \
         “Noise” and “means” count the runs whose fitted model includes them; “told apart”: the record tells the families apart; “refused”: no \
         family fits.\n\n\
         | record | coverage % (95 %) | bias % | sd % | assuming points, bias % | noise % of runs | \
         mean variance of the noise % | means % of runs | told apart % | refused % |\n\
         |---|---|---:|---:|---:|---:|---:|---:|---:|---:|\n",
    );
    for (name, history, record) in cases() {
        let step_m = history.decimation as f64;
        let found = all(runs, |run| {
            let values = record(run);
            let channel =
                WindowedRecords { window_m: 0.0, step_m, cell_m: 0.0, tracks: 1, records: vec![values.as_slice()] };
            let naive = fit_length(&[channel], RecordModel::Exponential, Default::default())?;
            Ok((ObservedLengths::fit(&[&values], step_m, history, &Silent)?, naive.length_m))
        })?;
        let mean = |value: &dyn Fn(&ObservedLengths) -> f64| {
            found.iter().map(|(found, _)| value(found)).sum::<f64>() / runs as f64
        };
        let percent = |is: &dyn Fn(&ObservedLengths) -> bool| 100.0 * mean(&|found| f64::from(u8::from(is(found))));
        let scale = |found: &ObservedLengths| {
            let chosen = found.families.chosen;
            [chosen.interval.low, chosen.length_m, chosen.interval.high].map(|m| chosen.model.integral_scale_m(m))
        };
        let length = mean(&|found| scale(found)[1]);
        let sd = mean(&|found| (scale(found)[1] - length).powi(2)).sqrt();
        let naive = found.iter().map(|(_, naive)| naive).sum::<f64>() / runs as f64;
        let hits = found.iter().filter(|(found, _)| (scale(found)[0]..=scale(found)[2]).contains(&LENGTH)).count();
        writeln!(
            text,
            "| {name} | {} | {:.1} | {:.1} | {:.0} | {:.0} | {:.2} | {:.0} | {:.0} | {:.0} |",
            percentage(hits, runs),
            100.0 * (length / LENGTH - 1.0),
            100.0 * sd / LENGTH,
            100.0 * (naive / LENGTH - 1.0),
            percent(&|found| found.families.chosen.noise_fraction > 0.0),
            100.0 * mean(&|found| found.families.chosen.noise_fraction),
            percent(&|found| found.observation != Observation::Points),
            percent(&|found| found.families.told_apart()),
            percent(&|found| found.families.chosen.lack_of_fit.is_some_and(|test| test.significant())),
        )?;
    }
    Ok(text)
}

/// Returns the section on intervals of short records.
fn short(runs: usize) -> Result<String> {
    let mut text = String::from(
        "\n### Short records\n\nCoverage in percent of the intervals of one measured record, normal, ℓ = 20 values.\n\n\
         | record | accepted % | mean | std | ℓ |\n|---|---:|---|---|---|\n",
    );
    for lengths in [15_usize, 20, 40, 90, 200] {
        let found = all(runs, |run| {
            let friction =
                exponential(LENGTH, lengths * LENGTH as usize, "short", run).iter().map(|g| 0.5 + 0.05 * g).collect();
            let record = MeasuredRecord {
                start_m: 0.0,
                step_m: 1.0,
                friction,
                velocity_m_per_s: None,
                strokes_m: Vec::new(),
                warnings: Vec::new(),
            };
            let prepared = RecordPreparation::default().apply(&record)?;
            Ok(FittedRecord::new(
                &prepared,
                DistributionChoice::One(asperity::distribution::fit::Family::Normal),
                "planted",
            )
            .ok())
        })?;
        let accepted: Vec<&FittedRecord> = found.iter().flatten().collect();
        let covered = |of: &dyn Fn(&FittedRecord) -> Option<[f64; 2]>, truth: f64| {
            let stated: Vec<[f64; 2]> = accepted.iter().filter_map(|found| of(found)).collect();
            percentage(stated.iter().filter(|ends| ends[0] <= truth && truth <= ends[1]).count(), stated.len())
        };
        writeln!(
            text,
            "| {lengths} ℓ | {:.0} | {} | {} | {} |",
            100.0 * accepted.len() as f64 / runs as f64,
            covered(&|found| found.process.mean_interval, 0.5),
            covered(&|found| found.process.std_interval, 0.05),
            covered(&|found| found.process.correlation.and_then(|c| c.length_interval_m), LENGTH),
        )?;
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
