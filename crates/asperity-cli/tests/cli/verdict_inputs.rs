//! Uncertain values that no verdict can use.

use std::fs;

use tempfile::TempDir;

use crate::support::run_in;
use crate::verdict::{MACHINE, run};

#[test]
fn samples_with_decimal_commas_wrong_units_or_no_file_are_unusable_data() {
    let folder = TempDir::new().unwrap();
    let lines = "damping_ratio = { samples = \"m.csv\" }\n";
    fs::write(folder.path().join("study.toml"), format!("{MACHINE}dimensionless_belt_velocity = 0.1\n{lines}"))
        .unwrap();
    let ended = |samples: Option<&str>| {
        match samples {
            Some(text) => fs::write(folder.path().join("m.csv"), text).unwrap(),
            None => drop(fs::remove_file(folder.path().join("m.csv"))),
        }
        run_in(folder.path(), "check study.toml")
    };
    for (samples, words) in [
        (Some("0,10\n0,12\n1,11\n"), "m.csv:1: `0,10` may have a decimal comma"),
        (Some("damping\n0,10\n0,12\n"), "m.csv:2: `0,10` may have a decimal comma"),
        (Some("damping;part\n0,19;1\n0,18;2\n"), "m.csv:2: `0,19` may have a decimal comma"),
        (Some("z\n0.1;5\n0,15\n"), "m.csv:3: `0,15` may have a decimal comma"),
        (Some("0.10 mm\n0.12\n"), "m.csv:1: "),
        // A mark of the byte order is no name of a column.
        (Some("\u{feff}0.10 mm\n0.12\n"), "m.csv:1: "),
        (Some("damping\n0.10\nnothing\n"), "m.csv:3: "),
        (None, "m.csv: no such file"),
    ] {
        let ended = ended(samples);
        assert!(ended.code == 3 && ended.stderr.contains(words), "{samples:?}: {:?} {}", ended.code, ended.stderr);
    }
    for samples in [
        "damping,part\n0.10,1\n0.12,2\n",
        "damping,part\n0,10\n1,12\n",
        "# a; b\n0.10,1\n0.12,2\n",
        "damping;part\n0.10;1,5\n0.12;2,5\n",
        "damping\n0.10\n0.11\n",
    ] {
        let ended = ended(Some(samples));
        assert_eq!(ended.code, 0, "{samples}: {}", ended.stderr);
    }
}

/// Constant friction of 0.2 that falls by 0.5 s/m.
const PROCESS: &str = r#"{"format": "asperity friction process", "version": 1, "mean": 0.2, "mean_interval": null, "std": 0,
    "std_interval": null, "marginal": null, "correlation": null, "stribeck_s_per_m": 0.5, "averaged_over_m": null,
    "mean_pressure_pa": null, "origin": {"kind": "record", "description": "rig"}}"#;

#[test]
fn a_run_with_files_of_a_process_and_of_samples_is_reproduced() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("data")).unwrap();
    fs::write(at.join("data/process.json"), PROCESS).unwrap();
    fs::write(at.join("data/m.csv"), "0.20\n0.25\n0.30\n0.35\n").unwrap();
    let lines = MACHINE.replace("static_friction = 0.3\n", "").replace("friction_std = 0\n", "");
    let text = format!(
        "{lines}belt_velocity = \"0.4 m/s\"\nfriction_process = \"data/process.json\"\ndamping_ratio = {{ samples = \"data/m.csv\" }}\n\
         [verdict]\nevaluations = 1000\n"
    );
    fs::write(at.join("study.toml"), text).unwrap();
    let ended = run_in(at, "run study.toml --out run");
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let again = run_in(at, "repro run");
    assert_eq!(again.stdout, "IDENTICAL\n", "{}", again.stderr);
}

#[test]
fn the_stribeck_coefficient_of_a_friction_process_contradicts_another_uncertain_one() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("process.json"), PROCESS).unwrap();
    let lines = MACHINE.replace("static_friction = 0.3\n", "").replace("friction_std = 0\n", "");
    let check = |more: &str| {
        let text = format!("{lines}belt_velocity = \"0.4 m/s\"\nfriction_process = \"process.json\"\n{more}");
        fs::write(folder.path().join("study.toml"), text).unwrap();
        run_in(folder.path(), "check study.toml")
    };
    let remedy = "[verdict]\nremedies = [{ input = \"vibration.stribeck\", range = [\"0.1 s/m\", \"2 s/m\"] }]\n";
    for more in [
        "damping_ratio = 0.25\nstribeck = { uniform = [\"0.1 s/m\", \"2 s/m\"], unknown = true }\n".to_owned(),
        format!("damping_ratio = \"0.25 ± 0.01\"\nstribeck = \"0.1 s/m\"\n{remedy}"),
    ] {
        check(&more).refuses(3, &["friction_process: process.json", "the Stribeck coefficient, 0.5 s/m"]);
    }
    for more in [
        "damping_ratio = 0.25\nstribeck = \"0.5 ± 0.1 s/m\"\n".to_owned(),
        format!("damping_ratio = \"0.25 ± 0.01\"\nstribeck = \"0.5 s/m\"\n{remedy}"),
        "damping_ratio = \"0.25 ± 0.01\"\nstribeck = \"0.1 s/m\"\n".to_owned(),
    ] {
        let ended = check(&more);
        assert_eq!(ended.code, 0, "{more}: {}", ended.stderr);
    }
}

#[test]
fn wrong_uncertain_values_name_their_line() {
    let lines = "dimensionless_belt_velocity = 0.1\nvelocity_law = \"linear\"\nlinear_weakening = 0.1\n";
    for (more, line, expected) in [
        ("damping_ratio = \"0.05 ± -0.01\"\n", 12, "damping_ratio"),
        ("damping_ratio = \"0.05 ± 0.05\"\n", 12, "distribution"),
        ("damping_ratio = { normal = [0.05] }\n", 12, "a list of 2 values"),
        ("damping_ratio = { normal = [0.05, 0.01], known = true }\n", 12, "unknown key `known`"),
        ("damping_ratio = 0.05\nduration = \"640 ± 10\"\n", 13, "cannot be uncertain"),
        ("damping_ratio = \"0.05 ± 0.01\"\n[verdict]\ntargets = [0.0]\n", 14, "a probability from 0.001 to 0.999"),
        ("damping_ratio = 0.05\n[verdict]\ntargets = [1e-4]\n", 14, "a probability from 0.001 to 0.999"),
        ("damping_ratio = 0.05\n[verdict]\ntargets = []\n", 14, "no probability"),
        (
            "damping_ratio = 0.05\n[verdict]\nremedies = [{ input = \"vibration.dampng\", range = [0.1, 0.2] }]\n",
            14,
            "vibration.dampng",
        ),
        (
            "damping_ratio = 0.05\n[verdict]\nremedies = [{ input = \"vibration.normal_force\", range = [1, 2] }]\n",
            14,
            "has no unit",
        ),
        // The machine of a stated friction does not depend on the material.
        (
            "damping_ratio = 0.05\n[material]\nyoungs_modulus = \"2 GPa\"\nhardness = \"100 MPa\"\n[verdict]\n\
             remedies = [{ input = \"material.hardness\", range = [\"50 MPa\", \"0.2 GPa\"] }]\n",
            17,
            "`material.hardness` has no effect without [friction]",
        ),
        (
            "damping_ratio = 0.05\n[verdict]\nremedies = [{ input = \"vibration.mass\", range = [\"2 kg\", \"1 kg\"] }]\n",
            14,
            "in rising order",
        ),
        (
            "damping_ratio = \"0.05 ± 0.01\"\n[uncertainty]\ncorrelation = [[\"vibration.damping_ratio\", \"vibration.mass\", 0.5]]\n",
            14,
            "vibration.mass",
        ),
        ("damping_ratio = 0.05\n[verdict]\nthreshold = 1.0\n", 14, "a fraction of the time between 0 and 1"),
        ("damping_ratio = 0.05\n[uncertainty]\nsurface = 1\n", 14, "is not true or false"),
    ] {
        let ended = run(&format!("{lines}{more}"));
        assert_eq!(ended.code, 2, "{more}: {ended:?}");
        assert!(ended.stderr.contains(&format!("study.toml:{line}:")), "{more}: {}", ended.stderr);
        assert!(ended.stderr.contains(expected), "{more}: {}", ended.stderr);
    }
}
