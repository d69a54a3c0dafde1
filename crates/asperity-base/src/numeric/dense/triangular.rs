//! Triangular systems with many right-hand sides.

use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};

use super::{BLOCK, half};
use crate::wide::{Kernel, wide};

/// Number of right-hand sides that are substituted together.
const COLUMNS: usize = 64;

/// Solves U X = B; the solution replaces the right-hand sides, the columns of `right`. Only the upper triangle is read.
///
/// A zero on the diagonal gives values that are not finite.
pub fn solve_upper(matrix: ArrayView2<'_, f64>, mut right: ArrayViewMut2<'_, f64>) {
    // With rows and columns in reverse order the triangle is a lower one.
    solve_lower(matrix.slice(s![..;-1, ..;-1]), right.slice_mut(s![..;-1, ..]));
}

/// Solves L X = B in place as [`solve_upper`]. Only the lower triangle is read.
pub(super) fn solve_lower(matrix: ArrayView2<'_, f64>, mut right: ArrayViewMut2<'_, f64>) {
    let n = matrix.nrows();
    if n > BLOCK {
        let half = half(n);
        let (mut top, mut bottom) = right.split_at(Axis(0), half);
        solve_lower(matrix.slice(s![..half, ..half]), top.view_mut());
        general_mat_mul(-1.0, &matrix.slice(s![half.., ..half]), &top, 1.0, &mut bottom);
        solve_lower(matrix.slice(s![half.., half..]), bottom);
        return;
    }
    let triangle: Vec<f64> = matrix.iter().copied().collect();
    for mut columns in right.axis_chunks_iter_mut(Axis(1), COLUMNS) {
        let mut rows = Array2::zeros((n, COLUMNS));
        let own = s![.., ..columns.ncols()];
        rows.slice_mut(own).assign(&columns);
        if let Some(rows) = rows.as_slice_mut() {
            wide::<Substitute, _>((&triangle[..], rows));
        }
        columns.assign(&rows.slice(own));
    }
}

/// Kernel that solves L X = B for rows of [`COLUMNS`] values.
struct Substitute;

impl<'a> Kernel<(&'a [f64], &'a mut [f64])> for Substitute {
    type Output = ();

    #[inline(always)]
    fn run((triangle, rows): (&'a [f64], &'a mut [f64])) {
        let rows = rows.as_chunks_mut::<COLUMNS>().0;
        let n = rows.len();
        for i in 0..n {
            let (solved, [row, ..]) = rows.split_at_mut(i) else { return };
            for (factor, other) in triangle[i * n..].iter().zip(solved) {
                for lane in 0..COLUMNS {
                    row[lane] -= factor * other[lane];
                }
            }
            for lane in 0..COLUMNS {
                row[lane] /= triangle[i * n + i];
            }
        }
    }
}
