//! Keyence CSV: lines of a key, its value and perhaps a unit, then `Height` alone on a line, and the heights.
//!
//! The programs write keys in the language of their user; English and German are known. All cells are quoted in some versions.
//!
//! The vendor published no description. The converter of the Austrian metrology institute (BEV) and files that others describe agree.

use crate::text::rows::{self, Layout};
use crate::text::separator::Separator;
use crate::{
    Description, Format, FormatError, Input, MAX_TEXT_BYTES, ReadOptions, Result, Scan, large, per_metre, refuse_if,
    utf8_or_latin1, warn_if,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["csv"],
    vendor: "Keyence",
    known_by: "`ImageDataCsv`",
    reads: "heights; keys in English or German",
    missing_points: "empty cells",
    orientation: "the first line is row 0, as in the VK-Analyzer's pictures",
    ..Description::new(Format::KeyenceCsv, detect, read)
};

/// Number of bytes in which the words of a header are looked for: its type, or two keys of files without one.
const PROBE_BYTES: usize = 4096;
const TYPE: &str = "imagedatacsv";
const WORDS: [&str; 2] = ["xy calibration", "output image data"];
/// Keys in the languages that are known.
const PITCH: [&str; 2] = ["XY Calibration", "XY-Justierung"];
const COLUMNS: [&str; 2] = ["Horizontal", "Horizont."];
const ROWS: [&str; 2] = ["Vertical", "Vertikal"];
const UNIT: [&str; 2] = ["Unit", "Einheit"];
const CONTENT: [&str; 2] = ["Output image data", "Bilddatenausg."];
const HEIGHT: [&str; 2] = ["Height", "Höhe"];

fn detect(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(PROBE_BYTES)];
    // The line ends of text, and no other control characters.
    let is_text = start.iter().all(|byte| !byte.is_ascii_control() || byte.is_ascii_whitespace());
    let start = if is_text { utf8_or_latin1(start).to_ascii_lowercase() } else { String::new() };
    start.contains(TYPE) || WORDS.iter().all(|word| start.contains(word))
}

/// Reads the heights.
///
/// # Errors
/// Another quantity than heights, keys of another language, and lines of other lengths than declared.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::KeyenceCsv, bytes);
    let (mut at, mut lines) = (0, 0);
    let mut header: Vec<Vec<String>> = Vec::new();
    let separator = Separator::detect(bytes.split(|&byte| byte == b'\n').next().unwrap_or_default(), None);
    loop {
        let rest = &bytes[at..bytes.len().min(MAX_TEXT_BYTES)];
        let end = rest.iter().position(|&byte| byte == b'\n');
        let end = end.ok_or_else(|| input.missing("the heights", at, "a line `Height` before them"))?;
        let line = utf8_or_latin1(&rest[..end]);
        (at, lines) = (at + end + 1, lines + 1);
        let cells: Vec<String> =
            line.split(char::from(separator.sign())).map(|cell| cell.trim().trim_matches('"').to_owned()).collect();
        if cells.iter().skip(1).all(String::is_empty) && HEIGHT.contains(&cells[0].as_str()) {
            break;
        }
        header.push(cells);
    }
    let cells = |keys: [&str; 2]| header.iter().find(|cells| keys.contains(&cells[0].as_str()));
    let value = |keys: [&str; 2]| {
        let value = cells(keys).and_then(|cells| cells.get(1)).map(String::as_str);
        value.ok_or_else(|| input.missing(keys[0], 0, "a line with this key in English or German"))
    };
    let wrong = |keys: [&str; 2], wanted: &str| input.wrong(keys[0], 0, value(keys).unwrap_or_default(), wanted);
    refuse_if!(!HEIGHT.contains(&value(CONTENT)?), wrong(CONTENT, "Height"));
    let size = |keys: [&'static str; 2]| {
        Ok::<_, FormatError>((keys[0], 0, value(keys)?.parse::<u64>().map_err(|_| wrong(keys, "a whole number"))?))
    };
    let (ny, nx) = input.shape(size(ROWS)?, size(COLUMNS)?)?;
    let unit = value(UNIT)?;
    let units = per_metre(unit).ok_or_else(|| wrong(UNIT, "a unit of length"))?;

    let unquoted: Vec<u8>;
    let mut table = &bytes[at..];
    if table.contains(&b'"') {
        unquoted = table.iter().copied().filter(|&byte| byte != b'"').collect();
        table = &unquoted;
    }
    let layout = Layout::new(Format::KeyenceCsv, separator, b"", b'\n').with_columns(nx).with_decimal(options.decimal);
    let read = rows::read(table, &layout, lines)?;
    let mut heights = read.values;
    if heights.len() != ny * nx {
        return Err(input.wrong("number of lines of heights", at, heights.len() / nx, &ny.to_string()));
    }
    large::map(&mut heights, |z| z / units);
    let heights_m = input.matrix(COLUMNS[0], 0, (ny, nx), heights)?;
    let mut scan = Scan { height_unit: Some(unit.to_owned()), ..Scan::new(heights_m, None) };
    let pitch = cells(PITCH).and_then(|cells| {
        let pitch: f64 = cells.get(1)?.replace(',', ".").parse().ok()?;
        Some(pitch / per_metre(cells.get(2)?)?)
    });
    scan.pitch_m = pitch.map(|pitch| (pitch, pitch));
    warn_if!(scan.warnings, pitch.is_none(), "the file states no length for `XY Calibration`; no pixel size was read");
    for cells in header.iter().filter(|cells| cells.len() > 1) {
        scan.metadata.insert(cells[0].clone(), cells[1..].join(" ").trim().to_owned());
    }
    Ok(scan)
}
