//! Local variables: what of a map matters for the pressure at one cell.
//!
//! The leading variables of a germ describe the whole map; the pressure at a cell is decided around it. Its own overlap
//! z − d presses the cell, and every overlap elsewhere, once it carries load, lowers the cell by Boussinesq's 1/r. So the
//! variables are the overlap at the cell, and for rings of growing radius the sum of [z − d]⁺/r.

use crate::contact::{self, Boundary, Control};
use crate::map::HeightMap;
use crate::pressure::Problem;

/// How to compute the local variables of a map.
#[derive(Debug, Clone)]
pub(super) struct LocalVariables<'a> {
    problem: Problem<'a>,
    centre: usize,
    mean_separation_m: f64,
    /// For each ring (cell, 1/r in 1/m).
    rings: Vec<Vec<(usize, f64)>>,
}

impl<'a> LocalVariables<'a> {
    /// The overlap at the cell of `problem` and `variables` − 1 rings, whose radii grow geometrically from the pitch to
    /// the farthest cell. Rings between grid points stay empty and are left out. Where the plane of a map is known only
    /// from its contact solution, it is taken to lie `mean_separation_m` above the mean of the map.
    pub(super) fn new(problem: &Problem<'a>, variables: usize, mean_separation_m: f64) -> Self {
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
        Self { problem: *problem, centre: row * grid.nx() + column, mean_separation_m, rings }
    }

    /// The variables of one map; `None` where heights are missing or the control has no plane for it.
    pub(super) fn of(&self, map: &HeightMap) -> Option<Vec<f64>> {
        let heights_m = map.complete_heights_m().ok()?;
        let plane_m = match self.problem.control() {
            Control::Plane { height_m } => height_m,
            control @ (Control::Penetration { .. } | Control::Percentile { .. }) => {
                contact::Problem::new(self.problem.half_space(), heights_m, control, None).ok()?.plane_m()?
            }
            Control::MeanPressure { .. } | Control::Load { .. } | Control::MeanGap { .. } => {
                heights_m.sum() / heights_m.len() as f64 + self.mean_separation_m
            }
        };
        let heights_m = heights_m.as_slice()?;
        let shield = |ring: &Vec<(usize, f64)>| {
            ring.iter().map(|&(i, inverse_m)| (heights_m[i] - plane_m).max(0.0) * inverse_m).sum()
        };
        Some(std::iter::once(heights_m[self.centre] - plane_m).chain(self.rings.iter().map(shield)).collect())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::HalfSpace;
    use crate::map::Grid;
    use crate::pressure::testing::Shape;

    fn problem_on(boundary: Boundary, control: Control, check: impl Fn(&Problem<'_>, &HeightMap)) {
        let grid = Grid::new(9, 7, 1.0, 0.5).unwrap();
        let shape = Shape::new(grid, 1.0, |x, y| (3.1 * x + 1.7 * y * y).sin());
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        let problem = Problem::new(&shape, &half_space, control, None).unwrap().at_cell(1, 2).unwrap();
        check(&problem, &HeightMap::new(grid, shape.heights_m.clone()).unwrap());
    }

    #[test]
    fn rings_hold_every_other_cell_once_with_boussinesqs_weight() {
        for boundary in [Boundary::Free, Boundary::Periodic { mean_compliance_m_per_pa: 1.0 }] {
            problem_on(boundary, Control::Plane { height_m: 0.1 }, |problem, map| {
                let local = LocalVariables::new(problem, 6, 0.0);
                let variables = local.of(map).unwrap();
                let mut wanted = 0.0;
                for ((row, column), z) in map.heights_m().indexed_iter() {
                    let (mut dx, mut dy) = (column.abs_diff(2) as f64, 0.5 * row.abs_diff(1) as f64);
                    if boundary != Boundary::Free {
                        (dx, dy) = (dx.min(9.0 - dx), dy.min(3.5 - dy));
                    }
                    if (row, column) != (1, 2) {
                        wanted += (z - 0.1).max(0.0) / dx.hypot(dy);
                    }
                }
                assert!((variables[0] - (map.heights_m()[[1, 2]] - 0.1)).abs() < 1e-15);
                assert!((variables[1..].iter().sum::<f64>() - wanted).abs() < 1e-12);
                let mut cells: Vec<usize> = local.rings.iter().flatten().map(|&(i, _)| i).collect();
                cells.sort_unstable();
                assert_eq!(cells, (0..63).filter(|&i| i != 11).collect::<Vec<_>>());
            });
        }
    }

    #[test]
    fn each_control_has_its_plane() {
        let planes = [
            (Control::Penetration { metre: 0.3 }, "highest"),
            (Control::Percentile { percent: 50.0 }, "median"),
            (Control::MeanPressure { pascal: 1.0 }, "mean"),
        ];
        for (control, from) in planes {
            problem_on(Boundary::Free, control, |problem, map| {
                let mut sorted: Vec<f64> = map.heights_m().iter().copied().collect();
                sorted.sort_by(f64::total_cmp);
                let plane_m = match from {
                    "highest" => sorted[62] - 0.3,
                    "median" => sorted[31],
                    _ => sorted.iter().sum::<f64>() / 63.0 + 0.05,
                };
                let overlap = LocalVariables::new(problem, 1, 0.05).of(map).unwrap()[0];
                assert!((overlap - (map.heights_m()[[1, 2]] - plane_m)).abs() < 1e-14, "{from}");
            });
        }
    }

    #[test]
    fn scaled_variables_are_standardised_limited_and_free_of_constants() {
        let rows = vec![vec![1.0, 5.0], vec![3.0, 5.0], vec![5.0, 5.0]];
        let scaling = Scaling::of(&rows);
        assert_eq!(scaling.variables(), 1);
        let std = (8.0_f64 / 3.0).sqrt();
        assert_eq!(scaling.apply(&[3.0, 5.0]), [0.0]);
        assert!((scaling.apply(&[100.0, 5.0])[0] - 2.0 / std).abs() < 1e-15);
    }
}
