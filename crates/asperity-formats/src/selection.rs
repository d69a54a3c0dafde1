//! Selection of one map of a file.

use std::collections::{HashMap, HashSet};

use crate::error::first_of;
use crate::{Decimal, Format, FormatError, LengthUnit, Result, shown};

/// One of several height maps in a file: channels, layers, pages or arrays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Channel {
    /// By number, counted from 1.
    Number(usize),
    /// By name, as spelt in [`Scan::channels`](crate::Scan::channels), in any case.
    Name(String),
}

impl From<&str> for Channel {
    /// Interprets a whole number as a map number and any other text as a name.
    fn from(text: &str) -> Self {
        text.parse().map_or_else(|_| Self::Name(text.into()), Self::Number)
    }
}

/// Options for reading a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Height map to read. `None` reads the one that the format marks as its main map, or the first whose name is not that of another
    /// quantity, such as an amplitude.
    pub channel: Option<Channel>,
    /// Unit of the heights for a file that states none. It replaces the unit of other files, with a warning.
    ///
    /// It is the unit of the numbers in the file: a conversion factor in the header of a text is then not applied.
    pub height_unit: Option<LengthUnit>,
    /// Decimal sign of a text in which every comma may be a decimal sign or separate thousands.
    pub decimal: Option<Decimal>,
    /// Distance between points along (x, y) in metre for a file that states none. It replaces the distance in other
    /// files, with a warning. The check that compares the span of the heights with the field of view uses it.
    pub pitch_m: Option<(f64, f64)>,
}

impl ReadOptions {
    /// Returns the index in `names` of the map to read.
    ///
    /// # Errors
    /// [`FormatError::NoSuchChannel`] with all names.
    pub(crate) fn choose(&self, format: Format, names: &[String]) -> Result<usize> {
        self.choose_or(format, names, None)
    }

    /// Returns the index in `names` of the map to read, `main` if none is asked for.
    ///
    /// # Errors
    /// As [`ReadOptions::choose`].
    pub(crate) fn choose_or(&self, format: Format, names: &[String], main: Option<usize>) -> Result<usize> {
        let place = match &self.channel {
            None if main.is_some() => main,
            None => names.iter().position(|name| !is_other_quantity(name)).or(Some(0)),
            Some(Channel::Number(number)) => number.checked_sub(1),
            Some(Channel::Name(name)) => {
                let exact = names.iter().position(|candidate| candidate == name);
                let folded = || names.iter().position(|candidate| candidate.to_lowercase() == name.to_lowercase());
                exact.or_else(folded)
            }
        };
        place.filter(|&place| place < names.len()).ok_or_else(|| FormatError::NoSuchChannel {
            format,
            found: match &self.channel {
                Some(Channel::Number(number)) => format!("number {number}"),
                Some(Channel::Name(name)) => format!("`{}`", shown(name)),
                None => "a first one".into(),
            },
            channels: names.to_vec(),
        })
    }
}

/// Returns whether the name of a map of lengths is that of another quantity than the height, such as the amplitude of a cantilever.
fn is_other_quantity(name: &str) -> bool {
    const OTHERS: &str =
        "amplitude phase deflection error deformation friction lateral indentation intensity separation user";
    let name = name.to_lowercase();
    OTHERS.split(' ').any(|other| name.contains(other))
}

/// Appends a number to names that repeat an earlier one, so that each can be selected.
pub(crate) fn unique(names: Vec<String>) -> Vec<String> {
    let mut taken: HashSet<String> = HashSet::new();
    let mut repeats: HashMap<String, usize> = HashMap::new();
    let mut distinct = |name: String| {
        let count = repeats.entry(name.clone()).or_insert(0);
        let mut candidate = name.clone();
        loop {
            *count += 1;
            if *count > 1 {
                candidate = format!("{name} {count}");
            }
            if taken.insert(candidate.clone()) {
                return candidate;
            }
        }
    };
    names.into_iter().map(&mut distinct).collect()
}

/// Lists the first 8 of several names for a message.
pub(crate) fn some_of(names: &[String]) -> String {
    first_of(names, 8, |name| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choose(channel: Option<&str>) -> Option<usize> {
        let options = ReadOptions { channel: channel.map(Channel::from), ..ReadOptions::default() };
        options.choose(Format::Gwy, &["Height".into(), "Phase".into(), "height".into()]).ok()
    }

    #[test]
    fn channels_are_chosen_by_number_or_name() {
        let cases = [(None, 0), (Some("2"), 1), (Some("PHASE"), 1), (Some("height"), 2)];
        assert!(cases.iter().all(|&(channel, place)| choose(channel) == Some(place)));
    }

    #[test]
    fn names_that_repeat_are_numbered() {
        let names = |names: &[&str]| unique(names.iter().map(|&name| name.into()).collect());
        assert_eq!(names(&["a", "b", "a", "a"]), ["a", "b", "a 2", "a 3"]);
        assert_eq!(names(&["a 2", "a", "a", "a 2"]), ["a 2", "a", "a 3", "a 2 2"]);
    }

    #[test]
    fn a_channel_that_is_not_there_is_refused_with_the_names_of_all() {
        for wrong in ["0", "4", "amplitude", ""] {
            assert_eq!(choose(Some(wrong)), None, "{wrong}");
        }
        let options = ReadOptions { channel: Some(Channel::Number(3)), ..ReadOptions::default() };
        let message = options.choose(Format::Gwy, &["a".into(), "b".into()]).unwrap_err().to_string();
        assert_eq!(message, "GWY: no height map number 3; the file holds `a`, `b`");
    }
}
