//! Folders that appear at their destination complete or not at all.
//!
//! A folder is written under a hidden name beside its destination and renamed at the end. A rename never replaces a
//! folder with content, so a destination that another process wrote meanwhile stays. The process locks the manifest
//! until it ends. A hidden folder whose manifest can be locked is therefore abandoned, and the next [`Staging::open`]
//! beside it removes it.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

use asperity_formats::{
    check_writable, create_locked, is_temporary_suffix, lock_abandoned, remove_abandoned_files, temporary_suffix,
};

use crate::manifest::{MANIFEST, Manifest, UNFINISHED, folders};
use crate::store::{COMPLETE, StoreError, at};

/// Prefixes of hidden names: of a folder that is being written, and of one that is being replaced.
const PARTIAL: &str = ".partial-";
const REPLACED: &str = ".replaced-";
/// Number of names to try, for a hidden folder and for a result whose destination was taken.
const MAX_ATTEMPTS: usize = 1000;

/// Unfinished folder. If dropped without [`Staging::commit`], it is removed.
#[derive(Debug)]
pub struct Staging {
    destination: PathBuf,
    partial: PathBuf,
    /// Manifest of the folder, locked.
    manifest: File,
    /// Manifest of the destination's files to replace; `None` if the destination is empty or absent.
    replaced: Option<Manifest>,
    /// Folders above the destination that were created for it, the deepest first.
    new_parents: Vec<PathBuf>,
}

impl Staging {
    /// Creates an unfinished folder for `destination`. With `force`, the commit replaces an existing folder if it
    /// contains only unchanged files that asperity wrote and none of the `inputs`.
    ///
    /// Calls [`Staging::clean_beside`] first.
    ///
    /// # Errors
    /// The destination is no folder, has no name of its own, contains files that may not be replaced, or its parent
    /// cannot be written.
    pub fn open(destination: &Path, force: bool, inputs: &[&Path]) -> Result<Self, StoreError> {
        // Without a trailing slash, which would make the system follow a link.
        let destination: PathBuf = destination.components().collect();
        Self::clean_beside(&destination);
        let replaced = replaceable(&destination, force, inputs)?;
        let Some(name) = destination.file_name() else { return Err(StoreError::Unnamed { path: destination }) };
        let parent = parent_of(&destination);
        let above = parent.ancestors().filter(|folder| !folder.as_os_str().is_empty());
        let new_parents: Vec<PathBuf> = above.take_while(|folder| !folder.exists()).map(Path::to_path_buf).collect();
        let made = fs::create_dir_all(parent).and_then(|()| {
            check_writable(parent)?;
            hidden_folder(parent, name)
        });
        match made {
            Ok((partial, manifest)) => Ok(Self { destination, partial, manifest, replaced, new_parents }),
            Err(source) => {
                remove_empty(&new_parents);
                Err(StoreError::Io { path: destination, source })
            }
        }
    }

    /// Removes the hidden folders and files that ended processes left beside a destination, and moves folders back that they were about to
    /// replace.
    pub fn clean_beside(destination: &Path) {
        remove_abandoned(parent_of(destination));
    }

    /// Returns the destination.
    pub fn destination(&self) -> &Path {
        &self.destination
    }

    /// Returns the hidden folder that becomes the destination.
    pub fn partial(&self) -> &Path {
        &self.partial
    }

    /// Writes one file; `relative` may name a subfolder.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn write(&self, relative: &str, bytes: &[u8]) -> Result<(), StoreError> {
        let path = self.partial.join(relative);
        let write = || {
            // One call, so that lines of several threads do not mix.
            (&self.manifest).write_all(format!("{UNFINISHED}  {relative}\n").as_bytes())?;
            path.parent().map_or(Ok(()), fs::create_dir_all)?;
            fs::write(&path, bytes)
        };
        write().map_err(at(&self.destination.join(relative)))
    }

    /// Marks the run complete and moves it to its destination.
    ///
    /// # Errors
    /// See [`Staging::commit_unmarked`].
    pub fn commit(self) -> Result<PathBuf, StoreError> {
        self.write(COMPLETE, b"")?;
        self.commit_unmarked()
    }

    /// Moves a folder that is no run to its destination, containing only the files that were written and their
    /// manifest.
    ///
    /// # Errors
    /// The operating system refused; the destination is then unchanged. [`StoreError::NotMoved`] if the folder
    /// could only be moved to another name.
    pub fn commit_unmarked(self) -> Result<PathBuf, StoreError> {
        self.finish_manifest().map_err(at(&self.destination.join(MANIFEST)))?;
        let aside = match self.set_aside() {
            Ok(aside) => aside,
            Err(source) => return Err(self.keep_under_new_name(source)),
        };
        let moved = fs::rename(&self.partial, &self.destination);
        if let Some((aside, old, _lock)) = aside {
            // If the move failed, the old folder moves back, unless another process has written the destination.
            if moved.is_ok() || fs::rename(&aside, &self.destination).is_err() {
                old.remove(&aside).map_err(at(&aside))?;
            }
        }
        match moved {
            Ok(()) => Ok(self.destination.clone()),
            Err(source) => Err(self.keep_under_new_name(source)),
        }
    }

    /// Replaces the unfinished manifest by one with the hashes of all files. Fails if some of them were removed by somebody else.
    fn finish_manifest(&self) -> io::Result<()> {
        let mut file = &self.manifest;
        file.rewind()?;
        let mut written = String::new();
        file.read_to_string(&mut written)?;
        let manifest = Manifest::from_folder(&self.partial)?;
        if !manifest.has_all_of(&Manifest::parse(&written)) {
            return Err(io::Error::new(io::ErrorKind::NotFound, "the folder was removed while it was written"));
        }
        let path = self.partial.join(MANIFEST);
        let anew;
        if !path.exists() {
            anew = File::create(path)?;
            file = &anew;
        }
        // Written over the old lines, which a process that is killed here must leave: what no line lists is never removed.
        let text = manifest.text();
        file.rewind()?;
        file.write_all(text.as_bytes())?;
        file.set_len(text.len() as u64)?;
        file.sync_all()
    }

    /// Moves the folder to be replaced aside, and back if it has changed.
    ///
    /// Returns its new name, its manifest, and the lock of the manifest: other processes ignore the folder while the
    /// manifest is locked.
    fn set_aside(&self) -> io::Result<Option<(PathBuf, &Manifest, Option<File>)>> {
        let Some(old) = &self.replaced else { return Ok(None) };
        let name = self.destination.file_name().unwrap_or_default();
        let aside = parent_of(&self.destination).join(hidden_name(name, REPLACED));
        let lock = lock_abandoned(&self.destination.join(MANIFEST));
        match fs::rename(&self.destination, &aside) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            moved => moved?,
        }
        // From here on no process can add a file under the old name.
        let is_same = Manifest::read(&aside)
            .and_then(|found| Ok(found.as_ref() == Some(old) && old.foreign(&aside)?.is_empty()))
            .unwrap_or(false);
        if is_same {
            return Ok(Some((aside, old, lock)));
        }
        fs::rename(&aside, &self.destination)?;
        Err(io::ErrorKind::DirectoryNotEmpty.into())
    }

    /// Moves a finished folder whose destination was taken to a new name, so that no result is lost.
    fn keep_under_new_name(&self, source: io::Error) -> StoreError {
        let name = self.destination.file_name().unwrap_or_default();
        let free = (2..MAX_ATTEMPTS).find_map(|number| {
            let mut other = name.to_os_string();
            other.push(format!("-{number}"));
            let kept = self.destination.with_file_name(other);
            let is_free = fs::symlink_metadata(&kept).is_err();
            (is_free && fs::rename(&self.partial, &kept).is_ok()).then_some(kept)
        });
        let path = self.destination.clone();
        match free {
            Some(kept) => StoreError::NotMoved { path, source, kept },
            None => StoreError::Io { path, source },
        }
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // After a commit nothing is left to remove; before one, a failed removal must not hide the first error.
        let _ = fs::remove_dir_all(&self.partial);
        remove_empty(&self.new_parents);
    }
}

/// Checks whether a folder may be written to `destination`. Returns the manifest of the files to be replaced.
fn replaceable(destination: &Path, force: bool, inputs: &[&Path]) -> Result<Option<Manifest>, StoreError> {
    let path = || destination.to_path_buf();
    let kind = match fs::symlink_metadata(destination) {
        Ok(metadata) => metadata.file_type(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(at(destination)(error)),
    };
    if kind.is_symlink() {
        return Err(StoreError::NoFolder { path: path(), found: "a symbolic link" });
    }
    if !kind.is_dir() {
        return Err(StoreError::NoFolder { path: path(), found: "no folder" });
    }
    if fs::read_dir(destination).map_err(at(destination))?.next().is_none() {
        return Ok(None);
    }
    if !force {
        return Err(StoreError::NotEmpty { path: path() });
    }
    let folder = destination.canonicalize().map_err(at(destination))?;
    let within = |input: &&&Path| input.canonicalize().is_ok_and(|input| input.starts_with(&folder));
    if let Some(input) = inputs.iter().find(within) {
        return Err(StoreError::HoldsInput { path: path(), input: input.to_path_buf() });
    }
    let Some(manifest) = Manifest::read(destination).map_err(at(destination))? else {
        return Err(StoreError::NoManifest { path: path() });
    };
    // What is write-protected, or belongs to another user, is not replaced.
    OpenOptions::new().write(true).open(destination.join(MANIFEST)).map_err(at(destination))?;
    for folder in folders(destination).map_err(at(destination))? {
        if fs::metadata(&folder).map_err(at(&folder))?.permissions().readonly() {
            return Err(at(&folder)(io::ErrorKind::PermissionDenied.into()));
        }
        // An ended process may have left temporary files.
        remove_abandoned_files(&folder);
    }
    let foreign = manifest.foreign(destination).map_err(at(destination))?;
    if foreign.is_empty() { Ok(Some(manifest)) } else { Err(StoreError::Foreign { path: path(), foreign }) }
}

/// Creates a hidden folder in `parent` with a locked manifest.
fn hidden_folder(parent: &Path, name: &OsStr) -> io::Result<(PathBuf, File)> {
    for _ in 0..MAX_ATTEMPTS {
        let partial = parent.join(hidden_name(name, PARTIAL));
        match fs::create_dir(&partial) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
            made => made?,
        }
        match create_locked(&partial.join(MANIFEST)) {
            Ok(Some(manifest)) => return Ok((partial, manifest)),
            // Another process removed the folder as abandoned before it was locked.
            Ok(None) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => {
                let _ = fs::remove_dir_all(&partial);
                return Err(error);
            }
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Removes the folders that ended processes left in `folder`: unfinished ones, and those that were about to be
/// replaced.
fn remove_abandoned(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let Some(name) = name.to_str().and_then(|name| name.strip_prefix('.')) else { continue };
        let of_kind = |kind: &str| name.rsplit_once(kind).filter(|(_, suffix)| is_temporary_suffix(suffix));
        let (partial, replaced) = (of_kind(PARTIAL), of_kind(REPLACED));
        if (partial.is_none() && replaced.is_none()) || !entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            continue;
        }
        // The lock is held until the folder is removed. A process that was killed at its start left an empty folder.
        let Some(_lock) = lock_abandoned(&path.join(MANIFEST)) else {
            let _ = fs::remove_dir(&path);
            continue;
        };
        if let Some((name, _)) = replaced
            && fs::rename(&path, folder.join(name)).is_ok()
        {
            // The replacement never reached its destination.
            continue;
        }
        if let Ok(Some(manifest)) = Manifest::read(&path)
            && (partial.is_some() || manifest.foreign(&path).is_ok_and(|foreign| foreign.is_empty()))
        {
            let _ = manifest.remove(&path);
        }
    }
}

fn hidden_name(name: &OsStr, kind: &str) -> String {
    format!(".{}{kind}{}", name.to_string_lossy(), temporary_suffix())
}

fn parent_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn remove_empty(folders: &[PathBuf]) {
    for folder in folders {
        // A folder with content stays.
        let _ = fs::remove_dir(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::blocks;

    #[test]
    fn files_of_many_threads_are_all_in_the_manifest() {
        let folder = tempfile::tempdir().unwrap();
        let staging = Staging::open(&folder.path().join("run"), false, &[]).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
        pool.install(|| blocks::for_each(0..800, |i| staging.write(&format!("{}/{i}.txt", i % 7), b"").unwrap()));
        let run = staging.commit().unwrap();
        assert_eq!(Manifest::read(&run).unwrap().unwrap().foreign(&run).unwrap(), Vec::<String>::new());
    }
}
