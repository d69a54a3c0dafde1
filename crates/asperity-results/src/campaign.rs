//! The results of a campaign: `results.json` of its folder.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{InputValue, MotionKind, Pair, RestsOn, SCHEMA_VERSION};

/// Rows of all members of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CampaignResults {
    /// Version of the keys.
    #[schemars(extend("const" = SCHEMA_VERSION))]
    pub schema_version: u64,
    /// Seed of the campaign.
    pub seed: u64,
    /// Keys that differ between the members, in the order of their values.
    pub keys: Vec<VariedKey>,
    /// The members in their order.
    pub members: Vec<MemberResult>,
    /// Inputs of the verdict that all members have in common, with their origin; empty in results of earlier versions.
    #[serde(default)]
    pub rests_on: Vec<RestsOn>,
    /// Warnings, in sentences.
    pub warnings: Vec<String>,
    /// Warnings of the members. Warnings that differ in numbers only are one.
    pub member_warnings: Vec<MemberWarning>,
}

impl Default for CampaignResults {
    fn default() -> Self {
        Self {
            schema_version: SCHEMA_VERSION,
            seed: 0,
            keys: Vec::new(),
            members: Vec::new(),
            rests_on: Vec::new(),
            warnings: Vec::new(),
            member_warnings: Vec::new(),
        }
    }
}

/// Key of a study that differs between the members.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VariedKey {
    /// Name, `section.key`; of a component of a list `section.key[0]`, of the standard deviations of uncertain values
    /// `section.key_std`.
    pub key: String,
    /// SI unit of the values; empty for numbers and texts.
    pub unit: String,
    /// Whether the values are draws of a distribution.
    pub sampled: bool,
}

/// Warning of some members.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MemberWarning {
    /// The warning with the numbers of the first of these members.
    pub warning: String,
    /// Numbers of the members, counted from 1.
    pub members: Vec<usize>,
}

/// One member of a campaign: its values, and its answers or the reason why it has none.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MemberResult {
    /// Scan, relative to the campaign file; absent if the members have the scan of the study.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<String>,
    /// Values of the keys: numbers in SI, uncertain ones at their centres, or texts as stated.
    pub values: Vec<InputValue>,
    /// Whether the member has no answer.
    pub failed: bool,
    /// Reason of the failure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Answers; undefined for a failed member.
    #[serde(flatten)]
    pub answers: MemberAnswers,
}

/// Main results of one study.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MemberAnswers {
    /// Mean friction coefficient, of the operating point or as stated.
    pub friction_mean: Option<f64>,
    /// Standard deviation of the friction coefficient of one window.
    pub friction_std: Option<f64>,
    /// Damping ratio above which no vibration persists, with uncertain values at their centres.
    pub limit_damping_ratio: Option<f64>,
    /// Margin of the damping: damping ratio minus `limit_damping_ratio`.
    pub damping_margin: Option<f64>,
    /// Kind of motion, with uncertain values at their centres.
    pub kind: Option<MotionKind>,
    /// Whether the machine vibrates if its motion begins in stick, with uncertain values at their centres.
    pub vibrates: Option<bool>,
    /// Probability of vibration over the uncertain values.
    pub probability: Option<f64>,
    /// Its 95 % interval: the error of the computation.
    pub probability_interval: Option<Pair>,
    /// Its 90 % range over the values that are not known.
    #[serde(default)]
    pub probability_range: Option<Pair>,
    /// First of the changes that make vibration improbable.
    #[serde(default)]
    pub remedy: Option<MemberRemedy>,
    /// Number of warnings.
    pub warnings: Option<usize>,
}

/// Change of one value of a member that makes vibration improbable.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MemberRemedy {
    /// Name of the value, `section.key`.
    pub input: String,
    /// SI unit of the value; empty for a number.
    pub unit: String,
    /// Probability of vibration.
    pub probability: f64,
    /// Nearest central value in the range of the study at which vibration is at most as probable; `null` if there is none.
    pub value: Option<f64>,
}
