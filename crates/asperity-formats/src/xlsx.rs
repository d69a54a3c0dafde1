//! Excel workbooks, XLSX (ISO/IEC 29500, SpreadsheetML): a zip archive of sheets in XML.
//!
//! A sheet is read like a text with the same cells and tabs between them ([`crate::text`], [`crate::xyz`]): a matrix, a profile or a list
//! of points. The lines that errors name are the rows of the sheet. Texts in columns before the first column with a number become
//! comments. A sheet is refused if a column has less than half the numbers of another one: it contains several tables. The main sheet is
//! the one with the most numbers.
//!
//! Roughness testers of Mitutoyo fill a workbook with the sheets `Certificate` and `DATA`. Columns E and F of `DATA` are positions and
//! heights without units. They are read in the unit of the cut-off on the certificate and in that of the first parameter in column A.

use std::ops::RangeInclusive;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::archive::unpacked_limit;
use crate::x3p::ZIP_MAGIC;
use crate::xml::{decode, fault, resolve};
use crate::{
    Archive, Description, Format, FormatError, Location, ReadOptions, Result, Scan, Tested, per_metre, refuse_if,
    shown, text, unique, xyz,
};

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
const STRINGS: &str = "xl/sharedStrings.xml";
/// Type of the links to sheets of cells ends with this; charts have sheets of their own.
const WORKSHEET: &str = "/worksheet";
/// Maximum size of the workbook and of its links in bytes.
const MAX_INDEX_BYTES: u64 = 1 << 22;
/// Maximum number of sheets, and the numbers of columns and rows of a sheet.
const MAX_SHEETS: usize = 256;
const MAX_COLUMNS: usize = 1 << 14;
const MAX_ROWS: usize = 1 << 20;
/// Maximum number of bytes of a text that cells share; Excel allows 32,767 characters.
const MAX_TEXT: usize = 1 << 16;
/// Maximum size of the text of a sheet in bytes beyond three quarters of its XML. Empty cells and shared texts may take no bytes of XML.
const FREE_BYTES: usize = 1 << 21;
/// Sheets of Mitutoyo, and the columns of a profile.
const CERTIFICATE: &str = "Certificate";
const DATA: &str = "DATA";
const PROFILE: RangeInclusive<usize> = 4..=5;

fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(ZIP_MAGIC)
        && Archive::open(Format::Xlsx, bytes).is_ok_and(|archive| archive.names().iter().any(|name| name == WORKBOOK))
}

/// Cell of a sheet; row and column count from 0.
struct Cell<'a> {
    row: usize,
    column: usize,
    text: &'a str,
    is_number: bool,
}

/// Sheet: its name, its file, and the number of numbers in each column.
struct Sheet {
    name: String,
    link: String,
    counts: Vec<usize>,
}

/// Reads a sheet.
///
/// # Errors
/// Damaged archives and XML, sheets without numbers or of several tables, and the errors of a text with the same cells.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let mut archive = Archive::open(Format::Xlsx, bytes)?;
    let strings = strings(&mut archive)?;
    let (mut sheets, mut unit_x) = (Vec::new(), None);
    // All sheets together have the limit of one file: several may name the same file.
    let mut room = unpacked_limit(bytes.len() as u64);
    for (name, link) in links(&mut archive)? {
        let (mut counts, mut is_cut_off) = (Vec::new(), false);
        let xml = archive.read_whole(&link, room)?;
        room = room.saturating_sub(xml.len() as u64);
        cells(&link, &xml, &strings, |cell| {
            if cell.is_number {
                counts.resize(counts.len().max(cell.column + 1), 0);
                counts[cell.column] += 1;
            } else if name == CERTIFICATE
                && unit_x.is_none()
                && std::mem::replace(&mut is_cut_off, cell.text == "Cut-Off")
            {
                unit_x = Some(unit_at_end(cell.text));
            }
            Ok(())
        })?;
        if name == CERTIFICATE || !counts.is_empty() {
            sheets.push(Sheet { name, link, counts });
        }
    }
    let is_mitutoyo =
        sheets.iter().any(|sheet| sheet.name == CERTIFICATE) && sheets.iter().any(|sheet| sheet.name == DATA);
    sheets.retain(|sheet| !sheet.counts.is_empty());
    let numbers = |sheet: &Sheet| sheet.counts.iter().sum::<usize>();
    let none = || FormatError::unsupported(Format::Xlsx, "no sheet holds numbers", "a sheet of heights");
    let main = (0..sheets.len()).rev().max_by_key(|&place| numbers(&sheets[place])).ok_or_else(none)?;
    let names = unique(sheets.iter().map(|sheet| sheet.name.clone()).collect());
    // The channels of a single sheet are those of its text.
    let is_single = sheets.len() == 1;
    let chosen = if is_single { 0 } else { options.choose_or(Format::Xlsx, &names, Some(main))? };
    let Sheet { name, link, counts } = &sheets[chosen];
    let is_profile = is_mitutoyo && name == DATA;
    let columns = if is_profile { PROFILE } else { table(name, counts)? };
    let xml = archive.read_whole(link, u64::MAX)?;
    let mut table = as_text(link, &xml, &strings, columns, unit_x.flatten().filter(|_| is_profile))?;
    drop((xml, strings));
    table.push('\n');
    let inner = if is_single { options.clone() } else { ReadOptions { channel: None, ..options.clone() } };
    let is_points = (xyz::CODEC.detect)(table.as_bytes());
    let mut scan = (if is_points { xyz::CODEC.read } else { text::CODEC.read })(table.as_bytes(), &inner)?;
    if is_single {
        return Ok(scan);
    }
    if scan.channels.len() > 1 {
        let (count, read) = (scan.channels.len(), scan.channel_name().map(shown).unwrap_or_default());
        scan.warnings.push(format!("the sheet holds {count} columns of heights; `{read}` was read"));
    }
    Ok(scan.with_channels(names, chosen))
}

/// Returns the columns of the table in a sheet, from the number of numbers in each column.
fn table(name: &str, counts: &[usize]) -> Result<RangeInclusive<usize>> {
    let first = counts.iter().position(|&count| count > 0).unwrap_or_default();
    let most = counts.iter().copied().max().unwrap_or_default();
    if counts[first..].iter().any(|&count| 2 * count < most) {
        let found = format!("the columns of the sheet `{}` hold from few to {most} numbers", shown(name));
        return Err(FormatError::unsupported(
            Format::Xlsx,
            found,
            "one table per sheet; save the columns of the heights as CSV",
        ));
    }
    Ok(first..=counts.len() - 1)
}

/// Returns the text of a sheet: a line for each row, tabs between the cells of `columns`, and texts before them as comments at the end.
/// `unit_x` is the unit of the positions in a profile.
fn as_text(
    link: &str,
    xml: &[u8],
    strings: &Strings,
    columns: RangeInclusive<usize>,
    unit_x: Option<String>,
) -> Result<String> {
    let (mut table, mut comments, mut unit_z) = (String::new(), String::new(), None);
    let (first, last) = (*columns.start(), *columns.end());
    let (mut row, mut column) = (0, first);
    let limit = FREE_BYTES + 3 * xml.len() / 4;
    cells(link, xml, strings, |cell| {
        let text = || cell.text.replace(char::is_control, " ");
        if cell.column < first && !cell.is_number {
            unit_z = unit_z.take().or_else(|| unit_at_end(cell.text));
            comments.extend(["\n# ", &text()]);
        }
        if columns.contains(&cell.column) {
            while row < cell.row {
                // Cells without a value at the end of a row are not in the file.
                let is_empty = table.is_empty() || table.ends_with('\n');
                let missing = if is_empty { 0 } else { last - column };
                table.extend(std::iter::repeat_n('\t', missing).chain(['\n']));
                (row, column) = (row + 1, first);
            }
            table.extend(std::iter::repeat_n('\t', cell.column - column));
            column = cell.column;
            table.push_str(&text());
        }
        let length = table.len() + comments.len();
        let beyond = || {
            FormatError::too_large(
                Format::Xlsx,
                "the size of the text in bytes",
                place(link, 0),
                length as u64,
                limit as u64,
            )
        };
        refuse_if!(length > limit, beyond());
        Ok(())
    })?;
    let missing = if table.is_empty() { 0 } else { last - column };
    table.extend(std::iter::repeat_n('\t', missing));
    table.push_str(&comments);
    if let Some((x, z)) = unit_x.zip(unit_z) {
        table.extend(["\n# x unit: ", &x, "\n# value units: ", &z]);
    }
    Ok(table)
}

/// Returns the unit of length at the end of a text such as `0.08mm` or `Ra 0.018 µm`.
fn unit_at_end(text: &str) -> Option<String> {
    let unit = text.trim().trim_start_matches(|c: char| !c.is_ascii_digit());
    let unit = unit.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | ' '));
    per_metre(unit).map(|_| unit.to_owned())
}

/// Returns the names of the sheets and the files that hold them.
fn links(archive: &mut Archive) -> Result<Vec<(String, String)>> {
    let mut targets = Vec::new();
    elements(LINKS, &archive.read_whole(LINKS, MAX_INDEX_BYTES)?, |event| {
        if let Part::Start("Relationship", start) = event
            && attribute(start, "Type").is_some_and(|kind| kind.ends_with(WORKSHEET))
            && targets.len() < MAX_SHEETS
        {
            targets.extend(attribute(start, "Id").zip(attribute(start, "Target")));
        }
        Ok(())
    })?;
    let mut links = Vec::new();
    elements(WORKBOOK, &archive.read_whole(WORKBOOK, MAX_INDEX_BYTES)?, |event| {
        let Part::Start("sheet", start) = event else { return Ok(()) };
        let target = attribute(start, "id").and_then(|id| targets.iter().find(|(own, _)| *own == id));
        if let Some(((_, target), name)) = target.zip(attribute(start, "name")).filter(|_| links.len() < MAX_SHEETS) {
            let link = target.strip_prefix('/').map_or_else(|| format!("xl/{target}"), str::to_owned);
            links.push((name, link));
        }
        Ok(())
    })?;
    Ok(links)
}

/// Texts that cells share, one after another.
#[derive(Default)]
struct Strings {
    text: String,
    ends: Vec<usize>,
}

impl Strings {
    fn get(&self, place: usize) -> Option<&str> {
        let start = place.checked_sub(1).map_or(Some(&0), |before| self.ends.get(before))?;
        self.text.get(*start..*self.ends.get(place)?)
    }

    /// Adds a part of the last text, without blanks before it.
    fn push(&mut self, part: &str) {
        let length = self.text.len() - self.ends.last().unwrap_or(&0);
        let part = if length == 0 { part.trim_start() } else { part };
        self.text.push_str(&part[..part.floor_char_boundary(MAX_TEXT.saturating_sub(length))]);
    }

    /// Ends the last text, without blanks behind it.
    fn end(&mut self) {
        let start = *self.ends.last().unwrap_or(&0);
        self.text.truncate(start + self.text[start..].trim_end().len());
        self.ends.push(self.text.len());
    }
}

/// Returns the texts that cells share.
fn strings(archive: &mut Archive) -> Result<Strings> {
    let mut strings = Strings::default();
    if !archive.contains(STRINGS) {
        return Ok(strings);
    }
    // The pronunciation of a text is not a part of it.
    let (mut is_text, mut is_spoken) = (false, false);
    elements(STRINGS, &archive.read_whole(STRINGS, u64::MAX)?, |event| {
        match event {
            Part::Start("rPh", _) => is_spoken = true,
            Part::End("rPh") => is_spoken = false,
            Part::Start(name, _) => is_text = name == "t" && !is_spoken,
            Part::End("si") => strings.end(),
            Part::Text(text) if is_text => strings.push(text),
            _ => (),
        }
        Ok(())
    })?;
    Ok(strings)
}

/// Calls `take` with each cell of a sheet that has a value.
fn cells(link: &str, xml: &[u8], strings: &Strings, mut take: impl FnMut(Cell) -> Result<()>) -> Result<()> {
    let wrong =
        |found: &str, wanted: &str| FormatError::field(Format::Xlsx, "a cell", place(link, 0), shown(found), wanted);
    // The next row, and the next cell in the present row.
    let (mut next_row, mut next) = (0, (0, 0));
    let (mut kind, mut value, mut is_value) = (String::new(), String::new(), false);
    elements(link, xml, |event| {
        match event {
            Part::Start("row", start) => {
                let row = attribute(start, "r")
                    .map_or(Ok(next_row + 1), |r| r.parse().map_err(|_| wrong(&r, "the number of a row")))?;
                refuse_if!(
                    row <= next_row || row > MAX_ROWS,
                    wrong(&row.to_string(), "rows in their order, 1048576 at most")
                );
                (next_row, next) = (row, (row - 1, 0));
            }
            Part::Start("c", start) => {
                value.clear();
                kind = attribute(start, "t").unwrap_or_default();
                if let Some(name) = attribute(start, "r") {
                    let column = column(&name).filter(|column| (next.1..MAX_COLUMNS).contains(column));
                    next.1 = column.ok_or_else(|| wrong(&name, "cells in the order of their columns"))?;
                }
            }
            Part::Start(name, _) => is_value = matches!(name, "v" | "t"),
            Part::Text(text) if is_value => value.push_str(text),
            Part::End("v" | "t") => is_value = false,
            Part::End("c") => {
                let shared = || value.parse::<usize>().ok().and_then(|place| strings.get(place));
                let text = if kind == "s" {
                    shared().ok_or_else(|| wrong(&value, "the number of a shared text"))?
                } else {
                    &value
                };
                // Errors such as `#N/A` mark missing numbers.
                let is_number = matches!(kind.as_str(), "" | "n" | "e");
                if !text.trim().is_empty() {
                    take(Cell { row: next.0, column: next.1, text: text.trim(), is_number })?;
                }
                next.1 += 1;
            }
            _ => (),
        }
        Ok(())
    })
}

/// Returns the column in the name of a cell such as `AB12`, from 0.
fn column(name: &str) -> Option<usize> {
    let letters = name.bytes().take_while(u8::is_ascii_uppercase);
    letters.take(4).fold(0, |column, letter| 26 * column + usize::from(letter - b'@')).checked_sub(1)
}

/// Part of an XML document, with the local names of elements.
enum Part<'a> {
    Start(&'a str, &'a BytesStart<'a>),
    Text(&'a str),
    End(&'a str),
}

/// Calls `visit` with the parts of an XML document.
fn elements(link: &str, xml: &[u8], mut visit: impl FnMut(Part) -> Result<()>) -> Result<()> {
    let xml = decode(xml);
    let mut reader = Reader::from_str(&xml);
    reader.config_mut().expand_empty_elements = true;
    let mut depth = 0_usize;
    loop {
        let damaged =
            |reason: String, offset: u64| FormatError::Xml { format: Format::Xlsx, at: place(link, offset), reason };
        match reader.read_event() {
            Err(error) => return Err(damaged(fault(&error), reader.error_position())),
            Ok(Event::Start(start)) => {
                depth += 1;
                visit(Part::Start(start.local_name().into_inner(), &start))?;
            }
            Ok(Event::End(end)) => {
                depth -= 1;
                visit(Part::End(end.local_name().into_inner()))?;
            }
            Ok(Event::Text(text)) => visit(Part::Text(&text.xml10_content()))?,
            Ok(Event::GeneralRef(reference)) => {
                let unknown =
                    || damaged(format!("the entity &{}; is unknown", shown(&reference)), reader.buffer_position());
                visit(Part::Text(&resolve(&reference).ok_or_else(unknown)?))?;
            }
            Ok(Event::Eof) if depth == 0 => return Ok(()),
            Ok(Event::Eof) => {
                return Err(damaged("the document ends inside of an element".into(), reader.buffer_position()));
            }
            Ok(_) => (),
        }
    }
}

/// Returns an attribute by its local name.
fn attribute(start: &BytesStart, name: &str) -> Option<String> {
    let mut attributes = start.attributes().flatten();
    let found = attributes.find(|attribute| attribute.key.local_name().into_inner() == name)?;
    Some(found.normalized_value(XmlVersion::Implicit1_0).ok()?.into_owned())
}

fn place(link: &str, offset: u64) -> Location {
    Location::Entry { entry: shown(link), offset }
}
