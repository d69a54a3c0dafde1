//! Digital Surf SUR: a header of 512 bytes, a comment, a private zone, and the heights as integers.
//!
//! A stored integer n is the height n·s + o with the z spacing s and the z offset o, both in the unit of the z steps.
//! n = z_min − 2 marks a point that was not measured when the header says that there are such points. Numbers are
//! little-endian, texts are Latin-1, padded with spaces or zeros.
//!
//! The header names two units per axis, one for the step and one for lengths, and the ratio between them. Only the
//! step's unit gives the scale here; a ratio that contradicts the units is reported.
//!
//! Some readers measure heights from z_min instead of from zero. That moves the datum and nothing else.

use std::collections::BTreeMap;

use ndarray::Array2;

use crate::format::{Codec, Description, Tested};
use crate::input::latin1 as text;
use crate::sample::{ByteOrder, Sample};
use crate::scan::{Dimension, shape};
use crate::unit::per_metre;
use crate::{Format, FormatError, Location, ReadOptions, Scan};

pub(crate) const CODEC: Codec = Codec {
    description: Description {
        format: Format::Sur,
        name: "SUR",
        extensions: &["sur", "pro"],
        vendor: "Digital Surf",
        known_by: "`DIGITAL SURF`, `DSCOMPRESSED`",
        reads: "int16, int32",
        writes: "",
        stores_pitch: true,
        missing_points: "z minimum − 2",
        orientation: "the first stored line is row 0",
        tested: Tested::InstrumentFiles,
    },
    detect,
    read,
    write: None,
};

fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(SIGNATURE) || bytes.starts_with(SIGNATURE_COMPRESSED)
}

/// First bytes of a readable file.
const SIGNATURE: &[u8] = b"DIGITAL SURF";
/// First bytes of a file whose heights are compressed.
const SIGNATURE_COMPRESSED: &[u8] = b"DSCOMPRESSED";

/// Bytes of the header.
const HEADER_BYTES: usize = 512;
/// Value of the format field in files of big-endian machines.
const BIG_ENDIAN: i16 = 257;
/// Distance of the code for missing points below the lowest height.
const VOID_BELOW_MINIMUM: i64 = 2;
/// Relative difference above which a unit ratio contradicts the units.
const RATIO_TOLERANCE: f64 = 1e-3;

/// A field of the header: its name and its first byte.
#[derive(Clone, Copy)]
struct Field(&'static str, usize);

const FORMAT: Field = Field("format", 12);
const OBJECTS: Field = Field("number of objects", 14);
const OBJECT_TYPE: Field = Field("object type", 18);
const OBJECT_NAME: Field = Field("object name", 20);
const OPERATOR_NAME: Field = Field("operator name", 50);
const ACQUISITION_TYPE: Field = Field("acquisition type", 82);
const SPECIAL_POINTS: Field = Field("special points", 86);
const ABSOLUTE: Field = Field("absolute heights", 88);
const BITS_PER_POINT: Field = Field("bits per point", 98);
const Z_MIN: Field = Field("z minimum", 100);
const Z_MAX: Field = Field("z maximum", 104);
const POINTS_PER_LINE: Field = Field("points per line", 108);
const LINES: Field = Field("number of lines", 112);
const POINTS: Field = Field("number of points", 116);
const DATE: Field = Field("date", 306);
const DURATION: Field = Field("measurement duration", 320);
const COMMENT_BYTES: Field = Field("comment size", 334);
const PRIVATE_BYTES: Field = Field("private zone size", 336);
const INVERTED: Field = Field("inverted", 290);
const IMPRINT: Field = Field("imprint", 288);
const LEVELLED: Field = Field("levelled", 292);

/// What the header says about one axis.
#[derive(Clone, Copy)]
struct Axis {
    spacing: Field,
    name: Field,
    step_unit: Field,
    length_unit: Field,
    unit_ratio: Field,
    offset: Field,
}

const X: Axis = Axis {
    spacing: Field("x spacing", 120),
    name: Field("x axis name", 132),
    step_unit: Field("x step unit", 180),
    length_unit: Field("x length unit", 228),
    unit_ratio: Field("x unit ratio", 276),
    offset: Field("x offset", 466),
};
const Y: Axis = Axis {
    spacing: Field("y spacing", 124),
    name: Field("y axis name", 148),
    step_unit: Field("y step unit", 196),
    length_unit: Field("y length unit", 244),
    unit_ratio: Field("y unit ratio", 280),
    offset: Field("y offset", 470),
};
const Z: Axis = Axis {
    spacing: Field("z spacing", 128),
    name: Field("z axis name", 164),
    step_unit: Field("z step unit", 212),
    length_unit: Field("z length unit", 260),
    unit_ratio: Field("z unit ratio", 284),
    offset: Field("z offset", 474),
};
/// Bytes of an axis name or unit.
const AXIS_TEXT_BYTES: usize = 16;
/// Bytes of the names of object and operator.
const NAME_BYTES: usize = 30;

/// What the header's object type says of the first object, by the published numbering.
fn object_kind(code: i16) -> Result<&'static str, &'static str> {
    match code {
        0 => Ok("an object of unknown type"),
        1 => Ok("a profile"),
        2 => Ok("a surface"),
        5 => Ok("a series of surfaces"),
        8 => Ok("a multilayer surface"),
        11 => Ok("a surface with intensity"),
        13 => Ok("a surface with colours"),
        16 => Ok("a surface with colours and intensity"),
        3 => Err("a binary image"),
        4 => Err("a series of profiles"),
        6 => Err("a meridian disc"),
        7 => Err("a multilayer profile"),
        9 => Err("a parallel disc"),
        10 => Err("an intensity image"),
        12 => Err("a colour image"),
        14 | 15 => Err("force curves"),
        17 => Err("a contour"),
        18 => Err("a series of colour images"),
        20 => Err("a spectrum"),
        21 => Err("a hyperspectral map"),
        _ => Err("an object of a type that is not published"),
    }
}

/// The header's bytes and how to take fields from them.
struct Header<'a>(&'a [u8; HEADER_BYTES]);

impl Header<'_> {
    fn bytes<const N: usize>(&self, field: Field) -> [u8; N] {
        std::array::from_fn(|i| self.0[field.1 + i])
    }

    fn i16(&self, field: Field) -> i16 {
        i16::from_le_bytes(self.bytes(field))
    }

    fn u16(&self, field: Field) -> u16 {
        u16::from_le_bytes(self.bytes(field))
    }

    fn i32(&self, field: Field) -> i32 {
        i32::from_le_bytes(self.bytes(field))
    }

    fn f32(&self, field: Field) -> f32 {
        f32::from_le_bytes(self.bytes(field))
    }

    fn text(&self, field: Field, length: usize) -> String {
        text(&self.0[field.1..field.1 + length])
    }

    fn axis_text(&self, field: Field) -> String {
        self.text(field, AXIS_TEXT_BYTES)
    }

    fn dimension(&self, field: Field) -> Dimension {
        Dimension { field: field.0, at: at(field), found: self.i32(field).into() }
    }

    /// A doubt where the units of steps and lengths and the ratio between them disagree.
    fn ratio_warning(&self, axis: Axis) -> Option<String> {
        let (step, length) = (self.axis_text(axis.step_unit), self.axis_text(axis.length_unit));
        let units = per_metre(&step)? / per_metre(&length)?;
        let ratio = f64::from(self.f32(axis.unit_ratio));
        let agrees = |ratio: f64| (ratio / units - 1.0).abs() < RATIO_TOLERANCE;
        // Writers disagree on which of the two units is divided by the other.
        (ratio > 0.0 && !agrees(ratio) && !agrees(1.0 / ratio)).then(|| {
            format!("the {} is {ratio}, but 1 {length} is {units} {step}; the step unit was used", axis.unit_ratio.0)
        })
    }

    /// Day and time of the measurement, `None` when no day is stated.
    fn date(&self) -> Option<String> {
        let [second, minute, hour, day, month, year] = std::array::from_fn(|i| self.i16(Field(DATE.0, DATE.1 + 2 * i)));
        (day > 0 && month > 0).then(|| format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}"))
    }
}

fn at(field: Field) -> Location {
    Location::Byte(field.1 as u64)
}

fn wrong(field: Field, found: impl ToString, wanted: &str) -> FormatError {
    FormatError::Field {
        format: Format::Sur,
        field: field.0.into(),
        at: at(field),
        found: found.to_string(),
        wanted: wanted.into(),
    }
}

fn unsupported(found: impl Into<String>, wanted: &'static str) -> FormatError {
    FormatError::Unsupported { format: Format::Sur, found: found.into(), wanted }
}

/// Reads the first surface of a SUR file.
///
/// # Errors
/// Compressed or big-endian files, objects that are no surface, and headers that the bytes cannot bear out.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan, FormatError> {
    let header = Header(bytes.first_chunk().ok_or_else(|| FormatError::Truncated {
        format: Format::Sur,
        part: "the bytes of the header".into(),
        at: Location::Byte(0),
        found: bytes.len() as u64,
        wanted: HEADER_BYTES as u64,
    })?);
    if bytes.starts_with(SIGNATURE_COMPRESSED) {
        return Err(unsupported(
            "the heights are compressed (signature DSCOMPRESSED)",
            "an uncompressed file (signature DIGITAL SURF); save the surface without compression",
        ));
    }
    if header.i16(FORMAT) == BIG_ENDIAN {
        return Err(unsupported("the numbers are big-endian (format 257)", "little-endian numbers (format 0)"));
    }
    let mut warnings = Vec::new();
    check_kind(&header, &mut warnings)?;

    let sample = match header.i16(BITS_PER_POINT) {
        16 => Sample::I16,
        32 => Sample::I32,
        bits => return Err(wrong(BITS_PER_POINT, bits, "16 or 32")),
    };
    let (ny, nx) = shape(Format::Sur, &header.dimension(LINES), &header.dimension(POINTS_PER_LINE))?;
    let points = header.i32(POINTS);
    if usize::try_from(points) != Ok(nx * ny) {
        return Err(wrong(POINTS, points, &format!("{nx} × {ny} = {}", nx * ny)));
    }
    let comment_start = HEADER_BYTES;
    let private_start = comment_start + usize::from(header.u16(COMMENT_BYTES));
    let data_start = private_start + usize::from(header.u16(PRIVATE_BYTES));
    let data = bytes.get(data_start..).unwrap_or_default();
    let data_bytes = nx * ny * sample.size();
    let Some(data) = data.get(..data_bytes) else {
        return Err(FormatError::Truncated {
            format: Format::Sur,
            part: "the heights".into(),
            at: Location::Byte(data_start as u64),
            found: data.len() as u64,
            wanted: data_bytes as u64,
        });
    };
    let mut heights = sample.decode_all(ByteOrder::Little, data);
    scale(&header, &mut heights, &mut warnings)?;

    let pitch_m = pitch(&header, &mut warnings);
    for axis in [X, Y, Z] {
        warnings.extend(header.ratio_warning(axis));
    }
    let mut metadata = metadata(&header);
    insert(&mut metadata, "comment", text(&bytes[comment_start..private_start]));
    let heights_m = Array2::from_shape_vec((ny, nx), heights).map_err(|_| wrong(POINTS, points, "lines × points"))?;
    Ok(Scan { metadata, warnings, ..Scan::new(heights_m, pitch_m) })
}

/// Refuses objects that are no surface; doubts those that are more.
fn check_kind(header: &Header, warnings: &mut Vec<String>) -> Result<(), FormatError> {
    let kind = object_kind(header.i16(OBJECT_TYPE))
        .map_err(|kind| unsupported(format!("the file holds {kind}"), "a surface"))?;
    let lines = header.i32(LINES);
    match header.i16(OBJECT_TYPE) {
        1 if lines == 1 => return Err(unsupported("the file holds a profile", "a surface")),
        0 | 1 => warnings.push(format!("the file calls itself {kind}; its {lines} lines were read as a surface")),
        _ => (),
    }
    if header.i16(OBJECTS) > 1 {
        warnings.push(format!("{kind} of {} objects; only the first was read", header.i16(OBJECTS)));
    }
    if header.i16(INVERTED) != 0 {
        warnings.push("the file states that it holds an inverted surface; heights were taken as they stand".into());
    }
    Ok(())
}

/// Turns stored integers into metre, NaN where the point was not measured.
fn scale(header: &Header, heights: &mut [f64], warnings: &mut Vec<String>) -> Result<(), FormatError> {
    let unit = header.axis_text(Z.step_unit);
    let per_metre =
        per_metre(&unit).ok_or_else(|| wrong(Z.step_unit, unit, "a unit of length (m, cm, mm, µm, nm, …)"))?;
    let spacing_m = f64::from(header.f32(Z.spacing)) / per_metre;
    if !(spacing_m.is_finite() && spacing_m != 0.0) {
        return Err(wrong(Z.spacing, header.f32(Z.spacing), "a finite number other than 0"));
    }
    let offset_m = f64::from(header.f32(Z.offset)) / per_metre;
    if !offset_m.is_finite() {
        return Err(wrong(Z.offset, header.f32(Z.offset), "a finite number"));
    }
    let (low, high) = (i64::from(header.i32(Z_MIN)), i64::from(header.i32(Z_MAX)));
    // Integers of 32 bits and their neighbours are exact as f64.
    let void = (low - VOID_BELOW_MINIMUM) as f64;
    let marked = header.i16(SPECIAL_POINTS) != 0;
    let (mut coded, mut outside) = (0_usize, 0_usize);
    for z in heights {
        let is_code = *z == void;
        coded += usize::from(is_code);
        outside += usize::from(!is_code && (*z < low as f64 || *z > high as f64));
        *z = if is_code && marked { f64::NAN } else { *z * spacing_m + offset_m };
    }
    if coded > 0 && !marked {
        warnings.push(format!(
            "{coded} heights equal the code for missing points, but the header says that none are missing; they were kept"
        ));
    }
    if outside > 0 && low < high {
        warnings.push(format!("{outside} heights are outside of the stated range and may be saturated"));
    }
    Ok(())
}

/// The pitch in metre where both axes are lengths.
fn pitch(header: &Header, warnings: &mut Vec<String>) -> Option<(f64, f64)> {
    let mut along = |axis: Axis| {
        let unit = header.axis_text(axis.step_unit);
        let per_metre = per_metre(&unit);
        if per_metre.is_none() {
            warnings.push(format!(
                "the {} is `{unit}`, which is no unit of length; no pixel size was read",
                axis.step_unit.0
            ));
        }
        per_metre.map(|per_metre| f64::from(header.f32(axis.spacing)) / per_metre)
    };
    let (dx_m, dy_m) = (along(X), along(Y));
    dx_m.zip(dy_m)
}

fn insert(metadata: &mut BTreeMap<String, String>, key: &str, value: String) {
    if !value.is_empty() {
        metadata.insert(key.into(), value);
    }
}

/// What else the header says.
fn metadata(header: &Header) -> BTreeMap<String, String> {
    let mut metadata = BTreeMap::new();
    for field in [OBJECT_NAME, OPERATOR_NAME] {
        insert(&mut metadata, field.0, header.text(field, NAME_BYTES));
    }
    for field in [OBJECT_TYPE, ACQUISITION_TYPE, ABSOLUTE, IMPRINT, INVERTED, LEVELLED] {
        insert(&mut metadata, field.0, header.i16(field).to_string());
    }
    for axis in [X, Y, Z] {
        for field in [axis.name, axis.step_unit, axis.length_unit] {
            insert(&mut metadata, field.0, header.axis_text(field));
        }
        insert(&mut metadata, axis.offset.0, header.f32(axis.offset).to_string());
    }
    insert(&mut metadata, DATE.0, header.date().unwrap_or_default());
    let duration_s = header.f32(DURATION);
    if duration_s > 0.0 {
        insert(&mut metadata, DURATION.0, duration_s.to_string());
    }
    metadata
}
