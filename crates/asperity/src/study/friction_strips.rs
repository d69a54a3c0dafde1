//! Contact problems of the strips of a study.

use std::sync::Arc;

use crate::contact::Solver;
use crate::friction::LevelControl;
use crate::friction::replicates::MomentReplicates;
use crate::friction::strip::{StripProblem, Strips};
use crate::monitor::Monitor;
use crate::study::StudyError;
use crate::study::check::FrictionStudy;
use crate::study::half_space::half_space;
use crate::surface::model::{CompositeModel, XiOrder};

/// Returns the contact problem of the strips with its mean compliance, in m/Pa.
pub(super) fn strip_problem(study: &FrictionStudy) -> Result<(StripProblem, Option<f64>), StudyError> {
    let ((grid, window), material) = (study.strip()?, &study.material);
    let compliance = study.mean_compliance.map(|c| c.0);
    let (half_space, mean_compliance_m_per_pa) =
        half_space("friction", grid, material.contact_modulus_pa, study.boundary, compliance)?;
    let solver = Solver { tolerance: study.tolerance, ..Solver::default() };
    let law = Arc::clone(&study.law);
    let problem = StripProblem {
        half_space,
        window,
        law,
        hardness_pa: material.hardness_pa,
        solver,
        valid_share: study.valid_fraction,
    };
    Ok((problem, mean_compliance_m_per_pa))
}

/// Solves a few strips at one level and returns the moments of friction at the mean load, `with_stiffness` or without that of the contact;
/// `None` if they have no solution. All surfaces are drawn from the same random numbers.
pub(super) fn solve_level(
    study: &FrictionStudy,
    model: &CompositeModel,
    level: LevelControl,
    (realisations, pitch_factor): (usize, f64),
    with_stiffness: bool,
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Option<MomentReplicates>, StudyError> {
    let (problem, _) = strip_problem(study)?;
    let generated = model.strip(problem.grid(), problem.is_periodic(), XiOrder::Wavevector)?;
    let strips = problem.strips(generated.surface.as_ref(), realisations, seed);
    let strips = Strips { stiff_level: with_stiffness.then_some(0), pitch_factor, ..strips };
    let solved = strips.solve(&[level.contact(|probability| model.height_quantile_m(probability))], monitor)?;
    let step_m = problem.window.step_m();
    Ok(solved.into_iter().flatten().next().map(|level| MomentReplicates::from_mean_load(&level, step_m)))
}
