//! Derivatives of a slip orbit, computed from the polynomials of its steps.
//!
//! The derivative (δW, δe) of a state of slip or over-slip with respect to a parameter obeys
//!
//! δW′ = δe + g·δW + a,  δe′ = −δW + b,  g = −dμ/d|v| − 2ζ,
//!
//! Here g is evaluated along the orbit, and (a, b) depends on the parameter. One step is solved by collocation at the
//! Gauss points, of order 24 like the series that gives W there. The friction law therefore only has to provide W(t)
//! and the slope of the law.

use std::sync::LazyLock;

use super::super::Oscillator;
use super::super::series::Series;
use asperity_base::numeric::{gauss_legendre, solve};

/// Number of Gauss points of a step.
const NODES: usize = 12;

type Vector = [f64; NODES];

/// Gauss–Legendre rule on [0, 1].
struct Rule {
    nodes: Vector,
    weights: Vector,
    /// Integral of the j-th Lagrange polynomial from 0 to node i.
    integrals: [Vector; NODES],
    /// Square of that matrix.
    twice: [Vector; NODES],
}

static RULE: LazyLock<Rule> = LazyLock::new(Rule::new);

/// Returns P_0(x) … P_NODES(x).
fn legendre(x: f64) -> [f64; NODES + 1] {
    let mut p = [1.0; NODES + 1];
    p[1] = x;
    for k in 1..NODES {
        let n = k as f64;
        p[k + 1] = ((2.0 * n + 1.0) * x * p[k] - n * p[k - 1]) / (n + 1.0);
    }
    p
}

impl Rule {
    fn new() -> Self {
        let mut rule = gauss_legendre::<NODES>();
        rule.reverse();
        let (roots, doubled) = (rule.map(|(x, _)| x), rule.map(|(_, weight)| weight));
        // The integral of P_k from −1 to x is (P_{k+1} − P_{k−1})/(2k + 1), and x + 1 for k = 0.
        let integrals = std::array::from_fn(|i| {
            let p = legendre(roots[i]);
            std::array::from_fn(|j| {
                let q = legendre(roots[j]);
                let sum: f64 = (1..NODES).map(|k| q[k] * (p[k + 1] - p[k - 1])).sum();
                0.25 * doubled[j] * (roots[i] + 1.0 + sum)
            })
        });
        let twice = std::array::from_fn(|i: usize| {
            std::array::from_fn(|j| {
                let (row, of): (&Vector, &[Vector; NODES]) = (&integrals[i], &integrals);
                (0..NODES).map(|k| row[k] * of[k][j]).sum()
            })
        });
        Self { nodes: roots.map(|x| 0.5 * (1.0 + x)), weights: doubled.map(|w| 0.5 * w), integrals, twice }
    }
}

/// Step of an orbit: the series about its start, and its length.
#[derive(Clone, Copy)]
pub(crate) struct Step<'a> {
    pub(crate) series: &'a Series,
    pub(crate) length: f64,
}

/// Tangent δ(W, e).
pub(crate) type Tangent = [f64; 2];

/// Linearised equations along the orbits of one oscillator.
pub(crate) struct Linear<'a>(pub(crate) &'a Oscillator);

impl Linear<'_> {
    /// Returns g at the scaled relative speed W.
    pub(crate) fn gain(&self, w: f64) -> f64 {
        self.0.law().weakening(self.0.belt_velocity() * w) - 2.0 * self.0.damping_ratio()
    }

    /// Returns ∫g over a step, the logarithm of the factor by which the step stretches areas.
    pub(crate) fn stretch(&self, step: Step) -> f64 {
        let sum: f64 = (0..NODES).map(|i| RULE.weights[i] * self.gain(speed(step, i))).sum();
        step.length * sum
    }

    /// Advances tangents to the end of a step. `source` returns (a, b) of each at a time since its start and W there.
    pub(crate) fn carry<const K: usize>(
        &self,
        step: Step,
        tangents: &mut [Tangent; K],
        source: impl Fn(f64, f64) -> [Tangent; K],
    ) {
        let (rule, h) = (&*RULE, step.length);
        let w: Vector = std::array::from_fn(|i| speed(step, i));
        let gains = w.map(|w| self.gain(w));
        let sources: [[Tangent; K]; NODES] = std::array::from_fn(|i| source(rule.nodes[i] * h, w[i]));
        // Elimination of e: (1 − hBG + h²B²) δW = δW₀ + hB(δe₀ + a) + h²B²b.
        let mut matrix: [Vector; NODES] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let unit = if i == j { 1.0 } else { 0.0 };
                unit - h * rule.integrals[i][j] * gains[j] + h * h * rule.twice[i][j]
            })
        });
        let mut right: [[f64; K]; NODES] = std::array::from_fn(|i| {
            std::array::from_fn(|k| {
                let [w0, e0] = tangents[k];
                let sum: f64 = (0..NODES)
                    .map(|j| {
                        let [a, b] = sources[j][k];
                        rule.integrals[i][j] * (e0 + a) + h * rule.twice[i][j] * b
                    })
                    .sum();
                w0 + h * sum
            })
        });
        solve(&mut matrix, &mut right);
        for k in 0..K {
            let [w0, e0] = tangents[k];
            let excess = |i: usize| {
                let sum: f64 = (0..NODES).map(|j| rule.integrals[i][j] * (sources[j][k][1] - right[j][k])).sum();
                e0 + h * sum
            };
            let (mut dw, mut de) = (0.0, 0.0);
            for j in 0..NODES {
                let [a, b] = sources[j][k];
                dw += rule.weights[j] * (excess(j) + gains[j] * right[j][k] + a);
                de += rule.weights[j] * (b - right[j][k]);
            }
            tangents[k] = [w0 + h * dw, e0 + h * de];
        }
    }
}

fn speed(step: Step, node: usize) -> f64 {
    step.series.state(RULE.nodes[node] * step.length).0
}

#[cfg(test)]
mod tests {
    use super::super::super::weakening::Loading;
    use super::super::super::weakening::Weakening;
    use super::*;

    const FREE: Loading = Loading { base: 1.0, kappa: 1.0, swing: 0.0, frequency: 0.0, phase: 0.0 };

    #[test]
    fn the_rule_integrates_polynomials_up_to_degree_23_between_its_ends_and_11_to_its_nodes() {
        for degree in 0..24 {
            let sum: f64 = (0..NODES).map(|j| RULE.weights[j] * RULE.nodes[j].powi(degree)).sum();
            assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-14);
        }
        for degree in 0..12 {
            for i in 0..NODES {
                let sum: f64 = (0..NODES).map(|j| RULE.integrals[i][j] * RULE.nodes[j].powi(degree)).sum();
                assert!((sum - RULE.nodes[i].powi(degree + 1) / f64::from(degree + 1)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn the_rate_of_the_orbit_is_a_tangent_and_areas_stretch_by_the_integral_of_the_gain() {
        let oscillator = Oscillator::with_stribeck(0.3, 4.2, 0.1, 0.2).unwrap();
        let weakening = Weakening::new(&oscillator);
        let rate = |w: f64, e: f64| [weakening.acceleration(w, e), 1.0 - w];
        let mut series = Series::new();
        for (w, e) in [(0.0, 0.3), (1.2, -0.4), (2.5, 0.7)] {
            series.expand(&weakening, &FREE, w, e, f64::INFINITY);
            let step = Step { series: &series, length: series.reach(f64::INFINITY) };
            let linear = Linear(&oscillator);
            let mut tangents = [rate(w, e), [1.0, 0.0], [0.0, 1.0]];
            linear.carry(step, &mut tangents, |_, _| [[0.0; 2]; 3]);
            let (w, e) = series.state(step.length);
            let wanted = rate(w, e);
            for i in 0..2 {
                // The step ends where its dropped terms are of the order 1e-13.
                assert!((tangents[0][i] - wanted[i]).abs() < 1e-13, "{tangents:?} instead of {wanted:?}");
            }
            let area = tangents[1][0] * tangents[2][1] - tangents[1][1] * tangents[2][0];
            assert!((area.ln() - linear.stretch(step)).abs() < 1e-13);
        }
    }
}
