//! The design matrix from which terms are selected.

use ndarray::{ArrayView2, CowArray, Ix2};

use super::error::SparseError;
use asperity_base::blocks;
use asperity_base::wide::{Kernel, wide};

/// Fraction of a length that counts as rounding.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Number of columns whose products are summed together; they stay in the first-level cache.
const BLOCK: usize = 2048;

/// Number of rows that are added at a time.
const ROWS: usize = 8;

/// Candidate columns, shape `[samples K, candidates P]`, with their means and lengths. P > K is allowed.
///
/// A column that is constant and non-zero on all samples belongs to every model, and candidates are compared after
/// subtracting their means. Without such a column nothing is subtracted. Columns without variation are never selected,
/// and of linearly dependent columns only the first enters. Rows may be repeated, but leave-one-out errors are then too
/// small because a copy of the left-out row remains.
#[derive(Debug)]
pub struct Candidates<'a> {
    /// Row-major.
    design: CowArray<'a, f64, Ix2>,
    means: Vec<f64>,
    /// Lengths after subtracting the mean; zero for columns that cannot be selected.
    norms: Vec<f64>,
    constant: Option<usize>,
}

impl<'a> Candidates<'a> {
    /// Borrows a matrix in standard layout, and copies a matrix in any other layout.
    ///
    /// # Errors
    /// There are fewer than three samples, or a value is not finite.
    pub fn new(design: ArrayView2<'a, f64>) -> Result<Self, SparseError> {
        let (samples, columns) = design.dim();
        if samples < 3 {
            return Err(SparseError::TooFewSamples { samples });
        }
        if let Some(sample) = design.rows().into_iter().position(|row| row.iter().any(|a| !a.is_finite())) {
            return Err(SparseError::NotFinite { sample });
        }
        let design = if design.is_standard_layout() {
            CowArray::from(design)
        } else {
            CowArray::from(design.as_standard_layout().into_owned())
        };
        let n = samples as f64;
        let mut means = vec![0.0; columns];
        let mut squares = vec![0.0; columns];
        // Differences from the first row are exactly zero if a column is constant.
        let first = design.row(0);
        for row in design.rows() {
            for (((mean, square), a), first) in means.iter_mut().zip(&mut squares).zip(row).zip(first) {
                *mean += (a - first) / n;
                *square += a * a;
            }
        }
        means.iter_mut().zip(first).for_each(|(mean, first)| *mean += first);
        let mut norms = vec![0.0; columns];
        for row in design.rows() {
            norms.iter_mut().zip(&means).zip(row).for_each(|((norm, mean), a)| *norm += (a - mean).powi(2));
        }
        for (norm, square) in norms.iter_mut().zip(&squares) {
            *norm = if norm.sqrt() <= ROUNDING * square.sqrt() { 0.0 } else { norm.sqrt() };
        }
        let constant = (0..columns).find(|&j| norms[j] == 0.0 && squares[j] > 0.0);
        if constant.is_none() {
            means.fill(0.0);
            norms = squares.into_iter().map(f64::sqrt).collect();
        }
        Ok(Self { design, means, norms, constant })
    }

    /// Returns the number of samples K.
    pub fn samples(&self) -> usize {
        self.design.nrows()
    }

    /// Returns the number of columns P.
    pub fn columns(&self) -> usize {
        self.design.ncols()
    }

    /// Returns the constant column.
    pub fn constant(&self) -> Option<usize> {
        self.constant
    }

    /// Returns the matrix.
    pub(super) fn design(&self) -> ArrayView2<'_, f64> {
        self.design.view()
    }

    /// Returns the number of columns that can be selected.
    pub(super) fn selectable(&self) -> usize {
        self.norms.iter().filter(|norm| **norm > 0.0).count()
    }

    /// Returns the length of a column, less its mean if there is a constant; zero for columns that cannot be selected.
    pub(super) fn norm(&self, column: usize) -> f64 {
        self.norms[column]
    }

    /// Copies a column.
    pub(super) fn fill_column(&self, column: usize, values: &mut [f64]) {
        values.iter_mut().zip(self.design.column(column)).for_each(|(value, a)| *value = *a);
    }

    /// Computes (x_j − x̄_j)ᵀv/‖x_j − x̄_j‖ for all columns and a vector v; zero for columns that cannot be selected.
    pub(super) fn correlate(&self, vector: &[f64], products: &mut [f64]) {
        let columns = self.columns();
        // `new` makes the rows contiguous.
        let Some(design) = self.design.as_slice() else { return };
        let block = |(number, part): (usize, &mut [f64])| {
            wide::<Accumulate, _>((design, columns, number * BLOCK, vector, part));
        };
        if columns <= BLOCK {
            block((0, products));
        } else {
            blocks::for_each(products.chunks_mut(BLOCK).enumerate(), block);
        }
        let sum: f64 = vector.iter().sum();
        for ((product, mean), norm) in products.iter_mut().zip(&self.means).zip(&self.norms) {
            *product = if *norm > 0.0 { (*product - mean * sum) / norm } else { 0.0 };
        }
    }
}

/// Kernel that sums weighted rows of a matrix over the columns from `first` on.
struct Accumulate;

impl<'a> Kernel<(&'a [f64], usize, usize, &'a [f64], &'a mut [f64])> for Accumulate {
    type Output = ();

    #[inline(always)]
    fn run((design, stride, first, weights, sums): (&'a [f64], usize, usize, &'a [f64], &'a mut [f64])) {
        let n = sums.len();
        sums.fill(0.0);
        let (chunks, rest) = weights.as_chunks::<ROWS>();
        for (chunk, w) in chunks.iter().enumerate() {
            let row = |place: usize| &design[(chunk * ROWS + place) * stride + first..][..n];
            let rows: [&[f64]; ROWS] = [row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)];
            for j in 0..n {
                let low = (w[0] * rows[0][j] + w[1] * rows[1][j]) + (w[2] * rows[2][j] + w[3] * rows[3][j]);
                let high = (w[4] * rows[4][j] + w[5] * rows[5][j]) + (w[6] * rows[6][j] + w[7] * rows[7][j]);
                sums[j] += low + high;
            }
        }
        for (place, w) in rest.iter().enumerate() {
            let row = &design[(chunks.len() * ROWS + place) * stride + first..][..n];
            for j in 0..n {
                sums[j] += w * row[j];
            }
        }
    }
}
