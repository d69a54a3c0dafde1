//! Checks of `[counterface]`, and which bodies of the contact are rough.

use super::friction::FrictionStudy;
use super::invalid_value::{InvalidValue, invalid};
use super::surface::SurfaceStudy;
use super::vibration_study::{FrictionSource, VibrationStudy};
use crate::friction::RoughBody;
use crate::map::BoundaryKind;
use crate::study::file::{CounterfaceSection, FrictionSection, StudyFile};

const SECTION: &str = "counterface";

impl StudyFile {
    /// Checks the section; returns the roughness of the counterface, `None` if it is smooth.
    pub(super) fn check_counterface(&self) -> Result<Option<SurfaceStudy>, InvalidValue> {
        let Some(counterface) = &self.counterface else { return Ok(None) };
        if counterface.poisson_ratio.is_some() && counterface.youngs_modulus.is_none() {
            return Err(invalid(SECTION, "poisson_ratio", "a rigid counterface has none; state youngs_modulus"));
        }
        let Some(surface) = &self.surface else {
            let message = "the counterface is pressed against a surface; add a [surface] section";
            return Err(invalid(SECTION, "file", message));
        };
        if counterface.roughness_key().is_none() {
            return Ok(None);
        }
        let section = counterface.roughness(surface);
        if surface.rescale.is_some() && section.marginal != "normal" {
            let message = "`rescale` in [surface] requires marginal = \"normal\" of both bodies";
            return Err(invalid(SECTION, "marginal", message));
        }
        let own = |error| InvalidValue { section: SECTION, ..error };
        Self { surface: Some(section.clone()), ..self.clone() }.check_numbers().map_err(own)?;
        section.check().map(Some).map_err(own)
    }

    /// Returns which bodies are rough.
    ///
    /// # Errors
    /// The study states another body, or needs friction of two rough bodies that its strips do not determine.
    pub(super) fn check_body(
        &self,
        friction: Option<&FrictionStudy>,
        vibration: Option<&VibrationStudy>,
    ) -> Result<RoughBody, InvalidValue> {
        let stated = self.surface.as_ref().and_then(|surface| surface.body);
        if self.counterface.as_ref().and_then(CounterfaceSection::roughness_key).is_none() {
            return match stated {
                Some(RoughBody::Both) => {
                    let message = "found \"both\", but the counterface is smooth; state its roughness in [counterface]";
                    Err(invalid("surface", "body", message))
                }
                stated => Ok(stated.unwrap_or_default()),
            };
        }
        if let Some(body @ (RoughBody::Track | RoughBody::Slider)) = stated {
            let message = format!("found \"{body}\", but [counterface] is rough too; state \"both\" or remove the key");
            return Err(invalid("surface", "body", message));
        }
        let ploughs = friction.is_some_and(|friction| friction.law.ploughs());
        if let Some(FrictionSection { law, .. }) = self.friction.as_ref().filter(|_| ploughs) {
            let message =
                format!("law = \"{law}\" requires a smooth counterface: the slopes of the harder body alone plough");
            return Err(invalid("friction", "law", message));
        }
        let computed =
            vibration.is_some_and(|vibration| matches!(vibration.machine.friction, FrictionSource::Computed(_)));
        if computed && friction.is_some_and(|friction| friction.boundary == BoundaryKind::Free) {
            let message = "found \"free\", but [vibration] with two rough bodies requires strips along which the track can move: \
                           state boundary = \"periodic\"";
            return Err(invalid("friction", "boundary", message));
        }
        Ok(RoughBody::Both)
    }
}
