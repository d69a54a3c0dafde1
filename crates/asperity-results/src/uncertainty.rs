//! Friction over uncertain parameters of the surface.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{DistributionResult, Pair, Prescribed};

/// `friction.uncertainty` of `results.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UncertaintyResult {
    /// Surfaces, each of other parameters.
    pub points: usize,
    /// Strips of each.
    pub realisations: usize,
    /// Uncertain parameters.
    pub parameters: Vec<UncertainParameter>,
    /// Levels, in the order of those of the stage.
    pub levels: Vec<UncertainLevel>,
}

/// An uncertain parameter of the surface.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UncertainParameter {
    /// `rms_height` in metre, `correlation_length` along x in metre, or `skewness`.
    pub name: String,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Distribution.
    pub law: DistributionResult,
}

/// Friction of one level over the parameters.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UncertainLevel {
    /// Prescribed quantity, the same for all surfaces.
    pub control: Prescribed,
    /// Percentage of the heights above the plane.
    pub percentile: Option<f64>,
    /// Prescribed mean pressure.
    pub mean_pressure_pa: Option<f64>,
    /// Prescribed penetration.
    pub penetration_m: Option<f64>,
    /// Moments of the quotient F/N of each window.
    pub responses: Vec<UncertainResponse>,
    /// Moments at the mean load.
    pub at_mean_load: Vec<UncertainResponse>,
    /// Points without a result, with the reason.
    pub failures: Vec<FailedPoint>,
}

/// A point without a result.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FailedPoint {
    /// Place in the design.
    pub point: usize,
    /// Reason.
    pub reason: String,
}

/// One moment of friction over the parameters; `null` where it is undefined, for the `reason`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UncertainResponse {
    /// `mean`, `std`, `coefficient_of_variation` or `correlation_length_m`.
    pub name: String,
    /// Mean over the parameters.
    pub value: Option<f64>,
    /// Interval of that mean, which allows for the finite numbers of strips and points.
    pub value_interval: Option<Pair>,
    /// Standard deviation over the parameters.
    pub std: Option<f64>,
    /// 95 % interval of `std`.
    pub std_interval: Option<Pair>,
    /// Interval that contains the moment for 95 % of the parameters.
    pub interval: Option<Pair>,
    /// Relative leave-one-out error of the expansion in the parameters: the variance that it does not explain.
    pub loo_error: Option<f64>,
    /// Standard error of `value` by the choice of the strips.
    pub noise_standard_error: Option<f64>,
    /// Fraction of the variance over the points that is due to the choice of the strips.
    pub noise_share: Option<f64>,
    /// Sobol' indices; empty where there are none.
    pub sobol: Vec<ParameterIndexResult>,
    /// Reason why there are no indices or no numbers at all.
    pub reason: Option<String>,
}

/// Sobol' indices of one parameter.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterIndexResult {
    /// Name of the parameter.
    pub parameter: String,
    /// First order: the fraction of the variance that it explains alone.
    pub first: f64,
    /// 95 % interval of `first`.
    pub first_interval: Pair,
    /// Total: together with all others.
    pub total: f64,
    /// 95 % interval of `total`.
    pub total_interval: Pair,
}
