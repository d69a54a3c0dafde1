//! Checks of `[uncertainty]` and `[verdict]`.

use asperity_results::MachineModel;
use asperity_results::keys::Link;
use serde::Serialize;

use super::invalid_value::{InvalidValue, POSITIVE, at_least, invalid, positive, within};
use super::{FrictionStudy, VibrationStudy};
use crate::chaos::{UncertainInput, UncertainInputs};
use crate::study::StudyFile;
use crate::study::file::{Hold, RemedySection, VerdictSection};
use crate::study::uncertain::{Place, Point, UncertainValue, parse};

const SECTION: &str = "verdict";
/// Targets of remedies that the machines of their search resolve.
const TARGETS: std::ops::RangeInclusive<f64> = 0.001..=0.999;
/// Largest ratio of a changed value to the present one where no range is stated.
pub(in crate::study) const LARGEST_CHANGE: f64 = 10.0;
/// Largest number of machines of a study's verdict.
const MOST_EVALUATIONS: f64 = 1e8;

/// Uncertain values of a study and its verdict.
#[derive(Debug, Clone, Serialize)]
pub(in crate::study) struct VerdictStudy {
    /// Least fraction of valid samples.
    pub(in crate::study) valid_fraction: f64,
    /// The central values.
    pub(in crate::study) central: Point,
    /// Joint distribution of the uncertain values.
    pub(in crate::study) inputs: UncertainInputs,
    /// Place of each uncertain value.
    pub(in crate::study) places: Vec<Place>,
    /// Value of the contact to which the friction of all windows is proportional.
    pub(in crate::study) proportional: Option<Place>,
    /// Whether the verdict counts what the scans leave uncertain of both bodies.
    pub(in crate::study) scan_errors: bool,
    /// Duration T.
    pub(in crate::study) duration_s: f64,
    /// Fraction of the time above which a machine counts as vibrating.
    pub(in crate::study) threshold: f64,
    pub(in crate::study) remedies: Vec<RemedyStudy>,
    /// Whether the study file states them.
    pub(in crate::study) states_remedies: bool,
    /// Probabilities to reach.
    pub(in crate::study) targets: Vec<f64>,
    /// Half width of the interval at which sampling stops.
    pub(in crate::study) half_width: f64,
    /// Largest number of machines.
    pub(in crate::study) evaluations: usize,
}

/// Value to change.
#[derive(Debug, Clone, Serialize)]
pub(in crate::study) struct RemedyStudy {
    pub(in crate::study) place: Place,
    /// Range of its central value in SI.
    pub(in crate::study) low: f64,
    pub(in crate::study) high: f64,
    pub(in crate::study) hold: Hold,
}

impl VerdictStudy {
    /// Returns the remedies to compute. Those that no study file states are left out for a single machine, which has turning points instead,
    /// and where friction fluctuates, because ensembles take minutes.
    pub(in crate::study) fn computed_remedies(&self, is_single: bool, fluctuates: bool) -> &[RemedyStudy] {
        if self.states_remedies || !(is_single || fluctuates) { &self.remedies } else { &[] }
    }

    /// Returns both remedies over which the probability is mapped: the first two of the study file.
    pub(in crate::study) fn mapped(&self) -> Option<[&RemedyStudy; 2]> {
        match &self.remedies[..] {
            [x, y, ..] if self.states_remedies => Some([x, y]),
            _ => None,
        }
    }

    /// Returns the study with more uncertain values, which no study file states and which are independent of all others.
    pub(in crate::study) fn with_latent(&self, latent: Vec<(Place, UncertainInput)>) -> Self {
        let (places, inputs): (Vec<Place>, Vec<UncertainInput>) = latent.into_iter().unzip();
        let mut study = self.clone();
        study.central.add_latent(&places);
        study.places.extend(places);
        study.inputs = study.inputs.with_independent(inputs);
        study
    }
}

impl StudyFile {
    /// Checks the verdict; `None` for a study without vibration.
    pub(super) fn check_verdict(
        &self,
        friction: Option<&FrictionStudy>,
        vibration: Option<&VibrationStudy>,
    ) -> Result<Option<VerdictStudy>, InvalidValue> {
        let Some(vibration) = vibration else {
            return match &self.verdict {
                Some(_) => Err(invalid(SECTION, "remedies", "a verdict requires [vibration]")),
                None => Ok(None),
            };
        };
        let inputs = self.joint_inputs()?;
        let central = Point::central(self);
        let stated = self.verdict.clone().unwrap_or_default();
        let VerdictSection { duration, threshold, remedies, targets, half_width, evaluations } = stated;
        if let Some(duration) = duration {
            within(SECTION, "duration", duration, positive, POSITIVE)?;
        }
        within(SECTION, "threshold", threshold, |t| t > 0.0 && t < 1.0, "a fraction of the time between 0 and 1")?;
        for target in &targets {
            within(SECTION, "targets", *target, |p| TARGETS.contains(&p), "a probability from 0.001 to 0.999")?;
        }
        if targets.is_empty() {
            return Err(invalid(SECTION, "targets", "no probability is stated"));
        }
        within(SECTION, "half_width", half_width, |w| w > 0.0 && w < 0.5, "a value above 0, below 0.5")?;
        at_least(SECTION, "evaluations", evaluations, 1000)?;
        within(SECTION, "evaluations", evaluations as f64, |n| n <= MOST_EVALUATIONS, "at most 1e8")?;
        let states_remedies = remedies.is_some();
        let remedies = match remedies {
            Some(stated) => stated
                .iter()
                .map(|remedy| check_remedy(remedy, &central, friction.is_some()))
                .collect::<Result<_, _>>()?,
            None => usual_remedies(&central, friction.is_some(), vibration.machine.model()),
        };
        Ok(Some(VerdictStudy {
            valid_fraction: self.valid_share,
            proportional: friction
                .and_then(|friction| friction.law.proportional_to())
                .and_then(|input| Place::named(input, &central)),
            central,
            inputs,
            places: self.uncertain.iter().map(UncertainValue::place).collect(),
            scan_errors: self.uncertainty.as_ref().is_none_or(|section| section.surface),
            duration_s: duration.map_or_else(|| vibration.duration_s(), |duration| duration.0),
            threshold,
            remedies,
            states_remedies,
            targets,
            half_width,
            evaluations,
        }))
    }

    /// Returns the joint distribution of the uncertain values.
    fn joint_inputs(&self) -> Result<UncertainInputs, InvalidValue> {
        let inputs: Vec<UncertainInput> = self.uncertain.iter().map(|value| value.input().clone()).collect();
        let wrong = |message: String| invalid("uncertainty", "correlation", message);
        let stated = self.uncertainty.as_ref().map_or(&[][..], |section| &section.correlation[..]);
        let place = |name: &str| {
            inputs.iter().position(|input| input.name() == name).ok_or_else(|| {
                let known: Vec<&str> = inputs.iter().map(UncertainInput::name).collect();
                wrong(format!("`{name}` is no uncertain value of this study (known: {})", known.join(", ")))
            })
        };
        let pairs = stated
            .iter()
            .map(|(first, second, rank)| Ok((place(first)?, place(second)?, *rank)))
            .collect::<Result<Vec<_>, InvalidValue>>()?;
        UncertainInputs::new(inputs, &pairs).map_err(|error| wrong(error.to_string()))
    }
}

/// Returns the changes of a study that states none: those that need no further solution of the contact.
fn usual_remedies(central: &Point, is_computed: bool, model: MachineModel) -> Vec<RemedyStudy> {
    let places = model.usual_changes().into_iter().filter_map(|input| Place::named(input, central));
    let places = places.filter(|place| !(is_computed && place.key().link == Link::Contact));
    let remedy = |place: Place| {
        let now = place.value_in(central)?;
        let (low, high) = if now > 0.0 { (now / LARGEST_CHANGE, now * LARGEST_CHANGE) } else { (0.0, 1.0) };
        Some(RemedyStudy { place, low, high, hold: Hold::default() })
    };
    places.filter_map(remedy).collect()
}

/// Checks a remedy of a study, of which the friction stage computes the friction or not.
fn check_remedy(remedy: &RemedySection, central: &Point, is_computed: bool) -> Result<RemedyStudy, InvalidValue> {
    let RemedySection { input, range, hold } = remedy;
    let wrong = |message: String| invalid(SECTION, "remedies", message);
    let place = Place::named(input, central).ok_or_else(|| {
        wrong(format!("`{input}` is no number or quantity that this study states and a remedy can change"))
    })?;
    if !is_computed && place.key().section != "vibration" {
        return Err(wrong(format!(
            "`{input}` has no effect without [friction]; a remedy can change a key of [vibration]"
        )));
    }
    let end = |value| parse(place.key(), value).map_err(|message| wrong(format!("range of `{input}`: {message}")));
    let (low, high) = (end(&range[0])?, end(&range[1])?);
    let possible = |value| place.key().bounds.is_some_and(|bounds| bounds.contain(value));
    if !(low < high && possible(low) && possible(high)) {
        return Err(wrong(format!(
            "range of `{input}`: found {low} to {high}, expected possible values in rising order"
        )));
    }
    Ok(RemedyStudy { place, low, high, hold: hold.unwrap_or_default() })
}
