//! The table in a sheet: its rows and columns among other cells, and its text.

use std::ops::RangeInclusive;

use super::cells::{Book, Cell, Kind, VALID, cells, place};
use super::unit_at_end;
use crate::text::columns::columns_in;
use crate::text::decimal::{Decimal, is_ambiguous};
use crate::text::header::unit;
use crate::text::structure::steps_evenly;
use crate::{Format, FormatError, Location, ReadOptions, Result, refuse_if, shown};

/// Maximum size of the text of a sheet in bytes beyond three quarters of its XML. Empty cells and shared texts may take no bytes of XML.
const FREE_BYTES: usize = 1 << 21;
/// Maximum number of numbers in a row above the table that starts with a text, such as `Ra | 0.8 | µm`.
const FEW: u16 = 2;
/// Last words of the names of heights whose unit stands above a matrix, as in `Height [nm]`.
const HEIGHTS: [&str; 7] = ["z", "h", "height", "heights", "höhe", "höhen", "topography"];
const WANTED: &str = "one table per sheet; save the heights alone, as a sheet of their own or as CSV";

/// Row with numbers: the column of the last text before the first number, and the columns of numbers.
struct Row {
    row: u32,
    text: Option<u16>,
    first: u16,
    last: u16,
    count: u16,
}

/// Rows of numbers in a column, and whether the column has a text.
#[derive(Clone, Default)]
struct Column {
    first: u32,
    last: u32,
    count: u32,
    has_text: bool,
}

/// Places of numbers and texts in a sheet.
#[derive(Default)]
pub(super) struct Places {
    rows: Vec<Row>,
    columns: Vec<Column>,
    /// Row and column of the last text.
    text: Option<(usize, usize)>,
    /// First text whose comma may be a decimal sign or separate thousands, and whether the comma of another text cannot separate them.
    ambiguous: Option<(usize, String)>,
    has_comma: bool,
}

/// Table in a sheet.
pub(super) struct Table {
    pub(super) columns: RangeInclusive<usize>,
    rows: RangeInclusive<usize>,
    /// Whether the first row and column are labels with a text in their corner.
    has_corner: bool,
    pub(super) warnings: Vec<String>,
}

impl Places {
    pub(super) fn add(&mut self, cell: &Cell) {
        if self.columns.len() <= cell.column {
            self.columns.resize(cell.column + 1, Column::default());
        }
        let (column, row, place) = (&mut self.columns[cell.column], cell.row as u32, cell.column as u16);
        if cell.kind == Kind::Text {
            column.has_text = true;
            self.text = Some((cell.row, cell.column));
            return;
        }
        if column.count == 0 {
            column.first = row;
        }
        (column.last, column.count) = (row, column.count + 1);
        match self.rows.last_mut().filter(|last| last.row == row) {
            Some(last) => (last.last, last.count) = (place, last.count + 1),
            None => {
                let text = self.text.filter(|(row, _)| *row == cell.row).map(|(_, column)| column as u16);
                self.rows.push(Row { row, text, first: place, last: place, count: 1 });
            }
        }
        if cell.kind == Kind::NumberInText && cell.text.contains(',') {
            match is_ambiguous(cell.text.as_bytes()) {
                true if self.ambiguous.is_none() => self.ambiguous = Some((cell.row, cell.text.to_owned())),
                true => (),
                false => self.has_comma = true,
            }
        }
    }

    /// Returns the number of numbers.
    pub(super) fn count(&self) -> usize {
        self.rows.iter().map(|row| usize::from(row.count)).sum()
    }

    /// Returns the decimal sign of the texts that are numbers.
    ///
    /// # Errors
    /// All commas may be decimal signs or separate thousands, and the options do not state the decimal sign.
    pub(super) fn decimal(&self, options: &ReadOptions) -> Result<Option<Decimal>> {
        match &self.ambiguous {
            _ if options.decimal.is_some() => Ok(options.decimal),
            _ if self.has_comma => Ok(Some(Decimal::Comma)),
            Some((row, found)) => {
                let (at, found) = (Location::Line(row + 1), found.clone());
                Err(FormatError::AmbiguousDecimal { format: Format::Xlsx, at, found })
            }
            None => Ok(None),
        }
    }

    /// Returns the table in the sheet. Rows above it start with a text and have few numbers.
    ///
    /// # Errors
    /// The sheet holds several tables: blocks of numbers, divided by empty rows or columns, or beside each other with far fewer numbers. A
    /// single empty row or column between equal blocks is a part of the table.
    pub(super) fn table(&self, sheet: &str) -> Result<Table> {
        let several = |found: String| {
            let found = format!("{found} in the sheet `{}`", shown(sheet));
            Err(FormatError::unsupported(Format::Xlsx, found, WANTED))
        };
        let present = |column: &Column| column.count > 0;
        let first = self.columns.iter().position(present).unwrap_or_default();
        let last = self.columns.iter().rposition(present).unwrap_or_default();
        let (mut rows, mut has_corner) = (&self.rows[..], false);
        while let [row, rest @ ..] = rows
            && row.text.is_some_and(|text| usize::from(text) >= first)
            && !rest.is_empty()
        {
            has_corner = usize::from(row.count) == last - first && row.count > FEW;
            if has_corner {
                break;
            } else if row.count > FEW {
                return several(format!("row {} with a text before {} numbers", row.row + 1, row.count));
            }
            rows = rest;
        }
        let places = |row: &Row| (row.row as usize, usize::from(row.first), usize::from(row.last));
        let blocks = blocks(rows.iter().map(places));
        if let Some([a, b]) = divided(&blocks) {
            return several(format!(
                "blocks of numbers {} and {}, divided by empty rows,",
                a.cells(false),
                b.cells(false)
            ));
        }
        let empty_rows = blocks.len() - 1;
        let columns = &self.columns[first..=last];
        let places = |(place, column): (usize, &Column)| (first + place, column.first as usize, column.last as usize);
        let blocks = self::blocks(columns.iter().enumerate().filter(|(_, column)| present(column)).map(places));
        // Names of columns but none for the empty one divide two tables.
        let is_named = |start: usize| {
            let [before, empty, behind] = [2, 1, 0].map(|back| self.columns[start - back].has_text);
            before && behind && !empty
        };
        let named = || blocks.windows(2).find(|pair| is_named(pair[1].lines[0]));
        if let Some([a, b]) = divided(&blocks).or_else(named) {
            return several(format!(
                "blocks of numbers {} and {}, divided by empty columns,",
                a.cells(true),
                b.cells(true)
            ));
        }
        let (top, bottom) = (rows[0].row, rows[rows.len() - 1].row);
        let is_solid = |column: &Column| column.first == top && column.last - top + 1 == column.count;
        let is_step = |a: u32, b: u32| 2 * a.min(b) < a.max(b);
        for (place, pair) in columns.windows(2).enumerate() {
            if is_step(pair[0].count, pair[1].count) && pair.iter().all(is_solid) {
                let [a, b] = [0, 1].map(|behind| letters(first + place + behind));
                return several(format!("columns {a} and {b} of {} and {} numbers", pair[0].count, pair[1].count));
            }
        }
        let is_solid = |row: &Row| usize::from(row.first) == first && row.last - row.first + 1 == row.count;
        // A single short row between others lacks heights.
        let mut steps = rows.windows(2).filter(|pair| is_step(pair[0].count.into(), pair[1].count.into()));
        if let (Some([a, b]), None) = (steps.next(), steps.next())
            && is_solid(a)
            && is_solid(b)
        {
            return several(format!("rows {} and {} of {} and {} numbers", a.row + 1, b.row + 1, a.count, b.count));
        }
        let mut warnings = Vec::new();
        for (count, line) in
            [(empty_rows, "row"), (blocks.len() - 1, "column")].into_iter().filter(|(count, _)| *count > 0)
        {
            let plural = if count > 1 { "s" } else { "" };
            warnings.push(format!("{count} empty {line}{plural} inside the table became missing heights"));
        }
        Ok(Table { columns: first..=last, rows: top as usize..=bottom as usize, has_corner, warnings })
    }
}

/// Rows or columns without an empty one between them: the first and the last, and the ends of their numbers.
struct Block {
    lines: [usize; 2],
    ends: [usize; 2],
}

impl Block {
    /// Returns the first and the last cell, as in `A1:C12`.
    fn cells(&self, are_columns: bool) -> String {
        let (rows, columns) = if are_columns { (self.ends, self.lines) } else { (self.lines, self.ends) };
        let [start, end] = [0, 1].map(|place| format!("{}{}", letters(columns[place]), rows[place] + 1));
        format!("{start}:{end}")
    }
}

/// Returns the blocks of rows or columns, given their numbers and the ends of each.
fn blocks(lines: impl Iterator<Item = (usize, usize, usize)>) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    for (line, start, end) in lines {
        match blocks.last_mut().filter(|last| last.lines[1] + 1 == line) {
            Some(last) => {
                last.lines[1] = line;
                last.ends = [last.ends[0].min(start), last.ends[1].max(end)];
            }
            None => blocks.push(Block { lines: [line; 2], ends: [start, end] }),
        }
    }
    blocks
}

/// Returns the first two neighbouring blocks that do not belong to one table: more than one empty row or column is between them, their ends
/// differ, or one of them is a single row or column, perhaps of means.
fn divided(blocks: &[Block]) -> Option<&[Block]> {
    let is_single = |block: &Block| block.lines[0] == block.lines[1];
    blocks.windows(2).find(|pair| {
        let gap = pair[1].lines[0] - pair[0].lines[1];
        gap > 2 || pair[0].ends != pair[1].ends || pair.iter().any(is_single)
    })
}

/// Returns the letters of a column.
fn letters(column: usize) -> String {
    let letter = char::from(b'A' + (column % 26) as u8);
    if column < 26 { letter.into() } else { letters(column / 26 - 1) + &String::from(letter) }
}

impl Table {
    /// Returns the profile of a roughness tester, which fills two columns from their start to their end.
    pub(super) fn of_tester(columns: RangeInclusive<usize>) -> Self {
        Self { columns, rows: 0..=usize::MAX, has_corner: false, warnings: Vec::new() }
    }

    /// Returns the text of a sheet: a line for each row, with tabs between the cells of the table. Rows above the table are comments, and so
    /// are texts before and below it, at the end. `unit_x` is the unit of the positions in the profile of a tester.
    ///
    /// # Errors
    /// Labels around a corner with a text that do not step evenly, and a text that is far longer than the sheet.
    pub(super) fn as_text(
        &self,
        link: &str,
        xml: &[u8],
        book: &Book,
        decimal: Option<Decimal>,
        unit_x: Option<String>,
    ) -> Result<String> {
        let (mut text, mut comments, mut unit_z) = (String::new(), String::new(), None);
        let (first, last) = (*self.columns.start(), *self.columns.end());
        let (mut row, mut column, mut is_empty, mut is_started) = (0, first, true, false);
        let mut head = Head::default();
        let mut labels = [Vec::new(), Vec::new()];
        let limit = FREE_BYTES + 3 * xml.len() / 4;
        cells(link, xml, book, |cell| {
            let mut content = cell.text.replace(char::is_control, " ");
            match (cell.kind, decimal) {
                (Kind::Number, Some(Decimal::Comma)) => content = content.replace('.', ","),
                // Commas between thousands.
                (Kind::NumberInText, Some(Decimal::Point)) => content = content.replace(',', ""),
                _ => (),
            }
            let is_above = cell.row < *self.rows.start();
            let is_inside = self.rows.contains(&cell.row) && self.columns.contains(&cell.column);
            let is_corner = self.has_corner && (cell.row, cell.column) == (*self.rows.start(), first);
            if head.row != cell.row {
                head.write(&self.columns, &mut text, &mut comments);
            }
            while (is_above || is_inside) && row < cell.row {
                // Cells without a value at the end of a row are not in the file.
                if is_started {
                    text.push_str(if is_empty { "nan" } else { "" });
                    text.extend(std::iter::repeat_n('\t', last - column));
                }
                text.push('\n');
                (row, column, is_empty) = (row + 1, first, true);
            }
            if is_above {
                (head.row, head.bytes) = (cell.row, head.bytes + content.len());
                let is_valid = content.eq_ignore_ascii_case(VALID);
                head.cells.push((cell.column, if is_valid { VALID.into() } else { content }, cell.kind));
            } else if is_inside && !is_corner {
                let number = || cell.text.replace(',', ".").parse().unwrap_or(f64::NAN);
                if self.has_corner && cell.row == *self.rows.start() {
                    labels[0].push(number());
                } else if self.has_corner && cell.column == first {
                    labels[1].push(number());
                }
                text.extend(std::iter::repeat_n('\t', cell.column - column));
                (column, is_empty, is_started) = (cell.column, false, true);
                // Signs of comments in a text would hide the rest of the row.
                text.push_str(&if cell.kind == Kind::Text { content.replace(['#', '%'], "?") } else { content });
            } else if cell.kind == Kind::Text && (is_corner || cell.column < first || cell.row > *self.rows.end()) {
                unit_z = unit_z.take().or_else(|| unit_at_end(cell.text));
                comments.extend(["\n# ", &content]);
            }
            let length = text.len() + comments.len() + head.bytes;
            let beyond = || {
                let at = place(link, cell.offset);
                FormatError::too_large(Format::Xlsx, "the size of the text in bytes", at, length as u64, limit as u64)
            };
            refuse_if!(length > limit, beyond());
            Ok(())
        })?;
        if self.has_corner && !labels.iter().all(|labels| steps_evenly(labels)) {
            let found =
                format!("a text at the start of row {} before numbers that do not step evenly", self.rows.start() + 1);
            return Err(FormatError::unsupported(Format::Xlsx, found, "labels in equal steps, or heights alone"));
        }
        text.extend(std::iter::repeat_n('\t', if text.is_empty() { 0 } else { last - column }));
        text.push_str(&comments);
        if let Some((x, z)) = unit_x.zip(unit_z) {
            text.extend(["\n# x unit: ", &x, "\n# value units: ", &z]);
        }
        Ok(text)
    }
}

/// Cells of a row above the table.
#[derive(Default)]
struct Head {
    row: usize,
    /// Size of their texts in bytes.
    bytes: usize,
    cells: Vec<(usize, String, Kind)>,
}

impl Head {
    /// Writes the row as a comment: as a key with its value, or as the names of the columns.
    fn write(&mut self, columns: &RangeInclusive<usize>, text: &mut String, comments: &mut String) {
        let cells = std::mem::take(&mut self.cells);
        self.bytes = 0;
        let is_length = |value: &str| {
            value.split_once(' ').is_some_and(|(number, rest)| number.parse::<f64>().is_ok() && unit(rest).is_some())
        };
        match &cells[..] {
            [] => return,
            [(_, key, Kind::Text), (_, value, kind), rest @ ..]
                if *kind != Kind::Text
                    || is_length(value)
                    || rest.is_empty() && unit(value).is_some() && unit(key).is_none() =>
            {
                text.extend(["# ", key.trim_end_matches([':', '=', ' ']), ": ", value]);
                text.extend(rest.iter().flat_map(|(_, more, _)| [" ", more]));
                return;
            }
            [(_, title, Kind::Text)] => {
                let named = columns_in(title).pop().and_then(|column| Some((column.name.to_lowercase(), column.unit?)));
                if let Some((_, unit)) =
                    named.filter(|(name, _)| HEIGHTS.contains(&name.rsplit(' ').next().unwrap_or(name)))
                {
                    comments.extend(["\n# value units: ", &unit]);
                }
            }
            _ => (),
        }
        text.push_str("# ");
        let mut column = *columns.start();
        for (place, content, _) in &cells {
            if columns.contains(place) {
                text.extend(std::iter::repeat_n('\t', place - column));
                text.push_str(content);
                column = *place;
            } else {
                comments.extend(["\n# ", content]);
            }
        }
    }
}
