//! Tests of folders, figures and sound files of `asperity vibration`.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::{PAPER, asperity, close, listing, number, run_in, written};

const NOISE: &str = "--friction-std 0.001 --correlation-length 0.01 --marginal beta:2.1,5 --seed 3";
/// Period of the cycle at ζ = 0.17, from a high-precision solver.
const PERIOD: f64 = 6.372_163_483_739_709;

/// The named column of a table.
fn column(folder: &Path, table: &str, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(folder.join(format!("tables/{table}.csv"))).unwrap();
    let mut lines = text.lines();
    let place = lines.next().unwrap().split(',').position(|own| own == name).unwrap();
    lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap_or(f64::NAN)).collect()
}

#[test]
fn every_command_with_a_report_writes_answer_tables_and_figures() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let damping = "--damping-ratio 0.17";
    let mut warnings = 0;
    let over = "--over damping-ratio --from 0.2 --to 0.21 --points 5";
    for (line, tables, figures) in [
        (
            format!(
                "map {PAPER} {damping} {NOISE} --damping-ratios 0.1,0.3,2 --friction-stds 0.00001,0.00002,1 --depth 1 \
                 --trajectories 20 --duration 150"
            ),
            vec!["map_cells.csv", "map_contours.csv", "map_limit.csv", "map_points.csv"],
            vec!["stability_map"],
        ),
        (
            format!("bifurcation {PAPER} {damping} {over}"),
            vec!["bifurcation_down.csv", "bifurcation_marks.csv", "bifurcation_up.csv"],
            vec!["bifurcation"],
        ),
        (
            format!("critical-curve {PAPER} --over belt-velocity --from 0.003 --to 0.1"),
            vec!["critical_curve.csv"],
            vec!["critical_curve"],
        ),
        (
            format!("sound {PAPER} {damping} {NOISE} --trajectories 2 --duration 200"),
            vec!["sound_spectrum.csv"],
            vec!["sound_spectrum"],
        ),
        (
            format!("ensemble {PAPER} {damping} {NOISE} --trajectories 30 --duration 200"),
            vec!["limit_cycle.csv", "phase_cloud.csv", "reattachment.csv", "release.csv", "survival.csv"],
            vec!["phase_portrait", "reattachment", "survival"],
        ),
        (
            format!("basin {PAPER} --damping-ratio 0.20482"),
            vec!["basin.csv", "limit_cycle.csv", "separatrix.csv"],
            vec!["basin"],
        ),
        (
            "mode-coupling --static-friction 0.8 --stribeck 0 --belt-velocity 0.5 --dampers 0.02,0.02".to_owned(),
            vec!["mode_cycle.csv", "modes_over_friction.csv"],
            vec!["mode_cycle", "modes"],
        ),
    ] {
        let name = line.split(' ').next().unwrap();
        let found = run_in(at, &format!("vibration {line} --report new/{name} --json"));
        let json = found.json(0);
        let report = at.join("new").join(name);
        assert_eq!(written(&report), ["answer.json", "figures", "report.html", "tables"], "{name}");
        assert_eq!(listing(&report.join("tables")), tables, "{name}");
        // Two portraits side by side are too wide for one column.
        let widths = |figure: &str| if figure == "mode_cycle" { vec![""] } else { vec!["", "_one_column"] };
        let files =
            figures.iter().flat_map(|figure| widths(figure).into_iter().map(move |w| format!("{figure}{w}.svg")));
        assert_eq!(listing(&report.join("figures")), files.collect::<Vec<_>>(), "{name}");
        let answer: Value = serde_json::from_slice(&fs::read(report.join("answer.json")).unwrap()).unwrap();
        assert_eq!(answer, json, "{name}");
        let page = fs::read_to_string(report.join("report.html")).unwrap();
        for warning in json["warnings"].as_array().unwrap() {
            assert!(page.contains(warning.as_str().unwrap()), "{name}: {warning}");
            warnings += 1;
        }
        // A folder with files stays unless `--force` is given.
        run_in(at, &format!("vibration {line} --report new/{name} --json")).refuses(2, &["not empty"]);
        let again = run_in(at, &format!("vibration {line} --report new/{name} --force --threads 1 --json"));
        assert_eq!(again.json(0), json, "{name}");
        run_in(at, &format!("vibration {line} --force")).refuses(2, &["--report"]);
    }
    assert!(warnings > 0, "the map does not resolve its transition");
    assert_eq!(listing(at), ["new"]);
}

#[test]
fn tables_agree_with_the_answer() {
    let folder = TempDir::new().unwrap();
    let line = format!("vibration basin {PAPER} --damping-ratio 0.20482 --report basin --json");
    let json = run_in(folder.path(), &line).json(0);
    let basin = folder.path().join("basin");
    let attractors = column(&basin, "basin", "attractor");
    assert_eq!(attractors.len(), 200 * 200);
    let sliding = attractors.iter().filter(|a| **a == 0.0).count() as f64 / attractors.len() as f64;
    assert_eq!(sliding, number(&json, "sliding_share"));
    assert_eq!(json["separatrix"], "unstable_cycle");
    // The area inside the separatrix equals that of the cells that end in sliding, except for cells at its border.
    let [x, y] =
        ["displacements", "velocities"].map(|key| json[key][1].as_f64().unwrap() - json[key][0].as_f64().unwrap());
    close(number(&json, "separatrix_area"), sliding * x * y, 0.01);
    let line =
        format!("vibration ensemble {PAPER} --damping-ratio 0.17 {NOISE} --trajectories 3 --duration 5 --report e");
    assert_eq!(run_in(folder.path(), &line).code, 0);
    let cloud = folder.path().join("e");
    let trajectory = column(&cloud, "phase_cloud", "trajectory");
    assert_eq!(trajectory.iter().filter(|t| **t == 2.0).count() * 3, trajectory.len());
    let belt = column(&cloud, "phase_cloud", "velocity").into_iter().fold(f64::NEG_INFINITY, f64::max);
    close(belt, 0.003, 1e-12);
}

#[test]
fn a_basin_without_a_cycle_needs_its_box() {
    let line = format!("vibration basin {PAPER} --damping-ratio 0.3 --json");
    asperity(&line).refuses(2, &["--displacements", "--velocities"]);
    let boxed = format!("{line} --displacements 0.09,0.11,20 --velocities -0.01,0.01,10");
    let json = asperity(&boxed).json(0);
    assert_eq!((number(&json, "sliding_share"), json["attractors"].as_array().unwrap().len()), (1.0, 200));
    assert_eq!((&json["separatrix"], &json["separatrix_area"]), (&Value::Null, &Value::Null));
    asperity(&format!("{line} --displacements 0.09,0.11")).refuses(2, &["--displacements", "FROM,TO,N"]);
    asperity(&format!("{line} --displacements 0.11,0.09,5 --velocities -1,1,5"))
        .refuses(2, &["--displacements", "above the first"]);
}

#[test]
fn flags_of_the_fluctuation_of_coupled_modes_require_each_other() {
    let base = "vibration mode-coupling --static-friction 0.9 --kinetic-friction 0.8 --stribeck 0 --belt-velocity 0.05 \
                --dampers 0.02,0.02 --json";
    asperity(&format!("{base} --friction-std 0.05")).refuses(2, &["--correlation-length", "--marginal", "--seed"]);
    asperity(&format!("{base} --seed 4")).refuses(2, &["--friction-std"]);
    asperity(&format!("{base} --marginal normal")).refuses(2, &["--friction-std"]);
    asperity(&format!("{base} --modal-damping 0.1,0.1")).refuses(2, &["cannot be used with"]);
    asperity(&format!("{base} --angles 30")).refuses(2, &["--angles", "two numbers"]);
    asperity(&base.replace("0.02,0.02", "-1,0")).refuses(2, &["tangential damping"]);
    let noise =
        "--friction-std 1e-9 --correlation-length 1 --marginal normal --trajectories 20 --duration 200 --seed 2";
    let json = asperity(&format!("{base} {noise}")).json(0);
    // With almost no fluctuation the growth rate is the mode's, and all trajectories vibrate.
    let growth = number(&json, "growth_1").max(number(&json, "growth_2"));
    close(number(&json, "growth_rate"), growth, 1e-12);
    close(number(&json, "growth_rate_mean"), growth, 1e-2);
    assert_eq!(number(&json, "sustained_share"), 1.0);
    let resting = base.replace("0.8 --stribeck", "0.5 --stribeck").replace("0.9", "0.5");
    asperity(&format!("{resting} {noise}")).refuses(2, &["--threshold"]);
    assert_eq!(asperity(&format!("{resting} {noise} --threshold 0.1")).json(0)["motion"], "steady");
}

#[test]
fn a_sound_file_has_the_cycle_s_peak_and_frequency() {
    let folder = TempDir::new().unwrap();
    let quiet = NOISE.replace("--friction-std 0.001", "--friction-std 1e-9");
    let base = format!("vibration sound {PAPER} --damping-ratio 0.17 {quiet} --trajectories 2 --duration 300 --json");
    let found = run_in(folder.path(), &format!("{base} --wav a.wav --natural-frequency 440Hz --seconds 1"));
    let cycle = number(&found.json(0), "cycle_period");
    close(cycle, PERIOD, 1e-12);
    let mut reader = hound::WavReader::open(folder.path().join("a.wav")).unwrap();
    let spec = reader.spec();
    assert_eq!((spec.channels, spec.sample_rate, spec.bits_per_sample), (1, 44_100, 16));
    let samples: Vec<f64> = reader.samples::<i16>().map(|sample| f64::from(sample.unwrap())).collect();
    assert_eq!(samples.len(), 44_100);
    let peak = samples.iter().fold(0.0_f64, |most, sample| sample.abs().max(most)) / f64::from(i16::MAX);
    close(20.0 * peak.log10(), -6.0, 2e-3);
    assert_eq!((samples[0], samples[44_099]), (0.0, 0.0));
    // A record of one second has frequency bins of 1 Hz.
    let power = |bin: usize| {
        let turn = TAU * bin as f64 / samples.len() as f64;
        let (cos, sin) = samples.iter().enumerate().fold((0.0, 0.0), |(cos, sin), (k, sample)| {
            let (s, c) = (turn * k as f64).sin_cos();
            (cos + sample * c, sin + sample * s)
        });
        cos * cos + sin * sin
    };
    // A subharmonic at half the frequency would be found, too.
    let loudest = (200..700).max_by(|a, b| power(*a).total_cmp(&power(*b))).unwrap();
    assert!((loudest as f64 - 440.0 * TAU / PERIOD).abs() <= 0.5, "{loudest} Hz");
    // An angular frequency is the same: ω₀ = 2π·440 Hz.
    let angular = format!("{base} --wav b.wav --natural-frequency 2764.601535159018rad/s --seconds 0.1");
    assert_eq!(run_in(folder.path(), &angular).code, 0);
    assert_eq!(hound::WavReader::open(folder.path().join("b.wav")).unwrap().duration(), 4410);
}

#[test]
fn sounds_beyond_the_limits_of_a_file_are_refused() {
    let folder = TempDir::new().unwrap();
    let base = format!("vibration sound {PAPER} --damping-ratio 0.17 {NOISE} --trajectories 2 --duration 200 --json");
    for (flags, words) in [
        ("--wav a.wav --natural-frequency 22.05kHz", ["half the sampling rate", "22050"]),
        ("--wav a.wav --natural-frequency 440Hz --seconds 1000", ["seconds", "600"]),
        ("--wav a.wav", ["--natural-frequency", "required"]),
        ("--natural-frequency 440Hz", ["--mass", "--normal-force"]),
        ("--wav a.wav --natural-frequency 440m", ["--natural-frequency", "440m"]),
        ("--wav gone/a.wav --natural-frequency 440Hz", ["--wav", "gone"]),
    ] {
        run_in(folder.path(), &format!("{base} {flags}")).refuses(2, &words);
    }
    assert!(listing(folder.path()).is_empty());
}
