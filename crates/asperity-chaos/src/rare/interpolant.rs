//! Interpolation of a limit state by cubic radial functions with a polynomial.
//!
//! ĝ(z) = Σᵢ wᵢ |z − zᵢ|³ + p(z) passes through all values. The polynomial p is linear; it has squares, and products of two
//! variables, if there are enough points. Limit states of this form are reproduced exactly.

use asperity_base::numeric::dense_solution;
use ndarray::Array2;

/// Number of points per term of the polynomial.
const POINTS_PER_TERM: f64 = 1.5;

/// Product of at most two variables.
type Monomial = [Option<usize>; 2];

/// Interpolant of scattered values.
#[derive(Debug, Clone)]
pub(super) struct Interpolant {
    /// Coordinates of the points, one list per variable.
    coordinates: Vec<Vec<f64>>,
    weights: Vec<f64>,
    polynomial: Vec<(f64, Monomial)>,
}

impl Interpolant {
    /// Returns the interpolant; `None` if the points do not determine it.
    pub(super) fn new(points: &[Vec<f64>], values: &[f64]) -> Option<Self> {
        let (count, variables) = (points.len(), points.first()?.len());
        let monomials = monomials(variables, count);
        let size = count + monomials.len();
        let matrix = Array2::from_shape_fn((size, size), |(i, j)| {
            let (low, high) = (i.min(j), i.max(j));
            if high < count {
                let square: f64 = points[low].iter().zip(&points[high]).map(|(a, b)| (a - b) * (a - b)).sum();
                square * square.sqrt()
            } else if low < count {
                product(monomials[high - count], &points[low])
            } else {
                0.0
            }
        });
        let right: Vec<f64> = (0..size).map(|i| values.get(i).copied().unwrap_or(0.0)).collect();
        let solution = dense_solution(matrix.view(), &right);
        solution.iter().all(|value| value.is_finite()).then(|| Self {
            coordinates: (0..variables).map(|k| points.iter().map(|point| point[k]).collect()).collect(),
            weights: solution[..count].to_vec(),
            polynomial: solution[count..].iter().copied().zip(monomials).collect(),
        })
    }

    /// Returns the values at the points.
    pub(super) fn values(&self, points: &[Vec<f64>]) -> Vec<f64> {
        let mut squares = vec![0.0; self.weights.len()];
        points.iter().map(|point| self.value(point, &mut squares)).collect()
    }

    /// Returns the directions of steepest descent at the points, as unit vectors.
    pub(super) fn descents(&self, points: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut squares = vec![0.0; self.weights.len()];
        points.iter().map(|point| self.descent(point, &mut squares)).collect()
    }

    fn descent(&self, point: &[f64], squares: &mut [f64]) -> Vec<f64> {
        self.fill_squares(point, squares);
        // The factor of z − zᵢ in the gradient.
        squares.iter_mut().zip(&self.weights).for_each(|(square, w)| *square = 3.0 * w * square.sqrt());
        let radial = point.iter().zip(&self.coordinates);
        let radial = radial.map(|(z, coordinates)| coordinates.iter().zip(&*squares).map(|(x, f)| f * (z - x)).sum());
        let mut gradient: Vec<f64> = radial.collect();
        for (factor, monomial) in &self.polynomial {
            match *monomial {
                [Some(i), Some(j)] => {
                    gradient[i] += factor * point[j];
                    gradient[j] += factor * point[i];
                }
                [Some(i), None] => gradient[i] += factor,
                _ => {}
            }
        }
        let length = gradient.iter().map(|d| d * d).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        gradient.into_iter().map(|d| -d / length).collect()
    }

    fn fill_squares(&self, point: &[f64], squares: &mut [f64]) {
        squares.fill(0.0);
        for (z, coordinates) in point.iter().zip(&self.coordinates) {
            squares.iter_mut().zip(coordinates).for_each(|(square, x)| *square += (z - x) * (z - x));
        }
    }

    fn value(&self, point: &[f64], squares: &mut [f64]) -> f64 {
        self.fill_squares(point, squares);
        let radial: f64 = squares.iter().zip(&self.weights).map(|(square, w)| w * square * square.sqrt()).sum();
        radial + self.polynomial.iter().map(|(factor, monomial)| factor * product(*monomial, point)).sum::<f64>()
    }
}

/// Returns the terms of the polynomial: linear ones, with more points squares, with yet more points products.
fn monomials(variables: usize, points: usize) -> Vec<Monomial> {
    let allowed = |terms: usize| POINTS_PER_TERM * terms as f64 <= points as f64;
    let mut monomials = vec![[None, None]];
    monomials.extend((0..variables).map(|i| [Some(i), None]));
    if allowed(1 + 2 * variables) {
        monomials.extend((0..variables).map(|i| [Some(i), Some(i)]));
    }
    if allowed((variables + 1) * (variables + 2) / 2) {
        monomials.extend((0..variables).flat_map(|i| (0..i).map(move |j| [Some(i), Some(j)])));
    }
    monomials
}

fn product(monomial: Monomial, z: &[f64]) -> f64 {
    monomial.into_iter().flatten().map(|i| z[i]).product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{standard_normal, stream};

    #[test]
    fn values_are_those_of_the_points_and_descents_those_of_differences() {
        let rough = |z: &[f64]| 1.0 + z[0] - 0.5 * z[1] * z[0] + 0.3 * z[1] * z[1] + (2.0 * z[0]).sin();
        let points: Vec<Vec<f64>> =
            standard_normal(&mut stream(1, "interpolant", 0), 60).chunks(2).map(<[_]>::to_vec).collect();
        let values: Vec<f64> = points.iter().map(|z| rough(z)).collect();
        let found = Interpolant::new(&points, &values).unwrap();
        assert!(found.values(&points).iter().zip(&values).all(|(f, v)| (f - v).abs() < 1e-9));
        let places = vec![vec![0.3, -0.2], vec![-1.1, 0.7], vec![0.05, 1.4]];
        for (place, descent) in places.iter().zip(found.descents(&places)) {
            let moved = |k: usize, by: f64| {
                let mut z = place.clone();
                z[k] += by;
                found.values(&[z])[0]
            };
            let slopes = [0, 1].map(|k| (moved(k, 1e-5) - moved(k, -1e-5)) / 2e-5);
            let length = slopes[0].hypot(slopes[1]);
            assert!((0..2).all(|k| (descent[k] + slopes[k] / length).abs() < 1e-6), "{descent:?} {slopes:?}");
        }
    }
}
