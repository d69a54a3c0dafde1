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

use crate::error::shown;
use crate::input::{MAX_TEXT_BYTES, Room, utf8_or_latin1};
use crate::scan::Shape;
use crate::text::rows::decimal_comma;
use crate::unit::per_metre;

/// Key with its value, and the unit in brackets after the key.
struct Pair {
    key: String,
    /// Key in small letters, without unit, with single spaces between words.
    name: String,
    unit: Option<f64>,
    value: String,
}

/// Pairs of keys and values of a header.
#[derive(Default)]
pub(crate) struct Header {
    pairs: Vec<Pair>,
    /// Limit of further pairs.
    room: Room,
}

/// Interpretation of a header.
pub(crate) struct Meaning {
    /// Distance between points along x and y in metre.
    pub(crate) pitch_m: Option<(f64, f64)>,
    /// Conversion of numbers to heights: multiplication by `factor`, then division by `per_metre`, so that units stay
    /// exact.
    pub(crate) factor: f64,
    pub(crate) per_metre: f64,
    /// Original unit or factor of converted numbers; `None` if they are in metre.
    pub(crate) converted: Option<String>,
    /// Unit of the heights in the header, after a factor.
    pub(crate) unit: Option<String>,
    /// Number that marks a missing point.
    pub(crate) no_data: Option<f64>,
    pub(crate) warnings: Vec<String>,
}

/// Keys with one meaning, separated by bars.
const HEIGHT_UNIT: &str =
    "value units|value unit|z unit|z units|zunit|height unit|height units|unit z|data unit|data units|unit data";
const ANY_UNIT: &str = "unit|units";
const X_UNIT: &str = "x unit|x units|xunit|unit x|xy unit|xy units|unit xy|lateral unit|lateral units";
const Y_UNIT: &str = "y unit|y units|yunit|unit y";
const PIXEL_SIZE: &str = "pixel size|pixel sizes|pixel spacing|point spacing|pixel pitch|pitch|spacing";
const DX: &str = "dx|delta x|x step|step x|x spacing|x pitch|x pixel size|pixel size x|pixel width|scale x";
const DY: &str = "dy|delta y|y step|step y|y spacing|y pitch|y pixel size|pixel size y|pixel height|scale y";
const SIZE: &str = "size|sizes|scan size|physical size|physical sizes|field of view|image size|map size";
const WIDTH: &str = "width|x length|xlength|x size|size x|x range|breite|largeur|larghezza|anchura|šířka";
const HEIGHT: &str = "height|y length|ylength|y size|size y|y range|höhe|hauteur|altezza|altura|výška";
const COLUMNS: &str = "x pixels|ncols|nx";
const ROWS: &str = "y pixels|nrows|ny";
const CHANNEL: &str = "channel|kanal|canal|canale|kanál";
/// Maximum number of bytes of these keys.
const MAX_CHANNEL_KEY: usize = 8;
const BIT_TO_NM: &str = "bit2nm";
const FACTOR: &str = "conversion factor";
/// Words beside it in keys that convert heights.
const OF_HEIGHTS: &str = "height|heights|z|data|value|values";
/// Maximum number of factors that warnings quote.
const QUOTED_FACTORS: usize = 8;
/// Key of the note that all decimal signs are commas.
pub(super) const DECIMAL_SIGN: &str = "decimal sign";
/// Key of comments without a key.
const COMMENT: &str = "comment";
const NO_DATA: &str = "nodata value|no data value|nodata|no data|missing value|fill value";
/// Keys of an ESRI grid, which precede their values without a sign between.
pub(super) const ESRI: &[&str] =
    &["ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value"];
/// Default mark of missing points in an ESRI grid.
const ESRI_NO_DATA: f64 = -9999.0;

/// Conversion factor of heights.
#[derive(Clone, Copy)]
struct Factor<'a> {
    pair: &'a Pair,
    value: f64,
    /// Unit before the conversion, if the header names it.
    source: Option<&'a str>,
    /// Unit after the conversion and its number per metre, if the header names it.
    target: Option<(&'a str, Option<f64>)>,
}

/// Conversion factors of a header.
struct Factors<'a> {
    /// Factor to apply.
    used: Option<Factor<'a>>,
    /// Pairs with factors that are not applied.
    unused: Vec<&'a Pair>,
}

impl Pair {
    /// Returns the key and the value for a message.
    fn quoted(&self) -> String {
        match self.name.as_str() {
            COMMENT => format!("`{}`", shown(&self.value)),
            _ => format!("`{}: {}`", shown(&self.key), shown(&self.value)),
        }
    }

    /// Returns whether this pair states a conversion factor.
    fn is_factor(&self) -> bool {
        self.name == BIT_TO_NM
            || self.name.contains(FACTOR)
            || self.name == COMMENT && self.value.to_lowercase().contains(FACTOR)
    }

    /// Returns the factor for heights; `None` for another factor. Its value is NaN if it is not a number.
    fn factor(&self, has_decimal_commas: bool) -> Option<Factor<'_>> {
        let (value, behind) = factor_value(&self.value, has_decimal_commas).unwrap_or((f64::NAN, ""));
        if self.name == BIT_TO_NM {
            return Some(Factor { pair: self, value, source: None, target: Some(("nm", Some(1e9))) });
        }
        let (before, after) = self.name.split_once(FACTOR)?;
        if !before.split_whitespace().chain(after.split_whitespace()).all(|word| is_one_of(OF_HEIGHTS, word)) {
            return None;
        }
        let bracket = self.key.split_once(['(', '[']).map_or("", |(_, bracket)| bracket);
        let (stated, other) = (units_of_factor(bracket), units_of_factor(behind));
        let target = match [stated.1, other.1].map(|name| name.map(|name| (name, unit(name)))) {
            // Units that contradict each other are ignored.
            [Some((name, per_metre)), Some((_, other))] => Some((name, per_metre.filter(|_| per_metre == other))),
            [target, other] => target.or(other),
        };
        Some(Factor { pair: self, value, source: stated.0.or(other.0), target })
    }
}

/// Returns the number at the start of a text and the text after it. A comma between digits is the decimal sign unless
/// it may separate thousands.
fn factor_value(text: &str, has_decimal_commas: bool) -> Option<(f64, &str)> {
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let sign = usize::from(text.starts_with(['+', '-']));
    let comma = sign + digits(&text[sign..]);
    let (value, length) = match text[comma..].strip_prefix(',') {
        Some(rest) => {
            let decimals = digits(rest);
            let ends = !rest[decimals..].starts_with(['e', 'E', ',', '.']);
            let may_be_thousands =
                ends && decimals == 3 && (1..=3).contains(&(comma - sign)) && !text[sign..].starts_with('0');
            if decimals == 0 || comma == sign || may_be_thousands && !has_decimal_commas {
                return None;
            }
            fast_float2::parse_partial(text.replacen(',', ".", 1)).ok()?
        }
        None => fast_float2::parse_partial(text).ok()?,
    };
    let behind = &text[length..];
    (!behind.starts_with([',', '.'])).then(|| (value, behind.trim()))
}

/// Returns the units before and after a conversion: `V -> nm`, `-> nm`, `nm/V` or `nm`.
fn units_of_factor(text: &str) -> (Option<&str>, Option<&str>) {
    let arrow = ["->", "→"].into_iter().find_map(|arrow| text.split_once(arrow));
    let (source, target) = match (arrow, text.split_once('/')) {
        (Some((source, target)), _) | (None, Some((target, source))) => (source, target),
        (None, None) => ("", text),
    };
    let named = |unit| Some(bare(unit)).filter(|unit| !unit.is_empty());
    (named(source), named(target))
}

/// Returns whether a name is one of several that bars separate.
fn is_one_of(names: &str, name: &str) -> bool {
    names.split('|').any(|one| one == name)
}

/// Returns whether two units are equal.
fn is_same_unit(one: &str, other: &str) -> bool {
    bare(one).eq_ignore_ascii_case(bare(other)) || unit(one).is_some_and(|one| unit(other) == Some(one))
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
        self.pairs.push(Pair { key: key.into(), name, unit, value: value.into() });
    }

    /// Returns the pair of the first key that is present.
    fn find(&self, names: &str) -> Option<&Pair> {
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

    /// Returns whether the numbers can be heights: they have a conversion factor, a unit of length or no unit.
    pub(crate) fn may_be_heights(&self) -> bool {
        self.factors().is_ok_and(|factors| factors.used.is_some())
            || self.height_unit().is_none_or(|(_, _, per_metre)| per_metre.is_some())
    }

    /// Returns the number of units per metre for x, y and z.
    pub(crate) fn units(&self) -> [Option<f64>; 3] {
        let named = |names| self.find(names).and_then(|pair: &Pair| unit(&pair.value));
        let any = named(ANY_UNIT);
        let x = named(X_UNIT).or(any);
        [x, named(Y_UNIT).or(x), named(HEIGHT_UNIT).or(any)]
    }

    /// Interprets the header of a matrix of `columns` × `rows` numbers. If the user stated the unit (`is_stated`),
    /// unknown units give no warning and no factor is applied.
    ///
    /// # Errors
    /// The key and the value of a conversion factor that is not a number or is 0, if no unit of length is stated.
    pub(crate) fn meaning(&self, (rows, columns): Shape, is_stated: bool) -> Result<Meaning, (&str, &str)> {
        let mut warnings = Vec::new();
        let pitch_m = self.pitch((rows, columns), &mut warnings);
        if let Some(stated) = self.shape().filter(|&stated| stated != (rows, columns)) {
            let (ny, nx) = stated;
            warnings.push(format!("the header states {nx} × {ny} points; there are {columns} × {rows}"));
        }
        let replaced = |pair: &Pair| format!("the stated height unit replaces the header's {}", pair.quoted());
        let Factors { used, unused } = match self.factors() {
            Ok(Factors { used: Some(factor), unused }) if is_stated => {
                warnings.push(replaced(factor.pair));
                Factors { used: None, unused }
            }
            Err(pair) if is_stated => {
                warnings.push(replaced(pair));
                Factors { used: None, unused: Vec::new() }
            }
            Err(pair) => return Err((&pair.key, &pair.value)),
            Ok(factors) => factors,
        };
        let not_used = |pair: &&Pair| format!("the header states {}, which was not used", pair.quoted());
        warnings.extend(unused.iter().take(QUOTED_FACTORS).map(not_used));
        let (mut factor, mut per_metre, mut converted, mut unit) = (1.0, 1.0, None, None);
        match (used, self.height_unit()) {
            (Some(Factor { pair, value, source, target }), stated) => {
                let (name, target_per_metre) =
                    target.map_or(("m", 1.0), |(name, per_metre)| (name, per_metre.unwrap_or(1.0)));
                (factor, per_metre, converted, unit) = (value, target_per_metre, Some(pair.key.as_str()), Some(name));
                if let Some((key, unit, Some(other))) = stated
                    && other != per_metre
                    && source.is_none()
                {
                    let (key, unit, factor) = (shown(key), shown(unit), shown(&pair.key));
                    warnings.push(format!("the header states `{key}: {unit}` and `{factor}`; the factor was used"));
                }
                let quoted = pair.quoted();
                if target.is_none() {
                    warnings.push(format!("the header states {quoted} without a unit; metre was assumed"));
                }
                if value < 0.0 {
                    let effect = "this negative factor turns the surface upside down";
                    warnings.push(format!("the header states {quoted}; {effect}"));
                }
            }
            (None, Some((_, stated, Some(stated_per_metre)))) => {
                (per_metre, converted, unit) = (stated_per_metre, Some(stated), Some(bare(stated)));
            }
            (None, Some((key, stated, None))) => {
                unit = Some(stated);
                warnings.extend((!is_stated).then(|| doubt(key, stated)));
            }
            (None, None) => {
                let other = self.other_unit().filter(|_| !is_stated);
                warnings.extend(other.map(|pair| doubt(&pair.key, &pair.value)));
            }
        }
        let converted = converted.filter(|_| factor != 1.0 || per_metre != 1.0).map(str::to_owned);
        let (unit, no_data) = (unit.map(str::to_owned), self.no_data());
        Ok(Meaning { pitch_m, factor, per_metre, converted, unit, no_data, warnings })
    }

    /// Returns a pair that may name a unit of the heights under another key.
    fn other_unit(&self) -> Option<&Pair> {
        let is_height_unit = |name: &str| name.contains("unit") && !is_one_of(X_UNIT, name) && !is_one_of(Y_UNIT, name);
        self.pairs.iter().find(|pair| is_height_unit(&pair.name) && pair.value != "m")
    }

    /// Returns the factor that converts numbers to heights, and the pairs of other factors.
    ///
    /// `Bit2nm` of SPIP converts to nanometre, `height conversion factor (-> m)` to any unit, unless the numbers are
    /// already in it. A factor without a unit converts to metre if it is the only one and no unit of length is
    /// stated.
    ///
    /// # Errors
    /// A factor that is not a number or is 0, if no unit of length is stated.
    fn factors(&self) -> Result<Factors<'_>, &Pair> {
        let stated = self.height_unit();
        let length = stated.and_then(|(_, _, per_metre)| per_metre);
        let has_decimal_commas = self.find(DECIMAL_SIGN).is_some();
        let (mut known, mut unused) = (Vec::new(), Vec::new());
        for pair in self.pairs.iter().filter(|pair| pair.is_factor()) {
            let Some(factor) = pair.factor(has_decimal_commas) else {
                unused.push(pair);
                continue;
            };
            let is_bit = pair.name == BIT_TO_NM;
            let leads_nowhere = matches!(factor.target, Some((_, None)));
            // Koala states the factor of phases also for heights.
            let is_done =
                length.is_some() && !is_bit && factor.target.map_or(Some(1.0), |(_, target)| target) == length;
            let is_of_other_unit =
                stated.zip(factor.source).is_some_and(|((_, unit, _), source)| !is_same_unit(unit, source));
            if is_done && !factor.source.is_some_and(|source| unit(source) == length) {
                continue;
            }
            if leads_nowhere || is_of_other_unit || factor.target.is_none() && length.is_some() {
                unused.push(pair);
            } else if factor.value.is_finite() && factor.value != 0.0 {
                known.push(factor);
            } else if length.is_some() && !is_bit {
                unused.push(pair);
            } else {
                return Err(pair);
            }
        }
        let named = known.iter().position(|factor| factor.pair.name == BIT_TO_NM);
        let named = named.or_else(|| known.iter().position(|factor| factor.target.is_some()));
        let place = named.or_else(|| Some(0).filter(|_| known.len() == 1));
        let used = place.map(|place| known.remove(place));
        unused.extend(known.iter().map(|factor| factor.pair));
        Ok(Factors { used, unused })
    }

    fn no_data(&self) -> Option<f64> {
        let stated = self.find(NO_DATA).and_then(|pair| pair.value.parse().ok());
        stated.or_else(|| self.is_esri().then_some(ESRI_NO_DATA))
    }

    /// Returns the pixel size from the first key that states it.
    fn pitch(&self, (rows, columns): Shape, warnings: &mut Vec<String>) -> Option<(f64, f64)> {
        let [x_unit, y_unit, _] = self.units();
        let is_spip = || self.find("file format").is_some_and(|pair| pair.value == "ASCII");
        let steps = |pair: &Pair, unit: Option<f64>| Lengths::parse(&pair.value, pair.unit.or(unit));
        if let Some(lengths) = self.find(PIXEL_SIZE).and_then(|pair| steps(pair, x_unit)) {
            return Some(lengths.pair(warnings));
        }
        if let Some(x) = self.find(DX).and_then(|pair| steps(pair, x_unit)) {
            let y = self.find(DY).and_then(|pair| steps(pair, y_unit));
            let (dx_m, _) = x.pair(warnings);
            return Some((dx_m, y.map_or(dx_m, |y| y.metre[0])));
        }
        if let Some(cell) = self.find("cellsize").and_then(|pair| steps(pair, x_unit)) {
            return Some((cell.metre[0], cell.metre[0]));
        }
        // Numbers equal to the numbers of points are counts, unless they have a unit or the header names a lateral
        // unit.
        let has_lateral = self.find(X_UNIT).is_some_and(|pair| unit(&pair.value).is_some());
        let is_length = |pair: &Pair| has_lateral || steps(pair, None).is_some_and(|lengths| lengths.has_unit);
        // Sizes cover all points: columns · dx, as in Gwyddion and SPIP.
        let pitch = |(width_m, height_m): (f64, f64)| (width_m / columns as f64, height_m / rows as f64);
        if let Some((pair, size)) = self.find(SIZE).and_then(|pair| Some((pair, steps(pair, x_unit)?)))
            && size.has_unit
            && (is_length(pair) || size.numbers() != [columns as f64, rows as f64])
        {
            return Some(pitch(size.pair(warnings)));
        }
        let nanometre = is_spip().then_some(1e9);
        let named = |names, unit: Option<f64>| {
            let pair = self.find(names)?;
            Some((pair, steps(pair, unit.or(nanometre))?))
        };
        let (x, width) = named(WIDTH, x_unit)?;
        let Some((y, height)) = named(HEIGHT, y_unit) else {
            if width.has_unit {
                warnings.push("the header states a width but no height; no pixel size was read".into());
            }
            return None;
        };
        let counts = [width.numbers(), height.numbers()].concat();
        let are_counts =
            counts == [columns as f64, rows as f64] && nanometre.is_none() && !(is_length(x) && is_length(y));
        let are_lengths = width.has_unit && height.has_unit && !are_counts;
        are_lengths.then(|| pitch((width.metre[0], height.metre[0])))
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

fn doubt(key: &str, unit: &str) -> String {
    format!("a comment states `{}: {}`; heights count as metre", shown(key), shown(unit))
}

/// Returns the number of units per metre. Brackets around the unit are ignored.
pub(crate) fn unit(text: &str) -> Option<f64> {
    per_metre(bare(text))
}

/// Returns a unit without the brackets around it.
fn bare(text: &str) -> &str {
    text.trim().trim_matches(['[', ']', '(', ')', '"', '\'']).trim()
}

/// One or two lengths.
struct Lengths {
    metre: Vec<f64>,
    stated: Vec<f64>,
    has_unit: bool,
}

impl Lengths {
    /// Parses lengths such as `0.5 um x 0.25 um`, `1 2 mm` or `(3, 4)`. A unit applies to the numbers before it.
    /// Numbers without a unit are in `unit`, or else in metre.
    fn parse(text: &str, unit: Option<f64>) -> Option<Self> {
        let mut lengths = Self { metre: Vec::new(), stated: Vec::new(), has_unit: true };
        let (mut scaled, mut rest) = (0, text);
        loop {
            rest = rest.trim_start_matches([' ', '\t', ',', ';', '(', ')', '[', ']', '*', '×']);
            let Some(first) = rest.chars().next() else { break };
            if lengths.stated.len() > 2 {
                return None;
            }
            let times = rest.strip_prefix(['x', 'X']).filter(|after| !after.starts_with(char::is_alphabetic));
            if first.is_ascii_digit() || matches!(first, '+' | '-' | '.') {
                let (number, length) = leading_number(rest)?;
                lengths.stated.push(number);
                rest = &rest[length..];
            } else if let Some(after) = times.or_else(|| rest.strip_prefix("by ")) {
                rest = after;
            } else {
                let length = rest.find([' ', '\t', ',', ';', '(', ')', '[', ']', '*', '×']).unwrap_or(rest.len());
                let (word, after) = rest.split_at(length);
                rest = after;
                let per_metre = per_metre(word)?;
                lengths.metre.extend(lengths.stated[scaled..].iter().map(|number| number / per_metre));
                scaled = lengths.stated.len();
            }
        }
        lengths.has_unit = unit.is_some() || scaled == lengths.stated.len();
        lengths.metre.extend(lengths.stated[scaled..].iter().map(|number| number / unit.unwrap_or(1.0)));
        (1..=2).contains(&lengths.metre.len()).then_some(lengths)
    }

    fn numbers(&self) -> &[f64] {
        &self.stated
    }

    /// Returns the lengths along x and y. A single length applies to both.
    fn pair(&self, warnings: &mut Vec<String>) -> (f64, f64) {
        if !self.has_unit {
            warnings.push("the header states a pixel size without a unit; metre was assumed".into());
        }
        (self.metre[0], self.metre[self.metre.len() - 1])
    }
}

/// Returns the number at the start of a text and its length; `1,5` is one number.
fn leading_number(text: &str) -> Option<(f64, usize)> {
    let comma = text.find(|c: char| !c.is_ascii_digit() && c != ',').unwrap_or(text.len());
    match decimal_comma(&text.as_bytes()[..comma]) {
        Some(number) => Some((number, comma)),
        None => fast_float2::parse_partial(text).ok(),
    }
}
