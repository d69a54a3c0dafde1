//! Windows of any shape and friction laws, against counts cell by cell and closed forms.

use std::f64::consts::{FRAC_2_PI, PI};

use asperity_base::correlation::{CorrelationModel, Covariance};
use asperity_base::map::{Grid, HeightMap};
use asperity_base::random;
use asperity_contact::exact::Hertz;
use asperity_contact::{Boundary, ContactProblem, Control, HalfSpace, Solution, Solver};
use asperity_friction::law::{AdhesionPloughing, BowdenTabor, Coulomb, PressureDependent, WindowLaw};
use asperity_friction::window::Window;
use asperity_friction::{WindowContact, window_contacts};
use asperity_surface::{RandomSurface, SpectralField};
use ndarray::Array2;

const MODULUS_PA: f64 = 230e9;

fn grid(nx: usize, ny: usize) -> Grid {
    Grid::new(nx, ny, 2e-6, 1.5e-6).unwrap()
}

fn solve(map: &HeightMap, periodic: bool, control: Control, hardness_pa: Option<f64>) -> Solution {
    let grid = map.grid();
    let mean_compliance_m_per_pa = HalfSpace::default_mean_compliance_m_per_pa(grid, MODULUS_PA);
    let boundary = if periodic { Boundary::Periodic { mean_compliance_m_per_pa } } else { Boundary::Free };
    let half_space = HalfSpace::new(grid, MODULUS_PA, boundary).unwrap();
    let problem = ContactProblem::new(&half_space, map.complete_heights_m().unwrap(), control, hardness_pa).unwrap();
    let solution = Solver { tolerance: 1e-7, ..Solver::default() }.solve(&problem).unwrap();
    assert!(solution.converged(), "{:?}", solution.residual());
    solution
}

fn rough(grid: Grid) -> HeightMap {
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 0.5e-6, 12e-6).unwrap();
    let field = SpectralField::periodic(&covariance, grid);
    field.generate(&random::standard_normal(&mut random::stream(4, "friction windows", 0), field.xi_len()))
}

/// Returns a rectangle as wide as the strip and a narrower one, an ellipse, and a mask with a hole and two parts.
fn shapes(grid: Grid) -> [Window; 4] {
    let (length_m, width_m) = (33.0 * grid.dx_m(), 7.0 * grid.dy_m());
    let mask = Array2::from_shape_fn((6, 32), |(row, column)| {
        (row % 5 == 0 && column < 20) || (column % 11 == 0) || (row == 3 && column > 28)
    });
    [
        Window::new(length_m, grid).unwrap(),
        Window::rectangle(length_m, width_m, grid).unwrap(),
        Window::ellipse(length_m, width_m, grid).unwrap(),
        Window::from_mask(&mask, grid).unwrap(),
    ]
}

/// Computes the contact of the window at this first row and column, cell by cell.
fn counted(map: &HeightMap, solution: &Solution, window: &Window, track: usize, start: usize) -> WindowContact {
    let (p, z) = (solution.pressure_pa(), map.complete_heights_m().unwrap());
    let (grid, periodic) = (solution.grid(), solution.boundary() != Boundary::Free);
    let (ny, nx) = p.dim();
    let place = |row: isize, column: isize| -> Option<(usize, usize)> {
        let inside = (0..ny as isize).contains(&row) && (0..nx as isize).contains(&column);
        (periodic || inside).then(|| (row.rem_euclid(ny as isize) as usize, column.rem_euclid(nx as isize) as usize))
    };
    let upper = solution.hardness_pa().unwrap_or(f64::INFINITY);
    let areas = solution.cell_contact_areas();
    let (mut contact, mut area, mut load_pa, mut ploughing_pa) = (0.0, 0.0, 0.0, 0.0);
    for ((row, column), _) in window.mask().indexed_iter().filter(|(_, inside)| **inside) {
        let (row, column) = ((track + row) as isize, (start + column) as isize);
        let own = place(row, column).unwrap();
        let here = p[own];
        contact += f64::from(here > 0.0);
        area += areas[own];
        load_pa += here;
        if here >= upper {
            let (before, after) = (place(row, column - 1), place(row, column + 1));
            let steps = f64::from(u8::from(before.is_some()) + u8::from(after.is_some()));
            let rise = z[after.unwrap_or(own)] - z[before.unwrap_or(own)];
            ploughing_pa += here * (rise / (steps * grid.dx_m())).abs();
        }
    }
    let cell_m2 = grid.cell_area_m2();
    WindowContact {
        position_m: (start as f64 + 0.5 * window.cells() as f64) * grid.dx_m(),
        contact_cells: contact,
        area_m2: area * cell_m2,
        least_area_m2: load_pa / upper * cell_m2,
        load_n: load_pa * cell_m2,
        ploughing_n: ploughing_pa * cell_m2,
    }
}

#[test]
fn sums_over_runs_equal_direct_counts_of_every_window() {
    // Sizes that are neither even nor powers of two.
    let map = rough(grid(331, 16));
    for (periodic, hardness_pa) in [(true, None), (true, Some(3e9)), (false, Some(3e9))] {
        let solution = solve(&map, periodic, Control::Percentile { percent: 20.0 }, hardness_pa);
        assert!(hardness_pa.is_none() || solution.plastic_fraction() > 0.0);
        for window in shapes(map.grid()) {
            let heights_m = map.complete_heights_m().unwrap();
            let seen = window_contacts(&solution, &[&window], Some(heights_m)).remove(0);
            let tracks = window.tracks(periodic);
            assert_eq!(seen.len(), tracks.len());
            assert_eq!(tracks.len(), if periodic { 16 / window.rows() } else { 1 });
            let step = (window.step_m() / map.grid().dx_m()).round() as usize;
            let first = if periodic { 0 } else { 12 };
            for (track, seen) in tracks.into_iter().zip(&seen) {
                assert_eq!(seen.len(), if periodic { 331_usize } else { 331 - 24 - window.cells() + 1 }.div_ceil(step));
                for (index, found) in seen.iter().enumerate() {
                    let wanted = counted(&map, &solution, &window, track, first + index * step);
                    let near = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-12 * scale;
                    assert!(near(found.position_m, wanted.position_m, 1e-3));
                    assert_eq!(found.contact_cells, wanted.contact_cells);
                    assert!(near(found.area_m2, wanted.area_m2, window.area_m2()));
                    assert!(near(found.least_area_m2, wanted.least_area_m2, window.area_m2()));
                    assert!(near(found.load_n, wanted.load_n, solution.load_n()));
                    assert_eq!(found.load_n == 0.0, wanted.load_n == 0.0, "an empty window is exactly empty");
                    assert!(near(found.ploughing_n, wanted.ploughing_n, solution.load_n()));
                }
            }
        }
    }
}

#[test]
fn adjoining_windows_on_all_tracks_add_up_to_the_strip() {
    let map = rough(grid(320, 16));
    let solution = solve(&map, true, Control::Percentile { percent: 10.0 }, Some(3e9));
    let window = Window::rectangle(32.0 * 2e-6, 4.0 * 1.5e-6, map.grid()).unwrap();
    let seen = window_contacts(&solution, &[&window], None).remove(0);
    let adjoining: Vec<&WindowContact> = seen.iter().flat_map(|track| track.iter().step_by(16)).collect();
    assert_eq!((seen.len(), adjoining.len()), (4, 40));
    let area_m2: f64 = adjoining.iter().map(|w| w.area_m2).sum();
    let load_n: f64 = adjoining.iter().map(|w| w.load_n).sum();
    assert!((area_m2 / (solution.corrected_contact_fraction() * map.grid().area_m2()) - 1.0).abs() < 1e-12);
    assert!((load_n / solution.load_n() - 1.0).abs() < 1e-12);
}

/// Returns the friction coefficients of every loaded window under a friction law.
fn coefficients(map: &HeightMap, solution: &Solution, window: &Window, law: &dyn WindowLaw) -> Vec<f64> {
    let heights_m = law.ploughs().then(|| map.complete_heights_m().unwrap());
    let seen = window_contacts(solution, &[window], heights_m).remove(0);
    let coefficients: Vec<f64> = seen.iter().flatten().filter_map(|w| law.coefficient(w)).collect();
    assert!(coefficients.len() > 20);
    coefficients
}

#[test]
fn fully_plastic_friction_is_constant_in_every_window_for_every_law() {
    let map = rough(grid(340, 16));
    // Yield stress Y: τ_max = Y/√3 and H = 3Y.
    let yield_pa = 1.0;
    let shear_strength_pa = yield_pa / 3.0_f64.sqrt();
    for periodic in [true, false] {
        let solution = solve(&map, periodic, Control::Percentile { percent: 30.0 }, Some(3.0 * yield_pa));
        assert_eq!(solution.plastic_fraction(), solution.contact_fraction());
        for window in shapes(map.grid()) {
            let sheared = BowdenTabor { shear_strength_pa };
            let dependent = PressureDependent { shear_strength_pa, pressure_coefficient: 0.05 };
            let laws: [(&dyn WindowLaw, f64); 3] =
                [(&sheared, 0.19245), (&dependent, 0.24245), (&Coulomb { coefficient: 0.3 }, 0.3)];
            for (law, wanted) in laws {
                let found = coefficients(&map, &solution, &window, law);
                assert!(found.iter().all(|mu| (mu / found[0] - 1.0).abs() < 1e-10), "{law:?}");
                assert!((found[0] - wanted).abs() < 1e-6, "{law:?}: {}", found[0]);
            }
            assert!((coefficients(&map, &solution, &window, &sheared)[0] - 1.0 / 27.0_f64.sqrt()).abs() < 1e-12);
        }
    }
}

#[test]
fn friction_by_shear_is_never_below_its_plastic_floor() {
    let map = rough(grid(331, 16));
    let (shear_strength_pa, hardness_pa) = (385e6, 2e9);
    for percent in [0.5, 5.0, 50.0] {
        let solution = solve(&map, true, Control::Percentile { percent }, Some(hardness_pa));
        for window in shapes(map.grid()) {
            let least = shear_strength_pa / hardness_pa * (1.0 - 1e-12);
            let sheared = coefficients(&map, &solution, &window, &BowdenTabor { shear_strength_pa });
            let law = PressureDependent { shear_strength_pa, pressure_coefficient: 0.1 };
            let dependent = coefficients(&map, &solution, &window, &law);
            let ploughing = coefficients(&map, &solution, &window, &AdhesionPloughing { shear_strength_pa });
            for ((sheared, dependent), ploughing) in sheared.iter().zip(dependent).zip(ploughing) {
                assert!(*sheared >= least && ploughing >= *sheared);
                assert!((dependent - sheared - 0.1).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn in_full_elastic_contact_friction_is_shear_strength_over_mean_pressure_in_a_window_of_any_width() {
    let grid = grid(320, 16);
    let (amplitude_m, wavelength_m) = (10e-9, 32.0 * grid.dx_m());
    let wave = HeightMap::from_function(grid, |x, _| amplitude_m * (2.0 * PI * x / wavelength_m).cos()).unwrap();
    // Westergaard: contact is complete from p* = πE*h/λ on.
    let pressure_pa = 1.5 * PI * MODULUS_PA * amplitude_m / wavelength_m;
    let solution = solve(&wave, true, Control::MeanPressure { pascal: pressure_pa }, None);
    assert_eq!(solution.contact_fraction(), 1.0);
    let window = Window::rectangle(wavelength_m, 4.0 * grid.dy_m(), grid).unwrap();
    for (law, more) in [
        (&BowdenTabor { shear_strength_pa: 1e8 } as &dyn WindowLaw, 0.0),
        (&PressureDependent { shear_strength_pa: 1e8, pressure_coefficient: 0.2 }, 0.2),
        // Without a hardness no cell is plastic.
        (&AdhesionPloughing { shear_strength_pa: 1e8 }, 0.0),
    ] {
        let found = coefficients(&wave, &solution, &window, law);
        assert!(found.iter().all(|mu| (mu / (1e8 / pressure_pa + more) - 1.0).abs() < 1e-6), "{law:?}");
    }
}

/// Returns ten bumps in a row, on cells of `spacing` per pitch. `height` is the height of a bump in pitches at a
/// distance in pitches. Summits lie between the cells, at a different offset for each bump.
fn row_of_bumps(spacing: usize, pitch_m: f64, height: impl Fn(f64) -> f64) -> HeightMap {
    let grid = Grid::new(20 * spacing, spacing, pitch_m / spacing as f64, pitch_m / spacing as f64).unwrap();
    let centre = |index: usize| {
        let shift = |ratio: f64| (index as f64 * ratio).fract() * grid.dx_m();
        ((index as f64 + 0.5) * pitch_m + shift(0.618), 0.5 * pitch_m + shift(0.414))
    };
    HeightMap::from_function(grid, |x, y| {
        let (cx, cy) = centre(((x / pitch_m) as usize).min(19));
        pitch_m * height((x - cx).hypot(y - cy) / pitch_m)
    })
    .unwrap()
}

#[test]
fn a_lattice_of_hertz_contacts_has_the_friction_of_their_circles_at_more_than_first_order() {
    let pitch_m = 96e-6;
    let radius_m = 2e-3;
    let mut errors = Vec::new();
    for spacing in [24, 48, 96] {
        let map = row_of_bumps(spacing, pitch_m, |r| -r * r * pitch_m / (2.0 * radius_m));
        // The contact radius is 7/48 of the pitch: a³ = 3FR/4E*.
        let radius_wanted_m = 7.0 / 48.0 * pitch_m;
        let force_n = 4.0 * MODULUS_PA * radius_wanted_m.powi(3) / (3.0 * radius_m);
        let hertz = Hertz::new(MODULUS_PA, radius_m, force_n);
        assert!((hertz.contact_radius_m / radius_wanted_m - 1.0).abs() < 1e-12);
        let solution = solve(&map, true, Control::Load { newton: 20.0 * force_n }, None);
        let window = Window::new(2.0 * pitch_m, map.grid()).unwrap();
        // The other contacts of the square lattice bend the surface by ρ²·F/(4πE*)·Σ1/R³ away from the flat, Σ1/R³ =
        // 9.0336/L³. This sharpens the bump: its radius R falls by a fraction (2·9.0336/3π)(a/L)³ and its area by ⅔ of
        // that.
        let sharpened = 2.0 / 3.0 * 2.0 * 9.0336 / (3.0 * PI) * (radius_wanted_m / pitch_m).powi(3);
        let wanted = 1e8 * PI * hertz.contact_radius_m.powi(2) * (1.0 - sharpened) / force_n;
        let found = coefficients(&map, &solution, &window, &BowdenTabor { shear_strength_pa: 1e8 });
        // The area of two circles on cells varies by less than half a ring of cells, Δx/a.
        let cells = 7.0 / 48.0 * spacing as f64;
        assert!(found.iter().all(|mu| (mu / wanted - 1.0).abs() < 1.0 / cells));
        let error = found.iter().sum::<f64>() / found.len() as f64 / wanted - 1.0;
        println!("Δx/a = 1/{cells}: error {error:.5}");
        // The bias of counting cells is 0.3 Δx/a.
        assert!(error.abs() < 0.02 / cells, "{error} at {cells} cells per radius");
        errors.push(error.abs());
    }
    let order = (errors[0] / errors[2]).log2() / 2.0;
    assert!(order > 1.5, "observed order {order:.2}");
}

#[test]
fn plastic_cones_have_the_ploughing_friction_of_bowden_and_tabor() {
    // Cones of slope 0.1, with the plane a third of a pitch below their tips: contact discs of that radius, all at the
    // hardness.
    let (tangent, depth) = (0.1, 1.0 / 3.0);
    let mut errors = Vec::new();
    for spacing in [12, 24, 48, 96] {
        let map = row_of_bumps(spacing, 96e-6, |r| -tangent * r);
        let plane = Control::Plane { height_m: -tangent * depth * 96e-6 };
        let solution = solve(&map, true, plane, Some(1.0));
        assert_eq!(solution.plastic_fraction(), solution.contact_fraction());
        assert!((solution.contact_fraction() / (PI * depth * depth) - 1.0).abs() < 4.0 / spacing as f64);
        let window = Window::new(2.0 * 96e-6, map.grid()).unwrap();
        let law = AdhesionPloughing { shear_strength_pa: 0.2 };
        let found = coefficients(&map, &solution, &window, &law);
        let error = found.iter().sum::<f64>() / found.len() as f64 - 0.2 - FRAC_2_PI * tangent;
        let relative = error / (FRAC_2_PI * tangent);
        println!("Δx/a = {:.4}: error {relative:.6}", 3.0 / spacing as f64);
        errors.push(relative.abs());
    }
    // Only cells next to the tip, a fraction (Δx/a)², have a wrong slope. Cells cut by the rim add noise.
    for (error, spacing) in errors.iter().zip([12.0_f64, 24.0, 48.0, 96.0]) {
        assert!(*error < 2.0 * (3.0 / spacing).powi(2), "{errors:?}");
    }
}
