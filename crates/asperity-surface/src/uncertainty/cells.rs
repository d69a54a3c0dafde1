//! A map divided into cells, and sums over heights and pairs of heights in each cell.

use std::ops::Range;

use asperity_base::blocks;
use asperity_base::map::{Grid, HeightMap};

/// Largest number of cells along the longer side of a map.
const MOST_CELLS: f64 = 64.0;
/// Least side of a cell over the correlation length.
const CELL_FRACTION: f64 = 0.5;
/// Least number of correlation lengths along an axis; an axis with fewer is not divided.
const LEAST_LENGTHS: f64 = 8.0;

/// Heights about their mean over their standard deviation, in cells with the same number of correlation lengths along
/// x and y.
pub(super) struct Cells {
    grid: Grid,
    /// Scaled heights in row order, 0 where missing.
    value: Vec<f64>,
    /// 1 where a height is present and 0 elsewhere; `None` if all are present.
    present: Option<Vec<f64>>,
    count: f64,
    size: (usize, usize),
    /// Stride of the rows from which pairs of points are taken, a quarter of a correlation length. The rows between add
    /// only a hundredth of the information.
    stride: usize,
    /// Cells along y and x.
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Distance between neighbouring cells along x and y, in units of which a correlation length has [`Cells::length`].
    pub(super) step: (f64, f64),
    /// Correlation length in those units.
    pub(super) length: f64,
}

impl Cells {
    /// Divides a map of mean `mean_m` and standard deviation `std_m` whose correlation falls to 1/e at `length_m` along
    /// x and y. An axis without a length, or with too few of them, is not divided. Returns `None` if neither axis is
    /// divided.
    pub(super) fn cut(map: &HeightMap, mean_m: f64, std_m: f64, length_m: [Option<f64>; 2]) -> Option<Self> {
        let grid = map.grid();
        let points = [grid.nx() as f64, grid.ny() as f64];
        let pitch_m = [grid.dx_m(), grid.dy_m()];
        // Correlation lengths in points, along the axes that are divided.
        let length = [0, 1].map(|axis| {
            let points_per_length = length_m[axis]? / pitch_m[axis];
            (points[axis] >= LEAST_LENGTHS * points_per_length).then_some(points_per_length)
        });
        let needed = [0, 1].map(|axis| length[axis].map_or(0.0, |l| points[axis] / (MOST_CELLS * l)));
        let fraction = needed.into_iter().fold(CELL_FRACTION, f64::max);
        let size = [0, 1].map(|axis| length[axis].map_or(points[axis], |l| (fraction * l).round().max(1.0)));
        if length == [None, None] {
            return None;
        }
        let value = map.heights_m().iter().map(|z| if z.is_nan() { 0.0 } else { (z - mean_m) / std_m }).collect();
        let missing = map.missing_points();
        let present = (missing > 0).then(|| map.heights_m().iter().map(|z| f64::from(u8::from(!z.is_nan()))).collect());
        let step = [0, 1].map(|axis| length[axis].map_or(1.0, |l| size[axis] / (fraction * l)));
        Some(Self {
            grid,
            value,
            present,
            count: (grid.points() - missing) as f64,
            rows: grid.ny().div_ceil(size[1] as usize),
            columns: grid.nx().div_ceil(size[0] as usize),
            size: (size[0] as usize, size[1] as usize),
            stride: length[1].map_or(1, |l| (0.25 * l).max(1.0) as usize),
            step: (step[0], step[1]),
            length: 1.0 / fraction,
        })
    }

    /// Returns the scaled height at a point, 0 where missing.
    pub(super) fn value(&self, point: usize) -> f64 {
        self.value[point]
    }

    pub(super) fn is_present(&self, point: usize) -> bool {
        self.present.as_ref().is_none_or(|present| present[point] > 0.0)
    }

    /// Returns the number of present heights.
    pub(super) fn count(&self) -> f64 {
        self.count
    }

    pub(super) fn grid(&self) -> Grid {
        self.grid
    }

    /// Returns sums of a term over the points of each cell, without the points outside `rows` and `columns`.
    pub(super) fn sums<const K: usize>(
        &self,
        rows: &Range<usize>,
        columns: &Range<usize>,
        term: impl Fn(usize) -> [f64; K] + Sync,
    ) -> Vec<[f64; K]> {
        let band = |cell_row: usize| {
            let mut sums = vec![[0.0; K]; self.columns];
            let first = (cell_row * self.size.1).max(rows.start);
            for row in first..((cell_row + 1) * self.size.1).min(rows.end) {
                for (cell, sum) in sums.iter_mut().enumerate() {
                    let left = (cell * self.size.0).max(columns.start);
                    for column in left..((cell + 1) * self.size.0).min(columns.end) {
                        let terms = term(row * self.grid.nx() + column);
                        for k in 0..K {
                            sum[k] += terms[k];
                        }
                    }
                }
            }
            sums
        };
        blocks::map::<_, Vec<_>>(0..self.rows, band).concat()
    }

    /// Returns [`Cells::sums`] over all points.
    pub(super) fn sums_of_all<const K: usize>(&self, term: impl Fn(usize) -> [f64; K] + Sync) -> Vec<[f64; K]> {
        self.sums(&(0..self.grid.ny()), &(0..self.grid.nx()), term)
    }

    /// Returns the fraction of the present heights in each cell.
    pub(super) fn fractions(&self) -> Vec<f64> {
        let counts = self.sums_of_all(|point| [f64::from(u8::from(self.is_present(point)))]);
        counts.into_iter().map(|[count]| count / self.count).collect()
    }

    /// Returns the sum of the products of scaled heights a lag apart, and the number of pairs, in the cell of the
    /// pair's first point, with the stride of the rows.
    pub(super) fn pairs(&self, lag_x: isize, lag_y: usize) -> Vec<[f64; 2]> {
        let (nx, ny) = (self.grid.nx(), self.grid.ny());
        let columns = (-lag_x).max(0) as usize..nx.saturating_add_signed(-lag_x.max(0));
        let band = |cell_row: usize| {
            let mut sums = vec![[0.0; 2]; self.columns];
            let first = (cell_row * self.size.1).next_multiple_of(self.stride);
            for row in (first..((cell_row + 1) * self.size.1).min(ny - lag_y)).step_by(self.stride) {
                for (cell, sum) in sums.iter_mut().enumerate() {
                    let left = (cell * self.size.0).max(columns.start);
                    let right = ((cell + 1) * self.size.0).min(columns.end);
                    if left >= right {
                        continue;
                    }
                    let here = row * nx + left..row * nx + right;
                    let from = (here.start + lag_y * nx).wrapping_add_signed(lag_x);
                    let there = from..from + here.len();
                    sum[0] += dot(&self.value[here.clone()], &self.value[there.clone()]);
                    sum[1] += match &self.present {
                        None => here.len() as f64,
                        Some(present) => dot(&present[here], &present[there]),
                    };
                }
            }
            sums
        };
        blocks::map::<_, Vec<_>>(0..self.rows, band).concat()
    }

    /// Returns the number of present heights of each cell in each of `classes`, cell after cell.
    pub(super) fn histogram(&self, classes: usize, class: impl Fn(f64) -> usize + Sync) -> Vec<f64> {
        let band = |cell_row: usize| {
            let mut counts = vec![0.0; self.columns * classes];
            for row in cell_row * self.size.1..((cell_row + 1) * self.size.1).min(self.grid.ny()) {
                for column in 0..self.grid.nx() {
                    let point = row * self.grid.nx() + column;
                    if self.is_present(point) {
                        counts[column / self.size.0 * classes + class(self.value[point])] += 1.0;
                    }
                }
            }
            counts
        };
        blocks::map::<_, Vec<_>>(0..self.rows, band).concat()
    }
}

/// Returns Σ a b.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut lanes = [0.0; LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for ((lane, a), b) in lanes.iter_mut().zip(a).zip(b) {
            *lane += a * b;
        }
    }
    lanes.iter().sum::<f64>() + rest
}
