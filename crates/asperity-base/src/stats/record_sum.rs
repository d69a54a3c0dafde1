//! Variance of sums over correlated records.

use std::borrow::Cow;

use super::flat_top::{self, BLOCKS_TO_SPARE, FADED, LARGEST_FITTED};
use super::{Layout, Spread, lag_sums, sum_of_tracks};

/// Few blocks narrow the window, down to this fraction; with fewer there is no interval.
const WANTED_BLOCKS: f64 = 10.0;
const NARROWEST: f64 = 0.6;
const LEAST_BLOCKS: f64 = 5.0;

/// Ordered pairs of values on records of one stationary process, by lag.
#[derive(Debug, Clone)]
#[doc(hidden)]
pub struct RecordSum {
    /// Number of positions on each strip.
    lengths: Vec<usize>,
    layout: Layout,
    /// Pairs on the same strip at the lags 0, 1, 2, …, over the squared number of values.
    fractions: Vec<f64>,
    /// Distance in steps at which the correlation of the values falls to 1/e.
    length: f64,
}

impl RecordSum {
    /// Counts the pairs of present (finite) values of `records`, including pairs across the tracks of a strip. `mean`
    /// is the mean of the values.
    ///
    /// # Panics
    /// If a record is empty, or the tracks of a strip differ in length.
    #[doc(hidden)]
    pub fn new(records: &[&[f64]], mean: f64, layout: Layout) -> Self {
        let lengths: Vec<usize> = layout.by_strip(records).map(|tracks| tracks[0].len()).collect();
        let (products, counts) = pooled(records, mean, layout);
        let present = records.iter().flat_map(|record| record.iter()).filter(|v| v.is_finite()).count() as f64;
        let mut found = Self { lengths, layout, fractions: vec![], length: 0.0 };
        found.length = crossing(&products, &counts, (-1.0_f64).exp());
        found.fractions = counts.into_iter().map(|count| count / (present * present)).collect();
        found
    }

    /// Returns the pairs at the lags 0, 1, 2, …, over the squared number of values.
    #[doc(hidden)]
    pub fn fractions(&self) -> &[f64] {
        &self.fractions
    }

    /// Returns the spread of a statistic from its influences (NaN for a missing value), record by record as in
    /// [`RecordSum::new`]. They sum to zero because `fitted` means replace those of the process.
    ///
    /// The variance is the sum of the products of influences over all pairs within strips under a flat-top lag window,
    /// corrected for the fitted means and for the tail of an exponential correlogram beyond the window. If no record is
    /// longer than the window, it is the variance between strips.
    ///
    /// `None` with fewer than five blocks, or if the influences do not vary.
    ///
    /// # References
    /// Politis & Romano, *J. Time Ser. Anal.* **16** (1995) 67, <https://doi.org/10.1111/j.1467-9892.1995.tb00223.x>.
    #[doc(hidden)]
    pub fn spread(&self, influence: &[Vec<f64>], fitted: f64) -> Option<Spread> {
        let influence = self.across(influence);
        let views: Vec<&[f64]> = influence.iter().map(Vec::as_slice).collect();
        let (products, _) = pooled(&views, 0.0, Layout { tracks: 1, ..self.layout });
        let reach = crossing(&products, &self.fractions, FADED);
        let least = flat_top::least_end(reach, self.length);
        let spare = 0.75 / (self.fractions[0] * BLOCKS_TO_SPARE);
        let mut end = spare.clamp(least, 2.0 * least);
        let taken = |end: f64| self.weighted(end, |fraction, weight| fraction * weight);
        let squares = |end: f64| self.weighted(end, |fraction, weight| fraction * weight * weight);
        while end > 2.0 && (fitted * taken(end) > LARGEST_FITTED)
            || (end > NARROWEST * least && squares(end) * WANTED_BLOCKS > 1.0)
        {
            end *= 0.95;
        }
        let squares = squares(end);
        let lags = || products.iter().enumerate();
        let sum: f64 = lags().map(|(lag, product)| flat_top::weight(lag as f64, end) * product).sum();
        // Exponential correlogram with the same reach.
        let decay = reach / (1.0 / FADED).ln();
        let exponential = |lag: usize| (-(lag as f64) / decay).exp();
        let whole: f64 = self.fractions.iter().enumerate().map(|(lag, fraction)| fraction * exponential(lag)).sum();
        let within: f64 = self
            .fractions
            .iter()
            .enumerate()
            .map(|(lag, s)| flat_top::weight(lag as f64, end) * s * exponential(lag))
            .sum();
        let variance = sum / (1.0 - fitted * taken(end)) / (within / whole);
        let (third, fourth, blocks) = self.block_moments(&influence, end.round() as usize);
        let excess = (fourth - 3.0 / blocks).max(0.0);
        let freedom = 1.0 / (squares + 0.5 * excess) - 1.0;
        let sound = variance > 0.0 && 1.0 / squares >= LEAST_BLOCKS + 1.0;
        sound.then_some(Spread { variance, blocks: freedom, skewness: third })
    }

    /// Returns the influences summed over the tracks of every strip.
    fn across<'a>(&self, influence: &'a [Vec<f64>]) -> Cow<'a, [Vec<f64>]> {
        match self.layout.tracks {
            1 => Cow::Borrowed(influence),
            _ => self.layout.by_strip(influence).map(|tracks| sum_of_tracks(tracks, |value| value)).collect(),
        }
    }

    fn weighted(&self, end: f64, term: impl Fn(f64, f64) -> f64) -> f64 {
        self.fractions
            .iter()
            .enumerate()
            .map(|(lag, fraction)| term(*fraction, flat_top::weight(lag as f64, end)))
            .sum()
    }

    /// Returns Σ S³/(Σ S²)^{3/2}, Σ S⁴/(Σ S²)² and the number of blocks of about `side` values with sums S.
    fn block_moments(&self, influence: &[Vec<f64>], side: usize) -> (f64, f64, f64) {
        let mut powers = [0.0; 4];
        for (record, length) in influence.iter().zip(&self.lengths) {
            let blocks = (length / side.max(1)).max(1);
            for block in record.chunks(length.div_ceil(blocks)) {
                let sum: f64 = block.iter().filter(|v| !v.is_nan()).sum();
                let square = sum * sum;
                for (power, term) in powers.iter_mut().zip([1.0, square, square * sum, square * square]) {
                    *power += term;
                }
            }
        }
        let [blocks, second, third, fourth] = powers;
        (third / second.powf(1.5), fourth / (second * second), blocks)
    }
}

/// Returns the sums of products of deviations from `mean` over ordered pairs on the same strip, and the numbers of
/// these pairs, at each lag; on a periodic strip the lag is the shorter distance.
fn pooled(records: &[&[f64]], mean: f64, layout: Layout) -> (Vec<f64>, Vec<f64>) {
    let periodic = layout.periodic;
    let longest = records.iter().map(|record| record.len()).max().unwrap_or(0);
    let lags = if periodic { longest / 2 + 1 } else { longest };
    let (mut products, mut counts) = (vec![0.0; lags], vec![0.0; lags]);
    for strip in layout.by_strip(records) {
        let n = strip[0].len();
        let (of_strip, pairs) = match strip {
            [record] => lag_sums(record, mean, n),
            // The product of sums over tracks equals the sum of the products over all pairs of tracks.
            tracks => {
                let of = |value: &dyn Fn(f64) -> f64| lag_sums(&sum_of_tracks(tracks, value), 0.0, n).0;
                (of(&|value| value - mean), of(&|_| 1.0).into_iter().map(f64::round).collect())
            }
        };
        for (lag, (product, count)) in of_strip.into_iter().zip(pairs).enumerate() {
            let times = if lag == 0 { 1.0 } else { 2.0 };
            let place = if periodic { lag.min(n - lag) } else { lag };
            products[place] += times * product;
            counts[place] += times * count;
        }
    }
    (products, counts)
}

/// Returns the lag at which the mean product first falls to a fraction of its value at lag zero, or the longest lag.
fn crossing(products: &[f64], pairs: &[f64], fraction: f64) -> f64 {
    let at = |lag: usize| products[lag] / pairs[lag] * pairs[0] / products[0];
    let mut above = (0, 1.0);
    for lag in 1..products.len() {
        let value = at(lag);
        if value <= fraction {
            let (near, high) = above;
            return near as f64 + (high - fraction) / (high - value) * (lag - near) as f64;
        }
        if value.is_finite() {
            above = (lag, value);
        }
    }
    products.len() as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use crate::stats::Moments;
    use crate::testing::autoregressive;

    /// Records with correlation φ^lag.
    fn records(phi: f64, count: usize, n: usize, run: u64) -> Vec<Vec<f64>> {
        let stream = |index: u64| random::stream(41, "record sum", 100 * run + index);
        (0..count as u64).map(|index| autoregressive(phi, n, &mut stream(index))).collect()
    }

    fn views(records: &[Vec<f64>]) -> Vec<&[f64]> {
        records.iter().map(Vec::as_slice).collect()
    }

    #[test]
    fn pairs_are_counted_one_by_one_also_round_a_circle() {
        let mut records = records(0.7, 2, 12, 0);
        records[1].truncate(9);
        records[0][4] = f64::NAN;
        for periodic in [false, true] {
            let (products, counts) = pooled(&views(&records), 0.1, periodic.into());
            let (mut naive, mut pairs) = (vec![0.0; products.len()], vec![0.0; products.len()]);
            for record in &records {
                for (i, a) in record.iter().enumerate() {
                    for (j, b) in record.iter().enumerate() {
                        let apart = i.abs_diff(j);
                        let lag = if periodic { apart.min(record.len() - apart) } else { apart };
                        if !(a.is_nan() || b.is_nan()) {
                            naive[lag] += (a - 0.1) * (b - 0.1);
                            pairs[lag] += 1.0;
                        }
                    }
                }
            }
            assert!(products.iter().zip(&naive).all(|(a, b)| (a - b).abs() < 1e-12), "{periodic}");
            assert_eq!(counts, pairs);
        }
    }

    #[test]
    fn the_variance_of_a_mean_is_that_over_many_runs_however_long_the_records() {
        // One record, some, and so many that each is shorter than the window; τ = (1 + φ)/(1 − φ) = 19 steps.
        for (records, n) in [(1, 2000), (4, 500), (40, 50)] {
            let runs = 200;
            let (mut means, mut variances, mut blocks) = (vec![], vec![], vec![]);
            for run in 0..runs {
                let records = super::tests::records(0.9, records, n, run + 1);
                let mean = Moments::new(&records.concat()).mean;
                let sum = RecordSum::new(&views(&records), mean, false.into());
                let influence: Vec<Vec<f64>> =
                    records.iter().map(|record| record.iter().map(|x| (x - mean) / 2000.0).collect()).collect();
                let spread = sum.spread(&influence, 1.0).unwrap();
                means.push(mean);
                variances.push(spread.variance);
                blocks.push(spread.blocks);
            }
            let found = Moments::new(&variances);
            let ratio = found.mean / Moments::new(&means).std.powi(2);
            println!("{records} × {n}: {ratio} {:?} {:?}", found.std / found.mean, Moments::new(&blocks).mean);
            // A variance over 200 runs has a standard error of 10 %, the mean of 200 variances on 15 blocks 3 %.
            assert!((ratio - 1.0).abs() < 4.0 * 0.105, "{records} records: {ratio}");
            // The degrees of freedom match the variance of the estimate, within their own standard error.
            let freedom = 2.0 * (found.mean / found.std).powi(2);
            let estimated = Moments::new(&blocks).mean;
            assert!(
                estimated / freedom < 1.8 && freedom / estimated < 1.8,
                "{records} records: {estimated} for {freedom}"
            );
        }
    }

    #[test]
    fn too_few_blocks_carry_no_spread() {
        let records = records(0.99, 1, 300, 9);
        let mean = Moments::new(&records[0]).mean;
        let influence = vec![records[0].iter().map(|x| (x - mean) / 300.0).collect()];
        assert!(RecordSum::new(&views(&records), mean, false.into()).spread(&influence, 1.0).is_none());
    }
}
