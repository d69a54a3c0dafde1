//! The pressure stage in `results.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Pair;

/// The pressure stage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureResult {
    /// Cell [row, column] whose pressure is studied.
    pub cell: [usize; 2],
    /// Contact solves of the reference run; 0 if only the default method is used, whose estimate is then the answer.
    pub reference_samples: usize,
    /// Cells of each sample whose pressures are pooled: more than one if the surface is stationary on a periodic patch.
    pub sites: usize,
    /// P(contact): of the reference run or, without one, of the default method.
    pub contact_probability: f64,
    /// Standard error of `contact_probability`.
    pub contact_probability_se: Option<f64>,
    /// 95 % interval of `contact_probability`.
    pub contact_probability_interval: Option<Pair>,
    /// Mean pressure, zeros out of contact included.
    pub mean_pa: f64,
    /// Standard error of `mean_pa`.
    pub mean_se_pa: Option<f64>,
    /// 95 % interval of `mean_pa`.
    pub mean_interval: Option<Pair>,
    /// Standard deviation of the pressure, zeros out of contact included.
    pub std_pa: f64,
    /// Quantiles of the pressure.
    pub quantiles: Vec<PressureQuantile>,
    /// Smallest Kolmogorov–Smirnov distance that the reference resolves at 95 %; `null` without a reference.
    pub ks_resolution: Option<f64>,
    /// Contact solves that failed: those of the reference run or, without one, of the default method.
    pub failed_samples: usize,
    /// Mean compliance of a periodic patch.
    pub mean_compliance_m_per_pa: Option<f64>,
    /// Height of the plane above the mean of the ensemble, where it is fixed in space.
    pub separation_m: Option<f64>,
    /// One entry per method.
    pub methods: Vec<MethodEntry>,
    /// Quantities of the whole contact.
    pub scalars: Vec<ScalarEntry>,
    /// Samples and accuracy of the maps of all cells; `null` without maps.
    pub maps: Option<MapsEntry>,
    /// Test of equal distributions in all cells; `null` without maps.
    pub homogeneity: Option<HomogeneityEntry>,
    /// The expansion of all cells; `null` without maps.
    pub global_expansion: Option<GlobalExpansionEntry>,
    /// Sobol' indices, one entry for each quantity and set of variables.
    pub sensitivities: Vec<SensitivityEntry>,
}

impl PressureResult {
    /// Returns the contact solutions of the answer in words.
    pub fn origin(&self) -> String {
        let solves = |method: &MethodEntry| method.name == PressureMethod::Default;
        match (self.reference_samples, self.methods.iter().find(|method| solves(method))) {
            (0, Some(default)) if default.coarse_solves.is_empty() => {
                format!("{} contact solutions of random surfaces", default.fine_solves)
            }
            (0, Some(default)) => {
                format!("{} contact solutions of random surfaces and further, cheaper ones", default.fine_solves)
            }
            (samples, _) => format!("{samples} contact solutions of the reference run"),
        }
    }
}

crate::choice! {
    /// Method that estimates the distribution of the pressure.
    #[derive(Default)]
    pub enum PressureMethod: "method for the pressure" {
        /// Empirical distribution of independent samples.
        MonteCarlo = "monte_carlo": "Monte Carlo",
        /// Mean of the empirical distributions of ten Latin hypercubes.
        LatinHypercube = "latin_hypercube": "Latin hypercube",
        /// Mean of the empirical distributions of ten randomisations of Sobol' points.
        Sobol = "sobol": "Sobol’ sequence",
        /// Eq. (8): chaos expansion of the pressure in contact in the leading variables ξ, on the Latin hypercubes.
        PolynomialChaos = "polynomial_chaos",
        /// Eq. (9): chaos expansion of the logarithm of the pressure in contact, on the same samples.
        PolynomialChaosLog = "polynomial_chaos_log": "polynomial chaos of log p",
        /// Eq. (8) on the Monte Carlo samples, in variables ξ rotated to the cell.
        PolynomialChaosLocal = "polynomial_chaos_local": "local polynomial chaos",
        /// Multilevel estimator by Monte Carlo samples, coarse grids, and normal variables rotated to the cell.
        #[default]
        Default = "default": "default of asperity",
    }
}

impl PressureMethod {
    /// Returns whether methods are more than the default, so that they are compared with a reference.
    pub fn are_compared(methods: &[Self]) -> bool {
        methods.iter().any(|method| *method != Self::Default)
    }

    /// Returns the method whose contact solutions this one uses.
    pub fn design(self) -> Self {
        match self {
            Self::MonteCarlo | Self::PolynomialChaosLocal | Self::Default => Self::MonteCarlo,
            Self::LatinHypercube | Self::PolynomialChaos | Self::PolynomialChaosLog => Self::LatinHypercube,
            Self::Sobol => Self::Sobol,
        }
    }
}

/// One method of the pressure stage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MethodEntry {
    /// Name.
    pub name: PressureMethod,
    /// Contact solves.
    pub fine_solves: usize,
    /// Contact solves on coarser grids.
    pub coarse_solves: Vec<CoarseEntry>,
    /// Work of all solves in fine solves; coarse solves count by cells and iterations.
    pub work_in_fine_solves: f64,
    /// Contact solves that failed.
    pub failed_samples: usize,
    /// P(contact).
    pub contact_probability: Option<f64>,
    /// Bias of P(contact); estimated from samples that a model is not fitted to; absent without a bias.
    pub contact_probability_bias: Option<f64>,
    /// The standard error of P(contact) less its bias.
    pub contact_probability_se: Option<f64>,
    /// 95 % interval of `contact_probability`, which allows for bias and error.
    pub contact_probability_interval: Option<Pair>,
    /// Mean pressure, zeros out of contact included.
    pub mean_pa: Option<f64>,
    /// Bias of the mean pressure; estimated in the same way.
    pub mean_bias_pa: Option<f64>,
    /// The standard error of the mean less its bias.
    pub mean_se_pa: Option<f64>,
    /// 95 % interval of `mean_pa`, which allows for bias and error.
    pub mean_interval: Option<Pair>,
    /// Standard deviation of the pressure, zeros out of contact included.
    pub std_pa: Option<f64>,
    /// Quantiles.
    pub quantiles: Vec<PressureQuantile>,
    /// Half width of the simultaneous 95 % band of the distribution function in standard errors, around the estimate less its
    /// bias; the table `pressure_bands` lists biases and standard errors.
    pub simultaneous_band_factor: Option<f64>,
    /// Kolmogorov–Smirnov distance from the reference.
    pub ks_distance: Option<f64>,
    /// Wasserstein-1 distance from the reference over its standard deviation.
    pub wasserstein_1_over_std: Option<f64>,
    /// Coefficients of the expansion.
    pub coefficients: Option<usize>,
    /// Relative leave-one-out error of the expansion.
    pub leave_one_out_error: Option<f64>,
    /// Reason why there are no intervals.
    pub interval_failure: Option<String>,
    /// Reason why there is no estimate.
    pub failure: Option<String>,
}

/// Contact solves on one coarser grid.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoarseEntry {
    /// Points along x.
    pub nx: usize,
    /// Points along y.
    pub ny: usize,
    /// Number of solves.
    pub solves: usize,
    /// Work of these solves in fine solves, by cells and iterations.
    pub work_in_fine_solves: f64,
}

/// A quantile of the pressure.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureQuantile {
    /// Probability.
    pub probability: f64,
    /// Quantile; 0 up to the probability of no contact.
    pub pressure_pa: f64,
    /// 95 % interval of `pressure_pa`; absent without standard errors.
    pub pressure_pa_interval: Option<Pair>,
}

/// A quantity of the whole contact, estimated by the default method.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScalarEntry {
    /// Name with the unit of all values.
    pub name: String,
    /// Mean.
    pub mean: f64,
    /// Standard error of `mean`.
    pub mean_se: f64,
    /// 95 % interval of `mean`.
    pub mean_interval: Pair,
    /// Standard deviation.
    pub std: f64,
    /// Quantiles.
    pub quantiles: Vec<ScalarQuantile>,
}

/// A quantile of a scalar.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScalarQuantile {
    /// Probability.
    pub probability: f64,
    /// Quantile.
    pub value: f64,
    /// 95 % interval of `value`.
    pub value_interval: Pair,
}

/// Samples and accuracy of the maps of all cells. The maps are fields: `contact_probability`, `pressure_mean`, `pressure_quantile_10`, `_50`
/// and `_90`, and `expansion_error`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapsEntry {
    /// Samples of contact probabilities and means.
    pub samples: usize,
    /// Samples of quantiles, standard errors and the expansion.
    pub kept_samples: usize,
    /// Largest half width of the 95 % intervals of the contact probabilities, each cell by itself.
    pub contact_probability_largest_half_width: Option<f64>,
    /// Largest standard error of the mean pressures.
    pub mean_largest_se_pa: Option<f64>,
}

/// Whether cells differ in contact probability or mean pressure.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HomogeneityEntry {
    /// Cells compared.
    pub cells: Option<usize>,
    /// Independent samples of them.
    pub samples: Option<usize>,
    /// p-value of equal contact probabilities.
    pub contact_p_value: Option<f64>,
    /// p-value of equal mean pressures.
    pub mean_p_value: Option<f64>,
    /// p-value of both.
    pub p_value: Option<f64>,
    /// Whether the samples do not show that cells differ, at 5 %.
    pub plausible: Option<bool>,
    /// Reason why there is no result.
    pub failure: Option<String>,
}

/// An expansion of the pressures of all cells in the leading standard normal variables.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GlobalExpansionEntry {
    /// Number of leading standard normal variables.
    pub variables: Option<usize>,
    /// Total degree.
    pub degree: Option<usize>,
    /// Coefficients of each cell.
    pub coefficients: Option<usize>,
    /// Relative leave-one-out error, mean over the cells that vary.
    pub leave_one_out_error: Option<f64>,
    /// Reason why there is no expansion.
    pub failure: Option<String>,
}

/// Sobol' indices of one quantity with respect to one set of variables: fractions of the variance that an expansion explains.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensitivityEntry {
    /// Name of the quantity with its unit.
    pub quantity: String,
    /// `local`: the height of the cell and of rings around it; `global`: the leading standard normal variables.
    pub variables: String,
    /// One entry for each variable.
    pub indices: Vec<IndexEntry>,
    /// Terms of the expansion.
    pub terms: Option<usize>,
    /// Fraction of the variance that the expansion does not predict, by cross-validation.
    pub cross_validated_error: Option<f64>,
    /// Reason why there are no indices.
    pub failure: Option<String>,
}

/// Sobol' indices of one variable.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IndexEntry {
    /// Name of the variable.
    pub name: String,
    /// First-order index.
    pub first_order: f64,
    /// Standard error of `first_order`.
    pub first_order_se: f64,
    /// 95 % interval of `first_order`.
    pub first_order_interval: Pair,
    /// Total index.
    pub total: f64,
    /// Standard error of `total`.
    pub total_se: f64,
    /// 95 % interval of `total`.
    pub total_interval: Pair,
}
