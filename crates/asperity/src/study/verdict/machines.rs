//! Machines of sampled values.

use serde::Deserialize;
use thiserror::Error;
use toml::{Table, Value};

use super::responses::FrictionResponses;
use crate::chaos::UncertainInputs;
use crate::friction::WindowFriction;
use crate::random;
use crate::study::StudyFile;
use crate::study::check::{FrictionSource, VerdictStudy, VibrationStudy};
use crate::study::file::Hold;
use crate::study::uncertain::Place;
use crate::vibration::Oscillator;

/// Stream of the standard normal variables of the samples.
const STREAM: &str = "study/verdict";
/// Coefficients of the friction law per unit of dimensionless velocity, and the dimensionless velocity of the belt, with the
/// power of the unit of velocity that they are proportional to.
const DIMENSIONLESS: [(&str, i32); 3] = [("stribeck", 1), ("linear_weakening", 1), ("dimensionless_belt_velocity", -1)];

/// Reason why a machine has no answer.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{0}")]
pub(super) struct NoAnswer(pub(super) String);

/// Machine with exact values.
#[derive(Debug, Clone)]
pub(super) struct Machine {
    pub(super) study: VibrationStudy,
    pub(super) oscillator: Oscillator,
    /// Friction of one window.
    pub(super) window: WindowFriction,
}

/// Change of one value of all machines.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    pub(super) place: Place,
    pub(super) value: f64,
    pub(super) hold: Hold,
}

/// All machines of a study: its values are exact or have a joint distribution.
#[derive(Clone)]
pub(super) struct Machines<'a> {
    /// The sections that decide the vibration, with central values.
    central: Table,
    inputs: UncertainInputs,
    places: &'a [Place],
    /// Friction of the machine with all values at their centres.
    window: &'a WindowFriction,
    /// Friction as a function of the values that change the contact.
    responses: Option<&'a FrictionResponses>,
    /// Factor of the mean friction coefficient.
    friction_factor: f64,
    changes: Vec<Change>,
    seed: u64,
}

impl<'a> Machines<'a> {
    pub(super) fn new(
        study: &'a VerdictStudy,
        window: &'a WindowFriction,
        responses: Option<&'a FrictionResponses>,
        seed: u64,
    ) -> Self {
        let mut central = study.central.clone();
        if !window.computed {
            central.retain(|section, _| matches!(section, "seed" | "vibration"));
        }
        central.retain(|section, _| section != "verdict" && section != "uncertainty");
        Self {
            central,
            inputs: study.inputs.clone(),
            places: &study.places,
            window,
            responses,
            friction_factor: 1.0,
            changes: Vec::new(),
            seed,
        }
    }

    /// Returns the number of uncertain values.
    pub(super) fn variables(&self) -> usize {
        self.inputs.inputs().len()
    }

    pub(super) fn inputs(&self) -> &UncertainInputs {
        &self.inputs
    }

    pub(super) fn places(&self) -> &[Place] {
        self.places
    }

    /// Returns the central value of a number or quantity in SI.
    pub(super) fn central_value(&self, place: Place) -> f64 {
        match self.places.iter().position(|uncertain| *uncertain == place) {
            Some(input) => self.inputs.inputs()[input].central(),
            None => place.value_in(&self.central).unwrap_or(f64::NAN),
        }
    }

    /// Returns the value of a number or quantity at a point of the standard normal variables.
    pub(super) fn value_of(&self, place: Place, variables: &[f64]) -> f64 {
        if let Some(input) = self.places.iter().position(|uncertain| *uncertain == place) {
            return self.inputs.values(variables)[input];
        }
        let changed = self.changes.iter().find(|change| change.place == place).map(|change| change.value);
        changed.or_else(|| place.value_in(&self.central)).unwrap_or(f64::NAN)
    }

    /// Returns the same machines with other distributions of their values.
    pub(super) fn with_inputs(&self, inputs: UncertainInputs) -> Self {
        Self { inputs, ..self.clone() }
    }

    /// Returns the same machines with another mean friction coefficient.
    pub(super) fn with_friction_factor(&self, friction_factor: f64) -> Self {
        Self { friction_factor, ..self.clone() }
    }

    /// Returns the same machines with exact values changed.
    pub(super) fn with_changes(&self, changes: Vec<Change>) -> Self {
        Self { changes, ..self.clone() }
    }

    /// Returns the independent standard normal variables of sample `index`.
    pub(super) fn variables_of(&self, index: usize) -> Vec<f64> {
        random::standard_normal(&mut random::stream(self.seed, STREAM, index as u64), self.variables())
    }

    /// Returns the machine with all values at their centres.
    pub(super) fn nominal(&self) -> Result<Machine, String> {
        let values: Vec<f64> = self.inputs.inputs().iter().map(|input| input.central()).collect();
        self.with_values(&values)
    }

    /// Returns the machine of independent standard normal variables.
    pub(super) fn at(&self, variables: &[f64]) -> Result<Machine, String> {
        self.with_values(&self.inputs.values(variables))
    }

    /// Returns the machine with these values in SI.
    fn with_values(&self, values: &[f64]) -> Result<Machine, String> {
        let mut table = self.central.clone();
        let mut before = damper(&table);
        self.places.iter().zip(values).for_each(|(place, value)| place.set(&mut table, *value));
        for change in &self.changes {
            change.place.set(&mut table, change.value);
            let after = damper(&table);
            if change.hold == Hold::Damper {
                // c = 2ζmω₀ stays.
                scale(&mut table, "damping_ratio", before / after);
            }
            before = after;
        }
        let ratio = velocity_unit(&table) / velocity_unit(&self.central);
        for (key, power) in DIMENSIONLESS {
            scale(&mut table, key, ratio.powi(power));
        }
        let mut window = match self.responses {
            Some(responses) => responses.at(&table, self.window),
            None => self.window.clone(),
        };
        let file = StudyFile::deserialize(table).map_err(|error| error.message().to_owned())?;
        let study = file.check_vibration().map_err(|error| error.to_string())?.ok_or("no vibration")?;
        window.stribeck = window.stribeck.map(|rate| rate * ratio);
        if let FrictionSource::Stated(stated) = &study.friction {
            let area_m2 = study.nominal_contact().area_m2;
            window = WindowFriction::from_statement(stated.clone(), area_m2, study.dimensionless_stribeck());
        }
        window.mean *= self.friction_factor;
        let oscillator = study.oscillator(window.mean, window.stribeck).map_err(|error| error.to_string())?;
        Ok(Machine { study, oscillator, window })
    }
}

/// Returns a number of [vibration] in SI; 1 if the study does not state it.
fn number(table: &Table, key: &str) -> f64 {
    Place::named(&format!("vibration.{key}"), table).and_then(|place| place.value_in(table)).unwrap_or(1.0)
}

/// Returns mω₀, to which the damper of a damping ratio is proportional.
fn damper(table: &Table) -> f64 {
    number(table, "mass") * number(table, "natural_frequency")
}

/// Returns the unit of velocity N/(mω₀).
fn velocity_unit(table: &Table) -> f64 {
    number(table, "normal_force") / damper(table)
}

/// Multiplies a dimensionless number of [vibration], if the study states it.
fn scale(table: &mut Table, key: &str, factor: f64) {
    if factor == 1.0 {
        return;
    }
    match table.get_mut("vibration").and_then(|section| section.get_mut(key)) {
        Some(Value::Float(number)) => *number *= factor,
        Some(place @ Value::Integer(_)) => {
            if let Value::Integer(number) = *place {
                *place = Value::Float(number as f64 * factor);
            }
        }
        _ => {}
    }
}
