//! Machines of sampled values.

use std::sync::Arc;

use thiserror::Error;

use super::dynamics::Dynamics;
use super::replicates::{REPLICATES, designs};
use super::responses::FrictionResponses;
use super::scan::is_change;
use super::sharing::Sharing;
use crate::chaos::{Design, InputError, UncertainInput, UncertainInputs};
use crate::distribution::Marginal;
use crate::friction::{MeanErrors, Upscaling, WindowFriction};
use crate::study::StudyFile;
use crate::study::check::{FrictionSource, MachineInputs, VerdictStudy};
use crate::study::file::{Hold, MachineModel};
use crate::study::uncertain::{BETWEEN_PARTS, CUT_OFF, Place, Point, numbers};

/// Number of samples that can be drawn.
const MOST_SAMPLES: usize = u32::MAX as usize;
/// Stream of the standard normal variables of the samples.
const STREAM: &str = "study/verdict";

/// Reason why a machine has no answer.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{0}")]
pub(super) struct NoAnswer(pub(super) String);

/// Machine with exact values.
#[derive(Debug, Clone)]
pub(super) struct Machine {
    pub(super) inputs: MachineInputs,
    pub(super) dynamics: Dynamics,
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
    /// The central values, of the sections that decide the vibration.
    central: Point,
    inputs: UncertainInputs,
    places: &'a [Place],
    /// Friction of the machine with all values at their centres.
    window: &'a WindowFriction,
    /// Friction as a function of the values that change the contact.
    responses: Option<&'a FrictionResponses>,
    /// Value to which this friction is proportional, and its central value.
    proportional: Option<(Place, f64)>,
    /// Whether the Stribeck coefficient is that of a friction process from a file, not that of the study.
    process_has_stribeck: bool,
    /// Place of the differences between the parts of a rough slider.
    between_parts: Option<Place>,
    /// Place of the shortest wave, if the scan leaves it unknown.
    cut_off: Option<Place>,
    /// Places of the changes of ln μ by errors of the scans that are factors of friction.
    changes_by_scans: Vec<Place>,
    /// Windows that share the load; `None` for those of the study.
    sharing: Option<Sharing>,
    /// Factor of the mean friction coefficient.
    friction_factor: f64,
    changes: Vec<Change>,
    /// Distributions of the values with which the machines have their dampers, if these stay.
    dampers: Option<UncertainInputs>,
    /// Independently scrambled Sobol' points of the samples; `None` if no value is uncertain.
    designs: Option<Arc<[Design]>>,
}

impl<'a> Machines<'a> {
    pub(super) fn new(
        study: &'a VerdictStudy,
        window: &'a WindowFriction,
        responses: Option<&'a FrictionResponses>,
        seed: u64,
    ) -> Self {
        let mut central = study.central.clone();
        central.file.pressure = None;
        let stated = central.machine().ok().and_then(|machine| machine.dimensionless_stribeck());
        Self {
            proportional: study
                .proportional
                .filter(|_| window.computed)
                .and_then(|place| Some((place, place.value_in(&central)?))),
            process_has_stribeck: window.stribeck != stated,
            central,
            inputs: study.inputs.clone(),
            places: &study.places,
            window,
            responses,
            between_parts: study.places.iter().copied().find(|place| place.name() == BETWEEN_PARTS),
            cut_off: study
                .places
                .iter()
                .copied()
                .find(|place| place.name() == CUT_OFF && !window.mean_errors.cut_off.is_empty()),
            changes_by_scans: study
                .places
                .iter()
                .copied()
                .filter(|place| is_change(*place))
                .filter(|place| responses.is_none_or(|own| own.axes.iter().all(|axis| axis.place != *place)))
                .collect(),
            sharing: None,
            friction_factor: 1.0,
            changes: Vec::new(),
            dampers: None,
            designs: designs(study.places.len(), MOST_SAMPLES, seed, STREAM).ok().map(Arc::from),
        }
    }

    /// Returns the model of all machines.
    pub(super) fn model(&self) -> MachineModel {
        self.central.file.vibration.as_ref().map(|section| section.model).unwrap_or_default()
    }

    /// Returns the study file of the machine with all values at their centres.
    pub(super) fn central(&self) -> &Point {
        &self.central
    }

    /// Returns the errors of the mean friction that all machines share.
    pub(super) fn mean_errors(&self) -> &MeanErrors {
        &self.window.mean_errors
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

    /// Returns the central value of a number or quantity in SI; `None` if the machine does not depend on it.
    pub(super) fn central_value(&self, place: Place) -> Option<f64> {
        match self.places.iter().position(|uncertain| *uncertain == place) {
            Some(input) => Some(self.inputs.inputs()[input].central()),
            None => place.value_in(&self.central),
        }
    }

    /// Returns the value of a number or quantity at a point of the standard normal variables; `None` if the machine does not depend on it.
    pub(super) fn value_of(&self, place: Place, variables: &[f64]) -> Option<f64> {
        if let Some(input) = self.places.iter().position(|uncertain| *uncertain == place) {
            return Some(self.inputs.values(variables)[input]);
        }
        let changed = self.changes.iter().find(|change| change.place == place).map(|change| change.value);
        changed.or_else(|| place.value_in(&self.central))
    }

    /// Returns the same machines with other distributions of their values. With `hold` each machine keeps the damper that it has with the
    /// present ones.
    pub(super) fn with_inputs(&self, inputs: UncertainInputs, hold: Hold) -> Self {
        let dampers = (hold == Hold::Damper).then(|| self.inputs.clone());
        Self { inputs, dampers, ..self.clone() }
    }

    /// Returns the same machines with other windows that share the load.
    pub(super) fn with_sharing(&self, sharing: Sharing) -> Self {
        Self { sharing: Some(sharing), ..self.clone() }
    }

    /// Returns the same machines with another mean friction coefficient.
    pub(super) fn with_friction_factor(&self, friction_factor: f64) -> Self {
        Self { friction_factor, ..self.clone() }
    }

    /// Returns the same machines with exact values changed.
    pub(super) fn with_changes(&self, changes: Vec<Change>) -> Self {
        Self { changes, ..self.clone() }
    }

    /// Returns the independent standard normal variables of sample `index`. The samples of all replicates take turns.
    pub(super) fn variables_of(&self, index: usize) -> Vec<f64> {
        let designs = self.designs.as_ref();
        designs.map_or_else(Vec::new, |designs| designs[index % REPLICATES].xi(index / REPLICATES))
    }

    /// Returns the machine with all values at their centres.
    pub(super) fn nominal(&self) -> Result<Machine, String> {
        // The printed friction is that of the waves of the strips.
        let of_strips = self.window.mean_errors.cut_off.first().map(|at| at.shortest_m);
        let cut_off = self.places.iter().position(|place| Some(*place) == self.cut_off).zip(of_strips);
        let central = |inputs: &UncertainInputs| {
            let mut values: Vec<f64> = inputs.inputs().iter().map(UncertainInput::central).collect();
            if let Some((index, longest_m)) = cut_off {
                values[index] = longest_m;
            }
            values
        };
        let values = central(&self.inputs);
        self.with_values(&values, self.dampers.as_ref().map(central).as_deref().unwrap_or(&values))
    }

    /// Returns the machine of independent standard normal variables.
    pub(super) fn at(&self, variables: &[f64]) -> Result<Machine, String> {
        let values = self.inputs.values(variables);
        let dampers = self.dampers.as_ref().map(|inputs| inputs.values(variables));
        self.with_values(&values, dampers.as_deref().unwrap_or(&values))
    }

    /// Returns the point of independent standard normal variables.
    pub(super) fn point_at(&self, variables: &[f64]) -> Point {
        let values = self.inputs.values(variables);
        self.point_of(&values, &values).0
    }

    /// Returns the point of values in SI, and the unit of velocity over that of the central values. The machine has its damper with the
    /// values `dampers`.
    fn point_of(&self, values: &[f64], dampers: &[f64]) -> (Point, f64) {
        let mut point = self.central.clone();
        let mut set = |values: &[f64]| {
            self.places.iter().zip(values).for_each(|(place, value)| place.set(&mut point, *value));
            point.damper()
        };
        let (first, mut before) = (set(dampers), set(values));
        // c = 2ζmω₀ stays.
        point.scale_damping(first / before);
        for change in &self.changes {
            change.place.set(&mut point, change.value);
            let after = point.damper();
            if change.hold == Hold::Damper {
                point.scale_damping(before / after);
            }
            before = after;
        }
        let ratio = point.velocity_unit() / self.central.velocity_unit();
        keep_velocities(&mut point.file, ratio);
        (point, ratio)
    }

    /// Returns the machine with these values in SI.
    fn with_values(&self, values: &[f64], dampers: &[f64]) -> Result<Machine, String> {
        let (point, ratio) = self.point_of(values, dampers);
        let mut window = match self.responses {
            Some(responses) => responses.at(&point, self.window),
            None => self.window.clone(),
        };
        if let Some((place, central)) = self.proportional {
            window = window.scaled(place.value_in(&point).map_or(1.0, |value| value / central));
        }
        let part = self.between_parts.and_then(|place| place.value_in(&point));
        let shortest_m = self.cut_off.and_then(|place| place.value_in(&point));
        let mut inputs = point.machine()?;
        window.stribeck = match &inputs.friction {
            FrictionSource::File(_) if self.process_has_stribeck => window.stribeck.map(|rate| rate * ratio),
            _ => inputs.dimensionless_stribeck(),
        };
        match &inputs.friction {
            FrictionSource::Stated(stated) if stated.std > 0.0 => {
                let area_m2 = inputs.nominal_contact().area_m2;
                window = WindowFriction::from_statement(stated.clone(), area_m2, window.stribeck);
            }
            FrictionSource::Stated(stated) => (window.mean, window.std) = (stated.mean, 0.0),
            FrictionSource::Computed(_) | FrictionSource::File(_) => {}
        }
        if let Some(sharing) = self.sharing {
            inputs.upscaling = Upscaling::Area;
            window.variance_reduction = sharing.variance_reduction(&window);
        }
        let by_scans: f64 = self.changes_by_scans.iter().filter_map(|place| place.value_in(&point)).sum();
        let mut factors = [self.friction_factor * by_scans.exp(); 2];
        if let Some(normal) = part {
            // A lognormal factor of mean 1.
            let reduction = if inputs.upscaling == Upscaling::Area { window.variance_reduction } else { 1.0 };
            let std = (window.between_parts_std / window.mean).powi(2).mul_add(reduction, 1.0).ln().sqrt();
            factors = factors.map(|factor| factor * (std * normal - 0.5 * std * std).exp());
        }
        if let Some(of_waves) = shortest_m.and_then(|shortest_m| self.window.mean_errors.at_cut_off(shortest_m)) {
            factors = [factors[0] * of_waves.mean, factors[1] * of_waves.std];
        }
        window.mean *= factors[0];
        window.std *= factors[1];
        let dynamics = Dynamics::new(&inputs, &window).map_err(|error| error.to_string())?;
        if let Dynamics::StickSlip(oscillator) = &dynamics {
            inputs.check_motion(oscillator, f64::INFINITY).map_err(|error| error.to_string())?;
        }
        Ok(Machine { inputs, dynamics, window })
    }
}

/// Returns the standard normal value that stands for the differences between the parts of a rough slider; `None` if it has none.
pub(super) fn between_parts(window: &WindowFriction) -> Result<Option<(Place, UncertainInput)>, InputError> {
    let place = Place::latent(BETWEEN_PARTS).filter(|_| window.between_parts_std > 0.0);
    place.map(|place| Ok((place, UncertainInput::new(BETWEEN_PARTS, Marginal::STANDARD_NORMAL, false)?))).transpose()
}

/// Number of shortest waves with equal ratios. Their empirical distribution has half of the inverse at each end, so that its 5 % and 95 %
/// quantiles, between which unknown values range, are the ends: the waves of most surfaces continue to the pixel and beyond.
const WAVES: u32 = 10;

/// Returns the shortest wave of the surface, unknown between those that the strips have and twice the pixel of the scan; `None` if it does
/// not matter.
pub(super) fn cut_off(window: &WindowFriction) -> Result<Option<(Place, UncertainInput)>, InputError> {
    let waves = &window.mean_errors.cut_off;
    let Some([longest_m, shortest_m]) = waves.first().zip(waves.last()).map(|(a, b)| [a, b].map(|at| at.shortest_m))
    else {
        return Ok(None);
    };
    let part = |index: u32| f64::from(index) / f64::from(WAVES - 1);
    let waves_m = (0..WAVES).map(|index| shortest_m * (longest_m / shortest_m).powf(part(index))).collect();
    let place = Place::latent(CUT_OFF).zip(Marginal::empirical(waves_m).ok());
    place.map(|(place, marginal)| Ok((place, UncertainInput::new(CUT_OFF, marginal, true)?))).transpose()
}

impl Point {
    fn machine(&self) -> Result<MachineInputs, String> {
        self.file.machine().map_err(|error| error.to_string())?.ok_or_else(|| "no vibration".into())
    }

    /// Returns mω₀, to which the damper of a damping ratio is proportional.
    fn damper(&self) -> f64 {
        self.file.vibration.as_ref().map_or(1.0, |section| section.mass.0 * section.natural_frequency.0)
    }

    /// Returns the unit of velocity N/(mω₀).
    fn velocity_unit(&self) -> f64 {
        self.file.vibration.as_ref().map_or(1.0, |section| section.normal_force.0 / self.damper())
    }

    fn scale_damping(&mut self, factor: f64) {
        if let Some(section) = &mut self.file.vibration {
            section.damping_ratio *= factor;
        }
    }
}

/// Converts the coefficients of the friction law per unit of dimensionless velocity, and the dimensionless velocity of the belt, to a unit
/// that is `ratio` times as large, so that they stay the same in SI.
fn keep_velocities(file: &mut StudyFile, ratio: f64) {
    for (key, access) in numbers().filter(|(key, _)| key.velocity_power != 0) {
        if let Some(value) = access.get(file, key, None) {
            access.set(file, key, None, value * ratio.powi(key.velocity_power));
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Machine that vibrates if ζ − b/2 < 0.
    pub(in crate::study::verdict) const LINEAR: &str = "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
        nominal_area = \"833 mm^2\"\nstatic_friction = 0.3\nfriction_std = 0\ndimensionless_belt_velocity = 0.1\n\
        velocity_law = \"linear\"\nlinear_weakening = \"0.1 ± 0.02\"\ndamping_ratio = \"0.055 ± 0.005\"\n";

    /// Returns the friction that a study states.
    pub(in crate::study::verdict) fn stated_window(study: &Study) -> WindowFriction {
        let vibration = study.vibration.as_ref().unwrap();
        let FrictionSource::Stated(stated) = &vibration.machine.friction else {
            panic!("{:?}", vibration.machine.friction)
        };
        let area_m2 = vibration.machine.nominal_contact().area_m2;
        WindowFriction::from_statement(stated.clone(), area_m2, vibration.machine.dimensionless_stribeck())
    }
    use super::super::axis::contact_places;
    use super::super::rests_on::tests::{STUDY, computed_window};
    use crate::friction::CutOff;
    use crate::study::Study;
    use crate::study::verdict::sampled::Evaluated;

    /// Returns a study and the friction that it states.
    pub(in crate::study::verdict) fn stated(text: &str) -> (Study, WindowFriction) {
        let study = Study::parse(text, "study.toml").unwrap();
        let window = stated_window(&study);
        (study, window)
    }

    /// Evaluates a machine under constant friction.
    pub(in crate::study::verdict) fn constant(machine: &Machine, _: usize) -> Result<Evaluated, String> {
        Evaluated::constant_friction(machine)
    }

    /// Returns factors between the waves of strips and those of pixels of 1 µm.
    fn waves(longest_m: f64) -> Vec<CutOff> {
        [(longest_m, 1.0, 1.0), (2e-6, 0.8, 0.5)]
            .map(|(shortest_m, mean, std)| CutOff { shortest_m, mean, std })
            .to_vec()
    }

    #[test]
    fn the_shortest_waves_range_from_one_end_of_the_band_to_the_other() {
        for longest_m in [8e-6, 200e-6] {
            let mut window = stated_window(&Study::parse(LINEAR, "study.toml").unwrap());
            window.mean_errors.cut_off = waves(longest_m);
            let (_, input) = cut_off(&window).unwrap().unwrap();
            let inputs = UncertainInputs::new(vec![input], &[]).unwrap();
            let factor = |z: f64| window.mean_errors.at_cut_off(inputs.values(&[z])[0]).unwrap().mean;
            // Quantiles at 5 %, 95 % and beyond.
            for (z, wanted) in [(-1.645, 0.8), (1.645, 1.0), (-3.0, 0.8), (3.0, 1.0)] {
                assert!((factor(z) - wanted).abs() < 0.03, "{longest_m} {z}: {}", factor(z));
            }
            assert!(factor(0.0) > 0.8 && factor(0.0) < 1.0);
        }
    }

    #[test]
    fn the_shortest_waves_change_the_fluctuation_by_a_factor_of_its_own() {
        let study =
            Study::parse(&format!("{STUDY}[verdict]\n").replace("0.17", "\"0.17 ± 0.01\""), "study.toml").unwrap();
        let mut window = WindowFriction { std: 0.03, ..computed_window(None) };
        window.mean_errors.cut_off = waves(8e-6);
        let study = study.verdict.unwrap().with_latent(cut_off(&window).unwrap().into_iter().collect());
        let machines = Machines::new(&study, &window, None, 1);
        let index = machines.places.iter().position(|place| place.name() == CUT_OFF).unwrap();
        for (z, [mean, std]) in [(3.0, [0.3, 0.03]), (-3.0, [0.24, 0.015])] {
            let mut variables = vec![0.0; machines.variables()];
            variables[index] = z;
            let found = machines.at(&variables).unwrap().window;
            assert!((found.mean - mean).abs() < 1e-12 && (found.std - std).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn a_factor_of_friction_multiplies_the_mean_and_its_fluctuation() {
        let (study, window) = stated(LINEAR);
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1).with_friction_factor(1.5);
        let machine = machines.nominal().unwrap();
        let Dynamics::StickSlip(oscillator) = &machine.dynamics else { panic!() };
        for friction in [machine.window.mean, oscillator.static_friction()] {
            assert!((friction - 0.45).abs() < 1e-15, "{friction}");
        }
        // Fluctuating friction keeps its standard deviation over the mean.
        let study = Study::parse(&format!("{STUDY}[verdict]\n"), "study.toml").unwrap();
        let window = WindowFriction { std: 0.03, ..computed_window(None) };
        let machines = Machines::new(study.verdict.as_ref().unwrap(), &window, None, 1).with_friction_factor(1.5);
        let found = machines.nominal().unwrap().window;
        assert!((found.mean - 0.45).abs() < 1e-12 && (found.std - 0.045).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn machines_of_another_load_mass_or_frequency_keep_their_velocities_in_si() {
        // The unit of velocity N/(mω₀) is that of V and of the fall of friction; a damper c = 2ζmω₀ is held by a change of mass or frequency.
        let text = "[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\n\
                    normal_force = { lognormal = [\"2.5 kN\", 0.2] }\nnominal_area = \"833 mm^2\"\nstatic_friction = 0.3\n\
                    friction_std = 0\ndamping_ratio = 0.05\ndimensionless_belt_velocity = 0.1\nstribeck = 4\n";
        let study = Study::parse(&format!("seed = 1\n{text}"), "study.toml").unwrap();
        let (window, verdict) = (stated_window(&study), study.verdict.as_ref().unwrap());
        let machines = Machines::new(verdict, &window, None, 1);
        let [load, mass, frequency] = ["normal_force", "mass", "natural_frequency"]
            .map(|key| Place::named(&format!("vibration.{key}"), &verdict.central).unwrap());
        let nominal = machines.nominal().unwrap().inputs.normal_force.0;
        assert!((machines.central_value(load).unwrap() / nominal - 1.0).abs() < 1e-12);
        assert!((machines.central_value(mass).unwrap() - 1.0).abs() < 1e-12);
        for (changes, held) in [
            (vec![], 1.0),
            (vec![Change { place: mass, value: 4.0, hold: Hold::Damper }], 4.0),
            (vec![Change { place: frequency, value: 4.0 * 316.0, hold: Hold::Damper }], 4.0),
            (vec![Change { place: mass, value: 4.0, hold: Hold::DampingRatio }], 1.0),
        ] {
            let growth = if changes.is_empty() { 1.0 } else { 4.0 };
            let changed = machines.with_changes(changes.clone());
            let machine = changed.at(&[1.5]).unwrap();
            let loaded = machine.inputs.normal_force.0 / nominal;
            assert!(loaded > 1.2, "{loaded}");
            let unit = loaded / growth;
            for change in &changes {
                assert_eq!(changed.value_of(change.place, &[1.5]), Some(change.value));
            }
            assert!((changed.value_of(load, &[1.5]).unwrap() / machine.inputs.normal_force.0 - 1.0).abs() < 1e-12);
            assert!((machine.inputs.belt_velocity * unit / 0.1 - 1.0).abs() < 1e-12, "{changes:?}");
            assert!((machine.window.stribeck.unwrap() / (4.0 * unit) - 1.0).abs() < 1e-12, "{changes:?}");
            assert!((machine.inputs.damping_ratio * held / 0.05 - 1.0).abs() < 1e-12, "{changes:?}");
        }
    }

    #[test]
    fn the_fall_of_a_friction_process_keeps_its_rate_in_si() {
        // The process falls at another rate than the study; under 1.5 times the load the unit of velocity is 1.5 times as large.
        let text = "[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
                    nominal_area = \"833 mm^2\"\nfriction_process = \"process.json\"\ndamping_ratio = 0.05\n\
                    belt_velocity = \"0.8 m/s\"\nstribeck = 4\n[verdict]\n";
        let study = Study::parse(&format!("seed = 1\n{text}"), "study.toml").unwrap();
        let stated = text.replace("friction_process = \"process.json\"", "static_friction = 0.3\nfriction_std = 0");
        let usual = stated_window(&Study::parse(&format!("seed = 1\n{stated}"), "study.toml").unwrap());
        let verdict = study.verdict.as_ref().unwrap();
        let changes = [("normal_force", 3750.0), ("stribeck", 8.0)].map(|(key, value)| {
            let place = Place::named(&format!("vibration.{key}"), &verdict.central).unwrap();
            Change { place, value, hold: Hold::default() }
        });
        // The study's own rate counts only if the process has the same.
        for (stribeck, change, wanted) in [
            (Some(7.0), changes[0], Some(10.5)),
            (Some(4.0), changes[0], Some(6.0)),
            (None, changes[0], None),
            (Some(7.0), changes[1], Some(7.0)),
            (Some(4.0), changes[1], Some(8.0)),
        ] {
            let window = WindowFriction { stribeck, ..usual.clone() };
            let machine = Machines::new(verdict, &window, None, 1).with_changes(vec![change]).nominal().unwrap();
            let found = machine.window.stribeck;
            assert_eq!(found.is_some(), wanted.is_some());
            assert!(found.zip(wanted).is_none_or(|(found, wanted)| (found / wanted - 1.0).abs() < 1e-12), "{found:?}");
        }
    }

    #[test]
    fn friction_follows_the_shear_strength_of_its_law_without_a_solution() {
        for (law, is_proportional) in
            [("", true), ("law = \"pressure_dependent\"\npressure_coefficient = 0.05\n", false)]
        {
            let text =
                STUDY.replace("\"385 MPa\"", "\"385 ± 30 MPa\"").replace("[friction]\n", &format!("[friction]\n{law}"));
            let study = Study::parse(&text, "study.toml").unwrap();
            let verdict = study.verdict.as_ref().unwrap();
            assert_eq!(contact_places(verdict).is_empty(), is_proportional);
            let window = WindowFriction { std: 0.01, ..computed_window(None) };
            let machines = Machines::new(verdict, &window, None, 1);
            let found = machines.at(&[2.0]).unwrap().window;
            let factor = if is_proportional { 445.0 / 385.0 } else { 1.0 };
            assert!(
                (found.mean / (0.3 * factor) - 1.0).abs() < 1e-12 && (found.std / (0.01 * factor) - 1.0).abs() < 1e-12
            );
        }
    }
}
