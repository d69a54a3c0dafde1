//! Tests of `asperity surface`.

use std::fs;
use std::path::Path;

use asperity_formats::{Scan, read, write_x3p};
use ndarray::{Array2, array};
use tempfile::TempDir;

use crate::support::{Finished, asperity, close, listing, npy, number, run_in, written};

fn surface(folder: &Path, line: &str) -> Finished {
    let line = format!("surface {line}");
    run_in(folder, &line)
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
    let back = surface(folder.path(), "convert map.x3p back.npy --level none");
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
    let scan = Scan::new(array![[1e-8, -2e-8], [-1e-8, 2e-8]], Some((1e-6, 1e-6)));
    fs::write(folder.path().join("map.x3p"), write_x3p(&scan).unwrap()).unwrap();
    let found = surface(folder.path(), "convert map.x3p out.x3p --pixel-size 5um");
    assert_eq!(found.code, 0);
    assert!(
        found.stderr.contains("warning: map.x3p: the stated pixel size, 5 µm × 5 µm, replaces the file's"),
        "{found:?}"
    );
    assert_eq!(read(&folder.path().join("out.x3p")).unwrap().pitch_m, Some((5e-6, 5e-6)));
    let same = surface(folder.path(), "convert map.x3p out.x3p --pixel-size 1um");
    assert!(same.code == 0 && !same.stderr.contains("warning"), "{same:?}");
    let quiet = surface(folder.path(), "convert map.x3p out.x3p --pixel-size 5um --quiet");
    assert_eq!((quiet.code, quiet.stderr.as_str()), (0, ""));
}

#[test]
fn a_tilt_left_in_a_converted_map_gives_a_warning() {
    let folder = TempDir::new().unwrap();
    let tilted = sine() + Array2::from_shape_fn(sine().dim(), |(_, column)| 1e-6 * column as f64);
    npy(folder.path(), "map.npy", tilted.clone());
    let warned = surface(folder.path(), "convert map.npy out.x3p --pixel-size 1um --json").json(0);
    let told = warned["warnings"].to_string();
    assert!(told.contains("the form (plane)") && told.contains("--level plane removes it"), "{told}");
    assert_eq!(read(&folder.path().join("out.x3p")).unwrap().heights_m, tilted);
    for level in ["plane", "none"] {
        let line = format!("convert map.npy {level}.x3p --pixel-size 1um --level {level}");
        let found = surface(folder.path(), &line);
        assert!(found.code == 0 && !found.stderr.contains("form"), "{found:?}");
    }
}

#[test]
fn a_profile_of_a_stylus_has_its_parameters_and_is_no_map() {
    let folder = TempDir::new().unwrap();
    let row = |k: u32| {
        let (x, wave) = (0.5 * f64::from(k), (std::f64::consts::TAU * f64::from(k) / 100.0).sin());
        format!("{x},{:.4},,\n", 2e4 * wave)
    };
    let text: String = (0..4000).map(row).collect();
    fs::write(
        folder.path().join("line.csv"),
        format!("Meta Data\nSavedAs,a.OPDx\n\nData\nLateral(µm),Raw(Å),,\n{text}"),
    )
    .unwrap();
    let found = surface(folder.path(), "stats line.csv --l-filter 0.4mm --json");
    let json = found.json(0);
    // Waves of 2 µm and 50 µm; the filter transmits 1 − 2^−64 of them.
    let known =
        [("Ra_m", 1.2732e-6), ("Rq_m", 1.4142e-6), ("Rz_m", 4e-6), ("RSm_m", 5e-5), ("Rdq", 0.17769), ("dx_m", 5e-7)];
    known.iter().for_each(|(key, wanted)| close(number(&json, key), *wanted, 0.02));
    assert_eq!((number(&json, "sections"), number(&json, "nx")), (5.0, 4000.0));
    assert!(json["Rz_m_interval"].is_array() && json["format"] == "text", "{json}");
    let primary = surface(folder.path(), "stats line.csv");
    assert!(primary.code == 0 && primary.stderr.contains("primary profile"), "{primary:?}");
    surface(folder.path(), "fill line.csv --seed 1 --out out.x3p")
        .refuses(3, &["line.csv", "a profile of 4000 points", "isotropic = true"]);
    surface(folder.path(), "stats line.csv --l-filter 9mm").refuses(2, &["line.csv", "L-filter"]);
    let started = run_in(folder.path(), "init my --scan line.csv");
    assert_eq!(started.code, 0, "{started:?}");
    let study = fs::read_to_string(folder.path().join("my/study.toml")).unwrap();
    assert!(study.contains("isotropic = true") && study.contains("file = \"line.csv\""), "{study}");
}

#[test]
fn a_conversion_that_cannot_be_done_leaves_nothing_behind() {
    let folder = TempDir::new().unwrap();
    npy(folder.path(), "map.npy", array![[1e-6, 2e-6], [3e-6, 4e-6]]);
    let scan = Scan::new(Array2::zeros((16, 16)), Some((1e-6, 1e-6)));
    let whole = write_x3p(&scan).unwrap();
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
        ("convert map.npy out.npy --level plane", 2, vec!["map.npy", "pixel size"]),
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

#[test]
fn a_hundred_and_one_modes_capture_the_published_variance_of_a_square() {
    for (covariance, length, share) in
        [("exponential", "0.1m", 0.665), ("squared_exponential", "0.1m", 0.940), ("exponential", "0.2m", 0.839)]
    {
        let line = format!(
            "surface modes --covariance {covariance} --correlation-length {length} --size 1m,1m --points 256,256 \
             --modes 101 --json"
        );
        let json = asperity(&line).json(0);
        // The published fractions have three digits; the midpoint rule adds 5e-4 at 256 points.
        assert!((number(&json, "captured_variance") - share).abs() < 1e-3, "{covariance} {length}: {json}");
        assert_eq!(json["eigenvalues"].as_array().unwrap().len(), 101);
        assert_eq!(json["eigenvalue_unit"], "m^2");
    }
}

#[test]
fn modes_that_do_not_exist_are_usage_errors() {
    let line = "surface modes --covariance self-affine --correlation-length 1m --size 1m --points 8 --modes 2";
    asperity(line).refuses(2, &["--hurst", "self-affine"]);
    let line = "surface modes --covariance matern --hurst 0.5 --correlation-length 1m --size 1m --points 8 --modes 2";
    asperity(line).refuses(2, &["--hurst", "self_affine"]);
    let base = "surface modes --covariance exponential --json";
    for (line, words) in [
        ("--size 1m --points 8 --modes 9", ["9 modes", "8"]),
        ("--size 1m,1m --points 8 --modes 4", ["2 sizes", "1 numbers"]),
        ("--size 1m --points 0 --modes 4", ["--points", "at least 1"]),
        ("--size 1m --points 8 --modes 0", ["--modes", "at least 1"]),
        ("--size 1m --points 8 --modes 4 --correlation-length 1m,2m", ["--correlation-length", "rectangle"]),
        ("--size -1m --points 8 --modes 4", ["--size", "above 0"]),
        ("--size 1 --points 8 --modes 4", ["--size", "no unit"]),
    ] {
        let length = if line.contains("--correlation-length") { "" } else { "--correlation-length 1m" };
        asperity(&format!("{base} {length} {line}")).refuses(2, &words);
    }
    asperity("surface modes --covariance exponentil --correlation-length 1m --size 1m --points 8 --modes 1")
        .refuses(2, &["exponentil", "exponential"]);
}

/// One sine of 1 µm amplitude, ten periods along x, whose parameters have closed forms.
fn sine() -> Array2<f64> {
    Array2::from_shape_fn((40, 400), |(_, column)| 1e-6 * (std::f64::consts::TAU * (column as f64 + 0.5) / 40.0).sin())
}

#[test]
fn the_parameters_of_a_sine_have_their_closed_forms() {
    let folder = TempDir::new().unwrap();
    npy(folder.path(), "sine.npy", sine());
    let json = surface(folder.path(), "stats sine.npy --pixel-size 1um,2um --level mean --json").json(0);
    for (key, wanted) in [("nx", 400.0), ("ny", 40.0), ("dx_m", 1e-6), ("dy_m", 2e-6), ("missing_points", 0.0)] {
        assert_eq!(number(&json, key), wanted, "{key}");
    }
    // Even moments are exact on equally spaced points of a whole period.
    close(number(&json, "Sq_m"), 1e-6 / 2.0_f64.sqrt(), 1e-12);
    close(number(&json, "Sku"), 1.5, 1e-12);
    assert!(number(&json, "Ssk").abs() < 1e-12);
    close(number(&json, "Sa_m"), 2e-6 / std::f64::consts::PI, 2e-3);
    // Forward differences over h: √2πA/P times sinc(h/P), here P = 40 h.
    let phase = std::f64::consts::PI / 40.0;
    let slope = 2.0_f64.sqrt() * std::f64::consts::PI * 1e-6 / 40e-6 * phase.sin() / phase;
    // The last column has no forward neighbour; the others cover all phases but one.
    close(number(&json, "Sdq"), slope, 2e-3);
}

/// A map of white noise, smoothed over 5 × 5 points.
fn noise(seed: u64, side: usize) -> Array2<f64> {
    // A linear congruential generator is sufficient.
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24) - 0.5
    };
    let white = Array2::from_shape_simple_fn((side + 4, side + 4), &mut next);
    Array2::from_shape_fn((side, side), |(row, column)| {
        1e-6 * white.slice(ndarray::s![row..row + 5, column..column + 5]).sum()
    })
}

#[test]
fn statistics_of_a_map_come_with_their_intervals() {
    let folder = TempDir::new().unwrap();
    npy(folder.path(), "a.npy", noise(1, 128));
    let json = surface(folder.path(), "stats a.npy --pixel-size 1um --json").json(0);
    for key in "Sa_m Sq_m Ssk Sku Sdq Sal_m Sk_m Spk_m Svk_m correlation_length_x_m correlation_length_y_m".split(' ') {
        let (value, se) = (number(&json, key), number(&json, &format!("{key}_se")));
        let ends = &json[format!("{key}_interval")];
        let (low, high) = (ends[0].as_f64().unwrap(), ends[1].as_f64().unwrap());
        assert!(low < value && value < high && se > 0.0 && high - low < 8.0 * se, "{key}: {value} {ends} {se}");
    }
    let table = surface(folder.path(), "stats a.npy --pixel-size 1um").stdout;
    let line = table.lines().find(|line| line.starts_with("Sq ")).unwrap();
    assert!(line.contains("(95 %: ") && line.contains(" to ") && !table.contains("interval"), "{table}");
    // The labels name the definition of the correlation length.
    assert!(table.contains("correlation length x (1/e)") && table.contains("correlation length y (1/e)"), "{table}");
    // A sine is no sample of a random surface: the table shows no intervals.
    npy(folder.path(), "sine.npy", sine());
    let json = surface(folder.path(), "stats sine.npy --pixel-size 1um --json").json(0);
    assert!(json["Sku_interval"].is_null() || json["Sku_interval"].is_array(), "{json}");
}

#[test]
fn several_scans_are_pooled() {
    let folder = TempDir::new().unwrap();
    npy(folder.path(), "a.npy", noise(1, 128));
    npy(folder.path(), "b.npy", noise(2, 96) * 1.2);
    let single = |file: &str| surface(folder.path(), &format!("stats {file} --pixel-size 1um --json")).json(0);
    let (a, b) = (single("a.npy"), single("b.npy"));
    let both = surface(folder.path(), "stats a.npy b.npy --pixel-size 1um --json").json(0);
    let (value, ends) = (number(&both, "Sq_m"), &both["Sq_m_interval"]);
    assert!(number(&a, "Sq_m") < value && value < number(&b, "Sq_m"));
    assert!(ends[0].as_f64().unwrap() < value && value < ends[1].as_f64().unwrap());
    for key in ["Sq_m_se", "Sq_m_within_std", "Sq_m_between_std", "Sdr_interval"] {
        assert!(both.get(key).is_some_and(|value| !value.is_null()), "{key}: {both}");
    }
    assert_eq!(both["scan_count"], 2);
    assert_eq!(both["scans"][0]["file"], "a.npy");
    assert_eq!(both["scans"][1]["Sq_m"], b["Sq_m"]);
    let table = surface(folder.path(), "stats a.npy b.npy --pixel-size 1um").stdout;
    let line = table.lines().find(|line| line.starts_with("Sq ")).unwrap();
    assert!(line.contains("(95 %: ") && line.contains("between scans"), "{table}");
    for (second, words) in [("gone.npy", ["gone.npy", "no such file"]), ("flat.npy", ["flat.npy", ""])] {
        npy(folder.path(), "flat.npy", Array2::from_elem((8, 8), 1e-6));
        surface(folder.path(), &format!("stats a.npy {second} --pixel-size 1um --json")).refuses(3, &words);
    }
}

#[test]
fn maps_without_statistics_are_unusable_data_and_a_missing_pixel_size_is_a_usage_error() {
    let folder = TempDir::new().unwrap();
    npy(folder.path(), "sine.npy", sine());
    npy(folder.path(), "flat.npy", Array2::from_elem((8, 8), 1e-6));
    npy(folder.path(), "point.npy", Array2::zeros((1, 1)));
    npy(folder.path(), "void.npy", Array2::from_elem((8, 8), f64::NAN));
    npy(folder.path(), "tilted.npy", Array2::from_shape_fn((16, 32), |(r, c)| 1e-9 * (r + 2 * c) as f64 + 3e-6));
    for (line, code, words) in [
        ("stats sine.npy", 2, vec!["sine.npy", "--pixel-size"]),
        ("stats sine.npy --pixel-size 1um --level cubic", 2, vec!["--level", "cubic", "quadratic"]),
        ("stats flat.npy --pixel-size 1um", 3, vec!["flat.npy"]),
        ("stats tilted.npy --pixel-size 1um", 3, vec!["once the form (plane) is removed, all 512 heights", "equal"]),
        ("stats flat.npy --pixel-size 1um --level none", 3, vec!["flat.npy: surface: all 64 heights", "equal"]),
        ("stats sine.npy --pixel-size 1e-155m", 2, vec!["--pixel-size", "between 1e-15 m and 1e3 m"]),
        ("stats sine.npy --pixel-size 1um,2e3m", 2, vec!["--pixel-size", "between 1e-15 m and 1e3 m"]),
        ("stats sine.npy --pixel-size 1e400m", 2, vec!["--pixel-size", "`1e400m` is out of range"]),
        ("stats point.npy --pixel-size 1um", 3, vec!["point.npy", "1 × 1"]),
        ("stats void.npy --pixel-size 1um", 3, vec!["void.npy", "all 64"]),
        ("stats gone.npy --pixel-size 1um", 3, vec!["gone.npy", "no such file"]),
    ] {
        surface(folder.path(), &format!("{line} --json")).refuses(code, &words);
    }
}

/// Heights in metres with the correlation e^{−(|x| + |y|)/5}, in points, by recursion, with a missing rectangle.
fn rough_with_a_void() -> Array2<f64> {
    let (ny, nx, memory) = (72, 80, (-0.2_f64).exp());
    let mut state = 7_u64;
    let mut noise = || {
        let mut sum = -6.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    };
    let mut heights = Array2::<f64>::zeros((ny, nx));
    for row in 0..ny {
        for column in 0..nx {
            let at = |up: usize, left: usize| match (row.checked_sub(up), column.checked_sub(left)) {
                (Some(row), Some(column)) => heights[[row, column]],
                _ => 0.0,
            };
            heights[[row, column]] = memory * (at(1, 0) + at(0, 1)) - memory * memory * at(1, 1) + 1e-7 * noise();
        }
    }
    heights.slice_mut(ndarray::s![20..40, 30..60]).fill(f64::NAN);
    heights
}

#[test]
#[ignore = "slow"]
fn filling_keeps_measured_heights_and_counts_the_filled_ones() {
    let folder = TempDir::new().unwrap();
    let measured = rough_with_a_void();
    npy(folder.path(), "map.npy", measured.clone());
    let bits = |map: &Array2<f64>| map.iter().map(|z| z.to_bits()).collect::<Vec<_>>();
    let filled = |name: &str| read(&folder.path().join(name)).unwrap().heights_m;

    let found = surface(folder.path(), "fill map.npy --pixel-size 1um --out out.npy --seed 3");
    assert_eq!((found.code, found.stdout.as_str()), (0, ""), "{found:?}");
    assert!(found.stderr.contains("600 of 5760 heights (10.4 %) are filled in, 5160 are measured"), "{found:?}");
    let out = filled("out.npy");
    assert!(out.iter().all(|z| z.is_finite()));
    let kept = measured.iter().zip(&out).filter(|(z, _)| !z.is_nan());
    assert!(kept.into_iter().all(|(before, after)| before.to_bits() == after.to_bits()));
    // The result depends on the seed alone.
    assert_eq!(surface(folder.path(), "fill map.npy --pixel-size 1um --out same.npy --seed 3 --threads 1").code, 0);
    assert_eq!(bits(&filled("same.npy")), bits(&out));
    assert_eq!(surface(folder.path(), "fill map.npy --pixel-size 1um --out other.npy --seed 4").code, 0);
    assert_ne!(bits(&filled("other.npy")), bits(&out));

    let line = "fill map.npy --pixel-size 1um --out maps --seed 3 --count 2 --extend 4um,2.5um --marginal normal \
                --covariance fitted";
    let several = surface(folder.path(), line);
    assert_eq!(several.code, 0, "{several:?}");
    assert_eq!(written(&folder.path().join("maps")), ["map_0000.x3p", "map_0001.x3p"]);
    let wide = filled("maps/map_0001.x3p");
    assert_eq!(wide.dim(), (72 + 6, 80 + 8));
    assert_eq!(wide[[3, 4]].to_bits(), measured[[0, 0]].to_bits());
    assert_ne!(bits(&wide), bits(&filled("maps/map_0000.x3p")));
    // The first of two maps equals the single map.
    let line =
        "fill map.npy --pixel-size 1um --out one.x3p --seed 3 --extend 4um,2.5um --marginal normal --covariance fitted";
    assert_eq!(surface(folder.path(), line).code, 0);
    assert_eq!(bits(&filled("one.x3p")), bits(&filled("maps/map_0000.x3p")));
}

#[test]
fn a_failed_filling_gives_a_reason_and_leaves_no_file() {
    let folder = TempDir::new().unwrap();
    npy(folder.path(), "map.npy", rough_with_a_void());
    npy(folder.path(), "flat.npy", Array2::from_shape_fn((16, 16), |(r, _)| if r > 8 { f64::NAN } else { 1e-6 }));
    let before = listing(folder.path());
    for (line, code, words) in [
        ("fill map.npy --pixel-size 1um --out out.npy", 2, vec!["--seed"]),
        ("fill map.npy --out out.npy --seed 1", 2, vec!["map.npy", "pixel size"]),
        ("fill map.npy --pixel-size 1um --out out.npy --seed 1 --nugget 2", 2, vec!["nugget", "[0, 1]"]),
        ("fill map.npy --pixel-size 1um --out out.npy --seed 1 --extend -1um", 2, vec!["--extend", "negative"]),
        (
            "fill map.npy --pixel-size 1um --out out.npy --seed 1 --extend 1um,1e30m",
            5,
            vec!["filling a map of this size"],
        ),
        ("fill flat.npy --pixel-size 1um --out out.npy --seed 1", 3, vec!["flat.npy", "equal"]),
        ("fill gone.npy --pixel-size 1um --out out.npy --seed 1", 3, vec!["gone.npy"]),
        ("fill map.npy --pixel-size 1um --out map.npy --seed 1", 2, vec!["map.npy", "is an input"]),
    ] {
        surface(folder.path(), line).refuses(code, &words);
    }
    assert_eq!(listing(folder.path()), before);
}
