use asperity_formats::Format;

use crate::assert_metadata;
use crate::check::{assert_no_warning, assert_refused, assert_scan, bytes, padded, patched};
use crate::fixture::Fixture;

/// A file of 3 × 2 heights in steps of a quarter of a micrometre, after a comment.
fn zmg() -> Vec<u8> {
    let start = padded("Zeta-Instruments", 85);
    // Points along x and y; steps along x, y, z in µm.
    let grid = bytes![[3_u32, 2, 7], [0.5_f32, 0.75, 0.25], [0_u8; 8]];
    let comment = "a seal";
    bytes![start, grid, comment.len() as u32, [0_u8; 84], comment, [0_i16, 4, -4, 32767, -32768, 1]]
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::whole("ZMG", zmg())]
}

#[test]
fn heights_are_numbers_of_steps_in_micrometres() {
    let heights_m = [0.0, 1e-6, -1e-6, 8191.75e-6, -8192e-6, 0.25e-6];
    let scan = assert_scan(&zmg(), Format::Zmg, (2, 3), (0.5e-6, 0.75e-6), &heights_m);
    assert_metadata(&scan, &[("comment", "a seal")]);
    let flat = patched(&zmg(), 211, [0_i16, 1, 1, 0, 0, 1]);
    assert_no_warning(&assert_scan(
        &flat,
        Format::Zmg,
        (2, 3),
        (0.5e-6, 0.75e-6),
        &[0.0, 0.25e-6, 0.25e-6, 0.0, 0.0, 0.25e-6],
    ));
}

#[test]
fn sizes_beyond_the_file_and_a_scale_of_zero_are_refused() {
    let whole = zmg();
    assert_refused([
        (patched(&whole, 85, 0_u32), "ZMG: points along x (byte 85) is `0`"),
        (patched(&whole, 85, [u32::MAX; 2]), "the limit is"),
        (patched(&whole, 105, 0_f32), "ZMG: step along z (byte 105) is `0`"),
        (patched(&whole, 117, u32::MAX), "ZMG: comment (byte 205) stop after"),
        (patched(&whole, 89, 3_u32), "ZMG: the heights (byte 211) stop after 12 bytes; wanted 18"),
        (whole[..200].to_vec(), "ZMG: comment (byte 205)"),
    ]);
}
