use asperity_formats::Format;

use crate::check::{
    assert_error, assert_pitch, assert_refused, assert_scan, assert_warns, bytes, padded, patched, warns,
};
use crate::fixture::{Fixture, read_bytes};
use crate::{NAN, assert_heights, assert_metadata};

/// The number next to 3e15 that `f32` has; its text in the file is rounded.
const INVALID: f32 = 3e15;

/// Variable parts of an AL3D file. The rest is as written by MeasureSuite.
struct Al3d {
    /// Columns and rows.
    size: (usize, usize),
    /// Tags beside the dimensions and offsets.
    tags: Vec<(&'static str, &'static str)>,
    depths_m: Vec<f32>,
    /// The planes of the texture, without padding; none for a file without.
    planes: Vec<Vec<u8>>,
    has_depths: bool,
}

impl Al3d {
    fn new() -> Self {
        let sides = [("PixelSizeXMeter", "4.5e-07"), ("PixelSizeYMeter", "9e-07")];
        let others = [("InvalidPixelValue", "3.000000028082e+15"), ("CreatingApplication", "MeasureSuite 5.3.6")];
        let depths_m = vec![0.25, INVALID, 0.5, f32::NAN, -0.125, 0.0];
        Self { size: (3, 2), tags: [sides, others].concat(), depths_m, planes: vec![], has_depths: true }
    }

    /// A file with three planes of colours and one of repeatabilities.
    fn with_texture() -> Self {
        let mut file = Self::new();
        file.tags.extend([("NumberOfPlanes", "4"), ("TexturePtr", "0;1;2"), ("DepthImageResPtr", "3")]);
        let filter = [("DepthResShiftVal", "1e-9"), ("DepthResMinVal", "1e-8"), ("DepthResFilterVal", "1e-7")];
        file.tags.extend(filter);
        // 90 · 1 nm + 10 nm is the filter's value, 91 is beyond.
        file.planes = vec![vec![200; 6], vec![200; 6], vec![200; 6], vec![0, 255, 89, 255, 92, 10]];
        file
    }

    fn with(mut self, key: &str, value: &'static str) -> Self {
        self.tags.iter_mut().filter(|(known, _)| *known == key).for_each(|tag| tag.1 = value);
        self
    }

    fn bytes(&self) -> Vec<u8> {
        let (columns, rows) = self.size;
        let tag = |key: &str, value: &str| bytes![padded(key, 20), padded(bytes![value], 30), "\r\n"];
        let rows_of = |bytes: &[u8], row: usize| -> Vec<u8> {
            bytes.chunks(row).flat_map(|row| padded(row, row.len().next_multiple_of(8))).collect()
        };
        let depths = rows_of(&bytes![self.depths_m], columns * 4);
        // Signature, Version, TagCount, all tags, comment.
        let count = self.tags.len() + 5;
        let start = 17 + (2 + count) * 52 + 256;
        let texture = if self.planes.is_empty() { 0 } else { start + depths.len() };
        let (depths_at, count) = (if self.has_depths { start } else { 0 }, count.to_string());
        let first = [tag("Version", "1"), tag("TagCount", &count), tag("Cols", &columns.to_string())].concat();
        let offsets = [tag("IconOffset", "0"), tag("DepthImageOffset", &depths_at.to_string())].concat();
        let tags: Vec<u8> = self.tags.iter().flat_map(|(key, value)| tag(key, value)).collect();
        let last = [tag("Rows", &rows.to_string()), tag("TextureImageOffset", &texture.to_string())].concat();
        let header = bytes!["AliconaImaging\0\r\n", first, offsets, tags, last, "edge of a tool"];
        let planes: Vec<u8> = self.planes.iter().flat_map(|plane| rows_of(plane, columns)).collect();
        bytes![padded(header, start - 2), "\r\n", depths, planes]
    }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    // The padding of the last row, 4 bytes, need not be there; nor the texture with its 4 planes of 2 rows of 8 bytes.
    let plain = Fixture::whole("AL3D", Al3d::new().bytes());
    let texture = Fixture::whole("AL3D with a texture", Al3d::with_texture().bytes());
    vec![Fixture { needed: plain.needed - 4, ..plain }, Fixture { needed: texture.needed - 64 - 4, ..texture }]
}

const WANTED_M: [f64; 6] = [0.25, NAN, 0.5, NAN, -0.125, 0.0];

#[test]
fn rows_are_metres_padded_to_eight_bytes_as_are_the_sides_of_a_pixel() {
    let bytes = Al3d::new().bytes();
    assert_scan(&bytes, Format::Al3d, (2, 3), (4.5e-7, 9e-7), &WANTED_M);
    let even = Al3d { size: (2, 3), ..Al3d::new() };
    assert_scan(&even.bytes(), Format::Al3d, (3, 2), (4.5e-7, 9e-7), &WANTED_M);
    // The padding of the last row need not be there.
    assert_heights(&read_bytes(&bytes[..bytes.len() - 4]).unwrap(), &WANTED_M);
    assert_error(read_bytes(&bytes[..bytes.len() - 5]), "stop after");
    let mut file = Al3d::new();
    file.tags.remove(0);
    let scan = read_bytes(&file.bytes()).unwrap();
    assert_pitch(&scan, None);
    assert_warns(&scan, "PixelSizeXMeter");
}

#[test]
fn invalid_depths_are_those_from_the_stated_value_on() {
    let depths_m = vec![0.25, INVALID, f32::INFINITY, -1.0, 0.0, 2.0];
    // A bound that is no bound means just the value.
    let others = vec![0.25, 0.5, 0.75, -1.0, 0.0, 2.0];
    for (value, depths_m, wanted) in [
        ("3.000000028082e+15", &depths_m, [0.25, NAN, NAN, -1.0, 0.0, 2.0]),
        ("nan", &depths_m, [0.25, NAN, NAN, -1.0, 0.0, 2.0]),
        ("1.#QNAN", &depths_m, [0.25, NAN, NAN, -1.0, 0.0, 2.0]),
        ("2.00000001", &depths_m, [0.25, NAN, NAN, -1.0, 0.0, NAN]),
        ("-1", &others, [0.25, 0.5, 0.75, NAN, 0.0, 2.0]),
        ("0", &others, [0.25, 0.5, 0.75, -1.0, NAN, 2.0]),
    ] {
        let file = Al3d { depths_m: depths_m.clone(), ..Al3d::new() }.with("InvalidPixelValue", value);
        assert_heights(&read_bytes(&file.bytes()).unwrap(), &wanted);
    }
}

#[test]
fn depths_beyond_the_filter_of_repeatability_are_left_out_and_counted() {
    let scan = read_bytes(&Al3d::with_texture().bytes()).unwrap();
    assert_heights(&scan, &[0.25, NAN, 0.5, NAN, NAN, 0.0]);
    assert_warns(&scan, "1 depths were left out");
    // Without the plane, without a filter, and with damaged tags all depths are kept.
    let mut cut = Al3d::with_texture();
    cut.planes.pop();
    let mut open = Al3d::with_texture();
    open.tags.retain(|(key, _)| *key != "DepthResFilterVal");
    for (file, reason) in [
        (cut, "repeatabilities"),
        (open, ""),
        (Al3d::with_texture().with("DepthImageResPtr", "3;4"), "DepthImageResPtr"),
        (Al3d::with_texture().with("DepthImageResPtr", "-1"), "the number of a plane"),
        (Al3d::with_texture().with("DepthResFilterVal", "1.#QNAN"), "DepthResFilterVal"),
        (Al3d::with_texture().with("DepthResShiftVal", "fine"), "DepthResShiftVal"),
        // A filter of 0 would exclude every depth, so there is no filter.
        (Al3d::with_texture().with("DepthResFilterVal", "0"), ""),
    ] {
        let scan = read_bytes(&file.bytes()).unwrap();
        assert_heights(&scan, &WANTED_M);
        let is_reported = warns(&scan, "no depth was left out for its repeatability") && warns(&scan, reason);
        assert_eq!(is_reported, !reason.is_empty(), "{reason}: {:?}", scan.warnings);
    }
}

#[test]
fn depths_that_do_not_reach_the_texture_give_a_warning() {
    let bytes = Al3d::with_texture().bytes();
    let rows = bytes.windows(4).position(|window| window == b"Rows").unwrap();
    let gives_warning = |bytes: &[u8]| warns(&read_bytes(bytes).unwrap(), "another image starts after");
    assert!(!gives_warning(&bytes) && gives_warning(&patched(&bytes, rows + 20, "1")));
}

#[test]
fn tags_and_comment_are_kept_where_they_are_text() {
    let mut file = Al3d::new();
    file.tags.push(("PlaceHolder", "B\u{91}FI\u{1b}"));
    let scan = read_bytes(&file.bytes()).unwrap();
    assert_metadata(&scan, &[("Version", "1"), ("CreatingApplication", "MeasureSuite 5.3.6"), ("Cols", "3")]);
    assert_metadata(&scan, &[("Comment", "edge of a tool")]);
    assert_eq!(scan.metadata.get("PlaceHolder"), None);
}

#[test]
fn damaged_tags_are_named_and_a_texture_alone_is_refused() {
    let bytes = Al3d::new().bytes();
    let with = |place: usize, new: &[u8]| patched(&bytes, place, new);
    let value = |key: &str, new: &[u8]| {
        let place = bytes.windows(key.len()).position(|window| window == key.as_bytes()).unwrap();
        patched(&bytes, place + 20, new)
    };
    let cols = bytes.windows(4).position(|window| window == b"Cols").unwrap();
    assert_refused([
        (Al3d { has_depths: false, ..Al3d::with_texture() }.bytes(), "only a texture"),
        // The end of the first tag; the second tag's key; the number of tags.
        (with(17 + 50, b"\n\r"), "the end of the tag Version (byte 67) is `\\n\\r`"),
        (with(17 + 52, b"tagcount"), "(byte 69) is `tagcount`; wanted TagCount"),
        (value("TagCount", b"9x"), "TagCount (byte 69) is `9x`; wanted a whole number"),
        (value("TagCount", b"-9"), "wanted 0 to 1000"),
        // The comment is no tag.
        (value("TagCount", b"99"), "the end of the tag edge of a tool"),
        (value("TagCount", b"999"), "the end of the tag edge of a tool"),
        (value("Rows", b"0"), "is `0`; wanted 1 or more"),
        (value("Rows", b"999999999"), "the limit is"),
        (with(cols, b"Kols"), "Cols is missing"),
        (value("PixelSizeX", b"fine"), "wanted a finite number"),
        (value("DepthImageOffset", b"17\0"), "a byte after the tags"),
        (value("DepthImageOffset", b"99999"), "the depths (byte 99999) stop after 0 bytes"),
    ]);
}
