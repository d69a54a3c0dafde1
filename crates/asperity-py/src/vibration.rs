//! Stick-slip of a mass on a belt.

use std::mem;
use std::sync::Arc;

use asperity::blocks::Task;
use asperity::choice::{ByName, Choice, SchemaGenerator};
use asperity::distribution::Marginal;
use asperity::friction::process::{FittedProcess, FrictionProcess, ProcessModel, Steady};
use asperity::monitor::{Cancelled, Inner};
use asperity::study::clipping_warning;
use asperity::vibration::{
    self, Drive, EnsembleSettings, Event, MapAxis, MapOver, MapSettings, MotionKind, Parameters, PhasePoint,
    SampledTrajectory, VelocityLaw, VibrationError, clipped_to_positive, limit_damping, smallest_kick,
};
use asperity_results::tidy;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::convert::{from_python, to_python, whole};
use crate::errors::{Raise, value_error, warn};
use crate::long;
use crate::machines::{Answer, Oscillator, place, stacked};
use crate::process::process_of;
use crate::resources::require_memory;

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

impl Answer<12> for LimitCycle {
    fn find(oscillator: &vibration::Oscillator) -> Result<Self, VibrationError> {
        let free = oscillator.forcing().is_none();
        let regime = vibration::limit_cycle(oscillator)?;
        Ok(Self {
            kind: regime.kind(),
            limit_cycle: regime.cycle().is_some(),
            steady_sliding_unstable: free.then(|| oscillator.sliding_is_unstable()),
            kick: if free { smallest_kick(oscillator)? } else { None },
            cycle: regime.cycle().copied(),
        })
    }

    /// The kind of motion is its place among all, from 1 on, and 0 without an answer.
    fn numbers(found: Option<&Self>) -> [(&'static str, f64); 12] {
        let unstable = found.and_then(|found| found.steady_sliding_unstable);
        let cycle = found.and_then(|found| found.cycle);
        let of = |number: fn(vibration::LimitCycle) -> Option<f64>| cycle.and_then(number).unwrap_or(f64::NAN);
        [
            ("kind", found.map_or(0.0, |found| 1.0 + f64::from(found.kind as u8))),
            ("limit_cycle", f64::from(u8::from(cycle.is_some()))),
            ("steady_sliding_unstable", unstable.map_or(f64::NAN, |unstable| f64::from(u8::from(unstable)))),
            ("kick", found.and_then(|found| found.kick).unwrap_or(f64::NAN)),
            ("period", of(|cycle| Some(cycle.period))),
            ("slip_duration", of(|cycle| Some(cycle.slip_duration))),
            ("reattachment_displacement", of(|cycle| cycle.reattachment_displacement)),
            ("displacement_min", of(|cycle| Some(cycle.displacement_min))),
            ("displacement_max", of(|cycle| Some(cycle.displacement_max))),
            ("velocity_min", of(|cycle| Some(cycle.velocity_min))),
            ("velocity_max", of(|cycle| Some(cycle.velocity_max))),
            ("slips", of(|cycle| Some(cycle.slips as f64))),
        ]
    }
}

/// Damping ratios at which vibration ends.
#[derive(Serialize, JsonSchema)]
struct CriticalDamping {
    #[serde(flatten)]
    found: vibration::CriticalDamping,
    /// ζ_v, above which no vibration persists; `null` if the search failed.
    limit_damping_ratio: Option<f64>,
}

impl Answer<3> for CriticalDamping {
    fn find(oscillator: &vibration::Oscillator) -> Result<Self, VibrationError> {
        let limit_damping_ratio = match limit_damping(oscillator) {
            Err(VibrationError::NotFound { .. }) => None,
            limit => Some(limit?),
        };
        Ok(Self { found: vibration::critical_damping(oscillator)?, limit_damping_ratio })
    }

    fn numbers(found: Option<&Self>) -> [(&'static str, f64); 3] {
        let limit = found.and_then(|found| found.limit_damping_ratio);
        let [critical, hopf] =
            found.map_or([f64::NAN; 2], |Self { found, .. }| [found.critical_damping_ratio, found.hopf_damping_ratio]);
        [
            ("critical_damping_ratio", critical),
            ("hopf_damping_ratio", hopf),
            ("limit_damping_ratio", limit.unwrap_or(f64::NAN)),
        ]
    }
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

/// Returns a velocity law in a unit of velocity that is larger by a factor.
#[pyfunction]
pub(crate) fn rescaled_law<'py>(py: Python<'py>, law: &Bound<'py, PyDict>, factor: f64) -> PyResult<Bound<'py, PyAny>> {
    to_python(py, &from_python::<VelocityLaw>(law)?.rescaled(factor))
}

/// Finds the vibration that develops from a start in stick, with the keys of `asperity vibration cycle --json`.
#[pyfunction]
pub(crate) fn limit_cycle<'py>(py: Python<'py>, oscillator: &Oscillator) -> PyResult<Bound<'py, PyAny>> {
    // An irregular motion under a force takes many cycles.
    let brief = oscillator.single().is_ok_and(|own| own.forcing().is_none());
    oscillator.answer::<LimitCycle, _>(py, brief)
}

/// Finds the damping ratios at which vibration ends, with the keys of `asperity vibration critical-damping --json`.
#[pyfunction]
pub(crate) fn critical_damping<'py>(py: Python<'py>, oscillator: &Oscillator) -> PyResult<Bound<'py, PyAny>> {
    oscillator.answer::<CriticalDamping, _>(py, false)
}

/// Fluctuation of the friction coefficient.
enum Fluctuation {
    /// A process in SI.
    Process(Box<FittedProcess>),
    /// Distribution of a fluctuation whose moments are stated.
    Stated(Marginal),
}

impl Fluctuation {
    /// Reads the dictionary of a process, or the text of a distribution.
    fn new(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        match given.extract::<String>() {
            Ok(text) => text.parse().map(Self::Stated).map_err(value_error),
            Err(_) => process_of(given).map(|process| Self::Process(Box::new(process))),
        }
    }

    /// Returns the model with a standard deviation and a correlation length; that of a process in the unit `length` in metre.
    fn model(&self, std: f64, length: f64) -> PyResult<ProcessModel> {
        match self {
            Self::Process(process) => process.model(length).raise(),
            Self::Stated(marginal) => Ok(ProcessModel::new(marginal.clone(), std, length)),
        }
    }
}

/// Warns if a fraction of the values is clipped. Fails if it is above the limit and not allowed.
fn accept_clipping(py: Python<'_>, fraction: f64, allowed: bool) -> PyResult<()> {
    vibration::accept_clipping(fraction, allowed).map_err(|error| {
        value_error(format_args!(
            "{error}; lower the scatter or the weakening of friction with velocity, or set allow_clipping=True"
        ))
    })?;
    clipping_warning(fraction).map_or(Ok(()), |warning| warn(py, &warning))
}

/// Returns the process of a machine's fluctuation, clipped so that friction stays positive, and the clipped fraction.
fn clipped_process(
    py: Python<'_>,
    oscillator: &vibration::Oscillator,
    model: ProcessModel,
    allow_clipping: bool,
) -> PyResult<(FrictionProcess, f64)> {
    let model = clipped_to_positive(oscillator, model, 1.0);
    let fraction = model.clipped_fraction();
    let process = FrictionProcess::new(model).raise()?;
    accept_clipping(py, fraction, allow_clipping)?;
    Ok((process, fraction))
}

/// Simulates a trajectory at rising times, from the state (X, X′) `start`.
#[pyfunction]
#[pyo3(signature = (oscillator, tau, start, fluctuation, std, length, allow_clipping, seed, index, drive))]
#[expect(clippy::too_many_arguments, reason = "the Python function has them as keywords")]
pub(crate) fn trajectory<'py>(
    py: Python<'py>,
    oscillator: &Oscillator,
    tau: PyReadonlyArray1<'py, f64>,
    start: Option<[f64; 2]>,
    fluctuation: Option<Bound<'py, PyAny>>,
    std: f64,
    length: f64,
    allow_clipping: bool,
    #[pyo3(from_py_with = whole)] seed: u64,
    #[pyo3(from_py_with = whole)] index: u64,
    drive: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let (own, times, drive) = (oscillator.single()?.clone(), tau.as_array().to_vec(), Drive::from_name(drive).raise()?);
    let model = fluctuation.map(|given| Fluctuation::new(&given)?.model(std, length)).transpose()?;
    let process = model.map(|model| clipped_process(py, &own, model, allow_clipping)).transpose()?;
    let SampledTrajectory { points, events } = long::run(py, None, move |monitor| {
        let simulated = match process {
            Some((process, _)) => {
                SampledTrajectory::simulate(&own, process.path(seed, index), drive, start, &times, monitor)
            }
            None => SampledTrajectory::simulate(&own, Steady, drive, start, &times, monitor),
        };
        simulated.raise()
    })?;
    let answer = PyDict::new(py);
    let of_points = |value: fn(&PhasePoint) -> f64| PyArray1::from_iter(py, points.iter().map(value));
    answer.set_item("tau", of_points(|point| point.tau))?;
    answer.set_item("displacement", of_points(|point| point.displacement))?;
    answer.set_item("velocity", of_points(|point| point.velocity))?;
    let of_events = |value: fn(&Event) -> f64| PyArray1::from_iter(py, events.iter().map(value));
    answer.set_item("event_tau", of_events(|event| event.tau))?;
    answer.set_item("event_displacement", of_events(|event| event.displacement))?;
    answer.set_item("event_sliding_distance", of_events(|event| event.sliding_distance))?;
    answer.set_item("events", events.iter().map(|event| event.kind.code()).collect::<Vec<_>>())?;
    Ok(answer)
}

/// Simulates many trajectories over a random friction fluctuation.
#[pyfunction]
#[pyo3(signature = (oscillator, fluctuation, std, length, allow_clipping, trajectories, duration, seed, drive, progress))]
#[expect(clippy::too_many_arguments, reason = "the Python function has them as keywords")]
pub(crate) fn ensemble<'py>(
    py: Python<'py>,
    oscillator: &Oscillator,
    fluctuation: &Bound<'py, PyAny>,
    std: f64,
    length: f64,
    allow_clipping: bool,
    #[pyo3(from_py_with = whole)] trajectories: usize,
    duration: f64,
    #[pyo3(from_py_with = whole)] seed: u64,
    drive: &str,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let own = oscillator.single()?.clone();
    let model = Fluctuation::new(fluctuation)?.model(std, length)?;
    let (process, clipped_fraction) = clipped_process(py, &own, model, allow_clipping)?;
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

/// Simulates an ensemble of each machine of an array, with its own fluctuation, of which `stds` and `lengths` are columns; see [`Fluctuation::model`]. All have the
/// same seed.
#[pyfunction]
#[pyo3(signature = (oscillator, fluctuation, stds, lengths, allow_clipping, trajectories, duration, seed, drive, progress))]
#[expect(clippy::too_many_arguments, reason = "the Python function has them as keywords")]
pub(crate) fn ensembles<'py>(
    py: Python<'py>,
    oscillator: &Oscillator,
    fluctuation: &Bound<'py, PyAny>,
    stds: Vec<f64>,
    lengths: Vec<f64>,
    allow_clipping: bool,
    #[pyo3(from_py_with = whole)] trajectories: usize,
    duration: f64,
    #[pyo3(from_py_with = whole)] seed: u64,
    drive: &str,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (machines, shape) = (Arc::clone(&oscillator.machines), oscillator.shape.clone().unwrap_or_default());
    let fluctuation = Fluctuation::new(fluctuation)?;
    let drive = Drive::from_name(drive).raise()?;
    let settings = EnsembleSettings { drive, ..EnsembleSettings::new(trajectories, duration, seed) };
    require_memory(settings.memory_bytes(rayon::current_num_threads()), "the ensembles")?;
    let of_machine = |(machine, (std, length)): (&vibration::Oscillator, (f64, f64))| {
        Ok::<_, PyErr>(clipped_to_positive(machine, fluctuation.model(std, length)?, 1.0))
    };
    let models: Vec<ProcessModel> =
        machines.iter().zip(stds.into_iter().zip(lengths)).map(of_machine).collect::<PyResult<_>>()?;
    let clipped: Vec<f64> = models.iter().map(ProcessModel::clipped_fraction).collect();
    accept_clipping(py, clipped.iter().copied().fold(0.0, f64::max), allow_clipping)?;
    let found = long::run(py, progress.as_ref(), move |monitor| {
        let task = Task::new(monitor, "ensembles", machines.len());
        let simulate = |index: usize| {
            let process = FrictionProcess::new(models[index].clone()).map_err(|error| error.to_string())?;
            let found = vibration::Ensemble::simulate(&machines[index], &process, &settings, &Inner(monitor));
            let mut found = found.map_err(|error| error.to_string())?;
            for of in [&mut found.reattachments, &mut found.releases, &mut found.periods] {
                of.sample.clear();
            }
            serde_json::to_string(&Ensemble { found, clipped_fraction: clipped[index] })
                .map_err(|error| error.to_string())
        };
        task.map(machines.len(), |index| Ok::<_, Cancelled>(simulate(index))).raise()
    })?;
    let mut failed = Vec::new();
    let mut of_machine = |(index, found): (usize, Result<String, String>)| match found {
        Ok(text) => serde_json::from_str::<Value>(&text).ok(),
        Err(reason) => {
            failed.push((place(index, &shape), reason));
            None
        }
    };
    let mut answers: Vec<Option<Value>> = found.into_iter().enumerate().map(&mut of_machine).collect();
    if let [(first, reason), ..] = &failed[..] {
        let (count, all) = (failed.len(), answers.len());
        warn(py, &format!("{count} of {all} ensembles have no answer and are NaN; the first is {first:?}: {reason}"))?;
    }
    let failures = PyList::empty(py);
    for (index, own) in answers.iter_mut().enumerate() {
        let own = own.as_mut().and_then(|own| own.get_mut("failures")).map_or(Value::Null, Value::take);
        for failure in own.as_array().into_iter().flatten() {
            let failure = to_python(py, failure)?;
            failure.set_item("machine", place(index, &shape))?;
            failures.append(failure)?;
        }
    }
    let answer = stacked(py, &answers.iter().map(Option::as_ref).collect::<Vec<_>>(), &shape)?;
    answer.set_item("failures", failures)?;
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
#[pyo3(signature = (oscillator, fluctuation, std, length, allow_clipping, axes, trajectories, duration, seed, progress))]
#[expect(clippy::too_many_arguments, reason = "the Python function has them as keywords")]
pub(crate) fn stability_map<'py>(
    py: Python<'py>,
    oscillator: &Oscillator,
    fluctuation: &Bound<'py, PyAny>,
    std: f64,
    length: f64,
    allow_clipping: bool,
    axes: &Bound<'py, PyDict>,
    #[pyo3(from_py_with = whole)] trajectories: usize,
    duration: f64,
    #[pyo3(from_py_with = whole)] seed: u64,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let stated = oscillator.single()?.clone();
    let friction = Fluctuation::new(fluctuation)?.model(std, length)?;
    let Axes { over: ByName(over), x, y, depth } = from_python(axes)?;
    let [x, y] = [x, y].map(MapAxis::check);
    let (x, y) = (x.map_err(value_error)?, y.map_err(value_error)?);
    let settings = MapSettings { x, y, depth, ensemble: EnsembleSettings::new(trajectories, duration, seed) };
    // An invalid distribution is an error of the arguments and not of a point.
    FrictionProcess::new(friction.clone()).raise()?;
    let clipped_fraction = settings.clipped_fraction(over, &stated, &friction).raise()?;
    accept_clipping(py, clipped_fraction, allow_clipping)?;
    let found = long::run(py, progress.as_ref(), move |monitor| {
        let machine = |x: f64, y: f64| {
            let (oscillator, model) = over.machine(&stated, &friction, [x, y])?;
            Ok((oscillator, model.map(FrictionProcess::new).transpose()?))
        };
        vibration::stability_map(&machine, &settings, monitor).raise()
    })?;
    to_python(py, &StabilityMap { axes: over.axes(), found, clipped_fraction })
}
