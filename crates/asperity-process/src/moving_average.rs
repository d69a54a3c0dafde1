//! Exact recursion of a normal process with windowed exponential correlation.

use rand_distr::{Distribution, StandardNormal};

use asperity_base::random::Stream;

/// Moving average over a window W of an Ornstein–Uhlenbeck process of length ℓ, at grid points h = W/k apart.
///
/// The process g and its integral J over one step are jointly normal given g at the start, with φ = e^{−h/ℓ}: mean (φg,
/// ℓ(1 − φ)g), variances 1 − φ² and ℓ²[2(h/ℓ − 1 + φ) − (1 − φ)²], covariance ℓ(1 − φ)². The sum of the last k
/// integrals is the integral over the window. The correlation at the grid points is therefore exact, the distribution
/// normal and the process without end. For ℓ = 0 independent values are summed.
#[derive(Debug, Clone)]
pub(super) struct MovingAverage {
    step: Step,
    g: f64,
    /// Integrals over the steps of the window, in a ring buffer.
    integrals: Vec<f64>,
    next: usize,
    sum: f64,
    /// Reciprocal of the standard deviation of the sum.
    scale: f64,
}

/// Coefficients that advance g and its integral by one step, lengths in units of ℓ.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// Values φ and 1 − φ.
    keep: f64,
    lose: f64,
    /// Factors of two independent normal values in g and in J.
    to_g: f64,
    to_integral: [f64; 2],
}

impl MovingAverage {
    /// Draws a stationary state; `steps` = k grid points per window and `step` = h/ℓ, infinite for ℓ = 0.
    pub(super) fn draw(steps: usize, step: f64, rng: &mut Stream) -> Self {
        let independent = Step { keep: 0.0, lose: 0.0, to_g: 0.0, to_integral: [0.0, 1.0] };
        let (step, variance) = if step.is_finite() {
            (Step::new(step), 2.0 * bend(step * steps as f64))
        } else {
            (independent, steps as f64)
        };
        let g = StandardNormal.sample(rng);
        let mut average =
            Self { step, g, integrals: vec![0.0; steps], next: 0, sum: 0.0, scale: variance.sqrt().recip() };
        for _ in 0..steps {
            average.turn(rng);
        }
        average
    }

    /// Returns the value at this grid point and moves to the next.
    pub(super) fn advance(&mut self, rng: &mut Stream) -> f64 {
        let value = self.scale * self.sum;
        self.turn(rng);
        value
    }

    fn turn(&mut self, rng: &mut Stream) {
        let (one, two): (f64, f64) = (StandardNormal.sample(rng), StandardNormal.sample(rng));
        let Step { keep, lose, to_g, to_integral } = self.step;
        let integral = lose * self.g + to_integral[0] * one + to_integral[1] * two;
        self.g = keep * self.g + to_g * one;
        self.sum += integral - std::mem::replace(&mut self.integrals[self.next], integral);
        self.next += 1;
        if self.next == self.integrals.len() {
            // Recomputed once per window, so that rounding does not accumulate.
            self.next = 0;
            self.sum = self.integrals.iter().sum();
        }
    }
}

impl Step {
    fn new(step: f64) -> Self {
        let lose = -(-step).exp_m1();
        let to_g = (-(-2.0 * step).exp_m1()).sqrt();
        let shared = lose * lose / to_g;
        let variance = 2.0 * bend(step) - lose * lose;
        let own = (variance - shared * shared).max(0.0).sqrt();
        Self { keep: (-step).exp(), lose, to_g, to_integral: [shared, own] }
    }
}

/// Returns e^{−x} − 1 + x.
fn bend(x: f64) -> f64 {
    if x > 0.05 {
        return (-x).exp_m1() + x;
    }
    let mut term = 0.5 * x * x;
    let mut sum = term;
    for n in 3..12 {
        term *= -x / f64::from(n);
        sum += term;
    }
    sum
}
