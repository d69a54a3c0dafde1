//! Bands that contain the statistic of a further twin.

use crate::stats::{Interval, Moments, sorted_present, student_quantile};
use crate::study::result::BandMethod;

/// Probability of a band.
pub(super) const LEVEL: f64 = 0.95;
/// Probability below a band, and above it.
const TAIL: f64 = 0.025;
/// Fraction of the statistics expected outside by chance.
pub(super) const CHANCE_OUTSIDE: f64 = 2.0 * TAIL;
/// Number of twins from which bands end at order statistics: the lowest and the highest of 39 contain a further one
/// with probability 38/40.
const ENOUGH_FOR_QUANTILES: usize = 39;

/// Returns the method for a number of twins.
pub(super) fn band_method(count: usize) -> BandMethod {
    match count {
        0 | 1 => BandMethod::None,
        n if n < ENOUGH_FOR_QUANTILES => BandMethod::StudentT,
        _ => BandMethod::Quantiles,
    }
}

/// Scale on which values are assumed normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scale {
    /// Values vary by differences.
    Linear,
    /// Values lie above a bound a and vary by factors: the logarithm of x − a.
    Above(f64),
    /// Fractions between 0 and 1: the logarithm of x/(1 − x).
    Share,
}
use Scale::{Above, Linear, Share};

impl Scale {
    /// Maps a value onto the real line.
    fn unfold(self, value: f64) -> f64 {
        match self {
            Linear => value,
            Above(least) => (value - least).ln(),
            Share => (value / (1.0 - value)).ln(),
        }
    }

    /// Maps a number from the real line back to a value.
    fn fold(self, value: f64) -> f64 {
        match self {
            Linear => value,
            Above(least) => least + value.exp(),
            Share => 1.0 / (1.0 + (-value).exp()),
        }
    }

    /// Returns the smallest and the largest possible value, or `None` if the values leave that range, for example
    /// estimates of a spectrum below zero.
    fn range(self, sorted: &[f64]) -> Option<(f64, f64)> {
        let (least, greatest) = match self {
            Linear => return None,
            Above(least) => (least, f64::INFINITY),
            Share => (0.0, 1.0),
        };
        let kept = sorted.first().is_some_and(|x| *x >= least) && sorted.last().is_some_and(|x| *x <= greatest);
        kept.then_some((least, greatest))
    }
}

/// Mean, standard deviation and band of the defined values.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    pub(super) mean: f64,
    pub(super) std: f64,
    pub(super) band: Option<Interval>,
    pub(super) defined: usize,
}

impl Spread {
    pub(super) fn new(values: impl Iterator<Item = f64>, scale: Scale) -> Self {
        let sorted = sorted_present(values);
        let moments = Moments::new(&sorted);
        let band = match band_method(sorted.len()) {
            BandMethod::None => None,
            BandMethod::Quantiles => {
                Some(Interval { low: order_statistic(&sorted, TAIL), high: order_statistic(&sorted, 1.0 - TAIL) })
            }
            BandMethod::StudentT => {
                let unfolded: Vec<f64> = sorted.iter().map(|value| scale.unfold(*value)).collect();
                if unfolded.iter().all(|value| value.is_finite()) {
                    let band = prediction_interval(&Moments::new(&unfolded));
                    Some(Interval { low: scale.fold(band.low), high: scale.fold(band.high) })
                } else {
                    // A fraction of exactly one, or a peak height of zero: use the original scale and clip the band to
                    // the range.
                    let band = prediction_interval(&moments);
                    let (least, greatest) = scale.range(&sorted).unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
                    Some(Interval { low: band.low.max(least), high: band.high.min(greatest) })
                }
            }
        };
        Self { mean: moments.mean, std: moments.sample_std(), band, defined: sorted.len() }
    }
}

/// Returns the value at the rank p(n + 1) of sorted values, linear between ranks. A further value of the same
/// distribution lies below it with probability p, on average over samples (type 6 of Hyndman & Fan 1996,
/// <https://doi.org/10.1080/00031305.1996.10473566>).
fn order_statistic(sorted: &[f64], probability: f64) -> f64 {
    let n = sorted.len();
    let rank = (probability * (n as f64 + 1.0)).clamp(1.0, n as f64);
    let left = rank.floor() as usize;
    let right = (left + 1).min(n);
    sorted[left - 1] + (rank - left as f64) * (sorted[right - 1] - sorted[left - 1])
}

/// Returns the interval that contains a further value with probability 95 % if all are normal: m ± t s √(1 + 1/n).
fn prediction_interval(moments: &Moments) -> Interval {
    let n = moments.n as f64;
    let half = student_quantile(1.0 - TAIL, n - 1.0) * moments.sample_std() * (1.0 + 1.0 / n).sqrt();
    Interval { low: moments.mean - half, high: moments.mean + half }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_band_leaves_the_range_of_its_statistic() {
        let band = |values: &[f64], scale| Spread::new(values.iter().copied(), scale).band.unwrap();
        // As wide as two values allow: t(1) = 12.7.
        for values in [[0.1, 0.9], [0.999, 0.2], [1e-9, 0.5]] {
            let share = band(&values, Share);
            assert!(share.low > 0.0 && share.low < values[0].min(values[1]), "{share:?}");
            assert!(share.high <= 1.0 && share.high > values[0].max(values[1]), "{share:?}");
            assert!(band(&values, Above(0.0)).low > 0.0);
        }
        assert!(band(&[1.5, 3.0], Above(1.0)).low > 1.0, "a kurtosis");
        // Log-odds of one, and the logarithm of zero, are infinite.
        let one = band(&[0.2, 0.3, 1.0], Share);
        assert_eq!((one.low, one.high), (0.0, 1.0));
        let none = band(&[0.0, 0.1, 0.2], Above(0.0));
        assert!(none.low == 0.0 && none.high > 0.2, "{none:?}");
        // An estimate of a spectrum may be negative, and so may its band.
        assert!(band(&[-0.1, 0.1, 0.2], Above(0.0)).low < -0.1);
    }

    #[test]
    fn bands_are_order_statistics_of_many_and_students_of_few() {
        let spread = |n: usize| Spread::new((0..n).map(|i| ((7 * i) % n) as f64), Linear);
        // 2.5 % of 40 is the first of 39, of 80 the second of 79.
        assert_eq!(spread(39).band, Some(Interval { low: 0.0, high: 38.0 }));
        assert_eq!(spread(79).band, Some(Interval { low: 1.0, high: 77.0 }));
        let few = Spread::new([1.0, 2.0, f64::NAN, 3.0].into_iter(), Linear);
        // t(2) · 1 · √(4/3) about 2.
        let half = 4.302_652_73 * (4.0_f64 / 3.0).sqrt();
        let band = few.band.unwrap();
        assert!((band.low - 2.0 + half).abs() < 1e-6 && (band.high - 2.0 - half).abs() < 1e-6 && few.defined == 3);
        let factors = Spread::new([1.0, std::f64::consts::E].into_iter(), Above(0.0)).band.unwrap();
        assert!((factors.low * factors.high / std::f64::consts::E - 1.0).abs() < 1e-12, "symmetric about √e");
        let shares = Spread::new([0.2, 0.3, 0.8].into_iter(), Share).band.unwrap();
        assert!(shares.low > 0.0 && shares.high < 1.0, "{shares:?}");
        assert_eq!(Spread::new([1.0].into_iter(), Linear).band, None);
        assert!(Spread::new(std::iter::empty(), Linear).mean.is_nan());
    }
}
