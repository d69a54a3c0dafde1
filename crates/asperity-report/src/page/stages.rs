//! Sections of the stages of a study.

use super::section::Section;
use super::{answers, appendix, friction, mode_coupling, tables, verdict, vibration};
use crate::{ReportError, Run, figures};

/// Returns what the verdict follows from.
pub(super) fn judged(run: &Run) -> Result<Option<Section>, ReportError> {
    let found = run.results.verdict.as_ref();
    let section = Section::new(
        "verdict",
        "Behind the verdict",
        verdict::lead(found.map(|verdict| verdict.model).unwrap_or_default()),
        found.map_or_else(Vec::new, verdict::tables),
        figures::verdict::figures(run)?,
    )
    .map(|section| section.with_answer(found.map(crate::verdict_sentence)));
    Ok(section)
}

/// Returns the surface; `heights` is its section of the appendix.
pub(super) fn surface(run: &Run, heights: Option<&Section>) -> Result<Option<Section>, ReportError> {
    let section = Section::new(
        "surface",
        "Surface",
        "Height statistics of the measured map, and the random surface fitted to it. Every statistic belongs to the bandwidth \
         between field size and pixel size.",
        tables::surface(run),
        figures::surface::figures(run)?,
    )
    .map(|section| section.with_further(heights).with_answer(answers::of_surface(run)));
    Ok(section)
}

/// Returns the distribution of the pressure; `methods` is its section of the appendix.
pub(super) fn contact(run: &Run, methods: Option<&Section>) -> Result<Option<Section>, ReportError> {
    let pressure = run.results.pressure.as_ref();
    let section = Section::new(
        "pressure",
        "Contact pressure",
        format!(
            "Probability that a point of the surface is in contact, and distribution of the pressure there. {}",
            pressure.map_or_else(String::new, tables::refused_methods)
        ),
        pressure.map(tables::scalars).into_iter().collect(),
        appendix::without_moved(figures::pressure::figures(run)?),
    )
    .map(|section| section.with_further(methods).with_answer(pressure.map(answers::of_pressure)));
    Ok(section)
}

/// Returns the friction coefficient; `models` is its section of the appendix.
pub(super) fn coefficient(run: &Run, models: Option<&Section>) -> Option<Section> {
    let friction = run.results.friction.as_ref();
    Section::new(
        "friction",
        "Friction coefficient",
        friction::lead(friction),
        friction.map_or_else(Vec::new, friction::tables),
        appendix::without_moved(figures::friction::figures(run)),
    )
    .map(|section| section.with_further(models).with_answer(friction.map(answers::of_friction)))
}

/// Returns the quotient F/N of single windows.
pub(super) fn quotient(run: &Run) -> Result<Option<Section>, ReportError> {
    let friction = run.results.friction.as_ref();
    let section = Section::new(
        "quotient",
        "Quotient F/N of single windows",
        friction::quotient_lead(friction),
        friction.map_or_else(Vec::new, friction::quotient_tables),
        figures::friction::quotient_figures(run)?,
    )
    .map(|section| section.with_answer(friction.and_then(answers::of_quotient)));
    Ok(section)
}

/// Returns the motion of one degree of freedom.
pub(super) fn motion(run: &Run) -> Result<Option<Section>, ReportError> {
    let vibration = run.results.vibration.as_ref();
    let section = Section::new(
        "vibration",
        "Friction-induced vibration",
        "The vibration of the machine without roughness, and the effect of the roughness on it. Displacement, time and \
         velocity are dimensionless: X = xc/N, τ = ω₀t and dX/dτ.",
        vibration.map_or_else(Vec::new, vibration::tables),
        figures::vibration::figures(run)?,
    )
    .map(|section| section.with_answer(vibration.map(answers::of_vibration)));
    Ok(section)
}

/// Returns the motion of two coupled modes.
pub(super) fn coupled(run: &Run) -> Option<Section> {
    let found = run.results.mode_coupling.as_ref();
    Section::new(
        "mode-coupling",
        "Mode coupling",
        "Stability of steady sliding of a mass with two modes that friction couples, and the vibration that follows.",
        found.map_or_else(Vec::new, mode_coupling::tables),
        figures::vibration::coupled_figures(run),
    )
    .map(|section| section.with_answer(found.map(answers::of_mode_coupling)))
}
