//! Tests of `asperity contact`: keys, exit codes, reference numbers and output files.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::Path;
#[cfg(target_os = "linux")]
use std::time::Duration;

#[cfg(target_os = "linux")]
use crate::support::run_and_interrupt;
use crate::support::{Finished, close, listing, npy, number, run_in};
use asperity_formats::{read_npz, write_vtk_fields};
use ndarray::Array2;
use serde_json::Value;
use tempfile::TempDir;

/// One wave of 1 µm amplitude over 256 points of 1 µm along x.
pub(crate) fn wave() -> Array2<f64> {
    Array2::from_shape_fn((4, 256), |(_, column)| 1e-6 * (TAU * (column as f64 + 0.5) / 256.0).cos())
}

/// A bowl plus a sum of waves, different in both directions.
pub(crate) fn rough() -> Array2<f64> {
    Array2::from_shape_fn((24, 32), |(row, column)| {
        let (x, y) = (column as f64 / 32.0, row as f64 / 24.0);
        1e-7 * ((TAU * x).sin() + (2.0 * TAU * y).cos() + 0.7 * (3.0 * TAU * (x + y)).sin())
    })
}

fn folder_with(heights_m: Array2<f64>) -> TempDir {
    let folder = TempDir::new().unwrap();
    npy(folder.path(), "map.npy", heights_m);
    folder
}

pub(crate) fn press(folder: &Path, line: &str) -> Finished {
    let line = format!("contact map.npy --pixel-size 1um {line}");
    run_in(folder, &line)
}

#[test]
fn a_quarter_of_the_full_contact_pressure_flattens_a_third_of_a_wave() {
    let folder = folder_with(wave());
    // ν = 0 makes E* = E = 1 GPa; p* = πE*h/λ; Westergaard: p̄/p* = sin²(πa/λ).
    let mean_pressure_pa = 0.25 * PI * 1e9 * 1e-6 / 256e-6;
    let line = format!(
        "--youngs-modulus 1GPa --poisson-ratio 0 --boundary periodic --mean-pressure {mean_pressure_pa}Pa --json"
    );
    let json = press(folder.path(), &line).json(0);
    close(number(&json, "mean_pressure_pa"), mean_pressure_pa, 1e-7);
    close(number(&json, "load_n"), mean_pressure_pa * 4.0 * 256.0 * 1e-12, 1e-7);
    // Two edges, each located to one cell; the pressure maximum 2√(p̄p*) and the gap are correct to first order in
    // 1/256.
    assert!((number(&json, "contact_fraction") - 1.0 / 3.0).abs() <= 2.0 / 256.0);
    close(number(&json, "max_pressure_pa"), 4.0 * mean_pressure_pa, 0.01);
    close(number(&json, "mean_gap_m"), 0.403_426_409_7e-6, 0.01);
    // Displacements have mean zero under a prescribed load, so the separation is the mean gap.
    assert_eq!(number(&json, "mean_compliance_m_per_pa"), 0.0);
    close(number(&json, "separation_m"), number(&json, "mean_gap_m"), 1e-9);
    assert_eq!(json["converged"], Value::Bool(true));
    assert!(number(&json, "residual") <= 1e-8);
    assert_eq!(number(&json, "plastic_fraction"), 0.0);
}

#[test]
fn all_controls_give_the_same_solution() {
    let folder = folder_with(rough());
    let base = "--youngs-modulus 210GPa --boundary free --tolerance 1e-10 --json";
    let first = press(folder.path(), &format!("{base} --percentile 30")).json(0);
    assert_eq!(first["mean_compliance_m_per_pa"], Value::Null);
    for (control, key, unit) in [
        ("--penetration", "penetration_m", "m"),
        ("--mean-pressure", "mean_pressure_pa", "Pa"),
        ("--load", "load_n", "N"),
        ("--mean-gap", "mean_gap_m", "m"),
    ] {
        let value = number(&first, key);
        let again = press(folder.path(), &format!("{base} {control} {value:e}{unit}")).json(0);
        for key in ["mean_pressure_pa", "penetration_m", "mean_gap_m", "max_pressure_pa"] {
            close(number(&again, key), number(&first, key), 1e-6);
        }
    }
}

/// Returns a field of the archive `fields.npz`.
pub(crate) fn field(folder: &Path, name: &str) -> Array2<f64> {
    read_npz(&fs::read(folder.join("fields.npz")).unwrap(), name).unwrap()
}

#[test]
fn the_archive_contains_the_fields_of_the_answer_and_replaces_the_old_file() {
    let folder = folder_with(rough());
    fs::write(folder.path().join("fields.npz"), "old").unwrap();
    let line = "--youngs-modulus 210GPa --boundary free --percentile 50 --hardness 2GPa --out fields.npz --json";
    let json = press(folder.path(), line).json(0);
    assert_eq!(listing(folder.path()), ["fields.npz", "map.npy"]);
    let field = |name: &str| field(folder.path(), name);
    let (pressure_pa, gap_m) = (field("pressure_pa"), field("gap_m"));
    let (displacement_m, plastic_m) = (field("displacement_m"), field("plastic_displacement_m"));
    assert_eq!(pressure_pa.dim(), (24, 32));
    close(pressure_pa.mean().unwrap(), number(&json, "mean_pressure_pa"), 1e-12);
    close(gap_m.mean().unwrap(), number(&json, "mean_gap_m"), 1e-12);
    // g = u + u_pl − z + plane, up to the residual; the plane lies at mean z + separation.
    let heights = rough();
    let plane_m = heights.mean().unwrap() + number(&json, "separation_m");
    for ((index, z), gap) in heights.indexed_iter().zip(&gap_m) {
        let closed = displacement_m[index] + plastic_m[index] - z + plane_m;
        assert!((closed - gap).abs() < 1e-6 * 1e-7, "{closed} is not {gap} at {index:?}");
        assert!(plastic_m[index] == 0.0 || pressure_pa[index] == 2e9);
    }
    let plastic = pressure_pa.iter().filter(|p| **p == 2e9).count() as f64 / (24.0 * 32.0);
    assert!(plastic > 0.0);
    close(plastic, number(&json, "plastic_fraction"), 1e-12);
}

#[test]
fn a_name_that_ends_in_vti_gives_an_image_with_the_fields_of_the_archive() {
    let folder = folder_with(rough());
    for name in ["fields.npz", "fields.VTI"] {
        let line =
            format!("--youngs-modulus 210GPa --boundary free --percentile 50 --hardness 2GPa --unload --out {name}");
        assert_eq!(press(folder.path(), &line).code, 0);
    }
    let names = ["pressure_pa", "displacement_m", "gap_m", "plastic_displacement_m", "clusters", "residual_height_m"];
    let fields = names.map(|name| field(folder.path(), name));
    let named: Vec<(&str, &Array2<f64>)> = names.into_iter().zip(&fields).collect();
    let image = fs::read(folder.path().join("fields.VTI")).unwrap();
    assert!(image == write_vtk_fields((1e-6, 1e-6), &named).unwrap());
}

#[test]
fn unloading_gives_the_heights_minus_the_plastic_displacement() {
    let folder = folder_with(rough());
    let line = "--youngs-modulus 210GPa --boundary free --percentile 50 --hardness 2GPa --json";
    let plain = press(folder.path(), line).json(0);
    let json = press(folder.path(), &format!("{line} --unload --out fields.npz")).json(0);
    for (key, value) in plain.as_object().unwrap() {
        assert_eq!(&json[key], value, "{key}");
    }
    let field = |name: &str| field(folder.path(), name);
    let (plastic_m, residual_m) = (field("plastic_displacement_m"), field("residual_height_m"));
    assert!(residual_m.iter().zip(&(rough() - &plastic_m)).all(|(a, b)| (a - b).abs() < 1e-20));
    // Every plastic cell of 1 µm² carries the hardness.
    close(number(&json, "plastic_work_j"), 2e9 * 1e-12 * plastic_m.sum(), 1e-12);
    close(number(&json, "max_plastic_displacement_m"), plastic_m.iter().copied().fold(0.0, f64::max), 1e-12);
    close(number(&json, "residual_rms_height_m"), residual_m.std(0.0), 1e-9);
    let (low, high) = residual_m.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(*z), h.max(*z)));
    close(number(&json, "residual_peak_to_valley_m"), high - low, 1e-12);
    // Without convergence the results are undefined.
    let line =
        "--youngs-modulus 210GPa --boundary free --percentile 50 --hardness 2GPa --tolerance 1e-30 --unload --json";
    let json = press(folder.path(), line).json(4);
    assert!(json["max_plastic_displacement_m"].is_null() && json["residual_rms_height_m"].is_null());
}

#[test]
fn the_flags_define_the_layer() {
    let folder = folder_with(wave());
    let base = "--youngs-modulus 1GPa --poisson-ratio 0.25 --boundary periodic --json";
    let run = |line: &str| press(folder.path(), &format!("{base} {line}")).json(0);
    let same = |one: &Value, other: &Value| {
        for key in ["contact_fraction", "max_pressure_pa", "mean_gap_m", "separation_m", "mean_compliance_m_per_pa"] {
            close(number(one, key), number(other, key), 1e-7);
        }
    };
    // A layer on a base of its own material is a half-space.
    let plain = run("--percentile 20");
    same(&run("--percentile 20 --layer-thickness 10um --base-youngs-modulus 1GPa --base-poisson-ratio 0.25"), &plain);
    // The mean compliance of a bonded layer is h(1+ν)(1−2ν)/((1−ν)E).
    let rigid = run("--percentile 20 --layer-thickness 10um --rigid-base");
    close(number(&rigid, "mean_compliance_m_per_pa"), 1e-5 * 1.25 * 0.5 / (0.75 * 1e9), 1e-12);
    // The default is the compliance of the longest wave, max(L)/(πE*).
    close(number(&plain, "mean_compliance_m_per_pa"), 256e-6 * (1.0 - 0.25 * 0.25) / (PI * 1e9), 1e-12);
    for (line, words) in [
        ("--percentile 20 --layer-thickness 10um", vec!["--rigid-base", "--base-youngs-modulus"]),
        ("--percentile 20 --rigid-base", vec!["--layer-thickness"]),
        ("--percentile 20 --base-youngs-modulus 1GPa", vec!["--layer-thickness"]),
        ("--percentile 20 --layer-thickness 1um --rigid-base --base-poisson-ratio 0.2", vec!["cannot be used with"]),
        ("--percentile 20 --layer-thickness 1um --base-poisson-ratio 0.2", vec!["--base-youngs-modulus"]),
        ("--percentile 20 --layer-thickness 1um --rigid-base --base-youngs-modulus 1GPa", vec!["cannot be used with"]),
        ("--percentile 20 --layer-thickness 0um --rigid-base", vec!["--layer-thickness", "above 0"]),
        ("--percentile 20 --layer-thickness 10um --rigid-base --mean-compliance 1um/MPa", vec!["--mean-compliance"]),
        ("--percentile 20 --unload", vec!["--hardness"]),
    ] {
        press(folder.path(), &format!("{base} {line}")).refuses(2, &words);
    }
    // A layer thinner than the span of the heights cannot have one thickness.
    let doubtful = press(folder.path(), &format!("{base} --percentile 20 --layer-thickness 1um --rigid-base"));
    assert!(
        doubtful.code == 0
            && doubtful.stderr.contains("the heights span 2.0e-6 m, more than the layer's thickness 1 um"),
        "{doubtful:?}"
    );
}

#[test]
fn equal_commands_give_equal_bytes_for_any_number_of_threads() {
    let folder = folder_with(rough());
    let run = |threads: &str, out: &str| {
        let line = format!(
            "--threads {threads} --youngs-modulus 210GPa --boundary periodic --percentile 20 --hardness 9GPa --stiffness \
             --out {out} --json"
        );
        (press(folder.path(), &line).stdout, fs::read(folder.path().join(out)).unwrap())
    };
    assert_eq!(run("1", "a.npz"), run("2", "b.npz"));
}

#[test]
fn an_unreachable_tolerance_gives_converged_false_in_json() {
    let folder = folder_with(rough());
    let found =
        press(folder.path(), "--youngs-modulus 210GPa --boundary free --percentile 50 --tolerance 1e-30 --json");
    let json = found.json(4);
    assert_eq!(json["converged"], Value::Bool(false));
    assert!(number(&json, "residual") > 1e-30);
    assert!(found.stderr.contains("not converged") && found.stderr.contains("1.0e-30"), "{found:?}");
}

#[test]
fn values_out_of_range_are_usage_errors_that_name_the_flag() {
    let folder = folder_with(rough());
    let base = "--youngs-modulus 210GPa --boundary free";
    for (line, words) in [
        (format!("{base} --penetration -1um"), vec!["--penetration", "must not be negative"]),
        (format!("{base} --percentile 101"), vec!["--percentile", "101"]),
        (format!("{base} --percentile nan"), vec!["--percentile"]),
        (format!("{base} --mean-pressure 20"), vec!["--mean-pressure", "no unit"]),
        (format!("{base} --mean-pressure 1e308Pa"), vec!["--mean-pressure", "at most 1e30"]),
        (format!("{base} --mean-pressure 20um"), vec!["--mean-pressure", "`um` is not a unit of pressure"]),
        (format!("{base} --load 0N"), vec!["--load", "above 0"]),
        (format!("{base} --mean-gap 0um"), vec!["--mean-gap", "above 0"]),
        (format!("{base} --percentile 5 --hardness 0Pa"), vec!["--hardness"]),
        (format!("{base} --percentile 5 --tolerance 0"), vec!["--tolerance"]),
        (format!("{base} --percentile 5 --tolerance 1"), vec!["--tolerance", "below 1"]),
        (format!("{base} --percentile 5 --poisson-ratio 0.6"), vec!["--poisson-ratio", "0.5"]),
        (format!("{base} --percentile 5 --mean-compliance 1e-15m/Pa"), vec!["--mean-compliance", "periodic"]),
        (format!("{base} --percentile 5 --load 1N"), vec!["cannot be used with"]),
        (base.to_owned(), vec!["--penetration", "--percentile", "--mean-pressure", "--load", "--mean-gap"]),
        ("--youngs-modulus -1GPa --boundary free --percentile 5".into(), vec!["--youngs-modulus"]),
        ("--youngs-modulus 1GPa --boundary fre --percentile 5".into(), vec!["--boundary", "free", "periodic"]),
        ("--boundary free --percentile 5".into(), vec!["--youngs-modulus"]),
        ("--youngs-modulu 1GPa --boundary free --percentile 5".into(), vec!["--youngs-modulus"]),
        (
            "--youngs-modulus 1GPa --boundary periodic --percentile 5 --mean-compliance 0m/Pa".into(),
            vec!["mean compliance"],
        ),
        (format!("{base} --mean-pressure 3GPa --hardness 2GPa"), vec!["hardness"]),
        (format!("{base} --percentile 5 --out nowhere/f.npz"), vec!["--out", "nowhere"]),
        (format!("{base} --percentile 5 --out ."), vec!["--out", "folder"]),
        #[cfg(unix)]
        (format!("{base} --percentile 5 --out /dev/null"), vec!["--out", "no regular file"]),
    ] {
        press(folder.path(), &format!("{line} --json")).refuses(2, &words);
    }
    assert_eq!(listing(folder.path()), ["map.npy"]);
}

#[test]
fn a_map_that_cannot_be_pressed_is_unusable_data() {
    let mut holed = rough();
    holed[[3, 4]] = f64::NAN;
    for (heights_m, words) in [
        (holed, vec!["map.npy", "1 of 768", "complete"]),
        (Array2::from_elem((8, 8), 2e-6), vec!["map.npy", "no roughness"]),
        (Array2::from_elem((1, 1), 0.0), vec!["map.npy", "1 × 1"]),
        (Array2::from_elem((4, 4), f64::NAN), vec!["map.npy", "all 16"]),
    ] {
        let folder = folder_with(heights_m);
        press(folder.path(), "--youngs-modulus 210GPa --boundary free --percentile 50 --out f.npz --json")
            .refuses(3, &words);
        assert_eq!(listing(folder.path()), ["map.npy"]);
    }
}

/// `rough` on a plane of ten times its height: 0.2 µm over 1 µm of x, 2 % of slope.
fn tilted() -> Array2<f64> {
    Array2::from_shape_fn((24, 32), |(row, column)| rough()[[row, column]] + 2e-8 * column as f64 + 1e-8 * row as f64)
}

#[test]
fn a_form_larger_than_the_roughness_gives_a_warning_and_level_removes_it() {
    let line = "--youngs-modulus 210GPa --boundary free --mean-pressure 50MPa --json";
    let folder = folder_with(tilted());
    let found = press(folder.path(), line);
    let json = found.json(0);
    let warning = json["warnings"][0].as_str().unwrap();
    // The plane over a grid of n points at distance s has the variance s² (n² − 1)/12 along each axis. The waves add
    // little to it.
    let plane = 1e-8 * (4.0 * (32.0 * 32.0 - 1.0) / 12.0 + (24.0 * 24.0 - 1.0) / 12.0_f64).sqrt();
    let shown = format!("{:.0}", plane * 1e9);
    assert!(
        warning.starts_with("map.npy: the form (plane) has an rms height of") && warning.contains("--level plane"),
        "{warning}"
    );
    assert!(warning.contains(&shown[..1]) && found.stderr.contains(warning), "{warning}: {shown} nm");
    // A levelled tilted map gives the same result as the map without tilt.
    let levelled = press(folder.path(), &format!("{line} --level plane")).json(0);
    assert_eq!(levelled["warnings"], Value::Array(vec![]));
    let level = folder_with(rough());
    let wanted = press(level.path(), &format!("{line} --level plane")).json(0);
    for key in ["contact_fraction", "max_pressure_pa", "mean_gap_m", "penetration_m"] {
        close(number(&levelled, key), number(&wanted, key), 1e-6);
    }
    assert!(number(&json, "mean_gap_m") > 2.0 * number(&levelled, "mean_gap_m"));
    // No warning if the user states that nothing is removed, or if the map is level.
    assert_eq!(press(folder.path(), &format!("{line} --level none")).json(0)["warnings"], Value::Array(vec![]));
    assert_eq!(press(level.path(), line).json(0)["warnings"], Value::Array(vec![]));
    press(level.path(), &format!("{line} --level cubic")).refuses(2, &["--level", "cubic", "quadratic"]);
}

#[test]
fn a_tilted_counterface_is_levelled_and_warned_about_like_the_surface() {
    let folder = folder_with(rough());
    npy(folder.path(), "upper.npy", tilted());
    let line = "--youngs-modulus 210GPa --boundary free --mean-pressure 50MPa --json --counterface upper.npy";
    let json = press(folder.path(), line).json(0);
    assert!(json["warnings"][0].as_str().unwrap().starts_with("upper.npy: the form (plane)"), "{json}");
    let levelled = press(folder.path(), &format!("{line} --level plane")).json(0);
    assert!(number(&levelled, "mean_gap_m") < number(&json, "mean_gap_m"));
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_solution_stops_immediately_and_leaves_the_old_file() {
    // The problem takes far more than a minute.
    let folder = folder_with(Array2::from_shape_fn((2048, 2048), |(row, column)| {
        let (x, y) = (column as f64, row as f64);
        1e-6 * ((0.011 * x + 0.002 * y).sin() + (0.017 * y - 0.003 * x).cos() + 0.1 * (0.9 * x).sin() * (1.1 * y).sin())
    }));
    fs::write(folder.path().join("f.npz"), "old").unwrap();
    let line = "contact map.npy --pixel-size 1um --youngs-modulus 210GPa --boundary free --percentile 60 \
                --tolerance 1e-13 --out f.npz --json";
    let (found, took) = run_and_interrupt(folder.path(), line);
    found.refuses(130, &["cancelled"]);
    assert!(took < Duration::from_secs(5), "{took:?}");
    assert_eq!(fs::read_to_string(folder.path().join("f.npz")).unwrap(), "old");
    assert_eq!(listing(folder.path()), ["f.npz", "map.npy"]);
}

#[test]
fn an_implausible_material_is_warned_about_and_a_load_beyond_the_hardness_is_refused() {
    let folder = folder_with(rough());
    let line = "--youngs-modulus 10GPa --hardness 2GPa --boundary periodic --mean-pressure";
    let soft = press(folder.path(), &format!("{line} 10MPa"));
    assert_eq!(soft.code, 0, "{soft:?}");
    assert!(
        soft.stderr.contains("warning: Young's modulus 10 GPa is less than ten times the hardness 2 GPa"),
        "{soft:?}"
    );
    press(folder.path(), &format!("{line} 3GPa")).refuses(2, &["hardness"]);
}
