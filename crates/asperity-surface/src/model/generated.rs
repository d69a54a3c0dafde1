//! Generators of the random surfaces of a model, on any grid.

use asperity_base::correlation::StationaryCovariance;
use asperity_base::distribution::Marginal;
use asperity_base::map::Grid;
use asperity_base::sentence;
use asperity_base::translation::TranslationKind;

use super::{SurfaceCovariance, SurfaceModel, SurfaceModelError, Texture, TruncatedExpansion};
use crate::spectral::variables;
use crate::{
    CorrectedField, GaussianSurface, KarhunenLoeve, ModesRoute, Predistorted, RandomSurface, SpectralField, Translated,
    TranslationCorrection, WeierstrassMandelbrot, modes_for_slopes, modes_memory_bytes,
};
use asperity_results::KarhunenLoeveResult;

/// Ratio of neighbouring wavenumbers of Weierstrass–Mandelbrot surfaces.
pub const GAMMA: f64 = 1.5;
/// Number of ridges of Weierstrass–Mandelbrot surfaces.
pub const RIDGES: usize = 20;
/// Largest number of terms of an expansion whose number is not stated; a patch that needs more has all Fourier modes.
const MOST_MODES: usize = 400;
/// Captured fraction of the variance, or of the slope variance, of an expansion below which there is a warning.
const WANTED_VARIANCE: f64 = 0.9;
/// Factor on the number of terms that Fourier modes need, because the modes of a patch differ from them.
const MARGIN: f64 = 1.1;
/// Factor on the number of terms if they do not contain the slopes.
const GROWTH: f64 = 1.25;
/// Deviation of the correlation under a corrected translation above which there is a warning.
const CORRELATION_LEFT: f64 = 0.01;
/// Fraction of clipped variance of a spectral field above which there is a warning.
pub(super) const CLIPPED_VARIANCE: f64 = 1e-3;

/// Order of the normal variables ξ of a spectral field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum XiOrder {
    /// By decreasing variance of the waves.
    Variance,
    /// By wavevector: on a periodic grid each variable belongs to the same wave for all covariances.
    Wavevector,
}

/// Size of the generator of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchSize {
    /// Largest number of normal variables ξ.
    pub variables: usize,
    /// Memory of a Karhunen–Loève expansion in byte; 0 for all Fourier modes.
    pub expansion_bytes: f64,
}

/// Generator of random surfaces on a grid, with its approximations.
pub struct Generated {
    /// Generator.
    pub surface: Box<dyn RandomSurface>,
    /// Karhunen–Loève expansion; `None` for the other generators.
    pub karhunen_loeve: Option<KarhunenLoeveResult>,
    /// Standard deviation of the heights, averaged over the patch, over that of the marginal distribution.
    pub std_share: f64,
    /// Warnings in sentences.
    pub warnings: Vec<String>,
    /// Sentence on the deviation of the correlation, if the translation was corrected or all Fourier modes replace an expansion.
    pub correction: Option<String>,
    /// Fraction of the variance that was clipped from a spectral field.
    pub clipped_variance: f64,
}

impl Generated {
    /// Returns the generator of a surface without approximations.
    fn exact(surface: Box<dyn RandomSurface>) -> Self {
        Self {
            surface,
            karhunen_loeve: None,
            std_share: 1.0,
            warnings: Vec::new(),
            correction: None,
            clipped_variance: 0.0,
        }
    }
}

impl SurfaceModel {
    /// Makes the generator of surfaces on a small patch.
    ///
    /// # Errors
    /// The covariance has no expansion or embedding on the grid, the marginal distribution has no translation, or the expansion of
    /// a patch that is not periodic is to leave out the constant mode.
    pub fn patch(&self, grid: Grid, periodic: bool) -> Result<Generated, SurfaceModelError> {
        match &self.texture {
            &Texture::Translated { ref covariance, translation, expansion: Some(expansion) } => {
                let field = self.field(covariance, translation, grid, periodic);
                field.expansion_or_all_modes(expansion)
            }
            _ => self.strip(grid, periodic, XiOrder::Variance),
        }
    }

    fn field<'a>(
        &'a self,
        covariance: &'a SurfaceCovariance,
        translation: TranslationKind,
        grid: Grid,
        periodic: bool,
    ) -> Field<'a> {
        let shortest_wave_m = self.shortest_wave_m;
        Field { marginal: &self.marginal, covariance, translation, shortest_wave_m, grid, periodic }
    }

    /// Returns about the size of the generator of surfaces on a small patch, without making it.
    pub fn patch_size(&self, grid: Grid, periodic: bool) -> PatchSize {
        let all_modes = || PatchSize { variables: self.strip_variables(grid, periodic), expansion_bytes: 0.0 };
        let &Texture::Translated { ref covariance, translation, expansion: Some(expansion) } = &self.texture else {
            return all_modes();
        };
        let field = self.field(covariance, translation, grid, periodic);
        let modes = expansion.modes.unwrap_or_else(|| with_margin(field.needed_modes()));
        if expansion.modes.is_none() && modes > MOST_MODES.min(grid.points()) && field.may_have_all_modes(expansion) {
            return all_modes();
        }
        let modes = if expansion.modes.is_some() { modes } else { modes.min(MOST_MODES) }.min(grid.points());
        let route = field.route(translation == TranslationKind::Plain && covariance.is_product());
        PatchSize { variables: modes, expansion_bytes: modes_memory_bytes(&[grid.nx(), grid.ny()], modes, route) }
    }

    /// Returns the number of normal variables ξ of surfaces on a long strip.
    pub fn strip_variables(&self, grid: Grid, periodic: bool) -> usize {
        match &self.texture {
            Texture::Translated { covariance, .. } => variables(covariance, grid, periodic),
            Texture::WeierstrassMandelbrot { .. } => grid.points(),
        }
    }

    /// Makes the generator of surfaces on a long strip. It has all Fourier modes, because a truncated expansion does not contain the
    /// variance of a long strip.
    ///
    /// # Errors
    /// The covariance has no embedding on the grid, or the marginal distribution has no translation.
    pub fn strip(&self, grid: Grid, periodic: bool, order: XiOrder) -> Result<Generated, SurfaceModelError> {
        match &self.texture {
            &Texture::Translated { ref covariance, translation, .. } => {
                self.field(covariance, translation, grid, periodic).spectral(order)
            }
            // The rms height sets G; its initial value has no effect.
            Texture::WeierstrassMandelbrot { dimension } => Ok(Generated::exact(Box::new(
                WeierstrassMandelbrot::new(grid, *dimension, GAMMA, RIDGES, 1e-9)?
                    .with_rms_height(self.marginal.std())?,
            ))),
        }
    }
}

/// Returns the number of terms of a patch whose Fourier modes would be as many as `needed`.
fn with_margin(needed: usize) -> usize {
    (MARGIN * needed as f64).ceil() as usize + 1
}

/// Translated Gaussian field on a grid.
struct Field<'a> {
    marginal: &'a Marginal,
    covariance: &'a SurfaceCovariance,
    translation: TranslationKind,
    shortest_wave_m: Option<f64>,
    grid: Grid,
    periodic: bool,
}

impl Field<'_> {
    /// Returns the number of Fourier modes that contain the slopes.
    fn needed_modes(&self) -> usize {
        modes_for_slopes(self.covariance, self.grid, WANTED_VARIANCE)
    }

    /// Returns whether all Fourier modes may replace an expansion with too many terms.
    fn may_have_all_modes(&self, expansion: TruncatedExpansion) -> bool {
        expansion.rescale.is_none() && expansion.mean_mode
    }

    fn route(&self, product: bool) -> ModesRoute {
        match (self.periodic, product) {
            (true, _) => ModesRoute::Periodic,
            (false, true) => ModesRoute::Separable,
            (false, false) => ModesRoute::General,
        }
    }

    /// Makes Karhunen–Loève surfaces with the stated number of terms, or with as many as contain the slopes. If these are too many,
    /// makes spectral surfaces, or surfaces of `MOST_MODES` terms if the treatment of the truncated variance is stated.
    fn expansion_or_all_modes(&self, expansion: TruncatedExpansion) -> Result<Generated, SurfaceModelError> {
        if let Some(modes) = expansion.modes {
            return self.expanded(expansion, modes);
        }
        let most = MOST_MODES.min(self.grid.points());
        let needed = self.needed_modes();
        let mut modes = with_margin(needed);
        while modes <= most {
            let generated = self.expanded(expansion, modes)?;
            let found = generated.karhunen_loeve;
            if found.is_none_or(|found| found.captured_slope_variance >= WANTED_VARIANCE) {
                return Ok(generated);
            }
            modes = (GROWTH * modes as f64).ceil() as usize;
        }
        if !self.may_have_all_modes(expansion) {
            return self.expanded(expansion, MOST_MODES);
        }
        let generated = self.spectral(XiOrder::Variance)?;
        let reason = format!(
            "A Karhunen–Loève expansion of a patch of {} would need {needed} terms or more to hold {} % of the slope variance, so that \
             its surfaces have all Fourier modes of the grid instead; state `modes` to have an expansion.",
            self.size(),
            sentence::digits(100.0 * WANTED_VARIANCE),
        );
        let correction = match generated.correction {
            Some(correction) => format!("{reason} {correction}"),
            None => reason,
        };
        Ok(Generated { correction: Some(correction), ..generated })
    }

    /// Makes Karhunen–Loève surfaces of this many terms.
    fn expanded(&self, expansion: TruncatedExpansion, modes: usize) -> Result<Generated, SurfaceModelError> {
        match self.translation {
            TranslationKind::Plain => {
                self.karhunen_loeve(self.covariance, self.covariance.is_product(), expansion, modes)
            }
            TranslationKind::Corrected => {
                let corrected = Predistorted::new(self.covariance, self.marginal)?;
                let correction = Some(format!(
                    "The correlation beneath the translation was distorted beforehand so that the heights keep theirs; \
                     heights of this distribution cannot have a correlation below {}.",
                    sentence::digits(corrected.least_correlation())
                ));
                Ok(Generated { correction, ..self.karhunen_loeve(&corrected, false, expansion, modes)? })
            }
        }
    }

    /// Makes Karhunen–Loève surfaces. `product` states that the covariance is a product of one along x and one along y.
    fn karhunen_loeve(
        &self,
        covariance: &dyn StationaryCovariance,
        product: bool,
        TruncatedExpansion { mean_mode, rescale, .. }: TruncatedExpansion,
        modes: usize,
    ) -> Result<Generated, SurfaceModelError> {
        let &Self { grid, periodic, .. } = self;
        let route = self.route(product);
        if !mean_mode && !periodic {
            return Err(SurfaceModelError::ConstantMode);
        }
        let mut warnings = Vec::new();
        let most = grid.points() - usize::from(!mean_mode);
        if modes > most {
            let points = grid.points();
            warnings
                .push(format!("a patch of {points} points has no more than {most} Karhunen–Loève terms, not {modes}"));
        }
        let modes = modes.min(most);
        let field = if mean_mode {
            KarhunenLoeve::new(covariance, grid, modes, route)?
        } else {
            KarhunenLoeve::periodic_without_constant(covariance, grid, modes)?
        };
        let captured_variance = field.captured_variance();
        if captured_variance < WANTED_VARIANCE {
            let than = if rescale == Some(false) { "smoother and lower" } else { "smoother" };
            warnings.push(format!(
                "{modes} Karhunen–Loève terms hold {} % of the variance on a patch of {}: the random surfaces are {than} \
                 than the model; raise `modes` or use the spectral generator",
                sentence::digits(100.0 * captured_variance),
                self.size()
            ));
        }
        let captured_slope_variance = field.captured_slope_variance();
        if captured_slope_variance < WANTED_VARIANCE {
            // Heights that are scaled to the whole variance scale the slopes, too.
            let variance = if rescale == Some(false) { 1.0 } else { captured_variance };
            warnings.push(format!(
                "{modes} Karhunen–Loève terms hold {} % of the slope variance on a patch of {}: the slopes of the random surfaces are \
                 {} times those of the model, and elastic contact area and friction depend on slopes; leave `modes` out, or use the \
                 spectral generator",
                sentence::digits(100.0 * captured_slope_variance),
                self.size(),
                sentence::digits((captured_slope_variance / variance).sqrt()),
            ));
        }
        let karhunen_loeve = Some(KarhunenLoeveResult { modes, captured_variance, captured_slope_variance });
        let (surface, std_share): (Box<dyn RandomSurface>, f64) = match rescale {
            None => (self.translated(field)?, 1.0),
            Some(true) => (Box::new(field.rescaled()), 1.0),
            Some(false) => (Box::new(field), captured_variance.sqrt()),
        };
        Ok(Generated { karhunen_loeve, std_share, warnings, ..Generated::exact(surface) })
    }

    /// Makes surfaces with all Fourier modes.
    fn spectral(&self, order: XiOrder) -> Result<Generated, SurfaceModelError> {
        let &Self { grid, periodic, .. } = self;
        let make = |covariance: &dyn StationaryCovariance| {
            if periodic { Ok(SpectralField::periodic(covariance, grid)) } else { SpectralField::free(covariance, grid) }
        };
        let mut warnings = Vec::new();
        let mut met = None;
        let field = match self.translation {
            TranslationKind::Plain => make(self.covariance)?,
            TranslationKind::Corrected => {
                let correction = TranslationCorrection::default();
                let CorrectedField { field, report } = if periodic {
                    correction.periodic(self.covariance, self.marginal, grid)?
                } else {
                    correction.free(self.covariance, self.marginal, grid)?
                };
                let left = report.corrected.largest_deviation;
                met = Some(format!(
                    "Corrected translation meets the correlation of the heights on {} to {}, plain translation would to {}; \
                     heights of this distribution cannot have a correlation below {}.",
                    self.size(),
                    sentence::digits(left),
                    sentence::digits(report.plain.largest_deviation),
                    sentence::digits(report.feasibility.least_correlation),
                ));
                if left > CORRELATION_LEFT {
                    warnings.push(format!(
                        "heights of the marginal distribution cannot have the correlation that was asked for: it is met to {}, by \
                         plain translation to {}",
                        sentence::digits(left),
                        sentence::digits(report.plain.largest_deviation)
                    ));
                }
                field
            }
        };
        if field.clipped_variance() > CLIPPED_VARIANCE {
            warnings.push(format!(
                "wrapped around a grid of {} the covariance is not positive definite, because a side holds too few \
                 correlation lengths; {} % of the variance was clipped",
                self.size(),
                sentence::digits(100.0 * field.clipped_variance())
            ));
        }
        let clipped_variance = field.clipped_variance();
        let (field, kept_variance) = match self.shortest_wave_m {
            Some(shortest_m) => field.without_waves_below(shortest_m),
            None => (field, 1.0),
        };
        let field = match order {
            XiOrder::Variance => field,
            XiOrder::Wavevector => field.by_wavevector(),
        };
        let std_share = kept_variance.sqrt();
        let marginal = self.marginal.standardised(0.0, std_share * self.marginal.std())?;
        let surface = Box::new(Translated::new(field, marginal)?);
        Ok(Generated { warnings, correction: met, clipped_variance, std_share, ..Generated::exact(surface) })
    }

    fn translated(&self, field: impl GaussianSurface + 'static) -> Result<Box<dyn RandomSurface>, SurfaceModelError> {
        Ok(Box::new(Translated::new(field, self.marginal.clone())?))
    }

    /// Formats the size of the grid.
    fn size(&self) -> String {
        sentence::size(self.grid.width_m(), self.grid.height_m())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::correlation::{CorrelationModel, Covariance};

    fn model(kind: CorrelationModel, length_m: f64, modes: Option<usize>) -> SurfaceModel {
        let covariance = SurfaceCovariance::Model(Covariance::isotropic(kind, 1e-6, length_m).unwrap());
        let expansion = Some(TruncatedExpansion { modes, mean_mode: true, rescale: None });
        let texture = Texture::Translated { covariance, translation: TranslationKind::Plain, expansion };
        SurfaceModel { marginal: Marginal::normal(0.0, 1e-6).unwrap(), texture, shortest_wave_m: None }
    }

    #[test]
    fn without_a_stated_number_the_terms_hold_the_slopes_or_all_fourier_modes_do() {
        let grid = Grid::new(48, 48, 1e-6, 1e-6).unwrap();
        let smooth = model(CorrelationModel::SquaredExponential, 8e-6, None);
        for periodic in [false, true] {
            let generated = smooth.patch(grid, periodic).unwrap();
            let found = generated.karhunen_loeve.unwrap();
            assert!(found.captured_slope_variance >= 0.9 && found.modes < 300, "{found:?}");
            assert!(generated.warnings.is_empty(), "{:?}", generated.warnings);
        }
        // Half of the slope of an exponential surface is in waves of a few pixels.
        let rough = model(CorrelationModel::Exponential, 8e-6, None).patch(grid, false).unwrap();
        assert!(rough.karhunen_loeve.is_none() && rough.correction.unwrap().contains("all Fourier modes"));
    }

    #[test]
    fn a_stated_number_of_terms_is_kept_and_warned_about_with_its_fraction_of_the_slopes() {
        let grid = Grid::new(48, 48, 1e-6, 1e-6).unwrap();
        let rough = model(CorrelationModel::Exponential, 8e-6, Some(101)).patch(grid, false).unwrap();
        let found = rough.karhunen_loeve.unwrap();
        assert!(found.modes == 101 && found.captured_slope_variance < 0.5, "{found:?}");
        assert!(rough.warnings.iter().any(|warning| warning.contains("of the slope variance")), "{:?}", rough.warnings);
    }
}
