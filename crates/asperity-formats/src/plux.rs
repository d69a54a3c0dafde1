//! Sensofar PLUX: a zip archive of `index.xml` and a file of heights per layer.
//!
//! Heights are little-endian `f32` in µm in rows of x, as many as `GENERAL/IMAGE_SIZE_X` × `IMAGE_SIZE_Y` state for all
//! layers, NaN where nothing was measured. The links `LAYER_n/FILENAME_Z` name their files. Other files of the archive
//! hold colour images, thumbnails and settings.
//!
//! `GENERAL/FOV_X` and `FOV_Y` are not the field of view, as their names say and some readers take them (in mm), but
//! the distance between points in µm: a file of an S neox with a 50× objective states 0.138 for both axes with
//! 2448 × 2048 points, which are 338 µm × 283 µm. The field of view is n of them.

use crate::error::Result;
use std::collections::BTreeMap;

use crate::archive::Archive;
use crate::codec::{Codec, Description, Tested};
use crate::plu::LOST;
use crate::sample::Sample;
use crate::scan::{Shape, matrix};
use crate::x3p::ZIP_MAGIC;
use crate::xml::Document;
use crate::{Format, FormatError, ReadOptions, Scan};

pub(crate) const CODEC: Codec = Codec {
    description: Description {
        format: Format::Plux,
        extensions: &["plux"],
        vendor: "Sensofar",
        known_by: "zip archive with index.xml and a file of the name *.raw, or an index.xml with IMAGE_SIZE_X",
        reads: "float32; layers",
        writes: "",
        stores_pitch: true,
        missing_points: "NaN, ±inf, 1000001",
        orientation: "the first stored row is row 0, as in the colour images beside it",
        tested: Tested::Specification,
    },
    detect,
    read,
    write: None,
};

/// The file of the archive that describes all others.
const INDEX: &str = "index.xml";
/// How the files of heights and of images end.
const RAW: &str = ".raw";
/// The largest `index.xml`, in bytes; those of instruments have some ten thousand.
const MAX_INDEX_BYTES: u64 = 1 << 22;
/// Bytes of `index.xml` in which the size of a map is looked for, and the name of its field.
const START_BYTES: usize = 1 << 14;
const SIZE: &[u8] = b"<IMAGE_SIZE_X>";
/// The format has no lists of numbers in XML: no path of an element ends with a slash.
const NO_LIST: &str = "/";
/// Micrometres in a metre.
const PER_METRE: f64 = 1e6;
/// Relative difference below which the ratio of the pixel's sides is that of the numbers of points.
const RATIO_TOLERANCE: f64 = 1e-3;

/// Paths of elements below the root of `index.xml`.
mod path {
    pub(super) const SIZE_X: &str = "GENERAL/IMAGE_SIZE_X";
    pub(super) const SIZE_Y: &str = "GENERAL/IMAGE_SIZE_Y";
    pub(super) const PITCH_X: &str = "GENERAL/FOV_X";
    pub(super) const PITCH_Y: &str = "GENERAL/FOV_Y";
    pub(super) const INFO: &str = "INFO/ITEM_";
}

/// `index.xml` is a common name: a file of heights stands beside it, or it states the size of a map.
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

    let (ny, nx) = document.shape(path::SIZE_Y, path::SIZE_X)?;
    let mut warnings = Vec::new();
    let (mut heights, unpacked) = archive.read_numbers(link, Sample::F32, 0, ny * nx, ny as u64 * nx as u64)?;
    if unpacked.md5.is_none() {
        warnings.push(format!("{link} is longer than the stated dimensions"));
    }
    for z in &mut heights {
        *z = if *z == LOST { f64::NAN } else { *z / PER_METRE };
    }
    let pitch_m = pitch(&document, (ny, nx), &mut warnings)?;
    let heights_m = matrix(Format::Plux, link, document.at(0), (ny, nx), heights)?;
    let scan = Scan { metadata: metadata(&document), warnings, ..Scan::new(heights_m, pitch_m) };
    Ok(scan.with_channels(channels, channel))
}

/// Numbers of the layers that have heights, and the links to them.
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

/// The distance between points in metre.
fn pitch(document: &Document, (ny, nx): Shape, warnings: &mut Vec<String>) -> Result<Option<(f64, f64)>> {
    let Some((x, y)) = document.number(path::PITCH_X)?.zip(document.number(path::PITCH_Y)?) else {
        warnings.push(format!("{INDEX} states no {} or no {}; no pixel size was read", path::PITCH_X, path::PITCH_Y));
        return Ok(None);
    };
    let stretch = x * ny as f64 / (y * nx as f64);
    if nx != ny && (stretch - 1.0).abs() < RATIO_TOLERANCE {
        warnings.push(format!(
            "{} and {} are as the numbers of points and may be sides of the field; they were read as those of a pixel",
            path::PITCH_X,
            path::PITCH_Y
        ));
    }
    Ok(Some((x / PER_METRE, y / PER_METRE)))
}

/// All texts by their paths, and the items of `INFO` by their own names.
fn metadata(document: &Document) -> BTreeMap<String, String> {
    let mut metadata = BTreeMap::new();
    for (path, value) in &document.values {
        let item = path.strip_prefix(path::INFO).and_then(|item| item.split_once('/'));
        match item {
            Some((number, "NAME")) => {
                let text = document.text(&format!("{}{number}/VALUE", path::INFO)).unwrap_or_default();
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
