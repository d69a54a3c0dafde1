//! Creation of an example study.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::replace_file;

/// Writes an annotated study file and the scan it needs.
#[derive(Debug, Args)]
pub(crate) struct Init {
    /// Folder to write into; created if missing.
    #[arg(default_value = ".")]
    dir: PathBuf,
    /// Example to write.
    #[arg(long, value_enum, default_value = "quickstart")]
    example: Example,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Example {
    /// A brake pad on a rough disc: the whole chain from a scan, in 15 seconds.
    Quickstart,
    /// The study of Gaus et al. 2016.
    Paper,
}

/// File of an example: its name and its bytes.
type Piece = (&'static str, &'static [u8]);

const SCAN: Piece = ("brake_disc.x3p", include_bytes!("init/brake_disc.x3p"));

impl Example {
    fn pieces(self) -> Vec<Piece> {
        match self {
            Self::Quickstart => {
                vec![("quickstart.toml", include_bytes!("init/quickstart.toml")), SCAN]
            }
            Self::Paper => vec![("paper.toml", include_bytes!("init/paper.toml"))],
        }
    }
}

impl Init {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let pieces = self.example.pieces();
        // Write nothing unless all files can be written. An existing file may contain someone's work.
        if let Some((name, _)) = pieces.iter().find(|(name, _)| self.dir.join(name).exists()) {
            let path = self.dir.join(name);
            return Err(Failure::usage(format!("{} exists already; choose another folder", path.display())));
        }
        if self.dir.is_file() {
            return Err(Failure::usage(format!("{} is a file; choose a folder", self.dir.display())));
        }
        fs::create_dir_all(&self.dir)
            .map_err(|e| Failure::io(Kind::Runtime, format_args!("cannot make {}", self.dir.display()), &e))?;
        for (name, bytes) in &pieces {
            replace_file(&self.dir.join(name), |file| std::io::Write::write_all(file, bytes))?;
            monitor.note(&format!("wrote {}", self.dir.join(name).display()));
        }
        let study = self.dir.join(pieces[0].0);
        monitor.note(&format!("next: asperity run {}", shown(&study)));
        Ok(())
    }
}

/// Formats a path without a leading `./`.
fn shown(path: &Path) -> String {
    path.strip_prefix(".").unwrap_or(path).display().to_string()
}
