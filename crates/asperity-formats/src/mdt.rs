//! NT-MDT MDT: frames, of which those of a scan hold a map of `int16`.
//!
//! A frame starts with its size and type. In frames of a scan follow the scales of x, y and z (offset and step as `float32`, a code of the
//! unit), the channel, the dimensions, points of spectra, and the numbers from the bottom up. A number n is the height `offset` + n · `step`.
//!
//! The vendor's description of version 1 is public; the frames of arrays of newer programs (type 106) have another layout and are not read.

use crate::{
    ChosenMap, Description, Format, FormatError, Input, ReadOptions, Result, Sample, Scan, date, per_metre, refuse_if,
    warn_if,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["mdt"],
    vendor: "NT-MDT",
    known_by: "0x01B093FF",
    reads: "frames of scans, int16; no arrays, spectra or texts",
    orientation: "lines from the bottom up; row 0 is the last line",
    ..Description::new(Format::Mdt, |bytes| bytes.starts_with(MAGIC), read)
};

const MAGIC: &[u8] = b"\x01\xb0\x93\xff";
/// Offset of the number of the last frame, and of the first frame.
const LAST_FRAME: usize = 12;
const FRAMES: usize = 33;
/// Size of the header of a frame, and of the fields of a scan after it that are used.
const HEADER_BYTES: usize = 22;
const SCAN_BYTES: usize = 36;
const TYPE_SCAN: u16 = 0;
/// Units by their codes from −5 on.
const UNITS: [&str; 6] = ["m", "cm", "mm", "um", "nm", "\u{c5}"];
/// Channels by their numbers.
const CHANNELS: &str = "Height,DFL,Lateral F,Bias V,Current,FB-Out,MAG,MAG*Sin,MAG*Cos,RMS,CalcMag,Phase1,Phase2,CalcPhase,\
                        Ex1,Ex2,HvX,HvY,Snap Back";

/// Frame of a scan.
struct Frame<'a> {
    input: Input<'a>,
    /// Offset of the mode and the dimensions.
    shape_at: usize,
}

/// Reads a height map.
///
/// # Errors
/// Frames beyond the end of the file, and no frame of a scan of heights.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Mdt, bytes);
    let (mut frames, mut others) = (Vec::new(), 0);
    let mut at = FRAMES;
    for _ in 0..=input.u16("number of the last frame", LAST_FRAME)? {
        let size = input.u32("size of a frame", at)? as usize;
        refuse_if!(size < HEADER_BYTES, input.wrong("size of a frame", at, size, &format!("{HEADER_BYTES} or more")));
        input.take("a frame", at, size)?;
        let frame = input.up_to(at + size).from(at);
        at += size;
        if frame.u16("type of a frame", 4)? != TYPE_SCAN {
            others += 1;
            continue;
        }
        let variables = usize::from(frame.u16("size of the variables", 20)?);
        if variables < SCAN_BYTES {
            return Err(frame.wrong("size of the variables", 20, variables, &format!("{SCAN_BYTES} or more")));
        }
        frames.push(Frame { input: frame, shape_at: HEADER_BYTES + variables });
    }
    if frames.is_empty() && others > 0 {
        return Err(
            input.unsupported(format!("none of the {others} frames is that of a scan"), "frames of scans (type 0)")
        );
    }
    let maps = frames.iter().map(Frame::describe).collect::<Result<Vec<_>>>()?;
    let chosen = ChosenMap::new(Format::Mdt, maps, options)?;
    let mut scan = frames[chosen.map].scan(&chosen)?;
    warn_if!(scan.warnings, others > 0 && options.channel.is_none(), "{others} frames other than scans were left out");
    Ok(chosen.add_to(scan))
}

impl Frame<'_> {
    /// Returns the name of the channel and the unit.
    fn describe(&self) -> Result<(String, String)> {
        let channel = self.input.u8("channel", 52)?;
        let name = CHANNELS.split(',').nth(channel.into());
        let name = name.map_or_else(|| format!("channel {channel}"), str::to_owned);
        let code = self.input.i16("unit of z", 50)?;
        Ok((name, unit(code).map_or_else(|| format!("code {code}"), str::to_owned)))
    }

    fn scan(&self, chosen: &ChosenMap) -> Result<Scan> {
        let (input, at) = (self.input, self.shape_at);
        let (columns, rows) = (input.u16("columns", at + 2)?, input.u16("rows", at + 4)?);
        let (ny, nx) = input.shape(("rows", at + 4, rows), ("columns", at + 2, columns))?;
        let points = usize::from(input.u16("points of spectra", at + 6)?);
        let start = at + 8 + if points > 0 { 14 + 16 * points } else { 0 };
        let scale = |field, at| {
            let (offset, step) = (input.f32(field, at)?, input.f32(field, at + 4)?);
            let unit = unit(input.i16(field, at + 8)?);
            let or = |number: f32, default: f64| if number.is_finite() { f64::from(number) } else { default };
            Ok::<_, FormatError>((or(offset, 0.0), or(step, 1.0), unit))
        };
        let (offset, step, unit) = scale("scale of z", 42)?;
        let step = if step == 0.0 { 1.0 } else { step };
        let in_metre = |n| (offset + n * step) / chosen.per_metre;
        let heights_m = input.heights_upwards(chosen.name(), start, (ny, nx), Sample::I16, in_metre)?;
        let pitch = |field, at| scale(field, at).map(|(_, step, unit)| Some(step.abs() / unit.and_then(per_metre)?));
        let pitch_m = pitch("scale of x", 22)?.zip(pitch("scale of y", 32)?);
        let date = [8, 10, 12, 14, 16, 18].map(|at| input.u16("date", at).unwrap_or(0));
        let metadata = [("date".to_owned(), date::text(date))].into();
        Ok(Scan { height_unit: unit.map(str::to_owned), metadata, ..Scan::new(heights_m, pitch_m) })
    }
}

/// Returns the unit of length with this code.
fn unit(code: i16) -> Option<&'static str> {
    UNITS.get(usize::try_from(code.checked_add(5)?).ok()?).copied()
}
