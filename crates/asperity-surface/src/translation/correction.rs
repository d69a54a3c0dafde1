//! The Gaussian spectrum whose translation comes closest to a target correlation.

#[cfg(test)]
mod tests;

use ndarray::Array2;
use rayon::prelude::*;

use super::lags::Lags;
use super::{Predistorted, TranslationError, TranslationReport};
use crate::spectral::WrappedSpectrum;
use crate::{GeneratorError, SpectralField};
use asperity_base::correlation::StationaryCovariance;
use asperity_base::fourier::{Workspace, good_length};
use asperity_base::law::{Marginal, translation::Translation};
use asperity_base::map::Grid;

/// Share of negative variance that counts as rounding.
const NEGLIGIBLE: f64 = 1e-12;
/// Largest side of an embedding domain over that of the grid, and its largest number of points.
const LARGEST_FACTOR: usize = 8;
const LARGEST_DOMAIN: usize = 1 << 22;
/// Values of the objective that a step of the descent must undercut one of.
const MEMORY: usize = 8;
/// A descent of the sum of squares by less than this share in as many steps as the memory is none.
const LEAST_GAIN: f64 = 1e-3;
/// Armijo's share of the slope that a step must gain, and the least share of a step that is tried.
const SUFFICIENT: f64 = 1e-4;
const LEAST_FRACTION: f64 = 1e-6;

/// Corrected translation by Fourier synthesis: the Gaussian field whose translated correlation is that of a target, or as
/// near to it as a correlation can be.
///
/// Pre-distortion, ρ_G = T⁻¹(ρ_X) with T the law's distortion, is exact where ρ_G has no negative spectrum. Else the
/// spectrum S ≥ 0 of ρ_G with least Σ (T(ρ_G) − ρ_X)² over the lags is searched, where the negative one, clipped, leaves a
/// larger deviation than the tolerance. As in the translation approximation of Shields, Deodatis & Bocchini, steps alternate
/// between the marginal transform ρ_G → T(ρ_G) and spectra that cannot be negative. Theirs multiply the spectrum by the ratio
/// of target and met spectra; here it moves against the gradient of the sum of squares and back onto the nearest
/// non-negative spectrum of unit variance (spectral projected gradients), which descends surely and leaves less.
///
/// # References
/// Shields, Deodatis & Bocchini, *Prob. Eng. Mech.* **26** (2011) 511, <https://doi.org/10.1016/j.probengmech.2011.04.003>;
/// Birgin, Martínez & Raydan, *SIAM J. Optim.* **10** (2000) 1196, <https://doi.org/10.1137/S1052623497330963>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TranslationCorrection {
    /// Largest deviation |ρ − target| at which the search ends.
    pub tolerance: f64,
    /// Largest number of iterations.
    pub iterations: usize,
}

impl Default for TranslationCorrection {
    /// A deviation of 1e-3, which is below the sampling error of any map's correlation; 100 iterations.
    fn default() -> Self {
        Self { tolerance: 1e-3, iterations: 100 }
    }
}

/// A Gaussian field to be translated, and how near its translation is to the target.
#[derive(Debug, Clone)]
pub struct CorrectedField {
    /// The Gaussian field, of the target's standard deviation.
    pub field: SpectralField,
    /// How near.
    pub report: CorrectionReport,
}

/// Whether a translated field can have a target correlation at all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feasibility {
    /// The least correlation that the law allows, at ρ_G = −1.
    pub least_correlation: f64,
    /// The least value of the target at the lags of the map.
    pub least_target: f64,
    /// Share of the variance that negative eigenvalues of the target itself hold, wrapped onto the domain: above zero the
    /// map holds too few correlation lengths, or the target is no correlation.
    pub target_negative_share: f64,
    /// Share of the variance that negative eigenvalues of the pre-distorted correlation hold: above zero no Gaussian field
    /// is translated into the target.
    pub predistorted_negative_share: f64,
}

impl Feasibility {
    /// By how much the target falls below the least correlation of the law; 0 where it does not.
    pub fn shortfall(&self) -> f64 {
        (self.least_correlation - self.least_target).max(0.0)
    }

    /// Whether pre-distortion meets the target to rounding.
    pub fn is_feasible(&self) -> bool {
        self.shortfall() == 0.0 && self.predistorted_negative_share < NEGLIGIBLE
    }
}

/// Target and achieved correlation of a translated field at the lags of its map: on a periodic grid up to half the sides, on
/// a free one all of them. No sampling is involved.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectionReport {
    /// What stands in the way.
    pub feasibility: Feasibility,
    /// What the plain map leaves, whose Gaussian field has the target's correlation.
    pub plain: TranslationReport,
    /// What pre-distortion and one clipping leave.
    pub predistorted: TranslationReport,
    /// What is left in the end.
    pub corrected: TranslationReport,
    /// Iterations after pre-distortion.
    pub iterations: usize,
    /// Whether the tolerance is met.
    pub converged: bool,
    /// The target, shape `[lags along y, lags along x]`, in steps of the grid.
    pub target: Array2<f64>,
    /// The correlation of plain translation, likewise.
    pub achieved_plain: Array2<f64>,
    /// The correlation achieved, likewise.
    pub achieved: Array2<f64>,
}

impl TranslationCorrection {
    /// The Gaussian field on the periodic `grid`.
    ///
    /// # Errors
    /// A law with a parameter outside its range, or a target that is not in [−1, 1] or not 1 at zero.
    pub fn periodic(
        &self,
        target: &dyn StationaryCovariance,
        marginal: &Marginal,
        grid: Grid,
    ) -> Result<CorrectedField, TranslationError> {
        self.field(target, marginal, grid, &Lags::periodic(target, grid))
    }

    /// The Gaussian field on a `grid` whose opposite edges do not know each other: a crop of a periodic domain of at least
    /// twice the sides. Only the lags within the grid count, so that beyond them the correlation may be what it likes.
    ///
    /// # Errors
    /// As [`TranslationCorrection::periodic`].
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
        // Targets that the law does not reach are raised to the least correlation.
        let normal = lags.wrapped(&Predistorted::new(Borrowed(target), marginal)?)?;
        let predistorted = lags.spectrum(&normal, &mut work);
        let least_target = lags.least(&wanted);
        let feasibility = Feasibility {
            least_correlation: translation.least_correlation(),
            least_target,
            target_negative_share: lags.negative_share(&unclipped),
            predistorted_negative_share: lags.negative_share(&predistorted),
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
            clipped: feasibility.predistorted_negative_share,
        };
        let field = SpectralField::from_spectrum(grid, lags.domain, lags.fft.clone(), target.std_m(), &spectrum);
        Ok(CorrectedField { field, report })
    }
}

/// The domain on which the *target* is a correlation, or the largest one tried. A pre-distorted correlation is often not
/// positive on any domain, so that it cannot say when to stop.
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
        if lags.negative_share(&spectrum) < NEGLIGIBLE
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

/// The spectrum of least largest deviation so far.
struct Best {
    spectrum: Vec<f64>,
    deviation: TranslationReport,
}

struct Descent {
    best: Best,
    /// The last spectrum, of least sum of squares.
    #[cfg_attr(not(test), expect(dead_code, reason = "the tests look where the search ends"))]
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
    /// The share by which [`MEMORY`] steps should lower the sum of squares.
    least_gain: f64,
    work: Workspace,
}

impl Search<'_> {
    /// The correlation of the translated field of a spectrum.
    fn translated(&mut self, spectrum: &[f64]) -> Vec<f64> {
        self.correlations(spectrum).0
    }

    /// The correlation of the translated field of a spectrum, and its slope over that of the normal one.
    fn correlations(&mut self, spectrum: &[f64]) -> (Vec<f64>, Vec<f64>) {
        /// Lags that a thread takes at a time.
        const AT_ONCE: usize = 1 << 13;

        let mut normal = self.lags.map(spectrum, &mut self.work);
        let (mut met, mut slopes) = (vec![0.0; normal.len()], vec![0.0; normal.len()]);
        let outputs = met.par_chunks_mut(AT_ONCE).zip(slopes.par_chunks_mut(AT_ONCE));
        normal.par_chunks_mut(AT_ONCE).zip(outputs).for_each(|(normal, (met, slopes))| {
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

    /// Σ a b over all wavevectors, over their number: Parseval's sum over the lags.
    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        self.lags.sum(a.iter().zip(b).map(|(a, b)| a * b)) / self.lags.points() as f64
    }

    /// Spectral projected gradients from the projection of the pre-distorted spectrum.
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
            let mut share = 1.0;
            let (next, there) = loop {
                let next: Vec<f64> = spectrum.iter().zip(&direction).map(|(s, d)| s + share * d).collect();
                let there = self.height(&next);
                if there.value <= highest + SUFFICIENT * share * slope || share < LEAST_FRACTION {
                    break (next, there);
                }
                share *= 0.5;
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
