//! Descriptions of containers: YAML, of which JSON is a part, read as a stream of events.
//!
//! Aliases are not expanded and nothing is stored but the measurements, so that no description takes more memory than its text.

use std::borrow::Cow;

use saphyr_parser::{Event, Parser, ScalarStyle};

use super::Measurement;
use crate::{Format, FormatError, Location, Result, refuse_if, shown};

/// Maximum depth of lists and mappings, and maximum number of events and of measurements.
const MAX_DEPTH: usize = 64;
const MAX_EVENTS: usize = 1 << 20;
const MAX_MEASUREMENTS: usize = 1 << 12;
/// Keys of a measurement that are read, and the key that merges another mapping into it.
const KEYS: [&str; 6] = ["name", "datafile", "unit", "height_scale", "size", "<<"];

/// Place in an open list or mapping.
enum Open {
    List,
    /// Key of the next value; `None` before the key.
    Mapping(Option<String>),
}

/// Returns the measurements that a description lists.
///
/// # Errors
/// Text that is not YAML, is nested too deep or too long, values of the wrong type, and aliases in their place.
pub(super) fn measurements(name: &str, text: &str) -> Result<Vec<Measurement>> {
    let text = if text.contains("\\ud") || text.contains("\\uD") { joined(text) } else { Cow::Borrowed(text) };
    let mut parser = Parser::new_from_str(text.trim_start_matches('\u{feff}'));
    let (mut measurements, mut open) = (Vec::new(), Vec::new());
    let damaged = |line: usize, reason: String| FormatError::Archive {
        format: Format::Container,
        entry: name.into(),
        reason: format!("line {line}: {reason}"),
    };
    let mut events = 0;
    while let Some(event) = parser.next_event() {
        let (event, span) = event.map_err(|error| damaged(error.marker().line(), error.info().into()))?;
        let line = span.start.line();
        events += 1;
        refuse_if!(events > MAX_EVENTS, damaged(line, format!("more than {MAX_EVENTS} keys and values")));
        refuse_if!(open.len() > MAX_DEPTH, damaged(line, format!("more than {MAX_DEPTH} lists inside each other")));
        match event {
            Event::SequenceStart(..) => open.push(Open::List),
            Event::MappingStart(..) => {
                let is_measurement =
                    path(&open).is_some_and(|path| matches!(path[..], ["surfaces", "", "topographies", ""]));
                refuse_if!(
                    is_measurement && measurements.len() == MAX_MEASUREMENTS,
                    damaged(line, format!("more than {MAX_MEASUREMENTS} measurements"))
                );
                measurements.extend(is_measurement.then(Measurement::default));
                open.push(Open::Mapping(None));
            }
            Event::SequenceEnd | Event::MappingEnd => {
                open.pop();
                end(&mut open, String::new);
            }
            Event::Scalar(text, style, ..) => {
                let is_null = style == ScalarStyle::Plain && matches!(&*text, "" | "~" | "null" | "Null" | "NULL");
                if let Some(wrong) = set(&mut measurements, &open, Some(&text).filter(|_| !is_null).map(|text| &**text))
                {
                    let field = |field: &str| {
                        FormatError::field(Format::Container, field, Location::Line(line), shown(&text), "a number")
                    };
                    return Err(field(&format!("`{wrong}` in {name}")));
                }
                end(&mut open, || text.into_owned());
            }
            Event::Alias(_) => {
                let is_read = path(&open).is_some_and(|path| match path[..] {
                    ["surfaces"] | ["surfaces", ""] | ["surfaces", "", "topographies" | "<<"] => true,
                    ["surfaces", "", "topographies", "", ref keys @ ..] => {
                        keys.first().is_none_or(|key| KEYS.contains(key))
                    }
                    _ => false,
                });
                refuse_if!(is_read, damaged(line, "an alias of a value elsewhere is not read".into()));
                end(&mut open, String::new);
            }
            _ => (),
        }
    }
    Ok(measurements)
}

/// Returns the keys that lead to the present value, empty for items of lists; `None` in a key.
fn path(open: &[Open]) -> Option<Vec<&str>> {
    let keys = open.iter().map(|open| match open {
        Open::List => Some(""),
        Open::Mapping(key) => key.as_deref(),
    });
    keys.collect()
}

/// Ends a value or a key of the innermost list or mapping.
fn end(open: &mut [Open], text: impl FnOnce() -> String) {
    if let Some(Open::Mapping(key)) = open.last_mut() {
        *key = if key.is_some() { None } else { Some(text()) };
    }
}

/// Sets a value of the last measurement. Returns its key if it should be a number and is none.
fn set(measurements: &mut [Measurement], open: &[Open], text: Option<&str>) -> Option<&'static str> {
    let (last, path) = (measurements.last_mut()?, path(open)?);
    let ["surfaces", "", "topographies", "", keys @ ..] = &path[..] else { return None };
    let owned = text.filter(|text| !text.is_empty()).map(str::to_owned);
    let number = || text.map(|text| text.parse::<f64>().ok().filter(|number| number.is_finite()));
    match keys {
        ["name"] => last.name = owned,
        ["unit"] => last.unit = owned,
        ["datafile", "original"] | ["datafile"] => last.original = owned,
        ["datafile", "squeezed-netcdf"] => last.squeezed = owned,
        ["height_scale"] => match number() {
            Some(None) => return Some("height_scale"),
            found => last.scale = found.flatten(),
        },
        ["size"] | ["size", ""] => match number() {
            Some(None) => return Some("size"),
            found => last.size.extend(found.flatten()),
        },
        _ => (),
    }
    None
}

/// Returns a text in which pairs of escapes that JSON writes for one character, `\ud83d\ude00`, are this character.
fn joined(json: &str) -> Cow<'_, str> {
    let (mut text, mut rest) = (String::with_capacity(json.len()), json);
    while let Some(place) = rest.find('\\') {
        let half = |at: usize| u16::from_str_radix(rest.get(at..at + 6)?.strip_prefix("\\u")?, 16).ok();
        let halves = half(place).zip(half(place + 6)).filter(|(high, _)| (0xd800..0xdc00).contains(high));
        let whole = halves.and_then(|(high, low)| char::decode_utf16([high, low]).next()?.ok());
        text.push_str(&rest[..place]);
        // An escaped backslash starts no other escape.
        let length = if whole.is_some() { 12 } else { 1 + rest[place + 1..].chars().next().map_or(0, char::len_utf8) };
        match whole {
            Some(whole) => text.push(whole),
            None => text.push_str(&rest[place..place + length]),
        }
        rest = &rest[place + length..];
    }
    text.push_str(rest);
    Cow::Owned(text)
}
