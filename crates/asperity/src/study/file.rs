//! Study files as written, before their values are checked.
//!
//! The type of each key checks its form. An unknown key is an error that names its line and the nearest known key.

mod counterface;
mod friction;
mod mode_coupling;
mod pressure;
mod surface;
mod verdict;
mod vibration;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;

use crate::stats::VALID_FRACTION;
use crate::study::StoreError;
use crate::study::uncertain::UncertainValue;

pub use counterface::CounterfaceSection;
pub(super) use friction::usual_window_m;
pub use friction::{FrictionSection, UncertaintySection, WindowShape};
pub use mode_coupling::{ContactSpring, MachineModel};
pub use pressure::{MaterialSection, PressureSection};
pub use surface::{DecimalSign, ScanFiles, SurfaceSection};
pub use verdict::{Hold, JointSection, RemedySection, VerdictSection};
pub use vibration::{MapSection, Stribeck, VibrationSection};

/// Study file: scan or surface model, stages, and the seed of every random draw.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Seed of every random draw.
    pub seed: u64,
    /// Name of the study, of which its run folder gets its name; that of the file when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Least fraction of valid samples of each kind, above 0, at most 1; statistics of fewer are refused.
    #[serde(default = "least_valid_share", skip_serializing_if = "is_least_valid_share")]
    pub valid_share: f64,
    /// Names, `section.key`, of the values below that are defaults because the first study file left them out. The study of a run
    /// folder lists them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unstated: Vec<String>,
    /// Measured or modelled surface; required by pressure and friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceSection>,
    /// Body that is pressed against the surface; smooth and rigid when left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counterface: Option<CounterfaceSection>,
    /// Elastic and plastic properties; required by every stage but the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialSection>,
    /// Distribution of the random pressure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<PressureSection>,
    /// Friction coefficient as a process.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionSection>,
    /// Stick-slip or mode coupling of a mass on a belt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vibration: Option<VibrationSection>,
    /// Dependence of uncertain values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<JointSection>,
    /// Probability of vibration over the uncertain values, and what changes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<VerdictSection>,
    /// Uncertain values of all sections; each section holds their central values.
    #[serde(skip)]
    pub uncertain: Vec<UncertainValue>,
}

impl StudyFile {
    /// Returns the file as a table with the uncertain values as stated.
    ///
    /// # Errors
    /// A path is not Unicode.
    pub fn to_table(&self) -> Result<Table, toml::ser::Error> {
        let mut table = Table::try_from(self)?;
        self.uncertain.iter().for_each(|value| value.restore(&mut table));
        Ok(table)
    }

    /// Returns the text of the file with the uncertain values as stated.
    pub(super) fn to_text(&self) -> Result<String, StoreError> {
        self.to_table().and_then(|table| toml::to_string(&table)).map_err(StoreError::content)
    }
}

fn least_valid_share() -> f64 {
    VALID_FRACTION
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_least_valid_share(fraction: &f64) -> bool {
    *fraction == VALID_FRACTION
}
