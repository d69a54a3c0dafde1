//! Instrument files of other projects, where the folder with them is present.

use std::path::PathBuf;

use asperity_formats::{Scan, read};
use serde_json::Value;

/// The folder that `ASPERITY_REFERENCE` names.
fn surfaces() -> Option<PathBuf> {
    std::env::var_os("ASPERITY_REFERENCE").map(|folder| PathBuf::from(folder).join("surfaces"))
}

fn present(scan: &Scan) -> Vec<f64> {
    scan.heights_m.iter().copied().filter(|z| !z.is_nan()).collect()
}

fn assert_close(found: f64, wanted: &Value, relative: f64, what: &str) {
    let wanted = wanted.as_f64().unwrap();
    assert!((found / wanted - 1.0).abs() < relative, "{what}: {found:e}, wanted {wanted:e}");
}

#[test]
fn instrument_files_have_their_published_shape_pitch_voids_and_heights() {
    let Some(folder) = surfaces() else { return };
    let text = std::fs::read_to_string(folder.join("reference.json")).unwrap();
    let reference: serde_json::Map<String, Value> = serde_json::from_str(&text).unwrap();
    let mut compared = 0;
    for (name, wanted) in reference.iter().filter(|(name, _)| name.ends_with(".x3p") || name.ends_with(".sur")) {
        let scan = read(&folder.join(name)).unwrap();
        let shape = [wanted["ny"].as_u64(), wanted["nx"].as_u64()].map(|n| n.unwrap() as usize);
        assert_eq!(scan.heights_m.shape(), shape, "{name}");
        assert_eq!(scan.missing_points() as u64, wanted["n_missing"].as_u64().unwrap(), "{name}");
        let (dx_m, dy_m) = scan.pitch_m.unwrap();
        let heights_m = present(&scan);
        let raw = &wanted["raw"];
        // Sums of up to 4e5 doubles of one size: 1e-12 is 5000 units in the last place.
        assert_close(dx_m, &wanted["dx_m"], 1e-12, name);
        assert_close(dy_m, &wanted["dy_m"], 1e-12, name);
        assert_close(heights_m.iter().copied().fold(f64::INFINITY, f64::min), &raw["min_m"], 1e-12, name);
        assert_close(heights_m.iter().copied().fold(f64::NEG_INFINITY, f64::max), &raw["max_m"], 1e-12, name);
        let mean_m = heights_m.iter().sum::<f64>() / heights_m.len() as f64;
        let scale_m = raw["rms_about_mean_m"].as_f64().unwrap();
        let wanted_mean_m = raw["mean_m"].as_f64().unwrap();
        assert!((mean_m - wanted_mean_m).abs() < 1e-10 * scale_m.max(wanted_mean_m.abs()), "{name}: {mean_m:e}");
        compared += 1;
    }
    assert_eq!(compared, 4);
}

#[test]
fn checksums_of_other_writers_fit() {
    let Some(folder) = surfaces() else { return };
    for name in
        ["st_x3p-2.x3p", "x3ptools_sample-land.x3p", "openfmc_ISO5436-sample4.x3p", "openfmc_ISO5436-sample4_bin.x3p"]
    {
        let warnings = read(&folder.join(name)).unwrap().warnings;
        assert!(!warnings.iter().any(|warning| warning.contains("MD5")), "{name}: {warnings:?}");
    }
}

#[test]
fn the_text_and_the_binary_form_of_one_sample_are_equal() {
    let Some(folder) = surfaces() else { return };
    let text = read(&folder.join("openfmc_ISO5436-sample4.x3p")).unwrap();
    let binary = read(&folder.join("openfmc_ISO5436-sample4_bin.x3p")).unwrap();
    assert_eq!(crate::bits(&text), crate::bits(&binary));
    assert_eq!(text.pitch_m, binary.pitch_m);
}

#[test]
fn formats_that_are_not_read_are_refused() {
    let Some(folder) = surfaces() else { return };
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let is_read = path.extension().is_some_and(|extension| extension == "x3p" || extension == "sur");
        assert_eq!(read(&path).is_ok(), is_read, "{}", path.display());
    }
}
