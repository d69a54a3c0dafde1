//! One uncertain input.

use super::InputError;
use crate::Parameter;
use asperity_base::distribution::{DistributionError, Marginal, standard_normal_cdf, standard_normal_quantile};
use serde::Serialize;

/// Largest probability beyond the bounds of a stated distribution.
const LARGEST_MASS: f64 = 1e-3;
/// Largest probability beyond the bounds after [`UncertainInput::moved_to`].
const LARGEST_MOVED_MASS: f64 = 0.5;
/// Probability beyond the bounds that is smaller than rounding errors.
const NEGLIGIBLE_MASS: f64 = 1e-16;

/// Input whose value varies from part to part, or is one value that is not known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UncertainInput {
    parameter: Parameter,
    unknown: bool,
    bounds: Bounds,
}

/// Physical bounds of an input, and the probabilities of the distribution beyond them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Bounds {
    low: f64,
    high: f64,
    below: f64,
    above: f64,
}

impl UncertainInput {
    /// Creates an input that varies from part to part or, if `unknown`, has one value that is not known.
    ///
    /// # Errors
    /// A parameter of the distribution is out of range.
    pub fn new(name: &str, marginal: Marginal, unknown: bool) -> Result<Self, InputError> {
        let parameter = named(name, Parameter::new(name, marginal))?;
        let bounds = Bounds { low: f64::NEG_INFINITY, high: f64::INFINITY, below: 0.0, above: 0.0 };
        Ok(Self { parameter, unknown, bounds })
    }

    /// Returns the name.
    pub fn name(&self) -> &str {
        self.parameter.name()
    }

    /// Returns the distribution without truncation.
    pub fn marginal(&self) -> &Marginal {
        self.parameter.marginal()
    }

    /// Returns whether the input is one unknown value. Otherwise it varies from part to part.
    pub fn is_unknown(&self) -> bool {
        self.unknown
    }

    /// Returns the central value: the median of the distribution without truncation. It is the mean of a normal and
    /// the middle of a uniform distribution.
    pub fn central(&self) -> f64 {
        match *self.marginal() {
            // Exact, without iterations.
            Marginal::Beta { a, b, low, high } if a == b => 0.5 * (low + high),
            _ => self.marginal().translate(0.0),
        }
    }

    /// Returns the input with another central value and the same bounds.
    ///
    /// A lognormal distribution keeps the standard deviation of its logarithm, and its shift. All other distributions
    /// are shifted, which keeps their standard deviation. The limit of [`UncertainInput::truncated`] does not apply:
    /// up to half of the moved distribution may lie beyond the bounds.
    ///
    /// # Errors
    /// The central value is not finite or not between the bounds (above the shift of a lognormal distribution), or
    /// more than half of the distribution would lie beyond the bounds.
    pub fn moved_to(&self, central: f64) -> Result<Self, InputError> {
        let Bounds { low, high, .. } = self.bounds;
        let low = if let Marginal::Lognormal { shift, .. } = self.marginal() { low.max(*shift) } else { low };
        if !(central.is_finite() && central > low && central < high) {
            return Err(InputError::Central { name: self.name().into(), central, low, high });
        }
        let marginal = match self.marginal() {
            Marginal::Lognormal { sigma, shift, .. } => Marginal::lognormal((central - shift).ln(), *sigma, *shift),
            other => other.standardised(other.mean() + (central - self.central()), other.std()),
        };
        let moved = Self::new(self.name(), named(self.name(), marginal)?, self.unknown)?;
        moved.bounded(self.bounds.low, high, LARGEST_MOVED_MASS)
    }

    /// Returns the input with its distribution truncated at physical bounds, which may be infinite. Values lie
    /// strictly between the bounds; point masses of an empirical distribution may lie on them.
    ///
    /// # Errors
    /// More than 0.1 % of the distribution lies beyond the bounds.
    ///
    /// # Panics
    /// If `low` is not below `high`.
    pub fn truncated(&self, low: f64, high: f64) -> Result<Self, InputError> {
        self.clone().bounded(low, high, LARGEST_MASS)
    }

    /// Returns the probability of the distribution beyond the bounds, which truncate it.
    pub fn truncated_mass(&self) -> f64 {
        self.bounds.below + self.bounds.above
    }

    fn bounded(mut self, low: f64, high: f64, largest: f64) -> Result<Self, InputError> {
        assert!(low < high, "bounds [{low}, {high}] contain no value");
        let marginal = self.marginal();
        // Values equal to a bound are not beyond it.
        let below = if low == f64::NEG_INFINITY { 0.0 } else { marginal.cdf(low.next_down()) };
        let above = if high == f64::INFINITY { 0.0 } else { marginal.survival(high) };
        let mass = below + above;
        if mass > largest {
            return Err(InputError::Mass { name: self.name().into(), mass, low, high });
        }
        self.bounds = Bounds { low, high, below, above };
        Ok(self)
    }

    /// Returns the value at a standard normal variable: the quantile of the truncated distribution at Φ(g).
    pub fn value(&self, g: f64) -> f64 {
        let Bounds { low, high, .. } = self.bounds;
        let g = self.untruncated(g);
        let value = match *self.marginal() {
            // Without the iterations of general shapes.
            Marginal::Beta { a: 1.0, b: 1.0, low, high } if g <= 0.0 => low + (high - low) * standard_normal_cdf(g),
            Marginal::Beta { a: 1.0, b: 1.0, low, high } => high - (high - low) * standard_normal_cdf(-g),
            _ => self.marginal().translate(g),
        };
        match self.marginal() {
            Marginal::Empirical { .. } => value.clamp(low, high),
            _ => value.clamp(low.next_up(), high.next_down()),
        }
    }

    /// Returns the quantile of the truncated distribution.
    pub fn quantile(&self, probability: f64) -> f64 {
        self.value(standard_normal_quantile(probability))
    }

    /// Returns the standard normal variable at which the distribution without truncation has the quantile that the
    /// truncated one has at `g`.
    fn untruncated(&self, g: f64) -> f64 {
        let Bounds { below, above, .. } = self.bounds;
        if self.truncated_mass() < NEGLIGIBLE_MASS {
            return g;
        }
        let kept = 1.0 - below - above;
        let (lower, upper) = (below + kept * standard_normal_cdf(g), above + kept * standard_normal_cdf(-g));
        if lower < upper { standard_normal_quantile(lower) } else { -standard_normal_quantile(upper) }
    }
}

fn named<T>(name: &str, result: Result<T, DistributionError>) -> Result<T, InputError> {
    result.map_err(|source| InputError::Distribution { name: name.into(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(text: &str) -> UncertainInput {
        UncertainInput::new("input", text.parse().unwrap(), false).unwrap()
    }

    #[test]
    fn the_central_value_is_the_median() {
        assert_eq!(input("normal:0.1,0.02").central(), 0.1);
        assert_eq!(input("beta:1,1,0.1,0.5").central(), 0.3);
        assert!((input("lognormal:0.5,0.3,2").central() - (2.0 + 0.5_f64.exp())).abs() < 1e-14);
        assert!((input("triangular:1,2,5").central() - (5.0 - 6.0_f64.sqrt())).abs() < 1e-14);
        let sampled = Marginal::empirical(vec![1.0, 2.0, 7.0]).unwrap();
        assert_eq!(UncertainInput::new("sampled", sampled, true).unwrap().central(), 2.0);
    }

    #[test]
    fn a_moved_distribution_keeps_its_standard_deviation_or_that_of_its_logarithm() {
        let moved = input("normal:0.1,0.02").moved_to(0.07).unwrap();
        assert_eq!(*moved.marginal(), Marginal::normal(0.1 + (0.07 - 0.1), 0.02).unwrap());
        let moved = input("lognormal:0.5,0.3").moved_to(4.0).unwrap();
        assert_eq!(*moved.marginal(), Marginal::lognormal(4.0_f64.ln(), 0.3, 0.0).unwrap());
        for text in ["beta:1,1,0.1,0.5", "beta:2.1,5", "triangular:1,2,5", "weibull:1.5,2", "lognormal:0,0.4,-1"] {
            let (before, after) = (input(text), input(text).moved_to(3.0).unwrap());
            assert!((after.central() - 3.0).abs() < 1e-12, "{text}: {}", after.central());
            if !text.starts_with("lognormal") {
                let shift = 3.0 - before.central();
                for g in [-2.0, 0.3, 1.5] {
                    assert!((after.value(g) - before.value(g) - shift).abs() < 1e-12, "{text}");
                }
            }
        }
        let sampled = Marginal::empirical(vec![1.0, 2.0, 7.0]).unwrap();
        let moved = UncertainInput::new("sampled", sampled, false).unwrap().moved_to(3.0).unwrap();
        let Marginal::Empirical { sorted } = moved.marginal() else { panic!("{:?}", moved.marginal()) };
        assert!(sorted.iter().zip([2.0, 3.0, 8.0]).all(|(found, wanted)| (found - wanted).abs() < 1e-14));
        let error = input("lognormal:0.5,0.3").moved_to(0.0).unwrap_err();
        assert_eq!(error.to_string(), "`input`: the central value 0 does not lie between 0 and inf");
    }

    #[test]
    fn a_truncated_value_is_the_conditional_quantile() {
        // P(x ≤ v | low < x < high) = Φ(g) for the value v at g.
        let free = Marginal::normal(0.6, 0.19).unwrap();
        for (low, high) in [(0.0, 1.3), (-0.1, 1.2)] {
            let bounded = UncertainInput::new("input", free.clone(), false).unwrap();
            let bounded = bounded.truncated(low, high).unwrap();
            let (below, above) = (free.cdf(low), free.survival(high));
            assert!(
                (bounded.bounds.below + bounded.bounds.above - below - above).abs() < 1e-18 && below + above > 5e-4
            );
            for g in [-8.0, -3.0, 0.0, 2.0, 5.0] {
                let value = bounded.value(g);
                let lower = (free.cdf(value) - below) / (1.0 - below - above);
                let upper = (free.survival(value) - above) / (1.0 - below - above);
                assert!(
                    (lower - standard_normal_cdf(g)).abs() < 1e-15 && (upper - standard_normal_cdf(-g)).abs() < 1e-15
                );
            }
            assert_eq!(bounded.quantile(0.3), bounded.value(standard_normal_quantile(0.3)));
        }
    }

    #[test]
    fn values_lie_strictly_between_the_bounds() {
        for text in ["normal:1,0.25", "lognormal:-0.5,0.1", "beta:1,1,0,2", "beta:2,2,0,2", "triangular:0,1,2"] {
            let bounded = input(text).truncated(0.0, 2.0).unwrap();
            for g in [-40.0, -9.0, 0.0, 9.0, 40.0] {
                assert!(bounded.value(g) > 0.0 && bounded.value(g) < 2.0, "{text} at {g}: {}", bounded.value(g));
            }
        }
        let sampled = Marginal::empirical((0..=10).map(f64::from).collect()).unwrap();
        let bounded = UncertainInput::new("sampled", sampled, false).unwrap().truncated(0.0, 10.0).unwrap();
        assert_eq!((bounded.value(-3.0), bounded.value(3.0)), (0.0, 10.0));
    }

    #[test]
    fn mass_beyond_a_bound_is_an_error_that_states_it() {
        let error = input("normal:0.1,0.05").truncated(0.0, f64::INFINITY).unwrap_err();
        assert_eq!(
            error.to_string(),
            "`input`: 2.275 % of its distribution lies outside [0, inf]; choose a distribution within these \
             bounds, for instance lognormal or triangular"
        );
        assert!(input("normal:0.1,0.0324").truncated(0.0, 1.0).is_err(), "0.101 %");
        let near = input("normal:0.1,0.0323").truncated(0.0, 1.0).unwrap();
        let beyond = |input: &UncertainInput| input.bounds.below + input.bounds.above;
        assert!(beyond(&near) < 1e-3 && beyond(&near) > 9.7e-4);
        // A move may exceed the limit, but not leave the bounds.
        let moved = near.moved_to(0.05).unwrap();
        assert!((beyond(&moved) - standard_normal_cdf(-0.05 / 0.0323)).abs() < 1e-15);
        assert!(moved.value(-9.0) > 0.0);
        assert!(matches!(near.moved_to(0.0), Err(InputError::Central { low: 0.0, high: 1.0, .. })));
        assert!(matches!(near.moved_to(f64::NAN), Err(InputError::Central { .. })));
    }

    #[test]
    fn an_invalid_distribution_is_an_error_with_the_name() {
        let error = UncertainInput::new("load", Marginal::Normal { mean: 0.0, std: -1.0 }, false).unwrap_err();
        assert_eq!(error.to_string(), "`load`: normal: std is -1, but must be positive and finite");
    }
}
