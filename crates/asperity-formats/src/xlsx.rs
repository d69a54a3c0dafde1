//! Excel workbooks, XLSX (ISO/IEC 29500, SpreadsheetML): a zip archive of sheets in XML.
//!
//! A sheet is read like a text with the same cells and tabs between them ([`crate::text`], [`crate::xyz`]): a matrix, a profile or a list
//! of points. The lines that errors name are the rows of the sheet. Texts above, below and left of the numbers become comments, and so do
//! rows above the table that start with a text and hold at most two numbers. A sheet of several tables is refused: see [`table`]. Texts
//! that are numbers count as such. Dates and truth values do not, except for truth values in a column `valid`. The main sheet is the
//! visible one with the most numbers.
//!
//! Roughness testers of Mitutoyo fill a workbook with the sheets `Certificate` and `DATA`. Columns E and F of `DATA` are positions and
//! heights without units. They are read in the unit of the cut-off on the certificate and in that of the first parameter in column A.

mod cells;
mod table;

use std::ops::RangeInclusive;

use crate::archive::unpacked_limit;
use crate::x3p::ZIP_MAGIC;
use crate::{
    Archive, Description, Format, FormatError, ReadOptions, Result, Scan, Tested, per_metre, shown, text, unique, xyz,
};
use cells::{Book, Kind, Part, attribute, cells, elements};
use table::{Places, Table};

pub(crate) const CODEC: Description = Description {
    extensions: &["xlsx"],
    vendor: "Microsoft; Mitutoyo",
    known_by: "zip archive with xl/workbook.xml",
    reads: "sheets of one table, as text with the same cells; profiles of Mitutoyo roughness testers",
    missing_points: "as in text",
    orientation: "the first row is row 0",
    tested: Tested::OtherPrograms,
    ..Description::new(Format::Xlsx, detect, read)
};

const WORKBOOK: &str = "xl/workbook.xml";
const LINKS: &str = "xl/_rels/workbook.xml.rels";
/// Type of the links to sheets of cells ends with this; charts have sheets of their own.
const WORKSHEET: &str = "/worksheet";
/// Maximum size of the workbook and of its links in bytes.
const MAX_INDEX_BYTES: u64 = 1 << 22;
/// Maximum number of sheets.
const MAX_SHEETS: usize = 256;
/// Sheets of Mitutoyo, and the columns of a profile.
const CERTIFICATE: &str = "Certificate";
const DATA: &str = "DATA";
const PROFILE: RangeInclusive<usize> = 4..=5;

fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(ZIP_MAGIC)
        && Archive::open(Format::Xlsx, bytes).is_ok_and(|archive| archive.names().iter().any(|name| name == WORKBOOK))
}

/// Sheet of cells.
struct Sheet {
    name: String,
    /// File that holds the cells.
    link: String,
    is_hidden: bool,
    places: Places,
}

/// Reads a sheet.
///
/// # Errors
/// Damaged archives and XML, sheets without numbers or of several tables, and the errors of a text with the same cells.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let mut archive = Archive::open(Format::Xlsx, bytes)?;
    let book = Book::read(&mut archive, options)?;
    let mut sheets = sheets(&mut archive)?;
    let mut unit_x = None;
    // All sheets together have the limit of one file: several may name the same file.
    let mut room = unpacked_limit(bytes.len() as u64);
    for Sheet { name, link, places, .. } in &mut sheets {
        let xml = archive.read_whole(link, room)?;
        room = room.saturating_sub(xml.len() as u64);
        let mut is_cut_off = false;
        cells(link, &xml, &book, |cell| {
            if cell.kind == Kind::Text
                && name == CERTIFICATE
                && unit_x.is_none()
                && std::mem::replace(&mut is_cut_off, cell.text == "Cut-Off")
            {
                unit_x = Some(unit_at_end(cell.text));
            }
            places.add(&cell);
            Ok(())
        })?;
    }
    let is_mitutoyo = [CERTIFICATE, DATA].iter().all(|name| sheets.iter().any(|sheet| sheet.name == *name));
    sheets.retain(|sheet| sheet.places.count() > 0);
    let none = || FormatError::unsupported(Format::Xlsx, "no sheet holds numbers", "a sheet of heights");
    let rank = |place: &usize| (!sheets[*place].is_hidden, sheets[*place].places.count());
    let main = (0..sheets.len()).rev().max_by_key(rank).ok_or_else(none)?;
    let names = unique(sheets.iter().map(|sheet| sheet.name.clone()).collect());
    // The channels of a single sheet are those of its text.
    let is_single = sheets.len() == 1;
    let chosen = if is_single { 0 } else { options.choose_or(Format::Xlsx, &names, Some(main))? };
    let Sheet { name, link, places, .. } = &sheets[chosen];
    let is_profile = is_mitutoyo && name == DATA;
    let decimal = places.decimal(options)?;
    let table = if is_profile { Table::of_tester(PROFILE) } else { places.table(name)? };
    let xml = archive.read_whole(link, u64::MAX)?;
    let mut text = table.as_text(link, &xml, &book, decimal, unit_x.flatten().filter(|_| is_profile))?;
    drop((xml, book));
    text.push('\n');
    let channel = options.channel.clone().filter(|_| is_single);
    let inner = ReadOptions { channel, decimal, ..options.clone() };
    let is_points = (xyz::CODEC.detect)(text.as_bytes());
    let mut scan = (if is_points { xyz::CODEC.read } else { text::CODEC.read })(text.as_bytes(), &inner)?;
    scan.warnings.extend(table.warnings);
    if is_single {
        return Ok(scan);
    }
    if scan.channels.len() > 1 {
        let (count, read) = (scan.channels.len(), scan.channel_name().map(shown).unwrap_or_default());
        scan.warnings.push(format!("the sheet holds {count} columns of heights; `{read}` was read"));
    }
    Ok(scan.with_channels(names, chosen))
}

/// Returns the unit of length at the end of a text such as `0.08mm` or `Ra 0.018 µm`.
fn unit_at_end(text: &str) -> Option<String> {
    let unit = text.trim().trim_start_matches(|c: char| !c.is_ascii_digit());
    let unit = unit.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | ' '));
    per_metre(unit).map(|_| unit.to_owned())
}

/// Returns the sheets, without their cells.
fn sheets(archive: &mut Archive) -> Result<Vec<Sheet>> {
    let mut targets = Vec::new();
    elements(LINKS, &archive.read_whole(LINKS, MAX_INDEX_BYTES)?, |event, _| {
        if let Part::Start("Relationship", start) = event
            && attribute(start, "Type").is_some_and(|kind| kind.ends_with(WORKSHEET))
            && targets.len() < MAX_SHEETS
        {
            targets.extend(attribute(start, "Id").zip(attribute(start, "Target")));
        }
        Ok(())
    })?;
    let mut sheets = Vec::new();
    elements(WORKBOOK, &archive.read_whole(WORKBOOK, MAX_INDEX_BYTES)?, |event, _| {
        let Part::Start("sheet", start) = event else { return Ok(()) };
        let target = attribute(start, "id").and_then(|id| targets.iter().find(|(own, _)| *own == id));
        if let Some(((_, target), name)) = target.zip(attribute(start, "name")).filter(|_| sheets.len() < MAX_SHEETS) {
            let link = target.strip_prefix('/').map_or_else(|| format!("xl/{target}"), str::to_owned);
            let is_hidden = attribute(start, "state").is_some_and(|state| state != "visible");
            sheets.push(Sheet { name, link, is_hidden, places: Places::default() });
        }
        Ok(())
    })?;
    Ok(sheets)
}
