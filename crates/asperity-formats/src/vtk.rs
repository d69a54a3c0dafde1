//! VTK image data (`.vti`), for ParaView and other programs that show fields.
//!
//! Heights and other fields are point data on a grid with the pitch as spacing, little-endian numbers in base64 inside the
//! XML. In VTK y points up, but the rows of a map run down: the last row of the map is y = 0. Layout:
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use std::fmt::Write as _;
use std::io::Write as _;

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderStringWriter;
use ndarray::Array2;
use quick_xml::escape::escape;

use crate::sample::stored;
use crate::scan::check;
use crate::{Description, Format, FormatError, Result, Scan, Shape, Tested};

pub(crate) const CODEC: Description = Description {
    extensions: &["vti"],
    vendor: "Kitware",
    writes: "float64 `height_m` with a mask `missing`, or fields by name",
    missing_points: "NaN, hidden points in vtkGhostType",
    orientation: "y points up: the last row of a scan is written first",
    write: Some(write_vtk),
    tested: Tested::OtherPrograms,
    ..Description::new(
        Format::Vtk,
        |_| false,
        |_, _| Err(FormatError::unsupported(Format::Vtk, "a VTK image", "a format that is read")),
    )
};

/// Bit of vtkGhostType that hides a point.
const HIDDEN_POINT: u8 = 2;

/// Writes a scan as a VTK image for ParaView. Equal scans give equal bytes.
///
/// The point data are `height_m`, NaN for missing points. If points are missing, the masks `missing` (1) and
/// `vtkGhostType`, which hides them in VTK, are added. The metadata are texts in the field data.
///
/// # Errors
/// [`FormatError::NoPitch`] without a pixel size, [`FormatError::NotStorable`] for a scan without points or with an
/// invalid pixel size.
pub fn write_vtk(scan: &Scan) -> Result<Vec<u8>, FormatError> {
    let (shape, pitch_m) = scan.to_store(Format::Vtk)?;
    let heights = &scan.heights_m;
    let mut data = field("height_m", heights)?;
    if scan.missing_points() > 0 {
        let mask = |value: u8| upwards(heights).map(move |z| [if z.is_finite() { 0 } else { value }]);
        data += &array("UInt8", "missing", heights.len(), mask(1))?;
        data += &array("UInt8", "vtkGhostType", heights.len(), mask(HIDDEN_POINT))?;
    }
    Ok(image(shape, pitch_m, &texts(scan), "height_m", &data))
}

/// Writes fields on one grid as a VTK image for ParaView: point data by name, NaN for missing points. ParaView shows the first
/// field. Equal fields give equal bytes.
///
/// `pitch_m` is the distance of columns and rows in metre; fields have the shape `[ny, nx]`, row 0 at the top.
///
/// # Errors
/// [`FormatError::NotStorable`] for fields without points, of different shapes, or with an invalid pitch.
pub fn write_vtk_fields(pitch_m: (f64, f64), fields: &[(&str, &Array2<f64>)]) -> Result<Vec<u8>, FormatError> {
    let [(first, values), ..] = fields else {
        return Err(FormatError::not_storable(Format::Vtk, "no field", "at least one field"));
    };
    let shape = values.dim();
    check(Format::Vtk, shape, pitch_m)?;
    let mut data = String::new();
    for (name, values) in fields {
        if values.dim() != shape {
            return Err(FormatError::not_storable(Format::Vtk, "fields of different shapes", "fields on one grid"));
        }
        data += &field(name, values)?;
    }
    Ok(image(shape, pitch_m, "", first, &data))
}

/// Returns the file of an image with texts and point data; `scalars` names the data that are shown first.
fn image((ny, nx): Shape, (dx_m, dy_m): (f64, f64), texts: &str, scalars: &str, data: &str) -> Vec<u8> {
    let extent = format!("0 {} 0 {} 0 0", nx - 1, ny - 1);
    // A single layer has no thickness, but VTK requires a spacing.
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="{dx_m:e} {dy_m:e} {dx_m:e}">
    <FieldData>
{texts}    </FieldData>
    <Piece Extent="{extent}">
      <PointData Scalars="{scalars}">
{data}      </PointData>
    </Piece>
  </ImageData>
</VTKFile>
"#
    )
    .into_bytes()
}

/// Returns the values in the order of VTK: the last row first.
fn upwards(values: &Array2<f64>) -> impl Iterator<Item = &f64> {
    values.rows().into_iter().rev().flatten()
}

/// Returns an array of the values of a field.
fn field(name: &str, values: &Array2<f64>) -> Result<String> {
    array("Float64", name, values.len(), upwards(values).map(stored))
}

/// Returns an array of `count` numbers of `N` bytes each, after its size in bytes.
fn array<const N: usize>(
    kind: &str,
    name: &str,
    count: usize,
    numbers: impl Iterator<Item = [u8; N]>,
) -> Result<String> {
    let mut encoder = EncoderStringWriter::new(&STANDARD);
    let written = encoder
        .write_all(&((count * N) as u64).to_le_bytes())
        .and_then(|()| numbers.into_iter().try_for_each(|number| encoder.write_all(&number)));
    written.map_err(|_| FormatError::not_storable(Format::Vtk, "an array", "numbers as base64"))?;
    Ok(format!(
        "        <DataArray type=\"{kind}\" Name=\"{name}\" format=\"binary\">{}</DataArray>\n",
        encoder.into_inner()
    ))
}

/// Returns the metadata, each text as the codes of its bytes with a zero after them.
fn texts(scan: &Scan) -> String {
    let mut fields = String::new();
    for (name, text) in &scan.metadata {
        // XML 1.0 does not allow other control characters, even escaped.
        let name: String = name.chars().filter(|c| !c.is_control()).collect();
        let _ = write!(
            fields,
            "      <Array type=\"String\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">",
            escape(name.as_str())
        );
        for byte in text.bytes().filter(|&byte| byte != 0) {
            // Writing to a String cannot fail.
            let _ = write!(fields, "{byte} ");
        }
        fields.push_str("0</Array>\n");
    }
    fields
}
