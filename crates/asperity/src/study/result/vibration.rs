//! The vibration stage in `results.json`.

use serde::Serialize;

use crate::study::result::{LawResult, Pair};

/// The vibration stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VibrationResult {
    /// The study's own damping ratio ζ.
    pub damping_ratio: f64,
    /// Dimensionless belt velocity V.
    pub belt_velocity: f64,
    /// Mean friction coefficient μ_st.
    pub static_friction: f64,
    /// Level of the friction stage that is used; `null` where it is the one at N/nominal_area, or friction is stated.
    pub level_percentile: Option<f64>,
    /// Mean pressure of that level.
    pub level_mean_pressure_pa: Option<f64>,
    /// Correlation length of μ.
    pub friction_correlation_length_m: f64,
    /// The same as sliding distance over N/c.
    pub correlation_length: f64,
    /// Marginal law of μ; `null` where friction is constant.
    pub marginal: Option<LawResult>,
    /// Variance of μ over the nominal area over that of one window.
    pub variance_reduction: f64,
    /// Damping ratio above which there is no deterministic limit cycle; `null` if there is none at any.
    pub critical_damping_ratio: Option<f64>,
    /// Damping ratio below which steady sliding is unstable.
    pub hopf_damping_ratio: Option<f64>,
    /// The deterministic cycle at the study's damping ratio.
    pub cycle: CycleResult,
    /// Which upscaling leads.
    pub upscaling: String,
    /// The stability map, if one is asked for; its numbers are tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<MapResult>,
    /// One window carries the whole normal force (the paper).
    pub paper: EnsembleResult,
    /// Windows average over the nominal area.
    pub area: EnsembleResult,
}

/// What a stability map is drawn over.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MapResult {
    /// First parameter: `damping_ratio` or `belt_velocity`.
    pub x: String,
    /// Second parameter: `belt_velocity`, `friction_std` or `load_ratio`.
    pub y: String,
}

/// A deterministic limit cycle; keys as in `asperity vibration cycle`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CycleResult {
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Whether there is a cycle.
    pub limit_cycle: bool,
    /// Period.
    pub period: Option<f64>,
    /// Duration of the slip.
    pub slip_duration: Option<f64>,
    /// Displacement at re-attachment.
    pub reattachment_displacement: Option<f64>,
    /// Least displacement.
    pub displacement_min: Option<f64>,
    /// Largest displacement.
    pub displacement_max: Option<f64>,
    /// Least velocity.
    pub velocity_min: Option<f64>,
}

/// Ensembles over the damping sweep for one upscaling.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EnsembleResult {
    /// Standard deviation of μ.
    pub friction_std: f64,
    /// Fraction of the friction values that are clipped to stay positive.
    pub clipped_fraction: f64,
    /// One entry per damping ratio.
    pub damping: Vec<DampingResult>,
    /// Where the mean number of cycles falls through shares of its value at the least damping ratio.
    pub crossings: Vec<CrossingResult>,
    /// The law of the re-attachment points at the study's damping ratio.
    pub reattachment: PointsResult,
    /// The law of the points at which the mass leaves the belt there.
    pub release: PointsResult,
    /// The cycle there; absent where friction is constant.
    pub motion: Option<MotionResult>,
}

/// Where the mean number of cycles falls through a share.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CrossingResult {
    /// Share of the number at the least damping ratio of the sweep.
    pub share: f64,
    /// The damping ratio, interpolated.
    pub damping_ratio: f64,
    /// Its interval.
    pub damping_ratio_interval: Pair,
}

/// The cycle in time: how regular it is, and how surely it goes on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionResult {
    /// Mean time τ from one cycle to the next, as long as the cycle is not lost.
    pub period_mean: Option<f64>,
    /// Its standard deviation.
    pub period_std: Option<f64>,
    /// Share of the time in stick.
    pub stick_share: f64,
    /// Its standard error over trajectories.
    pub stick_share_se: f64,
    /// Share of the time in the cycle.
    pub share_in_cycle: f64,
    /// Losses of the cycle per τ in it.
    pub exit_rate: Option<f64>,
    /// Its interval.
    pub exit_rate_interval: Option<Pair>,
    /// Returns to the cycle per τ out of it.
    pub entry_rate: Option<f64>,
    /// Its interval.
    pub entry_rate_interval: Option<Pair>,
    /// Share of the trajectories that lose the cycle at all.
    pub left_share: f64,
    /// Its interval.
    pub left_share_interval: Pair,
}

/// Cycle counts at one damping ratio.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DampingResult {
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Slips that reach a negative velocity, without noise.
    pub cycles_deterministic: u64,
    /// Their mean number with noise.
    pub cycles_mean: f64,
    /// Its standard error.
    pub cycles_se: f64,
    /// M_diff = M_det − E M.
    pub difference_mean: f64,
    /// Its interval.
    pub difference_interval: Pair,
    /// Share of the time in the cycle.
    pub share_in_cycle: f64,
    /// Share of the trajectories that sustain the cycle: they are in it for half of the second half of their time at least.
    pub sustained_share: f64,
    /// Its interval.
    pub sustained_share_interval: Pair,
    /// Trajectories that failed.
    pub failed_samples: usize,
}

/// The law of points met along the trajectories.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
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
