//! What a study found: the content of `results.json`, and the series behind its figures.
//!
//! Numbers are SI with the unit in the key; an undefined number is `null`; intervals are [low, high] at 95 %. No clock,
//! host or thread count enters, so equal studies give equal bytes.

mod cutoff;
mod friction;
mod pressure;
mod surface;
mod uncertainty;
mod vibration;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::friction::process::FittedProcess;
use crate::stats::Interval;
use crate::study::{Field, Table};

pub use cutoff::{CutoffPoint, CutoffResult, HalvedPitch};
pub use friction::{
    AreaScatter, AtMeanLoad, CorrelationCurveResult, CorrelationModelResult, CrossResult, FrictionResult,
    GoodnessResult, LevelResult, OperatingPoint, PaperScatter, RankedLawResult, ReturnLevelResult, StationarityResult,
    TailResult, UpscalingResult,
};
pub use pressure::{
    CoarseEntry, GlobalExpansionEntry, HomogeneityEntry, IndexEntry, MapsEntry, MethodEntry, PressureQuantile,
    PressureResult, ScalarEntry, ScalarQuantile, SensitivityEntry,
};
pub use surface::{
    CovarianceCandidate, CovarianceResult, KarhunenLoeveResult, StatisticsIntervals, SurfaceResult, SurfaceStatistics,
};
pub use uncertainty::{
    FailedPoint, ParameterIndexResult, UncertainLevel, UncertainParameter, UncertainResponse, UncertaintyResult,
};
pub use vibration::{
    CrossingResult, CycleResult, DampingResult, EnsembleResult, MapResult, MotionResult, PointsResult, VibrationResult,
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
