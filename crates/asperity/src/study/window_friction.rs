//! The friction that the oscillator slides on: of one window, computed or stated, and how much of it the nominal area keeps.

use crate::friction::upscaling::{exponential, variance_reduction};
use crate::law::Marginal;
use crate::study::StudyError;
use crate::study::config::{FrictionSection, VibrationSection};
use crate::study::friction_stage::SolvedStrips;
use crate::study::sentence;

/// Windows above which their mean counts as normal, whatever the law of one.
const MANY_WINDOWS: f64 = 30.0;

/// The friction of one window as a process.
pub(super) struct WindowFriction {
    pub(super) mean: f64,
    pub(super) std: f64,
    /// Correlation length, which contains the window.
    pub(super) length_m: f64,
    pub(super) marginal: Marginal,
    pub(super) area_m2: f64,
    pub(super) level_percentile: Option<f64>,
    pub(super) level_mean_pressure_pa: Option<f64>,
    /// Variance over the nominal area over that of one window.
    pub(super) variance_reduction: f64,
    /// Where it comes from, in words.
    pub(super) origin: String,
    pub(super) warnings: Vec<String>,
}

impl WindowFriction {
    /// That of the level that the study names, or of the one at the nominal pressure, at the mean load.
    pub(super) fn computed(section: &VibrationSection, strips: &SolvedStrips) -> Result<Self, StudyError> {
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
        let marginal = process.marginal().map(|fit| fit.law.clone()).unwrap_or_else(|| {
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
                let nominal_pa = section.normal_force.0 / section.nominal_area.0;
                warnings.extend(unlike(percentile, pressure_pa, nominal_pa));
                format!("of the level at percentile {percentile}, {pressure}, at the mean load")
            }
        };
        Ok(Self {
            mean: level.mean,
            std: process.moments.std,
            length_m,
            marginal,
            area_m2: strips.window.area_m2(),
            level_percentile: level.control.percentile(),
            level_mean_pressure_pa: Some(pressure_pa),
            variance_reduction: level.variance_reduction(&strips.window, section.nominal_area.0),
            origin,
            warnings,
        })
    }

    /// That which the study states, of a window of the customary size. Its correlation length counts in full when windows
    /// are averaged, since nothing tells how much of it is the window's.
    pub(super) fn stated(section: &VibrationSection) -> Result<Self, StudyError> {
        let usual = FrictionSection::default();
        let (window_m, width_m) = (usual.window.0, usual.strip[1].0);
        let absent = || StudyError::NoStage("friction");
        let length_m = section.friction_correlation_length.ok_or_else(absent)?.0;
        Ok(Self {
            mean: section.static_friction.ok_or_else(absent)?,
            std: section.friction_std.ok_or_else(absent)?,
            length_m,
            marginal: section.friction_marginal.as_deref().ok_or_else(absent)?.parse()?,
            area_m2: window_m * width_m,
            level_percentile: None,
            level_mean_pressure_pa: None,
            variance_reduction: variance_reduction(window_m, width_m, section.nominal_area.0, &exponential(length_m)),
            origin: format!(
                "stated, taken for that of a window of {} whose correlation is not the window's",
                sentence::size(window_m, width_m)
            ),
            warnings: Vec::new(),
        })
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
fn unlike(percentile: f64, pressure_pa: f64, nominal_pa: f64) -> Option<String> {
    let ratio = pressure_pa / nominal_pa;
    (!(0.5..=2.0).contains(&ratio)).then(|| {
        format!(
            "friction is taken at percentile {percentile}, whose mean pressure of {} is {} times the {} of the normal force on \
             the nominal area",
            sentence::si(pressure_pa, "Pa"),
            sentence::digits(ratio),
            sentence::si(nominal_pa, "Pa")
        )
    })
}
