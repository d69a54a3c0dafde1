//! Outcome of a study: the content of `results.json`, and the data behind its figures.

use std::collections::BTreeMap;

pub use asperity_results::*;

use crate::distribution::Marginal;
use crate::friction::process::FittedProcess;
use crate::stats::Interval;
use crate::study::run_machine::RunMachine;

/// All results of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Scalar results.
    pub results: Results,
    /// Tables by name.
    pub tables: BTreeMap<String, Table>,
    /// Fields by name.
    pub fields: BTreeMap<String, Field>,
    /// Friction process at the operating point.
    pub friction_process: Option<FittedProcess>,
    /// Machine on a belt, unless its friction has no course along the path.
    pub machine: Option<RunMachine>,
}

/// Returns a number, or `None` if it is undefined.
pub(super) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// Returns a distribution with its parameters by name.
pub(super) fn distribution_result(law: &Marginal) -> DistributionResult {
    let parameters = law.parameters().into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    DistributionResult { name: law.name().into(), parameters }
}

/// Returns an interval as [low, high].
pub(super) fn pair(interval: Interval) -> Pair {
    [interval.low, interval.high]
}
