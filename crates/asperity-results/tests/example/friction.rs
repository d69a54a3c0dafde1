//! The friction stage, and the functions that its tables share.

use std::collections::BTreeMap;

use asperity_results::{
    AreaUpscalingResult, AtMeanLoad, CorrelationCurveResult, CorrelationModelResult, CrossResult, CutoffPoint,
    CutoffResult, FailedPoint, FinerPitch, FrictionResult, GoodnessResult, LevelProcess, LevelResult, OperatingPoint,
    PaperUpscalingResult, ParameterIndexResult, Prescribed, RankedDistributionResult, ReturnLevelResult, RoughBody,
    ScanCutoff, ScanFriction, StationarityResult, TailResult, UncertainLevel, UncertainParameter, UncertainResponse,
    UncertaintyResult, UpscalingResult,
};

use super::law;

/// Penetrations of the levels; the last one leads.
pub(crate) const PENETRATIONS_M: [f64; 6] = [1.35e-6, 1.72e-6, 2.33e-6, 3.0e-6, 3.68e-6, 0.62e-6];

/// Percentiles of all levels but the last.
const PERCENTILES: [f64; 5] = [5.0, 10.0, 25.0, 50.0, 75.0];

/// Cut-off wavelengths.
pub(crate) const CUTOFFS_M: [f64; 4] = [2.9e-6, 5.9e-6, 11.7e-6, 23.4e-6];

/// Root mean square slopes without the waves below the cut-offs.
pub(crate) const RMS_SLOPES: [f64; 4] = [0.21, 0.17, 0.13, 0.09];

/// Fractions of the contact at the hardness.
pub(crate) const PLASTIC_FRACTIONS: [f64; 4] = [0.31, 0.24, 0.15, 0.06];

/// Mean of F/N at a penetration.
pub(crate) fn level_mean(penetration_m: f64) -> f64 {
    0.19 + 0.06 * (-(penetration_m / 1.2e-6)).exp()
}

/// Standard deviation of F/N at a penetration.
pub(crate) fn level_std(penetration_m: f64) -> f64 {
    0.012 * (-(penetration_m / 1.5e-6)).exp() + 0.0004
}

/// Mean friction without the waves below a cut-off.
pub(crate) fn cutoff_mean(cutoff_m: f64) -> f64 {
    0.19 + 0.03 * (cutoff_m / 2.9e-6).ln() / 8_f64.ln()
}

fn level(row: usize) -> LevelResult {
    let penetration_m = PENETRATIONS_M[row];
    let (mean, std) = (level_mean(penetration_m), level_std(penetration_m));
    let percentile = PERCENTILES.get(row).copied();
    let gof = GoodnessResult { kolmogorov_smirnov: 0.021, kolmogorov_smirnov_p: 0.41, ..GoodnessResult::default() };
    LevelResult {
        leading: percentile.is_none(),
        control: if percentile.is_some() { Prescribed::Percentile } else { Prescribed::MeanPressure },
        percentile,
        penetration_m,
        mean_pressure_pa: percentile.map_or(3e6, |percentile| 4e6 * percentile),
        contact_fraction: 0.02,
        plastic_share: 0.3,
        mean: Some(mean),
        mean_interval: Some([0.994 * mean, 1.006 * mean]),
        std: Some(std),
        std_interval: Some([0.88 * std, 1.15 * std]),
        coefficient_of_variation: Some(std / mean),
        skewness: Some(0.54),
        excess_kurtosis: Some(-0.12),
        correlation_length_m: Some(2.4e-4),
        correlation_length_m_interval: Some([1.9e-4, 3.1e-4]),
        marginal: Some(law("beta", &[("a", 2.13), ("b", 4.9), ("low", 0.1851), ("high", 0.2303)])),
        marginal_parameter_intervals: BTreeMap::from([("a".into(), Some([1.8, 2.6])), ("b".into(), None)]),
        gof: Some(gof.clone()),
        return_levels: vec![
            ReturnLevelResult { distance_m: 0.1, mu: 0.231, interval: Some([0.228, 0.236]) },
            ReturnLevelResult { distance_m: 1.0, mu: 0.24, interval: None },
        ],
        tail: Some(TailResult { largest: 0.25, threshold: 0.22, peaks: 31, shape: -0.2, shape_interval: [-0.4, 0.1] }),
        beta: Some(law("beta", &[("a", 2.13)])),
        process: LevelProcess {
            correlation_length_without_window_m: Some(2.5e-5),
            correlation_length_without_window_m_interval: Some([2.1e-5, 2.9e-5]),
            correlation_without_window_model: Some("exponential".into()),
            correlation_families_told_apart: Some(false),
            window_only: Some(percentile.is_none()),
            at_mean_load: AtMeanLoad {
                mean: 0.996 * mean,
                std: 0.7 * std,
                std_interval: Some([0.65 * std, 0.8 * std]),
                correlation_length_m: Some(2.5e-4),
                correlation_length_m_interval: Some([2e-4, 3.2e-4]),
                correlation_curves: vec![CorrelationCurveResult {
                    model: "matern".into(),
                    length_m: 6e-4,
                    misfit: 0.012,
                }],
                correlation_models: vec![CorrelationModelResult {
                    model: "exponential".into(),
                    length_m: 0.0,
                    length_interval: [0.0, 8.5e-6],
                    aic_difference: 0.0,
                    worse_beyond_chance: false,
                }],
                marginal: Some(law("lognormal", &[("mu", -4.2), ("sigma", 0.3), ("shift", 0.18)])),
                gof: Some(gof.clone()),
                laws: vec![RankedDistributionResult {
                    name: "shifted_lognormal".into(),
                    aic_difference: 0.0,
                    gof: Some(gof),
                }],
                effective_windows: 118.0,
                ..AtMeanLoad::default()
            },
            stationarity: Some(StationarityResult {
                trend_per_m: Some(0.0087),
                trend_p: Some(0.69),
                mean_change_p: Some(0.78),
                ends_p: Some(0.061),
                variance_change_p: Some(0.67),
                wander_p: None,
            }),
            area_and_load: Some(CrossResult { correlation: 0.98, interval: [0.97, 0.985] }),
            upscaling: UpscalingResult {
                paper: PaperUpscalingResult { std: 0.0055 },
                area: AreaUpscalingResult {
                    nominal_area_m2: 8.33e-4,
                    windows: 18500.0,
                    variance_reduction: 6.1e-5,
                    std: 4.3e-5,
                },
            },
            ..LevelProcess::default()
        },
        contact_cells_per_window: 21.0,
        effective_windows: 120.0,
        ..LevelResult::default()
    }
}

pub(super) fn friction() -> FrictionResult {
    let point = |row: usize| {
        let mean = cutoff_mean(CUTOFFS_M[row]);
        CutoffPoint {
            cutoff_m: CUTOFFS_M[row],
            mean,
            mean_interval: Some([0.98 * mean, 1.02 * mean]),
            rms_slope: RMS_SLOPES[row],
            plastic_fraction: PLASTIC_FRACTIONS[row],
        }
    };
    FrictionResult {
        body: RoughBody::Track,
        window_m: 6e-4,
        window_width_m: 7.5e-5,
        strip_width_m: 7.5e-5,
        mean_compliance_m_per_pa: Some(8.28e-15),
        realisations: 60,
        operating_point: OperatingPoint {
            level: "the nominal pressure".into(),
            percentile: None,
            penetration_m: 6.2e-7,
            mean_pressure_pa: 3e6,
            contact_fraction: 0.02,
            contact_fraction_interval: Some([0.019, 0.021]),
            contact_stiffness_pa_per_m: Some(5.6e12),
            contact_stiffness_pa_per_m_se: Some(1.2e11),
            mean: 0.2249,
            mean_interval: Some([0.2181, 0.2289]),
            mean_computational_interval: Some([0.2211, 0.2271]),
            mean_sampling_interval: Some([0.2227, 0.2271]),
            mean_of_scan: Some(0.2214),
            grid_error: Some(0.0012),
            saturation: Some(0.244),
            resolved: true,
            std: 0.0058,
            std_interval: None,
            std_nominal_area: 4.3e-5,
        },
        levels: (0..PENETRATIONS_M.len()).map(level).collect(),
        scan: Some(ScanFriction {
            size_m: [5e-4, 5e-4],
            pitches_m: vec![1e-6, 5e-7],
            slope_ratio: Some(1.02),
            cut_offs: [(4e-6, 0.2236, 0.09), (2e-6, 0.2214, 0.1)]
                .map(|(cutoff_m, mean, rms_slope)| ScanCutoff {
                    cutoff_m,
                    mean,
                    mean_interval: [0.98 * mean, 1.02 * mean],
                    grid_error: Some(0.0007),
                    order: None,
                    std: 0.02,
                    rms_slope,
                    plastic_fraction: 0.2,
                })
                .into(),
        }),
        cutoff: Some(CutoffResult {
            mean_pressure_pa: 3e6,
            strips: 4,
            strip_length_m: 3e-3,
            pitch_m: 1.45e-6,
            cutoff_m: 2.9e-6,
            band_end_m: Some(4e-6),
            plastic_floor: Some(0.17),
            points: (0..CUTOFFS_M.len()).map(point).collect(),
            finer_pitches: vec![FinerPitch {
                pitch_m: 7.25e-7,
                mean: 0.1834,
                mean_interval: Some([0.179, 0.187]),
                change: -0.0066,
                change_interval: [-0.008, -0.005],
            }],
            known: "The friction coefficient is known only as far as the shortest waves are.".into(),
        }),
        uncertainty: None,
    }
}

/// Friction over two uncertain parameters of the surface; the standard deviation does not vary.
pub(crate) fn uncertainty(levels: usize) -> UncertaintyResult {
    let index = |name: &str, total: f64| ParameterIndexResult {
        parameter: name.into(),
        first: total - 0.02,
        first_interval: [total - 0.05, total],
        total,
        total_interval: [total - 0.03, total + 0.03],
    };
    let response = |name: &str| UncertainResponse {
        name: name.into(),
        value: Some(0.2),
        std: Some(0.01),
        loo_error: Some(0.02),
        sobol: vec![index("rms_height", 0.3), index("correlation_length", 0.74)],
        ..UncertainResponse::default()
    };
    let constant = UncertainResponse {
        name: "std".into(),
        value: Some(0.0),
        std: Some(0.0),
        loo_error: Some(0.0),
        ..UncertainResponse::default()
    };
    let level = UncertainLevel {
        responses: vec![
            constant.clone(),
            UncertainResponse { interval: Some([0.19, 0.23]), sobol: Vec::new(), ..response("mean") },
        ],
        at_mean_load: vec![response("mean"), constant, response("correlation_length_m")],
        failures: vec![FailedPoint { point: 3, reason: "a strip carries no load".into() }],
        ..UncertainLevel::default()
    };
    let parameter = UncertainParameter {
        name: "rms_height".into(),
        mean: 1e-6,
        std: 1e-7,
        law: law("lognormal", &[("mu", -13.8)]),
    };
    UncertaintyResult { points: 32, realisations: 4, parameters: vec![parameter], levels: vec![level; levels] }
}
