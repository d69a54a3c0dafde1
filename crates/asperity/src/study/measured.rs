//! What a scan says: its statistics, and the series behind the figures of its heights.

use crate::correlation::{
    Autocorrelation, Axis, Covariance, ProfileSpectrum, axis_correlation_length_m, profile_spectrum,
};
use crate::law::Marginal;
use crate::law::fit::{Family, rank_by_aic};
use crate::map::HeightMap;
use crate::stats::{Histogram, Moments};
use crate::study::result::{StatisticsIntervals, SurfaceStatistics};
use crate::study::{StudyError, Table};
use crate::surface::areal::Analysis;
use crate::surface::preparation::Prepared;
use crate::surface::uncertainty::{self, Uncertainty, Values};
use crate::surface::{areal, fractal};

/// Statistics of a map that was levelled and filtered.
///
/// # Errors
/// The map is flat.
pub fn statistics(prepared: &Prepared) -> Result<SurfaceStatistics, StudyError> {
    let map = &prepared.map;
    let Analysis { parameters, correlation, spectrum } = areal::analyse(map)?;
    // Where the correlation does not fall to 1/e within half the field, the farther lags are asked as well.
    let correlation_length_m = |axis: Axis| match correlation.correlation_length_m(axis) {
        Some(length_m) => Ok(Some(length_m)),
        None => axis_correlation_length_m(map, axis),
    };
    let scaling = fractal::scaling(map, None)?;
    let uncertainty =
        Uncertainty { removed_terms: uncertainty::removed_terms(prepared.level), ..Uncertainty::default() };
    let estimates = uncertainty.of(map, &Values::new(&parameters, &correlation))?;
    let grid = map.grid();
    Ok(SurfaceStatistics {
        nx: grid.nx(),
        ny: grid.ny(),
        dx_m: grid.dx_m(),
        dy_m: grid.dy_m(),
        missing_points: map.missing_points(),
        outliers: prepared.outliers,
        form_radius_m: prepared.radius_m,
        Sa_m: parameters.sa_m,
        Sq_m: parameters.sq_m,
        Ssk: parameters.ssk,
        Sku: parameters.sku,
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
        Sk_m: parameters.core.sk_m,
        Spk_m: parameters.core.spk_m,
        Svk_m: parameters.core.svk_m,
        Smrk1: parameters.core.smrk1,
        Smrk2: parameters.core.smrk2,
        Spkx_m: parameters.core.spkx_m,
        Svkx_m: parameters.core.svkx_m,
        Sk_secant_m: parameters.core_secant.sk_m,
        Spk_secant_m: parameters.core_secant.spk_m,
        Svk_secant_m: parameters.core_secant.svk_m,
        Smrk1_secant: parameters.core_secant.smrk1,
        Smrk2_secant: parameters.core_secant.smrk2,
        Sxp_m: parameters.sxp_m,
        Vmp_m: parameters.vmp_m,
        Vmc_m: parameters.vmc_m,
        Vvc_m: parameters.vvc_m,
        Vvv_m: parameters.vvv_m,
        psd_reliable_low_rad_per_m: spectrum.reliable.low_rad_per_m,
        psd_reliable_high_rad_per_m: spectrum.reliable.high_rad_per_m,
        psd_upper_limit: spectrum.reliable.upper_limit.name(),
        correlation_length_x_m: correlation_length_m(Axis::X)?,
        correlation_length_y_m: correlation_length_m(Axis::Y)?,
        hurst: scaling.map(|s| s.hurst),
        fractal_dimension: scaling.map(|s| s.fractal_dimension),
        intervals: StatisticsIntervals(estimates),
    })
}

/// A levelled scan and what was estimated from it.
pub(super) struct Measured {
    pub(super) map: HeightMap,
    pub(super) statistics: SurfaceStatistics,
    pub(super) correlation: Autocorrelation,
}

impl Measured {
    pub(super) fn of(prepared: Prepared) -> Result<Self, StudyError> {
        let statistics = statistics(&prepared)?;
        let map = prepared.map;
        let correlation = Autocorrelation::estimate(&map)?;
        Ok(Self { map, statistics, correlation })
    }

    /// Density, correlation and spectra, beside the law and the covariance of the random surfaces, where they have one.
    pub(super) fn tables(
        &self,
        covariance: Option<&Covariance>,
        marginal: &Marginal,
    ) -> Result<Vec<(&'static str, Table)>, StudyError> {
        let mut tables = vec![("height_pdf", self.pdf_table(marginal)?), ("height_acf", self.acf_table(covariance))];
        tables.extend(self.psd_table(covariance).map(|table| ("height_psd", table)));
        Ok(tables)
    }

    fn pdf_table(&self, marginal: &Marginal) -> Result<Table, StudyError> {
        let heights: Vec<f64> = self.map.present_m().collect();
        let histogram = Histogram::of(&heights).map_err(StudyError::Heights)?;
        let moments = Moments::of(&heights);
        let normal = Marginal::normal(moments.mean, moments.std)?;
        // The law drawn beside the histogram: the stated one, or the best fit to a thinned sample of the measured.
        let fitted = if let Marginal::Empirical { sorted } = marginal {
            let stride = (sorted.len() / 4096).max(1);
            let thinned: Vec<f64> = sorted.iter().copied().skip(stride / 2).step_by(stride).collect();
            rank_by_aic(&Family::ANYWHERE, &thinned, None).fits.into_iter().next().map(|fit| fit.law)
        } else {
            Some(marginal.clone())
        };
        let centres = histogram.centres();
        let fitted = |z: &f64| fitted.as_ref().map_or(f64::NAN, |law| law.pdf(*z));
        Ok(Table::new([
            ("fitted_density_per_m", centres.iter().map(fitted).collect()),
            ("normal_density_per_m", centres.iter().map(|z| normal.pdf(*z)).collect()),
            ("density_per_m", histogram.density()),
            ("height_m", centres),
        ])
        .led_by("height_m"))
    }

    /// Correlation at the lags of both axes, up to half a side, where lags rest on enough pairs.
    fn acf_table(&self, covariance: Option<&Covariance>) -> Table {
        let grid = self.map.grid();
        let sides = [
            Side { acf: self.correlation.along(Axis::X), pitch_m: grid.dx_m(), points: grid.nx() },
            Side { acf: self.correlation.along(Axis::Y), pitch_m: grid.dy_m(), points: grid.ny() },
        ];
        let lags = merged(sides.iter().flat_map(|side| (0..=side.points / 2).map(|lag| lag as f64 * side.pitch_m)));
        let [x, y] = sides.map(|side| lags.iter().map(|lag| side.at(*lag)).collect::<Vec<f64>>());
        let mut columns = vec![("acf_x", x), ("acf_y", y)];
        if let Some(covariance) = covariance {
            columns.push(("fit_x", lags.iter().map(|lag| covariance.correlation(*lag, 0.0)).collect()));
            columns.push(("fit_y", lags.iter().map(|lag| covariance.correlation(0.0, *lag)).collect()));
        }
        columns.push(("lag_m", lags));
        Table::new(columns).led_by("lag_m")
    }

    /// Profile spectra at the wavenumbers of both axes; an axis without a complete profile is empty.
    fn psd_table(&self, covariance: Option<&Covariance>) -> Option<Table> {
        let [x, y] = [Axis::X, Axis::Y].map(|axis| profile_spectrum(&self.map, axis).ok());
        let of_both = [&x, &y].into_iter().flatten().flat_map(|spectrum| spectrum.q_rad_per_m.iter().copied());
        let wavenumbers = merged(of_both.filter(|q| *q > 0.0));
        if wavenumbers.is_empty() {
            return None;
        }
        let on = |spectrum: &Option<ProfileSpectrum>| -> Vec<f64> {
            let value = |q: &f64| {
                let spectrum = spectrum.as_ref()?;
                let index = spectrum.q_rad_per_m.binary_search_by(|own| own.total_cmp(q)).ok()?;
                Some(spectrum.psd_m3[index])
            };
            wavenumbers.iter().map(|q| value(q).unwrap_or(f64::NAN)).collect()
        };
        let mut columns = vec![("psd_x_m3", on(&x)), ("psd_y_m3", on(&y))];
        if let Some(covariance) = covariance {
            columns.push(("psd_model_x_m3", wavenumbers.iter().map(|q| covariance.profile_psd_x_m3(*q)).collect()));
        }
        columns.push(("wavenumber_rad_per_m", wavenumbers));
        Some(Table::new(columns).led_by("wavenumber_rad_per_m"))
    }
}

/// The correlation along one axis.
struct Side {
    acf: Vec<f64>,
    pitch_m: f64,
    points: usize,
}

impl Side {
    /// Correlation at a lag, linear between the map's own; NaN beyond half the side.
    fn at(&self, lag_m: f64) -> f64 {
        // Equal lags of both axes may differ by rounding.
        let position = lag_m / self.pitch_m;
        let nearest = position.round();
        if (position - nearest).abs() < 1e-9 * nearest.max(1.0) {
            let within = 2.0 * nearest <= self.points as f64;
            return self.acf.get(nearest as usize).copied().filter(|_| within).unwrap_or(f64::NAN);
        }
        let left = position.floor() as usize;
        if 2.0 * position > self.points as f64 || left + 1 >= self.acf.len() {
            return f64::NAN;
        }
        self.acf[left] + (position - left as f64) * (self.acf[left + 1] - self.acf[left])
    }
}

/// Sorted values, equal ones taken once.
fn merged(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    sorted
}
