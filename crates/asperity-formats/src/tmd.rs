//! TrueMap TMD: a title line, a comment, the size of the grid, and the heights as `float32`.
//!
//! Title and comment end with a zero byte. Little-endian fields follow: the numbers of columns and rows (`uint32`),
//! the lengths of both axes and, in version 2 only, the offsets of the map in the field of view of the instrument
//! (`float32`). The heights follow row by row. All lengths and heights are in millimetre, as in the routines that
//! GelSight publishes for the format, <https://github.com/gelsightinc/gsmatlab>.
//!
//! Some readers assume micrometre. In a file of TrueMap v6 with a coin of 17.9 mm on 300 points, the axes are 18.96
//! long: these are millimetres, and so is the relief of the coin, 0.35.
//!
//! The layout of version 1 is known only from the description of another reader.
//!
//! The length of an axis is the number of points times their distance: the file states the field of view, not the
//! distance between the outermost points.

use crate::{
    Description, Field, Format, FormatError, Input, ReadOptions, Result, Sample, Scan, Tested, latin1, warn_if,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["tmd"],
    vendor: "TrueMap, GelSight",
    known_by: "`Binary TrueMap Data File`",
    reads: "float32, versions 1 and 2",
    missing_points: "NaN, ±inf",
    orientation: "the first stored line is row 0",
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::Tmd, |bytes| bytes.starts_with(TITLE), read)
};

/// First bytes of the title in every version.
const TITLE: &[u8] = b"Binary TrueMap Data File";
/// Suffix of the title in version 2.
const VERSION_2: &str = "v2.0";
/// Size in bytes of the title in version 2, with the zero at its end.
const TITLE_2_BYTES: usize = 32;
/// Maximum size of the title in bytes.
const MAX_TITLE_BYTES: usize = 64;
/// Size in bytes of the comment if the writer fills it up with zeros.
const FILLED_COMMENT_BYTES: usize = 24;
/// Maximum size of the comment in bytes in GelSight's routines.
const MAX_COMMENT_BYTES: usize = 2048;
const METRES_PER_MILLIMETRE: f64 = 1e-3;

/// Fields after the comment, and the size of all of them in bytes with the offsets.
const COLUMNS: Field = Field("columns", 0);
const ROWS: Field = Field("rows", 4);
const LENGTH_X: Field = Field("the length of x", 8);
const LENGTH_Y: Field = Field("the length of y", 12);
const OFFSETS: [Field; 2] = [Field("offset x", 16), Field("offset y", 20)];
const FIELDS_BYTES: usize = 24;

/// Reads a map.
///
/// # Errors
/// Other versions than 1 and 2, no point along an axis, and fewer heights than stated.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Tmd, bytes);
    let title_end = text_end(&input, "the title", 0, MAX_TITLE_BYTES)?;
    let version = latin1(bytes.get(TITLE.len()..title_end).unwrap_or_default());
    let is_version_2 = version == VERSION_2;
    if !is_version_2 && !version.is_empty() {
        // Ambios files start with the same words. The meaning of their second length is unknown.
        return Err(input.unsupported(format!("the title goes on with `{version}`"), "version 1 (nothing) or `v2.0`"));
    }
    let comment = if is_version_2 { TITLE_2_BYTES } else { title_end + 1 };
    let comment_end = text_end(&input, "the comment", comment, MAX_COMMENT_BYTES)?;
    let offsets = if is_version_2 { &OFFSETS[..] } else { &[] };
    let heights_at = FIELDS_BYTES - 4 * (OFFSETS.len() - offsets.len());
    let fields = fields(&input, comment, comment_end, heights_at);

    let (columns, rows) = (fields.u32(COLUMNS.0, COLUMNS.1)?, fields.u32(ROWS.0, ROWS.1)?);
    let shape = fields.shape((ROWS.0, ROWS.1, rows), (COLUMNS.0, COLUMNS.1, columns))?;
    let in_metre = |z| z * METRES_PER_MILLIMETRE;
    let heights_m = fields.heights("the heights", heights_at, shape, Sample::F32, in_metre)?;
    let pitch_m = |length: Field, points: u32| {
        Ok::<_, FormatError>(f64::from(fields.f32(length.0, length.1)?) / f64::from(points) * METRES_PER_MILLIMETRE)
    };
    let mut scan = Scan::new(heights_m, Some((pitch_m(LENGTH_X, columns)?, pitch_m(LENGTH_Y, rows)?)));
    scan.metadata.insert("comment".into(), latin1(&bytes[comment..comment_end]));
    for Field(name, place) in offsets {
        scan.metadata.insert((*name).into(), format!("{} mm", fields.f32(name, *place)?));
    }
    let surplus = fields.len() - heights_at - shape.0 * shape.1 * Sample::F32.size();
    warn_if!(scan.warnings, surplus > 0, "{surplus} bytes follow the heights and were not read");
    Ok(scan)
}

/// Returns the offset of the zero after a text.
fn text_end(input: &Input, part: &str, start: usize, limit: usize) -> Result<usize> {
    let bytes = input.bytes.get(start..).unwrap_or_default();
    let end = bytes.iter().take(limit).position(|&byte| byte == 0);
    end.map(|length| start + length).ok_or_else(|| input.missing(part, start, "a text that a zero byte ends"))
}

/// Returns the fields after the comment, with the heights at an offset from their start.
///
/// They follow its zero byte, but some writers fill the comment up to 24 bytes. The size of the file shows which
/// applies.
fn fields<'a>(input: &Input<'a>, comment: usize, comment_end: usize, heights_at: usize) -> Input<'a> {
    let (plain, filled) = (input.from(comment_end + 1), input.from(comment + FILLED_COMMENT_BYTES));
    let fits = |fields: &Input| {
        let [columns, rows] = [COLUMNS, ROWS].map(|field| fields.u32(field.0, field.1).map_or(u64::MAX, u64::from));
        columns.saturating_mul(rows).saturating_mul(4).saturating_add(heights_at as u64) == fields.len() as u64
    };
    let is_filled = comment_end < comment + FILLED_COMMENT_BYTES && !fits(&plain) && fits(&filled);
    if is_filled { filled } else { plain }
}
