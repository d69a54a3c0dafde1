//! Weierstrass–Mandelbrot profiles and surfaces, Gaus et al. 2016, eq. (1).

#[cfg(test)]
mod tests;

use std::f64::consts::{PI, TAU};

use super::gaussian::{check_xi, map_of};
use super::{GeneratorError, RandomSurface};
use asperity_base::distribution::standard_normal_cdf;
use asperity_base::fourier::Complex64;
use asperity_base::map::{Grid, HeightMap};

fn check(parameter: &'static str, value: f64, valid: bool, wanted: &'static str) -> Result<(), GeneratorError> {
    if valid && value.is_finite() { Ok(()) } else { Err(GeneratorError::Parameter { parameter, value, wanted }) }
}

/// Weierstrass–Mandelbrot surface in the generalisation of Ausloos and Berman,
///
/// z(x) = G^{D−2} √(ln γ/M) Σ_{m=1}^{M} Σ_j γ^{(D−3)j} cos(γ^j (x cos α_m + y sin α_m) + φ_mj), α_m = πm/M, 2 < D < 3,
///
/// with a fractal roughness G in metre. A profile of it has dimension D − 1 and Hurst exponent 3 − D. With one ridge it
/// is eq. (1) of the paper times √(ln γ). The wavenumbers are γ^j = (2π/L)γ^k, k = 0, 1, … up to the grid's Nyquist
/// wavenumber, with L the longer side. ξ determines the phases, φ = 2πΦ(ξ), wavenumber by wavenumber from the lowest,
/// all ridges of one before the next.
///
/// Heights are sums of cosines with uniform phases. They are close to Gaussian for many terms, but not a linear
/// function of ξ.
///
/// # References
/// Ausloos & Berman, *Proc. R. Soc. A* **400** (1985) 331, <https://doi.org/10.1098/rspa.1985.0083>; Yan & Komvopoulos,
/// *J. Appl. Phys.* **84** (1998) 3617, <https://doi.org/10.1063/1.368536>. Profiles: Berry & Lewis, *Proc. R. Soc. A*
/// **370** (1980) 459, <https://doi.org/10.1098/rspa.1980.0044>; Majumdar & Tien, *Wear* **136** (1990) 313,
/// <https://doi.org/10.1016/0043-1648(90)90154-3>.
#[derive(Debug, Clone)]
pub struct WeierstrassMandelbrot {
    grid: Grid,
    /// G^{D−2}. G itself underflows for D near 2.
    scale: f64,
    waves: Vec<Wave>,
}

/// One cosine: its wavevector in rad/m and its amplitude over G^{D−2}.
#[derive(Debug, Clone, Copy)]
struct Wave {
    qx: f64,
    qy: f64,
    amplitude: f64,
}

/// Returns the waves of all wavenumbers in rad/m along all angles: amplitude √(ln γ/M) γ^{(D−3)j} with γ^j the
/// wavenumber.
fn waves(wavenumbers: impl Iterator<Item = f64>, angles: &[f64], dimension: f64, gamma: f64) -> Vec<Wave> {
    let norm = (gamma.ln() / angles.len() as f64).sqrt();
    let of_one = |q: f64| {
        let amplitude = norm * q.powf(dimension - 3.0);
        angles.iter().map(move |angle| Wave { qx: q * angle.cos(), qy: q * angle.sin(), amplitude })
    };
    wavenumbers.flat_map(of_one).collect()
}

impl WeierstrassMandelbrot {
    /// Creates a surface of fractal dimension 2 < D < 3 with `ridges` directions and fractal roughness G.
    ///
    /// # Errors
    /// D outside (2, 3), γ not above 1, G not positive, or no ridge.
    pub fn new(
        grid: Grid,
        dimension: f64,
        gamma: f64,
        ridges: usize,
        roughness_m: f64,
    ) -> Result<Self, GeneratorError> {
        check("dimension", dimension, dimension > 2.0 && dimension < 3.0, "in (2, 3)")?;
        check("ridges", ridges as f64, ridges > 0, "at least 1")?;
        check("gamma", gamma, gamma > 1.0, "above 1")?;
        check("roughness_m", roughness_m, roughness_m > 0.0, "positive")?;
        let (length_m, nyquist) = (grid.width_m().max(grid.height_m()), PI / grid.dx_m().max(grid.dy_m()));
        // The first wavenumber is always included, also on a grid too coarse for a second.
        let first = TAU / length_m;
        let more = std::iter::successors(Some(first * gamma), |q| Some(q * gamma));
        let wavenumbers = std::iter::once(first).chain(more.take_while(|q| *q <= nyquist * (1.0 + 1e-12)));
        let angles: Vec<f64> = (1..=ridges).map(|m| PI * m as f64 / ridges as f64).collect();
        let waves = waves(wavenumbers, &angles, dimension, gamma);
        Ok(Self { grid, scale: roughness_m.powf(dimension - 2.0), waves })
    }

    /// Returns the same surface with G such that the variance is `rms_height_m`².
    ///
    /// The rms height of one map about its own mean fluctuates around this value, mostly by its few longest waves.
    ///
    /// # Errors
    /// An rms height that is not positive.
    pub fn with_rms_height(mut self, rms_height_m: f64) -> Result<Self, GeneratorError> {
        check("rms_height_m", rms_height_m, rms_height_m > 0.0, "positive")?;
        self.scale *= rms_height_m / self.variance_m2().sqrt();
        Ok(self)
    }

    /// Returns the variance in m².
    fn variance_m2(&self) -> f64 {
        let sum: f64 = self.waves.iter().map(|wave| wave.amplitude * wave.amplitude).sum();
        0.5 * self.scale * self.scale * sum
    }
}

impl RandomSurface for WeierstrassMandelbrot {
    fn xi_len(&self) -> usize {
        self.waves.len()
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        check_xi(xi, self.xi_len());
        let (ny, nx) = self.grid.shape();
        let mut heights = vec![0.0; nx * ny];
        let mut along_x = vec![Complex64::default(); nx];
        for (wave, xi) in self.waves.iter().zip(xi) {
            let phase = TAU * standard_normal_cdf(*xi);
            // cos(a + b) = Re e^{ia} e^{ib}: nx + ny sines and cosines instead of nx·ny.
            for (column, value) in along_x.iter_mut().enumerate() {
                *value = Complex64::cis(wave.qx * column as f64 * self.grid.dx_m());
            }
            let amplitude = self.scale * wave.amplitude;
            for (row, line) in heights.chunks_exact_mut(nx).enumerate() {
                let along_y = Complex64::cis(wave.qy * row as f64 * self.grid.dy_m() + phase) * amplitude;
                for (z, x) in line.iter_mut().zip(&along_x) {
                    *z += x.re * along_y.re - x.im * along_y.im;
                }
            }
        }
        map_of(self.grid, heights)
    }
}
