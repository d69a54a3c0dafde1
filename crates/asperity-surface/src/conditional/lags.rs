//! Correlations between points of a grid.

use crate::spectral::FourierModes;
use asperity_base::fourier::Complex64;

/// Correlations at lags in points.
#[derive(Debug)]
pub(super) struct Lags {
    nx: usize,
    ny: usize,
    values: Vec<f64>,
}

impl Lags {
    /// Computes the lags of the field of these modes on its periodic domain.
    pub(super) fn of(modes: &FourierModes) -> Self {
        let mut spectrum: Vec<Complex64> = modes.spectrum_m2().into_iter().map(Complex64::from).collect();
        let fft = modes.fft();
        let mut values = vec![0.0; fft.nx() * fft.ny()];
        fft.inverse(&mut spectrum, &mut values, &mut fft.workspace());
        let variance = values[0];
        values.iter_mut().for_each(|value| *value /= variance);
        Self { nx: fft.nx(), ny: fft.ny(), values }
    }

    /// Returns the correlation at a lag smaller than the grid.
    pub(super) fn at(&self, lag_x: isize, lag_y: isize) -> f64 {
        let (nx, ny) = (self.nx as isize, self.ny as isize);
        let column = if lag_x < 0 { lag_x + nx } else { lag_x };
        let row = if lag_y < 0 { lag_y + ny } else { lag_y };
        self.values[(row * nx + column) as usize]
    }
}
