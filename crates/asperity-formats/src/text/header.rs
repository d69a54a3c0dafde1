//! Headers of texts: units, pixel size and missing points.
//!
//! Programs use different keys. The reader supports the headers of Gwyddion's text export (also in German, French,
//! Italian, Spanish and Czech), of SPIP, Attocube and Nova, of ESRI grids, and plain keys such as `unit`, `pixel
//! size`, `dx` and `size`. A length without a unit is in metre unless a key names the unit.
//!
//! A conversion factor of heights takes precedence over their unit: Koala (Lyncée Tec) states `data unit=rad` and
//! `height conversion factor (-> m)=2.1e-07`. The factor is not applied to numbers that are already in its target
//! unit (`data unit=m`). The units may also be given as `(V -> nm)`, as `[nm/V]`, or after the number (`25 nm/V`). A
//! factor that is not applied gives a warning.

use std::collections::BTreeMap;

use super::decimal::Decimal;
use crate::{MAX_TEXT_BYTES, TextLimit, per_metre, shown, utf8_or_latin1};

/// Key with its value, and the unit in brackets after the key.
pub(super) struct Pair {
    pub(super) key: String,
    /// Key in small letters, without unit, with single spaces between words.
    pub(super) name: String,
    pub(super) unit: Option<f64>,
    pub(super) value: String,
}

/// Pairs of keys and values of a header.
#[derive(Default)]
pub(crate) struct Header {
    pub(super) pairs: Vec<Pair>,
    /// Decimal sign of the first pair that states it. Every line asks for it.
    decimal: Option<Decimal>,
    /// Limit of further pairs.
    room: TextLimit,
}

/// Keys with one meaning, separated by bars.
const HEIGHT_UNIT: &str =
    "value units|value unit|z unit|z units|zunit|height unit|height units|unit z|data unit|data units|unit data";
const ANY_UNIT: &str = "unit|units";
pub(super) const X_UNIT: &str = "x unit|x units|xunit|unit x|xy unit|xy units|unit xy|lateral unit|lateral units";
pub(super) const Y_UNIT: &str = "y unit|y units|yunit|unit y";
pub(super) const PIXEL_SIZE: &str = "pixel size|pixel sizes|pixel spacing|point spacing|pixel pitch|pitch|spacing";
const COLUMNS: &str = "x pixels|ncols|nx";
const ROWS: &str = "y pixels|nrows|ny";
const CHANNEL: &str = "channel|kanal|canal|canale|kanál";
/// Maximum number of bytes of these keys.
const MAX_CHANNEL_KEY: usize = 8;
/// Key of the decimal sign of a file, `comma` or `point`.
pub(super) const DECIMAL_SIGN: &str = "decimal sign";
/// Key of comments without a key.
pub(super) const COMMENT: &str = "comment";
/// Keys of an ESRI grid, which precede their values without a sign between.
pub(super) const ESRI: &[&str] =
    &["ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value"];

impl Pair {
    /// Returns the key and the value for a message.
    pub(super) fn quoted(&self) -> String {
        match self.name.as_str() {
            COMMENT => format!("`{}`", shown(&self.value)),
            _ => format!("`{}: {}`", shown(&self.key), shown(&self.value)),
        }
    }
}

/// Returns whether a name is one of several that bars separate.
pub(super) fn is_one_of(names: &str, name: &str) -> bool {
    names.split('|').any(|one| one == name)
}

/// Returns the unit in a bracket, `m)` or `-> m)`.
fn target(bracket: &str) -> &str {
    bracket.trim_end_matches([')', ']']).trim_start_matches(['-', '>', ' '])
}

impl Header {
    /// Adds a comment or a line of the header.
    pub(crate) fn add(&mut self, line: &str) {
        let pair = line.split_once([':', '=']).map(|(key, value)| (key.trim(), value.trim()));
        let (key, value) =
            pair.filter(|(key, value)| !key.is_empty() && !value.is_empty()).unwrap_or((COMMENT, line.trim()));
        self.insert(key, value);
    }

    /// Returns whether further pairs are allowed.
    pub(crate) fn has_room(&self) -> bool {
        self.room.is_left()
    }

    /// Adds a pair.
    pub(crate) fn insert(&mut self, key: &str, value: &str) {
        let [key, value] = [key, value].map(|text| &text[..text.floor_char_boundary(MAX_TEXT_BYTES)]);
        if value.is_empty() || !self.room.take(2 * key.len() + value.len()) {
            return;
        }
        let (words, unit) = match key.split_once(['(', '[']) {
            Some((words, bracket)) => (words, unit(target(bracket))),
            None => (key, None),
        };
        let words = words.to_lowercase().replace(['_', '-'], " ");
        let name = words.split_whitespace().collect::<Vec<_>>().join(" ");
        if name == DECIMAL_SIGN && self.find(DECIMAL_SIGN).is_none() {
            self.decimal = Decimal::named(value);
        }
        self.pairs.push(Pair { key: key.into(), name, unit, value: value.into() });
    }

    /// Adds a pair that precedes all others.
    pub(super) fn insert_first(&mut self, key: &str, value: &str) {
        let before = self.pairs.len();
        self.insert(key, value);
        if self.pairs.len() > before {
            self.pairs.rotate_right(1);
        }
    }

    /// Returns the pair of the first key that is present.
    pub(super) fn find(&self, names: &str) -> Option<&Pair> {
        names.split('|').find_map(|name| self.pairs.iter().find(|pair| pair.name == name))
    }

    /// Returns the value of the first pair with this key, in any case.
    pub(crate) fn value(&self, key: &str) -> Option<&str> {
        self.pairs.iter().find(|pair| pair.key.eq_ignore_ascii_case(key)).map(|pair| pair.value.as_str())
    }

    /// Returns whether a comment names a channel.
    pub(crate) fn names_channel(comment: &[u8]) -> bool {
        let Some(end) = comment.iter().position(|byte| matches!(byte, b':' | b'=')) else { return false };
        let (key, value) = (comment[..end].trim_ascii(), comment[end + 1..].trim_ascii());
        key.len() <= MAX_CHANNEL_KEY && !value.is_empty() && is_one_of(CHANNEL, &utf8_or_latin1(key).to_lowercase())
    }

    /// Returns the name of the channel.
    pub(crate) fn channel(&self) -> Option<&str> {
        self.find(CHANNEL).map(|pair| pair.value.as_str())
    }

    /// Returns whether the header states a pixel size, which lists of points lack.
    pub(crate) fn states_pixels(&self) -> bool {
        self.find(PIXEL_SIZE).is_some()
    }

    /// Returns whether this is the header of an ESRI grid, whose rows may be broken into lines anywhere.
    pub(crate) fn is_esri(&self) -> bool {
        ["ncols", "nrows", "cellsize"].iter().all(|name| self.find(name).is_some())
    }

    /// Returns the shape in the header.
    pub(crate) fn shape(&self) -> Option<(usize, usize)> {
        let count = |names| self.find(names)?.value.parse().ok();
        count(ROWS).zip(count(COLUMNS))
    }

    /// Returns whether a map of voids with the same shape follows the heights: 1 marks a missing point.
    pub(crate) fn has_voids(&self) -> bool {
        self.find("voidpixels").and_then(|pair| pair.value.parse::<f64>().ok()).is_some_and(|voids| voids != 0.0)
    }

    /// Returns the key and the unit of the heights, and its number per metre; `None` if the header states no unit.
    pub(crate) fn height_unit(&self) -> Option<(&str, &str, Option<f64>)> {
        let pair = self.find(HEIGHT_UNIT).or_else(|| self.find(ANY_UNIT))?;
        Some((&pair.key, &pair.value, unit(&pair.value)))
    }

    /// Returns the number of units per metre for x, y and z.
    pub(crate) fn units(&self) -> [Option<f64>; 3] {
        let named = |names| self.find(names).and_then(|pair: &Pair| unit(&pair.value));
        let any = named(ANY_UNIT);
        let x = named(X_UNIT).or(any);
        [x, named(Y_UNIT).or(x), named(HEIGHT_UNIT).or(any)]
    }

    /// Returns the decimal sign that the header states.
    pub(crate) fn decimal(&self) -> Option<Decimal> {
        self.decimal
    }

    /// Returns the first unit of x, y or z that is not a length.
    pub(crate) fn other_unit(&self) -> Option<&str> {
        let values = [X_UNIT, Y_UNIT, HEIGHT_UNIT, ANY_UNIT].into_iter().filter_map(|names| self.find(names));
        values.map(|pair| pair.value.as_str()).find(|value| unit(value).is_none())
    }

    /// Returns the pairs as metadata. Values of equal keys are joined.
    pub(crate) fn metadata(self) -> BTreeMap<String, String> {
        let mut metadata: BTreeMap<String, String> = BTreeMap::new();
        for Pair { key, value, .. } in self.pairs {
            let kept = metadata.entry(key).or_default();
            if !kept.is_empty() {
                kept.push('\n');
            }
            kept.push_str(&value);
        }
        metadata
    }
}

/// Returns the number of units per metre. Brackets around the unit are ignored.
pub(crate) fn unit(text: &str) -> Option<f64> {
    per_metre(bare(text))
}

/// Returns a unit without the brackets around it.
pub(super) fn bare(text: &str) -> &str {
    text.trim().trim_matches(['[', ']', '(', ')', '"', '\'']).trim()
}
