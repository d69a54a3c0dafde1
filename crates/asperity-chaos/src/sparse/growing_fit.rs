//! Least squares that adds one column at a time.

use ndarray::{Array2, ArrayView1};

use super::candidates::Candidates;
use asperity_base::numeric::{dot, triangular_condition};
use asperity_base::wide::{Kernel, wide};

/// Remaining fraction of its length below which a column counts as linearly dependent.
const DEPENDENT: f64 = 1e-7;

/// Relative residual that counts as rounding.
const EXACT: f64 = 16.0 * f64::EPSILON;

/// Least-squares fit of the terms entered so far.
///
/// A = QR by Gram–Schmidt with a second pass.
#[derive(Debug)]
pub(super) struct GrowingFit<'a, 'c> {
    candidates: &'a Candidates<'c>,
    terms: Vec<usize>,
    /// Orthonormal columns, concatenated.
    q: Vec<f64>,
    /// Upper triangle, column by column.
    r: Vec<f64>,
    /// Qᵀ times the response.
    projections: Vec<f64>,
    residual: Vec<f64>,
    /// Length of the response.
    length: f64,
}

impl<'a, 'c> GrowingFit<'a, 'c> {
    /// Creates the fit by the constant if there is one, and the empty fit otherwise.
    pub(super) fn new(candidates: &'a Candidates<'c>, response: &[f64]) -> Self {
        let mut fit = Self {
            candidates,
            terms: Vec::new(),
            q: Vec::new(),
            r: Vec::new(),
            projections: Vec::new(),
            residual: response.to_vec(),
            length: response.iter().map(|y| y * y).sum::<f64>().sqrt(),
        };
        if let Some(constant) = candidates.constant() {
            fit.enter(constant);
        }
        fit
    }

    pub(super) fn candidates(&self) -> &'a Candidates<'c> {
        self.candidates
    }

    pub(super) fn terms(&self) -> &[usize] {
        &self.terms
    }

    pub(super) fn residual(&self) -> &[f64] {
        &self.residual
    }

    /// Returns Qᵀ times the response.
    pub(super) fn projections(&self) -> &[f64] {
        &self.projections
    }

    /// Returns the last orthonormal column.
    pub(super) fn last_direction(&self) -> &[f64] {
        &self.q[self.q.len() - self.residual.len()..]
    }

    /// Returns column `term` of R, diagonal last.
    fn triangle_column(&self, term: usize) -> &[f64] {
        &self.r[term * (term + 1) / 2..][..=term]
    }

    /// Adds a term. Returns `false` without a change if the other terms span its column.
    pub(super) fn enter(&mut self, column: usize) -> bool {
        let (samples, count) = (self.residual.len(), self.terms.len());
        let mut direction = vec![0.0; samples];
        self.candidates.fill_column(column, &mut direction);
        let full = self.candidates.norm(column);
        let full = if full > 0.0 { full } else { length(&direction) };
        let mut fractions = vec![0.0; count];
        wide::<Orthogonalise, _>((&self.q[..], &mut direction[..], &mut fractions[..]));
        wide::<Orthogonalise, _>((&self.q[..], &mut direction[..], &mut fractions[..]));
        let left = length(&direction);
        if left.is_nan() || left <= DEPENDENT * full {
            return false;
        }
        let mut projection = 0.0;
        for (q, r) in direction.iter_mut().zip(&self.residual) {
            *q /= left;
            projection += *q * r;
        }
        self.residual.iter_mut().zip(&direction).for_each(|(r, q)| *r -= projection * q);
        self.projections.push(projection);
        self.q.extend_from_slice(&direction);
        self.terms.push(column);
        self.r.extend_from_slice(&fractions);
        self.r.push(left);
        true
    }

    /// Solves R x = b with the leading triangle of the size of b.
    fn solve_triangle(&self, b: &mut [f64]) {
        for i in (0..b.len()).rev() {
            let column = self.triangle_column(i);
            let x = b[i] / column[i];
            b[i] = x;
            b[..i].iter_mut().zip(column).for_each(|(b, r)| *b -= x * r);
        }
    }

    /// Returns whether the residual is at the level of rounding.
    pub(super) fn is_exact(&self) -> bool {
        length(&self.residual) <= EXACT * self.length
    }

    /// Returns residuals and leverages of the model of the leading terms.
    pub(super) fn residuals_and_leverages(&self, response: &[f64], terms: usize) -> (Vec<f64>, Vec<f64>) {
        let mut residuals = response.to_vec();
        let mut leverages = vec![0.0; response.len()];
        for (direction, projection) in self.q.chunks_exact(response.len()).zip(&self.projections).take(terms) {
            for ((r, h), q) in residuals.iter_mut().zip(&mut leverages).zip(direction) {
                *r -= projection * q;
                *h += q * q;
            }
        }
        (residuals, leverages)
    }

    /// Returns the errors at a row that was not fitted, for the models of 1, 2, … leading terms. The row of Q follows
    /// from R.
    pub(super) fn errors_at(&self, row: ArrayView1<'_, f64>, value: f64) -> Vec<f64> {
        let mut directions: Vec<f64> = Vec::with_capacity(self.terms.len());
        let mut error = value;
        let mut errors = Vec::with_capacity(self.terms.len());
        for (number, &term) in self.terms.iter().enumerate() {
            let column = self.triangle_column(number);
            let direction = (row[term] - dot(column, &directions)) / column[number];
            directions.push(direction);
            error -= self.projections[number] * direction;
            errors.push(error);
        }
        errors
    }

    /// Returns the coefficients of the model of the leading terms.
    pub(super) fn coefficients(&self, terms: usize) -> Vec<f64> {
        let mut solution = self.projections[..terms].to_vec();
        self.solve_triangle(&mut solution);
        solution
    }

    /// Returns the condition number of the columns of the leading terms; infinite if it cannot be computed.
    pub(super) fn condition(&self, terms: usize) -> f64 {
        let entry = |(i, j): (usize, usize)| if i <= j { self.triangle_column(j)[i] } else { 0.0 };
        triangular_condition(Array2::from_shape_fn((terms, terms), entry).view())
    }
}

fn length(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Number of partial sums of a product, which hide the latency of an addition.
const LANES: usize = 16;

/// Kernel that subtracts from a vector its projections on the columns and adds the coefficients to a list.
struct Orthogonalise;

impl<'a> Kernel<(&'a [f64], &'a mut [f64], &'a mut [f64])> for Orthogonalise {
    type Output = ();

    #[inline(always)]
    fn run((columns, vector, fractions): (&'a [f64], &'a mut [f64], &'a mut [f64])) {
        let n = vector.len();
        for (column, fraction) in columns.chunks_exact(n).zip(fractions) {
            let mut sums = [0.0; LANES];
            let ((q, q_rest), (v, v_rest)) = (column.as_chunks::<LANES>(), vector.as_chunks::<LANES>());
            for (q, v) in q.iter().zip(v) {
                for lane in 0..LANES {
                    sums[lane] += q[lane] * v[lane];
                }
            }
            let mut product: f64 = sums.iter().sum();
            for (q, v) in q_rest.iter().zip(v_rest) {
                product += q * v;
            }
            *fraction += product;
            for (v, q) in vector.iter_mut().zip(column) {
                *v -= product * q;
            }
        }
    }
}

/// Returns the mean and the length of the deviation from it.
pub(super) fn mean_and_spread(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().map(|y| (y - mean).powi(2)).sum::<f64>().sqrt())
}
