//! An invented verdict.

use asperity_results::{
    AreaAsOne, Assumed, Driver, ErrorCause, ErrorSource, Guess, InputKind, InputValue, LearntFriction, MachineModel,
    MarginQuantile, MotionKind, NominalMachine, ProbabilityMap, ProbabilityMapAxis, Quantiles, Reach, Remedy, RestsOn,
    Risk, TurningPoint, VerdictResult, VibratingMachines,
};

/// Returns the verdict on a machine that probably vibrates, with dependent and unknown values.
pub(crate) fn verdict() -> VerdictResult {
    let driver = |input: &str, share: f64, reduction: Option<f64>| Driver {
        input: input.into(),
        first_order: share,
        first_order_interval: [share - 0.02, share + 0.02],
        total: share + 0.03,
        total_interval: [share + 0.01, share + 0.05],
        shapley: Some(share),
        shapley_interval: Some([share - 0.02, share + 0.02]),
        range_reduction: reduction,
    };
    let axis = |input: &str, unit: &str, values: &[f64]| ProbabilityMapAxis {
        input: input.into(),
        unit: unit.into(),
        values: values.into(),
    };
    let row = |windows: f64, friction_std: f64, probability: f64| AreaAsOne {
        windows,
        friction_std,
        probability,
        probability_interval: [probability - 0.05, probability + 0.05],
    };
    let number = |input: &str, value: f64, unit: &str, kind: InputKind| RestsOn {
        input: input.into(),
        value: InputValue::Number(value),
        unit: unit.into(),
        kind,
        range: matches!(kind, InputKind::Uncertain | InputKind::Unknown).then_some([0.8 * value, 1.2 * value]),
    };
    let inputs = [("vibration.stribeck", 0.6), ("material.shear_strength", 0.25), ("vibration.damping_ratio", 0.15)];
    VerdictResult {
        friction_unresolved: false,
        unresolved_by: Vec::new(),
        model: MachineModel::StickSlip,
        vibration_threshold: 0.1,
        friction_fluctuates: false,
        probability: 0.64,
        probability_interval: [0.61, 0.67],
        expected_vibration_share: 0.64,
        expected_vibration_share_interval: [0.61, 0.67],
        probability_half: 0.64,
        probability_half_interval: [0.61, 0.67],
        probability_from_steady_sliding: Some(0.12),
        probability_from_steady_sliding_interval: Some([0.1, 0.14]),
        probability_range: Some([0.22, 0.91]),
        leaves_out_fluctuation: false,
        probability_over_unknowns: Some(Quantiles { q05: 0.22, q50: 0.66, q95: 0.91 }),
        error_sources: vec![
            ErrorSource { source: ErrorCause::Machines, half_width: 0.026 },
            ErrorSource { source: ErrorCause::Strips, half_width: 0.014 },
        ],
        friction: Some(LearntFriction {
            inputs: vec!["material.shear_strength".into(), "surface.scan".into()],
            points: 18,
            points_near_limit: 6,
            difference_near_limit: Some(0.004),
            standard_error: 0.006,
        }),
        evaluations: 4096,
        failed_samples: 3,
        first_failure: Some("no fold of slip cycles found".into()),
        duration_s: 2.0,
        nominal: NominalMachine {
            vibrates: true,
            kind: MotionKind::StickSlip,
            steady_sliding_unstable: false,
            kick_m_per_s: Some(0.013),
            limit_damping_ratio: Some(0.018),
            damping_margin: -0.0025,
            damping_margin_interval: None,
        },
        if_vibrating: Some(VibratingMachines {
            kinds: [(MotionKind::StickSlip, 0.97), (MotionKind::SlipCycle, 0.03)].into(),
            frequency_hz: Some(Quantiles { q05: 298.0, q50: 312.0, q95: 325.0 }),
            velocity_amplitude_m_per_s: Some(Quantiles { q05: 0.031, q50: 0.046, q95: 0.06 }),
            displacement_amplitude_m: Some(Quantiles { q05: 1.6e-5, q50: 2.3e-5, q95: 3.1e-5 }),
        }),
        margin_quantiles: vec![
            MarginQuantile { probability: 0.05, damping_margin: -0.008 },
            MarginQuantile { probability: 0.5, damping_margin: -0.002 },
            MarginQuantile { probability: 0.95, damping_margin: 0.004 },
        ],
        drivers: inputs.map(|(input, share)| driver(input, share, Some(0.5 * share))).into(),
        event_drivers: inputs.map(|(input, share)| driver(input, 0.7 * share, None)).into(),
        guesses: vec![Guess { input: "vibration.stribeck".into(), probability_at_q05: 0.2, probability_at_q95: 0.93 }],
        turning_points: Vec::new(),
        remedies: vec![Remedy {
            input: "vibration.damping_ratio".into(),
            unit: String::new(),
            held: None,
            now: 0.0155,
            range: [0.001, 0.1],
            friction_coefficient_now: Some(0.43),
            reach: vec![
                Reach {
                    probability: 0.05,
                    value: Some(0.026),
                    value_interval: Some([0.024, 0.029]),
                    friction_coefficient: Some(0.43),
                },
                Reach { probability: 0.01, ..Reach::default() },
            ],
            risk: [(0.0155, 0.64), (0.02, 0.3), (0.026, 0.05), (0.03, 0.02)]
                .map(|(value, probability)| Risk { value, probability })
                .into(),
        }],
        map: Some(ProbabilityMap {
            x: axis("vibration.damping_ratio", "", &[0.01, 0.02, 0.03]),
            y: axis("vibration.normal_force", "N", &[5e3, 10e3]),
            probability: vec![vec![0.9, 0.3, 0.05], vec![0.95, 0.5, 0.1]],
            leaves_out_fluctuation: true,
        }),
        area_as_one: Some(vec![row(1.0, 0.02, 0.3), row(100.0, 0.002, 0.6), row(18_500.0, 0.0002, 0.64)]),
        assumptions: vec!["The verdict takes the statistics of the scan as exact.".into()],
        rests_on: vec![
            number("surface.file", 3.0, "", InputKind::Measured),
            number("material.shear_strength", 4e7, "Pa", InputKind::Unknown),
            number("vibration.normal_force", 2e3, "N", InputKind::Stated),
            number("vibration.damping_ratio", 0.0155, "", InputKind::Uncertain),
            number("vibration.stribeck", 4.2, "", InputKind::Default),
            RestsOn {
                input: "vibration.velocity_law".into(),
                value: InputValue::Name("stribeck".into()),
                unit: String::new(),
                kind: InputKind::Default,
                range: None,
            },
        ],
        assumed: vec![Assumed {
            input: "vibration.stribeck".into(),
            value: 4.2,
            range: [2.1, 8.4],
            probability_at: [0.21, 1.0],
            probability_interval_at: [[0.2, 0.22], [0.994, 1.0]],
            expected_vibration_share_at: [0.08, 0.97],
        }],
    }
}

/// Returns turning points of a machine without uncertain values.
pub(crate) fn turning_points() -> Vec<TurningPoint> {
    let point = |key: &str, unit: &str, now: f64, value: Option<f64>| TurningPoint {
        input: format!("vibration.{key}"),
        unit: unit.into(),
        now,
        value,
    };
    vec![
        point("damping_ratio", "", 0.0155, Some(0.018)),
        point("mass", "kg", 2.0, None),
        point("normal_force", "N", 90.0, Some(81.0)),
    ]
}
