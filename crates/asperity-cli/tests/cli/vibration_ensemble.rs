//! Tests of `asperity vibration ensemble` with published numbers.

use std::fs;
use std::path::Path;
#[cfg(target_os = "linux")]
use std::time::Duration;

use tempfile::TempDir;

#[cfg(target_os = "linux")]
use crate::support::run_and_interrupt;
use crate::support::{PAPER, asperity, close, number, run_in};

const NOISE: &str = "--friction-std 0.001 --correlation-length 0.01 --marginal beta:2.1,5 --duration 637.2";

#[test]
fn an_ensemble_counts_the_published_cycles() {
    let line = format!("vibration ensemble {PAPER} --damping-ratio 0.17 {NOISE} --trajectories 200 --seed 4 --json");
    let json = asperity(&line).json(0);
    // 69.20 (0.07) from two independent codes with 8,000 trajectories; here 4 standard errors of 200 trajectories.
    let (mean, se) = (number(&json, "cycles_mean"), number(&json, "cycles_se"));
    assert!((mean - 69.20).abs() < 4.0 * se.hypot(0.07), "{mean} ± {se}");
    assert!((0.2..0.8).contains(&se), "{se}");
    assert_eq!(number(&json, "cycles_deterministic"), 99.0);
    close(number(&json, "difference_mean"), 99.0 - mean, 1e-12);
}

#[test]
fn an_ensemble_is_the_same_for_any_number_of_threads_and_another_for_another_seed() {
    let run = |threads: usize, seed: u64| {
        let line = format!(
            "vibration ensemble {PAPER} --damping-ratio 0.2 {NOISE} --trajectories 16 --drive time \
             --steps-per-length 10 --seed {seed} --threads {threads} --json"
        );
        let found = asperity(&line);
        assert_eq!(found.code, 0, "{found:?}");
        found.stdout
    };
    assert_eq!(run(1, 7), run(3, 7));
    assert_ne!(run(2, 7), run(2, 8));
}

#[test]
fn clipped_friction_is_reported_and_refused_above_five_percent_unless_allowed() {
    let law = "--correlation-length 0.01 --marginal beta:2.1,5 --duration 60 --seed 1";
    let ensemble = |std: f64, more: &str| {
        asperity(&format!(
            "vibration ensemble {PAPER} --damping-ratio 0.17 --friction-std {std} {law} --trajectories 20 --json {more}"
        ))
    };
    let calm = ensemble(0.001, "");
    assert_eq!(number(&calm.json(0), "clipped_fraction"), 0.0);
    assert!(!calm.stderr.contains("clipped"), "{calm:?}");
    let wild = "% of the friction values would be clipped to stay positive, more than 5 %";
    ensemble(0.08, "").refuses(2, &[wild, "--allow-clipping"]);
    let allowed = ensemble(0.08, "--allow-clipping");
    let fraction = number(&allowed.json(0), "clipped_fraction");
    assert!((0.05..0.6).contains(&fraction), "{fraction}");
    assert!(allowed.stderr.contains("clipped to stay positive; variability is understated"), "{allowed:?}");
    let sound =
        format!("vibration sound {PAPER} --damping-ratio 0.17 --friction-std 0.08 {law} --trajectories 2 --json");
    asperity(&sound).refuses(2, &[wild]);
    let map = format!(
        "vibration map {PAPER} --damping-ratio 0.17 --friction-std 0.001 {law} --trajectories 2 --depth 0 --json \
         --damping-ratios 0.1,0.2,1 --friction-stds 0,0.08,1"
    );
    asperity(&map).refuses(2, &[wild]);
}

#[test]
fn an_ensemble_needs_a_seed_and_a_distribution() {
    let line = format!("vibration ensemble {PAPER} --damping-ratio 0.17 --trajectories 20 --json");
    asperity(&format!("{line} {NOISE}")).refuses(2, &["--seed"]);
    let noise = NOISE.replace("beta:2.1,5", "betta:2.1,5");
    asperity(&format!("{line} {noise} --seed 1")).refuses(2, &["--marginal", "betta:2.1,5", "beta:A,B"]);
    let noise = NOISE.replace("--friction-std 0.001", "--friction-std 0");
    asperity(&format!("{line} {noise} --seed 1")).refuses(2, &["--friction-std", "above 0"]);
    asperity(&format!("{line} {NOISE} --seed -1")).refuses(2, &["--seed"]);
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_ensemble_prints_no_numbers() {
    // Many trajectories, and trajectories over billions of friction values.
    let short = NOISE.replace("--correlation-length 0.01", "--correlation-length 1e-10");
    for (noise, paths) in [(NOISE, 10_000_000), (short.as_str(), 2)] {
        let line =
            format!("vibration ensemble {PAPER} --damping-ratio 0.17 {noise} --trajectories {paths} --seed 1 --json");
        let (found, took) = run_and_interrupt(Path::new("."), &line);
        found.refuses(130, &["cancelled", "friction values"]);
        assert!(took < Duration::from_secs(5), "{took:?}");
    }
}

#[test]
fn a_fitted_process_equals_the_fluctuation_of_its_flags() {
    let folder = TempDir::new().unwrap();
    let process = r#"{"format": "asperity friction process", "version": 1, "mean": 0.1, "std": 0.001,
        "marginal": {"beta": {"a": 2.1, "b": 5.0, "low": 0.0, "high": 1.0}},
        "correlation": {"model": "exponential", "length_m": 0.01}}"#;
    fs::write(folder.path().join("process.json"), process).unwrap();
    let rest = "--damping-ratio 0.17 --trajectories 8 --duration 100 --seed 3 --json";
    let file = format!("vibration ensemble {PAPER} {rest} --friction-process process.json");
    let read = run_in(folder.path(), &format!("{file} --length-unit 1m")).json(0);
    let flags = "--friction-std 0.001 --correlation-length 0.01 --marginal beta:2.1,5 --translation corrected";
    let stated = asperity(&format!("vibration ensemble {PAPER} {rest} {flags}")).json(0);
    assert_eq!(read, stated);
    // Lengths need a unit, and only one fluctuation may be stated; a file needs no flags of the fluctuation.
    let without_unit = run_in(folder.path(), &file);
    without_unit.refuses(2, &["--length-unit"]);
    assert!(["--marginal", "--correlation-length"].iter().all(|flag| !without_unit.stderr.contains(flag)));
    for flag in ["--friction-std 0.001", "--marginal normal", "--generator spectral", "--steps-per-length 9"] {
        run_in(folder.path(), &format!("{file} --length-unit 1m {flag}")).refuses(2, &["--friction-process", "cannot"]);
    }
    let absent = format!("vibration ensemble {PAPER} {rest} --friction-process no.json --length-unit 1m");
    assert!(run_in(folder.path(), &absent).code == 3);
    asperity(&format!("vibration ensemble {PAPER} {rest} --friction-std 0.001"))
        .refuses(2, &["--correlation-length", "--marginal"]);
    for command in ["ensemble", "sound"] {
        let help = asperity(&format!("vibration {command} --help")).stdout;
        let usage = help.lines().find(|line| line.starts_with("Usage:")).unwrap();
        assert!(!usage.contains("--marginal") && !usage.contains("--correlation-length"), "{usage}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn ensembles_beyond_the_memory_are_refused_before_they_start() {
    let damping = "--damping-ratio 0.17";
    for line in [
        format!("sound {PAPER} {damping} {NOISE} --trajectories 1000000000 --seed 1"),
        format!("basin {PAPER} {damping} --displacements 0,1,100000 --velocities 0,1,100000"),
        format!("bifurcation {PAPER} {damping} --over belt-velocity --from 0.01 --to 0.1 --points 1000000000000"),
        "mode-coupling --static-friction 0.8 --stribeck 0 --belt-velocity 0.5 --points 1000000000000".to_owned(),
    ] {
        asperity(&format!("vibration {line}")).refuses(5, &["memory"]);
    }
}

#[test]
fn an_unresolved_correlation_length_is_refused_and_no_foreign_folder_is_replaced() {
    let line = format!("vibration ensemble {PAPER} --damping-ratio 0.17 --trajectories 20 --seed 1");
    for length in ["1e-300", "1e-17"] {
        let noise = NOISE.replace("--correlation-length 0.01", &format!("--correlation-length {length}"));
        asperity(&format!("{line} {noise}")).refuses(2, &["distance between values of friction"]);
    }
    let folder = TempDir::new().unwrap();
    fs::create_dir(folder.path().join("keep")).unwrap();
    fs::write(folder.path().join("keep/thesis.txt"), "years").unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let report = |at: &str, words: &[&str]| {
        let line = format!("vibration basin {PAPER} --damping-ratio 0.17 --report {at}");
        run_in(folder.path(), &line).refuses(2, words);
    };
    report("keep --force", &["--report keep", "asperity did not write it"]);
    report("keep", &["--report", "not empty"]);
    report("file --force", &["--report file", "give a folder"]);
    assert_eq!(fs::read_to_string(folder.path().join("keep/thesis.txt")).unwrap(), "years");
}
