//! Maximum-likelihood fits of covariance models to the spectrum of a map.

use std::fmt;

use thiserror::Error;

use super::model::{CorrelationModel, Covariance, CovarianceError};
use super::profiles::Axis;
use super::spectrum::{BlockSpectrum, LineBlocks, ProfileSpectrum, ReliableBand};
use crate::numeric::{Range, least_squares};

/// Limit of the degrees of freedom of a block: model error of about 10 % makes more of them meaningless, and the few
/// blocks at long wavelengths would otherwise have no weight.
const MOST_DEGREES: f64 = 200.0;
/// Least number of blocks of a fit.
const FEWEST_BLOCKS: usize = 8;
/// Number of initial lengths, in geometric steps between the pitch and the size of the map.
const STARTS: usize = 3;
/// Bounds of a length in pitches and in sizes of the map.
const SHORTEST: f64 = 0.3;
const LONGEST: f64 = 10.0;
/// Ratio of map size to fitted length below which the map counts as short.
const FEW_LENGTHS: f64 = 10.0;
/// Correlation of the slopes along x and y above which the texture counts as oblique.
const OBLIQUE: f64 = 0.15;
/// Tolerance of the ranking: of models that are the same function, such as Matérn and self-affine for ν < 1, the one
/// listed first is taken.
const TIE: f64 = 1e-3;

/// A failed fit of a covariance.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// Empty list of model families.
    #[error("no family of covariance models to fit")]
    NoFamily,
    /// Too few wavevectors in the reliable band of the spectrum.
    #[error(
        "the reliable band of the spectrum, {low_rad_per_m:e} to {high_rad_per_m:e} rad/m, holds {blocks} blocks of \
         wavevectors, at least {wanted} are needed: the map is too small, noisy from the longest waves on, or smooth on \
         the scale of its pixels"
    )]
    NoBand {
        /// Lower limit of the band in rad/m.
        low_rad_per_m: f64,
        /// Upper limit of the band in rad/m.
        high_rad_per_m: f64,
        /// Number of blocks in the band.
        blocks: usize,
        /// Least number of blocks.
        wanted: usize,
    },
    /// Fitted parameters outside the range of the model.
    #[error(transparent)]
    Covariance(#[from] CovarianceError),
}

/// Warning about the quality of a fit.
#[derive(Debug, Clone, PartialEq)]
pub enum FitWarning {
    /// A map of fewer than ten fitted lengths, so that its correlation rests on few independent patches; below two, the
    /// length is extrapolated.
    FewLengths {
        /// Axis of the short side.
        axis: Axis,
        /// Ratio of map size to fitted length.
        lengths: f64,
    },
    /// A texture at an angle to the axes; the models are even in x and y and average over it.
    ObliqueLay {
        /// Value of [`BlockSpectrum::slope_correlation`].
        slope_correlation: f64,
    },
}

impl fmt::Display for FitWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewLengths { axis, lengths } => write!(
                f,
                "along {axis} the map is only {lengths:.1} correlation lengths long: few patches are independent{}",
                if *lengths < 2.0 { ", and the length is extrapolated" } else { "" }
            ),
            Self::ObliqueLay { slope_correlation } => write!(
                f,
                "the lay runs at an angle to the axes (slopes along x and y correlate by {slope_correlation:.2}), which the \
                 models average away; the empirical covariance keeps it"
            ),
        }
    }
}

/// One model fitted to a map.
#[derive(Debug, Clone, PartialEq)]
pub struct CovarianceFit {
    /// Fitted covariance with the given standard deviation.
    pub covariance: Covariance,
    /// Root mean square of ln(measured/fitted spectral density) over the blocks, without its sampling variance.
    pub misfit: f64,
    /// Fitted parameters: two lengths, and ν or H where the model has one.
    pub parameters: usize,
    /// Deviance: minus twice the log likelihood relative to a model that equals the data in every block.
    pub deviance: f64,
}

/// All models fitted to a map, best first.
#[derive(Debug, Clone, PartialEq)]
pub struct CovarianceFits {
    /// Ranked by deviance plus ln n per parameter, n the number of blocks (Schwarz's criterion).
    pub fits: Vec<CovarianceFit>,
    /// Whether the texture is oblique; see [`FitWarning::ObliqueLay`].
    pub oblique: bool,
    /// Warnings about the fit.
    pub warnings: Vec<FitWarning>,
}

impl CovarianceFits {
    /// Returns the covariance ranked first.
    pub fn best(&self) -> Covariance {
        self.fits[0].covariance
    }

    /// Returns the fit of the model with this name, as in study files.
    pub fn named(&self, name: &str) -> Option<&CovarianceFit> {
        self.fits.iter().find(|fit| fit.covariance.model().name() == name)
    }
}

crate::choice! {
    /// Family of correlation models, whose shape parameter is fitted.
    pub enum CorrelationFamily: "family of correlation models" {
        /// ρ = e^{−r²}, with r in lengths ℓ.
        SquaredExponential = "squared_exponential",
        /// ρ = e^{−r}, with r in lengths ℓ.
        Exponential = "exponential",
        /// Self-affine with roll-off; a fitted Hurst exponent H is in [0.05, 0.995].
        SelfAffine = "self_affine",
        /// Matérn; a fitted smoothness ν is in [0.05, 50].
        Matern = "matern",
    }
}

impl CorrelationFamily {
    /// Returns the range and initial value of the shape parameter, if there is one.
    fn shape(self) -> Option<(Range, f64)> {
        match self {
            Self::SquaredExponential | Self::Exponential => None,
            Self::SelfAffine => Some((Range { low: 0.05, high: 0.995 }, 0.7)),
            Self::Matern => Some((Range { low: 0.05, high: 50.0 }, 1.0)),
        }
    }

    /// Returns the model with a shape parameter.
    fn model(self, shape: Option<f64>) -> CorrelationModel {
        match (self, shape) {
            (Self::SquaredExponential, _) => CorrelationModel::SquaredExponential,
            (Self::SelfAffine, Some(hurst)) => CorrelationModel::SelfAffine { hurst },
            (Self::Matern, Some(nu)) => CorrelationModel::Matern { nu },
            (Self::Exponential | Self::SelfAffine | Self::Matern, _) => CorrelationModel::Exponential,
        }
    }
}

/// Fits `families` to the spectra of the maps of one surface, of standard deviation `std_m` in metre, and ranks them.
///
/// The likelihood is Whittle's for means of the periodogram over the blocks of [`BlockSpectrum`]: the mean I of a block
/// with ν degrees of freedom is distributed as Mχ²_ν/ν, with M the expected density, and the fit minimises the deviance
/// Σ ν (I/M − 1 − ln(I/M)). M includes aliasing by the sampling and smoothing by the window. The standard deviation is
/// prescribed, because the variance of a surface is known better than its longest waves; the lengths and the shape
/// follow from the spectrum.
///
/// # Errors
/// No family, or too few wavevectors in the reliable bands.
///
/// # References
/// Whittle, *Biometrika* **41** (1954) 434, <https://doi.org/10.1093/biomet/41.3-4.434>; Sykulski et al., *Biometrika*
/// **106** (2019) 251, <https://doi.org/10.1093/biomet/asy071> (expectations with folding and window); Schwarz, *Ann.
/// Stat.* **6** (1978) 461, <https://doi.org/10.1214/aos/1176344136>.
pub fn fit_covariance(
    spectra: &[&BlockSpectrum],
    std_m: f64,
    families: &[CorrelationFamily],
) -> Result<CovarianceFits, FitError> {
    let observed: Vec<&dyn Observed> = spectra.iter().map(|spectrum| *spectrum as &dyn Observed).collect();
    let fits = ranked(&observed, std_m, families)?;

    let best = fits[0].covariance;
    let mut warnings = Vec::new();
    for (place, axis) in [Axis::X, Axis::Y].into_iter().enumerate() {
        let lengths = spectra.iter().map(|s| s.size_m()[place] / decay_lengths_m(best)[place]).fold(0.0, f64::max);
        if lengths < FEW_LENGTHS {
            warnings.push(FitWarning::FewLengths { axis, lengths });
        }
    }
    let slope_correlation =
        spectra.iter().map(|spectrum| spectrum.slope_correlation()).sum::<f64>() / spectra.len() as f64;
    let oblique = slope_correlation.abs() > OBLIQUE;
    if oblique {
        warnings.push(FitWarning::ObliqueLay { slope_correlation });
    }
    Ok(CovarianceFits { fits, oblique, warnings })
}

/// Fits isotropic models of `families` to the spectrum of a profile at points `pitch_m` apart, of standard deviation `std_m`, in metre, as
/// [`fit_covariance`] does to maps. The profile of an isotropic surface of covariance C(r) has this covariance along x, and the density
/// P₁(q) = ∫ C(x) e^{−iqx} dx.
///
/// # Errors
/// No family, or too few wavenumbers in the reliable band.
pub fn fit_profile_covariance(
    spectrum: &ProfileSpectrum,
    pitch_m: f64,
    std_m: f64,
    families: &[CorrelationFamily],
) -> Result<CovarianceFits, FitError> {
    let blocks = LineBlocks::new(spectrum, pitch_m);
    let fits = ranked(&[&blocks], std_m, families)?;
    let lengths = blocks.length_m() / decay_lengths_m(fits[0].covariance)[0];
    let few = (lengths < FEW_LENGTHS).then_some(FitWarning::FewLengths { axis: Axis::X, lengths });
    Ok(CovarianceFits { fits, oblique: false, warnings: few.into_iter().collect() })
}

/// Spectral density of a map or a profile, averaged over blocks.
trait Observed: Sync {
    /// Returns the density and the degrees of freedom of each block.
    fn measured(&self) -> Vec<(f64, f64)>;

    /// Returns the density that a covariance leads to expect in each block.
    fn expected(&self, covariance: &Covariance) -> Vec<f64>;

    fn band(&self) -> ReliableBand;

    /// Returns the pitch and the size in metre along the axes that have a length of their own.
    fn sides_m(&self) -> Vec<[f64; 2]>;
}

impl Observed for BlockSpectrum {
    fn measured(&self) -> Vec<(f64, f64)> {
        self.blocks().iter().map(|block| (block.density_m4, block.degrees_of_freedom)).collect()
    }

    fn expected(&self, covariance: &Covariance) -> Vec<f64> {
        self.blocks().iter().map(|block| self.expected_m4(block, covariance)).collect()
    }

    fn band(&self) -> ReliableBand {
        self.reliable()
    }

    fn sides_m(&self) -> Vec<[f64; 2]> {
        self.pitch_m().into_iter().zip(self.size_m()).map(|(pitch_m, size_m)| [pitch_m, size_m]).collect()
    }
}

impl Observed for LineBlocks {
    fn measured(&self) -> Vec<(f64, f64)> {
        LineBlocks::measured(self).collect()
    }

    fn expected(&self, covariance: &Covariance) -> Vec<f64> {
        self.expected_m3(covariance)
    }

    fn band(&self) -> ReliableBand {
        self.band
    }

    fn sides_m(&self) -> Vec<[f64; 2]> {
        vec![[self.pitch_m, self.length_m()]]
    }
}

/// Fits all families and ranks them.
fn ranked(
    spectra: &[&dyn Observed],
    std_m: f64,
    families: &[CorrelationFamily],
) -> Result<Vec<CovarianceFit>, FitError> {
    let (false, Some(first)) = (families.is_empty(), spectra.first()) else { return Err(FitError::NoFamily) };
    let blocks = spectra.iter().map(|spectrum| spectrum.measured().len()).sum();
    if blocks < FEWEST_BLOCKS {
        let band = first.band();
        return Err(FitError::NoBand {
            low_rad_per_m: band.low_rad_per_m,
            high_rad_per_m: band.high_rad_per_m,
            blocks,
            wanted: FEWEST_BLOCKS,
        });
    }
    let (mut fits, mut failure) = (vec![], None);
    let searches: Vec<Search<'_>> = families.iter().map(|family| Search::new(*family, spectra, std_m)).collect();
    let minima: Vec<_> =
        crate::blocks::map(0..STARTS * families.len(), |place| searches[place / STARTS].from(place % STARTS));
    for (search, minima) in searches.iter().zip(minima.chunks(STARTS)) {
        match search.best(minima) {
            Ok(fit) => fits.push(fit),
            Err(error) => failure = Some(error),
        }
    }
    if let (true, Some(error)) = (fits.is_empty(), failure) {
        return Err(error);
    }
    let penalty = (blocks as f64).ln();
    let score = |place: usize, fit: &CovarianceFit| fit.deviance + penalty * fit.parameters as f64 + TIE * place as f64;
    let mut scored: Vec<(f64, CovarianceFit)> =
        fits.drain(..).enumerate().map(|(place, fit)| (score(place, &fit), fit)).collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    fits.extend(scored.into_iter().map(|(_, fit)| fit));
    Ok(fits)
}

/// Rough lags along x and y at which the correlation falls to 1/e.
fn decay_lengths_m(covariance: Covariance) -> [f64; 2] {
    let scale = match covariance.model() {
        CorrelationModel::SelfAffine { hurst } => (2.0 * hurst).sqrt(),
        _ => 1.0,
    };
    [covariance.length_x_m(), covariance.length_y_m()].map(|length_m| scale * length_m)
}

/// Search for the parameters of one family.
struct Search<'a> {
    family: CorrelationFamily,
    spectra: &'a [&'a dyn Observed],
    std_m: f64,
    /// Bounds of the lengths, one of a profile and two of a map, and of the shape.
    ranges: Vec<Range>,
    /// Pitch and largest size along the axes with a length of their own.
    sides_m: Vec<[f64; 2]>,
}

impl<'a> Search<'a> {
    fn new(family: CorrelationFamily, spectra: &'a [&'a dyn Observed], std_m: f64) -> Self {
        let mut sides_m = spectra[0].sides_m();
        for spectrum in spectra {
            sides_m.iter_mut().zip(spectrum.sides_m()).for_each(|(side, own)| side[1] = side[1].max(own[1]));
        }
        let mut ranges: Vec<Range> =
            sides_m.iter().map(|[pitch_m, size_m]| Range { low: SHORTEST * pitch_m, high: LONGEST * size_m }).collect();
        ranges.extend(family.shape().map(|(range, _)| range));
        Self { family, spectra, std_m, ranges, sides_m }
    }

    fn covariance(&self, parameters: &[f64]) -> Result<Covariance, CovarianceError> {
        let lengths = self.sides_m.len();
        let model = self.family.model(parameters.get(lengths).copied());
        Covariance::new(model, self.std_m, parameters[0], parameters[lengths - 1])
    }

    /// Returns ratios of measured to expected density, and effective degrees of freedom.
    fn ratios(&self, parameters: &[f64]) -> Vec<(f64, f64)> {
        let Ok(covariance) = self.covariance(parameters) else { return vec![] };
        let of = |spectrum: &&dyn Observed| {
            let pairs = spectrum.measured().into_iter().zip(spectrum.expected(&covariance));
            pairs.map(|((found, degrees), expected)| (found / expected.max(f64::MIN_POSITIVE), degrees)).collect()
        };
        self.spectra.iter().map(of).collect::<Vec<Vec<(f64, f64)>>>().concat()
    }

    /// Returns the parameters of the minimum that is found from one of the initial lengths, and its deviance.
    fn from(&self, start: usize) -> (Vec<f64>, f64) {
        let residual = |(ratio, degrees): (f64, f64)| {
            let excess = (ratio - 1.0 - ratio.ln()).max(0.0);
            (degrees.min(MOST_DEGREES) * excess).sqrt().copysign(ratio - 1.0)
        };
        let residuals = |p: &[f64]| -> Vec<f64> { self.ratios(p).into_iter().map(residual).collect() };
        let fraction = (start as f64 + 1.0) / (STARTS as f64 + 1.0);
        let length = |[pitch_m, size_m]: &[f64; 2]| pitch_m * (size_m / pitch_m).powf(fraction);
        let mut first: Vec<f64> = self.sides_m.iter().map(length).collect();
        first.extend(self.family.shape().map(|(_, value)| value));
        least_squares(&residuals, &first, &self.ranges)
    }

    fn best(&self, minima: &[(Vec<f64>, f64)]) -> Result<CovarianceFit, FitError> {
        let is_finite = |(values, deviance): &&(Vec<f64>, f64)| {
            deviance.is_finite() && values.iter().all(|value| value.is_finite())
        };
        let best = minima.iter().filter(is_finite).min_by(|a, b| a.1.total_cmp(&b.1)).cloned();
        // If there is no minimum, the constructor of the covariance rejects the parameters.
        let (found, deviance) = best.unwrap_or_else(|| (vec![f64::NAN; self.ranges.len()], f64::NAN));
        let (mut squares, mut weights) = (0.0, 0.0);
        for (ratio, degrees) in self.ratios(&found) {
            let weight = degrees.min(MOST_DEGREES);
            squares += weight * (ratio.ln().powi(2) - 2.0 / degrees);
            weights += weight;
        }
        Ok(CovarianceFit {
            covariance: self.covariance(&found)?,
            misfit: (squares / weights).max(0.0).sqrt(),
            parameters: found.len(),
            deviance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Grid, HeightMap};
    use crate::random;

    #[test]
    #[ignore = "slow"]
    fn white_noise_is_fitted_by_a_length_below_the_pitch() {
        let grid = Grid::new(96, 96, 1e-6, 1e-6).unwrap();
        let noise = random::standard_normal(&mut random::stream(1, "noise", 0), grid.points());
        let map = HeightMap::new(grid, ndarray::Array2::from_shape_vec(grid.shape(), noise).unwrap()).unwrap();
        let fits = fit_covariance(&[&BlockSpectrum::new(&map).unwrap()], 1.0, CorrelationFamily::ALL).unwrap();
        assert!(fits.best().correlation(1e-6, 0.0) < 0.1, "{fits:?}");
        assert!(fits.fits[0].misfit < 0.1, "{fits:?}");
    }

    #[test]
    fn a_map_without_a_reliable_band_is_refused_with_the_band() {
        let grid = Grid::new(5, 5, 1.0, 1.0).unwrap();
        let map = HeightMap::from_function(grid, |x, y| (7.0 * x).sin() + (3.0 * y).cos()).unwrap();
        let error = fit_covariance(&[&BlockSpectrum::new(&map).unwrap()], 1.0, CorrelationFamily::ALL).unwrap_err();
        assert!(matches!(error, FitError::NoBand { wanted: 8, .. }), "{error}");
    }
}
