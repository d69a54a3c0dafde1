//! Random maps from a specification.

use std::path::{Path, PathBuf};

use asperity::map::HeightMap;
use asperity::monitor::Monitor;
use asperity::study::Specimen;
use asperity_formats::Scan;
use clap::Args;

use super::convert::refused;
use crate::args;
use crate::commands::study_file;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::check_target;
use crate::resources::require_memory;

/// Draws random maps like the surface of a specification: seed, size, points and a [surface] section.
#[derive(Debug, Args)]
pub(crate) struct Generate {
    /// Specification file.
    spec: PathBuf,
    /// Seed, in place of the file's.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Number of maps.
    #[arg(long, value_name = "K", default_value = "1", value_parser = args::count, allow_hyphen_values = true)]
    count: usize,
    /// File to write (.x3p, .npy, .txt, .dat, .csv), or, for several maps, the folder of map_0000.x3p, map_0001.x3p, …
    #[arg(long, value_name = "FILE|DIR")]
    out: PathBuf,
}

impl Generate {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let into_folder = self.count > 1 || self.out.is_dir();
        if !into_folder {
            check_target("--out", &self.out)?;
        } else if self.out.is_file() {
            let message = format!("--out {}: {} maps need a folder, this is a file", self.out.display(), self.count);
            return Err(Failure::usage(message));
        }
        let mut specimen = study_file::read(&self.spec, Specimen::parse)?;
        specimen.seed = self.seed.unwrap_or(specimen.seed);
        require_memory(specimen.memory_bytes(), "a map of this size")?;
        let sampler =
            specimen.sampler(study_file::folder_of(&self.spec)).map_err(|e| study_file::ended(&self.spec, &e))?;
        for warning in sampler.warnings() {
            monitor.warn(warning);
        }
        if into_folder {
            std::fs::create_dir_all(&self.out)
                .map_err(|e| Failure::io(Kind::Runtime, format_args!("cannot make {}", self.out.display()), &e))?;
        }
        for index in 0..self.count {
            monitor.check()?;
            let path = if into_folder { self.out.join(format!("map_{index:04}.x3p")) } else { self.out.clone() };
            write(&sampler.draw(index as u64), &path)?;
            monitor.progress("maps", index + 1, self.count);
        }
        monitor.note(&format!("wrote {}", self.out.display()));
        Ok(())
    }
}

fn write(map: &HeightMap, path: &Path) -> Result<(), Failure> {
    let grid = map.grid();
    let scan = Scan::new(map.heights_m().clone(), Some((grid.dx_m(), grid.dy_m())));
    asperity_formats::write(&scan, path).map_err(|e| refused(&e))
}
