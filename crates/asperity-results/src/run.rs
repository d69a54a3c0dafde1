//! The content of `results.json` of a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    FrictionResult, ModeCouplingResult, PressureResult, SCHEMA_VERSION, SurfaceResult, VerdictResult, VibrationResult,
};

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
