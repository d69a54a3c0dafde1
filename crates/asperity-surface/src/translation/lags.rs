//! Correlations at all lags of a periodic domain, and their spectra.

use ndarray::Array2;

use super::{TranslationError, TranslationReport};
use asperity_base::correlation::StationaryCovariance;
use asperity_base::fourier::{RealFft2, Workspace};
use asperity_base::map::Grid;

/// Tolerance by which a correlation may exceed [−1, 1].
const ROUNDING: f64 = 1e-12;

/// Lags of a periodic domain, of which those up to `rows` − 1 and `columns` − 1 points count.
///
/// Spectra are unnormalised transforms S of correlations, in the order of [`RealFft2`]; ρ(0) = 1 means ΣS = number of
/// points.
pub(super) struct Lags {
    pub(super) domain: Grid,
    pub(super) fft: RealFft2,
    /// Counted lags along y and x, zero included.
    rows: usize,
    columns: usize,
    /// Whether ρ(−x, y) = ρ(x, y).
    mirrored: bool,
}

impl Lags {
    /// Creates all lags of a periodic grid, for correlations with the symmetry of `target`.
    pub(super) fn periodic(target: &dyn StationaryCovariance, grid: Grid) -> Self {
        let fft = RealFft2::new(grid.nx(), grid.ny());
        let (rows, columns) = (grid.ny() / 2 + 1, grid.nx() / 2 + 1);
        Self { domain: grid, fft, rows, columns, mirrored: target.mirror_symmetric() }
    }

    /// Creates the lags within `grid` on a domain of at least twice its sides, for correlations with the symmetry of
    /// `target`.
    pub(super) fn within(target: &dyn StationaryCovariance, grid: Grid, domain: Grid) -> Self {
        let fft = RealFft2::new(domain.nx(), domain.ny());
        Self { domain, fft, rows: grid.ny(), columns: grid.nx(), mirrored: target.mirror_symmetric() }
    }

    pub(super) fn points(&self) -> usize {
        self.domain.points()
    }

    /// Returns the correlation at the least image of every lag of the domain.
    pub(super) fn wrapped(&self, correlation: &dyn StationaryCovariance) -> Result<Vec<f64>, TranslationError> {
        let (nx, ny) = (self.domain.nx(), self.domain.ny());
        let mut wrapped = vec![0.0; nx * ny];
        let columns = if self.mirrored { nx / 2 + 1 } else { nx };
        for row in 0..=ny / 2 {
            for column in 0..columns {
                let (lag_x, lag_y) = (least_image(column, nx), row as f64);
                let (lag_x_m, lag_y_m) = (lag_x * self.domain.dx_m(), lag_y * self.domain.dy_m());
                let mut value = correlation.correlation(lag_x_m, lag_y_m);
                if !self.mirrored && (2 * column == nx || 2 * row == ny) {
                    // Lags of half a period are their own images from the other side.
                    value = 0.5 * (value + correlation.correlation(-lag_x_m, lag_y_m));
                }
                let at_zero = row == 0 && column == 0;
                if value.is_nan() || value.abs() > 1.0 + ROUNDING || (at_zero && value < 1.0 - ROUNDING) {
                    return Err(TranslationError::Target { lag_x_m, lag_y_m, value });
                }
                let (opposite_row, opposite_column) = ((ny - row) % ny, (nx - column) % nx);
                let mut set = |r: usize, c: usize| wrapped[r * nx + c] = value.clamp(-1.0, 1.0);
                set(row, column);
                set(opposite_row, opposite_column);
                if self.mirrored {
                    set(row, opposite_column);
                    set(opposite_row, column);
                }
            }
        }
        Ok(wrapped)
    }

    /// Returns the spectrum of an even map; its odd part is rounding and is dropped.
    pub(super) fn spectrum(&self, map: &[f64], work: &mut Workspace) -> Vec<f64> {
        let mut spectrum = self.fft.spectrum();
        self.fft.forward(map, &mut spectrum, work);
        let ny = self.fft.ny();
        (0..spectrum.len())
            .map(|place| {
                let (kx, ky) = (place / ny, place % ny);
                // Wavevectors on the edges of the stored half have their opposites there.
                let has_image = self.mirrored || kx == 0 || 2 * kx == self.domain.nx();
                if !has_image {
                    return spectrum[place].re;
                }
                0.5 * (spectrum[place].re + spectrum[kx * ny + (ny - ky) % ny].re)
            })
            .collect()
    }

    /// Returns the map of a spectrum.
    pub(super) fn map(&self, spectrum: &[f64], work: &mut Workspace) -> Vec<f64> {
        let mut complex = self.fft.spectrum();
        for (to, from) in complex.iter_mut().zip(spectrum) {
            to.re = *from;
        }
        let mut map = vec![0.0; self.points()];
        self.fft.inverse(&mut complex, &mut map, work);
        map
    }

    /// Returns the sum over all wavevectors, stored or not.
    pub(super) fn sum(&self, values: impl Iterator<Item = f64>) -> f64 {
        let ny = self.fft.ny();
        values.enumerate().map(|(place, value)| self.fft.multiplicity(place / ny) * value).sum()
    }

    /// Returns the fraction of the variance in negative eigenvalues.
    pub(super) fn negative_fraction(&self, spectrum: &[f64]) -> f64 {
        self.sum(spectrum.iter().map(|s| (-s).max(0.0))) / self.points() as f64
    }

    /// Sets negative eigenvalues to zero and scales the others to unit variance.
    pub(super) fn clip(&self, spectrum: &mut [f64]) {
        let scale = self.points() as f64 / self.sum(spectrum.iter().map(|s| s.max(0.0)));
        for s in spectrum {
            *s = s.max(0.0) * scale;
        }
    }

    /// Replaces a spectrum by the nearest one (in the sum of squares) that is non-negative and has unit variance: max(S
    /// − c, 0).
    ///
    /// # References
    /// Michelot, *J. Optim. Theory Appl.* **50** (1986) 195, <https://doi.org/10.1007/BF00938486>.
    pub(super) fn project(&self, spectrum: &mut [f64]) {
        let points = self.points() as f64;
        let mut offset = f64::NEG_INFINITY;
        loop {
            let kept = |s: &f64| *s > offset;
            let count = self.sum(spectrum.iter().map(|s| f64::from(u8::from(kept(s)))));
            let sum = self.sum(spectrum.iter().map(|s| if kept(s) { *s } else { 0.0 }));
            let next = (sum - points) / count;
            // The offset rises until no kept value is below it.
            if next <= offset || next.is_nan() {
                break;
            }
            offset = next;
        }
        for s in spectrum {
            *s = (*s - offset).max(0.0);
        }
    }

    /// Returns whether the lag at this place of a map counts.
    pub(super) fn counts(&self, place: usize) -> bool {
        let (nx, ny) = (self.domain.nx(), self.domain.ny());
        let (row, column) = (place / nx, place % nx);
        row.min(ny - row) < self.rows && column.min(nx - column) < self.columns
    }

    /// Returns the counted lags of one quadrant, shape `[lags along y, lags along x]`.
    pub(super) fn quadrant(&self, map: &[f64]) -> Array2<f64> {
        Array2::from_shape_fn((self.rows, self.columns), |(row, column)| map[row * self.domain.nx() + column])
    }

    /// Returns the least value of a map at the counted lags.
    pub(super) fn least(&self, map: &[f64]) -> f64 {
        let counted = map.iter().enumerate().filter(|(place, _)| self.counts(*place));
        counted.map(|(_, value)| *value).fold(f64::INFINITY, f64::min)
    }

    /// Returns the deviation of two correlations at the counted lags.
    pub(super) fn deviation(&self, met: &[f64], target: &[f64]) -> TranslationReport {
        let mut report = TranslationReport { largest_deviation: 0.0, lag_x_m: 0.0, lag_y_m: 0.0, rms_deviation: 0.0 };
        let (nx, mut count) = (self.domain.nx(), 0.0);
        // One quadrant determines a mirror-symmetric correlation, two determine any other.
        let left = if self.mirrored { 0 } else { self.columns.min(nx.div_ceil(2)) - 1 };
        for row in 0..self.rows {
            for column in (0..self.columns).chain(nx - left..nx) {
                let place = row * nx + column;
                let difference = met[place] - target[place];
                report.rms_deviation += difference * difference;
                count += 1.0;
                if difference.abs() > report.largest_deviation {
                    let lag_x_m = least_image(column, nx) * self.domain.dx_m();
                    let lag_y_m = row as f64 * self.domain.dy_m();
                    report = TranslationReport { largest_deviation: difference.abs(), lag_x_m, lag_y_m, ..report };
                }
            }
        }
        report.rms_deviation = (report.rms_deviation / count).sqrt();
        report
    }
}

/// Returns the lag of least size that is `column` points on a circle of `n`.
fn least_image(column: usize, n: usize) -> f64 {
    if 2 * column <= n { column as f64 } else { column as f64 - n as f64 }
}
