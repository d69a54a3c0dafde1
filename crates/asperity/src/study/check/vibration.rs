//! Whether the values of `[vibration]` can be right.

use std::str::FromStr;

use super::{POSITIVE, Problem, at_least, positive, problem, within};
use crate::distribution::Marginal;
use crate::friction::process::Steady;
use crate::study::config::{FluctuationChoice, MapSection, Study, VelocityLaw, VibrationSection};
use crate::vibration::{Method, Trajectory, TrajectorySettings, VibrationError};

const SECTION: &str = "vibration";
/// Time that is followed to see whether friction stays positive: the first slips are the fastest.
const FIRST_TIME: f64 = 100.0;
/// Correlation lengths over N/c that sliding distances resolve.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-13..=1e13;
const SHARE: &str = "a share above 0, at most 1";

fn share(value: f64) -> bool {
    value > 0.0 && value <= 1.0
}

impl Study {
    pub(super) fn check_vibration(&self) -> Result<(), Problem> {
        let Some(v) = &self.vibration else { return Ok(()) };
        within(SECTION, "mass", v.mass.0, positive, POSITIVE)?;
        within(SECTION, "natural_frequency", v.natural_frequency.0, positive, POSITIVE)?;
        within(SECTION, "damping_ratio", v.damping_ratio, |z| z >= 0.0, "zero or a positive value")?;
        within(SECTION, "normal_force", v.normal_force.0, positive, POSITIVE)?;
        within(SECTION, "nominal_area", v.nominal_area.0, positive, POSITIVE)?;
        match (v.belt_velocity, v.dimensionless_belt_velocity) {
            (Some(velocity), None) => within(SECTION, "belt_velocity", velocity.0, positive, POSITIVE)?,
            (None, Some(value)) => within(SECTION, "dimensionless_belt_velocity", value, positive, POSITIVE)?,
            _ => {
                let message = "state exactly one of belt_velocity and dimensionless_belt_velocity";
                return Err(problem(SECTION, "belt_velocity", message));
            }
        }
        check_machine(v)?;
        v.map.as_ref().map_or(Ok(()), check_map)?;
        let (from, to, count) = v.damping_sweep;
        let fits = |z: f64| (0.0..1.0).contains(&z);
        within(SECTION, "damping_sweep", from, fits, "damping ratios of at least 0, below 1")?;
        within(SECTION, "damping_sweep", to, |z| fits(z) && z > from, "an end above the start, below 1")?;
        at_least(SECTION, "damping_sweep", count, 2)?;
        at_least(SECTION, "trajectories", v.trajectories, 2)?;
        within(SECTION, "duration", v.duration, positive, POSITIVE)?;
        if let Some(level) = v.level
            && !self.friction.as_ref().is_some_and(|f| f.percentiles().contains(&level))
        {
            return Err(problem(SECTION, "level", format!("found {level}, wanted one of [friction] percentiles")));
        }
        if let (None, Some(_), Some(hardness)) =
            (v.level, &self.friction, self.material.as_ref().and_then(|material| material.hardness))
            && v.normal_force.0 >= hardness.0 * v.nominal_area.0
        {
            let message = format!(
                "{} on {} is not below the hardness {hardness}, so no level can be solved at it; enlarge the area, or \
                 name a `level`",
                v.normal_force, v.nominal_area
            );
            return Err(problem(SECTION, "nominal_area", message));
        }
        self.check_stated_friction()
    }

    fn check_stated_friction(&self) -> Result<(), Problem> {
        let Some(v) = &self.vibration else { return Ok(()) };
        let stated = [
            ("static_friction", v.static_friction.is_some()),
            ("friction_std", v.friction_std.is_some()),
            ("friction_correlation_length", v.friction_correlation_length.is_some()),
            ("friction_marginal", v.friction_marginal.is_some()),
        ];
        if let Some((first, _)) = stated.iter().find(|(_, present)| *present)
            && let Some((absent, _)) = stated.iter().find(|(_, present)| !present)
        {
            return Err(problem(SECTION, absent, format!("`{first}` is stated, so this must be too")));
        }
        let (states, computes, reads) = (v.states_friction(), self.friction.is_some(), v.friction_process.is_some());
        if !(states || computes || reads) {
            let message =
                "without a [friction] section the friction process must be stated here, or read by `friction_process`";
            return Err(problem(SECTION, "static_friction", message));
        }
        if states && computes {
            let message = "the friction process is stated here and computed by [friction]; leave one out";
            return Err(problem(SECTION, "static_friction", message));
        }
        if reads && (states || computes) {
            let other = if states { "stated beside it" } else { "computed by [friction]" };
            let message = format!("the friction process is read here and {other}; leave one out");
            return Err(problem(SECTION, "friction_process", message));
        }
        if let Some(value) = v.static_friction {
            within(SECTION, "static_friction", value, positive, POSITIVE)?;
        }
        if let Some(value) = v.friction_std {
            within(SECTION, "friction_std", value, |s| s >= 0.0, "zero or a positive value")?;
        }
        if let Some(length) = v.friction_correlation_length {
            within(SECTION, "friction_correlation_length", length.0, positive, POSITIVE)?;
        }
        if let Some(text) = &v.friction_marginal {
            Marginal::from_str(text).map_err(|error| problem(SECTION, "friction_marginal", error.to_string()))?;
        }
        v.static_friction.map_or(Ok(()), |friction| check_motion(v, friction))
    }
}

/// Whether the machine can move: its numbers lie in range, and friction stays positive at the speeds of its motion.
fn check_motion(v: &VibrationSection, static_friction: f64) -> Result<(), Problem> {
    let velocity = if v.belt_velocity.is_some() { "belt_velocity" } else { "dimensionless_belt_velocity" };
    let law = match v.velocity_law {
        VelocityLaw::Stribeck => "stribeck",
        VelocityLaw::Linear => "linear_weakening",
        VelocityLaw::Exponential => "stribeck_velocity",
    };
    let told = |error: VibrationError| match error {
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
            Err(problem(SECTION, key, format!("in the units of the machine, {error}")))
        }
        VibrationError::FrictionNotPositive { .. } => Err(problem(SECTION, law, error.to_string())),
        // What has no answer yet is told by the run.
        _ => Ok(()),
    };
    let machine = match v.dimensionless_stribeck().and_then(|stribeck| v.oscillator(static_friction, stribeck)) {
        Ok(machine) => machine,
        Err(error) => return told(error),
    };
    let unit_m = v.scales().map_or(f64::NAN, |scales| scales.length_m());
    if let Some(length) = v.friction_correlation_length.filter(|length| !LENGTHS.contains(&(length.0 / unit_m))) {
        let message = format!("{length} is not between 1e-13 and 1e13 times N/c, {unit_m:.3e} m");
        return Err(problem(SECTION, "friction_correlation_length", message));
    }
    let settings = TrajectorySettings {
        duration: v.duration.min(FIRST_TIME),
        start: None,
        drive: v.drive.into(),
        method: Method::Taylor,
    };
    Trajectory::simulate(&machine, Steady, &settings).map_or_else(told, |_| Ok(()))
}

/// The friction law, and the force on the mass.
fn check_machine(v: &VibrationSection) -> Result<(), Problem> {
    within(SECTION, "kinetic_share", v.kinetic_share, share, SHARE)?;
    if let Some(coefficient) = v.stribeck {
        within(SECTION, "stribeck", coefficient.value(), |a| a >= 0.0, "zero or a positive value")?;
    }
    let needs = |key, law: &str| Err(problem(SECTION, key, format!("velocity_law = \"{law}\" needs this key")));
    match v.velocity_law {
        VelocityLaw::Stribeck => {}
        VelocityLaw::Linear if v.linear_weakening.is_none() => return needs("linear_weakening", "linear"),
        VelocityLaw::Exponential if v.stribeck_velocity.is_none() => return needs("stribeck_velocity", "exponential"),
        VelocityLaw::Exponential if v.high_speed_share.is_none() => return needs("high_speed_share", "exponential"),
        VelocityLaw::Linear | VelocityLaw::Exponential => {}
    }
    // A key of another law would be left aside without a word.
    let exponential = v.velocity_law == VelocityLaw::Exponential;
    for (key, stray, law) in [
        ("stribeck", v.stribeck.is_some() && v.velocity_law != VelocityLaw::Stribeck, "stribeck"),
        ("linear_weakening", v.linear_weakening.is_some() && v.velocity_law != VelocityLaw::Linear, "linear"),
        ("stribeck_velocity", v.stribeck_velocity.is_some() && !exponential, "exponential"),
        ("high_speed_share", v.high_speed_share.is_some() && !exponential, "exponential"),
    ] {
        if stray {
            return Err(problem(SECTION, key, format!("this key belongs to velocity_law = \"{law}\"")));
        }
    }
    if let Some(slope) = v.linear_weakening {
        within(SECTION, "linear_weakening", slope, |b| b >= 0.0, "zero or a positive value")?;
    }
    if let Some(velocity) = v.stribeck_velocity {
        within(SECTION, "stribeck_velocity", velocity.0, positive, POSITIVE)?;
    }
    if let Some(high_speed) = v.high_speed_share {
        within(SECTION, "high_speed_share", high_speed, share, SHARE)?;
    }
    match (v.forcing, v.forcing_frequency) {
        (Some(force), Some(frequency)) => {
            within(SECTION, "forcing", force.0, |q| q >= 0.0, "zero or a positive value")?;
            within(SECTION, "forcing_frequency", frequency.0, positive, POSITIVE)?;
        }
        (Some(_), None) => {
            return Err(problem(SECTION, "forcing_frequency", "`forcing` is stated, so this must be too"));
        }
        (None, Some(_)) => {
            return Err(problem(SECTION, "forcing", "`forcing_frequency` is stated, so this must be too"));
        }
        (None, None) => {}
    }
    let stated = v.friction_marginal.as_deref().and_then(|text| text.parse().ok());
    if let (Some(FluctuationChoice::Jacobi), Some(law)) = (v.generator, &stated)
        && !matches!(law, Marginal::Beta { .. })
    {
        let message = format!("the diffusion has a Beta law, and friction_marginal is {law}");
        return Err(problem(SECTION, "generator", message));
    }
    Ok(())
}

fn check_map(map: &MapSection) -> Result<(), Problem> {
    const SECTION: &str = "vibration.map";
    for (key, name, (from, to, cells)) in [("x", map.over.axes()[0], map.x), ("y", map.over.axes()[1], map.y)] {
        // Damping and scatter may begin with none.
        let (least, most) = match name {
            "damping_ratio" => (0.0, 1.0),
            "friction_std" => (0.0, f64::INFINITY),
            _ => (f64::MIN_POSITIVE, f64::INFINITY),
        };
        let wanted = format!("values of {name} from {} on, in rising order", if least > 0.0 { "above 0" } else { "0" });
        within(SECTION, key, from, |value| value >= least && value < most, &wanted)?;
        within(SECTION, key, to, |value| value > from && value < most, &wanted)?;
        at_least(SECTION, key, cells, 1)?;
        if cells > 1000 {
            return Err(problem(SECTION, key, format!("found {cells} cells, wanted at most 1000")));
        }
    }
    within(SECTION, "depth", f64::from(map.depth), |depth| depth <= 8.0, "at most 8")?;
    at_least(SECTION, "trajectories", map.trajectories, 2)
}
