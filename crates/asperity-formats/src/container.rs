//! Containers of contact.engineering, as written by TopoBank and SurfaceTopography: a zip archive of measurements with
//! a description, `index.json` or in older files `meta.yml`.
//!
//! The description lists the measurements of all surfaces. `datafile` names up to two files of each: `squeezed-netcdf`,
//! with scale, detrending and filling applied, and `original`, the file of the instrument. The squeezed file is read if
//! there is one. An original may lack its unit, the size of its field, n pitches, and a scale of its heights, which the
//! description then states; it is neither detrended nor filled. A unit that the user states is that of the numbers in
//! the file, to which the scale is then not applied.
//!
//! A measurement is chosen by the name of its file or by its own name, if no other has it.

mod description;

use crate::file::read_plain;
use crate::x3p::ZIP_MAGIC;
use crate::{
    Archive, Channel, Description, Format, FormatError, ReadOptions, Result, Scan, Tested, per_metre, refuse_if, shown,
    some_of, unique,
};
use description::measurements;

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
/// Maximum size of the description in bytes, which a small archive does not reach: parsed, it may take two hundred times its size.
const MAX_BYTES: u64 = 1 << 22;
const FREE_BYTES: u64 = 1 << 18;

/// Measurement in the description.
#[derive(Default)]
struct Measurement {
    name: Option<String>,
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
    let limit = (64 * bytes.len() as u64).clamp(FREE_BYTES, MAX_BYTES);
    let mut measurements = measurements(name, &String::from_utf8_lossy(&archive.read_whole(name, limit)?))?;
    let file = |one: &Measurement| one.squeezed.clone().or_else(|| one.original.clone());
    let files: Vec<String> = measurements.iter().filter_map(file).collect();
    measurements.retain(|one| file(one).is_some());
    refuse_if!(files.is_empty(), none());
    let names = unique(files.clone());
    let chosen = match options.choose(Format::Container, &names) {
        Ok(chosen) => chosen,
        Err(error) => named(&measurements, options).ok_or(error)?,
    };
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
    measurements[chosen].complete(&mut scan, options)?;
    Ok(scan.with_channels(names, chosen))
}

/// Returns the index of the only measurement with the name that the options state.
fn named(measurements: &[Measurement], options: &ReadOptions) -> Option<usize> {
    let Some(Channel::Name(wanted)) = &options.channel else { return None };
    let mut places = (0..measurements.len()).filter(|&place| measurements[place].name.as_ref() == Some(wanted));
    places.next().filter(|_| places.next().is_none())
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
    ///
    /// # Errors
    /// Neither the file nor the options state the unit of the heights, and that of the description is not a length.
    fn complete(&self, scan: &mut Scan, options: &ReadOptions) -> Result<()> {
        let unit = self.unit.as_deref().and_then(|unit| Some((unit, per_metre(unit)?)));
        let other = self.unit.as_deref().filter(|_| unit.is_none()).map(shown);
        let scale = self.scale.filter(|&scale| scale != 1.0 && self.squeezed.is_none());
        if scan.height_unit.is_none() && options.height_unit.is_none() {
            if let Some(other) = other {
                let wanted = "a unit of length; state it, as by --height-unit, if the numbers are heights";
                return Err(FormatError::unsupported(Format::Container, format!("numbers in `{other}`"), wanted));
            }
            let (scale, per_metre) = (scale.unwrap_or(1.0), unit.map_or(1.0, |(_, per_metre)| per_metre));
            scan.heights_m.mapv_inplace(|z| z * scale / per_metre);
            scan.height_unit = unit.map(|(unit, _)| unit.to_owned());
        } else if let Some(scale) = scale {
            let reason =
                if options.height_unit.is_some() { "the stated unit replaces it" } else { "the heights have a unit" };
            scan.warnings.push(format!("the height scale {scale} of the container was not applied: {reason}"));
        }
        let Some(width) = self.size.first().filter(|_| scan.pitch_m.is_none()) else { return Ok(()) };
        let Some((_, per_metre)) = unit else {
            scan.warnings.push("the container states a size without a unit of length; no pixel size was read".into());
            return Ok(());
        };
        let (ny, nx) = scan.heights_m.dim();
        let pitch_m = |side: f64, count: usize| side / per_metre / count as f64;
        let dx_m = pitch_m(*width, nx);
        scan.pitch_m = Some((dx_m, self.size.get(1).map_or(dx_m, |side| pitch_m(*side, ny))));
        Ok(())
    }
}
