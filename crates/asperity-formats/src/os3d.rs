//! Digital Metrology OmniSurf3D OS3D: a header, the heights as `f32` in µm, and an optional picture as PNG.
//!
//! Files of version 1.01 and later also state the time of the measurement. Version 1.0 and 1.01 are described at
//! <https://digitalmetrology.com/omnisurf3d-file-format/>. Numbers are little-endian.

use std::collections::BTreeMap;

use crate::{Description, Format, Input, ReadOptions, Result, Sample, Scan, refuse_if, utf8_or_latin1};

pub(crate) const CODEC: Description = Description {
    extensions: &["os3d"],
    vendor: "Digital Metrology",
    known_by: "`OmniSurf3D`",
    reads: "float32, versions 1.0 and 1.01; no picture",
    missing_points: "numbers below −3e38, NaN",
    orientation: "the first stored line is row 0; the format defines no direction",
    ..Description::new(Format::Os3d, |bytes| bytes.starts_with(SIGNATURE), read)
};

const SIGNATURE: &[u8] = b"OmniSurf3D";
const MAJOR: (&str, usize) = ("major version", 10);
const MINOR: (&str, usize) = ("minor version", 14);
/// Offset of the first text.
const TEXTS: usize = 18;
/// The missing heights are the lowest finite `f32`, −3.4e38.
const LOWEST: f64 = -3e38;
const MICROMETRES: f64 = 1e6;

/// Reads the heights.
///
/// # Errors
/// Other versions, and texts or heights beyond the end of the file.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Os3d, bytes);
    let (major, minor) = (input.i32(MAJOR.0, MAJOR.1)?, input.i32(MINOR.0, MINOR.1)?);
    refuse_if!(major != 1, input.wrong(MAJOR.0, MAJOR.1, major, "1"));
    let fields: &[&str] = if minor > 0 { &["identification", "measured at"] } else { &["identification"] };
    let mut metadata = BTreeMap::from([("version".to_owned(), format!("{major}.{minor}"))]);
    let mut at = TEXTS;
    for &field in fields {
        let length = input.i32("length of a text", at)?;
        let length = usize::try_from(length).map_err(|_| input.wrong(field, at, length, "a length of 0 or more"))?;
        let text = utf8_or_latin1(input.take(field, at + 4, length)?);
        metadata.insert(field.to_owned(), text.trim_matches(['\0', ' ']).to_owned());
        at += 4 + length;
    }
    let (columns, rows) = (input.i32("points along x", at)?, input.i32("points along y", at + 4)?);
    let shape = input.shape(("points along y", at + 4, rows), ("points along x", at, columns))?;
    let number = |field: &str, place: usize| input.f64(field, at + 8 + 8 * place);
    let pitch_m = Some((number("spacing along x", 0)? / MICROMETRES, number("spacing along y", 1)? / MICROMETRES));
    for (place, field) in [(2, "x origin in um"), (3, "y origin in um")] {
        metadata.insert(field.to_owned(), number(field, place)?.to_string());
    }
    let in_metre = |z: f64| if z < LOWEST { f64::NAN } else { z / MICROMETRES };
    let heights_m = input.heights("the heights", at + 40, shape, Sample::F32, in_metre)?;
    Ok(Scan { metadata, ..Scan::new(heights_m, pitch_m) })
}
