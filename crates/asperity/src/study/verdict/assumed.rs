//! Probability of vibration at both ends of the range of each value that the study does not state.

use super::changed;
use super::machines::{Change, Machines};
use super::number;
use super::probability::Probability;
use super::rests_on::assumed_range;
use super::sampled::{Evaluate, Sampled};
use crate::monitor::{Cancelled, Monitor};
use crate::study::check::VerdictStudy;
use crate::study::file::Hold;
use crate::study::result::{Assumed, InputValue, Pair, RestsOn};
use crate::study::uncertain::Place;

/// Machines of each end of a range.
pub(super) const MACHINES: usize = 256;

/// The verdict of the study, from which its values are changed.
pub(super) struct Ends<'a> {
    pub(super) study: &'a VerdictStudy,
    pub(super) machines: &'a Machines<'a>,
    pub(super) sampled: &'a Sampled,
    pub(super) probability: &'a Probability,
    /// Expected fraction of the time in vibration.
    pub(super) share: &'a Probability,
    pub(super) evaluate: &'a Evaluate<'a>,
    pub(super) monitor: &'a dyn Monitor,
}

/// Probability, its interval, and expected fraction of the time at one end of a range.
type End = (f64, Pair, f64);

impl Ends<'_> {
    /// Returns the probability at both ends of the range of each input that the study does not state, and warnings on the inputs that are
    /// left out because too few machines have an answer there.
    pub(super) fn assumed(&self, rests_on: &[RestsOn]) -> Result<(Vec<Assumed>, Vec<String>), Cancelled> {
        let (mut found, mut warnings) = (Vec::new(), Vec::new());
        for input in rests_on {
            let (Some(range), InputValue::Number(value)) = (assumed_range(input), &input.value) else { continue };
            let Some(place) = Place::named(&input.input, &self.study.central) else { continue };
            let [low, high] = range.map(|end| self.end(place, end, *value));
            match (low?, high?) {
                (Ok(low), Ok(high)) => found.push(Assumed {
                    input: input.input.clone(),
                    value: *value,
                    range,
                    probability_at: [low.0, high.0],
                    probability_interval_at: [low.1, high.1],
                    expected_vibration_share_at: [low.2, high.2],
                }),
                (low, high) => warnings.extend([low, high].into_iter().filter_map(Result::err)),
            }
        }
        Ok((found, warnings))
    }

    /// Returns the answer with a value at one end of its range, or a warning if too few machines have an answer.
    fn end(&self, place: Place, value: f64, default: f64) -> Result<Result<End, String>, Cancelled> {
        if value == default {
            let Probability { value, interval, .. } = self.probability;
            return Ok(Ok((*value, [interval.low, interval.high], self.share.value)));
        }
        // The dampers do not depend on these values.
        let changed = self.machines.with_changes(vec![Change { place, value, hold: Hold::DampingRatio }]);
        let pairs = changed::pairs(&changed, self.sampled, [MACHINES; 2], self.evaluate, self.monitor)?;
        let known = self.sampled.machines.iter().take(MACHINES).flatten().count();
        if pairs.is_empty() || (pairs.len() as f64) < self.study.valid_fraction * known as f64 {
            let (failed, name) = (known - pairs.len(), place.name());
            return Ok(Err(format!(
                "`assumed` leaves out {name}: at {value}, {failed} of {known} machines have no answer"
            )));
        }
        let is_exact = self.machines.variables() == 0;
        let (probability, interval) =
            changed::controlled(&pairs, |machine| number(machine.vibrates), self.probability, is_exact);
        let (share, _) = changed::controlled(&pairs, |machine| machine.fraction, self.share, is_exact);
        Ok(Ok((probability, [interval.low, interval.high], share)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::standard_normal_cdf;
    use crate::friction::WindowFriction;
    use crate::monitor::Silent;
    use crate::study::Study;
    use crate::study::verdict::machines::Machine;
    use crate::study::verdict::machines::tests::{constant, stated_window};
    use crate::study::verdict::rests_on::rests_on;
    use crate::study::verdict::sampled::Evaluated;

    const MACHINE: &str =
        "seed = 1\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnominal_area = \"833 mm^2\"\n";

    /// Returns the probability of a study, that at the ends of its ranges, and the warnings, with friction `window` or the one that the
    /// study states.
    fn found(
        lines: &str,
        window: Option<WindowFriction>,
        evaluate: &Evaluate<'_>,
    ) -> (Probability, Vec<Assumed>, Vec<String>) {
        let study = Study::parse(&format!("{MACHINE}{lines}"), "study.toml").unwrap();
        let window = window.unwrap_or_else(|| stated_window(&study));
        let verdict = study.verdict.as_ref().unwrap();
        let machines = Machines::new(verdict, &window, None, 1);
        let most = if machines.variables() == 0 { 1 } else { MACHINES };
        let sampled = Sampled::until(&machines, evaluate, 0.02, most, &Silent).unwrap();
        let of = |value: fn(&Evaluated) -> f64| {
            let mean = sampled.mean(value);
            Probability { value: mean.value, interval: mean.interval(), sources: Vec::new() }
        };
        let (probability, share) = (of(|machine| number(machine.vibrates)), of(|machine| machine.fraction));
        let ends = Ends {
            study: verdict,
            machines: &machines,
            sampled: &sampled,
            probability: &probability,
            share: &share,
            evaluate,
            monitor: &Silent,
        };
        let (assumed, warnings) = ends.assumed(&rests_on(&study, verdict, &window, false)).unwrap();
        (probability, assumed, warnings)
    }

    /// A jump of friction of .05 at the velocity .05 raises the limit of the damping ratio from b/2 to .0578291 + b/2.
    const JUMP: &str = "normal_force = \"2.5 kN\"\nstatic_friction = 0.5\nfriction_std = 0\ndimensionless_belt_velocity = 0.05\n\
                        velocity_law = \"linear\"\nlinear_weakening = \"0.1 ± 0.03\"\ndamping_ratio = 0.09\n";

    #[test]
    fn the_ends_of_the_kinetic_share_have_the_probabilities_of_the_closed_form() {
        let (probability, assumed, warnings) = found(JUMP, None, &constant);
        let [entry] = &assumed[..] else { panic!("{assumed:?}") };
        assert_eq!((entry.input.as_str(), entry.value, entry.range), ("vibration.kinetic_share", 1.0, [0.9, 1.0]));
        // A machine vibrates if b > 2 (ζ − .0578291), and at the default if b > 2ζ.
        let wanted = [0.057_829_116, 0.0].map(|jump: f64| standard_normal_cdf((0.1 - 2.0 * (0.09 - jump)) / 0.03));
        assert!((entry.probability_at[0] - wanted[0]).abs() < 4.0 / MACHINES as f64, "{entry:?}, not {wanted:?}");
        let [low, high] = entry.probability_interval_at[0];
        assert!(low <= wanted[0] && wanted[0] <= high && high - low < 0.04, "{entry:?}, not {wanted:?}");
        assert_eq!(entry.probability_at[1], probability.value);
        assert!(
            (probability.value - wanted[1]).abs() < 4.0 / MACHINES as f64 && warnings.is_empty(),
            "{probability:?}"
        );
        assert_eq!(entry.expected_vibration_share_at, entry.probability_at);
    }

    #[test]
    fn the_ends_have_the_probabilities_of_studies_that_state_them() {
        // The unit of velocity, and with it the dimensionless coefficient, varies with the load.
        let lines = "normal_force = { lognormal = [\"2.5 kN\", 0.1] }\nstatic_friction = \"0.2 ± 0.02\"\nfriction_std = 0\n\
                     dimensionless_belt_velocity = 0.1\n";
        for (key, [low, high]) in [("stribeck", [2.1, 8.4]), ("kinetic_share", [0.9, 1.0])] {
            let lines =
                format!("{lines}damping_ratio = {}\n", if key == "stribeck" { "\"0.18 ± 0.05\"" } else { "0.21" });
            let (_, assumed, _) = found(&lines, None, &constant);
            let entry = assumed.iter().find(|entry| entry.input.ends_with(key)).unwrap();
            for (end, value) in [low, high].into_iter().enumerate() {
                let (stated, others, _) = found(&format!("{lines}{key} = {value:?}\n"), None, &constant);
                let difference = (entry.probability_at[end] - stated.value).abs();
                assert!(difference < 1e-12, "{key} = {value}: {entry:?} instead of {stated:?}");
                assert!((0.02..0.98).contains(&stated.value), "{key} = {value}: {stated:?}");
                assert!(others.len() == 1 && !others[0].input.ends_with(key), "{others:?}");
            }
        }
    }

    #[test]
    fn only_values_that_are_not_stated_and_used_have_ends() {
        let names = |lines: &str, window: Option<WindowFriction>| {
            let lines = format!("normal_force = \"2.5 kN\"\nbelt_velocity = \"0.8 m/s\"\n{lines}");
            let (_, assumed, _) = found(&lines, window, &constant);
            assumed.into_iter().map(|entry| entry.input).collect::<Vec<_>>()
        };
        let friction = "static_friction = 0.2\nfriction_std = 0\ndamping_ratio = 0.2\n[verdict]\n";
        let (stribeck, kinetic) = ("vibration.stribeck", "vibration.kinetic_share");
        assert_eq!(names(friction, None), [stribeck, kinetic]);
        assert_eq!(names(&format!("stribeck = 4.2\n{friction}"), None), [kinetic]);
        assert_eq!(names(&format!("kinetic_share = 1.0\n{friction}"), None), [stribeck]);
        assert_eq!(names(&format!("kinetic_share = \"0.95 ± 0.01\"\n{friction}"), None), [stribeck]);
        assert_eq!(names(&format!("velocity_law = \"linear\"\nlinear_weakening = 0.1\n{friction}"), None), [kinetic]);
        assert_eq!(names(&format!("model = \"mode_coupling\"\n{friction}"), None), [""; 0]);
        // The fall of friction of a process replaces that of the study.
        let process = "friction_process = \"process.json\"\ndamping_ratio = 0.2\n[verdict]\n";
        let stated = Study::parse(
            &format!("{MACHINE}normal_force = \"2.5 kN\"\nbelt_velocity = \"0.8 m/s\"\n{friction}"),
            "study.toml",
        );
        let usual = stated_window(&stated.unwrap());
        let own = WindowFriction { stribeck: Some(5.0), ..usual.clone() };
        assert_eq!(names(process, Some(own)), [kinetic]);
        // One without a fall leaves it to the study.
        assert_eq!(names(process, Some(WindowFriction { stribeck: None, ..usual })), [stribeck, kinetic]);
    }

    #[test]
    fn the_fall_of_friction_that_a_process_leaves_to_the_study_is_changed() {
        // A machine vibrates if μ a/(1 + aV)² > 2ζ: at V = .1 and ζ = .2 from steady sliding, .148 for a = 4.2.
        let lines = "normal_force = \"2.5 kN\"\ndimensionless_belt_velocity = 0.1\nfriction_process = \"process.json\"\n\
                     damping_ratio = 0.2\n[verdict]\n";
        let stated = format!(
            "{MACHINE}{}",
            lines.replace("friction_process = \"process.json\"", "static_friction = 0.2\nfriction_std = 0")
        );
        let usual = stated_window(&Study::parse(&stated, "study.toml").unwrap());
        for stribeck in [None, Some(4.2)] {
            let window = WindowFriction { stribeck, ..usual.clone() };
            let (probability, assumed, _) = found(lines, Some(window), &constant);
            let (wanted, others, _) = found(&stated[MACHINE.len()..], None, &constant);
            assert_eq!((probability.value, &assumed), (wanted.value, &others));
            assert_eq!(assumed[0].probability_at, [0.0, 1.0], "{assumed:?}");
            assert_eq!(assumed[0].probability_interval_at, [[0.0; 2], [1.0; 2]], "exact");
        }
    }

    #[test]
    fn the_fraction_of_the_time_is_that_of_the_changed_machines() {
        // φ = .3 at the kinetic share 1, and .5 at .9.
        let evaluate = |machine: &Machine, index: usize| {
            let fraction = 0.3 + 2.0 * (1.0 - machine.inputs.kinetic_fraction);
            Ok(Evaluated { fraction, vibrates: fraction > 0.4, ..constant(machine, index)? })
        };
        let (_, assumed, _) = found(JUMP, None, &evaluate);
        for (found, wanted) in assumed[0].expected_vibration_share_at.into_iter().zip([0.5, 0.3]) {
            assert!((found - wanted).abs() < 1e-12, "{assumed:?}");
        }
        assert_eq!(assumed[0].probability_at, [1.0, 0.0]);
    }

    #[test]
    fn an_end_without_answers_is_a_warning() {
        let evaluate =
            |machine: &Machine, index: usize| match machine.inputs.kinetic_fraction < 1.0 && index.is_multiple_of(2) {
                true => Err("no reason".into()),
                false => constant(machine, index),
            };
        let (_, assumed, warnings) = found(JUMP, None, &evaluate);
        assert!(assumed.is_empty(), "{assumed:?}");
        let wanted = "`assumed` leaves out vibration.kinetic_share: at 0.9, 128 of 256 machines have no answer";
        assert_eq!(warnings, [wanted]);
    }
}
