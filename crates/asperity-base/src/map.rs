//! Height maps on regular grids.

use std::ops::RangeInclusive;

use asperity_formats::Scan;
use ndarray::Array2;
use serde::Serialize;
use thiserror::Error;

/// Range of pitches in metre, from below an atomic nucleus to beyond any part, so that squares and sums over a map do
/// not overflow.
pub const PITCH_RANGE_M: RangeInclusive<f64> = 1e-15..=1e3;

/// Range of differences of heights in metre, and of root-mean-square heights. Variances of heights, and the energies of their contact, can
/// be represented.
pub const HEIGHT_RANGE_M: RangeInclusive<f64> = 1e-50..=1e50;

/// Error in the construction of a map.
#[derive(Debug, Clone, Error, PartialEq)]
#[non_exhaustive]
pub enum MapError {
    /// Fewer than two points along a direction of a grid.
    #[error("the map has {nx} × {ny} points; at least 2 × 2 are needed")]
    TooSmall {
        /// Points along x.
        nx: usize,
        /// Points along y.
        ny: usize,
    },
    /// Heights along one line, where a map is needed.
    #[error(
        "a profile of {points} points, without heights across it: `asperity surface stats` measures it, and [surface] of a study takes one \
         profile, for a surface without lay (`isotropic = true`)"
    )]
    Profile {
        /// Number of points.
        points: usize,
    },
    /// A pitch outside of [`PITCH_RANGE_M`].
    #[error(
        "the pixel size is {dx_m:?} × {dy_m:?} m; both must lie between {:e} m and {:e} m",
        PITCH_RANGE_M.start(),
        PITCH_RANGE_M.end()
    )]
    BadPitch {
        /// Pitch along x in metre.
        dx_m: f64,
        /// Pitch along y in metre.
        dy_m: f64,
    },
    /// Measured heights outside of [`HEIGHT_RANGE_M`].
    #[error(
        "the heights lie between {lowest_m:?} m and {highest_m:?} m; none may exceed {:e} m, and they must differ by {:e} m if not all \
         are equal",
        HEIGHT_RANGE_M.end(),
        HEIGHT_RANGE_M.start()
    )]
    BadHeights {
        /// Lowest height in metre.
        lowest_m: f64,
        /// Highest height in metre.
        highest_m: f64,
    },
    /// A file without the distance between its points.
    #[error("the file carries no pixel size; state one (--pixel-size, in a study `pixel_size`)")]
    NoPitch,
    /// No height present.
    #[error("all {points} heights are missing")]
    Empty {
        /// Number of points.
        points: usize,
    },
    /// Missing heights in an operation that requires a complete map.
    #[error("{missing} of {points} heights are missing; this needs a complete map")]
    Incomplete {
        /// Missing points.
        missing: usize,
        /// Number of points.
        points: usize,
    },
    /// Different shapes of a grid and an array.
    #[error("the array has {rows} × {columns} values, the grid {ny} × {nx}")]
    Shape {
        /// Rows of the array.
        rows: usize,
        /// Columns of the array.
        columns: usize,
        /// Rows of the grid.
        ny: usize,
        /// Columns of the grid.
        nx: usize,
    },
}

crate::choice! {
    /// Continuation of a map beyond its edge.
    pub enum BoundaryKind: "boundary" {
        /// A finite patch; in contact it is unloaded outside.
        Free = "free",
        /// The map repeats periodically.
        Periodic = "periodic",
    }
}

/// Regular grid of `nx` × `ny` points; each point represents a cell of `dx_m` × `dy_m`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Grid {
    nx: usize,
    ny: usize,
    dx_m: f64,
    dy_m: f64,
}

impl Grid {
    /// Creates a grid of `nx` × `ny` points with pitches in metre.
    ///
    /// # Errors
    /// Fewer than two points along a direction, or a pitch outside of [`PITCH_RANGE_M`].
    pub fn new(nx: usize, ny: usize, dx_m: f64, dy_m: f64) -> Result<Self, MapError> {
        if nx < 2 || ny < 2 {
            return Err(MapError::TooSmall { nx, ny });
        }
        checked_pitch_m((dx_m, dy_m))?;
        Ok(Self { nx, ny, dx_m, dy_m })
    }

    /// Creates a grid of `nx` × `ny` cells with a total size of `width_m` × `height_m`: the width of n cells is n·dx.
    ///
    /// # Errors
    /// See [`Grid::new`].
    pub fn with_size(nx: usize, ny: usize, width_m: f64, height_m: f64) -> Result<Self, MapError> {
        Self::new(nx, ny, width_m / nx as f64, height_m / ny as f64)
    }

    /// Returns the number of points along x (columns).
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Returns the number of points along y (rows).
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// Returns the pitch along x in metre.
    pub fn dx_m(&self) -> f64 {
        self.dx_m
    }

    /// Returns the pitch along y in metre.
    pub fn dy_m(&self) -> f64 {
        self.dy_m
    }

    /// Returns the number of points.
    pub fn points(&self) -> usize {
        self.nx * self.ny
    }

    /// Returns the length n·dx along x in metre.
    pub fn width_m(&self) -> f64 {
        self.nx as f64 * self.dx_m
    }

    /// Returns the length n·dy along y in metre.
    pub fn height_m(&self) -> f64 {
        self.ny as f64 * self.dy_m
    }

    /// Returns the area of all cells in square metre.
    pub fn area_m2(&self) -> f64 {
        self.width_m() * self.height_m()
    }

    /// Returns the area of one cell in square metre.
    pub fn cell_area_m2(&self) -> f64 {
        self.dx_m * self.dy_m
    }

    /// Returns the array shape (rows, columns) = (ny, nx).
    pub fn shape(&self) -> (usize, usize) {
        (self.ny, self.nx)
    }
}

/// Returns the pitches along x and y in metre, if they are valid.
///
/// # Errors
/// [`MapError::BadPitch`] outside of [`PITCH_RANGE_M`].
pub fn checked_pitch_m((dx_m, dy_m): (f64, f64)) -> Result<(f64, f64), MapError> {
    if PITCH_RANGE_M.contains(&dx_m) && PITCH_RANGE_M.contains(&dy_m) {
        Ok((dx_m, dy_m))
    } else {
        Err(MapError::BadPitch { dx_m, dy_m })
    }
}

/// Heights in metre on a [`Grid`], shape `[ny, nx]`, row 0 at the top. A missing height is stored as NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    grid: Grid,
    heights_m: Array2<f64>,
}

impl HeightMap {
    /// Creates a map from heights in metre, shape `[ny, nx]`. Every non-finite height counts as missing.
    ///
    /// # Errors
    /// Different shapes of the array and the grid, or no height present.
    pub fn new(grid: Grid, mut heights_m: Array2<f64>) -> Result<Self, MapError> {
        let (rows, columns) = heights_m.dim();
        if (rows, columns) != grid.shape() {
            return Err(MapError::Shape { rows, columns, ny: grid.ny, nx: grid.nx });
        }
        if !heights_m.is_standard_layout() {
            heights_m = heights_m.as_standard_layout().into_owned();
        }
        heights_m.mapv_inplace(|z| if z.is_finite() { z } else { f64::NAN });
        if heights_m.iter().all(|z| z.is_nan()) {
            return Err(MapError::Empty { points: grid.points() });
        }
        Ok(Self { grid, heights_m })
    }

    /// Creates a map of measured heights in metre, as [`HeightMap::new`].
    ///
    /// # Errors
    /// As [`HeightMap::new`], or heights whose statistics cannot be represented: see [`HEIGHT_RANGE_M`].
    pub fn measured(grid: Grid, heights_m: Array2<f64>) -> Result<Self, MapError> {
        let map = Self::new(grid, heights_m)?;
        let (lowest_m, highest_m) =
            map.present_m().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
        let differ = lowest_m == highest_m || highest_m - lowest_m >= *HEIGHT_RANGE_M.start();
        if differ && lowest_m.abs().max(highest_m.abs()) <= *HEIGHT_RANGE_M.end() {
            Ok(map)
        } else {
            Err(MapError::BadHeights { lowest_m, highest_m })
        }
    }

    /// Creates a map from a function of the cell centre (x, y) in metre.
    ///
    /// # Errors
    /// No finite height.
    pub fn from_function(grid: Grid, height_m: impl Fn(f64, f64) -> f64) -> Result<Self, MapError> {
        let heights_m = Array2::from_shape_fn(grid.shape(), |(row, column)| {
            height_m((column as f64 + 0.5) * grid.dx_m, (row as f64 + 0.5) * grid.dy_m)
        });
        Self::new(grid, heights_m)
    }

    /// Returns the map with every height multiplied by a finite factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        assert!(factor.is_finite(), "the factor {factor} is not finite");
        Self { grid: self.grid, heights_m: &self.heights_m * factor }
    }

    /// Returns the grid.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Returns the heights in metre, shape `[ny, nx]`, NaN where missing.
    pub fn heights_m(&self) -> &Array2<f64> {
        &self.heights_m
    }

    /// Returns the heights in metre without a copy.
    pub fn into_heights_m(self) -> Array2<f64> {
        self.heights_m
    }

    /// Returns all heights in row order, in metre, NaN where missing.
    pub fn values_m(&self) -> &[f64] {
        // The constructors keep rows contiguous, so a slice always exists.
        self.heights_m.as_slice().unwrap_or_default()
    }

    /// Returns the heights that are present, in row order, in metre.
    pub fn present_m(&self) -> impl Iterator<Item = f64> + '_ {
        self.heights_m.iter().copied().filter(|z| !z.is_nan())
    }

    /// Returns the number of missing heights.
    pub fn missing_points(&self) -> usize {
        self.heights_m.iter().filter(|z| z.is_nan()).count()
    }

    /// Returns the heights of a complete map.
    ///
    /// # Errors
    /// [`MapError::Incomplete`] if heights are missing.
    pub fn complete_heights_m(&self) -> Result<&Array2<f64>, MapError> {
        match self.missing_points() {
            0 => Ok(&self.heights_m),
            missing => Err(MapError::Incomplete { missing, points: self.grid.points() }),
        }
    }
}

impl TryFrom<Scan> for HeightMap {
    type Error = MapError;

    fn try_from(scan: Scan) -> Result<Self, MapError> {
        let (ny, nx) = scan.heights_m.dim();
        if scan.is_profile() {
            return Err(MapError::Profile { points: nx });
        }
        let (dx_m, dy_m) = scan.pitch_m.ok_or(MapError::NoPitch)?;
        Self::measured(Grid::new(nx, ny, dx_m, dy_m)?, scan.heights_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn infinite_heights_are_missing() {
        let grid = Grid::new(2, 2, 1.0, 1.0).unwrap();
        let map = HeightMap::new(grid, array![[1.0, f64::INFINITY], [f64::NAN, 2.0]]).unwrap();
        assert_eq!(map.missing_points(), 2);
        assert_eq!(map.present_m().collect::<Vec<_>>(), [1.0, 2.0]);
        assert_eq!(map.complete_heights_m(), Err(MapError::Incomplete { missing: 2, points: 4 }));
    }

    #[test]
    fn measured_heights_whose_statistics_cannot_be_represented_are_refused() {
        let measured = |a, b| HeightMap::measured(Grid::new(2, 2, 1.0, 1.0).unwrap(), array![[a, a], [f64::NAN, b]]);
        for (a, b) in [(0.0, 1e51), (-1e300, 1.0), (-f64::MAX, f64::MAX), (0.0, 5e-324), (1e-60, 2e-60)] {
            assert_eq!(measured(a, b), Err(MapError::BadHeights { lowest_m: a, highest_m: b }));
        }
        for (a, b) in [(0.0, 0.0), (3.0, 3.0), (1e-300, 1e-300), (0.0, 1e-50), (-1e50, 1e50), (1.0, 1.0 + f64::EPSILON)]
        {
            assert!(measured(a, b).is_ok(), "{a} and {b}");
        }
        let error = measured(0.0, 1e-200).unwrap_err().to_string();
        assert!(error.contains("between 0.0 m and 1e-200 m; none may exceed 1e50 m"), "{error}");
    }

    #[test]
    fn a_single_point_or_an_empty_map_is_refused() {
        assert_eq!(Grid::new(1, 1, 1.0, 1.0), Err(MapError::TooSmall { nx: 1, ny: 1 }));
        for wrong in [0.0, -1e-6, f64::NAN, f64::INFINITY, 1e-155, 9.9e-16, 1.1e3, 1e30] {
            assert!(matches!(Grid::new(2, 2, wrong, 1.0), Err(MapError::BadPitch { .. })), "{wrong}");
            assert!(matches!(Grid::new(2, 2, 1.0, wrong), Err(MapError::BadPitch { .. })), "{wrong}");
        }
        assert!(Grid::new(2, 2, 1e-15, 1e3).is_ok());
        let error = Grid::with_size(100, 100, 1e30, 1.0).unwrap_err().to_string();
        assert!(error.contains("1e28") && error.contains("between 1e-15 m and 1e3 m"), "{error}");
        let grid = Grid::new(2, 2, 1.0, 1.0).unwrap();
        assert_eq!(HeightMap::new(grid, Array2::from_elem((2, 2), f64::NAN)), Err(MapError::Empty { points: 4 }));
    }
}
