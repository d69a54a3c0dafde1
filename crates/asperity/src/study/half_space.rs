//! Half-space of a section of a study.

use crate::contact::{Boundary, HalfSpace};
use crate::map::{BoundaryKind, Grid};
use crate::study::StudyError;

/// Returns the half-space of a section, and its mean compliance if it is periodic.
pub(super) fn half_space(
    section: &'static str,
    grid: Grid,
    modulus_pa: f64,
    boundary: BoundaryKind,
    mean_compliance_m_per_pa: Option<f64>,
) -> Result<(HalfSpace, Option<f64>), StudyError> {
    let (boundary, compliance) = match boundary {
        BoundaryKind::Free => (Boundary::Free, None),
        BoundaryKind::Periodic => {
            let usual = HalfSpace::default_mean_compliance_m_per_pa(grid, modulus_pa);
            let mean_compliance_m_per_pa = mean_compliance_m_per_pa.unwrap_or(usual);
            (Boundary::Periodic { mean_compliance_m_per_pa }, Some(mean_compliance_m_per_pa))
        }
    };
    let half_space =
        HalfSpace::new(grid, modulus_pa, boundary).map_err(|error| StudyError::Contact { section, error })?;
    Ok((half_space, compliance))
}
