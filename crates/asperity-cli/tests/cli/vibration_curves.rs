//! Tests of the curves, diagrams, maps and modes of `asperity vibration`.

use serde_json::Value;

use crate::support::{PAPER, asperity, close, number};

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
