//! Random surfaces of a study, on any grid.

use std::f64::consts::FRAC_PI_2;

use crate::correlation::{CorrelationModel, Covariance, MeasuredCovariance, StationaryCovariance};
use crate::distribution::Marginal;
use crate::map::Grid;
use crate::study::StudyError;
use crate::study::result::KarhunenLoeveResult;
use crate::study::sentence;
use crate::surface::{
    CorrectedField, GaussianSurface, KarhunenLoeve, ModesRoute, Predistorted, RandomSurface, SpectralField, Translated,
    TranslationCorrection, WeierstrassForm, WeierstrassMandelbrot, modes_for_slopes,
};
use crate::translation::TranslationKind;

/// Ratio of neighbouring wavenumbers and number of ridges of Weierstrass–Mandelbrot surfaces.
pub(super) const GAMMA: f64 = 1.5;
pub(super) const RIDGES: usize = 20;
/// Below this fraction of captured variance, or of slope variance, a Karhunen–Loève expansion is warned about.
const WANTED_VARIANCE: f64 = 0.9;
/// Terms that are looked for where a study states none: more than this many, and the patch has all Fourier modes.
pub(super) const MOST_MODES: usize = 400;
/// Terms over those that Fourier modes need, since the modes of a patch are not quite these.
const MARGIN: f64 = 1.1;
/// Factor on the terms where these do not hold the slopes.
const GROWTH: f64 = 1.25;
/// Above this deviation of the correlation a corrected translation is warned about.
const CORRELATION_LEFT: f64 = 0.01;
/// Above this share of clipped variance a spectral field is warned about.
pub(super) const CLIPPED_VARIANCE: f64 = 1e-3;

/// Random surfaces of one marginal law.
#[derive(Debug, Clone)]
pub(super) struct SurfaceModel {
    /// Marginal law of the heights in metre, of mean zero.
    pub(super) marginal: Marginal,
    pub(super) texture: Texture,
}

/// The covariance of random surfaces.
#[derive(Debug, Clone)]
pub(super) enum SurfaceCovariance {
    /// A function of few parameters.
    Model(Covariance),
    /// The scan's own.
    Empirical(Box<MeasuredCovariance>),
}

impl SurfaceCovariance {
    /// Length along x of the model, or the lag at which a measured correlation is 1/e, in metre.
    pub(super) fn length_x_m(&self) -> f64 {
        match self {
            Self::Model(covariance) => covariance.length_x_m(),
            Self::Empirical(covariance) => decay_lengths_m(covariance)[0],
        }
    }

    /// Power spectral density of profiles along x in m³, at q in rad/m.
    pub(super) fn profile_psd_x_m3(&self, q_rad_per_m: f64) -> f64 {
        match self {
            Self::Model(covariance) => covariance.profile_psd_x_m3(q_rad_per_m),
            Self::Empirical(covariance) => covariance.profile_psd_x_m3(q_rad_per_m),
        }
    }

    /// Power spectral density of profiles along y in m³, at q in rad/m.
    pub(super) fn profile_psd_y_m3(&self, q_rad_per_m: f64) -> f64 {
        match self {
            Self::Model(covariance) => covariance.profile_psd_y_m3(q_rad_per_m),
            Self::Empirical(covariance) => covariance.profile_psd_y_m3(q_rad_per_m),
        }
    }

    /// Mean of the two-dimensional power spectral density over the directions in m⁴, at each of the wavenumbers in rad/m.
    pub(super) fn radial_psd_m4(&self, q_rad_per_m: &[f64]) -> Vec<f64> {
        /// Directions over a quarter turn, by the symmetry of the models.
        const DIRECTIONS: usize = 90;

        match self {
            Self::Model(covariance) => {
                let angles = || (0..DIRECTIONS).map(|i| (i as f64 + 0.5) * FRAC_PI_2 / DIRECTIONS as f64);
                let density = |q: f64| angles().map(move |a| covariance.psd_m4(q * a.cos(), q * a.sin())).sum::<f64>();
                q_rad_per_m.iter().map(|q| density(*q) / DIRECTIONS as f64).collect()
            }
            Self::Empirical(covariance) => covariance.radial_psd_m4(q_rad_per_m),
        }
    }

    /// Whether it is a product of one along x and one along y.
    fn is_product(&self) -> bool {
        matches!(self, Self::Model(covariance) if covariance.model() == CorrelationModel::SquaredExponential)
    }
}

impl StationaryCovariance for SurfaceCovariance {
    fn std_m(&self) -> f64 {
        match self {
            Self::Model(covariance) => covariance.std_m(),
            Self::Empirical(covariance) => covariance.std_m(),
        }
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        match self {
            Self::Model(covariance) => covariance.correlation(dx_m, dy_m),
            Self::Empirical(covariance) => covariance.correlation(dx_m, dy_m),
        }
    }

    fn mirror_symmetric(&self) -> bool {
        match self {
            Self::Model(covariance) => covariance.mirror_symmetric(),
            Self::Empirical(covariance) => covariance.mirror_symmetric(),
        }
    }
}

/// In which order a ξ stands for the waves of a spectral field.
#[derive(Debug, Clone, Copy)]
enum XiOrder {
    /// From the greatest variance.
    Variance,
    /// The same for all covariances.
    Wavevector,
}

/// How heights at different points belong together.
#[derive(Debug, Clone)]
pub(super) enum Texture {
    /// A Gaussian field of this covariance under a translation.
    Translated {
        covariance: SurfaceCovariance,
        translation: TranslationKind,
        /// The Karhunen–Loève expansion of patches; none: all Fourier modes.
        expansion: Option<Expansion>,
    },
    /// The sum of cosines of this fractal dimension, scaled to the standard deviation of the marginal law.
    WeierstrassMandelbrot { dimension: f64 },
}

/// A truncated Karhunen–Loève expansion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expansion {
    /// Terms that a study states; none: as many as hold 90 % of the slope variance.
    pub(super) modes: Option<usize>,
    /// Whether the constant Fourier mode of a periodic patch is among them.
    pub(super) mean_mode: bool,
    /// Whether one factor makes up for the variance left out, or nothing does; none: the marginal law is imposed at every point.
    pub(super) rescale: Option<bool>,
}

/// A random surface on a grid, and what is worth knowing about it.
pub(super) struct Generated {
    pub(super) surface: Box<dyn RandomSurface>,
    pub(super) karhunen_loeve: Option<KarhunenLoeveResult>,
    /// Standard deviation of the heights, averaged over the patch, over that of the marginal law.
    pub(super) std_share: f64,
    pub(super) warnings: Vec<String>,
    /// How well the correlation of the heights is met, where the translation was corrected for it.
    pub(super) correction: Option<String>,
    /// Fraction of the variance that was clipped from a spectral field.
    pub(super) clipped_variance: f64,
}

impl SurfaceModel {
    /// The covariance, where the surfaces are made from one.
    pub(super) fn covariance(&self) -> Option<&SurfaceCovariance> {
        match &self.texture {
            Texture::Translated { covariance, .. } => Some(covariance),
            Texture::WeierstrassMandelbrot { .. } => None,
        }
    }

    /// Surfaces for small patches, by the generator of the study.
    pub(super) fn patch(&self, grid: Grid, periodic: bool) -> Result<Generated, StudyError> {
        match self.texture {
            Texture::Translated { ref covariance, translation, expansion: Some(expansion) } => {
                if let Some(modes) = expansion.modes {
                    return self.expanded(covariance, translation, expansion, modes, grid, periodic);
                }
                let needed = modes_for_slopes(covariance, grid, WANTED_VARIANCE);
                let most = MOST_MODES.min(grid.points());
                let mut modes = (MARGIN * needed as f64).ceil() as usize + 1;
                while modes <= most {
                    let generated = self.expanded(covariance, translation, expansion, modes, grid, periodic)?;
                    let found = generated.karhunen_loeve.as_ref();
                    if found.is_none_or(|found| found.captured_slope_variance >= WANTED_VARIANCE) {
                        return Ok(generated);
                    }
                    modes = (GROWTH * modes as f64).ceil() as usize;
                }
                self.all_fourier_modes(covariance, translation, expansion, needed, grid, periodic)
            }
            Texture::Translated { ref covariance, translation, expansion: None } => {
                self.spectral(covariance, translation, XiOrder::Variance, grid, periodic)
            }
            Texture::WeierstrassMandelbrot { dimension } => self.weierstrass_mandelbrot(dimension, grid),
        }
    }

    /// Karhunen–Loève surfaces of this many terms.
    fn expanded(
        &self,
        covariance: &SurfaceCovariance,
        translation: TranslationKind,
        expansion: Expansion,
        modes: usize,
        grid: Grid,
        periodic: bool,
    ) -> Result<Generated, StudyError> {
        match translation {
            TranslationKind::Plain => {
                self.karhunen_loeve(covariance, expansion, modes, covariance.is_product(), grid, periodic)
            }
            TranslationKind::Corrected => {
                let corrected = Predistorted::new(covariance, &self.marginal)?;
                let correction = Some(format!(
                    "The correlation beneath the translation was distorted beforehand so that the heights keep theirs; \
                     heights of this law cannot have a correlation below {}.",
                    sentence::digits(corrected.least_correlation())
                ));
                let generated = self.karhunen_loeve(&corrected, expansion, modes, false, grid, periodic)?;
                Ok(Generated { correction, ..generated })
            }
        }
    }

    /// Spectral surfaces in place of a Karhunen–Loève expansion that would need too many terms. Where a study says what is done
    /// about the variance that an expansion leaves out, the expansion has the most terms instead.
    fn all_fourier_modes(
        &self,
        covariance: &SurfaceCovariance,
        translation: TranslationKind,
        expansion: Expansion,
        needed: usize,
        grid: Grid,
        periodic: bool,
    ) -> Result<Generated, StudyError> {
        if expansion.rescale.is_some() || !expansion.mean_mode {
            return self.expanded(covariance, translation, expansion, MOST_MODES, grid, periodic);
        }
        let generated = self.spectral(covariance, translation, XiOrder::Variance, grid, periodic)?;
        let told = format!(
            "A Karhunen–Loève expansion of a patch of {} would need {} terms or more to hold {} % of the slope variance, so that \
             its surfaces have all Fourier modes of the grid instead; state `modes` to have an expansion.",
            sentence::size(grid.width_m(), grid.height_m()),
            needed,
            sentence::digits(100.0 * WANTED_VARIANCE),
        );
        let correction = Some(generated.correction.map_or(told.clone(), |correction| format!("{told} {correction}")));
        Ok(Generated { correction, ..generated })
    }

    /// Surfaces for long strips. A truncated expansion cannot hold their variance, so all Fourier modes are used in its
    /// place.
    pub(super) fn strip(&self, grid: Grid, periodic: bool) -> Result<Generated, StudyError> {
        self.strip_in(XiOrder::Variance, grid, periodic)
    }

    /// The same with a ξ that means the same waves for every covariance, where the grid is periodic.
    pub(super) fn comparable_strip(&self, grid: Grid, periodic: bool) -> Result<Generated, StudyError> {
        self.strip_in(XiOrder::Wavevector, grid, periodic)
    }

    fn strip_in(&self, order: XiOrder, grid: Grid, periodic: bool) -> Result<Generated, StudyError> {
        match self.texture {
            Texture::Translated { ref covariance, translation, .. } => {
                self.spectral(covariance, translation, order, grid, periodic)
            }
            Texture::WeierstrassMandelbrot { dimension } => self.weierstrass_mandelbrot(dimension, grid),
        }
    }

    /// `product`: the covariance is a product of one along x and one along y.
    fn karhunen_loeve(
        &self,
        covariance: &dyn StationaryCovariance,
        Expansion { mean_mode, rescale, .. }: Expansion,
        modes: usize,
        product: bool,
        grid: Grid,
        periodic: bool,
    ) -> Result<Generated, StudyError> {
        let route = match (periodic, product) {
            (true, _) => ModesRoute::Periodic,
            (false, true) => ModesRoute::Separable,
            (false, false) => ModesRoute::General,
        };
        if !mean_mode && !periodic {
            return Err(StudyError::ConstantMode);
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
                sentence::size(grid.width_m(), grid.height_m())
            ));
        }
        let captured_slope_variance = field.captured_slope_variance();
        if captured_slope_variance < WANTED_VARIANCE {
            warnings.push(format!(
                "{modes} Karhunen–Loève terms hold {} % of the slope variance on a patch of {}: the slopes of the random surfaces are \
                 {} times those of the model, and elastic contact area and friction depend on slopes; leave `modes` out, or use the \
                 spectral generator",
                sentence::digits(100.0 * captured_slope_variance),
                sentence::size(grid.width_m(), grid.height_m()),
                sentence::digits(captured_slope_variance.sqrt()),
            ));
        }
        let karhunen_loeve = Some(KarhunenLoeveResult { modes, captured_variance, captured_slope_variance });
        let (surface, std_share): (Box<dyn RandomSurface>, f64) = match rescale {
            None => (self.translated(field)?, 1.0),
            Some(true) => (Box::new(field.rescaled()), 1.0),
            Some(false) => (Box::new(field), captured_variance.sqrt()),
        };
        Ok(Generated { surface, karhunen_loeve, std_share, warnings, correction: None, clipped_variance: 0.0 })
    }

    fn spectral(
        &self,
        covariance: &SurfaceCovariance,
        translation: TranslationKind,
        order: XiOrder,
        grid: Grid,
        periodic: bool,
    ) -> Result<Generated, StudyError> {
        let make = |covariance: &dyn StationaryCovariance| {
            if periodic { Ok(SpectralField::periodic(covariance, grid)) } else { SpectralField::free(covariance, grid) }
        };
        let mut warnings = Vec::new();
        let mut told = None;
        let field = match translation {
            TranslationKind::Plain => make(covariance)?,
            TranslationKind::Corrected => {
                let correction = TranslationCorrection::default();
                let CorrectedField { field, report } = if periodic {
                    correction.periodic(covariance, &self.marginal, grid)?
                } else {
                    correction.free(covariance, &self.marginal, grid)?
                };
                let left = report.corrected.largest_deviation;
                told = Some(format!(
                    "Corrected translation meets the correlation of the heights on {} to {}, plain translation would to {}; \
                     heights of this law cannot have a correlation below {}.",
                    sentence::size(grid.width_m(), grid.height_m()),
                    sentence::digits(left),
                    sentence::digits(report.plain.largest_deviation),
                    sentence::digits(report.feasibility.least_correlation),
                ));
                if left > CORRELATION_LEFT {
                    warnings.push(format!(
                        "heights of the marginal law cannot have the correlation that was asked for: it is met to {}, by \
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
                sentence::size(grid.width_m(), grid.height_m()),
                sentence::digits(100.0 * field.clipped_variance())
            ));
        }
        let clipped_variance = field.clipped_variance();
        Ok(Generated {
            surface: self.translated(match order {
                XiOrder::Variance => field,
                XiOrder::Wavevector => field.by_wavevector(),
            })?,
            karhunen_loeve: None,
            std_share: 1.0,
            warnings,
            correction: told,
            clipped_variance,
        })
    }

    fn translated(&self, field: impl GaussianSurface + 'static) -> Result<Box<dyn RandomSurface>, StudyError> {
        Ok(Box::new(Translated::new(field, self.marginal.clone())?))
    }

    fn weierstrass_mandelbrot(&self, dimension: f64, grid: Grid) -> Result<Generated, StudyError> {
        // The rms height sets G, so any positive value will do here.
        let form = WeierstrassForm::Truncated;
        let surface = WeierstrassMandelbrot::new(grid, dimension, GAMMA, RIDGES, 1e-9, form)?
            .with_rms_height(self.marginal.std())?;
        Ok(Generated {
            surface: Box::new(surface),
            karhunen_loeve: None,
            std_share: 1.0,
            warnings: Vec::new(),
            correction: None,
            clipped_variance: 0.0,
        })
    }
}

/// Lags along x and y at which a measured correlation is 1/e, in metre.
pub(super) fn decay_lengths_m(own: &MeasuredCovariance) -> [f64; 2] {
    let (x_m, y_m) = own.support_m();
    [decay_length_m(x_m, |lag_m| own.correlation(lag_m, 0.0)), decay_length_m(y_m, |lag_m| own.correlation(0.0, lag_m))]
}

/// The first lag at which a correlation that ends at `end_m` is 1/e.
pub(super) fn decay_length_m(end_m: f64, correlation: impl Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 4096;
    let (level, step_m) = ((-1.0_f64).exp(), end_m / STEPS as f64);
    let after = (1..=STEPS).find(|&step| correlation(step as f64 * step_m) <= level).unwrap_or(STEPS);
    let (mut low_m, mut high_m) = ((after - 1) as f64 * step_m, after as f64 * step_m);
    while high_m - low_m > 1e-12 * end_m {
        let middle_m = 0.5 * (low_m + high_m);
        if correlation(middle_m) > level { low_m = middle_m } else { high_m = middle_m }
    }
    0.5 * (low_m + high_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(kind: CorrelationModel, length_m: f64, modes: Option<usize>) -> SurfaceModel {
        let covariance = SurfaceCovariance::Model(Covariance::isotropic(kind, 1e-6, length_m).unwrap());
        let expansion = Some(Expansion { modes, mean_mode: true, rescale: None });
        let texture = Texture::Translated { covariance, translation: TranslationKind::Plain, expansion };
        SurfaceModel { marginal: Marginal::normal(0.0, 1e-6).unwrap(), texture }
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
