//! Unusual scans: stated covariance, pixel size or height unit, gaps, noise, and missing files.

use std::fs;
use std::path::Path;

use asperity::monitor::Monitor;
use asperity::random;
use asperity::study::{FailureKind, Outcome, RunBlocks, RunRecord, Share, Stage, Study, StudyError, json_bytes};
use asperity_formats::Scan;
use ndarray::Array2;
use serde_json::Value;

use crate::support::{MODEL, USUAL, assert_numbers, changed, folder_with, measured, rough, run, run_in};

#[test]
#[ignore = "slow"]
fn weierstrass_mandelbrot_requires_a_fractal_dimension() {
    // White noise has no scaling range.
    let noise = random::standard_normal(&mut random::stream(8, "noise", 0), 64 * 64);
    let folder = folder_with(Array2::from_shape_vec((64, 64), noise).unwrap().mapv(|z| 1e-6 * z));
    let text = changed(&measured(), &[("modes = 30", "generator = \"weierstrass_mandelbrot\"")]);
    let outcome = run_in(folder.path(), &text, Some(Stage::Surface));
    if let Err(error) = &outcome {
        assert!(error.to_string().contains("fractal_dimension"), "{error}");
        assert_eq!(error.kind(), FailureKind::Configuration);
    } else {
        let surface = outcome.unwrap().results.surface.unwrap();
        assert!(surface.scan().unwrap().fractal_dimension.is_some());
    }
    // A stated dimension suffices, and no covariance is invented.
    let stated = changed(&text, &[("generator", "fractal_dimension = 2.5\ngenerator")]);
    let outcome = run_in(folder.path(), &stated, Some(Stage::Friction)).unwrap();
    assert!(outcome.results.surface.as_ref().unwrap().covariance.is_none());
    assert!(outcome.tables["height_acf"].column("fit_x").is_none());
    assert!(outcome.results.assumptions.iter().any(|sentence| sentence.contains("fractal dimension 2.5 (stated)")));
}

#[test]
#[ignore = "slow"]
fn a_scan_may_have_stated_covariance_rms_height_distribution_and_form() {
    let folder = folder_with(rough(96, 80, 0.5e-6, 16e-6));
    for level in ["none", "mean", "plane", "quadratic"] {
        let text = changed(&measured(), &[("[surface]", &format!("[surface]\nlevel = \"{level}\""))]);
        assert_numbers(&run_in(folder.path(), &text, Some(Stage::Surface)).unwrap(), USUAL);
    }
    let text = changed(
        &measured(),
        &[
            (
                "[surface]",
                "[surface]\ncovariance = \"exponential\"\ncorrelation_length = [\"9 um\", \"8 um\"]\nrms_height = \"2 um\"\n\
                 marginal = \"beta:2.1,5\"",
            ),
            // The contact of so rough a surface would all be plastic, and its friction constant.
            ("hardness = \"2 GPa\"\n", ""),
        ],
    );
    let outcome = run_in(folder.path(), &text, Some(Stage::Friction)).unwrap();
    assert_numbers(&outcome, USUAL);
    let surface = outcome.results.surface.unwrap();
    let covariance = surface.covariance.as_ref().unwrap();
    assert_eq!((covariance.model.as_str(), covariance.std_m, covariance.length_y_m), ("exponential", 2e-6, 8e-6));
    // The statistics of the scan itself stay unchanged.
    assert!(surface.scan().unwrap().Sq_m < 1e-6);
}

#[test]
#[ignore = "slow"]
fn the_scan_s_own_covariance_works_in_every_stage_and_reports_its_changes() {
    let folder = folder_with(rough(96, 80, 0.5e-6, 16e-6));
    for (generator, boundary) in [("karhunen_loeve", "free"), ("spectral", "periodic")] {
        let own = format!("[surface]\ncovariance = \"empirical\"\ngenerator = \"{generator}\"");
        let text = changed(
            &measured(),
            &[("[surface]", &own), ("[friction]", &format!("[friction]\nboundary = \"{boundary}\""))],
        );
        let outcome = run_in(folder.path(), &text, Some(Stage::Friction)).unwrap();
        assert_numbers(&outcome, USUAL);
        let surface = outcome.results.surface.unwrap();
        let covariance = surface.covariance.as_ref().unwrap();
        assert_eq!(covariance.model, "empirical");
        // The same standard deviation, through the standardised distribution of the heights.
        assert!((covariance.std_m / surface.scan().unwrap().Sq_m - 1.0).abs() < 1e-12);
        // Its length is the lag at which the scan's own correlation falls to 1/e, except for the mean that was added
        // back.
        let length_m = surface.scan().unwrap().correlation_length_x_m.unwrap();
        assert!((covariance.length_x_m / length_m - 1.0).abs() < 0.1, "{} {length_m}", covariance.length_x_m);
        let report = covariance.empirical.as_ref().unwrap();
        assert!(report.clipping_change < 0.1 && report.mean_share < 0.2, "{report:?}");
        assert!(
            outcome.results.assumptions.iter().any(|sentence| sentence.contains("the covariance of the scan itself"))
        );
        let table = &outcome.tables["height_acf"];
        let (own, met) = (table.column("acf_x").unwrap(), table.column("fit_x").unwrap());
        assert!((own[1] - met[1]).abs() < 0.05 && met[0] == 1.0);
    }
    // Model covariances have no such report, and the results omit the key.
    let outcome = run(&MODEL, Some(Stage::Surface));
    let json: Value = serde_json::from_slice(&json_bytes(&outcome.results).unwrap()).unwrap();
    assert!(json["surface"]["covariance"]["model"] == "squared_exponential");
    assert!(json["surface"]["covariance"].get("empirical").is_none());
}

#[test]
fn the_pixel_size_of_a_scan_is_overridden_with_a_warning_and_never_guessed() {
    let folder = tempfile::tempdir().unwrap();
    let scan = Scan::new(rough(64, 64, 0.5e-6, 16e-6), Some((2e-6, 2e-6)));
    asperity_formats::write(&scan, &folder.path().join("scan.x3p")).unwrap();
    let text = changed(&measured(), &[("scan.npy", "scan.x3p"), ("[\"2 um\", \"2 um\"]", "[\"4 um\", \"2 um\"]")]);
    let outcome = run_in(folder.path(), &text, Some(Stage::Surface)).unwrap();
    assert_eq!(outcome.results.surface.unwrap().scan().unwrap().dx_m, 4e-6);
    let warning = outcome.results.warnings.iter().find(|warning| warning.contains("pixel size")).unwrap();
    assert!(warning.contains("2 µm × 2 µm") && warning.contains("4 µm × 2 µm"), "{warning}");
    // An array file states no pixel size.
    let folder = folder_with(rough(64, 64, 0.5e-6, 16e-6));
    let text = changed(&measured(), &[("pixel_size = [\"2 um\", \"2 um\"]", "")]);
    let error = run_in(folder.path(), &text, Some(Stage::Surface)).unwrap_err();
    assert_eq!(error.kind(), FailureKind::Input);
    assert!(error.to_string().contains("scan.npy"), "{error}");
}

#[test]
fn the_study_states_the_height_unit_of_a_scan_without_one() {
    // The same heights in metre and, without a stated unit, in micrometre.
    let of = |factor: f64, unit: &str| {
        let folder = folder_with(rough(64, 64, 0.5e-6, 16e-6) * factor);
        let text = changed(&measured(), &[("scan.npy\"", &format!("scan.npy\"\n{unit}"))]);
        run_in(folder.path(), &text, Some(Stage::Surface))
    };
    let rms_m = |outcome: Outcome| outcome.results.surface.unwrap().scan().unwrap().Sq_m;
    // Without the unit the heights span metres on a field of 128 µm.
    let error = of(1e6, "").unwrap_err();
    assert_eq!(error.kind(), FailureKind::Configuration);
    let message = error.to_string();
    assert!(message.contains("more than the field of view, 128 µm") && message.contains("`height_unit`"), "{message}");
    let (metre, micrometre) = (rms_m(of(1.0, "").unwrap()), of(1e6, "height_unit = \"um\"").unwrap());
    let warnings = &micrometre.results.warnings;
    assert!(!warnings.iter().any(|warning| warning.contains("field of view")), "{warnings:?}");
    let micrometre = rms_m(micrometre);
    assert!((micrometre / metre - 1.0).abs() < 1e-12, "{micrometre:e}, not {metre:e}");
}

#[test]
fn a_scan_without_any_complete_profile_has_all_results() {
    let mut heights = rough(96, 96, 0.5e-6, 16e-6);
    (0..96).for_each(|i| heights[[i, (7 * i) % 96]] = f64::NAN);
    let folder = folder_with(heights);
    let outcome = run_in(folder.path(), &measured(), Some(Stage::Surface)).unwrap();
    assert_numbers(&outcome, USUAL);
    assert!(outcome.tables.contains_key("height_psd") && outcome.tables.contains_key("height_acf"));
    assert_eq!(outcome.results.surface.unwrap().scan().unwrap().missing_points, 96);
}

#[test]
#[ignore = "slow"]
fn tiny_noisy_or_long_correlated_scans_are_unusable_or_give_warnings() {
    let noise = random::standard_normal(&mut random::stream(8, "noise", 0), 64 * 64);
    let noise = Array2::from_shape_vec((64, 64), noise).unwrap().mapv(|z| 1e-6 * z);
    let folder = folder_with(noise);
    let outcome = run_in(folder.path(), &measured(), Some(Stage::Surface)).unwrap();
    let warnings = outcome.results.warnings.join("\n");
    assert!(warnings.contains("less than 1/e") && warnings.contains("noise"), "{warnings}");
    // Roughness longer than the map: a warning reports that the fit has little data.
    let folder = folder_with(rough(64, 64, 0.5e-6, 400e-6));
    let text = changed(&measured(), &[("[surface]", "[surface]\nlevel = \"mean\"")]);
    match run_in(folder.path(), &text, Some(Stage::Surface)) {
        Ok(outcome) => {
            let warnings = outcome.results.warnings.join("\n");
            let few = warnings.contains("correlation lengths long") || warnings.contains("independent patches");
            assert!(few, "{warnings}");
        }
        Err(error) => assert_eq!(error.kind(), FailureKind::Input, "{error}"),
    }
    for size in [2, 3, 8] {
        let folder = folder_with(rough(64, 64, 0.5e-6, 8e-6).slice(ndarray::s![..size, ..size]).to_owned());
        let text = changed(
            &measured(),
            &[("[surface]", "[surface]\ncovariance = \"exponential\"\ncorrelation_length = [\"9 um\", \"8 um\"]")],
        );
        match run_in(folder.path(), &text, Some(Stage::Surface)) {
            Ok(outcome) => assert!(outcome.results.surface.unwrap().scan().unwrap().Sq_m > 0.0),
            Err(error) => assert_eq!(error.kind(), FailureKind::Input, "{size}: {error}"),
        }
    }
}

/// Replaces a file by another when a stage begins.
struct Replaces<'a>(&'a Path, &'a Path);

impl Monitor for Replaces<'_> {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        false
    }

    fn begin(&self, _stage: &str) {
        fs::copy(self.1, self.0).unwrap();
    }
}

#[test]
fn a_scan_that_changes_before_it_is_read_ends_the_run() {
    let (folder, other) = (folder_with(rough(48, 40, 0.5e-6, 8e-6)), folder_with(rough(48, 40, 0.4e-6, 8e-6)));
    let [scan, other] = [&folder, &other].map(|folder| folder.path().join("scan.npy"));
    let study = Study::parse(&measured(), "study.toml").unwrap();
    let blocks = RunBlocks::open(&folder.path().join("run"), RunRecord::default(), Share::All).unwrap();
    let run = study.run_with(Some(&blocks), folder.path(), Some(Stage::Surface), &Replaces(&scan, &other));
    let error = run.map(drop).unwrap_err();
    assert!(matches!(&error, StudyError::Changed(name) if name.ends_with("scan.npy")), "{error}");
    assert_eq!(error.kind(), FailureKind::Input);
}
