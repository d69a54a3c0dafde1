//! Which wavenumbers of a record speak of the process.

/// The frequencies of records that are used, and what filters left of their power.
///
/// A Gaussian filter of cutoff λ (ISO 16610-21) passes the amplitude 2^{−(λf)²} of a wave of frequency f.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RecordBand {
    /// Lowest frequency that is used, in 1/metre; what a trend took out is below.
    pub lowest_per_m: f64,
    /// Highest frequency that is used, in 1/metre. Absent, half a wave in a window, where it leaves 4/π² of the power.
    pub highest_per_m: Option<f64>,
    /// Cutoff in metre of a Gaussian filter that took faster waves out; nothing above 1/cutoff is used.
    pub low_pass_m: Option<f64>,
    /// Cutoff in metre of a Gaussian filter that took slower waves out; nothing below 1/cutoff is used.
    pub high_pass_m: Option<f64>,
}

impl RecordBand {
    /// Returns the lowest frequency with filters.
    pub(super) fn low_per_m(&self) -> f64 {
        self.lowest_per_m.max(self.high_pass_m.map_or(0.0, f64::recip))
    }

    /// Returns the highest frequency with filters, `open_per_m` where none is stated.
    pub(super) fn high_per_m(&self, open_per_m: f64) -> f64 {
        self.highest_per_m.unwrap_or(open_per_m).min(self.low_pass_m.map_or(f64::INFINITY, f64::recip))
    }

    /// Returns the fraction of the power that the filters leave at a frequency.
    pub(super) fn passed(&self, frequency_per_m: f64) -> f64 {
        let mean_line = |cutoff_m: f64| (-(cutoff_m * frequency_per_m).powi(2)).exp2();
        let low = self.low_pass_m.map_or(1.0, |cutoff_m| mean_line(cutoff_m).powi(2));
        let high = self.high_pass_m.map_or(1.0, |cutoff_m| (1.0 - mean_line(cutoff_m)).powi(2));
        low * high
    }
}
