//! NPZ: zip archives of NPY files.

use std::io::{Cursor, Write};

use asperity_formats::{Format, Scan};

use crate::assert_heights;
use crate::check::{assert_error, assert_refused, assert_scan, assert_warns, bytes, patched};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::fixtures::{npy, zip};

fn array(descr: &str, column_major: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if column_major { "True" } else { "False" };
    npy(1, &format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n"), data)
}

fn f8(shape: &str, values: &[f64]) -> Vec<u8> {
    array("<f8", false, shape, &bytes![values])
}

fn map(values: &[f64; 6]) -> Vec<u8> {
    f8("(2, 3)", values)
}

const GAP: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, f64::INFINITY];

/// Returns arrays as stored by a contact solution.
fn contact() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("pressure_pa.npy", map(&[0.0; 6])),
        ("displacement_m.npy", map(&[7.0; 6])),
        ("gap_m.npy", map(&GAP)),
        ("pitch_m.npy", f8("(2,)", &[2e-6, 3e-6])),
    ]
}

fn archive(files: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
    zip(&files)
}

/// An archive whose files are deflated.
fn deflated(files: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        archive.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let contact = contact();
    let files: Vec<(&str, &[u8])> = contact.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
    let turned = array("<i2", true, "(2, 3)", &[7; 12]);
    vec![
        Fixture::zip("NPZ of a contact", &files),
        Fixture::zip("NPZ in column order", &[("height_um.npy", &turned), ("dx.npy", &f8("()", &[1e-6]))]),
        Fixture::whole("NPZ deflated", deflated(&contact)),
    ]
}

fn read(files: &[(&str, Vec<u8>)]) -> Scan {
    read_bytes(&archive(files)).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn two_dimensional_arrays_of_lengths_are_channels_by_name() {
    for bytes in [archive(&contact()), deflated(&contact())] {
        let scan = assert_scan(&bytes, Format::Npz, (2, 3), (2e-6, 3e-6), &[7.0; 6]);
        assert_eq!((scan.channels.as_slice(), scan.channel), (&["displacement_m".into(), "gap_m".into()][..], 0));
        assert_warns(&scan, "left out: pressure_pa");
        let gap = read_channel(&bytes, "gap_m").unwrap();
        assert_heights(&gap, &[1.0, 2.0, 3.0, 4.0, 5.0, f64::NAN]);
        assert_eq!(gap.pitch_m, Some((2e-6, 3e-6)));
        assert_eq!(gap.metadata["pitch_m"], "0.000002, 0.000003");
        assert_error(read_channel(&bytes, "pressure_pa"), "no height map");
    }
}

#[test]
fn an_array_named_height_or_z_is_the_main_map() {
    for (main, value) in [("z.npy", 5.0), ("heights_m.npy", 5.0), ("Height_um.npy", 5e-6)] {
        let scan = read(&[("x.npy", map(&[1.0; 6])), (main, map(&[5.0; 6]))]);
        assert_eq!(scan.channel, 1);
        assert_heights(&scan, &[value; 6]);
    }
}

#[test]
fn names_state_units() {
    for (name, per_metre) in
        [("a_nm", 1e9), ("a_UM", 1e6), ("a_µm", 1e6), ("a_mm", 1e3), ("a_m", 1.0), ("a", 1.0), ("height_map", 1.0)]
    {
        assert_heights(&read(&[(&format!("{name}.npy"), map(&[3.0; 6]))]), &[3.0 / per_metre; 6]);
    }
    for name in ["p_pa", "p_MPa", "load_n", "slope_m_per_m", "compliance_m_per_pa", "phase_deg"] {
        let error = read_bytes(&archive(&[(&format!("{name}.npy"), map(&[3.0; 6]))])).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
}

#[test]
fn short_arrays_state_the_pitch() {
    for (files, pitch_m, warnings) in [
        (vec![("pixel_size_um.npy", f8("()", &[2.0]))], Some((2e-6, 2e-6)), 0),
        (vec![("spacing.npy", f8("(1,)", &[2e-6]))], Some((2e-6, 2e-6)), 0),
        (vec![("pitch_nm.npy", array("<i4", false, "(2,)", &bytes![[1, 2]]))], Some((1e-9, 2e-9)), 0),
        (vec![("dx.npy", f8("()", &[1e-6])), ("dy_um.npy", f8("()", &[2.0]))], Some((1e-6, 2e-6)), 0),
        (vec![("dx.npy", f8("()", &[1e-6]))], Some((1e-6, 1e-6)), 1),
        (vec![("dy.npy", f8("()", &[1e-6]))], None, 0),
        (vec![("pitch.npy", f8("(3,)", &[1.0; 3]))], None, 1),
        (vec![("pitch_pa.npy", f8("()", &[1.0]))], None, 0),
        (vec![], None, 0),
    ] {
        let scan = read(&[vec![("z.npy", map(&[0.0; 6]))], files].concat());
        assert_eq!((scan.pitch_m, scan.warnings.len()), (pitch_m, warnings));
    }
}

#[test]
fn rows_and_columns_follow_the_stated_order() {
    let data: Vec<u8> = (1..=6_i16).flat_map(i16::to_be_bytes).collect();
    let rows = read(&[("z.npy", array(">i2", false, "(2, 3)", &data))]);
    assert_eq!(rows.heights_m, ndarray::array![[1., 2., 3.], [4., 5., 6.]]);
    let columns = read(&[("z.npy", array(">i2", true, "(2, 3)", &data))]);
    assert_eq!(columns.heights_m, ndarray::array![[1., 3., 5.], [2., 4., 6.]]);
    assert!(columns.heights_m.is_standard_layout());
}

#[test]
fn numbers_across_the_pieces_of_a_deflated_stream_are_whole() {
    let values: Vec<f64> = (0..300 * 200).map(|i| f64::from(i).sqrt()).collect();
    let bytes = deflated(&[("z.npy", f8("(300, 200)", &values))]);
    assert_heights(&read_bytes(&bytes).unwrap(), &values);
    let turned: Vec<u8> = values.iter().flat_map(|z| (*z as f32).to_le_bytes()).collect();
    let scan = read_bytes(&deflated(&[("z.npy", array("<f4", true, "(300, 200)", &turned))])).unwrap();
    assert_eq!(scan.heights_m[[7, 11]], f64::from(values[11 * 300 + 7] as f32));
}

#[test]
fn a_flat_map_unpacks_and_a_bomb_does_not() {
    let flat = deflated(&[("z.npy", f8("(1024, 1024)", &vec![0.0; 1 << 20]))]);
    assert!(flat.len() < 1 << 15);
    assert_eq!(read_bytes(&flat).unwrap().heights_m.dim(), (1024, 1024));
    let bomb = deflated(&[("z.npy", array("<i1", false, "(8192, 8192)", &vec![0; 1 << 26]))]);
    assert_error(read_bytes(&bomb), "more than 256 times as many");
}

#[test]
fn arrays_other_than_maps_of_numbers_are_left_out() {
    let scan = read(&[
        ("name.npy", array("<U3", false, "()", &[0; 12])),
        ("valid.npy", array("|b1", false, "(2, 3)", &[1; 6])),
        ("x.npy", f8("(9,)", &[0.0; 9])),
        ("stack.npy", f8("(1, 2, 3)", &[0.0; 6])),
        ("none.npy", f8("(0, 3)", &[])),
        ("z.npy", map(&[1.0; 6])),
        ("readme.txt", b"no array".to_vec()),
    ]);
    assert_eq!(scan.channels, ["z"]);
    assert_eq!(scan.warnings, ["arrays other than heights were left out: name, valid, x, stack, none"]);
}

#[test]
fn declared_sizes_are_not_believed() {
    for (array, words) in [
        (f8("(99999, 99999)", &[]), "the limit is"),
        (f8("(4096, 4096)", &[0.0; 2]), "stop after 16 bytes; wanted 134217728"),
        (f8("(4096, 4096)", &[0.0; 2]), "z.npy, byte"),
        (patched(&map(&[0.0; 6]), 8, u16::MAX), "stop after"),
        (b"no array".to_vec(), "z.npy"),
    ] {
        assert_refused([(archive(&[("z.npy", array)]), words)]);
    }
}

#[test]
fn other_archives_are_not_claimed() {
    assert_eq!(Format::detect(&archive(&[("main.xml", Vec::new()), ("z.npy", Vec::new())])), Some(Format::X3p));
    assert_eq!(Format::detect(b"PK\x03\x04"), None);
}
