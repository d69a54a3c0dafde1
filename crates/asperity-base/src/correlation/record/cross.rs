//! Cross-correlation of two records, such as contact area and load of sliding windows.

use super::checked_moments;
use crate::correlation::estimate::EstimateError;
use crate::stats::{Interval, Moments, correlation_time, jackknife_reach};

/// Number of jackknife blocks.
const PIECES: usize = 20;
/// Least length of a block in integrated correlation times.
const SHORTEST_PIECE: f64 = 5.0;

/// Cross-correlation of two quantities along the same records.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossCorrelation {
    /// Distance between values in metre.
    pub step_m: f64,
    /// Lags in steps, from −largest to largest, by which the second quantity is ahead of the first.
    pub lags: Vec<isize>,
    /// Correlation at the lags over the pairs present; NaN without a pair.
    pub correlation: Vec<f64>,
    /// Correlation at lag 0.
    pub coefficient: f64,
    /// 95 % interval of it by a block jackknife of the records on Fisher's scale artanh ρ, with Student's quantile;
    /// [−1, 1] for a single block.
    pub interval: Interval,
    /// Number of blocks.
    pub pieces: usize,
}

/// Returns the cross-correlation of pairs of records up to `largest_lag` steps about their common means, with `tracks`
/// records per strip; NaN is a missing value.
///
/// # Errors
/// A step that is not positive, fewer than four pairs, or a quantity that does not vary.
pub fn cross_correlation(
    records: &[(&[f64], &[f64])],
    tracks: usize,
    step_m: f64,
    largest_lag: usize,
) -> Result<CrossCorrelation, EstimateError> {
    let first = checked_moments(records.iter().flat_map(|pair| pair.0.iter().copied()), step_m, 4)?;
    let second = checked_moments(records.iter().flat_map(|pair| pair.1.iter().copied()), step_m, 4)?;
    let longest = records.iter().map(|pair| pair.0.len()).max().unwrap_or(0);
    let reach = largest_lag.min(longest - 1) as isize;
    let lags: Vec<isize> = (-reach..=reach).collect();
    let scale = first.std * second.std;
    let at = |lag: &isize| {
        let (mut sum, mut count) = (0.0, 0.0);
        for (a, b) in records {
            let start = (-lag).max(0);
            let end = (a.len() as isize).min(b.len() as isize - lag);
            for i in start..end {
                let product = (a[i as usize] - first.mean) * (b[(i + lag) as usize] - second.mean);
                if product.is_finite() {
                    (sum, count) = (sum + product, count + 1.0);
                }
            }
        }
        if count > 0.0 { sum / count / scale } else { f64::NAN }
    };
    let correlation: Vec<f64> = lags.iter().map(at).collect();
    let pieces = pieces(records, tracks);
    let total = pieces.iter().fold(Sums::default(), |sum, piece| sum.plus(piece, 1.0));
    let coefficient = total.correlation();
    let count = pieces.len();
    let left_out: Vec<f64> = pieces.iter().map(|piece| total.plus(piece, -1.0).correlation().atanh()).collect();
    let half = jackknife_reach(&left_out);
    let interval = if half.is_finite() {
        Interval { low: (coefficient.atanh() - half).tanh(), high: (coefficient.atanh() + half).tanh() }
    } else if coefficient.abs() >= 1.0 {
        Interval { low: coefficient, high: coefficient }
    } else {
        Interval { low: -1.0, high: 1.0 }
    };
    Ok(CrossCorrelation { step_m, lags, correlation, coefficient, interval, pieces: count })
}

/// Sums of two quantities and of their products.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    n: f64,
    a: f64,
    b: f64,
    aa: f64,
    bb: f64,
    ab: f64,
}

impl Sums {
    fn plus(&self, other: &Self, sign: f64) -> Self {
        Self {
            n: self.n + sign * other.n,
            a: self.a + sign * other.a,
            b: self.b + sign * other.b,
            aa: self.aa + sign * other.aa,
            bb: self.bb + sign * other.bb,
            ab: self.ab + sign * other.ab,
        }
    }

    fn correlation(&self) -> f64 {
        let covariance = |product: f64, a: f64, b: f64| product / self.n - a * b / (self.n * self.n);
        let variances = covariance(self.aa, self.a, self.a) * covariance(self.bb, self.b, self.b);
        (covariance(self.ab, self.a, self.b) / variances.sqrt()).clamp(-1.0, 1.0)
    }
}

/// Returns about twenty blocks, whole strips if there are as many, each of a least number of correlation times. Both
/// quantities are centred and divided by their standard deviations.
fn pieces(records: &[(&[f64], &[f64])], tracks: usize) -> Vec<Sums> {
    let first = Moments::from_values(records.iter().flat_map(|pair| pair.0.iter().copied()));
    let second = Moments::from_values(records.iter().flat_map(|pair| pair.1.iter().copied()));
    let time = |values: &[f64]| correlation_time(values).map_or(1.0, |time| time.steps);
    let longest = records.iter().map(|pair| time(pair.0).max(time(pair.1))).fold(1.0, f64::max);
    let wanted = PIECES.div_ceil(records.len().div_ceil(tracks).max(1));
    let mut pieces = Vec::new();
    for strip in records.chunks(tracks) {
        let parts = wanted.min((strip[0].0.len() as f64 / (SHORTEST_PIECE * longest)) as usize).max(1);
        for part in 0..parts {
            let mut sums = Sums::default();
            for (a, b) in strip {
                for i in part * a.len() / parts..(part + 1) * a.len() / parts {
                    let x = (a[i] - first.mean) / first.std;
                    let y = b.get(i).map_or(f64::NAN, |b| (b - second.mean) / second.std);
                    if x.is_finite() && y.is_finite() {
                        sums = sums.plus(&Sums { n: 1.0, a: x, b: y, aa: x * x, bb: y * y, ab: x * y }, 1.0);
                    }
                }
            }
            if sums.n > 0.0 {
                pieces.push(sums);
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    /// Two processes with correlation φ^lag and cross-correlation ρ, the second delayed by `shift` steps.
    fn pair(rho: f64, shift: usize, n: usize, index: u64) -> (Vec<f64>, Vec<f64>) {
        let mut stream = random::stream(49, "cross", index);
        let mut draw = || {
            let noise = random::standard_normal(&mut stream, n + shift);
            let mut last = noise[0];
            let next = |e: &f64| {
                last = 0.9 * last + (1.0_f64 - 0.81).sqrt() * e;
                last
            };
            noise.iter().map(next).collect::<Vec<f64>>()
        };
        let (common, own) = (draw(), draw());
        let second = (0..n).map(|i| rho * common[i] + (1.0 - rho * rho).sqrt() * own[i]).collect();
        (common[shift..].to_vec(), second)
    }

    #[test]
    fn the_cross_correlation_peaks_at_the_delay() {
        let (a, b) = pair(0.9, 7, 4000, 0);
        let found = cross_correlation(&[(&a, &b)], 1, 1.0, 20).unwrap();
        let top = (0..41).max_by(|i, j| found.correlation[*i].total_cmp(&found.correlation[*j])).unwrap();
        assert_eq!(found.lags[top], 7);
        assert!((found.correlation[20] - found.coefficient).abs() < 1e-12);
    }

    #[test]
    fn intervals_cover_the_true_coefficient() {
        for (rho, records, n) in [(0.95, 1, 4000), (0.0, 3, 1300), (0.5, 20, 200)] {
            let mut hits = 0;
            for run in 0..100 {
                let drawn: Vec<_> = (0..records).map(|r| pair(rho, 0, n, 1 + run * records + r)).collect();
                let views: Vec<(&[f64], &[f64])> = drawn.iter().map(|(a, b)| (a.as_slice(), b.as_slice())).collect();
                let found = cross_correlation(&views, 1, 1.0, 0).unwrap();
                hits += usize::from(found.interval.contains(rho));
            }
            // Coverage 95 ± 2.2 of 100: four standard errors.
            assert!(hits >= 87, "ρ = {rho}: {hits} of 100");
        }
    }

    #[test]
    fn quantities_in_proportion_correlate_fully_and_constants_not_at_all() {
        let (a, _) = pair(0.0, 0, 500, 999);
        let b: Vec<f64> = a.iter().map(|value| 3.0 - 2.0 * value).collect();
        let found = cross_correlation(&[(&a, &b)], 1, 1.0, 0).unwrap();
        assert!((found.coefficient + 1.0).abs() < 1e-12);
        assert!(cross_correlation(&[(&a, &[1.0; 500])], 1, 1.0, 0).is_err());
    }
}
