//! Deserializer of parsed TOML whose errors are sentences for the reader of the file, with the place of the value or key.

use std::fmt::Display;

use serde::de::value::SeqDeserializer;
use serde::de::{self, DeserializeSeed, Error, Expected, IntoDeserializer, MapAccess, Unexpected, Visitor};
use toml::de::{DeInteger, DeString, DeTable, DeValue};
use toml::{Spanned, map};

use crate::study::sentence;

/// Error of a value or key.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(super) struct ValueError {
    message: String,
    /// Description of a value of a wrong type or out of range.
    found: Option<String>,
    /// First byte of the value or key.
    pub(super) start: Option<usize>,
}

impl ValueError {
    /// Returns an error that lists the known names, with the nearest as a suggestion.
    fn unknown(kind: &str, found: &str, known: &[&str]) -> Self {
        let likeness = known.iter().map(|name| (strsim::jaro_winkler(found, name), *name));
        let nearest = likeness.filter(|(likeness, _)| *likeness > 0.75).max_by(|a, b| a.0.total_cmp(&b.0));
        let hint = nearest.map_or_else(String::new, |(_, name)| format!("; did you mean `{name}`?"));
        Self::custom(format!("unknown {kind} `{found}`{hint} (known: {})", known.join(", ")))
    }

    /// Adds the place and the expected type of a value, unless the error is that of a value or key inside it.
    fn at(mut self, start: usize, expected: Option<&str>) -> Self {
        if self.start.is_none() {
            self.start = Some(start);
            if let (Some(found), Some(expected)) = (&self.found, expected) {
                self.message = format!("{found} is not {expected}");
            }
        }
        self
    }
}

impl Error for ValueError {
    fn custom<T: Display>(message: T) -> Self {
        Self { message: message.to_string(), found: None, start: None }
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let found = match found {
            Unexpected::Bool(value) => format!("`{value}`"),
            Unexpected::Unsigned(number) => format!("`{number}`"),
            Unexpected::Signed(number) => format!("`{number}`"),
            Unexpected::Float(number) if number.fract() == 0.0 => format!("`{number:.1}`"),
            Unexpected::Float(number) => format!("`{number}`"),
            Unexpected::Str(text) => format!("{text:?}"),
            Unexpected::Seq => "a list".into(),
            Unexpected::Map => "a table".into(),
            other => other.to_string(),
        };
        Self { message: format!("{found} is not {expected}"), found: Some(found), start: None }
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn unknown_field(found: &str, known: &'static [&'static str]) -> Self {
        Self::unknown("key", found, known)
    }

    fn unknown_variant(found: &str, known: &'static [&'static str]) -> Self {
        Self::unknown("value", found, known)
    }
}

/// Returns the error of a number that is written as text.
pub(in crate::study) fn quoted_number<E: Error>(text: &str) -> Option<E> {
    let number = text.trim();
    number.parse::<f64>().ok()?;
    Some(E::custom(format!("{text:?} is text; write {number} without quotation marks")))
}

/// Deserializer of a value with its place in the text.
pub(super) struct ValueDeserializer<'i>(Spanned<DeValue<'i>>);

impl<'i> From<Spanned<DeTable<'i>>> for ValueDeserializer<'i> {
    fn from(root: Spanned<DeTable<'i>>) -> Self {
        Self(Spanned::new(root.span(), DeValue::Table(root.into_inner())))
    }
}

impl ValueDeserializer<'_> {
    fn start(&self) -> usize {
        self.0.span().start
    }

    /// Passes the value to the visitor. Without the expected type, errors contain the words of the visitor.
    fn visit<'de, V: Visitor<'de>>(self, visitor: V, expected: Option<&str>) -> Result<V::Value, ValueError> {
        let start = self.start();
        let visited = match self.0.into_inner() {
            DeValue::String(text) => visitor.visit_str(&text),
            DeValue::Integer(number) => visit_integer(&number, visitor),
            DeValue::Float(number) => match number.as_str().parse::<f64>() {
                Ok(value) if value.is_infinite() && !number.as_str().ends_with("inf") => {
                    Err(ValueError::custom("floating-point number overflowed"))
                }
                Ok(value) => visitor.visit_f64(value),
                Err(error) => Err(ValueError::custom(error)),
            },
            DeValue::Boolean(value) => visitor.visit_bool(value),
            DeValue::Datetime(date) => Err(ValueError::custom(format!("{date} is a date; no key has one"))),
            DeValue::Array(list) => visitor.visit_seq(SeqDeserializer::new(list.into_iter().map(ValueDeserializer))),
            DeValue::Table(table) => visitor.visit_map(Entries::new(table)),
        };
        visited.map_err(|error: ValueError| error.at(start, expected))
    }

    fn visit_number<'de, V: Visitor<'de>>(self, visitor: V, expected: &str) -> Result<V::Value, ValueError> {
        match self.0.get_ref().as_str().and_then(quoted_number::<ValueError>) {
            Some(error) => Err(error.at(self.start(), None)),
            None => self.visit(visitor, Some(expected)),
        }
    }
}

/// Passes a whole number to the visitor. TOML limits whole numbers to 64 bits with a sign.
fn visit_integer<'de, V: Visitor<'de>>(number: &DeInteger<'_>, visitor: V) -> Result<V::Value, ValueError> {
    let (digits, radix) = (number.as_str(), number.radix());
    if let Ok(value) = i64::from_str_radix(digits, radix) {
        return visitor.visit_i64(value);
    }
    let value =
        u64::from_str_radix(digits, radix).map_err(|_| ValueError::custom(format!("`{number}` is out of range")))?;
    visitor.visit_u64(value).map_err(|error: ValueError| match error.found {
        Some(_) => error,
        None => ValueError::custom(format!("a whole number above {} is out of range", i64::MAX)),
    })
}

macro_rules! typed {
    ($($via:ident($expected:expr): $($method:ident)+;)+) => {$($(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
            self.$via(visitor, $expected)
        }
    )+)+};
}

impl<'de> de::Deserializer<'de> for ValueDeserializer<'_> {
    type Error = ValueError;

    typed! {
        visit_number("a whole number from 0 on"): deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64;
        visit_number("a whole number"): deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64;
        visit_number("a number"): deserialize_f32 deserialize_f64;
        visit(Some("true or false")): deserialize_bool;
        visit(Some("a list")): deserialize_seq;
        visit(Some("a table")): deserialize_map;
        visit(None): deserialize_any;
    }

    serde::forward_to_deserialize_any! {
        char str string bytes byte_buf unit unit_struct tuple_struct identifier ignored_any
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, ValueError> {
        visitor.visit_newtype_struct(self)
    }

    /// Arrays and tuples alone ignore the values that follow their last.
    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, ValueError> {
        let start = self.start();
        let found = self.0.get_ref().as_array().map_or(length, |list| list.len());
        match self.visit(visitor, Some("a list")) {
            Err(error) if found == length || error.start != Some(start) => Err(error),
            Ok(value) if found == length => Ok(value),
            _ => Err(wrong_length::<ValueError>(found, length).at(start, None)),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        self.visit(visitor, Some("a table"))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        let start = self.start();
        let visited = match self.0.into_inner() {
            DeValue::String(name) => visitor.visit_enum(name.into_deserializer()),
            DeValue::Table(_) => Err(ValueError::custom("a table is not a string")),
            _ => Err(ValueError::custom("wanted string or table")),
        };
        visited.map_err(|error: ValueError| error.at(start, None))
    }
}

/// Returns the error of a list that is too short or too long.
pub(in crate::study) fn wrong_length<E: Error>(found: usize, expected: usize) -> E {
    E::custom(format!("found {}, expected {expected}", sentence::count(found, "value", "values")))
}

impl IntoDeserializer<'_, ValueError> for ValueDeserializer<'_> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

/// Keys and values of a table that are still to be read.
struct Entries<'i> {
    rest: map::IntoIter<Spanned<DeString<'i>>, Spanned<DeValue<'i>>>,
    value: Option<ValueDeserializer<'i>>,
}

impl<'i> Entries<'i> {
    fn new(table: DeTable<'i>) -> Self {
        Self { rest: table.into_iter(), value: None }
    }
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = ValueError;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, ValueError> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        let start = key.span().start;
        self.value = Some(ValueDeserializer(value));
        let key = seed.deserialize(key.into_inner().into_deserializer());
        key.map(Some).map_err(|error: ValueError| error.at(start, None))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, ValueError> {
        let value = self.value.take().ok_or_else(|| ValueError::custom("no value follows the key"))?;
        let start = value.start();
        seed.deserialize(value).map_err(|error| error.at(start, None))
    }
}
