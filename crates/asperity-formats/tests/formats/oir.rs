//! OIR files after the chunks and the XML that SurfaceTopography describes.

use asperity_formats::{Format, Scan};

use crate::assert_heights;
use crate::check::{assert_refused, assert_scan, bytes};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::fixtures::zip;

fn chunk(kind: i32, content: &[u8]) -> Vec<u8> {
    bytes![content.len() as i32, kind, content]
}

/// A text after its length.
fn text(text: &str) -> Vec<u8> {
    bytes![text.len() as u32, text]
}

/// A description: its kind, eight numbers, and its content.
fn description(kind: u32, content: &[u8]) -> Vec<u8> {
    bytes![kind, [1_u32, 1, 0, 0, 1, 1, 1, 1], content]
}

/// A list of one text and a number.
fn list(entry: &str) -> Vec<u8> {
    bytes![1_u32, text(entry), [0_u8; 4]]
}

fn block(name: &str, data: &[u8]) -> Vec<u8> {
    let size = data.len() as u32;
    bytes![chunk(3, &bytes![[0_u8; 4], size, text(name)]), size, 4_u32, data]
}

fn channel(id: &str, kind: &str, more: &str) -> String {
    format!(
        "<commonphase:channel id=\"{id}\" order=\"1\"><commonphase:imageDefinition>{more}<commonphase:imageType>{kind}\
         </commonphase:imageType></commonphase:imageDefinition><commonphase:length><commonparam:x>0.5</commonparam:x>\
         <commonparam:y>0.25</commonparam:y><commonparam:z>2.0</commonparam:z></commonphase:length>\
         <commonphase:pixelUnit><commonphase:x>UNIT</commonphase:x><commonphase:y>UNIT</commonphase:y>\
         <commonphase:z>nm</commonphase:z></commonphase:pixelUnit></commonphase:channel>"
    )
}

const DEPTH: &str = "<commonphase:depth>2</commonphase:depth><commonphase:bitCounts>14</commonphase:bitCounts>";

/// The XML of channels of 3 × 2 points.
fn xml(channels: &[String], unit: &str) -> String {
    let channels = channels.concat().replace("UNIT", unit);
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\r\n<lsmimage:imageProperties xmlns:lsmimage=\"a\"><commonimage:general>\
         <base:creationDateTime>2020-01-01T00:00:00</base:creationDateTime></commonimage:general><commonimage:microscope>\
         <base:name>OLS5000</base:name></commonimage:microscope><commonimage:imageInfo><commonimage:width>3</commonimage:width>\
         <commonimage:height>2</commonimage:height><commonimage:phase><commonphase:group>{channels}</commonphase:group>\
         </commonimage:phase></commonimage:imageInfo><commonimage:acquisition><commonimage:microscopeConfiguration>\
         <commonimage:pixelCalibration><commonparam:x>2.0</commonparam:x><commonparam:z>0.5</commonparam:z>\
         </commonimage:pixelCalibration></commonimage:microscopeConfiguration></commonimage:acquisition></lsmimage:imageProperties>"
    )
}

fn oir(xml: &str, blocks: &[Vec<u8>]) -> Vec<u8> {
    let header = [12_u32, 0, 1, 2, 0, 0, 0, 0, 17, 0, 1, 0, 0, 0];
    let descriptions = bytes![
        description(1, &text("<version/>")),
        description(2, &text(xml)),
        description(6, &list("t001_0_1")),
        description(8, &list("id-of-heights")),
    ];
    bytes![
        "OLYMPUSRAWFORMAT",
        header,
        "UNKNOWN\0",
        [1, 1, u32::MAX, u32::MAX],
        chunk(5, b""),
        chunk(0, &descriptions),
        blocks,
        -1_i32,
        [0_u8; 12],
    ]
}

const NUMBERS: [u16; 6] = [1, 2, 3, 4, 5, 60000];

fn numbers(bytes: usize) -> Vec<u8> {
    NUMBERS.iter().flat_map(|n| n.to_le_bytes()[..bytes].to_vec()).collect()
}

/// A file with heights after intensities.
fn usual() -> Vec<u8> {
    let channels = [channel("id-of-colours", "INTENSITY", DEPTH), channel("id-of-heights", "HEIGHT", DEPTH)];
    let blocks = [
        block("t001_0_1_id-of-colours_0", &[9; 18]),
        block("REF_CAMERA0", &[9; 5]),
        block("t001_0_1_id-of-heights_0", &numbers(2)),
    ];
    oir(&xml(&channels, "um"), &blocks)
}

fn poir() -> Vec<u8> {
    let camera = oir("<cameraimage:imageProperties/>", &[]);
    zip(&[("info.xml", b"<a/>"), ("camera.oir", &camera), ("Sample/Image0001.oir", &usual())])
}

/// A file with channels of one byte, of two bytes without a stated size, and without a pixel size.
fn sizes_of_points() -> Vec<u8> {
    let channels = [
        channel("a", "HEIGHT", "<commonphase:depth>1</commonphase:depth>"),
        channel("b", "HEIGHT", "<commonphase:bitCounts>14</commonphase:bitCounts>"),
        channel("c", "HEIGHT", DEPTH).replace("UNIT", "s"),
    ];
    let blocks = [
        block("p_c_0", &numbers(2)),
        block("p_a_1", &[0; 6]),
        block("p_a_0", &numbers(1)),
        block("p_b_0", &numbers(2)[..6]),
        block("p_b_1", &numbers(2)[6..]),
    ];
    oir(&xml(&channels, "um"), &blocks)
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::open_ended("OIR", usual()),
        Fixture::open_ended("OIR with points of several sizes", sizes_of_points()),
        Fixture::open_ended("POIR", poir()),
        Fixture::open_ended("POIR of two files", zip(&[("a.oir", &usual()), ("b.oir", &sizes_of_points())])),
    ]
}

fn assert_usual(bytes: &[u8]) -> Scan {
    assert_scan(bytes, Format::Oir, (2, 3), (1e-6, 0.25e-6), &NUMBERS.map(|n| f64::from(n) * 1e-9))
}

#[test]
fn heights_are_calibrated_and_found_by_the_identifier_of_their_channel() {
    assert_usual(&usual());
    let with = |depth: &str, data: &[u8]| {
        oir(&xml(&[channel("a", "HEIGHT", depth)], "um"), &[block("p_a_1", &[0; 12]), block("p_a_0", data)])
    };
    let scan = read_bytes(&with("<commonphase:bitCounts>14</commonphase:bitCounts>", &numbers(2))).unwrap();
    assert_heights(&scan, &NUMBERS.map(|n| f64::from(n) * 1e-9));
    let scan = read_bytes(&with("<commonphase:depth>1</commonphase:depth>", &numbers(1))).unwrap();
    assert_heights(&scan, &NUMBERS.map(|n| f64::from(n as u8) * 1e-9));
}

#[test]
fn packed_files_are_channels_by_their_names() {
    assert_eq!(assert_usual(&poir()).channels, ["Sample/Image0001.oir"]);
    let other = oir(
        &xml(&[channel("b", "HEIGHT", DEPTH), channel("c", "HEIGHT", DEPTH)], "um"),
        &[block("p_b_0", &[0; 12]), block("p_c_0", &numbers(2))],
    );
    let bytes = zip(&[("a.oir", &usual()), ("b.oir", &other)]);
    assert_eq!(read_bytes(&bytes).unwrap().channels, ["a.oir", "b.oir", "b.oir 2"]);
    assert_heights(&read_channel(&bytes, "3").unwrap(), &NUMBERS.map(|n| f64::from(n) * 1e-9));
}

#[test]
fn files_without_heights_and_blocks_that_do_not_fit_are_refused() {
    let heights = xml(&[channel("a", "HEIGHT", DEPTH)], "um");
    let intensities = xml(&[channel("a", "INTENSITY", DEPTH)], "um");
    let of_floats = xml(&[channel("a", "HEIGHT", "<commonphase:depth>4</commonphase:depth>")], "um");
    let of_volt = heights.replace("<commonphase:z>nm", "<commonphase:z>V");
    let good = block("p_a_0", &numbers(2));
    let with = |xml: &str, block: &[u8]| oir(xml, &[block.to_vec()]);
    assert_refused([
        (with(&intensities, &good), "no heights"),
        (zip(&[("a.oir", &oir("<camera/>", &[]))]), "no heights"),
        (with(&heights, &block("p_b_0", &numbers(2))), "is missing"),
        (with(&heights, &block("p_a_0", &numbers(1))), "stop after"),
        (with(&of_floats, &good), "wanted 1 or 2"),
        (with(&of_volt, &good), "pixelUnit/z"),
    ]);
    let scan = read_bytes(&oir(&xml(&[channel("a", "HEIGHT", DEPTH)], "s"), &[good])).unwrap();
    assert!(scan.pitch_m.is_none() && scan.warnings[0].contains("no pixel size"), "{:?}", scan.warnings);
}
