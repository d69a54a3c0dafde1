//! Tests of written maps: a replaced file is reported, a folder appears complete or not at all, inputs are never
//! overwritten.

use std::fs;
use std::path::Path;

use asperity_formats::read;
use tempfile::TempDir;

use crate::support::{Finished, listing, run_in, written};

pub(crate) const SPECIFICATION: &str = "seed = 3\nsize = [\"32 um\", \"24 um\"]\npoints = [32, 24]\n[surface]\n\
                             covariance = \"exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\n\
                             correlation_length = \"4 um\"\ngenerator = \"spectral\"\n";

fn surface(at: &Path, line: &str) -> Finished {
    run_in(at, &format!("surface {line}"))
}

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("spec.toml"), SPECIFICATION).unwrap();
    folder
}

/// A folder that also contains a map with a missing corner.
fn folder_with_scan() -> TempDir {
    let folder = folder();
    let at = folder.path();
    assert_eq!(surface(at, "generate spec.toml --out whole.npy --quiet").code, 0);
    let mut scan = read(&at.join("whole.npy")).unwrap();
    scan.heights_m.indexed_iter_mut().filter(|((r, c), _)| r + c < 6).for_each(|(_, z)| *z = f64::NAN);
    scan.pitch_m = Some((1e-6, 1e-6));
    asperity_formats::write(&scan, &at.join("scan.x3p")).unwrap();
    fs::remove_file(at.join("whole.npy")).unwrap();
    folder
}

#[test]
fn an_existing_file_is_replaced_with_a_message() {
    let folder = folder_with_scan();
    let at = folder.path();
    for line in ["generate spec.toml --out a.x3p", "fill scan.x3p --seed 1 --out b.x3p", "convert scan.x3p c.x3p"] {
        let (name, first) = (line.rsplit(' ').next().unwrap(), surface(at, line));
        assert!(first.code == 0 && first.stderr.contains(&format!("wrote {name}")), "{first:?}");
        fs::write(at.join(name), "old").unwrap();
        let second = surface(at, line);
        assert!(second.code == 0 && second.stderr.contains(&format!("replaced {name}")), "{second:?}");
        assert!(read(&at.join(name)).is_ok());
        // `--force` changes nothing for files.
        if !line.starts_with("convert") {
            assert_eq!(surface(at, &format!("{line} --force")).code, 0);
        }
    }
    assert_eq!(listing(at), ["a.x3p", "b.x3p", "c.x3p", "scan.x3p", "spec.toml"]);
}

#[test]
fn inputs_are_not_overwritten() {
    let folder = folder_with_scan();
    let at = folder.path();
    fs::create_dir(at.join("in")).unwrap();
    fs::rename(at.join("scan.x3p"), at.join("in/scan.x3p")).unwrap();
    let measured =
        SPECIFICATION.replace("covariance = \"exponential\"", "file = \"scan.x3p\"\ncovariance = \"exponential\"");
    fs::write(at.join("in/measured.toml"), measured).unwrap();
    let bytes = fs::read(at.join("in/scan.x3p")).unwrap();
    for line in [
        "generate in/measured.toml --out in/scan.x3p",
        "fill in/scan.x3p --seed 1 --out ./in/../in/scan.x3p --force",
        "convert in/scan.x3p in/scan.x3p",
    ] {
        surface(at, line).refuses(2, &["scan.x3p", "is an input"]);
    }
    for line in
        ["generate in/measured.toml --count 2 --out in --force", "fill in/scan.x3p --seed 1 --count 2 --out in --force"]
    {
        surface(at, line).refuses(2, &["in contains", "the input"]);
    }
    assert_eq!(fs::read(at.join("in/scan.x3p")).unwrap(), bytes);
    assert_eq!(listing(at), ["in", "spec.toml"]);
    assert_eq!(listing(&at.join("in")), ["measured.toml", "scan.x3p"]);
}

#[test]
fn a_folder_contains_the_maps_of_one_run_and_only_force_replaces_it() {
    let folder = folder_with_scan();
    let at = folder.path();
    for (name, line) in [("drawn", "generate spec.toml"), ("filled", "fill scan.x3p")] {
        let out = at.join(name);
        let run =
            |count: usize, more: &str| surface(at, &format!("{line} --seed 1 --count {count} --out {name} {more}"));
        assert_eq!(run(3, "").code, 0);
        // Maps of two runs must not mix in one folder.
        let before = fs::read(out.join("map_0000.x3p")).unwrap();
        run(2, "").refuses(2, &[name, "not empty", "--force"]);
        surface(at, &format!("{line} --seed 2 --out {name}")).refuses(2, &[name, "not empty"]);
        assert_eq!(written(&out), ["map_0000.x3p", "map_0001.x3p", "map_0002.x3p"]);
        assert_eq!(fs::read(out.join("map_0000.x3p")).unwrap(), before);
        assert_eq!(run(2, "--force").code, 0);
        assert_eq!(written(&out), ["map_0000.x3p", "map_0001.x3p"]);
        // An empty folder may be replaced; a file is no folder.
        fs::create_dir(at.join("empty")).unwrap();
        let found = surface(at, &format!("{line} --seed 1 --out empty"));
        assert!(found.code == 0 && found.stderr.contains("wrote empty"), "{found:?}");
        assert_eq!(written(&at.join("empty")), ["map_0000.x3p"]);
        fs::remove_dir_all(at.join("empty")).unwrap();
        surface(at, &format!("{line} --seed 1 --count 2 --out spec.toml --force")).refuses(2, &["spec.toml", "folder"]);
    }
    let nameless = at.join("nameless");
    fs::create_dir(&nameless).unwrap();
    surface(&nameless, "generate ../spec.toml --count 2 --out .").refuses(2, &["--out", "does not name a folder"]);
    assert!(listing(&nameless).is_empty());
    assert_eq!(listing(at), ["drawn", "filled", "nameless", "scan.x3p", "spec.toml"]);
}

#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_and_failures_leave_no_partial_folder() {
    let folder = folder_with_scan();
    let at = folder.path();
    for line in ["generate spec.toml", "fill scan.x3p"] {
        let line = format!("surface {line} --seed 1 --count 1000000 --out deep/maps");
        let (found, _) = crate::support::run_and_interrupt(at, &line);
        assert_eq!((found.code, found.stdout.as_str()), (130, ""), "{found:?}");
        assert_eq!(listing(at), ["scan.x3p", "spec.toml"]);
    }
    fs::write(at.join("wide.toml"), SPECIFICATION.replace("\"32 um\"", "\"1e30 m\"")).unwrap();
    surface(at, "generate wide.toml --count 2 --out deep/maps").refuses(2, &["wide.toml", "between 1e-15 m and 1e3 m"]);
    assert_eq!(listing(at), ["scan.x3p", "spec.toml", "wide.toml"]);
}

#[test]
fn a_run_cites_the_works_of_its_methods_alone() {
    let folder = tempfile::TempDir::new().unwrap();
    let at = folder.path();
    let surface = |generator: &str, marginal: &str| {
        format!(
            "seed = 1\n[surface]\ncovariance = \"exponential\"\nrms_height = \"1 um\"\ncorrelation_length = \"20 um\"\n\
             marginal = \"{marginal}\"\ngenerator = \"{generator}\"\n"
        )
    };
    for (text, wanted, others) in [
        (surface("spectral", "normal"), &["Dietrich", "ISO 25178-2"][..], &["Ghanem", "Grigoriu", "Tabor", "Owen"][..]),
        (surface("karhunen_loeve", "beta:2.1,5"), &["Ghanem", "Grigoriu"], &["Dietrich", "Stanley"]),
    ] {
        std::fs::write(at.join("study.toml"), text).unwrap();
        assert_eq!(run_in(at, "run study.toml --out run --force").code, 0);
        let found = run_in(at, "cite run").stdout;
        assert!(found.starts_with("N. Gaus, C. Proppe, C. Zaccardi: "), "{found}");
        assert!(wanted.iter().all(|name| found.contains(name)), "{found}");
        assert!(!others.iter().any(|name| found.contains(name)), "{found}");
        // The report has the same.
        let report = std::fs::read_to_string(at.join("run/report.html")).unwrap();
        assert!(found.lines().all(|line| report.contains(&line.replace('\'', "&#39;"))), "{found}");
        let entries = run_in(at, "cite run --bibtex").stdout;
        assert!(entries.starts_with("@software{asperity,"), "{entries}");
        assert_eq!(entries.matches("\n@").count(), found.lines().count());
        assert_eq!(entries.matches('{').count(), entries.matches('}').count());
    }
    run_in(at, "cite nowhere").refuses(3, &["nowhere"]);
}
