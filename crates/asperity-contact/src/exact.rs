//! Closed-form solutions of contact problems.

use std::f64::consts::PI;

/// A parabola of revolution pressed into a flat (Hertz).
///
/// # References
/// K. L. Johnson, *Contact Mechanics*, Cambridge University Press (1985), §4.2,
/// <https://doi.org/10.1017/CBO9781139171731>.
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
    /// Computes the contact of a sphere of `radius_m` under `load_n` with contact modulus E* = `modulus_pa`.
    pub fn new(modulus_pa: f64, radius_m: f64, load_n: f64) -> Self {
        let contact_radius_m = (0.75 * load_n * radius_m / modulus_pa).cbrt();
        let max_pressure_pa = 1.5 * load_n / (PI * contact_radius_m.powi(2));
        Self { contact_radius_m, max_pressure_pa, approach_m: contact_radius_m.powi(2) / radius_m }
    }

    /// Returns the load in newton at the approach `approach_m`.
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
    /// Computes the contact of amplitude h and wavelength λ under the mean pressure p̄ ≤ p*.
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

/// Returns Persson's contact fraction A/A₀ = erf(√2 p̄/(E* h'_rms)) of a self-affine surface of rms gradient h'_rms.
///
/// # References
/// B. N. J. Persson, *J. Chem. Phys.* **115** (2001) 3840, <https://doi.org/10.1063/1.1388626>.
pub fn persson_contact_fraction(mean_pressure_pa: f64, modulus_pa: f64, rms_gradient: f64) -> f64 {
    statrs::function::erf::erf(std::f64::consts::SQRT_2 * mean_pressure_pa / (modulus_pa * rms_gradient))
}

/// Returns the contact fraction A/A₀ = √(2π) p̄/(E* h'_rms) of Bush, Gibson and Thomas at light loads, in the limit of
/// many scales.
///
/// It bounds numerical results from above. [`persson_contact_fraction`] bounds them from below; its slope √(8/π) is 1.57
/// times smaller. The fraction is linear in the pressure and invalid close to one.
///
/// # References
/// A. W. Bush, R. D. Gibson and T. R. Thomas, *Wear* **35** (1975) 87, <https://doi.org/10.1016/0043-1648(75)90145-3>.
pub fn bush_gibson_thomas_contact_fraction(mean_pressure_pa: f64, modulus_pa: f64, rms_gradient: f64) -> f64 {
    (2.0 * PI).sqrt() * mean_pressure_pa / (modulus_pa * rms_gradient)
}

/// Persson's distribution of the pressure of a rough contact, elastic or with a hardness.
///
/// In complete contact the pressure has the mean p̄ and the variance V = (E* h'_rms/2)², the sum of (E*|q|/2)²|ẑ|² over
/// all waves. Adding wave by wave and absorbing pressures that reach zero gives the diffusion result P(p) =
/// [exp(−(p−p̄)²/2V) − exp(−(p+p̄)²/2V)]/√(2πV) for p > 0, per area of the whole surface. Its integral is
/// [`persson_contact_fraction`]. The rest of the surface is a point mass at zero. With a hardness H, pressures that
/// reach H are absorbed as well: P is the sum over the images of p̄ in both walls, and a point mass at H carries the
/// remaining load. Without roughness (V = 0) there is no density.
///
/// # References
/// B. N. J. Persson, *J. Chem. Phys.* **115** (2001) 3840, <https://doi.org/10.1063/1.1388626>. W. Manners and
/// J. A. Greenwood, *Wear* **261** (2006) 600, <https://doi.org/10.1016/j.wear.2006.01.007>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PerssonPressure {
    /// Mean pressure p̄ over the whole surface in pascal, below the hardness.
    pub mean_pressure_pa: f64,
    /// Standard deviation √V of the pressure in complete elastic contact in pascal.
    pub full_contact_std_pa: f64,
    /// Hardness in pascal, the upper bound of the pressure, if any.
    pub hardness_pa: Option<f64>,
}

impl PerssonPressure {
    /// Value of √V/H above which less than 10⁻³⁰ of the surface is in elastic contact.
    const ALL_PLASTIC: f64 = 4.0;

    /// Creates the distribution for the mean pressure p̄, contact modulus E* and rms gradient h'_rms; elastic without a
    /// hardness.
    pub fn new(mean_pressure_pa: f64, modulus_pa: f64, rms_gradient: f64, hardness_pa: Option<f64>) -> Self {
        Self { mean_pressure_pa, full_contact_std_pa: 0.5 * modulus_pa * rms_gradient, hardness_pa }
    }

    /// Returns the fraction of the surface in contact, elastic or plastic.
    pub fn contact_fraction(&self) -> f64 {
        self.elastic_fraction() + self.plastic_fraction()
    }

    /// Returns the fraction of the surface with 0 < p < H.
    pub fn elastic_fraction(&self) -> f64 {
        self.elastic_below(self.hardness_pa.unwrap_or(f64::INFINITY))
    }

    /// Returns the fraction of the surface with p = H.
    pub fn plastic_fraction(&self) -> f64 {
        let Some(hardness_pa) = self.hardness_pa else { return 0.0 };
        // ∫ p G(p − m) dp over (0, H).
        let std = self.full_contact_std_pa;
        let carried = |m: f64| {
            let bell = |p: f64| (-0.5 * (p / std).powi(2)).exp() / (2.0 * PI).sqrt();
            0.5 * m * (self.erf(hardness_pa - m) + self.erf(m)) + std * (bell(m) - bell(hardness_pa - m))
        };
        let mean = self.mean_pressure_pa;
        let elastic_pa: f64 = self.images().map(|shift| carried(shift + mean) - carried(shift - mean)).sum();
        ((mean - elastic_pa) / hardness_pa).max(0.0)
    }

    /// Returns the fraction of the surface, in or out of contact, whose pressure is at most `pressure_pa`.
    pub fn cumulative(&self, pressure_pa: f64) -> f64 {
        if pressure_pa < 0.0 {
            0.0
        } else if self.hardness_pa.is_some_and(|hardness_pa| pressure_pa >= hardness_pa) {
            1.0
        } else {
            1.0 - self.contact_fraction() + self.elastic_below(pressure_pa)
        }
    }

    /// Returns the fraction of the surface with a pressure above zero and at most `pressure_pa`, all of it elastic.
    fn elastic_below(&self, pressure_pa: f64) -> f64 {
        let mean = self.mean_pressure_pa;
        let within = |m: f64| 0.5 * (self.erf(pressure_pa - m) + self.erf(m));
        self.images().map(|shift| within(shift + mean) - within(shift - mean)).sum()
    }

    /// Returns erf(p/√(2V)).
    fn erf(&self, pressure_pa: f64) -> f64 {
        statrs::function::erf::erf(pressure_pa / (std::f64::consts::SQRT_2 * self.full_contact_std_pa))
    }

    /// Returns the multiples of 2H that shift the images of ±p̄ and contribute; only zero in the elastic case.
    fn images(&self) -> impl Iterator<Item = f64> {
        let hardness_pa = self.hardness_pa.unwrap_or(f64::INFINITY);
        let reach = self.full_contact_std_pa / hardness_pa;
        // Pairs about ±1, ±2, … are at least 2H|k| − 2H away.
        let pairs = if reach > Self::ALL_PLASTIC { None } else { Some((1.0 + 5.0 * reach).ceil() as i32) };
        let range = match (pairs, self.hardness_pa) {
            (_, None) => 0..1,
            (None, _) => 0..0,
            (Some(pairs), _) => -pairs..pairs + 1,
        };
        range.map(move |k| if k == 0 { 0.0 } else { 2.0 * f64::from(k) * hardness_pa })
    }
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

    #[test]
    fn asperity_models_touch_half_pi_times_as_much_as_persson_at_light_loads() {
        assert!((bush_gibson_thomas_contact_fraction(0.01, 2.0, 0.5) - 0.025066282746310002).abs() < 1e-16);
        let slope = persson_contact_fraction(1e-6, 1.0, 1.0) / 1e-6;
        assert!((slope / (8.0 / PI).sqrt() - 1.0).abs() < 1e-11, "{slope}");
        let ratio = bush_gibson_thomas_contact_fraction(1e-6, 1.0, 1.0) / persson_contact_fraction(1e-6, 1.0, 1.0);
        assert!((ratio / (0.5 * PI) - 1.0).abs() < 1e-11);
    }

    /// Returns ∫ f over (0, top) by Simpson's rule.
    fn integral(top: f64, f: impl Fn(f64) -> f64) -> f64 {
        let steps = 4000;
        let weight = |i: usize| if i == 0 || i == steps { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
        (0..=steps).map(|i| weight(i) * f(top * i as f64 / steps as f64)).sum::<f64>() * top / (3.0 * steps as f64)
    }

    #[test]
    fn the_pressures_in_contact_carry_the_load_on_the_contact_area() {
        let (modulus, gradient) = (2.0, 0.3);
        for mean in [1e-4, 0.05, 0.3, 2.0] {
            let dist = PerssonPressure::new(mean, modulus, gradient, None);
            let top = mean + 12.0 * dist.full_contact_std_pa;
            let area = dist.contact_fraction();
            assert!((area / persson_contact_fraction(mean, modulus, gradient) - 1.0).abs() < 1e-9, "{mean}: {area}");
            let load = integral(top, |p| 1.0 - dist.cumulative(p));
            assert!((load / mean - 1.0).abs() < 1e-9, "{mean}: {load}");
            assert_eq!((dist.cumulative(-1.0), dist.cumulative(0.0)), (0.0, 1.0 - area));
        }
        // Deep in complete contact the distribution is normal with mean p̄ and standard deviation E* h'rms/2.
        let dist = PerssonPressure::new(30.0, 2.0, 3.0, None);
        assert!((dist.cumulative(33.0) - 0.841_344_746_068_542_9).abs() < 1e-10);
    }

    #[test]
    fn with_a_hardness_the_images_sum_to_perssons_series() {
        // P = (2/H) Σ sin(nπp̄/H) sin(nπp/H) exp(−(nπ/H)²V/2), which solves the diffusion between absorbing walls,
        // integrated over p.
        for (mean, std, hardness) in
            [(0.1, 0.3, 1.0), (0.1, 1.0, 1.0), (0.9, 0.3, 1.0), (0.5, 0.02, 2.0), (0.3, 2.0, 1.0)]
        {
            let dist = PerssonPressure::new(mean, 2.0, std, Some(hardness));
            let angle = |n: f64, p: f64| n * PI * p / hardness;
            let decay = |n: f64| (-0.5 * (n * PI * std / hardness).powi(2)).exp();
            for p in [0.01, 0.2, 0.5, 0.95].map(|fraction| fraction * hardness) {
                let terms =
                    (1..2000).map(f64::from).map(|n| angle(n, mean).sin() * (1.0 - angle(n, p).cos()) * decay(n) / n);
                let wanted = 2.0 / PI * terms.sum::<f64>();
                let found = dist.cumulative(p) - dist.cumulative(0.0);
                // The accuracy of the error function.
                assert!((found - wanted).abs() < 1e-10, "{dist:?} {p}: {found} {wanted}");
            }
            // The value at H, a jump, does not count.
            let below = |p: f64| if p < hardness { dist.cumulative(p) } else { 1.0 - dist.plastic_fraction() };
            let carried = integral(hardness, |p| 1.0 - below(p));
            assert!((carried / mean - 1.0).abs() < 1e-9, "{dist:?}: {carried}");
            assert_eq!(dist.cumulative(hardness), 1.0);
        }
        // A hardness far above the pressure changes nothing. Very large roughness leaves only plastic contact, of the
        // area p̄/H.
        let (hard, elastic) =
            (PerssonPressure::new(0.3, 2.0, 1.0, Some(40.0)), PerssonPressure::new(0.3, 2.0, 1.0, None));
        assert!((hard.contact_fraction() / elastic.contact_fraction() - 1.0).abs() < 1e-14);
        assert!(hard.plastic_fraction() < 1e-16 && hard.cumulative(0.7) == elastic.cumulative(0.7));
        // The images cancel here, to the accuracy of the error function.
        for std in [2.5, 3.9, 4.1, 1e6] {
            let plastic = PerssonPressure::new(0.3, 2.0, std, Some(1.0));
            assert!((plastic.contact_fraction() - 0.3).abs() < 1e-9, "{}", plastic.contact_fraction());
            assert!(plastic.elastic_fraction().abs() < 1e-9);
        }
    }
}
