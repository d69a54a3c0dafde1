//! Warning about friction values that are clipped to stay positive.

use crate::study::sentence;

/// Clipped fraction below which no warning is given.
const NEGLIGIBLE: f64 = 1e-4;

/// Returns a warning about a clipped fraction of the friction; `None` below 0.01 %.
pub fn clipping_warning(fraction: f64) -> Option<String> {
    (fraction >= NEGLIGIBLE).then(|| {
        format!(
            "{} % of the friction values were clipped to stay positive; variability is understated",
            sentence::digits(100.0 * fraction)
        )
    })
}
