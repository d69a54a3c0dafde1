//! The friction stage in `results.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{CutoffResult, LawResult, Pair, Prescribed, UncertaintyResult};

/// The friction stage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionResult {
    /// Length of the window.
    pub window_m: f64,
    /// Width of the window.
    pub window_width_m: f64,
    /// Width of the strip.
    pub strip_width_m: f64,
    /// Mean compliance of a periodic strip.
    pub mean_compliance_m_per_pa: Option<f64>,
    /// Strips per level.
    pub realisations: usize,
    /// The friction coefficient that drives the vibration, and that the report and the program state.
    pub operating_point: OperatingPoint,
    /// Levels of contact.
    pub levels: Vec<LevelResult>,
    /// Mean friction against the shortest waves kept; absent for Coulomb's law, and where it could not be solved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutoff: Option<CutoffResult>,
    /// What uncertain parameters of the surface do; absent where none is stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyResult>,
}

/// The friction coefficient at the operating point: of the level at the nominal pressure, of the percentile that the study
/// names or, without a vibration stage, of the level pressed hardest. Windows count by the load they carry, as in
/// [`AtMeanLoad`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingPoint {
    /// The level in words.
    pub level: String,
    /// Percentage of the heights above the plane; `null` where that is not prescribed.
    pub percentile: Option<f64>,
    /// Mean depth of the plane below the highest point of each strip.
    pub penetration_m: f64,
    /// Mean pressure.
    pub mean_pressure_pa: f64,
    /// Contact area over nominal area, corrected: the probability of contact at a point.
    pub contact_fraction: f64,
    /// Its interval; `null` where the strips hold too few correlation lengths.
    pub contact_fraction_interval: Option<Pair>,
    /// The friction coefficient μ̄ = ΣF/ΣN.
    pub mean: f64,
    /// Its interval; `null` where the strips hold too few correlation lengths.
    pub mean_interval: Option<Pair>,
    /// Standard deviation of one window.
    pub std: f64,
    /// Its interval.
    pub std_interval: Option<Pair>,
    /// Standard deviation of the mean over the nominal area.
    pub std_nominal_area: f64,
}

/// One level of the friction stage: the quotient F/N of each window, and under `at_mean_load` the process.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelResult {
    /// Whether this is the level that is shown in full and handed to the vibration stage.
    pub leading: bool,
    /// Prescribed quantity.
    pub control: Prescribed,
    /// Percentage of the heights above the plane; `null` where that is not prescribed.
    pub percentile: Option<f64>,
    /// Mean depth of the plane below the highest point of each strip.
    pub penetration_m: f64,
    /// Mean pressure.
    pub mean_pressure_pa: f64,
    /// Contact area over nominal area, corrected.
    pub contact_fraction: f64,
    /// Share of the contact cells at the hardness.
    pub plastic_share: f64,
    /// Mean of F/N; `null` where it does not exist (tail index of at most 1).
    pub mean: Option<f64>,
    /// Its interval, which as all of μ knows the correlation along the strips; `null` where they hold too few correlation
    /// lengths.
    pub mean_interval: Option<Pair>,
    /// Standard deviation of F/N; with all that needs a variance `null` where [`LevelResult::no_variance`] says why.
    pub std: Option<f64>,
    /// Its interval.
    pub std_interval: Option<Pair>,
    /// Standard deviation over mean.
    pub coefficient_of_variation: Option<f64>,
    /// Its interval.
    pub coefficient_of_variation_interval: Option<Pair>,
    /// Skewness of μ; `null` where μ does not vary.
    pub skewness: Option<f64>,
    /// Its interval.
    pub skewness_interval: Option<Pair>,
    /// Excess kurtosis of μ; `null` where μ does not vary.
    pub excess_kurtosis: Option<f64>,
    /// Its interval.
    pub excess_kurtosis_interval: Option<Pair>,
    /// ℓ_μ of the exponential fit; it contains the window.
    pub correlation_length_m: Option<f64>,
    /// Its interval.
    pub correlation_length_m_interval: Option<Pair>,
    /// Length that is left when the window is taken out, fitted jointly over windows of W to W/8; 0 where they explain
    /// everything.
    pub correlation_length_without_window_m: Option<f64>,
    /// Its interval.
    pub correlation_length_without_window_m_interval: Option<Pair>,
    /// Model that it is the length of.
    pub correlation_without_window_model: Option<String>,
    /// Probability of a spectrum at least as far from that model's where it holds.
    pub correlation_without_window_fit_p: Option<f64>,
    /// Probability that the windows one by one give lengths as different where one length holds under all.
    pub correlation_without_window_agreement_p: Option<f64>,
    /// Whether that interval includes what cannot be told from 0, less than a step: the correlation is the window's.
    pub window_only: Option<bool>,
    /// Marginal law ranked first by Akaike's criterion.
    pub marginal: Option<LawResult>,
    /// Intervals of its fitted parameters.
    pub marginal_parameter_intervals: BTreeMap<String, Option<Pair>>,
    /// How well it fits.
    pub gof: Option<GoodnessResult>,
    /// Values that μ of a window exceeds once in a sliding distance; empty where the strips hold too few separate peaks.
    pub return_levels: Vec<ReturnLevelResult>,
    /// How μ of a window is distributed far above the others; `null` where the strips hold too few separate peaks.
    pub tail: Option<TailResult>,
    /// The Beta law with bounds fitted by likelihood.
    pub beta: Option<LawResult>,
    /// Why F/N has no variance, and so no standard deviation, marginal law or return levels; `null` where it has one.
    pub no_variance: Option<String>,
    /// Windows without contact, left out.
    pub empty_windows: usize,
    /// The process that a body feels which rests on many windows.
    pub at_mean_load: AtMeanLoad,
    /// Whether friction drifts along the strips; `null` where it does not vary.
    pub stationarity: Option<StationarityResult>,
    /// Contact area against load of the windows; `null` where one of them does not vary.
    pub area_and_load: Option<CrossResult>,
    /// From one window to the nominal area.
    pub upscaling: UpscalingResult,
    /// Mean number of contact cells in a window.
    pub contact_cells_per_window: f64,
    /// Share of windows with fewer than 30 contact cells.
    pub sparse_window_share: f64,
    /// Independent windows that the correlated ones are worth.
    pub effective_windows: f64,
    /// Strips that failed.
    pub failed_samples: usize,
}

/// Friction at constant load, μ̄ + (F − μ̄N)/N̄ with the force F and load N of a window; what the vibration stage takes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AtMeanLoad {
    /// μ̄ = ΣF/ΣN.
    pub mean: f64,
    /// Its interval: the error of the quotient is, to first order, that of the mean of μ̄ + (F − μ̄N)/N̄.
    pub mean_interval: Option<Pair>,
    /// Standard deviation.
    pub std: f64,
    /// Its interval.
    pub std_interval: Option<Pair>,
    /// Skewness; `null` where friction does not vary.
    pub skewness: Option<f64>,
    /// Excess kurtosis; `null` where friction does not vary.
    pub excess_kurtosis: Option<f64>,
    /// ℓ of the exponential fit; it contains the window.
    pub correlation_length_m: Option<f64>,
    /// Its interval.
    pub correlation_length_m_interval: Option<Pair>,
    /// Curves fitted to the correlation, the closest first; their ℓ contains the window.
    pub correlation_curves: Vec<CorrelationCurveResult>,
    /// Models of the correlation that is left when the window is taken out, the most likely first.
    pub correlation_models: Vec<CorrelationModelResult>,
    /// Marginal law ranked first by Akaike's criterion.
    pub marginal: Option<LawResult>,
    /// Intervals of its fitted parameters.
    pub marginal_parameter_intervals: BTreeMap<String, Option<Pair>>,
    /// How well it fits; `null` for the windows' own law.
    pub gof: Option<GoodnessResult>,
    /// All laws that were fitted, the first by Akaike's criterion first. `marginal` is the first whose ends the windows see.
    pub laws: Vec<RankedLawResult>,
    /// Independent windows that the correlated ones are worth.
    pub effective_windows: f64,
}

/// A law among others.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RankedLawResult {
    /// Name; `shifted_` where a shift was fitted, `empirical` for the windows' own law.
    pub name: String,
    /// Akaike's criterion, of as many independent windows as the correlated ones are worth, less that of the first law.
    pub aic_difference: f64,
    /// How well it fits; `null` for the windows' own law.
    pub gof: Option<GoodnessResult>,
}

/// Distances between the windows and the marginal law, with p-values that know that the law was fitted and how the windows are
/// correlated.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoodnessResult {
    /// Largest difference of the distribution functions.
    pub kolmogorov_smirnov: f64,
    /// Probability of a larger one if the law is right.
    pub kolmogorov_smirnov_p: f64,
    /// A², which weighs the tails and grows with the number of windows; `null` where a window lies at an end of the law.
    pub anderson_darling: Option<f64>,
    /// Probability of a larger one if the law is right.
    pub anderson_darling_p: Option<f64>,
}

/// A curve fitted to the estimated correlation by least squares.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorrelationCurveResult {
    /// Its name.
    pub model: String,
    /// ℓ, which contains the window.
    pub length_m: f64,
    /// Root mean square difference from the estimated correlation.
    pub misfit: f64,
}

/// A model of the correlation without the window, fitted by likelihood.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorrelationModelResult {
    /// Its name.
    pub model: String,
    /// ℓ; 0 where the window explains everything.
    pub length_m: f64,
    /// Its interval.
    pub length_interval: Pair,
    /// Akaike's criterion less that of the best.
    pub aic_difference: f64,
    /// Whether the best is better beyond chance.
    pub worse_beyond_chance: bool,
}

/// Tests of friction against drifts along the strips, at the mean load: probabilities of at least as much if there is none.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StationarityResult {
    /// Slope of μ along the strip.
    pub trend_per_m: Option<f64>,
    /// Of the slope.
    pub trend_p: Option<f64>,
    /// Of the difference between the means of the halves.
    pub mean_change_p: Option<f64>,
    /// Of the difference between ends and middle.
    pub ends_p: Option<f64>,
    /// Of the difference between the variances of the halves.
    pub variance_change_p: Option<f64>,
    /// Of the wander of the mean; `null` where there are ten strips or more.
    pub wander_p: Option<f64>,
}

/// A correlation coefficient of two quantities of the same windows.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrossResult {
    /// The coefficient.
    pub correlation: f64,
    /// Its interval.
    pub interval: Pair,
}

/// The upper tail of μ: peaks over a threshold follow a generalised Pareto law.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TailResult {
    /// Largest value.
    pub largest: f64,
    /// The threshold.
    pub threshold: f64,
    /// Separate peaks above it.
    pub peaks: usize,
    /// Shape ξ: the tail ends below 0, is exponential at 0, and has no moments beyond the order 1/ξ above.
    pub shape: f64,
    /// Its interval.
    pub shape_interval: Pair,
}

/// A value that μ exceeds once in a distance on average.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReturnLevelResult {
    /// Sliding distance.
    pub distance_m: f64,
    /// The value.
    pub mu: f64,
    /// Its interval; `null` where the likelihood does not end it.
    pub interval: Option<Pair>,
}

/// The scatter of friction at the mean load under both upscalings.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UpscalingResult {
    /// One window carries the whole normal force (the paper).
    pub paper: PaperScatter,
    /// Windows average over the nominal area.
    pub area: AreaScatter,
}

/// Friction of one window.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperScatter {
    /// Standard deviation of μ.
    pub std: f64,
}

/// Friction of the nominal area.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AreaScatter {
    /// The nominal area.
    pub nominal_area_m2: f64,
    /// Windows that it holds.
    pub windows: f64,
    /// Variance of μ over the nominal area over that of one window.
    pub variance_reduction: f64,
    /// Standard deviation of μ.
    pub std: f64,
}
