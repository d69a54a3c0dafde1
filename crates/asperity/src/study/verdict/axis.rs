//! Values that change the contact, and the range of each.

use asperity_results::keys::Link;

use crate::chaos::Parameter;
use crate::study::StudyError;
use crate::study::check::VerdictStudy;
use crate::study::uncertain::{Place, Point};

/// Probability of values below and above the range on which friction is expanded.
const TAIL: f64 = 1e-3;

/// Returns the values, uncertain ones and those of remedies, whose effect on friction takes solutions of the contact.
pub(super) fn contact_places(verdict: &VerdictStudy) -> Vec<Place> {
    let changes_contact = |place: &Place| {
        matches!(place.key().link, Link::Surface | Link::Contact) && Some(*place) != verdict.proportional
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

    /// Returns the position of the value of a point: −1 … 1 on the range on which friction is expanded.
    pub(super) fn xi(&self, point: &Point) -> f64 {
        let [low, high] = [self.low, self.high].map(|end| self.scale(end));
        let value = self.place.value_in(point).unwrap_or(self.low);
        // A value that a logarithmic scale does not contain counts as the lower end.
        let scaled = if self.logarithmic && value <= 0.0 { low } else { self.scale(value) };
        2.0 * (scaled - low) / (high - low) - 1.0
    }

    pub(super) fn parameter(&self) -> Result<Parameter, StudyError> {
        Ok(Parameter::uniform(&self.place.name(), self.scale(self.low), self.scale(self.high))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Study;
    use crate::study::uncertain::BETWEEN_PARTS;
    use crate::study::verdict::rests_on::tests::STUDY;

    /// Returns the study with an uncertain load and remedies.
    fn study() -> Study {
        let verdict = "[verdict]\nremedies = [{ input = \"vibration.normal_force\", range = [\"2 kN\", \"8 kN\"] }, \
                       { input = \"vibration.mass\", range = [\"1 kg\", \"2 kg\"] }, \
                       { input = \"material.youngs_modulus\", range = [\"100 GPa\", \"400 GPa\"] }]\n";
        let text = STUDY.replace("\"2.5 kN\"", "{ uniform = [\"1 kN\", \"4 kN\"] }").replace("0.17", "\"0.17 ± 0.02\"");
        Study::parse(&format!("{text}{verdict}"), "study.toml").unwrap()
    }

    #[test]
    fn loads_and_bodies_change_the_contact_and_the_other_values_of_the_machine_do_not() {
        let study = study();
        let mut verdict = study.verdict.clone().unwrap();
        verdict.places.push(Place::latent(BETWEEN_PARTS).unwrap());
        let names: Vec<String> = contact_places(&verdict).iter().map(Place::name).collect();
        assert_eq!(names, ["vibration.normal_force", "material.youngs_modulus"]);
    }

    #[test]
    fn an_axis_contains_the_quantiles_of_its_value_and_the_range_of_its_remedy() {
        let study = study();
        let verdict = study.verdict.as_ref().unwrap();
        let axis = |name: &str| Axis::new(Place::named(name, &verdict.central).unwrap(), verdict).unwrap();
        let load = axis("vibration.normal_force");
        // The quantile at .001 of 1 … 4 kN, and the upper end of the remedy; logarithmic, because loads are positive.
        let (low, high) = (1003.0_f64, 8000.0_f64);
        for (value, wanted) in [(low, -1.0), (high, 1.0), ((low * high).sqrt(), 0.0), (-5.0, -1.0), (0.0, -1.0)] {
            let mut point = verdict.central.clone();
            load.place.set(&mut point, value);
            assert!((load.xi(&point) - wanted).abs() < 1e-9, "{value}: {}", load.xi(&point));
        }
        assert!((load.value(low.ln()) / low - 1.0).abs() < 1e-12);
        // A standard normal value has both signs.
        let linear = Axis { low: -3.0, high: 5.0, logarithmic: false, ..axis("material.youngs_modulus") };
        assert_eq!(linear.value(-3.0), -3.0);
        let mut point = verdict.central.clone();
        linear.place.set(&mut point, 1.0);
        assert!(linear.xi(&point).abs() < 1e-12);
    }
}
