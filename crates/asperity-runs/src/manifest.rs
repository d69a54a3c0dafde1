//! Manifest of the files that asperity wrote into a folder.
//!
//! One line per file: SHA-256, two spaces, and the path in the folder, in the format of `sha256sum`. In an unfinished
//! folder the manifest has `-` in place of the hash.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use sha2::{Digest, Sha256};

/// Name of the manifest in its folder.
pub(super) const MANIFEST: &str = ".asperity-manifest";
/// Placeholder for the hash of a file that is being written.
pub(super) const UNFINISHED: &str = "-";
/// Size of the read buffer in bytes.
const PIECE_BYTES: usize = 1 << 16;

/// Hashes of files by their path in the folder.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Manifest(BTreeMap<String, String>);

impl Manifest {
    /// Reads the manifest of a folder. Returns `None` if the folder has none.
    pub(super) fn read(folder: &Path) -> io::Result<Option<Self>> {
        match fs::read(folder.join(MANIFEST)) {
            Ok(bytes) => Ok(Some(Self::parse(&String::from_utf8_lossy(&bytes)))),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Parses a manifest. Ignores lines that name no file inside the folder, because unlisted files are never removed.
    pub(super) fn parse(text: &str) -> Self {
        let inside = |path: &str| Path::new(path).components().all(|part| matches!(part, Component::Normal(_)));
        let entries = text.lines().filter_map(|line| line.split_once("  ")).filter(|(_, path)| inside(path));
        Self(entries.map(|(hash, path)| (path.to_owned(), hash.to_owned())).collect())
    }

    /// Builds a manifest of every file in a folder.
    pub(super) fn from_folder(folder: &Path) -> io::Result<Self> {
        let files = entries(folder)?.into_iter().filter(|entry| entry.is_file);
        files.map(|entry| Ok((entry.path, hash(&entry.location)?))).collect::<io::Result<_>>().map(Self)
    }

    /// Updates the hashes of some of the listed files.
    pub(super) fn update<'a>(&mut self, folder: &Path, files: impl Iterator<Item = &'a str>) -> io::Result<()> {
        for file in files {
            self.0.insert(file.to_owned(), hash(&folder.join(file))?);
        }
        Ok(())
    }

    /// Returns whether the manifest lists all files of another.
    pub(super) fn has_all_of(&self, other: &Self) -> bool {
        other.0.keys().all(|file| self.0.contains_key(file))
    }

    /// Returns the manifest as text.
    pub(super) fn text(&self) -> String {
        self.0.iter().fold(String::new(), |mut text, (path, hash)| {
            let _ = writeln!(text, "{hash}  {path}");
            text
        })
    }

    /// Returns the content of a folder that asperity did not write: other files, files that have changed since, links,
    /// and empty folders.
    pub(super) fn foreign(&self, folder: &Path) -> io::Result<Vec<String>> {
        let found = entries(folder)?;
        let mut foreign = Vec::new();
        for entry in &found {
            let known = self.0.get(&entry.path).filter(|_| entry.is_file);
            if entry.is_folder {
                let prefix = format!("{}/", entry.path);
                let is_empty = !found.iter().any(|other| other.path.starts_with(&prefix));
                if is_empty && !self.0.keys().any(|file| file.starts_with(&prefix)) {
                    foreign.push(prefix);
                }
            } else if known.is_none() {
                foreign.push(entry.path.clone());
            } else if known != Some(&hash(&entry.location)?) {
                foreign.push(format!("{} (changed)", entry.path));
            }
        }
        Ok(foreign)
    }

    /// Returns the listed files that are missing or have changed since, with these words.
    pub(super) fn changed(&self, folder: &Path) -> io::Result<Vec<String>> {
        let word = |(file, known): (&String, &String)| match hash(&folder.join(file)) {
            Ok(found) => Ok((found != *known).then(|| format!("{file} (changed)"))),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Some(format!("{file} (missing)"))),
            Err(error) => Err(error),
        };
        self.0.iter().map(word).filter_map(Result::transpose).collect()
    }

    /// Removes the listed files, the manifest, and the folders that are then empty. Everything else stays.
    pub(super) fn remove(&self, folder: &Path) -> io::Result<()> {
        let found = entries(folder)?;
        for entry in found.iter().filter(|entry| entry.is_file && self.0.contains_key(&entry.path)) {
            fs::remove_file(&entry.location)?;
        }
        for entry in found.iter().rev().filter(|entry| entry.is_folder) {
            // A folder with other content stays.
            let _ = fs::remove_dir(&entry.location);
        }
        if entries(folder)?.is_empty() {
            fs::remove_file(folder.join(MANIFEST))?;
            fs::remove_dir(folder)?;
        }
        Ok(())
    }
}

/// File, link or folder below a folder.
struct Entry {
    /// Path in the folder, separated by `/`.
    path: String,
    location: PathBuf,
    is_file: bool,
    is_folder: bool,
}

/// Returns everything in a folder but its manifest, folders before their content. Does not follow links.
fn entries(folder: &Path) -> io::Result<Vec<Entry>> {
    let mut found = Vec::new();
    let mut folders = vec![(String::new(), folder.to_path_buf())];
    while let Some((prefix, folder)) = folders.pop() {
        for entry in fs::read_dir(&folder)? {
            let entry = entry?;
            let kind = entry.file_type()?;
            let path = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if kind.is_dir() {
                folders.push((format!("{path}/"), entry.path()));
            }
            if path != MANIFEST || !kind.is_file() {
                let (is_file, is_folder) = (kind.is_file(), kind.is_dir());
                found.push(Entry { path, location: entry.path(), is_file, is_folder });
            }
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

/// Returns a folder and all folders below it. Does not follow links.
pub(super) fn folders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let below = entries(folder)?.into_iter().filter(|entry| entry.is_folder).map(|entry| entry.location);
    Ok([folder.to_path_buf()].into_iter().chain(below).collect())
}

pub(super) fn hash(file: &Path) -> io::Result<String> {
    let (mut file, mut digest, mut piece) = (File::open(file)?, Sha256::new(), vec![0; PIECE_BYTES]);
    loop {
        match file.read(&mut piece) {
            Ok(0) => break,
            Ok(length) => digest.update(&piece[..length]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(digest.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_manifest_has_the_format_of_sha256sum_and_names_no_file_outside() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("tables")).unwrap();
        fs::write(folder.path().join("tables/abc.csv"), "abc").unwrap();
        // FIPS 180-2, appendix B.1.
        let line = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  tables/abc.csv\n";
        let manifest = Manifest::from_folder(folder.path()).unwrap();
        assert_eq!(manifest.text(), line);
        assert_eq!(Manifest::parse(&format!("{line}-  ../thesis.txt\n-  /etc/passwd\n-  a/../../b\n")), manifest);
        assert!(manifest.foreign(folder.path()).unwrap().is_empty());
    }

    #[test]
    fn everything_else_is_foreign_and_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["tables", "empty", "notes"] {
            fs::create_dir(at(name)).unwrap();
        }
        for name in ["a.csv", "b.csv", "tables/c.csv", "tables/d.csv"] {
            fs::write(at(name), name).unwrap();
        }
        let mut manifest = Manifest::default();
        manifest.update(folder.path(), ["a.csv", "b.csv", "tables/c.csv"].into_iter()).unwrap();
        fs::write(at("b.csv"), "edited").unwrap();
        fs::write(at(".hidden"), "").unwrap();
        fs::write(at("notes/thesis.txt"), "years").unwrap();
        let foreign = manifest.foreign(folder.path()).unwrap();
        assert_eq!(foreign, [".hidden", "b.csv (changed)", "empty/", "notes/thesis.txt", "tables/d.csv"]);
        manifest.remove(folder.path()).unwrap();
        assert!(at("notes/thesis.txt").is_file() && at("tables/d.csv").is_file() && !at("a.csv").exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_foreign_and_its_target_stays() {
        let folder = tempfile::tempdir().unwrap();
        let (run, target) = (folder.path().join("run"), folder.path().join("target"));
        for name in [&run, &target] {
            fs::create_dir(name).unwrap();
            fs::write(name.join("a.csv"), "a").unwrap();
        }
        std::os::unix::fs::symlink(&target, run.join("tables")).unwrap();
        let mut manifest = Manifest::from_folder(&run).unwrap();
        assert_eq!(manifest.foreign(&run).unwrap(), ["tables"]);
        manifest.update(&run, ["tables/a.csv"].into_iter()).unwrap();
        manifest.remove(&run).unwrap();
        assert!(target.join("a.csv").is_file() && !run.join("a.csv").exists());
    }
}
