//! WSxM: a text header of sections up to `[Header end]`, then one image of `int16`, `float32` or `float64`.
//!
//! Integers are scaled so that their range is `Z Amplitude`; real numbers are in its unit. The first number is the lower right corner of
//! the image and the last the upper left one, as in Gwyddion and WSxM's own pictures.
//!
//! The vendor published no description of the integers' scale. Files state the same scale a second time by `Conversion Factor 00` per volt
//! and `DSP voltage range`.

use crate::sections::{Section, quantity, section, sections};
use crate::{
    ChosenMap, Description, Format, Input, MAX_TEXT_BYTES, ReadOptions, Result, Sample, Scan, Tested, TextLimit,
    per_metre, utf8_or_latin1,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["stp", "top"],
    vendor: "WSxM Solutions (Nanotec)",
    known_by: "`WSxM file copyright`",
    reads: "int16, float32, float64; images only",
    orientation: "from the lower right corner on; row 0 is the last line",
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::Wsxm, |bytes| bytes.starts_with(b"WSxM file copyright"), read)
};

/// Second line of an image, and third line up to the number.
const IMAGE: &str = "SxM Image file";
const HEADER_SIZE: &str = "Image header size";
const END: &str = "[Header end]";

/// Reads the image.
///
/// # Errors
/// Other kinds of data, a damaged header, another unit than one of length, and data beyond the end of the file.
fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Wsxm, bytes);
    let text = utf8_or_latin1(&bytes[..bytes.len().min(MAX_TEXT_BYTES)]);
    if text.lines().nth(1).is_none_or(|line| line.trim() != IMAGE) {
        return Err(input.unsupported("the file holds no image", "an image (SxM Image file)"));
    }
    let text = text.split_once(END).ok_or_else(|| input.missing(END, 0, "the end of the header"))?.0;
    let sections = sections(Format::Wsxm, text, ":", |line| line.strip_prefix('[')?.strip_suffix(']'));
    let start: usize = sections[0].number(HEADER_SIZE)?;
    let [general, control] = ["General Info", "Control"].map(|name| section(&sections, name));
    let (general, control) = (general?, control?);
    let (ny, nx) = general.shape("Number of rows", "Number of columns")?;
    let kind = general.field("Image Data Type").unwrap_or("short");
    let sample = match kind {
        "short" | "integer" => Sample::I16,
        "float" => Sample::F32,
        "double" => Sample::F64,
        _ => return Err(general.wrong("Image Data Type", "short, integer, float or double")),
    };
    let (amplitude, unit) = length(general, "Z Amplitude")?;
    let name = general.field("Acquisition channel").unwrap_or("image").to_owned();
    let chosen = ChosenMap::new(Format::Wsxm, [(name, unit.to_owned())], &ReadOptions::default())?;
    let mut heights = input.samples("the image", start, ny * nx, sample)?;
    heights.reverse();
    let scale = if sample.is_float() {
        1.0
    } else {
        let (low, high) = heights.iter().fold((f64::MAX, f64::MIN), |(low, high), n| (low.min(*n), high.max(*n)));
        if high > low { amplitude / (high - low) } else { 0.0 }
    };
    heights.iter_mut().for_each(|n| *n = *n * scale / chosen.per_metre);
    let heights_m = input.matrix("the image", start, (ny, nx), heights)?;

    let size_m = |key| {
        let (size, unit) = length(control, key)?;
        let per_metre = per_metre(unit).ok_or_else(|| control.wrong(key, "a length"))?;
        Ok::<_, crate::FormatError>(size / per_metre)
    };
    let width_m = size_m("X Amplitude")?;
    // A square scan may state one size only.
    let height_m = if control.field("Y Amplitude").is_some() { size_m("Y Amplitude")? } else { width_m };
    let pitch_m = Some((width_m / nx as f64, height_m / ny as f64));
    let mut scan = Scan { height_unit: Some(unit.to_owned()), ..Scan::new(heights_m, pitch_m) };
    let mut room = TextLimit::default();
    [general, control].iter().for_each(|section| section.add_to(&mut scan, &mut room));
    Ok(scan)
}

/// Returns a number and its unit.
fn length<'a>(section: &'a Section, key: &str) -> Result<(f64, &'a str)> {
    let (number, unit) = quantity(section.text(key)?);
    Ok((number.ok_or_else(|| section.wrong(key, "a number and its unit"))?, unit))
}
