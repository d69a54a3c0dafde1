//! Products of Householder reflections.

use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayView2, ArrayViewMut2};

use super::solve_upper;

/// Turns a vector into the unit normal v of the reflection I − 2vvᵀ that maps it to a multiple of the first axis, and
/// returns the multiple.
pub(super) fn reflector(vector: &mut [f64]) -> f64 {
    let largest = vector.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let Some(first) = vector.first_mut() else { return 0.0 };
    if largest == 0.0 {
        *first = 1.0;
        return 0.0;
    }
    vector.iter_mut().for_each(|x| *x /= largest);
    let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    let image = -length.copysign(vector[0]);
    let first = vector[0] - image;
    // |v|² = |x|² − 2 x₀ image + image² = 2 image (image − x₀).
    let norm = (2.0 * length * first.abs()).sqrt();
    vector[0] = first;
    vector.iter_mut().for_each(|x| *x /= norm);
    image * largest
}

/// Product H₁ H₂ … of reflections H = I − 2vvᵀ, in the form I − V T Vᵀ.
///
/// T⁻¹ is the upper triangle of VᵀV with a diagonal of 1/2.
///
/// # References
/// Joffrain et al., *ACM Trans. Math. Softw.* **32** (2006) 169, <https://doi.org/10.1145/1141885.1141886>.
#[derive(Debug, Clone)]
pub(super) struct Reflectors {
    /// Unit vectors v as columns.
    v: Array2<f64>,
    /// Upper triangle.
    t: Array2<f64>,
}

impl Reflectors {
    /// Creates the product from unit vectors, the columns of `v`.
    pub(super) fn new(v: Array2<f64>) -> Self {
        let mut inverse = v.t().dot(&v);
        inverse.diag_mut().fill(0.5);
        let mut t = Array2::eye(inverse.nrows());
        solve_upper(inverse.view(), t.view_mut());
        Self { v, t }
    }

    /// Multiplies a matrix by the product from the left.
    pub(super) fn apply(&self, matrix: ArrayViewMut2<'_, f64>) {
        self.subtract(self.t.view(), matrix);
    }

    /// Multiplies a matrix by the transposed product from the left.
    pub(super) fn apply_transposed(&self, matrix: ArrayViewMut2<'_, f64>) {
        self.subtract(self.t.t(), matrix);
    }

    fn subtract(&self, middle: ArrayView2<'_, f64>, mut matrix: ArrayViewMut2<'_, f64>) {
        let projections = self.v.t().dot(&matrix);
        general_mat_mul(-1.0, &self.v, &middle.dot(&projections), 1.0, &mut matrix);
    }
}
