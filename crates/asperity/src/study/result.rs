//! What a study found: the content of `results.json`, and the series behind its figures.
//!
//! Numbers are SI with the unit in the key; an undefined number is `null`; intervals are [low, high] at 95 %. No clock,
//! host or thread count enters, so equal studies give equal bytes.

mod pressure;
mod uncertainty;

use std::collections::BTreeMap;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::correlation::MeasuredReport;
use crate::friction::process::FittedProcess;
use crate::stats::Interval;
use crate::study::{Field, PooledStatistics, Table};
use crate::surface::pooling::Mean;
use crate::surface::uncertainty::Estimates;

pub use pressure::{
    CoarseEntry, GlobalExpansionEntry, HomogeneityEntry, IndexEntry, MapsEntry, MethodEntry, PressureQuantile,
    PressureResult, ScalarEntry, ScalarQuantile, SensitivityEntry,
};
pub use uncertainty::{
    FailedPoint, ParameterIndexResult, UncertainLevel, UncertainParameter, UncertainResponse, UncertaintyResult,
};

/// Everything a run computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Numbers.
    pub results: Results,
    /// Series by name.
    pub tables: BTreeMap<String, Table>,
    /// Maps by name.
    pub fields: BTreeMap<String, Field>,
    /// The process of the leading level of the friction stage.
    pub friction_process: Option<FittedProcess>,
}

/// `results.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct Results {
    /// Seed of the study.
    pub seed: u64,
    /// The surface stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceResult>,
    /// The pressure stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<PressureResult>,
    /// The friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionResult>,
    /// The vibration stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vibration: Option<VibrationResult>,
    /// What was assumed, in sentences.
    pub assumptions: Vec<String>,
    /// What to be wary of, in sentences.
    pub warnings: Vec<String>,
}

/// A fitted or stated law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LawResult {
    /// Name of the law.
    pub name: String,
    /// Parameters by name; empty for an empirical law.
    pub parameters: BTreeMap<String, f64>,
}

/// An interval as [low, high].
pub type Pair = [f64; 2];

/// A number that may be undefined.
pub(super) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// [low, high] of an interval.
pub fn pair(interval: Interval) -> Pair {
    [interval.low, interval.high]
}

/// The surface stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceResult {
    /// Statistics of the scan; absent without one.
    #[serde(flatten)]
    pub statistics: Option<SurfaceStatistics>,
    /// Statistics of the part, where there are several scans of it, in place of those of one.
    #[serde(flatten)]
    pub part: Option<PooledStatistics>,
    /// Covariance of the random surfaces; absent for Weierstrass–Mandelbrot surfaces, which are not made from one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance: Option<CovarianceResult>,
    /// Marginal law of the random surfaces.
    pub marginal: LawResult,
    /// Karhunen–Loève expansion on the patches of the pressure stage.
    pub karhunen_loeve: Option<KarhunenLoeveResult>,
}

/// Statistics of a map after levelling; keys as in `asperity surface stats`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[expect(non_snake_case, reason = "the names of ISO 25178-2 parameters are case-sensitive")]
pub struct SurfaceStatistics {
    /// Points along x.
    pub nx: usize,
    /// Points along y.
    pub ny: usize,
    /// Pitch along x.
    pub dx_m: f64,
    /// Pitch along y.
    pub dy_m: f64,
    /// Missing points, rejected outliers included.
    pub missing_points: usize,
    /// Points rejected as outliers.
    pub outliers: usize,
    /// Radius of the cylinder or sphere that was removed, positive for a ridge or cap.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form_radius_m: Option<f64>,
    /// Arithmetical mean height.
    pub Sa_m: f64,
    /// Root mean square height.
    pub Sq_m: f64,
    /// Skewness.
    pub Ssk: f64,
    /// Kurtosis.
    pub Sku: f64,
    /// Highest peak.
    pub Sp_m: f64,
    /// Deepest pit.
    pub Sv_m: f64,
    /// Sp + Sv.
    pub Sz_m: f64,
    /// Root mean square gradient by forward differences.
    pub Sdq: Option<f64>,
    /// The same by the seven-point stencil.
    pub Sdq_7point: Option<f64>,
    /// Developed interfacial area ratio by triangulation.
    pub Sdr: Option<f64>,
    /// Autocorrelation length at 0.2.
    pub Sal_m: Option<f64>,
    /// Texture aspect ratio.
    pub Str: Option<f64>,
    /// Direction of the lay, counter-clockwise from x as the map is seen, from 0 to below π.
    pub Std_rad: Option<f64>,
    /// Dominant wavelength.
    pub Ssw_m: Option<f64>,
    /// Core height, by the least-squares line of ISO 25178-2, as those up to Svkx.
    pub Sk_m: f64,
    /// Reduced peak height.
    pub Spk_m: f64,
    /// Reduced dale depth.
    pub Svk_m: f64,
    /// Upper material ratio of the core.
    pub Smrk1: f64,
    /// Lower material ratio of the core.
    pub Smrk2: f64,
    /// Height of the highest peak above the core.
    pub Spkx_m: f64,
    /// Depth of the deepest dale below the core.
    pub Svkx_m: f64,
    /// Core height by the flattest secant, as the next four.
    pub Sk_secant_m: f64,
    /// Reduced peak height.
    pub Spk_secant_m: f64,
    /// Reduced dale depth.
    pub Svk_secant_m: f64,
    /// Upper material ratio of the core.
    pub Smrk1_secant: f64,
    /// Lower material ratio of the core.
    pub Smrk2_secant: f64,
    /// Peak extreme height, between the material ratios 2.5 % and 50 %.
    pub Sxp_m: f64,
    /// Peak material volume.
    pub Vmp_m: f64,
    /// Core material volume.
    pub Vmc_m: f64,
    /// Core void volume.
    pub Vvc_m: f64,
    /// Dale void volume.
    pub Vvv_m: f64,
    /// Lower end of the wavenumbers at which the radial spectrum is reliable.
    pub psd_reliable_low_rad_per_m: f64,
    /// Their upper end; nothing is reliable when it is not above the lower.
    pub psd_reliable_high_rad_per_m: f64,
    /// What sets the upper end: `pixel`, `roll_off` or `noise_floor`.
    pub psd_upper_limit: &'static str,
    /// 1/e correlation length along x.
    pub correlation_length_x_m: Option<f64>,
    /// 1/e correlation length along y.
    pub correlation_length_y_m: Option<f64>,
    /// Hurst exponent.
    pub hurst: Option<f64>,
    /// Its standard error.
    pub hurst_se: Option<f64>,
    /// Shortest lag of the structure functions from which it was fitted.
    pub hurst_range_low_m: Option<f64>,
    /// Longest lag of these.
    pub hurst_range_high_m: Option<f64>,
    /// Fractal dimension 3 − H.
    pub fractal_dimension: Option<f64>,
    /// Intervals and standard errors beside them.
    #[serde(flatten)]
    pub intervals: StatisticsIntervals,
}

impl SurfaceStatistics {
    /// The statistics that mean something for a part of which the map is one scan, with what is averaged over scans.
    pub fn poolable(&self) -> Vec<(&'static str, Option<f64>, Mean)> {
        let plain = [
            ("Sa_m", Some(self.Sa_m)),
            ("Ssk", finite(self.Ssk)),
            ("Sku", finite(self.Sku)),
            ("Sp_m", Some(self.Sp_m)),
            ("Sv_m", Some(self.Sv_m)),
            ("Sz_m", Some(self.Sz_m)),
            ("Sdr", self.Sdr),
            ("Sal_m", self.Sal_m),
            ("Str", self.Str),
            ("Ssw_m", self.Ssw_m),
            ("Sk_m", Some(self.Sk_m)),
            ("Spk_m", Some(self.Spk_m)),
            ("Svk_m", Some(self.Svk_m)),
            ("Smrk1", Some(self.Smrk1)),
            ("Smrk2", Some(self.Smrk2)),
            ("Spkx_m", Some(self.Spkx_m)),
            ("Svkx_m", Some(self.Svkx_m)),
            ("Sk_secant_m", Some(self.Sk_secant_m)),
            ("Spk_secant_m", Some(self.Spk_secant_m)),
            ("Svk_secant_m", Some(self.Svk_secant_m)),
            ("Smrk1_secant", Some(self.Smrk1_secant)),
            ("Smrk2_secant", Some(self.Smrk2_secant)),
            ("Sxp_m", Some(self.Sxp_m)),
            ("Vmp_m", Some(self.Vmp_m)),
            ("Vmc_m", Some(self.Vmc_m)),
            ("Vvc_m", Some(self.Vvc_m)),
            ("Vvv_m", Some(self.Vvv_m)),
            ("correlation_length_x_m", self.correlation_length_x_m),
            ("correlation_length_y_m", self.correlation_length_y_m),
            ("hurst", self.hurst),
            ("fractal_dimension", self.fractal_dimension),
        ];
        // Their squares are means over the surface.
        let square = [("Sq_m", Some(self.Sq_m)), ("Sdq", self.Sdq), ("Sdq_7point", self.Sdq_7point)];
        let of = |mean: Mean| move |(name, value)| (name, value, mean);
        square.into_iter().map(of(Mean::RootMeanSquare)).chain(plain.into_iter().map(of(Mean::Arithmetic))).collect()
    }

    /// Area of the points that are present in m².
    pub fn present_area_m2(&self) -> f64 {
        (self.nx * self.ny - self.missing_points) as f64 * self.dx_m * self.dy_m
    }
}

/// For each statistic x that is estimated, `x_interval` = [low, high] at 95 % and `x_se`; null where the map holds too few
/// correlation lengths.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StatisticsIntervals(pub Estimates);

impl Serialize for StatisticsIntervals {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let named = self.0.named();
        let mut map = serializer.serialize_map(Some(2 * named.len()))?;
        for (name, estimate) in named {
            map.serialize_entry(&format!("{name}_interval"), &estimate.map(|e| pair(e.interval)))?;
            map.serialize_entry(&format!("{name}_se"), &estimate.map(|e| e.standard_error))?;
        }
        map.end()
    }
}

/// Covariance of the random surfaces.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CovarianceResult {
    /// Name of the model; `empirical` is the scan's own.
    pub model: String,
    /// Standard deviation.
    pub std_m: f64,
    /// Length ℓ along x of the model ([`crate::correlation::CorrelationModel`]): where the correlation falls to 1/e, except
    /// that it is the scale of the Matérn model and the roll-off length of the self-affine one. Without a model where the
    /// correlation falls to 1/e.
    pub length_x_m: f64,
    /// The same along y.
    pub length_y_m: f64,
    /// Lag along x at which the correlation is 1/e, whatever the model: what `correlation_length_x_m` is of the scan.
    pub decay_length_x_m: f64,
    /// The same along y.
    pub decay_length_y_m: f64,
    /// Smoothness ν of a Matérn model.
    pub smoothness: Option<f64>,
    /// Hurst exponent of a self-affine model.
    pub hurst: Option<f64>,
    /// Root mean square misfit of the correlation, where fitted.
    pub misfit: Option<f64>,
    /// Other models that were tried, with their misfits.
    pub candidates: Vec<CovarianceCandidate>,
    /// What was done to the scan's own autocorrelation to make it a covariance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub empirical: Option<MeasuredReport>,
}

/// A covariance model that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CovarianceCandidate {
    /// Name of the model.
    pub model: String,
    /// Root mean square misfit of the correlation.
    pub misfit: f64,
}

/// A Karhunen–Loève expansion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KarhunenLoeveResult {
    /// Number of terms.
    pub modes: usize,
    /// Share of the variance that they hold.
    pub captured_variance: f64,
}

/// The friction stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// Levels of contact.
    pub levels: Vec<LevelResult>,
    /// What uncertain parameters of the surface do; absent where none is stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyResult>,
}

/// One level of the friction stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelResult {
    /// Whether this is the level that is shown in full and handed to the vibration stage.
    pub leading: bool,
    /// What is prescribed: `percentile`, `mean_pressure` or `penetration`.
    pub control: &'static str,
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
    /// Mean of μ.
    pub mean: f64,
    /// Its interval, which as all of μ knows the correlation along the strips; `null` where they hold too few correlation
    /// lengths.
    pub mean_interval: Option<Pair>,
    /// Standard deviation of μ.
    pub std: f64,
    /// Its interval.
    pub std_interval: Option<Pair>,
    /// Standard deviation over mean.
    pub coefficient_of_variation: f64,
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
    pub correlation_without_window_model: Option<&'static str>,
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
#[derive(Debug, Clone, PartialEq, Serialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RankedLawResult {
    /// Name; `shifted_` where a shift was fitted, `empirical` for the windows' own law.
    pub name: &'static str,
    /// Akaike's criterion, of as many independent windows as the correlated ones are worth, less that of the first law.
    pub aic_difference: f64,
    /// How well it fits; `null` for the windows' own law.
    pub gof: Option<GoodnessResult>,
}

/// Distances between the windows and the marginal law, with p-values that know that the law was fitted and how the windows are
/// correlated.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CorrelationCurveResult {
    /// Its name.
    pub model: &'static str,
    /// ℓ, which contains the window.
    pub length_m: f64,
    /// Root mean square difference from the estimated correlation.
    pub misfit: f64,
}

/// A model of the correlation without the window, fitted by likelihood.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CorrelationModelResult {
    /// Its name.
    pub model: &'static str,
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
#[derive(Debug, Clone, PartialEq, Serialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CrossResult {
    /// The coefficient.
    pub correlation: f64,
    /// Its interval.
    pub interval: Pair,
}

/// The upper tail of μ: peaks over a threshold follow a generalised Pareto law.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReturnLevelResult {
    /// Sliding distance.
    pub distance_m: f64,
    /// The value.
    pub mu: f64,
    /// Its interval; `null` where the likelihood does not end it.
    pub interval: Option<Pair>,
}

/// The scatter of friction at the mean load under both upscalings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UpscalingResult {
    /// One window carries the whole normal force (the paper).
    pub paper: PaperScatter,
    /// Windows average over the nominal area.
    pub area: AreaScatter,
}

/// Friction of one window.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperScatter {
    /// Standard deviation of μ.
    pub std: f64,
}

/// Friction of the nominal area.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
