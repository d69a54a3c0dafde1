//! Rows of numbers in lines of text, parsed from the bytes without copying fields.
//!
//! Long texts are cut at line ends and parsed in parallel. The result does not depend on the number of pieces.

use rayon::prelude::*;

use crate::text::decimal::{Decimal, is_ambiguous, with_comma};
use crate::text::field::{NO_DATA, missing, number, special_number, spreadsheet_error};
use crate::text::separator::{COMMENT, Separator};
use crate::{Format, FormatError, Location, MAX_POINTS, Result, TextLimit, large, utf8_or_latin1};

/// Size in bytes below which another thread costs more time than it saves.
const BYTES_PER_THREAD: usize = 1 << 20;
/// Number of pieces above which memory access limits the speed.
const MAX_PIECES: usize = 8;
/// Number of samples of a long text that estimate the number of values, and their size in bytes.
const SAMPLES: usize = 8;
const SAMPLE_BYTES: usize = 1 << 12;

/// Class of a byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Class {
    Other,
    Blank,
    Separator,
    Comment,
    LineEnd,
}

/// Layout of numbers in a text.
pub(crate) struct Layout {
    format: Format,
    separator: Separator,
    line_end: u8,
    /// Number of values per row; `None` if line ends have no meaning.
    columns: Option<usize>,
    /// Decimal sign, if it is stated.
    decimal: Option<Decimal>,
    /// Characters that start a comment.
    comment: &'static [u8],
    classes: [Class; 256],
}

impl Layout {
    pub(crate) fn new(format: Format, separator: Separator, comment: &'static [u8], line_end: u8) -> Self {
        let mut classes = [Class::Other; 256];
        for blank in *b" \t\r\x0c" {
            classes[usize::from(blank)] = Class::Blank;
        }
        if separator != Separator::Space {
            classes[usize::from(separator.sign())] = Class::Separator;
        }
        for &sign in comment {
            classes[usize::from(sign)] = Class::Comment;
        }
        classes[usize::from(line_end)] = Class::LineEnd;
        Self { format, separator, line_end, columns: None, decimal: None, comment, classes }
    }

    /// Returns the number of values per row; `None` if line ends have no meaning.
    pub(crate) fn columns(&self) -> Option<usize> {
        self.columns
    }

    /// Sets the number of values per row.
    pub(crate) fn with_columns(self, columns: usize) -> Self {
        Self { columns: Some(columns), ..self }
    }

    /// Sets the decimal sign that the user or the file states.
    pub(crate) fn with_decimal(self, decimal: Option<Decimal>) -> Self {
        Self { decimal, ..self }
    }

    /// Returns the number of values in the first line of `bytes`; `None` if a field is not a value.
    pub(crate) fn count(&self, bytes: &[u8]) -> Option<usize> {
        let (count, line) = self.tally(bytes);
        line.is_ok().then_some(count)
    }

    /// Counts the values before the first fault of a line. Too few columns are a fault.
    fn tally(&self, bytes: &[u8]) -> (usize, Result<(), Fault>) {
        let mut table = Table::default();
        let line = Scanner { kept: 0, ..Scanner::new(bytes, self) }.line(&mut table);
        (table.found, line)
    }

    /// Returns whether the first field of a line is a value.
    pub(crate) fn starts_with_value(&self, line: &[u8]) -> bool {
        let mut scanner = Scanner::new(line, self);
        scanner.skip_blanks();
        !scanner.is_at_end() && scanner.field(&mut Table::default()).is_some()
    }
}

/// Parsed rows.
#[derive(Default)]
pub(crate) struct Table {
    /// All values, row by row; NaN for missing ones.
    pub(crate) values: Vec<f64>,
    pub(crate) rows: usize,
    /// Number of times that blank lines divide rows.
    pub(crate) gaps: usize,
    /// Whether blank lines divide the first row from the second.
    pub(crate) is_first_divided: bool,
    /// Whether a blank line precedes the first row, and whether one follows the last row.
    starts_blank: bool,
    blank: bool,
    /// Number of rows that end with a separator.
    pub(crate) open_rows: usize,
    /// Comments between and after the rows, without their signs.
    pub(crate) comments: Vec<String>,
    /// Whether a number has a decimal comma, and whether the comma of one cannot separate thousands.
    pub(crate) decimal_comma: bool,
    is_certain: bool,
    /// Limit of further comments.
    room: TextLimit,
    lines: usize,
    /// Number of values of the present line.
    found: usize,
}

/// Fault of a line.
enum Fault {
    Value { column: usize, found: String },
    Ragged { found: usize },
    TooMany,
}

/// Reads all rows of `bytes`, which start after `lines_before` lines.
///
/// # Errors
/// A field that is not a number, a row of another length than in the layout, or too many values, each with its line. Commas that may be
/// decimal signs or separate thousands, if the layout does not state the decimal sign.
pub(crate) fn read(bytes: &[u8], layout: &Layout, lines_before: usize) -> Result<Table> {
    let wanted = (bytes.len() / BYTES_PER_THREAD).min(MAX_PIECES);
    // A query for the number of threads starts them, which takes longer than reading a short text.
    let pieces = cut(bytes, layout.line_end, if wanted > 1 { wanted.min(rayon::current_num_threads()) } else { 1 });
    let per_byte = values_per_byte(bytes, layout);
    let results: Vec<_> = pieces
        .par_iter()
        .enumerate()
        .map(|(place, piece)| {
            // The other pieces are appended to the first.
            let length = if place == 0 { bytes.len() } else { piece.len() };
            read_piece(piece, layout, (length as f64 * per_byte) as usize)
        })
        .collect();
    let mut table = Table::default();
    for result in results {
        let line = |lines: usize| lines_before + table.lines + lines + 1;
        let piece = result.map_err(|(lines, fault)| layout.error(fault, line(lines)))?;
        if (table.values.len() + piece.values.len()) as u64 > MAX_POINTS {
            return Err(layout.error(Fault::TooMany, line(0)));
        }
        table.append(piece);
    }
    let at = |line: usize| Location::Line(lines_before + line + 1);
    if table.decimal_comma && !table.is_certain && layout.decimal.is_none() {
        let (line, found) = first_comma(bytes, layout).unwrap_or_default();
        return Err(FormatError::AmbiguousDecimal { format: layout.format, at: at(line), found });
    }
    let is_comma = table.decimal_comma || layout.decimal == Some(Decimal::Comma);
    match is_comma.then(|| line_with_point(bytes, layout)).flatten() {
        Some(line) => {
            let wanted = "a comma, as stated or in other numbers of the file";
            Err(FormatError::field(layout.format, "a decimal sign", at(line), ".", wanted))
        }
        None => Ok(table),
    }
}

/// Returns the lines without their comments.
fn lines<'a>(bytes: &'a [u8], layout: &'a Layout) -> impl Iterator<Item = &'a [u8]> {
    bytes.split(|&byte| byte == layout.line_end).map(|line| {
        let starts = |(place, &byte): (usize, &u8)| {
            layout.classes[usize::from(byte)] == Class::Comment && spreadsheet_error(&line[place..]).is_none()
        };
        &line[..line.iter().enumerate().position(starts).unwrap_or(line.len())]
    })
}

/// Returns the first line with a point.
fn line_with_point(bytes: &[u8], layout: &Layout) -> Option<usize> {
    lines(bytes, layout).position(|line| line.contains(&b'.'))
}

/// Returns the first line with a comma, and the number of the comma.
fn first_comma(bytes: &[u8], layout: &Layout) -> Option<(usize, String)> {
    let number = |line: &[u8]| {
        let mut fields = line.split(|&byte| layout.classes[usize::from(byte)] != Class::Other);
        fields.find(|field| field.contains(&b',')).map(utf8_or_latin1)
    };
    lines(bytes, layout).enumerate().find_map(|(line, text)| Some((line, number(text)?)))
}

/// Cuts bytes into pieces of similar length that end with a line.
fn cut(bytes: &[u8], line_end: u8, count: usize) -> Vec<&[u8]> {
    let (mut pieces, mut rest) = (Vec::new(), bytes);
    for left in (2..=count).rev() {
        let (start, line) = rest.split_at(rest.len() / left);
        let length = start.len() + line.iter().position(|&byte| byte == line_end).map_or(line.len(), |place| place + 1);
        let (piece, after) = rest.split_at(length);
        pieces.push(piece);
        rest = after;
    }
    pieces.push(rest);
    pieces
}

/// Estimates the number of values per byte from samples, with a margin; at most 1.
fn values_per_byte(bytes: &[u8], layout: &Layout) -> f64 {
    let is_border = |&byte: &u8| layout.classes[usize::from(byte)] != Class::Other;
    let samples = if bytes.len() > SAMPLES * SAMPLE_BYTES { SAMPLES } else { 1 };
    let (mut values, mut length) = (0, 0);
    for start in (0..samples).map(|sample| bytes.len() / samples * sample) {
        let sample = &bytes[start..bytes.len().min(start + SAMPLE_BYTES)];
        length += sample.len();
        // Fields that the sample cuts are left out.
        let first = if start == 0 { Some(0) } else { sample.iter().position(is_border) };
        let end = sample.iter().rposition(is_border);
        let whole = first.zip(end).and_then(|(first, end)| sample.get(first..end)).unwrap_or_default();
        values += whole.split(|&byte| byte == layout.line_end).map(|line| layout.tally(line).0).sum::<usize>();
    }
    (1.01 * values as f64 / length.max(1) as f64).min(1.0)
}

fn read_piece(bytes: &[u8], layout: &Layout, expected: usize) -> Result<Table, (usize, Fault)> {
    let mut scanner = Scanner::new(bytes, layout);
    let mut table = Table { values: large::with_capacity(expected + 1), ..Table::default() };
    while scanner.cursor < bytes.len() {
        scanner.line(&mut table).map_err(|fault| (table.lines, fault))?;
        scanner.cursor += 1;
        table.lines += 1;
    }
    Ok(table)
}

impl Table {
    /// Adds a value to the present line and stores it if it is one of the first `kept`.
    fn push(&mut self, value: f64, kept: usize) {
        self.found += 1;
        if self.found <= kept {
            self.values.push(value);
        }
    }

    fn append(&mut self, piece: Self) {
        if self.values.is_empty() {
            self.values = piece.values;
        } else {
            self.values.extend_from_slice(&piece.values);
        }
        let is_blank = self.blank || piece.starts_blank;
        if piece.rows > 0 {
            self.gaps += piece.gaps + usize::from(is_blank && self.rows > 0);
            self.is_first_divided |= is_blank && self.rows == 1 || self.rows == 0 && piece.is_first_divided;
            self.starts_blank |= is_blank && self.rows == 0;
        }
        self.blank = if piece.rows > 0 { piece.blank } else { is_blank || piece.blank };
        self.rows += piece.rows;
        self.open_rows += piece.open_rows;
        self.decimal_comma |= piece.decimal_comma;
        self.is_certain |= piece.is_certain;
        self.lines += piece.lines;
        for comment in piece.comments {
            if self.room.take(comment.len()) {
                self.comments.push(comment);
            }
        }
    }
}

/// Position in a text.
struct Scanner<'a> {
    bytes: &'a [u8],
    cursor: usize,
    layout: &'a Layout,
    /// Number of values of a line that are stored. Further ones are counted only, because a line that is refused may be long.
    kept: usize,
}

impl<'a> Scanner<'a> {
    fn new(bytes: &'a [u8], layout: &'a Layout) -> Self {
        Self { bytes, cursor: 0, layout, kept: layout.columns.unwrap_or(usize::MAX) }
    }

    fn class_at(&self, place: usize) -> Class {
        self.bytes.get(place).map_or(Class::LineEnd, |&byte| self.layout.classes[usize::from(byte)])
    }

    fn class(&self) -> Class {
        self.class_at(self.cursor)
    }

    fn skip_blanks(&mut self) {
        while self.class() == Class::Blank {
            self.cursor += 1;
        }
    }

    /// Returns whether a row ends here.
    fn is_at_end(&self) -> bool {
        match self.class() {
            Class::LineEnd => true,
            Class::Comment => spreadsheet_error(&self.bytes[self.cursor..]).is_none(),
            _ => false,
        }
    }

    /// Parses one line up to its end.
    fn line(&mut self, table: &mut Table) -> Result<(), Fault> {
        table.found = 0;
        self.skip_blanks();
        let start = self.cursor;
        while !self.is_at_end() {
            let Some(value) = self.field(table) else {
                return Err(Fault::Value { column: table.found + 1, found: utf8_or_latin1(self.whole_field()) });
            };
            table.push(value, self.kept);
            if self.class() == Class::Separator {
                self.cursor += 1;
                self.skip_blanks();
                if self.is_at_end() {
                    table.push(f64::NAN, self.kept);
                    table.open_rows += 1;
                }
            }
        }
        if self.class() == Class::Comment {
            let rest = &self.bytes[self.cursor..];
            let length = rest.iter().position(|&byte| byte == self.layout.line_end).unwrap_or(rest.len());
            if table.room.is_left() {
                let comment = comment(&rest[..length], self.layout.comment);
                table.room.take(comment.len());
                table.comments.push(comment);
            }
            self.cursor += length;
        }
        let found = table.found;
        if found > 0 {
            table.gaps += usize::from(table.blank && table.rows > 0);
            table.is_first_divided |= table.blank && table.rows == 1;
            table.starts_blank |= table.blank && table.rows == 0;
            table.blank = false;
            table.rows += 1;
        } else {
            // A comment alone is no blank line.
            table.blank |= self.cursor == start;
        }
        match self.layout.columns {
            Some(columns) if found > 0 && found != columns => Err(Fault::Ragged { found }),
            _ if table.values.len() as u64 > MAX_POINTS => Err(Fault::TooMany),
            _ => Ok(()),
        }
    }

    /// Parses the value at the cursor and moves the cursor to the next separator or field. Returns NaN for a missing
    /// value; `None` if the field is not a number or is beyond the range of `f64`.
    fn field(&mut self, table: &mut Table) -> Option<f64> {
        let rest = &self.bytes[self.cursor..];
        let is_one = |length: &usize| self.layout.separator != Separator::Comma || !rest[..*length].contains(&b',');
        if let Some(length) = special_number(rest).filter(is_one) {
            self.cursor += length;
            self.skip_blanks();
            return Some(f64::NAN);
        }
        if let Ok((value, length)) = fast_float2::parse_partial::<f64, _>(rest)
            && !value.is_infinite()
        {
            let end = self.cursor + length;
            let mut next = end;
            while self.class_at(next) == Class::Blank {
                next += 1;
            }
            let ended = self.class_at(next) != Class::Other || self.layout.separator == Separator::Space && next > end;
            if ended {
                self.cursor = next;
                return Some(value);
            }
        }
        let field = self.whole_field();
        let value = if missing(field) {
            f64::NAN
        } else if let Some(value) = number(field) {
            value
        } else {
            let value = self.with_comma(field)?;
            table.decimal_comma |= self.layout.decimal != Some(Decimal::Point);
            table.is_certain = table.is_certain || !is_ambiguous(field);
            value
        };
        self.cursor += field.len();
        self.skip_blanks();
        Some(value)
    }

    /// Returns the bytes up to the end of the field at the cursor.
    fn whole_field(&self) -> &[u8] {
        let rest = &self.bytes[self.cursor..];
        let spaced = self.layout.separator == Separator::Space;
        // The words `No Data` are always one field.
        let ends = |&byte: &u8| match self.layout.classes[usize::from(byte)] {
            Class::Blank => spaced,
            class => class != Class::Other,
        };
        let words = rest.get(..NO_DATA.len()).filter(|words| words.eq_ignore_ascii_case(NO_DATA));
        if let Some(words) = words.filter(|_| self.class_at(self.cursor + NO_DATA.len()) != Class::Other) {
            return words;
        }
        if let Some(error) = spreadsheet_error(rest) {
            return error;
        }
        let length = rest.iter().position(ends).unwrap_or(rest.len());
        rest[..length].trim_ascii_end()
    }

    /// Parses a number such as `1,5`. Without a stated decimal sign, a single column without separators could also be two columns, which is
    /// refused.
    fn with_comma(&self, field: &[u8]) -> Option<f64> {
        let Layout { separator, columns, decimal, .. } = *self.layout;
        let is_single = separator == Separator::Space && columns == Some(1);
        if separator == Separator::Comma || decimal.is_none() && is_single {
            return None;
        }
        with_comma(field, decimal)
    }
}

/// Returns the offset of the comment of a line; its length if there is none.
pub(super) fn comment_start(line: &[u8]) -> usize {
    let is_number = |place: usize| place.checked_sub(2).is_some_and(|start| special_number(&line[start..]).is_some());
    let starts = |(place, byte): (usize, &u8)| {
        COMMENT.contains(byte) && spreadsheet_error(&line[place..]).is_none() && !is_number(place)
    };
    line.iter().enumerate().position(starts).unwrap_or(line.len())
}

/// Returns a comment without the signs that start it.
pub(super) fn comment(comment: &[u8], signs: &[u8]) -> String {
    let start = comment.iter().position(|byte| !signs.contains(byte)).unwrap_or(comment.len());
    utf8_or_latin1(comment[start..].trim_ascii())
}

impl Layout {
    fn error(&self, fault: Fault, line: usize) -> FormatError {
        let (format, at) = (self.format, Location::Line(line));
        match fault {
            Fault::Ragged { found } => FormatError::Ragged { line, found, wanted: self.columns.unwrap_or_default() },
            Fault::TooMany => FormatError::too_large(format, "the number of values", at, MAX_POINTS + 1, MAX_POINTS),
            Fault::Value { column, found } => {
                let wanted = match found.replace(',', ".").parse::<f64>() {
                    Ok(_) => "a number with a decimal point",
                    Err(_) if format == Format::Sdf => "a number or BAD",
                    Err(_) => "a number, an empty field, nan, inf or BAD (start comments with # or %)",
                };
                FormatError::field(format, format!("value {column}"), at, found, wanted)
            }
        }
    }
}
