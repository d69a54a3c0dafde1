//! Measures time and memory of a bare loop over the members of a campaign, and prints JSON. The overhead of `asperity campaign` is relative to
//! this loop.
//!
//! `cargo run -p asperity-benchmarks --bin time_campaign STUDY.toml COUNT CAMPAIGN.toml`
//!
//! The members are the study with COUNT damping ratios from 0.05 on; CAMPAIGN.toml is written for `asperity campaign`.
#![expect(clippy::print_stdout, reason = "prints measurements")]

use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::Instant;

use asperity::monitor::Silent;
use asperity::study::{Stage, Study};
use rayon::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [study, count, campaign] = arguments.as_slice() else {
        return Err("usage: time_campaign STUDY.toml COUNT CAMPAIGN.toml".into());
    };
    let count: usize = count.parse()?;
    let text = fs::read_to_string(study)?;
    let dampings: Vec<f64> = (0..count).map(|member| 0.05 + 0.3 * member as f64 / count as f64).collect();
    let study = std::path::absolute(study)?;
    fs::write(campaign, format!("study = {study:?}\n[values]\nvibration.damping_ratio = {dampings:?}\n"))?;
    let began = Instant::now();
    let answers = dampings.par_iter().map(|damping| {
        let lines = text.lines().map(|line| match line.starts_with("damping_ratio") {
            true => format!("damping_ratio = {damping:?}\n"),
            false => format!("{line}\n"),
        });
        let member = Study::parse(&lines.collect::<String>(), "study.toml").map_err(|error| error.to_string())?;
        let outcome = member.run(Path::new("."), Some(Stage::Vibration), &Silent).map_err(|error| error.to_string())?;
        outcome
            .results
            .vibration
            .and_then(|vibration| vibration.limit_damping_ratio)
            .ok_or("no limit damping".to_owned())
    });
    let answers: Vec<f64> = answers.collect::<Result<_, String>>()?;
    let seconds = began.elapsed().as_secs_f64();
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).map(str::trim);
    let sum: f64 = answers.iter().sum();
    println!("{}", serde_json::json!({ "members": count, "seconds": seconds, "peak_memory": peak, "sum": sum }));
    Ok(())
}
