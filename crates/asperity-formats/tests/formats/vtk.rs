//! VTK image data.

use asperity_formats::{Format, Scan, write_vtk, write_vtk_fields};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use ndarray::array;

use crate::NAN;
use crate::check::assert_error;
use crate::fixture::{Fixture, read_bytes};

pub(crate) fn fixtures() -> Vec<Fixture> {
    // Written and not read.
    vec![]
}

fn text(scan: &Scan) -> String {
    String::from_utf8(write_vtk(scan).unwrap()).unwrap()
}

/// Returns the bytes of an array after the eight bytes of their size.
fn array_bytes(text: &str, kind: &str, name: &str) -> Vec<u8> {
    let start = format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"binary\">");
    let content = text.split_once(&start).unwrap().1.split_once("</DataArray>").unwrap().0;
    let bytes = STANDARD.decode(content).unwrap();
    let (size, data) = bytes.split_first_chunk().unwrap();
    assert_eq!(u64::from_le_bytes(*size), data.len() as u64);
    data.to_vec()
}

#[test]
fn the_last_row_is_written_first_and_missing_points_are_marked() {
    let mut scan = Scan::new(array![[1e-6, NAN, 3e-6], [-4e-6, 5e-6, 0.1 + 0.2]], Some((1.5e-6, 2.5e-6)));
    scan.metadata.insert("A <\"&\u{1}>".into(), "1\0µ\n".into());
    let image = text(&scan);
    let wanted = [-4e-6, 5e-6, 0.1 + 0.2, 1e-6, NAN, 3e-6].map(f64::to_le_bytes).concat();
    assert_eq!(array_bytes(&image, "Float64", "height_m"), wanted);
    assert_eq!(array_bytes(&image, "UInt8", "missing"), [0, 0, 0, 0, 1, 0]);
    // Bit 2 of vtkGhostType hides a point (vtkDataSetAttributes::HIDDENPOINT).
    assert_eq!(array_bytes(&image, "UInt8", "vtkGhostType"), [0, 0, 0, 0, 2, 0]);
    // Metadata are texts as codes of bytes.
    for wanted in [
        r#"<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">"#,
        r#"<ImageData WholeExtent="0 2 0 1 0 0" Origin="0 0 0" Spacing="1.5e-6 2.5e-6 1.5e-6">"#,
        r#"<Piece Extent="0 2 0 1 0 0">"#,
        r#"<Array type="String" Name="A &lt;&quot;&amp;&gt;" NumberOfTuples="1" format="ascii">49 194 181 10 0</Array>"#,
    ] {
        assert!(image.contains(wanted), "{image}");
    }
    let complete = text(&Scan::new(array![[1.0, 2.0]], Some((1.0, 1.0))));
    assert!(!complete.contains("missing") && !complete.contains("vtkGhostType"));
    assert_eq!(Format::from_extension("VTI"), Some(Format::Vtk));
    assert!(read_bytes(image.as_bytes()).is_err());
}

#[test]
fn fields_are_point_data_by_name() {
    let (pressure, gap) = (array![[1e6, 2e6, 0.0], [0.0, 3e6, 4e6]], array![[0.0, 1e-9, NAN], [2e-9, 0.0, 3e-9]]);
    let bytes = write_vtk_fields((1.5e-6, 2.5e-6), &[("pressure_pa", &pressure), ("gap_m", &gap)]).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.contains(r#"<PointData Scalars="pressure_pa">"#));
    assert!(text.contains(r#"Spacing="1.5e-6 2.5e-6 1.5e-6""#));
    for (name, values) in
        [("pressure_pa", [0.0, 3e6, 4e6, 1e6, 2e6, 0.0]), ("gap_m", [2e-9, 0.0, 3e-9, 0.0, 1e-9, NAN])]
    {
        assert_eq!(array_bytes(&text, "Float64", name), values.map(f64::to_le_bytes).concat(), "{name}");
    }
    let other = array![[1.0]];
    for (pitch_m, fields) in [
        ((1e-6, 1e-6), vec![]),
        ((1e-6, 0.0), vec![("gap_m", &gap)]),
        ((1e-6, 1e-6), vec![("gap_m", &gap), ("other_m", &other)]),
    ] {
        assert_error(write_vtk_fields(pitch_m, &fields), "cannot be stored");
    }
}
