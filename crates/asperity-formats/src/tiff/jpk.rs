//! JPK images: pages of integers with private fields from 32768 on, the first of them a small picture.
//!
//! A page states its numbers in several *slots*, each with the straight line from the stored integers to a unit, and names the default
//! one. All pages share the size of the scan, which the first page states. Rows are stored from the bottom up.
//!
//! The fields have no public description; they are known from files and from the readers of several authors.

use super::{Directory, Tag, Units};
use crate::{Result, per_metre};

const VERSION: Tag = Tag(0x8000, "version");
const WIDTH: Tag = Tag(0x8042, "grid width");
const HEIGHT: Tag = Tag(0x8043, "grid height");
const COLUMNS: Tag = Tag(0x8046, "grid columns");
const ROWS: Tag = Tag(0x8047, "grid rows");
const NAME: Tag = Tag(0x8050, "channel");
const IS_RETRACE: Tag = Tag(0x8051, "retrace");
const FULL_NAME: Tag = Tag(0x8052, "channel name");
const SLOTS: Tag = Tag(0x8080, "number of slots");
const DEFAULT_SLOT: Tag = Tag(0x8081, "default slot");
/// Fields of the first slot, and the distance to those of the next one.
const SLOT: [Tag; 5] = [
    Tag(0x8090, "slot"),
    Tag(0x80a2, "unit"),
    Tag(0x80a3, "scaling"),
    Tag(0x80a4, "multiplier"),
    Tag(0x80a5, "offset"),
];
const SLOT_FIELDS: u64 = 48;
/// Largest number of slots: their fields end below those of other vendors.
const MAX_SLOTS: u64 = 64;

/// Returns whether the first page of a file is that of a JPK image.
pub(super) fn is_jpk(first: &Directory) -> bool {
    [VERSION, WIDTH, HEIGHT].into_iter().all(|tag| first.length(tag) > 0)
}

/// Returns the name of a page.
pub(super) fn name(page: &Directory) -> Result<Option<String>> {
    let name = page.text(FULL_NAME)?.or(page.text(NAME)?);
    let is_retrace = page.integer(IS_RETRACE)?.unwrap_or(0) == 1;
    Ok(name.map(|name| if is_retrace { format!("{name} (retrace)") } else { name }))
}

/// Returns the straight line of the default slot of a page and the size of its points, or the unit that is not one of length.
///
/// # Errors
/// Fields beyond the end of the file, and a slot without its line.
pub(super) fn units(first: &Directory, page: &Directory) -> Result<Result<Units, String>> {
    let default = page.text(DEFAULT_SLOT)?;
    let slots = page.integer(SLOTS)?.unwrap_or(0).min(MAX_SLOTS);
    for slot in 0..slots {
        let [name, unit, scaling, multiplier, offset] = SLOT.map(|tag| Tag(tag.0 + (slot * SLOT_FIELDS) as u16, tag.1));
        if page.text(name)? != default || default.is_none() {
            continue;
        }
        let unit = page.text(unit)?.unwrap_or_default();
        let Some(per_metre) = per_metre(&unit) else { return Ok(Err(unit)) };
        if page.text(scaling)?.as_deref() != Some("LinearScaling") {
            return Err(page.wrong(scaling, page.text(scaling)?.unwrap_or_default(), "LinearScaling"));
        }
        let number = |tag: Tag| page.real(tag)?.ok_or_else(|| page.input.missing(tag.1, page.offset, "a number"));
        let line_m = Some((number(offset)? / per_metre, number(multiplier)? / per_metre));
        let pitch =
            |size, count| Ok::<_, crate::FormatError>(first.real(size)?.zip(first.real(count)?).map(|(m, n)| m / n));
        let pitch_m = pitch(WIDTH, COLUMNS)?.zip(pitch(HEIGHT, ROWS)?);
        let metadata = [("slot".to_owned(), default.unwrap_or_default()), ("vunit".to_owned(), unit)].into();
        return Ok(Ok(Units { line_m, pitch_m, metadata, is_bottom_up: true, ..Units::default() }));
    }
    Ok(Err(String::new()))
}
