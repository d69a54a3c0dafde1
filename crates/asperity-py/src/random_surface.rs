//! Random surfaces: stated, or like measured ones.

use std::sync::Arc;

use asperity::choice::{ByName, Choice};
use asperity::correlation::{CorrelationFamily, CorrelationModel};
use asperity::map::{BoundaryKind, Grid};
use asperity::study::{covariance_result, draw_map};
use asperity::surface::model::{
    self, CovarianceRequest, Measurable, SelectedCovariance, SurfaceRequest, TruncatedExpansion,
};
use asperity::surface::preparation::Prepared;
use asperity::surface::scanned::ScannedSurface;
use asperity::surface::{self, SurfaceGenerator};
use asperity::translation::TranslationKind;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use serde::Deserialize;

use crate::convert::{from_python, map_of, to_python, whole};
use crate::errors::{Raise, value_error, warn};
use crate::long;
use crate::pool::detached;
use crate::resources::require_memory;
use crate::surface::History;

/// Largest standard normal variable of a map.
const LARGEST_XI: f64 = 1e6;

/// Settings of a random surface. What is left out is measured on the scans.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    generator: ByName<SurfaceGenerator>,
    covariance: Option<StatedCovariance>,
    rms_height_m: Option<f64>,
    marginal: Option<String>,
    translation: Option<ByName<TranslationKind>>,
    modes: Option<usize>,
    fractal_dimension: Option<f64>,
}

/// Covariance that is stated.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StatedCovariance {
    model: CorrelationModel,
    lengths_m: [f64; 2],
}

fn measurable<T>(stated: Option<T>) -> Measurable<T> {
    stated.map_or(Measurable::Measured, Measurable::Stated)
}

impl Settings {
    fn request(self) -> PyResult<SurfaceRequest> {
        let rms_height_m = measurable(self.rms_height_m);
        let ByName(generator) = self.generator;
        if generator == SurfaceGenerator::WeierstrassMandelbrot {
            let dimension = measurable(self.fractal_dimension);
            return Ok(SurfaceRequest::WeierstrassMandelbrot { rms_height_m, dimension });
        }
        let marginal = self.marginal.map(|text| text.parse().map_err(value_error)).transpose()?;
        let expansion = TruncatedExpansion { modes: self.modes, mean_mode: true, rescale: None };
        Ok(SurfaceRequest::Translated {
            rms_height_m,
            covariance: self.covariance.map_or(CovarianceRequest::Measured, |StatedCovariance { model, lengths_m }| {
                CovarianceRequest::Stated { model, lengths_m }
            }),
            families: CorrelationFamily::ALL.to_vec(),
            marginal: measurable(marginal),
            shortest_wave_m: None,
            translation: self.translation.map_or_else(TranslationKind::default, |ByName(kind)| kind),
            expansion: (generator == SurfaceGenerator::KarhunenLoeve).then_some(expansion),
        })
    }
}

/// Returns a scan with what was done to it.
pub(crate) fn prepared((heights_m, dx_m, dy_m, history): &Scan<'_>) -> PyResult<Prepared> {
    Ok(from_python::<History>(history)?.prepared(map_of(heights_m, *dx_m, *dy_m)?))
}

/// Model of a random surface, independent of any grid.
#[pyclass(frozen)]
pub(crate) struct SurfaceModel {
    model: model::SurfaceModel,
    selected: Option<SelectedCovariance>,
}

/// Heights, pitches and history of a scan.
pub(crate) type Scan<'py> = (PyReadonlyArray2<'py, f64>, f64, f64, Bound<'py, PyDict>);

#[pymethods]
impl SurfaceModel {
    #[new]
    fn new(py: Python<'_>, settings: &Bound<'_, PyDict>, scans: Vec<Scan<'_>>) -> PyResult<Self> {
        let request = from_python::<Settings>(settings)?.request()?;
        let scans = scans.iter().map(prepared).collect::<PyResult<Vec<_>>>()?;
        let (model, selected) = long::run(py, None, move |_| {
            let several = scans.len() > 1;
            let scans = scans.into_iter().map(ScannedSurface::new).collect::<Result<Vec<_>, _>>().raise()?;
            let scan = if several {
                let named = scans.into_iter().enumerate().map(|(place, scan)| (format!("scan {}", place + 1), scan));
                Some(ScannedSurface::from_scans(named.collect()).raise()?)
            } else {
                scans.into_iter().next()
            };
            model::SurfaceModel::new(request, scan.as_ref()).raise()
        })?;
        Ok(Self { model, selected })
    }

    /// Returns the covariance; `None` for a Weierstrass–Mandelbrot surface.
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.selected.as_ref().map(|selected| to_python(py, &covariance_result(selected))).transpose()
    }

    /// Returns the standard deviation of the heights.
    fn rms_height_m(&self) -> f64 {
        self.model.marginal.std()
    }

    /// Makes the generator of maps on a grid of `nx` × `ny` points.
    fn on_grid(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = whole)] nx: usize,
        #[pyo3(from_py_with = whole)] ny: usize,
        size_x_m: f64,
        size_y_m: f64,
        boundary: &str,
    ) -> PyResult<RandomSurface> {
        let grid = Grid::with_size(nx, ny, size_x_m, size_y_m).raise()?;
        let periodic = BoundaryKind::from_name(boundary).raise()? == BoundaryKind::Periodic;
        // A free patch is cut from one with twice as many points along each side, which has a spectrum.
        require_memory(64.0 * grid.points() as f64, "the random surface")?;
        let model = self.model.clone();
        let generated = long::run(py, None, move |_| model.patch(grid, periodic).raise())?;
        generated.warnings.iter().try_for_each(|warning| warn(py, warning))?;
        Ok(RandomSurface(generated.surface.into()))
    }
}

/// Generator of random maps on a grid.
#[pyclass(frozen)]
pub(crate) struct RandomSurface(Arc<dyn surface::RandomSurface>);

#[pymethods]
impl RandomSurface {
    /// Returns the number of standard normal variables of a map.
    fn xi_len(&self) -> usize {
        self.0.xi_len()
    }

    /// Returns the distances between points.
    fn pitch_m(&self) -> (f64, f64) {
        (self.0.grid().dx_m(), self.0.grid().dy_m())
    }

    /// Returns the map of standard normal variables.
    fn generate<'py>(&self, py: Python<'py>, xi: Vec<f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let wanted = self.0.xi_len();
        if xi.len() != wanted || !xi.iter().all(|xi| xi.abs() <= LARGEST_XI) {
            return Err(value_error(format_args!(
                "xi has {} values, expected {wanted} numbers from -{LARGEST_XI} to {LARGEST_XI}",
                xi.len()
            )));
        }
        let map = detached(py, || Ok(self.0.generate(&xi)))?;
        Ok(PyArray2::from_owned_array(py, map.into_heights_m()))
    }

    /// Draws maps, the same for any number of threads.
    fn sample<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = whole)] seed: u64,
        #[pyo3(from_py_with = whole)] count: usize,
    ) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        require_memory(8.0 * count as f64 * self.0.grid().points() as f64, "the maps")?;
        let surface = Arc::clone(&self.0);
        let maps = long::run(py, None, move |monitor| {
            let draw = |index: usize| (!monitor.cancelled()).then(|| draw_map(surface.as_ref(), seed, index as u64));
            (0..count).into_par_iter().map(draw).collect::<Option<Vec<_>>>().ok_or_else(|| value_error("cancelled"))
        })?;
        Ok(maps.into_iter().map(|map| PyArray2::from_owned_array(py, map.into_heights_m())).collect())
    }
}
