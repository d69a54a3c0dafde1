//! Friction of one window as a process, computed, fitted or stated, and its variance over the nominal area.

use asperity_base::distribution::Marginal;
use asperity_base::sentence;
use asperity_process::{CorrelationShape, FittedProcess, Generator, ProcessModel, TranslationKind};
use serde::{Deserialize, Serialize};

use crate::RoughBody;
use crate::mean_errors::MeanErrors;
use crate::solved_level::SolvedLevel;
use crate::upscaling::{Upscaling, exponential, variance_reduction};

/// Number of windows above which their mean is normal for any distribution of one window.
const MANY_WINDOWS: f64 = 30.0;

/// Nominal area and the normal force on it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NominalContact {
    /// Nominal area in m².
    pub area_m2: f64,
    /// Normal force over nominal area in pascal.
    pub pressure_pa: f64,
}

/// Stated friction of a window.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StatedFriction {
    /// Mean friction coefficient.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Correlation length in metre.
    pub length_m: f64,
    /// Marginal distribution; its mean and standard deviation are replaced.
    pub marginal: Marginal,
    /// Length and width of the window in metre.
    pub window_m: [f64; 2],
}

/// Friction of one window as a process.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct WindowFriction {
    /// Mean friction coefficient.
    pub mean: f64,
    /// Errors of `mean` beside that of sampling.
    pub mean_errors: MeanErrors,
    /// Standard deviation along the path.
    pub std: f64,
    /// Standard deviation between parts with a window of their own; 0 if friction is that of a rough track, stated or fitted.
    pub between_parts_std: f64,
    /// Shape of the correlation; its window is in metre.
    pub shape: CorrelationShape,
    /// Correlation length in metre; it contains the effect of the window unless the shape does.
    pub length_m: f64,
    /// Translation under which the correlation is given.
    pub correlation: TranslationKind,
    /// Marginal distribution; its mean and standard deviation are replaced.
    pub marginal: Marginal,
    /// Generator of a fitted process; `None` if it states none.
    pub generator: Option<Generator>,
    /// Area in m² over which this friction is averaged; `None` is unknown.
    pub area_m2: Option<f64>,
    /// Stribeck coefficient per unit of dimensionless velocity; `None` for other velocity laws.
    pub stribeck: Option<f64>,
    /// Percentile of the level; `None` if the friction is not computed at one.
    pub level_percentile: Option<f64>,
    /// Mean pressure of the level in pascal; `None` is unknown.
    pub level_mean_pressure_pa: Option<f64>,
    /// Variance over the nominal area divided by the variance of one window.
    pub variance_reduction: f64,
    /// Stiffness of the contact over the nominal area in Pa/m; `None` is unknown.
    pub stiffness_pa_per_m: Option<f64>,
    /// Whether the friction was computed from solved strips.
    pub computed: bool,
    /// Origin of the friction, for sentences.
    pub origin: String,
    /// Warnings in sentences.
    pub warnings: Vec<String>,
}

impl WindowFriction {
    /// Returns this friction with all its values multiplied.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let Self { mean, std, between_parts_std, .. } = self;
        Self { mean: factor * mean, std: factor * std, between_parts_std: factor * between_parts_std, ..self }
    }

    /// Returns the friction of the window of a level at the mean load; `stribeck` is per unit of dimensionless velocity.
    ///
    /// It fluctuates along the path if the track is rough; between two rough bodies as [`SolvedLevel::two_bodies`] states. A rough
    /// slider has the constant friction of a mean part.
    pub fn from_level(level: &SolvedLevel, body: RoughBody, nominal: NominalContact, stribeck: Option<f64>) -> Self {
        let (process, window) = (&level.process, &level.window);
        let mut warnings = Vec::new();
        let two_bodies = level.two_bodies.filter(|_| body == RoughBody::Both);
        let (std, between_parts_std) = match (body, two_bodies) {
            (RoughBody::Track, _) => (process.moments.std, 0.0),
            (_, Some(found)) => (found.path_std, found.between_parts_std),
            (_, None) => (0.0, process.moments.std),
        };
        let varies = std > 0.0;
        // Constant friction has neither correlation nor distribution; the values are not used.
        let length_m = match (two_bodies, &process.correlation) {
            (Some(found), _) => found.path_length_m,
            (None, Ok(correlation)) => correlation.exponential.length_m,
            (None, Err(error)) => {
                if varies {
                    warnings
                        .push(format!("friction has no correlation ({error}); the window's length is taken for it"));
                }
                window.length_m()
            }
        };
        let marginal = process.marginal().map(|fit| fit.marginal.clone()).unwrap_or_else(|| {
            if varies {
                warnings.push("no distribution could be fitted to friction; the normal distribution is taken".into());
            }
            Marginal::STANDARD_NORMAL
        });
        let pressure_pa = level.strips.mean_pressure_pa;
        let pressure = sentence::si(pressure_pa, "Pa");
        let origin = match level.control.percentile() {
            None => format!("of the level at the nominal pressure, {pressure}, at the mean load"),
            Some(percentile) => {
                warnings.extend(unlike(&format!("at percentile {percentile}"), pressure_pa, nominal.pressure_pa));
                format!("of the level at percentile {percentile}, {pressure}, at the mean load")
            }
        };
        let origin = match body {
            RoughBody::Track => origin,
            RoughBody::Slider => format!("{origin}; a rough slider carries its contacts along"),
            RoughBody::Both => format!("{origin}; that of a mean part of the rough slider"),
        };
        Self {
            mean: level.mean,
            mean_errors: level.mean_errors.clone(),
            std,
            between_parts_std,
            shape: CorrelationShape::Exponential,
            length_m,
            correlation: TranslationKind::Corrected,
            marginal,
            generator: None,
            area_m2: Some(window.area_m2()),
            stribeck,
            level_percentile: level.control.percentile(),
            level_mean_pressure_pa: Some(pressure_pa),
            variance_reduction: level.variance_reduction(nominal.area_m2),
            stiffness_pa_per_m: level.strips.stiffness_pa_per_m().map(|(mean, _)| mean),
            computed: true,
            origin,
            warnings,
        }
    }

    /// Returns stated friction. Averages over windows use the whole correlation length, because the part due to the window is
    /// unknown.
    pub fn from_statement(stated: StatedFriction, nominal_area_m2: f64, stribeck: Option<f64>) -> Self {
        let StatedFriction { mean, std, length_m, marginal, window_m: [window_m, width_m] } = stated;
        Self {
            mean,
            mean_errors: MeanErrors::default(),
            std,
            between_parts_std: 0.0,
            shape: CorrelationShape::Exponential,
            length_m,
            correlation: TranslationKind::Plain,
            marginal,
            generator: None,
            area_m2: Some(window_m * width_m),
            stribeck,
            level_percentile: None,
            level_mean_pressure_pa: None,
            variance_reduction: variance_reduction(window_m, width_m, nominal_area_m2, &exponential(length_m)),
            stiffness_pa_per_m: None,
            computed: false,
            origin: format!(
                "stated, taken for that of a window of {} whose correlation is not the window's",
                sentence::size(window_m, width_m)
            ),
            warnings: Vec::new(),
        }
    }

    /// Returns the friction of a fitted process from the file `file`; `velocity_m_per_s` is the unit of dimensionless velocity.
    ///
    /// A Stribeck coefficient of the process replaces `stribeck`. Friction that is averaged over an unknown area is used as that
    /// of the nominal area.
    pub fn from_process(
        process: &FittedProcess,
        file: &str,
        nominal: NominalContact,
        mut stribeck: Option<f64>,
        velocity_m_per_s: f64,
    ) -> Self {
        let mut warnings = Vec::new();
        let area_m2 = process.averaged_over_m.map(|[length_m, width_m]| length_m * width_m);
        // Constant friction has neither correlation nor distribution; the values are not used.
        let (shape, length_m) =
            process.correlation.map_or((CorrelationShape::Exponential, 1e-3), |c| (c.shape, c.length_m));
        let own_length_m = process.correlation.map_or(0.0, |correlation| {
            let free = correlation.window_m.is_none() || matches!(shape, CorrelationShape::WindowedExponential { .. });
            correlation.length_without_window_m.unwrap_or(if free { length_m } else { 0.0 })
        });
        let variance_reduction = process.averaged_over_m.map_or(1.0, |[along_m, across_m]| {
            variance_reduction(along_m, across_m, nominal.area_m2, &exponential(own_length_m))
        });
        if area_m2.is_none() && !process.is_constant() {
            warnings.push(format!(
                "{file} does not say over which area its friction is averaged; it is taken for that of the nominal area, and \
                 both upscalings are the same"
            ));
        }
        // Conversions between units round.
        if let Some((own, stated)) = process.stribeck(velocity_m_per_s).zip(stribeck)
            && (own - stated).abs() > 1e-9 * stated
        {
            stribeck = Some(own);
            warnings.push(format!(
                "the Stribeck coefficient of {file}, {} s/m or {} per unit of dimensionless velocity, takes the place of \
                 `stribeck` = {}",
                sentence::digits(own / velocity_m_per_s),
                sentence::digits(own),
                sentence::digits(stated)
            ));
        }
        if let Some(pressure_pa) = process.mean_pressure_pa {
            warnings.extend(unlike(&format!("from {file}"), pressure_pa, nominal.pressure_pa));
        }
        let described = if process.origin.description.is_empty() { "stated" } else { &process.origin.description };
        Self {
            mean: process.mean,
            mean_errors: MeanErrors::default(),
            std: process.std,
            between_parts_std: 0.0,
            shape,
            length_m,
            correlation: TranslationKind::Corrected,
            marginal: process.marginal.clone().unwrap_or(Marginal::STANDARD_NORMAL),
            generator: process.generator,
            area_m2,
            stribeck,
            level_percentile: None,
            level_mean_pressure_pa: process.mean_pressure_pa,
            variance_reduction,
            stiffness_pa_per_m: None,
            computed: false,
            origin: format!("from {file}: {described}"),
            warnings,
        }
    }

    /// Returns whether the nominal area contains so many windows that their mean is normal, by the central limit theorem.
    pub fn holds_many(&self) -> bool {
        self.variance_reduction * MANY_WINDOWS < 1.0
    }

    /// Returns the standard deviation of the friction of the nominal area.
    pub fn upscaled_std(&self, upscaling: Upscaling) -> f64 {
        match upscaling {
            Upscaling::Area => self.std * self.variance_reduction.sqrt(),
            Upscaling::Paper => self.std,
        }
    }

    /// Returns the process of the friction fluctuation of the nominal area, with lengths in units of `unit_m`.
    ///
    /// `generator` replaces the generator of a fitted process; without either it follows from the correlation. A diffusion
    /// reproduces only its own distribution, so it does not generate the normal mean of many windows.
    pub fn process_model(&self, upscaling: Upscaling, generator: Option<Generator>, unit_m: f64) -> ProcessModel {
        let marginal = match upscaling {
            Upscaling::Area if self.holds_many() => Marginal::STANDARD_NORMAL,
            Upscaling::Area | Upscaling::Paper => self.marginal.clone(),
        };
        let usable = generator.or(self.generator).filter(|generator| {
            *generator != Generator::Jacobi || matches!(marginal, Marginal::Beta { .. }) || !self.holds_many()
        });
        ProcessModel {
            shape: self.shape.in_unit(unit_m),
            generator: usable.unwrap_or_else(|| Generator::for_shape(self.shape)),
            correlation: self.correlation,
            ..ProcessModel::new(marginal, self.upscaled_std(upscaling), self.length_m / unit_m)
        }
    }
}

/// Returns a warning if the mean pressure of the level differs from that of the normal force on the nominal area.
fn unlike(place: &str, pressure_pa: f64, nominal_pa: f64) -> Option<String> {
    let ratio = pressure_pa / nominal_pa;
    (!(0.5..=2.0).contains(&ratio)).then(|| {
        format!(
            "friction is taken {place}, whose mean pressure of {} is {} times the {} of the normal force on \
             the nominal area",
            sentence::si(pressure_pa, "Pa"),
            sentence::digits(ratio),
            sentence::si(nominal_pa, "Pa")
        )
    })
}
