//! Checks of free memory and disk space before a computation starts.

use std::path::{Path, PathBuf};

use asperity::study::free_memory_bytes;

use crate::failure::{Failure, Kind};

/// Fails if `bytes` exceed a limit of the user.
pub(crate) fn limit_memory(bytes: f64, what: &str, most: f64) -> Result<(), Failure> {
    if bytes <= most {
        return Ok(());
    }
    let message = format!("{what} needs about {}, more than {}", shown(bytes), shown(most));
    Err(Failure::new(Kind::Resources, message))
}

/// Fails if `bytes` exceed the free memory. Systems that do not report it pass.
pub(crate) fn require_memory(bytes: f64, what: &str) -> Result<(), Failure> {
    match free_memory_bytes() {
        Some(free) if bytes > free => Err(Failure::new(
            Kind::Resources,
            format!("{what} needs about {}; {} of memory are free", shown(bytes), shown(free)),
        )),
        _ => Ok(()),
    }
}

/// Fails if `bytes` exceed the free space on the disk of `path`, which need not exist. Systems that do not report it
/// pass.
pub(crate) fn require_disk(bytes: f64, path: &Path, what: &str) -> Result<(), Failure> {
    match free_disk_bytes(path) {
        Some(free) if bytes > free => Err(Failure::new(
            Kind::Resources,
            format!("{what} needs about {} of disk; {} are free for {}", shown(bytes), shown(free), path.display()),
        )),
        _ => Ok(()),
    }
}

/// Returns the free bytes on the disk of the nearest existing folder above `path`.
#[cfg(unix)]
fn free_disk_bytes(path: &Path) -> Option<f64> {
    let path: PathBuf = std::path::absolute(path).ok()?;
    let disk = path.ancestors().find_map(|folder| rustix::fs::statvfs(folder).ok())?;
    Some(disk.f_bavail as f64 * disk.f_frsize as f64)
}

#[cfg(not(unix))]
fn free_disk_bytes(_path: &Path) -> Option<f64> {
    None
}

fn shown(bytes: f64) -> String {
    let [number, unit] = match bytes {
        bytes if bytes < 1e6 => [format!("{:.0}", bytes * 1e-3), "kB".into()],
        bytes if bytes < 10e6 => [format!("{:.1}", bytes * 1e-6), "MB".into()],
        bytes if bytes < 1e9 => [format!("{:.0}", bytes * 1e-6), "MB".into()],
        bytes => [format!("{:.1}", bytes * 1e-9), "GB".into()],
    };
    format!("{} {unit}", number.trim_end_matches(".0"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_the_free_memory_or_disk_is_refused() {
        assert!(require_memory(1e3, "a test").is_ok() && limit_memory(1e3, "a test", 1e3).is_ok());
        assert_eq!(limit_memory(1e3, "a test", 999.0).unwrap_err().kind(), Kind::Resources);
        assert!(require_disk(1.0, Path::new("no/such/folder"), "a test").is_ok());
        let refused = require_disk(1e30, Path::new("no/such/folder"), "a test");
        assert!(refused.map_or_else(|e| e.kind() == Kind::Resources, |()| cfg!(not(unix))));
        let refused = require_memory(1e18, "a test");
        assert!(refused.map_or_else(|e| e.kind() == Kind::Resources, |()| cfg!(not(target_os = "linux"))));
    }
}
