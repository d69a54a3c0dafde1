//! ISO 25178-71 surface data files (SDF), text and binary, and their predecessors, BCR files.
//!
//! A file consists of a header, the heights, and a trailer of free notes. In text the header has lines `key = value`,
//! `*` ends each part, and `;` starts a comment. In binary the same fields have fixed widths, numbers are
//! little-endian, and nothing separates the parts. A height is number · Zscale in metre; Xscale and Yscale are the
//! distances between points in metre. Compression and checksums, which the standard withdrew, are refused.
//!
//! In text, missing points are `BAD`. In numbers, ISO files and some BCR files mark them by the least value of the
//! type; other BCR files use the greatest, as unsigned types must. NaN is also missing: most programs write it.
//!
//! The first profile is row 0. In the standard y grows with the profiles, so that y = 0 is the upper edge of the map
//! here, as in X3P files and in the free programs that read both. A program that draws y upwards shows the map upside
//! down.
//!
//! # References
//! ISO 25178-71; Stout et al., *The Development of Methods for the Characterisation of Roughness in Three
//! Dimensions*, EUR 15178 EN (1993).

mod write;

use std::collections::BTreeMap;

use crate::input::Kind;
use crate::scan::matrix;
use crate::sections::Section;
use crate::text::decimal::Decimal;
use crate::text::header::Header as Notes;
use crate::text::lines;
use crate::text::rows::{self, Layout};
use crate::text::separator::Separator;
use crate::{
    Description, Format, FormatError, Input, Location, ReadOptions, Result, Sample, Scan, Shape, Tested, large, latin1,
    refuse_if,
};
pub use write::write_sdf;

pub(crate) const CODEC: Description = Description {
    extensions: &["sdf"],
    vendor: "ISO 25178-71",
    known_by: "`aISO-1.0`, `bISO-1.0`, `aBCR-1.0`, `bBCR-1.0` and other versions",
    reads: "text and binary; int8 to int32, uint8 to uint32, float32, float64",
    writes: "binary float64",
    missing_points: "BAD in text; least value of the type, greatest in BCR files and unsigned types, NaN",
    orientation: "the first profile (y = 0) is row 0",
    write: Some(write_sdf),
    tested: Tested::OtherPrograms,
    ..Description::new(Format::Sdf, |bytes| Version::detect(bytes).is_some(), read)
};

/// Kind of file according to its first bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Text,
    /// Binary file with counts of this many bytes.
    Binary {
        count_bytes: usize,
    },
}

/// Size in bytes of the version in a binary header.
const VERSION_BYTES: usize = 8;
/// Number of bytes in which the fields of a text must start.
const PROBE: usize = 512;

impl Version {
    /// Detects the kind of file. Texts exist in many versions (`aISO-1.0`, `aBCR-0.0`, `aNIST-1.0`, `aNPL-V1.0`), but
    /// all start with the same field.
    fn detect(bytes: &[u8]) -> Option<Self> {
        let number = |text: &[u8]| matches!(text, [b'0'..=b'9', b'.', b'0'..=b'9']);
        match bytes {
            [b'b', b'I', b'S', b'O', b'-', version @ ..] if number(version.get(..3)?) => {
                // Version 2.0 has wider counts.
                Some(Self::Binary { count_bytes: if version[0] == b'2' { 4 } else { 2 } })
            }
            [b'b', b'B', b'C', b'R', b'-', version @ ..] if number(version.get(..3)?) => {
                Some(Self::Binary { count_bytes: 2 })
            }
            [b'a', b'A'..=b'Z', ..] => {
                let probe = &bytes[..bytes.len().min(PROBE)];
                let mut lines = probe.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
                let (version, mut fields) = (lines.next()?, lines.filter(|line| !matches!(line, [] | [b';', ..])));
                let first = fields.next()?.get(..MANUFACTURER.len())?;
                let known = version.contains(&b'-') && first.eq_ignore_ascii_case(MANUFACTURER.as_bytes());
                known.then_some(Self::Text)
            }
            _ => None,
        }
    }
}

/// First line of a text, or first bytes.
const VERSION: &str = "version";
const MANUFACTURER: &str = "ManufacID";
/// Fields after the manufacturer, in the order of the binary header.
const DATES: [&str; 2] = ["CreateDate", "ModDate"];
const POINTS: &str = "NumPoints";
const PROFILES: &str = "NumProfiles";
const SCALES: [&str; 3] = ["Xscale", "Yscale", "Zscale"];
const Z_RESOLUTION: &str = "Zresolution";
const COMPRESSION: &str = "Compression";
const DATA_TYPE: &str = "DataType";
const CHECK_TYPE: &str = "CheckType";
/// End of a part of a text.
const END: u8 = b'*';
/// Start of a comment in a text.
const COMMENT: &[u8] = b";";

/// Returns the shape of the map and the type of the numbers.
fn check(header: &Section) -> Result<(Shape, Sample)> {
    let (ny, nx) = header.shape(PROFILES, POINTS)?;
    for key in [COMPRESSION, CHECK_TYPE] {
        refuse_if!(header.number::<i64>(key)? != 0, header.wrong(key, "0, heights without compression and checksum"));
    }
    let scale: f64 = header.number(SCALES[2])?;
    refuse_if!(!(scale.is_finite() && scale > 0.0), header.wrong(SCALES[2], "a positive number"));
    let samples =
        [Sample::U8, Sample::U16, Sample::U32, Sample::F32, Sample::I8, Sample::I16, Sample::I32, Sample::F64];
    let sample = usize::try_from(header.number::<i64>(DATA_TYPE)?).ok().and_then(|code| samples.get(code));
    Ok(((ny, nx), *sample.ok_or_else(|| header.wrong(DATA_TYPE, "0 to 7"))?))
}

fn scan(header: &Section, mut heights: Vec<f64>, shape: Shape, sample: Sample) -> Result<Scan> {
    let [x, y, z] = SCALES.map(|key| header.number::<f64>(key));
    let (x, y, z) = (x?, y?, z?);
    let is_bcr =
        header.field(VERSION).is_some_and(|version| version.get(1..).is_some_and(|rest| rest.starts_with("BCR")));
    let is_void = voids(sample, is_bcr);
    large::map(&mut heights, |height| if is_void(height) { f64::NAN } else { height * z });
    let heights_m = matrix(Format::Sdf, POINTS, header.place(POINTS), shape, heights)?;
    Ok(Scan::new(heights_m, Some((x, y))))
}

/// Returns a test for the numbers that mark missing points.
fn voids(sample: Sample, is_bcr: bool) -> impl Fn(f64) -> bool + Sync {
    // Floats are compared with a margin, because texts round them.
    let (none_low, none_high) = (f64::NEG_INFINITY, f64::INFINITY);
    let range = 2.0_f64.powi(8 * sample.size() as i32);
    let (least, greatest) = match sample {
        Sample::F32 => (-3.4e38, 3.4e38),
        Sample::F64 => (-1.79e308, 1.79e308),
        _ if sample.is_signed() => (-range / 2.0, range / 2.0 - 1.0),
        _ => (none_low, range - 1.0),
    };
    let is_float = sample.is_float();
    let has_greatest = is_bcr || is_float || least == none_low;
    let greatest = if has_greatest { greatest } else { none_high };
    move |number| match is_float {
        // A comparison with NaN is false, so NaN is missing.
        true => !(number > least && number < greatest),
        false => number == least || number == greatest,
    }
}

/// Reads the first map of a file.
///
/// # Errors
/// Compression, checksums, absent or invalid fields of the header, and heights that end early.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    match Version::detect(bytes) {
        Some(Version::Binary { count_bytes }) => read_binary(&Input::new(Format::Sdf, bytes), count_bytes),
        _ => read_text(bytes, options.decimal),
    }
}

fn read_binary(input: &Input<'_>, count_bytes: usize) -> Result<Scan> {
    let mut header = Section::new(Format::Sdf, Location::Byte(0), "a field of the header");
    let mut start = 0;
    for (name, length) in [(VERSION, VERSION_BYTES), (MANUFACTURER, 10), (DATES[0], 12), (DATES[1], 12)] {
        header.push(name, input.latin1(name, start, length)?, input.at(start));
        start += length;
    }
    let count = if count_bytes == 4 { Kind::U32 } else { Kind::U16 };
    for (name, kind, length) in [(POINTS, count, count_bytes), (PROFILES, count, count_bytes)]
        .into_iter()
        .chain(SCALES.into_iter().chain([Z_RESOLUTION]).map(|name| (name, Kind::F64, 8)))
        .chain([COMPRESSION, DATA_TYPE, CHECK_TYPE].map(|name| (name, Kind::U8, 1)))
    {
        header.push(name, input.value(name, start, kind)?, input.at(start));
        start += length;
    }
    let (shape, sample) = check(&header)?;
    let length = shape.0 * shape.1 * sample.size();
    // A program of Olympus adds two fields to the header, always 5 and 1.
    if input.len() == start + EXTRA.len() + length && input.bytes[start..].starts_with(EXTRA) {
        start += EXTRA.len();
    }
    let numbers = input.samples("the heights", start, shape.0 * shape.1, sample)?;
    let metadata = metadata(&header, &latin1(&input.bytes[start + length..]));
    Ok(Scan { metadata, ..scan(&header, numbers, shape, sample)? })
}

/// Two fields after the header of some files.
const EXTRA: &[u8] = b"\x05\0\0\0\x01\0\0\0";

fn read_text(bytes: &[u8], decimal: Option<Decimal>) -> Result<Scan> {
    let (bytes, line_end) = lines(bytes);
    let mut header = Section::new(Format::Sdf, Location::Line(1), "a line `key = value` before the first `*`");
    let (mut place, mut last_line) = (0, 0);
    for (index, line) in bytes.split(|&byte| byte == line_end).enumerate() {
        last_line = index;
        let trimmed = line.trim_ascii_start();
        if trimmed.first() == Some(&END) {
            place += line.len() - trimmed.len() + 1;
            break;
        }
        place += line.len() + 1;
        let line = latin1(line.split(|byte| COMMENT.contains(byte)).next().unwrap_or_default());
        let pair = line.split_once('=').or_else(|| line.split_once(char::is_whitespace));
        if index == 0 {
            header.push(VERSION, line, Location::Line(1));
        } else if let Some((key, value)) = pair.filter(|_| index < MAX_LINES) {
            header.push(key.trim().to_owned(), value.trim().to_owned(), Location::Line(index + 1));
        }
    }
    header.at = Location::Line(last_line + 1);
    let (shape, sample) = check(&header)?;

    let rest = bytes.get(place..).unwrap_or_default();
    let length = rest.iter().position(|&byte| byte == END).unwrap_or(rest.len());
    let layout = Layout::new(Format::Sdf, Separator::Space, COMMENT, line_end).with_decimal(decimal);
    let mut numbers = rows::read(&rest[..length], &layout, last_line)?.values;
    let (found, wanted) = (numbers.len(), shape.0 * shape.1);
    if found < wanted {
        let at = Location::Line(last_line + 1 + rest[..length].iter().filter(|&&byte| byte == line_end).count());
        let (field, wanted) = (format!("height {} of {wanted}", found + 1), format!("{POINTS} × {PROFILES} numbers"));
        return Err(FormatError::missing(Format::Sdf, field, at, wanted + " before `*`"));
    }
    let mut warnings = Vec::new();
    if found > wanted {
        numbers.truncate(wanted);
        warnings.push(format!("{} numbers after the last profile were left out", found - wanted));
    }
    let metadata = metadata(&header, &latin1(rest.get(length + 1..).unwrap_or_default()));
    Ok(Scan { metadata, warnings, ..scan(&header, numbers, shape, sample)? })
}

/// Maximum number of lines of a header.
const MAX_LINES: usize = 1000;

/// Returns the fields of the header that do not define the heights, and lines `name = value` and
/// `< name > value < / name >` of the trailer.
fn metadata(header: &Section, trailer: &str) -> BTreeMap<String, String> {
    let mut notes = Notes::default();
    let used = [&[POINTS, PROFILES, COMPRESSION, DATA_TYPE, CHECK_TYPE], &SCALES[..]].concat();
    for (key, value) in header.all().filter(|(key, _)| !used.iter().any(|used| used.eq_ignore_ascii_case(key))) {
        notes.insert(key, value);
    }
    for line in trailer.lines().map(str::trim).filter(|line| !line.is_empty() && *line != "*") {
        let tagged = line.strip_prefix('<').and_then(|line| line.split_once('>'));
        match (tagged, line.split_once('=')) {
            (Some((name, value)), _) => {
                notes.insert(name.trim(), value.rsplit_once('<').map_or(value, |(value, _)| value).trim());
            }
            (None, Some((name, value))) => notes.insert(name.trim(), value.trim()),
            (None, None) => notes.insert("trailer", line),
        }
    }
    notes.metadata()
}
