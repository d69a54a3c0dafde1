//! Null distribution of the goodness of fit of distributions fitted to correlated records.

use std::sync::LazyLock;

use super::{FitGoodness, Goodness};
use crate::blocks;
use crate::distribution::fit::Fit;
use crate::distribution::{DistributionError, standard_normal_cdf, standard_normal_pdf, standard_normal_quantile};
use crate::fourier::RealFft2;
use crate::numeric::{dot, inverse};
use crate::random;
use crate::stats::{Layout, sorted_present};

/// Cell width of the histogram of normal scores g = Φ⁻¹(F(x)), within ±[`REACH`].
const CELL: f64 = 0.02;
const REACH: f64 = 5.0;
const CELLS: usize = 500;
/// Least number of values of a simulation that stands for longer free records, absolute and in correlation times.
const LEAST_SIMULATED: usize = 1 << 15;
const LEAST_TIMES: f64 = 500.0;
/// Highest order of the autoregression, absolute and as a fraction of the longest record.
const MOST_ORDER: usize = 64;
const LONGEST_FRACTION: usize = 8;

/// Simulated records of a translation process with the correlation of a sample, for p-values of distances to fitted
/// distributions.
///
/// An autoregression, with the order from Akaike's criterion, is fitted to the normal scores of the ranks and simulated
/// on records with the lengths and gaps of the sample. The distance of each simulated record to the distribution
/// *fitted to it* is computed to first order in the errors of the parameters: F_n − F − ∂F/∂θ I⁻¹ s̄ with the scores s
/// and Fisher's information I. Scores and distances depend on g only, so one set of simulations serves all
/// distributions.
///
/// Simulations of long free records are shorter, and their distances are scaled: differences of distribution functions
/// are of order n^{−1/2}, with a distribution that hardly depends on n from some hundred correlation times.
///
/// Ends of the support on which the likelihood does not depend smoothly ([`Fit::estimates`]) are not refitted. Periodic
/// strips are simulated as periodic, with the covariance of the autoregression summed over all periods; this matters
/// below about six correlation lengths. Tracks of a strip are simulated with the correlation of those of the sample at
/// the same position, by their distance around the strip.
///
/// # References
/// Stute, González Manteiga & Presedo Quindimil, *Metrika* **40** (1993) 243, <https://doi.org/10.1007/BF02613687>
/// (parametric bootstrap of distances); Durbin, *Ann. Stat.* **1** (1973) 279, <https://doi.org/10.1214/aos/1176342365>
/// (estimated parameters to first order).
#[derive(Debug, Clone)]
pub struct ProcessNull {
    /// Fraction of the values in each cell, for every simulation.
    draws: Vec<Vec<f64>>,
    /// Number of values of a simulation over the number of values of the sample.
    fraction: f64,
    order: usize,
}

impl ProcessNull {
    /// Simulates `draws` samples like `records`, which have equal steps and belong to one process with independent
    /// strips. NaN is a missing value, and `true` and `false` stand for periodic and free strips of one track.
    /// Simulation i uses the stream (seed, "goodness", i).
    ///
    /// # Errors
    /// Fewer than 10 values, or all equal.
    ///
    /// # Panics
    /// If the tracks of a strip differ in number or length.
    pub fn new(
        records: &[&[f64]],
        layout: impl Into<Layout>,
        draws: usize,
        seed: u64,
    ) -> Result<Self, DistributionError> {
        let layout = layout.into();
        let sorted = sorted_present(records.iter().flat_map(|record| record.iter().copied()));
        let error = |reason| DistributionError::Sample { distribution: "goodness of fit", n: sorted.len(), reason };
        match (sorted.first(), sorted.last()) {
            (Some(first), Some(last)) if sorted.len() >= 10 => {
                if first == last {
                    return Err(error("all values are equal"));
                }
            }
            _ => return Err(error("at least 10 are needed")),
        }
        let n = sorted.len() as f64;
        let score = |x: &f64| {
            if x.is_nan() {
                return f64::NAN;
            }
            // Tied values share their mean rank.
            let below = sorted.partition_point(|v| v < x) as f64;
            let through = sorted.partition_point(|v| v <= x) as f64;
            standard_normal_quantile(0.5 * (below + through) / n)
        };
        let scores: Vec<Vec<f64>> = records.iter().map(|record| record.iter().map(score).collect()).collect();
        let longest = scores.iter().map(Vec::len).max().unwrap_or(0);
        let process = Autoregression::fit(&scores, MOST_ORDER.min(longest / LONGEST_FRACTION));
        let mixture = track_mixture(&scores, layout);
        let most = LEAST_SIMULATED.max((LEAST_TIMES * process.correlation_time()) as usize);
        let scores = if layout.periodic || layout.tracks > 1 { scores } else { shortened(scores, most) };
        let simulated = scores.iter().flatten().filter(|score| !score.is_nan()).count() as f64;
        let mut circles: Vec<Circle> = Vec::new();
        for n in scores.iter().map(Vec::len).filter(|n| layout.periodic && *n > 0) {
            if !circles.iter().any(|circle| circle.fft.nx() == n) {
                circles.push(Circle::new(&process, n));
            }
        }
        let draw = |index: usize| {
            let mut stream = random::stream(seed, "goodness", index as u64);
            let mut counts = vec![0.0; CELLS];
            let xi_samples: Vec<Vec<f64>> =
                scores.iter().map(|record| random::standard_normal(&mut stream, record.len())).collect();
            let xi_samples = layout.by_strip(&xi_samples).flat_map(|tracks| mixed(tracks, &mixture));
            for (record, xi) in scores.iter().zip(xi_samples) {
                let path = match circles.iter().find(|circle| circle.fft.nx() == record.len()) {
                    Some(circle) => circle.path(xi),
                    None => process.path(xi),
                };
                for (g, _) in path.iter().zip(record).filter(|(_, score)| !score.is_nan()) {
                    counts[cell(*g)] += 1.0 / simulated;
                }
            }
            counts
        };
        let draws = blocks::map(0..draws, draw);
        Ok(Self { draws, fraction: simulated / n, order: process.order() })
    }

    /// Returns the order of the autoregression of the normal scores.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Returns the distances of the values from a distribution fitted to them, with p-values (1 + number of larger
    /// simulated distances)/(1 + draws).
    ///
    /// # Errors
    /// An empty sample.
    pub fn goodness(&self, fit: &Fit, values: &[f64]) -> Result<FitGoodness, DistributionError> {
        let sorted = sorted_present(values.iter().copied());
        let reason = "no value is present";
        let empty = || DistributionError::Sample { distribution: fit.marginal.name(), n: 0, reason };
        let asymptotic = FitGoodness::new(&fit.marginal, &sorted, f64::INFINITY).ok_or_else(empty)?;
        Ok(self.assess(fit, &sorted, asymptotic))
    }

    /// Returns the distances with p-values as [`ProcessNull::goodness`] does, from those of the sorted values.
    pub(in crate::distribution) fn assess(&self, fit: &Fit, sorted: &[f64], known: FitGoodness) -> FitGoodness {
        let projection = Projection::new(fit);
        let own = distances(&cell_fractions(fit, sorted), None);
        let farther: Vec<[bool; 2]> = blocks::map(0..self.draws.len(), |draw| {
            let drawn = distances(&self.draws[draw], Some(&projection));
            [self.fraction.sqrt() * drawn[0] >= own[0], self.fraction * drawn[1] >= own[1]]
        });
        let p_value = |which: usize| {
            let count = farther.iter().filter(|far| far[which]).count();
            (1 + count) as f64 / (1 + self.draws.len()) as f64
        };
        let with = |goodness: Goodness, which: usize| {
            let effective_size = sorted.len() as f64;
            Goodness { statistic: goodness.statistic, effective_size, p_value: p_value(which) }
        };
        FitGoodness {
            kolmogorov_smirnov: with(known.kolmogorov_smirnov, 0),
            anderson_darling: known.anderson_darling.map(|goodness| with(goodness, 1)),
        }
    }
}

/// Returns the first values of the records, up to `most` in total.
fn shortened(mut records: Vec<Vec<f64>>, most: usize) -> Vec<Vec<f64>> {
    let mut left = most;
    for record in &mut records {
        record.truncate(left);
        left -= record.len();
    }
    records
}

fn cell(g: f64) -> usize {
    // Conversion to integers saturates.
    (((g + REACH) / CELL) as usize).min(CELLS - 1)
}

/// Returns Φ⁻¹(F(x)) with full precision in both tails.
fn normal_score(fit: &Fit, x: f64) -> f64 {
    let lower = fit.marginal.cdf(x);
    if lower < 0.5 { standard_normal_quantile(lower) } else { -standard_normal_quantile(fit.marginal.survival(x)) }
}

/// Returns the fraction of the sorted values in each cell of the normal score.
fn cell_fractions(fit: &Fit, sorted: &[f64]) -> Vec<f64> {
    let of = |x: f64| cell(normal_score(fit, x));
    let mut fractions = vec![0.0; CELLS];
    let mut rest = sorted;
    while let Some(first) = rest.first() {
        let own = of(*first);
        let count = rest.partition_point(|x| of(*x) <= own).max(1);
        fractions[own] += count as f64 / sorted.len() as f64;
        rest = &rest[count..];
    }
    fractions
}

/// Effect of the fitted parameters on a difference of distribution functions.
struct Projection {
    /// I⁻¹ s at the centre of every cell, for every parameter.
    scores: Vec<Vec<f64>>,
    /// ∂F/∂θ at the upper edge of every cell.
    slopes: Vec<Vec<f64>>,
}

impl Projection {
    fn new(fit: &Fit) -> Self {
        let parameters = fit.regular_parameters();
        let middle = |i: usize| (i as f64 + 0.5) * CELL - REACH;
        let at_middle: Vec<f64> = (0..CELLS).map(|i| fit.marginal.translate(middle(i))).collect();
        let at_end: Vec<f64> = (0..CELLS).map(|i| fit.marginal.translate(middle(i) + 0.5 * CELL)).collect();
        let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
        let scores: Vec<Vec<f64>> =
            parameters.iter().map(|p| at_middle.iter().map(|x| finite(fit.score(*p, *x))).collect()).collect();
        let slopes = parameters.iter().map(|p| at_end.iter().map(|x| finite(fit.slope(*p, *x))).collect()).collect();
        let product = |a: &[f64], b: &[f64]| -> f64 {
            (0..CELLS).map(|i| CELL * standard_normal_pdf(middle(i)) * a[i] * b[i]).sum()
        };
        let information = scores.iter().map(|a| scores.iter().map(|b| product(a, b)).collect()).collect();
        let Some(inverse) = inverse(information) else { return Self { scores: vec![], slopes: vec![] } };
        let combined = |row: &Vec<f64>| {
            (0..CELLS).map(|i| row.iter().zip(&scores).map(|(weight, score)| weight * score[i]).sum()).collect()
        };
        Self { scores: inverse.iter().map(combined).collect(), slopes }
    }
}

/// Upper edge g of a cell: Φ(g), φ(g) and Φ(g) Φ(−g).
struct Edge {
    lower: f64,
    density: f64,
    variance: f64,
}

/// Edges between all cells.
static EDGES: LazyLock<Vec<Edge>> = LazyLock::new(|| {
    let edge = |i: usize| {
        let g = i as f64 * CELL - REACH;
        let lower = standard_normal_cdf(g);
        Edge { lower, density: standard_normal_pdf(g), variance: lower * standard_normal_cdf(-g) }
    };
    (1..CELLS).map(edge).collect()
});

/// Returns the Kolmogorov–Smirnov and Anderson–Darling distances of cell fractions from the normal distribution, with
/// the effect of a fit removed by `projection`.
fn distances(fractions: &[f64], projection: Option<&Projection>) -> [f64; 2] {
    let moves: Vec<f64> = projection
        .map_or_else(Vec::new, |projection| projection.scores.iter().map(|score| dot(score, fractions)).collect());
    let (mut below, mut largest, mut squares) = (0.0, 0.0_f64, 0.0);
    for (i, (fraction, edge)) in fractions.iter().zip(EDGES.iter()).enumerate() {
        below += fraction;
        let mut difference = below - edge.lower;
        if let Some(projection) = projection {
            difference -= projection.slopes.iter().zip(&moves).map(|(slope, by)| slope[i] * by).sum::<f64>();
        }
        largest = largest.max(difference.abs());
        squares += difference * difference * CELL * edge.density / edge.variance;
    }
    [largest, squares]
}

/// Stationary normal autoregression of unit variance.
struct Autoregression {
    /// Coefficients of every order up to the selected one, for the last value first, and standard deviation of the
    /// innovation.
    orders: Vec<(Vec<f64>, f64)>,
}

impl Autoregression {
    /// Fits by Burg's method to all records together; the order minimises Akaike's criterion.
    ///
    /// # References
    /// Burg, *Maximum Entropy Spectral Analysis*, PhD thesis, Stanford 1975; Akaike, *IEEE Trans. Autom. Control*
    /// **19** (1974) 716, <https://doi.org/10.1109/TAC.1974.1100705>.
    fn fit(records: &[Vec<f64>], most: usize) -> Self {
        let (mut forward, mut backward) = (records.to_vec(), records.to_vec());
        let mut orders: Vec<(Vec<f64>, f64)> = vec![(vec![], 1.0)];
        let (mut best, mut variance) = ((f64::INFINITY, 0), 1.0_f64);
        let n = records.iter().flatten().filter(|x| !x.is_nan()).count() as f64;
        for order in 0..=most {
            let criterion = n * variance.ln() + 2.0 * order as f64;
            if criterion < best.0 {
                best = (criterion, order);
            }
            let (mut product, mut power) = (0.0, 0.0);
            for (f, b) in forward.iter().zip(&backward) {
                // f at t and b at t − 1.
                for (f, b) in f.iter().skip(order + 1).zip(b.iter().skip(order)) {
                    if !(f.is_nan() || b.is_nan()) {
                        product += f * b;
                        power += f * f + b * b;
                    }
                }
            }
            let reflection = 2.0 * product / power;
            if !(power > 0.0 && reflection.abs() < 1.0) {
                break;
            }
            for (f, b) in forward.iter_mut().zip(&mut backward) {
                for t in (order + 1..f.len()).rev() {
                    let (ahead, behind) = (f[t], b[t - 1]);
                    (f[t], b[t]) = (ahead - reflection * behind, behind - reflection * ahead);
                }
            }
            let before = &orders[order].0;
            let mut next: Vec<f64> =
                before.iter().zip(before.iter().rev()).map(|(here, there)| here - reflection * there).collect();
            next.push(reflection);
            variance *= 1.0 - reflection * reflection;
            orders.push((next, variance.sqrt()));
        }
        orders.truncate(best.1 + 1);
        Self { orders }
    }

    fn order(&self) -> usize {
        self.orders.len() - 1
    }

    /// Returns the sum of the correlations over all lags.
    fn correlation_time(&self) -> f64 {
        let (coefficients, std) = &self.orders[self.order()];
        (std / (1.0 - coefficients.iter().sum::<f64>())).powi(2)
    }

    /// Returns the path generated by a standard normal ξ, stationary from its first value.
    fn path(&self, mut xi: Vec<f64>) -> Vec<f64> {
        for t in 0..xi.len() {
            let (coefficients, std) = &self.orders[t.min(self.order())];
            let expected: f64 = coefficients.iter().zip(xi[..t].iter().rev()).map(|(c, x)| c * x).sum();
            xi[t] = expected + std * xi[t];
        }
        xi
    }
}

/// Mixing weights of the ξ of the tracks, by their distance around the strip: the square root of the circulant matrix
/// of the correlations at the same position, without negative eigenvalues.
fn track_mixture(scores: &[Vec<f64>], layout: Layout) -> Vec<f64> {
    let tracks = layout.tracks;
    if tracks == 1 {
        return vec![1.0];
    }
    let mut correlation = vec![0.0; tracks];
    for (distance, correlation) in correlation.iter_mut().enumerate() {
        let (mut product, mut power) = (0.0, 0.0);
        for strip in layout.by_strip(scores) {
            for track in 0..tracks {
                for (a, b) in strip[track].iter().zip(&strip[(track + distance) % tracks]) {
                    if !(a.is_nan() || b.is_nan()) {
                        product += a * b;
                        power += 0.5 * (a * a + b * b);
                    }
                }
            }
        }
        *correlation = if power > 0.0 { product / power } else { 0.0 };
    }
    let fft = RealFft2::new(tracks, 1);
    let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
    fft.forward(&correlation, &mut spectrum, &mut work);
    spectrum.iter_mut().for_each(|value| *value = value.re.max(0.0).sqrt().into());
    let mut mixture = vec![0.0; tracks];
    fft.inverse(&mut spectrum, &mut mixture, &mut work);
    let norm = mixture.iter().map(|fraction| fraction * fraction).sum::<f64>().sqrt();
    mixture.iter_mut().for_each(|fraction| *fraction /= norm);
    mixture
}

/// Returns the mixed ξ of the tracks of a strip.
fn mixed(xi_samples: &[Vec<f64>], mixture: &[f64]) -> Vec<Vec<f64>> {
    if let [xi] = xi_samples {
        return vec![xi.clone()];
    }
    let tracks = xi_samples.len();
    let of = |track: usize, place: usize| -> f64 {
        xi_samples.iter().enumerate().map(|(other, xi)| mixture[(other + tracks - track) % tracks] * xi[place]).sum()
    };
    (0..tracks).map(|track| (0..xi_samples[track].len()).map(|place| of(track, place)).collect()).collect()
}

/// Stationary normal process on a periodic strip.
struct Circle {
    fft: RealFft2,
    /// Spectral amplitude by wavenumber.
    amplitudes: Vec<f64>,
}

impl Circle {
    /// Creates the autoregression on a strip of `n` values, with its covariance summed over all periods and scaled to
    /// unit variance, from its density 1/|1 − Σ c_k e^{−iωk}|² at the wavenumbers of the strip.
    fn new(process: &Autoregression, n: usize) -> Self {
        let fft = RealFft2::new(n, 1);
        let coefficients = &process.orders[process.order()].0;
        let amplitude = |wavenumber: usize| {
            let phase = std::f64::consts::TAU * wavenumber as f64 / n as f64;
            let (mut re, mut im) = (1.0, 0.0);
            for (k, c) in coefficients.iter().enumerate() {
                let angle = phase * (k + 1) as f64;
                (re, im) = (re - c * angle.cos(), im + c * angle.sin());
            }
            1.0 / (re * re + im * im).sqrt()
        };
        let mut amplitudes: Vec<f64> = (0..fft.spectrum().len()).map(amplitude).collect();
        // All wavenumbers except 0 and n/2 count twice.
        let twice = |k: usize| if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
        let power: f64 = amplitudes.iter().enumerate().map(|(k, a)| twice(k) * a * a).sum();
        amplitudes.iter_mut().for_each(|a| *a /= (power / n as f64).sqrt());
        Self { fft, amplitudes }
    }

    /// Returns the path generated by a standard normal ξ.
    fn path(&self, mut xi: Vec<f64>) -> Vec<f64> {
        let (mut spectrum, mut work) = (self.fft.spectrum(), self.fft.workspace());
        self.fft.forward(&xi, &mut spectrum, &mut work);
        spectrum.iter_mut().zip(&self.amplitudes).for_each(|(value, amplitude)| *value *= *amplitude);
        self.fft.inverse(&mut spectrum, &mut xi, &mut work);
        xi
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::Marginal;
    use crate::distribution::fit::{Family, fit};

    fn autoregression() -> Autoregression {
        // Reflection coefficients .8 and −.5: coefficients .8(1 + .5) and −.5.
        let first = (vec![0.8], 0.6);
        Autoregression { orders: vec![(vec![], 1.0), first, (vec![1.2, -0.5], 0.6 * 0.75_f64.sqrt())] }
    }

    #[test]
    fn an_autoregression_is_stationary_from_the_start_and_found_again() {
        let truth = autoregression();
        let draw = |i: u64| truth.path(random::standard_normal(&mut random::stream(3, "ar2", i), 400));
        let mut records: Vec<Vec<f64>> = (0..200).map(draw).collect();
        // ρ₁ = .8, ρ₂ = 1.2 · .8 − .5; 200 pairs have a standard error of at most .07, the mean square .1.
        let mean = |i: usize, j: usize| records.iter().map(|r| r[i] * r[j]).sum::<f64>() / 200.0;
        for (i, j, wanted) in [(0, 0, 1.0), (0, 1, 0.8), (0, 2, 0.46), (50, 50, 1.0), (50, 52, 0.46)] {
            assert!((mean(i, j) - wanted).abs() < 0.4, "{i} {j}: {}", mean(i, j));
        }
        records.iter_mut().for_each(|record| record[100] = f64::NAN);
        let found = Autoregression::fit(&records, 10);
        let (coefficients, std) = &found.orders[2];
        // 80,000 values determine a coefficient to √(1 − .25)/√80,000 = .003.
        assert!((coefficients[0] - 1.2).abs() < 0.012 && (coefficients[1] + 0.5).abs() < 0.012, "{coefficients:?}");
        assert!((std - truth.orders[2].1).abs() < 0.01 && found.order() < 6);
    }

    #[test]
    fn round_a_strip_the_covariance_is_that_of_all_turns() {
        let truth = autoregression();
        // ρ_l = 1.2 ρ_{l−1} − .5 ρ_{l−2}.
        let mut rho = vec![1.0, 0.8];
        (2..400).for_each(|l| rho.push(1.2 * rho[l - 1] - 0.5 * rho[l - 2]));
        for n in [7_usize, 12, 40] {
            let circle = Circle::new(&truth, n);
            // After nine periods of seven, .5^{31} remains.
            let turns = |lag: usize| {
                (-9..=9_i64).map(|m| rho[(lag as i64 + m * n as i64).unsigned_abs() as usize]).sum::<f64>()
            };
            // Autocorrelation of the impulse response.
            let mut impulse = vec![0.0; n];
            impulse[0] = 1.0;
            let response = circle.path(impulse);
            for lag in 0..n {
                let found: f64 = (0..n).map(|i| response[i] * response[(i + lag) % n]).sum();
                assert!((found - turns(lag) / turns(0)).abs() < 1e-8, "{n} {lag}: {found}");
            }
        }
    }

    #[test]
    fn simulated_tracks_have_the_correlation_of_the_sample() {
        let of = |i: u64| random::standard_normal(&mut random::stream(7, "lanes", i), 4000);
        let layout = Layout { periodic: true, tracks: 4 };
        let copies = track_mixture(&vec![of(0); 4], layout);
        assert!(copies.iter().all(|fraction| (fraction - 0.5).abs() < 1e-12), "{copies:?}");
        // Each track shares half of its variance with either neighbour around the strip: Z_l + Z_{l+1}.
        let xi_samples: Vec<Vec<f64>> = (0..4).map(of).collect();
        let tracks: Vec<Vec<f64>> =
            (0..4).map(|l| xi_samples[l].iter().zip(&xi_samples[(l + 1) % 4]).map(|(a, b)| a + b).collect()).collect();
        let mixture = track_mixture(&tracks, layout);
        let drawn = mixed(&xi_samples, &mixture);
        let product = |a: usize, b: usize| drawn[a].iter().zip(&drawn[b]).map(|(x, y)| x * y).sum::<f64>() / 4000.0;
        // 4,000 products give a correlation to 1/√4,000 = .016; the tolerance is twice that.
        for (a, b, wanted) in [(0, 0, 1.0), (0, 1, 0.5), (1, 2, 0.5), (0, 2, 0.0), (0, 3, 0.5)] {
            assert!((product(a, b) - wanted).abs() < 4.0 * 0.023, "{a} {b}: {}", product(a, b));
        }
        assert_eq!(track_mixture(&[of(0)], false.into()), [1.0]);
    }

    #[test]
    fn first_order_distances_of_refitted_distributions_are_those_of_refits() {
        // Records of a correlated normal process, with the normal distribution actually refitted to each.
        let truth = autoregression();
        let record = |i: u64| truth.path(random::standard_normal(&mut random::stream(5, "null", i), 1000));
        let projection = {
            let values = record(0);
            Projection::new(&Fit { marginal: Marginal::STANDARD_NORMAL, ..fit(Family::Normal, &values).unwrap() })
        };
        let fractions = |values: &[f64], marginal: &dyn Fn(f64) -> f64| {
            let mut counts = vec![0.0; CELLS];
            values.iter().for_each(|x| counts[cell(marginal(*x))] += 1.0 / values.len() as f64);
            counts
        };
        let (mut ratio, mut worst) = ([0.0; 2], 0.0_f64);
        for i in 1..=100 {
            let values = record(i);
            let Marginal::Normal { mean, std } = fit(Family::Normal, &values).unwrap().marginal else { panic!() };
            let refitted = distances(&fractions(&values, &|x| (x - mean) / std), None);
            let linear = distances(&fractions(&values, &|x| x), Some(&projection));
            for k in 0..2 {
                ratio[k] += linear[k] / refitted[k] / 100.0;
            }
            worst = worst.max((linear[0] / refitted[0]).ln().abs());
        }
        println!("{ratio:?} {worst}");
        // The second order is about the squared error of a parameter, 1/n_eff ≈ 1/300 of F, compared with distances of
        // 1/√300.
        assert!(ratio.iter().all(|r| (r - 1.0).abs() < 0.06), "{ratio:?}");
        assert!(worst < 0.5);
    }

    #[test]
    #[ignore = "slow"]
    fn right_distributions_are_refused_as_often_as_stated_and_wrong_ones_more_often() {
        let runs = 120;
        let marginal: Marginal = "beta:2.1,5".parse().unwrap();
        let phi = (-0.2_f64).exp();
        let mut refused = [0; 3];
        for run in 0..runs {
            let mut g = random::standard_normal(&mut random::stream(37, "null level", run), 1000);
            for t in 1..1000 {
                g[t] = phi * g[t - 1] + (1.0 - phi * phi).sqrt() * g[t];
            }
            let values: Vec<f64> = g.iter().map(|g| marginal.translate(*g)).collect();
            let records: Vec<&[f64]> = values.chunks(250).collect();
            let null = ProcessNull::new(&records, false, 99, run).unwrap();
            let p = |family| null.goodness(&fit(family, &values).unwrap(), &values).unwrap();
            let (right, wrong) = (p(Family::Beta { low: 0.0, high: 1.0 }), p(Family::Normal));
            refused[0] += usize::from(right.kolmogorov_smirnov.p_value <= 0.1);
            refused[1] += usize::from(right.anderson_darling.unwrap().p_value <= 0.1);
            refused[2] += usize::from(wrong.anderson_darling.unwrap().p_value <= 0.1);
        }
        println!("{refused:?}");
        // 10 % of 120 with a standard error of 3.3.
        assert!(refused[..2].iter().all(|count| *count <= 12 + 11), "{refused:?} of {runs}");
        assert!(refused[2] > 30, "{refused:?} of {runs}");
    }

    #[test]
    fn cell_fractions_count_the_values_one_by_one() {
        let values = sorted_present(random::standard_normal(&mut random::stream(5, "cells", 0), 3000));
        for family in [Family::Normal, Family::BetaFreeBounds, Family::Empirical { bins: 8 }] {
            let fit = fit(family, &values).unwrap();
            let mut wanted = vec![0.0; CELLS];
            values.iter().for_each(|x| wanted[cell(normal_score(&fit, *x))] += 1.0 / 3000.0);
            let found = cell_fractions(&fit, &values);
            assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{family:?}");
        }
    }

    #[test]
    fn a_shorter_simulation_of_a_long_record_has_its_scaled_distances() {
        // τ = 2.4 steps, and about 430 and 3,400 correlation times.
        let values = autoregression().path(random::standard_normal(&mut random::stream(5, "long", 0), 8192));
        let normal = fit(Family::Normal, &values).unwrap();
        let projection = Projection::new(&normal);
        let mean = |values: &[f64], scale: f64| {
            let null = ProcessNull::new(&[values], false, 199, 3).unwrap();
            assert_eq!(null.fraction, 1.0);
            let distance = |draw: &Vec<f64>| distances(draw, Some(&projection))[0];
            scale.sqrt() * null.draws.iter().map(distance).sum::<f64>() / 199.0
        };
        // The distances of 199 simulations scatter by about 30 %.
        let ratio = mean(&values[..1024], 0.125) / mean(&values, 1.0);
        assert!((ratio - 1.0).abs() < 4.0 * 0.3 * (2.0_f64 / 199.0).sqrt(), "{ratio}");
        let long = autoregression().path(random::standard_normal(&mut random::stream(5, "long", 1), 50_000));
        let null = ProcessNull::new(&[&long[..20_000], &long[20_000..]], false, 3, 3).unwrap();
        assert_eq!(null.fraction, LEAST_SIMULATED as f64 / 50_000.0);
    }

    #[test]
    fn p_values_do_not_depend_on_the_unit_or_the_number_of_threads() {
        let values = autoregression().path(random::standard_normal(&mut random::stream(5, "null", 0), 500));
        let small: Vec<f64> = values.iter().map(|x| 1e-9 * x).collect();
        let p = |values: &[f64]| {
            let null = ProcessNull::new(&[values], false, 99, 3).unwrap();
            null.goodness(&fit(Family::Normal, values).unwrap(), values).unwrap().kolmogorov_smirnov.p_value
        };
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let three = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(one.install(|| p(&values)), three.install(|| p(&values)));
        assert!((p(&values) - p(&small)).abs() < 0.021, "one draw more or less");
        assert!(
            ProcessNull::new(&[&[1.0; 20]], false, 9, 0).is_err()
                && ProcessNull::new(&[&values[..5]], false, 9, 0).is_err()
        );
    }
}
