//! Gaussian elimination.

use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayView2, Axis, s};

use super::triangular::solve_lower;

/// Returns the solution x of A x = b by Gaussian elimination with row pivoting. For a singular matrix its values are not
/// finite.
///
/// # Panics
/// The matrix is not square, or the length of the right-hand side is wrong.
pub fn dense_solution(matrix: ArrayView2<'_, f64>, right: &[f64]) -> Vec<f64> {
    let n = right.len();
    assert_eq!(matrix.dim(), (n, n), "{n} values on the right-hand side");
    let mut rows = Array2::from_shape_fn((n, n + 1), |(i, j)| if j < n { matrix[[i, j]] } else { right[i] });
    eliminate(&mut rows, 0, n + 1);
    let mut solution: Vec<f64> = rows.column(n).to_vec();
    for i in (0..n).rev() {
        solution[i] -= (i + 1..n).map(|k| rows[[i, k]] * solution[k]).sum::<f64>();
    }
    solution
}

/// Replaces some columns, from the diagonal on, by those of L and of U in P A = L U. U has a unit diagonal.
fn eliminate(rows: &mut Array2<f64>, start: usize, end: usize) {
    if end - start == 1 {
        let column = rows.slice(s![start.., start]);
        let largest = column.iter().enumerate().fold((0, 0.0), |(place, largest), (i, value): (usize, &f64)| {
            if value.abs() > largest { (i, value.abs()) } else { (place, largest) }
        });
        if largest.0 > 0 {
            let (mut row, mut pivot) = rows.multi_slice_mut((s![start, ..], s![start + largest.0, ..]));
            row.iter_mut().zip(&mut pivot).for_each(|(a, b)| std::mem::swap(a, b));
        }
        return;
    }
    let width = (end - start) / 2;
    eliminate(rows, start, start + width);
    let (left, right) = rows.slice_mut(s![start.., start..end]).split_at(Axis(1), width);
    let (mut top, mut bottom) = right.split_at(Axis(0), width);
    let (head, tail) = left.view().split_at(Axis(0), width);
    solve_lower(head, top.view_mut());
    general_mat_mul(-1.0, &tail, &top, 1.0, &mut bottom);
    eliminate(rows, start + width, end);
}
