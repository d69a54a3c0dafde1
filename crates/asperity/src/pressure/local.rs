//! Local variables: what of a map matters for the pressure at one cell.
//!
//! The leading variables of a germ describe the whole map; the pressure at a cell is decided around it. Its own overlap
//! z − d presses the cell, and every overlap elsewhere, once it carries load, lowers the cell by Boussinesq's 1/r. So the
//! variables are the overlap at the cell, and for rings of growing radius the sum of [z − d]⁺/r.

use crate::contact::Boundary;
use crate::map::HeightMap;
use crate::pressure::Problem;

/// How to compute the local variables of a map.
#[derive(Debug, Clone)]
pub(super) struct LocalVariables {
    centre: usize,
    plane_m: f64,
    /// For each ring (cell, 1/r in 1/m).
    rings: Vec<Vec<(usize, f64)>>,
}

impl LocalVariables {
    /// The overlap at the cell of `problem` and `variables` − 1 rings, whose radii grow geometrically from the pitch to
    /// the farthest cell. Rings between grid points stay empty and are left out.
    pub(super) fn new(problem: &Problem<'_>, variables: usize) -> Self {
        let grid = problem.surface().grid();
        let (row, column) = problem.cell();
        let periodic = matches!(problem.half_space().boundary(), Boundary::Periodic { .. });
        let apart = |a: usize, b: usize, n: usize| {
            let distance = a.abs_diff(b);
            (if periodic { distance.min(n - distance) } else { distance }) as f64
        };
        let mut distances_m: Vec<(usize, f64)> = (0..grid.points())
            .map(|i| {
                let along_x = apart(i % grid.nx(), column, grid.nx()) * grid.dx_m();
                let along_y = apart(i / grid.nx(), row, grid.ny()) * grid.dy_m();
                (i, along_x.hypot(along_y))
            })
            .filter(|&(_, r)| r > 0.0)
            .collect();
        distances_m.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let count = variables.saturating_sub(1);
        let mut rings = vec![Vec::new(); count];
        if let (Some(&(_, least)), Some(&(_, largest))) = (distances_m.first(), distances_m.last()) {
            for (i, r) in distances_m {
                let fraction = (r / least).ln() / (largest / least).ln().max(f64::MIN_POSITIVE);
                if let Some(ring) = rings.get_mut(((fraction * count as f64) as usize).min(count.saturating_sub(1))) {
                    ring.push((i, 1.0 / r));
                }
            }
        }
        rings.retain(|ring| !ring.is_empty());
        Self { centre: row * grid.nx() + column, plane_m: problem.plane_m(), rings }
    }

    /// The variables of one map; NaN where heights are missing.
    pub(super) fn of(&self, map: &HeightMap) -> Vec<f64> {
        let heights_m: Vec<f64> = map.heights_m().iter().copied().collect();
        let shield = |ring: &Vec<(usize, f64)>| {
            ring.iter()
                .map(|&(i, inverse_m)| {
                    let overlap = heights_m[i] - self.plane_m;
                    // Not `max`, which would hide a missing height.
                    if overlap < 0.0 { 0.0 } else { overlap * inverse_m }
                })
                .sum()
        };
        std::iter::once(heights_m[self.centre] - self.plane_m).chain(self.rings.iter().map(shield)).collect()
    }
}

/// Shift, scale and range that make variables dimensionless.
#[derive(Debug, Clone)]
pub(super) struct Scaling {
    /// (mean, standard deviation, least, largest) of each variable that varies, with its position.
    columns: Vec<(usize, f64, f64, f64, f64)>,
}

impl Scaling {
    /// The scaling of a sample. Variables that do not vary are dropped.
    pub(super) fn of(rows: &[Vec<f64>]) -> Self {
        let n = rows.len() as f64;
        let columns = (0..rows.first().map_or(0, Vec::len))
            .filter_map(|j| {
                let mean = rows.iter().map(|row| row[j]).sum::<f64>() / n;
                let std = (rows.iter().map(|row| (row[j] - mean).powi(2)).sum::<f64>() / n).sqrt();
                let least = rows.iter().map(|row| row[j]).fold(f64::INFINITY, f64::min);
                let largest = rows.iter().map(|row| row[j]).fold(f64::NEG_INFINITY, f64::max);
                let varies = std > 1e-12 * least.abs().max(largest.abs());
                varies.then_some((j, mean, std, least, largest))
            })
            .collect();
        Self { columns }
    }

    /// Number of variables that vary.
    pub(super) fn variables(&self) -> usize {
        self.columns.len()
    }

    /// The dimensionless variables, limited to the range of the sample so that a polynomial is never extrapolated.
    pub(super) fn apply(&self, row: &[f64]) -> Vec<f64> {
        self.columns.iter().map(|&(j, mean, std, least, largest)| (row[j].clamp(least, largest) - mean) / std).collect()
    }
}
