//! A sparse factor of the inverse of a correlation matrix.

use rayon::prelude::*;

use super::kernel::Lags;
use asperity_base::map::Grid;

/// Predecessors on which a point depends.
const NEIGHBOURS: usize = 30;
/// Predecessors among which they are looked for, over [`NEIGHBOURS`], and the farthest along each axis in steps.
const CANDIDATES: f64 = 4.0;
const FARTHEST: isize = 40;
/// Steps between points of the coarsest lattice, as a power of two.
const COARSEST: u32 = 12;
/// Conditional variance below which a predecessor adds nothing but rounding.
const REDUNDANT: f64 = 1e-12;

/// L with L Lᵀ ≈ (K + nugget)⁻¹: of every point the column over itself and its best correlated predecessors.
///
/// Points come in the order of ever finer lattices of 2^ℓ steps. Given coarse points all around, a fine one hardly depends on
/// anything but its neighbours on the same lattice, which is why few predecessors will do at every scale.
#[derive(Debug)]
pub(super) struct SparseInverse {
    columns: Vec<Vec<(u32, f64)>>,
}

impl SparseInverse {
    pub(super) fn new(lags: &Lags, grid: Grid, places: &[usize], nugget: f64) -> Self {
        let (ny, nx) = grid.shape();
        let mut at = vec![u32::MAX; grid.points()];
        for (i, place) in places.iter().enumerate() {
            at[*place] = i as u32;
        }
        // Sparse points need a wider search.
        let density = places.len() as f64 / grid.points() as f64;
        let reach = (0.5 * (CANDIDATES * NEIGHBOURS as f64 / density).sqrt()).ceil() as isize;
        let offsets: Vec<Vec<(isize, isize)>> =
            (0..=COARSEST).map(|level| offsets(lags, grid, 1 << level, reach.min(FARTHEST))).collect();
        let column = |i: usize| {
            let (x, y) = (places[i] % nx, places[i] / nx);
            let level = level(x, y);
            let is_before = |(other_x, other_y): (usize, usize)| {
                let other = self::level(other_x, other_y);
                other > level || (other == level && (other_y, other_x) < (y, x))
            };
            let mut near: Vec<(isize, isize, u32)> = Vec::with_capacity(NEIGHBOURS + 1);
            for (step_x, step_y) in &offsets[level as usize] {
                let (Some(other_x), Some(other_y)) = (x.checked_add_signed(*step_x), y.checked_add_signed(*step_y))
                else {
                    continue;
                };
                if other_x < nx && other_y < ny && is_before((other_x, other_y)) {
                    let index = at[other_y * nx + other_x];
                    if index != u32::MAX {
                        near.push((*step_x, *step_y, index));
                        if near.len() == NEIGHBOURS {
                            break;
                        }
                    }
                }
            }
            near.push((0, 0, i as u32));
            last_column(lags, &near, nugget)
        };
        Self { columns: (0..places.len()).into_par_iter().map(column).collect() }
    }

    /// L Lᵀ v.
    pub(super) fn apply(&self, vector: &[f64], out: &mut [f64]) {
        let inner: Vec<f64> = self
            .columns
            .par_iter()
            .map(|column| column.iter().map(|(index, value)| value * vector[*index as usize]).sum())
            .collect();
        out.fill(0.0);
        for (column, inner) in self.columns.iter().zip(inner) {
            for (index, value) in column {
                out[*index as usize] += value * inner;
            }
        }
    }
}

/// The finest lattice of 2^ℓ steps on which a point lies has the largest ℓ.
fn level(x: usize, y: usize) -> u32 {
    x.trailing_zeros().min(y.trailing_zeros()).min(COARSEST)
}

/// Offsets on a lattice within the grid, by falling correlation; equal ones in row order.
fn offsets(lags: &Lags, grid: Grid, step: isize, reach: isize) -> Vec<(isize, isize)> {
    let (nx, ny) = (grid.nx() as isize, grid.ny() as isize);
    let mut all: Vec<(f64, (isize, isize))> = Vec::new();
    for y in (-reach..=reach).map(|k| k * step).filter(|y| y.abs() < ny) {
        for x in (-reach..=reach).map(|k| k * step).filter(|x| x.abs() < nx) {
            if (x, y) != (0, 0) {
                all.push((lags.at(x, y), (x, y)));
            }
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().map(|(_, offset)| offset).collect()
}

/// The last column of G⁻ᵀ with G Gᵀ the correlation matrix of the points `near`, the last of which is the point itself.
fn last_column(lags: &Lags, near: &[(isize, isize, u32)], nugget: f64) -> Vec<(u32, f64)> {
    let correlation = |i: usize, j: usize| lags.at(near[i].0 - near[j].0, near[i].1 - near[j].1);
    // Rows of G for the points that are not redundant.
    let mut kept: Vec<usize> = Vec::with_capacity(near.len());
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(near.len());
    for i in 0..near.len() {
        let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
        for (j, &other) in kept.iter().enumerate() {
            let known: f64 = row.iter().zip(&rows[j]).map(|(a, b)| a * b).sum();
            row.push((correlation(i, other) - known) / rows[j][j]);
        }
        let left = correlation(i, i) + nugget - row.iter().map(|a| a * a).sum::<f64>();
        let is_last = i + 1 == near.len();
        if left > REDUNDANT || is_last {
            row.push(left.max(REDUNDANT).sqrt());
            rows.push(row);
            kept.push(i);
        }
    }
    // Gᵀ x = e, from the last row up.
    let n = kept.len();
    let mut x = vec![0.0; n];
    x[n - 1] = 1.0 / rows[n - 1][n - 1];
    for j in (0..n - 1).rev() {
        let sum: f64 = (j + 1..n).map(|i| rows[i][j] * x[i]).sum();
        x[j] = -sum / rows[j][j];
    }
    kept.into_iter().zip(x).map(|(i, value)| (near[i].2, value)).collect()
}
