//! Table of offsets and measurement conditions of a VK4 file.

use crate::{Field, Input, Result};

/// Offset of the table of offsets.
const OFFSETS: usize = 12;
/// Entry of the table for the conditions.
const CONDITIONS_ENTRY: usize = 0;
/// Picometre per metre.
const PM_PER_METRE: f64 = 1e12;

/// Returns the measurement conditions, whose offset is in the first entry of the table.
pub(super) fn conditions(input: Input) -> Result<Input> {
    let start = offset(input, "the measurement conditions", CONDITIONS_ENTRY)?
        .ok_or_else(|| input.missing("the offset of the measurement conditions", OFFSETS, "a value above 0"))?;
    let size = usize::try_from(input.u32("the size of the measurement conditions", start)?).unwrap_or(usize::MAX);
    let end = start + input.take("the measurement conditions", start, size)?.len();
    Ok(input.up_to(end).from(start))
}

/// Reads a field of the measurement conditions. Its offset counts numbers of 4 bytes.
pub(super) fn number(conditions: &Input, field: Field) -> Result<u32> {
    conditions.u32(field.0, 4 * field.1)
}

/// Reads a length, stored in picometre, in metre.
pub(super) fn length_m(conditions: &Input, field: Field) -> Result<f64> {
    Ok(f64::from(number(conditions, field)?) / PM_PER_METRE)
}

/// Returns the offset in an entry of the table; `None` if the part is absent.
pub(super) fn offset(input: Input, part: &str, entry: usize) -> Result<Option<usize>> {
    let at = OFFSETS + 4 * entry;
    let found = input.u32(&format!("the offset of {part}"), at)?;
    Ok(usize::try_from(found).ok().filter(|&offset| offset > 0))
}
