//! The friction stage in `results.json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{CutoffResult, DistributionResult, Pair, Prescribed, ScanFriction, UncertaintyResult};

/// The friction stage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionResult {
    /// Body that is rough. Unless it is the track alone, windows along the strips are no path: correlation lengths, drifts and
    /// return levels are `null` or empty, and standard deviations are those between windows of different parts.
    #[serde(default)]
    pub body: RoughBody,
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
    /// Mean friction over the shortest wavelength; absent for Coulomb's law, and if there is no solution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutoff: Option<CutoffResult>,
    /// Friction of the scan itself at the operating point; `null` without a scan.
    #[serde(default)]
    pub scan: Option<ScanFriction>,
    /// Friction over uncertain parameters of the surface; absent if the study states none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyResult>,
}

impl FrictionResult {
    /// Returns the level at the operating point.
    pub fn operating_level(&self) -> Option<&LevelResult> {
        self.levels.iter().find(|level| level.leading).or(self.levels.first())
    }
}

crate::choice! {
    /// Rough body of a sliding contact.
    ///
    /// Friction fluctuates along the path only if new contacts form on the way. A rough slider on a smooth track carries its
    /// contacts along, so the friction coefficient of a part is constant and parts differ by a constant.
    #[derive(Default)]
    pub enum RoughBody: "rough body" {
        /// A smooth slider passes over a rough track: friction fluctuates along the path.
        #[default]
        Track = "track",
        /// A rough slider on a smooth track carries its contacts along: friction is constant for each part.
        Slider = "slider",
        /// Both: friction differs from part to part and fluctuates along the path.
        Both = "both",
    }
}

/// Largest `saturation` at which the roughness hardly matters.
pub const SATURATED: f64 = 0.05;

/// The friction coefficient at the operating point: the level at the nominal pressure, the percentile that the study names or,
/// without a vibration stage, the level with the highest pressure. Windows are weighted by the load they carry, as in
/// `at_mean_load`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OperatingPoint {
    /// The level in words.
    pub level: String,
    /// Percentage of the heights above the plane; `null` if not prescribed.
    pub percentile: Option<f64>,
    /// Mean depth of the plane below the highest point of each strip.
    pub penetration_m: f64,
    /// Mean pressure.
    pub mean_pressure_pa: f64,
    /// Contact area over nominal area, corrected: the probability of contact at a point.
    pub contact_fraction: f64,
    /// 95 % interval of `contact_fraction`; `null` if the strips contain too few correlation lengths.
    pub contact_fraction_interval: Option<Pair>,
    /// Contact stiffness −dp̄/dḡ over the nominal area, with the mean gap ḡ, against unloading and small vibration: plastic cells
    /// move elastically too, and the mean compliance is not part of it. `null` on free strips.
    #[serde(default)]
    pub contact_stiffness_pa_per_m: Option<f64>,
    /// Standard error of `contact_stiffness_pa_per_m` over the strips.
    #[serde(default)]
    pub contact_stiffness_pa_per_m_se: Option<f64>,
    /// The friction coefficient μ̄ = ΣF/ΣN.
    pub mean: f64,
    /// 95 % interval of `mean` with its whole error: the computation, the difference between random and scanned surface, and the limited
    /// scan. `null` if strips or scan contain too few correlation lengths.
    pub mean_interval: Option<Pair>,
    /// 95 % interval of `mean` for the random surface: the sampling of its strips and their pitch.
    #[serde(default)]
    pub mean_computational_interval: Option<Pair>,
    /// 95 % interval of `mean` due to the sampling of strips alone.
    #[serde(default)]
    pub mean_sampling_interval: Option<Pair>,
    /// The friction coefficient of the scan itself with all its waves, pressed at the same mean pressure; `null` without a scan, with a
    /// rough counterface, and for laws that do not depend on the contact.
    #[serde(default)]
    pub mean_of_scan: Option<f64>,
    /// Error of `mean` after its extrapolation in the pitch of the strips: the last term of the series; `null` if half the pitch has no
    /// solution.
    #[serde(default)]
    pub grid_error: Option<f64>,
    /// 1 − (τ_max/H)/`mean`: the fraction of `mean` that depends on the surface; `null` without a hardness.
    #[serde(default)]
    pub saturation: Option<f64>,
    /// Whether the strips resolve the surface and resemble the scan: errors of the pitch of at most 3 %, rms slopes and friction
    /// within 15 % of those of the scan.
    #[serde(default)]
    pub resolved: bool,
    /// Standard deviation of one window.
    pub std: f64,
    /// 95 % interval of `std`.
    pub std_interval: Option<Pair>,
    /// Standard deviation of the mean over the nominal area.
    pub std_nominal_area: f64,
}

/// One level of the friction stage: the quotient F/N of each window, and the process at the mean load.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LevelResult {
    /// Whether this level is the operating point.
    pub leading: bool,
    /// Prescribed quantity.
    pub control: Prescribed,
    /// Percentage of the heights above the plane; `null` if not prescribed.
    pub percentile: Option<f64>,
    /// Mean depth of the plane below the highest point of each strip.
    pub penetration_m: f64,
    /// Mean pressure.
    pub mean_pressure_pa: f64,
    /// Contact area over nominal area, corrected.
    pub contact_fraction: f64,
    /// Fraction of the contact cells at the hardness.
    pub plastic_share: f64,
    /// Mean of F/N; `null` where it does not exist (tail index of at most 1).
    pub mean: Option<f64>,
    /// 95 % interval of `mean`, which allows for the correlation along the strips; `null` if they contain too few correlation lengths.
    pub mean_interval: Option<Pair>,
    /// Standard deviation of F/N. Without a variance, for the reason in `no_variance`, it is `null`, and so is every
    /// other number that needs one.
    pub std: Option<f64>,
    /// 95 % interval of `std`.
    pub std_interval: Option<Pair>,
    /// Standard deviation over mean.
    pub coefficient_of_variation: Option<f64>,
    /// 95 % interval of `coefficient_of_variation`.
    pub coefficient_of_variation_interval: Option<Pair>,
    /// Skewness of μ; `null` if μ does not vary.
    pub skewness: Option<f64>,
    /// 95 % interval of `skewness`.
    pub skewness_interval: Option<Pair>,
    /// Excess kurtosis of μ; `null` if μ does not vary.
    pub excess_kurtosis: Option<f64>,
    /// 95 % interval of `excess_kurtosis`.
    pub excess_kurtosis_interval: Option<Pair>,
    /// Correlation length ℓ of the exponential fit, with the effect of the window.
    pub correlation_length_m: Option<f64>,
    /// 95 % interval of `correlation_length_m`.
    pub correlation_length_m_interval: Option<Pair>,
    /// Marginal distribution ranked first by Akaike's criterion.
    pub marginal: Option<DistributionResult>,
    /// Intervals of its fitted parameters.
    pub marginal_parameter_intervals: BTreeMap<String, Option<Pair>>,
    /// Goodness of fit.
    pub gof: Option<GoodnessResult>,
    /// Values that μ of a window exceeds once in a sliding distance; empty if the strips contain too few separate peaks.
    pub return_levels: Vec<ReturnLevelResult>,
    /// Upper tail of μ of a window; `null` if the strips contain too few separate peaks.
    pub tail: Option<TailResult>,
    /// The beta distribution with bounds fitted by likelihood.
    pub beta: Option<DistributionResult>,
    /// Reason why F/N has no variance, and so no standard deviation, marginal distribution or return levels; `null` if it has one.
    pub no_variance: Option<String>,
    /// Windows without contact, left out.
    pub empty_windows: usize,
    /// Friction of a body that rests on many windows, as a process.
    #[serde(flatten)]
    pub process: LevelProcess,
    /// Mean number of contact cells in a window.
    pub contact_cells_per_window: f64,
    /// Fraction of the windows with fewer than 30 contact cells.
    pub sparse_window_share: f64,
    /// Effective number of independent windows.
    pub effective_windows: f64,
    /// Strips that failed.
    pub failed_samples: usize,
}

/// Friction of a level at the mean load as a process along the path, and its upscaling.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LevelProcess {
    /// Correlation length without the window, fitted jointly over windows of W to W/8; 0 if the windows explain the whole
    /// correlation.
    pub correlation_length_without_window_m: Option<f64>,
    /// 95 % interval of `correlation_length_without_window_m`.
    pub correlation_length_without_window_m_interval: Option<Pair>,
    /// Correlation family of the length without the window: `exponential`, or the smooth `matern` of ν = 5/2.
    pub correlation_without_window_model: Option<String>,
    /// Whether the strips tell the two correlation families apart. If not, the exponential is used, and the interval of its length
    /// covers the integral scales ∫ρ ds of both.
    #[serde(default)]
    pub correlation_families_told_apart: Option<bool>,
    /// p-value of the fit of the correlation family to the spectrum.
    pub correlation_without_window_fit_p: Option<f64>,
    /// p-value of the agreement between the lengths under each window alone.
    pub correlation_without_window_agreement_p: Option<f64>,
    /// Whether the correlation is due to the window alone, as the interval of the length without it includes lengths below one step.
    pub window_only: Option<bool>,
    /// Standard deviation between parts of the slider at the mean load, for one window; friction of a part differs from the mean by a
    /// constant. `null` for a smooth slider and, if both bodies are rough, at other levels than the operating point and for free
    /// strips. The fluctuation along the path has the rest of the variance of `at_mean_load`.
    pub between_parts_std: Option<f64>,
    /// 95 % interval of `between_parts_std`; `null` with fewer than four strips.
    pub between_parts_std_interval: Option<Pair>,
    /// Friction of a body that rests on many windows.
    pub at_mean_load: AtMeanLoad,
    /// Whether friction drifts along the strips; `null` if it does not vary.
    pub stationarity: Option<StationarityResult>,
    /// Contact area against load of the windows; `null` if one of them does not vary.
    pub area_and_load: Option<CrossResult>,
    /// Standard deviations over the nominal area.
    pub upscaling: UpscalingResult,
}

/// Friction at constant load, μ̄ + (F − μ̄N)/N̄ with the force F and load N of a window; it drives the vibration stage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AtMeanLoad {
    /// Mean friction coefficient μ̄ = ΣF/ΣN.
    pub mean: f64,
    /// 95 % interval of `mean`: the error of the quotient is, to first order, that of the mean of μ̄ + (F − μ̄N)/N̄.
    pub mean_interval: Option<Pair>,
    /// Standard deviation.
    pub std: f64,
    /// 95 % interval of `std`.
    pub std_interval: Option<Pair>,
    /// Skewness; `null` if friction does not vary.
    pub skewness: Option<f64>,
    /// Excess kurtosis; `null` if friction does not vary.
    pub excess_kurtosis: Option<f64>,
    /// Correlation length ℓ of the exponential fit, with the effect of the window.
    pub correlation_length_m: Option<f64>,
    /// 95 % interval of `correlation_length_m`.
    pub correlation_length_m_interval: Option<Pair>,
    /// Both families fitted to the correlation, the closest first; their ℓ includes the effect of the window.
    pub correlation_curves: Vec<CorrelationCurveResult>,
    /// Both families fitted without the effect of the window, jointly over windows of W to W/8, the more likely first.
    pub correlation_models: Vec<CorrelationModelResult>,
    /// Marginal distribution ranked first by Akaike's criterion.
    pub marginal: Option<DistributionResult>,
    /// Intervals of its fitted parameters.
    pub marginal_parameter_intervals: BTreeMap<String, Option<Pair>>,
    /// Goodness of fit; `null` for the empirical distribution.
    pub gof: Option<GoodnessResult>,
    /// All fitted distributions, ordered by Akaike's criterion. `marginal` is the first whose ends lie within the data.
    pub laws: Vec<RankedDistributionResult>,
    /// Effective number of independent windows.
    pub effective_windows: f64,
}

/// A fitted distribution in the ranking.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RankedDistributionResult {
    /// Name; it begins with `shifted_` if a shift was fitted, and is `empirical` for the windows' own distribution.
    pub name: String,
    /// Difference of Akaike's criterion from the first distribution, for the effective number of independent windows.
    pub aic_difference: f64,
    /// Goodness of fit; `null` for the empirical distribution.
    pub gof: Option<GoodnessResult>,
}

/// Distances between the windows and the marginal distribution. The p-values allow for the fit and for the correlation of the windows.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GoodnessResult {
    /// Kolmogorov–Smirnov distance, the largest difference of the distribution functions.
    pub kolmogorov_smirnov: f64,
    /// p-value of the Kolmogorov–Smirnov distance.
    pub kolmogorov_smirnov_p: f64,
    /// Anderson–Darling statistic A²; `null` if a window lies at an end of the distribution.
    pub anderson_darling: Option<f64>,
    /// p-value of the Anderson–Darling statistic.
    pub anderson_darling_p: Option<f64>,
}

/// A curve fitted to the estimated correlation by least squares.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CorrelationCurveResult {
    /// Name of the family.
    pub model: String,
    /// Correlation length ℓ, with the effect of the window.
    pub length_m: f64,
    /// Root mean square difference from the estimated correlation.
    pub misfit: f64,
}

/// A correlation family fitted by likelihood, without the window.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CorrelationModelResult {
    /// Name of the family.
    pub model: String,
    /// Correlation length ℓ without the effect of the window; 0 if that explains the whole correlation.
    pub length_m: f64,
    /// 95 % interval of `length_m`.
    pub length_interval: Pair,
    /// Difference of −2 ln L from the more likely family; divided by the variance of the scores relative to Gaussian strips.
    pub aic_difference: f64,
    /// Whether the strips reject this family: the likelihood of the other is at least 20 times as large.
    pub worse_beyond_chance: bool,
}

/// Tests for drifts of friction along the strips, at the mean load, as p-values of no drift.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StationarityResult {
    /// Slope of μ along the strip.
    pub trend_per_m: Option<f64>,
    /// p-value of the slope.
    pub trend_p: Option<f64>,
    /// p-value of the difference between the means of the halves.
    pub mean_change_p: Option<f64>,
    /// p-value of the difference between ends and middle.
    pub ends_p: Option<f64>,
    /// p-value of the difference between the variances of the halves.
    pub variance_change_p: Option<f64>,
    /// p-value of the wander of the mean; `null` for ten strips or more.
    pub wander_p: Option<f64>,
}

/// A correlation coefficient of two quantities of the same windows.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrossResult {
    /// Correlation of contact area and load.
    pub correlation: f64,
    /// 95 % interval of `correlation`.
    pub interval: Pair,
}

/// Upper tail of μ: a generalised Pareto distribution of the peaks over a threshold.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TailResult {
    /// Largest value.
    pub largest: f64,
    /// Threshold of the peaks.
    pub threshold: f64,
    /// Number of separate peaks above the threshold.
    pub peaks: usize,
    /// Shape ξ: the tail ends below 0, is exponential at 0, and has no moments beyond the order 1/ξ above.
    pub shape: f64,
    /// 95 % interval of `shape`.
    pub shape_interval: Pair,
}

/// A value that μ exceeds once in a distance on average.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReturnLevelResult {
    /// Sliding distance.
    pub distance_m: f64,
    /// Value of μ.
    pub mu: f64,
    /// 95 % interval of `mu`; `null` if the likelihood does not bound it.
    pub interval: Option<Pair>,
}

/// Standard deviation of friction at the mean load under both upscalings.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpscalingResult {
    /// One window carries the whole normal force (the paper).
    pub paper: PaperUpscalingResult,
    /// Windows average over the nominal area.
    pub area: AreaUpscalingResult,
}

/// Friction of one window.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperUpscalingResult {
    /// Standard deviation of μ.
    pub std: f64,
}

/// Friction of the nominal area.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaUpscalingResult {
    /// Nominal area.
    pub nominal_area_m2: f64,
    /// Number of windows in the nominal area.
    pub windows: f64,
    /// Variance of μ over the nominal area divided by the variance of one window.
    pub variance_reduction: f64,
    /// Standard deviation of μ.
    pub std: f64,
}
