//! The page of the answer of a vibration command.

use std::collections::BTreeMap;

use asperity_results::{MapResult, Pair, Table};
use serde_json::Value;

use crate::figures::vibration;
use crate::format::Dimension;
use crate::page::Page;
use crate::page::data_table::DataTable;
use crate::page::section::Section;
use crate::{Report, ReportError};

/// Contents of the figures of a vibration command, with the values that its tables lack.
#[derive(Debug, Clone, PartialEq)]
pub enum VibrationFigures {
    /// Stability map: `map_cells`, `map_contours` and `map_limit`.
    Map(MapResult),
    /// Bifurcation diagram over a parameter: `bifurcation_up`, `bifurcation_down`, `bifurcation_marks` and `bifurcation_turnovers`.
    Bifurcation {
        /// Name of the parameter and of its columns.
        parameter: String,
    },
    /// Damping ratios along a parameter: `critical_curve`.
    CriticalCurve {
        /// Name of the parameter and of its column.
        parameter: String,
    },
    /// Spectrum of the velocity: `sound_spectrum`.
    Sound {
        /// Level above that of the limit cycle in decibel.
        level_db: Option<f64>,
        /// 95 % interval of the level.
        level_db_interval: Option<Pair>,
        /// Period of the limit cycle.
        cycle_period: Option<f64>,
    },
    /// Attractors over the starts: `basin`, `separatrix` and `limit_cycle`.
    Basin,
    /// Trajectories: `phase_cloud`, `limit_cycle`, the distributions `reattachment` and `release`, and `survival`, the fraction that
    /// never left vibration.
    Ensemble,
    /// Modes over the friction coefficient, `modes_over_friction`, and the cycle in the plane, `mode_cycle`.
    ModeCoupling(CoupledModes),
}

/// Characteristic values of coupled modes.
#[derive(Debug, Clone, PartialEq)]
pub struct CoupledModes {
    /// Friction coefficient at which the undamped modes meet.
    pub coalescence: Option<f64>,
    /// Friction coefficient above which a mode grows.
    pub critical_friction: Option<f64>,
    /// Friction coefficient of the machine.
    pub friction: f64,
    /// Velocity of the belt; `None` if the cycle is not drawn.
    pub belt_velocity: Option<f64>,
    /// Mean growth rate under fluctuating friction.
    pub mean_growth: Option<f64>,
}

/// Renders the page of a vibration command, such as `map`, from its figures, the keys and values that `--json` prints, its warnings and its
/// tables. It is a pure function; absent tables and columns are left out.
///
/// # Errors
/// The PNG encoder failed.
pub fn render_vibration(
    command: &str,
    figures: &VibrationFigures,
    answer: &[(String, Value)],
    warnings: &[String],
    tables: &BTreeMap<String, Table>,
) -> Result<Report, ReportError> {
    let units = "Displacement, time and velocity are dimensionless: X = xc/N, τ = ω₀t and dX/dτ.";
    let table = DataTable::properties("Numbers of the answer", rows(answer));
    let sections = [
        Section::new("figures", "Figures", units, Vec::new(), vibration::of_command(figures, tables)?),
        Section::new("answer", "Answer", "", vec![table], Vec::new()),
    ];
    let page = Page {
        title: format!("Vibration: {}", command.replace('-', " ")),
        intro: "Answer of one vibration command of asperity.",
        first_screen: None,
        answers: Vec::new(),
        warnings: warnings.to_vec(),
        sections: sections.into_iter().flatten().collect(),
        details: Vec::new(),
        script: "",
        machine: None,
    };
    Ok(page.render())
}

/// Returns the numbers, words and decisions of the answer with their units; lists have tables of their own.
fn rows(answer: &[(String, Value)]) -> Vec<(String, String)> {
    let value = |dimension: Dimension, value: &Value| match value {
        Value::Bool(holds) => Some(if *holds { "yes" } else { "no" }.to_owned()),
        Value::Number(number) => number.as_f64().map(|number| dimension.show(number)),
        Value::String(text) => Some(text.replace('_', " ")),
        _ => None,
    };
    let row = |(key, own): &(String, Value)| {
        let (name, dimension) = Dimension::of_key(key);
        Some((name.replace('_', " "), value(dimension, own)?))
    };
    answer.iter().filter_map(row).collect()
}
