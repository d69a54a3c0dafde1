//! Refuses what the machine has no room for, before it is begun.

use std::fs;
use std::path::{Path, PathBuf};

use crate::failure::{Failure, Kind};

/// An error if `bytes` of memory are more than this machine has free; systems that do not tell are trusted.
pub(crate) fn require_memory(bytes: f64, what: &str) -> Result<(), Failure> {
    let free = fs::read_to_string("/proc/meminfo").ok().and_then(|text| available_bytes(&text));
    match free {
        Some(free) if bytes > free => Err(Failure::new(
            Kind::Resources,
            format!("{what} needs about {}, and {} of memory are free", shown(bytes), shown(free)),
        )),
        _ => Ok(()),
    }
}

/// An error if `bytes` are more than the disk of `path` has free; `path` need not exist. Systems that do not tell are trusted.
pub(crate) fn require_disk(bytes: f64, path: &Path, what: &str) -> Result<(), Failure> {
    match free_disk_bytes(path) {
        Some(free) if bytes > free => Err(Failure::new(
            Kind::Resources,
            format!("{what} needs about {} of disk, and {} are free for {}", shown(bytes), shown(free), path.display()),
        )),
        _ => Ok(()),
    }
}

/// Free bytes on the disk of the nearest folder above `path` that exists.
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

fn available_bytes(meminfo: &str) -> Option<f64> {
    let line = meminfo.lines().find(|line| line.starts_with("MemAvailable:"))?;
    let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024.0)
}

fn shown(bytes: f64) -> String {
    match bytes {
        bytes if bytes < 1e6 => format!("{:.0} kB", bytes * 1e-3),
        bytes if bytes < 1e9 => format!("{:.0} MB", bytes * 1e-6),
        bytes => format!("{:.1} GB", bytes * 1e-9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_free_memory_and_disk_are_read_and_more_is_refused() {
        let meminfo = "MemTotal:       16000000 kB\nMemFree:  1 kB\nMemAvailable:    8000000 kB\n";
        assert_eq!(available_bytes(meminfo), Some(8_192_000_000.0));
        assert_eq!(available_bytes("nothing"), None);
        assert!(require_memory(1e3, "a test").is_ok());
        assert!(require_disk(1.0, Path::new("no/such/folder"), "a test").is_ok());
        let refused = require_disk(1e30, Path::new("no/such/folder"), "a test");
        assert!(refused.map_or_else(|e| e.kind() == Kind::Resources, |()| cfg!(not(unix))));
        let refused = require_memory(1e18, "a test");
        assert!(refused.map_or_else(|e| e.kind() == Kind::Resources, |()| cfg!(not(target_os = "linux"))));
    }
}
