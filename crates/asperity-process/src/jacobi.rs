//! Jacobi diffusion, advanced by its transition distribution.

mod transition;

use super::ProcessError;
use transition::Transition;

/// Largest score |g| of the table; the fraction 1.2e-15 of the values lies beyond and is set to the last.
const REACH: f64 = 8.0;
/// Largest innovations |ξ| up to which the table is read and tabulated; the fraction 2e-9 lies beyond and is set to the
/// last.
const INNOVATION_REACH: f64 = 6.0;
const INNOVATION_TABLE_REACH: f64 = 6.5;
/// Initial numbers of table cells per unit of ξ, and per standard deviation of a step in g; and the largest number of
/// doublings.
const INNOVATION_DENSITY: usize = 8;
const STEP_DENSITY: f64 = 4.0;
const DOUBLINGS: usize = 2;
/// Required largest error of a score.
const WANTED_ERROR: f64 = 2e-6;
/// Shortest step in correlation lengths; the spectral sum needs about 17/√step terms.
const SHORTEST_STEP: f64 = 1e-3;

/// Step of the diffusion dX = −θ(X − a/(a+b))ds + √(2θX(1 − X)/(a+b)) dB with distribution Beta(a, b) and correlation
/// e^{−θs}.
///
/// The state is the score g = Φ⁻¹(I_X(a, b)), which is standard normal in the stationary state. The next score is the
/// quantile of its conditional distribution at Φ(ξ) for a standard normal ξ: T(g, ξ), a smooth function close to φg +
/// √(1 − φ²)ξ. T is tabulated from the spectral sum of the transition distribution and interpolated by cubic splines in
/// both arguments. Values at the grid points therefore follow the exact transition distribution up to the measured
/// error of the table ([`JacobiStep::error`]), without Euler steps.
///
/// # References
/// Forman & Sørensen, *Scand. J. Statist.* **35** (2008) 438, <https://doi.org/10.1111/j.1467-9469.2007.00592.x>, case 6.
#[derive(Debug, Clone)]
pub(super) struct JacobiStep {
    density: f64,
    innovation_density: f64,
    /// Spline coefficients. Rows are the nodes of g and one beyond each end; columns are the nodes of ξ in the same
    /// way.
    coefficients: Vec<f64>,
    rows: usize,
    columns: usize,
    /// Largest error of the next score at cell centres, for |g| ≤ 4 and |ξ| ≤ 4; the fraction 1e-4 of the steps lies outside.
    error: f64,
}

impl JacobiStep {
    /// Tabulates a step of `step` correlation lengths between values with distribution Beta(a, b).
    pub(super) fn new(a: f64, b: f64, step: f64) -> Result<Self, ProcessError> {
        if step.is_nan() || step < SHORTEST_STEP {
            let parameter = "step of a Jacobi diffusion in correlation lengths";
            return Err(ProcessError::Parameter { parameter, value: step, wanted: "at least 0.001" });
        }
        let deviation = (-(-2.0 * step).exp_m1()).sqrt();
        let mut density = (STEP_DENSITY / deviation).ceil();
        let mut innovation_density = INNOVATION_DENSITY;
        let mut table = Self::tabulated(a, b, step, density, innovation_density);
        for _ in 0..DOUBLINGS {
            if table.error <= WANTED_ERROR {
                break;
            }
            (density, innovation_density) = (2.0 * density, 2 * innovation_density);
            table = Self::tabulated(a, b, step, density, innovation_density);
        }
        Ok(table)
    }

    fn tabulated(a: f64, b: f64, step: f64, density: f64, innovation_density: usize) -> Self {
        let innovations: Vec<f64> = {
            let half = (INNOVATION_TABLE_REACH * innovation_density as f64) as i32;
            (-half..=half).map(|k| f64::from(k) / innovation_density as f64).collect()
        };
        let transition = Transition::new(a, b, step, REACH, density);
        let nodes = transition.starts();
        let (rows, columns) = (nodes + 2, innovations.len() + 2);
        let mut coefficients = vec![0.0; rows * columns];
        for i in 0..nodes {
            let row = &mut coefficients[(i + 1) * columns..(i + 2) * columns];
            transition.quantiles(i, &innovations, &mut row[1..=innovations.len()]);
            to_spline(row, 0, 1, innovations.len());
        }
        for column in 0..columns {
            to_spline(&mut coefficients, column, columns, nodes);
        }
        let mut table =
            Self { density, innovation_density: innovation_density as f64, coefficients, rows, columns, error: 0.0 };
        table.error = table.measured_error(&transition);
        table
    }

    /// Returns the score one step after g, for the standard normal innovation ξ.
    #[inline]
    pub(super) fn next(&self, g: f64, xi: f64) -> f64 {
        let (row, down) = place((g + REACH) * self.density, self.rows);
        let xi = xi.clamp(-INNOVATION_REACH, INNOVATION_REACH);
        let (column, across) = place((xi + INNOVATION_TABLE_REACH) * self.innovation_density, self.columns);
        let mut sum = 0.0;
        for (k, weight) in down.iter().enumerate() {
            let first = (row + k) * self.columns + column;
            let c = &self.coefficients[first..first + 4];
            sum += weight * ((across[0] * c[0] + across[1] * c[1]) + (across[2] * c[2] + across[3] * c[3]));
        }
        sum
    }

    fn measured_error(&self, transition: &Transition) -> f64 {
        const POINTS: i32 = 6;
        // Cell centres near a regular grid.
        let near = |value: i32, density: f64| ((f64::from(value) / 1.5 * density).floor() + 0.5) / density;
        let mut worst = 0.0_f64;
        for g in (-POINTS..=POINTS).map(|i| near(i, self.density)) {
            let from = transition.from(g);
            for xi in (-POINTS..=POINTS).map(|k| near(k, self.innovation_density)) {
                let found = self.next(g, xi);
                worst = worst.max((found - transition.quantile(&from, xi, found)).abs());
            }
        }
        worst
    }
}

/// Returns the index of the first of the four coefficients at a position, in cells, and their weights; there are
/// `count` coefficients.
#[inline]
fn place(position: f64, count: usize) -> (usize, [f64; 4]) {
    let position = position.max(0.0);
    let first = (position as usize).min(count - 4);
    let t = (position - first as f64).min(1.0);
    let s = 1.0 - t;
    let (low, high) = (s * s * s / 6.0, t * t * t / 6.0);
    let inner = (4.0 - 6.0 * t * t) / 6.0 + 3.0 * high;
    (first, [low, inner, 1.0 - low - inner - high, high])
}

/// Converts `nodes` values, `stride` apart and after one free element, into the coefficients of the natural cubic
/// spline through them, including the free elements at both ends.
fn to_spline(values: &mut [f64], offset: usize, stride: usize, nodes: usize) {
    let at = |i: usize| offset + i * stride;
    // c_{i−1} + 4c_i + c_{i+1} = 6f_i, and c = f at the ends.
    let mut factors = vec![0.0; nodes + 1];
    for i in 2..nodes {
        let pivot = 1.0 / (4.0 - factors[i - 1]);
        values[at(i)] = (6.0 * values[at(i)] - values[at(i - 1)]) * pivot;
        factors[i] = pivot;
    }
    for i in (2..nodes).rev() {
        values[at(i)] -= factors[i] * values[at(i + 1)];
    }
    values[at(0)] = 2.0 * values[at(1)] - values[at(2)];
    values[at(nodes + 1)] = 2.0 * values[at(nodes)] - values[at(nodes - 1)];
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::distribution::{Marginal, standard_normal_cdf, standard_normal_pdf};

    /// Returns Jacobi's polynomial up to a factor: ₂F₁(−n, n − 1 + a + b; a; x).
    fn eigenfunction(n: u32, a: f64, b: f64, x: f64) -> f64 {
        let n = f64::from(n);
        let (mut term, mut sum) = (1.0, 1.0);
        for k in 0..n as u32 {
            let k = f64::from(k);
            term *= (k - n) * (k + n - 1.0 + a + b) / ((k + a) * (k + 1.0)) * x;
            sum += term;
        }
        sum
    }

    #[test]
    #[ignore = "slow"]
    fn a_step_multiplies_the_eigenfunctions_by_their_decay() {
        // E[P_n(X_{s+h}) | X_s] = e^{−λ_n h}P_n(X_s) covers all moments of the transition distribution. The trapezoidal
        // rule over ξ is exact except for the error of the table, 1e-6 in a score in which P_n changes by less than its
        // range per unit.
        for (a, b) in [(2.1, 5.0), (0.5, 0.5), (1.0, 1.0), (3.0, 0.8), (40.0, 25.0)] {
            let marginal = Marginal::Beta { a, b, low: 0.0, high: 1.0 };
            for h in [0.3, 0.05, 0.0125] {
                let step = JacobiStep::new(a, b, h).unwrap();
                assert!(step.error < 2e-6, "{a}, {b}, {h}: {:e}", step.error);
                for g in [-3.1, -1.3, 0.0, 0.72, 2.9] {
                    let nodes: Vec<[f64; 2]> = (-192..=192)
                        .map(|k| f64::from(k) / 32.0)
                        .map(|xi| [marginal.translate(step.next(g, xi)), standard_normal_pdf(xi) / 32.0])
                        .collect();
                    let x = marginal.translate(g);
                    for n in 1..=5 {
                        let rate = f64::from(n) * (f64::from(n) - 1.0 + a + b) / (a + b);
                        let wanted = (-rate * h).exp() * eigenfunction(n, a, b, x);
                        let found: f64 = nodes.iter().map(|[y, weight]| weight * eigenfunction(n, a, b, *y)).sum();
                        // |P_n| on the grid of its possible values.
                        let size =
                            (0..=20).map(|i| eigenfunction(n, a, b, 0.05 * f64::from(i)).abs()).fold(0.0, f64::max);
                        assert!((found - wanted).abs() < 1e-6 * size, "{a}, {b}, {h}, {g}, {n}: {found} not {wanted}");
                    }
                }
            }
        }
    }

    #[test]
    fn under_the_arcsine_distribution_the_angle_is_a_reflected_brownian_motion() {
        // X = sin²ψ of a = b = ½: dψ = √(θ/2) dB between reflections at 0 and π/2, and ψ = πΦ(g)/2.
        let quarter = std::f64::consts::FRAC_PI_2;
        for h in [0.2, 0.05] {
            let step = JacobiStep::new(0.5, 0.5, h).unwrap();
            let spread = (0.5 * h).sqrt();
            for g in [-3.0, -1.2, 0.1, 0.9, 2.5] {
                let start = quarter * standard_normal_cdf(g);
                for xi in [-3.7, -2.0, -0.6, 0.0, 0.3, 1.1, 2.9] {
                    let end = quarter * standard_normal_cdf(step.next(g, xi));
                    let images = (-8..=8).map(|k| 2.0 * f64::from(k) * quarter);
                    let below = |image: f64| {
                        standard_normal_cdf((end - start + image) / spread)
                            - standard_normal_cdf((-end - start + image) / spread)
                    };
                    let found: f64 = images.map(below).sum();
                    // The error of the score times the density of the conditional distribution.
                    assert!((found - standard_normal_cdf(xi)).abs() < 2e-6, "{h}, {g}, {xi}: {found}");
                }
            }
        }
    }

    #[test]
    fn steps_too_short_for_the_spectral_sum_are_refused() {
        assert!(JacobiStep::new(2.1, 5.0, 1e-4).is_err() && JacobiStep::new(2.1, 5.0, f64::NAN).is_err());
    }
}
