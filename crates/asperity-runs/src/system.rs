//! The machine as the operating system reports it.

use std::fs;
use std::path::Path;

use asperity_results::Machine;

/// Returns the machine and the number of threads of the present pool.
pub fn machine() -> Machine {
    Machine {
        system: std::env::consts::OS.into(),
        architecture: std::env::consts::ARCH.into(),
        processor: fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        }),
        threads: rayon::current_num_threads(),
    }
}

/// Returns the free memory of the machine in bytes, or less if the address space of the program or its control group is limited, where
/// the system reports it.
pub fn free_memory_bytes() -> Option<f64> {
    let free = entry_bytes(&fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    let left = || {
        let limit = address_space_bytes(&fs::read_to_string("/proc/self/limits").ok()?)?;
        Some((limit - entry_bytes(&fs::read_to_string("/proc/self/status").ok()?, "VmSize:")?).max(0.0))
    };
    let group = || group_bytes(Path::new("/sys/fs/cgroup"), &fs::read_to_string("/proc/self/cgroup").ok()?);
    Some([left(), group()].into_iter().flatten().fold(free, f64::min))
}

/// Returns what the limits of a control group (version 2) and those above it leave, from the folder of all groups and the list of the
/// groups of a program. File pages that were not used lately count as free. `None` if there is no limit.
fn group_bytes(groups: &Path, list: &str) -> Option<f64> {
    let group = list.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let left = |group: &Path| {
        let number = |name: &str| fs::read_to_string(groups.join(group).join(name)).ok()?.trim().parse::<f64>().ok();
        let pages = fs::read_to_string(groups.join(group).join("memory.stat")).ok()?;
        let unused = pages.lines().find_map(|line| line.strip_prefix("inactive_file "))?.parse::<f64>().ok()?;
        Some((number("memory.max")? - number("memory.current")? + unused).max(0.0))
    };
    Path::new(group).ancestors().filter_map(left).reduce(f64::min)
}

/// Returns the soft limit of the address space in a list of limits; `None` if there is none.
fn address_space_bytes(list: &str) -> Option<f64> {
    let limits = list.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    limits.split_whitespace().next()?.parse().ok()
}

/// Returns the largest resident memory of the program in byte since the last [`forget_peak_memory`], where the system reports it.
pub fn peak_memory_bytes() -> Option<f64> {
    entry_bytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Starts to measure the peak of memory anew, where the system can.
pub fn forget_peak_memory() {
    // Elsewhere the peak is that since the start.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Returns the bytes of an entry in a list of the system.
fn entry_bytes(list: &str, name: &str) -> Option<f64> {
    let entry = list.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: f64 = entry.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes * 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_kibibytes() {
        let list = "MemTotal:       16000000 kB\nMemFree:  1 kB\nMemAvailable:    8000000 kB\n";
        assert_eq!(entry_bytes(list, "MemAvailable:"), Some(8_192_000_000.0));
        assert_eq!(entry_bytes("nothing", "MemAvailable:"), None);
        let limits =
            |soft| format!("Max processes  95890  95890  processes\nMax address space  {soft}  unlimited  bytes\n");
        assert_eq!(address_space_bytes(&limits("204800000")), Some(204_800_000.0));
        assert_eq!(address_space_bytes(&limits("unlimited")), None);
    }

    #[test]
    fn the_tightest_limit_of_a_control_group_and_those_above_it_counts() {
        let groups = tempfile::tempdir().unwrap();
        let group = |name: &str, most: &str, current: f64, unused: f64| {
            let folder = groups.path().join(name);
            fs::create_dir_all(&folder).unwrap();
            let pages = format!("anon 7\ninactive_file {unused}\n");
            for (name, text) in
                [("memory.max", most), ("memory.current", &current.to_string()), ("memory.stat", &pages)]
            {
                fs::write(folder.join(name), format!("{text}\n")).unwrap();
            }
        };
        let left = |list| group_bytes(groups.path(), list);
        group("job/step", "max", 10.0, 1.0);
        assert_eq!(left("0::/job/step\n"), None);
        group("job", "1000", 300.0, 20.0);
        group("", "5000", 4000.0, 0.0);
        assert_eq!(left("4:memory:/\n0::/job/step\n"), Some(720.0));
        assert_eq!(left("0::/\n"), Some(1000.0));
        assert_eq!(left("4:memory:/job\n"), None);
    }
}
