//! Polynomials of a total degree.

use ndarray::Array2;

use asperity_base::blocks;
use asperity_base::map::HeightMap;
use asperity_base::numeric::solve_positive_definite;

/// The present points do not determine the polynomial.
#[derive(Debug)]
pub(super) struct Undetermined;

/// Returns sums of `count` values over the rows of a map. All threads work on rows, and rows are added in order, so the
/// result does not depend on the number of threads.
pub(super) fn sums_over_rows(rows: usize, count: usize, of_row: impl Fn(usize, &mut [f64]) + Sync) -> Vec<f64> {
    /// Number of rows that are added before their sum is passed on.
    const BLOCK: usize = 16;
    let blocks: Vec<Vec<f64>> = blocks::map(0..rows.div_ceil(BLOCK), |block| {
        let mut sums = vec![0.0; count];
        for row in block * BLOCK..((block + 1) * BLOCK).min(rows) {
            of_row(row, &mut sums);
        }
        sums
    });
    blocks.iter().fold(vec![0.0; count], |mut total, sums| {
        total.iter_mut().zip(sums).for_each(|(t, s)| *t += s);
        total
    })
}

/// Coordinates from −1 to 1 over the columns or rows with a present point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) centre: f64,
    pub(super) half: f64,
}

impl Span {
    /// Returns the spans of columns and rows.
    pub(super) fn of(map: &HeightMap) -> (Self, Self) {
        let ends = |place: fn((usize, usize)) -> usize| {
            let present = map.heights_m().indexed_iter().filter(|(_, z)| !z.is_nan());
            let (low, high) =
                present.fold((usize::MAX, 0), |(low, high), (at, _)| (low.min(place(at)), high.max(place(at))));
            // A single row has no extent. Its scaled coordinate is 0, and a slope is undetermined.
            let half = if high > low { 0.5 * (high - low) as f64 } else { 1.0 };
            Self { centre: 0.5 * (low + high) as f64, half }
        };
        (ends(|at| at.1), ends(|at| at.0))
    }

    fn at(self, index: usize) -> f64 {
        (index as f64 - self.centre) / self.half
    }
}

/// Number of times that the fit is repeated on its residual, which removes the rounding error of the normal equations.
const REFINEMENTS: usize = 2;

/// Returns the heights of the least-squares polynomial of total `degree` at every point of the map, in metre.
///
/// The basis consists of products P_a(u) P_b(v), a + b ≤ degree, of Legendre polynomials in coordinates from −1 to 1
/// over the present points. It is orthogonal on a full map except for the sampling. A row contributes P_b P_d times the
/// sums of P_a P_c over its present points to the normal equations, so a fit costs degree² operations per point instead
/// of degree⁴.
pub(super) fn fit(map: &HeightMap, degree: usize) -> Result<Array2<f64>, Undetermined> {
    let (ny, nx) = map.grid().shape();
    let (columns, rows) = Span::of(map);
    let one = degree + 1;
    let terms: Vec<(usize, usize)> = (0..one).flat_map(|sum| (0..=sum).map(move |b| (sum - b, b))).collect();
    let along_x: Vec<f64> = (0..nx).flat_map(|column| legendre(columns.at(column), degree)).collect();
    let along_y: Vec<f64> = (0..ny).flat_map(|row| legendre(rows.at(row), degree)).collect();
    let heights = map.heights_m();
    let n = terms.len();
    let gram = sums_over_rows(ny, n * n, |row, sums| {
        let mut products = vec![0.0; one * one];
        for (z, p) in heights.row(row).iter().zip(along_x.chunks_exact(one)) {
            if !z.is_nan() {
                for a in 0..one {
                    for c in 0..=a {
                        products[a * one + c] += p[a] * p[c];
                    }
                }
            }
        }
        let y = &along_y[row * one..(row + 1) * one];
        for (i, &(a, b)) in terms.iter().enumerate() {
            for (j, &(c, d)) in terms.iter().enumerate() {
                sums[i * n + j] += products[a.max(c) * one + a.min(c)] * y[b] * y[d];
            }
        }
    });
    // The mean is removed first, because roughness of nanometres may have an offset of millimetres.
    let present = (map.grid().points() - map.missing_points()) as f64;
    let mean_m = sums_over_rows(ny, 1, |row, sum| {
        sum[0] += heights.row(row).iter().filter(|z| !z.is_nan()).sum::<f64>();
    })[0]
        / present;
    let mut coefficients = vec![0.0; n];
    let value = |coefficients: &[f64], x: &[f64], y: &[f64]| -> f64 {
        terms.iter().zip(coefficients).map(|(&(a, b), c)| c * x[a] * y[b]).sum()
    };
    for _ in 0..=REFINEMENTS {
        let mut correction = sums_over_rows(ny, n, |row, sums| {
            let y = &along_y[row * one..(row + 1) * one];
            let mut products = vec![0.0; one];
            for (z, x) in heights.row(row).iter().zip(along_x.chunks_exact(one)) {
                if !z.is_nan() {
                    let left = (z - mean_m) - value(&coefficients, x, y);
                    products.iter_mut().zip(x).for_each(|(sum, p)| *sum += left * p);
                }
            }
            for (sum, &(a, b)) in sums.iter_mut().zip(&terms) {
                *sum += products[a] * y[b];
            }
        });
        if !solve_positive_definite(&mut gram.clone(), &mut correction) {
            return Err(Undetermined);
        }
        coefficients.iter_mut().zip(&correction).for_each(|(c, d)| *c += d);
    }
    let mut form = vec![0.0; nx * ny];
    blocks::for_each(form.chunks_exact_mut(nx).zip(along_y.chunks_exact(one)), |(out, y)| {
        for (z, x) in out.iter_mut().zip(along_x.chunks_exact(one)) {
            *z = mean_m + value(&coefficients, x, y);
        }
    });
    Ok(Array2::from_shape_fn((ny, nx), |(row, column)| form[row * nx + column]))
}

/// Returns P_0(u) … P_degree(u) by Bonnet's recurrence.
fn legendre(u: f64, degree: usize) -> Vec<f64> {
    let mut values = vec![1.0, u];
    for k in 1..degree {
        let k1 = k as f64;
        values.push(((2.0 * k1 + 1.0) * u * values[k] - k1 * values[k - 1]) / (k1 + 1.0));
    }
    values.truncate(degree + 1);
    values
}
