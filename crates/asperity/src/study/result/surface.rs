//! The surface stage in `results.json`.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::correlation::MeasuredReport;
use crate::study::PooledStatistics;
use crate::study::result::{LawResult, finite, pair};
use crate::surface::pooling::Mean;
use crate::surface::uncertainty::Estimates;

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
    /// Root mean square of ln(measured/model spectral density) over the reliable band, where fitted.
    pub misfit: Option<f64>,
    /// Sdq of maps drawn on the scan's grid, in the root mean square, over that of the scan, both S-filtered at `slope_cutoff_m`, where
    /// the covariance is the scan's.
    pub slope_ratio: Option<f64>,
    /// Cutoff of that S-filter: the end of the scan's reliable band, or four pixels.
    pub slope_cutoff_m: Option<f64>,
    /// The covariances that were tried, the most likely model first.
    pub candidates: Vec<CovarianceCandidate>,
    /// What was done to the scan's own autocorrelation to make it a covariance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub empirical: Option<MeasuredReport>,
}

/// A covariance that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CovarianceCandidate {
    /// Name of the model; `empirical` is the scan's own.
    pub model: String,
    /// Root mean square of ln(measured/model spectral density) over the reliable band, of a model.
    pub misfit: Option<f64>,
    /// Sdq of its random surfaces, as expected without sampling, over that of the scan.
    pub slope_ratio: Option<f64>,
}

/// A Karhunen–Loève expansion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KarhunenLoeveResult {
    /// Number of terms.
    pub modes: usize,
    /// Fraction of the variance that they hold.
    pub captured_variance: f64,
    /// Fraction of the mean squared slope on the patch's grid that they hold.
    pub captured_slope_variance: f64,
}
