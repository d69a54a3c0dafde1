//! Tests of the curves, diagrams, maps and modes of `asperity vibration`.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::{PAPER, asperity, close, number, run_in};

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
        let map = run_in(folder.path(), &map).json(0);
        let corner = map["points"].as_array().unwrap().iter().find(|p| p["x"] == 0.02 && p["y"] == 2.0).unwrap();
        let line = format!("vibration critical-damping --static-friction 0.1 {heavy} --belt-velocity 0.01 --json");
        let wanted = run_in(folder.path(), &line).json(0);
        close(number(corner, "limit_damping_ratio"), number(&wanted, "limit_damping_ratio"), 1e-12);
    }
}

#[test]
#[ignore = "slow"]
fn a_motion_that_neither_sticks_nor_slides_steadily_is_reported() {
    // ζ_c lies far below ζ_H = 375: between them the mass vibrates without sticking.
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("steep.txt"), "0 0.1\n0.001 0.1\n0.0011 0.05\n1 0.04\n").unwrap();
    let law = "--static-friction 0.1 --friction-table steep.txt --belt-velocity 0.00105";
    let found = run_in(folder.path(), &format!("vibration cycle {law} --damping-ratio 23 --json"));
    let answer = found.json(0);
    assert_eq!((&answer["limit_cycle"], &answer["kind"]), (&Value::Bool(true), &"slip_cycle".into()));
    assert_eq!(answer["steady_sliding_unstable"], Value::Bool(true));
    assert_eq!(answer["slip_duration"], answer["period"]);
    let limit = run_in(folder.path(), &format!("vibration critical-damping {law} --json")).json(0);
    assert!(number(&limit, "hopf_damping_ratio") > 23.0);
    assert!(number(&limit, "critical_damping_ratio") < 23.0);
    // Every start leads to this cycle.
    let starts = "--displacements 0,0.15,8 --velocities -0.001,0.001,8 --json";
    let basin = run_in(folder.path(), &format!("vibration basin {law} --damping-ratio 23 {starts}")).json(0);
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
