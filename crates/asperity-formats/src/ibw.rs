//! Igor binary wave (IBW) version 5, as Asylum Research writes it: a matrix, or layers of them with a label each.
//!
//! A header of 64 bytes holds the sizes of the parts after the numbers: formula, note, units and labels. A header of 320 bytes holds the
//! type, the dimensions, and the distance of points along each. The numbers are stored along x first, then along y from the bottom up,
//! then layer by layer. Layers of Asylum Research are in SI units, which their labels imply: `HeightTrace` is in metre, `PhaseTrace` is not.
//!
//! Layout: WaveMetrics, *Igor Pro Technical Note PTN003: Igor Binary Format*.

use crate::sections::sections;
use crate::{
    ByteOrder, ChosenMap, Description, Format, FormatError, Input, ReadOptions, Result, Sample, Scan, Tested,
    TextLimit, latin1, per_metre, utf8_or_latin1,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["ibw"],
    vendor: "Asylum Research, WaveMetrics Igor",
    known_by: "version 5 and a check sum over 384 bytes",
    reads: "version 5; integers, float32, float64; matrices and layers",
    missing_points: "NaN",
    orientation: "y points upwards; row 0 is the last stored line",
    tested: Tested::InstrumentFiles,
    ..Description::new(Format::Ibw, |bytes| order(bytes).is_some(), read)
};

const VERSION: i16 = 5;
/// Bytes of both headers, over which the sum of all 16-bit integers is zero.
const HEADERS_BYTES: usize = 384;
/// Offsets in the file.
const SIZE_OF_WAVE: usize = 4;
const SIZE_OF_FORMULA: usize = 8;
const SIZE_OF_NOTE: usize = 12;
const SIZES_OF_UNITS: usize = 16;
const SIZES_OF_LABELS: usize = 36;
const TYPE: usize = 80;
const NAME: usize = 92;
const DIMENSIONS: usize = 132;
const STEPS: usize = 148;
const DATA_UNIT: usize = 212;
const DIMENSION_UNITS: usize = 216;
/// Bytes before the numbers that the stated size of a wave includes.
const WAVE_HEADER_BYTES: usize = 320;
const NAME_BYTES: usize = 32;
const UNIT_BYTES: usize = 4;
/// Flag of the type of unsigned integers.
const UNSIGNED: i16 = 0x40;
/// Largest number of layers.
const MAX_LAYERS: usize = 1000;
/// Starts of the labels of layers in metre.
const LENGTHS: [&str; 5] = ["Height", "ZSensor", "Amplitude", "Deflection", "Topography"];

/// Returns the byte order of a wave of version 5 whose check sum holds.
fn order(bytes: &[u8]) -> Option<ByteOrder> {
    let headers = bytes.get(..HEADERS_BYTES)?;
    let input = Input::new(Format::Ibw, headers);
    [ByteOrder::Little, ByteOrder::Big].into_iter().find(|&order| {
        let input = input.with_order(order);
        let number = |at| input.i16("", at).unwrap_or(1);
        number(0) == VERSION && (0..HEADERS_BYTES).step_by(2).fold(0, |sum: i16, at| sum.wrapping_add(number(at))) == 0
    })
}

/// Reads a layer.
///
/// # Errors
/// Complex numbers and texts, other than two or three dimensions, no layer of lengths, and data beyond the end of the file.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Ibw, bytes);
    let input =
        input.with_order(order(bytes).ok_or_else(|| input.wrong("version", 0, "another one", "5 and a check sum"))?);
    let kind = input.i16("type", TYPE)?;
    let sample = match kind & !UNSIGNED {
        0x02 => Some(Sample::F32),
        0x04 => Some(Sample::F64),
        bits @ (0x08 | 0x10 | 0x20) => Sample::integer(bits as u64, kind & UNSIGNED == 0),
        _ => None,
    };
    let sample = sample.ok_or_else(|| input.wrong("type", TYPE, kind, "real numbers (2, 4, 8, 16, 32)"))?;
    let dimension = |n: usize| {
        Ok::<_, FormatError>(("dimensions", DIMENSIONS + 4 * n, input.i32("dimensions", DIMENSIONS + 4 * n)?))
    };
    let ((.., rows), (.., layers), (.., fourth)) = (dimension(1)?, dimension(2)?, dimension(3)?);
    if rows == 0 || fourth > 1 {
        return Err(input.unsupported("the wave has not two or three dimensions", "a matrix or layers"));
    }
    let (ny, nx) = input.shape(dimension(1)?, dimension(0)?)?;
    let layers = usize::try_from(layers).unwrap_or(0).clamp(1, MAX_LAYERS);

    let parts = Parts::of(&input)?;
    if layers == 1 && input.i32("sizes of labels", SIZES_OF_LABELS + 4)? > 0 {
        return Err(input.unsupported("the columns of the wave have labels, as curves do", "a height map"));
    }
    let labels = (0..layers).map(|layer| parts.label(&input, layer)).collect::<Result<Vec<_>>>()?;
    let unit = input.latin1("data unit", DATA_UNIT, UNIT_BYTES)?;
    let wave = input.latin1("name", NAME, NAME_BYTES)?;
    let maps = labels.iter().enumerate().map(|(layer, label)| match label.as_str() {
        "" => {
            let name = if layers == 1 { wave.clone() } else { format!("{wave} {}", layer + 1) };
            (name, if unit.is_empty() { "m".into() } else { unit.clone() })
        }
        label => {
            let is_length = LENGTHS.iter().any(|start| label.starts_with(start));
            (label.to_owned(), if is_length { "m".into() } else { String::new() })
        }
    });
    let chosen = ChosenMap::new(Format::Ibw, maps, options)?;
    // Sums of sizes may exceed 32 bits.
    let start = (ny * nx).saturating_mul(sample.size()).saturating_mul(chosen.map).saturating_add(HEADERS_BYTES);
    let unit = if labels[chosen.map].is_empty() { unit } else { "m".into() };
    let heights_m = input.heights_upwards(chosen.name(), start, (ny, nx), sample, |z| z / chosen.per_metre)?;

    let mut scan = Scan { height_unit: Some(unit).filter(|unit| !unit.is_empty()), ..Scan::new(heights_m, None) };
    let step = |n: usize| {
        let unit = input.latin1("dimension unit", DIMENSION_UNITS + UNIT_BYTES * n, UNIT_BYTES)?;
        let step = input.f64("distance of points", STEPS + 8 * n)?;
        Ok::<_, FormatError>(per_metre(&unit).map(|per_metre| step.abs() / per_metre))
    };
    scan.pitch_m = step(0)?.zip(step(1)?);
    if scan.pitch_m.is_none() {
        scan.warnings.push("the dimensions of the wave are not in a unit of length; no pixel size was read".into());
    }
    let note = parts.note(&input)?.replace('\r', "\n");
    sections(Format::Ibw, &note, ":", |_| None)[0].add_to(&mut scan, &mut TextLimit::default());
    Ok(chosen.add_to(scan))
}

/// Places of the parts after the numbers.
struct Parts {
    note: usize,
    note_bytes: usize,
    /// Labels of the layers, of 32 bytes each after one for the dimension.
    labels: usize,
    labels_bytes: usize,
}

impl Parts {
    fn of(input: &Input) -> Result<Self> {
        let size = |field, at| Ok::<_, FormatError>(usize::try_from(input.i32(field, at)?).unwrap_or(0));
        let sizes = |field, at: usize, count: usize| {
            let size = |n| size(field, at + 4 * n);
            (0..count).try_fold(0_usize, |sum, n| Ok::<_, FormatError>(sum.saturating_add(size(n)?)))
        };
        let numbers = size("size of the wave", SIZE_OF_WAVE)?.saturating_sub(WAVE_HEADER_BYTES);
        let before = HEADERS_BYTES.saturating_add(numbers);
        let note = before.saturating_add(size("size of the formula", SIZE_OF_FORMULA)?);
        let note_bytes = size("size of the note", SIZE_OF_NOTE)?;
        // Units of the numbers and of four dimensions, then labels of two dimensions before those of the layers.
        let units =
            sizes("sizes of units", SIZES_OF_UNITS, 5)?.saturating_add(sizes("sizes of labels", SIZES_OF_LABELS, 2)?);
        let labels = note.saturating_add(note_bytes).saturating_add(units);
        Ok(Self { note, note_bytes, labels, labels_bytes: size("size of the labels", SIZES_OF_LABELS + 8)? })
    }

    fn note(&self, input: &Input) -> Result<String> {
        Ok(utf8_or_latin1(input.take("the note", self.note, self.note_bytes)?))
    }

    /// Returns the label of a layer; empty if it has none.
    fn label(&self, input: &Input, layer: usize) -> Result<String> {
        let place = (layer + 1) * NAME_BYTES;
        let has_label = place + NAME_BYTES <= self.labels_bytes;
        Ok(if has_label {
            latin1(input.take("labels", self.labels.saturating_add(place), NAME_BYTES)?)
        } else {
            String::new()
        })
    }
}
