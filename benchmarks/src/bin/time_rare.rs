//! Estimates a small probability in several replicates, and prints the estimates and their numbers of evaluations as JSON.
//!
//! `cargo run -p asperity-benchmarks --bin time_rare LIMIT_STATE VARIABLES PARAMETER REPLICATES [SAMPLES]`
//!
//! With SAMPLES, one estimate is the mean of ten subset simulations with this number of samples per level.
//! `benchmarks/rare/limit_states.py` has the same limit states.
#![expect(clippy::print_stdout, reason = "prints results")]

use std::error::Error;

use asperity::chaos::rare::{Settings, SmallProbability, SubsetSettings, small_probability, subset_simulation};
use asperity::monitor::Silent;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, variables, parameter, replicates, samples @ ..] = arguments.as_slice() else {
        return Err("usage: time_rare LIMIT_STATE VARIABLES PARAMETER REPLICATES [SAMPLES]".into());
    };
    let (variables, parameter): (usize, f64) = (variables.parse()?, parameter.parse()?);
    let samples = samples.first().map(|samples| samples.parse::<usize>()).transpose()?;
    let g = |z: &[f64]| limit_state(name, parameter, z).ok_or("no such limit state");
    let mut found = Vec::new();
    for seed in 0..replicates.parse::<u64>()? {
        let answer = match samples {
            None => small_probability(variables, &g, &Settings::new(seed), &Silent),
            Some(samples) => subset_simulation(variables, &g, &SubsetSettings::new(samples, seed), &Silent),
        };
        let (probability, low, high, evaluations) = match answer.map_err(|error| error.to_string())? {
            SmallProbability::Estimate(found) => {
                (found.probability, found.interval.low, found.interval.high, found.evaluations)
            }
            SmallProbability::Bound(bound) => (0.0, 0.0, bound.probability, bound.evaluations),
        };
        found.push(serde_json::json!({
            "probability": probability, "low": low, "high": high, "evaluations": evaluations,
        }));
    }
    println!("{}", serde_json::Value::from(found));
    Ok(())
}

/// Returns g; u and v are orthogonal directions that involve all (an even number of) variables.
fn limit_state(name: &str, parameter: f64, z: &[f64]) -> Option<f64> {
    let scale = (z.len() as f64).sqrt();
    let (even, odd): (f64, f64) = (z.iter().step_by(2).sum(), z.iter().skip(1).step_by(2).sum());
    let (u, v) = ((even + odd) / scale, (even - odd) / scale);
    match name {
        "linear" => Some(parameter - u),
        "machine" => Some(parameter + 0.005 * z[1] - 0.5 * (0.1 + 0.02 * z[0])),
        "parabola" => Some(parameter - u + 0.1 * (z.iter().map(|z| z * z).sum::<f64>() - u * u)),
        "branches" => Some((parameter + 0.2 * v * v - u.abs()).min(2.0_f64.sqrt() * (parameter + 0.5 - v.abs()))),
        _ => None,
    }
}
