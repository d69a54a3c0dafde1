//! Reading of height maps from files.

use std::convert::Infallible;
use std::path::Path;

use asperity::map::{HeightMap, MapError, checked_pitch_m};
use asperity::quantity::Length;
use asperity::study::file::DecimalSign;
use asperity_formats::{Channel, Format, FormatError, LengthUnit, ReadOptions, Scan};
use clap::Args;

use crate::args::{self, OneOrTwo};
use crate::failure::{Failure, Kind, chain};
use crate::monitor::Terminal;
use crate::output::Answer;

/// Metadata that some files lack.
#[derive(Debug, Clone, Args)]
pub(crate) struct ScanOptions {
    /// Height map to read from a file that contains several: its name, or its number counted from 1.
    #[arg(long, value_name = "NAME|N", value_parser = channel)]
    channel: Option<Channel>,
    /// Distance between points, along x and y. Required for files that store none (NPY, most text); replaces the
    /// distance stored in other files.
    #[arg(long, value_name = "Q[,Q]", value_parser = args::quantity_pair::<Length>, allow_hyphen_values = true)]
    pixel_size: Option<OneOrTwo<Length>>,
    /// Unit of the heights: m, mm, um or nm. Heights of files that state none (NPY, most text, XYZ, TIFF) count as metre; the flag is
    /// required if they would then exceed the field of view. It replaces the unit stated in other files, and a conversion factor in the
    /// header of a text file.
    #[arg(long, value_name = "U", value_parser = height_unit)]
    height_unit: Option<LengthUnit>,
    /// Decimal sign of a text file in which every comma may be a decimal sign or separate thousands, as in `1,234`. Required for such a
    /// file.
    #[arg(long, value_parser = args::named::<DecimalSign>())]
    decimal: Option<DecimalSign>,
}

impl ScanOptions {
    /// Returns the options for another file: pixel size, unit and decimal sign without the channel, which belongs to one file.
    pub(crate) fn without_channel(&self) -> Self {
        Self { channel: None, ..self.clone() }
    }

    /// Returns the keys of `[surface]` with the same meaning, and their values.
    pub(crate) fn study_keys(&self) -> Vec<(&'static str, toml::Value)> {
        let channel = self.channel.as_ref().map(|channel| match channel {
            Channel::Name(name) => name.clone(),
            Channel::Number(number) => number.to_string(),
        });
        let pixel_size = self.pixel_size.map(OneOrTwo::both).map(|(x, y)| vec![x.to_string(), y.to_string()]);
        let unit = self.height_unit.as_ref().map(|unit| unit.name().to_owned());
        let decimal = self.decimal.map(|decimal| decimal.name().to_owned());
        let [channel, unit, decimal] = [channel, unit, decimal].map(|text| text.map(toml::Value::from));
        let values = [channel, pixel_size.map(toml::Value::from), unit, decimal];
        let named = ["channel", "pixel_size", "height_unit", "decimal"].into_iter().zip(values);
        named.filter_map(|(key, value)| Some((key, value?))).collect()
    }
}

/// Reads a scan and prints its warnings.
pub(crate) fn scan(path: &Path, options: &ScanOptions, monitor: &Terminal) -> Result<Scan, Failure> {
    let scan = read(path, options)?;
    for warning in &scan.warnings {
        monitor.warn(&format!("{}: {warning}", path.display()));
    }
    Ok(scan)
}

/// Returns whether a file holds a profile.
pub(crate) fn is_profile(path: &Path, options: &ScanOptions) -> bool {
    read(path, options).is_ok_and(|scan| scan.is_profile())
}

fn read(path: &Path, options: &ScanOptions) -> Result<Scan, Failure> {
    let pitch_m = options.pixel_size.map(OneOrTwo::both).map(|(dx, dy)| checked_pitch_m((dx.0, dy.0)));
    let pitch_m = pitch_m.transpose().map_err(|e| Failure::usage(format_args!("--pixel-size: {e}")))?;
    let ScanOptions { channel, height_unit, decimal, .. } = options.clone();
    let choice = ReadOptions { channel, height_unit, decimal: decimal.map(Into::into), pitch_m };
    asperity_formats::read_with(path, &choice).map_err(|e| read_failure(&e))
}

/// Reads a height map.
pub(crate) fn map(path: &Path, options: &ScanOptions, monitor: &Terminal) -> Result<HeightMap, Failure> {
    height_map(scan(path, options, monitor)?, path)
}

/// Converts a scan that was read from `path` into a height map.
pub(crate) fn height_map(scan: Scan, path: &Path) -> Result<HeightMap, Failure> {
    HeightMap::try_from(scan).map_err(|e| no_map(&e, path))
}

/// Returns the error of a scan that is no valid map.
pub(crate) fn no_map(error: &MapError, path: &Path) -> Failure {
    match error {
        MapError::NoPitch => Failure::usage(format_args!("{}: {error}", path.display())),
        error => Failure::data(path.display(), error),
    }
}

/// Returns the format of a scan, and the channel if the file contains several.
pub(crate) fn source(scan: &Scan) -> Answer {
    Answer::default().with("format", scan.format.map(Format::name)).with("channel", scan.channel_name())
}

/// Returns the error of a file that is missing or unusable; the message already names the file.
pub(crate) fn read_failure(error: &FormatError) -> Failure {
    let kind = if error.asks_for_option() { Kind::Usage } else { Kind::Data };
    Failure::new(kind, chain(error))
}

fn height_unit(text: &str) -> Result<LengthUnit, FormatError> {
    text.parse()
}

fn channel(text: &str) -> Result<Channel, Infallible> {
    Ok(Channel::from(text))
}
