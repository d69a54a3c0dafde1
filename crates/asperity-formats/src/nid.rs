//! Nanosurf NID: a text header of sections, `#!`, and the integers of all data sets in the order in which `[DataSet]` lists them.
//!
//! The integers of a data set span `Dim2Range` from `Dim2Min` on: with b bits and a sign, n is `Dim2Min` + (n + 2ᵇ⁻¹) · `Dim2Range`/2ᵇ.
//! Lines are stored from the bottom up.
//!
//! The vendor published the layout with the scripts of its program; fields of unknown meaning become metadata.

use crate::sections::{Section, section, sections};
use crate::{
    ByteOrder, ChosenMap, Description, Format, Input, MAX_TEXT_BYTES, ReadOptions, Result, Sample, Scan, Tested,
    TextLimit, per_metre, refuse_if, utf8_or_latin1,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["nid"],
    vendor: "Nanosurf",
    known_by: "`[DataSet]`",
    reads: "integers of 8 to 32 bits; no curves",
    orientation: "lines from the bottom up; row 0 is the last line",
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::Nid, |bytes| bytes.starts_with(MAGIC), read)
};

const MAGIC: &[u8] = b"[DataSet]";
/// Bytes after the header.
const HEADER_END: &[u8] = b"\n#!";
/// Largest number of groups and of data sets in a group.
const MOST: usize = 1000;

/// Data set and the place of its numbers.
struct DataSet<'s, 'a> {
    section: &'s Section<'a>,
    start: usize,
    sample: Sample,
    order: ByteOrder,
}

/// Reads a height map.
///
/// # Errors
/// A damaged header, data sets as text, no data set of heights, and data beyond the end of the file.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Nid, bytes);
    let start = &bytes[..bytes.len().min(MAX_TEXT_BYTES)];
    let end = start.windows(HEADER_END.len()).position(|window| window == HEADER_END);
    let end = end.ok_or_else(|| input.missing("the end of the header", 0, "`#!` after the header"))?;
    let text = utf8_or_latin1(&start[..end]);
    let sections = sections(Format::Nid, &text, "=", |line| line.strip_prefix('[')?.strip_suffix(']'));
    let sets = data_sets(&sections, end + HEADER_END.len())?;
    let maps = sets.iter().map(|set| {
        let text = |key| set.section.field(key).unwrap_or_default();
        let units = ["Dim0Unit", "Dim1Unit", "Dim2Unit"].map(text);
        let unit = units.into_iter().find(|unit| per_metre(unit).is_none()).unwrap_or(units[2]);
        (format!("{}: {}", text("Frame"), text("Dim2Name")), unit.to_owned())
    });
    let chosen = ChosenMap::new(Format::Nid, maps, options)?;

    let set = &sets[chosen.map];
    let field = |key| set.section.number::<f64>(key);
    let unit = |key| per_metre(set.section.field(key).unwrap_or_default()).unwrap_or(f64::NAN);
    let (low, range) = (field("Dim2Min")?, field("Dim2Range")?);
    let bits = 8 * set.sample.size() as i32;
    let zero = if set.sample.is_signed() { 2.0_f64.powi(bits - 1) } else { 0.0 };
    let step = range / 2.0_f64.powi(bits);
    let shape = set.section.shape("Lines", "Points")?;
    let in_metre = |n| (low + (n + zero) * step) / chosen.per_metre;
    let input = input.with_order(set.order);
    let heights_m = input.heights_upwards(chosen.name(), set.start, shape, set.sample, in_metre)?;
    let pitch = |range, count, unit_of| Ok::<_, crate::FormatError>(field(range)? / count as f64 / unit(unit_of));
    let pitch_m = Some((pitch("Dim0Range", shape.1, "Dim0Unit")?, pitch("Dim1Range", shape.0, "Dim1Unit")?));
    let height_unit = set.section.field("Dim2Unit").map(str::to_owned);
    let mut scan = Scan { height_unit, ..Scan::new(heights_m, pitch_m) };
    let mut room = TextLimit::default();
    section(&sections, "DataSet-Info")
        .into_iter()
        .chain([set.section])
        .for_each(|part| part.add_to(&mut scan, &mut room));
    Ok(chosen.add_to(scan))
}

/// Returns all data sets of a file whose numbers start at `start`.
fn data_sets<'s, 'a>(sections: &'s [Section<'a>], mut start: usize) -> Result<Vec<DataSet<'s, 'a>>> {
    let list = section(sections, "DataSet")?;
    let groups: usize = list.number("GroupCount")?;
    let mut sets = Vec::new();
    for group in 0..groups.min(MOST) {
        let count: usize = list.number(&format!("Gr{group}-Count"))?;
        for channel in 0..count.min(MOST) {
            // Channels that were not recorded have a number, but no entry.
            let Some(name) = list.field(&format!("Gr{group}-Ch{channel}")) else { continue };
            let section = section(sections, name)?;
            refuse_if!(section.text("SaveMode")? != "Binary", section.wrong("SaveMode", "Binary"));
            let is_signed = section.field("SaveSign") == Some("Signed");
            let bits = section.number::<usize>("SaveBits")? as u64;
            let sample = Sample::integer(bits, is_signed).filter(|_| bits <= 32);
            let sample = sample.ok_or_else(|| section.wrong("SaveBits", "8, 16 or 32"))?;
            let order = if section.field("SaveOrder") == Some("Intel") { ByteOrder::Little } else { ByteOrder::Big };
            let (rows, columns): (usize, usize) = (section.number("Lines")?, section.number("Points")?);
            sets.push(DataSet { section, start, sample, order });
            start = start.saturating_add(rows.saturating_mul(columns).saturating_mul(sample.size()));
        }
    }
    Ok(sets)
}
