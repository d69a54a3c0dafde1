//! Spectra of a scan in bins with their bands, beside that of the model, and its structure functions.

use crate::correlation::{Axis, BinnedSpectrum, binned_profile_spectrum, binned_radial_spectrum};
use crate::map::HeightMap;
use crate::study::result::StructureFunctions;
use crate::study::{StudyError, Table};
use crate::surface::fractal::{self, ProfileScaling, StructureFunction};
use crate::surface::model::{SurfaceCovariance, SurfaceModelError};

/// Tables `height_psd_radial`, `height_psd_x` and `height_psd_y`; those of spectra that do not exist are left out.
pub(super) fn binned_tables(map: &HeightMap, covariance: Option<&SurfaceCovariance>) -> Vec<(&'static str, Table)> {
    let mut tables = vec![];
    if let Ok(spectrum) = binned_radial_spectrum(map) {
        let model = covariance.map(|covariance| move |q: &[f64]| covariance.radial_psd_m4(q));
        tables.push(("height_psd_radial", table(spectrum, "m4", model)));
    }
    if let Ok(spectrum) = binned_profile_spectrum(map, Axis::X) {
        let model =
            covariance.map(|covariance| move |q: &[f64]| q.iter().map(|q| covariance.profile_psd_x_m3(*q)).collect());
        tables.push(("height_psd_x", table(spectrum, "m3", model)));
    }
    if let Ok(spectrum) = binned_profile_spectrum(map, Axis::Y) {
        let model =
            covariance.map(|covariance| move |q: &[f64]| q.iter().map(|q| covariance.profile_psd_y_m3(*q)).collect());
        tables.push(("height_psd_y", table(spectrum, "m3", model)));
    }
    tables.retain(|(_, table)| table.columns().iter().any(|(_, values)| !values.is_empty()));
    tables
}

fn table(spectrum: BinnedSpectrum, unit: &str, model: Option<impl Fn(&[f64]) -> Vec<f64>>) -> Table {
    let model = model.map(|model| model(&spectrum.q_rad_per_m));
    let coefficients = spectrum.coefficients.iter().map(|count| *count as f64).collect();
    let mut columns = vec![
        ("wavenumber_rad_per_m".to_owned(), spectrum.q_rad_per_m),
        (format!("psd_{unit}"), spectrum.psd),
        (format!("psd_low_{unit}"), spectrum.psd_low),
        (format!("psd_high_{unit}"), spectrum.psd_high),
        ("degrees_of_freedom".to_owned(), spectrum.degrees_of_freedom),
        ("coefficients".to_owned(), coefficients),
    ];
    columns.extend(model.map(|model| (format!("psd_model_{unit}"), model)));
    Table::new(columns)
}

/// Structure functions along x and y, and the power laws fitted to them over the lags of the fit.
///
/// # Errors
/// The map is flat.
pub(super) fn structure_table(map: &HeightMap) -> Result<Table, StudyError> {
    let scaling = fractal::scaling(map, None).map_err(SurfaceModelError::from)?;
    let axes = [(Axis::X, scaling.and_then(|s| s.x)), (Axis::Y, scaling.and_then(|s| s.y))]
        .map(|(axis, scaling)| (StructureFunction::new(map, axis), scaling));
    let mut lags_m: Vec<f64> = axes.iter().flat_map(|(structure, _)| structure.lags_m.iter().copied()).collect();
    lags_m.sort_by(f64::total_cmp);
    lags_m.dedup();
    let of_axis = |(structure, scaling): &(StructureFunction, Option<ProfileScaling>)| {
        let place = |lag_m: &f64| structure.lags_m.binary_search_by(|own| own.total_cmp(lag_m)).ok();
        let measured = lags_m.iter().map(|lag| place(lag).map_or(f64::NAN, |i| structure.values_m2[i])).collect();
        let fit = |lag_m: &f64| scaling.map_or(f64::NAN, |scaling| fitted_m2(structure, scaling, *lag_m));
        [measured, lags_m.iter().map(fit).collect()]
    };
    let [[structure_x_m2, fit_x_m2], [structure_y_m2, fit_y_m2]] = axes.each_ref().map(of_axis);
    Ok(StructureFunctions { lag_m: (&lags_m).into(), structure_x_m2, structure_y_m2, fit_x_m2, fit_y_m2 }.into())
}

/// The power law of exponent 2H through the mean of the logarithms within the range of the fit, NaN beyond it.
fn fitted_m2(structure: &StructureFunction, scaling: ProfileScaling, lag_m: f64) -> f64 {
    let inside = |lag_m: f64| lag_m >= scaling.range_m.0 && lag_m <= scaling.range_m.1;
    if !inside(lag_m) {
        return f64::NAN;
    }
    let points = structure.lags_m.iter().zip(&structure.values_m2);
    let used: Vec<f64> = points
        .filter(|(lag, value)| inside(**lag) && **value > 0.0)
        .map(|(lag, value)| value.ln() - 2.0 * scaling.hurst * (lag / lag_m).ln())
        .collect();
    (used.iter().sum::<f64>() / used.len() as f64).exp()
}
