//! Damping that keeps steady sliding stable.

use super::Model;

impl Model {
    /// Returns the damping ratio ζ of equal dampers 2ζ along and across the belt at which steady sliding with the coefficient μ
    /// becomes stable, in closed form. Returns zero if it is stable or neutral without damping, and none if it diverges, which no
    /// damper prevents.
    ///
    /// With C = a·1 the eigenvalues λ of the motion and Λ of the stiffness K(μ) obey λ² + aλ + Λ = 0. A vibration λ = iω neither
    /// grows nor decays if Re Λ = ω² and |Im Λ| = aω, so a = |Im Λ|/√Re Λ. The dampers and the friction law of the model are not
    /// used.
    pub fn limit_damping_ratio(&self, friction: f64) -> Option<f64> {
        let [k11, k12, k22] = self.stiffness;
        let half_trace = 0.5 * (k11 + k22);
        let determinant = k11 * k22 - k12 * (k12 - friction * self.parameters().contact_stiffness);
        let imaginary_squared = determinant - half_trace * half_trace;
        if imaginary_squared > 0.0 {
            return Some(0.5 * (imaginary_squared / half_trace).sqrt());
        }
        (determinant > 0.0).then_some(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CoupledParameters, Damping, critical_friction};
    use super::*;

    #[test]
    fn the_limit_damping_is_that_at_which_the_friction_is_critical() {
        let usual = CoupledParameters::default();
        for springs in [usual.springs, [0.3, 1.7]] {
            for ratio in [0.01, 0.05, 0.2] {
                let damping = Damping::Axes { tangential: 2.0 * ratio, normal: 2.0 * ratio };
                let model = Model::new(CoupledParameters { springs, damping, ..usual.clone() }).unwrap();
                let friction = critical_friction(&model, 100.0).unwrap().unwrap().friction;
                assert!((model.limit_damping_ratio(friction).unwrap() / ratio - 1.0).abs() < 1e-10, "{springs:?}");
            }
        }
    }

    #[test]
    fn no_damping_is_needed_below_the_coalescence_and_none_prevents_divergence() {
        let usual = CoupledParameters::default();
        let model = Model::new(usual.clone()).unwrap();
        // μ_c = ¾(1 + 8ζ²).
        assert_eq!(model.limit_damping_ratio(0.7499), Some(0.0));
        assert!((model.limit_damping_ratio(0.81).unwrap() - 0.1).abs() < 1e-12);
        let [soft, stiff] = usual.springs;
        let opposite = Model::new(CoupledParameters { springs: [stiff, soft], ..usual }).unwrap();
        assert_eq!(opposite.limit_damping_ratio(2.2), Some(0.0));
        assert_eq!(opposite.limit_damping_ratio(2.3), None);
    }
}
