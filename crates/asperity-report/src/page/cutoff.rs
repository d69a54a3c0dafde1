//! The table of friction against the shortest waves.

use serde_json::Value;

use super::DataTable;
use super::json::shown;
use super::tables::list;
use crate::format::{Dimension, significant};

/// One row per cut-off, and one for half the pitch; none where the study has no such entry.
pub(super) fn table(friction: &Value) -> Option<DataTable> {
    let cutoff = &friction["cutoff"];
    let length = |value: &Value| value.as_f64().map_or("–".into(), |metre| Dimension::Length.show(metre));
    let slope = |point: &Value| point["rms_slope"].as_f64().map_or("–".into(), |slope| significant(slope, 3));
    let percent =
        |value: &Value| value.as_f64().map_or("–".into(), |share| format!("{} %", significant(100.0 * share, 3)));
    let mut rows: Vec<Vec<String>> = list(&cutoff["points"])
        .iter()
        .map(|point| {
            let cells = [length(&point["cutoff_m"]), shown(point, "mean"), slope(point)];
            [&cells[..], &[percent(&point["plastic_fraction"])]].concat()
        })
        .collect();
    if rows.is_empty() {
        return None;
    }
    let halved = &cutoff["halved_pitch"];
    if halved["mean"].is_number() {
        let name = format!("{}, pitch of {}", length(&cutoff["cutoff_m"]), length(&halved["pitch_m"]));
        rows.push(vec![name, shown(halved, "mean"), "–".into(), "–".into()]);
    }
    let caption = format!(
        "Mean friction without the waves below a cut-off, at the mean pressure {} on strips of the pitch {}; brackets hold 95 % \
         intervals",
        cutoff["mean_pressure_pa"].as_f64().map_or("–".into(), |pascal| Dimension::Pressure.show(pascal)),
        length(&cutoff["pitch_m"])
    );
    let headers = ["Cut-off", "Mean μ", "Rms slope", "Contact at the hardness"];
    Some(DataTable::new(&caption, &headers, rows, "tables/friction_cutoff.csv"))
}
