//! QR factorisation and the condition of a triangle.

use ndarray::{Array2, ArrayView2, Axis, s};

use super::BLOCK;
use super::eigen::largest_eigenvalue;
use super::reflectors::{Reflectors, reflector};
use super::solve_upper;
use crate::wide::{Kernel, wide};

/// Thin QR factorisation A = Q R of a matrix with at least as many rows as columns, by Householder reflections.
#[derive(Debug, Clone)]
pub struct Qr {
    /// Orthonormal columns, of the shape of the matrix. They are orthonormal for a singular matrix as well.
    pub q: Array2<f64>,
    /// Upper triangle R, with zeros below it.
    pub r: Array2<f64>,
}

impl Qr {
    /// Factorises a matrix.
    ///
    /// # Panics
    /// There are fewer rows than columns.
    pub fn new(matrix: ArrayView2<'_, f64>) -> Self {
        let (rows, columns) = matrix.dim();
        assert!(rows >= columns, "{rows} rows, {columns} columns");
        let mut rest = matrix.as_standard_layout().into_owned();
        let mut factors = Vec::new();
        for start in (0..columns).step_by(BLOCK) {
            let end = (start + BLOCK).min(columns);
            let (mut panel, right) = rest.slice_mut(s![start.., start..]).split_at(Axis(1), end - start);
            let mut block = vec![[0.0; BLOCK]; rows - start];
            for (own, row) in block.iter_mut().zip(panel.rows()) {
                own.iter_mut().zip(row).for_each(|(own, value)| *own = *value);
            }
            let mut v = Array2::zeros(panel.dim());
            for j in 0..end - start {
                let mut vector: Vec<f64> = block[j..].iter().map(|row| row[j]).collect();
                let image = reflector(&mut vector);
                wide::<Reflect, _>((&mut block[j..], &vector[..], j + 1));
                v.slice_mut(s![j.., j]).iter_mut().zip(&vector).for_each(|(v, x)| *v = *x);
                block[j][j] = image;
            }
            for (own, mut row) in block.iter().zip(panel.rows_mut()) {
                row.iter_mut().zip(own).for_each(|(value, own)| *value = *own);
            }
            let factor = Reflectors::new(v);
            factor.apply_transposed(right);
            factors.push(factor);
        }
        let r = Array2::from_shape_fn((columns, columns), |(i, j)| if i <= j { rest[[i, j]] } else { 0.0 });
        let mut q = rest;
        q.fill(0.0);
        q.diag_mut().fill(1.0);
        for (number, factor) in factors.iter().enumerate().rev() {
            factor.apply(q.slice_mut(s![number * BLOCK.., number * BLOCK..]));
        }
        Self { q, r }
    }
}

/// Kernel that reflects the columns from a given one on.
struct Reflect;

impl<'a> Kernel<(&'a mut [[f64; BLOCK]], &'a [f64], usize)> for Reflect {
    type Output = ();

    #[inline(always)]
    fn run((rows, vector, from): (&'a mut [[f64; BLOCK]], &'a [f64], usize)) {
        let mut projections = [0.0; BLOCK];
        for (row, v) in rows.iter().zip(vector) {
            for lane in 0..BLOCK {
                projections[lane] += v * row[lane];
            }
        }
        for (lane, projection) in projections.iter_mut().enumerate() {
            *projection *= if lane < from { 0.0 } else { 2.0 };
        }
        for (row, v) in rows.iter_mut().zip(vector) {
            for lane in 0..BLOCK {
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
    if largest == 0.0 || inverse.iter().any(|value| !value.is_finite()) {
        return f64::INFINITY;
    }
    // The extreme singular values are the largest ones of the triangle and of its inverse, which are accurate.
    let norm_square = |matrix: &Array2<f64>| largest_eigenvalue(matrix.t().dot(matrix));
    match (norm_square(&scaled), norm_square(&inverse)) {
        (Ok(own), Ok(other)) if (own * other).is_finite() => own.sqrt() * other.sqrt(),
        _ => f64::INFINITY,
    }
}
