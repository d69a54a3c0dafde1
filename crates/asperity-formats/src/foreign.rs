//! Formats that are recognised but not read. Errors name them and give advice.
//!
//! The signatures are from the shared MIME database, the vendors' manuals and the comments on formats that Gwyddion
//! and SurfaceTopography publish. The readers of TIFF and NetCDF recognise vendors' files by their fields and groups.

use crate::x3p::ZIP_MAGIC;
use crate::{Archive, FormatError};

/// Format that is recognised by its content: its name with an article, its signature, and the advice to the user.
struct Foreign(&'static str, Signature, &'static str);

enum Signature {
    /// One of these byte strings at the start.
    Start(&'static [&'static [u8]]),
    /// A byte string at an offset.
    At(usize, &'static [u8]),
    /// Test of the content, given the size of the file in bytes.
    Test(fn(&[u8], u64) -> bool),
}

/// Number of bytes that are searched for words.
const HEAD_BYTES: usize = 4096;

pub(crate) const TO_GWY: &str = "Gwyddion can save it as GWY";
pub(crate) const TO_MATRIX: &str = "save the matrix of heights as NPY or text";
const TO_GRID: &str = "save the heights on a regular grid, as text or XYZ";
const NO_HEIGHTS: &str = "a picture holds no heights; export the height map from the instrument's program";
const NO_HEIGHTS_IN_TEXT: &str = "a document holds no heights; export the height map from the instrument's program";
const NO_MAP: &str = "a force curve is no height map";
const CUT_OFF: &str = "the file is cut off or damaged; copy or download it again";
const UNPACK: &str = "unpack it and give the file of heights";
const AS_TEXT: &str = "export the height map as text";
const FETCH: &str = "fetch the file of heights itself";

use Signature::{At, Start, Test};

const FOREIGN: &[Foreign] = &[
    Foreign("a Bruker Nanoscope file of force curves", Start(&[b"\\*Force file list"]), NO_MAP),
    Foreign("an Igor wave of version 2, a curve", Test(is_old_igor_wave), TO_MATRIX),
    Foreign("an Igor text wave", Start(&[b"IGOR\r", b"IGOR\n"]), TO_MATRIX),
    Foreign("an Asylum Research ARDF file", At(8, b"ARDF"), TO_GWY),
    Foreign("a Nanonis SXM file", Start(&[b":NANONIS_VERSION:"]), TO_GWY),
    Foreign("an RHK SM3 or SM4 file", At(2, RHK_MAGIC), TO_GWY),
    Foreign("a Leica LIF file", Test(is_leica), AS_TEXT),
    Foreign("a Nikon ND2 file", Start(&[b"\xda\xce\xbe\x0a"]), AS_TEXT),
    Foreign("an ISO 28600 file", Start(&[b"ISO/TC 201 SPM data transfer format"]), TO_GWY),
    Foreign("a Molecular Imaging (Agilent) STP file", Start(&[b"UK SOFT\r\n"]), TO_GWY),
    Foreign("a Molecular Imaging (Agilent) MI file", Start(&[b"fileType      "]), TO_GWY),
    Foreign("an SRTM tile of terrain heights (HGT)", Test(is_terrain), TO_MATRIX),
    Foreign("a Gwyddion XYZ field", Start(&[b"Gwyddion XYZ Field"]), TO_GWY),
    Foreign("a Zeiss CZI file", Start(&[b"ZISRAWFILE"]), AS_TEXT),
    Foreign(
        "an OLE compound file, as of old Office documents and some microscopes",
        Test(|bytes, _| bytes.starts_with(OLE_MAGIC) && !is_mountains(bytes)),
        AS_TEXT,
    ),
    Foreign("a MATLAB file", Start(&[b"MATLAB 5.0 MAT", b"MATLAB 7.3 MAT"]), TO_MATRIX),
    Foreign("an HDF4 file", Start(&[b"\x0e\x03\x13\x01"]), TO_MATRIX),
    Foreign("a FITS file", Start(&[b"SIMPLE  ="]), TO_MATRIX),
    Foreign("an NRRD file", Start(&[b"NRRD000"]), TO_MATRIX),
    Foreign("a binary STL mesh", Test(is_binary_stl), TO_GRID),
    Foreign("an STL mesh", Test(is_text_stl), TO_GRID),
    Foreign("a PLY mesh", Start(&[b"ply\n", b"ply\r"]), TO_GRID),
    Foreign("a PCD point cloud", Start(&[b"# .PCD"]), TO_GRID),
    Foreign("a LAS point cloud", Start(&[b"LASF"]), TO_GRID),
    Foreign("a PNG image", Start(&[b"\x89PNG\r\n\x1a\n"]), NO_HEIGHTS),
    Foreign("a JPEG image", Start(&[b"\xff\xd8\xff"]), NO_HEIGHTS),
    Foreign("a JPEG 2000 image", Start(&[b"\x00\x00\x00\x0cjP  ", b"\xff\x4f\xff\x51"]), NO_HEIGHTS),
    Foreign("a GIF image", Start(&[b"GIF87a", b"GIF89a"]), NO_HEIGHTS),
    Foreign("a BMP image", Test(is_bitmap), NO_HEIGHTS),
    Foreign("an OpenEXR image", Start(&[b"\x76\x2f\x31\x01"]), TO_MATRIX),
    Foreign("a PDF document", Start(&[b"%PDF-"]), NO_HEIGHTS_IN_TEXT),
    Foreign("a SQLite database", Start(&[b"SQLite format 3\0"]), "export the height map from the instrument's program"),
    Foreign("a Git LFS pointer", Start(&[b"version https://git-lfs"]), "fetch the file itself (`git lfs pull`)"),
    Foreign("an HTML page", Test(is_html), FETCH),
    Foreign("a JSON text", Test(is_json), TO_MATRIX),
    Foreign("a 7z archive", Start(&[b"7z\xbc\xaf\x27\x1c"]), UNPACK),
    Foreign("a RAR archive", Start(&[b"Rar!\x1a\x07"]), UNPACK),
    Foreign("an xz archive", Start(&[b"\xfd7zXZ\x00"]), UNPACK),
    Foreign("a Zstandard archive", Start(&[b"\x28\xb5\x2f\xfd"]), UNPACK),
    Foreign("a bzip2 archive", Test(is_bzip2), UNPACK),
    Foreign("a tar archive", At(257, b"ustar"), UNPACK),
];

/// Kind of zip archive: its name with an article, a test of the names of its files, and the advice to the user.
struct Zipped(&'static str, fn(&str) -> bool, &'static str);

/// Kinds of zip archives, the most specific first.
const ZIPPED: &[Zipped] = &[
    Zipped("a JPK force file", |name| name == "header.properties", TO_GWY),
    Zipped(
        "an Excel workbook in binary form (XLSB)",
        |name| name == "xl/workbook.bin",
        "save the sheet of heights as CSV",
    ),
    Zipped("an Office document", |name| name == "[Content_Types].xml", "export the heights as text"),
    Zipped("a zip archive", |_| true, UNPACK),
];

/// `STiMage 00` in UTF-16, after the size of the header.
const RHK_MAGIC: &[u8] = b"S\0T\0i\0M\0a\0g\0e\0 \0\x30\0\x30\0";

/// First bytes of an OLE compound file.
pub(crate) const OLE_MAGIC: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";

/// Returns the error for content in a format that is known but not read. `size` is the size of the file in bytes.
///
/// [`in_archive`] examines zip archives that no reader recognises.
pub(crate) fn recognise(bytes: &[u8], size: u64) -> Option<FormatError> {
    let is_known = |foreign: &&Foreign| match foreign.1 {
        Start(signatures) => signatures.iter().any(|signature| bytes.starts_with(signature)),
        At(offset, signature) => bytes.get(offset..).is_some_and(|rest| rest.starts_with(signature)),
        Test(is_match) => is_match(bytes, size),
    };
    FOREIGN.iter().find(is_known).map(|&Foreign(name, _, advice)| FormatError::NotRead { name, advice })
}

/// Returns the error for a zip archive that no reader recognises.
pub(crate) fn in_archive(bytes: &[u8]) -> Option<FormatError> {
    if !bytes.starts_with(ZIP_MAGIC) {
        return None;
    }
    let Ok(archive) = Archive::open(crate::Format::X3p, bytes) else {
        return Some(FormatError::NotRead {
            name: "a zip archive without a valid directory at its end",
            advice: CUT_OFF,
        });
    };
    let is_known = |zipped: &&Zipped| archive.names().iter().any(|name| zipped.1(name));
    ZIPPED.iter().find(is_known).map(|&Zipped(name, _, advice)| FormatError::NotRead { name, advice })
}

/// Returns whether bytes contain a word, ignoring the case of ASCII letters.
fn holds(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word))
}

/// Returns whether an OLE compound file holds a stream with the name of Mountains' surfaces. Names are in UTF-16 in
/// the directory; the header states its first sector.
pub(crate) fn is_mountains(bytes: &[u8]) -> bool {
    const STREAM: &str = "ScopedContents";
    let number = |at: usize, length: usize| {
        let raw = bytes.get(at..at + length)?;
        Some(raw.iter().rev().fold(0_u64, |number, byte| number << 8 | u64::from(*byte)))
    };
    let directory = || {
        let (shift, sector) = (number(30, 2)?, number(48, 4)?);
        // Sectors have 512 or 4096 bytes, and the header occupies one.
        let size = 1_u64 << shift.clamp(9, 12);
        let start = usize::try_from((sector + 1) * size).ok()?;
        bytes.get(start..(start + HEAD_BYTES).min(bytes.len()))
    };
    let name: Vec<u8> = STREAM.encode_utf16().flat_map(u16::to_le_bytes).collect();
    directory().is_some_and(|directory| directory.windows(name.len()).any(|window| window == name))
}

/// Returns whether bytes are an Igor binary wave: version 2 or 5 in either byte order, and 16-bit numbers in the
/// headers that sum to zero (Igor technical note 003).
fn is_old_igor_wave(bytes: &[u8], _: u64) -> bool {
    let sums_up = |number: fn([u8; 2]) -> u16| {
        let pairs = bytes.get(..126).map(|head| head.chunks_exact(2).map(|pair| number([pair[0], pair[1]])));
        pairs.is_some_and(|pairs| pairs.fold(0_u16, u16::wrapping_add) == 0)
    };
    match bytes.get(..2) {
        Some([2, 0]) => sums_up(u16::from_le_bytes),
        Some([0, 2]) => sums_up(u16::from_be_bytes),
        _ => false,
    }
}

/// Returns whether the size of a file fits a binary STL mesh: 84 bytes plus 50 for each declared triangle.
fn is_binary_stl(bytes: &[u8], size: u64) -> bool {
    let count = bytes.get(80..84).map_or(0, |raw| u64::from(u32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]])));
    count > 0 && size == 84 + 50 * count
}

fn is_text_stl(bytes: &[u8], _: u64) -> bool {
    bytes.starts_with(b"solid") && holds(&bytes[..bytes.len().min(HEAD_BYTES)], b"facet normal")
}

/// Returns whether bytes start as a bitmap: two letters, four reserved zero bytes, and a header of a known size.
fn is_bitmap(bytes: &[u8], _: u64) -> bool {
    let known = |size: &[u8]| matches!(size, [12 | 40 | 52 | 56 | 64 | 108 | 124, 0, 0, 0]);
    bytes.starts_with(b"BM") && bytes.get(6..10) == Some(&[0; 4]) && bytes.get(14..18).is_some_and(known)
}

/// Returns whether bytes start as bzip2: three letters, a digit, and the digits of π before the first block.
fn is_bzip2(bytes: &[u8], _: u64) -> bool {
    bytes.starts_with(b"BZh") && bytes.get(4..10) == Some(b"\x31\x41\x59\x26\x53\x59".as_slice())
}

/// Returns whether bytes start as a Leica image file: a block of XML, its size, and its text in UTF-16.
fn is_leica(bytes: &[u8], _: u64) -> bool {
    bytes.starts_with(b"\x70\0\0\0") && bytes.get(8) == Some(&0x2a) && bytes.get(13..15) == Some(b"<\0".as_slice())
}

/// Returns whether content is a tile of the Shuttle Radar Topography Mission, which has no header: a square of 1201 or 3601
/// big-endian `i16` in metre, −32768 where the height is missing.
fn is_terrain(bytes: &[u8], size: u64) -> bool {
    let is_height = |raw: &[u8; 2]| matches!(i16::from_be_bytes(*raw), -500..=9000 | i16::MIN);
    [1201, 3601].iter().any(|side| size == 2 * side * side) && bytes.as_chunks().0.iter().take(256).all(is_height)
}

fn is_html(bytes: &[u8], _: u64) -> bool {
    let start = first_word(bytes);
    [b"<!doctype html".as_slice(), b"<html"]
        .iter()
        .any(|tag| start.get(..tag.len()).is_some_and(|start| start.eq_ignore_ascii_case(tag)))
}

/// Returns whether text starts as a JSON object, or as an array of arrays, objects or strings.
fn is_json(bytes: &[u8], _: u64) -> bool {
    let start = first_word(bytes);
    let next =
        |wanted: &[u8]| start.get(1..).is_some_and(|rest| first_word(rest).iter().take(1).any(|c| wanted.contains(c)));
    match start.first() {
        Some(b'{') => next(b"\"}"),
        Some(b'[') => next(b"[{\""),
        _ => false,
    }
}

/// Returns the bytes after blanks and the byte-order mark of UTF-8.
fn first_word(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start()
}
