use asperity_formats::{Format, Scan};

use crate::assert_heights;
use crate::check::{assert_error, assert_pitch, assert_refused, assert_scan};
use crate::fixture::{Fixture, read_bytes, read_channel};

/// Variable parts of a file of two images of 3 × 2 points: a height and a phase.
#[derive(Clone)]
struct Nanoscope {
    start: &'static str,
    version: &'static str,
    bytes_per_pixel: usize,
    /// Bytes of a stored number.
    stored: usize,
    scan_size: &'static str,
    sensitivity: &'static str,
}

impl Default for Nanoscope {
    fn default() -> Self {
        Self {
            start: "\\*File list",
            version: "0x05120130",
            bytes_per_pixel: 2,
            stored: 2,
            scan_size: "3 4 um",
            sensitivity: "V 10.0 nm/V",
        }
    }
}

impl Nanoscope {
    fn wide() -> Self {
        Self { version: "0x09200000", stored: 4, ..Self::default() }
    }

    fn bytes(&self) -> Vec<u8> {
        let length = 6 * self.stored;
        let image = |at: usize, name: &str, scale: &str| {
            format!(
                "\\*Ciao image list\r\n\\Data offset: {}\r\n\\Data length: {length}\r\n\\Bytes/pixel: {}\r\n\
                 \\Samps/line: 3\r\n\\Number of lines: 2\r\n\\Aspect Ratio: 1:1\r\n\\Scan Size: {}\r\n\
                 \\Line Direction: Retrace\r\n\\@2:Image Data: S [{name}] \"{name}\"\r\n\\@2:Z scale: {scale}\r\n",
                1024 + at * length,
                self.bytes_per_pixel,
                self.scan_size
            )
        };
        let header = format!(
            "{}\r\n\\Version: {}\r\n\\Date: 03:40:34 PM Thu Mar 09 2017\r\n\\*Scanner list\r\n\\@Sens. Zsens: {}\r\n{}{}\
             \\*File list end\r\n\x1a",
            self.start,
            self.version,
            self.sensitivity,
            image(0, "Phase", "V [] (0.0054932 º/LSB) 360.0 º"),
            image(1, "Height", "V [Sens. Zsens] (0.0067 V/LSB) 65.536 V"),
        );
        let mut bytes = header.into_bytes();
        bytes.resize(1024, 0);
        for number in (0_i32..6).chain([0, 1000, -2000, 3000, 32767, -32768]) {
            bytes.extend(&number.to_le_bytes()[..self.stored]);
        }
        bytes
    }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::whole("Nanoscope", Nanoscope::default().bytes()),
        Fixture::whole("Nanoscope of 32 bits", Nanoscope::wide().bytes()),
    ]
}

fn scan(file: &Nanoscope) -> Scan {
    read_bytes(&file.bytes()).unwrap()
}

#[test]
fn numbers_are_a_share_of_the_voltage_of_the_range_from_the_bottom_up() {
    // 65.536 V span 65536 numbers, and a volt is 10 nm: 1000 is 10 nm.
    let wanted = [30e-9, 327.67e-9, -327.68e-9, 0.0, 10e-9, -20e-9];
    for file in [Nanoscope::default(), Nanoscope::wide()] {
        let scan = assert_scan(&file.bytes(), Format::Nanoscope, (2, 3), (1e-6, 2e-6), &wanted);
        assert_eq!(scan.channels, ["Height (retrace)"]);
        assert_eq!(scan.metadata["Date"], "03:40:34 PM Thu Mar 09 2017");
        assert!(scan.warnings.concat().contains("`Phase (retrace)` (º)"), "{:?}", scan.warnings);
    }
    // Four bytes per pixel: the range is that of 32 bits.
    let scan = scan(&Nanoscope { bytes_per_pixel: 4, ..Nanoscope::wide() });
    assert_heights(&scan, &wanted.map(|z| z / 65536.0));
}

#[test]
fn one_or_two_sizes_in_any_unit_of_length_are_the_field() {
    for (size, pitch_m) in
        [("3 4 um", (1e-6, 2e-6)), ("3 4 ~m", (1e-6, 2e-6)), ("300 nm", (1e-7, 1.5e-7)), ("3 \u{b5}m", (1e-6, 1.5e-6))]
    {
        assert_pitch(&scan(&Nanoscope { scan_size: size, ..Nanoscope::default() }), pitch_m);
    }
    assert_refused([(Nanoscope { scan_size: "3 V", ..Nanoscope::default() }.bytes(), "Scan Size (")]);
}

#[test]
fn images_that_are_no_heights_text_and_force_curves_are_refused() {
    let volts = Nanoscope { sensitivity: "V 10.0 mA/V", ..Nanoscope::default() };
    assert_refused([
        (volts.bytes(), "`Height (retrace)` (mA)"),
        (Nanoscope { start: "?*File list", ..volts }.bytes(), "the data are text"),
        (b"\\*Force file list\r\n".to_vec(), "force curves"),
        (b"\\*File list\r\n\\Version: 0x05\r\n\x1a".to_vec(), "no image"),
    ]);
    assert_error(read_channel(&Nanoscope::default().bytes(), "Phase (retrace)"), "no height map");
}
