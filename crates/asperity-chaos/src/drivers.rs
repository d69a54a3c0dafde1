//! Drivers of a response: how much of its variance each uncertain input causes.
//!
//! [`PickFreeze`] evaluates a cheap response at points of the input space, and again with some inputs drawn anew while
//! the others keep their values. Half the mean square of the difference estimates E Var\[f | kept inputs\]. Inputs are
//! redrawn from their distribution given the kept ones, so the estimates hold for dependent inputs, too. The response
//! may be an indicator of an event (1 or 0). [`NestedSampling`] estimates how a probability depends on unknown inputs.
//!
//! ```
//! use asperity_base::distribution::Marginal;
//! use asperity_chaos::{PickFreeze, UncertainInput, UncertainInputs};
//!
//! // The variance 1 of x₀ and 4 of 2x₁.
//! let input = |name| UncertainInput::new(name, Marginal::STANDARD_NORMAL, false);
//! let inputs = UncertainInputs::new(vec![input("x0")?, input("x1")?], &[])?;
//! let response = |points: &[Vec<f64>]| {
//!     let values = points.iter().map(|z| inputs.values(z));
//!     values.map(|x| x[0] + 2.0 * x[1]).collect()
//! };
//! let drivers = PickFreeze::new(7).drivers(&inputs, &response)?;
//! assert!((drivers.total[0].value - 0.2).abs() < 0.01 && (drivers.first_order[1].value - 0.8).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # References
//! Janon, Klein, Lagnoux, Nodet & Prieur, *ESAIM: Probab. Stat.* **18** (2014) 342,
//! <https://doi.org/10.1051/ps/2013040>; Owen & Prieur, *SIAM/ASA J. Uncertain. Quantif.* **5** (2017) 986,
//! <https://doi.org/10.1137/16M1097717>.

mod error;
mod permutations;
mod replicates;
mod subsets;
#[cfg(test)]
mod tests;
mod unknowns;

use crate::{Design, SampleEstimate, SamplingMethod, UncertainInputs};
use asperity_base::stats::Interval;
use error::MAX_INPUTS;
use permutations::Permutations;
use replicates::Replicates;
use subsets::Subsets;

pub use error::DriverError;
pub use unknowns::{NestedSampling, ProbabilityOverUnknowns, UnknownEffect};

/// Largest number of inputs for which Shapley effects are computed from all subsets.
const MAX_EXACT: usize = 8;

/// Response at points of independent standard normal variables.
type Response<'a> = dyn Fn(&[Vec<f64>]) -> Vec<f64> + Sync + 'a;

/// Pick-freeze estimates from 16 independent randomisations of a design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PickFreeze {
    /// Placement of the points.
    pub method: SamplingMethod,
    /// Points of each randomisation; a power of two for Sobol' points.
    pub points: usize,
    /// Seed of the stages "chaos/drivers" and "chaos/drivers/permutations".
    pub seed: u64,
}

/// Fractions of the variance of a response, in the order of the inputs.
///
/// The intervals have 95 % confidence (Student's distribution over the randomisations).
#[derive(Debug, Clone, PartialEq)]
pub struct Drivers {
    /// First-order index Var E\[f | x_i\]/Var f: how much the variance falls on average when the input is known.
    pub first_order: Vec<SampleEstimate>,
    /// Total index E Var\[f | all inputs but x_i\]/Var f: how much variance remains when only this input is uncertain.
    pub total: Vec<SampleEstimate>,
    /// Shapley effects of dependent inputs, which sum to one; `None` for independent inputs. Estimates of small
    /// effects may be negative.
    pub shapley: Option<Vec<SampleEstimate>>,
}

impl PickFreeze {
    /// Creates the settings for 16 × 1,024 Sobol' points.
    pub fn new(seed: u64) -> Self {
        Self { method: SamplingMethod::Sobol, points: 1024, seed }
    }

    /// Estimates the drivers of a response to independent standard normal variables z, one per input; the response returns its
    /// values at several points, and uses [`UncertainInputs::values`] for the values of the inputs.
    ///
    /// A point of n independent inputs takes 2n + 1 evaluations. Dependent inputs take one evaluation for each of the
    /// 2ⁿ − 1 subsets if n ≤ 8; for more inputs, random permutations give the Shapley effects with n further evaluations.
    ///
    /// # Errors
    /// The response is constant or not finite, there are no or more than 64 inputs, or the design is empty.
    ///
    /// # Panics
    /// If the response returns another number of values than points.
    ///
    /// # References
    /// Song, Nelson & Staum, *SIAM/ASA J. Uncertain. Quantif.* **4** (2016) 1060, <https://doi.org/10.1137/15M1048070>
    /// (permutations).
    pub fn drivers(&self, inputs: &UncertainInputs, response: &Response<'_>) -> Result<Drivers, DriverError> {
        let n = inputs.inputs().len();
        if n > MAX_INPUTS {
            return Err(DriverError::TooManyInputs { inputs: n });
        }
        let design = Design::new(self.method, self.seed, "chaos/drivers", self.points, 2 * n)?;
        let replicates = Replicates::new(&design)?;
        let origin = finite(response, &[vec![0.0; n]])?[0];
        let centred = Centred { response, origin };
        let exact = inputs.is_dependent() && n <= MAX_EXACT;
        let subsets = if exact { Subsets::all(inputs) } else { Subsets::single(inputs) };
        let sums = replicates.sums(subsets.width(), |point, sums| subsets.add(point, &centred, sums))?;
        let mut shapley = None;
        if exact {
            shapley = Some(replicates.estimates(&sums, &|sums| subsets.shapley_effects(sums))?);
        } else if inputs.is_dependent() {
            let permutations = Permutations::new(inputs, self.seed);
            let sums = replicates.sums(permutations.width(), |point, sums| permutations.add(point, &centred, sums))?;
            shapley = Some(replicates.estimates(&sums, &|sums| permutations.shapley_effects(sums))?);
        }
        let indices = |statistic: &dyn Fn(&[f64]) -> Vec<f64>| -> Result<Vec<SampleEstimate>, DriverError> {
            Ok(replicates.estimates(&sums, statistic)?.into_iter().map(clipped).collect())
        };
        Ok(Drivers {
            first_order: indices(&|sums| subsets.first_order(sums))?,
            total: indices(&|sums| subsets.total(sums))?,
            shapley,
        })
    }
}

/// Returns the estimate of an index between 0 and 1.
fn clipped(
    SampleEstimate { value, standard_error, interval: Interval { low, high } }: SampleEstimate,
) -> SampleEstimate {
    let [value, low, high] = [value, low, high].map(|end| end.clamp(0.0, 1.0));
    SampleEstimate { value, standard_error, interval: Interval { low, high } }
}

/// Differences of a response from its value at one point, which avoid cancellation in its variance.
struct Centred<'a> {
    response: &'a Response<'a>,
    origin: f64,
}

impl Centred<'_> {
    fn at(&self, points: &[Vec<f64>]) -> Result<Vec<f64>, DriverError> {
        let mut values = finite(self.response, points)?;
        values.iter_mut().for_each(|value| *value -= self.origin);
        Ok(values)
    }
}

/// Evaluates a response.
///
/// # Errors
/// A value is not finite.
///
/// # Panics
/// If the numbers of values and points differ.
fn finite(response: &Response<'_>, points: &[Vec<f64>]) -> Result<Vec<f64>, DriverError> {
    let values = response(points);
    assert_eq!(values.len(), points.len(), "values of a response");
    match values.iter().zip(points).find(|(value, _)| !value.is_finite()) {
        Some((value, z)) => Err(DriverError::NotFinite { value: *value, z: z.clone() }),
        None => Ok(values),
    }
}
