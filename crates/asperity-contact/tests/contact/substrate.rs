//! Contact on layers, against closed forms and dense algebra.

use std::f64::consts::{PI, TAU};

use asperity_base::map::Grid;
use asperity_base::random;
use asperity_contact::exact::Hertz;
use asperity_contact::{
    Base, Boundary, ContactProblem, Control, Elastic, HalfSpace, Layer, Solution, Solver, SolverStop, Substrate,
};
use asperity_testing::{paraboloid, self_affine};
use ndarray::Array2;

const PERIODIC: Boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };

fn layer(thickness_m: f64, poisson_ratio: f64, base: Base) -> Substrate {
    Substrate::Layer(Layer { thickness_m, material: Elastic { youngs_modulus_pa: 1.0, poisson_ratio }, base })
}

fn elastic(youngs_modulus_pa: f64, poisson_ratio: f64) -> Base {
    Base::Elastic(Elastic { youngs_modulus_pa, poisson_ratio })
}

fn displaced(half_space: &HalfSpace, p: &[f64]) -> Vec<f64> {
    let mut u = vec![0.0; p.len()];
    half_space.displace(p, &mut u, &mut half_space.workspace());
    u
}

fn solve(heights_m: &Array2<f64>, half_space: &HalfSpace, control: Control, hardness_pa: Option<f64>) -> Solution {
    let problem = ContactProblem::new(half_space, heights_m, control, hardness_pa).unwrap();
    let solution = Solver::default().solve(&problem).unwrap();
    assert!(solution.converged(), "{:?} after {}", solution.residual(), solution.iterations());
    solution
}

fn rough(n: usize, sample: u64) -> Array2<f64> {
    self_affine(n, 3.0, &mut random::stream(5, "layers", sample))
}

#[test]
fn a_layer_of_the_same_material_as_its_base_is_a_half_space() {
    let grid = Grid::new(24, 16, 0.5, 0.8).unwrap();
    let p = random::standard_normal(&mut random::stream(1, "layers", 0), grid.points());
    for boundary in [Boundary::Free, PERIODIC] {
        for thickness_m in [0.1, 1.0, 30.0] {
            let one = HalfSpace::with_substrate(layer(thickness_m, 0.3, elastic(1.0, 0.3)), grid, boundary).unwrap();
            let other = HalfSpace::new(grid, 1.0 / 0.91, boundary).unwrap();
            assert_eq!(one.modulus_pa(), other.modulus_pa());
            let (u, wanted) = (displaced(&one, &p), displaced(&other, &p));
            assert!(u.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{boundary:?} {thickness_m}");
        }
    }
}

#[test]
fn a_wave_displaces_a_periodic_layer_by_its_compliance() {
    let grid = Grid::new(12, 10, 0.5, 0.25).unwrap();
    for base in [Base::Rigid, Base::Slippery, elastic(0.2, 0.4)] {
        let substrate = layer(0.7, 0.25, base);
        let given = 0.3;
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: given };
        let half_space = HalfSpace::with_substrate(substrate, grid, boundary).unwrap();
        // On a rigid base the mean compliance is (1+ν)(1−2ν)h/(1−ν)E if bonded, h(1−ν²)/E if not.
        let mean = match base {
            Base::Rigid => 0.7 * 1.25 * 0.5 / 0.75,
            Base::Slippery => 0.7 * (1.0 - 0.0625),
            Base::Elastic(_) => given,
        };
        let Boundary::Periodic { mean_compliance_m_per_pa } = half_space.boundary() else { panic!("periodic") };
        assert!((mean_compliance_m_per_pa - mean).abs() < 1e-15);
        let (qx, qy) = (2.0 * TAU / grid.width_m(), -3.0 * TAU / grid.height_m());
        let wave = |i: usize| (qx * (i % 12) as f64 * 0.5 + qy * (i / 12) as f64 * 0.25 + 0.4).cos();
        let p: Vec<f64> = (0..grid.points()).map(|i| 2.0 + wave(i)).collect();
        let amplitude = substrate.compliance_m_per_pa(qx.hypot(qy));
        for (i, u) in displaced(&half_space, &p).into_iter().enumerate() {
            assert!((u - 2.0 * mean - amplitude * wave(i)).abs() < 1e-13);
        }
    }
}

#[test]
fn the_middle_of_a_wide_pressed_patch_has_the_displacement_of_a_confined_layer() {
    // Cells as wide as the layer, and narrower and wider ones. Loads beyond some 20 thicknesses have no effect.
    for (thickness_m, nu) in [(1.0, 0.3), (4.0, 0.0), (0.2, 0.3), (0.5, 0.49)] {
        let substrate = layer(thickness_m, nu, Base::Rigid);
        let grid = Grid::new(161, 161, 1.0, 1.0).unwrap();
        let half_space = HalfSpace::with_substrate(substrate, grid, Boundary::Free).unwrap();
        let u = displaced(&half_space, &vec![1.0; grid.points()]);
        let wanted = substrate.mean_compliance_m_per_pa().unwrap();
        let found = u[80 * 161 + 80];
        assert!((found - wanted).abs() < 1e-9, "{thickness_m} {nu}: {found:e} {wanted:e}");
        // A wave under a window that is smooth over many thicknesses has a displacement by the compliance of its
        // component waves.
        let (q, width) = (TAU / 16.0, 14.0);
        let window = |i: f64| (-0.5 * ((i - 80.0) / width).powi(2)).exp();
        let wave = |i: usize| {
            let (x, y) = ((i % 161) as f64, (i / 161) as f64);
            window(x) * window(y) * (q * (x - 80.0)).cos()
        };
        let p: Vec<f64> = (0..grid.points()).map(wave).collect();
        let found = displaced(&half_space, &p)[80 * 161 + 80];
        // Cells of constant pressure contain waves up to multiples of 2π, and average them.
        let averaged = |q: f64| if q == 0.0 { 1.0 } else { (0.5 * q).sin() / (0.5 * q) };
        let (mut wanted, mut weights) = (0.0, 0.0);
        for i in -20..=20 {
            for j in -20..=20 {
                let (dx, dy) = (0.2 * f64::from(i), 0.2 * f64::from(j));
                let weight = (-0.5 * (dx * dx + dy * dy)).exp();
                weights += weight;
                for alias in -12..=12 {
                    let (qx, qy) = (q + dx / width + TAU * f64::from(alias), dy / width);
                    wanted += weight * averaged(qx) * averaged(qy) * substrate.compliance_m_per_pa(qx.hypot(qy));
                }
            }
        }
        wanted /= weights;
        println!("{thickness_m} {nu}: {:.1e} from the compliance", found / wanted - 1.0);
        assert!((found / wanted - 1.0).abs() < 3e-3, "{thickness_m} {nu}: {found:e} {wanted:e}");
    }
}

#[test]
fn a_wave_on_a_layer_is_flattened_by_its_amplitude_over_the_compliance() {
    let n = 32;
    let grid = Grid::new(n, n, 1.0 / n as f64, 1.0 / n as f64).unwrap();
    let wave = |i: usize| 0.01 * (TAU * i as f64 / n as f64).cos();
    let heights = Array2::from_shape_fn((n, n), |(row, column)| wave(row) * (TAU * column as f64 / n as f64).cos());
    for base in [Base::Rigid, Base::Slippery, elastic(0.02, 0.4), elastic(30.0, 0.2)] {
        for thickness_m in [0.02, 0.3] {
            let substrate = layer(thickness_m, 0.3, base);
            let half_space = HalfSpace::with_substrate(substrate, grid, PERIODIC).unwrap();
            let amplitude = 0.01 / substrate.compliance_m_per_pa(TAU * 2.0_f64.sqrt());
            let mean = 1.1 * amplitude;
            let solution = solve(&heights, &half_space, Control::MeanPressure { pascal: mean }, None);
            assert_eq!(solution.contact_fraction(), 1.0);
            for (p, z) in solution.pressure_pa().iter().zip(&heights) {
                assert!((p - mean - amplitude * z / 0.01).abs() < 1e-6 * mean, "{base:?} {thickness_m}: {p}");
            }
            // The mean pressure then determines the plane.
            let Boundary::Periodic { mean_compliance_m_per_pa } = half_space.boundary() else { panic!("periodic") };
            assert!((solution.separation_m() + mean_compliance_m_per_pa * mean).abs() < 1e-8);
        }
    }
}

#[test]
fn rough_contacts_on_layers_have_small_residuals() {
    let n = 64;
    let grid = Grid::new(n, n, 1.0, 1.0).unwrap();
    let heights = rough(n, 1);
    let slope = {
        let along = &heights.slice(ndarray::s![.., 1..]) - &heights.slice(ndarray::s![.., ..-1]);
        2.0_f64.sqrt() * along.std(0.0)
    };
    let mut most_iterations = 0;
    for (nu, base) in [
        (0.3, elastic(1.0, 0.3)),
        (0.3, Base::Rigid),
        (0.5, Base::Rigid),
        (0.3, Base::Slippery),
        (0.3, elastic(1e-2, 0.3)),
        (0.45, elastic(1e2, 0.3)),
    ] {
        for thickness_m in [0.3, 3.0, 30.0] {
            for boundary in [Boundary::Free, PERIODIC] {
                let half_space = HalfSpace::with_substrate(layer(thickness_m, nu, base), grid, boundary).unwrap();
                for (control, hardness) in [
                    (Control::MeanPressure { pascal: 0.05 * slope }, None),
                    (Control::MeanPressure { pascal: 0.05 * slope }, Some(0.3 * slope)),
                    (Control::Percentile { percent: 10.0 }, None),
                    (Control::MeanGap { metre: 0.5 * heights.std(0.0) }, None),
                ] {
                    // A free patch of a stiff coating on a soft base bends away from the flat, so no load closes the
                    // gap.
                    if matches!((control, boundary), (Control::MeanGap { .. }, Boundary::Free)) {
                        continue;
                    }
                    if let Err(error) = ContactProblem::new(&half_space, &heights, control, hardness) {
                        // A layer that is incompressible as a whole, and a base without a given mean compliance.
                        assert!(control.prescribes_plane() && half_space.boundary() == PERIODIC, "{error}");
                        continue;
                    }
                    let problem = ContactProblem::new(&half_space, &heights, control, hardness).unwrap();
                    let solution = Solver::default().solve(&problem).unwrap();
                    most_iterations = most_iterations.max(solution.iterations());
                    assert_eq!(
                        solution.stop_reason(),
                        SolverStop::Converged,
                        "{nu} {base:?} {thickness_m} {control:?}"
                    );
                    // The gap by its definition, with recomputed displacements.
                    let p: Vec<f64> = solution.pressure_pa().iter().copied().collect();
                    let u = displaced(&half_space, &p);
                    let scale = heights.std(0.0);
                    for (((u, z), p), gap) in u.iter().zip(&heights).zip(&p).zip(&solution.gap_m()) {
                        let signed = u - z + solution.plane_m();
                        let plastic = hardness.is_some_and(|hardness| *p >= hardness);
                        assert!(signed > -1e-7 * scale || plastic, "{signed:e}");
                        assert!(*p > 0.0 || (signed - gap).abs() < 1e-7 * scale);
                    }
                }
            }
        }
    }
    println!("at most {most_iterations} iterations");
    assert!(most_iterations < 300);
}

#[test]
fn a_thick_layer_has_the_contact_of_hertz() {
    let delta = 0.01;
    let radius = f64::sqrt(delta);
    let (grid, heights) = paraboloid(128, 2.5 * radius, 0.0);
    let load_n = Hertz::load_n(1.0 / 0.91, 1.0, delta);
    let plain = solve(
        &heights,
        &HalfSpace::new(grid, 1.0 / 0.91, Boundary::Free).unwrap(),
        Control::Load { newton: load_n },
        None,
    );
    let hertz = Hertz::new(1.0 / 0.91, 1.0, load_n);
    // The base reduces the displacement about as a mirrored load at the depth 2h: by the order a/h, with a curvature of
    // order (a/h)³.
    for (ratio, pressure) in [(10.0, 2e-3), (100.0, 2e-6), (1000.0, 1e-7)] {
        let half_space =
            HalfSpace::with_substrate(layer(ratio * radius, 0.3, Base::Rigid), grid, Boundary::Free).unwrap();
        let found = solve(&heights, &half_space, Control::Load { newton: load_n }, None);
        assert!((found.max_pressure_pa() / hertz.max_pressure_pa - 1.0).abs() < 0.005);
        assert!((found.max_pressure_pa() / plain.max_pressure_pa() - 1.0).abs() < pressure);
        let lost = 1.0 - found.penetration_m() / plain.penetration_m();
        assert!(lost > 0.0 && lost * ratio < 2.0 && lost * ratio > 0.5, "{ratio}: {lost:e}");
    }
}

#[test]
fn a_thin_layer_is_a_bed_of_springs() {
    // p = M(δ − r²/2R)/h with M = E(1−ν)/((1+ν)(1−2ν)): F = πMRδ²/h (Johnson, Contact Mechanics, §5.8).
    let delta = 0.01;
    let a = f64::sqrt(2.0 * delta);
    let (grid, heights) = paraboloid(128, 2.4 * a, 0.0);
    let plane = Control::Plane { height_m: -delta };
    let errors = [0.1, 0.05, 0.025].map(|ratio| {
        let substrate = layer(ratio * a, 0.2, Base::Rigid);
        let half_space = HalfSpace::with_substrate(substrate, grid, Boundary::Free).unwrap();
        let found = solve(&heights, &half_space, plane, None);
        let spring = 1.0 / substrate.mean_compliance_m_per_pa().unwrap();
        let wanted = PI * spring * delta * delta;
        println!("h/a = {ratio}: {:.2e}", found.load_n() / wanted - 1.0);
        assert!((found.max_pressure_pa() / (spring * delta) - 1.0).abs() < 0.05 * ratio / 0.1);
        (found.load_n() / wanted - 1.0).abs()
    });
    assert!(errors[2] < 0.05 && errors.is_sorted_by(|a, b| a > b), "{errors:?}");
}
