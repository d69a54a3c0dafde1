//! Fields: maps on the grid of a surface.

use ndarray::Array2;

/// Map of a quantity on a regular grid of cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    pitch_m: [f64; 2],
    unit: String,
    values: Array2<f64>,
}

impl Field {
    /// Creates a field from the pitches along x and y in metre, the SI unit of the values, and the values, shape `[ny, nx]`, NaN where
    /// undefined.
    ///
    /// # Panics
    /// If a pitch is not positive and finite.
    pub fn new(pitch_m: [f64; 2], unit: impl Into<String>, values: Array2<f64>) -> Self {
        assert!(Self::is_pitch(pitch_m), "a pitch is not positive and finite");
        Self { pitch_m, unit: unit.into(), values }
    }

    /// Returns whether both pitches are positive and finite.
    pub fn is_pitch(pitch_m: [f64; 2]) -> bool {
        pitch_m.iter().all(|pitch| *pitch > 0.0 && pitch.is_finite())
    }

    /// Returns the number of cells along x.
    pub fn nx(&self) -> usize {
        self.values.ncols()
    }

    /// Returns the number of cells along y.
    pub fn ny(&self) -> usize {
        self.values.nrows()
    }

    /// Returns the pitch along x in metre.
    pub fn dx_m(&self) -> f64 {
        self.pitch_m[0]
    }

    /// Returns the pitch along y in metre.
    pub fn dy_m(&self) -> f64 {
        self.pitch_m[1]
    }

    /// Returns the SI unit of the values.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Returns the values, shape `[ny, nx]`, NaN where undefined.
    pub fn values(&self) -> &Array2<f64> {
        &self.values
    }

    /// Returns the values, without a copy.
    pub fn into_values(self) -> Array2<f64> {
        self.values
    }
}
