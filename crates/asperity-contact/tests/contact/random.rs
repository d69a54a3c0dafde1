//! The contact solver on random problems; each solution is checked from its pressure alone.

use asperity_base::map::Grid;
use asperity_base::random;
use asperity_contact::{Boundary, ContactProblem, Control, HalfSpace, Solution, Solver, SolverStop};
use asperity_testing::{Choices, filtered_noise};
use ndarray::Array2;

use crate::contact_check::{Operator, energy, evaluate};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    SelfAffine,
    Gaussian,
    Bump,
    RoughBump,
    Sinusoid,
    WhiteNoise,
    Step,
    Plateaus,
    Checkerboard,
    Spikes,
    Pit,
}

const KINDS: [Kind; 11] = [
    Kind::SelfAffine,
    Kind::Gaussian,
    Kind::Bump,
    Kind::RoughBump,
    Kind::Sinusoid,
    Kind::WhiteNoise,
    Kind::Step,
    Kind::Plateaus,
    Kind::Checkerboard,
    Kind::Spikes,
    Kind::Pit,
];

/// Returns heights of unit standard deviation.
fn surface(choices: &mut Choices, kind: Kind, grid: Grid) -> Array2<f64> {
    let (nx, ny) = (grid.nx(), grid.ny());
    let (x0, y0, waves) = (choices.between(0.2, 0.8), choices.between(0.2, 0.8), choices.one_of(&[1.0, 2.0, 5.0]));
    let hurst = choices.between(0.3, 0.9);
    let at = |i: usize| ((i % nx) as f64 / nx as f64, (i / nx) as f64 / ny as f64);
    let bump = |i: usize| -((at(i).0 - x0).powi(2) + (at(i).1 - y0).powi(2));
    let white = random::standard_normal(&mut choices.stream, grid.points());
    let mut z: Vec<f64> = match kind {
        Kind::SelfAffine => {
            filtered_noise(grid, &mut choices.stream, |qx, qy| qx.hypot(qy).max(2.0).powf(-1.0 - hurst))
        }
        Kind::Gaussian => filtered_noise(grid, &mut choices.stream, |qx, qy| (-(qx * qx + qy * qy) / 144.0).exp()),
        Kind::Bump => (0..grid.points()).map(bump).collect(),
        Kind::RoughBump => (0..grid.points()).map(|i| bump(i) + 0.02 * white[i]).collect(),
        Kind::Sinusoid => {
            (0..grid.points()).map(|i| (std::f64::consts::TAU * (waves * at(i).0 + at(i).1)).cos()).collect()
        }
        Kind::WhiteNoise => white,
        Kind::Step => (0..grid.points()).map(|i| f64::from(at(i).0 < x0) + 0.01 * white[i]).collect(),
        Kind::Plateaus => white.iter().map(|z| z.round()).collect(),
        Kind::Checkerboard => (0..grid.points()).map(|i| ((i % nx + i / nx) % 2) as f64).collect(),
        Kind::Spikes => white.iter().map(|z| z.powi(5)).collect(),
        Kind::Pit => (0..grid.points()).map(|i| if i == grid.points() / 3 { -1.0 } else { 0.0 }).collect(),
    };
    let mean = z.iter().sum::<f64>() / z.len() as f64;
    let rms = (z.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / z.len() as f64).sqrt();
    z.iter_mut().for_each(|z| *z = (*z - mean) / rms);
    Array2::from_shape_vec((ny, nx), z).unwrap()
}

const SIZES: [(usize, usize); 16] = [
    (8, 8),
    (9, 8),
    (15, 15),
    (16, 16),
    (17, 13),
    (23, 31),
    (32, 32),
    (33, 32),
    (31, 31),
    (64, 64),
    (96, 24),
    (61, 16),
    (12, 40),
    (256, 4),
    (4, 100),
    (48, 96),
];

/// Returns a half-space, heights, control and hardness. Lengths, heights and moduli have different scales.
fn random_problem(choices: &mut Choices, kind: Kind) -> (HalfSpace, Array2<f64>, Control, Option<f64>) {
    let (nx, ny) = choices.one_of(&SIZES);
    let aspect = choices.one_of(&[1.0, 1.0, 1.0, 2.0, 0.3, 8.0, 64.0, 1.0 / 64.0]);
    let (pitch, modulus, rms) = (choices.decades(-7.0, 0.0), choices.decades(0.0, 12.0), choices.decades(-9.0, 1.0));
    let grid = Grid::new(nx, ny, pitch, pitch * aspect).unwrap();
    let offset = choices.one_of(&[0.0, 0.0, 1.0, -1e3]);
    let heights = surface(choices, kind, grid).mapv(|z| rms * (z + offset));
    // Approximate pressure that flattens a wave with the surface's curvature.
    let full = modulus * rms / grid.dx_m().min(grid.dy_m()) / 8.0;
    let free = choices.one_of(&[true, false]);
    let control = match choices.one_of(&[0, 0, 0, 1, 2, 3, 4]) {
        0 => Control::MeanPressure { pascal: full * choices.decades(-4.0, 0.5) },
        1 => Control::Load { newton: full * choices.decades(-3.0, 0.0) * grid.area_m2() },
        2 => Control::Penetration { metre: rms * choices.decades(-2.0, 0.7) },
        3 => Control::Percentile { percent: choices.between(0.1, 80.0) },
        _ => Control::MeanGap { metre: rms * choices.decades(-2.0, 0.6) },
    };
    let boundary = if free {
        Boundary::Free
    } else {
        let usual = HalfSpace::default_mean_compliance_m_per_pa(grid, modulus);
        let ratio =
            if control.prescribes_plane() { choices.decades(-2.0, 2.0) } else { choices.one_of(&[0.0, 0.0, 1.0]) };
        Boundary::Periodic { mean_compliance_m_per_pa: ratio * usual }
    };
    let mean = match control {
        Control::MeanPressure { pascal } => Some(pascal),
        Control::Load { newton } => Some(newton / grid.area_m2()),
        _ => None,
    };
    let hardness = match (choices.one_of(&[0, 0, 1]), mean) {
        (0, _) => None,
        (_, Some(mean)) => Some(mean * (1.0 + choices.decades(-6.0, 4.0))),
        (_, None) => Some(full * choices.decades(-5.0, 2.0)),
    };
    (HalfSpace::new(grid, modulus, boundary).unwrap(), heights, control, hardness)
}

/// Creates and solves one random problem and passes it on with its name.
fn solve_random(
    stage: &str,
    sample: u64,
    solver: Solver,
    check: impl FnOnce(&ContactProblem<'_>, &Solution, &Operator, &str),
) {
    let mut choices = Choices::new(11, stage, sample);
    let kind = KINDS[sample as usize % KINDS.len()];
    let (half_space, heights, control, hardness) = random_problem(&mut choices, kind);
    let problem = ContactProblem::new(&half_space, &heights, control, hardness).unwrap();
    let solution = solver.solve(&problem).unwrap();
    let operator = Operator::new(half_space.grid(), half_space.modulus_pa(), half_space.boundary());
    let name = format!(
        "{sample}: {kind:?} {:?} {:?} {control:?} H {hardness:?}: {:?} after {}, {:?}",
        half_space.grid(),
        half_space.boundary(),
        solution.stop_reason(),
        solution.iterations(),
        solution.residual()
    );
    check(&problem, &solution, &operator, &name);
}

#[test]
fn random_problems_are_solved_and_their_residuals_are_correct() {
    let solver = Solver::default();
    for sample in 0..330 {
        solve_random("contact", sample, solver, |problem, solution, operator, name| {
            assert!(solution.converged(), "{name}");
            let found = evaluate(operator, problem, solution);
            // Two transforms of different length differ only by rounding.
            let bound = solver.tolerance + 1e-11;
            assert!(found.frank_wolfe <= bound && found.overlap <= bound, "{name} {found:?}");
            assert!(found.prescribed <= bound, "{name} {found:?}");
            let upper = problem.hardness_pa().unwrap_or(f64::INFINITY);
            assert!(solution.pressure_pa().iter().all(|p| (0.0..=upper).contains(p)), "{name}");

            // The energy is at most that of a uniform pressure, and at most that of zero pressure.
            let z: Vec<f64> = problem.heights_m().iter().copied().collect();
            let start = problem.mean_pressure_pa().unwrap_or(0.0);
            if problem.mean_pressure_pa().is_some() {
                let uniform = vec![start; z.len()];
                let energy_at_start = energy(&uniform, &operator.displace(&uniform), &z, problem.mean_height_m());
                assert!(found.energy <= energy_at_start, "{name}: {} from {energy_at_start}", found.energy);
            } else if problem.control().prescribes_plane() {
                assert!(found.energy <= 0.0, "{name}: {}", found.energy);
            }
        });
    }
}

#[test]
fn rounding_errors_of_pressure_are_no_contact() {
    // The problems of the first 77,345 in which rounding left a pressure where the surfaces are apart.
    for sample in [6955, 13_863, 16_128, 38_702, 44_510, 56_421, 68_181, 75_410, 76_879, 77_344] {
        let mut choices = Choices::new(11, "rounding", sample);
        let (nx, ny) = choices.one_of(&[(8, 8), (9, 8), (15, 15), (17, 13), (13, 26), (12, 20), (5, 30)]);
        let grid = Grid::new(nx, ny, 1.0, choices.decades(-0.5, 0.5)).unwrap();
        let heights = surface(&mut choices, KINDS[sample as usize % KINDS.len()], grid);
        let control = Control::Penetration { metre: choices.decades(-2.0, 0.7) };
        let hardness = choices.decades(-5.0, 0.0);
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
        let problem = ContactProblem::new(&half_space, &heights, control, Some(hardness)).unwrap();
        let solution = Solver::default().solve(&problem).unwrap();
        let largest = solution.pressure_pa().iter().copied().fold(0.0, f64::max);
        let carries = |p: &f64| *p == 0.0 || *p >= f64::EPSILON * largest;
        assert!(solution.converged() && solution.pressure_pa().iter().all(carries), "{sample}");
    }
}

#[test]
#[ignore = "slow"]
fn no_iteration_raises_the_energy() {
    for sample in 0..33 {
        let mut last = f64::INFINITY;
        for max_iterations in 0..40 {
            let solver = Solver { tolerance: 1e-12, max_iterations };
            solve_random("energy", sample, solver, |problem, solution, operator, name| {
                // Under a mean gap, neither load nor plane is fixed during the iteration.
                if !matches!(problem.control(), Control::MeanGap { .. }) {
                    let energy = evaluate(operator, problem, solution).energy;
                    assert!(energy <= last + 1e-12 * energy.abs(), "{name}: {energy} after {last}");
                    last = energy;
                }
            });
        }
    }
}

#[test]
fn reported_convergence_is_correct_even_if_rounding_prevents_it() {
    // Loads, planes, gaps and mean compliances far beyond the resolution of double precision at these tolerances. The
    // solver may give up and must then report it.
    let mut stops = [0_usize; 3];
    for sample in 0..220 {
        let mut choices = Choices::new(12, "extreme", sample);
        let kind = KINDS[sample as usize % KINDS.len()];
        let (nx, ny) = choices.one_of(&[(8, 8), (9, 15), (32, 16), (64, 4)]);
        let grid = Grid::new(nx, ny, 1.0, choices.one_of(&[1.0, 64.0])).unwrap();
        let offset = choices.one_of(&[0.0, 1e6, 1e12]);
        let heights = surface(&mut choices, kind, grid).mapv(|z| z + offset);
        let control = match choices.one_of(&[0, 1, 2]) {
            0 => Control::MeanPressure { pascal: choices.decades(-20.0, 14.0) },
            1 => Control::Penetration { metre: choices.decades(-14.0, 14.0) },
            _ => Control::MeanGap { metre: choices.decades(-18.0, 14.0) },
        };
        let boundary = match choices.one_of(&[true, false]) {
            true => Boundary::Free,
            false => Boundary::Periodic { mean_compliance_m_per_pa: choices.decades(-12.0, 12.0) },
        };
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        let hardness = match (choices.one_of(&[true, false]), control) {
            (true, _) => None,
            (false, Control::MeanPressure { pascal }) => Some(pascal * (1.0 + choices.decades(-15.0, 15.0))),
            (false, _) => Some(choices.decades(-15.0, 15.0)),
        };
        let Ok(problem) = ContactProblem::new(&half_space, &heights, control, hardness) else {
            continue;
        };
        let tolerance = choices.one_of(&[1e-6, 1e-10, 1e-16]);
        let solution = Solver { tolerance, max_iterations: 400 }.solve(&problem).unwrap();
        let name = format!("{sample}: {kind:?} {boundary:?} {control:?} H {hardness:?} offset {offset}, {solution:?}");
        let upper = hardness.unwrap_or(f64::INFINITY);
        assert!(solution.pressure_pa().iter().all(|p| (0.0..=upper).contains(p)), "{name}");
        stops[solution.stop_reason() as usize] += 1;
        if solution.converged() {
            assert!(solution.residual().worst() <= tolerance, "{name}");
            let found = evaluate(&Operator::new(grid, 1.0, boundary), &problem, &solution);
            // The rounding errors of the two evaluations scale with the displacement and with the heights.
            let displacement = solution.displacement_m().iter().map(|u| u.abs()).fold(0.0, f64::max);
            let rounding = 1e-15 * (displacement + 2.0 * solution.plane_m().abs() + offset);
            let gap_rounding = match control {
                Control::MeanGap { metre } => rounding / metre,
                _ => 1e-12,
            };
            let bound = tolerance + 20.0 * rounding;
            assert!(found.frank_wolfe <= bound && found.overlap <= bound, "{name} {found:?}");
            assert!(found.prescribed <= bound + gap_rounding, "{name} {found:?}");
        }
    }
    println!("converged, precision limit, iteration limit: {stops:?}");
    assert!(stops[SolverStop::Converged as usize] > 60 && stops[SolverStop::PrecisionLimit as usize] > 20, "{stops:?}");
}

#[test]
fn scaling_by_powers_of_two_changes_only_exponents() {
    for sample in 0..66 {
        let mut choices = Choices::new(13, "units", sample);
        let (half_space, heights, control, hardness) =
            random_problem(&mut choices, KINDS[sample as usize % KINDS.len()]);
        let problem = ContactProblem::new(&half_space, &heights, control, hardness).unwrap();
        let solution = Solver::default().solve(&problem).unwrap();
        // Heights times s, lengths times l, moduli times t: pressures scale as ts/l.
        let (s, l, t) = (2.0_f64.powi(-31), 2.0_f64.powi(-13), 2.0_f64.powi(37));
        let (grid, pressure) = (half_space.grid(), t * s / l);
        let scaled_grid = Grid::new(grid.nx(), grid.ny(), l * grid.dx_m(), l * grid.dy_m()).unwrap();
        let boundary = match half_space.boundary() {
            Boundary::Free => Boundary::Free,
            Boundary::Periodic { mean_compliance_m_per_pa } => {
                Boundary::Periodic { mean_compliance_m_per_pa: mean_compliance_m_per_pa * l / t }
            }
        };
        let scaled_control = match control {
            Control::MeanPressure { pascal } => Control::MeanPressure { pascal: pascal * pressure },
            Control::Load { newton } => Control::Load { newton: newton * pressure * l * l },
            Control::Penetration { metre } => Control::Penetration { metre: metre * s },
            Control::MeanGap { metre } => Control::MeanGap { metre: metre * s },
            other => other,
        };
        let scaled_space = HalfSpace::new(scaled_grid, t * half_space.modulus_pa(), boundary).unwrap();
        let scaled_heights = heights.mapv(|z| s * z);
        let scaled_hardness = hardness.map(|h| h * pressure);
        let scaled = ContactProblem::new(&scaled_space, &scaled_heights, scaled_control, scaled_hardness).unwrap();
        let scaled = Solver::default().solve(&scaled).unwrap();
        assert_eq!(scaled.iterations(), solution.iterations(), "{sample}: {control:?}");
        assert!(
            scaled.pressure_pa().iter().zip(solution.pressure_pa()).all(|(a, b)| *a == b * pressure),
            "{sample}: {control:?}"
        );
        assert_eq!(scaled.plane_m(), s * solution.plane_m(), "{sample}: {control:?}");
    }
}

#[test]
fn mirrored_transposed_and_shifted_surfaces_have_the_same_contact() {
    let tolerance = 1e-11;
    let solver = Solver { tolerance, max_iterations: 2000 };
    for sample in 0..33 {
        let mut choices = Choices::new(14, "symmetry", sample);
        let (half_space, heights, control, hardness) =
            random_problem(&mut choices, KINDS[sample as usize % KINDS.len()]);
        let solve = |half_space: &HalfSpace, heights: &Array2<f64>| {
            let problem = ContactProblem::new(half_space, heights, control, hardness).unwrap();
            solver.solve(&problem).unwrap()
        };
        let solution = solve(&half_space, &heights);
        let plain = solution.pressure_pa();
        let largest = solution.max_pressure_pa();
        let rms = ContactProblem::new(&half_space, &heights, control, hardness).unwrap().rms_height_m();
        let grid = half_space.grid();
        // A residual of τ·rms in the gap corresponds to τ·rms·E*|q|/2 in the pressure, with |q| ≤ √2π/min(dx, dy).
        let stiffest = half_space.modulus_pa() * 2.3 / grid.dx_m().min(grid.dy_m());
        let bound = 1e-9 * largest + 1e2 * tolerance * rms * stiffest;
        let differ = |a: &Array2<f64>, b: &Array2<f64>| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let flipped = |z: &Array2<f64>| z.slice(ndarray::s![.., ..;-1]).to_owned();
        let mirrored = solve(&half_space, &flipped(&heights));
        assert!(differ(&flipped(mirrored.pressure_pa()), plain) <= bound, "{sample}: mirrored");

        let turned_grid = Grid::new(grid.ny(), grid.nx(), grid.dy_m(), grid.dx_m()).unwrap();
        let turned = HalfSpace::new(turned_grid, half_space.modulus_pa(), half_space.boundary()).unwrap();
        let transposed = solve(&turned, &heights.t().as_standard_layout().to_owned());
        assert!(differ(&transposed.pressure_pa().t().to_owned(), plain) <= bound, "{sample}: transposed");

        if let Boundary::Periodic { .. } = half_space.boundary() {
            let rolled = |z: &Array2<f64>, by: usize| {
                Array2::from_shape_fn(z.dim(), |(i, j)| z[[(i + 1) % z.nrows(), (j + by) % z.ncols()]])
            };
            let shifted = solve(&half_space, &rolled(&heights, 3));
            assert!(differ(shifted.pressure_pa(), &rolled(plain, 3)) <= bound, "{sample}: shifted");
        }
    }
}

#[test]
fn a_contact_without_elastic_cells_is_solved() {
    // The load is that of exactly k cells at the hardness on a rigid-plastic solid, so no cell is between the bounds.
    let grid = Grid::new(16, 16, 1.0, 1.0).unwrap();
    let heights = surface(&mut Choices::new(15, "plastic", 0), Kind::WhiteNoise, grid);
    let mut sorted: Vec<f64> = heights.iter().copied().collect();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let hardness = 2.0_f64.powi(-40);
    for boundary in [Boundary::Free, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }] {
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        for carrying in [1, 32, 128, 255] {
            let control = Control::MeanPressure { pascal: hardness * carrying as f64 / 256.0 };
            let problem = ContactProblem::new(&half_space, &heights, control, Some(hardness)).unwrap();
            let solution = Solver::default().solve(&problem).unwrap();
            assert!(solution.converged(), "{carrying}: {:?}", solution.residual());
            assert_eq!(solution.plastic_fraction(), carrying as f64 / 256.0);
            assert_eq!(solution.contact_fraction(), solution.plastic_fraction());
            // The plane rests on the cell that touches next.
            assert!(
                (solution.plane_m() - sorted[carrying]).abs() < 1e-9,
                "{} {}",
                solution.plane_m(),
                sorted[carrying]
            );

            // A mean gap between the gaps of two such loads fixes the plane, and the load is constant.
            let plane = 0.5 * (sorted[carrying - 1] + sorted[carrying]);
            let gap = heights.iter().map(|z| (plane - z).max(0.0)).sum::<f64>() / 256.0;
            let problem =
                ContactProblem::new(&half_space, &heights, Control::MeanGap { metre: gap }, Some(hardness)).unwrap();
            let by_gap = Solver::default().solve(&problem).unwrap();
            assert!(by_gap.converged(), "{carrying}: {:?}", by_gap.residual());
            assert_eq!(by_gap.pressure_pa(), solution.pressure_pa());
            assert!((by_gap.plane_m() - plane).abs() < 1e-7, "{} {plane}", by_gap.plane_m());
        }
    }
}

#[test]
fn a_tolerance_or_a_gap_below_rounding_stops_at_the_precision_limit() {
    let grid = Grid::new(32, 32, 1.0, 1.0).unwrap();
    let heights = surface(&mut Choices::new(16, "precision", 0), Kind::SelfAffine, grid);
    for boundary in [Boundary::Free, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 }] {
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        for hardness in [None, Some(2.0)] {
            let solve = |control, tolerance| {
                let problem = ContactProblem::new(&half_space, &heights, control, hardness).unwrap();
                let solution = Solver { tolerance, max_iterations: 20_000 }.solve(&problem).unwrap();
                assert!(solution.pressure_pa().iter().all(|p| p.is_finite()));
                solution
            };
            let solution = solve(Control::MeanPressure { pascal: 0.05 }, 1e-18);
            println!("{boundary:?} {hardness:?}: {} iterations, {:?}", solution.iterations(), solution.residual());
            assert_eq!(solution.stop_reason(), SolverStop::PrecisionLimit);
            assert!(solution.residual().worst() < 1e-13, "{:?}", solution.residual());
            let solution = solve(Control::MeanGap { metre: 1e-13 }, 1e-8);
            println!("    gap: {} iterations, {:?}", solution.iterations(), solution.residual());
            assert!(!solution.converged());
        }
    }
}

#[test]
fn a_mean_gap_above_the_highest_point_is_reached_without_contact() {
    let grid = Grid::new(12, 9, 1.0, 1.0).unwrap();
    let heights = surface(&mut Choices::new(17, "gap", 0), Kind::WhiteNoise, grid).mapv(|z| z + 100.0);
    let mean = heights.sum() / heights.len() as f64;
    for boundary in [Boundary::Free, Boundary::Periodic { mean_compliance_m_per_pa: 1.0 }] {
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        for hardness in [None, Some(0.1)] {
            let problem =
                ContactProblem::new(&half_space, &heights, Control::MeanGap { metre: 10.0 }, hardness).unwrap();
            let solution = Solver::default().solve(&problem).unwrap();
            assert!(solution.converged());
            assert_eq!((solution.contact_fraction(), solution.load_n(), solution.iterations()), (0.0, 0.0, 0));
            assert!((solution.plane_m() - mean - 10.0).abs() < 1e-12);
            assert!((solution.mean_gap_m() - 10.0).abs() < 1e-12);
        }
    }
}
