//! Answers of one machine of either model, with constant friction.

use serde::{Deserialize, Serialize};

use crate::friction::WindowFriction;
use crate::study::check::MachineInputs;
use crate::study::motion_entries::{coupled_cycle_result, instability_result};
use crate::study::result::{MachineModel, MotionKind, NominalMachine};
use crate::vibration::mode_coupling::{Model, friction_margin, instability, limit_cycle_within, modes};
use crate::vibration::{DampingMargins, Oscillator, Scales, VibrationError, limit_cycle, limit_damping, smallest_kick};

/// Number of waves after which the motion of a sampled machine counts as irregular.
const MOST_WAVES: usize = 2_000;

/// Machine of either model.
#[derive(Debug, Clone)]
pub(super) enum Dynamics {
    /// One degree of freedom.
    StickSlip(Oscillator),
    /// Two coupled modes.
    ModeCoupling(Model),
}

/// Margins of a machine; it vibrates if its margin is negative.
///
/// With one degree of freedom they are margins of the damping ratio ([`DampingMargins`]). Coupled modes have one margin of the
/// friction coefficient, μ_c − μ: a machine counts as vibrating if its steady sliding is unstable, however its motion begins.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Margins {
    pub(super) from_stick: f64,
    pub(super) from_steady_sliding: f64,
}

/// Vibration of a machine.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Vibration {
    pub(super) kind: MotionKind,
    pub(super) frequency_hz: f64,
    /// Amplitude of the velocity; `None` for motion that does not repeat.
    pub(super) velocity_amplitude_m_per_s: Option<f64>,
    /// Amplitude of the displacement along the belt; `None` for motion that does not repeat.
    pub(super) displacement_amplitude_m: Option<f64>,
}

impl Dynamics {
    /// Returns the machine of a study with this friction.
    pub(super) fn new(machine: &MachineInputs, window: &WindowFriction) -> Result<Self, VibrationError> {
        match machine.coupled_model(window.mean, window.stiffness_pa_per_m) {
            Some(model) => model.map(Self::ModeCoupling),
            None => machine.oscillator(window.mean, window.stribeck).map(Self::StickSlip),
        }
    }

    pub(super) fn model(&self) -> MachineModel {
        match self {
            Self::StickSlip(_) => MachineModel::StickSlip,
            Self::ModeCoupling(_) => MachineModel::ModeCoupling,
        }
    }

    pub(super) fn margins(&self) -> Result<Margins, VibrationError> {
        match self {
            Self::StickSlip(oscillator) => {
                let DampingMargins { from_stick, from_steady_sliding } = DampingMargins::new(oscillator)?;
                Ok(Margins { from_stick, from_steady_sliding })
            }
            Self::ModeCoupling(model) => {
                let margin = friction_margin(model)?;
                Ok(Margins { from_stick: margin, from_steady_sliding: margin })
            }
        }
    }

    /// Returns the kind of motion.
    pub(super) fn kind(&self) -> Result<MotionKind, VibrationError> {
        match self {
            Self::StickSlip(oscillator) => Ok(limit_cycle(oscillator)?.kind()),
            Self::ModeCoupling(model) => Ok(instability_result(instability(model)?)),
        }
    }

    /// Returns the vibration of the machine; `None` without vibration.
    pub(super) fn vibration(&self, scales: &Scales) -> Result<Option<Vibration>, VibrationError> {
        match self {
            Self::StickSlip(oscillator) => Ok(limit_cycle(oscillator)?.cycle().map(|cycle| {
                let velocity = 0.5 * (cycle.velocity_max - cycle.velocity_min) * scales.velocity_m_per_s();
                let displacement = 0.5 * (cycle.displacement_max - cycle.displacement_min) * scales.length_m();
                Vibration {
                    kind: cycle.kind,
                    frequency_hz: 1.0 / (cycle.period * scales.time_s()),
                    velocity_amplitude_m_per_s: Some(velocity),
                    displacement_amplitude_m: Some(displacement),
                }
            })),
            Self::ModeCoupling(model) => {
                let kind = instability(model)?;
                if kind.is_none() {
                    return Ok(None);
                }
                let regime = limit_cycle_within(model, None, MOST_WAVES)?;
                let cycle = regime.cycle().map(|cycle| coupled_cycle_result(model, cycle, scales)).transpose()?;
                // A motion that does not repeat has the frequency of the growing mode.
                let growing_hz = || {
                    let [first, second] = modes(model, model.sliding_friction());
                    let growing = if first.growth > second.growth { first } else { second };
                    growing.frequency / (std::f64::consts::TAU * scales.time_s())
                };
                Ok(Some(Vibration {
                    kind: instability_result(kind),
                    frequency_hz: cycle.as_ref().map_or_else(growing_hz, |cycle| cycle.frequency_hz),
                    velocity_amplitude_m_per_s: cycle.as_ref().map(|cycle| cycle.velocity_amplitude_m_per_s),
                    displacement_amplitude_m: cycle.as_ref().map(|cycle| cycle.displacement_amplitude_m),
                }))
            }
        }
    }

    /// Returns the answer of the machine with all values at their centres.
    pub(super) fn nominal(&self, vibrates: bool, scales: &Scales) -> Result<NominalMachine, VibrationError> {
        match self {
            Self::StickSlip(oscillator) => {
                let limit_damping_ratio = limit_damping(oscillator)?;
                Ok(NominalMachine {
                    vibrates,
                    kind: self.kind()?,
                    steady_sliding_unstable: oscillator.sliding_is_unstable(),
                    kick_m_per_s: smallest_kick(oscillator)?.map(|kick| kick * scales.velocity_m_per_s()),
                    limit_damping_ratio: Some(limit_damping_ratio),
                    damping_margin: oscillator.damping_ratio() - limit_damping_ratio,
                    damping_margin_interval: None,
                })
            }
            Self::ModeCoupling(model) => {
                let margin = friction_margin(model)?;
                Ok(NominalMachine {
                    vibrates,
                    kind: self.kind()?,
                    steady_sliding_unstable: margin < 0.0,
                    kick_m_per_s: None,
                    limit_damping_ratio: model.limit_damping_ratio(model.sliding_friction()),
                    damping_margin: margin,
                    damping_margin_interval: None,
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Study;
    use crate::study::verdict::machines::Machines;
    use crate::study::verdict::machines::tests::stated_window;

    #[test]
    fn a_nominal_machine_has_its_margin_and_its_smallest_kick_in_si() {
        let text = "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
                    nominal_area = \"833 mm^2\"\nstatic_friction = 0.3\nfriction_std = 0\n";
        let machine = |lines: &str| {
            let study = Study::parse(&format!("{text}{lines}"), "study.toml").unwrap();
            let window = stated_window(&study);
            Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1).nominal().unwrap()
        };
        // A jump of .05 with a fall b at V = .05 between the limits ζ_H = b/2 = .05 of steady sliding and ζ_v = .1078 of stick-slip.
        let jumps = machine(
            "damping_ratio = 0.09\ndimensionless_belt_velocity = 0.05\nvelocity_law = \"linear\"\nlinear_weakening = 0.1\n\
             kinetic_share = 0.8333333333333334\n",
        );
        let Dynamics::StickSlip(oscillator) = &jumps.dynamics else { panic!() };
        let (scales, limit) = (&jumps.inputs.scales, limit_damping(oscillator).unwrap());
        let found = jumps.dynamics.nominal(true, scales).unwrap();
        let kick = smallest_kick(oscillator).unwrap().unwrap() * 2500.0 / 316.0;
        assert!((found.kick_m_per_s.unwrap() / kick - 1.0).abs() < 1e-12, "{found:?}");
        assert!(
            (found.damping_margin - (0.09 - limit)).abs() < 1e-12 && (limit - 0.1078291).abs() < 1e-6,
            "{found:?} {limit}"
        );
        assert_eq!((found.vibrates, found.steady_sliding_unstable), (true, false));
        // Coupled modes have the margin of friction.
        for (friction, is_unstable) in [("0.1", false), ("0.9", true)] {
            let lines = "model = \"mode_coupling\"\nbelt_velocity = \"0.5 m/s\"\ndamping_ratio = 0.001\n";
            let study = Study::parse(
                &format!("{text}{lines}").replace("static_friction = 0.3", &format!("static_friction = {friction}")),
                "study.toml",
            )
            .unwrap();
            let window = stated_window(&study);
            let machine = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1).nominal().unwrap();
            let Dynamics::ModeCoupling(model) = &machine.dynamics else { panic!() };
            let found = machine.dynamics.nominal(is_unstable, &machine.inputs.scales).unwrap();
            assert_eq!(found.damping_margin, friction_margin(model).unwrap());
            assert_eq!((found.damping_margin < 0.0, found.steady_sliding_unstable), (is_unstable, is_unstable));
        }
    }
}
