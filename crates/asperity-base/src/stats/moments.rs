//! Moments of a sample.

use super::blocks::{self, LANES};

/// Moments of the values of a sample without NaN. Without values all but `n` are NaN; for equal values the standard
/// deviation is 0 and skewness and kurtosis are NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Values present.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Standard deviation with divisor n, the root mean square about the mean as for Sq. See [`Moments::sample_std`].
    pub std: f64,
    /// Skewness m₃/m₂^{3/2} with central moments of divisor n.
    pub skewness: f64,
    /// Excess kurtosis m₄/m₂² − 3 with central moments of divisor n.
    pub excess_kurtosis: f64,
}

/// Number, mean and range of the values of a sample without NaN. Without values all but `n` are NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Values present.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub largest: f64,
}

impl Extent {
    /// Creates the extent of a sample, with the mean of the differences from the first value.
    pub fn new(values: &[f64]) -> Self {
        let Some(origin) = values.iter().copied().find(|v| !v.is_nan()) else {
            return Self { n: 0, mean: f64::NAN, least: f64::NAN, largest: f64::NAN };
        };
        let blocks = blocks::map(values, |block| {
            let (mut sums, mut counts) = ([0.0; LANES], [0.0; LANES]);
            let (mut least, mut largest) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
            let mut take = |lane: usize, value: f64| {
                sums[lane] += if value.is_nan() { 0.0 } else { value - origin };
                counts[lane] += if value.is_nan() { 0.0 } else { 1.0 };
                least[lane] = if value < least[lane] { value } else { least[lane] };
                largest[lane] = if value > largest[lane] { value } else { largest[lane] };
            };
            let (chunks, rest) = block.as_chunks::<LANES>();
            chunks.iter().for_each(|chunk| chunk.iter().enumerate().for_each(|(lane, value)| take(lane, *value)));
            rest.iter().for_each(|value| take(0, *value));
            let least = least.into_iter().fold(f64::INFINITY, f64::min);
            let largest = largest.into_iter().fold(f64::NEG_INFINITY, f64::max);
            (sums.iter().sum::<f64>(), counts.iter().sum::<f64>(), least, largest)
        });
        let (mut sum, mut count, mut least, mut largest) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        for block in blocks {
            (sum, count) = (sum + block.0, count + block.1);
            (least, largest) = (least.min(block.2), largest.max(block.3));
        }
        Self { n: count as usize, mean: origin + sum / count, least, largest }
    }

    /// Returns the largest distance of a value from the mean.
    pub fn largest_deviation(&self) -> f64 {
        f64::max(self.largest - self.mean, self.mean - self.least)
    }
}

impl Moments {
    /// Creates the moments of a slice; NaN is skipped.
    ///
    /// Two passes: the mean of the differences from the first value, then powers of the deviations, scaled by the
    /// largest to preserve accuracy for nanometres and for large offsets.
    pub fn new(values: &[f64]) -> Self {
        Self::with_extent(&Extent::new(values), values)
    }

    /// Creates the moments of a slice with a known extent.
    #[doc(hidden)]
    pub fn with_extent(extent: &Extent, values: &[f64]) -> Self {
        Self::with_absolute(extent, values).0
    }

    /// Returns the moments of a slice with a known extent, and its mean absolute deviation.
    #[doc(hidden)]
    pub fn with_absolute(extent: &Extent, values: &[f64]) -> (Self, f64) {
        let Extent { n, mean, least, largest } = *extent;
        let scale = extent.largest_deviation();
        if n == 0 || least == largest || scale == 0.0 {
            let std = if n == 0 { f64::NAN } else { 0.0 };
            return (Self { n, mean, std, skewness: f64::NAN, excess_kurtosis: f64::NAN }, std);
        }
        let sums = blocks::sums(values, |value| {
            let deviation = if value.is_nan() { 0.0 } else { (value - mean) / scale };
            let square = deviation * deviation;
            [deviation, square, square * deviation, square * square, deviation.abs()]
        });
        // Correct the higher moments for the rounding error of the mean.
        let [rest, second, third, fourth, absolute] = sums.map(|sum| sum / n as f64);
        let m2 = second - rest * rest;
        let m3 = third - 3.0 * rest * second + 2.0 * rest.powi(3);
        let m4 = fourth - 4.0 * rest * third + 6.0 * rest * rest * second - 3.0 * rest.powi(4);
        let moments = Self {
            n,
            mean: mean + scale * rest,
            std: scale * m2.sqrt(),
            skewness: m3 / m2.powf(1.5),
            excess_kurtosis: m4 / (m2 * m2) - 3.0,
        };
        (moments, scale * absolute)
    }

    /// Creates the moments of an iterator of values; NaN is skipped.
    pub fn from_values(values: impl Iterator<Item = f64>) -> Self {
        Self::new(&values.collect::<Vec<f64>>())
    }

    /// Returns the standard deviation with divisor n − 1, whose square is unbiased for independent values; NaN for a
    /// single value.
    pub fn sample_std(&self) -> f64 {
        if self.n < 2 { f64::NAN } else { self.std * (self.n as f64 / (self.n as f64 - 1.0)).sqrt() }
    }

    /// Returns the standard error of the mean of *independent* values, sample_std/√n.
    pub fn standard_error(&self) -> f64 {
        self.sample_std() / (self.n as f64).sqrt()
    }

    /// Returns the coefficient of variation, standard deviation over |mean|.
    pub fn coefficient_of_variation(&self) -> f64 {
        self.std / self.mean.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_four_values_by_hand() {
        // Deviations of 1, 2, 3, 6 from 3: −2, −1, 0, 3; m₂ = 14/4, m₃ = 18/4, m₄ = 98/4.
        let m = Moments::new(&[1.0, f64::NAN, 2.0, 3.0, 6.0]);
        assert_eq!((m.n, m.mean), (4, 3.0));
        assert!((m.std - 3.5_f64.sqrt()).abs() < 1e-15);
        assert!((m.sample_std() - (14.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert!((m.skewness - 4.5 / 3.5_f64.powf(1.5)).abs() < 1e-15);
        assert!((m.excess_kurtosis - (24.5 / 12.25 - 3.0)).abs() < 1e-15);
    }

    #[test]
    fn nanometres_on_a_large_offset_are_accurate() {
        // Multiples of 2⁻³⁰ m on 1 m are exact in binary, so the offset causes no error except the rounding of the
        // mean.
        let unit = 2.0_f64.powi(-30);
        let values: Vec<f64> = [1.0, 2.0, 3.0, 6.0].iter().map(|v| 1.0 + v * unit).collect();
        let (shifted, plain) = (Moments::new(&values), Moments::new(&[1.0, 2.0, 3.0, 6.0]));
        assert!((shifted.std / unit / plain.std - 1.0).abs() < 1e-12);
        assert!((shifted.skewness - plain.skewness).abs() < 1e-7 * plain.skewness);
        let tiny = Moments::new(&[1e-200, 2e-200, 3e-200, 6e-200]);
        assert!((tiny.excess_kurtosis - plain.excess_kurtosis).abs() < 1e-13);
    }

    #[test]
    fn no_values_and_equal_values_are_not_given_a_shape() {
        assert!(Moments::new(&[f64::NAN]).mean.is_nan());
        let equal = Moments::new(&[0.1; 7]);
        assert_eq!((equal.mean, equal.std), (0.1, 0.0));
        assert!(equal.skewness.is_nan() && equal.excess_kurtosis.is_nan());
        assert!(Moments::new(&[1.0]).sample_std().is_nan());
    }
}
