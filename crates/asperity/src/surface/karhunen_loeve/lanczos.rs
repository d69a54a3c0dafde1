//! The largest eigenpairs of a symmetric operator known by its products alone.

use ndarray::{Array2, Axis, s};
use rayon::prelude::*;

use super::profile::{dense_eigenpairs, fix_sign};
use crate::random;
use crate::surface::GeneratorError;

/// Vectors multiplied at once. Symmetric maps have eigenvalues in pairs, which a single start vector misses.
const BLOCK: usize = 8;

/// Accuracy of [`largest_eigenpairs`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Stopping {
    /// Largest residual ‖Av − λv‖ over the first eigenvalue.
    pub(super) tolerance: f64,
    /// Most vectors in the subspace.
    pub(super) subspace: usize,
}

/// The `wanted` largest eigenvalues, falling, and unit eigenvectors as rows, by block Lanczos with full
/// reorthogonalisation from a seeded random block.
///
/// `apply` writes A·v into its second argument; it is called from several threads on different vectors.
///
/// # References
/// Golub & Underwood, in *Mathematical Software III* (1977) 361, <https://doi.org/10.1016/B978-0-12-587260-7.50018-2>.
pub(super) fn largest_eigenpairs(
    apply: &(dyn Fn(&[f64], &mut [f64]) + Sync),
    n: usize,
    wanted: usize,
    stopping: Stopping,
    seed: u64,
) -> Result<(Vec<f64>, Array2<f64>), GeneratorError> {
    let block = BLOCK.min(n);
    let capacity = stopping.subspace.clamp(wanted, n);
    let mut stream = random::stream(seed, "karhunen-loeve lanczos", 0);
    let draws = random::standard_normal(&mut stream, block * n);
    let mut start = Array2::from_shape_fn((block, n), |(i, j)| draws[i * n + j]);
    let mut basis = Array2::<f64>::zeros((0, n));
    orthonormalise(&mut start, &basis, &mut stream);
    let mut projected = Array2::<f64>::zeros((0, 0));
    let mut next_check = wanted + block;
    loop {
        let from = basis.nrows();
        // The last block is cut where the space is full.
        let count = start.nrows().min(n - from);
        append_rows(&mut basis, &start.slice(s![..count, ..]).to_owned());
        let size = basis.nrows();
        let product = |row: usize| {
            let mut out = vec![0.0; n];
            apply(&basis.row(row).to_vec(), &mut out);
            out
        };
        let products: Vec<Vec<f64>> = (from..size).into_par_iter().map(product).collect();
        let mut image = Array2::from_shape_fn((count, n), |(i, j)| products[i][j]);

        let columns = basis.dot(&image.t());
        let mut grown = Array2::<f64>::zeros((size, size));
        grown.slice_mut(s![..from, ..from]).assign(&projected);
        grown.slice_mut(s![.., from..]).assign(&columns);
        grown.slice_mut(s![from.., ..]).assign(&columns.t());
        projected = grown;

        image -= &columns.t().dot(&basis);
        let coupling = orthonormalise(&mut image, &basis, &mut stream);

        let full = size >= capacity;
        if size >= next_check || full {
            next_check = size + (size / 8).max(block);
            let (values, vectors) = dense_eigenpairs(size, |i, j| 0.5 * (projected[[i, j]] + projected[[j, i]]))?;
            // A·y = θ·y + (next block)ᵀ R s, with s the part of the Ritz vector in the last block.
            let residual = |j: usize| {
                let tail = vectors.slice(s![j, from..]).to_owned();
                coupling.dot(&tail).mapv(|v| v * v).sum().sqrt()
            };
            let scale = values[0].max(f64::MIN_POSITIVE);
            let residuals: Vec<f64> = (0..wanted.min(size)).map(|j| residual(j) / scale).collect();
            let worst = residuals.iter().fold(0.0_f64, |m, r| m.max(*r));
            if size >= n || (size >= wanted && worst <= stopping.tolerance) {
                let mut found = vectors.slice(s![..wanted, ..]).dot(&basis);
                found.rows_mut().into_iter().for_each(fix_sign);
                return Ok((values[..wanted].to_vec(), found));
            }
            if full {
                return Err(GeneratorError::NotConverged {
                    wanted,
                    converged: residuals.iter().filter(|r| **r <= stopping.tolerance).count(),
                    subspace: size,
                    residual: worst,
                    tolerance: stopping.tolerance,
                });
            }
        }
        start = image;
    }
}

/// Makes the rows of `block` orthonormal and orthogonal to `basis`; returns R with block_before = Rᵀ·block_after.
///
/// A row that vanishes, because the subspace is invariant, is replaced by a random one with zero coupling.
fn orthonormalise(block: &mut Array2<f64>, basis: &Array2<f64>, stream: &mut random::Stream) -> Array2<f64> {
    let (rows, n) = block.dim();
    let largest = block.rows().into_iter().fold(0.0_f64, |m, row| m.max(row.dot(&row).sqrt()));
    project_out(block, basis);
    let mut coupling = within_block(block, f64::EPSILON * largest);
    for i in 0..rows {
        if coupling[[i, i]] == 0.0 {
            let fresh = random::standard_normal(stream, n);
            block.row_mut(i).iter_mut().zip(fresh).for_each(|(out, value)| *out = value);
        }
    }
    // Once more: the first pass leaves what rounding brought in, and the random rows.
    project_out(block, basis);
    let second = within_block(block, 0.0);
    for i in 0..rows {
        if coupling[[i, i]] == 0.0 {
            coupling.row_mut(i).fill(0.0);
        }
    }
    second.dot(&coupling)
}

/// Subtracts the part of each row that lies in the span of the orthonormal `basis`.
fn project_out(block: &mut Array2<f64>, basis: &Array2<f64>) {
    if basis.nrows() > 0 {
        let overlap = block.dot(&basis.t());
        *block -= &overlap.dot(basis);
    }
}

/// Modified Gram–Schmidt among the rows; rows of length up to `vanishing` get zero on the diagonal of R and stay.
fn within_block(block: &mut Array2<f64>, vanishing: f64) -> Array2<f64> {
    let rows = block.nrows();
    let mut coupling = Array2::<f64>::zeros((rows, rows));
    for i in 0..rows {
        let mut row = block.row(i).to_owned();
        let start = row.dot(&row).sqrt();
        for j in 0..i {
            if coupling[[j, j]] > 0.0 {
                let overlap = block.row(j).dot(&row);
                row.scaled_add(-overlap, &block.row(j));
                coupling[[j, i]] = overlap;
            }
        }
        let norm = row.dot(&row).sqrt();
        if norm > vanishing && norm > 1e-13 * start {
            coupling[[i, i]] = norm;
            row /= norm;
        }
        block.row_mut(i).assign(&row);
    }
    coupling
}

fn append_rows(basis: &mut Array2<f64>, rows: &Array2<f64>) {
    // Appending along the first axis of two row-major arrays of equal width cannot fail.
    let appended = basis.append(Axis(0), rows.view());
    debug_assert!(appended.is_ok());
}

#[cfg(test)]
mod tests {
    use super::*;

    const STOPPING: Stopping = Stopping { tolerance: 1e-10, subspace: usize::MAX };

    #[test]
    fn repeated_eigenvalues_are_all_found() {
        // diag(10, 10, 10, 9, 9, 1/k …): a single start vector would see 10 and 9 once.
        let n = 300;
        let diagonal = |i: usize| match i {
            7 | 50 | 299 => 10.0,
            0 | 120 => 9.0,
            _ => 1.0 / (i as f64),
        };
        let apply = |v: &[f64], out: &mut [f64]| {
            for (i, (o, x)) in out.iter_mut().zip(v).enumerate() {
                *o = diagonal(i) * x;
            }
        };
        let (values, vectors) = largest_eigenpairs(&apply, n, 7, STOPPING, 1).unwrap();
        for (value, wanted) in values.iter().zip([10.0, 10.0, 10.0, 9.0, 9.0, 1.0, 0.5]) {
            assert!((value - wanted).abs() < 1e-9, "{values:?}");
        }
        let gram = vectors.dot(&vectors.t());
        assert!(gram.indexed_iter().all(|((i, j), v)| (v - f64::from(u8::from(i == j))).abs() < 1e-12));
    }

    #[test]
    fn an_operator_of_low_rank_is_exhausted_without_harm() {
        let n = 64;
        let apply = |v: &[f64], out: &mut [f64]| {
            let sum: f64 = v.iter().sum();
            out.fill(sum);
        };
        let (values, vectors) = largest_eigenpairs(&apply, n, 5, STOPPING, 2).unwrap();
        assert!((values[0] - 64.0).abs() < 1e-10 && values[1..].iter().all(|v| v.abs() < 1e-10), "{values:?}");
        assert!(vectors.row(0).iter().all(|v| (v - 0.125).abs() < 1e-12));
        let gram = vectors.dot(&vectors.t());
        assert!(gram.indexed_iter().all(|((i, j), v)| (v - f64::from(u8::from(i == j))).abs() < 1e-12));
    }

    #[test]
    fn too_small_a_subspace_is_an_error_that_says_so() {
        let apply = |v: &[f64], out: &mut [f64]| {
            for (i, (o, x)) in out.iter_mut().zip(v).enumerate() {
                *o = x * (1.0 + 1e-3 * i as f64);
            }
        };
        let stopping = Stopping { tolerance: 1e-12, subspace: 30 };
        let error = largest_eigenpairs(&apply, 400, 20, stopping, 3).unwrap_err();
        assert!(matches!(error, GeneratorError::NotConverged { wanted: 20, .. }), "{error}");
    }
}
