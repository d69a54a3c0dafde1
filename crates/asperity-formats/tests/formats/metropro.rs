//! Zygo MetroPro DAT.

use asperity_formats::FormatError;

use crate::fixture::{Fixture, read_bytes, unsupported, wrong_field};
use crate::{NAN, assert_heights, assert_metadata};

/// Variable parts of a file. The rest is as written by a NewView.
struct MetroPro {
    magic: u32,
    format: u16,
    header_bytes: u32,
    /// Width, height, number of frames.
    intensity: (u16, u16, u16),
    intensity_bytes: u32,
    size: (u16, u16),
    scale_factor: f32,
    wavelength_m: f32,
    obliquity: f32,
    lateral_res_m: f32,
    phase_res: u16,
    sign: u16,
    camera_pixel_m: (f32, f32),
    intensities: Vec<u16>,
    phase: Vec<i32>,
}

impl Default for MetroPro {
    fn default() -> Self {
        Self {
            magic: 0x881b_036f,
            format: 1,
            header_bytes: 834,
            intensity: (2, 2, 1),
            intensity_bytes: 8,
            size: (3, 2),
            scale_factor: 0.5,
            wavelength_m: 6.25e-7,
            obliquity: 1.25,
            lateral_res_m: 2e-6,
            phase_res: 1,
            sign: 0,
            camera_pixel_m: (7.5e-6, 7.5e-6),
            intensities: vec![1, 2, 3, 0xffff],
            phase: vec![32768, -65536, 2_147_483_640, 0, 2_147_483_639, i32::MAX],
        }
    }
}

impl MetroPro {
    /// The fields of the header one after the other, in the order and with the widths of the published map.
    fn bytes(&self) -> Vec<u8> {
        fn text(bytes: &mut Vec<u8>, text: &[u8], width: usize) {
            bytes.extend(text);
            bytes.extend(vec![0; width - text.len()]);
        }
        fn big16(bytes: &mut Vec<u8>, numbers: &[u16]) {
            bytes.extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
        }
        fn big_float(bytes: &mut Vec<u8>, numbers: &[f32]) {
            bytes.extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
        }
        let mut bytes = self.magic.to_be_bytes().to_vec();
        bytes.extend(self.format.to_be_bytes());
        bytes.extend(self.header_bytes.to_be_bytes());
        // Software: type, date, version.
        big16(&mut bytes, &[1]);
        text(&mut bytes, b"Fri Jun 23 15:37:19 2006", 30);
        big16(&mut bytes, &[8, 1, 5]);
        // Intensity: origin, size, frames, range, bytes.
        big16(&mut bytes, &[0, 0, self.intensity.0, self.intensity.1, self.intensity.2, 255]);
        bytes.extend(self.intensity_bytes.to_be_bytes());
        // Phase: origin, size, bytes.
        big16(&mut bytes, &[4, 5, self.size.0, self.size.1]);
        bytes.extend(u32::from(self.size.0).wrapping_mul(self.size.1.into()).wrapping_mul(4).to_be_bytes());
        bytes.extend(1_311_439_776_i32.to_be_bytes());
        text(&mut bytes, b"flank 3, \xb5m", 82);
        // Source; scale factor, wavelength, numerical aperture, obliquity, magnification, lateral resolution.
        big16(&mut bytes, &[0]);
        big_float(&mut bytes, &[self.scale_factor, self.wavelength_m, 0.25]);
        big_float(&mut bytes, &[self.obliquity, 20.0, self.lateral_res_m]);
        // Acquisition type, averages, ramp calibration, gain tolerance and gain; thickness, light control, range.
        big16(&mut bytes, &[2, 1, 0, 0, 0]);
        big_float(&mut bytes, &[0.0]);
        big16(&mut bytes, &[0]);
        big_float(&mut bytes, &[0.0]);
        // Sequence of a radius measurement; minimum modulation and its count.
        bytes.extend([0; 2]);
        bytes.extend([0, 0, 0, 1, 0, 0, 0, 0]);
        big16(&mut bytes, &[self.phase_res]);
        // Minimum area; discontinuity action and filter; connection order.
        bytes.extend([0, 0, 0, 7]);
        big16(&mut bytes, &[1]);
        big_float(&mut bytes, &[60.0]);
        big16(&mut bytes, &[0, self.sign]);
        // Camera width and height; system type, board, serial number, instrument.
        big16(&mut bytes, &[640, 480, 5, 0, 59407, 3]);
        text(&mut bytes, b" 20X  Mirau", 12);
        text(&mut bytes, b"gear 7", 40);
        // Code V type, phase averages, system error subtracted, 16 unused bytes.
        big16(&mut bytes, &[0, 4, 1]);
        bytes.extend([0; 16]);
        text(&mut bytes, b"S/N 12", 40);
        big_float(&mut bytes, &[1.0]);
        // Tilt bias, fringes; maximum area; setup, wrapped; filter, wavelength 2; fold; wavelengths 1, 3, 4.
        big16(&mut bytes, &[0, 1]);
        bytes.extend([0; 4 + 2 + 2 + 4 + 4 + 2 + 12]);
        text(&mut bytes, b"1", 8);
        big16(&mut bytes, &[3]);
        text(&mut bytes, b"100 um bipolar", 20);
        // Fiducials: number and 7 points.
        bytes.extend([0; 2 + 56]);
        big_float(&mut bytes, &[self.camera_pixel_m.0, self.camera_pixel_m.1, 0.0, 6.5]);
        // From here on numbers are little-endian. State of the coordinates, positions, rotations, two modes.
        bytes.extend([0; 4]);
        bytes.extend([1.5_f32, 2.5, 3.5, 0.0, 0.0, 0.0].iter().flat_map(|number| number.to_le_bytes()));
        bytes.extend([0; 4]);
        text(&mut bytes, b"sphere.dat", 28);
        text(&mut bytes, b" 0.5X ", 8);
        // Part angles and distance, split camera.
        bytes.extend([0; 12 + 8]);
        text(&mut bytes, b"steel", 24);
        text(&mut bytes, b"", 24);
        // Up to the minimum modulation in percent.
        bytes.extend([0; 710 - 638]);
        bytes.extend(1_f32.to_le_bytes());
        // Up to the second serial number.
        bytes.extend([0; 798 - 714]);
        bytes.extend(59407_i32.to_le_bytes());
        bytes.extend([0; 834 - 802]);
        assert_eq!(bytes.len(), 834);
        bytes.resize(self.header_bytes as usize, 0);
        big16(&mut bytes, &self.intensities);
        bytes.extend(self.phase.iter().flat_map(|phase| phase.to_be_bytes()));
        bytes
    }
}

fn without_intensity() -> MetroPro {
    MetroPro { intensity: (0, 0, 0), intensity_bytes: 0, intensities: vec![], ..MetroPro::default() }
}

fn long_header() -> MetroPro {
    MetroPro { magic: 0x881b_0371, format: 3, header_bytes: 4096, phase_res: 2, ..without_intensity() }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::whole("MetroPro with intensity", MetroPro::default().bytes()),
        Fixture::whole("MetroPro without intensity", without_intensity().bytes()),
        Fixture::whole("MetroPro of format 3", long_header().bytes()),
    ]
}

/// Heights of the phases by the published formula.
fn heights_m(phase: &[i32], counts_per_fringe: f64) -> Vec<f64> {
    let factor_m = 0.5 * f64::from(6.25e-7_f32) * 1.25 / counts_per_fringe;
    phase.iter().map(|&p| if p >= 2_147_483_640 { NAN } else { f64::from(p) * factor_m }).collect()
}

#[test]
fn heights_follow_the_published_formula_and_the_first_row_is_on_top() {
    for (phase_res, counts) in [(0, 4096.0), (1, 32768.0), (2, 131_072.0)] {
        let file = MetroPro { phase_res, ..MetroPro::default() };
        let scan = read_bytes(&file.bytes()).unwrap();
        assert_eq!(scan.heights_m.dim(), (2, 3));
        assert_heights(&scan, &heights_m(&file.phase, counts));
        assert_eq!(scan.missing_points(), 2);
        assert_eq!(scan.pitch_m, Some((f64::from(2e-6_f32), f64::from(2e-6_f32))));
    }
}

#[test]
fn one_fringe_is_half_a_wave_times_the_obliquity() {
    let scan = read_bytes(&MetroPro::default().bytes()).unwrap();
    assert!((scan.heights_m[[0, 0]] / (0.5 * 6.25e-7 * 1.25) - 1.0).abs() < 1e-7);
}

#[test]
fn headers_of_834_and_4096_bytes_are_followed_by_frames_of_intensity() {
    let wanted = read_bytes(&MetroPro::default().bytes()).unwrap();
    let frames = MetroPro {
        magic: 0x881b_0370,
        format: 2,
        intensity: (2, 2, 3),
        intensity_bytes: 24,
        intensities: vec![7; 12],
        ..MetroPro::default()
    };
    let long = MetroPro { phase_res: 1, ..long_header() };
    for file in [without_intensity(), frames, long] {
        let scan = read_bytes(&file.bytes()).unwrap();
        assert_eq!(crate::bits(&scan), crate::bits(&wanted));
        assert!(scan.warnings.iter().all(|warning| !warning.contains("bytes")), "{:?}", scan.warnings);
    }
}

#[test]
fn the_size_of_the_file_decides_where_bytes_and_dimensions_of_the_intensity_disagree() {
    let wanted = read_bytes(&MetroPro::default().bytes()).unwrap();
    let no_frames = MetroPro { intensity: (2, 2, 0), ..MetroPro::default() };
    let no_bytes = MetroPro { intensity_bytes: 0, ..MetroPro::default() };
    for file in [no_frames, no_bytes] {
        let scan = read_bytes(&file.bytes()).unwrap();
        assert_eq!(crate::bits(&scan), crate::bits(&wanted));
        assert!(scan.warnings.iter().any(|warning| warning.contains("8 were skipped")), "{:?}", scan.warnings);
    }
}

#[test]
fn an_unknown_lateral_resolution_leaves_no_pixel_size() {
    let scan = read_bytes(&MetroPro { lateral_res_m: 0.0, ..MetroPro::default() }.bytes()).unwrap();
    assert_eq!(scan.pitch_m, None);
    assert!(scan.warnings.iter().any(|warning| warning.contains("means unknown")), "{:?}", scan.warnings);
}

#[test]
fn a_camera_without_square_pixels_gives_a_warning() {
    let gives_warning = |file: MetroPro| {
        read_bytes(&file.bytes()).unwrap().warnings.iter().any(|warning| warning.contains("pixels of the camera"))
    };
    assert!(!gives_warning(MetroPro::default()));
    assert!(!gives_warning(MetroPro { camera_pixel_m: (0.0, 0.0), ..MetroPro::default() }));
    assert!(gives_warning(MetroPro { camera_pixel_m: (7.5e-6, 9e-6), ..MetroPro::default() }));
}

#[test]
fn inverted_data_are_not_changed_and_give_a_warning() {
    let plain = read_bytes(&MetroPro::default().bytes()).unwrap();
    let inverted = read_bytes(&MetroPro { sign: 1, ..MetroPro::default() }.bytes()).unwrap();
    assert_eq!(crate::bits(&plain), crate::bits(&inverted));
    assert!(inverted.warnings.iter().any(|warning| warning.contains("inverted")), "{:?}", inverted.warnings);
    assert!(plain.warnings.iter().all(|warning| !warning.contains("inverted")));
}

#[test]
fn the_header_is_kept_in_either_order_of_bytes() {
    let scan = read_bytes(&MetroPro::default().bytes()).unwrap();
    let wanted = [
        ("swinfo_date", "Fri Jun 23 15:37:19 2006"),
        ("swinfo_vers", "8.1.5"),
        ("time_stamp", "2011-07-23T16:49:36Z"),
        ("comment", "flank 3, µm"),
        ("cn_org_x", "4"),
        ("wavelength_in", "0.000000625"),
        ("num_aperture", "0.25"),
        ("magnification", "20"),
        ("obj_name", "20X  Mirau"),
        ("part_name", "gear 7"),
        ("part_ser_num", "S/N 12"),
        ("sub_sys_err", "1"),
        ("phase_avg_cnt", "4"),
        ("discon_filter", "60"),
        ("sys_serial", "59407"),
        ("scan_descr", "100 um bipolar"),
        ("light_level_pct", "6.5"),
        ("coords_y_pos", "2.5"),
        ("sys_err_file_name", "sphere.dat"),
        ("zoom_descr", "0.5X"),
        ("material_a", "steel"),
        ("min_mod_pct", "1"),
        ("sys_serial2", "59407"),
    ];
    assert_metadata(&scan, &wanted);
    assert!(!scan.metadata.contains_key("material_b"));
}

#[test]
fn a_file_without_phase_is_refused() {
    let file = MetroPro { size: (0, 0), phase: vec![], ..MetroPro::default() };
    let found = unsupported(&file.bytes());
    assert!(found.contains("no connected phase"), "{found}");
}

#[test]
fn headers_that_contradict_themselves_or_give_no_heights_are_errors() {
    let plain = MetroPro::default;
    for (file, field) in [
        (MetroPro { format: 2, ..plain() }, "header_format"),
        (MetroPro { header_bytes: 4096, ..plain() }, "header_size"),
        (MetroPro { phase_res: 3, ..plain() }, "phase_res"),
        (MetroPro { wavelength_m: 0.0, ..plain() }, "wavelength_in"),
        (MetroPro { scale_factor: f32::NAN, ..plain() }, "intf_scale_factor"),
        (MetroPro { obliquity: f32::INFINITY, ..plain() }, "obliquity_factor"),
    ] {
        assert_eq!(wrong_field(&file.bytes()), field);
    }
}

#[test]
fn sizes_that_exceed_the_file_are_errors() {
    let long = MetroPro { size: (16384, 16384), ..MetroPro::default() }.bytes();
    assert!(matches!(read_bytes(&long), Err(FormatError::Truncated { found: 24, wanted: 1_073_741_824, .. })));
    let huge = MetroPro { size: (u16::MAX, u16::MAX), ..MetroPro::default() }.bytes();
    assert!(matches!(read_bytes(&huge), Err(FormatError::TooLarge { .. })));
    let frames = |intensity_bytes| {
        let most = (u16::MAX, u16::MAX, u16::MAX);
        read_bytes(&MetroPro { intensity: most, intensity_bytes, ..MetroPro::default() }.bytes())
    };
    assert!(matches!(frames(u32::MAX), Err(FormatError::Truncated { found: 0, wanted: 24, .. })));
    assert_eq!(frames(8).unwrap().missing_points(), 2);
}

#[test]
fn bytes_after_the_phase_give_a_warning() {
    let mut bytes = MetroPro::default().bytes();
    bytes.extend([0; 3]);
    let scan = read_bytes(&bytes).unwrap();
    assert!(scan.warnings.iter().any(|warning| warning.starts_with("3 bytes follow")), "{:?}", scan.warnings);
}
