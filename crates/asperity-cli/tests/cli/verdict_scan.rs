//! What scans leave uncertain of friction, against elastic contact: its area depends on the load over the slopes.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::run_in;

/// A rough slider of light elastic contact, whose friction does not fluctuate along the path.
const STUDY: &str = "seed = 5\n[surface]\nfile = FILES\nlevel = \"none\"\ncovariance = \"measured\"\ngenerator = \"spectral\"\nmarginal = \"normal\"\n\
                     body = \"slider\"\n[material]\nyoungs_modulus = \"10 GPa\"\npoisson_ratio = 0.25\n\
                     shear_strength = \"40 MPa\"\n[friction]\nstrip = [\"1.28 mm\", \"64 um\"]\npoints = [1280, 64]\n\
                     window = \"128 um\"\nrealisations = 4\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\n\
                     normal_force = { lognormal = [\"2.5 kN\", 0.2] }\nnominal_area = \"500 mm^2\"\ndimensionless_belt_velocity = 0.1\n\
                     stribeck = 4.2\ndamping_ratio = \"0.15 ± 0.03\"\n";

/// Writes a study of these scans, each a map of the same random surface times a factor, in a folder.
fn write(folder: &Path, factors: &[f64]) {
    let mut files = Vec::new();
    for (index, factor) in factors.iter().enumerate() {
        let spec = format!(
            "seed = {index}\nsize = [\"256 um\", \"256 um\"]\npoints = [256, 256]\n[surface]\ngenerator = \"spectral\"\n\
             covariance = \"squared_exponential\"\ncorrelation_length = \"10 um\"\nmarginal = \"normal\"\n\
             rms_height = \"{} um\"\n",
            0.2 * factor
        );
        fs::write(folder.join("spec.toml"), spec).unwrap();
        let name = format!("scan{index}.x3p");
        let line = format!("surface generate spec.toml --seed {} --out {name}", index + 1);
        assert_eq!(run_in(folder, &line).code, 0);
        files.push(format!("\"{name}\""));
    }
    fs::write(folder.join("study.toml"), STUDY.replace("FILES", &format!("[{}]", files.join(", ")))).unwrap();
}

/// Returns the changes of ln μ per standard deviation of an uncertain value and of the logarithm of the load, from the exported
/// samples, and the answer.
fn changes(folder: &Path, input: &str) -> (f64, f64, Value) {
    let ended = run_in(folder, "verdict study.toml --export-samples samples.csv --json");
    assert_eq!(ended.code, 0, "{ended:?}");
    let (own, load) = changes_in(&folder.join("samples.csv"), input);
    (own, load, serde_json::from_str(&ended.stdout).unwrap())
}

/// Returns the changes of ln μ per standard deviation of an uncertain value and of the logarithm of the load, from a table of samples.
fn changes_in(samples: &Path, input: &str) -> (f64, f64) {
    let text = fs::read_to_string(samples).unwrap();
    let mut rows = text.lines();
    let header: Vec<&str> = rows.next().unwrap().split(',').collect();
    let place = |name: &str| header.iter().position(|own| *own == name).unwrap_or_else(|| panic!("{name}: {header:?}"));
    let places = [place(input), place("vibration.normal_force"), place("friction_coefficient")];
    let samples: Vec<[f64; 3]> = rows
        .map(|row| {
            let cells: Vec<&str> = row.split(',').collect();
            let [normal, load, friction] = places.map(|place| cells[place].parse::<f64>().unwrap());
            [normal, load.ln(), friction.ln()]
        })
        .collect();
    let mean = |of: &dyn Fn(&[f64; 3]) -> f64| samples.iter().map(of).sum::<f64>() / samples.len() as f64;
    let centre = [0, 1, 2].map(|place: usize| mean(&|sample| sample[place]));
    let moment = |i: usize, j: usize| mean(&|sample| (sample[i] - centre[i]) * (sample[j] - centre[j]));
    // Samples of a standard normal value.
    assert!(centre[0].abs() < 0.1 && (moment(0, 0) - 1.0).abs() < 0.15, "{centre:?}");
    let determinant = moment(0, 0) * moment(1, 1) - moment(0, 1).powi(2);
    let own = (moment(0, 2) * moment(1, 1) - moment(1, 2) * moment(0, 1)) / determinant;
    let load = (moment(1, 2) * moment(0, 0) - moment(0, 2) * moment(0, 1)) / determinant;
    (own, load)
}

#[test]
fn the_error_of_the_slopes_of_a_scan_is_the_error_of_elastic_friction() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), &[1.0]);
    let (change, load, found) = changes(folder.path(), "surface.scan");
    let statistics = run_in(folder.path(), "surface stats scan0.x3p --level none --json");
    let statistics: Value = serde_json::from_str(&statistics.stdout).unwrap();
    let interval = &statistics["Sdq_interval"];
    let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap().ln());
    let error = (high - low) / (2.0 * 1.96);
    let wanted = error * (1.0 + load);
    assert!((change.abs() / wanted - 1.0).abs() < 0.3, "{change} for {wanted}");
    assert!(found["probability_over_unknowns"].is_object(), "{found}");
    assert!(found["guesses"].as_array().unwrap().iter().any(|guess| guess["input"] == "surface.scan"), "{found}");
}

#[test]
fn scans_of_different_slopes_differ_in_friction_beyond_their_errors() {
    // Two values that differ by ln 1.5 have the standard deviation ln 1.5/√2; the error of the scans is a few percent of it. k times as
    // high, the surface has the contact area that it had under 1/k of the load.
    let folder = TempDir::new().unwrap();
    write(folder.path(), &[1.0, 1.5]);
    let (change, load, found) = changes(folder.path(), "surface.between_scans");
    let wanted = 1.5_f64.ln() / 2.0_f64.sqrt() * (1.0 + load);
    assert!((change.abs() / wanted - 1.0).abs() < 0.15, "{change} for {wanted}");
    let drivers: Vec<&str> =
        found["drivers"].as_array().unwrap().iter().map(|driver| driver["input"].as_str().unwrap()).collect();
    assert_eq!(
        drivers,
        [
            "vibration.damping_ratio",
            "vibration.normal_force",
            "surface.scan",
            "surface.between_scans",
            "surface.between_parts"
        ]
    );
    // Only the error of both scans together is unknown; the differences vary from part to part.
    assert_eq!(found["guesses"].as_array().unwrap().len(), 1);
}

#[test]
fn scans_count_as_exact_where_the_study_says_so_whatever_the_number_of_threads() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), &[1.0]);
    let path = folder.path().join("study.toml");
    let study = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("{study}[uncertainty]\nsurface = false\n")).unwrap();
    let ended = run_in(folder.path(), "verdict study.toml --json");
    assert_eq!(ended.stdout, run_in(folder.path(), "verdict study.toml --json --threads 1").stdout);
    let found: Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(found["drivers"].as_array().unwrap().len(), 3, "{found}");
    assert!(found["probability_over_unknowns"].is_null());
}

#[test]
fn parts_of_a_rough_slider_differ_as_its_windows_do_over_the_area() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), &[1.0]);
    let path = folder.path().join("study.toml");
    let study = fs::read_to_string(&path).unwrap().replace("{ lognormal = [\"2.5 kN\", 0.2] }", "\"2.5 kN\"");
    for upscaling in ["paper", "area"] {
        fs::write(&path, format!("{study}upscaling = \"{upscaling}\"\n[uncertainty]\nsurface = false\n")).unwrap();
        assert_eq!(run_in(folder.path(), &format!("run study.toml --only verdict --out {upscaling}")).code, 0);
        let results = fs::read_to_string(folder.path().join(upscaling).join("results.json")).unwrap();
        let results: Value = serde_json::from_str(&results).unwrap();
        let levels = results["friction"]["levels"].as_array().unwrap();
        let level = levels.iter().find(|level| level["leading"] == true).unwrap();
        let std = level["upscaling"][upscaling]["std"].as_f64().unwrap();
        let mean = results["friction"]["operating_point"]["mean"].as_f64().unwrap();
        // The factor of a part is lognormal with mean 1.
        let wanted = (std / mean).powi(2).ln_1p().sqrt();
        let samples = fs::read_to_string(folder.path().join(upscaling).join("tables/verdict_samples.csv")).unwrap();
        let mut rows = samples.lines().map(|row| row.split(',').collect::<Vec<_>>());
        let header = rows.next().unwrap();
        let place = |name: &str| header.iter().position(|own| *own == name).unwrap();
        let (normal, friction) = (place("surface.between_parts"), place("friction_coefficient"));
        for row in rows {
            let [normal, friction] = [normal, friction].map(|place: usize| row[place].parse::<f64>().unwrap());
            let factor = (wanted * normal - 0.5 * wanted * wanted).exp();
            assert!((friction / (mean * factor) - 1.0).abs() < 1e-9, "{upscaling}: {friction} at {normal}");
        }
    }
}
