//! Frequency band of records.

/// Frequencies used of records, and the transfer function of their filters.
///
/// A Gaussian filter of cutoff λ (ISO 16610-21) passes the amplitude 2^{−(λf)²} of a wave of frequency f.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RecordBand {
    /// Lowest frequency used, in 1/metre; trends were removed below it.
    pub lowest_per_m: f64,
    /// Highest frequency used, in 1/metre; by default half a wave per window, where 4/π² of the power remains.
    pub highest_per_m: Option<f64>,
    /// Cutoff in metre of a Gaussian low-pass filter applied to the records; frequencies above 1/cutoff are not used.
    pub low_pass_m: Option<f64>,
    /// Cutoff in metre of a Gaussian high-pass filter applied to the records; frequencies below 1/cutoff are not used.
    pub high_pass_m: Option<f64>,
}

impl RecordBand {
    /// Returns the lowest frequency, including the limits of the filters.
    pub(super) fn low_per_m(&self) -> f64 {
        self.lowest_per_m.max(self.high_pass_m.map_or(0.0, f64::recip))
    }

    /// Returns the highest frequency, including the limits of the filters; `open_per_m` is the default.
    pub(super) fn high_per_m(&self, open_per_m: f64) -> f64 {
        self.highest_per_m.unwrap_or(open_per_m).min(self.low_pass_m.map_or(f64::INFINITY, f64::recip))
    }

    /// Returns the power transfer function of the filters at a frequency.
    pub(super) fn passed(&self, frequency_per_m: f64) -> f64 {
        let mean_line = |cutoff_m: f64| (-(cutoff_m * frequency_per_m).powi(2)).exp2();
        let low = self.low_pass_m.map_or(1.0, |cutoff_m| mean_line(cutoff_m).powi(2));
        let high = self.high_pass_m.map_or(1.0, |cutoff_m| (1.0 - mean_line(cutoff_m)).powi(2));
        low * high
    }
}
