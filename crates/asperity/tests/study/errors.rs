//! Errors of studies: their kind and line, and warnings about keys without effect.

use std::path::Path;

use asperity::study::{FailureKind, Stage, Study};
use asperity_testing::METHODS;

use crate::support::{MODEL, changed, run, run_in, study};

#[test]
fn failures_have_their_kind() {
    let unloaded = changed(&MODEL, &[("[60.0, 20.0]", "[0.0001]"), ("duration = 40.0", "level = 0.0001")]);
    let error = run_in(Path::new("."), &unloaded, Some(Stage::Friction)).unwrap_err();
    assert_eq!(error.kind(), FailureKind::NotConverged);
    assert!(error.to_string().contains("percentile 0.0001") && error.to_string().contains("carry load"), "{error}");
    // A patch has no more modes than points; a warning reports the others.
    let many = changed(&MODEL, &[("modes = 30", "modes = 100000")]);
    let results = run_in(Path::new("."), &many, Some(Stage::Pressure)).unwrap().results;
    assert!(results.warnings.iter().any(|warning| warning.contains("100000")), "{:?}", results.warnings);
    assert_eq!(results.surface.unwrap().karhunen_loeve.unwrap().modes, 21 * 17);
    let impossible = changed(&MODEL, &[("realisations = 3", "realisations = 3\ntolerance = 1e-30")]);
    let error = run_in(Path::new("."), &impossible, Some(Stage::Friction)).unwrap_err();
    assert_eq!(error.kind(), FailureKind::NotConverged, "{error}");
    assert!(error.to_string().contains("percentile 60"), "{error}");
    let deep = changed(&MODEL, &[("degree = 1", "degree = 60"), ("variables = 2", "variables = 30")]);
    let error = Study::parse(&deep, "study.toml").unwrap_err();
    assert!(error.message.contains("60") && error.message.contains("terms"), "{error}");
}

#[test]
#[ignore = "slow"]
fn a_search_without_result_has_not_converged() {
    // Without damping and with hardly any friction, vibration grows over more than a million steps.
    let slow = "seed = 1\n[vibration]\nmass = \"257 kg\"\nnatural_frequency = \"25800 rad/s\"\ndamping_ratio = 0\n\
                normal_force = \"1.76e6 N\"\nbelt_velocity = \"0.217 m/s\"\n\
                nominal_area = \"1 cm^2\"\nstatic_friction = 1.23e-6\nfriction_std = 1e-9\n\
                friction_correlation_length = \"83 um\"\nfriction_marginal = \"normal\"\n                velocity_law = \"stribeck\"\nstribeck = 5.71\n";
    let error = run_in(Path::new("."), slow, None).unwrap_err();
    assert_eq!(error.kind(), FailureKind::NotConverged, "{error}");
    assert!(error.to_string().contains("million steps"), "{error}");
}

#[test]
fn errors_name_their_line_in_any_layout() {
    let line_of = |from: &str| MODEL[..MODEL.find(from).unwrap()].lines().count() + 1;
    for (from, to, line, wanted) in [
        // Arrays over several lines, inline tables, dotted keys.
        ("[\"20 um\", \"12 um\"]", "[\n\"20 um\",\n\"12\"\n]", line_of("correlation_length") + 2, "no unit"),
        ("[60.0, 20.0]", "[\n60.0,\n\"20\"]", line_of("percentiles") + 2, "write 20 without quotation marks"),
        ("[60.0, 20.0]", "[60.0, 60.0]", line_of("percentiles"), "60 twice"),
        ("[60.0, 20.0]", "[]", line_of("percentiles"), "at least one"),
        ("points = [21, 17]", "points = [21]", line_of("points = [21"), "found 1 value, expected 2"),
        ("points = [21, 17]", "points = [21, 1]", line_of("points = [21"), "at least 2"),
        ("modes = 30", "modes = 30\nmodes = 31", line_of("modes") + 1, "duplicate key"),
        ("modes = 30", "modes = -1", line_of("modes"), "-1"),
        ("seed = 11", "seed = 1.5", 1, "1.5"),
        ("degree = 1", "\"degree\" = 1\n'percentile' = 10", line_of("degree") + 1, "duplicate key"),
        ("99 um", "0.5 mm", line_of("window"), "ten windows"),
        ("damping_ratio = 0.17", "damping_ratio = -0.1", line_of("damping_ratio"), "zero or a positive value"),
        ("[0.1, 0.5, 2]", "[0.5, 0.1, 2]", line_of("damping_sweep"), "end above the start"),
        ("\"833 mm^2\"", "\"1 mm^2\"", line_of("nominal_area"), "not below the hardness"),
        (
            "duration = 40.0",
            "duration = 40.0\n[counterface]\nhardness = \"2 MPa\"",
            line_of("nominal_area"),
            "not below the hardness 2 MPa",
        ),
        ("duration = 40.0", "duration = 40.0\nlevel = 33.0", line_of("duration") + 1, "33"),
        ("\"normal\"", "\"lognormal:0,-1\"", line_of("marginal"), "marginal"),
    ] {
        let text = changed(&MODEL, &[(from, to)]);
        for text in [text.clone(), text.replace('\n', "\r\n"), format!("\u{feff}{text}")] {
            let error = Study::parse(&text, "study.toml").unwrap_err();
            assert_eq!(error.line, line, "{from} → {to}: {error}");
            assert!(error.message.contains(wanted), "{from} → {to}: {error}");
        }
    }
    let surface = &MODEL[MODEL.find("[surface]").unwrap()..MODEL.find("[material]").unwrap()];
    let inline = "surface = { covariance = \"exponential\", marginal = \"normal\", rms_height = \"-1 um\", \
                  correlation_length = [\"1 um\", \"1 um\"] }\n";
    let dotted = "surface.covariance = \"exponential\"\nsurface.marginal = \"normal\"\nsurface.rms_height = \"-1 um\"\n\
                  surface.correlation_length = [\"1 um\", \"1 um\"]\n";
    for (layout, line) in [(inline, 2), (dotted, 4)] {
        let error = Study::parse(&changed(&MODEL, &[(surface, layout)]), "study.toml").unwrap_err();
        assert_eq!(error.line, line, "{error}");
        assert!(error.message.contains("positive"), "{error}");
    }
}

#[test]
fn a_list_of_another_length_is_an_error_at_its_line() {
    let more = [
        ("modes = 30", "modes = 30\npixel_size = [\"2 um\", \"2 um\"]"),
        ("percentile = 50.0", "percentile = 50.0\ncell = [1, 2]"),
    ];
    let map = "[vibration.map]\nover = \"damping_velocity\"\nx = [0.05, 0.3, 4]\ny = [0.001, 0.01, 3]\n";
    let text = changed(&MODEL, &more) + map;
    study(&text);
    let is_fixed =
        |line: &str| line.contains("= [") && !line.starts_with("percentiles") && !line.starts_with("methods");
    let lists = text.lines().enumerate().filter(|(_, line)| is_fixed(line));
    let mut keys = Vec::new();
    for (index, line) in lists {
        let (key, values) = line.strip_suffix(']').unwrap().split_once(" = [").unwrap();
        let values: Vec<&str> = values.split(", ").collect();
        for count in [values.len() - 1, values.len() + 1, values.len() + 2] {
            let other: Vec<&str> = values.iter().cycle().take(count).copied().collect();
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            lines[index] = format!("{key} = [{}]", other.join(", "));
            let error = Study::parse(&lines.join("\n"), "study.toml").unwrap_err();
            let noun = if count == 1 { "value" } else { "values" };
            let wanted = format!("found {count} {noun}, expected {}", values.len());
            assert_eq!((error.line, error.message), (index + 1, wanted), "{key}");
        }
        keys.push(key);
    }
    let all =
        ["correlation_length", "pixel_size", "size", "points", "cell", "strip", "points", "damping_sweep", "x", "y"];
    assert_eq!(keys, all);
}

#[test]
fn a_key_without_effect_gives_a_warning() {
    let text = changed(
        &MODEL,
        &[("modes = 30", "modes = 30\nhurst = 0.8"), ("[pressure]", "[pressure]\nmean_compliance = \"20 nm/MPa\"")],
    );
    let idle = study(&text).file().keys_without_effect();
    assert_eq!(idle.len(), 2, "{idle:?}");
    assert!(idle[0].contains("hurst") && idle[1].contains("[pressure] mean_compliance"), "{idle:?}");
    assert_eq!(run(&text, Some(Stage::Surface)).results.warnings[..2], idle);
    let spectral = study(&changed(&MODEL, &[("modes = 30", "modes = 30\ngenerator = \"spectral\"")]));
    assert_eq!(
        spectral.file().keys_without_effect(),
        ["[surface] modes has no effect without the generator karhunen_loeve"]
    );
    let alone = study(&changed(&MODEL, &[(METHODS, "methods = [\"default\"]")])).file().keys_without_effect();
    assert!(alone.len() == 1 && alone[0].starts_with("[pressure] reference_samples has no effect"), "{alone:?}");
    assert!(study(&MODEL).file().keys_without_effect().is_empty());
}
