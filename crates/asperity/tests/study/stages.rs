//! The whole chain on small studies.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use asperity::monitor::Silent;
use asperity::study::{
    FailureKind, Outcome, Stage, Staging, StoreError, StoredRun, Study, StudyError, json_bytes, provenance, write_run,
};
use asperity_formats::Scan;
use asperity_testing::{AlwaysCancelled, METHODS, StudyText};

use crate::support::{rough, run_all, run_in};

static STUDY: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(7, &["material", "pressure", "friction", "vibration"])
        .with("pressure", METHODS)
        .with("pressure", "points = [24, 24]\nfine_solves = 60\nreference_samples = 80\nvariables = 2\ndegree = 1")
        .with("friction", "strip = [\"2 mm\", \"50 um\"]\npoints = [512, 16]\nwindow = \"200 um\"")
        .with("friction", "percentiles = [20.0, 60.0]\nrealisations = 4")
        .with("vibration", "normal_force = \"30 kN\"\ndamping_sweep = [0.1, 0.5, 3]\ntrajectories = 6")
        .with("vibration", "duration = 100.0")
        .with("surface", "outliers = 6.0\nmodes = 40\nfile = \"scan.x3p\"")
        .to_string()
});

/// Writes a tilted random scan into `folder`, with correlation length `length_m`.
fn write_scan(folder: &Path, rms_m: f64, length_m: f64) {
    let mut heights = rough(128, 128, rms_m, length_m);
    heights.indexed_iter_mut().for_each(|((row, column), z)| *z += 1e-9 * column as f64 - 2e-9 * row as f64);
    heights[[5, 7]] = f64::NAN;
    asperity_formats::write(&Scan::new(heights, Some((2e-6, 2e-6))), &folder.join("scan.x3p")).unwrap();
}

fn run(text: &str, folder: &Path, threads: usize) -> Outcome {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| run_in(folder, text, None)).unwrap()
}

#[test]
#[ignore = "slow"]
fn one_and_two_threads_give_the_same_bytes_from_a_scan_to_the_verdict() {
    let folder = tempfile::tempdir().unwrap();
    write_scan(folder.path(), 0.5e-6, 20e-6);
    let uncertain = STUDY.replace("damping_ratio = 0.17", "damping_ratio = \"0.17 ± 0.02\"");
    let text = format!("{uncertain}\n[verdict]\nhalf_width = 0.1\nevaluations = 1000\n");
    let [one, two] = [1, 2].map(|threads| run(&text, folder.path(), threads));
    assert!(one.results.verdict.is_some() && one.results.friction.is_some());
    assert_eq!(json_bytes(&one.results).unwrap(), json_bytes(&two.results).unwrap());
    assert_eq!(one.tables.len(), two.tables.len());
    for (name, table) in &one.tables {
        assert_eq!(table.to_csv().unwrap(), two.tables[name].to_csv().unwrap(), "{name}");
    }
}

/// Runs the first stage alone on the named scans.
fn surface_of(folder: &Path, file: &str) -> Result<Outcome, StudyError> {
    run_in(folder, &STUDY.replace("\"scan.x3p\"", file), Some(Stage::Surface))
}

/// Writes two scans, `a.x3p` and the rougher `b.x3p` with a longer correlation.
fn two_scans() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, rms_m, length_m) in [("a.x3p", 0.5e-6, 10e-6), ("b.x3p", 1e-6, 14e-6)] {
        write_scan(folder.path(), rms_m, length_m);
        fs::rename(folder.path().join("scan.x3p"), folder.path().join(name)).unwrap();
    }
    folder
}

#[test]
#[ignore = "slow"]
fn a_list_of_one_scan_gives_the_same_bytes_as_the_scan() {
    let folder = two_scans();
    let one = run(&STUDY.replace("scan.x3p", "a.x3p"), folder.path(), 2);
    let list = run(&STUDY.replace("\"scan.x3p\"", "[\"a.x3p\"]"), folder.path(), 2);
    assert_eq!(json_bytes(&one.results).unwrap(), json_bytes(&list.results).unwrap());
    for (name, table) in &one.tables {
        assert_eq!(table.to_csv().unwrap(), list.tables[name].to_csv().unwrap(), "{name}");
    }
}

#[test]
#[ignore = "slow"]
fn two_scans_are_pooled_into_one_surface() {
    let folder = two_scans();
    let [a, b, both] =
        ["\"a.x3p\"", "\"b.x3p\"", "[\"a.x3p\", \"b.x3p\"]"].map(|f| surface_of(folder.path(), f).unwrap());
    let surface = |outcome: &Outcome| serde_json::to_value(outcome.results.surface.as_ref().unwrap()).unwrap();
    let ([of_a, of_b, of_both], [a, b, both]) = ([&a, &b, &both].map(surface), [a, b, both]);
    for key in ["Sq_m", "Sa_m", "correlation_length_x_m", "correlation_length_y_m", "Sk_m"] {
        let [low, value, high] = [&of_a, &of_both, &of_b].map(|s| s[key].as_f64().unwrap());
        assert!(low < value && value < high, "{key}: {low} {value} {high}");
        let interval = &of_both[format!("{key}_interval")];
        assert!(interval[0].as_f64().unwrap() <= value && value <= interval[1].as_f64().unwrap(), "{key}: {interval}");
        assert!(of_both[format!("{key}_between_std")].as_f64().unwrap() > 0.0, "{key}");
    }
    // Every key of one scan is present but its direction and the corners of its spectrum, and so are the scans themselves.
    for key in of_a.as_object().unwrap().keys().filter(|key| !["Std_rad", "psd_corners_m2"].contains(&key.as_str())) {
        assert!(of_both.get(key).is_some(), "{key}");
    }
    assert_eq!((of_both["scan_count"].as_u64(), of_both["missing_points"].as_u64()), (Some(2), Some(2)));
    assert_eq!((of_both["scans"][1]["file"].as_str(), &of_both["scans"][1]["Sq_m"]), (Some("b.x3p"), &of_b["Sq_m"]));
    // Random surfaces follow: variance and correlation length lie between those of the scans.
    let length = |s: &serde_json::Value| s["covariance"]["length_x_m"].as_f64().unwrap();
    assert!(length(&of_a) < length(&of_both) && length(&of_both) < length(&of_b));
    let [std_m, sq_m] = [&of_both["covariance"]["std_m"], &of_both["Sq_m"]].map(|value| value.as_f64().unwrap());
    assert!((std_m / sq_m - 1.0).abs() < 1e-12, "{std_m} {sq_m}");
    // Maps and tables show the first scan.
    let bits = |o: &Outcome| o.fields["height_levelled"].values().iter().map(|z| z.to_bits()).collect::<Vec<u64>>();
    assert!(bits(&both) == bits(&a) && bits(&both) != bits(&b));
    assert_eq!(both.tables["height_acf"].column("acf_x"), a.tables["height_acf"].column("acf_x"));
    assert_ne!(b.tables["height_acf"].column("acf_x"), a.tables["height_acf"].column("acf_x"));
}

#[test]
fn a_wrong_scan_of_several_is_named() {
    let folder = two_scans();
    let write = |name: &str, side: usize, pitch_m: f64| {
        let heights = ndarray::Array2::from_shape_fn((side, side), |(row, column)| {
            1e-6 * ((row * row + 3 * column) as f64).sin() * if name == "flat.x3p" { 0.0 } else { 1.0 }
        });
        asperity_formats::write(&Scan::new(heights, Some((pitch_m, pitch_m))), &folder.path().join(name)).unwrap();
    };
    write("flat.x3p", 64, 2e-6);
    write("point.x3p", 1, 2e-6);
    write("fine.x3p", 64, 1e-6);
    fs::write(folder.path().join("torn.x3p"), b"PK\x03\x04 truncated").unwrap();
    for wrong in ["flat.x3p", "point.x3p", "fine.x3p", "torn.x3p", "gone.x3p"] {
        let error = surface_of(folder.path(), &format!("[\"a.x3p\", \"{wrong}\"]")).unwrap_err();
        assert!(error.to_string().contains(wrong), "{wrong}: {error}");
        assert_eq!(error.kind(), FailureKind::Input, "{wrong}: {error}");
    }
    let empty = Study::parse(&STUDY.replace("\"scan.x3p\"", "[]"), "study.toml").unwrap_err();
    let line = STUDY.lines().count();
    assert!(empty.line == line && empty.message.contains("empty"), "{empty}");
    let number = Study::parse(&STUDY.replace("\"scan.x3p\"", "3"), "study.toml").unwrap_err();
    assert!(number.line == line && number.message.contains("list of names"), "{number}");
}

#[test]
#[ignore = "slow"]
fn limits_of_the_correlation_are_drawn_around_it() {
    let folder = two_scans();
    let outcome = surface_of(folder.path(), "\"a.x3p\"").unwrap();
    let column = |name: &str| outcome.tables["height_acf"].column(name).unwrap().to_vec();
    for axis in ["x", "y"] {
        let [acf, low, high] = ["", "_low", "_high"].map(|end| column(&format!("acf_{axis}{end}")));
        assert_eq!((low[0], high[0]), (1.0, 1.0));
        for lag in 1..acf.len() {
            // The variance that the plane removed is added back, so the limits lie slightly higher.
            assert!(low[lag] < acf[lag] + 0.02 && acf[lag] < high[lag] && high[lag] - low[lag] < 0.6, "{axis} {lag}");
        }
    }
}

#[test]
fn friction_may_be_stated() {
    let text = StudyText::new(1, &["vibration", "stated friction"])
        .with("vibration", "damping_sweep = [0.1, 0.3, 2]\ntrajectories = 4\nduration = 60.0");
    let vibration = run_all(&text.to_string()).results.vibration.unwrap();
    // λ = ℓ c/N with c = m ω₀².
    assert!((vibration.correlation_length.unwrap() - 250e-6 * 316.0 * 316.0 / 2500.0).abs() < 1e-12);
    assert!((vibration.critical_damping_ratio.unwrap() - 0.2048301505845).abs() < 1e-8);
    assert!((vibration.cycle.period.unwrap() - 6.372163483739709).abs() < 1e-8);
}

#[test]
fn a_cancelled_run_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    write_scan(folder.path(), 0.5e-6, 20e-6);
    let error = Study::parse(&STUDY, "study.toml").unwrap().run(folder.path(), None, &AlwaysCancelled).unwrap_err();
    assert_eq!(error.kind(), FailureKind::Cancelled, "{error}");
}

#[test]
fn a_run_folder_appears_complete_and_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    write_scan(folder.path(), 0.5e-6, 20e-6);
    let study = Study::parse(&STUDY, "study.toml").unwrap();
    let outcome = study.run(folder.path(), Some(Stage::Surface), &Silent).unwrap();
    let origin = provenance("small", study.seed(), &study.scan_paths(folder.path())).unwrap();
    let out = folder.path().join("runs").join("small");
    {
        let abandoned = Staging::open(&out, false, &[]).unwrap();
        write_run(&abandoned, &study, folder.path(), &outcome, &origin).unwrap();
    }
    assert!(!folder.path().join("runs").exists(), "an abandoned run leaves something behind");
    let staging = Staging::open(&out, false, &[]).unwrap();
    write_run(&staging, &study, folder.path(), &outcome, &origin).unwrap();
    staging.commit().unwrap();
    let stored = StoredRun::load(&out).unwrap();
    assert_eq!((&stored.results, &stored.provenance), (&outcome.results, &origin));
    assert_eq!(stored.tables["height_acf"].column("lag_m"), outcome.tables["height_acf"].column("lag_m"));
    let (back, field) = (&stored.fields["height_levelled"], &outcome.fields["height_levelled"]);
    assert_eq!((back.dx_m(), back.unit()), (2e-6, "m"));
    assert!(
        back.values().iter().zip(field.values()).all(|(a, b)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan())
    );
    let index = out.join("fields/index.json");
    let whole = fs::read_to_string(&index).unwrap();
    fs::write(&index, whole.replacen("2e-6", "0", 1)).unwrap();
    let refused = StoredRun::load(&out).unwrap_err();
    assert!(matches!(&refused, StoreError::Corrupt { reason, .. } if reason.contains("pitches 0")), "{refused}");
    fs::write(&index, whole).unwrap();
    assert!(Staging::open(&out, false, &[]).is_err(), "a finished run is not overwritten unasked");
    // Inputs are never deleted.
    let scan = out.join("results.json");
    assert!(matches!(Staging::open(&out, true, &[&scan]), Err(StoreError::HoldsInput { .. })));
    let replaced = Staging::open(&out, true, &[]).unwrap();
    replaced.write("study.toml", b"").unwrap();
    replaced.commit().unwrap();
    assert!(StoredRun::load(&out).is_err(), "the new content has no results");
    assert_eq!(fs::read_dir(folder.path().join("runs")).unwrap().count(), 1);
}

#[test]
fn a_stage_without_its_section_is_refused() {
    let study = Study::parse("seed = 1\n[surface]\nmarginal = \"normal\"\ncovariance = \"exponential\"\nrms_height = \"1 um\"\ncorrelation_length = [\"1 um\", \"1 um\"]\n", "s").unwrap();
    let error = study.run(Path::new("."), Some(Stage::Pressure), &Silent).unwrap_err();
    assert!(matches!(error, StudyError::NoStage("pressure")));
    assert_eq!(error.kind(), FailureKind::Configuration);
}

#[test]
fn a_folder_that_is_removed_while_it_is_written_is_whole_or_an_error() {
    let parent = tempfile::tempdir().unwrap();
    let remove_all = || {
        for entry in fs::read_dir(parent.path()).unwrap() {
            fs::remove_dir_all(entry.unwrap().path()).unwrap();
        }
    };
    // Before the first file.
    let staging = Staging::open(&parent.path().join("run"), false, &[]).unwrap();
    remove_all();
    staging.write("one.txt", b"1").unwrap();
    let run = staging.commit().unwrap();
    // asperity knows the folder as its own.
    drop(Staging::open(&run, true, &[]).unwrap());
    // Between two files.
    let staging = Staging::open(&parent.path().join("other"), false, &[]).unwrap();
    staging.write("one.txt", b"1").unwrap();
    remove_all();
    staging.write("two.txt", b"2").unwrap();
    assert!(matches!(staging.commit(), Err(StoreError::Io { .. })));
    assert!(!parent.path().join("other").exists());
}
