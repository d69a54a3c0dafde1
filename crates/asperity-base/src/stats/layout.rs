//! How records lie.

/// How the records of a process lie: whether they go round, and how many *lanes* lie side by side on one strip.
///
/// Strips are independent of each other, lanes of a strip need not be: errors add up over strips. Records come strip by
/// strip, the lanes of one after another, of equal length and position by position side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Whether a record goes on with its first value after its last.
    pub periodic: bool,
    /// Records per strip, at least 1.
    pub lanes: usize,
}

/// One record per strip, periodic or not.
impl From<bool> for Layout {
    fn from(periodic: bool) -> Self {
        Self { periodic, lanes: 1 }
    }
}

impl Layout {
    /// Returns the number of strips.
    #[doc(hidden)]
    pub fn strips(self, records: usize) -> usize {
        records.div_ceil(self.lanes)
    }

    /// Returns the lanes of each strip.
    ///
    /// # Panics
    /// If a strip lacks a lane, or its lanes differ in length.
    #[doc(hidden)]
    pub fn by_strip<T: AsRef<[f64]>>(self, records: &[T]) -> impl Iterator<Item = &[T]> {
        assert!(records.len().is_multiple_of(self.lanes), "{} records of {} lanes", records.len(), self.lanes);
        let even = |strip: &[T]| strip.iter().all(|lane| lane.as_ref().len() == strip[0].as_ref().len());
        records.chunks(self.lanes).inspect(move |strip| assert!(even(strip), "lanes of a strip are equally long"))
    }
}

/// Returns the sum over the lanes at every position of a function of the values present (finite); NaN where none is.
#[doc(hidden)]
pub fn sum_of_lanes<T: AsRef<[f64]>>(lanes: &[T], of: impl Fn(f64) -> f64) -> Vec<f64> {
    let at = |place: usize| {
        let values = lanes.iter().map(|lane| lane.as_ref()[place]).filter(|value| value.is_finite());
        values.map(&of).reduce(|a, b| a + b).unwrap_or(f64::NAN)
    };
    (0..lanes.first().map_or(0, |lane| lane.as_ref().len())).map(at).collect()
}
