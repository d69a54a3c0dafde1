//! Check of free memory before a computation starts.

use std::fs;

use pyo3::PyResult;

use crate::errors::ResourceError;

/// Fails if `bytes` exceed the free memory. Systems that do not report it pass.
pub(crate) fn require_memory(bytes: f64, what: &str) -> PyResult<()> {
    let list = fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = list.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    match kibibytes.map(|free| 1024.0 * free) {
        Some(free) if bytes > free => {
            let [bytes, free] = [bytes, free].map(|bytes| 1e-9 * bytes);
            Err(ResourceError::new_err(format!("{what} needs about {bytes:.2} GB; {free:.2} GB of memory are free")))
        }
        _ => Ok(()),
    }
}
