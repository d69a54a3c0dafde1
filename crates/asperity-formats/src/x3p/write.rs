//! Writer of X3P.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use md5::{Digest, Md5};
use quick_xml::escape::escape;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter};

use super::names::{CHECKSUM, MAIN, POINT_DATA, SAMPLES, VALID_POINTS};
use crate::archive::{damage_of_zip, damaged, hexadecimal, may_hold, unpacked_limit};
use crate::sample::stored;
use crate::{Format, FormatError, Result, Sample, Scan};

/// Number type of the heights in a file to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum X3pData {
    /// 32768 steps from the lowest to the highest height, with an error of at most half a step; missing points in
    /// `valid.bin`. The stored numbers are 0 to 32767, so that readers that take the type as unsigned read them
    /// correctly.
    Int16,
    /// `f32`; NaN for missing points.
    Float32,
    /// `f64`; NaN for missing points.
    #[default]
    Float64,
}

impl X3pData {
    /// Returns the letter of the type in `main.xml`.
    fn letter(self) -> &'static str {
        SAMPLES.iter().find(|(_, sample)| *sample == self.sample()).map_or("D", |(letter, _)| letter)
    }

    /// Returns the number type.
    fn sample(self) -> Sample {
        match self {
            Self::Int16 => Sample::I16,
            Self::Float32 => Sample::F32,
            Self::Float64 => Sample::F64,
        }
    }
}

/// Schema of ISO 5436-2, which ISO 25178-72 adopted and readers look for.
const NAMESPACE: &str = "http://www.opengps.eu/2008/ISO5436_2";
/// Highest number in a file of 16-bit integers; the lowest is 0.
const INT16_STEPS: f64 = 32767.0;
/// Date for scans without a date; the schema requires one.
const NO_DATE: &str = "1970-01-01T00:00:00Z";
/// Text for unknown fields.
const UNKNOWN: &str = "not available";

/// Binary files, and the z axis that converts their numbers to metre.
struct Stored {
    points: Vec<u8>,
    valid: Option<Vec<u8>>,
    increment: f64,
    offset_m: f64,
}

/// Writes a scan as an X3P file. Equal scans give equal bytes.
///
/// The description of the measurement is taken from the metadata (`Record2/…`; operator, date and comment of other
/// formats). Unknown texts read "not available".
///
/// # Errors
/// [`FormatError::NoPitch`] without a pixel size, [`FormatError::NotStorable`] for a scan without points or with
/// heights beyond the range of the number type.
pub fn write_x3p(scan: &Scan, data: X3pData) -> Result<Vec<u8>, FormatError> {
    let (_, pitch_m) = scan.to_store(Format::X3p)?;
    let stored = match data {
        X3pData::Int16 => int16(scan)?,
        X3pData::Float32 => float32(scan)?,
        X3pData::Float64 => float64(scan),
    };
    let main = main_xml(scan, pitch_m, data, &stored);
    let checksum = format!("{} *{MAIN}\n", hexadecimal(&Md5::digest(main.as_bytes())));
    let mut files: Vec<(&str, &[u8])> = vec![(MAIN, main.as_bytes()), (POINT_DATA, &stored.points)];
    files.extend(stored.valid.as_deref().map(|valid| (VALID_POINTS, valid)));
    files.push((CHECKSUM, checksum.as_bytes()));
    archive(&files, data)
}

/// Returns a zip archive whose bytes depend only on its files, not on clock or host.
///
/// Files are deflated, unless their packed size would exceed the unpacking limit of the reader, as for ideal
/// gratings.
fn archive(files: &[(&str, &[u8])], data: X3pData) -> Result<Vec<u8>> {
    let deflated = zip(files, |_| CompressionMethod::Deflated).map_err(unwritten)?;
    let mut written = ZipArchive::new(Cursor::new(&deflated)).map_err(unwritten)?;
    let mut refused = Vec::new();
    for (place, &(name, bytes)) in files.iter().enumerate() {
        let packed = written.by_index_raw(place).map_err(unwritten)?.compressed_size();
        let is_read = match name {
            POINT_DATA => may_hold(packed, (bytes.len() / data.sample().size()) as u64, data.sample()),
            // The number of points limits them.
            VALID_POINTS => true,
            _ => bytes.len() as u64 <= unpacked_limit(packed),
        };
        if !is_read {
            refused.push(name);
        }
    }
    if refused.is_empty() {
        return Ok(deflated);
    }
    let method = |name| if refused.contains(&name) { CompressionMethod::Stored } else { CompressionMethod::Deflated };
    zip(files, method).map_err(unwritten)
}

fn unwritten(error: ZipError) -> FormatError {
    damaged(Format::X3p, "archive", damage_of_zip(&error))
}

fn zip<'a>(files: &[(&'a str, &[u8])], method: impl Fn(&'a str) -> CompressionMethod) -> Result<Vec<u8>, ZipError> {
    let options = SimpleFileOptions::default()
        .last_modified_time(DateTime::default())
        .system(System::Unix)
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for &(name, bytes) in files {
        zip.start_file(name, options.compression_method(method(name)).large_file(u32::try_from(bytes.len()).is_err()))?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

fn float64(scan: &Scan) -> Stored {
    Stored { points: scan.heights_m.iter().flat_map(stored).collect(), valid: None, increment: 1.0, offset_m: 0.0 }
}

fn float32(scan: &Scan) -> Result<Stored> {
    let mut points = Vec::with_capacity(4 * scan.heights_m.len());
    for &z in &scan.heights_m {
        let narrow = if z.is_finite() { z as f32 } else { f32::NAN };
        if narrow.is_infinite() {
            let found = format!("a height of {z:e} m");
            return Err(FormatError::not_storable(Format::X3p, found, "heights within the range of f32"));
        }
        points.extend(narrow.to_le_bytes());
    }
    Ok(Stored { points, valid: None, increment: 1.0, offset_m: 0.0 })
}

/// Stores heights in [`INT16_STEPS`] equal steps from the lowest to the highest.
fn int16(scan: &Scan) -> Result<Stored> {
    let (low, high) = scan.height_range_m().unwrap_or((0.0, 0.0));
    let step = (high - low) / INT16_STEPS;
    if !step.is_finite() {
        let found = format!("heights from {low:e} to {high:e} m");
        return Err(FormatError::not_storable(Format::X3p, found, "a range that fits f64"));
    }
    // A flat map may have any step.
    let increment = if step > 0.0 { step } else { 1.0 };
    let mut points = Vec::with_capacity(2 * scan.heights_m.len());
    let mut valid = vec![0_u8; scan.heights_m.len().div_ceil(8)];
    for (point, &z) in scan.heights_m.iter().enumerate() {
        let mut number = 0;
        if z.is_finite() {
            // A conversion of floats saturates, so rounding cannot leave the range.
            number = ((z - low) / increment).round() as i16;
            valid[point / 8] |= 1 << (point % 8);
        }
        points.extend(number.to_le_bytes());
    }
    let complete = scan.missing_points() == 0;
    Ok(Stored { points, valid: (!complete).then_some(valid), increment, offset_m: low })
}

/// Elements of `Record2` and their names in the metadata of other formats.
const OTHER_NAMES: [(&str, &str); 3] = [("Date", "date"), ("Creator", "operator name"), ("Comment", "comment")];

/// Returns a metadata field as XML content.
fn known(metadata: &BTreeMap<String, String>, field: &str) -> Option<String> {
    let other_name = OTHER_NAMES.iter().find(|(element, _)| *element == field).map(|(_, name)| *name);
    let other = || metadata.get(other_name?).filter(|text| field != "Date" || is_date_time(text));
    let value = metadata.get(&format!("Record2/{field}")).or_else(other)?;
    // XML 1.0 does not allow other control characters, even escaped.
    let text: String = value.chars().filter(|c| !c.is_control() || matches!(c, '\n' | '\t')).collect();
    Some(escape(text.as_str()).into_owned())
}

/// Returns whether a text has the form `yyyy-mm-ddThh:mm:ss`, which the schema requires for dates.
fn is_date_time(text: &str) -> bool {
    let form = b"0000-00-00T00:00:00";
    let fits = |(found, form): (u8, &u8)| if *form == b'0' { found.is_ascii_digit() } else { found == *form };
    text.len() == form.len() && text.bytes().zip(form).all(fits)
}

/// Returns the description, in the order that the schema requires.
fn main_xml(scan: &Scan, (dx_m, dy_m): (f64, f64), data: X3pData, stored: &Stored) -> String {
    let (ny, nx) = scan.heights_m.dim();
    let field = |name: &str| known(&scan.metadata, name);
    let text = |name: &str| field(name).unwrap_or_else(|| UNKNOWN.into());
    let date = |name: &str| field(name).unwrap_or_else(|| NO_DATE.into());
    let kind = field("ProbingSystem/Type")
        .filter(|kind| matches!(kind.as_str(), "Contacting" | "NonContacting" | "Software"))
        .unwrap_or_else(|| "Software".into());
    let optional = |name: &str| field(name).map(|text| format!("    <{name}>{text}</{name}>\n")).unwrap_or_default();

    let mut axes = String::new();
    let z = (stored.increment, stored.offset_m);
    for (axis, kind, letter, (increment, offset)) in
        [("CX", "I", "D", (dx_m, 0.0)), ("CY", "I", "D", (dy_m, 0.0)), ("CZ", "A", data.letter(), z)]
    {
        // Writing to a String cannot fail.
        let _ = write!(
            axes,
            "      <{axis}>\n        <AxisType>{kind}</AxisType>\n        <DataType>{letter}</DataType>\n        \
             <Increment>{increment:e}</Increment>\n        <Offset>{offset:e}</Offset>\n      </{axis}>\n"
        );
    }
    let md5 = |bytes: &[u8]| hexadecimal(&Md5::digest(bytes)).to_uppercase();
    let mut links = format!(
        "      <PointDataLink>{POINT_DATA}</PointDataLink>\n      \
         <MD5ChecksumPointData>{}</MD5ChecksumPointData>\n",
        md5(&stored.points)
    );
    if let Some(valid) = &stored.valid {
        let _ = write!(
            links,
            "      <ValidPointsLink>{VALID_POINTS}</ValidPointsLink>\n      \
             <MD5ChecksumValidPoints>{}</MD5ChecksumValidPoints>\n",
            md5(valid)
        );
    }
    format!(
        r#"<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<p:ISO5436_2 xmlns:p="{NAMESPACE}" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="{NAMESPACE} {NAMESPACE}/ISO5436_2.xsd">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>SUR</FeatureType>
    <Axes>
{axes}    </Axes>
  </Record1>
  <Record2>
    <Date>{date}</Date>
{creator}    <Instrument>
      <Manufacturer>{manufacturer}</Manufacturer>
      <Model>{model}</Model>
      <Serial>{serial}</Serial>
      <Version>{version}</Version>
    </Instrument>
    <CalibrationDate>{calibration}</CalibrationDate>
    <ProbingSystem>
      <Type>{kind}</Type>
      <Identification>{identification}</Identification>
    </ProbingSystem>
{comment}  </Record2>
  <Record3>
    <MatrixDimension>
      <SizeX>{nx}</SizeX>
      <SizeY>{ny}</SizeY>
      <SizeZ>1</SizeZ>
    </MatrixDimension>
    <DataLink>
{links}    </DataLink>
  </Record3>
  <Record4>
    <ChecksumFile>{CHECKSUM}</ChecksumFile>
  </Record4>
</p:ISO5436_2>
"#,
        date = date("Date"),
        creator = optional("Creator"),
        manufacturer = text("Instrument/Manufacturer"),
        model = text("Instrument/Model"),
        serial = text("Instrument/Serial"),
        version = text("Instrument/Version"),
        calibration = date("CalibrationDate"),
        identification = text("ProbingSystem/Identification"),
        comment = optional("Comment"),
    )
}
