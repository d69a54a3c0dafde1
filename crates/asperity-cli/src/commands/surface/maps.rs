//! Where drawn maps go: a file, or a folder.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use asperity::map::HeightMap;
use asperity::study::Staging;
use asperity_formats::Scan;
use clap::Args;

use super::convert::refused;
use crate::failure::Failure;
use crate::output::{check_target, said_of_writing};
use crate::page::{begin_folder, store_failure};
use crate::resources::require_disk;

/// The destination of one map or several.
#[derive(Debug, Args)]
pub(super) struct MapsOut {
    /// File to write, in the format of its extension (`asperity formats` lists those that are written); one that is there
    /// is replaced. For several maps the folder of map_0000.x3p, map_0001.x3p, …, which appears complete or not at all.
    #[arg(long, value_name = "FILE|DIR")]
    out: PathBuf,
    /// Replace a folder that asperity wrote; one that holds any other or changed file, or an input, is refused. A single
    /// file is replaced without it.
    #[arg(long)]
    force: bool,
}

/// Maps in the making; dropped before [`Maps::commit`], a folder leaves nothing behind.
pub(super) enum Maps<'a> {
    /// One file, replaced in one step, and how that is told.
    File(&'a Path, &'static str),
    /// A folder.
    Folder(Staging),
}

impl MapsOut {
    /// Begins to write `count` maps.
    ///
    /// # Errors
    /// The destination cannot be written, or it is or holds one of the `inputs`, or it is a folder that is not empty.
    pub(super) fn open(&self, count: usize, inputs: &[&Path]) -> Result<Maps<'_>, Failure> {
        if count == 1 && !self.out.is_dir() {
            check_target("--out", &self.out, inputs)?;
            return Ok(Maps::File(&self.out, said_of_writing(&self.out)));
        }
        begin_folder("--out", &self.out, self.force, inputs).map(Maps::Folder)
    }
}

impl Maps<'_> {
    /// Refuses `count` maps of `points` heights if the disk has no room for them.
    pub(super) fn require_disk(&self, count: usize, points: f64) -> Result<(), Failure> {
        const HEIGHT_BYTES: f64 = 8.0;
        let path = match self {
            Self::File(path, _) => path,
            Self::Folder(staging) => staging.destination(),
        };
        require_disk(HEIGHT_BYTES * points * count as f64, path, "writing the maps")
    }

    /// Writes map number `index`.
    pub(super) fn keep(&self, index: usize, map: &HeightMap) -> Result<(), Failure> {
        let grid = map.grid();
        let scan = Scan::new(map.heights_m().clone(), Some((grid.dx_m(), grid.dy_m())));
        match self {
            Self::File(path, _) => asperity_formats::write(&scan, path).map_err(|e| refused(&e)),
            Self::Folder(staging) => {
                let name = format!("map_{index:04}.x3p");
                let bytes = asperity_formats::to_bytes(&scan, Path::new(&name)).map_err(|e| refused(&e))?;
                staging.write(&name, &bytes).map_err(|e| store_failure(&e))
            }
        }
    }

    /// Puts a folder in its place; says what was written.
    pub(super) fn commit(self) -> Result<impl Display, Failure> {
        match self {
            Self::File(path, said) => Ok(format!("{said} {}", path.display())),
            Self::Folder(staging) => {
                let written = staging.commit_unmarked().map_err(|e| store_failure(&e))?;
                Ok(format!("wrote {}", written.display()))
            }
        }
    }
}
