//! Eigenpairs of tridiagonal matrices by division into halves.
//!
//! T = diag(T₁, T₂) + ρ z zᵀ, and the eigenpairs of the halves turn the problem into that of a diagonal matrix plus a
//! matrix of rank one, whose eigenvalues are the roots of a rational function.
//!
//! # References
//! Cuppen, *Numerische Mathematik* **36** (1981) 177, <https://doi.org/10.1007/BF01396757>.
//! Gu & Eisenstat, *SIAM J. Matrix Anal. Appl.* **16** (1995) 172, <https://doi.org/10.1137/S0895479892241287>.

use ndarray::{Array2, Axis, s};

use super::NotConverged;
use crate::wide::{Kernel, wide};

/// Size up to which a problem is not divided.
const SMALL: usize = 32;
/// Largest number of QL sweeps and of interpolations per eigenvalue.
const SWEEPS: usize = 60;
const ROOT_STEPS: usize = 200;
/// Number of partial sums.
const LANES: usize = 16;

/// Computes all eigenpairs of a tridiagonal matrix with entries about 1 at most: values, rising, and vectors as rows.
pub(super) fn eigenpairs(mut diagonal: Vec<f64>, beside: &[f64]) -> Result<(Vec<f64>, Array2<f64>), NotConverged> {
    let n = diagonal.len();
    if n <= SMALL {
        let mut vectors = Array2::eye(n);
        implicit_ql(&mut diagonal, &mut beside.to_vec(), &mut vectors)?;
        return Ok(sorted(&diagonal, &vectors));
    }
    let middle = n / 2;
    let coupling = beside[middle - 1];
    diagonal[middle - 1] -= coupling.abs();
    diagonal[middle] -= coupling.abs();
    let second = diagonal.split_off(middle);
    let (mut values, first) = eigenpairs(diagonal, &beside[..middle - 1])?;
    let (others, second) = eigenpairs(second, &beside[middle..])?;
    values.extend(others);
    // z is (…, 0, 1, ±1, 0, …) in the basis of the vectors, made a unit vector.
    let (last, next) = (first.column(middle - 1), second.column(0));
    let z = last.iter().copied().chain(next.iter().map(|v| coupling.signum() * v));
    let z = z.map(|v| v * std::f64::consts::FRAC_1_SQRT_2).collect();
    let mut vectors = Array2::zeros((n, n));
    vectors.slice_mut(s![..middle, ..middle]).assign(&first);
    vectors.slice_mut(s![middle.., middle..]).assign(&second);
    let halves = (0..n).map(|i| [i < middle, i >= middle]).collect();
    Ok(Coupled { values, z, strength: 2.0 * coupling.abs(), vectors, halves, middle }.eigenpairs())
}

/// Sorts eigenpairs by their values.
fn sorted(values: &[f64], vectors: &Array2<f64>) -> (Vec<f64>, Array2<f64>) {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    (order.iter().map(|place| values[*place]).collect(), vectors.select(Axis(0), &order))
}

/// Diagonal matrix plus ρ z zᵀ in a basis.
struct Coupled {
    values: Vec<f64>,
    z: Vec<f64>,
    /// ρ ≥ 0.
    strength: f64,
    /// Vectors of the basis as rows.
    vectors: Array2<f64>,
    /// Whether a vector has components in the first and in the second half.
    halves: Vec<[bool; 2]>,
    /// Size of the first half.
    middle: usize,
}

impl Coupled {
    fn eigenpairs(mut self) -> (Vec<f64>, Array2<f64>) {
        let kept = self.deflate();
        let n = self.values.len();
        let poles: Vec<f64> = kept.iter().map(|place| self.values[*place]).collect();
        let weights: Vec<f64> = kept.iter().map(|place| self.strength * self.z[*place].powi(2)).collect();
        let mut gaps = vec![0.0; poles.len()];
        let roots: Vec<Root> = (0..poles.len()).map(|j| Root::new(&poles, &weights, j, &mut gaps)).collect();
        // Rounded roots are the exact roots for a slightly different z. Its vectors are orthogonal.
        let size = kept.len();
        let z: Vec<f64> = (0..size)
            .map(|i| {
                let distance = |j: usize| roots[j].value_less(&poles, poles[i]);
                let square = (0..i).map(|j| distance(j) / (poles[j] - poles[i])).product::<f64>()
                    * (i + 1..size).map(|j| distance(j - 1) / (poles[j] - poles[i])).product::<f64>()
                    * distance(size - 1);
                square.abs().sqrt().copysign(self.z[kept[i]])
            })
            .collect();
        let mut coordinates = Array2::zeros((size, size));
        for (mut row, root) in coordinates.rows_mut().into_iter().zip(&roots) {
            row.iter_mut().zip(&z).zip(&poles).for_each(|((u, z), pole)| *u = z / root.value_less(&poles, *pole));
            let length = row.iter().map(|u| u * u).sum::<f64>().sqrt();
            row.mapv_inplace(|u| u / length);
        }
        let mut turned = Array2::zeros((size, n));
        for (half, columns) in [0..self.middle, self.middle..n].into_iter().enumerate() {
            let columns = s![.., columns];
            let own: Vec<usize> = (0..size).filter(|i| self.halves[kept[*i]][half]).collect();
            let places: Vec<usize> = own.iter().map(|i| kept[*i]).collect();
            let basis = self.vectors.slice(columns).select(Axis(0), &places);
            turned.slice_mut(columns).assign(&coordinates.select(Axis(1), &own).dot(&basis));
        }
        for ((place, root), vector) in kept.into_iter().zip(&roots).zip(turned.rows()) {
            self.values[place] = poles[root.origin] + root.shift;
            self.vectors.row_mut(place).assign(&vector);
        }
        sorted(&self.values, &self.vectors)
    }

    /// Makes small entries of z and, by rotations, those of nearly equal values zero. Returns the places of the others in
    /// the order of their values, which are distinct.
    fn deflate(&mut self) -> Vec<usize> {
        let largest = self.values.iter().chain(&self.z).fold(0.0_f64, |m, value| m.max(value.abs()));
        let negligible = 8.0 * f64::EPSILON * largest;
        let mut order: Vec<usize> = (0..self.values.len()).collect();
        order.sort_by(|a, b| self.values[*a].total_cmp(&self.values[*b]));
        order.retain(|place| self.strength * self.z[*place].abs() > negligible);
        let mut kept: Vec<usize> = Vec::new();
        for place in order {
            if let Some(last) = kept.last_mut() {
                let (a, b) = (*last, place);
                let length = self.z[a].hypot(self.z[b]);
                let (cos, sin) = (self.z[b] / length, self.z[a] / length);
                if ((self.values[b] - self.values[a]) * cos * sin).abs() <= negligible {
                    self.rotate(a, b, cos, sin);
                    (self.z[a], self.z[b]) = (0.0, length);
                    *last = b;
                    continue;
                }
            }
            kept.push(place);
        }
        kept
    }

    /// Rotates two vectors and the diagonal.
    fn rotate(&mut self, a: usize, b: usize, cos: f64, sin: f64) {
        let (mut x, mut y) = self.vectors.multi_slice_mut((s![a, ..], s![b, ..]));
        x.iter_mut().zip(&mut y).for_each(|(x, y)| (*x, *y) = (cos * *x - sin * *y, cos * *y + sin * *x));
        let (p, q) = (self.values[a], self.values[b]);
        self.values[a] = cos * cos * p + sin * sin * q;
        self.values[b] = sin * sin * p + cos * cos * q;
        let either = [0, 1].map(|half| self.halves[a][half] || self.halves[b][half]);
        (self.halves[a], self.halves[b]) = (either, either);
    }
}

/// Root of 1 + Σ wᵢ/(dᵢ − λ), by its difference from the nearer one of the poles beside it.
#[derive(Debug, Clone, Copy)]
struct Root {
    origin: usize,
    shift: f64,
}

impl Root {
    /// Returns the root above pole `j`, by rational interpolation within an interval that contains it.
    ///
    /// # References
    /// R.-C. Li, LAPACK Working Note 89 (1994), <https://www.netlib.org/lapack/lawnspdf/lawn89.pdf>.
    fn new(poles: &[f64], weights: &[f64], j: usize, gaps: &mut [f64]) -> Self {
        let next = poles.get(j + 1);
        // The last root is at most the sum of the weights above its pole.
        let width = next.map_or_else(|| 2.0 * weights.iter().sum::<f64>(), |next| next - poles[j]);
        gaps.iter_mut().zip(poles).for_each(|(gap, pole)| *gap = pole - poles[j]);
        let mut shift = 0.5 * width;
        let (mut low, mut high) = (0.0, width);
        let mut origin = j;
        if next.is_some() && Sums::at(gaps, weights, j, shift).value() < 0.0 {
            origin = j + 1;
            gaps.iter_mut().zip(poles).for_each(|(gap, pole)| *gap = pole - poles[origin]);
            (low, high, shift) = (-width, 0.0, -shift);
        }
        for _ in 0..ROOT_STEPS {
            let sums = Sums::at(gaps, weights, j, shift);
            let value = sums.value();
            if value < 0.0 {
                low = shift;
            } else {
                high = shift;
            }
            if value.abs() <= f64::EPSILON * (1.0 + sums.below.abs() + sums.above.abs()) {
                break;
            }
            let step = sums.step(gaps[j] - shift, gaps.get(j + 1).map(|gap| gap - shift));
            let mut tried = shift + step;
            if !(tried > low && tried < high) {
                tried = 0.5 * (low + high);
            }
            if tried == shift || tried <= low || tried >= high {
                break;
            }
            shift = tried;
        }
        Self { origin, shift }
    }

    /// Returns the root less a pole.
    fn value_less(&self, poles: &[f64], pole: f64) -> f64 {
        (poles[self.origin] - pole) + self.shift
    }
}

/// Sums over the poles up to the root and over those beyond it, with their derivatives.
struct Sums {
    below: f64,
    below_slope: f64,
    above: f64,
    above_slope: f64,
}

impl Sums {
    fn at(gaps: &[f64], weights: &[f64], j: usize, shift: f64) -> Self {
        let [below, below_slope] = wide::<Sum, _>((&gaps[..=j], &weights[..=j], shift));
        let [above, above_slope] = wide::<Sum, _>((&gaps[j + 1..], &weights[j + 1..], shift));
        Self { below, below_slope, above, above_slope }
    }

    fn value(&self) -> f64 {
        1.0 + self.below + self.above
    }

    /// Returns the step to the root of a function with the same values and slopes that has one or two poles, at these
    /// distances.
    fn step(&self, here: f64, next: Option<f64>) -> f64 {
        let value = self.value();
        let Some(next) = next else { return here * value / (value - here * self.below_slope) };
        let c = value - here * self.below_slope - next * self.above_slope;
        let a = (here + next) * value - here * next * (self.below_slope + self.above_slope);
        let b = here * next * value;
        let root = (a * a - 4.0 * b * c).max(0.0).sqrt();
        if a <= 0.0 { (a - root) / (2.0 * c) } else { 2.0 * b / (a + root) }
    }
}

/// Kernel that returns Σ w/(d − λ) and its derivative.
struct Sum;

impl<'a> Kernel<(&'a [f64], &'a [f64], f64)> for Sum {
    type Output = [f64; 2];

    #[inline(always)]
    fn run((gaps, weights, shift): (&'a [f64], &'a [f64], f64)) -> [f64; 2] {
        let ((gaps, gaps_rest), (weights, weights_rest)) = (gaps.as_chunks::<LANES>(), weights.as_chunks::<LANES>());
        let (mut sums, mut slopes) = ([0.0; LANES], [0.0; LANES]);
        for (gaps, weights) in gaps.iter().zip(weights) {
            for lane in 0..LANES {
                let inverse = 1.0 / (gaps[lane] - shift);
                let term = weights[lane] * inverse;
                sums[lane] += term;
                slopes[lane] += term * inverse;
            }
        }
        let (mut sum, mut slope) = (sums.iter().sum::<f64>(), slopes.iter().sum::<f64>());
        for (gap, weight) in gaps_rest.iter().zip(weights_rest) {
            let inverse = 1.0 / (gap - shift);
            sum += weight * inverse;
            slope += weight * inverse * inverse;
        }
        [sum, slope]
    }
}

/// Computes the eigenvalues of a tridiagonal matrix by implicit QL sweeps; they replace the diagonal, in no order. The
/// rotations are applied to the rows of `vectors`.
///
/// # References
/// Dubrulle, Martin & Wilkinson, *Numerische Mathematik* **12** (1968) 377, <https://doi.org/10.1007/BF02165404>.
fn implicit_ql(diagonal: &mut [f64], beside: &mut [f64], vectors: &mut Array2<f64>) -> Result<(), NotConverged> {
    let n = diagonal.len();
    for first in 0..n {
        for sweep in 0.. {
            let negligible = |k: &usize| {
                let size = |k: usize| diagonal[k].abs() + diagonal[k + 1].abs();
                beside.get(*k).is_none_or(|e| e.abs() <= f64::EPSILON * size(*k) + f64::MIN_POSITIVE)
            };
            let last = (first..n).find(negligible).unwrap_or(first);
            if last == first {
                break;
            }
            if sweep == SWEEPS {
                return Err(NotConverged);
            }
            let mut g = (diagonal[first + 1] - diagonal[first]) / (2.0 * beside[first]);
            g = diagonal[last] - diagonal[first] + beside[first] / (g + g.hypot(1.0).copysign(g));
            let (mut sin, mut cos, mut moved) = (1.0, 1.0, 0.0);
            if let Some(negligible) = beside.get_mut(last) {
                *negligible = 0.0;
            }
            for k in (first..last).rev() {
                let (f, b) = (sin * beside[k], cos * beside[k]);
                let r = (f * f + g * g).sqrt();
                if k + 1 < last {
                    beside[k + 1] = r;
                }
                if r == 0.0 {
                    diagonal[k + 1] -= moved;
                    break;
                }
                (sin, cos) = (f / r, g / r);
                let above = diagonal[k + 1] - moved;
                let turned = (diagonal[k] - above) * sin + 2.0 * cos * b;
                moved = sin * turned;
                diagonal[k + 1] = above + moved;
                g = cos * turned - b;
                let (mut x, mut y) = vectors.multi_slice_mut((s![k, ..], s![k + 1, ..]));
                x.iter_mut().zip(&mut y).for_each(|(x, y)| (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y));
                if k == first {
                    diagonal[first] -= moved;
                    beside[first] = g;
                }
            }
        }
    }
    Ok(())
}
