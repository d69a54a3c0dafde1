//! The vibration stage in `results.json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{DistributionResult, Pair};

crate::choice! {
    /// Kind of motion that a machine settles into.
    #[derive(Default)]
    pub enum MotionKind: "kind of motion" {
        /// The mass sticks to the belt in every period.
        StickSlip = "stick_slip": "stick-slip",
        /// The mass passes the velocity of the belt (the relative velocity changes its sign) and never sticks.
        Overtaking = "overtaking",
        /// The mass stays slower than the belt throughout the period.
        SlipCycle = "slip_cycle",
        /// Two modes that friction couples grow to a vibration.
        Flutter = "flutter",
        /// Friction pulls the mass away without vibration.
        Divergence = "divergence",
        /// Steady sliding.
        #[default]
        None = "none": "steady sliding",
    }
}

impl MotionKind {
    /// Returns whether the motion is vibration.
    pub fn is_vibration(self) -> bool {
        !matches!(self, Self::None | Self::Divergence)
    }
}

/// The vibration stage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VibrationResult {
    /// Damping ratio ζ of the study.
    pub damping_ratio: f64,
    /// Dimensionless belt velocity V.
    pub belt_velocity: f64,
    /// Mean friction coefficient μ_st.
    pub static_friction: f64,
    /// Percentile of the level of the friction stage that is used; `null` if the level is at N/nominal_area or friction is stated.
    pub level_percentile: Option<f64>,
    /// Mean pressure of the level of the friction stage.
    pub level_mean_pressure_pa: Option<f64>,
    /// Correlation length of μ; `null` for a rough slider, whose friction is constant for each part.
    pub friction_correlation_length_m: Option<f64>,
    /// Correlation length of μ in X, as sliding distance over N/c.
    pub correlation_length: Option<f64>,
    /// Marginal distribution of μ; `null` if friction is constant.
    pub marginal: Option<DistributionResult>,
    /// Variance of μ over the nominal area divided by the variance of one window.
    pub variance_reduction: f64,
    /// Damping ratio ζ_c above which no cycle reaches the belt velocity; `null` if the search failed.
    pub critical_damping_ratio: Option<f64>,
    /// Damping ratio ζ_H below which steady sliding is unstable.
    pub hopf_damping_ratio: Option<f64>,
    /// Damping ratio ζ_v above which no vibration persists; `null` if the search failed.
    pub limit_damping_ratio: Option<f64>,
    /// Kind of motion without fluctuation, started in stick, at the study's damping ratio.
    pub kind: MotionKind,
    /// Whether steady sliding is unstable at the study's damping ratio; `null` under forcing.
    pub steady_sliding_unstable: Option<bool>,
    /// Smallest change of velocity, of either sign, after which a machine that slides steadily vibrates; `null` if none is
    /// needed, none suffices, or under forcing.
    pub kick_m_per_s: Option<f64>,
    /// The deterministic motion at the study's damping ratio.
    pub cycle: CycleResult,
    /// Upscaling that the study uses: `area` or `paper`; both are computed.
    pub upscaling: String,
    /// The stability map, if one is asked for; its numbers are tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<MapResult>,
    /// One window carries the whole normal force (the paper).
    pub paper: EnsembleResult,
    /// Windows average over the nominal area.
    pub area: EnsembleResult,
}

impl VibrationResult {
    /// Returns whether one window carries the whole normal force in the study.
    pub fn is_of_one_window(&self) -> bool {
        self.upscaling == "paper"
    }

    /// Returns the ensembles of the upscaling that the study uses.
    pub fn of_study(&self) -> &EnsembleResult {
        if self.is_of_one_window() { &self.paper } else { &self.area }
    }
}

/// Parameters and resolution of a stability map.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapResult {
    /// First parameter: `damping_ratio` or `belt_velocity`.
    pub x: String,
    /// Second parameter: `belt_velocity`, `friction_std` or `load_ratio`.
    pub y: String,
    /// Widths of the smallest cells, and whether they resolve the transition.
    pub resolution: MapResolutionResult,
}

/// Resolution of the transition of the probability in a map.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapResolutionResult {
    /// Width of the smallest cells along x.
    pub x: f64,
    /// Width of the smallest cells along y.
    pub y: f64,
    /// Fraction of the cells on the contour of 50 % in which the probability falls from 95 % to 5 %, so that the width of the
    /// transition is less than a cell and not known.
    pub unresolved_share: f64,
}

/// A deterministic limit cycle of any kind; keys as in `asperity vibration cycle`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CycleResult {
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Whether there is a cycle.
    pub limit_cycle: bool,
    /// Period τ.
    pub period: Option<f64>,
    /// Duration τ of the slip.
    pub slip_duration: Option<f64>,
    /// Displacement X at re-attachment.
    pub reattachment_displacement: Option<f64>,
    /// Least displacement X.
    pub displacement_min: Option<f64>,
    /// Largest displacement X.
    pub displacement_max: Option<f64>,
    /// Least velocity dX/dτ.
    pub velocity_min: Option<f64>,
}

/// Ensembles over the damping sweep for one upscaling.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnsembleResult {
    /// Standard deviation of μ.
    pub friction_std: f64,
    /// Fraction of the friction values that are clipped to stay positive.
    pub clipped_fraction: f64,
    /// One entry per damping ratio.
    pub damping: Vec<DampingResult>,
    /// Damping ratios at which vibration falls below 95, 50 and 5 % of the second half of the duration.
    pub crossings: Vec<CrossingResult>,
    /// Distribution of the re-attachment points at the study's damping ratio.
    pub reattachment: PointsResult,
    /// Distribution of the points at which the mass leaves the belt, at the study's damping ratio.
    pub release: PointsResult,
    /// Motion in time at the study's damping ratio; `null` if friction is constant.
    pub motion: Option<MotionResult>,
}

/// Damping ratio at which the mean fraction of the second half of the duration spent in vibration, started in stick, falls below
/// a level.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrossingResult {
    /// Fraction of the second half of the time in vibration.
    pub share: f64,
    /// Damping ratio; `null` if there is none.
    pub damping_ratio: Option<f64>,
    /// 95 % interval of `damping_ratio`.
    pub damping_ratio_interval: Option<Pair>,
    /// Reason why there is no damping ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// Regularity and persistence of vibration.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionResult {
    /// Mean time τ from one cycle to the next, as long as vibration is not lost.
    pub period_mean: Option<f64>,
    /// Standard deviation of the time τ from one cycle to the next.
    pub period_std: Option<f64>,
    /// Fraction of the time in stick.
    pub stick_share: f64,
    /// Standard error of `stick_share` over trajectories.
    pub stick_share_se: f64,
    /// Fraction of the time in vibration.
    pub share_in_cycle: f64,
    /// Fraction of the time in each kind of motion.
    #[schemars(extend("propertyNames" = crate::choice::schema::<MotionKind>()))]
    pub kind_shares: BTreeMap<MotionKind, f64>,
    /// Losses of vibration per τ in it.
    pub exit_rate: Option<f64>,
    /// 95 % interval of `exit_rate`.
    pub exit_rate_interval: Option<Pair>,
    /// Returns to vibration per τ out of it.
    pub entry_rate: Option<f64>,
    /// 95 % interval of `entry_rate`.
    pub entry_rate_interval: Option<Pair>,
    /// Fraction of the trajectories that leave vibration at all.
    pub left_share: f64,
    /// 95 % interval of `left_share`.
    pub left_share_interval: Pair,
}

/// Cycle counts at one damping ratio.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DampingResult {
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Kind of motion without noise.
    pub kind: MotionKind,
    /// Slips that reach a negative velocity, without noise.
    pub cycles_deterministic: u64,
    /// Mean number of slips that reach a negative velocity, with noise.
    pub cycles_mean: f64,
    /// Standard error of `cycles_mean`.
    pub cycles_se: f64,
    /// Slips lost by noise, M_diff = M_det − E M.
    pub difference_mean: f64,
    /// 95 % interval of `difference_mean`.
    pub difference_interval: Pair,
    /// Fraction of the time in vibration.
    pub share_in_cycle: f64,
    /// Mean fraction of the second half of the time in vibration.
    pub vibration_share: f64,
    /// Standard error of `vibration_share`.
    pub vibration_share_se: f64,
    /// Fraction of the trajectories that vibrate for at least half of the second half of their time.
    pub sustained_share: f64,
    /// 95 % interval of `sustained_share`.
    pub sustained_share_interval: Pair,
    /// Trajectories that failed.
    pub failed_samples: usize,
}

/// Distribution of points along the trajectories.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointsResult {
    /// Number of points.
    pub count: u64,
    /// Mean displacement.
    pub mean: Option<f64>,
    /// Standard deviation.
    pub std: Option<f64>,
    /// Skewness.
    pub skewness: Option<f64>,
    /// Excess kurtosis.
    pub excess_kurtosis: Option<f64>,
    /// p-value of normality.
    pub normality_p: Option<f64>,
}
