//! Spatial arrangement of records.

/// Arrangement of the records of a process: periodic or free, and the number of parallel *tracks* of a strip.
///
/// Strips are independent; tracks of a strip may be correlated, so errors are summed over strips. Records are listed
/// strip by strip and track by track; the tracks of a strip have equal length and aligned positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Whether records are periodic.
    pub periodic: bool,
    /// Records per strip, at least 1.
    pub tracks: usize,
}

/// Creates the layout of one record per strip, periodic or not.
impl From<bool> for Layout {
    fn from(periodic: bool) -> Self {
        Self { periodic, tracks: 1 }
    }
}

impl Layout {
    /// Returns the number of strips.
    #[doc(hidden)]
    pub fn strips(self, records: usize) -> usize {
        records.div_ceil(self.tracks)
    }

    /// Returns the tracks of each strip.
    ///
    /// # Panics
    /// If a strip is incomplete, or its tracks differ in length.
    #[doc(hidden)]
    pub fn by_strip<T: AsRef<[f64]>>(self, records: &[T]) -> impl Iterator<Item = &[T]> {
        assert!(records.len().is_multiple_of(self.tracks), "{} records of {} tracks", records.len(), self.tracks);
        let even = |strip: &[T]| strip.iter().all(|track| track.as_ref().len() == strip[0].as_ref().len());
        records.chunks(self.tracks).inspect(move |strip| assert!(even(strip), "tracks of a strip are equally long"))
    }
}

/// Returns the sum over the tracks of a function of the values present (finite), at every position; NaN without a
/// value.
#[doc(hidden)]
pub fn sum_of_tracks<T: AsRef<[f64]>>(tracks: &[T], of: impl Fn(f64) -> f64) -> Vec<f64> {
    let at = |place: usize| {
        let values = tracks.iter().map(|track| track.as_ref()[place]).filter(|value| value.is_finite());
        values.map(&of).reduce(|a, b| a + b).unwrap_or(f64::NAN)
    };
    (0..tracks.first().map_or(0, |track| track.as_ref().len())).map(at).collect()
}
