//! Histograms normalised as densities.

use super::{StatsError, quantile_sorted, sorted_present};

/// Largest number of bins.
const MAX_BINS: usize = 512;

/// Counts of values in bins of equal width.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// Bin edges, one more than bins, ascending.
    pub edges: Vec<f64>,
    /// Values in each bin; the last bin includes its upper edge.
    pub counts: Vec<usize>,
}

impl Histogram {
    /// Creates the histogram of the present values with the bin width of Freedman and Diaconis, 2·IQR·n^{−1/3}, and at
    /// most 512 bins. If half of all values are equal (IQR = 0), the width is Scott's 3.49·std·n^{−1/3}.
    ///
    /// # References
    /// Freedman & Diaconis, *Z. Wahrscheinlichkeitstheorie* **57** (1981) 453, <https://doi.org/10.1007/BF01025868>.
    ///
    /// # Errors
    /// No value present, or all equal.
    pub fn new(values: &[f64]) -> Result<Self, StatsError> {
        let sorted = sorted_present(values.iter().copied());
        let (first, last) = ends(&sorted)?;
        let quartile_range = quantile_sorted(&sorted, 0.75) - quantile_sorted(&sorted, 0.25);
        let spread = if quartile_range > 0.0 { 2.0 * quartile_range } else { 3.49 * super::Moments::new(&sorted).std };
        let width = spread / (sorted.len() as f64).cbrt();
        let bins = ((last - first) / width).ceil().clamp(1.0, MAX_BINS as f64) as usize;
        Self::from_sorted(&sorted, bins)
    }

    fn from_sorted(sorted: &[f64], bins: usize) -> Result<Self, StatsError> {
        let (first, last) = ends(sorted)?;
        let edge = |i: usize| if i == bins { last } else { first + (last - first) * (i as f64 / bins as f64) };
        let edges: Vec<f64> = (0..=bins).map(edge).collect();
        let below = |edge: f64| sorted.partition_point(|v| *v < edge);
        let counts = (0..bins)
            .map(|i| if i + 1 == bins { sorted.len() } else { below(edges[i + 1]) } - below(edges[i]))
            .collect();
        Ok(Self { edges, counts })
    }

    /// Returns the density of each bin: fraction of the values over the bin width; its integral is one.
    pub fn density(&self) -> Vec<f64> {
        let total = self.counts.iter().sum::<usize>() as f64;
        let widths = self.edges.windows(2).map(|pair| pair[1] - pair[0]);
        self.counts.iter().zip(widths).map(|(count, width)| *count as f64 / (total * width)).collect()
    }

    /// Returns the bin centres.
    pub fn centres(&self) -> Vec<f64> {
        self.edges.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
    }
}

fn ends(sorted: &[f64]) -> Result<(f64, f64), StatsError> {
    match (sorted.first(), sorted.last()) {
        (Some(first), Some(last)) if first < last => Ok((*first, *last)),
        (None, _) | (_, None) => Err(StatsError::TooFew { statistic: "a histogram", n: 0, wanted: 2 }),
        _ => Err(StatsError::Constant { statistic: "a histogram", n: sorted.len() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    #[test]
    fn every_value_falls_in_one_bin_and_the_density_integrates_to_one() {
        let values = random::standard_normal(&mut random::stream(3, "histogram", 0), 5000);
        let histogram = Histogram::new(&values).unwrap();
        assert_eq!(histogram.counts.iter().sum::<usize>(), 5000);
        let width = histogram.edges[1] - histogram.edges[0];
        // The IQR of the standard normal distribution is 1.349; the standard error of its quartiles is about 1.36/√n.
        assert!((width - 2.0 * 1.349 / 5000_f64.cbrt()).abs() < 0.01, "width {width}");
        let integral: f64 = histogram.density().iter().map(|d| d * width).sum();
        assert!((integral - 1.0).abs() < 1e-12);
    }

    #[test]
    fn bins_include_their_lower_edge_and_the_last_bin_both() {
        let histogram = Histogram::from_sorted(&[0.0, 1.0, 2.0, 4.0], 4).unwrap();
        assert_eq!(histogram.counts, [1, 1, 1, 1]);
        assert_eq!(histogram.centres(), [0.5, 1.5, 2.5, 3.5]);
        assert!(Histogram::new(&[1.0, 1.0]).is_err());
        assert!(Histogram::new(&[f64::NAN]).is_err());
        // Many ties: the interquartile range is 0, and a distant outlier must not cause too many bins.
        let mut ties = vec![0.0; 1000];
        ties.extend([1.0, 1e9]);
        assert!(Histogram::new(&ties).unwrap().counts.len() <= MAX_BINS);
    }
}
