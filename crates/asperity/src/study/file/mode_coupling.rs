//! Model of the machine in `[vibration]`, and the springs of two coupled modes.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

pub use asperity_results::MachineModel;

use crate::study::parse::quoted_number;

/// Stiffness of the contact spring of two coupled modes: a number, or `"surface"`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactSpring {
    /// Stiffness in units of mω₀².
    Stated(f64),
    /// Computed stiffness of the rough contact.
    Surface,
}

/// Name of the computed stiffness.
const SURFACE: &str = "surface";

impl JsonSchema for ContactSpring {
    fn schema_name() -> Cow<'static, str> {
        "ContactSpring".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [{ "type": "number" }, { "const": SURFACE }] })
    }
}

impl Serialize for ContactSpring {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Stated(stiffness) => serializer.serialize_f64(*stiffness),
            Self::Surface => serializer.serialize_str(SURFACE),
        }
    }
}

impl<'de> Deserialize<'de> for ContactSpring {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = ContactSpring;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number in units of mω₀², or \"surface\"")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<ContactSpring, E> {
                Ok(ContactSpring::Stated(value))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<ContactSpring, E> {
                Ok(ContactSpring::Stated(value as f64))
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<ContactSpring, E> {
                Ok(ContactSpring::Stated(value as f64))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<ContactSpring, E> {
                match text {
                    SURFACE => Ok(ContactSpring::Surface),
                    _ => Err(quoted_number(text).unwrap_or_else(|| E::invalid_value(de::Unexpected::Str(text), &self))),
                }
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}
