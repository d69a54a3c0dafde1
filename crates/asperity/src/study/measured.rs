//! What a scan says: its statistics, and the series behind the figures of its heights.

use crate::correlation::{
    Autocorrelation, Axis, ProfileSpectrum, StationaryCovariance, axis_correlation_length_m, profile_spectrum,
};
use crate::distribution::Marginal;
use crate::map::HeightMap;
use crate::stats::Interval;
use crate::study::band_slopes::Roughness;
use crate::study::height_fits::{HeightFits, effective_heights};
use crate::study::pooled::Part;
use crate::study::result::{Companions, SpreadResult, SurfaceStatistics, finite, pair};
use crate::study::spectra::{binned_tables, structure_table};
use crate::study::surface_model::SurfaceCovariance;
use crate::study::{StudyError, Table};
use crate::surface::areal::{Analysis, ArealError};
use crate::surface::fractal::Scaling;
use crate::surface::level::Level;
use crate::surface::pooling::Mean;
use crate::surface::preparation::Prepared;
use crate::surface::uncertainty::{Estimate, Estimates, Uncertainty, Values, removed_terms};
use crate::surface::{areal, fractal};

/// Steps between lags at which limits of the correlation are computed.
const BAND_LAGS: usize = 40;

/// Statistics of one map, and how well they are known.
#[derive(Debug, Clone, PartialEq)]
pub struct MapStatistics {
    /// The statistics as `results.json` holds them.
    pub results: SurfaceStatistics,
    /// Estimates of the statistics of the surface.
    pub estimates: Estimates,
}

impl MapStatistics {
    /// The statistics that mean something for a part of which the map is one scan, with what is averaged over scans.
    pub(super) fn poolable(&self) -> Vec<(&'static str, Option<f64>, Mean)> {
        // Their squares are means over the surface.
        const SQUARES: [&str; 3] = ["Sq_m", "Sdq", "Sdq_7point"];
        let of_map = ["dx_m", "dy_m", "form_radius_m", "Std_rad", "hurst_se"];
        let is_poolable = |name: &str| {
            !of_map.contains(&name) && !["psd_reliable", "hurst_range"].iter().any(|group| name.starts_with(group))
        };
        let all = self.results.numbers().into_iter().filter(|(name, _)| is_poolable(name));
        let (squares, others): (Vec<_>, Vec<_>) = all.partition(|(name, _)| SQUARES.contains(name));
        let of = |mean: Mean| move |(name, value)| (name, value, mean);
        squares.into_iter().map(of(Mean::RootMeanSquare)).chain(others.into_iter().map(of(Mean::Arithmetic))).collect()
    }

    /// Area of the points that are present in m².
    pub(super) fn present_area_m2(&self) -> f64 {
        let own = &self.results;
        (own.nx * own.ny - own.missing_points) as f64 * own.dx_m * own.dy_m
    }
}

fn spread(estimate: Estimate) -> SpreadResult {
    SpreadResult { interval: pair(estimate.interval), standard_error: estimate.standard_error }
}

/// Statistics of a map that was levelled and filtered.
///
/// # Errors
/// The map is flat.
pub fn statistics(prepared: &Prepared) -> Result<MapStatistics, StudyError> {
    Ok(analysed(prepared, true)?.0)
}

/// Statistics, on request with their intervals, and what they were read off.
fn analysed(prepared: &Prepared, intervals: bool) -> Result<(MapStatistics, Values, Autocorrelation), StudyError> {
    let map = &prepared.map;
    let Analysis { parameters, correlation, spectrum } = areal::analyse(map).map_err(|error| match error {
        // What was removed may have been all there was.
        ArealError::Flat { present } if prepared.level != Level::None => {
            StudyError::FormAlone { level: prepared.level, present }
        }
        error => error.into(),
    })?;
    // Where the correlation does not fall to 1/e within half the field, the farther lags are asked as well.
    let correlation_length_m = |axis: Axis| match correlation.correlation_length_m(axis) {
        Some(length_m) => Ok(Some(length_m)),
        None => axis_correlation_length_m(map, axis),
    };
    let scaling = fractal::scaling(map, None)?;
    let values = Values::new(&parameters, &correlation);
    let estimates = if intervals { uncertainty_of(prepared.level).of(map, &values)? } else { Estimates::default() };
    let grid = map.grid();
    let statistics = SurfaceStatistics {
        nx: grid.nx(),
        ny: grid.ny(),
        dx_m: grid.dx_m(),
        dy_m: grid.dy_m(),
        missing_points: map.missing_points(),
        outliers: prepared.outliers,
        form_radius_m: prepared.radius_m,
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
        psd_upper_limit: spectrum.reliable.upper_limit.name().into(),
        correlation_length_x_m: correlation_length_m(Axis::X)?,
        correlation_length_y_m: correlation_length_m(Axis::Y)?,
        hurst: scaling.map(|s| s.hurst),
        hurst_se: scaling.and_then(|s| s.hurst_se),
        hurst_range_low_m: fit_end_m(scaling, |range_m| range_m.0, f64::min),
        hurst_range_high_m: fit_end_m(scaling, |range_m| range_m.1, f64::max),
        fractal_dimension: scaling.map(|s| s.fractal_dimension),
        intervals: Companions(estimates.named().map(|(name, found)| (name.to_owned(), found.map(spread))).into()),
    };
    Ok((MapStatistics { results: statistics, estimates }, values, correlation))
}

/// An end of the lags, over the axes that scale.
fn fit_end_m(scaling: Option<Scaling>, end: fn((f64, f64)) -> f64, outer: fn(f64, f64) -> f64) -> Option<f64> {
    let Scaling { x, y, .. } = scaling?;
    [x, y].into_iter().flatten().map(|axis| end(axis.range_m)).reduce(outer)
}

fn uncertainty_of(level: Level) -> Uncertainty {
    Uncertainty { removed_terms: removed_terms(level), ..Uncertainty::default() }
}

/// A levelled scan and what was estimated from it.
pub(super) struct Measured {
    pub(super) map: HeightMap,
    pub(super) statistics: MapStatistics,
    pub(super) correlation: Autocorrelation,
    pub(super) values: Values,
    /// Form that was removed.
    pub(super) level: Level,
    /// What it says together with other scans of the part.
    pub(super) part: Option<Part>,
}

impl Measured {
    pub(super) fn of(prepared: Prepared) -> Result<Self, StudyError> {
        Self::analysed(prepared, true)
    }

    /// Without intervals.
    pub(super) fn point_values_of(prepared: Prepared) -> Result<Self, StudyError> {
        Self::analysed(prepared, false)
    }

    fn analysed(prepared: Prepared, intervals: bool) -> Result<Self, StudyError> {
        let (statistics, values, mut correlation) = analysed(&prepared, intervals)?;
        if correlation.reach() != Autocorrelation::half_field(prepared.map.grid()) {
            correlation = Autocorrelation::estimate(&prepared.map)?;
        }
        Ok(Self { map: prepared.map, statistics, correlation, values, level: prepared.level, part: None })
    }

    /// Root mean square height of the scan, or of the part.
    pub(super) fn sq_m(&self) -> f64 {
        self.part.as_ref().and_then(|part| part.statistics.value("Sq_m")).unwrap_or(self.statistics.results.Sq_m)
    }

    /// Fractal dimension of the scan, or of the part.
    pub(super) fn fractal_dimension(&self) -> Option<f64> {
        match &self.part {
            Some(part) => part.statistics.value("fractal_dimension"),
            None => self.statistics.results.fractal_dimension,
        }
    }

    /// A statistic of the scan, or of the part, with its 95 % interval.
    pub(super) fn estimate(&self, name: &str) -> Option<(f64, Interval)> {
        if let Some(part) = &self.part {
            let found = part.statistics.statistics.iter().find(|(own, _)| *own == name)?.1?;
            return Some((found.value, found.interval));
        }
        let found = self.statistics.estimates.named().into_iter().find(|(own, _)| *own == name)?.1?;
        Some((found.value, found.interval))
    }

    /// Shortest wavelength at which the spectra of all scans are reliable; `None` where none is reliable anywhere.
    pub(super) fn band_end_m(&self) -> Option<f64> {
        let of_part = self.part.iter().flat_map(|part| part.statistics.scans.iter().map(|(_, scan)| scan));
        let own = if self.part.is_some() { None } else { Some(&self.statistics) };
        own.into_iter()
            .chain(of_part)
            .map(|scan| &scan.results)
            .filter(|scan| scan.psd_reliable_high_rad_per_m > scan.psd_reliable_low_rad_per_m)
            .map(|scan| std::f64::consts::TAU / scan.psd_reliable_high_rad_per_m)
            .reduce(f64::max)
    }

    /// Spectra and slopes of the scan, or of the scans of the part.
    pub(super) fn roughness(&self) -> Result<Roughness, StudyError> {
        self.part.as_ref().map_or_else(|| Roughness::of(&[&self.map]), |part| Ok(part.roughness.clone()))
    }

    /// The heights of the scan, or of the part: a sample of the marginal law of the random surfaces.
    pub(super) fn heights_of_all_m(&self) -> Vec<f64> {
        self.part.as_ref().map_or_else(|| self.map.present_m().collect(), |part| part.heights_m.clone())
    }

    /// Density, correlation and spectra, beside the law and the covariance of the random surfaces, where they have one.
    pub(super) fn tables(
        &self,
        covariance: Option<&SurfaceCovariance>,
        marginal: &Marginal,
    ) -> Result<Vec<(&'static str, Table)>, StudyError> {
        let fits = HeightFits::of(self.map.present_m(), effective_heights(&self.correlation));
        let mut tables = vec![("height_pdf", fits.densities(marginal)?), ("height_acf", self.acf_table(covariance)?)];
        tables.extend(fits.table().map(|table| ("height_fits", table)));
        tables.extend(self.psd_table(covariance).map(|table| ("height_psd", table)));
        tables.extend(binned_tables(&self.map, covariance));
        tables.push(("structure_function", structure_table(&self.map)?));
        Ok(tables)
    }

    /// Correlation at the lags of both axes, up to half a side, where lags rest on enough pairs, with the 95 % limits of the
    /// surface's own where the map holds enough correlation lengths.
    fn acf_table(&self, covariance: Option<&SurfaceCovariance>) -> Result<Table, StudyError> {
        let grid = self.map.grid();
        let sides = [
            Side { acf: self.correlation.along(Axis::X), pitch_m: grid.dx_m(), points: grid.nx() },
            Side { acf: self.correlation.along(Axis::Y), pitch_m: grid.dy_m(), points: grid.ny() },
        ];
        let lags = merged(sides.iter().flat_map(|side| (0..=side.points / 2).map(|lag| lag as f64 * side.pitch_m)));
        let on_lags = |side: &Side| lags.iter().map(|lag| side.at(*lag)).collect::<Vec<f64>>();
        let mut columns = vec![("acf_x", on_lags(&sides[0])), ("acf_y", on_lags(&sides[1]))];
        let chosen = [0, 1].map(|axis| band_lags(sides[axis].points / 2));
        let limits = uncertainty_of(self.level).correlation(&self.map, &self.values, [&chosen[0], &chosen[1]])?;
        let names = [("acf_x_low", "acf_x_high"), ("acf_y_low", "acf_y_high")];
        for axis in 0..2 {
            if let Some([low, high]) = sides[axis].band(&chosen[axis], &limits[axis]) {
                columns.extend([(names[axis].0, on_lags(&low)), (names[axis].1, on_lags(&high))]);
            }
        }
        if let Some(covariance) = covariance {
            columns.push(("fit_x", lags.iter().map(|lag| covariance.correlation(*lag, 0.0)).collect()));
            columns.push(("fit_y", lags.iter().map(|lag| covariance.correlation(0.0, *lag)).collect()));
        }
        columns.push(("lag_m", lags));
        Ok(Table::new(columns).led_by("lag_m"))
    }

    /// Profile spectra at the wavenumbers of both axes; an axis without a complete profile is empty.
    fn psd_table(&self, covariance: Option<&SurfaceCovariance>) -> Option<Table> {
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
    /// Lower and upper limits at all lags from those at some: their distances from the correlation are linear between lags.
    fn band(&self, lags: &[usize], limits: &[Option<Interval>]) -> Option<[Self; 2]> {
        let known: Vec<(usize, Interval)> =
            lags.iter().zip(limits).filter_map(|(lag, i)| Some((*lag, (*i)?))).collect();
        let side = |end: fn(&Interval) -> f64| {
            let mut acf = vec![f64::NAN; self.acf.len()];
            for pair in known.windows(2) {
                let [(near, from), (far, to)] = [pair[0], pair[1]];
                let (from, to) = (end(&from) - self.acf[near], end(&to) - self.acf[far]);
                for lag in near..=far {
                    let part = (lag - near) as f64 / (far - near) as f64;
                    acf[lag] = self.acf[lag] + from + part * (to - from);
                }
            }
            Self { acf, ..*self }
        };
        (known.len() > 1).then(|| [side(|i| i.low), side(|i| i.high)])
    }

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

/// Lags at which limits are computed, ever wider apart up to the last: 0, 1, … `last`.
fn band_lags(last: usize) -> Vec<usize> {
    let lag = |k: usize| (last as f64 * (k as f64 / BAND_LAGS as f64).powi(2)).round() as usize;
    let mut lags: Vec<usize> = (0..=BAND_LAGS).map(lag).collect();
    lags.dedup();
    lags
}

/// Sorted values, equal ones taken once.
fn merged(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    sorted
}
