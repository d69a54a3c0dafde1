//! The contact solver at the edge of what numbers can hold, and what must grow with the load.

use asperity_base::map::Grid;
use asperity_base::random;
use asperity_contact::{Boundary, ContactError, ContactProblem, Control, HalfSpace, Solution, Solver};
use asperity_testing::Choices;
use ndarray::Array2;

const GRIDS: [(usize, usize); 7] = [(2, 2), (2, 13), (31, 2), (3, 5), (8, 8), (17, 6), (24, 24)];

/// White noise of unit variance on a grid of unit pitch, and a half-space of unit modulus below it.
fn unit_problem(choices: &mut Choices, free: bool) -> (HalfSpace, Array2<f64>) {
    let (nx, ny) = choices.one_of(&GRIDS);
    let grid = Grid::new(nx, ny, 1.0, 1.0).unwrap();
    let heights = random::standard_normal(&mut choices.stream, grid.points());
    let half_space = half_space(grid, 1.0, free).unwrap();
    (half_space, Array2::from_shape_vec((ny, nx), heights).unwrap())
}

fn half_space(grid: Grid, modulus: f64, free: bool) -> Result<HalfSpace, ContactError> {
    let mean_compliance_m_per_pa = HalfSpace::default_mean_compliance_m_per_pa(grid, modulus);
    let boundary = if free { Boundary::Free } else { Boundary::Periodic { mean_compliance_m_per_pa } };
    HalfSpace::new(grid, modulus, boundary)
}

fn solve(
    space: &HalfSpace,
    z: &Array2<f64>,
    control: Control,
    hardness: Option<f64>,
) -> Result<Solution, ContactError> {
    Solver::default().solve(&ContactProblem::new(space, z, control, hardness)?)
}

#[test]
fn extreme_scales_give_the_scaled_solution_or_an_error() {
    // Half of the decades lie in the stated ranges of heights and moduli, where nothing may be refused.
    let decades = [-320.0, -160.0, -51.0, -49.0, -30.5, -29.5, -9.0, 0.0, 29.5, 30.5, 49.0, 51.0, 160.0, 300.0];
    let mut refused = 0;
    for sample in 0..900 {
        let mut choices = Choices::new(22, "scales", sample);
        let free = choices.one_of(&[true, false]);
        let (unit, heights) = unit_problem(&mut choices, free);
        let (rms, modulus) = (10.0_f64.powf(choices.one_of(&decades)), 10.0_f64.powf(choices.one_of(&decades)));
        let pitch = choices.one_of(&[1e-15, 1e-6, 1.0, 1e3]);
        let pressure = modulus * (rms / pitch);
        let depth = choices.decades(-3.0, 2.0);
        let (control, unscaled) = match sample % 3 {
            0 => (Control::MeanPressure { pascal: depth * pressure }, Control::MeanPressure { pascal: depth }),
            1 => (Control::Penetration { metre: depth * rms }, Control::Penetration { metre: depth }),
            _ => (Control::Percentile { percent: 30.0 }, Control::Percentile { percent: 30.0 }),
        };
        let name = format!("{sample}: pitch {pitch:e}, rms {rms:e}, modulus {modulus:e}, {control:?}");
        let grid = Grid::new(unit.grid().nx(), unit.grid().ny(), pitch, pitch).unwrap();
        let scaled = half_space(grid, modulus, free).and_then(|h| solve(&h, &heights.mapv(|z| z * rms), control, None));
        let computable = (-49.5..=49.5).contains(&rms.log10()) && (-30.0..=30.0).contains(&modulus.log10());
        match scaled {
            Ok(scaled) => {
                let reference = solve(&unit, &heights, unscaled, None).unwrap();
                assert!(scaled.converged(), "{name}: {:?}", scaled.residual());
                let bound = 1e-4 * reference.max_pressure_pa();
                let near = |(a, b): (&f64, &f64)| (a / pressure - b).abs() <= bound;
                assert!(scaled.pressure_pa().iter().zip(reference.pressure_pa()).all(near), "{name}");
                assert!((scaled.plane_m() / rms - reference.plane_m()).abs() <= 1e-4 * (1.0 + depth), "{name}");
                assert!(scaled.load_n().is_finite() && scaled.load_n() > 0.0, "{name}");
            }
            Err(error) => {
                assert!(
                    !computable && matches!(error, ContactError::Parameter { .. } | ContactError::Flat),
                    "{name}: {error}"
                );
                refused += 1;
            }
        }
    }
    assert!((500..800).contains(&refused), "{refused}");
}

#[test]
fn loads_and_hardness_of_any_size_are_solved_or_reported() {
    for sample in 0..400 {
        let mut choices = Choices::new(23, "loads", sample);
        let free = choices.one_of(&[true, false]);
        let (space, heights) = unit_problem(&mut choices, free);
        let size = |choices: &mut Choices| {
            choices.one_of(&[5e-324, 1e-310, 1e-200, 1e-30, 1e-3, 1.0, 1e3, 1e30, 1e200, 1e308])
        };
        let control = match sample % 4 {
            0 => Control::MeanPressure { pascal: size(&mut choices) },
            1 => Control::Penetration { metre: size(&mut choices) },
            2 => Control::MeanGap { metre: size(&mut choices) },
            _ => Control::Percentile { percent: choices.one_of(&[0.0, 1e-9, 50.0, 100.0]) },
        };
        let hardness = choices.one_of(&[None, Some(()), Some(())]).map(|()| size(&mut choices));
        let name = format!("{sample}: {:?} {:?} {control:?} H {hardness:?}", space.grid(), space.boundary());
        match solve(&space, &heights, control, hardness) {
            Ok(solution) => {
                let most = hardness.unwrap_or(f64::INFINITY);
                assert!(solution.pressure_pa().iter().all(|p| p.is_finite() && (0.0..=most).contains(p)), "{name}");
                if solution.converged() {
                    assert!(
                        solution.residual().worst() <= Solver::default().tolerance,
                        "{name}: {:?}",
                        solution.residual()
                    );
                    assert!(solution.load_n().is_finite() && solution.plane_m().is_finite(), "{name}");
                    if let Control::MeanPressure { pascal } = control {
                        let reached = solution.load_n() / space.grid().area_m2();
                        assert!((reached / pascal - 1.0).abs() < 1e-6, "{name}: {reached:e}");
                    }
                } else {
                    println!("{name}: {:?} {:?}", solution.stop_reason(), solution.residual());
                }
            }
            Err(error) => assert!(
                matches!(error, ContactError::Overloaded { .. } | ContactError::Parameter { .. }),
                "{name}: {error}"
            ),
        }
    }
}

#[test]
fn one_cell_alone_carries_the_load_of_its_own_compliance() {
    // A single high cell: p = (penetration)/K₀₀ with Love's coefficient of a square cell at its own centre,
    // 8 ln(1+√2)·(a/2)/(π E*) for the side a; until the second cell touches.
    let own_compliance = 4.0 * (1.0 + 2.0_f64.sqrt()).ln() / std::f64::consts::PI;
    for (sample, (nx, ny)) in GRIDS.into_iter().enumerate() {
        let grid = Grid::new(nx, ny, 1.0, 1.0).unwrap();
        let space = half_space(grid, 1.0, true).unwrap();
        let mut heights = Array2::zeros((ny, nx));
        let cell = (sample % ny, sample % nx);
        heights[cell] = 1.0;
        for depth in [1e-4, 1e-2, 0.5] {
            let penetrated = solve(&space, &heights, Control::Penetration { metre: depth }, None).unwrap();
            let pressure = penetrated.pressure_pa()[cell];
            assert!((pressure * own_compliance / depth - 1.0).abs() < 1e-7 / depth, "{nx} × {ny}, {depth}: {pressure}");
            assert!((penetrated.load_n() / pressure - 1.0).abs() < 1e-12);
            // The same by load, and with a hardness below that pressure, at which this cell stays.
            let loaded = solve(&space, &heights, Control::Load { newton: pressure }, None).unwrap();
            assert_eq!(loaded.contact_fraction(), 1.0 / heights.len() as f64);
            let soft = solve(&space, &heights, Control::Penetration { metre: depth }, Some(0.5 * pressure)).unwrap();
            assert_eq!(soft.pressure_pa()[cell], 0.5 * pressure);
        }
    }
}

#[test]
fn load_area_and_depth_grow_together() {
    for sample in 0..120 {
        let mut choices = Choices::new(24, "monotone", sample);
        let free = choices.one_of(&[true, false]);
        let (space, heights) = unit_problem(&mut choices, free);
        let hardness = choices.one_of(&[None, Some(())]).map(|()| choices.decades(-2.0, 0.5));
        let mut last: Option<Solution> = None;
        let mut depth = choices.decades(-3.0, -1.0);
        while depth < 10.0 {
            let solution = solve(&space, &heights, Control::Penetration { metre: depth }, hardness).unwrap();
            if let Some(last) = &last {
                let name = format!("{sample}: {:?} {:?} H {hardness:?} at {depth}", space.grid(), space.boundary());
                let slack = 1e-6 * solution.max_pressure_pa();
                assert!(solution.load_n() >= last.load_n() - slack, "{name}: load");
                assert!(solution.contact_fraction() >= last.contact_fraction(), "{name}: area");
                assert!(solution.plastic_fraction() >= last.plastic_fraction(), "{name}: plastic area");
            }
            depth *= choices.between(1.05, 2.0);
            last = Some(solution);
        }
    }
}
