//! Which map of a file is read.

use crate::{Format, FormatError};

/// One of the height maps in a file that may hold several: channels, layers, pages, arrays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Channel {
    /// By its place, counted from 1.
    Number(usize),
    /// By its name, as [`Scan::channels`](crate::Scan::channels) spells it, in any case.
    Name(String),
}

impl From<&str> for Channel {
    /// A whole number is a place, everything else a name.
    fn from(text: &str) -> Self {
        text.parse().map_or_else(|_| Self::Name(text.into()), Self::Number)
    }
}

/// What to read of a file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The height map to read; the first, or the one that the format marks as its main one, unless told.
    pub channel: Option<Channel>,
}

impl ReadOptions {
    /// The place in `names` of the map to read.
    ///
    /// # Errors
    /// [`FormatError::NoSuchChannel`] with all names.
    pub(crate) fn choose(&self, format: Format, names: &[String]) -> Result<usize, FormatError> {
        let place = match &self.channel {
            None => Some(0),
            Some(Channel::Number(number)) => number.checked_sub(1),
            Some(Channel::Name(name)) => {
                let exact = names.iter().position(|candidate| candidate == name);
                let folded = || names.iter().position(|candidate| candidate.to_lowercase() == name.to_lowercase());
                exact.or_else(folded)
            }
        };
        place.filter(|&place| place < names.len()).ok_or_else(|| FormatError::NoSuchChannel {
            format,
            found: match &self.channel {
                Some(Channel::Number(number)) => format!("number {number}"),
                Some(Channel::Name(name)) => format!("`{}`", crate::error::shown(name)),
                None => "a first one".into(),
            },
            channels: names.to_vec(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choose(channel: Option<&str>) -> Option<usize> {
        let options = ReadOptions { channel: channel.map(Channel::from) };
        options.choose(Format::Gwy, &["Height".into(), "Phase".into(), "height".into()]).ok()
    }

    #[test]
    fn channels_are_chosen_by_number_or_name() {
        assert_eq!(choose(None), Some(0));
        assert_eq!(choose(Some("2")), Some(1));
        assert_eq!(choose(Some("PHASE")), Some(1));
        assert_eq!(choose(Some("height")), Some(2));
    }

    #[test]
    fn a_channel_that_is_not_there_is_refused_with_the_names_of_all() {
        for wrong in ["0", "4", "amplitude", ""] {
            assert_eq!(choose(Some(wrong)), None, "{wrong}");
        }
        let options = ReadOptions { channel: Some(Channel::Number(3)) };
        let message = options.choose(Format::Gwy, &["a".into(), "b".into()]).unwrap_err().to_string();
        assert_eq!(message, "GWY: no height map number 3; the file holds `a`, `b`");
    }
}
