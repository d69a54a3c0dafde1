//! Products of Householder reflections.

use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayView2, ArrayViewMut2};

use super::solve_upper;
use crate::wide::{Kernel, wide};

/// Turns a vector into the unit normal v of the reflection I − 2vvᵀ that maps it to a multiple of the first axis, and
/// returns the multiple.
pub(super) fn reflector(vector: &mut [f64]) -> f64 {
    wide::<Reflector, _>(vector)
}

/// Kernel of [`reflector`].
struct Reflector;

impl<'a> Kernel<&'a mut [f64]> for Reflector {
    type Output = f64;

    #[inline(always)]
    fn run(vector: &'a mut [f64]) -> f64 {
        let largest = lanes(vector, |m, x| if x.abs() > m { x.abs() } else { m }).into_iter().fold(0.0, f64::max);
        let Some(first) = vector.first_mut() else { return 0.0 };
        if largest < f64::MIN_POSITIVE {
            *first = 1.0;
            return 0.0;
        }
        let inverse = largest.recip();
        vector.iter_mut().for_each(|x| *x *= inverse);
        let length = lanes(vector, |sum, x| sum + x * x).iter().sum::<f64>().sqrt();
        let image = -length.copysign(vector[0]);
        let first = vector[0] - image;
        // |v|² = |x|² − 2 x₀ image + image² = 2 image (image − x₀).
        let inverse = (2.0 * length * first.abs()).sqrt().recip();
        vector[0] = first;
        vector.iter_mut().for_each(|x| *x *= inverse);
        image * largest
    }
}

/// Folds every sixteenth value, beginning with each of the first sixteen.
#[inline(always)]
fn lanes(values: &[f64], fold: impl Fn(f64, f64) -> f64) -> [f64; 16] {
    let mut lanes = [0.0; 16];
    let (chunks, rest) = values.as_chunks::<16>();
    for chunk in chunks {
        for lane in 0..16 {
            lanes[lane] = fold(lanes[lane], chunk[lane]);
        }
    }
    for (lane, value) in lanes.iter_mut().zip(rest) {
        *lane = fold(*lane, *value);
    }
    lanes
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
    pub(super) v: Array2<f64>,
    /// Upper triangle.
    pub(super) t: Array2<f64>,
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
