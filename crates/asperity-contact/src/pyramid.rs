//! Preconditioner without large transforms: |q| as a sum of small stencils on coarser and coarser grids.
//!
//! On an isotropic grid |q| ≈ K₀ + P K₁ R + P P K₂ R R + … + P…P C R…R. The K are stencils of nine points. R averages
//! four by four cells with the weights [1 3 3 1]/8 in either direction. P, four times its adjoint, interpolates
//! linearly between the centres of the cells. C multiplies by |q| in the Fourier space of the coarsest grid. The
//! stencils were fitted to |q| by least squares. The sum deviates from |q| by up to about a quarter and is symmetric.
//! As a preconditioner it is about as good as |q| itself at a fraction of the cost.

use asperity_base::blocks;
use asperity_base::fourier::{Convolution, ConvolutionWork, ROWS_OF_SLAB, good_length};
use asperity_base::wide::{Kernel, wide};

/// Least number of cells along the shorter side of the coarsest grid.
const COARSEST: usize = 16;
/// For one, two … coarser grids: weights of the four edge and of the four corner neighbours on every grid but the
/// coarsest, and the factor on |q| there. |q| is in radian per finest cell.
const FITS: [(&[(f32, f32)], f64); 4] = [
    (&[(0.468, 0.111)], 0.812),
    (&[(0.467, 0.113), (0.155, 0.058)], 0.718),
    (&[(0.468, 0.112), (0.146, 0.070), (0.053, 0.025)], 0.746),
    (&[(0.468, 0.112), (0.147, 0.070), (0.050, 0.028), (0.044, 0.008)], 0.66),
];
/// Least number of cells of a grid for which threads share its rows.
const SHARED_FROM: usize = 1 << 16;

/// Approximate multiplication by |q| of maps of `rows` × `columns` cells.
#[derive(Debug, Clone)]
pub(super) struct Pyramid {
    rows: usize,
    columns: usize,
    wraps: bool,
    stencils: &'static [(f32, f32)],
    coarsest: Convolution<f32>,
    symbol: Vec<f64>,
}

/// Scratch memory of one caller for one [`Pyramid`].
#[derive(Debug, Clone)]
pub(super) struct PyramidWork {
    /// The map on every grid, finest first.
    maps: Vec<Field>,
    /// Products on the coarser grids.
    products: Vec<Field>,
    coarsest: ConvolutionWork<f32>,
    line: Line,
}

/// Row buffer of one thread.
#[derive(Debug, Clone)]
struct Line {
    row: Vec<f32>,
}

/// A map with a margin of one cell all around.
#[derive(Debug, Clone)]
struct Field {
    rows: usize,
    columns: usize,
    values: Vec<f32>,
}

impl Field {
    fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns, values: vec![0.0; (rows + 2) * (columns + 2)] }
    }

    fn stride(&self) -> usize {
        self.columns + 2
    }

    /// Returns a row with its margin. Row 0 is the margin above the first row of the map.
    fn row(&self, row: usize) -> &[f32] {
        &self.values[row * self.stride()..][..self.stride()]
    }

    /// Returns all rows of the map, with their left and right margins.
    fn inner_mut(&mut self) -> &mut [f32] {
        let stride = self.stride();
        &mut self.values[stride..(self.rows + 1) * stride]
    }

    /// Continues the map periodically into its margin.
    fn wrap(&mut self) {
        let (stride, columns) = (self.stride(), self.columns);
        for row in self.inner_mut().chunks_exact_mut(stride) {
            (row[0], row[columns + 1]) = (row[columns], row[1]);
        }
        let last = self.rows * stride;
        self.values.copy_within(last..last + stride, 0);
        self.values.copy_within(stride..2 * stride, last + stride);
    }
}

impl Pyramid {
    /// Creates the pyramid for maps of `rows` × `columns` square cells, periodic or zero beyond their edge. Returns
    /// `None` if the cells cannot be halved.
    pub(super) fn new(rows: usize, columns: usize, wraps: bool) -> Option<Self> {
        let fits = |levels: &usize| {
            let cells = 1 << levels;
            rows.is_multiple_of(cells) && columns.is_multiple_of(cells) && rows.min(columns) / cells >= COARSEST
        };
        let levels = (1..=FITS.len()).rev().find(fits)?;
        let (stencils, factor) = FITS[levels - 1];
        let (ny, nx) = (rows >> levels, columns >> levels);
        let torus = if wraps { (ny, nx) } else { (good_length(2 * ny), good_length(2 * nx)) };
        let coarsest = Convolution::new((ny, nx), torus);
        let step = |n: usize| std::f64::consts::TAU / (n << levels) as f64;
        let (step_x, step_y) = (step(torus.1), step(torus.0));
        let symbol = coarsest.symbol(|kx, ky| factor * (kx as f64 * step_x).hypot(ky * step_y));
        Some(Self { rows, columns, wraps, stencils, coarsest, symbol })
    }

    pub(super) fn work(&self) -> PyramidWork {
        let field = |level: usize| Field::new(self.rows >> level, self.columns >> level);
        let levels = self.stencils.len();
        PyramidWork {
            maps: (0..=levels).map(field).collect(),
            products: (1..=levels).map(field).collect(),
            coarsest: self.coarsest.work(),
            line: self.line(),
        }
    }

    fn line(&self) -> Line {
        Line { row: vec![0.0; self.columns + 2] }
    }

    /// Multiplies a map by about |q|, in radian per cell, and its mean by `mean`. `slabs` has one entry for each slab
    /// of rows: `fill` writes the rows of the map in order into zeros, `take` receives the rows of the product in
    /// order.
    pub(super) fn apply<S: Send>(
        &self,
        mean: f64,
        slabs: &mut [S],
        fill: impl Fn(&mut S, usize, &mut [f32]) -> bool + Sync,
        take: impl Fn(&mut S, usize, &[f32]) + Sync,
        work: &mut PyramidWork,
    ) {
        let PyramidWork { maps, products, coarsest, line } = work;
        let stride = maps[0].stride();
        let chunks = maps[0].inner_mut().chunks_mut(ROWS_OF_SLAB * stride);
        self.split(line, slabs.iter_mut().zip(chunks).enumerate(), |_, (number, (slab, rows))| {
            for (row, out) in rows.chunks_exact_mut(stride).enumerate() {
                out.fill(0.0);
                fill(slab, number * ROWS_OF_SLAB + row, &mut out[1..=self.columns]);
            }
        });
        self.continue_beyond(&mut maps[0]);
        for level in 1..maps.len() {
            let (finer, coarser) = maps.split_at_mut(level);
            self.restrict(&finer[level - 1], &mut coarser[0], line);
        }
        self.multiply_coarsest(mean, &maps[maps.len() - 1], &mut products[maps.len() - 2], coarsest);
        for level in (1..self.stencils.len()).rev() {
            let (finer, coarser) = products.split_at_mut(level);
            self.combine(level, &maps[level], &coarser[0], &mut finer[level - 1], line);
        }
        let (map, coarser) = (&maps[0], &products[0]);
        self.split(line, slabs.iter_mut().enumerate(), |line, (number, slab)| {
            let first = number * ROWS_OF_SLAB;
            for row in first..(first + ROWS_OF_SLAB).min(self.rows) {
                self.row(0, map, coarser, row, &mut line.row);
                take(slab, row, &line.row[1..=self.columns]);
            }
        });
    }

    /// Calls `work` on the items, in parallel if the map is large.
    fn split<I: Send>(&self, line: &mut Line, items: impl Iterator<Item = I>, work: impl Fn(&mut Line, I) + Sync) {
        if self.rows * self.columns < SHARED_FROM || rayon::current_num_threads() == 1 {
            items.for_each(|item| work(line, item));
        } else {
            blocks::for_each_with(items, || self.line(), work);
        }
    }

    fn continue_beyond(&self, field: &mut Field) {
        if self.wraps {
            field.wrap();
        }
    }

    fn restrict(&self, finer: &Field, coarser: &mut Field, line: &mut Line) {
        let (columns, stride) = (coarser.columns, coarser.stride());
        let chunks = coarser.inner_mut().chunks_mut(ROWS_OF_SLAB * stride).enumerate();
        self.split(line, chunks, |line, (number, rows)| {
            for (row, out) in rows.chunks_exact_mut(stride).enumerate() {
                let above = 2 * (number * ROWS_OF_SLAB + row);
                let rows = [0, 1, 2, 3].map(|row| finer.row(above + row));
                wide::<Restrict, _>((&mut out[1..=columns], rows, line.row.as_mut_slice()));
            }
        });
        self.continue_beyond(coarser);
    }

    fn multiply_coarsest(&self, mean: f64, map: &Field, product: &mut Field, work: &mut ConvolutionWork<f32>) {
        let (columns, stride) = (map.columns, map.stride());
        let mut slabs: Vec<&mut [f32]> = product.inner_mut().chunks_mut(ROWS_OF_SLAB * stride).collect();
        let fill = |_: &mut &mut [f32], row: usize, out: &mut [f32]| {
            out.copy_from_slice(&map.row(row + 1)[1..=columns]);
            true
        };
        let take = |slab: &mut &mut [f32], row: usize, values: &[f32]| {
            slab[row % ROWS_OF_SLAB * stride + 1..][..columns].copy_from_slice(values);
        };
        self.coarsest.forward(&self.symbol, 1.0, self.coarsest.factor(mean), &mut slabs, fill, work);
        self.coarsest.backward(&mut slabs, take, work);
        self.continue_beyond(product);
    }

    /// Computes the product on the grid of `level` from the product on the next coarser grid.
    fn combine(&self, level: usize, map: &Field, coarser: &Field, product: &mut Field, line: &mut Line) {
        let stride = product.stride();
        let chunks = product.inner_mut().chunks_mut(ROWS_OF_SLAB * stride).enumerate();
        self.split(line, chunks, |_, (number, rows)| {
            for (row, out) in rows.chunks_exact_mut(stride).enumerate() {
                self.row(level, map, coarser, number * ROWS_OF_SLAB + row, out);
            }
        });
        self.continue_beyond(product);
    }

    /// Computes a row, with its margin, of the product on the grid of `level`.
    fn row(&self, level: usize, map: &Field, coarser: &Field, row: usize, out: &mut [f32]) {
        let stencil = self.stencils[level];
        let out = &mut out[1..=map.columns];
        let near = coarser.row(row / 2 + 1);
        let other = coarser.row(if row.is_multiple_of(2) { row / 2 } else { row / 2 + 2 });
        wide::<Stencil, _>((out, [map.row(row), map.row(row + 1), map.row(row + 2)], [near, other], stencil));
    }
}

/// Averages four rows with their margins into one row of half as many cells; `sum` is scratch memory.
struct Restrict;

impl<'a> Kernel<(&'a mut [f32], [&'a [f32]; 4], &'a mut [f32])> for Restrict {
    type Output = ();

    #[inline(always)]
    fn run((out, [a, b, c, d], sum): (&'a mut [f32], [&'a [f32]; 4], &'a mut [f32])) {
        let n = 2 * out.len() + 2;
        let (a, b, c, d, sum) = (&a[..n], &b[..n], &c[..n], &d[..n], &mut sum[..n]);
        for i in 0..n {
            sum[i] = (a[i] + d[i]) + 3.0 * (b[i] + c[i]);
        }
        let pairs = sum.as_chunks::<2>().0;
        let (left, right) = (&pairs[..out.len()], &pairs[1..=out.len()]);
        for ((out, left), right) in out.iter_mut().zip(left).zip(right) {
            *out = (1.0 / 64.0) * ((left[0] + right[1]) + 3.0 * (left[1] + right[0]));
        }
    }
}

/// Applies the nine-point stencil to the middle of three rows with their margins. Adds the linear interpolation between
/// two rows of half as many cells, the nearer one first.
struct Stencil;

impl<'a> Kernel<(&'a mut [f32], [&'a [f32]; 3], [&'a [f32]; 2], (f32, f32))> for Stencil {
    type Output = ();

    #[inline(always)]
    fn run(
        (out, [above, here, below], [near, other], (edge, corner)): (
            &'a mut [f32],
            [&'a [f32]; 3],
            [&'a [f32]; 2],
            (f32, f32),
        ),
    ) {
        let n = out.len();
        let (above, here, below) = (&above[..n + 2], &here[..n + 2], &below[..n + 2]);
        let centre = 4.0 * (edge + corner);
        for i in 0..n {
            let left = above[i] + below[i];
            let middle = above[i + 1] + below[i + 1];
            let right = above[i + 2] + below[i + 2];
            let edges = middle + (here[i] + here[i + 2]);
            out[i] = centre * here[i + 1] - edge * edges - corner * (left + right);
        }
        let half = n / 2;
        let (near, other) = (&near[..half + 2], &other[..half + 2]);
        let pairs = &mut out.as_chunks_mut::<2>().0[..half];
        for i in 0..half {
            let left = 3.0 * near[i] + other[i];
            let middle = 3.0 * near[i + 1] + other[i + 1];
            let right = 3.0 * near[i + 2] + other[i + 2];
            pairs[i][0] += (1.0 / 16.0) * (3.0 * middle + left);
            pairs[i][1] += (1.0 / 16.0) * (3.0 * middle + right);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;

    fn applied(pyramid: &Pyramid, mean: f64, map: &[f32]) -> Vec<f32> {
        let columns = pyramid.columns;
        let mut product = vec![0.0; map.len()];
        let chunk = ROWS_OF_SLAB * columns;
        let mut slabs: Vec<_> = map.chunks(chunk).zip(product.chunks_mut(chunk)).collect();
        let fill = |slab: &mut (&[f32], &mut [f32]), row: usize, out: &mut [f32]| {
            out.copy_from_slice(&slab.0[row % ROWS_OF_SLAB * columns..][..columns]);
            true
        };
        let take = |slab: &mut (&[f32], &mut [f32]), row: usize, values: &[f32]| {
            slab.1[row % ROWS_OF_SLAB * columns..][..columns].copy_from_slice(values);
        };
        pyramid.apply(mean, &mut slabs, fill, take, &mut pyramid.work());
        product
    }

    fn noise(n: usize, index: u64) -> Vec<f32> {
        random::standard_normal(&mut random::stream(1, "pyramid", index), n).iter().map(|z| *z as f32).collect()
    }

    fn product(a: &[f32], b: &[f32]) -> f64 {
        a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
    }

    #[test]
    fn waves_are_multiplied_by_about_their_wavenumber() {
        for (rows, columns) in [(32, 32), (64, 96), (128, 128), (256, 512)] {
            let pyramid = Pyramid::new(rows, columns, true).unwrap();
            for (kx, ky) in [(1, 0), (0, 1), (2, 3), (5, 0), (7, 9), (columns / 4, rows / 3), (columns / 2, rows / 2)] {
                let turn = |k: usize, n: usize| std::f64::consts::TAU * k as f64 / n as f64;
                let (qx, qy) = (turn(kx, columns), turn(ky, rows));
                let phase = |i: usize| qx * (i % columns) as f64 + qy * (i / columns) as f64;
                let wave: Vec<f32> = (0..rows * columns).map(|i| phase(i).cos() as f32).collect();
                let ratio = product(&wave, &applied(&pyramid, 1.0, &wave)) / product(&wave, &wave) / qx.hypot(qy);
                assert!((0.73..1.08).contains(&ratio), "{rows} × {columns}, ({kx}, {ky}): {ratio}");
            }
            let flat = vec![2.0; rows * columns];
            assert!(applied(&pyramid, 3.0, &flat).iter().all(|z| (z - 6.0).abs() < 1e-4));
        }
    }

    #[test]
    fn it_is_symmetric_and_positive_for_both_boundaries() {
        for wraps in [true, false] {
            let (rows, columns) = (64, 32);
            let pyramid = Pyramid::new(rows, columns, wraps).unwrap();
            let (a, b) = (noise(rows * columns, 0), noise(rows * columns, 1));
            let (ma, mb) = (applied(&pyramid, 0.02, &a), applied(&pyramid, 0.02, &b));
            let (left, right) = (product(&b, &ma), product(&a, &mb));
            assert!((left - right).abs() < 1e-5 * product(&a, &ma), "{left} {right}");
            assert!(product(&a, &ma) > 0.0);
        }
    }

    #[test]
    fn only_the_coarsest_grid_couples_opposite_edges() {
        // A point at one edge of a map that is not periodic hardly changes the other edge, apart from the spread of |q|
        // itself.
        let (rows, columns) = (64, 64);
        let mut map = vec![0.0; rows * columns];
        map[5 * columns] = 1.0;
        let far_side = |wraps: bool| {
            let product = applied(&Pyramid::new(rows, columns, wraps).unwrap(), 0.0, &map);
            product[5 * columns + columns - 1].abs()
        };
        assert!(far_side(true) > 0.3 && far_side(false) < 1e-3, "{} {}", far_side(true), far_side(false));
    }

    #[test]
    fn cells_that_cannot_be_halved_have_no_pyramid() {
        for (rows, columns) in [(33, 64), (64, 31), (16, 64), (30, 64)] {
            assert!(Pyramid::new(rows, columns, true).is_none());
        }
        assert_eq!(Pyramid::new(96, 160, false).unwrap().stencils.len(), 2);
    }

    #[test]
    fn results_are_bit_identical_for_any_number_of_threads() {
        let (rows, columns) = (288, 320);
        let pyramid = Pyramid::new(rows, columns, true).unwrap();
        let map = noise(rows * columns, 2);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| applied(&pyramid, 0.1, &map))
        };
        assert_eq!(on(1), on(3));
    }
}
