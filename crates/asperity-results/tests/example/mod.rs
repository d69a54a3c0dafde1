//! Invented results with every key of `results.json` and `comparison.json`.
#![allow(dead_code, reason = "each test that includes this file uses a part of it")]

pub(crate) mod verdict;

use std::collections::BTreeMap;
use std::f64::consts::E;

use asperity_results::{
    AreaScatter, AtMeanLoad, BandMethod, CoarseEntry, Companions, Comparison, CorrelationCurveResult,
    CorrelationModelResult, CoupledCycleResult, CoupledMotion, CovarianceCandidateResult, CovarianceResult,
    CrossResult, CrossingResult, CurveComparison, CutoffPoint, CutoffResult, CycleResult, DampingResult,
    EmpiricalCovariance, EnsembleResult, FailedPoint, FrictionResult, GlobalExpansionEntry, GoodnessResult,
    HalvedPitch, HomogeneityEntry, IndexEntry, KarhunenLoeveResult, KindResult, LawResult, LevelResult,
    MapResolutionResult, MapResult, MapsEntry, MeasuredSurface, MethodEntry, ModeCouplingResult, MotionResult,
    OperatingPoint, PaperScatter, ParameterIndexResult, PartStatistics, PointsResult, PooledResult, Prescribed,
    PressureQuantile, PressureResult, RankedLawResult, Results, ReturnLevelResult, RoughBodyResult, ScalarEntry,
    ScalarQuantile, ScanOfPart, SensitivityEntry, SpreadResult, StationarityResult, StatisticComparison, SurfaceResult,
    SurfaceStatistics, TailResult, TwinModel, UncertainLevel, UncertainParameter, UncertainResponse, UncertaintyResult,
    UpscalingResult, VibrationResult,
};

/// Penetrations of the levels; the last one leads.
pub(crate) const PENETRATIONS_M: [f64; 6] = [1.35e-6, 1.72e-6, 2.33e-6, 3.0e-6, 3.68e-6, 0.62e-6];
/// Percentiles of all levels but the last.
pub(crate) const PERCENTILES: [f64; 5] = [5.0, 10.0, 25.0, 50.0, 75.0];
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

/// Results of a study with one scan and all stages.
pub(crate) fn results() -> Results {
    Results {
        seed: 2016,
        surface: Some(surface(MeasuredSurface::Scan(Box::new(scan())))),
        pressure: Some(pressure()),
        friction: Some(friction()),
        vibration: Some(vibration()),
        assumptions: vec!["The boundary of the pressure patches is free.".into()],
        warnings: vec![
            "At the level of 3 MPa the windows hold 21 contact cells on average; about 30 are needed.".into(),
        ],
        ..Results::default()
    }
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
        kind: KindResult::Flutter,
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

/// The measured surface of several scans in place of one.
pub(crate) fn part(scans: Vec<ScanOfPart>) -> MeasuredSurface {
    let pooled = PooledResult {
        value: 1.1e-6,
        interval: [0.9e-6, 1.3e-6],
        standard_error: 1e-7,
        within_std: Some(2e-8),
        between_std: Some(1.2e-7),
    };
    MeasuredSurface::Part(Box::new(PartStatistics {
        scan_count: scans.len(),
        nx: Some(256),
        ny: Some(256),
        dx_m: Some(7.8125e-7),
        dy_m: None,
        missing_points: 914,
        outliers: 3,
        pooled: Companions(vec![("Sq_m".into(), Some(pooled)), ("hurst".into(), None)]),
        psd_reliable_low_rad_per_m: 6.3e4,
        psd_reliable_high_rad_per_m: 2e6,
        psd_upper_limit: "pixel".into(),
        hurst_range_low_m: Some(1.6e-6),
        hurst_range_high_m: Some(2.5e-5),
        scans,
    }))
}

/// Statistics of a scan.
pub(crate) fn scan() -> SurfaceStatistics {
    let spread = |interval, standard_error| Some(SpreadResult { interval, standard_error });
    SurfaceStatistics {
        nx: 256,
        ny: 256,
        dx_m: 7.8125e-7,
        dy_m: 7.8125e-7,
        missing_points: 457,
        outliers: 2,
        form_radius_m: Some(0.05),
        Sa_m: 7.9e-7,
        Sq_m: 1.0012e-6,
        Ssk: Some(-0.214),
        Sku: Some(3.31),
        Sp_m: 3.2e-6,
        Sv_m: 4.1e-6,
        Sz_m: 7.3e-6,
        Sdq: Some(0.183),
        Sdr: Some(0.0161),
        Sal_m: Some(1.4e-5),
        Str: Some(0.71),
        Sk_m: 2.5e-6,
        Spk_m: 9.6e-7,
        Svk_m: 1.2e-6,
        Smrk1: 0.102,
        Smrk2: 0.889,
        correlation_length_x_m: Some(2e-5),
        correlation_length_y_m: Some(1.4e-5),
        hurst: Some(0.78),
        fractal_dimension: Some(2.22),
        psd_reliable_low_rad_per_m: 6.3e4,
        psd_reliable_high_rad_per_m: 2e6,
        psd_upper_limit: "roll_off".into(),
        intervals: Companions(vec![
            ("Sq_m".into(), spread([9.41e-7, 1.0614e-6], 3.1e-8)),
            ("Ssk".into(), spread([-0.4, -0.03], 0.1)),
            ("Sku".into(), None),
        ]),
        ..SurfaceStatistics::default()
    }
}

fn surface(measured: MeasuredSurface) -> SurfaceResult {
    SurfaceResult {
        measured,
        covariance: Some(CovarianceResult {
            model: "squared_exponential".into(),
            std_m: 1e-6,
            length_x_m: 2e-5,
            length_y_m: 1.4e-5,
            decay_length_x_m: 2e-5,
            decay_length_y_m: 1.4e-5,
            misfit: Some(0.12),
            candidates: vec![CovarianceCandidateResult {
                model: "squared_exponential".into(),
                misfit: Some(0.12),
                slope_ratio: Some(1.02),
            }],
            empirical: Some(EmpiricalCovariance { reliable_x_m: 5e-5, decayed_x: true, ..Default::default() }),
            ..CovarianceResult::default()
        }),
        marginal: law("normal", &[("mean", 0.0), ("std", 1e-6)]),
        karhunen_loeve: Some(KarhunenLoeveResult {
            modes: 101,
            captured_variance: 0.9401,
            captured_slope_variance: 0.6,
        }),
    }
}

/// A distribution with its parameters.
pub(crate) fn law(name: &str, parameters: &[(&str, f64)]) -> LawResult {
    LawResult {
        name: name.into(),
        parameters: parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
    }
}

fn pressure() -> PressureResult {
    let quantile = PressureQuantile { probability: 0.9, pressure_pa: 6e8, pressure_pa_interval: Some([5.8e8, 6.2e8]) };
    let method = |name: &str, contact_probability, standard_error: Option<f64>, ks, wasserstein| MethodEntry {
        name: name.into(),
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
        ks_resolution: 0.0192,
        methods: vec![
            method("monte_carlo", 0.3121, Some(0.0207), 0.0512, 0.061),
            method("latin_hypercube", 0.3262, Some(0.0152), 0.0301, 0.0402),
            MethodEntry { fine_solves: 512, ..method("sobol", 0.3184, None, 0.0149, 0.0181) },
            method("polynomial_chaos", 0.34, Some(0.0212), 0.0402, 0.0711),
            method("polynomial_chaos_log", 0.32, Some(0.0209), 0.0333, 0.0502),
            method("polynomial_chaos_local", 0.317, Some(0.0212), 0.0212, 0.0311),
            MethodEntry {
                work_in_fine_solves: 1490.5,
                coarse_solves: vec![coarse(16, 9000), coarse(32, 1712)],
                contact_probability_interval: Some([0.3034, 0.3466]),
                mean_pa: Some(1.62e8),
                mean_se_pa: Some(2.1e6),
                mean_interval: Some([1.579e8, 1.661e8]),
                quantiles: vec![quantile],
                ..method("default", 0.325, Some(0.011), 0.0051, 0.0072)
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
        correlation_length_without_window_m: Some(2.5e-5),
        correlation_length_without_window_m_interval: Some([2.1e-5, 2.9e-5]),
        correlation_without_window_model: Some("exponential".into()),
        window_only: Some(percentile.is_none()),
        marginal: Some(law("beta", &[("a", 2.13), ("b", 4.9), ("low", 0.1851), ("high", 0.2303)])),
        marginal_parameter_intervals: BTreeMap::from([("a".into(), Some([1.8, 2.6])), ("b".into(), None)]),
        gof: Some(gof.clone()),
        return_levels: vec![
            ReturnLevelResult { distance_m: 0.1, mu: 0.231, interval: Some([0.228, 0.236]) },
            ReturnLevelResult { distance_m: 1.0, mu: 0.24, interval: None },
        ],
        tail: Some(TailResult { largest: 0.25, threshold: 0.22, peaks: 31, shape: -0.2, shape_interval: [-0.4, 0.1] }),
        beta: Some(law("beta", &[("a", 2.13)])),
        at_mean_load: AtMeanLoad {
            mean: 0.996 * mean,
            std: 0.7 * std,
            correlation_length_m: Some(2.5e-4),
            correlation_length_m_interval: Some([2e-4, 3.2e-4]),
            correlation_curves: vec![CorrelationCurveResult {
                model: "triangle".into(),
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
            laws: vec![RankedLawResult { name: "shifted_lognormal".into(), aic_difference: 0.0, gof: Some(gof) }],
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
            paper: PaperScatter { std: 0.0055 },
            area: AreaScatter { nominal_area_m2: 8.33e-4, windows: 18500.0, variance_reduction: 6.1e-5, std: 4.3e-5 },
        },
        contact_cells_per_window: 21.0,
        effective_windows: 120.0,
        ..LevelResult::default()
    }
}

fn friction() -> FrictionResult {
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
        body: RoughBodyResult::Track,
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
            mean_interval: Some([0.2227, 0.2271]),
            std: 0.0058,
            std_interval: None,
            std_nominal_area: 4.3e-5,
        },
        levels: (0..PENETRATIONS_M.len()).map(level).collect(),
        cutoff: Some(CutoffResult {
            mean_pressure_pa: 3e6,
            strips: 4,
            strip_length_m: 3e-3,
            pitch_m: 1.45e-6,
            cutoff_m: 2.9e-6,
            band_end_m: Some(4e-6),
            plastic_floor: Some(0.17),
            points: (0..CUTOFFS_M.len()).map(point).collect(),
            halved_pitch: Some(HalvedPitch {
                pitch_m: 7.25e-7,
                mean: 0.1834,
                mean_interval: Some([0.179, 0.187]),
                change: -0.0066,
                change_interval: [-0.008, -0.005],
            }),
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
        responses: vec![constant.clone()],
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

fn vibration() -> VibrationResult {
    let sweep = |upscaling: usize| {
        let entry = |damping_ratio| {
            let cycles = cycles(damping_ratio);
            let half = [2.5, 0.2][upscaling - 1];
            let lost = cycles[0] - cycles[upscaling];
            DampingResult {
                damping_ratio,
                kind: if cycles[0] > 0.0 { KindResult::StickSlip } else { KindResult::None },
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
    let shares = [(KindResult::StickSlip, 0.7), (KindResult::Overtaking, 0.0997), (KindResult::SlipCycle, 0.0)];
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
        kind: KindResult::StickSlip,
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

fn statistic(target: f64, inside: bool) -> StatisticComparison {
    StatisticComparison {
        target: Some(target),
        mean: Some(0.2),
        std: Some(0.02),
        band: Some([0.16, 0.24]),
        inside: Some(inside),
        defined: 10,
    }
}

/// Returns a comparison of a scan with ten twins.
pub(crate) fn comparison() -> Comparison {
    let curve = |inside| CurveComparison { inside_share: Some(inside as f64 / 20.0), inside, points: 20 };
    Comparison {
        file: "scan.x3p".into(),
        count: 10,
        seed: 4,
        points: [40, 30],
        pitch_m: [1e-6; 2],
        band_method: BandMethod::StudentT,
        band_level: 0.95,
        inside: 1,
        compared: 2,
        curves_inside: 36,
        curves_compared: 40,
        model: TwinModel {
            generator: "spectral".into(),
            boundary: "free".into(),
            translation: Some("corrected".into()),
            rms_height_m: 5.1e-7,
            form_share: Some(0.03),
            covariance: results().surface.and_then(|surface| surface.covariance),
            marginal: law("beta", &[("a", 2.1)]),
        },
        target: scan(),
        twins: vec![("Ssk".into(), statistic(0.2, true)), ("Sdq".into(), statistic(0.3, false))],
        curves: vec![("acf_x".into(), curve(19)), ("acf_y".into(), curve(17))],
        limits: vec!["Twins are stationary.".into()],
        assumptions: vec!["The plane was removed.".into()],
        warnings: vec!["1 of 2 statistics lies outside.".into()],
    }
}
