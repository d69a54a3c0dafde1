//! Reduction of symmetric matrices to tridiagonal ones.

use ndarray::{Array2, s};

use super::reflectors::{Reflectors, reflector};
use super::{BLOCK, subtract_from_lower};
use crate::numeric::dot;
use crate::wide::{Kernel, wide};

/// Number of rows and of partial sums in the product of a matrix with a vector.
const ROWS: usize = 4;
const LANES: usize = 8;

/// Tridiagonal matrix T = Qᵀ A Q.
#[derive(Debug, Clone)]
pub(super) struct Tridiagonal {
    pub(super) diagonal: Vec<f64>,
    /// Entries beside the diagonal, one fewer.
    pub(super) beside: Vec<f64>,
    /// Factors of Q in their order, with the first row on which each acts.
    pub(super) factors: Vec<(usize, Reflectors)>,
}

impl Tridiagonal {
    /// Reduces a symmetric matrix in standard layout, whose lower triangle is read.
    ///
    /// # References
    /// Dongarra, Hammarling & Sorensen, *J. Comput. Appl. Math.* **27** (1989) 215,
    /// <https://doi.org/10.1016/0377-0427(89)90367-1>.
    pub(super) fn new(mut matrix: Array2<f64>) -> Self {
        let n = matrix.nrows();
        let (mut diagonal, mut beside, mut factors) = (Vec::new(), Vec::new(), Vec::new());
        for start in (0..n.saturating_sub(1)).step_by(BLOCK) {
            let end = (start + BLOCK).min(n - 1);
            // The matrix less V Wᵀ + W Vᵀ is the reduced one. Each row has BLOCK values of V, then of W.
            let mut update = vec![[0.0; 2 * BLOCK]; n - start];
            for j in start..end {
                let number = j - start;
                let own = exchanged(&update[number]);
                let mut column = matrix.slice(s![j.., j]).to_vec();
                wide::<Subtract, _>((&update[number..], &own, &mut column[..]));
                diagonal.push(column[0]);
                let v = &mut column[1..];
                beside.push(reflector(v));
                let mut image = vec![0.0; v.len()];
                if let Some(values) = matrix.as_slice() {
                    wide::<Product, _>((&values[(j + 1) * n + j + 1..], n, &*v, &mut image[..]));
                }
                let sums = wide::<Project, _>((&update[number + 1..], &*v));
                wide::<Subtract, _>((&update[number + 1..], &exchanged(&sums), &mut image[..]));
                let along = dot(v, &image);
                for ((row, v), p) in update[number + 1..].iter_mut().zip(&*v).zip(&image) {
                    row[number] = *v;
                    row[BLOCK + number] = 2.0 * (p - along * v);
                }
            }
            let rest = &update[end - start..];
            let x = Array2::from_shape_fn((rest.len(), 2 * BLOCK), |(i, k)| rest[i][k]);
            let y = Array2::from_shape_fn(x.dim(), |(i, k)| rest[i][(k + BLOCK) % (2 * BLOCK)]);
            subtract_from_lower(matrix.slice_mut(s![end.., end..]), x.view(), y.view());
            let v = Array2::from_shape_fn((n - start - 1, end - start), |(i, k)| update[i + 1][k]);
            factors.push((start + 1, Reflectors::new(v)));
        }
        diagonal.extend(matrix.diag().last());
        Self { diagonal, beside, factors }
    }
}

/// Exchanges the values of V and of W in a row.
fn exchanged(row: &[f64; 2 * BLOCK]) -> [f64; 2 * BLOCK] {
    let mut result = *row;
    result.rotate_left(BLOCK);
    result
}

/// Kernel that returns the products Vᵀv and Wᵀv.
struct Project;

impl<'a> Kernel<(&'a [[f64; 2 * BLOCK]], &'a [f64])> for Project {
    type Output = [f64; 2 * BLOCK];

    #[inline(always)]
    fn run((update, v): (&'a [[f64; 2 * BLOCK]], &'a [f64])) -> Self::Output {
        let mut sums = [0.0; 2 * BLOCK];
        for (row, v) in update.iter().zip(v) {
            sums = std::array::from_fn(|lane| sums[lane] + row[lane] * v);
        }
        sums
    }
}

/// Kernel that subtracts the products of all rows with a vector.
struct Subtract;

impl<'a> Kernel<(&'a [[f64; 2 * BLOCK]], &'a [f64; 2 * BLOCK], &'a mut [f64])> for Subtract {
    type Output = ();

    #[inline(always)]
    fn run((update, vector, image): (&'a [[f64; 2 * BLOCK]], &'a [f64; 2 * BLOCK], &'a mut [f64])) {
        for (row, image) in update.iter().zip(image) {
            let mut sums = [0.0; LANES];
            for (a, b) in row.as_chunks::<LANES>().0.iter().zip(vector.as_chunks::<LANES>().0) {
                sums = std::array::from_fn(|lane| sums[lane] + a[lane] * b[lane]);
            }
            *image -= sums.iter().sum::<f64>();
        }
    }
}

/// Kernel that adds the product of a symmetric matrix and a vector. The lower triangle is read; its rows are a stride
/// apart.
struct Product;

impl<'a> Kernel<(&'a [f64], usize, &'a [f64], &'a mut [f64])> for Product {
    type Output = ();

    #[inline(always)]
    fn run((matrix, stride, v, image): (&'a [f64], usize, &'a [f64], &'a mut [f64])) {
        for start in (0..v.len()).step_by(ROWS) {
            let end = (start + ROWS).min(v.len());
            // The rows of the block up to its diagonal, in multiples of the lanes.
            let whole = if end == start + ROWS { start - start % LANES } else { 0 };
            let row = |i: usize| &matrix[i * stride..=i * stride + i];
            if whole > 0 {
                let [a, b, c, d] = [0, 1, 2, 3].map(|r| row(start + r)[..whole].as_chunks::<LANES>().0.iter());
                let factors = [0, 1, 2, 3].map(|r| v[start + r]);
                let mut sums = [[0.0; LANES]; ROWS];
                let (v, p) = (v[..whole].as_chunks::<LANES>().0, image[..whole].as_chunks_mut::<LANES>().0);
                for (((((v, p), a), b), c), d) in v.iter().zip(p).zip(a).zip(b).zip(c).zip(d) {
                    for (row, sum) in [a, b, c, d].into_iter().zip(&mut sums) {
                        *sum = std::array::from_fn(|lane| sum[lane] + row[lane] * v[lane]);
                    }
                    for (row, factor) in [a, b, c, d].into_iter().zip(factors) {
                        *p = std::array::from_fn(|lane| p[lane] + row[lane] * factor);
                    }
                }
                for (image, sums) in image[start..end].iter_mut().zip(&sums) {
                    *image += sums.iter().sum::<f64>();
                }
            }
            for i in start..end {
                let row = row(i);
                let mut sum = row[i] * v[i];
                for ((a, v_k), p) in row[whole..i].iter().zip(&v[whole..i]).zip(&mut image[whole..i]) {
                    sum += a * v_k;
                    *p += a * v[i];
                }
                image[i] += sum;
            }
        }
    }
}
