//! TIFF, by TIFF 6.0 and its technical notes.

use asperity_formats::{Format, FormatError, Scan};
use weezl::BitOrder;

use crate::check::{
    assert_no_warning, assert_pitch, assert_refused, assert_scan, assert_warns, bytes, padded, patched, warns,
};
use crate::fixture::{Fixture, read_bytes, read_channel, read_in_metre};
use crate::fixtures::deflated as zlib;
use crate::memory::peak_bytes;
use crate::{NAN, assert_heights, assert_metadata};

/// A file in one of the two orders of bytes, classic or big.
#[derive(Clone, Copy)]
struct Kind {
    big_endian: bool,
    big: bool,
}

const CLASSIC: Kind = Kind { big_endian: false, big: false };
const KINDS: [Kind; 4] = [
    CLASSIC,
    Kind { big_endian: true, big: false },
    Kind { big_endian: false, big: true },
    Kind { big_endian: true, big: true },
];

impl Kind {
    /// A number of some bytes.
    fn number(self, value: u64, width: usize) -> Vec<u8> {
        let mut raw = value.to_le_bytes()[..width].to_vec();
        if self.big_endian {
            raw.reverse();
        }
        raw
    }

    fn f32s(self, values: &[f64]) -> Vec<u8> {
        values.iter().flat_map(|&z| self.number((z as f32).to_bits().into(), 4)).collect()
    }
}

/// The value of a field.
#[derive(Clone)]
enum Value {
    Short(u64),
    Long(u64),
    Text(&'static str),
    /// A quotient.
    Rational(u64, u64),
    Double(f64),
    Bytes(Vec<u8>),
}

/// A page: its fields but for those of strips or tiles, and these.
#[derive(Clone)]
struct Page {
    fields: Vec<(u16, Value)>,
    chunks: Vec<Vec<u8>>,
    tiled: bool,
}

impl Page {
    /// A grey page of 3 × 2 numbers in one strip.
    fn new(bits: u64, format: u64, strip: Vec<u8>) -> Self {
        let fields = [(256, 3), (257, 2), (258, bits), (259, 1), (262, 1), (277, 1), (339, format)];
        let fields = fields.map(|(tag, value)| (tag, Value::Short(value))).to_vec();
        Self { fields, chunks: vec![strip], tiled: false }
    }

    fn with(mut self, tag: u16, value: Value) -> Self {
        self.fields.retain(|(known, _)| *known != tag);
        self.fields.push((tag, value));
        self
    }

    /// Fields with their numbers, types and raw values; the offsets of strips or tiles start at `data`.
    fn raw(&self, kind: Kind, mut data: u64) -> Vec<(u16, u64, u64, Vec<u8>)> {
        let mut raw: Vec<_> = self
            .fields
            .iter()
            .map(|(tag, value)| match value {
                Value::Short(value) => (*tag, 3, 1, kind.number(*value, 2)),
                Value::Long(value) => (*tag, 4, 1, kind.number(*value, 4)),
                Value::Text(text) => (*tag, 2, text.len() as u64 + 1, [text.as_bytes(), &[0]].concat()),
                Value::Rational(over, under) => (*tag, 5, 1, [kind.number(*over, 4), kind.number(*under, 4)].concat()),
                Value::Double(value) => (*tag, 12, 1, kind.number(value.to_bits(), 8)),
                Value::Bytes(bytes) => (*tag, 7, bytes.len() as u64, bytes.clone()),
            })
            .collect();
        let (mut offsets, mut sizes) = (Vec::new(), Vec::new());
        for chunk in &self.chunks {
            offsets.extend(kind.number(data, 4));
            sizes.extend(kind.number(chunk.len() as u64, 4));
            data += chunk.len() as u64;
        }
        let count = self.chunks.len() as u64;
        raw.push((if self.tiled { 324 } else { 273 }, 4, count, offsets));
        raw.push((if self.tiled { 325 } else { 279 }, 4, count, sizes));
        raw.sort_by_key(|(tag, ..)| *tag);
        raw
    }
}

/// Header, directories with their values, then the strips and tiles of all pages.
fn tiff(kind: Kind, pages: &[Page]) -> Vec<u8> {
    let (count_width, width, inline) = if kind.big { (8, 20, 8) } else { (2, 12, 4) };
    let outside = |raw: &[u8]| if raw.len() > inline { raw.len() } else { 0 };
    let directory_bytes = |page: &Page| {
        let raw = page.raw(kind, 0);
        count_width + raw.len() * width + inline + raw.iter().map(|(.., raw)| outside(raw)).sum::<usize>()
    };
    // Order of bytes, version; of big files the size of offsets and zero; the first directory.
    let mut bytes = if kind.big_endian { b"MM".to_vec() } else { b"II".to_vec() };
    bytes.extend(kind.number(if kind.big { 43 } else { 42 }, 2));
    if kind.big {
        bytes.extend([kind.number(8, 2), kind.number(0, 2)].concat());
    }
    let first = bytes.len() + inline;
    bytes.extend(kind.number(first as u64, inline));
    let mut data = first as u64 + pages.iter().map(|page| directory_bytes(page) as u64).sum::<u64>();
    for (place, page) in pages.iter().enumerate() {
        let raw = page.raw(kind, data);
        data += page.chunks.iter().map(|chunk| chunk.len() as u64).sum::<u64>();
        let mut values_at = bytes.len() + count_width + raw.len() * width + inline;
        let mut values: Vec<u8> = Vec::new();
        bytes.extend(kind.number(raw.len() as u64, count_width));
        for (tag, field_type, count, value) in &raw {
            bytes.extend(kind.number((*tag).into(), 2));
            bytes.extend(kind.number(*field_type, 2));
            bytes.extend(kind.number(*count, inline));
            if outside(value) > 0 {
                bytes.extend(kind.number(values_at as u64, inline));
                values_at += value.len();
                values.extend(value);
            } else {
                bytes.extend(value);
                bytes.extend(vec![0; inline - value.len()]);
            }
        }
        let next = if place + 1 < pages.len() { values_at } else { 0 };
        bytes.extend(kind.number(next as u64, inline));
        bytes.extend(values);
    }
    for page in pages {
        bytes.extend(page.chunks.concat());
    }
    bytes
}

const HEIGHTS: [f64; 6] = [1.0, -2.0, 3.5, 4.0, 5.0, 0.25];

fn floats() -> Page {
    Page::new(32, 3, CLASSIC.f32s(&HEIGHTS))
}

fn lzw(bytes: &[u8]) -> Vec<u8> {
    weezl::encode::Encoder::with_tiff_size_switch(BitOrder::Msb, 8).encode(bytes).unwrap()
}

/// PackBits without repeats: the number of bytes less one, and the bytes.
fn pack_bits(bytes: &[u8]) -> Vec<u8> {
    bytes.chunks(128).flat_map(|piece| [&[piece.len() as u8 - 1], piece].concat()).collect()
}

/// Rows of 3 numbers in tiles of 2 × 2, filled up with 99.
fn tiles(kind: Kind) -> Page {
    let tile = |values: &[f64; 4]| kind.f32s(values);
    let mut page = Page::new(32, 3, Vec::new()).with(322, Value::Short(2)).with(323, Value::Long(2));
    page.tiled = true;
    page.chunks = vec![tile(&[1.0, -2.0, 4.0, 5.0]), tile(&[3.5, 99.0, 0.25, 99.0])];
    page
}

const IMAGE_J: &str = "ImageJ=1.54f\nunit=\\u00B5m\nvunit=nm\ncf=0\nc0=1\nc1=2\n";
const OME: &str = "<?xml version=\"1.0\"?><!-- a --><OME><Image ID=\"Image:0\"><Pixels DimensionOrder=\"XYZCT\" \
                   PhysicalSizeX=\"0.5\" PhysicalSizeY=\"250\" PhysicalSizeYUnit=\"nm\"/></Image></OME>";

pub(crate) fn fixtures() -> Vec<Fixture> {
    let mut strips = floats().with(278, Value::Short(1)).with(259, Value::Short(32773));
    strips.chunks = HEIGHTS.chunks(3).map(|row| pack_bits(&CLASSIC.f32s(row))).collect();
    let second = Page::new(16, 1, vec![1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0]);
    let lzw_page = Page::new(8, 2, lzw(&[1, 2, 3, 4, 5, 255])).with(259, Value::Short(5)).with(317, Value::Short(2));
    let two_pages = tiff(KINDS[1], &[floats().with(270, Value::Text(OME)), second]);
    let deflated = |values: &[f64]| zlib(&values.iter().flat_map(|z| z.to_le_bytes()).collect::<Vec<_>>());
    let predicted = Page::new(64, 3, deflated(&HEIGHTS)).with(259, Value::Short(8)).with(317, Value::Short(3));
    vec![
        Fixture::open_ended("JPK", jpk(CLASSIC)),
        Fixture::open_ended("LEXT", lext(CLASSIC, "HEIGHT")),
        Fixture::open_ended("Park Systems", park(0x0100_0001, 0, vec![1; 12], "um")),
        Fixture::whole(
            "TIFF of ImageJ",
            tiff(CLASSIC, &[resolved(2, 4).with(270, Value::Text(IMAGE_J)).with(296, Value::Short(1))]),
        ),
        // The twelve bytes of the second page are at the end, and the first page is read.
        Fixture { needed: two_pages.len() - 12, ..Fixture::whole("TIFF with OME-XML", two_pages) },
        Fixture::whole("TIFF big with tiles", tiff(KINDS[2], &[tiles(KINDS[2]).with(42113, Value::Text("5"))])),
        Fixture::whole("TIFF with PackBits", tiff(CLASSIC, &[strips.with(274, Value::Short(6))])),
        Fixture::whole("TIFF with LZW", tiff(CLASSIC, &[lzw_page])),
        Fixture::whole("TIFF with Deflate", tiff(CLASSIC, &[predicted])),
    ]
}

fn read(page: &Page) -> Scan {
    read_bytes(&tiff(CLASSIC, std::slice::from_ref(page))).unwrap_or_else(|error| panic!("{error}"))
}

/// Reads a page whose heights are stated to be in metre.
fn in_metre(page: &Page) -> Scan {
    read_in_metre(&tiff(CLASSIC, std::slice::from_ref(page))).unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts the words with which files of one page are refused.
#[track_caller]
fn assert_pages_refused<const N: usize>(pages: [(Page, &str); N]) {
    assert_refused(pages.map(|(page, words)| (tiff(CLASSIC, &[page]), words)));
}

/// The usual numbers with a resolution along x and y in points per unit.
fn resolved(x: u64, y: u64) -> Page {
    floats().with(282, Value::Rational(x, 1)).with(283, Value::Rational(y, 1))
}

#[test]
fn floats_are_heights_in_metre_in_every_layout() {
    for kind in KINDS {
        let bytes = tiff(kind, &[Page::new(32, 3, kind.f32s(&HEIGHTS))]);
        let scan = assert_scan(&bytes, Format::Tiff, (2, 3), None, &HEIGHTS);
        assert_no_warning(&scan);
        assert_eq!(scan.channels, ["page 1"]);
        let doubles = HEIGHTS.iter().flat_map(|z| kind.number((z / 3.0).to_bits(), 8)).collect();
        assert_heights(&read_bytes(&tiff(kind, &[Page::new(64, 3, doubles)])).unwrap(), &HEIGHTS.map(|z| z / 3.0));
        assert_heights(&read_bytes(&tiff(kind, &[tiles(kind)])).unwrap(), &HEIGHTS);
    }
    // Numbers stand whichever colour is zero.
    assert_heights(&read(&floats().with(262, Value::Short(0))), &HEIGHTS);
}

#[test]
fn integers_give_a_warning() {
    let values: [i64; 6] = [1, 2, 127, -128, -1, 0];
    for width in [1, 2, 4] {
        for kind in KINDS {
            let raw: Vec<u8> = values.iter().flat_map(|&z| kind.number(z as u64, width)).collect();
            let bits = 8 * width as u64;
            let signed = read_bytes(&tiff(kind, &[Page::new(bits, 2, raw.clone())])).unwrap();
            assert_heights(&signed, &values.map(|z| z as f64));
            assert_warns(&signed, "counts without a unit");
            let unsigned = read_bytes(&tiff(kind, &[Page::new(bits, 1, raw)])).unwrap();
            let range = 2_f64.powi(8 * width as i32);
            assert_heights(&unsigned, &values.map(|z| if z < 0 { z as f64 + range } else { z as f64 }));
        }
    }
}

#[test]
fn every_packing_reads() {
    for kind in KINDS {
        let rows: Vec<Vec<u8>> = HEIGHTS.chunks(3).map(|row| kind.f32s(row)).collect();
        for (method, pack) in [
            (1, (|bytes| bytes.to_vec()) as fn(&[u8]) -> Vec<u8>),
            (5, lzw),
            (8, zlib),
            (32946, zlib),
            (32773, pack_bits),
        ] {
            let mut page = Page::new(32, 3, Vec::new()).with(259, Value::Short(method)).with(278, Value::Long(1));
            page.chunks = rows.iter().map(|row| pack(row)).collect();
            assert_heights(&read_bytes(&tiff(kind, &[page])).unwrap(), &HEIGHTS);
        }
    }
    for (method, name) in [(4, "fax"), (7, "JPEG"), (50000, "Zstandard"), (12345, "number 12345")] {
        assert_pages_refused([(floats().with(259, Value::Short(method)), name)]);
    }
    assert_pages_refused([(floats().with(266, Value::Short(2)), "FillOrder")]);
}

#[test]
fn differences_of_neighbours_are_summed() {
    for kind in KINDS {
        // Rows 500, 502, 501 and 65535, 0, 1 modulo 2¹⁶.
        let raw: Vec<u8> = [500, 2, 0xffff, 0xffff, 1, 1].iter().flat_map(|&z| kind.number(z, 2)).collect();
        let page = |packed| Page::new(16, 1, packed).with(317, Value::Short(2));
        let packed = page(zlib(&raw)).with(259, Value::Short(8));
        assert_heights(&read_bytes(&tiff(kind, &[packed])).unwrap(), &[500.0, 502.0, 501.0, 65535.0, 0.0, 1.0]);
        // Without compression there is no predictor, whatever the value of its field.
        let plain = page(raw);
        assert_heights(&read_bytes(&tiff(kind, &[plain])).unwrap(), &[500.0, 2.0, 65535.0, 65535.0, 1.0, 1.0]);
    }
}

#[test]
fn differences_of_sorted_bytes_are_summed() {
    for kind in KINDS {
        // The bytes of a row from the highest of all numbers to the lowest of all, each less the one before it.
        let encoded: Vec<u8> = HEIGHTS
            .chunks(3)
            .flat_map(|row| {
                let raw: Vec<[u8; 4]> = row.iter().map(|&z| (z as f32).to_be_bytes()).collect();
                let sorted: Vec<u8> = (0..4).flat_map(|place| raw.iter().map(move |raw| raw[place])).collect();
                let before = [0].into_iter().chain(sorted.clone());
                sorted.iter().zip(before).map(|(byte, before)| byte.wrapping_sub(before)).collect::<Vec<_>>()
            })
            .collect();
        let page = Page::new(32, 3, zlib(&encoded)).with(259, Value::Short(8)).with(317, Value::Short(3));
        assert_heights(&read_bytes(&tiff(kind, &[page])).unwrap(), &HEIGHTS);
    }
    let integers = Page::new(16, 1, zlib(&[0; 12])).with(259, Value::Short(8));
    assert_pages_refused([(integers.with(317, Value::Short(3)), "Predictor")]);
}

#[test]
fn the_orientation_tag_turns_the_map_upright() {
    let [a, b, c, d, e, f] = HEIGHTS;
    // Where row 0 and column 0 are: top left, top right, bottom right, bottom left, then with rows upright.
    for (orientation, wanted) in [
        (1, [a, b, c, d, e, f]),
        (2, [c, b, a, f, e, d]),
        (3, [f, e, d, c, b, a]),
        (4, [d, e, f, a, b, c]),
        (5, [a, d, b, e, c, f]),
        (6, [d, a, e, b, f, c]),
        (7, [f, c, e, b, d, a]),
        (8, [c, f, b, e, a, d]),
    ] {
        let page = resolved(1, 2).with(296, Value::Short(3)).with(274, Value::Short(orientation));
        let (shape, pitch_m) = if orientation > 4 { ((3, 2), (0.005, 0.01)) } else { ((2, 3), (0.01, 0.005)) };
        let scan = in_metre(&page);
        assert_eq!(scan.heights_m.dim(), shape);
        assert_heights(&scan, &wanted);
        assert_pitch(&scan, pitch_m);
    }
    assert_pages_refused([(floats().with(274, Value::Short(9)), "Orientation")]);
}

#[test]
fn resolutions_per_inch_and_centimetre_give_the_pitch() {
    let page = floats().with(282, Value::Rational(5080, 2)).with(283, Value::Double(1270.0));
    // Without an absolute unit there is no pitch.
    for (unit, pitch_m) in
        [(2, Some((0.0254 / 2540.0, 0.0254 / 1270.0))), (3, Some((0.01 / 2540.0, 0.01 / 1270.0))), (1, None)]
    {
        assert_eq!(in_metre(&page.clone().with(296, Value::Short(unit))).pitch_m, pitch_m);
    }
    for (per_inch, gives_warning) in [(1, true), (72, true), (300, true), (25400, false)] {
        let scan = in_metre(&resolved(per_inch, per_inch));
        assert_eq!(scan.pitch_m, Some((0.0254 / per_inch as f64, 0.0254 / per_inch as f64)));
        assert_eq!(warns(&scan, "screen's or printer's"), gives_warning, "{per_inch}: {:?}", scan.warnings);
    }
    let none = floats().with(282, Value::Rational(1, 0)).with(283, Value::Rational(1, 0));
    assert_eq!(read(&none).pitch_m, None);
}

#[test]
fn descriptions_state_units_and_calibration() {
    let imagej = |text| resolved(2, 4).with(296, Value::Short(1)).with(270, Value::Text(text));
    let scan = read(&imagej(IMAGE_J));
    // Two and four points per micrometre; heights 1 nm + 2 nm · n.
    assert_eq!(scan.pitch_m, Some((1.0 / 2e6, 1.0 / 4e6)));
    assert_heights(&scan, &HEIGHTS.map(|z| 1e-9 + 2e-9 * z));
    assert_metadata(&scan, &[("unit", "µm"), ("ImageJ", "1.54f")]);
    for (text, pitch_m) in [
        ("ImageJ=1.54f\nunit=micron\nyunit=mm\n", Some((1.0 / 2e6, 1.0 / 4e3))),
        ("ImageJ=1.54f\nunit=pixel\n", None),
        ("ImageJ=1.54f\ncf=20\nvunit=OD\n", None),
    ] {
        let scan = in_metre(&imagej(text));
        assert_heights(&scan, &HEIGHTS);
        assert_eq!((scan.pitch_m, warns(&scan, "calibration")), (pitch_m, text.contains("cf=20")));
    }
    // OME-XML goes before the tags of resolution.
    let of_ome = |text| in_metre(&resolved(72, 72).with(270, Value::Text(text)));
    let scan = of_ome(OME);
    assert_eq!(scan.pitch_m, Some((0.5 / 1e6, 250.0 / 1e9)));
    assert_metadata(&scan, &[("ImageDescription", OME)]);
    assert_eq!(of_ome("<OME><Pixels PhysicalSizeX=\"a\"").pitch_m, Some((0.0254 / 72.0, 0.0254 / 72.0)));
}

#[test]
fn the_value_for_no_data_is_missing() {
    let read = |numbers: [f64; 6], mark| read(&Page::new(32, 3, CLASSIC.f32s(&numbers)).with(42113, Value::Text(mark)));
    let scan = read([1.0, NAN, f64::INFINITY, -9999.0, 0.1, 2.0], "-9999");
    assert_heights(&scan, &[1.0, NAN, NAN, NAN, f64::from(0.1_f32), 2.0]);
    // The digits of a double where the numbers are single.
    assert_eq!(read([0.1, 1.0, 2.0, 3.0, 4.0, 5.0], "0.1").missing_points(), 1);
    assert_pages_refused([(floats().with(42113, Value::Text("none")), "GDAL_NODATA")]);
}

#[test]
fn pages_are_channels_and_those_of_other_kinds_are_left_out() {
    let named = Page::new(32, 3, CLASSIC.f32s(&[9.0; 6])).with(285, Value::Text("Height"));
    let colours = Page::new(8, 1, vec![0; 18]).with(262, Value::Short(2)).with(277, Value::Short(3));
    let thumbnail = floats().with(254, Value::Long(1));
    let bytes = tiff(CLASSIC, &[colours, thumbnail, floats().with(305, Value::Text("a program")), named]);
    let scan = read_bytes(&bytes).unwrap();
    assert_eq!((scan.channels.as_slice(), scan.channel), (&["page 3".into(), "Height".into()][..], 0));
    assert_heights(&scan, &HEIGHTS);
    assert_metadata(&scan, &[("Software", "a program")]);
    assert_warns(&scan, "left out: page 1 is in colours (RGB), page 2 is a smaller copy of another");
    let scan = read_channel(&bytes, "height").unwrap();
    assert_heights(&scan, &[9.0; 6]);
    assert_metadata(&scan, &[("PageName", "Height")]);
}

#[test]
fn pages_that_cannot_be_heights_are_refused_with_a_reason() {
    let short = |tag, value| floats().with(tag, Value::Short(value));
    assert_pages_refused([
        (short(262, 2), "page 1 is in colours (RGB)"),
        (short(262, 3), "colours of a palette"),
        (short(277, 2), "2 numbers per point"),
        (short(258, 16), "numbers of 16 bits and SampleFormat 3"),
        (short(258, 1), "numbers of 1 bits"),
        (short(339, 6), "SampleFormat 6"),
    ]);
}

#[test]
fn declared_sizes_are_not_believed() {
    let sized = |size| floats().with(256, Value::Long(size)).with(257, Value::Long(size));
    // One strip after the other over the same bytes.
    let mut overlapping = floats().with(259, Value::Short(32773)).with(278, Value::Short(1));
    overlapping.chunks = vec![Vec::new(); 2];
    let overlapping = tiff(CLASSIC, &[overlapping]);
    assert_refused([(patched(&overlapping, overlapping.len() - 8, [0xffff_u32; 2]), "at most the")]);
    assert_pages_refused([
        (sized(1 << 15), "the limit is"),
        (sized(1 << 14), "places for 1073741824 bytes"),
        (sized(1 << 14).with(259, Value::Short(8)), "more than 256 times"),
        (floats().with(256, Value::Short(0)), "ImageWidth"),
        (floats().with(278, Value::Long(0)), "RowsPerStrip"),
        (floats().with(278, Value::Long(1)), "wanted 2 numbers"),
    ]);
}

#[test]
fn a_flat_page_unpacks_within_bounds_and_a_bomb_does_not() {
    let page = |size: u64, strip: Vec<u8>| {
        let page = Page::new(64, 3, strip).with(256, Value::Long(size)).with(257, Value::Long(size));
        tiff(CLASSIC, &[page.with(259, Value::Short(8))])
    };
    let flat = page(2048, zlib(&vec![0; 8 << 22]));
    assert!(flat.len() < 1 << 16);
    let (scan, peak) = peak_bytes(|| read_bytes(&flat).unwrap());
    assert_eq!(scan.heights_m.dim(), (2048, 2048));
    // The heights, and the memory for unpacking one row.
    assert!(peak < (8 << 22) + (1 << 20), "{peak}");
    assert_refused([(page(2049, zlib(&vec![0; 8 * 2049 * 2049])), "more than 256 times as many")]);
}

#[test]
fn directories_that_lead_back_are_refused() {
    let file = tiff(CLASSIC, &[floats()]);
    // The offset of the next directory follows two bytes of a count and 12 bytes per field.
    assert_refused([(patched(&file, 10 + 12 * usize::from(file[8]), 8_u8), "no earlier directory")]);
    assert!(matches!(read_bytes(b"II*\0\0\0\0\0"), Err(FormatError::Unsupported { .. })));
    for cut in [b"II*\0".as_slice(), b"MM\0*\xff\xff\xff\xff"] {
        assert!(matches!(read_bytes(cut), Err(FormatError::Truncated { .. })));
    }
}

#[test]
fn files_of_vendors_are_refused_by_name() {
    const LEXT: &str = "<?xml version=\"1.0\"?><TiffTagDescData><HeightInfo/></TiffTagDescData>";
    const OLS: &str = "[System Info]\r\nSystem Name =         OLS3000\r\n";
    let [park, jpk, olympus] = [
        "a Park Systems TIFF file without heights",
        "a JPK file without the size of its grid",
        "an Olympus LEXT file without a page of heights, or of an OLS3000",
    ];
    let cases = [
        // Park: magic number and version.
        (50432, Value::Long(0x0e03_1301), park),
        (50435, Value::Long(1), park),
        // JPK: version of the file, width of the grid, name of the channel.
        (32768, Value::Long(1), jpk),
        (32834, Value::Double(1e-5), jpk),
        (32848, Value::Text("height"), jpk),
        (270, Value::Text(LEXT), olympus),
        (270, Value::Text(OLS), olympus),
        (271, Value::Text("OLYMPUS"), olympus),
    ];
    for (tag, value, name) in cases {
        for kind in KINDS {
            // In the second page as well.
            let vendor = Page::new(16, 1, vec![0; 12]).with(tag, value.clone());
            for pages in [vec![vendor.clone()], vec![Page::new(16, 1, vec![0; 12]), vendor]] {
                let error = read_bytes(&tiff(kind, &pages)).unwrap_err();
                assert!(matches!(error, FormatError::NotRead { .. }), "{error}");
                let wanted = format!("this is {name}, which is not read; Gwyddion can save it as GWY");
                assert_eq!(error.to_string(), wanted);
            }
        }
    }
    // Fields of others in the same range: ImageID, ImageDepth.
    for tag in [32781, 32997] {
        assert!(read_bytes(&tiff(CLASSIC, &[floats().with(tag, Value::Long(1))])).is_ok(), "{tag}");
    }
}

/// A JPK image: a picture with the size of the grid, a height in two slots, a height scanned backwards, and a phase.
fn jpk(kind: Kind) -> Vec<u8> {
    let integers = |numbers: [i64; 6]| numbers.iter().flat_map(|n| kind.number(*n as u64, 4)).collect();
    let slot = |page: Page, slot: u16, name: &'static str, unit: &'static str, multiplier: f64, offset: f64| {
        let first = 0x8090 + 48 * slot;
        let page = page.with(first, Value::Text(name)).with(first + 0x12, Value::Text(unit));
        let page = page.with(first + 0x13, Value::Text("LinearScaling")).with(first + 0x14, Value::Double(multiplier));
        page.with(first + 0x15, Value::Double(offset))
    };
    let page = |name: &'static str, unit: &'static str, retrace: u64| {
        let page = Page::new(32, 2, integers([0, 1, 2, 3, 4, -5])).with(0x8050, Value::Text("channel"));
        let page =
            page.with(0x8051, Value::Short(retrace)).with(0x8052, Value::Text(name)).with(0x8080, Value::Short(2));
        let page = page.with(0x8081, Value::Text("calibrated"));
        slot(slot(page, 0, "raw", unit, 7.0, 7.0), 1, "calibrated", unit, -10.0, 100.0)
    };
    let grid = [(0x8040, 0.5), (0x8041, 0.5), (0x8042, 3e-6), (0x8043, 4e-6)];
    let mut first = Page::new(8, 1, vec![0; 6]).with(262, Value::Short(3)).with(0x8000, Value::Text("6.0.41"));
    for (tag, value) in grid {
        first = first.with(tag, Value::Double(value));
    }
    let first = first.with(0x8046, Value::Long(3)).with(0x8047, Value::Long(2));
    tiff(kind, &[first, page("Phase", "deg", 0), page("Height", "nm", 1), page("Height", "nm", 0)])
}

#[test]
fn heights_of_jpk_are_those_of_the_default_slot_from_the_bottom_up() {
    for kind in KINDS {
        let scan = read_bytes(&jpk(kind)).unwrap();
        assert_eq!(
            (scan.channels.as_slice(), scan.channel),
            (["Height (retrace)", "Height"].map(str::to_owned).as_slice(), 0)
        );
        assert_heights(&scan, &[70e-9, 60e-9, 150e-9, 100e-9, 90e-9, 80e-9]);
        assert_pitch(&scan, (1e-6, 2e-6));
        assert_metadata(&scan, &[("slot", "calibrated")]);
        assert_eq!(scan.height_unit.as_deref(), Some("nm"));
        assert!(scan.warnings[0].contains("Phase has the unit `deg`"), "{:?}", scan.warnings);
    }
}

/// A LEXT file: a picture whose Exif directory is its own, a page of intensities, and one of heights.
fn lext(kind: Kind, height: &'static str) -> Vec<u8> {
    const DESCRIPTION: &str = "<?xml version=\"1.0\"?><TiffTagDescData><HeightInfo><HeightDataPerPixelX>250000</HeightDataPerPixelX>\
        <HeightDataPerPixelY>500000</HeightDataPerPixelY><HeightDataPerPixelZ>1000</HeightDataPerPixelZ></HeightInfo></TiffTagDescData>";
    const SETTINGS: &str = "<?xml version=\"1.0\"?><ExifTagDescData><ImageCommonSettingsInfo><MakerCalibrationValueX>2000000\
        </MakerCalibrationValueX><MakerCalibrationValueY>1000000</MakerCalibrationValueY><MakerCalibrationValueZ>500000\
        </MakerCalibrationValueZ></ImageCommonSettingsInfo></ExifTagDescData>";
    let first = Page::new(8, 1, vec![0; 18]).with(262, Value::Short(2)).with(277, Value::Short(3));
    let first = first.with(270, Value::Text(DESCRIPTION)).with(34665, Value::Long(if kind.big { 16 } else { 8 }));
    let first = first.with(41995, Value::Text(SETTINGS));
    let numbers = |numbers: [u64; 6]| Page::new(16, 1, numbers.iter().flat_map(|n| kind.number(*n, 2)).collect());
    let intensity = numbers([9; 6]).with(270, Value::Text("INTENSITY"));
    tiff(kind, &[first, intensity, numbers([0, 1, 2, 3, 4, 65535]).with(270, Value::Text(height))])
}

#[test]
fn heights_of_lext_are_calibrated_picometres() {
    for kind in KINDS {
        // 1000 pm, of which the calibration leaves half.
        let heights = [0.0, 0.5e-9, 1e-9, 1.5e-9, 2e-9, 32767.5e-9];
        let scan = assert_scan(&lext(kind, "HEIGHT"), Format::Tiff, (2, 3), (0.5e-6, 0.5e-6), &heights);
        assert_metadata(&scan, &[("HeightInfo/HeightDataPerPixelZ", "1000")]);
        assert_refused([(lext(kind, "DEPTH"), "an Olympus LEXT file without a page of heights")]);
    }
}

/// A Park Systems file: a picture with a header and numbers of `kind` in private fields.
fn park(version: u64, kind: u32, numbers: Vec<u8>, unit: &str) -> Vec<u8> {
    let text = |text: &str, letters: usize| padded(text.encode_utf16().collect::<Vec<_>>(), 2 * letters);
    // Source, way and size of the map, its sides, scale, factor and offset of the heights, their unit.
    let mut header = padded(bytes![[0_u8; 4], text("Topography", 32), text("NC", 8)], 484);
    for (at, value) in [
        (100, bytes![[3_u32, 2]]),
        (140, bytes![[3.0, 4.0]]),
        (220, bytes![[2e-3, 2.0, 3.0], text(unit, 8)]),
        (348, bytes![kind]),
    ] {
        header = patched(&header, at, value);
    }
    let page = Page::new(8, 1, vec![0; 18]).with(262, Value::Short(2)).with(277, Value::Short(3));
    let page = page.with(50432, Value::Long(0x0e03_1301)).with(50433, Value::Long(version));
    tiff(CLASSIC, &[page.with(50434, Value::Bytes(numbers)).with(50435, Value::Bytes(header))])
}

#[test]
fn heights_of_park_systems_are_scaled_numbers_of_a_private_field_from_the_bottom_up() {
    let numbers = [1, 2, 3, 4, 5, -6];
    let shorts = bytes![numbers.map(|n| n as i16)];
    let floats = bytes![numbers.map(|n| n as f32)];
    let cases = [
        (0x0100_0001, 9, shorts.clone()),
        (0x0100_0002, 0, shorts),
        (0x0100_0002, 1, bytes![numbers]),
        (0x0100_0002, 2, floats.clone()),
    ];
    for (version, kind, numbers) in cases {
        for (unit, metre) in [("um", 1e-6), ("", 1e-6), ("nm", 1e-9)] {
            let bytes = park(version, kind, numbers.clone(), unit);
            // (2n + 3) · 0.002.
            let heights = [22.0, 26.0, -18.0, 10.0, 14.0, 18.0].map(|z| z * 1e-3 * metre);
            assert_eq!(assert_scan(&bytes, Format::Tiff, (2, 3), (1e-6, 2e-6), &heights).channels, ["Topography"]);
        }
    }
    assert_refused([
        (park(0x0100_0002, 2, floats.clone(), "V"), "`Topography` (V)"),
        (park(0x0100_0002, 3, floats, "um"), "type of numbers"),
    ]);
}
