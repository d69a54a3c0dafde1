//! GWY, by the layout in Gwyddion's user guide.

use asperity_formats::{Format, Scan, write_gwy};
use ndarray::array;

use crate::check::{
    Raw, assert_error, assert_no_warning, assert_pitch, assert_refused, assert_scan, assert_warns, bytes, patched,
};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::{NAN, assert_heights, assert_metadata};

/// A component: name, zero, letter of the type, value.
fn component(name: &str, kind: char, value: impl Raw) -> Vec<u8> {
    bytes![name, [0, kind as u8], value]
}

fn string(name: &str, value: &str) -> Vec<u8> {
    component(name, 's', bytes![value, 0_u8])
}

fn integer(name: &str, value: i32) -> Vec<u8> {
    component(name, 'i', value)
}

fn double(name: &str, value: f64) -> Vec<u8> {
    component(name, 'd', value)
}

fn doubles(name: &str, values: &[f64]) -> Vec<u8> {
    component(name, 'D', bytes![values.len() as u32, values])
}

/// An object: name of the type, zero, size of the components, components.
fn object(kind: &str, components: &[Vec<u8>]) -> Vec<u8> {
    let content = components.concat();
    bytes![kind, 0_u8, content.len() as u32, content]
}

fn unit(name: &str, unit: &str) -> Vec<u8> {
    component(name, 'o', object("GwySIUnit", &[string("unitstr", unit)]))
}

/// An image of 3 × 2 points over 6 × 8 lateral units.
fn field(units: (&str, &str), values: &[f64]) -> Vec<u8> {
    let size = [integer("xres", 3), integer("yres", 2), double("xreal", 6e-6), double("yreal", 8e-6)].concat();
    let offset = [double("xoff", 1e-6), double("yoff", 0.0)].concat();
    let units = [unit("si_unit_xy", units.0), unit("si_unit_z", units.1)].concat();
    object("GwyDataField", &[size, offset, units, doubles("data", values)])
}

const HEIGHTS: [f64; 6] = [1e-9, 2e-9, 3e-9, 4e-9, 5e-9, 6e-9];

fn image(number: u32, title: &str, units: (&str, &str)) -> Vec<u8> {
    let values = HEIGHTS.map(|z| z + f64::from(number) * 1e-6);
    let data = component(&format!("/{number}/data"), 'o', field(units, &values));
    [string(&format!("/{number}/data/title"), title), data].concat()
}

fn mask(values: &[f64]) -> Vec<u8> {
    component("/0/mask", 'o', field(("m", ""), values))
}

fn file(components: &[Vec<u8>]) -> Vec<u8> {
    [b"GWYP".to_vec(), object("GwyContainer", components)].concat()
}

/// A file with everything that the reader looks at and all types of components.
fn full() -> Vec<u8> {
    let selection = object("GwySelectionPoint", &[integer("max", 1), doubles("data", &[1.0, 2.0])]);
    let texts = [string("Instrument", "µScan"), string("Comment", "a\nb"), integer("Averages", 4)];
    file(&[
        string("/filename", "C:\\ground.gwy"),
        component("/0/data/visible", 'b', [1_u8]),
        component("/0/select/pointer", 'o', selection.clone()),
        component("/0/letter", 'c', "x"),
        component("/0/long", 'q', 7_i64),
        component("/0/letters", 'C', bytes![2_u32, "ab"]),
        component("/0/integers", 'I', [1_u32, 0]),
        component("/0/longs", 'Q', bytes![1_u32, 0_u64]),
        component("/0/texts", 'S', bytes![2_u32, "a\0b\0"]),
        component("/0/objects", 'O', bytes![2_u32, selection, selection]),
        image(0, "Height", ("m", "m")),
        mask(&[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
        component("/0/meta", 'o', object("GwyContainer", &texts)),
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
    // The stated sizes are those of whole points: 6 µm / 3 and 8 µm / 2.
    let bytes = file(&[image(0, "Height", ("m", "m"))]);
    let scan = assert_scan(&bytes, Format::Gwy, (2, 3), (2e-6, 4e-6), &HEIGHTS);
    // Row 0 is the first stored one.
    assert_eq!(scan.heights_m[[1, 0]], 4e-9);
    assert_metadata(&scan, &[("title", "Height"), ("xoff", "1e-6 m")]);
    assert!(!scan.metadata.contains_key("yoff"));
    assert_no_warning(&scan);
    // An image without title has its key for a name.
    let unnamed = file(&[component("/3/data", 'o', field(("m", "m"), &HEIGHTS))]);
    assert_eq!(read_bytes(&unnamed).unwrap().channels, ["/3/data"]);
}

#[test]
fn units_are_applied_or_doubted_with_a_warning() {
    for (written, per_metre) in [("nm", 1e9), ("µm", 1e6), ("um", 1e6), ("mm", 1e3), ("Å", 1e10)] {
        let scan = read(("m", written));
        assert_heights(&scan, &HEIGHTS.map(|z| z / per_metre));
        assert_pitch(&scan, (2e-6, 4e-6));
        assert_warns(&scan, "prefixes");
        let scan = read((written, "m"));
        assert_heights(&scan, &HEIGHTS);
        assert_pitch(&scan, (6e-6 / 3.0 / per_metre, 8e-6 / 2.0 / per_metre));
    }
    // A file without any unit counts as metre.
    let scan = read(("", ""));
    assert_heights(&scan, &HEIGHTS);
    assert_pitch(&scan, (2e-6, 4e-6));
    assert_warns(&scan, "states no units");
    for unit in ["", "px", "s", "A"] {
        let scan = read((unit, "m"));
        assert_pitch(&scan, None);
        assert_warns(&scan, "no pixel size");
    }
    // A is the ampere and not the ångström; no unit beside metres is a plain number.
    let other = |unit| file(&[image(0, "Current", ("m", unit))]);
    assert_refused(["A", "deg", "V", ""].map(|unit| (other(unit), "no image of the file holds lengths: `Current`")));
}

#[test]
fn masked_points_are_missing_with_a_warning() {
    let bytes = file(&[image(0, "Height", ("m", "m")), mask(&[0.0, 1.0, 0.4, 0.6, 0.0, -1.0])]);
    let scan = read_bytes(&bytes).unwrap();
    assert_heights(&scan, &[1e-9, NAN, 3e-9, NAN, 5e-9, 6e-9]);
    assert_eq!(scan.warnings, ["2 points under the mask were read as missing"]);
    // A mask of another size is left out.
    let small = object("GwyDataField", &[integer("xres", 1), integer("yres", 1), doubles("data", &[1.0])]);
    let scan = read_bytes(&file(&[image(0, "Height", ("m", "m")), component("/0/mask", 'o', small)])).unwrap();
    assert_heights(&scan, &HEIGHTS);
    assert_warns(&scan, "1 × 1");
}

#[test]
fn images_of_lengths_are_channels_in_the_order_of_their_numbers() {
    let scan = read_bytes(&full()).unwrap();
    assert_eq!((scan.channels.as_slice(), scan.channel), (&["Height".to_owned(), "Height 2".to_owned()][..], 0));
    assert_heights(&scan, &[1e-9, NAN, 3e-9, 4e-9, 5e-9, 6e-9]);
    assert_warns(&scan, "`Phase` (deg)");
    assert_metadata(&scan, &[("Instrument", "µScan"), ("Averages", "4"), ("filename", "C:\\ground.gwy")]);
    for channel in ["2", "height 2"] {
        let second = read_channel(&full(), channel).unwrap();
        assert_eq!(second.channel, 1);
        assert_heights(&second, &HEIGHTS.map(|z| z + 7e-6));
        assert_no_warning(&second);
        assert!(!second.metadata.contains_key("Instrument"));
    }
    assert_error(read_channel(&full(), "Phase"), "no height map");
}

#[test]
fn damage_is_reported_with_field_and_place() {
    let with = |components: &[Vec<u8>]| {
        file(&[component("/0/data", 'o', object("GwyDataField", &[components.concat(), unit("si_unit_z", "m")]))])
    };
    let size = |x, y| [integer("xres", x), integer("yres", y)].concat();
    let huge = component("data", 'D', u32::MAX);
    assert_refused([
        (patched(&full(), 3, "O"), "Gwyddion saves it again"),
        (file(&[]), "no image"),
        (with(&[size(3, 2), doubles("data", &[0.0; 5])]), "wanted 3 × 2 = 6"),
        (with(&[size(3, 2)]), "data is missing"),
        (with(&[size(0, 2), doubles("data", &[])]), "xres"),
        (with(&[double("xres", 3.0)]), "type of the component xres"),
        (with(&[size(3, 2), huge]), "is `34359738360 bytes`"),
        (with(&[size(1 << 15, 1 << 15), doubles("data", &[])]), "the limit is"),
        (with(&[component("a", '?', [0_u8; 9])]), "one of b c i q d s o"),
        (b"GWYPGwyContainer".to_vec(), "without end"),
        (b"GWYPGwyContainer\0\x01\0\0\0".to_vec(), "at most 0 bytes"),
        (bytes!["GWYP", object("GwyBrick", &[])], "wanted GwyContainer"),
    ]);
    let no_size = object("GwyDataField", &[size(3, 2), unit("si_unit_z", "m"), doubles("data", &HEIGHTS)]);
    let scan = read_bytes(&file(&[component("/0/data", 'o', no_size)])).unwrap();
    assert_pitch(&scan, None);
    assert_warns(&scan, "no xreal");
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
    let texts = [string("Comment", "two\nlines"), string("ZeroName", "ab")];
    let wanted = file(&[
        string("/0/data/title", "Plateau"),
        component("/0/data/visible", 'b', [1_u8]),
        component("/0/data", 'o', object("GwyDataField", &[size.clone(), metre.concat(), data])),
        component("/0/mask", 'o', object("GwyDataField", &[size, metre[0].clone(), unit("si_unit_z", ""), mask])),
        component("/0/meta", 'o', object("GwyContainer", &texts)),
    ]);
    assert_eq!(write_gwy(&scan()).unwrap(), wanted);
    let read = read_bytes(&wanted).unwrap();
    assert_metadata(&read, &[("title", "Plateau"), ("Comment", "two\nlines")]);
    assert_eq!(read.warnings, ["1 points under the mask were read as missing"]);
    let plain = write_gwy(&Scan::new(array![[0.5]], Some((1.0, 1.0)))).unwrap();
    assert_metadata(&read_bytes(&plain).unwrap(), &[("title", "Height")]);
}
