//! Closed-form solutions.

use std::f64::consts::PI;

/// A parabola of revolution pressed into a flat (Hertz).
///
/// # References
/// K. L. Johnson, *Contact Mechanics*, Cambridge University Press (1985), §4.2, <https://doi.org/10.1017/CBO9781139171731>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hertz {
    /// Contact radius a = (3FR/4E*)^{1/3} in metre.
    pub contact_radius_m: f64,
    /// Highest pressure p₀ = 3F/2πa² in pascal.
    pub max_pressure_pa: f64,
    /// Approach δ = a²/R in metre.
    pub approach_m: f64,
}

impl Hertz {
    /// The contact of a sphere of `radius_m` under `load_n` with contact modulus E* = `modulus_pa`.
    pub fn new(modulus_pa: f64, radius_m: f64, load_n: f64) -> Self {
        let contact_radius_m = (0.75 * load_n * radius_m / modulus_pa).cbrt();
        let max_pressure_pa = 1.5 * load_n / (PI * contact_radius_m.powi(2));
        Self { contact_radius_m, max_pressure_pa, approach_m: contact_radius_m.powi(2) / radius_m }
    }

    /// The load in newton that makes the approach `approach_m`.
    pub fn load_n(modulus_pa: f64, radius_m: f64, approach_m: f64) -> f64 {
        4.0 / 3.0 * modulus_pa * radius_m.sqrt() * approach_m.powf(1.5)
    }
}

/// A one-dimensional sinusoid h·cos(2πx/λ) pressed flat (Westergaard).
///
/// # References
/// H. M. Westergaard, *J. Appl. Mech.* **6** (1939) A49. K. L. Johnson, *Contact Mechanics* (1985), §13.2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Westergaard {
    /// Mean pressure p* = πE*h/λ at which contact is complete, in pascal.
    pub full_contact_pressure_pa: f64,
    /// Contact width over wavelength, 2a/λ, from p̄/p* = sin²(πa/λ).
    pub contact_fraction: f64,
    /// Highest pressure 2√(p̄p*) in pascal.
    pub max_pressure_pa: f64,
}

impl Westergaard {
    /// The contact of amplitude h and wavelength λ under the mean pressure p̄ ≤ p*.
    ///
    /// # Panics
    /// If the mean pressure is negative or exceeds p*.
    pub fn new(modulus_pa: f64, amplitude_m: f64, wavelength_m: f64, mean_pressure_pa: f64) -> Self {
        let full_contact_pressure_pa = PI * modulus_pa * amplitude_m / wavelength_m;
        let ratio = mean_pressure_pa / full_contact_pressure_pa;
        assert!((0.0..=1.0).contains(&ratio), "the mean pressure lies between 0 and p*");
        let contact_fraction = 2.0 / PI * ratio.sqrt().asin();
        let max_pressure_pa = 2.0 * (mean_pressure_pa * full_contact_pressure_pa).sqrt();
        Self { full_contact_pressure_pa, contact_fraction, max_pressure_pa }
    }
}

/// Persson's contact fraction A/A₀ = erf(√2 p̄/(E* h'_rms)) of a self-affine surface of rms gradient h'_rms.
///
/// # References
/// B. N. J. Persson, *J. Chem. Phys.* **115** (2001) 3840, <https://doi.org/10.1063/1.1388626>.
pub fn persson_contact_fraction(mean_pressure_pa: f64, modulus_pa: f64, rms_gradient: f64) -> f64 {
    statrs::function::erf::erf(std::f64::consts::SQRT_2 * mean_pressure_pa / (modulus_pa * rms_gradient))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hertz_gives_the_textbook_figures() {
        let unit = Hertz::new(5.0, 4.0, 7.0);
        assert!((unit.approach_m - 0.6507879989531481).abs() < 1e-14);
        assert!((unit.contact_radius_m - 1.6134286460245437).abs() < 1e-14);
        assert!((unit.max_pressure_pa - 1.2839257217043503).abs() < 1e-14);
        assert!((Hertz::load_n(5.0, 4.0, unit.approach_m) - 7.0).abs() < 1e-13);
        let steel = Hertz::new(210e9 / (1.0 - 0.09), 10e-3, 10.0);
        assert!((steel.contact_radius_m * 1e6 - 68.75344).abs() < 5e-6);
        assert!((steel.max_pressure_pa * 1e-9 - 1.0100723).abs() < 5e-8);
        assert!((steel.approach_m * 1e6 - 0.47270360).abs() < 5e-9);
    }

    #[test]
    fn westergaard_gives_the_published_widths() {
        for (ratio, width) in [(0.1, 0.2048327647), (0.25, 1.0 / 3.0), (0.5, 0.5), (0.75, 2.0 / 3.0)] {
            let full = Westergaard::new(1.0, 0.01, 1.0, 0.0).full_contact_pressure_pa;
            let wave = Westergaard::new(1.0, 0.01, 1.0, ratio * full);
            assert!((wave.contact_fraction - width).abs() < 5e-11);
        }
    }

    #[test]
    fn persson_gives_the_published_fractions() {
        for (load, wanted) in [(0.01, 0.0159566), (0.05, 0.0796557), (0.1, 0.1585194)] {
            assert!((persson_contact_fraction(load, 1.0, 1.0) - wanted).abs() < 5e-8);
        }
    }
}
