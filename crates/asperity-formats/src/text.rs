//! Matrix of numbers as text: one row of heights per line, in metre unless a header names another unit.
//!
//! The separator is the first of semicolon, tab, comma and space that occurs in the first row. The decimal sign is
//! the point, or a comma between digits if commas are not separators. If every comma may separate thousands (`1,234`), the header
//! (`decimal sign: comma`) or the user must state the decimal sign. `#` and `%` start a comment. Comments and lines
//! `key: value` or `key = value` before the first row become metadata, and may state units, pixel size and missing
//! points (see [`header`]). Missing heights are empty fields, `nan`, `inf`, `BAD` and `No Data`, errors of
//! spreadsheets (`#N/A`), and special numbers of C libraries (`1.#QNAN`, `-nan(ind)`). Text may be UTF-8, UTF-16 with
//! a byte-order mark, or Latin-1.
//!
//! A first row or column of equal steps is a row of labels, which spreadsheets and data frames export: see [`structure`]. Several matrices
//! divided by blank lines are refused. Heights along one line become a scan of one row: see [`profile`].
//!
//! Some programs write the matrices of several channels into one file, each after a comment `Channel: name`. Channels
//! whose unit is not a length are left out.

pub(crate) mod columns;
pub(crate) mod decimal;
mod factor;
mod field;
pub(crate) mod header;
mod interpretation;
mod length;
pub(crate) mod profile;
pub(crate) mod rows;
pub(crate) mod separator;
pub(crate) mod structure;
mod write;

use std::borrow::Cow;

use ndarray::Array2;

use crate::input::utf16;
use crate::unit::in_words;
use crate::{
    Description, Format, FormatError, Location, ReadOptions, Result, Scan, Tested, large, per_metre, refuse_if, shown,
    unique, utf8_or_latin1,
};
use columns::Column;
use decimal::Decimal;
use header::{DECIMAL_SIGN, ESRI, Header};
use interpretation::{Interpretation, Wrong};
use profile::Profile;
use rows::{Layout, Table};
use separator::{COMMENT, Separator};
pub(crate) use write::write_text;

pub(crate) const CODEC: Description = Description {
    extensions: &["txt", "dat", "csv", "asc"],
    vendor: "any",
    known_by: "no control characters in UTF-8, UTF-16 or Latin-1",
    reads: "one row per line; spaces, tabs, commas or semicolons; decimal commas; profiles as one column or with positions; headers of \
            Gwyddion, SPIP, Attocube, Nova, ESRI grids, Dektak and HFM profiles, and plain keys",
    writes: ".csv with commas, others with spaces; unit and pixel size as comments",
    missing_points: "empty, nan, inf, 1.#QNAN, BAD, No Data, #N/A, the NODATA_value of the header",
    orientation: "the first line is row 0",
    write: Some(|scan| Ok(write_text(scan, Separator::Space))),
    tested: Tested::OtherPrograms,
    ..Description::new(Format::Text, is_text, read)
};

/// Number of bytes that are examined to distinguish text from binary data.
pub(crate) const TEXT_PROBE: usize = 4096;

/// Returns whether bytes start without control characters.
pub(crate) fn is_text(bytes: &[u8]) -> bool {
    let probe = utf8(without_end_mark(&bytes[..bytes.len().min(TEXT_PROBE)]));
    let is_text = |&byte: &u8| byte >= 0x20 && byte != 0x7f || matches!(byte, b'\t' | b'\n' | b'\r' | 0x0c);
    !probe.is_empty() && probe.iter().all(is_text)
}

/// Returns a text without the character Ctrl-Z, which ends texts of DOS.
fn without_end_mark(bytes: &[u8]) -> &[u8] {
    let text = bytes.trim_ascii_end();
    let end = text.iter().rposition(|byte| *byte != 0x1a).map_or(0, |last| last + 1);
    if end < text.len() { &text[..end] } else { bytes }
}

/// Number of rows from which three columns look like points rather than a map.
const POINT_LIST_ROWS: usize = 16;
/// Number of rows from which pairs of whole numbers are no map.
const DOUBTFUL_ROWS: usize = 4;
/// Maximum number of matrices in one file.
const MAX_CHANNELS: usize = 256;

/// Converts a text to UTF-8 if a mark declares it as UTF-16; returns other bytes unchanged.
pub(crate) fn utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    utf16(bytes).map_or(Cow::Borrowed(bytes), |text| Cow::Owned(text.into_bytes()))
}

/// Removes the byte-order mark of UTF-8 and a mark of the end. Returns the text and the byte that ends its lines.
pub(crate) fn lines(bytes: &[u8]) -> (&[u8], u8) {
    let bytes = without_end_mark(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    (bytes, if bytes.contains(&b'\n') { b'\n' } else { b'\r' })
}

/// Text before the first row of numbers.
pub(crate) struct Head {
    pub(crate) header: Header,
    /// Offset of the first row, and number of lines before it.
    pub(crate) start: usize,
    pub(crate) lines: usize,
    /// First row without comment.
    pub(crate) first_row: Vec<u8>,
    /// Decimal sign that the user states.
    stated: Option<Decimal>,
}

impl Head {
    /// Reads lines up to the first row. Without a comment sign, only `key: value`, `key = value` and the keys of an
    /// ESRI grid belong to the header. With `free`, all words do. `stated` is the decimal sign that the user states.
    pub(crate) fn read(bytes: &[u8], line_end: u8, free: bool, stated: Option<Decimal>) -> Self {
        let mut head = Self { header: Header::default(), start: 0, lines: 0, first_row: Vec::new(), stated };
        let mut lines = 0;
        for line in bytes.split(|&byte| byte == line_end) {
            let (row, comment) = line.split_at(rows::comment_start(line));
            if !row.trim_ascii().is_empty() || row.contains(&b'\t') {
                let separator = Separator::detect(row, head.decimal());
                let layout = Layout::new(Format::Text, separator, COMMENT, line_end).with_decimal(head.decimal());
                let words = utf8_or_latin1(row);
                // An index of the rows has no name.
                let start = row.iter().position(|byte| *byte != b' ').map_or(row, |start| &row[start..]);
                let start = start.strip_prefix(b"\"\"").unwrap_or(start);
                let named = start.strip_prefix(&[separator.sign()]).filter(|_| free);
                let is_numbered = named.is_some_and(|names| are_numbered(names, separator));
                if !is_numbered && (layout.starts_with_value(named.unwrap_or(row)) || !free && !head.take_key(&words)) {
                    head.first_row = row.to_vec();
                    break;
                }
                if free {
                    head.header.add(&words);
                }
            }
            if !comment.is_empty() && head.header.has_room() {
                head.header.add(&rows::comment(comment, COMMENT));
            }
            head.start += line.len() + 1;
            lines += 1;
        }
        head.lines = lines;
        head.start = head.start.min(bytes.len());
        head
    }

    /// Returns the decimal sign that the user or the header states.
    pub(crate) fn decimal(&self) -> Option<Decimal> {
        self.stated.or_else(|| self.header.decimal())
    }

    /// Returns the separator of the rows.
    fn separator(&self) -> Separator {
        Separator::detect(&self.first_row, self.decimal())
    }

    /// Returns the layout of the rows.
    fn layout(&self, line_end: u8) -> Layout {
        Layout::new(Format::Text, self.separator(), COMMENT, line_end).with_decimal(self.decimal())
    }

    /// Returns the number of values of the first row; `None` if it contains anything else.
    fn columns(&self) -> Option<usize> {
        self.layout(b'\n').count(&self.first_row)
    }

    /// Returns the columns of a profile that the header names.
    fn profile(&self, bytes: &[u8]) -> Option<Vec<Column>> {
        profile::names(&bytes[..self.start], self.columns()?)
    }

    /// Adds a line without a comment sign if it is a key with its value.
    fn take_key(&mut self, line: &str) -> bool {
        if let Some((key, value)) = line.trim().split_once([' ', '\t']).filter(|(key, _)| is_esri_key(key)) {
            self.header.insert(key, value.trim());
            return true;
        }
        let is_pair = line.contains([':', '=']) && line.trim_start().starts_with(char::is_alphabetic);
        if is_pair {
            self.header.add(line);
        }
        is_pair
    }
}

/// Returns whether the names of columns are their numbers, as data frames write for columns without names.
fn are_numbered(names: &[u8], separator: Separator) -> bool {
    let fields = names.trim_ascii_end().split(|&byte| byte == separator.sign());
    fields.enumerate().all(|(number, name)| name == number.to_string().as_bytes())
}

fn is_esri_key(key: &str) -> bool {
    ESRI.contains(&key.to_lowercase().as_str())
}

/// Reads a matrix of heights.
///
/// # Errors
/// A field that is not a number, rows of different length (with the line), or no row.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let text = utf8(bytes);
    let (bytes, line_end) = lines(&text);
    let blocks = blocks(bytes, line_end);
    if blocks.len() < 2 {
        let strict = Head::read(bytes, line_end, false, options.decimal);
        // The header of a profile names its columns in a line of words.
        let words = strict.columns().is_none().then(|| Head::read(bytes, line_end, true, options.decimal));
        let head = words.filter(|head| head.profile(bytes).is_some()).unwrap_or(strict);
        return read_block(bytes, line_end, 0, head, options);
    }
    let mut maps: Vec<_> = blocks
        .into_iter()
        .map(|(start, lines, end)| (&bytes[start..end], lines))
        .map(|(block, lines)| (block, lines, Head::read(block, line_end, false, options.decimal)))
        .filter(|(_, _, head)| head.header.may_be_heights(head.decimal()))
        .collect();
    let names = unique(maps.iter().map(|(_, _, head)| head.header.channel().unwrap_or_default().into()).collect());
    if names.is_empty() {
        let found = "the unit of no channel is a length";
        return Err(FormatError::unsupported(Format::Text, found, "a channel of heights"));
    }
    let channel = options.choose(Format::Text, &names)?;
    let (block, lines, head) = maps.swap_remove(channel);
    Ok(read_block(block, line_end, lines, head, options)?.with_channels(names, channel))
}

/// Returns start, line number and end of each matrix of a file with several channels; empty for other files.
fn blocks(bytes: &[u8], line_end: u8) -> Vec<(usize, usize, usize)> {
    let is_start = |line: &[u8]| line.strip_prefix(b"#").is_some_and(Header::names_channel);
    let (mut blocks, mut place): (Vec<(usize, usize, usize)>, usize) = (Vec::new(), 0);
    for (index, line) in bytes.split(|&byte| byte == line_end).enumerate() {
        // Only files that start with a channel are searched.
        if line.first() == Some(&b'#') && blocks.len() < MAX_CHANNELS && is_start(line) {
            if let Some(last) = blocks.last_mut() {
                last.2 = place;
            }
            blocks.push((place, index, bytes.len()));
        } else if blocks.is_empty() && line.first() != Some(&b'#') {
            break;
        }
        place += line.len() + 1;
    }
    blocks
}

/// Reads one matrix.
fn read_block(bytes: &[u8], line_end: u8, lines: usize, head: Head, options: &ReadOptions) -> Result<Scan> {
    let (layout, columns, names) = (head.layout(line_end), head.columns(), head.profile(bytes));
    let (separator, decimal) = (head.separator(), head.decimal());
    let Head { mut header, start, lines: header_lines, first_row, .. } = head;
    let layout = match columns.filter(|_| !header.is_esri()) {
        Some(columns) => layout.with_columns(columns),
        None => layout,
    };
    let mut table = rows::read(&bytes[start..], &layout, lines + header_lines)?;
    for comment in std::mem::take(&mut table.comments) {
        header.add(&comment);
    }
    let mut warnings = Vec::new();
    let mut columns = columns.filter(|_| !header.is_esri());
    let is_pair = columns == Some(2) && separator == Separator::Comma && decimal.is_none() && names.is_none();
    refuse_if!(is_pair && may_be_decimals(&bytes[start..], &table), doubtful_pairs(&first_row));
    columns = columns.map(|columns| without_open_column(&mut table, columns, &mut warnings));
    let profile = match columns {
        Some(columns) => profile::of(&table.values, (table.rows, columns), names, options)?,
        None => None,
    };
    // Two rows or columns beside a header with the size of the map: the first may rise by chance if it is short.
    let is_doubtful = |profile: &Profile| profile.step.is_some() && !profile.is_named() && header.states_extent();
    let profile = profile.filter(|profile| !is_doubtful(profile) || profile.heights.len() >= profile::MANY);
    if let Some(profile) = profile.as_ref().filter(|profile| is_doubtful(profile)) {
        let found = format!("{}, beside a header with the size of a map: positions or heights", profile.form);
        let wanted = "heights alone, or a header without that size";
        return Err(FormatError::unsupported(Format::Text, found, wanted));
    }
    refuse_if!(profile.is_some() && table.gaps > 0 && table.gaps + 1 < table.rows, structure::blocks(&table));
    let shape = match &profile {
        Some(profile) => {
            warnings.push(profile.describe(&mut header));
            table.values.clone_from(&profile.heights);
            (1, table.values.len())
        }
        None => {
            let shape = shape(&header, &mut table, columns.unwrap_or(0), &mut warnings)?;
            let is_corner_empty = separator != Separator::Space
                && first_row.iter().find(|byte| **byte != b' ').is_some_and(|&byte| byte == separator.sign());
            let corner = if is_corner_empty { structure::Corner::Empty } else { structure::Corner::Number };
            match header.shape() {
                None => structure::without_labels(&mut table, shape, corner, header.states_extent(), &mut warnings)?,
                Some(_) => shape,
            }
        }
    };
    if table.decimal_comma && header.decimal().is_none() {
        header.insert(DECIMAL_SIGN, "comma");
    }
    let interpretation =
        header.interpret(shape, options).map_err(|wrong| wrong_pair(bytes, line_end, lines, &wrong))?;
    if let Some(unit) = interpretation.unit.as_deref().filter(|unit| per_metre(unit).is_none())
        && options.height_unit.is_none()
    {
        let wanted = "a unit of length; state it, as by --height-unit, if the numbers are heights";
        return Err(FormatError::unsupported(Format::Text, format!("numbers in `{}`", shown(unit)), wanted));
    }
    interpretation.apply(&mut table.values);
    if let Some(unit) = &interpretation.converted {
        header.insert("converted", &format!("heights from {unit} to m"));
    }
    warnings.extend(interpretation.warnings);
    let (height_unit, mut pitch_m) = (interpretation.unit, interpretation.pitch_m);
    let heights_m = Array2::from_shape_vec(shape, table.values).map_err(|_| nothing())?;
    let (mut channels, mut channel) = (vec![], 0);
    if let Some(profile) = profile {
        let of_positions = profile.step.zip(header.units()[0]).map(|(step, per_metre)| step / per_metre);
        let stated = pitch_m.map(|(dx_m, _)| dx_m);
        if let Some((step_m, stated_m)) = of_positions.zip(stated).filter(|(a, b)| (a / b - 1.0).abs() > 0.01) {
            let [step, stated] = [step_m, stated_m].map(in_words);
            warnings.push(format!(
                "the positions step by {step}, not by the {stated} of the header; the positions were used"
            ));
        }
        pitch_m = of_positions.or(stated).map(|step_m| (step_m, step_m));
        (channels, channel) = (profile.channels, profile.channel);
    }
    let scan = Scan { metadata: header.metadata(), warnings, height_unit, ..Scan::new(heights_m, pitch_m) };
    Ok(scan.with_channels(channels, channel))
}

/// Returns whether rows of two whole numbers with a comma between may be one number each, with a decimal comma.
fn may_be_decimals(rows: &[u8], table: &Table) -> bool {
    let is_digit = |place: usize| rows.get(place).is_some_and(u8::is_ascii_digit);
    let are_within =
        |(place, byte): (usize, &u8)| *byte != b',' || place > 0 && is_digit(place - 1) && is_digit(place + 1);
    let are_whole = table.values.iter().all(|value| value.fract() == 0.0);
    table.rows >= DOUBTFUL_ROWS && are_whole && !rows.contains(&b'.') && rows.iter().enumerate().all(are_within)
}

fn doubtful_pairs(first_row: &[u8]) -> FormatError {
    let row = shown(&utf8_or_latin1(first_row.trim_ascii()));
    let found = format!("rows such as `{row}`, one number with a decimal comma or two");
    let wanted = "points, or `--decimal comma` or `--decimal point` (in a study `decimal`)";
    FormatError::unsupported(Format::Text, found, wanted)
}

/// Removes the last of several columns if it is empty because every row ends with a separator; returns the number of columns.
fn without_open_column(table: &mut Table, columns: usize, warnings: &mut Vec<String>) -> usize {
    if columns < 2 || table.open_rows < table.rows {
        return columns;
    }
    let mut column = 0;
    table.values.retain(|_| {
        column = column % columns + 1;
        column < columns
    });
    warnings.push("every row ends with a separator; the empty last column was left out".into());
    columns - 1
}

/// Returns the shape of a table after removing columns and rows that are not heights.
fn shape(header: &Header, table: &mut Table, columns: usize, warnings: &mut Vec<String>) -> Result<(usize, usize)> {
    refuse_if!(table.values.is_empty(), nothing());
    if let Some((ny, nx)) = header.shape().filter(|_| header.is_esri()) {
        if ny.checked_mul(nx) != Some(table.values.len()) {
            let (found, wanted) = (format!("{nx} × {ny}"), format!("{}, the number of values", table.values.len()));
            return Err(FormatError::field(Format::Text, "ncols × nrows", Location::Line(1), found, wanted));
        }
        return Ok((ny, nx));
    }
    let mut rows = table.rows;
    if header.has_voids() && header.shape() == Some((rows / 2, columns)) && rows.is_multiple_of(2) {
        let voids = table.values.split_off(rows / 2 * columns);
        large::hide(&mut table.values, voids.into_iter().map(|void| void != 0.0));
        rows /= 2;
    }
    if columns == 3 && rows >= POINT_LIST_ROWS && !header.states_pixels() {
        warnings.push(format!("a map of 3 columns and {rows} rows; a list of points x y z needs the extension .xyz"));
    }
    Ok((rows, columns))
}

/// Returns the error for an invalid pair of the header in a text that starts after `lines` lines.
fn wrong_pair(bytes: &[u8], line_end: u8, lines: usize, wrong: &Wrong<'_>) -> FormatError {
    let Wrong { key, value, wanted } = *wrong;
    let states = |line: &[u8]| {
        let line = utf8_or_latin1(line);
        line.split_once(key).is_some_and(|(_, rest)| rest.contains(value))
    };
    let line = bytes.split(|&byte| byte == line_end).position(states).unwrap_or_default();
    FormatError::field(Format::Text, shown(key), Location::Line(lines + line + 1), value, wanted)
}

fn nothing() -> FormatError {
    FormatError::missing(Format::Text, "a row of numbers", Location::Line(1), "one row of heights per line")
}

impl Interpretation {
    /// Converts numbers to heights in metre.
    fn apply(&self, values: &mut [f64]) {
        let Self { factor, per_metre, no_data, .. } = *self;
        if let Some(no_data) = no_data {
            for z in values.iter_mut().filter(|z| **z == no_data) {
                *z = f64::NAN;
            }
        }
        if self.converted.is_some() {
            for z in values {
                *z = *z * factor / per_metre;
            }
        }
    }
}
