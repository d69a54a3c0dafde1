//! The contact solver against closed forms and against dense algebra.

use std::f64::consts::PI;

use asperity_base::fourier::{RealFft2, signed_index};
use asperity_base::map::{Grid, HeightMap};
use asperity_base::monitor::Silent;
use asperity_base::random;
use asperity_contact::exact::{Hertz, Westergaard, persson_contact_fraction};
use asperity_contact::{
    Base, Boundary, ContactError, ContactProblem, ContactWorkspace, Control, Elastic, HalfSpace, Layer, Solution,
    Solver, SolverStop, Substrate, love_coefficient,
};
use asperity_testing::{CAPPED_HERTZ, CancelAfter, CappedHertz, self_affine};
use ndarray::Array2;

fn solve(heights_m: &Array2<f64>, half_space: &HalfSpace, control: Control, hardness_pa: Option<f64>) -> Solution {
    let problem = ContactProblem::new(half_space, heights_m, control, hardness_pa).unwrap();
    let solution = Solver::default().solve(&problem).unwrap();
    assert!(solution.converged(), "{:?} after {}", solution.residual(), solution.iterations());
    solution
}

/// Returns a paraboloid of radius 1 on a square of side `side_m`, its summit `offset` cells from the centre.
fn paraboloid(n: usize, side_m: f64, offset: f64) -> (HalfSpace, Array2<f64>) {
    let (grid, heights_m) = asperity_testing::paraboloid(n, side_m, offset);
    (HalfSpace::new(grid, 1.0, Boundary::Free).unwrap(), heights_m)
}

fn rough(n: usize, sample: u64) -> Array2<f64> {
    self_affine(n, 3.0, &mut random::stream(5, "rough", sample))
}

#[test]
fn hertz_converges_at_second_order() {
    let delta = 0.01;
    let radius = f64::sqrt(delta);
    let load = Hertz::load_n(1.0, 1.0, delta);
    let hertz = Hertz::new(1.0, 1.0, load);
    let mut errors = Vec::new();
    for n in [128, 256, 512] {
        let (half_space, heights) = paraboloid(n, 2.5 * radius, 0.0);
        let solution = solve(&heights, &half_space, Control::Load { newton: load }, None);
        let p0_error = solution.max_pressure_pa() / hertz.max_pressure_pa - 1.0;
        let area = solution.corrected_contact_fraction() * half_space.grid().area_m2();
        let a_error = (area / PI).sqrt() / hertz.contact_radius_m - 1.0;
        let delta_error = solution.penetration_m() / hertz.approach_m - 1.0;
        println!("n = {n}: p0 {p0_error:.2e}, a {a_error:.2e}, approach {delta_error:.2e}");
        assert!(p0_error.abs() < 2.2e-4 * (128.0 / n as f64).powi(2), "p0: {p0_error}");
        assert!(a_error.abs() < 2e-3, "a: {a_error}");
        errors.push((p0_error.abs(), delta_error.abs()));
    }
    let order = (errors[0].0 / errors[2].0).log2() / 2.0;
    assert!((order - 2.0).abs() < 0.1, "observed order of p0 {order:.2} from {errors:?}");
    let order = (errors[0].1 / errors[2].1).log2() / 2.0;
    assert!((order - 2.0).abs() < 0.1, "observed order of the approach {order:.2} from {errors:?}");
}

/// Returns the mean error of the counted and of the corrected area of a paraboloid on `n` cells along a side, over positions of the
/// summit between the cells. The hardness and the load are those of the paraboloid at the depth 0.01.
fn errors_of_area(n: usize, hardness_pa: Option<f64>, newton: f64, area_m2: f64) -> [f64; 2] {
    errors_of_area_on(n, 0.4, Boundary::Free, hardness_pa, newton, area_m2)
}

fn errors_of_area_on(
    n: usize,
    side_m: f64,
    boundary: Boundary,
    hardness_pa: Option<f64>,
    newton: f64,
    area_m2: f64,
) -> [f64; 2] {
    const STEPS: usize = 6;
    let mut errors = [0.0; 2];
    let grid = Grid::with_size(n, n, side_m, side_m).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
    let summit_m = |step: usize| 0.5 * side_m + (step as f64 + 0.2) / STEPS as f64 * grid.dx_m();
    for (row, column) in (0..STEPS).flat_map(|row| (0..STEPS).map(move |column| (row, column))) {
        let (x0, y0) = (summit_m(column), summit_m(row));
        let map = HeightMap::from_function(grid, |x, y| -0.5 * ((x - x0).powi(2) + (y - y0).powi(2))).unwrap();
        let solution = solve(map.heights_m(), &half_space, Control::Load { newton }, hardness_pa);
        for (error, fraction) in
            errors.iter_mut().zip([solution.contact_fraction(), solution.corrected_contact_fraction()])
        {
            *error += (fraction * grid.area_m2() / area_m2 - 1.0) / (STEPS * STEPS) as f64;
        }
    }
    errors
}

#[test]
fn the_area_of_an_elastic_paraboloid_converges_at_second_order() {
    let delta = 0.01;
    let load = Hertz::load_n(1.0, 1.0, delta);
    let [coarse, fine] = [12, 48].map(|n| errors_of_area(n, None, load, PI * delta));
    println!("{coarse:?} {fine:?}");
    // Counting cells is of first order.
    assert!(((coarse[0] / fine[0]).log2() / 2.0 - 1.0).abs() < 0.15);
    assert!(coarse[1].abs() < 3e-3 && fine[1].abs() < 3e-4);
}

#[test]
fn the_area_of_a_lattice_of_elastic_paraboloids_has_less_than_a_thirtieth_of_the_bias_of_counting() {
    let (radius_m, side_m) = (0.07_f64, 0.96);
    let load = Hertz::load_n(1.0, 1.0, radius_m * radius_m);
    // The other contacts of the square lattice bend the surface by ρ²·F/(4πE*)·Σ1/R³ away from the flat, Σ1/R³ =
    // 9.0336/L³. This sharpens the paraboloid, so that the area falls by ⅔ of 2·9.0336/3π·(a/L)³.
    let sharpened = 2.0 / 3.0 * 2.0 * 9.0336 / (3.0 * PI) * (radius_m / side_m).powi(3);
    let area_m2 = PI * radius_m * radius_m * (1.0 - sharpened);
    let boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };
    for n in [64, 96, 160] {
        let [counted, corrected] = errors_of_area_on(n, side_m, boundary, None, load, area_m2);
        println!("{n}: {counted} {corrected}");
        assert!(corrected.abs() < counted / 30.0, "{n}: {corrected}, counted {counted}");
    }
}

#[test]
fn the_area_of_a_plastic_paraboloid_is_its_load_over_the_hardness_on_every_grid() {
    let delta = 0.01;
    for n in [12, 24, 48] {
        let [counted, corrected] = errors_of_area(n, Some(1e-6), 2.0 * PI * delta * 1e-6, 2.0 * PI * delta);
        println!("{n}: {counted} {corrected}");
        // The load is exact to the tolerance of the solver.
        assert!(corrected.abs() < 1e-7 && counted > 1e-4);
    }
}

#[test]
fn between_elastic_and_plastic_contact_the_area_of_a_paraboloid_is_within_two_percent_on_coarse_grids() {
    let delta = 0.01;
    let elastic = Hertz::load_n(1.0, 1.0, delta);
    let p0 = Hertz::new(1.0, 1.0, elastic).max_pressure_pa;
    for CappedHertz { hardness, load, area, .. } in CAPPED_HERTZ {
        for (n, most) in [(12, 0.01), (24, 0.02), (48, 0.02), (96, 0.01)] {
            let [counted, corrected] = errors_of_area(n, Some(hardness * p0), load * elastic, area * PI * delta);
            println!("H/p0 = {hardness}, {n}: {counted:.4} {corrected:.4}");
            assert!(corrected.abs() < most, "H/p0 = {hardness}, {n}: {corrected}, counted {counted}");
        }
    }
}

#[test]
fn a_hardness_lowers_the_load_of_a_hertz_contact_as_published() {
    let delta = 0.01;
    let p0 = Hertz::new(1.0, 1.0, Hertz::load_n(1.0, 1.0, delta)).max_pressure_pa;
    // A cell centre lies on the summit, so the prescribed depth is the depth of the paraboloid.
    let (half_space, heights) = paraboloid(256, 0.4, 0.5);
    for CappedHertz { hardness: ratio, load, area, load_tolerance } in CAPPED_HERTZ {
        let solution = solve(&heights, &half_space, Control::Penetration { metre: delta }, Some(ratio * p0));
        let load_ratio = solution.load_n() / Hertz::load_n(1.0, 1.0, delta);
        println!("H/p0 = {ratio}: load ratio {load_ratio:.5} for {load}");
        assert!((load_ratio - load).abs() < load_tolerance, "H/p0 = {ratio}: load {load_ratio}, wanted {load}");
        let cells = solution.contact_fraction() * half_space.grid().area_m2() / (PI * delta);
        let ring = 2.0 * half_space.grid().dx_m() / delta.sqrt();
        assert!((cells - area).abs() < 0.003 + area.sqrt() * ring, "H/p0 = {ratio}: area {cells}, wanted {area}");
        let plastic = solution.plastic_displacement_m();
        assert!(plastic.iter().zip(solution.pressure_pa()).all(|(u, p)| *u == 0.0 || *p == ratio * p0));
        assert!(plastic.iter().any(|u| *u > 0.0));
    }
}

#[test]
fn at_vanishing_hardness_a_paraboloid_touches_its_geometric_intersection() {
    // For H → 0 the area is 2πRδ and the load 2πRδH.
    let delta = 0.01;
    let (half_space, heights) = paraboloid(256, 0.4, 0.5);
    let hardness = 1e-6;
    let solution = solve(&heights, &half_space, Control::Penetration { metre: delta }, Some(hardness));
    let area = solution.contact_fraction() * half_space.grid().area_m2();
    assert!((area / (2.0 * PI * delta) - 1.0).abs() < 0.01, "{area}");
    assert!((solution.load_n() / (2.0 * PI * delta * hardness) - 1.0).abs() < 0.01);
}

#[test]
fn one_wave_has_the_westergaard_width() {
    let (n, h, wavelength) = (1024, 0.01, 1.0);
    let grid = Grid::new(n, 2, wavelength / n as f64, wavelength / n as f64).unwrap();
    // The crest is a quarter of a cell off a point. At a point of symmetry, widths could change only by two cells at a
    // time.
    let map = HeightMap::from_function(grid, |x, _| h * (2.0 * PI * (x - 0.25 / n as f64)).cos()).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }).unwrap();
    for (ratio, width, gap) in [
        (0.1, 0.2048327647, 0.6697414907),
        (0.25, 1.0 / 3.0, 0.4034264097),
        (0.5, 0.5, 0.1534264097),
        (0.75, 2.0 / 3.0, 0.0342384457),
    ] {
        let full = Westergaard::new(1.0, h, wavelength, 0.0).full_contact_pressure_pa;
        let exact = Westergaard::new(1.0, h, wavelength, ratio * full);
        assert!((exact.contact_fraction - width).abs() < 1e-9);
        let control = Control::MeanPressure { pascal: ratio * full };
        let solution = solve(map.heights_m(), &half_space, control, None);
        let found = solution.contact_fraction();
        assert!((found - width).abs() <= 1.0 / n as f64 + 1e-10, "{found} for {width}");
        assert!((solution.max_pressure_pa() / exact.max_pressure_pa - 1.0).abs() < 0.01);
        assert!((solution.mean_gap_m() / h - gap).abs() < 2.0 / n as f64, "{}", solution.mean_gap_m() / h);
        // A prescribed mean gap gives the same state.
        let by_gap = solve(map.heights_m(), &half_space, Control::MeanGap { metre: solution.mean_gap_m() }, None);
        assert!((by_gap.mean_pressure_pa() / (ratio * full) - 1.0).abs() < 1e-4, "{}", by_gap.mean_pressure_pa());
    }
}

#[test]
fn a_double_sinusoid_has_its_small_load_and_near_full_limits() {
    let (n, h) = (256, 0.01);
    let grid = Grid::with_size(n, n, 1.0, 1.0).unwrap();
    let map = HeightMap::from_function(grid, |x, y| h * (2.0 * PI * x).cos() * (2.0 * PI * y).cos()).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }).unwrap();
    let full = 2.0_f64.sqrt() * PI * h;
    let fraction = |ratio: f64| {
        let solution = solve(map.heights_m(), &half_space, Control::MeanPressure { pascal: ratio * full }, None);
        solution.corrected_contact_fraction()
    };
    // Discs of 19 cells' radius: half a ring of cells is 5 % of their area. The correction of edges reduces this error.
    let small = PI * (3.0 * 0.01 / (8.0 * PI)).powf(2.0 / 3.0);
    assert!((fraction(0.01) / small - 1.0).abs() < 0.03, "{} for {small}", fraction(0.01));
    // Gaps of 10 cells' radius: a ring of cells is 20 % of their area.
    let open = 3.0 / (2.0 * PI) * (1.0 - 0.98);
    assert!(((1.0 - fraction(0.98)) / open - 1.0).abs() < 0.2, "{} for {open}", 1.0 - fraction(0.98));
}

/// Computes the dense compliance matrix from the definitions, without a transform.
fn dense_compliance(grid: Grid, modulus_pa: f64, boundary: Boundary) -> Vec<Vec<f64>> {
    let (nx, ny) = (grid.nx(), grid.ny());
    let entry = |dx: isize, dy: isize| match boundary {
        Boundary::Free => {
            let (x, y) = (dx.unsigned_abs() as f64 * grid.dx_m(), dy.unsigned_abs() as f64 * grid.dy_m());
            love_coefficient(x, y, grid.dx_m(), grid.dy_m(), modulus_pa)
        }
        Boundary::Periodic { mean_compliance_m_per_pa } => {
            let mut sum = mean_compliance_m_per_pa;
            for ky in 0..ny {
                for kx in 0..nx {
                    let (qx, qy) = (signed_index(kx, nx) / grid.width_m(), signed_index(ky, ny) / grid.height_m());
                    let q = 2.0 * PI * qx.hypot(qy);
                    if q > 0.0 {
                        let turn = kx as f64 * dx as f64 / nx as f64 + ky as f64 * dy as f64 / ny as f64;
                        sum += 2.0 / (modulus_pa * q) * (2.0 * PI * turn).cos();
                    }
                }
            }
            sum / (nx * ny) as f64
        }
    };
    // Row i, column j depends only on the offset, so the table of offsets is computed once.
    let (span_x, span_y) = (2 * nx - 1, 2 * ny - 1);
    let table: Vec<f64> = (0..span_x * span_y)
        .map(|k| entry((k % span_x) as isize - nx as isize + 1, (k / span_x) as isize - ny as isize + 1))
        .collect();
    let offset = |i: usize, j: usize| {
        let (dx, dy) = (i % nx + nx - 1 - j % nx, i / nx + ny - 1 - j / nx);
        table[dy * span_x + dx]
    };
    (0..nx * ny).map(|i| (0..nx * ny).map(|j| offset(i, j)).collect()).collect()
}

#[test]
fn every_solution_satisfies_the_optimality_conditions_by_dense_algebra() {
    let n = 16;
    let grid = Grid::new(n, n, 1.0, 0.8).unwrap();
    let tolerance = 1e-8;
    for (sample, boundary) in [
        (0, Boundary::Free),
        (1, Boundary::Periodic { mean_compliance_m_per_pa: 3.0 }),
        (2, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }),
    ] {
        let half_space = HalfSpace::new(grid, 2.0, boundary).unwrap();
        let compliance = dense_compliance(grid, 2.0, boundary);
        let heights = rough(n, sample);
        let problem = ContactProblem::new(&half_space, &heights, Control::MeanPressure { pascal: 1.0 }, None).unwrap();
        let h_rms = problem.rms_height_m();
        let pressure = 0.2 * h_rms;
        for hardness in [None, Some(2.0 * pressure)] {
            for control in [
                Control::MeanPressure { pascal: pressure },
                Control::Load { newton: pressure * grid.area_m2() },
                Control::MeanGap { metre: 0.6 * h_rms },
                Control::Penetration { metre: 1.5 * h_rms },
                Control::Percentile { percent: 30.0 },
            ] {
                let overlap_control = matches!(control, Control::Penetration { .. } | Control::Percentile { .. });
                if overlap_control && boundary == (Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }) {
                    let refused = ContactProblem::new(&half_space, &heights, control, hardness).unwrap_err();
                    assert_eq!(refused, ContactError::Unbounded);
                    continue;
                }
                let problem = ContactProblem::new(&half_space, &heights, control, hardness).unwrap();
                let solution = Solver { tolerance, max_iterations: 2000 }.solve(&problem).unwrap();
                assert!(solution.converged(), "{control:?} {hardness:?} {:?}", solution.residual());
                check_by_definition(&compliance, &problem, &solution, tolerance);
            }
        }
    }
}

fn check_by_definition(compliance: &[Vec<f64>], problem: &ContactProblem<'_>, solution: &Solution, tolerance: f64) {
    let (control, h_rms) = (problem.control(), problem.rms_height_m());
    let p: Vec<f64> = solution.pressure_pa().iter().copied().collect();
    let z: Vec<f64> = problem.heights_m().iter().copied().collect();
    let u: Vec<f64> = compliance.iter().map(|row| row.iter().zip(&p).map(|(c, p)| c * p).sum()).collect();
    let upper = problem.hardness_pa().unwrap_or(f64::INFINITY);
    let mut energy_gap = 0.0;
    let (mut gap_sum, reported) = (0.0, solution.displacement_m());
    for i in 0..p.len() {
        let reported = reported[[i / problem.half_space().grid().nx(), i % problem.half_space().grid().nx()]];
        assert!((u[i] - reported).abs() < 1e-9 * h_rms, "{control:?}: {} and {reported}", u[i]);
        let gap = u[i] - z[i] + solution.plane_m();
        assert!((0.0..=upper).contains(&p[i]));
        assert!(p[i] >= upper || -gap <= 2.0 * tolerance * h_rms, "{control:?}: overlap {gap:e}");
        energy_gap += p[i] * gap.max(0.0);
        gap_sum += if p[i] > 0.0 { 0.0 } else { gap };
    }
    assert!(energy_gap <= 2.0 * tolerance * p.iter().sum::<f64>() * h_rms, "{control:?}: {energy_gap:e}");
    match control {
        Control::MeanPressure { pascal } => assert!((solution.mean_pressure_pa() / pascal - 1.0).abs() <= tolerance),
        Control::Load { newton } => assert!((solution.load_n() / newton - 1.0).abs() <= tolerance),
        // Overlaps within the tolerance count as zero gap in the solution and negative here.
        Control::MeanGap { metre } => {
            assert!((gap_sum / p.len() as f64 - metre).abs() <= 3.0 * tolerance * h_rms, "{gap_sum}");
        }
        Control::Penetration { metre } => assert!((solution.penetration_m() / metre - 1.0).abs() < 1e-12),
        _ => {
            let above = z.iter().filter(|z| **z > solution.plane_m()).count();
            assert_eq!(above, (0.3 * p.len() as f64).round() as usize);
        }
    }
}

#[test]
fn a_start_changes_the_iterations_and_not_the_solution() {
    let n = 64;
    let grid = Grid::new(n, n, 1.0, 1.0).unwrap();
    let heights = rough(n, 30);
    for boundary in [Boundary::Free, Boundary::Periodic { mean_compliance_m_per_pa: 5.0 }] {
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        let mut workspace = half_space.workspace();
        let slope = rms_slope(&heights);
        for (control, next) in [
            (Control::MeanPressure { pascal: 0.05 * slope }, Control::MeanPressure { pascal: 0.051 * slope }),
            (Control::Percentile { percent: 20.0 }, Control::Percentile { percent: 20.5 }),
        ] {
            for hardness in [None, Some(slope)] {
                let solver = Solver { tolerance: 1e-9, ..Solver::default() };
                let problem = ContactProblem::new(&half_space, &heights, control, hardness).unwrap();
                let cold = solver.solve_with(&problem, &mut workspace).unwrap();
                let again = solver.solve_from(&problem, Some(cold.pressure_pa()), &mut workspace, &Silent).unwrap();
                assert!(again.converged() && again.iterations() <= 2, "{control:?}: {}", again.iterations());
                let next = ContactProblem::new(&half_space, &heights, next, hardness).unwrap();
                let warm = solver.solve_from(&next, Some(cold.pressure_pa()), &mut workspace, &Silent).unwrap();
                let cold = solver.solve_with(&next, &mut workspace).unwrap();
                let difference =
                    warm.pressure_pa().iter().zip(cold.pressure_pa()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(warm.converged() && difference < 1e-6 * cold.max_pressure_pa(), "{difference:e}");
                // Zero, invalid values and a different shape.
                for start in [0.0, f64::NAN, f64::INFINITY] {
                    let start = Array2::from_elem(grid.shape(), start);
                    assert!(solver.solve_from(&next, Some(&start), &mut workspace, &Silent).unwrap().converged());
                }
                let start = Array2::zeros((n, n - 1));
                let refused = solver.solve_from(&next, Some(&start), &mut workspace, &Silent);
                assert!(matches!(refused, Err(ContactError::Shape { .. })));
            }
        }
    }
}

/// Returns the root-mean-square slope by forward differences on a periodic map.
fn rms_slope(heights: &Array2<f64>) -> f64 {
    let (ny, nx) = heights.dim();
    let mut sum = 0.0;
    for ((i, j), z) in heights.indexed_iter() {
        sum += (heights[[i, (j + 1) % nx]] - z).powi(2) + (heights[[(i + 1) % ny, j]] - z).powi(2);
    }
    (sum / heights.len() as f64).sqrt()
}

#[test]
fn a_cancelled_solve_reports_it_and_returns_its_state() {
    let n = 64;
    let half_space = HalfSpace::new(Grid::new(n, n, 1.0, 1.0).unwrap(), 1.0, Boundary::Free).unwrap();
    let heights = rough(n, 31);
    let pascal = 0.05 * rms_slope(&heights);
    let metre = 0.5 * heights.std(0.0);
    // On a periodic patch with plastic cells a search finds the plane of a mean gap, starting from the elastic contact.
    let periodic = Boundary::Periodic { mean_compliance_m_per_pa: 1.0 };
    let other = HalfSpace::new(half_space.grid(), 1.0, periodic).unwrap();
    let problem = ContactProblem::new(&other, &heights, Control::MeanGap { metre }, Some(10.0 * pascal)).unwrap();
    for patience in [3, 8, 14] {
        let watch = CancelAfter::new(patience);
        let solution = Solver::default().solve_from(&problem, None, &mut other.workspace(), &watch).unwrap();
        assert_eq!(solution.stop_reason(), SolverStop::Cancelled);
        assert!(solution.load_n() > 0.0, "after {patience} questions");
    }
    for control in [Control::MeanPressure { pascal }, Control::Percentile { percent: 10.0 }, Control::MeanGap { metre }]
    {
        let problem = ContactProblem::new(&half_space, &heights, control, None).unwrap();
        let solution =
            Solver::default().solve_from(&problem, None, &mut half_space.workspace(), &CancelAfter::new(3)).unwrap();
        assert_eq!(solution.stop_reason(), SolverStop::Cancelled, "{control:?}");
        assert!(!solution.converged() && solution.pressure_pa().iter().all(|p| *p >= 0.0 && p.is_finite()));
        if control == (Control::MeanPressure { pascal }) {
            assert_eq!(solution.iterations(), 3);
            assert!((solution.mean_pressure_pa() / pascal - 1.0).abs() < 1e-12);
            assert!(solution.residual().worst() > 1e-8 && solution.residual().worst().is_finite());
        }
    }
}

#[test]
fn a_workspace_of_another_half_space_changes_nothing() {
    let n = 64;
    let grid = Grid::new(n, n, 1.0, 1.0).unwrap();
    let heights = rough(n, 50);
    let pascal = 0.05 * rms_slope(&heights);
    let material = Elastic { youngs_modulus_pa: 1.0, poisson_ratio: 0.2 };
    let layer = Substrate::Layer(Layer { thickness_m: 3.0, material, base: Base::Rigid });
    let periodic = Boundary::Periodic { mean_compliance_m_per_pa: 1.0 };
    let mut half_spaces = Vec::new();
    for substrate in [Substrate::HalfSpace { modulus_pa: 1.0 }, layer] {
        for boundary in [periodic, Boundary::Free] {
            half_spaces.push(HalfSpace::with_substrate(substrate, grid, boundary).unwrap());
        }
    }
    half_spaces.push(HalfSpace::new(Grid::new(n, n, 1.0, 0.5).unwrap(), 1.0, periodic).unwrap());
    let mut shared = half_spaces[0].workspace();
    for half_space in half_spaces.iter().chain(half_spaces.iter().rev()) {
        for control in [Control::MeanPressure { pascal }, Control::Percentile { percent: 10.0 }] {
            for hardness in [None, Some(8.0 * pascal)] {
                let problem = ContactProblem::new(half_space, &heights, control, hardness).unwrap();
                let fresh = Solver::default().solve(&problem).unwrap();
                let reused = Solver::default().solve_with(&problem, &mut shared).unwrap();
                assert!(reused.converged());
                assert_eq!(fresh.pressure_pa(), reused.pressure_pa());
            }
        }
        let p: Vec<f64> = heights.iter().copied().collect();
        let displaced = |workspace: &mut ContactWorkspace| {
            let mut u = vec![0.0; p.len()];
            half_space.displace(&p, &mut u, workspace);
            u
        };
        assert_eq!(displaced(&mut shared), displaced(&mut half_space.workspace()));
    }
}

#[test]
fn heights_and_layers_without_significant_digits_are_refused() {
    let grid = Grid::new(8, 8, 1.0, 1.0).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    let heights = random::standard_normal(&mut random::stream(7, "huge", 0), 64);
    let heights = Array2::from_shape_vec((8, 8), heights).unwrap() * 1e155;
    let problem = ContactProblem::new(&half_space, &heights, Control::MeanPressure { pascal: 1.0 }, None);
    assert!(matches!(problem, Err(ContactError::Parameter { parameter: "rms height", .. })));
    // The displacement of an incompressible layer falls with the third power of its thickness, below the error of Love's
    // coefficients.
    let layer = |thickness_m: f64, poisson_ratio: f64| {
        let material = Elastic { youngs_modulus_pa: 1.0, poisson_ratio };
        HalfSpace::with_substrate(
            Substrate::Layer(Layer { thickness_m, material, base: Base::Rigid }),
            grid,
            Boundary::Free,
        )
    };
    assert!(layer(0.2, 0.5).is_ok() && layer(0.01, 0.3).is_ok());
    assert!(matches!(layer(1e-3, 0.5), Err(ContactError::Parameter { .. })));
}

#[test]
fn at_the_median_the_free_boundary_touches_at_most_half() {
    // The plane overlaps exactly half of the heights, and elastic displacement can only reduce the contact.
    for sample in 0..5 {
        let n = 32;
        let grid = Grid::new(n, n, 1.0, 1.0).unwrap();
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
        let heights = rough(n, 10 + sample);
        let solution = solve(&heights, &half_space, Control::Percentile { percent: 50.0 }, None);
        let above = heights.iter().filter(|z| **z > solution.plane_m()).count();
        assert_eq!(above, n * n / 2);
        assert!(solution.contact_fraction() <= 0.5 && solution.contact_fraction() > 0.0);
    }
}

#[test]
fn a_rigid_plastic_solid_under_load_yields_at_its_highest_points() {
    // For H/E* → 0 elastic displacement vanishes, and the plane cuts off as many points as carry the load.
    let n = 32;
    let grid = Grid::new(n, n, 1.0, 1.0).unwrap();
    let heights = random::standard_normal(&mut random::stream(7, "plastic", 0), n * n);
    let heights = Array2::from_shape_vec((n, n), heights).unwrap();
    for boundary in [Boundary::Free, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }] {
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        for hardness in [1e-4, 1e-6, 1e-10] {
            let control = Control::MeanPressure { pascal: 0.06 * hardness };
            let solution = solve(&heights, &half_space, control, Some(hardness));
            let carrying = 0.06 * (n * n) as f64;
            assert!((solution.plastic_fraction() * (n * n) as f64 - carrying).abs() <= 1.0);
            let mut sorted: Vec<f64> = heights.iter().copied().collect();
            sorted.sort_by(|a, b| b.total_cmp(a));
            let lowest = heights.iter().zip(solution.pressure_pa()).filter(|(_, p)| **p == hardness).map(|(z, _)| *z);
            assert!(lowest.fold(f64::INFINITY, f64::min) >= sorted[carrying as usize]);
        }
    }
}

#[test]
fn rough_contact_lies_between_persson_and_the_asperity_models() {
    let n = 256;
    let grid = Grid::with_size(n, n, 1.0, 1.0).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }).unwrap();
    let heights = rough(n, 20);
    let mut slope2 = 0.0;
    for i in 0..n {
        for j in 0..n {
            let dx = heights[[i, (j + 1) % n]] - heights[[i, j]];
            let dy = heights[[(i + 1) % n, j]] - heights[[i, j]];
            slope2 += dx * dx + dy * dy;
        }
    }
    // The mean of squares is over n² cells and differences are over 1/n, so the factors cancel.
    let gradient = slope2.sqrt();
    let load = 0.03;
    let solution = solve(&heights, &half_space, Control::MeanPressure { pascal: load * gradient }, None);
    let persson = persson_contact_fraction(load, 1.0, 1.0);
    let asperities = (2.0 * PI).sqrt() * load;
    let found = solution.corrected_contact_fraction();
    println!("{persson} < {found} < {asperities}, {} iterations", solution.iterations());
    assert!(persson < found && found < asperities, "{persson} < {found} < {asperities}");
}

#[test]
fn a_large_map_is_solved_equally_on_any_number_of_threads_and_by_another_operator() {
    // Enough cells for the solver to use several threads, in rows that do not fill the last slab.
    let n = 270;
    let heights = rough(n, 3);
    let grid = Grid::with_size(n, n, 1.0, 1.0).unwrap();
    for (boundary, control, hardness_pa) in [
        (Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }, Control::MeanPressure { pascal: 0.02 }, None),
        (Boundary::Free, Control::Percentile { percent: 10.0 }, Some(0.3)),
    ] {
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| solve(&heights, &half_space, control, hardness_pa))
        };
        let (one, three) = (on(1), on(3));
        assert_eq!(one.pressure_pa(), three.pressure_pa());
        assert_eq!((one.iterations(), one.residual()), (three.iterations(), three.residual()));
        // The gap is zero in contact, by a transform that the solver does not use.
        let torus = if boundary == Boundary::Free { 2 * n } else { n };
        let fft = RealFft2::new(torus, torus);
        let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
        let mut u = vec![0.0; n * n];
        let kernel = |x: f64, y: f64| love_coefficient(x / n as f64, y / n as f64, 1.0 / n as f64, 1.0 / n as f64, 1.0);
        let mut symbol = fft.spectrum();
        let wrapped: Vec<f64> = (0..torus * torus)
            .map(|i| kernel(signed_index(i % torus, torus).abs(), signed_index(i / torus, torus).abs()))
            .collect();
        fft.forward(&wrapped, &mut symbol, &mut work);
        let p: Vec<f64> = one.pressure_pa().iter().copied().collect();
        fft.forward_padded(&p, n, n, &mut spectrum, &mut work);
        for (place, value) in spectrum.iter_mut().enumerate() {
            let q = std::f64::consts::TAU * ((place / torus) as f64).hypot(signed_index(place % torus, torus));
            *value *= match boundary {
                Boundary::Free => symbol[place].re,
                Boundary::Periodic { .. } => {
                    if place == 0 {
                        0.0
                    } else {
                        2.0 / q
                    }
                }
            };
        }
        fft.inverse_cropped(&mut spectrum, &mut u, n, n, &mut work);
        let rms_m = heights.std(0.0);
        for ((u, z), p) in u.iter().zip(&heights).zip(&p) {
            let gap = u - z + one.plane_m();
            if *p > 0.0 && hardness_pa.is_none_or(|hardness_pa| *p < hardness_pa) {
                assert!(gap.abs() < 1e-6 * rms_m, "{gap:e} at {p:e}");
            } else if *p == 0.0 {
                assert!(gap > -1e-7 * rms_m, "{gap:e}");
            }
        }
    }
}

#[test]
fn invalid_problems_are_refused_with_their_values() {
    let grid = Grid::new(4, 4, 1.0, 1.0).unwrap();
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    let heights = random::standard_normal(&mut random::stream(6, "bad", 0), 16);
    let heights = Array2::from_shape_vec((4, 4), heights).unwrap();
    let refuse = |heights: &Array2<f64>, control, hardness| {
        ContactProblem::new(&half_space, heights, control, hardness).unwrap_err()
    };
    let penetration = Control::Penetration { metre: -1.0 };
    assert!(matches!(refuse(&heights, penetration, None), ContactError::Parameter { value: -1.0, .. }));
    let percentile = Control::Percentile { percent: 101.0 };
    assert!(matches!(refuse(&heights, percentile, None), ContactError::Parameter { value: 101.0, .. }));
    let pressure = Control::MeanPressure { pascal: 2.0 };
    let overloaded = ContactError::Overloaded { mean_pressure_pa: 2.0, hardness_pa: 2.0 };
    assert_eq!(refuse(&heights, pressure, Some(2.0)), overloaded);
    assert_eq!(refuse(&Array2::from_elem((4, 4), 0.3), pressure, None), ContactError::Flat);
    let mut holes = heights.clone();
    holes[[1, 2]] = f64::NAN;
    assert_eq!(refuse(&holes, pressure, None), ContactError::Missing { missing: 1, points: 16 });
    assert!(HalfSpace::new(grid, -1.0, Boundary::Free).is_err());
}
