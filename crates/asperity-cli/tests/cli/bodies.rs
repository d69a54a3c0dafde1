//! Studies of a rough slider, and of a counterface that is elastic or rough.

use std::fs;
use std::path::Path;

use asperity_formats::read_npz;
use ndarray::Array2;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{Finished, close, json_of, number, run_in};

/// A stated surface; `generator = "spectral"`, so that its patches have the whole variance.
const SURFACE: &str = "seed = 7\n[surface]\ngenerator = \"spectral\"\ncovariance = \"squared_exponential\"\nmarginal = \"normal\"\n\
                       rms_height = \"0.1 um\"\ncorrelation_length = \"8 um\"\n";
const MATERIAL: &str = "[material]\nyoungs_modulus = \"210 GPa\"\nhardness = \"2 GPa\"\nshear_strength = \"385 MPa\"\n";
const PRESSURE: &str = "[pressure]\nsize = [\"48 um\", \"32 um\"]\npoints = [24, 16]\npercentile = 30.0\nfine_solves = 10\n\
                        methods = ['monte_carlo']\nreference_samples = 40\nvariables = 2\ndegree = 1\n";
const FRICTION: &str = "[friction]\nstrip = [\"400 um\", \"32 um\"]\npoints = [100, 8]\nwindow = \"40 um\"\n\
                        percentiles = [50.0]\nrealisations = 6\n";
const VIBRATION: &str = "[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\ndamping_ratio = 0.17\nnormal_force = \"2.5 kN\"\n\
     nominal_area = \"833 mm^2\"\ndimensionless_belt_velocity = 0.003\ndamping_sweep = [0.1, 0.3, 2]\ntrajectories = 2\n\
     duration = 32.0\n";

/// Runs a study into `folder/name` and returns the output of the program and `results.json`.
fn run(folder: &Path, name: &str, text: &str) -> (Finished, Value) {
    fs::write(folder.join(format!("{name}.toml")), text).unwrap();
    let ended = run_in(folder, &format!("run {name}.toml --out {name}"));
    assert_eq!(ended.code, 0, "{ended:?}");
    (ended, json_of(&folder.join(name).join("results.json")))
}

/// Returns the results of a study without the sentences, which name the counterface.
fn numbers(folder: &Path, name: &str, text: &str) -> Value {
    let mut results = run(folder, name, text).1;
    results["assumptions"].take();
    results
}

#[test]
fn a_rough_slider_has_the_windows_of_a_rough_track_but_constant_friction() {
    let folder = TempDir::new().unwrap();
    let text = [SURFACE, MATERIAL, FRICTION, VIBRATION, "level = 50.0\n"].concat();
    let (_, track) = run(folder.path(), "track", &text);
    let (_, slider) = run(folder.path(), "slider", &text.replace("[surface]\n", "[surface]\nbody = \"slider\"\n"));
    assert_eq!([&track["friction"]["body"], &slider["friction"]["body"]], ["track", "slider"]);
    // The same windows: only what describes their course along the path differs.
    assert_eq!(track["friction"]["operating_point"], slider["friction"]["operating_point"]);
    assert_eq!(track["friction"]["cutoff"], slider["friction"]["cutoff"]);
    let levels = |results: &Value| results["friction"]["levels"].as_array().unwrap().clone();
    for (of_track, of_slider) in levels(&track).iter().zip(&levels(&slider)) {
        for key in ["mean", "std", "std_interval", "skewness", "marginal", "upscaling", "effective_windows", "tail"] {
            assert_eq!(of_track[key], of_slider[key], "{key}");
        }
        let [along, carried] = [of_track, of_slider].map(|level| &level["at_mean_load"]);
        for key in ["mean", "std", "marginal", "laws"] {
            assert_eq!(along[key], carried[key], "{key}");
        }
        assert!(along["correlation_length_m"].is_number() && carried["correlation_length_m"].is_null());
        assert!(of_slider["correlation_length_m"].is_null());
        assert!(of_track["between_parts_std"].is_null() && of_track["between_parts_std_interval"].is_null());
        for key in ["std", "std_interval"] {
            assert_eq!(of_slider[&format!("between_parts_{key}")], carried[key]);
        }
        assert_eq!(carried["correlation_models"], Value::Array(Vec::new()));
        for key in ["correlation_length_without_window_m", "window_only", "stationarity"] {
            assert!(!of_track[key].is_null() && of_slider[key].is_null(), "{key}: {of_slider}");
        }
    }
    for (name, present) in [("track", true), ("slider", false)] {
        let run = folder.path().join(name);
        for file in ["friction_process.json", "tables/friction_acf.csv", "tables/friction_trace.csv"] {
            assert_eq!(run.join(file).exists(), present, "{name}/{file}");
        }
        assert!(run.join("tables/friction_histogram.csv").exists());
    }
    let page = fs::read_to_string(folder.path().join("slider/report.html")).unwrap();
    for wanted in ["between parts", "The slider is rough and the track smooth"] {
        assert!(page.contains(wanted), "{wanted}");
    }
    // The machine is that of the same friction, stated as constant.
    let mean = slider["friction"]["operating_point"]["mean"].as_f64().unwrap();
    let stated = format!(
        "seed = 7\n{VIBRATION}static_friction = {mean:?}\nfriction_std = 0.0\nfriction_correlation_length = \"80 um\"\n\
         friction_marginal = \"normal\"\n"
    );
    let (_, stated) = run(folder.path(), "stated", &stated);
    let [carried, constant] = [&slider, &stated].map(|results| &results["vibration"]);
    for key in ["static_friction", "cycle", "kind", "limit_damping_ratio", "kick_m_per_s", "paper", "area", "marginal"]
    {
        assert_eq!(carried[key], constant[key], "{key}");
    }
    assert_eq!(carried["paper"]["friction_std"], 0.0);
    for key in ["friction_correlation_length_m", "correlation_length"] {
        assert!(carried[key].is_null() && track["vibration"][key].is_number(), "{key}");
    }
    assert!(number(&track["vibration"]["paper"], "friction_std") > 0.0);
}

#[test]
#[ignore = "slow"]
fn an_elastic_or_softer_counterface_changes_modulus_and_hardness_alone() {
    let folder = TempDir::new().unwrap();
    let study = |material: &str, counterface: &str| [SURFACE, material, PRESSURE, counterface].concat();
    let friction = FRICTION.replace("realisations = 6", "realisations = 3");
    let alone = numbers(folder.path(), "alone", &study(MATERIAL, &friction));
    assert!(alone["counterface"].is_null());
    let twice = MATERIAL.replace("210 GPa", "420 GPa");
    for (name, material, counterface) in [
        ("stiff", MATERIAL, format!("youngs_modulus = \"1e28 Pa\"\n{friction}")),
        ("hard", MATERIAL, "hardness = \"5 GPa\"\n".to_owned()),
        ("equal", &twice, "youngs_modulus = \"420 GPa\"\n".to_owned()),
        ("soft", &MATERIAL.replace("2 GPa", "3 GPa"), "hardness = \"2 GPa\"\n".to_owned()),
    ] {
        let found = numbers(folder.path(), name, &study(material, &format!("[counterface]\n{counterface}")));
        for stage in ["pressure", "surface"] {
            assert_eq!(found[stage], alone[stage], "{name}: {stage}");
        }
        assert!(found["friction"] == alone["friction"] || name != "stiff");
    }
    // A third of the compliance is that of the counterface.
    let steel = "[counterface]\nyoungs_modulus = \"420 GPa\"\n";
    let assumptions = run(folder.path(), "pair", &study(MATERIAL, steel)).1["assumptions"].to_string();
    assert!(assumptions.contains("E* = 153.8 GPa") && assumptions.contains("smooth and elastic"), "{assumptions}");
}

/// Both bodies have half of the variance of [`SURFACE`].
fn halved() -> String {
    let rms = format!("rms_height = \"{:?} um\"", 0.1 * 0.5_f64.sqrt());
    let own = SURFACE.replace("rms_height = \"0.1 um\"", &rms);
    format!(
        "{own}[counterface]\ncovariance = \"squared_exponential\"\nmarginal = \"normal\"\n{rms}\ncorrelation_length = \"8 um\"\n"
    )
}

/// Asserts that two estimates from independent samples agree within four joint standard errors.
fn alike([a, b]: [f64; 2], [error_a, error_b]: [f64; 2], what: &str) {
    let error = error_a.hypot(error_b);
    assert!((a - b).abs() < 4.0 * error, "{what}: {a} and {b}, joint standard error {error}");
    assert!(a != b && error < 0.25 * a, "{what}: {a} ± {error_a}");
}

#[test]
fn the_pressure_of_two_bodies_of_half_the_variance_is_that_of_one() {
    let folder = TempDir::new().unwrap();
    let many = PRESSURE.replace("reference_samples = 40", "reference_samples = 500");
    let (_, one) = run(folder.path(), "one", &[SURFACE, MATERIAL, &many].concat());
    let (_, two) = run(folder.path(), "two", &[&halved(), MATERIAL, &many].concat());
    close(number(&two["pressure"], "separation_m"), number(&one["pressure"], "separation_m"), 1e-12);
    close(number(&two["surface"]["covariance"], "std_m"), 1e-7 * 0.5_f64.sqrt(), 1e-12);
    assert_eq!(two["counterface"]["covariance"], two["surface"]["covariance"]);
    let both = |key: &str| [&one, &two].map(|results| number(&results["pressure"], key));
    alike(both("contact_probability"), both("contact_probability_se"), "contact probability");
    alike(both("mean_pa"), both("mean_se_pa"), "mean pressure");
}

#[test]
fn the_friction_of_two_bodies_of_half_the_variance_has_the_moments_of_one_and_no_path() {
    let folder = TempDir::new().unwrap();
    // The intervals contain the error of the pitch, which is small on these points.
    let friction = FRICTION.replace("[100, 8]", "[200, 16]").replace("realisations = 6", "realisations = 12");
    let (_, one) = run(folder.path(), "one", &[SURFACE, MATERIAL, &friction].concat());
    let (_, two) = run(folder.path(), "two", &[&halved(), MATERIAL, &friction].concat());
    assert_eq!(two["friction"]["body"], "both");
    let both = |key: &str| [&one, &two].map(|results| number(&results["friction"]["operating_point"], key));
    let errors = |key: &str| {
        [&one, &two].map(|results| {
            let ends = &results["friction"]["operating_point"][key];
            (ends[1].as_f64().unwrap() - ends[0].as_f64().unwrap()) / (2.0 * 1.96)
        })
    };
    alike(both("mean"), errors("mean_interval"), "mean friction");
    alike(both("std"), errors("std_interval"), "standard deviation of friction");
    assert!(two["friction"]["levels"][0]["at_mean_load"]["correlation_length_m"].is_null());
    let run = folder.path().join("two");
    assert!(!run.join("friction_process.json").exists());
    let page = fs::read_to_string(run.join("report.html")).unwrap();
    assert!(page.contains("Both bodies are rough") && page.contains("The counterface is rough too"));
}

#[test]
#[ignore = "slow"]
fn two_rough_bodies_drive_the_vibration_by_the_fluctuation_along_the_path() {
    let folder = TempDir::new().unwrap();
    let friction = FRICTION.replace("percentiles = [50.0]", "percentiles = [30.0, 50.0]");
    let text = [&halved(), MATERIAL, &friction, VIBRATION, "level = 50.0\n"].concat();
    let (_, results) = run(folder.path(), "both", &text);
    assert_eq!(results["friction"]["body"], "both");
    let levels = results["friction"]["levels"].as_array().unwrap();
    let (other, lead) = (&levels[0], &levels[1]);
    assert!(other["between_parts_std"].is_null() && lead["leading"] == true);
    let between_parts = number(lead, "between_parts_std");
    let ends = [0, 1].map(|end| lead["between_parts_std_interval"][end].as_f64().unwrap());
    assert!((0.0..=between_parts).contains(&ends[0]) && ends[1] > between_parts, "{ends:?} {between_parts}");
    // Parts and path share the variance of all windows, and the machine has that of the path.
    let vibration = &results["vibration"];
    let along = number(&vibration["paper"], "friction_std");
    assert!(along > 0.0);
    close(along.hypot(between_parts), number(&lead["at_mean_load"], "std"), 1e-9);
    let area = number(&vibration["area"], "friction_std") / along;
    close(area * area, number(vibration, "variance_reduction"), 1e-9);
    // The contacts of two bodies change within the window.
    let length_m = number(vibration, "friction_correlation_length_m");
    assert!(length_m > 1e-6 && length_m < 60e-6, "{length_m}");
    assert!(lead["at_mean_load"]["correlation_length_m"].is_null());
    let page = fs::read_to_string(folder.path().join("both/report.html")).unwrap();
    assert!(page.contains("Both bodies are rough: the counterface is the slider"));
}

#[test]
fn a_study_presses_a_scanned_counterface_as_asperity_contact_does() {
    let folder = TempDir::new().unwrap();
    let drawn = SURFACE.replace("[surface]", "size = [\"64 um\", \"64 um\"]\npoints = [32, 32]\n[surface]");
    fs::write(folder.path().join("spec.toml"), drawn).unwrap();
    let drawn = run_in(folder.path(), "surface generate spec.toml --out pad.x3p");
    assert_eq!(drawn.code, 0, "{drawn:?}");
    let pressed = PRESSURE.replace("percentile = 30.0", "mean_pressure = \"300 MPa\"");
    let (_, results) = run(
        folder.path(),
        "pair",
        &format!(
            "{SURFACE}[counterface]\nfile = \"pad.x3p\"\nlevel = \"mean\"\ncovariance = \"squared_exponential\"\n\
             correlation_length = \"8 um\"\nyoungs_modulus = \"100 GPa\"\npoisson_ratio = 0.4\nhardness = \"1.5 GPa\"\n\
             {MATERIAL}{pressed}"
        ),
    );
    let statistics = run_in(folder.path(), "surface stats pad.x3p --level mean --json").json(0);
    assert_eq!(results["counterface"]["Sq_m"], statistics["Sq_m"]);
    let field = |name: &str, unit: &str| -> Array2<f64> {
        let archive = fs::read(folder.path().join(format!("pair/fields/{name}.npz"))).unwrap();
        read_npz(&archive, &format!("{name}_{unit}")).unwrap()
    };
    let (pressure_pa, map) = (field("pressure_sample", "pa"), field("counterface_sample", "m"));
    assert_ne!(field("surface_sample", "m"), map);
    let pressed = run_in(
        folder.path(),
        "contact pair/fields/surface_sample.npz --counterface pair/fields/counterface_sample.npz --level none --json \
         --youngs-modulus 210GPa --counterface-youngs-modulus 100GPa --counterface-poisson-ratio 0.4 \
         --hardness 1.5GPa --mean-pressure 300MPa --boundary free --tolerance 1e-6",
    );
    let pressed = pressed.json(0);
    let (cells, touching) = (pressure_pa.len() as f64, pressure_pa.iter().filter(|p| **p > 0.0).count() as f64);
    close(number(&pressed, "contact_fraction"), touching / cells, 1e-9);
    close(number(&pressed, "mean_pressure_pa"), pressure_pa.sum() / cells, 1e-6);
    close(number(&pressed, "max_pressure_pa"), pressure_pa.iter().copied().fold(0.0, f64::max), 1e-4);
    let capped = pressure_pa.iter().filter(|p| **p >= 1.5e9 * (1.0 - 1e-9)).count() as f64;
    assert!(capped > 0.0);
    close(number(&pressed, "plastic_fraction"), capped / cells, 1e-9);
    // The study of the run folder finds the scan from anywhere.
    let again = run_in(folder.path(), "check pair/study.toml");
    assert_eq!(again.code, 0, "{again:?}");
    let provenance = fs::read_to_string(folder.path().join("pair/provenance.json")).unwrap();
    assert!(provenance.contains("pad.x3p"), "{provenance}");
    assert!(fs::read_to_string(folder.path().join("pair/report.html")).unwrap().contains("seen from outside"));
}

#[test]
fn an_unsuitable_counterface_or_body_is_refused_with_its_line() {
    let folder = TempDir::new().unwrap();
    let rough =
        "covariance = \"exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\ncorrelation_length = \"8 um\"\n";
    let whole = [SURFACE, MATERIAL, PRESSURE, FRICTION].concat();
    let with = |counterface: &str| format!("{whole}[counterface]\n{counterface}");
    let slider = |body: &str, counterface: &str| {
        format!("{whole}{counterface}").replace("[surface]\n", &format!("[surface]\nbody = \"{body}\"\n"))
    };
    let free = [SURFACE, "[counterface]\n", rough, MATERIAL, FRICTION, "boundary = \"free\"\n", VIBRATION].concat();
    let line_of = |text: &str, key: &str| {
        let section = text.find(if key.starts_with("body") { "[surface]" } else { "[counterface]" }).unwrap_or(0);
        text[..section + text[section..].find(key).unwrap()].lines().count() + 1
    };
    for (text, code, key, words) in [
        (with("youngs_modulus = \"-1 GPa\"\n"), 2, "youngs_modulus", "a positive value"),
        (with("poisson_ratio = 0.2\n"), 2, "poisson_ratio", "a rigid counterface has none"),
        (with("youngs_modulus = \"1 GPa\"\npoisson_ratio = 0.6\n"), 2, "poisson_ratio", "at most 0.5"),
        (with("hardness = \"0 GPa\"\n"), 2, "hardness", "a positive value"),
        (with("hardnes = \"1 GPa\"\n"), 2, "hardnes", "did you mean `hardness`?"),
        (with(&rough.replace("rms_height = \"1 um\"\n", "")), 2, "[counterface]", "rms_height"),
        (with(&rough.replace("\"1 um\"", "\"-1 um\"")), 2, "rms_height", "[counterface] rms_height"),
        (with("file = []\n"), 2, "file", "the list of scans is empty"),
        (free, 2, "boundary", "two rough bodies requires strips along which the track can move"),
        (slider("both", ""), 2, "body", "the counterface is smooth"),
        (slider("slider", &format!("[counterface]\n{rough}")), 2, "body", "[counterface] is rough too"),
        (slider("belt", ""), 2, "body", "known: track, slider, both"),
    ] {
        fs::write(folder.path().join("study.toml"), &text).unwrap();
        let place = format!("study.toml:{}: ", line_of(&text, key));
        for command in ["check", "run"] {
            run_in(folder.path(), &format!("{command} study.toml")).refuses(code, &[&place, words]);
        }
    }
    // The law of ploughing and the scan are refused where they stand.
    let ploughing = with(rough).replace("[friction]\n", "[friction]\nlaw = \"adhesion_ploughing\"\n");
    for (text, code, words) in [
        (ploughing.as_str(), 2, "[friction] law: law = \"adhesion_ploughing\" requires a smooth counterface"),
        (&with("file = \"gone.npy\"\n"), 3, "gone.npy"),
    ] {
        fs::write(folder.path().join("study.toml"), text).unwrap();
        for command in ["check", "run"] {
            run_in(folder.path(), &format!("{command} study.toml")).refuses(code, &[words]);
        }
    }
    for (counterface, words) in [
        ("", "[counterface] has no effect"),
        ("hardness = \"1 GPa\"\nlevel = \"mean\"\n", "[counterface] level has no effect without `file`"),
        ("hardness = \"1 GPa\"\noutliers = 5.0\n", "[counterface] outliers has no effect without `file`"),
    ] {
        fs::write(folder.path().join("study.toml"), with(counterface)).unwrap();
        let checked = run_in(folder.path(), "check study.toml --json").json(0);
        assert!(checked["warnings"].to_string().contains(words), "{checked}");
    }
    let unused = SURFACE.replace("[surface]\n", "[surface]\nbody = \"slider\"\n");
    fs::write(folder.path().join("study.toml"), unused).unwrap();
    let checked = run_in(folder.path(), "check study.toml --json").json(0);
    assert!(checked["warnings"].to_string().contains("[surface] body has no effect"), "{checked}");
}
