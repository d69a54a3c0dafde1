//! Limit cycle as a table of a report folder.

use asperity::study::{Table, portrait_table};
use asperity::vibration::{Oscillator, VibrationError, cycle_portrait};

/// Points of a drawn limit cycle.
const CYCLE_POINTS: usize = 600;

/// Returns the limit cycle without fluctuation, if there is one.
pub(super) fn cycle(oscillator: &Oscillator) -> Result<Option<(&'static str, Table)>, VibrationError> {
    Ok(cycle_portrait(oscillator, CYCLE_POINTS)?.map(|points| ("limit_cycle", portrait_table(&points))))
}
