//! Answers of the members of a campaign.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::friction::WindowFriction;
use crate::study::result::{MemberAnswers, MemberRemedy, MemberWarning, MotionKind, Reach, Remedy, RestsOn, Results};

/// Answers of a member.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Answered {
    pub(super) answers: MemberAnswers,
    pub(super) warnings: Vec<String>,
    /// Inputs of the verdict; empty for members that differ from the first ones in other values than the scan.
    #[serde(with = "as_json")]
    pub(super) rests_on: Vec<RestsOn>,
}

/// Inputs as JSON text, because blocks do not state the kind of a value.
mod as_json {
    use serde::de::Error as _;
    use serde::ser::Error as _;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::RestsOn;

    pub(super) fn serialize<S: Serializer>(inputs: &[RestsOn], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&serde_json::to_string(inputs).map_err(S::Error::custom)?)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<RestsOn>, D::Error> {
        serde_json::from_str(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

/// Returns the main results of a study. `window` is the friction of its machine, and `damping` its damping ratio.
pub(super) fn answers(results: &Results, window: Option<&WindowFriction>, damping: Option<f64>) -> MemberAnswers {
    let point = results.friction.as_ref().map(|friction| &friction.operating_point);
    let mut found = MemberAnswers {
        friction_mean: window.map(|window| window.mean).or(point.map(|point| point.mean)),
        friction_std: window.map(|window| window.std).or(point.map(|point| point.std)),
        warnings: Some(results.warnings.len()),
        ..MemberAnswers::default()
    };
    if let Some(verdict) = &results.verdict {
        let nominal = &verdict.nominal;
        found.limit_damping_ratio = nominal.limit_damping_ratio;
        (found.kind, found.vibrates) = (Some(nominal.kind), Some(nominal.vibrates));
        found.probability = Some(verdict.probability);
        found.probability_interval = Some(verdict.probability_interval);
        found.probability_range = verdict.probability_range;
        found.remedy = verdict.remedies.first().and_then(|Remedy { input, unit, reach, .. }| {
            let Reach { probability, value, .. } = *reach.first()?;
            Some(MemberRemedy { input: input.clone(), unit: unit.clone(), probability, value })
        });
    } else if let Some(vibration) = &results.vibration {
        found.limit_damping_ratio = vibration.limit_damping_ratio;
        (found.kind, found.vibrates) = (Some(vibration.kind), Some(vibration.kind != MotionKind::None));
    } else if let Some(coupled) = &results.mode_coupling {
        found.limit_damping_ratio = coupled.limit_damping_ratio;
        (found.kind, found.vibrates) = (Some(coupled.kind), Some(coupled.steady_sliding_unstable));
    }
    found.damping_margin = damping.zip(found.limit_damping_ratio).map(|(damping, limit)| damping - limit);
    found
}

/// Returns the warnings of the members, those that differ in numbers only as one.
pub(super) fn member_warnings(answers: &[Result<Answered, String>]) -> Vec<MemberWarning> {
    let mut found: Vec<MemberWarning> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    for (index, warnings) in
        answers.iter().enumerate().filter_map(|(index, found)| Some((index, &found.as_ref().ok()?.warnings)))
    {
        for warning in warnings {
            let has_digit = |word: &&str| word.contains(|letter: char| letter.is_ascii_digit());
            let words: Vec<&str> = warning.split_whitespace().filter(|word| !has_digit(word)).collect();
            let place = *known.entry(words.join(" ")).or_insert(found.len());
            if place == found.len() {
                found.push(MemberWarning { warning: warning.clone(), members: Vec::new() });
            }
            let members = &mut found[place].members;
            if members.last() != Some(&(index + 1)) {
                members.push(index + 1);
            }
        }
    }
    found
}
