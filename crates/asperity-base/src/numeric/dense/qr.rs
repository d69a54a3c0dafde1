//! QR factorisation and the condition of a triangle.

use std::array;

use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};

use super::BLOCK;
use super::norm::spectral_norm;
use super::reflectors::{Reflectors, reflector};
use super::solve_upper;
use crate::wide::{Kernel, wide};

/// Columns that are reflected one by one.
const LANES: usize = 8;

/// Thin QR factorisation A = Q R of a matrix with at least as many rows as columns, by Householder reflections.
#[derive(Debug, Clone)]
pub struct Qr {
    /// Orthonormal columns, of the shape of the matrix. They are orthonormal for a singular matrix as well.
    pub q: Array2<f64>,
    /// Upper triangle R, with zeros below it.
    pub r: Array2<f64>,
}

impl Qr {
    /// Factorises a matrix, in its own memory if it is in standard layout.
    ///
    /// # Panics
    /// There are fewer rows than columns.
    pub fn new(matrix: Array2<f64>) -> Self {
        let (rows, columns) = matrix.dim();
        assert!(rows >= columns, "{rows} rows, {columns} columns");
        // Holds what is left to be factorised, then the unit vectors of the reflections, at last Q.
        let mut q = if matrix.is_standard_layout() { matrix } else { matrix.as_standard_layout().into_owned() };
        let mut r = Array2::zeros((columns, columns));
        let mut middles = Vec::new();
        for start in (0..columns).step_by(BLOCK) {
            let end = (start + BLOCK).min(columns);
            let (mut panel, mut right) = q.slice_mut(s![start.., start..]).split_at(Axis(1), end - start);
            let mut v = Array2::zeros(panel.dim());
            reflect_panel(panel.view_mut(), v.view_mut());
            let factor = Reflectors::new(v);
            factor.apply_transposed(right.view_mut());
            for i in start..end {
                r.slice_mut(s![i, i..end]).assign(&panel.slice(s![i - start, i - start..]));
            }
            r.slice_mut(s![start..end, end..]).assign(&right.slice(s![..end - start, ..]));
            panel.assign(&factor.v);
            middles.push((start, end, factor.t));
        }
        for (start, end, t) in middles.into_iter().rev() {
            let v = q.slice(s![start.., start..end]).to_owned();
            q.slice_mut(s![.., start..end]).fill(0.0);
            q.slice_mut(s![start..end, start..end]).diag_mut().fill(1.0);
            Reflectors { v, t }.apply(q.slice_mut(s![start.., start..]));
        }
        Self { q, r }
    }
}

/// Makes a panel upper triangular by reflections, whose unit vectors become the columns of `v`, which are zero.
fn reflect_panel(mut panel: ArrayViewMut2<'_, f64>, mut v: ArrayViewMut2<'_, f64>) {
    let columns = panel.ncols();
    if columns > LANES {
        let half = columns / 2;
        let (left, mut right) = panel.split_at(Axis(1), half);
        reflect_panel(left, v.slice_mut(s![.., ..half]));
        Reflectors::new(v.slice(s![.., ..half]).to_owned()).apply_transposed(right.view_mut());
        reflect_panel(right.slice_mut(s![half.., ..]), v.slice_mut(s![half.., half..]));
        return;
    }
    let mut block = vec![[0.0; LANES]; panel.nrows()];
    for (own, row) in block.iter_mut().zip(panel.rows()) {
        own.iter_mut().zip(row).for_each(|(own, value)| *own = *value);
    }
    for j in 0..columns {
        let mut vector: Vec<f64> = block[j..].iter().map(|row| row[j]).collect();
        let image = reflector(&mut vector);
        wide::<Reflect, _>((&mut block[j..], &vector[..], j + 1));
        v.slice_mut(s![j.., j]).iter_mut().zip(&vector).for_each(|(v, x)| *v = *x);
        block[j][j] = image;
    }
    for (own, mut row) in block.iter().zip(panel.rows_mut()) {
        row.iter_mut().zip(own).for_each(|(value, own)| *value = *own);
    }
}

/// Kernel that reflects the columns from a given one on.
struct Reflect;

impl<'a> Kernel<(&'a mut [[f64; LANES]], &'a [f64], usize)> for Reflect {
    type Output = ();

    #[inline(always)]
    fn run((rows, vector, from): (&'a mut [[f64; LANES]], &'a [f64], usize)) {
        // Several sums, since each would wait for its last addition.
        let mut sums = [[0.0; LANES]; 4];
        for (rows, v) in rows.chunks(4).zip(vector.chunks(4)) {
            for ((sum, row), v) in sums.iter_mut().zip(rows).zip(v) {
                for lane in 0..LANES {
                    sum[lane] += v * row[lane];
                }
            }
        }
        let projections: [f64; LANES] = array::from_fn(|lane| {
            if lane < from { 0.0 } else { 2.0 * (sums[0][lane] + sums[1][lane] + sums[2][lane] + sums[3][lane]) }
        });
        for (row, v) in rows.iter_mut().zip(vector) {
            for lane in 0..LANES {
                row[lane] -= v * projections[lane];
            }
        }
    }
}

/// Returns the ratio of the largest to the smallest singular value of an upper triangle, 1 for an empty one. It is
/// infinite for a singular triangle and where it cannot be computed.
pub fn triangular_condition(triangle: ArrayView2<'_, f64>) -> f64 {
    let n = triangle.nrows();
    if n == 0 {
        return 1.0;
    }
    let largest = triangle.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    let scaled = triangle.mapv(|r| r / largest);
    let mut inverse = Array2::eye(n);
    solve_upper(scaled.view(), inverse.view_mut());
    // The extreme singular values are the largest ones of the triangle and of its inverse, which are accurate.
    let condition = spectral_norm(&scaled) * spectral_norm(&inverse);
    if condition.is_finite() { condition } else { f64::INFINITY }
}
