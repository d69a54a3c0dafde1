//! Output of drawn maps: a file or a folder.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use asperity::map::HeightMap;
use asperity::study::Staging;
use asperity_formats::Scan;
use clap::Args;

use super::convert::format_failure;
use crate::failure::Failure;
use crate::output::{check_target, write_verb};
use crate::resources::require_disk;
use crate::run_folder::{begin_folder, store_failure};

/// Destination of one map or several.
#[derive(Debug, Args)]
pub(super) struct MapsOut {
    /// File to write, in the format of its extension (`asperity formats` lists those that are written); an existing
    /// file is replaced. For several maps, the folder of map_0000.x3p, map_0001.x3p, …, which appears complete or not
    /// at all.
    #[arg(long, value_name = "FILE|DIR")]
    out: PathBuf,
    /// Replace a folder that asperity wrote. A folder that contains an input, or a file that asperity did not write or
    /// that has changed, is never replaced. A single file is replaced without this flag.
    #[arg(long)]
    force: bool,
}

/// Output that is being written. If dropped before [`Maps::commit`], a folder is removed.
pub(super) enum Maps<'a> {
    /// One file, replaced atomically, and the verb for the message about it.
    File(&'a Path, &'static str),
    /// A folder.
    Folder(Staging),
}

impl MapsOut {
    /// Prepares to write `count` maps.
    ///
    /// # Errors
    /// The destination cannot be written, is or contains one of the `inputs`, or is a folder that is not empty.
    pub(super) fn open(&self, count: usize, inputs: &[&Path]) -> Result<Maps<'_>, Failure> {
        if count == 1 && !self.out.is_dir() {
            check_target("--out", &self.out, inputs)?;
            return Ok(Maps::File(&self.out, write_verb(&self.out)));
        }
        begin_folder("--out", &self.out, self.force, inputs).map(Maps::Folder)
    }
}

impl Maps<'_> {
    /// Fails if the disk has no room for `count` maps of `points` heights.
    pub(super) fn require_disk(&self, count: usize, points: f64) -> Result<(), Failure> {
        const HEIGHT_BYTES: f64 = 8.0;
        let path = match self {
            Self::File(path, _) => path,
            Self::Folder(staging) => staging.destination(),
        };
        require_disk(HEIGHT_BYTES * points * count as f64, path, "writing the maps")
    }

    /// Writes map number `index`.
    pub(super) fn write(&self, index: usize, map: &HeightMap) -> Result<(), Failure> {
        let grid = map.grid();
        let scan = Scan::new(map.heights_m().clone(), Some((grid.dx_m(), grid.dy_m())));
        match self {
            Self::File(path, _) => asperity_formats::write(&scan, path).map_err(|e| format_failure(&e)),
            Self::Folder(staging) => {
                let name = format!("map_{index:04}.x3p");
                let bytes = asperity_formats::to_bytes(&scan, Path::new(&name)).map_err(|e| format_failure(&e))?;
                staging.write(&name, &bytes).map_err(|e| store_failure(&e))
            }
        }
    }

    /// Moves a folder to its destination and returns a message about the output.
    pub(super) fn commit(self) -> Result<impl Display, Failure> {
        match self {
            Self::File(path, verb) => Ok(format!("{verb} {}", path.display())),
            Self::Folder(staging) => {
                let written = staging.commit_unmarked().map_err(|e| store_failure(&e))?;
                Ok(format!("wrote {}", written.display()))
            }
        }
    }
}
