//! The friction that the oscillator slides on: of one window, computed or stated, and how much of it the nominal area keeps.

use std::path::Path;

use crate::distribution::Marginal;
use crate::friction::process::{CorrelationShape, FittedProcess, Generator, TranslationKind};
use crate::friction::upscaling::{exponential, variance_reduction};
use crate::study::StudyError;
use crate::study::check::{StatedFriction, VibrationStudy};
use crate::study::file::FrictionSection;
use crate::study::friction_stage::SolvedStrips;
use crate::study::plausibility::implausible_friction;
use crate::study::sentence;

/// Windows above which their mean counts as normal, whatever the law of one.
const MANY_WINDOWS: f64 = 30.0;

/// The friction of one window as a process.
pub(super) struct WindowFriction {
    pub(super) mean: f64,
    pub(super) std: f64,
    /// Shape of the correlation, a window in metre.
    pub(super) shape: CorrelationShape,
    /// Correlation length, which contains the window unless the shape has it.
    pub(super) length_m: f64,
    /// Whose correlation it is.
    pub(super) correlation: TranslationKind,
    pub(super) marginal: Marginal,
    /// How a fitted process is made, where it says so.
    pub(super) generator: Option<Generator>,
    /// Area over which this friction is averaged, where it is known.
    pub(super) area_m2: Option<f64>,
    /// Stribeck coefficient per unit of dimensionless velocity, if the law has one.
    pub(super) stribeck: Option<f64>,
    pub(super) level_percentile: Option<f64>,
    pub(super) level_mean_pressure_pa: Option<f64>,
    /// Variance over the nominal area over that of one window.
    pub(super) variance_reduction: f64,
    /// Whether the friction stage computed it.
    pub(super) computed: bool,
    /// Where it comes from, in words.
    pub(super) origin: String,
    pub(super) warnings: Vec<String>,
}

impl WindowFriction {
    /// That of the level that the study names, or of the one at the nominal pressure, at the mean load.
    pub(super) fn computed(study: &VibrationStudy, strips: &SolvedStrips) -> Result<Self, StudyError> {
        let level = strips.levels.get(strips.lead).ok_or(StudyError::NoStage("friction"))?;
        let process = &level.process;
        let mut warnings = Vec::new();
        let varies = process.moments.std > 0.0;
        // Constant friction has no correlation and no law; any will do, since nothing is drawn.
        let length_m = match &process.correlation {
            Ok(correlation) => correlation.exponential.length_m,
            Err(error) => {
                if varies {
                    warnings
                        .push(format!("friction has no correlation ({error}); the window's length is taken for it"));
                }
                strips.window.length_m()
            }
        };
        let marginal = process.marginal().map(|fit| fit.marginal.clone()).unwrap_or_else(|| {
            if varies {
                warnings.push("no law could be fitted to friction; the normal one is taken".into());
            }
            Marginal::STANDARD_NORMAL
        });
        let pressure_pa = level.level.mean_pressure_pa;
        let pressure = sentence::si(pressure_pa, "Pa");
        let origin = match level.control.percentile() {
            None => format!("of the level at the nominal pressure, {pressure}, at the mean load"),
            Some(percentile) => {
                let nominal_pa = study.nominal_pressure_pa();
                warnings.extend(unlike(&format!("at percentile {percentile}"), pressure_pa, nominal_pa));
                format!("of the level at percentile {percentile}, {pressure}, at the mean load")
            }
        };
        Ok(Self {
            mean: level.mean,
            std: process.moments.std,
            shape: CorrelationShape::Exponential,
            length_m,
            correlation: TranslationKind::Corrected,
            marginal,
            generator: None,
            area_m2: Some(strips.window.area_m2()),
            stribeck: study.dimensionless_stribeck(),
            level_percentile: level.control.percentile(),
            level_mean_pressure_pa: Some(pressure_pa),
            variance_reduction: level.variance_reduction(&strips.window, study.nominal_area.0),
            computed: true,
            origin,
            warnings,
        })
    }

    /// That which the study states, of a window of the customary size. Its correlation length counts in full when windows
    /// are averaged, since nothing tells how much of it is the window's.
    pub(super) fn stated(study: &VibrationStudy, friction: &StatedFriction) -> Self {
        let usual = FrictionSection::default();
        let (window_m, width_m) = (usual.window.0, usual.strip[1].0);
        let length_m = friction.correlation_length.0;
        Self {
            mean: friction.mean,
            std: friction.std,
            shape: CorrelationShape::Exponential,
            length_m,
            correlation: TranslationKind::Plain,
            marginal: friction.marginal.clone(),
            generator: None,
            area_m2: Some(window_m * width_m),
            stribeck: study.dimensionless_stribeck(),
            level_percentile: None,
            level_mean_pressure_pa: None,
            variance_reduction: variance_reduction(window_m, width_m, study.nominal_area.0, &exponential(length_m)),
            computed: false,
            origin: format!(
                "stated, taken for that of a window of {} whose correlation is not the window's",
                sentence::size(window_m, width_m)
            ),
            warnings: Vec::new(),
        }
    }

    /// That of a fitted process, which the study reads. A process
    /// that has a Stribeck coefficient brings it along. Friction of an unknown area is taken for that of the nominal area.
    pub(super) fn fitted(study: &VibrationStudy, file: &Path, process: &FittedProcess) -> Self {
        let velocity_m_per_s = study.scales.velocity_m_per_s();
        let mut warnings = Vec::new();
        let file = file.display();
        let area_m2 = process.averaged_over_m.map(|[length_m, width_m]| length_m * width_m);
        // Constant friction has no correlation and no law; any will do, since nothing is drawn.
        let (shape, length_m) =
            process.correlation.map_or((CorrelationShape::Exponential, 1e-3), |c| (c.shape, c.length_m));
        let own_length_m = process.correlation.map_or(0.0, |correlation| {
            let free = correlation.window_m.is_none() || matches!(shape, CorrelationShape::WindowedExponential { .. });
            correlation.length_without_window_m.unwrap_or(if free { length_m } else { 0.0 })
        });
        let variance_reduction = process.averaged_over_m.map_or(1.0, |[along_m, across_m]| {
            variance_reduction(along_m, across_m, study.nominal_area.0, &exponential(own_length_m))
        });
        if area_m2.is_none() && !process.is_constant() {
            warnings.push(format!(
                "{file} does not say over which area its friction is averaged; it is taken for that of the nominal area, and \
                 both upscalings are the same"
            ));
        }
        // The same but for the rounding of units is the same.
        let mut stribeck = study.dimensionless_stribeck();
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
        let nominal_pa = study.nominal_pressure_pa();
        if let Some(pressure_pa) = process.mean_pressure_pa {
            warnings.extend(unlike(&format!("from {file}"), pressure_pa, nominal_pa));
        }
        warnings.extend(implausible_friction(process.mean).map(|warning| format!("{file}: {warning}")));
        let described = if process.origin.description.is_empty() { "stated" } else { &process.origin.description };
        Self {
            mean: process.mean,
            std: process.std,
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
            computed: false,
            origin: format!("from {file}: {described}"),
            warnings,
        }
    }

    /// Whether the nominal area holds so many windows that their mean is normal, by the central limit theorem.
    pub(super) fn holds_many(&self) -> bool {
        self.variance_reduction * MANY_WINDOWS < 1.0
    }

    /// Law of the mean over the nominal area.
    pub(super) fn area_marginal(&self) -> Marginal {
        if self.holds_many() { Marginal::STANDARD_NORMAL } else { self.marginal.clone() }
    }
}

/// A warning where the level that the study names is pressed otherwise than the normal force presses the nominal area.
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
