//! Positive semi-definite sequences and their splines.

use std::f64::consts::TAU;

use ndarray::Array2;

use crate::fourier::{Complex64, RealFft2, good_length, signed_index};

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

/// The correlation k ⋆ k of the finite moving average k cut from the root of the [balanced](Rings::balance) spectrum of `lags`,
/// which is positive semi-definite on the whole lattice.
///
/// Rows of `lags` are the lags 0 … R along y, columns −R … R along x, those of the other half plane being equal. The
/// wavenumber of a wavevector in radian per lag is in widths of the rings within which amounts are balanced.
pub(super) fn made_positive(lags: &Array2<f64>, wavenumber: impl Fn(f64, f64) -> f64) -> PositiveCorrelation {
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
    Rings::new(&torus, wavenumber).balance(&mut spectrum);
    for value in &mut spectrum {
        *value = value.re.sqrt().into();
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

/// Wavevectors of a spectrum, as places, by wavenumber.
struct Rings<'a> {
    torus: &'a Torus,
    /// Wavenumber of every place in widths of a ring.
    wavenumbers: Vec<f32>,
    count: usize,
}

impl<'a> Rings<'a> {
    /// `wavenumber` is that of a wavevector in radian per lag, in widths of a ring.
    fn new(torus: &'a Torus, wavenumber: impl Fn(f64, f64) -> f64) -> Self {
        let places = 0..torus.fft.spectrum_len();
        let wavenumbers: Vec<f32> = places.map(|place| torus.wavenumber(place, &wavenumber) as f32).collect();
        let count = wavenumbers.iter().fold(0.0_f32, |last, k| last.max(*k)) as usize + 1;
        Self { torus, wavenumbers, count }
    }

    /// Sums over the rings of a function of the wavenumber and the value.
    fn sums(&self, spectrum: &[Complex64], part: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.count];
        for (place, (value, k)) in spectrum.iter().zip(&self.wavenumbers).enumerate() {
            sums[*k as usize] += self.torus.multiplicity(place) * part(f64::from(*k), value.re);
        }
        sums
    }

    /// Sets negative values of a spectrum to zero and takes what they amount to from the positive ones of the same ring, all
    /// by the same factor; what a ring cannot pay falls to the next one inward.
    ///
    /// Amounts are counted in squared slopes q²P, so that the roughness of the map is kept at every wavelength: where the
    /// spectrum is nothing but noise about zero, half of that noise would else stay as a floor of roughness that the map has
    /// not. What then is missing of the variance is put back at the long waves, which hold half of it.
    fn balance(&self, spectrum: &mut [Complex64]) {
        let variance: f64 = self.sums(spectrum, |_, value| value).iter().sum();
        let slopes = self.sums(spectrum, |k, value| k * k * value);
        let positive = self.sums(spectrum, |k, value| k * k * value.max(0.0));
        let mut factors = vec![1.0; self.count];
        let mut debt = 0.0;
        for (factor, (all, positive)) in factors.iter_mut().zip(slopes.iter().zip(positive)).rev() {
            let left = all + debt;
            if positive > 0.0 {
                *factor = left.max(0.0) / positive;
                debt = left.min(0.0);
            }
        }
        let scale = |spectrum: &mut [Complex64], factors: &[f64]| {
            for (value, k) in spectrum.iter_mut().zip(&self.wavenumbers) {
                *value = (factors[*k as usize] * value.re.max(0.0)).into();
            }
        };
        scale(spectrum, &factors);
        let variances = self.sums(spectrum, |_, value| value);
        let missing = variance - variances.iter().sum::<f64>();
        let (mut half, mut rings) = (0.0, 0);
        while half < 0.5 * variance && rings < self.count {
            half += variances[rings];
            rings += 1;
        }
        factors.fill(1.0);
        factors[..rings].fill((1.0 + missing / half).max(0.0));
        scale(spectrum, &factors);
    }
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

    /// How often a place of the half spectrum stands in the whole.
    fn multiplicity(&self, place: usize) -> f64 {
        self.fft.multiplicity(place / self.fft.ny())
    }

    /// Wavenumber of a place of the spectrum. A wavevector on the edge of the zone is its own opposite along that axis, and
    /// has the lesser of the two wavenumbers.
    fn wavenumber(&self, place: usize, wavenumber: impl Fn(f64, f64) -> f64) -> f64 {
        let (nx, ny) = (self.fft.nx(), self.fft.ny());
        let (kx, ky) = (place / ny, place % ny);
        let phase = |k: usize, n: usize| TAU * signed_index(k, n) / n as f64;
        let (x, y) = (phase(kx, nx), phase(ky, ny));
        if 2 * kx == nx || 2 * ky == ny { wavenumber(x, y).min(wavenumber(-x, y)) } else { wavenumber(x, y) }
    }

    /// Mean of a function of the spectrum over all wavevectors.
    fn sum(&self, spectrum: &[Complex64], part: impl Fn(&Complex64) -> f64) -> f64 {
        let weighted = spectrum.iter().enumerate().map(|(place, value)| self.multiplicity(place) * part(value));
        weighted.sum::<f64>() / (self.fft.nx() * self.fft.ny()) as f64
    }

    /// The cubic spline through the sequence of this spectrum: its coefficients have the spectrum divided by that of the
    /// B-spline's samples ⅙, ⅔, ⅙, which is (2 + cos ω)/3 along each axis.
    fn spline(&self, mut spectrum: Vec<Complex64>, reach_x: usize, reach_y: usize) -> Spline {
        let (nx, ny) = (self.fft.nx(), self.fft.ny());
        let samples = |k: usize, n: usize| (2.0 + (TAU * k as f64 / n as f64).cos()) / 3.0;
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
