//! Reflections that leave a covariance on a rectangle unchanged, and their even and odd functions.

use std::f64::consts::FRAC_1_SQRT_2;

use asperity_base::map::Grid;

/// Functions on a rectangle that are even or odd in x and in y, by their values on the first half of each axis.
///
/// A covariance that is even in x and y commutes with both reflections of the map. So its modes belong to one of four
/// classes, each defined by a quarter of the points. A stationary covariance with an oblique lay commutes only with the
/// reflection through the centre. In row order this reflection reverses the sequence of all points: the classes are
/// those of a single row of nx·ny points.
///
/// Coordinates refer to the unit vectors (e ± mirrored e)/‖·‖, so inner products equal those of the functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Class {
    columns: usize,
    rows: usize,
    odd_x: bool,
    odd_y: bool,
}

impl Class {
    /// Returns the classes of a map: four quarters, or two halves for a covariance that is not mirror-symmetric.
    pub(super) fn all(grid: Grid, mirror_symmetric: bool) -> Vec<Self> {
        let (columns, rows) = if mirror_symmetric { (grid.nx(), grid.ny()) } else { (grid.points(), 1) };
        Self::of(columns, rows)
    }

    /// Returns the classes of one row of points.
    pub(super) fn of_profile(points: usize) -> Vec<Self> {
        Self::of(points, 1)
    }

    fn of(columns: usize, rows: usize) -> Vec<Self> {
        [(false, false), (true, false), (false, true), (true, true)]
            .into_iter()
            .map(|(odd_x, odd_y)| Self { columns, rows, odd_x, odd_y })
            .filter(|class| !class.is_empty())
            .collect()
    }

    fn half_columns(&self) -> usize {
        half(self.columns, self.odd_x)
    }

    fn half_rows(&self) -> usize {
        half(self.rows, self.odd_y)
    }

    /// Returns the number of coordinates.
    pub(super) fn len(&self) -> usize {
        self.half_columns() * self.half_rows()
    }

    /// Returns whether there is no coordinate, as in an odd class of a single row.
    pub(super) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the point of coordinate `i` and its images with their signs; a middle point is its own image and occurs
    /// twice.
    pub(super) fn images(&self, i: usize) -> [(usize, f64); 4] {
        let (x, y) = (i % self.half_columns(), i / self.half_columns());
        let (mirrored_x, mirrored_y) = (self.columns - 1 - x, (self.rows - 1 - y) * self.columns);
        let (sign_x, sign_y, y) = (sign(self.odd_x), sign(self.odd_y), y * self.columns);
        [(y + x, 1.0), (y + mirrored_x, sign_x), (mirrored_y + x, sign_y), (mirrored_y + mirrored_x, sign_x * sign_y)]
    }

    /// Returns the weight 1/√2 for each axis on whose middle line the point of coordinate `i` lies.
    pub(super) fn middle_weight(&self, i: usize) -> f64 {
        middle(i % self.half_columns(), self.columns) * middle(i / self.half_columns(), self.rows)
    }

    /// Returns the value at its point of a function whose coordinate `i` is 1.
    pub(super) fn value_per_coordinate(&self, i: usize) -> f64 {
        0.5 / self.middle_weight(i)
    }

    /// Returns the value at a place of the map of a function whose coordinate there is 1, and that coordinate; `None`
    /// if functions of the class vanish there.
    pub(super) fn coordinate_at(&self, place: usize) -> Option<(usize, f64)> {
        let fold = |i: usize, n: usize, odd: bool| {
            let (folded, sign) = if 2 * i < n { (i, 1.0) } else { (n - 1 - i, sign(odd)) };
            (folded < half(n, odd)).then_some((folded, sign))
        };
        let (x, sign_x) = fold(place % self.columns, self.columns, self.odd_x)?;
        let (y, sign_y) = fold(place / self.columns, self.rows, self.odd_y)?;
        let i = y * self.half_columns() + x;
        Some((i, sign_x * sign_y * self.value_per_coordinate(i)))
    }

    /// Computes the coordinates of the part of `map` that belongs to this class.
    pub(super) fn fold(&self, map: &[f64], coordinates: &mut [f64]) {
        let (half_columns, sign_x, sign_y) = (self.half_columns(), sign(self.odd_x), sign(self.odd_y));
        for (y, out) in coordinates.chunks_exact_mut(half_columns).enumerate() {
            let top = &map[y * self.columns..(y + 1) * self.columns];
            let bottom = &map[(self.rows - 1 - y) * self.columns..(self.rows - y) * self.columns];
            let middle_y = middle(y, self.rows);
            let mirrored = top.iter().rev().zip(bottom.iter().rev());
            for ((value, (a, b)), (c, d)) in out.iter_mut().zip(top.iter().zip(bottom)).zip(mirrored) {
                *value = 0.5 * middle_y * ((a + sign_x * c) + sign_y * (b + sign_x * d));
            }
            if self.columns % 2 == 1 && !self.odd_x {
                out[half_columns - 1] *= FRAC_1_SQRT_2;
            }
        }
    }

    /// Adds the function of these coordinates to `map`.
    pub(super) fn add_to(&self, coordinates: &[f64], map: &mut [f64]) {
        let (sign_x, sign_y) = (sign(self.odd_x), sign(self.odd_y));
        for (y, line) in coordinates.chunks_exact(self.half_columns()).enumerate() {
            let middle_y = middle(y, self.rows);
            let bottom = self.rows - 1 - y;
            // A middle row is written once.
            for (row, sign_row) in [(y, 1.0), (bottom, sign_y)].into_iter().take(if bottom == y { 1 } else { 2 }) {
                let out = &mut map[row * self.columns..(row + 1) * self.columns];
                for (x, coordinate) in line.iter().enumerate() {
                    let value = sign_row * 0.5 * coordinate / (middle_y * middle(x, self.columns));
                    out[x] += value;
                    if 2 * x + 1 != self.columns {
                        out[self.columns - 1 - x] += sign_x * value;
                    }
                }
            }
        }
    }

    /// Chooses the sign of a function so that, in row order of the map, its first value of at least half the largest
    /// magnitude is positive.
    pub(super) fn fix_sign(&self, coordinates: &mut [f64]) {
        // The first such value is among the coordinates' own points, because magnitudes are symmetric.
        let value = |(i, coordinate): (usize, &f64)| self.value_per_coordinate(i) * coordinate;
        let largest = coordinates.iter().enumerate().map(value).fold(0.0_f64, |m, v| m.max(v.abs()));
        let leading = coordinates.iter().enumerate().map(value).find(|v| v.abs() >= 0.5 * largest);
        if leading.is_some_and(|v| v < 0.0) {
            coordinates.iter_mut().for_each(|v| *v = -*v);
        }
    }
}

/// Returns the number of points that define an even or odd function of n points.
fn half(n: usize, odd: bool) -> usize {
    if odd { n / 2 } else { n.div_ceil(2) }
}

fn sign(odd: bool) -> f64 {
    if odd { -1.0 } else { 1.0 }
}

/// Returns the weight 1/√2 of a middle point, which is its own mirror image; 1 elsewhere.
fn middle(i: usize, n: usize) -> f64 {
    if 2 * i + 1 == n { FRAC_1_SQRT_2 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;

    #[test]
    fn the_classes_split_every_map_into_orthogonal_parts() {
        for (nx, ny) in [(6, 4), (7, 4), (6, 5), (7, 5), (2, 3)] {
            let grid = Grid::new(nx, ny, 1.0, 1.0).unwrap();
            let map = random::standard_normal(&mut random::stream(1, "parity", (10 * nx + ny) as u64), nx * ny);
            for mirror_symmetric in [true, false] {
                let classes = Class::all(grid, mirror_symmetric);
                assert_eq!(classes.iter().map(Class::len).sum::<usize>(), nx * ny);
                let (mut sum, mut power) = (vec![0.0; nx * ny], 0.0);
                for class in classes {
                    let mut coordinates = vec![0.0; class.len()];
                    class.fold(&map, &mut coordinates);
                    power += coordinates.iter().map(|u| u * u).sum::<f64>();
                    let mut part = vec![0.0; nx * ny];
                    class.add_to(&coordinates, &mut part);
                    for (i, coordinate) in coordinates.iter().enumerate() {
                        for (place, sign) in class.images(i) {
                            let value = sign * coordinate * class.value_per_coordinate(i);
                            assert!((part[place] - value).abs() < 1e-15);
                            let (back, weight) = class.coordinate_at(place).unwrap();
                            assert!(back == i && (part[place] - weight * coordinate).abs() < 1e-15);
                        }
                    }
                    for (place, value) in part.iter().enumerate() {
                        assert!(class.coordinate_at(place).is_some() || *value == 0.0);
                        sum[place] += value;
                    }
                }
                assert!(sum.iter().zip(&map).all(|(a, b)| (a - b).abs() < 1e-14));
                assert!((power - map.iter().map(|v| v * v).sum::<f64>()).abs() < 1e-12);
            }
        }
    }
}
