//! Two-dimensional transforms of real maps, the only caller of an FFT.
//!
//! # Conventions
//! The forward transform is X[ky, kx] = Σ x[row, column] e^{−2πi(kx·column/nx + ky·row/ny)}, unnormalised; the inverse
//! divides by nx·ny. Only kx = 0 … nx/2 is stored, and the spectrum stays *transposed*: one contiguous slice of shape
//! `[nx/2 + 1, ny]`, so that the second pass runs along contiguous memory and products need no second transpose.

use std::fmt;
use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
pub use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};

/// Edge of the square blocks in which a matrix is transposed: two blocks of 16² complex numbers fit the first cache.
const TRANSPOSE_BLOCK: usize = 16;

/// A planned transform of real `ny` × `nx` maps. Cheap to clone and to share between threads.
#[derive(Clone)]
pub struct RealFft2 {
    nx: usize,
    ny: usize,
    row_forward: Arc<dyn RealToComplex<f64>>,
    row_inverse: Arc<dyn ComplexToReal<f64>>,
    column_forward: Arc<dyn Fft<f64>>,
    column_inverse: Arc<dyn Fft<f64>>,
}

impl fmt::Debug for RealFft2 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RealFft2").field("nx", &self.nx).field("ny", &self.ny).finish_non_exhaustive()
    }
}

/// Scratch memory of one thread for one [`RealFft2`].
#[derive(Debug, Clone)]
pub struct Workspace {
    rows: Vec<Complex64>,
    real_row: Vec<f64>,
    scratch: Vec<Complex64>,
}

impl RealFft2 {
    /// Plans transforms of maps with `nx` columns and `ny` rows.
    pub fn new(nx: usize, ny: usize) -> Self {
        let mut real = RealFftPlanner::new();
        let mut complex = FftPlanner::new();
        Self {
            nx,
            ny,
            row_forward: real.plan_fft_forward(nx),
            row_inverse: real.plan_fft_inverse(nx),
            column_forward: complex.plan_fft_forward(ny),
            column_inverse: complex.plan_fft_inverse(ny),
        }
    }

    /// Columns of the map.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Rows of the map.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// Stored wavenumbers along x: nx/2 + 1.
    pub fn stored_kx(&self) -> usize {
        self.nx / 2 + 1
    }

    /// Length of the stored spectrum, (nx/2 + 1)·ny; the entry of (kx, ky) is at kx·ny + ky.
    pub fn spectrum_len(&self) -> usize {
        self.stored_kx() * self.ny
    }

    /// A zero spectrum.
    pub fn spectrum(&self) -> Vec<Complex64> {
        vec![Complex64::default(); self.spectrum_len()]
    }

    /// How often the stored column `kx` stands for a pair (kx, −kx): 1 or 2.
    pub fn multiplicity(&self, kx: usize) -> f64 {
        if kx == 0 || 2 * kx == self.nx { 1.0 } else { 2.0 }
    }

    /// Scratch memory for one thread.
    pub fn workspace(&self) -> Workspace {
        let scratch = [
            self.row_forward.get_scratch_len(),
            self.row_inverse.get_scratch_len(),
            self.column_forward.get_inplace_scratch_len(),
            self.column_inverse.get_inplace_scratch_len(),
        ];
        Workspace {
            rows: self.spectrum(),
            real_row: vec![0.0; self.nx],
            scratch: vec![Complex64::default(); scratch.into_iter().max().unwrap_or(0)],
        }
    }

    /// Transforms `map` (row-major, ny·nx values) into `spectrum` (transposed, see the module).
    ///
    /// # Panics
    /// If a slice or the workspace has the wrong length.
    pub fn forward(&self, map: &[f64], spectrum: &mut [Complex64], work: &mut Workspace) {
        self.forward_padded(map, self.ny, self.nx, spectrum, work);
    }

    /// Transforms a map of `rows` × `columns` values that is continued with zeros to `ny` × `nx`.
    ///
    /// # Panics
    /// If a slice or the workspace has the wrong length, or the map is larger than the plan.
    pub fn forward_padded(
        &self,
        map: &[f64],
        rows: usize,
        columns: usize,
        spectrum: &mut [Complex64],
        work: &mut Workspace,
    ) {
        assert!(rows <= self.ny && columns <= self.nx && map.len() == rows * columns, "map does not fit the plan");
        assert_eq!(spectrum.len(), self.spectrum_len(), "spectrum has the wrong length");
        let stored = self.stored_kx();
        for (row, out) in work.rows.chunks_exact_mut(stored).enumerate() {
            if row >= rows {
                out.fill(Complex64::default());
                continue;
            }
            work.real_row[..columns].copy_from_slice(&map[row * columns..(row + 1) * columns]);
            work.real_row[columns..].fill(0.0);
            let done = self.row_forward.process_with_scratch(
                &mut work.real_row,
                out,
                &mut work.scratch[..self.row_forward.get_scratch_len()],
            );
            debug_assert!(done.is_ok());
        }
        transpose(&work.rows, spectrum, self.ny, stored);
        self.column_forward.process_with_scratch(spectrum, &mut work.scratch);
    }

    /// Transforms `spectrum` back into `map`, dividing by nx·ny. The spectrum is used as scratch memory.
    ///
    /// # Panics
    /// If a slice or the workspace has the wrong length.
    pub fn inverse(&self, spectrum: &mut [Complex64], map: &mut [f64], work: &mut Workspace) {
        self.inverse_cropped(spectrum, map, self.ny, self.nx, work);
    }

    /// As [`RealFft2::inverse`], keeping the first `rows` × `columns` values alone.
    ///
    /// # Panics
    /// If a slice or the workspace has the wrong length, or the map is larger than the plan.
    pub fn inverse_cropped(
        &self,
        spectrum: &mut [Complex64],
        map: &mut [f64],
        rows: usize,
        columns: usize,
        work: &mut Workspace,
    ) {
        assert!(rows <= self.ny && columns <= self.nx && map.len() == rows * columns, "map does not fit the plan");
        assert_eq!(spectrum.len(), self.spectrum_len(), "spectrum has the wrong length");
        let stored = self.stored_kx();
        self.column_inverse.process_with_scratch(spectrum, &mut work.scratch);
        transpose(spectrum, &mut work.rows, stored, self.ny);
        let scale = 1.0 / (self.nx * self.ny) as f64;
        for (input, out) in work.rows.chunks_exact_mut(stored).zip(map.chunks_exact_mut(columns)) {
            // A real row has real first and Nyquist coefficients; rounding leaves dust there that realfft refuses.
            input[0].im = 0.0;
            if self.nx.is_multiple_of(2) {
                input[stored - 1].im = 0.0;
            }
            let done = self.row_inverse.process_with_scratch(
                input,
                &mut work.real_row,
                &mut work.scratch[..self.row_inverse.get_scratch_len()],
            );
            debug_assert!(done.is_ok());
            for (value, real) in out.iter_mut().zip(&work.real_row) {
                *value = real * scale;
            }
        }
    }
}

/// Writes the transpose of `from` (`rows` × `columns`) into `to`, block by block.
fn transpose(from: &[Complex64], to: &mut [Complex64], rows: usize, columns: usize) {
    for row_block in (0..rows).step_by(TRANSPOSE_BLOCK) {
        let row_end = (row_block + TRANSPOSE_BLOCK).min(rows);
        for column_block in (0..columns).step_by(TRANSPOSE_BLOCK) {
            let column_end = (column_block + TRANSPOSE_BLOCK).min(columns);
            for column in column_block..column_end {
                for row in row_block..row_end {
                    to[column * rows + row] = from[row * columns + column];
                }
            }
        }
    }
}

/// The signed wavenumber of index `k` of `n`: 0, 1, …, n/2, …, −1.
pub fn signed_index(k: usize, n: usize) -> f64 {
    if 2 * k > n { k as f64 - n as f64 } else { k as f64 }
}

/// The least even length ≥ `n` whose prime factors are 2, 3, 5 and 7, on which transforms are fast.
pub fn good_length(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for p in [2, 3, 5, 7] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    (n.max(2)..).find(|&m| m.is_multiple_of(2) && smooth(m)).unwrap_or(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    /// The defining sum, term by term.
    fn dense(map: &[f64], nx: usize, ny: usize, kx: usize, ky: usize) -> Complex64 {
        let mut sum = Complex64::default();
        for row in 0..ny {
            for column in 0..nx {
                let turn = kx as f64 * column as f64 / nx as f64 + ky as f64 * row as f64 / ny as f64;
                sum += Complex64::cis(-std::f64::consts::TAU * turn) * map[row * nx + column];
            }
        }
        sum
    }

    #[test]
    fn the_transform_is_the_defining_sum_for_even_odd_and_prime_sizes() {
        for (nx, ny) in [(8, 6), (7, 5), (16, 1), (1, 9), (11, 13), (20, 33)] {
            let map = random::standard_normal(&mut random::stream(1, "fourier", (nx * ny) as u64), nx * ny);
            let fft = RealFft2::new(nx, ny);
            let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
            fft.forward(&map, &mut spectrum, &mut work);
            for kx in 0..fft.stored_kx() {
                for ky in 0..ny {
                    let error = (spectrum[kx * ny + ky] - dense(&map, nx, ny, kx, ky)).norm();
                    assert!(error < 1e-11, "{nx}x{ny} at ({kx},{ky}): {error:e}");
                }
            }
            let mut back = vec![0.0; nx * ny];
            fft.inverse(&mut spectrum, &mut back, &mut work);
            assert!(back.iter().zip(&map).all(|(a, b)| (a - b).abs() < 1e-13));
        }
    }

    #[test]
    fn padding_with_zeros_and_cropping_undo_each_other() {
        let (rows, columns) = (5, 7);
        let map = random::standard_normal(&mut random::stream(2, "fourier", 0), rows * columns);
        let fft = RealFft2::new(16, 12);
        let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
        fft.forward_padded(&map, rows, columns, &mut spectrum, &mut work);
        let mut back = vec![0.0; rows * columns];
        fft.inverse_cropped(&mut spectrum, &mut back, rows, columns, &mut work);
        assert!(back.iter().zip(&map).all(|(a, b)| (a - b).abs() < 1e-13));
    }

    #[test]
    fn good_lengths_are_even_and_smooth() {
        assert_eq!([1, 127, 128, 131, 4097].map(good_length), [2, 128, 128, 140, 4116]);
    }
}
