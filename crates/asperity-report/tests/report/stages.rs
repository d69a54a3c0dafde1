//! Access to the results of the stages.

use asperity_report::Run;
use asperity_results::{FrictionResult, PressureResult, SurfaceResult};

/// Returns the results of the surface stage.
pub(crate) fn surface(run: &mut Run) -> &mut SurfaceResult {
    run.results.surface.as_mut().unwrap()
}

/// Returns the results of the pressure stage.
pub(crate) fn pressure(run: &mut Run) -> &mut PressureResult {
    run.results.pressure.as_mut().unwrap()
}

/// Returns the results of the friction stage.
pub(crate) fn friction(run: &mut Run) -> &mut FrictionResult {
    run.results.friction.as_mut().unwrap()
}
