//! The random surface of a study with other parameters.

use crate::chaos::Parameter;
use crate::correlation::Covariance;
use crate::distribution::Marginal;
use crate::stats::Interval;
use crate::study::StudyError;
use crate::study::file::UncertaintySection;
use crate::study::scatter::{LengthScatter, NumberScatter};
use crate::study::surface_model::{SurfaceCovariance, SurfaceModel, Texture};
use crate::study::surface_stage::SurfaceStage;

/// Which parameter of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    RmsHeight,
    CorrelationLength,
    Skewness,
}

/// A random surface some of whose parameters are uncertain.
pub(super) struct UncertainSurface<'a> {
    model: &'a SurfaceModel,
    /// Correlation length along x of the model; `None` without a covariance.
    length_x_m: Option<f64>,
    kinds: Vec<Kind>,
    pub(super) parameters: Vec<Parameter>,
}

impl<'a> UncertainSurface<'a> {
    pub(super) fn new(section: &UncertaintySection, surface: &'a SurfaceStage) -> Result<Self, StudyError> {
        let model = &surface.model;
        let measured = |statistic: &str| surface.measured.as_ref()?.estimate(statistic);
        let length_x_m = model.covariance().map(SurfaceCovariance::length_x_m);
        let (mut kinds, mut parameters) = (Vec::new(), Vec::new());
        let absent = |key, statistic| StudyError::NoInterval { key, statistic };
        let lengths = [
            (Kind::RmsHeight, "rms_height", section.rms_height, Some(model.marginal.std()), "Sq_m"),
            (
                Kind::CorrelationLength,
                "correlation_length",
                section.correlation_length,
                length_x_m,
                "correlation_length_x_m",
            ),
        ];
        for (kind, key, scatter, nominal_m, statistic) in lengths {
            // Without a covariance the check of the study refuses an uncertain length.
            let (Some(scatter), Some(nominal_m)) = (scatter, nominal_m) else { continue };
            let parameter = match scatter {
                LengthScatter::Relative(share) => Parameter::lognormal(key, nominal_m, share * nominal_m)?,
                LengthScatter::Absolute(std) => Parameter::lognormal(key, nominal_m, std.0)?,
                LengthScatter::Measured => {
                    let (value_m, Interval { low, high }) =
                        measured(statistic).filter(|(_, i)| i.low > 0.0).ok_or(absent(key, statistic))?;
                    // A model's length need not be the lag at which the scan's correlation is 1/e.
                    let scale = nominal_m / value_m;
                    Parameter::lognormal_within(key, Interval { low: scale * low, high: scale * high })?
                }
            };
            kinds.push(kind);
            parameters.push(parameter);
        }
        if let Some(scatter) = section.skewness {
            let parameter = match scatter {
                NumberScatter::Absolute(std) => Parameter::normal("skewness", model.marginal.skewness(), std)?,
                NumberScatter::Measured => {
                    let (_, interval) = measured("Ssk").ok_or(absent("skewness", "Ssk"))?;
                    Parameter::normal_within("skewness", interval)?
                }
            };
            kinds.push(Kind::Skewness);
            parameters.push(parameter);
        }
        Ok(Self { model, length_x_m, kinds, parameters })
    }

    /// Whether the heights have another law than the study's: Johnson's of a given skewness.
    pub(super) fn has_skewness(&self) -> bool {
        self.kinds.contains(&Kind::Skewness)
    }

    /// The surface with these values of the parameters.
    ///
    /// The kurtosis of a law of skewness g is κ + g² − g₀², with κ and g₀ those of the study's law: as far above 1 + g², the least
    /// that any law has, as before.
    pub(super) fn at(&self, values: &[f64]) -> Result<SurfaceModel, StudyError> {
        let value = |kind: Kind| self.kinds.iter().zip(values).find(|(own, _)| **own == kind).map(|(_, value)| *value);
        let law = &self.model.marginal;
        let std_m = value(Kind::RmsHeight).unwrap_or(law.std());
        let marginal = match value(Kind::Skewness) {
            None => law.standardised(0.0, std_m)?,
            Some(skewness) => {
                let excess_kurtosis = law.excess_kurtosis() + skewness * skewness - law.skewness().powi(2);
                Marginal::johnson_with_moments(0.0, std_m, skewness, excess_kurtosis)?
            }
        };
        let lengths = value(Kind::CorrelationLength).zip(self.length_x_m);
        let stretch = lengths.map_or(1.0, |(length_m, own_m)| length_m / own_m);
        let texture = match &self.model.texture {
            Texture::Translated { covariance, translation, expansion } => Texture::Translated {
                covariance: stretched(covariance, std_m, stretch)?,
                translation: *translation,
                expansion: *expansion,
            },
            Texture::WeierstrassMandelbrot { dimension } => Texture::WeierstrassMandelbrot { dimension: *dimension },
        };
        Ok(SurfaceModel { marginal, texture })
    }
}

fn stretched(covariance: &SurfaceCovariance, std_m: f64, factor: f64) -> Result<SurfaceCovariance, StudyError> {
    Ok(match covariance {
        SurfaceCovariance::Model(own) => {
            let (x_m, y_m) = (factor * own.length_x_m(), factor * own.length_y_m());
            SurfaceCovariance::Model(Covariance::new(own.model(), std_m, x_m, y_m)?)
        }
        SurfaceCovariance::Empirical(own) => {
            SurfaceCovariance::Empirical(Box::new((**own).clone().with_std(std_m).stretched(factor)))
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::{CorrelationModel, StationaryCovariance};
    use crate::translation::TranslationKind;

    #[test]
    fn a_point_has_the_parameters_that_it_states() {
        let covariance = Covariance::new(CorrelationModel::Exponential, 1e-6, 20e-6, 10e-6).unwrap();
        let beta = Marginal::beta(4.0, 2.5, 0.0, 1.0).unwrap().standardised(0.0, 1e-6).unwrap();
        let texture = Texture::Translated {
            covariance: SurfaceCovariance::Model(covariance),
            translation: TranslationKind::Plain,
            expansion: None,
        };
        let model = SurfaceModel { marginal: beta.clone(), texture };
        let kinds = vec![Kind::RmsHeight, Kind::CorrelationLength, Kind::Skewness];
        let surface = UncertainSurface { model: &model, length_x_m: Some(20e-6), kinds, parameters: Vec::new() };
        for skewness in [beta.skewness(), 0.0, 0.9, -1.5] {
            let found = surface.at(&[1.1e-6, 30e-6, skewness]).unwrap();
            assert!((found.marginal.std() / 1.1e-6 - 1.0).abs() < 1e-9);
            assert!((found.marginal.skewness() - skewness).abs() < 1e-6);
            let above = |law: &Marginal| law.excess_kurtosis() + 2.0 - law.skewness().powi(2);
            assert!((above(&found.marginal) - above(&beta)).abs() < 1e-6);
            let covariance = found.covariance().unwrap();
            assert!((covariance.correlation(30e-6, 0.0) - (-1.0_f64).exp()).abs() < 1e-12);
            assert!((covariance.correlation(0.0, 15e-6) - (-1.0_f64).exp()).abs() < 1e-12);
        }
        // Without skewness the law keeps its shape.
        let surface = UncertainSurface { kinds: vec![Kind::RmsHeight], ..surface };
        let found = surface.at(&[2e-6]).unwrap().marginal;
        assert!((found.quantile(0.9) / (2.0 * beta.quantile(0.9)) - 1.0).abs() < 1e-12);
    }
}
