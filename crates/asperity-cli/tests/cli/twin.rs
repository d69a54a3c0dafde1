//! Tests of `asperity surface twin`.

use std::fs;
use std::path::Path;

use asperity_formats::{Scan, read, write_x3p};
use ndarray::Array2;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{Finished, asperity_in, json_of, listing, npy, number, run_in, written};

fn twin(folder: &Path, line: &str) -> Finished {
    let line = format!("surface twin {line}");
    run_in(folder, &line)
}

/// A folder with a rough map drawn by the program, with holes.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let spec = "seed = 3\nsize = [\"60 um\", \"40 um\"]\npoints = [60, 40]\n[surface]\ncovariance = \"exponential\"\n\
                marginal = \"normal\"\nrms_height = \"1 um\"\ncorrelation_length = [\"5 um\", \"4 um\"]\n\
                generator = \"spectral\"\n";
    fs::write(folder.path().join("spec.toml"), spec).unwrap();
    let made = asperity_in(folder.path(), &["surface", "generate", "spec.toml", "--out", "whole.x3p"]);
    assert_eq!(made.code, 0, "{made:?}");
    let mut heights = read(&folder.path().join("whole.x3p")).unwrap().heights_m;
    heights.indexed_iter_mut().filter(|((r, c), _)| r + c < 12).for_each(|(_, z)| *z = f64::NAN);
    let scan = Scan::new(heights, Some((1e-6, 1e-6)));
    fs::write(folder.path().join("scan.x3p"), write_x3p(&scan).unwrap()).unwrap();
    folder
}

/// Fast options.
const FAST: &str = "--translation plain --covariance exponential";

#[test]
fn the_folder_contains_twins_comparison_tables_figures_and_a_page() {
    let folder = folder();
    let at = folder.path();
    let json = twin(at, &format!("scan.x3p --count 4 --out twins --seed 7 --json {FAST}")).json(0);
    assert!(json["format"] == "X3P" && json.get("channel").is_some(), "{json}");
    let out = at.join("twins");
    assert_eq!(
        written(&out),
        [
            "COMPLETE",
            "comparison.json",
            "figures",
            "provenance.json",
            "tables",
            "twin_0001.x3p",
            "twin_0002.x3p",
            "twin_0003.x3p",
            "twin_0004.x3p",
            "twins.html"
        ]
    );
    let figures = ["acf.svg", "height_pdf.svg", "maps.svg", "parameters.svg", "parameters_one_column.svg", "psd.svg"];
    assert_eq!(listing(&out.join("figures")), figures);
    let tables = listing(&out.join("tables"));
    let wanted = ["acf_x.csv", "acf_y.csv", "height_pdf.csv", "psd_x.csv", "psd_y.csv", "statistics.csv"];
    assert_eq!(tables, wanted);
    let stored = json_of(&out.join("comparison.json"));
    let mut printed = json.clone();
    for key in ["format", "channel"] {
        printed.as_object_mut().unwrap().remove(key).unwrap();
    }
    assert_eq!(stored, printed, "the file is what --json prints beside the source");

    assert_eq!((json["file"].as_str(), number(&json, "count"), number(&json, "seed")), (Some("scan.x3p"), 4.0, 7.0));
    assert_eq!(json["band_method"], "student_t");
    assert!(number(&json["target"], "missing_points") > 50.0);
    assert_eq!(json["twins"]["Sq_m"]["target"], json["target"]["Sq_m"]);
    let sq = &json["twins"]["Sq_m"];
    assert!(sq["inside"] == Value::Bool(true) && sq["band"][0].as_f64() < sq["mean"].as_f64(), "{sq}");
    assert_eq!(json["model"]["covariance"]["model"], "exponential");
    assert!(json["limits"][0].as_str().unwrap().contains("stationary"));

    let map = read(&out.join("twin_0002.x3p")).unwrap();
    assert_eq!((map.heights_m.dim(), map.pitch_m, map.missing_points()), ((40, 60), Some((1e-6, 1e-6)), 0));
    let page = fs::read_to_string(out.join("twins.html")).unwrap();
    assert!(page.contains("Twins of scan.x3p") && page.contains("4 maps of 60 × 40 points"));
    assert!(page.contains("of the points of the curves lie within") && page.contains("autocorrelation along x"));
    let table = fs::read_to_string(out.join("tables/statistics.csv")).unwrap();
    assert!(table.starts_with("twin,Sa_m,Sq_m,") && table.lines().count() == 5);
}

#[test]
fn a_twin_does_not_depend_on_the_count_and_format_selects_the_file_type() {
    let folder = folder();
    let at = folder.path();
    assert_eq!(twin(at, &format!("scan.x3p --count 2 --out few {FAST}")).code, 0);
    let many = twin(at, &format!("scan.x3p --count 3 --out many --threads 1 --format npy {FAST}"));
    assert_eq!(many.code, 0);
    assert!(many.stderr.contains("NPY cannot store the pixel size"), "{many:?}");
    let of = |path: &str| read(&at.join(path)).unwrap().heights_m;
    assert_eq!(of("few/twin_0002.x3p"), of("many/twin_0002.npy"));
    assert_ne!(of("few/twin_0001.x3p"), of("few/twin_0002.x3p"));
    // The table names the compared curves.
    assert!(many.stdout.contains("95 % band of twins") && many.stdout.contains("µm"), "{many:?}");
    let last = many.stdout.lines().last().unwrap();
    assert!(last.ends_with("lie within the band of its twins"), "{many:?}");
    assert!(last.contains(" % of the points of its curves (height pdf ") && last.contains("psd y "), "{last}");

    // A twin of another size cannot have the scan's missing points.
    let wide = twin(at, &format!("scan.x3p --count 2 --out wide --points 90,50 --json {FAST}"));
    assert_eq!(wide.json(0)["points"], serde_json::json!([90, 50]));
    assert!(wide.stderr.contains("different bandwidths"), "{wide:?}");
    assert_eq!(of("wide/twin_0001.x3p").dim(), (50, 90));
}

#[test]
fn only_force_replaces_a_folder_and_never_one_with_foreign_files() {
    let folder = folder();
    let at = folder.path();
    fs::create_dir(at.join("twins")).unwrap();
    fs::write(at.join("twins/mine.txt"), "mine").unwrap();
    let line = format!("scan.x3p --count 2 --out twins {FAST}");
    twin(at, &line).refuses(2, &["twins", "--force"]);
    twin(at, &format!("{line} --force")).refuses(2, &["--out twins", "asperity did not write it"]);
    assert_eq!(listing(&at.join("twins")), ["mine.txt"]);
    fs::remove_dir_all(at.join("twins")).unwrap();
    assert_eq!(twin(at, &line).code, 0);
    assert_eq!(twin(at, &line.replace("--count 2", "--count 1 --force")).code, 0);
    assert!(!at.join("twins/twin_0002.x3p").exists());
    // The folder that contains the scan is not deleted.
    twin(at, &format!("scan.x3p --count 2 --out . --force {FAST}")).refuses(2, &["scan.x3p", "delete"]);
    assert!(at.join("scan.x3p").is_file());
    twin(at, &format!("scan.x3p --count 2 --out huge --size 1m {FAST}")).refuses(5, &["memory"]);
    twin(at, &format!("scan.x3p --count 2 --out scan.x3p {FAST}")).refuses(2, &["--out", "folder"]);
    let hidden: Vec<String> = listing(at).into_iter().filter(|name| name.starts_with('.')).collect();
    assert!(hidden.is_empty(), "{hidden:?}");
}

#[test]
fn scans_without_texture_and_wrong_flags_leave_nothing_behind() {
    let folder = folder();
    let at = folder.path();
    npy(at, "flat.npy", Array2::from_elem((16, 16), 1e-6));
    npy(at, "noise.npy", Array2::from_shape_fn((16, 16), |(r, c)| ((r * 7919 + c * 104_729) % 101) as f64 * 1e-9));
    fs::write(at.join("words.txt"), "one two\n").unwrap();
    let before = listing(at);
    for (line, code, words) in [
        ("gone.x3p", 3, vec!["gone.x3p", "no such file"]),
        ("words.txt --pixel-size 1um", 3, vec!["words.txt"]),
        ("flat.npy", 2, vec!["flat.npy", "--pixel-size"]),
        ("flat.npy --pixel-size 1um", 3, vec!["flat.npy"]),
        ("scan.x3p --count 0", 2, vec!["--count", "at least 1"]),
        ("scan.x3p --format bmp", 2, vec!["--format", "asperity formats"]),
        ("scan.x3p --marginal gamma:2", 2, vec!["--marginal", "gamma"]),
        ("scan.x3p --correlation-length 5um", 2, vec!["--correlation-length", "--covariance"]),
        ("scan.x3p --covariance matern --correlation-length 5um", 2, vec!["--smoothness"]),
        ("scan.x3p --covariance self_affine --correlation-length 5um", 2, vec!["--hurst"]),
        ("scan.x3p --hurst 0.7", 2, vec!["--correlation-length"]),
        ("scan.x3p --modes 20", 2, vec!["--modes", "karhunen_loeve"]),
        ("scan.x3p --points 1,40", 2, vec!["--points", "2 × 2"]),
        ("scan.x3p --s-filter 9um --l-filter 5um", 2, vec!["scan.x3p", "no scale is left"]),
        ("scan.x3p --channel 3", 2, vec!["scan.x3p"]),
    ] {
        twin(at, &format!("{line} --out deep/twins")).refuses(code, &words);
    }
    assert_eq!(listing(at), before);
    // Noise can have twins; the command warns.
    let noisy = twin(at, "noise.npy --pixel-size 1um --covariance measured --count 2 --out deep/twins");
    assert!(noisy.code == 0 && noisy.stderr.contains("they are noise"), "{noisy:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_leaves_no_partial_folder() {
    let folder = folder();
    let at = folder.path();
    let line = format!("surface twin scan.x3p --count 100000 --out deep/twins {FAST}");
    let (found, _) = crate::support::run_and_interrupt(at, &line);
    assert_eq!((found.code, found.stdout.as_str()), (130, ""), "{found:?}");
    assert_eq!(listing(at), ["scan.x3p", "spec.toml", "whole.x3p"]);
}
