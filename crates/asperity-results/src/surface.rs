//! The surface stage in `results.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::companions::{Companions, PooledResult, SpreadResult};
use crate::{Answer, DistributionResult};

/// The surface stage. The statistics stand beside the other keys.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("unevaluatedProperties" = false))]
pub struct SurfaceResult {
    /// Statistics of the scan or scans.
    #[serde(flatten)]
    pub measured: MeasuredSurface,
    /// Covariance of the random surfaces; absent for Weierstrass–Mandelbrot surfaces, which are not made from one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance: Option<CovarianceResult>,
    /// Marginal distribution of the random surfaces.
    pub marginal: DistributionResult,
    /// Karhunen–Loève expansion on the patches of the pressure stage.
    pub karhunen_loeve: Option<KarhunenLoeveResult>,
}

impl SurfaceResult {
    /// Returns the statistics of the scan if the study has exactly one.
    pub fn scan(&self) -> Option<&SurfaceStatistics> {
        if let MeasuredSurface::Scan(scan) = &self.measured { Some(scan) } else { None }
    }

    /// Returns the statistics of the part if the study has several scans of it.
    pub fn part(&self) -> Option<&PartStatistics> {
        if let MeasuredSurface::Part(part) = &self.measured { Some(part) } else { None }
    }
}

/// Statistics of the scans of a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, deny_unknown_fields)]
pub enum MeasuredSurface {
    /// Pooled statistics of several scans of a part.
    Part(Box<PartStatistics>),
    /// Statistics of one scan.
    Scan(Box<SurfaceStatistics>),
    /// The study states its surface.
    Stated {},
}

impl Default for MeasuredSurface {
    fn default() -> Self {
        Self::Stated {}
    }
}

/// Statistics of a map after levelling; keys as in `asperity surface stats`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Skewness of the heights.
    pub Ssk: Option<f64>,
    /// Kurtosis of the heights, 3 for a normal distribution.
    pub Sku: Option<f64>,
    /// Highest peak.
    pub Sp_m: f64,
    /// Deepest pit.
    pub Sv_m: f64,
    /// Maximum height Sp + Sv.
    pub Sz_m: f64,
    /// Root mean square gradient by forward differences.
    pub Sdq: Option<f64>,
    /// Root mean square gradient by the seven-point stencil.
    pub Sdq_7point: Option<f64>,
    /// Developed interfacial area ratio by triangulation.
    pub Sdr: Option<f64>,
    /// Autocorrelation length at 0.2.
    pub Sal_m: Option<f64>,
    /// Texture aspect ratio, from 0 for a lay to 1 for none.
    pub Str: Option<f64>,
    /// Direction of the lay, counter-clockwise from x as the map is seen; from 0 to below π, meaningful if Str is small.
    pub Std_rad: Option<f64>,
    /// Dominant wavelength.
    pub Ssw_m: Option<f64>,
    /// Core height; by the least-squares line of ISO 25178-2, as the parameters up to Svkx.
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
    /// Peak extreme height, between the material ratios 2.5 % and 50 %.
    pub Sxp_m: f64,
    /// Core height by the secant; the flattest one, as for the next four parameters.
    pub Sk_secant_m: f64,
    /// Reduced peak height by the secant.
    pub Spk_secant_m: f64,
    /// Reduced dale depth by the secant.
    pub Svk_secant_m: f64,
    /// Upper material ratio of the core by the secant.
    pub Smrk1_secant: f64,
    /// Lower material ratio of the core by the secant.
    pub Smrk2_secant: f64,
    /// Peak material volume per area.
    pub Vmp_m: f64,
    /// Core material volume per area.
    pub Vmc_m: f64,
    /// Core void volume per area.
    pub Vvc_m: f64,
    /// Dale void volume per area.
    pub Vvv_m: f64,
    /// Lower end of the wavenumbers at which the radial spectrum is reliable.
    pub psd_reliable_low_rad_per_m: f64,
    /// Upper end of the wavenumbers at which the radial spectrum is reliable; none is if it is not above the lower end.
    pub psd_reliable_high_rad_per_m: f64,
    /// Limit that sets the upper end of the reliable spectrum: `pixel`, `roll_off` or `noise_floor`.
    pub psd_upper_limit: String,
    /// Variance outside the rings of the radial spectrum; in the corners of its plane, or below the first ring.
    #[serde(default)]
    pub psd_corners_m2: f64,
    /// 1/e correlation length along x.
    pub correlation_length_x_m: Option<f64>,
    /// 1/e correlation length along y.
    pub correlation_length_y_m: Option<f64>,
    /// Hurst exponent.
    pub hurst: Option<f64>,
    /// Standard error of `hurst`.
    pub hurst_se: Option<f64>,
    /// Shortest lag from which the Hurst exponent was fitted.
    pub hurst_range_low_m: Option<f64>,
    /// Longest lag from which the Hurst exponent was fitted.
    pub hurst_range_high_m: Option<f64>,
    /// Fractal dimension 3 − H.
    pub fractal_dimension: Option<f64>,
    /// Intervals and standard errors of the statistics.
    #[serde(flatten)]
    pub intervals: Companions<SpreadResult>,
}

impl SurfaceStatistics {
    /// Returns the names of all statistics but counts and words.
    pub(crate) fn names() -> Vec<String> {
        let is_number = |value: &Value| value.is_null() || value.is_f64();
        let default = Self { form_radius_m: Some(0.0), ..Self::default() };
        let Value::Object(fields) = default.json() else { return Vec::new() };
        fields.into_iter().filter(|(_, value)| is_number(value)).map(|(name, _)| name).collect()
    }

    /// Returns the statistic of a name; `None` if it is undefined or a word.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.json()[name].as_f64()
    }
}

/// Parameters of a profile after levelling and filters, ISO 21920-2; keys of `asperity surface stats`. With an L-filter they are those of
/// the roughness profile, otherwise those of the primary profile (Pa, Pq, …) under the same keys.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[expect(non_snake_case, reason = "the names of ISO 21920-2 parameters are case-sensitive")]
#[schemars(extend("unevaluatedProperties" = false))]
pub struct ProfileStatistics {
    /// Points along the profile.
    pub nx: usize,
    /// Distance between points.
    pub dx_m: f64,
    /// Missing points, rejected outliers included.
    pub missing_points: usize,
    /// Points rejected as outliers.
    pub outliers: usize,
    /// Radius of the circle that was removed, positive for a ridge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form_radius_m: Option<f64>,
    /// Number of sections, of the length of the L-filter's cutoff; 1 without the filter.
    pub sections: usize,
    /// Arithmetic mean height.
    pub Ra_m: f64,
    /// Root mean square height.
    pub Rq_m: f64,
    /// Skewness of the heights.
    pub Rsk: Option<f64>,
    /// Kurtosis of the heights, 3 for a normal distribution.
    pub Rku: Option<f64>,
    /// Highest peak of a section, mean over the sections.
    pub Rp_m: f64,
    /// Deepest pit of a section, mean over the sections.
    pub Rv_m: f64,
    /// Maximum height of a section, mean over the sections.
    pub Rz_m: f64,
    /// Total height of the profile.
    pub Rt_m: f64,
    /// Mean spacing of profile elements, a hill with a dale.
    pub RSm_m: Option<f64>,
    /// Root mean square gradient by forward differences.
    pub Rdq: Option<f64>,
    /// Root mean square gradient by the seven-point stencil, as ISO 21920-2 defines Rdq.
    pub Rdq_7point: Option<f64>,
    /// 1/e correlation length; none if the correlation does not decay within half the profile.
    pub correlation_length_m: Option<f64>,
    /// Lower end of the wavenumbers at which the spectrum is reliable.
    pub psd_reliable_low_rad_per_m: f64,
    /// Upper end of the wavenumbers at which the spectrum is reliable; none is if it is not above the lower end.
    pub psd_reliable_high_rad_per_m: f64,
    /// Limit that sets the upper end of the reliable spectrum: `pixel`, `roll_off` or `noise_floor`.
    pub psd_upper_limit: String,
    /// Intervals and standard errors of the parameters.
    #[serde(flatten)]
    pub intervals: Companions<SpreadResult>,
}

/// Pooled statistics of several scans of a part, and those of the scans.
///
/// Each pooled statistic `x` is the weighted mean over the scans, with `x_interval` and `x_se` of the part, `x_within_std` (the
/// standard error of one scan) and `x_between_std` (the standard deviation between places). All are `null` if `x` is undefined on a
/// scan.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PartStatistics {
    /// Number of scans.
    pub scan_count: usize,
    /// Points along x; `null` where the scans differ, as for the next three.
    pub nx: Option<usize>,
    /// Points along y.
    pub ny: Option<usize>,
    /// Pitch along x.
    pub dx_m: Option<f64>,
    /// Pitch along y.
    pub dy_m: Option<f64>,
    /// Missing points of all scans.
    pub missing_points: usize,
    /// Points of all scans rejected as outliers.
    pub outliers: usize,
    /// Pooled statistics by name.
    #[serde(flatten)]
    pub pooled: Companions<PooledResult>,
    /// Lower end of the wavenumbers at which the spectra of all scans are reliable.
    pub psd_reliable_low_rad_per_m: f64,
    /// Upper end of the wavenumbers at which the spectra of all scans are reliable.
    pub psd_reliable_high_rad_per_m: f64,
    /// Limit that sets the upper end of the reliable spectrum: `pixel`, `roll_off` or `noise_floor`.
    pub psd_upper_limit: String,
    /// Shortest lag from which the Hurst exponent of a scan was fitted.
    pub hurst_range_low_m: Option<f64>,
    /// Longest lag from which the Hurst exponent was fitted.
    pub hurst_range_high_m: Option<f64>,
    /// The scans.
    pub scans: Vec<ScanOfPart>,
}

/// One scan of a part.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("unevaluatedProperties" = false))]
pub struct ScanOfPart {
    /// Name of the file.
    pub file: String,
    /// Statistics of the scan.
    #[serde(flatten)]
    pub statistics: SurfaceStatistics,
}

/// Covariance of the random surfaces.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CovarianceResult {
    /// Name of the model; `empirical` is the scan's own.
    pub model: String,
    /// Standard deviation.
    pub std_m: f64,
    /// Length ℓ of the model along x: the scale of the Matérn model, the roll-off length of the self-affine one, otherwise, and
    /// without a model, the lag at which the correlation falls to 1/e.
    pub length_x_m: f64,
    /// Length ℓ of the model along y.
    pub length_y_m: f64,
    /// Lag along x at which the correlation is 1/e, for every model; compares with `correlation_length_x_m` of the scan.
    pub decay_length_x_m: f64,
    /// Lag along y at which the correlation is 1/e.
    pub decay_length_y_m: f64,
    /// Smoothness ν of a Matérn model.
    pub smoothness: Option<f64>,
    /// Hurst exponent of a self-affine model.
    pub hurst: Option<f64>,
    /// Root mean square of ln(measured/model spectral density) over the reliable band, where fitted.
    pub misfit: Option<f64>,
    /// Sdq of random maps over Sdq of the scan, within its reliable band; in the root mean square on the scan's grid, both S-filtered
    /// at `slope_cutoff_m`, where the covariance is the scan's.
    pub slope_ratio: Option<f64>,
    /// Cutoff of the S-filter of both Sdq: the end of the scan's reliable band, or four pixels.
    pub slope_cutoff_m: Option<f64>,
    /// The covariances that were tried, the most likely model first.
    pub candidates: Vec<CovarianceCandidateResult>,
    /// Changes that made the scan's own autocorrelation a covariance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub empirical: Option<EmpiricalCovariance>,
}

/// A covariance that was tried.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CovarianceCandidateResult {
    /// Name of the model; `empirical` is the scan's own.
    pub model: String,
    /// Root mean square of ln(measured/model spectral density) over the reliable band, of a model.
    pub misfit: Option<f64>,
    /// Sdq of random maps over Sdq of the scan; as expected, without sampling.
    pub slope_ratio: Option<f64>,
}

/// A Karhunen–Loève expansion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KarhunenLoeveResult {
    /// Number of terms.
    pub modes: usize,
    /// Fraction of the variance in the terms.
    pub captured_variance: f64,
    /// Fraction of the mean squared slope on the patch's grid in the terms.
    pub captured_slope_variance: f64,
}

/// Changes that made the scan's own autocorrelation a covariance. All correlations are relative to the variance.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmpiricalCovariance {
    /// Fraction of the variance removed with the map's mean; lags and variance are corrected for it.
    pub mean_share: f64,
    /// Standard error of a lag near zero in a field without correlation there, √(Σρ²/N).
    pub standard_error: f64,
    /// Largest lag along x, over all directions, up to which the estimate is used as it stands.
    pub reliable_x_m: f64,
    /// Largest lag along y up to which the estimate is used as it stands.
    pub reliable_y_m: f64,
    /// Whether the correlation decays along x within the map. Otherwise the taper shortened it.
    pub decayed_x: bool,
    /// Whether the correlation decays along y within the map.
    pub decayed_y: bool,
    /// Largest change of a lag by the taper.
    pub taper_change: f64,
    /// Fraction of the variance in negative values of the tapered spectrum, which were set to zero.
    pub clipped_variance: f64,
    /// Largest change of a lag by the balancing of the spectrum and the end of its factor.
    pub clipping_change: f64,
}
