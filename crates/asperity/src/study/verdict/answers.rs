//! Probability that machines vibrate at one central value, with its error.

use super::decided::LEAST_CHANCE;
use super::replicates::{REPLICATES, fraction_below_zero, fraction_unanswered, half_width};
use crate::stats::{Interval, quantile_sorted};

/// Answers of the machines of all replicates, or of one, at one central value.
pub(super) struct Answers {
    /// Margins with constant friction, in rising order.
    sorted: Vec<f64>,
    /// Fraction that vibrates of each replicate, or of each of as many parts of one.
    fractions: Vec<f64>,
    /// Fraction that vibrates of all machines.
    probability: f64,
    /// Margin below which as many machines are as vibrate; `None` if friction is constant and the margin is 0.
    limit: Option<f64>,
}

impl Answers {
    /// Returns the answers of machines that vibrate if their margin is negative.
    pub(super) fn with_constant_friction(margins: Vec<f64>) -> Self {
        let fractions = parts(&margins).map(fraction_below_zero).collect();
        Self { fractions, probability: fraction_below_zero(&margins), limit: None, sorted: sorted(margins) }
    }

    /// Returns the answers of machines whose friction fluctuates, with their [terms](super::decided::terms) of the probability.
    pub(super) fn with_fluctuation(margins: Vec<f64>, terms: &[f64]) -> Self {
        let mean = |terms: &[f64]| terms.iter().sum::<f64>() / terms.len() as f64;
        let (sorted, probability) = (sorted(margins), mean(terms));
        let limit = quantile_sorted(&sorted, probability.clamp(0.0, 1.0));
        Self { fractions: parts(terms).map(mean).collect(), probability, limit: Some(limit), sorted }
    }

    /// Returns a continuous number that is positive if fewer than the fraction `probability` of the machines vibrate: the distance of that
    /// quantile of the margin from the limit.
    pub(super) fn excess(&self, probability: f64) -> f64 {
        let quantile = self.quantile(probability);
        let Some(limit) = self.limit else { return quantile };
        let excess = quantile - limit;
        // A single machine has one margin.
        if excess == 0.0 || excess.is_nan() { probability - self.probability } else { excess }
    }

    /// Returns the fraction of the machines that vibrate.
    pub(super) fn probability(&self) -> f64 {
        self.probability
    }

    /// Returns the fraction of machines without an answer.
    pub(super) fn unanswered(&self) -> f64 {
        fraction_unanswered(&self.sorted)
    }

    fn quantile(&self, probability: f64) -> f64 {
        quantile_sorted(&self.sorted, probability.clamp(0.0, 1.0))
    }

    /// Returns whether as many machines may vibrate as the fraction `probability`: a third to three times as many do, or the difference is
    /// within three standard errors of the machines that ensembles decide far from the limit.
    pub(super) fn is_near(&self, probability: f64) -> bool {
        let decided = if self.limit.is_some() { LEAST_CHANCE * self.sorted.len() as f64 } else { f64::INFINITY };
        let found = self.probability.clamp(0.0, 1.0);
        let error = (found * (1.0 - found) / decided).sqrt();
        (probability / 3.0..3.0 * probability).contains(&found) || (found - probability).abs() < 3.0 * error
    }

    /// Returns the half width of the 95 % interval of the fraction that vibrates.
    fn half_width(&self) -> f64 {
        if self.fractions.len() < REPLICATES {
            return 0.0;
        }
        half_width(&self.fractions, 0.0)
    }

    /// Returns half the width of the interval of the margin's quantile.
    pub(super) fn error(&self, probability: f64) -> f64 {
        let half_width = self.half_width();
        0.5 * (self.quantile(probability + half_width) - self.quantile(probability - half_width))
    }

    /// Returns the interval of a central value at which the fraction `probability` vibrates, given the slope of the excess.
    pub(super) fn interval(&self, value: f64, slope: f64, probability: f64) -> Interval {
        let half_width = self.half_width();
        let [low, high] = [half_width, -half_width]
            .map(|change| value - (self.quantile(probability + change) - self.quantile(probability)) / slope);
        Interval { low: low.min(high), high: low.max(high) }
    }
}

/// Returns the parts of numbers in the order of the replicates.
fn parts(numbers: &[f64]) -> impl Iterator<Item = &[f64]> {
    numbers.chunks(numbers.len().div_ceil(REPLICATES))
}

fn sorted(mut margins: Vec<f64>) -> Vec<f64> {
    margins.sort_by(f64::total_cmp);
    margins
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_margins_leave_the_distance_of_the_probabilities() {
        // Without it, a root search over central values would see zero everywhere.
        let answers = Answers::with_fluctuation(vec![0.02; 3], &[1.0, 0.0, 0.5]);
        for (probability, wanted) in [(0.75, 0.25), (0.5, 0.0), (0.05, -0.45)] {
            assert!((answers.excess(probability) - wanted).abs() < 1e-15);
        }
    }

    #[test]
    fn machines_without_an_answer_vibrate() {
        // −∞ and its differences must not read as a distance from the limit.
        let margins = [vec![f64::NEG_INFINITY; 60], (1..=140).map(f64::from).collect()].concat();
        let answers = Answers::with_constant_friction(margins.clone());
        assert_eq!((answers.unanswered(), answers.probability), (0.3, 0.3));
        for probability in [0.0, 0.05, 0.29, 59.5 / 199.0] {
            assert_eq!(answers.excess(probability), f64::NEG_INFINITY, "{probability}");
        }
        assert!((answers.excess(0.5) - 40.5).abs() < 1e-9);
        let none = Answers::with_constant_friction(vec![f64::NEG_INFINITY; 9]);
        assert_eq!(
            (none.unanswered(), none.excess(0.05), none.excess(1.0)),
            (1.0, f64::NEG_INFINITY, f64::NEG_INFINITY)
        );
        let terms = [vec![1.0; 60], vec![0.0; 140]].concat();
        let fluctuating = Answers::with_fluctuation(margins, &terms);
        assert!(fluctuating.excess(0.05) < 0.0 && fluctuating.excess(0.5) > 0.0);
    }

    #[test]
    fn the_interval_of_a_value_is_that_of_the_replicates_over_the_slope() {
        // The quantile of margins between 0 and 1 at P is P. The probabilities of eight replicates are .05 from their mean.
        let margins: Vec<f64> = (0..=1000).map(|i| f64::from(i) / 1000.0).collect();
        let answers = Answers::with_fluctuation(margins.clone(), &[0.35, 0.45].repeat(4));
        let half_width = 2.364_624_252 * 0.05 * (8.0_f64 / 7.0).sqrt() / 8.0_f64.sqrt();
        assert!((answers.excess(0.6) - 0.2).abs() < 1e-12);
        assert!((answers.error(0.4) - half_width).abs() < 1e-9, "{}", answers.error(0.4));
        for slope in [2.0, -2.0] {
            let Interval { low, high } = answers.interval(5.0, slope, 0.4);
            assert!((low - (5.0 - half_width / 2.0)).abs() < 1e-9 && (high - (5.0 + half_width / 2.0)).abs() < 1e-9);
        }
        // Fewer replicates have no interval.
        assert_eq!(Answers::with_fluctuation(margins, &[0.35, 0.45, 0.4]).error(0.4), 0.0);
    }

    #[test]
    fn three_times_or_a_third_of_a_probability_is_near_it() {
        let answers = Answers::with_constant_friction((0..100).map(|i| f64::from(i) - 4.5).collect());
        let near = [0.016, 0.02, 0.05, 0.14, 0.16].map(|probability| answers.is_near(probability));
        assert_eq!(near, [false, true, true, true, false]);
        // One machine in 32 is decided: 30 vibrating ones of 1,024 may be a single one, and 300 are none too few.
        let near = [30, 300].map(|count| {
            let terms: Vec<f64> = (0..1024).map(|index| f64::from(u8::from(index < count))).collect();
            Answers::with_fluctuation(vec![0.0; 1024], &terms).is_near(0.005)
        });
        assert_eq!(near, [true, false]);
    }
}
