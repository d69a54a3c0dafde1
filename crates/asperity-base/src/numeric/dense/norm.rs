//! Largest singular value of a triangle.

use ndarray::Array2;

use crate::numeric::dot;
use crate::wide::{Kernel, wide};

/// Lanczos steps between two estimates.
const STEPS: usize = 4;
/// Residual, relative to the eigenvalue, at which the iteration ends. It bounds the error, which is of the order of its
/// square unless other eigenvalues are as near.
const RESIDUAL: f64 = 1e-8;

/// Returns the largest singular value of an upper triangle in standard layout, NaN if it cannot be computed.
///
/// Lanczos iteration with RᵀR. Vectors are not orthogonalised again: that would only prevent copies of eigenvalues that
/// were found already.
///
/// # References
/// Paige, *Linear Algebra and its Applications* **34** (1980) 235, <https://doi.org/10.1016/0024-3795(80)90167-6>.
pub(super) fn spectral_norm(triangle: &Array2<f64>) -> f64 {
    let n = triangle.nrows();
    let scale = triangle.iter().fold(0.0_f64, |m, value| if m >= value.abs() { m } else { value.abs() });
    if !scale.is_finite() || scale == 0.0 {
        return if scale == 0.0 { 0.0 } else { f64::NAN };
    }
    let scaled = triangle.mapv(|value| value / scale);
    let Some(rows) = scaled.as_slice() else { return f64::NAN };
    // No special vector: fractions of the multiples of the golden ratio.
    let mut vector: Vec<f64> = (1..=n).map(|i| 0.5 + (i as f64 * 0.618_033_988_749_894_9).fract()).collect();
    let (mut before, mut next) = (vec![0.0; n], vec![0.0; n]);
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let mut length = norm(&vector);
    for step in 1.. {
        vector.iter_mut().for_each(|v| *v /= length);
        next.fill(0.0);
        wide::<Square, _>((rows, &vector[..], &mut next[..]));
        let own = dot(&vector, &next);
        for ((w, v), u) in next.iter_mut().zip(&vector).zip(&before) {
            *w -= own * v + beside.last().unwrap_or(&0.0) * u;
        }
        length = norm(&next);
        diagonal.push(own);
        if step % STEPS == 0 || length == 0.0 {
            let value = largest_eigenvalue(&diagonal, &beside);
            if length * last_component(&diagonal, &beside, value) <= RESIDUAL * value || step > 100 * STEPS + 10 * n {
                return scale * value.sqrt();
            }
        }
        beside.push(length);
        (before, vector, next) = (vector, next, before);
    }
    f64::NAN
}

/// Returns the largest eigenvalue of a tridiagonal matrix by bisection with Sturm's count.
fn largest_eigenvalue(diagonal: &[f64], beside: &[f64]) -> f64 {
    let mut low = diagonal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut high = low + 2.0 * beside.iter().copied().fold(0.0, f64::max);
    loop {
        let middle = low.midpoint(high);
        if middle <= low || middle >= high {
            return high;
        }
        // All pivots of x − T are positive where x is above all eigenvalues.
        let mut pivot = middle - diagonal[0];
        let positive = pivot > 0.0
            && diagonal[1..].iter().zip(beside).all(|(own, beside)| {
                pivot = middle - own - beside * beside / pivot;
                pivot > 0.0
            });
        *(if positive { &mut high } else { &mut low }) = middle;
    }
}

/// Returns the size of the last component of a unit eigenvector of a tridiagonal matrix.
fn last_component(diagonal: &[f64], beside: &[f64], value: f64) -> f64 {
    let (mut after, mut own, mut beside_after, mut squares) = (0.0, 1.0_f64, 0.0, 1.0_f64);
    for (diagonal, beside) in diagonal[1..].iter().zip(beside).rev() {
        (after, own) = (own, ((value - diagonal) * own - beside_after * after) / beside);
        beside_after = *beside;
        squares += own * own;
        if squares > 1e100 {
            break;
        }
    }
    squares.sqrt().recip()
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Kernel that adds RᵀR x to a vector, for the upper triangle R in rows.
struct Square;

impl<'a> Kernel<(&'a [f64], &'a [f64], &'a mut [f64])> for Square {
    type Output = ();

    #[inline(always)]
    fn run((rows, x, sum): (&'a [f64], &'a [f64], &'a mut [f64])) {
        let n = x.len();
        for (i, row) in rows.chunks_exact(n).enumerate() {
            let (row, x, sum) = (&row[i..], &x[i..], &mut sum[i..]);
            let mut lanes = [0.0; 16];
            let (chunks, rest) = row.as_chunks::<16>();
            let (x_chunks, x_rest) = x.as_chunks::<16>();
            for (r, x) in chunks.iter().zip(x_chunks) {
                for lane in 0..16 {
                    lanes[lane] += r[lane] * x[lane];
                }
            }
            let product = lanes.iter().sum::<f64>() + dot(rest, x_rest);
            for (sum, r) in sum.iter_mut().zip(row) {
                *sum += product * r;
            }
        }
    }
}
