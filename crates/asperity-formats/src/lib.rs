//! Reads and writes files of measured surfaces.

use std::collections::BTreeMap;

use ndarray::Array2;

/// One measured height map as a file states it.
#[derive(Debug, Clone)]
pub struct Scan {
    /// Heights in metre, shape `[ny, nx]`, row 0 at the top; NaN where the instrument recorded nothing.
    pub heights_m: Array2<f64>,
    /// Distance between points along (x, y) in metre, where the file states it.
    pub pitch_m: Option<(f64, f64)>,
    /// What else the file says, by its own field names.
    pub metadata: BTreeMap<String, String>,
    /// Doubts about the content, in words for the user.
    pub warnings: Vec<String>,
}
