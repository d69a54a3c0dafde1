//! BCR-STM and BCRF of Image Metrology: a header of lines `key = value`, then the heights row by row.
//!
//! The header has 2048 characters, or `headersize` characters. The `_unicode` variants store it in UTF-16. `bcrstm`
//! holds 16-bit integers, which `bit2nm` converts to heights; `bcrf` holds heights as 32-bit floats. Both are in
//! `zunit`; the default unit is nanometre. `intelmode = 0` declares big-endian numbers.
//!
//! `xlength` is the length of all points, columns · dx: in a file of an instrument with square pixels this makes the
//! two pitches equal to the last digit of the lengths, and columns − 1 does not. The definition calls it the scanning range; Gwyddion and
//! SurfaceTopography read it the same way. In a file of 960 × 600 points, 1777404 nm and 1110878 nm, the pitches differ by 5·10⁻⁷ so, and by
//! 6·10⁻⁴ with one point less. Mountains takes the length for that of columns − 1 pitches, as its MNT file of the measurement shows.
//!
//! 32767 and the largest floats mark missing points. `voidpixels` states their number, or in some files the mark; if
//! it is 0, the integer 32767 is an ordinary height. `zmin` repeats the least height of some files and moves the
//! datum of others; it is ignored.
//!
//! # References
//! The BCR-STM file format, SPIP reference guide, Image Metrology.

use crate::text::header::Header as Notes;
use crate::{
    ByteOrder, Description, Format, Input, ReadOptions, Result, Sample, Scan, Shape, Tested, large, per_metre,
    utf16_text,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["bcr", "bcrf"],
    vendor: "Image Metrology (BCR-STM)",
    known_by: "`fileformat = bcr`, in ASCII or UTF-16",
    reads: "bcrstm (int16) and bcrf (float32), also with a Unicode header, either byte order; lengths cover all points",
    missing_points: "32767 (bcrstm), above 1.7e38 and NaN (bcrf)",
    orientation: "the first stored line is row 0",
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::Bcr, |bytes| Encoding::detect(bytes).is_some(), read)
};

/// Default and maximum number of characters of a header.
const HEADER_CHARACTERS: usize = 2048;
const MAX_HEADER_CHARACTERS: usize = 1 << 20;
/// Marks of missing points.
const VOID_INTEGER: f64 = 32767.0;
const VOID_FLOAT: f64 = 1.7e38;

/// Encoding of the header.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Utf16(ByteOrder),
}

impl Encoding {
    /// Returns the encoding in which bytes start with `fileformat = bcr`.
    fn detect(bytes: &[u8]) -> Option<Self> {
        let encodings = [Self::Ascii, Self::Utf16(ByteOrder::Little), Self::Utf16(ByteOrder::Big)];
        encodings.into_iter().find(|encoding| {
            let start = encoding.text(&bytes[..bytes.len().min(64)]);
            let value = start.strip_prefix("fileformat").and_then(|rest| rest.trim_start().strip_prefix('='));
            value.is_some_and(|value| value.trim_start().starts_with("bcr"))
        })
    }

    /// Returns the size of a character in bytes.
    fn width(self) -> usize {
        match self {
            Self::Ascii => 1,
            Self::Utf16(_) => 2,
        }
    }

    /// Decodes text and removes the byte-order mark.
    fn text(self, bytes: &[u8]) -> String {
        let Self::Utf16(order) = self else { return bytes.iter().map(|&byte| char::from(byte)).collect() };
        utf16_text(bytes, order).trim_start_matches('\u{feff}').into()
    }
}

/// Header of a file.
struct Header<'a> {
    input: Input<'a>,
    notes: Notes,
}

impl<'a> Header<'a> {
    fn parse(input: Input<'a>, text: &str) -> Self {
        let mut notes = Notes::default();
        let lines = text.lines().filter(|line| !line.starts_with(['%', '#']));
        for (key, value) in lines.filter_map(|line| line.split_once('=')) {
            let clean = |text: &'_ str| text.trim_matches(|c: char| c.is_whitespace() || c == '\0').to_owned();
            notes.insert(&clean(key), &clean(value));
        }
        Self { input, notes }
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.notes.value(key)
    }

    /// Returns a number; `None` if the key is absent.
    ///
    /// # Errors
    /// A value that is not a number.
    fn number(&self, key: &str) -> Result<Option<f64>> {
        let parse = |text: &str| text.parse().map_err(|_| self.input.wrong(key, 0, text, "a number"));
        self.get(key).map(parse).transpose()
    }

    /// Returns a number of points.
    fn count(&self, key: &str) -> Result<i64> {
        let text = self.get(key).ok_or_else(|| self.input.missing(key, 0, "the number of points along the axis"))?;
        text.parse().map_err(|_| self.input.wrong(key, 0, text, "a whole number"))
    }

    /// Returns the number of units of an axis per metre, or the text of an unknown unit.
    fn per_metre(&self, key: &str) -> Result<f64, &str> {
        let unit = self.get(key).unwrap_or("nm");
        per_metre(unit.trim_matches(['[', ']'])).ok_or(unit)
    }
}

/// Reads the map.
///
/// # Errors
/// Force curves, other formats of the family, values that are not lengths, a header without the numbers of points,
/// and heights that end early.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Bcr, bytes);
    let encoding = Encoding::detect(bytes).unwrap_or(Encoding::Ascii);
    let header_text = |characters: usize| {
        let length = characters.saturating_mul(encoding.width()).min(input.len());
        encoding.text(&bytes[..length])
    };
    let mut header = Header::parse(input, &header_text(HEADER_CHARACTERS));
    let mut characters = HEADER_CHARACTERS;
    if let Some(size) = header.get("headersize") {
        let wanted = format!("a number of characters, at most {MAX_HEADER_CHARACTERS}");
        let number = size.parse().ok().filter(|&size: &usize| size <= MAX_HEADER_CHARACTERS);
        characters = number.ok_or_else(|| input.wrong("headersize", 0, size, &wanted))?;
        header = Header::parse(input, &header_text(characters));
    }
    if header.number("forcecurve")?.is_some_and(|curves| curves != 0.0) {
        return Err(input.unsupported("the file holds force curves", "a height map"));
    }
    let kind = header.get("fileformat").unwrap_or_default();
    let sample = match kind {
        "bcrstm" | "bcrstm_unicode" => Sample::I16,
        "bcrf" | "bcrf_unicode" => Sample::F32,
        _ => return Err(input.wrong("fileformat", 0, kind, "bcrstm, bcrf, bcrstm_unicode or bcrf_unicode")),
    };
    let (ny, nx) = input.shape(("ypixels", 0, header.count("ypixels")?), ("xpixels", 0, header.count("xpixels")?))?;
    let order = match header.number("intelmode")? {
        Some(0.0) => ByteOrder::Big,
        _ => ByteOrder::Little,
    };
    let start = characters.saturating_mul(encoding.width());
    let mut heights = input.with_order(order).samples("the heights", start, nx * ny, sample)?;

    let mut warnings = Vec::new();
    let per_metre = header.per_metre("zunit").map_err(|unit| {
        input.unsupported(format!("the values are in {}, which is not a length", crate::error::shown(unit)), "heights")
    })?;
    let scale = scale(&header, sample, &mut warnings)?;
    let keeps_code = sample == Sample::I16 && header.number("voidpixels")? == Some(0.0);
    let codes = large::count(&mut heights, |z| {
        let is_code = if sample == Sample::I16 { *z == VOID_INTEGER } else { *z > VOID_FLOAT };
        *z = if is_code && !keeps_code { f64::NAN } else { *z * scale / per_metre };
        is_code
    });
    if keeps_code && codes > 0 {
        warnings.push(format!(
            "{codes} heights equal the code for missing points, but the header says that none are missing; they were kept"
        ));
    }
    let pitch_m = pitch(&header, (ny, nx), &mut warnings)?;
    let heights_m = input.matrix("xpixels", 0, (ny, nx), heights)?;
    let height_unit = crate::unit::name(per_metre).map(str::to_owned);
    Ok(Scan { metadata: header.notes.metadata(), warnings, height_unit, ..Scan::new(heights_m, pitch_m) })
}

/// Returns the factor from a number to a height in the unit of heights.
fn scale(header: &Header<'_>, sample: Sample, warnings: &mut Vec<String>) -> Result<f64> {
    let scale = header.number("bit2nm")?;
    if sample == Sample::F32 {
        if let Some(scale) = scale.filter(|&scale| scale != 1.0) {
            warnings.push(format!("bit2nm is {scale}; it scales integers, and the file holds floats, which were kept"));
        }
        return Ok(1.0);
    }
    let scale = scale.ok_or_else(|| header.input.missing("bit2nm", 0, "the height of one step"))?;
    header.input.factor("bit2nm", 0, scale)
}

/// Returns the pitch in metre if the header states lengths.
fn pitch(header: &Header<'_>, (rows, columns): Shape, warnings: &mut Vec<String>) -> Result<Option<(f64, f64)>> {
    let mut along = |length_key, unit_key, points: usize| {
        let Some(length) = header.number(length_key)? else { return Ok(None) };
        Ok(match header.per_metre(unit_key) {
            Ok(per_metre) => Some(length / points as f64 / per_metre),
            Err(unit) => {
                let unit = crate::error::shown(unit);
                warnings.push(format!("{unit_key} is `{unit}`, which is not a unit of length; no pixel size was read"));
                None
            }
        })
    };
    let (dx_m, dy_m) = (along("xlength", "xunit", columns)?, along("ylength", "yunit", rows)?);
    Ok(dx_m.zip(dy_m))
}
