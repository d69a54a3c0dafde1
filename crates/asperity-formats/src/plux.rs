//! Sensofar PLUX: a zip archive of `index.xml` and a file of heights per layer.
//!
//! Heights are little-endian `f32` in µm in rows of x; `GENERAL/IMAGE_SIZE_X` × `IMAGE_SIZE_Y` is the shape of all
//! layers, and NaN marks missing points. The links `LAYER_n/FILENAME_Z` name their files. Other files of the archive
//! hold colour images, thumbnails and settings.
//!
//! Despite their names, `GENERAL/FOV_X` and `FOV_Y` are not the field of view (some readers take them as such, in mm)
//! but the distance between points in µm: a file of an S neox with a 50× objective states 0.138 for both axes with
//! 2448 × 2048 points, which are 338 µm × 283 µm. The field of view is n times this distance.

use std::collections::BTreeMap;

use crate::plu::LOST;
use crate::scan::matrix;
use crate::x3p::ZIP_MAGIC;
use crate::{Archive, Description, Document, Format, FormatError, ReadOptions, Result, Sample, Scan, Shape, warn_if};

pub(crate) const CODEC: Description = Description {
    extensions: &["plux"],
    vendor: "Sensofar",
    known_by: "zip archive with index.xml and a file of the name *.raw, or an index.xml with IMAGE_SIZE_X",
    reads: "float32; layers",
    missing_points: "NaN, ±inf, 1000001",
    orientation: "the first stored row is row 0, as in the colour images beside it",
    ..Description::new(Format::Plux, detect, read)
};

/// File of the archive that describes all others.
const INDEX: &str = "index.xml";
/// Extension of files of heights and of images.
const RAW: &str = ".raw";
/// Largest `index.xml` in bytes. Files of instruments have about ten thousand.
const MAX_INDEX_BYTES: u64 = 1 << 22;
/// Number of bytes of `index.xml` that are searched for the size of a map, and the field of this size.
const START_BYTES: usize = 1 << 14;
const SIZE: &[u8] = b"<IMAGE_SIZE_X>";
/// Path that matches no element, because the format has no lists of numbers in XML.
const NO_LIST: &str = "/";
/// Number of micrometres per metre.
const PER_METRE: f64 = 1e6;
/// Relative difference below which the ratio of the sides of a pixel equals the ratio of the numbers of points.
const RATIO_TOLERANCE: f64 = 1e-3;

/// Elements of `index.xml` below its root: distances between points along x and y, and the start of items.
const PITCH_X: &str = "GENERAL/FOV_X";
const PITCH_Y: &str = "GENERAL/FOV_Y";
const INFO: &str = "INFO/ITEM_";

/// Returns whether a zip archive has an `index.xml`, which is a common name, with a file of heights or with the size
/// of a map.
fn detect(bytes: &[u8]) -> bool {
    let states_size = |archive: &mut Archive| {
        let start = archive.read_start(INDEX, START_BYTES).unwrap_or_default();
        start.windows(SIZE.len()).any(|window| window == SIZE)
    };
    bytes.starts_with(ZIP_MAGIC)
        && Archive::open(Format::Plux, bytes).is_ok_and(|mut archive| {
            archive.enter_folder_of(INDEX).is_ok()
                && (archive.names().iter().any(|name| name.ends_with(RAW)) || states_size(&mut archive))
        })
}

/// Reads a layer.
///
/// # Errors
/// Damaged archives and descriptions, layers without heights, and data that do not fill the stated dimensions.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let mut archive = Archive::open(Format::Plux, bytes)?;
    archive.enter_folder_of(INDEX)?;
    let index = archive.read_whole(INDEX, MAX_INDEX_BYTES)?;
    let document = Document::parse(Format::Plux, INDEX, &index, NO_LIST)?;
    let layers = layers(&document);
    if layers.is_empty() {
        let found = format!("no layer of {INDEX} has heights (LAYER_n/FILENAME_Z)");
        return Err(FormatError::unsupported(Format::Plux, found, "a layer with heights"));
    }
    let channels: Vec<String> = layers.iter().map(|(number, _)| format!("LAYER_{number}")).collect();
    let channel = options.choose(Format::Plux, &channels)?;
    let link = layers[channel].1;

    let (ny, nx) = document.shape("GENERAL/IMAGE_SIZE_Y", "GENERAL/IMAGE_SIZE_X")?;
    let mut warnings = Vec::new();
    let (mut heights, unpacked) = archive.read_numbers(link, Sample::F32, 0, ny * nx, ny as u64 * nx as u64)?;
    warn_if!(warnings, unpacked.md5.is_none(), "{link} is longer than the stated dimensions");
    for z in &mut heights {
        *z = if *z == LOST { f64::NAN } else { *z / PER_METRE };
    }
    let pitch_m = pitch(&document, (ny, nx), &mut warnings)?;
    let heights_m = matrix(Format::Plux, link, document.at(0), (ny, nx), heights)?;
    let scan = Scan { metadata: metadata(&document), warnings, ..Scan::new(heights_m, pitch_m) };
    Ok(scan.with_channels(channels, channel))
}

/// Returns the numbers of the layers with heights, and their links.
fn layers(document: &Document) -> Vec<(u64, &str)> {
    let mut layers: Vec<(u64, &str)> = document
        .values
        .iter()
        .filter_map(|(path, value)| {
            let (number, field) = path.strip_prefix("LAYER_")?.split_once('/')?;
            Some((number.parse().ok()?, value.text.as_str())).filter(|_| field == "FILENAME_Z")
        })
        .collect();
    layers.sort_unstable();
    layers
}

/// Returns the distance between points in metre.
fn pitch(document: &Document, (ny, nx): Shape, warnings: &mut Vec<String>) -> Result<Option<(f64, f64)>> {
    let Some((x, y)) = document.number(PITCH_X)?.zip(document.number(PITCH_Y)?) else {
        warnings.push(format!("{INDEX} states no {PITCH_X} or no {PITCH_Y}; no pixel size was read"));
        return Ok(None);
    };
    let stretch = x * ny as f64 / (y * nx as f64);
    if nx != ny && (stretch - 1.0).abs() < RATIO_TOLERANCE {
        warnings.push(format!(
            "{} and {} are as the numbers of points and may be sides of the field; they were read as those of a pixel",
            PITCH_X, PITCH_Y
        ));
    }
    Ok(Some((x / PER_METRE, y / PER_METRE)))
}

/// Returns all texts by their paths, and the items of `INFO` by their own names.
fn metadata(document: &Document) -> BTreeMap<String, String> {
    let mut metadata = BTreeMap::new();
    for (path, value) in &document.values {
        let item = path.strip_prefix(INFO).and_then(|item| item.split_once('/'));
        match item {
            Some((number, "NAME")) => {
                let text = document.text(&format!("{}{number}/VALUE", INFO)).unwrap_or_default();
                metadata.insert(value.text.clone(), text.to_owned());
            }
            Some((_, "VALUE")) => (),
            _ => {
                metadata.insert(path.clone(), value.text.clone());
            }
        }
    }
    metadata
}
