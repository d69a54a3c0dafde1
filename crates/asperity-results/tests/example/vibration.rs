//! The vibration stage, and the functions that its tables share.

use std::f64::consts::E;

use asperity_results::{
    CoupledCycleResult, CoupledMotion, CrossingResult, CycleResult, DampingResult, EnsembleResult, MapResolutionResult,
    MapResult, ModeCouplingResult, MotionKind, MotionResult, PointsResult, VibrationResult,
};

use super::law;

/// Damping ratios of the sweep.
pub(crate) fn damping_ratios() -> Vec<f64> {
    (0..11).map(|i| 0.05 + 0.25 * f64::from(i) / 10.0).collect()
}

/// Cycles without noise, and mean cycles with the paper's upscaling and with that over the area.
pub(crate) fn cycles(damping_ratio: f64) -> [f64; 3] {
    let deterministic = if damping_ratio < 0.2048 { (95.0 + 30.0 * damping_ratio).round() } else { 0.0 };
    // An approximation of the normal distribution function.
    let x = (0.205 - damping_ratio) / 0.045;
    let paper = 99.0 / (1.0 + (-1.5976 * x - 0.070_566 * f64::powi(x, 3)).exp());
    [deterministic, paper, if deterministic > 0.0 { deterministic - 0.04 } else { 0.02 }]
}

/// A machine that flutters.
pub(crate) fn mode_coupling() -> ModeCouplingResult {
    ModeCouplingResult {
        damping_ratio: 0.05,
        belt_velocity: 0.5,
        friction: 0.8,
        stiffness: [2.0, 1.0, 2.0],
        contact_spring: 4.0 / 3.0,
        contact_stiffness_n_per_m: 1.3e8,
        coalescence: Some(0.75),
        critical_friction: Some(0.765),
        friction_margin: Some(-0.035),
        limit_damping_ratio: Some(0.0913),
        steady_sliding_unstable: true,
        kind: MotionKind::Flutter,
        onset_frequency_hz: Some(2250.0),
        mode_frequencies_hz: [2240.0, 2260.0],
        mode_growth_rates_per_s: [41.0, -1041.0],
        motion: Some(CoupledMotion::Cycle),
        cycle: Some(CoupledCycleResult {
            frequency_hz: 2190.0,
            velocity_amplitude_m_per_s: 0.12,
            displacement_amplitude_m: 8.5e-6,
            normal_amplitude_m: 7.9e-6,
            stick_share: 0.1,
            flight_share: 0.0,
        }),
    }
}

pub(super) fn vibration() -> VibrationResult {
    let sweep = |upscaling: usize| {
        let entry = |damping_ratio| {
            let cycles = cycles(damping_ratio);
            let half = [2.5, 0.2][upscaling - 1];
            let lost = cycles[0] - cycles[upscaling];
            DampingResult {
                damping_ratio,
                kind: if cycles[0] > 0.0 { MotionKind::StickSlip } else { MotionKind::None },
                cycles_deterministic: cycles[0] as u64,
                cycles_mean: cycles[upscaling],
                difference_mean: lost,
                difference_interval: [lost - half, lost + half],
                ..DampingResult::default()
            }
        };
        damping_ratios().into_iter().map(entry).collect()
    };
    let points = |std: f64| PointsResult {
        count: 4000,
        mean: Some(0.2),
        std: Some(std),
        skewness: Some(0.11),
        excess_kurtosis: Some(-0.03),
        normality_p: Some(0.41),
    };
    let crossing = |share, damping_ratio: f64| CrossingResult {
        share,
        damping_ratio: Some(damping_ratio),
        damping_ratio_interval: Some([damping_ratio - 2e-4, damping_ratio + 2e-4]),
        reason: None,
    };
    let shares = [(MotionKind::StickSlip, 0.7), (MotionKind::Overtaking, 0.0997), (MotionKind::SlipCycle, 0.0)];
    let ensemble = |upscaling: usize, friction_std, std| EnsembleResult {
        friction_std,
        clipped_fraction: 0.0,
        damping: sweep(upscaling),
        crossings: Vec::new(),
        reattachment: points(std),
        release: points(std),
        motion: None,
    };
    VibrationResult {
        damping_ratio: 0.17,
        belt_velocity: 0.05,
        static_friction: 0.4,
        friction_correlation_length_m: Some(2.5e-4),
        correlation_length: Some(E),
        marginal: Some(law("beta", &[("a", 2.13)])),
        variance_reduction: 6.1e-5,
        critical_damping_ratio: Some(0.204_830_150_5),
        hopf_damping_ratio: Some(0.204_805_7),
        limit_damping_ratio: Some(0.204_830_150_5),
        kind: MotionKind::StickSlip,
        steady_sliding_unstable: Some(true),
        cycle: CycleResult {
            damping_ratio: 0.17,
            limit_cycle: true,
            period: Some(8.068_887_87),
            slip_duration: Some(4.068_887_87),
            reattachment_displacement: Some(0.2),
            displacement_min: Some(0.188_196_6),
            displacement_max: Some(0.411_803_4),
            velocity_min: Some(-0.111_803_4),
        },
        upscaling: "area".into(),
        map: Some(MapResult {
            x: "damping_ratio".into(),
            y: "belt_velocity".into(),
            resolution: MapResolutionResult { x: 0.01, y: 0.002, unresolved_share: 0.0 },
        }),
        paper: EnsembleResult {
            crossings: vec![
                crossing(0.95, 0.1516),
                crossing(0.5, 0.2106),
                CrossingResult {
                    share: 0.05,
                    reason: Some(
                        "vibration takes more than 5 % of the time up to the damping ratio 0.41, where the search ends"
                            .into(),
                    ),
                    ..CrossingResult::default()
                },
            ],
            motion: Some(MotionResult {
                period_mean: Some(9.114),
                period_std: Some(6.5),
                stick_share: 0.1137,
                stick_share_se: 0.0007,
                share_in_cycle: 0.7997,
                kind_shares: shares.into(),
                exit_rate: Some(0.00826),
                exit_rate_interval: Some([0.00787, 0.00867]),
                entry_rate: Some(0.0325),
                entry_rate_interval: Some([0.0309, 0.0341]),
                left_share: 0.995,
                left_share_interval: [0.982, 0.999],
            }),
            ..ensemble(1, 0.001, 9e-3)
        },
        area: ensemble(2, 7.1e-6, 4e-4),
        ..VibrationResult::default()
    }
}
