//! Zygo MetroPro DAT.

use asperity_formats::Format;

use crate::check::{assert_pitch, assert_refused, assert_scan, assert_warns, bytes, padded, patched, warns};
use crate::fixture::{Fixture, read_bytes};
use crate::{NAN, assert_heights, assert_metadata, bits};

/// Numbers in the order of bytes of the first half of the header.
fn big<const N: usize, const B: usize>(numbers: [[u8; B]; N]) -> Vec<u8> {
    numbers.concat()
}

fn u16s<const N: usize>(numbers: [u16; N]) -> Vec<u8> {
    big(numbers.map(u16::to_be_bytes))
}

fn f32s<const N: usize>(numbers: [f32; N]) -> Vec<u8> {
    big(numbers.map(f32::to_be_bytes))
}

const PHASE: [i32; 6] = [32768, -65536, 2_147_483_640, 0, 2_147_483_639, i32::MAX];

/// A header of a NewView: the fields one after the other, in the order and with the widths of the published map. `intensity` is width,
/// height, number of frames and bytes.
fn header(kind: (u32, u16, u32), [width, height, frames]: [u16; 3], intensity_bytes: u32) -> Vec<u8> {
    let magic = [&kind.0.to_be_bytes()[..], &kind.1.to_be_bytes(), &kind.2.to_be_bytes()].concat();
    // Type, date and version of the software; intensity: origin, size, frames, range, bytes; phase: origin, size, bytes.
    let software = bytes![u16s([1]), padded("Fri Jun 23 15:37:19 2006", 30), u16s([8, 1, 5])];
    let sizes =
        bytes![u16s([0, 0, width, height, frames, 255]), big([intensity_bytes.to_be_bytes()]), u16s([4, 5, 3, 2])];
    let stamp = bytes![big([24_u32.to_be_bytes(), 1_311_439_776_u32.to_be_bytes()]), padded(b"flank 3, \xb5m", 82)];
    // Source; scale factor, wavelength, numerical aperture, obliquity, magnification, lateral resolution.
    let optics = bytes![u16s([0]), f32s([0.5, 6.25e-7, 0.25, 1.25, 20.0, 2e-6])];
    // Acquisition type, averages, ramp calibration, gain tolerance and gain; thickness, light control, range.
    let acquisition = bytes![u16s([2, 1, 0, 0, 0]), f32s([0.0]), u16s([0]), f32s([0.0])];
    // Sequence of a radius measurement; minimum modulation and its count; phase_res; minimum area; discontinuity action and
    // filter; connection order, sign.
    let phase = bytes![[0_u8; 2], u16s([0, 1, 0, 0, 1, 0, 7, 1]), f32s([60.0]), u16s([0, 0])];
    // Camera width and height; system type, board, serial number, instrument; objective and part.
    let camera = bytes![u16s([640, 480, 5, 0, 59407, 3]), padded(" 20X  Mirau", 12), padded("gear 7", 40)];
    // Code V type, phase averages, system error subtracted, 16 unused bytes; serial number, refractive index.
    let part = bytes![u16s([0, 4, 1]), [0_u8; 16], padded("S/N 12", 40), f32s([1.0])];
    // Tilt bias, fringes; maximum area; setup, wrapped; filter, wavelength 2; fold; wavelengths 1, 3, 4; fiducials.
    let scan = bytes![u16s([0, 1]), [0_u8; 30], padded("1", 8), u16s([3]), padded("100 um bipolar", 20), [0_u8; 58]];
    let pixels = f32s([7.5e-6, 7.5e-6, 0.0, 6.5]);
    // From here on numbers are little-endian. State of the coordinates, positions, rotations, two modes.
    let coordinates = bytes![[0_u8; 4], [1.5_f32, 2.5, 3.5, 0.0, 0.0, 0.0], [0_u8; 4], padded("sphere.dat", 28)];
    // Zoom; part angles and distance, split camera; materials.
    let zoom = bytes![padded(" 0.5X ", 8), [0_u8; 20], padded("steel", 48)];
    let start =
        [magic, software, sizes, stamp, optics, acquisition, phase, camera, part, scan, pixels, coordinates, zoom];
    let minimum_modulation = bytes![padded(start.concat(), 710), 1_f32];
    padded(bytes![padded(minimum_modulation, 798), 59407_i32], kind.2 as usize)
}

fn file(kind: (u32, u16, u32), intensity: [u16; 3], intensity_bytes: u32, intensities: &[u16]) -> Vec<u8> {
    bytes![header(kind, intensity, intensity_bytes), intensities, big(PHASE.map(i32::to_be_bytes))]
}

const FORMAT_1: (u32, u16, u32) = (0x881b_036f, 1, 834);
const FORMAT_3: (u32, u16, u32) = (0x881b_0371, 3, 4096);

fn usual() -> Vec<u8> {
    file(FORMAT_1, [2, 2, 1], 8, &[1, 2, 3, 0xffff])
}

fn without_intensity(kind: (u32, u16, u32)) -> Vec<u8> {
    file(kind, [0; 3], 0, &[])
}

fn with_code(file: &[u8], code: u16) -> Vec<u8> {
    patched(file, 218, code.to_be_bytes())
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::whole("MetroPro with intensity", usual()),
        Fixture::whole("MetroPro without intensity", without_intensity(FORMAT_1)),
        Fixture::whole("MetroPro of format 3", with_code(&without_intensity(FORMAT_3), 2)),
    ]
}

#[test]
fn heights_follow_the_published_formula_and_the_first_row_is_on_top() {
    let pitch_m = f64::from(2e-6_f32);
    for (code, counts) in [(0, 4096.0), (1, 32768.0), (2, 131_072.0)] {
        let factor_m = 0.5 * f64::from(6.25e-7_f32) * 1.25 / counts;
        let wanted = PHASE.map(|p| if p >= 2_147_483_640 { NAN } else { f64::from(p) * factor_m });
        assert_scan(&with_code(&usual(), code), Format::MetroPro, (2, 3), (pitch_m, pitch_m), &wanted);
    }
}

#[test]
fn headers_of_834_and_4096_bytes_are_followed_by_frames_of_intensity() {
    let wanted = read_bytes(&usual()).unwrap();
    let frames = file((0x881b_0370, 2, 834), [2, 2, 3], 24, &[7; 12]);
    for bytes in [without_intensity(FORMAT_1), frames, without_intensity(FORMAT_3)] {
        let scan = read_bytes(&bytes).unwrap();
        assert_eq!(bits(&scan), bits(&wanted));
        assert!(!warns(&scan, "bytes"), "{:?}", scan.warnings);
    }
    // The size of the file decides where bytes and dimensions of the intensity disagree.
    for bytes in [file(FORMAT_1, [2, 2, 0], 8, &[0; 4]), file(FORMAT_1, [2, 2, 1], 0, &[0; 4])] {
        let scan = read_bytes(&bytes).unwrap();
        assert_eq!(bits(&scan), bits(&wanted));
        assert_warns(&scan, "8 were skipped");
    }
}

#[test]
fn doubts_about_pixels_sign_and_size_are_reported() {
    let plain = read_bytes(&usual()).unwrap();
    let no_lateral = read_bytes(&patched(&usual(), 184, [0_u8; 4])).unwrap();
    assert_pitch(&no_lateral, None);
    for (bytes, words) in [
        (patched(&usual(), 184, [0_u8; 4]), "means unknown"),
        (patched(&usual(), 490, 9e-6_f32.to_be_bytes()), "pixels of the camera"),
        (patched(&usual(), 232, [0_u8, 1]), "inverted"),
        (bytes![usual(), [0_u8; 3]], "3 bytes follow"),
    ] {
        assert!(!warns(&plain, words));
        let scan = read_bytes(&bytes).unwrap();
        assert_warns(&scan, words);
        assert_eq!(bits(&scan), bits(&plain));
    }
    assert!(!warns(&read_bytes(&patched(&usual(), 486, [0_u8; 8])).unwrap(), "pixels of the camera"));
}

#[test]
fn the_header_is_kept_in_either_order_of_bytes() {
    let scan = read_bytes(&usual()).unwrap();
    assert_metadata(&scan, &[("swinfo_date", "Fri Jun 23 15:37:19 2006"), ("time_stamp", "2011-07-23T16:49:36Z")]);
    assert_metadata(&scan, &[("swinfo_vers", "8.1.5"), ("comment", "flank 3, µm"), ("cn_org_x", "4")]);
    assert_metadata(&scan, &[("wavelength_in", "0.000000625"), ("num_aperture", "0.25"), ("magnification", "20")]);
    assert_metadata(&scan, &[("obj_name", "20X  Mirau"), ("part_name", "gear 7"), ("part_ser_num", "S/N 12")]);
    assert_metadata(&scan, &[("sub_sys_err", "1"), ("phase_avg_cnt", "4"), ("discon_filter", "60")]);
    assert_metadata(&scan, &[("sys_serial", "59407"), ("scan_descr", "100 um bipolar"), ("light_level_pct", "6.5")]);
    assert_metadata(&scan, &[("coords_y_pos", "2.5"), ("sys_err_file_name", "sphere.dat"), ("zoom_descr", "0.5X")]);
    assert_metadata(&scan, &[("material_a", "steel"), ("min_mod_pct", "1"), ("sys_serial2", "59407")]);
    assert!(!scan.metadata.contains_key("material_b"));
}

#[test]
fn headers_that_contradict_themselves_or_the_file_are_refused() {
    let with = |at, number: f32| patched(&usual(), at, number.to_be_bytes());
    let sized = |side: u16| patched(&usual(), 68, u16s([side; 2]));
    let frames = |bytes| file(FORMAT_1, [u16::MAX; 3], bytes, &[1, 2, 3, 4]);
    assert_refused([
        (sized(0), "no connected phase"),
        (patched(&usual(), 4, u16s([2])), "header_format ("),
        (patched(&usual(), 6, 4096_u32.to_be_bytes()), "header_size ("),
        (with_code(&usual(), 3), "phase_res ("),
        (with(168, 0.0), "wavelength_in ("),
        (with(164, f32::NAN), "intf_scale_factor ("),
        (with(176, f32::INFINITY), "obliquity_factor ("),
        (sized(16384), "stop after 24 bytes; wanted 1073741824"),
        (sized(u16::MAX), "the limit is"),
        (frames(u32::MAX), "stop after 0 bytes; wanted 24"),
    ]);
    assert_heights(
        &read_bytes(&frames(8)).unwrap(),
        &read_bytes(&usual()).unwrap().heights_m.into_raw_vec_and_offset().0,
    );
}
