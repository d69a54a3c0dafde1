//! Conversion of vibration results to entries of `results.json`.

use crate::study::result::{CycleResult, DampingResult, MotionResult, PointsResult, finite};
use crate::vibration::{Ensemble, MotionKind, Regime, SampleDistribution};

pub(super) fn cycle_result(damping_ratio: f64, regime: &Regime) -> CycleResult {
    let cycle = regime.cycle();
    CycleResult {
        damping_ratio,
        limit_cycle: cycle.is_some(),
        period: cycle.map(|c| c.period),
        slip_duration: cycle.map(|c| c.slip_duration),
        reattachment_displacement: cycle.and_then(|c| c.reattachment_displacement),
        displacement_min: cycle.map(|c| c.displacement_min),
        displacement_max: cycle.map(|c| c.displacement_max),
        velocity_min: cycle.map(|c| c.velocity_min),
    }
}

pub(super) fn damping_result(damping_ratio: f64, kind: MotionKind, ensemble: &Ensemble) -> DampingResult {
    DampingResult {
        damping_ratio,
        kind,
        cycles_deterministic: ensemble.cycles_deterministic,
        cycles_mean: ensemble.cycles.mean,
        cycles_se: ensemble.cycles.se,
        difference_mean: ensemble.difference_mean,
        difference_interval: ensemble.difference_interval,
        share_in_cycle: ensemble.passages.share_in_cycle,
        vibration_share: ensemble.passages.late_share.mean,
        vibration_share_se: ensemble.passages.late_share.se,
        sustained_share: ensemble.passages.sustained.value,
        sustained_share_interval: ensemble.passages.sustained.interval,
        failed_samples: ensemble.failures.len(),
    }
}

pub(super) fn points_result(points: &SampleDistribution) -> PointsResult {
    PointsResult {
        count: points.count,
        mean: finite(points.mean),
        std: finite(points.std),
        skewness: finite(points.skewness),
        excess_kurtosis: finite(points.excess_kurtosis),
        normality_p: points.normality_p,
    }
}

pub(super) fn motion_result(ensemble: &Ensemble) -> MotionResult {
    let passages = &ensemble.passages;
    MotionResult {
        period_mean: finite(ensemble.periods.mean),
        period_std: finite(ensemble.periods.std),
        stick_share: ensemble.stick_share.mean,
        stick_share_se: ensemble.stick_share.se,
        share_in_cycle: passages.share_in_cycle,
        kind_shares: passages.kinds.iter().map(|(kind, share)| (*kind, *share)).collect(),
        exit_rate: passages.exit_rate.map(|rate| rate.value),
        exit_rate_interval: passages.exit_rate.map(|rate| rate.interval),
        entry_rate: passages.entry_rate.map(|rate| rate.value),
        entry_rate_interval: passages.entry_rate.map(|rate| rate.interval),
        left_share: passages.left.value,
        left_share_interval: passages.left.interval,
    }
}
