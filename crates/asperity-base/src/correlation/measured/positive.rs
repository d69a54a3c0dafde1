//! Positive semi-definite sequences and their spline interpolation.

use std::f64::consts::{PI, TAU};

use ndarray::Array2;

use crate::fourier::{Complex64, RealFft2, good_length, signed_index};

/// Number of lags kept beyond the end of a correlation for the tails of its spline, which fall by 0.27 per lag.
const TAIL: usize = 16;

/// Positive semi-definite correlation, and its difference from the given sequence.
pub(super) struct PositiveCorrelation {
    pub(super) spline: Spline,
    /// Fraction of the variance in negative values of the spectrum.
    pub(super) clipped_variance: f64,
    /// Largest absolute difference of a lag.
    pub(super) largest_change: f64,
}

/// Returns the correlation k ⋆ k of a finite moving average k, which is positive semi-definite on the infinite lattice.
/// k is the truncated square root of the [balanced](Rings::balance) spectrum of `lags`.
///
/// Rows of `lags` are the lags 0 … R along y, columns −R … R along x; the other half plane follows by symmetry.
/// `wavevector` maps a wavevector in radian per lag to coordinates in which the rings of the balance are circles of
/// unit width.
pub(super) fn made_positive(lags: &Array2<f64>, wavevector: impl Fn(f64, f64) -> (f64, f64)) -> PositiveCorrelation {
    let (reach_y, reach_x) = (lags.nrows() as isize - 1, lags.ncols() as isize / 2);
    let given = |x: isize, y: isize| {
        let (x, y) = if y < 0 { (-x, -y) } else { (x, y) };
        if x.abs() <= reach_x && y <= reach_y { lags[[y as usize, (x + reach_x) as usize]] } else { 0.0 }
    };
    // Space for k ⋆ k without periodic wrapping.
    let torus = Torus::new(4 * reach_x as usize + 1, 4 * reach_y as usize + 1);
    let mut spectrum = torus.spectrum(reach_x, reach_y, given);
    let negative = torus.sum(&spectrum, |value| (-value.re).max(0.0));
    let clipped_variance = negative / torus.sum(&spectrum, |value| value.re);
    Rings::new(&torus, wavevector).balance(&mut spectrum);
    for value in &mut spectrum {
        *value = value.re.sqrt().into();
    }
    let spectrum = torus.factored(spectrum, reach_x, reach_y);
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

/// Largest number of iterations.
const ITERATIONS: usize = 10;
/// Number of table intervals of a distortion over [−1, 1].
const TABLE: usize = 1 << 14;
/// Largest factor of a spectral density per iteration.
const LARGEST_FACTOR: f64 = 10.0;

/// Returns the spectrum of the correlation whose values, mapped by `distortion`, have a spectrum as close as possible
/// to that of `wanted`, with the periodic grid of the spectrum.
///
/// Each iteration multiplies the spectrum by the ratio of required and present densities, so it stays positive.
///
/// # References
/// Shields, Deodatis & Bocchini, *Prob. Eng. Mech.* **26** (2011) 511,
/// <https://doi.org/10.1016/j.probengmech.2011.04.003>.
pub(super) struct Beneath {
    torus: Torus,
    spectrum: Vec<f64>,
    reach: (isize, isize),
}

impl Beneath {
    pub(super) fn new(wanted: &Spline, distortion: impl Fn(f64) -> f64) -> Self {
        let (reach_x, reach_y) = (wanted.reach().0 as isize, wanted.reach().1 as isize);
        let torus = Torus::new(2 * reach_x as usize + 1, 2 * reach_y as usize + 1);
        let real = |spectrum: Vec<Complex64>| spectrum.into_iter().map(|value| value.re).collect::<Vec<f64>>();
        let target = real(torus.spectrum(reach_x, reach_y, |x, y| wanted.value(x as f64, y as f64)));
        // Rounding leaves small values of both signs where the required density is zero.
        let least = 1e-12 * target.iter().fold(0.0_f64, |most, value| most.max(*value));
        let target: Vec<f64> = target.into_iter().map(|value| value.max(least)).collect();
        let table: Vec<f64> =
            (0..=TABLE + 1).map(|i| distortion((2.0 * i as f64 / TABLE as f64 - 1.0).min(1.0))).collect();
        let distorted = |rho: f64| {
            let place = 0.5 * (rho.clamp(-1.0, 1.0) + 1.0) * TABLE as f64;
            let left = place.floor();
            table[left as usize] + (place - left) * (table[left as usize + 1] - table[left as usize])
        };
        let mut found = Self { torus, spectrum: target.clone(), reach: (reach_x, reach_y) };
        for _ in 0..ITERATIONS {
            found.normalise();
            let correlation = found.correlation();
            let torus = &found.torus;
            let met = torus.transform(&correlation.into_iter().map(distorted).collect::<Vec<f64>>());
            for ((value, target), met) in found.spectrum.iter_mut().zip(&target).zip(&met) {
                *value *= (target / met.re.max(least)).clamp(1.0 / LARGEST_FACTOR, LARGEST_FACTOR);
            }
        }
        found.normalise();
        found
    }

    fn correlation(&self) -> Vec<f64> {
        self.torus.values(self.spectrum.iter().map(|value| (*value).into()).collect())
    }

    /// Normalises the variance to one.
    fn normalise(&mut self) {
        let torus = &self.torus;
        let weighted = self.spectrum.iter().enumerate().map(|(place, value)| torus.multiplicity(place) * value);
        let variance = weighted.sum::<f64>() / torus.points();
        self.spectrum.iter_mut().for_each(|value| *value /= variance);
    }

    /// Returns the correlation with its spectrum multiplied by `factor` of the wavevector in radian per lag.
    ///
    /// The spectrum belongs to a periodic sequence. Truncating the correlation would not keep it positive
    /// semi-definite, so its square root is truncated at half the lags, as in [`made_positive`].
    pub(super) fn spline(&self, factor: impl Fn(f64, f64) -> f64) -> Spline {
        let root = |(place, value): (usize, &f64)| {
            let (x, y) = self.torus.wavevector(place, |x, y| (x, y));
            (value * factor(x, y)).sqrt().into()
        };
        // Allow for the tail of the spline beyond the lags.
        let half = |reach: isize| (reach - TAIL as isize) / 2;
        let (half_x, half_y) = (half(self.reach.0), half(self.reach.1));
        let spectrum = self.torus.factored(self.spectrum.iter().enumerate().map(root).collect(), half_x, half_y);
        self.torus.spline(spectrum, 2 * half_x as usize + TAIL, 2 * half_y as usize + TAIL)
    }
}

/// Number of sectors of a ring of wavevectors.
const SECTORS: usize = 4;

/// Wavevectors of a spectrum, by index, grouped into rings and sectors.
struct Rings<'a> {
    torus: &'a Torus,
    /// For every index the wavenumber in ring widths, and the bin of its ring and sector, ring by ring.
    wavenumbers: Vec<f32>,
    fields: Vec<u32>,
    count: usize,
}

impl<'a> Rings<'a> {
    /// `wavevector` maps a wavevector in radian per lag to coordinates in which rings are circles, in ring widths.
    fn new(torus: &'a Torus, wavevector: impl Fn(f64, f64) -> (f64, f64)) -> Self {
        let vectors = || (0..torus.fft.spectrum_len()).map(|place| torus.wavevector(place, &wavevector));
        let wavenumbers: Vec<f32> = vectors().map(|(x, y)| x.hypot(y) as f32).collect();
        // Sectors are centred on the axes and on the diagonals; opposite sectors are identified.
        let sector = |(x, y): (f64, f64)| (y.atan2(x) / PI * SECTORS as f64).round() as i32;
        let fields = vectors()
            .zip(&wavenumbers)
            .map(|(vector, k)| *k as u32 * SECTORS as u32 + sector(vector).rem_euclid(SECTORS as i32) as u32);
        let fields: Vec<u32> = fields.collect();
        let count = fields.iter().fold(0, |last, field| last.max(*field)) as usize / SECTORS + 1;
        Self { torus, wavenumbers, fields, count }
    }

    /// Returns the sums over each bin of a function of the wavenumber and the value.
    fn sums(&self, spectrum: &[Complex64], part: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.count * SECTORS];
        for (place, (value, field)) in spectrum.iter().zip(&self.fields).enumerate() {
            sums[*field as usize] +=
                self.torus.multiplicity(place) * part(f64::from(self.wavenumbers[place]), value.re);
        }
        sums
    }

    /// Sets negative values of a spectrum to zero and scales the positive ones of the same ring and sector down by the
    /// same amount; what exceeds them is passed on to the next ring inward.
    ///
    /// Amounts are measured in squared slopes q²P, so that the roughness of the map is preserved at every wavelength
    /// and in every direction. Otherwise half of the noise about zero would remain as a spurious noise floor. The
    /// deficit of the variance is restored at the long waves, which carry half of it.
    fn balance(&self, spectrum: &mut [Complex64]) {
        let variance: f64 = self.sums(spectrum, |_, value| value).iter().sum();
        let slopes = self.sums(spectrum, |k, value| k * k * value);
        let positive = self.sums(spectrum, |k, value| k * k * value.max(0.0));
        let mut factors = vec![1.0; self.count * SECTORS];
        for sector in 0..SECTORS {
            let mut debt = 0.0;
            for field in (sector..factors.len()).step_by(SECTORS).rev() {
                let left = slopes[field] + debt;
                if positive[field] > 0.0 {
                    factors[field] = left.max(0.0) / positive[field];
                }
                debt = left.min(0.0);
            }
        }
        let scale = |spectrum: &mut [Complex64], factors: &[f64]| {
            for (value, field) in spectrum.iter_mut().zip(&self.fields) {
                *value = (factors[*field as usize] * value.re.max(0.0)).into();
            }
        };
        scale(spectrum, &factors);
        let variances = self.sums(spectrum, |_, value| value);
        let missing = variance - variances.iter().sum::<f64>();
        let (mut half, mut inner) = (0.0, 0);
        while half < 0.5 * variance && inner < variances.len() {
            half += variances[inner..inner + SECTORS].iter().sum::<f64>();
            inner += SECTORS;
        }
        factors.fill(1.0);
        factors[..inner].fill((1.0 + missing / half).max(0.0));
        scale(spectrum, &factors);
    }
}

/// Periodic grid of lags.
pub(super) struct Torus {
    pub(super) fft: RealFft2,
}

impl Torus {
    /// Creates a grid large enough for `lags_x` × `lags_y` lags and the tails of their spline.
    fn new(lags_x: usize, lags_y: usize) -> Self {
        Self { fft: RealFft2::new(good_length(lags_x + 2 * TAIL), good_length(lags_y + 2 * TAIL)) }
    }

    fn place(&self, x: isize, y: isize) -> usize {
        let (nx, ny) = (self.fft.nx() as isize, self.fft.ny() as isize);
        (y.rem_euclid(ny) * nx + x.rem_euclid(nx)) as usize
    }

    /// Returns the spectrum of a sequence on |x| ≤ `reach_x`, |y| ≤ `reach_y`.
    fn spectrum(&self, reach_x: isize, reach_y: isize, value: impl Fn(isize, isize) -> f64) -> Vec<Complex64> {
        let mut values = vec![0.0; self.fft.nx() * self.fft.ny()];
        for y in -reach_y..=reach_y {
            for x in -reach_x..=reach_x {
                values[self.place(x, y)] = value(x, y);
            }
        }
        self.transform(&values)
    }

    pub(super) fn transform(&self, values: &[f64]) -> Vec<Complex64> {
        let mut spectrum = self.fft.spectrum();
        self.fft.forward(values, &mut spectrum, &mut self.fft.workspace());
        spectrum
    }

    /// Returns the spectrum of k ⋆ k over its variance, where k is the sequence with the spectrum `root` truncated to
    /// |x| ≤ `reach_x`, |y| ≤ `reach_y`.
    fn factored(&self, root: Vec<Complex64>, reach_x: isize, reach_y: isize) -> Vec<Complex64> {
        let average = self.values(root);
        let mut spectrum = self.spectrum(reach_x, reach_y, |x, y| average[self.place(x, y)]);
        let variance = self.sum(&spectrum, |value| value.norm_sqr());
        for value in &mut spectrum {
            *value = (value.norm_sqr() / variance).into();
        }
        spectrum
    }

    pub(super) fn values(&self, mut spectrum: Vec<Complex64>) -> Vec<f64> {
        let mut values = vec![0.0; self.fft.nx() * self.fft.ny()];
        self.fft.inverse(&mut spectrum, &mut values, &mut self.fft.workspace());
        values
    }

    /// Multiplicity of an index of the half spectrum in the full spectrum.
    pub(super) fn multiplicity(&self, place: usize) -> f64 {
        self.fft.multiplicity(place / self.fft.ny())
    }

    /// Returns a function of the wavevector of an index of the spectrum. A wavevector on the zone boundary equals its
    /// opposite along that axis; the shorter image counts.
    pub(super) fn wavevector(&self, place: usize, image: impl Fn(f64, f64) -> (f64, f64)) -> (f64, f64) {
        let (nx, ny) = (self.fft.nx(), self.fft.ny());
        let (kx, ky) = (place / ny, place % ny);
        let phase = |k: usize, n: usize| TAU * signed_index(k, n) / n as f64;
        let (x, y) = (phase(kx, nx), phase(ky, ny));
        let (own, other) = (image(x, y), image(-x, y));
        // If both images are equally long, opposite wavevectors take opposite images.
        let ((own_k, other_k), is_turned) = ((own.0.hypot(own.1), other.0.hypot(other.1)), own.0 * own.1 < 0.0);
        let is_shorter = other_k < own_k || (other_k == own_k && is_turned);
        if (2 * kx == nx || 2 * ky == ny) && is_shorter { other } else { own }
    }

    /// Returns the mean of a function of the spectrum over all wavevectors.
    pub(super) fn sum(&self, spectrum: &[Complex64], part: impl Fn(&Complex64) -> f64) -> f64 {
        let weighted = spectrum.iter().enumerate().map(|(place, value)| self.multiplicity(place) * part(value));
        weighted.sum::<f64>() / self.points()
    }

    pub(super) fn points(&self) -> f64 {
        (self.fft.nx() * self.fft.ny()) as f64
    }

    /// Returns the cubic spline interpolant of the sequence with this spectrum: the spectrum of its coefficients is
    /// divided by that of the B-spline samples ⅙, ⅔, ⅙, (2 + cos ω)/3 along each axis.
    pub(super) fn spline(&self, mut spectrum: Vec<Complex64>, reach_x: usize, reach_y: usize) -> Spline {
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

/// Cubic spline Σ c(i, j) B(x − i) B(y − j) with the B-spline B, over lags −R … R.
#[derive(Debug, Clone)]
pub(super) struct Spline {
    coefficients: Array2<f64>,
}

impl Spline {
    /// Returns the lags in points beyond which the spline is zero.
    pub(super) fn reach(&self) -> (usize, usize) {
        (self.coefficients.ncols() / 2 + 2, self.coefficients.nrows() / 2 + 2)
    }

    /// Returns the value at a lag in points.
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

/// Returns the index of the first of the four contributing coefficients of `n` at a position, and their weights.
fn weights(position: f64, n: usize) -> (i64, [f64; 4]) {
    // Clamp positions far outside, which would overflow an integer.
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
