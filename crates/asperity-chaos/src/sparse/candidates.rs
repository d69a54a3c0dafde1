//! The design matrix from which terms are selected.

use ndarray::{ArrayView2, CowArray, Ix2};
use rayon::prelude::*;

use super::SparseError;
use asperity_base::wide::{Kernel, wide};

/// Share of a length that is taken as rounding.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Columns whose products are summed together: they stay in the nearest cache.
const BLOCK: usize = 2048;

/// Rows that are added at a time.
const ROWS: usize = 8;

/// Columns from which terms are selected, shape `[samples K, candidates P]`, P > K allowed, and their means and lengths.
///
/// A column that is the same in all samples, and not zero, is the constant: it belongs to every model, and candidates
/// are compared after their means are taken off. Without one nothing is taken off. Columns without variation are never selected,
/// and of columns that span the same the first to enter stays alone. Rows may repeat, but leave-one-out errors are too
/// small then: what is left out is still there.
#[derive(Debug)]
pub struct Candidates<'a> {
    /// In rows.
    design: CowArray<'a, f64, Ix2>,
    means: Vec<f64>,
    /// Lengths after the mean is taken off, zero for what cannot be selected.
    norms: Vec<f64>,
    constant: Option<usize>,
}

impl<'a> Candidates<'a> {
    /// Borrows a matrix in standard layout, and copies one in any other.
    ///
    /// # Errors
    /// Fewer than three samples, or a value that is not finite.
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
        for row in design.rows() {
            for ((mean, square), a) in means.iter_mut().zip(&mut squares).zip(row) {
                *mean += a / n;
                *square += a * a;
            }
        }
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

    /// Number of samples K.
    pub fn samples(&self) -> usize {
        self.design.nrows()
    }

    /// Number of columns P.
    pub fn columns(&self) -> usize {
        self.design.ncols()
    }

    /// The constant column.
    pub fn constant(&self) -> Option<usize> {
        self.constant
    }

    /// The matrix.
    pub(super) fn design(&self) -> ArrayView2<'_, f64> {
        self.design.view()
    }

    /// Number of columns that can be selected.
    pub(super) fn selectable(&self) -> usize {
        self.norms.iter().filter(|norm| **norm > 0.0).count()
    }

    /// Length of a column, less its mean where there is a constant; zero for what cannot be selected.
    pub(super) fn norm(&self, column: usize) -> f64 {
        self.norms[column]
    }

    /// Copies a column.
    pub(super) fn fill_column(&self, column: usize, values: &mut [f64]) {
        values.iter_mut().zip(self.design.column(column)).for_each(|(value, a)| *value = *a);
    }

    /// Products of all standardised columns with a vector: (x_j − x̄_j)ᵀv/‖x_j − x̄_j‖, zero for what cannot be selected.
    pub(super) fn correlate(&self, vector: &[f64], products: &mut [f64]) {
        let columns = self.columns();
        // The rows lie side by side: the layout was made so.
        let Some(design) = self.design.as_slice() else { return };
        let block = |(number, part): (usize, &mut [f64])| {
            wide::<Accumulate, _>((design, columns, number * BLOCK, vector, part));
        };
        if columns <= BLOCK {
            block((0, products));
        } else {
            products.par_chunks_mut(BLOCK).enumerate().for_each(block);
        }
        let sum: f64 = vector.iter().sum();
        for ((product, mean), norm) in products.iter_mut().zip(&self.means).zip(&self.norms) {
            *product = if *norm > 0.0 { (*product - mean * sum) / norm } else { 0.0 };
        }
    }
}

/// Sums of rows of a matrix with weights, for the columns from `first` on.
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
