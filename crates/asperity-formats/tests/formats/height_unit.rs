//! The unit of heights that a user states.

use asperity_formats::{Format, FormatError, ReadOptions, Scan, write_npy, write_sur};
use ndarray::array;

use crate::assert_heights;
use crate::check::{assert_one_warning, assert_warns, warns};
use crate::fixture::{read_bytes, read_bytes_with};

fn read(bytes: &[u8], unit: &str) -> Scan {
    let options = ReadOptions { height_unit: Some(unit.parse().unwrap()), ..ReadOptions::default() };
    read_bytes_with(bytes, &options).unwrap()
}

const XYZ: &str = "0 0 1\n9 0 2\n18 0 3\n0 9 4\n9 9 5\n18 9 6\n";

#[test]
fn heights_without_a_unit_are_in_the_stated_one() {
    let matrix = array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
    let npy = write_npy(&Scan::new(matrix, None));
    for (bytes, format) in
        [(b"1 2 3\n4 5 6\n".as_slice(), Format::Text), (XYZ.as_bytes(), Format::Xyz), (&npy, Format::Npy)]
    {
        for (unit, z) in [("um", 1e-6), ("nm", 1e-9), ("m", 1.0)] {
            let scan = read(bytes, unit);
            assert_eq!(scan.format, Some(format));
            assert_heights(&scan, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|number| number * z));
            assert_eq!(scan.height_unit.as_deref(), Some(unit));
            assert!(!warns(&scan, "height unit"), "{:?}", scan.warnings);
        }
    }
    assert_eq!(read_bytes(&npy).unwrap().height_unit, None);
    // The positions of points keep their unit.
    assert_eq!(read(XYZ.as_bytes(), "um").pitch_m, read_bytes(XYZ.as_bytes()).unwrap().pitch_m);
}

#[test]
fn a_stated_unit_replaces_that_of_the_file_with_a_warning() {
    let sur = write_sur(&Scan::new(array![[1e-6, 2e-6], [3e-6, 4e-6]], Some((1e-6, 1e-6)))).unwrap();
    let of_sur = read_bytes(&sur).unwrap();
    let own = of_sur.height_unit.clone().unwrap();
    for (bytes, own, other) in [(b"# unit: um\n1 2\n3 4\n".as_slice(), "um", "nm"), (&sur, own.as_str(), "mm")] {
        let (file, same, replaced) = (read_bytes(bytes).unwrap(), read(bytes, own), read(bytes, other));
        assert_eq!(crate::bits(&same), crate::bits(&file), "the same unit changes nothing");
        assert!(!warns(&same, "replaces"), "{:?}", same.warnings);
        let metre = |unit: &str| match unit {
            "mm" => 1e-3,
            "um" | "µm" => 1e-6,
            "nm" => 1e-9,
            _ => 1.0,
        };
        let wanted: Vec<f64> = file.heights_m.iter().map(|z| z / metre(own) * metre(other)).collect();
        for (z, wanted) in replaced.heights_m.iter().zip(wanted) {
            assert!((z / wanted - 1.0).abs() < 1e-12, "{z:e}, wanted {wanted:e}");
        }
        assert_warns(&replaced, &format!("the stated height unit, {other}, replaces the file's {own}"));
    }
    // Values that are not lengths have no scale.
    let scan = read(b"# Value units: V\n1 2\n3 4\n", "um");
    assert_heights(&scan, &[1e-6, 2e-6, 3e-6, 4e-6]);
    assert_eq!(scan.warnings, ["the stated height unit, um, replaces the file's V"]);
}

#[test]
fn a_stated_unit_replaces_the_conversion_factor_of_the_file() {
    let koala = b"data unit=rad\nheight conversion factor (-> m)=6.3e-8\n1 2\n3 4\n";
    let scan = read(koala, "nm");
    assert_heights(&scan, &[1e-9, 2e-9, 3e-9, 4e-9]);
    assert_eq!(
        scan.warnings,
        [
            "the stated height unit replaces the header's `height conversion factor (-> m): 6.3e-8`",
            "the stated height unit, nm, replaces the file's rad"
        ]
    );
    // A factor beside the unit that is stated, and one that is none.
    let scan = read(b"# height unit: nm\n# height conversion factor (-> m) = 2e-9\n1 2\n3 4\n", "nm");
    assert_heights(&scan, &[1e-9, 2e-9, 3e-9, 4e-9]);
    assert_one_warning(&scan, "2e-9");
    assert_heights(&read(b"# conversion factor = none\n1 2\n3 4\n", "um"), &[1e-6, 2e-6, 3e-6, 4e-6]);
}

/// Reads two heights, each in two rows, at points `pitch_m` apart.
fn with_pitch(heights: [f64; 2], unit: Option<&str>, pitch_m: f64) -> Result<Scan, FormatError> {
    let [low, high] = heights;
    let npy = write_npy(&Scan::new(array![[low, high], [low, high]], None));
    let height_unit = unit.map(|unit| unit.parse().unwrap());
    read_bytes_with(&npy, &ReadOptions { height_unit, pitch_m: Some((pitch_m, pitch_m)), ..ReadOptions::default() })
}

#[test]
fn heights_in_a_stated_unit_are_compared_with_the_field_of_view() {
    let warnings = |unit: &str, pitch_m: f64| {
        let scan = with_pitch([0.0, 2.0], Some(unit), pitch_m).unwrap();
        assert_eq!(scan.pitch_m, Some((pitch_m, pitch_m)));
        scan.warnings
    };
    // The field is two pixels wide.
    assert_eq!(warnings("m", 1e-5), ["the heights span 2 m, more than the field of view, 20 µm; check the units"]);
    assert_eq!(warnings("um", 1e-5), [] as [String; 0]);
    assert_eq!(warnings("um", 0.5e-6), ["the heights span 2 µm, more than the field of view, 1 µm; check the units"]);
    // An offset alone is no doubt.
    assert_eq!(with_pitch([4.8, 4.8], Some("m"), 1e-3).unwrap().warnings, [] as [String; 0]);
}

#[test]
fn heights_without_a_unit_that_exceed_the_field_of_view_are_refused() {
    for (heights, pitch_m, found) in [
        ([0.0, 2.0], 1e-5, "span 2 m, more than the field of view, 20 µm"),
        // An offset of 4.8 m, of either sign.
        ([4.8, 4.8 + 1e-6], 250e-6, "reach 4.8 m, more than the field of view, 500 µm"),
        ([-4.8, -4.8 + 1e-6], 250e-6, "reach 4.8 m, more than the field of view, 500 µm"),
        ([-0.6e-3, 0.6e-3], 0.5e-3, "span 1.2 mm, more than the field of view, 1 mm"),
    ] {
        let error = with_pitch(heights, None, pitch_m).unwrap_err();
        assert!(matches!(error, FormatError::NoHeightUnit { format: Format::Npy, .. }), "{error}");
        let wanted = format!(
            "NPY: the file states no unit of height; in metre the heights would {found}; state the unit by `--height-unit`, in \
             a study by `height_unit`, such as `um` (`m` if they are in metre)"
        );
        assert_eq!(error.to_string(), wanted);
        assert!(with_pitch(heights, Some("m"), pitch_m).is_ok());
    }
    // Plausible heights count as metre, up to the longer side of the field.
    let scan = with_pitch([-1e-3, 0.0], None, 0.5e-3).unwrap();
    assert_heights(&scan, &[-1e-3, 0.0, -1e-3, 0.0]);
    assert_eq!(scan.warnings, [] as [String; 0]);
    // A wide field holds heights in millimetre, but their slopes are those of no surface.
    let wide: String = (0..400).map(|i| format!("{}\n", [0.0, 3e-4, 1e-4, 5e-4][i % 4])).collect();
    let read = |unit: &str| read_bytes(format!("# pixel size: 10 um\n{unit}{wide}").as_bytes()).unwrap();
    assert_warns(
        &read(""),
        "half of the neighbouring heights differ by more than 10 pixels; the file states no unit of height",
    );
    assert!(!read("# unit: mm\n").warnings.iter().any(|warning| warning.contains("neighbouring")));
}

#[test]
fn heights_without_a_unit_are_refused_in_every_format_that_may_lack_it() {
    let points = "0 0 1\n1e-6 0 2\n2e-6 0 3\n0 1e-6 4\n1e-6 1e-6 5\n2e-6 1e-6 6\n";
    for (bytes, format) in [("# pixel size: 1 um\n1 2 3\n4 5 7\n", Format::Text), (points, Format::Xyz)] {
        let error = read_bytes(bytes.as_bytes()).unwrap_err();
        assert!(matches!(error, FormatError::NoHeightUnit { format: found, .. } if found == format), "{error}");
        assert_eq!(read(bytes.as_bytes(), "um").heights_m[[0, 0]], 1e-6);
    }
    // Without a pixel size there is no field of view. A unit in the file is no guess.
    assert_heights(&read_bytes(b"1 2 3\n4 5 7\n").unwrap(), &[1.0, 2.0, 3.0, 4.0, 5.0, 7.0]);
    let stated = read_bytes(b"# unit: m\n# pixel size: 1 um\n1 2 3\n4 5 7\n").unwrap();
    assert_warns(&stated, "the heights span 6 m, more than the field of view, 3 µm; check the units");
}

#[test]
fn a_stated_pixel_size_replaces_that_of_the_file_with_a_warning() {
    let read = |text: &[u8], pitch_m| {
        let options = ReadOptions { pitch_m: Some(pitch_m), ..ReadOptions::default() };
        let scan = read_bytes_with(text, &options).unwrap();
        assert_eq!(scan.pitch_m, Some(pitch_m));
        scan.warnings
    };
    let text = b"# unit: nm\n# pixel size: 2 um\n1 2\n3 4\n";
    assert_eq!(read(text, (2e-6, 2e-6)), [] as [String; 0]);
    assert_eq!(read(text, (4e-6, 2e-6)), ["the stated pixel size, 4 µm × 2 µm, replaces the file's, 2 µm × 2 µm"]);
}
