//! Standard errors and confidence bands of distribution functions.

use ndarray::Array2;

use asperity_base::numeric::symmetric_eigen;
use asperity_base::random;
use asperity_base::stats::{Interval, NORMAL_95, student_95, student_quantile, wilson_interval};
use asperity_chaos::DiscreteDistribution;

/// Minimum number of samples on either side of a value for normal errors of its fraction.
pub(super) const RARE: usize = 15;
/// Number of draws from which the critical value of a simultaneous band is estimated.
const DRAWS: usize = 4000;
const GROUP_DRAWS: usize = 1000;
/// Degrees of freedom from which errors are treated as normal, and the smallest number used.
const MANY: f64 = 1000.0;
const LEAST_DEGREES: f64 = 3.0;
/// Number of values on either side whose errors contribute to the error of a value.
const NEIGHBOURS: usize = 2;
/// Larger steps of a distribution function between neighbouring values count as point masses.
const POINT_MASS: f64 = 0.02;

/// Estimated distribution function with 95 % bands at some values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Band {
    /// Values in increasing order.
    pub values: Vec<f64>,
    /// Estimate of F at each value; not necessarily monotone or between 0 and 1.
    pub cdf: Vec<f64>,
    /// Bias of the estimate, computed from samples that were not used for the fit; 0 for an unbiased estimate.
    pub bias: Vec<f64>,
    /// Standard errors of the estimate without its bias.
    pub standard_errors: Vec<f64>,
    /// Factor on the standard error for 95 % coverage of F at one value.
    pub pointwise_factor: f64,
    /// Factor on the standard error for 95 % coverage of F at all values simultaneously.
    pub simultaneous_factor: f64,
}

impl Band {
    /// Creates the band for normal errors with the given covariance (row-major).
    ///
    /// If `degrees_of_freedom` is given, the covariance was estimated with few degrees of freedom, and the factors are
    /// those of Student's distribution.
    pub(super) fn new(
        values: &[f64],
        cdf: &[f64],
        covariance: &[f64],
        degrees_of_freedom: Option<usize>,
        seed: u64,
    ) -> Self {
        let n = values.len();
        let standard_errors: Vec<f64> = (0..n).map(|i| covariance[i * n + i].max(0.0).sqrt()).collect();
        let pointwise_factor = degrees_of_freedom.map_or(NORMAL_95, |degrees| student_95(degrees + 1));
        let simultaneous_factor = match degrees_of_freedom {
            _ if standard_errors.iter().all(|se| *se <= 0.0) => pointwise_factor,
            Some(degrees) => {
                critical_value_of_groups(standard_errors.iter().filter(|se| **se > 0.0).count(), degrees, seed)
            }
            None => critical_value(&standard_errors, covariance, seed),
        };
        let simultaneous_factor = simultaneous_factor.max(pointwise_factor);
        let bias = vec![0.0; n];
        Self {
            values: values.to_vec(),
            cdf: cdf.to_vec(),
            bias,
            standard_errors,
            pointwise_factor,
            simultaneous_factor,
        }
    }

    /// Returns the band of another estimate `cdf`, whose bias is its difference from this unbiased one.
    pub(super) fn with_estimate(self, cdf: Vec<f64>) -> Self {
        let bias = cdf.iter().zip(&self.cdf).map(|(biased, unbiased)| biased - unbiased).collect();
        Self { cdf, bias, ..self }
    }

    /// Creates the band of the empirical distribution function of `samples` independent values, where F̂ at `values` is
    /// `cdf`.
    ///
    /// # References
    /// A. Agresti and B. A. Coull, *Am. Stat.* **52** (1998) 119, <https://doi.org/10.1080/00031305.1998.10480550>.
    pub(super) fn from_independent(values: &[f64], cdf: &[f64], samples: usize, seed: u64) -> Self {
        let covariance = |i: usize, j: usize| cdf[i.min(j)] * (1.0 - cdf[i.max(j)]) / samples as f64;
        let n = values.len();
        let covariance: Vec<f64> = (0..n * n).map(|k| covariance(k / n, k % n)).collect();
        let band = Self::new(values, cdf, &covariance, None, seed);
        // Two samples of either kind are added (Agresti and Coull), because a small count underestimates its own
        // variance.
        let count = samples as f64;
        let more = |f: &f64| (count * f + 2.0) / (count + 4.0);
        let standard_error = |f: &f64| (more(f) * (1.0 - more(f)) / count).sqrt();
        Self { standard_errors: cdf.iter().map(standard_error).collect(), ..band }
    }

    /// Widens the band at the first value to Wilson's interval if few samples lie on one side of it.
    ///
    /// `above` of `samples` lie above the first value.
    pub(super) fn widened(mut self, [above, samples]: [usize; 2]) -> Self {
        if let Some(first) = self.standard_errors.first_mut().filter(|_| above.min(samples - above) < RARE) {
            let wilson = wilson_interval(above, samples);
            *first = first.max(0.5 * (wilson.high - wilson.low) / self.pointwise_factor);
        }
        self
    }

    /// Returns the 95 % interval of F at value number `i`.
    pub fn pointwise(&self, i: usize) -> [f64; 2] {
        self.around(i, self.pointwise_factor)
    }

    /// Returns the 95 % simultaneous band of F at value number `i`.
    pub fn simultaneous(&self, i: usize) -> [f64; 2] {
        self.around(i, self.simultaneous_factor)
    }

    fn around(&self, i: usize, factor: f64) -> [f64; 2] {
        let (unbiased, half) = (self.cdf[i] - self.bias[i], factor * self.standard_errors[i]);
        [(unbiased - half).clamp(0.0, 1.0), (unbiased + half).clamp(0.0, 1.0)]
    }

    /// Returns the standard error of F at any value, interpolated linearly.
    pub fn standard_error_at(&self, value: f64) -> f64 {
        self.interpolated(&self.standard_errors, value).unwrap_or(f64::INFINITY)
    }

    /// Returns the bias of F at any value, interpolated linearly.
    pub fn bias_at(&self, value: f64) -> f64 {
        self.interpolated(&self.bias, value).unwrap_or(0.0)
    }

    fn interpolated(&self, known: &[f64], value: f64) -> Option<f64> {
        let after = self.values.partition_point(|v| *v <= value);
        let (Some(low), Some(high)) = (after.checked_sub(1), self.values.get(after)) else {
            return [known.first(), known.last()][usize::from(after > 0)].copied();
        };
        let fraction = (value - self.values[low]) / (high - self.values[low]);
        Some(known[low] + fraction * (known[after] - known[low]))
    }
}

/// Quantile with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuantileResult {
    /// Probability.
    pub probability: f64,
    /// Smallest value at which F reaches the probability.
    pub value: f64,
    /// Values at which the pointwise limits of F reach the probability. For a biased estimate the interval may not
    /// contain the value.
    pub interval: Interval,
}

impl Band {
    /// Returns a quantile of `distribution`, to which this band belongs.
    pub fn quantile(&self, distribution: &DiscreteDistribution, probability: f64) -> QuantileResult {
        let limit = |value: f64, factor: f64| {
            distribution.cdf(value) - self.bias_at(value) + factor * self.standard_error_at(value)
        };
        let mut values: Vec<f64> = distribution.values().iter().chain(&self.values).copied().collect();
        values.sort_by(f64::total_cmp);
        let at = |factor: f64| {
            let Some(place) = values.iter().position(|value| limit(*value, factor) >= probability) else {
                return values.last().copied().unwrap_or(f64::NAN);
            };
            let Some(before) = place.checked_sub(1).map(|before| values[before]) else { return values[place] };
            // The limit is linear between values, except at a point mass.
            let [low, high] = [before, values[place]].map(|value| limit(value, factor));
            let fraction = if high - low < POINT_MASS { (probability - low) / (high - low) } else { 1.0 };
            before + fraction * (values[place] - before)
        };
        let factor = self.pointwise_factor;
        let interval = Interval { low: at(factor), high: at(-factor) };
        QuantileResult { probability, value: distribution.quantile(probability), interval }
    }
}

/// Returns the 95 % quantile of the largest |Z_i|/σ_i of normal Z with the given covariance.
fn critical_value(standard_errors: &[f64], covariance: &[f64], seed: u64) -> f64 {
    let n = standard_errors.len();
    let used: Vec<usize> = (0..n).filter(|i| standard_errors[*i] > 0.0).collect();
    let correlation = Array2::from_shape_fn((used.len(), used.len()), |(a, b)| {
        let (i, j) = (used[a], used[b]);
        covariance[i * n + j] / (standard_errors[i] * standard_errors[j])
    });
    let Some(z) = draws(correlation, DRAWS, seed) else { return f64::INFINITY };
    quantile_95((0..DRAWS).map(|draw| (0..used.len()).map(|a| z[[draw, a]].abs()).fold(0.0, f64::max)))
}

/// Returns the critical value for means of few vectors, each divided by the standard error estimated from these
/// vectors.
///
/// It is Student's factor for several values at once. Few vectors do not determine the correlation of errors at
/// different values, and stratified designs remove most of their common part, so the errors are treated as independent.
fn critical_value_of_groups(values: usize, degrees_of_freedom: usize, seed: u64) -> f64 {
    if degrees_of_freedom == 0 {
        return f64::INFINITY;
    }
    let groups = degrees_of_freedom + 1;
    let xi = random::standard_normal(&mut random::stream(seed, "pressure/band", 0), values * GROUP_DRAWS * groups);
    let ratios = xi.chunks_exact(groups).map(|own| {
        let mean = own.iter().sum::<f64>() / groups as f64;
        let squares: f64 = own.iter().map(|z| (z - mean).powi(2)).sum();
        mean.abs() / (squares / (groups * degrees_of_freedom) as f64).sqrt()
    });
    let ratios: Vec<f64> = ratios.collect();
    quantile_95(ratios.chunks_exact(values.max(1)).map(|own| own.iter().copied().fold(0.0, f64::max)))
}

/// Draws normal vectors with the given correlation, as rows.
fn draws(correlation: Array2<f64>, count: usize, seed: u64) -> Option<Array2<f64>> {
    let n = correlation.nrows();
    let eigen = symmetric_eigen(correlation).ok()?;
    // The symmetric root U √Λ Uᵀ does not depend on the signs of the vectors; rounding leaves some eigenvalues below zero.
    let roots = Array2::from_shape_fn((n, n), |(k, a)| eigen.values[k].max(0.0).sqrt() * eigen.vectors[[k, a]]);
    let xi = random::standard_normal(&mut random::stream(seed, "pressure/band", 0), n * count);
    Some(Array2::from_shape_vec((count, n), xi).ok()?.dot(&eigen.vectors.t().dot(&roots)))
}

fn quantile_95(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() * 95 / 100]
}

/// Returns the square root of a variance, widened for the uncertainty of the variance itself.
fn widened(variance: f64, uncertainty: f64) -> f64 {
    let degrees = 2.0 * variance * variance / uncertainty;
    let factor = if degrees < MANY { student_quantile(0.975, degrees.max(LEAST_DEGREES)) / NORMAL_95 } else { 1.0 };
    factor * variance.sqrt()
}

/// Sums and products of vectors of equal length.
#[derive(Debug, Clone)]
pub(super) struct Moments {
    count: f64,
    sums: Vec<f64>,
    /// Products of each pair (i, j ≤ i), row by row.
    products: Vec<f64>,
    /// Sums of third and fourth powers.
    powers: Vec<[f64; 2]>,
}

impl Moments {
    pub(super) fn new(length: usize) -> Self {
        let products = vec![0.0; length * (length + 1) / 2];
        Self { count: 0.0, sums: vec![0.0; length], products, powers: vec![[0.0; 2]; length] }
    }

    pub(super) fn add(&mut self, values: &[f64]) {
        self.count += 1.0;
        let mut row = 0;
        for (i, value) in values.iter().enumerate() {
            self.sums[i] += value;
            self.powers[i][0] += value * value * value;
            self.powers[i][1] += (value * value).powi(2);
            for (product, other) in self.products[row..=row + i].iter_mut().zip(values) {
                *product += value * other;
            }
            row += i + 1;
        }
    }

    /// Returns the variance of the sum of squared deviations of each component, Σ (d² − σ²)².
    fn of_squares(&self) -> impl Iterator<Item = f64> {
        let n = self.count;
        self.sums.iter().zip(&self.powers).enumerate().map(move |(i, (sum, [third, fourth]))| {
            let (mean, square) = (sum / n, self.products[i * (i + 1) / 2 + i]);
            let about = fourth - 4.0 * mean * third + 6.0 * mean * mean * square - 3.0 * n * mean.powi(4);
            let variance = square / n - mean * mean;
            (about - n * variance * variance).max(0.0)
        })
    }

    /// Returns the variance of each component.
    pub(super) fn variances(&self) -> impl Iterator<Item = f64> {
        (0..self.sums.len())
            .scan(0, |place, i| {
                *place += i + 1;
                Some(*place - 1)
            })
            .zip(&self.sums)
            .map(|(place, sum)| (self.products[place] - sum * sum / self.count) / (self.count - 1.0))
    }

    /// Returns the covariance of the vectors, pair by pair; zero for fewer than two vectors.
    fn covariances(&self) -> impl Iterator<Item = f64> {
        let pairs = (0..self.sums.len()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let scale = if self.count > 1.0 { 1.0 / (self.count - 1.0) } else { 0.0 };
        pairs
            .zip(&self.products)
            .map(move |((i, j), product)| scale * (product - self.sums[i] * self.sums[j] / self.count))
    }
}

/// Sum of independent estimates with the covariance of its errors.
#[derive(Debug, Clone)]
pub(super) struct Total {
    values: Vec<f64>,
    /// Covariance of each pair (i, j ≤ i), row by row.
    covariances: Vec<f64>,
    /// Variances of the variances.
    uncertainties: Vec<f64>,
}

impl Total {
    pub(super) fn new(length: usize) -> Self {
        let covariances = vec![0.0; length * (length + 1) / 2];
        Self { values: vec![0.0; length], covariances, uncertainties: vec![0.0; length] }
    }

    /// Adds the sum of independent vectors.
    pub(super) fn add_sum(&mut self, vectors: &Moments) {
        if vectors.count > 0.0 {
            self.values.iter_mut().zip(&vectors.sums).for_each(|(value, sum)| *value += sum);
            self.covariances.iter_mut().zip(vectors.covariances()).for_each(|(own, c)| *own += vectors.count * c);
            self.uncertainties.iter_mut().zip(vectors.of_squares()).for_each(|(own, u)| *own += u);
        }
    }

    /// Adds the mean of independent vectors.
    pub(super) fn add_mean(&mut self, vectors: &Moments) {
        let count = vectors.count;
        self.values.iter_mut().zip(&vectors.sums).for_each(|(value, sum)| *value += sum / count);
        self.covariances.iter_mut().zip(vectors.covariances()).for_each(|(own, c)| *own += c / count);
        self.uncertainties.iter_mut().zip(vectors.of_squares()).for_each(|(own, u)| *own += u / count.powi(4));
    }

    /// Adds the error of a mean over `count` further vectors with the same covariance.
    pub(super) fn add_error(&mut self, vectors: &Moments, count: f64) {
        self.covariances.iter_mut().zip(vectors.covariances()).for_each(|(own, c)| *own += c / count);
    }

    pub(super) fn value(&self, i: usize) -> f64 {
        self.values[i]
    }

    /// Returns the standard error.
    ///
    /// For few vectors, `degrees_of_freedom` is given. Otherwise the error is widened if few of the vectors dominate
    /// it: by Student's factor over the normal one, with Satterthwaite's degrees of freedom 2 V²/var V of its variance
    /// V.
    ///
    /// # References
    /// F. E. Satterthwaite, *Biometrics Bull.* **2** (1946) 110, <https://doi.org/10.2307/3002019>.
    pub(super) fn standard_error(&self, i: usize, degrees_of_freedom: Option<usize>) -> f64 {
        let variance = self.variance(i);
        if degrees_of_freedom.is_some() { variance.sqrt() } else { widened(variance, self.uncertainties[i]) }
    }

    fn variance(&self, i: usize) -> f64 {
        self.covariances[i * (i + 1) / 2 + i].max(0.0)
    }

    /// Returns the standard error at one of the leading `count` values of F; the first is a point mass.
    ///
    /// Errors at neighbouring values are similar but arise from other vectors, so the mean error of the neighbours is
    /// used if it is larger.
    fn standard_error_among(&self, i: usize, count: usize) -> f64 {
        let own = self.standard_error(i, None);
        if i == 0 {
            return own;
        }
        let around = i.saturating_sub(NEIGHBOURS).max(1)..(i + NEIGHBOURS + 1).min(count);
        let n = around.len() as f64;
        let variance = around.clone().map(|j| self.variance(j)).sum::<f64>() / n;
        let uncertainty = around.map(|j| self.uncertainties[j]).sum::<f64>() / (n * n);
        own.max(widened(variance, uncertainty))
    }

    /// Returns the band of the leading components, at `values`.
    pub(super) fn band(&self, values: &[f64], degrees_of_freedom: Option<usize>, seed: u64) -> Band {
        let n = values.len();
        let pair = |i: usize, j: usize| self.covariances[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
        let covariance: Vec<f64> = (0..n * n).map(|k| pair(k / n, k % n)).collect();
        let band = Band::new(values, &self.values[..n], &covariance, degrees_of_freedom, seed);
        if degrees_of_freedom.is_some() {
            return band;
        }
        Band { standard_errors: (0..n).map(|i| self.standard_error_among(i, n)).collect(), ..band }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::distribution::standard_normal_quantile;

    #[test]
    fn critical_values_of_equal_and_of_independent_errors_are_known() {
        let equal = Band::new(&[0.0, 1.0], &[0.2, 0.5], &[4.0, 4.0, 4.0, 4.0], None, 1);
        assert_eq!(equal.standard_errors, [2.0, 2.0]);
        // The 95 % point of 4,000 draws has a relative standard error of 1.5 %.
        assert!((equal.simultaneous_factor / NORMAL_95 - 1.0).abs() < 0.06, "{}", equal.simultaneous_factor);
        let n = 20;
        let identity: Vec<f64> = (0..n * n).map(|k| if k / n == k % n { 1.0 } else { 0.0 }).collect();
        let values: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let independent = Band::new(&values, &vec![0.5; n], &identity, None, 1);
        let wanted = standard_normal_quantile(0.5 + 0.5 * 0.95_f64.powf(1.0 / n as f64));
        assert!((independent.simultaneous_factor / wanted - 1.0).abs() < 0.04, "{}", independent.simultaneous_factor);
    }

    #[test]
    fn a_band_of_many_values_of_independent_samples_has_kolmogorovs_width() {
        // In the middle; towards the ends the band is narrower by design.
        let n = 199;
        let cdf: Vec<f64> = (1..=n).map(|i| f64::from(i) / f64::from(n + 1)).collect();
        let band = Band::from_independent(&cdf, &cdf, 100, 1);
        assert!((band.standard_errors[99] - 0.05).abs() < 1e-12);
        assert!(band.simultaneous_factor > 2.7 && band.simultaneous_factor < 3.3, "{}", band.simultaneous_factor);
        assert!((band.standard_error_at(0.5) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn limits_bias_and_errors_are_those_of_their_place() {
        let band = Band {
            values: vec![0.0, 1.0, 3.0],
            cdf: vec![0.3, 0.6, 0.98],
            bias: vec![0.0, 0.1, -0.05],
            standard_errors: vec![0.02, 0.04, 0.03],
            pointwise_factor: 2.0,
            simultaneous_factor: 3.0,
        };
        let close = |found: [f64; 2], wanted: [f64; 2]| (0..2).all(|k| (found[k] - wanted[k]).abs() < 1e-14);
        assert!(close(band.pointwise(0), [0.26, 0.34]) && close(band.simultaneous(0), [0.24, 0.36]));
        // Without the bias; a probability ends at one.
        assert!(close(band.pointwise(1), [0.42, 0.58]) && close(band.pointwise(2), [0.97, 1.0]));
        for (value, bias, error) in [(-1.0, 0.0, 0.02), (0.5, 0.05, 0.03), (1.5, 0.0625, 0.0375), (9.0, -0.05, 0.03)] {
            assert!(
                (band.bias_at(value) - bias).abs() < 1e-14 && (band.standard_error_at(value) - error).abs() < 1e-14
            );
        }
        let other = band.clone().with_estimate(vec![0.4, 0.6, 0.9]);
        assert!(other.bias.iter().zip([0.1, 0.0, -0.08]).all(|(found, wanted)| (found - wanted).abs() < 1e-14));
        assert_eq!((Band::default().bias_at(1.0), Band::default().standard_error_at(1.0)), (0.0, f64::INFINITY));
    }

    #[test]
    fn few_samples_on_one_side_widen_the_first_value_to_wilsons_interval() {
        let band = Band { standard_errors: vec![1e-6, 2e-6], pointwise_factor: NORMAL_95, ..Band::default() };
        for above in [2, 998] {
            let wilson = wilson_interval(above, 1000);
            let wanted = 0.5 * (wilson.high - wilson.low) / NORMAL_95;
            let found = band.clone().widened([above, 1000]).standard_errors;
            assert!((found[0] - wanted).abs() < 1e-12 && found[1] == 2e-6, "{found:?}");
        }
        assert_eq!(band.clone().widened([500, 1000]), band);
        // A larger error remains.
        let large = Band { standard_errors: vec![0.1], ..band };
        assert_eq!(large.clone().widened([2, 1000]), large);
    }

    #[test]
    fn added_samples_of_either_kind_enlarge_the_error_of_a_small_share() {
        // Agresti and Coull: (2 + 2)/(100 + 4).
        let band = Band::from_independent(&[0.0, 1.0], &[0.98, 1.0], 100, 1);
        let p = 4.0 / 104.0;
        assert!((band.standard_errors[0] - (p * (1.0_f64 - p) / 100.0).sqrt()).abs() < 1e-14);
        let p = 2.0 / 104.0;
        assert!((band.standard_errors[1] - (p * (1.0_f64 - p) / 100.0).sqrt()).abs() < 1e-14);
    }

    #[test]
    fn critical_values_of_few_groups_are_students_or_larger() {
        // One value of five groups: the 95 % point of Student's |t| with four degrees of freedom, 2.776.
        let one = critical_value_of_groups(1, 4, 1);
        assert!((one / 2.776 - 1.0).abs() < 0.1, "{one}");
        // Of ten independent values the largest is below x with probability F(x)¹⁰: the two-sided 0.9949 point, 5.57.
        let ten = critical_value_of_groups(10, 4, 1);
        assert!((ten / 5.57 - 1.0).abs() < 0.1, "{ten}");
        assert_eq!(critical_value_of_groups(3, 0, 1), f64::INFINITY);
    }

    #[test]
    fn sums_and_means_of_vectors_have_their_covariances() {
        let mut vectors = Moments::new(2);
        for v in [[1.0, 0.0], [3.0, 2.0], [5.0, 1.0]] {
            vectors.add(&v);
        }
        // Variances 4 and 1, covariance 1.
        let mut total = Total::new(2);
        total.add_sum(&vectors);
        total.add_mean(&vectors);
        assert_eq!((total.value(0), total.value(1)), (12.0, 4.0));
        assert!((total.standard_error(0, Some(2)) - (4.0_f64 * 3.0 + 4.0 / 3.0).sqrt()).abs() < 1e-12);
        assert!((total.standard_error(1, Some(2)) - (3.0_f64 + 1.0 / 3.0).sqrt()).abs() < 1e-12);
        let band = total.band(&[0.0], Some(2), 1);
        assert_eq!((band.cdf[0], band.standard_errors[0]), (12.0, total.standard_error(0, Some(2))));
    }

    #[test]
    fn an_error_of_zero_between_others_is_that_of_its_neighbours() {
        let mut vectors = Moments::new(3);
        (0..100).for_each(|i| vectors.add(&[0.0, 0.0, f64::from(i % 2)]));
        let mut total = Total::new(3);
        total.add_mean(&vectors);
        let errors = total.band(&[0.0, 1.0, 2.0], None, 1).standard_errors;
        // The mean of the variances 0 and 1/4·99, in a hundred samples; the point mass at zero has no neighbours.
        let wanted = (0.125_f64 / 99.0).sqrt();
        assert!(errors[0] == 0.0 && (errors[1] / wanted - 1.0).abs() < 0.02, "{errors:?}");
    }

    #[test]
    fn an_error_dominated_by_few_samples_has_few_degrees_of_freedom() {
        // Five of a hundred are one: squares about the mean .05 have the mean .0475 and the kurtosis κ with κ − 1 =
        // 1/(p(1 − p)) − 4.
        let mut vectors = Moments::new(1);
        (0..100).for_each(|i| vectors.add(&[if i % 20 == 0 { 1.0 } else { 0.0 }]));
        let mut total = Total::new(1);
        total.add_mean(&vectors);
        let degrees = 2.0 * 100.0 / (1.0 / 0.0475 - 4.0) * (100.0_f64 / 99.0).powi(2);
        let wanted = (0.0475_f64 / 99.0).sqrt() * student_quantile(0.975, degrees) / NORMAL_95;
        assert!(
            (total.standard_error(0, None) / wanted - 1.0).abs() < 1e-9,
            "{} {wanted}",
            total.standard_error(0, None)
        );
        assert!((total.standard_error(0, Some(99)) - (0.0475_f64 / 99.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn students_factors_for_several_values_at_once_are_larger_than_for_one() {
        let (cdf, covariance) = ([0.2, 0.8], [1.0, 0.0, 0.0, 1.0]);
        let one = Band::new(&[0.0], &[0.2], &[1.0], Some(9), 1);
        let two = Band::new(&[0.0, 1.0], &cdf, &covariance, Some(9), 1);
        assert!((one.pointwise_factor - 2.262_157).abs() < 1e-5);
        // A thousand draws of Student's distribution with nine degrees of freedom determine the 95 % point to about 4
        // %.
        assert!((one.simultaneous_factor / one.pointwise_factor - 1.0).abs() < 0.12, "{}", one.simultaneous_factor);
        // For two values the √.95 point: t(9) at .98734 is 2.68.
        let wanted = student_quantile(0.5 + 0.5 * 0.95_f64.sqrt(), 9.0);
        assert!((two.simultaneous_factor / wanted - 1.0).abs() < 0.12, "{} {wanted}", two.simultaneous_factor);
    }
}
