//! The table of offsets and the measurement conditions of a VK4 file.

use crate::error::Result;
use crate::input::Input;

/// Where the table of offsets starts.
const OFFSETS: usize = 12;
/// The entry of the table that leads to the conditions.
const CONDITIONS_ENTRY: usize = 0;
/// Picometre per metre.
const PM_PER_METRE: f64 = 1e12;

/// A field of the measurement conditions and its place, counted in numbers.
#[derive(Clone, Copy)]
pub(super) struct Field(pub(super) &'static str, pub(super) usize);

/// The measurement conditions: the file up to their end, and where they start.
#[derive(Clone, Copy)]
pub(super) struct Conditions<'a> {
    input: Input<'a>,
    start: usize,
}

impl<'a> Conditions<'a> {
    pub(super) fn new(input: Input<'a>) -> Result<Self> {
        let start = offset(input, "the measurement conditions", CONDITIONS_ENTRY)?
            .ok_or_else(|| input.missing("the offset of the measurement conditions", OFFSETS, "a value above 0"))?;
        let size = usize::try_from(input.u32("the size of the measurement conditions", start)?).unwrap_or(usize::MAX);
        let end = start + input.take("the measurement conditions", start, size)?.len();
        Ok(Self { input: input.up_to(end), start })
    }

    pub(super) fn at(&self, field: Field) -> usize {
        self.start + 4 * field.1
    }

    pub(super) fn u32(&self, field: Field) -> Result<u32> {
        self.input.u32(field.0, self.at(field))
    }

    /// A length that is stored in picometre.
    pub(super) fn metre(&self, field: Field) -> Result<f64> {
        Ok(f64::from(self.u32(field)?) / PM_PER_METRE)
    }
}

/// The offset in an entry of the table, `None` where the part is not there.
pub(super) fn offset(input: Input, part: &str, entry: usize) -> Result<Option<usize>> {
    let at = OFFSETS + 4 * entry;
    let found = input.u32(&format!("the offset of {part}"), at)?;
    Ok(usize::try_from(found).ok().filter(|&offset| offset > 0))
}
