//! VTK image data.

use asperity_formats::{Format, FormatError, Scan, write_vtk, write_vtk_fields};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use ndarray::{Array2, array};

use crate::NAN;
use crate::fixture::{Fixture, read_bytes};

pub(crate) fn fixtures() -> Vec<Fixture> {
    // Written and not read.
    vec![]
}

fn scan() -> Scan {
    let mut scan = Scan::new(array![[1e-6, NAN, 3e-6], [-4e-6, 5e-6, 0.1 + 0.2]], Some((1.5e-6, 2.5e-6)));
    scan.metadata.insert("A <\"&\u{1}>".into(), "1\0µ\n".into());
    scan
}

fn text(scan: &Scan) -> String {
    String::from_utf8(write_vtk(scan).unwrap()).unwrap()
}

/// Returns the bytes of an array after the eight bytes of their size.
fn array_bytes(text: &str, kind: &str, name: &str) -> Option<Vec<u8>> {
    let start = format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"binary\">");
    let content = text.split_once(&start)?.1.split_once("</DataArray>").unwrap().0;
    let bytes = STANDARD.decode(content).unwrap();
    let (size, data) = bytes.split_first_chunk().unwrap();
    assert_eq!(u64::from_le_bytes(*size), data.len() as u64);
    Some(data.to_vec())
}

#[test]
fn the_last_row_is_written_first_and_missing_points_are_marked() {
    let text = text(&scan());
    let heights = array_bytes(&text, "Float64", "height_m").unwrap();
    let heights: Vec<u64> = heights.as_chunks::<8>().0.iter().map(|raw| u64::from_le_bytes(*raw)).collect();
    assert_eq!(heights, [-4e-6, 5e-6, 0.1 + 0.2, 1e-6, NAN, 3e-6].map(f64::to_bits));
    assert_eq!(array_bytes(&text, "UInt8", "missing").unwrap(), [0, 0, 0, 0, 1, 0]);
    // Bit 2 of vtkGhostType hides a point (vtkDataSetAttributes::HIDDENPOINT).
    assert_eq!(array_bytes(&text, "UInt8", "vtkGhostType").unwrap(), [0, 0, 0, 0, 2, 0]);
}

#[test]
fn fields_are_point_data_by_name() {
    let (pressure, gap) = (array![[1e6, 2e6, 0.0], [0.0, 3e6, 4e6]], array![[0.0, 1e-9, NAN], [2e-9, 0.0, 3e-9]]);
    let bytes = write_vtk_fields((1.5e-6, 2.5e-6), &[("pressure_pa", &pressure), ("gap_m", &gap)]).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert!(
        text.contains(r#"<PointData Scalars="pressure_pa">"#) && text.contains(r#"Spacing="1.5e-6 2.5e-6 1.5e-6""#)
    );
    for (name, values) in
        [("pressure_pa", [0.0, 3e6, 4e6, 1e6, 2e6, 0.0]), ("gap_m", [2e-9, 0.0, 3e-9, 0.0, 1e-9, NAN])]
    {
        let found = array_bytes(&text, "Float64", name).unwrap();
        let found: Vec<u64> = found.as_chunks::<8>().0.iter().map(|raw| u64::from_le_bytes(*raw)).collect();
        assert_eq!(found, values.map(f64::to_bits), "{name}");
    }
    for (pitch_m, fields) in [
        ((1e-6, 1e-6), vec![]),
        ((1e-6, 0.0), vec![("gap_m", &gap)]),
        ((1e-6, 1e-6), vec![("gap_m", &gap), ("other_m", &array![[1.0]])]),
    ] {
        let error = write_vtk_fields(pitch_m, &fields).unwrap_err();
        assert!(matches!(error, FormatError::NotStorable { .. }), "{error}");
    }
}

#[test]
fn extent_and_spacing_follow_the_points() {
    let text = text(&scan());
    for wanted in [
        r#"<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">"#,
        r#"<ImageData WholeExtent="0 2 0 1 0 0" Origin="0 0 0" Spacing="1.5e-6 2.5e-6 1.5e-6">"#,
        r#"<Piece Extent="0 2 0 1 0 0">"#,
    ] {
        assert!(text.contains(wanted), "{text}");
    }
}

#[test]
fn metadata_are_texts_as_codes_of_bytes() {
    let wanted = r#"<Array type="String" Name="A &lt;&quot;&amp;&gt;" NumberOfTuples="1" format="ascii">49 194 181 10 0</Array>"#;
    assert!(text(&scan()).contains(wanted));
}

#[test]
fn a_complete_map_has_no_masks() {
    let text = text(&Scan::new(array![[1.0, 2.0]], Some((1.0, 1.0))));
    assert!(!text.contains("missing") && !text.contains("vtkGhostType"));
}

#[test]
fn an_image_needs_a_pitch_and_a_point() {
    let no_pitch = Scan::new(array![[0.0]], None);
    assert!(matches!(write_vtk(&no_pitch), Err(FormatError::NoPitch { format: Format::Vtk })));
    for (heights_m, pitch_m) in
        [(Array2::zeros((0, 3)), (1e-6, 1e-6)), (array![[0.0]], (0.0, 1e-6)), (array![[0.0]], (1.0, NAN))]
    {
        let error = write_vtk(&Scan::new(heights_m, Some(pitch_m))).unwrap_err();
        assert!(matches!(error, FormatError::NotStorable { .. }), "{error}");
    }
}

#[test]
fn images_are_written_under_their_extension_and_not_read() {
    assert_eq!(Format::from_extension("VTI"), Some(Format::Vtk));
    assert!(read_bytes(&write_vtk(&scan()).unwrap()).is_err());
}
