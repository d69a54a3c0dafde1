//! Formats that are recognised and not read, each from the first bytes that its description gives.

use std::fs;

use asperity_formats::{Format, FormatError, read};

use crate::check::assert_error;
use crate::datx::hdf5::Hdf5;
use crate::fixture::read_bytes;
use crate::fixtures::{gzip, zip};

fn refusal(bytes: &[u8]) -> String {
    let error = read_bytes(bytes).unwrap_err();
    assert!(matches!(error, FormatError::NotRead { .. }), "{error}");
    error.to_string()
}

/// An Igor wave of version 2: 126 bytes of headers whose 16-bit numbers sum up to zero.
fn igor_wave(is_big_endian: bool) -> Vec<u8> {
    let number = |n: u16| if is_big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
    let mut bytes = vec![0; 126 + 16];
    bytes[..2].copy_from_slice(&number(2));
    bytes[2..4].copy_from_slice(&number(2_u16.wrapping_neg().wrapping_sub(1234)));
    bytes[100..102].copy_from_slice(&number(1234));
    bytes
}

/// An OLE compound file of sectors of 512 bytes, with a directory in sector 2 that names one stream.
fn ole(stream: &str) -> Vec<u8> {
    let mut bytes = vec![0; 512 * 5];
    bytes[..8].copy_from_slice(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1");
    bytes[30] = 9;
    bytes[48] = 2;
    let name: Vec<u8> = stream.encode_utf16().flat_map(u16::to_le_bytes).collect();
    bytes[512 * 3 + 128..][..name.len()].copy_from_slice(&name);
    bytes
}

/// An RHK file: the size of its header and its version in UTF-16.
fn rhk(version: &str) -> Vec<u8> {
    let version: Vec<u8> = version.encode_utf16().flat_map(u16::to_le_bytes).collect();
    [[0xaa, 0].as_slice(), &version, &[0; 64]].concat()
}

/// Returns a Leica file: a block of XML in UTF-16 after its size and the number of its letters.
fn leica() -> Vec<u8> {
    let xml: Vec<u8> = "<LMSDataContainerHeader/>".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let letters = (xml.len() as u32 / 2).to_le_bytes();
    [[0x70, 0, 0, 0, 0x37, 0, 0, 0, 0x2a].as_slice(), &letters, &xml].concat()
}

/// Returns a square tile of equal heights in metre.
fn terrain(side: usize, height: i16) -> Vec<u8> {
    height.to_be_bytes().repeat(side * side)
}

#[test]
fn files_of_known_formats_are_refused_by_name_with_advice() {
    let stl = [[b' '; 80].as_slice(), &2_u32.to_le_bytes(), &[1; 100]].concat();
    let bitmap = [b"BM".as_slice(), &[70, 0, 0, 0, 0, 0, 0, 0, 54, 0, 0, 0, 40, 0, 0, 0], &[0; 50]].concat();
    let tar = [[b'a'; 257].as_slice(), b"ustar\x0000"].concat();
    let cases: Vec<(Vec<u8>, &str, &str)> = vec![
        (igor_wave(false), "an Igor wave of version 2, a curve", "NPY or text"),
        (igor_wave(true), "an Igor wave of version 2, a curve", "NPY or text"),
        (b":NANONIS_VERSION:\n2\n".to_vec(), "a Nanonis SXM file", "GWY"),
        (ole("WordDocument"), "an OLE compound file", "as text"),
        (b"MATLAB 5.0 MAT-file, Platform: GLNXA64".to_vec(), "a MATLAB file", "NPY or text"),
        (b"\x89PNG\r\n\x1a\n\x00".to_vec(), "a PNG image", "no heights"),
        (b"\xff\xd8\xff\xe0".to_vec(), "a JPEG image", "no heights"),
        (b"%PDF-1.7\n".to_vec(), "a PDF document", "no heights"),
        (bitmap, "a BMP image", "no heights"),
        (stl, "a binary STL mesh", "regular grid"),
        (b"solid part\n  facet normal 0 0 1\n".to_vec(), "an STL mesh", "regular grid"),
        (b"ply\nformat ascii 1.0\n".to_vec(), "a PLY mesh", "regular grid"),
        (
            zip(&[("[Content_Types].xml", b"<a/>"), ("xl/workbook.bin", b"\0")]),
            "an Excel workbook in binary form",
            "CSV",
        ),
        (b"UK SOFT\r\nsoftware      PicoScan\r\n".to_vec(), "a Molecular Imaging (Agilent) STP file", "GWY"),
        (b"fileType      Image\nversion       PicoView\n".to_vec(), "a Molecular Imaging (Agilent) MI file", "GWY"),
        (terrain(1201, 412), "an SRTM tile of terrain heights (HGT)", "NPY or text"),
        (terrain(3601, i16::MIN), "an SRTM tile of terrain heights (HGT)", "NPY or text"),
        (zip(&[("readme.txt", b"hello")]), "a zip archive", "unpack"),
        (tar, "a tar archive", "unpack"),
        (b"BZh91AY&SY\x00".to_vec(), "a bzip2 archive", "unpack"),
        (rhk("STiMage 005.006 1"), "an RHK SM3 or SM4 file", "GWY"),
        (rhk("STiMage 004.002 1"), "an RHK SM3 or SM4 file", "GWY"),
        (leica(), "a Leica LIF file", "as text"),
        (b"\xda\xce\xbe\x0a\x20\0\0\0\x40\0\0\0\0\0\0\0ND2 FILE".to_vec(), "a Nikon ND2 file", "as text"),
        (b"SQLite format 3\0\x10\0".to_vec(), "a SQLite database", "instrument's program"),
        (
            b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n".to_vec(),
            "a Git LFS pointer",
            "fetch the file itself",
        ),
        (b"\n<!DOCTYPE html>\n<html><body>404</body></html>".to_vec(), "an HTML page", "fetch the file"),
        (b"\xef\xbb\xbf<HTML><HEAD>".to_vec(), "an HTML page", "fetch the file"),
        (b"{\n  \"heights\": [1, 2]\n}".to_vec(), "a JSON text", "NPY or text"),
        (b"[[1, 2], [3, 4]]".to_vec(), "a JSON text", "NPY or text"),
    ];
    for (bytes, name, advice) in cases {
        assert_eq!(Format::detect(&bytes), None, "{name}");
        let message = refusal(&bytes);
        assert!(
            message.starts_with(&format!("this is {name}")) && message.contains(", which is not read; "),
            "{message}"
        );
        assert!(message.contains(advice), "{message}");
        // Within a gzip stream as well.
        assert_eq!(refusal(&gzip(&bytes)), message);
    }
}

#[test]
fn hdf5_files_that_are_neither_datx_nor_netcdf_are_refused_by_name() {
    for (group, name) in
        [("measurement0", "a 4D Technology HDF5 file"), ("results", "an HDF5 file that is neither DATX nor netCDF")]
    {
        let mut file = Hdf5::new();
        let inner = file.object(&[]);
        let root = file.group(&[(group, inner)], &[]);
        let message = refusal(&file.finish(0, root));
        assert!(message.starts_with(&format!("this is {name}, which is not read; save the matrix")), "{message}");
    }
}

#[test]
fn ordinary_text_and_bytes_match_no_other_format() {
    for text in ["1 2\n3 4\n", "# solid ground\n1 2\n3 4\n", "# output image data of a plane\n1 2\n3 4\n"] {
        assert_eq!(Format::detect(text.as_bytes()), Some(Format::Text), "{text}");
    }
    // A wave whose headers do not sum up to zero, a bitmap of an unknown header, a mesh of another size.
    let mut wave = igor_wave(false);
    wave[7] = 1;
    let mesh = [[b' '; 80].as_slice(), &3_u32.to_le_bytes(), &[1; 100]].concat();
    // Tiles with numbers that are no heights of the Earth, or of another size.
    for bytes in
        [terrain(1201, 0x7f01), terrain(1200, 412), wave, b"BM\x00\x00\x00\x00\x00\x00\x00\x00abcdefgh".to_vec(), mesh]
    {
        assert_error(read_bytes(&bytes), "unknown format");
    }
}

#[test]
fn a_message_states_the_size_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let content = [0_u8; 3000];
    for (name, bytes) in [("long.bin", vec![0; 100_000]), ("packed.bin.gz", gzip(&content))] {
        let path = folder.path().join(name);
        fs::write(&path, &bytes).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(
            message.contains(&format!("unknown format: {} bytes that start with `\\x00", bytes.len())),
            "{message}"
        );
        assert_eq!(message.contains("once unpacked"), name.ends_with("gz"), "{message}");
    }
    // A long file of a known format is not read to its end.
    let path = folder.path().join("long.sxm");
    fs::write(&path, [b":NANONIS_VERSION:\r\n".as_slice(), &[0; 100_000]].concat()).unwrap();
    assert_error(read(&path), "long.sxm: this is a Nanonis SXM file");
}

#[test]
fn a_file_beyond_the_limit_is_refused_with_its_own_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.sur");
    fs::write(&path, [b"DIGITAL SURF".as_slice(), &[0; 1 << 16]].concat()).unwrap();
    // Five gigabytes that take no room.
    fs::File::options().write(true).open(&path).unwrap().set_len(5_000_000_000).unwrap();
    let message = read(&path).unwrap_err().to_string();
    assert!(message.contains("the file's size in bytes (byte 0) is 5000000000; the limit is"), "{message}");
}

#[test]
fn archives_that_are_cut_off_are_described() {
    // One archive has the name of the main file in its first half, the other only in the directory.
    let noise: Vec<u8> = (0..4000_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    for (files, message) in [
        (
            [("main.xml", b"<a/>".as_slice()), ("bindata/data.bin", &noise)],
            "X3P: archive: the zip archive has no valid directory at its end; the file is cut off or damaged",
        ),
        (
            [("bindata/data.bin", &noise), ("main.xml", b"<a/>")],
            "this is a zip archive without a valid directory at its end, which is not read; the file is cut off or damaged; \
             copy or download it again",
        ),
    ] {
        let bytes = zip(&files);
        assert_eq!(read_bytes(&bytes[..bytes.len() / 2]).unwrap_err().to_string(), message);
    }
}
