//! Checked machine of `[vibration]`: a mass on a belt.

use std::path::PathBuf;

use asperity_results::MachineModel;
use asperity_results::keys::STRIBECK;
use serde::Serialize;

use super::invalid_value::{InvalidValue, POSITIVE, invalid, positive, within};
use crate::friction::process::Generator;
use crate::friction::{NominalContact, StatedFriction, Upscaling};
use crate::quantity::{Area, Force};
use crate::study::file::{ContactSpring, MapSection, Stribeck, StudyFile, VibrationSection};
use crate::study::sentence;
use crate::study::uncertain::numbers;
use crate::vibration::law::{Coulomb, VelocityLawKind};
use crate::vibration::mode_coupling::{CoupledParameters, Damping, Model};
use crate::vibration::{
    Drive, Forcing, MapOver, Oscillator, Parameters, Scales, TrajectorySettings, VelocityLaw, VibrationError,
    check_positive,
};

/// Duration of the check that friction stays positive, in units of 1/ω₀: the first slips are the fastest.
const FIRST_TIME: f64 = 100.0;
/// Default coefficient a of the Stribeck law, the paper's value.
const USUAL_STRIBECK: Stribeck = Stribeck::Dimensionless(STRIBECK);
/// Name of the section.
pub(super) const SECTION: &str = "vibration";

/// Settings of the vibration stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(in crate::study) struct VibrationStudy {
    pub(in crate::study) machine: MachineInputs,
    /// Key and number of the law per unit of dimensionless velocity, if a key of it is.
    pub(in crate::study) dimensionless_rate: Option<(&'static str, f64)>,
    /// Least fraction of valid samples.
    pub(in crate::study) valid_fraction: f64,
    /// Whether more than 5 % of the friction values may be clipped to stay positive.
    pub(in crate::study) allow_clipping: bool,
    /// Damping ratios: from, to, count.
    pub(in crate::study) damping_sweep: (f64, f64, usize),
    /// Trajectories per damping ratio.
    pub(in crate::study) trajectories: usize,
    /// Dimensionless duration of a trajectory.
    pub(in crate::study) duration: f64,
    pub(in crate::study) map: Option<MapSection>,
}

/// A mass on a belt: all that decides its motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(in crate::study) struct MachineInputs {
    /// Springs of two coupled modes; `None` for stick-slip of a mass with one degree of freedom.
    pub(in crate::study) coupled: Option<CoupledStudy>,
    pub(in crate::study) scales: Scales,
    pub(in crate::study) normal_force: Force,
    pub(in crate::study) nominal_area: Area,
    pub(in crate::study) damping_ratio: f64,
    /// Dimensionless velocity V of the belt.
    pub(in crate::study) belt_velocity: f64,
    /// Dimensionless harmonic force on the mass.
    pub(in crate::study) forcing: Option<Forcing>,
    /// Ratio of the kinetic friction coefficient at vanishing velocity to the static one.
    pub(in crate::study) kinetic_fraction: f64,
    /// Velocity law of a kinetic friction coefficient of 1.
    pub(in crate::study) velocity_law: VelocityLaw,
    /// Stribeck coefficient as stated, if the law has one.
    pub(in crate::study) stribeck: Option<Stribeck>,
    pub(in crate::study) friction: FrictionSource,
    /// Generator of the fluctuation, if the study states it.
    pub(in crate::study) generator: Option<Generator>,
    pub(in crate::study) drive: Drive,
    /// Upscaling of the main result.
    pub(in crate::study) upscaling: Upscaling,
}

/// Springs of two coupled modes, in units of mω₀².
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(in crate::study) struct CoupledStudy {
    pub(in crate::study) angles_deg: [f64; 2],
    pub(in crate::study) springs: [f64; 2],
    pub(in crate::study) contact_spring: ContactSpring,
}

/// Source of the friction process.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(in crate::study) enum FrictionSource {
    /// Result of the friction stage, at this percentile, or at the nominal pressure.
    Computed(Option<f64>),
    /// File of a fitted process, relative to the study file.
    File(PathBuf),
    /// Values stated in the study file, for a window of the usual size.
    Stated(StatedFriction),
}

impl StudyFile {
    /// Returns the machine; `None` without the section. A study with other values of its inputs has the same keys, which
    /// `check_vibration` has checked.
    pub(in crate::study) fn machine(&self) -> Result<Option<MachineInputs>, InvalidValue> {
        let Some(v) = &self.vibration else { return Ok(None) };
        let scales = Scales::new(v.mass.0, v.natural_frequency.0, v.normal_force.0)
            .map_err(|error| invalid(SECTION, "mass", error.to_string()))?;
        let belt_velocity = match (v.belt_velocity, v.dimensionless_belt_velocity) {
            (Some(velocity), None) => velocity.0 / scales.velocity_m_per_s(),
            (None, Some(value)) => value,
            _ => {
                let message = "state exactly one of belt_velocity and dimensionless_belt_velocity";
                return Err(invalid(SECTION, "belt_velocity", message));
            }
        };
        let coupled = v.coupled();
        let has_stribeck = v.velocity_law == VelocityLawKind::Stribeck && coupled.is_none();
        Ok(Some(MachineInputs {
            coupled,
            scales,
            normal_force: v.normal_force,
            nominal_area: v.nominal_area,
            damping_ratio: v.damping_ratio,
            belt_velocity,
            forcing: forcing(v)?,
            kinetic_fraction: v.kinetic_share,
            velocity_law: self.velocity_law(v, &scales)?,
            stribeck: has_stribeck.then(|| v.stribeck.unwrap_or(USUAL_STRIBECK)),
            friction: self.friction_source(v)?,
            generator: v.generator.map(|generator| generator.0),
            drive: v.drive,
            upscaling: v.upscaling,
        }))
    }
}

/// Checks the harmonic force and returns it in the units of the machine.
fn forcing(v: &VibrationSection) -> Result<Option<Forcing>, InvalidValue> {
    match (v.forcing, v.forcing_frequency) {
        (Some(force), Some(frequency)) => {
            within(SECTION, "forcing", force, |q| q >= 0.0, "zero or a positive value")?;
            within(SECTION, "forcing_frequency", frequency, positive, POSITIVE)?;
            let (amplitude, frequency) = (force.0 / v.normal_force.0, frequency.0 / v.natural_frequency.0);
            Ok(Some(Forcing { amplitude, frequency }))
        }
        (Some(_), None) => Err(invalid(SECTION, "forcing_frequency", "required because `forcing` is stated")),
        (None, Some(_)) => Err(invalid(SECTION, "forcing", "required because `forcing_frequency` is stated")),
        (None, None) => Ok(None),
    }
}

impl MachineInputs {
    /// Returns the model of the machine.
    pub(in crate::study) fn model(&self) -> MachineModel {
        if self.coupled.is_some() { MachineModel::ModeCoupling } else { MachineModel::StickSlip }
    }

    /// Returns the nominal area and its pressure.
    pub(in crate::study) fn nominal_contact(&self) -> NominalContact {
        let area_m2 = self.nominal_area.0;
        NominalContact { area_m2, pressure_pa: self.normal_force.0 / area_m2 }
    }

    /// Returns the Stribeck coefficient per unit of dimensionless velocity.
    pub(in crate::study) fn dimensionless_stribeck(&self) -> Option<f64> {
        self.stribeck.map(|stribeck| stribeck.per_unit(self.scales.velocity_m_per_s()))
    }

    /// Returns the oscillator with this static friction coefficient; `stribeck` replaces the coefficient of the law if
    /// a fitted process has one.
    pub(in crate::study) fn oscillator(
        &self,
        static_friction: f64,
        stribeck: Option<f64>,
    ) -> Result<Oscillator, VibrationError> {
        let kinetic = self.kinetic_fraction * static_friction;
        let own = self.velocity_law.with_coefficients(|ratio| ratio * kinetic)?;
        let law = stribeck.and_then(|rate| own.with_weakening_rate(rate)).unwrap_or(own);
        Oscillator::new(Parameters {
            static_friction,
            law,
            damping_ratio: self.damping_ratio,
            belt_velocity: self.belt_velocity,
            forcing: self.forcing,
        })
    }

    /// Checks that friction stays positive in the first motions of the mass, within a dimensionless duration.
    pub(in crate::study) fn check_motion(&self, oscillator: &Oscillator, duration: f64) -> Result<(), VibrationError> {
        let duration = duration.min(FIRST_TIME);
        check_positive(oscillator, &TrajectorySettings { duration, start: None, drive: self.drive })
    }

    /// Returns the model of two coupled modes with this friction coefficient and this stiffness of the rough contact over its area
    /// in Pa/m; `None` for a machine with one degree of freedom.
    ///
    /// # Errors
    /// The springs do not hold the mass, a value is out of range, or the stiffness of the contact is not known.
    pub(in crate::study) fn coupled_model(
        &self,
        friction: f64,
        stiffness_pa_per_m: Option<f64>,
    ) -> Option<Result<Model, VibrationError>> {
        let CoupledStudy { angles_deg, springs, contact_spring } = self.coupled?;
        let contact_stiffness = match (contact_spring, stiffness_pa_per_m) {
            (ContactSpring::Stated(stiffness), _) => stiffness,
            (ContactSpring::Surface, Some(pa_per_m)) => {
                pa_per_m * self.nominal_area.0 / self.scales.stiffness_n_per_m()
            }
            (ContactSpring::Surface, None) => {
                let reason = "the strips of the operating level have no contact stiffness";
                return Some(Err(VibrationError::NotFound { what: "contact spring of the surface", reason }));
            }
        };
        let damper = 2.0 * self.damping_ratio;
        Some(Model::new(CoupledParameters {
            angles_deg,
            springs,
            contact_stiffness,
            damping: Damping::Axes { tangential: damper, normal: damper },
            static_friction: friction,
            law: VelocityLaw::Coulomb(Coulomb { kinetic: friction }),
            belt_velocity: self.belt_velocity,
        }))
    }
}

impl VibrationStudy {
    /// Returns a warning about a dimensionless law in a study that varies the load.
    pub(in crate::study) fn load_warning(&self) -> Option<String> {
        if self.map.as_ref().is_none_or(|map| map.over != MapOver::VelocityLoad) {
            return None;
        }
        let (key, value) = self.dimensionless_rate?;
        let si = sentence::digits(value / self.machine.scales.velocity_m_per_s());
        let in_si =
            numbers().map(|(row, _)| row).find(|row| (row.section, row.name) == (SECTION, key) && !row.unit.is_empty());
        let instead = in_si.map_or(String::new(), |row| {
            format!("; state `{key} = \"{si} {}\"` to make the law independent of `normal_force`", row.unit)
        });
        Some(format!(
            "`{key}` = {} is per unit of dimensionless velocity and depends on the stated normal force of {}: there it means {si} s/m, \
             which the map keeps over the load{instead}",
            sentence::digits(value),
            self.machine.normal_force
        ))
    }

    /// Returns the duration of a trajectory in seconds.
    pub(in crate::study) fn duration_s(&self) -> f64 {
        self.duration * self.machine.scales.time_s()
    }

    /// Returns the distance in metre that the belt travels during a trajectory.
    pub(in crate::study) fn sliding_distance_m(&self) -> f64 {
        self.duration * self.machine.belt_velocity * self.machine.scales.length_m()
    }
}
