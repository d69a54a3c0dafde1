//! Directions in the space of germs that have names.

use rayon::prelude::*;

use crate::contact::Boundary;
use crate::pressure::Problem;

/// Longest germ whose response is found by finite differences.
const LONGEST_GERM: usize = 2048;
/// Half width of such a difference.
const DIFFERENCE: f64 = 1e-3;
/// Share of a direction that has to be new.
const NEW: f64 = 1e-6;

/// Orthonormal directions, each of what is new in a mean height that has a name.
#[derive(Debug, Clone, Default)]
pub(super) struct NamedDirections {
    pub(super) names: Vec<String>,
    directions: Vec<Vec<f64>>,
}

impl NamedDirections {
    /// The height of the cell, and the mean heights of rings around it from the inmost out, `most` in all: what each says
    /// beyond those before it. Ring n goes up to 2ⁿ⁻¹ times the finer pitch. None of a surface whose germ is too long.
    pub(super) fn of_cell(problem: &Problem<'_>, most: usize) -> Self {
        let mut named = Self::default();
        if problem.surface().germ_len() > LONGEST_GERM {
            return named;
        }
        for (ring, response) in responses(problem) {
            if named.directions.len() == most {
                break;
            }
            let name = if ring == 0 { "height of the cell".to_owned() } else { format!("ring {ring}") };
            named.add(name, &response);
        }
        named
    }

    /// The leading variables themselves.
    pub(super) fn leading(germ_len: usize, most: usize) -> Self {
        let unit = |j: usize| (0..germ_len).map(|i| if i == j { 1.0 } else { 0.0 }).collect();
        let count = most.min(germ_len);
        Self {
            names: (1..=count).map(|mode| format!("mode {mode}")).collect(),
            directions: (0..count).map(unit).collect(),
        }
    }

    /// The variables of a germ.
    pub(super) fn of(&self, germ: &[f64]) -> Vec<f64> {
        self.directions.iter().map(|direction| dot(direction, germ)).collect()
    }

    fn add(&mut self, name: String, direction: &[f64]) {
        let whole = dot(direction, direction);
        let mut rest = direction.to_vec();
        // Twice is enough.
        for own in self.directions.iter().chain(&self.directions) {
            let share = dot(own, &rest);
            rest.iter_mut().zip(own).for_each(|(rest, own)| *rest -= share * own);
        }
        let new = dot(&rest, &rest);
        if new > NEW * whole && new.is_finite() {
            rest.iter_mut().for_each(|x| *x /= new.sqrt());
            self.names.push(name);
            self.directions.push(rest);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Response of the mean height of each ring to each germ variable, with the number of the ring.
fn responses(problem: &Problem<'_>) -> Vec<(usize, Vec<f64>)> {
    let surface = problem.surface();
    let ring_of = rings(problem);
    let count = ring_of.iter().max().map_or(0, |ring| ring + 1);
    let mut sizes = vec![0.0_f64; count];
    ring_of.iter().for_each(|ring| sizes[*ring] += 1.0);
    let germ_len = surface.germ_len();
    let columns: Vec<Vec<f64>> = (0..germ_len)
        .into_par_iter()
        .map(|j| {
            let mut germ = vec![0.0; germ_len];
            let mut means = vec![0.0; count];
            for sign in [1.0, -1.0] {
                germ[j] = sign * DIFFERENCE;
                let map = surface.generate(&germ);
                for (z, ring) in map.heights_m().iter().zip(&ring_of) {
                    means[*ring] += sign * z / sizes[*ring];
                }
            }
            means
        })
        .collect();
    (0..count)
        .filter(|ring| sizes[*ring] > 0.0)
        .map(|ring| (ring, columns.iter().map(|column| column[ring]).collect()))
        .collect()
}

/// The ring of every cell: 0 the cell itself, n those up to 2ⁿ⁻¹ times the finer pitch away.
fn rings(problem: &Problem<'_>) -> Vec<usize> {
    let grid = problem.surface().grid();
    let (row, column) = problem.cell();
    let periodic = matches!(problem.half_space().boundary(), Boundary::Periodic { .. });
    let apart = |a: usize, b: usize, n: usize| {
        let distance = a.abs_diff(b);
        (if periodic { distance.min(n - distance) } else { distance }) as f64
    };
    let pitch_m = grid.dx_m().min(grid.dy_m());
    let ring = |i: usize| {
        let along_x = apart(i % grid.nx(), column, grid.nx()) * grid.dx_m();
        let along_y = apart(i / grid.nx(), row, grid.ny()) * grid.dy_m();
        let over = along_x.hypot(along_y) / pitch_m;
        // Just beyond by rounding counts as in.
        if over < 0.5 { 0 } else { 1 + (over.log2() - 1e-9).ceil().max(0.0) as usize }
    };
    (0..grid.points()).map(ring).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Control, HalfSpace};
    use crate::map::Grid;
    use crate::pressure::testing::{Shape, gaussian_surface};
    use crate::random::{standard_normal, stream};
    use crate::surface::RandomSurface;

    #[test]
    fn rings_double_their_radii() {
        let grid = Grid::new(9, 7, 1.0, 0.5).unwrap();
        let shape = Shape::new(grid, 1.0, |x, _| x);
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
        let problem = Problem::new(&shape, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let rings = rings(&problem.at_cell(1, 2).unwrap());
        // The cell; half a metre along y; a metre along x and along y.
        assert_eq!([rings[11], rings[2], rings[20], rings[10], rings[12], rings[29]], [0, 1, 1, 2, 2, 2]);
    }

    #[test]
    fn the_first_direction_is_the_height_of_the_cell_and_all_are_orthonormal() {
        let (surface, half_space) = gaussian_surface(16, 40);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let problem = problem.at_cell(3, 5).unwrap();
        let named = NamedDirections::of_cell(&problem, 4);
        assert_eq!(named.names, ["height of the cell", "ring 1", "ring 2", "ring 3"]);
        let germs: Vec<Vec<f64>> = (0..3).map(|i| standard_normal(&mut stream(1, "directions", i), 40)).collect();
        let ratio = |germ: &Vec<f64>| surface.generate(germ).heights_m()[[3, 5]] / named.of(germ)[0];
        assert!((ratio(&germs[0]) / ratio(&germs[1]) - 1.0).abs() < 1e-9);
        for (i, a) in named.directions.iter().enumerate() {
            for (j, b) in named.directions.iter().enumerate() {
                assert!((dot(a, b) - if i == j { 1.0 } else { 0.0 }).abs() < 1e-12);
            }
        }
        let leading = NamedDirections::leading(40, 2);
        assert_eq!((leading.of(&germs[0]), leading.names[1].as_str()), (germs[0][..2].to_vec(), "mode 2"));
    }
}
