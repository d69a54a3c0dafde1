//! Tests of finished and unfinished folders that are taken up again: changed inputs, other kinds of folders, and memory.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use asperity_testing::{METHODS, StudyText};
use ndarray::Array2;
use tempfile::TempDir;

use crate::support::{json_of, npy, run_in};

/// Statistics of two bodies.
const BODIES: &str = "seed = 1\n[surface]\nfile = \"a.npy\"\npixel_size = \"1 um\"\n\
                      [counterface]\nfile = \"b.npy\"\npixel_size = \"1 um\"\n";
/// Statistics of the scans of a folder.
const CAMPAIGN: &str = "study = \"one.toml\"\nscans = \"lot/*.npy\"\n";
static MACHINE: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(5, &["vibration", "stated friction"])
        .with("vibration", "damping_ratio = 0.4\nstatic_friction = 0.4\nfriction_std = 0.01")
        .with("vibration", "friction_marginal = \"normal\"\nfriction_correlation_length = \"10 um\"")
        .with("vibration", "damping_sweep = [0.3, 0.5, 2]\ntrajectories = 16\nduration = 20.0")
        .to_string()
});

/// Writes a wavy map.
fn scan(file: &Path, wave: f64) {
    let height = |(y, x): (usize, usize)| 1e-6 * ((wave * x as f64).sin() + (0.9 * wave * y as f64).cos());
    npy(file.parent().unwrap(), file.file_name().unwrap().to_str().unwrap(), Array2::from_shape_fn((48, 48), height));
}

fn swap(one: &Path, other: &Path) {
    let [first, second] = [one, other].map(|file| fs::read(file).unwrap());
    fs::write(one, second).unwrap();
    fs::write(other, first).unwrap();
}

/// Returns a folder with a study of two scans, a campaign of two, and a machine.
fn bench() -> TempDir {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("lot")).unwrap();
    for (name, wave) in [("a.npy", 0.5), ("b.npy", 0.7)] {
        scan(&at.join(name), wave);
        scan(&at.join("lot").join(name), wave);
    }
    let one = BODIES.split("[counterface]").next().unwrap();
    for (name, text) in [("two.toml", BODIES), ("one.toml", one), ("lots.toml", CAMPAIGN), ("machine.toml", &MACHINE)] {
        fs::write(at.join(name), text).unwrap();
    }
    folder
}

#[test]
#[ignore = "slow"]
fn a_finished_folder_is_no_result_of_other_scans() {
    let folder = bench();
    let at = folder.path();
    for line in ["run two.toml", "campaign lots.toml"] {
        assert_eq!(run_in(at, line).code, 0);
        assert_eq!(run_in(at, &format!("{line} --resume")).code, 0);
    }
    assert_eq!(run_in(at, "repro campaigns/lots").stdout, "IDENTICAL\n");
    swap(&at.join("a.npy"), &at.join("b.npy"));
    run_in(at, "run two.toml --resume").refuses(2, &["another study"]);
    run_in(at, "repro runs/two").refuses(3, &["a.npy has changed"]);
    swap(&at.join("lot/a.npy"), &at.join("lot/b.npy"));
    run_in(at, "campaign lots.toml --resume").refuses(2, &["another campaign"]);
    run_in(at, "repro campaigns/lots").refuses(3, &["a.npy has changed"]);
    swap(&at.join("lot/a.npy"), &at.join("lot/b.npy"));
    assert_eq!(run_in(at, "campaign lots.toml --resume").code, 0);
    fs::copy(at.join("lot/a.npy"), at.join("lot/c.npy")).unwrap();
    run_in(at, "campaign lots.toml --resume").refuses(2, &["another campaign"]);
    for gone in ["lot/b.npy", "lot/c.npy"] {
        fs::remove_file(at.join(gone)).unwrap();
    }
    run_in(at, "campaign lots.toml --resume").refuses(2, &["another campaign"]);
    // A run is no campaign and a campaign is no run.
    run_in(at, "run one.toml --out campaigns/lots --resume").refuses(2, &["another study"]);
    run_in(at, "campaign lots.toml --out runs/two --resume").refuses(2, &["another campaign"]);
    run_in(at, "run lots.toml").refuses(2, &["lots.toml is a campaign"]);
    run_in(at, "campaign two.toml").refuses(2, &["two.toml is a study"]);
}

#[test]
#[ignore = "slow"]
fn parts_of_other_scans_and_folders_that_are_no_parts_are_not_merged() {
    let folder = bench();
    let at = folder.path();
    let text = format!(
        "{}\n[vibration]{}",
        BODIES.split("[counterface]").next().unwrap(),
        MACHINE.split("[vibration]").nth(1).unwrap()
    );
    fs::write(at.join("one.toml"), text).unwrap();
    assert_eq!(run_in(at, "run one.toml --shard 1/2 --out parts/1").code, 0);
    swap(&at.join("a.npy"), &at.join("b.npy"));
    assert_eq!(run_in(at, "run one.toml --shard 2/2 --out parts/2").code, 0);
    run_in(at, "merge parts/1 parts/2 --out all").refuses(2, &["parts/2 is of another version of the scans"]);
    run_in(at, "merge parts/1 --out all --finish").refuses(2, &["parts/1 is of another version of the scans"]);
    // The folder above several runs is not one of them.
    for run in ["first", "second"] {
        assert_eq!(run_in(at, &format!("run machine.toml --out runs/{run}")).code, 0);
    }
    run_in(at, "status runs").refuses(3, &["runs: no run"]);
    run_in(at, "merge runs --out all").refuses(3, &["runs: no blocks of a part"]);
    run_in(at, "merge runs/first --out all").refuses(2, &["runs/first is a run"]);
    run_in(at, "repro runs --sample trajectories:0").refuses(3, &["runs: no blocks of a run"]);
    let status = run_in(at, "status runs/first").stdout;
    let row = status.lines().find(|line| line.starts_with("vibration")).unwrap();
    assert!(status.contains("machine.toml, seed 5: finished\n") && row.ends_with(" 0"), "{status}");
    // A missing scan is missing data for every command.
    fs::remove_file(at.join("a.npy")).unwrap();
    for line in ["run one.toml", "run one.toml --shard 1/2", "run one.toml --out parts/1 --shard 1/2"] {
        run_in(at, line).refuses(3, &["a.npy: no such file"]);
    }
}

#[test]
#[ignore = "slow"]
fn the_memory_estimate_is_between_the_peak_and_one_and_a_half_times_the_peak() {
    let folder = bench();
    let at = folder.path();
    scan(&at.join("a.npy"), 0.5);
    let bodies = |section: &'static str, lines: String| {
        StudyText::new(1, &["surface", "material"])
            .with("material", "youngs_modulus = \"10 GPa\"\nhardness = \"1 GPa\"\nshear_strength = \"40 MPa\"")
            .with(section, &lines)
            .to_string()
    };
    let pressure = |points: usize, solves: usize, boundary: &str| {
        let lines = format!(
            "size = [\"100 um\", \"100 um\"]\npoints = [{points}, {points}]\npercentile = 50.0\nboundary = \"{boundary}\"\n\
             fine_solves = {solves}\n{METHODS}\nreference_samples = {}\nvariables = 8\ndegree = 2",
            10 * solves
        );
        bodies("pressure", lines)
    };
    let friction = |nx: usize, ny: usize, boundary: &str| {
        let lines = format!(
            "strip = [\"{} um\", \"{} um\"]\npoints = [{nx}, {ny}]\nwindow = \"100 um\"\nboundary = \"{boundary}\"\n\
             percentiles = [50.0]\nrealisations = 8",
            2 * nx,
            2 * ny
        );
        bodies("friction", lines)
    };
    let studies = [
        ("machine", MACHINE.clone()),
        ("pressure", pressure(32, 200, "periodic")),
        (
            "the default pressure",
            pressure(32, 400, "periodic").replace(METHODS, "").replace("reference_samples = 4000\n", ""),
        ),
        ("a large patch", pressure(128, 20, "free")),
        ("friction", friction(4096, 96, "periodic")),
        ("friction on free strips", friction(3072, 64, "free")),
    ];
    for (name, text) in studies {
        fs::write(at.join("study.toml"), text).unwrap();
        let estimate = run_in(at, "check study.toml --json --threads 2").json(0);
        let most = |stages: &serde_json::Value, key: &str| -> f64 {
            let values: Vec<&serde_json::Value> = match stages {
                serde_json::Value::Array(list) => list.iter().collect(),
                stages => stages.as_object().unwrap().values().collect(),
            };
            values.iter().map(|stage| stage[key].as_f64().unwrap()).fold(0.0, f64::max)
        };
        let estimated = most(&estimate["estimate"], "memory_bytes");
        assert_eq!(run_in(at, "run study.toml --out run --threads 2 --force").code, 0, "{name}");
        let provenance = json_of(&at.join("run/provenance.json"));
        // Where the system does not report it, there is nothing to compare.
        if provenance["stages"].as_object().unwrap().values().all(|stage| stage["peak_memory_bytes"].is_number()) {
            let measured = most(&provenance["stages"], "peak_memory_bytes");
            let ratio = estimated / measured;
            assert!((1.0..=1.5).contains(&ratio), "{name}: {estimated:e} for {measured:e} bytes, {ratio:.2}");
        }
        run_in(at, &format!("run study.toml --out no --max-memory {:.0}kB", 0.9e-3 * estimated))
            .refuses(5, &["needs about"]);
    }
}
