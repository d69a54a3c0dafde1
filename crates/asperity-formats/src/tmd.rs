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

use crate::{Description, Format, Input, ReadOptions, Result, Sample, Scan, Tested, latin1, warn_if};

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

/// Place of the fields after the comment.
#[derive(Clone, Copy)]
struct Layout {
    columns: usize,
    has_offsets: bool,
}

impl Layout {
    fn rows(self) -> usize {
        self.columns + 4
    }

    fn lengths(self) -> [usize; 2] {
        [self.columns + 8, self.columns + 12]
    }

    fn offsets(self) -> [usize; 2] {
        [self.columns + 16, self.columns + 20]
    }

    fn heights(self) -> usize {
        self.columns + if self.has_offsets { 24 } else { 16 }
    }

    /// Returns the size of the whole file in bytes from the stated numbers of columns and rows.
    fn file_bytes(self, input: &Input) -> Result<u64> {
        let columns = u64::from(input.u32("the number of columns", self.columns)?);
        let rows = u64::from(input.u32("the number of rows", self.rows())?);
        Ok((self.heights() as u64).saturating_add(columns.saturating_mul(rows).saturating_mul(4)))
    }
}

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
    let layout = layout(&input, comment, comment_end, is_version_2)?;

    let (columns, rows) = (input.u32("columns", layout.columns)?, input.u32("rows", layout.rows())?);
    let shape = input.shape(("rows", layout.rows(), rows), ("columns", layout.columns, columns))?;
    let in_metre = |z| z * METRES_PER_MILLIMETRE;
    let heights_m = input.heights("the heights", layout.heights(), shape, Sample::F32, in_metre)?;
    let [length_x, length_y] = layout.lengths();
    let dx_m = f64::from(input.f32("the length of x", length_x)?) / f64::from(columns) * METRES_PER_MILLIMETRE;
    let dy_m = f64::from(input.f32("the length of y", length_y)?) / f64::from(rows) * METRES_PER_MILLIMETRE;

    let mut scan = Scan::new(heights_m, Some((dx_m, dy_m)));
    scan.metadata.insert("comment".into(), latin1(&bytes[comment..comment_end]));
    if layout.has_offsets {
        for (name, place) in ["offset x", "offset y"].into_iter().zip(layout.offsets()) {
            scan.metadata.insert(name.into(), format!("{} mm", input.f32(name, place)?));
        }
    }
    let surplus = (bytes.len() as u64).saturating_sub(layout.file_bytes(&input)?);
    warn_if!(scan.warnings, surplus > 0, "{surplus} bytes follow the heights and were not read");
    Ok(scan)
}

/// Returns the offset of the zero after a text.
fn text_end(input: &Input, part: &str, start: usize, limit: usize) -> Result<usize> {
    let bytes = input.bytes.get(start..).unwrap_or_default();
    let end = bytes.iter().take(limit).position(|&byte| byte == 0);
    end.map(|length| start + length).ok_or_else(|| input.missing(part, start, "a text that a zero byte ends"))
}

/// Returns the place of the fields after the comment.
///
/// They follow its zero byte, but some writers fill the comment up to 24 bytes. The size of the file shows which
/// applies.
fn layout(input: &Input, comment: usize, comment_end: usize, has_offsets: bool) -> Result<Layout> {
    let plain = Layout { columns: comment_end + 1, has_offsets };
    let filled = Layout { columns: comment + FILLED_COMMENT_BYTES, has_offsets };
    let fits = |layout: Layout| layout.file_bytes(input).is_ok_and(|bytes| bytes == input.len() as u64);
    let is_filled = comment_end < filled.columns && !fits(plain) && fits(filled);
    Ok(if is_filled { filled } else { plain })
}
