//! Height maps from files.

use std::convert::Infallible;
use std::path::Path;

use asperity::map::{HeightMap, MapError, checked_pitch_m};
use asperity::quantity::Length;
use asperity_formats::{Channel, Format, FormatError, LengthUnit, ReadOptions, Scan};
use clap::Args;

use crate::args::{self, OneOrTwo};
use crate::failure::{Failure, Kind, chain};
use crate::monitor::Terminal;
use crate::output::Answer;

/// What a file does not say of itself.
#[derive(Debug, Clone, Args)]
pub(crate) struct ScanOptions {
    /// Height map to read of a file that holds several: its name, or its number counted from 1.
    #[arg(long, value_name = "NAME|N", value_parser = channel)]
    channel: Option<Channel>,
    /// Distance between points, along x and y; needed for files without one (NPY, most text), overrides that of
    /// others.
    #[arg(long, value_name = "Q[,Q]", value_parser = args::quantity_pair::<Length>, allow_hyphen_values = true)]
    pixel_size: Option<OneOrTwo<Length>>,
    /// Unit of the heights of a file that states none (NPY, most text, XYZ, TIFF): m, mm, um or nm; overrides
    /// that of others. It is the unit of the numbers in the file: it also replaces a conversion factor in the header of a text.
    #[arg(long, value_name = "U", value_parser = height_unit)]
    height_unit: Option<LengthUnit>,
}

impl ScanOptions {
    /// The options for another file: pixel size and unit, as a channel belongs to one file.
    pub(crate) fn of_another_file(&self) -> Self {
        Self { channel: None, ..self.clone() }
    }
}

/// Reads a scan and reports its warnings.
pub(crate) fn scan(path: &Path, options: &ScanOptions, monitor: &Terminal) -> Result<Scan, Failure> {
    let pitch_m = options.pixel_size.map(OneOrTwo::both).map(|(dx, dy)| checked_pitch_m((dx.0, dy.0)));
    let pitch_m = pitch_m.transpose().map_err(|e| Failure::usage(format_args!("--pixel-size: {e}")))?;
    let choice = ReadOptions { channel: options.channel.clone(), height_unit: options.height_unit.clone(), pitch_m };
    let scan = asperity_formats::read_with(path, &choice).map_err(|e| unreadable(&e))?;
    for warning in &scan.warnings {
        monitor.warn(&format!("{}: {warning}", path.display()));
    }
    Ok(scan)
}

/// Reads a height map.
pub(crate) fn map(path: &Path, options: &ScanOptions, monitor: &Terminal) -> Result<HeightMap, Failure> {
    height_map(scan(path, options, monitor)?, path)
}

/// The height map of a scan that was read from `path`.
pub(crate) fn height_map(scan: Scan, path: &Path) -> Result<HeightMap, Failure> {
    HeightMap::try_from(scan).map_err(|e| no_map(&e, path))
}

/// The reason why the scan of a file is no map.
pub(crate) fn no_map(error: &MapError, path: &Path) -> Failure {
    match error {
        MapError::NoPitch => Failure::usage(format_args!("{}: {error}", path.display())),
        error => Failure::data(path.display(), error),
    }
}

/// The format that was read, and the channel of files that hold several.
pub(crate) fn source(scan: &Scan) -> Answer {
    Answer::default().with("format", scan.format.map(Format::name)).with("channel", scan.channel_name())
}

/// A file that cannot be read is missing or unusable data; the message names the file already.
pub(crate) fn unreadable(error: &FormatError) -> Failure {
    let kind = match error.cause() {
        FormatError::NoSuchChannel { .. } => Kind::Usage,
        _ => Kind::Data,
    };
    Failure::new(kind, chain(error))
}

fn height_unit(text: &str) -> Result<LengthUnit, FormatError> {
    text.parse()
}

fn channel(text: &str) -> Result<Channel, Infallible> {
    Ok(Channel::from(text))
}
