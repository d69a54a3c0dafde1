//! VK4: the header, the table of offsets, the measurement conditions and images, in the order and with the widths of
//! the published layout; VK6 around it.

use asperity_formats::{Format, FormatError, Scan};

use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::fixtures::zip;
use crate::{NAN, assert_heights, assert_metadata};

fn u32s(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// A layer of heights.
#[derive(Clone)]
struct Layer {
    size: (u32, u32),
    bits: u32,
    compression: u32,
    data: Vec<u8>,
}

impl Layer {
    /// 2 lines of 3 heights.
    fn of_32_bits() -> Self {
        Self { size: (3, 2), bits: 32, compression: 0, data: u32s(&[10, 20, 30, 40, 0, 60]) }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = u32s(&[self.size.0, self.size.1, self.bits, self.compression, self.data.len() as u32]);
        // Range of the palette, 256 colours.
        bytes.extend(u32s(&[0, 255]));
        bytes.extend([7; 768]);
        bytes.extend(&self.data);
        bytes
    }
}

/// Variable parts of a VK4 file.
#[derive(Clone)]
struct Vk4 {
    signature: &'static [u8; 4],
    file_type: u32,
    /// x, y, z in picometre.
    lengths: [u32; 3],
    layers: [Option<Layer>; 3],
}

impl Default for Vk4 {
    fn default() -> Self {
        Self {
            signature: b"VK4_",
            file_type: 0,
            lengths: [1_250_000, 2_500_000, 100],
            layers: [Some(Layer::of_32_bits()), None, None],
        }
    }
}

impl Vk4 {
    /// The measurement conditions: 76 numbers, named by their place.
    fn conditions(&self) -> Vec<u8> {
        let mut conditions = u32s(&[76 * 4]);
        // Year, month, day, hour, minute, second; minutes ahead of UTC.
        conditions.extend(u32s(&[2022, 10, 23, 12, 13, 10]));
        conditions.extend((-240_i32).to_le_bytes());
        // Image attributes, user interface mode, colour composition, layers, run mode, peak mode, sharpening level.
        conditions.extend(u32s(&[8, 9, 10, 1, 12, 13, 14]));
        // Speed, distance, pitch in nm, zoom · 10, number of lines, first line, 3 reserved.
        conditions.extend(u32s(&[15, 16_000, 750, 10, 768, 20, 0, 0, 0]));
        // Magnification · 10, PMT gain mode, gain, offset, ND filter, reserved, average, shutter mode, shutter speed.
        conditions.extend(u32s(&[500, 25, 26, 27, 28, 0, 30, 31, 32]));
        // White balance mode, red, blue; camera gain, plane compensation.
        conditions.extend(u32s(&[33, 34, 35, 36, 37]));
        // Units of lengths and heights, their decimal places.
        conditions.extend(u32s(&[38, 39, 40, 41]));
        conditions.extend(u32s(&self.lengths));
        // 5 reserved, light filter, reserved, gamma reverse, gamma, its offset, CCD offset.
        conditions.extend(u32s(&[0, 0, 0, 0, 0, 50, 0, 52, 53, 54, 55]));
        // Numerical aperture · 1000, head type, second PMT gain, colour omitted, lens ID, LUT mode.
        conditions.extend(u32s(&[950, 57, 58, 59, 60, 61]));
        // 5 pairs of the LUT, upper and lower position in nm, effective bits of light and height.
        conditions.extend(u32s(&[0; 10]));
        conditions.extend(u32s(&[72, 73, 16, 21]));
        assert_eq!(conditions.len(), 76 * 4);
        conditions
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.signature.to_vec();
        // Version of the library, the main number last.
        bytes.extend([4, 3, 2, 1]);
        bytes.extend(self.file_type.to_le_bytes());
        let entries = if self.signature == b"VK3_" { 17 } else { 18 };
        let conditions = self.conditions();
        let start = bytes.len() + 4 * entries;
        let (mut parts, mut heights) = (conditions, [0; 3]);
        // The strings: each its length in units of UTF-16 and the units.
        let strings_at = (start + parts.len()) as u32;
        for text in ["Zahnrad µ7", "Plan 50x"] {
            let units: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
            parts.extend(u32s(&[units.len() as u32 / 2]));
            parts.extend(units);
        }
        for (layer, offset) in self.layers.iter().zip(&mut heights) {
            if let Some(layer) = layer {
                *offset = (start + parts.len()) as u32;
                parts.extend(layer.bytes());
            }
        }
        // Conditions; colour of peak and light; 3 of light; 3 of heights.
        let mut table = u32s(&[start as u32, 0, 0, 0, 0, 0]);
        table.extend(u32s(&heights));
        // 4 thumbnails, assembly, line measurement, line thickness, strings, and in VK4 one that is reserved.
        table.extend(u32s(&[0, 0, 0, 0, 0, 0, 0, strings_at, 0]));
        bytes.extend(&table[..4 * entries]);
        bytes.extend(parts);
        bytes
    }
}

/// An image of errors: its size, bytes per point and row, and rows.
fn errors(nx: u32, ny: u32, bytes_per_point: u32, stride: u32, rows: &[u8]) -> Vec<u8> {
    [u32s(&[nx, ny, bytes_per_point, stride]), rows.to_vec()].concat()
}

/// A VK6 or VK7 file: signature, size of the preview, preview, archive.
fn vk6(signature: &[u8; 3], files: &[(&str, &[u8])]) -> Vec<u8> {
    // A BMP header: `BM`, its size, no more.
    let preview = [b"BM".to_vec(), u32s(&[14]), vec![0; 8]].concat();
    [signature.to_vec(), u32s(&[preview.len() as u32]), preview, zip(files)].concat()
}

/// A VK6 file with an image of errors.
fn vk6_with_errors(errors: &[u8]) -> Vec<u8> {
    let images = zip(&[("HdrImageData", b"left out"), ("ErrorImageData", errors)]);
    vk6(b"VK6", &[("Vk4File", &Vk4::default().bytes()), ("Vk6ImageData", &images)])
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let small = Layer { size: (2, 2), bits: 16, compression: 0, data: vec![1, 0, 2, 0, 3, 0, 255, 255] };
    let layers = [Some(small.clone()), None, Some(small.clone())];
    // The second layer comes last, so the first alone is read of a beginning.
    let several = Vk4 { signature: b"VK3_", layers, ..Vk4::default() };
    vec![
        Fixture::whole("VK4 of one layer", Vk4::default().bytes()),
        Fixture::open_ended("VK3 of two layers", several.bytes()),
        Fixture::whole("VK6 with errors", vk6_with_errors(&errors(3, 2, 1, 4, &[0, 1, 0, 0, 0, 0, 0, 0]))),
    ]
}

fn reading(vk4: &Vk4) -> Scan {
    read_bytes(&vk4.bytes()).unwrap()
}

fn layered(layer: Layer) -> Vk4 {
    Vk4 { layers: [Some(layer), None, None], ..Vk4::default() }
}

#[test]
fn heights_and_pitches_are_picometre_and_the_first_line_is_at_the_top() {
    let scan = reading(&Vk4::default());
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_heights(&scan, &[1e-9, 2e-9, 3e-9, 4e-9, 0.0, 6e-9]);
    assert_eq!(scan.pitch_m, Some((1.25e-6, 2.5e-6)));
    assert_eq!(scan.channels, ["Height 1"]);
}

#[test]
fn numbers_of_every_width_are_unsigned() {
    let cases = [
        (8, vec![1, 128, 255, 2], [1e-10, 128e-10, 255e-10, 2e-10]),
        (16, vec![1, 0, 0, 128, 255, 255, 2, 0], [1e-10, 32768e-10, 65535e-10, 2e-10]),
        (32, u32s(&[1, 1 << 31, u32::MAX, 2]), [1e-10, 2147483648e-10, 4294967295e-10, 2e-10]),
    ];
    for (bits, data, wanted) in cases {
        let scan = reading(&layered(Layer { size: (2, 2), bits, compression: 0, data }));
        assert_heights(&scan, &wanted);
    }
}

#[test]
fn heights_of_0_are_kept_with_a_warning() {
    let warned = |scan: &Scan| scan.warnings.iter().any(|warning| warning.starts_with("1 heights are 0"));
    assert!(warned(&reading(&Vk4::default())));
    let full = Layer { data: u32s(&[1, 2, 3, 4, 5, 6]), ..Layer::of_32_bits() };
    assert!(!warned(&reading(&layered(full))));
}

#[test]
fn layers_of_heights_are_channels_by_their_numbers() {
    let second = Layer { data: u32s(&[1, 2, 3, 4, 5, 6]), ..Layer::of_32_bits() };
    let file = Vk4 { layers: [Some(Layer::of_32_bits()), None, Some(second)], ..Vk4::default() }.bytes();
    let scan = read_bytes(&file).unwrap();
    assert_eq!((scan.channels, scan.channel), (vec!["Height 1".to_owned(), "Height 3".to_owned()], 0));
    let scan = read_channel(&file, "height 3").unwrap();
    assert_heights(&scan, &[1e-10, 2e-10, 3e-10, 4e-10, 5e-10, 6e-10]);
    assert_eq!(scan.channel, 1);
}

#[test]
fn vk3_has_a_shorter_table() {
    let scan = reading(&Vk4 { signature: b"VK3_", ..Vk4::default() });
    assert_eq!(crate::bits(&scan), crate::bits(&reading(&Vk4::default())));
    assert_eq!(scan.metadata["title"], "Zahnrad µ7");
}

#[test]
fn the_measurement_conditions_and_strings_are_kept() {
    let scan = reading(&Vk4::default());
    let wanted = [
        ("date", "2022-10-23T12:13:10-04:00"),
        ("library version", "1.2.3.4"),
        ("title", "Zahnrad µ7"),
        ("lens name", "Plan 50x"),
        ("image layers", "1"),
        ("run mode", "12"),
        ("peak mode", "13"),
        ("sharpening level", "14"),
        ("speed", "15"),
        ("distance", "16000 nm"),
        ("pitch", "750 nm"),
        ("optical zoom", "1"),
        ("number of lines", "768"),
        ("first line position", "20"),
        ("lens magnification", "50"),
        ("PMT gain mode", "25"),
        ("PMT gain", "26"),
        ("PMT offset", "27"),
        ("ND filter", "28"),
        ("image average frequency", "30"),
        ("shutter speed", "32"),
        ("plane compensation", "37"),
        ("x length per pixel", "1250000 pm"),
        ("y length per pixel", "2500000 pm"),
        ("z length per digit", "100 pm"),
        ("numerical aperture", "0.95"),
        ("head type", "57"),
        ("lens ID", "60"),
        ("upper position", "72 nm"),
        ("lower position", "73 nm"),
        ("height effective bit depth", "21"),
    ];
    assert_metadata(&scan, &wanted);
}

#[test]
fn vk6_and_vk7_hold_a_vk4_file_in_an_archive_after_a_preview() {
    let inner = Vk4::default().bytes();
    for signature in [b"VK6", b"VK7"] {
        let file = vk6(signature, &[("Vk6ImageData", &zip(&[])), ("Vk4File", &inner)]);
        assert_eq!(Format::detect(&file), Some(Format::Vk));
        let scan = read_bytes(&file).unwrap();
        assert_eq!(crate::bits(&scan), crate::bits(&reading(&Vk4::default())));
        assert_eq!(scan.metadata["lens name"], "Plan 50x");
    }
}

#[test]
fn points_of_the_image_of_errors_are_missing() {
    // Rows of 3 points in 4 bytes; the fourth is no point.
    let scan = read_bytes(&vk6_with_errors(&errors(3, 2, 1, 4, &[0, 1, 0, 9, 255, 0, 0, 9]))).unwrap();
    assert_heights(&scan, &[1e-9, NAN, 3e-9, NAN, 0.0, 6e-9]);
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("2 points are marked in ErrorImageData")));
    let scan = read_bytes(&vk6_with_errors(&errors(3, 2, 1, 3, &[0; 6]))).unwrap();
    assert_eq!(scan.missing_points(), 0);
    assert!(!scan.warnings.iter().any(|warning| warning.contains("ErrorImageData")));
}

#[test]
fn an_image_of_errors_that_does_not_fit_is_left_out_with_a_warning() {
    for (image, reason) in [
        (errors(2, 2, 1, 2, &[1; 4]), "width (ErrorImageData, byte 0) is `2`; wanted 3"),
        (errors(3, 3, 1, 3, &[1; 9]), "height (ErrorImageData, byte 4) is `3`; wanted 2"),
        (errors(3, 2, 4, 12, &[1; 12]), "bytes per point (ErrorImageData, byte 8) is `4`; wanted 1"),
        (errors(3, 2, 1, 2, &[1; 6]), "bytes per row (ErrorImageData, byte 12) is `2`"),
        (errors(3, 2, 1, 3, &[1; 5]), "the rows (ErrorImageData, byte 16) stop after 5 bytes; wanted 6"),
        (errors(3, 2, 1, 3, &[1; 13]), "the file's size in bytes (ErrorImageData, byte 0) is 29; the limit is 28"),
    ] {
        let scan = read_bytes(&vk6_with_errors(&image)).unwrap();
        assert_eq!(scan.missing_points(), 0);
        let wanted = format!("ErrorImageData was left out: VK4/VK6: {reason}");
        assert!(
            scan.warnings.iter().any(|warning| warning.starts_with(&wanted)),
            "{:?}, wanted {wanted}",
            scan.warnings
        );
    }
}

#[test]
fn a_damaged_image_of_errors_leaves_the_heights() {
    let image = errors(3, 2, 1, 4, &[0, 1, 0, 9, 255, 0, 0, 9]);
    for bit in 0..8 * image.len() {
        let mut damaged = image.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(read_bytes(&vk6_with_errors(&damaged)).unwrap().heights_m.dim(), (2, 3));
        let scan = read_bytes(&vk6_with_errors(&image[..bit / 8])).unwrap();
        assert_eq!(scan.heights_m.dim(), (2, 3));
    }
}

#[test]
fn archives_without_a_vk4_file_and_previews_beyond_the_file_are_refused() {
    let message = |bytes: &[u8]| read_bytes(bytes).unwrap_err().to_string();
    assert_eq!(message(&vk6(b"VK6", &[("Other", b"")])), "VK4/VK6: Vk4File: no such file in the archive");
    let mut long = vk6(b"VK7", &[("Vk4File", &Vk4::default().bytes())]);
    long[3..7].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(message(&long).starts_with("VK4/VK6: the bytes of the preview (byte 7) stop after"), "{}", message(&long));
    let inner = vk6(b"VK6", &[("Vk4File", b"VK4_")]);
    assert_eq!(message(&inner), "VK4/VK6: file type (Vk4File, byte 8) stop after 0 bytes; wanted 4");
}

#[test]
fn text_that_starts_with_vk6_is_not_a_vk6_file() {
    assert_eq!(Format::detect(b"VK6 sample\n1 2\n3 4\n"), Some(Format::Text));
}

#[test]
fn compression_is_detected_by_the_size_in_bytes_only() {
    let marked = Layer { compression: u32::from_le_bytes(*b"MC32"), ..Layer::of_32_bits() };
    assert_eq!(crate::bits(&reading(&layered(marked.clone()))), crate::bits(&reading(&Vk4::default())));
    let packed = Layer { data: vec![1; 20], ..marked };
    let message = read_bytes(&layered(packed).bytes()).unwrap_err().to_string();
    assert!(
        message.contains("byte size") && message.contains("is `20`; wanted 24, the size of uncompressed heights"),
        "{message}"
    );
}

#[test]
fn files_of_images_only_are_refused() {
    let message = read_bytes(&Vk4 { layers: [None, None, None], ..Vk4::default() }.bytes()).unwrap_err().to_string();
    assert_eq!(message, "VK4/VK6: the file holds no heights, only images; wanted a layer of heights");
}

#[test]
fn another_file_type_is_reported() {
    let scan = reading(&Vk4 { file_type: 2, ..Vk4::default() });
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("the file type is 2, not 0")));
}

#[test]
fn headers_that_exceed_the_file_are_errors() {
    let sized = |size, bits| read_bytes(&layered(Layer { size, bits, ..Layer::of_32_bits() }).bytes());
    assert!(matches!(sized((u32::MAX, u32::MAX), 32), Err(FormatError::TooLarge { .. })));
    for (size, bits, wanted) in [((0, 2), 32, "width"), ((3, 0), 32, "height"), ((3, 2), 24, "bit depth")] {
        assert!(matches!(sized(size, bits), Err(FormatError::Field { field, .. }) if field == wanted));
    }
    let flat = read_bytes(&Vk4 { lengths: [1, 1, 0], ..Vk4::default() }.bytes());
    assert!(matches!(flat, Err(FormatError::Field { field, .. }) if field == "z length per digit"));
    let unscaled = reading(&Vk4 { lengths: [0, 1, 1], ..Vk4::default() });
    assert_eq!(unscaled.pitch_m, None);
    let mut lost = Vk4::default().bytes();
    lost[12..16].fill(0);
    let message = read_bytes(&lost).unwrap_err().to_string();
    assert_eq!(
        message,
        "VK4/VK6: the offset of the measurement conditions is missing (byte 12); wanted a value above 0"
    );
    // Conditions that end before the lengths.
    let mut short = Vk4::default().bytes();
    short[84..88].copy_from_slice(&168_u32.to_le_bytes());
    let message = read_bytes(&short).unwrap_err().to_string();
    assert!(message.contains("length per"), "{message}");
}

#[test]
fn strings_that_do_not_fit_are_left_out() {
    let mut bytes = Vk4::default().bytes();
    // The length of the title, right after the conditions.
    bytes[84 + 304..84 + 308].copy_from_slice(&u32::MAX.to_le_bytes());
    let scan = read_bytes(&bytes).unwrap();
    assert!(!scan.metadata.contains_key("title") && !scan.metadata.contains_key("lens name"));
}
