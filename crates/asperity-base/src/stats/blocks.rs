//! Sums over large samples by fixed blocks, distributed over threads and added in order.
//!
//! The blocks depend on the sample only, so a sum does not depend on the number of threads; summation by blocks also
//! reduces rounding errors.

/// Values in a block.
#[doc(hidden)]
pub const BLOCK: usize = 4096;
/// Sample size above which blocks are distributed over threads.
#[doc(hidden)]
pub const SHARED_FROM: usize = 1 << 16;
/// Number of parallel partial sums, for vectorisation.
#[doc(hidden)]
pub const LANES: usize = 8;

/// Returns the results of `work` for every block of `values`, in order.
#[doc(hidden)]
pub fn map<R: Send>(values: &[f64], work: impl Fn(&[f64]) -> R + Sync) -> Vec<R> {
    let indices = 0..values.len().div_ceil(BLOCK);
    let block = |index: usize| work(&values[index * BLOCK..values.len().min((index + 1) * BLOCK)]);
    if values.len() < SHARED_FROM { indices.map(block).collect() } else { crate::blocks::map(indices, block) }
}

/// Returns the sums of `terms` over all values; `terms` handles missing values (NaN).
#[doc(hidden)]
pub fn sums<const N: usize>(values: &[f64], terms: impl Fn(f64) -> [f64; N] + Sync) -> [f64; N] {
    let blocks = map(values, |block| {
        let mut lanes = [[0.0; LANES]; N];
        let mut take = |lane: usize, value: f64| {
            lanes.iter_mut().zip(terms(value)).for_each(|(sums, term)| sums[lane] += term);
        };
        let (chunks, rest) = block.as_chunks::<LANES>();
        chunks.iter().for_each(|chunk| chunk.iter().enumerate().for_each(|(lane, value)| take(lane, *value)));
        rest.iter().for_each(|value| take(0, *value));
        lanes.map(|lanes| lanes.iter().sum::<f64>())
    });
    let mut total = [0.0; N];
    for block in blocks {
        total.iter_mut().zip(block).for_each(|(total, sum)| *total += sum);
    }
    total
}

/// Returns the sum and the number of values without NaN.
#[doc(hidden)]
pub fn sum_present(values: &[f64]) -> (f64, f64) {
    let [sum, count] = sums(values, |value| if value.is_nan() { [0.0, 0.0] } else { [value, 1.0] });
    (sum, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    #[test]
    fn sums_skip_missing_values_and_do_not_depend_on_the_threads() {
        let mut values = random::standard_normal(&mut random::stream(8, "blocks", 0), SHARED_FROM + 1234);
        values.iter_mut().step_by(11).for_each(|v| *v = f64::NAN);
        let plain: f64 = values.iter().filter(|v| !v.is_nan()).sum();
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let three = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let found = [&alone, &three].map(|pool| pool.install(|| sum_present(&values)));
        assert_eq!(found[0], found[1]);
        assert!((found[0].0 - plain).abs() < 1e-11);
        assert_eq!(found[0].1, values.iter().filter(|v| !v.is_nan()).count() as f64);
    }
}
