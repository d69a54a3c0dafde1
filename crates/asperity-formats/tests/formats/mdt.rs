use asperity_formats::{Format, FormatError};

use crate::assert_heights;
use crate::fixture::{Fixture, read_bytes};

/// A frame of a scan of 3 × 2 points: its channel, the code of its unit, the step and the number of points of spectra.
fn frame(channel: u8, unit: i16, step: f32, points: u16) -> Vec<u8> {
    let mut variables = Vec::new();
    for (offset, step, unit) in [(0.0_f32, 1.0_f32, -2_i16), (0.0, -2.0, -2), (10.0, step, unit)] {
        variables.extend(offset.to_le_bytes());
        variables.extend(step.to_le_bytes());
        variables.extend(unit.to_le_bytes());
    }
    variables.extend([channel, 0, 3, 0, 2, 0]);
    variables.resize(77, 0);
    let mut body = variables;
    for number in [0, 3, 2, points] {
        body.extend(number.to_le_bytes());
    }
    body.resize(body.len() + if points > 0 { 14 + 16 * usize::from(points) } else { 0 }, 0);
    body.extend([0_i16, 1, 2, 3, 4, -5].iter().flat_map(|n| n.to_le_bytes()));
    of_type(0, &body)
}

fn of_type(kind: u16, body: &[u8]) -> Vec<u8> {
    let mut frame = (22 + body.len() as u32).to_le_bytes().to_vec();
    for number in [kind, 0x0200, 2026, 11, 24, 1, 2, 3, 77] {
        frame.extend(number.to_le_bytes());
    }
    [frame.as_slice(), body].concat()
}

fn mdt(frames: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"\x01\xb0\x93\xff".to_vec();
    bytes.resize(12, 0);
    bytes.extend((frames.len() as u16 - 1).to_le_bytes());
    bytes.resize(33, 0);
    [bytes, frames.concat()].concat()
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
    let refusal = |frames: &[Vec<u8>]| read_bytes(&mdt(frames)).unwrap_err();
    assert!(refusal(&[of_type(106, &[0; 9])]).to_string().contains("none of the 1 frames"));
    assert!(refusal(&[frame(4, 1, 1.0, 0)]).to_string().contains("`Current` (code 1)"));
    let mut short = frame(0, -1, 1.0, 0);
    short[20] = 35;
    let error = refusal(&[short]);
    assert!(matches!(&error, FormatError::Field { field, .. } if field == "size of the variables"), "{error}");
    let mut endless = frame(0, -1, 1.0, 0);
    endless[0] = 0;
    let error = refusal(&[endless]);
    assert!(matches!(&error, FormatError::Field { field, .. } if field == "size of a frame"), "{error}");
}
