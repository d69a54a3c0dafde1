use asperity_formats::{Format, FormatError};

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

impl Default for Al3d {
    fn default() -> Self {
        Self {
            size: (3, 2),
            tags: vec![
                ("PixelSizeXMeter", "4.5e-07"),
                ("PixelSizeYMeter", "9e-07"),
                ("InvalidPixelValue", "3.000000028082e+15"),
                ("CreatingApplication", "MeasureSuite 5.3.6"),
            ],
            depths_m: vec![0.25, INVALID, 0.5, f32::NAN, -0.125, 0.0],
            planes: vec![],
            has_depths: true,
        }
    }
}

impl Al3d {
    /// A file with three planes of colours and one of repeatabilities.
    fn with_texture() -> Self {
        let mut file = Self::default();
        file.tags.extend([
            ("NumberOfPlanes", "4"),
            ("TexturePtr", "0;1;2"),
            ("DepthImageResPtr", "3"),
            ("DepthResShiftVal", "1e-9"),
            ("DepthResMinVal", "1e-8"),
            ("DepthResFilterVal", "1e-7"),
        ]);
        // 90 · 1 nm + 10 nm is the filter's value, 91 is beyond.
        file.planes = vec![vec![200; 6], vec![200; 6], vec![200; 6], vec![0, 255, 89, 255, 92, 10]];
        file
    }

    fn bytes(&self) -> Vec<u8> {
        let (columns, rows) = self.size;
        let tag = |key: &str, value: &str| {
            let mut tag = [key.as_bytes(), &vec![0; 20 - key.len()]].concat();
            tag.extend(value.bytes());
            tag.resize(50, 0);
            tag.extend(b"\r\n");
            tag
        };
        let padded = |bytes: &[u8], row: usize| -> Vec<u8> {
            bytes
                .chunks(row)
                .flat_map(|row| {
                    let mut row = row.to_vec();
                    row.resize(row.len().next_multiple_of(8), 0xee);
                    row
                })
                .collect()
        };
        let depths: Vec<u8> = self.depths_m.iter().flat_map(|z| z.to_le_bytes()).collect();
        let depths = padded(&depths, columns * 4);
        // Signature, Version, TagCount, all tags, comment.
        let count = self.tags.len() + 5;
        let start = 17 + (2 + count) * 52 + 256;
        let texture = if self.planes.is_empty() { 0 } else { start + depths.len() };

        let mut bytes = b"AliconaImaging\0\r\n".to_vec();
        bytes.extend(tag("Version", "1"));
        bytes.extend(tag("TagCount", &count.to_string()));
        bytes.extend(tag("Cols", &columns.to_string()));
        bytes.extend(tag("IconOffset", "0"));
        bytes.extend(tag("DepthImageOffset", &(if self.has_depths { start } else { 0 }).to_string()));
        for (key, value) in &self.tags {
            bytes.extend(tag(key, value));
        }
        bytes.extend(tag("Rows", &rows.to_string()));
        bytes.extend(tag("TextureImageOffset", &texture.to_string()));
        bytes.extend(b"edge of a tool");
        bytes.resize(start - 2, 0);
        bytes.extend(b"\r\n");
        assert_eq!(bytes.len(), start);
        bytes.extend(depths);
        for plane in &self.planes {
            bytes.extend(padded(plane, columns));
        }
        bytes
    }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    // The padding of the last row, 4 bytes, need not be there; nor the texture with its 4 planes of 2 rows of 8 bytes.
    let plain = Fixture::whole("AL3D", Al3d::default().bytes());
    let texture = Fixture::whole("AL3D with a texture", Al3d::with_texture().bytes());
    vec![Fixture { needed: plain.needed - 4, ..plain }, Fixture { needed: texture.needed - 64 - 4, ..texture }]
}

#[test]
fn rows_are_metres_padded_to_eight_bytes() {
    let scan = read_bytes(&Al3d::default().bytes()).unwrap();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_heights(&scan, &[0.25, NAN, 0.5, NAN, -0.125, 0.0]);
    let even = Al3d { size: (2, 3), ..Al3d::default() };
    assert_heights(&read_bytes(&even.bytes()).unwrap(), &[0.25, NAN, 0.5, NAN, -0.125, 0.0]);
}

#[test]
fn the_padding_of_the_last_row_need_not_be_there() {
    let bytes = Al3d::default().bytes();
    let whole = read_bytes(&bytes).unwrap();
    assert_eq!(crate::bits(&read_bytes(&bytes[..bytes.len() - 4]).unwrap()), crate::bits(&whole));
    let error = read_bytes(&bytes[..bytes.len() - 5]).unwrap_err();
    assert!(matches!(error, FormatError::Truncated { format: Format::Al3d, .. }), "{error}");
}

#[test]
fn sides_of_a_pixel_are_metres_along_x_and_y() {
    assert_eq!(read_bytes(&Al3d::default().bytes()).unwrap().pitch_m, Some((4.5e-7, 9e-7)));
    let mut file = Al3d::default();
    file.tags.remove(0);
    let scan = read_bytes(&file.bytes()).unwrap();
    assert_eq!(scan.pitch_m, None);
    assert!(scan.warnings.iter().any(|warning| warning.contains("PixelSizeXMeter")), "{:?}", scan.warnings);
}

#[test]
fn invalid_depths_are_those_from_the_stated_value_on() {
    let depths_m = vec![0.25, INVALID, f32::INFINITY, -1.0, 0.0, 2.0];
    for (value, wanted) in [
        ("3.000000028082e+15", [0.25, NAN, NAN, -1.0, 0.0, 2.0]),
        ("nan", [0.25, NAN, NAN, -1.0, 0.0, 2.0]),
        ("1.#QNAN", [0.25, NAN, NAN, -1.0, 0.0, 2.0]),
        ("2.00000001", [0.25, NAN, NAN, -1.0, 0.0, NAN]),
    ] {
        let mut file = Al3d { depths_m: depths_m.clone(), ..Al3d::default() };
        file.tags[2].1 = value;
        assert_heights(&read_bytes(&file.bytes()).unwrap(), &wanted);
    }
    // A bound that is no bound means just the value.
    let depths_m = vec![0.25, 0.5, 0.75, -1.0, 0.0, 2.0];
    for (value, wanted) in [("-1", [0.25, 0.5, 0.75, NAN, 0.0, 2.0]), ("0", [0.25, 0.5, 0.75, -1.0, NAN, 2.0])] {
        let mut file = Al3d { depths_m: depths_m.clone(), ..Al3d::default() };
        file.tags[2].1 = value;
        assert_heights(&read_bytes(&file.bytes()).unwrap(), &wanted);
    }
}

#[test]
fn depths_beyond_the_filter_of_repeatability_are_left_out_and_counted() {
    let scan = read_bytes(&Al3d::with_texture().bytes()).unwrap();
    assert_heights(&scan, &[0.25, NAN, 0.5, NAN, NAN, 0.0]);
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("1 depths were left out")), "{:?}", scan.warnings);
}

#[test]
fn without_the_plane_of_repeatabilities_all_depths_are_kept() {
    let mut file = Al3d::with_texture();
    file.planes.pop();
    let scan = read_bytes(&file.bytes()).unwrap();
    assert_heights(&scan, &[0.25, NAN, 0.5, NAN, -0.125, 0.0]);
    assert!(scan.warnings.iter().any(|warning| warning.contains("repeatabilities")), "{:?}", scan.warnings);
    let mut file = Al3d::with_texture();
    file.tags.retain(|(key, _)| *key != "DepthResFilterVal");
    let scan = read_bytes(&file.bytes()).unwrap();
    assert_heights(&scan, &[0.25, NAN, 0.5, NAN, -0.125, 0.0]);
    assert!(!scan.warnings.iter().any(|warning| warning.contains("repeatabilities")), "{:?}", scan.warnings);
}

#[test]
fn damaged_tags_of_the_repeatability_leave_all_depths() {
    for (key, value, reason) in [
        ("DepthImageResPtr", "3;4", "DepthImageResPtr"),
        ("DepthImageResPtr", "-1", "the number of a plane"),
        ("DepthResFilterVal", "1.#QNAN", "DepthResFilterVal"),
        ("DepthResShiftVal", "fine", "DepthResShiftVal"),
        // A filter of 0 would exclude every depth, so there is no filter.
        ("DepthResFilterVal", "0", ""),
    ] {
        let mut file = Al3d::with_texture();
        file.tags.iter_mut().filter(|(known, _)| *known == key).for_each(|tag| tag.1 = value);
        let scan = read_bytes(&file.bytes()).unwrap_or_else(|error| panic!("{key}: {error}"));
        assert_heights(&scan, &[0.25, NAN, 0.5, NAN, -0.125, 0.0]);
        let is_reported = scan.warnings.iter().any(|warning| {
            warning.starts_with("no depth was left out for its repeatability") && warning.contains(reason)
        });
        assert_eq!(is_reported, !reason.is_empty(), "{key}: {:?}", scan.warnings);
    }
}

#[test]
fn depths_that_do_not_reach_the_texture_give_a_warning() {
    let gives_warning = |bytes: &[u8]| {
        read_bytes(bytes).unwrap().warnings.iter().any(|warning| warning.contains("another image starts after"))
    };
    let file = Al3d::with_texture();
    let mut bytes = file.bytes();
    assert!(!gives_warning(&bytes));
    let tag = bytes.windows(4).position(|window| window == b"Rows").unwrap();
    bytes[tag + 20] = b'1';
    assert!(gives_warning(&bytes));
}

#[test]
fn tags_and_comment_are_kept_where_they_are_text() {
    let mut file = Al3d::default();
    file.tags.push(("PlaceHolder", "B\u{91}FI\u{1b}"));
    let scan = read_bytes(&file.bytes()).unwrap();
    let wanted =
        [("Version", "1"), ("CreatingApplication", "MeasureSuite 5.3.6"), ("Cols", "3"), ("Comment", "edge of a tool")];
    assert_metadata(&scan, &wanted);
    assert_eq!(scan.metadata.get("PlaceHolder"), None);
}

#[test]
fn a_texture_alone_is_refused_with_a_reason() {
    let error = read_bytes(&Al3d { has_depths: false, ..Al3d::with_texture() }.bytes()).unwrap_err();
    assert!(matches!(error, FormatError::Unsupported { format: Format::Al3d, .. }), "{error}");
    assert!(error.to_string().contains("only a texture"), "{error}");
}

#[test]
fn damaged_tags_are_named() {
    let bytes = Al3d::default().bytes();
    let with = |place: usize, new: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[place..place + new.len()].copy_from_slice(new);
        read_bytes(&bytes).unwrap_err().to_string()
    };
    let place = |key: &[u8]| bytes.windows(key.len()).position(|window| window == key).unwrap();
    // The end of the first tag; the second tag's key; the number of tags.
    assert!(with(17 + 50, b"\n\r").contains("the end of the tag Version (byte 67) is `\\n\\r`"));
    assert!(with(17 + 52, b"tagcount").contains("(byte 69) is `tagcount`; wanted TagCount"));
    assert!(with(17 + 52 + 20, b"9x").contains("TagCount (byte 69) is `9x`; wanted a whole number"));
    assert!(with(17 + 52 + 20, b"-9").contains("wanted 0 to 1000"));
    // The comment is no tag.
    assert!(with(17 + 52 + 20, b"99").contains("the end of the tag edge of a tool"));
    assert!(with(17 + 52 + 20, b"999").contains("the end of the tag edge of a tool"));
    assert!(with(place(b"Rows") + 20, b"0").contains("is `0`; wanted 1 or more"));
    assert!(with(place(b"Rows") + 20, b"999999999").contains("the limit is"));
    assert!(with(place(b"Cols"), b"Kols").contains("Cols is missing"));
    assert!(with(place(b"PixelSizeX") + 20, b"fine").contains("wanted a finite number"));
    assert!(with(place(b"DepthImageOffset") + 20, b"17\0").contains("a byte after the tags"));
    assert!(with(place(b"DepthImageOffset") + 20, b"99999").contains("the depths (byte 99999) stop after 0 bytes"));
}
