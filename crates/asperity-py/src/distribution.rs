//! Distributions of one variable.

use asperity::chaos::OrthonormalPolynomials;
use asperity::distribution::{self, standard_normal_quantile};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::errors::Raise;
use crate::pool::detached;

/// Distribution that a text states.
#[pyclass(frozen)]
pub(crate) struct Marginal(distribution::Marginal);

#[pymethods]
impl Marginal {
    #[new]
    fn new(text: &str) -> PyResult<Self> {
        Ok(Self(text.parse::<distribution::Marginal>().raise()?))
    }

    /// Returns the ends of the support.
    fn support(&self) -> (f64, f64) {
        (self.0.quantile(0.0), self.0.quantile(1.0))
    }

    /// Returns the values that are not exceeded with these probabilities or, with `upper`, that are exceeded.
    fn quantile<'py>(
        &self,
        py: Python<'py>,
        probability: PyReadonlyArray1<'_, f64>,
        upper: bool,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let sign = if upper { -1.0 } else { 1.0 };
        map(py, &probability, |p| self.0.translate(sign * standard_normal_quantile(p)))
    }

    /// Returns the probabilities not to exceed these values or, with `upper`, to exceed them.
    fn probability<'py>(
        &self,
        py: Python<'py>,
        values: PyReadonlyArray1<'_, f64>,
        upper: bool,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        map(py, &values, |x| if upper { self.0.survival(x) } else { self.0.cdf(x) })
    }
}

fn map<'py>(
    py: Python<'py>,
    values: &PyReadonlyArray1<'_, f64>,
    f: impl Fn(f64) -> f64 + Send,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let values = values.as_array().to_vec();
    let found = detached(py, || Ok(values.into_iter().map(f).collect()))?;
    Ok(PyArray1::from_vec(py, found))
}

/// Returns the standard normal values at which the polynomials of a bounded distribution need its translation.
#[pyfunction]
pub(crate) fn distribution_nodes(py: Python<'_>) -> Bound<'_, PyArray1<f64>> {
    PyArray1::from_vec(py, OrthonormalPolynomials::nodes())
}
