//! Spectral representation of a standard normal process.

use std::f64::consts::TAU;

use rand_distr::{Distribution, Open01};

use asperity_base::random::Stream;

/// Sum of harmonics √(2/K) Σ cos(ω_k s + φ_k), advanced by grid points.
///
/// The spectral distribution over positive frequencies, F(ω) = (2/π) atan(ωℓ) for e^{−|s|/ℓ}, is divided into K strata
/// of equal weight; each stratum contributes one harmonic of random frequency and phase. The correlation is therefore
/// exact at every lag, without a period and without a cut-off frequency, and every realisation has unit power. The
/// distribution is normal in the limit of many harmonics (excess kurtosis −3/(2K)).
///
/// # References
/// Shinozuka & Deodatis, *Appl. Mech. Rev.* **44** (1991) 191, <https://doi.org/10.1115/1.3119501>.
#[derive(Debug, Clone)]
pub(super) struct Harmonics {
    amplitude: f64,
    /// Cosine and sine of the present angle and of the angle per grid step.
    phasors: Vec<[f64; 4]>,
}

impl Harmonics {
    /// Draws `count` harmonics for grid points `step_fraction` correlation lengths apart; `quantile` is the inverse of F,
    /// of ωℓ.
    pub(super) fn draw(count: usize, step_fraction: f64, quantile: impl Fn(f64) -> f64, rng: &mut Stream) -> Self {
        let uniform = |rng: &mut Stream| -> f64 { Open01.sample(rng) };
        let phasors = (0..count)
            .map(|k| {
                let frequency = quantile((k as f64 + uniform(rng)) / count as f64);
                let phase = TAU * uniform(rng);
                let angle = frequency * step_fraction;
                [phase.cos(), phase.sin(), angle.cos(), angle.sin()]
            })
            .collect();
        Self { amplitude: (2.0 / count as f64).sqrt(), phasors }
    }

    /// Returns the value at this grid point and moves to the next.
    pub(super) fn advance(&mut self) -> f64 {
        let mut sum = 0.0;
        for [c, s, turn_c, turn_s] in &mut self.phasors {
            sum += *c;
            (*c, *s) = (*c * *turn_c - *s * *turn_s, *c * *turn_s + *s * *turn_c);
        }
        self.amplitude * sum
    }
}
