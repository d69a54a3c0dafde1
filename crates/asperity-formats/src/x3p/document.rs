//! `main.xml` as a flat table: the path of every element that holds text, by local names, so that namespace prefixes and
//! their absence do not matter.

use std::collections::BTreeMap;

use quick_xml::Reader;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesRef, Event};

use super::{in_main, path};
use crate::error::shown;
use crate::{Format, FormatError};

/// Elements inside each other; the format needs five.
const MAX_DEPTH: usize = 32;

/// The text of one element and where it ends.
pub(super) struct Value {
    pub(super) text: String,
    pub(super) offset: u64,
}

/// The elements of `main.xml`.
pub(super) struct Document {
    /// Text by path below the root element; texts of equal path are joined by line ends.
    pub(super) values: BTreeMap<String, Value>,
    /// The numbers of the data list, NaN for empty ones; `None` when there is no list.
    pub(super) data_list: Option<Vec<f64>>,
}

impl Document {
    /// Takes the elements out of the bytes of `main.xml`.
    ///
    /// # Errors
    /// XML that is not well-formed, nested too deep, or that uses entities of its own; a datum that is no number.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let text = decode(bytes);
        let mut reader = Reader::from_str(&text);
        reader.config_mut().expand_empty_elements = true;
        let mut document = Self { values: BTreeMap::new(), data_list: None };
        // Names of the open elements below the root, joined, and the lengths to cut back to.
        let (mut open, mut lengths) = (String::new(), Vec::new());
        let (mut content, mut is_leaf) = (String::new(), false);
        loop {
            let damaged =
                |reason: String, offset: u64| FormatError::Xml { format: Format::X3p, at: in_main(offset), reason };
            match reader.read_event() {
                Err(error) => return Err(damaged(error.to_string(), reader.error_position())),
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
                Ok(Event::Text(text)) => content.push_str(&text.xml10_content()),
                Ok(Event::CData(text)) => content.push_str(&text.xml10_content()),
                Ok(Event::GeneralRef(reference)) => match resolve(&reference) {
                    Some(text) => content.push_str(&text),
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

    fn add(&mut self, path: &str, text: &str, offset: u64) -> Result<(), FormatError> {
        if path == path::DATUM {
            let datum = if text.is_empty() { Some(f64::NAN) } else { text.parse().ok() };
            let datum = datum.ok_or_else(|| wrong(path, text, offset, "one number, or nothing for a missing point"))?;
            self.data_list.get_or_insert_default().push(datum);
        } else if !text.is_empty() {
            match self.values.get_mut(path) {
                Some(value) => {
                    value.text.push('\n');
                    value.text.push_str(text);
                }
                None => {
                    self.values.insert(path.into(), Value { text: text.into(), offset });
                }
            }
        }
        Ok(())
    }

    /// The text of an element, `None` when it is empty or absent.
    pub(super) fn text(&self, path: &str) -> Option<&str> {
        self.values.get(path).map(|value| value.text.as_str())
    }

    /// The text of an element that must be there.
    pub(super) fn required(&self, path: &str, wanted: &str) -> Result<&Value, FormatError> {
        self.values.get(path).ok_or_else(|| missing(path, wanted))
    }

    /// A finite number, `None` when its element is empty or absent.
    pub(super) fn number(&self, path: &str) -> Result<Option<f64>, FormatError> {
        let Some(Value { text, offset }) = self.values.get(path) else { return Ok(None) };
        match text.parse() {
            Ok(number) if f64::is_finite(number) => Ok(Some(number)),
            _ => Err(wrong(path, text, *offset, "a finite number")),
        }
    }

    /// A whole number that must be there.
    pub(super) fn integer(&self, path: &str) -> Result<(i64, u64), FormatError> {
        let wanted = "a whole number";
        let Value { text, offset } = self.required(path, wanted)?;
        let number = text.parse().map_err(|_| wrong(path, text, *offset, wanted))?;
        Ok((number, *offset))
    }
}

/// An element that is not there.
pub(super) fn missing(path: &str, wanted: &str) -> FormatError {
    FormatError::MissingField { format: Format::X3p, field: path.into(), at: in_main(0), wanted: wanted.into() }
}

/// An element whose text cannot be right.
pub(super) fn wrong(path: &str, found: &str, offset: u64, wanted: &str) -> FormatError {
    FormatError::Field {
        format: Format::X3p,
        field: path.into(),
        at: in_main(offset),
        found: shown(found),
        wanted: wanted.into(),
    }
}

/// The text of a character reference or a predefined entity.
fn resolve(reference: &BytesRef) -> Option<String> {
    match reference.resolve_char_ref() {
        Ok(Some(character)) => Some(character.into()),
        _ => resolve_predefined_entity(reference).map(str::to_owned),
    }
}

/// XML text from bytes: UTF-16 by its byte-order mark, UTF-8, and Latin-1 for what is not UTF-8.
fn decode(bytes: &[u8]) -> String {
    let utf16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.as_chunks::<2>().0.iter().map(|&pair| unit(pair));
        char::decode_utf16(units).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            let latin1 = || bytes.iter().map(|&byte| char::from(byte)).collect();
            std::str::from_utf8(bytes).map_or_else(|_| latin1(), str::to_owned)
        }
    }
}
