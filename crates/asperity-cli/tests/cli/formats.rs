//! Tests of `asperity formats`, and of files of many formats in other commands.

use std::fs;
use std::path::Path;

use asperity_formats::read;
use ndarray::Array2;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{asperity, listing, npy, number, run_in};

#[test]
fn the_table_lists_every_format_and_its_test_files() {
    let table = asperity("formats");
    assert_eq!((table.code, table.stderr.as_str()), (0, ""));
    let json = asperity("formats --json").json(0);
    let formats = json["formats"].as_array().unwrap();
    assert!(formats.len() >= 20, "{} formats", formats.len());
    for format in formats {
        let name = format["name"].as_str().unwrap();
        let line = table.stdout.lines().find(|line| line.starts_with(name));
        let extension = format["extensions"][0].as_str().unwrap();
        assert!(line.is_some_and(|line| line.contains(&format!(".{extension}"))), "{name}: {line:?}");
        assert!(table.stdout.contains(format["tested_on"].as_str().unwrap()));
    }
    let written: Vec<&str> =
        formats.iter().filter(|format| format["writes"] != "").map(|format| format["name"].as_str().unwrap()).collect();
    for wanted in ["X3P", "SUR", "SDF", "GWY", "NPY", "text"] {
        assert!(written.contains(&wanted), "{wanted} is not among {written:?}");
    }
}

/// Heights in micrometres with two missing points, on a grid and pixels that are not square.
fn map() -> Array2<f64> {
    let mut heights = Array2::from_shape_fn((7, 9), |(row, column)| 1e-6 * ((row * 9 + column) as f64).sin());
    heights[[0, 3]] = f64::NAN;
    heights[[6, 8]] = f64::NAN;
    heights
}

/// Writes an archive `two.npz` of the maps `a` and `b` from these files.
fn two_maps(folder: &Path, files: [&str; 2]) {
    let mut archive = zip::ZipWriter::new(fs::File::create(folder.join("two.npz")).unwrap());
    for (name, file) in ["a.npy", "b.npy"].into_iter().zip(files) {
        archive.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut archive, &fs::read(folder.join(file)).unwrap()).unwrap();
    }
    archive.finish().unwrap();
}

#[test]
fn channel_selects_a_map_by_name_or_number() {
    let folder = TempDir::new().unwrap();
    npy(folder.path(), "map.npy", Array2::from_shape_fn((16, 16), |(row, column)| 1e-7 * (row * column % 7) as f64));
    let press =
        "contact map.npy --pixel-size 1um --youngs-modulus 1GPa --boundary periodic --mean-pressure 1MPa --out f.npz";
    assert_eq!(run_in(folder.path(), press).code, 0);
    let first = run_in(folder.path(), "surface convert f.npz a.npy");
    assert!(first.stderr.contains("warning: f.npz: the file holds 3 height maps"), "{first:?}");
    assert!(first.stderr.contains("arrays other than heights were left out: pressure_pa, clusters"), "{first:?}");
    let gap = run_in(folder.path(), "surface convert f.npz b.npy --channel gap_m");
    assert!(gap.code == 0 && !gap.stderr.contains("height maps"), "{gap:?}");
    let names = ["displacement_m", "gap_m", "plastic_displacement_m"];
    let place = names.iter().position(|name| *name == "gap_m").unwrap() + 1;
    let by_number = run_in(folder.path(), &format!("surface convert f.npz c.npy --channel {place}"));
    assert_eq!(by_number.code, 0, "{by_number:?}");
    let heights = |name: &str| read(&folder.path().join(name)).unwrap().heights_m;
    assert_eq!(heights("b.npy"), heights("c.npy"));
    assert!(heights("b.npy").iter().all(|gap| *gap >= 0.0));
    assert_ne!(heights("a.npy"), heights("b.npy"));
    let before = listing(folder.path());
    for wrong in ["pressure_pa", "4", "0"] {
        run_in(folder.path(), &format!("surface convert f.npz d.npy --channel {wrong}"))
            .refuses(2, &["f.npz", "gap_m", wrong]);
    }
    assert_eq!(listing(folder.path()), before);
}

#[test]
#[ignore = "slow"]
fn a_study_selects_the_map_of_a_file() {
    let folder = TempDir::new().unwrap();
    let rough = |seed: usize| {
        Array2::from_shape_fn((32, 32), |(row, column)| {
            1e-7 * (((row * 31 + column * 17 + seed) * 2_654_435_761 % 1000) as f64 / 1000.0)
        })
    };
    npy(folder.path(), "a.npy", rough(1));
    npy(folder.path(), "b.npy", rough(5) * 3.0);
    two_maps(folder.path(), ["a.npy", "b.npy"]);
    let study = |channel: &str| {
        let text = format!(
            "seed = 1\n[surface]\nfile = \"two.npz\"\nchannel = \"{channel}\"\npixel_size = [\"1 um\", \"1 um\"]\n\
             covariance = \"exponential\"\ncorrelation_length = [\"3 um\", \"3 um\"]\n"
        );
        fs::write(folder.path().join("study.toml"), text).unwrap();
        run_in(folder.path(), "run study.toml --out out --force --json")
    };
    let sq = |channel: &str| number(&study(channel).json(0)["surface"], "Sq_m");
    let (first, second) = (sq("a"), sq("b"));
    assert!((second / first - 3.0).abs() < 0.2, "{first:e} {second:e}");
    assert_eq!(sq("2"), second);
    study("c").refuses(2, &["two.npz", "`a`, `b`"]);
}

#[test]
fn json_names_the_format_the_channel_and_the_warnings_also_when_quiet() {
    let folder = TempDir::new().unwrap();
    let run = |line: &str| run_in(folder.path(), line);
    npy(folder.path(), "a.npy", map());
    two_maps(folder.path(), ["a.npy"; 2]);
    for quiet in ["", " --quiet"] {
        let found = run(&format!("surface stats two.npz --pixel-size 1um --json{quiet}"));
        let json = found.json(0);
        assert_eq!((&json["format"], &json["channel"]), (&"NPZ".into(), &"a".into()));
        let warning = json["warnings"][0].as_str().unwrap();
        assert!(warning.contains("two.npz: the file holds 2 height maps (a, b); `a` was read"), "{warning}");
        assert_eq!(found.stderr.contains(warning), quiet.is_empty());
    }
    let json = run("surface convert two.npz out.x3p --channel b --pixel-size 1um,2um --json").json(0);
    assert_eq!(json["format"], "NPZ");
    assert_eq!((&json["channel"], &json["written_format"]), (&"b".into(), &"X3P".into()));
    assert_eq!((number(&json, "nx"), number(&json, "ny"), number(&json, "missing_points")), (9.0, 7.0, 2.0));
    assert_eq!((number(&json, "dx_m"), number(&json, "dy_m")), (1e-6, 2e-6));
    assert_eq!(json["warnings"], Value::Array(vec![]));
    let json = run("surface stats a.npy out.x3p --pixel-size 1um,2um --json").json(0);
    assert_eq!(
        (json["format"].to_string(), json["channel"].to_string()),
        (r#"["NPY","X3P"]"#.into(), r#"[null,"layer 1"]"#.into())
    );
}

#[test]
fn every_json_object_carries_its_warnings() {
    let folder = TempDir::new().unwrap();
    npy(
        folder.path(),
        "a.npy",
        Array2::from_shape_fn((16, 16), |(row, column)| 1e-7 * ((row * 5 + column * 3) as f64).sin()),
    );
    let machine = "--static-friction 0.1 --stribeck 4.2 --belt-velocity 0.003";
    for line in [
        "formats --json",
        "surface modes --covariance exponential --correlation-length 20um --size 200um --points 32 --modes 3 --json",
        "surface stats a.npy --pixel-size 1um --json",
        "contact a.npy --pixel-size 1um --youngs-modulus 1GPa --boundary periodic --mean-pressure 1MPa --json",
        &format!("vibration critical-damping {machine} --json"),
        &format!("vibration cycle {machine} --damping-ratio 0.17 --json"),
        &format!("vibration forced-cycles {machine} --damping-ratio 0.17 --forcing 0.01 --forcing-frequency 1 --json"),
    ] {
        let found = run_in(folder.path(), line);
        assert!(found.code == 0, "{line}: {found:?}");
        assert!(found.json(0)["warnings"].is_array(), "{line}: {found:?}");
    }
}

#[test]
fn a_stated_height_unit_applies_and_a_contradiction_gives_a_warning() {
    let folder = TempDir::new().unwrap();
    let run = |line: &str| run_in(folder.path(), line);
    fs::write(folder.path().join("plain.txt"), "1 2 3\n2 4 1\n5 1 2\n").unwrap();
    fs::write(folder.path().join("named.txt"), "# unit: nm\n1 2 3\n2 4 1\n5 1 2\n").unwrap();
    let sq = |line: &str| number(&run(&format!("surface stats {line} --pixel-size 20um --json")).json(0), "Sz_m");
    // In metre the plain file would be higher than its field of view is wide.
    let study = "seed = 1\n[surface]\nfile = \"plain.txt\"\npixel_size = \"20 um\"\n";
    fs::write(folder.path().join("study.toml"), study).unwrap();
    for line in ["surface stats plain.txt --pixel-size 20um", "check study.toml", "run study.toml"] {
        run(line).refuses(
            2,
            &["plain.txt", "span 4 m, more than the field of view, 60 µm", "--height-unit", "`height_unit`"],
        );
    }
    assert!((sq("plain.txt --level none --height-unit um") / 4e-6 - 1.0).abs() < 1e-12);
    assert!((sq("named.txt --level none") / 4e-9 - 1.0).abs() < 1e-12);
    assert!((sq("named.txt --level none --height-unit um") / 4e-6 - 1.0).abs() < 1e-12);
    let found = run("surface convert named.txt out.npy --height-unit um");
    assert!(
        found.stderr.contains("warning: named.txt: the stated height unit, um, replaces the file's nm"),
        "{found:?}"
    );
    assert_eq!(read(&folder.path().join("out.npy")).unwrap().heights_m[[0, 0]], 1e-6);
    let contact =
        "contact plain.txt --pixel-size 20um --height-unit um --youngs-modulus 1GPa --boundary free --percentile 50";
    let json = run(&format!("{contact} --json")).json(0);
    assert!(number(&json, "penetration_m") < 5e-6, "{json}");
    run("surface convert plain.txt out.npy --height-unit V")
        .refuses(2, &["--height-unit", "`V` is not a unit of length"]);
}

#[test]
fn commas_that_may_separate_thousands_need_the_decimal_sign_in_commands_and_studies() {
    let folder = TempDir::new().unwrap();
    let run = |line: &str| run_in(folder.path(), line);
    fs::write(
        folder.path().join("map.txt"),
        "# unit: nm\n1,000\t2,000\t3,000\n2,000\t4,000\t1,000\n5,000\t1,000\t2,000\n",
    )
    .unwrap();
    let study = |decimal: &str| {
        let text =
            format!("seed = 1\n[surface]\nfile = \"map.txt\"\npixel_size = \"20 um\"\nlevel = \"none\"\n{decimal}");
        fs::write(folder.path().join("study.toml"), text).unwrap();
    };
    study("");
    let readings = ["map.txt", "`1,000` (line 2) may be 1.000 or 1000", "--decimal comma", "`decimal`"];
    run("surface stats map.txt --pixel-size 20um").refuses(2, &readings);
    run("check study.toml").refuses(2, &readings);
    for (sign, sz_m) in [("comma", 4e-9), ("point", 4e-6)] {
        let line = format!("surface stats map.txt --pixel-size 20um --level none --decimal {sign} --json");
        assert!((number(&run(&line).json(0), "Sz_m") / sz_m - 1.0).abs() < 1e-12, "{sign}");
        study(&format!("decimal = \"{sign}\"\n"));
        let found = run("check study.toml");
        assert!(!found.stderr.contains("may be 1.000 or 1000"), "{found:?}");
    }
    study("decimal = \"dot\"\n");
    run("check study.toml").refuses(2, &["study.toml:6", "dot", "comma", "point"]);
    run("surface stats map.txt --decimal dot").refuses(2, &["--decimal", "dot", "comma", "point"]);
    // A study needs more points than a file of three rows.
    let rows: String = (0..32)
        .map(|row| {
            (0..32).map(|n| format!("{},{:03}\t", 1 + (row * 7 + n) % 5, n * n % 1000)).collect::<String>() + "\n"
        })
        .collect();
    fs::write(folder.path().join("large.txt"), format!("# unit: nm\n{}", rows.replace("\t\n", "\n"))).unwrap();
    run("init other --scan large.txt --pixel-size 20um").refuses(2, &["large.txt", "--decimal comma"]);
    let found = run("init other --scan large.txt --pixel-size 20um --decimal comma");
    assert_eq!(found.code, 0, "{found:?}");
    let study = fs::read_to_string(folder.path().join("other/study.toml")).unwrap_or_default();
    assert!(study.contains("decimal = \"comma\""), "{study}");
}

#[test]
fn an_unsupported_format_is_named_with_a_remedy() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scan.sxm"), b":NANONIS_VERSION:\r\n2\r\n").unwrap();
    run_in(folder.path(), "surface stats scan.sxm")
        .refuses(3, &["scan.sxm: this is a Nanonis SXM file", "Gwyddion can save it as GWY"]);
}
