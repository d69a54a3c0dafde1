//! Loss of stability of a machine's steady sliding, and its margin of friction.

use super::{Critical, Instability, Model, critical_friction};
use crate::VibrationError;

/// Friction coefficient up to which the loss of stability is searched for; a machine that is stable there counts as critical at it.
const LARGEST_FRICTION: f64 = 1e3;
/// End of a scan relative to the largest friction coefficient of interest.
const SCAN_MARGIN: f64 = 1.25;
/// Default number of friction coefficients of a scan of the modes.
pub const SCAN_POINTS: usize = 401;

/// Returns the least friction coefficient at which steady sliding is unstable; `None` if it is stable up to 1,000.
pub fn onset(model: &Model) -> Result<Option<Critical>, VibrationError> {
    critical_friction(model, LARGEST_FRICTION)
}

/// Returns the margin μ_c − μ of the friction coefficient, at most 1,000 − μ.
pub fn friction_margin(model: &Model) -> Result<f64, VibrationError> {
    Ok(onset(model)?.map_or(LARGEST_FRICTION, |critical| critical.friction) - model.sliding_friction())
}

/// Returns the kind of instability of steady sliding at the machine's own friction coefficient; `None` if it is stable.
pub fn instability(model: &Model) -> Result<Option<Instability>, VibrationError> {
    let critical = onset(model)?.filter(|critical| critical.friction < model.sliding_friction());
    Ok(critical.map(|critical| critical.instability))
}

/// Returns the end of a scan of the modes that contains the machine's own friction coefficient and one `of_interest`.
pub fn scan_end(model: &Model, of_interest: Option<f64>) -> f64 {
    let own = model.sliding_friction();
    SCAN_MARGIN * of_interest.map_or(own, |friction| friction.max(own))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VelocityLaw;
    use crate::law::Coulomb;
    use crate::mode_coupling::CoupledParameters;

    #[test]
    fn the_margin_changes_its_sign_where_the_modes_of_the_undamped_machine_meet() {
        for (friction, wanted) in [(0.5, None), (1.0, Some(Instability::Flutter))] {
            let law = VelocityLaw::Coulomb(Coulomb { kinetic: friction });
            let parameters = CoupledParameters { static_friction: friction, law, ..CoupledParameters::default() };
            let model = Model::new(parameters).unwrap();
            let coalescence = model.coalescence().unwrap();
            assert!((friction_margin(&model).unwrap() - (coalescence - friction)).abs() < 1e-12);
            assert_eq!(instability(&model).unwrap(), wanted);
            assert_eq!(scan_end(&model, Some(coalescence)), 1.25 * coalescence.max(friction));
        }
    }
}
