//! Headline numbers against closed forms, published values and independent counts.

use std::f64::consts::{LN_2, PI};
use std::fs;
use std::path::Path;

use asperity_formats::{Scan, read, write_x3p};
use asperity_testing::{METHODS, StudyText};
use ndarray::{Array2, Axis, s};
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{Finished, asperity, close, json_of, number, run_in};

/// Runs a study into the folder `run` and returns the output of the program and `results.json`.
fn study(folder: &Path, text: &str) -> (Finished, Value) {
    fs::write(folder.join("study.toml"), text).unwrap();
    let ended = run_in(folder, "run study.toml --out run");
    assert_eq!(ended.code, 0, "{ended:?}");
    (ended, json_of(&folder.join("run/results.json")))
}

/// Generates `count` maps of a specification and returns their heights in metre.
fn generated(folder: &Path, specification: &str, count: usize) -> Vec<Array2<f64>> {
    fs::write(folder.join("spec.toml"), specification).unwrap();
    let ended = run_in(folder, &format!("surface generate spec.toml --out maps --count {count}"));
    assert_eq!(ended.code, 0, "{ended:?}");
    let map = |index: usize| read(&folder.join(format!("maps/map_{index:04}.x3p"))).unwrap().heights_m;
    (0..count).map(map).collect()
}

/// Mean squared slope by forward differences over a square pitch.
fn squared_slope(heights_m: &Array2<f64>, pitch_m: f64) -> f64 {
    let along = |axis: usize| {
        let ahead = heights_m.slice_axis(Axis(axis), (1..).into());
        let here = heights_m.slice_axis(Axis(axis), (..-1).into());
        (&ahead - &here).mapv(|step| (step / pitch_m).powi(2)).mean().unwrap()
    };
    along(0) + along(1)
}

/// A surface of covariance σ² e^{−r/ℓ} with σ = 1 µm and ℓ = 16 µm, whose slopes lie in its shortest waves.
const EXPONENTIAL: &str = "covariance = \"exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\n\
                           correlation_length = [\"16 um\", \"16 um\"]\n";

/// Mean squared slope of [`EXPONENTIAL`] by differences over a pitch in µm: 2σ²(1 − ρ(Δ))/Δ² along each axis.
fn exponential_squared_slope(pitch_um: f64) -> f64 {
    4.0 * (1.0 - (-pitch_um / 16.0).exp()) / pitch_um.powi(2)
}

#[test]
fn random_surfaces_have_the_slopes_of_their_covariance_by_default() {
    let folder = TempDir::new().unwrap();
    let specification = format!("seed = 3\nsize = [\"64 um\", \"64 um\"]\npoints = [64, 64]\n[surface]\n{EXPONENTIAL}");
    let maps = generated(folder.path(), &specification, 8);
    let slope = maps.iter().map(|map| squared_slope(map, 1e-6)).sum::<f64>() / 8.0;
    close(slope.sqrt(), exponential_squared_slope(1.0).sqrt(), 0.05);
}

#[test]
fn the_slopes_that_a_stated_number_of_terms_loses_are_reported_and_warned_about() {
    let folder = TempDir::new().unwrap();
    // Not rescaled, the maps are the sum of the terms.
    let surface = format!("[surface]\n{EXPONENTIAL}modes = 101\nrescale = false\n");
    let patch = "size = [\"64 um\", \"64 um\"]\npoints = [32, 32]\n";
    let (ended, results) = study(
        folder.path(),
        &format!(
            "seed = 5\n{surface}[material]\nyoungs_modulus = \"210 GPa\"\nhardness = \"2 GPa\"\n[pressure]\n{patch}\
             percentile = 50.0\nfine_solves = 20\nmethods = ['monte_carlo']\nreference_samples = 20\nvariables = 2\ndegree = 1\n"
        ),
    );
    let expansion = &results["surface"]["karhunen_loeve"];
    assert_eq!(expansion["modes"], 101);
    // Independently: the slopes of maps from these terms over the closed form of all terms.
    let maps = generated(folder.path(), &format!("seed = 7\n{patch}{surface}"), 40);
    let slope = maps.iter().map(|map| squared_slope(map, 2e-6)).sum::<f64>() / 40.0;
    let kept = slope / exponential_squared_slope(2.0);
    assert!(kept < 0.5, "{kept}");
    close(number(expansion, "captured_slope_variance"), kept, 0.05);
    assert!(ended.stderr.contains("% of the slope variance"), "{ended:?}");
    // Heights that keep their whole variance have higher slopes than the terms alone.
    let scaled = surface.replace("rescale = false\n", "");
    let folder = TempDir::new().unwrap();
    let maps = generated(folder.path(), &format!("seed = 7\n{patch}{scaled}"), 40);
    let slope = maps.iter().map(|map| squared_slope(map, 2e-6)).sum::<f64>() / 40.0;
    let drawn = run_in(folder.path(), "surface generate spec.toml --out one.npy");
    let (_, factor) = drawn.stderr.split_once("slopes of the random surfaces are ").unwrap();
    let factor: f64 = factor.split_whitespace().next().unwrap().parse().unwrap();
    close(factor, (slope / exponential_squared_slope(2.0)).sqrt(), 0.02);
}

/// A map of unit variance: white noise of a linear congruential generator after recursions along both axes.
///
/// One pass gives the covariance e^{−(|x| + |y|)/ℓ} with x, y and ℓ in points; more passes make the map smoother.
fn correlated(seed: u64, length: f64, passes: usize) -> Array2<f64> {
    let (side, start, memory) = (200, 100, (-1.0 / length).exp());
    let mut state = seed;
    let mut map = Array2::from_shape_simple_fn((side + start, side + start), || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    });
    for axis in [Axis(0), Axis(1)].into_iter().cycle().take(2 * passes) {
        for index in 1..map.len_of(axis) {
            let before = map.index_axis(axis, index - 1).to_owned();
            map.index_axis_mut(axis, index).scaled_add(memory, &before);
        }
    }
    let map = map.slice_move(s![start.., start..]);
    (&map - map.mean().unwrap()) / map.std(0.0)
}

/// Gaussian S-filter with a cut-off of four points (ISO 16610-61), where all its weights lie on the map.
fn s_filtered(heights: &Array2<f64>) -> Array2<f64> {
    let weights = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0_f64].map(|x| (-PI * PI / LN_2 * (x / 4.0).powi(2)).exp());
    let sum: f64 = weights.iter().sum();
    let along = |map: &Array2<f64>, axis: Axis| {
        let length = map.len_of(axis) - 6;
        let mut filtered = Array2::zeros(match axis {
            Axis(0) => (length, map.ncols()),
            _ => (map.nrows(), length),
        });
        for (first, weight) in weights.iter().enumerate() {
            filtered.scaled_add(weight / sum, &map.slice_axis(axis, (first..first + length).into()));
        }
        filtered
    };
    along(&along(heights, Axis(0)), Axis(1))
}

#[test]
fn random_maps_like_a_scan_of_fine_roughness_on_long_waves_keep_its_slopes() {
    let folder = TempDir::new().unwrap();
    // No single covariance model has both lengths.
    let heights_m = 1e-7 * (correlated(1, 10.0, 2) + 0.3 * correlated(2, 5.0, 1));
    let scan = Scan::new(heights_m.clone(), Some((1e-6, 1e-6)));
    fs::write(folder.path().join("scan.x3p"), write_x3p(&scan).unwrap()).unwrap();
    let specification = "seed = 5\nsize = [\"200 um\", \"200 um\"]\npoints = [200, 200]\n[surface]\n\
                         file = \"scan.x3p\"\nlevel = \"plane\"\ngenerator = \"spectral\"\ncut_off = \"2 um\"\n";
    let maps = generated(folder.path(), specification, 2);
    for map in &maps {
        for view in [Array2::clone, s_filtered] {
            close(squared_slope(&view(map), 1e-6).sqrt(), squared_slope(&view(&heights_m), 1e-6).sqrt(), 0.15);
        }
    }
}

/// A study of the paper's machine with a stated friction process.
fn machine(friction_std: f64, more: &str) -> String {
    StudyText::new(3, &["vibration", "stated friction"])
        .with("vibration", &format!("friction_std = {friction_std:e}\nstribeck = 4.2\nupscaling = \"paper\""))
        .with("vibration", more)
        .to_string()
}

/// [`machine`] without damping and scatter for commands without units: λ = ℓc/N with N/c = 2500 N/(1 kg·316² s⁻²).
const MACHINE: &str = "--static-friction 0.1 --stribeck 4.2 --belt-velocity 0.003 --correlation-length 0.0099856 \
                       --marginal beta:2.1,5 --duration 150";

/// Fraction of 400 trajectories that vibrate at the end of the duration, when the process has forgotten its start.
fn vibrating(friction_std: f64, damping: f64) -> f64 {
    let line = format!("--friction-std {friction_std} --damping-ratio {damping} --trajectories 400 --seed 8 --json");
    number(&asperity(&format!("vibration ensemble {MACHINE} {line}")).json(0), "sustained_share")
}

/// The crossings that one window under the whole normal force gives: level, damping ratio and interval.
fn crossings(results: &Value) -> Vec<(f64, f64, [f64; 2])> {
    let crossing = |entry: &Value| {
        let interval = [0, 1].map(|end| entry["damping_ratio_interval"][end].as_f64().unwrap());
        (number(entry, "share"), number(entry, "damping_ratio"), interval)
    };
    results["vibration"]["paper"]["crossings"].as_array().unwrap().iter().map(crossing).collect()
}

#[test]
fn vibration_under_steady_friction_ends_at_the_published_damping_at_every_level() {
    let folder = TempDir::new().unwrap();
    let sweep = "damping_sweep = [0.1, 0.3, 3]\ntrajectories = 20\nduration = 200.0\n";
    let (_, results) = study(folder.path(), &machine(1e-6, sweep));
    let crossings = crossings(&results);
    assert_eq!(crossings.iter().map(|(level, ..)| *level).collect::<Vec<_>>(), [0.95, 0.5, 0.05]);
    for (level, damping, _) in crossings {
        // ζ_c of a high-precision solver; the sweep has steps of 0.1.
        assert!((damping - 0.204_830_150_584_523_2).abs() < 2e-4, "{level}: {damping}");
    }
}

#[test]
fn independent_ensembles_at_the_crossings_vibrate_as_often_as_their_levels() {
    let folder = TempDir::new().unwrap();
    let sweep = "damping_sweep = [0.1, 0.3, 3]\ntrajectories = 60\nduration = 150.0\n";
    let (_, results) = study(folder.path(), &machine(1e-3, sweep));
    let found = crossings(&results);
    assert_eq!(found.len(), 3);
    for (level, damping, [low, high]) in found {
        assert!(low <= damping && damping <= high && high - low < 0.1, "{level}: {damping} in [{low}, {high}]");
        // Four standard errors of the count; one end of the interval may lie on the other side by chance.
        let scatter = 4.0 * (level * (1.0 - level) / 400.0_f64).sqrt();
        let [most, least] = [low, high].map(|damping| vibrating(1e-3, damping));
        assert!(least - scatter < level && level < most + scatter, "{level}: {least} to {most} over [{low}, {high}]");
    }
}

/// A lightly loaded pad: at its nominal pressure most windows hold a contact or none.
fn pad() -> String {
    let friction = "strip = [\"320 um\", \"32 um\"]\npoints = [160, 16]\nwindow = \"32 um\"\nrealisations = 4";
    StudyText::new(12, &["surface", "material", "friction", "vibration"])
        .with("surface", "covariance = \"squared_exponential\"\nrms_height = \"0.5 um\"")
        .with("surface", "correlation_length = [\"12 um\", \"12 um\"]")
        .with("friction", friction)
        .with("friction", "percentiles = [20.0]\ntolerance = 1e-5")
        .with("vibration", "nominal_area = \"200 mm^2\"\nstribeck = 4.2\ntrajectories = 4\nduration = 20.0")
        .with("vibration", "damping_sweep = [0.1, 0.2, 2]")
        .to_string()
}

/// First number after `label`.
fn stated(text: &str, label: &str) -> f64 {
    let rest = text.split(label).nth(1).unwrap_or_else(|| panic!("`{label}` is missing in {text}"));
    let number = rest.trim_start().split(|c: char| !(c.is_ascii_digit() || c == '.')).next().unwrap();
    number.parse().unwrap_or_else(|e| panic!("{e} after `{label}`: {rest:.80}"))
}

#[test]
fn page_terminal_results_and_machine_have_one_friction_coefficient() {
    let folder = TempDir::new().unwrap();
    let (ended, results) = study(folder.path(), &pad());
    let text = |name: &str| fs::read_to_string(folder.path().join("run").join(name)).unwrap();
    let process: Value = serde_json::from_str(&text("friction_process.json")).unwrap();
    let vibration = &results["vibration"];
    // The coefficient that drives the machine, from its Hopf point 2ζ_H = aμ/(1 + aV)².
    let driving = 2.0 * number(vibration, "hopf_damping_ratio") * (1.0 + 4.2 * 0.003_f64).powi(2) / 4.2;
    close(number(&process, "mean"), driving, 1e-12);
    close(number(vibration, "static_friction"), driving, 1e-12);
    // The terminal and the first screen have three digits.
    close(stated(&ended.stdout, " % of the "), number(vibration, "limit_damping_ratio"), 5e-3);
    let report = text("report.html");
    close(stated(&report, "<strong>μ "), driving, 5e-3);
    let point = &results["friction"]["operating_point"];
    close(number(point, "mean"), driving, 1e-12);
    close(number(point, "mean_pressure_pa"), 2500.0 / 200e-6, 1e-3);
    let contact = report.split("in contact</strong>").next().unwrap().rsplit("<strong>").next().unwrap();
    close(0.01 * stated(&format!("<{contact}"), "<"), number(point, "contact_fraction"), 0.05);
    // A window shears its contact area, or the area that its load needs at the hardness where that is larger.
    let (elastic, floor) = (number(point, "contact_fraction") * 385e6 / number(point, "mean_pressure_pa"), 385e6 / 2e9);
    assert!(elastic.max(floor) <= driving && driving <= elastic + floor, "{elastic} and {floor}: {driving}");
}

/// A map over damping ratios from 0.1 to 0.3 in cells of at least 0.025.
fn map(friction_std: f64, trajectories: usize) -> Finished {
    asperity(&format!(
        "vibration map {MACHINE} --friction-std {friction_std} --damping-ratio 0.1 --damping-ratios 0.1,0.3,2 \
         --belt-velocities 0.003,0.0035,1 --depth 2 --trajectories {trajectories} --seed 3 --json"
    ))
}

/// Damping ratios along a contour of a map.
fn contour(map: &Value, level: f64) -> Vec<f64> {
    let contours = map["contours"].as_array().unwrap();
    let lines = contours.iter().find(|contour| contour["level"] == level).unwrap()["lines"].as_array().unwrap();
    let points = lines.iter().flat_map(|line| line.as_array().unwrap());
    points.map(|point| point[0].as_f64().unwrap()).collect()
}

#[test]
fn contours_are_not_drawn_a_cell_apart_about_a_narrower_transition() {
    // Hardly any scatter: all vibrate below ζ_c = .20483 and none above it.
    assert_eq!([0.2, 0.21].map(|damping| vibrating(1e-5, damping)), [1.0, 0.0]);
    let ended = map(1e-5, 20);
    let map = ended.json(0);
    for (often, rarely) in contour(&map, 0.95).into_iter().zip(contour(&map, 0.05)) {
        assert!((rarely - often).abs() < 0.01, "95 % at {often} and 5 % at {rarely}");
    }
    let middle = contour(&map, 0.5);
    assert!(!middle.is_empty() && middle.iter().all(|damping| (damping - 0.2048).abs() < 0.025), "{middle:?}");
    assert!(ended.stderr.contains("the transition is narrower than that"), "{ended:?}");
    assert_eq!(number(&map["resolution"], "unresolved_share"), 1.0);
    close(number(&map["resolution"], "x"), 0.025, 1e-9);
}

#[test]
fn contours_of_a_wide_transition_are_where_independent_ensembles_vibrate_as_often() {
    let ended = map(1e-3, 100);
    let map = ended.json(0);
    assert_eq!(number(&map["resolution"], "unresolved_share"), 0.0);
    assert!(!ended.stderr.contains("the transition is narrower than that"), "{ended:?}");
    for level in [0.95, 0.5, 0.05] {
        let damping = contour(&map, level);
        let last = damping[damping.len() - 1];
        // Four standard errors of two counts, and the curvature within a cell.
        let scatter = 4.0 * (level * (1.0 - level) * (1.0 / 100.0 + 1.0 / 400.0_f64)).sqrt() + 0.02;
        let share = vibrating(1e-3, last);
        assert!((share - level).abs() < scatter, "{level} at {last}: {share}");
    }
}

/// A patch that touches its flat at about half of its points.
fn patch(hardness: &str, fine_solves: usize) -> String {
    StudyText::new(1, &["surface", "material", "pressure"])
        .with("surface", "covariance = \"squared_exponential\"\nmodes = 30")
        .with("material", &format!("hardness = \"{hardness}\""))
        .with("pressure", METHODS)
        .with("pressure", &format!("fine_solves = {fine_solves}\nreference_samples = 100\nvariables = 3\ndegree = 3"))
        .to_string()
}

#[test]
fn no_method_has_a_mean_pressure_or_a_quantile_above_the_hardness() {
    let folder = TempDir::new().unwrap();
    let (_, results) = study(folder.path(), &patch("2 GPa", 100));
    let methods = results["pressure"]["methods"].as_array().unwrap();
    assert!(methods.iter().any(|method| method["name"] == "polynomial_chaos_log" && method["mean_pa"].is_number()));
    let possible = 0.0..=2e9 * (1.0 + 1e-9);
    let answered = || methods.iter().filter(|method| method["mean_pa"].is_number());
    for method in answered() {
        assert!(possible.contains(&number(method, "mean_pa")), "mean {} Pa of {}", method["mean_pa"], method["name"]);
    }
    for method in answered() {
        for quantile in method["quantiles"].as_array().unwrap() {
            assert!(possible.contains(&number(quantile, "pressure_pa")), "{quantile} of {}", method["name"]);
        }
    }
}

#[test]
fn a_refused_method_has_its_reason_and_no_row_of_dashes() {
    let folder = TempDir::new().unwrap();
    let (ended, results) = study(folder.path(), &patch("20 GPa", 40));
    let methods = results["pressure"]["methods"].as_array().unwrap();
    let refused: Vec<&Value> = methods.iter().filter(|method| method["mean_pa"].is_null()).collect();
    assert!(!refused.is_empty() && refused.len() < methods.len());
    let table = fs::read_to_string(folder.path().join("run/tables/pressure_methods.csv")).unwrap();
    for method in refused {
        let (name, reason) = (method["name"].as_str().unwrap(), method["failure"].as_str().unwrap());
        assert!(ended.stderr.contains(reason), "{reason}: {ended:?}");
        assert!(!table.lines().any(|line| line.starts_with(&format!("{name},"))), "{name}: {table}");
    }
}
