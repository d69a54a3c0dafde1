//! Points x, y, z on a grid as text, one point per line, and the XYZ files of Zygo.
//!
//! Points follow each other along x or along y, in either direction, or in any order. The reader determines the grid from the
//! coordinates. A point may differ from its grid point by [a quarter of a step](grid::TOLERANCE), which allows for
//! the rounding of coarse digits and for the jitter of a stage. The header may name the columns x, y and z in another order. A fourth column,
//! often an intensity, is left out, and so are an index of the rows and any columns beside those that a header names x, y
//! and z. Missing are grid points without a point, and heights
//! `nan`, `BAD` and `No Data`. Lists that leave three of four grid points empty are refused, and so are two points on
//! one grid point.
//!
//! y points down, as in SUR and Zygo files: the smallest y is row 0. Units are in a header: `x [mm] y [mm] z [um]`,
//! `mm, mm, um`, or keys such as `unit: um` and `z unit: nm`. Without units, all coordinates are in metre, with a
//! warning for a spacing above a millimetre.
//!
//! A Zygo file starts with 13 lines and `#`. Its x and y count pixels from the upper left corner, heights are in
//! micrometre, and the header states the pixel size in metre. (Zygo, *MetroPro Reference Guide* OMP-0347, appendix
//! B.)

mod grid;

use ndarray::Array2;

use crate::text::columns::{Column, named};
use crate::text::decimal::Decimal;
use crate::text::header::{Header, unit};
use crate::text::profile::is_profile;
use crate::text::rows::{self, Layout};
use crate::text::separator::{COMMENT, Separator};
use crate::text::{Head, TEXT_PROBE, is_text, lines, utf8};
use crate::unit::in_words;
use crate::{Description, Format, FormatError, Location, ReadOptions, Result, Scan, shown, utf8_or_latin1, warn_if};
use grid::{Grid, MAX_SPREAD, NoGrid, Points, TOLERANCE};

pub(crate) const CODEC: Description = Description {
    extensions: &["xyz"],
    vendor: "any; Zygo",
    known_by: "three or four columns of which the first two step like a grid, or columns that a header names x, y and z; `Zygo XYZ Data \
               File`",
    reads: "points on a grid in any order of lines; columns in the order of their names; spaces, tabs, commas or semicolons; units from \
            the header",
    missing_points: "nan, 1.#QNAN, BAD, No Data, grid points without a point",
    orientation: "y points down: the smallest y is row 0, as the first line of SUR",
    ..Description::new(Format::Xyz, detect, read)
};

/// Places of the columns x, y and z without names, and behind an index of the rows.
const IN_ORDER: [usize; 3] = [0, 1, 2];
const INDEXED: [usize; 3] = [1, 2, 3];
/// Names of the heights.
const HEIGHTS: [&str; 3] = ["z", "height", "h"];
/// Most columns of points without names: with an index or another quantity.
const MOST_COLUMNS: usize = 4;
/// First bytes of a Zygo file.
const ZYGO: &[u8] = b"Zygo XYZ Data File";
/// Ratio of a step between lines to the usual step across a line, which is jitter or zero.
const JITTER: f64 = 4.0;
/// Number of steps along a line that outweigh one against the grid.
const AGAINST: usize = 4;
/// Minimum number of steps along a line if the probe contains no second line.
const MIN_STEPS: usize = 8;
/// Spacing above which coordinates are unlikely to be in metre.
const MAX_PLAUSIBLE_M: f64 = 1e-3;

/// Returns whether the header names three columns x, y and z, or the first lines are points of a grid: along a line
/// one of the first two values changes in steps and the other stays constant, or the points fill a grid in any order.
///
/// Maps with three columns of heights do not have this pattern.
fn detect(bytes: &[u8]) -> bool {
    if bytes.starts_with(ZYGO) {
        return true;
    }
    if !is_text(bytes) {
        return false;
    }
    let probe = utf8(&bytes[..bytes.len().min(TEXT_PROBE)]);
    let (probe, line_end) = lines(&probe);
    let whole = bytes.len() <= TEXT_PROBE;
    // The last line of a longer text is incomplete.
    let end = probe.iter().rposition(|&byte| byte == line_end).filter(|_| !whole).unwrap_or(probe.len());
    let head = Head::read(&probe[..end], line_end, true, None);
    let columns = layout(&head.first_row, line_end, head.decimal()).count(&head.first_row);
    let Some(columns @ 3..) = columns.filter(|_| !head.header.states_pixels()) else { return false };
    let (before, points) = probe[..end].split_at(head.start.min(end));
    let is_named = named_columns(before, columns).is_some();
    if is_named || columns > MOST_COLUMNS || is_profile(before, columns) {
        return is_named;
    }
    let readings = |text: &[u8]| -> Vec<Vec<f64>> {
        let read = |decimal| {
            let table = rows::read(text, &layout(&head.first_row, line_end, decimal), 0)?;
            Ok::<_, FormatError>(points_of(&table.values, columns, places_of(&table.values, columns)))
        };
        match read(head.decimal()) {
            // Points step like a grid whatever their decimal sign is.
            Err(FormatError::AmbiguousDecimal { .. }) => {
                [Decimal::Comma, Decimal::Point].into_iter().filter_map(|decimal| read(Some(decimal)).ok()).collect()
            }
            found => found.into_iter().collect(),
        }
    };
    if readings(points).iter().any(|points| steps_like_a_grid(points, whole)) {
        return true;
    }
    // Only the whole list shows that points in any order fill a grid.
    let text = utf8(bytes);
    let (text, _) = lines(&text);
    readings(&text[head.start.min(text.len())..]).iter().any(|points| Points(points).are_shuffled())
}

/// Places of the columns x, y and z, with the columns.
type Columns = [(usize, Column); 3];

/// Returns the columns x, y and z as the last line of the header that names all columns: `x [um] y [um] z [um]`, `X;Y;Z` or `# x/mm, y/mm, z/um`.
fn named_columns(head: &[u8], columns: usize) -> Option<Columns> {
    named(head, |found| {
        let place = |wanted: &str| {
            let place = found.iter().position(|column| column.name.eq_ignore_ascii_case(wanted))?;
            Some((place, found[place].clone()))
        };
        let height = || HEIGHTS.iter().find_map(|name| place(name));
        let places = [place("x")?, place("y")?, height()?];
        // An index of the rows may have no name.
        let unnamed =
            columns.checked_sub(found.len()).filter(|unnamed| *unnamed == 0 || columns > 3 && *unnamed == 1)?;
        Some(places.map(|(place, column)| (place + unnamed, column)))
    })
}

/// Returns the places of x, y and z without names: behind an index if the first of four columns rises from row to row in whole numbers, as
/// no coordinate of a grid does.
fn places_of(values: &[f64], columns: usize) -> [usize; 3] {
    let index = || values.chunks_exact(columns).map(|row| row[0]);
    let is_index = columns == MOST_COLUMNS
        && values.len() > columns
        && index().all(|value| value.fract() == 0.0)
        && index().zip(index().skip(1)).all(|(here, next)| next > here);
    if is_index { INDEXED } else { IN_ORDER }
}

/// Returns x, y and z of points with further columns or another order.
fn points_of(values: &[f64], columns: usize, places: [usize; 3]) -> Vec<f64> {
    values.chunks_exact(columns).flat_map(|point| places.map(|place| point[place])).collect()
}

fn layout(first_row: &[u8], line_end: u8, decimal: Option<Decimal>) -> Layout {
    let separator = Separator::detect(first_row, decimal);
    let layout = Layout::new(Format::Xyz, separator, COMMENT, line_end).with_decimal(decimal);
    let columns = layout.count(first_row).filter(|columns| *columns >= 3);
    layout.with_columns(columns.unwrap_or(3))
}

fn steps_like_a_grid(values: &[f64], whole: bool) -> bool {
    let steps =
        |axis: usize| values.chunks_exact(3).zip(values.chunks_exact(3).skip(1)).map(move |(a, b)| b[axis] - a[axis]);
    let usual = |axis| {
        let mut steps: Vec<f64> = steps(axis).map(f64::abs).collect();
        steps.sort_unstable_by(f64::total_cmp);
        steps.get(steps.len().saturating_sub(1) / 2).copied().unwrap_or(0.0)
    };
    let usual = [usual(0), usual(1)];
    let fast = usize::from(usual[1] > usual[0]);
    let (mut along, mut between, mut against, mut direction) = (0, 0, 0, 0.0);
    for (fast_step, slow_step) in steps(fast).zip(steps(1 - fast)) {
        if fast_step.is_nan() || slow_step.is_nan() {
            continue;
        }
        let goes_on = fast_step.abs() >= 0.5 * usual[fast] && fast_step * direction >= 0.0 && fast_step != 0.0;
        // If lines are closer than the points on them, only a change of direction shows the start of a new line.
        let is_far = slow_step.abs() > TOLERANCE * usual[fast];
        if is_far || !goes_on && slow_step.abs() > JITTER * usual[1 - fast] {
            between += 1;
            direction = 0.0;
        } else if goes_on {
            along += 1;
            direction = fast_step;
        } else {
            // A return to an earlier position.
            against += 1;
            direction = 0.0;
        }
    }
    along > between + AGAINST * against
        && if whole { along >= 3 && between >= 1 } else { along >= MIN_STEPS || along >= 3 && between >= 1 }
}

fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let text = utf8(bytes);
    let (bytes, line_end) = lines(&text);
    if bytes.starts_with(ZYGO) {
        read_zygo(bytes, line_end, options.decimal)
    } else {
        read_points(bytes, line_end, options)
    }
}

fn read_points(bytes: &[u8], line_end: u8, options: &ReadOptions) -> Result<Scan> {
    let head = Head::read(bytes, line_end, true, options.decimal);
    let layout = layout(&head.first_row, line_end, head.decimal());
    let Head { mut header, start, lines, .. } = head;
    let list = List { bytes: &bytes[start..], lines, layout, line_end };
    let mut table = list.table()?;
    for comment in std::mem::take(&mut table.comments) {
        header.add(&comment);
    }
    let (head, columns) = (&bytes[..start], list.layout.columns().unwrap_or(3));
    let named = named_columns(head, columns);
    let places = match &named {
        Some(named) => named.each_ref().map(|(place, _)| *place),
        None => places_of(&table.values, columns),
    };
    if columns > 3 || places != IN_ORDER {
        table.values = points_of(&table.values, columns, places);
    }
    let mut warnings = Vec::new();
    warn_if!(warnings, columns > 3, "a point has {columns} values; those beside x, y and z were left out");
    let units = units(&header, head, named, options)?;
    let grid = Points(&table.values).grid().map_err(|reason| {
        let (sound, flaw) = Points(&table.values).sound();
        let is_list = steps_like_a_grid(&table.values, true);
        match flaw.filter(|_| is_list || Points(&sound).grid().is_ok()) {
            Some(flaw) => list.error(&flaw),
            None if is_list => list.error(&reason),
            None => no_grid(Points(&table.values).spacing() / units[0].unwrap_or(1.0)),
        }
    })?;
    drop(table);
    let [per_metre_x, per_metre_y, per_metre_z] = units.map(|unit| unit.unwrap_or(1.0));
    let [dx_m, dy_m] = [grid.axes[0].step / per_metre_x, grid.axes[1].step / per_metre_y];
    if units[0].is_none() && dx_m.max(dy_m) > MAX_PLAUSIBLE_M {
        let taken = if options.height_unit.is_some() { "x and y" } else { "x, y and z" };
        warnings.push(format!(
            "no unit is stated; {taken} count as metre, which gives pixels of {} × {}",
            in_words(dx_m),
            in_words(dy_m)
        ));
    }
    let heights_m = map(grid)?.mapv_into(|z| z / per_metre_z);
    let height_unit = units[2].and_then(crate::unit::name).map(str::to_owned);
    Ok(Scan { metadata: header.metadata(), warnings, height_unit, ..Scan::new(heights_m, Some((dx_m, dy_m))) })
}

fn map(grid: Grid) -> Result<Array2<f64>> {
    let [columns, rows] = grid.axes.map(|axis| axis.lines);
    Array2::from_shape_vec((rows, columns), grid.heights).map_err(|_| nothing(1))
}

/// Returns the number of units per metre for x, y and z: from keys, from the line that names the columns, or from words in brackets or
/// columns of the header.
///
/// # Errors
/// Some of the named columns have a unit and others have none, or a unit is not one of length. A stated unit replaces that of the heights.
fn units(header: &Header, head: &[u8], named: Option<Columns>, options: &ReadOptions) -> Result<[Option<f64>; 3]> {
    let is_stated = options.height_unit.is_some();
    let keyed = header.units();
    if keyed.iter().any(Option::is_some) || header.other_unit().is_some() {
        return match header.other_unit().filter(|_| !is_stated) {
            Some(other) => Err(other_unit(other)),
            None => Ok(keyed),
        };
    }
    if let Some(named) = named.filter(|named| named.iter().any(|(_, column)| column.unit.is_some())) {
        let replaced = if is_stated { 2 } else { 3 };
        let others = named.iter().take(replaced).filter(|(_, column)| column.per_metre().is_none());
        if let Some(other) = others.filter_map(|(_, column)| column.unit.as_deref()).next() {
            return Err(other_unit(other));
        }
        let [x, y, z] = named.map(|(_, column)| column.per_metre());
        let lateral = [x.or(y), y.or(x)];
        return match (lateral, z) {
            ([Some(x), Some(y)], z) if is_stated || z.is_some() => Ok([Some(x), Some(y), z]),
            _ => Err(unsupported_columns(
                "a header in which some of the columns x, y and z have a unit of length".into(),
            )),
        };
    }
    let text = utf8_or_latin1(head);
    let in_brackets = text.split(['[', '(']).skip(1).filter_map(|rest| unit(rest.split([']', ')']).next()?));
    // `mm mm um`: every column ends with a unit.
    let in_columns = |line: &str| {
        let words = line.trim_start_matches(['#', '%']).split([' ', '\t', ',', ';', '\r']);
        let words = words.filter(|word| !word.is_empty()).map(|word| unit(word.rsplit('/').next().unwrap_or(word)));
        words.collect::<Option<Vec<_>>>().filter(|units| matches!(units.len(), 1 | 3))
    };
    let mut found: Vec<f64> = in_brackets.take(MOST_COLUMNS).collect();
    if found.is_empty() {
        found = text.lines().find_map(in_columns).unwrap_or_default();
    }
    Ok(match found[..] {
        [all] => [Some(all); 3],
        [lateral, z] => [Some(lateral), Some(lateral), Some(z)],
        [x, y, z] => [Some(x), Some(y), Some(z)],
        _ => [None; 3],
    })
}

fn other_unit(unit: &str) -> FormatError {
    unsupported_columns(format!("coordinates in `{}`", shown(unit)))
}

fn unsupported_columns(found: String) -> FormatError {
    let wanted = "a unit of length for each of x, y and z, such as `x (mm), y (mm), z (um)`";
    FormatError::unsupported(Format::Xyz, found, wanted)
}

/// Lines of points in a text.
struct List<'a> {
    bytes: &'a [u8],
    /// Number of lines before the first point.
    lines: usize,
    layout: Layout,
    line_end: u8,
}

impl List<'_> {
    fn table(&self) -> Result<rows::Table> {
        let table = rows::read(self.bytes, &self.layout, self.lines).map_err(|error| match error {
            FormatError::Ragged { line, found, .. } => {
                FormatError::field(Format::Xyz, "the number of values", Location::Line(line), found, "3: x, y and z")
            }
            error => error,
        })?;
        if table.rows == 0 { Err(nothing(self.lines + 1)) } else { Ok(table) }
    }

    /// Returns the line of a point, counted from 1.
    fn line(&self, point: usize) -> usize {
        let mut rows = self
            .bytes
            .split(|&byte| byte == self.line_end)
            .enumerate()
            .filter(|(_, line)| self.layout.count(line).is_some_and(|values| values > 0));
        self.lines + rows.nth(point).map_or(0, |(index, _)| index) + 1
    }

    fn error(&self, reason: &NoGrid) -> FormatError {
        let name = |axis: usize| ["x", "y"][axis];
        let field = |field: &str, point: usize, found: String, wanted: &str| {
            FormatError::field(Format::Xyz, field, Location::Line(self.line(point)), found, wanted)
        };
        match *reason {
            NoGrid::NotFinite { point, axis } => field(name(axis), point, "not finite".into(), "a number"),
            NoGrid::Off { point, axis, steps } => field(
                name(axis),
                point,
                format!("{steps:.2} steps off the grid"),
                &format!("at most {TOLERANCE}; interpolate the heights onto a regular grid"),
            ),
            NoGrid::Twice { point } => field(
                "the point",
                point,
                "in the place of another".into(),
                "one point for each place of the grid; leave repeated points out or average them",
            ),
            NoGrid::Line { axis } => unsupported(format!("the points have no grid along {}", name(axis))),
            NoGrid::Sparse { columns, rows } => unsupported(format!(
                "the points would fill less than 1 of {MAX_SPREAD} places of a grid of {columns} × {rows}"
            )),
        }
    }
}

fn unsupported(found: String) -> FormatError {
    let wanted = "points on a regular grid; interpolate the heights onto one and save them again";
    FormatError::unsupported(Format::Xyz, found, wanted)
}

/// Returns the error for points without a grid, which are so far apart on average.
fn no_grid(spacing_m: f64) -> FormatError {
    let apart = if spacing_m > 0.0 { format!(", some {} apart", in_words(spacing_m)) } else { String::new() };
    unsupported(format!("the three columns are points x, y, z that lie on no regular grid{apart}"))
}

fn nothing(line: usize) -> FormatError {
    FormatError::missing(Format::Xyz, "a line of x, y and z", Location::Line(line), "one point per line")
}

/// Number of lines of a Zygo header before its end, and the lines that become metadata.
const ZYGO_LINES: usize = 13;
const ZYGO_NOTES: [(usize, &str); 5] =
    [(1, "software"), (4, "comment"), (5, "part serial number"), (6, "part number"), (8, "system")];
/// Line of the pixel size, and its index among the words.
const CAMERA_RESOLUTION: (usize, usize) = (7, 6);
/// Number of height units of Zygo files per metre: heights are in micrometre.
const ZYGO_PER_METRE: f64 = 1e6;

fn read_zygo(bytes: &[u8], line_end: u8, decimal: Option<Decimal>) -> Result<Scan> {
    let (mut head, mut start) = (Vec::new(), 0);
    for line in bytes.split(|&byte| byte == line_end).take(2 * ZYGO_LINES) {
        start += line.len() + 1;
        if line.trim_ascii() == b"#" {
            break;
        }
        head.push(utf8_or_latin1(line.trim_ascii()));
    }
    if head.len() < ZYGO_LINES || start >= bytes.len() {
        let (at, wanted) = (Location::Line(head.len() + 1), format!("{ZYGO_LINES} lines, `#`, and the points"));
        return Err(FormatError::missing(Format::Xyz, "the line `#` after the header", at, wanted));
    }
    let layout = layout(b"", line_end, decimal);
    let list = List { bytes: &bytes[start..], lines: head.len() + 1, layout, line_end };
    let table = list.table()?;
    let grid = Points(&table.values).grid().map_err(|reason| list.error(&reason))?;
    let mut warnings = Vec::new();
    let (line, place) = CAMERA_RESOLUTION;
    let resolution_m = head[line].split_whitespace().nth(place).and_then(|word| word.parse::<f64>().ok());
    let pitch_m = resolution_m
        .filter(|resolution| *resolution > 0.0)
        .map(|resolution| (grid.axes[0].step * resolution, grid.axes[1].step * resolution));
    warn_if!(warnings, pitch_m.is_none(), "the camera was not calibrated; no pixel size was read");
    let mut header = Header::default();
    header.insert("format", &head[0]);
    for (line, key) in ZYGO_NOTES {
        header.insert(key, head[line].trim_matches('"').trim());
    }
    let heights_m = map(grid)?.mapv_into(|z| z / ZYGO_PER_METRE);
    let height_unit = Some("um".into());
    Ok(Scan { metadata: header.metadata(), warnings, height_unit, ..Scan::new(heights_m, pitch_m) })
}
