//! Zygo DATX, written by Mx: an HDF5 file with one dataset per map and a table of links between them.
//!
//! Maps are the datasets `/Data/{kind}/{identifier}`. The kinds are Surface and, depending on the measurement, Bottom Surface,
//! Thickness, Intensity, Quality and others. Heights are the maps in a unit of length, and those whose `Z Converter` has the
//! category `HeightCat`. `/MetaData` is a table of links (source, link, destination); the chain Root, Measurement, Surface,
//! Path leads to the measured map.
//!
//! A stored number n is a height in the `Unit` of the dataset. In `Fringes` it is the height n·W·S·O in metre, with the
//! wavelength W, the interferometric scale factor S and the obliquity factor O, which are attributes of the dataset and
//! the parameters 1 to 3 of its `Z Converter`. Readers that ignore unit and factors are wrong by the wavelength.
//!
//! The shape of a dataset is (height, width) of the camera window, row 0 at the top. Parameter 1 of the `X Converter` is
//! the distance between columns in metre, parameter 1 of the `Y Converter` the distance between rows. (Some readers take
//! the first index for x, which shows on maps that are not square. Others reverse the rows to let y point upwards.)
//!
//! Points that were not measured hold the attribute `No Data`, which is the largest number of its type or near it.
//! Numbers beyond it, of either sign, are not heights either.

use std::collections::{BTreeMap, HashSet};

use crate::hdf5::{Attribute, Dataset, File, Object, Value, shown_name};
use crate::{Description, Format, FormatError, Input, ReadOptions, Result, Scan, per_metre, unique};

pub(crate) const CODEC: Description = Description {
    extensions: &["datx"],
    vendor: "Zygo",
    known_by: "HDF5 with the groups `MetaData` or `Data`",
    reads: "heights in fringes or a length, integers and floats; HDF5 superblocks 0 to 3, old and new groups, \
            compact and dense attributes, data compact, contiguous or chunked under a version 1 B-tree, with deflate, \
            shuffle, Fletcher-32",
    missing_points: "`No Data`, NaN",
    orientation: "the first index is the row, from the top",
    ..Description::new(Format::Datx, detect, read)
};

/// Names in the root of a DATX file.
const TABLE: &str = "MetaData";
const DATA: &str = "Data";
/// Kind of the measured map if the table does not name it.
const MAIN_KIND: &str = "Surface";
/// Unit that needs the wavelength.
const FRINGES: &str = "Fringes";
/// Factors of a height in fringes: wavelength in metre, and two numbers.
const FACTORS: [&str; 3] = ["Wavelength", "Interferometric Scale Factor", "Obliquity Factor"];
/// Maximum number of datasets.
const MAX_MAPS: usize = 4096;
/// Maximum number of entries of metadata.
const MAX_METADATA: usize = 4096;
/// Relative difference above which two values of one quantity contradict each other.
const TOLERANCE: f64 = 1e-6;

/// Returns whether an HDF5 file is a DATX file by the names in its root. A file whose root cannot be read counts as a
/// damaged DATX file.
fn detect(bytes: &[u8]) -> bool {
    let has_names = |file: File| {
        let names = file.names()?;
        Ok::<_, FormatError>(names.iter().any(|&name| name == TABLE.as_bytes() || name == DATA.as_bytes()))
    };
    File::is_one(bytes) && File::open(Format::Datx, bytes).and_then(has_names).unwrap_or(true)
}

/// Attributes of a dataset that define its numbers.
#[derive(Default)]
struct HeightAttributes {
    unit: Option<String>,
    no_data: Option<f64>,
    /// Values of the attributes in [`FACTORS`].
    factors: [Option<f64>; 3],
    x: Option<Converter>,
    y: Option<Converter>,
    z: Option<Converter>,
}

/// Conversion of numbers or positions to lengths.
struct Converter {
    category: String,
    unit: String,
    parameters: Vec<f64>,
}

fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let input = Input::new(Format::Datx, bytes);
    let file = File::open(Format::Datx, bytes)?;
    let (names, places) = maps(&file, &input)?;
    let chosen = options.choose(Format::Datx, &names)?;
    let at = places[chosen];
    let missing = |field: &str| input.missing(field, at, "a dataset of numbers in rows and columns");
    let object = file.object(at)?;
    let dataset = file.dataset(&object)?.ok_or_else(|| missing("the map"))?;
    let attributes = attributes(&file, &object)?;
    let &[ny, nx] = dataset.shape.as_slice() else { return Err(missing("the map")) };
    let shape = input.shape(("rows", at, ny), ("columns", at, nx))?;

    let mut warnings = Vec::new();
    let mut heights = file.numbers(&dataset)?.ok_or_else(|| missing("the numbers"))?;
    let to_metre = attributes.to_metre(&input, at, &mut warnings)?;
    let no_data = attributes.no_data.unwrap_or(f64::NAN);
    for z in &mut heights {
        let is_void = *z == no_data || no_data > 0.0 && z.abs() >= no_data;
        *z = if is_void { f64::NAN } else { to_metre(*z) };
    }
    let heights_m = input.matrix("the map", at, shape, heights)?;
    let mut metadata = BTreeMap::new();
    describe(&file, &object, &mut metadata);
    let lateral_m = attributes_group(&file, &mut metadata);
    let pitch_m = attributes.pitch_m(lateral_m, &mut warnings);
    let height_unit = attributes.unit().and_then(length_unit).and_then(crate::unit::name).map(str::to_owned);
    let scan = Scan { metadata, warnings, height_unit, ..Scan::new(heights_m, pitch_m) };
    Ok(scan.with_channels(names, chosen))
}

/// Returns the names and places of the datasets of heights, the measurement first.
///
/// # Errors
/// The error of the first dataset if none can be read; a file without heights.
fn maps(file: &File, input: &Input) -> Result<(Vec<String>, Vec<usize>)> {
    let main = file.optional(|| main(file)).flatten();
    // A dataset with two links counts once, under its first name.
    let (mut objects, mut known) = (Vec::new(), HashSet::new());
    if let Some(data) = file.find(DATA)? {
        for kind in file.links(&data)? {
            if !known.insert(kind.address) {
                continue;
            }
            let name = shown_name(kind.name);
            let members = file.object(kind.address).and_then(|object| file.links(&object)).unwrap_or_default();
            let addresses = members.iter().map(|member| member.address).filter(|&address| known.insert(address));
            objects.extend(addresses.take(MAX_MAPS - objects.len()).map(|address| (name.clone(), address)));
            if objects.len() == MAX_MAPS {
                break;
            }
        }
    }
    if let Some(main) = main.filter(|main| !known.contains(main)) {
        objects.push((MAIN_KIND.into(), main));
    }
    // Stable order: the main map, then the surfaces, then the rest as in the file.
    objects.sort_by_key(|(kind, at)| (Some(*at) != main, kind != MAIN_KIND));
    let (mut kinds, mut places, mut first_error) = (Vec::new(), Vec::new(), None);
    for (kind, at) in objects {
        match file.object(at).and_then(|object| is_height(file, &object)) {
            Ok(true) => {
                kinds.push(kind);
                places.push(at);
            }
            Ok(false) => (),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    match (places.is_empty(), first_error) {
        (false, _) => Ok((unique(kinds), places)),
        (true, Some(error)) => Err(error),
        (true, None) => Err(input.unsupported("the file holds no map of heights", "a surface under /Data")),
    }
}

/// Returns the dataset of the measured surface from the table of links.
fn main(file: &File) -> Result<Option<usize>> {
    let Some(dataset) = file.find(TABLE)?.map(|table| file.dataset(&table)).transpose()?.flatten() else {
        return Ok(None);
    };
    let bytes = file.bytes(&dataset)?;
    let mut node = b"Root".to_vec();
    for link in ["Measurement", MAIN_KIND, "Path"] {
        let next = file.find_element(&dataset, &bytes, |row| {
            let is_match = row.has_text("Link", link.as_bytes())? && row.has_text("Source", &node)?;
            if is_match { Ok(row.member_text("Destination")?.map(<[u8]>::to_vec)) } else { Ok(None) }
        })?;
        let Some(next) = next else { return Ok(None) };
        node = next;
    }
    Ok(file.find(&String::from_utf8_lossy(&node))?.map(|object| object.at))
}

/// Returns whether an object is a map of heights.
fn is_height(file: &File, object: &Object) -> Result<bool> {
    let is_map = |dataset: Dataset| dataset.shape.len() == 2 && dataset.sample().is_some();
    if !file.dataset(object)?.is_some_and(is_map) {
        return Ok(false);
    }
    let attributes = attributes(file, object)?;
    let is_named_height = attributes.z.as_ref().is_some_and(|z| z.category == "HeightCat");
    Ok(is_named_height || attributes.unit().is_some_and(|unit| unit == FRINGES || length_unit(unit).is_some()))
}

fn attributes(file: &File, object: &Object) -> Result<HeightAttributes> {
    let mut attributes = HeightAttributes::default();
    for attribute in file.attributes(object)? {
        let number = || file.value(&attribute, |value| value.number());
        let converter = || file.value(&attribute, converter);
        match attribute.name {
            b"Unit" => attributes.unit = file.value(&attribute, |value| value.text())?,
            b"No Data" => attributes.no_data = number()?,
            b"X Converter" => attributes.x = converter()?,
            b"Y Converter" => attributes.y = converter()?,
            b"Z Converter" => attributes.z = converter()?,
            name => {
                if let Some(place) = FACTORS.iter().position(|factor| factor.as_bytes() == name) {
                    attributes.factors[place] = number()?;
                }
            }
        }
    }
    Ok(attributes)
}

fn converter(value: Value) -> Result<Option<Converter>> {
    let text = |name| value.member(name).map_or(Ok(None), |value| value.text());
    let parameters = value.member("Parameters").map_or(Ok(Vec::new()), |value| value.numbers(4))?;
    let (category, unit) = (text("Category")?.unwrap_or_default(), text("BaseUnit")?.unwrap_or_default());
    Ok(Some(Converter { category, unit, parameters }))
}

/// Returns the number of units per metre for a unit as spelt by Mx: NanoMeters, MicroMeters, ….
fn length_unit(unit: &str) -> Option<f64> {
    per_metre(unit).or_else(|| per_metre(&unit.to_lowercase()))
}

impl HeightAttributes {
    /// Returns the unit of the numbers from the dataset, or else from its converter.
    fn unit(&self) -> Option<&str> {
        let base = self.z.as_ref().map(|z| z.unit.as_str()).filter(|unit| !unit.is_empty());
        self.unit.as_deref().filter(|unit| !unit.is_empty()).or(base)
    }

    /// Returns the conversion of a stored number to a height in metre.
    fn to_metre(&self, input: &Input, at: usize, warnings: &mut Vec<String>) -> Result<Box<dyn Fn(f64) -> f64>> {
        let unit = self.unit().ok_or_else(|| input.missing("Unit", at, "Fringes or a unit of length"))?;
        if let Some(z) = self.z.as_ref().filter(|z| !z.unit.is_empty() && z.unit != unit) {
            warnings.push(format!(
                "the unit of the heights is {unit}, but their converter states {}; {unit} was used",
                z.unit
            ));
        }
        if unit != FRINGES {
            let per_metre =
                length_unit(unit).ok_or_else(|| input.wrong("Unit", at, unit, "Fringes or a unit of length"))?;
            return Ok(Box::new(move |z| z / per_metre));
        }
        let mut height_m = 1.0;
        for (place, (name, attribute)) in FACTORS.into_iter().zip(self.factors).enumerate() {
            let parameter = self.z.as_ref().and_then(|z| z.parameters.get(place + 1).copied());
            let factor = attribute.or(parameter);
            let factor = factor.ok_or_else(|| input.missing(name, at, "a number that turns fringes into heights"))?;
            if !(factor.is_finite() && factor != 0.0) {
                return Err(input.wrong(name, at, factor, "a finite number other than 0"));
            }
            if let Some(parameter) = parameter.filter(|parameter| (parameter / factor - 1.0).abs() > TOLERANCE) {
                warnings
                    .push(format!("the {name} is {factor}, but the Z Converter states {parameter}; {factor} was used"));
            }
            height_m *= factor;
        }
        Ok(Box::new(move |z| z * height_m))
    }

    /// Returns the distance between points from the converters, or else from the lateral resolution of the
    /// measurement.
    fn pitch_m(&self, lateral_m: Option<f64>, warnings: &mut Vec<String>) -> Option<(f64, f64)> {
        let is_length = |length: &f64| length.is_finite() && *length > 0.0;
        let along = |converter: &Option<Converter>| {
            let pixels = converter.as_ref().filter(|one| one.category == "LateralCat" && one.unit == "Pixels");
            pixels.and_then(|one| one.parameters.get(1).copied()).filter(is_length).or(lateral_m.filter(is_length))
        };
        let pitch_m = along(&self.x).zip(along(&self.y));
        if pitch_m.is_none() {
            warnings.push("the file states no lateral resolution: the instrument was not calibrated".into());
        }
        pitch_m
    }
}

/// Adds the attributes of the groups under `/Attributes`. Returns the lateral resolution in metre.
fn attributes_group(file: &File, metadata: &mut BTreeMap<String, String>) -> Option<f64> {
    let group = file.find("Attributes").ok().flatten()?;
    let mut lateral_m = None;
    for link in file.links(&group).unwrap_or_default() {
        let Ok(object) = file.object(link.address) else { continue };
        let found = describe(file, &object, metadata);
        lateral_m = lateral_m.or(found);
    }
    lateral_m
}

/// Adds the readable attributes of an object. Returns the lateral resolution among them.
fn describe(file: &File, object: &Object, metadata: &mut BTreeMap<String, String>) -> Option<f64> {
    let mut lateral_m = None;
    for attribute in file.attributes(object).unwrap_or_default() {
        let shown = |attribute: &Attribute| file.value(attribute, |value| value.describe()).ok().flatten();
        if metadata.len() < MAX_METADATA
            && let Some(text) = shown(&attribute).filter(|text| !text.is_empty())
        {
            metadata.entry(shown_name(attribute.name)).or_insert(text);
        }
        if attribute.name.ends_with(b"Data Context.Lateral Resolution:Value") {
            lateral_m = lateral_m.or(file.value(&attribute, |value| value.number()).ok().flatten());
        }
    }
    lateral_m
}
