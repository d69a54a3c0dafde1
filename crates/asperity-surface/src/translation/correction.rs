//! Gaussian spectrum whose translation comes closest to a target correlation.

#[cfg(test)]
mod tests;

use ndarray::Array2;

use super::lags::Lags;
use super::{Predistorted, TranslationError, TranslationReport};
use crate::spectral::{NEGLIGIBLE, OnPeriod, WrappedSpectrum};
use crate::{GeneratorError, SpectralField};
use asperity_base::blocks;
use asperity_base::correlation::StationaryCovariance;
use asperity_base::distribution::{Marginal, translation::Translation};
use asperity_base::fourier::{Workspace, good_length};
use asperity_base::map::Grid;

/// Largest side of an embedding domain over the side of the grid, and its largest number of points.
const LARGEST_FACTOR: usize = 8;
const LARGEST_DOMAIN: usize = 1 << 22;
/// Number of previous values of the objective; a step must go below the largest of them.
const MEMORY: usize = 8;
/// Relative decrease of the sum of squares over [`MEMORY`] steps below which the descent has stalled.
const LEAST_GAIN: f64 = 1e-3;
/// Fraction of the slope that a step must gain (Armijo), and the least fraction of a step that is tried.
const SUFFICIENT: f64 = 1e-4;
const LEAST_FRACTION: f64 = 1e-6;

/// Corrected translation by Fourier synthesis: the Gaussian field whose translated correlation equals a target, or
/// comes as close to it as possible.
///
/// Pre-distortion, ρ_G = T⁻¹(ρ_X) with T the distortion by the distribution, is exact if ρ_G has no negative spectrum.
/// Otherwise the negative part is clipped. If the deviation then exceeds the tolerance, a search finds the spectrum S ≥
/// 0 of ρ_G with least Σ (T(ρ_G) − ρ_X)² over the lags. As in the translation approximation of Shields, Deodatis &
/// Bocchini, steps alternate between the marginal transform ρ_G → T(ρ_G) and spectra that cannot be negative. Their
/// method multiplies the spectrum by the ratio of target and achieved spectra. Here the spectrum moves against the
/// gradient of the sum of squares and back onto the nearest non-negative spectrum of unit variance (spectral projected
/// gradients), which is a guaranteed descent with smaller deviations.
///
/// # References
/// Shields, Deodatis & Bocchini, *Prob. Eng. Mech.* **26** (2011) 511,
/// <https://doi.org/10.1016/j.probengmech.2011.04.003>; Birgin, Martínez & Raydan, *SIAM J. Optim.* **10** (2000) 1196,
/// <https://doi.org/10.1137/S1052623497330963>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TranslationCorrection {
    /// Deviation |ρ − target| at which the search ends.
    pub tolerance: f64,
    /// Largest number of iterations.
    pub iterations: usize,
}

impl Default for TranslationCorrection {
    /// Returns a deviation of 1e-3, which is below the sampling error of any map's correlation, and 100 iterations.
    fn default() -> Self {
        Self { tolerance: 1e-3, iterations: 100 }
    }
}

/// A Gaussian field to be translated, and the deviation of its translation from the target.
#[derive(Debug, Clone)]
pub struct CorrectedField {
    /// The Gaussian field, with the standard deviation of the target.
    pub field: SpectralField,
    /// Deviation from the target.
    pub report: CorrectionReport,
}

/// Feasibility of a target correlation for a translated field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feasibility {
    /// Least correlation that the distribution allows, at ρ_G = −1.
    pub least_correlation: f64,
    /// Least value of the target at the lags of the map.
    pub least_target: f64,
    /// Fraction of the variance in negative eigenvalues of the target itself, wrapped onto the domain. A positive value
    /// means that the map contains too few correlation lengths, or that the target is no correlation.
    pub target_negative_fraction: f64,
    /// Fraction of the variance in negative eigenvalues of the pre-distorted correlation. If it is positive, no
    /// Gaussian field has the target as its translation.
    pub predistorted_negative_fraction: f64,
}

/// Target and achieved correlation of a translated field at the lags of its map, without sampling: on a periodic grid
/// up to half the sides, on a free grid all lags.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectionReport {
    /// Feasibility of the target.
    pub feasibility: Feasibility,
    /// Deviation of plain translation, whose Gaussian field has the correlation of the target.
    pub plain: TranslationReport,
    /// Deviation after pre-distortion and one clipping.
    pub predistorted: TranslationReport,
    /// Final deviation.
    pub corrected: TranslationReport,
    /// Iterations after pre-distortion.
    pub iterations: usize,
    /// Whether the deviation is within the tolerance.
    pub converged: bool,
    /// The target, shape `[lags along y, lags along x]`, in steps of the grid.
    pub target: Array2<f64>,
    /// The correlation of plain translation at the same lags.
    pub achieved_plain: Array2<f64>,
    /// The achieved correlation at the same lags.
    pub achieved: Array2<f64>,
}

impl TranslationCorrection {
    /// Computes the Gaussian field on the periodic `grid`.
    ///
    /// # Errors
    /// A distribution with a parameter outside its range, or a target that is not in [−1, 1] or not 1 at zero.
    pub fn periodic(
        &self,
        target: &dyn StationaryCovariance,
        marginal: &Marginal,
        grid: Grid,
    ) -> Result<CorrectedField, TranslationError> {
        let target = OnPeriod::new(target, grid);
        self.field(&target, marginal, grid, &Lags::periodic(&target, grid))
    }

    /// Computes the Gaussian field on a `grid` whose opposite edges are independent: a crop of a periodic domain of at
    /// least twice the sides. Only the lags within the grid count; beyond them the correlation is unconstrained.
    ///
    /// # Errors
    /// The errors of [`TranslationCorrection::periodic`].
    pub fn free(
        &self,
        target: &dyn StationaryCovariance,
        marginal: &Marginal,
        grid: Grid,
    ) -> Result<CorrectedField, TranslationError> {
        let lags = embedding(target, grid)?;
        self.field(target, marginal, grid, &lags)
    }

    fn field(
        &self,
        target: &dyn StationaryCovariance,
        marginal: &Marginal,
        grid: Grid,
        lags: &Lags,
    ) -> Result<CorrectedField, TranslationError> {
        let translation = Translation::new(marginal)?;
        let mut work = lags.fft.workspace();
        let wanted = lags.wrapped(target)?;
        let unclipped = lags.spectrum(&wanted, &mut work);
        // Targets below the least correlation of the distribution are raised to it.
        let normal = lags.wrapped(&Predistorted::new(Borrowed(target), marginal)?)?;
        let predistorted = lags.spectrum(&normal, &mut work);
        let least_target = lags.least(&wanted);
        let feasibility = Feasibility {
            least_correlation: translation.least_correlation(),
            least_target,
            target_negative_fraction: lags.negative_fraction(&unclipped),
            predistorted_negative_fraction: lags.negative_fraction(&predistorted),
        };
        let mut search = Search { lags, translation: &translation, target: &wanted, least_gain: LEAST_GAIN, work };

        let mut plain_spectrum = unclipped;
        lags.clip(&mut plain_spectrum);
        let plain = search.translated(&plain_spectrum);
        let mut clipped = predistorted.clone();
        lags.clip(&mut clipped);
        let once = search.translated(&clipped);
        let [plain_deviation, once_deviation] = [&plain, &once].map(|met| lags.deviation(met, &wanted));
        let first = Best { spectrum: clipped, deviation: once_deviation };
        let Descent { best, iterations, .. } = search.descend(self, predistorted, first);
        let achieved = search.translated(&best.spectrum);

        let report = CorrectionReport {
            feasibility,
            plain: plain_deviation,
            predistorted: once_deviation,
            corrected: best.deviation,
            iterations,
            converged: best.deviation.largest_deviation <= self.tolerance,
            target: lags.quadrant(&wanted),
            achieved_plain: lags.quadrant(&plain),
            achieved: lags.quadrant(&achieved),
        };
        let cell_m2 = lags.domain.cell_area_m2();
        let spectrum = WrappedSpectrum {
            eigenvalues_m2: best.spectrum.iter().map(|s| s * cell_m2).collect(),
            clipped: feasibility.predistorted_negative_fraction,
        };
        let field = SpectralField::from_spectrum(grid, lags.domain, lags.fft.clone(), target.std_m(), &spectrum);
        Ok(CorrectedField { field, report })
    }
}

/// Returns the domain on which the *target* is a correlation, or the largest one tried. A pre-distorted correlation is
/// often not positive definite on any domain, so it cannot determine the size.
fn embedding(target: &dyn StationaryCovariance, grid: Grid) -> Result<Lags, TranslationError> {
    let (mut factor_x, mut factor_y) = (2, 2);
    loop {
        let (nx, ny) = (good_length(factor_x * grid.nx()), good_length(factor_y * grid.ny()));
        let domain = Grid::new(nx, ny, grid.dx_m(), grid.dy_m()).map_err(GeneratorError::from)?;
        let lags = Lags::within(target, grid, domain);
        let spectrum = lags.spectrum(&lags.wrapped(target)?, &mut lags.fft.workspace());
        let across_x = target.correlation(0.5 * domain.width_m(), 0.0).abs();
        let across_y = target.correlation(0.0, 0.5 * domain.height_m()).abs();
        let factor = if across_x > across_y { &mut factor_x } else { &mut factor_y };
        if lags.negative_fraction(&spectrum) < NEGLIGIBLE
            || *factor >= LARGEST_FACTOR
            || 2 * domain.points() > LARGEST_DOMAIN
        {
            return Ok(lags);
        }
        *factor *= 2;
    }
}

/// A covariance behind a reference.
struct Borrowed<'a>(&'a dyn StationaryCovariance);

impl StationaryCovariance for Borrowed<'_> {
    fn std_m(&self) -> f64 {
        self.0.std_m()
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.0.correlation(dx_m, dy_m)
    }

    fn mirror_symmetric(&self) -> bool {
        self.0.mirror_symmetric()
    }
}

/// Spectrum with the least largest deviation so far.
struct Best {
    spectrum: Vec<f64>,
    deviation: TranslationReport,
}

struct Descent {
    best: Best,
    /// The last spectrum, with the least sum of squares.
    #[cfg_attr(not(test), expect(dead_code, reason = "only tests read the last spectrum"))]
    last: Vec<f64>,
    iterations: usize,
}

/// Half the sum of squares at a spectrum, and its gradient there.
struct Height {
    value: f64,
    gradient: Vec<f64>,
    deviation: TranslationReport,
}

struct Search<'a> {
    lags: &'a Lags,
    translation: &'a Translation,
    target: &'a [f64],
    /// Fraction by which [`MEMORY`] steps should lower the sum of squares.
    least_gain: f64,
    work: Workspace,
}

impl Search<'_> {
    /// Returns the correlation of the translated field of a spectrum.
    fn translated(&mut self, spectrum: &[f64]) -> Vec<f64> {
        self.correlations(spectrum).0
    }

    /// Returns the correlation of the translated field of a spectrum, and its slope over that of the normal field.
    fn correlations(&mut self, spectrum: &[f64]) -> (Vec<f64>, Vec<f64>) {
        /// Number of lags in one unit of work of a thread.
        const AT_ONCE: usize = 1 << 13;

        let mut normal = self.lags.map(spectrum, &mut self.work);
        let (mut met, mut slopes) = (vec![0.0; normal.len()], vec![0.0; normal.len()]);
        let outputs = met.chunks_mut(AT_ONCE).zip(slopes.chunks_mut(AT_ONCE));
        blocks::for_each(normal.chunks_mut(AT_ONCE).zip(outputs), |(normal, (met, slopes))| {
            normal.iter_mut().for_each(|rho| *rho = rho.clamp(-1.0, 1.0));
            self.translation.correlations(normal, met, slopes);
        });
        (met, slopes)
    }

    fn height(&mut self, spectrum: &[f64]) -> Height {
        let (met, mut slopes) = self.correlations(spectrum);
        let mut value = 0.0;
        for (place, slope) in slopes.iter_mut().enumerate() {
            let error = if self.lags.counts(place) { met[place] - self.target[place] } else { 0.0 };
            value += 0.5 * error * error;
            *slope *= error;
        }
        let deviation = self.lags.deviation(&met, self.target);
        Height { value, gradient: self.lags.spectrum(&slopes, &mut self.work), deviation }
    }

    /// Returns Σ a b over all wavevectors, over their number: Parseval's sum over the lags.
    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        self.lags.sum(a.iter().zip(b).map(|(a, b)| a * b)) / self.lags.points() as f64
    }

    /// Runs spectral projected gradients from the projection of the pre-distorted spectrum.
    fn descend(&mut self, settings: &TranslationCorrection, predistorted: Vec<f64>, first: Best) -> Descent {
        let mut best = first;
        let mut spectrum = predistorted;
        if best.deviation.largest_deviation <= settings.tolerance {
            return Descent { best, last: spectrum, iterations: 0 };
        }
        self.lags.project(&mut spectrum);
        let mut here = self.height(&spectrum);
        let mut values = vec![here.value];
        let steepest = f64::max(self.translation.slope(1.0), self.translation.slope(-1.0).abs());
        let mut step = 1.0 / (steepest * steepest);
        let mut iterations = 0;
        loop {
            if here.deviation.largest_deviation < best.deviation.largest_deviation {
                best = Best { spectrum: spectrum.clone(), deviation: here.deviation };
            }
            let met = best.deviation.largest_deviation <= settings.tolerance;
            if met || iterations == settings.iterations || self.stalls(&values) {
                break;
            }
            let mut direction: Vec<f64> = spectrum.iter().zip(&here.gradient).map(|(s, g)| s - step * g).collect();
            self.lags.project(&mut direction);
            for (d, s) in direction.iter_mut().zip(&spectrum) {
                *d -= s;
            }
            let slope = self.product(&here.gradient, &direction);
            if slope > -f64::EPSILON * here.value {
                break;
            }
            let highest = values[values.len().saturating_sub(MEMORY)..].iter().copied().fold(0.0, f64::max);
            let mut fraction = 1.0;
            let (next, there) = loop {
                let next: Vec<f64> = spectrum.iter().zip(&direction).map(|(s, d)| s + fraction * d).collect();
                let there = self.height(&next);
                if there.value <= highest + SUFFICIENT * fraction * slope || fraction < LEAST_FRACTION {
                    break (next, there);
                }
                fraction *= 0.5;
            };
            // Barzilai and Borwein's step |Δs|²/(Δs·Δgradient).
            let moved: Vec<f64> = next.iter().zip(&spectrum).map(|(a, b)| a - b).collect();
            let turned: Vec<f64> = there.gradient.iter().zip(&here.gradient).map(|(a, b)| a - b).collect();
            let curvature = self.product(&moved, &turned);
            step = if curvature > 0.0 { self.product(&moved, &moved) / curvature } else { 10.0 * step };
            (spectrum, here) = (next, there);
            values.push(here.value);
            iterations += 1;
        }
        Descent { best, last: spectrum, iterations }
    }

    fn stalls(&self, values: &[f64]) -> bool {
        let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        values.split_at_checked(values.len().saturating_sub(MEMORY)).is_some_and(|(before, recent)| {
            !before.is_empty() && least(recent) > (1.0 - self.least_gain) * least(before)
        })
    }
}
