//! The pressure stage.

use asperity_results::{
    CoarseEntry, GlobalExpansionEntry, HomogeneityEntry, IndexEntry, MapsEntry, MethodEntry, PressureMethod,
    PressureQuantile, PressureResult, ScalarEntry, ScalarQuantile, SensitivityEntry,
};

pub(super) fn pressure() -> PressureResult {
    let quantile = PressureQuantile { probability: 0.9, pressure_pa: 6e8, pressure_pa_interval: Some([5.8e8, 6.2e8]) };
    let method =
        |name: PressureMethod, contact_probability, standard_error: Option<f64>, ks, wasserstein| MethodEntry {
            name,
            fine_solves: 500,
            work_in_fine_solves: 500.0,
            contact_probability: Some(contact_probability),
            contact_probability_se: standard_error,
            ks_distance: Some(ks),
            wasserstein_1_over_std: Some(wasserstein),
            ..MethodEntry::default()
        };
    let coarse = |n, solves| CoarseEntry { nx: n, ny: n, solves, work_in_fine_solves: 495.25 };
    PressureResult {
        cell: [32, 32],
        reference_samples: 5000,
        sites: 1,
        contact_probability: 0.32,
        contact_probability_se: Some(0.0066),
        contact_probability_interval: Some([0.3072, 0.3331]),
        mean_pa: 1.64e8,
        mean_se_pa: Some(2e6),
        mean_interval: Some([1.6e8, 1.68e8]),
        std_pa: 3e8,
        quantiles: vec![quantile.clone()],
        ks_resolution: Some(0.0192),
        methods: vec![
            method(PressureMethod::MonteCarlo, 0.3121, Some(0.0207), 0.0512, 0.061),
            method(PressureMethod::LatinHypercube, 0.3262, Some(0.0152), 0.0301, 0.0402),
            MethodEntry { fine_solves: 512, ..method(PressureMethod::Sobol, 0.3184, None, 0.0149, 0.0181) },
            method(PressureMethod::PolynomialChaos, 0.34, Some(0.0212), 0.0402, 0.0711),
            method(PressureMethod::PolynomialChaosLog, 0.32, Some(0.0209), 0.0333, 0.0502),
            method(PressureMethod::PolynomialChaosLocal, 0.317, Some(0.0212), 0.0212, 0.0311),
            MethodEntry {
                work_in_fine_solves: 1490.5,
                coarse_solves: vec![coarse(16, 9000), coarse(32, 1712)],
                contact_probability_interval: Some([0.3034, 0.3466]),
                mean_pa: Some(1.62e8),
                mean_se_pa: Some(2.1e6),
                mean_interval: Some([1.579e8, 1.661e8]),
                quantiles: vec![quantile],
                ..method(PressureMethod::Default, 0.325, Some(0.011), 0.0051, 0.0072)
            },
        ],
        scalars: vec![ScalarEntry {
            name: "mean_gap_m".into(),
            mean: 4e-7,
            mean_se: 1e-9,
            mean_interval: [3.98e-7, 4.02e-7],
            std: 5e-8,
            quantiles: vec![ScalarQuantile { probability: 0.5, value: 4e-7, value_interval: [3.9e-7, 4.1e-7] }],
        }],
        maps: Some(MapsEntry {
            samples: 500,
            kept_samples: 500,
            contact_probability_largest_half_width: Some(0.0437),
            mean_largest_se_pa: Some(2.9e7),
        }),
        homogeneity: Some(HomogeneityEntry {
            cells: Some(16),
            samples: Some(500),
            contact_p_value: Some(0.02),
            mean_p_value: Some(0.0031),
            p_value: Some(0.0062),
            plausible: Some(false),
            failure: None,
        }),
        global_expansion: Some(GlobalExpansionEntry {
            variables: Some(8),
            degree: Some(1),
            coefficients: Some(9),
            leave_one_out_error: Some(0.93),
            failure: None,
        }),
        sensitivities: sensitivities(),
        ..PressureResult::default()
    }
}

/// Sobol' indices of two quantities with respect to variables about the cell and leading ones; one expansion failed.
fn sensitivities() -> Vec<SensitivityEntry> {
    let entry = |quantity: &str, variables: &str, names: Vec<String>, unexplained: f64| {
        let index = |(k, name): (i32, String)| {
            let first = 0.55 * 0.4f64.powi(k);
            let total = first + 0.1 * 0.7f64.powi(k);
            IndexEntry {
                name,
                first_order: first,
                first_order_se: 0.02,
                first_order_interval: [(first - 0.04).max(0.0), first + 0.04],
                total,
                total_se: 0.03,
                total_interval: [(total - 0.06).max(0.0), total + 0.06],
            }
        };
        SensitivityEntry {
            quantity: quantity.into(),
            variables: variables.into(),
            indices: (0..).zip(names).map(index).collect(),
            terms: Some(12),
            cross_validated_error: Some(unexplained),
            failure: None,
        }
    };
    let rings = std::iter::once("height of the cell".to_owned()).chain((1..6).map(|k| format!("ring {k}"))).collect();
    let modes = || (1..9).map(|k| format!("mode {k}")).collect();
    vec![
        entry("pressure_pa", "local", rings, 0.17),
        entry("pressure_pa", "global", modes(), 0.98),
        SensitivityEntry {
            quantity: "contact_fraction".into(),
            variables: "local".into(),
            failure: Some("too many normal variables to rotate them to the cell".into()),
            ..SensitivityEntry::default()
        },
        entry("contact_fraction", "global", modes(), 0.61),
    ]
}
