//! Oscillators, and answers about arrays of them.
//!
//! The parameters of an array cross the border as columns, the answers as an array of a row per number.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

use asperity::blocks;
use asperity::monitor::{Cancelled, Monitor};
use asperity::study::{implausible_damping, implausible_friction};
use asperity::vibration::{self, Parameters, VibrationError};
use ndarray::{Array2, Axis};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use serde_json::Value;

use crate::convert::{from_python, to_python};
use crate::errors::{Raise, value_error, warn};
use crate::long;
use crate::pool::detached;
use crate::resources::require_memory;

/// Memory in byte of a machine with its answer.
const MACHINE_BYTES: f64 = 300.0;
/// Machines whose answers a thread computes together.
const CHUNK: usize = 16;

/// Checked oscillator, or an array of oscillators.
#[pyclass(frozen)]
pub(crate) struct Oscillator {
    /// In C order.
    pub(crate) machines: Arc<Vec<vibration::Oscillator>>,
    /// Shape of the array; `None` for a single oscillator.
    pub(crate) shape: Option<Vec<usize>>,
}

#[pymethods]
impl Oscillator {
    /// Replaces numbers of the parameters by columns, which have a value of each machine.
    #[new]
    fn new(
        py: Python<'_>,
        parameters: &Bound<'_, PyDict>,
        columns: Vec<(String, PyReadonlyArray1<'_, f64>)>,
        shape: Option<Vec<usize>>,
    ) -> PyResult<Self> {
        let mut common: Parameters = from_python(parameters)?;
        let Some(shape) = shape else {
            return Ok(Self { machines: Arc::new(vec![vibration::Oscillator::new(common).raise()?]), shape });
        };
        let count = shape.iter().product();
        require_memory(MACHINE_BYTES * count as f64, "the machines")?;
        let mut values: Vec<(&str, &[f64])> = Vec::new();
        for (name, column) in &columns {
            if number(&mut common, name).is_none() {
                return Err(value_error(format_args!("{name} must not be an array")));
            }
            values.push((name, column.as_slice().map_err(value_error)?));
        }
        let machine = |index: usize| {
            let mut own = common.clone();
            for (name, column) in &values {
                if let Some(number) = number(&mut own, name) {
                    *number = column[index];
                }
            }
            vibration::Oscillator::new(own)
        };
        let checked: Vec<_> = detached(py, || Ok(blocks::map(0..count, machine)))?;
        let refused = |(index, checked): (usize, Result<_, _>)| {
            checked.map_err(|error| value_error(format_args!("machine {:?}: {error}", place(index, &shape))))
        };
        let machines = checked.into_iter().enumerate().map(refused).collect::<PyResult<Vec<_>>>()?;
        Ok(Self { machines: Arc::new(machines), shape: Some(shape) })
    }

    /// Returns warnings of implausible parameters, each kind once.
    fn warnings(&self) -> Vec<String> {
        let implausible: [fn(&vibration::Oscillator) -> Option<String>; 2] =
            [|own| implausible_friction(own.static_friction()), |own| implausible_damping(own.damping_ratio())];
        let found = implausible.into_iter().filter_map(|warning| {
            let mut all = self.machines.iter().filter_map(warning);
            let first = all.next()?;
            Some(match self.shape {
                None => first,
                Some(_) => format!("{first} ({} of {} machines)", 1 + all.count(), self.machines.len()),
            })
        });
        found.collect()
    }
}

impl Oscillator {
    /// Returns the oscillator of a function that takes no array.
    pub(crate) fn single(&self) -> PyResult<&vibration::Oscillator> {
        match (&self.shape, &self.machines[..]) {
            (None, [own]) => Ok(own),
            _ => Err(value_error("this function takes a single oscillator, without arrays")),
        }
    }

    /// Returns the answer about a single oscillator as a dictionary, or each number of all answers as an array.
    ///
    /// `brief` answers about a single oscillator need no thread of their own.
    pub(crate) fn answer<'py, A: Answer<N>, const N: usize>(
        &self,
        py: Python<'py>,
        brief: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let machines = Arc::clone(&self.machines);
        let Some(shape) = &self.shape else {
            let find = move || A::find(&machines[0]).raise();
            let found = if brief { detached(py, find) } else { long::run(py, None, move |_| find()) };
            return to_python(py, &found?);
        };
        let (numbers, failed) = long::run(py, None, move |monitor| answers::<A, N>(&machines, monitor).raise())?;
        if let Some((index, error)) = failed.first() {
            let (count, all, place) = (failed.len(), self.machines.len(), place(*index, shape));
            let message =
                format!("{count} of {all} machines have no answer and are NaN; the first is {place:?}: {error}");
            warn(py, &message)?;
        }
        let numbers = PyArray2::from_owned_array(py, numbers);
        let answer = PyDict::new(py);
        for (row, (name, _)) in A::numbers(None).into_iter().enumerate() {
            answer.set_item(name, numbers.get_item(row)?.call_method1("reshape", (shape,))?)?;
        }
        Ok(answer.into_any())
    }
}

/// Answer about an oscillator, of `N` numbers.
pub(crate) trait Answer<const N: usize>: Serialize + Send + 'static {
    fn find(oscillator: &vibration::Oscillator) -> Result<Self, VibrationError>
    where
        Self: Sized;

    /// Returns the numbers by the names of the attributes in Python, NaN where they are undefined; without an answer all are undefined.
    fn numbers(found: Option<&Self>) -> [(&'static str, f64); N];
}

/// Machines without an answer, by rising index.
type Failed = Vec<(usize, VibrationError)>;

/// Returns the numbers of the answers about all machines, a row each, and the machines without an answer.
fn answers<A: Answer<N>, const N: usize>(
    machines: &[vibration::Oscillator],
    monitor: &dyn Monitor,
) -> Result<(Array2<f64>, Failed), Cancelled> {
    let (mut numbers, failed) = (Array2::zeros((N, machines.len())), Mutex::new(Failed::new()));
    let chunks = machines.chunks(CHUNK).zip(numbers.axis_chunks_iter_mut(Axis(1), CHUNK)).enumerate();
    blocks::for_each(chunks, |(chunk, (machines, mut numbers))| {
        for (place, (machine, mut column)) in machines.iter().zip(numbers.columns_mut()).enumerate() {
            if monitor.cancelled() {
                return;
            }
            let found = A::find(machine);
            for (number, (_, value)) in column.iter_mut().zip(A::numbers(found.as_ref().ok())) {
                *number = value;
            }
            if let Err(error) = found {
                failed.lock().unwrap_or_else(PoisonError::into_inner).push((CHUNK * chunk + place, error));
            }
        }
    });
    if monitor.cancelled() {
        return Err(Cancelled);
    }
    let mut failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
    failed.sort_unstable_by_key(|(index, _)| *index);
    Ok((numbers, failed))
}

/// Returns a number of the parameters by the name that Python has for it.
fn number<'a>(parameters: &'a mut Parameters, name: &str) -> Option<&'a mut f64> {
    let Parameters { static_friction, law, damping_ratio, belt_velocity, forcing } = parameters;
    match (name, forcing) {
        ("static_friction", _) => Some(static_friction),
        ("damping_ratio", _) => Some(damping_ratio),
        ("belt_velocity", _) => Some(belt_velocity),
        ("amplitude", Some(force)) => Some(&mut force.amplitude),
        ("frequency", Some(force)) => Some(&mut force.frequency),
        _ => law.number_mut(name),
    }
}

/// Returns the answers about all machines as one structure of arrays: a number or a list of equal length of each machine becomes an array, what is
/// undefined NaN, and lists of different lengths `None`. `answers` holds JSON values, `None` for machines without an answer.
pub(crate) fn stacked<'py>(
    py: Python<'py>,
    answers: &[Option<&Value>],
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let defined = || answers.iter().copied().flatten().filter(|value| !value.is_null());
    let width = match defined().next() {
        Some(Value::Object(_)) => {
            let names: BTreeSet<&String> = defined().filter_map(Value::as_object).flat_map(|own| own.keys()).collect();
            let dictionary = PyDict::new(py);
            for name in names {
                let inner: Vec<_> = answers.iter().map(|own| own.and_then(|own| own.get(name))).collect();
                dictionary.set_item(name, stacked(py, &inner, shape)?)?;
            }
            return Ok(dictionary.into_any());
        }
        Some(Value::Array(first)) => Some(first.len()),
        Some(_) => None,
        None => return Ok(py.None().into_bound(py)),
    };
    let number = |value: &Value| value.as_f64().or_else(|| value.as_bool().map(|is| f64::from(u8::from(is))));
    let mut numbers = Vec::with_capacity(answers.len() * width.unwrap_or(1));
    for answer in answers {
        match (answer, width) {
            (Some(Value::Array(own)), Some(width)) if own.len() == width => {
                numbers.extend(own.iter().map(|value| number(value).unwrap_or(f64::NAN)));
            }
            (Some(Value::Array(_)), Some(_)) => return Ok(py.None().into_bound(py)),
            (_, Some(width)) => numbers.extend(std::iter::repeat_n(f64::NAN, width)),
            (own, None) => numbers.push(own.and_then(number).unwrap_or(f64::NAN)),
        }
    }
    let shape: Vec<usize> = shape.iter().copied().chain(width).collect();
    PyArray1::from_vec(py, numbers).call_method1("reshape", (shape,))
}

/// Returns the indices along all axes of an element of an array in C order.
pub(crate) fn place(index: usize, shape: &[usize]) -> Vec<usize> {
    let mut rest = index;
    let mut place: Vec<usize> = shape.iter().rev().map(|&size| (rest % size, rest /= size).0).collect();
    place.reverse();
    place
}
