//! Slopes and developed area.

use ndarray::Array2;

use crate::map::HeightMap;

/// Root-mean-square gradient by forward differences.
pub(super) fn gradient_forward(map: &HeightMap) -> Option<f64> {
    let (z, grid) = (map.heights_m(), map.grid());
    let squares = (0..grid.ny() - 1).flat_map(|row| {
        (0..grid.nx() - 1).map(move |column| {
            let here = z[[row, column]];
            let along_x = (z[[row, column + 1]] - here) / grid.dx_m();
            let along_y = (z[[row + 1, column]] - here) / grid.dy_m();
            along_x * along_x + along_y * along_y
        })
    });
    mean_present(squares).map(f64::sqrt)
}

/// Root-mean-square gradient by the differences (z₊₃ − 9z₊₂ + 45z₊₁ − 45z₋₁ + 9z₋₂ − z₋₃)/(60 Δ), exact for polynomials
/// of degree six.
pub(super) fn gradient_seven_points(map: &HeightMap) -> Option<f64> {
    let (z, grid) = (map.heights_m(), map.grid());
    let stencil = |at: &dyn Fn(usize) -> f64| {
        (at(6) - at(0)) / 60.0 - 9.0 * (at(5) - at(1)) / 60.0 + 45.0 * (at(4) - at(2)) / 60.0
    };
    let squares = (3..grid.ny().saturating_sub(3)).flat_map(|row| {
        (3..grid.nx().saturating_sub(3)).filter(move |column| !z[[row, *column]].is_nan()).map(move |column| {
            let along_x = stencil(&|i| z[[row, column + i - 3]]) / grid.dx_m();
            let along_y = stencil(&|i| z[[row + i - 3, column]]) / grid.dy_m();
            along_x * along_x + along_y * along_y
        })
    });
    mean_present(squares).map(f64::sqrt)
}

/// Triangulated area over projected area, less one; the mean of both diagonals of every cell.
pub(super) fn developed_area_ratio(map: &HeightMap) -> Option<f64> {
    let (z, grid): (&Array2<f64>, _) = (map.heights_m(), map.grid());
    // √(1 + s²) − 1 without cancellation for gentle slopes.
    let excess = |along_x: f64, along_y: f64| {
        let square = along_x * along_x + along_y * along_y;
        square / ((1.0 + square).sqrt() + 1.0)
    };
    let cells = (0..grid.ny() - 1).flat_map(|row| {
        (0..grid.nx() - 1).map(move |column| {
            let (a, b) = (z[[row, column]], z[[row, column + 1]]);
            let (c, d) = (z[[row + 1, column]], z[[row + 1, column + 1]]);
            let (top, bottom) = ((b - a) / grid.dx_m(), (d - c) / grid.dx_m());
            let (left, right) = ((c - a) / grid.dy_m(), (d - b) / grid.dy_m());
            // Diagonal b–c makes the triangles (a, b, c) and (d, c, b); diagonal a–d makes (b, a, d) and (c, d, a).
            0.25 * (excess(top, left) + excess(bottom, right) + excess(top, right) + excess(bottom, left))
        })
    });
    mean_present(cells)
}

fn mean_present(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) =
        values.filter(|v| !v.is_nan()).fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}
