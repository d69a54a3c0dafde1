//! XML descriptions as flat tables: the path of every element that holds text, by local names, so that namespace
//! prefixes have no effect.

use std::borrow::Cow;
use std::collections::BTreeMap;

use quick_xml::Reader;
use quick_xml::errors::{Error, IllFormedError};
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesRef, Event};

use crate::input::utf16;
use crate::scan::shape;
use crate::{Format, FormatError, Location, MAX_TEXT_BYTES, Result, Shape, shown};

/// Maximum depth of elements. Descriptions of instruments need about five.
const MAX_DEPTH: usize = 32;
/// Maximum number of bytes of the names of all open elements.
const MAX_PATH_BYTES: usize = 1 << 10;
/// Maximum number of elements with different paths. Descriptions of instruments need hundreds.
const MAX_VALUES: usize = 1 << 14;

/// Text of an element, and the offset of its end.
pub(crate) struct Value {
    pub(crate) text: String,
    pub(crate) offset: u64,
}

/// Elements of a description.
pub(crate) struct Document {
    format: Format,
    /// Name of the file inside the archive.
    entry: &'static str,
    /// Path of the elements that form a list of numbers.
    list_path: &'static str,
    /// Texts by path below the root element. Texts with equal paths are joined by line ends.
    pub(crate) values: BTreeMap<String, Value>,
    /// Numbers at `list_path`, NaN for empty elements; `None` if there are none.
    pub(crate) list: Option<Vec<f64>>,
    /// First text at `list_path` that is not a number. It is an error only if the list is used: point clouds list
    /// points.
    pub(crate) wrong_datum: Option<Value>,
}

/// Describes an error of the XML reader.
pub(crate) fn fault(error: &Error) -> String {
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
    /// Parses a file in an archive.
    ///
    /// The texts of elements at `list_path` are parsed as numbers, so that lists of millions take little memory.
    ///
    /// # Errors
    /// XML that is not well-formed, is nested too deep, or uses custom entities.
    pub(crate) fn parse(format: Format, entry: &'static str, bytes: &[u8], list_path: &'static str) -> Result<Self> {
        let text = decode(bytes);
        let mut reader = Reader::from_str(&text);
        reader.config_mut().expand_empty_elements = true;
        let mut document = Self { format, entry, list_path, values: BTreeMap::new(), list: None, wrong_datum: None };
        // Joined names of the open elements below the root, and the lengths to truncate to.
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
                    // All paths are stored: long paths of many elements would take far more memory than their texts.
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

    /// Returns the text of an element; `None` if it is empty or absent.
    pub(crate) fn text(&self, path: &str) -> Option<&str> {
        self.values.get(path).map(|value| value.text.as_str())
    }

    /// Returns the text of a required element.
    pub(crate) fn required(&self, path: &str, wanted: &str) -> Result<&Value> {
        self.values.get(path).ok_or_else(|| self.missing(path, wanted))
    }

    /// Returns a finite number; `None` if the element is empty or absent.
    pub(crate) fn number(&self, path: &str) -> Result<Option<f64>> {
        let Some(Value { text, offset }) = self.values.get(path) else { return Ok(None) };
        match text.parse() {
            Ok(number) if f64::is_finite(number) => Ok(Some(number)),
            _ => Err(self.wrong(path, text, *offset, "a finite number")),
        }
    }

    /// Returns a required whole number, and its offset.
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

    /// Returns the place of an element.
    pub(crate) fn at(&self, offset: u64) -> Location {
        Location::Entry { entry: self.entry.into(), offset }
    }

    /// Returns the error for an absent element.
    pub(crate) fn missing(&self, path: &str, wanted: &str) -> FormatError {
        FormatError::missing(self.format, path, self.at(0), wanted)
    }

    /// Returns the error for an element whose text is invalid.
    pub(crate) fn wrong(&self, path: &str, found: &str, offset: u64, wanted: &str) -> FormatError {
        FormatError::field(self.format, path, self.at(offset), found, wanted)
    }
}

/// Appends text up to the limit of [`MAX_TEXT_BYTES`].
fn append(text: &mut String, more: &str) {
    let room = MAX_TEXT_BYTES.saturating_sub(text.len());
    text.push_str(&more[..more.floor_char_boundary(room)]);
}

/// Resolves a character reference or a predefined entity.
pub(crate) fn resolve(reference: &BytesRef) -> Option<String> {
    match reference.resolve_char_ref() {
        Ok(Some(character)) => Some(character.into()),
        _ => resolve_predefined_entity(reference).map(str::to_owned),
    }
}

/// Decodes XML text: UTF-16 with a byte-order mark, UTF-8, or else Latin-1.
pub(crate) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    if let Some(text) = utf16(bytes) {
        return Cow::Owned(text);
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes).map_or_else(
        |_| {
            // A character takes at most two bytes. Growth by doubling would take more memory.
            let mut text = String::with_capacity(2 * bytes.len());
            text.extend(bytes.iter().map(|&byte| char::from(byte)));
            Cow::Owned(text)
        },
        Cow::Borrowed,
    )
}
