//! Conversion between file formats.

use std::path::PathBuf;

use asperity::map::HeightMap;
use asperity_formats::{Format, FormatError, Scan};
use clap::Args;

use super::preparation::LevelOption;
use crate::failure::{Failure, Kind, chain};
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;
use crate::output::{check_target, write_verb};

/// Converts a file to another format; missing points stay missing.
#[derive(Debug, Args)]
pub(crate) struct Convert {
    /// File to read, in any format that `asperity formats` lists; the content decides the format.
    input: PathBuf,
    /// File to write; the extension decides the format (`asperity formats` lists those that are written). An existing
    /// file is replaced, unless it is the input.
    output: PathBuf,
    #[command(flatten)]
    options: ScanOptions,
    #[command(flatten)]
    level: LevelOption,
    /// Print one JSON object: what was read and written.
    #[arg(long)]
    json: bool,
}

impl Convert {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        check_target("OUTPUT", &self.output, &[&self.input])?;
        let verb = write_verb(&self.output);
        let mut scan = input::scan(&self.input, &self.options, monitor)?;
        let map = match HeightMap::try_from(scan.clone()) {
            Err(_) if !self.level.removes() => None,
            map => Some(map.map_err(|e| input::no_map(&e, &self.input))?),
        };
        if let Some(map) = map {
            let levelled = self.level.remove(map, &self.input, monitor)?;
            scan = Scan { heights_m: levelled.heights_m().clone(), ..scan };
        }
        asperity_formats::write(&scan, &self.output).map_err(|e| format_failure(&e))?;
        let extension = self.output.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let written = Format::from_extension(&extension);
        if let (Some((dx_m, dy_m)), Some(format)) = (scan.pitch_m, written)
            && !format.stores_pitch()
        {
            let (output, name) = (self.output.display(), format.name());
            monitor.warn(&format!("{output}: {name} cannot store the pixel size, {dx_m:?} × {dy_m:?} m; note it"));
        }
        let (ny, nx) = scan.heights_m.dim();
        let missing = scan.missing_points();
        monitor.note(&format!("{verb} {}: {nx} × {ny} points, {missing} missing", self.output.display()));
        if !self.json {
            return Ok(());
        }
        input::source(&scan)
            .with("written_format", written.map(Format::name))
            .with("nx", nx)
            .with("ny", ny)
            .with("dx_m", scan.pitch_m.map(|(dx_m, _)| dx_m))
            .with("dy_m", scan.pitch_m.map(|(_, dy_m)| dy_m))
            .with("missing_points", missing)
            .print(true)
    }
}

pub(super) fn format_failure(error: &FormatError) -> Failure {
    match error.cause() {
        FormatError::UnknownExtension { .. } | FormatError::NoPitch { .. } => Failure::usage(chain(error)),
        FormatError::Io { path, error } => {
            Failure::io(Kind::Runtime, format_args!("cannot write {}", path.display()), error)
        }
        FormatError::NotStorable { .. } => Failure::new(Kind::Data, chain(error)),
        _ => Failure::new(Kind::Runtime, chain(error)),
    }
}
