use std::f64::consts::PI;

use super::*;
use crate::Boundary;
use asperity_base::map::Grid;
use asperity_base::random;
use asperity_testing::{AlwaysCancelled, self_affine};

const SOLVER: Solver = Solver { tolerance: 1e-10, max_iterations: 5000 };

fn load(newton: f64) -> Control {
    Control::Load { newton }
}

/// Returns a random map of about unit slope.
fn rough(n: usize, sample: u64) -> Array2<f64> {
    self_affine(n, 2.0, &mut random::stream(5, "cycle", sample))
}

fn paraboloid(n: usize, side_m: f64) -> (Grid, Array2<f64>) {
    asperity_testing::paraboloid(n, side_m, 0.0)
}

fn largest_difference(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Returns rough surfaces with either boundary, their hardness and a load that makes much of the contact plastic.
fn surfaces() -> Vec<(HalfSpace, Array2<f64>, f64, f64)> {
    let grid = Grid::new(32, 32, 1.0, 0.8).unwrap();
    let periodic = Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };
    [Boundary::Free, periodic]
        .into_iter()
        .enumerate()
        .map(|(sample, boundary)| {
            let heights = rough(32, sample as u64);
            let slope = (&heights.slice(ndarray::s![.., 1..]) - &heights.slice(ndarray::s![.., ..-1])).std(0.0);
            (HalfSpace::new(grid, 1.0, boundary).unwrap(), heights, 0.5 * slope, 0.07 * slope * grid.area_m2())
        })
        .collect()
}

#[test]
fn many_load_steps_leave_the_same_state_as_one() {
    for (half_space, heights, hardness, newton) in surfaces() {
        let path = |count: usize| {
            let mut path = LoadPath::new(&half_space, &heights, Some(hardness)).unwrap();
            let controls: Vec<Control> = (1..=count).map(|i| load(newton * i as f64 / count as f64)).collect();
            let mut steps = path.follow(&controls, &SOLVER, &Silent).unwrap();
            assert!(steps.len() == count && steps.iter().all(LoadStep::converged));
            (path, steps.pop().unwrap())
        };
        let ((one, whole), (many, last)) = (path(1), path(12));
        let (whole, last) = (whole.solution.unwrap(), last.solution.unwrap());
        assert!(whole.plastic_fraction() > 0.04 && whole.plastic_fraction() < whole.contact_fraction());
        let imprint = one.plastic_displacement_m();
        let deepest = imprint.iter().copied().fold(0.0, f64::max);
        assert!(deepest > 0.02 * heights.std(0.0), "{deepest:e}");
        let pressure = largest_difference(whole.pressure_pa(), last.pressure_pa()) / hardness;
        let apart = largest_difference(&imprint, &many.plastic_displacement_m()) / deepest;
        println!("pressure {pressure:.1e} of the hardness, imprint {apart:.1e} of the deepest");
        assert!(pressure < 1e-6 && apart < 1e-6, "{pressure:e} {apart:e}");
        assert!((whole.plane_m() - last.plane_m()).abs() < 1e-8 * heights.std(0.0));
    }
}

#[test]
fn reloading_up_to_the_largest_load_is_elastic() {
    for (half_space, heights, hardness, newton) in surfaces() {
        let mut path = LoadPath::new(&half_space, &heights, Some(hardness)).unwrap();
        let top = path.press(load(newton), &SOLVER).unwrap().solution.unwrap();
        let left = path.residual_heights_m().clone();
        let dissipated = path.plastic_work_j();
        assert!((top.plastic_work_j() / dissipated - 1.0).abs() < 1e-6);
        assert!(largest_difference(&top.residual_heights_m(&heights), &left) <= 2e-10 * heights.std(0.0));
        for ratio in [0.8, 0.3, 0.0, 0.05, 0.5, 1.0] {
            let step = path.press(load(ratio * newton), &SOLVER).unwrap();
            assert!(step.converged() && step.largest_increment_m < 1e-8 * heights.std(0.0), "{ratio}: {step:?}");
            let Some(found) = step.solution else {
                // Unloaded, the flat touches the highest remaining point.
                assert_eq!((step.load_n, step.plane_m), (0.0, left.iter().copied().fold(f64::NEG_INFINITY, f64::max)));
                continue;
            };
            // Without a hardness the contact is the same.
            let elastic = ContactProblem::new(&half_space, &left, load(ratio * newton), None).unwrap();
            let elastic = SOLVER.solve(&elastic).unwrap();
            let error = largest_difference(found.pressure_pa(), elastic.pressure_pa()) / hardness;
            assert!(elastic.converged() && error < 1e-5, "{ratio}: {error:e}");
            if ratio == 1.0 {
                let error = largest_difference(found.pressure_pa(), top.pressure_pa()) / hardness;
                assert!(error < 1e-5, "{error:e}");
                assert!((found.plane_m() - top.plane_m()).abs() < 1e-7 * heights.std(0.0));
            } else {
                // During unloading the flat lies lower than under the same load before the imprint.
                let virgin = ContactProblem::new(&half_space, &heights, load(ratio * newton), Some(hardness)).unwrap();
                assert!(found.plane_m() < SOLVER.solve(&virgin).unwrap().plane_m());
            }
        }
        assert!(path.plastic_work_j() - dissipated <= 1e-6 * dissipated);
    }
}

/// Returns the work −∫F dd in joule of the flat along `steps`, d being its height, by the trapezoidal rule. After first
/// touch the approach rises as F^{2/3}, so with equal load steps the error falls with their number to the power 5/3.
fn work_of_flat_j(steps: &[LoadStep]) -> f64 {
    steps.windows(2).map(|pair| 0.5 * (pair[0].load_n + pair[1].load_n) * (pair[0].plane_m - pair[1].plane_m)).sum()
}

#[test]
fn the_work_of_a_cycle_equals_the_plastic_dissipation() {
    let (grid, heights) = paraboloid(48, 0.36);
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    let (hardness, top) = (0.03, 6e-4);
    let errors = [6_u32, 12, 24].map(|count| {
        let up = (0..=count).map(|i| load(top * f64::from(i) / f64::from(count)));
        let down = (0..count).rev().map(|i| load(top * f64::from(i) / f64::from(count)));
        let controls: Vec<Control> = up.chain(down).collect();
        let mut path = LoadPath::new(&half_space, &heights, Some(hardness)).unwrap();
        let steps = path.follow(&controls, &SOLVER, &Silent).unwrap();
        assert!(steps.iter().all(LoadStep::converged));
        // Half way, the work is stored or dissipated; at the end all of it is dissipated.
        let stored = steps[count as usize].elastic_energy_j();
        let half = work_of_flat_j(&steps[..=count as usize]) / (stored + path.plastic_work_j()) - 1.0;
        let whole = work_of_flat_j(&steps) / path.plastic_work_j() - 1.0;
        println!("{count} steps: {half:.2e} loading, {whole:.2e} around; {:.2} stored", stored / path.plastic_work_j());
        (half.abs(), whole.abs())
    });
    for error in [|e: &(f64, f64)| e.0, |e: &(f64, f64)| e.1] {
        let order = (error(&errors[0]) / error(&errors[2])).log2() / 2.0;
        // After first touch the approach rises as F^{2/3}, which limits the order of the trapezoidal rule to 1 + 2/3.
        assert!((order - 5.0 / 3.0).abs() < 0.1, "observed order {order:.2} from {errors:?}");
        assert!(error(&errors[2]) < 5e-3, "{errors:?}");
    }
}

#[test]
fn a_stiff_cap_dissipates_the_hardness_times_its_volume() {
    // The body is so stiff that its elastic displacement, about 2a·H/E*, is negligible against the depth.
    let (grid, heights) = paraboloid(128, 0.3);
    let half_space = HalfSpace::new(grid, 1e4, Boundary::Free).unwrap();
    let mut path = LoadPath::new(&half_space, &heights, Some(1.0)).unwrap();
    let depth = 0.005;
    let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let step = path.press(Control::Plane { height_m: highest - depth }, &SOLVER).unwrap();
    // A plane at height −d cuts the volume πd² off the paraboloid z = −r²/2.
    let (work, plane) = (path.plastic_work_j(), step.plane_m);
    let wanted = PI * plane.powi(2);
    println!("{:.1e} from the volume", work / wanted - 1.0);
    assert!((work / wanted - 1.0).abs() < 0.01, "{work:e} {wanted:e}");
    assert!((step.plastic_work_j - work).abs() < 1e-15);
    // The spring-back is the height that stands out of the flat afterwards.
    let spring_back = path.residual_heights_m().iter().copied().fold(f64::NEG_INFINITY, f64::max) - plane;
    assert!(spring_back > 0.0 && spring_back < 4.0 * 0.1 / 1e4, "{spring_back:e}");
}

#[test]
fn a_fully_plastic_cap_fits_its_imprint_afterwards() {
    let (grid, heights) = paraboloid(64, 0.4);
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    let mut path = LoadPath::new(&half_space, &heights, Some(0.01)).unwrap();
    let newton = 2e-4;
    let first = path.press(load(newton), &SOLVER).unwrap().solution.unwrap();
    // The contact is almost fully plastic: its mean pressure is close to the hardness.
    assert!(first.plastic_fraction() > 0.85 * first.contact_fraction());
    assert!(first.mean_pressure_pa() / first.contact_fraction() > 0.9 * 0.01);
    let imprint = path.plastic_displacement_m();
    path.press(load(0.0), &SOLVER).unwrap();
    let again = path.press(load(newton), &SOLVER).unwrap();
    let second = again.solution.unwrap();
    assert!(largest_difference(first.pressure_pa(), second.pressure_pa()) < 1e-5 * 0.01);
    assert!(largest_difference(&imprint, &path.plastic_displacement_m()) < 1e-8 * heights.std(0.0));
    // A larger load continues from the end of the first.
    assert!(path.press(load(1.2 * newton), &SOLVER).unwrap().largest_increment_m > 0.0);
}

#[test]
fn planes_stay_in_the_coordinates_of_the_map() {
    let (grid, heights) = paraboloid(32, 0.4);
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    for control in [
        Control::Penetration { metre: 0.01 },
        Control::Percentile { percent: 15.0 },
        Control::Plane { height_m: -0.01 },
    ] {
        let mut path = LoadPath::new(&half_space, &heights, Some(0.02)).unwrap();
        let first = path.press(control, &SOLVER).unwrap();
        assert!(first.largest_increment_m > 1e-3);
        let again = path.press(control, &SOLVER).unwrap();
        assert_eq!(first.plane_m, again.plane_m);
        assert!((again.load_n / first.load_n - 1.0).abs() < 1e-6 && again.largest_increment_m < 1e-10);
    }
}

#[test]
fn a_repeated_cycle_adds_no_imprint() {
    let (half_space, heights, hardness, newton) = surfaces().remove(1);
    let cycle = [0.5, 1.0, 0.4, 0.0].map(|ratio| load(ratio * newton));
    let mut path = LoadPath::new(&half_space, &heights, Some(hardness)).unwrap();
    path.follow(&cycle, &SOLVER, &Silent).unwrap();
    let first = path.plastic_displacement_m();
    assert!(first.iter().copied().fold(0.0, f64::max) > 0.02 * heights.std(0.0));
    path.follow(&cycle, &SOLVER, &Silent).unwrap();
    let added = (path.plastic_displacement_m() - first).into_iter().fold(0.0, f64::max);
    assert!(added < 1e-6 * heights.std(0.0), "{added}");
    // A step that does not converge ends the path.
    let hasty = Solver { max_iterations: 1, ..SOLVER };
    let mut path = LoadPath::new(&half_space, &heights, Some(hardness)).unwrap();
    let steps = path.follow(&cycle, &hasty, &Silent).unwrap();
    assert!(steps.len() == 1 && !steps[0].converged());
    assert_eq!((path.plastic_work_j(), path.residual_heights_m()), (0.0, &heights));
}

#[test]
fn invalid_paths_are_refused() {
    let (grid, heights) = paraboloid(8, 0.4);
    let periodic = Boundary::Periodic { mean_compliance_m_per_pa: 1.0 };
    let half_space = HalfSpace::new(grid, 1.0, periodic).unwrap();
    assert!(LoadPath::new(&half_space, &heights, Some(-1.0)).is_err());
    assert!(LoadPath::new(&half_space, &Array2::zeros((8, 8)), Some(1.0)).is_err());
    let mut path = LoadPath::new(&half_space, &heights, Some(1e-3)).unwrap();
    assert!(path.press(load(-1.0), &SOLVER).is_err());
    assert!(path.press(load(1e-3), &SOLVER).is_err(), "more than the hardness carries");
    // After the whole contact has become plastic, the surface has no roughness left.
    let flat = path.press(Control::Plane { height_m: -1.0 }, &SOLVER).unwrap();
    assert_eq!(flat.solution.unwrap().plastic_fraction(), 1.0);
    assert_eq!(path.press(load(1e-5), &SOLVER).unwrap_err(), ContactError::Flat);
}

#[test]
fn a_cancelled_load_leaves_no_imprint() {
    let (grid, heights) = paraboloid(32, 1.0);
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).unwrap();
    let mut path = LoadPath::new(&half_space, &heights, Some(0.05)).unwrap();
    let steps = path.follow(&[load(1e-3), load(2e-3)], &SOLVER, &AlwaysCancelled).unwrap();
    assert_eq!(steps.len(), 1);
    assert!(!steps[0].converged());
    assert_eq!(path.residual_heights_m(), &heights);
    assert!(path.press(load(1e-3), &SOLVER).unwrap().largest_increment_m > 0.0);
}
