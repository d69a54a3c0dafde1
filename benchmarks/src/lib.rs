//! Words `key=value` of the command line, as used by the timing programs.

use std::collections::BTreeMap;
use std::str::FromStr;

/// Words of a command line, by key.
#[derive(Debug)]
pub struct Words(BTreeMap<String, String>);

impl Words {
    /// Splits the words at their first `=`.
    ///
    /// # Errors
    /// A word has no `=`.
    pub fn parse(words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut found = BTreeMap::new();
        for word in words {
            let (key, value) = word.split_once('=').ok_or_else(|| format!("{word} is not key=value"))?;
            found.insert(key.to_owned(), value.to_owned());
        }
        Ok(Self(found))
    }

    /// Removes a word and returns its value; `None` without the word.
    ///
    /// # Errors
    /// The value does not parse.
    pub fn optional<T: FromStr>(&mut self, key: &str) -> Result<Option<T>, String> {
        let parse = |value: String| value.parse().map_err(|_| format!("{key}={value} cannot be read"));
        self.0.remove(key).map(parse).transpose()
    }

    /// Removes a required word and returns its value.
    ///
    /// # Errors
    /// The word is missing, or its value does not parse.
    pub fn wanted<T: FromStr>(&mut self, key: &str) -> Result<T, String> {
        self.optional(key)?.ok_or_else(|| format!("{key}=… is missing"))
    }

    /// Removes a word and returns its value, or the default without the word.
    ///
    /// # Errors
    /// The value does not parse.
    pub fn or<T: FromStr>(&mut self, key: &str, default: T) -> Result<T, String> {
        Ok(self.optional(key)?.unwrap_or(default))
    }

    /// Checks that every word has been removed.
    ///
    /// # Errors
    /// A word is left.
    pub fn finish(self) -> Result<(), String> {
        let unknown: Vec<String> = self.0.into_keys().collect();
        if unknown.is_empty() { Ok(()) } else { Err(format!("unknown: {}", unknown.join(", "))) }
    }
}
