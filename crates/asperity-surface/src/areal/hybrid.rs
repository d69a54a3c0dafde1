//! Slopes and developed area.

use asperity_base::blocks;
use asperity_base::map::HeightMap;
use asperity_base::stats::blocks::sum_present;

/// Statistics of the differences between neighbouring heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hybrid {
    /// Root-mean-square gradient by forward differences.
    pub(super) gradient_forward: Option<f64>,
    /// Root-mean-square gradient by seven-point differences.
    pub(super) gradient_seven_points: Option<f64>,
    /// Triangulated area over projected area, minus one.
    pub(super) developed_area_ratio: Option<f64>,
}

/// Sums and numbers of squared gradients by forward differences, of area excesses, and of squared gradients by
/// seven-point differences.
type Sums = [(f64, f64); 3];

/// Computes slopes and area of a map. Each row is summed separately, and rows are added in order.
pub(super) fn hybrid(map: &HeightMap) -> Hybrid {
    let rows: Vec<Sums> = blocks::map_with(0..map.grid().ny() - 1, Vec::new, |terms, row| row_sums(map, row, terms));
    let mean = |which: usize| {
        let (sum, count) = rows.iter().fold((0.0, 0.0), |(s, c), row| (s + row[which].0, c + row[which].1));
        (count > 0.0).then(|| sum / count)
    };
    Hybrid {
        gradient_forward: mean(0).map(f64::sqrt),
        developed_area_ratio: mean(1),
        gradient_seven_points: mean(2).map(f64::sqrt),
    }
}

/// Computes the sums of one row. The terms are written to an array first, so that the compiler vectorises the loops.
fn row_sums(map: &HeightMap, row: usize, terms: &mut Vec<f64>) -> Sums {
    let grid = map.grid();
    let nx = grid.nx();
    let (per_dx, per_dy) = (1.0 / grid.dx_m(), 1.0 / grid.dy_m());
    let line = |row: usize| &map.values_m()[row * nx..(row + 1) * nx];
    let (here, below) = (line(row), line(row + 1));
    let cells = nx - 1;
    terms.resize(nx, 0.0);

    let (a, b, c, d) = (&here[..cells], &here[1..][..cells], &below[..cells], &below[1..][..cells]);
    let out = &mut terms[..cells];
    for i in 0..cells {
        let (along_x, along_y) = ((b[i] - a[i]) * per_dx, (c[i] - a[i]) * per_dy);
        out[i] = along_x * along_x + along_y * along_y;
    }
    let forward = sum_present(out);

    for i in 0..cells {
        let (top, bottom) = ((b[i] - a[i]) * per_dx, (d[i] - c[i]) * per_dx);
        let (left, right) = ((c[i] - a[i]) * per_dy, (d[i] - b[i]) * per_dy);
        let (top, bottom, left, right) = (top * top, bottom * bottom, left * left, right * right);
        // Diagonal b–c defines the triangles (a, b, c) and (d, c, b); diagonal a–d defines (b, a, d) and (c, d, a).
        out[i] = 0.25 * (excesses(top + left, bottom + right) + excesses(top + right, bottom + left));
    }
    let area = sum_present(out);

    let mut seven = (0.0, 0.0);
    if row >= 3 && row + 3 < grid.ny() && nx > 6 {
        let count = nx - 6;
        let out = &mut terms[..count];
        add_square_difference(out, std::array::from_fn(|i| &here[STEPS[i]..][..count]), per_dx / 60.0, |_| 0.0);
        add_square_difference(
            out,
            std::array::from_fn(|i| &line(row + STEPS[i] - 3)[3..nx - 3]),
            per_dy / 60.0,
            |sum| sum,
        );
        // The stencil does not use the middle point, but it must be present.
        out.iter_mut().zip(&here[3..]).for_each(|(out, z)| *out += 0.0 * z);
        seven = sum_present(out);
    }
    [forward, area, seven]
}

/// Returns the areas of two triangles of these squared slopes over their projections, minus one each: √(1 + s) − 1 =
/// s/(√(1 + s) + 1), which does not cancel for gentle slopes, with one division for both.
fn excesses(s: f64, t: f64) -> f64 {
    let (p, q) = ((1.0 + s).sqrt() + 1.0, (1.0 + t).sqrt() + 1.0);
    (s * q + t * p) / (p * q)
}

/// Offsets of the seven-point stencil with non-zero weight.
const STEPS: [usize; 6] = [0, 1, 2, 4, 5, 6];

/// Sets `out` to `start(out)` plus the squares of (z₊₃ − 9z₊₂ + 45z₊₁ − 45z₋₁ + 9z₋₂ − z₋₃)·`scale`. This difference is
/// exact for polynomials of degree six. `z` contains a slice of heights for each of [`STEPS`].
fn add_square_difference(out: &mut [f64], z: [&[f64]; 6], scale: f64, start: impl Fn(f64) -> f64) {
    let n = out.len();
    let [a, b, c, d, e, f] = z.map(|z| &z[..n]);
    for i in 0..n {
        let difference = ((f[i] - a[i]) - 9.0 * (e[i] - b[i]) + 45.0 * (d[i] - c[i])) * scale;
        out[i] = start(out[i]) + difference * difference;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::map::Grid;
    use asperity_base::random;
    use ndarray::Array2;

    /// Computes the statistics from their definitions, point by point.
    fn direct(map: &HeightMap) -> [Option<f64>; 3] {
        let (z, grid) = (map.heights_m(), map.grid());
        let (ny, nx) = grid.shape();
        let mut values = [vec![], vec![], vec![]];
        for row in 0..ny {
            for column in 0..nx {
                if row + 1 < ny && column + 1 < nx {
                    let (a, b) = (z[[row, column]], z[[row, column + 1]]);
                    let (c, d) = (z[[row + 1, column]], z[[row + 1, column + 1]]);
                    values[0].push(((b - a) / grid.dx_m()).powi(2) + ((c - a) / grid.dy_m()).powi(2));
                    // Half the cross product of two edges, for each of the four triangles.
                    let triangle = |p: [f64; 3], q: [f64; 3]| {
                        let cross = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
                        0.5 * cross.iter().map(|c| c * c).sum::<f64>().sqrt()
                    };
                    let (dx, dy) = (grid.dx_m(), grid.dy_m());
                    let all = triangle([dx, 0.0, b - a], [0.0, dy, c - a])
                        + triangle([dx, 0.0, d - c], [0.0, dy, d - b])
                        + triangle([dx, 0.0, b - a], [0.0, dy, d - b])
                        + triangle([dx, 0.0, d - c], [0.0, dy, c - a]);
                    values[1].push(0.5 * all / (dx * dy) - 1.0);
                }
                if row >= 3 && row + 3 < ny && column >= 3 && column + 3 < nx && !z[[row, column]].is_nan() {
                    let weights = [-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0];
                    let of = |at: &dyn Fn(usize) -> f64| {
                        (0..7).filter(|i| *i != 3).map(|i| weights[i] * at(i)).sum::<f64>() / 60.0
                    };
                    let along_x = of(&|i| z[[row, column + i - 3]]) / grid.dx_m();
                    let along_y = of(&|i| z[[row + i - 3, column]]) / grid.dy_m();
                    values[2].push(along_x * along_x + along_y * along_y);
                }
            }
        }
        values.map(|values| {
            let present: Vec<f64> = values.into_iter().filter(|v| !v.is_nan()).collect();
            (!present.is_empty()).then(|| present.iter().sum::<f64>() / present.len() as f64)
        })
    }

    #[test]
    fn sums_by_rows_equal_the_definitions_with_missing_points() {
        for (nx, ny, missing) in [(23, 17, 0.0), (23, 17, 0.08), (9, 9, 0.0), (6, 30, 0.2), (2, 2, 0.0), (40, 7, 0.02)]
        {
            let mut stream = random::stream(16, "hybrid", nx as u64);
            let mut heights = random::standard_normal(&mut stream, nx * ny);
            let holes = random::standard_normal(&mut stream, nx * ny);
            let cut = if missing > 0.0 {
                asperity_base::distribution::standard_normal_quantile(missing)
            } else {
                f64::NEG_INFINITY
            };
            heights.iter_mut().zip(holes).filter(|(_, hole)| *hole < cut).for_each(|(z, _)| *z = f64::NAN);
            let grid = Grid::new(nx, ny, 0.8, 1.7).unwrap();
            let map = HeightMap::new(grid, Array2::from_shape_vec((ny, nx), heights).unwrap()).unwrap();
            let (found, wanted) = (hybrid(&map), direct(&map));
            let found = [
                found.gradient_forward.map(|g| g * g),
                found.developed_area_ratio,
                found.gradient_seven_points.map(|g| g * g),
            ];
            for (found, wanted) in found.into_iter().zip(wanted) {
                assert_eq!(found.is_some(), wanted.is_some(), "{nx} × {ny}");
                if let (Some(found), Some(wanted)) = (found, wanted) {
                    assert!((found / wanted - 1.0).abs() < 1e-12, "{nx} × {ny}: {found} {wanted}");
                }
            }
        }
    }
}
