//! Lists of a fixed number of values. Arrays and tuples alone ignore the values that follow their last.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, SeqAccess, Visitor};

/// Reads a list into an array or a tuple; a longer or shorter list is an error.
pub(in crate::study) fn fixed_list<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
    struct FixedList<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for FixedList<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a list")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<T, A::Error> {
            all_values(list)
        }
    }
    deserializer.deserialize_seq(FixedList(PhantomData))
}

/// Reads an optional list, as [`fixed_list`] does.
pub(super) fn optional_fixed_list<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    fixed_list(deserializer).map(Some)
}

/// Reads all values of a list into an array or a tuple.
pub(super) fn all_values<'de, A: SeqAccess<'de>, T: Deserialize<'de>>(mut list: A) -> Result<T, A::Error> {
    let found = list.size_hint();
    let values = T::deserialize(SeqAccessDeserializer::new(&mut list))?;
    let mut more = 0;
    while list.next_element::<IgnoredAny>()?.is_some() {
        more += 1;
    }
    if more == 0 {
        return Ok(values);
    }
    let found = found.unwrap_or(more);
    Err(A::Error::invalid_length(found, &format!("an array of length {}", found - more).as_str()))
}
