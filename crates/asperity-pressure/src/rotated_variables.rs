//! Rotation of the normal variables ξ to one cell.
//!
//! The leading variables ξ describe the whole map, not a single cell. The height of the cell and the mean heights of
//! rings around it are linear in ξ for a Gaussian surface, and monotone in such linear functions for a translated
//! surface. In an orthonormal basis that begins with their directions, a few variables contain nearly all information
//! that is available without a contact solution. They are exactly standard normal.
//!
//! # References
//! R. Tipireddy and R. Ghanem, *J. Comput. Phys.* **259** (2014) 304, <https://doi.org/10.1016/j.jcp.2013.12.009> (basis
//! adaptation).

use ndarray::Array2;

use crate::predictor::Predictor;
use crate::{MethodError, Problem};
use asperity_base::blocks;
use asperity_base::numeric::dot;
use asperity_contact::Boundary;

/// Largest number of variables ξ for which a response is computed by finite differences, if the surface does not
/// provide it.
const MAX_XI_LEN: usize = 2048;
/// Half width of the finite difference.
const DIFFERENCE: f64 = 1e-3;
/// Number of samples used to select directions, and the relative reduction of the error that a further direction must
/// achieve.
const CHOOSING: usize = 1000;
const WORTHWHILE: f64 = 0.02;
/// Squared fraction of a direction that must be orthogonal to the previous ones.
const NEW: f64 = 1e-6;

/// Orthonormal directions in the space of ξ.
#[derive(Debug, Clone, Default)]
pub(super) struct RotatedVariables {
    directions: Vec<Vec<f64>>,
}

impl RotatedVariables {
    /// Selects directions of the cell of `problem` and of rings around it. Returns the rotation with the rotated variables of the samples.
    ///
    /// The most important direction comes first. At most `most` directions are kept, each of which improves the
    /// prediction of `values` by a polynomial of `degree` in ξ. `xi` returns the variables ξ of a sample. The result is
    /// empty if there are too many variables ξ or none has a direction of its own for the cell.
    pub(super) fn new(
        problem: &Problem<'_>,
        most: usize,
        degree: usize,
        xi: impl Fn(usize) -> Vec<f64> + Sync,
        values: &[f64],
    ) -> Result<(Self, Vec<Vec<f64>>), MethodError> {
        let responses: Vec<Vec<f64>> = responses(problem).into_iter().map(|(_, response)| response).collect();
        // The variables ξ of all samples may need much memory, their components along the responses do not.
        let all = responses.iter().fold(Self::default(), |all, response| all.with(response).unwrap_or(all));
        let samples: Vec<Vec<f64>> = blocks::map(0..values.len(), |sample| all.apply(&xi(sample)));
        let mut candidates: Vec<Vec<f64>> = responses.iter().map(|response| all.apply(response)).collect();
        let used = values.len().min(CHOOSING);
        let mut chosen = Self::default();
        let mut error = 1.0;
        while chosen.directions.len() < most {
            let mut best: Option<(usize, Self, f64)> = None;
            // The cell itself comes first.
            let tried = if chosen.directions.is_empty() { 1 } else { candidates.len() };
            for (place, candidate) in candidates.iter().enumerate().take(tried) {
                let Some(with) = chosen.with(candidate) else { continue };
                let rows: Vec<Vec<f64>> = samples[..used].iter().map(|sample| with.apply(sample)).collect();
                let found = Predictor::fit(&rows, &values[..used], degree)?.relative_error().unwrap_or(1.0);
                if best.as_ref().is_none_or(|(_, _, least)| found < *least) {
                    best = Some((place, with, found));
                }
            }
            match best {
                Some((place, with, found)) if found < (1.0 - WORTHWHILE) * error => {
                    (chosen, error) = (with, found);
                    candidates.remove(place);
                }
                _ => break,
            }
        }
        let rows = samples.iter().map(|sample| chosen.apply(sample)).collect();
        let directions = chosen.directions.iter().map(|components| all.combine(components)).collect();
        Ok((Self { directions }, rows))
    }

    /// Creates the rotation from given orthonormal directions.
    pub(super) fn from_orthonormal(directions: Vec<Vec<f64>>) -> Self {
        Self { directions }
    }

    /// Returns the rotated variables of ξ.
    pub(super) fn apply(&self, xi: &[f64]) -> Vec<f64> {
        self.directions.iter().map(|direction| dot(direction, xi)).collect()
    }

    /// Returns the vector with the given components along the directions.
    fn combine(&self, components: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.directions.first().map_or(0, Vec::len)];
        for (direction, component) in self.directions.iter().zip(components) {
            sum.iter_mut().zip(direction).for_each(|(sum, own)| *sum += component * own);
        }
        sum
    }

    /// Returns the rotation with the orthogonal part of another direction added, or `None` if nothing is left of it.
    pub(super) fn with(&self, direction: &[f64]) -> Option<Self> {
        let whole = dot(direction, direction);
        let mut rest = direction.to_vec();
        // Two passes are sufficient.
        for own in self.directions.iter().chain(&self.directions) {
            let fraction = dot(own, &rest);
            rest.iter_mut().zip(own).for_each(|(rest, own)| *rest -= fraction * own);
        }
        let new = dot(&rest, &rest);
        if !(new > NEW * whole && new.is_finite()) {
            return None;
        }
        rest.iter_mut().for_each(|x| *x /= new.sqrt());
        let mut directions = self.directions.clone();
        directions.push(rest);
        Some(Self { directions })
    }
}

/// Returns the response of the mean height of each ring to each variable ξ, with the number of the ring.
///
/// Ring 0 is the cell itself; ring n reaches up to 2ⁿ⁻¹ times the finer pitch. The responses have a common arbitrary
/// factor. The result is empty if the surface does not provide its response and there are too many variables ξ.
pub(super) fn responses(problem: &Problem<'_>) -> Vec<(usize, Vec<f64>)> {
    let rings = rings(problem);
    let used: Vec<usize> = (0..rings.len()).filter(|ring| !rings[*ring].is_empty()).collect();
    let stated: Option<Vec<Vec<f64>>> = used.iter().map(|ring| stated_response(problem, &rings[*ring])).collect();
    let responses = stated.unwrap_or_else(|| by_differences(problem, &rings, &used));
    used.into_iter().zip(responses).filter(|(_, response)| response.iter().all(|x| x.is_finite())).collect()
}

/// Returns the response of the mean height of a ring, if the surface provides it.
fn stated_response(problem: &Problem<'_>, ring: &[usize]) -> Option<Vec<f64>> {
    let (ny, nx) = problem.surface().grid().shape();
    let mut weights = Array2::zeros((ny, nx));
    ring.iter().for_each(|i| weights[[i / nx, i % nx]] = 1.0 / ring.len() as f64);
    problem.surface().xi_response(&weights)
}

/// Computes the differences of the mean heights of the used rings for each variable ξ.
fn by_differences(problem: &Problem<'_>, rings: &[Vec<usize>], used: &[usize]) -> Vec<Vec<f64>> {
    let surface = problem.surface();
    let xi_len = surface.xi_len();
    if xi_len > MAX_XI_LEN {
        return Vec::new();
    }
    let columns: Vec<Vec<f64>> = blocks::map(0..xi_len, |j| {
        let mut xi = vec![0.0; xi_len];
        let mut means = |value: f64| -> Vec<f64> {
            xi[j] = value;
            let map = surface.generate(&xi);
            let heights_m = map.heights_m().as_slice().unwrap_or(&[]);
            let mean = |ring: &Vec<usize>| ring.iter().map(|i| heights_m[*i]).sum::<f64>() / ring.len() as f64;
            rings.iter().map(mean).collect()
        };
        let (above, below) = (means(DIFFERENCE), means(-DIFFERENCE));
        above.iter().zip(&below).map(|(above, below)| above - below).collect()
    });
    used.iter().map(|ring| columns.iter().map(|column| column[*ring]).collect()).collect()
}

/// Returns the cell alone and the cells of rings around it whose radii double; some rings may be empty.
fn rings(problem: &Problem<'_>) -> Vec<Vec<usize>> {
    let grid = problem.surface().grid();
    let (row, column) = problem.cell();
    let periodic = matches!(problem.half_space().boundary(), Boundary::Periodic { .. });
    let apart = |a: usize, b: usize, n: usize| {
        let distance = a.abs_diff(b);
        (if periodic { distance.min(n - distance) } else { distance }) as f64
    };
    let pitch_m = grid.dx_m().min(grid.dy_m());
    let mut rings: Vec<Vec<usize>> = vec![Vec::new()];
    for i in 0..grid.points() {
        let along_x = apart(i % grid.nx(), column, grid.nx()) * grid.dx_m();
        let along_y = apart(i / grid.nx(), row, grid.ny()) * grid.dy_m();
        let over = along_x.hypot(along_y) / pitch_m;
        // Radii up to 1, up to 2, up to 4 …; values just beyond by rounding count as inside.
        let ring = if over < 0.5 { 0 } else { 1 + (over.log2() - 1e-9).ceil().max(0.0) as usize };
        if rings.len() <= ring {
            rings.resize(ring + 1, Vec::new());
        }
        rings[ring].push(i);
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Shape, gaussian_surface};
    use asperity_base::map::Grid;
    use asperity_base::random::{standard_normal, stream};
    use asperity_contact::{Control, HalfSpace};

    #[test]
    fn rings_contain_every_cell_once_and_begin_with_the_cell() {
        let grid = Grid::new(9, 7, 2.0, 1.0).unwrap();
        let shape = Shape::new(grid, 1.0, |x, _| x);
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
        let problem = Problem::new(&shape, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let rings = rings(&problem.at_cell(1, 2).unwrap());
        assert_eq!(rings[0], [11]);
        // One metre away along y.
        assert_eq!(rings[1], [2, 20]);
        // Two metres away along x and along y.
        assert!([10, 12, 29].iter().all(|cell| rings[2].contains(cell)));
        let mut all: Vec<usize> = rings.concat();
        all.sort_unstable();
        assert_eq!(all, (0..63).collect::<Vec<_>>());
    }

    #[test]
    fn stated_responses_are_those_of_differences() {
        let (surface, half_space) = gaussian_surface(12, 30);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let problem = problem.at_cell(3, 5).unwrap();
        let rings = rings(&problem);
        let used: Vec<usize> = (0..rings.len()).filter(|ring| !rings[*ring].is_empty()).collect();
        let by_differences = by_differences(&problem, &rings, &used);
        let stated = responses(&problem);
        assert_eq!(stated.iter().map(|(ring, _)| *ring).collect::<Vec<_>>(), used);
        assert!(by_differences.len() == used.len() && by_differences.iter().all(|ring| ring.len() == 30));
        for ((_, stated), differences) in stated.iter().zip(&by_differences) {
            for (stated, difference) in stated.iter().zip(differences) {
                assert!((2.0 * DIFFERENCE * stated - difference).abs() < 1e-13, "{stated} {difference}");
            }
        }
    }

    #[test]
    fn the_first_variable_is_the_height_of_the_cell() {
        let (surface, half_space) = gaussian_surface(16, 40);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let problem = problem.at_cell(3, 5).unwrap();
        let xi_samples: Vec<Vec<f64>> = (0..300).map(|i| standard_normal(&mut stream(1, "adapted", i), 40)).collect();
        let heights = |cell: [usize; 2]| -> Vec<f64> {
            xi_samples
                .iter()
                .map(|xi| asperity_surface::RandomSurface::generate(&surface, xi).heights_m()[cell])
                .collect()
        };
        // Values that depend on the cell and its neighbours.
        let around = [[2, 5], [4, 5], [3, 4], [3, 6]].map(heights);
        let mean = |i: usize| around.iter().map(|heights| heights[i]).sum::<f64>() / 4.0;
        let values: Vec<f64> =
            heights([3, 5]).iter().enumerate().map(|(i, z)| z + 30.0 * (z - mean(i)) + (z - mean(i)).powi(2)).collect();
        let (rotation, rows) = RotatedVariables::new(&problem, 4, 3, |i| xi_samples[i].clone(), &values).unwrap();
        assert!((2..=4).contains(&rotation.directions.len()), "{}", rotation.directions.len());
        let scale = heights([3, 5])[0] / rotation.apply(&xi_samples[0])[0];
        for ((xi, row), z) in xi_samples.iter().zip(&rows).zip(heights([3, 5])) {
            let rotated = rotation.apply(xi);
            assert!((rotated[0] * scale - z).abs() < 1e-9 * scale.abs());
            assert!(rotated.len() == row.len() && rotated.iter().zip(row).all(|(a, b)| (a - b).abs() < 1e-12));
        }
        for (i, a) in rotation.directions.iter().enumerate() {
            for (j, b) in rotation.directions.iter().enumerate() {
                let wanted = if i == j { 1.0 } else { 0.0 };
                assert!((dot(a, b) - wanted).abs() < 1e-12);
            }
        }
    }
}
