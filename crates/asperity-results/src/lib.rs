//! The results of asperity as plain types: the content of `results.json` of runs and campaigns, `provenance.json` and
//! `comparison.json`.
//!
//! A program that reads a run folder needs this crate alone; it computes nothing. Numbers are SI with the unit in the name, an
//! undefined number is `None` (`null` in the file), and an interval is [low, high] at 95 %. Results hold no clock, host or number of
//! threads, so equal studies give equal bytes.

mod campaign;
mod companions;
mod comparison;
mod cutoff;
mod friction;
mod mode_coupling;
mod pressure;
mod provenance;
mod schema;
mod surface;
mod uncertainty;
mod verdict;
mod verdict_tables;
mod vibration;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use campaign::{CampaignResults, MemberAnswers, MemberResult, MemberWarning, VariedKey};
pub use companions::{Companions, PooledResult, SpreadResult};
pub use comparison::{BandMethod, Comparison, CurveComparison, StatisticComparison, TwinModel};
pub use cutoff::{CutoffPoint, CutoffResult, HalvedPitch};
pub use friction::{
    AreaScatter, AtMeanLoad, CorrelationCurveResult, CorrelationModelResult, CrossResult, FrictionResult,
    GoodnessResult, LevelResult, OperatingPoint, PaperScatter, RankedLawResult, ReturnLevelResult, RoughBodyResult,
    StationarityResult, TailResult, UpscalingResult,
};
pub use mode_coupling::{CoupledCycleResult, CoupledMotion, ModeCouplingResult, ModelResult};
pub use pressure::{
    CoarseEntry, GlobalExpansionEntry, HomogeneityEntry, IndexEntry, MapsEntry, MethodEntry, PressureQuantile,
    PressureResult, ScalarEntry, ScalarQuantile, SensitivityEntry,
};
pub use provenance::{Machine, Program, Provenance, StageCost};
pub use schema::results_schema;
#[doc(hidden)]
pub use schema::tidy;
pub use surface::{
    CovarianceCandidateResult, CovarianceResult, EmpiricalCovariance, KarhunenLoeveResult, MeasuredSurface,
    PartStatistics, ScanOfPart, SurfaceResult, SurfaceStatistics,
};
pub use uncertainty::{
    FailedPoint, ParameterIndexResult, UncertainLevel, UncertainParameter, UncertainResponse, UncertaintyResult,
};
pub use verdict::{
    Driver, ErrorSource, Guess, InputKind, InputValue, LearntFriction, MarginQuantile, NominalMachine, Quantiles,
    Reach, Remedy, RestsOn, VerdictResult, VibratingMachines,
};
pub use verdict_tables::{AreaAsOne, ProbabilityMap, ProbabilityMapAxis};
pub use vibration::{
    CrossingResult, CycleResult, DampingResult, EnsembleResult, KindResult, MapResolutionResult, MapResult,
    MotionResult, PointsResult, VibrationResult,
};

/// Version of the keys of `results.json` that this crate reads and writes.
pub const SCHEMA_VERSION: u64 = 1;

/// The content of `results.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Results {
    /// Version of the keys.
    #[schemars(extend("const" = SCHEMA_VERSION))]
    pub schema_version: u64,
    /// Seed of the study.
    pub seed: u64,
    /// The surface stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceResult>,
    /// Roughness of the counterface, with the keys of `surface`; absent if it is smooth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counterface: Option<SurfaceResult>,
    /// The pressure stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<PressureResult>,
    /// The friction stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionResult>,
    /// The vibration stage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vibration: Option<VibrationResult>,
    /// The machine of two modes that friction couples, in place of `vibration`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode_coupling: Option<ModeCouplingResult>,
    /// The probability of vibration over uncertain values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<VerdictResult>,
    /// Assumptions, in sentences.
    pub assumptions: Vec<String>,
    /// Warnings, in sentences.
    pub warnings: Vec<String>,
}

impl Default for Results {
    fn default() -> Self {
        Self {
            schema_version: SCHEMA_VERSION,
            seed: 0,
            surface: None,
            counterface: None,
            pressure: None,
            friction: None,
            vibration: None,
            mode_coupling: None,
            verdict: None,
            assumptions: Vec::new(),
            warnings: Vec::new(),
        }
    }
}

/// A fitted or stated distribution.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LawResult {
    /// Name of the distribution.
    pub name: String,
    /// Parameters by name; empty for an empirical distribution.
    pub parameters: BTreeMap<String, f64>,
}

/// Quantity that a level of the friction stage prescribes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Prescribed {
    /// Percentage of the heights above the plane.
    #[default]
    Percentile,
    /// Mean pressure.
    MeanPressure,
    /// Depth of the plane below the highest point.
    Penetration,
}

/// An interval as [low, high].
pub type Pair = [f64; 2];

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
