use std::fs;

use asperity_formats::{Format, FormatError, Scan, read, temporary_suffix, write};
use ndarray::array;

use crate::bits;
use crate::check::assert_error;
use crate::fixture::read_bytes;
use crate::fixtures::{Sur, TEXT, X3p, npy};
use crate::memory::peak_bytes;

fn scan() -> Scan {
    Scan::new(array![[1e-6, f64::NAN], [3e-6, -4e-6]], Some((2e-6, 3e-6)))
}

#[test]
fn the_content_decides_and_not_the_name() {
    let folder = tempfile::tempdir().unwrap();
    let array = npy(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1), }", &1e-6_f64.to_le_bytes());
    for (format, bytes) in [
        (Format::X3p, X3p::default().bytes()),
        (Format::Sur, Sur::default().bytes()),
        (Format::Npy, array),
        (Format::Text, TEXT.to_vec()),
    ] {
        assert_eq!(Format::detect(&bytes), Some(format));
        let path = folder.path().join("scan.sdf");
        fs::write(&path, &bytes).unwrap();
        assert_eq!(bits(&read(&path).unwrap()), bits(&read_bytes(&bytes).unwrap()));
    }
}

#[test]
fn unknown_content_is_shown() {
    for (bytes, start) in [
        (&b""[..], "the file is empty; known formats are"),
        (b"\x00\x01BCR", "5 bytes that start with `\\x00\\x01BCR`"),
    ] {
        assert_eq!(Format::detect(bytes), None);
        let error = read_bytes(bytes).unwrap_err();
        assert!(matches!(error, FormatError::Unrecognised { .. }) && error.to_string().contains(start), "{error}");
    }
}

#[test]
fn the_extension_decides_the_written_format() {
    let folder = tempfile::tempdir().unwrap();
    for (name, format, keeps_pitch) in
        [("a.X3P", Format::X3p, true), ("a.npy", Format::Npy, false), ("a.csv", Format::Text, true)]
    {
        let path = folder.path().join(name);
        write(&scan(), &path).unwrap();
        assert_eq!(Format::detect(&fs::read(&path).unwrap()), Some(format));
        assert_eq!((format.stores_pitch(), read(&path).unwrap().format), (keeps_pitch, Some(format)));
    }
    let csv = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert_eq!(csv, "# unit: m\n# pixel size: 2e-6 m x 3e-6 m\n1e-6,nan\n3e-6,-4e-6\n");
    for (name, wanted) in
        [("a.opd", "as `.opd`; wanted .x3p"), ("a.XYZ", "`.xyz`"), ("a", "no extension"), (".x3p", "no ext")]
    {
        let error = write(&scan(), &folder.path().join(name)).unwrap_err();
        assert!(error.to_string().contains(wanted), "{error}");
    }
}

#[test]
fn a_file_is_replaced_as_a_whole_without_leftovers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.x3p");
    fs::write(&path, "old").unwrap();
    let without_pitch = Scan { pitch_m: None, ..scan() };
    let error = write(&without_pitch, &path).unwrap_err();
    assert!(
        matches!(&error, FormatError::File { error, .. } if matches!(**error, FormatError::NoPitch { .. })),
        "{error}"
    );
    assert_eq!(fs::read(&path).unwrap(), b"old");
    write(&scan(), &path).unwrap();
    assert_eq!(bits(&read(&path).unwrap()), bits(&scan()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn errors_name_the_path_and_a_missing_file_is_its_own_kind() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("none.x3p");
    let error = read(&missing).unwrap_err();
    assert!(matches!(error, FormatError::NotFound { .. }));
    assert_eq!(error.to_string(), format!("{}: no such file or folder", missing.display()));
    let error = read(folder.path()).unwrap_err();
    assert!(matches!(&error, FormatError::Io { path, .. } if path == folder.path()), "{error}");
    assert!(error.to_string().ends_with("this is a folder; a file is wanted"), "{error}");
    let ragged = folder.path().join("ragged.csv");
    fs::write(&ragged, "1,2\n3\n").unwrap();
    let error = read(&ragged).unwrap_err();
    assert_eq!(error.to_string(), format!("{}: text: line 2 has 1 values; the first row has 2", ragged.display()));
    let error = write(&scan(), &folder.path().join("no folder/a.npy")).unwrap_err();
    assert!(
        matches!(error, FormatError::NotFound { .. }) && error.to_string().contains("no folder: no such"),
        "{error}"
    );
}

#[test]
fn long_content_of_no_known_format_is_not_read_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.dat");
    let file = fs::File::create(&path).unwrap();
    // A terabyte of zeros that takes no room.
    file.set_len(1 << 40).unwrap();
    let (result, peak) = peak_bytes(|| read(&path));
    assert_error(result, "film.dat: unknown format: 1099511627776 bytes");
    assert!(peak < 1 << 20, "{peak}");
}

#[test]
fn long_names_are_written_and_left_over_temporary_files_are_no_hindrance() {
    let folder = tempfile::tempdir().unwrap();
    // The next two hundred names.
    let next = temporary_suffix();
    let (process, count) = next.rsplit_once('-').unwrap();
    for count in (count.parse::<u64>().unwrap() + 1..).take(200) {
        fs::write(folder.path().join(format!(".asperity-{process}-{count}.tmp")), "others").unwrap();
    }
    let path = folder.path().join(format!("{}.npy", "n".repeat(251)));
    // Each attempt passes over a hundred names.
    let written = (0..3).any(|_| write(&scan(), &path).is_ok());
    assert!(written && bits(&read(&path).unwrap()) == bits(&scan()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 201);
}
