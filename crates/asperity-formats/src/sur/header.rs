//! Header of an object: fields, axes and metadata.

use std::collections::BTreeMap;

use crate::input::Kind;
use crate::{ByteOrder, Field, FormatError, Input, Result, Sample, date, per_metre};

/// First bytes of an object.
pub(super) const SIGNATURE: &[u8; 12] = b"DIGITAL SURF";
/// First bytes of an object whose heights are compressed.
pub(super) const SIGNATURE_COMPRESSED: &[u8; 12] = b"DSCOMPRESSED";
/// Difference between the lowest height and the code for missing points.
pub(super) const VOID_BELOW_MINIMUM: i32 = 2;

/// Size of the header in bytes.
pub(super) const HEADER_BYTES: usize = 512;
/// Value of the format field in files of big-endian machines. It is the same in either byte order.
const BIG_ENDIAN: i16 = 257;
/// Relative difference above which a unit ratio contradicts the units.
const RATIO_TOLERANCE: f64 = 1e-3;

const FORMAT: Field = Field("format", 12);
pub(super) const OBJECTS: Field = Field("number of objects", 14);
pub(super) const OBJECT_TYPE: Field = Field("object type", 18);
pub(super) const OBJECT_NAME: Field = Field("object name", 20);
pub(super) const OPERATOR_NAME: Field = Field("operator name", 50);
pub(super) const SPECIAL_POINTS: Field = Field("special points", 86);
pub(super) const BITS_PER_POINT: Field = Field("bits per point", 98);
pub(super) const Z_MIN: Field = Field("z minimum", 100);
pub(super) const Z_MAX: Field = Field("z maximum", 104);
const POINTS_PER_LINE: Field = Field("points per line", 108);
pub(super) const LINES: Field = Field("number of lines", 112);
const POINTS: Field = Field("number of points", 116);
pub(super) const INVERTED: Field = Field("inverted", 290);
pub(super) const DATE: Field = Field("date", 306);
const DURATION: Field = Field("measurement duration", 320);
pub(super) const COMMENT_BYTES: Field = Field("comment size", 334);
pub(super) const PRIVATE_BYTES: Field = Field("private zone size", 336);
const CLIENT_ZONE: Field = Field("client zone", 338);
/// Further fields that become metadata.
const NOTES: [(&str, usize, Kind); 8] = [
    (OBJECT_NAME.0, OBJECT_NAME.1, Kind::Text(NAME_BYTES)),
    (OPERATOR_NAME.0, OPERATOR_NAME.1, Kind::Text(NAME_BYTES)),
    (OBJECT_TYPE.0, OBJECT_TYPE.1, Kind::I16),
    ("acquisition type", 82, Kind::I16),
    ("absolute heights", 88, Kind::I16),
    ("imprint", 288, Kind::I16),
    (INVERTED.0, INVERTED.1, Kind::I16),
    ("levelled", 292, Kind::I16),
];
/// Fields of the axis of a series. An empty name means that there is none.
const SERIES_NOTES: [(&str, usize, Kind); 4] = [
    ("t axis name", 486, Kind::Text(13)),
    ("t step unit", 499, Kind::Text(13)),
    ("t spacing", 478, Kind::F32),
    ("t offset", 482, Kind::F32),
];

/// Fields of one axis.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    pub(super) spacing: Field,
    name: Field,
    pub(super) step_unit: Field,
    length_unit: Field,
    unit_ratio: Field,
    pub(super) offset: Field,
}

impl Axis {
    /// Returns the fields of axis 0, 1 or 2. The header lists each field for all axes: numbers of 4 bytes, texts of 16.
    const fn new(axis: usize, [spacing, name, step, length, ratio, offset]: [&'static str; 6]) -> Self {
        Self {
            spacing: Field(spacing, 120 + 4 * axis),
            name: Field(name, 132 + AXIS_TEXT_BYTES * axis),
            step_unit: Field(step, 180 + AXIS_TEXT_BYTES * axis),
            length_unit: Field(length, 228 + AXIS_TEXT_BYTES * axis),
            unit_ratio: Field(ratio, 276 + 4 * axis),
            offset: Field(offset, 466 + 4 * axis),
        }
    }
}

pub(super) const X: Axis =
    Axis::new(0, ["x spacing", "x axis name", "x step unit", "x length unit", "x unit ratio", "x offset"]);
pub(super) const Y: Axis =
    Axis::new(1, ["y spacing", "y axis name", "y step unit", "y length unit", "y unit ratio", "y offset"]);
pub(super) const Z: Axis =
    Axis::new(2, ["z spacing", "z axis name", "z step unit", "z length unit", "z unit ratio", "z offset"]);
/// Size in bytes of an axis name or unit, and of the client zone.
pub(super) const AXIS_TEXT_BYTES: usize = 16;
pub(super) const CLIENT_ZONE_BYTES: usize = 128;
/// Size in bytes of the names of object and operator.
pub(super) const NAME_BYTES: usize = 30;

/// Header of an object.
#[derive(Clone, Copy)]
pub(super) struct Header<'a> {
    /// File from the header on.
    pub(super) input: Input<'a>,
    pub(super) order: ByteOrder,
}

impl<'a> Header<'a> {
    /// Opens the header at the start of `input`.
    pub(super) fn open(input: Input<'a>) -> Result<Self> {
        input.take("the bytes of the header", 0, HEADER_BYTES)?;
        let [little, big] =
            [ByteOrder::Little, ByteOrder::Big].map(|order| Self { input: input.with_order(order), order });
        // Some writers declare big-endian numbers and write little-endian ones. The size of a point decides: 16 and 32
        // in the wrong order are 4096 and 8192.
        let is_big = little.i16(FORMAT)? == BIG_ENDIAN && matches!(big.i16(BITS_PER_POINT)?, 16 | 32);
        Ok(if is_big { big } else { little })
    }

    pub(super) fn i16(&self, Field(name, at): Field) -> Result<i16> {
        self.input.i16(name, at)
    }

    pub(super) fn i32(&self, Field(name, at): Field) -> Result<i32> {
        self.input.i32(name, at)
    }

    pub(super) fn f32(&self, Field(name, at): Field) -> Result<f32> {
        self.input.f32(name, at)
    }

    pub(super) fn text(&self, Field(name, at): Field, length: usize) -> Result<String> {
        self.input.latin1(name, at, length)
    }

    /// Returns a unit without the brackets that some writers put around it.
    pub(super) fn unit(&self, field: Field) -> Result<String> {
        let text = self.text(field, AXIS_TEXT_BYTES)?;
        Ok(text.trim_matches(['(', ')', '[', ']', ' ']).to_owned())
    }

    pub(super) fn wrong(&self, Field(name, at): Field, found: impl ToString, wanted: &str) -> FormatError {
        self.input.wrong(name, at, found, wanted)
    }

    /// Returns the type of the stored numbers.
    pub(super) fn sample(&self) -> Result<Sample> {
        let bits = self.i16(BITS_PER_POINT)?;
        let sample = if matches!(bits, 16 | 32) { Sample::integer(bits as u64, true) } else { None };
        sample.ok_or_else(|| self.wrong(BITS_PER_POINT, bits, "16 or 32"))
    }

    /// Returns the checked numbers of lines and points per line.
    pub(super) fn shape(&self) -> Result<(usize, usize)> {
        let [lines, columns] = [LINES, POINTS_PER_LINE].map(|field| Ok((field.0, field.1, self.i32(field)?)));
        let (ny, nx) = self.input.shape(lines?, columns?)?;
        let points = self.i32(POINTS)?;
        if usize::try_from(points) != Ok(nx * ny) {
            return Err(self.wrong(POINTS, points, &format!("{nx} × {ny} = {}", nx * ny)));
        }
        Ok((ny, nx))
    }

    /// Returns a warning if the units of steps and lengths and the ratio between them disagree.
    pub(super) fn ratio_warning(&self, axis: Axis) -> Result<Option<String>> {
        let (step, length) = (self.unit(axis.step_unit)?, self.unit(axis.length_unit)?);
        let ratio = f64::from(self.f32(axis.unit_ratio)?);
        let Some((per_step, per_length)) = per_metre(&step).zip(per_metre(&length)) else { return Ok(None) };
        let units = per_step / per_length;
        let agrees = |ratio: f64| (ratio / units - 1.0).abs() < RATIO_TOLERANCE;
        // Writers disagree on the direction of the ratio.
        Ok((ratio > 0.0 && !agrees(ratio) && !agrees(1.0 / ratio)).then(|| {
            format!("the {} is {ratio}, but 1 {length} is {units} {step}; the step unit was used", axis.unit_ratio.0)
        }))
    }

    /// Returns date and time of the measurement; empty if no day is stated.
    fn date(&self) -> Result<String> {
        let part = |place: usize| self.input.i16(DATE.0, DATE.1 + 2 * place);
        let date @ [_, month, day, ..] = [part(5)?, part(4)?, part(3)?, part(2)?, part(1)?, part(0)?];
        Ok(if day > 0 && month > 0 { date::text(date) } else { String::new() })
    }

    /// Returns further fields of the header.
    pub(super) fn metadata(&self) -> Result<BTreeMap<String, String>> {
        let mut metadata = self.input.values(&NOTES)?;
        for axis in [X, Y, Z] {
            for Field(name, at) in [axis.name, axis.step_unit, axis.length_unit] {
                metadata.insert(name.to_owned(), self.input.latin1(name, at, AXIS_TEXT_BYTES)?);
            }
            metadata.insert(axis.offset.0.to_owned(), self.f32(axis.offset)?.to_string());
        }
        metadata.insert(DATE.0.to_owned(), self.date()?);
        if self.f32(DURATION)? > 0.0 {
            metadata.insert(DURATION.0.to_owned(), self.f32(DURATION)?.to_string());
        }
        // The writing program owns this zone and may store binary data in it.
        let client = self.text(CLIENT_ZONE, CLIENT_ZONE_BYTES)?;
        if !client.chars().any(char::is_control) {
            metadata.insert(CLIENT_ZONE.0.to_owned(), client);
        }
        let series = self.input.values(&SERIES_NOTES)?;
        if !series[SERIES_NOTES[0].0].is_empty() {
            metadata.extend(series);
        }
        Ok(metadata)
    }
}

/// Returns whether an object starts here.
pub(super) fn is_object(bytes: &[u8]) -> bool {
    bytes.starts_with(SIGNATURE) || bytes.starts_with(SIGNATURE_COMPRESSED)
}
