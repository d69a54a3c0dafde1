//! Height maps: files, form removal, statistics, correlation and spectra.

use std::path::PathBuf;

use asperity::choice::ByName;
use asperity::correlation::{Autocorrelation, Axis, radial_spectrum_with_bands};
use asperity::map::{HeightMap, checked_pitch_m};
use asperity::random;
use asperity::study::file::DecimalSign;
use asperity::study::{filling_warnings, part_statistics, surface_statistics};
use asperity::surface::level::Level;
use asperity::surface::preparation::{Preparation, Prepared};
use asperity::surface::scanned::{MapStatistics, PooledStatistics};
use asperity::surface::{FillCovariance, FillMarginal, FillOptions, Filling, RandomSurface, filling_memory_bytes};
use asperity_formats::{Channel, LengthUnit, ReadOptions, Scan, read_with, write};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};

use crate::convert::{from_python, map_of, to_python};
use crate::errors::{Raise, value_error, warn};
use crate::long;
use crate::random_surface::{Scan as PreparedScan, prepared};
use crate::resources::require_memory;

/// Heights, pitches and warnings of a file.
type FileContent<'py> = (Bound<'py, PyArray2<f64>>, (f64, f64), Vec<String>);

/// Reads a height map from a file.
#[pyfunction]
#[pyo3(signature = (path, channel, dx_m, dy_m, height_unit, decimal))]
pub(crate) fn read_map<'py>(
    py: Python<'py>,
    path: PathBuf,
    channel: Option<String>,
    dx_m: Option<f64>,
    dy_m: Option<f64>,
    height_unit: Option<String>,
    decimal: Option<String>,
) -> PyResult<FileContent<'py>> {
    let pitch_m = match (dx_m, dy_m) {
        (Some(dx_m), dy_m) => Some(checked_pitch_m((dx_m, dy_m.unwrap_or(dx_m))).raise()?),
        (None, Some(_)) => return Err(value_error("dy_m is given without dx_m")),
        (None, None) => None,
    };
    let height_unit = height_unit.map(|unit| unit.parse::<LengthUnit>().raise()).transpose()?;
    let decimal = decimal.map(|sign| sign.parse::<DecimalSign>().raise()).transpose()?.map(Into::into);
    let options = ReadOptions { channel: channel.as_deref().map(Channel::from), height_unit, decimal, pitch_m };
    let file = path.clone();
    let scan = long::run(py, None, move |_| read_with(&file, &options).raise())?;
    let missing = || value_error(format_args!("{}: the file carries no pixel size; state dx_m", path.display()));
    let (pitch_m, warnings) = (scan.pitch_m.ok_or_else(missing)?, scan.warnings.clone());
    let map = HeightMap::try_from(scan).raise()?;
    Ok((PyArray2::from_owned_array(py, map.into_heights_m()), pitch_m, warnings))
}

/// Returns the names of the height maps of a file.
#[pyfunction]
pub(crate) fn map_names(py: Python<'_>, path: PathBuf) -> PyResult<Vec<String>> {
    // Names do not depend on the unit; heights of files that state none would otherwise be refused.
    let options = ReadOptions { height_unit: "m".parse().ok(), ..ReadOptions::default() };
    Ok(long::run(py, None, move |_| read_with(&path, &options).raise())?.channels)
}

/// Writes a height map to a file, in the format of its extension.
#[pyfunction]
pub(crate) fn write_map(
    py: Python<'_>,
    path: PathBuf,
    heights_m: PyReadonlyArray2<'_, f64>,
    dx_m: f64,
    dy_m: f64,
) -> PyResult<()> {
    let scan = Scan::new(map_of(&heights_m, dx_m, dy_m)?.into_heights_m(), Some((dx_m, dy_m)));
    long::run(py, None, move |_| write(&scan, &path).raise())
}

/// Options of a filling.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fill {
    seed: u64,
    level: Level,
    covariance: ByName<FillCovariance>,
    marginal: ByName<FillMarginal>,
    nugget: f64,
}

/// Fills missing heights with random ones that continue the map, as `asperity surface fill` does.
#[pyfunction]
pub(crate) fn fill<'py>(
    heights_m: PyReadonlyArray2<'py, f64>,
    dx_m: f64,
    dy_m: f64,
    options: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let py = heights_m.py();
    let (map, own): (_, Fill) = (map_of(&heights_m, dx_m, dy_m)?, from_python(options)?);
    let (ByName(covariance), ByName(marginal)) = (own.covariance, own.marginal);
    let (level, nugget) = (own.level, own.nugget);
    let options = FillOptions { level, covariance, marginal, nugget, ..FillOptions::default() };
    require_memory(filling_memory_bytes(map.grid().points() as f64), "filling a map of this size")?;
    let (filled, warnings) = long::run(py, None, move |monitor| {
        let filling = Filling::new(&map, options, monitor).raise()?;
        let xi = random::standard_normal(&mut random::stream(own.seed, "fill", 0), filling.xi_len());
        let mut drawn = filling.draw([xi], monitor).raise()?;
        Ok((drawn.swap_remove(0).into_heights_m(), filling_warnings(&filling, nugget)))
    })?;
    warnings.iter().try_for_each(|message| warn(py, message))?;
    Ok(PyArray2::from_owned_array(py, filled))
}

/// Copies heights into a checked map: infinite heights count as missing.
#[pyfunction]
pub(crate) fn height_map<'py>(
    heights_m: PyReadonlyArray2<'py, f64>,
    dx_m: f64,
    dy_m: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let map = map_of(&heights_m, dx_m, dy_m)?;
    Ok(PyArray2::from_owned_array(heights_m.py(), map.into_heights_m()))
}

/// Steps of a preparation.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Steps {
    level: Level,
    outliers: Option<f64>,
    s_filter_m: Option<f64>,
    l_filter_m: Option<f64>,
    robust: bool,
}

/// Changes that a preparation made to a map.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct History {
    level: Level,
    outliers: usize,
    lost: usize,
    radius_m: Option<f64>,
}

impl History {
    /// Returns the prepared map.
    pub(crate) fn prepared(self, map: HeightMap) -> Prepared {
        let Self { level, outliers, lost, radius_m } = self;
        Prepared { map, outliers, lost, radius_m, level }
    }
}

/// Removes form, outliers and filtered waves. Returns the heights, and what was done to them.
#[pyfunction]
pub(crate) fn level<'py>(
    heights_m: PyReadonlyArray2<'py, f64>,
    dx_m: f64,
    dy_m: f64,
    steps: &Bound<'py, PyDict>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyAny>)> {
    let map = map_of(&heights_m, dx_m, dy_m)?;
    let Steps { level, outliers, s_filter_m, l_filter_m, robust } = from_python(steps)?;
    let preparation = Preparation { level, outliers, s_filter_m, l_filter_m, robust };
    let py = heights_m.py();
    let Prepared { map, outliers, lost, radius_m, level } =
        long::run_on_map(py, map, move |map| preparation.apply(map).raise())?;
    let history = History { level, outliers, lost, radius_m };
    Ok((PyArray2::from_owned_array(py, map.into_heights_m()), to_python(py, &history)?))
}

/// Computes the statistics of a map, with the keys of `asperity surface stats --json`.
#[pyfunction]
pub(crate) fn statistics<'py>(
    heights_m: PyReadonlyArray2<'py, f64>,
    dx_m: f64,
    dy_m: f64,
    history: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let map = map_of(&heights_m, dx_m, dy_m)?;
    let history: History = from_python(history)?;
    let found = long::run_on_map(heights_m.py(), map, |map| MapStatistics::new(&history.prepared(map)).raise())?;
    to_python(heights_m.py(), &surface_statistics(&found))
}

/// Computes the statistics of a part of several scans, with the keys of `asperity surface stats --json`.
#[pyfunction]
pub(crate) fn pooled_statistics<'py>(py: Python<'py>, scans: Vec<PreparedScan<'py>>) -> PyResult<Bound<'py, PyAny>> {
    let scans = scans.iter().map(prepared).collect::<PyResult<Vec<_>>>()?;
    let found = long::run(py, None, move |_| {
        let of_scan =
            |(place, scan): (usize, &Prepared)| Ok((format!("scan {}", place + 1), MapStatistics::new(scan).raise()?));
        let statistics = scans.iter().enumerate().map(of_scan).collect::<PyResult<Vec<_>>>()?;
        PooledStatistics::new(statistics).raise()
    })?;
    to_python(py, &part_statistics(&found))
}

/// Computes the autocorrelation along both axes.
#[pyfunction]
pub(crate) fn acf<'py>(heights_m: PyReadonlyArray2<'py, f64>, dx_m: f64, dy_m: f64) -> PyResult<Bound<'py, PyDict>> {
    let (py, map) = (heights_m.py(), map_of(&heights_m, dx_m, dy_m)?);
    let found = long::run_on_map(py, map, |map| Autocorrelation::estimate(&map).raise())?;
    let answer = PyDict::new(py);
    for (axis, pitch_m, name) in [(Axis::X, dx_m, "x"), (Axis::Y, dy_m, "y")] {
        let correlation = found.along(axis);
        let lag_m = (0..correlation.len()).map(|lag| lag as f64 * pitch_m).collect();
        answer.set_item(format!("lag_{name}_m"), PyArray1::from_vec(py, lag_m))?;
        answer.set_item(format!("acf_{name}"), PyArray1::from_vec(py, correlation))?;
        answer.set_item(format!("correlation_length_{name}_m"), found.correlation_length_m(axis))?;
    }
    answer.set_item("variance_m2", found.variance_m2())?;
    Ok(answer)
}

/// Computes the radially averaged power spectral density.
#[pyfunction]
pub(crate) fn psd<'py>(heights_m: PyReadonlyArray2<'py, f64>, dx_m: f64, dy_m: f64) -> PyResult<Bound<'py, PyDict>> {
    let (py, map) = (heights_m.py(), map_of(&heights_m, dx_m, dy_m)?);
    let (found, rings) = long::run_on_map(py, map, |map| radial_spectrum_with_bands(&map).raise())?;
    let answer = PyDict::new(py);
    let coefficients = rings.coefficients.iter().map(|count| *count as f64).collect();
    for (name, values) in [
        ("q_rad_per_m", rings.q_rad_per_m),
        ("psd_m4", rings.psd),
        ("psd_low_m4", rings.psd_low),
        ("psd_high_m4", rings.psd_high),
        ("degrees_of_freedom", rings.degrees_of_freedom),
        ("coefficients", coefficients),
    ] {
        answer.set_item(name, PyArray1::from_vec(py, values))?;
    }
    answer.set_item("psd_corners_m2", found.corners_m2)?;
    answer.set_item("method", found.route.name())?;
    answer.set_item("reliable_low_rad_per_m", found.reliable.low_rad_per_m)?;
    answer.set_item("reliable_high_rad_per_m", found.reliable.high_rad_per_m)?;
    answer.set_item("upper_limit", found.reliable.upper_limit.name())?;
    Ok(answer)
}
