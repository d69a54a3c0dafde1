//! Conversion of the pressure distribution to entries of `results.json`.

use crate::pressure::{ComparisonResults, MethodResult, PressureEstimate, PressureMethod};
use crate::study::pressure_stage::{indices, maps, scalars};
use crate::study::result::{CoarseEntry, MethodEntry, PressureQuantile, PressureResult, finite, pair};

/// Probabilities of the reported quantiles.
const PROBABILITIES: [f64; 3] = [0.1, 0.5, 0.9];

/// Prescribed control, in addition to the sizes.
pub(super) struct Prescribed {
    pub(super) cell: (usize, usize),
    pub(super) mean_compliance_m_per_pa: Option<f64>,
    pub(super) separation_m: Option<f64>,
}

pub(super) fn summary(
    results: &ComparisonResults,
    estimate: &PressureEstimate,
    prescribed: &Prescribed,
) -> PressureResult {
    let reference = results.reference.as_ref();
    let default = results.methods.iter().find(|method| method.method == PressureMethod::Default);
    let failed = default.map_or(0, |method| method.failures.len());
    PressureResult {
        cell: [prescribed.cell.0, prescribed.cell.1],
        reference_samples: reference.map_or(0, |reference| reference.samples),
        sites: reference.map_or(1, |reference| reference.sites),
        contact_probability: estimate.contact_probability,
        contact_probability_se: finite(estimate.contact_probability_se),
        contact_probability_interval: estimate.contact_probability_interval.map(pair),
        mean_pa: estimate.mean_pa,
        mean_se_pa: finite(estimate.mean_se_pa),
        mean_interval: estimate.mean_interval_pa().map(pair),
        std_pa: estimate.distribution.std(),
        quantiles: quantiles(estimate),
        ks_resolution: reference.map(|reference| reference.ks_resolution),
        failed_samples: reference.map_or(failed, |reference| reference.failures.len()),
        mean_compliance_m_per_pa: prescribed.mean_compliance_m_per_pa,
        separation_m: prescribed.separation_m,
        methods: results.methods.iter().map(method_entry).collect(),
        scalars: results.scalars.iter().map(scalars::entry).collect(),
        maps: results.fields.as_ref().map(maps::entry),
        homogeneity: results.fields.as_ref().map(|distributions| maps::homogeneity(&distributions.homogeneity)),
        global_expansion: results.fields.as_ref().map(|distributions| maps::global_expansion(&distributions.global)),
        sensitivities: indices::entries(&results.sensitivities),
    }
}

fn method_entry(method: &MethodResult) -> MethodEntry {
    let coarse_solves = method.coarse_solves.iter().map(|coarse| CoarseEntry {
        nx: coarse.shape.1,
        ny: coarse.shape.0,
        solves: coarse.solves,
        work_in_fine_solves: coarse.work_in_fine_solves,
    });
    let coarse_solves: Vec<CoarseEntry> = coarse_solves.collect();
    let coarse_work: f64 = coarse_solves.iter().map(|coarse| coarse.work_in_fine_solves).sum();
    let prescribed = MethodEntry {
        name: method.method,
        fine_solves: method.fine_solves,
        coarse_solves,
        work_in_fine_solves: method.fine_solves as f64 + coarse_work,
        failed_samples: method.failures.len(),
        ..MethodEntry::default()
    };
    let (estimate, comparison) = match &method.outcome {
        Ok(outcome) => outcome,
        Err(reason) => return MethodEntry { failure: Some(reason.to_string()), ..prescribed },
    };
    MethodEntry {
        contact_probability: Some(estimate.contact_probability),
        contact_probability_se: finite(estimate.contact_probability_se),
        contact_probability_bias: estimate.contact_probability_bias,
        contact_probability_interval: estimate.contact_probability_interval.map(pair),
        mean_pa: finite(estimate.mean_pa),
        mean_bias_pa: estimate.mean_bias_pa.and_then(finite),
        mean_se_pa: finite(estimate.mean_se_pa),
        mean_interval: estimate.mean_interval_pa().map(pair),
        std_pa: finite(estimate.distribution.std()),
        quantiles: quantiles(estimate),
        simultaneous_band_factor: estimate.band.as_ref().and_then(|band| finite(band.simultaneous_factor)),
        ks_distance: comparison.as_ref().map(|comparison| comparison.ks_distance),
        wasserstein_1_over_std: comparison.as_ref().and_then(|comparison| comparison.wasserstein_1_over_std),
        coefficients: estimate.coefficients,
        leave_one_out_error: estimate.leave_one_out_error,
        interval_failure: estimate.interval_failure.as_ref().map(ToString::to_string),
        ..prescribed
    }
}

fn quantiles(estimate: &PressureEstimate) -> Vec<PressureQuantile> {
    let quantile = |probability: f64| PressureQuantile {
        probability,
        pressure_pa: estimate.distribution.quantile(probability),
        pressure_pa_interval: estimate.quantile_interval_pa(probability).map(pair),
    };
    PROBABILITIES.into_iter().map(quantile).collect()
}
