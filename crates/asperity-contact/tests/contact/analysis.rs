//! Quantities derived from a solved contact, against closed forms, identities and dense algebra.

use std::f64::consts::{PI, TAU};

use asperity_base::map::{Grid, HeightMap};
use asperity_base::random;
use asperity_base::stats::{quantile_sorted, sorted_present};
use asperity_contact::exact::{Hertz, PerssonPressure, Westergaard};
use asperity_contact::{
    Body, Boundary, ContactError, ContactProblem, ContactStiffness, Control, Elastic, ElasticPair, HalfSpace, Motion,
    Neighbours, Orientation, Solution, Solver, StiffnessSolver, composite, spectral_rms_gradient,
};
use asperity_testing::{AlwaysCancelled, self_affine};
use ndarray::Array2;

const PERIODIC: Boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };

/// Depth of the paraboloids of radius 1 below their plane, and the radius √δ of the contact.
const DELTA_M: f64 = 0.01;
const RADIUS_M: f64 = 0.1;

fn solved(heights_m: &Array2<f64>, half_space: &HalfSpace, control: Control, hardness_pa: Option<f64>) -> Solution {
    let problem = ContactProblem::new(half_space, heights_m, control, hardness_pa).unwrap();
    let solution = Solver { tolerance: 1e-10, ..Solver::default() }.solve(&problem).unwrap();
    assert!(solution.converged(), "{:?} after {}", solution.residual(), solution.iterations());
    solution
}

fn stiffness(half_space: &HalfSpace, solution: &Solution) -> ContactStiffness {
    let stiffness = StiffnessSolver::default().solve(half_space, solution).unwrap();
    assert!(stiffness.converged, "{stiffness:?}");
    stiffness
}

/// Returns a paraboloid of radius 1, its summit in a cell centre, on an elastic square of E* = 1.
fn paraboloid(n: usize, side_m: f64) -> (HalfSpace, Array2<f64>) {
    let (grid, heights_m) = asperity_testing::paraboloid(n, side_m, 0.5);
    (HalfSpace::new(grid, 1.0, Boundary::Free).unwrap(), heights_m)
}

/// Returns a self-affine map scaled to a spectral rms gradient of 1 on the unit square.
fn rough(n: usize, sample: u64) -> Array2<f64> {
    let heights = self_affine(n, 3.0, &mut random::stream(5, "rough", sample));
    let gradient = spectral_rms_gradient(&heights, Grid::with_size(n, n, 1.0, 1.0).unwrap());
    heights / gradient
}

/// Returns the positive values in ascending order.
fn above_zero<'a>(values: impl Iterator<Item = &'a f64>) -> Vec<f64> {
    sorted_present(values.copied().filter(|value| *value > 0.0))
}

/// Returns the fraction of the cells whose value is at most `value`.
fn fraction_up_to(value: f64, cells: &Array2<f64>) -> f64 {
    cells.iter().filter(|own| **own <= value).count() as f64 / cells.len() as f64
}

#[test]
fn the_pressures_of_a_hertz_contact_grow_as_the_root_of_their_rank() {
    // p = p₀√(1 − r²/a²) is below p on the fraction p²/p₀² of the contact.
    let (half_space, heights) = paraboloid(256, 2.5 * RADIUS_M);
    let solution = solved(&heights, &half_space, Control::Penetration { metre: DELTA_M }, None);
    let p0 = Hertz::new(1.0, 1.0, Hertz::load_n(1.0, 1.0, DELTA_M)).max_pressure_pa;
    let pressures = above_zero(solution.pressure_pa().iter());
    // Of 32,700 cells in contact, 2 % lie in the edge, a ring one cell wide.
    for probability in [0.1, 0.25, 0.5, 0.75, 0.95, 1.0] {
        let wanted = p0 * f64::sqrt(probability);
        let found = quantile_sorted(&pressures, probability);
        assert!((found / wanted - 1.0).abs() < 0.01 / probability.sqrt(), "{probability}: {found} for {wanted}");
    }
    let mean = pressures.iter().sum::<f64>() / pressures.len() as f64;
    assert!((mean / (2.0 / 3.0 * p0) - 1.0).abs() < 0.02);
}

#[test]
fn the_gaps_around_a_hertz_contact_have_their_closed_form() {
    // g(r) = a²/πR [(r²/a² − 2) arccos(a/r) + √(r²/a² − 1)] (Johnson §4.2) at r > a, within the square: a fraction
    // πr²/4b² of the cells lies within r.
    let side = 4.0 * RADIUS_M;
    let (half_space, heights) = paraboloid(256, side);
    let solution = solved(&heights, &half_space, Control::Penetration { metre: DELTA_M }, None);
    let gaps = solution.gap_m();
    for ratio in [1.3_f64, 1.5, 1.8] {
        let terms = (ratio.powi(2) - 2.0) * (1.0 / ratio).acos() + (ratio.powi(2) - 1.0).sqrt();
        let gap = RADIUS_M.powi(2) / PI * terms;
        let wanted = PI * (ratio * RADIUS_M / side).powi(2);
        // A ring half a cell wide is 0.6 to 0.9 % of such discs.
        let found = fraction_up_to(gap, &gaps);
        assert!((found / wanted - 1.0).abs() < 0.01, "{ratio}: {found} for {wanted}");
    }
}

#[test]
fn in_complete_contact_persson_is_exact() {
    let n = 128;
    let grid = Grid::with_size(n, n, 1.0, 1.0).unwrap();
    let half_space = HalfSpace::new(grid, 2.0, PERIODIC).unwrap();
    let heights = rough(n, 0);
    let solution = solved(&heights, &half_space, Control::MeanPressure { pascal: 6.0 }, None);
    assert_eq!(solution.contact_fraction(), 1.0);
    let distribution = PerssonPressure::new(6.0, 2.0, 1.0, None);
    let variance = solution.pressure_pa().mapv(|p| (p - 6.0).powi(2)).mean().unwrap();
    assert!((variance.sqrt() / distribution.full_contact_std_pa - 1.0).abs() < 1e-6, "{variance}");
    // The distribution is normal. For some 500 independent cells (half a wave of 4 cells) the empirical one is within 2
    // %.
    let found = |p: f64| fraction_up_to(p, solution.pressure_pa());
    let distance = (0..200).map(|i| 0.06 * f64::from(i)).map(|p| (found(p) - distribution.cumulative(p)).abs());
    let distance = distance.fold(0.0, f64::max);
    println!("distance {distance:.4}");
    assert!(distance < 0.02, "{distance}");
}

#[test]
fn pressures_in_partial_contact_are_close_to_perssons_distribution() {
    // Not an identity: the theory is approximate in partial contact and underestimates the area.
    let n = 256;
    let half_space = HalfSpace::new(Grid::with_size(n, n, 1.0, 1.0).unwrap(), 1.0, PERIODIC).unwrap();
    for (mean_pressure, hardness_pa) in [(0.1, None), (0.4, None), (0.1, Some(1.0)), (0.4, Some(1.0))] {
        let control = Control::MeanPressure { pascal: mean_pressure };
        let solution = solved(&rough(n, 20), &half_space, control, hardness_pa);
        let distribution = PerssonPressure::new(mean_pressure, 1.0, 1.0, hardness_pa);
        let found = |p: f64| fraction_up_to(p, solution.pressure_pa());
        let distance = (0..100).map(|i| 0.03 * f64::from(i)).map(|p| (found(p) - distribution.cumulative(p)).abs());
        let distance = distance.fold(0.0, f64::max);
        let clusters = solution.clusters(Neighbours::Edges);
        println!(
            "p̄ = {mean_pressure}, {hardness_pa:?}: contact {:.4} ({:.4} in theory), plastic {:.4} ({:.4}), distance \
             {distance:.4}, {} clusters, largest {:.3}",
            solution.contact_fraction(),
            distribution.contact_fraction(),
            solution.plastic_fraction(),
            distribution.plastic_fraction(),
            clusters.count(),
            clusters.largest_fraction().unwrap()
        );
        assert!(distance < 0.1 && distribution.contact_fraction() < solution.contact_fraction(), "{distance}");
        let load: f64 = clusters.loads_n().iter().sum();
        assert!((load / solution.load_n() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_hertz_contact_stores_two_fifths_of_load_times_approach() {
    let (half_space, heights) = paraboloid(128, 2.5 * RADIUS_M);
    let solution = solved(&heights, &half_space, Control::Penetration { metre: DELTA_M }, None);
    let wanted = 0.4 * Hertz::load_n(1.0, 1.0, DELTA_M) * DELTA_M;
    assert!((solution.elastic_energy_j() / wanted - 1.0).abs() < 1e-3, "{}", solution.elastic_energy_j() / wanted);
    assert_eq!(solution.plastic_work_j(), 0.0);
}

/// Returns ∫ F dδ from first touch to `depth_m` by Simpson's rule in √δ.
fn work_of_pressing(depth_m: f64, load_n: impl Fn(f64) -> f64) -> f64 {
    let steps = 40;
    let weight = |i: usize| if i == 0 || i == steps { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    let top = depth_m.sqrt();
    let terms = (1..=steps).map(|i| {
        let root = top * i as f64 / steps as f64;
        weight(i) * 2.0 * root * load_n(root * root)
    });
    terms.sum::<f64>() * top / (3.0 * steps as f64)
}

#[test]
fn the_work_of_loading_is_elastic_energy_plus_plastic_work() {
    let p0 = Hertz::new(1.0, 1.0, Hertz::load_n(1.0, 1.0, DELTA_M)).max_pressure_pa;
    let (free, sphere) = paraboloid(48, 4.0 * RADIUS_M);
    let soft = Boundary::Periodic { mean_compliance_m_per_pa: 0.2 };
    let periodic = HalfSpace::new(Grid::with_size(48, 48, 1.0, 1.0).unwrap(), 1.0, soft).unwrap();
    for (half_space, heights, depth_m, hardness_pa) in [
        (&free, &sphere, DELTA_M, Some(0.4 * p0)),
        (&free, &sphere, DELTA_M, None),
        (&periodic, &rough(48, 3), 0.3, None),
        (&periodic, &rough(48, 3), 0.3, Some(0.6)),
    ] {
        let pressed = |metre: f64| solved(heights, half_space, Control::Penetration { metre }, hardness_pa);
        let work = work_of_pressing(depth_m, |depth_m| pressed(depth_m).load_n());
        let end = pressed(depth_m);
        let (stored, spent) = (end.elastic_energy_j(), end.plastic_work_j());
        println!("{work:.6e} = {stored:.6e} + {spent:.6e}, relative {:.1e}", (stored + spent) / work - 1.0);
        assert!(((stored + spent) / work - 1.0).abs() < 2e-3);
        assert_eq!(spent > 0.05 * work, hardness_pa.is_some());
    }
}

#[test]
fn a_hertz_contact_has_the_stiffness_of_its_circle() {
    // K = 2E*a. Cells in contact are counted whole, so K belongs to a circle larger by a fraction of a cell.
    let mut errors = Vec::new();
    for n in [64, 128, 256] {
        let (half_space, heights) = paraboloid(n, 2.5 * RADIUS_M);
        let solution = solved(&heights, &half_space, Control::Penetration { metre: DELTA_M }, None);
        let found = stiffness(&half_space, &solution);
        let radius = (solution.contact_fraction() * half_space.grid().area_m2() / PI).sqrt();
        let error = found.newton_per_m / (2.0 * RADIUS_M) - 1.0;
        println!("n = {n}: K {error:.2e}, radius {:.2e}, {} iterations", radius / RADIUS_M - 1.0, found.iterations);
        assert!((found.pascal_per_m * half_space.grid().area_m2() / found.newton_per_m - 1.0).abs() < 1e-14);
        assert!(found.iterations < 100);
        errors.push(error);
    }
    assert!(errors[2].abs() < 3e-3, "{errors:?}");
}

/// Returns a punch of height 1 on the cells where `inside` is true for (x, y), counted from the centre.
fn punch(n: usize, side_m: f64, inside: impl Fn(f64, f64) -> bool) -> (HalfSpace, Array2<f64>) {
    let grid = Grid::with_size(n, n, side_m, side_m).unwrap();
    let centre = 0.5 * side_m;
    let map = HeightMap::from_function(grid, |x, y| f64::from(u8::from(inside(x - centre, y - centre)))).unwrap();
    (HalfSpace::new(grid, 1.0, Boundary::Free).unwrap(), map.heights_m().clone())
}

#[test]
fn a_flat_punch_carries_its_stiffness_times_its_depth() {
    let (half_space, heights) = punch(128, 3.0, |x, y| x.hypot(y) < 1.0);
    let solution = solved(&heights, &half_space, Control::Penetration { metre: 1e-3 }, None);
    let cells = heights.sum();
    assert_eq!(solution.contact_fraction() * 128.0 * 128.0, cells);
    let found = stiffness(&half_space, &solution);
    println!("circle: K/2E*a = {:.5}, {} iterations", found.newton_per_m / 2.0, found.iterations);
    // The tolerance of the solution is relative to the rms height, some 450 times the depth.
    let rest = found.newton_per_m * 1e-3 / solution.load_n() - 1.0;
    assert!(rest.abs() < 1e-6, "{rest:e}");
    // The circle of equal area; the pressure at the edge is infinite, so the order is low.
    let radius = (cells * half_space.grid().cell_area_m2() / PI).sqrt();
    assert!((found.newton_per_m / (2.0 * radius) - 1.0).abs() < 0.01);
}

#[test]
fn a_wave_has_westergaards_stiffness() {
    // ḡ/h = 1 − s + s ln s with s = p̄/p* (it gives the published mean gaps), so K/A₀ = −dp̄/dḡ = πE*/(λ ln(1/s)).
    let gap = |s: f64| 1.0 - s + s * s.ln();
    assert!((gap(0.1) - 0.6697414907).abs() < 1e-10 && (gap(0.75) - 0.0342384457).abs() < 1e-10);
    let (n, h) = (1024, 0.01);
    let grid = Grid::new(n, 2, 1.0 / n as f64, 1.0 / n as f64).unwrap();
    let map = HeightMap::from_function(grid, |x, _| h * (TAU * (x - 0.25 / n as f64)).cos()).unwrap();
    // The mean compliance of the bulk does not matter.
    for compliance in [0.0, 0.3] {
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: compliance };
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        let full = Westergaard::new(1.0, h, 1.0, 0.0).full_contact_pressure_pa;
        for s in [0.1, 0.25, 0.5, 0.75] {
            let control = Control::MeanPressure { pascal: s * full };
            let solution = solved(map.heights_m(), &half_space, control, None);
            let found = stiffness(&half_space, &solution);
            let wanted = PI / (1.0 / s).ln();
            println!("s = {s}: {:.2e}, {} iterations", found.pascal_per_m / wanted - 1.0, found.iterations);
            // The width is resolved to one of 1024 cells.
            assert!((found.pascal_per_m / wanted - 1.0).abs() < 0.01, "{} for {wanted}", found.pascal_per_m);
        }
    }
}

/// Solves S_cc x = 1 by elimination, with S from unit pressures. Returns K in N/m over the cells whose pressure `moves`
/// accepts.
fn stiffness_by_elimination(half_space: &HalfSpace, solution: &Solution, moves: impl Fn(f64) -> bool) -> f64 {
    let points = half_space.grid().points();
    let cells: Vec<usize> =
        solution.pressure_pa().iter().enumerate().filter(|(_, p)| moves(**p)).map(|(i, _)| i).collect();
    let mut workspace = half_space.workspace();
    let mut rows: Vec<Vec<f64>> = cells
        .iter()
        .map(|cell| {
            let (mut unit, mut u) = (vec![0.0; points], vec![0.0; points]);
            unit[*cell] = 1.0;
            half_space.displace(&unit, &mut u, &mut workspace);
            cells.iter().map(|cell| u[*cell]).chain([1.0]).collect()
        })
        .collect();
    let n = rows.len();
    for i in 0..n {
        let pivot = rows[i].clone();
        for row in rows.iter_mut().skip(i + 1) {
            let factor = row[i] / pivot[i];
            row.iter_mut().zip(&pivot).skip(i).for_each(|(a, b)| *a -= factor * b);
        }
    }
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| rows[i][j] * x[j]).sum();
        x[i] = (rows[i][n] - known) / rows[i][i];
    }
    x.iter().sum::<f64>() * half_space.grid().cell_area_m2()
}

#[test]
fn the_stiffness_equals_dense_algebra() {
    let n = 20;
    let grid = Grid::with_size(n, n, 1.0, 0.7).unwrap();
    let heights = rough(n, 7);
    for boundary in [Boundary::Free, PERIODIC] {
        let half_space = HalfSpace::new(grid, 2.0, boundary).unwrap();
        for (mean_pressure, hardness_pa) in [(0.05, None), (0.5, None), (0.3, Some(0.7)), (1.2, None)] {
            let control = Control::MeanPressure { pascal: mean_pressure };
            let solution = solved(&heights, &half_space, control, hardness_pa);
            let upper = hardness_pa.unwrap_or(f64::INFINITY);
            assert_eq!(solution.plastic_fraction() > 0.05, hardness_pa.is_some());
            for (motion, upper) in [(Motion::Loading, upper), (Motion::Unloading, f64::INFINITY)] {
                let wanted = stiffness_by_elimination(&half_space, &solution, |p| p > 0.0 && p < upper);
                let solver = StiffnessSolver { motion, tolerance: 1e-10, max_iterations: 500 };
                let found = solver.solve(&half_space, &solution).unwrap();
                assert!(found.converged && found.residual <= 1e-10);
                assert!((found.newton_per_m / wanted - 1.0).abs() < 1e-12, "{boundary:?} {mean_pressure} {motion:?}");
                let quick = StiffnessSolver { motion, ..StiffnessSolver::default() };
                let quick = quick.solve(&half_space, &solution).unwrap();
                assert!((quick.newton_per_m / wanted - 1.0).abs() < 1e-12, "{}", quick.newton_per_m / wanted - 1.0);
            }
        }
    }
}

#[test]
fn the_stiffness_is_the_slope_of_load_over_approach() {
    let n = 64;
    let grid = Grid::with_size(n, n, 1.0, 1.0).unwrap();
    let heights = rough(n, 11);
    for (boundary, hardness_pa) in
        [(Boundary::Free, None), (Boundary::Free, Some(0.5)), (PERIODIC, None), (PERIODIC, Some(0.5))]
    {
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        let solver = Solver { tolerance: 1e-13, ..Solver::default() };
        let press = |pascal: f64| {
            let control = Control::MeanPressure { pascal };
            solver.solve(&ContactProblem::new(&half_space, &heights, control, hardness_pa).unwrap()).unwrap()
        };
        let (less, more) = (press(0.2 * (1.0 - 1e-5)), press(0.2 * (1.0 + 1e-5)));
        let slope = (more.load_n() - less.load_n()) / (less.plane_m() - more.plane_m());
        let found = stiffness(&half_space, &press(0.2)).newton_per_m;
        println!("{boundary:?} {hardness_pa:?}: {found:.6} for {slope:.6}");
        // The cells are the same except for a few of 4096 whose pressure is close to zero.
        assert!((found / slope - 1.0).abs() < 2e-3, "{found} for {slope}");
    }
}

#[test]
fn the_stiffness_of_a_rough_contact_grows_with_its_load() {
    // Not an identity: K ≈ F/(γ h_rms) with γ near one half at light loads (Akarapu, Sharp and Robbins, Phys. Rev.
    // Lett. 106 (2011) 204301, https://doi.org/10.1103/PhysRevLett.106.204301), within the variability of one small
    // map.
    let n = 256;
    let half_space = HalfSpace::new(Grid::with_size(n, n, 1.0, 1.0).unwrap(), 1.0, PERIODIC).unwrap();
    let heights = rough(n, 1);
    let rms_height_m = heights.mapv(|z| z * z).mean().unwrap().sqrt();
    for pascal in [0.002, 0.008, 0.03] {
        let solution = solved(&heights, &half_space, Control::MeanPressure { pascal }, None);
        let found = stiffness(&half_space, &solution);
        let ratio = found.newton_per_m * rms_height_m / solution.load_n();
        println!("p̄ = {pascal}: K h_rms/F = {ratio:.3}, {} iterations", found.iterations);
        assert!((1.5..3.0).contains(&ratio) && found.iterations < 50, "{ratio}");
    }
}

#[test]
fn complete_contact_has_infinite_stiffness_and_no_contact_has_none() {
    let n = 64;
    let grid = Grid::with_size(n, n, 1.0, 1.0).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, PERIODIC).unwrap();
    let heights = rough(n, 2);
    let at = |half_space: &HalfSpace, control, hardness| solved(&heights, half_space, control, hardness);
    let mut last = 0.0;
    for pascal in [0.01, 0.1, 0.5, 0.9, 1.1, 1.3] {
        let solution = at(&half_space, Control::MeanPressure { pascal }, None);
        let found = stiffness(&half_space, &solution);
        println!(
            "p̄ = {pascal}: contact {}, K {:e}, {} iterations",
            solution.contact_fraction(),
            found.newton_per_m,
            found.iterations
        );
        assert!(found.newton_per_m > 1.3 * last && found.iterations < 100, "{found:?}");
        last = found.newton_per_m;
    }
    let complete = at(&half_space, Control::MeanPressure { pascal: 5.0 }, None);
    assert_eq!(complete.contact_fraction(), 1.0);
    assert_eq!(stiffness(&half_space, &complete).newton_per_m, f64::INFINITY);
    let free = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    let apart = at(&free, Control::Plane { height_m: 9.0 }, None);
    assert_eq!(stiffness(&free, &apart).newton_per_m, 0.0);
    // On the free boundary complete contact has the stiffness of a square punch, 1.012 times 2E*√(A/π) (King, Int. J.
    // Solids Struct. 23 (1987) 1657).
    let complete = at(&free, Control::Plane { height_m: -9.0 }, None);
    assert_eq!(complete.contact_fraction(), 1.0);
    let ratio = stiffness(&free, &complete).newton_per_m / (2.0 / PI.sqrt());
    println!("square: {ratio:.4}");
    assert!((ratio / 1.012 - 1.0).abs() < 0.01, "{ratio}");
    let other = HalfSpace::new(Grid::with_size(32, 64, 1.0, 1.0).unwrap(), 1.0, PERIODIC).unwrap();
    let error = StiffnessSolver::default().solve(&other, &complete).unwrap_err();
    assert_eq!(error, ContactError::Shape { rows: 64, columns: 64, ny: 64, nx: 32 });
    let useless = StiffnessSolver { tolerance: 0.0, ..StiffnessSolver::default() };
    assert!(matches!(useless.solve(&free, &complete), Err(ContactError::Parameter { parameter: "tolerance", .. })));
    let hasty = StiffnessSolver { max_iterations: 1, ..StiffnessSolver::default() };
    assert!(!hasty.solve(&free, &complete).unwrap().converged);
    let stopped = StiffnessSolver::default().solve_with(&free, &complete, &AlwaysCancelled).unwrap();
    assert!(!stopped.converged && stopped.iterations == 0);
}

#[test]
fn two_spheres_touch_like_one_of_their_combined_curvature() {
    let (n, side) = (128, 0.25);
    let grid = Grid::with_size(n, n, side, side).unwrap();
    let (lower_radius, upper_radius) = (1.5, 3.0);
    // The upper summit is off the middle, so its position over the lower one depends on the orientation.
    let shift = 8.0 * grid.dx_m();
    let sphere = |radius: f64, centre_x: f64| {
        let height = |x: f64, y: f64| -((x - centre_x).powi(2) + (y - 0.5 * side).powi(2)) / (2.0 * radius);
        HeightMap::from_function(grid, height).unwrap()
    };
    let lower = sphere(lower_radius, 0.5 * side + shift);
    let upper = sphere(upper_radius, 0.5 * side - shift);
    let (steel, rubber) = (Elastic::new(2.0, 0.3).unwrap(), Elastic::new(0.5, 0.5).unwrap());
    let pair = ElasticPair::new(steel, rubber).unwrap();
    let modulus = 1.0 / ((1.0 - 0.09) / 2.0 + (1.0 - 0.25) / 0.5);
    assert!((pair.contact_modulus_pa() / modulus - 1.0).abs() < 1e-14);
    let half_space = HalfSpace::new(grid, pair.contact_modulus_pa(), Boundary::Free).unwrap();
    let radius = 1.0 / (1.0 / lower_radius + 1.0 / upper_radius);
    let load = Hertz::load_n(modulus, radius, 0.007);
    let hertz = Hertz::new(modulus, radius, load);
    let face = composite(&lower, &upper, Orientation::Mirrored).unwrap();
    let solution = solved(face.heights_m(), &half_space, Control::Load { newton: load }, None);
    assert!((solution.max_pressure_pa() / hertz.max_pressure_pa - 1.0).abs() < 0.01);
    assert!((solution.penetration_m() / hertz.approach_m - 1.0).abs() < 0.01);
    let area = solution.corrected_contact_fraction() * grid.area_m2();
    assert!(((area / PI).sqrt() / hertz.contact_radius_m - 1.0).abs() < 0.02);
    // Both surfaces together are displaced by u, the softer one more.
    let (down, up) = (pair.displacement_of(Body::Lower, &solution), pair.displacement_of(Body::Upper, &solution));
    assert!((&down + &up - solution.displacement_m()).iter().all(|rest| rest.abs() < 1e-16));
    let fraction = (1.0 - 0.09) / 2.0 * modulus;
    assert!((down[[60, 60]] / solution.displacement_m()[[60, 60]] / fraction - 1.0).abs() < 1e-13);
    // Aligned, the summits are s = 16 cells apart. The sum of both parabolas has the same curvature and is s²/2(R₁ +
    // R₂) lower.
    let laid = composite(&lower, &upper, Orientation::Aligned).unwrap();
    let highest = |map: &HeightMap| map.present_m().fold(f64::NEG_INFINITY, f64::max);
    let drop = (2.0 * shift).powi(2) / (2.0 * (lower_radius + upper_radius));
    assert!(((highest(&face) - highest(&laid)) / drop - 1.0).abs() < 0.01, "{drop}");
}

#[test]
fn a_map_and_its_cast_conform_completely() {
    let n = 32;
    let grid = Grid::with_size(n, n, 1.0, 1.0).unwrap();
    let map = HeightMap::new(grid, rough(n, 1)).unwrap();
    // A cast has valleys in place of summits and, seen from outside, its right on the left.
    let cast = Array2::from_shape_fn((n, n), |(row, column)| -map.heights_m()[[row, n - 1 - column]]);
    let cast = HeightMap::new(grid, cast).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    let pose = |laid| {
        let face = composite(&map, &cast, laid).unwrap();
        ContactProblem::new(&half_space, face.heights_m(), Control::MeanPressure { pascal: 0.1 }, None)
            .map(|p| p.rms_height_m())
    };
    assert_eq!(pose(Orientation::Mirrored), Err(ContactError::Flat));
    assert!(pose(Orientation::Aligned).is_ok());
    // Mean squares of two independent maps add, up to their accidental correlation.
    let other = HeightMap::new(grid, rough(n, 5)).unwrap();
    let face = composite(&map, &other, Orientation::default()).unwrap();
    let square = |map: &HeightMap| map.present_m().map(|z| z * z).sum::<f64>();
    let cross: f64 = map.present_m().zip(face.present_m()).map(|(z, sum)| 2.0 * z * (sum - z)).sum();
    assert!((square(&face) - square(&map) - square(&other) - cross).abs() < 1e-10 * square(&face));
}
