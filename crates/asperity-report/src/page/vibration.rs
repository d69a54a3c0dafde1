//! The tables of the vibration stage.

use std::collections::BTreeMap;

use asperity_results::{DampingResult, EnsembleResult, VibrationResult};

use crate::cells::shown;
use crate::format::Dimension;
use crate::page::answer_table::{all, distribution};
use crate::page::data_table::DataTable;
use crate::run::RESULTS;

/// Returns limits and cycle, then what roughness changes: the motion, and cycles and thresholds over the damping ratio.
pub(super) fn tables(vibration: &VibrationResult) -> Vec<DataTable> {
    let upscalings = upscalings(vibration).map(|(name, part)| (format!("“{name}”"), part));
    let mut tables = vec![
        DataTable::of("Motion without roughness, and the friction of the machine", vibration, |key| {
            !["paper", "area", "map", "marginal"].contains(&key)
        }),
        DataTable::beside(
            "The motion under fluctuating friction by upscaling, at the damping ratio of the study; brackets are 95 % intervals, ± is \
             a standard error",
            &upscalings,
            all,
        ),
    ];
    tables.extend(vibration.marginal.iter().map(|marginal| {
        let rows = distribution(marginal, &BTreeMap::new(), Dimension::None);
        DataTable::new("Distribution of μ", &["Property", "Value"], rows, RESULTS)
    }));
    for (name, part) in &upscalings {
        let caption = format!("Vibration over the damping ratio, upscaling {name}; brackets are 95 % intervals");
        tables.push(DataTable::listed(&caption, &part.damping, all));
        let caption = format!(
            "Damping ratios at which the time in vibration, from a start in stick and as the mean over the trajectories, falls below a \
             fraction; upscaling {name}; brackets are 95 % intervals"
        );
        tables.push(DataTable::listed(&caption, &part.crossings, all));
    }
    tables
}

/// Returns both upscalings with their names.
fn upscalings(vibration: &VibrationResult) -> [(&'static str, &EnsembleResult); 2] {
    [("area", &vibration.area), ("paper", &vibration.paper)]
}

/// Formats the lost cycles with their interval.
pub(super) fn difference(entry: &DampingResult) -> String {
    shown(Dimension::None, entry.difference_mean, Some(entry.difference_interval))
}
