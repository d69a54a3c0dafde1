//! The counterface of a study: its random surface, and its part in the contact.

use std::fmt::Display;
use std::path::Path;

use crate::contact::contact_modulus_pa;
use crate::study::check::SurfaceStudy;
use crate::study::file::StudyFile;
use crate::study::result::SurfaceResult;
use crate::study::surface_stage::{self, SurfaceStage};
use crate::study::{StudyError, sentence};

/// Checks that the scans can be filtered and returns warnings about them.
pub(super) fn check_scans(study: &SurfaceStudy, folder: &Path) -> Result<Vec<String>, StudyError> {
    let warnings = surface_stage::check_scans(study, folder);
    Ok(warnings.map_err(StudyError::of_counterface)?.into_iter().map(named).collect())
}

/// Measures the scans, adds the random counterface to the model of `stage`, and returns its entry of `results.json`. Sentences
/// join those of `stage`; tables and fields show the surface alone.
pub(super) fn add_to(
    stage: &mut SurfaceStage,
    study: &SurfaceStudy,
    folder: &Path,
) -> Result<SurfaceResult, StudyError> {
    let own = surface_stage::without_tables(study, folder);
    let own = own.map_err(StudyError::of_counterface)?;
    let result = own.result(None);
    // Waves beyond the band of either scan are those of a model alone.
    stage.band_end_m = stage.band_end_m.into_iter().chain(own.band_end_m).reduce(f64::max);
    stage.model.counterface = Some(own.model.surface);
    stage.measured_counterface = own.measured;
    stage.output.assumptions.extend(own.output.assumptions.into_iter().map(|own| format!("Counterface: {own}")));
    stage.output.warnings.extend(own.output.warnings.into_iter().map(named));
    Ok(result)
}

/// Returns a warning of the surface stage as one about the counterface.
pub(super) fn named(warning: impl Display) -> String {
    format!("counterface: {warning}")
}

/// Returns a sentence on the contact with the counterface; `None` without the section `[counterface]`, or without `[material]`.
pub(super) fn contact_sentence(file: &StudyFile) -> Option<String> {
    let (counterface, material) = (file.counterface.as_ref()?, file.material.as_ref()?);
    let pascal = |pascal: f64| sentence::si(pascal, "Pa");
    let elastic = match counterface.elastic() {
        None => "rigid".to_owned(),
        Some(body) => format!(
            "elastic with E/(1 − ν²) = {} beside the {} of the surface; the compliances of both bodies add up to 1/E*",
            pascal(body.contact_modulus_pa()),
            pascal(contact_modulus_pa(material.youngs_modulus.0, material.poisson_ratio))
        ),
    };
    let rough = if counterface.roughness_key().is_some() {
        "The counterface is rough too: contact is that of the sum of both heights with a flat. Random maps of the two bodies are \
         independent; the map of the counterface is mirrored along x to face the surface. It is"
    } else {
        "The counterface is smooth and"
    };
    let hardness = counterface.hardness.zip(file.hardness()).map_or_else(String::new, |(own, lower)| {
        let softer = if own == lower { "the counterface" } else { "the surface" };
        format!(" The softer body, {softer}, bounds the pressure at {}.", pascal(lower.0))
    });
    Some(format!("{rough} {elastic}.{hardness}"))
}
