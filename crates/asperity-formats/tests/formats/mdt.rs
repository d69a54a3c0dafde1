use asperity_formats::Format;

use crate::assert_heights;
use crate::check::{assert_refused, bytes, padded, patched};
use crate::fixture::{Fixture, read_bytes};

/// A frame of a scan of 3 × 2 points: its channel, the code of its unit, the step and the number of points of spectra.
fn frame(channel: u8, unit: i16, step: f32, points: u16) -> Vec<u8> {
    // Offset, step and unit of three axes; channel, mode, points along two axes.
    let axes = bytes![0.0_f32, 1.0_f32, -2_i16, 0.0_f32, -2.0_f32, -2_i16, 10.0_f32, step, unit];
    let variables = padded(bytes![axes, [channel, 0, 3, 0, 2, 0]], 77);
    let spectra = vec![0_u8; if points > 0 { 14 + 16 * usize::from(points) } else { 0 }];
    of_type(0, &bytes![variables, [0, 3, 2, points], spectra, [0_i16, 1, 2, 3, 4, -5]])
}

fn of_type(kind: u16, body: &[u8]) -> Vec<u8> {
    bytes![22 + body.len() as u32, [kind, 0x0200, 2026, 11, 24, 1, 2, 3, 77], body]
}

fn mdt(frames: &[Vec<u8>]) -> Vec<u8> {
    let last = frames.len() as u16 - 1;
    bytes![padded(bytes![padded(b"\x01\xb0\x93\xff", 12), last], 33), frames]
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::whole("MDT", mdt(&[frame(4, 1, 1.0, 0), frame(0, -1, 0.5, 0)]))]
}

#[test]
fn heights_are_offset_and_steps_in_the_unit_of_z_from_the_bottom_up() {
    for points in [0, 3] {
        let scan = read_bytes(&mdt(&[frame(4, 1, 1.0, 0), of_type(106, &[0; 9]), frame(0, -1, 0.5, points)])).unwrap();
        assert_eq!((scan.format, scan.pitch_m), (Some(Format::Mdt), Some((1e-6, 2e-6))));
        assert_heights(&scan, &[11.5e-9, 12e-9, 7.5e-9, 10e-9, 10.5e-9, 11e-9]);
        assert_eq!(
            (scan.channels.as_slice(), scan.height_unit.as_deref()),
            (["Height".to_owned()].as_slice(), Some("nm"))
        );
        assert_eq!(scan.metadata["date"], "2026-11-24T01:02:03");
        let warnings = scan.warnings.concat();
        assert!(
            warnings.contains("1 frames other than scans") && warnings.contains("`Current` (code 1)"),
            "{warnings}"
        );
    }
}

#[test]
fn files_without_a_scan_of_heights_and_damaged_frames_are_refused() {
    let height = frame(0, -1, 1.0, 0);
    assert_refused([
        (mdt(&[of_type(106, &[0; 9])]), "none of the 1 frames"),
        (mdt(&[frame(4, 1, 1.0, 0)]), "`Current` (code 1)"),
        (mdt(&[patched(&height, 20, 35_u8)]), "size of the variables ("),
        (mdt(&[patched(&height, 0, 0_u8)]), "size of a frame ("),
    ]);
}
