//! Checks of `[vibration]`.

use asperity_results::keys::Key;

use super::invalid_value::{InvalidValue, POSITIVE, at_least, invalid, positive, within};
use super::mode_coupling::check_springs;
use super::stated_law::split;
use super::vibration_study::{FrictionSource, SECTION, VibrationStudy};
use crate::distribution::{DistributionError, Marginal};
use crate::friction::StatedFriction;
use crate::friction::process::Generator;
use crate::quantity::Length;
use crate::study::file::{MachineModel, MapSection, StudyFile, VibrationSection, usual_window_m};
use crate::study::uncertain::numbers;
use crate::vibration::law::{Coulomb, VelocityLawKind};
use crate::vibration::{Scales, VelocityLaw, VibrationError};

/// Range of correlation lengths over N/c that sliding distances resolve.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-13..=1e13;

impl StudyFile {
    pub(super) fn check_vibration(&self) -> Result<Option<VibrationStudy>, InvalidValue> {
        let Some(v) = &self.vibration else { return Ok(None) };
        self.check_model(v)?;
        self.check_keys_of_law(v)?;
        let Some(machine) = self.machine()? else { return Ok(None) };
        let stated = v.friction_marginal.as_deref().and_then(|text| text.parse::<Marginal>().ok());
        if let (Some(Generator::Jacobi), Some(marginal)) = (machine.generator, &stated)
            && !matches!(marginal, Marginal::Beta { .. })
        {
            let message = format!("the diffusion requires a Beta distribution, found {marginal}");
            return Err(invalid(SECTION, "generator", message));
        }
        v.map.as_ref().map_or(Ok(()), check_map)?;
        let (from, to, count) = v.damping_sweep;
        let fits = |z: f64| (0.0..1.0).contains(&z);
        within(SECTION, "damping_sweep", from, fits, "damping ratios of at least 0, below 1")?;
        within(SECTION, "damping_sweep", to, |z| fits(z) && z > from, "an end above the start, below 1")?;
        at_least(SECTION, "damping_sweep", count, 2)?;
        at_least(SECTION, "trajectories", v.trajectories, 2)?;
        within(SECTION, "duration", v.duration, positive, POSITIVE)?;
        let study = VibrationStudy {
            machine,
            dimensionless_rate: self.dimensionless_rate(v),
            valid_fraction: self.valid_share,
            allow_clipping: v.allow_clipping,
            damping_sweep: v.damping_sweep,
            trajectories: v.trajectories,
            duration: v.duration,
            map: v.map.clone(),
        };
        match &study.machine.friction {
            _ if study.machine.coupled.is_some() => check_springs(&study.machine)?,
            FrictionSource::Stated(friction) => check_motion(v, &study, friction)?,
            FrictionSource::Computed(_) | FrictionSource::File(_) => {}
        }
        Ok(Some(study))
    }

    /// Refuses keys of other velocity laws than the stated one.
    fn check_keys_of_law(&self, v: &VibrationSection) -> Result<(), InvalidValue> {
        let (law, table) = (v.velocity_law, VelocityLawKind::Table);
        let of_table = || (split(table.statement().inputs[0]).1, table.name());
        let of_table = v.friction_table.as_ref().filter(|_| law != table).map(|_| of_table());
        let of_other = self.unmet(SECTION, "velocity_law", law.name()).map(|(key, law)| (key.name, law));
        match of_other.chain(of_table).next() {
            Some((key, law)) => Err(invalid(SECTION, key, format!("this key requires velocity_law = \"{law}\""))),
            None => Ok(()),
        }
    }

    /// Returns the source of the friction: exactly one of the friction stage, a file and the keys of the section.
    pub(super) fn friction_source(&self, v: &VibrationSection) -> Result<FrictionSource, InvalidValue> {
        if let Some(level) = v.level
            && !self.friction.as_ref().is_some_and(|f| f.percentiles().contains(&level))
        {
            return Err(invalid(SECTION, "level", format!("found {level}, expected one of [friction] percentiles")));
        }
        if let (None, Some(_), Some(hardness)) = (v.level, &self.friction, self.hardness())
            && v.normal_force.0 >= hardness.0 * v.nominal_area.0
        {
            let message = format!(
                "{} on {} is not below the hardness {hardness}, so no level can be solved at it; enlarge the area, or \
                 name a `level`",
                v.normal_force, v.nominal_area
            );
            return Err(invalid(SECTION, "nominal_area", message));
        }
        // Constant friction has neither a correlation nor a distribution.
        let constant = v.friction_std == Some(0.0);
        let keys = [
            ("static_friction", v.static_friction.is_some()),
            ("friction_std", v.friction_std.is_some()),
            ("friction_correlation_length", v.friction_correlation_length.is_some() || constant),
            ("friction_marginal", v.friction_marginal.is_some() || constant),
        ];
        let stated = v
            .static_friction
            .zip(v.friction_std)
            .zip(v.friction_correlation_length.or(constant.then_some(Length(usual_window_m()[0]))))
            .zip(v.friction_marginal.as_deref().or(constant.then_some("normal")));
        if let (Some((first, _)), Some((absent, _))) =
            (keys.iter().find(|(_, present)| *present), keys.iter().find(|(_, present)| !present))
        {
            return Err(invalid(SECTION, absent, format!("required because `{first}` is stated")));
        }
        match (stated, &v.friction_process, self.friction.is_some()) {
            (None, None, false) => {
                let message = "without a [friction] section the friction process must be stated here, or read by \
                               `friction_process`";
                Err(invalid(SECTION, "static_friction", message))
            }
            (Some(_), _, true) => {
                let message = "the friction process is both stated here and computed by [friction]; remove one";
                Err(invalid(SECTION, "static_friction", message))
            }
            (Some(_), Some(_), _) => {
                let message = "the friction process is both read from a file and stated; remove one";
                Err(invalid(SECTION, "friction_process", message))
            }
            (None, Some(_), true) => {
                let message = "the friction process is both read from a file and computed by [friction]; remove one";
                Err(invalid(SECTION, "friction_process", message))
            }
            (None, None, true) => Ok(FrictionSource::Computed(v.level)),
            (None, Some(file), false) => Ok(FrictionSource::File(file.clone())),
            (Some((((mean, std), correlation_length), marginal)), None, false) => {
                let marginal = marginal
                    .parse()
                    .map_err(|error: DistributionError| invalid(SECTION, "friction_marginal", error.to_string()))?;
                let (length_m, window_m) = (correlation_length.0, usual_window_m());
                Ok(FrictionSource::Stated(StatedFriction { mean, std, length_m, marginal, window_m }))
            }
        }
    }
}

/// Checks that the oscillator can move: its parameters are in range, and friction stays positive at the velocities of
/// its motion.
fn check_motion(v: &VibrationSection, study: &VibrationStudy, friction: &StatedFriction) -> Result<(), InvalidValue> {
    let velocity = if v.belt_velocity.is_some() { "belt_velocity" } else { "dimensionless_belt_velocity" };
    let law = split(v.velocity_law.statement().inputs[0]).1;
    let of_key = |error: VibrationError| match error {
        VibrationError::Parameter { parameter, .. } => {
            let key = match parameter {
                "static_friction" => "static_friction",
                "kinetic_friction" => "kinetic_share",
                "damping_ratio" => "damping_ratio",
                "belt_velocity" => velocity,
                "forcing amplitude" => "forcing",
                "forcing_frequency" => "forcing_frequency",
                _ => law,
            };
            Err(invalid(SECTION, key, format!("in the units of the machine, {error}")))
        }
        error => Err(invalid(SECTION, law, error.to_string())),
    };
    let machine = &study.machine;
    let oscillator = match machine.oscillator(friction.mean, None) {
        Ok(oscillator) => oscillator,
        Err(error) => return of_key(error),
    };
    let unit_m = machine.scales.length_m();
    let length = Length(friction.length_m);
    if !LENGTHS.contains(&(length.0 / unit_m)) {
        let message = format!("{length} is not between 1e-13 and 1e13 times N/c, {unit_m:.3e} m");
        return Err(invalid(SECTION, "friction_correlation_length", message));
    }
    study.machine.check_motion(&oscillator, study.duration).or_else(of_key)
}

impl StudyFile {
    /// Returns the velocity law for a kinetic friction coefficient of 1.
    pub(super) fn velocity_law(&self, v: &VibrationSection, scales: &Scales) -> Result<VelocityLaw, InvalidValue> {
        if v.model == MachineModel::ModeCoupling {
            return Ok(Coulomb { kinetic: 1.0 }.into());
        }
        self.stated_law(v.velocity_law.statement(), Some(scales))
    }

    /// Returns the key and the number of the velocity law per unit of dimensionless velocity.
    fn dimensionless_rate(&self, v: &VibrationSection) -> Option<(&'static str, f64)> {
        let inputs = v.velocity_law.statement().inputs;
        let of_law = |key: &Key| key.velocity_power != 0 && inputs.contains(&key.path().as_str());
        let mut rates = numbers().filter(|(key, _)| v.model == MachineModel::StickSlip && of_law(key));
        rates.find_map(|(key, access)| {
            let usual = || key.default?.value.number().filter(|_| !access.is_stated(self));
            Some((key.name, access.get(self, key, None).or_else(usual)?))
        })
    }
}

fn check_map(map: &MapSection) -> Result<(), InvalidValue> {
    const SECTION: &str = "vibration.map";
    for (key, name, (from, to, cells)) in [("x", map.over.axes()[0], map.x), ("y", map.over.axes()[1], map.y)] {
        // Damping and standard deviation may start at zero.
        let (least, most) = match name {
            "damping_ratio" => (0.0, 1.0),
            "friction_std" => (0.0, f64::INFINITY),
            _ => (f64::MIN_POSITIVE, f64::INFINITY),
        };
        let range = format!("values of {name} from {} on, in rising order", if least > 0.0 { "above 0" } else { "0" });
        within(SECTION, key, from, |value| value >= least && value < most, &range)?;
        within(SECTION, key, to, |value| value > from && value < most, &range)?;
        at_least(SECTION, key, cells, 1)?;
        if cells > 1000 {
            return Err(invalid(SECTION, key, format!("found {cells} cells, expected at most 1000")));
        }
    }
    within(SECTION, "depth", map.depth, |depth| depth <= 8.0, "at most 8")?;
    at_least(SECTION, "trajectories", map.trajectories, 2)
}
