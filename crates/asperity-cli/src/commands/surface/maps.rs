//! Where drawn maps go: a file, or a folder.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use asperity::map::HeightMap;
use asperity::study::Staging;
use asperity_formats::Scan;
use clap::Args;

use super::convert::refused;
use crate::commands::run::NewParents;
use crate::failure::Failure;
use crate::output::{check_target, said_of_writing};
use crate::page::store_failure;

/// The destination of one map or several.
#[derive(Debug, Args)]
pub(super) struct MapsOut {
    /// File to write, in the format of its extension (`asperity formats` lists those that are written); one that is there
    /// is replaced. For several maps the folder of map_0000.x3p, map_0001.x3p, …, which appears complete or not at all.
    #[arg(long, value_name = "FILE|DIR")]
    out: PathBuf,
    /// Replace a folder that is not empty, unless it holds a file that is read. A single file is replaced without it.
    #[arg(long)]
    force: bool,
}

/// Maps in the making; dropped before [`Maps::commit`], a folder leaves nothing behind.
pub(super) enum Maps<'a> {
    /// One file, replaced in one step, and how that is told.
    File(&'a Path, &'static str),
    /// A folder, and those above it that were made for it.
    Folder(Staging, NewParents),
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
        if self.out.exists() && !self.out.is_dir() {
            let message = format!("--out {}: {count} maps need a folder, this is a file", self.out.display());
            return Err(Failure::usage(message));
        }
        let parents = NewParents::of(&self.out);
        let staging = Staging::open(&self.out, self.force, inputs).map_err(|e| store_failure(&e))?;
        Ok(Maps::Folder(staging, parents))
    }
}

impl Maps<'_> {
    /// Writes map number `index`.
    pub(super) fn keep(&self, index: usize, map: &HeightMap) -> Result<(), Failure> {
        let grid = map.grid();
        let scan = Scan::new(map.heights_m().clone(), Some((grid.dx_m(), grid.dy_m())));
        let path = match self {
            Self::File(path, _) => path.to_path_buf(),
            Self::Folder(staging, _) => staging.path(&format!("map_{index:04}.x3p")).map_err(|e| store_failure(&e))?,
        };
        asperity_formats::write(&scan, &path).map_err(|e| refused(&e))
    }

    /// Puts a folder in its place; says what was written.
    pub(super) fn commit(self) -> Result<impl Display, Failure> {
        match self {
            Self::File(path, said) => Ok(format!("{said} {}", path.display())),
            Self::Folder(staging, _parents) => {
                let written = staging.commit_unmarked().map_err(|e| store_failure(&e))?;
                Ok(format!("wrote {}", written.display()))
            }
        }
    }
}
