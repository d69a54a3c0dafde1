//! Convolutions of real maps with real kernels that are even in x and in y, with one pass over memory in each direction.
//!
//! Two real rows form one complex row; their transforms are separated when the columns are gathered. Columns are
//! transformed, multiplied and transformed back within the level-2 cache, so the spectrum of the map is never written
//! to memory.

use std::fmt;
use std::sync::Arc;

use asperity_fft::{Complex, Fft, FftNum, complex_f32, complex_f64};

use super::{SHARED_FROM, even_spectrum};
use crate::blocks;
use crate::wide::{Kernel, wide};

/// Columns gathered per block.
const BLOCK: usize = 16;
/// Rows finished per block.
#[doc(hidden)]
pub const ROWS_OF_SLAB: usize = 16;
/// Padding after every row and column: with lengths that are powers of two, all rows would map to the same cache sets.
const PAD: usize = 8;
/// Number of parallel partial sums.
const LANES: usize = 8;

/// Single or double precision.
#[doc(hidden)]
pub trait Real: FftNum + Default {
    /// Rounds to this precision.
    fn from_double(value: f64) -> Self;
    /// Converts to double precision.
    fn to_f64(self) -> f64;
    /// Returns the plans of the forward and inverse transform of a length.
    fn transforms(length: usize) -> [Arc<dyn Fft<Self>>; 2];
}

impl Real for f32 {
    fn from_double(value: f64) -> Self {
        value as Self
    }

    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    fn transforms(length: usize) -> [Arc<dyn Fft<Self>>; 2] {
        complex_f32(length)
    }
}

impl Real for f64 {
    fn from_double(value: f64) -> Self {
        value
    }

    fn to_f64(self) -> f64 {
        self
    }

    fn transforms(length: usize) -> [Arc<dyn Fft<Self>>; 2] {
        complex_f64(length)
    }
}

/// Plan of convolutions of maps of `rows` × `columns` values, zero-padded to a periodic `ny` × `nx` grid. Cheap to
/// clone and to share between threads.
#[derive(Clone)]
#[doc(hidden)]
pub struct Convolution<T> {
    rows: usize,
    columns: usize,
    nx: usize,
    ny: usize,
    along_rows: [Arc<dyn Fft<T>>; 2],
    along_columns: [Arc<dyn Fft<T>>; 2],
}

impl<T> fmt::Debug for Convolution<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Convolution").field("nx", &self.nx).field("ny", &self.ny).finish_non_exhaustive()
    }
}

/// Workspace of one caller for a [`Convolution`].
#[derive(Debug, Clone)]
#[doc(hidden)]
pub struct ConvolutionWork<T> {
    /// Transformed pairs of rows.
    pairs: Vec<Complex<T>>,
    /// Columns of half the spectrum, transformed back, without the padding of the map.
    columns: Vec<Complex<T>>,
    scratch: ThreadScratch<T>,
}

/// Workspace of one thread.
#[derive(Debug, Clone)]
struct ThreadScratch<T> {
    rows: [Vec<T>; 2],
    slab: Vec<Complex<T>>,
    /// [`BLOCK`] padded columns.
    columns: Vec<Complex<T>>,
    /// Factors of one column.
    factors: Vec<T>,
    scratch: Vec<Complex<T>>,
}

impl<T: Real> Convolution<T> {
    /// Creates the plan for maps of `shape` = (rows, columns) on a periodic grid of `torus` = (ny, nx) points.
    ///
    /// # Panics
    /// If the map is larger than the periodic grid.
    #[doc(hidden)]
    pub fn new(shape: (usize, usize), torus: (usize, usize)) -> Self {
        let ((rows, columns), (ny, nx)) = (shape, torus);
        assert!(rows <= ny && columns <= nx, "a map of {columns} × {rows} points does not fit {nx} × {ny}");
        let (along_rows, along_columns) = (T::transforms(nx), T::transforms(ny));
        Self { rows, columns, nx, ny, along_rows, along_columns }
    }

    /// Returns the number of stored wavenumbers along x, nx/2 + 1.
    #[doc(hidden)]
    pub fn stored_kx(&self) -> usize {
        self.nx / 2 + 1
    }

    /// Returns the number of grid points along y.
    #[doc(hidden)]
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// Returns the number of grid points along x.
    #[doc(hidden)]
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Returns the number of slabs of [`ROWS_OF_SLAB`] rows of a result; the last one may be shorter.
    #[doc(hidden)]
    pub fn slabs(&self) -> usize {
        self.rows.div_ceil(ROWS_OF_SLAB)
    }

    /// Returns the number of stored factors along y, ny/2 + 1: they are even.
    fn stored_ky(&self) -> usize {
        self.ny / 2 + 1
    }

    /// Returns the rows of the transforms of columns that are not padding, in pairs.
    fn kept_rows(&self) -> usize {
        2 * self.rows.div_ceil(2)
    }

    /// Returns the factors `symbol(kx, ky)`, ky ≥ 0, for [`Convolution::forward`].
    #[doc(hidden)]
    pub fn symbol(&self, symbol: impl Fn(usize, f64) -> f64) -> Vec<f64> {
        let scale = 1.0 / (self.nx * self.ny) as f64;
        let columns = (0..self.stored_kx()).flat_map(|kx| (0..self.stored_ky()).map(move |ky| (kx, ky)));
        columns.map(|(kx, ky)| scale * symbol(kx, ky as f64)).collect()
    }

    /// Returns the factors of the kernel with these values on the periodic grid for [`Convolution::forward`]; `fill`
    /// writes a row.
    #[doc(hidden)]
    pub fn symbol_of_kernel(&self, fill: impl Fn(usize, &mut [f64]) + Sync) -> Vec<f64> {
        let scale = (self.nx * self.ny) as f64;
        let spectrum = even_spectrum(self.nx, self.ny, fill);
        spectrum
            .chunks_exact(self.ny)
            .flat_map(|column| column[..self.stored_ky()].iter().map(|value| value / scale))
            .collect()
    }

    /// Returns one factor for [`Convolution::forward`].
    #[doc(hidden)]
    pub fn factor(&self, value: f64) -> T {
        T::from_double(value / (self.nx * self.ny) as f64)
    }

    #[doc(hidden)]
    pub fn work(&self) -> ConvolutionWork<T> {
        ConvolutionWork {
            pairs: vec![Complex::default(); self.rows.div_ceil(2) * (self.nx + PAD)],
            columns: vec![Complex::default(); self.stored_kx() * (self.kept_rows() + PAD)],
            scratch: self.thread_scratch(),
        }
    }

    fn thread_scratch(&self) -> ThreadScratch<T> {
        let plans = self.along_rows.iter().chain(&self.along_columns);
        let scratch = plans.map(|plan| plan.get_inplace_scratch_len()).max().unwrap_or(0);
        ThreadScratch {
            rows: [vec![T::default(); self.columns], vec![T::default(); self.columns]],
            slab: vec![Complex::default(); ROWS_OF_SLAB / 2 * (self.nx + PAD)],
            columns: vec![Complex::default(); BLOCK * (self.ny + PAD)],
            factors: vec![T::default(); self.ny],
            scratch: vec![Complex::default(); scratch],
        }
    }

    /// Applies `work` to the items, over threads if the map is large.
    fn distribute<I: Send>(
        &self,
        thread: &mut ThreadScratch<T>,
        items: impl Iterator<Item = I>,
        work: impl Fn(&mut ThreadScratch<T>, I) + Sync,
    ) {
        if self.nx * self.ny < SHARED_FROM || rayon::current_num_threads() == 1 {
            items.for_each(|item| work(thread, item));
        } else {
            blocks::for_each_with(items, || self.thread_scratch(), work);
        }
    }

    /// Multiplies the transform of a map z by `symbol` over its `unit`, and its constant term by `constant`, and returns Σ z·(S z) with the convolution S. [`Convolution::backward`] then returns S z.
    ///
    /// Each of `slabs` corresponds to a slab of rows; `fill` writes the rows in order into zeroed memory and returns
    /// `false` for a zero row.
    ///
    /// # Panics
    /// If the symbol or the workspace belongs to another convolution, or the number of `slabs` differs.
    #[doc(hidden)]
    pub fn forward<S: Send>(
        &self,
        symbol: &[f64],
        unit: f64,
        constant: T,
        slabs: &mut [S],
        fill: impl Fn(&mut S, usize, &mut [T]) -> bool + Sync,
        work: &mut ConvolutionWork<T>,
    ) -> f64 {
        assert_eq!(symbol.len(), self.stored_kx() * self.stored_ky(), "the symbol has the wrong length");
        assert_eq!(slabs.len(), self.slabs(), "there must be one input for each slab of rows");
        let ConvolutionWork { pairs, columns, scratch } = work;
        let (nx, ny) = (self.nx, self.ny);
        let items = slabs.iter_mut().zip(pairs.chunks_mut(ROWS_OF_SLAB / 2 * (nx + PAD))).enumerate();
        self.distribute(scratch, items, |thread, (slab, (input, pairs))| {
            let [even, odd] = &mut thread.rows;
            for (pair, out) in pairs.chunks_exact_mut(nx + PAD).enumerate() {
                let row = slab * ROWS_OF_SLAB + 2 * pair;
                even.fill(T::zero());
                odd.fill(T::zero());
                let present = fill(input, row, even);
                let present = (row + 1 < self.rows && fill(input, row + 1, odd)) || present;
                let out = &mut out[..nx];
                out[self.columns..].fill(Complex::default());
                wide::<Join, _>((out, even.as_slice(), odd.as_slice()));
                if present {
                    self.along_rows[0].process_with_scratch(out, &mut thread.scratch);
                }
            }
        });

        let pairs = &*pairs;
        let kept = self.kept_rows();
        let blocks = columns.chunks_mut(BLOCK * (kept + PAD)).zip(symbol.chunks(BLOCK * self.stored_ky()));
        let mut energies = vec![0.0; self.stored_kx().div_ceil(BLOCK)];
        let items = blocks.zip(&mut energies).enumerate().map(|(block, ((to, symbol), sum))| (block, to, symbol, sum));
        self.distribute(scratch, items, |thread, (block, to, symbol, energy)| {
            let ThreadScratch { columns, factors, scratch, .. } = thread;
            let padded = to.len() / (kept + PAD) * (ny + PAD);
            let (columns, cropped) = if kept == ny { (to, None) } else { (&mut columns[..padded], Some(to)) };
            wide::<GatherColumns, _>((self, pairs, block * BLOCK, columns));
            let symbols = symbol.chunks_exact(self.stored_ky());
            for (j, (column, symbol)) in columns.chunks_exact_mut(ny + PAD).zip(symbols).enumerate() {
                let (kx, column) = (block * BLOCK + j, &mut column[..ny]);
                wide::<Mirror, _>((factors.as_mut_slice(), symbol, unit));
                self.along_columns[0].process_with_scratch(column, scratch);
                let first = if kx == 0 { constant } else { factors[0] };
                let sum = (first * column[0].norm_sqr()).to_f64();
                column[0] = column[0] * first;
                let sum = sum + wide::<Multiply, _>((&mut column[1..], &factors[1..]));
                // A stored column also represents its opposite.
                *energy += if kx == 0 || 2 * kx == nx { sum } else { 2.0 * sum };
                self.along_columns[1].process_with_scratch(column, scratch);
            }
            if let Some(to) = cropped {
                let most = kept.min(ny);
                for (to, column) in to.chunks_exact_mut(kept + PAD).zip(columns.chunks_exact(ny + PAD)) {
                    to[..most].copy_from_slice(&column[..most]);
                }
            }
        });
        energies.into_iter().sum()
    }

    /// Transforms the result of [`Convolution::forward`] back row by row; `take` receives the rows of a slab in order.
    ///
    /// # Panics
    /// If the number of `slabs` differs.
    #[doc(hidden)]
    pub fn backward<S: Send>(
        &self,
        slabs: &mut [S],
        take: impl Fn(&mut S, usize, &[T]) + Sync,
        work: &mut ConvolutionWork<T>,
    ) {
        assert_eq!(slabs.len(), self.slabs(), "there must be one output for each slab of rows");
        let ConvolutionWork { columns, scratch, .. } = work;
        let columns = &*columns;
        let nx = self.nx;
        self.distribute(scratch, slabs.iter_mut().enumerate(), |thread, (slab, output)| {
            let ThreadScratch { rows: [even, odd], slab: pairs, scratch, .. } = thread;
            let first = slab * ROWS_OF_SLAB;
            let count = (self.rows - first).min(ROWS_OF_SLAB).div_ceil(2);
            wide::<GatherRows, _>((self, columns, first, count, pairs));
            for (pair, row) in pairs.chunks_exact_mut(nx + PAD).take(count).enumerate() {
                self.along_rows[1].process_with_scratch(&mut row[..nx], scratch);
                wide::<Part, _>((&*row, even.as_mut_slice(), odd.as_mut_slice()));
                let row = first + 2 * pair;
                take(output, row, even);
                if row + 1 < self.rows {
                    take(output, row + 1, odd);
                }
            }
        });
    }
}

/// Extracts columns of half the spectrum, from `first` on, from the transformed pairs of rows, zero-padded.
struct GatherColumns;

impl<'a, T: Real> Kernel<(&'a Convolution<T>, &'a [Complex<T>], usize, &'a mut [Complex<T>])> for GatherColumns {
    type Output = ();

    #[inline(always)]
    fn run((plan, pairs, first, to): (&'a Convolution<T>, &'a [Complex<T>], usize, &'a mut [Complex<T>])) {
        let (nx, stride) = (plan.nx, plan.ny + PAD);
        let half = T::from_double(0.5);
        let width = to.len() / stride;
        // The transform of an even and an odd row, e + io, is e + io at k and the conjugate of e − io at −k.
        let halves = |at: Complex<T>, opposite: Complex<T>| {
            let even = Complex::new(half * (at.re + opposite.re), half * (at.im - opposite.im));
            let odd = Complex::new(half * (at.im + opposite.im), half * (opposite.re - at.re));
            [even, odd]
        };
        for (pair, row) in pairs.chunks_exact(nx + PAD).enumerate() {
            for j in 0..width {
                let k = first + j;
                let opposite = if k == 0 { row[0] } else { row[nx - k] };
                to[j * stride + 2 * pair..][..2].copy_from_slice(&halves(row[k], opposite));
            }
        }
        for column in to.chunks_exact_mut(stride) {
            column[2 * plan.rows.div_ceil(2)..].fill(Complex::default());
        }
    }
}

/// Extracts `count` pairs of rows of half the spectrum, from the row `first` on, from its columns, and completes the
/// other half.
struct GatherRows;

impl<'a, T: Real> Kernel<(&'a Convolution<T>, &'a [Complex<T>], usize, usize, &'a mut [Complex<T>])> for GatherRows {
    type Output = ();

    #[inline(always)]
    fn run(
        (plan, columns, first, count, to): (&'a Convolution<T>, &'a [Complex<T>], usize, usize, &'a mut [Complex<T>]),
    ) {
        let nx = plan.nx;
        for (k, column) in columns.chunks_exact(plan.kept_rows() + PAD).enumerate() {
            let column = &column[first..first + 2 * count];
            for ([even, odd], row) in column.as_chunks::<2>().0.iter().zip(to.chunks_exact_mut(nx + PAD)) {
                // The other half is the conjugate of the value at −k with separated rows.
                if k > 0 {
                    row[nx - k] = Complex::new(even.re + odd.im, odd.re - even.im);
                }
                row[k] = Complex::new(even.re - odd.im, even.im + odd.re);
            }
        }
    }
}

/// Combines two real rows into one complex row.
struct Join;

impl<'a, T: Real> Kernel<(&'a mut [Complex<T>], &'a [T], &'a [T])> for Join {
    type Output = ();

    #[inline(always)]
    fn run((out, even, odd): (&'a mut [Complex<T>], &'a [T], &'a [T])) {
        for ((out, re), im) in out.iter_mut().zip(even).zip(odd) {
            *out = Complex::new(*re, *im);
        }
    }
}

/// Splits one complex row into two real ones.
struct Part;

impl<'a, T: Real> Kernel<(&'a [Complex<T>], &'a mut [T], &'a mut [T])> for Part {
    type Output = ();

    #[inline(always)]
    fn run((row, even, odd): (&'a [Complex<T>], &'a mut [T], &'a mut [T])) {
        for ((value, even), odd) in row.iter().zip(even).zip(odd) {
            (*even, *odd) = (value.re, value.im);
        }
    }
}

/// Completes even factors in a unit.
struct Mirror;

impl<'a, T: Real> Kernel<(&'a mut [T], &'a [f64], f64)> for Mirror {
    type Output = ();

    #[inline(always)]
    fn run((factors, half, unit): (&'a mut [T], &'a [f64], f64)) {
        let (first, rest) = factors.split_at_mut(half.len());
        for (factor, value) in first.iter_mut().zip(half) {
            *factor = T::from_double(value / unit);
        }
        for (factor, opposite) in rest.iter_mut().rev().zip(&first[1..]) {
            *factor = *opposite;
        }
    }
}

/// Multiplies values by factors, and returns Σ factor |value|².
struct Multiply;

impl<'a, T: Real> Kernel<(&'a mut [Complex<T>], &'a [T])> for Multiply {
    type Output = f64;

    #[inline(always)]
    fn run((values, factors): (&'a mut [Complex<T>], &'a [T])) -> f64 {
        let mut lanes = [T::zero(); LANES];
        let (values, rest) = values.as_chunks_mut::<LANES>();
        let (factors, rest_of_factors) = factors.as_chunks::<LANES>();
        for (values, factors) in values.iter_mut().zip(factors) {
            for lane in 0..LANES {
                let (value, factor) = (values[lane], factors[lane]);
                lanes[lane] = lanes[lane] + factor * (value.re * value.re + value.im * value.im);
                values[lane] = Complex::new(factor * value.re, factor * value.im);
            }
        }
        let mut sum: f64 = lanes.into_iter().map(Real::to_f64).sum();
        for (value, factor) in rest.iter_mut().zip(rest_of_factors) {
            sum += (*factor * value.norm_sqr()).to_f64();
            *value = *value * *factor;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    /// Returns the periodic convolution of a map with the kernel of `symbol` by definition.
    fn direct(plan: &Convolution<f64>, symbol: impl Fn(usize, f64) -> f64, map: &[f64]) -> Vec<f64> {
        let (nx, ny) = (plan.nx, plan.ny);
        let turn = |k: f64, n: usize| std::f64::consts::TAU * k / n as f64;
        let kernel = |x: f64, y: f64| {
            let mut sum = 0.0;
            for kx in 0..nx {
                for ky in 0..ny {
                    let (kx, ky) = (super::super::signed_index(kx, nx), super::super::signed_index(ky, ny));
                    sum += symbol(kx.abs() as usize, ky) * (turn(kx, nx) * x + turn(ky, ny) * y).cos();
                }
            }
            sum / (nx * ny) as f64
        };
        let (rows, columns) = (plan.rows, plan.columns);
        let kernels: Vec<f64> = (0..ny * nx).map(|i| kernel((i % nx) as f64, (i / nx) as f64)).collect();
        let mut out = vec![0.0; rows * columns];
        for (i, out) in out.iter_mut().enumerate() {
            for (j, z) in map.iter().enumerate() {
                let x = (i % columns + nx - j % columns) % nx;
                let y = (i / columns + ny - j / columns) % ny;
                *out += kernels[y * nx + x] * z;
            }
        }
        out
    }

    fn apply<T: Real>(plan: &Convolution<T>, symbol: &[f64], constant: T, map: &[f64]) -> (f64, Vec<f64>) {
        let mut work = plan.work();
        let columns = plan.columns;
        let fill = |slab: &mut &[f64], row: usize, out: &mut [T]| {
            let values = &slab[row % ROWS_OF_SLAB * columns..][..columns];
            out.iter_mut().zip(values).for_each(|(out, z)| *out = T::from_double(*z));
            values.iter().any(|z| *z != 0.0)
        };
        let mut slabs: Vec<&[f64]> = map.chunks(ROWS_OF_SLAB * columns).collect();
        let energy = plan.forward(symbol, 1.0, constant, &mut slabs, fill, &mut work);
        let mut result = vec![0.0; map.len()];
        let mut slabs: Vec<&mut [f64]> = result.chunks_mut(ROWS_OF_SLAB * columns).collect();
        let take = |out: &mut &mut [f64], row: usize, values: &[T]| {
            let out = &mut out[row % ROWS_OF_SLAB * columns..][..columns];
            out.iter_mut().zip(values).for_each(|(out, value)| *out = value.to_f64());
        };
        plan.backward(&mut slabs, take, &mut work);
        (energy, result)
    }

    #[test]
    fn convolution_equals_the_periodic_sum_at_any_size_and_precision() {
        let symbol = |kx: usize, ky: f64| 1.0 / (1.0 + (kx as f64).powi(2) + 0.3 * ky * ky) + 0.1 * kx as f64;
        for (shape, torus) in [
            ((6, 8), (6, 8)),
            ((7, 9), (7, 9)),
            ((1, 5), (3, 8)),
            ((5, 1), (9, 2)),
            ((19, 16), (38, 35)),
            ((33, 20), (33, 20)),
            ((20, 37), (40, 72)),
        ] {
            let plan = Convolution::<f64>::new(shape, torus);
            let mut map = random::standard_normal(&mut random::stream(1, "torus", shape.0 as u64), shape.0 * shape.1);
            // Zero rows are skipped.
            map.iter_mut().skip(2 * shape.1).take(2 * shape.1).for_each(|z| *z = 0.0);
            let constant = |kx: usize, ky: f64| if kx == 0 && ky == 0.0 { 7.0 } else { symbol(kx, ky) };
            let wanted = direct(&plan, constant, &map);
            let (energy, found) = apply(&plan, &plan.symbol(symbol), plan.factor(7.0), &map);
            let error = |found: &[f64]| found.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error(&found) < 1e-13, "{shape:?}: {:e}", error(&found));
            let product: f64 = map.iter().zip(&wanted).map(|(z, w)| z * w).sum();
            assert!((energy - product).abs() < 1e-12 * product.abs().max(1.0));

            let single = Convolution::<f32>::new(shape, torus);
            let (energy, found) = apply(&single, &single.symbol(symbol), single.factor(7.0), &map);
            assert!(error(&found) < 1e-5 && (energy - product).abs() < 1e-5 * product.abs().max(1.0), "{shape:?}");
        }
    }

    #[test]
    fn a_large_map_is_the_same_on_any_number_of_threads() {
        let shape = (200, 230);
        let plan = Convolution::<f64>::new(shape, shape);
        let symbol = plan.symbol(|kx, ky| 1.0 / (1.0 + (kx as f64).hypot(ky)));
        let map = random::standard_normal(&mut random::stream(1, "threads", 0), shape.0 * shape.1);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| apply(&plan, &symbol, 0.0, &map))
        };
        assert_eq!(on(1), on(3));
    }
}
