//! Flat-top lag windows, under which correlograms are summed to the variance of a statistic.
//!
//! # References
//! Politis & Romano, *J. Time Ser. Anal.* **16** (1995) 67, <https://doi.org/10.1111/j.1467-9892.1995.tb00223.x>.

/// Level that defines the reach of a correlogram.
pub const FADED: f64 = 0.2;
/// Length of a window in reaches. It then contains 98 % of an exponential correlogram along a line, 95 % in a plane.
pub const REACHES: f64 = 4.65;
/// Least length of a window in correlation lengths of the values.
const LEAST_LENGTHS: f64 = 3.75;
/// Number of blocks down to which a large sample has a wider window.
pub const BLOCKS_TO_SPARE: f64 = 40.0;
/// Largest fraction of the variance in the window removed by the fitted means.
pub const LARGEST_FITTED: f64 = 0.5;

/// Returns the weight of a lag: 1 up to half of `end`, then decreasing to 0 at `end`.
pub fn weight(distance: f64, end: f64) -> f64 {
    (2.0 - 2.0 * distance / end).clamp(0.0, 1.0)
}

/// Returns the least end of a window for the reach of the correlogram and the correlation length of the values.
pub fn least_end(reach: f64, length: f64) -> f64 {
    (REACHES * reach).max(LEAST_LENGTHS * length).max(3.0)
}
