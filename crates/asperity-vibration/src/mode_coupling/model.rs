//! Model with two degrees of freedom and its state of steady sliding.

use crate::law::Coulomb;
use serde::{Deserialize, Serialize};

use super::super::{VelocityLaw, VibrationError, non_negative, positive};

/// Largest stiffness, velocity, friction coefficient and damping; results for larger values would be meaningless.
const MOST: f64 = 1e6;
/// Value of (ω₂² − ω₁²)/ω₂² below which the modes count as equal.
const DISTINCT: f64 = 1e-9;

/// Damping of the motion by a force −C·(x′, y′), which also acts in flight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Damping {
    /// Modal damping ratios ζ₁, ζ₂ of the modes without friction, the slow one first. C has their mode shapes and the
    /// eigenvalues 2ζᵢωᵢ.
    Modal {
        /// ζ₁ and ζ₂.
        ratios: [f64; 2],
    },
    /// C = a·1 + b·K, with the stiffness K of the mass in contact without friction.
    Proportional {
        /// a.
        mass: f64,
        /// b.
        stiffness: f64,
    },
    /// One damper along the belt and one across it.
    Axes {
        /// Along x.
        tangential: f64,
        /// Along y.
        normal: f64,
    },
}

/// Parameters of a [`Model`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CoupledParameters {
    /// α₁ and α₂: directions of the inclined springs in degrees, from the belt's velocity towards the belt.
    pub angles_deg: [f64; 2],
    /// k₁ and k₂ ≥ 0.
    pub springs: [f64; 2],
    /// k₃ > 0.
    pub contact_stiffness: f64,
    /// Damping.
    pub damping: Damping,
    /// μ_s, the stick limit.
    pub static_friction: f64,
    /// Kinetic friction law μ(|v|).
    pub law: VelocityLaw,
    /// V > 0.
    pub belt_velocity: f64,
}

impl Default for CoupledParameters {
    /// Returns the published example: springs at 150° and 30° with k₁, k₂ = ⅔(2 ∓ √3) and k₃ = 4/3, without damping. K
    /// = \[2, 1 − Δ; 1, 2\] with Δ = 4μ/3 and ω² = 2 ± √(1 − Δ), so the modes meet at μ = ¾. Coulomb friction μ = 0.8,
    /// V = 0.5.
    fn default() -> Self {
        let root = 3.0_f64.sqrt();
        Self {
            angles_deg: [150.0, 30.0],
            springs: [2.0 / 3.0 * (2.0 - root), 2.0 / 3.0 * (2.0 + root)],
            contact_stiffness: 4.0 / 3.0,
            damping: Damping::Axes { tangential: 0.0, normal: 0.0 },
            static_friction: 0.8,
            law: VelocityLaw::Coulomb(Coulomb { kinetic: 0.8 }),
            belt_velocity: 0.5,
        }
    }
}

/// State in which the mass rests in space and the belt slides under it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SteadySliding {
    /// x.
    pub tangential: f64,
    /// y.
    pub normal: f64,
    /// n = 1 + k₃y > 0.
    pub normal_force: f64,
}

/// Mass on two inclined springs, pressed on a moving belt through a contact spring, with checked dimensionless
/// parameters.
///
/// The coordinate x is along the belt velocity and y into the belt, both zero where the static normal force 1 acts
/// alone. With the contact force n = max(0, 1 + k₃y),
///
/// - x″ = −k₁₁x − k₁₂y − (C·(x′, y′))ₓ + sign(V − x′)·\[μ(|V − x′|) + m(s)\]·n,
/// - y″ = −k₁₂x − k_yy·y − (C·(x′, y′))_y + 1 − n,
/// - k₁₁ = Σkᵢcos²αᵢ, k₁₂ = Σkᵢ sin αᵢ cos αᵢ, k_yy = Σkᵢ sin²αᵢ; in contact k₂₂ = k_yy + k₃;
/// - stick, x′ = V, while the required friction force is at most (μ_s + m)·n.
///
/// The sliding distance s = ∫|V − x′|dτ is constant in stick and in flight.
///
/// # References
/// Hoffmann, Fischer, Allgaier & Gaul, *Mechanics Research Communications* **29** (2002) 197,
/// <https://doi.org/10.1016/S0093-6413(02)00254-9>; stick, flight and fluctuation are added here.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    parameters: CoupledParameters,
    /// k₁₁, k₁₂, k₂₂ in contact.
    pub(super) stiffness: [f64; 3],
    /// c₁₁, c₁₂, c₂₂.
    pub(super) damping: [f64; 3],
}

impl Model {
    /// Checks the parameters. Angles, stiffnesses, damping and friction must be finite and at most 10⁶, 0 < V ≤ 10⁶,
    /// μ_k ≤ μ_s, and the springs must hold the mass (k₁₁k₂₂ > k₁₂²). Modal damping of two equal modes must have equal
    /// ratios.
    pub fn new(parameters: CoupledParameters) -> Result<Self, VibrationError> {
        let CoupledParameters { angles_deg, springs, contact_stiffness, static_friction, belt_velocity, .. } =
            parameters;
        let law = &parameters.law;
        let bounded = |parameter, value: f64| {
            if value.abs() <= MOST {
                Ok(())
            } else {
                Err(VibrationError::Parameter { parameter, value, wanted: "at most 1e6 in absolute value" })
            }
        };
        angles_deg.iter().try_for_each(|&angle| bounded("angle of a spring", angle))?;
        for spring in springs {
            non_negative("stiffness of a spring", spring)?;
            bounded("stiffness of a spring", spring)?;
        }
        for (name, value) in [
            ("contact_stiffness", contact_stiffness),
            ("static_friction", static_friction),
            ("belt_velocity", belt_velocity),
        ] {
            positive(name, value)?;
            bounded(name, value)?;
        }
        law.validate()?;
        if law.table().is_some() {
            let reason = "mode coupling does not support friction tables; use a law with a formula";
            return Err(VibrationError::NotFound { what: "series of the friction law", reason });
        }
        bounded("velocity weakening of the friction law", law.steepest())?;
        if law.kinetic() > static_friction {
            let value = law.kinetic();
            let wanted = "at most the static friction";
            return Err(VibrationError::Parameter { parameter: "kinetic_friction", value, wanted });
        }
        let mut stiffness = [0.0, 0.0, contact_stiffness];
        for (angle, k) in angles_deg.iter().zip(springs) {
            let (sin, cos) = angle.to_radians().sin_cos();
            stiffness[0] += k * cos * cos;
            stiffness[1] += k * sin * cos;
            stiffness[2] += k * sin * sin;
        }
        let [k11, k12, k22] = stiffness;
        let determinant = k11 * k22 - k12 * k12;
        if determinant.is_nan() || determinant <= 1e-12 * k11 * k22 || k11 <= 1e-12 * k22 {
            let wanted = "positive: the springs do not hold the mass";
            return Err(VibrationError::Parameter { parameter: "k11·k22 - k12²", value: determinant, wanted });
        }
        let damping = damping_matrix(parameters.damping, stiffness)?;
        damping.iter().try_for_each(|&c| bounded("damping", c))?;
        Ok(Self { parameters, stiffness, damping })
    }

    /// Returns the parameters of the model.
    pub fn parameters(&self) -> &CoupledParameters {
        &self.parameters
    }

    /// Returns the stiffness (k₁₁, k₁₂, k₂₂) of the mass in contact, without friction.
    pub fn stiffness(&self) -> [f64; 3] {
        self.stiffness
    }

    /// Returns the damping (c₁₁, c₁₂, c₂₂).
    pub fn damping(&self) -> [f64; 3] {
        self.damping
    }

    /// Returns the belt velocity V.
    pub fn belt_velocity(&self) -> f64 {
        self.parameters.belt_velocity
    }

    /// Returns μ(V), the coefficient of steady sliding.
    pub fn sliding_friction(&self) -> f64 {
        self.parameters.law.coefficient(self.parameters.belt_velocity)
    }

    /// Returns steady sliding at the coefficient μ, with the normal force det K(0)/det K(μ). Returns none if the
    /// stiffness with friction K(μ) has no positive determinant; the springs then do not hold the mass.
    pub fn steady(&self, friction: f64) -> Option<SteadySliding> {
        let [k11, k12, k22] = self.stiffness;
        let determinant = k11 * k22 - k12 * (k12 - friction * self.parameters.contact_stiffness);
        let (tangential, normal) = (k22 * friction / determinant, -k12 * friction / determinant);
        let normal_force = 1.0 + self.parameters.contact_stiffness * normal;
        (determinant > 0.0).then_some(SteadySliding { tangential, normal, normal_force })
    }
}

/// Returns C for a given K; both are symmetric, stored as (11, 12, 22).
fn damping_matrix(damping: Damping, stiffness: [f64; 3]) -> Result<[f64; 3], VibrationError> {
    let (mass, fraction) = match damping {
        Damping::Axes { tangential, normal } => {
            non_negative("tangential damping", tangential)?;
            non_negative("normal damping", normal)?;
            return Ok([tangential, 0.0, normal]);
        }
        Damping::Proportional { mass, stiffness } => (mass, stiffness),
        Damping::Modal { ratios } => {
            let [k11, k12, k22] = stiffness;
            let (mean, radius) = (0.5 * (k11 + k22), (0.5 * (k11 - k22)).hypot(k12));
            let fast = mean + radius;
            let slow = (k11 * k22 - k12 * k12) / fast;
            // Every function of a symmetric 2 × 2 matrix has the form a·1 + b·K.
            let wanted = [2.0 * ratios[0] * slow.sqrt(), 2.0 * ratios[1] * fast.sqrt()];
            ratios.iter().try_for_each(|&ratio| non_negative("damping ratio", ratio))?;
            if 2.0 * radius <= DISTINCT * fast {
                if ratios[0] != ratios[1] {
                    let wanted = "equal to the first one, because the modes have the same frequency";
                    return Err(VibrationError::Parameter { parameter: "damping ratio", value: ratios[1], wanted });
                }
                (wanted[0], 0.0)
            } else {
                let fraction = (wanted[1] - wanted[0]) / (fast - slow);
                return Ok(combination(wanted[0] - fraction * slow, fraction, stiffness));
            }
        }
    };
    non_negative("damping proportional to the mass", mass)?;
    non_negative("damping proportional to the stiffness", fraction)?;
    Ok(combination(mass, fraction, stiffness))
}

/// Returns a·1 + b·K.
fn combination(a: f64, b: f64, [k11, k12, k22]: [f64; 3]) -> [f64; 3] {
    [a + b * k11, b * k12, a + b * k22]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_has_the_stiffness_of_the_example() {
        let model = Model::new(CoupledParameters::default()).unwrap();
        for (found, wanted) in model.stiffness().iter().zip([2.0, 1.0, 2.0]) {
            assert!((found - wanted).abs() < 1e-15);
        }
    }

    #[test]
    fn forces_balance_in_steady_sliding() {
        let model = Model::new(CoupledParameters { springs: [0.3, 1.7], ..CoupledParameters::default() }).unwrap();
        let [k11, k12, k22] = model.stiffness();
        for friction in [0.1, 0.5, 1.5] {
            let SteadySliding { tangential: x, normal: y, normal_force: n } = model.steady(friction).unwrap();
            assert!((k11 * x + k12 * y - friction * n).abs() < 1e-15);
            assert!((k12 * x + k22 * y).abs() < 1e-15);
            assert_eq!(n, 1.0 + model.parameters().contact_stiffness * y);
            let ratio = (k11 * k22 - k12 * k12) / (k11 * k22 - k12 * (k12 - friction * 4.0 / 3.0));
            assert!((n - ratio).abs() < 1e-15);
        }
    }

    #[test]
    fn modal_damping_acts_on_its_modes() {
        let damping = Damping::Modal { ratios: [0.02, 0.07] };
        let model = Model::new(CoupledParameters { damping, ..CoupledParameters::default() }).unwrap();
        let [c11, c12, c22] = model.damping();
        // Modes (1, ∓1) with ω² = 1 and 3.
        for (found, wanted) in [(c11 - c12, 0.04), (c22 - c12, 0.04), (c11 + c12, 0.14 * 3.0_f64.sqrt())] {
            assert!((found - wanted).abs() < 1e-15);
        }
    }

    #[test]
    fn invalid_parameters_are_refused() {
        let fine = CoupledParameters::default();
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.9 });
        for parameters in [
            CoupledParameters { angles_deg: [f64::NAN, 30.0], ..fine.clone() },
            CoupledParameters { springs: [-1.0, 1.0], ..fine.clone() },
            CoupledParameters { springs: [0.0, 0.0], ..fine.clone() },
            CoupledParameters { angles_deg: [30.0, 30.0], contact_stiffness: 1e-15, ..fine.clone() },
            CoupledParameters { contact_stiffness: 0.0, ..fine.clone() },
            CoupledParameters { belt_velocity: 1e9, ..fine.clone() },
            CoupledParameters { law, ..fine.clone() },
            CoupledParameters { damping: Damping::Modal { ratios: [0.1, -0.1] }, ..fine.clone() },
            CoupledParameters { damping: Damping::Axes { tangential: 0.0, normal: f64::INFINITY }, ..fine.clone() },
            CoupledParameters { damping: Damping::Proportional { mass: -1.0, stiffness: 0.0 }, ..fine.clone() },
        ] {
            assert!(Model::new(parameters.clone()).is_err(), "{parameters:?}");
        }
        assert!(serde_json::from_str::<CoupledParameters>(r#"{"spring": [1.0, 1.0]}"#).is_err());
        assert_eq!(serde_json::from_str::<CoupledParameters>("{}").unwrap(), fine);
    }
}
