//! Values that change the contact, and the range of each.

use toml::Table;

use crate::chaos::Parameter;
use crate::study::StudyError;
use crate::study::check::VerdictStudy;
use crate::study::uncertain::{BETWEEN_PARTS, Place};

/// Probability of values below and above the range on which friction is expanded.
const TAIL: f64 = 1e-3;

/// Keys of [vibration] that change the pressure of the contact.
const LOADS: [&str; 2] = ["normal_force", "nominal_area"];

/// Returns the values that change the contact, uncertain ones and those of remedies.
pub(in crate::study) fn contact_places(verdict: &VerdictStudy) -> Vec<Place> {
    let changes_contact = |place: &Place| {
        let key = place.key();
        (key.section != "vibration" || LOADS.contains(&key.name)) && place.name() != BETWEEN_PARTS
    };
    let mut places: Vec<Place> = Vec::new();
    for place in verdict.places.iter().copied().chain(verdict.remedies.iter().map(|remedy| remedy.place)) {
        if changes_contact(&place) && !places.contains(&place) {
            places.push(place);
        }
    }
    places
}

/// One value, on a linear or logarithmic scale.
pub(super) struct Axis {
    pub(super) place: Place,
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Axis {
    /// Returns the axis over the values of an input and of its remedies.
    pub(super) fn new(place: Place, study: &VerdictStudy) -> Option<Self> {
        let mut ends = Vec::new();
        if let Some(index) = study.places.iter().position(|own| *own == place) {
            let input = &study.inputs.inputs()[index];
            ends.extend([TAIL, 1.0 - TAIL].map(|probability| input.marginal().quantile(probability)));
        }
        for remedy in study.remedies.iter().filter(|remedy| remedy.place == place) {
            ends.extend([remedy.low, remedy.high]);
        }
        let low = ends.iter().copied().reduce(f64::min)?;
        let high = ends.into_iter().reduce(f64::max)?;
        Some(Self { place, low, high, logarithmic: low > 0.0 })
    }

    fn scale(&self, value: f64) -> f64 {
        if self.logarithmic { value.ln() } else { value }
    }

    /// Returns the value at a point of the scale.
    pub(super) fn value(&self, scaled: f64) -> f64 {
        if self.logarithmic { scaled.exp() } else { scaled }
    }

    /// Returns the position of a study file's value: −1 … 1 on the range on which friction is expanded.
    pub(super) fn xi(&self, table: &Table) -> f64 {
        let [low, high] = [self.low, self.high].map(|end| self.scale(end));
        let value = self.place.value_in(table).unwrap_or(self.low);
        // A value that a logarithmic scale does not contain counts as the lower end.
        let scaled = if self.logarithmic && value <= 0.0 { low } else { self.scale(value) };
        2.0 * (scaled - low) / (high - low) - 1.0
    }

    pub(super) fn parameter(&self) -> Result<Parameter, StudyError> {
        Ok(Parameter::uniform(&self.place.name(), self.scale(self.low), self.scale(self.high))?)
    }
}
