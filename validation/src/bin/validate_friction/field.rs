//! Synthetic processes of known correlation and marginal distribution on cells, and windows that slide over them.

use asperity::distribution::Marginal;
use asperity::distribution::translation::Translation;
use asperity::fourier::{Complex64, RealFft2};
use asperity::random;

use super::Result;

/// Periodic process of correlation e^{−s/ℓ} with a given marginal distribution, on cells of length 1.
pub(crate) struct Field {
    marginal: Option<Marginal>,
    fft: RealFft2,
    /// Standard deviations of the Fourier coefficients of the normal process.
    amplitudes: Vec<f64>,
}

impl Field {
    /// Creates a process of ℓ = `length` cells on `cells` cells; its correlation is the sum of e^{−s/ℓ} over all periods. It is normal
    /// without a marginal distribution.
    pub(crate) fn new(length: f64, cells: usize, marginal: Option<Marginal>) -> Result<Self> {
        let fft = RealFft2::new(cells, 1);
        // Σ e^{−|s + mP|/ℓ} over all periods is a ratio of cosh.
        let half = cells as f64 / 2.0;
        let wrapped = |lag: f64| {
            let x = half - lag.min(cells as f64 - lag);
            ((x - half) / length).exp() * (1.0 + (-2.0 * x / length).exp()) / (1.0 + (-2.0 * half / length).exp())
        };
        let translation = marginal.as_ref().map(Translation::new).transpose()?;
        let mut lags = Vec::with_capacity(cells);
        for lag in 0..cells {
            let target = wrapped(lag as f64);
            lags.push(translation.as_ref().map_or(Ok(target), |found| found.normal_correlation(target))?);
        }
        let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
        fft.forward(&lags, &mut spectrum, &mut work);
        let amplitudes = spectrum.iter().map(|value| value.re.max(0.0).sqrt()).collect();
        Ok(Self { marginal, fft, amplitudes })
    }

    /// Returns one realisation.
    pub(crate) fn draw(&self, stage: &str, index: u64) -> Vec<f64> {
        let n = self.fft.nx();
        let mut values = random::standard_normal(&mut random::stream(77, stage, index), n);
        let (mut spectrum, mut work) = (self.fft.spectrum(), self.fft.workspace());
        self.fft.forward(&values, &mut spectrum, &mut work);
        for (value, amplitude) in spectrum.iter_mut().zip(&self.amplitudes) {
            *value = Complex64::new(value.re * amplitude, value.im * amplitude);
        }
        self.fft.inverse(&mut spectrum, &mut values, &mut work);
        if let Some(marginal) = &self.marginal {
            values.iter_mut().for_each(|value| *value = marginal.translate(*value));
        }
        values
    }
}

/// Returns means over windows of `window` cells moved by `step` cells. Windows wrap around the end of a periodic record.
pub(crate) fn averaged(cells: &[f64], window: usize, step: usize, periodic: bool) -> Vec<f64> {
    let mut sums = vec![0.0];
    let extra = if periodic { window } else { 0 };
    for value in cells.iter().chain(&cells[..extra]) {
        sums.push(sums[sums.len() - 1] + value);
    }
    let positions = if periodic { cells.len() } else { cells.len() - window + 1 };
    (0..positions).step_by(step).map(|start| (sums[start + window] - sums[start]) / window as f64).collect()
}
