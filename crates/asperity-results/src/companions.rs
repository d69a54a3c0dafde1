//! Statistics with several keys in one object: `x`, `x_interval`, `x_se`, ….

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::Pair;

/// Statistics by name in the order of the file; `None` where undefined.
#[derive(Debug, Clone, PartialEq)]
pub struct Companions<T>(pub Vec<(String, Option<T>)>);

impl<T> Default for Companions<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Companions<T> {
    /// Returns the statistic of a name if it is defined.
    pub fn get(&self, name: &str) -> Option<&T> {
        self.0.iter().find(|(own, _)| own == name)?.1.as_ref()
    }
}

/// Interval and standard error of a statistic, without its value.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SpreadResult {
    /// 95 % interval.
    pub interval: Pair,
    /// Standard error.
    pub standard_error: f64,
}

/// A statistic of a part.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PooledResult {
    /// Weighted mean of the values of the scans.
    pub value: f64,
    /// 95 % interval of the part's statistic.
    pub interval: Pair,
    /// Standard error of the part's statistic.
    pub standard_error: f64,
    /// Standard error of a single scan; `None` when no scan has one.
    pub within_std: Option<f64>,
    /// Standard deviation between places of the part.
    pub between_std: Option<f64>,
}

/// A number or an interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CompanionCell {
    /// A number.
    Number(f64),
    /// [low, high].
    Interval(Pair),
}

impl CompanionCell {
    fn number(self) -> Option<f64> {
        if let Self::Number(value) = self { Some(value) } else { None }
    }

    fn interval(self) -> Option<Pair> {
        if let Self::Interval(ends) = self { Some(ends) } else { None }
    }
}

/// A statistic as cells, one for each ending of its name.
pub trait CompanionCells: Sized {
    /// Endings of the keys. A name ends with the first that fits.
    const ENDINGS: &'static [&'static str];

    /// Returns one cell for each ending.
    fn cells(&self) -> Vec<Option<CompanionCell>>;

    /// Returns the statistic of cells, or `None` if it is undefined.
    fn from_cells(cells: &[Option<CompanionCell>]) -> Option<Self>;
}

impl CompanionCells for SpreadResult {
    const ENDINGS: &'static [&'static str] = &["_interval", "_se"];

    fn cells(&self) -> Vec<Option<CompanionCell>> {
        vec![Some(CompanionCell::Interval(self.interval)), Some(CompanionCell::Number(self.standard_error))]
    }

    fn from_cells(cells: &[Option<CompanionCell>]) -> Option<Self> {
        Some(Self { interval: cells[0]?.interval()?, standard_error: cells[1]?.number()? })
    }
}

impl CompanionCells for PooledResult {
    const ENDINGS: &'static [&'static str] = &["_interval", "_se", "_within_std", "_between_std", ""];

    fn cells(&self) -> Vec<Option<CompanionCell>> {
        let numbers = [Some(self.standard_error), self.within_std, self.between_std, Some(self.value)];
        std::iter::once(Some(CompanionCell::Interval(self.interval)))
            .chain(numbers.map(|number| number.map(CompanionCell::Number)))
            .collect()
    }

    fn from_cells(cells: &[Option<CompanionCell>]) -> Option<Self> {
        Some(Self {
            interval: cells[0]?.interval()?,
            standard_error: cells[1]?.number()?,
            within_std: cells[2].and_then(CompanionCell::number),
            between_std: cells[3].and_then(CompanionCell::number),
            value: cells[4]?.number()?,
        })
    }
}

impl<T: CompanionCells> Serialize for Companions<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let entries = self.0.iter().flat_map(|(name, statistic)| {
            let cells = statistic.as_ref().map_or_else(|| vec![None; T::ENDINGS.len()], T::cells);
            let keys = T::ENDINGS.iter().map(move |ending| format!("{name}{ending}"));
            let mut entries: Vec<_> = keys.zip(cells).collect();
            // A value comes before its companions.
            entries.sort_by_key(|(key, _)| key != name);
            entries
        });
        serializer.collect_map(entries)
    }
}

impl<'de, T: CompanionCells> Deserialize<'de> for Companions<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Keys(PhantomData))
    }
}

struct Keys<T>(PhantomData<T>);

impl<'de, T: CompanionCells> Visitor<'de> for Keys<T> {
    type Value = Companions<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("statistics")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Companions<T>, A::Error> {
        let mut found: Vec<(String, Vec<Option<CompanionCell>>)> = Vec::new();
        while let Some(key) = map.next_key::<String>()? {
            let split = T::ENDINGS.iter().enumerate().find_map(|(place, end)| Some((place, key.strip_suffix(end)?)));
            let (place, name) = split.ok_or_else(|| A::Error::custom(format_args!("unknown field `{key}`")))?;
            let cell = map.next_value()?;
            match found.iter_mut().find(|(own, _)| own == name) {
                Some((_, cells)) => cells[place] = cell,
                None => {
                    let mut cells = vec![None; T::ENDINGS.len()];
                    cells[place] = cell;
                    found.push((name.to_owned(), cells));
                }
            }
        }
        let statistics = found.into_iter().map(|(name, cells)| match T::from_cells(&cells) {
            None if cells.iter().any(Option::is_some) => Err(A::Error::custom(format_args!("`{name}` is incomplete"))),
            statistic => Ok((name, statistic)),
        });
        statistics.collect::<Result<_, _>>().map(Companions)
    }
}
