//! Two-dimensional Fourier transforms of real maps; all FFT calls are in this module.
//!
//! # Conventions
//! The forward transform is X[ky, kx] = Σ x[row, column] e^{−2πi(kx·column/nx + ky·row/ny)}, unnormalised; the inverse
//! divides by nx·ny. Only kx = 0 … nx/2 is stored, and the spectrum stays *transposed*: one contiguous slice of shape
//! `[nx/2 + 1, ny]`, so that the second pass runs along contiguous memory and products need no second transpose.
//!
//! Rows and columns of large maps are distributed over the threads of the current pool. Each is transformed on its own,
//! so results do not depend on the number of threads.

mod convolution;
mod products;
mod transpose;

use std::fmt;
use std::sync::Arc;

pub use asperity_fft::Complex64;
use asperity_fft::{ComplexToReal, Fft, RealToComplex, complex_f64, real_forward, real_inverse};

#[doc(hidden)]
pub use convolution::{Convolution, ConvolutionWork, ROWS_OF_SLAB};
#[doc(hidden)]
pub use products::{autocorrelation_sums, even_spectrum, lag_sums_of_power, power, real_transform, summed_power};
use transpose::{BLOCK, TILE, gather};

use crate::blocks;

/// Points of a map above which its rows are distributed over threads, which costs some microseconds.
const SHARED_FROM: usize = 1 << 15;

/// Plan of transforms of real `ny` × `nx` maps. Cheap to clone and to share between threads.
#[doc(hidden)]
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

/// Workspace of one caller for a [`RealFft2`].
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct Workspace {
    /// Transformed rows, before the columns; empty before the first forward transform.
    rows: Vec<Complex64>,
    scratch: ThreadScratch,
}

/// Workspace of one thread.
#[derive(Debug, Clone)]
struct ThreadScratch {
    real_row: Vec<f64>,
    /// [`BLOCK`] half-transformed rows.
    block: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl RealFft2 {
    /// Creates the plan for maps with `nx` columns and `ny` rows.
    pub fn new(nx: usize, ny: usize) -> Self {
        let [column_forward, column_inverse] = complex_f64(ny);
        Self { nx, ny, row_forward: real_forward(nx), row_inverse: real_inverse(nx), column_forward, column_inverse }
    }

    /// Returns the number of columns of the map.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Returns the number of rows of the map.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// Returns the number of stored wavenumbers along x, nx/2 + 1.
    pub fn stored_kx(&self) -> usize {
        self.nx / 2 + 1
    }

    /// Returns the length of the stored spectrum, (nx/2 + 1)·ny; the entry of (kx, ky) is at kx·ny + ky.
    pub fn spectrum_len(&self) -> usize {
        self.stored_kx() * self.ny
    }

    /// Returns a zero spectrum.
    pub fn spectrum(&self) -> Vec<Complex64> {
        vec![Complex64::default(); self.spectrum_len()]
    }

    /// Returns the multiplicity of the stored column `kx`, which represents (kx, −kx): 1 or 2.
    pub fn multiplicity(&self, kx: usize) -> f64 {
        if kx == 0 || 2 * kx == self.nx { 1.0 } else { 2.0 }
    }

    /// Returns a workspace for one caller.
    pub fn workspace(&self) -> Workspace {
        Workspace { rows: Vec::new(), scratch: self.thread_scratch() }
    }

    fn thread_scratch(&self) -> ThreadScratch {
        let scratch = [
            self.row_forward.get_scratch_len(),
            self.row_inverse.get_scratch_len(),
            self.column_forward.get_inplace_scratch_len(),
            self.column_inverse.get_inplace_scratch_len(),
        ];
        ThreadScratch {
            real_row: vec![0.0; self.nx],
            block: vec![Complex64::default(); BLOCK.min(self.ny) * self.stored_kx()],
            scratch: vec![Complex64::default(); scratch.into_iter().max().unwrap_or(0)],
        }
    }

    /// Applies `work` to every chunk of `length` values of `slice`, over threads if the map is large.
    fn for_chunks<T: Send>(
        &self,
        slice: &mut [T],
        length: usize,
        thread: &mut ThreadScratch,
        work: &(dyn Fn(&mut ThreadScratch, usize, &mut [T]) + Sync),
    ) {
        if self.nx * self.ny < SHARED_FROM {
            slice.chunks_mut(length).enumerate().for_each(|(index, chunk)| work(thread, index, chunk));
        } else {
            let chunks = slice.chunks_mut(length).enumerate();
            blocks::for_each_with(
                chunks,
                || self.thread_scratch(),
                |thread, (index, chunk)| work(thread, index, chunk),
            );
        }
    }

    /// Transforms `map` (row-major, ny·nx values) into `spectrum` (transposed, see the module).
    ///
    /// # Panics
    /// If a slice or the workspace has the wrong length.
    pub fn forward(&self, map: &[f64], spectrum: &mut [Complex64], work: &mut Workspace) {
        self.forward_padded(map, self.ny, self.nx, spectrum, work);
    }

    /// Transforms a map of `rows` × `columns` values, zero-padded to `ny` × `nx`.
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
        assert!(map.len() == rows * columns, "map does not fit the plan");
        let fill = |row: usize, out: &mut [f64]| out.copy_from_slice(&map[row * columns..(row + 1) * columns]);
        self.forward_rows(rows, columns, fill, spectrum, work);
    }

    /// Transforms a map as [`RealFft2::forward_padded`] does; `fill` writes one of its rows.
    ///
    /// # Panics
    /// If the spectrum has the wrong length, or the map is larger than the plan.
    pub fn forward_rows(
        &self,
        rows: usize,
        columns: usize,
        fill: impl Fn(usize, &mut [f64]) + Sync,
        spectrum: &mut [Complex64],
        work: &mut Workspace,
    ) {
        assert!(rows <= self.ny && columns <= self.nx, "map does not fit the plan");
        assert_eq!(spectrum.len(), self.spectrum_len(), "spectrum has the wrong length");
        let stored = self.stored_kx();
        let Workspace { rows: transformed, scratch } = work;
        transformed.resize(transformed.len().max(rows * stored), Complex64::default());
        self.for_chunks(&mut transformed[..rows * stored], stored, scratch, &|thread, row, out| {
            fill(row, &mut thread.real_row[..columns]);
            thread.real_row[columns..].fill(0.0);
            let scratch = &mut thread.scratch[..self.row_forward.get_scratch_len()];
            let done = self.row_forward.process_with_scratch(&mut thread.real_row, out, scratch);
            debug_assert!(done.is_ok());
        });
        let transformed = &transformed[..rows * stored];
        self.for_chunks(spectrum, BLOCK * self.ny, scratch, &|thread, block, out| {
            gather(transformed.chunks(TILE * stored), stored, block * BLOCK, out, self.ny);
            self.column_forward.process_with_scratch(out, &mut thread.scratch);
        });
    }

    /// Transforms `spectrum` back into `map`, dividing by nx·ny. The spectrum is overwritten.
    ///
    /// # Panics
    /// If a slice or the workspace has the wrong length.
    pub fn inverse(&self, spectrum: &mut [Complex64], map: &mut [f64], work: &mut Workspace) {
        self.inverse_cropped(spectrum, map, self.ny, self.nx, work);
    }

    /// Transforms as [`RealFft2::inverse`], with only the first `rows` × `columns` values returned.
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
        self.for_chunks(spectrum, BLOCK * self.ny, &mut work.scratch, &|thread, _, columns| {
            self.column_inverse.process_with_scratch(columns, &mut thread.scratch);
        });
        let spectrum = &*spectrum;
        let scale = 1.0 / (self.nx * self.ny) as f64;
        self.for_chunks(map, BLOCK * columns, &mut work.scratch, &|thread, block, out| {
            let ThreadScratch { real_row, block: inputs, scratch } = thread;
            let inputs = &mut inputs[..out.len() / columns * stored];
            gather(spectrum.chunks(TILE * self.ny), self.ny, block * BLOCK, inputs, stored);
            for (input, out) in inputs.chunks_exact_mut(stored).zip(out.chunks_exact_mut(columns)) {
                transpose::make_real(input, self.nx);
                let scratch = &mut scratch[..self.row_inverse.get_scratch_len()];
                let done = self.row_inverse.process_with_scratch(input, real_row, scratch);
                debug_assert!(done.is_ok());
                for (value, real) in out.iter_mut().zip(real_row.iter()) {
                    *value = real * scale;
                }
            }
        });
    }
}

/// Returns the signed wavenumber of index `k` of `n`: 0, 1, …, n/2, …, −1.
pub fn signed_index(k: usize, n: usize) -> f64 {
    if 2 * k > n { k as f64 - n as f64 } else { k as f64 }
}

/// Returns the least even length ≥ `n` with no prime factor above 7, for which transforms are fast.
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

    /// Returns the sum of the definition, term by term.
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
    fn the_bits_do_not_depend_on_the_number_of_threads() {
        let (nx, ny) = (360, 250);
        let map = random::standard_normal(&mut random::stream(3, "fourier", 0), 300 * 200);
        let fft = RealFft2::new(nx, ny);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
                fft.forward_padded(&map, 200, 300, &mut spectrum, &mut work);
                let forward = spectrum.clone();
                let mut back = vec![0.0; 300 * 200];
                fft.inverse_cropped(&mut spectrum, &mut back, 200, 300, &mut work);
                (forward, back)
            })
        };
        let alone = with(1);
        assert!(alone == with(2) && alone == with(3));
        assert!(alone.1.iter().zip(&map).all(|(a, b)| (a - b).abs() < 1e-13));
    }

    #[test]
    fn padding_with_zeros_and_cropping_are_inverse() {
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
