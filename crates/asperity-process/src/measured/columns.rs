//! Text files of columns, as written by data loggers.

use std::borrow::Cow;

use super::MeasuredError;
use super::units::is_unit;

/// Texts of cells without a value.
const MISSING: [&str; 10] = ["", "nan", "-nan", "na", "n/a", "#n/a", "null", "none", "-", "--"];
/// Number of lines from which the layout is determined.
const PROBE: usize = 1000;
/// Characters that start a comment.
const COMMENT: [char; 2] = ['#', '%'];

/// Columns of numbers with the names and units of the header.
///
/// Fields are separated by semicolons, tabs, commas or spaces; the separator that reads most lines consistently is
/// used. The decimal sign is the point or, if commas do not separate fields, the comma. `#` and `%` start comments. The
/// last line before the numbers with the same number of fields is the header, in a comment or not; a line of units may
/// follow it. Empty cells, `nan`, `NA` and infinities are missing values.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnTable {
    columns: Vec<Column>,
    /// Line of every row, counted from 1.
    lines: Vec<usize>,
}

#[derive(Debug, Clone, PartialEq, Default)]
struct Column {
    /// Name without the unit; empty without a header.
    name: String,
    unit: Option<String>,
    values: Vec<f64>,
    /// First cell that is not a number: line and text.
    wrong: Option<(usize, String)>,
    /// First cell with a comma, if the comma may separate thousands: line and text.
    comma: Option<(usize, String)>,
}

/// Selected column.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chosen<'a> {
    pub(super) name: &'a str,
    pub(super) unit: Option<&'a str>,
    pub(super) values: &'a [f64],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    Sign(char),
    Space,
}

impl Separator {
    const ALL: [Self; 4] = [Self::Sign(';'), Self::Sign('\t'), Self::Sign(','), Self::Space];

    /// Returns the fields of a line; quoted fields may contain separators.
    fn fields<'a>(self, line: &'a str) -> Vec<&'a str> {
        let mut fields = Vec::new();
        let (mut start, mut quoted) = (0, false);
        for (place, letter) in line.char_indices() {
            match letter {
                '"' => quoted = !quoted,
                _ if quoted => {}
                _ if self.separates(letter) => {
                    fields.push(&line[start..place]);
                    start = place + letter.len_utf8();
                }
                _ => {}
            }
        }
        fields.push(&line[start..]);
        let bare = |field: &&'a str| field.trim().trim_matches('"').trim();
        match self {
            Self::Space => fields.iter().map(bare).filter(|field| !field.is_empty()).collect(),
            Self::Sign(_) => fields.iter().map(bare).collect(),
        }
    }

    fn separates(self, letter: char) -> bool {
        match self {
            Self::Sign(sign) => letter == sign,
            Self::Space => letter.is_whitespace(),
        }
    }
}

/// Nonempty line: its number, counted from 1, and its text without the comment character.
struct Line<'a> {
    number: usize,
    text: &'a str,
    comment: bool,
}

impl ColumnTable {
    /// Reads a text in UTF-8, in UTF-16 with a byte-order mark, or in Latin-1.
    ///
    /// # Errors
    /// Fails if there is no row of numbers, or if rows differ in length. A cell that is not a number is an error only
    /// when its column is requested.
    pub fn read(bytes: &[u8]) -> Result<Self, MeasuredError> {
        let text = decoded(bytes);
        let lines: Vec<Line<'_>> = text
            .lines()
            .enumerate()
            .map(|(index, line)| (index + 1, line.trim_end_matches(['\r', '\0'])))
            .filter(|(_, line)| !line.trim().is_empty())
            .map(|(number, line)| {
                let comment = line.trim_start().starts_with(COMMENT);
                let text = if comment { line.trim_start().trim_start_matches(COMMENT) } else { line };
                Line { number, text, comment }
            })
            .collect();
        let layouts = Separator::ALL.into_iter().filter_map(|separator| Layout::new(&lines, separator));
        // The first of equally good layouts: semicolons and tabs rarely have another meaning.
        let best = layouts.reduce(|best, next| if next.rank() > best.rank() { next } else { best });
        let layout = best.ok_or(MeasuredError::NoRows)?;
        layout.read(&lines)
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// Returns the names of the columns; empty without a header.
    pub fn names(&self) -> Vec<&str> {
        self.columns.iter().map(|column| column.name.as_str()).collect()
    }

    /// Returns the line of a row, counted from 1.
    pub(super) fn line(&self, row: usize) -> usize {
        self.lines[row]
    }

    /// Returns the column with that name, in any case and with or without its unit, or with that number, counted from
    /// 1.
    pub(super) fn column(&self, wanted: &str) -> Result<Chosen<'_>, MeasuredError> {
        let plain = wanted.trim();
        let alike = |own: &Column| {
            own.name == plain
                || own.name.to_lowercase() == header(plain).0.to_lowercase()
                    && header(plain).1.is_none_or(|unit| own.unit.as_deref() == Some(unit))
        };
        let by_number = || plain.parse::<usize>().ok().filter(|number| (1..=self.columns.len()).contains(number));
        let mut equal = self.columns.iter().enumerate().filter(|(_, own)| !own.name.is_empty() && own.name == plain);
        let exact = equal.next().map(|(index, _)| index);
        if equal.next().is_some() {
            return Err(MeasuredError::TwoColumns { wanted: wanted.into(), known: self.known() });
        }
        let mut found = self.columns.iter().enumerate().filter(|(_, own)| !own.name.is_empty() && alike(own));
        let similar = match (found.next(), found.next()) {
            (Some((index, _)), None) => Some(index),
            _ => None,
        };
        let index = exact
            .or(similar)
            .or(by_number().map(|number| number - 1))
            .ok_or_else(|| MeasuredError::NoColumn { wanted: wanted.into(), known: self.known() })?;
        self.chosen(index)
    }

    /// Returns the values of a column, counted from 0.
    ///
    /// # Errors
    /// A cell is not a number, or has a comma that may separate thousands.
    ///
    /// # Panics
    /// If there is no such column.
    pub fn values(&self, index: usize) -> Result<&[f64], MeasuredError> {
        self.chosen(index).map(|chosen| chosen.values)
    }

    fn chosen(&self, index: usize) -> Result<Chosen<'_>, MeasuredError> {
        let Column { name, unit, values, wrong, comma } = &self.columns[index];
        let (column, own) = (index + 1, || name.clone());
        match (wrong, comma) {
            (Some((line, text)), _) => {
                Err(MeasuredError::Cell { line: *line, column, name: own(), text: text.clone() })
            }
            (None, Some((line, text))) => {
                Err(MeasuredError::Comma { line: *line, column, name: own(), text: text.clone() })
            }
            (None, None) => Ok(Chosen {
                name: if name.is_empty() { wanted_name(index) } else { name },
                unit: unit.as_deref(),
                values,
            }),
        }
    }

    fn known(&self) -> String {
        let named = |(index, column): (usize, &Column)| match (&column.name[..], &column.unit) {
            ("", _) => format!("{}", index + 1),
            (name, Some(unit)) => format!("{} `{name} [{unit}]`", index + 1),
            (name, None) => format!("{} `{name}`", index + 1),
        };
        let list: Vec<String> = self.columns.iter().enumerate().map(named).collect();
        match list.len() {
            1 => format!("column {}", list[0]),
            _ => format!("columns {}", list.join(", ")),
        }
    }
}

/// Returns the name of a column without a header for messages.
fn wanted_name(index: usize) -> &'static str {
    const NUMBERS: [&str; 9] = ["1", "2", "3", "4", "5", "6", "7", "8", "9"];
    NUMBERS.get(index).copied().unwrap_or("of that number")
}

/// Layout of the lines for one separator.
struct Layout {
    separator: Separator,
    /// Index of the first row among the lines.
    first: usize,
    columns: usize,
    /// Number of columns of numbers.
    numeric: usize,
    names: Option<Vec<(String, Option<String>)>>,
}

impl Layout {
    /// Returns the layout for a separator; `None` if no line is a row.
    fn new(lines: &[Line<'_>], separator: Separator) -> Option<Self> {
        let probe: Vec<(usize, Vec<&str>)> = (0..lines.len())
            .filter(|index| !lines[*index].comment)
            .take(PROBE)
            .map(|index| (index, separator.fields(lines[index].text)))
            .filter(|(_, fields)| fields.iter().any(|field| number(field).is_some_and(|value| !value.is_nan())))
            .collect();
        let columns = most_frequent(probe.iter().map(|(_, fields)| fields.len()))?;
        let alike = || probe.iter().filter(|(_, fields)| fields.len() == columns);
        // Columns of numbers, possibly with gaps; the other columns contain text, such as remarks.
        let numeric: Vec<usize> = (0..columns)
            .filter(|column| {
                let numbers = alike().filter(|(_, fields)| number(fields[*column]).is_some()).count();
                let values = alike().any(|(_, fields)| number(fields[*column]).is_some_and(|value| !value.is_nan()));
                values && 2 * numbers > alike().count()
            })
            .collect();
        // Numbers in most columns, or numbers in some and gaps in the others.
        let is_row = |fields: &[&str]| {
            let cells = || numeric.iter().map(|column| number(fields[*column]));
            let numbers = cells().filter(|cell| cell.is_some_and(|value| !value.is_nan())).count();
            2 * numbers > numeric.len() || numbers > 0 && cells().all(|cell| cell.is_some())
        };
        let first = alike().find(|(_, fields)| is_row(fields)).map(|(index, _)| *index)?;
        let open = alike().all(|(_, fields)| fields.last().is_some_and(|field| field.is_empty()));
        let names = header_of(&lines[..first], separator, columns, open);
        Some(Self { separator, first, columns, numeric: numeric.len(), names })
    }

    /// Returns the rank of the layout: layouts with a header and with many columns of numbers rank higher.
    fn rank(&self) -> (bool, usize) {
        (self.names.is_some(), self.numeric)
    }

    fn read(self, lines: &[Line<'_>]) -> Result<ColumnTable, MeasuredError> {
        let mut columns: Vec<Column> = vec![Column::default(); self.columns];
        for (column, (name, unit)) in columns.iter_mut().zip(self.names.into_iter().flatten()) {
            (column.name, column.unit) = (name, unit);
        }
        let mut numbers = Vec::new();
        let (mut points, mut commas) = (false, vec![Commas::default(); columns.len()]);
        for line in lines[self.first..].iter().filter(|line| !line.comment) {
            let mut fields = self.separator.fields(line.text);
            if fields.len() == self.columns + 1 && fields.last().is_some_and(|field| field.is_empty()) {
                fields.pop();
            }
            if fields.len() != self.columns {
                return Err(MeasuredError::Ragged { line: line.number, found: fields.len(), wanted: self.columns });
            }
            numbers.push(line.number);
            for ((column, commas), field) in columns.iter_mut().zip(&mut commas).zip(fields) {
                let value = number(field);
                let cell = || (line.number, field.chars().take(40).collect());
                match value {
                    None => column.wrong = column.wrong.take().or_else(|| Some(cell())),
                    Some(_) if field.contains(',') => {
                        column.comma = column.comma.take().or_else(|| Some(cell()));
                        commas.decimal |= !is_grouped(field.trim());
                    }
                    Some(value) => {
                        points |= field.contains('.');
                        commas.large |= value.abs() >= 100.0;
                    }
                }
                column.values.push(value.unwrap_or(f64::NAN));
            }
        }
        for (column, commas) in columns.iter_mut().zip(commas) {
            if commas.decimal || !(points || commas.large) {
                column.comma = None;
            }
        }
        // A separator at the end of every line creates an empty column.
        columns.pop_if(|last| last.name.is_empty() && last.wrong.is_none() && last.values.iter().all(|v| v.is_nan()));
        Ok(ColumnTable { columns, lines: numbers })
    }
}

/// Commas of a column.
#[derive(Debug, Clone, Copy, Default)]
struct Commas {
    /// A comma must be a decimal sign.
    decimal: bool,
    /// A number above 100 has none.
    large: bool,
}

/// Returns whether a comma may separate thousands: one to three digits before it and three behind.
fn is_grouped(number: &str) -> bool {
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    number.trim_start_matches(['+', '-']).split_once(',').is_some_and(|(thousands, rest)| {
        digits(thousands)
            && digits(rest)
            && (1..=3).contains(&thousands.len())
            && rest.len() == 3
            && !thousands.starts_with('0')
    })
}

/// Returns names and units from the last lines before the first row, if they have as many fields. Rows that are `open`
/// end with a separator, which the header may omit.
fn header_of(
    above: &[Line<'_>],
    separator: Separator,
    columns: usize,
    open: bool,
) -> Option<Vec<(String, Option<String>)>> {
    let fields = |line: Option<&Line<'_>>| -> Option<Vec<String>> {
        let mut fields: Vec<String> = Vec::new();
        for field in separator.fields(line?.text) {
            match fields.last_mut() {
                // `time [s]` between spaces is one field.
                Some(name) if separator == Separator::Space && field.starts_with(['[', '(']) => {
                    *name += " ";
                    *name += field;
                }
                _ => fields.push(field.to_owned()),
            }
        }
        if open && fields.len() + 1 == columns {
            fields.push(String::new());
        }
        let words = fields.iter().all(|field| number(field).is_none_or(f64::is_nan));
        (fields.len() == columns && words && fields.iter().any(|field| !field.is_empty())).then_some(fields)
    };
    let mut upward = above.iter().rev();
    let last = fields(upward.next())?;
    let fits = |field: &String| field.is_empty() || is_unit(bracketless(field));
    let owned = |field: &str| {
        let (name, unit) = header(field);
        (name.to_owned(), unit.map(str::to_owned))
    };
    let of_units = |(name, unit): (String, &String)| {
        let unit = bracketless(unit);
        if unit.is_empty() { owned(&name) } else { (name, Some(unit.to_owned())) }
    };
    match fields(upward.next()) {
        Some(names) if last.iter().all(fits) => Some(names.into_iter().zip(&last).map(of_units).collect()),
        _ => Some(last.iter().map(|field| owned(field)).collect()),
    }
}

/// Returns the most frequent number; the largest of several.
fn most_frequent(numbers: impl Iterator<Item = usize>) -> Option<usize> {
    let mut counts = std::collections::BTreeMap::new();
    for number in numbers {
        *counts.entry(number).or_insert(0_usize) += 1;
    }
    counts.into_iter().max_by_key(|(_, count)| *count).map(|(number, _)| number)
}

/// Returns the value of a cell, NaN if it is missing; `None` if it is not a number.
fn number(field: &str) -> Option<f64> {
    let field = field.trim();
    let parse = |text: &str| text.parse::<f64>().ok().map(|value| if value.is_finite() { value } else { f64::NAN });
    let comma = || {
        let is_decimal = field.matches(',').count() == 1 && !field.contains('.');
        is_decimal.then(|| parse(&field.replace(',', "."))).flatten()
    };
    let missing = || MISSING.contains(&field.to_lowercase().as_str()).then_some(f64::NAN);
    parse(field).or_else(comma).or_else(missing)
}

/// Returns name and unit of a header field: `Force [N]`, `t (s)`, `force / N`, `force_n`.
fn header(field: &str) -> (&str, Option<&str>) {
    let field = field.trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')] {
        if let Some((name, unit)) = field.strip_suffix(close).and_then(|rest| rest.rsplit_once(open)) {
            return (name.trim(), Some(unit.trim()));
        }
    }
    let known = |unit: &str| is_unit(unit);
    for sign in ["/", " in ", ","] {
        if let Some((name, unit)) =
            field.rsplit_once(sign).filter(|(name, unit)| !name.is_empty() && known(unit.trim()))
        {
            return (name.trim(), Some(unit.trim()));
        }
    }
    match field.rsplit_once('_') {
        // Names like `force_n` in newton, as in the tables of asperity.
        Some((name, "n")) if !name.is_empty() => (name, Some("N")),
        Some((name, unit)) if !name.is_empty() && known(unit) => (name, Some(unit)),
        _ => (field, None),
    }
}

fn bracketless(unit: &str) -> &str {
    unit.trim().trim_matches(['[', ']', '(', ')', '{', '}', '<', '>']).trim()
}

fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        Cow::Owned(String::from_utf16_lossy(&units))
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest),
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> ColumnTable {
        ColumnTable::read(text.as_bytes()).unwrap_or_else(|error| panic!("{text}: {error}"))
    }

    #[test]
    fn separators_decimal_signs_and_headers_are_recognised() {
        for text in [
            "time [s];force [N]\n0;1.5\n0.001;1.75\n",
            "time (s),force (N)\r\n0,1.5\r\n0.001,1.75\r\n",
            "time/s\tforce/N\n0\t1,5\n0,001\t1,75\n",
            "# made by a rig\n# time_s force_n\n0 1.5\n0.001 1.75\n",
            "Operator: A. B.\nLoad: 10 N\n\ntime;force\ns;N\n0;1,5\n0,001;1,75\n",
            "time [s];force [N];\n0;1,5;\n0,001;1,75;\n",
            "\u{feff}\"time [s]\",\"force [N]\"\n\"0\",\"1,5\"\n\"0,001\",\"1,75\"\n",
            "% time in s, force in N\n0, 1.5\n% a pause\n0.001, 1.75\n",
            "  time[s]   force[N]\n  0  1,5\n  0,001 1,75\n",
            "Speed;10\ntime;force\n[s];[N]\n0;1.5\n0.001;1.75\n",
            "time (s) force (N)\n0 1.5\n0.001 1.75\n",
        ] {
            let table = read(text);
            assert_eq!(table.names(), ["time", "force"], "{text}");
            let (time, force) = (table.column("time").unwrap(), table.column("FORCE [N]").unwrap());
            assert_eq!((time.unit, force.unit), (Some("s"), Some("N")), "{text}");
            assert_eq!((time.values, force.values), (&[0.0, 0.001][..], &[1.5, 1.75][..]), "{text}");
            assert_eq!(table.column("2").unwrap().values, force.values);
        }
        let utf16: Vec<u8> = "\u{feff}t [s];µ\n0;1\n1;2\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(ColumnTable::read(&utf16).unwrap().names(), ["t", "µ"]);
        assert_eq!(ColumnTable::read(b"t [s];\xb5\n0;1\n1;2\n").unwrap().names(), ["t", "µ"]);
    }

    #[test]
    fn one_column_with_decimal_commas_is_one_column() {
        let table = read("mu\n0,21\n0,22\n");
        assert_eq!(table.column("mu").unwrap().values, [0.21, 0.22]);
        assert_eq!(read("0.21\n0.22\n").column("1").unwrap().values, [0.21, 0.22]);
    }

    #[test]
    fn commas_that_may_separate_thousands_are_refused() {
        for text in ["t;F\n0.000;2,193\n0.001;2,251\n", "t\tF\n0.000\t999\n0.001\t1,002\n", "t;F\n0;998\n1;-1,002\n"] {
            let error = read(text).column("F").unwrap_err();
            assert!(error.to_string().contains("may separate thousands or be a decimal sign"), "{text}: {error}");
            assert!(read(text).column("t").is_ok());
        }
        for text in
            ["t;F\n0;2,193\n1;2,251\n", "t;F\n0.5;2,19\n1;2,251\n", "t;F\n0.5;0,219\n1;0,221\n", "t;F\n0;2,193\n1;7\n"]
        {
            assert!(read(text).column("F").unwrap().values[0] < 3.0, "{text}");
        }
    }

    #[test]
    fn missing_cells_are_gaps_and_text_is_an_error_of_its_column_alone() {
        let table = read("t;F;note\n0;1;start\n1;;\n2;NaN;\n3;inf;x\n4;#N/A;end\n");
        let force = table.column("F").unwrap().values;
        assert!(force[0] == 1.0 && force[1..].iter().all(|value| value.is_nan()));
        let error = table.column("note").unwrap_err();
        assert_eq!(error.to_string(), "line 2, column 3 (`note`): `start` is not a number");
        let table = read("t;F\n0;1\n1;2\n2;1.5.1\n");
        assert!(table.column("t").is_ok());
        assert_eq!(table.column("F").unwrap_err().to_string(), "line 4, column 2 (`F`): `1.5.1` is not a number");
    }

    #[test]
    fn two_columns_of_one_name_are_selected_by_number() {
        let table = read("t;mu;mu\n0;1;2\n1;2;3\n");
        let error = table.column("mu").unwrap_err();
        assert!(error.to_string().contains("several columns `mu`") && error.to_string().contains("3 `mu`"), "{error}");
        assert_eq!(table.column("3").unwrap().values, [2.0, 3.0]);
    }

    #[test]
    fn files_without_a_table_are_refused_with_the_line() {
        for text in ["", "\n\n", "time;force\n", "no numbers at all\nhere\n"] {
            assert_eq!(ColumnTable::read(text.as_bytes()), Err(MeasuredError::NoRows), "{text}");
        }
        let error = ColumnTable::read(b"t,F\n0,1\n1,2\n2\n").unwrap_err();
        assert_eq!(error, MeasuredError::Ragged { line: 4, found: 1, wanted: 2 });
        let error = read("time [s];friction force [N];3\n0;1;2\n1;1;2\n").column("frction").unwrap_err();
        assert!(error.to_string().contains("no column `frction`; the file has columns 1"), "{error}");
        let error = read("t [s];Force [N]\n0;1\n1;2\n").column("Kraft").unwrap_err();
        assert_eq!(error.to_string(), "no column `Kraft`; the file has columns 1 `t [s]`, 2 `Force [N]`");
        assert!(read("t;F\n0;1\n1;2\n").column("0").is_err() && read("t;F\n0;1\n1;2\n").column("3").is_err());
    }
}
