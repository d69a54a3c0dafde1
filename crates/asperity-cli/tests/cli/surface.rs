//! `asperity surface …`.

use std::fs;
use std::path::Path;

use asperity_formats::{Scan, X3pData, read, write_x3p};
use ndarray::{Array2, array};
use tempfile::TempDir;

use crate::support::{Ended, asperity_in, listing, npy};

fn surface(folder: &Path, line: &str) -> Ended {
    let line = format!("surface {line}");
    asperity_in(folder, &line.split_whitespace().collect::<Vec<_>>())
}

#[test]
fn converting_keeps_heights_pitch_and_missing_points() {
    let folder = TempDir::new().unwrap();
    let heights_m = array![[1e-6, f64::NAN, 3e-6], [0.5e-6, -1.0 / 3.0 * 1e-6, 0.0]];
    npy(folder.path(), "map.npy", heights_m.clone());
    let first = surface(folder.path(), "convert map.npy map.x3p --pixel-size 2um,3um");
    assert_eq!((first.code, first.stdout.as_str()), (0, ""));
    assert!(first.stderr.contains("3 × 2 points, 1 missing"), "{first:?}");
    let scan = read(&folder.path().join("map.x3p")).unwrap();
    assert_eq!(scan.pitch_m, Some((2e-6, 3e-6)));
    let back = surface(folder.path(), "convert map.x3p back.npy --quiet");
    assert_eq!(back.code, 0);
    assert!(back.stderr.starts_with("warning: back.npy") && back.stderr.contains("2e-6 × 3e-6 m"), "{back:?}");
    let read_back = read(&folder.path().join("back.npy")).unwrap().heights_m;
    let bits = |map: &Array2<f64>| map.iter().map(|z| z.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&read_back), bits(&heights_m));
    assert_eq!(listing(folder.path()), ["back.npy", "map.npy", "map.x3p"]);
}

#[test]
fn a_given_pixel_size_overrides_the_file_s_with_a_warning() {
    let folder = TempDir::new().unwrap();
    let scan = Scan::new(array![[1e-8, 2e-8], [3e-8, 4e-8]], Some((1e-6, 1e-6)));
    fs::write(folder.path().join("map.x3p"), write_x3p(&scan, X3pData::Float64).unwrap()).unwrap();
    let ended = surface(folder.path(), "convert map.x3p out.x3p --pixel-size 5um");
    assert_eq!(ended.code, 0);
    assert!(ended.stderr.contains("warning: map.x3p: --pixel-size"), "{ended:?}");
    assert_eq!(read(&folder.path().join("out.x3p")).unwrap().pitch_m, Some((5e-6, 5e-6)));
    let same = surface(folder.path(), "convert map.x3p out.x3p --pixel-size 1um --quiet");
    assert_eq!((same.code, same.stderr.as_str()), (0, ""));
}

#[test]
fn a_conversion_that_cannot_be_done_leaves_nothing_behind() {
    let folder = TempDir::new().unwrap();
    npy(folder.path(), "map.npy", array![[1e-6, 2e-6], [3e-6, 4e-6]]);
    let scan = Scan::new(Array2::zeros((16, 16)), Some((1e-6, 1e-6)));
    let whole = write_x3p(&scan, X3pData::Float64).unwrap();
    fs::write(folder.path().join("cut.x3p"), &whole[..whole.len() / 2]).unwrap();
    fs::write(folder.path().join("empty.npy"), "").unwrap();
    fs::write(folder.path().join("words.txt"), "1e-6 two 3e-6\n").unwrap();
    let before = listing(folder.path());
    for (line, code, words) in [
        ("convert gone.x3p out.npy", 3, vec!["gone.x3p", "no such file"]),
        ("convert cut.x3p out.npy", 3, vec!["cut.x3p"]),
        ("convert empty.npy out.npy", 3, vec!["empty.npy"]),
        ("convert words.txt out.npy", 3, vec!["words.txt", "line 1", "two"]),
        ("convert . out.npy", 3, vec!["."]),
        ("convert map.npy out.x3p", 2, vec!["out.x3p", "pixel size"]),
        ("convert map.npy out.tiff", 2, vec!["out.tiff", ".tiff", ".x3p"]),
        ("convert map.npy out", 2, vec!["out"]),
        ("convert map.npy nowhere/out.npy", 2, vec!["nowhere"]),
        ("convert map.npy out.x3p --pixel-size 0um", 2, vec!["--pixel-size", "above 0"]),
        ("convert map.npy out.x3p --pixel-size 1", 2, vec!["--pixel-size", "no unit"]),
        ("convert map.npy out.x3p --pixel-size 1um,1um,1um", 2, vec!["--pixel-size", "3 values"]),
    ] {
        surface(folder.path(), line).refuses(code, &words);
    }
    assert_eq!(listing(folder.path()), before);
}
