//! Flags of the friction over the velocity: those of a law are its inputs in a study.

use std::path::{Path, PathBuf};

use asperity::choice::Choice;
use asperity::friction::measured::ColumnTable;
use asperity::keys::Key;
use asperity::keys::STATIC_FRICTION as STATIC;
use asperity::statement::Stated;
use asperity::vibration::VelocityLaw;
use asperity::vibration::law::VelocityLawKind;
use asperity_formats::read_limited;
use clap::error::ErrorKind;
use clap::{Arg, ArgGroup, ArgMatches, Args, Command, FromArgMatches, value_parser};

use crate::args;
use crate::failure::{Failure, Kind};

const KINETIC: &str = "vibration.kinetic_share";

/// Stick limit, and friction in sliding.
#[derive(Debug)]
pub(super) struct Friction {
    pub(super) static_friction: f64,
    kinetic_friction: Option<f64>,
    kind: VelocityLawKind,
    /// Inputs of the law, and their values.
    numbers: Vec<(&'static str, f64)>,
    /// File of a law of points.
    table: Option<PathBuf>,
}

/// Returns the flag that states a law: its first input.
fn first(kind: VelocityLawKind) -> &'static str {
    args::name(kind.statement().inputs[0])
}

/// Returns whether an input is a table of points, and its flag that of a file.
fn is_table(input: &str) -> bool {
    Key::find(input).is_none()
}

/// Returns the number that stands for an input which is left out.
fn default(input: &str) -> Option<f64> {
    Key::find(input)?.default?.value.number()
}

/// Returns the flag of an input.
fn flag(input: &'static str, note: &str) -> Arg {
    let name = args::name(input);
    let arg = Arg::new(name).long(name.replace('_', "-"));
    if is_table(input) {
        let help = format!("Table of two columns, velocity from 0 upwards and friction coefficient{note}");
        return arg.value_name("FILE").value_parser(value_parser!(PathBuf)).help(help);
    }
    let help = args::help(input, note);
    arg.value_name("X").allow_hyphen_values(true).value_parser(args::of_input(input)).help(help)
}

impl Args for Friction {
    fn augment_args(command: Command) -> Command {
        let kinetic = flag(KINETIC, " at vanishing velocity; the static one when left out");
        let mut command = command.arg(flag(STATIC, " at rest, the stick limit").required(true)).arg(kinetic);
        for kind in VelocityLawKind::ALL {
            let (own, inputs) = (first(*kind), kind.statement().inputs);
            let more = inputs[1..].iter().filter(|input| default(input).is_none()).map(|input| args::name(input));
            let note = format!("; {}", kind.description().trim_end_matches('.'));
            let law = more.fold(flag(inputs[0], &note), Arg::requires);
            command = command.arg(if is_table(inputs[0]) { law.conflicts_with(args::name(KINETIC)) } else { law });
            let others = VelocityLawKind::ALL.iter().filter(|other| *other != kind).map(|other| first(*other));
            for input in &inputs[1..] {
                let note = format!(", with --{}", own.replace('_', "-"));
                command = command.arg(flag(input, &note).requires(own).conflicts_with_all(others.clone()));
            }
        }
        command.group(ArgGroup::new("law").args(VelocityLawKind::ALL.iter().map(|kind| first(*kind))).required(true))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Friction {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let number = |input| matches.get_one::<f64>(args::name(input)).copied();
        let missing = || clap::Error::new(ErrorKind::MissingRequiredArgument);
        let kind = *VelocityLawKind::ALL.iter().find(|kind| matches.contains_id(first(**kind))).ok_or_else(missing)?;
        let (tables, numbers): (Vec<&'static str>, Vec<_>) =
            kind.statement().inputs.iter().partition(|input| is_table(input));
        Ok(Self {
            static_friction: number(STATIC).ok_or_else(missing)?,
            kinetic_friction: number(KINETIC),
            kind,
            numbers: numbers.into_iter().filter_map(|input| Some((input, number(input)?))).collect(),
            table: tables.first().and_then(|input| matches.get_one(args::name(input)).cloned()),
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Friction {
    /// Returns the input files.
    pub(super) fn inputs(&self) -> Vec<&Path> {
        self.table.as_deref().into_iter().collect()
    }

    pub(super) fn law(&self) -> Result<VelocityLaw, Failure> {
        let points = self.table.as_deref().map(table).transpose()?;
        (self.kind.statement().law)(&Values { flags: self, points }).map_err(|error| match &self.table {
            Some(path) => Failure::data(path.display(), &error),
            None => Failure::usage(error),
        })
    }
}

/// Values of the flags. Friction coefficients are stated as they are.
struct Values<'a> {
    flags: &'a Friction,
    points: Option<Vec<[f64; 2]>>,
}

impl Stated for Values<'_> {
    fn number(&self, input: &str) -> Option<f64> {
        let stated = self.flags.numbers.iter().find(|(name, _)| *name == input);
        stated.map(|(_, value)| *value).or_else(|| default(input))
    }

    fn kinetic(&self) -> f64 {
        self.flags.kinetic_friction.unwrap_or(self.flags.static_friction)
    }

    fn points(&self, _: &str) -> Option<Vec<[f64; 2]>> {
        self.points.clone()
    }
}

/// Reads the points of a friction law: a table of two columns.
fn table(path: &Path) -> Result<Vec<[f64; 2]>, Failure> {
    let bytes = read_limited(path).map_err(|e| Failure::io(Kind::Data, path.display(), &e))?;
    let points = |table: ColumnTable| {
        let (velocities, coefficients) = (table.values(0)?, table.values(1)?);
        Ok(velocities.iter().zip(coefficients).map(|(v, mu)| [*v, *mu]).collect())
    };
    match ColumnTable::read(&bytes) {
        Ok(table) if table.names().len() != 2 => {
            let message = format!("{}: expected two columns, a velocity and a friction coefficient", path.display());
            Err(Failure::new(Kind::Data, message))
        }
        table => table.and_then(points).map_err(|e| Failure::data(path.display(), &e)),
    }
}
