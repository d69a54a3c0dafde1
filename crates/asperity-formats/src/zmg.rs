//! Zeta Instruments (KLA) ZMG: a header of 205 bytes, a comment, and the heights as `i16` in steps along z.
//!
//! Steps along x, y and z are in µm. The vendor published no description. SurfaceTopography and surfalize agree on the
//! layout; no mark of missing points is known. Numbers are little-endian.

use crate::input::Kind;
use crate::{Description, Field, Format, Input, ReadOptions, Result, Sample, Scan};

pub(crate) const CODEC: Description = Description {
    extensions: &["zmg"],
    vendor: "Zeta Instruments (KLA)",
    known_by: "`Zeta-Instruments`",
    reads: "int16",
    orientation: "the first stored line is row 0",
    ..Description::new(Format::Zmg, |bytes| bytes.starts_with(b"Zeta-Instruments"), read)
};

const COLUMNS: Field = Field("points along x", 85);
const ROWS: Field = Field("points along y", 89);
const STEP_X: Field = Field("step along x", 97);
const STEP_Y: Field = Field("step along y", 101);
const STEP_Z: Field = Field("step along z", 105);
const COMMENT_SIZE: Field = Field("size of the comment", 117);
const HEADER_BYTES: usize = 205;
const MICROMETRES: f64 = 1e6;

/// Reads the heights.
///
/// # Errors
/// A step along z of 0, and data beyond the end of the file.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Zmg, bytes);
    let (rows, columns) = (input.u32(ROWS.0, ROWS.1)?, input.u32(COLUMNS.0, COLUMNS.1)?);
    let shape = input.shape((ROWS.0, ROWS.1, rows), (COLUMNS.0, COLUMNS.1, columns))?;
    let step = |field: Field| Ok(f64::from(input.f32(field.0, field.1)?) / MICROMETRES);
    let pitch_m = Some((step(STEP_X)?, step(STEP_Y)?));
    let step_um = input.factor(STEP_Z.0, STEP_Z.1, input.f32(STEP_Z.0, STEP_Z.1)?)?;
    let comment_bytes = input.u32(COMMENT_SIZE.0, COMMENT_SIZE.1)? as usize;
    let metadata = input.values(&[("comment", HEADER_BYTES, Kind::Text(comment_bytes))])?;
    let in_metre = |z: f64| z * step_um / MICROMETRES;
    let heights_m = input.heights("the heights", HEADER_BYTES + comment_bytes, shape, Sample::I16, in_metre)?;
    Ok(Scan { metadata, ..Scan::new(heights_m, pitch_m) })
}
