//! Values with units of the dimensionless vibration commands: converted before the flags are parsed.

use std::ffi::OsString;

use asperity::choice::Choice;
use asperity::keys::{KEYS, Key, SCALES};
use asperity::quantity::{AngularFrequency, Dimension, Force, Mass};
use asperity::sentence;
use asperity::vibration::{CurveParameter, Scales};
use clap::Args;

use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;

/// Flags that are no inputs of a study, and the SI units that their values may have.
pub(crate) const FLAGS_WITH_UNITS: [(&str, &str); 11] = [
    ("belt_velocities", "m/s"),
    ("correlation_length", "m"),
    ("displacements", "m"),
    ("duration", "s"),
    ("forcing", "N"),
    ("forcing_frequency", "rad/s"),
    ("friction_step", "m"),
    // Of a sound; without a parameter that the range is over.
    ("from", "s"),
    ("settling", "s"),
    ("start", "m"),
    ("velocities", "m/s"),
];

/// The machine in SI, for values with units.
#[derive(Debug, Args)]
#[command(next_help_heading = "Values with units, such as --belt-velocity 20mm/s")]
pub(super) struct Units {
    /// Mass m.
    #[arg(long, global = true, value_name = "Q", value_parser = args::positive_quantity::<Mass>, allow_hyphen_values = true)]
    mass: Option<Mass>,
    /// Natural frequency ω₀, such as 100Hz or 628rad/s.
    #[arg(long, global = true, value_name = "Q", value_parser = args::positive_quantity::<AngularFrequency>, allow_hyphen_values = true)]
    pub(super) natural_frequency: Option<AngularFrequency>,
    /// Normal force N.
    #[arg(long, global = true, value_name = "Q", value_parser = args::positive_quantity::<Force>, allow_hyphen_values = true)]
    normal_force: Option<Force>,
}

impl Units {
    /// Prints the units of the answer. The natural frequency may stand alone if it is that of a sound file.
    ///
    /// # Errors
    /// Only a part of the machine is stated.
    pub(super) fn note(&self, writes_wav: bool, monitor: &Terminal) -> Result<(), Failure> {
        let scales = match (self.mass, self.natural_frequency, self.normal_force) {
            (None, None, None) => return Ok(()),
            (None, Some(_), None) if writes_wav => return Ok(()),
            (Some(mass), Some(frequency), Some(force)) => Scales::new(mass.0, frequency.0, force.0)?,
            _ => return Err(Failure::usage(WANTED)),
        };
        monitor.note(&format!(
            "the unit of lengths is {}, of times {}, of velocities {}",
            sentence::si(scales.length_m(), "m"),
            sentence::si(scales.time_s(), "s"),
            sentence::si(scales.velocity_m_per_s(), "m/s")
        ));
        Ok(())
    }
}

const WANTED: &str = "values with units require all of --mass, --natural-frequency and --normal-force";

/// Converts the values with units of the flags of a vibration command to dimensionless numbers. Leaves all other arguments as they are.
///
/// # Errors
/// A value has a unit, but the machine is not stated in SI.
pub(crate) fn dimensionless(arguments: Vec<OsString>) -> Result<Vec<OsString>, Failure> {
    let is_vibration = arguments.iter().skip(1).find(|argument| {
        let text = argument.to_string_lossy();
        !text.starts_with('-') && text.parse::<usize>().is_err()
    });
    if is_vibration.is_none_or(|command| command != "vibration") {
        return Ok(arguments);
    }
    let is_given = |flag: &str| arguments.iter().any(|argument| argument.to_string_lossy().starts_with(flag));
    let scales = stated_scales(&arguments);
    // The parser of the flags reports a wrong value, and prints the help.
    if is_given("--help")
        || arguments.iter().any(|argument| argument == "-h")
        || scales.is_none() && SCALES.iter().all(|input| is_given(&flag_of(input)))
    {
        return Ok(arguments);
    }
    // A range of values of a parameter has the unit of the parameter.
    let over = value_of(&arguments, "--over");
    let unit_of = |flag: &str| match &over {
        Some(parameter) if ["from", "to"].contains(&flag) => CurveParameter::from_name(parameter).ok()?.unit(),
        _ => unit_of(flag),
    };
    let mut converted = Vec::with_capacity(arguments.len());
    let mut unit = None;
    for argument in arguments {
        let Some(text) = argument.to_str() else {
            converted.push(argument);
            continue;
        };
        let (flag, value) = match (unit.take(), text.strip_prefix("--")) {
            (Some(unit), _) => (String::new(), Some((unit, text))),
            (None, Some(long)) => match long.split_once('=') {
                Some((name, value)) => (format!("--{name}="), unit_of(name).map(|unit| (unit, value))),
                None => {
                    unit = unit_of(long);
                    (String::new(), None)
                }
            },
            (None, None) => (String::new(), None),
        };
        let number = value.map(|(unit, value)| numbers(value, unit, scales.as_ref())).transpose()?.flatten();
        converted.push(number.map_or(argument, |number| OsString::from(flag + &number)));
    }
    let is_given =
        |flag: &str| converted.iter().any(|argument: &OsString| argument.to_string_lossy().starts_with(flag));
    if let Some(scales) = scales
        && is_given("--friction-process")
        && !is_given("--length-unit")
    {
        converted.extend(["--length-unit".into(), format!("{:?} m", scales.length_m()).into()]);
    }
    Ok(converted)
}

/// Returns the flag of an input.
fn flag_of(input: &'static str) -> String {
    format!("--{}", args::name(input).replace('_', "-"))
}

/// Returns the value of a flag.
fn value_of(arguments: &[OsString], flag: &str) -> Option<String> {
    let place = arguments.iter().position(|argument| argument.to_string_lossy().starts_with(flag))?;
    match arguments[place].to_string_lossy().strip_prefix(flag)?.strip_prefix('=') {
        Some(value) => Some(value.to_owned()),
        None => Some(arguments.get(place + 1)?.to_string_lossy().into_owned()),
    }
}

/// Returns the machine that the flags state.
fn stated_scales(arguments: &[OsString]) -> Option<Scales> {
    let si = |flag: &str, unit| Dimension::of_unit(unit)?.parse(&value_of(arguments, flag)?).ok();
    let [mass, frequency, force] = SCALES.map(|input| si(&flag_of(input), Key::find(input)?.unit));
    Scales::new(mass?, frequency?, force?).ok()
}

/// Returns the SI unit that the values of a flag may have.
fn unit_of(flag: &str) -> Option<&'static str> {
    let flag = flag.replace('-', "_");
    let of_key = KEYS.iter().filter(|key| key.section == "vibration").find_map(|key| {
        let own = key.name.strip_prefix("dimensionless_").unwrap_or(key.name);
        match (key.velocity_power, key.unit) {
            _ if own != flag || SCALES.contains(&key.path().as_str()) => None,
            (1, _) => Some("s/m"),
            (-1, _) => Some("m/s"),
            (_, unit) => Some(unit).filter(|unit| !unit.is_empty()),
        }
    });
    of_key.or_else(|| FLAGS_WITH_UNITS.iter().find(|(name, _)| *name == flag).map(|(_, unit)| *unit))
}

/// Converts a value, or the first and the last value of a range `FROM,TO,N`; `None` if it has no unit of this kind.
fn numbers(text: &str, unit: &str, scales: Option<&Scales>) -> Result<Option<String>, Failure> {
    let Some(dimension) = Dimension::of_unit(unit) else { return Ok(None) };
    let parts: Vec<&str> = text.split(',').collect();
    let found: Vec<Option<f64>> = parts.iter().map(|part| dimension.parse(part).ok()).collect();
    if found.iter().all(Option::is_none) {
        return Ok(None);
    }
    let scales = scales.ok_or_else(|| Failure::usage(format_args!("`{text}` has a unit: {WANTED}")))?;
    let number = |(part, si): (&&str, Option<f64>)| {
        let number = si.and_then(|si| scales.dimensionless(si, unit));
        number.map_or_else(|| (*part).to_owned(), |number| format!("{number:?}"))
    };
    Ok(Some(parts.iter().zip(found).map(number).collect::<Vec<_>>().join(",")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lengths in units of 1/128 m, times in 1/8 s, velocities in 1/16 m/s.
    const MACHINE: &str = "--mass 4kg --natural-frequency=8rad/s --normal-force 2N";

    fn of(line: &str) -> Result<String, Failure> {
        let arguments = line.split_whitespace().map(OsString::from).collect();
        let found = dimensionless(arguments)?;
        Ok(found.iter().map(|argument| argument.to_str().unwrap()).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn values_with_units_become_numbers_in_units_of_the_machine() {
        for (given, number) in [
            ("--belt-velocity 0.125m/s", "--belt-velocity 2.0"),
            ("--belt-velocity=0.125m/s", "--belt-velocity=2.0"),
            ("--belt-velocities 0.0625m/s,0.25m/s,8", "--belt-velocities 1.0,4.0,8"),
            ("--stribeck 16s/m", "--stribeck 1.0"),
            ("--linear-weakening 4s/m", "--linear-weakening 0.25"),
            ("--stribeck-velocity 0.25m/s", "--stribeck-velocity 4.0"),
            ("--duration 2s", "--duration 16.0"),
            ("--correlation-length 0.5m", "--correlation-length 64.0"),
            ("--forcing 0.5N", "--forcing 0.25"),
            ("--forcing-frequency 4rad/s", "--forcing-frequency 0.5"),
            ("--from=2s", "--from=16.0"),
            ("--over belt_velocity --from 0.0625m/s --to 0.25m/s", "--over belt_velocity --from 1.0 --to 4.0"),
            ("--from 0.5N --over=forcing_amplitude --to=1N", "--from 0.25 --over=forcing_amplitude --to=0.5"),
            ("--over damping_ratio --from 0.1 --to 0.2", "--over damping_ratio --from 0.1 --to 0.2"),
            // Numbers, units of another kind and other flags stay.
            ("--belt-velocity 0.003", "--belt-velocity 0.003"),
            ("--belt-velocity 5mm", "--belt-velocity 5mm"),
            ("--damping-ratio 5mm", "--damping-ratio 5mm"),
        ] {
            let found = of(&format!("asperity --threads 2 vibration cycle {MACHINE} {given}")).unwrap();
            assert_eq!(found, format!("asperity --threads 2 vibration cycle {MACHINE} {number}"));
        }
        let fitted = of(&format!("asperity vibration sound {MACHINE} --friction-process a.json")).unwrap();
        assert!(fitted.ends_with("a.json --length-unit 0.0078125 m"), "{fitted}");
        assert_eq!(
            of("asperity run vibration --belt-velocity 5mm/s").unwrap(),
            "asperity run vibration --belt-velocity 5mm/s"
        );
    }

    #[test]
    fn a_unit_without_the_whole_machine_is_refused() {
        let error = of("asperity vibration cycle --mass 4kg --belt-velocity 5mm/s").unwrap_err().to_string();
        assert!(error.contains("`5mm/s` has a unit") && error.contains("--natural-frequency"), "{error}");
    }
}
