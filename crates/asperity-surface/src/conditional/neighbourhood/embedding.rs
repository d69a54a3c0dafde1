//! Unconditional field of a conditional surface.

use crate::spectral::wrapped_spectrum;
use crate::{GeneratorError, SpectralField};
use asperity_base::blocks;
use asperity_base::correlation::StationaryCovariance;
use asperity_base::fourier::{RealFft2, good_length};
use asperity_base::map::Grid;

/// Fraction of clipped variance, and correlation across the domain, below which a larger domain has no benefit.
const NEGLIGIBLE: f64 = 1e-12;
const DECAYED: f64 = 1e-6;
/// Largest number of points of a domain that is more than twice the grid.
pub(crate) const LARGEST_DOMAIN: usize = 1 << 22;

/// Creates a field like [`SpectralField::free`], but with a domain that grows only while the correlation reaches across
/// it. An invalid correlation, as used for many translations, has negative eigenvalues on every domain.
pub(super) fn embedded(covariance: &dyn StationaryCovariance, grid: Grid) -> Result<SpectralField, GeneratorError> {
    let (mut factor_x, mut factor_y) = (2, 2);
    loop {
        let (nx, ny) = (good_length(factor_x * grid.nx()), good_length(factor_y * grid.ny()));
        let domain = Grid::new(nx, ny, grid.dx_m(), grid.dy_m())?;
        let table = Table::new(covariance, domain);
        let fft = RealFft2::new(nx, ny);
        let spectrum = wrapped_spectrum(&table, domain, &fft);
        let (across_x, across_y) = table.largest_across();
        let enough = spectrum.clipped < NEGLIGIBLE || across_x.max(across_y) < DECAYED;
        if enough || 2 * domain.points() > LARGEST_DOMAIN {
            return Ok(SpectralField::from_spectrum(grid, domain, fft, covariance.std_m(), &spectrum));
        }
        *(if across_x > across_y { &mut factor_x } else { &mut factor_y }) *= 2;
    }
}

/// Correlations at the lags of a periodic domain of up to half its sides, each computed once.
struct Table {
    pitch_m: (f64, f64),
    half: (usize, usize),
    mirrors: bool,
    /// Rows are lags 0 … along y. Columns are lags along x, from zero with mirror symmetry, otherwise from minus half
    /// the domain.
    values: Vec<f64>,
}

impl Table {
    fn new(covariance: &dyn StationaryCovariance, domain: Grid) -> Self {
        let half = (domain.nx() / 2, domain.ny() / 2);
        let (pitch_m, mirrors) = ((domain.dx_m(), domain.dy_m()), covariance.mirror_symmetric());
        let first = if mirrors { 0.0 } else { -(half.0 as f64) };
        let columns = if mirrors { half.0 + 1 } else { 2 * half.0 + 1 };
        let mut values = vec![0.0; columns * (half.1 + 1)];
        blocks::for_each(values.chunks_mut(columns).enumerate(), |(row, out)| {
            for (column, value) in out.iter_mut().enumerate() {
                *value = covariance.correlation((first + column as f64) * pitch_m.0, row as f64 * pitch_m.1);
            }
        });
        Self { pitch_m, half, mirrors, values }
    }

    fn columns(&self) -> usize {
        self.values.len() / (self.half.1 + 1)
    }

    /// Returns the largest |ρ| at which the domain closes along x, and along y.
    fn largest_across(&self) -> (f64, f64) {
        let columns = self.columns();
        let largest = |values: &mut dyn Iterator<Item = &f64>| values.fold(0.0_f64, |m, v| m.max(v.abs()));
        let across_x = largest(&mut self.values.iter().skip(columns - 1).step_by(columns));
        let across_y = largest(&mut self.values[self.half.1 * columns..].iter());
        let other_x = if self.mirrors { 0.0 } else { largest(&mut self.values.iter().step_by(columns)) };
        (across_x.max(other_x), across_y)
    }
}

impl StationaryCovariance for Table {
    /// Returns 1; the table is used only for correlations.
    fn std_m(&self) -> f64 {
        1.0
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        let (x, y) = ((dx_m / self.pitch_m.0).round() as isize, (dy_m / self.pitch_m.1).round() as isize);
        let (x, y) = if y < 0 { (-x, -y) } else { (x, y) };
        let column = if self.mirrors { x.unsigned_abs() } else { (x + self.half.0 as isize) as usize };
        self.values[y as usize * self.columns() + column]
    }

    fn mirror_symmetric(&self) -> bool {
        self.mirrors
    }
}
