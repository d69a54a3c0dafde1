//! Check of free memory before a computation starts.

use asperity::study::free_memory_bytes;
use pyo3::PyResult;

use crate::errors::ResourceError;

/// Fails if `bytes` exceed the free memory. Systems that do not report it pass.
pub(crate) fn require_memory(bytes: f64, what: &str) -> PyResult<()> {
    match free_memory_bytes() {
        Some(free) if bytes > free => {
            let [bytes, free] = [bytes, free].map(|bytes| 1e-9 * bytes);
            Err(ResourceError::new_err(format!("{what} needs about {bytes:.2} GB; {free:.2} GB of memory are free")))
        }
        _ => Ok(()),
    }
}
