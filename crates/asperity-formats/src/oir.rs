//! Olympus (Evident) OIR of the laser microscopes LEXT, and POIR, a zip archive of them.
//!
//! After a header of 96 bytes an OIR file is a list of chunks: a size and a kind (`i32`), and the content; the size −1 ends it. A list of
//! descriptions (kind 0) holds the XML `lsmimage:imageProperties`, which states the channels with their kinds and identifiers, the units
//! and steps of a stored 1 and of a pixel, and a calibration to multiply them with. A block of data (kind 3) has a head (a zero, the
//! number of bytes, a name that ends with the identifier of its channel and `_0`), once more the number of bytes, and a number 4;
//! the data follow after what the size counts.
//!
//! The vendor published no description. SurfaceTopography describes chunks and XML from files of instruments.

use std::borrow::Cow;

use crate::x3p::ZIP_MAGIC;
use crate::{
    Archive, Description, Document, Format, FormatError, Input, MAX_POINTS, ReadOptions, Result, Sample, Scan, Shape,
    per_metre, refuse_if, unique, warn_if,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["oir", "poir"],
    vendor: "Olympus (Evident)",
    known_by: "`OLYMPUSRAWFORMAT`, or a zip archive of files `.oir`",
    reads: "heights of laser scans, 8 and 16 bits",
    orientation: "the first stored line is row 0",
    ..Description::new(
        Format::Oir,
        |bytes| bytes.starts_with(MAGIC) || (bytes.starts_with(ZIP_MAGIC) && !packed_files(bytes).is_empty()),
        read,
    )
};

const MAGIC: &[u8] = b"OLYMPUSRAWFORMAT";
const HEADER_BYTES: usize = 96;
/// Kinds of chunks, and the size that ends their list.
const DESCRIPTIONS: i32 = 0;
const DATA: i32 = 3;
const END: i32 = -1;
/// Size in bytes of the head of a chunk, and of the numbers before the name of a block and before its data.
const HEAD_BYTES: usize = 8;
/// Start and end of the XML, and of a channel in it.
const XML: [&[u8]; 2] = [b"<lsmimage:imageProperties", b"</lsmimage:imageProperties>"];
const CHANNEL: [&str; 2] = ["<commonphase:channel ", "</commonphase:channel>"];
/// Largest number of channels, and of files in an archive.
const MAX_CHANNELS: usize = 64;
const MAX_FILES: usize = 64;
/// Largest size of the XML, and of an unpacked file.
const MAX_XML_BYTES: usize = 1 << 22;
const MAX_FILE_BYTES: u64 = 2 * MAX_POINTS + (1 << 26);

/// Map of heights: its place in the file and its units.
struct Map {
    id: String,
    shape: Shape,
    sample: Sample,
    unit: String,
    step_m: f64,
    pitch_m: Option<(f64, f64)>,
}

/// Reads the heights of a laser scan.
///
/// # Errors
/// Damaged archives, chunks beyond the end of the file, XML without a channel of heights, and blocks of another size.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    if bytes.starts_with(MAGIC) {
        let input = Input::new(Format::Oir, bytes);
        let maps = maps(input)?;
        let names = maps.iter().map(|_| "height".to_owned()).collect();
        return scan(input, maps, names, 0, options);
    }
    let mut archive = Archive::open(Format::Oir, bytes)?;
    let files = packed_files(bytes);
    let mut names = Vec::new();
    // One map per file: files of a camera hold none, and those of other channels are beside the heights in the same file.
    let mut first_error = None;
    for file in &files {
        let content = archive.read_whole(file, MAX_FILE_BYTES)?;
        match maps(Input::entry(Format::Oir, file, &content)) {
            Ok(maps) => names.extend(maps.iter().map(|_| file.clone())),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    refuse_if!(names.is_empty(), first_error.unwrap_or_else(|| no_heights(Input::new(Format::Oir, bytes))));
    let channel = options.choose(Format::Oir, &unique(names.clone()))?;
    let file = names[channel].clone();
    let before = names.iter().position(|name| *name == file).unwrap_or_default();
    let content = archive.read_whole(&file, MAX_FILE_BYTES)?;
    let input = Input::entry(Format::Oir, &file, &content);
    scan(input, maps(input)?, names, before, options)
}

/// Returns the names of the OIR files in a zip archive.
fn packed_files(bytes: &[u8]) -> Vec<String> {
    let archive = Archive::open(Format::Oir, bytes);
    let names = archive.map(|archive| archive.names().to_vec()).unwrap_or_default();
    names.into_iter().filter(|name| name.to_ascii_lowercase().ends_with(".oir")).take(MAX_FILES).collect()
}

/// Reads the chosen map of a file whose first map has the index `before` among `names`.
fn scan(input: Input<'_>, maps: Vec<Map>, names: Vec<String>, before: usize, options: &ReadOptions) -> Result<Scan> {
    let names = unique(names);
    let channel = options.choose(Format::Oir, &names)?;
    let map = &maps[channel - before];
    let mut data = None;
    for_each_chunk(input, |kind, _, block| {
        if let (DATA, Some((name, values))) = (kind, block) {
            let is_wanted = name.windows(map.id.len()).any(|part| part == map.id.as_bytes()) && name.ends_with(b"_0");
            data = data.or(is_wanted.then_some(values));
        }
    })?;
    let data = data.ok_or_else(|| input.missing("the block of heights", HEADER_BYTES, &format!("`…{}_0`", map.id)))?;
    let heights_m = data.heights("the heights", 0, map.shape, map.sample, |z| z * map.step_m)?;
    let mut scan = Scan { height_unit: Some(map.unit.clone()), ..Scan::new(heights_m, map.pitch_m) };
    warn_if!(scan.warnings, map.pitch_m.is_none(), "the lateral units are not of length; no pixel size was read");
    Ok(scan.with_channels(names, channel))
}

fn no_heights(input: Input<'_>) -> FormatError {
    input.unsupported("the file holds no heights", "a laser scan with a channel of heights")
}

/// Calls `visit` with the kind of each chunk, its content, and the name and the data of a block.
fn for_each_chunk<'a>(
    input: Input<'a>,
    mut visit: impl FnMut(i32, Input<'a>, Option<(&'a [u8], Input<'a>)>),
) -> Result<()> {
    let mut at = HEADER_BYTES;
    while at < input.len() {
        let size = input.i32("the size of a chunk", at)?;
        if size == END {
            break;
        }
        let kind = input.i32("the kind of a chunk", at + 4)?;
        let size = usize::try_from(size).map_err(|_| input.wrong("the size of a chunk", at, size, "0 or more"))?;
        let start = at + HEAD_BYTES;
        input.take("a chunk", start, size)?;
        at = start + size;
        let content = input.up_to(at).from(start);
        let block = if kind == DATA {
            let bytes = content.u32("the size of a block", 4)? as usize;
            let length = content.u32("the name of a block", 8)? as usize;
            let name = content.take("the name of a block", 12, length)?;
            input.take("a block", at, HEAD_BYTES + bytes)?;
            let values = input.up_to(at + HEAD_BYTES + bytes).from(at + HEAD_BYTES);
            at += HEAD_BYTES + bytes;
            Some((name, values))
        } else {
            None
        };
        visit(kind, content, block);
    }
    Ok(())
}

/// Returns the maps of heights.
fn maps(input: Input<'_>) -> Result<Vec<Map>> {
    let mut xml = None;
    for_each_chunk(input, |kind, content, _| {
        if kind == DESCRIPTIONS {
            xml = xml.or_else(|| between(content.bytes, XML));
        }
    })?;
    let Some(xml) = xml.filter(|xml| xml.len() <= MAX_XML_BYTES) else { return Err(no_heights(input)) };
    let document = Document::parse(Format::Oir, "imageProperties", xml, "")?;
    let shape = document.shape("imageInfo/height", "imageInfo/width")?;
    let text: Cow<'_, str> = String::from_utf8_lossy(xml);
    let mut maps = Vec::new();
    for channel in text.split(CHANNEL[0]).skip(1).take(MAX_CHANNELS) {
        let tag = channel.split('>').next().unwrap_or_default();
        let id = tag.split_once("id=\"").and_then(|(_, rest)| rest.split_once('"')).map_or("", |(id, _)| id);
        let content = channel.split(CHANNEL[1]).next().unwrap_or_default();
        let whole = format!("{}{content}{}", CHANNEL[0], CHANNEL[1]);
        let channel = Document::parse(Format::Oir, "channel", whole.as_bytes(), "")?;
        if channel.text("imageDefinition/imageType") == Some("HEIGHT") && !id.is_empty() {
            maps.push(map(&document, &channel, id, shape)?);
        }
    }
    if maps.is_empty() { Err(no_heights(input)) } else { Ok(maps) }
}

/// Returns the part of bytes from a start to an end, both included.
fn between<'a>(bytes: &'a [u8], [start, end]: [&[u8]; 2]) -> Option<&'a [u8]> {
    let find = |bytes: &[u8], word: &[u8]| bytes.windows(word.len()).position(|window| window == word);
    let bytes = &bytes[find(bytes, start)?..];
    Some(&bytes[..find(bytes, end)? + end.len()])
}

/// Returns the map that a channel describes.
fn map(document: &Document, channel: &Document, id: &str, shape: Shape) -> Result<Map> {
    // A stored 1 or a pixel in metre; `None` for a unit that is not one of length.
    let step = |axis: char| {
        let unit = channel.required(&format!("pixelUnit/{axis}"), "a unit")?;
        let path = format!("length/{axis}");
        let length = channel.number(&path)?.ok_or_else(|| channel.missing(&path, "a number"))?;
        let calibration = format!("acquisition/microscopeConfiguration/pixelCalibration/{axis}");
        let factor = document.number(&calibration)?.unwrap_or(1.0);
        Ok::<_, FormatError>((length * factor, unit.text.as_str()))
    };
    let in_metre = |(length, unit): (f64, &str)| per_metre(unit).map(|per_metre| length / per_metre);
    let z = step('z')?;
    let step_m = in_metre(z).ok_or_else(|| channel.wrong("pixelUnit/z", z.1, 0, "a unit of length"))?;
    let bytes = match channel.text("imageDefinition/depth") {
        Some(_) => channel.integer("imageDefinition/depth")?.0,
        None => channel.integer("imageDefinition/bitCounts")?.0.saturating_add(7) / 8,
    };
    let sample = match bytes {
        1 => Sample::U8,
        2 => Sample::U16,
        _ => return Err(channel.wrong("imageDefinition/depth", &bytes.to_string(), 0, "1 or 2")),
    };
    let pitch_m = in_metre(step('x')?).zip(in_metre(step('y')?));
    Ok(Map { id: id.to_owned(), shape, sample, unit: z.1.to_owned(), step_m, pitch_m })
}
