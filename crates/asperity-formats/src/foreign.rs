//! Formats that are recognised and not read, so that an error can name them and say what to do instead.
//!
//! Signatures are those of the shared MIME database, of the vendors' manuals and of the comments on formats that Gwyddion and
//! SurfaceTopography publish. The readers of TIFF and NetCDF recognise files of vendors by their fields and groups.

use crate::FormatError;
use crate::archive::Archive;
use crate::x3p::ZIP_MAGIC;

/// A format that is recognised by its content.
struct Foreign {
    /// The format with its article, as an error names it.
    name: &'static str,
    signature: Signature,
    /// What to do instead.
    way_out: &'static str,
}

enum Signature {
    /// One of these at the start.
    Start(&'static [&'static [u8]]),
    /// These bytes at an offset.
    At(usize, &'static [u8]),
    /// Text that starts without control characters and holds all of these words in its first [`HEAD_BYTES`].
    Words(&'static [&'static [u8]]),
    /// A test of the content, given the size of the file in bytes.
    Test(fn(&[u8], u64) -> bool),
}

/// Bytes in which words are looked for.
const HEAD_BYTES: usize = 4096;

pub(crate) const TO_GWY: &str = "Gwyddion can save it as GWY";
pub(crate) const TO_MATRIX: &str = "save the matrix of heights as NPY or text";
const TO_GRID: &str = "save the heights on a regular grid, as text or XYZ";
const NO_HEIGHTS: &str = "a picture holds no heights; export the height map from the instrument's program";
const CUT_OFF: &str = "the file is cut off or damaged; copy or download it again";
const UNPACK: &str = "unpack it and give the file of heights";

const FETCH: &str = "fetch the file of heights itself";

use Signature::{At, Start, Test, Words};

const FOREIGN: &[Foreign] = &[
    Foreign {
        name: "a Bruker Nanoscope file",
        signature: Start(&[b"\\*File list", b"\\*EC File list", b"\\*Force file list", b"?*File list"]),
        way_out: TO_GWY,
    },
    Foreign { name: "a Bruker OPDx file", signature: Start(&[b"VCA DATA"]), way_out: TO_GWY },
    Foreign {
        name: "a Wyko ASCII file",
        signature: Start(&[b"Wyko ASCII Data File"]),
        way_out: "save the measurement as OPD",
    },
    Foreign {
        name: "a Zygo ASCII file",
        signature: Start(&[b"Zygo ASCII Data File"]),
        way_out: "save the measurement as DAT, DATX or XYZ",
    },
    Foreign { name: "an Olympus OIR file", signature: Start(&[b"OLYMPUSRAWFORMAT"]), way_out: TO_GWY },
    Foreign { name: "a Keyence ZON file", signature: Start(&[b"KPK0", b"KPK1"]), way_out: TO_GWY },
    Foreign {
        name: "a Keyence CSV file",
        signature: Words(&[b"output image data", b"xy calibration"]),
        way_out: "save the measurement as VK4, VK6 or VK7, or keep only the rows of heights and state pixel size and unit",
    },
    Foreign { name: "an Asylum Research (Igor) IBW file", signature: Test(is_igor_wave), way_out: TO_GWY },
    Foreign { name: "an Igor text wave", signature: Start(&[b"IGOR\r", b"IGOR\n"]), way_out: TO_MATRIX },
    Foreign { name: "an Asylum Research ARDF file", signature: At(8, b"ARDF"), way_out: TO_GWY },
    Foreign { name: "a Nanosurf NID file", signature: Start(&[b"[DataSet]"]), way_out: TO_GWY },
    Foreign { name: "an NT-MDT file (MDT)", signature: Start(&[b"\x01\xb0\x93\xff"]), way_out: TO_GWY },
    Foreign { name: "a WSxM file", signature: Start(&[b"WSxM file copyright"]), way_out: TO_GWY },
    Foreign { name: "a Nanonis SXM file", signature: Start(&[b":NANONIS_VERSION:"]), way_out: TO_GWY },
    Foreign { name: "an RHK SM3 or SM4 file", signature: At(2, RHK_MAGIC), way_out: TO_GWY },
    Foreign { name: "a Leica LIF file", signature: Test(is_leica), way_out: "export the height map as text" },
    Foreign {
        name: "a Nikon ND2 file",
        signature: Start(&[b"\xda\xce\xbe\x0a"]),
        way_out: "export the height map as text",
    },
    Foreign { name: "an ISO 28600 file", signature: Start(&[b"ISO/TC 201 SPM data transfer format"]), way_out: TO_GWY },
    Foreign { name: "a Gwyddion simple field (GSF)", signature: Start(&[b"Gwyddion Simple Field"]), way_out: TO_GWY },
    Foreign { name: "a Gwyddion XYZ field", signature: Start(&[b"Gwyddion XYZ Field"]), way_out: TO_GWY },
    Foreign { name: "a Zeiss CZI file", signature: Start(&[b"ZISRAWFILE"]), way_out: "export the height map as text" },
    Foreign {
        name: "a Mountains file (MNT)",
        signature: Test(|bytes, _| bytes.starts_with(OLE_MAGIC) && is_mountains(bytes)),
        way_out: "Mountains can save the surface as SUR",
    },
    Foreign {
        name: "an OLE compound file, as of old Office documents and some microscopes",
        signature: Start(&[OLE_MAGIC]),
        way_out: "export the height map as text",
    },
    Foreign { name: "a MATLAB file", signature: Start(&[b"MATLAB 5.0 MAT", b"MATLAB 7.3 MAT"]), way_out: TO_MATRIX },
    Foreign { name: "an HDF4 file", signature: Start(&[b"\x0e\x03\x13\x01"]), way_out: TO_MATRIX },
    Foreign { name: "a FITS file", signature: Start(&[b"SIMPLE  ="]), way_out: TO_MATRIX },
    Foreign { name: "an NRRD file", signature: Start(&[b"NRRD000"]), way_out: TO_MATRIX },
    Foreign { name: "a binary STL mesh", signature: Test(is_binary_stl), way_out: TO_GRID },
    Foreign { name: "an STL mesh", signature: Test(is_text_stl), way_out: TO_GRID },
    Foreign { name: "a PLY mesh", signature: Start(&[b"ply\n", b"ply\r"]), way_out: TO_GRID },
    Foreign { name: "a PCD point cloud", signature: Start(&[b"# .PCD"]), way_out: TO_GRID },
    Foreign { name: "a LAS point cloud", signature: Start(&[b"LASF"]), way_out: TO_GRID },
    Foreign { name: "a PNG image", signature: Start(&[b"\x89PNG\r\n\x1a\n"]), way_out: NO_HEIGHTS },
    Foreign { name: "a JPEG image", signature: Start(&[b"\xff\xd8\xff"]), way_out: NO_HEIGHTS },
    Foreign {
        name: "a JPEG 2000 image",
        signature: Start(&[b"\x00\x00\x00\x0cjP  ", b"\xff\x4f\xff\x51"]),
        way_out: NO_HEIGHTS,
    },
    Foreign { name: "a GIF image", signature: Start(&[b"GIF87a", b"GIF89a"]), way_out: NO_HEIGHTS },
    Foreign { name: "a BMP image", signature: Test(is_bitmap), way_out: NO_HEIGHTS },
    Foreign { name: "an OpenEXR image", signature: Start(&[b"\x76\x2f\x31\x01"]), way_out: TO_MATRIX },
    Foreign {
        name: "a PDF document",
        signature: Start(&[b"%PDF-"]),
        way_out: "a document holds no heights; export the height map from the instrument's program",
    },
    Foreign {
        name: "a SQLite database",
        signature: Start(&[b"SQLite format 3\0"]),
        way_out: "export the height map from the instrument's program",
    },
    Foreign {
        name: "a Git LFS pointer",
        signature: Start(&[b"version https://git-lfs"]),
        way_out: "fetch the file itself (`git lfs pull`)",
    },
    Foreign { name: "an HTML page", signature: Test(is_html), way_out: FETCH },
    Foreign { name: "a JSON text", signature: Test(is_json), way_out: TO_MATRIX },
    Foreign { name: "a 7z archive", signature: Start(&[b"7z\xbc\xaf\x27\x1c"]), way_out: UNPACK },
    Foreign { name: "a RAR archive", signature: Start(&[b"Rar!\x1a\x07"]), way_out: UNPACK },
    Foreign { name: "an xz archive", signature: Start(&[b"\xfd7zXZ\x00"]), way_out: UNPACK },
    Foreign { name: "a Zstandard archive", signature: Start(&[b"\x28\xb5\x2f\xfd"]), way_out: UNPACK },
    Foreign { name: "a bzip2 archive", signature: Test(is_bzip2), way_out: UNPACK },
    Foreign { name: "a tar archive", signature: At(257, b"ustar"), way_out: UNPACK },
];

/// A kind of zip archive that is no format of its own.
struct Zipped {
    name: &'static str,
    /// Whether a file of this name marks the kind.
    marks: fn(&str) -> bool,
    way_out: &'static str,
}

/// Kinds of zip archives, the most special first.
const ZIPPED: &[Zipped] = &[
    Zipped { name: "an Olympus POIR file", marks: |name| name.ends_with(".oir"), way_out: TO_GWY },
    Zipped { name: "a JPK force file", marks: |name| name == "header.properties", way_out: TO_GWY },
    Zipped {
        name: "an Excel workbook (XLSX)",
        marks: |name| name == "xl/workbook.xml",
        way_out: "save the sheet of heights as CSV",
    },
    Zipped {
        name: "an Office document",
        marks: |name| name == "[Content_Types].xml",
        way_out: "export the heights as text",
    },
    Zipped { name: "a zip archive", marks: |_| true, way_out: UNPACK },
];

/// `STiMage 00` in UTF-16, behind the size of the header.
const RHK_MAGIC: &[u8] = b"S\0T\0i\0M\0a\0g\0e\0 \0\x30\0\x30\0";

/// First bytes of an OLE compound file.
pub(crate) const OLE_MAGIC: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";

/// The error for content of a known format that is not read, given the size of its file in bytes.
///
/// Zip archives are looked into by [`in_archive`], after those that are read.
pub(crate) fn recognise(bytes: &[u8], size: u64) -> Option<FormatError> {
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    let is_known = |foreign: &&Foreign| match foreign.signature {
        Start(signatures) => signatures.iter().any(|signature| bytes.starts_with(signature)),
        At(offset, signature) => bytes.get(offset..).is_some_and(|rest| rest.starts_with(signature)),
        Words(words) => crate::text::is_text(bytes) && words.iter().all(|word| holds(head, word)),
        Test(is_it) => is_it(bytes, size),
    };
    FOREIGN.iter().find(is_known).map(|&Foreign { name, way_out, .. }| FormatError::NotRead { name, way_out })
}

/// The error for a zip archive that no reader knows.
pub(crate) fn in_archive(bytes: &[u8]) -> Option<FormatError> {
    if !bytes.starts_with(ZIP_MAGIC) {
        return None;
    }
    let Ok(archive) = Archive::open(crate::Format::X3p, bytes) else {
        return Some(FormatError::NotRead {
            name: "a zip archive without a valid directory at its end",
            way_out: CUT_OFF,
        });
    };
    let is_known = |zipped: &&Zipped| archive.names().iter().any(|name| (zipped.marks)(name));
    ZIPPED.iter().find(is_known).map(|&Zipped { name, way_out, .. }| FormatError::NotRead { name, way_out })
}

/// Whether some bytes hold a word of small letters, in any case.
fn holds(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word))
}

/// Whether an OLE compound file holds a stream of the name that Mountains gives to its surfaces. Names are in UTF-16 in the
/// directory, whose first sector the header states.
fn is_mountains(bytes: &[u8]) -> bool {
    const STREAM: &str = "ScopedContents";
    let number = |at: usize, length: usize| {
        let raw = bytes.get(at..at + length)?;
        Some(raw.iter().rev().fold(0_u64, |number, byte| number << 8 | u64::from(*byte)))
    };
    let directory = || {
        let (shift, sector) = (number(30, 2)?, number(48, 4)?);
        // Sectors have 512 or 4096 bytes, and the header takes the place of one.
        let size = 1_u64 << shift.clamp(9, 12);
        let start = usize::try_from((sector + 1) * size).ok()?;
        bytes.get(start..(start + HEAD_BYTES).min(bytes.len()))
    };
    let name: Vec<u8> = STREAM.encode_utf16().flat_map(u16::to_le_bytes).collect();
    directory().is_some_and(|directory| directory.windows(name.len()).any(|window| window == name))
}

/// Whether bytes are an Igor binary wave: version 2 or 5 in either order of bytes, and 16-bit numbers in the headers that sum
/// up to zero (Igor technical note 003).
fn is_igor_wave(bytes: &[u8], _: u64) -> bool {
    let sums_up = |length: usize, number: fn([u8; 2]) -> u16| {
        let pairs = bytes.get(..length).map(|head| head.chunks_exact(2).map(|pair| number([pair[0], pair[1]])));
        pairs.is_some_and(|pairs| pairs.fold(0_u16, u16::wrapping_add) == 0)
    };
    match bytes.get(..2) {
        Some([2, 0]) => sums_up(126, u16::from_le_bytes),
        Some([0, 2]) => sums_up(126, u16::from_be_bytes),
        Some([5, 0]) => sums_up(384, u16::from_le_bytes),
        Some([0, 5]) => sums_up(384, u16::from_be_bytes),
        _ => false,
    }
}

/// Whether the size of a file is that of a binary STL mesh: 84 bytes and 50 for each of the stated triangles.
fn is_binary_stl(bytes: &[u8], size: u64) -> bool {
    let count = bytes.get(80..84).map_or(0, |raw| u64::from(u32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]])));
    count > 0 && size == 84 + 50 * count
}

fn is_text_stl(bytes: &[u8], _: u64) -> bool {
    bytes.starts_with(b"solid") && holds(&bytes[..bytes.len().min(HEAD_BYTES)], b"facet normal")
}

/// Whether bytes start as a bitmap: the two letters, four reserved bytes of zero, and a header of a known size.
fn is_bitmap(bytes: &[u8], _: u64) -> bool {
    let known = |size: &[u8]| matches!(size, [12 | 40 | 52 | 56 | 64 | 108 | 124, 0, 0, 0]);
    bytes.starts_with(b"BM") && bytes.get(6..10) == Some(&[0; 4]) && bytes.get(14..18).is_some_and(known)
}

/// Whether bytes start as bzip2: the three letters, a digit, and the digits of π before the first block.
fn is_bzip2(bytes: &[u8], _: u64) -> bool {
    bytes.starts_with(b"BZh") && bytes.get(4..10) == Some(b"\x31\x41\x59\x26\x53\x59".as_slice())
}

/// Whether bytes start as a Leica image file: a block of XML, whose size follows, and its text in UTF-16.
fn is_leica(bytes: &[u8], _: u64) -> bool {
    bytes.starts_with(b"\x70\0\0\0") && bytes.get(8) == Some(&0x2a) && bytes.get(13..15) == Some(b"<\0".as_slice())
}

fn is_html(bytes: &[u8], _: u64) -> bool {
    let start = first_word(bytes);
    [b"<!doctype html".as_slice(), b"<html"]
        .iter()
        .any(|tag| start.get(..tag.len()).is_some_and(|start| start.eq_ignore_ascii_case(tag)))
}

/// Whether text starts as an object of JSON, or as an array of arrays, objects or strings.
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

/// The bytes behind blanks and the mark that some programs put before UTF-8.
fn first_word(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start()
}
