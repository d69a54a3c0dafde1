//! The profiles of a map along one axis.

use std::ops::Range;

use crate::fourier::{lag_sums_of_power, summed_power};
use crate::map::HeightMap;

/// Rows read at a time for profiles along y.
const TILE: usize = 8;

/// A direction of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Along rows.
    X,
    /// Along columns.
    Y,
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
        })
    }
}

/// Returns the number of profiles along `axis`, the points of each, and their pitch in metre.
#[doc(hidden)]
pub fn dimensions(map: &HeightMap, axis: Axis) -> (usize, usize, f64) {
    let grid = map.grid();
    match axis {
        Axis::X => (grid.ny(), grid.nx(), grid.dx_m()),
        Axis::Y => (grid.nx(), grid.ny(), grid.dy_m()),
    }
}

/// Copies a range of profiles, one after the other.
///
/// # Panics
/// If the range exceeds the map, or the length of `heights_m` differs.
#[doc(hidden)]
pub fn copy(map: &HeightMap, axis: Axis, range: Range<usize>, heights_m: &mut [f64]) {
    let width = map.grid().nx();
    let (_, points, _) = dimensions(map, axis);
    assert_eq!(heights_m.len(), range.len() * points, "profiles do not fit");
    match axis {
        Axis::X => heights_m.copy_from_slice(&map.values_m()[range.start * width..range.end * width]),
        Axis::Y => {
            // Eight rows fill a cache line of every profile.
            for (tile, rows) in map.values_m().chunks(TILE * width).enumerate() {
                for (column, out) in range.clone().zip(heights_m.chunks_exact_mut(points)) {
                    let out = &mut out[tile * TILE..];
                    out.iter_mut().zip(rows.chunks_exact(width)).for_each(|(out, row)| *out = row[column]);
                }
            }
        }
    }
}

/// Returns the sums of products of `term` of the heights over the pairs of the same profile, at the lags 0 … padded/2.
/// Lags up to `padded` less the length of a profile contain no wrapped pairs.
pub(super) fn lag_sums(map: &HeightMap, axis: Axis, padded: usize, term: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
    let (all, points, _) = dimensions(map, axis);
    let power = summed_power(all, points, padded, |range, out| {
        copy(map, axis, range, out);
        out.iter_mut().for_each(|z| *z = term(*z));
    });
    lag_sums_of_power(&power, padded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Grid;

    #[test]
    fn profiles_are_rows_and_columns() {
        let map = HeightMap::from_function(Grid::new(11, 19, 1.0, 2.0).unwrap(), |x, y| x + 100.0 * y).unwrap();
        for (axis, profiles, points) in [(Axis::X, 19, 11), (Axis::Y, 11, 19)] {
            assert_eq!(dimensions(&map, axis).0, profiles);
            let mut out = vec![0.0; 3 * points];
            copy(&map, axis, 4..7, &mut out);
            for (i, z) in out.iter().enumerate() {
                let (profile, point) = (4 + i / points, i % points);
                let place = if axis == Axis::X { [profile, point] } else { [point, profile] };
                assert_eq!(*z, map.heights_m()[place]);
            }
        }
    }
}
