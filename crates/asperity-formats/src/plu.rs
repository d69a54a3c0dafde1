//! Sensofar PLU: a header of 500 bytes, then one or more layers of heights.
//!
//! A layer consists of the numbers of rows and columns (both `u32`), the heights as `f32` in µm with 1000001 for a
//! lost signal, the lowest and the highest height, and as many colour images of three bytes per point as the header
//! states. Readers that expect the heights directly after the header shift them by the two numbers of the shape.
//! Numbers are little-endian.
//!
//! The file has no signature. It starts with the date in the form of the C function `ctime`, in a field of 128 bytes.

mod names;

use std::collections::BTreeMap;

use crate::input::Kind;
use crate::{Description, Field, Format, Input, ReadOptions, Result, Sample, Scan, Tested};

pub(crate) const CODEC: Description = Description {
    extensions: &["plu", "apx"],
    vendor: "Sensofar",
    known_by: "a date in words at byte 0, a measurement type from 0 to 8 at byte 428, a known version at byte 490",
    reads: "topographies; layers; no images, profiles, thicknesses or maps of coordinates",
    missing_points: "1000001",
    orientation: "the first stored row is row 0, as in the colour image of the same file",
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::Plu, detect, read)
};

/// Size of the header in bytes.
const HEADER_BYTES: usize = 500;
/// Sizes in bytes of the shape before the heights of a layer, and of the range after them.
const SHAPE_BYTES: usize = 8;
const RANGE_BYTES: usize = 8;
/// Size in bytes of a point of a colour image.
const COLOUR_BYTES: usize = 3;
/// Height of a point whose signal was lost; exact as `f32`.
pub(crate) const LOST: f64 = 1_000_001.0;
/// Number of micrometres per metre.
const PER_METRE: f64 = 1e6;

const ROWS: Field = Field("yres", 388);
const COLUMNS: Field = Field("xres", 392);
const PITCH_X: Field = Field("mppx", 404);
const PITCH_Y: Field = Field("mppy", 408);
const TYPE: Field = Field("type", 428);
const ALGORITHM: Field = Field("algorithm", 432);
const METHOD: Field = Field("method", 436);
const OBJECTIVE: Field = Field("objective", 440);
const AREA: Field = Field("area", 444);
const LAYERS: Field = Field("num_layers", 489);
const VERSION: Field = Field("version", 490);
const HARDWARE: Field = Field("config_hardware", 491);
const IMAGES: Field = Field("num_images", 492);

/// Further fields that become metadata, with the unit of each.
const NOTES: [(&str, usize, Kind, &str); 7] = [
    ("date", 0, Kind::Text(128), ""),
    ("time", 128, Kind::U32, " s since 1970"),
    ("user comment", 132, Kind::Text(256), ""),
    ("x_0", 412, Kind::F32, " µm"),
    ("y_0", 416, Kind::F32, " µm"),
    ("z_0", 424, Kind::F32, " µm"),
    ("factor_delmacio", 496, Kind::U32, ""),
];
/// Fields on the scan of the field of view. Other fields have these offsets if the area is given by coordinates.
const SCAN_NOTES: [(&str, usize, Kind, &str); 5] = [
    ("na", 464, Kind::U32, ""),
    ("incr_z", 468, Kind::F64, " µm"),
    ("range", 476, Kind::F32, " µm"),
    ("n_planes", 480, Kind::U32, ""),
    ("tpc_umbral_F", 484, Kind::U32, " %"),
];

/// Length of a date such as `Fri Mar 10 16:35:59 2023`.
const CTIME_BYTES: usize = 24;
/// Measurement type of a height map.
const TOPOGRAPHY: u32 = 3;
/// Area of measurements at points that the user selected.
const COORDINATES: u32 = 6;
/// Versions since 2006 count down from 255. Version 0, of 2000, is the first.
const NEW_VERSIONS: std::ops::RangeInclusive<u8> = 0xf0..=0xff;

/// Returns whether bytes start with a date and hold numbers that text cannot contain: three of the four bytes of a
/// small type are zero.
fn detect(bytes: &[u8]) -> bool {
    let input = Input::new(Format::Plu, bytes);
    bytes.len() >= HEADER_BYTES
        && bytes.first_chunk().is_some_and(is_ctime)
        && bytes[CTIME_BYTES..].first().is_some_and(|&byte| byte == 0 || byte.is_ascii_whitespace())
        && input.u32(TYPE.0, TYPE.1).is_ok_and(|kind| (kind as usize) < names::TYPES.len())
        && input.u8(VERSION.0, VERSION.1).is_ok_and(|version| version == 0 || NEW_VERSIONS.contains(&version))
}

/// Returns whether a text is a date such as `Fri Mar 10 16:35:59 2023`. The day of the month may start with a space.
fn is_ctime(text: &[u8; CTIME_BYTES]) -> bool {
    let Ok(text) = std::str::from_utf8(text) else { return false };
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    let [day, month, day_of_month, time, year] = words.as_slice() else { return false };
    let digits = |text: &str, most: u32| {
        text.bytes().all(|byte| byte.is_ascii_digit()) && text.parse::<u32>().is_ok_and(|number| number <= most)
    };
    let clock: Vec<&str> = time.split(':').collect();
    ["Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"].contains(day)
        && ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"].contains(month)
        && digits(day_of_month, 31)
        && matches!(clock.as_slice(), [hour, minute, second] if digits(hour, 23) && digits(minute, 59) && digits(second, 60))
        && year.len() == 4
        && digits(year, 9999)
}

/// Layer of heights: offset, rows and columns.
struct Layer {
    start: usize,
    ny: usize,
    nx: usize,
}

/// Reads a layer of a topography.
///
/// # Errors
/// Measurements of other types, and heights beyond the end of the file.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Plu, bytes);
    input.take("the bytes of the header", 0, HEADER_BYTES)?;
    let kind = input.u32(TYPE.0, TYPE.1)?;
    if kind != TOPOGRAPHY {
        let found = format!("the file holds {}", names::name_of(&names::TYPES, kind));
        return Err(input.unsupported(found, "a topography (type 3)"));
    }
    let mut warnings = Vec::new();
    let layers = layers(&input, &mut warnings)?;
    let channels: Vec<String> = (1..=layers.len()).map(|number| format!("layer {number}")).collect();
    let channel = options.choose(Format::Plu, &channels)?;
    let Layer { start, ny, nx } = layers[channel];

    let stated = (input.u32(ROWS.0, ROWS.1)?, input.u32(COLUMNS.0, COLUMNS.1)?);
    if (stated.0 as usize, stated.1 as usize) != (ny, nx) {
        warnings.push(format!(
            "the header states {} × {} points, the layer holds {nx} × {ny}; the pixel size may be wrong",
            stated.1, stated.0
        ));
    }
    let in_metre = |z| if z == LOST { f64::NAN } else { z / PER_METRE };
    let heights_m = input.heights("the heights", start, (ny, nx), Sample::F32, in_metre)?;
    // Micrometres per pixel are the distance between points; n of them make the field of view.
    let pitch_m = Some((
        f64::from(input.f32(PITCH_X.0, PITCH_X.1)?) / PER_METRE,
        f64::from(input.f32(PITCH_Y.0, PITCH_Y.1)?) / PER_METRE,
    ));
    Ok(Scan { metadata: metadata(&input)?, warnings, ..Scan::new(heights_m, pitch_m) }.with_channels(channels, channel))
}

/// Returns the layers in the file: the first one, and the further ones that the header states.
fn layers(input: &Input, warnings: &mut Vec<String>) -> Result<Vec<Layer>> {
    // Early files leave this number at zero.
    let stated = input.u8(LAYERS.0, LAYERS.1)?.max(1);
    let images = usize::from(input.u8(IMAGES.0, IMAGES.1)?);
    let mut layers = vec![layer(input, HEADER_BYTES)?];
    while layers.len() < usize::from(stated) {
        let Some(Layer { start, ny, nx }) = layers.last() else { break };
        let point_bytes = Sample::F32.size() + images * COLOUR_BYTES;
        let next = (ny * nx).saturating_mul(point_bytes).saturating_add(start + RANGE_BYTES);
        match layer(input, next) {
            Ok(layer) => layers.push(layer),
            Err(error) => {
                warnings
                    .push(format!("the header states {stated} layers; from number {} on: {error}", layers.len() + 1));
                break;
            }
        }
    }
    Ok(layers)
}

fn layer(input: &Input, at: usize) -> Result<Layer> {
    let columns_at = at.saturating_add(4);
    let rows = input.u32("the number of rows", at)?;
    let columns = input.u32("the number of columns", columns_at)?;
    let (ny, nx) = input.shape(("the number of rows", at, rows), ("the number of columns", columns_at, columns))?;
    let start = at + SHAPE_BYTES;
    input.take("the heights", start, ny * nx * Sample::F32.size())?;
    Ok(Layer { start, ny, nx })
}

/// Returns further fields of the header.
fn metadata(input: &Input) -> Result<BTreeMap<String, String>> {
    let mut metadata = BTreeMap::new();
    let area = input.u32(AREA.0, AREA.1)?;
    for (name, at, kind, unit) in NOTES.iter().chain(SCAN_NOTES.iter().filter(|_| area != COORDINATES)) {
        metadata.insert((*name).to_owned(), input.value(name, *at, *kind)? + unit);
    }
    let mut insert = |field: Field, value: String| metadata.insert(field.0.to_owned(), value);
    insert(TYPE, names::name_of(&names::TYPES, TOPOGRAPHY));
    insert(ALGORITHM, names::name_of(&names::ALGORITHMS, input.u32(ALGORITHM.0, ALGORITHM.1)?));
    insert(METHOD, names::name_of(&names::METHODS, input.u32(METHOD.0, METHOD.1)?));
    insert(OBJECTIVE, names::objective(input.u32(OBJECTIVE.0, OBJECTIVE.1)?));
    insert(AREA, names::name_of(&names::AREAS, area));
    insert(VERSION, names::version(input.u8(VERSION.0, VERSION.1)?));
    insert(HARDWARE, names::name_of(&names::HARDWARE, input.u8(HARDWARE.0, HARDWARE.1)?.into()));
    Ok(metadata)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_distinguished_from_other_texts() {
        for (text, is_date) in [
            (b"Fri Mar 10 16:35:59 2023", true),
            (b"Sat Jan  1 00:00:00 2000", true),
            (b"Fre Mar 10 16:35:59 2023", false),
            (b"Fri Mrz 10 16:35:59 2023", false),
            (b"Fri Mar 32 16:35:59 2023", false),
            (b"Fri Mar 10 24:35:59 2023", false),
            (b"Fri Mar 10 16:35:+9 2023", false),
            (b"Fri Mar 10 16:35:59  202", false),
            (b"Fri Mar 10 16:35-59 2023", false),
        ] {
            assert_eq!(is_ctime(text), is_date, "{}", text.escape_ascii());
        }
    }
}
