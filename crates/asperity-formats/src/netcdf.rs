//! NetCDF: classic (versions 1, 2 and 5) and netCDF-4, as written by SurfaceTopography and other programs.
//!
//! Maps are variables of two dimensions whose `unit` (`units`, `length_unit`) is a length; `heights` is the main map.
//! Dimensions of one element before the last two are ignored. A dimension x or y determines the orientation:
//! SurfaceTopography stores `heights(x, y)`, other programs z(y, x). The first y is the top row, as in
//! SurfaceTopography.
//!
//! A variable with the name of a dimension holds the positions along it; their distance is the pitch.
//! SurfaceTopography also states the `length` of the side, n·d, and writes the positions 0, d, …, (n − 1)·d. If it
//! states no unit for the heights, they are in the unit of the positions.
//!
//! Numbers are unpacked as n·`scale_factor` + `add_offset`. Missing are numbers equal to `_FillValue` or
//! `missing_value`, or to the fill value of their type if `_FillValue` is absent, and points with a 1 in the variable
//! `mask`.
//!
//! `heights` of one dimension are a line scan, with their positions in `x`.

mod classic;
mod contents;
mod enhanced;

use std::collections::BTreeMap;

use self::contents::{Contents, Dimension, HEIGHTS, MAX_NUMBERS, Value, Variable, transposed};
use crate::foreign::TO_MATRIX;
use crate::{
    Description, Format, FormatError, Input, ReadOptions, Result, Sample, Scan, Shape, Tested, hdf5, large, per_metre,
    refuse_if, warn_if,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["nc", "nc4", "cdf"],
    vendor: "Unidata",
    known_by: "`CDF\\x01`, `CDF\\x02`, `CDF\\x05`; HDF5 without the groups of DATX",
    reads: "classic, 64-bit offset, 64-bit data, netCDF-4; variables of two dimensions in a unit of length; line scans `heights`",
    missing_points: "`_FillValue`, `missing_value`, the fill value of the type, a variable `mask`, NaN",
    orientation: "the first y is the top row; (x, y) is turned to (y, x)",
    // HDF5 files that are not DATX are tried as netCDF-4: the registry tries DATX first.
    tested: Tested::OtherPrograms,
    ..Description::new(Format::NetCdf, |bytes| classic::version(bytes).is_some() || hdf5::File::is_one(bytes), read)
};

/// Variable of the missing points in files of SurfaceTopography.
const MASK: &str = "mask";
/// Group of the first measurement in the root of HDF5 files of 4D Technology.
const MEASUREMENT_OF_4D: &[u8] = b"measurement0";
/// Tolerance of positions on an even grid, as a fraction of the pitch.
const UNEVEN: f64 = 1e-3;

/// File of either kind.
enum Source<'a> {
    Classic(Input<'a>),
    Enhanced(hdf5::File<'a>),
}

impl Source<'_> {
    /// Returns the error for HDF5 files of other programs, which have no netCDF dimensions.
    fn foreign(&self, contents: &Contents) -> Option<FormatError> {
        let Self::Enhanced(file) = self else { return None };
        if !contents.dimensions.is_empty() {
            return None;
        }
        let names = file.names().unwrap_or_default();
        let name = match names.contains(&MEASUREMENT_OF_4D) {
            true => "a 4D Technology HDF5 file",
            false => "an HDF5 file that is neither DATX nor netCDF",
        };
        Some(FormatError::NotRead { name, advice: TO_MATRIX })
    }

    fn numbers(&self, variable: &Variable) -> Result<Vec<f64>> {
        match self {
            Self::Classic(input) => classic::numbers(input, variable),
            Self::Enhanced(file) => enhanced::numbers(file, variable),
        }
    }

    /// Returns the numbers of a map, in column order if `is_turned`.
    fn map(&self, variable: &Variable, shape: Shape, is_turned: bool) -> Result<Vec<f64>> {
        match self {
            Self::Classic(input) if is_turned => classic::columns(input, variable, shape),
            _ if is_turned => self.numbers(variable).map(|numbers| transposed(numbers, shape)),
            _ => self.numbers(variable),
        }
    }
}

fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::NetCdf, bytes);
    let (source, mut contents) = if classic::version(bytes).is_some() {
        let (input, contents) = classic::read(bytes)?;
        (Source::Classic(input), contents)
    } else {
        let file = hdf5::File::open(Format::NetCdf, bytes)?;
        let contents = enhanced::read(&file)?;
        (Source::Enhanced(file), contents)
    };
    let first_error = contents.first_error.take();
    let mut maps: Vec<&Variable> = contents.variables.iter().filter(|variable| variable.is_height()).collect();
    maps.sort_by_key(|variable| variable.name != HEIGHTS);
    let names: Vec<String> = maps.iter().map(|variable| variable.name.clone()).collect();
    refuse_if!(maps.is_empty(), source.foreign(&contents).or(first_error).unwrap_or_else(|| no_map(&input, &contents)));
    let chosen = options.choose(Format::NetCdf, &names)?;
    let map = maps[chosen];
    let Some((rows, columns)) = map.map() else { return Err(no_map(&input, &contents)) };
    let (rows, columns) = input.shape(("rows", map.at, rows), ("columns", map.at, columns))?;

    let mut warnings = Vec::new();
    let [slow, fast] = [2, 1].map(|back| Axis::new(&contents, map, back));
    // Heights without a unit are in the unit of the positions.
    let unit = map.unit().or_else(|| [&slow, &fast].iter().find_map(|axis| axis.positions.and_then(Variable::unit)));
    warn_if!(warnings, unit.is_none(), "the file states no unit; heights and positions count as metre");
    let is_line = map.shape.len() == 1;
    let is_turned = !is_line && (slow.is_named("x") || fast.is_named("y"));
    let numbers = |variable: &Variable| source.map(variable, (rows, columns), is_turned);
    let heights = heights(numbers, &contents, map, unit.unwrap_or("m"), &input)?;
    refuse_if!(is_line && options.pitch_m.is_none() && !fast.is_even(&source)?, uneven(&input));
    let mut pitch_m = |axis: &Axis| axis.pitch_m(&source, unit.is_none().then_some("m"), &mut warnings);
    let along_slow = pitch_m(&slow)?;
    let along_fast = if is_line { along_slow } else { pitch_m(&fast)? };
    let read = [slow.positions, fast.positions, Some(map)].into_iter().flatten().map(|one| one.name.clone());
    let read: Vec<String> = read.collect();
    let (shape, pitch_m) = match is_turned {
        true => ((columns, rows), along_slow.zip(along_fast)),
        false => ((rows, columns), along_fast.zip(along_slow)),
    };
    let heights_m = input.matrix(&map.name, map.at, shape, heights)?;
    let height_unit = unit.map(str::to_owned);
    let metadata = metadata(contents, &read);
    Ok(Scan { metadata, warnings, height_unit, ..Scan::new(heights_m, pitch_m) }.with_channels(names, chosen))
}

/// Returns the heights in metre; NaN for missing ones.
fn heights(
    numbers: impl Fn(&Variable) -> Result<Vec<f64>>,
    contents: &Contents,
    map: &Variable,
    unit: &str,
    input: &Input,
) -> Result<Vec<f64>> {
    let per_metre = per_metre(unit).ok_or_else(|| input.wrong("unit", map.at, unit, "a unit of length"))?;
    let mut heights = numbers(map)?;
    unpack(map, per_metre, &mut heights);
    let mask = contents.variables.iter().find(|variable| variable.name == MASK && variable.sample.is_some());
    if let Some(mask) = mask.filter(|mask| map.name == HEIGHTS && mask.shape == map.shape) {
        large::hide(&mut heights, numbers(mask)?.into_iter().map(|masked| masked != 0.0));
    }
    Ok(heights)
}

/// Returns the error for a file without a map of heights.
fn no_map(input: &Input, contents: &Contents) -> FormatError {
    let wanted = "a variable of two dimensions in a unit of length, or named `heights`";
    let units: Vec<String> = contents
        .variables
        .iter()
        .filter(|variable| variable.map().is_some())
        .take(MAX_NUMBERS)
        .map(|variable| format!("`{}` ({})", crate::error::shown(&variable.name), variable.unit().unwrap_or("no unit")))
        .collect();
    let found = if units.is_empty() { "no map".into() } else { units.join(", ") };
    input.unsupported(format!("the file holds {found}"), wanted)
}

/// Returns the error for a line scan between whose points the distance varies.
fn uneven(input: &Input) -> FormatError {
    input.unsupported("the file holds a line scan whose positions are not evenly spaced", "positions in equal steps")
}

/// Converts stored numbers to metre; NaN for missing ones.
fn unpack(variable: &Variable, per_metre: f64, numbers: &mut [f64]) {
    let (fill, default) = (variable.numbers("_FillValue"), variable.sample.and_then(default_fill));
    let mut missing = [fill, variable.numbers("missing_value")].concat();
    if fill.is_empty() {
        missing.extend(default);
    }
    // Numbers in single precision are compared with the attribute rounded to single precision.
    if variable.sample == Some(Sample::F32) {
        for number in &mut missing {
            *number = f64::from(*number as f32);
        }
    }
    let first = |name, default| variable.numbers(name).first().copied().unwrap_or(default);
    let (scale, offset) = (first("scale_factor", 1.0), first("add_offset", 0.0));
    let in_metre = |z: f64| (z * scale + offset) / per_metre;
    match missing[..] {
        // A single mark is the usual case and needs no search.
        [missing] => large::map(numbers, |z| if z == missing { f64::NAN } else { in_metre(z) }),
        _ => large::map(numbers, |z| if missing.contains(&z) { f64::NAN } else { in_metre(z) }),
    }
}

/// Returns the value that the netCDF library fills unwritten variables with. Bytes may hold any number.
fn default_fill(sample: Sample) -> Option<f64> {
    match sample {
        Sample::I16 => Some(-32767.0),
        Sample::U16 => Some(65535.0),
        Sample::I32 => Some(-2147483647.0),
        Sample::U32 => Some(4294967295.0),
        Sample::F32 | Sample::F64 => Some(f64::from_bits(0x479e_0000_0000_0000)),
        _ => None,
    }
}

/// One of the two dimensions of a map.
struct Axis<'c> {
    dimension: Option<&'c Dimension>,
    length: usize,
    /// Variable with the positions along the axis.
    positions: Option<&'c Variable>,
}

impl<'c> Axis<'c> {
    /// Returns the dimension `back` places before the end.
    fn new(contents: &'c Contents, map: &Variable, back: usize) -> Self {
        let place = map.shape.len().saturating_sub(back);
        let dimension = map.dimensions.get(place).copied().flatten().and_then(|place| contents.dimensions.get(place));
        // Line scans with varying distances have the dimension `n` and the positions `x`.
        let is_line = |variable: &Variable| map.shape.len() == 1 && variable.name == "x";
        let is_match = |variable: &&Variable| {
            let is_named = dimension.is_some_and(|(name, _)| *name == variable.name) || is_line(variable);
            variable.shape.len() == 1 && is_named
        };
        let positions = contents.variables.iter().find(is_match).filter(|variable| variable.sample.is_some());
        Self { dimension, length: map.shape.get(place).copied().unwrap_or_default(), positions }
    }

    fn is_named(&self, name: &str) -> bool {
        self.dimension.is_some_and(|(own, _)| own.eq_ignore_ascii_case(name))
    }

    /// Returns whether the positions step evenly, if there are positions.
    fn is_even(&self, source: &Source) -> Result<bool> {
        let variable = self.positions.filter(|variable| variable.shape == [self.length]);
        let places = variable.map(|variable| source.numbers(variable)).transpose()?.unwrap_or_default();
        let (Some(first), Some(last)) = (places.first(), places.last()) else { return Ok(true) };
        let pitch = (last - first) / (places.len() - 1) as f64;
        Ok(places.windows(2).all(|pair| ((pair[1] - pair[0]) / pitch - 1.0).abs() <= UNEVEN))
    }

    /// Returns the distance between positions, or else the length of the side divided by the number of points.
    fn pitch_m(&self, source: &Source, default_unit: Option<&str>, warnings: &mut Vec<String>) -> Result<Option<f64>> {
        let Some(variable) = self.positions else { return Ok(None) };
        let name = &variable.name;
        let unit = variable.unit().or(default_unit).unwrap_or_default();
        let Some(per_metre) = per_metre(unit) else {
            warnings.push(format!("the unit of {name} is `{unit}`, which is not a length; no pixel size was read"));
            return Ok(None);
        };
        let stated = variable.numbers("length").first().map(|length| length / self.length as f64);
        let places = if variable.shape == [self.length] { source.numbers(variable)? } else { Vec::new() };
        let measured = match (places.first(), places.last()) {
            (Some(first), Some(last)) => (last - first).abs() / (places.len() - 1) as f64,
            _ => f64::NAN,
        };
        let is_length = |pitch: &f64| pitch.is_finite() && *pitch > 0.0;
        let Some(pitch) = Some(measured).filter(is_length).or(stated).filter(is_length) else { return Ok(None) };
        let is_off = |step: f64| (step.abs() / pitch - 1.0).abs() > UNEVEN;
        if places.windows(2).any(|pair| is_off(pair[1] - pair[0])) {
            warnings.push(format!("the positions in {name} are not evenly spaced; their mean distance was used"));
        }
        if let Some(stated) = stated.filter(|&stated| is_off(stated)) {
            warnings.push(format!(
                "the length of {name} gives pixels of {stated} {unit}, its positions {pitch} {unit}; the positions were used"
            ));
        }
        Ok(Some(pitch / per_metre))
    }
}

/// Returns the attributes of the file under their names, and the attributes of the variables read as
/// `variable:attribute`.
fn metadata(contents: Contents, read: &[String]) -> BTreeMap<String, String> {
    let show = |value: Value| match value {
        Value::Text(text) => text,
        Value::Numbers(numbers) => numbers.into_iter().map(hdf5::shown_number).collect::<Vec<_>>().join(" "),
    };
    let mut metadata: BTreeMap<String, String> =
        contents.attributes.into_iter().map(|(name, value)| (name, show(value))).collect();
    for variable in contents.variables.into_iter().filter(|variable| read.contains(&variable.name)) {
        let own = |(name, value)| (format!("{}:{name}", variable.name), show(value));
        metadata.extend(variable.attributes.into_iter().map(own));
    }
    metadata
}
