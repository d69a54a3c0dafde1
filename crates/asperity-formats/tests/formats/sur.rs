use std::io::Write;

use asperity_formats::{FormatError, Scan, write_sur};
use ndarray::array;

use crate::fixture::{Fixture, read_bytes, read_channel, unsupported, wrong_field};
use crate::fixtures::{Sur, deflated};
use crate::memory::peak_bytes;
use crate::{NAN, assert_heights, assert_metadata};

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

#[test]
fn int16_heights_are_scaled_shifted_and_voids_are_two_below_the_minimum() {
    let scan = read_bytes(&Sur::default().bytes()).unwrap();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    // n · 2 nm + 1000 nm.
    assert_heights(&scan, &[1200e-9, 1400e-9, NAN, 400e-9, 1800e-9, 2000e-9]);
    let (dx_m, dy_m) = scan.pitch_m.unwrap();
    assert!((dx_m / 0.5e-6 - 1.0).abs() < 1e-15 && (dy_m / 0.25e-3 - 1.0).abs() < 1e-15);
}

#[test]
fn a_height_outside_of_the_stated_range_gives_a_warning() {
    let scan = read_bytes(&Sur::default().bytes()).unwrap();
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("1 heights are outside")), "{:?}", scan.warnings);
}

#[test]
fn a_spacing_of_0_is_read_as_a_flat_map() {
    let flat = |numbers: [i16; 6]| {
        let data = numbers.iter().flat_map(|z| z.to_le_bytes()).collect();
        Sur { spacing: [1.0, 1.0, 0.0], special_points: 0, z_range: (0, 7), data, ..Sur::default() }.bytes()
    };
    // The offset of 1000 nm is the height of every point.
    assert_heights(&read_bytes(&flat([7; 6])).unwrap(), &[1e-6; 6]);
    let error = read_bytes(&flat([7, 7, 7, 7, 7, 8])).unwrap_err().to_string();
    assert!(error.starts_with("SUR: z spacing (byte 128) is `0`"), "{error}");
}

#[test]
fn int32_heights_read_up_to_the_ends_of_their_range() {
    let heights = [i32::MIN, i32::MIN + 2, 0, i32::MAX];
    let file = Sur {
        bits: 32,
        size: (2, 2),
        z_range: (i32::MIN + 2, i32::MAX),
        spacing: [1.0, 1.0, 0.5],
        units: [b"m", b"um", b"cm"],
        z_offset: 0.0,
        data: heights.iter().flat_map(|z| z.to_le_bytes()).collect(),
        ..Sur::default()
    };
    let scan = read_bytes(&file.bytes()).unwrap();
    assert_heights(&scan, &[NAN, -2147483646.0 * 0.005, 0.0, 2147483647.0 * 0.005]);
    assert_eq!(scan.pitch_m, Some((1.0, 1e-6)));
}

#[test]
fn without_special_points_the_code_is_a_height() {
    let scan = read_bytes(&Sur { special_points: 0, ..Sur::default() }.bytes()).unwrap();
    assert_heights(&scan, &[1200e-9, 1400e-9, 1196e-9, 400e-9, 1800e-9, 2000e-9]);
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("1 heights equal the code")), "{:?}", scan.warnings);
}

#[test]
fn the_minimum_of_all_integers_leaves_no_code() {
    let file = Sur { z_range: (i32::MIN, i32::MAX), ..Sur::default() };
    assert_eq!(read_bytes(&file.bytes()).unwrap().missing_points(), 0);
}

#[test]
fn units_are_lengths_in_several_spellings() {
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
        let file = Sur { units: [unit, unit, unit], spacing: [1.0, 1.0, 1.0], z_offset: 0.0, ..Sur::default() };
        let scan = read_bytes(&file.bytes()).unwrap();
        assert_eq!(scan.pitch_m, Some((metres, metres)));
        assert_eq!(scan.heights_m[[0, 0]], 100.0 * metres);
    }
}

#[test]
fn heights_without_a_length_unit_are_an_error_and_positions_a_warning() {
    let error = read_bytes(&Sur { units: [b"mm", b"mm", b"V"], ..Sur::default() }.bytes()).unwrap_err();
    assert!(error.to_string().starts_with("SUR: z step unit (byte 212) is `V`; wanted a unit of length"), "{error}");
    let scan = read_bytes(&Sur { units: [b"s", b"mm", b"mm"], ..Sur::default() }.bytes()).unwrap();
    assert_eq!(scan.pitch_m, None);
    assert!(scan.warnings.iter().any(|warning| warning.contains("the x step unit is `s`")), "{:?}", scan.warnings);
}

#[test]
fn a_unit_ratio_that_contradicts_the_units_gives_a_warning() {
    let mut bytes = Sur::default().bytes();
    let gives_warning = |bytes: &[u8]| read_bytes(bytes).unwrap().warnings.iter().any(|w| w.contains("x unit ratio"));
    assert!(!gives_warning(&bytes));
    // Steps in µm, lengths in mm: the ratio is 1000 or its inverse.
    bytes[228..244].copy_from_slice(b"mm              ");
    assert!(gives_warning(&bytes));
    for ratio in [1000_f32, 0.001] {
        bytes[276..280].copy_from_slice(&ratio.to_le_bytes());
        assert!(!gives_warning(&bytes));
    }
}

#[test]
fn the_comment_and_the_header_are_kept() {
    let scan = read_bytes(&Sur::default().bytes()).unwrap();
    let wanted = [
        ("comment", "hob ground, µ = 0.1"),
        ("object name", "gear 7"),
        ("operator name", "A. Operator"),
        ("acquisition type", "1"),
        ("date", "2016-12-01T14:30:59"),
        ("measurement duration", "12.5"),
        ("z step unit", "nm"),
        ("z offset", "1000"),
        ("client zone", "a program"),
    ];
    assert_metadata(&scan, &wanted);
}

#[test]
fn comment_and_private_zone_are_skipped_by_their_sizes() {
    let plain = read_bytes(&Sur { comment: b"", private: b"", ..Sur::default() }.bytes()).unwrap();
    let long: &'static [u8] = &[b'x'; 30_000];
    let skipped = read_bytes(&Sur { comment: long, private: long, ..Sur::default() }.bytes()).unwrap();
    assert_eq!(crate::bits(&plain), crate::bits(&skipped));
}

#[test]
fn compressed_heights_are_the_joined_streams() {
    let plain = read_bytes(&int32(false).bytes()).unwrap();
    assert_heights(&plain, &[1020e-9, 141e-6, NAN, 400e-9]);
    // Whole numbers, a number across two streams, a stream without bytes.
    let cuts: [&[usize]; 5] = [&[], &[4], &[4, 12], &[6, 7], &[0, 5, 5, 16]];
    for cuts in cuts {
        let scan = read_bytes(&int32(false).compressed(cuts).bytes()).unwrap();
        assert_eq!(crate::bits(&scan), crate::bits(&plain), "{cuts:?}");
        assert_eq!(scan.pitch_m, plain.pitch_m);
        assert_eq!(scan.metadata, plain.metadata);
        assert_eq!(scan.warnings, plain.warnings);
    }
}

#[test]
fn deflated_streams_are_read() {
    let heights: Vec<u8> = (0..100_000).flat_map(|n: i32| (n % 997 + 100).to_le_bytes()).collect();
    let file = Sur { bits: 32, size: (400, 250), z_range: (100, 1096), ..Sur::default() };
    let plain = Sur { data: heights.clone(), ..file.clone() }.bytes();
    let mut packed = file.compressed(&[]).bytes();
    // Header, comment and private zone stay; the directory and the streams are another program's.
    packed.truncate(512 + Sur::default().comment.len() + Sur::default().private.len());
    let streams: Vec<Vec<u8>> = heights.chunks(150_001).map(deflated).collect();
    packed.extend((streams.len() as u32).to_le_bytes());
    for (stream, chunk) in streams.iter().zip(heights.chunks(150_001)) {
        packed.extend((chunk.len() as u32).to_le_bytes());
        packed.extend((stream.len() as u32).to_le_bytes());
    }
    packed.extend(streams.concat());
    assert!(packed.len() < plain.len() / 10);
    assert_eq!(crate::bits(&read_bytes(&packed).unwrap()), crate::bits(&read_bytes(&plain).unwrap()));
}

#[test]
fn damaged_streams_and_directories_are_errors() {
    let file = int32(false).compressed(&[]);
    let bytes = file.bytes();
    let directory = 512 + file.comment.len() + file.private.len();
    let damaged = |place: usize, byte: u8| {
        let mut bytes = bytes.clone();
        bytes[place] = byte;
        read_bytes(&bytes).unwrap_err().to_string()
    };
    assert!(damaged(directory, 0).contains("size of all streams"), "{}", damaged(directory, 0));
    assert!(damaged(directory + 2, 1).contains("number of streams"));
    assert!(damaged(directory, 2).contains("the bytes of a stream"));
    for raw in [15, 17] {
        assert!(damaged(directory + 4, raw).contains("wanted 16 bytes for 4 points"));
    }
    assert!(damaged(directory + 8, 255).contains("the bytes of a stream"));
    // In the zlib header, the heights, and the checksum.
    for place in [directory + 12, directory + 20, bytes.len() - 1] {
        let error = damaged(place, bytes[place] ^ 0x10);
        assert!(error.starts_with("SUR: stream 1: "), "{error}");
    }
    // Two streams that hold one byte more and less than they should.
    let mut shifted = int32(false).compressed(&[8]).bytes();
    shifted[directory + 4] = 7;
    shifted[directory + 12] = 9;
    let error = read_bytes(&shifted).unwrap_err().to_string();
    assert_eq!(error, "SUR: stream 1: it unpacks to more than the stated 7 bytes");
    shifted[directory + 4] = 9;
    shifted[directory + 12] = 7;
    let error = read_bytes(&shifted).unwrap_err().to_string();
    assert_eq!(error, "SUR: stream 1: it unpacks to 8 bytes, not to the stated 9");
}

#[test]
fn a_bomb_of_heights_is_refused_before_it_is_unpacked() {
    // 2³⁰ bytes of zeros deflate to 2²⁰.
    let (nx, ny) = (1 << 14, 1 << 14);
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    for _ in 0..1 << 7 {
        encoder.write_all(&[0; 1 << 16]).unwrap();
    }
    let stream = encoder.finish().unwrap();
    let mut bytes = Sur { bits: 32, size: (nx, ny), ..Sur::default() }.compressed(&[]).bytes();
    bytes.truncate(512 + Sur::default().comment.len() + Sur::default().private.len());
    for number in [1, 1 << 30, stream.len() as u32] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(&stream);
    let (error, peak) = peak_bytes(|| read_bytes(&bytes).unwrap_err());
    assert!(error.to_string().contains("more than 256 times as many"), "{error}");
    assert!(peak < 1 << 20, "{peak}");
}

#[test]
fn big_endian_numbers_are_read_where_the_header_makes_sense_so() {
    let (little, big) = (read_bytes(&int32(false).bytes()).unwrap(), read_bytes(&int32(true).bytes()).unwrap());
    assert_eq!(crate::bits(&big), crate::bits(&little));
    assert_eq!((big.pitch_m, &big.metadata, &big.warnings), (little.pitch_m, &little.metadata, &little.warnings));
    let compressed = read_bytes(&int32(true).compressed(&[3]).bytes()).unwrap();
    assert_eq!(crate::bits(&compressed), crate::bits(&little));
    // A writer that claims the other order and does not use it.
    let mut claimed = int32(false).bytes();
    claimed[12..14].copy_from_slice(&[1, 1]);
    assert_eq!(crate::bits(&read_bytes(&claimed).unwrap()), crate::bits(&little));
}

#[test]
fn surfaces_of_a_series_are_channels_by_their_names() {
    let bytes = series();
    let read = |text: &str| read_channel(&bytes, text).unwrap();
    let moved = |offset: f64| [200.0, 400.0, NAN, -600.0, 800.0, 1000.0].map(|z| (z + offset) * 1e-9);
    assert_eq!(read("1").channels, ["surface 1", "worn", "surface 3"]);
    assert_heights(&read("1"), &moved(1000.0));
    assert_heights(&read("worn"), &moved(3000.0));
    assert_heights(&read("surface 3"), &moved(2000.0));
    assert_eq!(read("Worn").channel, 1);
    assert_eq!(read("worn").metadata["object name"], "worn");
    // Only the first object of a series has a comment.
    assert_eq!(read("worn").metadata["comment"], "hob ground, µ = 0.1");
    assert!(read_channel(&bytes, "4").is_err());
    let default = read_bytes(&bytes).unwrap();
    assert_eq!(default.channel, 0);
    assert!(default.warnings.iter().any(|warning| warning.contains("3 height maps")), "{:?}", default.warnings);
    let single = read_bytes(&Sur::default().bytes()).unwrap();
    assert_eq!(single.channels, ["gear 7"]);
    let twins = [Sur::default().bytes(), Sur::default().bytes()].concat();
    assert_eq!(read_bytes(&twins).unwrap().channels, ["gear 7", "gear 7 (2)"]);
}

#[test]
fn objects_other_than_heights_are_not_channels() {
    let layer = |name, unit| Sur { name, object_type: 8, objects: 3, units: [b"mm", b"mm", unit], ..Sur::default() };
    let layers = [layer(b"phase", b"deg"), layer(b"height", b"nm"), layer(b"potential", b"V")];
    let scan = read_bytes(&layers.map(|layer| layer.bytes()).concat()).unwrap();
    assert_eq!((scan.channels.as_slice(), scan.channel), (["height".to_owned()].as_slice(), 0));
    assert_heights(&scan, &[1200e-9, 1400e-9, NAN, 400e-9, 1800e-9, 2000e-9]);
    let coloured = Sur { object_type: 16, ..Sur::default() }.bytes();
    // Some writers call the images that follow surfaces.
    let image = Sur { name: b"red", z_offset: 0.0, ..Sur::default() }.bytes();
    for (images, code) in [(4, 16), (1, 11)] {
        let mut bytes = coloured.clone();
        bytes[18] = code;
        bytes.extend(image.repeat(images));
        assert_eq!(read_bytes(&bytes).unwrap().channels, ["gear 7"]);
    }
    let spectrum = [Sur::default().bytes(), Sur { object_type: 20, ..Sur::default() }.bytes()].concat();
    assert_eq!(read_bytes(&spectrum).unwrap().channels, ["gear 7"]);
}

#[test]
fn surplus_bytes_and_missing_objects_give_a_warning() {
    let warnings_of = |bytes: &[u8]| {
        let scan = read_bytes(bytes).unwrap();
        assert_eq!(scan.channels.len(), 1);
        scan.warnings.join("; ")
    };
    let mut trailing = Sur::default().bytes();
    trailing.extend([0; 7]);
    assert!(warnings_of(&trailing).contains("7 bytes after the last object were left out"));
    assert!(
        warnings_of(&Sur { objects: 3, ..Sur::default() }.bytes()).contains("declares 3 objects; the file holds 1")
    );
    let cut = [Sur::default().bytes(), Sur::default().bytes()].concat();
    let heights = cut.len() - 12;
    let wanted = format!("the heights (byte {heights}) stop after 11 bytes; wanted 12");
    assert!(warnings_of(&cut[..cut.len() - 1]).contains(&wanted));
}

#[test]
fn other_objects_are_refused_with_a_reason() {
    let cases = [
        (Sur { object_type: 1, size: (6, 1), ..Sur::default() }.bytes(), "profile"),
        (Sur { object_type: 12, ..Sur::default() }.bytes(), "colour image"),
        (Sur { object_type: 99, ..Sur::default() }.bytes(), "not published"),
    ];
    for (bytes, reason) in cases {
        let found = unsupported(&bytes);
        assert!(found.contains(reason), "{found}");
    }
}

#[test]
fn a_profile_of_many_lines_is_a_surface_with_a_warning() {
    let scan = read_bytes(&Sur { object_type: 1, ..Sur::default() }.bytes()).unwrap();
    assert!(scan.warnings.iter().any(|warning| warning.contains("the type of the file is a profile")));
}

#[test]
fn headers_that_exceed_the_file_are_errors() {
    let huge = Sur { size: (i32::MAX, i32::MAX), ..Sur::default() }.bytes();
    assert!(matches!(read_bytes(&huge), Err(FormatError::TooLarge { .. })));
    let long = Sur { size: (16384, 16384), ..Sur::default() }.bytes();
    assert!(matches!(read_bytes(&long), Err(FormatError::Truncated { found: 12, wanted: 536_870_912, .. })));
    for (file, field) in [
        (Sur { size: (0, 2), ..Sur::default() }, "points per line"),
        (Sur { size: (3, -2), ..Sur::default() }, "number of lines"),
        (Sur { bits: 8, ..Sur::default() }, "bits per point"),
        (Sur { spacing: [1.0, 1.0, f32::NAN], ..Sur::default() }, "z spacing"),
        (Sur { spacing: [1.0, 1.0, 0.0], ..Sur::default() }, "z spacing"),
        (Sur { z_offset: f32::INFINITY, ..Sur::default() }, "z offset"),
    ] {
        assert_eq!(wrong_field(&file.bytes()), field);
    }
    let mut miscounted = Sur::default().bytes();
    miscounted[116] = 7;
    assert!(matches!(read_bytes(&miscounted), Err(FormatError::Field { wanted, .. }) if wanted == "3 × 2 = 6"));
    let short = &Sur::default().bytes()[..400];
    assert!(matches!(read_bytes(short), Err(FormatError::Truncated { found: 400, wanted: 512, .. })));
}
