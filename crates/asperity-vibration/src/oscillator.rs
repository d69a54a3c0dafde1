//! Mass on the belt in dimensionless form, and its scales.

use crate::law::Stribeck;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{VelocityLaw, VibrationError, positive};

/// Default force at the start, in stick, as a fraction of the static friction force.
const DEFAULT_START_FRACTION: f64 = 0.97;

/// Closed range of a parameter, and its description. Machines lie well inside. Outside, rounding dominates the motion
/// in a slip phase in double precision, and results would be meaningless.
struct Range {
    least: f64,
    most: f64,
    wanted: &'static str,
}

const FRICTION: Range = Range { least: 1e-12, most: 1e3, wanted: "between 1e-12 and 1000" };
const WEAKENING: Range = Range { least: 0.0, most: 1e6, wanted: "between 0 and 1e6" };
const DAMPING: Range = Range { least: 0.0, most: 1e3, wanted: "between 0 and 1000" };
const BELT_VELOCITY: Range = Range { least: 1e-12, most: 1e6, wanted: "between 1e-12 and 1e6" };
const FORCING_AMPLITUDE: Range = Range { least: 0.0, most: 1e6, wanted: "between 0 and 1e6" };
const FORCING_FREQUENCY: Range = Range { least: 1e-6, most: 1e3, wanted: "between 1e-6 and 1000" };

impl Range {
    /// Fails if the value is outside the range or NaN.
    fn check(&self, parameter: &'static str, value: f64) -> Result<(), VibrationError> {
        if (self.least..=self.most).contains(&value) {
            Ok(())
        } else {
            Err(VibrationError::Parameter { parameter, value, wanted: self.wanted })
        }
    }
}

/// Harmonic force q cos ητ on the mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Forcing {
    /// q = Q/N.
    pub amplitude: f64,
    /// η = Ω/ω₀ > 0.
    pub frequency: f64,
}

/// Dimensionless parameters of an oscillator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// μ_st, the stick limit.
    pub static_friction: f64,
    /// Kinetic friction law μ(|v|).
    pub law: VelocityLaw,
    /// ζ = d/(2mω₀).
    pub damping_ratio: f64,
    /// V = v_b·mω₀/N.
    pub belt_velocity: f64,
    /// Harmonic force, if any.
    pub forcing: Option<Forcing>,
}

/// Mass, spring and damper on a moving belt with dry friction, with checked dimensionless parameters.
///
/// With the displacement X = x·c/N, the time τ = ω₀t and the friction fluctuation m(s),
///
/// - slip: X″ + 2ζX′ + X = q cos ητ + sign(V − X′)·\[μ(|V − X′|) + m\],
/// - stick, X′ = V, while |X + 2ζV − q cos ητ| ≤ μ_st + m.
///
/// # References
/// Gaus, Proppe & Zaccardi, *Meccanica dei Materiali e delle Strutture* VI (2016) 1, 115–122, §5.
#[derive(Debug, Clone, PartialEq)]
pub struct Oscillator {
    parameters: Parameters,
}

impl Oscillator {
    /// Checks the parameters: 10⁻¹² ≤ μ_k ≤ μ_st ≤ 10³, weakening rate 0 … 10⁶, ζ = 0 … 10³, V = 10⁻¹² … 10⁶, q = 0 …
    /// 10⁶, η = 10⁻⁶ … 10³.
    pub fn new(parameters: Parameters) -> Result<Self, VibrationError> {
        let Parameters { static_friction, ref law, damping_ratio, belt_velocity, forcing } = parameters;
        FRICTION.check("static_friction", static_friction)?;
        FRICTION.check("kinetic_friction", law.kinetic())?;
        law.validate()?;
        let rate = law.weakening_rate().unwrap_or_else(|| law.steepest());
        WEAKENING.check("velocity weakening of the friction law", rate)?;
        if law.kinetic() > static_friction {
            return Err(VibrationError::Parameter {
                parameter: "kinetic_friction",
                value: law.kinetic(),
                wanted: "at most the static friction",
            });
        }
        DAMPING.check("damping_ratio", damping_ratio)?;
        BELT_VELOCITY.check("belt_velocity", belt_velocity)?;
        if let Some(Forcing { amplitude, frequency }) = forcing {
            FORCING_AMPLITUDE.check("forcing amplitude", amplitude)?;
            FORCING_FREQUENCY.check("forcing_frequency", frequency)?;
        }
        Ok(Self { parameters })
    }

    /// Creates an oscillator with the paper's law: μ_st/(1 + a|v|) in slip and μ_st in stick, without forcing.
    pub fn with_stribeck(
        static_friction: f64,
        decay: f64,
        damping_ratio: f64,
        belt_velocity: f64,
    ) -> Result<Self, VibrationError> {
        let law = VelocityLaw::Stribeck(Stribeck { kinetic: static_friction, decay });
        Self::new(Parameters { static_friction, law, damping_ratio, belt_velocity, forcing: None })
    }

    /// Returns the same oscillator with another damping ratio.
    pub fn with_damping(&self, damping_ratio: f64) -> Result<Self, VibrationError> {
        Self::new(Parameters { damping_ratio, ..self.parameters.clone() })
    }

    /// Returns the same machine under `ratio` times its normal force, in the units of the new force. Velocities, the
    /// friction law over the velocity and the harmonic force keep their SI values.
    pub fn under_load(&self, ratio: f64) -> Result<Self, VibrationError> {
        super::positive("load ratio", ratio)?;
        let force = |forcing: Forcing| Forcing { amplitude: forcing.amplitude / ratio, ..forcing };
        Self::new(Parameters {
            law: self.law().rescaled(ratio),
            belt_velocity: self.belt_velocity() / ratio,
            forcing: self.forcing().map(force),
            ..self.parameters.clone()
        })
    }

    /// Returns the same oscillator with another harmonic force, or none.
    pub fn with_forcing(&self, forcing: Option<Forcing>) -> Result<Self, VibrationError> {
        Self::new(Parameters { forcing, ..self.parameters.clone() })
    }

    /// Returns the parameters of the oscillator.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Returns the stick limit μ_st.
    pub fn static_friction(&self) -> f64 {
        self.parameters.static_friction
    }

    /// Returns the kinetic friction law.
    pub fn law(&self) -> &VelocityLaw {
        &self.parameters.law
    }

    /// Returns the damping ratio ζ.
    pub fn damping_ratio(&self) -> f64 {
        self.parameters.damping_ratio
    }

    /// Returns the belt velocity V.
    pub fn belt_velocity(&self) -> f64 {
        self.parameters.belt_velocity
    }

    /// Returns whether steady sliding is unstable, 2ζ < −dμ/d|v| at the belt velocity, ignoring forcing.
    pub fn sliding_is_unstable(&self) -> bool {
        2.0 * self.damping_ratio() < self.law().weakening(self.belt_velocity())
    }

    /// Returns the harmonic force; none if its amplitude is zero.
    pub fn forcing(&self) -> Option<Forcing> {
        self.parameters.forcing.filter(|f| f.amplitude > 0.0)
    }

    /// Returns the default start X = 0.97 μ_st − 2ζV, at which the mass sticks without fluctuation and forcing.
    pub fn default_start(&self) -> f64 {
        DEFAULT_START_FRACTION * self.static_friction() - 2.0 * self.damping_ratio() * self.belt_velocity()
    }
}

/// Scales of a machine in SI, which convert between metres and seconds and the variables of the oscillator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scales {
    mass_kg: f64,
    natural_frequency_rad_per_s: f64,
    normal_force_n: f64,
}

impl Scales {
    /// Creates the scales of a mass m on a spring c = mω₀², pressed on the belt by the force N; all must be positive.
    pub fn new(mass_kg: f64, natural_frequency_rad_per_s: f64, normal_force_n: f64) -> Result<Self, VibrationError> {
        positive("mass", mass_kg)?;
        positive("natural_frequency", natural_frequency_rad_per_s)?;
        positive("normal_force", normal_force_n)?;
        Ok(Self { mass_kg, natural_frequency_rad_per_s, normal_force_n })
    }

    /// Returns a value of this SI unit in the units of the machine: of `m/s` as a multiple of the velocity N/(mω₀). `None` for a unit that its
    /// motion does not have.
    pub fn dimensionless(&self, value: f64, unit: &str) -> Option<f64> {
        Some(match unit {
            "kg" => value / self.mass_kg,
            "m" => value / self.length_m(),
            "s" => value / self.time_s(),
            "N" => value / self.normal_force_n,
            "m/s" => value / self.velocity_m_per_s(),
            "s/m" => value * self.velocity_m_per_s(),
            "rad/s" => value / self.natural_frequency_rad_per_s,
            "N/m" => value / self.stiffness_n_per_m(),
            _ => return None,
        })
    }

    /// Returns the spring stiffness c = mω₀² in N/m.
    pub fn stiffness_n_per_m(&self) -> f64 {
        self.mass_kg * self.natural_frequency_rad_per_s.powi(2)
    }

    /// Returns the unit of displacement N/c in metre: X = x/(N/c), and λ = ℓ_μ/(N/c).
    pub fn length_m(&self) -> f64 {
        self.normal_force_n / self.stiffness_n_per_m()
    }

    /// Returns the unit of time 1/ω₀ in second.
    pub fn time_s(&self) -> f64 {
        self.natural_frequency_rad_per_s.recip()
    }

    /// Returns the unit of velocity N/(mω₀) in m/s: V = v_b/(N/(mω₀)).
    pub fn velocity_m_per_s(&self) -> f64 {
        self.length_m() / self.time_s()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Coulomb, Exponential};

    #[test]
    fn the_paper_s_belt_and_correlation_length_belong_to_one_kilogram() {
        let scales = Scales::new(1.0, 316.0, 2500.0).unwrap();
        // λ = 250 µm·c/N = 0.01 and V = 0.003 is 23.7 mm/s.
        assert!((250e-6 / scales.length_m() - 0.01).abs() < 2e-5);
        assert!((0.0237 / scales.velocity_m_per_s() - 0.003).abs() < 5e-6);
    }

    #[test]
    fn under_another_load_a_machine_is_the_same_in_si() {
        let (light, heavy) = (Scales::new(2.0, 300.0, 500.0).unwrap(), Scales::new(2.0, 300.0, 1500.0).unwrap());
        let law = VelocityLaw::Exponential(Exponential { kinetic: 0.4, high_speed: 0.3, stribeck_velocity: 0.2 });
        let forcing = Some(Forcing { amplitude: 0.03, frequency: 0.9 });
        let parameters = Parameters { static_friction: 0.5, law, damping_ratio: 0.1, belt_velocity: 0.06, forcing };
        let before = Oscillator::new(parameters).unwrap();
        let after = before.under_load(3.0).unwrap();
        let same = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-14, "{a} and {b}");
        let velocity =
            |oscillator: &Oscillator, scales: &Scales| oscillator.belt_velocity() * scales.velocity_m_per_s();
        same(velocity(&before, &light), velocity(&after, &heavy));
        same(before.forcing().unwrap().amplitude * 500.0, after.forcing().unwrap().amplitude * 1500.0);
        same(before.forcing().unwrap().frequency, after.forcing().unwrap().frequency);
        for metre_per_second in [0.0, 0.03, 0.4, 2.0] {
            let coefficient = |oscillator: &Oscillator, scales: &Scales| {
                oscillator.law().coefficient(metre_per_second / scales.velocity_m_per_s())
            };
            same(coefficient(&before, &light), coefficient(&after, &heavy));
        }
        assert_eq!((after.static_friction(), after.damping_ratio()), (0.5, 0.1));
        assert!(before.under_load(0.0).is_err() && before.under_load(f64::NAN).is_err());
    }

    #[test]
    fn invalid_parameters_are_refused() {
        assert!(Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).is_ok());
        for (static_friction, decay, damping, velocity) in [
            (0.0, 4.2, 0.17, 0.003),
            (0.1, -1.0, 0.17, 0.003),
            (0.1, 4.2, -0.1, 0.003),
            (0.1, 4.2, 0.17, 0.0),
            (0.1, 4.2, f64::NAN, 0.003),
            (f64::INFINITY, 4.2, 0.1, 0.003),
            (1e300, 4.2, 0.17, 0.003),
            (0.1, 1e300, 0.17, 0.003),
            (0.1, 4.2, 1e9, 0.003),
            (0.1, 4.2, 0.17, 1e-300),
            (0.1, 4.2, 0.17, 1e9),
        ] {
            assert!(Oscillator::with_stribeck(static_friction, decay, damping, velocity).is_err());
        }
        // The ends of the ranges are allowed.
        for (static_friction, decay, damping, velocity) in [(1e3, 1e6, 1e3, 1e6), (1e-12, 0.0, 0.0, 1e-12)] {
            assert!(Oscillator::with_stribeck(static_friction, decay, damping, velocity).is_ok());
        }
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.5 });
        let parameters =
            Parameters { static_friction: 0.4, law, damping_ratio: 0.0, belt_velocity: 0.1, forcing: None };
        assert!(matches!(
            Oscillator::new(parameters),
            Err(VibrationError::Parameter { parameter: "kinetic_friction", .. })
        ));
        let fine = Oscillator::with_stribeck(0.1, 4.2, 0.17, 0.003).unwrap();
        for (amplitude, frequency) in [(0.1, 0.0), (0.1, 1e6), (1e9, 1.0), (-0.1, 1.0), (0.1, f64::NAN)] {
            assert!(fine.with_forcing(Some(Forcing { amplitude, frequency })).is_err(), "{amplitude} {frequency}");
        }
        assert!(fine.with_damping(1e9).is_err());
        assert_eq!(fine.with_forcing(Some(Forcing { amplitude: 0.0, frequency: 1.0 })).unwrap().forcing(), None);
    }
}
