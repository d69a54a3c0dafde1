//! Wyko ASCII: a line for each block of [`crate::opd`] with its name, type, length and value, then the numbers of the array.
//!
//! The first line ends with three flags; the second is 1 if heights are in nanometre instead of wavelengths. After `RAW_DATA` follow
//! `X Size` lines of `Y Size` numbers: like the arrays of OPD they are columns, from the bottom up. One reader takes the lines as rows and
//! so mirrors the map at its diagonal. Readers disagree on whether `Mult` divides the numbers, as in OPD, or multiplies them, so that
//! only 1 is accepted.

use std::collections::BTreeMap;

use crate::text::rows::{self, Layout};
use crate::text::separator::Separator;
use crate::{
    Description, Format, FormatError, Input, MAX_TEXT_BYTES, ReadOptions, Result, Scan, TextLimit, large, refuse_if,
    utf8_or_latin1, warn_if,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["asc"],
    vendor: "Wyko (Veeco, Bruker)",
    known_by: "`Wyko ASCII Data File Format`",
    reads: "RAW_DATA, OPD and SAMPLE_DATA as text",
    missing_points: "Bad",
    orientation: "columns from the bottom up; row 0 is the last number of every line",
    ..Description::new(Format::WykoAscii, |bytes| bytes.starts_with(MAGIC), read)
};

const MAGIC: &[u8] = b"Wyko ASCII Data File Format";
/// Names of the blocks that hold heights.
const HEIGHTS: [&str; 5] = ["RAW_DATA", "RAW DATA", "Raw", "OPD", "SAMPLE_DATA"];

/// Reads the first array of heights.
///
/// # Errors
/// No array of heights, a header without sizes or wavelength, and fewer numbers than declared.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::WykoAscii, bytes);
    let mut fields = BTreeMap::new();
    let (mut at, mut lines) = (0, 0);
    let mut room = TextLimit::default();
    loop {
        let rest = &bytes[at..bytes.len().min(MAX_TEXT_BYTES)];
        let end = rest.iter().position(|&byte| byte == b'\n');
        let end = end.ok_or_else(|| input.missing("the heights", at, "a block RAW_DATA, Raw, OPD or SAMPLE_DATA"))?;
        let line = utf8_or_latin1(&rest[..end]);
        (at, lines) = (at + end + 1, lines + 1);
        let mut cells = line.split('\t').map(str::trim);
        let name = cells.next().unwrap_or_default();
        if HEIGHTS.contains(&name) {
            break;
        }
        // Sizes have a value only; blocks have a type and a length before it.
        let value = cells.next_back().unwrap_or_default();
        if room.take(line.len()) {
            fields.insert(name.to_owned(), value.to_owned());
        }
    }
    let number = |name: &str| match fields.get(name) {
        Some(text) => text.parse::<f64>().map(Some).map_err(|_| input.wrong(name, 0, text, "a number")),
        None => Ok(None),
    };
    let required = |name: &str| number(name)?.ok_or_else(|| input.missing(name, 0, "a number in the header"));
    let size = |name| Ok::<_, FormatError>((name, 0, required(name)?.clamp(0.0, 1e18) as u64));
    let (ny, nx) = input.shape(size("Y Size")?, size("X Size")?)?;
    let first = bytes[..at].split(|&byte| byte == b'\n').next().unwrap_or_default();
    let is_nanometre = utf8_or_latin1(first).split_ascii_whitespace().rev().nth(1) == Some("1");
    if number("Mult")?.is_some_and(|mult| mult != 1.0) {
        return Err(
            input.unsupported("Mult, whose meaning in this format is unknown, is not 1", "the measurement as OPD")
        );
    }
    let scale_nm = if is_nanometre { 1.0 } else { required("Wavelength")? };

    // Other arrays may follow.
    let mut ends = bytes[at..].iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(place, _)| at + place + 1);
    let end = ends.nth(nx - 1).unwrap_or(bytes.len());
    let layout =
        Layout::new(Format::WykoAscii, Separator::Space, b"", b'\n').with_columns(ny).with_decimal(options.decimal);
    let columns = rows::read(&bytes[at..end], &layout, lines)?.values;
    refuse_if!(columns.len() != ny * nx, input.wrong("number of lines", at, columns.len() / ny, &nx.to_string()));
    let mut heights = large::transposed(&columns, (nx, ny));
    large::map(&mut heights, |z| z * scale_nm / 1e9);
    large::flip(&mut heights, nx);
    let heights_m = input.matrix("X Size", 0, (ny, nx), heights)?;
    let pixel_m = number("Pixel_size")?.map(|millimetre| millimetre / 1e3);
    let aspect = number("Aspect")?.unwrap_or(1.0);
    let mut scan = Scan::new(heights_m, pixel_m.map(|dx_m| (dx_m, dx_m * aspect)));
    warn_if!(scan.warnings, pixel_m.is_none(), "the file has no block `Pixel_size`; no pixel size was read");
    scan.metadata = fields;
    Ok(scan)
}
