use std::io::Write;

use asperity_formats::{Format, Scan, write_sur};
use ndarray::array;

use crate::check::{assert_error, assert_pitch, assert_refused, assert_scan, assert_warns, bytes, patched, warns};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::fixtures::{Sur, deflated};
use crate::memory::peak_bytes;
use crate::{NAN, assert_heights, assert_metadata, bits};

/// Four heights of 32 bits in the order that is asked for, the last but one missing.
fn int32(big_endian: bool) -> Sur {
    let heights = [10, 70_000, 8, -300];
    Sur {
        big_endian,
        bits: 32,
        size: (2, 2),
        z_range: (10, 70_000),
        data: heights.iter().flat_map(|z: &i32| if big_endian { z.to_be_bytes() } else { z.to_le_bytes() }).collect(),
        ..Sur::default()
    }
}

/// A series of three surfaces, the second compressed and with a name of its own.
fn series() -> Vec<u8> {
    let unnamed = Sur { name: b"", objects: 3, object_type: 5, ..Sur::default() };
    let later = Sur { object_type: 2, objects: 1, comment: b"", z_offset: 2000.0, ..unnamed.clone() };
    let named = Sur { name: b"worn", z_offset: 3000.0, ..later.clone() }.compressed(&[]);
    [unnamed.bytes(), named.bytes(), later.bytes()].concat()
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let scan = Scan::new(array![[1e-6, f64::NAN], [3e-6, -4e-6]], Some((1e-6, 1e-6)));
    let first = Sur { name: b"", objects: 3, object_type: 5, ..Sur::default() }.bytes().len();
    vec![
        Fixture::whole("SUR of int16", Sur::default().bytes()),
        Fixture::whole("SUR of int32, big-endian", int32(true).bytes()),
        Fixture::whole("SUR of int32, compressed in two streams", int32(false).compressed(&[6]).bytes()),
        Fixture { needed: first, ..Fixture::whole("SUR series", series()) },
        Fixture::whole("SUR as written", write_sur(&scan).unwrap()),
    ]
}

const WANTED_M: [f64; 6] = [1200e-9, 1400e-9, NAN, 400e-9, 1800e-9, 2000e-9];

fn read(file: Sur) -> Scan {
    read_bytes(&file.bytes()).unwrap()
}

#[test]
fn int16_heights_are_scaled_shifted_and_voids_are_two_below_the_minimum() {
    // n · 2 nm + 1000 nm.
    let scan = assert_scan(&Sur::default().bytes(), Format::Sur, (2, 3), (0.5e-6, 0.25e-3), &WANTED_M);
    assert_warns(&scan, "1 heights are outside");
    assert_eq!(scan.channels, ["gear 7"]);
    assert_metadata(&scan, &[("comment", "hob ground, µ = 0.1"), ("object name", "gear 7"), ("acquisition type", "1")]);
    assert_metadata(&scan, &[("operator name", "A. Operator"), ("date", "2016-12-01T14:30:59"), ("z offset", "1000")]);
    assert_metadata(&scan, &[("measurement duration", "12.5"), ("z step unit", "nm"), ("client zone", "a program")]);
    // Comment and private zone are skipped by their sizes.
    let long: &'static [u8] = &[b'x'; 30_000];
    assert_heights(&read(Sur { comment: long, private: long, ..Sur::default() }), &WANTED_M);
    // Without special points the code is a height; the minimum of all integers leaves no code.
    let scan = read(Sur { special_points: 0, ..Sur::default() });
    assert_heights(&scan, &[1200e-9, 1400e-9, 1196e-9, 400e-9, 1800e-9, 2000e-9]);
    assert_warns(&scan, "1 heights equal the code");
    assert_eq!(read(Sur { z_range: (i32::MIN, i32::MAX), ..Sur::default() }).missing_points(), 0);
}

#[test]
fn a_spacing_of_0_is_read_as_a_flat_map() {
    let flat = |last: i16| Sur {
        spacing: [1.0, 1.0, 0.0],
        special_points: 0,
        z_range: (0, 7),
        data: bytes![[7_i16; 5], last],
        ..Sur::default()
    };
    // The offset of 1000 nm is the height of every point.
    assert_heights(&read(flat(7)), &[1e-6; 6]);
    assert_error(read_bytes(&flat(8).bytes()), "SUR: z spacing (byte 128) is `0`");
}

#[test]
fn int32_heights_read_up_to_the_ends_of_their_range() {
    let file = Sur {
        bits: 32,
        size: (2, 2),
        z_range: (i32::MIN + 2, i32::MAX),
        spacing: [1.0, 1.0, 0.5],
        units: [b"m", b"um", b"cm"],
        z_offset: 0.0,
        data: bytes![[i32::MIN, i32::MIN + 2, 0, i32::MAX]],
        ..Sur::default()
    };
    let wanted = [NAN, -2147483646.0 * 0.005, 0.0, 2147483647.0 * 0.005];
    assert_scan(&file.bytes(), Format::Sur, (2, 2), (1.0, 1e-6), &wanted);
}

#[test]
fn units_are_lengths_in_several_spellings_or_doubted() {
    let spellings: [(&[u8], f64); 9] = [
        (b"m", 1.0),
        (b"cm", 1e-2),
        (b"mm", 1e-3),
        (b"um", 1e-6),
        (b"\xb5m", 1e-6),
        (b"\xc2\xb5m", 1e-6),
        (b"nm\x00junk", 1e-9),
        (b" nm", 1e-9),
        (b"(mm)", 1e-3),
    ];
    for (unit, metres) in spellings {
        let scan = read(Sur { units: [unit; 3], spacing: [1.0; 3], z_offset: 0.0, ..Sur::default() });
        assert_eq!((scan.pitch_m, scan.heights_m[[0, 0]]), (Some((metres, metres)), 100.0 * metres));
    }
    let error = read_bytes(&Sur { units: [b"mm", b"mm", b"V"], ..Sur::default() }.bytes());
    assert_error(error, "SUR: z step unit (byte 212) is `V`; wanted a unit of length");
    let scan = read(Sur { units: [b"s", b"mm", b"mm"], ..Sur::default() });
    assert_pitch(&scan, None);
    assert_warns(&scan, "the x step unit is `s`");
    // Steps in µm, lengths in mm: the ratio is 1000 or its inverse.
    let other = patched(&Sur::default().bytes(), 228, "mm              ");
    let gives_warning = |bytes: &[u8]| warns(&read_bytes(bytes).unwrap(), "x unit ratio");
    assert!(!gives_warning(&Sur::default().bytes()) && gives_warning(&other));
    assert!([1000_f32, 0.001].iter().all(|&ratio| !gives_warning(&patched(&other, 276, ratio))));
}

#[test]
fn compressed_heights_are_the_joined_streams() {
    let plain = read(int32(false));
    assert_heights(&plain, &[1020e-9, 141e-6, NAN, 400e-9]);
    // Whole numbers, a number across two streams, a stream without bytes.
    let cuts: [&[usize]; 5] = [&[], &[4], &[4, 12], &[6, 7], &[0, 5, 5, 16]];
    for cuts in cuts {
        let scan = read(int32(false).compressed(cuts));
        assert_eq!(bits(&scan), bits(&plain), "{cuts:?}");
        assert_eq!((scan.pitch_m, &scan.metadata, &scan.warnings), (plain.pitch_m, &plain.metadata, &plain.warnings));
    }
    let heights: Vec<u8> = (0..100_000).flat_map(|n: i32| (n % 997 + 100).to_le_bytes()).collect();
    let file = Sur { bits: 32, size: (400, 250), z_range: (100, 1096), ..Sur::default() };
    let plain = Sur { data: heights.clone(), ..file.clone() }.bytes();
    let streams: Vec<(u32, Vec<u8>)> =
        heights.chunks(150_001).map(|chunk| (chunk.len() as u32, deflated(chunk))).collect();
    let packed = of_streams(&file, &streams);
    assert!(packed.len() < plain.len() / 10);
    assert_eq!(bits(&read_bytes(&packed).unwrap()), bits(&read_bytes(&plain).unwrap()));
}

/// An object whose directory and streams, each with its stated size, are another program's.
fn of_streams(file: &Sur, streams: &[(u32, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = file.clone().compressed(&[]).bytes();
    // Header, comment and private zone stay.
    bytes.truncate(512 + file.comment.len() + file.private.len());
    let sizes: Vec<u8> = streams.iter().flat_map(|(raw, stream)| bytes![*raw, stream.len() as u32]).collect();
    let streams_of = streams.iter().flat_map(|(_, stream)| stream.clone()).collect::<Vec<u8>>();
    bytes![bytes, streams.len() as u32, sizes, streams_of]
}

#[test]
fn damaged_streams_and_directories_are_errors() {
    let file = int32(false).compressed(&[]);
    let bytes = file.bytes();
    let directory = 512 + file.comment.len() + file.private.len();
    let damaged = |place: usize, byte: u8| patched(&bytes, place, byte);
    let shifted = int32(false).compressed(&[8]).bytes();
    // Two streams that hold one byte more and less than they should.
    let moved = |first: u8, second: u8| patched(&patched(&shifted, directory + 4, first), directory + 12, second);
    assert_refused([
        (damaged(directory, 0), "size of all streams"),
        (damaged(directory + 2, 1), "number of streams"),
        (damaged(directory, 2), "the bytes of a stream"),
        (damaged(directory + 4, 15), "wanted 16 bytes for 4 points"),
        (damaged(directory + 4, 17), "wanted 16 bytes for 4 points"),
        (damaged(directory + 8, 255), "the bytes of a stream"),
        // In the zlib header, the heights, and the checksum.
        (damaged(directory + 12, bytes[directory + 12] ^ 0x10), "SUR: stream 1: "),
        (damaged(directory + 20, bytes[directory + 20] ^ 0x10), "SUR: stream 1: "),
        (damaged(bytes.len() - 1, bytes[bytes.len() - 1] ^ 0x10), "SUR: stream 1: "),
        (moved(7, 9), "SUR: stream 1: it unpacks to more than the stated 7 bytes"),
        (moved(9, 7), "SUR: stream 1: it unpacks to 8 bytes, not to the stated 9"),
    ]);
}

#[test]
fn a_bomb_of_heights_is_refused_before_it_is_unpacked() {
    // 2³⁰ bytes of zeros deflate to 2²⁰.
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    for _ in 0..1 << 7 {
        encoder.write_all(&[0; 1 << 16]).unwrap();
    }
    let file = Sur { bits: 32, size: (1 << 14, 1 << 14), ..Sur::default() };
    let bytes = of_streams(&file, &[(1 << 30, encoder.finish().unwrap())]);
    let (result, peak) = peak_bytes(|| read_bytes(&bytes));
    assert_error(result, "more than 256 times as many");
    assert!(peak < 1 << 20, "{peak}");
}

#[test]
fn big_endian_numbers_are_read_where_the_header_makes_sense_so() {
    let (little, big) = (read(int32(false)), read(int32(true)));
    assert_eq!((big.pitch_m, &big.metadata, &big.warnings), (little.pitch_m, &little.metadata, &little.warnings));
    // A writer that claims the other order and does not use it.
    let claimed = read_bytes(&patched(&int32(false).bytes(), 12, [1_u8, 1])).unwrap();
    for scan in [big, read(int32(true).compressed(&[3])), claimed] {
        assert_eq!(bits(&scan), bits(&little));
    }
}

#[test]
fn surfaces_of_a_series_are_channels_by_their_names() {
    let bytes = series();
    let moved = |offset: f64| [200.0, 400.0, NAN, -600.0, 800.0, 1000.0].map(|z| (z + offset) * 1e-9);
    for (channel, place, offset) in
        [("1", 0, 1000.0), ("worn", 1, 3000.0), ("Worn", 1, 3000.0), ("surface 3", 2, 2000.0)]
    {
        let scan = read_channel(&bytes, channel).unwrap();
        assert_eq!((scan.channels.join(", ").as_str(), scan.channel), ("surface 1, worn, surface 3", place));
        assert_heights(&scan, &moved(offset));
        // Only the first object of a series has a comment.
        assert_metadata(&scan, &[("comment", "hob ground, µ = 0.1")]);
    }
    assert_eq!(read_channel(&bytes, "worn").unwrap().metadata["object name"], "worn");
    assert_error(read_channel(&bytes, "4"), "no height map");
    let default = read_bytes(&bytes).unwrap();
    assert_eq!(default.channel, 0);
    assert_warns(&default, "3 height maps");
    let twins = Sur::default().bytes().repeat(2);
    assert_eq!(read_bytes(&twins).unwrap().channels, ["gear 7", "gear 7 (2)"]);
}

#[test]
fn objects_other_than_heights_are_not_channels() {
    let layer = |name, unit| Sur { name, object_type: 8, objects: 3, units: [b"mm", b"mm", unit], ..Sur::default() };
    let layers = [layer(b"phase", b"deg"), layer(b"height", b"nm"), layer(b"potential", b"V")];
    let scan = read_bytes(&layers.map(|layer| layer.bytes()).concat()).unwrap();
    assert_eq!((scan.channels.as_slice(), scan.channel), (["height".to_owned()].as_slice(), 0));
    assert_heights(&scan, &WANTED_M);
    // Some writers call the images that follow surfaces.
    let image = Sur { name: b"red", z_offset: 0.0, ..Sur::default() }.bytes();
    let of_type = |object_type| Sur { object_type, ..Sur::default() }.bytes();
    let spectrum = [of_type(2), of_type(20)].concat();
    for bytes in [bytes![of_type(16), image.repeat(4)], bytes![of_type(11), image], spectrum] {
        assert_eq!(read_bytes(&bytes).unwrap().channels, ["gear 7"]);
    }
}

#[test]
fn surplus_bytes_missing_objects_and_profiles_of_many_lines_give_a_warning() {
    let cut = Sur::default().bytes().repeat(2);
    let lost = format!("the heights (byte {}) stop after 11 bytes; wanted 12", cut.len() - 12);
    for (bytes, words) in [
        (bytes![Sur::default().bytes(), [0_u8; 7]], "7 bytes after the last object were left out"),
        (Sur { objects: 3, ..Sur::default() }.bytes(), "declares 3 objects; the file holds 1"),
        (cut[..cut.len() - 1].to_vec(), &lost),
        (Sur { object_type: 1, ..Sur::default() }.bytes(), "the type of the file is a profile"),
    ] {
        let scan = read_bytes(&bytes).unwrap();
        assert_eq!(scan.channels.len(), 1);
        assert_warns(&scan, words);
    }
}

#[test]
fn a_profile_of_one_line_is_a_single_row() {
    let map = read_bytes(&Sur::default().bytes()).unwrap();
    let profile = read_bytes(&Sur { object_type: 1, size: (6, 1), ..Sur::default() }.bytes()).unwrap();
    assert!(profile.is_profile());
    assert!(profile.warnings.iter().all(|warning| map.warnings.contains(warning)), "{:?}", profile.warnings);
    let bits = |scan: &Scan| scan.heights_m.iter().map(|z| z.to_bits()).collect::<Vec<u64>>();
    assert_eq!(bits(&profile), bits(&map));
    // Beside a surface it is no height map.
    let both = [Sur::default().bytes(), Sur { object_type: 1, size: (6, 1), ..Sur::default() }.bytes()].concat();
    assert_eq!(bits(&read_bytes(&both).unwrap()), bits(&map));
}

#[test]
fn other_objects_and_headers_that_exceed_the_file_are_refused() {
    let usual = Sur::default;
    let files = [
        (Sur { object_type: 12, ..usual() }, "colour image"),
        (Sur { object_type: 99, ..usual() }, "not published"),
        (Sur { size: (i32::MAX, i32::MAX), ..usual() }, "the limit is"),
        (Sur { size: (16384, 16384), ..usual() }, "stop after 12 bytes; wanted 536870912"),
        (Sur { size: (0, 2), ..usual() }, "points per line ("),
        (Sur { size: (3, -2), ..usual() }, "number of lines ("),
        (Sur { bits: 8, ..usual() }, "bits per point ("),
        (Sur { spacing: [1.0, 1.0, f32::NAN], ..usual() }, "z spacing ("),
        (Sur { z_offset: f32::INFINITY, ..usual() }, "z offset ("),
    ];
    assert_refused(files.map(|(file, words)| (file.bytes(), words)));
    let short = usual().bytes()[..400].to_vec();
    assert_refused([(patched(&usual().bytes(), 116, 7_u8), "3 × 2 = 6"), (short, "stop after 400 bytes; wanted 512")]);
}
