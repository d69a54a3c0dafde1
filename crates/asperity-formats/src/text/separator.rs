//! Separators of values and signs of comments.

use super::decimal::{Decimal, with_comma};

/// Characters that start a comment.
pub(crate) const COMMENT: &[u8] = b"#%";

/// Separator of values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Separator {
    /// One or more spaces or tabs.
    Space = b' ',
    /// A comma.
    Comma = b',',
    /// A semicolon.
    Semicolon = b';',
    /// A tab; two in a row enclose an empty field.
    Tab = b'\t',
}

impl Separator {
    /// Detects the separator of a row.
    ///
    /// In `1,5 2,5` the commas are no separators: they would leave two numbers between them. A stated decimal comma is none either.
    pub(crate) fn detect(row: &[u8], decimal: Option<Decimal>) -> Self {
        let words = || row.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let is_number = |word: &[u8]| {
            with_comma(word, decimal).is_some()
                || std::str::from_utf8(word).is_ok_and(|word| word.parse::<f64>().is_ok())
        };
        if row.contains(&b';') {
            Self::Semicolon
        } else if row.contains(&b'\t') {
            Self::Tab
        } else if row.contains(&b',')
            && decimal != Some(Decimal::Comma)
            && !(words().count() > 1 && words().all(is_number))
        {
            Self::Comma
        } else {
            Self::Space
        }
    }

    pub(crate) fn sign(self) -> u8 {
        self as u8
    }
}
