//! Entries of `results.json` for scans and random surfaces.

use crate::correlation::{CorrelationModel, StationaryCovariance};
use crate::study::result::{
    self, Companions, CovarianceResult, PartStatistics, PooledResult, ScanOfPart, SpreadResult, SurfaceStatistics,
    finite, pair,
};
use crate::surface::model::{SelectedCovariance, SurfaceCovariance};
use crate::surface::pooling::Pooled;
use crate::surface::profile::ProfileStatistics;
use crate::surface::scanned::{MapStatistics, PooledStatistics};
use crate::surface::uncertainty::Estimate;

/// Returns the statistics of a map as `results.json` stores them.
pub fn surface_statistics(map: &MapStatistics) -> SurfaceStatistics {
    let &MapStatistics { grid, parameters, reliable, correlation_lengths_m, scaling, estimates, .. } = map;
    let (range_m, core, secant) = (map.hurst_range_m(), parameters.core, parameters.core_secant);
    SurfaceStatistics {
        nx: grid.nx(),
        ny: grid.ny(),
        dx_m: grid.dx_m(),
        dy_m: grid.dy_m(),
        missing_points: parameters.missing,
        outliers: map.outliers,
        form_radius_m: map.form_radius_m,
        Sa_m: parameters.sa_m,
        Sq_m: parameters.sq_m,
        Ssk: finite(parameters.ssk),
        Sku: finite(parameters.sku),
        Sp_m: parameters.sp_m,
        Sv_m: parameters.sv_m,
        Sz_m: parameters.sz_m,
        Sdq: parameters.sdq,
        Sdq_7point: parameters.sdq_7point,
        Sdr: parameters.sdr,
        Sal_m: parameters.sal_m,
        Str: parameters.str_ratio,
        Std_rad: parameters.std_rad,
        Ssw_m: parameters.ssw_m,
        Sk_m: core.sk_m,
        Spk_m: core.spk_m,
        Svk_m: core.svk_m,
        Smrk1: core.smrk1,
        Smrk2: core.smrk2,
        Spkx_m: core.spkx_m,
        Svkx_m: core.svkx_m,
        Sk_secant_m: secant.sk_m,
        Spk_secant_m: secant.spk_m,
        Svk_secant_m: secant.svk_m,
        Smrk1_secant: secant.smrk1,
        Smrk2_secant: secant.smrk2,
        Sxp_m: parameters.sxp_m,
        Vmp_m: parameters.vmp_m,
        Vmc_m: parameters.vmc_m,
        Vvc_m: parameters.vvc_m,
        Vvv_m: parameters.vvv_m,
        psd_reliable_low_rad_per_m: reliable.low_rad_per_m,
        psd_reliable_high_rad_per_m: reliable.high_rad_per_m,
        psd_upper_limit: reliable.upper_limit.name().into(),
        psd_corners_m2: map.corners_m2,
        correlation_length_x_m: correlation_lengths_m[0],
        correlation_length_y_m: correlation_lengths_m[1],
        hurst: scaling.map(|s| s.hurst),
        hurst_se: scaling.and_then(|s| s.hurst_se),
        hurst_range_low_m: range_m.map(|range_m| range_m.0),
        hurst_range_high_m: range_m.map(|range_m| range_m.1),
        fractal_dimension: scaling.map(|s| s.fractal_dimension),
        intervals: Companions(estimates.named().map(|(name, found)| (name.to_owned(), found.map(spread))).into()),
    }
}

/// Returns the parameters of a profile as `asperity surface stats` prints them.
pub fn profile_statistics(profile: &ProfileStatistics) -> result::ProfileStatistics {
    let (prepared, features, reliable) = (&profile.prepared, &profile.features, profile.spectrum.reliable);
    let of_estimates = profile.estimates.iter().map(|(name, found)| ((*name).to_owned(), found.map(spread)));
    let of_features = profile.feature_intervals.iter().map(|(name, found)| {
        let spread = |(interval, standard_error)| SpreadResult { interval: pair(interval), standard_error };
        ((*name).to_owned(), found.map(spread))
    });
    result::ProfileStatistics {
        nx: prepared.profile.heights_m().len(),
        dx_m: prepared.profile.pitch_m(),
        missing_points: profile.missing,
        outliers: prepared.outliers,
        form_radius_m: prepared.radius_m,
        sections: features.sections,
        Ra_m: profile.ra_m,
        Rq_m: profile.rq_m,
        Rsk: finite(profile.rsk),
        Rku: finite(profile.rku),
        Rp_m: features.rp_m,
        Rv_m: features.rv_m,
        Rz_m: features.rz_m,
        Rt_m: features.rt_m,
        RSm_m: features.rsm_m,
        Rdq: profile.rdq,
        Rdq_7point: profile.rdq_7point,
        correlation_length_m: profile.correlation_length_m,
        psd_reliable_low_rad_per_m: reliable.low_rad_per_m,
        psd_reliable_high_rad_per_m: reliable.high_rad_per_m,
        psd_upper_limit: reliable.upper_limit.name().into(),
        intervals: Companions(of_estimates.chain(of_features).collect()),
    }
}

fn spread(estimate: Estimate) -> SpreadResult {
    SpreadResult { interval: pair(estimate.interval), standard_error: estimate.standard_error }
}

/// Returns the statistics of a part as `results.json` stores them: points and pitches if all scans have the same, the missing points
/// and outliers of all scans, the wavenumbers at which every spectrum is reliable, and the outermost lags of the Hurst exponents.
pub fn part_statistics(part: &PooledStatistics) -> PartStatistics {
    let named = |(name, pooled): &(&str, Option<Pooled>)| ((*name).to_owned(), pooled.as_ref().map(pooled_result));
    let scans: Vec<ScanOfPart> = part
        .scans
        .iter()
        .map(|(file, scan)| ScanOfPart { file: file.clone(), statistics: surface_statistics(scan) })
        .collect();
    let all = || scans.iter().map(|scan| &scan.statistics);
    let narrowest = all().min_by(|a, b| a.psd_reliable_high_rad_per_m.total_cmp(&b.psd_reliable_high_rad_per_m));
    PartStatistics {
        scan_count: scans.len(),
        nx: common(all().map(|s| s.nx)),
        ny: common(all().map(|s| s.ny)),
        dx_m: common(all().map(|s| s.dx_m)),
        dy_m: common(all().map(|s| s.dy_m)),
        missing_points: all().map(|s| s.missing_points).sum(),
        outliers: all().map(|s| s.outliers).sum(),
        pooled: Companions(part.statistics.iter().map(named).collect()),
        psd_reliable_low_rad_per_m: all().map(|s| s.psd_reliable_low_rad_per_m).fold(f64::NAN, f64::max),
        psd_reliable_high_rad_per_m: all().map(|s| s.psd_reliable_high_rad_per_m).fold(f64::NAN, f64::min),
        psd_upper_limit: narrowest.map_or_else(String::new, |scan| scan.psd_upper_limit.clone()),
        hurst_range_low_m: all().filter_map(|s| s.hurst_range_low_m).reduce(f64::min),
        hurst_range_high_m: all().filter_map(|s| s.hurst_range_high_m).reduce(f64::max),
        scans,
    }
}

/// Returns the value on which all scans agree.
fn common<T: PartialEq>(mut values: impl Iterator<Item = T>) -> Option<T> {
    let first = values.next()?;
    values.all(|value| value == first).then_some(first)
}

fn pooled_result(pooled: &Pooled) -> PooledResult {
    let Pooled { value, standard_error, within_std, between_std, .. } = *pooled;
    PooledResult { value, interval: pair(pooled.interval), standard_error, within_std, between_std }
}

/// Converts the selection of a covariance to its entry of `results.json`.
pub fn covariance_result(selected: &SelectedCovariance) -> CovarianceResult {
    let covariance = &selected.covariance;
    let [decay_length_x_m, decay_length_y_m] = covariance.decay_lengths_m();
    let common = CovarianceResult {
        model: "empirical".into(),
        std_m: covariance.std_m(),
        length_x_m: decay_length_x_m,
        length_y_m: decay_length_y_m,
        decay_length_x_m,
        decay_length_y_m,
        smoothness: None,
        hurst: None,
        misfit: selected.misfit,
        slope_ratio: selected.slope_ratio,
        slope_cutoff_m: selected.slope_cutoff_m,
        candidates: selected.candidates.clone(),
        empirical: None,
    };
    match covariance {
        SurfaceCovariance::Empirical(own) => CovarianceResult { empirical: Some(own.report()), ..common },
        SurfaceCovariance::Model(own) => {
            let (smoothness, hurst) = match own.model() {
                CorrelationModel::Matern { nu } => (Some(nu), None),
                CorrelationModel::SelfAffine { hurst } => (None, Some(hurst)),
                _ => (None, None),
            };
            let (length_x_m, length_y_m) = (own.length_x_m(), own.length_y_m());
            CovarianceResult { model: own.model().name().into(), length_x_m, length_y_m, smoothness, hurst, ..common }
        }
    }
}
