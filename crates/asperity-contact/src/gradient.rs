//! Root-mean-square gradient h'rms of a map, the scale of contact area and pressure in theories.

use ndarray::Array2;

use crate::Boundary;
use asperity_base::fourier::{RealFft2, signed_index};
use asperity_base::map::Grid;

/// Returns the root-mean-square gradient √⟨|∇z|²⟩ by forward differences, dimensionless; `heights_m` has shape `[ny,
/// nx]`.
///
/// On the periodic boundary the mean is over all cells, and the last row and column neighbour the first. On the free
/// boundary it is over cells with a right and a lower neighbour: Sdq of ISO 25178-2 by the simplest stencil. The
/// differences multiply the gradient of a wave of wavenumber q by sin(qΔ/2)/(qΔ/2). A missing height makes the result
/// NaN.
///
/// # Panics
/// If the map does not fit the grid.
pub fn rms_gradient(heights_m: &Array2<f64>, grid: Grid, boundary: Boundary) -> f64 {
    assert_eq!(heights_m.dim(), grid.shape(), "the map does not fit the grid");
    let (ny, nx) = grid.shape();
    let (rows, columns) = match boundary {
        Boundary::Free => (ny - 1, nx - 1),
        Boundary::Periodic { .. } => (ny, nx),
    };
    let mut sum = 0.0;
    for row in 0..rows {
        for column in 0..columns {
            let z = heights_m[[row, column]];
            let along_x = (heights_m[[row, (column + 1) % nx]] - z) / grid.dx_m();
            let along_y = (heights_m[[(row + 1) % ny, column]] - z) / grid.dy_m();
            sum += along_x * along_x + along_y * along_y;
        }
    }
    (sum / (rows * columns) as f64).sqrt()
}

/// Returns the root-mean-square gradient of a periodic map from its spectrum, √Σ|q|²|ẑ|², dimensionless, without
/// damping.
///
/// E*/2 times this gradient is the standard deviation of the pressure in complete contact on a periodic half-space, as
/// used in Persson's theory. On maps rough down to the cell it exceeds [`rms_gradient`], for white noise by a factor of
/// 1.28.
///
/// # Panics
/// If the map does not fit the grid.
pub fn spectral_rms_gradient(heights_m: &Array2<f64>, grid: Grid) -> f64 {
    assert_eq!(heights_m.dim(), grid.shape(), "the map does not fit the grid");
    let (ny, nx) = grid.shape();
    let fft = RealFft2::new(nx, ny);
    let mut spectrum = fft.spectrum();
    // Without subtraction the mean would add its rounding error to every wave.
    let mean_m = heights_m.sum() / grid.points() as f64;
    let heights: Vec<f64> = heights_m.iter().map(|z| z - mean_m).collect();
    fft.forward(&heights, &mut spectrum, &mut fft.workspace());
    let step_x = std::f64::consts::TAU / grid.width_m();
    let step_y = std::f64::consts::TAU / grid.height_m();
    let mut sum = 0.0;
    for (kx, waves) in spectrum.chunks(ny).enumerate() {
        let along: f64 = waves.iter().enumerate().fold(0.0, |along, (ky, wave)| {
            let q2 = (step_x * kx as f64).powi(2) + (step_y * signed_index(ky, ny)).powi(2);
            along + q2 * wave.norm_sqr()
        });
        sum += fft.multiplicity(kx) * along;
    }
    sum.sqrt() / grid.points() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;
    use std::f64::consts::{PI, TAU};

    const PERIODIC: Boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };

    #[test]
    fn differences_damp_the_gradient_of_a_wave_and_the_spectrum_does_not() {
        let grid = Grid::new(48, 30, 0.5, 0.25).unwrap();
        let (qx, qy, h) = (5.0 * TAU / grid.width_m(), -3.0 * TAU / grid.height_m(), 0.01);
        let (dx, dy) = (grid.dx_m(), grid.dy_m());
        let wave = Array2::from_shape_fn((30, 48), |(row, column)| {
            7.0 + h * (qx * dx * column as f64 + qy * dy * row as f64 + 0.3).cos()
        });
        let exact = h * qx.hypot(qy) / 2.0_f64.sqrt();
        assert!((spectral_rms_gradient(&wave, grid) / exact - 1.0).abs() < 1e-12);
        let damped = |q: f64, pitch: f64| 2.0 / pitch * (0.5 * q * pitch).sin();
        let wanted = h * damped(qx, dx).hypot(damped(qy, dy)) / 2.0_f64.sqrt();
        assert!((rms_gradient(&wave, grid, PERIODIC) / wanted - 1.0).abs() < 1e-10);
    }

    #[test]
    fn a_plane_has_its_slope_on_the_free_boundary() {
        let grid = Grid::new(7, 5, 0.5, 0.25).unwrap();
        let plane = Array2::from_shape_fn((5, 7), |(row, column)| 3.0 * 0.5 * column as f64 - 4.0 * 0.25 * row as f64);
        assert!((rms_gradient(&plane, grid, Boundary::Free) - 5.0).abs() < 1e-13);
        assert!(rms_gradient(&plane, grid, PERIODIC) > 5.0);
    }

    #[test]
    fn white_noise_has_its_known_gradients() {
        // Mean square per axis: 2 by differences, π²/3 by the spectrum, each over the pitch squared; the relative
        // standard error of a mean square over 65,536 cells stays below 1 %.
        let n = 256;
        let grid = Grid::new(n, n, 1.0, 1.0).unwrap();
        let noise = random::standard_normal(&mut random::stream(2, "gradient", 0), n * n);
        let noise = Array2::from_shape_vec((n, n), noise).unwrap();
        assert!((rms_gradient(&noise, grid, PERIODIC) / 2.0 - 1.0).abs() < 0.01);
        assert!((spectral_rms_gradient(&noise, grid) / (2.0 / 3.0_f64).sqrt() / PI - 1.0).abs() < 0.01);
    }
}
