//! An XML description as a flat table: the path of every element that holds text, by local names, so that namespace
//! prefixes and their absence do not matter.

use crate::error::{Result, shown};
use std::borrow::Cow;
use std::collections::BTreeMap;

use quick_xml::Reader;
use quick_xml::errors::{Error, IllFormedError};
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesRef, Event};

use crate::input::{MAX_TEXT_BYTES, utf16};
use crate::scan::{Shape, shape};
use crate::{Format, FormatError, Location};

/// Elements inside each other; descriptions of instruments need about five.
const MAX_DEPTH: usize = 32;
/// Bytes of the names of all elements that are open at one place.
const MAX_PATH_BYTES: usize = 1 << 10;
/// Elements of different paths; descriptions of instruments need hundreds.
const MAX_VALUES: usize = 1 << 14;

/// The text of one element and where it ends.
pub(crate) struct Value {
    pub(crate) text: String,
    pub(crate) offset: u64,
}

/// The elements of a description.
pub(crate) struct Document {
    format: Format,
    /// Name of the file inside the archive.
    entry: &'static str,
    /// Path of the elements that make up a list of numbers.
    list_path: &'static str,
    /// Text by path below the root element; texts of equal path are joined by line ends.
    pub(crate) values: BTreeMap<String, Value>,
    /// The numbers at `list_path`, NaN for empty ones; `None` when there are none.
    pub(crate) list: Option<Vec<f64>>,
    /// The first text at `list_path` that is no number. It is an error only where the list is used: point clouds list points.
    pub(crate) wrong_datum: Option<Value>,
}

/// Describes an error of the XML reader.
fn fault(error: &Error) -> String {
    match error {
        Error::Syntax(_) => "the document ends inside of a tag or a comment".into(),
        Error::IllFormed(IllFormedError::MismatchedEndTag { expected, found }) => {
            format!("`</{}>` closes `<{}>`", shown(found), shown(expected))
        }
        Error::IllFormed(IllFormedError::UnmatchedEndTag(found)) => format!("`</{}>` closes nothing", shown(found)),
        Error::IllFormed(IllFormedError::UnclosedReference) => "`&` starts an entity that does not end with `;`".into(),
        _ => "the XML is not well-formed".into(),
    }
}

impl Document {
    /// Takes the elements out of the bytes of a file in an archive.
    ///
    /// The texts of elements at `list_path` are read as numbers, so that lists of millions cost no more than they must.
    ///
    /// # Errors
    /// XML that is not well-formed, nested too deep, or that uses entities of its own.
    pub(crate) fn parse(format: Format, entry: &'static str, bytes: &[u8], list_path: &'static str) -> Result<Self> {
        let text = decode(bytes);
        let mut reader = Reader::from_str(&text);
        reader.config_mut().expand_empty_elements = true;
        let mut document = Self { format, entry, list_path, values: BTreeMap::new(), list: None, wrong_datum: None };
        // Names of the open elements below the root, joined, and the lengths to cut back to.
        let (mut open, mut lengths) = (String::new(), Vec::new());
        let (mut content, mut is_leaf) = (String::new(), false);
        loop {
            let damaged = |reason: String, offset: u64| {
                let at = Location::Entry { entry: entry.into(), offset };
                FormatError::Xml { format, at, reason }
            };
            match reader.read_event() {
                Err(error) => return Err(damaged(fault(&error), reader.error_position())),
                Ok(Event::Start(start)) => {
                    if lengths.len() == MAX_DEPTH {
                        let reason = format!("more than {MAX_DEPTH} elements inside each other");
                        return Err(damaged(reason, reader.buffer_position()));
                    }
                    lengths.push(open.len());
                    if lengths.len() > 1 {
                        if !open.is_empty() {
                            open.push('/');
                        }
                        open.push_str(start.local_name().into_inner());
                    }
                    // Every path is kept: long ones around many elements would take far more memory than their text.
                    if open.len() > MAX_PATH_BYTES {
                        let reason = format!("names of more than {MAX_PATH_BYTES} bytes inside each other");
                        return Err(damaged(reason, reader.buffer_position()));
                    }
                    content.clear();
                    is_leaf = true;
                }
                Ok(Event::End(_)) => {
                    if is_leaf {
                        document.add(&open, content.trim(), reader.buffer_position())?;
                    }
                    open.truncate(lengths.pop().unwrap_or_default());
                    content.clear();
                    is_leaf = false;
                }
                Ok(Event::Text(text)) => append(&mut content, &text.xml10_content()),
                Ok(Event::CData(text)) => append(&mut content, &text.xml10_content()),
                Ok(Event::GeneralRef(reference)) => match resolve(&reference) {
                    Some(text) => append(&mut content, &text),
                    None => {
                        let reason = format!("the entity &{}; is unknown", shown(&reference));
                        return Err(damaged(reason, reader.buffer_position()));
                    }
                },
                Ok(Event::Eof) if lengths.is_empty() => return Ok(document),
                Ok(Event::Eof) => {
                    return Err(damaged(
                        format!("the document ends inside of `{}`", shown(&open)),
                        reader.buffer_position(),
                    ));
                }
                Ok(_) => (),
            }
        }
    }

    fn add(&mut self, path: &str, text: &str, offset: u64) -> Result<()> {
        if path == self.list_path {
            let datum = if text.is_empty() { Some(f64::NAN) } else { text.parse().ok() };
            if datum.is_none() {
                self.wrong_datum.get_or_insert_with(|| Value { text: text.into(), offset });
            }
            self.list.get_or_insert_default().push(datum.unwrap_or(f64::NAN));
        } else if !text.is_empty() {
            let is_full = self.values.len() >= MAX_VALUES;
            match self.values.get_mut(path) {
                Some(value) => {
                    append(&mut value.text, "\n");
                    append(&mut value.text, text);
                }
                None if is_full => {
                    let reason = format!("more than {MAX_VALUES} different elements");
                    return Err(FormatError::Xml { format: self.format, at: self.at(offset), reason });
                }
                None => {
                    self.values.insert(path.into(), Value { text: text.into(), offset });
                }
            }
        }
        Ok(())
    }

    /// The text of an element, `None` when it is empty or absent.
    pub(crate) fn text(&self, path: &str) -> Option<&str> {
        self.values.get(path).map(|value| value.text.as_str())
    }

    /// The text of an element that must be there.
    pub(crate) fn required(&self, path: &str, wanted: &str) -> Result<&Value> {
        self.values.get(path).ok_or_else(|| self.missing(path, wanted))
    }

    /// A finite number, `None` when its element is empty or absent.
    pub(crate) fn number(&self, path: &str) -> Result<Option<f64>> {
        let Some(Value { text, offset }) = self.values.get(path) else { return Ok(None) };
        match text.parse() {
            Ok(number) if f64::is_finite(number) => Ok(Some(number)),
            _ => Err(self.wrong(path, text, *offset, "a finite number")),
        }
    }

    /// A whole number that must be there.
    pub(crate) fn integer(&self, path: &str) -> Result<(i64, u64)> {
        let wanted = "a whole number";
        let Value { text, offset } = self.required(path, wanted)?;
        let number = text.parse().map_err(|_| self.wrong(path, text, *offset, wanted))?;
        Ok((number, *offset))
    }

    /// Returns the checked shape of a map from the elements that state its rows and its columns.
    pub(crate) fn shape(&self, rows: &str, columns: &str) -> Result<Shape> {
        let [(ny, ny_at), (nx, nx_at)] = [self.integer(rows)?, self.integer(columns)?];
        shape(self.format, (rows, self.at(ny_at), ny), (columns, self.at(nx_at), nx))
    }

    /// The place of an element.
    pub(crate) fn at(&self, offset: u64) -> Location {
        Location::Entry { entry: self.entry.into(), offset }
    }

    /// The error for an element that is not there.
    pub(crate) fn missing(&self, path: &str, wanted: &str) -> FormatError {
        FormatError::missing(self.format, path, self.at(0), wanted)
    }

    /// The error for an element whose text cannot be right.
    pub(crate) fn wrong(&self, path: &str, found: &str, offset: u64, wanted: &str) -> FormatError {
        FormatError::field(self.format, path, self.at(offset), found, wanted)
    }
}

/// Adds to a text as much as is kept of it.
fn append(text: &mut String, more: &str) {
    let room = MAX_TEXT_BYTES.saturating_sub(text.len());
    text.push_str(&more[..more.floor_char_boundary(room)]);
}

/// The text of a character reference or a predefined entity.
fn resolve(reference: &BytesRef) -> Option<String> {
    match reference.resolve_char_ref() {
        Ok(Some(character)) => Some(character.into()),
        _ => resolve_predefined_entity(reference).map(str::to_owned),
    }
}

/// XML text from bytes: UTF-16 by its byte-order mark, UTF-8, and Latin-1 for what is not UTF-8.
fn decode(bytes: &[u8]) -> Cow<'_, str> {
    if let Some(text) = utf16(bytes) {
        return Cow::Owned(text);
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes).map_or_else(
        |_| {
            // Two bytes at most for each; growing by doubling would take more.
            let mut text = String::with_capacity(2 * bytes.len());
            text.extend(bytes.iter().map(|&byte| char::from(byte)));
            Cow::Owned(text)
        },
        Cow::Borrowed,
    )
}
