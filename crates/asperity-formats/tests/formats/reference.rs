//! Instrument files of other projects, where the folder with them is present.

use std::path::PathBuf;

use asperity_formats::{Scan, read};
use serde_json::Value;

/// Returns the folder in `ASPERITY_REFERENCE`.
#[expect(clippy::print_stdout, reason = "a skipped test says so")]
fn surfaces() -> Option<PathBuf> {
    let folder = std::env::var_os("ASPERITY_REFERENCE");
    if folder.is_none() {
        println!("skipped: ASPERITY_REFERENCE names no folder");
    }
    folder.map(|folder| PathBuf::from(folder).join("surfaces"))
}

/// Residuals of the least-squares plane through the present heights.
///
/// The normal equations in coordinates about their mean and in units of their range: well conditioned for any map.
fn without_plane(scan: &Scan) -> Vec<f64> {
    let (ny, nx) = scan.heights_m.dim();
    let points: Vec<[f64; 3]> = scan
        .heights_m
        .indexed_iter()
        .filter(|(_, z)| !z.is_nan())
        .map(|((row, column), &z)| [column as f64 / nx as f64, row as f64 / ny as f64, z])
        .collect();
    let count = points.len() as f64;
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / count;
    let (mx, my, mz) = (mean(0), mean(1), mean(2));
    let sum = |f: &dyn Fn(f64, f64, f64) -> f64| points.iter().map(|&[x, y, z]| f(x - mx, y - my, z - mz)).sum::<f64>();
    let (xx, yy, xy) = (sum(&|x, _, _| x * x), sum(&|_, y, _| y * y), sum(&|x, y, _| x * y));
    let (xz, yz) = (sum(&|x, _, z| x * z), sum(&|_, y, z| y * z));
    let determinant = xx * yy - xy * xy;
    let (a, b) = ((xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant);
    points.iter().map(|&[x, y, z]| z - mz - a * (x - mx) - b * (y - my)).collect()
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
    for (name, wanted) in reference.iter().filter(|(name, _)| !name.starts_with('_')) {
        let scan = read(&folder.join(name)).unwrap();
        let shape = [wanted["ny"].as_u64(), wanted["nx"].as_u64()].map(|n| n.unwrap() as usize);
        assert_eq!(scan.heights_m.shape(), shape, "{name}");
        assert_eq!(scan.missing_points() as u64, wanted["n_missing"].as_u64().unwrap(), "{name}");
        // The loaders of the reference store some pitches as f32, others as text of six digits.
        let (dx_m, dy_m) = scan.pitch_m.unwrap();
        assert_close(dx_m, &wanted["dx_m"], 1e-6, name);
        assert_close(dy_m, &wanted["dy_m"], 1e-6, name);
        let flat = without_plane(&scan);
        let moment = |f: &dyn Fn(f64) -> f64| flat.iter().map(|&z| f(z)).sum::<f64>() / flat.len() as f64;
        let sq_m = moment(&|z| z * z).sqrt();
        let statistics = &wanted["own_numpy_after_LS_plane"];
        if statistics["Sq_m"].is_null() {
            // The smallest sample has no statistics in the reference, but its lowest and highest height.
            let (low, high) =
                scan.heights_m.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &z| (l.min(z), h.max(z)));
            assert_close(low, &wanted["raw"]["min_m"], 1e-12, name);
            assert_close(high, &wanted["raw"]["max_m"], 1e-12, name);
            continue;
        }
        assert_close(sq_m, &statistics["Sq_m"], 1e-6, &format!("{name}: Sq"));
        assert_close(moment(&f64::abs), &statistics["Sa_m"], 1e-6, &format!("{name}: Sa"));
        assert_close(moment(&|z| z.powi(3)) / sq_m.powi(3), &statistics["Ssk"], 1e-4, &format!("{name}: Ssk"));
        assert_close(moment(&|z| z.powi(4)) / sq_m.powi(4), &statistics["Sku"], 1e-6, &format!("{name}: Sku"));
        compared += 1;
    }
    assert_eq!(compared, 11, "files with reference values");
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
fn every_file_of_the_collection_is_read() {
    let Some(folder) = surfaces() else { return };
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let is_description = path.extension().is_some_and(|extension| extension == "md" || extension == "json");
        assert!(is_description || read(&path).is_ok(), "{}: {:?}", path.display(), read(&path).err());
    }
}
