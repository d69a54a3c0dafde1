//! Cells of a sheet, with the texts that they share and the styles of dates.

use std::borrow::Cow;
use std::collections::HashSet;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::text::rows::Layout;
use crate::text::separator::Separator;
use crate::xml::{decode, fault, resolve};
use crate::{Archive, Format, FormatError, Location, ReadOptions, Result, refuse_if, shown};

const STRINGS: &str = "xl/sharedStrings.xml";
const STYLES: &str = "xl/styles.xml";
/// Maximum numbers of columns and rows of a sheet.
const MAX_COLUMNS: usize = 1 << 14;
const MAX_ROWS: usize = 1 << 20;
/// Maximum number of bytes of a text that cells share; Excel allows 32,767 characters.
const MAX_TEXT: usize = 1 << 16;
/// Name of columns with 0 or FALSE for heights that are missing.
pub(super) const VALID: &str = "valid";
/// Numbers of the formats of dates and times that need no code in the file.
const DATES: [std::ops::RangeInclusive<u32>; 4] = [14..=22, 27..=36, 45..=47, 50..=58];

/// Content of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A number or an error such as `#N/A`, which marks a missing number.
    Number,
    /// A text that is a number, perhaps with a decimal comma.
    NumberInText,
    Text,
}

/// Cell of a sheet; row and column count from 0.
pub(super) struct Cell<'a> {
    pub(super) row: usize,
    pub(super) column: usize,
    pub(super) text: &'a str,
    pub(super) kind: Kind,
    /// Offset of its end in the XML.
    pub(super) offset: u64,
}

/// What the sheets of a workbook have in common.
pub(super) struct Book {
    strings: Strings,
    /// Styles that show a number as a date; empty if none does.
    dates: Vec<bool>,
    /// Layout of a number in a text.
    layout: Layout,
}

impl Book {
    pub(super) fn read(archive: &mut Archive, options: &ReadOptions) -> Result<Self> {
        let layout = Layout::new(Format::Xlsx, Separator::Tab, &[], b'\n').with_decimal(options.decimal);
        Ok(Self { strings: strings(archive)?, dates: dates(archive)?, layout })
    }

    /// Returns text and content of a cell of a type. Truth values are numbers only in a column of valid heights, and dates never are.
    fn content<'a>(&self, kind: &str, text: &'a str, is_date: bool, is_valid: bool) -> (Cow<'a, str>, Kind) {
        let text = match kind {
            "b" if text == "0" => "FALSE",
            "b" => "TRUE",
            _ => text,
        };
        match kind {
            "" | "n" if is_date => (format!("date {text}").into(), Kind::Text),
            "" | "n" if !text.contains(',') => (text.into(), Kind::Number),
            "e" => ("#N/A".into(), Kind::Number),
            _ if is_valid && text.eq_ignore_ascii_case("true") => ("1".into(), Kind::Number),
            _ if is_valid && text.eq_ignore_ascii_case("false") => ("0".into(), Kind::Number),
            _ if self.layout.count(text.as_bytes()) == Some(1) => (text.into(), Kind::NumberInText),
            _ => (text.into(), Kind::Text),
        }
    }
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
    elements(STRINGS, &archive.read_whole(STRINGS, u64::MAX)?, |event, _| {
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

/// Returns which styles of cells show a number as a date; nothing if none does.
fn dates(archive: &mut Archive) -> Result<Vec<bool>> {
    let (mut custom, mut styles, mut is_of_cells) = (HashSet::new(), Vec::new(), false);
    if !archive.contains(STYLES) {
        return Ok(styles);
    }
    elements(STYLES, &archive.read_whole(STYLES, u64::MAX)?, |event, _| {
        let number = |start, name| attribute(start, name).and_then(|number| number.parse::<u32>().ok());
        match event {
            Part::Start("numFmt", start) if attribute(start, "formatCode").is_some_and(|code| shows_date(&code)) => {
                custom.extend(number(start, "numFmtId"));
            }
            Part::Start("cellXfs", _) => is_of_cells = true,
            Part::End("cellXfs") => is_of_cells = false,
            Part::Start("xf", start) if is_of_cells => {
                let is_date =
                    |number: u32| DATES.iter().any(|dates| dates.contains(&number)) || custom.contains(&number);
                styles.push(number(start, "numFmtId").is_some_and(is_date));
            }
            _ => (),
        }
        Ok(())
    })?;
    Ok(if styles.contains(&true) { styles } else { Vec::new() })
}

/// Returns whether the code of a format has letters of dates and times outside of quotes, brackets and escapes.
fn shows_date(code: &str) -> bool {
    let mut letters = code.chars();
    while let Some(letter) = letters.next() {
        let closing = match letter {
            '"' => Some('"'),
            '[' => Some(']'),
            _ => None,
        };
        if let Some(closing) = closing {
            letters.by_ref().find(|letter| *letter == closing);
        } else if matches!(letter, '\\' | '_' | '*') {
            letters.next();
        } else if matches!(letter.to_ascii_lowercase(), 'd' | 'm' | 'y' | 'h' | 's') {
            return true;
        }
    }
    false
}

/// Calls `take` with each cell of a sheet that has a value.
pub(super) fn cells(link: &str, xml: &[u8], book: &Book, mut take: impl FnMut(Cell) -> Result<()>) -> Result<()> {
    let wrong = |found: &str, offset: u64, wanted: &str| {
        FormatError::field(Format::Xlsx, "a cell", place(link, offset), shown(found), wanted)
    };
    // The next row, and the next cell in the present row.
    let (mut next_row, mut next) = (0, (0, 0));
    let (mut kind, mut value, mut is_value, mut is_date) = (String::new(), String::new(), false, false);
    let mut valid: HashSet<usize> = HashSet::new();
    elements(link, xml, |event, offset| {
        match event {
            Part::Start("row", start) => {
                let row = attribute(start, "r")
                    .map_or(Ok(next_row + 1), |r| r.parse().map_err(|_| wrong(&r, offset, "the number of a row")))?;
                refuse_if!(
                    row <= next_row || row > MAX_ROWS,
                    wrong(&row.to_string(), offset, "rows in their order, 1048576 at most")
                );
                (next_row, next) = (row, (row - 1, 0));
            }
            Part::Start("c", start) => {
                value.clear();
                kind = attribute(start, "t").unwrap_or_default();
                let style = || attribute(start, "s")?.parse::<usize>().ok();
                is_date = !book.dates.is_empty() && style().and_then(|style| book.dates.get(style)) == Some(&true);
                if let Some(name) = attribute(start, "r") {
                    let column = column(&name).filter(|column| (next.1..MAX_COLUMNS).contains(column));
                    next.1 = column.ok_or_else(|| wrong(&name, offset, "cells in the order of their columns"))?;
                }
            }
            Part::Start(name, _) => is_value = matches!(name, "v" | "t"),
            Part::Text(text) if is_value => value.push_str(text),
            Part::End("v" | "t") => is_value = false,
            Part::End("c") => {
                let shared = || value.parse::<usize>().ok().and_then(|place| book.strings.get(place));
                let text = if kind == "s" {
                    shared().ok_or_else(|| wrong(&value, offset, "the number of a shared text"))?
                } else {
                    &value
                };
                let text = text.trim();
                if !text.is_empty() {
                    let (row, column) = next;
                    refuse_if!(
                        column >= MAX_COLUMNS,
                        wrong(&(column + 1).to_string(), offset, "16384 columns at most")
                    );
                    let (text, kind) = book.content(&kind, text, is_date, valid.contains(&column));
                    if kind == Kind::Text && text.eq_ignore_ascii_case(VALID) {
                        valid.insert(column);
                    }
                    take(Cell { row, column, text: &text, kind, offset })?;
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
pub(super) enum Part<'a> {
    Start(&'a str, &'a BytesStart<'a>),
    Text(&'a str),
    End(&'a str),
}

/// Calls `visit` with the parts of an XML document and the offset of their end.
pub(super) fn elements(link: &str, xml: &[u8], mut visit: impl FnMut(Part, u64) -> Result<()>) -> Result<()> {
    let xml = decode(xml);
    let mut reader = Reader::from_str(&xml);
    reader.config_mut().expand_empty_elements = true;
    let mut depth = 0_usize;
    loop {
        let damaged =
            |reason: String, offset: u64| FormatError::Xml { format: Format::Xlsx, at: place(link, offset), reason };
        let event = reader.read_event();
        let offset = reader.buffer_position();
        match event {
            Err(error) => return Err(damaged(fault(&error), reader.error_position())),
            Ok(Event::Start(start)) => {
                depth += 1;
                visit(Part::Start(start.local_name().into_inner(), &start), offset)?;
            }
            Ok(Event::End(end)) => {
                depth -= 1;
                visit(Part::End(end.local_name().into_inner()), offset)?;
            }
            Ok(Event::Text(text)) => visit(Part::Text(&text.xml10_content()), offset)?,
            Ok(Event::CData(text)) => visit(Part::Text(&text.xml10_content()), offset)?,
            Ok(Event::GeneralRef(reference)) => {
                let unknown = || damaged(format!("the entity &{}; is unknown", shown(&reference)), offset);
                visit(Part::Text(&resolve(&reference).ok_or_else(unknown)?), offset)?;
            }
            Ok(Event::Eof) if depth == 0 => return Ok(()),
            Ok(Event::Eof) => {
                return Err(damaged("the document ends inside of an element".into(), offset));
            }
            Ok(_) => (),
        }
    }
}

/// Returns an attribute by its local name.
pub(super) fn attribute(start: &BytesStart, name: &str) -> Option<String> {
    let mut attributes = start.attributes().flatten();
    let found = attributes.find(|attribute| attribute.key.local_name().into_inner() == name)?;
    Some(found.normalized_value(XmlVersion::Implicit1_0).ok()?.into_owned())
}

pub(super) fn place(link: &str, offset: u64) -> Location {
    Location::Entry { entry: shown(link), offset }
}
