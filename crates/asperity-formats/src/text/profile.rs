//! Profiles: heights along one line, as styluses record them.

use super::columns::{Column, named};
use super::header::Header;
use crate::{Format, FormatError, ReadOptions, Result, Shape, large, shown};

/// Fewest points of a profile with positions.
const FEWEST: usize = 4;
/// Fewest numbers that do not rise or fall by chance.
pub(super) const MANY: usize = 8;
/// Name of a column with 0 for heights that are missing and 1 for others, as in HFM files.
const VALID: &str = "valid";
/// Start of the name that data frames give a column without one.
const UNNAMED: &str = "Unnamed:";
/// Usual names of positions and of heights, in small letters.
const POSITIONS: [&str; 9] =
    ["x", "position", "pos", "lateral", "distance", "length", "abscissa", "x position", "lateral position"];
const HEIGHTS: [&str; 8] = ["z", "height", "heights", "profile", "total profile", "raw", "level", "y"];
/// Distance of a position from its place in equal steps, in steps, up to which the steps count as equal.
const TOLERANCE: f64 = 0.25;

/// Heights of a profile in the order of rising positions.
pub(super) struct Profile {
    pub(super) heights: Vec<f64>,
    /// Distance between points in the unit of the positions; `None` for heights alone.
    pub(super) step: Option<f64>,
    /// Names of all columns of heights; empty without names.
    pub(super) channels: Vec<String>,
    /// Index of the column that was read.
    pub(super) channel: usize,
    /// Units of positions and heights behind the names of their columns.
    pub(super) units: [Option<String>; 2],
    /// Form of the text, for the user.
    pub(super) form: String,
}

impl Profile {
    /// Returns whether the header names the columns.
    pub(super) fn is_named(&self) -> bool {
        !self.channels.is_empty()
    }

    /// Adds the units of the columns to the header, and returns a sentence for the user.
    pub(super) fn describe(&self, header: &mut Header) -> String {
        // The first keys of both units: those of the columns count before those of the rest of the header.
        for (key, unit) in ["x unit", "value units"].into_iter().zip(&self.units) {
            if let Some(unit) = unit {
                header.insert_first(key, unit);
            }
        }
        format!("this is a profile: {}", self.form)
    }
}

/// Columns of a profile, by what their names and units say.
struct Roles {
    positions: usize,
    heights: Vec<usize>,
    /// Column of zeros where the height is missing.
    valid: Option<usize>,
}

impl Roles {
    /// Returns the roles of named columns; `None` if the names are not those of a profile. Columns without a unit and a known name have no
    /// role, among them an index of the rows.
    fn of(columns: &[Column]) -> Option<Self> {
        let name = |place: &usize| columns[*place].name.to_lowercase();
        let is_position = |place: &usize| POSITIONS.contains(&name(place).as_str());
        let is_height = |place: &usize| HEIGHTS.contains(&name(place).as_str());
        let valid = (0..columns.len()).find(|place| name(place) == VALID);
        let named: Vec<usize> =
            (0..columns.len()).filter(|place| Some(*place) != valid && !name(place).is_empty()).collect();
        let is_point = named.iter().any(|place| name(place) == "y") && named.len() > 2;
        let lengths = || named.iter().filter(|place| columns[**place].per_metre().is_some());
        let by_name = named.iter().find(|place| is_position(place));
        let is_other = |place: &&usize| !is_height(place) || lengths().count() > 1;
        let by_unit = || lengths().find(|place| !is_height(place)).or_else(|| lengths().find(is_other));
        let positions = *by_name.or_else(by_unit)?;
        let others = || named.iter().copied().filter(|place| *place != positions);
        let is_length = |place: &usize| columns[*place].per_metre().is_some() || is_height(place);
        let mut heights: Vec<usize> = others().filter(is_length).collect();
        if heights.is_empty() {
            // Another quantity is refused by its unit.
            heights = others().filter(|place| columns[*place].unit.is_some()).collect();
        }
        // Without a unit of the positions, both names must be usual ones.
        let is_known =
            heights.first().is_some_and(|place| is_height(place) || columns[positions].per_metre().is_some());
        (is_known && !is_point).then_some(Self { positions, heights, valid })
    }
}

/// Returns the columns of a header that names positions and heights, with their units or by usual names. Further columns have no name, and a
/// column before all others has none if it is the index of the rows.
pub(super) fn names(head: &[u8], columns: usize) -> Option<Vec<Column>> {
    named(head, |found| {
        let count = found.iter().rposition(|column| !column.name.is_empty())? + 1;
        let mut found = found[..count].to_vec();
        if let Some(index) = found.first_mut().filter(|column| column.name.starts_with(UNNAMED)) {
            index.name.clear();
        }
        // A key with its value, `z unit = um`, is no list of names.
        let is_name = |column: &Column| column.name.contains(char::is_alphabetic);
        let is_profile = count <= columns && found[1..].iter().all(is_name);
        (is_profile && Roles::of(&found).is_some()).then_some(found)
    })
}

/// Returns whether a header names a position and heights, one for each column.
pub(crate) fn is_profile(head: &[u8], columns: usize) -> bool {
    names(head, columns).is_some_and(|names| names.len() == columns)
}

/// Returns the profile that a matrix of numbers is; `None` for a map. A profile is a single row or column, two columns or rows of which the
/// first rises or falls, or columns with `names`.
///
/// # Errors
/// The positions do not step equally, or the options choose a column that does not exist.
pub(super) fn of(
    values: &[f64],
    (rows, columns): Shape,
    names: Option<Vec<Column>>,
    options: &ReadOptions,
) -> Result<Option<Profile>> {
    let column = |place: usize| values.iter().copied().skip(place).step_by(columns).collect::<Vec<f64>>();
    let plain = |heights: Vec<f64>, form: String| {
        Ok(Some(Profile { heights, step: None, channels: vec![], channel: 0, units: [None, None], form }))
    };
    let is_empty = |place: usize| column(place).iter().all(|z| z.is_nan());
    // The names of a data frame may leave out the one of the index.
    let shift = |names: &Vec<Column>| usize::from(names.len() + 1 == columns && !is_empty(columns - 1));
    if names.as_ref().is_some_and(|names| names.len() > columns) {
        let found = "a profile whose last column is empty";
        return Err(FormatError::unsupported(Format::Text, found, "numbers in every column that has a name"));
    }
    let are_complete = |names: &Vec<Column>| rows > 1 && (names.len() + shift(names)..columns).all(is_empty);
    if let Some(names) = names.filter(are_complete)
        && let Some(Roles { positions, heights, valid }) = Roles::of(&names)
    {
        let shift = shift(&names);
        let channels: Vec<String> = heights.iter().map(|place| names[*place].name.clone()).collect();
        let channel = options.choose(Format::Text, &channels)?;
        let place = heights[channel];
        let units = [&names[positions], &names[place]].map(|column| column.unit.clone());
        let mut found = column(place + shift);
        if let Some(valid) = valid {
            large::hide(&mut found, column(valid + shift).into_iter().map(|valid| valid.is_nan() || valid == 0.0));
        }
        let has_role = |place: &usize| *place == positions || Some(*place) == valid || heights.contains(place);
        let others: Vec<&str> =
            (0..names.len()).filter(|place| !has_role(place)).map(|place| names[place].name.as_str()).collect();
        let left_out = others.into_iter().filter(|name| !name.is_empty()).map(shown).collect::<Vec<_>>().join(", ");
        let mut form = "columns of positions and heights".to_owned();
        if !left_out.is_empty() {
            form += &format!("; `{left_out}` was left out");
        }
        let found = stepped(&column(positions + shift), found, form, options)?;
        return Ok(Some(Profile { channels, channel, units, ..found }));
    }
    // Nothing is known about a row or column of voids alone.
    if values.iter().all(|value| value.is_nan()) {
        return Ok(None);
    }
    match (rows, columns) {
        (FEWEST.., 1) => plain(values.to_vec(), format!("a single column of {rows} numbers")),
        (1, FEWEST..) => plain(values.to_vec(), format!("a single row of {columns} numbers")),
        (FEWEST.., 2) if runs(&column(0)) => {
            let form = format!("two columns, of which the first rises or falls over {rows} rows");
            stepped(&column(0), column(1), form, options).map(Some)
        }
        (2, FEWEST..) if runs(&values[..columns]) => {
            let form = format!("two rows, of which the first rises or falls over {columns} columns");
            stepped(&values[..columns], values[columns..].to_vec(), form, options).map(Some)
        }
        _ => Ok(None),
    }
}

/// Returns whether numbers rise or fall from each to the next. Many may repeat the last three times, as rounded positions do.
fn runs(numbers: &[f64]) -> bool {
    let least = if numbers.len() >= MANY { 0.0 } else { f64::MIN_POSITIVE };
    let all = |sign: f64| numbers.windows(2).all(|pair| sign * (pair[1] - pair[0]) >= least);
    let changes = numbers.windows(2).filter(|pair| pair[0] != pair[1]).count();
    4 * changes >= numbers.len() && (all(1.0) || all(-1.0))
}

/// Returns the profile of heights at positions in equal steps. A stated distance between points replaces the positions.
fn stepped(positions: &[f64], mut heights: Vec<f64>, form: String, options: &ReadOptions) -> Result<Profile> {
    let (first, last) = (positions[0], positions[positions.len() - 1]);
    let step = (last - first) / (positions.len() - 1) as f64;
    let fits =
        |(place, position): (usize, &f64)| (position - first - step * place as f64).abs() <= TOLERANCE * step.abs();
    if options.pitch_m.is_none() && (step == 0.0 || !positions.iter().enumerate().all(fits)) {
        let steps = || positions.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let shown = |step: f64| format!("{step:.3e}").parse::<f64>().unwrap_or(step);
        let [low, high] = [steps().fold(f64::INFINITY, f64::min), steps().fold(0.0, f64::max)].map(shown);
        let found = format!("a profile ({form}) whose positions step by {low} to {high}");
        return Err(FormatError::unsupported(Format::Text, found, "positions in equal steps"));
    }
    if step < 0.0 {
        heights.reverse();
    }
    Ok(Profile { heights, step: Some(step.abs()), channels: vec![], channel: 0, units: [None, None], form })
}
