//! Stiffness of a contact with respect to the approach of its plane.

use crate::FailureReason;
use asperity_base::monitor::Silent;
use asperity_contact::{Boundary, ContactWorkspace, HalfSpace, Solution, StiffnessSolver};

/// Tolerance of the stiffness of fine contacts, which has an error of second order, and of coarse contacts.
pub(super) const TOLERANCE: f64 = 1e-4;
pub(super) const LOOSE_TOLERANCE: f64 = 1e-2;

/// Returns the rise dp̄/dδ of the mean pressure as the plane approaches, in Pa/m, for a fixed contact area.
///
/// It is 1/(1/k + c) with the stiffness k of the interface ([`StiffnessSolver`], loading) and the mean compliance c of
/// a periodic half-space (0 for the free boundary): 0 without contact, 1/c in complete contact.
pub(super) fn approach_stiffness_pa_per_m(
    half_space: &HalfSpace,
    solution: &Solution,
    tolerance: f64,
    workspace: &mut ContactWorkspace,
) -> Result<Approach, FailureReason> {
    let solver = StiffnessSolver { tolerance, ..StiffnessSolver::default() };
    let found = solver.solve_in(half_space, solution, workspace, &Silent)?;
    let short = (!found.converged).then_some(FailureReason::Stiffness {
        iterations: found.iterations,
        residual: found.residual,
        tolerance,
    });
    Ok(Approach { pascal_per_m: 1.0 / (1.0 / found.pascal_per_m + mean_compliance_m_per_pa(half_space)), short })
}

/// Stiffness, with the reason if it did not converge.
pub(super) struct Approach {
    pub(super) pascal_per_m: f64,
    pub(super) short: Option<FailureReason>,
}

/// Returns the upper bound of the stiffness of contacts on a half-space, the stiffness of its mean mode.
pub(super) fn largest_pa_per_m(half_space: &HalfSpace) -> f64 {
    1.0 / mean_compliance_m_per_pa(half_space)
}

fn mean_compliance_m_per_pa(half_space: &HalfSpace) -> f64 {
    match half_space.boundary() {
        Boundary::Free => 0.0,
        Boundary::Periodic { mean_compliance_m_per_pa } => mean_compliance_m_per_pa,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::Problem;
    use crate::testing::{Shape, gaussian_surface};
    use asperity_base::correlation::{CorrelationModel, Covariance};
    use asperity_base::map::Grid;
    use asperity_base::random::{standard_normal, stream};
    use asperity_contact::{Control, Solver};
    use asperity_surface::{RandomSurface, SpectralField};

    #[test]
    fn complete_contact_has_the_stiffness_of_the_mean_mode_and_no_contact_none() {
        let compliance = 4e-15;
        let grid = Grid::with_size(8, 8, 1e-4, 1e-4).unwrap();
        let wave = Shape::new(grid, 1e-6, |x, _| 1e-10 * (TAU * x / 1e-4).cos());
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: compliance };
        let half_space = HalfSpace::new(grid, 2e11, boundary).unwrap();
        let problem = Problem::new(&wave, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let stiffness = |problem: &Problem<'_>, xi: f64| {
            problem.observe(&[xi], &mut half_space.workspace()).unwrap().stiffness_pa_per_m
        };
        assert_eq!(stiffness(&problem, 1.0), None);
        assert_eq!(stiffness(&problem.with_stiffness(), 1.0), Some(1.0 / compliance));
        assert_eq!(stiffness(&problem.with_stiffness(), -1.0), Some(0.0));
    }

    #[test]
    fn a_pressed_wave_yields_with_its_interface_and_its_mean_mode_in_series() {
        // Westergaard with s = p̄/p*: the mean gap falls by λ ln(1/s)/(π E*) per mean pressure.
        let grid = Grid::with_size(256, 4, 1.0, 4.0 / 256.0).unwrap();
        let wave = Shape::new(grid, 1.0, |x, _| 0.01 * (TAU * x).cos());
        let compliance = 0.2;
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: compliance };
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        let full_pa = std::f64::consts::PI * 0.01;
        for s in [0.2, 0.5] {
            let control = Control::MeanPressure { pascal: s * full_pa };
            let problem = Problem::new(&wave, &half_space, control, None).unwrap().with_stiffness();
            let found = problem.observe(&[0.0], &mut half_space.workspace()).unwrap().stiffness_pa_per_m.unwrap();
            let wanted = 1.0 / ((1.0 / s).ln() / std::f64::consts::PI + compliance);
            assert!((found / wanted - 1.0).abs() < 0.01, "{found} {wanted}");
        }
    }

    /// Compares the mean stiffness over maps with central differences of the mean pressure of the same maps, and bounds
    /// the fraction of maps on which both agree. The load is piecewise linear in the approach, and some maps have a
    /// kink in between.
    fn against_differences(surface: &dyn RandomSurface, half_space: &HalfSpace, hardness_pa: Option<f64>) {
        let (step_m, count) = (1e-4, 40);
        let solver = Solver { tolerance: 1e-11, ..Solver::default() };
        let under = |height_m: f64| {
            let control = Control::Plane { height_m };
            Problem::new(surface, half_space, control, hardness_pa).unwrap().with_solver(solver)
        };
        let mut workspace = half_space.workspace();
        let (mut sums, mut agree, mut plastic) = ([0.0; 2], 0, 0);
        for i in 0..count {
            let xi = standard_normal(&mut stream(3, "stiffness", i), surface.xi_len());
            let solution = under(0.3).solve(&xi, &mut workspace).unwrap();
            plastic += usize::from(solution.pressure_pa().iter().any(|p| Some(*p) == hardness_pa));
            let found = under(0.3).with_stiffness().observe(&xi, &mut workspace).unwrap().stiffness_pa_per_m.unwrap();
            let mut load = |height_m: f64| under(height_m).observe(&xi, &mut workspace).unwrap().mean_pressure_pa;
            let wanted = (load(0.3 - step_m) - load(0.3 + step_m)) / (2.0 * step_m);
            agree += usize::from((found - wanted).abs() <= 1e-5 * wanted);
            sums = [sums[0] + found, sums[1] + wanted];
        }
        assert!(hardness_pa.is_none() || plastic > count as usize / 2, "{plastic}");
        assert!(agree as f64 >= 0.7 * count as f64, "{agree}");
        assert!((sums[0] / sums[1] - 1.0).abs() < 2e-3, "{sums:?}");
    }

    #[test]
    fn the_stiffness_is_the_slope_of_the_load_as_the_plane_moves() {
        let (surface, half_space) = gaussian_surface(16, 30);
        against_differences(&surface, &half_space, None);
        against_differences(&surface, &half_space, Some(2.0));
        let grid = surface.grid();
        let covariance = Covariance::new(CorrelationModel::SquaredExponential, 1.0, 0.2, 0.2).unwrap();
        let periodic = SpectralField::periodic(&covariance, grid);
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.3 };
        let half_space = HalfSpace::new(grid, 1.0, boundary).unwrap();
        against_differences(&periodic, &half_space, None);
        against_differences(&periodic, &half_space, Some(2.0));
    }
}
