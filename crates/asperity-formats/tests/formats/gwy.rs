//! GWY, by the layout in Gwyddion's user guide.

use asperity_formats::{Channel, Format, FormatError, ReadOptions, Scan, write_gwy};
use ndarray::array;

use crate::fixture::{Fixture, read_bytes, read_bytes_with, read_channel, refusal};
use crate::{NAN, assert_heights, bits};

/// A component: name, zero, letter of the type, value.
fn component(name: &str, kind: u8, value: impl AsRef<[u8]>) -> Vec<u8> {
    let mut bytes = name.as_bytes().to_vec();
    bytes.extend([0, kind]);
    bytes.extend(value.as_ref());
    bytes
}

fn string(name: &str, value: &str) -> Vec<u8> {
    component(name, b's', [value.as_bytes(), &[0]].concat())
}

fn integer(name: &str, value: i32) -> Vec<u8> {
    component(name, b'i', value.to_le_bytes())
}

fn double(name: &str, value: f64) -> Vec<u8> {
    component(name, b'd', value.to_le_bytes())
}

fn doubles(name: &str, values: &[f64]) -> Vec<u8> {
    let mut value = (values.len() as u32).to_le_bytes().to_vec();
    value.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    component(name, b'D', value)
}

/// An object: name of the type, zero, size of the components, components.
fn object(kind: &str, components: &[Vec<u8>]) -> Vec<u8> {
    let content = components.concat();
    let mut bytes = kind.as_bytes().to_vec();
    bytes.push(0);
    bytes.extend((content.len() as u32).to_le_bytes());
    bytes.extend(content);
    bytes
}

fn unit(name: &str, unit: &str) -> Vec<u8> {
    component(name, b'o', object("GwySIUnit", &[string("unitstr", unit)]))
}

/// An image of 3 × 2 points over 6 × 8 lateral units.
fn field(units: (&str, &str), values: &[f64]) -> Vec<u8> {
    object(
        "GwyDataField",
        &[
            integer("xres", 3),
            integer("yres", 2),
            double("xreal", 6e-6),
            double("yreal", 8e-6),
            double("xoff", 1e-6),
            double("yoff", 0.0),
            unit("si_unit_xy", units.0),
            unit("si_unit_z", units.1),
            doubles("data", values),
        ],
    )
}

const HEIGHTS: [f64; 6] = [1e-9, 2e-9, 3e-9, 4e-9, 5e-9, 6e-9];

fn image(number: u32, title: &str, units: (&str, &str)) -> Vec<u8> {
    let values = HEIGHTS.map(|z| z + f64::from(number) * 1e-6);
    [
        string(&format!("/{number}/data/title"), title),
        component(&format!("/{number}/data"), b'o', field(units, &values)),
    ]
    .concat()
}

fn mask(values: &[f64]) -> Vec<u8> {
    component("/0/mask", b'o', field(("m", ""), values))
}

fn file(components: &[Vec<u8>]) -> Vec<u8> {
    [b"GWYP".to_vec(), object("GwyContainer", components)].concat()
}

/// A file with everything that the reader looks at and all types of components.
fn full() -> Vec<u8> {
    let selection = object("GwySelectionPoint", &[integer("max", 1), doubles("data", &[1.0, 2.0])]);
    file(&[
        string("/filename", "C:\\ground.gwy"),
        component("/0/data/visible", b'b', [1]),
        component("/0/select/pointer", b'o', selection.clone()),
        component("/0/letter", b'c', *b"x"),
        component("/0/long", b'q', 7_i64.to_le_bytes()),
        component("/0/letters", b'C', [&2_u32.to_le_bytes()[..], b"ab"].concat()),
        component("/0/integers", b'I', [&1_u32.to_le_bytes()[..], &[0; 4]].concat()),
        component("/0/longs", b'Q', [&1_u32.to_le_bytes()[..], &[0; 8]].concat()),
        component("/0/texts", b'S', [&2_u32.to_le_bytes()[..], b"a\0b\0"].concat()),
        component("/0/objects", b'O', [&2_u32.to_le_bytes()[..], &selection, &selection].concat()),
        image(0, "Height", ("m", "m")),
        mask(&[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
        component(
            "/0/meta",
            b'o',
            object("GwyContainer", &[string("Instrument", "µScan"), string("Comment", "a\nb"), integer("Averages", 4)]),
        ),
        image(2, "Phase", ("m", "deg")),
        image(7, "Height", ("m", "m")),
    ])
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::whole("GWY with mask and metadata", full()),
        Fixture::whole("GWY without units", file(&[image(0, "", ("", ""))])),
        Fixture::whole("GWY as written", write_gwy(&scan()).unwrap()),
    ]
}

fn read(units: (&str, &str)) -> Scan {
    read_bytes(&file(&[image(0, "Height", units)])).unwrap()
}

#[test]
fn heights_pitch_and_rows_are_as_stored() {
    assert_eq!(Format::detect(&full()), Some(Format::Gwy));
    let scan = read(("m", "m"));
    assert_heights(&scan, &HEIGHTS);
    // Row 0 is the first stored one.
    assert_eq!(scan.heights_m[[1, 0]], 4e-9);
    // The stated sizes are those of whole points: 6 µm / 3 and 8 µm / 2.
    assert_eq!(scan.pitch_m, Some((2e-6, 4e-6)));
    assert_eq!(scan.metadata["title"], "Height");
    assert_eq!(scan.metadata["xoff"], "1e-6 m");
    assert!(!scan.metadata.contains_key("yoff"));
    assert_eq!(scan.warnings, [] as [String; 0]);
}

#[test]
fn units_with_prefixes_are_applied_with_a_warning() {
    for (written, per_metre) in [("nm", 1e9), ("µm", 1e6), ("um", 1e6), ("mm", 1e3), ("Å", 1e10)] {
        let scan = read(("m", written));
        assert_heights(&scan, &HEIGHTS.map(|z| z / per_metre));
        assert_eq!(scan.pitch_m, Some((2e-6, 4e-6)));
        assert!(matches!(scan.warnings.as_slice(), [one] if one.contains("prefixes")), "{:?}", scan.warnings);
        let scan = read((written, "m"));
        assert_heights(&scan, &HEIGHTS);
        assert_eq!(scan.pitch_m, Some((6e-6 / 3.0 / per_metre, 8e-6 / 2.0 / per_metre)));
    }
}

#[test]
fn a_file_without_any_unit_counts_as_metre_with_a_warning() {
    let scan = read(("", ""));
    assert_heights(&scan, &HEIGHTS);
    assert_eq!(scan.pitch_m, Some((2e-6, 4e-6)));
    assert!(matches!(scan.warnings.as_slice(), [one] if one.contains("states no units")), "{:?}", scan.warnings);
}

#[test]
fn lateral_units_other_than_lengths_give_no_pitch() {
    for unit in ["", "px", "s", "A"] {
        let scan = read((unit, "m"));
        assert_eq!(scan.pitch_m, None);
        assert!(scan.warnings[0].contains("no pixel size"), "{:?}", scan.warnings);
    }
}

#[test]
fn values_other_than_lengths_are_refused() {
    // A is the ampere and not the ångström; no unit beside metres is a plain number.
    for unit in ["A", "deg", "V", ""] {
        let found = refusal(&file(&[image(0, "Current", ("m", unit))]));
        assert!(found.contains("no image of the file holds lengths: `Current`"), "{found}");
    }
    assert!(refusal(&file(&[])).contains("no image"));
}

#[test]
fn masked_points_are_missing_with_a_warning() {
    let bytes = file(&[image(0, "Height", ("m", "m")), mask(&[0.0, 1.0, 0.4, 0.6, 0.0, -1.0])]);
    let scan = read_bytes(&bytes).unwrap();
    assert_heights(&scan, &[1e-9, NAN, 3e-9, NAN, 5e-9, 6e-9]);
    assert_eq!(scan.warnings, ["2 points under the mask were read as missing"]);
}

#[test]
fn a_mask_of_another_size_is_left_out_with_a_warning() {
    let small = object("GwyDataField", &[integer("xres", 1), integer("yres", 1), doubles("data", &[1.0])]);
    let bytes = file(&[image(0, "Height", ("m", "m")), component("/0/mask", b'o', small)]);
    let scan = read_bytes(&bytes).unwrap();
    assert_heights(&scan, &HEIGHTS);
    assert!(scan.warnings[0].contains("1 × 1"), "{:?}", scan.warnings);
}

#[test]
fn images_of_lengths_are_channels_in_the_order_of_their_numbers() {
    let scan = read_bytes(&full()).unwrap();
    assert_eq!((scan.channels.as_slice(), scan.channel), (&["Height".to_owned(), "Height 2".to_owned()][..], 0));
    assert_heights(&scan, &[1e-9, NAN, 3e-9, 4e-9, 5e-9, 6e-9]);
    assert!(scan.warnings.iter().any(|warning| warning.contains("`Phase` (deg)")), "{:?}", scan.warnings);
    assert_eq!(scan.metadata["Instrument"], "µScan");
    assert_eq!(scan.metadata["Averages"], "4");
    assert_eq!(scan.metadata["filename"], "C:\\ground.gwy");

    for channel in [Channel::Number(2), Channel::Name("height 2".into())] {
        let second =
            read_bytes_with(&full(), &ReadOptions { channel: Some(channel), ..ReadOptions::default() }).unwrap();
        assert_eq!(second.channel, 1);
        assert_heights(&second, &HEIGHTS.map(|z| z + 7e-6));
        assert_eq!(second.warnings, [] as [String; 0]);
        assert!(!second.metadata.contains_key("Instrument"));
    }
    assert!(matches!(read_channel(&full(), "Phase"), Err(FormatError::NoSuchChannel { .. })));
}

#[test]
fn an_image_without_title_has_its_key_for_a_name() {
    let bytes = file(&[component("/3/data", b'o', field(("m", "m"), &HEIGHTS))]);
    assert_eq!(read_bytes(&bytes).unwrap().channels, ["/3/data"]);
}

#[test]
fn files_of_gwyddion_1_are_refused_with_advice() {
    let mut bytes = full();
    bytes[3] = b'O';
    assert_eq!(Format::detect(&bytes), Some(Format::Gwy));
    assert!(refusal(&bytes).contains("Gwyddion saves it again"));
}

#[test]
fn damage_is_reported_with_field_and_place() {
    let with = |components: &[Vec<u8>]| {
        file(&[component("/0/data", b'o', object("GwyDataField", &[components.concat(), unit("si_unit_z", "m")]))])
    };
    let size = [integer("xres", 3), integer("yres", 2)].concat();
    assert!(refusal(&with(&[size.clone(), doubles("data", &[0.0; 5])])).contains("wanted 3 × 2 = 6"));
    assert!(refusal(&with(std::slice::from_ref(&size))).contains("data is missing"));
    assert!(refusal(&with(&[integer("xres", 0), integer("yres", 2), doubles("data", &[])])).contains("xres"));
    assert!(refusal(&with(&[double("xres", 3.0)])).contains("type of the component xres"));
    let huge = component("data", b'D', u32::MAX.to_le_bytes());
    assert!(refusal(&with(&[size.clone(), huge])).contains("is `34359738360 bytes`"));
    let large = [integer("xres", 1 << 15), integer("yres", 1 << 15), doubles("data", &[])].concat();
    assert!(matches!(read_bytes(&with(&[large])), Err(FormatError::TooLarge { .. })));
    assert!(refusal(&with(&[component("a", b'?', [0; 9])])).contains("one of b c i q d s o"));
    assert!(refusal(b"GWYPGwyContainer").contains("without end"));
    assert!(refusal(b"GWYPGwyContainer\0\x01\0\0\0").contains("at most 0 bytes"));
    assert!(refusal(&[b"GWYP".to_vec(), object("GwyBrick", &[])].concat()).contains("wanted GwyContainer"));
    let no_size = object("GwyDataField", &[size, unit("si_unit_z", "m"), doubles("data", &HEIGHTS)]);
    let scan = read_bytes(&file(&[component("/0/data", b'o', no_size)])).unwrap();
    assert_eq!(scan.pitch_m, None);
    assert!(scan.warnings.iter().any(|warning| warning.contains("no xreal")), "{:?}", scan.warnings);
}

/// A map of 3 × 2 points with one void, and texts of all kinds.
fn scan() -> Scan {
    let mut scan = Scan::new(array![[1e-9, NAN, 3e-9], [-4e-9, 5e-9, 6.5e-9]], Some((1.5e-6, 2.5e-6)));
    for (field, text) in [("title", "Plateau"), ("Comment", "two\nlines"), ("Zero\0Name", "a\0b"), ("", "none")] {
        scan.metadata.insert(field.into(), text.into());
    }
    scan
}

#[test]
fn written_files_follow_the_layout() {
    let mean = (1e-9 + 3e-9 - 4e-9 + 5e-9 + 6.5e-9) / 5.0;
    let metre = ["si_unit_xy", "si_unit_z"].map(|name| unit(name, "m"));
    let size = [integer("xres", 3), integer("yres", 2), double("xreal", 3.0 * 1.5e-6), double("yreal", 5e-6)].concat();
    let data = doubles("data", &[1e-9, mean, 3e-9, -4e-9, 5e-9, 6.5e-9]);
    let mask = doubles("data", &[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    let wanted = file(&[
        string("/0/data/title", "Plateau"),
        component("/0/data/visible", b'b', [1]),
        component("/0/data", b'o', object("GwyDataField", &[size.clone(), metre.concat(), data])),
        component("/0/mask", b'o', object("GwyDataField", &[size, metre[0].clone(), unit("si_unit_z", ""), mask])),
        component(
            "/0/meta",
            b'o',
            object("GwyContainer", &[string("Comment", "two\nlines"), string("ZeroName", "ab")]),
        ),
    ]);
    assert_eq!(write_gwy(&scan()).unwrap(), wanted);
}

#[test]
fn written_files_are_read_back() {
    let read = read_bytes(&write_gwy(&scan()).unwrap()).unwrap();
    assert_eq!(bits(&read), bits(&scan()));
    let (dx, dy) = read.pitch_m.unwrap();
    // Size over points undoes points times pitch to half a unit in the last place.
    assert!((dx / 1.5e-6 - 1.0).abs() <= f64::EPSILON && (dy / 2.5e-6 - 1.0).abs() <= f64::EPSILON);
    assert_eq!(read.metadata["title"], "Plateau");
    assert_eq!(read.metadata["Comment"], "two\nlines");
    assert_eq!(read.warnings, ["1 points under the mask were read as missing"]);

    let plain = Scan::new(array![[0.5, -1e300]], Some((1.0, 1.0)));
    let read = read_bytes(&write_gwy(&plain).unwrap()).unwrap();
    assert_eq!((bits(&read), &*read.metadata["title"]), (bits(&plain), "Height"));
    let empty = Scan::new(array![[NAN, f64::INFINITY]], Some((1.0, 1.0)));
    assert_eq!(read_bytes(&write_gwy(&empty).unwrap()).unwrap().missing_points(), 2);
}

#[test]
fn a_file_needs_a_pitch_and_a_point() {
    let no_pitch = Scan::new(array![[0.0]], None);
    assert!(matches!(write_gwy(&no_pitch), Err(FormatError::NoPitch { format: Format::Gwy })));
    for (heights_m, pitch_m) in [
        (ndarray::Array2::zeros((0, 3)), (1e-6, 1e-6)),
        (array![[0.0]], (0.0, 1e-6)),
        (array![[0.0, 0.0]], (1e308, 1.0)),
    ] {
        let error = write_gwy(&Scan::new(heights_m, Some(pitch_m))).unwrap_err();
        assert!(matches!(error, FormatError::NotStorable { .. }), "{error}");
    }
}
