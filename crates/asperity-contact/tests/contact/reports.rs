//! Cases that users of other programs reported; docs/validation/reports.md lists them.

use std::f64::consts::PI;

use asperity_base::map::Grid;
use asperity_contact::exact::{Hertz, Westergaard};
use asperity_contact::{Boundary, ContactError, ContactProblem, Control, HalfSpace, Solution, Solver};
use ndarray::Array2;

fn solve(half_space: &HalfSpace, heights_m: &Array2<f64>, control: Control) -> Solution {
    let problem = ContactProblem::new(half_space, heights_m, control, None).unwrap();
    let solution = Solver { tolerance: 1e-11, max_iterations: 2000 }.solve(&problem).unwrap();
    assert!(solution.converged());
    solution
}

/// Returns values with row and column moved on by `rows` and `columns` around the map.
fn shifted(values: &Array2<f64>, rows: usize, columns: usize) -> Array2<f64> {
    let (ny, nx) = values.dim();
    Array2::from_shape_fn((ny, nx), |(row, column)| values[[(row + ny - rows) % ny, (column + nx - columns) % nx]])
}

fn assert_close(found: &Array2<f64>, wanted: &Array2<f64>, tolerance: f64) {
    let differ = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(differ < tolerance, "{differ:e}");
}

#[test]
fn a_sphere_has_the_same_contact_wherever_it_stands_on_a_map_of_unequal_pitches() {
    // FastIsostasy.jl #101, ContactMechanics #28. Contact radius 0.1, some eleven cells.
    let grid = Grid::new(48, 32, 0.4 / 48.0, 0.3 / 32.0).unwrap();
    let sphere = |row: f64, column: f64| {
        Array2::from_shape_fn((32, 48), |(i, j)| {
            let (x, y) = ((j as f64 - column) * grid.dx_m(), (i as f64 - row) * grid.dy_m());
            -0.5 * (x * x + y * y)
        })
    };
    let load = Hertz::load_n(1.0, 1.0, 0.01);
    let p0 = (6.0 * load / PI.powi(3)).cbrt();
    let control = Control::Load { newton: load };
    let free = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    // On a cell, half a cell off, and with the contact at a corner of the map.
    let pressures = [(16.0, 23.0), (15.5, 23.5), (11.0, 13.0)].map(|(row, column)| {
        let solution = solve(&free, &sphere(row, column), control);
        let pressure = solution.pressure_pa().clone();
        // The centre of a cell lies up to half a diagonal off the summit, and (r/a)²/2 = 0.002 of p₀ below it.
        assert!((solution.max_pressure_pa() / p0 - 1.0).abs() < 0.01, "{} {p0}", solution.max_pressure_pa());
        assert!((solution.penetration_m() / 0.01 - 1.0).abs() < 0.01, "{}", solution.penetration_m());
        assert!(pressure.iter().all(|p| *p >= 0.0), "compression is positive");
        for ((i, j), p) in pressure.indexed_iter() {
            let (i, j) = (2.0 * row - i as f64, 2.0 * column - j as f64);
            let inside = (0.0..32.0).contains(&i) && (0.0..48.0).contains(&j);
            let opposite = if inside { pressure[[i as usize, j as usize]] } else { 0.0 };
            assert!((p - opposite).abs() < 1e-8 * p0, "{row} {column}: {p} {opposite}");
        }
        pressure
    });
    assert_close(&shifted(&pressures[2], 5, 10), &pressures[0], 1e-8 * p0);
    let periodic = HalfSpace::new(grid, 1.0, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }).unwrap();
    let heights = sphere(15.5, 23.5);
    let pressure = solve(&periodic, &heights, control).pressure_pa().clone();
    let moved = solve(&periodic, &shifted(&heights, 7, 29), control).pressure_pa().clone();
    assert_close(&moved, &shifted(&pressure, 7, 29), 1e-8 * p0);
}

#[test]
fn a_cosine_of_sixteen_points_is_pressed_flat_at_its_full_contact_pressure() {
    // ContactMechanics #3, #56, #68.
    let (n, amplitude) = (16, 0.01);
    let grid = Grid::new(n, 2, 1.0 / 16.0, 1.0 / 16.0).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }).unwrap();
    // The crest is a quarter of a cell off a point, so that widths change by single cells.
    let heights = Array2::from_shape_fn((2, n), |(_, i)| amplitude * (2.0 * PI * (i as f64 - 0.25) / 16.0).cos());
    let full = Westergaard::new(1.0, amplitude, 1.0, 0.0).full_contact_pressure_pa;
    assert!((full - 0.031_415_9).abs() < 5e-8);
    let flat = solve(&half_space, &heights, Control::MeanPressure { pascal: 1.001 * full });
    assert_eq!(flat.contact_fraction(), 1.0);
    assert!(flat.mean_gap_m() < 1e-12);
    for ratio in [0.05, 0.1, 0.25, 0.5, 0.75, 0.9] {
        let solution = solve(&half_space, &heights, Control::MeanPressure { pascal: ratio * full });
        let (found, wanted) = (solution.contact_fraction(), 2.0 / PI * f64::asin(ratio.sqrt()));
        assert!((found - wanted).abs() <= 1.0 / n as f64, "{ratio}: {found} {wanted}");
    }
    let (mean_pressure_pa, hardness_pa) = (0.021, 0.02);
    let control = Control::MeanPressure { pascal: mean_pressure_pa };
    let refused = ContactProblem::new(&half_space, &heights, control, Some(hardness_pa)).unwrap_err();
    assert_eq!(refused, ContactError::Overloaded { mean_pressure_pa, hardness_pa });
}
