//! Contact stiffness of strips against closed forms.

use std::f64::consts::PI;
use std::sync::Arc;

use asperity_base::correlation::{CorrelationModel, Covariance};
use asperity_base::map::{Grid, HeightMap};
use asperity_base::monitor::Silent;
use asperity_contact::{Boundary, Control, HalfSpace, Solver, spectral_rms_gradient};
use asperity_friction::law::BowdenTabor;
use asperity_friction::replicates::MomentReplicates;
use asperity_friction::strip::{SolvedStrips, StripProblem, Strips};
use asperity_friction::window::Window;
use asperity_surface::{RandomSurface, SpectralField};
use ndarray::Array2;

const MODULUS_PA: f64 = 230e9;

/// One wave along the strip.
struct Wave {
    grid: Grid,
    amplitude_m: f64,
}

impl RandomSurface for Wave {
    fn xi_len(&self) -> usize {
        0
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn generate(&self, _: &[f64]) -> HeightMap {
        let (rows, columns) = self.grid.shape();
        let height =
            |(_, column): (usize, usize)| self.amplitude_m * (2.0 * PI * (column as f64 + 0.5) / columns as f64).cos();
        HeightMap::new(self.grid, Array2::from_shape_fn((rows, columns), height)).unwrap()
    }
}

fn problem(grid: Grid, boundary: Boundary, hardness_pa: Option<f64>) -> StripProblem {
    StripProblem {
        valid_share: 0.95,
        half_space: HalfSpace::new(grid, MODULUS_PA, boundary).unwrap(),
        window: Window::new(16.0 * grid.dx_m(), grid).unwrap(),
        law: Arc::new(BowdenTabor { shear_strength_pa: 385e6 }),
        hardness_pa,
        solver: Solver { tolerance: 1e-7, ..Solver::default() },
    }
}

fn periodic(grid: Grid) -> Boundary {
    Boundary::Periodic { mean_compliance_m_per_pa: HalfSpace::default_mean_compliance_m_per_pa(grid, MODULUS_PA) }
}

/// Solves strips at mean pressures and computes the stiffness at the last of them.
fn solve(
    problem: &StripProblem,
    surface: &dyn RandomSurface,
    strips: usize,
    pressures_pa: &[f64],
) -> Vec<SolvedStrips> {
    let controls: Vec<Control> = pressures_pa.iter().map(|pascal| Control::MeanPressure { pascal: *pascal }).collect();
    let strips = Strips { stiff_level: Some(controls.len() - 1), ..problem.strips(surface, strips, 5) };
    strips.solve(&controls, &Silent).unwrap().into_iter().map(Result::unwrap).collect()
}

#[test]
fn one_wave_has_the_stiffness_of_westergaard() {
    // From the mean gap ḡ = h(1 − s + s ln s) with s = p̄/p*: −dp̄/dḡ = p*/(h ln(1/s)).
    let (columns, amplitude_m) = (1024, 0.1e-6);
    let grid = Grid::new(columns, 4, 1e-7, 1e-7).unwrap();
    let full_pa = PI * MODULUS_PA * amplitude_m / grid.width_m();
    let problem = problem(grid, periodic(grid), None);
    for s in [0.1, 0.25, 0.5, 0.75_f64] {
        let levels = solve(&problem, &Wave { grid, amplitude_m }, 1, &[0.9 * s * full_pa, s * full_pa]);
        assert!(levels[0].stiffness_pa_per_m().is_none(), "only the stated level has a stiffness");
        let (found, standard_error) = levels[1].stiffness_pa_per_m().unwrap();
        let exact = full_pa / (amplitude_m * (1.0 / s).ln());
        // The contact width 2a with s = sin²(πa/λ) is known to one cell on each side: d ln k = 2π cot(πa/λ) da/λ / ln(1/s).
        let tolerance = 2.0 * PI * ((1.0 - s) / s).sqrt() / columns as f64 / (1.0 / s).ln();
        assert!((found / exact - 1.0).abs() < tolerance, "{s}: {found:e} {exact:e}");
        assert!(standard_error.is_nan(), "one strip has no standard error");
    }
}

#[test]
fn stiffness_is_proportional_to_the_pressure_on_a_self_affine_surface() {
    // k = p̄/(γ h_rms) with γ about .5 at light loads: B. N. J. Persson, Phys. Rev. Lett. 99 (2007) 125502,
    // doi 10.1103/PhysRevLett.99.125502.
    let grid = Grid::new(384, 192, 2e-6, 2e-6).unwrap();
    let model = CorrelationModel::SelfAffine { hurst: 0.8 };
    let rms_m = 0.5e-6;
    let surface = SpectralField::periodic(&Covariance::isotropic(model, rms_m, 8e-6).unwrap(), grid);
    let problem = problem(grid, periodic(grid), None);
    let strips = problem.strips(&surface, 1, 5);
    let pressure_pa = 0.02 * MODULUS_PA * spectral_rms_gradient(strips.map(0).heights_m(), grid);
    let [light, heavy] = [1.0, 2.0].map(|factor| {
        let level = solve(&problem, &surface, 4, &[factor * pressure_pa]).remove(0);
        let (mean, standard_error) = level.stiffness_pa_per_m().unwrap();
        (mean / (factor * pressure_pa), standard_error / (factor * pressure_pa))
    });
    for (per_pressure, standard_error) in [light, heavy] {
        let gamma = 1.0 / (per_pressure * rms_m);
        assert!((gamma - 0.5).abs() < 0.1 + 2.0 * gamma * standard_error / per_pressure, "{gamma}");
    }
    assert!((heavy.0 / light.0 - 1.0).abs() < 0.05, "{light:?} {heavy:?}");
}

#[test]
fn replicates_leave_one_strip_out_and_plastic_cells_unload_elastically() {
    let grid = Grid::new(256, 32, 2e-6, 2e-6).unwrap();
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 0.5e-6, 12e-6).unwrap();
    let surface = SpectralField::periodic(&covariance, grid);
    let plastic = problem(grid, periodic(grid), Some(1e9));
    let level = solve(&plastic, &surface, 3, &[1e8]).remove(0);
    assert!(level.plastic_fraction() > 0.5, "{}", level.plastic_fraction());
    let strips = &level.strip_stiffnesses_pa_per_m;
    let replicates = MomentReplicates::from_mean_load(&level, plastic.window.step_m());
    assert_eq!(replicates.all.stiffness_pa_per_m, level.stiffness_pa_per_m().unwrap().0);
    for (index, without) in replicates.without.iter().enumerate() {
        let others = strips.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, stiffness)| stiffness);
        let mean = others.sum::<f64>() / 2.0;
        assert!((without.stiffness_pa_per_m / mean - 1.0).abs() < 1e-12);
    }
    // A plastic contact has the larger area of p̄/H; as an elastic contact of that area it is stiffer than the elastic one.
    let elastic = solve(&problem(grid, periodic(grid), None), &surface, 3, &[1e8]).remove(0);
    assert!(level.contact_fraction > elastic.contact_fraction);
    assert!(replicates.all.stiffness_pa_per_m > elastic.stiffness_pa_per_m().unwrap().0);
}

#[test]
fn a_free_strip_has_no_stiffness() {
    let grid = Grid::new(256, 16, 1e-7, 1e-7).unwrap();
    let level = solve(&problem(grid, Boundary::Free, None), &Wave { grid, amplitude_m: 1e-8 }, 2, &[1e8]).remove(0);
    assert!(level.stiffness_pa_per_m().is_none() && level.strip_stiffnesses_pa_per_m.is_empty());
}
