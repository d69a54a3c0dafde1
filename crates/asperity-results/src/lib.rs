//! The results of asperity as plain types: the content of `results.json` of runs and campaigns, `provenance.json` and
//! `comparison.json`.
//!
//! [`Table`] and [`Field`] are the data behind the figures. A program that reads a run folder needs this crate alone; it computes
//! nothing. Numbers are SI with the unit in the name, an undefined number is `None` (`null` in the file), and an interval is [low, high]
//! at 95 %. Results hold no clock, host or number of threads, so equal studies give equal bytes.

mod campaign;
pub mod choice;
mod companions;
mod comparison;
mod curves;
mod cutoff;
mod field;
mod friction;
pub mod keys;
mod labelled;
mod mode_coupling;
mod pressure;
mod provenance;
mod run;
mod schema;
mod stage;
mod surface;
mod table;
mod uncertainty;
mod unit;
mod verdict;
mod verdict_tables;
mod vibration;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use campaign::{CampaignResults, MemberAnswers, MemberRemedy, MemberResult, MemberWarning, VariedKey};
pub use companions::{Companions, PooledResult, SpreadResult};
pub use comparison::{BandMethod, Comparison, CurveComparison, StatisticComparison, TwinModel};
pub use curves::{
    AreaAndLoad, AttractorMap, CoupledPortrait, DisplacementHistogram, FrictionSpectrum, FrictionWindows,
    HeightCorrelation, LoadCurve, ModesOverFriction, PhaseCloud, Portrait, SoundSpectrum, StructureFunctions, Survival,
};
pub use cutoff::{CutoffPoint, CutoffResult, FinerPitch, ScanCutoff, ScanFriction};
pub use field::Field;
pub use friction::{
    AreaUpscalingResult, AtMeanLoad, CorrelationCurveResult, CorrelationModelResult, CrossResult, FrictionResult,
    GoodnessResult, LevelProcess, LevelResult, OperatingPoint, PaperUpscalingResult, RankedDistributionResult,
    ReturnLevelResult, RoughBody, SATURATED, StationarityResult, TailResult, UpscalingResult,
};
pub use labelled::{Answer, FieldKind, LabelledField};
pub use mode_coupling::{CoupledCycleResult, CoupledMotion, MachineModel, ModeCouplingResult};
pub use pressure::{
    CoarseEntry, GlobalExpansionEntry, HomogeneityEntry, IndexEntry, MapsEntry, MethodEntry, PressureMethod,
    PressureQuantile, PressureResult, ScalarEntry, ScalarQuantile, SensitivityEntry,
};
pub use provenance::{Machine, Program, Provenance, StageCost};
pub use run::Results;
pub use schema::results_schema;
#[doc(hidden)]
pub use schema::tidy;
pub use stage::Stage;
pub use surface::{
    CovarianceCandidateResult, CovarianceResult, EmpiricalCovariance, KarhunenLoeveResult, MeasuredSurface,
    PartStatistics, ProfileStatistics, ScanOfPart, SurfaceResult, SurfaceStatistics,
};
pub use table::{Table, TableError};
pub use uncertainty::{
    FailedPoint, ParameterIndexResult, UncertainLevel, UncertainParameter, UncertainResponse, UncertaintyResult,
};
pub use unit::{split_unit, units_of_names};
pub use verdict::{
    Assumed, Driver, ErrorCause, ErrorSource, Guess, InputKind, InputValue, LearntFriction, MarginQuantile,
    NominalMachine, Quantiles, Reach, Remedy, RestsOn, Risk, TurningPoint, VerdictResult, VibratingMachines,
};
pub use verdict_tables::{AreaAsOne, ProbabilityMap, ProbabilityMapAxis};
pub use vibration::{
    CrossingResult, CycleResult, DampingResult, EnsembleResult, MapResolutionResult, MapResult, MotionKind,
    MotionResult, PointsResult, VibrationResult,
};

/// Version of the keys of `results.json` that this crate reads and writes.
pub const SCHEMA_VERSION: u64 = 1;

/// A fitted or stated distribution.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistributionResult {
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
