//! Designs of experiments and polynomial chaos expansions.

use asperity::chaos::{
    self, Basis, Candidates, Design, Factor, MultiIndexSet, OrthonormalPolynomials, PolynomialFamily, SamplingMethod,
    SparseError, SparseRegression,
};
use asperity::choice::Choice;
use asperity::stats::Interval;
use ndarray::Array2;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::convert::{owned, whole};
use crate::errors::{Raise, value_error};
use crate::long;
use crate::pool::detached;
use crate::resources::require_memory;

/// Name of the random stream of designs of Python programs.
const STAGE: &str = "python design";

/// Plans a design and returns its standard normal variables, shape (samples, variables).
#[pyfunction]
pub(crate) fn design<'py>(
    py: Python<'py>,
    method: &str,
    #[pyo3(from_py_with = whole)] seed: u64,
    #[pyo3(from_py_with = whole)] samples: usize,
    #[pyo3(from_py_with = whole)] variables: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let method = SamplingMethod::from_name(method).raise()?;
    // Points, and for designs that are searched their strata.
    require_memory(16.0 * samples as f64 * variables as f64, "the design")?;
    let xi = long::run(py, None, move |_| {
        let design = Design::new(method, seed, STAGE, samples, variables).raise()?;
        let mut xi = Array2::zeros((samples, variables));
        for (index, mut row) in xi.rows_mut().into_iter().enumerate() {
            design.fill_xi(index, row.as_slice_mut().unwrap_or_default());
        }
        Ok(xi)
    })?;
    Ok(PyArray2::from_owned_array(py, xi))
}

/// Translation of a bounded distribution at the nodes; `None` is a standard normal variable.
type Nodes = Option<Vec<f64>>;

/// Returns the basis of a set in the polynomials of each variable.
fn basis(set: MultiIndexSet, variables: &[Nodes]) -> PyResult<Basis> {
    let nodes = OrthonormalPolynomials::nodes().len();
    if let Some(found) = variables.iter().flatten().map(Vec::len).find(|&found| found != nodes) {
        return Err(value_error(format_args!("{found} values at {nodes} nodes")));
    }
    let degree = set.largest_power();
    let polynomials = |own: &Nodes| match own {
        Some(values) => OrthonormalPolynomials::of_bounded(values, degree),
        None => PolynomialFamily::Hermite.polynomials(degree),
    };
    Basis::with_polynomials(set, variables.iter().map(polynomials).collect()).raise()
}

/// Expansion in orthonormal polynomials of standard normal and of bounded variables.
#[pyclass(frozen)]
pub(crate) struct Expansion {
    expansion: chaos::Expansion,
    relative_error: Option<f64>,
}

/// Returns the number of terms of total degree `degree`, (variables + degree)! / (variables! degree!), or one above 1e18.
fn terms(variables: usize, degree: usize) -> f64 {
    let (fewer, more) = (variables.min(degree), variables.max(degree) as f64);
    let mut terms = 1.0;
    for i in 1..=fewer {
        if terms > 1e18 {
            break;
        }
        terms *= (more + i as f64) / i as f64;
    }
    terms
}

/// Returns the rows of samples with contiguous rows.
fn rows(xi: &Array2<f64>) -> Vec<&[f64]> {
    xi.rows().into_iter().map(|row| row.to_slice().unwrap_or_default()).collect()
}

#[pymethods]
impl Expansion {
    /// Creates an expansion from the powers of its terms, their coefficients, its leave-one-out error and its variables.
    #[new]
    fn new(
        powers: Vec<Vec<u16>>,
        coefficients: Vec<f64>,
        relative_error: Option<f64>,
        variables: Vec<Nodes>,
    ) -> PyResult<Self> {
        let factors = |row: Vec<u16>| -> Vec<Factor> {
            let factor = |(variable, degree)| (degree > 0).then_some(Factor { variable, degree });
            (0..).zip(row).filter_map(factor).collect()
        };
        let set = MultiIndexSet::from_factors(variables.len(), powers.into_iter().map(factors)).raise()?;
        if set.len() != coefficients.len() {
            return Err(value_error(format_args!("{} terms have {} coefficients", set.len(), coefficients.len())));
        }
        Ok(Self { expansion: chaos::Expansion::new(basis(set, &variables)?, coefficients), relative_error })
    }

    /// Fits an expansion of total degree `degree`; `sparse` keeps few terms, chosen by cross-validation. Returns also the
    /// 95 % intervals of the `statistics`, shape (statistics, 2), or none.
    #[staticmethod]
    fn fit<'py>(
        py: Python<'py>,
        xi: PyReadonlyArray2<'_, f64>,
        values: PyReadonlyArray1<'_, f64>,
        #[pyo3(from_py_with = whole)] degree: usize,
        sparse: bool,
        variables: Vec<Nodes>,
    ) -> PyResult<(Self, Option<Bound<'py, PyArray2<f64>>>)> {
        let (xi, values) = (owned(&xi), values.as_array().to_vec());
        if xi.nrows() != values.len() {
            return Err(value_error(format_args!("{} samples have {} values", xi.nrows(), values.len())));
        }
        if !xi.iter().chain(&values).all(|value| value.is_finite()) {
            return Err(value_error("a sample or a value is not finite"));
        }
        // Polynomials of all samples, their factors, and the coefficients without each sample.
        let terms = terms(xi.ncols(), degree);
        require_memory(24.0 * terms * xi.nrows() as f64 + 2.0 * terms * xi.ncols() as f64, "the regression")?;
        let (expansion, fit, intervals) = long::run(py, None, move |_| {
            let mut basis = basis(MultiIndexSet::total_degree(xi.ncols(), degree).raise()?, &variables)?;
            if sparse {
                let matrix = basis.design_matrix(&rows(&xi));
                let candidates = Candidates::new(matrix.view()).raise()?;
                let terms = match SparseRegression::default().select(&candidates, &values) {
                    Err(SparseError::ConstantResponse { .. }) => vec![0],
                    chosen => chosen.raise()?.terms,
                };
                basis = basis.select(&terms).raise()?;
            }
            chaos::Expansion::fit_with_intervals(basis, &rows(&xi), &values).raise()
        })?;
        let ends = |own: &[Interval]| Array2::from_shape_fn((own.len(), 2), |(i, end)| [own[i].low, own[i].high][end]);
        let intervals = intervals.map(|own| PyArray2::from_owned_array(py, ends(&own)));
        Ok((Self { expansion, relative_error: fit.leave_one_out.relative_error }, intervals))
    }

    /// Returns the values at samples.
    fn evaluate<'py>(&self, py: Python<'py>, xi: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (found, wanted) = (xi.as_array().ncols(), self.variables());
        if found != wanted {
            return Err(value_error(format_args!("samples have {found} variables, the expansion {wanted}")));
        }
        let xi = owned(&xi);
        let values = detached(py, || Ok(self.expansion.evaluate_many(&rows(&xi))))?;
        Ok(PyArray1::from_vec(py, values))
    }

    fn variables(&self) -> usize {
        self.expansion.basis().set().variables()
    }

    /// Returns the leave-one-out error over the variance.
    fn relative_error(&self) -> Option<f64> {
        self.relative_error
    }

    fn coefficients<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.expansion.coefficients())
    }

    /// Returns the powers of the variables in each term.
    fn powers(&self) -> Vec<Vec<u16>> {
        let set = self.expansion.basis().set();
        (0..set.len()).map(|term| set.at(term)).collect()
    }

    /// Returns mean, variance, first-order and total Sobol' indices of all variables, and the matrix of the second-order ones.
    fn statistics<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.expansion.statistics())
    }
}
