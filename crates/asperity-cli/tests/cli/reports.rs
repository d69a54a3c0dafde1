//! Cases that users of other programs reported; docs/validation/reports.md lists them.

use std::fs;

use asperity_formats::read;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::run_in;

#[test]
fn voids_keep_their_place_when_levelled_and_converted_to_every_format() {
    // SurfaceTopography #126: a list of 14 of 16 points.
    let folder = TempDir::new().unwrap();
    let is_void = |place: usize| [6, 12].contains(&place);
    let height = |place: usize| 0.3 * (place % 4) as f64 - 0.2 * (place / 4) as f64 + ((place * place) % 7) as f64;
    let points = (0..16).filter(|place| !is_void(*place));
    let text: String = points.map(|place| format!("{} {} {}\n", place % 4, place / 4, height(place))).collect();
    fs::write(folder.path().join("points.xyz"), format!("X [um] Y [um] Z [nm]\n{text}")).unwrap();
    let convert = |from: &str, to: &str| {
        let finished = run_in(folder.path(), &format!("surface convert {from} {to} --level plane"));
        assert_eq!(finished.code, 0, "{finished:?}");
        read(&folder.path().join(to)).unwrap().heights_m
    };
    let levelled = convert("points.xyz", "map.x3p");
    assert_eq!(levelled.dim(), (4, 4));
    // Least squares over the present points: the rest is orthogonal to 1, x and y.
    for weight in [|_, _| 1.0, |_, column| column as f64, |row, _| row as f64] as [fn(usize, usize) -> f64; 3] {
        let present = levelled.indexed_iter().filter(|(_, z)| !z.is_nan());
        let sum: f64 = present.map(|((row, column), z)| weight(row, column) * z).sum();
        assert!(sum.abs() < 1e-21, "{sum}");
    }
    // VTI is written and not read; asperity-formats tests its voids.
    for extension in ["x3p", "sur", "sdf", "gwy", "npy", "txt"] {
        let found = convert("points.xyz", &format!("again.{extension}"));
        assert_eq!(found.dim(), (4, 4));
        for (place, (z, wanted)) in found.iter().zip(&levelled).enumerate() {
            assert_eq!(z.is_nan(), is_void(place), "{extension}: {found}");
            // SUR stores whole steps.
            assert!(z.is_nan() || (z - wanted).abs() < 1e-16, "{extension}: {z:e} {wanted:e}");
        }
    }
}

/// Asserts that all numbers of two objects agree to 1e-12, and everything else is equal. The residual of a solution is a difference of
/// numbers of order one, to which 1e-12 refers.
fn assert_same(found: &Value, wanted: &Value, place: &str) {
    match (found, wanted) {
        (Value::Number(found), Value::Number(wanted)) => {
            let (found, wanted) = (found.as_f64().unwrap(), wanted.as_f64().unwrap());
            let scale = if place == "/residual" { 1.0 } else { wanted.abs() };
            assert!((found - wanted).abs() <= 1e-12 * scale, "{place}: {found:e} {wanted:e}");
        }
        (Value::Array(found), Value::Array(wanted)) => {
            assert_eq!(found.len(), wanted.len(), "{place}");
            found.iter().zip(wanted).for_each(|(found, wanted)| assert_same(found, wanted, place));
        }
        (Value::Object(found), Value::Object(wanted)) => {
            found.iter().for_each(|(key, value)| assert_same(value, &wanted[key], &format!("{place}/{key}")));
        }
        _ => assert_eq!(found, wanted, "{place}"),
    }
}

#[test]
fn units_of_lengths_and_pressures_change_no_result() {
    // SurfaceTopography #275, CalculiX #162.
    let folder = TempDir::new().unwrap();
    for (unit, per_metre) in [("m", 1.0), ("um", 1e6), ("nm", 1e9)] {
        let row = |row: usize| -> String {
            let height = |column: usize| {
                let (x, y) = (column as f64, row as f64);
                1e-7 * (2.0 + (0.7 * x + 0.3 * y).sin() + (0.5 * (0.4 * x - 0.9 * y).cos()).exp())
            };
            (0..32).map(|column| format!("{:e} ", height(column) * per_metre)).collect::<String>() + "\n"
        };
        let header =
            format!("# unit: {unit}\n# dx: {:e} {unit}\n# dy: {:e} {unit}\n", 1e-6 * per_metre, 1.5e-6 * per_metre);
        let text = header + &(0..24).map(row).collect::<String>();
        fs::write(folder.path().join(format!("{unit}.txt")), text).unwrap();
    }
    let json = |line: &str| {
        let mut json = run_in(folder.path(), &format!("{line} --json --quiet")).json(0);
        json.as_object_mut().unwrap().remove("warnings");
        json
    };
    let stats = ["m", "um", "nm"].map(|unit| json(&format!("surface stats {unit}.txt --level plane")));
    stats[1..].iter().for_each(|found| assert_same(found, &stats[0], ""));
    let press = |unit: &str, modulus: &str, pressure: &str| {
        json(&format!("contact {unit}.txt --youngs-modulus {modulus} --boundary periodic --mean-pressure {pressure}"))
    };
    let contact = press("m", "2e9Pa", "1e6Pa");
    assert!(contact["iterations"].as_u64().unwrap() > 0);
    for (unit, modulus, pressure) in [("um", "2e9Pa", "1e6Pa"), ("nm", "2000MPa", "1MPa"), ("m", "2GPa", "1000kPa")] {
        assert_same(&press(unit, modulus, pressure), &contact, "");
    }
}

#[test]
fn lengths_along_a_lay_are_named_as_without_decay() {
    // surfalize 0.17.1: 10.37 grooves across the map.
    let folder = TempDir::new().unwrap();
    let row: String = (0..128)
        .map(|column| format!("{:e} ", 1e-7 * (std::f64::consts::TAU * 10.37 * f64::from(column) / 128.0).cos()))
        .collect();
    let text = format!("# unit: m\n# dx: 1 um\n# dy: 1 um\n{}", (row + "\n").repeat(128));
    fs::write(folder.path().join("grooves.txt"), text).unwrap();
    let line = "surface stats grooves.txt --level mean --quiet";
    let table = run_in(folder.path(), line).stdout;
    for label in ["Str", "correlation length y (1/e)"] {
        let found = table.lines().find(|line| line.starts_with(&format!("{label}  "))).unwrap();
        assert!(found.ends_with("  no decay within the field"), "{table}");
    }
    let json = run_in(folder.path(), &format!("{line} --json")).json(0);
    assert_eq!((&json["Str"], &json["correlation_length_y_m"]), (&Value::Null, &Value::Null));
}
