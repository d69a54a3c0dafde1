//! Independent evaluation of contact solutions from the pressure alone.

use asperity_base::fourier::{Complex64, RealFft2, signed_index};
use asperity_base::map::Grid;
use asperity_contact::{Boundary, ContactProblem, Control, Solution, love_coefficient};

/// Compliance of a half-space, applied by a transform on twice the patch (free) or on the patch (periodic).
pub(crate) struct Operator {
    grid: Grid,
    fft: RealFft2,
    spectrum: Vec<Complex64>,
}

impl Operator {
    /// Creates the operator from the definitions of the kernels: Love's coefficient for every lag, or 2/(E*|q|) for
    /// every wave.
    pub(crate) fn new(grid: Grid, modulus_pa: f64, boundary: Boundary) -> Self {
        let (nx, ny) = (grid.nx(), grid.ny());
        match boundary {
            Boundary::Free => {
                let fft = RealFft2::new(2 * nx, 2 * ny);
                let mut kernel = vec![0.0; 4 * nx * ny];
                for row in 0..2 * ny {
                    for column in 0..2 * nx {
                        let x = signed_index(column, 2 * nx).abs() * grid.dx_m();
                        let y = signed_index(row, 2 * ny).abs() * grid.dy_m();
                        kernel[row * 2 * nx + column] = love_coefficient(x, y, grid.dx_m(), grid.dy_m(), modulus_pa);
                    }
                }
                let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
                fft.forward(&kernel, &mut spectrum, &mut work);
                Self { grid, fft, spectrum }
            }
            Boundary::Periodic { mean_compliance_m_per_pa } => {
                let fft = RealFft2::new(nx, ny);
                let mut spectrum = fft.spectrum();
                for (i, value) in spectrum.iter_mut().enumerate() {
                    let wave_x = (i / ny) as f64 / grid.width_m();
                    let wave_y = signed_index(i % ny, ny) / grid.height_m();
                    let q = std::f64::consts::TAU * wave_x.hypot(wave_y);
                    value.re = if i == 0 { mean_compliance_m_per_pa } else { 2.0 / (modulus_pa * q) };
                }
                Self { grid, fft, spectrum }
            }
        }
    }

    /// Computes the displacement of the pressure `p`, row by row.
    pub(crate) fn displace(&self, p: &[f64]) -> Vec<f64> {
        let (rows, columns) = self.grid.shape();
        let (mut spectrum, mut work) = (self.fft.spectrum(), self.fft.workspace());
        self.fft.forward_padded(p, rows, columns, &mut spectrum, &mut work);
        for (value, factor) in spectrum.iter_mut().zip(&self.spectrum) {
            *value *= *factor;
        }
        let mut u = vec![0.0; p.len()];
        self.fft.inverse_cropped(&mut spectrum, &mut u, rows, columns, &mut work);
        u
    }
}

/// Violations of the optimality conditions over the standard deviation of the heights, and the energy.
#[derive(Debug)]
pub(crate) struct Evaluation {
    pub(crate) frank_wolfe: f64,
    pub(crate) overlap: f64,
    /// Relative error of the prescribed quantity: load, mean gap, or height of the plane over the standard deviation.
    pub(crate) prescribed: f64,
    /// Mean of ½pu − p(z − d), where d is the plane if it is prescribed and the mean height otherwise.
    #[allow(dead_code, reason = "each test that shares this module reads what it needs")]
    pub(crate) energy: f64,
}

/// Evaluates a solution from its pressure and its plane.
pub(crate) fn evaluate(operator: &Operator, problem: &ContactProblem<'_>, solution: &Solution) -> Evaluation {
    let p: Vec<f64> = solution.pressure_pa().iter().copied().collect();
    let z: Vec<f64> = problem.heights_m().iter().copied().collect();
    let u = operator.displace(&p);
    let hardness_pa = problem.hardness_pa().unwrap_or(f64::INFINITY);
    let (points, rms) = (p.len() as f64, problem.rms_height_m());
    let gap: Vec<f64> = (0..p.len()).map(|i| u[i] - (z[i] - solution.plane_m())).collect();
    let least = (0..p.len()).filter(|&i| p[i] < hardness_pa).map(|i| gap[i]).fold(f64::INFINITY, f64::min);
    let from = if problem.control().prescribes_plane() { 0.0 } else { least };
    let sum: f64 = p.iter().sum();
    let work: f64 = (0..p.len()).map(|i| p[i] * (gap[i] - from).max(0.0)).sum();
    let mean_pressure = sum / points;
    let mean_gap = (0..p.len()).map(|i| if p[i] > 0.0 { 0.0 } else { gap[i].max(0.0) }).sum::<f64>() / points;
    let prescribed = match problem.control() {
        Control::MeanPressure { pascal } => mean_pressure / pascal - 1.0,
        Control::Load { newton } => mean_pressure * problem.half_space().grid().area_m2() / newton - 1.0,
        Control::MeanGap { metre } => mean_gap / metre - 1.0,
        _ => (problem.plane_m().unwrap_or(f64::NAN) - solution.plane_m()) / rms,
    };
    let from_m = if problem.control().prescribes_plane() { solution.plane_m() } else { problem.mean_height_m() };
    Evaluation {
        frank_wolfe: if sum > 0.0 { work / (sum * rms) } else { 0.0 },
        overlap: (-least).max(0.0) / rms,
        prescribed: prescribed.abs(),
        energy: energy(&p, &u, &z, from_m),
    }
}

/// Returns the mean of ½pu − p(z − d).
pub(crate) fn energy(p: &[f64], u: &[f64], z: &[f64], plane_m: f64) -> f64 {
    (0..p.len()).map(|i| p[i] * (0.5 * u[i] - (z[i] - plane_m))).sum::<f64>() / p.len() as f64
}
