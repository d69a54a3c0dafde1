//! Studies of two coupled modes against closed forms. With the default springs and dampers of 2ζ, μ_c = ¾(1 + 8ζ²), and flutter
//! begins with the frequency √2 ω₀.

use std::fs;
use std::path::Path;

use asperity_testing::StudyText;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{Finished, json_of, run_in};
use crate::verdict::{contains, pair};

const MACHINE: &str = "seed = 1\n[vibration]\nmodel = \"mode_coupling\"\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\n\
                       normal_force = \"2.5 kN\"\nnominal_area = \"833 mm^2\"\ndimensionless_belt_velocity = 0.5\n";

fn write(folder: &Path, friction: &str, lines: &str) {
    let text = format!("{MACHINE}static_friction = {friction}\nfriction_std = 0\n{lines}");
    fs::write(folder.join("study.toml"), text).unwrap();
}

fn run(friction: &str, lines: &str) -> Finished {
    let folder = TempDir::new().unwrap();
    write(folder.path(), friction, lines);
    run_in(folder.path(), "verdict study.toml --json")
}

fn verdict(friction: &str, lines: &str) -> Value {
    run(friction, lines).json(0)
}

fn results(folder: &Path, run: &str) -> Value {
    json_of(&folder.join(run).join("results.json"))
}

#[test]
fn undamped_modes_flutter_with_the_probability_that_friction_exceeds_the_coalescence() {
    // P(μ > ¾) with μ ~ N(.7, .05).
    let found = verdict("\"0.7 ± 0.05\"", "damping_ratio = 0\n");
    assert_eq!(found["model"], "mode_coupling");
    for key in ["probability", "probability_from_steady_sliding"] {
        contains(&found[format!("{key}_interval")], 0.158_655_3);
    }
    let driver = &found["drivers"][0];
    assert_eq!(driver["input"], "vibration.static_friction");
    assert!((driver["first_order"].as_f64().unwrap() - 1.0).abs() < 1e-3, "{found}");
    assert!((found["nominal"]["damping_margin"].as_f64().unwrap() - 0.05).abs() < 1e-12);
    assert_eq!(found["nominal"]["limit_damping_ratio"], 0.0);
    // The median of at least 2,048 margins has a standard error of at most .05·1.25/√2048.
    let median = found["margin_quantiles"].as_array().unwrap().iter().find(|q| q["probability"] == 0.5).unwrap();
    assert!((median["damping_margin"].as_f64().unwrap() - 0.05).abs() < 4.0 * 0.0014, "{median}");
    // Motion without damping does not repeat: it has the frequency √2 ω₀ of the coalesced modes, and no amplitude.
    let vibrating = &found["if_vibrating"];
    let hertz = vibrating["frequency_hz"]["q50"].as_f64().unwrap();
    assert!((hertz / (2.0_f64.sqrt() * 316.0 / std::f64::consts::TAU) - 1.0).abs() < 0.02, "{hertz}");
    assert!(vibrating["displacement_amplitude_m"].is_null(), "{vibrating}");
    // Friction that falls with the velocity belongs to the other machine.
    let inputs = found["rests_on"].as_array().unwrap().iter().map(|input| input["input"].as_str().unwrap());
    assert!(inputs.clone().any(|input| input == "vibration.damping_ratio"));
    assert!(!inputs.clone().any(|input| input.contains("stribeck") || input.contains("velocity_law")), "{found}");
    assert!(
        found["sentence"].as_str().unwrap().starts_with("Squeal by mode coupling at 71.2 Hz is unlikely"),
        "{found}"
    );
}

#[test]
fn damping_moves_the_critical_friction_by_the_closed_form() {
    for (ratio, critical) in [(0.05, 0.765), (0.1, 0.81)] {
        let folder = TempDir::new().unwrap();
        write(folder.path(), "0.8", &format!("damping_ratio = {ratio}\n"));
        let ended = run_in(folder.path(), "run study.toml --out run");
        assert_eq!(ended.code, 0, "{ended:?}");
        let results = results(folder.path(), "run");
        let found = &results["mode_coupling"];
        let number = |key: &str| found[key].as_f64().unwrap();
        assert!((number("critical_friction") - critical).abs() < 1e-12, "{found}");
        assert!((number("friction_margin") - (critical - 0.8)).abs() < 1e-12);
        let onset = 2.0_f64.sqrt() * 316.0 / std::f64::consts::TAU;
        assert!((number("onset_frequency_hz") / onset - 1.0).abs() < 1e-12, "{found}");
        // ¾(1 + 8ζ²) = .8.
        let limit = ((0.8 / 0.75 - 1.0) / 8.0_f64).sqrt();
        assert!((number("limit_damping_ratio") / limit - 1.0).abs() < 1e-10);
        let unstable = critical < 0.8;
        assert_eq!(found["kind"], if unstable { "flutter" } else { "none" });
        assert_eq!(found["motion"], if unstable { "cycle" } else { "steady" });
        assert_eq!(found["cycle"].is_null(), !unstable);
        assert!(results["vibration"].is_null());
        let page = fs::read_to_string(folder.path().join("run/report.html")).unwrap();
        let headline =
            format!("<strong class=\"{}\">", if unstable { "vibrates\">squeals<" } else { "quiet\">does not squeal<" });
        assert!(
            page.contains(headline.trim_end_matches("\">")) && page.contains("Modes over the friction coefficient")
        );
        // The study of the run folder states the default springs and runs again.
        let exact = run_in(folder.path(), "verdict run/study.toml --json").json(0);
        assert_eq!(exact["probability"], if unstable { 1.0 } else { 0.0 });
        assert!((exact["nominal"]["damping_margin"].as_f64().unwrap() - (critical - 0.8)).abs() < 1e-12);
        let wanted = if unstable { "The machine squeals by mode coupling" } else { "The machine does not squeal" };
        assert!(exact["sentence"].as_str().unwrap().starts_with(wanted), "{exact}");
    }
}

#[test]
#[ignore = "slow"]
fn a_remedy_of_the_damping_ratio_reaches_the_closed_form() {
    let lines = "damping_ratio = 0.02\n[verdict]\ntargets = [0.05]\n\
                 remedies = [{ input = \"vibration.damping_ratio\", range = [0.01, 0.2] }]\n";
    let found = verdict("\"0.7 ± 0.05\"", lines);
    let reach = &found["remedies"][0]["reach"][0];
    // Vibration begins with the frequency √2 ω₀, and lift-off changes it little just above the critical coefficient.
    let vibrating = &found["if_vibrating"];
    assert!((vibrating["kinds"]["flutter"].as_f64().unwrap() - 1.0).abs() < 1e-12, "{found}");
    let onset = 2.0_f64.sqrt() * 316.0 / std::f64::consts::TAU;
    assert!((vibrating["frequency_hz"]["q50"].as_f64().unwrap() / onset - 1.0).abs() < 0.02, "{found}");
    // P(μ > ¾(1 + 8ζ²)) = .05.
    let wanted = (((0.7 + 0.05 * 1.644_853_627) / 0.75 - 1.0) / 8.0_f64).sqrt();
    contains(&reach["value_interval"], wanted);
    assert!((reach["value"].as_f64().unwrap() / wanted - 1.0).abs() < 0.01, "{reach} {wanted}");
}

#[test]
#[ignore = "slow"]
fn the_map_of_damping_and_friction_is_the_closed_form() {
    let lines = "damping_ratio = \"0.1 ± 0.01\"\n[verdict]\nremedies = [{ input = \"vibration.damping_ratio\", range = [0.05, 0.2] }, \
                 { input = \"vibration.static_friction\", range = [0.7, 0.9] }]\n";
    let found = verdict("\"0.8 ± 0.05\"", lines);
    let values = |axis: &str| -> Vec<f64> {
        found["map"][axis]["values"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
    };
    for (row, friction) in values("y").into_iter().enumerate() {
        for (column, damping) in values("x").into_iter().enumerate() {
            // P(μ > ¾(1 + 8ζ²)), to first order in the scatter of ζ.
            let std = 0.05_f64.hypot(12.0 * damping * 0.01);
            let wanted =
                asperity::distribution::standard_normal_cdf((friction - 0.75 * (1.0 + 8.0 * damping * damping)) / std);
            let probability = found["map"]["probability"][row][column].as_f64().unwrap();
            // The standard error of 512 independent machines, which Sobol' points undercut.
            assert!((probability - wanted).abs() < 0.022, "{probability} instead of {wanted} at {damping}, {friction}");
        }
    }
}

#[test]
#[ignore = "slow"]
fn rare_flutter_has_both_ends_of_its_interval_above_zero() {
    // P(μ > ¾) with μ ~ N(.5, .05): five standard deviations.
    let found = verdict("\"0.5 ± 0.05\"", "damping_ratio = 0\n");
    contains(&found["probability_interval"], 2.866_516e-7);
    let [low, high] = pair(&found["probability_interval"]);
    assert!(low > 0.0 && high < 3.0 * low, "{low} to {high}");
    assert!(found["sentence"].as_str().unwrap().contains("machines like this one flutter"), "{found}");
}

#[test]
fn keys_of_the_other_model_are_errors_with_their_name() {
    for line in [
        "stribeck = 4.2",
        "velocity_law = \"linear\"\nlinear_weakening = 0.1",
        "kinetic_share = 0.9",
        "forcing = \"1 N\"\nforcing_frequency = \"3 rad/s\"",
        "damping_sweep = [0.1, 0.2, 3]",
        "trajectories = 20",
        "drive = \"time\"",
    ] {
        let ended = run("0.7", &format!("damping_ratio = 0.05\n{line}\n"));
        let key = line.split(' ').next().unwrap();
        assert_eq!(ended.code, 2, "{ended:?}");
        assert!(ended.stderr.contains(key) && ended.stderr.contains("model = \"stick_slip\""), "{ended:?}");
    }
    // Default values are no error.
    assert_eq!(run("0.7", "damping_ratio = 0.05\nvelocity_law = \"stribeck\"\ntrajectories = 200\n").code, 0);
    for (line, words) in [
        ("contact_spring = \"surface\"", "[friction]"),
        ("contact_spring = \"pad\"", "surface"),
        ("contact_spring = 0", "contact_spring"),
        ("springs = [1.0]", "found 1 value, expected 2"),
        ("springs = [0.0, 0.0]", "springs do not hold the mass"),
    ] {
        let ended = run("0.7", &format!("damping_ratio = 0.05\n{line}\n"));
        assert!(ended.code == 2 && ended.stderr.contains(words), "{line}: {ended:?}");
    }
    let folder = TempDir::new().unwrap();
    let one_mode = MACHINE.replace("model = \"mode_coupling\"\n", "");
    let text =
        format!("{one_mode}static_friction = 0.3\nfriction_std = 0\ndamping_ratio = 0.1\nsprings = [1.0, 2.0]\n");
    fs::write(folder.path().join("study.toml"), text).unwrap();
    let ended = run_in(folder.path(), "verdict study.toml --json");
    assert!(ended.code == 2 && ended.stderr.contains("requires model = \"mode_coupling\""), "{ended:?}");
}

#[test]
#[ignore = "slow"]
fn springs_and_angles_may_be_uncertain() {
    // μ_c = ((k₁₁ − k₂₂)² + 4k₁₂²)/(4k₁₂k₃) = 1/k₃ + …; with the default springs k₂₂ = ⅔ + k₃, k₁₁ = 2 and k₁₂ = 1.
    let found =
        verdict("0.6", "damping_ratio = 0\ncontact_spring = \"1.4 ± 0.05\"\nspring_angles = [150, \"30 ± 0.5\"]\n");
    let k3 = 1.4;
    let critical = ((2.0_f64 - 2.0 / 3.0 - k3).powi(2) + 4.0) / (4.0 * k3);
    assert!((found["nominal"]["damping_margin"].as_f64().unwrap() - (critical - 0.6)).abs() < 1e-12, "{found}");
    let names: Vec<&str> =
        found["drivers"].as_array().unwrap().iter().map(|driver| driver["input"].as_str().unwrap()).collect();
    assert_eq!(names, ["vibration.contact_spring", "vibration.spring_angles[1]"]);
}

#[test]
#[ignore = "slow"]
fn the_contact_spring_of_the_surface_is_the_computed_stiffness_over_the_nominal_area() {
    let folder = TempDir::new().unwrap();
    let friction = "strip = [\"600 um\", \"40 um\"]\nwindow = \"60 um\"\npoints = [256, 16]\npercentiles = [25.0]";
    let text = StudyText::new(5, &["surface", "material", "friction", "vibration"])
        .with("surface", "rms_height = \"1 um ± 0.05 um\"")
        .with("friction", friction)
        .with("vibration", "model = \"mode_coupling\"\nnatural_frequency = \"60000 rad/s\"\nnominal_area = \"1 mm^2\"")
        .with("vibration", "belt_velocity = \"1 m/s\"\ndamping_ratio = 0.02\ncontact_spring = \"surface\"")
        .without("material", &["hardness"])
        .without("vibration", &["dimensionless_belt_velocity"])
        .to_string();
    fs::write(folder.path().join("study.toml"), text).unwrap();
    let ended = run_in(folder.path(), "run study.toml --out run");
    assert_eq!(ended.code, 0, "{ended:?}");
    let results = results(folder.path(), "run");
    let point = &results["friction"]["operating_point"];
    let stiffness = point["contact_stiffness_pa_per_m"].as_f64().unwrap();
    let error = point["contact_stiffness_pa_per_m_se"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.2 * stiffness, "{point}");
    let found = &results["mode_coupling"];
    let newton = found["contact_stiffness_n_per_m"].as_f64().unwrap();
    assert!((newton / (stiffness * 1e-6) - 1.0).abs() < 1e-12, "{found}");
    assert!((found["contact_spring"].as_f64().unwrap() / (newton / 60_000_f64.powi(2)) - 1.0).abs() < 1e-12);
    // The samples have the stiffness of their own surface, which falls about as 1/h_rms.
    let table = fs::read_to_string(folder.path().join("run/tables/verdict_samples.csv")).unwrap();
    let mut rows = table.lines();
    let names: Vec<&str> = rows.next().unwrap().split(',').collect();
    let column = |name: &str| names.iter().position(|own| *own == name).unwrap();
    let (height, stiff) = (column("surface.rms_height"), column("contact_stiffness_n_per_m"));
    let number = |row: &str, place: usize| row.split(',').nth(place).unwrap().parse::<f64>().unwrap();
    let mut samples: Vec<[f64; 2]> = rows.map(|row| [number(row, height), number(row, stiff)]).collect();
    samples.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let [low, high] = [samples[samples.len() / 20], samples[samples.len() * 19 / 20]];
    let exponent = (high[1] / low[1]).ln() / (high[0] / low[0]).ln();
    assert!((exponent + 1.0).abs() < 0.35, "{exponent}");
}
