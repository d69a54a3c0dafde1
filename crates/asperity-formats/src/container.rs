//! Containers of contact.engineering, as written by TopoBank and SurfaceTopography: a zip archive of measurements with
//! a description, `index.json` or in older files `meta.yml`.
//!
//! The description lists the measurements of all surfaces. `datafile` names up to two files of each: `squeezed-netcdf`,
//! with scale, detrending and filling applied, and `original`, the file of the instrument. The squeezed file is read if
//! there is one. An original may lack its unit, the size of its field, n pitches, and a scale of its heights, which the
//! description then states; it is neither detrended nor filled.
//!
//! Both descriptions have a key and its value on each line, so neither JSON nor YAML is parsed in full. The layout is
//! that of the two programs.

use crate::file::read_plain;
use crate::x3p::ZIP_MAGIC;
use crate::{
    Archive, Description, Format, FormatError, ReadOptions, Result, Scan, Tested, per_metre, refuse_if, shown, some_of,
    unique,
};

pub(crate) const CODEC: Description = Description {
    extensions: &["zip"],
    vendor: "contact.engineering",
    known_by: "zip archive with `surfaces` in index.json or meta.yml",
    reads: "measurements in any other format that is not compressed with gzip; the squeezed NetCDF file rather than the original",
    missing_points: "as in the format of the measurement",
    orientation: "as in the format of the measurement",
    tested: Tested::OtherPrograms,
    ..Description::new(Format::Container, |bytes| description(bytes).is_some(), read)
};

/// Names of the description, the newer first, and a word in it.
const NAMES: [&str; 2] = ["index.json", "meta.yml"];
const SURFACES: &[u8] = b"surfaces";
/// Number of bytes that are searched for this word.
const START_BYTES: usize = 1 << 14;
/// Maximum size of the description in bytes, and maximum number of measurements.
const MAX_BYTES: u64 = 1 << 22;
const MAX_MEASUREMENTS: usize = 1 << 12;

/// Measurement in the description.
#[derive(Default)]
struct Measurement {
    squeezed: Option<String>,
    original: Option<String>,
    unit: Option<String>,
    /// Sides of the field in this unit, and factor of the heights.
    size: Vec<f64>,
    scale: Option<f64>,
}

/// Returns the archive and the name of its description.
fn description(bytes: &[u8]) -> Option<(Archive<'_>, &'static str)> {
    let mut archive = Archive::open(Format::Container, bytes).ok().filter(|_| bytes.starts_with(ZIP_MAGIC))?;
    let is_one = |name: &&str| {
        archive.enter_folder_of(name).is_ok()
            && archive
                .read_start(name, START_BYTES)
                .is_ok_and(|start| start.windows(SURFACES.len()).any(|word| word == SURFACES))
    };
    let name = NAMES.into_iter().find(is_one)?;
    Some((archive, name))
}

/// Reads a measurement.
///
/// # Errors
/// Damaged archives, descriptions without measurements, and the errors of the format of the measurement.
fn read(bytes: &[u8], options: &ReadOptions) -> Result<Scan> {
    let wanted = "a measurement with a `datafile` in index.json or meta.yml";
    let none = || FormatError::unsupported(Format::Container, "the container holds no measurement", wanted);
    let (mut archive, name) = description(bytes).ok_or_else(none)?;
    let mut measurements = measurements(&String::from_utf8_lossy(&archive.read_whole(name, MAX_BYTES)?));
    let file = |one: &Measurement| one.squeezed.clone().or_else(|| one.original.clone());
    let files: Vec<String> = measurements.iter().filter_map(file).collect();
    measurements.retain(|one| file(one).is_some());
    refuse_if!(files.is_empty(), none());
    let names = unique(files.clone());
    let chosen = options.choose(Format::Container, &names)?;
    let content = archive.read_whole(&files[chosen], u64::MAX)?;
    let nested = || FormatError::unsupported(Format::Container, "a container in a container", "a file of heights");
    refuse_if!(Format::detect(&content) == Some(Format::Container), nested());
    let inner = ReadOptions { channel: None, ..options.clone() };
    let mut scan = read_plain(None, &content, &inner).map_err(|error| unread(&names, chosen, error))?;
    drop(content);
    if scan.channels.len() > 1 {
        let (count, read) = (scan.channels.len(), scan.channel_name().map(shown).unwrap_or_default());
        scan.warnings.push(format!("`{}` holds {count} height maps; `{read}` was read", shown(&files[chosen])));
    }
    measurements[chosen].complete(&mut scan, options);
    Ok(scan.with_channels(names, chosen))
}

/// Returns the error for a measurement that is not read, which names the others.
fn unread(names: &[String], chosen: usize, error: FormatError) -> FormatError {
    if names.len() == 1 {
        return error;
    }
    let found = format!("`{}` of {} is not read ({error})", shown(&names[chosen]), some_of(names));
    FormatError::unsupported(Format::Container, found, "another of them (`--channel`)")
}

impl Measurement {
    /// Adds unit, scale and distance between points that the file of the measurement does not state.
    fn complete(&self, scan: &mut Scan, options: &ReadOptions) {
        let unit = self.unit.as_deref().and_then(|unit| Some((unit, per_metre(unit)?)));
        let scale = self.scale.filter(|&scale| scale != 1.0 && self.squeezed.is_none());
        if let Some((unit, per_metre)) = unit.filter(|_| scan.height_unit.is_none() && options.height_unit.is_none()) {
            let scale = scale.unwrap_or(1.0);
            scan.heights_m.mapv_inplace(|z| z * scale / per_metre);
            scan.height_unit = Some(unit.to_owned());
        } else if let Some(scale) = scale {
            scan.warnings
                .push(format!("the height scale {scale} of the container was not applied: the heights have a unit"));
        }
        if let (None, Some((_, per_metre)), Some(width)) = (scan.pitch_m, unit, self.size.first()) {
            let (ny, nx) = scan.heights_m.dim();
            let pitch_m = |side: f64, count: usize| side / per_metre / count as f64;
            let dx_m = pitch_m(*width, nx);
            scan.pitch_m = Some((dx_m, self.size.get(1).map_or(dx_m, |side| pitch_m(*side, ny))));
        }
    }
}

/// Returns the measurements that a description lists.
fn measurements(text: &str) -> Vec<Measurement> {
    let mut measurements: Vec<Measurement> = Vec::new();
    // Indentation of the keys of a measurement: the unit of its instrument lies deeper.
    let (mut open, mut is_size, mut level) = (None, false, 0);
    for line in text.lines() {
        // A text in quotes may go on over several lines.
        let quotes = |line: &str, quote: char| line.replace("\\\\", "").replace("\\\"", "").matches(quote).count();
        if let Some(quote) = open {
            open = Some(quote).filter(|_| quotes(line, quote).is_multiple_of(2));
            continue;
        }
        let start = line.trim_start().trim_start_matches("- ");
        let (column, line) = (line.len() - start.len(), start.trim_end().trim_end_matches(','));
        let (key, value) = line.split_once(':').unwrap_or(("", line));
        let (key, value) = (key.trim_matches('"'), value.trim());
        open = value.chars().next().filter(|&c| matches!(c, '"' | '\'') && !quotes(value, c).is_multiple_of(2));
        if key == "datafile" && measurements.len() < MAX_MEASUREMENTS {
            measurements.push(Measurement::default());
            level = column;
        }
        is_size = key == "size" && column == level || key.is_empty() && is_size;
        let Some(last) = measurements.last_mut() else { continue };
        let text = || {
            let text = value.trim_matches(['"', '\'']);
            Some(text.to_owned()).filter(|text| !text.is_empty() && text != "null")
        };
        match key {
            "original" => last.original = text(),
            "squeezed-netcdf" => last.squeezed = text(),
            "unit" if column == level => last.unit = text(),
            "height_scale" if column == level => {
                last.scale = value.parse().ok().filter(|scale: &f64| scale.is_finite())
            }
            _ if is_size => {
                last.size.extend(value.split([',', '[', ']']).filter_map(|side| side.trim().parse::<f64>().ok()))
            }
            _ => (),
        }
    }
    measurements
}
