//! Tests of `asperity init`, `check`, `run`, `report` and `surface generate`.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use asperity_formats::{Scan, read, read_npz, write_vtk_fields, write_x3p};
use asperity_testing::{METHODS, StudyText};
use ndarray::Array2;
use tempfile::TempDir;

#[cfg(target_os = "linux")]
use crate::support::run_and_interrupt;
use crate::support::{MANIFEST, asperity_in, folder_with_study, json_of, keys, listing, number, run_in, written};

/// A small study of every stage but friction; the friction process is stated.
static STUDY: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(5, &["surface", "material", "pressure", "vibration", "stated friction"])
        .with("surface", "covariance = \"squared_exponential\"\nmodes = 20")
        .with("pressure", METHODS)
        .with("pressure", "fine_solves = 40\nreference_samples = 100\nvariables = 3\ndegree = 1")
        .with("vibration", "damping_sweep = [0.1, 0.3, 3]\ntrajectories = 8\nduration = 64.0")
        .without("material", &["shear_strength"])
        .to_string()
});

/// All files below a folder, with their relative paths.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(dir) = open.pop() {
        for entry in fs::read_dir(dir).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned();
                found.push((name, fs::read(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn an_example_is_complete_valid_and_never_overwritten() {
    let folder = TempDir::new().unwrap();
    for (example, wanted) in [("quickstart", vec!["brake_disc.x3p", "quickstart.toml"]), ("paper", vec!["paper.toml"])]
    {
        let found = run_in(folder.path(), &format!("init {example} --example {example}"));
        assert_eq!((found.code, found.stdout.as_str()), (0, ""), "{found:?}");
        assert!(found.stderr.contains(&format!("asperity run {example}/{example}.toml")), "{found:?}");
        assert_eq!(listing(&folder.path().join(example)), wanted);
        let check = run_in(folder.path(), &format!("check {example}/{example}.toml --show"));
        assert_eq!(check.code, 0, "{check:?}");
        assert!(check.stdout.contains("contact solutions") && check.stdout.contains("MB"), "{check:?}");
        // `check --show` prints the same study with all defaults filled in.
        fs::write(folder.path().join(example).join("resolved.toml"), &check.stdout).unwrap();
        let again = run_in(folder.path(), &format!("check {example}/resolved.toml --json")).json(0);
        let first = run_in(folder.path(), &format!("check {example}/{example}.toml --json")).json(0);
        assert_eq!(again["study"], first["study"]);
        assert_eq!(keys(&first), ["estimate", "problems", "study", "warnings"]);
    }
    let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies");
    for file in ["quickstart/quickstart.toml", "quickstart/brake_disc.x3p", "paper/paper.toml"].map(Path::new) {
        let written = fs::read(folder.path().join(file)).unwrap();
        let original = studies.join(file.file_name().unwrap());
        assert!(written == fs::read(original).unwrap(), "{file:?} differs from the file in studies: copy it");
    }
    fs::write(folder.path().join("quickstart/quickstart.toml"), "mine").unwrap();
    fs::remove_file(folder.path().join("quickstart/brake_disc.x3p")).unwrap();
    run_in(folder.path(), "init quickstart").refuses(2, &["quickstart/quickstart.toml", "exists"]);
    assert_eq!(listing(&folder.path().join("quickstart")), ["quickstart.toml", "resolved.toml"]);
    run_in(folder.path(), "init quickstart/quickstart.toml").refuses(2, &["is a file", "folder"]);
    fs::write(folder.path().join("scan.bin"), [0xff, 0xfe]).unwrap();
    run_in(folder.path(), "run scan.bin").refuses(2, &["scan.bin", "TOML"]);
    run_in(folder.path(), "init --example papr").refuses(2, &["papr", "paper"]);
    // The run of the study has the name of the folder.
    assert_eq!(run_in(folder.path(), "init brake").code, 0);
    let text = fs::read_to_string(folder.path().join("brake/quickstart.toml")).unwrap();
    let line = "name = \"brake\"                           # of the run: runs/brake\n";
    let original = fs::read_to_string(studies.join("quickstart.toml")).unwrap();
    assert!(text.contains(line) && text.replace(line, "") == original, "{text}");
}

#[test]
fn a_run_writes_the_whole_folder_and_equal_studies_give_equal_bytes() {
    let folder = folder_with_study(&STUDY);
    let found = run_in(folder.path(), "run study.toml --threads 1");
    assert_eq!(found.code, 0, "{found:?}");
    assert!(found.stdout.starts_with("The machine vibrates (stick-slip)"), "{found:?}");
    let run = folder.path().join("runs/study");
    let wanted = [
        "COMPLETE",
        "fields",
        "figures",
        "machine.json",
        "provenance.json",
        "report.html",
        "results.json",
        "study.toml",
        "tables",
    ];
    assert_eq!(written(&run), wanted);
    assert_eq!(listing(&folder.path().join("runs")), ["study"]);
    let results = json_of(&run.join("results.json"));
    assert_eq!(
        keys(&results),
        ["assumptions", "pressure", "schema_version", "seed", "surface", "verdict", "vibration", "warnings"]
    );
    let methods: Vec<&str> =
        results["pressure"]["methods"].as_array().unwrap().iter().map(|m| m["name"].as_str().unwrap()).collect();
    for name in ["monte_carlo", "latin_hypercube", "sobol", "polynomial_chaos", "polynomial_chaos_log", "default"] {
        assert!(methods.contains(&name), "{name} is missing in {methods:?}");
    }
    // The printed object equals the file, up to the layout.
    let again = run_in(folder.path(), "run study.toml --out again --threads 2 --quiet --json");
    assert_eq!(again.json(0), results);
    let but_provenance = |dir: &Path| {
        let mut all = files(dir);
        // Times of this run, and hashes of files that contain such times.
        all.retain(|(name, _)| !["provenance.json", "report.html", MANIFEST].contains(&name.as_str()));
        all
    };
    let (first, second) = (but_provenance(&run), but_provenance(&folder.path().join("again")));
    assert!(first.len() > 10);
    for ((name, bytes), (other, others)) in first.iter().zip(&second) {
        assert!(name == other && bytes == others, "{name} and {other} differ");
    }
    assert_eq!(first.len(), second.len());
    // Each field is an array and an image.
    let index = json_of(&run.join("fields/index.json"));
    assert!(index["pressure_mean"].is_object());
    for (name, entry) in index.as_object().unwrap() {
        let array = format!("{name}_{}", entry["unit"].as_str().unwrap().to_lowercase());
        let archive = fs::read(run.join(format!("fields/{name}.npz"))).unwrap();
        let values = read_npz(&archive, array.trim_end_matches('_')).unwrap();
        let image =
            write_vtk_fields((number(entry, "dx_m"), number(entry, "dy_m")), &[(name.as_str(), &values)]).unwrap();
        assert!(fs::read(run.join(format!("fields/{name}.vti"))).unwrap() == image, "{name}");
    }
    let provenance = json_of(&run.join("provenance.json"));
    assert_eq!(provenance["asperity"], env!("CARGO_PKG_VERSION"));
    assert_eq!(provenance["inputs"]["study.toml"].as_str().unwrap().len(), 64);
    // The written study is complete: it gives the same results.
    fs::copy(run.join("study.toml"), folder.path().join("resolved.toml")).unwrap();
    assert_eq!(run_in(folder.path(), "run resolved.toml --quiet --json").json(0), results);
}

#[test]
fn rendering_a_report_again_gives_the_same_bytes_and_keeps_the_numbers() {
    let folder = folder_with_study(&STUDY);
    assert_eq!(run_in(folder.path(), "run study.toml --only surface --quiet").code, 0);
    let run = folder.path().join("runs/study");
    let before = files(&run);
    fs::write(run.join("report.html"), "spoiled").unwrap();
    assert_eq!(run_in(folder.path(), "report runs/study").code, 0);
    assert_eq!(files(&run), before);
    fs::rename(run.join("results.json"), folder.path().join("aside.json")).unwrap();
    run_in(folder.path(), "report runs/study").refuses(3, &["results.json"]);
    fs::rename(folder.path().join("aside.json"), run.join("results.json")).unwrap();
    let results = fs::read_to_string(run.join("results.json")).unwrap();
    for (version, found) in [("\"schema_version\": 7,", "schema_version 7"), ("", "no schema_version")] {
        fs::write(run.join("results.json"), results.replace("\"schema_version\": 1,", version)).unwrap();
        let wanted = [found, "reads version 1", "run the study again", "runs/study/study.toml"];
        run_in(folder.path(), "report runs/study").refuses(3, &wanted);
    }
    fs::write(run.join("results.json"), results.replace("\"seed\"", "\"sed\"")).unwrap();
    run_in(folder.path(), "report runs/study").refuses(3, &["results.json", "sed"]);
    fs::remove_file(run.join("COMPLETE")).unwrap();
    run_in(folder.path(), "report runs/study").refuses(3, &["runs/study", "not a finished run", "COMPLETE"]);
    run_in(folder.path(), "report nowhere").refuses(3, &["nowhere"]);
}

#[test]
fn only_selects_a_stage_and_seed_replaces_the_study_s() {
    let folder = folder_with_study(&STUDY);
    let run = |line: &str| run_in(folder.path(), &format!("run study.toml --quiet --json {line}"));
    let surface = run("--only surface --out a").json(0);
    assert_eq!(keys(&surface), ["assumptions", "schema_version", "seed", "surface", "warnings"]);
    let vibration = run("--only vibration --out b").json(0);
    assert!(vibration["vibration"].is_object() && vibration.get("pressure").is_none(), "{vibration}");
    let other = run("--only vibration --out c --seed 6").json(0);
    assert_eq!(other["seed"], 6);
    assert_ne!(other["vibration"]["area"], vibration["vibration"]["area"]);
    assert!(fs::read_to_string(folder.path().join("c/study.toml")).unwrap().starts_with("seed = 6\n"));
    run("--only friction --out d").refuses(2, &["study.toml", "[friction]"]);
    run("--only frction --out d").refuses(2, &["frction", "friction"]);
    assert_eq!(listing(folder.path()), ["a", "b", "c", "study.toml"]);
}

#[test]
fn a_wrong_study_names_file_line_key_and_the_nearest_right_one() {
    // The library has the other errors of keys and values.
    for (from, to, words) in [
        ("percentile =", "percentil =", vec!["`percentil`", "did you mean `percentile`"]),
        ("\"1 um\"", "\"-1 um\"", vec!["[surface] rms_height: found -1 um, expected a positive value"]),
        ("seed = 5", "seed = five", vec![]),
        ("seed = 5", "", vec!["seed"]),
    ] {
        let line = STUDY[..STUDY.find(from).unwrap()].matches('\n').count() + 1;
        let folder = folder_with_study(&STUDY.replace(from, to));
        for command in ["check", "run"] {
            let found = run_in(folder.path(), &format!("{command} study.toml"));
            found.refuses(2, &[&format!("study.toml:{line}: ")]);
            found.refuses(2, &words);
        }
        assert_eq!(listing(folder.path()), ["study.toml"]);
    }
}

#[test]
fn a_missing_or_unusable_input_is_a_data_error_not_a_usage_error() {
    let folder = folder_with_study(&STUDY.replace("covariance =", "file = \"scan.x3p\"\ncovariance ="));
    run_in(folder.path(), "run gone.toml").refuses(3, &["gone.toml", "no such file"]);
    fs::write(folder.path().join("long.toml"), "#".repeat(9 << 20)).unwrap();
    run_in(folder.path(), "run long.toml").refuses(3, &["long.toml", "larger than 8 MiB"]);
    fs::write(folder.path().join("binary.toml"), [0xff, 0xfe]).unwrap();
    run_in(folder.path(), "run binary.toml").refuses(2, &["binary.toml", "not a text file"]);
    fs::remove_file(folder.path().join("binary.toml")).unwrap();
    let scan = |heights_m: Array2<f64>| write_x3p(&Scan::new(heights_m, Some((1e-6, 1e-6)))).unwrap();
    let whole = scan(Array2::from_shape_fn((16, 16), |(row, column)| 1e-8 * ((row * 7 + column * 3) % 5) as f64));
    for (bytes, words) in [
        (None, vec!["study.toml:3: [surface] file: ", "scan.x3p", "no such file"]),
        (Some(whole[..whole.len() / 2].to_vec()), vec!["scan.x3p"]),
        (Some(scan(Array2::from_elem((16, 16), f64::NAN))), vec!["scan.x3p", "missing"]),
        (Some(scan(Array2::from_elem((1, 1), 0.0))), vec!["scan.x3p", "1 × 1"]),
    ] {
        if let Some(bytes) = bytes {
            fs::write(folder.path().join("scan.x3p"), bytes).unwrap();
        }
        for command in ["check", "run"] {
            run_in(folder.path(), &format!("{command} study.toml")).refuses(3, &words);
        }
        let _ = fs::remove_file(folder.path().join("scan.x3p"));
    }
    fs::write(folder.path().join("scan.x3p"), scan(Array2::from_elem((16, 16), 1e-7))).unwrap();
    run_in(folder.path(), "run study.toml").refuses(3, &["study.toml"]);
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_run_ends_with_130_and_leaves_nothing() {
    let folder = folder_with_study(&STUDY.replace("reference_samples = 100", "reference_samples = 5000000"));
    let (found, _) = run_and_interrupt(folder.path(), "run study.toml --out out");
    found.refuses(130, &["cancelled"]);
    assert_eq!(listing(folder.path()), ["study.toml"]);
}

#[test]
fn the_study_in_a_run_folder_runs_there_and_its_results_contain_no_path() {
    let folder = TempDir::new().unwrap();
    let home = folder.path().join("my study é");
    fs::create_dir(&home).unwrap();
    fs::write(home.join("spec.toml"), SPECIFICATION).unwrap();
    assert_eq!(run_in(&home, "surface generate spec.toml --out scan.x3p --quiet").code, 0);
    let text = STUDY[..STUDY.find("[material]").unwrap()].replace("covariance =", "file = \"scan.x3p\"\ncovariance =");
    fs::write(home.join("study.toml"), text).unwrap();
    // The scan lies beside the study, not in the working directory.
    let first = asperity_in(folder.path(), &["run", "my study é/study.toml", "--out", "first", "--json"]).json(0);
    let again = run_in(&folder.path().join("first"), "run study.toml --out ../again --json").json(0);
    assert_eq!(first, again);
    for run in ["first", "again"] {
        let results = fs::read_to_string(folder.path().join(run).join("results.json")).unwrap();
        assert!(!results.contains("my study") && !results.contains("/"), "{results}");
    }
}

#[test]
fn check_and_run_name_the_line_of_a_value_that_does_not_suit_the_scan() {
    let surface = &STUDY[..STUDY.find("[material]").unwrap()];
    let folder = TempDir::new().unwrap();
    // A surface that is smooth on the scale of its pixels has no scaling range.
    let wave = |index: usize| (std::f64::consts::TAU * index as f64 / 32.0).sin();
    let heights_m = Array2::from_shape_fn((64, 64), |(row, column)| 1e-7 * (wave(row) + wave(column)));
    let bytes = write_x3p(&Scan::new(heights_m, Some((1e-6, 1e-6)))).unwrap();
    fs::write(folder.path().join("scan.x3p"), bytes).unwrap();
    let fractal = "generator = \"weierstrass_mandelbrot\"\n";
    for (files, keys, line, words) in [
        ("\"scan.x3p\"", "s_filter = \"1 nm\"\n", 4, ["S-filter: the cutoff is 1 nm", "the pixel, 1 µm"]),
        ("\"scan.x3p\"", "s_filter = \"3 um\"\nl_filter = \"1 mm\"\n", 5, ["L-filter: the cutoff is 1 mm", "64 µm"]),
        ("[\"scan.x3p\", \"scan.x3p\"]", "l_filter = \"1 mm\"\n", 4, ["scan.x3p: L-filter", "64 µm"]),
        ("\"scan.x3p\"", fractal, 2, ["no scaling range", "`fractal_dimension`"]),
    ] {
        let keys = format!("[surface]\nfile = {files}\n{keys}");
        fs::write(folder.path().join("study.toml"), surface.replace("[surface]\n", &keys)).unwrap();
        let [check, run] = ["check", "run"].map(|command| run_in(folder.path(), &format!("{command} study.toml")));
        check.refuses(2, &[&format!("study.toml:{line}: ")]);
        check.refuses(2, &words);
        assert_eq!((check.code, check.stderr), (run.code, run.stderr));
        let map = "size = [\"16 um\", \"16 um\"]\npoints = [16, 16]\n[surface]\n";
        let specification = surface.replace("[surface]\n", &keys).replace("[surface]\n", map);
        fs::write(folder.path().join("spec.toml"), specification).unwrap();
        let generated = run_in(folder.path(), "surface generate spec.toml --out map.npy");
        generated.refuses(2, &[&format!("spec.toml:{}: ", line + 2)]);
        generated.refuses(2, &words);
    }
    assert_eq!(listing(folder.path()), ["scan.x3p", "spec.toml", "study.toml"]);
}

#[test]
#[ignore = "slow"]
fn several_scans_run_from_any_directory_and_an_invalid_one_is_named() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("spec.toml"), SPECIFICATION).unwrap();
    // Two scans of the same name in two folders.
    for (at, seed) in [("one", 1), ("two", 2)] {
        fs::create_dir(folder.path().join(at)).unwrap();
        let line = format!("surface generate spec.toml --seed {seed} --out {at}/scan.x3p --quiet");
        assert_eq!(run_in(folder.path(), &line).code, 0);
    }
    let study = |files: &str| {
        let text = STUDY[..STUDY.find("[material]").unwrap()]
            .replace("covariance =", &format!("file = {files}\ncovariance ="));
        fs::write(folder.path().join("study.toml"), text).unwrap();
    };
    study("[\"one/scan.x3p\", \"two/scan.x3p\"]");
    assert_eq!(run_in(folder.path(), "check study.toml --json").code, 0);
    let first = run_in(folder.path(), "run study.toml --out first --json").json(0);
    assert_eq!(
        (&first["surface"]["scan_count"], &first["surface"]["scans"][1]["file"]),
        (&2.into(), &"scan.x3p".into())
    );
    let again = run_in(&folder.path().join("first"), "run study.toml --out ../again --json").json(0);
    assert_eq!(first, again);
    let report = fs::read_to_string(folder.path().join("first/report.html")).unwrap();
    assert!(report.contains("Measured: scan.x3p, the first of 2 scans"));
    let provenance = json_of(&folder.path().join("first/provenance.json"));
    assert_eq!(provenance["inputs"].as_object().unwrap().len(), 3, "{provenance}");
    study("[\"one/scan.x3p\", \"two/skan.x3p\"]");
    for command in ["check", "run"] {
        let found = run_in(folder.path(), &format!("{command} study.toml"));
        found.refuses(3, &["skan.x3p", "no such file"]);
        assert!(!found.stderr.contains("os error"), "{found:?}");
    }
    study("[]");
    run_in(folder.path(), "run study.toml").refuses(2, &["study.toml:3", "empty"]);
}

#[test]
fn a_failed_run_leaves_no_folder_and_keeps_existing_ones() {
    // A tolerance below double precision leaves no valid sample.
    let folder = folder_with_study(&STUDY.replace("percentile = 50.0", "percentile = 50.0\ntolerance = 1e-30"));
    let failed = run_in(folder.path(), "run study.toml --only pressure --json").json(4);
    assert_eq!(failed["converged"], false);
    // The blocks alone stay.
    assert_eq!(listing(&folder.path().join("runs")), [""; 0]);
    fs::remove_dir_all(folder.path().join("runs")).unwrap();
    assert_eq!(listing(folder.path()), ["study.toml"]);
    fs::create_dir(folder.path().join("mine")).unwrap();
    assert_eq!(run_in(folder.path(), "run study.toml --only pressure --out mine/a/b").code, 4);
    assert_eq!(listing(folder.path()), ["mine", "study.toml"]);
    assert_eq!(listing(&folder.path().join("mine/a")), [""; 0]);
    assert_eq!(run_in(folder.path(), "run study.toml --only surface --out mine/a/b --quiet").code, 0);
    assert!(folder.path().join("mine/a/b/COMPLETE").is_file());
}

#[cfg(target_os = "linux")]
#[test]
fn a_study_too_large_for_the_memory_is_a_problem_for_check_and_a_lack_of_resources_for_run() {
    let folder = folder_with_study(&STUDY.replace("points = [16, 16]", "points = [1000000, 1000000]"));
    let found = run_in(folder.path(), "check study.toml --json");
    let checked = found.json(5);
    assert!(found.stderr.contains("error: the pressure stage needs about"), "{found:?}");
    let problem = checked["problems"][0].as_str().unwrap();
    assert!(problem.contains("pressure stage") && problem.contains("GB"), "{problem}");
    run_in(folder.path(), "run study.toml").refuses(5, &["pressure stage", "GB"]);
    assert_eq!(listing(folder.path()), ["study.toml"]);
}

#[test]
fn check_gives_the_warnings_of_run_and_refuses_what_run_refuses() {
    // Young's modulus of 15 GPa over a hardness of 2 GPa, friction above 1.5, damping above 1, and a normal force beyond the hardness.
    let doubtful = STUDY
        .replace("210 GPa", "15 GPa")
        .replace("static_friction = 0.1", "static_friction = 1.6")
        .replace("damping_ratio = 0.17", "damping_ratio = 1.2")
        .replace("833 mm^2", "1 mm^2");
    let folder = folder_with_study(&doubtful);
    let found = run_in(folder.path(), "check study.toml --json");
    let warnings: Vec<String> =
        found.json(0)["warnings"].as_array().unwrap().iter().map(|w| w.as_str().unwrap().to_owned()).collect();
    for wanted in [
        "[material] Young's modulus 15 GPa is less than ten times the hardness 2 GPa",
        "[vibration] the friction coefficient 1.6 is above 1.5",
        "[vibration] the damping ratio 1.2 is above 1",
        "[vibration] the normal force 2.5 kN presses the nominal area 1 mm^2 with 2.5 GPa, which is not below the hardness 2 GPa",
    ] {
        assert!(warnings.iter().any(|warning| warning.starts_with(wanted)), "{wanted} in {warnings:?}");
    }
    let text = run_in(folder.path(), "check study.toml");
    let ran = run_in(folder.path(), "run study.toml --only vibration");
    assert_eq!((text.code, ran.code), (0, 0), "{ran:?}");
    for warning in &warnings {
        assert!(text.stdout.contains(&format!("\nwarning: {warning}\n")), "{text:?}");
        assert!(ran.stderr.contains(&format!("warning: {warning}")), "{ran:?}");
    }
    // The standard deviation of the friction equals its mean.
    let wild = folder_with_study(&STUDY.replace("friction_std = 0.001", "friction_std = 0.1\nupscaling = \"paper\""));
    let refused = run_in(wild.path(), "check study.toml --json");
    let problem = refused.json(2)["problems"][0].as_str().unwrap().to_owned();
    assert!(problem.contains("would be clipped to stay positive, more than 5 %"), "{problem}");
    run_in(wild.path(), "run study.toml").refuses(2, &["would be clipped", "allow_clipping = true"]);
    assert_eq!(listing(wild.path()), ["study.toml"]);
}

#[test]
fn a_quiet_run_prints_nothing_and_a_plain_one_names_the_report() {
    let folder = folder_with_study(&STUDY);
    let quiet = run_in(folder.path(), "run study.toml --only surface --out a --quiet --json");
    assert_eq!((quiet.code, quiet.stderr.as_str()), (0, ""));
    let plain = run_in(folder.path(), "run study.toml --only surface --out b");
    assert!(plain.code == 0 && plain.stderr.contains("wrote b/report.html"), "{plain:?}");
}

/// A map of a stated surface.
const SPECIFICATION: &str = "seed = 3\nsize = [\"64 um\", \"32 um\"]\npoints = [64, 32]\n[surface]\ncovariance = \"exponential\"\n\
                             marginal = \"normal\"\nrms_height = \"1 um\"\ncorrelation_length = \"8 um\"\n\
                             generator = \"spectral\"\n";

#[test]
fn generated_maps_depend_on_seed_and_index_alone() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("spec.toml"), SPECIFICATION).unwrap();
    let run = |line: &str| {
        let found = run_in(folder.path(), &format!("surface generate spec.toml --quiet {line}"));
        assert_eq!((found.code, found.stdout.as_str()), (0, ""), "{found:?}");
    };
    run("--seed 3 --out one.npy");
    run("--seed 3 --count 3 --out maps");
    run("--seed 4 --out other.npy");
    run("--out same.x3p");
    assert_eq!(written(&folder.path().join("maps")), ["map_0000.x3p", "map_0001.x3p", "map_0002.x3p"]);
    let heights = |name: &str| read(&folder.path().join(name)).unwrap().heights_m;
    let one = heights("one.npy");
    assert_eq!(one.dim(), (32, 64));
    assert_eq!(one, heights("maps/map_0000.x3p"));
    assert_eq!(one, heights("same.x3p"));
    assert_ne!(one, heights("maps/map_0001.x3p"));
    assert_ne!(one, heights("other.npy"));
    assert_eq!(read(&folder.path().join("same.x3p")).unwrap().pitch_m, Some((1e-6, 1e-6)));
}

#[test]
fn a_wrong_specification_or_target_writes_nothing() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("spec.toml"), SPECIFICATION).unwrap();
    fs::write(folder.path().join("typo.toml"), SPECIFICATION.replace("points", "point")).unwrap();
    fs::write(folder.path().join("thin.toml"), SPECIFICATION.replace("[64, 32]", "[64, 1]")).unwrap();
    let before = listing(folder.path());
    for (line, code, words) in [
        ("typo.toml --seed 1 --out a.npy", 2, vec!["typo.toml:3:", "did you mean `points`"]),
        ("thin.toml --seed 1 --out a.npy", 2, vec!["thin.toml:3:", "64 × 1"]),
        ("gone.toml --seed 1 --out a.npy", 3, vec!["gone.toml", "no such file"]),
        ("spec.toml --seed 1 --out a.tiff", 2, vec![".tiff"]),
        ("spec.toml --seed 1 --out nowhere/a.npy", 2, vec!["nowhere"]),
        ("spec.toml --seed x --out a.npy", 2, vec!["--seed"]),
        ("spec.toml --seed 1 --count 0 --out a", 2, vec!["--count", "at least 1"]),
        ("spec.toml --seed 1 --count 2 --out typo.toml", 2, vec!["typo.toml", "folder"]),
        ("spec.toml --seed 1", 2, vec!["--out"]),
    ] {
        run_in(folder.path(), &format!("surface generate {line}")).refuses(code, &words);
        assert_eq!(listing(folder.path()), before);
    }
}

#[test]
fn init_writes_the_study_of_a_scan() {
    let folder = TempDir::new().unwrap();
    assert_eq!(run_in(folder.path(), "init example").code, 0);
    let found = run_in(folder.path(), "init mine --scan example/brake_disc.x3p --level quadratic");
    assert_eq!(found.code, 0, "{found:?}");
    let text = fs::read_to_string(folder.path().join("mine/study.toml")).unwrap();
    for part in [
        "# Study of brake_disc.x3p. The scan resolves waves down to 8 µm",
        "level = \"quadratic\"                      # form to remove",
        "# your scan, or several of one part",
        "\nsize = [\"130 um\", \"83 um\"]\n",
        // Four points to the shortest wave.
        "strip = [\"5.952 mm\", \"96 um\"]\n",
        "points = [2976, 48]\nwindow = \"595.2 um\"\n",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let [scan, copy] =
        ["example", "mine"].map(|name| fs::read(folder.path().join(name).join("brake_disc.x3p")).unwrap());
    assert!(scan == copy);
    assert_eq!(run_in(folder.path(), "run mine/study.toml --only surface").code, 0);
    assert!(folder.path().join("runs/mine/COMPLETE").is_file());

    // The scan stays where it is if it is in the folder, and options of the file are keys of the study.
    fs::create_dir(folder.path().join("other")).unwrap();
    assert_eq!(run_in(folder.path(), "surface convert mine/brake_disc.x3p other/scan.npy").code, 0);
    run_in(folder.path(), "init other --scan other/scan.npy").refuses(3, &["scan.npy", "--pixel-size"]);
    let found = run_in(folder.path(), "init other --scan other/scan.npy --pixel-size 2um,2um --height-unit m");
    assert_eq!(found.code, 0, "{found:?}");
    let text = fs::read_to_string(folder.path().join("other/study.toml")).unwrap();
    assert!(text.contains("\npixel_size = [\"2 um\", \"2 um\"]\nheight_unit = \"m\"\nlevel = "), "{text}");
    assert_eq!(run_in(folder.path(), "check other/study.toml").code, 0);

    // The first form with which the correlation falls to 1/e: half a wave along x bends more than the roughness.
    let wave = |ny: usize, nx: usize| {
        Array2::from_shape_fn((ny, nx), |(row, column)| {
            let (x, y) = (column as f64 / nx as f64, row as f64);
            1e-6 * (20.0 * x * x
                + (2.4 * column as f64).sin() * (1.9 * y).cos()
                + (0.7 * column as f64 + 0.6 * y).sin())
        })
    };
    for (name, heights_m) in [("bent.x3p", wave(64, 64)), ("small.x3p", wave(4, 64))] {
        fs::write(folder.path().join(name), write_x3p(&Scan::new(heights_m, Some((1e-6, 1e-6)))).unwrap()).unwrap();
    }
    let found = run_in(folder.path(), "init bent --scan bent.x3p");
    assert_eq!(found.code, 0, "{found:?}");
    let text = fs::read_to_string(folder.path().join("bent/study.toml")).unwrap();
    let comment = "# with \"plane\" the correlation of the heights does not fall to 1/e within half of the scan\nlevel = \"quadratic\" ";
    assert!(text.contains(comment), "{text}");
    let words = ["bent.x3p", "`level = \"quadratic\"`", "`l_filter`"];
    run_in(folder.path(), "init third --scan bent.x3p --level plane").refuses(3, &words);
    run_in(folder.path(), "init third --scan small.x3p")
        .refuses(3, &["small.x3p", "64 × 4 points", "at least 32 × 32"]);
    run_in(folder.path(), "init third --scan absent.x3p").refuses(3, &["absent.x3p"]);
    run_in(folder.path(), "init third --pixel-size 1um").refuses(2, &["--scan"]);
    run_in(folder.path(), "init third --example paper --scan mine/brake_disc.x3p").refuses(2, &["--example"]);
    assert!(!folder.path().join("third").exists());
}
