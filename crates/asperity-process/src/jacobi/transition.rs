//! Transition distribution of the Jacobi diffusion as a spectral sum.

use asperity_base::distribution::{Marginal, standard_normal_cdf, standard_normal_pdf, standard_normal_quantile};
use asperity_base::numeric::cubic;

/// Negative logarithm of the size below which terms are dropped.
const NEGLIGIBLE: f64 = 39.0;
/// Number of end points per start point of a table.
const ENDS_PER_START: usize = 4;
/// Tail probability at which the search for quantiles ends: the rounding error of the sum.
const LEAST_TAIL: f64 = 2e-12;

/// P(X_{s+h} ≤ y | X_s = x) = I_y(a, b) + Σ e^{−λ_n h} p_n(x) ∫₀^y p_n dI, for scores of x and y on a grid.
///
/// p_n are the Jacobi polynomials orthonormal under Beta(a, b), λ_n = θn(n − 1 + a + b)/(a + b), and by the equation they
/// solve ∫₀^y p_n dI = −y(1 − y)w(y)p_n′(y)/(n(n − 1 + a + b)), with w the density and p_n′ a multiple of the polynomial
/// under Beta(a + 1, b + 1).
pub(super) struct Transition {
    marginal: Marginal,
    mirrored: Marginal,
    /// Logarithms of 1/B(a, b), a and b.
    normaliser: [f64; 3],
    polynomials: Polynomials,
    derivatives: Polynomials,
    /// e^{−λ_n h}, n ≥ 1.
    decay: Vec<f64>,
    /// −1/√(n(n − 1 + a + b)) times the constant of p_n′.
    to_integral: Vec<f64>,
    /// Scores of the end points.
    scores: Vec<f64>,
    ends: Vec<End>,
}

/// Values p_n and ∫p_n dI at one point, n ≥ 1.
struct End {
    values: Vec<f64>,
    integrals: Vec<f64>,
}

impl Transition {
    /// Creates the distribution for a step in correlation lengths; start points |g| ≤ `reach`, `density` per unit.
    pub(super) fn new(a: f64, b: f64, step: f64, reach: f64, density: f64) -> Self {
        let total = a + b;
        let rate = |n: usize| n as f64 * ((n - 1) as f64 + total);
        let mut decay = vec![];
        while decay.len() < 2 || rate(decay.len()) / total * step < NEGLIGIBLE {
            decay.push((-rate(decay.len() + 1) / total * step).exp());
        }
        // Integral ∫ y(1 − y) dI.
        let spread = a * b / (total * (total + 1.0));
        let to_integral = (1..=decay.len()).map(|n| -1.0 / (spread * rate(n)).sqrt()).collect();
        let marginal = Marginal::Beta { a, b, low: 0.0, high: 1.0 };
        let log_constant = marginal.ln_pdf(0.5) + (total - 2.0) * std::f64::consts::LN_2;
        let density = density * ENDS_PER_START as f64;
        let half = (reach * density) as i32;
        let scores: Vec<f64> = (-half..=half).map(|j| f64::from(j) / density).collect();
        let terms = decay.len();
        let mut transition = Self {
            marginal,
            mirrored: Marginal::Beta { a: b, b: a, low: 0.0, high: 1.0 },
            normaliser: [log_constant, a, b],
            polynomials: Polynomials::new(a, b, terms),
            derivatives: Polynomials::new(a + 1.0, b + 1.0, terms),
            decay,
            to_integral,
            scores: vec![],
            ends: vec![],
        };
        transition.ends = scores.iter().map(|&g| transition.end(g)).collect();
        transition.scores = scores;
        transition
    }

    /// Returns the number of start points.
    pub(super) fn starts(&self) -> usize {
        self.scores.len() / ENDS_PER_START + 1
    }

    fn end(&self, g: f64) -> End {
        let (x, rest) = (self.marginal.translate(g), self.mirrored.translate(-g));
        let terms = self.decay.len();
        let (mut values, mut slopes) = (vec![0.0; terms + 1], vec![0.0; terms + 1]);
        self.polynomials.fill(x - rest, &mut values);
        self.derivatives.fill(x - rest, &mut slopes);
        values.remove(0);
        let [log_constant, a, b] = self.normaliser;
        let flux = (log_constant + a * x.ln() + b * rest.ln()).exp();
        // At an end of the support the flux is zero.
        let integrals = slopes.iter().zip(&self.to_integral).map(|(slope, c)| flux * c * slope).collect();
        End { values, integrals }
    }

    /// Returns the normal score of the conditional probability of ending below `end`, of score g, and its slope in g,
    /// from the decayed polynomials of the start. Returns the tail if the sum resolves only that.
    fn score(&self, weights: &[f64], g: f64, end: &End) -> Result<(f64, f64), Tail> {
        let (mut change, mut density) = (0.0, 1.0);
        for ((weight, value), integral) in weights.iter().zip(&end.values).zip(&end.integrals) {
            density += weight * value;
            change += weight * integral;
        }
        let lower = standard_normal_cdf(g) + change;
        let upper = standard_normal_cdf(-g) - change;
        if lower.is_nan() || lower < LEAST_TAIL {
            return Err(Tail::Lower);
        }
        if upper < LEAST_TAIL {
            return Err(Tail::Upper);
        }
        let z = if lower < 0.5 { standard_normal_quantile(lower) } else { -standard_normal_quantile(upper) };
        Ok((z, standard_normal_pdf(g) * density / standard_normal_pdf(z)))
    }

    fn weights(&self, start: &End) -> Vec<f64> {
        self.decay.iter().zip(&start.values).map(|(decay, value)| decay * value).collect()
    }

    /// Computes the scores g′ after a step from start point i at rising innovations ξ: the conditional quantiles at
    /// Φ(ξ).
    pub(super) fn quantiles(&self, i: usize, innovations: &[f64], quantiles: &mut [f64]) {
        let centre = i * ENDS_PER_START;
        let weights = self.weights(&self.ends[centre]);
        let of = |j: usize| self.score(&weights, self.scores[j], &self.ends[j]);
        let (least, most) = (innovations[0], innovations[innovations.len() - 1]);
        // From a point of the bulk, extends down and up until the innovations are covered.
        let middle = self.bulk(&of, centre);
        let mut points = vec![];
        let mut above = f64::INFINITY;
        for j in (0..=middle).rev() {
            let Ok((z, slope)) = of(j) else { break };
            if z >= above {
                break;
            }
            points.push((z, self.scores[j], slope));
            above = z;
            if z < least {
                break;
            }
        }
        points.reverse();
        let mut below = points.last().map_or(f64::NEG_INFINITY, |point| point.0);
        for j in middle + 1..self.scores.len() {
            let Ok((z, slope)) = of(j) else { break };
            if z <= below {
                break;
            }
            points.push((z, self.scores[j], slope));
            below = z;
            if z > most {
                break;
            }
        }
        let mut k = 0;
        for (xi, quantile) in innovations.iter().zip(quantiles) {
            while k + 2 < points.len() && points[k + 1].0 < *xi {
                k += 1;
            }
            *quantile = match points.get(k..k + 2) {
                Some([left, right]) => inverse(*left, *right, *xi),
                _ => self.scores[middle],
            };
        }
    }

    /// Returns an end point whose conditional probability is neither small nor large.
    fn bulk(&self, of: &impl Fn(usize) -> Result<(f64, f64), Tail>, guess: usize) -> usize {
        let (mut low, mut high) = (0, self.scores.len() - 1);
        let mut j = guess;
        while low < high {
            match of(j) {
                Ok((z, _)) if z.abs() < 1.0 => break,
                Ok((z, _)) if z < 0.0 => low = j + 1,
                Err(Tail::Lower) => low = j + 1,
                Ok(_) | Err(Tail::Upper) => high = j,
            }
            j = usize::midpoint(low, high);
        }
        j
    }

    /// Returns the decayed polynomials of a start.
    pub(super) fn from(&self, start: f64) -> Vec<f64> {
        self.weights(&self.end(start))
    }

    /// Returns the same quantile at any innovation, by Newton's method on the sum itself.
    pub(super) fn quantile(&self, weights: &[f64], innovation: f64, guess: f64) -> f64 {
        let mut g = guess;
        for _ in 0..4 {
            let Ok((z, slope)) = self.score(weights, g, &self.end(g)) else { break };
            let change = (innovation - z) / slope;
            g += change;
            if change.abs() < 1e-9 {
                break;
            }
        }
        g
    }
}

/// Tail of the conditional distribution that contains an end point.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Tail {
    Lower,
    Upper,
}

/// Returns g at ξ between two points (z, g, dz/dg), by the cubic through g and dg/dz; constant beyond them.
fn inverse((z0, g0, s0): (f64, f64, f64), (z1, g1, s1): (f64, f64, f64), xi: f64) -> f64 {
    let width = z1 - z0;
    let t = ((xi - z0) / width).clamp(0.0, 1.0);
    let rise = g1 - g0;
    let slope = |s: f64| if s > 0.0 && width / s < 3.0 * rise { width / s } else { rise };
    cubic([g0, slope(s0)], [g1, slope(s1)], t)
}

/// Recursion of the polynomials orthonormal under Beta(a, b), in t = 2x − 1.
struct Polynomials {
    /// (centre, √ratio, 1/√next ratio) of √r_{n+1} p_{n+1} = (t − c_n) p_n − √r_n p_{n−1}.
    steps: Vec<[f64; 3]>,
}

impl Polynomials {
    fn new(a: f64, b: f64, terms: usize) -> Self {
        let (total, difference) = (a + b, a - b);
        let centre = |n: usize| {
            let n = 2.0 * n as f64;
            // At n = 0 a factor a + b − 2 cancels.
            if n == 0.0 { difference / total } else { difference * (total - 2.0) / ((n + total - 2.0) * (n + total)) }
        };
        let ratio = |n: usize| {
            if n == 0 {
                return 0.0;
            }
            let n = n as f64;
            let twice = 2.0 * n + total - 2.0;
            // At n = 1 a factor a + b − 1 cancels.
            let quotient = if n == 1.0 { 1.0 } else { (n + total - 2.0) / (twice - 1.0) };
            4.0 * n * (n + a - 1.0) * (n + b - 1.0) * quotient / (twice * twice * (twice + 1.0))
        };
        let steps = (0..terms).map(|n| [centre(n), ratio(n).sqrt(), 1.0 / ratio(n + 1).sqrt()]).collect();
        Self { steps }
    }

    /// Computes p_0 … p_terms at t.
    fn fill(&self, t: f64, values: &mut [f64]) {
        let (mut before, mut here) = (0.0, 1.0);
        values[0] = 1.0;
        for ([centre, root, next], value) in self.steps.iter().zip(&mut values[1..]) {
            (before, here) = (here, ((t - centre) * here - root * before) * next);
            *value = here;
        }
    }
}
