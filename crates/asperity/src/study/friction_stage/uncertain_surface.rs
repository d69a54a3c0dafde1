//! Uncertain parameters of the random surface of a study.

use crate::chaos::Parameter;
use crate::stats::Interval;
use crate::study::StudyError;
use crate::study::check::UncertaintyStudy;
use crate::study::standard_deviation::{LengthStd, NumberStd};
use crate::study::surface_stage::SurfaceStage;
use crate::surface::model::{CompositeModel, SurfaceCovariance, Variation};

/// Names of the parameters.
const RMS_HEIGHT: &str = "rms_height";
const CORRELATION_LENGTH: &str = "correlation_length";
const SKEWNESS: &str = "skewness";

/// Random surface with uncertain parameters.
pub(super) struct UncertainSurface<'a> {
    model: &'a CompositeModel,
    pub(super) parameters: Vec<Parameter>,
}

impl<'a> UncertainSurface<'a> {
    pub(super) fn new(study: &UncertaintyStudy, surface: &'a SurfaceStage) -> Result<Self, StudyError> {
        let model = &surface.model.surface;
        let measured = |statistic: &str| surface.measured.as_ref()?.estimate(statistic);
        let length_x_m = model.covariance().map(SurfaceCovariance::length_x_m);
        let mut parameters = Vec::new();
        let absent = |key, statistic| StudyError::NoInterval { key, statistic };
        let lengths = [
            (RMS_HEIGHT, study.rms_height, Some(model.marginal.std()), "Sq_m"),
            (CORRELATION_LENGTH, study.correlation_length, length_x_m, "correlation_length_x_m"),
        ];
        for (key, std, nominal_m, statistic) in lengths {
            // Without a covariance the check of the study refuses an uncertain length.
            let (Some(std), Some(nominal_m)) = (std, nominal_m) else { continue };
            let parameter = match std {
                LengthStd::Relative(fraction) => Parameter::lognormal(key, nominal_m, fraction * nominal_m)?,
                LengthStd::Absolute(std) => Parameter::lognormal(key, nominal_m, std.0)?,
                LengthStd::Measured => {
                    let (value_m, Interval { low, high }) =
                        measured(statistic).filter(|(_, i)| i.low > 0.0).ok_or(absent(key, statistic))?;
                    // A model's length need not be the lag at which the scan's correlation is 1/e.
                    let scale = nominal_m / value_m;
                    Parameter::lognormal_within(key, Interval { low: scale * low, high: scale * high })?
                }
            };
            parameters.push(parameter);
        }
        if let Some(std) = study.skewness {
            let parameter = match std {
                NumberStd::Absolute(std) => Parameter::normal(SKEWNESS, model.marginal.skewness(), std)?,
                NumberStd::Measured => {
                    let (_, interval) = measured("Ssk").ok_or(absent(SKEWNESS, "Ssk"))?;
                    Parameter::normal_within(SKEWNESS, interval)?
                }
            };
            parameters.push(parameter);
        }
        Ok(Self { model: &surface.model, parameters })
    }

    /// Returns whether the heights have Johnson's distribution of a given skewness.
    pub(super) fn has_skewness(&self) -> bool {
        self.parameters.iter().any(|parameter| parameter.name() == SKEWNESS)
    }

    /// Returns the surface with these values of the parameters; the counterface does not change.
    pub(super) fn at(&self, values: &[f64]) -> Result<CompositeModel, StudyError> {
        let place = |name: &str| self.parameters.iter().position(|parameter| parameter.name() == name);
        let value = |name: &str| place(name).map(|place| values[place]);
        let (rms_height_m, correlation_length_m) = (value(RMS_HEIGHT), value(CORRELATION_LENGTH));
        let variation =
            Variation { rms_height_m, correlation_length_m, skewness: value(SKEWNESS), ..Variation::default() };
        Ok(CompositeModel { surface: self.model.surface.varied(&variation)?, ..self.model.clone() })
    }
}
