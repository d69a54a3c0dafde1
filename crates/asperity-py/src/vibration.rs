//! Stick-slip of a mass on a belt.

use std::mem;

use asperity::choice::{ByName, Choice, SchemaGenerator};
use asperity::friction::process::{FrictionProcess, ProcessModel};
use asperity::study::{clipping_warning, implausible_damping, implausible_friction};
use asperity::vibration::{
    self, Drive, EnsembleSettings, MapAxis, MapOver, MapSettings, MotionKind, Parameters, VibrationError,
    clipped_to_positive, limit_damping, smallest_kick,
};
use asperity_results::tidy;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::{Deserialize, Serialize};

use crate::convert::{from_python, to_python, whole};
use crate::errors::{Raise, value_error, warn};
use crate::long;
use crate::pool::detached;
use crate::resources::require_memory;

/// Checked oscillator.
#[pyclass(frozen)]
pub(crate) struct Oscillator(vibration::Oscillator);

#[pymethods]
impl Oscillator {
    #[new]
    fn new(parameters: &Bound<'_, PyDict>) -> PyResult<Self> {
        vibration::Oscillator::new(from_python::<Parameters>(parameters)?).raise().map(Self)
    }

    /// Returns warnings of implausible parameters.
    fn warnings(&self) -> Vec<String> {
        let found = [implausible_friction(self.0.static_friction()), implausible_damping(self.0.damping_ratio())];
        found.into_iter().flatten().collect()
    }
}

/// Motion that develops from a start in stick. Numbers of the cycle are absent if there is none.
#[derive(Serialize, JsonSchema)]
struct LimitCycle {
    /// Kind of motion.
    kind: MotionKind,
    /// Whether the motion is periodic vibration.
    limit_cycle: bool,
    /// Whether steady sliding is unstable; `null` under a harmonic force.
    steady_sliding_unstable: Option<bool>,
    /// Smallest velocity that starts vibration from stable steady sliding; `null` if none is needed or none suffices.
    kick: Option<f64>,
    #[serde(flatten)]
    cycle: Option<vibration::LimitCycle>,
}

/// Damping ratios at which vibration ends.
#[derive(Serialize, JsonSchema)]
struct CriticalDamping {
    #[serde(flatten)]
    found: vibration::CriticalDamping,
    /// ζ_v, above which no vibration persists; `null` if the search failed.
    limit_damping_ratio: Option<f64>,
}

/// Statistics of many trajectories over a random friction fluctuation.
#[derive(Serialize, JsonSchema)]
struct Ensemble {
    #[serde(flatten)]
    found: vibration::Ensemble,
    /// Fraction of the friction values that were raised so that friction stays positive.
    clipped_fraction: f64,
}

/// Probability of sustained vibration over two parameters.
#[derive(Serialize, JsonSchema)]
struct StabilityMap {
    /// Names of the parameters x and y.
    axes: [&'static str; 2],
    #[serde(flatten)]
    found: vibration::StabilityMap,
    /// Largest fraction of friction values that were raised so that friction stays positive.
    clipped_fraction: f64,
}

/// All answers of this module.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its schema is used")]
struct Answers(LimitCycle, CriticalDamping, Ensemble, StabilityMap);

/// Returns the JSON Schema of the answers of this module, from which the dataclasses are generated.
#[pyfunction]
pub(crate) fn vibration_schema() -> String {
    let settings = SchemaSettings::draft2020_12().for_serialize().with_transform(tidy);
    settings.into_generator().into_root_schema_for::<Answers>().to_value().to_string()
}

/// Returns the JSON Schema of the parameters of an oscillator, from which the dataclasses of the velocity laws are generated.
#[pyfunction]
pub(crate) fn parameters_schema() -> String {
    SchemaGenerator::default().into_root_schema_for::<Parameters>().to_value().to_string()
}

/// Finds the vibration that develops from a start in stick, with the keys of `asperity vibration cycle --json`.
#[pyfunction]
pub(crate) fn limit_cycle<'py>(py: Python<'py>, oscillator: &Oscillator) -> PyResult<Bound<'py, PyAny>> {
    let own = oscillator.0.clone();
    let free = own.forcing().is_none();
    let find = move || -> Result<_, VibrationError> {
        let regime = vibration::limit_cycle(&own)?;
        let kick = if free { smallest_kick(&own)? } else { None };
        Ok((regime, free.then(|| own.sliding_is_unstable()), kick))
    };
    let (regime, steady_sliding_unstable, kick) = if free {
        detached(py, || find().raise())?
    } else {
        // An irregular motion takes many cycles.
        long::run(py, None, move |_| find().raise())?
    };
    let cycle = regime.cycle().copied();
    let limit_cycle = cycle.is_some();
    to_python(py, &LimitCycle { kind: regime.kind(), limit_cycle, steady_sliding_unstable, kick, cycle })
}

/// Finds the damping ratios at which vibration ends, with the keys of `asperity vibration critical-damping --json`.
#[pyfunction]
pub(crate) fn critical_damping<'py>(py: Python<'py>, oscillator: &Oscillator) -> PyResult<Bound<'py, PyAny>> {
    let own = oscillator.0.clone();
    let found = long::run(py, None, move |_| {
        let limit_damping_ratio = match limit_damping(&own) {
            Err(VibrationError::NotFound { .. }) => None,
            limit => Some(limit.raise()?),
        };
        Ok(CriticalDamping { found: vibration::critical_damping(&own).raise()?, limit_damping_ratio })
    })?;
    to_python(py, &found)
}

/// Fluctuation of the friction coefficient.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fluctuation {
    friction_std: f64,
    correlation_length: f64,
    marginal: String,
    allow_clipping: bool,
}

impl Fluctuation {
    fn model(&self) -> PyResult<ProcessModel> {
        let marginal = self.marginal.parse().map_err(value_error)?;
        Ok(ProcessModel::new(marginal, self.friction_std, self.correlation_length))
    }

    /// Warns if a fraction of the values is clipped. Fails if it is above the limit and not allowed.
    fn accept(&self, py: Python<'_>, fraction: f64) -> PyResult<()> {
        vibration::accept_clipping(fraction, self.allow_clipping).map_err(|error| {
            value_error(format_args!(
                "{error}; lower friction_std or the weakening of friction with velocity, or set allow_clipping=True"
            ))
        })?;
        clipping_warning(fraction).map_or(Ok(()), |warning| warn(py, &warning))
    }
}

/// Simulates many trajectories over a random friction fluctuation.
#[pyfunction]
#[pyo3(signature = (oscillator, fluctuation, trajectories, duration, seed, drive, progress))]
#[expect(clippy::too_many_arguments, reason = "the Python function has them as keywords")]
pub(crate) fn ensemble<'py>(
    py: Python<'py>,
    oscillator: &Oscillator,
    fluctuation: &Bound<'py, PyDict>,
    #[pyo3(from_py_with = whole)] trajectories: usize,
    duration: f64,
    #[pyo3(from_py_with = whole)] seed: u64,
    drive: &str,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (own, fluctuation): (_, Fluctuation) = (oscillator.0.clone(), from_python(fluctuation)?);
    let model = clipped_to_positive(&own, fluctuation.model()?, 1.0);
    let clipped_fraction = model.clipped_fraction();
    let process = FrictionProcess::new(model).raise()?;
    fluctuation.accept(py, clipped_fraction)?;
    let drive = Drive::from_name(drive).raise()?;
    let settings = EnsembleSettings { drive, ..EnsembleSettings::new(trajectories, duration, seed) };
    require_memory(settings.memory_bytes(rayon::current_num_threads()), "the ensemble")?;
    let mut found = long::run(py, progress.as_ref(), move |monitor| {
        vibration::Ensemble::simulate(&own, &process, &settings, monitor).raise()
    })?;
    let samples =
        [&mut found.reattachments, &mut found.releases, &mut found.periods].map(|of| mem::take(&mut of.sample));
    let answer = to_python(py, &Ensemble { found, clipped_fraction })?;
    for (name, sample) in ["reattachments", "releases", "periods"].into_iter().zip(samples) {
        answer.get_item(name)?.set_item("sample", PyArray1::from_vec(py, sample))?;
    }
    Ok(answer)
}

/// Axes and resolution of a stability map.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Axes {
    over: ByName<MapOver>,
    x: MapAxis,
    y: MapAxis,
    depth: u32,
}

/// Maps the probability of sustained vibration over two parameters.
#[pyfunction]
#[pyo3(signature = (oscillator, fluctuation, axes, trajectories, duration, seed, progress))]
#[expect(clippy::too_many_arguments, reason = "the Python function has them as keywords")]
pub(crate) fn stability_map<'py>(
    py: Python<'py>,
    oscillator: &Oscillator,
    fluctuation: &Bound<'py, PyDict>,
    axes: &Bound<'py, PyDict>,
    #[pyo3(from_py_with = whole)] trajectories: usize,
    duration: f64,
    #[pyo3(from_py_with = whole)] seed: u64,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (stated, fluctuation): (_, Fluctuation) = (oscillator.0.clone(), from_python(fluctuation)?);
    let Axes { over: ByName(over), x, y, depth } = from_python(axes)?;
    let [x, y] = [x, y].map(MapAxis::check);
    let (x, y) = (x.map_err(value_error)?, y.map_err(value_error)?);
    let settings = MapSettings { x, y, depth, ensemble: EnsembleSettings::new(trajectories, duration, seed) };
    let friction = fluctuation.model()?;
    // An invalid distribution is an error of the arguments and not of a point.
    FrictionProcess::new(friction.clone()).raise()?;
    let clipped_fraction = settings.clipped_fraction(over, &stated, &friction).raise()?;
    fluctuation.accept(py, clipped_fraction)?;
    let found = long::run(py, progress.as_ref(), move |monitor| {
        let machine = |x: f64, y: f64| {
            let (oscillator, model) = over.machine(&stated, &friction, [x, y])?;
            Ok((oscillator, model.map(FrictionProcess::new).transpose()?))
        };
        vibration::stability_map(&machine, &settings, monitor).raise()
    })?;
    to_python(py, &StabilityMap { axes: over.axes(), found, clipped_fraction })
}
