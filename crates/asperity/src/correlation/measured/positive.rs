//! Positive semi-definite sequences and their splines.

use ndarray::Array2;

use crate::fourier::{Complex64, RealFft2, good_length};

/// Lags kept beyond the end of a correlation for the tails of its spline, which fall by 0.27 from lag to lag.
const TAIL: usize = 16;

/// A correlation that is positive semi-definite, and how far it lies from what it was made of.
pub(super) struct PositiveCorrelation {
    pub(super) spline: Spline,
    /// Share of the variance in negative values of the spectrum.
    pub(super) clipped_variance: f64,
    /// Largest difference at any lag.
    pub(super) largest_change: f64,
}

/// The correlation k ⋆ k of the finite moving average k cut from the root of the clipped spectrum of `lags`, which is
/// positive semi-definite on the whole lattice.
///
/// Rows of `lags` are the lags 0 … R along y, columns −R … R along x, those of the other half plane being equal.
pub(super) fn made_positive(lags: &Array2<f64>) -> PositiveCorrelation {
    let (reach_y, reach_x) = (lags.nrows() as isize - 1, lags.ncols() as isize / 2);
    let given = |x: isize, y: isize| {
        let (x, y) = if y < 0 { (-x, -y) } else { (x, y) };
        if x.abs() <= reach_x && y <= reach_y { lags[[y as usize, (x + reach_x) as usize]] } else { 0.0 }
    };
    // Room for k ⋆ k without wrapping.
    let torus = Torus::new(4 * reach_x as usize + 1, 4 * reach_y as usize + 1);
    let mut spectrum = torus.spectrum(reach_x, reach_y, given);
    let negative = torus.sum(&spectrum, |value| (-value.re).max(0.0));
    let clipped_variance = negative / torus.sum(&spectrum, |value| value.re);
    for value in &mut spectrum {
        *value = value.re.max(0.0).sqrt().into();
    }
    let average = torus.values(spectrum);

    let mut spectrum = torus.spectrum(reach_x, reach_y, |x, y| average[torus.place(x, y)]);
    let variance = torus.sum(&spectrum, |value| value.norm_sqr());
    for value in &mut spectrum {
        *value = (value.norm_sqr() / variance).into();
    }
    let correlation = torus.values(spectrum.clone());
    let (far_x, far_y) = (2 * reach_x, 2 * reach_y);
    let mut largest_change = 0.0_f64;
    for y in 0..=far_y {
        for x in -far_x..=far_x {
            largest_change = largest_change.max((correlation[torus.place(x, y)] - given(x, y)).abs());
        }
    }
    let spline = torus.spline(spectrum, (far_x + TAIL as isize) as usize, (far_y + TAIL as isize) as usize);
    PositiveCorrelation { spline, clipped_variance, largest_change }
}

/// Sequences over lags that are closed at a distance.
struct Torus {
    fft: RealFft2,
}

impl Torus {
    /// A torus on which `lags_x` × `lags_y` lags and the tails of their spline do not meet.
    fn new(lags_x: usize, lags_y: usize) -> Self {
        Self { fft: RealFft2::new(good_length(lags_x + 2 * TAIL), good_length(lags_y + 2 * TAIL)) }
    }

    fn place(&self, x: isize, y: isize) -> usize {
        let (nx, ny) = (self.fft.nx() as isize, self.fft.ny() as isize);
        (y.rem_euclid(ny) * nx + x.rem_euclid(nx)) as usize
    }

    /// Spectrum of a sequence on |x| ≤ `reach_x`, |y| ≤ `reach_y`.
    fn spectrum(&self, reach_x: isize, reach_y: isize, value: impl Fn(isize, isize) -> f64) -> Vec<Complex64> {
        let mut values = vec![0.0; self.fft.nx() * self.fft.ny()];
        for y in -reach_y..=reach_y {
            for x in -reach_x..=reach_x {
                values[self.place(x, y)] = value(x, y);
            }
        }
        let mut spectrum = self.fft.spectrum();
        self.fft.forward(&values, &mut spectrum, &mut self.fft.workspace());
        spectrum
    }

    fn values(&self, mut spectrum: Vec<Complex64>) -> Vec<f64> {
        let mut values = vec![0.0; self.fft.nx() * self.fft.ny()];
        self.fft.inverse(&mut spectrum, &mut values, &mut self.fft.workspace());
        values
    }

    /// Mean of a function of the spectrum over all wavevectors.
    fn sum(&self, spectrum: &[Complex64], part: impl Fn(&Complex64) -> f64) -> f64 {
        let ny = self.fft.ny();
        let weighted = spectrum.iter().enumerate().map(|(i, value)| self.fft.multiplicity(i / ny) * part(value));
        weighted.sum::<f64>() / (self.fft.nx() * ny) as f64
    }

    /// The cubic spline through the sequence of this spectrum: its coefficients have the spectrum divided by that of the
    /// B-spline's samples ⅙, ⅔, ⅙, which is (2 + cos ω)/3 along each axis.
    fn spline(&self, mut spectrum: Vec<Complex64>, reach_x: usize, reach_y: usize) -> Spline {
        let (nx, ny) = (self.fft.nx(), self.fft.ny());
        let samples = |k: usize, n: usize| (2.0 + (std::f64::consts::TAU * k as f64 / n as f64).cos()) / 3.0;
        for (i, value) in spectrum.iter_mut().enumerate() {
            *value /= samples(i / ny, nx) * samples(i % ny, ny);
        }
        let values = self.values(spectrum);
        let coefficients = Array2::from_shape_fn((2 * reach_y + 1, 2 * reach_x + 1), |(row, column)| {
            values[self.place(column as isize - reach_x as isize, row as isize - reach_y as isize)]
        });
        Spline { coefficients }
    }
}

/// Σ c(i, j) B(x − i) B(y − j) with the cubic B-spline B, over lags −R … R.
#[derive(Debug, Clone)]
pub(super) struct Spline {
    coefficients: Array2<f64>,
}

impl Spline {
    /// Lags in points beyond which the spline is zero.
    pub(super) fn reach(&self) -> (usize, usize) {
        (self.coefficients.ncols() / 2 + 2, self.coefficients.nrows() / 2 + 2)
    }

    /// Value at a lag in points.
    pub(super) fn value(&self, x: f64, y: f64) -> f64 {
        let (rows, columns) = self.coefficients.dim();
        let (first_column, along_x) = weights(x, columns);
        let (first_row, along_y) = weights(y, rows);
        let mut sum = 0.0;
        for (row, weight_y) in (first_row..).zip(along_y) {
            for (column, weight_x) in (first_column..).zip(along_x) {
                if (0..rows as i64).contains(&row) && (0..columns as i64).contains(&column) {
                    sum += weight_y * weight_x * self.coefficients[[row as usize, column as usize]];
                }
            }
        }
        sum
    }
}

/// The first of the four coefficients of `n` that meet at a position, and their weights.
fn weights(position: f64, n: usize) -> (i64, [f64; 4]) {
    // Positions far beyond either end are all alike, and would not fit an integer.
    let place = (position + (n / 2) as f64).clamp(-4.0, n as f64 + 4.0);
    let t = place - place.floor();
    let (t2, t3) = (t * t, t * t * t);
    let weights = [
        (1.0 - t).powi(3) / 6.0,
        (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0,
        (1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t3) / 6.0,
        t3 / 6.0,
    ];
    (place.floor() as i64 - 1, weights)
}
