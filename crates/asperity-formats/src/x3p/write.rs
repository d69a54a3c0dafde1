//! Writer of X3P.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Cursor;

use md5::{Digest, Md5};
use quick_xml::escape::escape;
use zip::result::ZipError;
use zip::{CompressionMethod, ZipArchive};

use super::names::{CHECKSUM, MAIN, POINT_DATA};
use crate::archive::{damage_of_zip, damaged, hexadecimal, may_hold, unpacked_limit, written};
use crate::sample::stored;
use crate::{Format, FormatError, Result, Sample, Scan};

/// Schema of ISO 5436-2, which ISO 25178-72 adopted and readers look for.
const NAMESPACE: &str = "http://www.opengps.eu/2008/ISO5436_2";
/// Date for scans without a date; the schema requires one.
const NO_DATE: &str = "1970-01-01T00:00:00Z";
/// Text for unknown fields.
const UNKNOWN: &str = "not available";

/// Writes a scan as an X3P file. Equal scans give equal bytes.
///
/// The description of the measurement is taken from the metadata (`Record2/…`; operator, date and comment of other
/// formats). Unknown texts read "not available".
///
/// # Errors
/// [`FormatError::NoPitch`] without a pixel size, [`FormatError::NotStorable`] for a scan without points or with an
/// invalid pixel size.
pub fn write_x3p(scan: &Scan) -> Result<Vec<u8>, FormatError> {
    let (_, pitch_m) = scan.to_store(Format::X3p)?;
    let points: Vec<u8> = scan.heights_m.iter().flat_map(stored).collect();
    let main = main_xml(scan, pitch_m, &points);
    let checksum = format!("{} *{MAIN}\n", hexadecimal(&Md5::digest(main.as_bytes())));
    archive([(MAIN, main.as_bytes()), (POINT_DATA, &points), (CHECKSUM, checksum.as_bytes())])
        .map_err(|error| damaged(Format::X3p, "archive", damage_of_zip(&error)))
}

/// Returns a zip archive of the files.
///
/// They are deflated, unless their packed size would exceed the unpacking limit of the reader, as for ideal gratings.
fn archive(files: [(&str, &[u8]); 3]) -> Result<Vec<u8>, ZipError> {
    let deflated = written(&files, CompressionMethod::Deflated, None)?;
    let packed = ZipArchive::new(Cursor::new(&deflated))?.by_index_raw(1)?.compressed_size();
    let count = (files[1].1.len() / Sample::F64.size()) as u64;
    let is_read = may_hold(packed, count, Sample::F64) && files[0].1.len() as u64 <= unpacked_limit(0);
    if is_read { Ok(deflated) } else { written(&files, CompressionMethod::Stored, None) }
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
fn main_xml(scan: &Scan, (dx_m, dy_m): (f64, f64), points: &[u8]) -> String {
    let (ny, nx) = scan.heights_m.dim();
    let field = |name: &str| known(&scan.metadata, name);
    let text = |name: &str| field(name).unwrap_or_else(|| UNKNOWN.into());
    let date = |name: &str| field(name).unwrap_or_else(|| NO_DATE.into());
    let kind = field("ProbingSystem/Type")
        .filter(|kind| matches!(kind.as_str(), "Contacting" | "NonContacting" | "Software"))
        .unwrap_or_else(|| "Software".into());
    let optional = |name: &str| field(name).map(|text| format!("    <{name}>{text}</{name}>\n")).unwrap_or_default();

    let mut axes = String::new();
    for (axis, kind, increment) in [("CX", "I", dx_m), ("CY", "I", dy_m), ("CZ", "A", 1.0)] {
        // Writing to a String cannot fail.
        let _ = write!(
            axes,
            "      <{axis}>\n        <AxisType>{kind}</AxisType>\n        <DataType>D</DataType>\n        \
             <Increment>{increment:e}</Increment>\n        <Offset>0e0</Offset>\n      </{axis}>\n"
        );
    }
    let md5 = hexadecimal(&Md5::digest(points)).to_uppercase();
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
      <PointDataLink>{POINT_DATA}</PointDataLink>
      <MD5ChecksumPointData>{md5}</MD5ChecksumPointData>
    </DataLink>
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
