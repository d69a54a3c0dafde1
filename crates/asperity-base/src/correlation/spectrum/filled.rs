//! Small voids of a map, filled for its spectrum.

use crate::map::HeightMap;

/// Largest distance of a missing point from the heights around it, in points.
const FARTHEST: usize = 8;
/// Sweeps of the relaxation for each point of distance, squared.
const SWEEPS: usize = 4;

/// Heights of a map whose missing points continue those around them.
pub(super) struct Filled {
    /// Heights in the order of the map: its own, and solutions of Laplace's equation at missing points.
    pub(super) heights_m: Vec<f64>,
    /// Density in m⁴ that the errors of the filled heights add at every wavevector, if they are independent of each other: their variance
    /// over all points, times the area of a point. The error at the distance d from a height counts with half the mean square difference
    /// of heights at this distance.
    pub(super) scatter_m4: f64,
}

/// Fills the voids of a map; `None` if a missing point is more than 8 points away from the heights around it.
pub(super) fn filled(map: &HeightMap) -> Option<Filled> {
    let (ny, nx) = map.grid().shape();
    let mut heights_m = map.values_m().to_vec();
    let neighbours = |point: usize| {
        let (row, column) = (point / nx, point % nx);
        let beside = [(column > 0).then(|| point - 1), (column + 1 < nx).then_some(point + 1)];
        beside.into_iter().chain([(row > 0).then(|| point - nx), (row + 1 < ny).then_some(point + nx)]).flatten()
    };
    let mean = |heights: &[f64], point: usize| {
        let known = neighbours(point).map(|other| heights[other]).filter(|z| !z.is_nan());
        let (sum, count) = known.fold((0.0, 0.0), |(sum, count), z| (sum + z, count + 1.0));
        sum / count
    };
    // From the edges of the voids inwards.
    let mut layers: Vec<Vec<usize>> = Vec::new();
    let mut open: Vec<usize> = (0..heights_m.len()).filter(|point| heights_m[*point].is_nan()).collect();
    while !open.is_empty() {
        let is_at_edge = |point: &usize| neighbours(*point).any(|other| !heights_m[other].is_nan());
        let (layer, inside): (Vec<usize>, Vec<usize>) = open.into_iter().partition(is_at_edge);
        if layer.is_empty() || layers.len() == FARTHEST {
            return None;
        }
        let found: Vec<f64> = layer.iter().map(|point| mean(&heights_m, *point)).collect();
        layer.iter().zip(found).for_each(|(point, z)| heights_m[*point] = z);
        layers.push(layer);
        open = inside;
    }
    for _ in 0..SWEEPS * layers.len().pow(2) {
        for point in layers.iter().flatten() {
            heights_m[*point] = mean(&heights_m, *point);
        }
    }
    let errors = layers.iter().enumerate().map(|(depth, layer)| layer.len() as f64 * half_difference(map, depth + 1));
    let scatter_m4 = errors.sum::<f64>() / heights_m.len() as f64 * map.grid().cell_area_m2();
    Some(Filled { heights_m, scatter_m4 })
}

/// Returns half the mean square difference of heights so many points apart, along x or y.
fn half_difference(map: &HeightMap, distance: usize) -> f64 {
    let (values, nx) = (map.values_m(), map.grid().nx());
    let along_y = values.iter().zip(values.iter().skip(distance * nx));
    let along_x = values.chunks_exact(nx).flat_map(|row| row.iter().zip(row.iter().skip(distance)));
    let squares = along_x.chain(along_y).map(|(a, b)| (a - b).powi(2)).filter(|square| !square.is_nan());
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
    if count > 0.0 { 0.5 * sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;
    use crate::map::Grid;

    /// Returns a map of x² − y² without the points of a square.
    fn saddle(n: usize, side: usize) -> HeightMap {
        let grid = Grid::new(n, n, 1e-6, 1e-6).unwrap();
        let middle = (n - side) / 2;
        let inside = |k: usize| (middle..middle + side).contains(&k);
        let height = |row: usize, column: usize| {
            let [x, y] = [column, row].map(|k| k as f64 - 0.4 * n as f64);
            if inside(row) && inside(column) { f64::NAN } else { 1e-9 * (x * x - y * y) }
        };
        HeightMap::new(grid, Array2::from_shape_fn((n, n), |(row, column)| height(row, column))).unwrap()
    }

    #[test]
    fn harmonic_heights_are_continued() {
        for side in [1, 2, 5, 12] {
            let (map, whole) = (saddle(32, side), saddle(32, 0));
            let found = filled(&map).unwrap();
            let largest = whole.values_m().iter().map(|z| z.abs()).fold(0.0, f64::max);
            for (found, wanted) in found.heights_m.iter().zip(whole.values_m()) {
                assert!((found - wanted).abs() < 1e-4 * largest, "{side}: {found} {wanted}");
            }
            assert!(found.scatter_m4 > 0.0);
        }
        assert!(filled(&saddle(32, 17)).is_none());
    }
}
