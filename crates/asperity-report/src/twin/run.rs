//! The data of the page of a comparison.

use std::collections::BTreeMap;

use asperity_results::{Comparison, Field, Provenance, StatisticComparison, Table};

use crate::format::{Dimension, fixed};
use crate::page::parameters::parameter;
/// The data of the page of a comparison.
#[derive(Debug, Clone, Default)]
pub struct TwinRun {
    /// Name of the scan.
    pub name: String,
    /// The content of `comparison.json`.
    pub comparison: Comparison,
    /// The tables by the name of their CSV file, without its extension.
    pub tables: BTreeMap<String, Table>,
    /// The prepared scan, in metre.
    pub scan: Option<Field>,
    /// The first twins, in metre.
    pub twins: Vec<Field>,
    /// The content of `provenance.json`.
    pub provenance: Option<Provenance>,
}

/// Returns the statistics of a comparison in the order in which parameters are shown.
pub(super) fn statistics(comparison: &Comparison) -> Vec<(&str, &StatisticComparison)> {
    let mut found: Vec<_> = comparison.twins.iter().map(|(key, statistic)| (key.as_str(), statistic)).collect();
    found.sort_by_key(|(key, _)| parameter(key).map_or(usize::MAX, |(place, _, _)| place));
    found
}

/// Returns symbol and meaning of a statistic.
pub(super) fn named(key: &str) -> (String, String) {
    match parameter(key) {
        Some((_, symbol, meaning)) if !symbol.is_empty() => (symbol, meaning),
        _ => (Dimension::of_key(key).0.replace('_', " "), String::new()),
    }
}

/// Returns the distance of the scan from the mean of its twins, in their standard deviations.
pub(super) fn distance(statistic: &StatisticComparison) -> Option<f64> {
    let std = statistic.std.filter(|std| *std > 0.0)?;
    Some((statistic.target? - statistic.mean?) / std)
}

/// Formats a fraction as a whole percentage.
pub(super) fn percent(fraction: f64) -> String {
    format!("{} %", fixed(100.0 * fraction, 0))
}

/// Returns the fraction of the points of a curve inside the pointwise band.
pub(super) fn inside_share(comparison: &Comparison, curve: &str) -> Option<f64> {
    comparison.curves.iter().find(|(name, _)| name == curve)?.1.inside_share
}
