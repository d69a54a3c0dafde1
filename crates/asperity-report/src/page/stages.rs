//! The links of the chain: for each a section with its answer and one or two figures, and an entry of the details with the rest.

use super::section::Section;
use super::{answers, friction, mode_coupling, parameters, tables, verdict, vibration};
use crate::{ReportError, Run, figures};

/// Section of a link and its entry among the details.
pub(super) type Link = [Option<Section>; 2];

/// Returns what the verdict follows from: its map, and among the details how much each value decides.
pub(super) fn judged(run: &Run) -> Result<Link, ReportError> {
    let Some(found) = &run.results.verdict else { return Ok([None, None]) };
    let figures = figures::verdict::figures(run)?;
    let section = Section::new("verdict", "Map of the verdict", "", verdict::tables(found), figures);
    let entry = ("details-verdict", "Verdict: sensitivities and inputs", verdict::lead(found.model));
    Ok(Section::folded(section, &["verdict_map"], entry))
}

/// Returns the surface.
pub(super) fn surface(run: &Run) -> Result<Link, ReportError> {
    let tables = tables::surface(run).into_iter().chain(parameters::distributions(run));
    let section = Section::new("surface", "Surface", "", tables.collect(), figures::surface::figures(run)?)
        .map(|section| section.with_answer(answers::of_surface(run)));
    let lead = "Every statistic belongs to the bandwidth between field size and pixel size.";
    let entry = ("details-surface", "Surface: parameters, spectrum and random surface", lead);
    Ok(Section::folded(section, &["height_levelled", "surface_sample", "height_psd"], entry))
}

/// Returns the distribution of the pressure.
pub(super) fn contact(run: &Run) -> Result<Link, ReportError> {
    let pressure = run.results.pressure.as_ref();
    let tables = pressure.into_iter().flat_map(|pressure| [tables::scalars(pressure), tables::methods(pressure)]);
    let section = Section::new("pressure", "Contact", "", tables.collect(), figures::pressure::figures(run)?)
        .map(|section| section.with_answer(pressure.map(|pressure| answers::of_pressure(run, pressure))));
    let lead = pressure.map_or_else(String::new, tables::refused_methods);
    let entry = ("details-pressure", "Contact: distributions and methods", &*lead);
    Ok(Section::folded(section, &["pressure_sample", "pressure_cdf"], entry))
}

/// Returns the friction coefficient.
pub(super) fn coefficient(run: &Run) -> Result<Link, ReportError> {
    let friction = run.results.friction.as_ref();
    let tables = friction.map_or_else(Vec::new, friction::tables);
    let section =
        Section::new("friction", "Friction", friction::lead(friction), tables, figures::friction::figures(run)?)
            .map(|section| section.with_answer(friction.map(answers::of_friction)));
    let lead = "F/N, friction force over load of every single window, is the paper’s definition. It differs from the friction at the mean load \
                if windows carry few contacts; the vibration has the latter.";
    let entry = ("details-friction", "Friction: levels, correlation and fitted distributions", lead);
    Ok(Section::folded(section, &["friction_trace", "friction_histogram"], entry))
}

/// Returns the motion of one degree of freedom.
pub(super) fn motion(run: &Run) -> Result<Link, ReportError> {
    let vibration = run.results.vibration.as_ref();
    let tables = vibration.map_or_else(Vec::new, vibration::tables);
    let section = Section::new("vibration", "Vibration", "", tables, figures::vibration::figures(run)?)
        .map(|section| section.with_answer(vibration.map(|vibration| answers::of_vibration(run, vibration))));
    let lead = "Displacement, time and velocity are dimensionless: X = xc/N, τ = ω₀t and dX/dτ.";
    let entry = ("details-vibration", "Vibration: cycles over the damping ratio", lead);
    Ok(Section::folded(section, &["stability_map", "limit_cycle", "sustained_over_damping"], entry))
}

/// Returns the motion of two coupled modes.
pub(super) fn coupled(run: &Run) -> Link {
    let found = run.results.mode_coupling.as_ref();
    let tables = found.map_or_else(Vec::new, mode_coupling::tables);
    let section = Section::new("mode-coupling", "Mode coupling", "", tables, figures::vibration::coupled_figures(run))
        .map(|section| section.with_answer(found.map(|found| answers::of_mode_coupling(run, found))));
    Section::folded(section, &["modes"], ("details-mode-coupling", "Mode coupling: numbers", ""))
}
