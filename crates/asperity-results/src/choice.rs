//! Choices by name: one enum from which study files, flags and bindings follow.

use std::fmt;
use std::marker::PhantomData;

use schemars::json_schema;
#[doc(hidden)]
pub use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use thiserror::Error;

/// Values that are chosen by name.
pub trait Choice: Copy + 'static {
    /// Noun for one of them in messages, such as "boundary".
    const NOUN: &'static str;
    /// All values, the usual one first.
    const ALL: &'static [Self];
    /// Names of all values, in the same order.
    const NAMES: &'static [&'static str];

    /// Returns the name in files and on the command line.
    fn name(self) -> &'static str;

    /// Returns a description for help texts; empty where the name is enough.
    fn description(self) -> &'static str;

    /// Returns the words for readers of a sentence or a table.
    fn words(self) -> String {
        words(self.name(), &[])
    }

    /// Returns the value of this name.
    ///
    /// # Errors
    /// No value has this name.
    fn from_name(name: &str) -> Result<Self, UnknownChoice> {
        let found = Self::ALL.iter().copied().find(|value| value.name() == name.trim());
        found.ok_or_else(|| UnknownChoice { noun: Self::NOUN, found: name.into(), known: Self::NAMES.join(", ") })
    }
}

/// A name that no value of a choice has.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("`{found}` is not a valid {noun}; write one of {known}")]
pub struct UnknownChoice {
    noun: &'static str,
    found: String,
    known: String,
}

/// A value that files hold by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ByName<T>(pub T);

impl<T: Choice> Serialize for ByName<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name())
    }
}

impl<'de, T: Choice> Deserialize<'de> for ByName<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor<T>(PhantomData<T>);
        impl<T: Choice> de::Visitor<'_> for Visitor<T> {
            type Value = ByName<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "the name of a {}", T::NOUN)
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<ByName<T>, E> {
                T::from_name(text).map(ByName).map_err(|_| E::unknown_variant(text, T::NAMES))
            }
        }
        deserializer.deserialize_str(Visitor(PhantomData))
    }
}

/// Returns the stated words of a name, or its own.
#[doc(hidden)]
pub fn words(name: &str, stated: &[&str]) -> String {
    stated.first().map_or_else(|| name.replace('_', " "), |words| (*words).to_owned())
}

/// Returns the JSON Schema of a value by name: its noun, and each name with its description, and with its words if they differ.
#[doc(hidden)]
pub fn schema<T: Choice>() -> Schema {
    let value = |value: &T| {
        let mut schema = json_schema!({ "const": value.name() });
        let words = Some(value.words()).filter(|words| *words != self::words(value.name(), &[]));
        let texts = [("description", value.description().to_owned()), ("title", words.unwrap_or_default())];
        for (key, text) in texts.into_iter().filter(|(_, text)| !text.is_empty()) {
            schema.insert(key.to_owned(), text.into());
        }
        schema
    };
    let values: Vec<Schema> = T::ALL.iter().map(value).collect();
    let noun = T::NOUN.chars().enumerate().map(|(place, c)| if place == 0 { c.to_ascii_uppercase() } else { c });
    json_schema!({ "description": format!("{}.", noun.collect::<String>()), "type": "string", "oneOf": values })
}

impl<T: Choice> JsonSchema for ByName<T> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        T::NOUN.into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        schema::<T>()
    }
}

/// Declares an enum of choices, each with its name: `ALL`, `name`, `Display`, `FromStr`, serde, JSON Schema and
/// [`Choice`]. The first line of
/// documentation of a variant is its description. Its words for readers follow the name, as in `StickSlip = "stick_slip": "stick-slip"`, unless
/// they are the name with spaces. The crate that uses it depends on `serde`.
///
/// ```
/// asperity_results::choice! {
///     /// Edge of a patch.
///     #[derive(Default)]
///     pub enum Edge: "boundary" {
///         /// Unloaded half-space.
///         #[default]
///         Free = "free",
///         /// The patch again.
///         Periodic = "periodic",
///     }
/// }
/// assert_eq!("periodic".parse(), Ok(Edge::Periodic));
/// assert_eq!("round".parse::<Edge>().unwrap_err().to_string(), "`round` is not a valid boundary; write one of free, periodic");
/// ```
#[macro_export]
macro_rules! choice {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $name:ident: $noun:literal {
            $(#[doc = $first:literal] $(#[$($attribute_of_variant:tt)+])* $variant:ident = $text:literal $(: $words:literal)?,)+
        }
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, ::serde::Serialize, ::serde::Deserialize)]
        $visibility enum $name {
            $(#[doc = $first] $(#[$($attribute_of_variant)+])* #[serde(rename = $text)] $variant,)+
        }

        impl $name {
            /// All values.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Returns the name in files and on the command line.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)+
                }
            }
        }

        impl $crate::choice::Choice for $name {
            const NOUN: &'static str = $noun;
            const ALL: &'static [Self] = Self::ALL;
            const NAMES: &'static [&'static str] = &[$($text),+];

            fn name(self) -> &'static str {
                self.name()
            }

            fn description(self) -> &'static str {
                match self {
                    $(Self::$variant => $first.trim_start(),)+
                }
            }

            fn words(self) -> String {
                match self {
                    $(Self::$variant => $crate::choice::words($text, &[$($words)?]),)+
                }
            }
        }

        impl $crate::choice::JsonSchema for $name {
            fn schema_name() -> ::std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut $crate::choice::SchemaGenerator) -> $crate::choice::Schema {
                $crate::choice::schema::<Self>()
            }
        }

        impl ::std::fmt::Display for $name {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl ::std::str::FromStr for $name {
            type Err = $crate::choice::UnknownChoice;

            fn from_str(text: &str) -> Result<Self, Self::Err> {
                $crate::choice::Choice::from_name(text)
            }
        }
    };
}
