//! Independent randomisations of a design, and estimates with jackknife intervals over them.

use super::error::DriverError;
use crate::{Design, SampleEstimate};
use asperity_base::blocks;
use asperity_base::stats::{Interval, jackknife_error, student_95};

/// Number of randomisations.
const COUNT: usize = 16;
/// Points of a block.
const BLOCK: usize = 64;

/// Point of the input space, and variables for inputs that are drawn anew.
pub(super) struct Point<'a> {
    /// Number of the point over all randomisations.
    pub(super) index: usize,
    /// Independent standard normal variables of the inputs.
    pub(super) z: &'a [f64],
    /// Further standard normal variables, one per input.
    pub(super) fresh: &'a [f64],
}

/// Randomisations of a design in two variables per input.
pub(super) struct Replicates(Vec<Design>);

impl Replicates {
    pub(super) fn new(design: &Design) -> Result<Self, DriverError> {
        Ok(Self((0..COUNT).map(|number| design.replicate(number)).collect::<Result<_, _>>()?))
    }

    /// Returns the sums over the points of each randomisation; `add` adds the terms of a point.
    ///
    /// # Errors
    /// The error of a point.
    pub(super) fn sums(
        &self,
        width: usize,
        add: impl Fn(&Point<'_>, &mut [f64]) -> Result<(), DriverError> + Sync,
    ) -> Result<Vec<Vec<f64>>, DriverError> {
        let points = self.0[0].samples();
        let blocks_each = points.div_ceil(BLOCK);
        let block = |number: usize| -> Result<Vec<f64>, DriverError> {
            let (replicate, first) = (number / blocks_each, number % blocks_each * BLOCK);
            let mut sums = vec![0.0; width];
            for k in first..points.min(first + BLOCK) {
                let xi = self.0[replicate].xi(k);
                let (z, fresh) = xi.split_at(xi.len() / 2);
                add(&Point { index: replicate * points + k, z, fresh }, &mut sums)?;
            }
            Ok(sums)
        };
        let parts = blocks::map::<_, Result<Vec<Vec<f64>>, DriverError>>(0..COUNT * blocks_each, block)?;
        Ok(parts.chunks(blocks_each).map(|parts| total(parts, width)).collect())
    }

    /// Estimates fractions that are functions of the sums, with the delete-one jackknife. Intervals extend beyond [0, 1]
    /// only if the value does.
    ///
    /// # Errors
    /// The response is constant: a fraction is not finite.
    pub(super) fn estimates(
        &self,
        sums: &[Vec<f64>],
        statistic: &dyn Fn(&[f64]) -> Vec<f64>,
    ) -> Result<Vec<SampleEstimate>, DriverError> {
        let all = total(sums, sums[0].len());
        let without: Vec<Vec<f64>> = sums
            .iter()
            .map(|own| statistic(&all.iter().zip(own).map(|(all, own)| all - own).collect::<Vec<f64>>()))
            .collect();
        let reach = student_95(sums.len());
        let estimate = |(i, value): (usize, f64)| {
            let standard_error = jackknife_error(&without.iter().map(|values| values[i]).collect::<Vec<f64>>());
            let [low, high] = [-reach, reach].map(|deviate| (value + deviate * standard_error).clamp(0.0, 1.0));
            SampleEstimate { value, standard_error, interval: Interval { low: low.min(value), high: high.max(value) } }
        };
        let values = statistic(&all);
        if !values.iter().chain(without.iter().flatten()).all(|value| value.is_finite()) {
            return Err(DriverError::Constant);
        }
        Ok(values.into_iter().enumerate().map(estimate).collect())
    }
}

/// Returns the sum of rows, in their order.
fn total(rows: &[Vec<f64>], width: usize) -> Vec<f64> {
    rows.iter().fold(vec![0.0; width], |sums, row| sums.iter().zip(row).map(|(sum, term)| sum + term).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jackknife_of_a_mean_has_its_standard_error_and_students_interval() {
        let values = [0.41, 0.52, 0.47, 0.55, 0.49, 0.5, 0.44, 0.58];
        let sums: Vec<Vec<f64>> = values.iter().map(|value| vec![1.0, *value]).collect();
        let found = Replicates(Vec::new()).estimates(&sums, &|sums| vec![sums[1] / sums[0]]).unwrap()[0];
        // Mean 0.495, sum of squared deviations 0.0218; the 97.5 % quantile of Student's distribution of 7 is 2.364624.
        let standard_error = (0.0218_f64 / 7.0 / 8.0).sqrt();
        assert!((found.value - 0.495).abs() < 1e-15 && (found.standard_error - standard_error).abs() < 1e-12);
        assert!((found.interval.low - (0.495 - 2.364624 * standard_error)).abs() < 1e-8, "{found:?}");
        assert!((found.interval.high - (0.495 + 2.364624 * standard_error)).abs() < 1e-8, "{found:?}");
    }
}
