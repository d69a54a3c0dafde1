//! NumPy archives: a zip archive of NPY files.
//!
//! Two-dimensional arrays of numbers are maps under their names. A name that ends in a unit of length (`height_um`,
//! `gap_m`) states the unit; other maps are in metre. Arrays whose name ends in another unit (`pressure_pa`) are not
//! maps, and neither are arrays that number regions (`clusters`, `labels`).
//!
//! A short array states the distance between points: `pixel_size`, `pitch` or `spacing` with one number or with two
//! for (x, y), or `dx` and `dy`, in metre or in the unit at the end (`pixel_size_um`). Other short arrays are
//! metadata. The format itself defines none of these conventions.

use std::collections::BTreeMap;
use std::io;

use ndarray::Array2;
use zip::CompressionMethod;

use crate::archive::written;
use crate::npy::Header;
use crate::scan::matrix;
use crate::x3p::ZIP_MAGIC;
use crate::{
    Archive, Description, Format, FormatError, Input, Location, ReadOptions, Result, Scan, Shape, Tested, large,
    per_metre, some_of,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["npz"],
    vendor: "NumPy",
    known_by: "zip archive whose first file is .npy",
    reads: "two-dimensional arrays of the types of NPY, stored or deflated; `pixel_size`, `pitch`, `spacing`, \
            `dx` and `dy` for the pixel size; units at the end of names (`gap_um`)",
    missing_points: "NaN, ±inf",
    orientation: "the first index is the row",
    tested: Tested::OtherPrograms,
    ..Description::new(Format::Npz, detect, read)
};

/// Size in bytes of a local file header of a zip archive before the name of the file.
const LOCAL_HEADER_BYTES: usize = 30;
/// Offset of the length of the name in a local file header.
const NAME_LENGTH: usize = 26;
/// Extension of arrays inside the archive.
const EXTENSION: &str = ".npy";
/// Maximum number of arrays of one archive.
const MAX_ARRAYS: usize = 1024;
/// Number of bytes that are read of each array for its header. NumPy's headers take 128.
const START_BYTES: usize = 4096;
/// Maximum number of numbers of an array that becomes metadata.
const SHORT: i64 = 8;
/// Units of length at the end of names.
const LENGTHS: [&str; 7] = ["m", "cm", "mm", "um", "µm", "nm", "pm"];
/// Units of other quantities at the end of names.
const OTHERS: [&str; 19] =
    ["pa", "kpa", "mpa", "gpa", "n", "kn", "mn", "v", "mv", "k", "degc", "deg", "rad", "s", "ms", "hz", "w", "j", "kg"];
/// Names of arrays that number regions.
const NUMBERS: [&str; 2] = ["clusters", "labels"];

/// Returns whether the first file of a zip archive is an array.
fn detect(bytes: &[u8]) -> bool {
    let length =
        bytes.get(NAME_LENGTH..NAME_LENGTH + 2).map_or(0, |raw| usize::from(raw[0]) | usize::from(raw[1]) << 8);
    let name = bytes.get(LOCAL_HEADER_BYTES..LOCAL_HEADER_BYTES + length);
    bytes.starts_with(ZIP_MAGIC) && name.is_some_and(|name| name.ends_with(EXTENSION.as_bytes()))
}

/// Quantity according to the end of a name.
enum Quantity {
    /// Length, with the number of units per metre.
    Length(f64),
    Other,
}

/// Returns the name without its unit in lower case, and the quantity.
fn quantity(name: &str) -> (String, Quantity) {
    let name = name.to_lowercase();
    if NUMBERS.contains(&name.as_str()) {
        return (name, Quantity::Other);
    }
    let Some((stem, unit)) = name.rsplit_once('_') else { return (name, Quantity::Length(1.0)) };
    // A quotient such as `pa_per_m` is not a length.
    if OTHERS.contains(&unit) || (LENGTHS.contains(&unit) && stem.ends_with("_per")) {
        return (stem.to_owned(), Quantity::Other);
    }
    match per_metre(unit).filter(|_| LENGTHS.contains(&unit)) {
        Some(per_metre) => (stem.to_owned(), Quantity::Length(per_metre)),
        None => (name, Quantity::Length(1.0)),
    }
}

/// Array of the archive that may be a map.
struct Map {
    link: String,
    header: Header,
    shape: Shape,
    per_metre: f64,
    states_unit: bool,
}

/// Reads the selected array as heights.
///
/// # Errors
/// Damaged archives, arrays beyond the end of their files, archives without a two-dimensional array of lengths.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let mut archive = Archive::open(Format::Npz, bytes)?;
    let links: Vec<String> = archive.names().iter().filter(|name| name.ends_with(EXTENSION)).cloned().collect();
    if links.len() > MAX_ARRAYS {
        return Err(Input::new(Format::Npz, bytes).too_large("the number of arrays", 0, links.len(), MAX_ARRAYS));
    }
    let (mut names, mut maps, mut others, mut short) = (Vec::new(), Vec::new(), Vec::new(), BTreeMap::new());
    for link in links {
        let name = link.strip_suffix(EXTENSION).unwrap_or(&link).to_owned();
        let start = archive.read_start(&link, START_BYTES)?;
        let input = Input::entry(Format::Npz, &link, &start);
        let header = match Header::parse(&input) {
            // Texts, truth values, complex numbers and similar types are not heights.
            Err(FormatError::Unsupported { .. }) => {
                others.push(name);
                continue;
            }
            header => header?,
        };
        let (stem, quantity) = quantity(&name);
        match (header.dimensions().as_deref(), quantity) {
            (Some([(1..), (1..)]), Quantity::Length(per_metre)) => {
                let (shape, states_unit) = (header.matrix(&input)?, stem != name.to_lowercase());
                maps.push(Map { header, shape, per_metre, states_unit, link });
                names.push(name);
            }
            (Some([] | [0..=SHORT]), _) => {
                let count = header.dimensions().unwrap_or_default().first().map_or(1, |&length| length as usize);
                short.insert(name, archive.read_array(&link, header.start, (header.sample, header.order), count)?);
            }
            _ => others.push(name),
        }
    }
    if maps.is_empty() {
        let found = format!("no array of the file can be heights: {}", some_of(&others));
        let wanted = "a two-dimensional array of numbers whose name ends in no unit, or in one of length";
        return Err(FormatError::unsupported(Format::Npz, found, wanted));
    }
    let place = options.choose_or(Format::Npz, &names, Some(main(&names)))?;
    let mut warnings = Vec::new();
    if options.channel.is_none() && !others.is_empty() {
        warnings.push(format!("arrays other than heights were left out: {}", some_of(&others)));
    }
    let pitch_m = pitch(&short, &mut warnings);
    let heights_m = heights(&mut archive, &maps[place])?;
    // Only a name with a unit states one.
    let height_unit = Some(maps[place].per_metre).filter(|_| maps[place].states_unit).and_then(crate::unit::name);
    let height_unit = height_unit.map(str::to_owned);
    let text = |values: Vec<f64>| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    let metadata = short.into_iter().map(|(name, values)| (name, text(values))).collect();
    Ok(Scan { metadata, warnings, height_unit, ..Scan::new(heights_m, pitch_m) }.with_channels(names, place))
}

/// Returns the index of the map named height or z, or else 0.
fn main(names: &[String]) -> usize {
    let is_main = |name: &String| matches!(quantity(name).0.as_str(), "height" | "heights" | "z" | "topography");
    names.iter().position(is_main).unwrap_or(0)
}

/// Returns the distance between points from short arrays.
fn pitch(short: &BTreeMap<String, Vec<f64>>, warnings: &mut Vec<String>) -> Option<(f64, f64)> {
    let lengths = |wanted: &str| {
        short.iter().find_map(|(name, values)| match quantity(name) {
            (stem, Quantity::Length(per_metre)) if stem == wanted => {
                Some(values.iter().map(|value| value / per_metre).collect::<Vec<f64>>())
            }
            _ => None,
        })
    };
    for name in ["pixel_size", "pitch", "spacing"] {
        match lengths(name).as_deref() {
            Some(&[both]) => return Some((both, both)),
            Some(&[dx, dy]) => return Some((dx, dy)),
            Some(other) => warnings.push(format!("{name} has {} numbers, not 1 or 2; it was left out", other.len())),
            None => (),
        }
    }
    match (lengths("dx").as_deref(), lengths("dy").as_deref()) {
        (Some(&[dx]), Some(&[dy])) => Some((dx, dy)),
        (Some(&[dx]), None) => {
            warnings.push("there is dx and no dy; square pixels were assumed".into());
            Some((dx, dx))
        }
        _ => None,
    }
}

/// Reads the heights of an array in metre.
fn heights(archive: &mut Archive, map: &Map) -> Result<Array2<f64>> {
    let (ny, nx) = map.shape;
    let number = (map.header.sample, map.header.order);
    let mut heights = archive.read_array(&map.link, map.header.start, number, nx * ny)?;
    if map.header.column_major {
        heights = large::transposed(&heights, (nx, ny));
    }
    if map.per_metre != 1.0 {
        heights.iter_mut().for_each(|z| *z /= map.per_metre);
    }
    matrix(Format::Npz, &map.link, Location::Byte(0), (ny, nx), heights)
}

/// Writes a NumPy archive of named array files ([`crate::write_npy`], [`crate::write_series`]). Equal arrays give equal bytes.
///
/// # Errors
/// A name occurs twice.
pub fn write_npz(arrays: &[(&str, Vec<u8>)]) -> io::Result<Vec<u8>> {
    let names: Vec<String> = arrays.iter().map(|(name, _)| format!("{name}{EXTENSION}")).collect();
    let files: Vec<(&str, &[u8])> =
        names.iter().zip(arrays).map(|(name, (_, bytes))| (name.as_str(), bytes.as_slice())).collect();
    Ok(written(&files, CompressionMethod::Deflated, Some(1))?)
}

/// Reads the two-dimensional array of this name from a NumPy archive.
///
/// # Errors
/// The archive is damaged, or has no such array.
pub fn read_npz(bytes: &[u8], name: &str) -> Result<Array2<f64>> {
    let mut archive = Archive::open(Format::Npz, bytes)?;
    let link = format!("{name}{EXTENSION}");
    let start = archive.read_start(&link, START_BYTES)?;
    let input = Input::entry(Format::Npz, &link, &start);
    let header = Header::parse(&input)?;
    let shape = header.matrix(&input)?;
    heights(&mut archive, &Map { link, header, shape, per_metre: 1.0, states_unit: false })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{read_bytes, write_npy, write_series};
    use ndarray::array;

    #[test]
    fn an_archive_stores_arrays_bit_for_bit_and_equal_arrays_give_equal_bytes() {
        let (pressure, gap) = (array![[0.1, 2e9], [-0.0, 1.0 / 3.0]], array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let file = |values: &Array2<f64>| write_npy(&Scan::new(values.clone(), None));
        let archive = || {
            let pitch = write_series(&[1e-6]);
            write_npz(&[("pressure_pa", file(&pressure)), ("gap_m", file(&gap)), ("dx_m", pitch)]).unwrap()
        };
        assert_eq!(archive(), archive());
        assert_eq!(read_npz(&archive(), "pressure_pa").unwrap(), pressure);
        assert_eq!(read_npz(&archive(), "gap_m").unwrap(), gap);
        assert!(read_npz(&archive(), "other").is_err() && read_npz(&archive(), "dx_m").is_err());
        // As a file of heights, it has the map of lengths and the pitch.
        let scan = read_bytes(&archive()).unwrap();
        assert_eq!((scan.heights_m, scan.pitch_m), (gap, Some((1e-6, 1e-6))));
        assert!(write_npz(&[("a", file(&pressure)), ("a", file(&pressure))]).is_err());
    }
}
