//! Tests of `asperity contact`: clusters, energies, stiffness, theories, and rough or elastic counterfaces.

use std::f64::consts::{PI, SQRT_2};
use std::fs;

use crate::contact::{field, press, rough, wave};
use crate::support::{asperity_in, close, listing, npy, number, run_in};
use ndarray::{Array2, s};
use serde_json::Value;
use tempfile::TempDir;

fn folder_with(maps: &[(&str, Array2<f64>)]) -> TempDir {
    let folder = TempDir::new().unwrap();
    for (name, heights_m) in maps {
        npy(folder.path(), name, heights_m.clone());
    }
    folder
}

#[test]
fn a_pressed_wave_has_its_analytic_energy_stiffness_and_contact_fractions() {
    let folder = folder_with(&[("map.npy", wave())]);
    // Westergaard with s = p̄/p* = 1/4: ḡ/h = 1 − s + s ln s gives the stiffness −dp̄/dḡ and the energy ∫ p̄ d(−ḡ).
    let (h, full_pa, s) = (1e-6, PI * 1e9 * 1e-6 / 256e-6, 0.25_f64);
    let line = format!(
        "--youngs-modulus 1GPa --poisson-ratio 0 --boundary periodic --mean-pressure {}Pa --stiffness --json",
        s * full_pa
    );
    let json = press(folder.path(), &line).json(0);
    let area_m2 = 1024e-12;
    close(number(&json, "contact_stiffness_pa_per_m"), full_pa / (h * (1.0 / s).ln()), 0.02);
    let per_area = number(&json, "contact_stiffness_n_per_m") / area_m2;
    close(per_area, number(&json, "contact_stiffness_pa_per_m"), 1e-12);
    let energy_j = full_pa * h * (s * s / 4.0 - s * s / 2.0 * s.ln()) * area_m2;
    close(number(&json, "elastic_energy_j"), energy_j, 0.01);
    assert_eq!(number(&json, "plastic_work_j"), 0.0);
    assert_eq!(number(&json, "contact_modulus_pa"), 1e9);
    // Forward differences miss 2.5e-5 of the gradient √2πh/λ.
    close(number(&json, "rms_gradient"), SQRT_2 * PI / 256.0, 1e-4);
    // √2 p̄/(E* h'rms) = 1/4.
    close(number(&json, "persson_contact_fraction"), 0.276_326_390_168, 1e-4);
    assert_eq!(number(&json, "persson_plastic_fraction"), 0.0);
    close(number(&json, "bgt_contact_fraction"), PI.sqrt() / 4.0, 1e-4);
    // The crest lies on the border, and the ridge continues around the map.
    assert_eq!(json["clusters"], Value::from(1));
    assert_eq!(number(&json, "largest_cluster_fraction"), 1.0);
    close(number(&json, "largest_cluster_m2"), number(&json, "contact_fraction") * area_m2, 1e-12);
    let free = line.replace("periodic", "free");
    assert_eq!(press(folder.path(), &free).json(0)["clusters"], Value::from(2));
    let table = press(folder.path(), &line.replace("--json", "")).stdout;
    for words in ["contact stiffness", "N/m", "elastic energy", "contact fraction (Persson)", "m²"] {
        assert!(table.contains(words), "`{words}` is missing: {table}");
    }
    // Complete contact is infinitely stiff.
    let line = line.replace(&format!("{}Pa", s * full_pa), "1GPa");
    let json = press(folder.path(), &line).json(0);
    assert_eq!((number(&json, "contact_fraction"), &json["contact_stiffness_n_per_m"]), (1.0, &Value::Null));
}

#[test]
fn the_gradient_of_a_free_map_is_its_sdq() {
    let folder = folder_with(&[("map.npy", rough())]);
    let json = press(folder.path(), "--youngs-modulus 210GPa --boundary free --percentile 20 --json").json(0);
    let line = ["surface", "stats", "map.npy", "--pixel-size", "1um", "--level", "none", "--json"];
    close(number(&json, "rms_gradient"), number(&asperity_in(folder.path(), &line).json(0), "Sdq"), 1e-12);
}

#[test]
fn the_archive_numbers_the_clusters() {
    let folder = folder_with(&[("map.npy", rough())]);
    let line = "--youngs-modulus 210GPa --boundary free --percentile 20 --hardness 2GPa --out fields.npz --json";
    let json = press(folder.path(), line).json(0);
    let (pressure_pa, clusters) = (field(folder.path(), "pressure_pa"), field(folder.path(), "clusters"));
    assert!(pressure_pa.iter().zip(&clusters).all(|(p, label)| (*p > 0.0) == (*label > 0.0)));
    assert_eq!(clusters.iter().copied().fold(0.0, f64::max), number(&json, "clusters"));
    assert!(number(&json, "clusters") > 1.0 && number(&json, "plastic_work_j") > 0.0);
    assert!(number(&json, "persson_plastic_fraction") > 0.0);
}

#[test]
fn exchanging_surface_and_counterface_changes_nothing() {
    let whole = rough();
    let folder = folder_with(&[
        ("map.npy", whole.clone()),
        ("part.npy", &whole * 0.4),
        ("rest_laid.npy", &whole * 0.6),
        ("rest.npy", (&whole * 0.6).slice(s![.., ..;-1]).to_owned()),
        ("flat.npy", Array2::zeros((24, 32))),
    ]);
    let run = |file: &str, line: &str| {
        let line = format!("contact {file} --pixel-size 1um --boundary free --percentile 20 --stiffness --json {line}");
        run_in(folder.path(), &line).json(0)
    };
    let single = run("map.npy", "--youngs-modulus 210GPa");
    for (file, line) in [
        // Twice as stiff on both sides.
        ("map.npy", "--youngs-modulus 420GPa --counterface-youngs-modulus 420GPa"),
        // Two moduli E/(1−ν²) that give 1/3 and 2/3 of the compliance.
        (
            "map.npy",
            "--youngs-modulus 315GPa --counterface-youngs-modulus 519.2307692307692GPa --counterface-poisson-ratio 0.5",
        ),
        ("part.npy", "--youngs-modulus 210GPa --counterface rest.npy"),
        ("part.npy", "--youngs-modulus 210GPa --counterface rest_laid.npy --counterface-as-laid"),
        (
            "flat.npy",
            "--youngs-modulus 420GPa --counterface map.npy --counterface-as-laid --counterface-youngs-modulus 420GPa",
        ),
    ] {
        let pair = run(file, line);
        for key in
            ["contact_modulus_pa", "mean_pressure_pa", "penetration_m", "contact_stiffness_n_per_m", "rms_gradient"]
        {
            close(number(&pair, key), number(&single, key), 1e-6);
        }
    }
    let turned = run("part.npy", "--youngs-modulus 210GPa --counterface rest_laid.npy");
    assert!((number(&turned, "penetration_m") / number(&single, "penetration_m") - 1.0).abs() > 0.01);
}

#[test]
fn an_unsuitable_counterface_is_refused() {
    let mut holed = rough();
    holed[[3, 4]] = f64::NAN;
    let cast = rough().slice(s![.., ..;-1]).mapv(|z| -z);
    let folder = folder_with(&[
        ("map.npy", rough()),
        ("cast.npy", cast),
        ("holed.npy", holed),
        ("small.npy", Array2::from_shape_fn((8, 8), |(row, column)| 1e-7 * (row * column) as f64)),
    ]);
    fs::write(folder.path().join("note.txt"), "no heights").unwrap();
    let base = "--youngs-modulus 210GPa --boundary free --percentile 20 --json";
    for (line, code, words) in [
        ("--counterface small.npy", 3, vec!["small.npy", "32 × 24", "8 × 8", "1e-6 m"]),
        ("--counterface holed.npy", 3, vec!["holed.npy", "1 of 768"]),
        ("--counterface cast.npy", 3, vec!["cast.npy on map.npy", "no roughness"]),
        ("--counterface nowhere.npy", 3, vec!["nowhere.npy"]),
        ("--counterface note.txt", 3, vec!["note.txt"]),
        ("--counterface-as-laid", 2, vec!["--counterface <FILE>"]),
        ("--counterface-poisson-ratio 0.3", 2, vec!["--counterface-youngs-modulus"]),
        ("--counterface-youngs-modulus 0GPa", 2, vec!["--counterface-youngs-modulus", "above 0"]),
        ("--counterface cast.npy --out cast.npy", 2, vec!["--out", "is an input"]),
    ] {
        press(folder.path(), &format!("{base} {line}")).refuses(code, &words);
    }
    assert_eq!(listing(folder.path()), ["cast.npy", "holed.npy", "map.npy", "note.txt", "small.npy"]);
}
