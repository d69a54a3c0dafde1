//! Tables of the vibration stage.

use crate::law::Marginal;
use crate::stats::Histogram;
use crate::study::Table;
use crate::study::result::{DampingResult, EnsembleResult};
use crate::vibration::{Ensemble, PhasePoint};

pub(super) fn damping_table(paper: &EnsembleResult, area: &EnsembleResult) -> Table {
    let column = |result: &EnsembleResult, value: &dyn Fn(&DampingResult) -> f64| -> Vec<f64> {
        result.damping.iter().map(value).collect()
    };
    let mut columns = vec![
        ("damping_ratio".to_owned(), column(paper, &|d| d.damping_ratio)),
        ("cycles_deterministic".into(), column(paper, &|d| d.cycles_deterministic as f64)),
    ];
    for (name, result) in [("paper", paper), ("area", area)] {
        columns.push((format!("{name}_cycles_mean"), column(result, &|d| d.cycles_mean)));
        columns.push((format!("{name}_difference_mean"), column(result, &|d| d.difference_mean)));
        columns.push((format!("{name}_difference_low"), column(result, &|d| d.difference_interval[0])));
        columns.push((format!("{name}_difference_high"), column(result, &|d| d.difference_interval[1])));
        columns.push((format!("{name}_sustained_share"), column(result, &|d| d.sustained_share)));
        columns.push((format!("{name}_sustained_share_low"), column(result, &|d| d.sustained_share_interval[0])));
        columns.push((format!("{name}_sustained_share_high"), column(result, &|d| d.sustained_share_interval[1])));
    }
    Table::new(columns)
}

/// Histogram of the re-attachment points beside the normal density of equal mean and standard deviation.
pub(super) fn reattachment_table(ensemble: &Ensemble) -> Option<Table> {
    let points = &ensemble.reattachments;
    let histogram = Histogram::of(&points.sample).ok()?;
    let normal = Marginal::normal(points.mean, points.std).ok()?;
    let centres = histogram.centres();
    Some(
        Table::new([
            ("normal_density", centres.iter().map(|x| normal.pdf(*x)).collect()),
            ("density", histogram.density()),
            ("displacement", centres),
        ])
        .led_by("displacement"),
    )
}

/// Points of a phase portrait.
pub(super) fn portrait_table(points: &[PhasePoint]) -> Table {
    Table::new([
        ("tau", points.iter().map(|p| p.tau).collect()),
        ("displacement", points.iter().map(|p| p.displacement).collect()),
        ("velocity", points.iter().map(|p| p.velocity).collect::<Vec<f64>>()),
    ])
}
