//! Gwyddion simple field: a text header, and heights as `float32` from the next multiple of four bytes on.
//!
//! Gwyddion's user guide describes the format. Without `XReal` and `YReal` a field has no size, which the guide sets to 1.

use crate::sections::sections;
use crate::{
    ChosenMap, Description, Format, Input, MAX_TEXT_BYTES, ReadOptions, Result, Sample, Scan, Tested, TextLimit,
    per_metre, utf8_or_latin1,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["gsf"],
    vendor: "Gwyddion simple field",
    known_by: "`Gwyddion Simple Field 1.0`",
    reads: "float32",
    missing_points: "NaN",
    orientation: "the first stored line is row 0",
    tested: Tested::OtherPrograms,
    ..Description::new(Format::Gsf, |bytes| bytes.starts_with(MAGIC), read)
};

const MAGIC: &[u8] = b"Gwyddion Simple Field 1.0\n";
/// Multiple of bytes at which the heights start, after one to four zeros.
const ALIGNMENT: usize = 4;

/// Reads the heights.
///
/// # Errors
/// No end of the header, no dimensions, another unit than one of length, and heights beyond the end of the file.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Gsf, bytes);
    let start = &bytes[..bytes.len().min(MAX_TEXT_BYTES)];
    let end = start
        .iter()
        .position(|&byte| byte == 0)
        .ok_or_else(|| input.missing("the end of the header", 0, "a byte 0"))?;
    let text = utf8_or_latin1(&start[..end]);
    let header = sections(Format::Gsf, &text, "=", |_| None).swap_remove(0);
    let (ny, nx) = header.shape("YRes", "XRes")?;
    let unit = |key| header.field(key).filter(|unit| !unit.is_empty());
    let z = unit("ZUnits").unwrap_or("m");
    let name = header.field("Title").unwrap_or("field").to_owned();
    let units = ChosenMap::new(Format::Gsf, [(name, z.to_owned())], &ReadOptions::default())?.per_metre;
    let heights_at = (end / ALIGNMENT + 1) * ALIGNMENT;
    let heights_m = input.heights("the heights", heights_at, (ny, nx), Sample::F32, |v| v / units)?;

    let mut scan = Scan { height_unit: unit("ZUnits").map(str::to_owned), ..Scan::new(heights_m, None) };
    let sizes = header.field("XReal").zip(header.field("YReal"));
    match (sizes, per_metre(unit("XYUnits").unwrap_or("m"))) {
        (Some(_), Some(units)) => {
            let size = |key| header.number::<f64>(key);
            scan.pitch_m = Some((size("XReal")? / nx as f64 / units, size("YReal")? / ny as f64 / units));
        }
        (Some(_), None) => {
            let unit = unit("XYUnits").unwrap_or_default();
            scan.warnings
                .push(format!("the lateral unit is `{unit}`, which is not a unit of length; no pixel size was read"));
        }
        (None, _) => scan.warnings.push("the field has no XReal or YReal; no pixel size was read".into()),
    }
    header.add_to(&mut scan, &mut TextLimit::default());
    Ok(scan)
}
