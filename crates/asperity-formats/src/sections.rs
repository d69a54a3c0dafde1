//! Text headers of sections, each with its fields, as several programs write before binary data.

use std::str::FromStr;

use crate::{Input, Result, Scan, TextLimit};

/// Section of a header.
pub(crate) struct Section<'a> {
    /// Name; empty for fields before the first section.
    pub(crate) name: &'a str,
    /// Offset of its first line.
    at: usize,
    fields: Vec<(&'a str, &'a str)>,
}

/// Splits a header into sections. `name` returns the name of a section from the line that starts it; `separator` stands between the key
/// and the value of a field.
pub(crate) fn sections<'a>(text: &'a str, separator: &str, name: fn(&str) -> Option<&str>) -> Vec<Section<'a>> {
    let mut sections = vec![Section { name: "", at: 0, fields: Vec::new() }];
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if let Some(name) = name(line.trim()) {
            sections.push(Section { name, at, fields: Vec::new() });
        } else if let (Some((key, value)), Some(section)) = (line.split_once(separator), sections.last_mut()) {
            // Some programs write a backslash before every key.
            section.fields.push((key.trim().trim_start_matches('\\'), value.trim()));
        }
        at += line.len();
    }
    sections
}

/// Returns the section with this name.
///
/// # Errors
/// There is none.
pub(crate) fn section<'s, 'a>(input: &Input, sections: &'s [Section<'a>], name: &str) -> Result<&'s Section<'a>> {
    let found = sections.iter().find(|section| section.name.eq_ignore_ascii_case(name));
    found.ok_or_else(|| input.missing(name, 0, "a section of the header"))
}

impl<'a> Section<'a> {
    /// Returns the value of the first field with this key, in any case.
    pub(crate) fn field(&self, key: &str) -> Option<&'a str> {
        self.find(|name| name.eq_ignore_ascii_case(key))
    }

    /// Returns the value of the first field whose key passes a test.
    pub(crate) fn find(&self, is_it: impl Fn(&str) -> bool) -> Option<&'a str> {
        self.fields.iter().find(|(key, _)| is_it(key)).map(|(_, value)| *value)
    }

    /// Returns the text of a field.
    ///
    /// # Errors
    /// There is none.
    pub(crate) fn text(&self, input: &Input, key: &str) -> Result<&'a str> {
        self.field(key).ok_or_else(|| input.missing(key, self.at, "a field of the header"))
    }

    /// Returns the number in a field.
    ///
    /// # Errors
    /// There is no field, or it is no number.
    pub(crate) fn number<T: FromStr>(&self, input: &Input, key: &str) -> Result<T> {
        let text = self.text(input, key)?;
        text.parse().map_err(|_| self.wrong(input, key, "a number"))
    }

    /// Checks the dimensions of a map.
    ///
    /// # Errors
    /// As [`Input::shape`].
    pub(crate) fn shape(&self, input: &Input, rows: &str, columns: &str) -> Result<(usize, usize)> {
        let number = |key| Ok((key, self.at, self.number::<u64>(input, key)?));
        input.shape(number(rows)?, number(columns)?)
    }

    /// Returns the error for a field whose value is invalid.
    pub(crate) fn wrong(&self, input: &Input, key: &str, wanted: &str) -> crate::FormatError {
        input.wrong(key, self.at, self.field(key).unwrap_or_default(), wanted)
    }

    /// Adds the fields to the metadata of a scan.
    pub(crate) fn add_to(&self, scan: &mut Scan, room: &mut TextLimit) {
        for (key, value) in &self.fields {
            if room.take(key.len() + value.len()) {
                scan.metadata.insert((*key).to_owned(), (*value).to_owned());
            }
        }
    }
}

/// Splits a value into its number, if there is one, and its unit.
pub(crate) fn quantity(text: &str) -> (Option<f64>, &str) {
    let (number, unit) = text.trim().split_once(' ').unwrap_or((text.trim(), ""));
    (number.parse().ok(), unit.trim())
}
