//! Harmonic force while the mass sticks.

use super::Oscillator;

/// Largest number of steps in the search for the end of a stick; convergence is quadratic except at a tangential
/// release.
const MAX_RELEASE_STEPS: usize = 400;

/// Harmonic force q cos ητ in units of V.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScaledForcing {
    /// q/V.
    pub(super) amplitude: f64,
    /// η, zero without forcing.
    pub(super) frequency: f64,
}

impl ScaledForcing {
    pub(super) fn new(oscillator: &Oscillator) -> Self {
        oscillator.forcing().map_or(Self { amplitude: 0.0, frequency: 0.0 }, |forcing| Self {
            amplitude: forcing.amplitude / oscillator.belt_velocity(),
            frequency: forcing.frequency,
        })
    }

    /// Returns (q/V) cos ητ.
    pub(super) fn force(&self, tau: f64) -> f64 {
        if self.amplitude == 0.0 { 0.0 } else { self.amplitude * (self.frequency * tau).cos() }
    }

    /// Returns the growth rate of the forward excess due to the force, (qη/V) sin ητ.
    pub(super) fn rate(&self, tau: f64) -> f64 {
        if self.amplitude == 0.0 { 0.0 } else { self.amplitude * self.frequency * (self.frequency * tau).sin() }
    }

    /// Returns the growth of the excess in the direction ± during a stick of duration t: rate·t ± (q/V)[cos ητ − cos
    /// η(τ + t)].
    pub(super) fn growth(&self, direction: f64, rate: f64, tau: f64, t: f64) -> f64 {
        if self.amplitude == 0.0 {
            return rate * t;
        }
        let half = 0.5 * self.frequency * t;
        rate * t + direction * 2.0 * self.amplitude * half.sin() * (self.frequency * tau + half).sin()
    }

    /// Returns the first time in [0, limit] at which the excess in one direction reaches zero from below.
    ///
    /// The excess at the most favourable phase of the force bounds it from above. The search starts where this bound
    /// rises to zero, less than a period before a possible release, and ends where the bound falls below zero. Each
    /// step goes to the zero of the parabola that bounds the excess from above (its second derivative is at most
    /// qη²/V), so no release is skipped. Close to a release this is Newton's method.
    pub(super) fn release(&self, direction: f64, rate: f64, excess: f64, tau: f64, limit: f64) -> Option<f64> {
        if self.amplitude == 0.0 {
            let t = (-excess / rate).max(0.0);
            return (rate > 0.0 && t <= limit).then_some(t);
        }
        let curvature = self.amplitude * self.frequency * self.frequency;
        let best = excess + self.amplitude + direction * self.force(tau);
        let mut t = if rate > 0.0 { (-best / rate).max(0.0) } else { 0.0 };
        if t > limit {
            return None;
        }
        for _ in 0..MAX_RELEASE_STEPS {
            if rate <= 0.0 && best + rate * t < 0.0 {
                return None;
            }
            let y = (excess + self.growth(direction, rate, tau, t)).min(0.0);
            let slope = rate + direction * self.rate(tau + t);
            let root = (slope * slope - 2.0 * curvature * y).sqrt();
            let advance = if slope > 0.0 { -2.0 * y / (slope + root) } else { (root - slope) / curvature };
            if t + advance > limit {
                return None;
            }
            t += advance;
            if advance <= 4.0 * f64::EPSILON * t.max(1.0) {
                return Some(t);
            }
        }
        Some(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_release_is_missed() {
        // Strong forcing: the excess oscillates and may reach the limit many periods before its mean does.
        for (amplitude, frequency, tau) in [(3.0, 2.0, 0.1), (0.3, 5.0, 2.0), (20.0, 0.7, 1.0), (0.0, 0.0, 0.0)] {
            let scaled = ScaledForcing { amplitude, frequency };
            for excess in [-0.01, -1.0, -6.5, -40.0] {
                let found = scaled.release(1.0, 1.0, excess, tau, 1e3).unwrap();
                assert!((excess + scaled.growth(1.0, 1.0, tau, found)).abs() < 1e-12);
                let fine = (0..200_000).map(|i| f64::from(i) / 200_000.0 * found * (1.0 - 1e-6));
                assert!(fine.map(|t| excess + scaled.growth(1.0, 1.0, tau, t)).all(|e| e < 0.0));
            }
        }
    }

    #[test]
    fn a_stick_of_thousands_of_forcing_periods_ends_in_time() {
        // Slow belt and fast force.
        let (scaled, excess) = (ScaledForcing { amplitude: 632.0, frequency: 5.75 }, -23_000.0);
        let found = scaled.release(1.0, 1.0, excess, 0.3, f64::INFINITY).unwrap();
        assert!((excess + scaled.growth(1.0, 1.0, 0.3, found)).abs() < 1e-9);
        // Not before the force at its most favourable phase is sufficient, and within a period from there.
        let best = -(excess + 632.0 * (1.0 + (5.75_f64 * 0.3).cos()));
        assert!(found >= best && found < best + std::f64::consts::TAU / 5.75, "{found} after {best}");
        assert_eq!(scaled.release(1.0, 1.0, excess, 0.3, found - 1e-6), None);
        // The belt carries the mass away from the other limit, which the force narrowly misses at the start and never
        // reaches later.
        let scaled = ScaledForcing { amplitude: 198.0, frequency: 8.68 };
        for missing in [1e-9, 1e-3, 0.1] {
            let excess = -2.0 * 198.0 - missing;
            assert_eq!(scaled.release(-1.0, -1.0, excess, 0.0, 1e6), None);
        }
    }

    #[test]
    fn without_forcing_a_stick_lasts_as_long_as_its_missing_force() {
        let scaled = ScaledForcing { amplitude: 0.0, frequency: 0.0 };
        assert_eq!(scaled.release(1.0, 1.0, -0.75, 3.0, 10.0), Some(0.75));
        assert_eq!(scaled.release(1.0, 1.0, -0.75, 3.0, 0.5), None);
        assert_eq!(scaled.release(-1.0, -1.0, -0.75, 3.0, 10.0), None);
    }
}
