//! The tables of the vibration stage.

use std::collections::BTreeMap;

use asperity_results::VibrationResult;

use crate::format::Dimension;
use crate::page::answer_table::{all, distribution};
use crate::page::data_table::DataTable;

/// Returns limits and cycle, then what roughness changes: the motion, and cycles and thresholds over the damping ratio.
pub(super) fn tables(vibration: &VibrationResult) -> Vec<DataTable> {
    let [area, paper] = [&vibration.area, &vibration.paper];
    let (of_area, of_paper) = ("upscaling “area”", "upscaling “paper”");
    let mut tables = vec![
        DataTable::of("Motion without roughness, and the friction of the machine", vibration, |key| {
            !["paper", "area", "map", "marginal"].contains(&key)
        }),
        DataTable::beside(
            "The motion under fluctuating friction by upscaling, at the damping ratio of the study; brackets are 95 % intervals, ± is \
             a standard error",
            &[("“area”".to_owned(), area), ("“paper”".to_owned(), paper)],
            all,
        ),
    ];
    tables.extend(vibration.marginal.iter().map(|marginal| {
        let rows = distribution(marginal, &BTreeMap::new(), Dimension::None);
        DataTable::new("Distribution of μ", &["Property", "Value"], rows)
    }));
    tables.push(DataTable::grouped(
        "Vibration over the damping ratio by upscaling; brackets are 95 % intervals",
        &[(of_area, &area.damping), (of_paper, &paper.damping)],
        all,
    ));
    tables.push(DataTable::grouped(
        "Damping ratios at which the time in vibration, from a start in stick and as the mean over the trajectories, falls below a \
         fraction, by upscaling; brackets are 95 % intervals",
        &[(of_area, &area.crossings), (of_paper, &paper.crossings)],
        all,
    ));
    tables
}
