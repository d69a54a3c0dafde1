//! Uncertain inputs and their dependence.
//!
//! An input *varies* from part to part, or is *unknown*: one value that is not known. The joint distribution is a
//! Gaussian copula: correlated standard normal variables g = Lz of independent ones z, and the value of input i is the
//! quantile of its distribution at Φ(g_i). Rank correlations r of Spearman become the correlations 2 sin(πr/6) of g.
//!
//! ```
//! use asperity_base::distribution::Marginal;
//! use asperity_chaos::{UncertainInput, UncertainInputs};
//!
//! let hardness = UncertainInput::new("hardness", Marginal::lognormal(2e9_f64.ln(), 0.2, 0.0)?, false)?;
//! let damping = UncertainInput::new("damping", Marginal::normal(0.17, 0.02)?, false)?;
//! let inputs = UncertainInputs::new(vec![hardness, damping.truncated(0.0, f64::INFINITY)?], &[(0, 1, 0.6)])?;
//! assert!((inputs.values(&[0.0, 0.0])[1] - 0.17).abs() < 1e-12);
//! let remedy = inputs.with_moved(1, 0.25)?;
//! assert!((remedy.values(&[0.0, 0.0])[1] - 0.25).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # References
//! Lebrun & Dutfoy, *Prob. Eng. Mech.* **24** (2009) 312, <https://doi.org/10.1016/j.probengmech.2008.08.001>.

mod copula;
mod error;
mod input;

pub use copula::Redraw;
pub use error::InputError;
pub use input::UncertainInput;

use asperity_base::distribution::standard_normal_quantile;
use copula::Copula;
use serde::Serialize;

/// Uncertain inputs with a joint distribution.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UncertainInputs {
    inputs: Vec<UncertainInput>,
    copula: Copula,
}

impl UncertainInputs {
    /// Creates inputs with rank correlations: (first input, second input, Spearman's r). Other pairs are independent.
    ///
    /// # Errors
    /// A pair is stated twice or consists of one input, a correlation is not between −1 and 1, an unknown input is
    /// correlated with a varying one, or the correlations contradict each other.
    ///
    /// # Panics
    /// If a correlation refers to an input that does not exist.
    pub fn new(inputs: Vec<UncertainInput>, spearman: &[(usize, usize, f64)]) -> Result<Self, InputError> {
        let n = inputs.len();
        let mut correlation: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
        for (k, &(i, j, spearman_r)) in spearman.iter().enumerate() {
            let name = |input: usize| inputs[input].name().to_owned();
            if i == j {
                return Err(InputError::SameInput { name: name(i) });
            }
            if spearman[..k].iter().any(|&(a, b, _)| (a, b) == (i, j) || (a, b) == (j, i)) {
                return Err(InputError::SamePair { first: name(i), second: name(j) });
            }
            if spearman_r.is_nan() || spearman_r.abs() >= 1.0 {
                return Err(InputError::Correlation { first: name(i), second: name(j), spearman: spearman_r });
            }
            if spearman_r != 0.0 && inputs[i].is_unknown() != inputs[j].is_unknown() {
                let (unknown, varying) = if inputs[i].is_unknown() { (i, j) } else { (j, i) };
                return Err(InputError::UnknownWithVarying { unknown: name(unknown), varying: name(varying) });
            }
            let pearson = 2.0 * (std::f64::consts::PI * spearman_r / 6.0).sin();
            (correlation[i][j], correlation[j][i]) = (pearson, pearson);
        }
        Ok(Self { inputs, copula: Copula::new(correlation)? })
    }

    /// Returns these inputs and more, which are independent of all others.
    #[must_use]
    pub fn with_independent(mut self, more: Vec<UncertainInput>) -> Self {
        self.copula = self.copula.with_independent(more.len());
        self.inputs.extend(more);
        self
    }

    /// Returns the inputs.
    pub fn inputs(&self) -> &[UncertainInput] {
        &self.inputs
    }

    /// Returns whether any inputs are correlated.
    pub fn is_dependent(&self) -> bool {
        self.copula.is_dependent()
    }

    /// Returns the values of the inputs at independent standard normal variables, one per input.
    ///
    /// Varying inputs depend on the variables of varying inputs only, and unknown inputs on those of unknown inputs.
    ///
    /// # Panics
    /// If the number of variables differs from the number of inputs.
    pub fn values(&self, z: &[f64]) -> Vec<f64> {
        self.inputs.iter().zip(self.copula.dependent(z)).map(|(input, g)| input.value(g)).collect()
    }

    /// Returns the inputs with another central value of one of them ([`UncertainInput::moved_to`]) and the same copula.
    ///
    /// # Errors
    /// The central value is impossible.
    ///
    /// # Panics
    /// If there is no such input.
    pub fn with_moved(&self, input: usize, central: f64) -> Result<Self, InputError> {
        let moved = self.inputs[input].moved_to(central)?;
        let mut inputs = self.clone();
        inputs.inputs[input] = moved;
        Ok(inputs)
    }

    /// Returns independent standard normal variables at which one input has its quantile `probability`.
    ///
    /// # Panics
    /// If there is no such input.
    pub fn point_with(&self, input: usize, probability: f64) -> Vec<f64> {
        self.copula.point_with(input, standard_normal_quantile(probability))
    }

    /// Returns the redraw of the last inputs of an order, given the values of those before them.
    ///
    /// # Panics
    /// If `order` does not contain every input once.
    pub fn redraw(&self, order: &[usize]) -> Redraw {
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..self.inputs.len()), "an order of all inputs");
        Redraw::new(&self.copula, order.to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{standard_normal, stream};
    use asperity_base::stats::Moments;

    fn inputs(unknown: [bool; 3]) -> Vec<UncertainInput> {
        ["lognormal:0,1.5", "beta:1,1,-2,5", "triangular:0,0,1"]
            .into_iter()
            .zip(unknown)
            .enumerate()
            .map(|(i, (text, unknown))| UncertainInput::new(&format!("x{i}"), text.parse().unwrap(), unknown).unwrap())
            .collect()
    }

    /// Returns Spearman's rank correlation of values without ties.
    fn spearman(a: &[f64], b: &[f64]) -> f64 {
        let ranks = |values: &[f64]| {
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|i, j| values[*i].total_cmp(&values[*j]));
            let mut ranks = vec![0.0; values.len()];
            order.iter().enumerate().for_each(|(rank, &i)| ranks[i] = rank as f64);
            ranks
        };
        let n = a.len() as f64;
        let squares: f64 = ranks(a).iter().zip(ranks(b)).map(|(a, b)| (a - b) * (a - b)).sum();
        1.0 - 6.0 * squares / (n * (n * n - 1.0))
    }

    #[test]
    fn drawn_values_have_the_stated_rank_correlations() {
        let stated = [(0, 1, 0.7), (2, 0, -0.4)];
        let inputs = UncertainInputs::new(inputs([false; 3]), &stated).unwrap();
        assert!(inputs.is_dependent());
        let n = 2000;
        let batches: Vec<[f64; 3]> = (0..20)
            .map(|batch| {
                let draws: Vec<Vec<f64>> = (0..n)
                    .map(|i| inputs.values(&standard_normal(&mut stream(3, "spearman", batch * n + i), 3)))
                    .collect();
                let column = |i: usize| draws.iter().map(|values| values[i]).collect::<Vec<f64>>();
                [spearman(&column(0), &column(1)), spearman(&column(2), &column(0)), spearman(&column(1), &column(2))]
            })
            .collect();
        for (pair, wanted) in [(0, 0.7), (1, -0.4)] {
            let found = Moments::from_values(batches.iter().map(|batch| batch[pair]));
            assert!((found.mean - wanted).abs() < 4.0 * found.standard_error(), "{pair}: {}", found.mean);
            assert!(found.standard_error() < 0.01);
        }
        // g₁ and g₂ are independent although both depend on g₀: their correlation is not stated.
        let found = Moments::from_values(batches.iter().map(|batch| batch[2]));
        assert!(found.mean.abs() < 4.0 * found.standard_error(), "{}", found.mean);
    }

    #[test]
    fn independent_values_are_the_quantiles_and_a_move_changes_one_of_them() {
        let inputs = UncertainInputs::new(inputs([false, true, false]), &[(0, 1, 0.0)]).unwrap();
        assert!(!inputs.is_dependent());
        let z = [0.4, -1.0, 2.0];
        let values = inputs.values(&z);
        for (input, (value, z)) in inputs.inputs().iter().zip(values.iter().zip(z)) {
            assert_eq!(*value, input.value(z));
        }
        let moved = inputs.with_moved(1, 2.5).unwrap().values(&z);
        assert_eq!((moved[0], moved[2]), (values[0], values[2]));
        assert!((moved[1] - values[1] - 1.0).abs() < 1e-14);
        assert!(inputs.with_moved(0, -1.0).is_err());
    }

    #[test]
    fn unknown_values_do_not_depend_on_variables_of_varying_inputs() {
        let inputs = UncertainInputs::new(inputs([true, false, true]), &[(0, 2, 0.8)]).unwrap();
        let (a, b) = (inputs.values(&[0.3, 1.0, -0.7]), inputs.values(&[0.3, -2.0, -0.7]));
        assert_eq!((a[0], a[2]), (b[0], b[2]));
        assert_ne!(a[1], b[1]);
    }

    #[test]
    fn a_point_has_the_requested_quantile_of_one_input() {
        let inputs = UncertainInputs::new(inputs([false; 3]), &[(0, 1, 0.7), (2, 0, -0.4)]).unwrap();
        for input in 0..3 {
            let value = inputs.values(&inputs.point_with(input, 0.05))[input];
            assert!((value / inputs.inputs()[input].quantile(0.05) - 1.0).abs() < 1e-13, "{input}");
        }
    }

    #[test]
    fn impossible_correlations_are_errors_with_names() {
        let error = |spearman: &[(usize, usize, f64)], unknown| {
            UncertainInputs::new(inputs(unknown), spearman).unwrap_err().to_string()
        };
        let none = [false; 3];
        assert_eq!(
            error(&[(0, 1, 0.2), (1, 0, 0.3)], none),
            "the correlation of `x1` and `x0` is stated twice; keep one"
        );
        assert_eq!(error(&[(1, 1, 0.2)], none), "a correlation of `x1` with itself; name two different inputs");
        assert!(error(&[(0, 2, -1.0)], none).contains("is -1; it must lie between -1 and 1"));
        assert!(error(&[(0, 2, f64::NAN)], none).contains("NaN"));
        assert!(error(&[(0, 1, 0.9), (1, 2, 0.9), (0, 2, -0.9)], none).contains("contradict"));
        assert!(error(&[(1, 0, 0.1)], [true, false, false]).starts_with("`x0` is unknown and `x1` varies"));
        let unknowns = UncertainInputs::new(inputs([true, true, false]), &[(0, 1, 0.1)]);
        assert!(unknowns.unwrap().is_dependent());
    }
}
