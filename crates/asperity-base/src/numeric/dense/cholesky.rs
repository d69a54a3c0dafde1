//! Cholesky factorisation.

use ndarray::{Array2, ArrayViewMut2, s};

use super::triangular::solve_lower;
use super::{BLOCK, half, subtract_from_lower};
use crate::numeric::dot;
use crate::wide::{Kernel, wide};

/// Number of partial sums of a product.
const LANES: usize = 16;

/// Factor L of a symmetric positive definite matrix A = L Lᵀ.
#[derive(Debug, Clone)]
pub struct Cholesky {
    /// Rows of L; entries above the diagonal have no meaning.
    lower: Array2<f64>,
}

impl Cholesky {
    /// Factorises a matrix in standard layout, whose lower triangle is read. Returns `None` unless it is numerically
    /// positive definite.
    ///
    /// # Panics
    /// The matrix is not square or not in standard layout.
    pub fn new(mut matrix: Array2<f64>) -> Option<Self> {
        assert!(matrix.is_square() && matrix.is_standard_layout(), "shape {:?}", matrix.dim());
        factorise(matrix.view_mut()).then_some(Self { lower: matrix })
    }

    /// Returns the solution x of A x = b.
    ///
    /// # Panics
    /// The length of the right-hand side is wrong.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let n = self.lower.nrows();
        assert_eq!(right.len(), n, "the matrix has {n} rows");
        let mut solution = right.to_vec();
        if let Some(lower) = self.lower.as_slice() {
            wide::<Substitute, _>((lower, &mut solution[..]));
        }
        solution
    }

    /// Returns the logarithm of the determinant of A.
    pub fn log_determinant(&self) -> f64 {
        2.0 * self.lower.diag().iter().map(|pivot| pivot.ln()).sum::<f64>()
    }
}

/// Replaces the lower triangle of a matrix by its factor. Returns `false` if a pivot is not positive.
fn factorise(mut matrix: ArrayViewMut2<'_, f64>) -> bool {
    let n = matrix.nrows();
    if n <= BLOCK {
        return factorise_block(matrix);
    }
    let half = half(n);
    let (mut first, mut corner, mut rest) =
        matrix.multi_slice_mut((s![..half, ..half], s![half.., ..half], s![half.., half..]));
    if !factorise(first.view_mut()) {
        return false;
    }
    solve_lower(first.view(), corner.view_mut().reversed_axes());
    subtract_from_lower(rest.view_mut(), corner.view(), corner.view());
    factorise(rest)
}

fn factorise_block(mut matrix: ArrayViewMut2<'_, f64>) -> bool {
    for j in 0..matrix.nrows() {
        for i in j..matrix.nrows() {
            let product: f64 = (0..j).map(|k| matrix[[i, k]] * matrix[[j, k]]).sum();
            let rest = matrix[[i, j]] - product;
            if i == j && !(rest > 0.0 && rest.is_finite()) {
                return false;
            }
            matrix[[i, j]] = if i == j { rest.sqrt() } else { rest / matrix[[j, j]] };
        }
    }
    true
}

/// Kernel that solves L Lᵀ x = b in place.
struct Substitute;

impl<'a> Kernel<(&'a [f64], &'a mut [f64])> for Substitute {
    type Output = ();

    #[inline(always)]
    fn run((lower, x): (&'a [f64], &'a mut [f64])) {
        let n = x.len();
        for i in 0..n {
            let row = &lower[i * n..=i * n + i];
            let ((a, a_rest), (b, b_rest)) = (row[..i].as_chunks::<LANES>(), x[..i].as_chunks::<LANES>());
            let mut sums = [0.0; LANES];
            for (a, b) in a.iter().zip(b) {
                for lane in 0..LANES {
                    sums[lane] += a[lane] * b[lane];
                }
            }
            x[i] = (x[i] - dot(a_rest, b_rest) - sums.iter().sum::<f64>()) / row[i];
        }
        for i in (0..n).rev() {
            let row = &lower[i * n..=i * n + i];
            let value = x[i] / row[i];
            x[i] = value;
            x[..i].iter_mut().zip(row).for_each(|(x, a)| *x -= value * a);
        }
    }
}
