//! Atomic replacement of files, and removal of abandoned temporary files.
//!
//! A process locks each temporary file while it writes it. The operating system releases the lock when the process
//! ends, even if it is killed, so a temporary file that can be locked belongs to no running process. Process numbers
//! alone do not suffice: they are reused, and several hosts or containers may write to one folder. The names contain
//! the host because locks of some network file systems do not reach other hosts.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Maximum number of temporary names to try.
const MAX_ATTEMPTS: u32 = 100;

/// Replaces `path` atomically: readers see the old content or the new, never a part.
///
/// # Errors
/// The temporary file beside `path` cannot be created, written or renamed. `path` is then unchanged.
pub fn replace_file(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let (temporary, mut file) = temporary_beside(path)?;
    let written = write(&mut file).and_then(|()| file.sync_all()).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        // The first error is the one to report.
        let _ = fs::remove_file(&temporary);
    }
    written
}

/// Checks that files can be written to `folder`, and removes files that ended processes left there.
///
/// # Errors
/// The operating system refuses a small file, for example because the disk is full.
pub fn check_writable(folder: &Path) -> io::Result<()> {
    const PROBE: [u8; 4096] = [0; 4096];
    remove_abandoned_files(folder);
    let (temporary, mut file) = temporary_beside(&folder.join("probe"))?;
    let written = file.write_all(&PROBE).and_then(|()| file.sync_all());
    fs::remove_file(&temporary).and(written)
}

/// Removes the temporary files that ended processes of this host left in `folder`.
pub fn remove_abandoned_files(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let suffix =
            name.to_str().and_then(|name| name.strip_prefix(".asperity-")).and_then(|name| name.strip_suffix(".tmp"));
        if suffix.is_some_and(is_temporary_suffix) && lock_abandoned(&entry.path()).is_some() {
            // Another process may remove it at the same time.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Returns a suffix for temporary names: host, process number and a counter.
pub fn temporary_suffix() -> String {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    format!("{}-{}-{}", host(), process::id(), COUNTER.fetch_add(1, Ordering::Relaxed))
}

/// Returns whether `text` is a suffix that [`temporary_suffix`] makes on this host.
pub fn is_temporary_suffix(text: &str) -> bool {
    let numbers =
        text.strip_prefix(host()).and_then(|rest| rest.strip_prefix('-')).and_then(|rest| rest.split_once('-'));
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    numbers.is_some_and(|(process, count)| is_number(process) && is_number(count))
}

/// Creates and locks the file `path`. Returns `None` if the name is taken.
///
/// # Errors
/// The file cannot be created.
pub fn create_locked(path: &Path) -> io::Result<Option<File>> {
    let file = match OpenOptions::new().read(true).write(true).create_new(true).open(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Ok(None),
        file => file?,
    };
    // Between creation and lock, another process may remove the file as abandoned. On a file system without locks no
    // file counts as abandoned, so a failed lock does no harm.
    let lost = matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock)) || !path.exists();
    Ok((!lost).then_some(file))
}

/// Locks a regular file that no running process has locked. Returns `None` for all others.
pub fn lock_abandoned(path: &Path) -> Option<File> {
    if !fs::symlink_metadata(path).is_ok_and(|found| found.is_file()) {
        return None;
    }
    // Network file systems lock only files that are open for writing.
    let file = OpenOptions::new().write(true).open(path).ok()?;
    file.try_lock().ok().map(|()| file)
}

fn temporary_beside(path: &Path) -> io::Result<(PathBuf, File)> {
    for _ in 0..MAX_ATTEMPTS {
        let temporary = path.with_file_name(format!(".asperity-{}.tmp", temporary_suffix()));
        if let Some(file) = create_locked(&temporary)? {
            return Ok((temporary, file));
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Returns the name of this host without hyphens; empty if the system does not report it.
fn host() -> &'static str {
    static HOST: OnceLock<String> = OnceLock::new();
    HOST.get_or_init(|| {
        let name = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        name.trim().chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
    })
}

/// Describes an error of the operating system without its number.
pub fn refusal(error: &io::Error) -> String {
    use io::ErrorKind as Kind;
    let words = match error.kind() {
        Kind::NotFound => "no such file or folder",
        Kind::PermissionDenied => "permission denied",
        Kind::ReadOnlyFilesystem => "the file system is read-only",
        Kind::StorageFull => "the disk is full",
        Kind::QuotaExceeded => "the disk quota is used up",
        Kind::FileTooLarge => "the file would be larger than the system allows",
        Kind::OutOfMemory => "out of memory",
        Kind::IsADirectory => "this is a folder; a file is wanted",
        Kind::NotADirectory => "a part of the path is a file; give a folder",
        Kind::InvalidFilename => "the name is too long or has characters that the system refuses",
        Kind::WriteZero => "the device takes no more bytes",
        _ => {
            let text = error.to_string();
            return text.split(" (os error").next().unwrap_or(&text).to_owned();
        }
    };
    words.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_replacement_leaves_only_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        replace_file(&path, |file| file.write_all(b"old")).unwrap();
        let failed = replace_file(&path, |file| {
            file.write_all(b"half of the n")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert_eq!(refusal(&failed.unwrap_err()), "the disk is full");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn abandoned_files_are_removed_and_all_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let abandoned = at(&format!(".asperity-{}.tmp", temporary_suffix()));
        let in_use = at(&format!(".asperity-{}.tmp", temporary_suffix()));
        let folder_of_that_name = at(&format!(".asperity-{}.tmp", temporary_suffix()));
        drop(create_locked(&abandoned).unwrap());
        assert!(create_locked(&abandoned).unwrap().is_none(), "the name is taken");
        let lock = create_locked(&in_use).unwrap().unwrap();
        fs::create_dir(&folder_of_that_name).unwrap();
        // Names of another host, and of another program.
        let others = [at(&format!(".asperity-{}x-1-2.tmp", host())), at(".asperity-notes.tmp"), at("thesis.tmp")];
        others.iter().for_each(|path| fs::write(path, "").unwrap());
        remove_abandoned_files(folder.path());
        assert!(!abandoned.exists());
        assert!(in_use.exists() && folder_of_that_name.exists() && others.iter().all(|path| path.exists()));
        drop(lock);
        remove_abandoned_files(folder.path());
        assert!(!in_use.exists());
    }

    #[test]
    fn refusals_have_no_numbers() {
        for number in [2, 13, 20, 21, 27, 28, 30, 36, 122, 5] {
            let text = refusal(&io::Error::from_raw_os_error(number));
            assert!(!text.contains("os error"), "{text}");
        }
    }
}
