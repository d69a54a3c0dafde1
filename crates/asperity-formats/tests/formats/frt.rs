//! FRT: blocks in the order and with the widths of the published layout (tags and sizes as in the table of blocks).

use asperity_formats::{Format, Scan};

use crate::check::{assert_error, assert_pitch, assert_refused, assert_scan, assert_warns, bytes, warns};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::{NAN, assert_heights, assert_metadata, bits};

/// A file of blocks, each a tag and its bytes.
#[derive(Clone)]
struct Frt {
    version: &'static str,
    blocks: Vec<(u16, Vec<u8>)>,
}

/// An image of block 0x007d: type, points along x and y, bits per point; numbers.
fn image(head: [u32; 4], numbers: Vec<u8>) -> Vec<u8> {
    bytes![head, numbers]
}

impl Frt {
    /// 2 lines of 3 numbers of 16 bits, the second of them missing, 3 mm × 4 mm, 10 nm per step.
    fn single() -> Self {
        let blocks = vec![
            (0x0065, b"hob ground, \xb5 = 0.1\0\0".to_vec()),
            (0x0066, bytes![[3_u32, 2, 16]]),
            // x range, y range, x offset, y offset, y range over x range; scan direction.
            (0x0067, bytes![[3e-3_f64, 4e-3, 0.5, 0.25, 4.0 / 3.0], 9_u32]),
            // x speed, y speed; four flags and delays and one more.
            (0x0068, bytes![[1e-3_f64, 2e-3], [0_u32, 1, 0, 20, 30]]),
            // Range of 800 µm, metre per step.
            (0x006c, bytes![2_u32, 1e-8_f64]),
            (0x006e, bytes![[4_u32, 5, 6]]),
            // First and last valid number.
            (0x0070, bytes![[2_u32, 65000]]),
            (0x0071, bytes![0.125_f64]),
            // Start, end, duration.
            (0x0072, bytes![[1_678_463_840_u32, u32::MAX, 77]]),
            (0x0077, b"fast".to_vec()),
            // Name and description of the user, each after its length.
            (0x00ac, bytes![5_u32, "Anna\0", 3_u32, "lab"]),
            // Serial number after its length; day, month, year; created, number of values.
            (0x008e, bytes![4_u32, "S-42", [1_u8, 2], 2020_u16, [0_u32; 2]]),
            // A block of an unknown tag.
            (0x1234, vec![7; 5]),
            (0x000b, bytes![[100_u16, 1, 65000, 400, 0, 600]]),
        ];
        Self { version: "1.00", blocks }
    }

    /// Topography of the top sensor, intensity, and thickness below of other size, after a repetition of the intensity.
    fn several() -> Self {
        let images = [
            // Description of the current buffer: four numbers.
            bytes![[3_u16, 0, 0, 0]],
            image([0x0000_0002, 2, 2, 16], bytes![[9_u16; 4]]),
            // Second buffer of the bottom sensor: computed thickness.
            image([0x1102_0080, 4, 2, 32], bytes![[-5_i32, 6, 7, 8, 1, -1, i32::MIN, i32::MAX]]),
            image([0x0000_0024, 2, 2, 16], bytes![[10_u16, 20, 1, 65535]]),
        ];
        let single = Self::single().without(0x0070).with(0x000b, bytes![[9_u16; 4]]);
        single.with(0x0066, bytes![[2_u32, 2, 16]]).with(0x007d, images.concat())
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
        let block = |(tag, content): &(u16, Vec<u8>)| match self.version {
            "1.00" => bytes![*tag, content.len() as u32, content],
            _ => bytes![*tag, content.len() as u64, content],
        };
        let blocks: Vec<u8> = self.blocks.iter().flat_map(block).collect();
        bytes!["FRTM_GLIDERV", self.version, self.blocks.len() as u16, blocks]
    }

    fn read(&self) -> Scan {
        read_bytes(&self.bytes()).unwrap()
    }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let buffers = bytes![[1_u32, 1], [2.0_f64, 0.0], 1_u32];
    let wide = Frt { version: "1.01", ..Frt::several() }.with(0x00ab, buffers).with(0x009f, b"\x02\x00nm".to_vec());
    // The last two blocks may be cut off between them.
    let several = Fixture::open_ended("FRT of several images", wide.bytes());
    vec![Fixture::whole("FRT of one image", Frt::single().bytes()), several]
}

const ALL_M: [f64; 6] = [400e-8, 0.0, 600e-8, 100e-8, NAN, 65000e-8];

#[test]
fn numbers_of_16_bits_are_unsigned_1_is_missing_and_the_last_line_is_at_the_top() {
    let plain = Frt::single().without(0x0070);
    // A range is the number of points times their distance.
    let scan = assert_scan(&plain.bytes(), Format::Frt, (2, 3), (1e-3, 2e-3), &ALL_M);
    assert!(scan.channels.is_empty() && !warns(&scan, "1 numbers"));
    // The fifth number is 0, outside of the valid range.
    let scan = Frt::single().read();
    assert_heights(&scan, &[400e-8, NAN, 600e-8, 100e-8, NAN, 65000e-8]);
    assert_warns(&scan, "1 numbers are outside of the valid range that the file states, 2 to 65000");
    // Both ends are valid.
    assert_heights(&Frt::single().with(0x0070, bytes![[0_u32, 65000]]).read(), &ALL_M);
    // An empty block of images leaves the single one, and blocks come in any order and with sizes of 64 bits.
    let mut turned = plain.clone();
    turned.blocks.reverse();
    for file in [plain.clone().with(0x007d, vec![0; 8]), turned, Frt { version: "1.01", ..plain }] {
        assert_heights(&file.read(), &ALL_M);
    }
}

#[test]
fn doubts_about_ranges_blocks_units_and_scales_are_reported() {
    let single = Frt::single;
    // Number of buffers; alias, scale, offset, absolute.
    let buffer = |scale: f64, offset: f64| single().with(0x00ab, bytes![[1_u32, 0x24], [scale, offset], 0_u32]);
    let unit = |unit: &[u8]| single().with(0x009f, unit.to_vec());
    for (file, pitch_m, words) in [
        (single().with(0x0067, bytes![[-3e-3_f64, 4e-3]]), Some((1e-3, 2e-3)), "the x range is -3 mm"),
        (single().with(0x0067, bytes![[3e-3_f64, 0.0]]), None, "the stated pixel size"),
        (single().without(0x0067), None, "block 0x0067 (scan size) is missing"),
        (buffer(2e-8, 0.0), Some((1e-3, 2e-3)), "block 0x00ab"),
        (buffer(1e-8, 1e-6), Some((1e-3, 2e-3)), "block 0x00ab"),
        (single().with(0x009b, bytes![1_u32]), Some((1e-3, 2e-3)), "the file states a measurement of roundness"),
        (unit(b"\x01\x00V"), Some((1e-3, 2e-3)), "the z unit is `V`"),
        (single().with(0x0066, bytes![[2_u32, 2, 16]]), Some((1.5e-3, 2e-3)), "block 0x000b is 4 bytes longer"),
    ] {
        let scan = file.read();
        assert_warns(&scan, words);
        assert_pitch(&scan, pitch_m);
    }
    assert!(!warns(&buffer(1e-8, 0.0).read(), "block 0x00ab") && !warns(&buffer(1.0, 0.0).read(), "block 0x00ab"));
    let micron = unit(b"\x02\x00\xb5m").read();
    assert!(!warns(&micron, "the z unit"));
    assert_eq!(micron.metadata["z unit"], "µm");
    let mut bytes = bytes![single().bytes(), [0_u8; 5]];
    bytes[16] += 1;
    let scan = read_bytes(&bytes).unwrap();
    assert_warns(&scan, "the file states 15 blocks and holds 14");
    assert_warns(&scan, "5 bytes after the last block were left out");
}

#[test]
fn blocks_become_metadata() {
    let scan = Frt::single().read();
    assert_metadata(&scan, &[("description", "hob ground, µ = 0.1"), ("x offset", "0.5"), ("y offset", "0.25")]);
    assert_metadata(&scan, &[("scan direction", "9"), ("x speed", "0.001"), ("y speed", "0.002")]);
    assert_metadata(&scan, &[("measuring range", "2"), ("z scale", "0.00000001"), ("sensor type", "4")]);
    assert_metadata(&scan, &[("xy table type", "5"), ("z table type", "6"), ("z offset", "0.125")]);
    assert_metadata(&scan, &[("measurement started", "2023-03-10T15:57:20Z"), ("measurement time in s", "77")]);
    assert_metadata(&scan, &[("parameter set", "fast"), ("user name", "Anna"), ("user description", "lab")]);
    assert_metadata(&scan, &[("serial number", "S-42")]);
    assert!(!scan.metadata.contains_key("measurement ended"));
}

#[test]
fn the_first_topography_is_read_of_several_images_and_others_are_no_channels() {
    let file = Frt::several().bytes();
    let scan = assert_scan(&file, Format::Frt, (2, 2), (1.5e-3, 2e-3), &[NAN, 65535e-8, 10e-8, 20e-8]);
    assert_eq!(scan.channels, ["Thickness (bottom sensor) 2, computed", "Topography (top sensor) 1, filtered"]);
    assert_eq!(scan.channel, 1);
    // Numbers of 32 bits are signed, and ranges span every image.
    let scan = read_channel(&file, "1").unwrap();
    let [least, most] = [-2147483648.0 * 1e-8, 2147483647.0 * 1e-8];
    assert_heights(&scan, &[NAN, -1e-8, least, most, -5e-8, 6e-8, 7e-8, 8e-8]);
    assert_pitch(&scan, (3e-3 / 4.0, 2e-3));
}

#[test]
fn other_data_missing_parts_and_sizes_that_exceed_the_file_are_refused() {
    let single = Frt::single;
    let with_image = |kind: u32| single().with(0x007d, bytes![[1_u16, 0, 0, 0], image([kind, 2, 2, 16], vec![9; 8])]);
    let sized = |size: [u32; 3]| single().with(0x0066, bytes![size]);
    let scaled = |scale: f64| single().with(0x006c, bytes![2_u32, scale]);
    let mut twice = single();
    twice.blocks.push((0x006c, bytes![2_u32, 1_f64]));
    let refused = [
        (with_image(2), "FRT: the file holds no topography, only other images; wanted an image of heights"),
        // Types from 0x4000 on are fits, whatever their lower bits.
        (with_image(0x4004), "no topography"),
        (Frt { version: "2.00", ..single() }, "version 2.00"),
        (single().without(0x000b), "block 0x000b or an image in block 0x007d is missing"),
        (single().without(0x0066), "block 0x0066 (image size) is missing"),
        (single().without(0x006c), "block 0x006c (sensor) is missing"),
        (sized([6, 1, 16]), "a profile of 6 points"),
        (sized([1, 6, 16]), "a profile of 6 points"),
        (sized([u32::MAX, u32::MAX, 16]), "the limit is"),
        (sized([16384, 16384, 32]), "wanted 1073741824"),
        (sized([0, 2, 16]), "points along x ("),
        (sized([3, 0, 16]), "points along y ("),
        (sized([3, 2, 8]), "bits per point ("),
        (scaled(0.0), "FRT: z scale (byte 1"),
        (scaled(NAN), "FRT: z scale (byte 1"),
        (scaled(f64::INFINITY), "FRT: z scale (byte 1"),
        (twice, "a block's tag"),
    ];
    assert_refused(refused.map(|(file, words)| (file.bytes(), words)));
    let bytes = single().bytes();
    assert_error(read_bytes(&bytes[..bytes.len() - 1]), "stop after 11 bytes; wanted 12");
}

#[test]
fn many_small_images_take_no_more_than_their_bytes_justify() {
    let small = image([4, 2, 2, 16], bytes![[5_u16, 6, 7, 8]]);
    // Many empty blocks besides.
    let empty = bytes![9_u16, 0_u32].repeat(1 << 17);
    let bytes =
        |images: usize| bytes![Frt::single().with(0x007d, bytes![[0_u8; 8], small.repeat(images)]).bytes(), empty];
    let many = bytes(1 << 12);
    let start = std::time::Instant::now();
    let (scan, peak) = crate::memory::peak_bytes(|| read_bytes(&many).unwrap());
    assert_eq!(scan.channels.len(), 1 << 12);
    // Each has a name of its own.
    assert_eq!(scan.channels[1], format!("{} 2", scan.channels[0]));
    assert!(peak < (1 << 20) + 2 * many.len(), "{peak} bytes for {}", many.len());
    assert!(start.elapsed() < crate::memory::TIME_LIMIT, "{:?}", start.elapsed());
    assert_error(read_bytes(&bytes((1 << 12) + 1)), "is 4097; the limit is 4096");
    assert_eq!(bits(&scan), bits(&read_channel(&many, "1").unwrap()));
}
