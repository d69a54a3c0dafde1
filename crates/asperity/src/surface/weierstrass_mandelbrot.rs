//! Weierstrass–Mandelbrot profiles and surfaces, Gaus et al. 2016, eq. (1).

use std::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};

use super::gaussian::{check_germ, map_of};
use super::{GeneratorError, RandomSurface};
use crate::fourier::Complex64;
use crate::law::standard_normal_cdf;
use crate::map::{Grid, HeightMap};

/// How the sum over frequencies, which diverges towards the low ones, is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WeierstrassForm {
    /// Σ γ^{(D−2)j} cos(γ^j x + φ_j) over a finite range of j: stationary.
    Truncated,
    /// Σ γ^{(D−2)j} [cos φ_j − cos(γ^j x + φ_j)], which converges over all j: zero at the origin, with stationary
    /// increments.
    Convergent,
}

fn check(parameter: &'static str, value: f64, valid: bool, wanted: &'static str) -> Result<(), GeneratorError> {
    if valid && value.is_finite() { Ok(()) } else { Err(GeneratorError::Parameter { parameter, value, wanted }) }
}

/// A Weierstrass–Mandelbrot profile z(x) = G^{D−1} Σ_{j=j₁}^{j₂} γ^{(D−2)j} cos(γ^j x + φ_j), or its convergent form.
///
/// γ^j is an angular wavenumber in rad/m, G a length in metre, D the fractal dimension of the graph.
///
/// # References
/// Berry & Lewis, *Proc. R. Soc. A* **370** (1980) 459, <https://doi.org/10.1098/rspa.1980.0044>; Majumdar & Tien,
/// *Wear* **136** (1990) 313, <https://doi.org/10.1016/0043-1648(90)90154-3>.
#[derive(Debug, Clone, PartialEq)]
pub struct WeierstrassProfile {
    dimension: f64,
    gamma: f64,
    roughness_m: f64,
    form: WeierstrassForm,
    exponents: Vec<f64>,
}

impl WeierstrassProfile {
    /// The sum over whole j from `first` to `last`, with fractal roughness G.
    ///
    /// # Errors
    /// D outside (1, 2), γ not above 1, G not positive, or an empty range.
    pub fn new(
        dimension: f64,
        gamma: f64,
        roughness_m: f64,
        first: i32,
        last: i32,
        form: WeierstrassForm,
    ) -> Result<Self, GeneratorError> {
        check("dimension", dimension, dimension > 1.0 && dimension < 2.0, "in (1, 2)")?;
        check("gamma", gamma, gamma > 1.0, "above 1")?;
        check("roughness_m", roughness_m, roughness_m > 0.0, "positive")?;
        check("last", f64::from(last), last >= first, "at least the first exponent")?;
        let exponents = (first..=last).map(f64::from).collect();
        Ok(Self { dimension, gamma, roughness_m, form, exponents })
    }

    /// Wavenumbers γ^j in rad/m, rising.
    pub fn wavenumbers_rad_per_m(&self) -> Vec<f64> {
        self.exponents.iter().map(|j| self.gamma.powf(*j)).collect()
    }

    /// Amplitudes G^{D−1} γ^{(D−2)j} in metre, falling.
    pub fn amplitudes_m(&self) -> Vec<f64> {
        let scale = self.roughness_m.powf(self.dimension - 1.0);
        self.exponents.iter().map(|j| scale * self.gamma.powf((self.dimension - 2.0) * j)).collect()
    }

    /// Height in metre at x for the given phases in radian.
    ///
    /// # Panics
    /// If there is not one phase per term.
    pub fn height_m(&self, x_m: f64, phases: &[f64]) -> f64 {
        assert_eq!(phases.len(), self.exponents.len(), "one phase per term");
        let terms = self.wavenumbers_rad_per_m().into_iter().zip(self.amplitudes_m()).zip(phases);
        terms
            .map(|((q, amplitude), phase)| match self.form {
                WeierstrassForm::Truncated => amplitude * (q * x_m + phase).cos(),
                WeierstrassForm::Convergent => amplitude * (phase.cos() - (q * x_m + phase).cos()),
            })
            .sum()
    }

    /// Variance ½ G^{2(D−1)} Σ γ^{2(D−2)j} of the stationary part, in m².
    pub fn variance_m2(&self) -> f64 {
        0.5 * self.amplitudes_m().iter().map(|a| a * a).sum::<f64>()
    }

    /// Structure function E (z(x + τ) − z(x))² = G^{2(D−1)} Σ γ^{2(D−2)j} (1 − cos γ^jτ) in m²; that of both forms.
    ///
    /// Over all j it obeys S(γτ) = γ^{2(2−D)} S(τ).
    pub fn structure_function_m2(&self, lag_m: f64) -> f64 {
        let terms = self.wavenumbers_rad_per_m().into_iter().zip(self.amplitudes_m());
        // 1 − cos by the half angle, which keeps the small ones.
        terms.map(|(q, amplitude)| 2.0 * (amplitude * (0.5 * q * lag_m).sin()).powi(2)).sum()
    }
}

/// A Weierstrass–Mandelbrot surface in the generalisation of Ausloos and Berman,
///
/// z(x) = G^{D−2} √(ln γ/M) Σ_{m=1}^{M} Σ_j γ^{(D−3)j} cos(γ^j (x cos α_m + y sin α_m) + φ_mj), α_m = πm/M, 2 < D < 3,
///
/// or its convergent form; a profile of it has dimension D − 1 and Hurst exponent 3 − D. The wavenumbers are
/// γ^j = (2π/L)γ^k, k = 0, 1, … up to the grid's Nyquist wavenumber, with L the longer side. The germ sets the phases,
/// φ = 2πΦ(ξ), wavenumber by wavenumber from the lowest, all ridges of one before the next.
///
/// Heights are sums of cosines with uniform phases: close to Gaussian for many terms, but not a linear function of the
/// germ.
///
/// # References
/// Ausloos & Berman, *Proc. R. Soc. A* **400** (1985) 331, <https://doi.org/10.1098/rspa.1985.0083>; Yan & Komvopoulos,
/// *J. Appl. Phys.* **84** (1998) 3617, <https://doi.org/10.1063/1.368536>.
#[derive(Debug, Clone)]
pub struct WeierstrassMandelbrot {
    grid: Grid,
    dimension: f64,
    gamma: f64,
    roughness_m: f64,
    form: WeierstrassForm,
    waves: Vec<Wave>,
}

/// One cosine: its wavevector in rad/m and its amplitude over G^{D−2}.
#[derive(Debug, Clone, Copy)]
struct Wave {
    qx: f64,
    qy: f64,
    amplitude: f64,
}

impl WeierstrassMandelbrot {
    /// A surface of fractal dimension 2 < D < 3 with `ridges` directions and fractal roughness G.
    ///
    /// # Errors
    /// D outside (2, 3), γ not above 1, G not positive, or no ridge.
    pub fn new(
        grid: Grid,
        dimension: f64,
        gamma: f64,
        ridges: usize,
        roughness_m: f64,
        form: WeierstrassForm,
    ) -> Result<Self, GeneratorError> {
        check("dimension", dimension, dimension > 2.0 && dimension < 3.0, "in (2, 3)")?;
        check("ridges", ridges as f64, ridges > 0, "at least 1")?;
        let angles: Vec<f64> = (1..=ridges).map(|m| PI * m as f64 / ridges as f64).collect();
        Self::with_ridges(grid, dimension, gamma, &angles, roughness_m, form)
    }

    /// A corrugation along y whose profile along x is eq. (1) with dimension 1 < D < 2: one ridge, without the factor
    /// √(ln γ). The wavenumbers start at 2π over the width.
    ///
    /// # Errors
    /// D outside (1, 2), γ not above 1, or G not positive.
    pub fn corrugation(
        grid: Grid,
        profile_dimension: f64,
        gamma: f64,
        roughness_m: f64,
        form: WeierstrassForm,
    ) -> Result<Self, GeneratorError> {
        let valid = profile_dimension > 1.0 && profile_dimension < 2.0;
        check("profile_dimension", profile_dimension, valid, "in (1, 2)")?;
        let mut surface = Self::with_ridges(grid, profile_dimension + 1.0, gamma, &[0.0], roughness_m, form)?;
        for wave in &mut surface.waves {
            wave.amplitude /= gamma.ln().sqrt();
        }
        Ok(surface)
    }

    fn with_ridges(
        grid: Grid,
        dimension: f64,
        gamma: f64,
        angles: &[f64],
        roughness_m: f64,
        form: WeierstrassForm,
    ) -> Result<Self, GeneratorError> {
        check("gamma", gamma, gamma > 1.0, "above 1")?;
        check("roughness_m", roughness_m, roughness_m > 0.0, "positive")?;
        let (length_m, nyquist) = match angles {
            [0.0] => (grid.width_m(), PI / grid.dx_m()),
            _ => (grid.width_m().max(grid.height_m()), PI / grid.dx_m().max(grid.dy_m())),
        };
        let norm = (gamma.ln() / angles.len() as f64).sqrt();
        let mut waves = Vec::new();
        // The first wavenumber is always there, also on a grid too coarse for a second.
        let mut q = TAU / length_m;
        loop {
            // γ^{(D−3)j} with γ^j = q.
            let amplitude = norm * q.powf(dimension - 3.0);
            waves.extend(angles.iter().map(|angle| Wave { qx: q * angle.cos(), qy: q * angle.sin(), amplitude }));
            q *= gamma;
            if q > nyquist * (1.0 + 1e-12) {
                break;
            }
        }
        Ok(Self { grid, dimension, gamma, roughness_m, form, waves })
    }

    /// The same surface with G such that the variance of the stationary part is `rms_height_m`².
    ///
    /// The rms height of one map about its own mean fluctuates around this value, mostly by its few longest waves.
    ///
    /// # Errors
    /// An rms height that is not positive.
    pub fn with_rms_height(mut self, rms_height_m: f64) -> Result<Self, GeneratorError> {
        check("rms_height_m", rms_height_m, rms_height_m > 0.0, "positive")?;
        let factor = rms_height_m / self.variance_m2().sqrt();
        self.roughness_m *= factor.powf(1.0 / (self.dimension - 2.0));
        Ok(self)
    }

    /// Fractal dimension D of the surface.
    pub fn dimension(&self) -> f64 {
        self.dimension
    }

    /// Ratio γ of neighbouring wavenumbers.
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Fractal roughness G in metre.
    pub fn roughness_m(&self) -> f64 {
        self.roughness_m
    }

    fn scale(&self) -> f64 {
        self.roughness_m.powf(self.dimension - 2.0)
    }

    /// Variance of the stationary part in m².
    pub fn variance_m2(&self) -> f64 {
        let sum: f64 = self.waves.iter().map(|wave| wave.amplitude * wave.amplitude).sum();
        0.5 * self.scale() * self.scale() * sum
    }

    /// Structure function E (z(s + (x, y)) − z(s))² in m².
    pub fn structure_function_m2(&self, lag_x_m: f64, lag_y_m: f64) -> f64 {
        let sum: f64 = self
            .waves
            .iter()
            .map(|wave| 2.0 * (wave.amplitude * (0.5 * (wave.qx * lag_x_m + wave.qy * lag_y_m)).sin()).powi(2))
            .sum();
        self.scale() * self.scale() * sum
    }

    /// Heights for given phases in radian.
    ///
    /// # Panics
    /// If there is not one finite phase per wave.
    pub fn map(&self, phases: &[f64]) -> HeightMap {
        check_germ(phases, self.waves.len());
        let (ny, nx) = self.grid.shape();
        let mut heights = vec![0.0; nx * ny];
        let mut along_x = vec![Complex64::default(); nx];
        for (wave, phase) in self.waves.iter().zip(phases) {
            // cos(a + b) = Re e^{ia} e^{ib}: nx + ny sines and cosines instead of nx·ny.
            for (column, value) in along_x.iter_mut().enumerate() {
                *value = Complex64::cis(wave.qx * column as f64 * self.grid.dx_m());
            }
            let amplitude = self.scale() * wave.amplitude;
            let (sign, offset) = match self.form {
                WeierstrassForm::Truncated => (1.0, 0.0),
                WeierstrassForm::Convergent => (-1.0, amplitude * phase.cos()),
            };
            for (row, line) in heights.chunks_exact_mut(nx).enumerate() {
                let along_y = Complex64::cis(wave.qy * row as f64 * self.grid.dy_m() + phase) * (sign * amplitude);
                for (z, x) in line.iter_mut().zip(&along_x) {
                    *z += offset + x.re * along_y.re - x.im * along_y.im;
                }
            }
        }
        map_of(self.grid, heights)
    }
}

impl RandomSurface for WeierstrassMandelbrot {
    fn germ_len(&self) -> usize {
        self.waves.len()
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn generate(&self, germ: &[f64]) -> HeightMap {
        check_germ(germ, self.germ_len());
        let phases: Vec<f64> = germ.iter().map(|xi| TAU * standard_normal_cdf(*xi)).collect();
        self.map(&phases)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::{Axis, profile_spectrum};
    use crate::random;

    #[test]
    fn the_structure_function_of_the_two_sided_sum_is_self_affine() {
        for (dimension, gamma) in [(1.5, 1.5), (1.4, 1.7), (1.6, 1.5)] {
            let profile = WeierstrassProfile::new(dimension, gamma, 1.0, -60, 60, WeierstrassForm::Convergent).unwrap();
            // What the truncation leaves out is γ^{−60·2(2−D)} above and γ^{−60·2(D−1)} below.
            let left_out = gamma.powf(-120.0 * (2.0 - dimension)) + gamma.powf(-120.0 * (dimension - 1.0));
            for lag in [0.1, 1.0, 2.3] {
                let ratio = profile.structure_function_m2(gamma * lag) / profile.structure_function_m2(lag);
                let wanted = gamma.powf(2.0 * (2.0 - dimension));
                assert!((ratio / wanted - 1.0).abs() < 10.0 * left_out, "D {dimension}: {ratio} {wanted}");
            }
        }
    }

    #[test]
    fn the_variance_of_the_truncated_sum_is_the_published_number() {
        let profile = WeierstrassProfile::new(1.5, 1.5, 1.0, 0, 20, WeierstrassForm::Truncated).unwrap();
        assert!((profile.variance_m2() - 1.499_699_271).abs() < 5e-10);
    }

    #[test]
    fn random_phases_have_the_variance_and_the_structure_function() {
        let profile = WeierstrassProfile::new(1.5, 1.5, 0.3, 0, 20, WeierstrassForm::Truncated).unwrap();
        let count = 20_000;
        let mut stream = random::stream(5, "phases", 0);
        let (mut squares, mut steps) = (Vec::new(), Vec::new());
        for _ in 0..count {
            let phases: Vec<f64> =
                random::standard_normal(&mut stream, 21).into_iter().map(|xi| TAU * standard_normal_cdf(xi)).collect();
            let (here, there) = (profile.height_m(0.4, &phases), profile.height_m(0.9, &phases));
            squares.push(here * here);
            steps.push((there - here).powi(2));
        }
        for (values, wanted) in [(squares, profile.variance_m2()), (steps, profile.structure_function_m2(0.5))] {
            let mean = values.iter().sum::<f64>() / count as f64;
            let error = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>()).sqrt() / count as f64;
            assert!((mean - wanted).abs() < 4.0 * error, "{mean} ± {error}, wanted {wanted}");
        }
    }

    #[test]
    fn the_spectrum_of_a_profile_falls_with_the_power_five_minus_two_d() {
        for dimension in [1.2, 1.5, 1.8] {
            let grid = Grid::new(8192, 2, 1.0, 1.0).unwrap();
            let surface =
                WeierstrassMandelbrot::corrugation(grid, dimension, 1.5, 1.0, WeierstrassForm::Truncated).unwrap();
            let germ = random::standard_normal(&mut random::stream(6, "slope", 0), surface.germ_len());
            let spectrum = profile_spectrum(&surface.generate(&germ), Axis::X).unwrap();
            // Power per band of one line each, from where lines are tens of bins apart, over the band's width.
            let root = 1.5_f64.sqrt();
            let points: Vec<(f64, f64)> = (9..18)
                .map(|k| {
                    let line = TAU / 8192.0 * 1.5_f64.powi(k);
                    let inside = spectrum.q_rad_per_m.iter().zip(&spectrum.psd_m3);
                    let power: f64 =
                        inside.filter(|(q, _)| **q > line / root && **q < line * root).map(|(_, p)| p).sum();
                    (line.ln(), (power / line).ln())
                })
                .collect();
            let n = points.len() as f64;
            let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
            let slope = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>()
                / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>();
            assert!((slope + 5.0 - 2.0 * dimension).abs() < 0.01, "D {dimension}: slope {slope}");
        }
    }

    #[test]
    fn a_map_is_the_sum_of_its_cosines() {
        let grid = Grid::new(9, 7, 0.5, 0.8).unwrap();
        for form in [WeierstrassForm::Truncated, WeierstrassForm::Convergent] {
            let surface = WeierstrassMandelbrot::new(grid, 2.4, 1.6, 5, 0.2, form).unwrap();
            let germ = random::standard_normal(&mut random::stream(7, "cosines", 0), surface.germ_len());
            let phases: Vec<f64> = germ.iter().map(|xi| TAU * standard_normal_cdf(*xi)).collect();
            let map = surface.generate(&germ);
            for ((row, column), z) in map.heights_m().indexed_iter() {
                let (x, y) = (0.5 * column as f64, 0.8 * row as f64);
                let mut sum = 0.0;
                let terms = surface.germ_len() / 5;
                for k in 0..terms {
                    let q = TAU / 5.6 * 1.6_f64.powi(k as i32);
                    for m in 1..=5 {
                        let angle = PI * m as f64 / 5.0;
                        let phase = phases[5 * k + m - 1];
                        let wave = (q * (x * angle.cos() + y * angle.sin()) + phase).cos();
                        let amplitude = 0.2_f64.powf(0.4) * (1.6_f64.ln() / 5.0).sqrt() * q.powf(-0.6);
                        sum += match form {
                            WeierstrassForm::Truncated => amplitude * wave,
                            WeierstrassForm::Convergent => amplitude * (phase.cos() - wave),
                        };
                    }
                }
                assert!((z - sum).abs() < 1e-13);
            }
            if form == WeierstrassForm::Convergent {
                assert!(map.heights_m()[[0, 0]].abs() < 1e-14, "zero at the origin");
            }
        }
    }

    #[test]
    fn a_corrugation_is_the_profile_of_equation_one() {
        // With a width of 2π the wavenumbers are γ^0, γ^1, …
        let grid = Grid::covering(64, 2, TAU, 1.0).unwrap();
        let surface = WeierstrassMandelbrot::corrugation(grid, 1.3, 1.5, 0.7, WeierstrassForm::Convergent).unwrap();
        let last = surface.germ_len() as i32 - 1;
        let profile = WeierstrassProfile::new(1.3, 1.5, 0.7, 0, last, WeierstrassForm::Convergent).unwrap();
        let phases: Vec<f64> = (0..=last).map(|k| 0.7 * f64::from(k)).collect();
        let map = surface.map(&phases);
        for column in [0, 5, 63] {
            let wanted = profile.height_m(grid.dx_m() * column as f64, &phases);
            assert!((map.heights_m()[[0, column]] - wanted).abs() < 1e-13);
            assert!((map.heights_m()[[1, column]] - wanted).abs() < 1e-13);
        }
        assert!((surface.variance_m2() - profile.variance_m2()).abs() < 1e-12 * profile.variance_m2());
    }

    #[test]
    fn the_rms_height_can_be_set() {
        let grid = Grid::new(64, 64, 1e-6, 1e-6).unwrap();
        let surface = WeierstrassMandelbrot::new(grid, 2.3, 1.5, 10, 1e-12, WeierstrassForm::Truncated).unwrap();
        let surface = surface.with_rms_height(1e-6).unwrap();
        assert!((surface.variance_m2().sqrt() / 1e-6 - 1.0).abs() < 1e-12);
        let powers: Vec<f64> = (0..400)
            .map(|index| {
                let germ = random::standard_normal(&mut random::stream(8, "rms", index), surface.germ_len());
                surface.generate(&germ).present_m().map(|z| z * z).sum::<f64>() / grid.points() as f64
            })
            .collect();
        let mean = powers.iter().sum::<f64>() / 400.0;
        let error = powers.iter().map(|p| (p - mean).powi(2)).sum::<f64>().sqrt() / 400.0;
        assert!((mean - 1e-12).abs() < 4.0 * error, "{mean:e} ± {error:e}");
    }

    #[test]
    fn parameters_outside_their_ranges_are_refused() {
        let grid = Grid::new(8, 8, 1.0, 1.0).unwrap();
        let form = WeierstrassForm::Truncated;
        assert!(WeierstrassProfile::new(2.0, 1.5, 1.0, 0, 5, form).is_err());
        assert!(WeierstrassProfile::new(1.5, 1.0, 1.0, 0, 5, form).is_err());
        assert!(WeierstrassProfile::new(1.5, 1.5, 1.0, 5, 0, form).is_err());
        assert!(WeierstrassMandelbrot::new(grid, 1.5, 1.5, 4, 1.0, form).is_err());
        assert!(WeierstrassMandelbrot::new(grid, 2.5, 1.5, 0, 1.0, form).is_err());
        assert!(WeierstrassMandelbrot::new(grid, 2.5, f64::NAN, 4, 1.0, form).is_err());
    }
}
