//! Spectra of a scan in bins with their bands, beside that of the model.

use std::f64::consts::PI;

use crate::correlation::{Axis, BinnedSpectrum, Covariance, binned_profile_spectrum, binned_radial_spectrum};
use crate::map::HeightMap;
use crate::study::Table;

/// Directions over a quarter turn on which the model's radial mean rests.
const DIRECTIONS: usize = 90;

/// Tables `height_psd_radial`, `height_psd_x` and `height_psd_y`; those of spectra that do not exist are left out.
pub(super) fn binned_tables(map: &HeightMap, covariance: Option<&Covariance>) -> Vec<(&'static str, Table)> {
    let mut tables = vec![];
    if let Ok(spectrum) = binned_radial_spectrum(map) {
        let model = covariance.map(|covariance| move |q: f64| radial_mean_m4(covariance, q));
        tables.push(("height_psd_radial", table(spectrum, "m4", model)));
    }
    if let Ok(spectrum) = binned_profile_spectrum(map, Axis::X) {
        let model = covariance.map(|covariance| move |q: f64| covariance.profile_psd_x_m3(q));
        tables.push(("height_psd_x", table(spectrum, "m3", model)));
    }
    if let Ok(spectrum) = binned_profile_spectrum(map, Axis::Y) {
        let model = covariance.map(|covariance| move |q: f64| covariance.profile_psd_y_m3(q));
        tables.push(("height_psd_y", table(spectrum, "m3", model)));
    }
    tables.retain(|(_, table)| table.columns().iter().any(|(_, values)| !values.is_empty()));
    tables
}

fn table(spectrum: BinnedSpectrum, unit: &str, model: Option<impl Fn(f64) -> f64>) -> Table {
    let model = model.map(|model| spectrum.q_rad_per_m.iter().map(|q| model(*q)).collect());
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

/// Mean of the model's density over the directions of q, by symmetry over a quarter turn.
fn radial_mean_m4(covariance: &Covariance, q_rad_per_m: f64) -> f64 {
    let angles = (0..DIRECTIONS).map(|i| (i as f64 + 0.5) * 0.5 * PI / DIRECTIONS as f64);
    let density = |angle: f64| covariance.psd_m4(q_rad_per_m * angle.cos(), q_rad_per_m * angle.sin());
    angles.map(density).sum::<f64>() / DIRECTIONS as f64
}
