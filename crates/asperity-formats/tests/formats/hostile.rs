//! No input makes a reader panic, hang or take much memory. The result may be a scan or an error.
//!
//! `ASPERITY_MUTATIONS` sets the number of damaged copies of each fixture (default 100), `ASPERITY_MUTATE` limits
//! them to fixtures whose name contains it.

use std::io::{Cursor, Write};
use std::time::{Duration, Instant};

use asperity_formats::read_bytes;

use crate::fixture::{Content, Fixture, all};
use crate::fixtures::X3p;
use crate::memory::{TIME_LIMIT, peak_bytes};

/// Prefixes of each fixture.
const PREFIXES: usize = 400;
/// Bytes at the end of an archive of which a bit is flipped.
const FLIPPED_BYTES: usize = 1024;
/// The most memory that an input may take beyond twice its size.
const MEMORY_LIMIT: usize = 64 << 20;

/// Words of the messages of libraries, which errors must not repeat.
const FOREIGN_WORDS: [&str; 11] = [
    "EOCD",
    "invalid Zip",
    "deflate stream",
    "gzip header",
    "gzip stream",
    "Invalid checksum",
    "whole buffer",
    "ill-formed",
    "syntax error",
    "incompatible shapes",
    "invalid code",
];

/// Reads a file, and checks the invariants of the scan and the limits of the crate.
fn read(name: &str, bytes: &[u8]) -> bool {
    let start = Instant::now();
    let (scan, peak) = peak_bytes(|| read_bytes(bytes));
    let took = start.elapsed();
    assert!(took < TIME_LIMIT, "{name}: {took:?} for {} bytes", bytes.len());
    assert!(peak <= MEMORY_LIMIT + 2 * bytes.len(), "{name}: {peak} bytes of memory for {} of input", bytes.len());
    let scan = match scan {
        Ok(scan) => scan,
        Err(error) => {
            let message = error.to_string();
            assert!(!FOREIGN_WORDS.iter().any(|words| message.contains(words)), "{name}: {message}");
            return false;
        }
    };
    assert!(scan.heights_m.iter().all(|z| !z.is_infinite()));
    assert!(!scan.heights_m.is_empty());
    assert!(scan.pitch_m.is_none_or(|(dx, dy)| dx > 0.0 && dy > 0.0 && dx.is_finite() && dy.is_finite()));
    assert!(scan.channels.is_empty() || scan.channel < scan.channels.len());
    true
}

#[test]
fn prefixes_are_read_or_refused() {
    for fixture in all() {
        let bytes = fixture.bytes();
        assert!(read(fixture.name, &bytes), "{}: {:?}", fixture.name, read_bytes(&bytes).map(|_| ()));
        let ends = (0..bytes.len()).step_by(bytes.len().div_ceil(PREFIXES)).chain(fixture.needed.checked_sub(1));
        for end in ends {
            let is_read = read(fixture.name, &bytes[..end]);
            assert!(!is_read || end >= fixture.needed, "{}: a prefix of {end} bytes was read", fixture.name);
        }
    }
}

#[test]
fn flipped_bits_in_an_archive_directory_are_read_or_refused() {
    for fixture in all().iter().filter(|fixture| matches!(fixture.content, Content::Zip(_))) {
        let mut bytes = fixture.bytes();
        for position in bytes.len().saturating_sub(FLIPPED_BYTES)..bytes.len() {
            let bit = 1 << (position % 8);
            bytes[position] ^= bit;
            read(fixture.name, &bytes);
            bytes[position] ^= bit;
        }
    }
}

/// A gzip member and a zip archive of one file, both of `count` zeros.
fn bombs(name: &str, count: usize) -> [Vec<u8>; 2] {
    let zeros = vec![0; 1 << 20];
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
    for _ in 0..count >> 20 {
        gzip.write_all(&zeros).unwrap();
        zip.write_all(&zeros).unwrap();
    }
    [gzip.finish().unwrap(), zip.finish().unwrap().into_inner()]
}

#[test]
fn bombs_are_refused() {
    for name in ["main.xml", "index.xml", "heights.npy"] {
        for bytes in bombs(name, 256 << 20) {
            assert!(!read(name, &bytes), "{name}");
        }
    }
}

#[test]
fn a_bomb_of_heights_is_refused() {
    // 16384² heights of eight bytes, the most that a map may have, in a file of one five-hundredth.
    let [_, zeros] = bombs("bindata/data.bin", 64 << 20);
    let mut archive = zip::ZipWriter::new_append(Cursor::new(zeros)).unwrap();
    let x3p = X3p { size: (1 << 14, 1 << 14, 1), ..X3p::default() };
    archive.start_file("main.xml", zip::write::SimpleFileOptions::default()).unwrap();
    archive.write_all(x3p.main_xml().as_bytes()).unwrap();
    let bytes = archive.finish().unwrap().into_inner();
    assert!(!read("a bomb of heights", &bytes));
}

/// A multiplicative congruential generator (MMIX): noise enough to damage files with.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize
    }

    fn below(&mut self, bound: usize) -> usize {
        self.next() % bound.max(1)
    }
}

/// Values that sizes, offsets and counts break on.
const EXTREMES: [u64; 12] = [
    0,
    1,
    2,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    u64::MAX,
    0x7ff0_0000_0000_0000,
];
/// Texts that fields of numbers break on.
const WORDS: [&[u8]; 10] =
    [b"0", b"-1", b"99999999999", b"1e999", b"nan", b"inf", b"", b"\n", b" 18446744073709551615 ", b"1e-400"];

/// Damages bytes in one of several accidental or malicious ways.
fn damage(bytes: &mut Vec<u8>, noise: &mut Noise) {
    let place = noise.below(bytes.len() + 1);
    match noise.below(9) {
        0 => at(bytes, place, |_| noise.next() as u8),
        1 => at(bytes, place, |byte| byte ^ 1 << noise.below(8)),
        // A number of 1, 2, 4 or 8 bytes, in either order.
        2 | 3 => {
            let width = 1 << noise.below(4);
            let mut raw = EXTREMES[noise.below(EXTREMES.len())].to_le_bytes()[..width].to_vec();
            if noise.below(2) == 0 {
                raw.reverse();
            }
            bytes[place..].iter_mut().zip(raw).for_each(|(byte, new)| *byte = new);
        }
        4 => bytes.truncate(place),
        5 => {
            let end = (place + noise.below(16)).min(bytes.len());
            bytes.drain(place..end);
        }
        // A piece of the file once more.
        6 => {
            let from = noise.below(bytes.len() + 1);
            let piece = bytes[from..].iter().copied().take(noise.below(64)).collect::<Vec<_>>();
            bytes.splice(place..place, piece);
        }
        // The digits of a number replaced by a word.
        7 => {
            let is_digit = |byte: &u8| byte.is_ascii_digit();
            let start = place + bytes[place..].iter().position(is_digit).unwrap_or(bytes.len() - place);
            let length = bytes[start..].iter().take_while(|byte| is_digit(byte)).count();
            bytes.splice(start..start + length, WORDS[noise.below(WORDS.len())].iter().copied());
        }
        _ => at(bytes, place, |byte| byte.wrapping_add(1)),
    }
}

/// Changes the byte at a place, if there is one.
fn at(bytes: &mut [u8], place: usize, change: impl FnOnce(u8) -> u8) {
    if let Some(byte) = bytes.get_mut(place) {
        *byte = change(*byte);
    }
}

/// Returns a damaged copy of the file, or of the bytes that its checksums cover.
fn damaged(fixture: &Fixture, noise: &mut Noise) -> Vec<u8> {
    let mut content = fixture.content.clone();
    let times = 1 + noise.below(4);
    if noise.below(4) == 0 {
        content = Content::Bytes(content.bytes());
    }
    for _ in 0..times {
        match &mut content {
            Content::Bytes(bytes) | Content::Gzip(bytes) => damage(bytes, noise),
            Content::Zip(files) => {
                let file = noise.below(files.len());
                damage(&mut files[file].1, noise);
            }
        }
    }
    content.bytes()
}

#[test]
fn damaged_files_are_read_or_refused() {
    let count = std::env::var("ASPERITY_MUTATIONS").map_or(100, |count| count.parse::<u64>().unwrap());
    let only = std::env::var("ASPERITY_MUTATE").unwrap_or_default();
    for (place, fixture) in all().iter().enumerate().filter(|(_, fixture)| fixture.name.contains(&only)) {
        for repeat in 0..count {
            // Every input is a function of the fixture and the repeat, so that a failure can be looked at alone.
            let mut noise = Noise((place as u64) << 40 ^ repeat.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let bytes = damaged(fixture, &mut noise);
            if std::panic::catch_unwind(|| read(fixture.name, &bytes)).is_err() {
                let shown: Vec<u8> = bytes.iter().copied().take(4096).collect();
                panic!("{}, repeat {repeat}: `{}`", fixture.name, shown.escape_ascii());
            }
        }
    }
}

/// Returns a number of bytes.
type Filling<'a> = Box<dyn Fn(usize) -> Vec<u8> + 'a>;

/// A file of which `filling` takes ten megabytes: at its end, or at its middle.
fn filled(content: &Content, filling: &Filling, at_end: bool) -> Vec<u8> {
    const BYTES: usize = 10_000_000;
    let fill = |bytes: &[u8]| {
        let (start, end) = bytes.split_at(if at_end { bytes.len() } else { bytes.len() / 2 });
        [start, &filling(BYTES - bytes.len()), end].concat()
    };
    match content {
        Content::Bytes(bytes) => fill(bytes),
        Content::Gzip(bytes) => Content::Gzip(fill(bytes)).bytes(),
        Content::Zip(files) => {
            let largest = files.iter().map(|(_, bytes)| bytes.len()).max();
            let more = |(name, bytes): &(String, Vec<u8>)| {
                (name.clone(), if Some(bytes.len()) == largest { fill(bytes) } else { bytes.clone() })
            };
            Content::Zip(files.iter().map(more).collect()).bytes()
        }
    }
}

#[test]
#[ignore = "slow"]
fn files_of_ten_megabytes_are_read_or_refused_within_two_seconds() {
    let repeated = |word: &[u8], count: usize| word.iter().copied().cycle().take(count).collect::<Vec<u8>>();
    let mut longest = (Duration::ZERO, String::new());
    for fixture in all() {
        let bytes = fixture.bytes();
        let noise = |count: usize| {
            let mut noise = Noise(7);
            (0..count).map(|_| noise.next() as u8).collect::<Vec<u8>>()
        };
        let fillings: [(&str, Filling<'_>); 8] = [
            ("zeros", Box::new(|count| vec![0; count])),
            ("ones", Box::new(|count| vec![0xff; count])),
            ("noise", Box::new(noise)),
            ("numbers", Box::new(|count| repeated(b"1.5 -2e-6 3\r\n", count))),
            ("one line", Box::new(|count| repeated(b"7,", count))),
            ("elements", Box::new(|count| repeated(b"<a b=\"c\">d</a>", count))),
            ("itself", Box::new(|count| repeated(&bytes, count))),
            ("its end", Box::new(|count| repeated(&bytes[bytes.len() - bytes.len().min(64)..], count))),
        ];
        for (name, filling) in &fillings {
            for at_end in [true, false] {
                let name = format!("{} with {name} at its {}", fixture.name, if at_end { "end" } else { "middle" });
                let bytes = filled(&fixture.content, filling, at_end);
                let start = Instant::now();
                read(&name, &bytes);
                longest = longest.max((start.elapsed(), name));
            }
        }
    }
    println!("longest: {:?}, {}", longest.0, longest.1);
}
