//! Spectra of a scan in bins with their bands, beside that of the model.

use crate::correlation::{Axis, BinnedSpectrum, binned_profile_spectrum, binned_radial_spectrum};
use crate::map::HeightMap;
use crate::study::Table;
use crate::study::surface_model::SurfaceCovariance;

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
