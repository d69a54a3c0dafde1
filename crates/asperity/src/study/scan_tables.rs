//! Tables behind the figures of a scan.

use crate::correlation::{Axis, ProfileSpectrum, StationaryCovariance, profile_spectrum};
use crate::distribution::Marginal;
use crate::distribution::fit::{Family, Ranking};
use crate::map::HeightMap;
use crate::stats::{Histogram, Interval, Moments};
use crate::study::result::HeightCorrelation;
use crate::study::spectra::{binned_tables, structure_table};
use crate::study::{StudyError, Table};
use crate::surface::HeightFits;
use crate::surface::model::{SurfaceCovariance, SurfaceModelError};
use crate::surface::scanned::{ScannedSurface, uncertainty};

/// Number of steps between lags at which limits of the correlation are computed.
const BAND_LAGS: usize = 40;
/// Number of fitted distributions in the table of densities.
const DRAWN: usize = 3;

/// Returns the tables of densities, correlation and spectra of a scan with those of its random surfaces.
pub(super) fn scan_tables(
    scan: &ScannedSurface,
    covariance: Option<&SurfaceCovariance>,
    marginal: &Marginal,
) -> Result<Vec<(&'static str, Table)>, StudyError> {
    let fits = HeightFits::new(&scan.map, &scan.correlation);
    let mut tables = vec![("height_pdf", densities(&fits, marginal)?), ("height_acf", acf_table(scan, covariance)?)];
    tables.extend(fits_table(&fits).map(|table| ("height_fits", table)));
    tables.extend(psd_table(&scan.map, covariance).map(|table| ("height_psd", table)));
    tables.extend(binned_tables(&scan.map, covariance));
    tables.push(("structure_function", structure_table(&scan.map)?));
    Ok(tables)
}

/// Returns table `height_pdf`: the histogram, the normal distribution of equal moments, and the best fits in columns named after
/// their distributions. Column `fitted` is the distribution that the study states, or the best fit if it uses the measured heights.
fn densities(fits: &HeightFits, marginal: &Marginal) -> Result<Table, StudyError> {
    let histogram = Histogram::new(&fits.sorted_m).map_err(StudyError::Heights)?;
    let moments = Moments::new(&fits.sorted_m);
    let normal = Marginal::normal(moments.mean, moments.std)?;
    let stated = (!matches!(marginal, Marginal::Empirical { .. })).then_some(marginal);
    let centres = histogram.centres();
    let density = |law: Option<&Marginal>| -> Vec<f64> {
        centres.iter().map(|z| law.map_or(f64::NAN, |law| law.pdf(*z))).collect()
    };
    let best = fits.ranking.fits.first().map(|fit| &fit.marginal);
    let mut columns = vec![
        ("height_m".to_owned(), centres.clone()),
        ("density_per_m".to_owned(), histogram.density()),
        ("fitted_density_per_m".to_owned(), density(stated.or(best))),
        ("normal_density_per_m".to_owned(), density(Some(&normal))),
    ];
    columns.extend(stated.map(|law| ("study_density_per_m".to_owned(), density(Some(law)))));
    let drawn = fits.ranking.fits.iter().take(DRAWN).filter(|fit| fit.family != Family::Normal);
    columns.extend(drawn.map(|fit| (format!("{}_density_per_m", fit.marginal.name()), density(Some(&fit.marginal)))));
    Ok(Table::new(columns))
}

/// Returns table `height_fits`: one row per fitted distribution in the order of Akaike's criterion, with its parameters in columns
/// named after it; `None` if no distribution could be fitted.
fn fits_table(fits: &HeightFits) -> Option<Table> {
    let Ranking { fits, goodness, effective_size, .. } = &fits.ranking;
    let least = fits.first()?.aic_correlated(*effective_size);
    let delta: Vec<f64> = fits.iter().map(|fit| fit.aic_correlated(*effective_size) - least).collect();
    let weights: f64 = delta.iter().map(|delta| (-0.5 * delta).exp()).sum();
    let tails = |i: usize| goodness[i].anderson_darling.map_or(f64::NAN, |found| found.p_value);
    let rows = 0..fits.len();
    let mut columns = vec![
        ("rank".to_owned(), rows.clone().map(|i| (i + 1) as f64).collect()),
        ("free_parameters".to_owned(), fits.iter().map(|fit| fit.family.parameters() as f64).collect()),
        ("delta_aic".to_owned(), delta.clone()),
        ("akaike_weight".to_owned(), delta.iter().map(|delta| (-0.5 * delta).exp() / weights).collect()),
        ("ks_distance".to_owned(), goodness.iter().map(|found| found.kolmogorov_smirnov.statistic).collect()),
        ("ks_p_value".to_owned(), goodness.iter().map(|found| found.kolmogorov_smirnov.p_value).collect()),
        ("anderson_darling_p_value".to_owned(), rows.clone().map(tails).collect()),
        ("effective_heights".to_owned(), vec![*effective_size; fits.len()]),
    ];
    for (row, fit) in fits.iter().enumerate() {
        for (parameter, value) in fit.marginal.parameters() {
            let name = format!("{}_{parameter}{}", fit.marginal.name(), unit_suffix(parameter));
            let values = rows.clone().map(|i| if i == row { value } else { f64::NAN }).collect();
            columns.push((name, values));
        }
    }
    Some(Table::new(columns))
}

/// Returns the unit of a parameter of a distribution as the end of a column's name.
fn unit_suffix(parameter: &str) -> &'static str {
    match parameter {
        "mean" | "std" | "shift" | "scale" | "low" | "high" | "xi" | "lambda" => "_m",
        _ => "",
    }
}

/// Returns table `height_acf`: the correlation at the lags of both axes up to half a side, with 95 % limits of the correlation of
/// the surface if the map contains enough correlation lengths.
fn acf_table(scan: &ScannedSurface, covariance: Option<&SurfaceCovariance>) -> Result<Table, StudyError> {
    let grid = scan.map.grid();
    let sides = [
        Side { acf: scan.correlation.along(Axis::X), pitch_m: grid.dx_m(), points: grid.nx() },
        Side { acf: scan.correlation.along(Axis::Y), pitch_m: grid.dy_m(), points: grid.ny() },
    ];
    let lags = merged(sides.iter().flat_map(|side| (0..=side.points / 2).map(|lag| lag as f64 * side.pitch_m)));
    let on_lags = |side: &Side| lags.iter().map(|lag| side.at(*lag)).collect();
    let chosen = [0, 1].map(|axis| band_lags(sides[axis].points / 2));
    let limits = uncertainty(scan.level)
        .correlation(&scan.map, &scan.values, [&chosen[0], &chosen[1]])
        .map_err(SurfaceModelError::from)?;
    let bands = [0, 1].map(|axis| sides[axis].band(&chosen[axis], &limits[axis]));
    let [[acf_x_low, acf_x_high], [acf_y_low, acf_y_high]] =
        bands.map(|band| band.map_or_else(Default::default, |ends| ends.each_ref().map(on_lags)));
    let mut curves = HeightCorrelation {
        acf_x: on_lags(&sides[0]),
        acf_y: on_lags(&sides[1]),
        acf_x_low,
        acf_x_high,
        acf_y_low,
        acf_y_high,
        ..HeightCorrelation::default()
    };
    if let Some(covariance) = covariance {
        curves.fit_x = lags.iter().map(|lag| covariance.correlation(*lag, 0.0)).collect();
        curves.fit_y = lags.iter().map(|lag| covariance.correlation(0.0, *lag)).collect();
    }
    Ok(Table::from(HeightCorrelation { lag_m: lags.into(), ..curves }))
}

/// Returns table `height_psd`: profile spectra at the wavenumbers of both axes; an axis without a complete profile is empty.
fn psd_table(map: &HeightMap, covariance: Option<&SurfaceCovariance>) -> Option<Table> {
    let [x, y] = [Axis::X, Axis::Y].map(|axis| profile_spectrum(map, axis).ok());
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
    Some(Table::new(columns).with_first("wavenumber_rad_per_m"))
}

/// Correlation along one axis.
struct Side {
    acf: Vec<f64>,
    pitch_m: f64,
    points: usize,
}

impl Side {
    /// Interpolates lower and upper limits to all lags; their distance from the correlation is linear between lags.
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

    /// Interpolates the correlation linearly at a lag; returns NaN beyond half the side.
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

/// Returns the lags at which limits are computed, from 0 to `last` with increasing distances.
fn band_lags(last: usize) -> Vec<usize> {
    let lag = |k: usize| (last as f64 * (k as f64 / BAND_LAGS as f64).powi(2)).round() as usize;
    let mut lags: Vec<usize> = (0..=BAND_LAGS).map(lag).collect();
    lags.dedup();
    lags
}

/// Returns the sorted values without repetitions.
fn merged(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    #[test]
    fn every_row_of_the_table_has_the_parameters_of_one_law() {
        let normal = random::standard_normal(&mut random::stream(41, "height fits", 0), 64 * 64);
        let heights: Vec<f64> = normal.iter().map(|g| 1e-6 * (0.5 * g).sinh()).collect();
        let fits = HeightFits::with_effective_size(heights.into_iter(), 1000.0);
        let table = fits_table(&fits).unwrap();
        let column = |name: &str| table.column(name).unwrap();
        // sinh(g/2) is Johnson's S_U with γ = 0, δ = 2 and λ = 1 µm; δ has a standard error of about δ/√(n/2).
        assert_eq!(column("rank")[0], 1.0);
        assert!((column("johnson_su_delta")[0] - 2.0).abs() < 0.3, "{table:?}");
        assert!((column("johnson_su_lambda_m")[0] / 1e-6 - 1.0).abs() < 0.2);
        assert!(column("normal_std_m")[0].is_nan());
        assert_eq!(column("delta_aic")[0], 0.0);
        assert!(column("delta_aic").is_sorted());
        assert!((column("akaike_weight").iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let drawn = densities(&fits, &Marginal::empirical(vec![0.0, 1.0]).unwrap()).unwrap();
        assert_eq!(drawn.column("fitted_density_per_m"), drawn.column("johnson_su_density_per_m"));
        assert!(drawn.column("study_density_per_m").is_none());
        let stated = densities(&fits, &Marginal::normal(0.0, 1e-6).unwrap()).unwrap();
        assert_eq!(stated.column("fitted_density_per_m"), stated.column("study_density_per_m"));
    }
}
