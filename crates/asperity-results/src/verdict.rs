//! The verdict in `results.json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{AreaAsOne, MachineModel, MotionKind, Pair, ProbabilityMap, choice};

/// Probability of vibration over the uncertain values of a study, what decides it and what changes it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VerdictResult {
    /// Model of the machine. It decides what a margin is.
    #[serde(default)]
    pub model: MachineModel,
    /// Expected fraction of the second half of the duration in which a machine vibrates whose motion begins in stick.
    pub expected_vibration_share: f64,
    /// Its 95 % interval: the error of the computation.
    pub expected_vibration_share_interval: Pair,
    /// Whether the friction coefficient is not resolved (`resolved` of the operating point is false): the probability is then no answer.
    #[serde(default)]
    pub friction_unresolved: bool,
    /// Why it is not: the pitch of the strips, or their difference from the scan. Empty if it is.
    #[serde(default)]
    pub unresolved_by: Vec<ErrorCause>,
    /// Probability that a machine whose motion begins in stick vibrates longer than the fraction `vibration_threshold` of the second half of
    /// the duration, in the mean over realisations of friction. With mode coupling, the probability that steady sliding is unstable.
    pub probability: f64,
    /// Its 95 % interval: the error of the computation.
    pub probability_interval: Pair,
    /// Probability that a machine whose motion begins in stick vibrates for at least half of the second half of the duration.
    pub probability_half: f64,
    /// Its 95 % interval: the error of the computation.
    pub probability_half_interval: Pair,
    /// Fraction of the time above which a machine with fluctuating friction counts as vibrating.
    pub vibration_threshold: f64,
    /// Whether the verdict counts a fluctuation of friction along the path, so that a machine may vibrate for a part of the time. One whose
    /// standard deviation is below 1e-4 of the mean does not count. Then `probability`, `expected_vibration_share` and `probability_half`
    /// are equal.
    pub friction_fluctuates: bool,
    /// Probability that a machine vibrates which slides steadily at first and is not kicked; `null` if friction fluctuates, because the
    /// fluctuation starts vibration.
    pub probability_from_steady_sliding: Option<f64>,
    /// Its 95 % interval: the error of the computation.
    pub probability_from_steady_sliding_interval: Option<Pair>,
    /// Range of the probability over the values that are unknown: its 5 and 95 % quantiles. `null` if none is unknown.
    pub probability_range: Option<Pair>,
    /// Quantiles of the probability over the values that are unknown; `null` if none is.
    pub probability_over_unknowns: Option<Quantiles>,
    /// Parts of the half width of `probability_interval`, largest first.
    pub error_sources: Vec<ErrorSource>,
    /// Friction as a function of the uncertain values; `null` if it does not depend on them.
    pub friction: Option<LearntFriction>,
    /// Number of machines that were evaluated.
    pub evaluations: usize,
    /// Number of them that have no answer.
    pub failed_samples: usize,
    /// Reason of the first of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_failure: Option<String>,
    /// Duration T of the event.
    pub duration_s: f64,
    /// Whether the verdict leaves out the fluctuation of friction that the study has: with mode coupling the mean friction coefficient
    /// decides.
    #[serde(default)]
    pub leaves_out_fluctuation: bool,
    /// The machine with all values at their centres.
    pub nominal: NominalMachine,
    /// The vibration of machines that vibrate; `null` if no sampled machine does.
    pub if_vibrating: Option<VibratingMachines>,
    /// Quantiles of the margin.
    pub margin_quantiles: Vec<MarginQuantile>,
    /// Sensitivity of the margin.
    pub drivers: Vec<Driver>,
    /// Sensitivity of the event; empty for probabilities below 5 or above 95 %.
    pub event_drivers: Vec<Driver>,
    /// Effect of each unknown value.
    pub guesses: Vec<Guess>,
    /// Changes that reach the target probabilities.
    pub remedies: Vec<Remedy>,
    /// If no value is uncertain and the mean friction decides, what each number of the machine would have to be; otherwise empty.
    #[serde(default)]
    pub turning_points: Vec<TurningPoint>,
    /// Probability over the central values of the first two remedies of the study file; `null` if it states fewer.
    pub map: Option<ProbabilityMap>,
    /// Probability against the number of windows that share the load; `null` if friction neither fluctuates nor differs between
    /// parts, or is averaged over an unknown area.
    pub area_as_one: Option<Vec<AreaAsOne>>,
    /// Assumptions of the verdict, in sentences.
    pub assumptions: Vec<String>,
    /// Inputs of the verdict with their origin; empty in results of earlier versions.
    #[serde(default)]
    pub rests_on: Vec<RestsOn>,
    /// Probability with each number that the study does not state at the ends of its range; empty in results of earlier versions.
    #[serde(default)]
    pub assumed: Vec<Assumed>,
}

choice! {
    /// Cause of an error of a probability.
    #[derive(Default)]
    pub enum ErrorCause: "cause of an error" {
        /// Finite number of machines.
        #[default]
        Machines = "machines": "the number of machines",
        /// Finite number of strips.
        Strips = "strips": "the number of strips",
        /// Expansion of friction in the uncertain values.
        Expansion = "expansion": "the expansion of friction in the uncertain values",
        /// Limited scan.
        Scan = "scan": "the size of the scan",
        /// Pitch of the strips.
        Grid = "grid": "the pitch of the strips",
        /// Random strips in place of the scan.
        Model = "model": "the difference between random strips and scan",
    }
}

impl ErrorCause {
    /// Returns what makes the error smaller.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Machines => "lower `half_width` and, if needed, raise `evaluations` in [verdict]",
            Self::Strips => "raise `realisations` in [friction]",
            Self::Expansion => "state narrower distributions or ranges of remedies",
            Self::Scan => "take a larger scan",
            Self::Grid => "raise `points` in [friction]",
            Self::Model => "take a larger scan, or remove more form (`level`)",
        }
    }
}

/// Part of the interval of the probability.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErrorSource {
    /// Its cause.
    pub source: ErrorCause,
    /// Distance from the probability to the farther end of the interval if this were its only cause.
    pub half_width: f64,
}

/// Friction of the contact as a function of the uncertain values, learnt from solved strips.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LearntFriction {
    /// Names of the values.
    pub inputs: Vec<String>,
    /// Number of solved points.
    pub points: usize,
    /// Number of them near the limit of vibration.
    pub points_near_limit: usize,
    /// Root-mean-square relative difference between the solved and the predicted mean friction coefficient at the last points near the
    /// limit, before they were used.
    pub difference_near_limit: Option<f64>,
    /// Relative standard error of the mean friction coefficient.
    pub standard_error: f64,
}

/// Input of the verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RestsOn {
    /// Name of the input, `section.key`.
    pub input: String,
    /// Central value; of `surface.file` and `counterface.file` the number of scans.
    pub value: InputValue,
    /// SI unit of the value; empty for a number or a name.
    pub unit: String,
    /// Origin of the value.
    pub kind: InputKind,
    /// 5 % and 95 % quantile of an uncertain or unknown value.
    #[serde(default)]
    pub range: Option<Pair>,
}

/// Value of an input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum InputValue {
    /// Whole number, such as a seed.
    Integer(i64),
    /// Number in SI.
    Number(f64),
    /// Name of a choice, such as `stribeck`.
    Name(String),
}

/// Origin of the value of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InputKind {
    /// Scan of the surface.
    Measured,
    /// Exact value of the study file.
    Stated,
    /// Distribution over the parts, of the study file.
    Uncertain,
    /// Distribution of one value that is not known, of the study file.
    Unknown,
    /// Default of asperity; the study file leaves the key out.
    Default,
    /// Value of the template `asperity init`, in a study of another scan.
    Example,
}

/// Quantiles of a distribution.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quantiles {
    /// 5 % quantile.
    pub q05: f64,
    /// Median.
    pub q50: f64,
    /// 95 % quantile.
    pub q95: f64,
}

/// The machine with all values at their centres.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NominalMachine {
    /// Whether it vibrates if its motion begins in stick.
    pub vibrates: bool,
    /// Kind of its motion.
    pub kind: MotionKind,
    /// Whether its steady sliding is unstable.
    pub steady_sliding_unstable: bool,
    /// Smallest change of velocity after which it vibrates from steady sliding; `null` if none is needed or none suffices.
    pub kick_m_per_s: Option<f64>,
    /// Damping ratio ζ_v above which no vibration persists; with mode coupling the one that just keeps steady sliding stable, `null`
    /// if none does.
    pub limit_damping_ratio: Option<f64>,
    /// Margin ζ − ζ_v; with mode coupling the margin of the friction coefficient, μ_c − μ.
    pub damping_margin: f64,
    /// 95 % interval of the margin, by the errors of a computed friction coefficient; `null` if it has none, and in results of earlier
    /// versions.
    #[serde(default)]
    pub damping_margin_interval: Option<Pair>,
}

/// Vibration of the machines that vibrate.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VibratingMachines {
    /// Fraction of each kind of motion.
    #[schemars(extend("propertyNames" = crate::choice::schema::<MotionKind>()))]
    pub kinds: BTreeMap<MotionKind, f64>,
    /// Frequency.
    pub frequency_hz: Option<Quantiles>,
    /// Half the difference of the largest and the smallest velocity.
    pub velocity_amplitude_m_per_s: Option<Quantiles>,
    /// Half the difference of the largest and the smallest displacement.
    pub displacement_amplitude_m: Option<Quantiles>,
}

/// Quantile of the margin.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MarginQuantile {
    /// Probability of a smaller margin.
    pub probability: f64,
    /// Margin ζ − ζ_v; with mode coupling the margin of the friction coefficient, μ_c − μ.
    pub damping_margin: f64,
}

/// Sensitivity to one uncertain value.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Driver {
    /// Name of the value, `section.key`.
    pub input: String,
    /// Fraction of the variance that the value explains alone.
    pub first_order: f64,
    /// Its 95 % interval.
    pub first_order_interval: Pair,
    /// Fraction of the variance that is left if all other values are known.
    pub total: f64,
    /// Its 95 % interval.
    pub total_interval: Pair,
    /// Shapley effect, a fraction of the variance; `null` for independent values.
    pub shapley: Option<f64>,
    /// Its 95 % interval.
    pub shapley_interval: Option<Pair>,
    /// Fraction by which the 5–95 % range of the margin narrows on average once the value is known; `null` for the event.
    pub range_reduction: Option<f64>,
}

/// Effect of one unknown value.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Guess {
    /// Name of the value, `section.key`.
    pub input: String,
    /// Probability of vibration with the value at its 5 % quantile.
    pub probability_at_q05: f64,
    /// Probability of vibration with the value at its 95 % quantile.
    pub probability_at_q95: f64,
}

/// Value at which the machine begins or ceases to vibrate while all its other values stay.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurningPoint {
    /// Name of the value, `section.key`.
    pub input: String,
    /// Unit of its values; empty for a number.
    pub unit: String,
    /// Present value.
    pub now: f64,
    /// The nearest such value between a tenth and ten times the present one; `null` if there is none.
    pub value: Option<f64>,
}

/// Effect of a number that the study does not state: asperity assumes a default, which counts as exact.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Assumed {
    /// Name of the value, `section.key`.
    pub input: String,
    /// The default.
    pub value: f64,
    /// Range of the value: 0.9 to 1 for `vibration.kinetic_share`, and 2.1 to 8.4, half to twice the default, for `vibration.stribeck`.
    pub range: Pair,
    /// `probability` with the value at the low and the high end of its range.
    pub probability_at: Pair,
    /// Their 95 % intervals: the error of the computation.
    pub probability_interval_at: [Pair; 2],
    /// `expected_vibration_share` with the value at the low and the high end of its range.
    pub expected_vibration_share_at: Pair,
}

/// Change of the central value of one input.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Remedy {
    /// Name of the value, `section.key`.
    pub input: String,
    /// SI unit of the value; empty for a number.
    pub unit: String,
    /// Damping that stays constant: `damper`, the coefficient c = 2ζmω₀ in N s/m, or `damping_ratio`, ζ; `null` for a change of the damping
    /// ratio itself.
    pub held: Option<String>,
    /// Its present central value.
    pub now: f64,
    /// Range in which values are searched.
    pub range: Pair,
    /// Friction coefficient at the present value.
    pub friction_coefficient_now: Option<f64>,
    /// Values that reach the target probabilities.
    pub reach: Vec<Reach>,
    /// Probability from the present value to beyond the farthest of these; of the first remedy that has one, empty for the others.
    #[serde(default)]
    pub risk: Vec<Risk>,
}

/// Probability at one central value.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Risk {
    /// The central value.
    pub value: f64,
    /// Probability of vibration.
    pub probability: f64,
}

/// Central value that reaches one probability.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reach {
    /// Probability of vibration.
    pub probability: f64,
    /// Nearest central value in the range at which vibration is at most as probable; `null` if there is none.
    pub value: Option<f64>,
    /// Its 95 % interval: the error of the computation.
    pub value_interval: Option<Pair>,
    /// Friction coefficient that is left there.
    pub friction_coefficient: Option<f64>,
}
