//! Parallel sorting of large samples.

use crate::blocks;

/// Sample size above which buckets are used.
const LARGE: usize = 1 << 16;
/// Values per chunk distributed to buckets; fits the level-2 cache.
const CHUNK: usize = 1 << 16;
/// Mean number of values per bucket; fits the level-1 cache.
const BUCKET: usize = 1024;
/// Largest number of buckets, limited by the type of the index.
const MAX_BUCKETS: usize = 1 << 14;
/// Values sampled per bucket to determine its limits, and cells of the lookup table per bucket.
const SAMPLED: usize = 8;
const CELLS: usize = 4096;

/// Direction of sorting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[doc(hidden)]
pub enum Order {
    Ascending,
    Descending,
}

/// Returns the sorted values without NaN, less `origin`.
///
/// Large samples are distributed to buckets bounded by quantiles of a subsample, and the buckets are sorted separately.
/// The result is exact for every distribution; clusters only cost time.
#[doc(hidden)]
pub fn sorted(values: &[f64], origin: f64, order: Order) -> Vec<f64> {
    if values.len() >= LARGE
        && let Some(dealer) = Dealer::new(values)
    {
        return dealer.sorted(values, origin, order);
    }
    let mut keys: Vec<i64> = values.iter().filter(|v| !v.is_nan()).map(|v| key(*v, order)).collect();
    keys.sort_unstable();
    keys.into_iter().map(|key| value(key, order) - origin).collect()
}

/// Returns an integer with the order of [`f64::total_cmp`], or the reverse. Integers sort twice as fast.
fn key(value: f64, order: Order) -> i64 {
    flipped(flip(value.to_bits() as i64), order)
}

/// Returns the value of a [`key`].
fn value(key: i64, order: Order) -> f64 {
    f64::from_bits(flip(flipped(key, order)) as u64)
}

/// Inverts the bits below the sign of negative numbers, which then sort as integers; self-inverse.
fn flip(bits: i64) -> i64 {
    bits ^ ((bits >> 63) as u64 >> 1) as i64
}

fn flipped(key: i64, order: Order) -> i64 {
    match order {
        Order::Ascending => key,
        Order::Descending => !key,
    }
}

/// Map from values to buckets: the rank in a subsample, interpolated between the cells of a uniform table,
/// non-decreasing.
struct Dealer {
    low: f64,
    cells_per_unit: f64,
    /// Rank at the lower end of every cell, in buckets.
    ranks: Vec<f64>,
    buckets: usize,
}

/// Values of a chunk, bucket by bucket.
struct Dealt {
    keys: Vec<i64>,
    /// Start of each bucket, and end of the last.
    starts: Vec<u32>,
}

impl Dealer {
    /// `None` if nearly all values are equal or missing.
    fn new(values: &[f64]) -> Option<Self> {
        let buckets = (values.len() / BUCKET).clamp(2, MAX_BUCKETS);
        let mut sample: Vec<f64> =
            values.iter().step_by(values.len() / (SAMPLED * buckets)).copied().filter(|v| v.is_finite()).collect();
        sample.sort_unstable_by(f64::total_cmp);
        let (low, high) = (*sample.first()?, *sample.last()?);
        let cells_per_unit = CELLS as f64 / (high - low);
        if !(high > low && cells_per_unit.is_finite() && cells_per_unit > 0.0) {
            return None;
        }
        let rank = |cell: usize| {
            let below = sample.partition_point(|v| (*v - low) * cells_per_unit < cell as f64);
            below as f64 / sample.len() as f64 * buckets as f64
        };
        Some(Self { low, cells_per_unit, ranks: (0..=CELLS).map(rank).collect(), buckets })
    }

    fn bucket(&self, value: f64) -> usize {
        // Conversion to integers saturates, so values beyond the subsample fall into the first or last cell.
        let position = (value - self.low) * self.cells_per_unit;
        let cell = (position as usize).min(CELLS - 1);
        let (below, above) = (self.ranks[cell], self.ranks[cell + 1]);
        let along = (position - cell as f64).clamp(0.0, 1.0);
        // Rounding must not raise a value above the start of the next cell.
        ((below + along * (above - below)).min(above) as usize).min(self.buckets - 1)
    }

    /// Returns the values of a chunk by bucket, without missing ones.
    fn deal(&self, chunk: &[f64], order: Order) -> Dealt {
        let missing = self.buckets;
        let places: Vec<u16> = chunk
            .iter()
            .map(|value| match (value.is_nan(), order) {
                (true, _) => missing as u16,
                (false, Order::Ascending) => self.bucket(*value) as u16,
                (false, Order::Descending) => (self.buckets - 1 - self.bucket(*value)) as u16,
            })
            .collect();
        let mut starts = vec![0_u32; self.buckets + 2];
        places.iter().for_each(|place| starts[*place as usize + 1] += 1);
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut keys = vec![0; chunk.len()];
        let mut next = starts.clone();
        for (value, place) in chunk.iter().zip(places) {
            let next = &mut next[place as usize];
            keys[*next as usize] = key(*value, order);
            *next += 1;
        }
        starts.truncate(self.buckets + 1);
        Dealt { keys, starts }
    }

    fn sorted(&self, values: &[f64], origin: f64, order: Order) -> Vec<f64> {
        let chunks: Vec<&[f64]> = values.chunks(CHUNK).collect();
        let dealt: Vec<Dealt> = blocks::map(0..chunks.len(), |index| self.deal(chunks[index], order));
        let size = |bucket: usize| {
            dealt.iter().map(|dealt| (dealt.starts[bucket + 1] - dealt.starts[bucket]) as usize).sum::<usize>()
        };
        let sizes: Vec<usize> = (0..self.buckets).map(size).collect();
        let mut sorted = vec![0.0; sizes.iter().sum()];
        let mut rest = sorted.as_mut_slice();
        let mut outputs = Vec::with_capacity(self.buckets);
        for size in sizes {
            let (output, others) = rest.split_at_mut(size);
            outputs.push(output);
            rest = others;
        }
        blocks::for_each_with(outputs.into_iter().enumerate(), Vec::new, |keys: &mut Vec<i64>, (bucket, output)| {
            keys.clear();
            for dealt in &dealt {
                keys.extend(&dealt.keys[dealt.starts[bucket] as usize..dealt.starts[bucket + 1] as usize]);
            }
            keys.sort_unstable();
            output.iter_mut().zip(keys.iter()).for_each(|(out, key)| *out = value(*key, order) - origin);
        });
        sorted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    /// Returns samples that are smooth, peaked, tied, in two narrow clusters, of huge range, or partly infinite.
    fn samples() -> Vec<Vec<f64>> {
        let normal = random::standard_normal(&mut random::stream(9, "sorting", 0), 3 * LARGE + 77);
        let of = |f: &dyn Fn(usize, f64) -> f64| normal.iter().enumerate().map(|(i, z)| f(i, *z)).collect::<Vec<f64>>();
        vec![
            of(&|_, z| z),
            of(&|i, z| if i % 10_007 == 0 { 1e6 * z } else { z }),
            of(&|_, z| (4.0 * z).round()),
            of(&|i, z| if i % 2 == 0 { 1e-9 * z } else { 1.0 + 1e-9 * z }),
            of(&|_, z| (200.0 * z).exp() * z),
            of(&|i, z| [z, f64::INFINITY, f64::NEG_INFINITY, -0.0, 0.0, f64::NAN][i % 6]),
            of(&|_, _| 0.25),
            of(&|i, z| if i % 3 == 0 { z } else { f64::NAN }),
            of(&|i, _| if i == 5 { 1.0 } else { f64::NAN }),
        ]
    }

    #[test]
    fn bucket_sort_equals_plain_sort() {
        for (number, sample) in samples().into_iter().enumerate() {
            let mut wanted: Vec<f64> = sample.iter().copied().filter(|v| !v.is_nan()).collect();
            wanted.sort_by(f64::total_cmp);
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert!(bits(&sorted(&sample, 0.0, Order::Ascending)) == bits(&wanted), "sample {number}, ascending");
            wanted.reverse();
            assert!(bits(&sorted(&sample, 0.0, Order::Descending)) == bits(&wanted), "sample {number}, descending");
        }
    }

    #[test]
    fn the_origin_is_taken_off_after_sorting() {
        let sample = random::standard_normal(&mut random::stream(9, "sorting", 1), 2 * LARGE);
        let (plain, shifted) = (sorted(&sample, 0.0, Order::Ascending), sorted(&sample, 0.3, Order::Ascending));
        assert!(plain.iter().zip(&shifted).all(|(a, b)| a - 0.3 == *b));
        assert_eq!(sorted(&[2.0, f64::NAN, 1.0], 1.0, Order::Descending), [1.0, 0.0]);
    }
}
