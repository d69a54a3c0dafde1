//! Nanoscope of Digital Instruments, Veeco and Bruker (`.spm`, `.001`): a text header of sections, then images of integers.
//!
//! A section starts with a line `\*Name`, a field is a line `\Key: value`, and a byte 0x1A follows the header. Each section
//! `Ciao image list` describes an image. Its field `@2:Z scale: V [Sens. Zsens] (0.0067 V/LSB) 440.0 V` states the voltage of the whole
//! range of its integers, and `Sens. Zsens`, a field of another section, the nanometre of a volt. From version 9.2 on all integers have
//! 32 bits, while `Bytes/pixel` still tells of which width the range is. Lines are stored from the bottom up.
//!
//! The vendor published no description. Gwyddion's user guide describes the header; fields of unknown meaning become metadata.

use crate::sections::{Section, quantity, sections};
use crate::{
    ChosenMap, Description, Format, Input, MAX_TEXT_BYTES, ReadOptions, Result, Sample, Scan, Tested, TextLimit,
    per_metre, refuse_if, utf8_or_latin1,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["spm", "000", "001"],
    vendor: "Digital Instruments, Veeco, Bruker",
    known_by: "`\\*File list`",
    reads: "int16, int32, version 4.3 and later; no force curves",
    orientation: "lines from the bottom up; row 0 is the last line",
    tested: Tested::InstrumentFiles,
    ..Description::new(
        Format::Nanoscope,
        |bytes| STARTS.iter().any(|start| bytes.starts_with(start)) || bytes.starts_with(AS_TEXT),
        read,
    )
};

/// First bytes of a file, and of a file whose data are text.
const STARTS: [&[u8]; 2] = [b"\\*File list", b"\\*EC File list"];
const AS_TEXT: &[u8] = b"?*File list";
/// Byte after the header.
const HEADER_END: u8 = 0x1a;
/// Names of sections that describe an image.
const IMAGES: [&str; 4] = ["Ciao image list", "NC AFM image list", "AFM image list", "STM image list"];
/// Version from which on all integers have 32 bits.
const WIDE: u32 = 0x0920_0000;
/// Largest number of images.
const MAX_IMAGES: usize = 1000;

/// Reads a height map.
///
/// # Errors
/// Data that are text, force curves, no image of heights, a damaged header, and images beyond the end of the file.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Nanoscope, bytes);
    refuse_if!(bytes.starts_with(AS_TEXT), input.unsupported("the data are text", "binary data"));
    let start = &bytes[..bytes.len().min(MAX_TEXT_BYTES)];
    let end = start.iter().position(|&byte| byte == HEADER_END).unwrap_or(start.len());
    let text = utf8_or_latin1(&start[..end]);
    let sections = sections(Format::Nanoscope, &text, ": ", |line| line.strip_prefix("\\*"));
    let is_image = |section: &&Section| IMAGES.iter().any(|name| name.eq_ignore_ascii_case(section.name));
    let images: Vec<&Section> = sections.iter().filter(is_image).take(MAX_IMAGES).collect();
    let scales: Vec<Scale> = images.iter().map(|image| Scale::of(image, &sections)).collect();
    let maps = images.iter().zip(&scales).map(|(image, scale)| (name(image), scale.usable_unit()));
    let chosen = ChosenMap::new(Format::Nanoscope, maps, options)?;
    let (image, scale) = (images[chosen.map], &scales[chosen.map]);
    let scale_m = scale.value / chosen.per_metre;

    let (ny, nx) = image.shape("Number of lines", "Samps/line")?;
    let (start, length): (usize, usize) = (image.number("Data offset")?, image.number("Data length")?);
    let is_wide = version(&sections) >= WIDE && length >= 4 * nx * ny;
    let sample = if is_wide || image.field("Bytes/pixel") == Some("4") { Sample::I32 } else { Sample::I16 };
    let heights_m = input.heights_upwards(chosen.name(), start, (ny, nx), sample, |n| n * scale_m)?;
    let pitch_m = size_m(image)?.map(|(x_m, y_m)| (x_m / nx as f64, y_m / ny as f64));
    let mut scan = Scan { height_unit: Some(scale.unit.clone()), ..Scan::new(heights_m, pitch_m) };
    let mut room = TextLimit::default();
    sections.iter().take(3).chain([image]).for_each(|section| section.add_to(&mut scan, &mut room));
    Ok(chosen.add_to(scan))
}

/// Returns the value of the parameter with this name, whose key is `@2:NAME` or `@3:NAME`.
fn parameter<'a>(section: &'a Section, name: &str) -> Option<&'a str> {
    let is_it = |key: &str| key.strip_prefix('@').and_then(|key| key.split_once(':')).is_some_and(|(_, of)| of == name);
    section.find(is_it)
}

/// Value of an image's number 1.
struct Scale {
    value: f64,
    unit: String,
}

impl Scale {
    /// Reads the scale of an image: the voltage of the whole range and the length of a volt. A parameter without sensitivity is a voltage.
    fn of(image: &Section, sections: &[Section]) -> Self {
        let stated = parameter(image, "Z scale").unwrap_or_default();
        let sensitivity = stated.split_once('[').and_then(|(_, rest)| rest.split_once(']'));
        let name = sensitivity.map_or("", |(name, _)| name);
        let hard = stated.rsplit_once("/LSB)").map_or(stated, |(_, hard)| hard);
        let (range, hard_unit) = quantity(hard);
        let range = range.unwrap_or(f64::NAN);
        let key = format!("@{name}");
        let soft = sections.iter().find_map(|section| section.field(&key)).and_then(|value| value.strip_prefix("V "));
        let (per_volt, soft_unit) = soft.map_or((None, ""), quantity);
        let values = if image.field("Bytes/pixel") == Some("4") { 2.0_f64.powi(32) } else { 65536.0 };
        let (unit, divisor) = soft_unit.split_once('/').unwrap_or((hard_unit, hard_unit));
        let prefix = match (hard_unit, divisor) {
            _ if hard_unit == divisor => 1.0,
            ("mV", "V") => 1e-3,
            ("V", "mV") => 1e3,
            _ => f64::NAN,
        };
        Self { value: range / values * prefix * per_volt.unwrap_or(1.0), unit: unit.to_owned() }
    }

    /// Returns the unit if there is a value for it.
    fn usable_unit(&self) -> String {
        if self.value.is_finite() || self.unit.is_empty() {
            self.unit.clone()
        } else {
            format!("{} of unknown scale", self.unit)
        }
    }
}

/// Returns the name of an image. The same name twice is one scan to the right and one to the left.
fn name(image: &Section) -> String {
    let stated = parameter(image, "Image Data").or_else(|| image.field("Image Data")).unwrap_or_default();
    let quoted = stated.split('"').nth(1).unwrap_or(stated);
    let direction = image.field("Line Direction").filter(|direction| direction.eq_ignore_ascii_case("retrace"));
    direction.map_or(quoted.to_owned(), |_| format!("{quoted} (retrace)"))
}

fn version(sections: &[Section]) -> u32 {
    let stated = sections.iter().find_map(|section| section.field("Version")).unwrap_or_default();
    u32::from_str_radix(stated.trim_start_matches("0x"), 16).unwrap_or(0)
}

/// Returns width and height of an image in metre.
fn size_m(image: &Section) -> Result<Option<(f64, f64)>> {
    const KEY: &str = "Scan Size";
    let Some(stated) = image.field(KEY) else { return Ok(None) };
    let wrong = || image.wrong(KEY, "one or two numbers and a unit of length");
    let (width, rest) = quantity(stated);
    let (height, unit) = match quantity(rest) {
        (Some(height), unit) => (Some(height), unit),
        (None, _) => (None, rest),
    };
    let per_metre = per_metre(unit).ok_or_else(wrong)?;
    let width = width.ok_or_else(wrong)?;
    let aspect = image.field("Aspect Ratio").and_then(|ratio| ratio.split_once(':'));
    let ratio = aspect.and_then(|(x, y)| Some(y.trim().parse::<f64>().ok()? / x.trim().parse::<f64>().ok()?));
    let height = height.unwrap_or(width * ratio.unwrap_or(1.0));
    Ok(Some((width / per_metre, height / per_metre)))
}
