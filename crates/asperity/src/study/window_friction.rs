//! Friction of a window as the study states, reads or computes it.

use std::path::Path;

use crate::friction::process::FittedProcess;
use crate::friction::{NominalContact, StatedFriction, WindowFriction};
use crate::study::StudyError;
use crate::study::config::{FrictionSection, VibrationSection};
use crate::study::friction_stage::SolvedStrips;
use crate::study::plausibility::implausible_friction;

/// Returns the friction at the operating level.
pub(super) fn computed_friction(
    section: &VibrationSection,
    strips: &SolvedStrips,
) -> Result<WindowFriction, StudyError> {
    let stribeck = section.dimensionless_stribeck()?;
    Ok(WindowFriction::from_level(strips.operating(), &strips.window, nominal(section), stribeck))
}

/// Returns the friction that the section states, for a window of the default size.
pub(super) fn stated_friction(section: &VibrationSection) -> Result<WindowFriction, StudyError> {
    let usual = FrictionSection::default();
    let absent = || StudyError::NoStage("friction");
    let stated = StatedFriction {
        mean: section.static_friction.ok_or_else(absent)?,
        std: section.friction_std.ok_or_else(absent)?,
        length_m: section.friction_correlation_length.ok_or_else(absent)?.0,
        marginal: section.friction_marginal.as_deref().ok_or_else(absent)?.parse()?,
        window_m: [usual.window.0, usual.strip[1].0],
    };
    Ok(WindowFriction::from_statement(stated, section.nominal_area.0, section.dimensionless_stribeck()?))
}

/// Returns the friction of the fitted process that the section reads.
pub(super) fn fitted_friction(
    section: &VibrationSection,
    process: &FittedProcess,
) -> Result<WindowFriction, StudyError> {
    let velocity_m_per_s = section.scales()?.velocity_m_per_s();
    let file = section.friction_process.as_deref().unwrap_or(Path::new("")).display().to_string();
    let stribeck = section.dimensionless_stribeck()?;
    let mut found = WindowFriction::from_process(process, &file, nominal(section), stribeck, velocity_m_per_s);
    found.warnings.extend(implausible_friction(process.mean).map(|warning| format!("{file}: {warning}")));
    Ok(found)
}

fn nominal(section: &VibrationSection) -> NominalContact {
    let area_m2 = section.nominal_area.0;
    NominalContact { area_m2, pressure_pa: section.normal_force.0 / area_m2 }
}
