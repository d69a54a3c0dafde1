//! Correlations of periodic maps.

use super::{NEGLIGIBLE, WrappedSpectrum, embedding};
use asperity_base::correlation::StationaryCovariance;
use asperity_base::fourier::RealFft2;
use asperity_base::map::Grid;

/// Largest excess of the variance of a sum of images, which is scaled away.
const EXCESS: f64 = 0.02;

/// Covariance of the periodic maps of a grid that stand for a wide surface.
///
/// A covariance that is wrapped at its least image has a kink at half the side. Where the correlation has not decayed there, the
/// kink has negative eigenvalues, and setting these to zero would add short waves. Then the eigenvalues are taken from a domain of
/// several times the side, on which none is negative:
///
/// - At the wavevectors of the grid. The covariance is the sum of all images, Σ C(h + mL), scaled to its variance.
/// - If that sum has too much variance, because the side is short for the correlation: the mean over the band that each
///   wavevector stands for, which keeps the variance. Waves longer than the side become constant along it.
pub(crate) struct OnPeriod<'a> {
    covariance: &'a dyn StationaryCovariance,
    /// Correlation at the lags of the grid, row by row, if it is not the wrapped one.
    table: Option<Vec<f64>>,
    grid: Grid,
    /// Fraction of the variance in negative eigenvalues, of the wrapped covariance or on the domain.
    pub(crate) clipped: f64,
}

impl<'a> OnPeriod<'a> {
    /// Computes the covariance of periodic maps on `grid`.
    pub(crate) fn new(covariance: &'a dyn StationaryCovariance, grid: Grid) -> Self {
        let wrapped = |clipped| Self { covariance, table: None, grid, clipped };
        let Ok((domain, fft, WrappedSpectrum { eigenvalues_m2, clipped })) = embedding(covariance, grid, 1, |n| n)
        else {
            return wrapped(0.0);
        };
        let factors = (domain.nx() / grid.nx(), domain.ny() / grid.ny());
        // What is no correlation is for others to refuse.
        let known = |place: usize| {
            let (x, y) = ((place % grid.nx()) as f64, (place / grid.nx()) as f64);
            covariance.correlation(x * grid.dx_m(), y * grid.dy_m()).abs() <= 1.0 + NEGLIGIBLE
        };
        if factors == (1, 1) || !(0..grid.points()).all(known) {
            return wrapped(clipped);
        }
        let images = correlation(&means(&eigenvalues_m2, &fft, factors, |_| 0), grid);
        let table = match images[0] {
            variance if variance <= 1.0 + EXCESS => images.iter().map(|value| value / variance).collect(),
            _ => correlation(&means(&eigenvalues_m2, &fft, factors, |factor| factor / 2), grid),
        };
        Self { table: Some(table), ..wrapped(clipped) }
    }
}

/// Returns the correlation of eigenvalues on a grid, row by row.
fn correlation(eigenvalues_m2: &[f64], grid: Grid) -> Vec<f64> {
    let fft = RealFft2::new(grid.nx(), grid.ny());
    let mut spectrum = fft.spectrum();
    for (to, eigenvalue_m2) in spectrum.iter_mut().zip(eigenvalues_m2) {
        to.re = eigenvalue_m2 / grid.cell_area_m2();
    }
    let mut correlation = vec![0.0; grid.points()];
    fft.inverse(&mut spectrum, &mut correlation, &mut fft.workspace());
    correlation
}

/// Returns means of the eigenvalues of a domain around each wavevector of a grid whose sides are those of the domain over `factors`.
/// A mean reaches `half` of a factor to both sides, of which the two ends count half.
fn means(
    eigenvalues: &[f64],
    domain: &RealFft2,
    factors: (usize, usize),
    half: impl Fn(usize) -> usize + Copy,
) -> Vec<f64> {
    let (nx, ny) = (domain.nx(), domain.ny());
    let stored = |kx: usize, ky: usize| {
        let (kx, ky) = if 2 * kx > nx { (nx - kx, (ny - ky) % ny) } else { (kx, ky) };
        eigenvalues[kx * ny + ky]
    };
    let band = |factor: usize, centre: usize, n: usize| {
        let half = half(factor);
        (0..=2 * half).map(move |i| {
            let weight = if half > 0 && (i == 0 || i == 2 * half) { 0.5 } else { 1.0 };
            ((centre * factor + n + i - half) % n, weight / (2 * half).max(1) as f64)
        })
    };
    let (own_nx, own_ny) = (nx / factors.0, ny / factors.1);
    (0..=own_nx / 2)
        .flat_map(|kx| (0..own_ny).map(move |ky| (kx, ky)))
        .map(|(kx, ky)| {
            band(factors.0, kx, nx)
                .map(|(x, weight)| weight * band(factors.1, ky, ny).map(|(y, w)| w * stored(x, y)).sum::<f64>())
                .sum()
        })
        .collect()
}

impl StationaryCovariance for OnPeriod<'_> {
    fn std_m(&self) -> f64 {
        self.covariance.std_m()
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        let Some(table) = &self.table else { return self.covariance.correlation(dx_m, dy_m) };
        let place =
            |lag_m: f64, pitch_m: f64, n: usize| ((lag_m / pitch_m).round() as i64).rem_euclid(n as i64) as usize;
        let (row, column) =
            (place(dy_m, self.grid.dy_m(), self.grid.ny()), place(dx_m, self.grid.dx_m(), self.grid.nx()));
        table[row * self.grid.nx() + column]
    }

    fn mirror_symmetric(&self) -> bool {
        self.covariance.mirror_symmetric()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::wrapped_spectrum;
    use crate::{GaussianSurface, SpectralField};
    use asperity_base::correlation::{CorrelationModel, Covariance, Rotated};

    fn squared_exponential(length_m: f64) -> Covariance {
        Covariance::isotropic(CorrelationModel::SquaredExponential, 1.0, length_m).unwrap()
    }

    /// Returns the mean squared differences of neighbours along x and y.
    fn slopes(covariance: impl Fn(usize, usize) -> f64) -> [f64; 2] {
        [2.0 * (covariance(0, 0) - covariance(1, 0)), 2.0 * (covariance(0, 0) - covariance(0, 1))]
    }

    #[test]
    fn a_strip_narrower_than_its_waves_has_no_other_waves() {
        let long = |model| Covariance::isotropic(model, 1.0, 24.0).unwrap();
        let (smooth, rough) = (squared_exponential(24.0), long(CorrelationModel::SelfAffine { hurst: 0.5 }));
        let lay = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 30.0, 9.0).unwrap();
        let oblique = Rotated::new(lay, 0.6).unwrap();
        let grid = Grid::new(256, 16, 1.0, 1.0).unwrap();
        // Short waves have their slopes. Waves that are longer than the strip is wide are constant across it, which are almost all of
        // the smooth ones; those of the oblique lay, 9 wide on 16, are drawn to the nearest waves that fit.
        for (covariance, least, most) in
            [(&rough as &dyn StationaryCovariance, 0.98, 1.02), (&smooth, 0.7, 1.0), (&oblique, 0.9, 1.1)]
        {
            let wanted = slopes(|x, y| covariance.correlation(x as f64, y as f64));
            assert!(wrapped_spectrum(covariance, grid, &RealFft2::new(256, 16)).clipped > 1e-4);
            let field = SpectralField::periodic(covariance, grid);
            assert!(field.clipped_variance() < NEGLIGIBLE);
            let met = field.covariance_with_m2(0, 0);
            let found = slopes(|x, y| met[[y, x]]);
            let sdq = |squares: [f64; 2]| (squares[0] + squares[1]).sqrt();
            let ratio = sdq(found) / sdq(wanted);
            println!("{ratio}: {found:?} for {wanted:?}");
            assert!((found[0] / wanted[0] - 1.0).abs() < 0.02 && least < ratio && ratio < most, "{ratio}: {found:?}");
        }
    }

    #[test]
    fn means_over_bands_are_the_covariance_under_their_window() {
        // Over Δk = 2π/L they multiply the covariance by W(h) = Σ_j w_j cos(2πjh/fL), on every image h + mL.
        let covariance = squared_exponential(24.0);
        let periodic = OnPeriod::new(&covariance, Grid::new(64, 10, 1.0, 1.0).unwrap());
        let along = |lag: f64, n: f64, factor: i32| -> f64 {
            let half = factor / 2;
            let window = |h: f64| -> f64 {
                let term = |j: i32| (std::f64::consts::TAU * f64::from(j) * h / (f64::from(factor) * n)).cos();
                (-half..=half).map(|j| if j.abs() == half { 0.5 } else { 1.0 } * term(j)).sum::<f64>()
                    / f64::from(factor)
            };
            let images =
                (-half..=half).map(|m| lag + f64::from(m) * n).filter(|h| h.abs() <= 0.5 * f64::from(factor) * n);
            images.map(|h| (-(h / 24.0).powi(2)).exp() * window(h)).sum()
        };
        // The first domains without negative eigenvalues: 4 × 64 and 32 × 10 points.
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (7.0, 3.0), (31.0, 4.0)] {
            let wanted = along(x, 64.0, 4) * along(y, 10.0, 32);
            let found = periodic.correlation(x, y);
            assert!((found - wanted).abs() < 1e-9, "({x}, {y}): {found} {wanted}");
        }
    }

    #[test]
    fn a_covariance_that_has_almost_decayed_is_the_sum_of_its_images() {
        let covariance = squared_exponential(5.0);
        let periodic = OnPeriod::new(&covariance, Grid::new(20, 32, 1.0, 1.0).unwrap());
        let along =
            |lag: f64, n: f64| -> f64 { [-n, 0.0, n].iter().map(|image| (-((lag + image) / 5.0).powi(2)).exp()).sum() };
        let scale = along(0.0, 20.0) * along(0.0, 32.0);
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (10.0, 16.0), (-7.0, 9.0)] {
            assert!((periodic.correlation(x, y) - along(x, 20.0) * along(y, 32.0) / scale).abs() < 1e-12);
        }
        // Wide enough, it is wrapped.
        assert!(OnPeriod::new(&covariance, Grid::new(64, 64, 1.0, 1.0).unwrap()).table.is_none());
    }
}
