//! Conversion between Python objects and types of the library.

use asperity::map::{Grid, HeightMap};
use ndarray::Array2;
use numpy::PyReadonlyArray2;
use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::errors::{Raise, value_error};
use crate::resources::require_memory;

/// Returns a result as dictionaries, lists, numbers and strings; undefined numbers are `None`, as in JSON.
pub(crate) fn to_python<'py>(py: Python<'py>, result: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    from_value(py, &serde_json::to_value(result).map_err(value_error)?)
}

/// Returns a JSON text as dictionaries, lists, numbers and strings.
pub(crate) fn from_json<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    from_value(py, &serde_json::from_str(text).raise()?)
}

fn from_value<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Null => py.None().into_bound(py),
        Value::Bool(value) => PyBool::new(py, *value).to_owned().into_any(),
        Value::Number(number) => match (number.as_u64(), number.as_i64()) {
            (Some(whole), _) => PyInt::new(py, whole).into_any(),
            (_, Some(whole)) => PyInt::new(py, whole).into_any(),
            _ => PyFloat::new(py, number.as_f64().unwrap_or(f64::NAN)).into_any(),
        },
        Value::String(text) => PyString::new(py, text).into_any(),
        Value::Array(values) => {
            let values = values.iter().map(|value| from_value(py, value)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, values)?.into_any()
        }
        Value::Object(entries) => {
            let object = PyDict::new(py);
            for (key, value) in entries {
                object.set_item(key, from_value(py, value)?)?;
            }
            object.into_any()
        }
    })
}

/// Reads settings from dictionaries, lists, numbers and strings.
pub(crate) fn from_python<T: DeserializeOwned>(object: &Bound<'_, PyAny>) -> PyResult<T> {
    serde_json::from_value(to_value(object)?).map_err(value_error)
}

/// Returns a Python object as JSON. Keys whose value is `None` are left out.
pub(crate) fn to_value(object: &Bound<'_, PyAny>) -> PyResult<Value> {
    if object.is_none() {
        return Ok(Value::Null);
    }
    if let Ok(value) = object.cast::<PyBool>() {
        return Ok(value.is_true().into());
    }
    if let Ok(text) = object.extract::<String>() {
        return Ok(text.into());
    }
    if let Ok(entries) = object.cast::<PyDict>() {
        let entries = entries.iter().filter(|(_, value)| !value.is_none());
        let entry = |(key, value): (Bound<'_, _>, Bound<'_, _>)| Ok((key.extract()?, to_value(&value)?));
        return Ok(Value::Object(entries.map(entry).collect::<PyResult<Map<_, _>>>()?));
    }
    if object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>() {
        return object.try_iter()?.map(|value| to_value(&value?)).collect::<PyResult<_>>().map(Value::Array);
    }
    // Whole numbers first: every one of them is also a number.
    if let Ok(whole) = object.extract::<u64>() {
        return Ok(whole.into());
    }
    if let Ok(whole) = object.extract::<i64>() {
        return Ok(whole.into());
    }
    if let Ok(number) = object.extract::<f64>() {
        let finite = serde_json::Number::from_f64(number);
        return finite.map(Value::Number).ok_or_else(|| value_error(format_args!("{number} is not a finite number")));
    }
    let kind = object.get_type().qualname()?;
    Err(PyTypeError::new_err(format!("found {kind}, expected a number, a string, a list or a dictionary")))
}

/// Reads a number of things, or a seed.
pub(crate) fn whole<T: TryFrom<u64>>(object: &Bound<'_, PyAny>) -> PyResult<T> {
    let out_of_range = || value_error(format_args!("found {object}, expected a whole number from 0 on"));
    let number = object
        .extract::<u64>()
        .map_err(|error| if error.is_instance_of::<PyOverflowError>(object.py()) { out_of_range() } else { error })?;
    T::try_from(number).map_err(|_| out_of_range())
}

/// Copies an array, once, with contiguous rows.
pub(crate) fn owned(array: &PyReadonlyArray2<'_, f64>) -> Array2<f64> {
    array.as_array().as_standard_layout().into_owned()
}

/// Copies heights in metre into a map.
pub(crate) fn map_of(heights_m: &PyReadonlyArray2<'_, f64>, dx_m: f64, dy_m: f64) -> PyResult<HeightMap> {
    require_memory(16.0 * heights_m.as_array().len() as f64, "the map")?;
    let heights_m = owned(heights_m);
    let (ny, nx) = heights_m.dim();
    HeightMap::measured(Grid::new(nx, ny, dx_m, dy_m).raise()?, heights_m).raise()
}
