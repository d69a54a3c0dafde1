//! Range of one value that changes the contact.

use toml::Table;

use crate::chaos::Parameter;
use crate::study::StudyError;
use crate::study::check::VerdictStudy;
use crate::study::uncertain::Place;

/// Probability of values below and above the range on which friction is learnt.
const TAIL: f64 = 1e-3;

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

    /// Returns the point of the scale of a study file's value; values beyond the ends count as the ends.
    fn scaled(&self, table: &Table) -> f64 {
        self.scale(self.place.value_in(table).unwrap_or(self.low).clamp(self.low, self.high))
    }

    /// Returns the position of a study file's value in −1 … 1.
    pub(super) fn xi(&self, table: &Table) -> f64 {
        let [low, high] = [self.low, self.high].map(|end| self.scale(end));
        2.0 * (self.scaled(table) - low) / (high - low) - 1.0
    }

    pub(super) fn parameter(&self) -> Result<Parameter, StudyError> {
        Ok(Parameter::uniform(&self.place.name(), self.scale(self.low), self.scale(self.high))?)
    }
}
