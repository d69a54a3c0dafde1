//! FRT: blocks in the order and with the widths of the published layout (tags and sizes as in the table of blocks).

use asperity_formats::FormatError;

use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::{NAN, assert_heights, assert_metadata};

fn bytes_of<const N: usize, T>(numbers: &[T], bytes: impl Fn(&T) -> [u8; N]) -> Vec<u8> {
    numbers.iter().flat_map(bytes).collect()
}

fn u32s(numbers: &[u32]) -> Vec<u8> {
    bytes_of(numbers, |n| n.to_le_bytes())
}

fn f64s(numbers: &[f64]) -> Vec<u8> {
    bytes_of(numbers, |n| n.to_le_bytes())
}

fn u16s(numbers: &[u16]) -> Vec<u8> {
    bytes_of(numbers, |n| n.to_le_bytes())
}

fn i32s(numbers: &[i32]) -> Vec<u8> {
    bytes_of(numbers, |n| n.to_le_bytes())
}

/// A file of blocks, each a tag and its bytes.
#[derive(Clone)]
struct Frt {
    version: &'static [u8; 4],
    blocks: Vec<(u16, Vec<u8>)>,
}

impl Frt {
    /// 2 lines of 3 numbers of 16 bits, the second of them missing, 3 mm × 4 mm, 10 nm per step.
    fn single() -> Self {
        let blocks = vec![
            (0x0065, b"hob ground, \xb5 = 0.1\0\0".to_vec()),
            (0x0066, u32s(&[3, 2, 16])),
            // x range, y range, x offset, y offset, y range over x range; scan direction.
            (0x0067, [f64s(&[3e-3, 4e-3, 0.5, 0.25, 4.0 / 3.0]), u32s(&[9])].concat()),
            // x speed, y speed; four flags and delays and one more.
            (0x0068, [f64s(&[1e-3, 2e-3]), u32s(&[0, 1, 0, 20, 30])].concat()),
            // Range of 800 µm, metre per step.
            (0x006c, [u32s(&[2]), f64s(&[1e-8])].concat()),
            (0x006e, u32s(&[4, 5, 6])),
            // First and last valid number.
            (0x0070, u32s(&[2, 65000])),
            (0x0071, f64s(&[0.125])),
            // Start, end, duration.
            (0x0072, u32s(&[1_678_463_840, u32::MAX, 77])),
            (0x0077, b"fast".to_vec()),
            // Name and description of the user, each after its length.
            (0x00ac, [u32s(&[5]), b"Anna\0".to_vec(), u32s(&[3]), b"lab".to_vec()].concat()),
            // Serial number after its length; day, month, year; created, number of values.
            (0x008e, [u32s(&[4]), b"S-42".to_vec(), vec![1, 2], u16s(&[2020]), u32s(&[0, 0])].concat()),
            // A block of an unknown tag.
            (0x1234, vec![7; 5]),
            (0x000b, u16s(&[100, 1, 65000, 400, 0, 600])),
        ];
        Self { version: b"1.00", blocks }
    }

    /// Topography of the top sensor, intensity, and thickness below of other size, after a repetition of the intensity.
    fn several() -> Self {
        let image =
            |kind: u32, nx: u32, ny: u32, bits: u32, numbers: Vec<u8>| [u32s(&[kind, nx, ny, bits]), numbers].concat();
        let images = [
            // Description of the current buffer: four numbers.
            u16s(&[3, 0, 0, 0]),
            image(0x0000_0002, 2, 2, 16, u16s(&[9, 9, 9, 9])),
            // Second buffer of the bottom sensor: computed thickness.
            image(0x1102_0080, 4, 2, 32, i32s(&[-5, 6, 7, 8, 1, -1, i32::MIN, i32::MAX])),
            image(0x0000_0024, 2, 2, 16, u16s(&[10, 20, 1, 65535])),
        ];
        let single = Self::single().without(0x0070);
        single.with(0x000b, u16s(&[9, 9, 9, 9])).with(0x0066, u32s(&[2, 2, 16])).with(0x007d, images.concat())
    }

    /// The file with a block in place of its namesake, or after all others.
    fn with(mut self, tag: u16, content: Vec<u8>) -> Self {
        match self.blocks.iter_mut().find(|(known, _)| *known == tag) {
            Some((_, old)) => *old = content,
            None => self.blocks.push((tag, content)),
        }
        self
    }

    fn without(mut self, tag: u16) -> Self {
        self.blocks.retain(|(known, _)| *known != tag);
        self
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = [b"FRTM_GLIDERV", self.version.as_slice(), &u16s(&[self.blocks.len() as u16])].concat();
        for (tag, content) in &self.blocks {
            bytes.extend(tag.to_le_bytes());
            match self.version {
                b"1.00" => bytes.extend((content.len() as u32).to_le_bytes()),
                _ => bytes.extend((content.len() as u64).to_le_bytes()),
            }
            bytes.extend(content);
        }
        bytes
    }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let buffers = [u32s(&[1, 1]), f64s(&[2.0, 0.0]), u32s(&[1])].concat();
    let wide = Frt { version: b"1.01", ..Frt::several() };
    vec![
        Fixture::whole("FRT of one image", Frt::single().bytes()),
        // The last two blocks may be cut off between them.
        Fixture::open_ended(
            "FRT of several images",
            wide.with(0x00ab, buffers).with(0x009f, b"\x02\x00nm".to_vec()).bytes(),
        ),
    ]
}

fn reading(frt: &Frt) -> asperity_formats::Scan {
    read_bytes(&frt.bytes()).unwrap()
}

fn error(frt: &Frt) -> String {
    read_bytes(&frt.bytes()).unwrap_err().to_string()
}

fn warns(frt: &Frt, start: &str) -> bool {
    reading(frt).warnings.iter().any(|warning| warning.starts_with(start))
}

#[test]
fn numbers_of_16_bits_are_unsigned_1_is_missing_and_the_last_line_is_at_the_top() {
    let scan = reading(&Frt::single().without(0x0070));
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_heights(&scan, &[400e-8, 0.0, 600e-8, 100e-8, NAN, 65000e-8]);
    assert!(scan.channels.is_empty());
}

#[test]
fn a_range_is_the_number_of_points_times_their_distance() {
    assert_eq!(reading(&Frt::single()).pitch_m, Some((3e-3 / 3.0, 4e-3 / 2.0)));
}

#[test]
fn the_magnitude_of_a_negative_range_is_used_and_0_is_no_range() {
    let turned = Frt::single().with(0x0067, f64s(&[-3e-3, 4e-3]));
    assert_eq!(reading(&turned).pitch_m, Some((1e-3, 2e-3)));
    assert!(warns(&turned, "the x range is -0.003 m"));
    let flat = Frt::single().with(0x0067, f64s(&[3e-3, 0.0]));
    assert_eq!(reading(&flat).pitch_m, None);
    assert!(warns(&flat, "the stated pixel size"));
    let silent = Frt::single().without(0x0067);
    assert_eq!(reading(&silent).pitch_m, None);
    assert!(warns(&silent, "block 0x0067 (scan size) is missing"));
}

#[test]
fn numbers_outside_of_the_valid_range_are_missing() {
    // The fifth number is 0.
    assert_heights(&reading(&Frt::single()), &[400e-8, NAN, 600e-8, 100e-8, NAN, 65000e-8]);
    assert!(warns(&Frt::single(), "1 numbers are outside of the valid range that the file states, 2 to 65000"));
    assert!(!warns(&Frt::single().without(0x0070), "1 numbers"));
    // Both ends are valid.
    let whole = Frt::single().with(0x0070, u32s(&[0, 65000]));
    assert_heights(&reading(&whole), &[400e-8, 0.0, 600e-8, 100e-8, NAN, 65000e-8]);
}

#[test]
fn blocks_become_metadata() {
    let scan = reading(&Frt::single());
    let wanted = [
        ("description", "hob ground, µ = 0.1"),
        ("x offset", "0.5"),
        ("y offset", "0.25"),
        ("scan direction", "9"),
        ("x speed", "0.001"),
        ("y speed", "0.002"),
        ("measuring range", "2"),
        ("z scale", "0.00000001"),
        ("sensor type", "4"),
        ("xy table type", "5"),
        ("z table type", "6"),
        ("z offset", "0.125"),
        ("measurement started", "2023-03-10T15:57:20Z"),
        ("measurement time in s", "77"),
        ("parameter set", "fast"),
        ("user name", "Anna"),
        ("user description", "lab"),
        ("serial number", "S-42"),
    ];
    assert_metadata(&scan, &wanted);
    assert!(!scan.metadata.contains_key("measurement ended"));
}

#[test]
fn the_first_topography_is_read_of_several_images_and_others_are_no_channels() {
    let scan = reading(&Frt::several());
    assert_eq!(scan.channels, ["Thickness (bottom sensor) 2, computed", "Topography (top sensor) 1, filtered"]);
    assert_eq!(scan.channel, 1);
    assert_heights(&scan, &[NAN, 65535e-8, 10e-8, 20e-8]);
    assert_eq!(scan.pitch_m, Some((1.5e-3, 2e-3)));
}

#[test]
fn numbers_of_32_bits_are_signed_and_ranges_span_every_image() {
    let scan = read_channel(&Frt::several().bytes(), "1").unwrap();
    let [least, most] = [-2147483648.0 * 1e-8, 2147483647.0 * 1e-8];
    assert_heights(&scan, &[NAN, -1e-8, least, most, -5e-8, 6e-8, 7e-8, 8e-8]);
    assert_eq!(scan.pitch_m, Some((3e-3 / 4.0, 2e-3)));
}

#[test]
fn images_other_than_heights_are_refused() {
    let intensity = [u16s(&[1, 0, 0, 0]), u32s(&[2, 2, 2, 16]), u16s(&[9, 9, 9, 9])].concat();
    let message = error(&Frt::single().with(0x007d, intensity));
    assert_eq!(message, "FRT: the file holds no topography, only other images; wanted an image of heights");
    // Types from 0x4000 on are fits, whatever their lower bits.
    let fit = [u16s(&[1, 0, 0, 0]), u32s(&[0x4004, 2, 2, 16]), u16s(&[9, 9, 9, 9])].concat();
    assert!(error(&Frt::single().with(0x007d, fit)).contains("no topography"));
}

#[test]
fn an_empty_block_of_images_leaves_the_single_one() {
    let scan = reading(&Frt::single().with(0x007d, u16s(&[0, 0, 0, 0])));
    assert_eq!(scan.heights_m.dim(), (2, 3));
}

#[test]
fn sizes_of_blocks_are_64_bits_in_version_1_01() {
    let wide = Frt { version: b"1.01", ..Frt::single() };
    assert_eq!(crate::bits(&reading(&wide)), crate::bits(&reading(&Frt::single())));
    assert!(error(&Frt { version: b"2.00", ..Frt::single() }).contains("version 2.00"));
}

#[test]
fn blocks_may_come_in_any_order() {
    let mut turned = Frt::single();
    turned.blocks.reverse();
    assert_eq!(crate::bits(&reading(&turned)), crate::bits(&reading(&Frt::single())));
}

#[test]
fn scales_of_single_buffers_give_a_warning_because_their_aliases_are_not_known() {
    // Number of buffers; alias, scale, offset, absolute.
    let buffer = |scale: f64, offset: f64| [u32s(&[1, 0x24]), f64s(&[scale, offset]), u32s(&[0])].concat();
    for (scale, offset, gives_warning) in [(1e-8, 0.0, false), (1.0, 0.0, false), (2e-8, 0.0, true), (1e-8, 1e-6, true)]
    {
        assert_eq!(warns(&Frt::single().with(0x00ab, buffer(scale, offset)), "block 0x00ab"), gives_warning);
    }
}

#[test]
fn roundness_and_units_other_than_lengths_give_a_warning() {
    assert!(warns(&Frt::single().with(0x009b, u32s(&[1])), "the file states a measurement of roundness"));
    assert!(warns(&Frt::single().with(0x009f, b"\x01\x00V".to_vec()), "the z unit is `V`"));
    let micron = Frt::single().with(0x009f, b"\x02\x00\xb5m".to_vec());
    assert!(!warns(&micron, "the z unit"));
    assert_eq!(reading(&micron).metadata["z unit"], "µm");
}

#[test]
fn a_count_of_blocks_that_does_not_fit_gives_a_warning() {
    let mut bytes = Frt::single().bytes();
    bytes[16] += 1;
    bytes.extend([0; 5]);
    let scan = read_bytes(&bytes).unwrap();
    assert!(scan.warnings.contains(&"the file states 15 blocks and holds 14".to_owned()), "{:?}", scan.warnings);
    assert!(scan.warnings.contains(&"5 bytes after the last block were left out".to_owned()), "{:?}", scan.warnings);
}

#[test]
fn missing_parts_are_named() {
    for (tag, part) in
        [(0x000b, "block 0x000b"), (0x0066, "block 0x0066 (image size)"), (0x006c, "block 0x006c (sensor)")]
    {
        let message = error(&Frt::single().without(tag));
        assert!(message.contains(part) && message.contains("is missing"), "{message}");
    }
}

#[test]
fn profiles_are_refused() {
    for size in [[6, 1, 16], [1, 6, 16]] {
        assert!(error(&Frt::single().with(0x0066, u32s(&size))).contains("a profile of 6 points"));
    }
}

#[test]
fn headers_that_exceed_the_file_are_errors() {
    let sized = |size: [u32; 3]| read_bytes(&Frt::single().with(0x0066, u32s(&size)).bytes());
    assert!(matches!(sized([u32::MAX, u32::MAX, 16]), Err(FormatError::TooLarge { .. })));
    assert!(matches!(sized([16384, 16384, 32]), Err(FormatError::Truncated { wanted: 1_073_741_824, .. })));
    for (size, field) in [([0, 2, 16], "points along x"), ([3, 0, 16], "points along y"), ([3, 2, 8], "bits per point")]
    {
        assert!(matches!(sized(size), Err(FormatError::Field { field: found, .. }) if found == field));
    }
    for scale in [0.0, NAN, f64::INFINITY] {
        let message = error(&Frt::single().with(0x006c, [u32s(&[2]), f64s(&[scale])].concat()));
        assert!(message.starts_with("FRT: z scale (byte 1"), "{message}");
    }
    let mut twice = Frt::single();
    twice.blocks.push((0x006c, [u32s(&[2]), f64s(&[1.0])].concat()));
    assert!(error(&twice).contains("a block's tag"));
    assert!(warns(&Frt::single().with(0x0066, u32s(&[2, 2, 16])), "block 0x000b is 4 bytes longer"));
}

#[test]
fn a_block_longer_than_the_file_is_refused_with_its_tag() {
    let bytes = Frt::single().bytes();
    let message = read_bytes(&bytes[..bytes.len() - 1]).unwrap_err().to_string();
    assert!(
        message.starts_with("FRT: the bytes of block 0x000b") && message.ends_with("11 bytes; wanted 12"),
        "{message}"
    );
}

#[test]
fn many_small_images_take_no_more_than_their_bytes_justify() {
    let image = [u32s(&[4, 2, 2, 16]), u16s(&[5, 6, 7, 8])].concat();
    // Many empty blocks besides.
    let empty = [u16s(&[9]), u32s(&[0])].concat();
    let bytes = |images: usize| {
        let images = [u16s(&[0; 4]), image.repeat(images)].concat();
        [Frt::single().with(0x007d, images).bytes(), empty.repeat(1 << 17)].concat()
    };
    let many = bytes(1 << 12);
    let start = std::time::Instant::now();
    let (scan, peak) = crate::memory::peak_bytes(|| read_bytes(&many).unwrap());
    assert_eq!(scan.channels.len(), 1 << 12);
    // Each has a name of its own.
    assert_eq!(scan.channels[1], format!("{} 2", scan.channels[0]));
    assert!(peak < (1 << 20) + 2 * many.len(), "{peak} bytes for {}", many.len());
    assert!(start.elapsed() < crate::memory::TIME_LIMIT, "{:?}", start.elapsed());
    let error = read_bytes(&bytes((1 << 12) + 1)).unwrap_err();
    assert!(error.to_string().ends_with("is 4097; the limit is 4096"), "{error}");
}
