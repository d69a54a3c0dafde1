//! Measured surfaces.

use asperity_results::{
    Companions, CovarianceCandidateResult, CovarianceResult, EmpiricalCovariance, KarhunenLoeveResult, MeasuredSurface,
    PartStatistics, PooledResult, ScanOfPart, SpreadResult, SurfaceResult, SurfaceStatistics,
};

use super::law;

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
        psd_corners_m2: 1.2e-15,
        intervals: Companions(vec![
            ("Sq_m".into(), spread([9.41e-7, 1.0614e-6], 3.1e-8)),
            ("Ssk".into(), spread([-0.4, -0.03], 0.1)),
            ("Sku".into(), None),
        ]),
        ..SurfaceStatistics::default()
    }
}

pub(super) fn surface(measured: MeasuredSurface) -> SurfaceResult {
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
