//! Height maps from files.

use std::path::Path;

use asperity::map::{HeightMap, MapError};
use asperity::quantity::Length;
use asperity_formats::{FormatError, Scan};
use clap::Args;

use crate::args::{self, OneOrTwo};
use crate::failure::{Failure, Kind, chain};
use crate::monitor::Terminal;

/// The scale of files that state none.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct PixelSize {
    /// Distance between points, along x and y; needed for files without one (NPY, text: heights in metre), overrides
    /// that of others.
    #[arg(long, value_name = "Q[,Q]", value_parser = args::quantity_pair::<Length>, allow_hyphen_values = true)]
    pixel_size: Option<OneOrTwo<Length>>,
}

/// Reads a scan, tells its warnings, and applies the pixel size.
pub(crate) fn scan(path: &Path, pixel_size: PixelSize, monitor: &Terminal) -> Result<Scan, Failure> {
    let mut scan = asperity_formats::read(path).map_err(|e| unreadable(&e))?;
    for warning in &scan.warnings {
        monitor.warn(&format!("{}: {warning}", path.display()));
    }
    if let Some((dx, dy)) = pixel_size.pixel_size.map(OneOrTwo::both) {
        if let Some((dx_m, dy_m)) = scan.pitch_m.filter(|pitch| *pitch != (dx.0, dy.0)) {
            let stated = format!("{} × {}", Length(dx_m), Length(dy_m));
            monitor.warn(&format!("{}: --pixel-size {dx} × {dy} replaces the file's {stated}", path.display()));
        }
        scan.pitch_m = Some((dx.0, dy.0));
    }
    Ok(scan)
}

/// Reads a height map.
pub(crate) fn map(path: &Path, pixel_size: PixelSize, monitor: &Terminal) -> Result<HeightMap, Failure> {
    HeightMap::try_from(scan(path, pixel_size, monitor)?).map_err(|e| match e {
        MapError::NoPitch => Failure::usage(format_args!("{}: {e}", path.display())),
        e => Failure::data(path.display(), &e),
    })
}

/// A file that cannot be read is missing or unusable data; the message names the file already.
pub(crate) fn unreadable(error: &FormatError) -> Failure {
    Failure::new(Kind::Data, chain(error))
}
