//! Tests of `asperity vibration` with published numbers.

use std::fs;
use std::path::Path;
#[cfg(target_os = "linux")]
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

#[cfg(target_os = "linux")]
use crate::support::run_and_interrupt;
use crate::support::{Finished, asperity, asperity_in, close, keys, number};

/// The paper's friction law; periods and displacements come from a high-precision solver.
const PAPER: &str = "--static-friction 0.1 --stribeck 4.2 --belt-velocity 0.003";

/// Writes a one-dimensional NPY file byte by byte.
fn record(folder: &Path, values: &[f64]) {
    let dictionary = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", values.len());
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(118_u16.to_le_bytes());
    bytes.extend(format!("{dictionary:<117}\n").as_bytes());
    bytes.extend(values.iter().flat_map(|x| x.to_le_bytes()));
    fs::write(folder.join("m.npy"), bytes).unwrap();
}

/// Runs the program in a folder with the arguments of a line.
fn line_in(folder: &Path, line: &str) -> Finished {
    asperity_in(folder, &line.split_whitespace().collect::<Vec<_>>())
}

#[test]
fn the_paper_s_cycle_has_its_period_and_displacements() {
    let json = asperity(&format!("vibration cycle {PAPER} --damping-ratio 0.17 --json")).json(0);
    assert_eq!(
        keys(&json),
        [
            "displacement_max",
            "displacement_min",
            "kick",
            "kind",
            "limit_cycle",
            "period",
            "reattachment_displacement",
            "slip_duration",
            "steady_sliding_unstable",
            "velocity_min",
            "warnings"
        ]
    );
    assert_eq!(json["limit_cycle"], Value::Bool(true));
    // ζ_H = .2048: below it steady sliding needs no kick.
    assert_eq!((&json["kind"], &json["kick"]), (&"stick_slip".into(), &Value::Null));
    assert_eq!(json["steady_sliding_unstable"], Value::Bool(true));
    close(number(&json, "period"), 6.372_163_483_739_709, 1e-12);
    close(number(&json, "slip_duration"), 5.644_059_891_168_911, 1e-12);
    close(number(&json, "reattachment_displacement"), 0.096_795_689_222_287_6, 1e-12);
    close(number(&json, "displacement_min"), 0.095_239_651_620_418_2, 1e-12);
    close(number(&json, "displacement_max"), 0.101_931_013_749_859_7, 1e-12);
}

#[test]
fn a_jump_from_static_to_kinetic_friction_has_its_closed_form() {
    // Coulomb: T = 2π − 2 atan(Δ/V) + 2Δ/V, X_r = 2μ_k − μ_s.
    let line = "vibration cycle --static-friction 0.4 --kinetic-friction 0.3 --stribeck 0 --damping-ratio 0 \
                --belt-velocity 0.05 --json";
    let json = asperity(line).json(0);
    close(number(&json, "period"), 8.068_887_871_591_405, 1e-12);
    close(number(&json, "reattachment_displacement"), 0.2, 1e-12);
}

#[test]
fn no_limit_cycle_is_an_answer() {
    let found = asperity(&format!("vibration cycle {PAPER} --damping-ratio 0.3 --json"));
    let json = found.json(0);
    assert_eq!(json["limit_cycle"], Value::Bool(false));
    assert_eq!((&json["kind"], &json["steady_sliding_unstable"]), (&"none".into(), &Value::Bool(false)));
    let stated = ["limit_cycle", "kind", "steady_sliding_unstable", "warnings"];
    for key in keys(&json).into_iter().filter(|key| !stated.contains(key)) {
        assert_eq!(json[key], Value::Null, "{key}");
    }
    assert!(found.stderr.contains("no limit cycle"));
    let table = asperity(&format!("vibration cycle {PAPER} --damping-ratio 0.3 --quiet"));
    assert!(table.stdout.contains("undefined") && table.stderr.is_empty(), "{table:?}");
}

#[test]
fn the_critical_damping_is_the_published_one() {
    let json = asperity(&format!("vibration critical-damping {PAPER} --json")).json(0);
    assert_eq!(keys(&json), ["critical_damping_ratio", "hopf_damping_ratio", "limit_damping_ratio", "warnings"]);
    assert_eq!(json["limit_damping_ratio"], json["critical_damping_ratio"]);
    close(number(&json, "critical_damping_ratio"), 0.204_830_150_584_523_2, 1e-12);
    // 2ζ_H = aμ_st/(1 + aV)².
    close(number(&json, "hopf_damping_ratio"), 0.5 * 4.2 * 0.1 / (1.0 + 4.2 * 0.003_f64).powi(2), 1e-12);
}

#[test]
fn between_the_hopf_point_and_the_fold_the_machine_vibrates_once_started() {
    let base = "vibration cycle --static-friction 0.1 --stribeck 4.2 --belt-velocity 0.1";
    // SciPy, DOP853 with bisection.
    for (damping, kick) in [(0.111, 0.0966), (0.109, 0.0821)] {
        let found = asperity(&format!("{base} --damping-ratio {damping} --json"));
        let json = found.json(0);
        assert_eq!((&json["kind"], &json["limit_cycle"]), (&"stick_slip".into(), &Value::Bool(true)));
        assert_eq!(json["steady_sliding_unstable"], Value::Bool(false));
        assert!((number(&json, "kick") - kick).abs() < 2e-4, "{json}");
        assert!(found.stderr.contains("once started"), "{}", found.stderr);
    }
    // An independent integrator: a cycle without stick.
    let fast = "vibration cycle --static-friction 0.432353 --stribeck 4.2 --belt-velocity 3.1416 --damping-ratio 0.001";
    let json = asperity(&format!("{fast} --json")).json(0);
    assert_eq!(json["kind"], "overtaking");
    assert!((number(&json, "period") - 6.294_67).abs() < 6e-6, "{json}");
}

#[test]
fn forcing_inside_the_locked_region_repeats_with_the_force_and_needs_both_flags() {
    // The 1:1 locked orbit exists up to ζ = 0.27319 at η = 1.
    let base = "vibration cycle --static-friction 0.2 --stribeck 4.2 --damping-ratio 0.26 --belt-velocity 0.1";
    let json = asperity(&format!("{base} --forcing 0.01 --forcing-frequency 1 --json")).json(0);
    assert_eq!(json["limit_cycle"], Value::Bool(true));
    close(number(&json, "period"), std::f64::consts::TAU, 1e-9);
    asperity(&format!("{base} --forcing 0.01 --json")).refuses(2, &["--forcing-frequency"]);
    asperity(&format!("{base} --forcing-frequency 1 --json")).refuses(2, &["--forcing"]);
}

#[test]
fn a_record_of_zeros_gives_the_deterministic_cycle() {
    let folder = TempDir::new().unwrap();
    record(folder.path(), &vec![0.0; 4000]);
    let line = format!(
        "vibration trajectory {PAPER} --damping-ratio 0.17 --friction-file m.npy --friction-step 0.0005 \
         --duration 60 --json"
    );
    let run = |line: &str| asperity_in(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
    let json = run(&line).json(0);
    let events = json["events"].as_array().unwrap();
    let of_kind = |kind: &str| {
        let found: Vec<f64> = events.iter().filter(|e| e[0] == kind).map(|e| e[1].as_f64().unwrap()).collect();
        found
    };
    let detached = of_kind("D");
    assert_eq!(detached.len(), 10);
    for pair in detached.windows(2) {
        close(pair[1] - pair[0], 6.372_163_483_739_709, 1e-10);
    }
    for (event, kind) in events.iter().zip(["D", "R"].iter().cycle()) {
        assert_eq!(event[0], **kind);
        assert_eq!(event.as_array().unwrap().len(), 4);
    }
    close(events[1][2].as_f64().unwrap(), 0.096_795_689_222_287_6, 1e-10);
    // From X = μ_st − 2ζV − 1.5 V the belt takes τ = 1.5 to the detachment.
    let start = 0.1 - 2.0 * 0.17 * 0.003 - 1.5 * 0.003;
    let json = run(&format!("{line} --start {start}")).json(0);
    close(json["events"][0][1].as_f64().unwrap(), 1.5, 1e-10);
}

#[test]
fn unsuitable_records_are_unusable_data() {
    let folder = TempDir::new().unwrap();
    let run = |line: &str| asperity_in(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
    let line = format!(
        "vibration trajectory {PAPER} --damping-ratio 0.17 --friction-step 0.0005 --duration 600 --json \
         --friction-file"
    );
    run(&format!("{line} gone.npy")).refuses(3, &["gone.npy", "no such file"]);
    for (values, words) in [
        (vec![0.0; 40], vec!["m.npy", "ends at"]),
        (vec![0.0; 1], vec!["m.npy", "at least 2"]),
        (vec![0.0, f64::NAN, 0.0], vec!["m.npy", "finite"]),
        (vec![-0.2; 4000], vec!["m.npy", "positive"]),
    ] {
        record(folder.path(), &values);
        run(&format!("{line} m.npy")).refuses(3, &words);
    }
    fs::write(folder.path().join("map.txt"), "0 1\n2 3\n").unwrap();
    run(&format!("{line} map.txt")).refuses(3, &["map.txt", "one-dimensional"]);
}

#[test]
fn values_out_of_range_are_usage_errors() {
    for (line, words) in [
        (
            "cycle --static-friction -0.1 --stribeck 4.2 --damping-ratio 0.1 --belt-velocity 1",
            ["--static-friction", "-0.1"],
        ),
        ("cycle --static-friction 0.1 --stribeck -4 --damping-ratio 0.1 --belt-velocity 1", ["--stribeck", "negative"]),
        (
            "cycle --static-friction 0.1 --stribeck 4 --damping-ratio nan --belt-velocity 1",
            ["--damping-ratio", "finite"],
        ),
        (
            "cycle --static-friction 0.1 --stribeck 4 --damping-ratio 0.1 --belt-velocity 0",
            ["--belt-velocity", "above 0"],
        ),
        ("cycle --static-friction 0.1 --stribeck 4 --damping-ratio 0.1", ["--belt-velocity", "required"]),
        (
            "cycle --static-friction 0.1 --kinetic-friction 0.2 --stribeck 4 --damping-ratio 0.1 --belt-velocity 1",
            ["kinetic_friction", "static friction"],
        ),
        ("cycle --static-frction 0.1", ["--static-frction", "--static-friction"]),
    ] {
        asperity(&format!("vibration {line} --json")).refuses(2, &words);
    }
}

#[test]
fn machines_beyond_double_precision_are_refused_with_the_range() {
    let base = [("static-friction", "0.1"), ("stribeck", "4.2"), ("belt-velocity", "0.003"), ("damping-ratio", "0.17")];
    for (flag, value, words) in [
        ("static-friction", "1e300", ["static_friction", "between 1e-12 and 1000"]),
        ("stribeck", "1e300", ["weakening", "between 0 and 1e6"]),
        ("damping-ratio", "1e9", ["damping_ratio", "between 0 and 1000"]),
        ("belt-velocity", "1e-300", ["belt_velocity", "between 1e-12 and 1e6"]),
    ] {
        let line = base.map(|(name, usual)| format!("--{name} {}", if name == flag { value } else { usual })).join(" ");
        asperity(&format!("vibration cycle {line} --json")).refuses(2, &words);
        if flag != "damping-ratio" {
            asperity(&format!("vibration critical-damping {line} --json")).refuses(2, &words);
        }
    }
    let forced = format!("vibration cycle {PAPER} --damping-ratio 0.17 --forcing 0.01 --forcing-frequency 1e9 --json");
    asperity(&forced).refuses(2, &["forcing_frequency", "between 1e-6 and 1000"]);
}

const NOISE: &str = "--friction-std 0.001 --correlation-length 0.01 --marginal beta:2.1,5 --duration 637.2";

#[test]
fn an_ensemble_counts_the_published_cycles() {
    let line = format!("vibration ensemble {PAPER} --damping-ratio 0.17 {NOISE} --trajectories 200 --seed 4 --json");
    let json = asperity(&line).json(0);
    for key in [
        "cycles_deterministic",
        "difference_mean_interval",
        "entry_rate",
        "entry_rate_interval",
        "exit_rate",
        "exit_rate_interval",
        "kind",
        "kind_shares",
        "left_share",
        "left_share_interval",
        "micro_slips_mean",
        "period_mean",
        "period_std",
        "reattachment_normality_p",
        "reattachment_skewness",
        "release_mean",
        "release_normality_p",
        "release_skewness",
        "release_std",
        "share_in_cycle",
        "stick_share_mean",
        "stick_share_se",
        "sustained_share",
        "sustained_share_interval",
        "vibration_share",
        "vibration_share_se",
    ] {
        assert!(!json[key].is_null(), "{key}");
    }
    // 69.20 (0.07) from two independent codes with 8,000 trajectories; here 4 standard errors of 200 trajectories.
    let (mean, se) = (number(&json, "cycles_mean"), number(&json, "cycles_se"));
    assert!((mean - 69.20).abs() < 4.0 * se.hypot(0.07), "{mean} ± {se}");
    assert!((0.2..0.8).contains(&se), "{se}");
    assert_eq!(number(&json, "cycles_deterministic"), 99.0);
    close(number(&json, "difference_mean"), 99.0 - mean, 1e-12);
}

#[test]
fn overtaking_counts_as_vibration() {
    let machine = "--static-friction 0.432353 --stribeck 4.2 --belt-velocity 3.1416";
    let noise = "--friction-std 1e-6 --correlation-length 30 --marginal beta:2.1,5 --seed 3";
    for (damping, kind) in [("0.001", "overtaking"), ("0.002", "overtaking"), ("0.004", "stick_slip")] {
        let line = format!(
            "vibration ensemble {machine} --damping-ratio {damping} {noise} --duration 3000 --trajectories 4 --json"
        );
        let json = asperity(&line).json(0);
        assert_eq!(json["kind"], kind);
        assert_eq!((number(&json, "sustained_share"), number(&json, "vibration_share")), (1.0, 1.0));
        assert!((number(&json, "cycles_deterministic") - 3000.0 / 6.295).abs() < 3.0);
        assert!(json["kind_shares"][kind].as_f64().unwrap() > 0.5, "{}", json["kind_shares"]);
    }
    let map = format!(
        "vibration map {machine} --damping-ratio 0.001 {noise} --damping-ratios 0.001,0.2,2 --belt-velocities 3,3.2,1 --depth 0 \
         --trajectories 4 --duration 600 --json"
    );
    let map = asperity(&map).json(0);
    let points = map["points"].as_array().unwrap();
    let vibrates = |p: &&Value| p["sustained"]["value"] == 1.0;
    assert_eq!(points.iter().filter(vibrates).count(), 2, "{points:?}");
    // The probability falls from 1 to 0 within one cell.
    assert_eq!(number(&map["resolution"], "unresolved_share"), 1.0);
    let lines = |k: usize| map["contours"][k]["lines"].as_array().unwrap().len();
    assert_eq!([lines(0), lines(1), lines(2)], [0, 1, 0]);
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
fn implausible_machines_are_warned_about() {
    let warned = |line: &str| asperity(&format!("vibration {line}")).stderr;
    let damped = warned("cycle --static-friction 0.1 --stribeck 4.2 --belt-velocity 0.003 --damping-ratio 1.2");
    assert!(damped.contains("warning: the damping ratio 1.2 is above 1"), "{damped}");
    let rough = warned("critical-damping --static-friction 1.6 --stribeck 4.2 --belt-velocity 0.003");
    assert!(rough.contains("warning: the friction coefficient 1.6 is above 1.5"), "{rough}");
    assert!(!warned(&format!("cycle {PAPER} --damping-ratio 0.17")).contains("warning"));
    let modes = warned("mode-coupling --static-friction 1.6 --stribeck 1 --belt-velocity 1 --modal-damping 0.01,1.2");
    let [friction, damping] = ["the friction coefficient 1.6 is above 1.5", "the damping ratio 1.2 is above 1"];
    assert!(modes.contains(friction) && modes.contains(damping), "{modes}");
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
fn every_friction_law_has_its_flags() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("law.csv"), "velocity,friction\n0,0.4\n0.5,0.25\n1,0.1\n").unwrap();
    fs::write(folder.path().join("wrong.csv"), "velocity,friction\n0,0.4\n0.5,x\n").unwrap();
    let run = |line: &str| asperity_in(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
    let base = "vibration cycle --static-friction 0.4 --damping-ratio 0.1 --belt-velocity 0.1 --json";
    // Linear weakening has a closed form; by its own flag and as a table of a straight line.
    for law in ["--linear-weakening 0.3", "--friction-table law.csv"] {
        let json = run(&format!("{base} {law}")).json(0);
        close(number(&json, "period"), 6.439_474_890_105_244, 1e-11);
        close(number(&json, "reattachment_displacement"), 0.288_933_000_910_998, 1e-11);
    }
    // An exponential law without a fall is Coulomb's: T = 2π − 2 atan(Δ/V) + 2Δ/V.
    let coulomb = "vibration cycle --static-friction 0.4 --kinetic-friction 0.3 --damping-ratio 0 --belt-velocity 0.05 --json \
                   --stribeck-velocity 0.1 --high-speed-friction 0.3";
    close(number(&asperity(coulomb).json(0), "period"), 8.068_887_871_591_405, 1e-12);
    run(&format!("{base} --friction-table wrong.csv")).refuses(3, &["wrong.csv, line 3"]);
    run(&format!("{base} --stribeck 1 --linear-weakening 1")).refuses(2, &["cannot be used with"]);
}

#[test]
fn the_curve_of_critical_damping_passes_through_published_points_and_the_diagram_jumps_there() {
    let curve =
        asperity(&format!("vibration critical-curve {PAPER} --over belt-velocity --from 0.003 --to 0.1 --json"))
            .json(0);
    let points = curve["points"].as_array().unwrap();
    for (end, wanted) in [(&points[0], 0.204_830_150_584_523_2), (&points[points.len() - 1], 0.111_508_270_209_214_1)] {
        close(number(end, "critical_damping_ratio"), wanted, 1e-10);
    }
    let line = format!(
        "vibration bifurcation {PAPER} --damping-ratio 0.1 --over damping-ratio --from 0.2 --to 0.21 --points 3 --json"
    );
    let diagram = asperity(&line).json(0);
    let upward = diagram["upward"].as_array().unwrap();
    let slowest = |point: &Value| point["velocity"][0].as_f64().unwrap();
    assert!(slowest(&upward[0]) < -0.003 && slowest(&upward[2]).abs() < 1e-12);
}

#[test]
fn the_map_falls_from_one_to_zero_and_weak_noise_has_the_sound_of_the_cycle() {
    let noise = "--correlation-length 0.01 --marginal beta:2.1,5 --seed 3";
    let line = format!(
        "vibration map {PAPER} --damping-ratio 0.1 --friction-std 0.001 {noise} --damping-ratios 0.1,0.3,2 \
         --friction-stds 0.0002,0.001,1 --depth 1 --trajectories 20 --duration 150 --json"
    );
    let map = asperity(&line).json(0);
    assert_eq!((map["x"].as_str(), map["y"].as_str()), (Some("damping_ratio"), Some("friction_std")));
    let share = |x: f64| {
        let points = map["points"].as_array().unwrap();
        let at = points.iter().filter(|p| (p["x"].as_f64().unwrap() - x).abs() < 1e-9);
        at.map(|p| p["sustained"]["value"].as_f64().unwrap()).collect::<Vec<_>>()
    };
    assert!(share(0.1).iter().all(|p| *p == 1.0) && share(0.3).iter().all(|p| *p == 0.0));
    assert_eq!(map["contours"].as_array().unwrap().len(), 3);
    asperity(&line.replace("--friction-stds 0.0002,0.001,1", "")).refuses(2, &["two axes"]);
    let sound = format!(
        "vibration sound {PAPER} --damping-ratio 0.15 --friction-std 1e-6 {noise} --trajectories 2 --duration 300 --json"
    );
    assert!(number(&asperity(&sound).json(0), "level_db").abs() < 0.1);
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
    let read = line_in(folder.path(), &format!("{file} --length-unit 1m")).json(0);
    let flags = "--friction-std 0.001 --correlation-length 0.01 --marginal beta:2.1,5 --translation corrected";
    let stated = asperity(&format!("vibration ensemble {PAPER} {rest} {flags}")).json(0);
    assert_eq!(read, stated);
    // Lengths need a unit, and only one fluctuation may be stated.
    assert!(line_in(folder.path(), &file).code == 2);
    assert!(line_in(folder.path(), &format!("{file} --length-unit 1m {flags}")).code == 2);
    let absent = format!("vibration ensemble {PAPER} {rest} --friction-process no.json --length-unit 1m");
    assert!(line_in(folder.path(), &absent).code == 3);
    assert!(asperity(&format!("vibration ensemble {PAPER} {rest} --friction-std 0.001")).code == 2);
}

#[test]
fn integrators_find_the_same_events() {
    let folder = TempDir::new().unwrap();
    let values: Vec<f64> = (0..2000).map(|i| 0.002 * (f64::from(i) * 0.7).sin()).collect();
    record(folder.path(), &values);
    let events = |integrator: &str| {
        let line = format!(
            "vibration trajectory {PAPER} --damping-ratio 0.17 --friction-file m.npy --friction-step 0.0005 --duration 40 \
             --integrator {integrator} --json"
        );
        let json = line_in(folder.path(), &line).json(0);
        json["events"].as_array().unwrap().clone()
    };
    let series = events("taylor");
    assert!(series.len() > 8);
    for (integrator, error) in [("dormand-prince", 1e-8), ("runge-kutta-fehlberg", 1e-5)] {
        let found = events(integrator);
        assert_eq!(found.len(), series.len());
        for (a, b) in found.iter().zip(&series) {
            assert_eq!(a[0], b[0]);
            let (a, b) = (a[1].as_f64().unwrap(), b[1].as_f64().unwrap());
            assert!((a - b).abs() < error, "{integrator}: {a} and {b}");
        }
    }
}

#[test]
fn a_map_over_loads_scales_every_friction_law_in_si() {
    let folder = TempDir::new().unwrap();
    let points = |factor: f64| format!("0 0.1\n{} 0.08\n{} 0.07\n", 0.1 / factor, 0.4 / factor);
    fs::write(folder.path().join("law.txt"), points(1.0)).unwrap();
    fs::write(folder.path().join("heavy.txt"), points(2.0)).unwrap();
    let laws = [
        ("--stribeck 4.2", "--stribeck 8.4"),
        ("--linear-weakening 0.3", "--linear-weakening 0.6"),
        ("--stribeck-velocity 0.2 --high-speed-friction 0.06", "--stribeck-velocity 0.1 --high-speed-friction 0.06"),
        ("--friction-table law.txt", "--friction-table heavy.txt"),
    ];
    let noise = "--friction-std 1e-5 --correlation-length 0.01 --marginal normal";
    for (law, heavy) in laws {
        let map = format!(
            "vibration map --static-friction 0.1 {law} --belt-velocity 0.01 --damping-ratio 0.1 {noise} --belt-velocities 0.01,0.02,1 \
             --loads 1,2,1 --depth 0 --trajectories 4 --duration 20 --seed 1 --json"
        );
        let map = line_in(folder.path(), &map).json(0);
        let corner = map["points"].as_array().unwrap().iter().find(|p| p["x"] == 0.02 && p["y"] == 2.0).unwrap();
        let line = format!("vibration critical-damping --static-friction 0.1 {heavy} --belt-velocity 0.01 --json");
        let wanted = line_in(folder.path(), &line).json(0);
        close(number(corner, "limit_damping_ratio"), number(&wanted, "limit_damping_ratio"), 1e-12);
    }
}

#[test]
fn a_motion_that_neither_sticks_nor_slides_steadily_is_reported() {
    // ζ_c lies far below ζ_H = 375: between them the mass vibrates without sticking.
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("steep.txt"), "0 0.1\n0.001 0.1\n0.0011 0.05\n1 0.04\n").unwrap();
    let law = "--static-friction 0.1 --friction-table steep.txt --belt-velocity 0.00105";
    let found = line_in(folder.path(), &format!("vibration cycle {law} --damping-ratio 23 --json"));
    let answer = found.json(0);
    assert_eq!((&answer["limit_cycle"], &answer["kind"]), (&Value::Bool(true), &"slip_cycle".into()));
    assert_eq!(answer["steady_sliding_unstable"], Value::Bool(true));
    assert_eq!(answer["slip_duration"], answer["period"]);
    let limit = line_in(folder.path(), &format!("vibration critical-damping {law} --json")).json(0);
    assert!(number(&limit, "hopf_damping_ratio") > 23.0);
    assert!(number(&limit, "critical_damping_ratio") < 23.0);
    // Every start leads to this cycle.
    let starts = "--displacements 0,0.15,8 --velocities -0.001,0.001,8 --json";
    let basin = line_in(folder.path(), &format!("vibration basin {law} --damping-ratio 23 {starts}")).json(0);
    assert_eq!(number(&basin, "slip_cycle_share"), 1.0);
}

#[test]
fn flags_of_an_invalid_machine_or_range_are_named() {
    let damping = "--damping-ratio 0.1";
    for (line, words) in [
        (format!("bifurcation {PAPER} {damping} --over belt-velocity --from 0.1 --to 0.1"), ["--to", "--from"]),
        (
            format!("bifurcation {PAPER} {damping} --over belt-velocity --from 0.01 --to 0.1 --points 1"),
            ["--points", "2"],
        ),
        (format!("bifurcation {PAPER} {damping} --over forcing --from 0.01 --to 0.1"), ["--over forcing", "--forcing"]),
        (format!("critical-curve {PAPER} --over damping-ratio --from 0.01 --to 0.1"), ["--over", "critical"]),
        (
            format!("critical-curve {PAPER} --over forcing-frequency --from 0.9 --to 1"),
            ["forcing-frequency", "--forcing"],
        ),
        (
            format!(
                "map {PAPER} {damping} --friction-std 0.001 --correlation-length 0.01 --marginal normal --seed 1 --trajectories 4 \
                 --duration 20 --damping-ratios 0.3,0.1,4 --belt-velocities 0.01,0.1,4"
            ),
            ["--damping-ratios", "above the first"],
        ),
        (format!("cycle {PAPER} {damping} --high-speed-friction 0.05"), ["--high-speed-friction", "--stribeck"]),
    ] {
        asperity(&format!("vibration {line}")).refuses(2, &words);
    }
}

#[test]
fn a_linear_law_that_becomes_negative_names_its_slope() {
    let line = "--static-friction 0.1 --linear-weakening 3 --belt-velocity 0.05 --damping-ratio 0.1";
    asperity(&format!("vibration cycle {line}")).refuses(2, &["slope"]);
}

#[test]
fn a_forced_motion_that_settles_slowly_is_periodic() {
    let line = "vibration bifurcation --static-friction 0.2 --stribeck 0 --belt-velocity 0.5 --forcing 0.01 --forcing-frequency 0.7 \
                --damping-ratio 0.002 --over damping-ratio --from 0.002 --to 0.004 --points 2 --json";
    let diagram = asperity(line).json(0);
    for point in diagram["upward"].as_array().unwrap() {
        assert_eq!((&point["multiplicity"], &point["settled"]), (&Value::from(1), &Value::Bool(true)), "{point}");
    }
}

#[test]
fn a_short_scan_of_the_modes_finds_their_critical_friction() {
    let line = "vibration mode-coupling --static-friction 0.3 --stribeck 0 --belt-velocity 0.5 --json";
    let whole = asperity(line).json(0);
    let short = asperity(&format!("{line} --friction-to 0.2")).json(0);
    close(number(&short, "critical_friction"), number(&whole, "critical_friction"), 1e-12);
}

#[test]
fn a_locked_machine_has_the_published_stable_and_unstable_cycle() {
    // Phases and multipliers from SciPy's DOP853 and finite differences.
    let free = "--static-friction 0.2 --stribeck 4.2 --belt-velocity 0.1 --damping-ratio 0.1";
    let line = format!("vibration forced-cycles {free} --forcing 0.02 --forcing-frequency 0.85");
    let cycles = asperity(&format!("{line} --json")).json(0)["cycles"].as_array().unwrap().clone();
    assert_eq!(cycles.len(), 2);
    for (cycle, (phase, multiplier, stable)) in
        cycles.iter().zip([(0.167_718_780_139, 0.798_109_649_788, true), (5.478_189_762_536, 1.229_339_408_056, false)])
    {
        close(number(cycle, "detachment_phase"), phase, 1e-11);
        close(number(cycle, "multiplier"), multiplier, 1e-10);
        close(number(cycle, "period"), std::f64::consts::TAU / 0.85, 1e-12);
        assert_eq!(cycle["stable"], Value::Bool(stable));
    }
    let found = asperity(&line);
    assert!(found.code == 0 && found.stdout.lines().count() == 3, "{}", found.stdout);
    asperity(&format!("vibration forced-cycles {free}")).refuses(2, &["--forcing"]);
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
        line_in(folder.path(), &line).refuses(2, words);
    };
    report("keep --force", &["--report keep", "asperity did not write it"]);
    report("keep", &["--report", "not empty"]);
    report("file --force", &["--report file", "give a folder"]);
    assert_eq!(fs::read_to_string(folder.path().join("keep/thesis.txt")).unwrap(), "years");
}
