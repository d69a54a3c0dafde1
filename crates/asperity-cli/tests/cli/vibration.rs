//! Tests of the cycles and trajectories of `asperity vibration` with published numbers.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::{PAPER, asperity, close, keys, number, run_in};

/// Writes a one-dimensional NPY file byte by byte.
fn record(folder: &Path, values: &[f64]) {
    let dictionary = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", values.len());
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(118_u16.to_le_bytes());
    bytes.extend(format!("{dictionary:<117}\n").as_bytes());
    bytes.extend(values.iter().flat_map(|x| x.to_le_bytes()));
    fs::write(folder.join("m.npy"), bytes).unwrap();
}

#[test]
fn the_paper_s_cycle_has_its_period_and_displacements() {
    let json = asperity(&format!("vibration cycle {PAPER} --damping-ratio 0.17 --json")).json(0);
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
fn the_paper_s_machine_may_be_stated_in_si() {
    // The unit of velocity is 2500 N/(1 kg · 316 rad/s) = 7.911 m/s, and its inverse that of the Stribeck coefficient.
    let machine = "--mass 1kg --natural-frequency 316rad/s --normal-force 2.5kN";
    let stated =
        "--static-friction 0.1 --damping-ratio 0.17 --belt-velocity 23.734177215189874mm/s --stribeck 0.53088s/m";
    let found = asperity(&format!("vibration cycle {machine} {stated} --json"));
    let json = found.json(0);
    close(number(&json, "period"), 6.372_163_483_739_709, 1e-12);
    close(number(&json, "displacement_max"), 0.101_931_013_749_859_7, 1e-12);
    assert!(found.stderr.contains("the unit of lengths is 25.04 mm, of times 3.165 ms, of velocities 7.911 m/s"));
    asperity(&format!("vibration cycle {stated}")).refuses(2, &["has a unit", "--mass, --natural-frequency"]);
    asperity(&format!("vibration cycle --mass 1kg {PAPER} --damping-ratio 0.17")).refuses(2, &["all of --mass"]);
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
    assert_eq!(json["limit_damping_ratio"], json["critical_damping_ratio"]);
    close(number(&json, "critical_damping_ratio"), 0.204_830_150_584_523_2, 1e-12);
    // 2ζ_H = aμ_st/(1 + aV)².
    close(number(&json, "hopf_damping_ratio"), 0.5 * 4.2 * 0.1 / (1.0 + 4.2 * 0.003_f64).powi(2), 1e-12);
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
    let run = |line: &str| run_in(folder.path(), line);
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
    let run = |line: &str| run_in(folder.path(), line);
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
        (
            "cycle --static-friction 1e300 --stribeck 4 --damping-ratio 0.1 --belt-velocity 1",
            ["static_friction", "between 1e-12 and 1000"],
        ),
        ("cycle --static-frction 0.1", ["--static-frction", "--static-friction"]),
    ] {
        asperity(&format!("vibration {line} --json")).refuses(2, &words);
    }
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
fn every_friction_law_has_its_flags() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("law.csv"), "velocity,friction\n0,0.4\n0.5,0.25\n1,0.1\n").unwrap();
    fs::write(folder.path().join("wrong.csv"), "velocity,friction\n0,0.4\n0.5,x\n").unwrap();
    let run = |line: &str| run_in(folder.path(), line);
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
    run(&format!("{base} --friction-table wrong.csv")).refuses(3, &["wrong.csv: line 3"]);
    run(&format!("{base} --stribeck 1 --linear-weakening 1")).refuses(2, &["cannot be used with"]);
}

#[test]
fn a_linear_law_that_becomes_negative_names_its_slope() {
    let line = "--static-friction 0.1 --linear-weakening 3 --belt-velocity 0.05 --damping-ratio 0.1";
    asperity(&format!("vibration cycle {line}")).refuses(2, &["slope"]);
}
