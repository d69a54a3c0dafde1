//! What scans leave uncertain of friction, against elastic contact: its area depends on the load over the slopes.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::{json_of, run_in};

/// A rough slider of light elastic contact, whose friction does not fluctuate along the path.
const STUDY: &str = "seed = 5\n[surface]\nfile = FILES\nlevel = \"none\"\ncovariance = \"measured\"\ngenerator = \"spectral\"\nmarginal = \"normal\"\n\
                     body = \"slider\"\n[material]\nyoungs_modulus = \"10 GPa\"\npoisson_ratio = 0.25\n\
                     shear_strength = \"40 MPa\"\n[friction]\nstrip = [\"1.28 mm\", \"64 um\"]\npoints = [1280, 64]\n\
                     window = \"128 um\"\nrealisations = 4\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\n\
                     normal_force = { lognormal = [\"2.5 kN\", 0.2] }\nnominal_area = \"500 mm^2\"\ndimensionless_belt_velocity = 0.1\n\
                     stribeck = 4.2\ndamping_ratio = \"0.15 ± 0.03\"\n";

/// Draws a scan, a map of the same random surface times a factor, and returns its file.
fn draw(folder: &Path, index: usize, factor: f64) -> String {
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
    name
}

/// Writes a study of these scans, each a map of the same random surface times a factor, in a folder.
fn write(folder: &Path, factors: &[f64]) {
    let draw = |(index, factor): (usize, &f64)| format!("\"{}\"", draw(folder, index, *factor));
    let files: Vec<String> = factors.iter().enumerate().map(draw).collect();
    fs::write(folder.join("study.toml"), STUDY.replace("FILES", &format!("[{}]", files.join(", ")))).unwrap();
}

/// Returns a study with one level of strips and windows of a quarter of the length, for answers that do not depend on them.
fn with_short_strips(study: &str) -> String {
    let short = study.replace("\"1.28 mm\"", "\"320 um\"").replace("[1280, 64]", "[320, 64]");
    short.replace("window = \"128 um\"", "window = \"32 um\"\npercentiles = [50.0]")
}

/// Returns the changes of ln μ per standard deviation of an uncertain value and of the logarithm of the load, from the exported
/// samples, and the answer.
fn changes(folder: &Path, input: &str) -> (f64, f64, Value) {
    let found = run_in(folder, "verdict study.toml --export-samples samples.csv --json").json(0);
    let text = fs::read_to_string(folder.join("samples.csv")).unwrap();
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
    let std = moment(0, 0).sqrt();
    assert!(centre[0].abs() < 0.1 * std, "{centre:?}");
    let determinant = moment(0, 0) * moment(1, 1) - moment(0, 1).powi(2);
    let own = (moment(0, 2) * moment(1, 1) - moment(1, 2) * moment(0, 1)) / determinant;
    let load = (moment(1, 2) * moment(0, 0) - moment(0, 2) * moment(0, 1)) / determinant;
    // The value is the change of ln μ, of which the expansion is a curve.
    assert!((own - 1.0).abs() < 0.2, "{own}");
    (own * std, load, found)
}

/// Returns the standard error of the logarithm of the rms slope of the first scan.
fn slope_error(folder: &Path) -> f64 {
    let statistics = run_in(folder, "surface stats scan0.x3p --level none --json").json(0);
    let [low, high] = [0, 1].map(|end| statistics["Sdq_interval"][end].as_f64().unwrap().ln());
    (high - low) / (2.0 * 1.96)
}

#[test]
#[ignore = "slow"]
fn the_error_of_the_slopes_of_a_scan_is_the_error_of_elastic_friction() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), &[1.0]);
    let (change, load, found) = changes(folder.path(), "surface.scan");
    let wanted = slope_error(folder.path()) * (1.0 + load);
    assert!((change.abs() / wanted - 1.0).abs() < 0.3, "{change} for {wanted}");
    assert!(found["probability_over_unknowns"].is_object(), "{found}");
    assert!(found["guesses"].as_array().unwrap().iter().any(|guess| guess["input"] == "surface.scan"), "{found}");
}

#[test]
#[ignore = "slow"]
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
            "surface.between_parts",
            "surface.cut_off"
        ]
    );
    // The error of both scans together and the shortest wave are unknown; the differences vary from part to part.
    assert_eq!(found["guesses"].as_array().unwrap().len(), 2);
}

#[test]
#[ignore = "slow"]
fn a_machine_of_exact_values_keeps_the_differences_between_scans() {
    let drivers = |factors: &[f64]| -> Vec<String> {
        let folder = TempDir::new().unwrap();
        write(folder.path(), factors);
        let path = folder.path().join("study.toml");
        let exact = with_short_strips(&fs::read_to_string(&path).unwrap())
            .replace("{ lognormal = [\"2.5 kN\", 0.2] }", "\"2.5 kN\"")
            .replace("\"0.15 ± 0.03\"", "0.15");
        fs::write(&path, exact).unwrap();
        let found = run_in(folder.path(), "verdict study.toml --json").json(0);
        found["drivers"].as_array().unwrap().iter().map(|driver| driver["input"].as_str().unwrap().into()).collect()
    };
    let of_two = drivers(&[1.0, 1.5]);
    assert!(
        ["surface.scan", "surface.between_scans"].iter().all(|name| of_two.iter().any(|own| own == name)),
        "{of_two:?}"
    );
    // The error of one scan is that of the mean friction.
    let of_one = drivers(&[1.0]);
    assert!(!of_one.iter().any(|own| own == "surface.scan"), "{of_one:?}");
}

#[test]
#[ignore = "slow"]
fn scans_count_as_exact_where_the_study_says_so_whatever_the_number_of_threads() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), &[1.0]);
    let path = folder.path().join("study.toml");
    let study = with_short_strips(&fs::read_to_string(&path).unwrap());
    fs::write(&path, format!("{study}[uncertainty]\nsurface = false\n")).unwrap();
    let ended = run_in(folder.path(), "verdict study.toml --json");
    assert_eq!(ended.stdout, run_in(folder.path(), "verdict study.toml --json --threads 1").stdout);
    let found = ended.json(0);
    assert_eq!(found["drivers"].as_array().unwrap().len(), 3, "{found}");
    assert!(found["probability_over_unknowns"].is_null());
}

#[test]
#[ignore = "slow"]
fn parts_of_a_rough_slider_differ_as_its_windows_do_over_the_area() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), &[1.0]);
    let path = folder.path().join("study.toml");
    let study = with_short_strips(&fs::read_to_string(&path).unwrap())
        .replace("{ lognormal = [\"2.5 kN\", 0.2] }", "\"2.5 kN\"");
    let rows = ["paper", "area"].map(|upscaling| {
        fs::write(&path, format!("{study}upscaling = \"{upscaling}\"\n[uncertainty]\nsurface = false\n")).unwrap();
        assert_eq!(run_in(folder.path(), &format!("run study.toml --only verdict --out {upscaling}")).code, 0);
        let results = json_of(&folder.path().join(upscaling).join("results.json"));
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
        // One window is the paper's reading, all windows are the nominal area.
        let verdict = &results["verdict"];
        let rows = verdict["area_as_one"].as_array().unwrap().clone();
        let own = if upscaling == "paper" { rows.first() } else { rows.last() }.unwrap();
        assert!((own["friction_std"].as_f64().unwrap() / std - 1.0).abs() < 1e-9, "{upscaling}: {own}, not {std}");
        let ends = |entry: &Value| [0, 1].map(|end| entry["probability_interval"][end].as_f64().unwrap());
        let ([low, high], [least, most]) = (ends(own), ends(verdict));
        assert!(low < most && least < high, "{low} to {high}, but {least} to {most}");
        rows
    });
    // The machines of a row are the same in both studies, but the verdict that is their control variate differs.
    assert_eq!(rows[0].len(), rows[1].len());
    for (a, b) in rows[0].iter().zip(&rows[1]) {
        assert_eq!([&a["windows"], &a["friction_std"]], [&b["windows"], &b["friction_std"]]);
        let ends = |row: &Value| [0, 1].map(|end| row["probability_interval"][end].as_f64().unwrap());
        assert!(ends(a)[0] < ends(b)[1] && ends(b)[0] < ends(a)[1], "{a} and {b}");
    }
}

/// A smooth surface under a rough counterface with its own scan, and a machine whose friction does not fluctuate.
fn with_counterface(folder: &Path, scan: &str, extra: &str) {
    let (_, rest) = STUDY.split_once("[material]").unwrap();
    let (contact, _) = rest.split_once("[vibration]").unwrap();
    let contact = with_short_strips(contact).replace("40 MPa", "105 MPa");
    let study = format!(
        "seed = 5\n[surface]\ncovariance = \"squared_exponential\"\ncorrelation_length = \"10 um\"\nrms_height = \"0.02 um\"\n\
         generator = \"spectral\"\nmarginal = \"normal\"\n[counterface]\nfile = \"{scan}\"\nlevel = \"none\"\ncovariance = \"measured\"\n\
         marginal = \"normal\"\n[material]{contact}[vibration]\nmodel = \"mode_coupling\"\nmass = \"1 kg\"\n\
         natural_frequency = \"12000 rad/s\"\nnormal_force = {{ lognormal = [\"2.5 kN\", 0.2] }}\nnominal_area = \"500 mm^2\"\n\
         belt_velocity = \"1 m/s\"\ndamping_ratio = \"0.02 ± 0.005\"\n{extra}"
    );
    fs::write(folder.join("study.toml"), study).unwrap();
}

#[test]
#[ignore = "slow"]
fn the_scan_of_a_much_rougher_counterface_is_the_error_of_friction() {
    let folder = TempDir::new().unwrap();
    with_counterface(folder.path(), &draw(folder.path(), 0, 1.0), "");
    let (change, load, found) = changes(folder.path(), "counterface.scan");
    // The squares of the slopes add up, and the surface has a hundredth of those of the counterface.
    let wanted = slope_error(folder.path()) / 1.01 * (1.0 + load);
    assert!((change.abs() / wanted - 1.0).abs() < 0.3, "{change} for {wanted}");
    let drivers: Vec<(&str, f64)> = found["drivers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|driver| (driver["input"].as_str().unwrap(), driver["total"].as_f64().unwrap()))
        .collect();
    let (largest, total) = drivers.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!(*largest == "counterface.scan" && *total > 0.5, "{drivers:?}");
    assert!(found["guesses"].as_array().unwrap().iter().any(|guess| guess["input"] == "counterface.scan"), "{found}");
    let said = "The verdict is for the counterface with this scan";
    assert!(found["assumptions"].to_string().contains(said), "{found}");
    with_counterface(folder.path(), "scan0.x3p", "[uncertainty]\nsurface = false\n");
    let exact = run_in(folder.path(), "verdict study.toml --json").json(0);
    assert!(!exact["drivers"].to_string().contains("scan"), "{exact}");
}

#[test]
#[ignore = "slow"]
fn friction_differs_between_drawn_counterface_scans_as_each_of_them_states() {
    const SCANS: usize = 16;
    let folder = TempDir::new().unwrap();
    let (mut frictions, mut stated) = (Vec::new(), Vec::new());
    for index in 0..SCANS {
        with_counterface(folder.path(), &draw(folder.path(), index, 1.0), "");
        // With a stated covariance all studies have the same strips, and only the rms heights of the scans differ.
        let path = folder.path().join("study.toml");
        let covariance = "covariance = \"squared_exponential\"\ncorrelation_length = \"10 um\"";
        let study = fs::read_to_string(&path).unwrap().replace("covariance = \"measured\"", covariance);
        fs::write(&path, study).unwrap();
        let out = format!("run{index}");
        assert_eq!(run_in(folder.path(), &format!("run study.toml --only friction --out {out}")).code, 0);
        let results = json_of(&folder.path().join(out).join("results.json"));
        frictions.push(results["friction"]["operating_point"]["mean"].as_f64().unwrap().ln());
        if index < 3 {
            stated.push(changes(folder.path(), "counterface.scan").0.abs());
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let centre = mean(&frictions);
    let variance = frictions.iter().map(|own| (own - centre).powi(2)).sum::<f64>() / (SCANS - 1) as f64;
    let ratio = variance / mean(&stated).powi(2);
    // The 0.1 % and 99.9 % quantiles of χ²/15 for 15 degrees of freedom.
    assert!((0.2322..2.5131).contains(&ratio), "the scans scatter by {}, each states {stated:?}", variance.sqrt());
}
