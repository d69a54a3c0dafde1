//! Headers of keys and values, in sections or not, as several programs write before binary data.

use std::borrow::Cow;
use std::str::FromStr;

use crate::scan::shape;
use crate::{Format, FormatError, Location, Result, Scan, Shape, TextLimit, shown};

/// Header, or section of one.
pub(crate) struct Section<'a> {
    format: Format,
    /// Name; empty for fields before the first section.
    pub(crate) name: &'a str,
    /// Place at which an absent field is missed.
    pub(crate) at: Location,
    /// Description of a field for the error that it is missing.
    wanted: &'static str,
    /// Keys, values and places.
    fields: Vec<(Cow<'a, str>, Cow<'a, str>, Location)>,
}

/// Number in a field.
pub(crate) trait Number: FromStr {
    /// Description for the error that a text is none.
    const WANTED: &'static str;
}

impl Number for f64 {
    const WANTED: &'static str = "a number";
}

impl Number for i64 {
    const WANTED: &'static str = "a whole number";
}

impl Number for usize {
    const WANTED: &'static str = "a whole number, 0 or more";
}

/// Splits a header into sections. `name` returns the name of a section from the line that starts it; `separator` stands between the key
/// and the value of a field.
pub(crate) fn sections<'a>(
    format: Format,
    text: &'a str,
    separator: &str,
    name: fn(&str) -> Option<&str>,
) -> Vec<Section<'a>> {
    const WANTED: &str = "a field of the header";
    let mut sections = vec![Section::new(format, Location::Byte(0), WANTED)];
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if let Some(name) = name(line.trim()) {
            sections.push(Section { name, ..Section::new(format, Location::Byte(at), WANTED) });
        } else if let (Some((key, value)), Some(section)) = (line.split_once(separator), sections.last_mut()) {
            // Some programs write a backslash before every key.
            section.push(key.trim().trim_start_matches('\\'), value.trim(), section.at.clone());
        }
        at += line.len() as u64;
    }
    sections
}

/// Returns the section with this name.
///
/// # Errors
/// There is none.
pub(crate) fn section<'s, 'a>(sections: &'s [Section<'a>], name: &str) -> Result<&'s Section<'a>> {
    let found = sections.iter().find(|section| section.name.eq_ignore_ascii_case(name));
    found.ok_or_else(|| FormatError::missing(sections[0].format, name, Location::Byte(0), "a section of the header"))
}

impl<'a> Section<'a> {
    /// Creates a header without fields.
    pub(crate) fn new(format: Format, at: Location, wanted: &'static str) -> Self {
        Self { format, name: "", at, wanted, fields: Vec::new() }
    }

    /// Adds a field.
    pub(crate) fn push(&mut self, key: impl Into<Cow<'a, str>>, value: impl Into<Cow<'a, str>>, at: Location) {
        self.fields.push((key.into(), value.into(), at));
    }

    /// Returns the keys and values of all fields.
    pub(crate) fn all(&self) -> impl Iterator<Item = (&str, &str)> {
        self.fields.iter().map(|(key, value, _)| (key.as_ref(), value.as_ref()))
    }

    /// Returns the value of the first field with this key, in any case.
    pub(crate) fn field(&self, key: &str) -> Option<&str> {
        self.find(|name| name.eq_ignore_ascii_case(key))
    }

    /// Returns the value of the first field whose key passes a test.
    pub(crate) fn find(&self, is_it: impl Fn(&str) -> bool) -> Option<&str> {
        self.all().find(|(key, _)| is_it(key)).map(|(_, value)| value)
    }

    /// Returns the text of a field.
    ///
    /// # Errors
    /// There is none.
    pub(crate) fn text(&self, key: &str) -> Result<&str> {
        self.field(key).ok_or_else(|| FormatError::missing(self.format, key, self.at.clone(), self.wanted))
    }

    /// Returns the number in a field.
    ///
    /// # Errors
    /// There is no field, or it is no number.
    pub(crate) fn number<T: Number>(&self, key: &str) -> Result<T> {
        self.text(key)?.parse().map_err(|_| self.wrong(key, T::WANTED))
    }

    /// Returns the number in a field; `None` if there is no field.
    ///
    /// # Errors
    /// It is no number.
    pub(crate) fn optional<T: Number>(&self, key: &str) -> Result<Option<T>> {
        self.field(key).map(|_| self.number(key)).transpose()
    }

    /// Checks the dimensions of a map.
    ///
    /// # Errors
    /// As [`crate::Input::shape`].
    pub(crate) fn shape(&self, rows: &str, columns: &str) -> Result<Shape> {
        let [ny, nx] = [self.number::<i64>(rows)?, self.number(columns)?];
        shape(self.format, (rows, self.place(rows), ny), (columns, self.place(columns), nx))
    }

    /// Returns the place of a field.
    pub(crate) fn place(&self, key: &str) -> Location {
        let field = self.fields.iter().find(|(name, ..)| name.eq_ignore_ascii_case(key));
        field.map_or(&self.at, |(.., at)| at).clone()
    }

    /// Returns the error for a field whose value is invalid.
    pub(crate) fn wrong(&self, key: &str, wanted: &str) -> FormatError {
        FormatError::field(self.format, shown(key), self.place(key), self.field(key).unwrap_or_default(), wanted)
    }

    /// Adds the fields to the metadata of a scan.
    pub(crate) fn add_to(&self, scan: &mut Scan, room: &mut TextLimit) {
        for (key, value) in self.all().filter(|(key, value)| room.take(key.len() + value.len())) {
            scan.metadata.insert(key.to_owned(), value.to_owned());
        }
    }
}

/// Splits a value into its number, if there is one, and its unit.
pub(crate) fn quantity(text: &str) -> (Option<f64>, &str) {
    let (number, unit) = text.trim().split_once(' ').unwrap_or((text.trim(), ""));
    (number.parse().ok(), unit.trim())
}
